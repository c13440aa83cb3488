// Matrices of Eigen, and meshes V, F as libigl has them. Not part of catamaran.hpp: it needs Eigen.

#ifndef CATAMARAN_EIGEN_HPP
#define CATAMARAN_EIGEN_HPP

#include "borrowed.hpp"

#include <Eigen/Core>
#include <Eigen/SparseCore>

namespace catamaran {

/// A dense matrix, map or block of Eigen, without a copy, valid as long as it is; its entries must
/// be neighbours within a column, or row where it is row-major, unless it is a vector.
template <class Matrix>
auto view(Matrix& a) {
    const bool neighbours = a.innerStride() == 1;
    detail::require(neighbours || Matrix::IsVectorAtCompileTime, CATA_ERR_ARGUMENT,
                    "a: entries are not neighbours");
    const auto rows = static_cast<std::size_t>(a.rows()), cols = static_cast<std::size_t>(a.cols());
    const auto leading = static_cast<std::size_t>(neighbours ? a.outerStride() : a.innerStride());
    // A row across columns is a matrix by columns.
    return Matrix::IsRowMajor == neighbours ? row_major(a.data(), rows, cols, leading)
                                            : col_major(a.data(), rows, cols, leading);
}

/// Eigenvectors, a column each, as a matrix of Eigen, without a copy.
inline Eigen::Map<const Eigen::MatrixXd> map(const eigenpairs& pairs) {
    return {pairs.vectors.data(), static_cast<Eigen::Index>(pairs.rows),
            static_cast<Eigen::Index>(pairs.values.size())};
}
Eigen::Map<const Eigen::MatrixXd> map(const eigenpairs&&) = delete;

/// Rows of three, such as vertices and faces, as a matrix of Eigen, without a copy.
template <class T>
Eigen::Map<const Eigen::Matrix<T, Eigen::Dynamic, 3, Eigen::RowMajor>> map(
    const std::vector<std::array<T, 3>>& rows) {
    return {detail::first_of(rows), static_cast<Eigen::Index>(rows.size()), 3};
}
template <class T>
void map(const std::vector<std::array<T, 3>>&&) = delete;

/// A sparse matrix of Eigen whose indices are as wide as those of the library.
template <int Order>
using wide_sparse = Eigen::SparseMatrix<double, Order, std::ptrdiff_t>;

/// A sparse matrix as one of Eigen, without a copy.
inline Eigen::Map<const wide_sparse<Eigen::RowMajor>> map(const sparse_matrix& a) {
    // Signed and unsigned integers of one width may stand for each other.
    const auto indices = [](const std::vector<std::size_t>& of) {
        return reinterpret_cast<const std::ptrdiff_t*>(of.data());
    };
    return {static_cast<Eigen::Index>(a.rows), static_cast<Eigen::Index>(a.cols),
            static_cast<Eigen::Index>(a.entries.size()), indices(a.row_starts), indices(a.columns),
            a.entries.data()};
}
Eigen::Map<const wide_sparse<Eigen::RowMajor>> map(const sparse_matrix&&) = delete;

/// A sparse symmetric matrix of Eigen, both triangles, compressed, without a copy and valid as long
/// as it is. By columns it is the same as by rows.
template <int Order>
sparse_view symmetric_view(const wide_sparse<Order>& a) {
    detail::require(a.isCompressed(), CATA_ERR_ARGUMENT, "a: call makeCompressed() before");
    detail::require(a.rows() == a.cols(), CATA_ERR_SHAPE, "a: a symmetric matrix is square");
    const auto indices = [](const std::ptrdiff_t* first) {
        return reinterpret_cast<const std::size_t*>(first);
    };
    return {static_cast<std::size_t>(a.rows()), indices(a.outerIndexPtr()),
            indices(a.innerIndexPtr()), a.valuePtr()};
}
template <int Order>
sparse_view symmetric_view(const wide_sparse<Order>&&) = delete;

/// Does not compile: a matrix with other indices can't be seen without a copy.
template <int Order, class Index>
sparse_view symmetric_view(const Eigen::SparseMatrix<double, Order, Index>&) {
    static_assert(sizeof(Index) == 0,
                  "indices are not of std::ptrdiff_t: use catamaran::wide_sparse, or copied(a)");
    return {};
}

/// A copy of any sparse matrix of Eigen, by rows; functions take it in the place of a view.
template <class Derived>
sparse_matrix copied(const Eigen::SparseMatrixBase<Derived>& a) {
    const wide_sparse<Eigen::RowMajor> rows(a.template cast<double>());
    const auto entries = static_cast<std::size_t>(rows.nonZeros());
    const std::ptrdiff_t *starts = rows.outerIndexPtr(), *columns = rows.innerIndexPtr();
    return {static_cast<std::size_t>(rows.rows()), static_cast<std::size_t>(rows.cols()),
            std::vector<std::size_t>(starts, starts + rows.rows() + 1),
            std::vector<std::size_t>(columns, columns + entries),
            std::vector<double>(rows.valuePtr(), rows.valuePtr() + entries)};
}

namespace detail {

/// The rows of a matrix of Eigen with three columns of T, or of integers as wide as T, that lie one
/// after the other; null where they do not, and are copied.
template <class T, class Derived>
const T* rows_of_three(const Eigen::MatrixBase<Derived>& a, std::vector<std::array<T, 3>>& copy,
                       const char* wanted) {
    using S = typename Derived::Scalar;
    require(a.cols() == 3, CATA_ERR_SHAPE, wanted);
    constexpr bool direct = (Derived::Flags & Eigen::DirectAccessBit) != 0;
    constexpr bool same = std::is_same<S, T>::value || (std::is_integral<S>::value &&
                                                        std::is_integral<T>::value &&
                                                        sizeof(S) == sizeof(T));
    if constexpr (direct && same && Derived::IsRowMajor) {
        if (a.derived().innerStride() == 1 && a.derived().outerStride() == 3 && a.rows() > 0) {
            return reinterpret_cast<const T*>(a.derived().data());
        }
    }
    copy.resize(static_cast<std::size_t>(a.rows()));
    for (Eigen::Index i = 0; i < a.rows(); ++i) {
        for (Eigen::Index j = 0; j < 3; ++j) {
            const S value = a(i, j);
            const auto stored = static_cast<T>(value);
            require(std::is_floating_point<T>::value || static_cast<S>(stored) == value,
                    CATA_ERR_ARGUMENT, wanted);
            copy[static_cast<std::size_t>(i)][static_cast<std::size_t>(j)] = stored;
        }
    }
    return nullptr;
}

}  // namespace detail

/// The mesh V, F of libigl, n x 3 and m x 3, which must outlive the result. Row-major doubles, and
/// row-major integers of 32 bits, are not copied; F has no negative numbers.
template <class Vertices, class Faces>
borrowed_mesh borrow(const Eigen::MatrixBase<Vertices>& v, const Eigen::MatrixBase<Faces>& f) {
    point_list copied_vertices;
    triangle_list copied_faces;
    const double* own = detail::rows_of_three(v, copied_vertices, "V: must have three columns");
    const std::uint32_t* own_faces = detail::rows_of_three(
        f, copied_faces, "F: must have three columns of numbers from 0 to 2^32 - 1");
    return {static_cast<std::size_t>(v.rows()), own, std::move(copied_vertices),
            static_cast<std::size_t>(f.rows()), own_faces, std::move(copied_faces)};
}
template <class Vertices, class Faces>
void borrow(const Eigen::PlainObjectBase<Vertices>&&, const Eigen::MatrixBase<Faces>&) = delete;
template <class Vertices, class Faces>
void borrow(const Eigen::MatrixBase<Vertices>&, const Eigen::PlainObjectBase<Faces>&&) = delete;

}  // namespace catamaran

#endif
