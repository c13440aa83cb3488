/* Laplacians through the C ABI: rows that sum to 0, masses that sum to the area, the eigenvalues
 * of cata_mesh_eigs, minus divergence times gradient; points; refusals. */

#include <catamaran.h>

#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "check.h"
#include "meshes.h"

#define CHECK_MENTIONS(text) CHECK(strstr(cata_last_error_message(), text) != NULL)

enum { AROUND = 24, TUBE = 12, V = AROUND * TUBE, F = 2 * V, MOST = 13 * V, K = 6 };

static double vertices[3 * V], w[MOST], masses[MOST];
static uint32_t faces[3 * F], kept[V];
static size_t starts[V + 1], columns[MOST];

static double torus_area(void)
{
    double areas[V], sum = 0;
    CHECK_STATUS(cata_laplacian_areas(V, vertices, F, faces, areas), CATA_OK);
    for (int v = 0; v < V; v++) {
        sum += areas[v];
    }
    return sum;
}

static double entry(size_t i, size_t j)
{
    for (size_t e = starts[i]; e < starts[i + 1]; e++) {
        if (columns[e] == j) {
            return w[e];
        }
    }
    return 0;
}

static void test_torus(void)
{
    const int32_t kinds[3] = {CATA_LAPLACIAN_COTANGENT, CATA_LAPLACIAN_INTRINSIC_DELAUNAY,
                              CATA_LAPLACIAN_TUFTED};
    const double area = torus_area();
    CHECK(fabs(area / (8 * 9.869604401089358) - 1) < 0.05);
    for (int i = 0; i < 3; i++) {
        cata_laplacian *laplacian = NULL;
        size_t rows = 0, entries = 0, count = 0;
        double sum = 0, values[K], functions[K * V], expected[K], residuals[K];
        cata_eigs_params params = {.struct_size = sizeof params, .laplacian = kinds[i]};
        CHECK_STATUS(cata_laplacian_new(V, vertices, F, faces, 0, NULL, &params, &laplacian),
                     CATA_OK);
        CHECK_STATUS(cata_laplacian_size(laplacian, &rows, &entries, &count), CATA_OK);
        CHECK(rows == V && entries <= MOST && count == V);
        CHECK_STATUS(cata_laplacian_get(laplacian, kept, starts, columns, w), CATA_OK);
        CHECK_STATUS(cata_laplacian_masses(laplacian, masses), CATA_OK);
        CHECK(starts[0] == 0 && starts[V] == entries);
        for (size_t v = 0; v < V; v++) {
            double row = 0;
            for (size_t e = starts[v]; e < starts[v + 1]; e++) {
                row += w[e];
                CHECK(e == starts[v] || columns[e - 1] < columns[e]);
                CHECK(w[e] == entry(columns[e], v));
            }
            CHECK(fabs(row) < 1e-12 && kept[v] == v && masses[v] > 0);
            sum += masses[v];
        }
        CHECK(fabs(sum / area - 1) < 1e-6);
        CHECK_STATUS(cata_eigs(V, starts, columns, w, masses, K, values, functions, V, residuals,
                               NULL),
                     CATA_OK);
        CHECK_STATUS(cata_mesh_eigs(V, vertices, F, faces, K, expected, functions, V, NULL, NULL,
                                    &params),
                     CATA_OK);
        for (int k = 0; k < K; k++) {
            CHECK(fabs(values[k] - expected[k]) < 1e-7);
        }
        cata_laplacian_free(laplacian);
    }
}

static void test_consistent_masses(void)
{
    cata_laplacian *laplacian = NULL;
    size_t entries = 0, count = 0;
    double sum = 0;
    cata_eigs_params params = {.struct_size = sizeof params, .mass = CATA_MASS_CONSISTENT};
    CHECK_STATUS(cata_laplacian_new(V, vertices, F, faces, 0, NULL, &params, &laplacian), CATA_OK);
    CHECK_STATUS(cata_laplacian_size(laplacian, NULL, &entries, &count), CATA_OK);
    CHECK(count == entries && count <= MOST);
    CHECK_STATUS(cata_laplacian_masses(laplacian, masses), CATA_OK);
    for (size_t e = 0; e < count; e++) {
        sum += masses[e];
    }
    CHECK(fabs(sum / torus_area() - 1) < 1e-12);
    cata_laplacian_free(laplacian);
}

static void test_held_vertices(void)
{
    const uint32_t held[2] = {5, 0};
    cata_laplacian *laplacian = NULL, *none = NULL;
    size_t rows = 0;
    CHECK_STATUS(cata_laplacian_new(V, vertices, F, faces, 2, held, NULL, &laplacian), CATA_OK);
    CHECK_STATUS(cata_laplacian_size(laplacian, &rows, NULL, NULL), CATA_OK);
    CHECK_STATUS(cata_laplacian_get(laplacian, kept, NULL, NULL, NULL), CATA_OK);
    CHECK(rows == V - 2 && kept[0] == 1 && kept[3] == 4 && kept[4] == 6 && kept[V - 3] == V - 1);
    cata_laplacian_free(laplacian);
    const uint32_t beyond = V;
    CHECK_STATUS(cata_laplacian_new(V, vertices, F, faces, 1, &beyond, NULL, &none), CATA_ERR_MESH);
    cata_eigs_params params = {.struct_size = sizeof params, .boundary = CATA_BOUNDARY_DIRICHLET};
    CHECK_STATUS(cata_laplacian_new(V, vertices, F, faces, 2, held, &params, &none),
                 CATA_ERR_ARGUMENT);
    CHECK_MENTIONS("n_held: must be 0 with CATA_BOUNDARY_DIRICHLET");
    params.boundary = CATA_BOUNDARY_NEUMANN;
    params.mass = 3;
    CHECK_STATUS(cata_laplacian_new(V, vertices, F, faces, 0, NULL, &params, &none),
                 CATA_ERR_ARGUMENT);
    CHECK_MENTIONS("params.mass");
    CHECK_STATUS(cata_laplacian_new(V, NULL, F, faces, 0, NULL, NULL, &none), CATA_ERR_NULL);
    CHECK_STATUS(cata_laplacian_size(NULL, NULL, NULL, NULL), CATA_ERR_NULL);
    CHECK_MENTIONS("laplacian: must not be NULL");
    CHECK(none == NULL);
    cata_laplacian_free(NULL);
}

/* y = A x of a matrix by rows. */
static void apply(size_t rows, const size_t *from, const size_t *of, const double *a,
                  const double *x,
                  double *y)
{
    for (size_t i = 0; i < rows; i++) {
        y[i] = 0;
        for (size_t e = from[i]; e < from[i + 1]; e++) {
            y[i] += a[e] * x[of[e]];
        }
    }
}

static void test_divergence_of_gradient(void)
{
    static size_t grad_starts[3 * F + 1], grad_columns[9 * F], div_starts[V + 1],
        div_columns[9 * F];
    static double grad[9 * F], div[9 * F], f[V], slopes[3 * F], found[V], expected[V];
    cata_laplacian *laplacian = NULL;
    CHECK_STATUS(cata_laplacian_gradient(V, vertices, F, faces, grad_starts, grad_columns, grad),
                 CATA_OK);
    CHECK_STATUS(cata_laplacian_divergence(V, vertices, F, faces, div_starts, div_columns, div),
                 CATA_OK);
    CHECK_STATUS(cata_laplacian_gradient(V, vertices, F, faces, NULL, NULL, NULL), CATA_OK);
    CHECK_STATUS(cata_laplacian_new(V, vertices, F, faces, 0, NULL, NULL, &laplacian), CATA_OK);
    CHECK_STATUS(cata_laplacian_get(laplacian, NULL, starts, columns, w), CATA_OK);
    for (int v = 0; v < V; v++) {
        f[v] = sin(0.1 * v * v);
    }
    apply(3 * F, grad_starts, grad_columns, grad, f, slopes);
    apply(V, div_starts, div_columns, div, slopes, found);
    apply(V, starts, columns, w, f, expected);
    for (int v = 0; v < V; v++) {
        CHECK(fabs(found[v] + expected[v]) < 1e-11);
    }
    cata_laplacian_free(laplacian);
    const uint32_t flat[3] = {0, 1, 2};
    const double line[9] = {0, 0, 0, 1, 0, 0, 2, 0, 0};
    grad_starts[0] = 7;
    CHECK_STATUS(cata_laplacian_gradient(3, line, 1, flat, grad_starts, NULL, NULL), CATA_ERR_MESH);
    CHECK(grad_starts[0] == 7);
}

static int32_t cancel(double fraction, void *user)
{
    (void)fraction;
    ++*(int *)user;
    return 1;
}

static void test_points(void)
{
    enum { SIDE = 12, N = SIDE * SIDE };
    double points[3 * N], sum = 0;
    uint32_t unused[6 * N];
    cata_laplacian *laplacian = NULL, *none = NULL;
    size_t rows = 0, count = 0;
    int calls = 0;
    make_square(SIDE, 2, points, unused);
    CHECK_STATUS(cata_cloud_laplacian(N, points, 12, NULL, &laplacian), CATA_OK);
    CHECK_STATUS(cata_laplacian_size(laplacian, &rows, NULL, &count), CATA_OK);
    CHECK(rows == N && count == N);
    CHECK_STATUS(cata_laplacian_masses(laplacian, masses), CATA_OK);
    for (int v = 0; v < N; v++) {
        sum += masses[v];
    }
    CHECK(fabs(sum / 4 - 1) < 0.1);
    cata_laplacian_free(laplacian);
    CHECK_STATUS(cata_cloud_laplacian(N, points, 2, NULL, &none), CATA_ERR_ARGUMENT);
    CHECK_MENTIONS("neighbours");
    cata_eigs_params params = {.struct_size = sizeof params, .progress = cancel, .progress_user =
                               &calls};
    CHECK_STATUS(cata_cloud_laplacian(N, points, 0, &params, &none), CATA_ERR_CANCELLED);
    CHECK(calls == 1 && none == NULL);
}

int main(void)
{
    make_torus(AROUND, TUBE, vertices, faces);
    test_torus();
    test_consistent_masses();
    test_held_vertices();
    test_divergence_of_gradient();
    test_points();
    return report("test_laplacian");
}
