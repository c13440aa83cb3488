/* Two regressions: a noisy one, with standard errors, checked by its normal equations in plain
 * loops; and the polynomial of degree 5 of NIST's data set Wampler1, whose coefficients are 1. */

#include <catamaran.h>

#include <math.h>
#include <stdio.h>
#include <stdlib.h>

enum { DAYS = 200, COLUMNS = 2, POINTS = 21, POWERS = 6 };

static void check(cata_status status)
{
    if (status != CATA_OK) {
        fprintf(stderr, "%s: %s\n", cata_status_name(status), cata_last_error_message());
        exit(EXIT_FAILURE);
    }
}

/* In [-1/2, 1/2). */
static double uniform(void)
{
    static unsigned state = 12345;
    state = state * 1664525u + 1013904223u;
    return (double)(state >> 8) / 16777216.0 - 0.5;
}

/* Energy for heating a house, from the temperature outside and the wind. */
static int heating(void)
{
    static const char *const names[COLUMNS] = {"temperature", "wind"};
    double a[DAYS * COLUMNS], energy[DAYS];
    for (int i = 0; i < DAYS; i++) {
        a[i * COLUMNS] = 5.0 + 20.0 * uniform();
        a[i * COLUMNS + 1] = 4.0 + 8.0 * uniform();
        energy[i] = 60.0 - 2.5 * a[i * COLUMNS] + 1.5 * a[i * COLUMNS + 1] + 6.0 * uniform();
    }
    double x[COLUMNS], errors[COLUMNS], intercept, intercept_error, norm, r_squared;
    cata_lstsq_params params = {.struct_size = sizeof params, .intercept = 1};
    cata_lstsq_result result = {.struct_size = sizeof result,
                                .residual_norms = &norm,
                                .r_squared = &r_squared,
                                .intercepts = &intercept,
                                .standard_errors = errors,
                                .intercept_errors = &intercept_error};
    check(cata_lstsq(CATA_ROW_MAJOR, DAYS, COLUMNS, 1, a, COLUMNS, energy, 1, NULL, x, 1,
                         &result,
                         &params));
    printf("%-12s %9.4f +- %.4f\n", "constant", intercept, intercept_error);
    for (int j = 0; j < COLUMNS; j++) {
        printf("%-12s %9.4f +- %.4f\n", names[j], x[j], errors[j]);
    }
    printf("R^2 %.4f, residual %.3f with %zu degrees of freedom\n", r_squared,
           norm / sqrt((double)result.degrees_of_freedom), result.degrees_of_freedom);
    /* What is left has nothing in common with the columns. */
    double sums[COLUMNS + 1] = {0}, square = 0.0;
    for (int i = 0; i < DAYS; i++) {
        double left = energy[i] - intercept;
        for (int j = 0; j < COLUMNS; j++) {
            left -= x[j] * a[i * COLUMNS + j];
        }
        for (int j = 0; j < COLUMNS; j++) {
            sums[j] += left * a[i * COLUMNS + j];
        }
        sums[COLUMNS] += left;
        square += left * left;
    }
    int good = fabs(norm - sqrt(square)) < 1e-10 * norm;
    for (int j = 0; j <= COLUMNS; j++) {
        good = good && fabs(sums[j]) < 1e-9;
    }
    return good;
}

static int polynomial(void)
{
    double a[POINTS * POWERS], b[POINTS], x[POWERS], worst = 0.0;
    for (int i = 0; i < POINTS; i++) {
        b[i] = 0.0;
        for (int j = 0; j < POWERS; j++) {
            a[i * POWERS + j] = pow(i, j);
            b[i] += a[i * POWERS + j];
        }
    }
    cata_lstsq_result result = {.struct_size = sizeof result};
    check(cata_lstsq(CATA_ROW_MAJOR, POINTS, POWERS, 1, a, POWERS, b, 1, NULL, x, 1, &result,
                         NULL));
    for (int j = 0; j < POWERS; j++) {
        worst = fmax(worst, fabs(x[j] - 1.0));
    }
    printf("Wampler1: condition %.1e, coefficients 1 up to %.1e, %.1f digits to be trusted\n",
           result.condition, worst, result.digits);
    return worst < 1e-14;
}

int main(void)
{
    const int fitted = heating(), exact = polynomial();
    if (!fitted || !exact) {
        fprintf(stderr, "MISMATCH\n");
    }
    return fitted && exact ? EXIT_SUCCESS : EXIT_FAILURE;
}
