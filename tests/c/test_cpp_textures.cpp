// The C++ layer of plants, slime moulds, Newton fractals and devices.

#include <catamaran.hpp>

#include <cmath>
#include <cstdlib>
#include <cstring>
#include <stdexcept>
#include <string>
#include <thread>
#include <type_traits>
#include <vector>

#include "check.hpp"

namespace {

static_assert(!std::is_copy_constructible<catamaran::plant>::value, "one owner");
static_assert(std::is_nothrow_move_constructible<catamaran::rods>::value, "movable");
static_assert(std::is_nothrow_move_assignable<catamaran::slime>::value, "movable");

void plants() {
    const catamaran::plant_segments stem{{{{0, 0, 0.1}}, {{0, 0, 0.2}}},
                                         {1e-3, 1e-3},
                                         {CATA_NO_PARENT, 0},
                                         {CATA_PLANT_STEM, CATA_PLANT_LEAF},
                                         {}};
    catamaran::plant plant(stem);
    const std::vector<double> full = plant.full_water();
    CHECK(plant.size() == 2 && full.size() == 2);
    CHECK((plant.segments().tails == stem.tails && plant.segments().kinds == stem.kinds));
    CHECK((*plant.segments().base == std::array<double, 3>{{0, 0, 0}}));
    plant.set_loss(1e-5);
    const std::vector<double> later = plant.water_after(full, 3600.0);
    plant.start(full, 360.0);
    const std::vector<double> stepped = plant.step(10);
    CHECK(later[0] + later[1] < full[0] + full[1]);
    CHECK(std::abs(stepped[1] - later[1]) < 1e-6 * full[1]);
    const auto curve = plant.water_curve(full, {0, 3600.0});
    CHECK(curve.size() == 2 && curve[0] == full && std::abs(curve[1][1] - later[1]) < 1e-9 * full[1]);
    const auto dark = plant.water_curve(full, {3600.0}, {{7200.0, 0.0}});
    CHECK(std::abs(dark[0][0] - full[0]) < 1e-9 * full[0]);
    CHECK(plant.stiffness(later)[1] < 5e7 && plant.rates().size() == 2);
    CHECK(status_of([&] { plant.weaken(0, 0.5); }) == CATA_ERR_ARGUMENT);
    CHECK(status_of([&] { plant.water_after({1.0}, 1.0); }) == CATA_ERR_SHAPE);
    CHECK(status_of([] { catamaran::plant("/no/such/plant.txt"); }) == CATA_ERR_IO);
    catamaran::plant_segments odd = stem;
    odd.radii.pop_back();
    CHECK(status_of([&] { catamaran::plant{odd}; }) == CATA_ERR_SHAPE);
}

void poses() {
    catamaran::plant_options how;
    how.loss = 2e-5;
    int calls = 0;
    bool throws = false;
    how.progress = [&](double) {
        if (throws) {
            throw std::runtime_error("enough");
        }
        return ++calls > 0;
    };
    const catamaran::plant made = catamaran::plant::grow(40, 1, how);
    how.progress = nullptr;
    catamaran::plant moved = catamaran::plant::grow(2, 1);
    moved = catamaran::plant::grow(40, 1, how);
    CHECK(moved.full_water() == made.full_water());
    catamaran::rods rods(made);
    const auto found = made.wilt({0, 3e5});
    CHECK(calls > 2 && found.water.size() == 2 && found.tails[1].size() == 40);
    CHECK(found.rotations == made.wilt({0, 3e5}, {}, &rods).rotations);
    rods.set_state(found.moduli[0], found.water[0]);
    CHECK(rods.relax() <= 1e-8);
    CHECK(rods.pose().rotations == found.rotations[0] && rods.pose().tails == found.tails[0]);
    rods.set_pose(found.rotations[1]);
    CHECK(rods.pose().heads.size() == 40);
    const auto mesh = rods.tubes(3);
    CHECK(mesh.vertices.size() == 240 && mesh.faces.back()[2] < 240);
    rods.set_pose();
    CHECK(rods.step(5) < 1e-4);
    // What progress throws comes out, and once only.
    throws = true;
    bool caught = false;
    try {
        made.wilt({1e3});
    } catch (const std::runtime_error& error) {
        caught = std::strcmp(error.what(), "enough") == 0;
    }
    throws = false;
    CHECK(caught && made.wilt({1e3}).water.size() == 1);
    CHECK(status_of([&] { rods.set_state({1.0}, {1.0, 2.0}); }) == CATA_ERR_SHAPE);
    CHECK(status_of([&] { rods.set_pose({{{1, 0, 0, 0}}}); }) == CATA_ERR_SHAPE);
    CHECK(status_of([&] { rods.tubes(1); }) == CATA_ERR_ARGUMENT);
    catamaran::rods_options odd;
    odd.poisson = -2;
    CHECK(status_of([&] { catamaran::rods(made, odd); }) == CATA_ERR_ARGUMENT);
}

const std::vector<std::array<double, 3>> corners{{{0, 0, 0}}, {{1, 0, 0}}, {{1, 1, 0}}, {{0, 1, 0}}};
const std::vector<std::array<std::uint32_t, 3>> halves{{{0, 1, 2}}, {{0, 2, 3}}};

void slimes() {
    const catamaran::mesh_view square(corners, halves);
    catamaran::slime_options how;
    how.agents = 50;
    how.size = 32;
    int calls = 0, last = 1 << 30;
    how.progress = [&](double) { return ++calls < last; };
    catamaran::slime slime(square, how);
    slime.step(3);
    CHECK(calls == 3 && slime.texture().size() == 32 * 32 && slime.steps() == 3);
    const auto [coverage, presence] = slime.coverage();
    CHECK(0 < coverage && coverage <= presence);
    CHECK(status_of([&] { slime.texture(1); }) == CATA_ERR_ARGUMENT);
    last = 4;
    CHECK(status_of([&] { slime.step(2); }) == CATA_ERR_CANCELLED);
    CHECK(slime.steps() == 4 && slime.uv().size() == 2);
    CHECK(status_of([&] { catamaran::slime(square, how, {{{0}}}); }) == CATA_ERR_SHAPE);
    CHECK(status_of([&] { catamaran::slime(square, how, {}, {1, 2}); }) == CATA_ERR_SHAPE);
    // Without a size, masks are as large as the texture that the library makes by default.
    how.size = 0;
    CHECK(status_of([&] { catamaran::slime(square, how, {}, {1, 2}); }) == CATA_ERR_SHAPE);
    const std::vector<std::uint8_t> everywhere(CATA_SLIME_SIZE * CATA_SLIME_SIZE, 1);
    CHECK(catamaran::slime(square, how, {}, everywhere).size() == CATA_SLIME_SIZE);
    how.progress = nullptr;
    how.lengths = catamaran::slime_lengths::texture;
    CHECK(catamaran::slime(square, how, slime.uv()).uv() == slime.uv());
}

void newton_fractals() {
    catamaran::newton newton;
    const auto found = newton.points({1, 0, 0, -0.5F, 0.8660254F, 0});
    CHECK((found.roots == std::vector<std::uint16_t>{0, 4}) && found.convergence[0] == -1);
    CHECK(newton.colors(found).size() == 6);
    CHECK(newton.plane(3, 2, {{0, 0}}, 2.0).roots.size() == 6);
    newton.set_w(0.5);
    CHECK(status_of([&] { newton.points({1, 2}); }) == CATA_ERR_SHAPE);
    CHECK(status_of([&] { newton.plane(2, 2, {{0, 0}}, 0.0); }) == CATA_ERR_ARGUMENT);
    catamaran::newton_options how;
    how.roots = {{{2, 1}}, {{-2, 0}}};
    how.gradient = catamaran::newton_gradient::shader;
    how.progress = [](double) { return false; };
    CHECK(status_of([&] { catamaran::newton(how).points({2, 1, 0}); }) == CATA_ERR_CANCELLED);
    how.progress = nullptr;
    CHECK((catamaran::newton(how).points({-2, 0, 0}).roots == std::vector<std::uint16_t>{3}));
}

void on_devices() {
    catamaran::slime_options how;
    how.agents = 300;
    how.size = 32;
    how.device = "0";
    const catamaran::mesh_view square(corners, halves);
    std::vector<catamaran::device> devices;
    try {
        devices = catamaran::devices();
    } catch (const catamaran::error& error) {
        const bool has_opencl = (cata_capabilities() & CATA_CAP_OPENCL) != 0;
        CHECK(error.status() == (has_opencl ? CATA_ERR_BACKEND : CATA_ERR_UNSUPPORTED));
        CHECK(!has_opencl || std::getenv("CATAMARAN_REQUIRE_OPENCL") == nullptr);
        CHECK(status_of([&] { catamaran::slime(square, how); }) == error.status());
        std::puts("no OpenCL device: its test is left out");
        return;
    }
    CHECK(!devices.empty() && !devices[0].name.empty());
    catamaran::slime there(square, how);
    how.device.reset();
    catamaran::slime here(square, how);
    here.step(5);
    there.step(5);
    CHECK(there.steps() == 5);
    if (devices[0].kind == catamaran::device_kind::cpu) {
        CHECK(here.texture() == there.texture() && here.coverage() == there.coverage());
    }
    // What only reads may be called at the same time.
    const auto covered = there.coverage();
    std::array<bool, 4> same{};
    std::vector<std::thread> readers;
    for (bool& is_same : same) {
        readers.emplace_back([&] {
            is_same = true;
            for (int i = 0; i < 20; ++i) {
                is_same = is_same && there.coverage() == covered && there.texture().size() == 1024;
            }
        });
    }
    for (std::thread& reader : readers) {
        reader.join();
    }
    CHECK((same == std::array<bool, 4>{{true, true, true, true}}));
    catamaran::newton_options what;
    what.device = "0";
    CHECK(catamaran::newton(what).points({1, 0, 0}).roots[0] == 0);
}

}  // namespace

int main() {
    plants();
    poses();
    slimes();
    newton_fractals();
    on_devices();
    return report("cpp_textures");
}
