#include <catamaran_mpi.h>

#include <stdio.h>

int main(int argc, char **argv)
{
    int provided = 0;
    MPI_Init_thread(&argc, &argv, MPI_THREAD_FUNNELED, &provided);
    cata_world *world = NULL;
    size_t ranks = 0;
    if (cata_world_from_comm(MPI_COMM_WORLD, &world) != CATA_OK
        || cata_world_size(world, &ranks) != CATA_OK) {
        fprintf(stderr, "%s\n", cata_last_error_message());
        return 1;
    }
    printf("ranks: %zu\n", ranks);
    cata_world_free(world);
    MPI_Finalize();
    return ranks != 1;
}
