/* Curves through the C ABI: an exact case, outcomes, refusals, outputs untouched. */

#include <catamaran.h>

#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "check.h"

#define CHECK_MENTIONS(text) CHECK(strstr(cata_last_error_message(), text) != NULL)

/* Squares of side 1, N x N of them, each cut in two. */
enum { N = 6, VERTICES = (N + 1) * (N + 1), FACES = 2 * N * N };
static double vertices[3 * VERTICES];
static uint32_t faces[3 * FACES];

static uint32_t at(int x, int y) { return (uint32_t)(y * (N + 1) + x); }

static void make_grid(void)
{
    for (int y = 0; y <= N; y++) {
        for (int x = 0; x <= N; x++) {
            vertices[3 * at(x, y)] = x;
            vertices[3 * at(x, y) + 1] = y;
        }
    }
    uint32_t *t = faces;
    for (int y = 0; y < N; y++) {
        for (int x = 0; x < N; x++, t += 6) {
            t[0] = t[3] = at(x, y);
            t[1] = at(x + 1, y);
            t[2] = t[4] = at(x + 1, y + 1);
            t[5] = at(x, y + 1);
        }
    }
}

static cata_curve_solver *solver;

static cata_status find(size_t count, const uint32_t *samples, const cata_curve_params *params,
                        cata_curves **curves)
{
    return cata_curve_solver_find(solver, count, samples, params, curves);
}

static void test_square(void)
{
    const uint32_t corners[4] = {at(1, 1), at(5, 5), at(5, 1), at(1, 5)};
    cata_curve_params params;
    CHECK_STATUS(cata_curve_params_init(&params, sizeof params), CATA_OK);
    for (int faithful = 0; faithful < 2; faithful++) {
        cata_curves *curves = NULL;
        params.faithful = faithful;
        CHECK_STATUS(find(4, corners, &params, &curves), CATA_OK);
        int32_t outcome = -1;
        size_t count = 0, left_out = 7, samples = 0, n = 0, n_points = 0;
        double length = 0, points[3 * 16];
        uint32_t order[4], path[16];
        CHECK_STATUS(cata_curves_outcome(curves, &outcome, &count, &left_out), CATA_OK);
        CHECK(outcome == CATA_CURVE_CLOSED && count == 1 && left_out == 0);
        CHECK_STATUS(cata_curves_size(curves, 0, &samples, &n, &n_points, &length), CATA_OK);
        CHECK(samples == 4 && n == 16 && n_points == 16 && length == 16);
        CHECK_STATUS(cata_curves_get(curves, 0, order, path, points), CATA_OK);
        CHECK(order[0] == 0 && order[2] == 1 && path[0] == at(1, 1));
        CHECK(points[0] == 1 && points[1] == 1 && points[2] == 0);
        CHECK_STATUS(cata_curves_get(curves, 1, order, path, points), CATA_ERR_ARGUMENT);
        CHECK_MENTIONS("curve: must be less than 1 (curves), is 1");
        CHECK_STATUS(cata_curves_size(curves, 0, NULL, NULL, NULL, NULL), CATA_OK);
        cata_curves_free(curves);
    }
}

/* Points of a curve are on faces of the mesh that was given, without what was inserted. */
static void check_places(const cata_curve_solver *from, const cata_curves *curves)
{
    size_t n_points = 0;
    double points[3 * 64], weights[3 * 64];
    uint32_t on[64];
    CHECK_STATUS(cata_curves_size(curves, 0, NULL, NULL, &n_points, NULL), CATA_OK);
    CHECK(n_points > 3 && n_points <= 64);
    CHECK_STATUS(cata_curves_get(curves, 0, NULL, NULL, points), CATA_OK);
    CHECK_STATUS(cata_curves_places(curves, from, 0, on, weights), CATA_OK);
    for (size_t i = 0; i < n_points; i++) {
        CHECK(on[i] < FACES);
        for (size_t k = 0; k < 3; k++) {
            double at = 0;
            for (size_t j = 0; j < 3; j++) {
                at += weights[3 * i + j] * vertices[3 * faces[3 * on[i] + j] + k];
            }
            CHECK(fabs(at - points[3 * i + k]) < 1e-12);
        }
    }
    CHECK_STATUS(cata_curves_places(curves, from, 1, on, weights), CATA_ERR_ARGUMENT);
}

/* Samples around the border of the grid, 1 apart, and a stray in its middle. */
static void test_outliers(void)
{
    uint32_t samples[4 * N + 1];
    size_t n = 0;
    for (int i = 0; i < N; i++) {
        samples[n++] = at(i, 0);
        samples[n++] = at(N, i);
        samples[n++] = at(N - i, N);
        samples[n++] = at(0, N - i);
    }
    samples[n++] = at(3, 3);
    cata_curve_params params;
    CHECK_STATUS(cata_curve_params_init(&params, sizeof params), CATA_OK);
    for (int drop = 0; drop < 2; drop++) {
        cata_curves *curves = NULL;
        size_t count = 7;
        uint32_t which[1] = {7};
        double length = 0;
        params.drop_outliers = drop;
        CHECK_STATUS(find(n, samples, &params, &curves), CATA_OK);
        CHECK_STATUS(cata_curves_outliers(curves, &count, NULL), CATA_OK);
        CHECK(count == (size_t)drop);
        CHECK_STATUS(cata_curves_outliers(curves, NULL, which), CATA_OK);
        CHECK(which[0] == (uint32_t)(drop ? 4 * N : 7));
        CHECK_STATUS(cata_curves_size(curves, 0, NULL, NULL, NULL, &length), CATA_OK);
        CHECK(drop ? length == 4 * N : length > 4 * N);
        cata_curves_free(curves);
    }
    cata_curves *none = NULL;
    params.faithful = 1;
    CHECK_STATUS(find(n, samples, &params, &none), CATA_ERR_ARGUMENT);
    CHECK_MENTIONS("drop_outliers");
    CHECK(none == NULL);
}

/* A triangle in the plane, whose sides do not follow edges; samples on faces and in space. */
static void test_smooth_and_sites(void)
{
    const uint32_t corners[3] = {at(1, 1), at(5, 2), at(2, 5)};
    cata_curve_params params = {.struct_size = sizeof params, .smooth = 1};
    cata_curves *curves = NULL;
    double length = 0;
    size_t n_points = 0;
    CHECK_STATUS(find(3, corners, &params, &curves), CATA_OK);
    CHECK_STATUS(cata_curves_size(curves, 0, NULL, NULL, &n_points, &length), CATA_OK);
    check_places(solver, curves);
    CHECK(n_points > 3 && fabs(length - (2 * sqrt(17.0) + sqrt(18.0))) < 1e-9);
    cata_curves_free(curves);

    const uint32_t places[3] = {0, CATA_IN_SPACE, CATA_IN_SPACE};
    const double weights[9] = {0.25, 0.25, 0.5, 5.1, 2.1, 0.3, 2, 5, 0};
    uint32_t samples[3] = {7, 7, 7};
    cata_curve_solver *refined = NULL;
    CHECK_STATUS(cata_curve_solver_new_at(VERTICES, vertices, FACES, faces, 3, places, weights,
                                          samples, &refined),
                 CATA_OK);
    CHECK(samples[0] == VERTICES && samples[1] == at(5, 2) && samples[2] == at(2, 5));
    CHECK_STATUS(cata_curve_solver_find(refined, 3, samples, &params, &curves), CATA_OK);
    check_places(refined, curves);
    CHECK_STATUS(cata_curves_places(curves, solver, 0, NULL, NULL), CATA_ERR_ARGUMENT);
    CHECK_MENTIONS("solver: must be the one that found the curves");
    cata_curves_free(curves);
    cata_curve_solver_free(refined);
    refined = NULL;
    const uint32_t beyond[1] = {FACES};
    CHECK_STATUS(cata_curve_solver_new_at(VERTICES, vertices, FACES, faces, 1, beyond, weights,
                                          samples, &refined),
                 CATA_ERR_ARGUMENT);
    CHECK(refined == NULL && samples[0] == VERTICES);

    /* Two components, one with too few samples. */
    const double six[18] = {0, 0, 0, 1, 0, 0, 0, 1, 0, 9, 0, 0, 8, 0, 0, 9, 1, 0};
    const uint32_t two[6] = {0, 1, 2, 3, 4, 5}, four[4] = {0, 3, 1, 2};
    size_t left_out = 0;
    uint32_t which = 7;
    CHECK_STATUS(cata_curve_solver_new(6, six, 2, two, &refined), CATA_OK);
    CHECK_STATUS(cata_curve_solver_find(refined, 4, four, NULL, &curves), CATA_OK);
    CHECK_STATUS(cata_curves_outcome(curves, NULL, NULL, &left_out), CATA_OK);
    CHECK_STATUS(cata_curves_left_out(curves, &which), CATA_OK);
    CHECK(left_out == 1 && which == 1);
    cata_curves_free(curves);
    cata_curve_solver_free(refined);
}

static int32_t cancel(double fraction, void *user)
{
    (void)fraction;
    ++*(int *)user;
    return 1;
}

static void test_refusals(void)
{
    const uint32_t twice[3] = {1, 2, 1}, beyond[3] = {1, 2, VERTICES}, good[3] = {1, 12, 30};
    cata_curves *curves = NULL;
    CHECK_STATUS(find(3, twice, NULL, &curves), CATA_ERR_ARGUMENT);
    CHECK_MENTIONS("sample 2 is vertex 1, as sample 0");
    CHECK_STATUS(find(3, beyond, NULL, &curves), CATA_ERR_ARGUMENT);
    CHECK_STATUS(find(2, good, NULL, &curves), CATA_ERR_ARGUMENT);
    CHECK_STATUS(find(3, NULL, NULL, &curves), CATA_ERR_NULL);
    CHECK_STATUS(find(3, good, NULL, NULL), CATA_ERR_NULL);
    cata_curve_solver *none = NULL;
    CHECK_STATUS(cata_curve_solver_new(2, vertices, FACES, faces, &none), CATA_ERR_MESH);
    CHECK_STATUS(cata_curve_solver_new(VERTICES, vertices, FACES, faces, NULL), CATA_ERR_NULL);
    CHECK_STATUS(cata_curve_solver_find(NULL, 3, good, NULL, &curves), CATA_ERR_NULL);
    CHECK_MENTIONS("solver: must not be NULL");
    CHECK(none == NULL);
    int calls = 0;
    cata_curve_params params = {.struct_size = sizeof params};
    params.progress = cancel;
    params.progress_user = &calls;
    CHECK_STATUS(find(3, good, &params, &curves), CATA_ERR_CANCELLED);
    CHECK(calls > 0 && curves == NULL);
    params.progress = NULL;
    params.points = 2;
    CHECK_STATUS(find(3, good, &params, &curves), CATA_ERR_ARGUMENT);
    CHECK_MENTIONS("params.points");
    params.points = CATA_CURVE_VERTICES;
    params.open = 2;
    CHECK_STATUS(find(3, good, &params, &curves), CATA_ERR_ARGUMENT);
    CHECK_MENTIONS("params.open");
    int32_t outcome = 7;
    CHECK_STATUS(cata_curves_outcome(NULL, &outcome, NULL, NULL), CATA_ERR_NULL);
    CHECK(outcome == 7 && curves == NULL);
    cata_curves_free(NULL);
}

int main(void)
{
    make_grid();
    CHECK_STATUS(cata_curve_solver_new(VERTICES, vertices, FACES, faces, &solver), CATA_OK);
    test_square();
    test_smooth_and_sites();
    test_outliers();
    test_refusals();
    cata_curve_solver_free(solver);
    cata_curve_solver_free(NULL);
    return report("test_curve");
}
