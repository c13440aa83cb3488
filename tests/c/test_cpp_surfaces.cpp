// Topology, measures, comparison, isosurfaces, generated meshes, two levels and plans from C++.

#include <catamaran.hpp>

#include <cmath>
#include <cstdint>
#include <string>
#include <utility>
#include <vector>

#include "check.hpp"

namespace {

using catamaran::mesh_view;
using catamaran::point_list;
using catamaran::triangle_list;

const point_list octahedron{{{1, 0, 0}},  {{-1, 0, 0}}, {{0, 1, 0}},
                            {{0, -1, 0}}, {{0, 0, 1}},  {{0, 0, -1}}};
const triangle_list octants{{{0, 2, 4}}, {{2, 1, 4}}, {{1, 3, 4}}, {{3, 0, 4}},
                            {{2, 0, 5}}, {{1, 2, 5}}, {{3, 1, 5}}, {{0, 3, 5}}};

bool near(double x, double expected, double tolerance = 1e-12) {
    return std::abs(x - expected) <= tolerance;
}

void topology() {
    const auto torus = catamaran::shape("torus", {12, 6}, {2, 0.5});
    const auto edges = catamaran::edges_of(torus.mesh());
    CHECK(edges.ends.size() == 216 && edges.ends[0][0] == 0 && edges.ends[0][1] == 1);
    CHECK(edges.face_counts == std::vector<std::uint32_t>(216, 2));
    const auto closed = catamaran::genus_of(torus.mesh());
    CHECK(closed.genus == 1 && closed.orientable);
    CHECK(catamaran::boundary_loops(torus.mesh()).empty());

    const auto tube = catamaran::shape("cylinder", {8, 2}, {1, 1});
    const auto loops = catamaran::boundary_loops(tube.mesh());
    CHECK(loops.size() == 2 && loops[0].size() == 8 && loops[1].size() == 8);
    CHECK(loops.size() == 2 && loops[0][0] != loops[1][0]);
    CHECK(catamaran::genus_of(tube.mesh()).genus == 0);

    // A strip that is twisted once: one side, one boundary.
    point_list points(10);
    triangle_list faces;
    for (std::uint32_t i = 0; i < 5; ++i) {
        points[2 * i] = {{1.0 * i, 0, 0}};
        points[2 * i + 1] = {{1.0 * i, 1, 0}};
        const std::uint32_t next[2] = {i < 4 ? 2 * i + 2 : 1, i < 4 ? 2 * i + 3 : 0};
        faces.push_back({{2 * i, next[0], 2 * i + 1}});
        faces.push_back({{2 * i + 1, next[0], next[1]}});
    }
    const auto strip = catamaran::genus_of({points, faces});
    CHECK(strip.genus == 1 && !strip.orientable);
    const auto around = catamaran::boundary_loops({points, faces});
    CHECK(around.size() == 1 && around[0].size() == 10);

    // Two triangles and a vertex between them; then a third face at an edge of the first one.
    const point_list seven(points.begin(), points.begin() + 7);
    triangle_list two{{{0, 1, 2}}, {{4, 5, 6}}};
    const auto parts = catamaran::components_of({seven, two});
    CHECK(parts.count == 2 && (parts.of_faces == std::vector<std::uint32_t>{0, 1}));
    CHECK((parts.of_vertices == std::vector<std::uint32_t>{0, 0, 0, UINT32_MAX, 1, 1, 1}));
    two = {{{0, 1, 2}}, {{0, 1, 4}}, {{0, 1, 6}}};
    CHECK(catamaran::edges_of({seven, two}).face_counts[0] == 3);
    CHECK(catamaran::quality_of({seven, two}).non_manifold_edges == 1);
    CHECK(status_of([&] { catamaran::genus_of({seven, two}); }) == CATA_ERR_MESH);
    CHECK(status_of([&] { catamaran::boundary_loops({seven, two}); }) == CATA_ERR_MESH);

    // Too little room: nothing is written.
    std::uint32_t ends[22] = {77};
    std::size_t count = 77, total = 77, lengths[11] = {77};
    const mesh_view solid(octahedron, octants);
    CHECK_STATUS(cata_mesh_edges(6, solid.vertices, 8, solid.faces, 11, ends, nullptr, &count),
                 CATA_ERR_SHAPE);
    CHECK(std::string(cata_last_error_message()) == "room: must be at least 12 (edges), is 11");
    const mesh_view open(octahedron, two = {octants[0]});
    CHECK_STATUS(cata_mesh_boundary_loops(6, open.vertices, 1, open.faces, 2, ends, lengths, &total,
                                          &count),
                 CATA_ERR_SHAPE);
    CHECK(ends[0] == 77 && lengths[0] == 77 && count == 77 && total == 77);
}

void measures() {
    const auto found = catamaran::measures_of({octahedron, octants});
    CHECK(near(found.area, 4 * std::sqrt(3.0)) && near(found.volume, 4.0 / 3));
    // Open, and with a face that runs the other way.
    auto broken = octants;
    broken.pop_back();
    CHECK(std::isnan(catamaran::measures_of({octahedron, broken}).volume));
    broken = octants;
    std::swap(broken[0][0], broken[0][1]);
    CHECK(std::isnan(catamaran::measures_of({octahedron, broken}).volume));
    for (std::size_t f = 0; f < 8; ++f) {
        CHECK(near(found.face_areas[f], std::sqrt(3.0) / 2) && near(found.qualities[f], 1));
        CHECK(near(std::abs(found.face_normals[f][2]), std::sqrt(1.0 / 3)));
    }
    for (std::size_t v = 0; v < 6; ++v) {
        for (std::size_t k = 0; k < 3; ++k) {
            CHECK(near(found.vertex_normals[v][k], octahedron[v][k]));
        }
    }
    const auto quality = catamaran::quality_of({octahedron, octants});
    CHECK(near(quality.mean_area, std::sqrt(3.0) / 2) && near(quality.area_variation, 0));
    CHECK(near(quality.mean_quality, 1) && near(quality.least_quality, 1));
    CHECK(near(quality.quality_deviation, 0) && quality.mean_valence == 4);
    CHECK(quality.regular_vertices == 0 && quality.non_manifold_edges == 0);
    point_list far = octahedron;
    far[5][2] = 1e80;
    CHECK(status_of([&] { catamaran::measures_of({far, octants}); }) == CATA_ERR_MESH);
    CHECK(status_of([&] { catamaran::quality_of({far, octants}); }) == CATA_ERR_MESH);
    CHECK(status_of([&] { catamaran::compare({octahedron, octants}, {far, octants}); }) ==
          CATA_ERR_MESH);
}

// Two squares, one half a unit above the other and upside down.
void comparisons() {
    const auto grid = catamaran::shape("grid", {4, 3});
    point_list above = grid.vertices();
    triangle_list turned = grid.faces();
    for (auto& p : above) p[2] = 0.5;
    for (auto& face : turned) std::swap(face[0], face[1]);
    catamaran::mesh_options how;
    how.threads = 2;
    const auto found = catamaran::compare(grid.mesh(), {above, turned}, how);
    for (const auto& side : {found.out, found.back}) {
        CHECK(near(side.largest, 0.5) && near(side.mean, 0.5, 1e-9) && near(side.angle, 180, 1e-9));
    }
    CHECK(near(found.hausdorff, 0.5) && near(found.chamfer, 0.5));
    // Only what is wanted is computed.
    double out[3] = {7, 7, 7};
    const mesh_view one = grid.mesh();
    CHECK_STATUS(cata_mesh_compare(one.n_vertices, one.vertices, one.n_faces, one.faces,
                                   one.n_vertices, one.vertices, one.n_faces, one.faces, out,
                                   nullptr, nullptr, nullptr, nullptr),
                 CATA_OK);
    CHECK(near(out[0], 0) && near(out[1], 0) && near(out[2], 0, 1e-6));
    how.progress = [](double) { return false; };
    CHECK(status_of([&] { catamaran::compare(one, one, how); }) == CATA_ERR_CANCELLED);
    CHECK(status_of([&] { catamaran::compare(one, {0, nullptr, 0, nullptr}); }) == CATA_ERR_MESH);
}

// The half of a cube where x is above 0.5, cut at its border; balls by values and by labels.
void isosurfaces() {
    catamaran::lattice cube;
    cube.counts = {{3, 3, 3}};
    cube.open = true;
    std::vector<float> x;
    for (int i = 0; i < 27; ++i) x.push_back(static_cast<float>(i % 3));
    const auto plane = catamaran::isosurface(cube, x, 0.5f);
    CHECK(near(catamaran::measures_of(plane.mesh()).area, 4));
    CHECK(catamaran::boundary_loops(plane.mesh()).size() == 1);
    for (const auto& p : plane.vertices()) CHECK(near(p[0], 0.5));

    catamaran::lattice fine;
    fine.counts = {{31, 31, 31}};
    fine.origin = {{-1.5, -1.5, -1.5}};
    fine.step = {{0.1, 0.1, 0.1}};
    std::vector<float> values;
    std::vector<std::uint16_t> labels;
    for (int i = 0; i < 31 * 31 * 31; ++i) {
        float value = 1;
        for (const int place : {i % 31, i / 31 % 31, i / 961}) {
            value -= std::pow(0.1f * static_cast<float>(place) - 1.5f, 2.0f);
        }
        values.push_back(value);
        labels.push_back(static_cast<std::uint16_t>(value > 0 ? 3 : 4));
    }
    const auto ball = catamaran::isosurface(fine, values, 0);
    CHECK(catamaran::boundary_loops(ball.mesh()).empty());
    CHECK(catamaran::genus_of(ball.mesh()).genus == 0);
    // Between points 0.1 apart, linear values are too small, by 0.75 x 0.1^2 at most; a vertex is
    // at least 1/1024 of its edge, of at most sqrt(3) x 0.1, away from the ends.
    const double pi = std::acos(-1.0), slack = 4 * pi * std::sqrt(3.0) * 0.1 / 1024;
    const double volume = catamaran::measures_of(ball.mesh()).volume;
    CHECK(volume < 4 * pi / 3 + slack);
    CHECK(volume > 4 * pi / 3 * std::pow(1 - 0.75 * 0.01, 1.5) - slack);
    // Borders of labels are halfway, as those of values 0 and 1.
    std::vector<float> zeros_and_ones;
    for (const auto label : labels) zeros_and_ones.push_back(label == 3 ? 1.0f : 0.0f);
    const auto labelled = catamaran::label_surface(fine, labels, 3);
    const auto halves = catamaran::isosurface(fine, zeros_and_ones, 0.5f);
    CHECK(labelled.vertices() == halves.vertices() && labelled.faces() == halves.faces());
    CHECK(!labelled.faces().empty());
    catamaran::mesh_options how;
    how.progress = [](double) { return false; };
    CHECK(status_of([&] { catamaran::isosurface(fine, values, 0, how); }) == CATA_ERR_CANCELLED);
    values[7] = NAN;
    CHECK(status_of([&] { catamaran::isosurface(fine, values, 0); }) == CATA_ERR_NON_FINITE);
    values.pop_back();
    labels.pop_back();
    CHECK(status_of([&] { catamaran::isosurface(fine, values, 0); }) == CATA_ERR_SHAPE);
    CHECK(status_of([&] { catamaran::label_surface(fine, labels, 3); }) == CATA_ERR_SHAPE);
    CHECK(status_of([&] { catamaran::isosurface(cube, x, NAN); }) == CATA_ERR_ARGUMENT);
    cube.step[1] = 0;
    CHECK(status_of([&] { catamaran::isosurface(cube, x, 0.5f); }) == CATA_ERR_ARGUMENT);
    cube.counts = {{SIZE_MAX, SIZE_MAX, 2}};
    cata_mesh_file* none = nullptr;
    CHECK_STATUS(cata_mesh_isosurface(cube.counts.data(), cube.origin.data(), cube.step.data(),
                                      x.data(), 0, 2, nullptr, &none),
                 CATA_ERR_SHAPE);
    CHECK(none == nullptr);
}

void generated() {
    CHECK(catamaran::shape("terrain", {5, 4, 1}).vertices().size() == 30);
    CHECK(catamaran::shape("icosphere", {1}).vertices().size() == 42);
    CHECK(status_of([&] { catamaran::shape("sphere", {1}); }) == CATA_ERR_ARGUMENT);
    CHECK(status_of([&] { catamaran::shape("torus", {12, 6}); }) == CATA_ERR_ARGUMENT);
}

// A ring of 200 nodes from every fourth of them, and a sphere from 400 of its vertices.
void two_levels() {
    const std::size_t n = 200, coarse = 50, k = 9;
    std::vector<std::size_t> starts{0}, columns, p_starts{0}, p_columns;
    std::vector<double> entries, p_entries;
    for (std::size_t i = 0; i < n; ++i) {
        for (std::size_t j = 0; j < n; ++j) {
            const bool beside = j == (i + 1) % n || i == (j + 1) % n;
            if (i == j || beside) {
                columns.push_back(j);
                entries.push_back(beside ? -1 : 2);
            }
        }
        starts.push_back(columns.size());
        const double part = static_cast<double>(i % 4) / 4;
        const std::size_t left = i / 4, right = (left + 1) % coarse;
        for (const std::size_t j : {left < right ? left : right, left < right ? right : left}) {
            p_columns.push_back(j);
            p_entries.push_back(j == left ? 1 - part : part);
        }
        p_starts.push_back(p_columns.size());
    }
    const catamaran::sparse_view ring{n, starts.data(), columns.data(), entries.data()};
    const catamaran::sparse_view p{n, p_starts.data(), p_columns.data(), p_entries.data()};
    // Unsmoothed, the last pair, 4 waves over 50 nodes, would be (4 x 2 pi / 50)^2 / 12 = 2 % off.
    const auto exact = catamaran::eigs(ring, k);
    const auto found = catamaran::eigs_two_level(ring, p, coarse, k);
    for (std::size_t i = 1; i < k; ++i) {
        const double error = found.values[i] / exact.values[i] - 1;
        CHECK(error > -1e-9 && error < 2e-3);
    }
    catamaran::eigs_options how;
    how.shift = 1;
    CHECK(status_of([&] { catamaran::eigs_two_level(ring, p, coarse, k, {}, how); }) ==
          CATA_ERR_ARGUMENT);
    CHECK(status_of([&] { catamaran::eigs_two_level(ring, p, 49, k); }) == CATA_ERR_ARGUMENT);
    CHECK(std::string(cata_last_error_message()).rfind("P: ", 0) == 0);

    const auto sphere = catamaran::shape("icosphere", {4});
    const catamaran::decimation small(sphere.mesh(), 400);
    const auto all = catamaran::eigs(sphere.mesh(), k), few = small.eigs(k);
    for (std::size_t i = 1; i < k; ++i) {
        const double error = few.values[i] / all.values[i] - 1;
        CHECK(error > -1e-9 && error < 0.01);
    }
    CHECK(few.masses == all.masses && few.vectors.size() == sphere.vertices().size() * k);
    how.shift.reset();
    how.boundary = catamaran::boundary::dirichlet;
    CHECK(status_of([&] { small.eigs(k, how); }) == CATA_ERR_ARGUMENT);
}

void plans() {
    CHECK(catamaran::plan<double>(1000, 500).find("A 1000 x 500, f64") != std::string::npos);
    CHECK(catamaran::plan<float>(1000, 500).find("A 1000 x 500, f32") != std::string::npos);
    catamaran::options how;
    how.scheme = catamaran::scheme::classical;
    const auto classical = catamaran::plan<double>(1000, 1000, how);
    how.scheme = catamaran::scheme::winograd;
    how.leaf = 64;
    CHECK(catamaran::plan<double>(1000, 1000, how) != classical);
    char text[5];
    CHECK_STATUS(cata_ata_plan_f64(1000, 500, nullptr, sizeof text, text), CATA_OK);
    CHECK(std::string(text) == "C = ");
    how.error_factor = 0.5;
    CHECK(status_of([&] { catamaran::plan<double>(10, 10, how); }) == CATA_ERR_ARGUMENT);
}

}  // namespace

int main() {
    topology();
    measures();
    comparisons();
    isosurfaces();
    generated();
    two_levels();
    plans();
    return report("test_cpp_surfaces");
}
