/* Bases, functional maps and details through the C ABI: a ring, whose functions are known, and a torus. */

#include <catamaran.h>

#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "check.h"

#define CHECK_MENTIONS(text) CHECK(strstr(cata_last_error_message(), text) != NULL)

enum { N = 24, K = 5 };

/* A ring: the constant, and cosines and sines of frequencies 1 and 2. The target is numbered backwards. */
static double masses[N], values[K] = {0, 1, 1, 4, 4}, source[K * N], target[K * N];
static uint32_t points[N];

static double angle(int i)
{
    return 2 * acos(-1) * i / N;
}

static void ring(void)
{
    for (int i = 0; i < N; i++) {
        masses[i] = 1.0 / N;
        points[i] = (uint32_t)(N - 1 - i);
        for (int j = 0; j < K; j++) {
            const double at = (j + 1) / 2 * angle(i);
            source[j * N + i] = j == 0 ? 1 : sqrt(2) * (j % 2 ? cos(at) : sin(at));
        }
    }
    for (int i = 0; i < N; i++) {
        for (int j = 0; j < K; j++) {
            target[j * N + i] = source[j * N + (int)points[i]];
        }
    }
}

static int32_t cancel(double fraction, void *user)
{
    (void)fraction;
    ++*(int *)user;
    return 1;
}

static cata_basis *basis_of(size_t k, const double *vectors)
{
    cata_basis *basis = NULL;
    CHECK_STATUS(cata_basis_new(N, k, masses, values, vectors, N, NULL, &basis), CATA_OK);
    return basis;
}

static void test_basis(void)
{
    size_t n = 9, r = 9, products = 9;
    double q[3 * N], f[N], g[N], high[N], c[3];
    cata_basis *basis = basis_of(3, source);
    CHECK_STATUS(cata_basis_size(basis, &n, &r, &products), CATA_OK);
    CHECK(n == N && r == 3 && products == 0);
    CHECK_STATUS(cata_basis_size(basis, NULL, NULL, NULL), CATA_OK);
    CHECK_STATUS(cata_basis_copy(basis, CATA_COL_MAJOR, q, N, NULL, 0, NULL), CATA_OK);
    for (int i = 0; i < 3 * N; i++) {
        CHECK(fabs(q[i] - source[i]) < 1e-12);
    }
    for (int i = 0; i < N; i++) {
        f[i] = 2 + cos(angle(i)) + cos(2 * angle(i));
    }
    CHECK_STATUS(cata_basis_analysis(basis, CATA_ROW_MAJOR, 1, f, 1, c, 1), CATA_OK);
    CHECK(fabs(c[0] - 2) < 1e-12 && fabs(c[1] - sqrt(0.5)) < 1e-12 && fabs(c[2]) < 1e-12);
    CHECK_STATUS(cata_basis_synthesis(basis, CATA_ROW_MAJOR, 1, c, 1, g, 1), CATA_OK);
    CHECK_STATUS(cata_basis_split(basis, CATA_COL_MAJOR, 1, f, N, q, N, high, N), CATA_OK);
    for (int i = 0; i < N; i++) {
        CHECK(fabs(g[i] - 2 - cos(angle(i))) < 1e-12 && fabs(q[i] - g[i]) < 1e-12);
        CHECK(fabs(high[i] - cos(2 * angle(i))) < 1e-12);
    }
    const double gains[3] = {0, 3, 1};
    CHECK_STATUS(cata_basis_filter(basis, CATA_COL_MAJOR, 1, f, N, gains, 0.5, g, N), CATA_OK);
    CHECK_STATUS(cata_basis_add_coefficient(basis, 2, sqrt(0.5), CATA_COL_MAJOR, 1, f, N), CATA_OK);
    for (int i = 0; i < N; i++) {
        CHECK(fabs(g[i] - 3 * cos(angle(i)) - 0.5 * cos(2 * angle(i))) < 1e-12);
        CHECK(fabs(f[i] - 2 - cos(angle(i)) - cos(2 * angle(i)) - sin(angle(i))) < 1e-12);
    }

    g[0] = 5;
    CHECK_STATUS(cata_basis_filter(NULL, CATA_COL_MAJOR, 1, f, N, gains, 0, g, N), CATA_ERR_NULL);
    CHECK_MENTIONS("basis: must not be NULL");
    CHECK_STATUS(cata_basis_filter(basis, CATA_COL_MAJOR, 1, f, N, NULL, 0, g, N), CATA_ERR_NULL);
    CHECK_MENTIONS("gains: must not be NULL");
    CHECK_STATUS(cata_basis_filter(basis, CATA_COL_MAJOR, 1, f, N - 1, gains, 0, g, N), CATA_ERR_SHAPE);
    CHECK_MENTIONS("ldf");
    CHECK_STATUS(cata_basis_filter(basis, CATA_COL_MAJOR, 1, f, N, gains, NAN, g, N),
                 CATA_ERR_NON_FINITE);
    CHECK_STATUS(cata_basis_add_coefficient(basis, 3, 1, CATA_COL_MAJOR, 1, g, N), CATA_ERR_ARGUMENT);
    CHECK_MENTIONS("index: 3");
    CHECK_STATUS(cata_basis_copy(basis, CATA_COL_MAJOR, g, N, g, N, NULL), CATA_ERR_ARGUMENT);
    CHECK_MENTIONS("triangle: needs a basis of cata_basis_products");
    CHECK(g[0] == 5);
    cata_basis *none = NULL;
    values[2] = 0.5;
    CHECK_STATUS(cata_basis_new(N, 3, masses, values, source, N, NULL, &none), CATA_ERR_ARGUMENT);
    CHECK_MENTIONS("eigenvalues: must ascend, but value 2 is less");
    values[2] = 1;
    CHECK_STATUS(cata_basis_new(N, 3, masses, values, source, N - 1, NULL, &none), CATA_ERR_SHAPE);
    CHECK_MENTIONS("ldv: must be at least 24 (rows of eigenvectors), is 23");
    CHECK_STATUS(cata_basis_new(N, 3, masses, values, NULL, N, NULL, &none), CATA_ERR_NULL);
    CHECK_MENTIONS("eigenvectors: must not be NULL");
    masses[1] = 0;
    CHECK_STATUS(cata_basis_new(N, 3, masses, values, source, N, NULL, &none), CATA_ERR_ARGUMENT);
    CHECK_MENTIONS("mass");
    masses[1] = masses[0];
    int calls = 0;
    cata_basis_params params = {.struct_size = sizeof params, .progress = cancel, .progress_user = &calls};
    CHECK_STATUS(cata_basis_new(N, 3, masses, values, source, N, &params, &none), CATA_ERR_CANCELLED);
    CHECK(none == NULL && calls == 1);
    cata_basis_free(basis);
    cata_basis_free(NULL);
}

/* The products 1, c, s, cc, cs, ss, of which the last depends on the first and the fourth. */
static void test_products(void)
{
    cata_basis *eigen = basis_of(3, source), *basis = NULL;
    for (int32_t method = 0; method <= CATA_ORTHO_RANK_REVEALING; method++) {
        cata_basis_params params = {.struct_size = sizeof params, .method = method};
        CHECK_STATUS(cata_basis_products(eigen, &params, &basis), CATA_OK);
        size_t n, r, products, kept[5];
        double q[5 * N], triangle[5 * 6];
        CHECK_STATUS(cata_basis_size(basis, &n, &r, &products), CATA_OK);
        CHECK(n == N && r == 5 && products == 6);
        CHECK_STATUS(cata_basis_copy(basis, CATA_COL_MAJOR, q, N, triangle, 5, kept), CATA_OK);
        static const int factors[6][2] = {{0, 0}, {1, 0}, {2, 0}, {1, 1}, {1, 2}, {2, 2}};
        for (int j = 0; j < 6; j++) {
            for (int i = 0; i < N; i++) {
                double sum = -source[factors[j][0] * N + i] * source[factors[j][1] * N + i];
                for (int l = 0; l < 5; l++) {
                    sum += q[l * N + i] * triangle[j * 5 + l];
                }
                CHECK(fabs(sum) < 1e-12);
            }
        }
        for (size_t j = 0; j < 5; j++) {
            CHECK(j == 0 || kept[j - 1] < kept[j]);
            for (size_t l = 0; l <= j; l++) {
                double sum = j == l ? -1 : 0;
                for (int i = 0; i < N; i++) {
                    sum += masses[i] * q[j * N + (size_t)i] * q[l * N + (size_t)i];
                }
                CHECK(fabs(sum) < 1e-12);
            }
        }
        cata_basis_free(basis);
    }
    basis = NULL;
    int calls = 0;
    cata_basis_params params = {.struct_size = sizeof params, .progress = cancel, .progress_user = &calls};
    CHECK_STATUS(cata_basis_products(eigen, &params, &basis), CATA_ERR_CANCELLED);
    CHECK(calls == 1);
    params = (cata_basis_params){.struct_size = sizeof params, .method = 4};
    CHECK_STATUS(cata_basis_products(eigen, &params, &basis), CATA_ERR_ARGUMENT);
    CHECK_MENTIONS("params.method: must be a CATA_ORTHO_* value, is 4");
    params.method = 0;
    params.order = 256;
    CHECK_STATUS(cata_basis_products(eigen, &params, &basis), CATA_ERR_ARGUMENT);
    CHECK_MENTIONS("order");
    CHECK_STATUS(cata_basis_products(NULL, NULL, &basis), CATA_ERR_NULL);
    CHECK_MENTIONS("eigenfunctions: must not be NULL");
    CHECK(basis == NULL);
    cata_basis_free(eigen);
}

/* Whether C is the map along the points. */
static int is_the_map(const double *c, const double *expected)
{
    int same = 1;
    for (int i = 0; i < K * K; i++) {
        same &= fabs(c[i] - expected[i]) < 1e-5;
    }
    return same;
}

static void test_maps(void)
{
    cata_basis *from = basis_of(K, source), *to = basis_of(K, target);
    double expected[K * K], c[K * K], again[K * K], f[2 * N], g[2 * N];
    uint32_t found[N];
    CHECK_STATUS(cata_map_from_points(from, to, points, CATA_ROW_MAJOR, expected, K, NULL), CATA_OK);
    CHECK_STATUS(cata_map_points(from, to, CATA_ROW_MAJOR, expected, K, found, NULL), CATA_OK);
    CHECK(memcmp(found, points, sizeof points) == 0);
    for (int i = 0; i < N; i++) {
        f[i] = exp(cos(angle(i)) + 0.5 * sin(2 * angle(i)));
        f[N + i] = exp(sin(angle(i)));
    }
    for (int i = 0; i < N; i++) {
        g[i] = f[points[i]];
        g[N + i] = f[N + (int)points[i]];
    }

    /* Each way of telling of the map is enough. */
    const uint32_t pairs[6] = {0, N - 1, 5, N - 6, 9, N - 10};
    uint32_t labels[N], mirrored[N];
    for (uint32_t i = 0; i < N; i++) {
        labels[i] = i < 3 ? 0 : i < 8 ? 1 : i < 18 ? 2 : i < 21 ? 3 : 4;
    }
    for (uint32_t i = 0; i < N; i++) {
        mirrored[i] = labels[points[i]];
    }
    cata_basis_params params = {.struct_size = sizeof params};
    for (int way = 0; way < 4; way++) {
        cata_map_fit *fit = NULL;
        CHECK_STATUS(cata_map_fit_new(from, to, &fit), CATA_OK);
        if (way == 0) {
            CHECK_STATUS(cata_map_fit_landmarks(fit, 3, pairs), CATA_OK);
        } else if (way == 1) {
            CHECK_STATUS(cata_map_fit_segments(fit, labels, mirrored), CATA_OK);
        } else {
            CHECK_STATUS(cata_map_fit_functions(fit, CATA_COL_MAJOR, 2, f, N, g, N), CATA_OK);
        }
        if (way > 2) {
            CHECK_STATUS(cata_map_fit_operators(fit, CATA_COL_MAJOR, 2, f, N, g, N, 0.1), CATA_OK);
        }
        for (size_t threads = 1; threads <= 4; threads *= 2) {
            params.threads = threads;
            memset(c, 0, sizeof c);
            CHECK_STATUS(cata_map_fit_solve(fit, way == 2 ? 0.05 : 1e-3, CATA_ROW_MAJOR, c, K, &params), CATA_OK);
            CHECK(threads == 1 || memcmp(c, again, sizeof c) == 0);
            memcpy(again, c, sizeof c);
        }
        CHECK_STATUS(cata_map_points(from, to, CATA_ROW_MAJOR, c, K, found, NULL), CATA_OK);
        CHECK(way == 2 || memcmp(found, points, sizeof points) == 0);
        CHECK(way == 2 || is_the_map(c, expected));
        cata_map_fit_free(fit);
    }

    /* A map with errors, and one of the first functions, are refined. */
    for (int i = 0; i < K * K; i++) {
        c[i] = expected[i] + 0.03 * (i % 3 - 1);
    }
    CHECK_STATUS(cata_map_icp(from, to, 10, CATA_ROW_MAJOR, c, K, found, NULL), CATA_OK);
    CHECK(is_the_map(c, expected) && memcmp(found, points, sizeof points) == 0);
    CHECK_STATUS(cata_map_icp(from, to, 10, CATA_ROW_MAJOR, c, K, NULL, NULL), CATA_OK);
    memset(c, 0, sizeof c);
    memset(found, 0, sizeof found);
    CHECK_STATUS(cata_map_zoomout(from, to, 1, CATA_ROW_MAJOR, 3, 3, expected, K, c, K, found, NULL),
                 CATA_OK);
    CHECK(is_the_map(c, expected) && memcmp(found, points, sizeof points) == 0);

    /* What is in the span is carried over as it is. */
    for (int i = 0; i < N; i++) {
        f[i] = 3 - cos(angle(i)) + sin(2 * angle(i));
    }
    CHECK_STATUS(cata_transfer_map(from, to, CATA_ROW_MAJOR, expected, K, 1, f, 1, g, 1, NULL), CATA_OK);
    for (int i = 0; i < N; i++) {
        CHECK(fabs(g[i] - f[points[i]]) < 1e-12);
    }
    cata_basis_free(from);
    cata_basis_free(to);
}

static void test_refusals(void)
{
    cata_basis *from = basis_of(K, source), *to = basis_of(K, target), *products = NULL;
    CHECK_STATUS(cata_basis_products(from, NULL, &products), CATA_OK);
    double c[K * K] = {0}, map[K * K] = {5}, f[N] = {0}, g[N] = {0};
    uint32_t found[N] = {7}, labels[N] = {0}, others[N] = {1};
    cata_map_fit *fit = NULL;
    CHECK_STATUS(cata_map_fit_new(products, to, &fit), CATA_ERR_ARGUMENT);
    CHECK_MENTIONS("source: must be a basis of cata_basis_new");
    CHECK_STATUS(cata_map_fit_new(from, NULL, &fit), CATA_ERR_NULL);
    CHECK_MENTIONS("target: must not be NULL");
    CHECK(fit == NULL);
    CHECK_STATUS(cata_map_fit_new(from, to, &fit), CATA_OK);
    CHECK_STATUS(cata_map_fit_solve(fit, 1, CATA_ROW_MAJOR, map, K, NULL), CATA_ERR_ARGUMENT);
    CHECK_MENTIONS("functions: must not all be zero");
    const uint32_t beyond[4] = {0, 0, 1, N};
    CHECK_STATUS(cata_map_fit_landmarks(fit, 2, beyond), CATA_ERR_ARGUMENT);
    CHECK_MENTIONS("landmarks: (1, 24)");
    CHECK_STATUS(cata_map_fit_landmarks(fit, 2, NULL), CATA_ERR_NULL);
    CHECK_STATUS(cata_map_fit_segments(fit, labels, others), CATA_ERR_ARGUMENT);
    CHECK_MENTIONS("labels: label 1");
    CHECK_STATUS(cata_map_fit_functions(fit, CATA_ROW_MAJOR, 1, f, 1, NULL, 1), CATA_ERR_NULL);
    CHECK_MENTIONS("g: must not be NULL");
    CHECK_STATUS(cata_map_fit_operators(fit, CATA_ROW_MAJOR, 1, f, 1, g, 1, -1), CATA_ERR_ARGUMENT);
    CHECK_MENTIONS("weight");
    CHECK_STATUS(cata_map_fit_functions(NULL, CATA_ROW_MAJOR, 1, f, 1, g, 1), CATA_ERR_NULL);
    CHECK_MENTIONS("fit: must not be NULL");
    f[2] = NAN;
    CHECK_STATUS(cata_map_fit_functions(fit, CATA_ROW_MAJOR, 1, f, 1, g, 1), CATA_ERR_NON_FINITE);
    /* The fit outlives its bases, and goes on after what was refused. */
    const uint32_t pairs[6] = {0, N - 1, 5, N - 6, 9, N - 10};
    CHECK_STATUS(cata_map_fit_landmarks(fit, 3, pairs), CATA_OK);
    CHECK_STATUS(cata_map_fit_solve(fit, -1, CATA_ROW_MAJOR, map, K, NULL), CATA_ERR_ARGUMENT);
    CHECK_MENTIONS("commutativity");
    int calls = 0;
    cata_basis_params params = {.struct_size = sizeof params, .progress = cancel, .progress_user = &calls};
    CHECK_STATUS(cata_map_fit_solve(fit, 1, CATA_ROW_MAJOR, map, K, &params), CATA_ERR_CANCELLED);
    CHECK(calls >= 1 && map[0] == 5);

    CHECK_STATUS(cata_map_icp(from, to, 0, CATA_ROW_MAJOR, map, K, found, NULL), CATA_ERR_ARGUMENT);
    CHECK_MENTIONS("iterations");
    CHECK_STATUS(cata_map_icp(from, products, 1, CATA_ROW_MAJOR, map, K, found, NULL), CATA_ERR_ARGUMENT);
    CHECK_MENTIONS("target: must be");
    CHECK_STATUS(cata_map_icp(from, to, 3, CATA_ROW_MAJOR, map, K, found, &params), CATA_ERR_CANCELLED);
    CHECK_STATUS(cata_map_zoomout(from, to, 0, CATA_ROW_MAJOR, 3, 3, c, K, map, K, found, NULL),
                 CATA_ERR_ARGUMENT);
    CHECK_MENTIONS("step");
    CHECK_STATUS(cata_map_zoomout(from, to, 1, CATA_ROW_MAJOR, 3, 3, c, K, map, K, found, &params),
                 CATA_ERR_CANCELLED);
    CHECK_STATUS(cata_map_zoomout(from, to, 1, CATA_ROW_MAJOR, 3, K + 1, c, K + 1, map, K, found, NULL),
                 CATA_ERR_SHAPE);
    static double o[N * N] = {5};
    CHECK_STATUS(cata_product_map(NULL, to, products, products, CATA_ROW_MAJOR, c, K, 0, o, N, NULL),
                 CATA_ERR_NULL);
    CHECK_MENTIONS("source_eigen: must not be NULL");
    CHECK_STATUS(cata_product_map(from, products, products, products, CATA_ROW_MAJOR, c, K, 0, o, N, NULL),
                 CATA_ERR_ARGUMENT);
    CHECK_MENTIONS("target_eigen: must be a basis of cata_basis_new");
    CHECK_STATUS(cata_product_map(from, to, from, products, CATA_ROW_MAJOR, c, K, 0, o, N, NULL),
                 CATA_ERR_ARGUMENT);
    CHECK_MENTIONS("source: needs a basis of cata_basis_products");
    CHECK_STATUS(cata_product_map(from, to, products, products, CATA_ROW_MAJOR, NULL, K, 0, o, N, NULL),
                 CATA_ERR_NULL);
    CHECK_MENTIONS("c: must not be NULL");
    CHECK_STATUS(cata_product_map(from, to, products, products, CATA_ROW_MAJOR, o, K, 0, o, N, NULL),
                 CATA_ERR_ARGUMENT);
    CHECK_MENTIONS("o: must not overlap c");
    CHECK_STATUS(cata_product_map(from, to, products, products, CATA_ROW_MAJOR, c, K, 2, o, N, NULL),
                 CATA_ERR_ARGUMENT);
    CHECK_MENTIONS("of_all");
    CHECK_STATUS(cata_product_map(from, to, products, products, CATA_ROW_MAJOR, c, K, 1, o, N, &params),
                 CATA_ERR_CANCELLED);
    CHECK(o[0] == 5);
    CHECK_STATUS(cata_map_points(from, to, CATA_ROW_MAJOR, c, K, found, &params), CATA_ERR_CANCELLED);
    c[3] = INFINITY;
    CHECK_STATUS(cata_map_points(from, to, CATA_ROW_MAJOR, c, K, found, NULL), CATA_ERR_NON_FINITE);
    CHECK_MENTIONS("functional map");
    CHECK_STATUS(cata_transfer_map(from, to, CATA_ROW_MAJOR, c, K, 1, g, 1, f, 1, NULL), CATA_ERR_NON_FINITE);
    points[2] = N;
    CHECK_STATUS(cata_map_from_points(from, to, points, CATA_ROW_MAJOR, map, K, NULL), CATA_ERR_ARGUMENT);
    CHECK_MENTIONS("target vertex 2");
    ring();
    CHECK_STATUS(cata_map_from_points(from, to, points, CATA_ROW_MAJOR, map, K, &params),
                 CATA_ERR_CANCELLED);
    CHECK_STATUS(cata_transfer_map(from, to, CATA_ROW_MAJOR, map, K, 1, g, 1, f, 1, &params),
                 CATA_ERR_CANCELLED);
    CHECK(map[0] == 5 && found[0] == 7);
    cata_basis_free(from);
    cata_basis_free(to);
    CHECK_STATUS(cata_map_fit_solve(fit, 1e-3, CATA_ROW_MAJOR, map, K, NULL), CATA_OK);
    CHECK(fabs(map[0] - 1) < 1e-12);
    cata_map_fit_free(fit);
    cata_map_fit_free(NULL);
    cata_basis_free(products);
}

enum { AROUND = 16, ACROSS = 8, V = AROUND * ACROSS, F = 2 * V, FEW = 8, MANY = 60 };

static double positions[3 * V], scaled[3 * V];
static uint32_t corners[3 * F];

static void torus(void)
{
    size_t f = 0;
    for (uint32_t i = 0; i < AROUND; i++) {
        for (uint32_t j = 0; j < ACROSS; j++) {
            const double u = 2 * acos(-1) * i / AROUND, v = 2 * acos(-1) * j / ACROSS;
            const double radius = 3 + cos(v) + 0.02 * cos(4 * u);
            double *x = positions + 3 * (i * ACROSS + j);
            x[0] = radius * cos(u);
            x[1] = 1.2 * radius * sin(u);
            x[2] = sin(v);
            const uint32_t next = (i + 1) % AROUND * ACROSS, own = i * ACROSS, up = (j + 1) % ACROSS;
            const uint32_t two[6] = {own + j, next + j, next + up, own + j, next + up, own + up};
            memcpy(corners + f, two, sizeof two);
            f += 6;
        }
    }
    for (int i = 0; i < 3 * V; i++) {
        scaled[i] = 2 * positions[i];
    }
}

static cata_basis *of_mesh(const double *x, size_t k)
{
    static double numbers[MANY], functions[MANY * V], weights[V];
    cata_basis *basis = NULL;
    CHECK_STATUS(cata_mesh_eigs(V, x, F, corners, k, numbers, functions, V, NULL, weights, NULL), CATA_OK);
    CHECK_STATUS(cata_basis_new(V, k, weights, numbers, functions, V, NULL, &basis), CATA_OK);
    return basis;
}

/* A torus that gets its own details stays as it is, nearly; one of twice the size gets them twice. */
static void test_details(size_t count)
{
    static double map[MANY * MANY], moved[3 * V], twice[3 * V];
    static uint32_t identity[V];
    torus();
    cata_basis *few = of_mesh(positions, FEW), *many = of_mesh(positions, count);
    cata_basis *large_few = of_mesh(scaled, FEW), *large = of_mesh(scaled, count);
    for (uint32_t i = 0; i < V; i++) {
        identity[i] = i;
    }
    CHECK_STATUS(cata_map_from_points(many, many, identity, CATA_COL_MAJOR, map, MANY, NULL), CATA_OK);
    CHECK_STATUS(cata_transfer_details(V, positions, F, corners, V, positions, F, corners, few, few, many, many,
                                       CATA_COL_MAJOR, map, MANY, moved, NULL),
                 CATA_OK);
    CHECK_STATUS(cata_map_from_points(many, large, identity, CATA_COL_MAJOR, map, MANY, NULL), CATA_OK);
    CHECK_STATUS(cata_transfer_details(V, positions, F, corners, V, scaled, F, corners, few, large_few, many,
                                       large, CATA_COL_MAJOR, map, MANY, twice, NULL),
                 CATA_OK);
    double gap = 0, most = 0;
    for (int i = 0; i < 3 * V; i++) {
        gap = fmax(gap, fabs(2 * moved[i] - twice[i]));
        most = fmax(most, fabs(moved[i] - positions[i]));
    }
    CHECK(gap < 1e-6 && most > 0 && most < 0.6);
    moved[0] = 5;
    const uint32_t beyond[3] = {0, 1, V};
    CHECK_STATUS(cata_transfer_details(V, positions, F, corners, V, positions, 1, beyond, few, few, many, many,
                                       CATA_COL_MAJOR, map, MANY, moved, NULL),
                 CATA_ERR_MESH);
    CHECK_MENTIONS("target: face 0");
    CHECK_STATUS(cata_transfer_details(V - 1, positions, 0, corners, V, positions, F, corners, few, few, many,
                                       many, CATA_COL_MAJOR, map, MANY, moved, NULL),
                 CATA_ERR_SHAPE);
    CHECK_STATUS(cata_transfer_details(V, positions, F, corners, V, positions, F, corners, few, NULL, many,
                                       many, CATA_COL_MAJOR, map, MANY, moved, NULL),
                 CATA_ERR_NULL);
    CHECK_MENTIONS("smooth_target: must not be NULL");
    int calls = 0;
    cata_basis_params params = {.struct_size = sizeof params, .progress = cancel, .progress_user = &calls};
    CHECK_STATUS(cata_transfer_details(V, positions, F, corners, V, positions, F, corners, few, few, many, many,
                                       CATA_COL_MAJOR, map, MANY, moved, &params),
                 CATA_ERR_CANCELLED);
    CHECK(moved[0] == 5 && calls == 1);

    /* Products, maps and points of many functions do not depend on threads. */
    static double triangle[500 * 500], other[500 * 500];
    for (size_t threads = 1; threads <= (count < MANY ? 1 : 4); threads *= 2) {
        cata_basis *products = NULL;
        size_t r = 0, all = 0;
        cata_basis_params how = {.struct_size = sizeof how, .threads = threads,
                                 .method = CATA_ORTHO_RANK_REVEALING};
        CHECK_STATUS(cata_basis_products(few, &how, &products), CATA_OK);
        CHECK_STATUS(cata_basis_size(products, NULL, &r, &all), CATA_OK);
        CHECK(all == FEW * (FEW + 1) / 2 && r > FEW && r <= all);
        CHECK_STATUS(cata_basis_copy(products, CATA_ROW_MAJOR, NULL, 0, triangle, 500, NULL), CATA_OK);
        CHECK(threads == 1 || memcmp(triangle, other, sizeof other) == 0);
        memcpy(other, triangle, sizeof other);
        cata_basis_free(products);
    }
    cata_basis_free(few);
    cata_basis_free(many);
    cata_basis_free(large_few);
    cata_basis_free(large);
}

/* Meshes at fault are named, and outputs stay as they are. */
static void test_refused_searches(void)
{
    cata_basis *from = basis_of(K, source), *to = basis_of(K, target);
    double circle[3 * N], map[K * K] = {5}, numbers[2] = {7, 7};
    const uint32_t face[3] = {0, 1, 2}, beyond[3] = {0, 1, N};
    int32_t ambiguous = 7;
    for (int i = 0; i < N; i++) {
        circle[3 * i] = cos(angle(i));
        circle[3 * i + 1] = sin(angle(i));
        circle[3 * i + 2] = 0;
    }
    const struct {
        const double *source;
        const uint32_t *of_source, *of_target;
        cata_status status;
        const char *said;
    } cases[] = {
        {NULL, face, face, CATA_ERR_NULL, "source: vertices: must not be NULL"},
        {circle, face, NULL, CATA_ERR_NULL, "target: faces: must not be NULL"},
        {circle, beyond, face, CATA_ERR_MESH, "source: face 0"},
        {circle, face, beyond, CATA_ERR_MESH, "target: face 0"},
    };
    for (size_t i = 0; i < sizeof cases / sizeof *cases; i++) {
        CHECK_STATUS(cata_map_search(from, to, cases[i].source, 1, cases[i].of_source, circle, 1,
                                     cases[i].of_target, CATA_ROW_MAJOR, map, K, NULL, &ambiguous, NULL,
                                     NULL, NULL, NULL),
                     cases[i].status);
        CHECK_MENTIONS(cases[i].said);
    }
    CHECK_STATUS(cata_map_search(from, to, circle, 1, face, circle, 1, face, CATA_ROW_MAJOR, map, K, NULL,
                                 &ambiguous, numbers, numbers, NULL, NULL),
                 CATA_ERR_ARGUMENT);
    CHECK_MENTIONS("next: must not overlap commutativity");
    CHECK(ambiguous == 7 && numbers[0] == 7 && map[0] == 5);
    cata_basis_free(from);
    cata_basis_free(to);
}

int main(int argc, char **argv)
{
    const int quick = argc > 1 && strcmp(argv[1], "quick") == 0;
    ring();
    test_basis();
    test_products();
    test_maps();
    test_refusals();
    test_refused_searches();
    test_details(quick ? 2 * FEW : MANY);
    return report("test_maps");
}
