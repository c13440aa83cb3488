// A^T A, A A^T, A^T B, their complex forms, checks and sparse products.

#ifndef CATAMARAN_ATA_HPP
#define CATAMARAN_ATA_HPP

#include "backend.hpp"

#include <complex>
#include <limits>

namespace catamaran {

/// How a product is computed: the fields of cata_ata_params.
struct options {
    /// Threads, at most; 0: as many as the process may use (catamaran.h, Threads).
    std::size_t threads = 0;
    /// Which recursion to run.
    catamaran::scheme scheme = scheme::automatic;
    /// 0: the default; 1: classical products only; infinity: no bound; CATA_ERROR_LEAST: the least.
    double error_factor = 0.0;
    /// Whether results have the same bytes on every machine, by scheme::exact; no other is
    /// allowed.
    bool reproducible = false;
    /// Thread i stays on the i-th core of the affinity mask of the process.
    bool pin = false;
    /// 0: chosen by the library.
    std::size_t leaf = 0;
    /// 0: chosen by the library.
    std::size_t tasks = 0;
    /// Back end of the small products, which must outlive the call; null: the built-in one.
    const catamaran::backend* backend = nullptr;
    /// Told the fraction done; returns whether to go on. It is called from any thread that works
    /// for the call, one call at a time, each after the one before it has returned. It may be slow,
    /// and may call this library. What it throws stops the work and comes out of the call.
    std::function<bool(double)> progress;
};

namespace detail {

/// cata_ata_params for the length of a call.
class call {
public:
    explicit call(const options& options) : watcher_(options.progress) {
        check(cata_ata_params_init(&params_, sizeof params_));
        params_.threads = options.threads;
        params_.scheme = static_cast<std::int32_t>(options.scheme);
        params_.error_factor = options.error_factor;
        params_.reproducible = options.reproducible ? 1 : 0;
        params_.pin = options.pin ? 1 : 0;
        params_.leaf = options.leaf;
        params_.tasks = options.tasks;
        params_.backend = options.backend ? options.backend->get() : nullptr;
        watcher_.attach(params_);
    }

    const cata_ata_params* params() const noexcept { return &params_; }

    void finish(cata_status status) { watcher_.finish(status); }

private:
    cata_ata_params params_{};
    watcher watcher_;
};

template <class T>
void require_square(matrix_view<T> c, std::size_t n, layout order,
                    const char* wanted = "c: must be square, of the columns of a") {
    require(c.rows == n && c.cols == n, CATA_ERR_SHAPE, wanted);
    require(c.order == order, CATA_ERR_ARGUMENT, "c: must have the layout of a");
}

template <class T>
void require_general(matrix_view<const T> a, matrix_view<const T> b, matrix_view<T> c) {
    require(a.rows == b.rows, CATA_ERR_SHAPE, "b: must have the rows of a");
    require(c.rows == a.cols && c.cols == b.cols, CATA_ERR_SHAPE,
            "c: must have the columns of a as rows and those of b as columns");
    require(a.order == b.order && a.order == c.order, CATA_ERR_ARGUMENT,
            "b, c: must have the layout of a");
}

}  // namespace detail

/// C := alpha A^T A + beta C. A is m x n, C is n x n, in the same layout.
template <class T>
void ata(detail::identity_t<T> alpha, matrix_view<const T> a, detail::identity_t<T> beta,
         matrix_view<T> c, uplo part = uplo::both, const options& how = {}) {
    detail::require_square(c, a.cols, a.order);
    detail::call call(how);
    const auto order = static_cast<std::int32_t>(a.order);
    const auto triangle = static_cast<std::int32_t>(part);
    const auto product = detail::of_scalar<T>(cata_ata_f64, cata_ata_f32);
    call.finish(product(order, triangle, a.rows, a.cols, alpha, a.data, a.leading, beta, c.data,
                        c.leading, call.params()));
}

template <class T>
void ata(detail::identity_t<T> alpha, matrix_view<T> a, detail::identity_t<T> beta,
         matrix_view<T> c, uplo part = uplo::both, const options& how = {}) {
    ata<T>(alpha, matrix_view<const T>(a), beta, c, part, how);
}

/// C_i := alpha A_i^T A_i + beta C_i for `count` matrices, of which `a` and `c` are the first ones,
/// each so many elements before the next one: cata_ata_batched_f64.
template <class T>
void ata_batched(std::size_t count, detail::identity_t<T> alpha, matrix_view<const T> a,
                 std::size_t stride_a, detail::identity_t<T> beta, matrix_view<T> c,
                 std::size_t stride_c, uplo part = uplo::both, const options& how = {}) {
    detail::require_square(c, a.cols, a.order);
    detail::call call(how);
    const auto product = detail::of_scalar<T>(cata_ata_batched_f64, cata_ata_batched_f32);
    call.finish(product(static_cast<std::int32_t>(a.order), static_cast<std::int32_t>(part), count,
                        a.rows, a.cols, alpha, a.data, a.leading, stride_a, beta, c.data,
                        c.leading, stride_c, call.params()));
}

template <class T>
void ata_batched(std::size_t count, detail::identity_t<T> alpha, matrix_view<T> a,
                 std::size_t stride_a, detail::identity_t<T> beta, matrix_view<T> c,
                 std::size_t stride_c, uplo part = uplo::both, const options& how = {}) {
    ata_batched<T>(count, alpha, matrix_view<const T>(a), stride_a, beta, c, stride_c, part, how);
}

/// C := alpha A A^T + beta C. A is m x n, C is m x m, in the same layout: cata_aat_f64.
template <class T>
void aat(detail::identity_t<T> alpha, matrix_view<const T> a, detail::identity_t<T> beta,
         matrix_view<T> c, uplo part = uplo::both, const options& how = {}) {
    detail::require_square(c, a.rows, a.order, "c: must be square, of the rows of a");
    detail::call call(how);
    const auto product = detail::of_scalar<T>(cata_aat_f64, cata_aat_f32);
    call.finish(product(static_cast<std::int32_t>(a.order), static_cast<std::int32_t>(part),
                        a.rows, a.cols, alpha, a.data, a.leading, beta, c.data, c.leading,
                        call.params()));
}

template <class T>
void aat(detail::identity_t<T> alpha, matrix_view<T> a, detail::identity_t<T> beta,
         matrix_view<T> c, uplo part = uplo::both, const options& how = {}) {
    aat<T>(alpha, matrix_view<const T>(a), beta, c, part, how);
}

namespace detail {

/// Room for an n x n matrix without gaps.
template <class T>
std::vector<T> square(std::size_t n) {
    require(n == 0 || n <= std::numeric_limits<std::size_t>::max() / n, CATA_ERR_SHAPE,
            "a: the product exceeds the address space");
    return std::vector<T>(n * n);
}

}  // namespace detail

/// A^T A, n x n without gaps, in the layout of A; both triangles.
template <class T>
std::vector<std::remove_const_t<T>> ata(matrix_view<T> a, const options& how = {}) {
    using S = std::remove_const_t<T>;
    std::vector<S> c = detail::square<S>(a.cols);
    const matrix_view<S> view{c.data(), a.cols, a.cols, a.cols ? a.cols : 1, a.order};
    ata<S>(S(1), matrix_view<const S>(a), S(0), view, uplo::both, how);
    return c;
}

/// A A^T, m x m without gaps, in the layout of A; both triangles.
template <class T>
std::vector<std::remove_const_t<T>> aat(matrix_view<T> a, const options& how = {}) {
    using S = std::remove_const_t<T>;
    std::vector<S> c = detail::square<S>(a.rows);
    const matrix_view<S> view{c.data(), a.rows, a.rows, a.rows ? a.rows : 1, a.order};
    aat<S>(S(1), matrix_view<const S>(a), S(0), view, uplo::both, how);
    return c;
}

/// How ata computes A^T A of an m x n matrix, in lines of text: cata_ata_plan_f64.
template <class T>
std::string plan(std::size_t m, std::size_t n, const options& how = {}) {
    char text[4096];
    detail::call call(how);
    const auto describe = detail::of_scalar<T>(cata_ata_plan_f64, cata_ata_plan_f32);
    call.finish(describe(m, n, call.params(), sizeof text, text));
    return text;
}

/// What is subtracted from the rows of a matrix.
enum class centering : std::int32_t {
    none = CATA_CENTER_NONE,
    mean = CATA_CENTER_MEAN,
    given = CATA_CENTER_GIVEN,
};

/// Which rows a product is of: those of A, with weights, less their mean or a given row.
template <class T>
struct row_options {
    /// Weights, one for each row of A; empty: all 1.
    std::vector<T> weights;
    /// What is subtracted from each row.
    catamaran::centering centering = centering::none;
    /// Row to subtract, with centering::given: one value for each column of A.
    std::vector<T> center;
};

/// C := alpha X^T W X + beta C of the rows X of A, which are read in blocks. C is n x n, in the
/// layout of A: cata_ata_rows_f64.
template <class T>
void ata_rows(detail::identity_t<T> alpha, matrix_view<const T> a,
              const row_options<detail::identity_t<T>>& rows, detail::identity_t<T> beta,
              matrix_view<T> c, uplo part = uplo::both, const options& how = {}) {
    detail::require_square(c, a.cols, a.order);
    detail::require(rows.weights.empty() || rows.weights.size() == a.rows, CATA_ERR_SHAPE,
                    "weights: must be as many as rows, or none for all 1");
    detail::require(rows.centering != centering::given || rows.center.size() == a.cols,
                    CATA_ERR_SHAPE, "center: must have an element for each column of a");
    detail::call call(how);
    const auto product = detail::of_scalar<T>(cata_ata_rows_f64, cata_ata_rows_f32);
    call.finish(product(static_cast<std::int32_t>(a.order), static_cast<std::int32_t>(part),
                        a.rows, a.cols, alpha, a.data, a.leading,
                        rows.weights.empty() ? nullptr : rows.weights.data(),
                        static_cast<std::int32_t>(rows.centering), rows.center.data(), beta,
                        c.data, c.leading, call.params()));
}

/// alpha X^T W X, n x n without gaps, in the layout of A; both triangles.
template <class T>
std::vector<std::remove_const_t<T>> ata_rows(matrix_view<T> a,
                                             const row_options<std::remove_const_t<T>>& rows,
                                             std::remove_const_t<T> alpha = 1,
                                             const options& how = {}) {
    using S = std::remove_const_t<T>;
    std::vector<S> c = detail::square<S>(a.cols);
    const matrix_view<S> view{c.data(), a.cols, a.cols, a.cols ? a.cols : 1, a.order};
    ata_rows<S>(alpha, matrix_view<const S>(a), rows, S(0), view, uplo::both, how);
    return c;
}

/// C := alpha A^T B + beta C. A is m x n, B is m x k, C is n x k, in the same layout.
template <class T>
void atb(detail::identity_t<T> alpha, matrix_view<const T> a, matrix_view<const T> b,
         detail::identity_t<T> beta, matrix_view<T> c, const options& how = {}) {
    detail::require_general(a, b, c);
    detail::call call(how);
    const auto order = static_cast<std::int32_t>(a.order);
    const auto product = detail::of_scalar<T>(cata_atb_f64, cata_atb_f32);
    call.finish(product(order, a.rows, a.cols, b.cols, alpha, a.data, a.leading, b.data, b.leading,
                        beta, c.data, c.leading, call.params()));
}

template <class T>
void atb(detail::identity_t<T> alpha, matrix_view<T> a, matrix_view<T> b,
         detail::identity_t<T> beta, matrix_view<T> c, const options& how = {}) {
    atb<T>(alpha, matrix_view<const T>(a), matrix_view<const T>(b), beta, c, how);
}

/// C := alpha A^H A + beta C, alpha and beta real. A is m x n, C is n x n and Hermitian, in the
/// same layout. The diagonal becomes real.
template <class T>
void aha(detail::identity_t<T> alpha, matrix_view<const std::complex<T>> a,
         detail::identity_t<T> beta, matrix_view<std::complex<T>> c, uplo part = uplo::both,
         const options& how = {}) {
    detail::require_square(c, a.cols, a.order);
    detail::call call(how);
    const auto order = static_cast<std::int32_t>(a.order);
    const auto triangle = static_cast<std::int32_t>(part);
    const auto* from = reinterpret_cast<const T*>(a.data);
    auto* to = reinterpret_cast<T*>(c.data);
    const auto product = detail::of_scalar<T>(cata_aha_c64, cata_aha_c32);
    call.finish(product(order, triangle, a.rows, a.cols, alpha, from, a.leading, beta, to,
                        c.leading, call.params()));
}

template <class T>
void aha(detail::identity_t<T> alpha, matrix_view<std::complex<T>> a, detail::identity_t<T> beta,
         matrix_view<std::complex<T>> c, uplo part = uplo::both, const options& how = {}) {
    aha<T>(alpha, matrix_view<const std::complex<T>>(a), beta, c, part, how);
}

/// C := alpha A^H B + beta C. A is m x n, B is m x k, C is n x k, in the same layout.
template <class T>
void ahb(detail::identity_t<std::complex<T>> alpha, matrix_view<const std::complex<T>> a,
         matrix_view<const std::complex<T>> b, detail::identity_t<std::complex<T>> beta,
         matrix_view<std::complex<T>> c, const options& how = {}) {
    detail::require_general(a, b, c);
    detail::call call(how);
    const auto order = static_cast<std::int32_t>(a.order);
    const auto* factor = reinterpret_cast<const T*>(&alpha);
    const auto* kept = reinterpret_cast<const T*>(&beta);
    const auto* left = reinterpret_cast<const T*>(a.data);
    const auto* right = reinterpret_cast<const T*>(b.data);
    auto* to = reinterpret_cast<T*>(c.data);
    const auto product = detail::of_scalar<T>(cata_ahb_c64, cata_ahb_c32);
    call.finish(product(order, a.rows, a.cols, b.cols, factor, left, a.leading, right, b.leading,
                        kept, to, c.leading, call.params()));
}

template <class T>
void ahb(detail::identity_t<std::complex<T>> alpha, matrix_view<std::complex<T>> a,
         matrix_view<std::complex<T>> b, detail::identity_t<std::complex<T>> beta,
         matrix_view<std::complex<T>> c, const options& how = {}) {
    using input = matrix_view<const std::complex<T>>;
    ahb<T>(alpha, input(a), input(b), beta, c, how);
}

/// What verify found.
struct verification {
    /// Whether C passed.
    bool passed;
    /// Largest error that was found.
    double residual;
    /// Largest error that passes.
    double tolerance;
};

/// Checks C = alpha A^T A; a wrong C passes with probability at most 2^-rounds. An A with a NaN or
/// an infinity is an error.
template <class T>
verification verify(double alpha, matrix_view<const T> a, matrix_view<const T> c,
                    uplo part = uplo::both, int rounds = 20, std::uint64_t seed = 1) {
    detail::require_square(c, a.cols, a.order);
    const auto order = static_cast<std::int32_t>(a.order);
    const auto triangle = static_cast<std::int32_t>(part);
    std::int32_t passed = 0;
    verification found{};
    const auto check = detail::of_scalar<T>(cata_verify_f64, cata_verify_f32);
    detail::check(check(order, triangle, a.rows, a.cols, alpha, a.data, a.leading, c.data,
                        c.leading, rounds, seed, &passed, &found.residual, &found.tolerance));
    found.passed = passed != 0;
    return found;
}

template <class T>
verification verify(double alpha, matrix_view<T> a, matrix_view<T> c, uplo part = uplo::both,
                    int rounds = 20, std::uint64_t seed = 1) {
    using S = std::remove_const_t<T>;
    return verify<S>(alpha, matrix_view<const S>(a), matrix_view<const S>(c), part, rounds, seed);
}

/// A view of a sparse matrix by rows, which owns no memory: the entries of row i are those from
/// `row_starts[i]` to `row_starts[i + 1] - 1`.
struct sparse_view {
    /// Number of rows.
    std::size_t rows = 0;
    /// rows + 1 positions.
    const std::size_t* row_starts = nullptr;
    /// Column of each entry, ascending within a row.
    const std::size_t* columns = nullptr;
    /// The entries, row by row.
    const double* entries = nullptr;
};

/// A^T W A of a sparse A of `cols` columns, cols x cols, both triangles; no weights: all 1.
inline std::vector<double> ata(const sparse_view& a, std::size_t cols,
                               const std::vector<double>& weights = {}, const options& how = {}) {
    const double* diagonal = weights.empty() ? nullptr : weights.data();
    detail::require(!diagonal || weights.size() == a.rows, CATA_ERR_SHAPE,
                    "weights: must have an element for each row of a");
    std::vector<double> c = detail::square<double>(cols);
    detail::call call(how);
    call.finish(cata_ata_sparse_f64(CATA_ROW_MAJOR, CATA_BOTH, a.rows, cols, 1.0, a.row_starts,
                                    a.columns, a.entries, diagonal, 0.0, c.data(), cols ? cols : 1,
                                    call.params()));
    return c;
}

}  // namespace catamaran

#endif
