// Errors, views of matrices and meshes, progress.

#ifndef CATAMARAN_CORE_HPP
#define CATAMARAN_CORE_HPP

#include "../catamaran.h"

#include <array>
#include <cstddef>
#include <cstdint>
#include <exception>
#include <functional>
#include <memory>
#include <stdexcept>
#include <string>
#include <type_traits>
#include <utility>
#include <vector>

namespace catamaran {

/// A call failed: what() is the library's message.
class error : public std::runtime_error {
public:
    /// Creates an error with the status and the message of a call.
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

/// A view of a matrix, which must outlive it.
template <class T>
struct matrix_view {
    /// Pointer to the first entry.
    T* data = nullptr;
    /// Number of rows.
    std::size_t rows = 0;
    /// Number of columns.
    std::size_t cols = 0;
    /// Elements from one row (row-major) or column (column-major) to the next.
    std::size_t leading = 1;
    /// Order of the entries in memory.
    catamaran::layout order = layout::row_major;

    /// Converts a view that can be written to one that can be read.
    operator matrix_view<const T>() const noexcept { return {data, rows, cols, leading, order}; }

    /// Entry (i, j), unchecked.
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

/// x, y, z of points.
using point_list = std::vector<std::array<double, 3>>;
/// Three vertices of each triangle.
using triangle_list = std::vector<std::array<std::uint32_t, 3>>;
/// Edges: two vertices each.
using edge_list = std::vector<std::array<std::uint32_t, 2>>;

/// A view of a triangle mesh, which must outlive it.
struct mesh_view {
    /// Creates a view of arrays, which must outlive it.
    mesh_view(const point_list& vertices_of, const triangle_list& faces_of) noexcept
        : n_vertices(vertices_of.size()),
          vertices(vertices_of.empty() ? nullptr : vertices_of.front().data()),
          n_faces(faces_of.size()),
          faces(faces_of.empty() ? nullptr : faces_of.front().data()) {}
    mesh_view(const point_list&&, const triangle_list&) = delete;
    mesh_view(const point_list&, const triangle_list&&) = delete;
    mesh_view(const point_list&&, const triangle_list&&) = delete;

    /// 3 count coordinates, and 3 count_of_faces numbers of vertices.
    mesh_view(std::size_t count, const double* coordinates, std::size_t count_of_faces,
              const std::uint32_t* corners) noexcept
        : n_vertices(count), vertices(coordinates), n_faces(count_of_faces), faces(corners) {}

    /// Number of vertices.
    std::size_t n_vertices;
    /// x, y, z of each.
    const double* vertices;
    /// Number of faces.
    std::size_t n_faces;
    /// Three vertices of each.
    const std::uint32_t* faces;
};

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

/// The leading dimension of a rows x cols matrix without gaps.
inline std::size_t gapless(layout order, std::size_t rows, std::size_t cols) noexcept {
    const std::size_t line = order == layout::row_major ? cols : rows;
    return line ? line : 1;
}

/// T where it must not take part in deducing the scalar.
template <class T>
struct identity {
    using type = T;
};
template <class T>
using identity_t = typename identity<T>::type;

/// The function of a scalar: double or float.
template <class T, class Double, class Float>
constexpr auto of_scalar(Double in_double, Float in_float) noexcept {
    static_assert(std::is_same<T, float>::value || std::is_same<T, double>::value,
                  "catamaran computes in float or double");
    if constexpr (std::is_same<T, double>::value) {
        static_cast<void>(in_float);
        return in_double;
    } else {
        static_cast<void>(in_double);
        return in_float;
    }
}

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
            std::rethrow_exception(std::exchange(thrown_, nullptr));
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

/// A progress callback that a handle keeps for its calls; nothing without one.
class kept_watcher {
public:
    explicit kept_watcher(const std::function<bool(double)>& progress)
        : kept_(progress ? std::make_unique<kept>(progress) : nullptr) {}

    template <class Params>
    void attach(Params& params) {
        if (kept_) {
            kept_->watcher_.attach(params);
        }
    }

    void finish(cata_status status) const { kept_ ? kept_->watcher_.finish(status) : check(status); }

private:
    struct kept {
        explicit kept(const std::function<bool(double)>& progress)
            : progress_(progress), watcher_(progress_) {}

        std::function<bool(double)> progress_;
        watcher watcher_;
    };

    std::unique_ptr<kept> kept_;
};

}  // namespace detail

/// Ends the threads that the library keeps between calls, and waits until they have ended; later
/// calls start new threads. A call that runs at the same time keeps its threads until it returns.
inline void release_threads() { detail::check(cata_threads_release()); }

}  // namespace catamaran

#endif
