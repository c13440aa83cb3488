// The spectrum of a grid from C++17, against its closed form, and a basis of products of its eigenvectors.

#include <catamaran.hpp>

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <iostream>
#include <vector>

namespace {

constexpr std::size_t side = 40, n = side * side, k = 20;
const double pi = std::acos(-1.0);

// A symmetric matrix in compressed rows.
struct sparse {
    std::vector<std::size_t> row_starts{0}, columns;
    std::vector<double> entries;
};

// The Laplacian of a side x side grid graph.
sparse grid() {
    sparse w;
    for (std::size_t i = 0; i < side; ++i) {
        for (std::size_t j = 0; j < side; ++j) {
            const std::size_t row = i * side + j;
            const double degree = 4.0 - (i == 0) - (i + 1 == side) - (j == 0) - (j + 1 == side);
            const auto add = [&w](bool there, std::size_t column, double entry) {
                if (!there) return;
                w.columns.push_back(column);
                w.entries.push_back(entry);
            };
            add(i > 0, row - side, -1.0);
            add(j > 0, row - 1, -1.0);
            add(true, row, degree);
            add(j + 1 < side, row + 1, -1.0);
            add(i + 1 < side, row + side, -1.0);
            w.row_starts.push_back(w.columns.size());
        }
    }
    return w;
}

// Its eigenvalues, ascending.
std::vector<double> closed_form() {
    const auto path = [](std::size_t i) { return 2.0 - 2.0 * std::cos(pi * double(i) / double(side)); };
    std::vector<double> values;
    for (std::size_t i = 0; i < side; ++i) {
        for (std::size_t j = 0; j < side; ++j) values.push_back(path(i) + path(j));
    }
    std::sort(values.begin(), values.end());
    return values;
}

}  // namespace

int main() {
    try {
        const sparse w = grid();
        catamaran::eigs_options how;
        how.verify_count = true;
        const catamaran::eigenpairs pairs = catamaran::eigs(
            {n, w.row_starts.data(), w.columns.data(), w.entries.data()}, k, {}, how);
        const std::vector<double> expected = closed_form();
        double worst = 0.0;
        for (std::size_t i = 0; i < k; ++i) worst = std::max(worst, std::abs(pairs.values[i] - expected[i]));
        const double residual = *std::max_element(pairs.residuals.begin(), pairs.residuals.end());
        std::cout << k << " eigenvalues off by " << worst << ", residuals of " << residual << '\n';

        // All products of two eigenvectors, of which the constant one is the first, orthonormalized.
        const auto vectors = pairs.matrix();
        std::vector<double> products;
        for (std::size_t a = 0; a < k; ++a) {
            for (std::size_t b = a; b < k; ++b) {
                for (std::size_t i = 0; i < n; ++i) products.push_back(vectors(i, a) * vectors(i, b));
            }
        }
        const std::size_t count = k * (k + 1) / 2;
        const auto basis = catamaran::col_major(products.data(), n, count);
        const std::size_t rank = catamaran::gram_schmidt(basis).kept.size();
        double defect = 0.0;
        for (std::size_t a = 0; a < rank; ++a) {
            for (std::size_t b = 0; b <= a; ++b) {
                double sum = a == b ? -1.0 : 0.0;
                for (std::size_t i = 0; i < n; ++i) sum += basis(i, a) * basis(i, b);
                defect = std::max(defect, std::abs(sum));
            }
        }
        std::cout << count << " products span " << rank << " dimensions, orthonormal up to " << defect << '\n';
        const bool good = worst < 1e-9 && residual <= 1e-9 && rank > k && rank < count && defect < 1e-12;
        if (!good) std::cerr << "MISMATCH\n";
        return good ? EXIT_SUCCESS : EXIT_FAILURE;
    } catch (const catamaran::error& error) {
        std::cerr << cata_status_name(error.status()) << ": " << error.what() << '\n';
        return EXIT_FAILURE;
    }
}
