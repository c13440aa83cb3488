/* Orthonormal polynomials on [-1, 1] out of monomials, by Gram-Schmidt with rank detection, checked by plain loops. */

#include <catamaran.h>

#include <math.h>
#include <stdio.h>
#include <stdlib.h>

enum { POINTS = 2000, COLUMNS = 9 };

int main(void)
{
    double *a = malloc(sizeof(double) * POINTS * COLUMNS);
    double *q = malloc(sizeof(double) * POINTS * COLUMNS);
    double *masses = malloc(sizeof(double) * POINTS);
    if (!a || !q || !masses) {
        fprintf(stderr, "out of memory\n");
        free(a);
        free(q);
        free(masses);
        return EXIT_FAILURE;
    }
    /* The midpoint rule; the columns are 1, x, ..., x^7, and one that depends on two of them. */
    for (int i = 0; i < POINTS; i++) {
        const double x = -1.0 + (2.0 * (double)i + 1.0) / POINTS;
        masses[i] = 2.0 / POINTS;
        for (int j = 0; j < COLUMNS - 1; j++) {
            a[i + j * POINTS] = q[i + j * POINTS] = pow(x, j);
        }
        const int last = (COLUMNS - 1) * POINTS;
        a[i + last] = q[i + last] = x * x - 3.0 * x;
    }

    double r[COLUMNS * COLUMNS];
    size_t kept[COLUMNS], rank = 0;
    const cata_status status = cata_ortho_gram_schmidt(CATA_COL_MAJOR, POINTS, COLUMNS, q, POINTS, masses, r,
                                                 COLUMNS, kept, &rank, NULL);
    double defect = 0.0, gap = 0.0, legendre = 0.0;
    if (status == CATA_OK) {
        for (size_t j = 0; j < rank; j++) {
            for (size_t k = 0; k <= j; k++) {
                double sum = j == k ? -1.0 : 0.0;
                for (size_t i = 0; i < POINTS; i++) {
                    sum += q[i + j * POINTS] * masses[i] * q[i + k * POINTS];
                }
                defect = fmax(defect, fabs(sum));
            }
        }
        for (size_t i = 0; i < POINTS; i++) {
            for (size_t j = 0; j < COLUMNS; j++) {
                double sum = -a[i + j * POINTS];
                for (size_t k = 0; k < rank; k++) {
                    sum += q[i + k * POINTS] * r[k + j * COLUMNS];
                }
                gap = fmax(gap, fabs(sum));
            }
            /* Legendre's second polynomial, of length 1. */
            const double x = -1.0 + (2.0 * (double)i + 1.0) / POINTS;
            const double p2 = sqrt(2.5) * 0.5 * (3.0 * x * x - 1.0);
            legendre = fmax(legendre, fabs(q[i + 2 * POINTS] - p2));
        }
        printf("rank %zu of %d columns, the last one kept is %zu\n", rank, COLUMNS, kept[rank - 1]);
        printf("orthonormal up to %.1e, Q R = A up to %.1e, Legendre up to %.1e\n", defect, gap,
               legendre);
    } else {
        fprintf(stderr, "%s: %s\n", cata_status_name(status), cata_last_error_message());
    }
    free(a);
    free(q);
    free(masses);
    const int good = status == CATA_OK && rank == COLUMNS - 1 && kept[rank - 1] == COLUMNS - 2 &&
                     defect < 1e-12 && gap < 1e-12 && legendre < 1e-4;
    if (status == CATA_OK && !good) {
        fprintf(stderr, "MISMATCH\n");
    }
    return good ? EXIT_SUCCESS : EXIT_FAILURE;
}
