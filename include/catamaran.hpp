// Catamaran from C++17: RAII and exceptions over catamaran.h, header only.
//
// Nothing here adds a rule of its own: see catamaran.h for what the functions compute and promise.

#ifndef CATAMARAN_HPP
#define CATAMARAN_HPP

#include "catamaran.h"

#include <array>
#include <complex>
#include <cstddef>
#include <cstdint>
#include <exception>
#include <functional>
#include <limits>
#include <memory>
#include <optional>
#include <stdexcept>
#include <string>
#include <type_traits>
#include <utility>
#include <vector>

namespace catamaran {

/// A call failed: what() is the library's message.
class error : public std::runtime_error {
public:
    error(cata_status status, const std::string& message)
        : std::runtime_error(message), status_(status) {}

    /// One of CATA_ERR_*.
    cata_status status() const noexcept { return status_; }

private:
    cata_status status_;
};

/// How a matrix lies in memory.
enum class layout : std::int32_t { row_major = CATA_ROW_MAJOR, col_major = CATA_COL_MAJOR };

/// Which part of a symmetric result is wanted.
enum class uplo : std::int32_t { upper = CATA_UPPER, lower = CATA_LOWER, both = CATA_BOTH };

/// Which recursion to run.
enum class scheme : std::int32_t {
    automatic = CATA_SCHEME_AUTO,
    classical = CATA_SCHEME_CLASSICAL,
    ata2 = CATA_SCHEME_ATA2,
    winograd = CATA_SCHEME_WINOGRAD,
    rxtx = CATA_SCHEME_RXTX,
    kgp4 = CATA_SCHEME_KGP4,
    kgp3 = CATA_SCHEME_KGP3,
    exact = CATA_SCHEME_EXACT,
    floating = CATA_SCHEME_FLOAT,
};

/// A matrix that somebody else owns.
template <class T>
struct matrix_view {
    T* data = nullptr;
    std::size_t rows = 0;
    std::size_t cols = 0;
    /// Elements from one row (row-major) or column (column-major) to the next.
    std::size_t leading = 1;
    catamaran::layout order = layout::row_major;

    /// A view that may be written is one that may be read.
    operator matrix_view<const T>() const noexcept { return {data, rows, cols, leading, order}; }

    T& operator()(std::size_t i, std::size_t j) const noexcept {
        return order == layout::row_major ? data[i * leading + j] : data[i + j * leading];
    }
};

/// rows x cols with contiguous rows, `leading` elements apart (0: no gap).
template <class T>
matrix_view<T> row_major(T* data, std::size_t rows, std::size_t cols, std::size_t leading = 0) {
    return {data, rows, cols, leading ? leading : (cols ? cols : 1), layout::row_major};
}

/// rows x cols with contiguous columns, `leading` elements apart (0: no gap).
template <class T>
matrix_view<T> col_major(T* data, std::size_t rows, std::size_t cols, std::size_t leading = 0) {
    return {data, rows, cols, leading ? leading : (rows ? rows : 1), layout::col_major};
}

namespace detail {

inline void check(cata_status status) {
    if (status != CATA_OK) {
        throw error(status, cata_last_error_message());
    }
}

inline void require(bool condition, cata_status status, const char* message) {
    if (!condition) {
        throw error(status, message);
    }
}

/// The numbers of rows of equal length, one row after the other; null when there are none.
template <class Rows>
auto* first_of(Rows& rows) noexcept {
    return rows.empty() ? nullptr : rows.front().data();
}

/// T where it must not take part in deducing the scalar.
template <class T>
struct identity {
    using type = T;
};
template <class T>
using identity_t = typename identity<T>::type;

template <class T>
constexpr void require_scalar() {
    static_assert(std::is_same<T, float>::value || std::is_same<T, double>::value,
                  "catamaran computes in float or double");
}

}  // namespace detail

/// A BLAS library that computes the small products. Movable, not copyable.
class backend {
public:
    /// Loads a shared library with the CBLAS interface.
    static backend load(const std::string& path) {
        cata_backend* handle = nullptr;
        detail::check(cata_backend_load(path.c_str(), &handle));
        return backend(handle);
    }

    /// The OpenBLAS that the library was linked with; throws without CATA_CAP_OPENBLAS.
    static backend openblas() {
        cata_backend* handle = nullptr;
        detail::check(cata_backend_openblas(&handle));
        return backend(handle);
    }

    std::string name() const { return cata_backend_name(handle_.get()); }

    const cata_backend* get() const noexcept { return handle_.get(); }

private:
    struct free {
        void operator()(cata_backend* handle) const noexcept { cata_backend_free(handle); }
    };

    explicit backend(cata_backend* handle) noexcept : handle_(handle) {}

    std::unique_ptr<cata_backend, free> handle_;
};

/// How a product is computed: the fields of cata_ata_params.
struct options {
    /// 0: all cores of the affinity mask.
    std::size_t threads = 0;
    catamaran::scheme scheme = scheme::automatic;
    /// 0: the default; 1: classical products only; infinity: no bound; CATA_ERROR_LEAST: the least.
    double error_factor = 0.0;
    /// The same bytes on every machine: scheme::exact everywhere, and no other may be asked for.
    bool reproducible = false;
    /// Thread i stays on the i-th core of the affinity mask of the process.
    bool pin = false;
    /// 0: chosen by the library.
    std::size_t leaf = 0;
    /// 0: chosen by the library.
    std::size_t tasks = 0;
    /// Null: the built-in one. Must outlive the call.
    const catamaran::backend* backend = nullptr;
    /// Told the fraction done; returns whether to go on. It is called from any thread that works for
    /// the call, one call at a time, each after the one before it has returned. It may be slow, and may
    /// call this library. What it throws stops the work and comes out of the call.
    std::function<bool(double)> progress;
};

namespace detail {

/// A progress callback for the length of a call; carries an exception of it across the call.
class watcher {
public:
    explicit watcher(const std::function<bool(double)>& progress) : progress_(progress) {}
    watcher(const watcher&) = delete;
    watcher& operator=(const watcher&) = delete;

    template <class Params>
    void attach(Params& params) {
        if (progress_) {
            params.progress = &report;
            params.progress_user = this;
        }
    }

    void finish(cata_status status) {
        if (thrown_) {
            std::rethrow_exception(thrown_);
        }
        check(status);
    }

private:
    static std::int32_t report(double fraction, void* user) noexcept {
        watcher& self = *static_cast<watcher*>(user);
        if (self.thrown_) {
            return 1;
        }
        try {
            return self.progress_(fraction) ? 0 : 1;
        } catch (...) {
            self.thrown_ = std::current_exception();
            return 1;
        }
    }

    const std::function<bool(double)>& progress_;
    std::exception_ptr thrown_;
};

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
void require_square(matrix_view<T> c, std::size_t n, layout order) {
    require(c.rows == n && c.cols == n, CATA_ERR_SHAPE, "c: must be square, of the columns of a");
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
    detail::require_scalar<T>();
    detail::require_square(c, a.cols, a.order);
    detail::call call(how);
    const auto order = static_cast<std::int32_t>(a.order);
    const auto triangle = static_cast<std::int32_t>(part);
    if constexpr (std::is_same<T, double>::value) {
        call.finish(cata_ata_f64(order, triangle, a.rows, a.cols, alpha, a.data, a.leading, beta,
                                 c.data, c.leading, call.params()));
    } else {
        call.finish(cata_ata_f32(order, triangle, a.rows, a.cols, alpha, a.data, a.leading, beta,
                                 c.data, c.leading, call.params()));
    }
}

template <class T>
void ata(detail::identity_t<T> alpha, matrix_view<T> a, detail::identity_t<T> beta,
         matrix_view<T> c, uplo part = uplo::both, const options& how = {}) {
    ata<T>(alpha, matrix_view<const T>(a), beta, c, part, how);
}

/// A^T A, n x n without gaps, in the layout of A; both triangles.
template <class T>
std::vector<std::remove_const_t<T>> ata(matrix_view<T> a, const options& how = {}) {
    using S = std::remove_const_t<T>;
    detail::require(a.cols == 0 || a.cols <= std::numeric_limits<std::size_t>::max() / a.cols,
                    CATA_ERR_SHAPE, "a: the product exceeds the address space");
    std::vector<S> c(a.cols * a.cols);
    const matrix_view<S> view{c.data(), a.cols, a.cols, a.cols ? a.cols : 1, a.order};
    ata<S>(S(1), matrix_view<const S>(a), S(0), view, uplo::both, how);
    return c;
}

/// C := alpha A^T B + beta C. A is m x n, B is m x k, C is n x k, in the same layout.
template <class T>
void atb(detail::identity_t<T> alpha, matrix_view<const T> a, matrix_view<const T> b,
         detail::identity_t<T> beta, matrix_view<T> c, const options& how = {}) {
    detail::require_scalar<T>();
    detail::require_general(a, b, c);
    detail::call call(how);
    const auto order = static_cast<std::int32_t>(a.order);
    if constexpr (std::is_same<T, double>::value) {
        call.finish(cata_atb_f64(order, a.rows, a.cols, b.cols, alpha, a.data, a.leading, b.data,
                                 b.leading, beta, c.data, c.leading, call.params()));
    } else {
        call.finish(cata_atb_f32(order, a.rows, a.cols, b.cols, alpha, a.data, a.leading, b.data,
                                 b.leading, beta, c.data, c.leading, call.params()));
    }
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
    detail::require_scalar<T>();
    detail::require_square(c, a.cols, a.order);
    detail::call call(how);
    const auto order = static_cast<std::int32_t>(a.order);
    const auto triangle = static_cast<std::int32_t>(part);
    const auto* from = reinterpret_cast<const T*>(a.data);
    auto* to = reinterpret_cast<T*>(c.data);
    if constexpr (std::is_same<T, double>::value) {
        call.finish(cata_aha_c64(order, triangle, a.rows, a.cols, alpha, from, a.leading, beta, to,
                                 c.leading, call.params()));
    } else {
        call.finish(cata_aha_c32(order, triangle, a.rows, a.cols, alpha, from, a.leading, beta, to,
                                 c.leading, call.params()));
    }
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
    detail::require_scalar<T>();
    detail::require_general(a, b, c);
    detail::call call(how);
    const auto order = static_cast<std::int32_t>(a.order);
    const auto* factor = reinterpret_cast<const T*>(&alpha);
    const auto* kept = reinterpret_cast<const T*>(&beta);
    const auto* left = reinterpret_cast<const T*>(a.data);
    const auto* right = reinterpret_cast<const T*>(b.data);
    auto* to = reinterpret_cast<T*>(c.data);
    if constexpr (std::is_same<T, double>::value) {
        call.finish(cata_ahb_c64(order, a.rows, a.cols, b.cols, factor, left, a.leading, right,
                                 b.leading, kept, to, c.leading, call.params()));
    } else {
        call.finish(cata_ahb_c32(order, a.rows, a.cols, b.cols, factor, left, a.leading, right,
                                 b.leading, kept, to, c.leading, call.params()));
    }
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
    bool passed;
    double residual;
    double tolerance;
};

/// Checks C = alpha A^T A; a wrong C passes with probability at most 2^-rounds.
template <class T>
verification verify(double alpha, matrix_view<const T> a, matrix_view<const T> c,
                    uplo part = uplo::both, int rounds = 20, std::uint64_t seed = 1) {
    detail::require_scalar<T>();
    detail::require_square(c, a.cols, a.order);
    const auto order = static_cast<std::int32_t>(a.order);
    const auto triangle = static_cast<std::int32_t>(part);
    std::int32_t passed = 0;
    verification found{};
    if constexpr (std::is_same<T, double>::value) {
        detail::check(cata_verify_f64(order, triangle, a.rows, a.cols, alpha, a.data, a.leading,
                                      c.data, c.leading, rounds, seed, &passed, &found.residual,
                                      &found.tolerance));
    } else {
        detail::check(cata_verify_f32(order, triangle, a.rows, a.cols, alpha, a.data, a.leading,
                                      c.data, c.leading, rounds, seed, &passed, &found.residual,
                                      &found.tolerance));
    }
    found.passed = passed != 0;
    return found;
}

template <class T>
verification verify(double alpha, matrix_view<T> a, matrix_view<T> c, uplo part = uplo::both,
                    int rounds = 20, std::uint64_t seed = 1) {
    using S = std::remove_const_t<T>;
    return verify<S>(alpha, matrix_view<const S>(a), matrix_view<const S>(c), part, rounds, seed);
}

/// A sparse symmetric matrix by rows that somebody else owns: the entries of row i are those from `row_starts[i]` to
/// `row_starts[i + 1] - 1`.
struct sparse_view {
    std::size_t rows = 0;
    const std::size_t* row_starts = nullptr;
    const std::size_t* columns = nullptr;
    const double* entries = nullptr;
};

/// A^T W A of a sparse A of `cols` columns, cols x cols, both triangles; no weights: all 1.
inline std::vector<double> ata(const sparse_view& a, std::size_t cols,
                               const std::vector<double>& weights = {}, const options& how = {}) {
    const double* diagonal = weights.empty() ? nullptr : weights.data();
    detail::require(!diagonal || weights.size() == a.rows, CATA_ERR_SHAPE,
                    "weights: must have an element for each row of a");
    std::vector<double> c(cols * cols);
    detail::call call(how);
    call.finish(cata_ata_sparse_f64(CATA_ROW_MAJOR, CATA_BOTH, a.rows, cols, 1.0, a.row_starts,
                                    a.columns, a.entries, diagonal, 0.0, c.data(), cols ? cols : 1,
                                    call.params()));
    return c;
}

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

/// What the Laplacian of a mesh is made of.
struct laplacian_options {
    laplacian_kind kind = laplacian_kind::cotangent;
    mass_kind mass = mass_kind::barycentric;
    catamaran::boundary boundary = boundary::neumann;
};

/// How eigenpairs are computed: the fields of cata_spectrum_params.
struct spectrum_options {
    /// 0: all cores of the affinity mask.
    std::size_t threads = 0;
    /// 0: 60.
    std::size_t max_restarts = 0;
    std::uint64_t seed = 0;
    /// 0: 1e-9.
    double tolerance = 0.0;
    /// The eigenvalues nearest to this number; nothing: the smallest.
    std::optional<double> shift;
    bool verify_count = false;
    /// As options::progress.
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
    std::vector<double> residuals;
    /// The diagonal of M; empty where it is not a diagonal, or all 1.
    std::vector<double> masses;

    matrix_view<const double> matrix() const noexcept {
        return col_major(vectors.data(), rows, values.size());
    }
};

namespace detail {

/// cata_spectrum_params for the length of a call.
class spectrum_call {
public:
    explicit spectrum_call(const spectrum_options& options) : watcher_(options.progress) {
        check(cata_spectrum_params_init(&params_, sizeof params_));
        params_.threads = options.threads;
        params_.max_restarts = options.max_restarts;
        params_.seed = options.seed;
        params_.tolerance = options.tolerance;
        params_.shift = options.shift.value_or(0.0);
        params_.has_shift = options.shift ? 1 : 0;
        params_.verify_count = options.verify_count ? 1 : 0;
        watcher_.attach(params_);
    }

    const cata_spectrum_params* params() const noexcept { return &params_; }

    void finish(cata_status status) { watcher_.finish(status); }

private:
    cata_spectrum_params params_{};
    watcher watcher_;
};

inline cata_laplacian_params params_of(const laplacian_options& operators) {
    cata_laplacian_params params;
    check(cata_laplacian_params_init(&params, sizeof params));
    params.kind = static_cast<std::int32_t>(operators.kind);
    params.mass = static_cast<std::int32_t>(operators.mass);
    params.boundary = static_cast<std::int32_t>(operators.boundary);
    return params;
}

inline eigenpairs room_for(std::size_t rows, std::size_t k) {
    // More pairs than rows there never are, and the memory for them may not be.
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

/// The k eigenpairs of W phi = lambda M phi that the options ask for; `masses`: the diagonal of M, empty: all 1.
inline eigenpairs spectrum(const sparse_view& w, std::size_t k, std::vector<double> masses = {},
                           const spectrum_options& how = {}) {
    const double* diagonal = detail::masses_of(masses, w.rows);
    eigenpairs pairs = detail::room_for(w.rows, k);
    detail::spectrum_call call(how);
    call.finish(cata_spectrum(w.rows, w.row_starts, w.columns, w.entries, diagonal, k,
                              pairs.values.data(), pairs.vectors.data(), w.rows ? w.rows : 1,
                              pairs.residuals.data(), call.params()));
    pairs.masses = std::move(masses);
    return pairs;
}

/// The k eigenpairs of the Laplacian of a triangle mesh: positions of vertices, and three of them a face.
inline eigenpairs spectrum(const std::vector<std::array<double, 3>>& positions,
                           const std::vector<std::array<std::uint32_t, 3>>& faces, std::size_t k,
                           const laplacian_options& operators = {},
                           const spectrum_options& how = {}) {
    const std::size_t rows = positions.size();
    eigenpairs pairs = detail::room_for(rows, k);
    if (operators.mass != mass_kind::consistent) {
        pairs.masses.resize(rows);
    }
    const cata_laplacian_params params = detail::params_of(operators);
    detail::spectrum_call call(how);
    call.finish(cata_mesh_spectrum(
        rows, detail::first_of(positions), faces.size(), detail::first_of(faces), k,
        pairs.values.data(),
        pairs.vectors.data(), rows ? rows : 1, pairs.residuals.data(),
        pairs.masses.empty() ? nullptr : pairs.masses.data(), &params, call.params()));
    return pairs;
}

/// The k smallest eigenvalues of a part of a triangle mesh, ascending: cata_part_spectrum. mask: 1 for each vertex of the
/// part, 0 for each other.
inline std::vector<double> part_spectrum(
    const std::vector<std::array<double, 3>>& positions,
    const std::vector<std::array<std::uint32_t, 3>>& faces, const std::vector<std::uint8_t>& mask,
    std::size_t k,
    const laplacian_options& operators = {laplacian_kind::cotangent, mass_kind::barycentric,
                                          boundary::dirichlet},
    std::size_t threads = 0) {
    detail::require(mask.size() == positions.size(), CATA_ERR_SHAPE,
                    "mask: must have a value for each vertex");
    // More eigenvalues than vertices there never are, and the memory for them may not be.
    detail::require(k <= positions.size(), CATA_ERR_ARGUMENT, "k: more eigenvalues than vertices");
    const cata_laplacian_params params = detail::params_of(operators);
    std::vector<double> values(k);
    detail::check(cata_part_spectrum(
        positions.size(), detail::first_of(positions), faces.size(), detail::first_of(faces),
        mask.data(), k, values.data(), &params, threads));
    return values;
}

/// The network that predicts spectra of unions of parts from those of the parts. One owner; calls may run at the same time.
class unions {
public:
    /// The first Dirichlet eigenvalues of a part, ascending and positive, in whatever unit.
    using eigenvalues = std::array<double, CATA_UNION_EIGENVALUES>;

    /// With the weights that come with the library.
    unions() : handle_(made(nullptr)) {}

    /// With weights of `catamaran unions train`.
    explicit unions(const std::string& weights) : handle_(made(weights.c_str())) {}

    struct prediction {
        eigenvalues values;
        /// Above 1 the prediction is a guess.
        double strangeness;
    };

    /// Of the union of these parts, at least one.
    prediction predict(const std::vector<eigenvalues>& parts) const {
        prediction found{};
        detail::check(cata_unions_predict(handle_.get(), parts.size(), detail::first_of(parts),
                                          found.values.data(), &found.strangeness));
        return found;
    }

    /// Where the union is on the template, the mesh that `catamaran unions template` writes: for each vertex about 1
    /// inside and 0 outside.
    std::vector<double> locate(const std::vector<eigenvalues>& parts,
                               const std::vector<std::array<double, 3>>& positions,
                               const std::vector<std::array<std::uint32_t, 3>>& faces,
                               std::size_t threads = 0) const {
        std::vector<double> indicator(positions.size());
        detail::check(cata_unions_locate(
            handle_.get(), parts.size(), detail::first_of(parts), positions.size(),
            detail::first_of(positions), faces.size(), detail::first_of(faces), indicator.data(),
            threads));
        return indicator;
    }

    const cata_unions* get() const noexcept { return handle_.get(); }

private:
    struct free {
        void operator()(cata_unions* handle) const noexcept { cata_unions_free(handle); }
    };

    static cata_unions* made(const char* weights) {
        cata_unions* handle = nullptr;
        detail::check(cata_unions_new(weights, &handle));
        return handle;
    }

    std::unique_ptr<cata_unions, free> handle_;
};

/// How columns are made orthonormal: the fields of cata_ortho_params.
struct ortho_options {
    /// 0: all cores of the affinity mask.
    std::size_t threads = 0;
    /// 0: 1e-9, or 1e-2 with single_pass.
    double threshold = 0.0;
    bool single_pass = false;
    /// As options::progress.
    std::function<bool(double)> progress;
};

/// What gram_schmidt leaves beside Q.
struct factors {
    /// kept.size() x columns of A, in the layout of A without gaps: coefficients of every column.
    std::vector<double> r;
    /// The columns of A that Q is made of, ascending.
    std::vector<std::size_t> kept;
};

/// A = Q R with Q^T M Q = I: the first kept.size() columns of `a` are Q afterwards. `masses`: the diagonal of M, empty:
/// all 1.
inline factors gram_schmidt(matrix_view<double> a, const std::vector<double>& masses = {},
                            const ortho_options& how = {}) {
    const double* diagonal = detail::masses_of(masses, a.rows);
    const std::size_t most = a.rows < a.cols ? a.rows : a.cols;
    const bool by_rows = a.order == layout::row_major;
    const std::size_t leading = by_rows ? (a.cols ? a.cols : 1) : (most ? most : 1);
    std::vector<double> r(most * a.cols);
    factors found;
    found.kept.resize(a.cols);
    cata_ortho_params params;
    detail::check(cata_ortho_params_init(&params, sizeof params));
    params.threads = how.threads;
    params.threshold = how.threshold;
    params.single_pass = how.single_pass ? 1 : 0;
    detail::watcher watcher(how.progress);
    watcher.attach(params);
    std::size_t rank = 0;
    watcher.finish(cata_gram_schmidt(static_cast<std::int32_t>(a.order), a.rows, a.cols, a.data,
                                     a.leading, diagonal, r.data(), leading, found.kept.data(),
                                     &rank, &params));
    found.kept.resize(rank);
    if (!by_rows) {
        // Rows below the rank are zeros.
        for (std::size_t j = 0; j < a.cols; ++j) {
            for (std::size_t i = 0; i < rank; ++i) {
                r[i + j * rank] = r[i + j * leading];
            }
        }
    }
    r.resize(rank * a.cols);
    found.r = std::move(r);
    return found;
}

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
/// cata_lstsq_f64. A is m x n, B is m x k, in the same layout.
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
    watcher.finish(cata_lstsq_f64(static_cast<std::int32_t>(a.order), a.rows, n, k, a.data,
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

/// The first `count` principal components of the rows of A: cata_pca_f64.
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
    watcher.finish(cata_pca_f64(
        static_cast<std::int32_t>(a.order), a.rows, a.cols, a.data, a.leading, count,
        found.components.data(), detail::tight(a.order, count, a.cols),
        found.explained_variance.data(), found.explained_variance_ratio.data(),
        found.singular_values.data(), found.mean.data(), found.scale.data(), &params));
    return found;
}

/// The singular values and right singular vectors of A: cata_svd_f64.
inline singular_value_decomposition svd(matrix_view<const double> a,
                                        const gram_options& how = {}) {
    const std::size_t most = a.rows < a.cols ? a.rows : a.cols;
    singular_value_decomposition found;
    found.values.resize(most);
    found.v.resize(detail::entries(a.cols, most));
    detail::gram_call call(how);
    call.finish(cata_svd_f64(static_cast<std::int32_t>(a.order), a.rows, a.cols, a.data, a.leading,
                             found.values.data(), found.v.data(),
                             detail::tight(a.order, a.cols, most), call.params()));
    return found;
}

/// A^T W A, of A less its mean row if `centered`, in two parts: cata_gram_extended_f64.
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
    call.finish(cata_gram_extended_f64(
        static_cast<std::int32_t>(a.order), a.rows, n, a.data, a.leading, weight,
        centered ? CATA_CENTER_MEAN : CATA_CENTER_NONE, found.high.data(), leading,
        found.low.data(), leading, &exact, call.params()));
    found.exact = exact != 0;
    return found;
}

/// The correlation matrix of the columns of A, n x n without gaps: cata_correlation_f64.
inline std::vector<double> correlation(matrix_view<const double> a, const gram_options& how = {}) {
    std::vector<double> c(detail::entries(a.cols, a.cols));
    detail::gram_call call(how);
    call.finish(cata_correlation_f64(static_cast<std::int32_t>(a.order), a.rows, a.cols, a.data,
                                     a.leading, c.data(), a.cols ? a.cols : 1, call.params()));
    return c;
}

/// How far the columns of Q are from orthonormal: cata_orthogonality_f64.
inline orthogonality_defect orthogonality(matrix_view<const double> q,
                                          const gram_options& how = {}) {
    orthogonality_defect found;
    detail::gram_call call(how);
    call.finish(cata_orthogonality_f64(static_cast<std::int32_t>(q.order), q.rows, q.cols, q.data,
                                       q.leading, &found.max, &found.frobenius, call.params()));
    return found;
}

/// A = Q R for independent columns: `a` becomes Q, and R, n x n in the layout of A without gaps,
/// is returned: cata_cholesky_qr_extended_f64.
inline std::vector<double> cholesky_qr_extended(matrix_view<double> a,
                                                const gram_options& how = {}) {
    std::vector<double> r(detail::entries(a.cols, a.cols));
    detail::gram_call call(how);
    call.finish(cata_cholesky_qr_extended_f64(static_cast<std::int32_t>(a.order), a.rows, a.cols,
                                              a.data, a.leading, r.data(), a.cols ? a.cols : 1,
                                              call.params()));
    return r;
}

/// How functions are transferred: the fields of cata_transfer_params.
struct transfer_options {
    /// 0: all cores of the affinity mask.
    std::size_t threads = 0;
    /// Most factors of a product; 0: 2.
    std::size_t order = 0;
    bool reorthogonalised = false;
    /// As options::progress.
    std::function<bool(double)> progress;
};

/// Functions on the source mesh, one a column, as functions on the target mesh, in the same layout without gaps.
/// `source` and `target` are eigenpairs of meshes, the constant among them; `points` has the vertex of the source for
/// each vertex of the target.
inline std::vector<double> transfer(const eigenpairs& source, const eigenpairs& target,
                                    const std::vector<std::uint32_t>& points,
                                    matrix_view<const double> functions,
                                    const transfer_options& how = {}) {
    for (const eigenpairs* basis : {&source, &target}) {
        detail::require(basis->masses.size() == basis->rows, CATA_ERR_ARGUMENT,
                        "source, target: must have masses");
    }
    detail::require(points.size() == target.rows, CATA_ERR_SHAPE,
                    "points: must be as many as vertices of the target");
    detail::require(functions.rows == source.rows, CATA_ERR_SHAPE,
                    "functions: must have a row for each vertex of the source");
    cata_transfer_params params;
    detail::check(cata_transfer_params_init(&params, sizeof params));
    params.threads = how.threads;
    params.order = how.order;
    params.reorthogonalised = how.reorthogonalised ? 1 : 0;
    detail::watcher watcher(how.progress);
    watcher.attach(params);
    const std::size_t width = functions.order == layout::row_major ? functions.cols : target.rows;
    std::vector<double> found(target.rows * functions.cols);
    watcher.finish(cata_transfer(
        source.rows, source.values.size(), source.masses.data(), source.values.data(),
        source.vectors.data(), target.rows, target.values.size(), target.masses.data(),
        target.values.data(), target.vectors.data(), points.data(),
        static_cast<std::int32_t>(functions.order), functions.cols, functions.data,
        functions.leading, found.data(), width ? width : 1, &params));
    return found;
}

/// How a mesh is decimated: the fields of cata_decimate_params.
struct decimate_options {
    /// 0: all cores of the affinity mask.
    std::size_t threads = 0;
    /// Passes that move samples to the centroids of their cells.
    std::int32_t lloyd = 0;
    /// Passes that flip edges and move vertices of the result; 0: the default; -1: none.
    std::int32_t relaxation = 0;
    /// The vertex that the first sample is; none: the lowest that a face has.
    std::optional<std::uint32_t> first;
    /// Whether handles too narrow for the triangles of the result are cut, and their ends closed.
    bool cut_narrow_handles = false;
    /// As options::progress.
    std::function<bool(double)> progress;
};

/// What decimate leaves of a mesh.
struct decimation {
    std::vector<std::array<double, 3>> positions;
    std::vector<std::array<std::uint32_t, 3>> faces;
    /// For each vertex of the input the nearest one of the result along edges; UINT32_MAX where no face has it.
    std::vector<std::uint32_t> cells;
    /// Whether the input had to be repaired.
    bool changed = false;
};

/// A mesh of exactly n vertices like this one: cata_decimate.
inline decimation decimate(const std::vector<std::array<double, 3>>& positions,
                           const std::vector<std::array<std::uint32_t, 3>>& faces, std::size_t n,
                           const decimate_options& how = {}) {
    cata_decimate_params params;
    detail::check(cata_decimate_params_init(&params, sizeof params));
    params.threads = how.threads;
    params.lloyd = how.lloyd;
    params.relaxation = how.relaxation;
    params.has_first = how.first ? 1 : 0;
    params.first = how.first.value_or(0);
    params.cut_narrow_handles = how.cut_narrow_handles ? 1 : 0;
    detail::watcher watcher(how.progress);
    watcher.attach(params);
    decimation found;
    found.positions.resize(n);
    found.faces.resize(cata_decimate_faces_bound(n, faces.size()));
    found.cells.resize(positions.size());
    std::size_t count = 0;
    std::int32_t changed = 0;
    watcher.finish(cata_decimate(
        positions.size(), detail::first_of(positions), faces.size(), detail::first_of(faces), n,
        detail::first_of(found.positions), detail::first_of(found.faces), found.faces.size(),
        &count, found.cells.empty() ? nullptr : found.cells.data(), &changed, &params));
    found.faces.resize(count);
    found.changed = changed != 0;
    return found;
}

/// How a search for curves ended.
enum class curve_outcome : std::int32_t {
    closed = CATA_CURVE_CLOSED,
    open = CATA_CURVE_OPEN,
    blocked = CATA_CURVE_BLOCKED,
    close_blocked = CATA_CURVE_CLOSE_BLOCKED,
    disconnected = CATA_CURVE_DISCONNECTED,
};

/// How curves are found: the fields of cata_curve_params.
struct curve_options {
    /// With faithful: among how many of the nearest samples the next one is chosen; 0: 5.
    std::size_t candidates = 0;
    /// With faithful: the number of the sample that the curve starts at.
    std::size_t start = 0;
    /// Algorithm 6.1 of the thesis, from sample to sample; else the order first, then paths that do not meet.
    bool faithful = false;
    /// Open curves; else closed ones.
    bool open = false;
    /// One curve, even where there are gaps as between several.
    bool single = false;
    /// Vertices of the mesh alone; else points on edges are added where there is no other way.
    bool no_steiner = false;
    /// As options::progress.
    std::function<bool(double)> progress;
};

/// A curve on a mesh.
struct curve {
    /// Numbers of samples, in its order.
    std::vector<std::uint32_t> order;
    /// Its vertices, the first one not repeated; those from the number of vertices of the mesh on were added.
    std::vector<std::uint32_t> path;
    /// Where they are.
    std::vector<std::array<double, 3>> points;
    double length = 0.0;
};

/// What curves finds.
struct found_curves {
    curve_outcome outcome = curve_outcome::closed;
    /// Or what there is of them.
    std::vector<curve> curves;
};

/// The curves along the edges of a mesh that samples (vertices) without an order are of: cata_curves_new.
inline found_curves curves(const std::vector<std::array<double, 3>>& positions,
                           const std::vector<std::array<std::uint32_t, 3>>& faces,
                           const std::vector<std::uint32_t>& samples,
                           const curve_options& how = {}) {
    cata_curve_params params;
    detail::check(cata_curve_params_init(&params, sizeof params));
    params.candidates = how.candidates;
    params.start = how.start;
    params.faithful = how.faithful ? 1 : 0;
    params.open = how.open ? 1 : 0;
    params.single = how.single ? 1 : 0;
    params.no_steiner = how.no_steiner ? 1 : 0;
    detail::watcher watcher(how.progress);
    watcher.attach(params);
    cata_curves* made = nullptr;
    watcher.finish(cata_curves_new(
        positions.size(), detail::first_of(positions), faces.size(), detail::first_of(faces),
        samples.size(), samples.data(), &params, &made));
    const std::unique_ptr<cata_curves, void (*)(cata_curves*)> handle(made, cata_curves_free);
    found_curves found;
    std::int32_t outcome = 0;
    std::size_t count = 0;
    detail::check(cata_curves_outcome(handle.get(), &outcome, &count));
    found.outcome = static_cast<curve_outcome>(outcome);
    found.curves.resize(count);
    for (std::size_t i = 0; i < count; ++i) {
        curve& one = found.curves[i];
        std::size_t of_order = 0, of_path = 0;
        detail::check(cata_curves_size(handle.get(), i, &of_order, &of_path, &one.length));
        one.order.resize(of_order);
        one.path.resize(of_path);
        one.points.resize(of_path);
        detail::check(cata_curves_get(handle.get(), i, one.order.data(), one.path.data(),
                                      detail::first_of(one.points)));
    }
    return found;
}

/// The water in a plant. One owner; models share nothing.
class plant {
public:
    /// A plant in a file: .txt, .swc, .mtg or .obj.
    explicit plant(const std::string& path, const cata_plant_params* params = nullptr) {
        cata_plant* handle = nullptr;
        detail::check(cata_plant_read(path.c_str(), params, &handle));
        handle_.reset(handle);
    }

    /// Three coordinates, a radius, a parent and 1 or 0 for a vein or stem of every segment; base: three numbers or null.
    plant(const std::vector<double>& tails, const std::vector<double>& radii,
          const std::vector<std::uint32_t>& parents, const std::vector<std::int32_t>& leaves,
          const double* base = nullptr, const cata_plant_params* params = nullptr) {
        const std::size_t n = radii.size();
        detail::require(tails.size() / 3 == n && tails.size() % 3 == 0, CATA_ERR_SHAPE,
                        "tails: must have three numbers for each radius");
        detail::require(parents.size() == n && leaves.size() == n, CATA_ERR_SHAPE,
                        "parents and leaves: must be as many as radii");
        cata_plant* handle = nullptr;
        detail::check(cata_plant_new(n, tails.data(), radii.data(), parents.data(), leaves.data(),
                                     base, params, &handle));
        handle_.reset(handle);
    }

    std::size_t size() const noexcept { return cata_plant_size(handle_.get()); }

    std::vector<double> full_water() const {
        std::vector<double> water(size());
        detail::check(cata_plant_full_water(handle_.get(), size(), water.data()));
        return water;
    }

    void set_loss(double loss) { detail::check(cata_plant_set_loss(handle_.get(), loss)); }
    void set_intake(double intake) { detail::check(cata_plant_set_intake(handle_.get(), intake)); }
    void weaken(std::size_t node, double factor) {
        detail::check(cata_plant_weaken(handle_.get(), node, factor));
    }

    std::vector<double> water_after(const std::vector<double>& water, double seconds) const {
        std::vector<double> result(water.size());
        detail::check(cata_plant_water_after(handle_.get(), water.size(), water.data(), seconds,
                                             result.data()));
        return result;
    }

    /// Makes `water` the present of step().
    void start(const std::vector<double>& water, double step) {
        detail::check(cata_plant_start(handle_.get(), water.size(), water.data(), step));
    }

    /// Goes `count` steps ahead; the water there.
    std::vector<double> step(std::size_t count = 1) {
        std::vector<double> water(size());
        detail::check(cata_plant_step(handle_.get(), count, water.size(), water.data()));
        return water;
    }

    std::vector<double> stiffness(const std::vector<double>& water, double full, double dry,
                                  double steepness, double shift) const {
        std::vector<double> moduli(water.size());
        detail::check(cata_plant_stiffness(handle_.get(), water.size(), water.data(), full, dry,
                                           steepness, shift, moduli.data()));
        return moduli;
    }

    const cata_plant* get() const noexcept { return handle_.get(); }

private:
    struct free {
        void operator()(cata_plant* handle) const noexcept { cata_plant_free(handle); }
    };

    std::unique_ptr<cata_plant, free> handle_;
};

/// Slime moulds on a surface. One owner; simulations share nothing.
class slime {
public:
    /// Three coordinates a vertex, three vertices a triangle; uv: six numbers a triangle, or none for an atlas. start and
    /// ground: a value for each texel, or none.
    slime(const std::vector<double>& positions, const std::vector<std::uint32_t>& triangles,
          const std::vector<double>& uv = {}, const cata_slime_params* params = nullptr,
          const std::vector<std::uint8_t>& start = {},
          const std::vector<std::uint8_t>& ground = {}) {
        detail::require(positions.size() % 3 == 0 && triangles.size() % 3 == 0, CATA_ERR_SHAPE,
                        "positions and triangles: must be in threes");
        detail::require(uv.empty() || uv.size() == 2 * triangles.size(), CATA_ERR_SHAPE,
                        "uv: must have six numbers for each triangle");
        const std::size_t side = params != nullptr && params->size > 0 ? params->size : 2048;
        for (const auto* mask : {&start, &ground}) {
            detail::require(mask->empty() || mask->size() == side * side, CATA_ERR_SHAPE,
                            "start and ground: must have a value for each texel");
        }
        cata_slime* handle = nullptr;
        detail::check(cata_slime_new(positions.size() / 3, positions.data(), triangles.size() / 3,
                                     triangles.data(), uv.empty() ? nullptr : uv.data(),
                                     start.empty() ? nullptr : start.data(),
                                     ground.empty() ? nullptr : ground.data(), params, &handle));
        handle_.reset(handle);
    }

    /// Goes ahead; `progress` is told the fraction done after each step, and returns whether to go on.
    void step(std::uint32_t steps = 1, const std::function<bool(double)>& progress = {}) {
        struct {
            cata_progress progress = nullptr;
            void* progress_user = nullptr;
        } told;
        detail::watcher watcher(progress);
        watcher.attach(told);
        watcher.finish(cata_slime_step(handle_.get(), steps, told.progress, told.progress_user));
    }

    /// Texels of a side of the texture.
    std::size_t size() const {
        std::size_t size = 0;
        detail::check(cata_slime_size(handle_.get(), &size, nullptr, nullptr, nullptr));
        return size;
    }

    std::vector<float> texture(std::size_t species = 0) const {
        std::vector<float> texture(size() * size());
        detail::check(cata_slime_texture(handle_.get(), species, texture.data()));
        return texture;
    }

    /// Coverage and presence.
    std::pair<double, double> coverage(std::size_t species = 0) const {
        std::pair<double, double> found;
        detail::check(cata_slime_coverage(handle_.get(), species, &found.first, &found.second));
        return found;
    }

    const cata_slime* get() const noexcept { return handle_.get(); }

private:
    struct free {
        void operator()(cata_slime* handle) const noexcept { cata_slime_free(handle); }
    };

    std::unique_ptr<cata_slime, free> handle_;
};

/// A Newton fractal in four dimensions. One owner; fractals share nothing.
class newton {
public:
    /// For each point the number of the root that it converges to, and how slowly.
    struct values {
        std::vector<std::uint16_t> roots;
        std::vector<float> convergence;
    };

    explicit newton(const cata_newton_params* params = nullptr) {
        cata_newton* handle = nullptr;
        detail::check(cata_newton_new(params, &handle));
        handle_.reset(handle);
    }

    /// Changes the fourth coordinate of all points.
    void set_w(double w) { detail::check(cata_newton_set_w(handle_.get(), w)); }

    /// At points in space, such as the vertices of a mesh: three coordinates each.
    values points(const std::vector<float>& positions) const {
        detail::require(positions.size() % 3 == 0, CATA_ERR_SHAPE, "positions: must be in threes");
        values found = room_for(positions.size() / 3);
        detail::check(cata_newton_points(handle_.get(), found.roots.size(), positions.data(),
                                         found.roots.data(), found.convergence.data()));
        return found;
    }

    /// At the centres of the pixels of a picture of the plane z = 0, rows from the top; extent: how wide it is.
    values plane(std::uint32_t width, std::uint32_t height, std::array<double, 2> center,
                 double extent) const {
        // Before there is room for them.
        detail::require(std::uint64_t{width} * height < std::uint64_t{1} << 31, CATA_ERR_ARGUMENT,
                        "width and height: 2^31 pixels or more");
        values found = room_for(std::size_t{width} * height);
        detail::check(cata_newton_plane(handle_.get(), width, height, center[0], center[1], extent,
                                        found.roots.data(), found.convergence.data()));
        return found;
    }

    /// Red, green and blue of each point, as screens have them.
    std::vector<std::uint8_t> colors(const values& of) const {
        detail::require(of.roots.size() == of.convergence.size(), CATA_ERR_SHAPE,
                        "roots and convergence: must be as many");
        std::vector<std::uint8_t> colors(3 * of.roots.size());
        detail::check(cata_newton_colors(handle_.get(), of.roots.size(), of.roots.data(),
                                         of.convergence.data(), colors.data()));
        return colors;
    }

    const cata_newton* get() const noexcept { return handle_.get(); }

private:
    struct free {
        void operator()(cata_newton* handle) const noexcept { cata_newton_free(handle); }
    };

    static values room_for(std::size_t count) {
        values found;
        found.roots.resize(count);
        found.convergence.resize(count);
        return found;
    }

    std::unique_ptr<cata_newton, free> handle_;
};

}  // namespace catamaran

#endif  // CATAMARAN_HPP
