/* The water of a plant through the C ABI: closed forms, independence of handles, refusals, outputs untouched. */

#include <catamaran.h>

#include <math.h>
#include <stdio.h>
#include <string.h>

#include "check.h"

#define CHECK_MENTIONS(text) CHECK(strstr(cata_last_error_message(), text) != NULL)

#define N 3

static const double tails[3 * N] = {0, 0, 0.1, 0, 0, 0.2, 0.1, 0, 0.1};
static const double radii[N] = {1e-3, 1e-3, 1e-3};
static const uint32_t parents[N] = {CATA_NO_PARENT, 0, 0};
static const int32_t kinds[N] = {CATA_PLANT_STEM, CATA_PLANT_LEAF, CATA_PLANT_LEAF};
static const double base[3] = {0, 0, 0};

static cata_plant *new_plant(double loss)
{
    cata_plant_params params = {.struct_size = sizeof params, .threads = 1, .loss = loss};
    cata_plant *plant = NULL;
    CHECK_STATUS(cata_plant_new(N, tails, radii, parents, kinds, base, &params, &plant), CATA_OK);
    return plant;
}

/* Two plants of one segment each, in centimetres and millimetres. */
static void test_units_and_individuals(void)
{
    const char *name = "test_plant_units.mtg";
    FILE *file = fopen(name, "w");
    CHECK(file != NULL);
    fputs("MTG:\nTOPO\tLength\tDiameter\n/P1\n^/E1\t1\t4\n/P2\n^/E1\t200\t6\n", file);
    fclose(file);
    const double unit[2] = {1e-2, 1e-3};
    cata_plant *plant = NULL;
    CHECK_STATUS(cata_plant_read_with(name, unit, "P2", NULL, &plant), CATA_OK);
    double end[3], radius, start[3];
    CHECK_STATUS(cata_plant_segments(plant, 1, end, &radius, NULL, NULL, start), CATA_OK);
    const double along[3] = {end[0] - start[0], end[1] - start[1], end[2] - start[2]};
    CHECK(fabs(hypot(hypot(along[0], along[1]), along[2]) - 2) < 1e-14);
    CHECK(fabs(radius - 3e-3) < 1e-17);
    cata_plant_free(plant);
    plant = NULL;
    CHECK_STATUS(cata_plant_read_with(name, NULL, "", NULL, &plant), CATA_ERR_IO);
    CHECK_MENTIONS("P1");
    const double none[2] = {0, 1};
    CHECK_STATUS(cata_plant_read_with(name, none, "P2", NULL, &plant), CATA_ERR_ARGUMENT);
    CHECK_MENTIONS("unit");
    CHECK_STATUS(cata_plant_read_with(NULL, unit, NULL, NULL, &plant), CATA_ERR_NULL);
    CHECK(plant == NULL);
    remove(name);
}

static double sum(const double *water)
{
    return water[0] + water[1] + water[2];
}

static void test_full_water_and_decay(void)
{
    const double pi = acos(-1);
    cata_plant *plant = new_plant(0);
    double full[N], water[N];
    CHECK(cata_plant_size(plant) == N);
    CHECK_STATUS(cata_plant_full_water(plant, N, full), CATA_OK);
    for (int v = 0; v < N; v++) {
        CHECK(fabs(full[v] - 1000 * pi * 1e-6 * 0.1) < 1e-15);
    }
    /* Nothing is lost until leaves lose something. */
    CHECK_STATUS(cata_plant_water_after(plant, N, full, 1e6, water), CATA_OK);
    CHECK(fabs(sum(water) / sum(full) - 1) < 1e-12);
    /* A leaf that is cut off decays alone, at the rate loss r h / full. */
    CHECK_STATUS(cata_plant_set_loss(plant, 2e-5), CATA_OK);
    CHECK_STATUS(cata_plant_weaken(plant, 2, 0), CATA_OK);
    CHECK_STATUS(cata_plant_water_after(plant, N, full, 5e3, water), CATA_OK);
    const double alone = full[2] * exp(-2e-5 * 1e-4 / full[2] * 5e3);
    CHECK(fabs(water[2] - alone) < 1e-12 * full[2]);
    /* In place. */
    CHECK_STATUS(cata_plant_water_after(plant, N, full, 5e3, full), CATA_OK);
    CHECK(memcmp(full, water, sizeof full) == 0);
    cata_plant_free(plant);
}

static void test_literal_elasticity(void)
{
    const cata_plant_params params = {.struct_size = sizeof params, .threads = 1, .elasticity_full = 3e7,
        .elasticity_steepness = 2, .elasticity_shift = 0.1, .elasticity_literal = 1};
    cata_plant *plant = NULL;
    double full[N], moduli[N];
    CHECK_STATUS(cata_plant_new(N, tails, radii, parents, kinds, base, &params, &plant), CATA_OK);
    CHECK_STATUS(cata_plant_full_water(plant, N, full), CATA_OK);
    CHECK_STATUS(cata_plant_stiffness(plant, N, full, moduli), CATA_OK);
    for (int v = 0; v < N; v++) {
        CHECK(fabs(moduli[v] - 3e7 / (1 + exp(-2 * (1e3 * full[v] - 0.1)))) < 1e-6);
    }
    cata_plant_free(plant);
    cata_plant_params wrong = params;
    wrong.elasticity_literal = 2;
    CHECK_STATUS(cata_plant_new(N, tails, radii, parents, kinds, base, &wrong, &plant), CATA_ERR_ARGUMENT);
    CHECK_MENTIONS("elasticity_literal");
    wrong = params;
    wrong.elasticity_dry = 1e5;
    CHECK_STATUS(cata_plant_new(N, tails, radii, parents, kinds, base, &wrong, &plant), CATA_ERR_ARGUMENT);
    CHECK_MENTIONS("elasticity_dry");
}

static void test_steps_and_independent_handles(void)
{
    cata_plant *a = new_plant(2e-5), *b = new_plant(1e-5);
    double full[N], by_a[N], by_b[N], exact[N], moduli[N];
    CHECK_STATUS(cata_plant_full_water(a, N, full), CATA_OK);
    CHECK_STATUS(cata_plant_start(a, N, NULL, 100), CATA_OK);
    CHECK_STATUS(cata_plant_start(b, N, full, 100), CATA_OK);
    for (int i = 0; i < 50; i++) {
        CHECK_STATUS(cata_plant_step(a, 1, N, by_a), CATA_OK);
        CHECK_STATUS(cata_plant_step(b, 1, 0, NULL), CATA_OK);
    }
    CHECK_STATUS(cata_plant_step(b, 0, N, by_b), CATA_OK);
    CHECK_STATUS(cata_plant_water_after(a, N, full, 5e3, exact), CATA_OK);
    CHECK(fabs(sum(by_a) - sum(exact)) < 1e-8 * sum(full));
    CHECK_STATUS(cata_plant_water_after(b, N, full, 5e3, exact), CATA_OK);
    CHECK(fabs(sum(by_b) - sum(exact)) < 1e-8 * sum(full));
    /* A change counts from the next step on. */
    CHECK_STATUS(cata_plant_set_loss(a, 0), CATA_OK);
    CHECK_STATUS(cata_plant_set_intake(a, 1e-9), CATA_OK);
    CHECK_STATUS(cata_plant_step(a, 10, N, exact), CATA_OK);
    CHECK(fabs(sum(exact) - sum(by_a) - 1e-6) < 1e-11 * sum(full));
    CHECK_STATUS(cata_plant_stiffness(a, N, full, moduli), CATA_OK);
    CHECK(fabs(moduli[0] - 5e7) < 1);
    cata_plant_free(a);
    cata_plant_free(b);
    cata_plant_free(NULL);
}

/* Water at many times is that at each of them; a day of two parts is one after the other. */
static void test_curves_and_rates(void)
{
    cata_plant *plant = new_plant(2e-5);
    double full[N], curve[3 * N], exact[N], rates[N];
    const double times[3] = {0, 1e3, 5e3}, late = 5e3, day[4] = {1e3, 2e-5, 9e3, 0};
    CHECK_STATUS(cata_plant_full_water(plant, N, full), CATA_OK);
    CHECK_STATUS(cata_plant_water_curve(plant, N, NULL, 3, times, 0, NULL, curve), CATA_OK);
    CHECK(memcmp(curve, full, sizeof full) == 0);
    CHECK_STATUS(cata_plant_water_after(plant, N, full, 5e3, exact), CATA_OK);
    for (int v = 0; v < N; v++) {
        CHECK(fabs(curve[2 * N + v] - exact[v]) < 1e-11 * full[v]);
    }
    /* Nothing is lost in the second part. */
    const double dried = sum(curve + N);
    CHECK_STATUS(cata_plant_water_curve(plant, N, full, 1, &late, 2, day, curve), CATA_OK);
    CHECK(fabs(sum(curve) / dried - 1) < 1e-11 && dried < 0.997 * sum(full));
    CHECK_STATUS(cata_plant_water_curve(plant, N, NULL, 0, NULL, 0, NULL, NULL), CATA_OK);
    /* A leaf that is cut off decays at its own rate. */
    CHECK_STATUS(cata_plant_weaken(plant, 2, 0), CATA_OK);
    CHECK_STATUS(cata_plant_rates(plant, N, rates), CATA_OK);
    const double own = 2e-5 * 1e-4 / full[2];
    CHECK(rates[0] <= rates[1] && rates[1] <= rates[2]);
    CHECK(fmin(fabs(rates[0] - own), fabs(rates[1] - own)) < 1e-9 * own + 1e-14 * rates[2]);
    cata_plant_free(plant);
}

/* What a plant is made of, taken out and put in again; a pin is a pin. */
static void test_segments(void)
{
    enum { MANY = 40 };
    cata_plant *plant = NULL, *again = NULL;
    double ends[3 * MANY], wide[MANY], root[3], one[MANY], other[MANY];
    uint32_t above[MANY];
    int32_t what[MANY], found[MANY];
    CHECK_STATUS(cata_plant_grow(MANY, 5, NULL, &plant), CATA_OK);
    CHECK(cata_plant_size(plant) == MANY);
    CHECK_STATUS(cata_plant_segments(plant, MANY, ends, wide, above, what, root), CATA_OK);
    CHECK(above[0] == CATA_NO_PARENT);
    what[7] |= CATA_PLANT_PINNED;
    CHECK_STATUS(cata_plant_new(MANY, ends, wide, above, what, root, NULL, &again), CATA_OK);
    CHECK_STATUS(cata_plant_segments(again, MANY, NULL, NULL, NULL, found, NULL), CATA_OK);
    CHECK(memcmp(what, found, sizeof what) == 0);
    CHECK_STATUS(cata_plant_full_water(plant, MANY, one), CATA_OK);
    CHECK_STATUS(cata_plant_full_water(again, MANY, other), CATA_OK);
    CHECK(memcmp(one, other, sizeof one) == 0);
    cata_plant_free(plant);
    cata_plant_free(again);
}

static void test_threads(void)
{
    enum { MANY = 3000 };
    static double first[2 * MANY], here[2 * MANY];
    const double times[2] = {1e4, 1e5};
    for (size_t threads = 1; threads <= 4; threads *= 2) {
        cata_plant_params params = {.struct_size = sizeof params, .threads = threads, .loss = 1e-5};
        cata_plant *plant = NULL;
        CHECK_STATUS(cata_plant_grow(MANY, 1, &params, &plant), CATA_OK);
        double *to = threads == 1 ? first : here;
        CHECK_STATUS(cata_plant_water_curve(plant, MANY, NULL, 2, times, 0, NULL, to), CATA_OK);
        CHECK(threads == 1 || memcmp(first, here, sizeof first) == 0);
        cata_plant_free(plant);
    }
}

/* Stops at the call whose number comes to 0. */
static int32_t count_down(double fraction, void *user)
{
    CHECK(0 < fraction && fraction <= 1);
    return --*(int *)user == 0;
}

static void test_cancel(void)
{
    int left = 1;
    cata_plant_params params = {.struct_size = sizeof params, .threads = 1, .loss = 1e-5};
    params.progress = count_down;
    params.progress_user = &left;
    cata_plant *plant = NULL;
    const double times[3] = {1, 2, 3};
    double full[N], water[3 * N] = {5}, exact[N];
    CHECK_STATUS(cata_plant_new(N, tails, radii, parents, kinds, base, &params, &plant), CATA_OK);
    CHECK_STATUS(cata_plant_full_water(plant, N, full), CATA_OK);
    CHECK_STATUS(cata_plant_water_after(plant, N, full, 60, water), CATA_ERR_CANCELLED);
    left = 2;
    CHECK_STATUS(cata_plant_water_curve(plant, N, full, 3, times, 0, NULL, water), CATA_ERR_CANCELLED);
    CHECK(left == 0 && water[0] == 5);
    /* Two steps of five are done, and it goes on. */
    CHECK_STATUS(cata_plant_start(plant, N, NULL, 100), CATA_OK);
    left = 2;
    CHECK_STATUS(cata_plant_step(plant, 5, N, water), CATA_ERR_CANCELLED);
    CHECK(water[0] == 5);
    CHECK_STATUS(cata_plant_step(plant, 3, N, water), CATA_OK);
    CHECK_STATUS(cata_plant_water_after(plant, N, full, 500, exact), CATA_OK);
    CHECK(fabs(sum(water) - sum(exact)) < 1e-8 * sum(full));
    cata_plant_free(plant);
}

static void test_refusals(void)
{
    cata_plant *plant = NULL;
    const uint32_t cycle[N] = {CATA_NO_PARENT, 2, 1}, two_roots[N] = {CATA_NO_PARENT, 0, CATA_NO_PARENT};
    const double thin[N] = {1e-3, 0, 1e-3};
    CHECK_STATUS(cata_plant_new(N, tails, radii, cycle, kinds, base, NULL, &plant), CATA_ERR_MESH);
    CHECK_MENTIONS("node 1: is on a cycle");
    CHECK_STATUS(cata_plant_new(N, tails, radii, two_roots, kinds, base, NULL, &plant), CATA_ERR_MESH);
    CHECK_MENTIONS("node 2: is isolated");
    CHECK_STATUS(cata_plant_new(N, tails, thin, parents, kinds, base, NULL, &plant), CATA_ERR_MESH);
    CHECK_MENTIONS("node 1: radius must be positive and finite, is 0");
    CHECK_STATUS(cata_plant_new(0, NULL, NULL, NULL, NULL, NULL, NULL, &plant), CATA_ERR_ARGUMENT);
    CHECK_STATUS(cata_plant_new(N, NULL, radii, parents, kinds, base, NULL, &plant), CATA_ERR_NULL);
    CHECK_MENTIONS("tails");
    CHECK_STATUS(cata_plant_new((size_t)-1, tails, radii, parents, kinds, base, NULL, &plant), CATA_ERR_SHAPE);
    cata_plant_params params = {.struct_size = sizeof params, .loss = -1};
    CHECK_STATUS(cata_plant_new(N, tails, radii, parents, kinds, NULL, &params, &plant), CATA_ERR_ARGUMENT);
    CHECK_MENTIONS("loss");
    params.loss = 0;
    params.elasticity_dry = 6e7;
    CHECK_STATUS(cata_plant_new(N, tails, radii, parents, kinds, NULL, &params, &plant), CATA_ERR_ARGUMENT);
    CHECK_MENTIONS("above the dry modulus of 60000000 Pa");
    const int32_t odd[N] = {0, 1, 4};
    CHECK_STATUS(cata_plant_new(N, tails, radii, parents, odd, NULL, NULL, &plant), CATA_ERR_ARGUMENT);
    CHECK_MENTIONS("kinds: 4 of node 2");
    CHECK_STATUS(cata_plant_grow(0, 1, NULL, &plant), CATA_ERR_ARGUMENT);
    params.struct_size = 3;
    CHECK_STATUS(cata_plant_new(N, tails, radii, parents, kinds, NULL, &params, &plant), CATA_ERR_ARGUMENT);
    CHECK_STATUS(cata_plant_read("/nowhere/plant.txt", NULL, &plant), CATA_ERR_IO);
    CHECK_STATUS(cata_plant_read(NULL, NULL, &plant), CATA_ERR_NULL);
    CHECK(plant == NULL);

    plant = new_plant(1e-5);
    double water[N] = {5, 5, 5};
    CHECK_STATUS(cata_plant_step(plant, 1, N, water), CATA_ERR_ARGUMENT);
    CHECK_MENTIONS("cata_plant_start");
    CHECK_STATUS(cata_plant_full_water(plant, 2, water), CATA_ERR_SHAPE);
    CHECK_MENTIONS("must be 3");
    CHECK_STATUS(cata_plant_full_water(NULL, N, water), CATA_ERR_NULL);
    CHECK_STATUS(cata_plant_weaken(plant, 0, 0.5), CATA_ERR_ARGUMENT);
    CHECK_STATUS(cata_plant_weaken(plant, N, 0.5), CATA_ERR_ARGUMENT);
    CHECK_STATUS(cata_plant_start(plant, N, NULL, 0), CATA_ERR_ARGUMENT);
    const double wrong[N] = {1, NAN, 1};
    CHECK_STATUS(cata_plant_water_after(plant, N, wrong, 1, water), CATA_ERR_NON_FINITE);
    CHECK_STATUS(cata_plant_water_after(plant, N, radii, -1, water), CATA_ERR_ARGUMENT);
    CHECK_MENTIONS("seconds");
    CHECK_STATUS(cata_plant_rates(plant, 2, water), CATA_ERR_SHAPE);
    CHECK_STATUS(cata_plant_segments(plant, 4, water, NULL, NULL, NULL, NULL), CATA_ERR_SHAPE);
    const double back[2] = {2, 1}, intervals[2] = {0, 1};
    CHECK_STATUS(cata_plant_water_curve(plant, N, NULL, 2, back, 0, NULL, water), CATA_ERR_ARGUMENT);
    CHECK_MENTIONS("times");
    CHECK_STATUS(cata_plant_water_curve(plant, N, NULL, 1, back, 1, intervals, water), CATA_ERR_ARGUMENT);
    CHECK_MENTIONS("interval");
    CHECK_STATUS(cata_plant_water_curve(plant, N, NULL, 1, NULL, 0, NULL, water), CATA_ERR_NULL);
    CHECK_STATUS(cata_plant_water_curve(plant, N, NULL, (size_t)-1, back, 0, NULL, water), CATA_ERR_SHAPE);
    CHECK(water[0] == 5 && water[2] == 5);
    CHECK(cata_plant_size(NULL) == 0);
    cata_plant_free(plant);
}

int main(void)
{
    test_full_water_and_decay();
    test_units_and_individuals();
    test_literal_elasticity();
    test_steps_and_independent_handles();
    test_curves_and_rates();
    test_segments();
    test_threads();
    test_cancel();
    test_refusals();
    return report("test_plant");
}
