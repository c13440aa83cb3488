/* Eigenpairs of a grid whose rows are spread over the ranks, and polynomials made orthonormal over them; each rank makes
 * its rows alone. As a job:
 *
 *   #SBATCH --ntasks=4 --cpus-per-task=8
 *   srun ./eigs_mpi        (or mpirun -n 4 ./eigs_mpi)
 */

#include <catamaran_mpi.h>

#include <math.h>
#include <stdio.h>
#include <stdlib.h>

enum { SIDE = 40, N = SIDE * SIDE, K = 12, COLUMNS = 4 };

static size_t row_starts[N + 1], columns[5 * N];
static double entries[5 * N], expected[N], vectors[K * N], a[COLUMNS * N];
static int rank, size;

/* Ends the job if a call failed; every rank says why. */
static void check(cata_status status)
{
    if (status != CATA_OK) {
        fprintf(stderr, "rank %d: %s: %s\n", rank, cata_status_name(status), cata_last_error_message());
        MPI_Abort(MPI_COMM_WORLD, EXIT_FAILURE);
    }
}

/* Rows of the Laplacian of a grid graph. */
static void make_rows(size_t first, size_t end)
{
    size_t at = 0;
    for (size_t i = first; i < end; i++) {
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
        row_starts[i - first + 1] = at;
    }
}

static int ascending(const void *p, const void *q)
{
    const double x = *(const double *)p, y = *(const double *)q;
    return (x > y) - (x < y);
}

/* The largest |Q^T Q - I| of columns whose rows are spread. */
static double defect(const double *q, size_t own, int count)
{
    double worst = 0;
    for (int j = 0; j < count; j++) {
        for (int k = 0; k <= j; k++) {
            double sum = 0, all = 0;
            for (size_t i = 0; i < own; i++) {
                sum += q[(size_t)j * own + i] * q[(size_t)k * own + i];
            }
            MPI_Allreduce(&sum, &all, 1, MPI_DOUBLE, MPI_SUM, MPI_COMM_WORLD);
            worst = fmax(worst, fabs(all - (j == k)));
        }
    }
    return worst;
}

int main(int argc, char **argv)
{
    int provided = 0;
    cata_world *world = NULL;
    MPI_Init_thread(&argc, &argv, MPI_THREAD_FUNNELED, &provided);
    MPI_Comm_rank(MPI_COMM_WORLD, &rank);
    MPI_Comm_size(MPI_COMM_WORLD, &size);
    check(cata_world_from_comm(MPI_COMM_WORLD, &world));

    const size_t first = (size_t)N * (size_t)rank / (size_t)size;
    const size_t end = (size_t)N * (size_t)(rank + 1) / (size_t)size, own = end - first;
    make_rows(first, end);
    double values[K], residuals[K], worst = 0;
    /* Threads of this rank: all cores that srun or mpirun binds it to. */
    check(cata_world_eigs(world, own, N, row_starts, columns, entries, NULL, K, values, vectors, own, residuals,
                          NULL));
    for (size_t i = 0; i < N; i++) {
        expected[i] = 4 - 2 * cos(acos(-1) * (double)(i / SIDE) / SIDE) -
                      2 * cos(acos(-1) * (double)(i % SIDE) / SIDE);
    }
    qsort(expected, N, sizeof expected[0], ascending);
    for (int j = 0; j < K; j++) {
        worst = fmax(worst, fabs(values[j] - expected[j]));
    }

    for (size_t i = 0; i < own; i++) {
        for (int j = 0; j < COLUMNS; j++) {
            a[(size_t)j * own + i] = pow((double)(first + i) / N, j);
        }
    }
    size_t kept[COLUMNS], independent = 0;
    double r[COLUMNS * COLUMNS];
    check(cata_world_gram_schmidt(world, CATA_COL_MAJOR, own, COLUMNS, a, own, NULL, r, COLUMNS, kept, &independent,
                                  NULL));
    const double of_vectors = defect(vectors, own, K), of_columns = defect(a, own, COLUMNS);
    const int good = worst < 1e-9 && of_vectors < 1e-11 && independent == COLUMNS && of_columns < 1e-12;
    if (rank == 0) {
        printf("%d ranks: %d eigenvalues off by at most %.1e, vectors orthonormal up to %.1e; %zu columns up to %.1e\n",
               size, K, worst, of_vectors, independent, of_columns);
        if (!good) {
            fputs("MISMATCH\n", stderr);
        }
    }
    cata_world_free(world);
    MPI_Finalize();
    return good ? EXIT_SUCCESS : EXIT_FAILURE;
}
