// Curves on meshes.

#ifndef CATAMARAN_CURVES_HPP
#define CATAMARAN_CURVES_HPP

#include "core.hpp"

#include <memory>

namespace catamaran {

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

}  // namespace catamaran

#endif
