// Meshes with fewer vertices.

#ifndef CATAMARAN_DECIMATION_HPP
#define CATAMARAN_DECIMATION_HPP

#include "eigs.hpp"

#include <memory>

namespace catamaran {

/// How a mesh is decimated: the fields of cata_decimation_params.
struct decimation_options {
    /// Threads, at most; 0: as many as the process may use (catamaran.h, Threads).
    std::size_t threads = 0;
    /// The thesis literally, for comparison.
    bool thesis = false;
    /// Passes that move samples to the centroids of their cells.
    std::int32_t lloyd = 0;
    /// Passes that flip edges and move vertices of the result; 0: 12, or CATA_NO_PASSES.
    std::int32_t relaxation = 0;
    /// The vertex that the first sample is; none: the lowest that a face has.
    std::optional<std::uint32_t> first;
    /// Whether handles too narrow for the triangles of the result are cut, and their ends closed.
    bool cut_narrow_handles = false;
    /// Whether edges of the input stay whole.
    bool keep_edges = false;
    /// Vertices that stay, each once: the first of the result, in this order; edges between them
    /// stay, unless they are longer than those of the result (decimation::locked_edges).
    std::vector<std::uint32_t> locked;
    /// Whether areas are made as equal as possible, at the cost of the shapes of triangles.
    bool uniform = false;
    /// Vertices of the result per area, relative to elsewhere: a positive number for each vertex of
    /// the input; none: the same everywhere.
    std::vector<double> density;
    /// Up to how many times as many vertices per area where the surface bends, from 1.
    double curvature = 1;
    /// Progress callback, as options::progress.
    std::function<bool(double)> progress;
};

/// Edges between locked vertices: cata_decimation_locked_edges.
struct locked_edge_counts {
    /// Those of the input.
    std::size_t edges = 0;
    /// Those which the result does not have.
    std::size_t lost = 0;
};

/// Where vertices of a decimated mesh lie on the input, and those of the input in their cells.
struct decimation_places {
    /// For each vertex of the input the nearest one of the result along edges; UINT32_MAX where no
    /// face has it.
    std::vector<std::uint32_t> cells;
    /// How far that is.
    std::vector<float> distances;
    /// For each vertex of the result a face of the input.
    std::vector<std::uint32_t> faces;
    /// Its barycentric coordinates there.
    point_list weights;
};

/// Farthest points.
struct sampling {
    /// Vertices, in the order in which they were taken.
    std::vector<std::uint32_t> samples;
    /// For each vertex the number of the sample nearest to it; UINT32_MAX where no face has it.
    std::vector<std::uint32_t> nearest;
    /// Distance from that sample, in the unit of the mesh.
    std::vector<float> distances;
};

namespace detail {

inline cata_decimation_params params_of(const decimation_options& how) {
    cata_decimation_params params;
    check(cata_decimation_params_init(&params, sizeof params));
    params.threads = how.threads;
    params.method = how.thesis ? CATA_DECIMATION_THESIS : CATA_DECIMATION_UNIFORM;
    params.lloyd = how.lloyd;
    params.relaxation = how.relaxation;
    params.has_first = how.first ? 1 : 0;
    params.first = how.first.value_or(0);
    params.cut_narrow_handles = how.cut_narrow_handles ? 1 : 0;
    params.keep_edges = how.keep_edges ? 1 : 0;
    params.locked = how.locked.empty() ? nullptr : how.locked.data();
    params.n_locked = how.locked.size();
    params.uniform = how.uniform ? 1 : 0;
    params.density = how.density.empty() ? nullptr : how.density.data();
    params.n_density = how.density.size();
    params.curvature = how.curvature;
    return params;
}

}  // namespace detail

/// A mesh of exactly n vertices like another one, and how it lies on that: cata_decimation_new.
class decimation {
public:
    /// Decimates a mesh.
    decimation(const mesh_view& mesh, std::size_t n, const decimation_options& how = {})
        : decimation(mesh, how, cata_decimation_new, n) {}

    /// The decimation to the fewest vertices that a search finds for which no point of either
    /// surface is farther from the other one than `error`: cata_decimation_new_within.
    static decimation within(const mesh_view& mesh, double error,
                             const decimation_options& how = {}) {
        return decimation(mesh, how, cata_decimation_new_within, error);
    }

    /// An upper bound of the distance of any point of either surface from the other one:
    /// cata_decimation_bound.
    double bound() const {
        double found = 0;
        detail::check(cata_decimation_bound(handle_.get(), &found));
        return found;
    }

    /// Edges between locked vertices.
    locked_edge_counts locked_edges() const {
        locked_edge_counts found;
        detail::check(cata_decimation_locked_edges(handle_.get(), &found.edges, &found.lost));
        return found;
    }

    /// Vertices of the result.
    const point_list& vertices() const noexcept { return vertices_; }
    /// Faces of the result.
    const triangle_list& faces() const noexcept { return faces_; }
    /// The result, valid as long as this.
    mesh_view mesh() const& { return {vertices_, faces_}; }
    mesh_view mesh() const&& = delete;

    /// Whether the input had to be repaired.
    bool repaired() const noexcept { return repaired_; }

    /// How the two meshes lie on each other.
    decimation_places places() const {
        decimation_places found;
        found.cells.resize(before_vertices_);
        found.distances.resize(before_vertices_);
        found.faces.resize(vertices_.size());
        found.weights.resize(vertices_.size());
        detail::check(cata_decimation_places(handle_.get(), found.cells.data(),
                                             found.distances.data(), found.faces.data(),
                                             detail::first_of(found.weights)));
        return found;
    }

    /// Values of the input's vertices at those of the result, `width` for each.
    std::vector<double> carry(const std::vector<double>& values, std::size_t width = 1) const {
        detail::require(values.size() == before_vertices_ * width, CATA_ERR_SHAPE,
                        "values: must be `width` for each vertex of the input");
        std::vector<double> carried(vertices_.size() * width);
        detail::check(cata_decimation_carry(handle_.get(), width, values.data(), carried.data()));
        return carried;
    }

    /// Values of the result's vertices at those of the input, `width` for each.
    std::vector<double> prolong(const std::vector<double>& values, std::size_t width = 1) const {
        detail::require(values.size() == vertices_.size() * width, CATA_ERR_SHAPE,
                        "values: must be `width` for each vertex of the result");
        std::vector<double> found(before_vertices_ * width);
        detail::check(cata_decimation_prolong(handle_.get(), width, values.data(), found.data()));
        return found;
    }

    /// The k smallest eigenpairs of the Laplacian of the input, approximately, from those of the
    /// result: cata_decimation_eigs.
    eigenpairs eigs(std::size_t k, const eigs_options& how = {}) const {
        const std::size_t rows = before_vertices_;
        eigenpairs pairs = detail::room_for(rows, k);
        if (how.mass != mass_kind::consistent) {
            pairs.masses.resize(rows);
        }
        detail::eigs_call call(how);
        call.finish(cata_decimation_eigs(
            handle_.get(), k, pairs.values.data(), pairs.vectors.data(), rows ? rows : 1,
            pairs.residuals.data(), pairs.masses.empty() ? nullptr : pairs.masses.data(),
            call.params()));
        return pairs;
    }

    /// The texture of the result, from that of the input: six numbers a face.
    std::vector<std::array<double, 6>> carry_uv(
        const std::vector<std::array<double, 6>>& uv) const {
        detail::require(uv.size() == before_faces_, CATA_ERR_SHAPE,
                        "uv: must be one for each face of the input");
        std::vector<std::array<double, 6>> carried(faces_.size());
        detail::check(cata_decimation_carry_uv(handle_.get(), detail::first_of(uv),
                                               detail::first_of(carried)));
        return carried;
    }

private:
    struct free {
        void operator()(cata_decimation* handle) const noexcept { cata_decimation_free(handle); }
    };

    template <class Make, class Size>
    decimation(const mesh_view& mesh, const decimation_options& how, Make make, Size size)
        : before_vertices_(mesh.n_vertices), before_faces_(mesh.n_faces) {
        cata_decimation_params params = detail::params_of(how);
        detail::watcher watcher(how.progress);
        watcher.attach(params);
        cata_decimation* made = nullptr;
        watcher.finish(make(mesh.n_vertices, mesh.vertices, mesh.n_faces, mesh.faces, size, &params,
                            &made));
        handle_.reset(made);
        std::size_t n_vertices = 0, n_faces = 0;
        std::int32_t repaired = 0;
        detail::check(cata_decimation_size(made, &n_vertices, &n_faces, &repaired));
        repaired_ = repaired != 0;
        vertices_.resize(n_vertices);
        faces_.resize(n_faces);
        detail::check(
            cata_decimation_get(made, detail::first_of(vertices_), detail::first_of(faces_)));
    }

    std::size_t before_vertices_;
    std::size_t before_faces_;
    std::unique_ptr<cata_decimation, free> handle_;
    point_list vertices_;
    triangle_list faces_;
    bool repaired_ = false;
};

/// The n farthest points of a mesh: cata_decimation_farthest_points.
inline sampling farthest_points(const mesh_view& mesh, std::size_t n,
                                const decimation_options& how = {}) {
    // Checked before memory is allocated: n may exceed any memory.
    detail::require(n <= mesh.n_vertices, CATA_ERR_ARGUMENT, "n: more samples than vertices");
    cata_decimation_params params = detail::params_of(how);
    detail::watcher watcher(how.progress);
    watcher.attach(params);
    sampling found;
    found.samples.resize(n);
    found.nearest.resize(mesh.n_vertices);
    found.distances.resize(mesh.n_vertices);
    watcher.finish(cata_decimation_farthest_points(
        mesh.n_vertices, mesh.vertices, mesh.n_faces, mesh.faces, n, found.samples.data(),
        found.nearest.data(), found.distances.data(), &params));
    return found;
}

}  // namespace catamaran

#endif
