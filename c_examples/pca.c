/* Principal components of measurements of leaves, checked against plain loops: five lengths that
 * two causes explain. */

#include <catamaran.h>

#include <math.h>
#include <stdio.h>
#include <stdlib.h>

enum { LEAVES = 500, LENGTHS = 5, COUNT = 3 };

/* In [-1/2, 1/2). */
static double uniform(void)
{
    static unsigned state = 12345;
    state = state * 1664525u + 1013904223u;
    return (double)(state >> 8) / 16777216.0 - 0.5;
}

int main(void)
{
    /* How much each length grows with the size of a leaf, and with its slenderness. */
    static const double size_of[LENGTHS] = {8, 3, 2, 1, 0.5};
    static const double slender_of[LENGTHS] = {2, -3, 0.5, -1, 0};
    static double a[LEAVES * LENGTHS];
    for (int i = 0; i < LEAVES; i++) {
        const double size = uniform(), slender = uniform();
        for (int j = 0; j < LENGTHS; j++) {
            a[i * LENGTHS + j] =
                20.0 + size_of[j] * size + slender_of[j] * slender + 0.05 * uniform();
        }
    }
    double components[COUNT * LENGTHS], variance[COUNT], ratio[COUNT], mean[LENGTHS];
    const cata_status status = cata_pca(CATA_ROW_MAJOR, LEAVES, LENGTHS, a, LENGTHS, COUNT,
                                            components, LENGTHS, variance, ratio, NULL, mean, NULL,
                                            NULL);
    if (status != CATA_OK) {
        fprintf(stderr, "%s: %s\n", cata_status_name(status), cata_last_error_message());
        return EXIT_FAILURE;
    }
    int good = ratio[0] + ratio[1] > 0.999 && ratio[2] < 0.001;
    for (int k = 0; k < COUNT; k++) {
        printf("component %d: %7.4f %% of the variance, along", k + 1, 100.0 * ratio[k]);
        for (int j = 0; j < LENGTHS; j++) {
            printf(" %6.3f", components[k * LENGTHS + j]);
        }
        puts("");
        double sum = 0.0;
        for (int i = 0; i < LEAVES; i++) {
            double score = 0.0;
            for (int j = 0; j < LENGTHS; j++) {
                score += (a[i * LENGTHS + j] - mean[j]) * components[k * LENGTHS + j];
            }
            sum += score * score;
        }
        good = good && fabs(sum / (LEAVES - 1) - variance[k]) < 1e-12 * variance[0];
        for (int l = 0; l <= k; l++) {
            double product = k == l ? -1.0 : 0.0;
            for (int j = 0; j < LENGTHS; j++) {
                product += components[k * LENGTHS + j] * components[l * LENGTHS + j];
            }
            good = good && fabs(product) < 1e-14;
        }
    }
    if (!good) {
        fprintf(stderr, "MISMATCH\n");
    }
    return good ? EXIT_SUCCESS : EXIT_FAILURE;
}
