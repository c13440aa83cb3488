// Plants.

#ifndef CATAMARAN_PLANTS_HPP
#define CATAMARAN_PLANTS_HPP

#include "core.hpp"

#include <memory>

namespace catamaran {

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

}  // namespace catamaran

#endif
