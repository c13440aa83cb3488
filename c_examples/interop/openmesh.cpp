// A mesh of OpenMesh: distances along its surface from its own points, and a coarser mesh.

#include <catamaran/openmesh.hpp>

#include <OpenMesh/Core/Mesh/DefaultTriMesh.hh>

#include <cmath>
#include <cstdlib>
#include <iostream>

using Mesh = OpenMesh::TriMesh;

// A square of side 1, with n x n vertices.
Mesh square(int n) {
    Mesh mesh;
    const auto vertex = [n](int i, int j) { return OpenMesh::VertexHandle(i * n + j); };
    for (int i = 0; i < n; ++i) {
        for (int j = 0; j < n; ++j) {
            mesh.add_vertex({i / (n - 1.0), j / (n - 1.0), 0.0});
        }
    }
    for (int i = 0; i + 1 < n; ++i) {
        for (int j = 0; j + 1 < n; ++j) {
            mesh.add_face(vertex(i, j), vertex(i + 1, j), vertex(i + 1, j + 1));
            mesh.add_face(vertex(i, j), vertex(i + 1, j + 1), vertex(i, j + 1));
        }
    }
    return mesh;
}

int main() {
    try {
        const Mesh mesh = square(50);
        const auto borrowed = catamaran::borrow(mesh);
        const auto distances = catamaran::heat_method(borrowed.mesh()).distances({0});
        std::cout << "the opposite corner is " << distances.back() << " away\n";
        const catamaran::decimation small(borrowed.mesh(), 200);
        const Mesh coarse = catamaran::open_mesh<Mesh>(small.mesh());
        std::cout << coarse.n_vertices() << " vertices and " << coarse.n_faces() << " faces\n";
        const double error = distances.back() - std::sqrt(2.0);
        return borrowed.shares_vertices() && coarse.n_vertices() == 200 && std::abs(error) < 0.1
                   ? EXIT_SUCCESS
                   : EXIT_FAILURE;
    } catch (const catamaran::error& error) {
        std::cerr << error.what() << '\n';
        return EXIT_FAILURE;
    }
}
