/* Every product, in every layout, triangle and precision, against plain loops.
 *
 * With the argument "quick": small sizes on one thread, for Valgrind. (rayon keeps its threads for
 * the life of the process; Valgrind would call what they own possibly lost.) */

#include <catamaran.h>

#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "check.h"

#define REAL double
#define NAME(base) base##_f64
#define LOCAL(base) base##_double
#define UNIT 1.2e-16
#include "products_template.h"
#undef REAL
#undef NAME
#undef LOCAL
#undef UNIT

#define REAL float
#define NAME(base) base##_f32
#define LOCAL(base) base##_float
#define UNIT 6.0e-8
#include "products_template.h"
#undef REAL
#undef NAME
#undef LOCAL
#undef UNIT

/* float in, double out: as exact as double, which sums in float are not. */
static void test_mixed(void)
{
    enum { M = 127, N = 13 };
    float *a = make_float(M * N, 1);
    double wide[M * N], c[N * N], before[N * N];
    for (size_t i = 0; i < M * N; i++) {
        wide[i] = (double)a[i];
    }
    for (size_t i = 0; i < N * N; i++) {
        before[i] = c[i] = 0.25 * (double)i;
    }
    CHECK_STATUS(cata_ata_f32_f64(CATA_COL_MAJOR, CATA_LOWER, M, N, 1.0, a, M, 3.0, c, N, NULL),
                 CATA_OK);
    compare_double(CATA_COL_MAJOR, CATA_LOWER, M, N, wide, M, 1.0, 3.0, c, before, N, NULL);
    free(a);
}

/* The same bits on any number of threads. */
static void test_threads_agree(size_t m, size_t n)
{
    double *a = make_double(m * n, 1), *c = make_double(n * n, 2), *d = make_double(n * n, 3);
    cata_ata_params params;
    CHECK_STATUS(cata_ata_params_init(&params, sizeof params), CATA_OK);
    params.threads = 1;
    CHECK_STATUS(
        cata_ata_f64(CATA_ROW_MAJOR, CATA_BOTH, m, n, 1.0, a, n, 0.0, c, n, &params), CATA_OK);
    for (params.threads = 2; params.threads <= 8; params.threads *= 2) {
        CHECK_STATUS(
            cata_ata_f64(CATA_ROW_MAJOR, CATA_BOTH, m, n, 1.0, a, n, 0.0, d, n, &params), CATA_OK);
        CHECK(memcmp(c, d, n * n * sizeof *c) == 0);
        CHECK_STATUS(cata_memory_release(), CATA_OK);
    }
    free(a);
    free(c);
    free(d);
}

/* A sparse A with an empty row and an empty column, weighted, against the dense product. */
static void test_sparse(void)
{
    const size_t row_starts[] = {0, 2, 2, 3, 5}, columns[] = {0, 3, 1, 0, 1};
    const double entries[] = {2, -1, 3, 1, 0.5}, weights[] = {1, 7, -2, 4};
    const double expected[9 + 7] = {8, 2, 0, -2, 2, -17, 0, 0, 0, 0, 0, 0, -2, 0, 0, 1};
    double c[16];
    cata_ata_params params = {.struct_size = sizeof params, .threads = 2};
    CHECK_STATUS(cata_ata_sparse_f64(CATA_ROW_MAJOR, CATA_BOTH, 4, 4, 1.0, row_starts, columns, entries,
                                     weights, 0.0, c, 4, &params),
                 CATA_OK);
    for (int i = 0; i < 16; i++) {
        CHECK(c[i] == expected[i]);
    }
    const float single[] = {2, -1, 3, 1, 0.5f};
    float c32[16] = {0};
    CHECK_STATUS(cata_ata_sparse_f32(CATA_COL_MAJOR, CATA_LOWER, 4, 4, 2.0f, row_starts, columns, single,
                                     NULL, 1.0f, c32, 4, NULL),
                 CATA_OK);
    CHECK(c32[0] == 10 && c32[1] == 1 && c32[3] == -4 && c32[4] == 0 && c32[5] == 18.5f);
    CHECK_STATUS(cata_ata_sparse_f64(CATA_ROW_MAJOR, CATA_LOWER, 0, 1, 1.0, NULL, NULL, NULL, NULL, 0.0, c,
                                     1, NULL),
                 CATA_OK);
    CHECK(c[0] == 0);
    const size_t twice[] = {0, 0};
    CHECK_STATUS(cata_ata_sparse_f64(CATA_ROW_MAJOR, CATA_LOWER, 1, 4, 1.0, row_starts, twice, entries,
                                     NULL, 0.0, c, 4, NULL),
                 CATA_ERR_ARGUMENT);
    const double infinite[] = {1, 1, INFINITY, 1};
    CHECK_STATUS(cata_ata_sparse_f64(CATA_ROW_MAJOR, CATA_LOWER, 4, 4, 1.0, row_starts, columns, entries,
                                     infinite, 0.0, c, 4, NULL),
                 CATA_ERR_NON_FINITE);
}

int main(int argc, char **argv)
{
    int quick = argc > 1 && strcmp(argv[1], "quick") == 0;
    test_all_double(quick);
    test_all_float(quick);
    test_sparse();
    if (!quick) {
        test_mixed();
        test_threads_agree(700, 300);
        test_threads_agree(5000, 30);
    }
    return report("products");
}
