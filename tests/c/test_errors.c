/* What a caller can get wrong: the status, the message, and C untouched. */

#include "internal.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "check.h"

enum { M = 4, N = 3 };

static double a[M * N], c[N * N], untouched[N * N];

#define ROW CATA_ROW_MAJOR
#define COL CATA_COL_MAJOR

static cata_status ata(int32_t layout, int32_t uplo, const double *from, size_t lda, double *to,
                       size_t ldc, const cata_ata_params *params)
{
    return cata_ata_f64(layout, uplo, M, N, 1.0, from, lda, 0.0, to, ldc, params);
}

#define CHECK_MESSAGE(text) CHECK(strcmp(cata_last_error_message(), text) == 0)
#define CHECK_MENTIONS(text) CHECK(strstr(cata_last_error_message(), text) != NULL)
#define CHECK_UNTOUCHED() CHECK(memcmp(c, untouched, sizeof c) == 0)

static void test_no_message_yet(void)
{
    CHECK_MESSAGE("");
}

static void test_null(void)
{
    CHECK_STATUS(ata(ROW, CATA_BOTH, NULL, N, c, N, NULL), CATA_ERR_NULL);
    CHECK_MESSAGE("a: must not be NULL");
    CHECK_STATUS(ata(ROW, CATA_BOTH, a, N, NULL, N, NULL), CATA_ERR_NULL);
    CHECK_MESSAGE("c: must not be NULL");
    CHECK_STATUS(cata_ata_f64(ROW, CATA_BOTH, 0, 0, 1.0, NULL, 1, 0.0, NULL, 1, NULL), CATA_OK);
    CHECK_STATUS(cata_atb_f64(ROW, M, N, 1, 1.0, a, N, NULL, 1, 0.0, c, N, NULL), CATA_ERR_NULL);
    CHECK_MESSAGE("b: must not be NULL");
    CHECK_STATUS(cata_ata_scratch_len_f64(M, N, NULL, NULL), CATA_ERR_NULL);
    CHECK_MESSAGE("len: must not be NULL");
    CHECK_STATUS(cata_ata_params_init(NULL, sizeof(cata_ata_params)), CATA_ERR_NULL);
    CHECK_STATUS(cata_verify_f64(ROW, CATA_BOTH, M, N, 1.0, a, N, c, N, 1, 1, NULL, NULL, NULL),
                 CATA_ERR_NULL);
    CHECK_MESSAGE("passed: must not be NULL");
    CHECK_STATUS(cata_ata_rows_f64(ROW, CATA_BOTH, M, N, 1.0, a, N, NULL, CATA_CENTER_GIVEN, NULL,
                                   0.0, c, N, NULL),
                 CATA_ERR_NULL);
    CHECK_MESSAGE("center: must not be NULL");
    CHECK_UNTOUCHED();
}

/* No output may overlap another one or an input; lines between those of another matrix may. */
static void test_overlaps(void)
{
    double square[N * N], shared[M * (N + N)] = {0};
    memcpy(square, untouched, sizeof square);
    CHECK_STATUS(cata_ata_f64(ROW, CATA_BOTH, N, N, 1.0, square, N, 0.0, square, N, NULL),
                 CATA_ERR_ARGUMENT);
    CHECK_MESSAGE("c: must not overlap a");
    CHECK_STATUS(cata_gram_orthogonality(ROW, M, N, a, N, c, c, NULL), CATA_ERR_ARGUMENT);
    CHECK_MESSAGE("frobenius: must not overlap max");
    CHECK_STATUS(cata_svd(ROW, M, N, a, N, square + 2, square, N, NULL), CATA_ERR_ARGUMENT);
    CHECK_MESSAGE("v: must not overlap values");
    CHECK(memcmp(square, untouched, sizeof square) == 0);
    CHECK_UNTOUCHED();
    for (int i = 0; i < M; i++) {
        shared[i * (N + N)] = i + 1;
    }
    CHECK_STATUS(
        cata_ata_f64(ROW, CATA_BOTH, M, N, 1.0, shared, N + N, 0.0, shared + N, N + N, NULL),
        CATA_OK);
    CHECK(shared[0] == 1 && shared[N] == 30 && shared[N + 1] == 0);
    CHECK_STATUS(
        cata_ata_f64(ROW, CATA_BOTH, M, N, 1.0, shared, N + N, 0.0, shared + N - 1, N + N, NULL),
        CATA_ERR_ARGUMENT);
    CHECK_STATUS(cata_atb_f64(ROW, M, N, N, 1.0, a, N, a, N, 0.0, square, N, NULL), CATA_OK);
    /* A struct is an argument, too. */
    cata_gram_params params = {.struct_size = sizeof params};
    CHECK_STATUS(cata_gram_orthogonality(ROW, M, N, a, N, (double *)(void *)&params.threads, NULL,
                                         &params),
                 CATA_ERR_ARGUMENT);
    CHECK_MESSAGE("max: must not overlap params");
    CHECK(params.threads == 0);
}

static void test_batches(void)
{
    const double *from[] = {a, a + 1};
    double *to[] = {c, c + 1};
    CHECK_STATUS(cata_ata_batched_f64(ROW, CATA_BOTH, 2, 2, 2, 1, a, 2, 0, 0, c, 2, 3, NULL),
                 CATA_ERR_SHAPE);
    CHECK_MESSAGE("stride_c: must be at least 4, is 3");
    CHECK_STATUS(
        cata_ata_batched_f64(ROW, CATA_BOTH, 2, 2, 1, 1, a, 1, SIZE_MAX, 0, c, 1, 1, NULL),
        CATA_ERR_SHAPE);
    CHECK_MENTIONS("stride_a: ");
    CHECK_STATUS(cata_ata_batched_f64(ROW, CATA_BOTH, 2, 2, 1, 1, c, 1, 1, 0, c + 2, 1, 1, NULL),
                 CATA_ERR_ARGUMENT);
    CHECK_MESSAGE("c: must not overlap a");
    CHECK_STATUS(cata_ata_batched_f64(ROW, CATA_BOTH, 0, 2, 1, 1, NULL, 1, 1, 0, NULL, 1, 1, NULL),
                 CATA_OK);
    from[1] = NULL;
    CHECK_STATUS(
        cata_ata_batched_pointers_f64(ROW, CATA_BOTH, 2, 2, 1, 1, from, 1, 0, to, 1, NULL),
        CATA_ERR_NULL);
    CHECK_MESSAGE("a[1]: must not be NULL");
    from[1] = a;
    to[1] = c;
    CHECK_STATUS(
        cata_ata_batched_pointers_f64(ROW, CATA_BOTH, 2, 2, 1, 1, from, 1, 0, to, 1, NULL),
        CATA_ERR_ARGUMENT);
    CHECK_MESSAGE("c[1]: must not overlap c[0]");
    to[0] = (double *)(void *)from;
    CHECK_STATUS(
        cata_ata_batched_pointers_f64(ROW, CATA_BOTH, 1, 2, 1, 1, from, 1, 0, to, 1, NULL),
        CATA_ERR_ARGUMENT);
    CHECK_MESSAGE("c[0]: must not overlap a");
    CHECK(from[0] == a);
    CHECK_UNTOUCHED();
}

static void test_enums(void)
{
    CHECK_STATUS(ata(0, CATA_BOTH, a, N, c, N, NULL), CATA_ERR_ARGUMENT);
    CHECK_MENTIONS("layout: must be CATA_ROW_MAJOR (101) or CATA_COL_MAJOR (102), is 0");
    CHECK_STATUS(ata(ROW, 124, a, N, c, N, NULL), CATA_ERR_ARGUMENT);
    CHECK_MENTIONS("uplo");
    CHECK_STATUS(ata(ROW, -1, a, N, c, N, NULL), CATA_ERR_ARGUMENT);
    CHECK_STATUS(cata_ata_rows_f64(ROW, CATA_BOTH, M, N, 1.0, a, N, NULL, 3, NULL, 0.0, c, N, NULL),
                 CATA_ERR_ARGUMENT);
    CHECK_MENTIONS("centering");
    CHECK_UNTOUCHED();
}

static void test_shapes(void)
{
    CHECK_STATUS(ata(ROW, CATA_BOTH, a, N - 1, c, N, NULL), CATA_ERR_SHAPE);
    CHECK_MESSAGE("lda: must be at least 3 (columns of a), is 2");
    CHECK_STATUS(ata(COL, CATA_BOTH, a, M - 1, c, N, NULL), CATA_ERR_SHAPE);
    CHECK_MESSAGE("lda: must be at least 4 (rows of a), is 3");
    CHECK_STATUS(ata(ROW, CATA_BOTH, a, N, c, N - 1, NULL), CATA_ERR_SHAPE);
    CHECK_MENTIONS("ldc");
    CHECK_STATUS(ata(ROW, CATA_BOTH, a, 0, c, N, NULL), CATA_ERR_SHAPE);
    CHECK_STATUS(ata(ROW, CATA_BOTH, a, SIZE_MAX / 2, c, N, NULL), CATA_ERR_SHAPE);
    CHECK_MENTIONS("exceeds the address space");
    CHECK_STATUS(cata_ata_f64(ROW, CATA_BOTH, SIZE_MAX / 4, SIZE_MAX / 4, 1.0, a, SIZE_MAX / 4, 0.0,
                              c, SIZE_MAX / 4, NULL),
                 CATA_ERR_SHAPE);
    /* An array that would not end before the address space does. */
    CHECK_STATUS(ata(ROW, CATA_BOTH, (double *)(UINTPTR_MAX - 7), N, c, N, NULL), CATA_ERR_SHAPE);
    CHECK_MENTIONS("a: its 12 elements exceed the address space");
    /* Lines of nothing have no stride. */
    CHECK_STATUS(cata_ata_f64(ROW, CATA_BOTH, M, 0, 1.0, NULL, SIZE_MAX, 0.0, NULL, 1, NULL),
                 CATA_OK);
    size_t len = 77;
    CHECK_STATUS(cata_ata_scratch_len_f64(1, SIZE_MAX / 64, NULL, &len), CATA_ERR_SHAPE);
    CHECK(len == 77);
    /* Rows beyond counting, but nothing in them. */
    CHECK_STATUS(cata_ata_rows_f64(ROW, CATA_BOTH, SIZE_MAX / 32, 0, 1.0, NULL, 1, NULL,
                                   CATA_CENTER_NONE, NULL, 0.0, NULL, 1, NULL),
                 CATA_OK);
    CHECK_UNTOUCHED();
}

static void test_scratch(void)
{
    enum { BIG = 64 };
    cata_ata_params params = {
        .struct_size = sizeof params, .threads = 1, .leaf = 8, .scheme = CATA_SCHEME_RXTX};
    static double big[BIG * BIG], to[BIG * BIG];
    size_t len = 0;
    CHECK_STATUS(cata_ata_scratch_len_f64(BIG, BIG, &params, &len), CATA_OK);
    CHECK(len > 0);
    double *scratch = malloc(len * sizeof *scratch);
    to[0] = 5.0;
    CHECK_STATUS(cata_ata_with_scratch_f64(ROW, CATA_LOWER, BIG, BIG, 1.0, big, BIG, 0.0, to, BIG,
                                           scratch, len - 1, &params),
                 CATA_ERR_SHAPE);
    CHECK_MENTIONS("scratch");
    CHECK(to[0] == 5.0);
    CHECK_STATUS(cata_ata_with_scratch_f64(ROW, CATA_LOWER, BIG, BIG, 1.0, big, BIG, 0.0, to, BIG,
                                           NULL, len, &params),
                 CATA_ERR_NULL);
    CHECK_STATUS(cata_ata_with_scratch_f64(ROW, CATA_LOWER, BIG, BIG, 1.0, big, BIG, 0.0, to, BIG,
                                           scratch, len, &params),
                 CATA_OK);
    CHECK(to[0] == 0.0);
    free(scratch);
}

static void test_not_finite(void)
{
    double weights[M] = {1.0, 1.0, INFINITY, 1.0}, balanced[M] = {1.0, -1.0, 1.0, -1.0};
    double center[N] = {0.0, NAN, 0.0};
    CHECK_STATUS(cata_ata_rows_f64(ROW, CATA_BOTH, M, N, 1.0, a, N, weights, CATA_CENTER_NONE, NULL,
                                   0.0, c, N, NULL),
                 CATA_ERR_NON_FINITE);
    CHECK_MENTIONS("weights: not finite at row 2");
    CHECK_STATUS(cata_ata_rows_f64(ROW, CATA_BOTH, M, N, 1.0, a, N, NULL, CATA_CENTER_GIVEN, center,
                                   0.0, c, N, NULL),
                 CATA_ERR_NON_FINITE);
    CHECK_STATUS(cata_ata_rows_f64(ROW, CATA_BOTH, M, N, 1.0, a, N, balanced, CATA_CENTER_MEAN, NULL,
                                   0.0, c, N, NULL),
                 CATA_ERR_ARGUMENT);
    CHECK_MENTIONS("sum to zero");
    CHECK_UNTOUCHED();
}

static void test_params(void)
{
    /* A caller compiled against a later version, whose struct has grown. */
    struct {
        cata_ata_params known;
        uint64_t later[3];
    } future;
    CHECK_STATUS(cata_ata_params_init(&future.known, sizeof future), CATA_OK);
    CHECK(future.known.struct_size == sizeof future && future.later[2] == 0);
    CHECK_STATUS(ata(ROW, CATA_BOTH, a, N, c, N, &future.known), CATA_OK);
    memcpy(c, untouched, sizeof c);
    future.later[1] = 1;
    CHECK_STATUS(ata(ROW, CATA_BOTH, a, N, c, N, &future.known), CATA_ERR_UNSUPPORTED);

    /* Of a struct that is too short no more than its size is read. */
    size_t *lone = malloc(sizeof *lone);
    *lone = sizeof *lone;
    CHECK_STATUS(ata(ROW, CATA_BOTH, a, N, c, N, (const cata_ata_params *)lone), CATA_ERR_ARGUMENT);
    free(lone);

    cata_ata_params params = {.struct_size = sizeof params};
    cata_ata_params initialized;
    CHECK_STATUS(cata_ata_params_init(&initialized, sizeof initialized), CATA_OK);
    CHECK(memcmp(&params, &initialized, sizeof params) == 0);
    params.struct_size = sizeof params - 8;
    CHECK_STATUS(ata(ROW, CATA_BOTH, a, N, c, N, &params), CATA_ERR_ARGUMENT);
    CHECK_MENTIONS("struct_size");
    params.struct_size = 0;
    CHECK_STATUS(ata(ROW, CATA_BOTH, a, N, c, N, &params), CATA_ERR_ARGUMENT);
    params.struct_size = SIZE_MAX;
    CHECK_STATUS(ata(ROW, CATA_BOTH, a, N, c, N, &params), CATA_ERR_ARGUMENT);
    CHECK_STATUS(cata_ata_params_init(&params, 8), CATA_ERR_ARGUMENT);

    params = initialized;
    params.scheme = 9;
    CHECK_STATUS(ata(ROW, CATA_BOTH, a, N, c, N, &params), CATA_ERR_ARGUMENT);
    CHECK_MENTIONS("scheme");
    params = initialized;
    params.tasks = SIZE_MAX;
    CHECK_STATUS(ata(ROW, CATA_BOTH, a, N, c, N, &params), CATA_ERR_ARGUMENT);
    params = initialized;
    params.leaf = SIZE_MAX;
    CHECK_STATUS(ata(ROW, CATA_BOTH, a, N, c, N, &params), CATA_ERR_ARGUMENT);
    params = initialized;
    params.reproducible = 2;
    CHECK_STATUS(ata(ROW, CATA_BOTH, a, N, c, N, &params), CATA_ERR_ARGUMENT);
    CHECK_MESSAGE("params.reproducible: must be 0 or 1, is 2");
    params.reproducible = -1;
    CHECK_STATUS(ata(ROW, CATA_BOTH, a, N, c, N, &params), CATA_ERR_ARGUMENT);
    CHECK_MENTIONS("params.reproducible");
    params = initialized;
    params.pin = 2;
    CHECK_STATUS(ata(ROW, CATA_BOTH, a, N, c, N, &params), CATA_ERR_ARGUMENT);
    CHECK_MESSAGE("params.pin: must be 0 or 1, is 2");
    params = initialized;
    params.reproducible = 1;
    for (params.scheme = CATA_SCHEME_CLASSICAL; params.scheme < CATA_SCHEME_EXACT; params.scheme++) {
        CHECK_STATUS(ata(ROW, CATA_BOTH, a, N, c, N, &params), CATA_ERR_ARGUMENT);
        CHECK_MENTIONS("scheme");
        CHECK_MENTIONS("reproducible");
    }
    static const double factors[] = {0.5, -0.5, -2.0, NAN, -INFINITY};
    for (size_t i = 0; i < sizeof factors / sizeof *factors; i++) {
        params = initialized;
        params.error_factor = factors[i];
        CHECK_STATUS(ata(ROW, CATA_BOTH, a, N, c, N, &params), CATA_ERR_ARGUMENT);
        CHECK_MENTIONS("params.error_factor");
    }
    CHECK_UNTOUCHED();
}

struct progress {
    int calls;
    int stop_at;
    double last;
};

static int32_t count(double fraction, void *user)
{
    struct progress *progress = user;
    progress->calls++;
    CHECK(fraction >= progress->last && fraction <= 1.0);
    progress->last = fraction;
    return progress->calls == progress->stop_at;
}

static void test_progress(void)
{
    // Several pieces, also with a large cache, in which smaller products are done in one.
    enum { BIG = 800 };
    static double big[BIG * BIG], to[BIG * BIG];
    struct progress progress = {0, 0, 0.0};
    cata_ata_params params = {.struct_size = sizeof params};
    params.threads = 1;
    params.tasks = 16;
    params.progress = count;
    params.progress_user = &progress;
    CHECK_STATUS(
        cata_ata_f64(ROW, CATA_LOWER, BIG, BIG, 1.0, big, BIG, 0.0, to, BIG, &params), CATA_OK);
    CHECK(progress.calls > 2 && fabs(progress.last - 1.0) < 1e-9);
    progress.calls = 0;
    progress.last = 0.0;
    progress.stop_at = 2;
    CHECK_STATUS(cata_ata_f64(ROW, CATA_LOWER, BIG, BIG, 1.0, big, BIG, 0.0, to, BIG, &params),
                 CATA_ERR_CANCELLED);
    CHECK(progress.calls == 2);
    CHECK_MESSAGE("cancelled");
}

static void test_backend(void)
{
    cata_backend *backend = (cata_backend *)a; /* anything, to see that it is left alone */
    CHECK_STATUS(cata_backend_load("/no/such/library.so", &backend), CATA_ERR_BACKEND);
    CHECK_MENTIONS("library.so");
    CHECK_STATUS(cata_backend_load("libm.so.6", &backend), CATA_ERR_BACKEND);
    CHECK_MENTIONS("cblas_dgemm");
    CHECK_STATUS(cata_backend_load("", &backend), CATA_ERR_ARGUMENT);
    CHECK_STATUS(cata_backend_load(NULL, &backend), CATA_ERR_NULL);
    CHECK_STATUS(cata_backend_load("libm.so.6", NULL), CATA_ERR_NULL);
    CHECK(backend == (cata_backend *)a);
    cata_backend_free(NULL);
    CHECK(strcmp(cata_backend_name(NULL), "") == 0);
    backend = NULL;
    if (cata_capabilities() & CATA_CAP_OPENBLAS) {
        CHECK_STATUS(cata_backend_openblas(&backend), CATA_OK);
        CHECK(strcmp(cata_backend_name(backend), "openblas") == 0);
        cata_backend_free(backend);
    } else {
        CHECK_STATUS(cata_backend_openblas(&backend), CATA_ERR_UNSUPPORTED);
        CHECK(backend == NULL);
    }
}

/* With a CBLAS library where there is one: the same answer, within rounding. */
static void test_loaded_backend(const char *path)
{
    cata_backend *backend = NULL;
    if (cata_backend_load(path, &backend) != CATA_OK) {
        printf("errors: no %s, its test is left out\n", path);
        return;
    }
    double from[6] = {1, 2, 3, 4, 5, 6}, to[4] = {0};
    cata_ata_params params = {.struct_size = sizeof params};
    params.backend = backend;
    params.threads = 1;
    CHECK_STATUS(cata_ata_f64(ROW, CATA_BOTH, 3, 2, 1.0, from, 2, 0.0, to, 2, &params), CATA_OK);
    CHECK(to[0] == 35.0 && to[1] == 44.0 && to[2] == 44.0 && to[3] == 56.0);
    CHECK(strcmp(cata_backend_name(backend), path) == 0);
    cata_backend_free(backend);
}

/* Without the feature; with it see test_mpi.c. */
static void test_without_mpi(void)
{
    if (cata_capabilities() & CATA_CAP_MPI) {
        return;
    }
    cata_world *world = NULL;
    cata_symmetric *product = NULL;
    size_t n = 5;
    CHECK_STATUS(cata_world_new(0, &world), CATA_ERR_UNSUPPORTED);
    CHECK_MESSAGE("built without the feature mpi (CMake: CATAMARAN_MPI=ON)");
    CHECK_STATUS(cata_world_rank(world, &n), CATA_ERR_UNSUPPORTED);
    CHECK_STATUS(cata_world_ata_rows_f64(world, ROW, M, N, 1.0, a, N, NULL, &product),
                 CATA_ERR_UNSUPPORTED);
    CHECK(world == NULL && product == NULL && n == 5);
    cata_world_free(NULL);
    cata_symmetric_free(NULL);
}

static void test_verify(void)
{
    int32_t passed = 5;
    const double before = a[N + 1];
    a[N + 1] = INFINITY;
    CHECK_STATUS(cata_verify_f64(ROW, CATA_BOTH, M, N, 1.0, a, N, c, N, 1, 1, &passed, NULL, NULL),
                 CATA_ERR_NON_FINITE);
    CHECK_MESSAGE("A: not finite at row 1, column 1");
    a[N + 1] = before;
    CHECK_STATUS(cata_verify_f64(ROW, CATA_BOTH, M, N, 1.0, a, N, c, N, 0, 1, &passed, NULL, NULL),
                 CATA_ERR_ARGUMENT);
    CHECK_STATUS(
        cata_verify_f64(ROW, CATA_BOTH, M, N, 1.0, a, N, c, N, 1001, 1, &passed, NULL, NULL),
        CATA_ERR_ARGUMENT);
    CHECK(passed == 5);
}

#ifdef WITH_INTERNAL
static void test_panic(void)
{
    CHECK_STATUS(cata_internal_panic(0), CATA_ERR_PANIC);
    CHECK_MENTIONS("forced by cata_internal_panic");
    CHECK_STATUS(cata_internal_panic(1), CATA_ERR_PANIC);
    CHECK_MENTIONS("on a worker");
    /* And it goes on working. */
    double one = 3.0, square = 0.0;
    CHECK_STATUS(cata_ata_f64(ROW, CATA_BOTH, 1, 1, 1.0, &one, 1, 0.0, &square, 1, NULL), CATA_OK);
    CHECK(square == 9.0);
    /* A success leaves the message alone. */
    CHECK_MENTIONS("on a worker");
}
#endif

static void test_version(void)
{
    int32_t major = -1, minor = -1, patch = -1;
    char text[64];
    CHECK_STATUS(cata_version(&major, &minor, &patch), CATA_OK);
    CHECK(major == CATA_VERSION_MAJOR && minor == CATA_VERSION_MINOR);
    CHECK(patch == CATA_VERSION_PATCH);
    snprintf(text, sizeof text, "%d.%d.%d", (int)major, (int)minor, (int)patch);
    CHECK(strcmp(text, CATA_VERSION_STRING) == 0);
    CHECK(strcmp(text, cata_version_string()) == 0);
    CHECK(strcmp(text, EXPECTED_VERSION) == 0); /* CMake's, from Cargo.toml */
    CHECK_STATUS(cata_version(NULL, NULL, NULL), CATA_OK);
    major = minor = -1;
    CHECK_STATUS(cata_version(&major, &minor, &major), CATA_ERR_ARGUMENT);
    CHECK_MESSAGE("patch: must not overlap major");
    CHECK(major == -1 && minor == -1);
    CHECK((cata_capabilities() & CATA_CAP_CHAPTERS) != 0 && cata_capabilities() < 32);
}

static void test_status_names(void)
{
    CHECK(strcmp(cata_status_name(CATA_OK), "CATA_OK") == 0);
    CHECK(strcmp(cata_status_name(CATA_ERR_CANCELLED), "CATA_ERR_CANCELLED") == 0);
    CHECK(strcmp(cata_status_name(-77), "unknown status") == 0);
    /* The values are for ever. */
    CHECK(CATA_OK == 0 && CATA_ERR_NULL == 1 && CATA_ERR_SHAPE == 2 && CATA_ERR_ARGUMENT == 3);
    CHECK(CATA_ERR_NON_FINITE == 4 && CATA_ERR_NOT_CONVERGED == 5 && CATA_ERR_IO == 6);
    CHECK(CATA_ERR_OUT_OF_MEMORY == 7 && CATA_ERR_BACKEND == 8 && CATA_ERR_CANCELLED == 9);
    CHECK(CATA_ERR_UNSUPPORTED == 10 && CATA_ERR_PANIC == 11 && CATA_ERR_RANK == 12);
}

int main(int argc, char **argv)
{
    int quick = argc > 1 && strcmp(argv[1], "quick") == 0;
    for (int i = 0; i < N * N; i++) {
        c[i] = untouched[i] = 0.5 + i;
    }
    for (int i = 0; i < M * N; i++) {
        a[i] = i;
    }
    test_no_message_yet();
    test_null();
    test_overlaps();
    test_batches();
    test_enums();
    test_shapes();
    test_scratch();
    test_not_finite();
    test_params();
    test_progress();
    test_backend();
    test_without_mpi();
    test_verify();
    test_version();
    test_status_names();
    if (!quick) {
        test_loaded_backend("libopenblas.so.0"); /* starts threads of its own */
#ifdef WITH_INTERNAL
        test_panic();
#endif                            /* starts a worker */
    }
    return report("errors");
}
