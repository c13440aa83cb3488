/* A program of a BLAS whose dsyrk is replaced: the same arguments, and one that names the plan. */

#include <catamaran.h>

#include <cblas.h>

#include <math.h>
#include <stdio.h>
#include <stdlib.h>

enum { M = 600, N = 300 };

static double a[M * N], before[N * N], after[N * N];

int main(void)
{
    for (int i = 0; i < M * N; i++) {
        a[i] = sin(i * 0.37);
    }
    cblas_dsyrk(CblasRowMajor, CblasUpper, CblasTrans, N, M, 1.0, a, N, 0.0, before, N);
    if (cata_ata_f64(CATA_ROW_MAJOR, CATA_UPPER, M, N, 1.0, a, N, 0.0, after, N, NULL) != CATA_OK) {
        fprintf(stderr, "%s\n", cata_last_error_message());
        return EXIT_FAILURE;
    }
    double error = 0;
    for (int i = 0; i < N * N; i++) {
        error = fmax(error, fabs(before[i] - after[i]));
    }
    printf("results differ by at most %.2g\n", error);
    return error < 1e-10 ? EXIT_SUCCESS : EXIT_FAILURE;
}
