// A plant that dries for four days, hangs its head, is watered, and swings up again: water, stiffness, poses at rest, motion, and
// a mesh of each moment for a renderer. With --obj the last one is written as plant.obj.

#include <catamaran.hpp>

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <string>

namespace {

double height(const std::vector<std::array<double, 3>>& tails) {
    double sum = 0.0;
    for (const auto& tail : tails) {
        sum += tail[2] / static_cast<double>(tails.size());
    }
    return sum;
}

void write(const catamaran::plant_tubes& mesh, const char* path) {
    std::FILE* file = std::fopen(path, "w");
    if (file == nullptr) {
        return;
    }
    for (const auto& p : mesh.vertices) {
        std::fprintf(file, "v %g %g %g\n", p[0], p[1], p[2]);
    }
    for (const auto& f : mesh.faces) {
        std::fprintf(file, "f %u %u %u\n", f[0] + 1, f[1] + 1, f[2] + 1);
    }
    std::fclose(file);
}

}  // namespace

int main(int argc, char** argv) try {
    const double hour = 3600.0, loss = 100.0 / 3.6e6;
    const catamaran::plant plant = catamaran::plant::grow(600, 1);
    const std::vector<catamaran::plant_interval> day{{16 * hour, loss}, {8 * hour, loss / 12}};
    const std::vector<double> times{0.0, 24 * hour, 48 * hour, 96 * hour};
    const auto drought = plant.wilt(times, day);
    for (std::size_t i = 0; i < drought.water.size(); ++i) {
        double water = 0.0;
        for (double kg : drought.water[i]) {
            water += kg;
        }
        std::printf("%3.0f h: %.2f g of water, %.1f mm high in the mean\n", times[i] / hour,
                    1e3 * water, 1e3 * height(drought.tails[i]));
    }

    // Watered: full cells again, from where it hangs.
    catamaran::rods_options how;
    how.damping = 12.0;
    catamaran::rods rods(plant, how);
    rods.set_pose(drought.rotations.back());
    double gap = 0.0;
    for (int frame = 0; frame < 10; ++frame) {
        gap = std::max(gap, rods.step(60));
    }
    const double up = height(rods.pose().tails);
    std::printf("watered: %.1f mm, segments at most %.1e m apart\n", 1e3 * up, gap);
    const auto mesh = rods.tubes(6);
    if (argc > 1 && std::string(argv[1]) == "--obj") {
        write(mesh, "plant.obj");
    }
    // It sank, and is back where it was.
    const double first = height(drought.tails.front()), last = height(drought.tails.back());
    if (!(last < 0.99 * first && std::abs(up / first - 1.0) < 1e-3 && gap < 1e-5 &&
          mesh.vertices.size() == 12 * plant.size())) {
        std::fprintf(stderr, "MISMATCH: %g %g %g\n", first, last, up);
        return EXIT_FAILURE;
    }
    return EXIT_SUCCESS;
} catch (const catamaran::error& error) {
    std::fprintf(stderr, "%s\n", error.what());
    return EXIT_FAILURE;
}
