/* The components of find_package that the library itself says it has, one a line. */
#include <catamaran.h>

#include <stdio.h>

int main(void)
{
    const uint64_t have = cata_capabilities();
    const struct {
        uint64_t bit;
        const char *name;
    } all[] = {{CATA_CAP_OPENBLAS, "openblas"}, {CATA_CAP_OPENCL, "opencl"},
               {CATA_CAP_HDF5, "hdf5"}, {CATA_CAP_MPI, "mpi"}};
    for (size_t i = 0; i < sizeof all / sizeof all[0]; i++) {
        if (have & all[i].bit) {
            puts(all[i].name);
        }
    }
    return 0;
}
