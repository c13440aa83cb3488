/* A world needs an MPI that knows of threads. */

#include <catamaran_mpi.h>

#include <string.h>

#include "check.h"

int main(int argc, char** argv)
{
    MPI_Init(&argc, &argv);
    int level = -1;
    MPI_Query_thread(&level);
    cata_world* world = NULL;
    if (level == MPI_THREAD_SINGLE) {
        CHECK_STATUS(cata_world_from_comm(MPI_COMM_WORLD, &world), CATA_ERR_ARGUMENT);
        CHECK(world == NULL);
        CHECK(strstr(cata_last_error_message(), "MPI_THREAD_FUNNELED") != NULL);
    } else {
        /* This library gives more than it was asked for. */
        CHECK_STATUS(cata_world_from_comm(MPI_COMM_WORLD, &world), CATA_OK);
        cata_world_free(world);
    }
    MPI_Finalize();
    return report("mpi_threads");
}
