/* Rods through the C ABI: beam theory, tubes, wilting as the sum of its steps, cancelling, refusals, outputs untouched. */

#include <catamaran.h>

#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "check.h"

#define CHECK_MENTIONS(text) CHECK(strstr(cata_last_error_message(), text) != NULL)

enum { N = 60 };

/* A straight chain of N segments along x (0) or z (2), 1 m long. */
static cata_plant *chain(int axis, int32_t last)
{
    double tails[3 * N] = {0}, radii[N];
    const double base[3] = {0, 0, 0};
    uint32_t parents[N];
    int32_t kinds[N] = {0};
    for (int v = 0; v < N; v++) {
        tails[3 * v + axis] = (v + 1.0) / N;
        radii[v] = 1e-3;
        parents[v] = v == 0 ? CATA_NO_PARENT : (uint32_t)(v - 1);
    }
    kinds[N - 1] = last;
    cata_plant *plant = NULL;
    CHECK_STATUS(cata_plant_new(N, tails, radii, parents, kinds, base, NULL, &plant), CATA_OK);
    return plant;
}

static cata_plant_rods *rods_of(cata_plant *plant, const cata_plant_rods_params *params)
{
    cata_plant_rods *rods = NULL;
    CHECK_STATUS(cata_plant_rods_new(plant, params, &rods), CATA_OK);
    return rods;
}

/* A load near the end of a cantilever: P a^2 (3 L - a) / 6 E I, by relaxing, and in the end by moving too. */
static void test_cantilever(void)
{
    const double pi = acos(-1), stiffness = 1e9 * pi * 1e-12 / 4, mass = 1e-4 * stiffness;
    const double a = 1 - 0.5 / N, exact = mass * 9.81 * a * a * (3 - a) / (6 * stiffness);
    cata_plant *plant = chain(0, CATA_PLANT_STEM);
    cata_plant_rods_params params = {.struct_size = sizeof params, .dry_density = 1e-9};
    cata_plant_rods *rods = rods_of(plant, &params);
    cata_plant_free(plant);
    double moduli[N], water[N] = {0}, tails[3 * N], rotations[4 * N], before[4 * N], residual = 1;
    for (int v = 0; v < N; v++) {
        moduli[v] = 1e9;
    }
    water[N - 1] = mass;
    size_t iterations = 0;
    CHECK_STATUS(cata_plant_rods_set_state(rods, N, moduli, water), CATA_OK);
    CHECK_STATUS(cata_plant_rods_relax(rods, &iterations, &residual), CATA_OK);
    CHECK(0 < iterations && iterations <= 30 && residual <= 1e-8);
    CHECK_STATUS(cata_plant_rods_pose(rods, N, NULL, tails, rotations), CATA_OK);
    CHECK(fabs(-tails[3 * N - 1] / exact - 1) < 1e-3);
    /* The pose is given back and taken; at its balance nothing is left to do. */
    CHECK_STATUS(cata_plant_rods_set_pose(rods, N, NULL), CATA_OK);
    CHECK_STATUS(cata_plant_rods_pose(rods, N, NULL, tails, before), CATA_OK);
    CHECK(tails[3 * N - 1] == 0 && before[4 * N - 4] == 1);
    CHECK_STATUS(cata_plant_rods_set_pose(rods, N, rotations), CATA_OK);
    CHECK_STATUS(cata_plant_rods_relax(rods, &iterations, NULL), CATA_OK);
    CHECK(iterations <= 1);
    cata_plant_rods_free(rods);
    cata_plant_rods_free(NULL);
}

/* A plant that moves and is damped comes to where relaxing leads; its segments stay together. */
static void test_motion(void)
{
    cata_plant *plant = NULL;
    CHECK_STATUS(cata_plant_grow(N, 2, NULL, &plant), CATA_OK);
    cata_plant_rods_params params = {.struct_size = sizeof params, .damping = 20, .step = 0.02};
    cata_plant_rods *moving = rods_of(plant, &params), *resting = rods_of(plant, NULL);
    double here[3 * N], there[3 * N], heads[3 * N], gap = -1, full[N], moduli[N];
    CHECK_STATUS(cata_plant_rods_step(moving, 1, NULL), CATA_OK);
    CHECK_STATUS(cata_plant_rods_pose(resting, N, heads, there, NULL), CATA_OK);
    CHECK_STATUS(cata_plant_rods_pose(moving, N, NULL, here, NULL), CATA_OK);
    CHECK(here[3 * N - 1] != there[3 * N - 1] && heads[0] == 0);
    CHECK_STATUS(cata_plant_rods_step(moving, 400, &gap), CATA_OK);
    CHECK(0 <= gap && gap < 1e-6);
    CHECK_STATUS(cata_plant_rods_relax(resting, NULL, NULL), CATA_OK);
    CHECK_STATUS(cata_plant_rods_pose(resting, N, NULL, there, NULL), CATA_OK);
    CHECK_STATUS(cata_plant_rods_pose(moving, N, NULL, here, NULL), CATA_OK);
    double largest = 0;
    for (int i = 0; i < 3 * N; i++) {
        largest = fmax(largest, fabs(here[i] - there[i]));
    }
    CHECK(largest < 1e-4);
    /* Softer, while it moves: it goes on sinking. */
    CHECK_STATUS(cata_plant_full_water(plant, N, full), CATA_OK);
    for (int v = 0; v < N; v++) {
        moduli[v] = 5e6;
    }
    CHECK_STATUS(cata_plant_rods_set_state(moving, N, moduli, full), CATA_OK);
    CHECK_STATUS(cata_plant_rods_step(moving, 40, NULL), CATA_OK);
    CHECK_STATUS(cata_plant_rods_pose(moving, N, NULL, there, NULL), CATA_OK);
    double sinking = 0;
    for (int v = 0; v < N; v++) {
        sinking += here[3 * v + 2] - there[3 * v + 2];
    }
    CHECK(sinking > 0);
    cata_plant_free(plant);
    cata_plant_rods_free(moving);
    cata_plant_rods_free(resting);
}

/* Upright: rings of vertices around the axis. */
static void test_tubes(void)
{
    enum { SIDES = 5 };
    cata_plant *plant = chain(2, CATA_PLANT_LEAF);
    cata_plant_rods *rods = rods_of(plant, NULL);
    static double vertices[6 * N * SIDES];
    static uint32_t faces[6 * N * SIDES];
    CHECK_STATUS(cata_plant_rods_tubes(rods, N, SIDES, 2e-3, vertices, faces), CATA_OK);
    int wrong = 0;
    for (int i = 0; i < 2 * N * SIDES; i++) {
        const double *p = vertices + 3 * i;
        const int v = i / (2 * SIDES), at_tail = i / SIDES % 2;
        wrong += fabs(hypot(p[0], p[1]) - 2e-3) > 1e-12;
        wrong += fabs(p[2] - (v + at_tail) / (double)N) > 1e-12;
        for (int k = 0; k < 3; k++) {
            wrong += faces[3 * i + k] / (2 * SIDES) != (uint32_t)v;
        }
    }
    CHECK(wrong == 0);
    CHECK_STATUS(cata_plant_rods_tubes(rods, N, SIDES, 0, NULL, faces), CATA_OK);
    CHECK_STATUS(cata_plant_rods_tubes(rods, N, 2, 0, vertices, NULL), CATA_ERR_ARGUMENT);
    CHECK_MENTIONS("tubes");
    CHECK_STATUS(cata_plant_rods_tubes(rods, N, (size_t)-1, 0, vertices, NULL), CATA_ERR_SHAPE);
    CHECK_STATUS(cata_plant_rods_tubes(rods, N - 1, SIDES, 0, vertices, faces), CATA_ERR_SHAPE);
    cata_plant_rods_free(rods);
    cata_plant_free(plant);
}

/* Wilting is a curve of water, and a pose at each of its times; the same bytes for any threads. */
static void test_wilting(void)
{
    enum { TIMES = 3 };
    static double water[TIMES * N], moduli[TIMES * N], tails[3 * TIMES * N], rotations[4 * TIMES * N];
    static double again[4 * TIMES * N], curve[TIMES * N], here[4 * N];
    const double times[TIMES] = {0, 1e6, 3e6}, day[4] = {57600, 2e-4, 28800, 2e-5};
    for (size_t threads = 1; threads <= 4; threads *= 2) {
        cata_plant_params params = {.struct_size = sizeof params, .threads = threads};
        cata_plant *plant = NULL;
        CHECK_STATUS(cata_plant_grow(N, 3, &params, &plant), CATA_OK);
        if (threads > 1) {
            CHECK_STATUS(cata_plant_wilt(plant, NULL, TIMES, times, 2, day, N, NULL, NULL, NULL, again),
                         CATA_OK);
            CHECK(memcmp(again, rotations, sizeof rotations) == 0);
            cata_plant_free(plant);
            continue;
        }
        cata_plant_rods *rods = rods_of(plant, NULL);
        CHECK_STATUS(cata_plant_wilt(plant, rods, TIMES, times, 2, day, N, water, moduli, tails, rotations),
                     CATA_OK);
        CHECK_STATUS(cata_plant_water_curve(plant, N, NULL, TIMES, times, 2, day, curve), CATA_OK);
        CHECK(memcmp(water, curve, sizeof water) == 0);
        double heights[TIMES] = {0};
        for (int i = 0; i < TIMES; i++) {
            CHECK_STATUS(cata_plant_stiffness(plant, N, water + i * N, here), CATA_OK);
            CHECK(memcmp(here, moduli + i * N, N * sizeof *here) == 0);
            CHECK_STATUS(cata_plant_rods_set_state(rods, N, here, water + i * N), CATA_OK);
            CHECK_STATUS(cata_plant_rods_relax(rods, NULL, NULL), CATA_OK);
            CHECK_STATUS(cata_plant_rods_pose(rods, N, NULL, NULL, here), CATA_OK);
            CHECK(memcmp(here, rotations + 4 * i * N, sizeof here) == 0);
            for (int v = 0; v < N; v++) {
                heights[i] += tails[3 * (i * N + v) + 2];
            }
        }
        CHECK(heights[1] < heights[0] && heights[2] < heights[0]);
        CHECK_STATUS(cata_plant_wilt(plant, rods, 0, NULL, 0, NULL, N, NULL, NULL, NULL, NULL), CATA_OK);
        cata_plant *other = chain(2, CATA_PLANT_LEAF);
        again[0] = 7;
        CHECK_STATUS(cata_plant_wilt(other, rods, 1, times, 0, NULL, N, NULL, NULL, NULL, again),
                     CATA_ERR_ARGUMENT);
        CHECK_MENTIONS("rods");
        CHECK_STATUS(cata_plant_wilt(plant, rods, 1, times, 0, NULL, N - 1, NULL, NULL, NULL, again),
                     CATA_ERR_SHAPE);
        CHECK_STATUS(cata_plant_wilt(plant, rods, (size_t)-1, times, 0, NULL, N, NULL, NULL, NULL, again),
                     CATA_ERR_SHAPE);
        CHECK(again[0] == 7);
        cata_plant_free(other);
        cata_plant_rods_free(rods);
        cata_plant_free(plant);
    }
}

/* Stops at the call whose number comes to 0. */
static int32_t count_down(double fraction, void *user)
{
    CHECK(0 <= fraction && fraction <= 1);
    return --*(int *)user == 0;
}

static void test_cancel(void)
{
    int left = 2;
    cata_plant *plant = NULL;
    cata_plant_params of_plant = {.struct_size = sizeof of_plant};
    of_plant.progress = count_down;
    of_plant.progress_user = &left;
    CHECK_STATUS(cata_plant_grow(N, 2, &of_plant, &plant), CATA_OK);
    cata_plant_rods_params params = {.struct_size = sizeof params};
    params.progress = count_down;
    params.progress_user = &left;
    cata_plant_rods *rods = rods_of(plant, &params);
    double one[3 * N], other[3 * N], gap = 7, residual = 7;
    CHECK_STATUS(cata_plant_rods_step(rods, 5, &gap), CATA_ERR_CANCELLED);
    CHECK_STATUS(cata_plant_rods_step(rods, 3, NULL), CATA_OK);
    CHECK_STATUS(cata_plant_rods_pose(rods, N, NULL, one, NULL), CATA_OK);
    CHECK_STATUS(cata_plant_rods_set_pose(rods, N, NULL), CATA_OK);
    CHECK_STATUS(cata_plant_rods_step(rods, 5, NULL), CATA_OK);
    CHECK_STATUS(cata_plant_rods_pose(rods, N, NULL, other, NULL), CATA_OK);
    CHECK(memcmp(one, other, sizeof one) == 0);
    left = 1;
    CHECK_STATUS(cata_plant_rods_relax(rods, NULL, &residual), CATA_ERR_CANCELLED);
    left = 3;
    const double time = 1e5;
    one[0] = 7;
    CHECK_STATUS(cata_plant_wilt(plant, rods, 1, &time, 0, NULL, N, NULL, NULL, one, NULL),
                 CATA_ERR_CANCELLED);
    CHECK(gap == 7 && residual == 7 && left == 0 && one[0] == 7);
    cata_plant_rods_free(rods);
    cata_plant_free(plant);
}

static void test_refusals(void)
{
    cata_plant *plant = chain(0, CATA_PLANT_STEM);
    cata_plant_rods *rods = NULL;
    cata_plant_rods_params params;
    CHECK_STATUS(cata_plant_rods_params_init(&params, sizeof params), CATA_OK);
    params.poisson = 0.6;
    CHECK_STATUS(cata_plant_rods_new(plant, &params, &rods), CATA_ERR_ARGUMENT);
    CHECK_MENTIONS("poisson");
    params.poisson = 0;
    params.tolerance = 1;
    CHECK_STATUS(cata_plant_rods_new(plant, &params, &rods), CATA_ERR_ARGUMENT);
    CHECK_MENTIONS("params.tolerance");
    params.tolerance = 0;
    params.step = -1;
    CHECK_STATUS(cata_plant_rods_new(plant, &params, &rods), CATA_ERR_ARGUMENT);
    CHECK_MENTIONS("step");
    CHECK_STATUS(cata_plant_rods_new(NULL, NULL, &rods), CATA_ERR_NULL);
    CHECK_STATUS(cata_plant_rods_new(plant, NULL, NULL), CATA_ERR_NULL);
    CHECK(rods == NULL);
    params.step = 0;
    params.iterations = 1;
    rods = rods_of(plant, &params);
    double moduli[N] = {0}, water[N] = {0}, tails[3 * N] = {7}, rotations[4 * N] = {0};
    CHECK_STATUS(cata_plant_rods_set_state(rods, N, moduli, water), CATA_ERR_ARGUMENT);
    CHECK_MENTIONS("moduli");
    CHECK_STATUS(cata_plant_rods_set_state(rods, N - 1, moduli, water), CATA_ERR_SHAPE);
    CHECK_STATUS(cata_plant_rods_set_state(rods, N, NULL, water), CATA_ERR_NULL);
    CHECK_STATUS(cata_plant_rods_set_pose(rods, N, rotations), CATA_ERR_ARGUMENT);
    CHECK_MENTIONS("rotations");
    rotations[6] = NAN;
    rotations[0] = 1;
    CHECK_STATUS(cata_plant_rods_set_pose(rods, N, rotations), CATA_ERR_NON_FINITE);
    CHECK_STATUS(cata_plant_rods_set_pose(rods, 1, rotations), CATA_ERR_SHAPE);
    CHECK_STATUS(cata_plant_rods_pose(rods, N + 1, NULL, tails, NULL), CATA_ERR_SHAPE);
    CHECK_STATUS(cata_plant_rods_pose(NULL, N, NULL, tails, NULL), CATA_ERR_NULL);
    CHECK_STATUS(cata_plant_rods_step(NULL, 1, NULL), CATA_ERR_NULL);
    CHECK(tails[0] == 7);
    CHECK_STATUS(cata_plant_rods_relax(rods, NULL, NULL), CATA_ERR_NOT_CONVERGED);
    cata_plant_rods_free(rods);
    cata_plant_free(plant);
}

int main(void)
{
    test_cantilever();
    test_motion();
    test_tubes();
    test_wilting();
    test_cancel();
    test_refusals();
    return report("test_rods");
}
