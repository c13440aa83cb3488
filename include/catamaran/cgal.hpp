// Meshes of CGAL. Not part of catamaran.hpp: it needs CGAL.

#ifndef CATAMARAN_CGAL_HPP
#define CATAMARAN_CGAL_HPP

#include "borrowed.hpp"

#include <CGAL/Kernel_traits.h>
#include <CGAL/Surface_mesh.h>

namespace catamaran {

/// A triangle mesh of CGAL without removed elements, which must outlive the result. Its points are
/// not copied where coordinates are doubles (EPICK, Cartesian<double>, Simple_cartesian<double>).
template <class Point>
borrowed_mesh borrow(const CGAL::Surface_mesh<Point>& mesh) {
    detail::require(!mesh.has_garbage(), CATA_ERR_ARGUMENT,
                    "mesh: call collect_garbage() before, it has removed elements");
    using number = typename CGAL::Kernel_traits<Point>::Kernel::FT;
    const double* own = nullptr;
    point_list copied;
    if constexpr (std::is_same<number, double>::value && sizeof(Point) == 3 * sizeof(double)) {
        own = mesh.num_vertices() ? reinterpret_cast<const double*>(mesh.points().data()) : nullptr;
    } else {
        for (const auto vertex : mesh.vertices()) {
            const Point& p = mesh.point(vertex);
            copied.push_back({{CGAL::to_double(p.x()), CGAL::to_double(p.y()),
                               CGAL::to_double(p.z())}});
        }
    }
    triangle_list faces;
    faces.reserve(mesh.num_faces());
    for (const auto face : mesh.faces()) {
        const auto first = mesh.halfedge(face);
        const auto second = mesh.next(first), third = mesh.next(second);
        if (mesh.next(third) != first) {
            detail::refuse_face(face.idx(), "not a triangle");
        }
        const auto corner = [&](const auto& halfedge) {
            return static_cast<std::uint32_t>(mesh.target(halfedge).idx());
        };
        faces.push_back({{corner(first), corner(second), corner(third)}});
    }
    return {mesh.num_vertices(), own, std::move(copied), 0, nullptr, std::move(faces)};
}
template <class Point>
void borrow(const CGAL::Surface_mesh<Point>&&) = delete;

/// A mesh of CGAL with the vertices and faces of another one, in their order. CATA_ERR_MESH for a
/// face that would make it no manifold.
template <class Point>
CGAL::Surface_mesh<Point> surface_mesh(const mesh_view& mesh) {
    CGAL::Surface_mesh<Point> made;
    using vertex = typename CGAL::Surface_mesh<Point>::Vertex_index;
    for (std::size_t v = 0; v < mesh.n_vertices; ++v) {
        const double* at = mesh.vertices + 3 * v;
        made.add_vertex(Point(at[0], at[1], at[2]));
    }
    for (std::size_t f = 0; f < mesh.n_faces; ++f) {
        const std::uint32_t* at = mesh.faces + 3 * f;
        const bool within = at[0] < mesh.n_vertices && at[1] < mesh.n_vertices &&
                            at[2] < mesh.n_vertices;
        if (!within || made.add_face(vertex(at[0]), vertex(at[1]), vertex(at[2])) ==
                           CGAL::Surface_mesh<Point>::null_face()) {
            detail::refuse_face(f);
        }
    }
    return made;
}

}  // namespace catamaran

#endif
