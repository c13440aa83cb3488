// Least squares, principal components, singular values.

#ifndef CATAMARAN_GRAM_HPP
#define CATAMARAN_GRAM_HPP

#include "core.hpp"

#include <limits>

namespace catamaran {

/// How a Gram matrix in extended precision is computed: the fields of cata_gram_params.
struct gram_options {
    /// 0: all cores of the affinity mask.
    std::size_t threads = 0;
    /// As options::progress.
    std::function<bool(double)> progress;
};

/// How a least-squares problem is solved: the fields of cata_lstsq_params.
struct lstsq_options {
    /// 0: all cores of the affinity mask.
    std::size_t threads = 0;
    double ridge = 0.0;
    /// Whether a constant is fitted for each target too.
    bool intercept = false;
    /// Whether columns that depend on others are an error.
    bool refuse_dependent = false;
    /// As options::progress.
    std::function<bool(double)> progress;
};

/// How principal components are computed: the fields of cata_pca_params.
struct pca_options {
    /// 0: all cores of the affinity mask.
    std::size_t threads = 0;
    /// Whether columns are divided by their standard deviations.
    bool standardize = false;
    /// As options::progress.
    std::function<bool(double)> progress;
};

/// What lstsq finds for n columns and k targets; matrices are in the layout of A without gaps.
struct least_squares {
    /// n x k.
    std::vector<double> coefficients;
    /// n x k.
    std::vector<double> standard_errors;
    /// k each.
    std::vector<double> residual_norms, r_squared, intercepts;
    /// k; none without intercept.
    std::vector<double> intercept_errors;
    /// The columns that depend on others.
    std::vector<std::size_t> dependent;
    std::size_t rank = 0;
    std::size_t degrees_of_freedom = 0;
    double condition = 1.0;
    /// Decimal digits of the coefficients that can be trusted.
    double digits = 0.0;
};

/// What pca finds for n columns.
struct principal_components {
    /// count x n, in the layout of A without gaps.
    std::vector<double> components;
    /// count each.
    std::vector<double> explained_variance, explained_variance_ratio, singular_values;
    /// n each.
    std::vector<double> mean, scale;
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
    /// n x n each, in the layout of A without gaps.
    std::vector<double> high, low;
    /// Whether no entry of A was rounded.
    bool exact = false;
};

/// How far columns are from orthonormal: norms of Q^T Q - I.
struct orthogonality_defect {
    double max = 0.0;
    double frobenius = 0.0;
};

namespace detail {

/// The leading dimension of a rows x cols matrix without gaps.
inline std::size_t tight(layout order, std::size_t rows, std::size_t cols) noexcept {
    const std::size_t line = order == layout::row_major ? cols : rows;
    return line ? line : 1;
}

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

}  // namespace detail

/// The X that minimises |A X - B|^2 + ridge |X|^2, each row with its weight if there are any:
/// cata_lstsq. A is m x n, B is m x k, in the same layout.
inline least_squares lstsq(matrix_view<const double> a, matrix_view<const double> b,
                           const std::vector<double>& weights = {},
                           const lstsq_options& how = {}) {
    detail::require(a.rows == b.rows, CATA_ERR_SHAPE, "b: must have the rows of a");
    detail::require(a.order == b.order, CATA_ERR_ARGUMENT, "b: must have the layout of a");
    const double* weight = detail::weights_of(weights, a.rows);
    const std::size_t n = a.cols, k = b.cols;
    cata_lstsq_params params;
    detail::check(cata_lstsq_params_init(&params, sizeof params));
    params.threads = how.threads;
    params.ridge = how.ridge;
    params.intercept = how.intercept ? 1 : 0;
    params.refuse_dependent = how.refuse_dependent ? 1 : 0;
    detail::watcher watcher(how.progress);
    watcher.attach(params);
    least_squares found;
    found.coefficients.resize(detail::entries(n, k));
    found.standard_errors.resize(n * k);
    for (auto* values : {&found.residual_norms, &found.r_squared, &found.intercepts}) {
        values->resize(k);
    }
    found.intercept_errors.resize(how.intercept ? k : 0);
    found.dependent.resize(n);
    cata_lstsq_result result{};
    result.struct_size = sizeof result;
    result.residual_norms = found.residual_norms.data();
    result.r_squared = found.r_squared.data();
    result.intercepts = found.intercepts.data();
    result.standard_errors = found.standard_errors.data();
    result.intercept_errors = how.intercept ? found.intercept_errors.data() : nullptr;
    result.dependent = found.dependent.data();
    watcher.finish(cata_lstsq(static_cast<std::int32_t>(a.order), a.rows, n, k, a.data,
                                  a.leading, b.data, b.leading, weight,
                                  found.coefficients.data(), detail::tight(a.order, n, k),
                                  &result, &params));
    found.dependent.resize(n - result.rank);
    found.rank = result.rank;
    found.degrees_of_freedom = result.degrees_of_freedom;
    found.condition = result.condition;
    found.digits = result.digits;
    return found;
}

/// The first `count` principal components of the rows of A: cata_pca.
inline principal_components pca(matrix_view<const double> a, std::size_t count,
                                const pca_options& how = {}) {
    // Before there is room for them.
    detail::require(count <= a.cols, CATA_ERR_ARGUMENT, "count: more than columns of a");
    cata_pca_params params;
    detail::check(cata_pca_params_init(&params, sizeof params));
    params.threads = how.threads;
    params.standardize = how.standardize ? 1 : 0;
    detail::watcher watcher(how.progress);
    watcher.attach(params);
    principal_components found;
    found.components.resize(detail::entries(count, a.cols));
    for (auto* values : {&found.explained_variance, &found.explained_variance_ratio,
                         &found.singular_values}) {
        values->resize(count);
    }
    found.mean.resize(a.cols);
    found.scale.resize(a.cols);
    watcher.finish(cata_pca(
        static_cast<std::int32_t>(a.order), a.rows, a.cols, a.data, a.leading, count,
        found.components.data(), detail::tight(a.order, count, a.cols),
        found.explained_variance.data(), found.explained_variance_ratio.data(),
        found.singular_values.data(), found.mean.data(), found.scale.data(), &params));
    return found;
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
                             detail::tight(a.order, a.cols, most), call.params()));
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
