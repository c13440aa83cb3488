/* Transfer of functions through the C ABI: exact within the span, refusals, outputs untouched. */

#include <catamaran.h>

#include <math.h>
#include <string.h>

#include "check.h"

#define CHECK_MENTIONS(text) CHECK(strstr(cata_last_error_message(), text) != NULL)

#define N 12

/* A ring of N points: the constant, and cosine and sine of frequency 1. The target is numbered backwards. */
static double masses[N], values[3] = {0, 1, 1}, source[3 * N], target[3 * N];
static uint32_t points[N];

static void ring(void)
{
    const double pi = acos(-1);
    for (int i = 0; i < N; i++) {
        masses[i] = 1.0 / N;
        points[i] = (uint32_t)(N - 1 - i);
        source[i] = target[i] = 1;
        source[N + i] = target[N + N - 1 - i] = sqrt(2) * cos(2 * pi * i / N);
        source[2 * N + i] = target[2 * N + N - 1 - i] = sqrt(2) * sin(2 * pi * i / N);
    }
}

static cata_status transfer(const double *f, double *g, const cata_basis_params *params)
{
    cata_basis *from = NULL, *to = NULL;
    cata_status status = cata_basis_new(N, 3, masses, values, source, N, NULL, &from);
    if (status == CATA_OK) {
        status = cata_basis_new(N, 3, masses, values, target, N, NULL, &to);
    }
    if (status == CATA_OK) {
        status = cata_transfer(from, to, points, CATA_COL_MAJOR, 1, f, N, g, N, params);
    }
    cata_basis_free(from);
    cata_basis_free(to);
    return status;
}

static void test_products_carry_frequency_2(void)
{
    const double pi = acos(-1);
    double f[N], g[N], again[N];
    for (int i = 0; i < N; i++) {
        f[i] = cos(4 * pi * i / N);
    }
    CHECK_STATUS(transfer(f, g, NULL), CATA_OK);
    for (int i = 0; i < N; i++) {
        CHECK(fabs(g[i] - f[points[i]]) < 1e-12);
    }
    cata_basis_params params;
    CHECK_STATUS(cata_basis_params_init(&params, sizeof params), CATA_OK);
    params.method = CATA_ORTHO_REORTHOGONALIZED;
    params.threads = 2;
    CHECK_STATUS(transfer(f, again, &params), CATA_OK);
    for (int i = 0; i < N; i++) {
        CHECK(fabs(again[i] - f[points[i]]) < 1e-12);
    }
    /* Eigenfunctions alone know nothing of it. */
    params.order = 1;
    CHECK_STATUS(transfer(f, again, &params), CATA_OK);
    for (int i = 0; i < N; i++) {
        CHECK(fabs(again[i]) < 1e-12);
    }
}

static int32_t cancel(double fraction, void *user)
{
    (void)fraction;
    ++*(int *)user;
    return 1;
}

static void test_refusals(void)
{
    double f[N] = {0}, g[N] = {5};
    CHECK_STATUS(transfer(NULL, g, NULL), CATA_ERR_NULL);
    CHECK_MENTIONS("f: must not be NULL");
    CHECK_STATUS(transfer(f, NULL, NULL), CATA_ERR_NULL);
    points[3] = N;
    CHECK_STATUS(transfer(f, g, NULL), CATA_ERR_ARGUMENT);
    CHECK_MENTIONS("target vertex 3");
    ring();
    masses[2] = -1;
    CHECK_STATUS(transfer(f, g, NULL), CATA_ERR_ARGUMENT);
    CHECK_MENTIONS("mass");
    ring();
    f[7] = nan("");
    CHECK_STATUS(transfer(f, g, NULL), CATA_ERR_NON_FINITE);
    f[7] = 0;
    cata_basis_params params = {.struct_size = sizeof params, .order = 256};
    CHECK_STATUS(transfer(f, g, &params), CATA_ERR_ARGUMENT);
    CHECK_MENTIONS("order");
    int calls = 0;
    params = (cata_basis_params){.struct_size = sizeof params, .progress = cancel, .progress_user = &calls};
    CHECK_STATUS(transfer(f, g, &params), CATA_ERR_CANCELLED);
    CHECK(calls == 1);
    CHECK_STATUS(cata_transfer(NULL, NULL, points, CATA_COL_MAJOR, 1, f, N, g, N, NULL), CATA_ERR_NULL);
    CHECK_MENTIONS("source: must not be NULL");
    CHECK(g[0] == 5);
}

int main(void)
{
    ring();
    test_products_carry_frequency_2();
    test_refusals();
    return report("test_transfer");
}
