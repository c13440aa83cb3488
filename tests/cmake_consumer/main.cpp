#include <catamaran.hpp>

#include <iostream>

int main() {
    const float a[6] = {1, 2, 3, 4, 5, 6};  // 3 x 2
    const auto c = catamaran::ata(catamaran::row_major(a, 3, 2));
    std::cout << c[0] << ' ' << c[1] << ' ' << c[2] << ' ' << c[3] << '\n';
    return c[0] == 35 && c[1] == 44 && c[2] == 44 && c[3] == 56 ? 0 : 1;
}
