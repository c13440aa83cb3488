/* The covariance matrix of a table: A^T A of its centred rows, checked against a plain loop. */

#include <catamaran.h>

#include <math.h>
#include <stdio.h>
#include <stdlib.h>

enum { ROWS = 1000, COLS = 7 };

/* Heights, weights and the like would stand here; entry (i, j) of a row-major table. */
static void fill(double *table)
{
    unsigned state = 12345;
    for (int i = 0; i < ROWS; i++) {
        for (int j = 0; j < COLS; j++) {
            state = state * 1664525u + 1013904223u;
            table[i * COLS + j] = 100.0 * j + (double)(state >> 8) / 16777216.0;
        }
    }
}

static double naive_covariance(const double *table, int j, int k)
{
    double mean_j = 0.0, mean_k = 0.0, sum = 0.0;
    for (int i = 0; i < ROWS; i++) {
        mean_j += table[i * COLS + j] / ROWS;
        mean_k += table[i * COLS + k] / ROWS;
    }
    for (int i = 0; i < ROWS; i++) {
        sum += (table[i * COLS + j] - mean_j) * (table[i * COLS + k] - mean_k);
    }
    return sum / (ROWS - 1);
}

int main(void)
{
    double *table = malloc(sizeof(double) * ROWS * COLS);
    double covariance[COLS * COLS];
    double worst = 0.0;
    if (table == NULL) {
        fputs("out of memory\n", stderr);
        return EXIT_FAILURE;
    }
    fill(table);

    cata_status status = cata_ata_rows_f64(
        CATA_ROW_MAJOR, CATA_BOTH, ROWS, COLS, 1.0 / (ROWS - 1), table, COLS, NULL,
        CATA_CENTER_MEAN, NULL, 0.0, covariance, COLS, NULL);
    if (status != CATA_OK) {
        fprintf(stderr, "%s: %s\n", cata_status_name(status), cata_last_error_message());
        free(table);
        return EXIT_FAILURE;
    }

    printf("catamaran %s: covariance of a %d x %d table\n", cata_version_string(), ROWS, COLS);
    for (int j = 0; j < COLS; j++) {
        for (int k = 0; k < COLS; k++) {
            double error = fabs(covariance[j * COLS + k] - naive_covariance(table, j, k));
            printf("%9.5f", covariance[j * COLS + k]);
            if (!(error <= worst)) {
                worst = error;
            }
        }
        putchar('\n');
    }
    free(table);
    printf("largest difference from the plain loop: %.1e\n", worst);
    if (!(worst < 1e-12)) {
        fputs("MISMATCH\n", stderr);
        return EXIT_FAILURE;
    }
    return EXIT_SUCCESS;
}
