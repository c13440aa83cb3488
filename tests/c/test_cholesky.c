/* Sparse Cholesky factorizations through the C ABI: small cases, refusals, outputs untouched. */

#include <catamaran.h>

#include <math.h>
#include <string.h>

#include "check.h"

#define CHECK_MENTIONS(text) CHECK(strstr(cata_last_error_message(), text) != NULL)

/* 2 on the diagonal, -1 beside it: A (1, 1, 1) = (1, 0, 1). */
static const size_t row_starts[4] = {0, 2, 5, 7};
static const size_t columns[7] = {0, 1, 0, 1, 2, 1, 2};
static const double entries[7] = {2, -1, -1, 2, -1, -1, 2};

/* Its upper triangle. */
static const size_t upper_starts[4] = {0, 2, 4, 5};
static const size_t upper_columns[5] = {0, 1, 1, 2, 2};
static const double upper_entries[5] = {2, -1, 2, -1, 2};

static int near(double x, double y)
{
    return fabs(x - y) < 1e-14;
}

static void test_solutions(void)
{
    cata_cholesky *cholesky = NULL;
    CHECK_STATUS(cata_cholesky_analyse(3, row_starts, columns, NULL, &cholesky), CATA_OK);
    double x[2 * 4] = {1, 0, 1, 7, 2, 0, 2, 7};
    CHECK_STATUS(cata_cholesky_solve(cholesky, CATA_COL_MAJOR, 2, x, 4), CATA_ERR_ARGUMENT);
    CHECK_MENTIONS("not factorized");
    CHECK_STATUS(cata_cholesky_factor(cholesky, row_starts, columns, entries), CATA_OK);
    CHECK_STATUS(cata_cholesky_solve(cholesky, CATA_COL_MAJOR, 2, x, 4), CATA_OK);
    for (int i = 0; i < 3; i++) {
        CHECK(near(x[i], 1) && near(x[4 + i], 2));
    }
    CHECK(x[3] == 7 && x[7] == 7);
    double by_rows[3 * 2] = {1, 2, 0, 0, 1, 2};
    const size_t wanted[3] = {2, 0, 2};
    double rows[3 * 3] = {7, 7, 7, 7, 7, 7, 7, 7, 7};
    CHECK_STATUS(cata_cholesky_solve_rows(cholesky, CATA_ROW_MAJOR, 2, by_rows, 2, 3, wanted, rows,
                                          3),
                 CATA_OK);
    for (int i = 0; i < 3; i++) {
        CHECK(near(rows[3 * i], 1) && near(rows[3 * i + 1], 2) && rows[3 * i + 2] == 7);
    }
    size_t n = 0, count = 0, held = 9, row = 9;
    double ratio = 0;
    CHECK_STATUS(cata_cholesky_size(cholesky, &n, &count, &held), CATA_OK);
    CHECK(n == 3 && count >= 5 && count <= 6 && held == 0);
    CHECK_STATUS(cata_cholesky_held(cholesky, NULL), CATA_OK);
    CHECK_STATUS(cata_cholesky_weakest(cholesky, &row, &ratio), CATA_OK);
    CHECK(row < 3 && ratio > 0.3 && ratio < 0.8);

    /* Other values in the same places, and after values that are refused. */
    double twice[7];
    for (int i = 0; i < 7; i++) {
        twice[i] = 2 * entries[i];
    }
    const double negative[7] = {2, -1, -1, 0.25, -1, -1, 2};
    CHECK_STATUS(cata_cholesky_factor(cholesky, row_starts, columns, negative), CATA_ERR_ARGUMENT);
    CHECK_MENTIONS("not positive definite (elimination fails at row");
    CHECK_STATUS(cata_cholesky_size(cholesky, NULL, NULL, &held), CATA_OK);
    CHECK_STATUS(cata_cholesky_factor(cholesky, row_starts, columns, twice), CATA_OK);
    double other[3] = {2, 0, 2};
    CHECK_STATUS(cata_cholesky_solve(cholesky, CATA_ROW_MAJOR, 1, other, 1), CATA_OK);
    CHECK(near(other[0], 1) && near(other[1], 1) && near(other[2], 1));
    cata_cholesky_free(cholesky);
    cata_cholesky_free(NULL);
}

static void test_triangles(void)
{
    cata_cholesky_params params;
    CHECK_STATUS(cata_cholesky_params_init(&params, sizeof params), CATA_OK);
    params.triangle = CATA_UPPER;
    params.threads = 2;
    cata_cholesky *cholesky = NULL;
    CHECK_STATUS(cata_cholesky_analyse(3, upper_starts, upper_columns, &params, &cholesky),
                 CATA_OK);
    CHECK_STATUS(cata_cholesky_factor(cholesky, upper_starts, upper_columns, upper_entries),
                 CATA_OK);
    double x[3] = {1, 0, 1};
    CHECK_STATUS(cata_cholesky_solve(cholesky, CATA_COL_MAJOR, 1, x, 3), CATA_OK);
    CHECK(near(x[0], 1) && near(x[1], 1) && near(x[2], 1));
    cata_cholesky_free(cholesky);
}

static void test_semidefinite(void)
{
    /* The Laplacian of an edge, and a node alone. */
    const size_t starts[4] = {0, 2, 4, 4}, places[4] = {0, 1, 0, 1};
    const double edge[4] = {1, -1, -1, 1};
    cata_cholesky_params params = {.struct_size = sizeof params, .semidefinite = 1};
    cata_cholesky *cholesky = NULL;
    CHECK_STATUS(cata_cholesky_analyse(3, starts, places, &params, &cholesky), CATA_OK);
    CHECK_STATUS(cata_cholesky_factor(cholesky, starts, places, edge), CATA_OK);
    size_t count = 0, held[2] = {9, 9};
    CHECK_STATUS(cata_cholesky_size(cholesky, NULL, NULL, &count), CATA_OK);
    CHECK(count == 2);
    CHECK_STATUS(cata_cholesky_held(cholesky, held), CATA_OK);
    CHECK(held[0] < 2 && held[1] == 2);
    double x[3] = {3, -3, 5};
    CHECK_STATUS(cata_cholesky_solve(cholesky, CATA_COL_MAJOR, 1, x, 3), CATA_OK);
    CHECK(near(x[0] - x[1], 3) && x[held[0]] == 0 && x[2] == 0);
    cata_cholesky_free(cholesky);

    params.semidefinite = 0;
    CHECK_STATUS(cata_cholesky_analyse(3, starts, places, &params, &cholesky), CATA_OK);
    CHECK_STATUS(cata_cholesky_factor(cholesky, starts, places, edge), CATA_ERR_ARGUMENT);
    cata_cholesky_free(cholesky);
}

static int32_t stop(double fraction, void *user)
{
    (void)fraction;
    return *(int *)user;
}

static void test_refusals(void)
{
    cata_cholesky *cholesky = NULL;
    CHECK_STATUS(cata_cholesky_analyse(3, NULL, columns, NULL, &cholesky), CATA_ERR_NULL);
    CHECK_MENTIONS("row_starts: must not be NULL");
    CHECK_STATUS(cata_cholesky_analyse(3, row_starts, columns, NULL, NULL), CATA_ERR_NULL);
    const size_t beyond[7] = {0, 1, 0, 1, 3, 1, 2};
    CHECK_STATUS(cata_cholesky_analyse(3, row_starts, beyond, NULL, &cholesky), CATA_ERR_ARGUMENT);
    cata_cholesky_params params = {.struct_size = sizeof params, .triangle = 7};
    CHECK_STATUS(cata_cholesky_analyse(3, row_starts, columns, &params, &cholesky),
                 CATA_ERR_ARGUMENT);
    CHECK_MENTIONS("params.triangle");
    params.triangle = CATA_BOTH;
    params.semidefinite = 2;
    CHECK_STATUS(cata_cholesky_analyse(3, row_starts, columns, &params, &cholesky),
                 CATA_ERR_ARGUMENT);
    CHECK_MENTIONS("params.semidefinite");
    params.semidefinite = 0;
    params.tolerance = 0.5;
    CHECK_STATUS(cata_cholesky_analyse(3, row_starts, columns, &params, &cholesky),
                 CATA_ERR_ARGUMENT);
    CHECK_MENTIONS("tolerance");
    params.tolerance = 0;
    const size_t twice[3] = {2, 0, 2}, order[3] = {2, 0, 1};
    params.order = twice;
    CHECK_STATUS(cata_cholesky_analyse(3, row_starts, columns, &params, &cholesky),
                 CATA_ERR_ARGUMENT);
    CHECK_MENTIONS("order: must have every row once, but entry 2 is 2");
    CHECK(cholesky == NULL);
    params.order = order;
    CHECK_STATUS(cata_cholesky_analyse(3, row_starts, columns, &params, &cholesky), CATA_OK);
    CHECK_STATUS(cata_cholesky_factor(cholesky, row_starts, columns, entries), CATA_OK);
    double ordered[3] = {1, 0, 1};
    CHECK_STATUS(cata_cholesky_solve(cholesky, CATA_COL_MAJOR, 1, ordered, 3), CATA_OK);
    CHECK(near(ordered[0], 1) && near(ordered[1], 1) && near(ordered[2], 1));
    cata_cholesky_free(cholesky);
    cholesky = NULL;

    CHECK_STATUS(cata_cholesky_analyse(3, upper_starts, upper_columns, NULL, &cholesky), CATA_OK);
    CHECK_STATUS(cata_cholesky_factor(cholesky, upper_starts, upper_columns, upper_entries),
                 CATA_ERR_ARGUMENT);
    CHECK_MENTIONS("not symmetric");
    const size_t corner_starts[4] = {0, 1, 1, 2}, corner[2] = {2, 0};
    const double ones[2] = {1, 1};
    CHECK_STATUS(cata_cholesky_factor(cholesky, corner_starts, corner, ones), CATA_ERR_ARGUMENT);
    CHECK_MENTIONS("entry (2, 0) is not in the pattern that was analysed");
    CHECK_STATUS(cata_cholesky_factor(cholesky, row_starts, columns, entries), CATA_OK);
    double x[3] = {1, 0, NAN};
    CHECK_STATUS(cata_cholesky_solve(cholesky, CATA_COL_MAJOR, 1, x, 2), CATA_ERR_SHAPE);
    CHECK_MENTIONS("ldx");
    CHECK_STATUS(cata_cholesky_solve(cholesky, 7, 1, x, 3), CATA_ERR_ARGUMENT);
    CHECK_STATUS(cata_cholesky_solve(cholesky, CATA_COL_MAJOR, 1, x, 3), CATA_ERR_NON_FINITE);
    CHECK(x[0] == 1 && x[1] == 0);
    const size_t row = 3;
    double b[3] = {1, 0, 1}, found = 7;
    CHECK_STATUS(cata_cholesky_solve_rows(cholesky, CATA_COL_MAJOR, 1, b, 3, 1, &row, &found, 1),
                 CATA_ERR_ARGUMENT);
    CHECK_MENTIONS("row 3 is out of range: 3 rows");
    CHECK_STATUS(cata_cholesky_solve_rows(cholesky, CATA_COL_MAJOR, 1, b, 3, 1, &row, b, 1),
                 CATA_ERR_ARGUMENT);
    CHECK(found == 7);
    CHECK_STATUS(cata_cholesky_solve(NULL, CATA_COL_MAJOR, 1, b, 3), CATA_ERR_NULL);
    cata_cholesky_free(cholesky);

    int cancels = 1;
    cata_cholesky_params asks = {.struct_size = sizeof asks};
    asks.progress = stop;
    asks.progress_user = &cancels;
    CHECK_STATUS(cata_cholesky_analyse(3, row_starts, columns, &asks, &cholesky),
                 CATA_ERR_CANCELLED);
    cancels = 0;
    CHECK_STATUS(cata_cholesky_analyse(3, row_starts, columns, &asks, &cholesky), CATA_OK);
    cancels = 1;
    CHECK_STATUS(cata_cholesky_factor(cholesky, row_starts, columns, entries), CATA_ERR_CANCELLED);
    cancels = 0;
    CHECK_STATUS(cata_cholesky_factor(cholesky, row_starts, columns, entries), CATA_OK);
    cata_cholesky_free(cholesky);
    CHECK_STATUS(cata_cholesky_analyse(0, NULL, NULL, NULL, &cholesky), CATA_OK);
    CHECK_STATUS(cata_cholesky_factor(cholesky, NULL, NULL, NULL), CATA_OK);
    CHECK_STATUS(cata_cholesky_solve(cholesky, CATA_COL_MAJOR, 2, NULL, 1), CATA_OK);
    cata_cholesky_free(cholesky);
}

int main(void)
{
    test_solutions();
    test_triangles();
    test_semidefinite();
    test_refusals();
    return report("test_cholesky");
}
