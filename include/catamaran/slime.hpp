// Slime moulds.

#ifndef CATAMARAN_SLIME_HPP
#define CATAMARAN_SLIME_HPP

#include "core.hpp"

#include <memory>
#include <optional>

namespace catamaran {

/// How agents turn.
enum class slime_turns : std::int32_t {
    random = CATA_SLIME_TURNS_RANDOM,
    even = CATA_SLIME_TURNS_EVEN,
};

/// What the blur goes over.
enum class slime_blur : std::int32_t {
    surface = CATA_SLIME_BLUR_SURFACE,
    texture = CATA_SLIME_BLUR_TEXTURE,
};

/// Whose lengths those of the options are.
enum class slime_lengths : std::int32_t {
    surface = CATA_SLIME_LENGTHS_SURFACE,
    texture = CATA_SLIME_LENGTHS_TEXTURE,
};

/// What slime moulds are like: the fields of cata_slime_params; 0 is the default of each.
struct slime_options {
    /// Threads, at most; 0: as many as the process may use (catamaran.h, Threads).
    std::size_t threads = 0;
    /// Progress callback, as options::progress, of all calls of the simulation.
    std::function<bool(double)> progress;
    /// Number of agents, below 2^32; 0: 1,000,000.
    std::size_t agents = 0;
    /// Number of species, 1 to 15; 0: 1.
    std::size_t species = 0;
    /// Texels of a side of the texture, a multiple of 32, at most 16384; 0: 2048.
    std::size_t size = 0;
    /// An OpenCL device; none: the processor.
    std::optional<std::string> device;
    /// Seed of all random numbers.
    std::uint32_t seed = 0;
    /// Number of projected substeps of a step; 0: steps are exact.
    std::uint32_t substeps = 0;
    /// Seconds that a step takes; 0: 1 / 30.
    double time_step = 0.0;
    /// Speed, in hundredths of the square root of the area a second, such as 1 to 2; 0: 1.5.
    double movement_speed = 0.0;
    /// Most degrees that an agent turns in a second; 0: 1800.
    double turn_speed = 0.0;
    /// Distance of the sensors from an agent, in hundredths, such as 0.4 to 2; 0: 1.
    double vision_distance = 0.0;
    /// Angle between sensors, in degrees, such as 10 to 50; 0: 30.
    double vision_angle = 0.0;
    /// Pheromone that evaporates in a second, where an agent leaves 1, such as 0.2 to 1; 0: 0.4.
    double evaporation_rate = 0.0;
    /// Blurs a second; 0: 6.
    double diffusion_rate = 0.0;
    /// random: at random, up to turn_speed; even: always at turn_speed.
    slime_turns turns = slime_turns::random;
    /// surface: across seams; texture: of the texture alone.
    slime_blur blur = slime_blur::surface;
    /// surface: hundredths are of the surface; texture: of the texture, of side 1.
    slime_lengths lengths = slime_lengths::surface;
};

/// Slime moulds on a surface. One owner; simulations share nothing.
class slime {
public:
    /// uv: u, v of the corners of each face, from 0 to 1, or none for an atlas. start (not 0 where
    /// agents start) and ground (0 free, 1 obstacle, 2 attractor): a value for each texel, or none.
    explicit slime(const mesh_view& mesh, const slime_options& how = {},
                   const std::vector<std::array<double, 6>>& uv = {},
                   const std::vector<std::uint8_t>& start = {},
                   const std::vector<std::uint8_t>& ground = {})
        : watcher_(how.progress) {
        detail::require(uv.empty() || uv.size() == mesh.n_faces, CATA_ERR_SHAPE,
                        "uv: must be as many as faces");
        // The size is passed on, so that masks end where C stops to read.
        const std::size_t side = how.size > 0 ? how.size : CATA_SLIME_SIZE;
        for (const auto* mask : {&start, &ground}) {
            detail::require(mask->empty() || mask->size() == side * side, CATA_ERR_SHAPE,
                            "start and ground: must have a value for each texel");
        }
        cata_slime_params params;
        detail::check(cata_slime_params_init(&params, sizeof params));
        params.threads = how.threads;
        params.agents = how.agents;
        params.species = how.species;
        params.size = side;
        params.device = how.device ? how.device->c_str() : nullptr;
        params.seed = how.seed;
        params.substeps = how.substeps;
        params.time_step = how.time_step;
        params.movement_speed = how.movement_speed;
        params.turn_speed = how.turn_speed;
        params.vision_distance = how.vision_distance;
        params.vision_angle = how.vision_angle;
        params.evaporation_rate = how.evaporation_rate;
        params.diffusion_rate = how.diffusion_rate;
        params.turns = static_cast<std::int32_t>(how.turns);
        params.blur = static_cast<std::int32_t>(how.blur);
        params.lengths = static_cast<std::int32_t>(how.lengths);
        watcher_.attach(params);
        cata_slime* handle = nullptr;
        detail::check(cata_slime_new(mesh.n_vertices, mesh.vertices, mesh.n_faces, mesh.faces,
                                     detail::first_of(uv), start.empty() ? nullptr : start.data(),
                                     ground.empty() ? nullptr : ground.data(), &params, &handle));
        handle_.reset(handle);
    }

    /// Goes `steps` steps ahead.
    void step(std::uint32_t steps = 1) { watcher_.finish(cata_slime_step(handle_.get(), steps)); }

    /// Texels of a side of the texture.
    std::size_t size() const {
        std::size_t size = 0;
        detail::check(cata_slime_size(get(), &size, nullptr, nullptr, nullptr));
        return size;
    }

    /// Steps that are done.
    std::uint32_t steps() const {
        std::uint32_t steps = 0;
        detail::check(cata_slime_size(get(), nullptr, nullptr, nullptr, &steps));
        return steps;
    }

    /// Pheromone of a species, from 0 to 1: size() x size(), rows along u, the first at v = 0.
    std::vector<float> texture(std::size_t species = 0) const {
        std::vector<float> texture(size() * size());
        detail::check(cata_slime_texture(get(), species, texture.data()));
        return texture;
    }

    /// Mean of the pheromone of a species, and the part of the surface that has any.
    std::pair<double, double> coverage(std::size_t species = 0) const {
        std::pair<double, double> found;
        detail::check(cata_slime_coverage(get(), species, &found.first, &found.second));
        return found;
    }

    /// The corners of each face in the texture.
    std::vector<std::array<double, 6>> uv() const {
        std::size_t faces = 0;
        detail::check(cata_slime_size(get(), nullptr, nullptr, &faces, nullptr));
        std::vector<std::array<double, 6>> uv(faces);
        detail::check(cata_slime_uv(get(), detail::first_of(uv)));
        return uv;
    }

    /// The handle, owned by this.
    const cata_slime* get() const noexcept { return handle_.get(); }

private:
    struct free {
        void operator()(cata_slime* handle) const noexcept { cata_slime_free(handle); }
    };

    detail::kept_watcher watcher_;
    std::unique_ptr<cata_slime, free> handle_;
};

}  // namespace catamaran

#endif
