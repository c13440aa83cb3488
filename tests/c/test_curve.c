/* Curves through the C ABI: an exact case, outcomes, refusals, outputs untouched. */

#include <catamaran.h>

#include <stdlib.h>
#include <string.h>

#include "check.h"

#define CHECK_MENTIONS(text) CHECK(strstr(cata_last_error_message(), text) != NULL)

/* Squares of side 1, N x N of them, each cut in two. */
enum { N = 6, VERTICES = (N + 1) * (N + 1), FACES = 2 * N * N };
static double positions[3 * VERTICES];
static uint32_t triangles[3 * FACES];

static uint32_t at(int x, int y) { return (uint32_t)(y * (N + 1) + x); }

static void make_grid(void)
{
    for (int y = 0; y <= N; y++) {
        for (int x = 0; x <= N; x++) {
            positions[3 * at(x, y)] = x;
            positions[3 * at(x, y) + 1] = y;
        }
    }
    uint32_t *t = triangles;
    for (int y = 0; y < N; y++) {
        for (int x = 0; x < N; x++, t += 6) {
            t[0] = t[3] = at(x, y);
            t[1] = at(x + 1, y);
            t[2] = t[4] = at(x + 1, y + 1);
            t[5] = at(x, y + 1);
        }
    }
}

static cata_status find(size_t count, const uint32_t *samples, const cata_curve_params *params,
                        cata_curves **curves)
{
    return cata_curves_new(VERTICES, positions, FACES, triangles, count, samples, params, curves);
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
        size_t count = 0, samples = 0, vertices = 0;
        double length = 0, points[3 * 16];
        uint32_t order[4], path[16];
        CHECK_STATUS(cata_curves_outcome(curves, &outcome, &count), CATA_OK);
        CHECK(outcome == CATA_CURVE_CLOSED && count == 1);
        CHECK_STATUS(cata_curves_size(curves, 0, &samples, &vertices, &length), CATA_OK);
        CHECK(samples == 4 && vertices == 16 && length == 16);
        CHECK_STATUS(cata_curves_get(curves, 0, order, path, points), CATA_OK);
        CHECK(order[0] == 0 && order[2] == 1 && path[0] == at(1, 1));
        CHECK(points[0] == 1 && points[1] == 1 && points[2] == 0);
        CHECK_STATUS(cata_curves_get(curves, 1, order, path, points), CATA_ERR_ARGUMENT);
        CHECK_MENTIONS("curve: 1 of 1");
        CHECK_STATUS(cata_curves_size(curves, 0, NULL, NULL, NULL), CATA_OK);
        cata_curves_free(curves);
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
    const uint32_t twice[3] = {1, 2, 1}, beyond[3] = {1, 2, VERTICES}, good[3] = {1, 12, 30};
    cata_curves *curves = NULL;
    CHECK_STATUS(find(3, twice, NULL, &curves), CATA_ERR_ARGUMENT);
    CHECK_MENTIONS("sample 2 is vertex 1, as sample 0");
    CHECK_STATUS(find(3, beyond, NULL, &curves), CATA_ERR_ARGUMENT);
    CHECK_STATUS(find(2, good, NULL, &curves), CATA_ERR_ARGUMENT);
    CHECK_STATUS(find(3, NULL, NULL, &curves), CATA_ERR_NULL);
    CHECK_STATUS(find(3, good, NULL, NULL), CATA_ERR_NULL);
    CHECK_STATUS(cata_curves_new(2, positions, FACES, triangles, 3, good, NULL, &curves),
                 CATA_ERR_MESH);
    int calls = 0;
    cata_curve_params params = {.struct_size = sizeof params};
    params.progress = cancel;
    params.progress_user = &calls;
    CHECK_STATUS(find(3, good, &params, &curves), CATA_ERR_CANCELLED);
    CHECK(calls > 0 && curves == NULL);
    params.progress = NULL;
    params.open = 2;
    CHECK_STATUS(find(3, good, &params, &curves), CATA_ERR_ARGUMENT);
    CHECK_MENTIONS("params.open");
    int32_t outcome = 7;
    CHECK_STATUS(cata_curves_outcome(NULL, &outcome, NULL), CATA_ERR_NULL);
    CHECK(outcome == 7 && curves == NULL);
    cata_curves_free(NULL);
}

int main(void)
{
    make_grid();
    test_square();
    test_refusals();
    return report("test_curve");
}
