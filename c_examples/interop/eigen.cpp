// Matrices of Eigen, and meshes as libigl has them, without copies where layouts allow it.

#include <catamaran.hpp>

#include <Eigen/Dense>

#include <cmath>
#include <cstdlib>
#include <iostream>

// Views of what Eigen owns: its matrices are column-major unless they say otherwise.
template <class Matrix>
auto view(Matrix& a) {
    const auto rows = static_cast<std::size_t>(a.rows()), cols = static_cast<std::size_t>(a.cols());
    const auto leading = static_cast<std::size_t>(a.outerStride());
    return std::decay_t<Matrix>::IsRowMajor ? catamaran::row_major(a.data(), rows, cols, leading)
                                            : catamaran::col_major(a.data(), rows, cols, leading);
}

// The covariance of the columns of A, against Eigen's own.
bool products() {
    const Eigen::MatrixXd a = Eigen::MatrixXd::Random(500, 40);
    Eigen::MatrixXd c(40, 40);
    catamaran::ata(1.0, view(a), 0.0, view(c));
    const double error = (c - a.transpose() * a).cwiseAbs().maxCoeff();
    std::cout << "A^T A differs from Eigen's by " << error << '\n';
    return error < 1e-11;
}

// V (#V x 3) and F (#F x 3) as in libigl; rows must lie one after the other.
using Vertices = Eigen::Matrix<double, Eigen::Dynamic, 3, Eigen::RowMajor>;
using Faces = Eigen::Matrix<std::uint32_t, Eigen::Dynamic, 3, Eigen::RowMajor>;

bool meshes() {
    // As igl::read_triangle_mesh fills them: an octahedron.
    Eigen::MatrixXd v(6, 3);
    Eigen::MatrixXi f(8, 3);
    v << 1, 0, 0, 0, 1, 0, -1, 0, 0, 0, -1, 0, 0, 0, 1, 0, 0, -1;
    f << 0, 1, 4, 1, 2, 4, 2, 3, 4, 3, 0, 4, 1, 0, 5, 2, 1, 5, 3, 2, 5, 0, 3, 5;

    const Vertices rows = v;
    const Faces corners = f.cast<std::uint32_t>();
    const catamaran::mesh_view mesh(static_cast<std::size_t>(v.rows()), rows.data(),
                                    static_cast<std::size_t>(f.rows()), corners.data());
    const catamaran::decimation fine(mesh, 500);
    // And back, without a copy.
    const Eigen::Map<const Vertices> u(fine.vertices().front().data(), 500, 3);
    const double farthest = u.rowwise().norm().maxCoeff();
    std::cout << fine.faces().size() << " faces, vertices within " << farthest << " of the centre\n";
    return fine.faces().size() == 996 && std::abs(farthest - 1) < 0.1;
}

int main() {
    try {
        return products() && meshes() ? EXIT_SUCCESS : EXIT_FAILURE;
    } catch (const catamaran::error& error) {
        std::cerr << error.what() << '\n';
        return EXIT_FAILURE;
    }
}
