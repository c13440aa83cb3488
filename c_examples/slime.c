/* Two species of slime moulds on a torus that avoid each other, as a renderer would use them:
 * buffers of vertices, coordinates and indices in, a texture out. `slime --image` writes the
 * texture of the first species as slime.pgm; `slime --device 0` computes the same bytes on that
 * OpenCL device, from which only the results that this program reads are copied. */

#include <catamaran.h>

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

enum { AROUND = 48, TUBE = 16, VERTICES = AROUND * TUBE, FACES = 2 * VERTICES, SIZE = 128 };

static double positions[3 * VERTICES], uv[6 * FACES];
static uint32_t triangles[3 * FACES];
static float first[SIZE * SIZE], second[SIZE * SIZE];

static void check(cata_status status)
{
    if (status != CATA_OK) {
        fprintf(stderr, "%s: %s\n", cata_status_name(status), cata_last_error_message());
        exit(EXIT_FAILURE);
    }
}

/* The texture is wrapped once around either way; at its seams, the corners of one vertex have two
 * places in it. */
static void make_torus(void)
{
    static const int corners[6][2] = {{0, 0}, {1, 0}, {1, 1}, {0, 0}, {1, 1}, {0, 1}};
    const double turn = 2.0 * acos(-1.0);
    for (int i = 0; i < AROUND; i++) {
        for (int j = 0; j < TUBE; j++) {
            const int v = i * TUBE + j;
            const double a = turn * i / AROUND, b = turn * j / TUBE, r = 2.0 + 0.8 * cos(b);
            positions[3 * v] = r * cos(a);
            positions[3 * v + 1] = r * sin(a);
            positions[3 * v + 2] = 0.8 * sin(b);
            for (int c = 0; c < 6; c++) {
                const int x = i + corners[c][0], y = j + corners[c][1], at = 6 * v + c;
                triangles[at] = (uint32_t)(x % AROUND * TUBE + y % TUBE);
                uv[2 * at] = (double)x / AROUND;
                uv[2 * at + 1] = (double)y / TUBE;
            }
        }
    }
}

int main(int argc, char **argv)
{
    make_torus();
    cata_slime_params params;
    check(cata_slime_params_init(&params, sizeof params));
    params.agents = 8000;
    params.species = 2;
    params.size = SIZE;
    params.vision_distance = 2.0;
    params.movement_speed = 3.0;
    if (argc > 2 && strcmp(argv[1], "--device") == 0) {
        params.device = argv[2];
    }
    cata_slime *slime = NULL;
    check(cata_slime_new(VERTICES, positions, FACES, triangles, uv, NULL, NULL, &params, &slime));
    for (int frame = 1; frame <= 5; frame++) {
        double coverage[2], presence[2];
        check(cata_slime_step(slime, 30));
        for (size_t s = 0; s < 2; s++) {
            check(cata_slime_coverage(slime, s, &coverage[s], &presence[s]));
        }
        printf("%2d s: coverage %.3f and %.3f, presence %.3f and %.3f\n", frame, coverage[0],
               coverage[1], presence[0], presence[1]);
    }
    check(cata_slime_texture(slime, 0, first));
    check(cata_slime_texture(slime, 1, second));
    cata_slime_free(slime);
    if (argc > 1 && strcmp(argv[1], "--image") == 0) {
        FILE *file = fopen("slime.pgm", "wb");
        if (file == NULL) {
            return EXIT_FAILURE;
        }
        fprintf(file, "P5 %d %d 255\n", SIZE, SIZE);
        for (int row = SIZE - 1; row >= 0; row--) {
            for (int i = 0; i < SIZE; i++) {
                fputc((int)(255.0f * first[row * SIZE + i] + 0.5f), file);
            }
        }
        fclose(file);
    }
    /* Where one species is, the other is less than by chance. */
    double sums[2] = {0.0, 0.0}, both = 0.0;
    for (int i = 0; i < SIZE * SIZE; i++) {
        sums[0] += first[i];
        sums[1] += second[i];
        both += (double)first[i] * second[i];
    }
    if (!(both < 0.7 * sums[0] * sums[1] / (SIZE * SIZE))) {
        fprintf(stderr, "MISMATCH: the species do not avoid each other\n");
        return EXIT_FAILURE;
    }
    return EXIT_SUCCESS;
}
