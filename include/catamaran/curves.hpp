// Curves on meshes.

#ifndef CATAMARAN_CURVES_HPP
#define CATAMARAN_CURVES_HPP

#include "core.hpp"

#include <memory>

namespace catamaran {

/// How a search for curves ended.
enum class curve_outcome : std::int32_t {
    closed = CATA_CURVE_CLOSED,
    open = CATA_CURVE_OPEN,
    blocked = CATA_CURVE_BLOCKED,
    close_blocked = CATA_CURVE_CLOSE_BLOCKED,
    disconnected = CATA_CURVE_DISCONNECTED,
};

/// How curves are found: the fields of cata_curve_params.
struct curve_options {
    /// Number of nearest samples among which the next one is chosen, with faithful; 0: 5.
    std::size_t candidates = 0;
    /// Number of the sample at which the curve starts, with faithful.
    std::size_t start = 0;
    /// Whether to use algorithm 6.1 of the thesis, from sample to sample; else the order comes
    /// first, then paths that do not meet.
    bool faithful = false;
    /// Open curves; else closed ones.
    bool open = false;
    /// One curve, even where there are gaps as between several.
    bool single = false;
    /// Vertices of the mesh alone; else points on edges are added where there is no other way.
    bool vertices_alone = false;
    /// Whether curves are shortened to geodesics between their samples.
    bool smooth = false;
    /// Whether outliers are dropped: one or two successive samples to which the curve makes a
    /// detour of more than three times the median distance between successive samples. Not with
    /// faithful.
    bool drop_outliers = false;
    /// Progress callback, as options::progress.
    std::function<bool(double)> progress;
};

/// A curve on a mesh.
struct curve {
    /// Numbers of samples, in its order.
    std::vector<std::uint32_t> order;
    /// Its vertices, the first one not repeated; those from the number of vertices of the mesh on
    /// were added.
    std::vector<std::uint32_t> path;
    /// Points of the curve: those of path, unless the curve is smooth.
    point_list points;
    /// For each point, a face of the mesh, as the solver was given it.
    std::vector<std::uint32_t> faces;
    /// The barycentric coordinates of each point in its face.
    point_list weights;
    /// Length of the curve, in the unit of the mesh.
    double length = 0.0;
};

/// What a solver finds.
struct found_curves {
    /// How the search ended.
    curve_outcome outcome = curve_outcome::closed;
    /// Curves that were found; some may be missing if the search failed.
    std::vector<curve> curves;
    /// Numbers of the samples that no curve passes, because their components of the mesh have fewer
    /// than three.
    std::vector<std::uint32_t> left_out;
    /// Numbers of the samples that were dropped as outliers.
    std::vector<std::uint32_t> outliers;
};

/// A place for a sample: on a face, by barycentric coordinates, or the vertex nearest to a point.
struct curve_site {
    /// A face; CATA_IN_SPACE: the place is a point in space.
    std::uint32_t face = CATA_IN_SPACE;
    /// Barycentric coordinates, or x, y, z.
    std::array<double, 3> weights{};
};

namespace detail {

/// cata_curve_params for the length of a call.
class curve_call {
public:
    explicit curve_call(const curve_options& how) : watcher_(how.progress) {
        check(cata_curve_params_init(&params_, sizeof params_));
        params_.candidates = how.candidates;
        params_.start = how.start;
        params_.faithful = how.faithful ? 1 : 0;
        params_.open = how.open ? 1 : 0;
        params_.single = how.single ? 1 : 0;
        params_.points = how.vertices_alone ? CATA_CURVE_VERTICES : CATA_CURVE_STEINER;
        params_.smooth = how.smooth ? 1 : 0;
        params_.drop_outliers = how.drop_outliers ? 1 : 0;
        watcher_.attach(params_);
    }

    const cata_curve_params* params() const noexcept { return &params_; }

    void finish(cata_status status) { watcher_.finish(status); }

private:
    cata_curve_params params_{};
    watcher watcher_;
};

}  // namespace detail

/// A mesh, prepared for the search for curves: cata_curve_solver. One owner, one thread at a time.
class curve_solver {
public:
    /// Prepares a mesh, of which a copy is kept.
    explicit curve_solver(const mesh_view& mesh) {
        cata_curve_solver* made = nullptr;
        detail::check(cata_curve_solver_new(mesh.n_vertices, mesh.vertices, mesh.n_faces, mesh.faces,
                                            &made));
        handle_.reset(made);
    }

    /// Prepares a mesh for samples that need not be vertices; samples() returns the vertices that
    /// stand for the sites.
    curve_solver(const mesh_view& mesh, const std::vector<curve_site>& sites)
        : samples_(sites.size()) {
        std::vector<std::uint32_t> faces;
        point_list weights;
        for (const curve_site& site : sites) {
            faces.push_back(site.face);
            weights.push_back(site.weights);
        }
        cata_curve_solver* made = nullptr;
        detail::check(cata_curve_solver_new_at(mesh.n_vertices, mesh.vertices, mesh.n_faces,
                                               mesh.faces, sites.size(), faces.data(),
                                               detail::first_of(weights), samples_.data(), &made));
        handle_.reset(made);
    }

    /// The vertices that stand for the sites.
    const std::vector<std::uint32_t>& samples() const noexcept { return samples_; }

    /// The curves that samples (vertices) without an order are of.
    found_curves find(const std::vector<std::uint32_t>& samples, const curve_options& how = {}) {
        detail::curve_call call(how);
        cata_curves* made = nullptr;
        call.finish(cata_curve_solver_find(handle_.get(), samples.size(), samples.data(),
                                           call.params(), &made));
        const std::unique_ptr<cata_curves, void (*)(cata_curves*)> handle(made, cata_curves_free);
        return copied(handle.get());
    }

private:
    struct free {
        void operator()(cata_curve_solver* handle) const noexcept {
            cata_curve_solver_free(handle);
        }
    };

    found_curves copied(const cata_curves* curves) const {
        found_curves found;
        std::int32_t outcome = 0;
        std::size_t count = 0, left_out = 0, outliers = 0;
        detail::check(cata_curves_outcome(curves, &outcome, &count, &left_out));
        found.outcome = static_cast<curve_outcome>(outcome);
        found.curves.resize(count);
        found.left_out.resize(left_out);
        detail::check(cata_curves_left_out(curves, found.left_out.data()));
        detail::check(cata_curves_outliers(curves, &outliers, nullptr));
        found.outliers.resize(outliers);
        detail::check(cata_curves_outliers(curves, nullptr, found.outliers.data()));
        for (std::size_t i = 0; i < count; ++i) {
            curve& one = found.curves[i];
            std::size_t samples = 0, vertices = 0, points = 0;
            detail::check(cata_curves_size(curves, i, &samples, &vertices, &points, &one.length));
            one.order.resize(samples);
            one.path.resize(vertices);
            one.points.resize(points);
            detail::check(cata_curves_get(curves, i, one.order.data(), one.path.data(),
                                          detail::first_of(one.points)));
            one.faces.resize(points);
            one.weights.resize(points);
            detail::check(cata_curves_places(curves, handle_.get(), i, one.faces.data(),
                                             detail::first_of(one.weights)));
        }
        return found;
    }

    std::unique_ptr<cata_curve_solver, free> handle_;
    std::vector<std::uint32_t> samples_;
};

}  // namespace catamaran

#endif
