// Topology, measures and comparison of meshes; meshes of lattices, and generated ones.

#ifndef CATAMARAN_SURFACES_HPP
#define CATAMARAN_SURFACES_HPP

#include "meshes.hpp"

namespace catamaran {

/// How meshes are compared, or made of a lattice: the fields of cata_mesh_params.
struct mesh_options {
    /// Threads, at most; 0: as many as the process may use (catamaran.h, Threads).
    std::size_t threads = 0;
    /// Progress callback, as options::progress.
    std::function<bool(double)> progress;
};

namespace detail {

/// cata_mesh_params for the length of a call.
class mesh_call {
public:
    explicit mesh_call(const mesh_options& how) : watcher_(how.progress) {
        check(cata_mesh_params_init(&params_, sizeof params_));
        params_.threads = how.threads;
        watcher_.attach(params_);
    }

    const cata_mesh_params* params() const noexcept { return &params_; }

    void finish(cata_status status) { watcher_.finish(status); }

private:
    cata_mesh_params params_{};
    watcher watcher_;
};

}  // namespace detail

/// The edges of a mesh.
struct mesh_edges {
    /// Ascending, the lower vertex first.
    edge_list ends;
    /// For each edge the number of its faces.
    std::vector<std::uint32_t> face_counts;
};

/// The edges of a mesh: cata_mesh_edges.
inline mesh_edges edges_of(const mesh_view& mesh) {
    std::size_t count = 0;
    detail::check(cata_mesh_edges(mesh.n_vertices, mesh.vertices, mesh.n_faces, mesh.faces, 0,
                                  nullptr, nullptr, &count));
    mesh_edges found{edge_list(count), std::vector<std::uint32_t>(count)};
    detail::check(cata_mesh_edges(mesh.n_vertices, mesh.vertices, mesh.n_faces, mesh.faces, count,
                                  detail::first_of(found.ends), found.face_counts.data(), &count));
    return found;
}

/// The connected components of a mesh.
struct mesh_components {
    /// The number of components.
    std::size_t count = 0;
    /// For each vertex its component; UINT32_MAX where no face has it.
    std::vector<std::uint32_t> of_vertices;
    /// For each face its component.
    std::vector<std::uint32_t> of_faces;
};

/// The connected components of a mesh: cata_mesh_components.
inline mesh_components components_of(const mesh_view& mesh) {
    mesh_components found{0, std::vector<std::uint32_t>(mesh.n_vertices),
                          std::vector<std::uint32_t>(mesh.n_faces)};
    detail::check(cata_mesh_components(mesh.n_vertices, mesh.vertices, mesh.n_faces, mesh.faces,
                                       found.of_vertices.data(), found.of_faces.data(),
                                       &found.count));
    return found;
}

/// The genus of a mesh.
struct mesh_genus {
    /// The number of handles; of cross-caps where the mesh is not orientable.
    std::size_t genus = 0;
    /// Whether all components are orientable.
    bool orientable = true;
};

/// The genus of a manifold: cata_mesh_genus.
inline mesh_genus genus_of(const mesh_view& mesh) {
    mesh_genus found;
    std::int32_t orientable = 0;
    detail::check(cata_mesh_genus(mesh.n_vertices, mesh.vertices, mesh.n_faces, mesh.faces,
                                  &found.genus, &orientable));
    found.orientable = orientable != 0;
    return found;
}

/// The vertices of each boundary loop, in order: cata_mesh_boundary_loops.
inline std::vector<std::vector<std::uint32_t>> boundary_loops(const mesh_view& mesh) {
    std::size_t total = 0, count = 0;
    detail::check(cata_mesh_boundary_loops(mesh.n_vertices, mesh.vertices, mesh.n_faces,
                                           mesh.faces, 0, nullptr, nullptr, &total, &count));
    std::vector<std::uint32_t> all(total);
    std::vector<std::size_t> lengths(total);
    detail::check(cata_mesh_boundary_loops(mesh.n_vertices, mesh.vertices, mesh.n_faces,
                                           mesh.faces, total, all.data(), lengths.data(), &total,
                                           &count));
    std::vector<std::vector<std::uint32_t>> found;
    auto first = all.begin();
    for (std::size_t i = 0; i < count; ++i) {
        const auto end = first + static_cast<std::ptrdiff_t>(lengths[i]);
        found.emplace_back(first, end);
        first = end;
    }
    return found;
}

/// Measures of a mesh.
struct mesh_measures {
    /// Area of all faces, in squared units of the mesh.
    double area = 0.0;
    /// Volume inside of a closed and oriented mesh; negative where faces are seen clockwise from
    /// outside, NaN for other meshes.
    double volume = 0.0;
    /// Area of each face.
    std::vector<double> face_areas;
    /// Quality of each face, from 0 (flat) to 1 (equilateral).
    std::vector<double> qualities;
    /// Normal of each face, of length 1; 0 for faces without area.
    point_list face_normals;
    /// The directions of the means of the normals of the faces at each vertex, by area: of length
    /// 1; 0 where the mean is 0.
    point_list vertex_normals;
};

/// The measures of a mesh: cata_mesh_measures.
inline mesh_measures measures_of(const mesh_view& mesh) {
    mesh_measures found;
    found.face_areas.resize(mesh.n_faces);
    found.qualities.resize(mesh.n_faces);
    found.face_normals.resize(mesh.n_faces);
    found.vertex_normals.resize(mesh.n_vertices);
    detail::check(cata_mesh_measures(mesh.n_vertices, mesh.vertices, mesh.n_faces, mesh.faces,
                                     &found.area, &found.volume, found.face_areas.data(),
                                     found.qualities.data(), detail::first_of(found.face_normals),
                                     detail::first_of(found.vertex_normals)));
    return found;
}

/// How uniform a mesh is.
struct mesh_quality {
    /// Mean area of the faces.
    double mean_area = 0.0;
    /// Standard deviation of the areas, divided by their mean.
    double area_variation = 0.0;
    /// Mean of mesh_measures::qualities.
    double mean_quality = 0.0;
    /// Standard deviation of the qualities.
    double quality_deviation = 0.0;
    /// Least of the qualities.
    double least_quality = 0.0;
    /// Mean number of edges at the vertices that have a face.
    double mean_valence = 0.0;
    /// The share of these vertices that have 6 edges, or 4 at the boundary.
    double regular_vertices = 0.0;
    /// The number of edges with more than two faces.
    std::size_t non_manifold_edges = 0;
};

/// How uniform a mesh is: cata_mesh_quality.
inline mesh_quality quality_of(const mesh_view& mesh) {
    mesh_quality found;
    detail::check(cata_mesh_quality(mesh.n_vertices, mesh.vertices, mesh.n_faces, mesh.faces,
                                    &found.mean_area, &found.area_variation, &found.mean_quality,
                                    &found.quality_deviation, &found.least_quality,
                                    &found.mean_valence, &found.regular_vertices,
                                    &found.non_manifold_edges));
    return found;
}

/// Distances from one surface to another one.
struct mesh_distance {
    /// Largest distance of the vertices and of points spread by area.
    double largest = 0.0;
    /// Mean distance of the points spread by area.
    double mean = 0.0;
    /// Mean angle between the normals at these points, in degrees.
    double angle = 0.0;
};

/// Distances between two meshes.
struct mesh_comparison {
    /// From the first mesh to the second one.
    mesh_distance out;
    /// From the second mesh to the first one.
    mesh_distance back;
    /// The largest distance of a vertex of either mesh from the other surface.
    double hausdorff = 0.0;
    /// The mean squares of the distances of vertices from the other surface, in both directions.
    double chamfer = 0.0;
};

/// The distances between two meshes: cata_mesh_compare.
inline mesh_comparison compare(const mesh_view& mesh, const mesh_view& other,
                               const mesh_options& how = {}) {
    double out[3] = {}, back[3] = {};
    mesh_comparison found;
    detail::mesh_call call(how);
    call.finish(cata_mesh_compare(mesh.n_vertices, mesh.vertices, mesh.n_faces, mesh.faces,
                                  other.n_vertices, other.vertices, other.n_faces, other.faces, out,
                                  back, &found.hausdorff, &found.chamfer, call.params()));
    found.out = {out[0], out[1], out[2]};
    found.back = {back[0], back[1], back[2]};
    return found;
}

/// Points in rows, columns and layers; x first, then y, then z.
struct lattice {
    /// The number of points along x, y and z.
    std::array<std::size_t, 3> counts{};
    /// The first point.
    std::array<double, 3> origin{};
    /// Distance from one point to the next along x, y and z.
    std::array<double, 3> step{{1.0, 1.0, 1.0}};
    /// Whether surfaces are cut at the outermost points; else they are closed half a step outside.
    bool open = false;
};

namespace detail {

/// Requires as many values as points.
inline void require_points(const lattice& points, std::size_t values) {
    const auto [x, y, z] = points.counts;
    const bool fits = x == 0 || y == 0 || z == 0 ? values == 0
                                                 : values % x == 0 && values / x % y == 0 &&
                                                       values / x / y == z;
    require(fits, CATA_ERR_SHAPE, "values: must be one for each point of the lattice");
}

}  // namespace detail

/// The surface of the region where values exceed `level`: cata_mesh_isosurface.
inline mesh_file isosurface(const lattice& points, const std::vector<float>& values, float level,
                            const mesh_options& how = {}) {
    detail::require_points(points, values.size());
    detail::mesh_call call(how);
    cata_mesh_file* made = nullptr;
    call.finish(cata_mesh_isosurface(points.counts.data(), points.origin.data(),
                                     points.step.data(), values.data(), level, points.open ? 1 : 0,
                                     call.params(), &made));
    return mesh_file(made);
}

/// The surface of the points with a label: cata_mesh_label_surface.
inline mesh_file label_surface(const lattice& points, const std::vector<std::uint16_t>& labels,
                               std::uint16_t label, const mesh_options& how = {}) {
    detail::require_points(points, labels.size());
    detail::mesh_call call(how);
    cata_mesh_file* made = nullptr;
    call.finish(cata_mesh_label_surface(points.counts.data(), points.origin.data(),
                                        points.step.data(), labels.data(), label,
                                        points.open ? 1 : 0, call.params(), &made));
    return mesh_file(made);
}

/// A generated shape by its name, such as "torus", with counts and sizes: cata_mesh_shape.
inline mesh_file shape(const std::string& name, const std::vector<std::size_t>& counts,
                       const std::vector<double>& sizes = {}) {
    cata_mesh_file* made = nullptr;
    detail::check(cata_mesh_shape(name.c_str(), counts.size(), counts.data(), sizes.size(),
                                  sizes.data(), &made));
    return mesh_file(made);
}

}  // namespace catamaran

#endif
