/* Every distributed function, under mpirun on any number of ranks; what one rank gets wrong is an error on all. */

#include <catamaran_mpi.h>

#include <math.h>
#include <stdint.h>
#include <stdlib.h>
#include <string.h>

#include "check.h"

enum { M = 37, N = 11 };

#define CHECK_MESSAGE(text) CHECK(strcmp(cata_last_error_message(), text) == 0)
#define CHECK_MENTIONS(text) CHECK(strstr(cata_last_error_message(), text) != NULL)

static int rank, size;
static cata_world *world;

/* Small integers, so that sums are exact in any order. */
static double entry(int i, int j)
{
    return (i * 31 + j * 17 + i * j) % 7 - 3;
}

/* Entry (j, k) of A^T A, and of A A^T. */
static double ata(int j, int k)
{
    double sum = 0.0;
    for (int i = 0; i < M; i++) {
        sum += entry(i, j) * entry(i, k);
    }
    return sum;
}

static double aat(int i, int k)
{
    double sum = 0.0;
    for (int j = 0; j < N; j++) {
        sum += entry(i, j) * entry(k, j);
    }
    return sum;
}

/* Status of a rank when `at_fault` has the given one. */
static cata_status seen(int at_fault, cata_status own)
{
    return rank == at_fault ? own : CATA_ERR_RANK;
}

static void test_world(void)
{
    size_t number = 99;
    CHECK_STATUS(cata_world_rank(world, &number), CATA_OK);
    CHECK(number == (size_t)rank);
    CHECK_STATUS(cata_world_size(world, &number), CATA_OK);
    CHECK(number == (size_t)size);
    CHECK_STATUS(cata_world_rank(NULL, &number), CATA_ERR_NULL);
    CHECK_MESSAGE("world: must not be NULL");
    CHECK_STATUS(cata_world_size(world, NULL), CATA_ERR_NULL);
    CHECK_MESSAGE("size: must not be NULL");
    CHECK_STATUS(cata_world_set_longest_message(NULL, 1), CATA_ERR_NULL);
    CHECK(cata_capabilities() & CATA_CAP_MPI);

    cata_traffic traffic;
    memset(&traffic, 7, sizeof traffic);
    CHECK_STATUS(cata_world_traffic(world, &traffic), CATA_ERR_ARGUMENT);
    CHECK_MENTIONS("traffic.struct_size");
    traffic.struct_size = sizeof traffic;
    CHECK_STATUS(cata_world_traffic(NULL, &traffic), CATA_ERR_NULL);
    CHECK_STATUS(cata_world_traffic(world, NULL), CATA_ERR_NULL);

    /* Of a struct that is too short no more than its size is read, and nothing is written. */
    size_t lone[2] = {sizeof lone[0], 7};
    CHECK_STATUS(cata_world_traffic(world, (cata_traffic *)lone), CATA_ERR_ARGUMENT);
    CHECK(lone[0] == sizeof lone[0] && lone[1] == 7);

    /* A later version's struct is longer. */
    struct {
        cata_traffic known;
        uint64_t unknown;
    } longer = {{sizeof longer, 1, 1, 1, 1}, 1};
    CHECK_STATUS(cata_world_traffic(world, &longer.known), CATA_OK);
    CHECK(longer.known.words_sent == 0 && longer.known.messages_received == 0);
    CHECK(longer.unknown == 0);

    /* On one rank alone: all refuse. */
    cata_world *other = NULL;
    int last = size - 1;
    CHECK_STATUS(cata_world_from_comm(MPI_COMM_WORLD, rank == last ? NULL : &other),
                 seen(last, CATA_ERR_NULL));
    CHECK(other == NULL);
    CHECK_STATUS(cata_world_from_comm(MPI_COMM_NULL, &other), CATA_ERR_ARGUMENT);
    CHECK_MESSAGE("communicator: not a communicator");
    cata_world_free(NULL);
}

/* Two worlds of one communicator, and one of half of it. */
static void test_worlds(void)
{
    cata_world *second = NULL, *half = NULL;
    MPI_Comm comm;
    size_t number = 99;
    CHECK_STATUS(cata_world_from_comm(MPI_COMM_WORLD, &second), CATA_OK);
    MPI_Comm_split(MPI_COMM_WORLD, rank % 2, rank, &comm);
    CHECK_STATUS(cata_world_from_comm(comm, &half), CATA_OK);
    MPI_Comm_free(&comm);
    CHECK_STATUS(cata_world_rank(half, &number), CATA_OK);
    CHECK(number == (size_t)rank / 2);

    /* Each half has a product of its own, after its communicator is gone. */
    double a = rank % 2 + 1.0, c = 0.0;
    cata_symmetric *product = NULL;
    CHECK_STATUS(cata_world_ata_rows_f64(half, CATA_ROW_MAJOR, 1, 1, 1.0, &a, 1, NULL, &product),
                 CATA_OK);
    CHECK_STATUS(cata_symmetric_gather_f64(product, half, 0, CATA_ROW_MAJOR, CATA_BOTH, &c, 1),
                 CATA_OK);
    int members = rank % 2 == 0 ? (size + 1) / 2 : size / 2;
    CHECK(number != 0 || c == members * a * a);
    if (members != size) {
        CHECK_STATUS(cata_symmetric_gather_f64(product, second, 0, CATA_ROW_MAJOR, CATA_BOTH, &c, 1),
                     CATA_ERR_ARGUMENT);
        CHECK_MENTIONS("symmetric: spread over");
    }
    cata_world_free(half);
    cata_symmetric_free(product);
    cata_world_free(second);
}

/* A product of 2 A^T A passes, and one of A^T A does not. */
static void test_verify(const cata_symmetric *product, const cata_symmetric *product32, int32_t spread,
                        int32_t layout, size_t rows, size_t cols, const double *a, const float *a32,
                        size_t lda)
{
    int32_t passed = 5;
    double residual = -1.0, tolerance = -1.0;
    int last = size - 1;
    CHECK_STATUS(cata_symmetric_verify_f64(product, world, spread, layout, rows, cols, 2.0, a, lda, 20, 7,
                                           &passed, &residual, &tolerance),
                 CATA_OK);
    CHECK(passed == 1 && residual >= 0.0 && residual <= tolerance);
    if (product32 != NULL) {
        CHECK_STATUS(cata_symmetric_verify_f32(product32, world, spread, layout, rows, cols, 1.0, a32, lda,
                                               20, 7, &passed, &residual, NULL),
                     CATA_OK);
        CHECK(passed == 0 && residual > tolerance);
    }
    passed = 5;
    CHECK_STATUS(cata_symmetric_verify_f64(product, world, spread, layout, rows, cols, 2.0, a, lda,
                                           rank == last ? -1 : 20, 7, &passed, NULL, NULL),
                 seen(last, CATA_ERR_ARGUMENT));
    CHECK_MENTIONS("rounds: must be 1 to 1000, is -1");
    CHECK_STATUS(cata_symmetric_verify_f64(product, world, rank == last ? 0 : spread, layout, rows, cols, 2.0,
                                           a, lda, 20, 7, &passed, NULL, NULL),
                 seen(last, CATA_ERR_ARGUMENT));
    CHECK_MENTIONS("spread: must be CATA_BY_ROWS");
    CHECK_STATUS(cata_symmetric_verify_f64(product, world, spread, layout, rows, cols, 2.0, a, lda, 20, 7,
                                           rank == last ? NULL : &passed, NULL, NULL),
                 seen(last, CATA_ERR_NULL));
    CHECK(passed == 5);
}

/* Each rank has rows of A, row-major on even ranks and column-major on odd ones; the sum is on the last rank. */
static void test_rows(void)
{
    static double a[M * N], c[N * N];
    static float a32[M * N], c32[N * N];
    int first = M * rank / size, rows = M * (rank + 1) / size - first, root = size - 1;
    int32_t layout = rank % 2 == 0 ? CATA_ROW_MAJOR : CATA_COL_MAJOR;
    size_t lda = rank % 2 == 0 ? N : M;
    for (int i = 0; i < rows; i++) {
        for (int j = 0; j < N; j++) {
            int at = rank % 2 == 0 ? i * N + j : i + j * M;
            a[at] = entry(first + i, j);
            a32[at] = (float)a[at];
        }
    }
    cata_symmetric *product = NULL, *product32 = NULL;
    size_t n = 0;
    CHECK_STATUS(
        cata_world_ata_rows_f64(world, layout, (size_t)rows, N, 2.0, a, lda, NULL, &product), CATA_OK);
    CHECK_STATUS(
        cata_world_ata_rows_f32(world, layout, (size_t)rows, N, 2.0f, a32, lda, NULL, &product32),
        CATA_OK);
    CHECK_STATUS(cata_symmetric_n(product, &n), CATA_OK);
    CHECK(n == N);
    CHECK_STATUS(cata_symmetric_n(product, NULL), CATA_ERR_NULL);
    CHECK_STATUS(cata_symmetric_n(NULL, &n), CATA_ERR_NULL);
    CHECK_MESSAGE("symmetric: must not be NULL");

    /* On the root only. */
    int here = rank == root;
    CHECK_STATUS(cata_symmetric_gather_f64(product, world, (size_t)root, CATA_ROW_MAJOR, CATA_BOTH,
                                           here ? c : NULL, here ? N : 0),
                 CATA_OK);
    CHECK_STATUS(cata_symmetric_gather_f32(product32, world, (size_t)root, CATA_COL_MAJOR, CATA_LOWER,
                                           here ? c32 : NULL, here ? N : 0),
                 CATA_OK);
    for (int j = 0; here && j < N; j++) {
        for (int k = 0; k < N; k++) {
            CHECK(c[j * N + k] == 2.0 * ata(j, k));
            CHECK(c32[j + k * N] == (j >= k ? (float)(2.0 * ata(j, k)) : 0.0f));
        }
    }

    test_verify(product, product32, CATA_BY_ROWS, layout, (size_t)rows, N, a, a32, lda);

    /* Nobody hangs. */
    memset(c, 0, sizeof c);
    CHECK_STATUS(cata_symmetric_gather_f64(product, world, 0, CATA_ROW_MAJOR, CATA_BOTH, NULL, N),
                 seen(0, CATA_ERR_NULL));
    CHECK(rank == 0 || strcmp(cata_last_error_message(), "rank 0: c: must not be NULL") == 0);
    CHECK_STATUS(cata_symmetric_gather_f64(product, world, 0, CATA_ROW_MAJOR, CATA_BOTH, c, N - 1),
                 seen(0, CATA_ERR_SHAPE));
    CHECK_STATUS(
        cata_symmetric_gather_f64(product, world, (size_t)size, CATA_ROW_MAJOR, CATA_BOTH, c, N),
        CATA_ERR_ARGUMENT);
    CHECK_MENTIONS("root: must be less than");
    CHECK_STATUS(cata_symmetric_gather_f64(product32, world, 0, CATA_ROW_MAJOR, CATA_BOTH, c, N),
                 CATA_ERR_ARGUMENT);
    CHECK_MESSAGE("symmetric: does not hold entries of type f64");
    CHECK_STATUS(cata_symmetric_gather_f32(NULL, world, 0, CATA_ROW_MAJOR, CATA_BOTH, c32, N),
                 CATA_ERR_NULL);
    CHECK(c[0] == 0.0);
    cata_symmetric_free(product32);
    cata_symmetric_free(product);
    cata_symmetric_free(NULL);
}

static void test_columns(void)
{
    static double a[M * N], c[N * N];
    int first = N * rank / size, cols = N * (rank + 1) / size - first;
    for (int j = 0; j < cols; j++) {
        for (int i = 0; i < M; i++) {
            a[i + j * M] = entry(i, first + j);
        }
    }
    cata_symmetric *product = NULL;
    cata_ata_params params = {.struct_size = sizeof params};
    params.threads = 1;
    CHECK_STATUS(cata_world_set_longest_message(world, 13), CATA_OK);
    CHECK_STATUS(cata_world_ata_columns(world, CATA_COL_MAJOR, M, (size_t)cols, 2.0, a, M, &params,
                                            &product),
                 CATA_OK);
    CHECK_STATUS(cata_symmetric_gather_f64(product, world, 0, CATA_COL_MAJOR, CATA_UPPER, c, N), CATA_OK);
    CHECK_STATUS(cata_world_set_longest_message(world, SIZE_MAX), CATA_OK);
    for (int j = 0; rank == 0 && j < N; j++) {
        for (int k = 0; k < N; k++) {
            CHECK(c[j + k * N] == (j <= k ? 2.0 * ata(j, k) : 0.0));
        }
    }
    test_verify(product, NULL, CATA_BY_COLUMNS, CATA_COL_MAJOR, M, (size_t)cols, a, NULL, M);
    cata_symmetric_free(product);

    cata_traffic traffic;
    traffic.struct_size = sizeof traffic;
    CHECK_STATUS(cata_world_traffic(world, &traffic), CATA_OK);
    CHECK(size == 1 || traffic.words_sent > 0);
    CHECK(size == 1 || traffic.messages_sent > traffic.words_sent / 1000);
}

/* A and C on the last rank; the others say nothing of them. */
static void test_root(void)
{
    static double a[M * N], c[N * N];
    int root = size - 1, here = rank == root;
    for (int i = 0; i < M; i++) {
        for (int j = 0; j < N; j++) {
            a[i * N + j] = entry(i, j);
        }
    }
    for (int i = 0; i < N * N; i++) {
        c[i] = -1.0;
    }
    CHECK_STATUS(cata_world_ata_root(world, (size_t)root, here ? CATA_ROW_MAJOR : 0,
                                         here ? CATA_LOWER : 0, here ? M : 0, here ? N : 0, 2.0,
                                         here ? a : NULL, here ? N : 0, 1.0, here ? c : NULL, here ? N : 0,
                                         NULL),
                 CATA_OK);
    for (int j = 0; j < N; j++) {
        for (int k = 0; k < N; k++) {
            CHECK(c[j * N + k] == (here && j >= k ? 2.0 * ata(j, k) - 1.0 : -1.0));
        }
    }
    double old = c[0];
    CHECK_STATUS(cata_world_ata_root(world, (size_t)root, CATA_ROW_MAJOR, CATA_LOWER, M, N, 2.0, a, N,
                                         1.0, here ? NULL : c, N, NULL),
                 seen(root, CATA_ERR_NULL));
    CHECK_MENTIONS("c: must not be NULL");
    CHECK_STATUS(cata_world_ata_root(world, (size_t)root, CATA_ROW_MAJOR, CATA_LOWER, M, N, 2.0, a,
                                         N - 1, 1.0, c, N, NULL),
                 seen(root, CATA_ERR_SHAPE));
    CHECK_STATUS(cata_world_ata_root(world, (size_t)size, CATA_ROW_MAJOR, CATA_LOWER, M, N, 2.0, a, N,
                                         1.0, c, N, NULL),
                 CATA_ERR_ARGUMENT);
    CHECK(c[0] == old);
}

static void test_errors(void)
{
    double a[4 * N] = {0};
    cata_symmetric *product = NULL;
    int last = size - 1;
    size_t n = rank == last ? N - 1 : N;
    /* Another shape, NULL, wrong parameters on the last rank. */
    if (size > 1) {
        CHECK_STATUS(cata_world_ata_rows_f64(world, CATA_ROW_MAJOR, 4, n, 1.0, a, N, NULL, &product),
                     CATA_ERR_RANK);
        CHECK_MENTIONS("n is 10, where rank 0 has 11");
        CHECK_STATUS(cata_world_ata_columns(world, CATA_COL_MAJOR, n, 1, 1.0, a, N, NULL, &product),
                     CATA_ERR_RANK);
        CHECK_STATUS(rank == 0
                         ? cata_world_ata_rows_f64(world, CATA_ROW_MAJOR, 4, N, 1.0, a, N, NULL, &product)
                         : cata_world_ata_columns(world, CATA_COL_MAJOR, N, 1, 1.0, a, N, NULL,
                                                      &product),
                     CATA_ERR_RANK);
        CHECK_MENTIONS("called another function than rank 0");
    }
    const double *from = rank == last ? NULL : a;
    CHECK_STATUS(cata_world_ata_rows_f64(world, CATA_ROW_MAJOR, 4, N, 1.0, from, N, NULL, &product),
                 seen(last, CATA_ERR_NULL));
    CHECK_MENTIONS("a: must not be NULL");
    CHECK_STATUS(cata_world_ata_columns(world, CATA_COL_MAJOR, N, 4, 1.0, a,
                                            rank == last ? N - 1 : N, NULL, &product),
                 seen(last, CATA_ERR_SHAPE));
    CHECK_MENTIONS("lda: must be at least 11");
    CHECK_STATUS(cata_world_ata_rows_f64(world, rank == last ? 0 : CATA_ROW_MAJOR, 4, N, 1.0, a, N, NULL,
                                         &product),
                 seen(last, CATA_ERR_ARGUMENT));
    CHECK_STATUS(cata_world_ata_rows_f64(world, CATA_ROW_MAJOR, 4, N, 1.0, a, N, NULL,
                                         rank == last ? NULL : &product),
                 seen(last, CATA_ERR_NULL));
    cata_ata_params params = {.struct_size = sizeof params};
    params.scheme = rank == last ? 99 : CATA_SCHEME_AUTO;
    CHECK_STATUS(cata_world_ata_rows_f64(world, CATA_ROW_MAJOR, 4, N, 1.0, a, N, &params, &product),
                 seen(last, CATA_ERR_ARGUMENT));
    CHECK_MENTIONS("params.scheme");
    CHECK_STATUS(cata_world_ata_rows_f64(NULL, CATA_ROW_MAJOR, 4, N, 1.0, a, N, NULL, &product),
                 CATA_ERR_NULL);
    CHECK(product == NULL);
    /* And the world goes on working. */
    CHECK_STATUS(cata_world_ata_rows_f64(world, CATA_ROW_MAJOR, 4, N, 1.0, a, N, NULL, &product), CATA_OK);
    cata_symmetric_free(product);
}

/* ScaLAPACK's NUMROC and INDXL2G, for a matrix that begins on process `first`. */
static int numroc(int n, int block, int process, int first, int processes)
{
    int count = 0;
    for (int i = 0; i < n; i++) {
        count += (i / block + first) % processes == process;
    }
    return count;
}

static int global(int local, int block, int process, int first, int processes)
{
    return (local / block * processes + (process + processes - first) % processes) * block +
           local % block;
}

/* A matrix that is dealt out: its descriptor, and what this rank has of it. */
typedef struct {
    int32_t desc[9];
    int row, col, grid_rows, grid_cols, rows, cols;
    double *entries;
} dealt;

static dealt deal(int m, int n, int mb, int nb, int row0, int col0, int grid_rows, int grid_cols,
                  int32_t order, double (*value)(int, int))
{
    dealt d;
    int inside = rank < grid_rows * grid_cols;
    d.row = order == CATA_ROW_MAJOR ? rank / grid_cols : rank % grid_rows;
    d.col = order == CATA_ROW_MAJOR ? rank % grid_cols : rank / grid_rows;
    d.grid_rows = grid_rows;
    d.grid_cols = grid_cols;
    d.rows = inside ? numroc(m, mb, d.row, row0, grid_rows) : 0;
    d.cols = inside ? numroc(n, nb, d.col, col0, grid_cols) : 0;
    int32_t desc[9] = {1, inside ? 0 : -1, m, n, mb, nb, row0, col0, d.rows + 2};
    memcpy(d.desc, desc, sizeof desc);
    d.entries = calloc((size_t)(d.rows + 2) * (size_t)d.cols + 1, sizeof(double));
    for (int j = 0; j < d.cols; j++) {
        for (int i = 0; i < d.rows; i++) {
            double x = value(global(i, mb, d.row, row0, grid_rows), global(j, nb, d.col, col0, grid_cols));
            d.entries[i + j * (d.rows + 2)] = x;
        }
    }
    return d;
}

/* Its entries are those of `value` within the triangle, and -1 elsewhere; between columns there are zeros. */
static void check_dealt(const dealt *d, int32_t uplo, double (*value)(int, int), double factor)
{
    int wrong = 0, lld = d->rows + 2;
    for (int j = 0; j < d->cols; j++) {
        for (int i = 0; i < lld; i++) {
            double should_be = 0.0;
            if (i < d->rows) {
                int k = global(i, d->desc[4], d->row, d->desc[6], d->grid_rows);
                int l = global(j, d->desc[5], d->col, d->desc[7], d->grid_cols);
                int wanted = uplo == CATA_BOTH || (uplo == CATA_LOWER ? k >= l : k <= l);
                should_be = wanted ? factor * value(k, l) - 1.0 : -1.0;
            }
            wrong += d->entries[i + j * lld] != should_be;
        }
    }
    CHECK(wrong == 0);
}

static void discard(dealt *d)
{
    free(d->entries);
}

static double minus_one(int i, int j)
{
    (void)i;
    (void)j;
    return -1.0;
}

/* C := 2 A^T A + C and C := A A^T + C of block-cyclic matrices, on every grid that the ranks allow. */
static void test_cyclic(void)
{
    static const int32_t uplos[3] = {CATA_LOWER, CATA_UPPER, CATA_BOTH};
    int kind = 0;
    for (int grid_rows = 1; grid_rows <= size; grid_rows++) {
        for (int grid_cols = 1; grid_rows * grid_cols <= size; grid_cols++, kind++) {
            int32_t order = kind % 2 == 0 ? CATA_ROW_MAJOR : CATA_COL_MAJOR, uplo = uplos[kind % 3];
            size_t pr = (size_t)grid_rows, pc = (size_t)grid_cols;
            dealt a = deal(M, N, 4, 2, grid_rows - 1, 0, grid_rows, grid_cols, order, entry);
            dealt c = deal(N, N, 3, 2, 0, grid_cols - 1, grid_rows, grid_cols, order, minus_one);
            dealt d = deal(M, M, 5, 5, 0, 0, grid_rows, grid_cols, order, minus_one);
            CHECK_STATUS(cata_world_ata_cyclic(world, uplo, 2.0, a.entries, a.desc, 1.0, c.entries,
                                                   c.desc, pr, pc, order, NULL),
                         CATA_OK);
            check_dealt(&c, uplo, ata, 2.0);
            CHECK_STATUS(cata_world_aat_cyclic(world, uplo, 1.0, a.entries, a.desc, 1.0, d.entries,
                                                   d.desc, pr, pc, order, NULL),
                         CATA_OK);
            check_dealt(&d, uplo, aat, 1.0);
            discard(&a);
            discard(&c);
            discard(&d);
        }
    }
}

static cata_status cyclic(int32_t uplo, const double *a, const int32_t *desc_a, double *c,
                          const int32_t *desc_c, size_t grid_rows, size_t grid_cols, int32_t order)
{
    return cata_world_ata_cyclic(world, uplo, 1.0, a, desc_a, 0.0, c, desc_c, grid_rows, grid_cols,
                                     order, NULL);
}

static void test_cyclic_errors(void)
{
    dealt a = deal(M, N, 4, 2, 0, 0, 1, size, CATA_ROW_MAJOR, entry);
    dealt c = deal(N, N, 4, 2, 0, 0, 1, size, CATA_ROW_MAJOR, minus_one);
    double old = c.cols > 0 ? c.entries[0] : 0.0;
    int last = size - 1;
    size_t pc = (size_t)size;
#define GOOD_GRID 1, pc, CATA_ROW_MAJOR

    /* On all ranks. */
    /* As large as its descriptor says, or it would overlap A. */
    dealt tall = deal(M, N, 4, 2, 0, 0, 1, size, CATA_ROW_MAJOR, minus_one);
    CHECK_STATUS(cyclic(CATA_LOWER, a.entries, a.desc, tall.entries, a.desc, GOOD_GRID),
                 CATA_ERR_SHAPE);
    CHECK_MESSAGE("C: expected 11 x 11, got 37 x 11");
    discard(&tall);
    CHECK_STATUS(cyclic(CATA_LOWER, a.entries, a.desc, c.entries, c.desc, 2, pc, CATA_ROW_MAJOR),
                 CATA_ERR_ARGUMENT);
    CHECK_MENTIONS("grid: 2 x");
    CHECK_STATUS(cyclic(CATA_LOWER, a.entries, a.desc, c.entries, c.desc, 0, pc, CATA_ROW_MAJOR),
                 CATA_ERR_ARGUMENT);
    CHECK_STATUS(cyclic(CATA_LOWER, a.entries, a.desc, c.entries, c.desc, 1, pc, 7), CATA_ERR_ARGUMENT);
    CHECK_MENTIONS("grid_order: must be CATA_ROW_MAJOR");
    CHECK_STATUS(cyclic(7, a.entries, a.desc, c.entries, c.desc, GOOD_GRID), CATA_ERR_ARGUMENT);

    /* On one of them. */
    int32_t wrong[9];
    memcpy(wrong, a.desc, sizeof wrong);
    wrong[4] = rank == last ? 0 : wrong[4];
    CHECK_STATUS(cyclic(CATA_LOWER, a.entries, wrong, c.entries, c.desc, GOOD_GRID),
                 seen(last, CATA_ERR_ARGUMENT));
    CHECK_MENTIONS("desc_a: MB_ must be at least 1, is 0");
    memcpy(wrong, c.desc, sizeof wrong);
    wrong[8] = rank == last ? c.rows - 1 : wrong[8];
    CHECK_STATUS(cyclic(CATA_LOWER, a.entries, a.desc, c.entries, wrong, GOOD_GRID),
                 seen(last, CATA_ERR_ARGUMENT));
    CHECK_MENTIONS("desc_c: LLD_ must be at least");
    CHECK_STATUS(cyclic(CATA_LOWER, a.entries, rank == last ? NULL : a.desc, c.entries, c.desc, GOOD_GRID),
                 seen(last, CATA_ERR_NULL));
    CHECK_MENTIONS("desc_a: must not be NULL");
    if (c.cols > 0 && last < N / 2) {
        CHECK_STATUS(cyclic(CATA_LOWER, a.entries, a.desc, rank == last ? NULL : c.entries, c.desc,
                            GOOD_GRID),
                     seen(last, CATA_ERR_NULL));
        CHECK_MENTIONS("c: must not be NULL");
    }
    if (size > 1) {
        memcpy(wrong, c.desc, sizeof wrong);
        wrong[4] += rank == last;
        CHECK_STATUS(cyclic(CATA_LOWER, a.entries, a.desc, c.entries, wrong, GOOD_GRID), CATA_ERR_RANK);
        CHECK_MENTIONS("MB_ of C is 5, where rank 0 has 4");
        CHECK_STATUS(cyclic(rank == last ? CATA_UPPER : CATA_LOWER, a.entries, a.desc, c.entries, c.desc,
                            GOOD_GRID),
                     CATA_ERR_RANK);
        CHECK_MENTIONS("the triangle is");
    }
    CHECK(c.cols == 0 || c.entries[0] == old);
    discard(&a);
    discard(&c);
#undef GOOD_GRID
}

/* The path of P nodes, whose eigenvalues are 2 - 2 cos(pi i / P); each rank makes its rows. */
enum { P = 90, PAIRS = 5, WIDTH = 4 };

static size_t path_starts[P + 1], path_columns[3 * P];
static double path_entries[3 * P];

static size_t make_path(void)
{
    size_t first = (size_t)(P * rank / size), end = (size_t)(P * (rank + 1) / size), at = 0;
    for (size_t i = first; i < end; i++) {
        for (size_t j = i == 0 ? 0 : i - 1; j <= i + 1 && j < P; j++) {
            path_columns[at] = j;
            path_entries[at++] = i != j ? -1 : i == 0 || i == P - 1 ? 1 : 2;
        }
        path_starts[i - first + 1] = at;
    }
    return end - first;
}

static int32_t cancel(double fraction, void *user)
{
    (void)fraction;
    (void)user;
    return 1;
}

/* The largest |Q^T Q - I| of columns whose rows are spread. */
static double defect(const double *q, size_t own, size_t count)
{
    double worst = 0;
    for (size_t j = 0; j < count; j++) {
        for (size_t k = 0; k <= j; k++) {
            double sum = 0, all = 0;
            for (size_t i = 0; i < own; i++) {
                sum += q[j * own + i] * q[k * own + i];
            }
            MPI_Allreduce(&sum, &all, 1, MPI_DOUBLE, MPI_SUM, MPI_COMM_WORLD);
            worst = all - (j == k) > worst ? all - (j == k) : worst;
            worst = (j == k) - all > worst ? (j == k) - all : worst;
        }
    }
    return worst;
}

static void test_eigs(void)
{
    static double vectors[PAIRS * P], again[PAIRS * P], masses[P];
    double values[PAIRS], residuals[PAIRS];
    const size_t own = make_path(), ldv = own ? own : 1;
    int last = size - 1;
    for (size_t threads = 1; threads <= 4; threads *= 2) {
        const cata_eigs_params params = {.struct_size = sizeof params, .threads = threads};
        CHECK_STATUS(cata_world_eigs(world, own, P, path_starts, path_columns, path_entries, NULL, PAIRS, values,
                                     vectors, ldv, residuals, &params),
                     CATA_OK);
        CHECK(threads == 1 || memcmp(vectors, again, PAIRS * own * sizeof(double)) == 0);
        memcpy(again, vectors, sizeof vectors);
    }
    for (int j = 0; j < PAIRS; j++) {
        CHECK(fabs(values[j] - 2 + 2 * cos(acos(-1) * j / P)) < 1e-10 && residuals[j] < 1e-9);
    }
    CHECK(defect(vectors, own, PAIRS) < 1e-11);
    for (size_t i = 0; i < own; i++) {
        masses[i] = 2;
    }
    CHECK_STATUS(cata_world_eigs(world, own, P, path_starts, path_columns, path_entries, masses, 2, values,
                                 vectors, ldv, NULL, NULL),
                 CATA_OK);
    CHECK(fabs(values[1] - 1 + cos(acos(-1) / P)) < 1e-10);

    values[0] = 5;
    CHECK_STATUS(cata_world_eigs(world, own, P, rank == last ? NULL : path_starts, path_columns, path_entries,
                                 NULL, 1, values, vectors, ldv, NULL, NULL),
                 seen(last, CATA_ERR_NULL));
    CHECK_MENTIONS("row_starts: must not be NULL");
    CHECK_STATUS(cata_world_eigs(world, own, P, path_starts, path_columns, path_entries, NULL, 1, values, vectors,
                                 rank == last ? own - 1 : ldv, NULL, NULL),
                 seen(last, CATA_ERR_SHAPE));
    CHECK_MENTIONS("ldv");
    CHECK_STATUS(cata_world_eigs(world, own, P, path_starts, path_columns, path_entries, NULL, 1, values,
                                 NULL, ldv, NULL, NULL),
                 CATA_ERR_NULL);
    if (size > 1) {
        CHECK_STATUS(cata_world_eigs(world, own, P, path_starts, path_columns, path_entries, NULL,
                                     rank == last ? 2 : 1, values, vectors, ldv, NULL, NULL),
                     CATA_ERR_RANK);
        CHECK_MENTIONS("k is 2, where rank 0 has 1");
    }
    cata_eigs_params params = {.struct_size = sizeof params, .progress = rank == last ? cancel : NULL};
    CHECK_STATUS(cata_world_eigs(world, own, P, path_starts, path_columns, path_entries, NULL, 1, values, vectors,
                                 ldv, NULL, &params),
                 seen(last, CATA_ERR_CANCELLED));
    CHECK_STATUS(cata_world_eigs(NULL, own, P, path_starts, path_columns, path_entries, NULL, 1, values, vectors,
                                 ldv, NULL, NULL),
                 CATA_ERR_NULL);
    CHECK_MESSAGE("world: must not be NULL");
    CHECK(values[0] == 5);
}

/* Columns 1, i, i^2 and 3 i - 2, by Gram-Schmidt; the first three by Cholesky QR. */
static void test_ortho(void)
{
    static double a[WIDTH * P], q[WIDTH * P], first[WIDTH * P];
    const size_t own = make_path(), lda = own ? own : 1;
    size_t kept[WIDTH], independent = 0;
    double r[WIDTH * WIDTH];
    int last = size - 1;
    for (size_t i = 0; i < own; i++) {
        const double x = (double)(P * rank / size + (int)i) / P;
        a[i] = 1;
        a[own + i] = x;
        a[2 * own + i] = x * x;
        a[3 * own + i] = 3 * x - 2;
    }
    for (size_t threads = 1; threads <= 4; threads *= 2) {
        const cata_ortho_params params = {.struct_size = sizeof params, .threads = threads};
        memcpy(q, a, sizeof a);
        CHECK_STATUS(cata_world_gram_schmidt(world, CATA_COL_MAJOR, own, WIDTH, q, lda, NULL, r, WIDTH, kept,
                                             &independent, &params),
                     CATA_OK);
        CHECK(independent == 3 && kept[0] == 0 && kept[1] == 1 && kept[2] == 2);
        CHECK(threads == 1 || memcmp(q, first, 3 * own * sizeof(double)) == 0);
        memcpy(first, q, sizeof q);
    }
    CHECK(defect(q, own, 3) < 1e-13);
    for (size_t i = 0; i < own; i++) {
        for (size_t j = 0; j < WIDTH; j++) {
            double sum = -a[j * own + i];
            for (size_t k = 0; k < WIDTH; k++) {
                sum += r[k + j * WIDTH] * (k < 3 ? q[k * own + i] : 1);
            }
            CHECK(fabs(sum) < 1e-13);
        }
    }
    memcpy(q, a, sizeof a);
    CHECK_STATUS(cata_world_cholesky_qr(world, CATA_COL_MAJOR, own, 3, q, lda, NULL, r, 3, NULL), CATA_OK);
    for (size_t i = 0; i < 3 * own; i++) {
        CHECK(fabs(q[i] - first[i]) < 1e-12);
    }
    memcpy(q, a, sizeof a);
    CHECK_STATUS(cata_world_cholesky_qr(world, CATA_COL_MAJOR, own, WIDTH, q, lda, NULL, r, WIDTH, NULL),
                 CATA_ERR_ARGUMENT);
    CHECK_MENTIONS("A: column 3 depends");

    independent = 77;
    memcpy(q, a, sizeof a);
    CHECK_STATUS(cata_world_gram_schmidt(world, CATA_COL_MAJOR, own, WIDTH, q, lda, NULL, r, WIDTH, kept,
                                         rank == last ? NULL : &independent, NULL),
                 seen(last, CATA_ERR_NULL));
    CHECK_MENTIONS("rank: must not be NULL");
    cata_ortho_params params = {.struct_size = sizeof params};
    params.method = rank == last ? CATA_ORTHO_RANK_REVEALING : 0;
    CHECK_STATUS(cata_world_gram_schmidt(world, CATA_COL_MAJOR, own, WIDTH, q, lda, NULL, r, WIDTH, kept,
                                         &independent, &params),
                 seen(last, CATA_ERR_UNSUPPORTED));
    CHECK_MENTIONS("params.method");
    CHECK_STATUS(cata_world_cholesky_qr(world, rank == last ? 0 : CATA_COL_MAJOR, own, 3, q, lda, NULL, r, 3, NULL),
                 seen(last, CATA_ERR_ARGUMENT));
    CHECK(memcmp(q, a, sizeof a) == 0);
    params.method = 0;
    params.progress = rank == last ? cancel : NULL;
    CHECK_STATUS(cata_world_gram_schmidt(world, CATA_COL_MAJOR, own, WIDTH, q, lda, NULL, r, WIDTH, kept,
                                         &independent, &params),
                 seen(last, CATA_ERR_CANCELLED));
    CHECK_STATUS(cata_world_cholesky_qr(world, CATA_COL_MAJOR, own, 3, q, lda, NULL, r, 3, &params),
                 seen(last, CATA_ERR_CANCELLED));
    CHECK(independent == 77);
}

static void test_without_mpi(const char *why)
{
    cata_world *none = NULL;
    CHECK_STATUS(cata_world_from_comm(MPI_COMM_WORLD, &none), CATA_ERR_ARGUMENT);
    CHECK_MESSAGE(why);
    CHECK_STATUS(cata_world_new(0, &none), CATA_ERR_ARGUMENT);
    CHECK(none == NULL);
}

int main(int argc, char **argv)
{
    cata_world *late = NULL;
    int provided = 0;
    test_without_mpi("communicator: MPI is not initialized");
    MPI_Init_thread(&argc, &argv, MPI_THREAD_FUNNELED, &provided);
    MPI_Comm_rank(MPI_COMM_WORLD, &rank);
    MPI_Comm_size(MPI_COMM_WORLD, &size);
    CHECK_STATUS(cata_world_from_comm(MPI_COMM_WORLD, &world), CATA_OK);
    CHECK_STATUS(cata_world_from_comm(MPI_COMM_WORLD, &late), CATA_OK);
    test_world();
    test_worlds();
    test_rows();
    test_columns();
    test_root();
    test_errors();
    test_cyclic();
    test_cyclic_errors();
    test_eigs();
    test_ortho();
    cata_world_free(world);
    MPI_Finalize();
    /* Too late, but harmless. */
    cata_world_free(late);
    test_without_mpi("communicator: MPI is finalized already");
    return report("mpi");
}
