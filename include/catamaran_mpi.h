/* Catamaran on the ranks of an MPI communicator: a thin layer over catamaran.h that takes an MPI_Comm.
 *
 * Everything is inline and calls the functions cata_world_* and cata_symmetric_* of catamaran.h; the library must
 * have been built with MPI (CATA_CAP_MPI), the same one as <mpi.h> belongs to. C99 and C++17.
 *
 * MIT OR Apache-2.0
 */

#ifndef CATAMARAN_MPI_H
#define CATAMARAN_MPI_H

#include "catamaran.h"

#include <mpi.h>

/**
 * The world of the ranks of `comm`, of which a duplicate is made. Collective over it.
 *
 * - `comm`: an intracommunicator; it may be freed while the world lives.
 * - `world`: one pointer, not NULL; written on success only. Free it by cata_world_free, before MPI_Finalize.
 *
 * Returns what cata_world_new does: CATA_ERR_ARGUMENT when MPI is not initialized, was initialized with less
 * than MPI_THREAD_FUNNELED, or is finalized already, and for MPI_COMM_NULL.
 *
 * Not thread-safe: MPI_Comm_dup is called.
 */
static inline cata_status cata_world_from_comm(MPI_Comm comm, cata_world **world)
{
    int initialized = 0, finalized = 0;
    int handle = 0;
    MPI_Initialized(&initialized);
    MPI_Finalized(&finalized);
    /* MPI would abort; cata_world_new says what is wrong. */
    if (initialized && !finalized) {
        handle = (int)MPI_Comm_c2f(comm);
    }
    return cata_world_new(handle, world);
}

#endif
