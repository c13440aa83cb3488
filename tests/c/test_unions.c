/* Spectral unions from C: what is promised of predictions, and errors. */

#include <catamaran.h>

#include <math.h>
#include <string.h>

#include "check.h"

enum { K = CATA_UNION_EIGENVALUES };

static void fill(double spectrum[K], double first, double step)
{
    for (int i = 0; i < K; i++) {
        spectrum[i] = first + step * i;
    }
}

static int same(const double *a, const double *b)
{
    return memcmp(a, b, K * sizeof *a) == 0;
}

static void predictions(const cata_unions *unions)
{
    double parts[3 * K], swapped[2 * K], spectrum[K], other[K], ood_score = -1;
    fill(parts, 10, 11);
    fill(parts + K, 14, 9);
    fill(parts + 2 * K, 20, 30);
    CHECK_STATUS(cata_unions_predict(unions, 2, parts, spectrum, &ood_score), CATA_OK);
    CHECK(ood_score > 0);
    for (int i = 0; i < K; i++) {
        CHECK(spectrum[i] > 0 && spectrum[i] <= parts[i] && spectrum[i] <= parts[K + i]);
        CHECK(i == 0 || spectrum[i - 1] <= spectrum[i]);
    }
    memcpy(swapped, parts + K, K * sizeof *parts);
    memcpy(swapped + K, parts, K * sizeof *parts);
    CHECK_STATUS(cata_unions_predict(unions, 2, swapped, other, NULL), CATA_OK);
    CHECK(same(spectrum, other));
    CHECK_STATUS(cata_unions_predict(unions, 3, parts, other, NULL), CATA_OK);
    CHECK(other[0] <= spectrum[0] || other[0] <= parts[2 * K]);
    CHECK_STATUS(cata_unions_predict(unions, 1, parts, other, NULL), CATA_OK);
    CHECK(same(parts, other));
}

static void errors(const cata_unions *unions)
{
    double parts[2 * K], spectrum[K] = {-7};
    fill(parts, 10, 11);
    fill(parts + K, 14, 9);
    CHECK_STATUS(cata_unions_predict(NULL, 2, parts, spectrum, NULL), CATA_ERR_NULL);
    CHECK_STATUS(cata_unions_predict(unions, 2, NULL, spectrum, NULL), CATA_ERR_NULL);
    CHECK_STATUS(cata_unions_predict(unions, 2, parts, NULL, NULL), CATA_ERR_NULL);
    CHECK_STATUS(cata_unions_predict(unions, 0, parts, spectrum, NULL), CATA_ERR_ARGUMENT);
    parts[K + 3] = NAN;
    CHECK_STATUS(cata_unions_predict(unions, 2, parts, spectrum, NULL), CATA_ERR_NON_FINITE);
    parts[K + 3] = 1;
    CHECK_STATUS(cata_unions_predict(unions, 2, parts, spectrum, NULL), CATA_ERR_ARGUMENT);
    CHECK(strstr(cata_last_error_message(), "must ascend") != NULL);
    CHECK(spectrum[0] == -7);
    cata_unions *none = NULL;
    CHECK_STATUS(cata_unions_new("/nowhere/weights.safetensors", &none), CATA_ERR_IO);
    CHECK(none == NULL);
    CHECK_STATUS(cata_unions_new(NULL, NULL), CATA_ERR_NULL);
    cata_unions_free(NULL);
}

static void places(const cata_unions *unions)
{
    double parts[2 * K], positions[9] = {0, 0, 0, 1, 0, 0, 0, 1, 0}, indicator[3] = {-7, -7, -7};
    const uint32_t corners[3] = {0, 1, 2};
    fill(parts, 10, 11);
    fill(parts + K, 14, 9);
    /* A triangle is not the template. */
    CHECK_STATUS(cata_unions_locate(unions, 2, parts, 3, positions, 1, corners, indicator, NULL),
                 CATA_ERR_SHAPE);
    CHECK_STATUS(cata_unions_locate(NULL, 2, parts, 3, positions, 1, corners, indicator, NULL),
                 CATA_ERR_NULL);
    CHECK_STATUS(cata_unions_locate(unions, 0, parts, 3, positions, 1, corners, indicator, NULL),
                 CATA_ERR_ARGUMENT);
    cata_unions_params params;
    CHECK_STATUS(cata_unions_params_init(&params, sizeof params), CATA_OK);
    params.threads = 1;
    CHECK_STATUS(cata_unions_locate(unions, 2, parts, 3, positions, 1, corners, indicator, &params),
                 CATA_ERR_SHAPE);
    params.struct_size = 8;
    CHECK_STATUS(cata_unions_locate(unions, 2, parts, 3, positions, 1, corners, indicator, &params),
                 CATA_ERR_ARGUMENT);
    CHECK(strstr(cata_last_error_message(), "sizeof(cata_unions_params)") != NULL);
    CHECK(indicator[0] == -7);
}

static void between(void)
{
    double a[K], b[K];
    fill(a, 1, 1);
    fill(b, 3, 3);
    CHECK_STATUS(cata_unions_interpolate(a, b, 0.5, a), CATA_OK);
    CHECK(a[0] == 2 && a[K - 1] == 2 * K);
    CHECK_STATUS(cata_unions_interpolate(a, b, 2, a), CATA_ERR_ARGUMENT);
}

int main(void)
{
    cata_unions *unions = NULL;
    CHECK_STATUS(cata_unions_new(NULL, &unions), CATA_OK);
    predictions(unions);
    errors(unions);
    places(unions);
    between();
    cata_unions_free(unions);
    return report("test_unions");
}
