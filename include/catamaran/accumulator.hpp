// Sums of rows that come in blocks, and what follows from them.

#ifndef CATAMARAN_ACCUMULATOR_HPP
#define CATAMARAN_ACCUMULATOR_HPP

#include "gram.hpp"

#include <memory>
#include <string>

namespace catamaran {

/// What an accumulator adds up.
enum class sums : std::int32_t {
    floating = CATA_SUMS_FLOAT,
    exact = CATA_SUMS_EXACT,
    extended = CATA_SUMS_EXTENDED,
};

/// What an accumulator adds, and how: the fields of cata_accumulator_params.
struct accumulator_options {
    /// Threads, at most; 0: as many as the process may use (catamaran.h, Threads).
    std::size_t threads = 0;
    /// What is added up.
    catamaran::sums sums = sums::floating;
    /// Whether products are about the mean of the rows; else about 0.
    bool centered = false;
    /// Lower bound of the entries of each column; not read for floating sums.
    std::vector<double> lower;
    /// Upper bound of the entries of each column; not read for floating sums.
    std::vector<double> upper;
    /// Most rows; not read for floating sums.
    std::uint64_t rows = 0;
    /// Largest weight; 0: rows have no weights. Not read for floating sums.
    double largest_weight = 0.0;
    /// Progress callback, as options::progress; of each call that adds rows or removes them.
    std::function<bool(double)> progress;
};

/// X^T W X of rows X that come in blocks: cata_accumulator. One owner.
class accumulator {
public:
    /// Creates an accumulator of n columns, without rows.
    explicit accumulator(std::size_t n, const accumulator_options& how = {})
        : watcher_(how.progress), columns_(n) {
        const bool bounded = how.sums != sums::floating;
        detail::require(!bounded || (how.lower.size() == n && how.upper.size() == n),
                        CATA_ERR_SHAPE, "lower, upper: must be one for each column");
        cata_accumulator_params params = detail_params(how.threads);
        params.lower = how.lower.data();
        params.upper = how.upper.data();
        params.rows = how.rows;
        params.largest_weight = how.largest_weight;
        params.sums = static_cast<std::int32_t>(how.sums);
        params.centered = how.centered ? 1 : 0;
        cata_accumulator* made = nullptr;
        detail::check(cata_accumulator_new(n, &params, &made));
        handle_.reset(made);
    }

    /// Adds the rows of A, with their weights if there are any.
    void add(matrix_view<const double> a, const std::vector<double>& weights = {}) {
        check_columns(a);
        watcher_.finish(cata_accumulator_add(handle_.get(), static_cast<std::int32_t>(a.order),
                                             a.rows, a.data, a.leading,
                                             detail::weights_of(weights, a.rows)));
    }

    /// Removes rows that were added.
    void remove(matrix_view<const double> a, const std::vector<double>& weights = {}) {
        check_columns(a);
        watcher_.finish(cata_accumulator_remove(handle_.get(), static_cast<std::int32_t>(a.order),
                                                a.rows, a.data, a.leading,
                                                detail::weights_of(weights, a.rows)));
    }

    /// Adds the rows of a file: NAME.npy, or NAME.h5:/dataset.
    void add_file(const std::string& path) {
        watcher_.finish(cata_accumulator_add_file(handle_.get(), path.c_str()));
    }

    /// Adds the rows of another one.
    void merge(const accumulator& other) {
        detail::check(cata_accumulator_merge(handle_.get(), other.handle_.get()));
    }

    /// Writes the sums to a file, from which load continues.
    void save(const std::string& path) const {
        detail::check(cata_accumulator_write(handle_.get(), path.c_str()));
    }

    /// The accumulator of n columns of a file of save.
    static accumulator load(const std::string& path, std::size_t n, std::size_t threads = 0,
                            const std::function<bool(double)>& progress = {}) {
        accumulator read(n, progress);
        const cata_accumulator_params params = read.detail_params(threads);
        cata_accumulator* made = nullptr;
        detail::check(cata_accumulator_read(path.c_str(), &params, &made));
        read.handle_.reset(made);
        return read;
    }

    /// The rows so far.
    std::uint64_t rows() const {
        std::uint64_t rows = 0;
        detail::check(cata_accumulator_rows(handle_.get(), &rows, nullptr, nullptr));
        return rows;
    }

    /// The mean of each column; zeros unless it is centred.
    std::vector<double> mean() const {
        std::vector<double> mean(columns_);
        detail::check(cata_accumulator_rows(handle_.get(), nullptr, nullptr, mean.data()));
        return mean;
    }

    /// alpha X^T W X, n x n, both triangles.
    std::vector<double> gram(double alpha = 1.0) const {
        std::vector<double> c(detail::entries(columns_, columns_));
        detail::check(cata_accumulator_gram(handle_.get(), CATA_ROW_MAJOR, CATA_BOTH, alpha,
                                            c.data(), columns_ ? columns_ : 1));
        return c;
    }

    /// Least squares with the last k columns as targets; matrices are row-major.
    least_squares lstsq(std::size_t k, const lstsq_options& how = {}) const {
        detail::require(k <= columns_, CATA_ERR_ARGUMENT, "k: more targets than columns");
        detail::lstsq_call call(how, layout::row_major, columns_ - k, k);
        return call.finish(cata_accumulator_lstsq(handle_.get(), k, CATA_ROW_MAJOR, call.x(),
                                                  call.leading(), call.result(), call.params()));
    }

    /// The first `count` principal components; row-major.
    principal_components pca(std::size_t count, const pca_options& how = {}) const {
        detail::pca_call call(how, layout::row_major, columns_, count);
        principal_components& found = call.found;
        return call.finish(cata_accumulator_pca(
            handle_.get(), CATA_ROW_MAJOR, count, found.components.data(), call.leading(),
            found.explained_variance.data(), found.explained_variance_ratio.data(),
            found.singular_values.data(), found.mean.data(), found.scale.data(), call.params()));
    }

private:
    struct free {
        void operator()(cata_accumulator* handle) const noexcept { cata_accumulator_free(handle); }
    };

    accumulator(std::size_t n, const std::function<bool(double)>& progress)
        : watcher_(progress), columns_(n) {}

    cata_accumulator_params detail_params(std::size_t threads) {
        cata_accumulator_params params;
        detail::check(cata_accumulator_params_init(&params, sizeof params));
        params.threads = threads;
        watcher_.attach(params);
        return params;
    }

    void check_columns(matrix_view<const double> a) const {
        detail::require(a.cols == columns_, CATA_ERR_SHAPE, "a: must have the columns of the sums");
    }

    detail::kept_watcher watcher_;
    std::unique_ptr<cata_accumulator, free> handle_;
    std::size_t columns_;
};

}  // namespace catamaran

#endif
