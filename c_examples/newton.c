/* A Newton fractal on a sphere, and a picture of it on the plane, on the processor and on a device; with --image the picture
 * is written as newton.ppm. */

#include <catamaran.h>

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

enum { RINGS = 40, SECTORS = 80, POINTS = RINGS * SECTORS, WIDTH = 160, HEIGHT = 100 };

static float sphere[3 * POINTS];
static uint16_t roots[WIDTH * HEIGHT], others[WIDTH * HEIGHT];
static float convergence[WIDTH * HEIGHT];
static uint8_t colors[3 * WIDTH * HEIGHT];

static int failed(cata_status status)
{
    if (status != CATA_OK) {
        fprintf(stderr, "%s: %s\n", cata_status_name(status), cata_last_error_message());
    }
    return status != CATA_OK;
}

int main(int argc, char **argv)
{
    const double pi = 3.14159265358979323846;
    for (int i = 0; i < POINTS; i++) {
        double above = pi * (i / SECTORS + 0.5) / RINGS, around = 2 * pi * (i % SECTORS) / SECTORS;
        sphere[3 * i] = (float)(sin(above) * cos(around));
        sphere[3 * i + 1] = (float)(sin(above) * sin(around));
        sphere[3 * i + 2] = (float)cos(above);
    }
    cata_newton_params params = {.struct_size = sizeof params};
    params.power = 3;
    params.w = 0.25;
    cata_newton *newton = NULL;
    if (failed(cata_newton_new(&params, &newton))
        || failed(cata_newton_points(newton, POINTS, sphere, roots, convergence))) {
        return EXIT_FAILURE;
    }
    int found[9] = {0}, kinds = 0;
    for (int i = 0; i < POINTS; i++) {
        kinds += found[roots[i]]++ == 0;
    }
    printf("sphere: %d of the 9 roots of z^3 = 1\n", kinds);

    /* The same plane twice: here, and on an OpenCL device if there is one. */
    int wrong = kinds < 7 || failed(cata_newton_set_w(newton, 0))
             || failed(cata_newton_plane(newton, WIDTH, HEIGHT, 0, 0, 3, roots, convergence))
             || failed(cata_newton_colors(newton, WIDTH * HEIGHT, roots, convergence, colors));
    cata_newton_free(newton);
    FILE *file = argc > 1 && strcmp(argv[1], "--image") == 0 ? fopen("newton.ppm", "wb") : NULL;
    if (file != NULL) {
        fprintf(file, "P6 %d %d 255\n", WIDTH, HEIGHT);
        fwrite(colors, 1, sizeof colors, file);
        fclose(file);
    }
    char name[128];
    if (!wrong && cata_device_name(0, sizeof name, name) == CATA_OK) {
        int different = 0;
        params.w = 0;
        params.device = "0";
        wrong = failed(cata_newton_new(&params, &newton))
             || failed(cata_newton_plane(newton, WIDTH, HEIGHT, 0, 0, 3, others, convergence));
        cata_newton_free(newton);
        for (int i = 0; i < WIDTH * HEIGHT; i++) {
            different += roots[i] != others[i];
        }
        printf("%s: %d of %d pixels differ\n", name, different, WIDTH * HEIGHT);
        wrong = wrong || different > WIDTH * HEIGHT / 4000;
    }
    /* On the plane alpha and beta are the same: only the roots 0, 4 and 8. */
    for (int i = 0; i < WIDTH * HEIGHT; i++) {
        wrong = wrong || roots[i] % 4 != 0;
    }
    if (wrong) {
        fputs("MISMATCH\n", stderr);
        return EXIT_FAILURE;
    }
    return EXIT_SUCCESS;
}
