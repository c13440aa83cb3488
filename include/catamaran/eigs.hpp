// Sparse eigenpairs, those of meshes, and orthonormal columns.

#ifndef CATAMARAN_EIGS_HPP
#define CATAMARAN_EIGS_HPP

#include "ata.hpp"

#include <functional>
#include <limits>
#include <optional>
#include <utility>

namespace catamaran {

/// Which triangles the functions are linear on.
enum class laplacian_kind : std::int32_t {
    cotangent = CATA_LAPLACIAN_COTANGENT,
    intrinsic_delaunay = CATA_LAPLACIAN_INTRINSIC_DELAUNAY,
    tufted = CATA_LAPLACIAN_TUFTED,
};

/// How the mass of a triangle goes to its vertices.
enum class mass_kind : std::int32_t {
    barycentric = CATA_MASS_BARYCENTRIC,
    mixed_voronoi = CATA_MASS_MIXED_VORONOI,
    consistent = CATA_MASS_CONSISTENT,
};

/// What holds at the boundary.
enum class boundary : std::int32_t {
    neumann = CATA_BOUNDARY_NEUMANN,
    dirichlet = CATA_BOUNDARY_DIRICHLET,
};

/// How eigenpairs are computed, and of which Laplacian where it is that of a mesh: the fields of
/// cata_eigs_params.
struct eigs_options {
    /// Threads, at most; 0: as many as the process may use (catamaran.h, Threads).
    std::size_t threads = 0;
    /// Restarts, at most; 0: 60.
    std::size_t max_restarts = 0;
    /// Seed of the starting vectors.
    std::uint64_t seed = 0;
    /// Residual that every pair must reach, 1e-14 to 1e-2; 0: 1e-9.
    double tolerance = 0.0;
    /// The eigenvalues nearest to this number; nothing: the smallest.
    std::optional<double> shift;
    /// Whether eigenvalues are counted, by further factorizations, and none is left out.
    bool verify_count = false;
    /// Laplacian of meshes: the triangles on which functions are linear.
    laplacian_kind laplacian = laplacian_kind::cotangent;
    /// Masses of meshes: how the area of a triangle is divided among its vertices.
    mass_kind mass = mass_kind::barycentric;
    /// Condition of functions at the boundary of meshes.
    catamaran::boundary boundary = boundary::neumann;
    /// Progress callback, as options::progress.
    std::function<bool(double)> progress;
};

/// Eigenpairs.
struct eigenpairs {
    /// Entries of an eigenvector.
    std::size_t rows = 0;
    /// Ascending.
    std::vector<double> values;
    /// rows x values.size(), column-major without gaps.
    std::vector<double> vectors;
    /// values.size(): |W phi - lambda M phi| of each pair, relative, as cata_eigs defines it.
    std::vector<double> residuals;
    /// The diagonal of M; empty where it is not a diagonal, or all 1.
    std::vector<double> masses;

    /// The eigenvectors, rows x values.size(), valid as long as this.
    matrix_view<const double> matrix() const& noexcept {
        return col_major(vectors.data(), rows, values.size());
    }
    matrix_view<const double> matrix() const&& = delete;
};

namespace detail {

/// cata_eigs_params for the length of a call.
class eigs_call {
public:
    explicit eigs_call(const eigs_options& options) : watcher_(options.progress) {
        check(cata_eigs_params_init(&params_, sizeof params_));
        params_.threads = options.threads;
        params_.max_restarts = options.max_restarts;
        params_.seed = options.seed;
        params_.tolerance = options.tolerance;
        params_.shift = options.shift.value_or(0.0);
        params_.has_shift = options.shift ? 1 : 0;
        params_.verify_count = options.verify_count ? 1 : 0;
        params_.laplacian = static_cast<std::int32_t>(options.laplacian);
        params_.mass = static_cast<std::int32_t>(options.mass);
        params_.boundary = static_cast<std::int32_t>(options.boundary);
        watcher_.attach(params_);
    }

    const cata_eigs_params* params() const noexcept { return &params_; }

    void finish(cata_status status) { watcher_.finish(status); }

private:
    cata_eigs_params params_{};
    watcher watcher_;
};

inline eigenpairs room_for(std::size_t rows, std::size_t k) {
    // Checked before memory is allocated: k may exceed any memory.
    require(k <= rows, CATA_ERR_ARGUMENT, "k: more eigenpairs than rows");
    require(k == 0 || rows <= std::numeric_limits<std::size_t>::max() / sizeof(double) / k,
            CATA_ERR_SHAPE, "k: the eigenvectors exceed the address space");
    eigenpairs pairs;
    pairs.rows = rows;
    pairs.values.resize(k);
    pairs.vectors.resize(rows * k);
    pairs.residuals.resize(k);
    return pairs;
}

inline const double* masses_of(const std::vector<double>& masses, std::size_t rows) {
    require(masses.empty() || masses.size() == rows, CATA_ERR_SHAPE,
            "masses: must be as many as rows, or none for all 1");
    return masses.empty() ? nullptr : masses.data();
}

}  // namespace detail

/// The k eigenpairs of W phi = lambda M phi that the options ask for; `masses`: the diagonal of M,
/// empty: all 1.
inline eigenpairs eigs(const sparse_view& w, std::size_t k, std::vector<double> masses = {},
                       const eigs_options& how = {}) {
    const double* diagonal = detail::masses_of(masses, w.rows);
    eigenpairs pairs = detail::room_for(w.rows, k);
    detail::eigs_call call(how);
    call.finish(cata_eigs(w.rows, w.row_starts, w.columns, w.entries, diagonal, k,
                          pairs.values.data(), pairs.vectors.data(), w.rows ? w.rows : 1,
                          pairs.residuals.data(), call.params()));
    pairs.masses = std::move(masses);
    return pairs;
}

/// The k smallest eigenpairs of W phi = lambda M phi, approximately, from those of a smaller
/// problem with `coarse` unknowns: cata_eigs_two_level. `p`: P, w.rows x coarse.
inline eigenpairs eigs_two_level(const sparse_view& w, const sparse_view& p, std::size_t coarse,
                                 std::size_t k, std::vector<double> masses = {},
                                 const eigs_options& how = {}) {
    detail::require(p.rows == w.rows, CATA_ERR_SHAPE, "p: must have the rows of w");
    const double* diagonal = detail::masses_of(masses, w.rows);
    eigenpairs pairs = detail::room_for(w.rows, k);
    detail::eigs_call call(how);
    call.finish(cata_eigs_two_level(
        w.rows, w.row_starts, w.columns, w.entries, diagonal, coarse, p.row_starts, p.columns,
        p.entries, k, pairs.values.data(), pairs.vectors.data(), w.rows ? w.rows : 1,
        pairs.residuals.data(), call.params()));
    pairs.masses = std::move(masses);
    return pairs;
}

/// The k eigenpairs of the Laplacian of a triangle mesh.
inline eigenpairs eigs(const mesh_view& mesh, std::size_t k, const eigs_options& how = {}) {
    const std::size_t rows = mesh.n_vertices;
    eigenpairs pairs = detail::room_for(rows, k);
    if (how.mass != mass_kind::consistent) {
        pairs.masses.resize(rows);
    }
    detail::eigs_call call(how);
    call.finish(cata_mesh_eigs(rows, mesh.vertices, mesh.n_faces, mesh.faces, k,
                               pairs.values.data(), pairs.vectors.data(), rows ? rows : 1,
                               pairs.residuals.data(),
                               pairs.masses.empty() ? nullptr : pairs.masses.data(),
                               call.params()));
    return pairs;
}

/// The number of eigenvalues of the Laplacian of a triangle mesh that are 0, one for each component
/// without a vertex that is held at zero: cata_mesh_free_components.
inline std::size_t free_components(const mesh_view& mesh, const eigs_options& how = {}) {
    std::size_t count = 0;
    detail::eigs_call call(how);
    call.finish(cata_mesh_free_components(mesh.n_vertices, mesh.vertices, mesh.n_faces, mesh.faces,
                                          &count, call.params()));
    return count;
}

/// The k smallest eigenvalues of a part of a triangle mesh, ascending: cata_mesh_part_eigenvalues.
/// mask: 1 for each vertex of the part, 0 for each other.
inline std::vector<double> part_eigenvalues(const mesh_view& mesh,
                                            const std::vector<std::uint8_t>& mask, std::size_t k,
                                            const eigs_options& how = {}) {
    detail::require(mask.size() == mesh.n_vertices, CATA_ERR_SHAPE,
                    "mask: must have a value for each vertex");
    // Checked before memory is allocated: k may exceed any memory.
    detail::require(k <= mesh.n_vertices, CATA_ERR_ARGUMENT, "k: more eigenvalues than vertices");
    std::vector<double> values(k);
    detail::eigs_call call(how);
    call.finish(cata_mesh_part_eigenvalues(mesh.n_vertices, mesh.vertices, mesh.n_faces,
                                           mesh.faces, mask.data(), k, values.data(),
                                           call.params()));
    return values;
}

/// The number of eigenvalues of W phi = lambda M phi below `value`: cata_eigs_count.
inline std::size_t count_below(const sparse_view& w, double value,
                               const std::vector<double>& masses = {},
                               const eigs_options& how = {}) {
    std::size_t count = 0;
    detail::eigs_call call(how);
    call.finish(cata_eigs_count(w.rows, w.row_starts, w.columns, w.entries,
                                detail::masses_of(masses, w.rows), value, &count, call.params()));
    return count;
}

/// Some eigenpairs, gone when the call that hands them out returns.
struct eigenpair_slice {
    /// Number of pairs.
    std::size_t count;
    /// count: ascending, within the slice and from slice to slice.
    const double* values;
    /// count: as eigenpairs::residuals.
    const double* residuals;
    /// rows x count.
    matrix_view<const double> vectors;
};

/// Takes a slice; returns whether to go on. What it throws comes out of the call.
using slice_taker = std::function<bool(const eigenpair_slice&)>;

namespace detail {

/// A slice_taker for the length of a call.
class slice_call {
public:
    slice_call(std::size_t rows, const slice_taker& take) : rows_(rows), take_(take) {}

    static std::int32_t slice(std::size_t count, const double* values, const double* vectors,
                              std::size_t ldv, const double* residuals, void* user) noexcept {
        slice_call& self = *static_cast<slice_call*>(user);
        try {
            return self.take_({count, values, residuals,
                               col_major(vectors, self.rows_, count, ldv)})
                       ? 0
                       : 1;
        } catch (...) {
            self.thrown_ = std::current_exception();
            return 1;
        }
    }

    void finish(eigs_call& call, cata_status status) {
        if (thrown_) {
            std::rethrow_exception(thrown_);
        }
        call.finish(status);
    }

private:
    std::size_t rows_;
    const slice_taker& take_;
    std::exception_ptr thrown_;
};

}  // namespace detail

/// The k smallest eigenpairs, in slices for which `memory` bytes are enough: cata_eigs_sliced.
inline void eigs_sliced(const sparse_view& w, std::size_t k, std::size_t memory,
                        const slice_taker& take, const std::vector<double>& masses = {},
                        const eigs_options& how = {}) {
    detail::eigs_call call(how);
    detail::slice_call slices(w.rows, take);
    slices.finish(call, cata_eigs_sliced(w.rows, w.row_starts, w.columns, w.entries,
                                         detail::masses_of(masses, w.rows), k, memory,
                                         &detail::slice_call::slice, &slices, call.params()));
}

/// Those of the Laplacian of a triangle mesh.
inline void eigs_sliced(const mesh_view& mesh, std::size_t k, std::size_t memory,
                        const slice_taker& take, const eigs_options& how = {}) {
    detail::eigs_call call(how);
    detail::slice_call slices(mesh.n_vertices, take);
    slices.finish(call, cata_mesh_eigs_sliced(mesh.n_vertices, mesh.vertices, mesh.n_faces,
                                              mesh.faces, k, memory, &detail::slice_call::slice,
                                              &slices, call.params()));
}

/// How columns, or products, are made orthonormal.
enum class ortho_method : std::int32_t {
    standard = 0,
    reorthogonalized = CATA_ORTHO_REORTHOGONALIZED,
    single_pass = CATA_ORTHO_SINGLE_PASS,
    rank_revealing = CATA_ORTHO_RANK_REVEALING,
};

/// How columns are made orthonormal: the fields of cata_ortho_params.
struct ortho_options {
    /// Threads, at most; 0: as many as the process may use (catamaran.h, Threads).
    std::size_t threads = 0;
    /// 0: 1e-9, or 1e-2 with ortho_method::single_pass.
    double threshold = 0.0;
    /// How often columns are projected, and which ones are kept; standard: reorthogonalized.
    ortho_method method = ortho_method::standard;
    /// Progress callback, as options::progress.
    std::function<bool(double)> progress;
};

/// What gram_schmidt leaves beside Q.
struct factors {
    /// kept.size() x columns of A, in the layout of A without gaps: coefficients of every column.
    std::vector<double> r;
    /// The columns of A that Q is made of, ascending.
    std::vector<std::size_t> kept;
};

namespace detail {

/// cata_ortho_params for the length of a call.
class ortho_call {
public:
    explicit ortho_call(const ortho_options& options) : watcher_(options.progress) {
        check(cata_ortho_params_init(&params_, sizeof params_));
        params_.threads = options.threads;
        params_.threshold = options.threshold;
        params_.method = static_cast<std::int32_t>(options.method);
        watcher_.attach(params_);
    }

    const cata_ortho_params* params() const noexcept { return &params_; }

    void finish(cata_status status) { watcher_.finish(status); }

private:
    cata_ortho_params params_{};
    watcher watcher_;
};

/// R in the first rows of `most` x cols, and the columns kept, as factors.
inline factors factors_of(std::vector<double> r, std::size_t most, std::size_t cols, layout order,
                          std::vector<std::size_t> kept, std::size_t rank) {
    kept.resize(rank);
    if (order == layout::col_major) {
        // Rows below the rank are zeros.
        for (std::size_t j = 0; j < cols; ++j) {
            for (std::size_t i = 0; i < rank; ++i) {
                r[i + j * rank] = r[i + j * most];
            }
        }
    }
    r.resize(rank * cols);
    return {std::move(r), std::move(kept)};
}

}  // namespace detail

/// A = Q R with Q^T M Q = I: the first kept.size() columns of `a` are Q afterwards. `masses`: the
/// diagonal of M, empty: all 1.
inline factors gram_schmidt(matrix_view<double> a, const std::vector<double>& masses = {},
                            const ortho_options& how = {}) {
    const double* diagonal = detail::masses_of(masses, a.rows);
    const std::size_t most = a.rows < a.cols ? a.rows : a.cols;
    std::vector<double> r(most * a.cols);
    std::vector<std::size_t> kept(a.cols);
    std::size_t rank = 0;
    detail::ortho_call call(how);
    call.finish(cata_ortho_gram_schmidt(
        static_cast<std::int32_t>(a.order), a.rows, a.cols, a.data, a.leading, diagonal, r.data(),
        detail::gapless(a.order, most, a.cols), kept.data(), &rank, call.params()));
    return detail::factors_of(std::move(r), most, a.cols, a.order, std::move(kept), rank);
}

/// A = Q R with Q^T M Q = I for independent columns: `a` becomes Q, and R, in the layout of A
/// without gaps, is returned: cata_ortho_cholesky_qr.
inline std::vector<double> cholesky_qr(matrix_view<double> a,
                                       const std::vector<double>& masses = {},
                                       const ortho_options& how = {}) {
    const double* diagonal = detail::masses_of(masses, a.rows);
    // More columns than rows are dependent. Checked before R, cols x cols, is allocated.
    detail::require(a.cols <= a.rows, CATA_ERR_ARGUMENT, "A: more columns than rows");
    std::vector<double> r(a.cols * a.cols);
    detail::ortho_call call(how);
    call.finish(cata_ortho_cholesky_qr(static_cast<std::int32_t>(a.order), a.rows, a.cols, a.data,
                                       a.leading, diagonal, r.data(), a.cols ? a.cols : 1,
                                       call.params()));
    return r;
}

}  // namespace catamaran

#endif
