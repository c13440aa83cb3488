// A mesh of libigl, from a file: eigenfunctions and distances from its own arrays.
//
//     igl [MESH]

#include <catamaran/eigen.hpp>

#include <igl/icosahedron.h>
#include <igl/loop.h>
#include <igl/read_triangle_mesh.h>

#include <cstdlib>
#include <iostream>

// Row-major, so that nothing is copied.
using Vertices = Eigen::Matrix<double, Eigen::Dynamic, 3, Eigen::RowMajor>;
using Faces = Eigen::Matrix<int, Eigen::Dynamic, 3, Eigen::RowMajor>;

int main(int argc, char** argv) {
    try {
        Vertices v;
        Faces f;
        if (argc > 1) {
            if (!igl::read_triangle_mesh(argv[1], v, f)) return EXIT_FAILURE;
        } else {
            Eigen::MatrixXd points;
            Eigen::MatrixXi corners;
            igl::icosahedron(points, corners);
            igl::loop(Eigen::MatrixXd(points), Eigen::MatrixXi(corners), points, corners, 3);
            v = points;
            f = corners;
        }
        const auto borrowed = catamaran::borrow(v, f);
        const auto pairs = catamaran::eigs(borrowed.mesh(), 10);
        const auto functions = catamaran::map(pairs);
        const auto distances = catamaran::heat_method(borrowed.mesh()).distances({0});
        std::cout << functions.rows() << " x " << functions.cols()
                  << " eigenfunctions, the last of " << pairs.values.back() << "; distances to "
                  << distances.back() << '\n';
        return borrowed.shares_vertices() && borrowed.shares_faces() ? EXIT_SUCCESS : EXIT_FAILURE;
    } catch (const catamaran::error& error) {
        std::cerr << error.what() << '\n';
        return EXIT_FAILURE;
    }
}
