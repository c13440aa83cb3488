// Newton fractals.

#ifndef CATAMARAN_NEWTON_HPP
#define CATAMARAN_NEWTON_HPP

#include "core.hpp"

#include <memory>

namespace catamaran {

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

#endif
