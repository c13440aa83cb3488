/* Decimation through the C ABI: sizes, what is carried, refusals, the same bytes for any number of threads. */

#include <catamaran.h>

#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "check.h"

#define CHECK_MENTIONS(text) CHECK(strstr(cata_last_error_message(), text) != NULL)

enum { AROUND = 40, TUBE = 20, V = AROUND * TUBE, F = 2 * V, N = 100 };

static double vertices[3 * V];
static uint32_t faces[3 * F];

static void make_torus(void)
{
    const double tau = 6.283185307179586;
    size_t f = 0;
    for (uint32_t i = 0; i < AROUND; i++) {
        for (uint32_t j = 0; j < TUBE; j++) {
            const uint32_t a = i * TUBE + j, b = (i + 1) % AROUND * TUBE + j;
            const uint32_t c = (i + 1) % AROUND * TUBE + (j + 1) % TUBE;
            const uint32_t d = i * TUBE + (j + 1) % TUBE;
            const double u = tau * i / AROUND, v = tau * j / TUBE;
            vertices[3 * a] = (2 + cos(v)) * cos(u);
            vertices[3 * a + 1] = (2 + cos(v)) * sin(u);
            vertices[3 * a + 2] = sin(v);
            const uint32_t corners[6] = {a, b, c, a, c, d};
            memcpy(faces + f, corners, sizeof corners);
            f += 6;
        }
    }
}

static double new_vertices[3 * N], more_vertices[3 * N], values[V], carried[N], uv[6 * F];
static uint32_t new_faces[6 * N], more_faces[6 * N], cells[V];

static cata_status decimate(size_t n, const cata_decimation_params *params,
                            cata_decimation **decimation)
{
    return cata_decimation_new(V, vertices, F, faces, n, params, decimation);
}

static void test_torus(void)
{
    cata_decimation *torus = NULL;
    size_t n = 0, count = 0;
    int32_t repaired = 7;
    CHECK_STATUS(decimate(N, NULL, &torus), CATA_OK);
    CHECK_STATUS(cata_decimation_size(torus, &n, &count, &repaired), CATA_OK);
    /* A torus: as many faces as twice its vertices. */
    CHECK(n == N && count == 2 * N && repaired == 0);
    CHECK_STATUS(cata_decimation_get(torus, new_vertices, new_faces), CATA_OK);
    for (size_t i = 0; i < 3 * count; i++) {
        CHECK(new_faces[i] < N);
    }
    cata_decimation_free(torus);
    for (size_t threads = 1; threads <= 3; threads++) {
        cata_decimation_params params;
        CHECK_STATUS(cata_decimation_params_init(&params, sizeof params), CATA_OK);
        params.threads = threads;
        CHECK_STATUS(decimate(N, &params, &torus), CATA_OK);
        CHECK_STATUS(cata_decimation_get(torus, more_vertices, more_faces), CATA_OK);
        CHECK(memcmp(new_vertices, more_vertices, sizeof new_vertices) == 0);
        CHECK(memcmp(new_faces, more_faces, sizeof new_faces) == 0);
        cata_decimation_free(torus);
    }
}

static void test_within_an_error(void)
{
    cata_decimation *torus = NULL;
    size_t few = 0, many = 0;
    double bound = 0;
    for (int k = 0; k < 2; k++) {
        const double error = k == 0 ? 0.3 : 0.1;
        CHECK_STATUS(cata_decimation_new_within(V, vertices, F, faces, error, NULL, &torus),
                     CATA_OK);
        CHECK_STATUS(cata_decimation_bound(torus, &bound), CATA_OK);
        CHECK(bound > 0.5 * error && bound <= error);
        CHECK_STATUS(cata_decimation_size(torus, k == 0 ? &few : &many, NULL, NULL), CATA_OK);
        cata_decimation_free(torus);
    }
    CHECK(few < many && many < V);
    CHECK_STATUS(cata_decimation_new_within(V, vertices, F, faces, -1, NULL, &torus),
                 CATA_ERR_ARGUMENT);
    CHECK_MENTIONS("error");
}

static void test_locked_vertices(void)
{
    const uint32_t locked[3] = {21, 1, 500}, out[1] = {V};
    cata_decimation_params params;
    cata_decimation *torus = NULL;
    size_t n_edges = 7, n_lost = 7;
    CHECK_STATUS(cata_decimation_params_init(&params, sizeof params), CATA_OK);
    params.locked = locked;
    params.n_locked = 3;
    CHECK_STATUS(decimate(N, &params, &torus), CATA_OK);
    CHECK_STATUS(cata_decimation_get(torus, more_vertices, NULL), CATA_OK);
    for (size_t i = 0; i < 3; i++) {
        CHECK(memcmp(more_vertices + 3 * i, vertices + 3 * locked[i], 3 * sizeof(double)) == 0);
    }
    /* Of these, 1 and 21 = 20 + 1 are neighbours. */
    CHECK_STATUS(cata_decimation_locked_edges(torus, &n_edges, &n_lost), CATA_OK);
    CHECK(n_edges == 1 && n_lost == 0);
    cata_decimation_free(torus);
    params.locked = out;
    params.n_locked = 1;
    CHECK_STATUS(decimate(N, &params, &torus), CATA_ERR_ARGUMENT);
    CHECK_MENTIONS("locked");
}

static void test_density(void)
{
    static double density[V], even[3 * N];
    cata_decimation_params params;
    cata_decimation *torus = NULL;
    size_t outside[2] = {0, 0};
    CHECK_STATUS(cata_decimation_params_init(&params, sizeof params), CATA_OK);
    CHECK(params.density == NULL && params.n_density == 0 && params.curvature == 0);
    for (size_t v = 0; v < V; v++) {
        density[v] = vertices[3 * v] > 0 ? 9 : 1;
    }
    for (int dense = 0; dense < 2; dense++) {
        params.density = dense ? density : NULL;
        params.n_density = dense ? V : 0;
        CHECK_STATUS(decimate(N, &params, &torus), CATA_OK);
        CHECK_STATUS(cata_decimation_get(torus, even, NULL), CATA_OK);
        cata_decimation_free(torus);
        for (size_t v = 0; v < N; v++) {
            outside[dense] += even[3 * v] > 0;
        }
    }
    /* Nine tenths instead of a half, less what is near the middle. */
    CHECK(outside[0] < 2 * N / 3 && outside[1] > 3 * N / 4);
    params.curvature = 4;
    CHECK_STATUS(decimate(N, &params, &torus), CATA_OK);
    cata_decimation_free(torus);
    density[7] = -1;
    CHECK_STATUS(decimate(N, &params, &torus), CATA_ERR_ARGUMENT);
    CHECK_MENTIONS("density: must be positive and finite, is -1e0 at vertex 7");
    params.n_density = 3;
    CHECK_STATUS(decimate(N, &params, &torus), CATA_ERR_ARGUMENT);
    CHECK_MENTIONS("density");
    params.n_density = 0;
    params.curvature = 0.5;
    CHECK_STATUS(decimate(N, &params, &torus), CATA_ERR_ARGUMENT);
    CHECK_MENTIONS("curvature");
}

static void test_what_is_carried(void)
{
    cata_decimation *torus = NULL;
    static float distances[V];
    static uint32_t places[N];
    static double weights[3 * N], back[V], new_uv[12 * N];
    CHECK_STATUS(decimate(N, NULL, &torus), CATA_OK);
    CHECK_STATUS(cata_decimation_get(torus, new_vertices, NULL), CATA_OK);
    CHECK_STATUS(cata_decimation_places(torus, cells, distances, places, weights), CATA_OK);
    for (size_t v = 0; v < V; v++) {
        CHECK(cells[v] < N && distances[v] >= 0 && distances[v] < 1.5f);
        values[v] = vertices[3 * v + 2];
    }
    CHECK_STATUS(cata_decimation_carry(torus, 1, values, carried), CATA_OK);
    for (size_t v = 0; v < N; v++) {
        const double *w = weights + 3 * v;
        const uint32_t *face = faces + 3 * places[v];
        CHECK(places[v] < F && fabs(w[0] + w[1] + w[2] - 1) < 1e-12);
        const double z = w[0] * values[face[0]] + w[1] * values[face[1]] + w[2] * values[face[2]];
        CHECK(fabs(carried[v] - z) < 1e-12 && fabs(carried[v] - new_vertices[3 * v + 2]) < 0.2);
    }
    CHECK_STATUS(cata_decimation_prolong(torus, 1, carried, back), CATA_OK);
    for (size_t v = 0; v < V; v++) {
        CHECK(fabs(back[v] - values[v]) < 0.5);
    }
    for (size_t i = 0; i < 3 * F; i++) {
        uv[2 * i] = vertices[3 * faces[i]];
        uv[2 * i + 1] = vertices[3 * faces[i] + 1];
    }
    CHECK_STATUS(cata_decimation_carry_uv(torus, uv, new_uv), CATA_OK);
    for (size_t i = 0; i < 12 * N; i++) {
        CHECK(fabs(new_uv[i]) < 3.5);
    }
    CHECK_STATUS(cata_decimation_carry(torus, SIZE_MAX, values, carried), CATA_ERR_SHAPE);
    CHECK_STATUS(cata_decimation_carry(torus, 1, NULL, carried), CATA_ERR_NULL);
    CHECK_STATUS(cata_decimation_carry(NULL, 1, values, carried), CATA_ERR_NULL);
    CHECK_MENTIONS("decimation: must not be NULL");
    uv[3] = NAN;
    CHECK_STATUS(cata_decimation_carry_uv(torus, uv, new_uv), CATA_ERR_NON_FINITE);
    CHECK_MENTIONS("uv");
    cata_decimation_free(torus);
}

static void test_farthest_points(void)
{
    uint32_t few[3], more[12];
    float distances[V];
    cata_decimation_params params = {.struct_size = sizeof params, .first = 7, .has_first = 1};
    CHECK_STATUS(cata_decimation_farthest_points(V, vertices, F, faces, 12, more, cells, distances,
                                                 &params),
                 CATA_OK);
    CHECK_STATUS(cata_decimation_farthest_points(V, vertices, F, faces, 3, few, NULL, NULL, &params),
                 CATA_OK);
    CHECK(few[0] == 7 && memcmp(few, more, sizeof few) == 0);
    for (size_t i = 0; i < 12; i++) {
        CHECK(cells[more[i]] == i && distances[more[i]] == 0);
    }
    few[0] = 42;
    CHECK_STATUS(cata_decimation_farthest_points(V, vertices, F, faces, V + 1, cells, NULL, NULL,
                                                 NULL),
                 CATA_ERR_ARGUMENT);
    params.first = V;
    CHECK_STATUS(cata_decimation_farthest_points(V, vertices, F, faces, 3, few, NULL, NULL, &params),
                 CATA_ERR_ARGUMENT);
    CHECK_MENTIONS("first");
    CHECK_STATUS(cata_decimation_farthest_points(V, vertices, F, faces, 0, few, NULL, NULL, NULL),
                 CATA_ERR_ARGUMENT);
    CHECK(few[0] == 42);
}

static int32_t cancel(double fraction, void *user)
{
    (void)fraction;
    ++*(int *)user;
    return 1;
}

static void test_refusals(void)
{
    cata_decimation *none = NULL;
    CHECK_STATUS(decimate(3, NULL, &none), CATA_ERR_ARGUMENT);
    CHECK_STATUS(cata_decimation_new(0, NULL, 0, NULL, 0, NULL, &none), CATA_ERR_MESH);
    CHECK_STATUS(cata_decimation_new(V, NULL, F, faces, N, NULL, &none), CATA_ERR_NULL);
    CHECK_STATUS(decimate(N, NULL, NULL), CATA_ERR_NULL);
    const uint32_t wrong[3] = {0, 1, V};
    CHECK_STATUS(cata_decimation_new(V, vertices, 1, wrong, 3, NULL, &none), CATA_ERR_MESH);
    CHECK_MENTIONS("face 0");
    int calls = 0;
    cata_decimation_params params = {.struct_size = sizeof params};
    params.progress = cancel;
    params.progress_user = &calls;
    CHECK_STATUS(decimate(N, &params, &none), CATA_ERR_CANCELLED);
    CHECK(calls == 1);
    params.progress = NULL;
    params.lloyd = -2;
    CHECK_STATUS(decimate(N, &params, &none), CATA_ERR_ARGUMENT);
    CHECK_MENTIONS("params.lloyd");
    params.lloyd = 0;
    params.keep_edges = 1;
    CHECK_STATUS(decimate(V + 1, &params, &none), CATA_ERR_ARGUMENT);
    params.method = 2;
    CHECK_STATUS(decimate(N, &params, &none), CATA_ERR_ARGUMENT);
    CHECK_MENTIONS("params.method");
    CHECK(none == NULL);
    cata_decimation_free(NULL);
}

int main(void)
{
    make_torus();
    test_torus();
    test_within_an_error();
    test_locked_vertices();
    test_density();
    test_what_is_carried();
    test_farthest_points();
    test_refusals();
    return report("test_decimate");
}
