// Meshes of Eigen, CGAL and OpenMesh: what is shared, what is copied, and what is refused.

#include <catamaran/eigen.hpp>
#ifdef WITH_CGAL
#include <catamaran/cgal.hpp>

#include <CGAL/Exact_predicates_inexact_constructions_kernel.h>
#endif
#ifdef WITH_OPENMESH
#include <catamaran/openmesh.hpp>

#include <OpenMesh/Core/Mesh/DefaultTriMesh.hh>
#endif

#include "check.hpp"

namespace {

const catamaran::point_list corners{{{0, 0, 0}}, {{1, 0, 0}}, {{1, 1, 0}}, {{0, 1, 0}}};
const catamaran::triangle_list halves{{{0, 1, 2}}, {{0, 2, 3}}};
// Two faces on one side of the edge from 0 to 1.
const catamaran::triangle_list overlapping{{{0, 1, 2}}, {{0, 1, 3}}};
const catamaran::triangle_list outside{{{0, 1, 4}}};

bool same(const catamaran::mesh_view& mesh) {
    const std::size_t vertices = corners.size(), faces = halves.size();
    return mesh.n_vertices == vertices && mesh.n_faces == faces &&
           std::equal(mesh.vertices, mesh.vertices + 3 * vertices, corners[0].data()) &&
           std::equal(mesh.faces, mesh.faces + 3 * faces, halves[0].data());
}

void eigen() {
    const auto v = catamaran::map(corners);
    const auto f = catamaran::map(halves);
    auto shared = catamaran::borrow(v, f);
    const auto moved = std::move(shared);
    CHECK(same(moved.mesh()) && moved.mesh().vertices == corners[0].data());
    CHECK(moved.shares_vertices() && moved.shares_faces());
    const Eigen::MatrixXf by_columns = v.cast<float>();
    Eigen::Matrix<std::int64_t, Eigen::Dynamic, Eigen::Dynamic> wide = f.cast<std::int64_t>();
    auto copies = catamaran::borrow(by_columns, wide);
    const auto kept = std::move(copies);
    CHECK(same(kept.mesh()) && !kept.shares_vertices() && !kept.shares_faces());
    wide(1, 2) = -1;
    CHECK(status_of([&] { catamaran::borrow(v, wide); }) == CATA_ERR_ARGUMENT);
    CHECK(status_of([&] { catamaran::borrow(by_columns.leftCols(2), f); }) == CATA_ERR_SHAPE);
    Eigen::MatrixXd fractions = f.cast<double>();
    const auto whole = catamaran::borrow(v, fractions);
    CHECK(same(whole.mesh()));
    fractions(0, 1) = 1.5;
    CHECK(status_of([&] { catamaran::borrow(v, fractions); }) == CATA_ERR_ARGUMENT);
    CHECK(same(catamaran::mesh_view(corners, halves)));

    Eigen::MatrixXd a(3, 4);
    a << 1, 2, 3, 4, 5, 6, 7, 8, 9, 10, 11, 12;
    auto block = a.block(1, 1, 2, 2);
    const auto view = catamaran::view(block);
    CHECK(view.rows == 2 && view.leading == 3 && view(1, 0) == 10);
    auto row = a.row(0);
    CHECK(catamaran::view(row)(0, 3) == 4);
    Eigen::Map<Eigen::MatrixXd, 0, Eigen::Stride<Eigen::Dynamic, Eigen::Dynamic>> strided(
        a.data(), 1, 2, Eigen::Stride<Eigen::Dynamic, Eigen::Dynamic>(6, 2));
    CHECK(status_of([&] { catamaran::view(strided); }) == CATA_ERR_ARGUMENT);

    catamaran::wide_sparse<Eigen::ColMajor> sparse(2, 2);
    sparse.insert(0, 0) = 2;
    CHECK(status_of([&] { catamaran::symmetric_view(sparse); }) == CATA_ERR_ARGUMENT);
    sparse.makeCompressed();
    CHECK(catamaran::symmetric_view(sparse).entries == sparse.valuePtr());
    const auto copy = catamaran::copied(sparse);
    CHECK((copy.row_starts == std::vector<std::size_t>{0, 1, 1}) && copy.entries[0] == 2);

    // A matrix as Eigen has it by default, with indices of int: functions take its copy.
    Eigen::SparseMatrix<double> narrow(3, 3);
    const std::vector<Eigen::Triplet<double>> entries{{0, 0, 2.}, {0, 1, -1.}, {1, 0, -1.},
                                                      {1, 1, 2.}, {1, 2, -1.}, {2, 1, -1.},
                                                      {2, 2, 2.}};
    narrow.setFromTriplets(entries.begin(), entries.end());
    const auto path = catamaran::copied(narrow);
    const Eigen::Vector3d b(4, 0, 0);
    const auto x = catamaran::cholesky(path).solve(catamaran::view(b));
    CHECK(std::abs(x[0] - 3) + std::abs(x[1] - 2) + std::abs(x[2] - 1) < 1e-14);
    CHECK(std::abs(catamaran::eigs(path, 1).values[0] - 2 + std::sqrt(2.0)) < 1e-12);
    const Eigen::SparseMatrix<double> lower = narrow.triangularView<Eigen::Lower>();
    const auto half = catamaran::copied(lower);
    catamaran::cholesky_options how;
    how.triangle = catamaran::uplo::lower;
    CHECK(catamaran::cholesky(half, how).solve(catamaran::view(b)) == x);
    CHECK(status_of([&] { catamaran::cholesky{half}; }) != CATA_OK);
}

#ifdef WITH_CGAL
void cgal() {
    using Point = CGAL::Exact_predicates_inexact_constructions_kernel::Point_3;
    auto mesh = catamaran::surface_mesh<Point>({corners, halves});
    const auto borrowed = catamaran::borrow(mesh);
    CHECK(borrowed.shares_vertices() && borrowed.mesh().n_faces == 2);
    CHECK(catamaran::eigs(borrowed.mesh(), 2).values ==
          catamaran::eigs({corners, halves}, 2).values);
    for (const auto& faces : {overlapping, outside}) {
        CHECK(status_of([&] { catamaran::surface_mesh<Point>({corners, faces}); }) ==
              CATA_ERR_MESH);
    }
    mesh.remove_face(*mesh.faces().begin());
    CHECK(status_of([&] { catamaran::borrow(mesh); }) == CATA_ERR_ARGUMENT);
    CGAL::Surface_mesh<Point> square;
    std::vector<CGAL::SM_Vertex_index> around;
    for (const auto& at : corners) around.push_back(square.add_vertex({at[0], at[1], at[2]}));
    square.add_face(around);
    CHECK(status_of([&] { catamaran::borrow(square); }) == CATA_ERR_MESH);
}
#endif

#ifdef WITH_OPENMESH
void open_mesh() {
    auto mesh = catamaran::open_mesh<OpenMesh::TriMesh>({corners, halves});
    const auto borrowed = catamaran::borrow(mesh);
    CHECK(borrowed.shares_vertices() && borrowed.mesh().n_faces == 2);
    CHECK(catamaran::eigs(borrowed.mesh(), 2).values ==
          catamaran::eigs({corners, halves}, 2).values);
    using Floats = OpenMesh::TriMesh_ArrayKernelT<>;
    const auto floats = catamaran::open_mesh<Floats>({corners, halves});
    CHECK(!catamaran::borrow(floats).shares_vertices());
    CHECK(status_of([] { catamaran::open_mesh<Floats>({corners, outside}); }) == CATA_ERR_MESH);
    mesh.request_vertex_status();
    mesh.request_edge_status();
    mesh.request_face_status();
    mesh.delete_face(OpenMesh::FaceHandle(0));
    CHECK(status_of([&] { catamaran::borrow(mesh); }) == CATA_ERR_ARGUMENT);
}
#endif

}  // namespace

int main() {
    eigen();
#ifdef WITH_CGAL
    cgal();
#endif
#ifdef WITH_OPENMESH
    open_mesh();
#endif
    return report("cpp_borrowed");
}
