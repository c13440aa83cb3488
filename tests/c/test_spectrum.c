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
    CHECK_STATUS(cata_eigs(3, row_starts, columns, entries, NULL, 3, values, vectors, 5,
                               residuals, NULL),
                 CATA_OK);
    CHECK(fabs(values[0]) < 1e-12 && fabs(values[1] - 1) < 1e-12 && fabs(values[2] - 3) < 1e-12);
    CHECK(fabs(fabs(vectors[0]) - sqrt(1.0 / 3)) < 1e-12);
    CHECK(vectors[3] == 7 && vectors[4] == 7);
    for (int i = 0; i < 3; i++) {
        CHECK(residuals[i] < 1e-12);
    }
    cata_eigs_params params;
    CHECK_STATUS(cata_eigs_params_init(&params, sizeof params), CATA_OK);
    params.has_shift = 1;
    params.shift = 2.9;
    params.threads = 2;
    const double masses[3] = {2, 2, 2};
    CHECK_STATUS(cata_eigs(3, row_starts, columns, entries, masses, 1, values, vectors, 3, NULL,
                               &params),
                 CATA_OK);
    CHECK(fabs(values[0] - 1.5) < 1e-12);
    CHECK_STATUS(cata_eigs(0, NULL, NULL, NULL, NULL, 0, NULL, NULL, 1, NULL, NULL), CATA_OK);
}

static int32_t cancel(double fraction, void *user)
{
    (void)fraction;
    ++*(int *)user;
    return 1;
}

static void test_spectrum_refusals(void)
{
    /* As many as the largest k says: others would overlap. */
    double values[4] = {5, 5, 5, 5}, vectors[12];
    CHECK_STATUS(cata_eigs(3, NULL, columns, entries, NULL, 1, values, vectors, 3, NULL, NULL),
                 CATA_ERR_NULL);
    CHECK_MENTIONS("row_starts: must not be NULL");
    CHECK_STATUS(cata_eigs(3, row_starts, columns, entries, NULL, 1, NULL, vectors, 3, NULL,
                               NULL),
                 CATA_ERR_NULL);
    CHECK_STATUS(cata_eigs(3, row_starts, columns, entries, NULL, 1, values, vectors, 2, NULL,
                               NULL),
                 CATA_ERR_SHAPE);
    CHECK_MENTIONS("ldv");
    CHECK_STATUS(cata_eigs(3, row_starts, columns, entries, NULL, 4, values, vectors, 3, NULL,
                               NULL),
                 CATA_ERR_ARGUMENT);
    CHECK_MENTIONS("k: 4");
    const size_t beyond[7] = {0, 1, 0, 1, 3, 1, 2};
    CHECK_STATUS(cata_eigs(3, row_starts, beyond, entries, NULL, 1, values, vectors, 3, NULL,
                               NULL),
                 CATA_ERR_ARGUMENT);
    const size_t backwards[4] = {0, 5, 2, 7};
    CHECK_STATUS(cata_eigs(3, backwards, columns, entries, NULL, 1, values, vectors, 3, NULL,
                               NULL),
                 CATA_ERR_ARGUMENT);
    const double negative[3] = {1, -1, 1};
    CHECK_STATUS(cata_eigs(3, row_starts, columns, entries, negative, 1, values, vectors, 3,
                               NULL, NULL),
                 CATA_ERR_ARGUMENT);
    CHECK_MENTIONS("mass: must be positive, but entry 1 is -1");
    int calls = 0;
    cata_eigs_params params = {.struct_size = sizeof params};
    params.progress = cancel;
    params.progress_user = &calls;
    CHECK_STATUS(cata_eigs(3, row_starts, columns, entries, NULL, 1, values, vectors, 3, NULL,
                               &params),
                 CATA_ERR_CANCELLED);
    CHECK(calls == 1);
    params.struct_size = 1;
    CHECK_STATUS(cata_eigs(3, row_starts, columns, entries, NULL, 1, values, vectors, 3, NULL,
                               &params),
                 CATA_ERR_ARGUMENT);
    CHECK_MENTIONS("sizeof(cata_eigs_params)");
    CHECK(values[0] == 5 && values[1] == 5 && values[2] == 5);
}

/* A square of four faces around one vertex, and a vertex in no face. */
static const double positions[6 * 3] = {0, 0, 0, 1, 0, 0, 1, 1, 0, 0, 1, 0, 0.5, 0.5, 0, 7, 7, 7};
static const uint32_t corners[4 * 3] = {0, 1, 4, 1, 2, 4, 2, 3, 4, 3, 0, 4};

static void test_mesh(void)
{
    double values[5], vectors[5 * 6], residuals[5], masses[6];
    CHECK_STATUS(cata_mesh_eigs(6, positions, 4, corners, 5, values, vectors, 6, residuals, masses,
                                NULL),
                 CATA_OK);
    double area = 0;
    for (int i = 0; i < 6; i++) {
        area += masses[i];
        CHECK(fabs(vectors[i] - (i < 5 ? vectors[0] : 0)) < 1e-12);
    }
    CHECK(fabs(area - 1) < 1e-15 && masses[5] == 0 && fabs(masses[4] - 1.0 / 3) < 1e-15);
    CHECK(fabs(values[0]) < 1e-12 && fabs(fabs(vectors[0]) - 1) < 1e-12);
    for (int i = 0; i < 5; i++) {
        CHECK(residuals[i] < 1e-12);
    }
    /* One vertex inside: its weights sum to 4, a third of the area is its mass. */
    cata_eigs_params params;
    CHECK_STATUS(cata_eigs_params_init(&params, sizeof params), CATA_OK);
    params.boundary = CATA_BOUNDARY_DIRICHLET;
    params.threads = 1;
    CHECK_STATUS(cata_mesh_eigs(6, positions, 4, corners, 1, values, vectors, 6, NULL, masses,
                                &params),
                 CATA_OK);
    CHECK(fabs(values[0] - 12) < 1e-12 && vectors[0] == 0 && masses[0] == 0 && masses[4] > 0.3);
    for (int kind = CATA_LAPLACIAN_COTANGENT; kind <= CATA_LAPLACIAN_TUFTED; kind++) {
        for (int mass = CATA_MASS_BARYCENTRIC; mass <= CATA_MASS_CONSISTENT; mass++) {
            cata_eigs_params any = {.struct_size = sizeof any, .laplacian = kind, .mass = mass};
            CHECK_STATUS(cata_mesh_eigs(6, positions, 4, corners, 2, values, vectors, 6, NULL, NULL,
                                        &any),
                         CATA_OK);
            CHECK(fabs(values[0]) < 1e-12 && values[1] > 1);
        }
    }
    CHECK_STATUS(cata_mesh_eigs(0, NULL, 0, NULL, 0, NULL, NULL, 1, NULL, NULL, NULL),
                 CATA_OK);
}

static void test_mesh_refusals(void)
{
    double values[6] = {5}, vectors[6 * 6], masses[6] = {5};
    const uint32_t beyond[3] = {0, 1, 6};
    CHECK_STATUS(cata_mesh_eigs(6, positions, 1, beyond, 1, values, vectors, 6, NULL, NULL, NULL),
                 CATA_ERR_MESH);
    CHECK_MENTIONS("face 0");
    CHECK_STATUS(cata_mesh_eigs(6, NULL, 4, corners, 1, values, vectors, 6, NULL, NULL, NULL),
                 CATA_ERR_NULL);
    CHECK_MENTIONS("vertices: must not be NULL");
    CHECK_STATUS(cata_mesh_eigs(6, positions, 4, corners, 6, values, vectors, 6, NULL, NULL, NULL),
                 CATA_ERR_ARGUMENT);
    CHECK_MENTIONS("k: 6");
    cata_eigs_params params = {.struct_size = sizeof params, .laplacian = 3};
    CHECK_STATUS(cata_mesh_eigs(6, positions, 4, corners, 1, values, vectors, 6, NULL, NULL, &params),
                 CATA_ERR_ARGUMENT);
    CHECK_MENTIONS("params.laplacian: must be a CATA_LAPLACIAN_* value, is 3");
    params.laplacian = 0;
    params.mass = CATA_MASS_CONSISTENT;
    CHECK_STATUS(cata_mesh_eigs(6, positions, 4, corners, 1, values, vectors, 6, NULL, masses,
                                &params),
                 CATA_ERR_ARGUMENT);
    CHECK_MENTIONS("masses");
    CHECK(values[0] == 5 && masses[0] == 5);
}

/* A path of P nodes, whose eigenvalues are 2 - 2 cos(pi i / P). */
enum { P = 400 };

static size_t path_starts[P + 1], path_columns[3 * P];
static double path_entries[3 * P], path_masses[P];

static double path_value(double i)
{
    return 2 - 2 * cos(acos(-1) * i / P);
}

static void make_path(void)
{
    size_t at = 0;
    for (size_t i = 0; i < P; i++) {
        path_masses[i] = 1;
        for (size_t j = i == 0 ? 0 : i - 1; j <= i + 1 && j < P; j++) {
            path_columns[at] = j;
            path_entries[at++] = i != j ? -1 : i == 0 || i == P - 1 ? 1 : 2;
        }
        path_starts[i + 1] = at;
    }
}

/* What slices brought, and how many. */
typedef struct {
    size_t slices, pairs, last;
    double values[P], vectors[P * P], worst;
} brought;

static int32_t take(size_t count, const double *eigenvalues, const double *eigenvectors, size_t ldv,
                    const double *residuals, void *user)
{
    brought *all = user;
    for (size_t j = 0; j < count; j++, all->pairs++) {
        all->values[all->pairs] = eigenvalues[j];
        all->worst = fmax(all->worst, residuals[j]);
        memcpy(all->vectors + all->pairs * all->last, eigenvectors + j * ldv, all->last * sizeof(double));
    }
    all->slices++;
    return 0;
}

static int32_t refuse(size_t count, const double *eigenvalues, const double *eigenvectors, size_t ldv,
                      const double *residuals, void *user)
{
    (void)eigenvalues, (void)eigenvectors, (void)ldv, (void)residuals;
    *(size_t *)user += count;
    return 1;
}

static cata_status sliced(size_t k, size_t memory, cata_eigs_slice slice, void *user, size_t threads,
                          cata_progress progress, int *calls)
{
    const cata_eigs_params params = {.struct_size = sizeof params, .threads = threads, .progress = progress,
                                     .progress_user = calls};
    return cata_eigs_sliced(P, path_starts, path_columns, path_entries, NULL, k, memory, slice, user, &params);
}

static void test_slices(int quick)
{
    enum { PAIRS = 120 };
    const size_t pairs = quick ? 8 : PAIRS, most = quick ? 0 : 4;
    static brought all, again;
    all.last = P;
    CHECK_STATUS(sliced(pairs, (size_t)1 << 30, take, &all, 1, NULL, NULL), CATA_OK);
    CHECK(all.slices == 1 && all.pairs == pairs && all.worst <= 1e-9);
    for (size_t j = 0; j < pairs; j++) {
        CHECK(fabs(all.values[j] - path_value((double)j)) < 1e-10);
    }
    /* The message says how little will do; in several slices the pairs are the same. */
    CHECK_STATUS(sliced(pairs, 1, take, &all, 1, NULL, NULL), CATA_ERR_ARGUMENT);
    CHECK_MENTIONS("memory: must be at least ");
    const size_t least = strtoull(strstr(cata_last_error_message(), "least ") + 6, NULL, 10);
    for (size_t threads = 1; threads <= most; threads *= 2) {
        memset(&again, 0, sizeof again);
        again.last = P;
        CHECK_STATUS(sliced(pairs, least + (1 << 16), take, &again, threads, NULL, NULL), CATA_OK);
        CHECK(again.slices > 1 && again.pairs == pairs && again.worst <= 1e-9);
        CHECK(threads == 1 || memcmp(again.vectors, all.vectors, sizeof all.vectors) == 0);
        for (size_t j = 0; j < pairs; j++) {
            CHECK(fabs(again.values[j] - path_value((double)j)) < 1e-10);
        }
        all = again;
    }
    size_t count = 0;
    int calls = 0;
    CHECK_STATUS(sliced(pairs, (size_t)1 << 30, refuse, &count, 1, NULL, NULL), CATA_ERR_CANCELLED);
    CHECK(count == pairs);
    CHECK_STATUS(sliced(pairs, (size_t)1 << 30, refuse, &count, 1, cancel, &calls), CATA_ERR_CANCELLED);
    CHECK(count == pairs && calls == 1);
    CHECK_STATUS(sliced(pairs, (size_t)1 << 30, NULL, NULL, 1, NULL, NULL), CATA_ERR_NULL);
    CHECK_MENTIONS("slice: must not be NULL");
    CHECK_STATUS(sliced(0, 0, refuse, NULL, 1, NULL, NULL), CATA_OK);

    /* Of a mesh, with a vertex in no face. */
    double values[4], vectors[4 * 6];
    static brought mesh;
    mesh.last = 6;
    CHECK_STATUS(cata_mesh_eigs(6, positions, 4, corners, 4, values, vectors, 6, NULL, NULL, NULL), CATA_OK);
    CHECK_STATUS(cata_mesh_eigs_sliced(6, positions, 4, corners, 4, 1 << 20, take, &mesh, NULL), CATA_OK);
    CHECK(mesh.slices == 1 && mesh.pairs == 4);
    CHECK(memcmp(mesh.values, values, sizeof values) == 0);
    CHECK(memcmp(mesh.vectors, vectors, sizeof vectors) == 0);
    CHECK_STATUS(cata_mesh_eigs_sliced(6, positions, 4, corners, 6, 1 << 20, take, &mesh, NULL),
                 CATA_ERR_ARGUMENT);
    CHECK_MENTIONS("k: 6");
    CHECK(mesh.slices == 1);
}

static void test_counts(void)
{
    size_t count = 77;
    for (int i = 0; i < P; i += 57) {
        CHECK_STATUS(cata_eigs_count(P, path_starts, path_columns, path_entries, path_masses,
                                     path_value(i + 0.5), &count, NULL),
                     CATA_OK);
        CHECK(count == (size_t)i + 1);
    }
    /* All pairs of an interval. */
    const double low = path_value(10.5), high = path_value(15.5);
    size_t below = 0;
    CHECK_STATUS(cata_eigs_count(P, path_starts, path_columns, path_entries, NULL, low, &below, NULL), CATA_OK);
    CHECK_STATUS(cata_eigs_count(P, path_starts, path_columns, path_entries, NULL, high, &count, NULL), CATA_OK);
    CHECK(count - below == 5);
    double values[5], vectors[5 * P];
    const cata_eigs_params around = {.struct_size = sizeof around, .shift = (low + high) / 2, .has_shift = 1};
    CHECK_STATUS(cata_eigs(P, path_starts, path_columns, path_entries, NULL, 5, values, vectors, P, NULL,
                           &around),
                 CATA_OK);
    for (int i = 0; i < 5; i++) {
        CHECK(fabs(values[i] - path_value(11 + i)) < 1e-10);
    }
    count = 77;
    CHECK_STATUS(cata_eigs_count(P, path_starts, path_columns, path_entries, NULL, NAN, &count, NULL),
                 CATA_ERR_ARGUMENT);
    CHECK_MENTIONS("value: NaN is not finite");
    CHECK_STATUS(cata_eigs_count(P, path_starts, path_columns, path_entries, NULL, 1, NULL, NULL),
                 CATA_ERR_NULL);
    CHECK_MENTIONS("count: must not be NULL");
    int calls = 0;
    const cata_eigs_params params = {.struct_size = sizeof params, .progress = cancel, .progress_user = &calls};
    CHECK_STATUS(cata_eigs_count(P, path_starts, path_columns, path_entries, NULL, 1, &count, &params),
                 CATA_ERR_CANCELLED);
    CHECK(count == 77 && calls == 1);
    CHECK_STATUS(cata_eigs_count(0, NULL, NULL, NULL, NULL, 1, &count, NULL), CATA_OK);
    CHECK(count == 0);
}

static void test_cholesky_qr(void)
{
    double a[6] = {3, 4, 0, 1, 2, 3}, r[4], old[6];
    memcpy(old, a, sizeof a);
    const double masses[3] = {1, 2, 1};
    CHECK_STATUS(cata_ortho_cholesky_qr(CATA_COL_MAJOR, 3, 2, a, 3, masses, r, 2, NULL), CATA_OK);
    CHECK(r[0] > 0 && r[1] == 0 && r[3] > 0);
    for (int i = 0; i < 3; i++) {
        CHECK(fabs(a[i] * r[0] - old[i]) < 1e-14);
        CHECK(fabs(a[i] * r[2] + a[3 + i] * r[3] - old[3 + i]) < 1e-14);
    }
    CHECK(fabs(a[0] * a[3] + 2 * a[1] * a[4] + a[2] * a[5]) < 1e-15);
    CHECK(fabs(a[3] * a[3] + 2 * a[4] * a[4] + a[5] * a[5] - 1) < 1e-15);

    memcpy(a, old, sizeof a);
    int calls = 0;
    cata_ortho_params params = {.struct_size = sizeof params, .progress = cancel, .progress_user = &calls};
    r[0] = 5;
    CHECK_STATUS(cata_ortho_cholesky_qr(CATA_COL_MAJOR, 3, 2, a, 3, NULL, r, 2, &params), CATA_ERR_CANCELLED);
    CHECK(calls == 1);
    memcpy(a, old, sizeof a);
    CHECK_STATUS(cata_ortho_cholesky_qr(CATA_COL_MAJOR, 3, 2, a, 3, NULL, r, 1, NULL), CATA_ERR_SHAPE);
    CHECK_MENTIONS("ldr");
    CHECK_STATUS(cata_ortho_cholesky_qr(CATA_COL_MAJOR, 3, 2, NULL, 3, NULL, r, 2, NULL), CATA_ERR_NULL);
    a[2] = INFINITY;
    CHECK_STATUS(cata_ortho_cholesky_qr(CATA_COL_MAJOR, 3, 2, a, 3, NULL, r, 2, NULL), CATA_ERR_NON_FINITE);
    a[2] = 0;
    CHECK(memcmp(a, old, sizeof a) == 0);
    for (int i = 0; i < 3; i++) {
        a[3 + i] = 2 * a[i];
    }
    CHECK_STATUS(cata_ortho_cholesky_qr(CATA_COL_MAJOR, 3, 2, a, 3, NULL, r, 2, NULL), CATA_ERR_ARGUMENT);
    CHECK_MENTIONS("A: column 1 depends");
    CHECK(r[0] == 5);
    CHECK_STATUS(cata_ortho_cholesky_qr(CATA_ROW_MAJOR, 0, 0, NULL, 1, NULL, NULL, 0, NULL), CATA_OK);
}

/* Columns of a Gaussian at nearby centres: far more of them differ than the rank. */
static void test_rank_revealing(int quick)
{
    enum { ROWS = 200, COLS = 60 };
    static double a[ROWS * COLS], q[ROWS * COLS], first[ROWS * COLS], r[COLS * COLS];
    for (int j = 0; j < COLS; j++) {
        for (int i = 0; i < ROWS; i++) {
            const double x = (double)i / ROWS - (double)j / COLS;
            a[i + j * ROWS] = exp(-8 * x * x);
        }
    }
    size_t by_columns = 0, rank = 0, kept[COLS];
    cata_ortho_params params = {.struct_size = sizeof params};
    memcpy(q, a, sizeof a);
    CHECK_STATUS(cata_ortho_gram_schmidt(CATA_COL_MAJOR, ROWS, COLS, q, ROWS, NULL, NULL, 0, NULL, &by_columns,
                                         &params),
                 CATA_OK);
    params.method = CATA_ORTHO_RANK_REVEALING;
    for (size_t threads = 1; threads <= (quick ? 1 : 4); threads *= 2) {
        params.threads = threads;
        memcpy(q, a, sizeof a);
        CHECK_STATUS(cata_ortho_gram_schmidt(CATA_COL_MAJOR, ROWS, COLS, q, ROWS, NULL, r, COLS, kept, &rank,
                                             &params),
                     CATA_OK);
        CHECK(rank > 5 && rank <= by_columns && rank < COLS);
        CHECK(threads == 1 || memcmp(first, q, rank * ROWS * sizeof(double)) == 0);
        memcpy(first, q, sizeof q);
    }
    double gap = 0, defect = 0;
    for (size_t j = 0; j < rank; j++) {
        CHECK(j == 0 || kept[j - 1] < kept[j]);
        for (size_t l = 0; l <= j; l++) {
            double sum = j == l ? -1 : 0;
            for (size_t i = 0; i < ROWS; i++) {
                sum += q[i + j * ROWS] * q[i + l * ROWS];
            }
            defect = fmax(defect, fabs(sum));
        }
    }
    for (size_t j = 0; j < COLS; j++) {
        for (size_t i = 0; i < ROWS; i++) {
            double sum = -a[i + j * ROWS];
            for (size_t l = 0; l < rank; l++) {
                sum += q[i + l * ROWS] * r[l + j * COLS];
            }
            gap = fmax(gap, fabs(sum));
        }
    }
    CHECK(defect < 1e-12 && gap < 1e-7);
    params.method = -1;
    CHECK_STATUS(cata_ortho_gram_schmidt(CATA_COL_MAJOR, ROWS, COLS, q, ROWS, NULL, r, COLS, kept, &rank,
                                         &params),
                 CATA_ERR_ARGUMENT);
    CHECK_MENTIONS("params.method: must be a CATA_ORTHO_* value, is -1");
}

static void test_gram_schmidt(void)
{
    /* By rows; the third column is the sum of the first two. */
    double a[12] = {3, 1, 4, 99, 0, 2, 2, 99, 4, 0, 4, 99};
    double r[3 * 4];
    size_t kept[3] = {9, 9, 9}, rank = 0;
    CHECK_STATUS(cata_ortho_gram_schmidt(CATA_ROW_MAJOR, 3, 3, a, 4, NULL, r, 4, kept, &rank, NULL),
                 CATA_OK);
    CHECK(rank == 2 && kept[0] == 0 && kept[1] == 1 && kept[2] == 9);
    CHECK(fabs(a[0] - 0.6) < 1e-15 && fabs(a[4]) < 1e-15 && fabs(a[8] - 0.8) < 1e-15);
    CHECK(fabs(r[0] - 5) < 1e-14 && r[4] == 0 && fabs(r[2] - r[0] - r[1]) < 1e-14);
    CHECK(r[8] == 0 && r[9] == 0 && r[10] == 0);

    const double bad[3] = {1, 0, 1};
    rank = 77;
    CHECK_STATUS(cata_ortho_gram_schmidt(CATA_COL_MAJOR, 3, 1, a, 3, bad, NULL, 0, NULL, &rank, NULL),
                 CATA_ERR_ARGUMENT);
    CHECK_STATUS(cata_ortho_gram_schmidt(CATA_COL_MAJOR, 3, 1, a, 3, NULL, NULL, 0, NULL, NULL, NULL),
                 CATA_ERR_NULL);
    CHECK_MENTIONS("rank: must not be NULL");
    cata_ortho_params params;
    CHECK_STATUS(cata_ortho_params_init(&params, sizeof params), CATA_OK);
    params.threshold = 2;
    CHECK_STATUS(cata_ortho_gram_schmidt(CATA_COL_MAJOR, 3, 1, a, 3, NULL, NULL, 0, NULL, &rank, &params),
                 CATA_ERR_ARGUMENT);
    CHECK_MENTIONS("threshold");
    CHECK(rank == 77);
    CHECK_STATUS(cata_ortho_gram_schmidt(CATA_COL_MAJOR, 0, 0, NULL, 1, NULL, NULL, 0, NULL, &rank, NULL),
                 CATA_OK);
    CHECK(rank == 0);
}

int main(int argc, char **argv)
{
    const int quick = argc > 1 && strcmp(argv[1], "quick") == 0;
    make_path();
    test_path();
    test_spectrum_refusals();
    test_mesh();
    test_mesh_refusals();
    test_slices(quick);
    test_counts();
    test_gram_schmidt();
    test_cholesky_qr();
    test_rank_revealing(quick);
    return report("test_spectrum");
}
