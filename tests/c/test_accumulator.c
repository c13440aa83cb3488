/* Accumulators through the C ABI: blocks, removal, merges, files, what follows, refusals. */

#include <catamaran.h>

#include <math.h>
#include <stdio.h>
#include <string.h>

#include "check.h"

#define CHECK_MENTIONS(text) CHECK(strstr(cata_last_error_message(), text) != NULL)

enum { M = 60, N = 4 };
static double rows[M * N], by_columns[M * N], weights[M];

/* Two columns, a constant, and what follows from them: 3 + 2 x - y. */
static void make_rows(void)
{
    for (size_t i = 0; i < M; i++) {
        double *row = rows + N * i;
        row[0] = (double)(i % 7);
        row[1] = (double)(i % 5) - 2;
        row[2] = 1;
        row[3] = 3 + 2 * row[0] - row[1];
        weights[i] = 1 + (double)(i % 3);
        for (size_t j = 0; j < N; j++) {
            by_columns[i + M * j] = row[j];
        }
    }
}

static void sum_of(const double *weight, double *c)
{
    memset(c, 0, N * N * sizeof *c);
    for (size_t i = 0; i < M; i++) {
        for (size_t j = 0; j < N; j++) {
            for (size_t k = 0; k < N; k++) {
                c[N * j + k] += (weight ? weight[i] : 1) * rows[N * i + j] * rows[N * i + k];
            }
        }
    }
}

static const double lower[N] = {0, -2, 0, -9}, upper[N] = {9, 2, 1, 99};

static cata_accumulator *made(int32_t sums, int32_t centered, size_t threads)
{
    cata_accumulator *accumulator = NULL;
    cata_accumulator_params params;
    CHECK_STATUS(cata_accumulator_params_init(&params, sizeof params), CATA_OK);
    params.threads = threads;
    params.sums = sums;
    params.centered = centered;
    params.lower = lower;
    params.upper = upper;
    params.rows = 3 * M;
    params.largest_weight = 3;
    CHECK_STATUS(cata_accumulator_new(N, &params, &accumulator), CATA_OK);
    return accumulator;
}

static void test_sums(void)
{
    double expected[N * N], c[N * N];
    for (int32_t sums = CATA_SUMS_FLOAT; sums <= CATA_SUMS_EXTENDED; sums++) {
        for (size_t threads = 1; threads <= 4; threads *= 2) {
            cata_accumulator *one = made(sums, 0, threads), *other = made(sums, 0, threads);
            CHECK_STATUS(cata_accumulator_add(one, CATA_ROW_MAJOR, 25, rows, N, weights), CATA_OK);
            CHECK_STATUS(cata_accumulator_add(other, CATA_COL_MAJOR, M - 25, by_columns + 25, M,
                                              weights + 25),
                         CATA_OK);
            CHECK_STATUS(cata_accumulator_merge(one, other), CATA_OK);
            uint64_t count = 0;
            double weight = 0;
            CHECK_STATUS(cata_accumulator_rows(one, &count, &weight, NULL), CATA_OK);
            CHECK(count == M && weight == 120);
            sum_of(weights, expected);
            CHECK_STATUS(cata_accumulator_gram(one, CATA_ROW_MAJOR, CATA_BOTH, 1, c, N), CATA_OK);
            CHECK(memcmp(c, expected, sizeof c) == 0);
            c[1] = c[N] = -7;
            CHECK_STATUS(cata_accumulator_gram(one, CATA_COL_MAJOR, CATA_LOWER, 2, c, N), CATA_OK);
            CHECK(c[N] == -7 && c[1] == 2 * expected[1]);
            /* Twice the rows of one part, and without them. */
            if (sums != CATA_SUMS_FLOAT) {
                CHECK_STATUS(cata_accumulator_add(one, CATA_ROW_MAJOR, 9, rows, N, weights), CATA_OK);
                CHECK_STATUS(cata_accumulator_remove(one, CATA_ROW_MAJOR, 9, rows, N, weights),
                             CATA_OK);
                CHECK_STATUS(cata_accumulator_gram(one, CATA_ROW_MAJOR, CATA_BOTH, 1, c, N), CATA_OK);
                CHECK(memcmp(c, expected, sizeof c) == 0);
            } else {
                CHECK_STATUS(cata_accumulator_remove(one, CATA_ROW_MAJOR, 9, rows, N, weights),
                             CATA_ERR_ARGUMENT);
                CHECK_MENTIONS("exact");
            }
            cata_accumulator_free(one);
            cata_accumulator_free(other);
        }
    }
}

static void test_what_follows(void)
{
    cata_accumulator *sums = made(CATA_SUMS_EXTENDED, 0, 1), *copy = NULL, *centred = NULL;
    CHECK_STATUS(cata_accumulator_add(sums, CATA_ROW_MAJOR, M, rows, N, NULL), CATA_OK);
    double x[3] = {0};
    cata_lstsq_result result = {.struct_size = sizeof result};
    CHECK_STATUS(cata_accumulator_lstsq(sums, 1, CATA_ROW_MAJOR, x, 1, &result, NULL), CATA_OK);
    CHECK(fabs(x[0] - 2) < 1e-14 && fabs(x[1] + 1) < 1e-14 && fabs(x[2] - 3) < 1e-14);
    CHECK(result.rank == 3 && result.degrees_of_freedom == M - 3);
    CHECK_STATUS(cata_accumulator_lstsq(sums, 5, CATA_ROW_MAJOR, x, 1, NULL, NULL),
                 CATA_ERR_ARGUMENT);
    CHECK_STATUS(cata_accumulator_pca(sums, CATA_ROW_MAJOR, 5, NULL, N, NULL, NULL, NULL, NULL, NULL,
                                      NULL),
                 CATA_ERR_ARGUMENT);
    CHECK_MENTIONS("count");

    /* Through a file, and on. */
    char name[64];
    snprintf(name, sizeof name, "test_accumulator_%p.sums", (void *)sums);
    CHECK_STATUS(cata_accumulator_write(sums, name), CATA_OK);
    CHECK_STATUS(cata_accumulator_read(name, NULL, &copy), CATA_OK);
    CHECK_STATUS(cata_accumulator_remove(copy, CATA_ROW_MAJOR, M, rows, N, NULL), CATA_OK);
    uint64_t count = 9;
    CHECK_STATUS(cata_accumulator_rows(copy, &count, NULL, NULL), CATA_OK);
    CHECK(count == 0);
    remove(name);
    cata_accumulator_free(copy);
    copy = NULL;
    CHECK_STATUS(cata_accumulator_read(name, NULL, &copy), CATA_ERR_IO);
    CHECK(copy == NULL);

    centred = made(CATA_SUMS_EXTENDED, 1, 2);
    CHECK_STATUS(cata_accumulator_add(centred, CATA_ROW_MAJOR, M, rows, N, NULL), CATA_OK);
    double components[2 * N], again[2 * N], mean[N], variances[2];
    CHECK_STATUS(cata_accumulator_pca(centred, CATA_ROW_MAJOR, 2, components, N, variances, NULL,
                                      NULL, mean, NULL, NULL),
                 CATA_OK);
    CHECK_STATUS(cata_pca(CATA_ROW_MAJOR, M, N, rows, N, 2, again, N, NULL, NULL, NULL, NULL, NULL,
                          NULL),
                 CATA_OK);
    for (size_t i = 0; i < 2 * N; i++) {
        CHECK(fabs(components[i] - again[i]) < 1e-12);
    }
    CHECK(variances[0] > variances[1] && mean[2] == 1);
    CHECK_STATUS(cata_accumulator_merge(centred, sums), CATA_ERR_ARGUMENT);
    CHECK_MENTIONS("centring");
    CHECK_STATUS(cata_accumulator_rows(centred, &count, NULL, mean), CATA_OK);
    CHECK(count == M && mean[2] == 1);
    cata_accumulator_free(sums);
    cata_accumulator_free(centred);
}

/* A .npy file of version 1.0, rows of doubles. */
static void write_npy(const char *name)
{
    char header[128] = "\x93NUMPY\x01\x00\x76\x00{'descr': '<f8', 'fortran_order': False, 'shape': (60, 4), }";
    FILE *file = fopen(name, "wb");
    const size_t length = 10 + strlen(header + 10);
    memset(header + length, ' ', sizeof header - length);
    header[127] = '\n';
    CHECK(file != NULL && fwrite(header, 1, 128, file) == 128);
    CHECK(file != NULL && fwrite(rows, sizeof *rows, M * N, file) == M * N && fclose(file) == 0);
}

static void test_file(void)
{
    double expected[N * N], c[N * N];
    char name[64];
    cata_accumulator *sums = made(CATA_SUMS_FLOAT, 0, 1);
    snprintf(name, sizeof name, "test_accumulator_%p.npy", (void *)sums);
    write_npy(name);
    CHECK_STATUS(cata_accumulator_add_file(sums, name), CATA_OK);
    remove(name);
    sum_of(NULL, expected);
    CHECK_STATUS(cata_accumulator_gram(sums, CATA_ROW_MAJOR, CATA_BOTH, 1, c, N), CATA_OK);
    CHECK(memcmp(c, expected, sizeof c) == 0);
    CHECK_STATUS(cata_accumulator_add_file(sums, name), CATA_ERR_IO);
    CHECK_STATUS(cata_accumulator_add_file(sums, NULL), CATA_ERR_NULL);
    /* It can go on. */
    CHECK_STATUS(cata_accumulator_add(sums, CATA_ROW_MAJOR, 1, rows, N, NULL), CATA_OK);
    cata_accumulator_free(sums);
}

static int32_t cancel(double fraction, void *user)
{
    (void)fraction;
    ++*(int *)user;
    return 1;
}

static int32_t go_on(double fraction, void *user)
{
    *(double *)user = fraction;
    return 0;
}

/* What follows from sums asks the callback of its own parameters, and has the same bytes for any
 * number of threads. */
static void test_progress_of_what_follows(void)
{
    cata_accumulator *sums = made(CATA_SUMS_EXTENDED, 1, 1);
    CHECK_STATUS(cata_accumulator_add(sums, CATA_ROW_MAJOR, M, rows, N, NULL), CATA_OK);
    double x[N - 1] = {7}, again[N - 1], components[2 * N] = {7}, others[2 * N], last = -1;
    int calls = 0;
    cata_lstsq_params fit = {.struct_size = sizeof fit, .intercept = 1};
    cata_pca_params pca = {.struct_size = sizeof pca};
    fit.progress = pca.progress = cancel;
    fit.progress_user = pca.progress_user = &calls;
    CHECK_STATUS(cata_accumulator_lstsq(sums, 1, CATA_ROW_MAJOR, x, 1, NULL, &fit),
                 CATA_ERR_CANCELLED);
    CHECK(calls == 1 && x[0] == 7);
    CHECK_STATUS(cata_accumulator_pca(sums, CATA_ROW_MAJOR, 2, components, N, NULL, NULL, NULL, NULL,
                                      NULL, &pca),
                 CATA_ERR_CANCELLED);
    CHECK(calls == 2 && components[0] == 7);
    /* A call that is cancelled leaves the sums as they are. */
    fit.progress = pca.progress = go_on;
    fit.progress_user = pca.progress_user = &last;
    CHECK_STATUS(cata_accumulator_lstsq(sums, 1, CATA_ROW_MAJOR, x, 1, NULL, &fit), CATA_OK);
    CHECK(last == 1 && x[0] != 7);
    last = -1;
    CHECK_STATUS(cata_accumulator_pca(sums, CATA_ROW_MAJOR, 2, components, N, NULL, NULL, NULL, NULL,
                                      NULL, &pca),
                 CATA_OK);
    CHECK(last == 1 && components[0] != 7);
    fit.threads = pca.threads = 3;
    CHECK_STATUS(cata_accumulator_lstsq(sums, 1, CATA_ROW_MAJOR, again, 1, NULL, &fit), CATA_OK);
    CHECK(memcmp(x, again, sizeof x) == 0);
    CHECK_STATUS(cata_accumulator_pca(sums, CATA_ROW_MAJOR, 2, others, N, NULL, NULL, NULL, NULL, NULL,
                                      &pca),
                 CATA_OK);
    CHECK(memcmp(components, others, sizeof others) == 0);
    cata_accumulator_free(sums);
}

static void test_refusals(void)
{
    cata_accumulator *sums = NULL;
    int calls = 0;
    cata_accumulator_params params = {.struct_size = sizeof params, .sums = 3};
    CHECK_STATUS(cata_accumulator_new(N, &params, &sums), CATA_ERR_ARGUMENT);
    CHECK_MENTIONS("params.sums");
    params.sums = CATA_SUMS_EXACT;
    CHECK_STATUS(cata_accumulator_new(N, &params, &sums), CATA_ERR_NULL);
    CHECK_MENTIONS("params.lower");
    CHECK_STATUS(cata_accumulator_new(N, NULL, NULL), CATA_ERR_NULL);
    CHECK_STATUS(cata_accumulator_add(NULL, CATA_ROW_MAJOR, 1, rows, N, NULL), CATA_ERR_NULL);
    CHECK(sums == NULL);
    cata_accumulator_free(NULL);

    /* Beyond the bounds: refused, and nothing is lost. */
    sums = made(CATA_SUMS_EXACT, 0, 1);
    const double far[N] = {0, 3, 0, 0};
    uint64_t count = 9;
    CHECK_STATUS(cata_accumulator_add(sums, CATA_ROW_MAJOR, 1, far, N, NULL), CATA_ERR_ARGUMENT);
    CHECK_STATUS(cata_accumulator_add(sums, CATA_ROW_MAJOR, 1, rows, N - 1, NULL), CATA_ERR_SHAPE);
    CHECK_STATUS(cata_accumulator_add(sums, CATA_ROW_MAJOR, 2, rows, N, NULL), CATA_OK);
    CHECK_STATUS(cata_accumulator_rows(sums, &count, NULL, NULL), CATA_OK);
    CHECK(count == 2);
    double x[N];
    CHECK_STATUS(cata_accumulator_lstsq(sums, 1, CATA_ROW_MAJOR, x, 1, NULL, NULL),
                 CATA_ERR_ARGUMENT);
    CHECK_MENTIONS("extended");
    cata_accumulator_free(sums);

    /* Cancelled within the rows: of no use, and it says so. */
    cata_accumulator_params watched = {.struct_size = sizeof watched};
    watched.progress = cancel;
    watched.progress_user = &calls;
    CHECK_STATUS(cata_accumulator_new(N, &watched, &sums), CATA_OK);
    CHECK_STATUS(cata_accumulator_add(sums, CATA_ROW_MAJOR, M, rows, N, NULL), CATA_ERR_CANCELLED);
    CHECK(calls == 1);
    CHECK_STATUS(cata_accumulator_rows(sums, &count, NULL, NULL), CATA_ERR_ARGUMENT);
    CHECK_MENTIONS("must not be used after an error");
    cata_accumulator_free(sums);
}

int main(void)
{
    make_rows();
    test_sums();
    test_what_follows();
    test_file();
    test_progress_of_what_follows();
    test_refusals();
    return report("test_accumulator");
}
