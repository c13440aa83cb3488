/* A bumpy sheet of 90,000 vertices decimated to 1,000: buffers are the caller's, their sizes known before. */

#include <catamaran.h>

#include <math.h>
#include <stdio.h>
#include <stdlib.h>

enum { SIDE = 300, N = 1000 };

int main(void)
{
    const size_t n_vertices = (size_t)SIDE * SIDE;
    const size_t n_faces = 2 * (size_t)(SIDE - 1) * (SIDE - 1);
    const size_t capacity = cata_decimate_faces_bound(N, n_faces);
    double *vertices = malloc(3 * n_vertices * sizeof *vertices);
    uint32_t *faces = malloc(3 * n_faces * sizeof *faces);
    double *new_vertices = malloc(3 * (size_t)N * sizeof *new_vertices);
    uint32_t *new_faces = malloc(3 * capacity * sizeof *new_faces);
    uint32_t *cells = malloc(n_vertices * sizeof *cells);
    int result = EXIT_FAILURE;
    if (!vertices || !faces || !new_vertices || !new_faces || !cells) {
        fprintf(stderr, "out of memory\n");
        goto done;
    }
    size_t f = 0;
    for (uint32_t i = 0; i < SIDE; i++) {
        for (uint32_t j = 0; j < SIDE; j++) {
            const uint32_t v = i * SIDE + j;
            vertices[3 * v] = i / (SIDE - 1.0);
            vertices[3 * v + 1] = j / (SIDE - 1.0);
            vertices[3 * v + 2] = 0.05 * sin(0.07 * i) * cos(0.05 * j);
            if (i + 1 < SIDE && j + 1 < SIDE) {
                const uint32_t corners[6] = {v, v + SIDE, v + SIDE + 1, v, v + SIDE + 1, v + 1};
                for (int k = 0; k < 6; k++) {
                    faces[f++] = corners[k];
                }
            }
        }
    }

    size_t n_new_faces = 0;
    const cata_status status =
        cata_decimate(n_vertices, vertices, n_faces, faces, N, new_vertices, new_faces, capacity,
                      &n_new_faces, cells, NULL, NULL);
    if (status != CATA_OK) {
        fprintf(stderr, "%s: %s\n", cata_status_name(status), cata_last_error_message());
        goto done;
    }
    size_t sizes[N] = {0}, largest = 0;
    for (size_t v = 0; v < n_vertices; v++) {
        if (++sizes[cells[v]] > largest) {
            largest = sizes[cells[v]];
        }
    }
    printf("%zu vertices, %zu faces -> %d vertices, %zu faces; the largest cell has %zu vertices\n",
           n_vertices, n_faces, N, n_new_faces, largest);
    result = EXIT_SUCCESS;
done:
    free(vertices);
    free(faces);
    free(new_vertices);
    free(new_faces);
    free(cells);
    return result;
}
