/* Descriptors, filters and shapes from spectra through the C ABI: closed forms on a ring,
 * invariants on a torus; refusals. */

#include <catamaran.h>

#include <math.h>
#include <string.h>

#include "check.h"
#include "meshes.h"

#define CHECK_MENTIONS(text) CHECK(strstr(cata_last_error_message(), text) != NULL)

enum { N = 24, K = 5 };

/* A ring of length 1: the constant, and cosines and sines of the frequencies 1 and 2, of the
 * eigenvalues 0, 1, 1, 4, 4. The sum of squares of a pair is 2 everywhere. */
static const double values[K] = {0, 1, 1, 4, 4};
static double functions[K * N];

static void ring(void)
{
    for (int i = 0; i < N; i++) {
        for (int j = 0; j < K; j++) {
            const double at = (j + 1) / 2 * 2 * acos(-1) * i / N;
            functions[j * N + i] = j == 0 ? 1 : sqrt(2) * (j % 2 ? cos(at) : sin(at));
        }
    }
}

static void test_heat(void)
{
    const double times[3] = {0, 0.5, 100};
    double found[3 * N], scaled[3 * N], usual[4];
    CHECK_STATUS(cata_descriptor_heat(CATA_COL_MAJOR, N, K, values, functions, N, 3, times, 0,
                                      found, N, NULL),
                 CATA_OK);
    CHECK_STATUS(cata_descriptor_heat(CATA_COL_MAJOR, N, K, values, functions, N, 3, times, 1,
                                      scaled, N, NULL),
                 CATA_OK);
    for (int j = 0; j < 3; j++) {
        const double all = 1 + 2 * exp(-times[j]) + 2 * exp(-4 * times[j]);
        for (int i = 0; i < N; i++) {
            CHECK(fabs(found[j * N + i] - all) < 1e-12);
            /* The trace is the same here: the ring has the length 1. */
            CHECK(fabs(scaled[j * N + i] - 1) < 1e-12);
        }
    }
    CHECK_STATUS(cata_descriptor_heat_times(K, values, 4, usual), CATA_OK);
    CHECK(fabs(usual[0] - log(10)) < 1e-12 && fabs(usual[3] - 4 * log(10)) < 1e-12);
    CHECK(fabs(usual[1] / usual[0] - usual[3] / usual[2]) < 1e-12);
    CHECK_STATUS(cata_descriptor_heat_kernel(CATA_COL_MAJOR, N, K, values, functions, N, 3, 0.25,
                                             found), CATA_OK);
    for (int i = 0; i < N; i++) {
        const double angle = 2 * acos(-1) * (i - 3) / N;
        const double heat = 1 + 2 * exp(-0.25) * cos(angle) + 2 * exp(-1.0) * cos(2 * angle);
        CHECK(fabs(found[i] - heat) < 1e-12);
    }
}

static void test_wave(void)
{
    double energies[6], sigma = 0, found[6 * N];
    CHECK_STATUS(cata_descriptor_wave_scales(K, values, 6, energies, &sigma), CATA_OK);
    CHECK(fabs(sigma - 7 * log(4) / 33) < 1e-12 && fabs(energies[0] - 2 * sigma) < 1e-12);
    cata_descriptor_params params;
    CHECK_STATUS(cata_descriptor_params_init(&params, sizeof params), CATA_OK);
    params.threads = 2;
    CHECK_STATUS(cata_descriptor_wave(CATA_COL_MAJOR, N, K, values, functions, N, 6, energies,
                                      sigma, found, N,
                                      &params),
                 CATA_OK);
    /* A mean of squares that come in pairs with the sum 2. */
    for (int i = 0; i < 6 * N; i++) {
        CHECK(fabs(found[i] - 1) < 1e-12);
    }
}

static void test_points(void)
{
    double found[K * N];
    size_t count = 9;
    CHECK_STATUS(cata_descriptor_points(CATA_COL_MAJOR, N, K, values, functions, N, &count, found,
                                        N), CATA_OK);
    CHECK(count == 4);
    for (int i = 0; i < N; i++) {
        CHECK(fabs(found[i] - functions[N + i]) < 1e-15);
        CHECK(fabs(found[3 * N + i] - functions[4 * N + i] / 2) < 1e-15);
        CHECK(found[4 * N + i] == 0);
    }
}

enum { AROUND = 20, TUBE = 10, V = AROUND * TUBE, F = 2 * V };

static double vertices[3 * V], moved[3 * V];
static uint32_t faces[3 * F];

static void test_surfaces(void)
{
    static double shot[V * CATA_SHOT_BINS], other[V * CATA_SHOT_BINS], rings[V * 9], heights[2 * V];
    make_torus(AROUND, TUBE, vertices, faces);
    /* Shaken, as symmetry leaves it to rounding which way a frame turns. */
    uint32_t random = 1;
    for (int i = 0; i < 3 * V; i++) {
        random = random * 1664525u + 1013904223u;
        vertices[i] += 0.2 * (random / 4294967296.0 - 0.5);
    }
    for (int v = 0; v < V; v++) {
        /* Turned, moved, and twice as large. */
        moved[3 * v] = 7 - 2 * vertices[3 * v + 1];
        moved[3 * v + 1] = 2 * vertices[3 * v];
        moved[3 * v + 2] = 2 * vertices[3 * v + 2] - 1;
        heights[v] = 3;
        heights[V + v] = vertices[3 * v + 2];
    }
    CHECK_STATUS(cata_descriptor_shot(V, vertices, F, faces, 1.3, CATA_ROW_MAJOR, shot,
                                      CATA_SHOT_BINS, NULL),
                 CATA_OK);
    cata_descriptor_params params = {.struct_size = sizeof params, .threads = 3};
    CHECK_STATUS(cata_descriptor_shot(V, vertices, F, faces, 1.3, CATA_ROW_MAJOR, other,
                                      CATA_SHOT_BINS, &params),
                 CATA_OK);
    CHECK(memcmp(shot, other, sizeof shot) == 0);
    CHECK_STATUS(cata_descriptor_shot(V, moved, F, faces, 2.6, CATA_ROW_MAJOR, other,
                                      CATA_SHOT_BINS, NULL),
                 CATA_OK);
    int near = 0;
    for (int v = 0; v < V; v++) {
        double square = 0, apart = 0;
        for (int i = 0; i < CATA_SHOT_BINS; i++) {
            const double x = shot[v * CATA_SHOT_BINS + i], y = other[v * CATA_SHOT_BINS + i];
            square += x * x;
            apart += (x - y) * (x - y);
        }
        CHECK(fabs(square - 1) < 1e-12);
        near += apart < 1e-12;
    }
    /* Rounding may take a point from one half of a ball to the other, here and there. */
    CHECK(near > V * 3 / 4);

    CHECK_STATUS(cata_descriptor_rings(V, vertices, F, faces, 1.5, 3, CATA_COL_MAJOR, 2, heights,
                                       V, rings, V, NULL),
                 CATA_OK);
    for (int v = 0; v < V; v++) {
        CHECK(fabs(rings[v] + rings[3 * V + v] + rings[6 * V + v] - 1) < 1e-12);
        for (int ring = 0; ring < 3; ring++) {
            CHECK(fabs(rings[(3 * ring + 1) * V + v] - 3) < 1e-12);
            CHECK(fabs(rings[(3 * ring + 2) * V + v]) <= 1.1 + 1e-12);
        }
    }
}

static void test_filters(void)
{
    const double frequencies[4] = {0, 1, 2, 9};
    double gains[4], rest = 9;
    CHECK_STATUS(cata_filter_gains(CATA_RESPONSE_LOW_PASS, 2, 0, 4, frequencies, gains, &rest),
                 CATA_OK);
    CHECK(gains[0] == 1 && gains[2] == 1 && gains[3] == 0 && rest == 0);
    CHECK_STATUS(cata_filter_gains(CATA_RESPONSE_HIGH_PASS, 1, NAN, 4, frequencies, gains, &rest),
                 CATA_OK);
    CHECK(gains[1] == 0 && gains[2] == 1 && rest == 1);
    CHECK_STATUS(cata_filter_gains(CATA_RESPONSE_BAND_PASS, 1, 2, 4, frequencies, gains, NULL),
                 CATA_OK);
    CHECK(gains[0] == 0 && gains[1] == 1 && gains[2] == 1 && gains[3] == 0);
    CHECK_STATUS(cata_filter_gains(CATA_RESPONSE_HEAT, 0.5, 0, 4, frequencies, gains, &rest),
                 CATA_OK);
    CHECK(gains[0] == 1 && fabs(gains[2] - exp(-1.0)) < 1e-15 && rest == 0);
    CHECK_STATUS(cata_filter_gains(CATA_RESPONSE_SHARPEN, 0.5, 3, 4, frequencies, gains, &rest),
                 CATA_OK);
    CHECK(gains[0] == 1 && fabs(gains[2] - 1 - 3 * (1 - exp(-1.0))) < 1e-12 &&
          fabs(rest - 4) < 1e-12);
    gains[0] = 5;
    CHECK_STATUS(cata_filter_gains(5, 0, 0, 4, frequencies, gains, NULL), CATA_ERR_ARGUMENT);
    CHECK_MENTIONS("response");
    CHECK_STATUS(cata_filter_gains(CATA_RESPONSE_HEAT, NAN, 0, 4, frequencies, gains, NULL),
                 CATA_ERR_NON_FINITE);
    CHECK_MENTIONS("first");
    CHECK(gains[0] == 5);

    /* W = [2 -1; -1 2] has the energies 1 and 3. */
    const size_t starts[3] = {0, 2, 4}, columns[4] = {0, 1, 0, 1};
    const double w[4] = {2, -1, -1, 2}, f[6] = {1, 1, 2, -2, 0, 0}, masses[2] = {0.5, 0.5};
    double energies[3];
    CHECK_STATUS(cata_filter_energies(2, starts, columns, w, NULL, CATA_COL_MAJOR, 3, f, 2,
                                      energies), CATA_OK);
    CHECK(fabs(energies[0] - 1) < 1e-15 && fabs(energies[1] - 3) < 1e-15 && energies[2] == 0);
    CHECK_STATUS(cata_filter_energies(2, starts, columns, w, masses, CATA_COL_MAJOR, 3, f, 2,
                                      energies), CATA_OK);
    CHECK(fabs(energies[0] - 2) < 1e-15 && fabs(energies[1] - 6) < 1e-15);
}

enum { SIDE = 9, S = SIDE * SIDE, SF = 2 * (SIDE - 1) * (SIDE - 1), L = 5 };

static void first_eigenvalues(const double *of, const uint32_t *corners, double *found)
{
    double vectors[L * S];
    cata_eigs_params params = {.struct_size = sizeof params, .boundary = CATA_BOUNDARY_DIRICHLET};
    CHECK_STATUS(cata_mesh_eigs(S, of, SF, corners, L, found, vectors, S, NULL, NULL, &params),
                 CATA_OK);
}

static void test_shapes(void)
{
    double square[3 * S], other[3 * S], wanted[L], found[L], recomputed[L], positions[3 * S],
        error = 9, before = 9;
    uint32_t corners[3 * SF];
    size_t steps = 9;
    make_square(SIDE, 1, square, corners);
    make_square(SIDE, 2, other, corners);
    first_eigenvalues(other, corners, wanted);
    CHECK_STATUS(cata_shape_from_spectrum(S, square, SF, corners, L, wanted, positions, found,
                                          &error, &steps, NULL),
                 CATA_OK);
    /* The size alone is another one, which is fitted first. */
    CHECK(steps == 0 && error < 1e-9);
    for (int i = 0; i < 3 * S; i++) {
        CHECK(fabs(positions[i] - other[i]) < 1e-9);
    }
    for (int v = 0; v < S; v++) {
        other[3 * v] *= 1.1;
    }
    first_eigenvalues(other, corners, wanted);
    cata_shape_params params;
    CHECK_STATUS(cata_shape_params_init(&params, sizeof params), CATA_OK);
    params.tolerance = 10;
    CHECK_STATUS(cata_shape_from_spectrum(S, square, SF, corners, L, wanted, positions, NULL,
                                          &before, &steps, &params),
                 CATA_OK);
    CHECK(steps == 0 && before > 1e-3);
    params.tolerance = 0;
    params.steps = 5;
    CHECK_STATUS(cata_shape_from_spectrum(S, square, SF, corners, L, wanted, positions, found,
                                          &error, &steps, &params),
                 CATA_OK);
    CHECK(error < before && steps >= 1 && steps <= 5);
    first_eigenvalues(positions, corners, recomputed);
    double mean = 0;
    for (int i = 0; i < L; i++) {
        CHECK(fabs(recomputed[i] / found[i] - 1) < 1e-8);
        mean += fabs(found[i] / wanted[i] - 1) / L;
    }
    CHECK(fabs(mean - error) < 1e-12);

    positions[0] = 5;
    wanted[0] = 0;
    CHECK_STATUS(cata_shape_from_spectrum(S, square, SF, corners, L, wanted, positions, NULL,
                                          NULL, NULL, NULL),
                 CATA_ERR_ARGUMENT);
    CHECK_MENTIONS("leave zeros out");
    params.tolerance = -1;
    wanted[0] = 0.1;
    CHECK_STATUS(cata_shape_from_spectrum(S, square, SF, corners, L, wanted, positions, NULL,
                                          NULL, NULL, &params),
                 CATA_ERR_ARGUMENT);
    CHECK_MENTIONS("tolerance");
    CHECK(positions[0] == 5);
}

static int32_t cancel(double fraction, void *user)
{
    (void)fraction;
    ++*(int *)user;
    return 1;
}

static void test_refusals(void)
{
    double found[K * N] = {5}, sigma = 5;
    const double times[2] = {0, -1}, none[2] = {0, 0};
    int calls = 0;
    CHECK_STATUS(cata_descriptor_heat(CATA_COL_MAJOR, N, K, values, functions, N, 2, times, 0,
                                      found, N, NULL),
                 CATA_ERR_ARGUMENT);
    CHECK_MENTIONS("times");
    CHECK_STATUS(cata_descriptor_heat(CATA_COL_MAJOR, N, K, values, functions, N, 1, times, 2,
                                      found, N, NULL),
                 CATA_ERR_ARGUMENT);
    CHECK_MENTIONS("scaled");
    CHECK_STATUS(cata_descriptor_heat(CATA_COL_MAJOR, N, K, values, functions, N - 1, 1, times, 0,
                                      found, N, NULL),
                 CATA_ERR_SHAPE);
    CHECK_MENTIONS("ldv");
    CHECK_STATUS(cata_descriptor_heat_times(2, none, 2, found), CATA_ERR_ARGUMENT);
    CHECK_STATUS(cata_descriptor_heat_kernel(CATA_COL_MAJOR, N, K, values, functions, N, N, 1,
                                             found),
                 CATA_ERR_ARGUMENT);
    CHECK_MENTIONS("source");
    CHECK_STATUS(cata_descriptor_wave_scales(2, values, 2, found, &sigma), CATA_ERR_ARGUMENT);
    CHECK_STATUS(cata_descriptor_wave(CATA_COL_MAJOR, N, K, values, functions, N, 1, none, 0,
                                      found, N, NULL),
                 CATA_ERR_ARGUMENT);
    CHECK_MENTIONS("sigma");
    CHECK_STATUS(cata_descriptor_points(CATA_COL_MAJOR, N, K, values, NULL, N, NULL, found, N),
                 CATA_ERR_NULL);
    CHECK_STATUS(cata_descriptor_shot(0, NULL, 0, NULL, 0, CATA_ROW_MAJOR, NULL, CATA_SHOT_BINS,
                                      NULL),
                 CATA_ERR_ARGUMENT);
    CHECK_MENTIONS("radius");
    CHECK_STATUS(cata_descriptor_rings(0, NULL, 0, NULL, 1, 0, CATA_ROW_MAJOR, 0, NULL, 1, NULL,
                                       1, NULL),
                 CATA_ERR_ARGUMENT);
    CHECK_MENTIONS("rings");
    cata_descriptor_params params = {.struct_size = sizeof params, .progress = cancel,
                                     .progress_user = &calls};
    CHECK_STATUS(cata_descriptor_heat(CATA_COL_MAJOR, N, K, values, functions, N, 1, times, 0,
                                      found, N, &params),
                 CATA_ERR_CANCELLED);
    CHECK(calls == 1 && found[0] == 5 && sigma == 5);
}

int main(void)
{
    ring();
    test_heat();
    test_wave();
    test_points();
    test_surfaces();
    test_filters();
    test_shapes();
    test_refusals();
    return report("test_descriptors");
}
