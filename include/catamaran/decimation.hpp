// Meshes with fewer vertices.

#ifndef CATAMARAN_DECIMATION_HPP
#define CATAMARAN_DECIMATION_HPP

#include "core.hpp"

#include <optional>

namespace catamaran {

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

}  // namespace catamaran

#endif
