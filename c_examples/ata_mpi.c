/* Each rank makes some rows of a table; A^T A is summed over the ranks, gathered on rank 0 and checked there
 * against a plain loop.
 *
 *   mpirun -n 4 ./ata_mpi
 */

#include <catamaran_mpi.h>

#include <math.h>
#include <stdio.h>
#include <stdlib.h>

enum { ROWS = 1000, COLS = 30 };

/* Entry (i, j) of the table. */
static double entry(int i, int j)
{
    return sin(0.7 * i + 0.3 * j) + (double)(i % 7 == j % 5);
}

/* Ends the job if a call failed; every rank says why. */
static void check(cata_status status, int rank)
{
    if (status != CATA_OK) {
        fprintf(stderr, "rank %d: %s: %s\n", rank, cata_status_name(status),
                cata_last_error_message());
        MPI_Abort(MPI_COMM_WORLD, EXIT_FAILURE);
    }
}

static double largest_error(const double *c)
{
    double worst = 0.0;
    for (int j = 0; j < COLS; j++) {
        for (int k = 0; k < COLS; k++) {
            double sum = 0.0;
            for (int i = 0; i < ROWS; i++) {
                sum += entry(i, j) * entry(i, k);
            }
            if (!(fabs(c[j * COLS + k] - sum) <= worst)) {
                worst = fabs(c[j * COLS + k] - sum);
            }
        }
    }
    return worst;
}

int main(int argc, char **argv)
{
    int rank = 0, size = 1, provided = 0, failed = 0;
    cata_world *world = NULL;
    cata_symmetric *product = NULL;
    double c[COLS * COLS];

    MPI_Init_thread(&argc, &argv, MPI_THREAD_FUNNELED, &provided);
    MPI_Comm_rank(MPI_COMM_WORLD, &rank);
    MPI_Comm_size(MPI_COMM_WORLD, &size);
    check(cata_world_from_comm(MPI_COMM_WORLD, &world), rank);

    /* This rank's rows, one after another. */
    int first = ROWS * rank / size, end = ROWS * (rank + 1) / size;
    double *rows = malloc(sizeof(double) * (size_t)(end - first + 1) * COLS);
    if (rows == NULL) {
        MPI_Abort(MPI_COMM_WORLD, EXIT_FAILURE);
        return EXIT_FAILURE;
    }
    for (int i = first; i < end; i++) {
        for (int j = 0; j < COLS; j++) {
            rows[(i - first) * COLS + j] = entry(i, j);
        }
    }

    check(cata_world_ata_rows_f64(world, CATA_ROW_MAJOR, (size_t)(end - first), COLS, 1.0, rows, COLS,
                                  NULL, &product),
          rank);
    check(cata_symmetric_gather_f64(product, world, 0, CATA_ROW_MAJOR, CATA_BOTH, c, COLS), rank);

    if (rank == 0) {
        double worst = largest_error(c);
        failed = !(worst < 1e-10);
        printf("catamaran %s: A^T A of a %d x %d table on %d ranks, largest difference from the plain "
               "loop: %.1e\n",
               cata_version_string(), ROWS, COLS, size, worst);
        if (failed) {
            fputs("MISMATCH\n", stderr);
        }
    }

    cata_symmetric_free(product);
    cata_world_free(world);
    free(rows);
    MPI_Finalize();
    return failed ? EXIT_FAILURE : EXIT_SUCCESS;
}
