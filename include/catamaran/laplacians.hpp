// Laplacians, gradients and divergences as sparse matrices.

#ifndef CATAMARAN_LAPLACIANS_HPP
#define CATAMARAN_LAPLACIANS_HPP

#include "eigs.hpp"

#include <memory>

namespace catamaran {

/// A sparse matrix by rows.
struct sparse_matrix {
    /// Number of rows.
    std::size_t rows = 0;
    /// Number of columns.
    std::size_t cols = 0;
    /// rows + 1 positions.
    std::vector<std::size_t> row_starts;
    /// Column of each entry, ascending within a row.
    std::vector<std::size_t> columns;
    /// The entries, row by row.
    std::vector<double> entries;

    /// The matrix, valid as long as this.
    sparse_view view() const& noexcept {
        return {rows, row_starts.data(), columns.data(), entries.data()};
    }
    sparse_view view() const&& = delete;

    /// The matrix, for functions that take a view.
    operator sparse_view() const& noexcept { return view(); }
    operator sparse_view() const&& = delete;
};

/// The matrices of W phi = lambda M phi.
struct laplacian_matrices {
    /// W: both triangles.
    sparse_matrix stiffness;
    /// M: its diagonal, or, of mass_kind::consistent, its entries at the places of those of W.
    std::vector<double> masses;
    /// The vertex of each row, ascending.
    std::vector<std::uint32_t> kept;
};

namespace detail {

inline laplacian_matrices copied(const cata_laplacian* laplacian) {
    laplacian_matrices found;
    sparse_matrix& w = found.stiffness;
    std::size_t entries = 0, masses = 0;
    check(cata_laplacian_size(laplacian, &w.rows, &entries, &masses));
    w.cols = w.rows;
    w.row_starts.resize(w.rows + 1);
    w.columns.resize(entries);
    w.entries.resize(entries);
    found.kept.resize(w.rows);
    found.masses.resize(masses);
    check(cata_laplacian_get(laplacian, found.kept.data(), w.row_starts.data(), w.columns.data(),
                             w.entries.data()));
    check(cata_laplacian_masses(laplacian, found.masses.data()));
    return found;
}

}  // namespace detail

/// The Laplacian of a triangle mesh; functions are zero at the vertices `held`: cata_laplacian_new.
inline laplacian_matrices laplacian(const mesh_view& mesh, const eigs_options& how = {},
                                    const std::vector<std::uint32_t>& held = {}) {
    detail::eigs_call call(how);
    cata_laplacian* made = nullptr;
    call.finish(cata_laplacian_new(mesh.n_vertices, mesh.vertices, mesh.n_faces, mesh.faces,
                                   held.size(), held.data(), call.params(), &made));
    const std::unique_ptr<cata_laplacian, void (*)(cata_laplacian*)> handle(made,
                                                                          cata_laplacian_free);
    return detail::copied(made);
}

/// The Laplacian of the surface that points are samples of, each triangulated with its `neighbours`
/// nearest ones; 0: 30.
inline laplacian_matrices cloud_laplacian(const point_list& points, std::size_t neighbours = 0,
                                          const eigs_options& how = {}) {
    detail::eigs_call call(how);
    cata_laplacian* made = nullptr;
    call.finish(cata_cloud_laplacian(points.size(), detail::first_of(points), neighbours,
                                     call.params(), &made));
    const std::unique_ptr<cata_laplacian, void (*)(cata_laplacian*)> handle(made,
                                                                          cata_laplacian_free);
    return detail::copied(made);
}

/// From values of vertices to gradients, x, y, z of each face: cata_laplacian_gradient.
inline sparse_matrix gradient(const mesh_view& mesh) {
    sparse_matrix found{3 * mesh.n_faces, mesh.n_vertices, {}, {}, {}};
    found.row_starts.resize(found.rows + 1);
    found.columns.resize(9 * mesh.n_faces);
    found.entries.resize(9 * mesh.n_faces);
    detail::check(cata_laplacian_gradient(mesh.n_vertices, mesh.vertices, mesh.n_faces, mesh.faces,
                                          found.row_starts.data(), found.columns.data(),
                                          found.entries.data()));
    return found;
}

/// From fields, x, y, z of each face, to integrated divergences: cata_laplacian_divergence.
inline sparse_matrix divergence(const mesh_view& mesh) {
    sparse_matrix found{mesh.n_vertices, 3 * mesh.n_faces, {}, {}, {}};
    found.row_starts.resize(found.rows + 1);
    found.columns.resize(9 * mesh.n_faces);
    found.entries.resize(9 * mesh.n_faces);
    detail::check(cata_laplacian_divergence(mesh.n_vertices, mesh.vertices, mesh.n_faces,
                                            mesh.faces, found.row_starts.data(),
                                            found.columns.data(), found.entries.data()));
    return found;
}

/// A third of the area of the faces at each vertex.
inline std::vector<double> vertex_areas(const mesh_view& mesh) {
    std::vector<double> areas(mesh.n_vertices);
    detail::check(cata_laplacian_areas(mesh.n_vertices, mesh.vertices, mesh.n_faces, mesh.faces,
                                       areas.data()));
    return areas;
}

}  // namespace catamaran

#endif
