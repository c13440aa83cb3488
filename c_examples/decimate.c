/* A bumpy sheet of 90,000 vertices decimated to 1,000, and its heights carried over. */

#include <catamaran.h>

#include <math.h>
#include <stdio.h>
#include <stdlib.h>

enum { SIDE = 300, N = 1000 };

int main(void)
{
    const size_t n_vertices = (size_t)SIDE * SIDE;
    const size_t n_faces = 2 * (size_t)(SIDE - 1) * (SIDE - 1);
    double *vertices = malloc(3 * n_vertices * sizeof *vertices);
    uint32_t *faces = malloc(3 * n_faces * sizeof *faces);
    double *heights = malloc(n_vertices * sizeof *heights);
    uint32_t *cells = malloc(n_vertices * sizeof *cells);
    static double new_vertices[3 * N], new_heights[N];
    cata_decimation *sheet = NULL;
    int result = EXIT_FAILURE;
    if (!vertices || !faces || !heights || !cells) {
        fprintf(stderr, "out of memory\n");
        goto done;
    }
    size_t f = 0;
    for (uint32_t i = 0; i < SIDE; i++) {
        for (uint32_t j = 0; j < SIDE; j++) {
            const uint32_t v = i * SIDE + j;
            vertices[3 * v] = i / (SIDE - 1.0);
            vertices[3 * v + 1] = j / (SIDE - 1.0);
            vertices[3 * v + 2] = heights[v] = 0.05 * sin(0.07 * i) * cos(0.05 * j);
            if (i + 1 < SIDE && j + 1 < SIDE) {
                const uint32_t corners[6] = {v, v + SIDE, v + SIDE + 1, v, v + SIDE + 1, v + 1};
                for (int k = 0; k < 6; k++) {
                    faces[f++] = corners[k];
                }
            }
        }
    }

    size_t n_new_faces = 0;
    if (cata_decimation_new(n_vertices, vertices, n_faces, faces, N, NULL, &sheet) != CATA_OK
        || cata_decimation_size(sheet, NULL, &n_new_faces, NULL) != CATA_OK
        || cata_decimation_get(sheet, new_vertices, NULL) != CATA_OK
        || cata_decimation_places(sheet, cells, NULL, NULL, NULL) != CATA_OK
        || cata_decimation_carry(sheet, 1, heights, new_heights) != CATA_OK) {
        fprintf(stderr, "%s\n", cata_last_error_message());
        goto done;
    }
    size_t sizes[N] = {0}, largest = 0;
    for (size_t v = 0; v < n_vertices; v++) {
        if (++sizes[cells[v]] > largest) {
            largest = sizes[cells[v]];
        }
    }
    double farthest = 0; /* vertices are a little beside the surface */
    for (size_t v = 0; v < N; v++) {
        farthest = fmax(farthest, fabs(new_heights[v] - new_vertices[3 * v + 2]));
    }
    printf("%zu vertices, %zu faces -> %d vertices, %zu faces; the largest cell has %zu vertices;\n"
           "carried heights are within %.4f of the new ones\n",
           n_vertices, n_faces, N, n_new_faces, largest, farthest);
    if (farthest > 0.01) {
        fputs("MISMATCH\n", stderr);
        goto done;
    }
    result = EXIT_SUCCESS;
done:
    free(vertices);
    free(faces);
    free(heights);
    free(cells);
    cata_decimation_free(sheet);
    return result;
}
