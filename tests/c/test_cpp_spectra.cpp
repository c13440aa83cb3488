// Eigenpairs, orthonormal columns, bases, maps and unions through the C++ layer.

#include <catamaran.hpp>

#include <cmath>
#include <cstdint>
#include <stdexcept>
#include <vector>

#include "check.hpp"

namespace {

using catamaran::basis;
using catamaran::col_major;
using catamaran::layout;

const double pi = std::acos(-1.0);

void slices_and_counts() {
    const std::size_t n = 100, k = 6;
    // The path of n nodes, whose eigenvalues are 2 - 2 cos(pi i / n).
    const tridiagonal line(n, 2, 1);
    const auto value = [&](double i) { return 2 - 2 * std::cos(pi * i / n); };
    CHECK(catamaran::count_below(line.view(), value(k - 0.5)) == k);
    CHECK(catamaran::count_below(line.view(), value(k - 0.5) / 2, std::vector<double>(n, 2)) == k);
    CHECK(status_of([&] { catamaran::count_below(line.view(), 1, {1}); }) == CATA_ERR_SHAPE);
    std::size_t pairs = 0;
    catamaran::eigs_sliced(line.view(), k, 1 << 26, [&](const catamaran::eigenpair_slice& slice) {
        for (std::size_t j = 0; j < slice.count; ++j, ++pairs) {
            CHECK(std::abs(slice.values[j] - value(static_cast<double>(pairs))) < 1e-9);
            CHECK(slice.residuals[j] < 1e-9 && slice.vectors.rows == n);
            double norm = 0;
            for (std::size_t i = 0; i < n; ++i) norm += slice.vectors(i, j) * slice.vectors(i, j);
            CHECK(std::abs(norm - 1) < 1e-12);
        }
        return true;
    });
    CHECK(pairs == k);
    const auto stop = [](const catamaran::eigenpair_slice&) { return false; };
    CHECK(status_of([&] { catamaran::eigs_sliced(line.view(), k, 1 << 26, stop); }) ==
          CATA_ERR_CANCELLED);
    bool thrown = false;
    try {
        catamaran::eigs_sliced(line.view(), k, 1 << 26,
                               [](const catamaran::eigenpair_slice&) -> bool {
                                   throw std::runtime_error("mine");
                               });
    } catch (const std::runtime_error& error) {
        thrown = std::string(error.what()) == "mine";
    }
    CHECK(thrown);
}

void orthonormal_columns() {
    std::vector<double> data{3, 4, 0, 1, 2, 3};
    const std::vector<double> old = data;
    const auto a = col_major(data.data(), 3, 2);
    const std::vector<double> r = catamaran::cholesky_qr(a, {1, 2, 1});
    for (std::size_t i = 0; i < 3; ++i) {
        CHECK(std::abs(a(i, 0) * r[2] + a(i, 1) * r[3] - old[3 + i]) < 1e-14);
    }
    CHECK(status_of([&] { catamaran::cholesky_qr(col_major(data.data(), 2, 3)); }) ==
          CATA_ERR_ARGUMENT);
    data = {3, 0, 4, 1, 2, 0, 4, 2, 4};
    catamaran::ortho_options how;
    how.method = catamaran::ortho_method::rank_revealing;
    const auto found = catamaran::gram_schmidt(col_major(data.data(), 3, 3), {}, how);
    CHECK(found.kept.size() == 2 && found.r.size() == 6);
    how.progress = [](double) { return false; };
    CHECK(status_of([&] { catamaran::gram_schmidt(col_major(data.data(), 3, 3), {}, how); }) ==
          CATA_ERR_CANCELLED);
}

// A ring: the constant, and cosines and sines of frequencies 1 and 2.
catamaran::eigenpairs ring(std::size_t n, bool backwards) {
    catamaran::eigenpairs pairs;
    pairs.rows = n;
    pairs.values = {0, 1, 1, 4, 4};
    pairs.masses.assign(n, 1.0 / static_cast<double>(n));
    for (std::size_t j = 0; j < 5; ++j) {
        for (std::size_t v = 0; v < n; ++v) {
            const double at = 2 * pi * static_cast<double>(backwards ? n - 1 - v : v) /
                              static_cast<double>(n) * static_cast<double>((j + 1) / 2);
            pairs.vectors.push_back(j == 0 ? 1
                                           : std::sqrt(2.0) * (j % 2 ? std::cos(at) : std::sin(at)));
        }
    }
    return pairs;
}

bool near(const std::vector<double>& a, const std::vector<double>& b, double tolerance = 1e-9) {
    if (a.size() != b.size()) return false;
    for (std::size_t i = 0; i < a.size(); ++i) {
        if (!(std::abs(a[i] - b[i]) < tolerance)) return false;
    }
    return true;
}

void bases_and_maps() {
    const std::size_t n = 24;
    const basis source(ring(n, false)), target(ring(n, true));
    CHECK(source.vertices() == n && source.size() == 5);
    CHECK(near(source.functions(), ring(n, false).vectors));
    CHECK(status_of([&] {
              auto without = ring(n, false);
              without.masses.clear();
              const basis none(without);
          }) == CATA_ERR_ARGUMENT);
    CHECK(status_of([&] {
              auto few = ring(n, false);
              few.vectors.pop_back();
              const basis none(few);
          }) == CATA_ERR_SHAPE);

    catamaran::basis_options how;
    how.method = catamaran::ortho_method::rank_revealing;
    const basis products = source.products(how);
    CHECK(products.size() == 9 && products.factors().r.size() == 9 * 15);
    CHECK(status_of([&] { products.products(); }) == CATA_ERR_ARGUMENT);
    how.progress = [](double) { return false; };
    CHECK(status_of([&] { source.products(how); }) == CATA_ERR_CANCELLED);

    std::vector<double> f(n), carried(n);
    std::vector<std::uint32_t> points(n), labels(n), mirrored(n);
    for (std::uint32_t v = 0; v < n; ++v) {
        points[v] = static_cast<std::uint32_t>(n) - 1 - v;
        f[v] = 1 + std::cos(2 * pi * v / n) + std::cos(6 * pi * v / n);
        labels[v] = v < 3 ? 0 : v < 8 ? 1 : v < 18 ? 2 : 3;
    }
    for (std::size_t v = 0; v < n; ++v) {
        carried[v] = f[points[v]];
        mirrored[v] = labels[points[v]];
    }
    const auto column = col_major<const double>(f.data(), n, 1);
    const auto rows = catamaran::row_major<const double>(f.data(), n, 1);
    const auto c = source.analysis(column);
    CHECK(near(source.analysis(rows), c, 1e-15) && std::abs(c[0] - 1) < 1e-12);
    const auto low = source.synthesis(col_major<const double>(c.data(), 5, 1));
    const auto parts = source.split(column);
    CHECK(near(parts.low, low));
    CHECK(near(source.filter(column, {1, 1, 1, 1, 1}, 1), f));
    CHECK(near(source.filter(column, std::vector<double>(5)), std::vector<double>(n)));
    CHECK(status_of([&] { source.filter(column, {1}); }) == CATA_ERR_SHAPE);
    auto changed = low;
    source.add_coefficient(0, -c[0], col_major(changed.data(), n, 1));
    CHECK(std::abs(changed[0] + 1 - low[0]) < 1e-12);

    const auto expected = catamaran::map_from_points(points, source, target);
    CHECK(catamaran::points_from_map(expected.matrix(), source, target) == points);
    catamaran::map_fit fit(source, target);
    const auto found = fit.landmarks({{{0, n - 1}}, {{5, n - 6}}, {{9, n - 10}}})
                           .segments(labels, mirrored)
                           .functions(column, col_major<const double>(carried.data(), n, 1))
                           .operators(column, col_major<const double>(carried.data(), n, 1))
                           .solve();
    CHECK(near(found.entries, expected.entries, 1e-6));
    CHECK(status_of([&] { fit.solve(1e-3, how); }) == CATA_ERR_CANCELLED);
    CHECK(status_of([&] { fit.segments(labels, {1}); }) == CATA_ERR_SHAPE);
    CHECK(status_of([&] { fit.landmarks({{{n, 0}}}); }) == CATA_ERR_ARGUMENT);
    auto noisy = expected;
    for (double& x : noisy.entries) x += 0.02;
    const auto refined = catamaran::icp(noisy, source, target, 10);
    CHECK(refined.points == points && near(refined.entries, expected.entries));
    noisy.entries.pop_back();
    CHECK(status_of([&] { catamaran::icp(noisy, source, target, 10); }) == CATA_ERR_SHAPE);
    for (const layout order : {layout::row_major, layout::col_major}) {
        std::vector<double> first(9);
        const catamaran::matrix_view<double> few{first.data(), 3, 3, 3, order};
        for (std::size_t i = 0; i < 3; ++i) {
            for (std::size_t j = 0; j < 3; ++j) few(i, j) = expected.matrix()(i, j);
        }
        const auto whole = catamaran::zoomout(few, source, target);
        CHECK(whole.points == points && near(whole.entries, expected.entries));
    }
    const auto smooth = col_major<const double>(parts.low.data(), n, 1);
    const auto over = catamaran::transfer(source, target, expected.matrix(), smooth);
    for (std::size_t v = 0; v < n; ++v) CHECK(std::abs(over[v] - parts.low[points[v]]) < 1e-12);
    // Of frequency 3, which products know and eigenfunctions don't.
    CHECK(near(catamaran::transfer(source, target, points, column), carried));
    CHECK(status_of([&] { catamaran::transfer(source, target, points, column, how); }) ==
          CATA_ERR_CANCELLED);
}

// A turn of the ring: what it does to eigenfunctions says what it does to their products.
void maps_of_products() {
    const std::size_t n = 24;
    const basis eigen(ring(n, false)), products = eigen.products();
    std::vector<std::uint32_t> turned(n);
    for (std::uint32_t v = 0; v < n; ++v) turned[v] = (v + 5) % static_cast<std::uint32_t>(n);
    const auto c = catamaran::map_from_points(turned, eigen, eigen);
    const auto expected = catamaran::map_from_points(turned, products, products);
    CHECK(expected.rows == 9);
    std::vector<double> by_rows(25);
    const catamaran::matrix_view<double> rows = catamaran::row_major(by_rows.data(), 5, 5);
    for (std::size_t i = 0; i < 5; ++i) {
        for (std::size_t j = 0; j < 5; ++j) rows(i, j) = c.matrix()(i, j);
    }
    for (const bool of_all : {false, true}) {
        const auto found =
            catamaran::product_map(c.matrix(), eigen, eigen, products, products, of_all);
        CHECK(near(found.entries, expected.entries, 1e-8));
        const auto again =
            catamaran::product_map(rows, eigen, eigen, products, products, of_all);
        CHECK(near(again.entries, found.entries, 1e-12));
    }
    CHECK(status_of([&] { catamaran::product_map(rows, eigen, eigen, eigen, products); }) ==
          CATA_ERR_ARGUMENT);
    catamaran::basis_options how;
    how.order = 3;
    const basis more = eigen.products(how);
    CHECK(status_of([&] { catamaran::product_map(rows, eigen, eigen, products, more); }) ==
          CATA_ERR_ARGUMENT);
}

// A tetrahedron: all its eigenfunctions, and so all its details.
void meshes() {
    const std::vector<std::array<double, 3>> corners{
        {{1, 1, 1}}, {{1, -1, -1}}, {{-1, 1, -1}}, {{-1, -1, 1}}};
    const std::vector<std::array<std::uint32_t, 3>> faces{
        {{0, 1, 2}}, {{0, 3, 1}}, {{0, 2, 3}}, {{1, 3, 2}}};
    const catamaran::mesh_view mesh(corners, faces);
    std::size_t pairs = 0;
    catamaran::eigs_sliced(mesh, 3, 1 << 20, [&](const catamaran::eigenpair_slice& slice) {
        pairs += slice.count;
        return slice.vectors.rows == 4;
    });
    CHECK(pairs == 3);
    const basis whole(catamaran::eigs(mesh, 4));
    const auto identity = catamaran::map_from_points({0, 1, 2, 3}, whole, whole);
    const auto moved =
        catamaran::transfer_details({mesh, whole, whole}, {mesh, whole, whole}, identity.matrix());
    for (std::size_t v = 0; v < 4; ++v) {
        for (std::size_t k = 0; k < 3; ++k) CHECK(std::abs(moved[v][k] - corners[v][k]) < 1e-12);
    }
    CHECK(catamaran::free_components(mesh) == 1);
    const auto signature = catamaran::shape_dna(mesh, 4);
    CHECK(std::abs(signature[0]) < 1e-9 && std::abs(signature[1] / signature[3] - 1) < 1e-9);
    catamaran::eigs_options how;
    how.progress = [](double) { return false; };
    CHECK(status_of([&] { catamaran::shape_dna(mesh, 4, true, how); }) == CATA_ERR_CANCELLED);
    const std::vector<double> signatures{0, 5, 3, 4, 0, 5, 1, 1};
    const auto found =
        catamaran::retrieve({0, 4}, catamaran::row_major<const double>(signatures.data(), 4, 2), 3);
    CHECK((found.indices == std::vector<std::size_t>{0, 2, 1}));
    CHECK((found.distances == std::vector<double>{1, 1, 3}));
}

void unions() {
    catamaran::unions::eigenvalues a{}, b{};
    for (std::size_t i = 0; i < a.size(); ++i) {
        a[i] = static_cast<double>(i + 1);
        b[i] = 3 * a[i];
    }
    CHECK(catamaran::unions::interpolate(a, b, 0.5)[4] == 10);
    CHECK(status_of([&] { catamaran::unions::interpolate(a, b, 2); }) == CATA_ERR_ARGUMENT);
    const catamaran::unions network;
    catamaran::unions_options how;
    how.threads = 1;
    const std::vector<std::array<double, 3>> corners{{{0, 0, 0}}, {{1, 0, 0}}, {{0, 1, 0}}};
    const std::vector<std::array<std::uint32_t, 3>> faces{{{0, 1, 2}}};
    CHECK(status_of([&] { network.locate({a}, {corners, faces}, how); }) == CATA_ERR_SHAPE);
}

}  // namespace

int main() {
    slices_and_counts();
    orthonormal_columns();
    bases_and_maps();
    maps_of_products();
    meshes();
    unions();
    return report("test_cpp_spectra");
}
