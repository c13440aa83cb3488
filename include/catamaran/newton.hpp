// Newton fractals.

#ifndef CATAMARAN_NEWTON_HPP
#define CATAMARAN_NEWTON_HPP

#include "core.hpp"

#include <memory>
#include <optional>

namespace catamaran {

/// How slowly points converge, as which number.
enum class newton_gradient : std::int32_t {
    thesis = CATA_NEWTON_THESIS,
    shader = CATA_NEWTON_SHADER,
};

/// What a Newton fractal is of: the fields of cata_newton_params; 0 is the default of each.
struct newton_options {
    /// Threads, at most; 0: as many as the process may use (catamaran.h, Threads).
    std::size_t threads = 0;
    /// Progress callback, as options::progress, of all calls of the fractal.
    std::function<bool(double)> progress;
    /// Real and imaginary part of each, at most 64, within 1e4 of 0; none: those of z^power - 1.
    std::vector<std::array<double, 2>> roots;
    /// An OpenCL device; none: the processor.
    std::optional<std::string> device;
    /// What points are multiplied by after offset and w are added; 0: 1.
    double scale = 0.0;
    /// Theta of the gradient, -10 to 20; 0: 3.5.
    double theta = 0.0;
    /// Fourth coordinate of all points.
    double w = 0.0;
    /// Offset that is added to x, y and z of each point.
    std::array<double, 3> offset{};
    /// Without roots: the degree of z^power - 1, 2 to 64; 0: 3. With roots: 0.
    std::uint32_t power = 0;
    /// Steps of Newton's method for a point, at most 1000; 0: 32.
    std::uint32_t iterations = 0;
    /// thesis: from -1 (at a root) to the iterations; shader: from 0 to 1.
    newton_gradient gradient = newton_gradient::thesis;
};

/// A Newton fractal in four dimensions. One owner, one thread at a time; fractals share nothing.
class newton {
public:
    /// For each point the number of the root that it converges to, and how slowly.
    struct values {
        /// a n + b for the roots a and b of a polynomial of n.
        std::vector<std::uint16_t> roots;
        /// How slowly, as newton_options::gradient says; as many as roots.
        std::vector<float> convergence;
    };

    /// Checks the options; nothing is computed yet.
    explicit newton(const newton_options& how = {}) : watcher_(how.progress) {
        cata_newton_params params;
        detail::check(cata_newton_params_init(&params, sizeof params));
        params.threads = how.threads;
        params.root_count = how.roots.size();
        params.roots = detail::first_of(how.roots);
        params.device = how.device ? how.device->c_str() : nullptr;
        params.scale = how.scale;
        params.theta = how.theta;
        params.w = how.w;
        for (std::size_t i = 0; i < 3; ++i) {
            params.offset[i] = how.offset[i];
        }
        params.power = how.power;
        params.iterations = how.iterations;
        params.gradient = static_cast<std::int32_t>(how.gradient);
        watcher_.attach(params);
        cata_newton* handle = nullptr;
        detail::check(cata_newton_new(&params, &handle));
        handle_.reset(handle);
    }

    /// Changes the fourth coordinate of all points.
    void set_w(double w) { detail::check(cata_newton_set_w(handle_.get(), w)); }

    /// Returns the values at points in space, such as the vertices of a mesh: three coordinates
    /// each.
    values points(const std::vector<float>& positions) const {
        detail::require(positions.size() % 3 == 0, CATA_ERR_SHAPE, "positions: must be in threes");
        values found = room_for(positions.size() / 3);
        watcher_.finish(cata_newton_points(handle_.get(), found.roots.size(), positions.data(),
                                           found.roots.data(), found.convergence.data()));
        return found;
    }

    /// At the centres of the pixels of a picture of the plane z = 0, rows from the top; extent: how
    /// wide it is.
    values plane(std::uint32_t width, std::uint32_t height, std::array<double, 2> center,
                 double extent) const {
        // Before there is room for them.
        detail::require(std::uint64_t{width} * height < std::uint64_t{1} << 31, CATA_ERR_ARGUMENT,
                        "width and height: 2^31 pixels or more");
        values found = room_for(std::size_t{width} * height);
        watcher_.finish(cata_newton_plane(handle_.get(), width, height, center[0], center[1],
                                          extent, found.roots.data(), found.convergence.data()));
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

    /// The handle, owned by this.
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

    detail::kept_watcher watcher_;
    std::unique_ptr<cata_newton, free> handle_;
};

}  // namespace catamaran

#endif
