// Mesh files, repair, Laplacians, distances, regions, descriptors and shapes from C++.

#include <catamaran.hpp>

#include <cmath>
#include <cstdio>
#include <string>
#include <vector>

#include "check.hpp"

namespace {

using vertex_list = std::vector<std::array<double, 3>>;
using face_list = std::vector<std::array<std::uint32_t, 3>>;

// The unit square, side x side vertices.
struct square {
    vertex_list vertices;
    face_list faces;

    explicit square(std::uint32_t side) {
        for (std::uint32_t i = 0; i < side; ++i) {
            for (std::uint32_t j = 0; j < side; ++j) {
                const std::uint32_t v = i * side + j;
                vertices.push_back({{i / (side - 1.0), j / (side - 1.0), 0.0}});
                if (i + 1 < side && j + 1 < side) {
                    faces.push_back({{v, v + side, v + side + 1}});
                    faces.push_back({{v, v + side + 1, v + 1}});
                }
            }
        }
    }

    catamaran::mesh_view mesh() const { return {vertices, faces}; }
};

// What is written is read again, with its attributes.
void files() {
    const square plane(4);
    catamaran::mesh_file file(plane.mesh());
    CHECK(file.vertices() == plane.vertices && file.faces() == plane.faces);
    CHECK(!file.has_uv() && !file.has_normals() && !file.has_colors() && file.notes().empty());
    std::vector<std::array<double, 6>> uv(18, {{0, 0, 1, 0, 0.5, 1}});
    std::vector<std::array<double, 9>> normals(18, {{0, 0, 1, 0, 0, 1, 0, 0, 1}});
    std::vector<std::array<double, 4>> colors(16, {{0, 0.5, 1, 1}});
    file.set_uv(uv);
    file.set_normals(normals);
    file.set_colors(colors);
    catamaran::face_names groups{{"near", "far"}, std::vector<std::uint32_t>(18, 0)};
    groups.of_faces[17] = 1;
    file.set_names(catamaran::mesh_names::groups, groups);
    const auto bytes = file.write(catamaran::mesh_format::obj);
    const auto again = catamaran::mesh_file::read(bytes, catamaran::mesh_format::obj);
    CHECK(again.vertices() == plane.vertices && again.faces() == plane.faces);
    CHECK(again.uv() == uv && again.normals() == normals && again.colors() == colors);
    const auto names = again.names(catamaran::mesh_names::groups);
    CHECK(names.names.size() == 2 && names.names[names.of_faces[17]] == "far");
    CHECK(again.names(catamaran::mesh_names::materials).names.empty());
    uv.pop_back();
    CHECK(status_of([&] { file.set_uv(uv); }) == CATA_ERR_SHAPE);

    const std::string name = "test_cpp_geometry.off";
    file.write(name);
    CHECK(file.notes().size() == 1);
    CHECK(catamaran::mesh_file::read(name).vertices() == plane.vertices);
    catamaran::mesh_file_options how;
    how.keep = true;
    CHECK(status_of([&] { file.write(name, how); }) == CATA_ERR_IO);
    std::remove(name.c_str());
    CHECK(status_of([&] { catamaran::mesh_file::read(name); }) == CATA_ERR_IO);
}

// Functions on the vertices of a file have their names and values.
void functions_on_vertices() {
    const std::string text = "# vtk DataFile Version 3.0\ntriangle\nASCII\nDATASET POLYDATA\n"
                             "POINTS 3 double\n0 0 0 1 0 0 0 1 0\nPOLYGONS 1 4\n3 0 1 2\n"
                             "POINT_DATA 3\nSCALARS heat float\nLOOKUP_TABLE default\n1 2 3\n"
                             "FIELD FieldData 1\nage 1 3 double\n4 5 6\n";
    const std::vector<std::uint8_t> bytes(text.begin(), text.end());
    const auto found = catamaran::mesh_file::read(bytes, catamaran::mesh_format::vtk).scalars();
    CHECK(found.size() == 2 && found[0].name == "heat" && found[1].name == "age");
    CHECK(found[0].values == std::vector<double>({1, 2, 3}));
    CHECK(found[1].values == std::vector<double>({4, 5, 6}));
    CHECK(catamaran::mesh_file(square(2).mesh()).scalars().empty());
}

// A soup becomes a surface again.
void repairs() {
    const square plane(3);
    vertex_list points;
    face_list faces;
    for (const auto& face : plane.faces) {
        const auto first = static_cast<std::uint32_t>(points.size());
        for (const std::uint32_t v : face) {
            points.push_back(plane.vertices[v]);
        }
        faces.push_back({{first, first + 1, first + 2}});
    }
    const catamaran::mesh_file soup(catamaran::mesh_view{points, faces});
    CHECK(!catamaran::repair_needed(soup.mesh()).empty());
    CHECK(catamaran::repair_needed(plane.mesh()).empty());
    catamaran::repair_options how;
    how.everything = true;
    const auto found = catamaran::repair(soup, how);
    CHECK(found.changed && found.file.vertices().size() == 9 && found.file.faces().size() == 8);
    CHECK(found.vertices.size() == 24 && found.steps.size() == 6);
    CHECK(found.steps[0].kind == CATA_REPAIR_SEAMS && found.steps[0].vertices == 15);
    CHECK(found.steps[0].text.find("15 vertices joined along seams") != std::string::npos);
    how.drop_specks = 2.0;
    CHECK(status_of([&] { catamaran::repair(soup, how); }) == CATA_ERR_ARGUMENT);
    how.progress = [](double) { return false; };
    CHECK(status_of([&] { catamaran::repair(soup, how); }) == CATA_ERR_CANCELLED);
}

// The matrices have the eigenvalues of the mesh.
void laplacians() {
    const square plane(7);
    catamaran::eigs_options how;
    how.boundary = catamaran::boundary::dirichlet;
    const auto found = catamaran::laplacian(plane.mesh(), how);
    CHECK(found.kept.size() == 25 && found.kept[0] == 8 && found.masses.size() == 25);
    const auto pairs = catamaran::eigs(found.stiffness.view(), 4, found.masses);
    const auto expected = catamaran::eigs(plane.mesh(), 4, how);
    for (std::size_t i = 0; i < 4; ++i) {
        CHECK(std::abs(pairs.values[i] / expected.values[i] - 1) < 1e-9);
    }
    const auto all =
        catamaran::dirichlet_energies(found.stiffness.view(), pairs.matrix(), found.masses);
    CHECK(std::abs(all[3] / pairs.values[3] - 1) < 1e-9);
    CHECK(catamaran::laplacian(plane.mesh(), {}, {3, 4}).kept.size() == 47);

    const auto gradient = catamaran::gradient(plane.mesh());
    const auto divergence = catamaran::divergence(plane.mesh());
    CHECK(gradient.rows == 216 && gradient.cols == 49 && gradient.row_starts[216] == 648);
    CHECK(divergence.rows == 49 && divergence.cols == 216 && divergence.row_starts[49] == 648);
    double area = 0.0;
    for (const double part : catamaran::vertex_areas(plane.mesh())) {
        area += part;
    }
    CHECK(std::abs(area - 1) < 1e-12);
    CHECK(catamaran::cloud_laplacian(plane.vertices, 8).kept.size() == 49);
}

void distances() {
    const square plane(11);
    const catamaran::heat_method heat(plane.mesh());
    CHECK(std::abs(heat.distances({0})[120] - std::sqrt(2.0)) < 0.1);
    CHECK(std::abs(catamaran::exact_distances(plane.mesh(), {0})[120] - std::sqrt(2.0)) < 1e-12);
    const auto over = catamaran::shortest_path_over_faces(plane.mesh(), {0, 120});
    CHECK(std::abs(over.length - std::sqrt(2.0)) < 1e-12);
    CHECK(over.faces.size() == over.points.size() && over.weights.size() == over.points.size());
    // From the middle of the first diagonal.
    const catamaran::point_list middle{{{0.5, 0.0, 0.5}}};
    const double away = std::sqrt(2.0) * 0.95;
    CHECK(std::abs(catamaran::exact_distances(plane.mesh(), {0}, middle)[120] - away) < 1e-12);
    const catamaran::point_list both{{{0.5, 0.0, 0.5}}, {{1.0, 1.0, 0.0}}};
    const auto across =
        catamaran::shortest_path_over_faces(plane.mesh(), {0, CATA_IN_SPACE}, both);
    CHECK(std::abs(across.length - away) < 1e-12 && across.vertices.empty());
    CHECK(status_of([&] { catamaran::exact_distances(plane.mesh(), {0, 1}, middle); }) ==
          CATA_ERR_SHAPE);
    const auto traced = catamaran::trace_geodesic(plane.mesh(), 0, {3, 4, 0}, 7);
    CHECK(traced.end == catamaran::trace_end::boundary && std::abs(traced.length - 1.25) < 1e-12);
    CHECK(std::abs(traced.heading[1] - 0.8) < 1e-12);
    const auto from_face = catamaran::trace_geodesic(plane.mesh(), 0, middle[0], {1, 1, 0}, 0.5);
    CHECK(from_face.end == catamaran::trace_end::complete && from_face.length == 0.5);
    const auto edges = catamaran::distances_along_edges(plane.mesh(), {0, 10});
    CHECK(std::abs(edges.distances[120] - 1) < 1e-12 && edges.nearest[120] == 10);
    CHECK(edges.before[0] == CATA_NO_VERTEX && edges.before[120] == 109);
    // Away from the boundary, where paths stay.
    const auto path = catamaran::shortest_path(plane.mesh(), 20, 100);
    CHECK(path.vertices.size() == 17 && std::abs(path.length - 1.6) < 1e-12);
    const auto straight = catamaran::shortest_path(plane.mesh(), 20, 100, true);
    CHECK(std::abs(straight.length - 0.8 * std::sqrt(2.0)) < 1e-9);
    catamaran::distance_options how;
    how.time = -1;
    CHECK(status_of([&] { catamaran::heat_method(plane.mesh(), how); }) == CATA_ERR_ARGUMENT);
}

void regions() {
    const square plane(5);
    const catamaran::edge_list line{{{5, 6}}, {{6, 7}}, {{7, 8}}, {{8, 9}}};
    const catamaran::region left(plane.mesh(), line);
    const catamaran::region right(plane.mesh(), line, std::vector<std::uint32_t>{24});
    CHECK(std::abs(left.area(plane.mesh()) - 0.25) < 1e-12);
    CHECK((~left).inside() == right.inside() && (left & right).area(plane.mesh()) == 0);
    CHECK((left | right).boundary(plane.mesh()).empty() && left.boundary(plane.mesh()) == line);
    CHECK((left ^ right).inside() == (left | right).inside());
    CHECK((left - right).inside() == left.inside());
    CHECK(left.part(plane.mesh()).vertices.size() == 10);
    const auto open = catamaran::cut(plane.mesh(), line);
    CHECK(open.mesh().n_vertices == 30 && open.of_vertices.size() == 30);
    CHECK(status_of([&] { left.area(square(4).mesh()); }) == CATA_ERR_SHAPE);

    const square fine(9);
    catamaran::drawing drawing(fine.mesh());
    CHECK(drawing.add({10, 64, 16, 70}) == catamaran::curve_outcome::closed);
    const auto drawn = drawing.inscribe(true);
    const catamaran::region inside(drawn.mesh(), drawn.layers()[0],
                                   std::vector<std::uint32_t>{40});
    CHECK(std::abs(inside.area(drawn.mesh()) - 36.0 / 64) < 1e-12);
    double sum = 0.0;
    for (const double share : drawn.shares(inside)) {
        sum += share / 128;
    }
    CHECK(std::abs(sum - 36.0 / 64) < 1e-12);
    CHECK(drawn.weights().size() == drawn.vertices().size() && drawn.corners().size() >= 81);
    CHECK(drawn.of_faces().size() == drawn.faces().size());
    CHECK(status_of([&] { drawing.add({0, 8, 80}); }) == CATA_ERR_ARGUMENT);
}

void descriptors() {
    const square plane(9);
    const auto pairs = catamaran::eigs(plane.mesh(), 6);
    const auto times = catamaran::heat_times(pairs, 4);
    const auto heat = catamaran::heat_kernel_signature(pairs, times, true);
    CHECK(heat.rows == 81 && heat.cols == 4);
    // The integral of a scaled signature is 1.
    for (std::size_t j = 0; j < 4; ++j) {
        double sum = 0.0;
        for (std::size_t i = 0; i < 81; ++i) {
            sum += pairs.masses[i] * heat.matrix()(i, j);
        }
        CHECK(std::abs(sum - 1) < 1e-9);
    }
    CHECK(catamaran::heat_kernel(pairs, 40, times[0]).size() == 81);
    const auto wave = catamaran::wave_kernel_signature(pairs, catamaran::wave_scales_of(pairs, 5));
    CHECK(wave.cols == 5 && wave.entries[0] > 0);
    const auto points = catamaran::global_point_signature(pairs);
    CHECK(points.cols == 5 && points.entries.size() == 5 * 81);
    const auto shot = catamaran::shot(plane.mesh(), 0.3);
    CHECK(shot.cols == CATA_SHOT_BINS && shot.rows == 81);
    const auto rings = catamaran::geodesic_rings(plane.mesh(), pairs.matrix(), 0.4, 2);
    CHECK(rings.cols == 14 && std::abs(rings.entries[0] + rings.entries[7 * 81] - 1) < 1e-12);
    CHECK(status_of([&] { catamaran::shot(plane.mesh(), 0); }) == CATA_ERR_ARGUMENT);

    const auto gains = catamaran::gains_of(catamaran::response::low_pass, pairs.values, 1.0);
    CHECK(gains.gains[0] == 1 && gains.gains[5] == 0 && gains.rest == 0);
    const auto ones = std::vector<double>(81, 1.0);
    const auto same = catamaran::basis(pairs).filter(catamaran::col_major(ones.data(), 81, 1),
                                                     gains.gains, gains.rest);
    CHECK(std::abs(same[40] - 1) < 1e-9);
}

void shapes() {
    const square plane(7);
    catamaran::eigs_options how;
    how.boundary = catamaran::boundary::dirichlet;
    auto wanted = catamaran::eigs(plane.mesh(), 4, how).values;
    for (double& value : wanted) {
        value /= 9;
    }
    const auto found = catamaran::shape_from_spectrum(plane.mesh(), wanted);
    CHECK(found.steps == 0 && found.error < 1e-9 && found.eigenvalues.size() == 4);
    CHECK(std::abs(found.vertices[48][0] - 3) < 1e-9);
    catamaran::shape_options few;
    few.tolerance = -1;
    CHECK(status_of([&] { catamaran::shape_from_spectrum(plane.mesh(), wanted, few); }) ==
          CATA_ERR_ARGUMENT);
}

}  // namespace

int main() {
    files();
    functions_on_vertices();
    repairs();
    laplacians();
    distances();
    regions();
    descriptors();
    shapes();
    return report("test_cpp_geometry");
}
