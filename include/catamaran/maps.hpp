// Functions carried from one shape to another.

#ifndef CATAMARAN_MAPS_HPP
#define CATAMARAN_MAPS_HPP

#include "eigs.hpp"

namespace catamaran {

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

}  // namespace catamaran

#endif
