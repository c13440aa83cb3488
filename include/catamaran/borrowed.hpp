// Meshes of other libraries, for the headers of each: eigen.hpp, cgal.hpp, openmesh.hpp.

#ifndef CATAMARAN_BORROWED_HPP
#define CATAMARAN_BORROWED_HPP

#include "../catamaran.hpp"

namespace catamaran {

/// A mesh of another library: its own arrays, which must outlive this, where they lie as the
/// library's do, and copies of the others.
class borrowed_mesh {
public:
    /// Creates a mesh of 3 count coordinates at `own`, or, where that is null, of `copied`; and of
    /// faces in the same way.
    borrowed_mesh(std::size_t count, const double* own, point_list copied,
                  std::size_t count_of_faces, const std::uint32_t* own_faces,
                  triangle_list copied_faces)
        : copied_(std::move(copied)),
          copied_faces_(std::move(copied_faces)),
          view_(own ? count : copied_.size(), own ? own : detail::first_of(copied_),
                own_faces ? count_of_faces : copied_faces_.size(),
                own_faces ? own_faces : detail::first_of(copied_faces_)) {}

    /// Vectors that are moved keep their elements where they are, and views of them hold.
    borrowed_mesh(borrowed_mesh&&) = default;
    /// Moves a mesh, as the constructor does.
    borrowed_mesh& operator=(borrowed_mesh&&) = default;

    /// The mesh, valid as long as this, and as what it is borrowed from.
    mesh_view mesh() const& noexcept { return view_; }
    mesh_view mesh() const&& = delete;

    /// Whether the vertices are those of the other library.
    bool shares_vertices() const noexcept { return copied_.empty() && view_.n_vertices > 0; }
    /// Whether the faces are.
    bool shares_faces() const noexcept { return copied_faces_.empty() && view_.n_faces > 0; }

private:
    point_list copied_;
    triangle_list copied_faces_;
    mesh_view view_;
};

namespace detail {

/// Throws for a face that the mesh of another library can't have, or this library.
[[noreturn]] inline void refuse_face(std::size_t face,
                                     const char* why = "not of an orientable manifold") {
    throw error(CATA_ERR_MESH, "face " + std::to_string(face) + ": " + why);
}

}  // namespace detail

}  // namespace catamaran

#endif
