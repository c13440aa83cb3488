// Progress callbacks of the C++ interface under ThreadSanitizer: they write plain variables, for the
// header promises one call at a time. Built and run by `scripts/test --sanitize`.
#include <catamaran.hpp>

#include <cstdio>
#include <cstdlib>
#include <stdexcept>
#include <vector>

namespace {

void require(bool held, const char* what) {
    if (!held) {
        std::fprintf(stderr, "watcher: %s\n", what);
        std::exit(1);
    }
}

std::vector<double> numbers(std::size_t count) {
    std::vector<double> values(count);
    for (std::size_t i = 0; i < count; ++i) {
        values[i] = static_cast<double>(i * 7 % 11) - 5.0;
    }
    return values;
}

// One product that counts its calls, and one whose callback throws halfway.
void watch(catamaran::scheme scheme, std::size_t m, std::size_t n) {
    const std::vector<double> storage = numbers(m * n);
    const auto a = catamaran::row_major(storage.data(), m, n);
    const std::vector<double> expected = catamaran::ata(a);

    int calls = 0;
    double last = 0.0;
    catamaran::options how;
    how.threads = 4;
    how.scheme = scheme;
    how.progress = [&](double fraction) {
        require(fraction >= last, "progress went back");
        last = fraction;
        ++calls;
        // Another product inside of the callback.
        const std::vector<double> small = numbers(64);
        catamaran::ata(catamaran::row_major(small.data(), 8, 8));
        return true;
    };
    require(catamaran::ata(a, how) == expected, "integers differ");
    require(calls > 0 && last == 1.0, "progress did not end at 1");

    how.progress = [&](double fraction) -> bool {
        if (fraction > 0.3) {
            throw std::runtime_error("enough");
        }
        return true;
    };
    bool thrown = false;
    try {
        catamaran::ata(a, how);
    } catch (const std::runtime_error&) {
        thrown = true;
    }
    require(thrown, "the exception was lost");
}

}  // namespace

int main() {
    for (int round = 0; round < 10; ++round) {
        watch(catamaran::scheme::floating, 700, 300);
        watch(catamaran::scheme::floating, 9000, 40);
        watch(catamaran::scheme::ata2, 300, 300);
        watch(catamaran::scheme::exact, 500, 200);
    }
    std::puts("test result: ok. 1 passed; 0 failed; 0 ignored");
}
