// From a mesh file to spectra, distances and fewer vertices: reads a mesh, or makes a broken torus,
// repairs it, and writes it with fewer vertices, coloured by the distance from one of them.
//
//     mesh [INPUT [OUTPUT]]

#include <catamaran.hpp>

#include <algorithm>
#include <cmath>
#include <cstdio>

namespace {

// A torus whose triangles share no vertex.
catamaran::mesh_file torus() {
    std::vector<std::array<double, 3>> vertices;
    std::vector<std::array<std::uint32_t, 3>> faces;
    const auto corner = [&](int i, int j) {
        const double u = 6.283185307179586 * (i % 60) / 60, v = 6.283185307179586 * (j % 30) / 30;
        vertices.push_back({{(2 + std::cos(v)) * std::cos(u), (2 + std::cos(v)) * std::sin(u),
                             std::sin(v)}});
        return static_cast<std::uint32_t>(vertices.size() - 1);
    };
    for (int i = 0; i < 60; ++i) {
        for (int j = 0; j < 30; ++j) {
            const std::uint32_t a = corner(i, j), b = corner(i + 1, j), c = corner(i + 1, j + 1);
            const std::uint32_t d = corner(i, j), e = corner(i + 1, j + 1), f = corner(i, j + 1);
            faces.push_back({{a, b, c}});
            faces.push_back({{d, e, f}});
        }
    }
    return catamaran::mesh_file(catamaran::mesh_view{vertices, faces});
}

}  // namespace

int main(int argc, char** argv) {
    try {
        const auto input = argc > 1 ? catamaran::mesh_file::read(argv[1]) : torus();
        catamaran::repair_options steps;
        steps.everything = true;
        steps.fill_holes = 30;
        const auto repaired = catamaran::repair(input, steps);
        for (const auto& step : repaired.steps) {
            std::printf("%s\n", step.text.c_str());
        }
        const catamaran::mesh_view mesh = repaired.file.mesh();
        const auto pairs = catamaran::eigs(mesh, std::min<std::size_t>(50, mesh.n_vertices / 2));
        std::printf("%zu eigenvalues, the last is %.4g\n", pairs.values.size(),
                    pairs.values.back());
        auto distances = catamaran::heat_method(mesh).distances({mesh.faces[0]});
        double farthest = 0.0;
        for (double& distance : distances) {
            distance = std::isfinite(distance) ? distance : 0.0;
            farthest = std::max(farthest, distance);
        }
        std::printf("the farthest vertex is %.4g away\n", farthest);

        const catamaran::decimation small(mesh, mesh.n_vertices / 4);
        catamaran::mesh_file output(small.mesh());
        std::vector<std::array<double, 4>> colors;
        for (const double distance : small.carry(distances)) {
            const double red = farthest > 0.0 ? distance / farthest : 0.0;
            colors.push_back({{red, 0.5, 1.0 - red, 1.0}});
        }
        output.set_colors(colors);
        const auto bytes = output.write(catamaran::mesh_format::ply);
        std::printf("%zu vertices, %zu bytes\n", output.vertices().size(), bytes.size());
        if (argc > 2) {
            output.write(argv[2]);
        }
    } catch (const catamaran::error& error) {
        std::fprintf(stderr, "%s\n", error.what());
        return 1;
    }
    return 0;
}
