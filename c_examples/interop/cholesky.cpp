// Solutions with a sparse symmetric matrix of Eigen, without a copy of it, beside Eigen's own.

#include <catamaran/eigen.hpp>

#include <Eigen/Sparse>

#include <chrono>
#include <cstddef>
#include <cstdlib>
#include <iostream>
#include <vector>

// Indices as wide as those of the library.
using Sparse = catamaran::wide_sparse<Eigen::ColMajor>;

// The Laplacian of a square grid, plus a small multiple of the identity.
Sparse grid(std::ptrdiff_t side, double shift) {
    std::vector<Eigen::Triplet<double, std::ptrdiff_t>> entries;
    const auto join = [&](std::ptrdiff_t i, std::ptrdiff_t j) {
        entries.emplace_back(i, j, -1.0);
        entries.emplace_back(j, i, -1.0);
        entries.emplace_back(i, i, 1.0);
        entries.emplace_back(j, j, 1.0);
    };
    for (std::ptrdiff_t i = 0; i < side * side; ++i) {
        entries.emplace_back(i, i, shift);
        if (i % side > 0) join(i, i - 1);
        if (i >= side) join(i, i - side);
    }
    Sparse a(side * side, side * side);
    a.setFromTriplets(entries.begin(), entries.end());
    return a;
}

using catamaran::symmetric_view;

template <class Work>
double seconds(Work work) {
    const auto start = std::chrono::steady_clock::now();
    work();
    return std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
}

int main() {
    try {
        const Sparse a = grid(150, 0.01), other = grid(150, 0.02);
        const Eigen::MatrixXd b = Eigen::MatrixXd::Random(a.rows(), 8);
        const auto rows = static_cast<std::size_t>(a.rows());

        Eigen::SimplicialLDLT<Sparse> ldlt;
        catamaran::cholesky cholesky = catamaran::cholesky::analysis(symmetric_view(a));
        std::cout << "analysis: " << seconds([&] { ldlt.analyzePattern(a); }) << " s (Eigen), "
                  << seconds([&] { cholesky = catamaran::cholesky::analysis(symmetric_view(a)); })
                  << " s\n";
        double largest = 0;
        for (const Sparse* matrix : {&a, &other}) {
            std::cout << "factor: " << seconds([&] { ldlt.factorize(*matrix); })
                      << " s (Eigen), "
                      << seconds([&] { cholesky.factor(symmetric_view(*matrix)); }) << " s\n";
            Eigen::MatrixXd expected, x = b;
            std::cout << "8 solutions: " << seconds([&] { expected = ldlt.solve(b); })
                      << " s (Eigen), " << seconds([&] {
                             cholesky.solve_in_place(catamaran::col_major(x.data(), rows, 8));
                         }) << " s\n";
            const double difference = (x - expected).cwiseAbs().maxCoeff();
            largest = difference > largest ? difference : largest;
        }
        std::cout << "solutions differ by " << largest << '\n';
        return largest < 1e-10 ? EXIT_SUCCESS : EXIT_FAILURE;
    } catch (const catamaran::error& error) {
        std::cerr << error.what() << '\n';
        return EXIT_FAILURE;
    }
}
