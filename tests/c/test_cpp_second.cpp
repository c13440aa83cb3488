#include <catamaran.hpp>

int second_unit();

int second_unit() {
    const double x[2] = {3, 4};
    return static_cast<int>(catamaran::ata(catamaran::row_major(x, 2, 1))[0]);
}
