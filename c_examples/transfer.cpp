// A function carried from a torus to one that is bent a little and numbered otherwise, through products of
// eigenfunctions, beside eigenfunctions alone.

#include <catamaran.hpp>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <cstdlib>
#include <iostream>
#include <vector>

namespace {

constexpr std::uint32_t around = 40, across = 20, n = around * across;
constexpr std::size_t k = 16;
const double pi = std::acos(-1.0);

// The vertex of the target that stands for vertex v of the source: numbered backwards.
std::uint32_t image(std::uint32_t v) { return n - 1 - v; }

struct mesh {
    std::vector<std::array<double, 3>> positions{n};
    std::vector<std::array<std::uint32_t, 3>> faces;
};

template <class Number>
mesh torus(double bent, Number number) {
    mesh found;
    for (std::uint32_t i = 0; i < around; ++i) {
        for (std::uint32_t j = 0; j < across; ++j) {
            const double u = 2 * pi * i / around, v = 2 * pi * j / across;
            const double radius = 2.0 + (0.8 + 0.1 * std::cos(u)) * std::cos(v);
            const auto vertex = [&](std::uint32_t a, std::uint32_t b) {
                return number(a % around * across + b % across);
            };
            found.positions[vertex(i, j)] = {radius * std::cos(u), 1.3 * radius * std::sin(u),
                                             std::sin(v) + bent * std::cos(2 * u)};
            found.faces.push_back({vertex(i, j), vertex(i + 1, j), vertex(i + 1, j + 1)});
            found.faces.push_back({vertex(i, j), vertex(i + 1, j + 1), vertex(i, j + 1)});
        }
    }
    return found;
}

}  // namespace

int main() {
    try {
        const mesh first = torus(0.0, [](std::uint32_t v) { return v; });
        const mesh second = torus(0.05, image);
        const catamaran::eigenpairs source = catamaran::eigs({first.positions, first.faces}, k);
        const catamaran::eigenpairs target = catamaran::eigs({second.positions, second.faces}, k);
        const double residual = *std::max_element(source.residuals.begin(), source.residuals.end());
        std::cout << k << " eigenpairs, residuals up to " << residual << '\n';

        std::vector<std::uint32_t> points(n);
        std::vector<double> function(n);
        for (std::uint32_t v = 0; v < n; ++v) {
            points[image(v)] = v;
            const double u = 2 * pi * (v / across) / around;
            function[v] = std::cos(4 * u) + 0.5 * std::sin(2 * pi * (v % across) / across);
        }
        const auto column = catamaran::col_major<const double>(function.data(), n, 1);
        const auto error = [&](std::size_t order) {
            catamaran::basis_options how;
            how.order = order;
            const std::vector<double> carried = catamaran::transfer(source, target, points, column, how);
            double gap = 0.0, size = 0.0;
            for (std::uint32_t v = 0; v < n; ++v) {
                const double expected = function[points[v]];
                gap += target.masses[v] * (carried[v] - expected) * (carried[v] - expected);
                size += target.masses[v] * expected * expected;
            }
            return std::sqrt(gap / size);
        };
        const double alone = error(1), products = error(2);
        std::cout << "off by " << alone << " through eigenfunctions, " << products << " through their products\n";
        const bool good = residual <= 1e-9 && products < 0.1 && products < 0.5 * alone;
        if (!good) std::cerr << "MISMATCH\n";
        return good ? EXIT_SUCCESS : EXIT_FAILURE;
    } catch (const catamaran::error& error) {
        std::cerr << cata_status_name(error.status()) << ": " << error.what() << '\n';
        return EXIT_FAILURE;
    }
}
