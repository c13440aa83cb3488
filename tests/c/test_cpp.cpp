// The C++ layer: views, exceptions, ownership.

#include <catamaran.hpp>

#include <algorithm>
#include <array>
#include <cfenv>
#include <cmath>
#include <complex>
#include <string>
#include <type_traits>
#include <vector>

#include "check.hpp"

int second_unit();  // test_cpp_second.cpp: the header in two translation units

namespace {

using catamaran::layout;
using catamaran::uplo;

static_assert(!std::is_copy_constructible<catamaran::backend>::value, "one owner");
static_assert(std::is_nothrow_move_constructible<catamaran::backend>::value, "movable");

void products() {
    const std::vector<double> data{1, 2, 3, 4, 5, 6};
    const auto a = catamaran::row_major(data.data(), 3, 2);
    CHECK((catamaran::ata(a) == std::vector<double>{35, 44, 44, 56}));

    std::vector<double> out(6, -1.0);
    const auto c = catamaran::row_major(out.data(), 2, 2, 3);
    catamaran::ata<double>(1, a, 0, c, uplo::lower);
    CHECK((out == std::vector<double>{35, -1, -1, 44, 56, -1}));

    std::vector<float> f{1, 2, 3};
    const auto column = catamaran::col_major(f.data(), 3, 1);
    CHECK((catamaran::ata(column) == std::vector<float>{14}));
    float dot = 1;
    catamaran::atb(2, column, column, 1, catamaran::col_major(&dot, 1, 1));
    CHECK(dot == 29);
    CHECK(catamaran::verify(2.0, column, catamaran::col_major(&(dot = 28), 1, 1)).passed);
    CHECK(!catamaran::verify(2.0, column, catamaran::col_major(&(dot = 30), 1, 1)).passed);

    CHECK(catamaran::ata(catamaran::row_major<double>(nullptr, 0, 0)).empty());
}

static_assert(!std::is_constructible<catamaran::mesh_view, catamaran::point_list,
                                     catamaran::triangle_list>::value, "of temporaries");
static_assert(!std::is_constructible<catamaran::mesh_view, const catamaran::point_list&,
                                     catamaran::triangle_list>::value, "of a temporary");

template <class Owner, class = void>
struct has_matrix : std::false_type {};
template <class Owner>
struct has_matrix<Owner, decltype(std::declval<Owner>().matrix(), void())> : std::true_type {};
static_assert(has_matrix<const catamaran::eigenpairs&>::value, "as long as they last");
static_assert(!has_matrix<catamaran::eigenpairs>::value, "of temporaries");

void batches() {
    std::vector<double> data{1, 2, 3, 4, 5, 6}, c(4, 1.0);
    const auto a = catamaran::row_major(data.data(), 3, 1);
    const auto square = catamaran::row_major(c.data(), 1, 1);
    catamaran::ata_batched(2, 1, a, 3, 1, square, 2);
    CHECK((c == std::vector<double>{15, 1, 78, 1}));
    catamaran::ata_batched<double>(3, 1, catamaran::row_major<const double>(data.data(), 4, 1), 1,
                                   0, square, 1);
    CHECK((c == std::vector<double>{30, 54, 86, 1}));
    CHECK(status_of([&] { catamaran::ata_batched(2, 1, a, 3, 1, square, 0); }) == CATA_ERR_SHAPE);
}

void products_of_rows() {
    const std::vector<double> data{1, 2, 3, 4, 5, 6};
    const auto a = catamaran::row_major(data.data(), 3, 2);
    CHECK((catamaran::aat(a) == std::vector<double>{5, 11, 17, 11, 25, 39, 17, 39, 61}));
    std::vector<float> f{3, 4}, c{7, 7, 7, 7};
    const auto column = catamaran::col_major(f.data(), 2, 1);
    catamaran::aat(1, column, 0, catamaran::col_major(c.data(), 2, 2), uplo::upper);
    CHECK((c == std::vector<float>{9, 7, 12, 16}));
    CHECK(status_of([&] { catamaran::aat(1, column, 0, column); }) == CATA_ERR_SHAPE);

    catamaran::row_options<double> rows;
    rows.centering = catamaran::centering::mean;
    CHECK((catamaran::ata_rows(a, rows, 0.5) == std::vector<double>{4, 4, 4, 4}));
    rows.weights = {1, 0, 2};
    rows.centering = catamaran::centering::given;
    rows.center = {1, 2};
    CHECK((catamaran::ata_rows(a, rows) == std::vector<double>{32, 32, 32, 32}));
    rows.center = {1};
    CHECK(status_of([&] { catamaran::ata_rows(a, rows); }) == CATA_ERR_SHAPE);
    rows = {};
    rows.weights = {1};
    CHECK(status_of([&] { catamaran::ata_rows(a, rows); }) == CATA_ERR_SHAPE);
}

void complex_products() {
    using number = std::complex<double>;
    const std::vector<number> data{{1, 2}, {0, -1}, {3, 0}, {1, 1}};
    const auto a = catamaran::row_major(data.data(), 2, 2);
    std::vector<number> c(4, {7, 7});
    catamaran::aha<double>(1, a, 0, catamaran::row_major(c.data(), 2, 2));
    CHECK((c == std::vector<number>{{14, 0}, {1, 2}, {1, -2}, {3, 0}}));
    catamaran::aha<double>(2, a, -1, catamaran::row_major(c.data(), 2, 2), uplo::lower);
    CHECK((c == std::vector<number>{{14, 0}, {1, 2}, {1, -2}, {3, 0}}));

    std::vector<std::complex<float>> f{{1, 2}, {3, -1}};
    const auto column = catamaran::col_major(f.data(), 2, 1);
    std::complex<float> dot{1, 0};
    catamaran::ahb({0, 1}, column, column, {0, 2}, catamaran::col_major(&dot, 1, 1));
    CHECK((dot == std::complex<float>{0, 17}));
    catamaran::aha(1, column, 0, catamaran::col_major(&dot, 1, 1));
    CHECK((dot == std::complex<float>{15, 0}));
    CHECK(status_of([&] { catamaran::aha(1, column, 0, catamaran::col_major(f.data(), 2, 1)); }) ==
          CATA_ERR_SHAPE);
    CHECK(status_of([&] { catamaran::ahb(1, column, catamaran::col_major(&dot, 1, 1), 0, column); }) ==
          CATA_ERR_SHAPE);
}

// Classical sums in this order lose the 1; the exact ones, in any order, do not.
void reproducible() {
    const std::vector<double> data{1, 1, 0x1p53, 1, -0x1p53, 1};
    const auto a = catamaran::row_major(data.data(), 3, 2);
    catamaran::options how;
    how.reproducible = true;
    const std::vector<double> expected{0x1p107, 1, 1, 3};
    CHECK(catamaran::ata(a, how) == expected);
    how.reproducible = false;
    how.scheme = catamaran::scheme::exact;
    CHECK(catamaran::ata(a, how) == expected);
    how.scheme = catamaran::scheme::automatic;
    how.error_factor = CATA_ERROR_LEAST;
    CHECK(catamaran::ata(a, how) == expected);
    how.reproducible = true;
    how.scheme = catamaran::scheme::classical;
    CHECK(status_of([&] { catamaran::ata(a, how); }) == CATA_ERR_ARGUMENT);
}

void errors() {
    std::vector<double> a(6), c(4);
    const auto view = catamaran::row_major(a.data(), 3, 2);
    CHECK(status_of([&] { catamaran::ata(1, view, 0, catamaran::row_major(c.data(), 1, 2)); }) ==
          CATA_ERR_SHAPE);
    CHECK(status_of([&] { catamaran::ata(1, view, 0, catamaran::col_major(c.data(), 2, 2)); }) ==
          CATA_ERR_ARGUMENT);
    CHECK(status_of([&] { catamaran::ata(catamaran::row_major(a.data(), 3, 2, 1)); }) ==
          CATA_ERR_SHAPE);
    CHECK(status_of([&] { catamaran::ata(catamaran::row_major<double>(nullptr, 3, 2)); }) ==
          CATA_ERR_NULL);
    CHECK(status_of([&] { catamaran::atb(1, view, view, 0, catamaran::row_major(c.data(), 1, 2)); }) ==
          CATA_ERR_SHAPE);
    CHECK(status_of([] { catamaran::backend::load("/no/such/library.so"); }) == CATA_ERR_BACKEND);
}

void progress() {
    // Several pieces, also with a large cache, in which smaller products are done in one.
    std::vector<double> a(800 * 800, 1.0);
    const auto view = catamaran::row_major(a.data(), 800, 800);
    int calls = 0;
    catamaran::options how;
    how.threads = 1;
    how.scheme = catamaran::scheme::classical;
    how.progress = [&](double) { return ++calls < 2; };
    CHECK(status_of([&] { catamaran::ata(view, how); }) == CATA_ERR_CANCELLED);
    CHECK(calls == 2);
    how.progress = [](double) -> bool { throw std::string("mine"); };
    std::string caught;
    try {
        catamaran::ata(view, how);
    } catch (const std::string& text) {
        caught = text;
    }
    CHECK(caught == "mine");
    how.progress = nullptr;
    CHECK(catamaran::ata(view, how)[0] == 800.0);
}

// Calls come from several threads, but never overlap: nothing here is atomic or locked. They may call the
// library, and leave by an exception.
void progress_of_many_threads() {
    const std::vector<double> a(400 * 400, 1.0);
    const auto view = catamaran::row_major(a.data(), 400, 400);
    using catamaran::scheme;
    for (const scheme wanted : {scheme::classical, scheme::ata2, scheme::rxtx, scheme::exact}) {
        for (const int last : {1, 2, 1000000}) {
            int calls = 0, inside = 0, overlaps = 0;
            double nested = 0;
            catamaran::options how;
            how.threads = 4;
            how.tasks = 16;
            how.scheme = wanted;
            how.progress = [&](double) -> bool {
                overlaps += inside++;
                catamaran::options inner;
                inner.threads = 2;
                nested = catamaran::ata(catamaran::row_major(a.data(), 100, 100), inner)[0];
                --inside;
                if (++calls == last) throw std::string("enough");
                return true;
            };
            bool threw = false;
            try {
                CHECK(catamaran::ata(view, how)[0] == 400.0);
            } catch (const std::string& text) {
                threw = text == "enough";
            }
            CHECK(overlaps == 0 && calls > 0 && nested == 100.0);
            CHECK(threw == (calls == last));
        }
    }
}

void spectra() {
    // The path of three nodes: eigenvalues 0, 1, 3.
    const std::vector<std::size_t> row_starts{0, 2, 5, 7}, columns{0, 1, 0, 1, 2, 1, 2};
    const std::vector<double> entries{1, -1, -1, 2, -1, -1, 1};
    const catamaran::sparse_view path{3, row_starts.data(), columns.data(), entries.data()};
    CHECK((catamaran::ata(path, 3, {1, 2, 1}) == std::vector<double>{3, -5, 2, -5, 10, -5, 2, -5, 3}));
    CHECK(status_of([&] { catamaran::ata(path, 3, {1, 2}); }) == CATA_ERR_SHAPE);
    const auto pairs = catamaran::eigs(path, 3);
    CHECK(std::abs(pairs.values[1] - 1) < 1e-12 && std::abs(pairs.values[2] - 3) < 1e-12);
    CHECK(pairs.masses.empty() && std::abs(pairs.matrix()(1, 1)) < 1e-12);
    catamaran::eigs_options how;
    how.shift = 2.9;
    CHECK(std::abs(catamaran::eigs(path, 1, {2, 2, 2}, how).values[0] - 1.5) < 1e-12);
    CHECK(status_of([&] { catamaran::eigs(path, 1, {2, 2}); }) == CATA_ERR_SHAPE);
    CHECK(status_of([&] { catamaran::eigs(path, 4); }) == CATA_ERR_ARGUMENT);
    how.progress = [](double) { return false; };
    CHECK(status_of([&] { catamaran::eigs(path, 1, {}, how); }) == CATA_ERR_CANCELLED);

    const std::vector<std::array<double, 3>> corners{
        {{0, 0, 0}}, {{1, 0, 0}}, {{1, 1, 0}}, {{0, 1, 0}}};
    const std::vector<std::array<std::uint32_t, 3>> halves{{{0, 1, 2}}, {{0, 2, 3}}};
    const auto square = catamaran::eigs({corners, halves}, 2);
    CHECK(square.masses.size() == 4 && square.vectors.size() == 8);
    const catamaran::point_list alone{{{0, 0, 0}}};
    CHECK(status_of([&] { catamaran::eigs({alone, halves}, 1); }) == CATA_ERR_MESH);

    // Through eigenfunctions that span everything, any function is carried as it is.
    const auto whole = catamaran::eigs({corners, halves}, 4);
    const std::vector<double> f{1, 2, 3, 5};
    const auto carried =
        catamaran::transfer(whole, whole, {0, 1, 2, 3}, catamaran::col_major(f.data(), 4, 1));
    for (std::size_t i = 0; i < 4; ++i) {
        CHECK(std::abs(carried[i] - f[i]) < 1e-9);
    }
    CHECK(status_of([&] {
              catamaran::transfer(whole, whole, {0}, catamaran::col_major(f.data(), 4, 1));
          }) == CATA_ERR_SHAPE);
}

// The third column is the sum of the first two.
void orthonormal_columns() {
    for (const layout order : {layout::row_major, layout::col_major}) {
        std::vector<double> data(9);
        const catamaran::matrix_view<double> a{data.data(), 3, 3, 3, order};
        const double entries[3][3] = {{3, 1, 4}, {0, 2, 2}, {4, 0, 4}};
        for (std::size_t i = 0; i < 3; ++i) {
            for (std::size_t j = 0; j < 3; ++j) a(i, j) = entries[i][j];
        }
        catamaran::factors found = catamaran::gram_schmidt(a);
        CHECK((found.kept == std::vector<std::size_t>{0, 1}) && found.r.size() == 6);
        const catamaran::matrix_view<double> r{found.r.data(), 2, 3,
                                               order == layout::row_major ? 3u : 2u, order};
        for (std::size_t i = 0; i < 3; ++i) {
            for (std::size_t j = 0; j < 3; ++j) {
                CHECK(std::abs(a(i, 0) * r(0, j) + a(i, 1) * r(1, j) - entries[i][j]) < 1e-13);
            }
        }
        CHECK(status_of([&] { catamaran::gram_schmidt(a, {1, -1, 1}); }) == CATA_ERR_ARGUMENT);
    }
}

// A line without and with an error, and what else comes from Gram matrices in extended precision.
void gram_matrices() {
    const std::vector<double> t{0, 1, 2}, b{1, 4, 3, 3, 5, 2};
    const auto a = catamaran::row_major(t.data(), 3, 1);
    catamaran::lstsq_options how;
    how.intercept = true;
    const auto targets = catamaran::row_major(b.data(), 3, 2);
    const catamaran::least_squares line = catamaran::lstsq(a, targets, {}, how);
    CHECK((line.coefficients == std::vector<double>{2, -1}));
    CHECK((line.intercepts == std::vector<double>{1, 4}));
    CHECK((line.r_squared == std::vector<double>{1, 1}) && line.standard_errors.size() == 2);
    CHECK(line.rank == 1 && line.dependent.empty() && line.degrees_of_freedom == 1);
    CHECK(line.intercept_errors.size() == 2 && line.digits > 15);
    CHECK((line.p_values == std::vector<double>{0, 0}) && line.intercept_p_values.size() == 2);
    CHECK((line.f_p_values == std::vector<double>{0, 0}) && line.observations == 3);
    CHECK((line.adjusted_r_squared == std::vector<double>{1, 1}));
    CHECK((line.residual_deviations == std::vector<double>{0, 0}));
    CHECK(catamaran::lstsq(a, targets).intercept_errors.empty());
    CHECK(catamaran::lstsq(a, targets, {0, 1, 0}).coefficients == (std::vector<double>{3, 3}));
    CHECK(status_of([&] { catamaran::lstsq(a, targets, {1, 1}); }) == CATA_ERR_SHAPE);
    CHECK(status_of([&] { catamaran::lstsq(a, catamaran::row_major(b.data(), 2, 2)); }) ==
          CATA_ERR_SHAPE);
    how.progress = [](double) { return false; };
    CHECK(status_of([&] { catamaran::lstsq(a, targets, {}, how); }) == CATA_ERR_CANCELLED);

    // A vector has either layout, unless there are gaps.
    const std::vector<double> rows{1, 0, 1, 1, 1, 2}, columns{1, 1, 1, 0, 1, 2}, odd{1, 9, 3, 9, 5};
    const std::vector<double> heights{1, 3, 5}, expected{1, 2};
    const auto by_rows = catamaran::row_major(rows.data(), 3, 2);
    const auto by_columns = catamaran::col_major(columns.data(), 3, 2);
    const auto fitted = [](const auto& m, const auto& target) {
        return catamaran::lstsq(m, target).coefficients;
    };
    CHECK(fitted(by_rows, catamaran::col_major(heights.data(), 3, 1)) == expected);
    CHECK(fitted(by_columns, catamaran::row_major(heights.data(), 3, 1)) == expected);
    CHECK(fitted(by_rows, catamaran::row_major(odd.data(), 3, 1, 2)) == expected);
    CHECK(status_of([&] { fitted(by_columns, catamaran::row_major(odd.data(), 3, 1, 2)); }) ==
          CATA_ERR_ARGUMENT);
    CHECK(status_of([&] { fitted(by_rows, catamaran::col_major(columns.data(), 3, 2)); }) ==
          CATA_ERR_ARGUMENT);

    for (const layout order : {layout::row_major, layout::col_major}) {
        std::vector<double> data(4);
        const catamaran::matrix_view<double> m{data.data(), 2, 2, 2, order};
        m(0, 0) = 3, m(0, 1) = 1, m(1, 0) = 4, m(1, 1) = 1;
        const auto found = catamaran::pca(m, 1);
        CHECK((found.mean == std::vector<double>{3.5, 1}) && found.scale.size() == 2);
        CHECK((found.components == std::vector<double>{1, 0}));
        CHECK(std::abs(found.explained_variance[0] - 0.5) < 1e-15);
        const auto values = catamaran::svd(m).values;
        CHECK(std::abs(values[0] * values[1] - 1) < 1e-14);
        const auto gram = catamaran::gram_extended(m);
        const catamaran::matrix_view<const double> high{gram.high.data(), 2, 2, 2, order};
        CHECK(high(0, 0) == 25 && high(1, 0) == 7 && high(1, 1) == 2 && high(0, 1) == 0);
        CHECK((gram.low == std::vector<double>(4)) && gram.exact);
        CHECK(catamaran::gram_extended(m, {}, true).high[0] == 0.5);
        CHECK(std::isnan(catamaran::correlation(m)[3]) && catamaran::correlation(m)[0] == 1);
        std::vector<double> factor = catamaran::cholesky_qr_extended(m);
        const catamaran::matrix_view<double> r{factor.data(), 2, 2, 2, order};
        CHECK(r(0, 0) == 5 && r(0, 1) == 1.4 && r(1, 0) == 0 && m(0, 0) == 0.6);
        CHECK(catamaran::orthogonality(m).max < 2e-16);
        CHECK(status_of([&] { catamaran::pca(m, 3); }) == CATA_ERR_ARGUMENT);
    }
    catamaran::gram_options watched;
    watched.progress = [](double) -> bool { throw std::string("mine"); };
    bool threw = false;
    try {
        catamaran::svd(a, watched);
    } catch (const std::string&) {
        threw = true;
    }
    CHECK(threw);
}

void loaded_backend() {
    try {
        catamaran::backend first = catamaran::backend::load("libopenblas.so.0");
        const catamaran::backend second = std::move(first);
        CHECK(second.name() == "libopenblas.so.0");
        catamaran::options how;
        how.backend = &second;
        const std::vector<double> data{1, 2, 3, 4};
        CHECK((catamaran::ata(catamaran::col_major(data.data(), 2, 2), how) ==
               std::vector<double>{5, 11, 11, 25}));
    } catch (const catamaran::error& error) {
        CHECK(error.status() == CATA_ERR_BACKEND);
        std::puts("cpp: no libopenblas.so.0, its test is left out");
    }
}

const std::vector<std::array<double, 3>> octahedron{{{1, 0, 0}},  {{-1, 0, 0}}, {{0, 1, 0}},
                                                    {{0, -1, 0}}, {{0, 0, 1}},  {{0, 0, -1}}};
const std::vector<std::array<std::uint32_t, 3>> octants{
    {{0, 2, 4}}, {{2, 1, 4}}, {{1, 3, 4}}, {{3, 0, 4}},
    {{2, 0, 5}}, {{1, 2, 5}}, {{3, 1, 5}}, {{0, 3, 5}}};

// Two halves of an octahedron that overlap, and their union.
void parts_and_unions() {
    const catamaran::decimation fine({octahedron, octants}, 402);
    const catamaran::mesh_view mesh = fine.mesh();
    catamaran::eigs_options held;
    held.boundary = catamaran::boundary::dirichlet;
    const auto spectrum_of = [&](double low, double high) {
        std::vector<std::uint8_t> mask;
        for (const auto& p : fine.vertices()) {
            mask.push_back(low <= p[2] && p[2] <= high ? 1 : 0);
        }
        const auto found = catamaran::part_eigenvalues(mesh, mask, CATA_UNION_EIGENVALUES, held);
        catamaran::unions::eigenvalues values;
        std::copy(found.begin(), found.end(), values.begin());
        return values;
    };
    const auto lower = spectrum_of(-1, 0.2), upper = spectrum_of(-0.2, 1);
    const catamaran::unions unions;
    const auto found = unions.predict({lower, upper});
    for (std::size_t i = 0; i < found.values.size(); ++i) {
        CHECK(0 < found.values[i] && found.values[i] <= std::min(lower[i], upper[i]));
    }
    CHECK(found.ood_score > 0);
    CHECK(unions.predict({upper, lower}).values == found.values);
    CHECK(status_of([&] { unions.predict({}); }) == CATA_ERR_ARGUMENT);
    CHECK(status_of([&] { unions.locate({lower}, mesh); }) == CATA_ERR_SHAPE);
    CHECK(status_of([] { catamaran::unions("/no/such/weights"); }) == CATA_ERR_IO);
    CHECK(status_of([&] { catamaran::part_eigenvalues(mesh, {1}, 2); }) == CATA_ERR_SHAPE);
}

/// Results are rounded to nearest in any mode of the caller, which stays as it is; and so they are
/// once the threads have been released.
void rounding() {
    std::vector<double> data(150 * 120);
    for (std::size_t i = 0; i < data.size(); ++i) {
        data[i] = static_cast<double>((i * 7919) % 10007) / 3.0;
    }
    const auto a = catamaran::row_major(data.data(), 150, 120);
    const auto expected = catamaran::ata(a);
    for (const int mode : {FE_UPWARD, FE_DOWNWARD, FE_TOWARDZERO}) {
        catamaran::release_threads();
        std::fesetround(mode);
        const auto found = catamaran::ata(a);
        const int after = std::fegetround();
        std::fesetround(FE_TONEAREST);
        CHECK(found == expected && after == mode);
    }
}

}  // namespace

int main() {
    rounding();
    products();
    batches();
    products_of_rows();
    complex_products();
    reproducible();
    errors();
    progress();
    progress_of_many_threads();
    spectra();
    orthonormal_columns();
    gram_matrices();
    loaded_backend();
    parts_and_unions();
    CHECK(second_unit() == 25);
    return report("cpp");
}
