/* All eigenpairs of a grid below a bound: counted first, then computed in slices of which one at a time is in memory,
 * and compared with the known eigenvalues. */

#include <catamaran.h>

#include <math.h>
#include <stdio.h>
#include <stdlib.h>

enum { SIDE = 60, N = SIDE * SIDE };

static size_t row_starts[N + 1], columns[5 * N];
static double entries[5 * N], expected[N];

/* The Laplacian of a grid graph: a sum of those of two paths. */
static void make_grid(void)
{
    size_t at = 0;
    for (size_t i = 0; i < N; i++) {
        const size_t x = i / SIDE, y = i % SIDE;
        const size_t has[5] = {x > 0, y > 0, 1, y + 1 < SIDE, x + 1 < SIDE};
        const size_t near[5] = {i - SIDE, i - 1, i, i + 1, i + SIDE};
        const size_t degree = has[0] + has[1] + has[3] + has[4];
        for (int k = 0; k < 5; k++) {
            if (has[k]) {
                columns[at] = near[k];
                entries[at++] = k == 2 ? (double)degree : -1;
            }
        }
        row_starts[i + 1] = at;
        expected[i] = 4 - 2 * cos(acos(-1) * (double)x / SIDE) - 2 * cos(acos(-1) * (double)y / SIDE);
    }
}

static int ascending(const void *a, const void *b)
{
    const double x = *(const double *)a, y = *(const double *)b;
    return (x > y) - (x < y);
}

typedef struct {
    size_t slices, pairs;
    double worst, residual;
} outcome;

/* Real work would write the vectors to a file here. */
static int32_t take(size_t count, const double *eigenvalues, const double *eigenvectors, size_t ldv,
                    const double *residuals, void *user)
{
    outcome *found = user;
    (void)eigenvectors;
    (void)ldv;
    for (size_t j = 0; j < count; j++) {
        found->worst = fmax(found->worst, fabs(eigenvalues[j] - expected[found->pairs++]));
        found->residual = fmax(found->residual, residuals[j]);
    }
    found->slices++;
    return 0;
}

int main(void)
{
    outcome found = {0, 0, 0, 0};
    size_t k = 0;
    make_grid();
    qsort(expected, N, sizeof expected[0], ascending);
    /* In a gap between two eigenvalues. */
    size_t wanted = 200;
    while (expected[wanted] - expected[wanted - 1] < 1e-3) {
        wanted++;
    }
    const double bound = 0.5 * (expected[wanted - 1] + expected[wanted]);
    cata_status status = cata_eigs_count(N, row_starts, columns, entries, NULL, bound, &k, NULL);
    if (status == CATA_OK) {
        status = cata_eigs_sliced(N, row_starts, columns, entries, NULL, k, 14 << 20, take, &found, NULL);
    }
    if (status != CATA_OK) {
        fprintf(stderr, "%s: %s\n", cata_status_name(status), cata_last_error_message());
        return EXIT_FAILURE;
    }
    printf("%zu eigenvalues below %.4f, in %zu slices, off by at most %.1e, residuals up to %.1e\n", found.pairs,
           bound, found.slices, found.worst, found.residual);
    const int good = k == wanted && found.pairs == k && found.slices > 1 && found.worst < 1e-10 &&
                     found.residual <= 1e-9;
    if (!good) {
        fprintf(stderr, "MISMATCH\n");
    }
    return good ? EXIT_SUCCESS : EXIT_FAILURE;
}
