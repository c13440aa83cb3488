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
    double values[3] = {5, 5, 5}, vectors[9];
    CHECK_STATUS(cata_eigs(3, NULL, columns, entries, NULL, 1, values, vectors, 3, NULL, NULL),
                 CATA_ERR_NULL);
    CHECK_MENTIONS("row_starts: NULL");
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
    CHECK_MENTIONS("vertices: NULL");
    CHECK_STATUS(cata_mesh_eigs(6, positions, 4, corners, 6, values, vectors, 6, NULL, NULL, NULL),
                 CATA_ERR_ARGUMENT);
    CHECK_MENTIONS("k: 6");
    cata_eigs_params params = {.struct_size = sizeof params, .laplacian = 3};
    CHECK_STATUS(cata_mesh_eigs(6, positions, 4, corners, 1, values, vectors, 6, NULL, NULL, &params),
                 CATA_ERR_ARGUMENT);
    CHECK_MENTIONS("params.laplacian: 3");
    params.laplacian = 0;
    params.mass = CATA_MASS_CONSISTENT;
    CHECK_STATUS(cata_mesh_eigs(6, positions, 4, corners, 1, values, vectors, 6, NULL, masses,
                                &params),
                 CATA_ERR_ARGUMENT);
    CHECK_MENTIONS("masses");
    CHECK(values[0] == 5 && masses[0] == 5);
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
    CHECK_MENTIONS("rank: NULL");
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

int main(void)
{
    test_path();
    test_spectrum_refusals();
    test_mesh();
    test_mesh_refusals();
    test_gram_schmidt();
    return report("test_spectrum");
}
