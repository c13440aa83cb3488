// A^T A and A^T B from C++17, checked against plain loops.

#include <catamaran.hpp>

#include <cmath>
#include <cstdlib>
#include <iostream>
#include <random>
#include <vector>

namespace {

using catamaran::matrix_view;

// Largest entry of |C - A^T B|, relative to the largest that rounding is measured by.
template <class T>
double difference(matrix_view<const T> a, matrix_view<const T> b, matrix_view<const T> c) {
    double worst = 0.0;
    for (std::size_t i = 0; i < a.cols; ++i) {
        for (std::size_t j = 0; j < b.cols; ++j) {
            double sum = 0.0;
            for (std::size_t k = 0; k < a.rows; ++k) {
                sum += double(a(k, i)) * double(b(k, j));
            }
            const double error = std::abs(sum - double(c(i, j)));
            worst = error <= worst ? worst : error;
        }
    }
    return worst / double(a.rows);
}

template <class T>
bool run(const char* scalar, double tolerance) {
    constexpr std::size_t m = 211, n = 97, k = 31;
    std::mt19937 random(7);
    std::uniform_real_distribution<T> uniform(-1, 1);
    std::vector<T> a_data(m * n), b_data(m * k), d_data(n * k);
    for (T& x : a_data) x = uniform(random);
    for (T& x : b_data) x = uniform(random);
    const auto a = catamaran::col_major(static_cast<const T*>(a_data.data()), m, n);
    const auto b = catamaran::col_major(static_cast<const T*>(b_data.data()), m, k);

    const std::vector<T> c_data = catamaran::ata(a);
    const auto c = catamaran::col_major(c_data.data(), n, n);
    const double of_ata = difference<T>(a, a, c);

    const auto d = catamaran::col_major(d_data.data(), n, k);
    catamaran::options one_thread;
    one_thread.threads = 1;
    catamaran::atb<T>(1, a, b, 0, d, one_thread);
    const double of_atb = difference<T>(a, b, d);

    const bool verified = catamaran::verify(1.0, a, c).passed;
    std::cout << scalar << ": A^T A off by " << of_ata << ", A^T B by " << of_atb
              << (verified ? ", verified\n" : ", NOT verified\n");
    return of_ata < tolerance && of_atb < tolerance && verified;
}

// The same bytes from two layouts, whatever the number of threads and the machine.
bool reproducible() {
    constexpr std::size_t m = 1000, n = 60;
    std::mt19937 random(8);
    std::normal_distribution<double> normal;
    std::vector<double> rows(m * n), columns(m * n);
    for (std::size_t i = 0; i < m; ++i) {
        for (std::size_t j = 0; j < n; ++j) {
            rows[i * n + j] = columns[i + j * m] = normal(random);
        }
    }
    catamaran::options how;
    how.reproducible = true;
    const std::vector<double> c = catamaran::ata(catamaran::row_major(rows.data(), m, n), how);
    how.threads = 1;
    const std::vector<double> d = catamaran::ata(catamaran::col_major(columns.data(), m, n), how);
    std::cout << "reproducible: " << (c == d ? "the same" : "NOT the same") << '\n';
    return c == d;
}

}  // namespace

int main() {
    try {
        std::cout << "catamaran " << cata_version_string() << '\n';
        const bool in_double = run<double>("double", 1e-14);
        const bool in_float = run<float>("float", 1e-6);
        if (!in_double || !in_float || !reproducible()) {
            std::cerr << "MISMATCH\n";
            return EXIT_FAILURE;
        }
        return EXIT_SUCCESS;
    } catch (const catamaran::error& error) {
        std::cerr << cata_status_name(error.status()) << ": " << error.what() << '\n';
        return EXIT_FAILURE;
    }
}
