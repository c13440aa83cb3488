/* The water of a plant through the C ABI: closed forms, independence of handles, refusals, outputs untouched. */

#include <catamaran.h>

#include <math.h>
#include <string.h>

#include "check.h"

#define CHECK_MENTIONS(text) CHECK(strstr(cata_last_error_message(), text) != NULL)

#define N 3

static const double tails[3 * N] = {0, 0, 0.1, 0, 0, 0.2, 0.1, 0, 0.1};
static const double radii[N] = {1e-3, 1e-3, 1e-3};
static const uint32_t parents[N] = {CATA_NO_PARENT, 0, 0};
static const int32_t leaves[N] = {0, 1, 1};
static const double base[3] = {0, 0, 0};

static cata_plant *new_plant(double loss)
{
    cata_plant_params params = {.struct_size = sizeof params, .threads = 1, .loss = loss};
    cata_plant *plant = NULL;
    CHECK_STATUS(cata_plant_new(N, tails, radii, parents, leaves, base, &params, &plant), CATA_OK);
    return plant;
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
    CHECK_STATUS(cata_plant_stiffness(a, N, full, 1e9, 3e5, 8, 0.6, moduli), CATA_OK);
    CHECK(fabs(moduli[0] - 1e9) < 1);
    cata_plant_free(a);
    cata_plant_free(b);
    cata_plant_free(NULL);
}

static void test_refusals(void)
{
    cata_plant *plant = NULL;
    const uint32_t cycle[N] = {CATA_NO_PARENT, 2, 1}, two_roots[N] = {CATA_NO_PARENT, 0, CATA_NO_PARENT};
    const double thin[N] = {1e-3, 0, 1e-3};
    CHECK_STATUS(cata_plant_new(N, tails, radii, cycle, leaves, base, NULL, &plant), CATA_ERR_MESH);
    CHECK_MENTIONS("node 1: on a cycle");
    CHECK_STATUS(cata_plant_new(N, tails, radii, two_roots, leaves, base, NULL, &plant), CATA_ERR_MESH);
    CHECK_MENTIONS("node 2: isolated");
    CHECK_STATUS(cata_plant_new(N, tails, thin, parents, leaves, base, NULL, &plant), CATA_ERR_MESH);
    CHECK_MENTIONS("node 1: radius 0");
    CHECK_STATUS(cata_plant_new(0, NULL, NULL, NULL, NULL, NULL, NULL, &plant), CATA_ERR_ARGUMENT);
    CHECK_STATUS(cata_plant_new(N, NULL, radii, parents, leaves, base, NULL, &plant), CATA_ERR_NULL);
    CHECK_MENTIONS("tails");
    CHECK_STATUS(cata_plant_new((size_t)-1, tails, radii, parents, leaves, base, NULL, &plant), CATA_ERR_SHAPE);
    cata_plant_params params = {.struct_size = sizeof params, .loss = -1};
    CHECK_STATUS(cata_plant_new(N, tails, radii, parents, leaves, NULL, &params, &plant), CATA_ERR_ARGUMENT);
    CHECK_MENTIONS("loss");
    params.struct_size = 3;
    CHECK_STATUS(cata_plant_new(N, tails, radii, parents, leaves, NULL, &params, &plant), CATA_ERR_ARGUMENT);
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
    double moduli[N];
    CHECK_STATUS(cata_plant_stiffness(plant, N, water, 1, 2, 8, 0.6, moduli), CATA_ERR_ARGUMENT);
    CHECK(water[0] == 5 && water[2] == 5);
    CHECK(cata_plant_size(NULL) == 0);
    cata_plant_free(plant);
}

int main(void)
{
    test_full_water_and_decay();
    test_steps_and_independent_handles();
    test_refusals();
    return report("test_plant");
}
