/* Meshes for the tests of geometry. */

#ifndef MESHES_H
#define MESHES_H

#include <math.h>
#include <stdint.h>
#include <string.h>

/* A square of this size in the plane, side x side vertices: vertex i * side + j is at (i, j),
 * and its 2 (side - 1)^2 faces are counter-clockwise as seen from above. */
static inline void make_square(uint32_t side, double size, double *vertices, uint32_t *faces)
{
    size_t f = 0;
    for (uint32_t i = 0; i < side; i++) {
        for (uint32_t j = 0; j < side; j++) {
            const uint32_t v = i * side + j;
            vertices[3 * v] = size * i / (side - 1);
            vertices[3 * v + 1] = size * j / (side - 1);
            vertices[3 * v + 2] = 0;
            if (i + 1 < side && j + 1 < side) {
                const uint32_t two[6] = {v, v + side, v + side + 1, v, v + side + 1, v + 1};
                memcpy(faces + f, two, sizeof two);
                f += 6;
            }
        }
    }
}

/* A torus of around x tube vertices with the radii 2 and 1, and 2 around tube faces. */
static inline void make_torus(uint32_t around, uint32_t tube, double *vertices, uint32_t *faces)
{
    const double tau = 6.283185307179586;
    size_t f = 0;
    for (uint32_t i = 0; i < around; i++) {
        for (uint32_t j = 0; j < tube; j++) {
            const uint32_t a = i * tube + j, b = (i + 1) % around * tube + j;
            const uint32_t c = (i + 1) % around * tube + (j + 1) % tube, d =
                i * tube + (j + 1) % tube;
            const double u = tau * i / around, v = tau * j / tube;
            vertices[3 * a] = (2 + cos(v)) * cos(u);
            vertices[3 * a + 1] = (2 + cos(v)) * sin(u);
            vertices[3 * a + 2] = sin(v);
            const uint32_t corners[6] = {a, b, c, a, c, d};
            memcpy(faces + f, corners, sizeof corners);
            f += 6;
        }
    }
}

#endif
