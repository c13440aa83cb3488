/* Regions, cuts and drawings through the C ABI: on a square, whose parts are known; refusals. */

#include <catamaran.h>

#include <math.h>
#include <string.h>

#include "check.h"
#include "meshes.h"

#define CHECK_MENTIONS(text) CHECK(strstr(cata_last_error_message(), text) != NULL)

enum { SIDE = 5, V = SIDE * SIDE, F = 2 * (SIDE - 1) * (SIDE - 1) };

static double vertices[3 * V];
static uint32_t faces[3 * F];

/* The line x = 1/4: the first 8 faces are to the left of it. */
static const uint32_t line[8] = {5, 6, 6, 7, 8, 7, 8, 9};

static size_t count_of(size_t n, const uint8_t *inside)
{
    size_t count = 0;
    for (size_t f = 0; f < n; f++) {
        count += inside[f];
    }
    return count;
}

static void test_enclosed(void)
{
    uint8_t left[F], right[F], seeded[F], whole[F], found[F];
    const uint32_t seed = V - 1;
    double area = 0;
    CHECK_STATUS(cata_region_enclosed(V, vertices, F, faces, 4, line, CATA_SIDE_SMALL, 0, NULL,
                                      left),
                 CATA_OK);
    CHECK_STATUS(cata_region_enclosed(V, vertices, F, faces, 4, line, CATA_SIDE_LARGE, 0, NULL,
                                      right),
                 CATA_OK);
    CHECK_STATUS(cata_region_enclosed(V, vertices, F, faces, 4, line, CATA_SIDE_SEEDS, 1, &seed,
                                      seeded),
                 CATA_OK);
    for (int f = 0; f < F; f++) {
        CHECK(left[f] == (f < 8) && right[f] == (f >= 8) && seeded[f] == right[f]);
        whole[f] = 1;
    }
    CHECK_STATUS(cata_region_area(V, vertices, F, faces, left, &area), CATA_OK);
    CHECK(fabs(area - 0.25) < 1e-15);

    CHECK_STATUS(cata_region_combine(CATA_REGION_UNION, F, left, right, found), CATA_OK);
    CHECK(memcmp(found, whole, F) == 0);
    CHECK_STATUS(cata_region_combine(CATA_REGION_INTERSECTION, F, left, whole, found), CATA_OK);
    CHECK(memcmp(found, left, F) == 0);
    CHECK_STATUS(cata_region_combine(CATA_REGION_DIFFERENCE, F, whole, left, found), CATA_OK);
    CHECK(memcmp(found, right, F) == 0);
    CHECK_STATUS(cata_region_combine(CATA_REGION_SYMMETRIC_DIFFERENCE, F, left, whole, found),
                 CATA_OK);
    CHECK(memcmp(found, right, F) == 0);

    uint32_t edges[8];
    const uint32_t expected[8] = {5, 6, 6, 7, 7, 8, 8, 9};
    size_t count = 9;
    CHECK_STATUS(cata_region_boundary(V, vertices, F, faces, left, 0, NULL, &count), CATA_OK);
    CHECK(count == 4);
    CHECK_STATUS(cata_region_boundary(V, vertices, F, faces, left, 4, edges, &count), CATA_OK);
    CHECK(memcmp(edges, expected, sizeof edges) == 0);
    count = 9;
    CHECK_STATUS(cata_region_boundary(V, vertices, F, faces, left, 3, edges, &count),
                 CATA_ERR_SHAPE);
    CHECK_MENTIONS("room: must be at least 4 (edges), is 3");
    CHECK(count == 9);
    CHECK_STATUS(cata_region_boundary(V, vertices, F, faces, whole, 0, NULL, &count), CATA_OK);
    CHECK(count == 0);
}

static void test_parts(void)
{
    uint8_t left[F];
    cata_part *part = NULL;
    size_t n_vertices = 0, n_faces = 0;
    double positions[3 * (V + SIDE)];
    uint32_t corners[3 * F], of_vertices[V + SIDE], of_faces[F];
    for (int f = 0; f < F; f++) {
        left[f] = f < 8;
    }
    CHECK_STATUS(cata_region_part(V, vertices, F, faces, left, &part), CATA_OK);
    CHECK_STATUS(cata_part_size(part, &n_vertices, &n_faces), CATA_OK);
    CHECK(n_vertices == 2 * SIDE && n_faces == 8);
    CHECK_STATUS(cata_part_get(part, positions, corners, of_vertices, of_faces), CATA_OK);
    CHECK(memcmp(positions, vertices, 6 * SIDE * sizeof *positions) == 0);
    CHECK(memcmp(corners, faces, 24 * sizeof *corners) == 0);
    CHECK(of_vertices[9] == 9 && of_faces[7] == 7);
    cata_part_free(part);

    CHECK_STATUS(cata_region_cut(V, vertices, F, faces, 4, line, &part), CATA_OK);
    CHECK_STATUS(cata_part_size(part, &n_vertices, &n_faces), CATA_OK);
    CHECK(n_vertices == V + SIDE && n_faces == F);
    CHECK_STATUS(cata_part_get(part, positions, corners, of_vertices, of_faces), CATA_OK);
    for (size_t v = 0; v < V + SIDE; v++) {
        const uint32_t from = of_vertices[v];
        CHECK(v < V ? from == v : from >= SIDE && from < 2 * SIDE);
        CHECK(memcmp(positions + 3 * v, vertices + 3 * from, 3 * sizeof *positions) == 0);
    }
    for (size_t i = 0; i < 3 * F; i++) {
        CHECK(of_vertices[corners[i]] == faces[i] && of_faces[i / 3] == i / 3);
        /* No vertex has faces on both sides. */
        CHECK((i < 24) == (corners[i] < 2 * SIDE));
    }
    cata_part_free(part);
}

enum { N = 9, W = N * N, G = 2 * (N - 1) * (N - 1) };

/* Around 6 x 6 squares, and around 2 x 2 of them. */
static const uint32_t layers[2][4] = {{10, 64, 16, 70}, {30, 50, 48, 32}};

static void test_drawings(void)
{
    static double grid[3 * W], positions[9 * W], weights[9 * W], shares[G];
    static uint32_t squares[3 * G], triangles[9 * G], of_faces[3 * G], corners[9 * W], along[2 * W];
    static uint8_t inside[2][3 * G], ring[3 * G];
    cata_drawing *drawing = NULL;
    cata_drawn *drawn = NULL;
    size_t n_vertices = 0, n_faces = 0, count = 0;
    int32_t outcome = 9;
    double area = 0;
    const uint32_t middle = 40;
    make_square(N, 1, grid, squares);
    CHECK_STATUS(cata_drawing_new(W, grid, G, squares, &drawing), CATA_OK);
    for (int layer = 0; layer < 2; layer++) {
        CHECK_STATUS(cata_drawing_add(drawing, 4, layers[layer], &outcome, NULL), CATA_OK);
        CHECK(outcome == CATA_CURVE_CLOSED);
    }
    for (int32_t smooth = 0; smooth < 2; smooth++) {
        CHECK_STATUS(cata_drawing_inscribe(drawing, smooth, &drawn), CATA_OK);
        CHECK_STATUS(cata_drawn_size(drawn, &n_vertices, &n_faces, &count), CATA_OK);
        CHECK(n_vertices >= W && n_vertices <= 3 * W && n_faces >= G && n_faces <= 3 * G);
        CHECK(count == 2);
        if (n_vertices > 3 * W || n_faces > 3 * G) {
            return;
        }
        CHECK_STATUS(cata_drawn_get(drawn, positions, triangles, of_faces, corners, weights),
                     CATA_OK);
        for (size_t v = 0; v < n_vertices; v++) {
            for (uint32_t axis = 0; axis < 3; axis++) {
                double mean = 0;
                for (size_t i = 3 * v; i < 3 * v + 3; i++) {
                    mean += weights[i] * grid[3 * corners[i] + axis];
                }
                CHECK(fabs(mean - positions[3 * v + axis]) < 1e-12);
            }
        }
        for (size_t layer = 0; layer < 2; layer++) {
            CHECK_STATUS(cata_drawn_edges(drawn, layer, 0, NULL, &count), CATA_OK);
            CHECK(count >= 4 && count <= W);
            CHECK_STATUS(cata_drawn_edges(drawn, layer, W, along, &count), CATA_OK);
            CHECK_STATUS(cata_region_enclosed(n_vertices, positions, n_faces, triangles, count,
                                              along, CATA_SIDE_SEEDS, 1, &middle, inside[layer]),
                         CATA_OK);
            CHECK_STATUS(cata_region_area(n_vertices, positions, n_faces, triangles, inside[layer],
                                          &area),
                         CATA_OK);
            CHECK(fabs(area - (layer == 0 ? 36 : 4) / 64.0) < 1e-12);
        }
        CHECK_STATUS(cata_region_combine(CATA_REGION_DIFFERENCE, n_faces, inside[0], inside[1],
                                         ring),
                     CATA_OK);
        CHECK(count_of(n_faces, ring) >= 64);
        CHECK_STATUS(cata_drawn_shares(drawn, ring, shares), CATA_OK);
        double sum = 0;
        for (int f = 0; f < G; f++) {
            sum += shares[f] / G;
        }
        CHECK(fabs(sum - 0.5) < 1e-12);
        CHECK_STATUS(cata_drawn_edges(drawn, 2, 0, NULL, &count), CATA_ERR_ARGUMENT);
        CHECK_MENTIONS("layer: must be less than 2 (layers), is 2");
        CHECK_STATUS(cata_drawn_edges(drawn, 0, 1, along, &count), CATA_ERR_SHAPE);
        CHECK_MENTIONS("room");
        cata_drawn_free(drawn);
    }
    CHECK_STATUS(cata_drawing_add(drawing, 4, layers[0], NULL, NULL), CATA_ERR_ARGUMENT);
    CHECK_MENTIONS("smooth");
    cata_drawing_free(drawing);
}

static void test_refusals(void)
{
    uint8_t inside[F] = {5}, wrong[F] = {0, 2}, found[F] = {5};
    const uint32_t apart[2] = {0, 2}, open[2] = {6, 7}, on[1] = {6};
    cata_part *part = NULL;
    cata_drawing *drawing = NULL;
    double area = 5;
    CHECK_STATUS(cata_region_enclosed(V, vertices, F, faces, 1, apart, CATA_SIDE_SMALL, 0, NULL,
                                      found),
                 CATA_ERR_ARGUMENT);
    CHECK_MENTIONS("no edge joins vertices 0 and 2");
    CHECK_STATUS(cata_region_enclosed(V, vertices, F, faces, 1, open, CATA_SIDE_SMALL, 0, NULL,
                                      found),
                 CATA_ERR_MESH);
    CHECK_STATUS(cata_region_enclosed(V, vertices, F, faces, 4, line, CATA_SIDE_SEEDS, 1, on,
                                      found),
                 CATA_ERR_ARGUMENT);
    CHECK_MENTIONS("seeds");
    CHECK_STATUS(cata_region_enclosed(V, vertices, F, faces, 4, line, 3, 0, NULL, found),
                 CATA_ERR_ARGUMENT);
    CHECK_MENTIONS("side");
    CHECK_STATUS(cata_region_combine(4, 0, NULL, NULL, NULL), CATA_ERR_ARGUMENT);
    CHECK_MENTIONS("operation");
    CHECK_STATUS(cata_region_area(V, vertices, F, faces, wrong, &area), CATA_ERR_ARGUMENT);
    CHECK_MENTIONS("inside: must be 0 or 1, but element 1 is 2");
    CHECK_STATUS(cata_region_part(V, vertices, F, faces, inside, &part), CATA_ERR_ARGUMENT);
    CHECK_STATUS(cata_region_cut(V, vertices, F, faces, 1, apart, &part), CATA_ERR_ARGUMENT);
    CHECK_STATUS(cata_part_size(NULL, NULL, NULL), CATA_ERR_NULL);
    CHECK_MENTIONS("part: must not be NULL");
    CHECK_STATUS(cata_drawing_new(V, vertices, F, faces, &drawing), CATA_OK);
    cata_curve_params params = {.struct_size = sizeof params, .smooth = 1};
    const uint32_t samples[4] = {6, 8, 18, 16};
    CHECK_STATUS(cata_drawing_add(drawing, 4, samples, NULL, &params), CATA_ERR_ARGUMENT);
    CHECK_MENTIONS("params.smooth");
    CHECK_STATUS(cata_drawing_inscribe(drawing, 2, NULL), CATA_ERR_NULL);
    cata_drawing_free(drawing);
    CHECK(found[0] == 5 && area == 5 && part == NULL);
    cata_part_free(NULL);
    cata_drawing_free(NULL);
    cata_drawn_free(NULL);
}

int main(void)
{
    make_square(SIDE, 1, vertices, faces);
    test_enclosed();
    test_parts();
    test_drawings();
    test_refusals();
    return report("test_regions");
}
