/* A plant that dries out: what a physics simulator asks the water model, frame by frame. A stem of ten segments carries two
 * leaves; after ten hours one of them is cut off from the water, and withers. */

#include <catamaran.h>

#include <math.h>
#include <stdio.h>
#include <stdlib.h>

enum { STEM = 10, LEAF = 6, N = STEM + 2 * LEAF };

static const double hour = 3600.0;

static void check(cata_status status)
{
    if (status != CATA_OK) {
        fprintf(stderr, "%s: %s\n", cata_status_name(status), cata_last_error_message());
        exit(EXIT_FAILURE);
    }
}

static double total(const double *water, int first, int count)
{
    double sum = 0.0;
    for (int v = first; v < first + count; v++) {
        sum += water[v];
    }
    return sum;
}

int main(void)
{
    double tails[3 * N], radii[N];
    uint32_t parents[N];
    int32_t kinds[N];
    for (int v = 0; v < N; v++) {
        const int on_leaf = v >= STEM, side = v >= STEM + LEAF ? 1 : -1;
        const int i = on_leaf ? (v - STEM) % LEAF : v;
        tails[3 * v] = on_leaf ? side * 0.008 * (i + 1) : 0.0;
        tails[3 * v + 1] = 0.0;
        tails[3 * v + 2] = on_leaf ? 0.01 * STEM : 0.01 * (i + 1);
        radii[v] = on_leaf ? 4e-4 : 1.5e-3;
        parents[v] = v == 0 ? CATA_NO_PARENT : (uint32_t)(on_leaf && i == 0 ? STEM - 1 : v - 1);
        kinds[v] = on_leaf ? CATA_PLANT_LEAF : CATA_PLANT_STEM;
    }
    const double base[3] = {0.0, 0.0, 0.0};
    cata_plant_params params;
    check(cata_plant_params_init(&params, sizeof params));
    params.loss = 60.0 / 3.6e6;
    cata_plant *plant = NULL;
    check(cata_plant_new(N, tails, radii, parents, kinds, base, &params, &plant));

    double full[N], water[N], later[N], moduli[N];
    check(cata_plant_full_water(plant, N, full));
    check(cata_plant_start(plant, N, NULL, hour / 4));
    for (int frame = 0; frame <= 8; frame++) {
        check(cata_plant_step(plant, frame == 0 ? 0 : 10, N, water));
        check(cata_plant_stiffness(plant, N, water, moduli));
        printf("%5.1f h: stem %.3f, leaves %.3f and %.3f; a leaf's E = %.2e Pa\n", 2.5 * frame,
               total(water, 0, STEM) / total(full, 0, STEM),
               total(water, STEM, LEAF) / total(full, STEM, LEAF),
               total(water, STEM + LEAF, LEAF) / total(full, STEM + LEAF, LEAF), moduli[N - 1]);
        if (frame == 4) {
            /* Steps against the exact evaluation at the same time. */
            check(cata_plant_water_after(plant, N, full, 10.0 * hour, later));
            for (int v = 0; v < N; v++) {
                if (fabs(later[v] - water[v]) > 1e-6 * full[v]) {
                    fprintf(stderr, "MISMATCH at node %d: %g %g\n", v, water[v], later[v]);
                    return EXIT_FAILURE;
                }
            }
            check(cata_plant_weaken(plant, STEM + LEAF, 0.0));
        }
    }
    const int withered = total(water, STEM + LEAF, LEAF) < 0.8 * total(water, STEM, LEAF);
    cata_plant_free(plant);
    if (!withered) {
        fprintf(stderr, "the leaf that was cut off has as much water as the other\n");
        return EXIT_FAILURE;
    }
    return EXIT_SUCCESS;
}
