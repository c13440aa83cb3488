// From a mesh file to spectra, distances and fewer vertices: repairs a mesh, or a broken torus, and
// writes OUTPUT.csv (the distance from a vertex and eigenfunctions, a line for each vertex) and
// OUTPUT.ply (a quarter of the vertices). python/examples/mesh.py does the same from Python.
//
//     mesh [OUTPUT [INPUT]]

#include <catamaran.hpp>

#include <cmath>
#include <cstdio>
#include <fstream>

// A torus whose triangles share no vertex.
catamaran::mesh_file torus() {
    const std::uint32_t along[2][3] = {{0, 1, 1}, {0, 1, 0}}, around[2][3] = {{0, 0, 1}, {0, 1, 1}};
    catamaran::point_list vertices;
    catamaran::triangle_list faces;
    for (std::uint32_t k = 0; k < 2 * 60 * 30; ++k) {
        for (std::uint32_t c = 0; c < 3; ++c) {
            const double u = std::acos(-1.0) / 30 * ((k / 2 + along[k % 2][c]) % 60);
            const double v = std::acos(-1.0) / 15 * ((k / 120 + around[k % 2][c]) % 30);
            const double r = 2 + std::cos(v);
            vertices.push_back({{r * std::cos(u), r * std::sin(u), std::sin(v)}});
        }
        faces.push_back({{3 * k, 3 * k + 1, 3 * k + 2}});
    }
    return catamaran::mesh_file(catamaran::mesh_view(vertices, faces));
}

int main(int argc, char** argv) try {
    const auto input = argc > 2 ? catamaran::mesh_file::read(argv[2]) : torus();
    catamaran::repair_options steps;
    steps.everything = true;
    steps.fill_holes = 30;
    const auto repaired = catamaran::repair(input, steps);
    for (const auto& step : repaired.steps) std::printf("%s\n", step.text.c_str());
    const catamaran::mesh_view mesh = repaired.file.mesh();
    const auto pairs = catamaran::eigs(mesh, 50);
    const auto distances = catamaran::heat_method(mesh).distances({mesh.faces[0]});
    const catamaran::decimation small(mesh, mesh.n_vertices / 4);
    std::printf("%zu vertices, %zu of them kept; the last of 50 eigenvalues is %.6g\n",
                mesh.n_vertices, small.vertices().size(), pairs.values.back());
    if (argc > 1) {
        const std::string output = argv[1];
        std::ofstream table(output + ".csv");
        table.precision(17);
        const auto functions = pairs.matrix();
        for (std::size_t v = 0; v < functions.rows; ++v) {
            table << distances[v];
            for (std::size_t j = 0; j < functions.cols; ++j) table << ',' << functions(v, j);
            table << '\n';
        }
        catamaran::mesh_file(small.mesh()).write(output + ".ply");
        if (!table.flush()) throw std::runtime_error(output + ".csv: not written");
    }
    return 0;
} catch (const std::exception& error) {
    std::fprintf(stderr, "%s\n", error.what());
    return 1;
}
