/* Distances through the C ABI: on a square, where they are known, and around a torus; refusals. */

#include <catamaran.h>

#include <math.h>
#include <string.h>

#include "check.h"
#include "meshes.h"

#define CHECK_MENTIONS(text) CHECK(strstr(cata_last_error_message(), text) != NULL)

enum { SIDE = 21, V = SIDE * SIDE, F = 2 * (SIDE - 1) * (SIDE - 1) };

static double vertices[3 * V], distances[V], again[V];
static uint32_t faces[3 * F], nearest[V], before[V];

static double apart(size_t a, size_t b)
{
    return hypot(vertices[3 * a] - vertices[3 * b], vertices[3 * a + 1] - vertices[3 * b + 1]);
}

static void test_heat(void)
{
    const uint32_t sources[2] = {0, V - 1};
    CHECK_STATUS(cata_distance_edges(V, vertices, F, faces, 2, sources, again, NULL, NULL, NULL),
                 CATA_OK);
    for (int32_t flow = CATA_FLOW_TUFTED; flow <= CATA_FLOW_COTANGENT; flow++) {
        cata_heat *heat = NULL;
        cata_distance_params params;
        CHECK_STATUS(cata_distance_params_init(&params, sizeof params), CATA_OK);
        params.flow = flow;
        params.threads = 1 + (size_t)flow;
        CHECK_STATUS(cata_heat_new(V, vertices, F, faces, &params, &heat), CATA_OK);
        CHECK_STATUS(cata_heat_distances(heat, 2, sources, distances), CATA_OK);
        double wrong = 0;
        for (size_t v = 0; v < V; v++) {
            const double exact = fmin(apart(v, 0), apart(v, V - 1));
            CHECK(distances[v] >= exact - 1e-9 && distances[v] <= again[v] + 1e-9);
            wrong += fabs(distances[v] - exact) / V;
        }
        CHECK(wrong < 0.04);
        CHECK(distances[0] == 0 && distances[V - 1] == 0);
        CHECK_STATUS(cata_heat_distances(heat, 0, NULL, distances), CATA_OK);
        CHECK(isinf(distances[7]));
        const uint32_t beyond = V;
        distances[0] = 5;
        CHECK_STATUS(cata_heat_distances(heat, 1, &beyond, distances), CATA_ERR_ARGUMENT);
        CHECK_MENTIONS("sources");
        CHECK(distances[0] == 5);
        cata_heat_free(heat);
    }
}

static void test_edges(void)
{
    const uint32_t sources[2] = {0, SIDE - 1};
    CHECK_STATUS(cata_distance_edges(V, vertices, F, faces, 2, sources, distances, nearest,
                                     before, NULL),
                 CATA_OK);
    for (size_t v = 0; v < V; v++) {
        const double x = vertices[3 * v], y = vertices[3 * v + 1];
        /* Diagonals go up and right: from the other corner there are none that lead nearer. */
        const double first = fmax(x, y) - fmin(x, y) + sqrt(2) * fmin(x, y), second = x + (1 - y);
        CHECK(fabs(distances[v] - fmin(first, second)) < 1e-12);
        CHECK(nearest[v] == 0 || nearest[v] == SIDE - 1);
        if (before[v] != CATA_NO_VERTEX) {
            CHECK(nearest[before[v]] == nearest[v]);
            CHECK(fabs(distances[before[v]] + apart(v, before[v]) - distances[v]) < 1e-12);
        } else {
            CHECK(v == 0 || v == SIDE - 1);
        }
    }
    cata_distance_params params = {.struct_size = sizeof params, .cutoff = 0.5};
    CHECK_STATUS(cata_distance_edges(V, vertices, F, faces, 2, sources, again, NULL, before,
                                     &params),
                 CATA_OK);
    for (size_t v = 0; v < V; v++) {
        /* At the limit itself, rounding decides. */
        CHECK(fabs(distances[v] - 0.5) < 1e-9 ||
              again[v] == (distances[v] < 0.5 ? distances[v] : INFINITY));
    }
    CHECK(before[V - 1] == CATA_NO_VERTEX);
}

static void test_paths(void)
{
    const uint32_t from = SIDE + SIDE - 2, to = (SIDE - 2) * SIDE + 1;
    const double side = 1 - 2.0 / (SIDE - 1);
    cata_path *path = NULL;
    uint32_t way[V];
    double points[9 * V], length = 0, sum = 0;
    size_t n_vertices = 0, n_points = 0;
    /* Against all diagonals, away from the boundary, where paths stay. */
    CHECK_STATUS(cata_distance_path(V, vertices, F, faces, from, to, 0, NULL, &path), CATA_OK);
    CHECK_STATUS(cata_path_size(path, &n_vertices, &n_points, &length), CATA_OK);
    CHECK(n_vertices == 2 * SIDE - 5 && n_points == n_vertices);
    CHECK(fabs(length - 2 * side) < 1e-12);
    CHECK_STATUS(cata_path_get(path, way, points), CATA_OK);
    CHECK(way[0] == from && way[n_vertices - 1] == to);
    for (size_t i = 0; i < n_vertices && n_vertices <= V; i++) {
        CHECK(memcmp(points + 3 * i, vertices + 3 * way[i], 3 * sizeof *points) == 0);
    }
    cata_path_free(path);
    CHECK_STATUS(cata_distance_path(V, vertices, F, faces, from, to, 1, NULL, &path), CATA_OK);
    CHECK_STATUS(cata_path_size(path, &n_vertices, &n_points, &length), CATA_OK);
    CHECK(n_vertices == 2 * SIDE - 5 && fabs(length - sqrt(2) * side) < 1e-9);
    CHECK(n_points >= 2 && n_points <= 3 * V);
    if (n_points >= 2 && n_points <= 3 * V) {
        CHECK_STATUS(cata_path_get(path, NULL, points), CATA_OK);
        for (size_t i = 1; i < n_points; i++) {
            sum += hypot(points[3 * i] - points[3 * i - 3], points[3 * i + 1] - points[3 * i - 2]);
            CHECK(fabs(points[3 * i] + points[3 * i + 1] - 1) < 1e-9);
        }
        CHECK(fabs(sum - length) < 1e-9);
    }
    cata_path_free(path);
    CHECK_STATUS(cata_distance_path(V, vertices, F, faces, 7, 7, 1, NULL, &path), CATA_OK);
    CHECK_STATUS(cata_path_size(path, &n_vertices, NULL, &length), CATA_OK);
    CHECK(n_vertices == 1 && length == 0);
    cata_path_free(path);
    /* The first face alone: no path leads to the vertices that it has not. */
    CHECK_STATUS(cata_distance_path(V, vertices, 1, faces, 0, V - 1, 1, NULL, &path), CATA_OK);
    CHECK_STATUS(cata_path_size(path, &n_vertices, &n_points, &length), CATA_OK);
    CHECK(n_vertices == 0 && n_points == 0 && isinf(length));
    cata_path_free(path);
}

static void test_exact(void)
{
    const uint32_t sources[2] = {0, SIDE - 1}, beyond = V;
    CHECK_STATUS(cata_distance_exact(V, vertices, F, faces, 2, sources, NULL, distances, NULL),
                 CATA_OK);
    for (size_t v = 0; v < V; v++) {
        CHECK(fabs(distances[v] - fmin(apart(v, 0), apart(v, SIDE - 1))) < 1e-12);
    }
    distances[0] = 5;
    CHECK_STATUS(cata_distance_exact(V, vertices, F, faces, 1, &beyond, NULL, distances, NULL),
                 CATA_ERR_ARGUMENT);
    CHECK_MENTIONS("sources");
    CHECK(distances[0] == 5);

    /* Through three vertices, whose distances are straight. */
    const uint32_t through[3] = {0, 5 * SIDE + 7, SIDE - 1};
    cata_path *path = NULL;
    double points[9 * V], weights[9 * V], length = 0, sum = 0;
    uint32_t of[3 * V], way[3];
    size_t n_vertices = 0, n_points = 0;
    CHECK_STATUS(cata_distance_path_exact(V, vertices, F, faces, 3, through, NULL, NULL, &path),
                 CATA_OK);
    CHECK_STATUS(cata_path_size(path, &n_vertices, &n_points, &length), CATA_OK);
    CHECK(fabs(length - apart(through[0], through[1]) - apart(through[1], through[2])) < 1e-12);
    CHECK(n_vertices == 3 && n_points >= 3 && n_points <= 3 * V);
    if (n_vertices == 3 && n_points <= 3 * V) {
        CHECK_STATUS(cata_path_get(path, way, points), CATA_OK);
        CHECK_STATUS(cata_path_places(path, of, weights), CATA_OK);
        CHECK(memcmp(way, through, sizeof way) == 0);
        for (size_t i = 0; i < n_points; i++) {
            for (size_t k = 0; k < 2; k++) {
                double x = 0;
                for (size_t c = 0; c < 3; c++) {
                    x += weights[3 * i + c] * vertices[3 * faces[3 * of[i] + c] + k];
                }
                CHECK(fabs(x - points[3 * i + k]) < 1e-12);
            }
            sum += i == 0 ? 0
                          : hypot(points[3 * i] - points[3 * i - 3],
                                  points[3 * i + 1] - points[3 * i - 2]);
        }
        CHECK(fabs(sum - length) < 1e-9);
    }
    cata_path_free(path);
    path = NULL;
    CHECK_STATUS(cata_distance_path_exact(V, vertices, F, faces, 1, through, NULL, NULL, &path),
                 CATA_ERR_ARGUMENT);
    CHECK_MENTIONS("through: at least two points");
    const uint32_t wrong[2] = {V, 0};
    CHECK_STATUS(cata_distance_path_exact(V, vertices, F, faces, 2, wrong, NULL, NULL, &path),
                 CATA_ERR_ARGUMENT);
    CHECK_MENTIONS("through: vertex 441 is out of range");
    CHECK(path == NULL);
    CHECK_STATUS(cata_distance_path(V, vertices, F, faces, 0, 1, 0, NULL, &path), CATA_OK);
    CHECK_STATUS(cata_path_places(path, of, weights), CATA_ERR_ARGUMENT);
    CHECK_MENTIONS("cata_distance_path_exact");
    cata_path_free(path);
    /* The first face alone. */
    CHECK_STATUS(cata_distance_path_exact(V, vertices, 1, faces, 2, &through[1], NULL, NULL, &path),
                 CATA_OK);
    CHECK_STATUS(cata_path_size(path, &n_vertices, &n_points, &length), CATA_OK);
    CHECK(n_vertices == 0 && n_points == 0 && isinf(length));
    cata_path_free(path);
}

static void test_points(void)
{
    /* Of face 6, and at the vertex that is nearest to a corner. */
    const uint32_t places[2] = {6, CATA_IN_SPACE};
    const double weights[6] = {0.2, 0.3, 0.5, 1.2, 1.1, 0.4};
    double at[2] = {0, 0};
    for (size_t c = 0; c < 3; c++) {
        for (size_t k = 0; k < 2; k++) {
            at[k] += weights[c] * vertices[3 * faces[3 * 6 + c] + k];
        }
    }
    CHECK_STATUS(cata_distance_exact(V, vertices, F, faces, 1, places, weights, distances, NULL),
                 CATA_OK);
    for (size_t v = 0; v < V; v++) {
        const double exact = hypot(vertices[3 * v] - at[0], vertices[3 * v + 1] - at[1]);
        CHECK(fabs(distances[v] - exact) < 1e-12);
    }
    cata_path *path = NULL;
    double length = 0;
    size_t n_vertices = 7, n_points = 0;
    CHECK_STATUS(cata_distance_path_exact(V, vertices, F, faces, 2, places, weights, NULL, &path),
                 CATA_OK);
    CHECK_STATUS(cata_path_size(path, &n_vertices, &n_points, &length), CATA_OK);
    CHECK(n_vertices == 0 && n_points >= 2 && fabs(length - hypot(1 - at[0], 1 - at[1])) < 1e-12);
    cata_path_free(path);
    const uint32_t beyond[2] = {F, 0};
    path = NULL;
    CHECK_STATUS(cata_distance_path_exact(V, vertices, F, faces, 2, beyond, weights, NULL, &path),
                 CATA_ERR_ARGUMENT);
    CHECK_MENTIONS("through: face 800 is out of range");
    CHECK(path == NULL);
}

static void test_trace(void)
{
    const double along[3] = {3, 4, 0}, weights[3] = {0.2, 0.3, 0.5}, up[3] = {0, 0, 1};
    double points[9 * V], w[9 * V], heading[3], length = 0;
    uint32_t of[3 * V];
    size_t n_points = 0;
    int32_t end = 7;
    cata_path *path = NULL;
    CHECK_STATUS(cata_distance_trace(V, vertices, F, faces, 0, NULL, along, 1, NULL, &path, &end,
                                     heading),
                 CATA_OK);
    CHECK_STATUS(cata_path_size(path, NULL, &n_points, &length), CATA_OK);
    CHECK(end == CATA_TRACE_COMPLETE && length == 1 && n_points >= 2 && n_points <= 3 * V);
    CHECK(fabs(heading[0] - 0.6) < 1e-12 && fabs(heading[1] - 0.8) < 1e-12 && heading[2] == 0);
    if (n_points >= 2 && n_points <= 3 * V) {
        CHECK_STATUS(cata_path_get(path, NULL, points), CATA_OK);
        const double *last = points + 3 * (n_points - 1);
        CHECK(fabs(last[0] - 0.6) < 1e-12 && fabs(last[1] - 0.8) < 1e-12 && last[2] == 0);
        CHECK_STATUS(cata_path_places(path, of, w), CATA_OK);
        CHECK(of[n_points - 1] < F);
        /* From there back. */
        const double back[3] = {-heading[0], -heading[1], -heading[2]};
        cata_path *other = NULL;
        CHECK_STATUS(cata_distance_trace(V, vertices, F, faces, of[n_points - 1],
                                         w + 3 * (n_points - 1), back, 0.5, NULL, &other, &end,
                                         NULL),
                     CATA_OK);
        CHECK_STATUS(cata_path_size(other, NULL, &n_points, NULL), CATA_OK);
        CHECK(n_points >= 2 && n_points <= 3 * V);
        CHECK_STATUS(cata_path_get(other, NULL, points), CATA_OK);
        CHECK(fabs(points[3 * n_points - 3] - 0.3) < 1e-12);
        CHECK(fabs(points[3 * n_points - 2] - 0.4) < 1e-12);
        cata_path_free(other);
    }
    cata_path_free(path);
    CHECK_STATUS(cata_distance_trace(V, vertices, F, faces, 0, NULL, along, 7, NULL, &path, &end,
                                     NULL),
                 CATA_OK);
    CHECK_STATUS(cata_path_size(path, NULL, NULL, &length), CATA_OK);
    CHECK(end == CATA_TRACE_BOUNDARY && fabs(length - 1.25) < 1e-12);
    cata_path_free(path);
    path = NULL;
    end = 7;
    CHECK_STATUS(cata_distance_trace(V, vertices, F, faces, F, weights, along, 1, NULL, &path, &end,
                                     NULL),
                 CATA_ERR_ARGUMENT);
    CHECK_MENTIONS("start: face 800 is out of range");
    CHECK_STATUS(cata_distance_trace(V, vertices, F, faces, 3, weights, up, 1, NULL, &path, &end,
                                     NULL),
                 CATA_ERR_ARGUMENT);
    CHECK_MENTIONS("direction: is perpendicular to face 3");
    CHECK_STATUS(cata_distance_trace(V, vertices, F, faces, 3, weights, along, -1, NULL, &path,
                                     &end, NULL),
                 CATA_ERR_ARGUMENT);
    CHECK_MENTIONS("length: must be finite and at least 0");
    CHECK(path == NULL && end == 7);
}

static int32_t cancel(double fraction, void *user)
{
    (void)fraction;
    ++*(int *)user;
    return 1;
}

static void test_refusals(void)
{
    cata_heat *heat = NULL;
    cata_path *path = NULL;
    const uint32_t beyond = V;
    int calls = 0;
    cata_distance_params params = {.struct_size = sizeof params, .flow = 3};
    CHECK_STATUS(cata_heat_new(V, vertices, F, faces, &params, &heat), CATA_ERR_ARGUMENT);
    CHECK_MENTIONS("params.flow");
    params.flow = 0;
    params.time = -1;
    CHECK_STATUS(cata_heat_new(V, vertices, F, faces, &params, &heat), CATA_ERR_ARGUMENT);
    CHECK_MENTIONS("time");
    distances[0] = 5;
    CHECK_STATUS(cata_distance_edges(V, vertices, F, faces, 1, &beyond, distances, NULL, NULL,
                                     NULL),
                 CATA_ERR_ARGUMENT);
    CHECK_MENTIONS("sources");
    params = (cata_distance_params){.struct_size = sizeof params, .cutoff = -1};
    CHECK_STATUS(cata_distance_edges(V, vertices, F, faces, 0, NULL, distances, NULL, NULL,
                                     &params),
                 CATA_ERR_ARGUMENT);
    CHECK_MENTIONS("cutoff");
    CHECK_STATUS(cata_distance_path(V, vertices, F, faces, 0, V, 0, NULL, &path),
                 CATA_ERR_ARGUMENT);
    CHECK_MENTIONS("to: must be less than");
    CHECK_STATUS(cata_distance_path(V, vertices, F, faces, 0, 1, 2, NULL, &path),
                 CATA_ERR_ARGUMENT);
    CHECK_MENTIONS("straight");
    params = (cata_distance_params){.struct_size = sizeof params, .progress = cancel,
                                    .progress_user = &calls};
    CHECK_STATUS(cata_heat_new(V, vertices, F, faces, &params, &heat), CATA_ERR_CANCELLED);
    CHECK(calls == 1);
    CHECK_STATUS(cata_path_size(NULL, NULL, NULL, NULL), CATA_ERR_NULL);
    CHECK_MENTIONS("path: must not be NULL");
    CHECK_STATUS(cata_heat_distances(NULL, 0, NULL, distances), CATA_ERR_NULL);
    CHECK(heat == NULL && path == NULL && distances[0] == 5);
    cata_heat_free(NULL);
    cata_path_free(NULL);
}

int main(void)
{
    make_square(SIDE, 1, vertices, faces);
    test_heat();
    test_edges();
    test_paths();
    test_exact();
    test_points();
    test_trace();
    test_refusals();
    return report("test_distance");
}
