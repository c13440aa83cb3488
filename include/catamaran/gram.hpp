// Least squares, principal components, singular values.

#ifndef CATAMARAN_GRAM_HPP
#define CATAMARAN_GRAM_HPP

#include "core.hpp"

#include <limits>
#include <utility>

namespace catamaran {

/// How a Gram matrix in extended precision is computed: the fields of cata_gram_params.
struct gram_options {
    /// Threads, at most; 0: as many as the process may use (catamaran.h, Threads).
    std::size_t threads = 0;
    /// Progress callback, as options::progress.
    std::function<bool(double)> progress;
};

/// How a least-squares problem is solved: the fields of cata_lstsq_params but confidence.
struct lstsq_options {
    /// Threads, at most; 0: as many as the process may use (catamaran.h, Threads).
    std::size_t threads = 0;
    /// Multiple of |X|^2 that is added.
    double ridge = 0.0;
    /// Whether a constant is fitted for each target too.
    bool intercept = false;
    /// Whether columns that depend on others are an error.
    bool refuse_dependent = false;
    /// Progress callback, as options::progress.
    std::function<bool(double)> progress;
};

/// How principal components are computed: the fields of cata_pca_params.
struct pca_options {
    /// Threads, at most; 0: as many as the process may use (catamaran.h, Threads).
    std::size_t threads = 0;
    /// Whether columns are divided by their standard deviations.
    bool standardize = false;
    /// Progress callback, as options::progress.
    std::function<bool(double)> progress;
};

/// What lstsq finds for n columns and k targets; matrices are in the layout of A without gaps.
struct least_squares {
    /// n x k.
    std::vector<double> coefficients;
    /// n x k.
    std::vector<double> standard_errors;
    /// n x k: the p value of each coefficient.
    std::vector<double> p_values;
    /// k: |A x - b| of each target.
    std::vector<double> residual_norms;
    /// k: 1 - |A x - b|^2 / |b|^2 of each target.
    std::vector<double> r_squared;
    /// k: zeros without intercept.
    std::vector<double> intercepts;
    /// k; none without intercept.
    std::vector<double> intercept_errors;
    /// k; none without intercept.
    std::vector<double> intercept_p_values;
    /// k: the standard deviation of the residuals of each target.
    std::vector<double> residual_deviations;
    /// k: r_squared, adjusted for the number of coefficients.
    std::vector<double> adjusted_r_squared;
    /// k: that all coefficients but the constant are 0.
    std::vector<double> f_statistics;
    /// k: the p value of each F statistic.
    std::vector<double> f_p_values;
    /// The columns that depend on others.
    std::vector<std::size_t> dependent;
    /// Columns that do not depend on others.
    std::size_t rank = 0;
    /// Rows whose weight is not 0.
    std::size_t observations = 0;
    /// Observations less the rank, and less one more with intercept.
    std::size_t degrees_of_freedom = 0;
    /// An estimate of the condition number of A.
    double condition = 1.0;
    /// Decimal digits of the coefficients that can be trusted.
    double digits = 0.0;
};

/// What pca finds for n columns.
struct principal_components {
    /// count x n, in the layout of A without gaps.
    std::vector<double> components;
    /// count: along each component.
    std::vector<double> explained_variance;
    /// count: divided by the variance of all columns.
    std::vector<double> explained_variance_ratio;
    /// count: of the centred (and standardized) rows.
    std::vector<double> singular_values;
    /// n: of each column.
    std::vector<double> mean;
    /// n: the divisor of each column.
    std::vector<double> scale;
};

/// What svd finds of A (m x n).
struct singular_value_decomposition {
    /// min(m, n), descending.
    std::vector<double> values;
    /// n x min(m, n), in the layout of A without gaps.
    std::vector<double> v;
};

/// The lower triangle of a matrix in two parts, high + low; zeros above.
struct extended_gram {
    /// n x n, in the layout of A without gaps.
    std::vector<double> high;
    /// n x n, in the layout of A without gaps: what rounding took from high.
    std::vector<double> low;
    /// Whether no entry of A was rounded.
    bool exact = false;
};

/// How far columns are from orthonormal: norms of Q^T Q - I.
struct orthogonality_defect {
    /// The largest entry by size.
    double max = 0.0;
    /// The Frobenius norm.
    double frobenius = 0.0;
};

namespace detail {

/// The number of entries of a matrix whose rows there may be no memory for.
inline std::size_t entries(std::size_t rows, std::size_t cols) {
    require(cols == 0 || rows <= std::numeric_limits<std::size_t>::max() / cols, CATA_ERR_SHAPE,
            "a: the result exceeds the address space");
    return rows * cols;
}

/// The weights of `rows` rows; null when there are none.
inline const double* weights_of(const std::vector<double>& weights, std::size_t rows) {
    require(weights.empty() || weights.size() == rows, CATA_ERR_SHAPE,
            "weights: must be as many as rows");
    return weights.empty() ? nullptr : weights.data();
}

/// cata_gram_params for the length of a call.
class gram_call {
public:
    explicit gram_call(const gram_options& options) : watcher_(options.progress) {
        check(cata_gram_params_init(&params_, sizeof params_));
        params_.threads = options.threads;
        watcher_.attach(params_);
    }

    const cata_gram_params* params() const noexcept { return &params_; }

    void finish(cata_status status) { watcher_.finish(status); }

private:
    cata_gram_params params_{};
    watcher watcher_;
};

/// A column whose entries are neighbours, in either layout; anything else as it is.
inline matrix_view<const double> in_layout(matrix_view<const double> b, layout order) noexcept {
    if (b.order == order || b.cols != 1) {
        return b;
    }
    if (order == layout::row_major) {
        return row_major(b.data, b.rows, 1);
    }
    return b.leading == 1 ? col_major(b.data, b.rows, 1) : b;
}

/// A call for least squares of n columns and k targets, in matrices of this layout without gaps.
class lstsq_call {
public:
    lstsq_call(const lstsq_options& how, layout order, std::size_t n, std::size_t k)
        : watcher_(how.progress), columns_(n), leading_(gapless(order, n, k)) {
        check(cata_lstsq_params_init(&params_, sizeof params_));
        params_.threads = how.threads;
        params_.ridge = how.ridge;
        params_.intercept = how.intercept ? 1 : 0;
        params_.refuse_dependent = how.refuse_dependent ? 1 : 0;
        watcher_.attach(params_);
        found_.coefficients.resize(entries(n, k));
        found_.standard_errors.resize(n * k);
        found_.p_values.resize(n * k);
        for (auto* values : {&found_.residual_norms, &found_.r_squared, &found_.intercepts,
                             &found_.residual_deviations, &found_.adjusted_r_squared,
                             &found_.f_statistics, &found_.f_p_values}) {
            values->resize(k);
        }
        found_.intercept_errors.resize(how.intercept ? k : 0);
        found_.intercept_p_values.resize(how.intercept ? k : 0);
        found_.dependent.resize(n);
        result_.struct_size = sizeof result_;
        result_.residual_norms = found_.residual_norms.data();
        result_.r_squared = found_.r_squared.data();
        result_.intercepts = found_.intercepts.data();
        result_.standard_errors = found_.standard_errors.data();
        result_.intercept_errors = how.intercept ? found_.intercept_errors.data() : nullptr;
        result_.dependent = found_.dependent.data();
        result_.p_values = found_.p_values.data();
        result_.intercept_p_values = how.intercept ? found_.intercept_p_values.data() : nullptr;
        result_.residual_deviations = found_.residual_deviations.data();
        result_.adjusted_r_squared = found_.adjusted_r_squared.data();
        result_.f_statistics = found_.f_statistics.data();
        result_.f_p_values = found_.f_p_values.data();
        result_.observations = &observations_;
    }

    double* x() noexcept { return found_.coefficients.data(); }
    std::size_t leading() const noexcept { return leading_; }
    cata_lstsq_result* result() noexcept { return &result_; }
    const cata_lstsq_params* params() const noexcept { return &params_; }

    least_squares finish(cata_status status) {
        watcher_.finish(status);
        found_.dependent.resize(columns_ - result_.rank);
        found_.rank = result_.rank;
        found_.observations = observations_;
        found_.degrees_of_freedom = result_.degrees_of_freedom;
        found_.condition = result_.condition;
        found_.digits = result_.digits;
        return std::move(found_);
    }

private:
    cata_lstsq_params params_{};
    cata_lstsq_result result_{};
    watcher watcher_;
    least_squares found_;
    std::size_t observations_ = 0;
    std::size_t columns_;
    std::size_t leading_;
};

/// A call for `count` principal components of n columns, in a matrix of this layout without gaps.
class pca_call {
public:
    pca_call(const pca_options& how, layout order, std::size_t n, std::size_t count)
        : watcher_(how.progress), leading_(gapless(order, count, n)) {
        // Before there is room for them.
        require(count <= n, CATA_ERR_ARGUMENT, "count: more than columns of a");
        check(cata_pca_params_init(&params_, sizeof params_));
        params_.threads = how.threads;
        params_.standardize = how.standardize ? 1 : 0;
        watcher_.attach(params_);
        found.components.resize(entries(count, n));
        for (auto* values : {&found.explained_variance, &found.explained_variance_ratio,
                             &found.singular_values}) {
            values->resize(count);
        }
        found.mean.resize(n);
        found.scale.resize(n);
    }

    std::size_t leading() const noexcept { return leading_; }
    const cata_pca_params* params() const noexcept { return &params_; }

    principal_components finish(cata_status status) {
        watcher_.finish(status);
        return std::move(found);
    }

private:
    cata_pca_params params_{};
    watcher watcher_;
    std::size_t leading_;

public:
    principal_components found;
};

}  // namespace detail

/// The X that minimizes |A X - B|^2 + ridge |X|^2, each row with its weight if there are any:
/// cata_lstsq. A is m x n, B is m x k, in the same layout, which a vector has either way.
inline least_squares lstsq(matrix_view<const double> a, matrix_view<const double> b,
                           const std::vector<double>& weights = {},
                           const lstsq_options& how = {}) {
    b = detail::in_layout(b, a.order);
    detail::require(a.rows == b.rows, CATA_ERR_SHAPE, "b: must have the rows of a");
    detail::require(a.order == b.order, CATA_ERR_ARGUMENT, "b: must have the layout of a");
    const double* weight = detail::weights_of(weights, a.rows);
    detail::lstsq_call call(how, a.order, a.cols, b.cols);
    return call.finish(cata_lstsq(static_cast<std::int32_t>(a.order), a.rows, a.cols, b.cols,
                                  a.data, a.leading, b.data, b.leading, weight, call.x(),
                                  call.leading(), call.result(), call.params()));
}

/// The first `count` principal components of the rows of A: cata_pca.
inline principal_components pca(matrix_view<const double> a, std::size_t count,
                                const pca_options& how = {}) {
    detail::pca_call call(how, a.order, a.cols, count);
    principal_components& found = call.found;
    return call.finish(cata_pca(static_cast<std::int32_t>(a.order), a.rows, a.cols, a.data,
                                a.leading, count, found.components.data(), call.leading(),
                                found.explained_variance.data(),
                                found.explained_variance_ratio.data(),
                                found.singular_values.data(), found.mean.data(),
                                found.scale.data(), call.params()));
}

/// The singular values and right singular vectors of A: cata_svd.
inline singular_value_decomposition svd(matrix_view<const double> a,
                                        const gram_options& how = {}) {
    const std::size_t most = a.rows < a.cols ? a.rows : a.cols;
    singular_value_decomposition found;
    found.values.resize(most);
    found.v.resize(detail::entries(a.cols, most));
    detail::gram_call call(how);
    call.finish(cata_svd(static_cast<std::int32_t>(a.order), a.rows, a.cols, a.data, a.leading,
                             found.values.data(), found.v.data(),
                             detail::gapless(a.order, a.cols, most), call.params()));
    return found;
}

/// A^T W A, of A less its mean row if `centered`, in two parts: cata_gram_extended.
inline extended_gram gram_extended(matrix_view<const double> a,
                                   const std::vector<double>& weights = {}, bool centered = false,
                                   const gram_options& how = {}) {
    const double* weight = detail::weights_of(weights, a.rows);
    const std::size_t n = a.cols, leading = n ? n : 1;
    extended_gram found;
    found.high.resize(detail::entries(n, n));
    found.low.resize(n * n);
    std::int32_t exact = 0;
    detail::gram_call call(how);
    call.finish(cata_gram_extended(
        static_cast<std::int32_t>(a.order), a.rows, n, a.data, a.leading, weight,
        centered ? CATA_CENTER_MEAN : CATA_CENTER_NONE, found.high.data(), leading,
        found.low.data(), leading, &exact, call.params()));
    found.exact = exact != 0;
    return found;
}

/// The correlation matrix of the columns of A, n x n without gaps: cata_gram_correlation.
inline std::vector<double> correlation(matrix_view<const double> a, const gram_options& how = {}) {
    std::vector<double> c(detail::entries(a.cols, a.cols));
    detail::gram_call call(how);
    call.finish(cata_gram_correlation(static_cast<std::int32_t>(a.order), a.rows, a.cols, a.data,
                                     a.leading, c.data(), a.cols ? a.cols : 1, call.params()));
    return c;
}

/// How far the columns of Q are from orthonormal: cata_gram_orthogonality.
inline orthogonality_defect orthogonality(matrix_view<const double> q,
                                          const gram_options& how = {}) {
    orthogonality_defect found;
    detail::gram_call call(how);
    call.finish(cata_gram_orthogonality(static_cast<std::int32_t>(q.order), q.rows, q.cols, q.data,
                                       q.leading, &found.max, &found.frobenius, call.params()));
    return found;
}

/// A = Q R for independent columns: `a` becomes Q, and R, n x n in the layout of A without gaps,
/// is returned: cata_gram_cholesky_qr.
inline std::vector<double> cholesky_qr_extended(matrix_view<double> a,
                                                const gram_options& how = {}) {
    std::vector<double> r(detail::entries(a.cols, a.cols));
    detail::gram_call call(how);
    call.finish(cata_gram_cholesky_qr(static_cast<std::int32_t>(a.order), a.rows, a.cols,
                                              a.data, a.leading, r.data(), a.cols ? a.cols : 1,
                                              call.params()));
    return r;
}

}  // namespace catamaran

#endif
