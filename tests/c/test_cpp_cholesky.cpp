// Sparse Cholesky factorizations through the C++ layer.

#include <catamaran.hpp>

#include <algorithm>
#include <cmath>
#include <stdexcept>
#include <string>
#include <utility>
#include <vector>

#include "check.hpp"

namespace {

using catamaran::cholesky;
using catamaran::cholesky_options;

void solutions_of_a_path() {
    // The inverse has (i + 1) (n - j) / (n + 1) at i <= j.
    const std::size_t n = 101;
    const tridiagonal held(n, 2, 2);
    cholesky factors(held.view());
    std::vector<double> b(2 * n);
    b[10] = 1;
    b[n + 90] = 1;
    const auto inverse = [&](std::size_t i, std::size_t j) {
        return static_cast<double>((std::min(i, j) + 1) * (n - std::max(i, j))) / (n + 1);
    };
    const auto x = factors.solve(catamaran::col_major<const double>(b.data(), n, 2));
    bool right = true;
    for (std::size_t i = 0; i < n; ++i) {
        right = right && std::abs(x[i] - inverse(i, 10)) < 1e-11;
        right = right && std::abs(x[n + i] - inverse(i, 90)) < 1e-11;
    }
    CHECK(right);
    const auto rows =
        factors.solve_rows(catamaran::col_major<const double>(b.data(), n, 2), {50, 3});
    CHECK(rows.size() == 4 && rows[0] == x[50] && rows[1] == x[3] && rows[3] == x[n + 3]);
    CHECK(factors.size() == n && factors.entries() >= 2 * n - 1 && factors.held().empty());
    CHECK(factors.weakest().second > 0.01 && factors.weakest().second <= 1);

    // Moved, and with other values.
    cholesky other = std::move(factors);
    const tridiagonal twice(n, 3, 3);
    other.factor(twice.view());
    std::vector<double> ones(n, 1.0);
    other.solve_in_place(catamaran::col_major(ones.data(), n, 1));
    CHECK(std::abs(3 * ones[0] - ones[1] - 1) < 1e-14);
    CHECK(std::abs(3 * ones[50] - ones[49] - ones[51] - 1) < 1e-14);
    CHECK(status_of([&] { other.factor(tridiagonal(n - 1, 3, 3).view()); }) == CATA_ERR_SHAPE);
    CHECK(status_of([&] { other.solve(catamaran::col_major<const double>(b.data(), 5, 2)); }) ==
          CATA_ERR_SHAPE);
}

void a_laplacian_is_semidefinite() {
    const std::size_t n = 50;
    const tridiagonal path(n, 2, 1);
    CHECK(status_of([&] { cholesky strict(path.view()); }) == CATA_ERR_ARGUMENT);
    cholesky_options how;
    how.semidefinite = true;
    how.order = {0, 1};
    CHECK(status_of([&] { cholesky short_one(path.view(), how); }) == CATA_ERR_SHAPE);
    how.order.resize(n);
    for (std::size_t i = 0; i < n; ++i) how.order[i] = n - 1 - i;
    const cholesky factors(path.view(), how);
    const auto held = factors.held();
    CHECK(held.size() == 1 && held[0] == 0);
    // From one end to the other the solution falls by one a node.
    std::vector<double> b(n);
    b.front() = 1;
    b.back() = -1;
    factors.solve_in_place(catamaran::col_major(b.data(), n, 1));
    CHECK(std::abs(b.front() - b.back() - (n - 1)) < 1e-10 && b[held.front()] == 0);
}

void progress_is_told_and_its_exceptions_come_out() {
    const tridiagonal held(20, 2, 2);
    int calls = 0;
    bool throws = false;
    cholesky_options how;
    how.progress = [&](double) {
        ++calls;
        if (throws) throw std::runtime_error("enough");
        return true;
    };
    cholesky factors = cholesky::analysis(held.view(), how);
    CHECK(calls > 0);
    throws = true;
    bool caught = false;
    try {
        factors.factor(held.view());
    } catch (const std::runtime_error& error) {
        caught = std::string(error.what()) == "enough";
    }
    CHECK(caught);
    throws = false;
    factors.factor(held.view());
    CHECK(factors.weakest().first < 20);
}

}  // namespace

int main() {
    solutions_of_a_path();
    a_laplacian_is_semidefinite();
    progress_is_told_and_its_exceptions_come_out();
    return report("test_cpp_cholesky");
}
