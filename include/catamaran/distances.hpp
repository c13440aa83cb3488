// Distances and paths on meshes.

#ifndef CATAMARAN_DISTANCES_HPP
#define CATAMARAN_DISTANCES_HPP

#include "core.hpp"

#include <array>
#include <memory>

namespace catamaran {

/// The triangulation on which heat flows.
enum class heat_flow : std::int32_t {
    tufted = CATA_FLOW_TUFTED,
    intrinsic_delaunay = CATA_FLOW_INTRINSIC_DELAUNAY,
    cotangent = CATA_FLOW_COTANGENT,
};

/// How distances are computed: the fields of cata_distance_params.
struct distance_options {
    /// Of the heat method; 0: as many as the process may use (catamaran.h, Threads).
    std::size_t threads = 0;
    /// For the heat method: time of the flow, in units of the squared mean length of edges; 0: 1.
    double time = 0.0;
    /// Along edges: vertices farther than this are not reached; 0: all are.
    double cutoff = 0.0;
    /// Triangulation on which heat flows, of the heat method.
    heat_flow flow = heat_flow::tufted;
    /// Progress callback, as options::progress.
    std::function<bool(double)> progress;
};

namespace detail {

/// cata_distance_params for the length of a call.
class distance_call {
public:
    explicit distance_call(const distance_options& how) : watcher_(how.progress) {
        check(cata_distance_params_init(&params_, sizeof params_));
        params_.threads = how.threads;
        params_.time = how.time;
        params_.cutoff = how.cutoff;
        params_.flow = static_cast<std::int32_t>(how.flow);
        watcher_.attach(params_);
    }

    const cata_distance_params* params() const noexcept { return &params_; }

    void finish(cata_status status) { watcher_.finish(status); }

private:
    cata_distance_params params_{};
    watcher watcher_;
};

/// Refuses points whose faces and weights are not as many.
inline void check_weights(const std::vector<std::uint32_t>& faces, const point_list& weights) {
    if (faces.size() != weights.size()) {
        throw error(CATA_ERR_SHAPE, "weights: must be as many as faces");
    }
}

}  // namespace detail

/// A mesh, prepared for distances over its surface by the heat method: cata_heat. One owner; calls
/// may run at the same time.
class heat_method {
public:
    /// Prepares a mesh.
    explicit heat_method(const mesh_view& mesh, const distance_options& how = {})
        : n_vertices_(mesh.n_vertices) {
        detail::distance_call call(how);
        cata_heat* made = nullptr;
        call.finish(cata_heat_new(mesh.n_vertices, mesh.vertices, mesh.n_faces, mesh.faces,
                                  call.params(), &made));
        handle_.reset(made);
    }

    /// The distance of each vertex from the nearest source.
    std::vector<double> distances(const std::vector<std::uint32_t>& sources) const {
        std::vector<double> found(n_vertices_);
        detail::check(cata_heat_distances(handle_.get(), sources.size(), sources.data(),
                                          found.data()));
        return found;
    }

private:
    struct free {
        void operator()(cata_heat* handle) const noexcept { cata_heat_free(handle); }
    };

    std::size_t n_vertices_;
    std::unique_ptr<cata_heat, free> handle_;
};

/// Distances along edges.
struct edge_distances {
    /// Distance of each vertex from the nearest source; infinite where no path leads.
    std::vector<double> distances;
    /// The nearest source of each vertex; CATA_NO_VERTEX where no path leads.
    std::vector<std::uint32_t> nearest;
    /// The vertex before each on its path; CATA_NO_VERTEX at sources and where no path leads.
    std::vector<std::uint32_t> before;
};

/// The lengths of the shortest paths along edges: cata_distance_edges.
inline edge_distances distances_along_edges(const mesh_view& mesh,
                                            const std::vector<std::uint32_t>& sources,
                                            const distance_options& how = {}) {
    edge_distances found;
    found.distances.resize(mesh.n_vertices);
    found.nearest.resize(mesh.n_vertices);
    found.before.resize(mesh.n_vertices);
    detail::distance_call call(how);
    call.finish(cata_distance_edges(mesh.n_vertices, mesh.vertices, mesh.n_faces, mesh.faces,
                                    sources.size(), sources.data(), found.distances.data(),
                                    found.nearest.data(), found.before.data(), call.params()));
    return found;
}

/// The exact distance of each vertex from the nearest source over the surface:
/// cata_distance_exact.
inline std::vector<double> exact_distances(const mesh_view& mesh,
                                           const std::vector<std::uint32_t>& sources,
                                           const distance_options& how = {}) {
    std::vector<double> found(mesh.n_vertices);
    detail::distance_call call(how);
    call.finish(cata_distance_exact(mesh.n_vertices, mesh.vertices, mesh.n_faces, mesh.faces,
                                    sources.size(), sources.data(), nullptr, found.data(),
                                    call.params()));
    return found;
}

/// The same from points of faces, by their barycentric coordinates; the face CATA_IN_SPACE stands
/// for the vertex that is nearest to x, y, z.
inline std::vector<double> exact_distances(const mesh_view& mesh,
                                           const std::vector<std::uint32_t>& faces,
                                           const point_list& weights,
                                           const distance_options& how = {}) {
    std::vector<double> found(mesh.n_vertices);
    detail::check_weights(faces, weights);
    detail::distance_call call(how);
    call.finish(cata_distance_exact(mesh.n_vertices, mesh.vertices, mesh.n_faces, mesh.faces,
                                    faces.size(), faces.data(), detail::first_of(weights),
                                    found.data(), call.params()));
    return found;
}

/// A path from one vertex to another.
struct mesh_path {
    /// Vertices of the path along edges, both ends included, or those that an exact path was asked
    /// to lead through; empty: there is no path.
    std::vector<std::uint32_t> vertices;
    /// Points of the path, both ends included.
    point_list points;
    /// Length of the path, in the unit of the mesh; infinite without a path.
    double length = 0.0;
};

/// A path over faces.
struct exact_path : mesh_path {
    /// The face of each point.
    std::vector<std::uint32_t> faces;
    /// The barycentric coordinates of each point in its face.
    point_list weights;
};

namespace detail {

/// Copies a path of cata_distance_path_exact or cata_distance_trace, and frees it.
inline exact_path copied(cata_path* made) {
    const std::unique_ptr<cata_path, void (*)(cata_path*)> handle(made, cata_path_free);
    exact_path found;
    std::size_t n_vertices = 0, n_points = 0;
    check(cata_path_size(made, &n_vertices, &n_points, &found.length));
    found.vertices.resize(n_vertices);
    found.points.resize(n_points);
    found.faces.resize(n_points);
    found.weights.resize(n_points);
    check(cata_path_get(made, found.vertices.data(), first_of(found.points)));
    check(cata_path_places(made, found.faces.data(), first_of(found.weights)));
    return found;
}

}  // namespace detail

/// The shortest path over faces through vertices in their order, at least two:
/// cata_distance_path_exact.
inline exact_path shortest_path_over_faces(const mesh_view& mesh,
                                           const std::vector<std::uint32_t>& through,
                                           const distance_options& how = {}) {
    detail::distance_call call(how);
    cata_path* made = nullptr;
    call.finish(cata_distance_path_exact(mesh.n_vertices, mesh.vertices, mesh.n_faces, mesh.faces,
                                         through.size(), through.data(), nullptr, call.params(),
                                         &made));
    return detail::copied(made);
}

/// The same through points of faces, by their barycentric coordinates; the face CATA_IN_SPACE
/// stands for the vertex that is nearest to x, y, z.
inline exact_path shortest_path_over_faces(const mesh_view& mesh,
                                           const std::vector<std::uint32_t>& faces,
                                           const point_list& weights,
                                           const distance_options& how = {}) {
    detail::check_weights(faces, weights);
    detail::distance_call call(how);
    cata_path* made = nullptr;
    call.finish(cata_distance_path_exact(mesh.n_vertices, mesh.vertices, mesh.n_faces, mesh.faces,
                                         faces.size(), faces.data(), detail::first_of(weights),
                                         call.params(), &made));
    return detail::copied(made);
}

/// How the trace of a geodesic ends.
enum class trace_end : std::int32_t {
    complete = CATA_TRACE_COMPLETE,
    boundary = CATA_TRACE_BOUNDARY,
    non_manifold = CATA_TRACE_NON_MANIFOLD,
};

/// A geodesic from a point in a direction.
struct geodesic_trace : exact_path {
    /// How it ends.
    trace_end end = trace_end::complete;
    /// Its direction at the end, of length 1, in the plane of the face of the last point.
    std::array<double, 3> heading{};
};

namespace detail {

inline geodesic_trace trace(const mesh_view& mesh, std::uint32_t start, const double* weights,
                            const std::array<double, 3>& direction, double length,
                            const distance_options& how) {
    distance_call call(how);
    cata_path* made = nullptr;
    std::int32_t end = 0;
    geodesic_trace found;
    call.finish(cata_distance_trace(mesh.n_vertices, mesh.vertices, mesh.n_faces, mesh.faces,
                                    start, weights, direction.data(), length, call.params(), &made,
                                    &end, found.heading.data()));
    static_cast<exact_path&>(found) = copied(made);
    found.end = static_cast<trace_end>(end);
    return found;
}

}  // namespace detail

/// The geodesic that leaves a vertex in a direction, for a length: cata_distance_trace.
inline geodesic_trace trace_geodesic(const mesh_view& mesh, std::uint32_t vertex,
                                     const std::array<double, 3>& direction, double length,
                                     const distance_options& how = {}) {
    return detail::trace(mesh, vertex, nullptr, direction, length, how);
}

/// The same from a point of a face, by its barycentric coordinates.
inline geodesic_trace trace_geodesic(const mesh_view& mesh, std::uint32_t face,
                                     const std::array<double, 3>& weights,
                                     const std::array<double, 3>& direction, double length,
                                     const distance_options& how = {}) {
    return detail::trace(mesh, face, weights.data(), direction, length, how);
}

/// The shortest path along edges, or, where `straight`, the geodesic that it shortens to:
/// cata_distance_path.
inline mesh_path shortest_path(const mesh_view& mesh, std::uint32_t from, std::uint32_t to,
                               bool straight = false, const distance_options& how = {}) {
    detail::distance_call call(how);
    cata_path* made = nullptr;
    call.finish(cata_distance_path(mesh.n_vertices, mesh.vertices, mesh.n_faces, mesh.faces, from,
                                   to, straight ? 1 : 0, call.params(), &made));
    const std::unique_ptr<cata_path, void (*)(cata_path*)> handle(made, cata_path_free);
    mesh_path found;
    std::size_t n_vertices = 0, n_points = 0;
    detail::check(cata_path_size(made, &n_vertices, &n_points, &found.length));
    found.vertices.resize(n_vertices);
    found.points.resize(n_points);
    detail::check(cata_path_get(made, found.vertices.data(), detail::first_of(found.points)));
    return found;
}

}  // namespace catamaran

#endif
