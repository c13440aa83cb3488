// Products, least squares, eigenpairs and orthonormal columns over the ranks of an MPI
// communicator. Not part of catamaran.hpp: it needs <mpi.h>.

#ifndef CATAMARAN_MPI_HPP
#define CATAMARAN_MPI_HPP

#if __cplusplus < 201703L
#error "catamaran/mpi.hpp needs C++17: compile with -std=c++17 or later"
#else

#include "../catamaran_mpi.h"
#include "eigs.hpp"
#include "gram.hpp"

#include <memory>
#include <optional>

namespace catamaran {

/// The ranks of a communicator, which is duplicated. All ranks make and destroy it together, before
/// MPI_Finalize.
class world {
public:
    /// Collective over `comm`, between MPI_Init and MPI_Finalize.
    explicit world(MPI_Comm comm) {
        cata_world* made = nullptr;
        detail::check(cata_world_from_comm(comm, &made));
        handle_.reset(made);
    }

    /// Returns the rank of the caller, from 0. Local.
    std::size_t rank() const {
        std::size_t number = 0;
        detail::check(cata_world_rank(handle_.get(), &number));
        return number;
    }

    /// Number of ranks, at least 1. Local.
    std::size_t size() const {
        std::size_t number = 0;
        detail::check(cata_world_size(handle_.get(), &number));
        return number;
    }

    /// What this rank has sent and received since this was made. Local.
    cata_traffic traffic() const {
        cata_traffic found{};
        found.struct_size = sizeof found;
        detail::check(cata_world_traffic(handle_.get(), &found));
        return found;
    }

    /// The handle, owned by this.
    const cata_world* get() const noexcept { return handle_.get(); }

private:
    struct free {
        void operator()(cata_world* handle) const noexcept { cata_world_free(handle); }
    };

    std::unique_ptr<cata_world, free> handle_;
};

namespace detail {

/// The preparations of one rank for a collective call. If they fail, the rank still makes the call,
/// with a leading dimension that it refuses, because the other ranks wait for it.
class preparation {
public:
    /// Requires that arguments fit, and runs `work`, which allocates memory.
    template <class Work>
    preparation(bool fits, const char* message, const Work& work) noexcept {
        try {
            require(fits, CATA_ERR_SHAPE, message);
            work();
        } catch (...) {
            thrown_ = std::current_exception();
        }
    }

    /// A leading dimension for so many elements.
    std::size_t leading(std::size_t elements) const noexcept {
        return thrown_ ? 0 : elements ? elements : 1;
    }

    /// The diagonal of M, unless the call might read it where there is none.
    const double* diagonal(const std::vector<double>& masses) const noexcept {
        return thrown_ || masses.empty() ? nullptr : masses.data();
    }

    /// Throws what the preparations threw, after the call.
    void finish() const {
        if (thrown_) {
            std::rethrow_exception(thrown_);
        }
    }

private:
    std::exception_ptr thrown_;
};

inline bool fit(const std::vector<double>& masses, std::size_t rows) noexcept {
    return masses.empty() || masses.size() == rows;
}

}  // namespace detail

/// A symmetric matrix of doubles that is spread over the ranks of a world.
class symmetric {
public:
    /// Takes a handle of C, which is freed with this object.
    explicit symmetric(cata_symmetric* handle) : handle_(handle) {}

    /// Number of rows and of columns. Local.
    std::size_t n() const {
        std::size_t number = 0;
        detail::check(cata_symmetric_n(handle_.get(), &number));
        return number;
    }

    /// The whole of it on one rank, row-major without gaps; nothing on the others. Collective.
    std::vector<double> gather(const world& ranks, std::size_t root = 0) const {
        const std::size_t size = n();
        std::vector<double> whole;
        const detail::preparation own(true, "", [&] {
            whole = ranks.rank() == root ? detail::square<double>(size) : std::vector<double>();
        });
        const cata_status status =
            cata_symmetric_gather_f64(handle_.get(), ranks.get(), root, CATA_ROW_MAJOR, CATA_BOTH,
                                      whole.data(), own.leading(size));
        own.finish();
        detail::check(status);
        return whole;
    }

    /// The handle, owned by this.
    const cata_symmetric* get() const noexcept { return handle_.get(); }

private:
    struct free {
        void operator()(cata_symmetric* handle) const noexcept { cata_symmetric_free(handle); }
    };

    std::unique_ptr<cata_symmetric, free> handle_;
};

/// alpha A^T A of the rows that the ranks have. Collective: cata_world_ata_rows_f64.
inline symmetric ata_rows(const world& ranks, matrix_view<const double> rows, double alpha = 1.0,
                          const options& how = {}) {
    detail::call call(how);
    cata_symmetric* made = nullptr;
    call.finish(cata_world_ata_rows_f64(ranks.get(), static_cast<std::int32_t>(rows.order),
                                        rows.rows, rows.cols, alpha, rows.data, rows.leading,
                                        call.params(), &made));
    return symmetric(made);
}

/// alpha A^T A of the columns that the ranks have. Collective: cata_world_ata_columns.
inline symmetric ata_columns(const world& ranks, matrix_view<const double> columns,
                             double alpha = 1.0, const options& how = {}) {
    detail::call call(how);
    cata_symmetric* made = nullptr;
    call.finish(cata_world_ata_columns(ranks.get(), static_cast<std::int32_t>(columns.order),
                                       columns.rows, columns.cols, alpha, columns.data,
                                       columns.leading, call.params(), &made));
    return symmetric(made);
}

/// lstsq where `a`, `b` and `weights` are of own rows, with weights on all ranks or on none; every
/// rank gets the whole result, with the same bytes for any number of ranks. Collective:
/// cata_world_lstsq.
inline least_squares lstsq(const world& ranks, matrix_view<const double> a,
                           matrix_view<const double> b, const std::vector<double>& weights = {},
                           const lstsq_options& how = {}) {
    b = detail::in_layout(b, a.order);
    std::optional<detail::lstsq_call> call;
    const detail::preparation own(
        a.rows == b.rows && a.order == b.order && detail::fit(weights, a.rows),
        "b, weights: must have own rows, and b the layout of a",
        [&] { call.emplace(how, a.order, a.cols, b.cols); });
    const cata_status status = cata_world_lstsq(
        ranks.get(), static_cast<std::int32_t>(a.order), a.rows, a.cols, b.cols, a.data,
        own.leading(a.leading), b.data, b.leading, own.diagonal(weights),
        call ? call->x() : nullptr, call ? call->leading() : 0, call ? call->result() : nullptr,
        call ? call->params() : nullptr);
    own.finish();
    return call->finish(status);
}

/// A block-cyclic matrix of doubles, as ScaLAPACK has it.
template <class T>
struct cyclic_view {
    /// The entries on this rank, column-major.
    T* data;
    /// DTYPE_, CTXT_, M_, N_, MB_, NB_, RSRC_, CSRC_, LLD_.
    std::array<std::int32_t, 9> descriptor;
};

/// The grid of the first ranks that block-cyclic matrices are on.
struct process_grid {
    /// Rows of ranks.
    std::size_t rows = 1;
    /// Columns of ranks.
    std::size_t cols = 1;
    /// Whether ranks are numbered along rows or along columns.
    layout order = layout::row_major;
};

/// C := alpha A^T A + beta C of block-cyclic matrices. Collective: cata_world_ata_cyclic.
inline void ata_cyclic(const world& ranks, const process_grid& grid, double alpha,
                       const cyclic_view<const double>& a, double beta,
                       const cyclic_view<double>& c, uplo part = uplo::both,
                       const options& how = {}) {
    detail::call call(how);
    call.finish(cata_world_ata_cyclic(ranks.get(), static_cast<std::int32_t>(part), alpha, a.data,
                                      a.descriptor.data(), beta, c.data, c.descriptor.data(),
                                      grid.rows, grid.cols, static_cast<std::int32_t>(grid.order),
                                      call.params()));
}

/// C := alpha A A^T + beta C of block-cyclic matrices. Collective: cata_world_aat_cyclic.
inline void aat_cyclic(const world& ranks, const process_grid& grid, double alpha,
                       const cyclic_view<const double>& a, double beta,
                       const cyclic_view<double>& c, uplo part = uplo::both,
                       const options& how = {}) {
    detail::call call(how);
    call.finish(cata_world_aat_cyclic(ranks.get(), static_cast<std::int32_t>(part), alpha, a.data,
                                      a.descriptor.data(), beta, c.data, c.descriptor.data(),
                                      grid.rows, grid.cols, static_cast<std::int32_t>(grid.order),
                                      call.params()));
}

/// Eigenpairs, with the own rows of eigenvectors, of a matrix W of n rows of which `w` has own ones
/// and `masses` their masses; empty: all 1. Collective: cata_world_eigs.
inline eigenpairs eigs(const world& ranks, const sparse_view& w, std::size_t n, std::size_t k,
                       std::vector<double> masses = {}, const eigs_options& how = {}) {
    eigenpairs pairs;
    pairs.rows = w.rows;
    const detail::preparation own(detail::fit(masses, w.rows) && k <= n,
                                  "masses, k: must be as many as own rows, at most n", [&] {
                                      pairs.values.resize(k);
                                      pairs.vectors.resize(w.rows * k);
                                      pairs.residuals.resize(k);
                                  });
    detail::eigs_call call(how);
    const cata_status status = cata_world_eigs(
        ranks.get(), w.rows, n, w.row_starts, w.columns, w.entries, own.diagonal(masses), k,
        pairs.values.data(), pairs.vectors.data(), own.leading(w.rows), pairs.residuals.data(),
        call.params());
    own.finish();
    call.finish(status);
    pairs.masses = std::move(masses);
    return pairs;
}

/// gram_schmidt where `a` and `masses` are of own rows. Collective: cata_world_gram_schmidt.
inline factors gram_schmidt(const world& ranks, matrix_view<double> a,
                            const std::vector<double>& masses = {}, const ortho_options& how = {}) {
    std::vector<double> r;
    std::vector<std::size_t> kept;
    const detail::preparation own(detail::fit(masses, a.rows),
                                  "masses: must be as many as own rows", [&] {
                                      r = detail::square<double>(a.cols);
                                      kept.resize(a.cols);
                                  });
    std::size_t rank = 0;
    detail::ortho_call call(how);
    const cata_status status = cata_world_gram_schmidt(
        ranks.get(), static_cast<std::int32_t>(a.order), a.rows, a.cols, a.data,
        own.leading(a.leading), own.diagonal(masses), r.data(), a.cols ? a.cols : 1, kept.data(),
        &rank, call.params());
    own.finish();
    call.finish(status);
    return detail::factors_of(std::move(r), a.cols, a.cols, a.order, std::move(kept), rank);
}

/// cholesky_qr where `a` and `masses` are of own rows. Collective: cata_world_cholesky_qr.
inline std::vector<double> cholesky_qr(const world& ranks, matrix_view<double> a,
                                       const std::vector<double>& masses = {},
                                       const ortho_options& how = {}) {
    std::vector<double> r;
    const detail::preparation own(detail::fit(masses, a.rows),
                                  "masses: must be as many as own rows",
                                  [&] { r = detail::square<double>(a.cols); });
    detail::ortho_call call(how);
    const cata_status status = cata_world_cholesky_qr(
        ranks.get(), static_cast<std::int32_t>(a.order), a.rows, a.cols, a.data,
        own.leading(a.leading), own.diagonal(masses), r.data(), a.cols ? a.cols : 1,
        call.params());
    own.finish();
    call.finish(status);
    return r;
}

}  // namespace catamaran

#endif

#endif
