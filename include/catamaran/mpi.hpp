// Products, eigenpairs and orthonormal columns over the ranks of an MPI communicator. Not part of
// catamaran.hpp: it needs <mpi.h>.

#ifndef CATAMARAN_MPI_HPP
#define CATAMARAN_MPI_HPP

#include "../catamaran_mpi.h"
#include "eigs.hpp"

#include <memory>

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

    /// Number of the caller, from 0. Local.
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

/// A symmetric matrix of doubles that is spread over the ranks of a world.
class symmetric {
public:
    /// Takes over a handle from C, which is given back with this.
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
        std::vector<double> whole(ranks.rank() == root ? size * size : 0);
        detail::check(cata_symmetric_gather_f64(handle_.get(), ranks.get(), root, CATA_ROW_MAJOR,
                                                CATA_BOTH, whole.data(), size ? size : 1));
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

namespace detail {

/// What does not fit on one rank goes to the call all the same, with a leading dimension that it
/// refuses, and without masses, which it might read first: the other ranks would wait for ever.
inline bool fit(const std::vector<double>& masses, std::size_t rows) noexcept {
    return masses.empty() || masses.size() == rows;
}
inline std::size_t or_refused(bool fits, std::size_t rows) noexcept {
    return !fits ? 0 : rows ? rows : 1;
}

}  // namespace detail

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

/// Eigenpairs, with the own rows of eigenvectors, of a matrix W of n rows of which `w` has own ones
/// and `masses` their masses; empty: all 1. Collective: cata_world_eigs.
inline eigenpairs eigs(const world& ranks, const sparse_view& w, std::size_t n, std::size_t k,
                       std::vector<double> masses = {}, const eigs_options& how = {}) {
    const bool fits = detail::fit(masses, w.rows) && k <= n;
    eigenpairs pairs;
    pairs.rows = w.rows;
    if (fits) {
        pairs.values.resize(k);
        pairs.vectors.resize(w.rows * k);
        pairs.residuals.resize(k);
    }
    detail::eigs_call call(how);
    const cata_status status = cata_world_eigs(
        ranks.get(), w.rows, n, w.row_starts, w.columns, w.entries,
        fits && !masses.empty() ? masses.data() : nullptr, k, pairs.values.data(),
        pairs.vectors.data(), detail::or_refused(fits, w.rows), pairs.residuals.data(),
        call.params());
    detail::require(fits, CATA_ERR_SHAPE, "masses, k: must be as many as own rows, at most n");
    call.finish(status);
    pairs.masses = std::move(masses);
    return pairs;
}

/// gram_schmidt where `a` and `masses` are of own rows. Collective: cata_world_gram_schmidt.
inline factors gram_schmidt(const world& ranks, matrix_view<double> a,
                            const std::vector<double>& masses = {}, const ortho_options& how = {}) {
    const bool fits = detail::fit(masses, a.rows);
    std::vector<double> r(a.cols * a.cols);
    std::vector<std::size_t> kept(a.cols);
    std::size_t rank = 0;
    detail::ortho_call call(how);
    const cata_status status = cata_world_gram_schmidt(
        ranks.get(), static_cast<std::int32_t>(a.order), a.rows, a.cols, a.data,
        fits ? a.leading : 0, fits && !masses.empty() ? masses.data() : nullptr, r.data(),
        a.cols ? a.cols : 1, kept.data(), &rank, call.params());
    detail::require(fits, CATA_ERR_SHAPE, "masses: must be as many as own rows");
    call.finish(status);
    return detail::factors_of(std::move(r), a.cols, a.cols, a.order, std::move(kept), rank);
}

/// cholesky_qr where `a` and `masses` are of own rows. Collective: cata_world_cholesky_qr.
inline std::vector<double> cholesky_qr(const world& ranks, matrix_view<double> a,
                                       const std::vector<double>& masses = {},
                                       const ortho_options& how = {}) {
    const bool fits = detail::fit(masses, a.rows);
    std::vector<double> r(a.cols * a.cols);
    detail::ortho_call call(how);
    const cata_status status = cata_world_cholesky_qr(
        ranks.get(), static_cast<std::int32_t>(a.order), a.rows, a.cols, a.data,
        fits ? a.leading : 0, fits && !masses.empty() ? masses.data() : nullptr, r.data(),
        a.cols ? a.cols : 1, call.params());
    detail::require(fits, CATA_ERR_SHAPE, "masses: must be as many as own rows");
    call.finish(status);
    return r;
}

}  // namespace catamaran

#endif
