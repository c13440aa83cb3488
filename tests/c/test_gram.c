/* Least squares, PCA, SVD and extended Gram matrices through the C ABI: exact values, both
 * layouts, refusals, outputs untouched, threads, cancelling. */

#include <catamaran.h>

#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "check.h"

#define CHECK_MENTIONS(text) CHECK(strstr(cata_last_error_message(), text) != NULL)
#define NEAR(x, y) (fabs((x) - (y)) <= 1e-15 * fabs(y))

static const int32_t LAYOUTS[2] = {CATA_ROW_MAJOR, CATA_COL_MAJOR};

/* Where entry (i, j) is, with lines `ld` apart. */
static size_t at(int32_t layout, size_t ld, size_t i, size_t j)
{
    return layout == CATA_ROW_MAJOR ? i * ld + j : i + j * ld;
}

static int32_t cancel(double fraction, void *user)
{
    ++*(int *)user;
    return fraction >= 0.0;
}

static int32_t go_on(double fraction, void *user)
{
    double *last = user;
    CHECK(fraction >= *last && fraction <= 1.0);
    *last = fraction;
    return 0;
}

/* Targets 2 t + 1 and 4 - t, with lines as long as columns are in the other layout. */
static void test_lines_are_fitted_exactly(void)
{
    enum { M = 5, N = 1, K = 2, LD = 5 };
    for (int l = 0; l < 2; l++) {
        const int32_t layout = LAYOUTS[l];
        double a[M * LD], b[M * LD], x[LD * LD], errors[LD * LD];
        for (size_t i = 0; i < M; i++) {
            a[at(layout, LD, i, 0)] = (double)i;
            b[at(layout, LD, i, 0)] = 2.0 * (double)i + 1.0;
            b[at(layout, LD, i, 1)] = 4.0 - (double)i;
        }
        double norms[K], r_squared[K], intercepts[K], intercept_errors[K];
        size_t dependent[N] = {77};
        cata_lstsq_params params;
        CHECK_STATUS(cata_lstsq_params_init(&params, sizeof params), CATA_OK);
        params.intercept = 1;
        cata_lstsq_result result = {.struct_size = sizeof result};
        result.residual_norms = norms;
        result.r_squared = r_squared;
        result.intercepts = intercepts;
        result.standard_errors = errors;
        result.intercept_errors = intercept_errors;
        result.dependent = dependent;
        CHECK_STATUS(cata_lstsq(layout, M, N, K, a, LD, b, LD, NULL, x, LD, &result, &params),
                     CATA_OK);
        CHECK(x[at(layout, LD, 0, 0)] == 2.0 && x[at(layout, LD, 0, 1)] == -1.0);
        CHECK(intercepts[0] == 1.0 && intercepts[1] == 4.0);
        CHECK(norms[0] == 0.0 && norms[1] == 0.0 && r_squared[0] == 1.0 && r_squared[1] == 1.0);
        CHECK(errors[at(layout, LD, 0, 1)] == 0.0 && intercept_errors[1] == 0.0);
        CHECK(result.rank == 1 && result.degrees_of_freedom == 3 && dependent[0] == 77);
        CHECK(NEAR(result.condition, 1.0) && result.digits > 15.9);
        CHECK(result.struct_size == sizeof result && result.intercepts == intercepts);
        /* Nothing but X is wanted, or nothing at all. */
        x[0] = 7;
        CHECK_STATUS(cata_lstsq(layout, M, N, K, a, LD, b, LD, NULL, x, LD, NULL, &params),
                     CATA_OK);
        CHECK(x[0] == 2.0);
        CHECK_STATUS(cata_lstsq(layout, M, N, K, a, LD, b, LD, NULL, NULL, 0, NULL, NULL),
                     CATA_OK);
    }
}

/* b = 0, 1, 5 at t = 0, 1, 2: slope 5/2, intercept -1/2, residuals 1/2, -1, 1/2. */
static void test_statistics_of_a_line(void)
{
    const double a[3] = {0, 1, 2}, b[3] = {0, 1, 5};
    double x = 7, norm, r_squared, error, intercept, intercept_error;
    cata_lstsq_params params = {.struct_size = sizeof params, .intercept = 1};
    cata_lstsq_result result = {.struct_size = sizeof result,
                                .residual_norms = &norm, .r_squared = &r_squared,
                                .intercepts = &intercept, .standard_errors = &error,
                                .intercept_errors = &intercept_error};
    CHECK_STATUS(cata_lstsq(CATA_ROW_MAJOR, 3, 1, 1, a, 1, b, 1, NULL, &x, 1, &result, &params),
                 CATA_OK);
    CHECK(x == 2.5 && NEAR(intercept, -0.5) && NEAR(norm, sqrt(1.5)));
    CHECK(NEAR(r_squared, 1.0 - 1.5 / 14.0) && result.degrees_of_freedom == 1);
    CHECK(NEAR(error, sqrt(0.75)) && fabs(intercept_error - sqrt(1.25)) < 1e-15);
    /* Without intercept: 11/5, its array untouched but for the zero constant. */
    params.intercept = 0;
    intercept_error = 7;
    CHECK_STATUS(cata_lstsq(CATA_COL_MAJOR, 3, 1, 1, a, 3, b, 3, NULL, &x, 1, &result, &params),
                 CATA_OK);
    CHECK(x == 2.2 && intercept == 0.0 && intercept_error == 7 && result.degrees_of_freedom == 2);
    /* A ridge of 6: 11 / (5 + 6). A weight of 2 is a row twice. */
    params.ridge = 6;
    CHECK_STATUS(cata_lstsq(CATA_ROW_MAJOR, 3, 1, 1, a, 1, b, 1, NULL, &x, 1, NULL, &params),
                 CATA_OK);
    CHECK(x == 1.0);
    const double weights[3] = {1, 1, 2}, twice_a[4] = {0, 1, 2, 2}, twice_b[4] = {0, 1, 5, 5};
    double repeated = 0;
    CHECK_STATUS(cata_lstsq(CATA_ROW_MAJOR, 3, 1, 1, a, 1, b, 1, weights, &x, 1, NULL, NULL),
                 CATA_OK);
    CHECK_STATUS(cata_lstsq(CATA_ROW_MAJOR, 4, 1, 1, twice_a, 1, twice_b, 1, NULL, &repeated, 1,
                                NULL, NULL),
                 CATA_OK);
    CHECK(x == repeated && NEAR(x, 21.0 / 9.0));
}

/* The third column is the sum of the first two: of all solutions (1, 1, 2) is the shortest. */
static void test_dependent_columns(void)
{
    const double a[6] = {1, 0, 1, 0, 1, 1}, b[2] = {3, 3};
    double x[3] = {7, 7, 7};
    size_t dependent[3] = {77, 77, 77};
    cata_lstsq_params params = {.struct_size = sizeof params};
    cata_lstsq_result result = {.struct_size = sizeof result, .dependent = dependent};
    CHECK_STATUS(cata_lstsq(CATA_ROW_MAJOR, 2, 3, 1, a, 3, b, 1, NULL, x, 1, &result, &params),
                 CATA_OK);
    CHECK(NEAR(x[0], 1.0) && NEAR(x[1], 1.0) && NEAR(x[2], 2.0));
    CHECK(result.rank == 2 && dependent[0] < 3 && dependent[1] == 77);
    CHECK(result.degrees_of_freedom == 0);
    params.refuse_dependent = 1;
    x[0] = result.condition = 7;
    CHECK_STATUS(cata_lstsq(CATA_ROW_MAJOR, 2, 3, 1, a, 3, b, 1, NULL, x, 1, &result, &params),
                 CATA_ERR_ARGUMENT);
    CHECK_MENTIONS("depends on others");
    CHECK(x[0] == 7 && result.condition == 7);
}

/* lm(c(0, 3, 0) ~ c(0, 1, 2)) of R: the square of the residual is 6, with one degree of freedom. */
static void test_statistics_of_lstsq(void)
{
    const double a[3] = {0, 1, 2}, b[3] = {0, 3, 0}, quantile = 12.706204736174704;
    double x, t, p, lower, upper, constant_p, constant_lower, constant_upper, deviation, adjusted;
    double f, f_p, covariance[4];
    size_t observations = 0;
    cata_lstsq_params params;
    CHECK_STATUS(cata_lstsq_params_init(&params, sizeof params), CATA_OK);
    params.intercept = 1;
    cata_lstsq_result result = {.struct_size = sizeof result,
                                .t_statistics = &t, .p_values = &p, .lower = &lower,
                                .upper = &upper, .intercept_p_values = &constant_p,
                                .intercept_lower = &constant_lower,
                                .intercept_upper = &constant_upper,
                                .residual_deviations = &deviation,
                                .adjusted_r_squared = &adjusted, .f_statistics = &f,
                                .f_p_values = &f_p, .covariances = covariance,
                                .observations = &observations};
    CHECK_STATUS(cata_lstsq(CATA_ROW_MAJOR, 3, 1, 1, a, 1, b, 1, NULL, &x, 1, &result, &params),
                 CATA_OK);
    CHECK(x == 0.0 && t == 0.0 && p == 1.0 && f == 0.0 && f_p == 1.0 && observations == 3);
    CHECK(fabs(lower + quantile * sqrt(3.0)) < 1e-12 && lower == -upper);
    CHECK(fabs(constant_lower - (1.0 - quantile * sqrt(5.0))) < 1e-12);
    CHECK(fabs(constant_upper - (1.0 + quantile * sqrt(5.0))) < 1e-12);
    CHECK(fabs(constant_p - 0.7322795271987701) < 1e-14);
    CHECK(NEAR(deviation, sqrt(6.0)) && fabs(adjusted + 1.0) < 1e-14);
    const double right[4] = {5, -3, -3, 3};
    for (size_t i = 0; i < 4; i++) {
        CHECK(fabs(covariance[i] - right[i]) < 1e-14);
    }
    /* A wrong confidence leaves all outputs as they were. */
    params.confidence = 95;
    x = lower = 7;
    CHECK_STATUS(cata_lstsq(CATA_ROW_MAJOR, 3, 1, 1, a, 1, b, 1, NULL, &x, 1, &result, &params),
                 CATA_ERR_ARGUMENT);
    CHECK_MENTIONS("confidence");
    CHECK(x == 7 && lower == 7);
    /* A row of weight 0 is no observation; the constant has row 0 of the covariance alone. */
    const double weights[3] = {1, 1, 0};
    params.confidence = 0.5;
    params.intercept = 0;
    CHECK_STATUS(cata_lstsq(CATA_ROW_MAJOR, 3, 1, 1, a, 1, b, 1, weights, &x, 1, &result, &params),
                 CATA_OK);
    CHECK(x == 3.0 && observations == 2 && result.degrees_of_freedom == 1);
    CHECK(covariance[0] == 0.0 && covariance[1] == 0.0 && covariance[2] == 0.0);
}

static void test_lstsq_refusals(void)
{
    double a[6] = {1, 2, 3, 4, 5, 7}, b[3] = {1, 2, 3}, weights[3] = {1, 1, 1};
    double x[2] = {7, 7};
    cata_lstsq_params params = {.struct_size = sizeof params};
    cata_lstsq_result result = {.struct_size = sizeof result};
    result.rank = 77;
    const int32_t rows = CATA_ROW_MAJOR;
#define LSTSQ(layout, k, a, lda, b, ldb, ldx) \
    cata_lstsq(layout, 3, 2, k, a, lda, b, ldb, weights, x, ldx, &result, &params)
#define REFUSED(call, status, text)   \
    do {                              \
        CHECK_STATUS(call, status);   \
        CHECK_MENTIONS(text);         \
        CHECK(x[0] == 7 && x[1] == 7 && result.rank == 77); \
    } while (0)
    REFUSED(LSTSQ(7, 1, a, 2, b, 1, 1), CATA_ERR_ARGUMENT, "layout");
    REFUSED(LSTSQ(rows, 0, a, 2, b, 1, 1), CATA_ERR_ARGUMENT, "k:");
    REFUSED(LSTSQ(rows, 1, NULL, 2, b, 1, 1), CATA_ERR_NULL, "a:");
    REFUSED(LSTSQ(rows, 1, a, 1, b, 1, 1), CATA_ERR_SHAPE, "lda:");
    REFUSED(LSTSQ(rows, 1, a, 2, NULL, 1, 1), CATA_ERR_NULL, "b:");
    REFUSED(LSTSQ(rows, 1, a, 2, b, 0, 1), CATA_ERR_SHAPE, "ldb:");
    REFUSED(LSTSQ(rows, 1, a, 2, b, 1, 0), CATA_ERR_SHAPE, "ldx:");
    weights[1] = -1;
    REFUSED(LSTSQ(rows, 1, a, 2, b, 1, 1), CATA_ERR_ARGUMENT, "weights: weight 1");
    weights[1] = NAN;
    REFUSED(LSTSQ(rows, 1, a, 2, b, 1, 1), CATA_ERR_NON_FINITE, "weights:");
    weights[1] = 1;
    a[3] = INFINITY;
    REFUSED(LSTSQ(rows, 1, a, 2, b, 1, 1), CATA_ERR_NON_FINITE, "a: not finite at row 1, column 1");
    a[3] = 4;
    b[2] = NAN;
    REFUSED(LSTSQ(rows, 1, a, 2, b, 1, 1), CATA_ERR_NON_FINITE, "b: not finite at row 2, column 0");
    b[2] = 3;
    params.ridge = -1;
    REFUSED(LSTSQ(rows, 1, a, 2, b, 1, 1), CATA_ERR_ARGUMENT, "ridge:");
    params.ridge = 0;
    params.intercept = 2;
    REFUSED(LSTSQ(rows, 1, a, 2, b, 1, 1), CATA_ERR_ARGUMENT, "params.intercept:");
    params.intercept = 0;
    params.refuse_dependent = -1;
    REFUSED(LSTSQ(rows, 1, a, 2, b, 1, 1), CATA_ERR_ARGUMENT, "params.refuse_dependent:");
    params.refuse_dependent = 0;
    params.struct_size = 8;
    REFUSED(LSTSQ(rows, 1, a, 2, b, 1, 1), CATA_ERR_ARGUMENT, "params.struct_size:");
    params.struct_size = sizeof params;
    result.struct_size = 8;
    REFUSED(LSTSQ(rows, 1, a, 2, b, 1, 1), CATA_ERR_ARGUMENT, "result.struct_size:");
    result.struct_size = sizeof result;
    /* X would be where condition and digits are written. */
    CHECK_STATUS(cata_lstsq(rows, 3, 2, 1, a, 2, b, 1, weights, &result.condition, 1, &result,
                            &params),
                 CATA_ERR_ARGUMENT);
    CHECK_MENTIONS("x: must not overlap result");
    CHECK(result.rank == 77);
    /* The arrays of the result have its name, and the leading dimension of X. */
    double lower[2] = {7, 7};
    result.lower = lower;
    REFUSED(LSTSQ(rows, 1, a, 2, b, 1, 0), CATA_ERR_SHAPE, "ldx: must be at least 1");
    CHECK_STATUS(cata_lstsq(rows, 3, 2, 1, a, 2, b, 1, weights, NULL, 0, &result, &params),
                 CATA_ERR_SHAPE);
    CHECK_MENTIONS("ldx: must be at least 1 (columns of result.lower), is 0");
    result.upper = lower;
    REFUSED(LSTSQ(rows, 1, a, 2, b, 1, 1), CATA_ERR_ARGUMENT,
            "result.upper: must not overlap result.lower");
    result.upper = NULL;
    result.standard_errors = x;
    REFUSED(LSTSQ(rows, 1, a, 2, b, 1, 1), CATA_ERR_ARGUMENT,
            "x: must not overlap result.standard_errors");
    result.standard_errors = NULL;
    result.lower = NULL;
    CHECK(lower[0] == 7 && lower[1] == 7);
    int calls = 0;
    params.progress = cancel;
    params.progress_user = &calls;
    REFUSED(LSTSQ(rows, 1, a, 2, b, 1, 1), CATA_ERR_CANCELLED, "");
    CHECK(calls == 1);
    double last = 0;
    params.progress = go_on;
    params.progress_user = &last;
    CHECK_STATUS(LSTSQ(rows, 1, a, 2, b, 1, 1), CATA_OK);
    CHECK(last > 0.0 && x[0] != 7 && result.rank == 2);
    CHECK_STATUS(cata_lstsq_params_init(&params, 3), CATA_ERR_ARGUMENT);
    CHECK_STATUS(cata_lstsq_params_init(NULL, sizeof params), CATA_ERR_NULL);
#undef LSTSQ
#undef REFUSED
}

/* Rows on the line through (1, 2) in the direction (3, 4) / 5, at -5, 0 and 5. */
static void test_pca_of_a_line(void)
{
    enum { M = 3, N = 2, LD = 4 };
    for (int l = 0; l < 2; l++) {
        const int32_t layout = LAYOUTS[l];
        double a[LD * LD], components[LD * LD];
        for (size_t i = 0; i < M; i++) {
            a[at(layout, LD, i, 0)] = 1.0 + 3.0 * ((double)i - 1.0);
            a[at(layout, LD, i, 1)] = 2.0 + 4.0 * ((double)i - 1.0);
        }
        double variance[2], ratio[2], values[2], mean[2], scale[2];
        cata_pca_params params;
        CHECK_STATUS(cata_pca_params_init(&params, sizeof params), CATA_OK);
        CHECK_STATUS(cata_pca(layout, M, N, a, LD, 2, components, LD, variance, ratio, values,
                                  mean, scale, &params),
                     CATA_OK);
        CHECK(NEAR(components[at(layout, LD, 0, 0)], 0.6));
        CHECK(NEAR(components[at(layout, LD, 0, 1)], 0.8));
        CHECK(components[at(layout, LD, 1, 0)] == 0.0 && components[at(layout, LD, 1, 1)] == 0.0);
        CHECK(NEAR(variance[0], 25.0) && variance[1] == 0.0);
        CHECK(NEAR(ratio[0], 1.0) && ratio[1] == 0.0);
        CHECK(NEAR(values[0], sqrt(50.0)) && values[1] == 0.0);
        CHECK(mean[0] == 1.0 && mean[1] == 2.0 && scale[0] == 1.0 && scale[1] == 1.0);
        /* Of standardized columns both have the same share. */
        params.standardize = 1;
        CHECK_STATUS(cata_pca(layout, M, N, a, LD, 1, components, LD, variance, NULL, NULL,
                                  NULL, scale, &params),
                     CATA_OK);
        CHECK(fabs(components[at(layout, LD, 0, 0)] - sqrt(0.5)) < 1e-15);
        CHECK(fabs(components[at(layout, LD, 0, 1)] - sqrt(0.5)) < 1e-15);
        CHECK(fabs(variance[0] - 2.0) < 1e-15 && scale[0] == 3.0 && scale[1] == 4.0);
        CHECK_STATUS(cata_pca(layout, M, N, a, LD, 0, NULL, 0, NULL, NULL, NULL, mean, NULL,
                                  NULL),
                     CATA_OK);
    }
}

static void test_pca_refusals(void)
{
    double a[4] = {1, 2, 3, 5}, c[4] = {7, 7, 7, 7}, v[2] = {7, 7};
    cata_pca_params params = {.struct_size = sizeof params};
    const int32_t rows = CATA_ROW_MAJOR;
#define PCA(layout, m, a, lda, count, ldc) \
    cata_pca(layout, m, 2, a, lda, count, c, ldc, v, NULL, NULL, NULL, NULL, &params)
#define REFUSED(call, status, text)        \
    do {                                   \
        CHECK_STATUS(call, status);        \
        CHECK_MENTIONS(text);              \
        CHECK(c[0] == 7 && v[0] == 7);     \
    } while (0)
    REFUSED(PCA(0, 2, a, 2, 2, 2), CATA_ERR_ARGUMENT, "layout:");
    REFUSED(PCA(rows, 1, a, 2, 2, 2), CATA_ERR_ARGUMENT, "m:");
    REFUSED(PCA(rows, 2, a, 2, 3, 2), CATA_ERR_ARGUMENT, "count:");
    REFUSED(PCA(rows, 2, NULL, 2, 2, 2), CATA_ERR_NULL, "a:");
    REFUSED(PCA(rows, 2, a, 1, 2, 2), CATA_ERR_SHAPE, "lda:");
    REFUSED(PCA(rows, 2, a, 2, 2, 1), CATA_ERR_SHAPE, "ldcomponents:");
    params.standardize = 5;
    REFUSED(PCA(rows, 2, a, 2, 2, 2), CATA_ERR_ARGUMENT, "params.standardize:");
    params.standardize = 0;
    a[1] = NAN;
    REFUSED(PCA(rows, 2, a, 2, 2, 2), CATA_ERR_NON_FINITE, "a: not finite at row 0, column 1");
    a[1] = 2;
    int calls = 0;
    params.progress = cancel;
    params.progress_user = &calls;
    REFUSED(PCA(rows, 2, a, 2, 2, 2), CATA_ERR_CANCELLED, "");
    CHECK(calls == 1);
#undef PCA
#undef REFUSED
}

/* diag(3, 2^-40) over a zero row, and its transpose; the smaller value is lost in a Gram matrix of
 * doubles. */
static void test_singular_values(void)
{
    const double small = ldexp(1.0, -40);
    const double tall[6] = {3, 0, 0, small, 0, 0};
    double values[2], v[6];
    cata_gram_params params;
    CHECK_STATUS(cata_gram_params_init(&params, sizeof params), CATA_OK);
    CHECK_STATUS(cata_svd(CATA_ROW_MAJOR, 3, 2, tall, 2, values, v, 2, &params), CATA_OK);
    CHECK(values[0] == 3.0 && values[1] == small);
    CHECK(fabs(v[0]) == 1.0 && v[1] == 0.0 && v[2] == 0.0 && fabs(v[3]) == 1.0);
    /* The same numbers by columns are the transpose: V has two columns of three entries. */
    CHECK_STATUS(cata_svd(CATA_COL_MAJOR, 2, 3, tall, 2, values, v, 3, NULL), CATA_OK);
    CHECK(values[0] == 3.0 && values[1] == small);
    CHECK(fabs(v[0]) == 1.0 && v[1] == 0.0 && v[2] == 0.0);
    CHECK(v[3] == 0.0 && fabs(v[4]) == 1.0 && v[5] == 0.0);
    /* Rank 1: zeros for what is not there. */
    const double ones[4] = {1, 1, 1, 1};
    v[1] = v[3] = 7;
    CHECK_STATUS(cata_svd(CATA_ROW_MAJOR, 2, 2, ones, 2, values, v, 2, NULL), CATA_OK);
    CHECK(NEAR(values[0], 2.0) && values[1] == 0.0 && v[1] == 0.0 && v[3] == 0.0);
    CHECK_STATUS(cata_svd(CATA_ROW_MAJOR, 3, 2, tall, 2, NULL, NULL, 0, NULL), CATA_OK);
    CHECK_STATUS(cata_svd(CATA_ROW_MAJOR, 0, 2, NULL, 2, values, v, 1, NULL), CATA_OK);
    v[0] = values[0] = 7;
    CHECK_STATUS(cata_svd(CATA_ROW_MAJOR, 3, 2, tall, 2, values, v, 1, NULL), CATA_ERR_SHAPE);
    CHECK_MENTIONS("ldv:");
    CHECK_STATUS(cata_svd(CATA_ROW_MAJOR, 3, 2, tall, 1, values, v, 2, NULL), CATA_ERR_SHAPE);
    CHECK_MENTIONS("lda:");
    int calls = 0;
    params.progress = cancel;
    params.progress_user = &calls;
    CHECK_STATUS(cata_svd(CATA_ROW_MAJOR, 3, 2, tall, 2, values, v, 2, &params),
                 CATA_ERR_CANCELLED);
    CHECK(calls == 1 && v[0] == 7 && values[0] == 7);
}

/* The classical example whose Gram matrix in double is singular. */
static void test_extended_gram(void)
{
    enum { M = 3, N = 2, LD = 3 };
    const double e = ldexp(1.0, -30);
    for (int l = 0; l < 2; l++) {
        const int32_t layout = LAYOUTS[l];
        double a[LD * LD], high[LD * LD], low[LD * LD];
        for (size_t i = 0; i < M; i++) {
            a[at(layout, LD, i, 0)] = i == 0 ? 1 : i == 1 ? e : 0;
            a[at(layout, LD, i, 1)] = i == 0 ? 1 : i == 2 ? e : 0;
        }
        for (size_t i = 0; i < LD * LD; i++) {
            high[i] = low[i] = 7;
        }
        int32_t exact = 7;
        CHECK_STATUS(cata_gram_extended(layout, M, N, a, LD, NULL, CATA_CENTER_NONE, high, LD,
                                            low, LD, &exact, NULL),
                     CATA_OK);
        CHECK(high[at(layout, LD, 0, 0)] == 1 && low[at(layout, LD, 0, 0)] == e * e);
        CHECK(high[at(layout, LD, 1, 0)] == 1 && low[at(layout, LD, 1, 0)] == 0);
        CHECK(high[at(layout, LD, 1, 1)] == 1 && low[at(layout, LD, 1, 1)] == e * e);
        CHECK(high[at(layout, LD, 0, 1)] == 7 && low[at(layout, LD, 0, 1)] == 7 && exact == 1);
    }
    double a[3] = {0, 1, 2}, weights[3] = {1, 0, 3}, high = 7;
#define GRAM(m, a, weights, centering, high, ldhigh, low, ldlow, exact)                      \
    cata_gram_extended(CATA_ROW_MAJOR, m, 1, a, 1, weights, centering, high, ldhigh, low, \
                           ldlow, exact, NULL)
    /* About the mean 1: -1, 0, 1; with weights 1, 0, 3 about the mean 3/2: 9/4 + 3/4. */
    CHECK_STATUS(GRAM(3, a, NULL, CATA_CENTER_MEAN, &high, 1, NULL, 0, NULL), CATA_OK);
    CHECK(high == 2);
    CHECK_STATUS(GRAM(3, a, weights, CATA_CENTER_MEAN, &high, 1, NULL, 0, NULL), CATA_OK);
    CHECK(high == 3);
    /* Entries 2^-100 apart do not fit 80 bits. */
    const double far[2] = {1, ldexp(1.0, -100) * 3};
    int32_t exact = 7;
    CHECK_STATUS(GRAM(2, far, NULL, CATA_CENTER_NONE, NULL, 0, NULL, 0, &exact), CATA_OK);
    CHECK(exact == 0);
    CHECK_STATUS(GRAM(0, NULL, NULL, CATA_CENTER_MEAN, &high, 1, NULL, 0, NULL), CATA_OK);
    CHECK(high == 0);
    CHECK_STATUS(cata_gram_extended(CATA_COL_MAJOR, 3, 0, NULL, 3, NULL, CATA_CENTER_NONE, NULL,
                                        0, NULL, 0, NULL, NULL),
                 CATA_OK);
    high = 7;
    CHECK_STATUS(GRAM(3, a, NULL, CATA_CENTER_GIVEN, &high, 1, NULL, 0, NULL), CATA_ERR_ARGUMENT);
    CHECK_MENTIONS("centering:");
    CHECK_STATUS(GRAM(3, a, NULL, CATA_CENTER_NONE, &high, 0, NULL, 0, NULL), CATA_ERR_SHAPE);
    CHECK_MENTIONS("ldhigh:");
    CHECK_STATUS(GRAM(3, a, NULL, CATA_CENTER_NONE, NULL, 0, &high, 0, NULL), CATA_ERR_SHAPE);
    CHECK_MENTIONS("ldlow:");
    weights[1] = INFINITY;
    CHECK_STATUS(GRAM(3, a, weights, CATA_CENTER_NONE, &high, 1, NULL, 0, NULL),
                 CATA_ERR_NON_FINITE);
    CHECK_MENTIONS("weights:");
    weights[0] = -1, weights[1] = weights[2] = 0.5;
    CHECK_STATUS(GRAM(3, a, weights, CATA_CENTER_MEAN, &high, 1, NULL, 0, NULL), CATA_ERR_ARGUMENT);
    CHECK_MENTIONS("weights");
    CHECK(high == 7);
#undef GRAM
}

static void test_correlation(void)
{
    /* The second column falls as the first rises; the third does not vary. */
    const double a[9] = {1, 6, 5, 2, 4, 5, 3, 2, 5};
    double c[9];
    CHECK_STATUS(cata_gram_correlation(CATA_ROW_MAJOR, 3, 3, a, 3, c, 3, NULL), CATA_OK);
    CHECK(c[0] == 1 && c[4] == 1 && c[1] == -1 && c[3] == -1);
    CHECK(isnan(c[2]) && isnan(c[6]) && isnan(c[8]));
    /* 0, 0, 1, 1 and 0, 1, 0, 1 by columns. */
    const double b[8] = {0, 0, 1, 1, 0, 1, 0, 1};
    CHECK_STATUS(cata_gram_correlation(CATA_COL_MAJOR, 4, 2, b, 4, c, 2, NULL), CATA_OK);
    CHECK(c[0] == 1 && c[1] == 0 && c[2] == 0 && c[3] == 1);
    CHECK_STATUS(cata_gram_correlation(CATA_COL_MAJOR, 4, 0, NULL, 4, NULL, 1, NULL), CATA_OK);
    c[0] = 7;
    CHECK_STATUS(cata_gram_correlation(CATA_COL_MAJOR, 4, 2, b, 4, NULL, 2, NULL), CATA_ERR_NULL);
    CHECK_MENTIONS("c:");
    CHECK_STATUS(cata_gram_correlation(CATA_COL_MAJOR, 4, 2, b, 3, c, 2, NULL), CATA_ERR_SHAPE);
    CHECK_MENTIONS("lda:");
    CHECK_STATUS(cata_gram_correlation(CATA_COL_MAJOR, 4, 2, b, 4, c, 1, NULL), CATA_ERR_SHAPE);
    CHECK_MENTIONS("ldc:");
    int calls = 0;
    cata_gram_params params = {
        .struct_size = sizeof params, .progress = cancel, .progress_user = &calls};
    CHECK_STATUS(cata_gram_correlation(CATA_COL_MAJOR, 4, 2, b, 4, c, 2, &params),
                 CATA_ERR_CANCELLED);
    CHECK(calls == 1 && c[0] == 7);
}

static void test_orthogonality(void)
{
    const double q[4] = {1, 0x1p-60, 0, 1};
    double max = 7, frobenius = 7;
    CHECK_STATUS(cata_gram_orthogonality(CATA_ROW_MAJOR, 2, 2, q, 2, &max, &frobenius, NULL),
                 CATA_OK);
    CHECK(max == 0x1p-60 && NEAR(frobenius, sqrt(2.0) * 0x1p-60));
    CHECK_STATUS(cata_gram_orthogonality(CATA_COL_MAJOR, 2, 2, q, 2, NULL, NULL, NULL), CATA_OK);
    CHECK_STATUS(cata_gram_orthogonality(CATA_ROW_MAJOR, 0, 2, NULL, 2, &max, &frobenius, NULL),
                 CATA_OK);
    CHECK(max == 1 && NEAR(frobenius, sqrt(2.0)));
    max = 7;
    CHECK_STATUS(cata_gram_orthogonality(CATA_ROW_MAJOR, 2, 2, NULL, 2, &max, NULL, NULL),
                 CATA_ERR_NULL);
    CHECK_MENTIONS("q:");
    CHECK_STATUS(cata_gram_orthogonality(CATA_ROW_MAJOR, 2, 2, q, 1, &max, NULL, NULL),
                 CATA_ERR_SHAPE);
    CHECK_MENTIONS("ldq:");
    const double infinite[1] = {INFINITY};
    CHECK_STATUS(cata_gram_orthogonality(CATA_ROW_MAJOR, 1, 1, infinite, 1, &max, NULL, NULL),
                 CATA_ERR_NON_FINITE);
    CHECK_MENTIONS("q:");
    CHECK(max == 7);
}

/* [[3, 1], [4, 1]] = [[0.6, 0.8], [0.8, -0.6]] [[5, 1.4], [0, 0.2]]. */
static void test_cholesky_qr(void)
{
    for (int l = 0; l < 2; l++) {
        const int32_t layout = LAYOUTS[l];
        enum { LD = 3 };
        double a[LD * 2], r[LD * 2] = {7, 7, 7, 7, 7, 7};
        a[at(layout, LD, 0, 0)] = 3, a[at(layout, LD, 0, 1)] = 1;
        a[at(layout, LD, 1, 0)] = 4, a[at(layout, LD, 1, 1)] = 1;
        CHECK_STATUS(cata_gram_cholesky_qr(layout, 2, 2, a, LD, r, LD, NULL), CATA_OK);
        CHECK(a[at(layout, LD, 0, 0)] == 0.6 && a[at(layout, LD, 0, 1)] == 0.8);
        CHECK(a[at(layout, LD, 1, 0)] == 0.8 && a[at(layout, LD, 1, 1)] == -0.6);
        CHECK(r[at(layout, LD, 0, 0)] == 5.0 && r[at(layout, LD, 0, 1)] == 1.4);
        CHECK(r[at(layout, LD, 1, 0)] == 0.0 && r[at(layout, LD, 1, 1)] == 0.2);
    }
    double a[4] = {1, 2, 2, 4}, r[4] = {7, 7, 7, 7};
    CHECK_STATUS(cata_gram_cholesky_qr(CATA_ROW_MAJOR, 2, 2, a, 2, r, 2, NULL),
                 CATA_ERR_ARGUMENT);
    CHECK_MENTIONS("column 1");
    CHECK_STATUS(cata_gram_cholesky_qr(CATA_ROW_MAJOR, 2, 2, a, 2, r, 1, NULL),
                 CATA_ERR_SHAPE);
    CHECK_MENTIONS("ldr:");
    CHECK_STATUS(cata_gram_cholesky_qr(CATA_ROW_MAJOR, 2, 2, NULL, 2, r, 2, NULL),
                 CATA_ERR_NULL);
    CHECK_MENTIONS("a:");
    int calls = 0;
    cata_gram_params params = {
        .struct_size = sizeof params, .progress = cancel, .progress_user = &calls};
    CHECK_STATUS(cata_gram_cholesky_qr(CATA_ROW_MAJOR, 2, 2, a, 2, r, 2, &params),
                 CATA_ERR_CANCELLED);
    CHECK(calls == 1 && a[0] == 1 && a[3] == 4 && r[0] == 7);
    CHECK_STATUS(cata_gram_cholesky_qr(CATA_ROW_MAJOR, 2, 0, NULL, 1, NULL, 0, NULL),
                 CATA_OK);
}

/* Sizes that are primes, and more than one block of threads. */
static void test_threads_give_the_same_bytes(void)
{
    enum { M = 211, N = 37, K = 3 };
    static double a[M * N], b[M * K], q[2][M * N], x[2][N * K], errors[2][N * K], v[2][N * N],
        components[2][N * N], high[2][N * N];
    unsigned state = 12345;
    for (size_t i = 0; i < M * N + M * K; i++) {
        state = state * 1664525u + 1013904223u;
        const double value = (double)(state >> 8) / 16777216.0 - 0.5;
        *(i < M * N ? &a[i] : &b[i - M * N]) = value;
    }
    double scalars[2][4];
    memset(scalars, 0, sizeof scalars);
    for (size_t run = 0; run < 2; run++) {
        const size_t threads = run == 0 ? 1 : 5;
        cata_lstsq_params lstsq = {.struct_size = sizeof lstsq, .threads = threads, .intercept = 1};
        cata_pca_params pca = {.struct_size = sizeof pca, .threads = threads};
        cata_gram_params gram = {.struct_size = sizeof gram, .threads = threads};
        cata_lstsq_result result = {.struct_size = sizeof result, .standard_errors = errors[run]};
        CHECK_STATUS(cata_lstsq(CATA_ROW_MAJOR, M, N, K, a, N, b, K, NULL, x[run], K, &result,
                                    &lstsq),
                     CATA_OK);
        scalars[run][0] = result.condition;
        CHECK_STATUS(cata_pca(CATA_ROW_MAJOR, M, N, a, N, N, components[run], N, NULL, NULL,
                                  NULL, NULL, NULL, &pca),
                     CATA_OK);
        CHECK_STATUS(cata_svd(CATA_ROW_MAJOR, M, N, a, N, NULL, v[run], N, &gram), CATA_OK);
        CHECK_STATUS(cata_gram_extended(CATA_ROW_MAJOR, M, N, a, N, NULL, CATA_CENTER_NONE,
                                            high[run], N, NULL, 0, NULL, &gram),
                     CATA_OK);
        memcpy(q[run], a, sizeof a);
        CHECK_STATUS(cata_gram_cholesky_qr(CATA_ROW_MAJOR, M, N, q[run], N, NULL, 0, &gram),
                     CATA_OK);
        CHECK_STATUS(cata_gram_orthogonality(CATA_ROW_MAJOR, M, N, q[run], N, &scalars[run][1],
                                            &scalars[run][2], &gram),
                     CATA_OK);
    }
    CHECK(scalars[0][2] < 1e-14);
    CHECK(memcmp(scalars[0], scalars[1], sizeof scalars[0]) == 0);
    CHECK(memcmp(x[0], x[1], sizeof x[0]) == 0 && memcmp(errors[0], errors[1], sizeof x[0]) == 0);
    CHECK(memcmp(v[0], v[1], sizeof v[0]) == 0 && memcmp(high[0], high[1], sizeof v[0]) == 0);
    CHECK(memcmp(components[0], components[1], sizeof v[0]) == 0);
    CHECK(memcmp(q[0], q[1], sizeof q[0]) == 0);
}

/* What ranks do together is tested under mpirun. */
static void test_without_a_world(void)
{
    const double a[1] = {1}, b[1] = {2};
    double x[1] = {7};
    const cata_status expected =
        cata_capabilities() & CATA_CAP_MPI ? CATA_ERR_NULL : CATA_ERR_UNSUPPORTED;
    CHECK(cata_world_lstsq(NULL, CATA_ROW_MAJOR, 1, 1, 1, a, 1, b, 1, NULL, x, 1, NULL, NULL) ==
          expected);
    CHECK(x[0] == 7);
}

/* The work after the Gram matrix asks too, and tells no fraction below the last one. */
static void test_fractions_never_decrease(void)
{
    enum { M = 500, N = 250 };
    static double a[M * N], values[N], v[N * N];
    for (size_t i = 0; i < M * N; i++)
        a[i] = (double)((i * 7919) % 10007) / 10007.0 - 0.5;
    double last = 0;
    cata_gram_params params;
    CHECK_STATUS(cata_gram_params_init(&params, sizeof params), CATA_OK);
    params.progress = go_on;
    params.progress_user = &last;
    CHECK_STATUS(cata_svd(CATA_ROW_MAJOR, M, N, a, N, values, v, N, &params), CATA_OK);
    CHECK(last == 1.0 && values[0] >= values[N - 1] && values[N - 1] > 0.0);
}

int main(void)
{
    test_lines_are_fitted_exactly();
    test_statistics_of_a_line();
    test_dependent_columns();
    test_statistics_of_lstsq();
    test_lstsq_refusals();
    test_pca_of_a_line();
    test_pca_refusals();
    test_singular_values();
    test_fractions_never_decrease();
    test_extended_gram();
    test_correlation();
    test_orthogonality();
    test_cholesky_qr();
    test_threads_give_the_same_bytes();
    test_without_a_world();
    return report("test_gram");
}
