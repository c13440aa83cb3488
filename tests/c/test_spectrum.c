/* Eigenpairs and Gram-Schmidt through the C ABI: exact small cases, refusals, outputs untouched. */

#include <catamaran.h>

#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "check.h"

#define CHECK_MENTIONS(text) CHECK(strstr(cata_last_error_message(), text) != NULL)

/* The path of three nodes: eigenvalues 0, 1, 3. */
static const size_t row_starts[4] = {0, 2, 5, 7};
static const size_t columns[7] = {0, 1, 0, 1, 2, 1, 2};
static const double entries[7] = {1, -1, -1, 2, -1, -1, 1};

static void test_path(void)
{
    double values[3], vectors[3 * 5], residuals[3];
    vectors[3] = vectors[4] = 7;
    CHECK_STATUS(cata_spectrum(3, row_starts, columns, entries, NULL, 3, values, vectors, 5,
                               residuals, NULL),
                 CATA_OK);
    CHECK(fabs(values[0]) < 1e-12 && fabs(values[1] - 1) < 1e-12 && fabs(values[2] - 3) < 1e-12);
    CHECK(fabs(fabs(vectors[0]) - sqrt(1.0 / 3)) < 1e-12);
    CHECK(vectors[3] == 7 && vectors[4] == 7);
    for (int i = 0; i < 3; i++) {
        CHECK(residuals[i] < 1e-12);
    }
    cata_spectrum_params params;
    CHECK_STATUS(cata_spectrum_params_init(&params, sizeof params), CATA_OK);
    params.has_shift = 1;
    params.shift = 2.9;
    params.threads = 2;
    const double masses[3] = {2, 2, 2};
    CHECK_STATUS(cata_spectrum(3, row_starts, columns, entries, masses, 1, values, vectors, 3, NULL,
                               &params),
                 CATA_OK);
    CHECK(fabs(values[0] - 1.5) < 1e-12);
    CHECK_STATUS(cata_spectrum(0, NULL, NULL, NULL, NULL, 0, NULL, NULL, 1, NULL, NULL), CATA_OK);
}

static int32_t cancel(double fraction, void *user)
{
    (void)fraction;
    ++*(int *)user;
    return 1;
}

static void test_spectrum_refusals(void)
{
    double values[3] = {5, 5, 5}, vectors[9];
    CHECK_STATUS(cata_spectrum(3, NULL, columns, entries, NULL, 1, values, vectors, 3, NULL, NULL),
                 CATA_ERR_NULL);
    CHECK_MENTIONS("row_starts: NULL");
    CHECK_STATUS(cata_spectrum(3, row_starts, columns, entries, NULL, 1, NULL, vectors, 3, NULL,
                               NULL),
                 CATA_ERR_NULL);
    CHECK_STATUS(cata_spectrum(3, row_starts, columns, entries, NULL, 1, values, vectors, 2, NULL,
                               NULL),
                 CATA_ERR_SHAPE);
    CHECK_MENTIONS("ldv");
    CHECK_STATUS(cata_spectrum(3, row_starts, columns, entries, NULL, 4, values, vectors, 3, NULL,
                               NULL),
                 CATA_ERR_ARGUMENT);
    CHECK_MENTIONS("k: 4");
    const size_t beyond[7] = {0, 1, 0, 1, 3, 1, 2};
    CHECK_STATUS(cata_spectrum(3, row_starts, beyond, entries, NULL, 1, values, vectors, 3, NULL,
                               NULL),
                 CATA_ERR_ARGUMENT);
    const size_t backwards[4] = {0, 5, 2, 7};
    CHECK_STATUS(cata_spectrum(3, backwards, columns, entries, NULL, 1, values, vectors, 3, NULL,
                               NULL),
                 CATA_ERR_ARGUMENT);
    const double negative[3] = {1, -1, 1};
    CHECK_STATUS(cata_spectrum(3, row_starts, columns, entries, negative, 1, values, vectors, 3,
                               NULL, NULL),
                 CATA_ERR_ARGUMENT);
    CHECK_MENTIONS("mass: must be positive, but entry 1 is -1");
    int calls = 0;
    cata_spectrum_params params = {.struct_size = sizeof params};
    params.progress = cancel;
    params.progress_user = &calls;
    CHECK_STATUS(cata_spectrum(3, row_starts, columns, entries, NULL, 1, values, vectors, 3, NULL,
                               &params),
                 CATA_ERR_CANCELLED);
    CHECK(calls == 1);
    params.struct_size = 1;
    CHECK_STATUS(cata_spectrum(3, row_starts, columns, entries, NULL, 1, values, vectors, 3, NULL,
                               &params),
                 CATA_ERR_ARGUMENT);
    CHECK_MENTIONS("sizeof(cata_spectrum_params)");
    CHECK(values[0] == 5 && values[1] == 5 && values[2] == 5);
}

static void test_gram_schmidt(void)
{
    /* By rows; the third column is the sum of the first two. */
    double a[12] = {3, 1, 4, 99, 0, 2, 2, 99, 4, 0, 4, 99};
    double r[3 * 4];
    size_t kept[3] = {9, 9, 9}, rank = 0;
    CHECK_STATUS(cata_gram_schmidt(CATA_ROW_MAJOR, 3, 3, a, 4, NULL, r, 4, kept, &rank, NULL),
                 CATA_OK);
    CHECK(rank == 2 && kept[0] == 0 && kept[1] == 1 && kept[2] == 9);
    CHECK(fabs(a[0] - 0.6) < 1e-15 && fabs(a[4]) < 1e-15 && fabs(a[8] - 0.8) < 1e-15);
    CHECK(fabs(r[0] - 5) < 1e-14 && r[4] == 0 && fabs(r[2] - r[0] - r[1]) < 1e-14);
    CHECK(r[8] == 0 && r[9] == 0 && r[10] == 0);

    const double bad[3] = {1, 0, 1};
    rank = 77;
    CHECK_STATUS(cata_gram_schmidt(CATA_COL_MAJOR, 3, 1, a, 3, bad, NULL, 0, NULL, &rank, NULL),
                 CATA_ERR_ARGUMENT);
    CHECK_STATUS(cata_gram_schmidt(CATA_COL_MAJOR, 3, 1, a, 3, NULL, NULL, 0, NULL, NULL, NULL),
                 CATA_ERR_NULL);
    CHECK_MENTIONS("rank: NULL");
    cata_ortho_params params;
    CHECK_STATUS(cata_ortho_params_init(&params, sizeof params), CATA_OK);
    params.threshold = 2;
    CHECK_STATUS(cata_gram_schmidt(CATA_COL_MAJOR, 3, 1, a, 3, NULL, NULL, 0, NULL, &rank, &params),
                 CATA_ERR_ARGUMENT);
    CHECK_MENTIONS("threshold");
    CHECK(rank == 77);
    CHECK_STATUS(cata_gram_schmidt(CATA_COL_MAJOR, 0, 0, NULL, 1, NULL, NULL, 0, NULL, &rank, NULL),
                 CATA_OK);
    CHECK(rank == 0);
}

int main(void)
{
    test_path();
    test_spectrum_refusals();
    test_gram_schmidt();
    return report("test_spectrum");
}
