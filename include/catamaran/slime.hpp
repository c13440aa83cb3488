// Slime moulds.

#ifndef CATAMARAN_SLIME_HPP
#define CATAMARAN_SLIME_HPP

#include "core.hpp"

#include <memory>

namespace catamaran {

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

}  // namespace catamaran

#endif
