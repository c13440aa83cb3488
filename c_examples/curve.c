/* A closed curve through samples of a torus, whose order is not known. */

#include <catamaran.h>

#include <math.h>
#include <stdio.h>
#include <stdlib.h>

enum { AROUND = 60, TUBE = 24, SAMPLES = 12 };

static double vertices[3 * AROUND * TUBE];
static uint32_t faces[6 * AROUND * TUBE];

static void make_torus(void)
{
    const double pi = 3.14159265358979323846;
    for (int i = 0; i < AROUND; i++) {
        for (int j = 0; j < TUBE; j++) {
            double u = 2 * pi * i / AROUND, v = 2 * pi * j / TUBE;
            double *p = vertices + 3 * (i * TUBE + j);
            p[0] = (2 + 0.8 * cos(v)) * cos(u);
            p[1] = (2 + 0.8 * cos(v)) * sin(u);
            p[2] = 0.8 * sin(v);
            uint32_t a = (uint32_t)(i * TUBE + j), b = (uint32_t)((i + 1) % AROUND * TUBE + j);
            uint32_t c = (uint32_t)((i + 1) % AROUND * TUBE + (j + 1) % TUBE);
            uint32_t d = (uint32_t)(i * TUBE + (j + 1) % TUBE);
            uint32_t *t = faces + 6 * (i * TUBE + j);
            t[0] = a, t[1] = b, t[2] = c, t[3] = a, t[4] = c, t[5] = d;
        }
    }
}

static int failed(cata_status status)
{
    if (status != CATA_OK) {
        fprintf(stderr, "%s: %s\n", cata_status_name(status), cata_last_error_message());
    }
    return status != CATA_OK;
}

int main(void)
{
    /* Twelve places around the torus, on a wave, every fifth of them after the other. */
    uint32_t samples[SAMPLES];
    make_torus();
    for (int i = 0; i < SAMPLES; i++) {
        int place = 5 * i % SAMPLES;
        samples[i] = (uint32_t)(place * (AROUND / SAMPLES) * TUBE + (place % 2 ? 2 : 22));
    }
    cata_curve_solver *solver = NULL;
    cata_curves *curves = NULL, *geodesics = NULL;
    cata_curve_params smooth = {.struct_size = sizeof smooth, .smooth = 1};
    if (failed(cata_curve_solver_new(AROUND * TUBE, vertices, 2 * AROUND * TUBE, faces, &solver))
        || failed(cata_curve_solver_find(solver, SAMPLES, samples, NULL, &curves))
        || failed(cata_curve_solver_find(solver, SAMPLES, samples, &smooth, &geodesics))) {
        return EXIT_FAILURE;
    }
    int32_t outcome = -1;
    size_t count = 0, sample_count = 0, vertex_count = 0;
    double length = 0, shorter = 0;
    uint32_t order[SAMPLES];
    int wrong = failed(cata_curves_outcome(curves, &outcome, &count, NULL))
             || failed(cata_curves_size(curves, 0, &sample_count, &vertex_count, NULL, &length))
             || failed(cata_curves_size(geodesics, 0, NULL, NULL, NULL, &shorter))
             || sample_count != SAMPLES || failed(cata_curves_get(curves, 0, order, NULL, NULL));
    cata_curves_free(curves);
    cata_curves_free(geodesics);
    cata_curve_solver_free(solver);
    if (wrong) {
        return EXIT_FAILURE;
    }
    printf("outcome %d, %zu curve, %zu vertices, length %.3f, as geodesics %.3f\n", (int)outcome,
           count, vertex_count, length, shorter);
    wrong = shorter >= length;
    for (int i = 0; i < SAMPLES; i++) {
        int step = abs(5 * (int)order[i] % SAMPLES - 5 * (int)order[(i + 1) % SAMPLES] % SAMPLES);
        printf("%u ", (unsigned)order[i]);
        wrong = wrong || (step != 1 && step != SAMPLES - 1);
    }
    putchar('\n');
    if (wrong || outcome != CATA_CURVE_CLOSED || count != 1) {
        fputs("MISMATCH\n", stderr);
        return EXIT_FAILURE;
    }
    return EXIT_SUCCESS;
}
