// One solution with a sparse symmetric matrix by CHOLMOD (Debian: libsuitesparse-dev).
//
//     cholmod FOLDER     reads data, indices, indptr (A by rows) and right (n x 8 as one column) of
//                        FOLDER, .npy each; prints seconds and bytes, the seconds of analysis,
//                        factorization and solution, the entries of L, and the largest residual

#include <suitesparse/cholmod.h>
#include <sys/resource.h>
#include <unistd.h>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <cstdint>
#include <cstdlib>
#include <fstream>
#include <iostream>
#include <string>
#include <vector>

static const std::size_t RIGHT = 8;

// The numbers of a column of doubles, version 1 of the format.
static std::vector<double> read(const std::string& path) {
    std::ifstream file(path, std::ios::binary | std::ios::ate);
    const std::streamoff size = file.tellg();
    unsigned char head[10];
    file.seekg(0);
    file.read(reinterpret_cast<char*>(head), sizeof head);
    const std::streamoff start = 10 + head[8] + 256 * head[9];
    std::vector<double> values(file ? static_cast<std::size_t>(size - start) / sizeof(double) : 0);
    file.seekg(start);
    file.read(reinterpret_cast<char*>(values.data()), size - start);
    if (!file || head[6] != 1) {
        std::cerr << path << ": can't be read\n";
        std::exit(1);
    }
    return values;
}

static long resident() {
    long pages = 0, all = 0;
    std::ifstream("/proc/self/statm") >> all >> pages;
    return pages * sysconf(_SC_PAGESIZE);
}

static double now() {
    const auto time = std::chrono::steady_clock::now().time_since_epoch();
    return std::chrono::duration<double>(time).count();
}

int main(int count, char** arguments) {
    if (count != 2) {
        std::cerr << "cholmod FOLDER\n";
        return 2;
    }
    const std::string folder = std::string(arguments[1]) + "/";
    const std::vector<double> data = read(folder + "data.npy");
    const std::vector<double> columns = read(folder + "indices.npy");
    const std::vector<double> starts = read(folder + "indptr.npy");
    const std::vector<double> right = read(folder + "right.npy");
    const std::size_t n = starts.size() - 1;

    cholmod_common common;
    cholmod_l_start(&common);
    // The lower triangle by rows is the upper one by columns.
    std::size_t entries = 0;
    const auto first = [&](std::size_t i) { return static_cast<std::size_t>(starts[i]); };
    for (std::size_t i = 0; i < n; ++i) {
        for (std::size_t k = first(i); k < first(i + 1); ++k) entries += columns[k] <= i;
    }
    cholmod_sparse* a = cholmod_l_allocate_sparse(n, n, entries, 1, 1, 1, CHOLMOD_REAL, &common);
    std::int64_t* p = static_cast<std::int64_t*>(a->p);
    std::int64_t* rows = static_cast<std::int64_t*>(a->i);
    double* x = static_cast<double*>(a->x);
    std::int64_t at = 0;
    for (std::size_t i = 0; i < n; ++i) {
        p[i] = at;
        for (std::size_t k = first(i); k < first(i + 1); ++k) {
            if (columns[k] > i) continue;
            rows[at] = static_cast<std::int64_t>(columns[k]);
            x[at++] = data[k];
        }
    }
    p[n] = at;
    cholmod_dense* b = cholmod_l_allocate_dense(n, RIGHT, n, CHOLMOD_REAL, &common);
    std::copy(right.begin(), right.end(), static_cast<double*>(b->x));

    const long before = resident();
    const double start = now();
    cholmod_factor* factor = cholmod_l_analyze(a, &common);
    const double analysed = now();
    cholmod_l_factorize(a, factor, &common);
    const double factorized = now();
    cholmod_dense* found = cholmod_l_solve(CHOLMOD_A, factor, b, &common);
    const double solved = now();
    rusage usage;
    getrusage(RUSAGE_SELF, &usage);
    if (common.status != CHOLMOD_OK || !found) {
        std::cerr << "cholmod: status " << common.status << '\n';
        return 1;
    }

    double residual = 0;
    for (std::size_t j = 0; j < RIGHT; ++j) {
        const double* solution = static_cast<double*>(found->x) + j * n;
        for (std::size_t i = 0; i < n; ++i) {
            double sum = -right[j * n + i];
            for (std::size_t k = first(i); k < first(i + 1); ++k) {
                sum += data[k] * solution[static_cast<std::size_t>(columns[k])];
            }
            residual = std::max(residual, std::abs(sum));
        }
    }
    std::cout.precision(17);
    std::cout << solved - start << ' ' << usage.ru_maxrss * 1024 - before << ' ' << analysed - start
              << ' ' << factorized - analysed << ' ' << solved - factorized << ' ' << common.lnz
              << ' ' << residual << '\n';
}
