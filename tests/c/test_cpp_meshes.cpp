// Decimation, curves and accumulators from C++.

#include <catamaran.hpp>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>
#include <string>
#include <vector>

#include "check.hpp"

namespace {

const std::vector<std::array<double, 3>> octahedron{{{1, 0, 0}},  {{-1, 0, 0}}, {{0, 1, 0}},
                                                    {{0, -1, 0}}, {{0, 0, 1}},  {{0, 0, -1}}};
const std::vector<std::array<std::uint32_t, 3>> octants{
    {{0, 2, 4}}, {{2, 1, 4}}, {{1, 3, 4}}, {{3, 0, 4}},
    {{2, 0, 5}}, {{1, 2, 5}}, {{3, 1, 5}}, {{0, 3, 5}}};

// An octahedron, split into many faces, and taken back.
void decimations() {
    const catamaran::mesh_view small{octahedron, octants};
    catamaran::decimation_options how;
    how.threads = 2;
    const catamaran::decimation fine(small, 102, how);
    CHECK(fine.vertices().size() == 102 && fine.faces().size() == 200 && !fine.repaired());
    CHECK(fine.places().cells.size() == 6 && fine.places().faces.size() == 102);
    how.first = 7;
    const catamaran::decimation coarse(fine.mesh(), 20, how);
    CHECK(coarse.vertices().size() == 20 && coarse.faces().size() == 36);
    for (const std::uint32_t cell : coarse.places().cells) {
        CHECK(cell < 20);
    }
    how.threads = 1;
    CHECK(catamaran::decimation(fine.mesh(), 20, how).vertices() == coarse.vertices());

    // What is linear stays so, but for what the new vertices are beside the surface.
    std::vector<double> heights;
    for (const auto& p : fine.vertices()) {
        heights.push_back(p[2]);
    }
    const auto carried = coarse.carry(heights);
    for (std::size_t v = 0; v < carried.size(); ++v) {
        CHECK(std::abs(carried[v] - coarse.vertices()[v][2]) < 0.2);
    }
    CHECK(coarse.prolong(carried).size() == 102);
    CHECK(coarse.carry_uv(std::vector<std::array<double, 6>>(200, {{0, 0, 1, 0, 0, 1}})).size() == 36);
    CHECK(status_of([&] { coarse.carry({1, 2}); }) == CATA_ERR_SHAPE);
    CHECK(status_of([&] { coarse.prolong({1, 2}); }) == CATA_ERR_SHAPE);
    CHECK(status_of([&] { coarse.carry_uv({}); }) == CATA_ERR_SHAPE);

    how.first.reset();
    // The same face twice is left out, which is told.
    std::vector<std::array<std::uint32_t, 3>> twice = fine.faces();
    twice.push_back(twice[0]);
    CHECK(catamaran::decimation({fine.vertices(), twice}, 20, how).repaired());
    how.progress = [](double) { return false; };
    CHECK(status_of([&] { catamaran::decimation(fine.mesh(), 20, how); }) == CATA_ERR_CANCELLED);
    CHECK(status_of([&] { catamaran::decimation(small, 3); }) == CATA_ERR_ARGUMENT);
    // More vertices than the input has: its edges are split, unless they are to stay.
    CHECK(catamaran::decimation(small, 7).vertices().size() == 7);
    catamaran::decimation_options whole;
    whole.keep_edges = true;
    CHECK(status_of([&] { catamaran::decimation(small, 7, whole); }) == CATA_ERR_ARGUMENT);
    const std::vector<std::array<std::uint32_t, 3>> beyond{{{0, 1, 6}}};
    CHECK(status_of([&] { catamaran::decimation({octahedron, beyond}, 4); }) == CATA_ERR_MESH);
    // As few vertices as an error allows.
    const auto near = catamaran::decimation::within(small, 0.1);
    CHECK(near.bound() > 0 && near.bound() <= 0.1);
    CHECK(near.vertices().size() > catamaran::decimation::within(small, 0.3).vertices().size());
    CHECK(status_of([&] { catamaran::decimation::within(small, 0); }) == CATA_ERR_ARGUMENT);
    // Locked vertices are the first ones.
    catamaran::decimation_options locks;
    locks.locked = {5, 90, 17};
    const catamaran::decimation stays(fine.mesh(), 40, locks);
    for (std::size_t i = 0; i < 3; ++i) {
        CHECK(stays.vertices()[i] == fine.vertices()[locks.locked[i]]);
    }
    CHECK(stays.locked_edges().lost <= stays.locked_edges().edges);
    locks.locked = {0, 1, 2, 3, 4, 5};
    const catamaran::decimation corners(small, 100, locks);
    CHECK(corners.locked_edges().edges == 12 && corners.locked_edges().lost == 12);

    // A density for each vertex, and one by curvature.
    catamaran::decimation_options dense;
    dense.density.assign(fine.vertices().size(), 1);
    CHECK(catamaran::decimation(fine.mesh(), 40, dense).vertices() ==
          catamaran::decimation(fine.mesh(), 40).vertices());
    dense.density.front() = 5;
    dense.curvature = 4;
    CHECK(catamaran::decimation(fine.mesh(), 40, dense).vertices() !=
          catamaran::decimation(fine.mesh(), 40).vertices());
    dense.density.pop_back();
    CHECK(status_of([&] { catamaran::decimation(fine.mesh(), 40, dense); }) == CATA_ERR_ARGUMENT);

    const catamaran::sampling points = catamaran::farthest_points(fine.mesh(), 6);
    CHECK(points.samples.size() == 6 && points.nearest[points.samples[5]] == 5);
    CHECK(*std::max_element(points.distances.begin(), points.distances.end()) < 1.5f);
    CHECK(status_of([&] { catamaran::farthest_points(small, 7); }) == CATA_ERR_ARGUMENT);
}

// Once around the equator of an octahedron.
void curves() {
    const catamaran::mesh_view mesh{octahedron, octants};
    catamaran::curve_solver solver(mesh);
    for (int time = 0; time < 2; ++time) {
        const auto found = solver.find({0, 1, 2, 3});
        CHECK(found.outcome == catamaran::curve_outcome::closed && found.curves.size() == 1);
        const catamaran::curve& one = found.curves[0];
        CHECK(one.order.size() == 4 && one.path.size() == 4 && found.left_out.empty());
        CHECK(one.points[0] == octahedron[one.path[0]]);
        CHECK(std::abs(one.length - 4 * std::sqrt(2.0)) < 1e-12);
    }
    CHECK(status_of([&] { solver.find({0, 1, 6}); }) == CATA_ERR_ARGUMENT);
    catamaran::curve_options how;
    how.smooth = true;
    CHECK(solver.find({0, 2, 4}, how).curves[0].points.size() == 3);
    how.progress = [](double) { return false; };
    CHECK(status_of([&] { solver.find({0, 1, 2}, how); }) == CATA_ERR_CANCELLED);
    how.progress = [](double) -> bool { throw std::string("stop"); };
    try {
        solver.find({0, 1, 2}, how);
        CHECK(false);
    } catch (const std::string& thrown) {
        CHECK(thrown == "stop");
    }

    catamaran::curve_site inside;
    inside.face = 0;
    inside.weights = {{0.25, 0.25, 0.5}};
    catamaran::curve_site near;
    near.weights = {{-2, 0, 0}};
    const catamaran::curve_solver refined(mesh, {inside, near});
    CHECK((refined.samples() == std::vector<std::uint32_t>{6, 1}));

    // The points of a curve are on faces of the mesh before the site cut one of them.
    catamaran::curve_solver cut(mesh, {inside, near});
    how = {};
    how.smooth = true;
    const auto found = cut.find({6, 1, 3}, how);
    for (const catamaran::curve& one : found.curves) {
        CHECK(one.points.size() >= 3 && one.faces.size() == one.points.size());
        for (std::size_t i = 0; i < one.points.size(); ++i) {
            const auto& face = octants.at(one.faces[i]);
            for (std::size_t k = 0; k < 3; ++k) {
                double at = -one.points[i][k];
                for (std::size_t j = 0; j < 3; ++j) {
                    at += one.weights[i][j] * octahedron[face[j]][k];
                }
                CHECK(std::abs(at) < 1e-12);
            }
        }
    }
    CHECK(!found.curves.empty() && found.outliers.empty());
}

// Rows of (1, t, 2 + 3 t) in two blocks.
void accumulators() {
    std::vector<double> rows;
    for (int t = 0; t < 10; ++t) {
        rows.insert(rows.end(), {1.0, double(t), 2.0 + 3.0 * t});
    }
    const auto block = [&](std::size_t first, std::size_t count) {
        return catamaran::row_major<const double>(rows.data() + 3 * first, count, 3);
    };
    catamaran::accumulator_options how;
    how.sums = catamaran::sums::extended;
    how.lower = {0, 0, 0};
    how.upper = {1, 10, 100};
    how.rows = 20;
    catamaran::accumulator sums(3, how), others(3, how);
    sums.add(block(0, 4));
    others.add(block(4, 6));
    sums.merge(others);
    CHECK(sums.rows() == 10 && sums.gram()[4] == 285 && sums.gram(2)[1] == 90);
    const auto fit = sums.lstsq(1);
    CHECK(std::abs(fit.coefficients[0] - 2) < 1e-14 && std::abs(fit.coefficients[1] - 3) < 1e-14);
    CHECK(fit.rank == 2 && fit.dependent.empty());
    sums.remove(block(4, 6));
    CHECK(sums.gram()[4] == 14);

    const std::string name = "test_cpp_meshes.sums";
    sums.save(name);
    CHECK(catamaran::accumulator::load(name, 3).gram() == sums.gram());
    std::remove(name.c_str());
    CHECK(status_of([&] { catamaran::accumulator::load(name, 3); }) == CATA_ERR_IO);

    how.centered = true;
    int calls = 0;
    how.progress = [&](double) { return ++calls > 0; };
    catamaran::accumulator moved = catamaran::accumulator(3, how), centred = std::move(moved);
    centred.add(block(0, 10));
    CHECK(calls > 0 && centred.mean()[1] == 4.5);
    const auto found = centred.pca(1);
    CHECK(std::abs(found.components[2] / found.components[1] - 3) < 1e-12);
    catamaran::lstsq_options fitting;
    catamaran::pca_options analysing;
    fitting.intercept = true;
    fitting.progress = analysing.progress = [](double) { return false; };
    CHECK(status_of([&] { centred.lstsq(1, fitting); }) == CATA_ERR_CANCELLED);
    CHECK(status_of([&] { centred.pca(1, analysing); }) == CATA_ERR_CANCELLED);
    CHECK(status_of([&] { centred.merge(sums); }) == CATA_ERR_ARGUMENT);
    CHECK(status_of([&] { centred.pca(4); }) == CATA_ERR_ARGUMENT);
    CHECK(status_of([&] { sums.add(catamaran::row_major<const double>(rows.data(), 2, 4)); }) ==
          CATA_ERR_SHAPE);
    how.lower.pop_back();
    CHECK(status_of([&] { catamaran::accumulator(3, how); }) == CATA_ERR_SHAPE);
}

}  // namespace

int main() {
    decimations();
    curves();
    accumulators();
    return report("test_cpp_meshes");
}
