// The header in C++17: one product, under mpirun.

#include <catamaran_mpi.h>

#include <cstddef>

#include "check.h"

int main(int argc, char** argv)
{
    int provided = 0;
    MPI_Init_thread(&argc, &argv, MPI_THREAD_FUNNELED, &provided);
    cata_world* world = nullptr;
    CHECK_STATUS(cata_world_from_comm(MPI_COMM_WORLD, &world), CATA_OK);
    std::size_t rank = 0, size = 0;
    CHECK_STATUS(cata_world_rank(world, &rank), CATA_OK);
    CHECK_STATUS(cata_world_size(world, &size), CATA_OK);
    // Row (rank + 1, 2) on each rank.
    const double row[2] = {static_cast<double>(rank + 1), 2.0};
    double c[4] = {0.0, 0.0, 0.0, 0.0};
    cata_symmetric* product = nullptr;
    CHECK_STATUS(cata_world_ata_rows_f64(world, CATA_ROW_MAJOR, 1, 2, 1.0, row, 2, nullptr, &product),
                 CATA_OK);
    CHECK_STATUS(cata_symmetric_gather_f64(product, world, 0, CATA_ROW_MAJOR, CATA_BOTH, c, 2), CATA_OK);
    const double p = static_cast<double>(size);
    CHECK(rank != 0 || (c[0] == p * (p + 1) * (2 * p + 1) / 6 && c[1] == p * (p + 1) && c[3] == 4 * p));
    cata_symmetric_free(product);
    cata_world_free(world);
    MPI_Finalize();
    return report("mpi_cpp");
}
