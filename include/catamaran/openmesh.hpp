// Meshes of OpenMesh. Not part of catamaran.hpp: it needs OpenMesh.

#ifndef CATAMARAN_OPENMESH_HPP
#define CATAMARAN_OPENMESH_HPP

#include "borrowed.hpp"

#include <OpenMesh/Core/Mesh/TriMesh_ArrayKernelT.hh>

namespace catamaran {

/// A triangle mesh of OpenMesh without deleted elements, which must outlive the result. Its points
/// are not copied where they are of doubles (OpenMesh::TriMesh).
template <class Traits>
borrowed_mesh borrow(const OpenMesh::TriMesh_ArrayKernelT<Traits>& mesh) {
    using point = typename OpenMesh::TriMesh_ArrayKernelT<Traits>::Point;
    const double* own = nullptr;
    point_list copied;
    if constexpr (std::is_same<typename point::value_type, double>::value) {
        own = mesh.n_vertices() ? mesh.points()->data() : nullptr;
    } else {
        for (std::size_t v = 0; v < mesh.n_vertices(); ++v) {
            const point& p = mesh.points()[v];
            copied.push_back({{static_cast<double>(p[0]), static_cast<double>(p[1]),
                               static_cast<double>(p[2])}});
        }
    }
    triangle_list faces;
    faces.reserve(mesh.n_faces());
    for (std::size_t f = 0; f < mesh.n_faces(); ++f) {
        const OpenMesh::FaceHandle face(static_cast<int>(f));
        detail::require(!mesh.has_face_status() || !mesh.status(face).deleted(), CATA_ERR_ARGUMENT,
                        "mesh: call garbage_collection() before, it has deleted elements");
        auto halfedge = mesh.halfedge_handle(face);
        std::array<std::uint32_t, 3> corners{};
        for (std::uint32_t& corner : corners) {
            corner = static_cast<std::uint32_t>(mesh.to_vertex_handle(halfedge).idx());
            halfedge = mesh.next_halfedge_handle(halfedge);
        }
        faces.push_back(corners);
    }
    return {mesh.n_vertices(), own, std::move(copied), 0, nullptr, std::move(faces)};
}
template <class Traits>
void borrow(const OpenMesh::TriMesh_ArrayKernelT<Traits>&&) = delete;

/// A mesh of OpenMesh with the vertices and faces of another one, in their order. CATA_ERR_MESH for
/// a face that would make it no manifold.
template <class Mesh>
Mesh open_mesh(const mesh_view& mesh) {
    Mesh made;
    using number = typename Mesh::Point::value_type;
    for (std::size_t v = 0; v < mesh.n_vertices; ++v) {
        const double* at = mesh.vertices + 3 * v;
        made.add_vertex({static_cast<number>(at[0]), static_cast<number>(at[1]),
                         static_cast<number>(at[2])});
    }
    const auto vertex = [](std::uint32_t v) { return OpenMesh::VertexHandle(static_cast<int>(v)); };
    for (std::size_t f = 0; f < mesh.n_faces; ++f) {
        const std::uint32_t* at = mesh.faces + 3 * f;
        const bool within = at[0] < mesh.n_vertices && at[1] < mesh.n_vertices &&
                            at[2] < mesh.n_vertices;
        if (!within || !made.add_face(vertex(at[0]), vertex(at[1]), vertex(at[2])).is_valid()) {
            detail::refuse_face(f);
        }
    }
    return made;
}

}  // namespace catamaran

#endif
