/* Three sheets, rolled or not, told apart by their signatures; and the spectrum of a part of one of them. */

#include <catamaran.h>

#include <math.h>
#include <stdio.h>
#include <stdlib.h>

enum { SIDE = 40, V = (SIDE + 1) * (SIDE + 1), F = 2 * SIDE * SIDE, K = 10, SHEETS = 3 };

static double positions[3 * V];
static uint32_t corners[3 * F];

/* A sheet of this width and height 1, rolled around a cylinder of this radius (0: flat). */
static void make_sheet(double width, double radius)
{
    size_t f = 0;
    for (uint32_t i = 0; i <= SIDE; i++) {
        for (uint32_t j = 0; j <= SIDE; j++) {
            const uint32_t v = i * (SIDE + 1) + j;
            const double x = width * i / SIDE;
            positions[3 * v] = radius > 0 ? radius * sin(x / radius) : x;
            positions[3 * v + 1] = (double)j / SIDE;
            positions[3 * v + 2] = radius > 0 ? radius * cos(x / radius) : 0;
            if (i < SIDE && j < SIDE) {
                const uint32_t right = v + SIDE + 1;
                const uint32_t two[6] = {v, right, right + 1, v, right + 1, v + 1};
                for (int k = 0; k < 6; k++) {
                    corners[f++] = two[k];
                }
            }
        }
    }
}

static void checked(cata_status status)
{
    if (status != CATA_OK) {
        fprintf(stderr, "%s: %s\n", cata_status_name(status), cata_last_error_message());
        exit(EXIT_FAILURE);
    }
}

int main(void)
{
    double signatures[SHEETS * K], query[K], distances[SHEETS];
    size_t found[SHEETS];
    for (int i = 0; i < SHEETS; i++) {
        make_sheet(1 + 0.5 * i, 0);
        checked(cata_shape_dna(V, positions, F, corners, K, 1, signatures + K * i, NULL));
    }
    make_sheet(1.5, 0.7);
    checked(cata_shape_dna(V, positions, F, corners, K, 1, query, NULL));
    checked(cata_shape_dna_retrieve(K, query, SHEETS, signatures, SHEETS, found, distances));
    printf("a rolled sheet 1.5 wide is most like the flat ones of width");
    for (int i = 0; i < SHEETS; i++) {
        printf(" %.1f (distance %.2g)", 1 + 0.5 * (double)found[i], distances[i]);
    }

    uint8_t mask[V];
    for (size_t v = 0; v < V; v++) {
        mask[v] = positions[3 * v + 1] <= 0.5;
    }
    double values[K];
    const cata_eigs_params params = {.struct_size = sizeof params,
                                     .boundary = CATA_BOUNDARY_DIRICHLET};
    checked(cata_mesh_part_eigenvalues(V, positions, F, corners, mask, K, values, &params));
    printf("\nits lower half, held at its edge: %.1f %.1f %.1f ...\n", values[0], values[1], values[2]);
    return found[0] == 1 ? EXIT_SUCCESS : EXIT_FAILURE;
}
