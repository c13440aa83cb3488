/* Spectra of parts and ShapeDNA through the C ABI: closed forms, domain monotonicity, refusals, outputs untouched. */

#include <catamaran.h>

#include <math.h>
#include <string.h>

#include "check.h"

#define CHECK_MENTIONS(text) CHECK(strstr(cata_last_error_message(), text) != NULL)

enum { SIDE = 41, V = SIDE * SIDE, F = 2 * (SIDE - 1) * (SIDE - 1), K = 8 };

static double positions[3 * V];
static uint32_t corners[3 * F];
static uint8_t mask[V];

/* The unit square. */
static void make_square(void)
{
    size_t f = 0;
    for (uint32_t i = 0; i < SIDE; i++) {
        for (uint32_t j = 0; j < SIDE; j++) {
            const uint32_t v = i * SIDE + j;
            positions[3 * v] = i / (SIDE - 1.0);
            positions[3 * v + 1] = j / (SIDE - 1.0);
            if (i + 1 < SIDE && j + 1 < SIDE) {
                const uint32_t two[6] = {v, v + SIDE, v + SIDE + 1, v, v + SIDE + 1, v + 1};
                memcpy(corners + f, two, sizeof two);
                f += 6;
            }
        }
    }
}

/* Vertices with x of at most this. */
static void mask_up_to(double x)
{
    for (size_t v = 0; v < V; v++) {
        mask[v] = positions[3 * v] <= x + 1e-9;
    }
}

static cata_status part(size_t k, double *values, int32_t boundary, size_t threads)
{
    cata_eigs_params params;
    CHECK_STATUS(cata_eigs_params_init(&params, sizeof params), CATA_OK);
    params.boundary = boundary;
    params.threads = threads;
    return cata_mesh_part_eigenvalues(V, positions, F, corners, mask, k, values, &params);
}

static int32_t cancel(double fraction, void *user)
{
    (void)fraction;
    ++*(int *)user;
    return 1;
}

static void test_parts(void)
{
    const double pi2 = 9.869604401089358;
    double whole[K], half[K], again[K], free_half[K];
    mask_up_to(1.0);
    CHECK_STATUS(part(K, whole, CATA_BOUNDARY_DIRICHLET, 0), CATA_OK);
    CHECK(fabs(whole[0] / (2 * pi2) - 1) < 0.01 && fabs(whole[1] / (5 * pi2) - 1) < 0.01);
    mask_up_to(0.5);
    CHECK_STATUS(part(K, half, CATA_BOUNDARY_DIRICHLET, 1), CATA_OK);
    CHECK(fabs(half[0] / (5 * pi2) - 1) < 0.01 && fabs(half[1] / (8 * pi2) - 1) < 0.01);
    CHECK_STATUS(part(K, again, CATA_BOUNDARY_DIRICHLET, 3), CATA_OK);
    CHECK(memcmp(half, again, sizeof half) == 0);
    CHECK_STATUS(part(K, free_half, CATA_BOUNDARY_NEUMANN, 1), CATA_OK);
    CHECK(fabs(free_half[0]) < 1e-9 && fabs(free_half[1] / pi2 - 1) < 0.01);
    for (size_t i = 0; i < K; i++) {
        CHECK(whole[i] <= half[i] && free_half[i] <= half[i]);
    }
    /* Nothing but what is not there is refused. */
    CHECK_STATUS(part(0, NULL, CATA_BOUNDARY_DIRICHLET, 1), CATA_OK);
    again[0] = -7;
    CHECK_STATUS(part(V, again, CATA_BOUNDARY_DIRICHLET, 1), CATA_ERR_ARGUMENT);
    CHECK_MENTIONS("the number of inner vertices, is ");
    mask[3] = 2;
    CHECK_STATUS(part(K, again, CATA_BOUNDARY_DIRICHLET, 1), CATA_ERR_ARGUMENT);
    CHECK_MENTIONS("mask: must be 0 or 1, but element 3 is 2");
    CHECK_STATUS(cata_mesh_part_eigenvalues(V, positions, F, corners, NULL, K, again, NULL), CATA_ERR_NULL);
    CHECK_STATUS(cata_mesh_part_eigenvalues(2, positions, F, corners, mask, K, again, NULL), CATA_ERR_MESH);
    int calls = 0;
    cata_eigs_params params = {.struct_size = sizeof params, .progress = cancel, .progress_user = &calls};
    mask[3] = 1;
    CHECK_STATUS(cata_mesh_part_eigenvalues(V, positions, F, corners, mask, K, again, &params),
                 CATA_ERR_CANCELLED);
    CHECK_STATUS(cata_shape_dna(V, positions, F, corners, K, 1, again, &params), CATA_ERR_CANCELLED);
    CHECK(again[0] == -7 && calls == 2);
}

/* Two squares that share no vertex, then a tetrahedron. */
static void test_free_components(void)
{
    double v[3 * 12] = {0};
    const uint32_t f[24] = {0, 1, 2, 0, 2, 3, 4, 5, 6, 4, 6, 7, 8, 10, 9, 8, 9, 11, 8, 11, 10, 9, 10, 11};
    for (size_t i = 0; i < 12; i++) {
        const double square[6] = {(i % 4 == 1 || i % 4 == 2), i % 4 > 1, 0};
        const double corner[6] = {i == 9, i == 10, i == 11};
        memcpy(v + 3 * i, i < 8 ? square : corner, 3 * sizeof(double));
    }
    size_t count = 7;
    double signature[4] = {-7, -7, -7, -7};
    cata_eigs_params params = {.struct_size = sizeof params};
    CHECK_STATUS(cata_mesh_free_components(12, v, 8, f, &count, NULL), CATA_OK);
    CHECK(count == 3);
    params.boundary = CATA_BOUNDARY_DIRICHLET;
    CHECK_STATUS(cata_mesh_free_components(12, v, 8, f, &count, &params), CATA_OK);
    CHECK(count == 1);
    params.boundary = 9;
    CHECK_STATUS(cata_mesh_free_components(12, v, 8, f, &count, &params), CATA_ERR_ARGUMENT);
    CHECK_STATUS(cata_mesh_free_components(2, v, 8, f, &count, NULL), CATA_ERR_MESH);
    CHECK_STATUS(cata_mesh_free_components(12, v, 8, f, NULL, NULL), CATA_ERR_NULL);
    CHECK(count == 1);
    /* A signature of zeros alone is that of any such mesh. */
    CHECK_STATUS(cata_shape_dna(12, v, 8, f, 3, 1, signature, NULL), CATA_ERR_ARGUMENT);
    CHECK_MENTIONS("k: must be more than 3");
    CHECK(signature[0] == -7);
    CHECK_STATUS(cata_shape_dna(12, v, 8, f, 4, 1, signature, NULL), CATA_OK);
    CHECK(signature[0] == 0 && signature[2] == 0 && signature[3] > 0);
}

static void test_shape_dna(void)
{
    double one[K], scaled[K], plain[K];
    CHECK_STATUS(cata_shape_dna(V, positions, F, corners, K, 1, one, NULL), CATA_OK);
    for (size_t i = 0; i < 3 * V; i++) {
        positions[i] *= 2;
    }
    CHECK_STATUS(cata_shape_dna(V, positions, F, corners, K, 1, scaled, NULL), CATA_OK);
    CHECK_STATUS(cata_shape_dna(V, positions, F, corners, K, 0, plain, NULL), CATA_OK);
    for (size_t i = 1; i < K; i++) {
        CHECK(fabs(scaled[i] / one[i] - 1) < 1e-9 && fabs(4 * plain[i] / one[i] - 1) < 1e-9);
    }
    CHECK_STATUS(cata_shape_dna(V, positions, F, corners, K, 2, plain, NULL), CATA_ERR_ARGUMENT);

    const double signatures[8] = {0, 5, 3, 4, 0, 5, 1, 1}, query[2] = {0, 4};
    size_t found[3];
    double distances[3];
    CHECK_STATUS(cata_shape_dna_retrieve(2, query, 4, signatures, 3, found, distances), CATA_OK);
    CHECK(found[0] == 0 && found[1] == 2 && found[2] == 1);
    CHECK(distances[0] == 1 && distances[1] == 1 && distances[2] == 3);
    found[0] = 9;
    CHECK_STATUS(cata_shape_dna_retrieve(2, query, 4, signatures, 5, found, distances),
                 CATA_ERR_ARGUMENT);
    CHECK_STATUS(cata_shape_dna_retrieve(2, NULL, 4, signatures, 1, found, distances), CATA_ERR_NULL);
    const double broken[2] = {0, NAN};
    CHECK_STATUS(cata_shape_dna_retrieve(2, broken, 4, signatures, 1, found, distances),
                 CATA_ERR_NON_FINITE);
    CHECK(found[0] == 9);
}

int main(void)
{
    make_square();
    test_parts();
    test_free_components();
    test_shape_dna();
    return report("test_parts");
}
