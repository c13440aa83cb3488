// Matrices of Eigen, and meshes as libigl has them, without copies where layouts allow it.

#include <catamaran/eigen.hpp>

#include <Eigen/Dense>

#include <cmath>
#include <cstdlib>
#include <iostream>

// The covariance of the columns of A, against Eigen's own.
bool products() {
    const Eigen::MatrixXd a = Eigen::MatrixXd::Random(500, 40);
    Eigen::MatrixXd c(40, 40);
    catamaran::ata(1.0, catamaran::view(a), 0.0, catamaran::view(c));
    const double error = (c - a.transpose() * a).cwiseAbs().maxCoeff();
    std::cout << "A^T A differs from Eigen's by " << error << '\n';
    return error < 1e-11;
}

// V (#V x 3) and F (#F x 3) as in libigl; those that are row-major are not copied.
using Vertices = Eigen::Matrix<double, Eigen::Dynamic, 3, Eigen::RowMajor>;
using Faces = Eigen::Matrix<int, Eigen::Dynamic, 3, Eigen::RowMajor>;

bool meshes() {
    // As igl::read_triangle_mesh fills them: an octahedron.
    Vertices v(6, 3);
    Faces f(8, 3);
    v << 1, 0, 0, 0, 1, 0, -1, 0, 0, 0, -1, 0, 0, 0, 1, 0, 0, -1;
    f << 0, 1, 4, 1, 2, 4, 2, 3, 4, 3, 0, 4, 1, 0, 5, 2, 1, 5, 3, 2, 5, 0, 3, 5;
    const auto borrowed = catamaran::borrow(v, f);
    const Eigen::MatrixXd by_columns = v;
    const auto copied = catamaran::borrow(by_columns, f);

    const catamaran::decimation fine(borrowed.mesh(), 500), same(copied.mesh(), 500);
    const double farthest = catamaran::map(fine.vertices()).rowwise().norm().maxCoeff();
    std::cout << fine.faces().size() << " faces, the farthest vertex at " << farthest << '\n';
    return borrowed.shares_vertices() && borrowed.shares_faces() && !copied.shares_vertices() &&
           fine.vertices() == same.vertices() && catamaran::map(fine.faces()).rows() == 996 &&
           std::abs(farthest - 1) < 0.1;
}

// The Laplacian of a mesh as a sparse matrix of Eigen, whose energies are the eigenvalues.
bool spectra() {
    const catamaran::point_list v{{{0, 0, 0}}, {{1, 0, 0}}, {{0, 1, 0}}, {{0, 0, 1}}};
    const catamaran::triangle_list f{{{0, 2, 1}}, {{0, 1, 3}}, {{0, 3, 2}}, {{1, 2, 3}}};
    const auto laplacian = catamaran::laplacian({v, f});
    const auto pairs = catamaran::eigs({v, f}, 3);
    const auto w = catamaran::map(laplacian.stiffness);
    const auto functions = catamaran::map(pairs);
    const Eigen::VectorXd energies =
        (functions.transpose() * (w * functions)).diagonal();
    const Eigen::Map<const Eigen::VectorXd> values(pairs.values.data(), 3);
    const double error = (energies - values).cwiseAbs().maxCoeff();
    std::cout << "energies differ from eigenvalues by " << error << '\n';
    const auto back = catamaran::copied(Eigen::SparseMatrix<double>(w));
    return error < 1e-9 && back.columns == laplacian.stiffness.columns &&
           back.entries == laplacian.stiffness.entries;
}

int main() {
    try {
        return products() && meshes() && spectra() ? EXIT_SUCCESS : EXIT_FAILURE;
    } catch (const catamaran::error& error) {
        std::cerr << error.what() << '\n';
        return EXIT_FAILURE;
    }
}
