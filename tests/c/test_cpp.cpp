// The C++ layer: views, exceptions, ownership.

#include <catamaran.hpp>

#include <cmath>
#include <string>
#include <type_traits>
#include <vector>

#include "check.h"

int second_unit();  // test_cpp_second.cpp: the header in two translation units

namespace {

using catamaran::layout;
using catamaran::uplo;

static_assert(!std::is_copy_constructible<catamaran::backend>::value, "one owner");
static_assert(std::is_nothrow_move_constructible<catamaran::backend>::value, "movable");

template <class F>
cata_status status_of(F call) {
    try {
        call();
        return CATA_OK;
    } catch (const catamaran::error& error) {
        CHECK(std::string(error.what()) != "");
        return error.status();
    }
}

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
    // Smaller products are done in one piece.
    std::vector<double> a(300 * 300, 1.0);
    const auto view = catamaran::row_major(a.data(), 300, 300);
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
    CHECK(catamaran::ata(view, how)[0] == 300.0);
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

void plants() {
    catamaran::plant plant({0, 0, 0.1, 0, 0, 0.2}, {1e-3, 1e-3}, {CATA_NO_PARENT, 0}, {0, 1});
    const std::vector<double> full = plant.full_water();
    CHECK(plant.size() == 2 && full.size() == 2);
    plant.set_loss(1e-5);
    const std::vector<double> later = plant.water_after(full, 3600.0);
    plant.start(full, 360.0);
    const std::vector<double> stepped = plant.step(10);
    CHECK(later[0] + later[1] < full[0] + full[1]);
    CHECK(std::abs(stepped[1] - later[1]) < 1e-6 * full[1]);
    CHECK(plant.stiffness(later, 5e7, 3e5, 10, 0.75)[1] < 5e7);
    CHECK(status_of([&] { plant.weaken(0, 0.5); }) == CATA_ERR_ARGUMENT);
    CHECK(status_of([&] { plant.water_after({1.0}, 1.0); }) == CATA_ERR_SHAPE);
    CHECK(status_of([] { catamaran::plant("/no/such/plant.txt"); }) == CATA_ERR_IO);
    CHECK(status_of([] { catamaran::plant({0, 0, 1}, {1, 1}, {0, 0}, {0, 0}); }) == CATA_ERR_SHAPE);
}

}  // namespace

int main() {
    products();
    reproducible();
    errors();
    progress();
    loaded_backend();
    plants();
    CHECK(second_unit() == 25);
    return report("cpp");
}
