// Plants.

#ifndef CATAMARAN_PLANTS_HPP
#define CATAMARAN_PLANTS_HPP

#include "core.hpp"

#include <memory>
#include <optional>

namespace catamaran {

/// The constants of a plant: the fields of cata_plant_params but elasticity_literal; 0 is the
/// default of each.
struct plant_options {
    /// Threads, at most; 0: as many as the process may use (catamaran.h, Threads).
    std::size_t threads = 0;
    /// Progress callback, as options::progress, of all calls of the plant.
    std::function<bool(double)> progress;
    /// Water that leaves give off, in kg / (s m^2); 0: none.
    double loss = 0.0;
    /// Water that the root takes from the soil, in kg / s; 0: none.
    double intake = 0.0;
    /// Conductance of a segment, as a part of that of a pipe of its width; 0: 1e-9.
    double conductance = 0.0;
    /// Pressure in full cells, in Pa; 0: 1e6.
    double modulus = 0.0;
    /// Viscosity of the sap, in Pa s; 0: 1e-3.
    double viscosity = 0.0;
    /// Density of water in full tissue, in kg / m^3; 0: 1000.
    double density = 0.0;
    /// Modulus of elasticity of full cells, in Pa; 0: 5e7.
    double elasticity_full = 0.0;
    /// Modulus of elasticity of dry cells, in Pa; 0: 3e5.
    double elasticity_dry = 0.0;
    /// How steeply the modulus falls in between; 0: 10.
    double elasticity_steepness = 0.0;
    /// Relative water content at which it falls most steeply; 0: 0.75.
    double elasticity_shift = 0.0;
};

/// The constants of rods: the fields of cata_plant_rods_params; 0 is the default of each.
struct rods_options {
    /// Progress callback, as options::progress, of all calls of the rods.
    std::function<bool(double)> progress;
    /// Acceleration, in m / s^2; all 0: 0, 0, -9.81.
    std::array<double, 3> gravity{};
    /// Ratio of lateral contraction to stretch, above -1 and at most 0.5; 0: 0.3.
    double poisson = 0.0;
    /// Density of tissue without its water, in kg / m^3; 0: 100.
    double dry_density = 0.0;
    /// Of relax: torque out of balance, divided by the largest torque of a weight, 1e-12 to 1e-2;
    /// 0: 1e-8.
    double tolerance = 0.0;
    /// Iterations of relax, at most; 0: 200.
    std::size_t iterations = 0;
    /// Seconds that a step takes; 0: 1 / 60.
    double step = 0.0;
    /// Iterations of each step; 0: 3.
    std::size_t step_iterations = 0;
    /// Rate at which velocities wear off, in 1 / s; 0: 1.
    double damping = 0.0;
};

/// The segments of a plant, as cata_plant_new takes them.
struct plant_segments {
    /// x, y, z of the end of each, in m.
    point_list tails;
    /// Radius of each segment, in m, positive.
    std::vector<double> radii;
    /// The segment at whose end each begins; CATA_NO_PARENT for the root.
    std::vector<std::uint32_t> parents;
    /// CATA_PLANT_STEM or CATA_PLANT_LEAF, each also + CATA_PLANT_PINNED.
    std::vector<std::int32_t> kinds;
    /// Point at which the root begins; none: the root is as long as its first child, and in its
    /// direction.
    std::optional<std::array<double, 3>> base;
};

/// A part of a day: its seconds, and what leaves lose then.
struct plant_interval {
    /// How long it is.
    double seconds;
    /// What leaves give off then, in kg / (s m^2).
    double loss;
};

/// Where segments are.
struct plant_pose {
    /// Point at which each segment begins, in m.
    point_list heads;
    /// Point at which each segment ends, in m.
    point_list tails;
    /// How they have turned since the plant was given: unit quaternions (w, x, y, z).
    std::vector<std::array<double, 4>> rotations;
};

/// A mesh of tubes.
struct plant_tubes {
    /// x, y, z in m: 2 x sides for each segment, one segment after the other.
    point_list vertices;
    /// Three vertices of each: 2 x sides for each segment, in the same order.
    triangle_list faces;
};

/// What became of a plant, time by time.
struct wilting {
    /// Water of each node, in kg.
    std::vector<std::vector<double>> water;
    /// Modulus of elasticity of each segment, in Pa.
    std::vector<std::vector<double>> moduli;
    /// As plant_pose::tails.
    std::vector<point_list> tails;
    /// As plant_pose::rotations.
    std::vector<std::vector<std::array<double, 4>>> rotations;
};

namespace detail {

/// The numbers at `flat`, `count` rows of them.
template <class Row>
std::vector<std::vector<Row>> rows_of(const std::vector<Row>& flat, std::size_t count) {
    std::vector<std::vector<Row>> rows(count);
    const std::size_t n = count > 0 ? flat.size() / count : 0;
    for (std::size_t i = 0; i < count; ++i) {
        rows[i].assign(flat.begin() + i * n, flat.begin() + (i + 1) * n);
    }
    return rows;
}

}  // namespace detail

class rods;

/// The water in a plant. One owner, one thread at a time; plants share nothing.
class plant {
public:
    /// A plant in a file: .txt, .swc, .mtg or .obj.
    explicit plant(const std::string& path, const plant_options& how = {}) : watcher_(how.progress) {
        make(how, [&](auto params, auto out) { return cata_plant_read(path.c_str(), params, out); });
    }

    /// Creates a plant of at least one segment, all in one tree.
    explicit plant(const plant_segments& of, const plant_options& how = {}) : watcher_(how.progress) {
        const std::size_t n = of.tails.size();
        detail::require(of.radii.size() == n && of.parents.size() == n && of.kinds.size() == n,
                        CATA_ERR_SHAPE, "radii, parents and kinds: must be as many as tails");
        make(how, [&](auto params, auto out) {
            return cata_plant_new(n, detail::first_of(of.tails), of.radii.data(), of.parents.data(),
                                  of.kinds.data(), of.base ? of.base->data() : nullptr, params, out);
        });
    }

    /// A plant in a file, in the units of the file: metres in a unit of its lengths, and in one of
    /// its radii. `individual` is the name of one of several plants in an .mtg file.
    static plant read(const std::string& path, const std::array<double, 2>& unit,
                      const std::string& individual = {}, const plant_options& how = {}) {
        plant found(how.progress);
        found.make(how, [&](auto params, auto out) {
            return cata_plant_read_with(path.c_str(), unit.data(), individual.c_str(), params, out);
        });
        return found;
    }

    /// A plant of n >= 1 nodes that grows at random, the same for the same seed.
    static plant grow(std::size_t n, std::uint64_t seed, const plant_options& how = {}) {
        plant grown(how.progress);
        grown.make(how, [&](auto params, auto out) { return cata_plant_grow(n, seed, params, out); });
        return grown;
    }

    /// Number of nodes, each at the end of a segment.
    std::size_t size() const noexcept { return cata_plant_size(get()); }

    /// As the plant was given, with its base.
    plant_segments segments() const {
        plant_segments found;
        const std::size_t n = size();
        found.tails.resize(n);
        found.radii.resize(n);
        found.parents.resize(n);
        found.kinds.resize(n);
        detail::check(cata_plant_segments(get(), n, detail::first_of(found.tails), found.radii.data(),
                                          found.parents.data(), found.kinds.data(),
                                          found.base.emplace().data()));
        return found;
    }

    /// Returns the water of each node when its cells are full, in kg.
    std::vector<double> full_water() const {
        std::vector<double> water(size());
        detail::check(cata_plant_full_water(get(), size(), water.data()));
        return water;
    }

    /// Changes what all leaves give off, in kg / (s m^2), from now on.
    void set_loss(double loss) { detail::check(cata_plant_set_loss(handle_.get(), loss)); }
    /// Changes what the root takes from the soil, in kg / s, from now on.
    void set_intake(double intake) { detail::check(cata_plant_set_intake(handle_.get(), intake)); }
    /// Multiplies the conductance between a node, not the root, and its parent; 0 cuts them apart.
    void weaken(std::size_t node, double factor) {
        detail::check(cata_plant_weaken(handle_.get(), node, factor));
    }

    /// The rates at which the modes of the water decay, ascending, in 1 / s; of order n^3.
    std::vector<double> rates() const {
        std::vector<double> rates(size());
        detail::check(cata_plant_rates(get(), size(), rates.data()));
        return rates;
    }

    /// Returns the water of each node, in kg, `seconds` after `water`, without time steps.
    std::vector<double> water_after(const std::vector<double>& water, double seconds) const {
        std::vector<double> result(water.size());
        watcher_.finish(
            cata_plant_water_after(get(), water.size(), water.data(), seconds, result.data()));
        return result;
    }

    /// The water, in kg, at each of `times`, in s, ascending, from `water` at time 0 on. The parts
    /// of `day` come again and again; none: the loss is that of the plant.
    std::vector<std::vector<double>> water_curve(const std::vector<double>& water,
                                                 const std::vector<double>& times,
                                                 const std::vector<plant_interval>& day = {}) const {
        std::vector<double> result(times.size() * water.size());
        watcher_.finish(cata_plant_water_curve(get(), water.size(), water.data(), times.size(),
                                               times.data(), day.size(), numbers(day),
                                               result.data()));
        return detail::rows_of(result, times.size());
    }

    /// Makes `water`, in kg, the present of step(), which takes `step` seconds.
    void start(const std::vector<double>& water, double step) {
        detail::check(cata_plant_start(handle_.get(), water.size(), water.data(), step));
    }

    /// Goes `count` steps ahead; the water there.
    std::vector<double> step(std::size_t count = 1) {
        std::vector<double> water(size());
        watcher_.finish(cata_plant_step(handle_.get(), count, size(), water.data()));
        return water;
    }

    /// Modulus of elasticity of every segment, in Pa, from its water, in kg.
    std::vector<double> stiffness(const std::vector<double>& water) const {
        std::vector<double> moduli(water.size());
        detail::check(cata_plant_stiffness(get(), water.size(), water.data(), moduli.data()));
        return moduli;
    }

    /// Water, stiffness and pose at rest at each of `times`, from full cells on, with the constants
    /// of `rods`, which are those of this plant; null: the defaults.
    inline wilting wilt(const std::vector<double>& times, const std::vector<plant_interval>& day = {},
                        const rods* rods = nullptr) const;

    /// The handle, owned by this.
    const cata_plant* get() const noexcept { return handle_.get(); }

private:
    struct free {
        void operator()(cata_plant* handle) const noexcept { cata_plant_free(handle); }
    };

    explicit plant(const std::function<bool(double)>& progress) : watcher_(progress) {}

    template <class Make>
    void make(const plant_options& how, Make call) {
        cata_plant_params params;
        detail::check(cata_plant_params_init(&params, sizeof params));
        params.threads = how.threads;
        params.loss = how.loss;
        params.intake = how.intake;
        params.conductance = how.conductance;
        params.modulus = how.modulus;
        params.viscosity = how.viscosity;
        params.density = how.density;
        params.elasticity_full = how.elasticity_full;
        params.elasticity_dry = how.elasticity_dry;
        params.elasticity_steepness = how.elasticity_steepness;
        params.elasticity_shift = how.elasticity_shift;
        watcher_.attach(params);
        cata_plant* handle = nullptr;
        detail::check(call(&params, &handle));
        handle_.reset(handle);
    }

    static const double* numbers(const std::vector<plant_interval>& day) noexcept {
        static_assert(sizeof(plant_interval) == 2 * sizeof(double), "seconds and loss in turn");
        return day.empty() ? nullptr : &day.front().seconds;
    }

    detail::kept_watcher watcher_;
    std::unique_ptr<cata_plant, free> handle_;
};

/// The segments of a plant as rods, in a pose. One owner.
class rods {
public:
    /// Creates rods with full cells, in the pose of the plant, which need not outlive them.
    explicit rods(const plant& of, const rods_options& how = {})
        : size_(of.size()), watcher_(how.progress) {
        cata_plant_rods_params params;
        detail::check(cata_plant_rods_params_init(&params, sizeof params));
        for (std::size_t i = 0; i < 3; ++i) {
            params.gravity[i] = how.gravity[i];
        }
        params.poisson = how.poisson;
        params.dry_density = how.dry_density;
        params.tolerance = how.tolerance;
        params.iterations = how.iterations;
        params.step = how.step;
        params.step_iterations = how.step_iterations;
        params.damping = how.damping;
        watcher_.attach(params);
        cata_plant_rods* handle = nullptr;
        detail::check(cata_plant_rods_new(of.get(), &params, &handle));
        handle_.reset(handle);
    }

    /// Changes moduli of elasticity, in Pa, and water, in kg, of all segments; the pose stays.
    void set_state(const std::vector<double>& moduli, const std::vector<double>& water) {
        detail::require(moduli.size() == water.size(), CATA_ERR_SHAPE,
                        "moduli and water: must be as many");
        detail::check(
            cata_plant_rods_set_state(handle_.get(), water.size(), moduli.data(), water.data()));
    }

    /// Sets a pose at rest by rotations; empty: the pose of the plant.
    void set_pose(const std::vector<std::array<double, 4>>& rotations = {}) {
        detail::check(cata_plant_rods_set_pose(handle_.get(),
                                               rotations.empty() ? size_ : rotations.size(),
                                               detail::first_of(rotations)));
    }

    /// Returns where the segments are.
    plant_pose pose() const {
        plant_pose found;
        found.heads.resize(size_);
        found.tails.resize(size_);
        found.rotations.resize(size_);
        detail::check(cata_plant_rods_pose(get(), size_, detail::first_of(found.heads),
                                           detail::first_of(found.tails),
                                           detail::first_of(found.rotations)));
        return found;
    }

    /// Moves to a pose of equilibrium, at rest. Returns the torque out of balance, in units of
    /// rods_options::tolerance.
    double relax() {
        double residual = 0.0;
        watcher_.finish(cata_plant_rods_relax(handle_.get(), nullptr, &residual));
        return residual;
    }

    /// Lets them move for `count` steps; the largest gap between a segment and its parent, in m.
    double step(std::size_t count = 1) {
        double gap = 0.0;
        watcher_.finish(cata_plant_rods_step(handle_.get(), count, &gap));
        return gap;
    }

    /// The pose as a mesh of tubes of `sides` >= 3 sides, with radii of at least `thinnest` m.
    plant_tubes tubes(std::size_t sides, double thinnest = 0.0) const {
        // The sizes of larger ones might wrap around; the call refuses them anyway.
        detail::require(sides < 65536, CATA_ERR_ARGUMENT, "sides: 65536 or more");
        plant_tubes found;
        found.vertices.resize(2 * size_ * sides);
        found.faces.resize(2 * size_ * sides);
        detail::check(cata_plant_rods_tubes(get(), size_, sides, thinnest,
                                            detail::first_of(found.vertices),
                                            detail::first_of(found.faces)));
        return found;
    }

    /// The handle, owned by this.
    const cata_plant_rods* get() const noexcept { return handle_.get(); }

private:
    struct free {
        void operator()(cata_plant_rods* handle) const noexcept { cata_plant_rods_free(handle); }
    };

    std::size_t size_;
    detail::kept_watcher watcher_;
    std::unique_ptr<cata_plant_rods, free> handle_;
};

wilting plant::wilt(const std::vector<double>& times, const std::vector<plant_interval>& day,
                    const rods* rods) const {
    const std::size_t n = size(), count = times.size();
    std::vector<double> water(count * n), moduli(count * n);
    point_list tails(count * n);
    std::vector<std::array<double, 4>> rotations(count * n);
    watcher_.finish(cata_plant_wilt(get(), rods ? rods->get() : nullptr, count, times.data(),
                                    day.size(), numbers(day), n, water.data(), moduli.data(),
                                    detail::first_of(tails), detail::first_of(rotations)));
    return {detail::rows_of(water, count), detail::rows_of(moduli, count),
            detail::rows_of(tails, count), detail::rows_of(rotations, count)};
}

}  // namespace catamaran

#endif
