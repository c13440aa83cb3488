/* Decimation through the C ABI: sizes, refusals, outputs untouched, the same bytes for any number of threads. */

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

static double new_vertices[3 * V], more_vertices[3 * V];
static uint32_t new_faces[3 * (2 * V + F)], more_faces[3 * (2 * V + F)], cells[V];

static void test_torus(void)
{
    const size_t capacity = cata_decimate_faces_bound(N, F);
    CHECK(capacity == 2 * N + F);
    CHECK(cata_decimate_faces_bound(SIZE_MAX, 1) == SIZE_MAX);
    size_t count = 0;
    int32_t changed = 7;
    CHECK_STATUS(cata_decimate(V, vertices, F, faces, N, new_vertices, new_faces, capacity, &count,
                               cells, &changed, NULL),
                 CATA_OK);
    /* A torus: as many faces as twice its vertices. */
    CHECK(count == 2 * N && changed == 0);
    for (size_t i = 0; i < 3 * count; i++) {
        CHECK(new_faces[i] < N);
    }
    for (size_t v = 0; v < V; v++) {
        CHECK(cells[v] < N);
    }
    for (size_t threads = 1; threads <= 3; threads++) {
        cata_decimate_params params;
        CHECK_STATUS(cata_decimate_params_init(&params, sizeof params), CATA_OK);
        params.threads = threads;
        CHECK_STATUS(cata_decimate(V, vertices, F, faces, N, more_vertices, more_faces, 2 * N,
                                   &count, NULL, NULL, &params),
                     CATA_OK);
        CHECK(memcmp(new_vertices, more_vertices, 3 * N * sizeof(double)) == 0);
        CHECK(memcmp(new_faces, more_faces, 3 * count * sizeof(uint32_t)) == 0);
    }
}

static int32_t cancel(double fraction, void *user)
{
    (void)fraction;
    ++*(int *)user;
    return 1;
}

static void test_refusals(void)
{
    size_t count = 5;
    new_vertices[0] = 42;
    new_faces[0] = 43;
    cells[0] = 44;
    CHECK_STATUS(cata_decimate(V, vertices, F, faces, N, new_vertices, new_faces, 2 * N - 1, &count,
                               cells, NULL, NULL),
                 CATA_ERR_SHAPE);
    CHECK_MENTIONS("200 faces, but faces_capacity is 199");
    CHECK_STATUS(cata_decimate(V, vertices, F, faces, V + 1, new_vertices, new_faces, F, &count,
                               cells, NULL, NULL),
                 CATA_ERR_SHAPE);
    CHECK_MENTIONS("1602 faces");
    CHECK_STATUS(cata_decimate(V, vertices, F, faces, 3, new_vertices, new_faces, F, &count, cells,
                               NULL, NULL),
                 CATA_ERR_ARGUMENT);
    CHECK_STATUS(cata_decimate(0, NULL, 0, NULL, 0, NULL, NULL, 0, &count, NULL, NULL, NULL),
                 CATA_ERR_MESH);
    CHECK_STATUS(cata_decimate(V, NULL, F, faces, N, new_vertices, new_faces, F, &count, cells, NULL,
                               NULL),
                 CATA_ERR_NULL);
    CHECK_STATUS(cata_decimate(V, vertices, F, faces, N, new_vertices, new_faces, F, NULL, cells,
                               NULL, NULL),
                 CATA_ERR_NULL);
    const uint32_t wrong[3] = {0, 1, V};
    CHECK_STATUS(cata_decimate(V, vertices, 1, wrong, 3, new_vertices, new_faces, F, &count, cells,
                               NULL, NULL),
                 CATA_ERR_MESH);
    CHECK_MENTIONS("face 0");
    int calls = 0;
    cata_decimate_params params = {.struct_size = sizeof params};
    params.progress = cancel;
    params.progress_user = &calls;
    CHECK_STATUS(cata_decimate(V, vertices, F, faces, N, new_vertices, new_faces, F, &count, cells,
                               NULL, &params),
                 CATA_ERR_CANCELLED);
    CHECK(calls == 1);
    params.progress = NULL;
    params.lloyd = -2;
    CHECK_STATUS(cata_decimate(V, vertices, F, faces, N, new_vertices, new_faces, F, &count, cells,
                               NULL, &params),
                 CATA_ERR_ARGUMENT);
    CHECK_MENTIONS("params.lloyd");
    CHECK(count == 5 && new_vertices[0] == 42 && new_faces[0] == 43 && cells[0] == 44);
}

int main(void)
{
    make_torus();
    test_torus();
    test_refusals();
    return report("test_decimate");
}
