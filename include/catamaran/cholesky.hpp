// Sparse Cholesky factorizations.

#ifndef CATAMARAN_CHOLESKY_HPP
#define CATAMARAN_CHOLESKY_HPP

#include "ata.hpp"

#include <functional>
#include <memory>
#include <utility>
#include <vector>

namespace catamaran {

/// What is read of a matrix, and which pivots are allowed: the fields of cata_cholesky_params.
struct cholesky_options {
    /// Threads, at most; 0: as many as the process may use (catamaran.h, Threads).
    std::size_t threads = 0;
    /// The triangle that is read; both: they must agree.
    uplo triangle = uplo::both;
    /// Whether pivots may be zero, of which the rows are held at zero.
    bool semidefinite = false;
    /// Largest pivot that is zero, relative to the diagonal entry of its row; 0: 8 n 2^-52 if
    /// semidefinite, and only zero itself if not.
    double tolerance = 0.0;
    /// The rows in the order of elimination, each once; none: approximate minimum degree, from
    /// 100,000 rows on after nested dissection.
    std::vector<std::size_t> order;
    /// Progress callback, as options::progress, of all calls of the factorization.
    std::function<bool(double)> progress;
};

/// A = L L^T for a sparse symmetric A, and solutions of A X = B: cata_cholesky. One owner. A matrix
/// by columns is given as its transpose, with the other triangle.
class cholesky {
public:
    /// Analyses and factorizes A.
    explicit cholesky(const sparse_view& a, const cholesky_options& how = {})
        : cholesky(analysis(a, how)) {
        factor(a);
    }

    /// Analyses matrices with entries in the places of A, whose entries are not read and may be
    /// null: factor comes next.
    static cholesky analysis(const sparse_view& a, const cholesky_options& how = {}) {
        detail::require(how.order.empty() || how.order.size() == a.rows, CATA_ERR_SHAPE,
                        "order: must be as many as rows, or none");
        cholesky made(how.progress);
        cata_cholesky_params params;
        detail::check(cata_cholesky_params_init(&params, sizeof params));
        params.threads = how.threads;
        params.order = how.order.empty() ? nullptr : how.order.data();
        params.triangle = static_cast<std::int32_t>(how.triangle);
        params.semidefinite = how.semidefinite ? 1 : 0;
        params.tolerance = how.tolerance;
        made.watcher_.attach(params);
        cata_cholesky* handle = nullptr;
        made.watcher_.finish(
            cata_cholesky_analyse(a.rows, a.row_starts, a.columns, &params, &handle));
        made.handle_.reset(handle);
        return made;
    }

    /// Computes L for a matrix without entries in other places, any number of times.
    void factor(const sparse_view& a) {
        detail::require(a.rows == size(), CATA_ERR_SHAPE, "a: must have as many rows as before");
        watcher_.finish(
            cata_cholesky_factor(handle_.get(), a.row_starts, a.columns, a.entries));
    }

    /// The solution X of A X = B, size() x b.cols, in the layout of B without gaps.
    std::vector<double> solve(matrix_view<const double> b) const {
        const std::size_t n = rows_of(b);
        std::vector<double> x(n * b.cols);
        const matrix_view<double> solution{x.data(), n, b.cols,
                                           detail::gapless(b.order, n, b.cols), b.order};
        for (std::size_t i = 0; i < n; ++i) {
            for (std::size_t j = 0; j < b.cols; ++j) {
                solution(i, j) = b(i, j);
            }
        }
        solve_in_place(solution);
        return x;
    }

    /// Replaces B by the solution of A X = B.
    void solve_in_place(matrix_view<double> b) const {
        rows_of(b);
        watcher_.finish(cata_cholesky_solve(get(), static_cast<std::int32_t>(b.order), b.cols,
                                            b.data, b.leading));
    }

    /// Rows of the solution, from 0 and in any order: rows.size() x b.cols, in the layout of B
    /// without gaps.
    std::vector<double> solve_rows(matrix_view<const double> b,
                                   const std::vector<std::size_t>& rows) const {
        rows_of(b);
        std::vector<double> x(rows.size() * b.cols);
        watcher_.finish(cata_cholesky_solve_rows(
            get(), static_cast<std::int32_t>(b.order), b.cols, b.data, b.leading, rows.size(),
            rows.data(), x.data(), detail::gapless(b.order, rows.size(), b.cols)));
        return x;
    }

    /// Number of rows of A.
    std::size_t size() const {
        std::size_t n = 0;
        detail::check(cata_cholesky_size(get(), &n, nullptr, nullptr));
        return n;
    }

    /// Number of entries of L that are stored, zeros included.
    std::size_t entries() const {
        std::size_t entries = 0;
        detail::check(cata_cholesky_size(get(), nullptr, &entries, nullptr));
        return entries;
    }

    /// The rows that are held at zero, ascending; none without a factor.
    std::vector<std::size_t> held() const {
        std::size_t count = 0;
        detail::check(cata_cholesky_size(get(), nullptr, nullptr, &count));
        std::vector<std::size_t> held(count);
        detail::check(cata_cholesky_held(get(), held.data()));
        return held;
    }

    /// The row with the smallest pivot relative to its diagonal entry, and this ratio; size() and 1
    /// without rows that are not held, or without a factor.
    std::pair<std::size_t, double> weakest() const {
        std::pair<std::size_t, double> found;
        detail::check(cata_cholesky_weakest(get(), &found.first, &found.second));
        return found;
    }

private:
    struct free {
        void operator()(cata_cholesky* handle) const { cata_cholesky_free(handle); }
    };

    explicit cholesky(const std::function<bool(double)>& progress) : watcher_(progress) {}

    const cata_cholesky* get() const noexcept { return handle_.get(); }

    std::size_t rows_of(matrix_view<const double> b) const {
        const std::size_t n = size();
        detail::require(b.rows == n, CATA_ERR_SHAPE, "b: must have a row for each row of a");
        return n;
    }

    detail::kept_watcher watcher_;
    std::unique_ptr<cata_cholesky, free> handle_;
};

}  // namespace catamaran

#endif
