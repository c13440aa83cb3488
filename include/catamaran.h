/* Catamaran: A^T A, spectra and geometry at scale. The C interface.
 *
 * Generated from capi/src by `cargo xtask header`: do not edit. MIT OR Apache-2.0.
 *
 * Conventions
 * - Names: cata_<chapter>_<what>; _f64 and _f32 (_c64 and _c32: complex) where there are several
 *   scalars.
 * - Results: a function that can fail returns a cata_status: CATA_OK (0), or the kind of error,
 *   which cata_last_error_message explains. After an error outputs are untouched, unless the
 *   function says otherwise. Functions that need a capability that this build lacks return
 *   CATA_ERR_UNSUPPORTED (cata_capabilities).
 * - Sizes are size_t, any, 0 included, and numbers of elements, never bytes.
 * - Pointers may be NULL only where the function says so, or where there is no element to point to.
 *   They are not kept after the call. An output that overlaps another one or an input is
 *   CATA_ERR_ARGUMENT.
 * - Matrices: `layout` is CATA_ROW_MAJOR or CATA_COL_MAJOR, for all matrices of a call. m x n
 *   elements at `a` are m rows (n columns) of n (m) elements, each `lda` >= max(1, n) (max(1, m))
 *   elements after the one before. What lies between is neither read nor written.
 * - Meshes: `n_vertices`, `vertices` (x, y, z of each: 3 n_vertices doubles, finite), `n_faces`,
 *   `faces` (three vertices of each: 3 n_faces uint32_t, from 0, counter-clockwise as seen from
 *   outside).
 * - Parameters: `params` is NULL for the defaults, or a struct whose first field is its sizeof;
 *   all others are 0 (NULL) by default, and 0 stands for the default: after `cata_ata_params
 *   params = {.struct_size = sizeof params};`, which is what cata_ata_params_init does, only what
 *   differs is set. Later versions add fields at the end; one that the library does not know must
 *   be 0. It is read during the call; a handle that is made keeps `progress` and `progress_user`
 *   for its own calls.
 * - Handles: where sizes of results follow from the arguments, results are written into arrays of
 *   the caller. Elsewhere, and where there is a state to keep, the call makes a handle, a pointer
 *   to an opaque struct, whose functions tell the sizes and copy the values. Each has a `_free`,
 *   to be called once, for which NULL does nothing.
 * - Threads: functions may be called from any thread, and at the same time, as long as no output
 *   is shared and nobody else uses a handle that a call takes without const. Each call uses up to
 *   `params.threads` threads, by default one for each core in the affinity mask of the process, or
 *   fewer where CATAMARAN_NUM_THREADS or RAYON_NUM_THREADS is set to a lower number. Their number
 *   changes no result, not by a bit. Calls at the same time share the threads of the process,
 *   which cata_threads_release ends.
 * - Rounding: numbers are rounded to nearest, and subnormal numbers are kept, whatever mode the
 *   calling thread has set (fesetround, flush-to-zero); it has the same mode after the call. So no
 *   result encloses an exact value. Progress callbacks and back ends run in the mode to nearest.
 */

#ifndef CATAMARAN_H
#define CATAMARAN_H

#include <stddef.h>
#include <stdint.h>

#define CATA_VERSION_MAJOR 0 /**< Of this header. */
#define CATA_VERSION_MINOR 1 /**< Of this header. */
#define CATA_VERSION_PATCH 0 /**< Of this header. */
#define CATA_VERSION_STRING "0.1.0" /**< Of this header. */

#ifdef __cplusplus
extern "C" {
#endif // __cplusplus

/* ==== Status, version, memory =============================================================== */
/**
 * @defgroup status Status, version, memory
 * Functions that can fail return a status. Others report the capabilities and the version of the
 * build, or release the scratch memory and the threads that are kept between calls.
 * @code{.c}
 * if (cata_memory_release() != CATA_OK) {
 *     fprintf(stderr, "%s\n", cata_last_error_message());
 * }
 * printf("catamaran %s\n", cata_version_string());
 * @endcode
 * @{
 */

/** What a call returns. A value with a meaning keeps it forever. */
typedef int32_t cata_status;

#define CATA_OK 0 /**< Done. */
#define CATA_ERR_NULL 1 /**< A pointer is NULL where it may not be. */
#define CATA_ERR_SHAPE 2 /**< A size is too small, does not fit, or overflows. */
#define CATA_ERR_ARGUMENT 3 /**< An argument is outside its range. */
#define CATA_ERR_NON_FINITE 4 /**< A NaN or an infinity where only finite numbers are allowed. */
#define CATA_ERR_NOT_CONVERGED 5 /**< An iteration ended before it reached its tolerance. */
#define CATA_ERR_IO 6 /**< A file could not be read or written. */
#define CATA_ERR_OUT_OF_MEMORY 7 /**< Memory could not be allocated. */
#define CATA_ERR_BACKEND 8 /**< A BLAS back end could not be loaded, or refused a request. */
#define CATA_ERR_CANCELLED 9 /**< The progress callback asked to stop. */
#define CATA_ERR_UNSUPPORTED 10 /**< This build or version can't do it (cata_capabilities). */
#define CATA_ERR_PANIC 11 /**< A bug in Catamaran, caught; the library stays usable. */

/** Another rank failed, or its arguments disagree; the message names it. */
#define CATA_ERR_RANK 12
#define CATA_ERR_MESH 13 /**< A mesh or plant is invalid; the message names the element. */

/** Returns the message of the last call of this thread that failed, in UTF-8, NUL-terminated; empty
 * when none has. A call that succeeds leaves it alone. Never NULL.
 *
 * The pointer is valid until the next call of this thread that fails, and not after the
 * thread's end; do not free it. */
const char *cata_last_error_message(void);

/** Returns the name of a status, such as "CATA_ERR_SHAPE"; "unknown status" for any other value.
 * Static, never NULL; do not free it. */
const char *cata_status_name(cata_status status);

#define CATA_CAP_OPENBLAS 1 /**< Bit of cata_capabilities: OpenBLAS is linked in. */
#define CATA_CAP_MPI 2 /**< Bit of cata_capabilities: MPI is linked in. */
#define CATA_CAP_OPENCL 4 /**< Bit of cata_capabilities: kernels for OpenCL devices. */
#define CATA_CAP_HDF5 8 /**< Bit of cata_capabilities: rows from HDF5 files. */
#define CATA_CAP_CHAPTERS 16 /**< Bit of cata_capabilities: all chapters, not A^T A alone. */

/** Gets the version of the library that runs, which may be newer than the header's. NULL where a
 * part is not wanted. */
cata_status cata_version(int32_t *major, int32_t *minor, int32_t *patch);

/** Returns the version as "major.minor.patch". Static, never NULL; do not free it. */
const char *cata_version_string(void);

/** Returns what this build of the library can do: a sum of CATA_CAP_* bits. The functions of an
 * absent capability exist, and return CATA_ERR_UNSUPPORTED. */
uint64_t cata_capabilities(void);

/** Frees the memory that products keep for later ones, at most 1.25 GiB, except what is in use. */
cata_status cata_memory_release(void);

/** Ends the threads that the library keeps between calls, and waits until they have ended.
 *
 * Later calls start new threads. A call that runs at the same time keeps its threads until it
 * returns. */
cata_status cata_threads_release(void);

/** @} */

/* ==== Threads and progress ================================================================== */
/**
 * @defgroup progress Threads and progress
 * @code{.c}
 * static int32_t tell(double fraction, void *wanted)
 * {
 *     fprintf(stderr, "\r%3.0f %%", 100 * fraction);
 *     return *(int *)wanted == 0; // 1: stop
 * }
 * @endcode
 * @{
 */

/** A progress callback: `fraction` of the work done, in [0, 1]. Returns 0 to continue; anything
 * else asks to stop soon, and the call then returns CATA_ERR_CANCELLED.
 *
 * It is called from any thread that works for the call, one call at a time: each begins after
 * the one before it has returned, and sees what that has written. No thread waits for it, so it
 * may be slow, and it may call this library. It must not leave by longjmp or a C++ exception. */
typedef int32_t (*cata_progress)(double fraction, void *user);

/** @} */

/* ==== Back ends ============================================================================= */
/**
 * @defgroup backend Back ends
 * A BLAS library may compute the small products that schemes end in.
 * @code{.c}
 * double a[] = {1, 2, 3, 4, 5, 6}, c[4];
 * cata_backend *backend;
 * if (cata_backend_load("libopenblas.so.0", &backend) == CATA_OK) {
 *     cata_ata_params params = {.struct_size = sizeof params, .backend = backend};
 *     cata_ata_f64(CATA_ROW_MAJOR, CATA_BOTH, 3, 2, 1, a, 2, 0, c, 2, &params);
 *     cata_backend_free(backend);
 * }
 * @endcode
 * @{
 */

/** A BLAS library that computes the small products, for several calls and threads at a time. */
typedef struct cata_backend cata_backend;

/** Loads the shared library at `path` (MKL's libmkl_rt.so, libopenblas.so, libblis.so, ...),
 * which must have the CBLAS interface with 32-bit integers; without a slash the system's search
 * path is used. Its initializers run: load only what you trust. CATA_ERR_BACKEND when there is
 * no such file or it is not such a library. */
cata_status cata_backend_load(const char *path, cata_backend **backend);

/** Gets the OpenBLAS that the library was linked with; needs CATA_CAP_OPENBLAS. */
cata_status cata_backend_openblas(cata_backend **backend);

/** Returns the short name of a back end, such as "openblas" or the file name of a loaded library,
 * in UTF-8; valid until cata_backend_free; empty for NULL. Never NULL; do not free it. */
const char *cata_backend_name(const cata_backend *backend);

void cata_backend_free(cata_backend *backend); /**< Frees a back end. */

/** @} */

/* ==== A^T A ================================================================================= */
/**
 * @defgroup ata A^T A
 * Dense products: symmetric, of two matrices, Hermitian; of a sparse matrix; and a
 * probabilistic check.
 * @code{.c}
 * double a[] = {1, 2, 3, 4, 5, 6}, c[4]; // 3 x 2
 * cata_ata_f64(CATA_ROW_MAJOR, CATA_BOTH, 3, 2, 1, a, 2, 0, c, 2, NULL);
 * printf("%g %g %g\n", c[0], c[1], c[3]); // 35 44 56
 * @endcode
 * @{
 */

#define CATA_ROW_MAJOR 101 /**< `layout`: entry (i, j) is `a[i * lda + j]`. */
#define CATA_COL_MAJOR 102 /**< `layout`: entry (i, j) is `a[i + j * lda]`. */
#define CATA_UPPER 121 /**< `uplo`: the triangle on and above the diagonal. */
#define CATA_LOWER 122 /**< `uplo`: the triangle on and below the diagonal. */
#define CATA_BOTH 123 /**< `uplo`: both, equal; with beta != 0 the old lower one is read. */

#define CATA_SCHEME_AUTO 0 /**< `scheme`: the fastest within the requested accuracy. */
#define CATA_SCHEME_CLASSICAL 1 /**< `scheme`: no fast products, blocks over the back end. */
#define CATA_SCHEME_ATA2 2 /**< `scheme`: AtA over Strassen's, 2 x 2, down to the cache. */
#define CATA_SCHEME_WINOGRAD 3 /**< `scheme`: 2 x 2 over Winograd's variant of Strassen's. */
#define CATA_SCHEME_RXTX 4 /**< `scheme`: RXTX (4 x 4 blocks) over Winograd's variant. */
#define CATA_SCHEME_KGP4 5 /**< `scheme`: 4 x 4 of Khoruzhii, Gelss and Pokutta. */
#define CATA_SCHEME_KGP3 6 /**< `scheme`: 3 x 3 of Khoruzhii, Gelss and Pokutta. */

/** `scheme`: integer products modulo small coprime numbers: nothing is rounded but the columns, to
 * about 2^-54 of their norms (float: 2^-27), and the result. */
#define CATA_SCHEME_EXACT 7
#define CATA_SCHEME_FLOAT 8 /**< `scheme`: as CATA_SCHEME_AUTO, but never CATA_SCHEME_EXACT. */

/** `error_factor`: the least error. With CATA_SCHEME_AUTO that is CATA_SCHEME_EXACT on every
 * machine, however slow it is there; other schemes are as with 1. */
#define CATA_ERROR_LEAST -1.0

/** How a product is computed. */
typedef struct cata_ata_params {
    size_t struct_size; /**< sizeof(cata_ata_params). */
    size_t threads; /**< Threads, at most; 0: all. */
    cata_progress progress; /**< Progress callback; NULL: none. */
    void *progress_user; /**< Passed to `progress`. */
    /** Smallest block side of the recursion, in elements, at most 2^31; 0: the library's
     * choice. */
    size_t leaf;
    /** Tasks that C is split into, whatever the number of threads, at most 65536; 0: the
     * library's choice. Of no effect where the built-in kernels share C in their own way. */
    size_t tasks;
    /** Error that fast products may cause, as a factor of the classical algorithm's in the
     * maximum norm, expected: 1 for classical products only, INFINITY for no bound,
     * CATA_ERROR_LEAST for the least error, 0 for the default, which is 4. Not below 1
     * otherwise, and not NaN. CATA_SCHEME_EXACT takes 15 moduli for 1 and CATA_ERROR_LEAST, 13
     * from 8 on, and otherwise 14 for A^T A and 15 for A^T B (float: 8, 6, 7 and 8). */
    double error_factor;
    /** Back end of the small products; NULL: the built-in one. Borrowed during the call. */
    const cata_backend *backend;
    int32_t scheme; /**< CATA_SCHEME_*. */
    /** 1: the same bytes on every machine, which takes CATA_SCHEME_EXACT everywhere, slower than
     * others on CPUs without AMX; the scheme must be that or CATA_SCHEME_AUTO. 0: not asked
     * for. */
    int32_t reproducible;
    /** 1: thread i of the call stays on the i-th core of the affinity mask (modulo their
     * number), which is that of the process, as taskset or the binding of mpirun sets it; the
     * calling thread waits and keeps its mask. Calls at the same time share these threads. 0:
     * the system moves threads. */
    int32_t pin;
} cata_ata_params;
/** Fills a struct with the defaults. */
cata_status cata_ata_params_init(cata_ata_params *params, size_t struct_size);

/** Computes C := alpha A^T A + beta C, for A m x n and C n x n.
 * - `uplo`: the part of C that is wanted, CATA_UPPER, CATA_LOWER or CATA_BOTH; the rest is
 *   neither read nor written.
 * - `alpha`: with 0, A is not read.
 * - `beta`: with 0, C is not read, so it may be uninitialized.
 *
 * The workspace is allocated before C is first written: C is untouched after any error but
 * CATA_ERR_CANCELLED and CATA_ERR_PANIC, which leave unspecified values in its wanted part.
 *
 * With u = 2^-53 (float: 2^-24) entry (i, j) of a classical product is wrong by at most about m
 * u (|A|^T |A|)(i, j); that of CATA_SCHEME_EXACT with the default `error_factor` by at most
 * (1.1e-16 sqrt(m) + u) |a_i| |a_j| (float: 1.7e-8 for 1.1e-16), the Euclidean norms of two
 * columns, far below which it may have no correct digit; fast products are bounded in the
 * maximum norm only. CATA_SCHEME_AUTO may take any of them unless `error_factor` is 1, which
 * allows only the first, or CATA_ERROR_LEAST. NaN and infinities reach the entries of C of
 * their columns, in classical and exact products; fast products spread them further. */
cata_status cata_ata_f64(int32_t layout, int32_t uplo, size_t m, size_t n, double alpha,
    const double *a, size_t lda, double beta, double *c, size_t ldc, const cata_ata_params *params);

/** Computes cata_ata_f64 in float. */
cata_status cata_ata_f32(int32_t layout, int32_t uplo, size_t m, size_t n, float alpha,
    const float *a, size_t lda, float beta, float *c, size_t ldc, const cata_ata_params *params);

/** Computes cata_ata_f64 with A in float, in blocks: sums and products are in double. C holds
 * unspecified values in its wanted part after CATA_ERR_OUT_OF_MEMORY too. */
cata_status cata_ata_f32_f64(int32_t layout, int32_t uplo, size_t m, size_t n, double alpha,
    const float *a, size_t lda, double beta, double *c, size_t ldc, const cata_ata_params *params);

/** Gets the length of the scratch of cata_ata_with_scratch_f64 for the same m, n and params. */
cata_status cata_ata_scratch_len_f64(size_t m, size_t n, const cata_ata_params *params,
    size_t *len);

/** Gets the length as cata_ata_scratch_len_f64 does, in float. */
cata_status cata_ata_scratch_len_f32(size_t m, size_t n, const cata_ata_params *params,
    size_t *len);

/** Computes cata_ata_f64 in scratch of the caller, with any contents and at least the length from
 * cata_ata_scratch_len_f64. It is overwritten. */
cata_status cata_ata_with_scratch_f64(int32_t layout, int32_t uplo, size_t m, size_t n,
    double alpha, const double *a, size_t lda, double beta, double *c, size_t ldc, double *scratch,
    size_t scratch_len, const cata_ata_params *params);

/** Computes cata_ata_with_scratch_f64 in float. */
cata_status cata_ata_with_scratch_f32(int32_t layout, int32_t uplo, size_t m, size_t n, float alpha,
    const float *a, size_t lda, float beta, float *c, size_t ldc, float *scratch,
    size_t scratch_len, const cata_ata_params *params);

/** Computes C := alpha A A^T + beta C, for A m x n and C m x m. The rest as in cata_ata_f64. */
cata_status cata_aat_f64(int32_t layout, int32_t uplo, size_t m, size_t n, double alpha,
    const double *a, size_t lda, double beta, double *c, size_t ldc, const cata_ata_params *params);

/** Computes cata_aat_f64 in float. */
cata_status cata_aat_f32(int32_t layout, int32_t uplo, size_t m, size_t n, float alpha,
    const float *a, size_t lda, float beta, float *c, size_t ldc, const cata_ata_params *params);

/** Computes C_i := alpha A_i^T A_i + beta C_i for each of `count` matrices, with the bytes of
 * cata_ata_f64. Threads share the products; `progress` is called after some of them. The C_i hold
 * unspecified values in their wanted parts after CATA_ERR_OUT_OF_MEMORY too.
 * - `stride_a`: elements from one A_i to the next; the A_i may overlap.
 * - `stride_c`: the same of C, at least the elements from the first to the last entry of a C_i,
 *   all of which count as its memory. */
cata_status cata_ata_batched_f64(int32_t layout, int32_t uplo, size_t count, size_t m, size_t n,
    double alpha, const double *a, size_t lda, size_t stride_a, double beta, double *c, size_t ldc,
    size_t stride_c, const cata_ata_params *params);

/** Computes cata_ata_batched_f64 in float. */
cata_status cata_ata_batched_f32(int32_t layout, int32_t uplo, size_t count, size_t m, size_t n,
    float alpha, const float *a, size_t lda, size_t stride_a, float beta, float *c, size_t ldc,
    size_t stride_c, const cata_ata_params *params);

/** Computes cata_ata_batched_f64 for matrices at `count` pointers each. No C_i may overlap another
 * matrix; blocks of one matrix do not. */
cata_status cata_ata_batched_pointers_f64(int32_t layout, int32_t uplo, size_t count, size_t m,
    size_t n, double alpha, const double *const *a, size_t lda, double beta, double *const *c,
    size_t ldc, const cata_ata_params *params);

/** Computes cata_ata_batched_pointers_f64 in float. */
cata_status cata_ata_batched_pointers_f32(int32_t layout, int32_t uplo, size_t count, size_t m,
    size_t n, float alpha, const float *const *a, size_t lda, float beta, float *const *c,
    size_t ldc, const cata_ata_params *params);

/** Computes C := alpha A^T W A + beta C, for a sparse A, m x n, weights W or none, and C n x n,
 * dense. The sums are those of the classical algorithm, in double and in the order of the rows.
 * - `row_starts`: m + 1 elements, read: the entries of row i are those from `row_starts[i]` to
 *   `row_starts[i + 1] - 1`, the first being 0.
 * - `columns`, `entries`: `row_starts[m]` elements each, read: columns ascending within a row,
 *   from 0, each at most once, and the entries of A there.
 * - `weights`: m finite elements, read; NULL: all 1.
 * - `params`: `threads` and `progress` are used, the rest is only checked.
 *
 * The rest as in cata_ata_f64. */
cata_status cata_ata_sparse_f64(int32_t layout, int32_t uplo, size_t m, size_t n, double alpha,
    const size_t *row_starts, const size_t *columns, const double *entries, const double *weights,
    double beta, double *c, size_t ldc, const cata_ata_params *params);

/** Computes cata_ata_sparse_f64 with A and C in float; weights and sums are in double. */
cata_status cata_ata_sparse_f32(int32_t layout, int32_t uplo, size_t m, size_t n, float alpha,
    const size_t *row_starts, const size_t *columns, const float *entries, const double *weights,
    float beta, float *c, size_t ldc, const cata_ata_params *params);

/** Describes how cata_ata_f64 computes A^T A for the same m, n and params: the recursion, its tasks
 * and scratch, and the expected seconds on one core.
 *
 * `size`, `text`: so many elements, written: lines of text, cut to fit, with a NUL; 2048 is
 * enough. */
cata_status cata_ata_plan_f64(size_t m, size_t n, const cata_ata_params *params, size_t size,
    char *text);

/** Describes cata_ata_f32 as cata_ata_plan_f64 does. */
cata_status cata_ata_plan_f32(size_t m, size_t n, const cata_ata_params *params, size_t size,
    char *text);

/** Computes C := alpha A^T B + beta C, for A m x n, B m x k and C n x k. A and B may overlap. The
 * rest as in cata_ata_f64, with NaN and infinities of columns of A and of B. */
cata_status cata_atb_f64(int32_t layout, size_t m, size_t n, size_t k, double alpha,
    const double *a, size_t lda, const double *b, size_t ldb, double beta, double *c, size_t ldc,
    const cata_ata_params *params);

/** Computes cata_atb_f64 in float. */
cata_status cata_atb_f32(int32_t layout, size_t m, size_t n, size_t k, float alpha, const float *a,
    size_t lda, const float *b, size_t ldb, float beta, float *c, size_t ldc,
    const cata_ata_params *params);

/** Gets the length of the scratch of cata_atb_with_scratch_f64 for the same m, n, k and params. */
cata_status cata_atb_scratch_len_f64(size_t m, size_t n, size_t k, const cata_ata_params *params,
    size_t *len);

/** Gets the length as cata_atb_scratch_len_f64 does, in float. */
cata_status cata_atb_scratch_len_f32(size_t m, size_t n, size_t k, const cata_ata_params *params,
    size_t *len);

/** Computes cata_atb_f64 in scratch of the caller, with any contents and at least the length from
 * cata_atb_scratch_len_f64. It is overwritten. */
cata_status cata_atb_with_scratch_f64(int32_t layout, size_t m, size_t n, size_t k, double alpha,
    const double *a, size_t lda, const double *b, size_t ldb, double beta, double *c, size_t ldc,
    double *scratch, size_t scratch_len, const cata_ata_params *params);

/** Computes cata_atb_with_scratch_f64 in float. */
cata_status cata_atb_with_scratch_f32(int32_t layout, size_t m, size_t n, size_t k, float alpha,
    const float *a, size_t lda, const float *b, size_t ldb, float beta, float *c, size_t ldc,
    float *scratch, size_t scratch_len, const cata_ata_params *params);

/** Computes C := alpha A^H A + beta C, for complex A m x n and Hermitian C n x n; alpha and beta
 * are real.
 *
 * A complex element is two doubles, the real part and then the imaginary one, as `double
 * complex` of C99 and `std::complex<double>` of C++: pointers to those can be cast. Leading
 * dimensions count complex elements.
 * - `uplo`: as in cata_ata_f64. With CATA_BOTH the upper triangle is the conjugate of the lower
 *   one, bit for bit; with beta != 0 the old lower one is what is read.
 * - `c`: imaginary parts of its diagonal are not read, and become 0. C is untouched after any
 *   error but CATA_ERR_PANIC, which leaves unspecified values in its wanted part.
 *
 * The extra memory is that of a matrix like C, 64 MiB (or 1024 rows of A if those are longer),
 * and the scratch of cata_ata_f64 for as many rows.
 *
 * With u = 2^-53 (float: 2^-24) both parts of entry (i, j) of a product with the default params
 * are wrong by at most 8 m u |a_i| |a_j|, the Euclidean norms of two columns. NaN and
 * infinities have the effect of (x - i y)(u + i v) = (x u + y v) + i (x v - y u), term by term,
 * in classical and exact products; fast products spread them further. */
cata_status cata_aha_c64(int32_t layout, int32_t uplo, size_t m, size_t n, double alpha,
    const double *a, size_t lda, double beta, double *c, size_t ldc, const cata_ata_params *params);

/** Computes cata_aha_c64 in float: `float complex` and `std::complex<float>`. */
cata_status cata_aha_c32(int32_t layout, int32_t uplo, size_t m, size_t n, float alpha,
    const float *a, size_t lda, float beta, float *c, size_t ldc, const cata_ata_params *params);

/** Computes C := alpha A^H B + beta C, complex, for A m x n, B m x k, C n x k. A and B may overlap.
 * - `alpha`, `beta`: one complex element each, read; with beta == 0 C is not read. A real one
 *   multiplies both parts.
 *
 * The rest as in cata_aha_c64. */
cata_status cata_ahb_c64(int32_t layout, size_t m, size_t n, size_t k, const double *alpha,
    const double *a, size_t lda, const double *b, size_t ldb, const double *beta, double *c,
    size_t ldc, const cata_ata_params *params);

/** Computes cata_ahb_c64 in float: `float complex` and `std::complex<float>`. */
cata_status cata_ahb_c32(int32_t layout, size_t m, size_t n, size_t k, const float *alpha,
    const float *a, size_t lda, const float *b, size_t ldb, const float *beta, float *c, size_t ldc,
    const cata_ata_params *params);

/** Checks that C = alpha A^T A for A m x n and C n x n, up to rounding, with `rounds` random
 * vectors (Freivalds 1977), in time proportional to rounds (m n + n^2), on the calling thread.
 * CATA_OK whether C passed or not; CATA_ERR_NON_FINITE where A holds a NaN or an infinity, whose
 * place the message names.
 * - `uplo`: the part of C that is checked.
 * - `rounds`: 1 to 1000. A C with an entry wrong by more than twice the tolerance passes with
 *   probability at most 2^-rounds.
 * - `seed`: of the random vectors; the same seed gives the same answer.
 * - `passed`: written: 1 if C passed, else 0.
 * - `residual`, `tolerance`: written: the largest entry of |C X - alpha A^T (A X)|, and how
 *   large rounding may make it; NULL where not wanted. If the tolerance overflows, no C passes,
 *   and `passed` = 0 says nothing about C. */
cata_status cata_verify_f64(int32_t layout, int32_t uplo, size_t m, size_t n, double alpha,
    const double *a, size_t lda, const double *c, size_t ldc, int32_t rounds, uint64_t seed,
    int32_t *passed, double *residual, double *tolerance);

/** Checks a product in float as cata_verify_f64. The check itself is in double. */
cata_status cata_verify_f32(int32_t layout, int32_t uplo, size_t m, size_t n, double alpha,
    const float *a, size_t lda, const float *c, size_t ldc, int32_t rounds, uint64_t seed,
    int32_t *passed, double *residual, double *tolerance);

/** @} */

/* ==== Least squares, principal components, singular values ================================== */
/**
 * @defgroup gram Least squares, principal components, singular values
 * Results from a Gram matrix in extended precision, computed in one or two passes over the rows,
 * as accurate as by an orthogonal factorization.
 * @code{.c}
 * double a[] = {1, 0, 1, 1, 1, 2}, b[] = {1, 3, 5}, x[2]; // b = 1 + 2 t
 * cata_lstsq(CATA_ROW_MAJOR, 3, 2, 1, a, 2, b, 1, NULL, x, 1, NULL, NULL);
 * printf("%g %g\n", x[0], x[1]); // 1 2
 * @endcode
 * @{
 */

/** How a least-squares problem is solved. */
typedef struct cata_lstsq_params {
    size_t struct_size; /**< sizeof(cata_lstsq_params). */
    size_t threads; /**< Threads, at most; 0: all. */
    /** Progress callback; NULL: none. Fractions are those of the passes that form the Gram matrix;
     * the work after them tells 1 again. */
    cata_progress progress;
    void *progress_user; /**< Passed to `progress`. */
    /** Multiple of |X|^2 that is added to the minimized sum; finite, at least 0. The intercept is
     * not a part of X. */
    double ridge;
    int32_t intercept; /**< 1: a constant is fitted for each target too. 0: none. */
    /** 1: columns of A that depend on others are an error, CATA_ERR_ARGUMENT, whose message names
     * them. 0: the solution of least norm is returned. */
    int32_t refuse_dependent;
    double confidence; /**< Confidence of `result.lower` and `result.upper`, below 1; 0: 0.95. */
} cata_lstsq_params;

/** Results of least squares beside X. The caller sets `struct_size` and the pointers, each to an
 * array of its own or to NULL where it is not wanted; the call writes the arrays and the fields
 * after them. `cata_lstsq_result result = {.struct_size = sizeof result};` requests those fields
 * alone. */
typedef struct cata_lstsq_result {
    size_t struct_size; /**< sizeof(cata_lstsq_result). */
    /** k elements, written: |A x - b| of each target, weighted; 0 where it is below the rounding
     * of the Gram matrix. */
    double *residual_norms;
    /** k elements, written: 1 - |A x - b|^2 / |b|^2 of each target, with b about its mean where
     * there is an intercept; 1 for a residual of 0. */
    double *r_squared;
    /** k elements, written: the constant of each target; zeros without `params.intercept`. */
    double *intercepts;
    /** n x k, written, with the layout and the leading dimension of X: the standard error of
     * each coefficient; NaN without degrees of freedom. */
    double *standard_errors;
    /** k elements, written: the standard error of each constant; untouched without
     * `params.intercept`. */
    double *intercept_errors;
    /** n elements, of which the first n - `rank` are written: the columns of A, from 0, that
     * depend on others. */
    size_t *dependent;
    /** Written: columns of A that do not depend on others, as far as the precision can tell. */
    size_t rank;
    /** Written: rows of a weight other than 0, less the rank, and less one more with an
     * intercept; at least 0. */
    size_t degrees_of_freedom;
    /** Written: an estimate of the condition number of A, about the mean with an intercept, and
     * with sqrt(ridge) I below it. */
    double condition;
    /** Written: decimal digits of X, relative to its largest entry when columns of A have norm
     * 1, that agree with the exact solution; from 0 to 15.95. */
    double digits;
    /** n x k, written, with the layout and the leading dimension of X: each coefficient over its
     * standard error. */
    double *t_statistics;
    /** n x k, written, with the layout and the leading dimension of X: the probability of a t
     * statistic as far from 0, or farther, were the coefficient 0. */
    double *p_values;
    /** n x k, written, with the layout and the leading dimension of X: the lower end of the
     * confidence interval of each coefficient; see `params.confidence`. */
    double *lower;
    /** n x k, written, with the layout and the leading dimension of X: the upper end. */
    double *upper;
    /** k elements, written: the p value of each constant; untouched without `params.intercept`. */
    double *intercept_p_values;
    /** k elements, written: the lower end of the confidence interval of each constant; untouched
     * without `params.intercept`. */
    double *intercept_lower;
    /** k elements, written: the upper end; untouched without `params.intercept`. */
    double *intercept_upper;
    /** k elements, written: the standard deviation of the residuals of each target; NaN without
     * degrees of freedom. */
    double *residual_deviations;
    /** k elements, written: `r_squared`, adjusted for the number of coefficients. */
    double *adjusted_r_squared;
    /** k elements, written: the F statistic of each target, that all coefficients but the
     * constant are 0, with `rank` and `degrees_of_freedom` degrees of freedom; NaN with a ridge. */
    double *f_statistics;
    double *f_p_values; /**< k elements, written: the p value of each F statistic. */
    /** k symmetric matrices (n + 1) x (n + 1), one after another without gaps, written: the
     * covariance of the coefficients of each target, in row and column 0 of the constant; zeros
     * there without `params.intercept`. */
    double *covariances;
    size_t *observations; /**< One element, written: rows of a weight other than 0. */
} cata_lstsq_result;
/** Fills a struct with the defaults. */
cata_status cata_lstsq_params_init(cata_lstsq_params *params, size_t struct_size);

/** Computes the X (n x k) that minimizes |W^(1/2) (A X - B)|^2 + ridge |X|^2, for A m x n, B m x k
 * and W = diag(weights), from the Gram matrix of [A B] in extended precision.
 *
 * Where cata_gram_extended is exact, X is at least as accurate as by an orthogonal
 * factorization of A in double, up to condition numbers of about 2^48 of A with columns of norm
 * 1; see `result.digits`. Rows are read twice, in blocks; neither A nor B is copied as a whole.
 * - `m`, `n`: any, 0 included. `k`: number of targets, at least 1.
 * - `b`: B, m x k, read, with leading dimension `ldb`.
 * - `weights`: m finite numbers, at least 0, read; NULL: all 1.
 * - `x`: X, n x k, written, with leading dimension `ldx`; NULL where not wanted, `ldx` is then
 *   used for `result.standard_errors` only.
 * - `result`: one struct, read and written: see cata_lstsq_result; NULL where not wanted.
 *   Standard errors take a few times as long as X, and no time when they are not wanted. */
cata_status cata_lstsq(int32_t layout, size_t m, size_t n, size_t k, const double *a, size_t lda,
    const double *b, size_t ldb, const double *weights, double *x, size_t ldx,
    cata_lstsq_result *result, const cata_lstsq_params *params);

/** How principal components are computed. */
typedef struct cata_pca_params {
    size_t struct_size; /**< sizeof(cata_pca_params). */
    size_t threads; /**< Threads, at most; 0: all. */
    /** Progress callback; NULL: none. Fractions are those of the passes that form the Gram matrix;
     * the work after them tells 1 again. */
    cata_progress progress;
    void *progress_user; /**< Passed to `progress`. */
    /** 1: columns are divided by their standard deviations; those without variance are not. 0:
     * none is. */
    int32_t standardize;
} cata_pca_params;
/** Fills a struct with the defaults. */
cata_status cata_pca_params_init(cata_pca_params *params, size_t struct_size);

/** Computes the first principal components of the rows of A (m x n), from the Gram matrix of its
 * centred columns in extended precision. Components beyond the rank of the centred columns are
 * zeros, and so are their variances and singular values.
 * - `m`: at least 2. `n`: any, 0 included.
 * - `count`: number of components, at most n.
 * - `components`: count x n, written, with leading dimension `ldcomponents`: one row for each
 *   component, orthonormal, the most variance first; the first of the largest entries of a row
 *   is positive. NULL where not wanted; `ldcomponents` is then ignored.
 * - `explained_variance`: count elements, written: the variance along each component, with the
 *   divisor m - 1; NULL where not wanted.
 * - `explained_variance_ratio`: count elements, written: the same, divided by the variance of
 *   all columns; NULL where not wanted.
 * - `singular_values`: count elements, written: those of the centred (and standardized) rows;
 *   NULL where not wanted.
 * - `mean`: n elements, written: the mean of each column; NULL where not wanted.
 * - `scale`: n elements, written: the divisor of each column, its standard deviation or 1; NULL
 *   where not wanted. */
cata_status cata_pca(int32_t layout, size_t m, size_t n, const double *a, size_t lda, size_t count,
    double *components, size_t ldcomponents, double *explained_variance,
    double *explained_variance_ratio, double *singular_values, double *mean, double *scale,
    const cata_pca_params *params);

/** How a Gram matrix in extended precision is computed. */
typedef struct cata_gram_params {
    size_t struct_size; /**< sizeof(cata_gram_params). */
    size_t threads; /**< Threads, at most; 0: all. */
    /** Progress callback; NULL: none. Fractions are those of the passes that form the Gram matrix;
     * the work after them tells 1 again. */
    cata_progress progress;
    void *progress_user; /**< Passed to `progress`. */
} cata_gram_params;
/** Fills a struct with the defaults. */
cata_status cata_gram_params_init(cata_gram_params *params, size_t struct_size);

/** Computes the singular values of A (m x n), and its right singular vectors, from its Gram matrix
 * in extended precision: A = U diag(values) V^T, where column j of U is A v_j over the j-th value.
 *
 * With K the condition number of A with columns of norm 1, the relative error of every value,
 * the smallest included, is a few n 2^-53 plus K^2 2^-106 (K^2 2^-80 where cata_gram_extended
 * is not exact).
 * - `m`, `n`: any, 0 included. Time and memory suit m >= n.
 * - `values`: min(m, n) elements, written: descending; zeros where columns depend on others as
 *   far as the precision can tell. NULL where not wanted.
 * - `v`: V, n x min(m, n), written, with leading dimension `ldv`: an orthonormal column for
 *   each value that is not 0, and zeros for the others. NULL where not wanted; `ldv` is then
 *   ignored. */
cata_status cata_svd(int32_t layout, size_t m, size_t n, const double *a, size_t lda,
    double *values, double *v, size_t ldv, const cata_gram_params *params);

/** Computes the lower triangle of C = X^T W X as unevaluated sums of two doubles, high + low, where
 * X is A (m x n), or A with the mean of its rows subtracted from every row, and W = diag(weights).
 *
 * C is the same for any order of the rows. Where `exact` is 1, no entry of A was rounded, and
 * the two parts together are C rounded to about 106 bits; else entries were rounded to about
 * 2^-80 of the largest of their column.
 * - `weights`: m finite numbers, negative ones too, read; NULL: all 1.
 * - `centering`: CATA_CENTER_NONE or CATA_CENTER_MEAN (weighted if there are weights).
 * - `high`: n x n, with leading dimension `ldhigh`: the triangle on and below the diagonal is
 *   written, with C rounded to double; the rest is neither read nor written. NULL where not
 *   wanted; `ldhigh` is then ignored.
 * - `low`: the same, with leading dimension `ldlow`: what that rounding took away.
 * - `exact`: one int32_t, written: 1 or 0; NULL where not wanted. */
cata_status cata_gram_extended(int32_t layout, size_t m, size_t n, const double *a, size_t lda,
    const double *weights, int32_t centering, double *high, size_t ldhigh, double *low,
    size_t ldlow, int32_t *exact, const cata_gram_params *params);

/** Computes C := the correlation matrix (n x n) of the columns of A (m x n), from their Gram matrix
 * about the mean in extended precision: entries are within [-1, 1], and wrong by little more than
 * one rounding. Both triangles are written; rows and columns of a column without variance are NaN.
 * - `c`: C, written, with leading dimension `ldc`; must not overlap A. */
cata_status cata_gram_correlation(int32_t layout, size_t m, size_t n, const double *a, size_t lda,
    double *c, size_t ldc, const cata_gram_params *params);

/** Computes how far the columns of Q (m x n) are from orthonormal: Q^T Q - I is formed in extended
 * precision, and no digits are lost to cancellation.
 * - `q`: Q, read, with leading dimension `ldq` as A in cata_ata_f64.
 * - `max`: one double, written: the largest entry of Q^T Q - I by size; NULL where not wanted.
 * - `frobenius`: one double, written: the Frobenius norm of Q^T Q - I; NULL where not wanted. */
cata_status cata_gram_orthogonality(int32_t layout, size_t m, size_t n, const double *q, size_t ldq,
    double *max, double *frobenius, const cata_gram_params *params);

/** Factorizes A = Q R with orthonormal columns of Q, in place, by Cholesky QR with a Gram matrix in
 * extended precision: A (m x n) becomes Q. For columns that are independent;
 * cata_ortho_gram_schmidt takes any.
 *
 * Let K be the condition number of A with columns of norm 1. The columns of Q are orthonormal
 * up to rounding for K up to 10^14 where cata_gram_extended is exact, and up to an error of n
 * K^2 2^-79 otherwise.
 * - `m`, `n`: any, 0 included; m >= n, or the columns depend on each other.
 * - `a`: A, read and written, with leading dimension `lda` as in cata_ata_f64.
 * - `r`: R, n x n, written, with leading dimension `ldr`: upper triangular with a positive
 *   diagonal, zeros below; must not overlap A. NULL where not wanted; `ldr` is then ignored.
 *
 * Returns CATA_ERR_ARGUMENT when columns depend on those before them, which the message names.
 * A and R are unspecified after CATA_ERR_PANIC. */
cata_status cata_gram_cholesky_qr(int32_t layout, size_t m, size_t n, double *a, size_t lda,
    double *r, size_t ldr, const cata_gram_params *params);

/** @} */

/* ==== Streams of rows ======================================================================= */
/**
 * @defgroup rows Streams of rows
 * Products of weighted and centred rows, which are read in blocks.
 * @code{.c}
 * double a[] = {1, 2, 3, 4, 5, 6}, c[4]; // 3 x 2, its covariance
 * cata_ata_rows_f64(CATA_ROW_MAJOR, CATA_BOTH, 3, 2, 0.5, a, 2, NULL, CATA_CENTER_MEAN, NULL, 0,
 *     c, 2, NULL);
 * printf("%g\n", c[1]); // 4
 * @endcode
 * @{
 */

#define CATA_CENTER_NONE 0 /**< `centering`: nothing is subtracted from the rows. */
#define CATA_CENTER_MEAN 1 /**< `centering`: the (weighted) mean of the rows is subtracted. */
#define CATA_CENTER_GIVEN 2 /**< `centering`: the row given is subtracted. */

/** Computes C := alpha X^T W X + beta C, where X is A with a row subtracted from every row, and W =
 * diag(weights). A is read in blocks of rows, about 32 MiB each. With CATA_CENTER_MEAN and alpha =
 * 1 / (m - 1) C is the covariance matrix of the columns of A.
 * - `weights`: m finite numbers, negative ones too, read; NULL: all 1.
 * - `centering`: CATA_CENTER_NONE, CATA_CENTER_MEAN or CATA_CENTER_GIVEN.
 * - `center`: with CATA_CENTER_GIVEN n finite numbers, read; else ignored.
 *
 * The rest as in cata_ata_f64, but that C holds unspecified values after CATA_ERR_OUT_OF_MEMORY
 * too. CATA_ERR_ARGUMENT when the weights of a mean sum to 0. */
cata_status cata_ata_rows_f64(int32_t layout, int32_t uplo, size_t m, size_t n, double alpha,
    const double *a, size_t lda, const double *weights, int32_t centering, const double *center,
    double beta, double *c, size_t ldc, const cata_ata_params *params);

/** Computes cata_ata_rows_f64 in float; the mean is summed in double. */
cata_status cata_ata_rows_f32(int32_t layout, int32_t uplo, size_t m, size_t n, float alpha,
    const float *a, size_t lda, const float *weights, int32_t centering, const float *center,
    float beta, float *c, size_t ldc, const cata_ata_params *params);

#define CATA_SUMS_FLOAT 0 /**< `sums`: in double, up to rounding. */

/** `sums`: integers, within bounds that are given: the same bytes for any blocks, order, threads
 * and machines, and rows can be removed. */
#define CATA_SUMS_EXACT 1
#define CATA_SUMS_EXTENDED 2 /**< `sums`: exact, for least squares and the like. */

/** The sums X^T W X of rows X that come in blocks, with weights W, and results from them at any
 * time. Made by cata_accumulator_new or cata_accumulator_read. */
typedef struct cata_accumulator cata_accumulator;

/** The kind of sums of an accumulator, their bounds, and threads. */
typedef struct cata_accumulator_params {
    size_t struct_size; /**< sizeof(cata_accumulator_params). */
    size_t threads; /**< Threads, at most; 0: all. */
    /** Progress callback of each call that adds or removes rows; NULL: none. */
    cata_progress progress;
    void *progress_user; /**< Passed to `progress`. */
    /** n elements, read unless CATA_SUMS_FLOAT: a lower bound of the entries of each column. */
    const double *lower;
    /** n elements, read unless CATA_SUMS_FLOAT: an upper bound of the entries of each column. */
    const double *upper;
    uint64_t rows; /**< The most rows that are added, unless CATA_SUMS_FLOAT. */
    /** The largest weight of a row, unless CATA_SUMS_FLOAT; 0: rows have no weights. */
    double largest_weight;
    int32_t sums; /**< CATA_SUMS_*. */
    int32_t centered; /**< 1: about the mean of the rows. 0: about 0. */
} cata_accumulator_params;
/** Fills a struct with the defaults. */
cata_status cata_accumulator_params_init(cata_accumulator_params *params, size_t struct_size);

/** Creates an accumulator of no rows of n columns. */
cata_status cata_accumulator_new(size_t n, const cata_accumulator_params *params,
    cata_accumulator **accumulator);

/** Reads the accumulator of a file of cata_accumulator_write.
 * - `params`: threads and progress; the rest comes from the file. */
cata_status cata_accumulator_read(const char *path, const cata_accumulator_params *params,
    cata_accumulator **accumulator);

/** Writes an accumulator to a file, to continue elsewhere. A file of that name is replaced after
 * everything has been written, and stays otherwise. */
cata_status cata_accumulator_write(const cata_accumulator *accumulator, const char *path);

void cata_accumulator_free(cata_accumulator *accumulator); /**< Frees an accumulator. */

/** Adds the rows of A, m x n.
 *
 * After an error within the rows, such as a cancelled call, the accumulator must not be used any
 * more, and its calls fail; a first row or weight that is invalid leaves it unchanged.
 * - `weights`: m finite numbers, read; NULL: all 1. */
cata_status cata_accumulator_add(cata_accumulator *accumulator, int32_t layout, size_t m,
    const double *a, size_t lda, const double *weights);

/** Removes rows that were added, with the same weights, from sums of integers; the sums then have
 * the bytes of sums without these rows. Otherwise as cata_accumulator_add. */
cata_status cata_accumulator_remove(cata_accumulator *accumulator, int32_t layout, size_t m,
    const double *a, size_t lda, const double *weights);

/** Adds the rows of a file, which may be larger than memory: NAME.npy, or NAME.h5:/dataset with
 * CATA_CAP_HDF5. Otherwise as cata_accumulator_add. */
cata_status cata_accumulator_add_file(cata_accumulator *accumulator, const char *path);

/** Adds the rows of another accumulator of the same kind, which is not changed. */
cata_status cata_accumulator_merge(cata_accumulator *accumulator, const cata_accumulator *other);

/** Gets the number of rows, the sum of their weights, and the mean of each column (n elements; 0
 * unless `centered`). NULL where not wanted. */
cata_status cata_accumulator_rows(const cata_accumulator *accumulator, uint64_t *rows,
    double *weight, double *mean);

/** Computes C := alpha X^T W X, n x n, of the rows; 1 / (rows - 1) makes it a covariance matrix.
 * - `uplo`: the part of C that is written; the rest is neither read nor written. */
cata_status cata_accumulator_gram(const cata_accumulator *accumulator, int32_t layout, int32_t uplo,
    double alpha, double *c, size_t ldc);

/** Solves least squares, as cata_lstsq, with the first n - k columns of the rows for A and the last
 * k for B. The sums must be CATA_SUMS_EXTENDED, and `centered` with `params.intercept`. */
cata_status cata_accumulator_lstsq(const cata_accumulator *accumulator, size_t k, int32_t layout,
    double *x, size_t ldx, cata_lstsq_result *result, const cata_lstsq_params *params);

/** Computes principal components of the rows, as cata_pca. The sums must be CATA_SUMS_EXTENDED and
 * `centered`. */
cata_status cata_accumulator_pca(const cata_accumulator *accumulator, int32_t layout, size_t count,
    double *components, size_t ldcomponents, double *explained_variance,
    double *explained_variance_ratio, double *singular_values, double *mean, double *scale,
    const cata_pca_params *params);

/** @} */

/* ==== Tables ================================================================================ */
/**
 * @defgroup tables Tables
 * The matrix in a file: a text table as spreadsheets, R or pandas write it, .npy, or a dense
 * MatrixMarket file. What the file leaves open is an error that names the field which decides.
 * @code{.c}
 * cata_table *table = NULL;
 * if (cata_table_read("heights.csv", NULL, &table) == CATA_OK) {
 *     size_t rows, columns;
 *     cata_table_shape(table, &rows, &columns, NULL);
 *     double *entries = malloc(rows * columns * sizeof *entries);
 *     cata_table_entries(table, CATA_ROW_MAJOR, entries, columns);
 *     printf("the first column is called %s\n", cata_table_name(table, 0));
 *     free(entries);
 * }
 * cata_table_free(table);
 * @endcode
 * @{
 */

#define CATA_AUTO 0 /**< `header`, `index`: the file decides. */
#define CATA_YES 1 /**< `header`, `index`: there is one. */
#define CATA_NO 2 /**< `header`, `index`: there is none. */

/** `missing`: a row with a missing cell in a column that is used is an error. */
#define CATA_MISSING_ERROR 0
#define CATA_MISSING_DROP 1 /**< `missing`: such a row is left out. */
#define CATA_MISSING_NAN 2 /**< `missing`: such a cell becomes NaN. */

/** A matrix that was read, and what is known about its columns. Made by cata_table_read. */
typedef struct cata_table cata_table;

/** How a table is read. What is 0 or NULL, the file decides. */
typedef struct cata_table_params {
    size_t struct_size; /**< sizeof(cata_table_params). */
    size_t threads; /**< Threads, at most; 0: all. The result does not depend on them. */
    cata_progress progress; /**< Progress callback; NULL: none. */
    void *progress_user; /**< Passed to `progress`. */
    /** Bytes of memory that the table may take; 0: a limit that suits usual files. */
    uint64_t max_memory;
    size_t skip; /**< Lines at the start of the file that are left out. */
    /** Columns that are used: names, numbers from 0, ranges `3..5`, or a list of these between
     * commas; NULL: all but those of words. */
    const char *columns;
    /** Names or numbers of columns that become factors if one of their entries is a word, between
     * commas; NULL: none. */
    const char *factors;
    /** The words of missing cells, between commas; NULL: those of pandas, such as NA. */
    const char *missing_words;
    /** The encoding of the text, such as "latin1"; NULL: the file decides. */
    const char *encoding;
    /** "npy", "mtx" or "table"; NULL: the name of the file, or else its content, decides. */
    const char *format;
    int32_t missing; /**< CATA_MISSING_*. */
    /** Whether the first row has the names of the columns: CATA_AUTO, CATA_YES or CATA_NO. */
    int32_t header;
    /** Whether the first column numbers or names the rows, and is left out: CATA_AUTO, CATA_YES or
     * CATA_NO. */
    int32_t index;
    /** The character between fields; a blank: runs of blanks and tabs. 0: the file decides. */
    char separator;
    char decimal; /**< '.' or ','; 0: the file decides. */
    char thousands; /**< The separator of groups of three digits; 0: the file decides. */
    char comment; /**< The character that starts a comment; 0: '#'. */
} cata_table_params;
/** Fills a struct with the defaults. */
cata_status cata_table_params_init(cata_table_params *params, size_t struct_size);

/** Reads the matrix in a file, whose `path` is in UTF-8: a text table or .npy, each also packed
 * (.gz, .xz, .bz2, .zip), an array of .npz (`FILE.npz:NAME`), or .mtx without coordinates.
 * A column of words is left out unless it is a factor. Errors name the file, the line and the
 * column. */
cata_status cata_table_read(const char *path, const cata_table_params *params, cata_table **table);

/** Gets the number of rows, the number of columns, and the number of rows that were left out
 * because a cell is missing. NULL where not wanted. */
cata_status cata_table_shape(const cata_table *table, size_t *rows, size_t *columns,
    uint64_t *dropped_rows);

/** Gets the entries, rows x columns. An entry of a factor is the number of its level, from 0; a
 * missing cell is NaN. */
cata_status cata_table_entries(const cata_table *table, int32_t layout, double *entries, size_t ld);

/** Returns the name of a column, in UTF-8; valid until cata_table_free. Empty for NULL, for a
 * column that does not exist, and without names. Never NULL; do not free it. */
const char *cata_table_name(const cata_table *table, size_t column);

/** Returns the number of levels of a factor; 0 for NULL, for a column that does not exist, and for
 * one of numbers. */
size_t cata_table_levels(const cata_table *table, size_t column);

/** Returns a level of a factor, from 0, in UTF-8; valid until cata_table_free. Empty where there is
 * none. Never NULL; do not free it. */
const char *cata_table_level(const cata_table *table, size_t column, size_t level);

/** Returns what was decided about a text table, such as "separator ;, decimal comma, header", and
 * which integers of any format were rounded, in UTF-8; valid until cata_table_free. Empty for NULL
 * and where there is nothing to say. Never NULL; do not free it. */
const char *cata_table_reading(const cata_table *table);

void cata_table_free(cata_table *table); /**< Frees a table. */

/** @} */

/* ==== Sparse Cholesky factorizations ======================================================== */
/**
 * @defgroup cholesky Sparse Cholesky factorizations
 * Solutions of A X = B for a sparse symmetric matrix, positive definite or semidefinite: analysed
 * once for all matrices with entries in the same places, factorized for each, solved for any
 * number of right-hand sides.
 * @code{.c}
 * size_t starts[] = {0, 2, 4}, columns[] = {0, 1, 0, 1};
 * double entries[] = {2, -1, -1, 2}, x[] = {1, 1};
 * cata_cholesky *cholesky;
 * cata_cholesky_analyse(2, starts, columns, NULL, &cholesky);
 * cata_cholesky_factor(cholesky, starts, columns, entries);
 * cata_cholesky_solve(cholesky, CATA_COL_MAJOR, 1, x, 2);
 * printf("%g %g\n", x[0], x[1]); // 1 1
 * cata_cholesky_free(cholesky);
 * @endcode
 * @{
 */

/** The factorization A = L L^T of a sparse symmetric matrix, or its analysis alone. */
typedef struct cata_cholesky cata_cholesky;

/** What is read of a matrix, and which pivots are allowed. */
typedef struct cata_cholesky_params {
    size_t struct_size; /**< sizeof(cata_cholesky_params). */
    size_t threads; /**< Threads, at most; 0: all. */
    cata_progress progress; /**< Progress callback; NULL: none. */
    void *progress_user; /**< Passed to `progress`. */
    /** n elements: the rows in the order of elimination, from 0, each once, as that of METIS; NULL:
     * approximate minimum degree, from 100,000 rows on after nested dissection. */
    const size_t *order;
    /** Largest pivot that is zero, relative to the diagonal entry of its row, at most 0.01; 0: 8 n
     * 2^-52 with `semidefinite`, and only zero itself without. */
    double tolerance;
    /** The triangle that is read, the other one being ignored; 0: CATA_BOTH, which must agree. */
    int32_t triangle;
    /** 1: pivots may be zero: their rows are held (cata_cholesky_held). 0: all are positive. */
    int32_t semidefinite;
} cata_cholesky_params;
/** Fills a struct with the defaults. */
cata_status cata_cholesky_params_init(cata_cholesky_params *params, size_t struct_size);

/** Finds the order of elimination and the pattern of L for the n x n matrices with entries in these
 * places. The diagonal is part of the pattern.
 * - `row_starts`: n + 1 elements: the entries of row i are those from `row_starts[i]` to
 *   `row_starts[i + 1] - 1`, the first being 0.
 * - `columns`: `row_starts[n]` elements, ascending within a row, from 0. A matrix by columns is
 *   given as its transpose: CATA_UPPER and CATA_LOWER change places.
 * - `cholesky`: a handle, written. */
cata_status cata_cholesky_analyse(size_t n, const size_t *row_starts, const size_t *columns,
    const cata_cholesky_params *params, cata_cholesky **cholesky);

void cata_cholesky_free(cata_cholesky *cholesky); /**< Frees a factorization. */

/** Computes L for a matrix without entries outside of the pattern that was analysed, any number of
 * times: arrays as in cata_cholesky_analyse, and `entries`: `row_starts[n]` finite elements. After
 * an error there is no factor; CATA_ERR_ARGUMENT names the row at which elimination fails. */
cata_status cata_cholesky_factor(cata_cholesky *cholesky, const size_t *row_starts,
    const size_t *columns, const double *entries);

/** Solves A X = B: replaces B in `x` (n x count) by X. */
cata_status cata_cholesky_solve(const cata_cholesky *cholesky, int32_t layout, size_t count,
    double *x, size_t ldx);

/** Computes some rows of the solution of A X = B, without memory for the others.
 * - `b`: n x count.
 * - `rows`: n_rows elements: the rows of X wanted, from 0, in any order.
 * - `x`: n_rows x count, written. */
cata_status cata_cholesky_solve_rows(const cata_cholesky *cholesky, int32_t layout, size_t count,
    const double *b, size_t ldb, size_t n_rows, const size_t *rows, double *x, size_t ldx);

/** Gets the size of a factorization, each number NULL where not wanted: rows of A, entries of L,
 * zeros among them, and held rows, 0 without a factor. */
cata_status cata_cholesky_size(const cata_cholesky *cholesky, size_t *n, size_t *entries,
    size_t *held);

/** Copies the numbers of the held rows (cata_cholesky_size), ascending: X is 0 there, and the
 * equations of these rows follow from the others where there is a solution. A Laplacian has one in
 * each component. */
cata_status cata_cholesky_held(const cata_cholesky *cholesky, size_t *held);

/** Gets the row with the smallest pivot relative to its diagonal entry, and this ratio: at 1e-12,
 * solutions may lose 12 digits. Held rows do not count. Without other rows or a factor they are n
 * and 1. Each is NULL where not wanted. */
cata_status cata_cholesky_weakest(const cata_cholesky *cholesky, size_t *row, double *ratio);

/** @} */

/* ==== Sparse eigenpairs ===================================================================== */
/**
 * @defgroup eigs Sparse eigenpairs
 * The smallest eigenvalues of sparse symmetric matrices, or those nearest to a shift, by
 * shift-invert block Lanczos; and orthonormal columns, in the inner product of a diagonal.
 * @code{.c}
 * size_t starts[] = {0, 1, 2}, columns[] = {0, 1};
 * double entries[] = {2, 1}, value, vector[2]; // diag(2, 1)
 * cata_eigs(2, starts, columns, entries, NULL, 1, &value, vector, 2, NULL, NULL);
 * printf("%g\n", value); // 1
 * @endcode
 * @{
 */

#define CATA_LAPLACIAN_COTANGENT 0 /**< `laplacian`: of the faces. */
#define CATA_LAPLACIAN_INTRINSIC_DELAUNAY 1 /**< `laplacian`: no negative weights. */
#define CATA_LAPLACIAN_TUFTED 2 /**< `laplacian`: the same for any mesh (tufted cover). */
#define CATA_MASS_BARYCENTRIC 0 /**< `mass`: a third of the area of a face to each vertex. */
#define CATA_MASS_MIXED_VORONOI 1 /**< `mass`: what is nearest to each vertex. */
#define CATA_MASS_CONSISTENT 2 /**< `mass`: the inner product of linear functions, a full matrix. */
#define CATA_BOUNDARY_NEUMANN 0 /**< `boundary`: the normal derivative is zero there. */
#define CATA_BOUNDARY_DIRICHLET 1 /**< `boundary`: functions are zero there. */

/** How eigenpairs are computed, and the Laplacian if they are those of a mesh. */
typedef struct cata_eigs_params {
    size_t struct_size; /**< sizeof(cata_eigs_params). */
    size_t threads; /**< Threads, at most; 0: all. */
    cata_progress progress; /**< Progress callback; NULL: none. */
    void *progress_user; /**< Passed to `progress`. */
    size_t max_restarts; /**< Restarts after which CATA_ERR_NOT_CONVERGED is returned; 0: 60. */
    uint64_t seed; /**< Seed of the starting vectors. */
    double tolerance; /**< Residual that every pair must reach, 1e-14 to 1e-2; 0: 1e-9. */
    /** With `has_shift` 1: the eigenvalues nearest to this finite number are computed, which may be
     * an eigenvalue. Otherwise ignored. */
    double shift;
    int32_t has_shift; /**< 1: `shift` is used; 0: the smallest eigenvalues are computed. */
    /** 1: counts the eigenvalues by one or two more factorizations, and continues until none is
     * missing. 0: does not. */
    int32_t verify_count;
    int32_t laplacian; /**< For meshes: CATA_LAPLACIAN_*. */
    int32_t mass; /**< For meshes: CATA_MASS_*. */
    int32_t boundary; /**< For meshes: CATA_BOUNDARY_*. */
} cata_eigs_params;

/** Takes a slice of eigenpairs: `count` of them, as cata_eigs writes them, ascending within the
 * slice and from slice to slice; gone when it returns. It is called by the calling thread, and
 * returns 0 to continue, anything else to end the call with CATA_ERR_CANCELLED. */
typedef int32_t (*cata_eigs_slice)(size_t count, const double *eigenvalues,
    const double *eigenvectors, size_t ldv, const double *residuals, void *user);
/** Fills a struct with the defaults. */
cata_status cata_eigs_params_init(cata_eigs_params *params, size_t struct_size);

/** Computes the k smallest eigenvalues, or those nearest to a shift, of W phi = lambda M phi, and
 * their eigenvectors. W is n x n, sparse, symmetric, and positive semi-definite unless a shift is
 * given; M is a diagonal of positive masses.
 * - `row_starts`: n + 1 elements: the entries of row i are those from `row_starts[i]` to
 *   `row_starts[i + 1] - 1`, the first being 0.
 * - `columns`, `entries`: `row_starts[n]` elements each: columns ascending within a row, from
 *   0, and the entries of W there, both triangles.
 * - `masses`: n elements: the diagonal of M; NULL: all 1.
 * - `k`: number of pairs, at most n.
 * - `eigenvalues`: k elements, written: ascending.
 * - `eigenvectors`: n x k, written, column-major; orthonormal in the inner product of M.
 * - `residuals`: k elements, written: for each pair |W phi - lambda M phi| / max(|W phi|, s |M
 *   phi|), n s being the median of W_ii / M_ii; NULL where not wanted. */
cata_status cata_eigs(size_t n, const size_t *row_starts, const size_t *columns,
    const double *entries, const double *masses, size_t k, double *eigenvalues,
    double *eigenvectors, size_t ldv, double *residuals, const cata_eigs_params *params);

/** Computes the k smallest eigenpairs as those of cata_eigs, in slices of the spectrum of which one
 * at a time is in memory. Each slice is complete (as with `verify_count`), and ends in a gap
 * between eigenvalues.
 * - `memory`: bytes that may be used beside W and M; where all pairs fit there is one slice.
 *   Too few for any slice, or for k pairs around a shift, are CATA_ERR_ARGUMENT.
 * - `slice`, `user`: what takes the slices, and what is handed to it. */
cata_status cata_eigs_sliced(size_t n, const size_t *row_starts, const size_t *columns,
    const double *entries, const double *masses, size_t k, size_t memory, cata_eigs_slice slice,
    void *user, const cata_eigs_params *params);

/** Computes the k smallest eigenpairs as those of cata_eigs, approximately, from those of a smaller
 * problem, P^T W P and P^T M P, which are smoothed. Eigenvalues are never too small; `residuals`
 * bound how far they are too large, widely. cata_decimation_eigs does this for meshes.
 * - `coarse`: columns of P, at least k.
 * - `p_row_starts`, `p_columns`, `p_entries`: P, n x coarse, by rows as W: the vectors of the
 *   problem that those of the smaller one stand for.
 * - `params`: `has_shift` and `verify_count` must be 0, and `tolerance` is not used. */
cata_status cata_eigs_two_level(size_t n, const size_t *row_starts, const size_t *columns,
    const double *entries, const double *masses, size_t coarse, const size_t *p_row_starts,
    const size_t *p_columns, const double *p_entries, size_t k, double *eigenvalues,
    double *eigenvectors, size_t ldv, double *residuals, const cata_eigs_params *params);

/** Counts the eigenvalues below `value`, which may not be one, by a factorization: so many k give
 * cata_eigs all of them. In an interval there are as many as the difference of two counts, and
 * these are nearest to its middle as `shift`.
 * - `count`: one size_t, written.
 * - `params`: only `progress` is used, before and after the work. */
cata_status cata_eigs_count(size_t n, const size_t *row_starts, const size_t *columns,
    const double *entries, const double *masses, double value, size_t *count,
    const cata_eigs_params *params);

#define CATA_ORTHO_REORTHOGONALIZED 1 /**< `method`: orthogonal to rounding; threshold 1e-9. */
#define CATA_ORTHO_SINGLE_PASS 2 /**< `method`: one projection; threshold 1e-2. */

/** `method`: as many columns as the numerical rank: singular values above the threshold, 1e-9,
 * times the largest one, columns scaled to length 1; orthogonal to rounding. */
#define CATA_ORTHO_RANK_REVEALING 3

/** How columns are made orthonormal. */
typedef struct cata_ortho_params {
    size_t struct_size; /**< sizeof(cata_ortho_params). */
    size_t threads; /**< Threads, at most; 0: all. */
    cata_progress progress; /**< Progress callback; NULL: none. */
    void *progress_user; /**< Passed to `progress`. */
    /** A column is dropped if its part orthogonal to the columns before it is at most this fraction
     * of its length: 1e-13 to 1; 0: that of `method`. */
    double threshold;
    int32_t method; /**< CATA_ORTHO_*; 0: CATA_ORTHO_REORTHOGONALIZED. */
} cata_ortho_params;
/** Fills a struct with the defaults. */
cata_status cata_ortho_params_init(cata_ortho_params *params, size_t struct_size);

/** Runs Gram-Schmidt with rank detection, in place: A (n x c) = Q R with Q^T M Q = I, for a
 * diagonal M. Columns that depend on those before them are dropped.
 * - `a`: A, read and written: its first `*rank` columns are Q afterwards, the others
 *   unspecified.
 * - `masses`: n elements: the diagonal of M, positive; NULL: all 1.
 * - `r`: min(n, c) x c, written: R in its first `*rank` rows, zeros below; coefficients of
 *   every column of A. NULL where not wanted; `ldr` is then ignored.
 * - `kept`: c elements; the first `*rank` are written: the columns that Q is made of,
 *   ascending, from 0. NULL where not wanted.
 * - `rank`: one size_t, written.
 *
 * A is unspecified after an error. */
cata_status cata_ortho_gram_schmidt(int32_t layout, size_t n, size_t c, double *a, size_t lda,
    const double *masses, double *r, size_t ldr, size_t *kept, size_t *rank,
    const cata_ortho_params *params);

/** Factorizes A (n x c) = Q R with Q^T M Q = I, in place, by shifted Cholesky QR: about half the
 * work of cata_ortho_gram_schmidt, for independent columns. Dependent columns are
 * CATA_ERR_ARGUMENT. A is unspecified after an error. cata_gram_cholesky_qr does the same from a
 * Gram matrix in extended precision.
 * - `a`, `masses`: as in cata_ortho_gram_schmidt; A becomes Q.
 * - `r`: c x c, written: R, upper triangular with a positive diagonal. NULL where not wanted;
 *   `ldr` is then ignored.
 * - `params`: `threads` and `progress` are used. */
cata_status cata_ortho_cholesky_qr(int32_t layout, size_t n, size_t c, double *a, size_t lda,
    const double *masses, double *r, size_t ldr, const cata_ortho_params *params);

/** @} */

/* ==== Mesh files ============================================================================ */
/**
 * @defgroup mesh_files Mesh files
 * Meshes with texture coordinates, normals, colours and names, from and to files (.obj, .ply,
 * .off, .stl, .glb, .gltf, .vtk, .gii and .3mf, also packed: .gz) and their bytes in memory; also
 * from .vtp, .vtu, .msh, surfaces of FreeSurfer, and what .xz, .bz2 and .zip pack.
 * @code{.c}
 * const char text[] = "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n";
 * cata_mesh_file *file;
 * size_t n_vertices;
 * cata_mesh_file_read_bytes(sizeof text - 1, text, CATA_MESH_OBJ, &file);
 * cata_mesh_file_size(file, &n_vertices, NULL);
 * printf("%zu vertices\n", n_vertices); // 3 vertices
 * cata_mesh_file_free(file);
 * @endcode
 * @{
 */

#define CATA_MESH_BY_NAME 0 /**< `format`: what the name of the file says. */
#define CATA_MESH_OBJ 1 /**< `format`: Wavefront OBJ. */
#define CATA_MESH_PLY 2 /**< `format`: PLY, binary. */
#define CATA_MESH_PLY_TEXT 3 /**< `format`: PLY as text. */
#define CATA_MESH_OFF 4 /**< `format`: Geomview OFF. */
#define CATA_MESH_STL 5 /**< `format`: STL, binary: coordinates are rounded to float. */
#define CATA_MESH_STL_TEXT 6 /**< `format`: STL as text. */
#define CATA_MESH_GLB 7 /**< `format`: glTF, binary: coordinates are rounded to float. */
#define CATA_MESH_GLTF 8 /**< `format`: glTF as text: coordinates are rounded to float. */
#define CATA_MESH_VTK 9 /**< `format`: legacy VTK, binary. */
#define CATA_MESH_VTK_TEXT 10 /**< `format`: legacy VTK as text. */
#define CATA_MESH_GIFTI 11 /**< `format`: GIFTI: coordinates are rounded to float. */
#define CATA_MESH_3MF 12 /**< `format`: 3MF, in millimetres. */
#define CATA_MESH_VTK_XML 13 /**< `format`: XML files of VTK, only read. */
#define CATA_MESH_FREESURFER 14 /**< `format`: surfaces of FreeSurfer, only read. */
#define CATA_MESH_GMSH 15 /**< `format`: Gmsh, only read. */

/** The bytes of a file. Made by cata_mesh_file_write_bytes; constant. */
typedef struct cata_mesh_bytes cata_mesh_bytes;

/** A mesh with its attributes, as in a file. */
typedef struct cata_mesh_file cata_mesh_file;

/** How mesh files are read and written. */
typedef struct cata_mesh_file_params {
    size_t struct_size; /**< sizeof(cata_mesh_file_params). */
    size_t threads; /**< Ignored. */
    cata_progress progress; /**< Progress callback; NULL: none. */
    void *progress_user; /**< Passed to `progress`. */
    /** For reading: bytes of memory that the file may take; 0: a hundred times its size, or 1 GiB
     * if that is more. */
    uint64_t max_memory;
    int32_t format; /**< For writing: CATA_MESH_*. */
    /** For writing: 1: an existing file stays, and CATA_ERR_IO is returned. 0: it is replaced. */
    int32_t keep;
} cata_mesh_file_params;
/** Fills a struct with the defaults. */
cata_status cata_mesh_file_params_init(cata_mesh_file_params *params, size_t struct_size);

/** Creates a mesh without attributes, of which it keeps a copy. Triangles that have a vertex twice
 * are left out, as those of files are; cata_mesh_file_notes counts them. */
cata_status cata_mesh_file_new(size_t n_vertices, const double *vertices, size_t n_faces,
    const uint32_t *faces, cata_mesh_file **file);

/** Reads a mesh in the format that the name of the file says; where its content has another one,
 * that of the content. Polygons are cut into triangles, and the triangles that have a vertex twice
 * are left out. CATA_ERR_IO: the message names the file, the line, and what is wrong with it.
 * - `path`: NUL-terminated; with .gz, .xz or .bz2 at its end, packed. */
cata_status cata_mesh_file_read(const char *path, const cata_mesh_file_params *params,
    cata_mesh_file **file);

/** Reads a mesh as cata_mesh_file_read does, from the bytes of a file that is not packed.
 * - `size`: number of bytes; `format`: CATA_MESH_* but CATA_MESH_BY_NAME: of both variants of a
 *   format, either. */
cata_status cata_mesh_file_read_bytes(size_t size, const void *bytes, int32_t format,
    cata_mesh_file **file);

/** Writes a mesh; the file appears whole or not at all. The notes of `file` become those about what
 * the new file does not hold as it is here, such as attributes that its format can't store.
 * - `path`: NUL-terminated; with .gz at its end the file is packed. */
cata_status cata_mesh_file_write(cata_mesh_file *file, const char *path,
    const cata_mesh_file_params *params);

/** Writes a mesh into memory, as cata_mesh_file_write does into a file that is not packed.
 * - `format`: CATA_MESH_* but CATA_MESH_BY_NAME. */
cata_status cata_mesh_file_write_bytes(cata_mesh_file *file, int32_t format,
    cata_mesh_bytes **bytes);

void cata_mesh_file_free(cata_mesh_file *file); /**< Frees a mesh. */

/** Gets the numbers of vertices and faces. NULL where not wanted. */
cata_status cata_mesh_file_size(const cata_mesh_file *file, size_t *n_vertices, size_t *n_faces);

/** Gets the vertices and faces, as many as cata_mesh_file_size tells. NULL where not wanted. */
cata_status cata_mesh_file_get(const cata_mesh_file *file, double *vertices, uint32_t *faces);

/** Gets the numbers of notes and of triangles that are left out because two of their corners are
 * one vertex. A note says what the reader left out or replaced, or what the file that was written
 * last does not hold. NULL where not wanted. */
cata_status cata_mesh_file_notes(const cata_mesh_file *file, size_t *notes,
    size_t *collapsed_faces);

/** Gets the note `index` (from 0): `size` elements of `text`, cut to fit, and NUL; in UTF-8. */
cata_status cata_mesh_file_note(const cata_mesh_file *file, size_t index, size_t size, char *text);

/** Gets the number of bytes. */
cata_status cata_mesh_bytes_size(const cata_mesh_bytes *bytes, size_t *size);

/** Gets the bytes, as many as cata_mesh_bytes_size tells. */
cata_status cata_mesh_bytes_get(const cata_mesh_bytes *bytes, void *to);

void cata_mesh_bytes_free(cata_mesh_bytes *bytes); /**< Frees bytes. */

#define CATA_MESH_MATERIALS 0 /**< `kind` of names: the materials of faces. */
#define CATA_MESH_GROUPS 1 /**< `kind` of names: the groups of faces. */
#define CATA_MESH_OBJECTS 2 /**< `kind` of names: the objects of faces. */
#define CATA_MESH_NO_NAME UINT32_MAX /**< Instead of the number of a name: the face has none. */

/** Gets which attributes a mesh has: 1, or 0. NULL where not wanted. */
cata_status cata_mesh_file_has(const cata_mesh_file *file, int32_t *uv, int32_t *normals,
    int32_t *colors);

/** Gets the texture coordinates: 6 for each face, u and v at its three corners, NaN where a face
 * has none. CATA_ERR_ARGUMENT when the mesh has none. */
cata_status cata_mesh_file_get_uv(const cata_mesh_file *file, double *uv);

/** Gets the normals: 9 for each face, x, y, z at its three corners, as long as in the file; NaN
 * where a face has none. CATA_ERR_ARGUMENT when the mesh has none. */
cata_status cata_mesh_file_get_normals(const cata_mesh_file *file, double *normals);

/** Gets the colours: 4 for each vertex, red, green, blue and opacity, usually from 0 to 1.
 * CATA_ERR_ARGUMENT when the mesh has none. */
cata_status cata_mesh_file_get_colors(const cata_mesh_file *file, double *colors);

/** Sets the texture coordinates: as cata_mesh_file_get_uv returns them; NULL: none. */
cata_status cata_mesh_file_set_uv(cata_mesh_file *file, const double *uv);

/** Sets the normals: as cata_mesh_file_get_normals returns them; NULL: none. */
cata_status cata_mesh_file_set_normals(cata_mesh_file *file, const double *normals);

/** Sets the colours: as cata_mesh_file_get_colors returns them; NULL: none. */
cata_status cata_mesh_file_set_colors(cata_mesh_file *file, const double *colors);

/** Gets the number of names of faces, 0 when the mesh has none.
 * - `kind`: CATA_MESH_MATERIALS, CATA_MESH_GROUPS or CATA_MESH_OBJECTS. */
cata_status cata_mesh_file_names(const cata_mesh_file *file, int32_t kind, size_t *count);

/** Gets the name `index` (from 0): `size` elements of `name`, cut to fit, and NUL; in UTF-8. `kind`
 * as in cata_mesh_file_names. */
cata_status cata_mesh_file_name(const cata_mesh_file *file, int32_t kind, size_t index, size_t size,
    char *name);

/** Gets the number of the name of each face, CATA_MESH_NO_NAME where it has none: n_faces elements.
 * `kind` as in cata_mesh_file_names. */
cata_status cata_mesh_file_get_names(const cata_mesh_file *file, int32_t kind, uint32_t *of_faces);

/** Sets the names of faces, in place of those that the mesh has. `kind` as in cata_mesh_file_names.
 * - `count`: number of names; 0: none.
 * - `names`: `count` texts in UTF-8, NUL-terminated; they are copied.
 * - `of_faces`: n_faces elements, read: the number of the name of each face, or
 *   CATA_MESH_NO_NAME. */
cata_status cata_mesh_file_set_names(cata_mesh_file *file, int32_t kind, size_t count,
    const char *const *names, const uint32_t *of_faces);

/** Gets the number of functions on the vertices in the file (VTK, GIFTI, Gmsh). */
cata_status cata_mesh_file_scalars(const cata_mesh_file *file, size_t *count);

/** Gets a function on the vertices. NULL where not wanted.
 * - `index`: its number, from 0, less than that of cata_mesh_file_scalars.
 * - `name`: `size` elements, written: the name, cut to fit, and NUL; in UTF-8.
 * - `values`: n_vertices elements, written: NaN where there is no value. */
cata_status cata_mesh_file_get_scalars(const cata_mesh_file *file, size_t index, size_t size,
    char *name, double *values);

/** @} */

/* ==== Repair ================================================================================ */
/**
 * @defgroup repair Repair
 * Meshes without seams, repeated faces, faces without area, edges of many faces, holes and specks,
 * with their attributes; and a report of what was done.
 * @code{.c}
 * double v[] = {0, 0, 0, 1, 0, 0, 1, 1, 0, 0, 0, 0, 1, 1, 0, 0, 1, 0}; // two triangles, apart
 * uint32_t f[] = {0, 1, 2, 3, 4, 5};
 * cata_mesh_file *soup, *square;
 * cata_repair *repair;
 * cata_repair_params params = {.struct_size = sizeof params, .everything = 1};
 * size_t n_vertices;
 * cata_mesh_file_new(6, v, 2, f, &soup);
 * cata_repair_new(soup, &params, &repair);
 * cata_repair_file(repair, &square);
 * cata_mesh_file_size(square, &n_vertices, NULL);
 * printf("%zu of 6 vertices\n", n_vertices); // 4 of 6 vertices
 * cata_mesh_file_free(soup);
 * cata_mesh_file_free(square);
 * cata_repair_free(repair);
 * @endcode
 * @{
 */

#define CATA_WELD_NEVER 0 /**< `weld`: no vertices. */
#define CATA_WELD_EXACT 1 /**< `weld`: vertices in the same place. */
#define CATA_WELD_WITHIN 2 /**< `weld`: vertices at most `tolerance` apart. */
#define CATA_WELD_SEAMS 3 /**< `weld`: along seams, where exactly two boundary edges coincide. */
#define CATA_REPAIR_WELDED 0 /**< A step: vertices were joined. */
#define CATA_REPAIR_SEAMS 1 /**< A step: seams were closed. */
#define CATA_REPAIR_DUPLICATES 2 /**< A step: repeated faces were left out. */
#define CATA_REPAIR_DEGENERATE 3 /**< A step: faces without area were removed. */
#define CATA_REPAIR_COMPACTED 4 /**< A step: vertices without a face were left out. */
#define CATA_REPAIR_CUT 5 /**< A step: the mesh was cut into a manifold. */
#define CATA_REPAIR_LARGEST 6 /**< A step: all but the largest components were left out. */
#define CATA_REPAIR_SPECKS 7 /**< A step: small components were left out. */
#define CATA_REPAIR_HOLES 8 /**< A step: holes were filled. */
#define CATA_REPAIR_ORIENTED 9 /**< A step: faces were flipped. */

/** A repaired mesh, and what was done. Made by cata_repair_new; constant. */
typedef struct cata_repair cata_repair;

/** The steps of a repair, in their order; by default there are none. */
typedef struct cata_repair_params {
    size_t struct_size; /**< sizeof(cata_repair_params). */
    size_t threads; /**< Ignored. */
    cata_progress progress; /**< Progress callback; NULL: none. */
    void *progress_user; /**< Passed to `progress`. */
    double tolerance; /**< For CATA_WELD_WITHIN: in the unit of the mesh. Otherwise ignored. */
    size_t keep_largest; /**< Components to keep, those with the most faces; 0: all. */
    /** Components with less than this share of the area, from 0 to 1, are left out. */
    double drop_specks;
    size_t fill_holes; /**< Holes of at most this many edges are filled. */
    /** 1: as if all fields after `weld` were 1, and `weld` CATA_WELD_SEAMS where it is
     * CATA_WELD_NEVER. 0: they say what is done. */
    int32_t everything;
    int32_t weld; /**< CATA_WELD_*: the vertices that are joined. */
    /** 1: faces with the vertices of an earlier one are left out. 0: they stay. */
    int32_t drop_duplicates;
    int32_t drop_degenerate; /**< 1: faces without area are removed. 0: they stay. */
    int32_t compact; /**< 1: vertices without a face are left out. 0: they stay. */
    /** 1: the mesh is cut along edges of more than two faces, and where it meets itself. 0: it is
     * not. */
    int32_t cut;
    /** 1: faces are flipped to agree with their neighbours, and in closed components so that they
     * are counter-clockwise as seen from outside. 0: they stay. */
    int32_t orient;
} cata_repair_params;
/** Fills a struct with the defaults. */
cata_status cata_repair_params_init(cata_repair_params *params, size_t struct_size);

/** Repairs a mesh by the steps of `params`. Attributes follow their vertices and corners.
 * - `file`: stays as it is. */
cata_status cata_repair_new(const cata_mesh_file *file, const cata_repair_params *params,
    cata_repair **repair);

void cata_repair_free(cata_repair *repair); /**< Frees a repair. */

/** Copies the repaired mesh: `file`, one pointer, written. */
cata_status cata_repair_file(const cata_repair *repair, cata_mesh_file **file);

/** Gets for each vertex of the input the lowest vertex of the result that comes from it, UINT32_MAX
 * where it was left out: `vertices`, as many elements as the input has vertices, written. */
cata_status cata_repair_vertices(const cata_repair *repair, uint32_t *vertices);

/** Gets the number of steps that were taken, in the order of the fields of cata_repair_params, and
 * whether any changed the mesh: 1, or 0. NULL where not wanted. */
cata_status cata_repair_steps(const cata_repair *repair, size_t *count, int32_t *changed);

/** Gets what a step did, from 0; NULL where not wanted, 0 where a step has no such number.
 * - `kind`: CATA_REPAIR_*.
 * - `vertices`: that joined others, were left out, or were split.
 * - `edges`: that were flipped or cut; of CATA_REPAIR_SEAMS: that stay, because more than two
 *   coincide.
 * - `faces`: that were left out; of CATA_REPAIR_HOLES: new ones; of CATA_REPAIR_ORIENTED: flipped.
 * - `parts`: components that were left out, or holes that were filled.
 * - `left`: boundary loops that stay, or parts that are not orientable and stay as they were; of
 *   joined vertices: those that lost their colour, because the first one has another. */
cata_status cata_repair_step(const cata_repair *repair, size_t step, int32_t *kind,
    size_t *vertices, size_t *edges, size_t *faces, size_t *parts, size_t *left);

/** Gets what a step did, from 0, as a line of text: `size` elements of `text`, cut to fit, with a
 * NUL. */
cata_status cata_repair_step_text(const cata_repair *repair, size_t step, size_t size, char *text);

/** Gets whether a mesh has seams, repeated faces or faces without area, whose repair has a single
 * sensible result: 1, or 0; and a line about the first: `size` elements of `text`, cut to fit, and
 * NUL; NULL where not wanted. */
cata_status cata_repair_needed(size_t n_vertices, const double *vertices, size_t n_faces,
    const uint32_t *faces, int32_t *needed, size_t size, char *text);

/** @} */

/* ==== Meshes ================================================================================ */
/**
 * @defgroup mesh Meshes
 * Triangle meshes are arrays: `n_vertices`, `vertices` (3 doubles each: x, y, z), `n_faces`,
 * `faces` (3 vertices each, from 0, counter-clockwise as seen from outside). Here:
 * eigenfunctions of their Laplacian.
 * @code{.c}
 * double v[] = {0, 0, 0, 1, 0, 0, 0, 1, 0, 0, 0, 1}, values[2], functions[8]; // a tetrahedron
 * uint32_t f[] = {0, 2, 1, 0, 1, 3, 0, 3, 2, 1, 2, 3};
 * cata_mesh_eigs(4, v, 4, f, 2, values, functions, 4, NULL, NULL, NULL);
 * printf("%.3f\n", values[1]); // 3.000
 * @endcode
 * @{
 */

/** Counts the eigenvalues of the Laplacian of a triangle mesh that are 0: one for each connected
 * component without a vertex that is held at zero, as all are under CATA_BOUNDARY_NEUMANN. More
 * than 1 are often pieces that belong together, such as those beside a seam of the texture.
 * - `count`: written.
 * - `params`: `boundary` is used, the rest is only checked. */
cata_status cata_mesh_free_components(size_t n_vertices, const double *vertices, size_t n_faces,
    const uint32_t *faces, size_t *count, const cata_eigs_params *params);

/** Computes the k smallest eigenvalues, or those nearest to a shift, of the Laplacian of a triangle
 * mesh, W phi = lambda M phi, and their eigenfunctions.
 * - `k`: number of pairs, at most the vertices that are in a face and not held at zero.
 * - `eigenvalues`: k elements, written: ascending, in units of 1 / length^2; the first ones are 0,
 *   as many as cata_mesh_free_components counts.
 * - `eigenvectors`: n_vertices x k, written, column-major; orthonormal in the inner product of
 *   M, 0 where functions are held at zero and at vertices in no face.
 * - `residuals`: k elements, written, as those of cata_eigs; NULL where not wanted.
 * - `masses`: n_vertices elements, written: the diagonal of M, 0 at vertices that it has no row
 *   for; NULL where not wanted. CATA_MASS_CONSISTENT has none to give. */
cata_status cata_mesh_eigs(size_t n_vertices, const double *vertices, size_t n_faces,
    const uint32_t *faces, size_t k, double *eigenvalues, double *eigenvectors, size_t ldv,
    double *residuals, double *masses, const cata_eigs_params *params);

/** Computes the k smallest eigenpairs of the Laplacian of a triangle mesh, as those of
 * cata_mesh_eigs, in slices: `memory`, `slice` and `user` are those of cata_eigs_sliced. */
cata_status cata_mesh_eigs_sliced(size_t n_vertices, const double *vertices, size_t n_faces,
    const uint32_t *faces, size_t k, size_t memory, cata_eigs_slice slice, void *user,
    const cata_eigs_params *params);

/** Computes the k smallest eigenvalues of the Laplacian of a part of a triangle mesh, which has the
 * faces whose three vertices are in the mask.
 *
 * Under CATA_BOUNDARY_DIRICHLET functions are zero where the part ends and at the boundary of
 * the mesh: of two parts of which one lies in the other, the inner one then has no smaller
 * eigenvalue anywhere in the sequence. Under CATA_BOUNDARY_NEUMANN the part is a mesh of its
 * own.
 * - `mask`: n_vertices elements: 1 for a vertex of the part, 0 for any other.
 * - `k`: number of eigenvalues, at most the vertices of the part that are not held at zero.
 * - `eigenvalues`: k elements, written: ascending, in units of 1 / length^2.
 * - `params`: the Laplacian, `threads` and `progress` are used, the rest is only checked. */
cata_status cata_mesh_part_eigenvalues(size_t n_vertices, const double *vertices, size_t n_faces,
    const uint32_t *faces, const uint8_t *mask, size_t k, double *eigenvalues,
    const cata_eigs_params *params);

/** @} */

/* ==== Surfaces ============================================================================== */
/**
 * @defgroup surfaces Surfaces
 * Topology, measures and comparison of triangle meshes; meshes of lattices, and generated ones.
 * @code{.c}
 * double v[] = {0, 0, 0, 1, 0, 0, 1, 1, 0, 0, 1, 0}, area; // a square
 * uint32_t f[] = {0, 1, 2, 0, 2, 3};
 * size_t edges, genus;
 * cata_mesh_edges(4, v, 2, f, 0, NULL, NULL, &edges);
 * cata_mesh_genus(4, v, 2, f, &genus, NULL);
 * cata_mesh_measures(4, v, 2, f, &area, NULL, NULL, NULL, NULL, NULL);
 * printf("%zu edges, genus %zu, area %g\n", edges, genus, area); // 5 edges, genus 0, area 1
 * @endcode
 * @{
 */

/** Finds the edges of a mesh, ascending.
 * - `room`: the number of edges that `edges` and `face_counts` have room for; CATA_ERR_SHAPE where
 *   there are more. 3 n_faces is always enough.
 * - `edges`: 2 vertices for each edge, the lower first, written. NULL where not wanted.
 * - `face_counts`: for each edge the number of its faces, written: 1 at the boundary, more than 2
 *   where the mesh is no manifold. NULL where not wanted.
 * - `count`: written: the number of edges. */
cata_status cata_mesh_edges(size_t n_vertices, const double *vertices, size_t n_faces,
    const uint32_t *faces, size_t room, uint32_t *edges, uint32_t *face_counts, size_t *count);

/** Finds the connected components of a mesh, numbered from 0 by their lowest vertex: two faces with
 * a common vertex are in the same one.
 * - `of_vertices`: n_vertices elements, written: the component of each vertex, UINT32_MAX for
 *   those that no face has. NULL where not wanted.
 * - `of_faces`: n_faces elements, written. NULL where not wanted.
 * - `count`: written: the number of components. */
cata_status cata_mesh_components(size_t n_vertices, const double *vertices, size_t n_faces,
    const uint32_t *faces, uint32_t *of_vertices, uint32_t *of_faces, size_t *count);

/** Computes the genus of a manifold with its boundary loops closed by disks, summed over its
 * components: the number of handles. CATA_ERR_MESH where the mesh is no manifold.
 * - `orientable`: written: 1, or 0 where a component is not orientable: then `genus` is the number
 *   of cross-caps, where a handle counts as two. NULL where not wanted. */
cata_status cata_mesh_genus(size_t n_vertices, const double *vertices, size_t n_faces,
    const uint32_t *faces, size_t *genus, int32_t *orientable);

/** Finds the boundary loops of a mesh, with the mesh on their left where it is oriented.
 * CATA_ERR_MESH where there is a boundary and an edge of more than two faces.
 * - `room`: the number of vertices that `loops` has room for, and of loops that `lengths` has;
 *   CATA_ERR_SHAPE where there are more.
 * - `loops`: the vertices of each loop in order, one loop after the other, written. NULL where not
 *   wanted.
 * - `lengths`: the number of vertices of each loop, written. NULL where not wanted.
 * - `total`: written: the number of vertices of all loops, which is that of boundary edges.
 * - `count`: written: the number of loops. */
cata_status cata_mesh_boundary_loops(size_t n_vertices, const double *vertices, size_t n_faces,
    const uint32_t *faces, size_t room, uint32_t *loops, size_t *lengths, size_t *total,
    size_t *count);

/** How meshes are compared, or made of a lattice. */
typedef struct cata_mesh_params {
    size_t struct_size; /**< sizeof(cata_mesh_params). */
    size_t threads; /**< Threads, at most; 0: all. */
    cata_progress progress; /**< Progress callback; NULL: none. */
    void *progress_user; /**< Passed to `progress`. */
} cata_mesh_params;
/** Fills a struct with the defaults. */
cata_status cata_mesh_params_init(cata_mesh_params *params, size_t struct_size);

/** Measures a mesh; NULL where not wanted.
 * - `area`, `volume`: written; the volume is negative where faces are seen clockwise from outside,
 *   and NaN unless the mesh has faces, is closed (every edge has two faces) and oriented.
 * - `face_areas`, `qualities`: n_faces elements each, written. The quality of a face is 2 sqrt(3)
 *   area / (half the perimeter x the longest edge): 1 for equilateral triangles, 0 for flat ones.
 * - `face_normals`: 3 for each face, written: of length 1, or 0 for faces without area.
 * - `vertex_normals`: 3 for each vertex, written: the directions of the means of the normals of
 *   its faces by area, of length 1, or 0 where the mean is 0. */
cata_status cata_mesh_measures(size_t n_vertices, const double *vertices, size_t n_faces,
    const uint32_t *faces, double *area, double *volume, double *face_areas, double *qualities,
    double *face_normals, double *vertex_normals);

/** Measures how uniform a mesh is, such as one that was decimated; NULL where not wanted.
 * - `mean_area`: of the faces; `area_variation`: the standard deviation of their areas over it.
 * - `mean_quality`, `quality_deviation`, `least_quality`: of the qualities of the faces, as
 *   cata_mesh_measures has them, with their standard deviation.
 * - `mean_valence`: edges at a vertex with a face, in the mean; `regular_vertices`: the share of
 *   these vertices that have 6, or 4 at the boundary.
 * - `non_manifold_edges`: the number of edges with more than two faces. */
cata_status cata_mesh_quality(size_t n_vertices, const double *vertices, size_t n_faces,
    const uint32_t *faces, double *mean_area, double *area_variation, double *mean_quality,
    double *quality_deviation, double *least_quality, double *mean_valence,
    double *regular_vertices, size_t *non_manifold_edges);

/** Compares two meshes; NULL where not wanted.
 * - `out`, `back`: 3 numbers each, written: from the mesh to the other one, and back: the largest
 *   distance, of vertices and of 100,000 points spread by area, from the other surface; the mean
 *   distance of these points; and the mean angle between the normals there, in degrees.
 * - `hausdorff`: written: the largest distance of a vertex of either mesh from the other surface.
 * - `chamfer`: written: the mean square of the distances of the vertices of one mesh from the
 *   other surface, plus the same in the other direction. */
cata_status cata_mesh_compare(size_t n_vertices, const double *vertices, size_t n_faces,
    const uint32_t *faces, size_t other_n_vertices, const double *other_vertices,
    size_t other_n_faces, const uint32_t *other_faces, double *out, double *back, double *hausdorff,
    double *chamfer, const cata_mesh_params *params);

/** Makes the surface of the region where values, interpolated between the points of a lattice,
 * exceed `level`: a manifold without attributes.
 * - `counts`, `origin`, `step`: 3 elements each, of x, y and z: the number of points, the place of
 *   the first one, and the distance from one to the next, positive.
 * - `values`: one for each point, x first, then y, then z; none is NaN.
 * - `open`: 0: the region ends half a step outside of the outermost points, and the surface is
 *   closed. 1: the surface is cut at these points.
 * - `file`: one pointer, written. */
cata_status cata_mesh_isosurface(const size_t *counts, const double *origin, const double *step,
    const float *values, float level, int32_t open, const cata_mesh_params *params,
    cata_mesh_file **file);

/** Makes the surface of the points of a lattice that have a label, as cata_mesh_isosurface does of
 * values, halfway between points with the label and others: `labels`, one for each point. */
cata_status cata_mesh_label_surface(const size_t *counts, const double *origin, const double *step,
    const uint16_t *labels, uint16_t label, int32_t open, const cata_mesh_params *params,
    cata_mesh_file **file);

/** Generates a mesh by its name, with these counts and sizes:
 * - "icosphere": subdivisions; "figure": cells, and the pose as a size;
 * - "torus": vertices around the axis and the tube, and the two radii; "knot": p, q, vertices
 *   along and around, and a radius; "genus": holes and cells;
 * - "grid": columns and rows; "disk": rings and sectors; "cylinder": vertices around and along,
 *   and its radius and height; "terrain": columns, rows and a seed. */
cata_status cata_mesh_shape(const char *name, size_t n_counts, const size_t *counts, size_t n_sizes,
    const double *sizes, cata_mesh_file **file);

/** @} */

/* ==== Laplacians ============================================================================ */
/**
 * @defgroup laplacians Laplacians
 * The matrices of the Laplacian of a mesh or of points, of gradients and of divergences, by rows:
 * the entries of row i are those from `row_starts[i]` to `row_starts[i + 1] - 1`.
 * @code{.c}
 * double v[] = {0, 0, 0, 1, 0, 0, 0, 1, 0, 0, 0, 1}, w[16]; // a tetrahedron
 * uint32_t f[] = {0, 2, 1, 0, 1, 3, 0, 3, 2, 1, 2, 3};
 * cata_laplacian *laplacian;
 * size_t n, entries, starts[5], columns[16];
 * cata_laplacian_new(4, v, 4, f, 0, NULL, NULL, &laplacian);
 * cata_laplacian_size(laplacian, &n, &entries, NULL);
 * cata_laplacian_get(laplacian, NULL, starts, columns, w);
 * printf("%zu rows, %zu entries, first %g\n", n, entries, w[0]); // 4 rows, 16 entries, first 3
 * cata_laplacian_free(laplacian);
 * @endcode
 * @{
 */

/** The matrices of W phi = lambda M phi: the stiffness W and the mass M. Constant. */
typedef struct cata_laplacian cata_laplacian;

/** Computes the Laplacian of a triangle mesh: W, positive semi-definite, minus the weight of an
 * edge off the diagonal, and M, whose entries sum to the area. Vertices in no face and those where
 * functions are zero have no row.
 * - `n_held`, `held`: vertices where functions are zero, with CATA_BOUNDARY_NEUMANN elsewhere; 0
 *   and NULL: none.
 * - `params`: the Laplacian, `threads` and `progress` are used, the rest is only checked. */
cata_status cata_laplacian_new(size_t n_vertices, const double *vertices, size_t n_faces,
    const uint32_t *faces, size_t n_held, const uint32_t *held, const cata_eigs_params *params,
    cata_laplacian **laplacian);

/** Computes the Laplacian of the surface that points are samples of: the tufted one of small
 * triangulations around every point.
 * - `n`, `points`: 3 doubles each, x, y, z.
 * - `neighbours`: nearest points with which each one is triangulated, at least 3; 0: 30.
 * - `params`: `boundary`, `threads` and `progress` are used, the rest is only checked. */
cata_status cata_cloud_laplacian(size_t n, const double *points, size_t neighbours,
    const cata_eigs_params *params, cata_laplacian **laplacian);

void cata_laplacian_free(cata_laplacian *laplacian); /**< Frees a Laplacian. */

/** Gets the numbers of rows, of entries of W, and of numbers of M: one for each row of a diagonal,
 * one for each entry of W with CATA_MASS_CONSISTENT. NULL where not wanted. */
cata_status cata_laplacian_size(const cata_laplacian *laplacian, size_t *rows, size_t *entries,
    size_t *masses);

/** Gets W, both triangles, as cata_eigs takes it; NULL where not wanted.
 * - `kept`: one element for each row, written: its vertex, ascending.
 * - `row_starts`: rows + 1 elements, written.
 * - `columns`, `w`: one element for each entry, written: columns ascending within a row. */
cata_status cata_laplacian_get(const cata_laplacian *laplacian, uint32_t *kept, size_t *row_starts,
    size_t *columns, double *w);

/** Gets M, as many numbers as cata_laplacian_size tells: its diagonal, or, with
 * CATA_MASS_CONSISTENT, its entries at the places of those of W. */
cata_status cata_laplacian_masses(const cata_laplacian *laplacian, double *masses);

/** Computes the matrix that takes a function, a value for each vertex, to its gradient, which is
 * constant on faces: rows 3 f to 3 f + 2 are x, y, z in face f. NULL where not wanted.
 * - `row_starts`: 3 n_faces + 1 elements, written.
 * - `columns`, `entries`: 9 n_faces elements each, written. */
cata_status cata_laplacian_gradient(size_t n_vertices, const double *vertices, size_t n_faces,
    const uint32_t *faces, size_t *row_starts, size_t *columns, double *entries);

/** Computes the matrix that takes a field, x, y, z for each face, to its divergence, integrated
 * against the hat function of each vertex: times the gradient it is -W. NULL where not wanted.
 * - `row_starts`: n_vertices + 1 elements, written.
 * - `columns`, `entries`: 9 n_faces elements each, written. */
cata_status cata_laplacian_divergence(size_t n_vertices, const double *vertices, size_t n_faces,
    const uint32_t *faces, size_t *row_starts, size_t *columns, double *entries);

/** Computes a third of the area of the faces at each vertex: n_vertices elements, written. */
cata_status cata_laplacian_areas(size_t n_vertices, const double *vertices, size_t n_faces,
    const uint32_t *faces, double *areas);

/** @} */

/* ==== Distances ============================================================================= */
/**
 * @defgroup distances Distances
 * Distances on a mesh: over its surface, exactly or by the heat method, and along its edges; the
 * shortest paths over faces and along edges, geodesics that the latter shorten to, and geodesics
 * from a point in a direction.
 * @code{.c}
 * double v[] = {0, 0, 0, 1, 0, 0, 1, 1, 0, 0, 1, 0}, d[4], length; // a square
 * uint32_t f[] = {0, 1, 3, 1, 2, 3}, source = 0;
 * cata_path *path;
 * cata_distance_edges(4, v, 2, f, 1, &source, d, NULL, NULL, NULL);
 * cata_distance_path(4, v, 2, f, 0, 2, 0, NULL, &path);
 * cata_path_size(path, NULL, NULL, &length);
 * printf("%g away, by a path of %g\n", d[2], length); // 2 away, by a path of 2
 * cata_path_free(path);
 * @endcode
 * @{
 */

/** `flow`: heat flows on the intrinsic Delaunay triangulation of any mesh (tufted cover). */
#define CATA_FLOW_TUFTED 0
#define CATA_FLOW_INTRINSIC_DELAUNAY 1 /**< `flow`: on that of a manifold. */

/** `flow`: on the faces: wrong by half and more where they are long. */
#define CATA_FLOW_COTANGENT 2
#define CATA_NO_VERTEX UINT32_MAX /**< Instead of a vertex: there is none. */
#define CATA_TRACE_COMPLETE 0 /**< `end`: the geodesic has the length that was asked for. */
#define CATA_TRACE_BOUNDARY 1 /**< `end`: it stopped at the boundary of the mesh. */

/** `end`: it stopped where more than one way leads on: at an edge of more than two faces, or
 * where the surface meets itself. */
#define CATA_TRACE_NON_MANIFOLD 2

/** A mesh, prepared for the heat method. Made by cata_heat_new; constant. */
typedef struct cata_heat cata_heat;

/** A path from one point to another. Made by cata_distance_path, cata_distance_path_exact and
 * cata_distance_trace; constant. */
typedef struct cata_path cata_path;

/** How distances are computed. */
typedef struct cata_distance_params {
    size_t struct_size; /**< sizeof(cata_distance_params). */
    size_t threads; /**< Threads of the heat method, at most; 0: all. */
    cata_progress progress; /**< Progress callback; NULL: none. */
    void *progress_user; /**< Passed to `progress`. */
    /** For the heat method: time of the flow, in units of the squared mean length of edges,
     * positive; 0: 1. Longer times make distances smoother. */
    double time;
    /** Along edges: vertices farther than this are not reached, positive; 0: all are. */
    double cutoff;
    int32_t flow; /**< For the heat method: CATA_FLOW_*. */
} cata_distance_params;
/** Fills a struct with the defaults. */
cata_status cata_distance_params_init(cata_distance_params *params, size_t struct_size);

/** Prepares the distances over the surface of a mesh by the heat method (Crane, Weischedel and
 * Wardetzky 2013), by two factorizations. A mesh of fewer than 500 faces is refined for it. */
cata_status cata_heat_new(size_t n_vertices, const double *vertices, size_t n_faces,
    const uint32_t *faces, const cata_distance_params *params, cata_heat **heat);

void cata_heat_free(cata_heat *heat); /**< Frees what was prepared. */

/** Computes the distance of every vertex from the nearest source over the surface: not exact, at
 * least the straight distance through space, and at most that along edges.
 * - `count`, `sources`: vertices.
 * - `distances`: n_vertices elements, written: 0 at sources, INFINITY in components without one. */
cata_status cata_heat_distances(const cata_heat *heat, size_t count, const uint32_t *sources,
    double *distances);

/** Computes the length of the shortest path along edges from every vertex to the nearest source
 * (Dijkstra 1959), on the calling thread.
 * - `count`, `sources`: vertices.
 * - `distances`: n_vertices elements, written: INFINITY where no path leads.
 * - `nearest`: n_vertices elements, written: the vertex of the nearest source, CATA_NO_VERTEX
 *   where no path leads. NULL where not wanted.
 * - `before`: n_vertices elements, written: the vertex before each on the path from its source,
 *   CATA_NO_VERTEX at sources and where no path leads. NULL where not wanted.
 * - `params`: `cutoff` and `progress` are used, the rest is only checked. */
cata_status cata_distance_edges(size_t n_vertices, const double *vertices, size_t n_faces,
    const uint32_t *faces, size_t count, const uint32_t *sources, double *distances,
    uint32_t *nearest, uint32_t *before, const cata_distance_params *params);

/** Computes the exact distance of every vertex from the nearest source over the surface, up to
 * rounding: the length of the shortest path over faces (Mitchell, Mount and Papadimitriou 1987;
 * Xin and Wang 2009), on the calling thread. Edges may have any number of faces; none may be
 * without length.
 * - `count`, `sources`: vertices; with `weights`, the faces of points, or CATA_IN_SPACE: the
 *   nearest vertex.
 * - `weights`: 3 `count` elements, read: barycentric coordinates in the faces, or x, y, z. NULL:
 *   the sources are vertices.
 * - `distances`: n_vertices elements, written: 0 at sources, INFINITY in components without one.
 * - `params`: `progress` is used, the rest is only checked. */
cata_status cata_distance_exact(size_t n_vertices, const double *vertices, size_t n_faces,
    const uint32_t *faces, size_t count, const uint32_t *sources, const double *weights,
    double *distances, const cata_distance_params *params);

/** Finds the shortest path over faces that leads through points in their order: from the first to
 * the last. Without a path, the sizes are 0, and the length is INFINITY.
 * - `count`, `through`: vertices, at least two; with `weights`, the faces of points, or
 *   CATA_IN_SPACE: the nearest vertex.
 * - `weights`: 3 `count` elements, read: barycentric coordinates in the faces, or x, y, z. NULL:
 *   the points are vertices.
 * - `params`: `progress` is used, the rest is only checked. */
cata_status cata_distance_path_exact(size_t n_vertices, const double *vertices, size_t n_faces,
    const uint32_t *faces, size_t count, const uint32_t *through, const double *weights,
    const cata_distance_params *params, cata_path **path);

/** Traces the geodesic that leaves a point in a direction, for a length: the exponential map of the
 * surface. It is straight over faces and edges, and passes vertices with equal angles on both
 * sides (Polthier and Schmies 1998). It stops at the boundary, and where more than one way leads
 * on.
 * - `start`: a vertex; with `weights`, the face of the point, or CATA_IN_SPACE: the nearest
 *   vertex.
 * - `weights`: 3 elements, read: barycentric coordinates in the face, or x, y, z. NULL: the start
 *   is a vertex.
 * - `direction`: 3 elements, read: of any length, not 0. It is projected onto the plane of the
 *   face; at an edge or a vertex it may point out of the face. At a start that is a vertex it
 *   stands for the nearest direction over a face.
 * - `length`: at least 0.
 * - `params`: `progress` is used, the rest is only checked.
 * - `path`: the geodesic, whose length is less than `length` if it stops, and which has no
 *   vertices; see cata_path_places for its end.
 * - `end`: how it ends, CATA_TRACE_*. NULL where not wanted.
 * - `heading`: 3 elements, written: the direction at its end, of length 1, in the plane of the
 *   face of the last point. NULL where not wanted. */
cata_status cata_distance_trace(size_t n_vertices, const double *vertices, size_t n_faces,
    const uint32_t *faces, uint32_t start, const double *weights, const double *direction,
    double length, const cata_distance_params *params, cata_path **path, int32_t *end,
    double *heading);

/** Finds the shortest path along edges from one vertex to another. Without a path, all sizes are 0,
 * and the length is INFINITY.
 * - `straight`: 1: the path is shortened, over faces, until it is straight but for vertices on the
 *   boundary of the mesh, where it stays (Sharp and Crane 2020): a geodesic, which need not be the
 *   shortest. The mesh must be a manifold whose faces agree about which side is outside. 0: the
 *   path along edges.
 * - `params`: `progress` is used, the rest is only checked. */
cata_status cata_distance_path(size_t n_vertices, const double *vertices, size_t n_faces,
    const uint32_t *faces, uint32_t from, uint32_t to, int32_t straight,
    const cata_distance_params *params, cata_path **path);

/** Gets the numbers of vertices and of points of a path, and its length. NULL where not wanted. */
cata_status cata_path_size(const cata_path *path, size_t *n_vertices, size_t *n_points,
    double *length);

/** Gets a path; NULL where not wanted.
 * - `vertices`: n_vertices elements, written: those of the path along edges, both ends included;
 *   of an exact path those that it was asked to lead through, none where it was asked for points.
 * - `points`: 3 n_points elements, written: where the path goes, the positions of `vertices`
 *   unless it is straight. */
cata_status cata_path_get(const cata_path *path, uint32_t *vertices, double *points);

/** Gets the points of a path of cata_distance_path_exact or cata_distance_trace as points of faces;
 * NULL where not wanted.
 * - `faces`: n_points elements, written.
 * - `weights`: 3 n_points elements, written: barycentric coordinates at the corners of faces. */
cata_status cata_path_places(const cata_path *path, uint32_t *faces, double *weights);

void cata_path_free(cata_path *path); /**< Frees a path. */

/** @} */

/* ==== Decimation ============================================================================ */
/**
 * @defgroup decimation Decimation
 * A mesh with a given number of vertices, spread evenly over the surface (thesis, chapter 5),
 * and what carries functions, attributes and textures from one to the other.
 * @code{.c}
 * double v[] = {1, 0, 0, 0, 1, 0, -1, 0, 0, 0, -1, 0, 0, 0, 1, 0, 0, -1}; // an octahedron
 * uint32_t f[] = {0, 1, 4, 1, 2, 4, 2, 3, 4, 3, 0, 4, 1, 0, 5, 2, 1, 5, 3, 2, 5, 0, 3, 5};
 * cata_decimation *sphere;
 * size_t n_faces;
 * if (cata_decimation_new(6, v, 8, f, 100, NULL, &sphere) == CATA_OK) {
 *     cata_decimation_size(sphere, NULL, &n_faces, NULL);
 *     printf("%zu\n", n_faces); // 196
 *     cata_decimation_free(sphere);
 * }
 * @endcode
 * @{
 */

#define CATA_DECIMATION_UNIFORM 0 /**< `method`: exactly n vertices, the topology of the input. */
#define CATA_DECIMATION_THESIS 1 /**< `method`: algorithm 5.2, for comparison: no manifold. */
#define CATA_NO_PASSES -1 /**< Passes: none, where 0 stands for the default. */

/** A decimated mesh, and how it lies on the input. Made by cata_decimation_new; constant. */
typedef struct cata_decimation cata_decimation;

/** How a mesh is decimated. */
typedef struct cata_decimation_params {
    size_t struct_size; /**< sizeof(cata_decimation_params). */
    size_t threads; /**< Threads, at most; 0: all. */
    cata_progress progress; /**< Progress callback; NULL: none. */
    void *progress_user; /**< Passed to `progress`. */
    int32_t method; /**< CATA_DECIMATION_*. */
    int32_t lloyd; /**< Passes that move samples to the centroids of their cells; 0: none. */
    /** Passes that flip edges and move vertices of the result; 0: 12, or CATA_NO_PASSES. */
    int32_t relaxation;
    uint32_t first; /**< With `has_first` 1: the vertex of the first sample. Otherwise ignored. */
    int32_t has_first; /**< 1: `first` is used; 0: the lowest vertex that a face has. */
    /** 1: handles too narrow for the triangles of the result are cut, and their ends closed. 0:
     * they are kept. */
    int32_t cut_narrow_handles;
    /** 1: edges of the input stay whole, and n is at most its number of vertices. 0: those
     * longer than the edges of the result are split first. */
    int32_t keep_edges;
    /** Vertices that stay, each once: the first of the result, in this order, at the same
     * positions; edges between them stay, unless they are longer than those of the result and
     * split (cata_decimation_locked_edges). NULL: none. */
    const uint32_t *locked;
    size_t n_locked; /**< Number of `locked`, at most n. */
    /** 1: the relaxation ends with passes that make areas as equal as possible, at the cost of
     * the shapes of triangles. 0: it does not. */
    int32_t uniform;
    /** Vertices of the result per area, relative to elsewhere: a positive number for each vertex
     * of the input. NULL: the same everywhere. */
    const double *density;
    size_t n_density; /**< Number of `density`: n_vertices, or 0. */
    /** Up to how many times as many vertices per area where the surface bends; 0: 1. */
    double curvature;
} cata_decimation_params;
/** Fills a struct with the defaults. */
cata_status cata_decimation_params_init(cata_decimation_params *params, size_t struct_size);

/** Decimates a triangle mesh to exactly n vertices, uniformly: a manifold with the components,
 * boundary loops and genus of the input. The input is cut along edges of more than two faces
 * first, and edges longer than those of the result are split, so that n may also be more than the
 * input has. No step makes faces intersect that did not. Impossible requests return an error, and
 * the message says why.
 * - `n`: vertices of the result. With fewer than the topology needs, CATA_ERR_ARGUMENT.
 * - `decimation`: one pointer, written. */
cata_status cata_decimation_new(size_t n_vertices, const double *vertices, size_t n_faces,
    const uint32_t *faces, size_t n, const cata_decimation_params *params,
    cata_decimation **decimation);

/** Decimates a triangle mesh as cata_decimation_new does, to the fewest vertices that a search
 * finds for which no point of either surface is farther from the other one than `error`: what
 * cata_decimation_bound returns is at most `error`. The number is at most 2 % (or 1) above one
 * that is too small.
 * - `error`: positive, in the unit of the mesh. If it can't be reached, CATA_ERR_ARGUMENT.
 * - `decimation`: one pointer, written. */
cata_status cata_decimation_new_within(size_t n_vertices, const double *vertices, size_t n_faces,
    const uint32_t *faces, double error, const cata_decimation_params *params,
    cata_decimation **decimation);

/** Computes an upper bound of the distance of any point of the input or of the result from the
 * other surface: the Hausdorff distance, or at most 1 % more.
 * - `bound`: written, in the unit of the mesh. */
cata_status cata_decimation_bound(const cata_decimation *decimation, double *bound);

/** Gets the number of edges of the input between locked vertices, and that of those which the
 * result does not have: edges longer than its own were split. NULL where not wanted. */
cata_status cata_decimation_locked_edges(const cata_decimation *decimation, size_t *n_edges,
    size_t *n_lost);

void cata_decimation_free(cata_decimation *decimation); /**< Frees a decimation. */

/** Gets the numbers of vertices and faces of the result, and whether the input had to be repaired
 * (repeated faces and vertices without a face left out, faces flipped, the mesh cut): 1, or 0.
 * NULL where not wanted. */
cata_status cata_decimation_size(const cata_decimation *decimation, size_t *n_vertices,
    size_t *n_faces, int32_t *repaired);

/** Gets the vertices and faces of the result, as many as cata_decimation_size returns; NULL where
 * not wanted. */
cata_status cata_decimation_get(const cata_decimation *decimation, double *vertices,
    uint32_t *faces);

/** Gets where the result lies on the input; NULL where not wanted.
 * - `cells`: for each vertex of the input the nearest one of the result along edges, written;
 *   UINT32_MAX for those that no face has.
 * - `distances`: for each vertex of the input how far that is, written.
 * - `places`: for each vertex of the result the face of the input at it, written.
 * - `weights`: 3 for each vertex of the result, written: its barycentric coordinates there. */
cata_status cata_decimation_places(const cata_decimation *decimation, uint32_t *cells,
    float *distances, uint32_t *places, double *weights);

/** Computes values of the input's vertices at the vertices of the result: `width` for each, one
 * vertex after the other. */
cata_status cata_decimation_carry(const cata_decimation *decimation, size_t width,
    const double *values, double *carried);

/** Computes values of the result's vertices at the vertices of the input: each is the mean of those
 * of a face near it, 0 at vertices without a face. */
cata_status cata_decimation_prolong(const cata_decimation *decimation, size_t width,
    const double *values, double *prolonged);

/** Computes the k smallest eigenpairs of the Laplacian of the input, approximately, from those of
 * the result, as cata_eigs_two_level does. Eigenvalues are about 0.1 % too large where the
 * triangles of the input are even, and several per cent where they are long and thin.
 * - `k`: at most the vertices of the result.
 * - `eigenvalues`, `eigenvectors`, `residuals`, `masses`: as those of cata_mesh_eigs.
 * - `params`: as for cata_eigs_two_level, with CATA_BOUNDARY_NEUMANN. */
cata_status cata_decimation_eigs(const cata_decimation *decimation, size_t k, double *eigenvalues,
    double *eigenvectors, size_t ldv, double *residuals, double *masses,
    const cata_eigs_params *params);

/** Computes the texture of the result, from that of the input, with its seams.
 * - `uv`: 6 for each face of the input, read: u and v at its three corners.
 * - `carried`: 6 for each face of the result, written. */
cata_status cata_decimation_carry_uv(const cata_decimation *decimation, const double *uv,
    double *carried);

/** Computes the farthest points of a mesh: each new sample is the vertex farthest along edges from
 * those before, so that the first ones are the same for every n.
 * - `n`: samples, at most the vertices that have a face.
 * - `samples`: n vertices, written, in their order.
 * - `nearest`: n_vertices elements, written: the number of the sample nearest to each vertex,
 *   UINT32_MAX for those that no face has. NULL where not wanted.
 * - `distances`: n_vertices elements, written: how far it is. NULL where not wanted.
 * - `params`: `first` and `progress` are used, the rest is only checked. On the calling thread. */
cata_status cata_decimation_farthest_points(size_t n_vertices, const double *vertices,
    size_t n_faces, const uint32_t *faces, size_t n, uint32_t *samples, uint32_t *nearest,
    float *distances, const cata_decimation_params *params);

/** @} */

/* ==== Curves ================================================================================ */
/**
 * @defgroup curves Curves
 * Closed or open curves along the edges of a mesh through samples of them, whose order is found
 * (thesis, chapter 6): a solver for each mesh, for many curves.
 * @code{.c}
 * double v[] = {0, 0, 0, 1, 0, 0, 1, 1, 0, 0, 1, 0, .5, .5, 0}, length;
 * uint32_t f[] = {0, 1, 4, 1, 2, 4, 2, 3, 4, 3, 0, 4}, samples[] = {0, 2, 1, 3};
 * cata_curve_solver *solver;
 * cata_curves *curves;
 * cata_curve_solver_new(5, v, 4, f, &solver);
 * cata_curve_solver_find(solver, 4, samples, NULL, &curves);
 * cata_curves_size(curves, 0, NULL, NULL, NULL, &length);
 * printf("%g\n", length); // 4
 * cata_curves_free(curves);
 * cata_curve_solver_free(solver);
 * @endcode
 * @{
 */

#define CATA_CURVE_CLOSED 0 /**< `outcome`: the curve is closed, or all curves are. */
#define CATA_CURVE_OPEN 1 /**< `outcome`: the curve is open, as requested. */
#define CATA_CURVE_BLOCKED 2 /**< `outcome`: no path leaves one of the samples. */
#define CATA_CURVE_CLOSE_BLOCKED 3 /**< `outcome`: no path leads back to the first sample. */
#define CATA_CURVE_DISCONNECTED 4 /**< `outcome`: samples are on several components. */
#define CATA_CURVE_STEINER 0 /**< `points`: vertices, and new ones on edges where needed. */
#define CATA_CURVE_VERTICES 1 /**< `points`: vertices of the mesh alone. */
#define CATA_IN_SPACE UINT32_MAX /**< Instead of a face: the place is a point in space. */

/** A mesh, prepared for the search for curves. Made by cata_curve_solver_new. */
typedef struct cata_curve_solver cata_curve_solver;

/** Curves that were found. Made by cata_curve_solver_find; constant. */
typedef struct cata_curves cata_curves;

/** How curves are found. They are found on the calling thread. */
typedef struct cata_curve_params {
    size_t struct_size; /**< sizeof(cata_curve_params). */
    size_t threads; /**< Ignored. */
    cata_progress progress; /**< Progress callback; NULL: none. */
    void *progress_user; /**< Passed to `progress`. */
    /** With `faithful` 1: among how many of the nearest samples the next one is chosen; 0: 5. */
    size_t candidates;
    size_t start; /**< With `faithful` 1: the number of the sample that the curve starts at. */
    /** 1: algorithm 6.1 of the thesis, from sample to sample. 0: the order first, then paths
     * that do not meet. */
    int32_t faithful;
    int32_t open; /**< 1: an open curve; 0: closed. */
    /** 1: one curve, even where there are gaps as between several; 0: as many as there are gaps
     * for. */
    int32_t single;
    int32_t points; /**< CATA_CURVE_STEINER or CATA_CURVE_VERTICES. */
    /** 1: curves are shortened to geodesics between their samples. 0: they are along edges. */
    int32_t smooth;
    int32_t reserved; /**< 0. */
    /** 1: outliers are dropped: one or two successive samples to which the curve makes a detour
     * of more than three times the median distance between successive samples (at the ends of an
     * open curve, six times). At least half of the samples stay. Not with `faithful` 1. */
    int32_t drop_outliers;
} cata_curve_params;
/** Fills a struct with the defaults. */
cata_status cata_curve_params_init(cata_curve_params *params, size_t struct_size);

/** Creates a solver for a mesh of any kind, of which it keeps a copy. */
cata_status cata_curve_solver_new(size_t n_vertices, const double *vertices, size_t n_faces,
    const uint32_t *faces, cata_curve_solver **solver);

/** Creates a solver as cata_curve_solver_new, for samples that need not be vertices: those inside
 * of faces become vertices, numbered from n_vertices on, which cut their faces.
 * - `count`: number of places.
 * - `places`: `count` elements, read: the face of each, or CATA_IN_SPACE: the nearest vertex.
 * - `weights`: 3 `count` elements, read: barycentric coordinates in the face, or x, y, z.
 * - `samples`: `count` elements, written: the vertices that stand for the places. */
cata_status cata_curve_solver_new_at(size_t n_vertices, const double *vertices, size_t n_faces,
    const uint32_t *faces, size_t count, const uint32_t *places, const double *weights,
    uint32_t *samples, cata_curve_solver **solver);

void cata_curve_solver_free(cata_curve_solver *solver); /**< Frees a solver. */

/** Finds the curves through unordered samples; they meet neither themselves nor each other. The
 * same samples give the same curves, bit for bit. CATA_OK also when there is no complete curve:
 * see cata_curves_outcome.
 * - `samples`: `count` elements, read: vertices, at least 3, none twice. */
cata_status cata_curve_solver_find(cata_curve_solver *solver, size_t count, const uint32_t *samples,
    const cata_curve_params *params, cata_curves **curves);

void cata_curves_free(cata_curves *curves); /**< Frees curves. */

/** Gets how the search ended, CATA_CURVE_*; the number of curves; and the number of samples that no
 * curve is through, because their components of the mesh have fewer than three. NULL where not
 * wanted. */
cata_status cata_curves_outcome(const cata_curves *curves, int32_t *outcome, size_t *count,
    size_t *left_out);

/** Gets the numbers of samples, of vertices and of points of a curve, from 0, and its length. NULL
 * where not wanted. */
cata_status cata_curves_size(const cata_curves *curves, size_t curve, size_t *n_samples,
    size_t *n_vertices, size_t *n_points, double *length);

/** Gets a curve; NULL where not wanted.
 * - `order`: n_samples elements, written: numbers of samples in the order of the curve.
 * - `path`: n_vertices elements, written: its vertices, the first one not repeated; those from
 *   the number of vertices of the mesh on were added.
 * - `points`: 3 n_points elements, written: where the curve goes, those of `path` unless it is
 *   smooth. */
cata_status cata_curves_get(const cata_curves *curves, size_t curve, uint32_t *order,
    uint32_t *path, double *points);

/** Gets where the points of a curve are on the mesh of `solver`, which found the curves. NULL
 * where not wanted. The first call takes time in proportion to the size of the mesh.
 * - `faces`: n_points elements, written: a face of the mesh, as it was given, for each point.
 * - `weights`: 3 n_points elements, written: barycentric coordinates in that face. */
cata_status cata_curves_places(const cata_curves *curves, const cata_curve_solver *solver,
    size_t curve, uint32_t *faces, double *weights);

/** Gets how many samples were dropped as outliers, and which, ascending. NULL where not wanted.
 * - `samples`: as many elements as `count` tells, written. */
cata_status cata_curves_outliers(const cata_curves *curves, size_t *count, uint32_t *samples);

/** Gets the numbers of samples that no curve is through: components with fewer than three. */
cata_status cata_curves_left_out(const cata_curves *curves, uint32_t *samples);

/** @} */

/* ==== Regions =============================================================================== */
/**
 * @defgroup regions Regions
 * Curves drawn into a mesh, so that they run along its edges; the regions that they enclose, which
 * are sets of faces (1 for a face inside, 0 for any other), and their algebra; cuts and parts.
 * @code{.c}
 * double v[] = {0, 0, 0, 1, 0, 0, 1, 1, 0, 0, 1, 0}, area; // a square
 * uint32_t f[] = {0, 1, 3, 1, 2, 3}, along[] = {1, 3};
 * uint8_t inside[2];
 * cata_region_enclosed(4, v, 2, f, 1, along, CATA_SIDE_SMALL, 0, NULL, inside);
 * cata_region_area(4, v, 2, f, inside, &area);
 * printf("%d %d, area %g\n", inside[0], inside[1], area); // 1 0, area 0.5
 * @endcode
 * @{
 */

/** Layers of curves on one mesh: those of one layer do not meet, those of several may cross. Made
 * by cata_drawing_new. */
typedef struct cata_drawing cata_drawing;

/** A mesh with the curves of a drawing along its edges. Made by cata_drawing_inscribe; constant. */
typedef struct cata_drawn cata_drawn;

/** Creates a drawing without curves on a mesh, of which it keeps a copy. */
cata_status cata_drawing_new(size_t n_vertices, const double *vertices, size_t n_faces,
    const uint32_t *faces, cata_drawing **drawing);

/** Frees a drawing; a cata_drawn of it stays valid. */
void cata_drawing_free(cata_drawing *drawing);

/** Finds the curves through samples, as cata_curve_solver_find does, and adds them as a layer.
 * - `count`, `samples`: vertices of the mesh, at least 3, none twice.
 * - `outcome`: written: CATA_CURVE_*. NULL where not wanted.
 * - `params`: `smooth` must be 0: cata_drawing_inscribe shortens all curves. */
cata_status cata_drawing_add(cata_drawing *drawing, size_t count, const uint32_t *samples,
    int32_t *outcome, const cata_curve_params *params);

/** Makes a mesh of the same surface with the curves of all layers along its edges: vertices where
 * curves cross edges and each other follow those of the mesh.
 * - `smooth`: 1: all curves are shortened to geodesics between their samples first; no layer can
 *   be added after that. 0: they are along edges. */
cata_status cata_drawing_inscribe(cata_drawing *drawing, int32_t smooth, cata_drawn **drawn);

/** Gets the numbers of vertices and faces of the mesh, and of layers. NULL where not wanted. */
cata_status cata_drawn_size(const cata_drawn *drawn, size_t *n_vertices, size_t *n_faces,
    size_t *layers);

/** Gets the mesh, and where it lies on that of the drawing; NULL where not wanted.
 * - `vertices`, `faces`: as many as cata_drawn_size tells, written.
 * - `of_faces`: for each face the one of the drawing's mesh that contains it, written.
 * - `corners`, `weights`: for each vertex 3 vertices of a face of the drawing's mesh and their
 *   weights, whose mean it is, written. */
cata_status cata_drawn_get(const cata_drawn *drawn, double *vertices, uint32_t *faces,
    uint32_t *of_faces, uint32_t *corners, double *weights);

/** Gets the edges of the curves of a layer, from 0, for cata_region_enclosed and cata_region_cut.
 * - `room`: the number of edges that `along` has room for; CATA_ERR_SHAPE where there are more.
 * - `along`: 2 vertices for each edge, written. NULL where not wanted.
 * - `count`: written: the number of edges. */
cata_status cata_drawn_edges(const cata_drawn *drawn, size_t layer, size_t room, uint32_t *along,
    size_t *count);

/** Computes the share of each face of the drawing's mesh that a region of the mesh of `drawn`
 * covers.
 * - `inside`: one element for each face of the mesh of `drawn`: 1 inside of the region, 0 outside.
 * - `shares`: one element for each face of the drawing's mesh, written: exactly 0 or 1 where none
 *   or all of it is inside. */
cata_status cata_drawn_shares(const cata_drawn *drawn, const uint8_t *inside, double *shares);

void cata_drawn_free(cata_drawn *drawn); /**< Frees a mesh with curves. */

#define CATA_SIDE_SMALL 0 /**< `side`: that of smaller area. */
#define CATA_SIDE_LARGE 1 /**< `side`: that of larger area. */
#define CATA_SIDE_SEEDS 2 /**< `side`: the pieces with the seeds. */
#define CATA_REGION_UNION 0 /**< `operation`: the faces in one of two regions, or both. */
#define CATA_REGION_INTERSECTION 1 /**< `operation`: the faces in both. */
#define CATA_REGION_DIFFERENCE 2 /**< `operation`: the faces in the first one alone. */
#define CATA_REGION_SYMMETRIC_DIFFERENCE 3 /**< `operation`: the faces in one of them alone. */

/** A part of a mesh, or the whole, cut open; and where it comes from. Constant. */
typedef struct cata_part cata_part;

/** Finds the region that curves along edges enclose. With a side by area, each curve leads from one
 * side to the other, and one side is taken on each part of the surface with curves; a ring, too,
 * is a region. CATA_ERR_MESH: the message names an edge with the same region on both sides.
 * - `count`, `along`: edges, 2 vertices each.
 * - `side`: CATA_SIDE_*; of equal areas, the side with the lowest face is the small one.
 * - `n_seeds`, `seeds`: with CATA_SIDE_SEEDS: vertices on no curve. Otherwise ignored.
 * - `inside`: n_faces elements, written. */
cata_status cata_region_enclosed(size_t n_vertices, const double *vertices, size_t n_faces,
    const uint32_t *faces, size_t count, const uint32_t *along, int32_t side, size_t n_seeds,
    const uint32_t *seeds, uint8_t *inside);

/** Combines two regions of the same mesh: `operation`, CATA_REGION_*; n_faces elements each, the
 * result written. The difference from a region of all faces is the complement. */
cata_status cata_region_combine(int32_t operation, size_t n_faces, const uint8_t *first,
    const uint8_t *second, uint8_t *result);

/** Computes the area of a region: `inside`, n_faces elements; `area`, written. */
cata_status cata_region_area(size_t n_vertices, const double *vertices, size_t n_faces,
    const uint32_t *faces, const uint8_t *inside, double *area);

/** Finds the edges between faces inside of a region and others.
 * - `inside`: n_faces elements.
 * - `room`: the number of edges that `edges` has room for; CATA_ERR_SHAPE where there are more.
 * - `edges`: 2 vertices for each edge, the lower first, written; ascending. NULL where not wanted.
 * - `count`: written: the number of edges. */
cata_status cata_region_boundary(size_t n_vertices, const double *vertices, size_t n_faces,
    const uint32_t *faces, const uint8_t *inside, size_t room, uint32_t *edges, size_t *count);

/** Makes a mesh of the faces of a region, with the vertices that they use: `inside`, n_faces
 * elements; `part`, one pointer, written. */
cata_status cata_region_part(size_t n_vertices, const double *vertices, size_t n_faces,
    const uint32_t *faces, const uint8_t *inside, cata_part **part);

/** Cuts a mesh open along edges: a vertex whose faces they separate becomes one for each part.
 * Faces keep their order, and new vertices follow those of the mesh.
 * - `count`, `along`: edges, 2 vertices each.
 * - `part`: one pointer, written. */
cata_status cata_region_cut(size_t n_vertices, const double *vertices, size_t n_faces,
    const uint32_t *faces, size_t count, const uint32_t *along, cata_part **part);

/** Gets the numbers of vertices and faces of a part. NULL where not wanted. */
cata_status cata_part_size(const cata_part *part, size_t *n_vertices, size_t *n_faces);

/** Gets a part; NULL where not wanted.
 * - `vertices`, `faces`: of the part, as many as cata_part_size tells, written.
 * - `of_vertices`: for each vertex its number in the mesh, written.
 * - `of_faces`: for each face its number in the mesh, written. */
cata_status cata_part_get(const cata_part *part, double *vertices, uint32_t *faces,
    uint32_t *of_vertices, uint32_t *of_faces);

void cata_part_free(cata_part *part); /**< Frees a part. */

/** @} */

/* ==== Spectra and maps ====================================================================== */
/**
 * @defgroup spectra Spectra and maps
 * Eigenfunctions of two shapes and their products as bases; functional maps between them,
 * functions and details carried over; ShapeDNA (thesis, chapter 1).
 * @code{.c}
 * double masses[] = {0.5, 0.5}, values[] = {0, 1}, vectors[] = {1, 1, 1, -1};
 * double f[] = {3, 1}, gains[] = {1, 0}, g[2];
 * cata_basis *basis;
 * cata_basis_new(2, 2, masses, values, vectors, 2, NULL, &basis);
 * cata_basis_filter(basis, CATA_COL_MAJOR, 1, f, 2, gains, 0, g, 2);
 * printf("%g %g\n", g[0], g[1]); // 2 2
 * cata_basis_free(basis);
 * @endcode
 * @{
 */

/** Functions on the vertices of a mesh, r linearly independent ones, with the inner product of
 * its masses: eigenfunctions (cata_basis_new) or their products (cata_basis_products). */
typedef struct cata_basis cata_basis;

/** Options of bases of products, and of the other calls of this chapter. */
typedef struct cata_basis_params {
    size_t struct_size; /**< sizeof(cata_basis_params). */
    size_t threads; /**< Threads, at most; 0: all. A basis keeps this for its own calls. */
    /** Progress callback; NULL: none. A basis does not keep it: its own calls are short. */
    cata_progress progress;
    void *progress_user; /**< Passed to `progress`. */
    size_t order; /**< For products: most factors, at most 255; 1: eigenfunctions alone; 0: 2. */
    /** For products: CATA_ORTHO_*; 0: CATA_ORTHO_SINGLE_PASS, which is stabler under transfer. */
    int32_t method;
} cata_basis_params;
/** Fills a struct with the defaults. */
cata_status cata_basis_params_init(cata_basis_params *params, size_t struct_size);

/** Creates the basis of k eigenfunctions, as cata_mesh_eigs computes them, which are copied.
 * - `masses`: n elements, positive: those of the vertices.
 * - `eigenvalues`: k elements, ascending.
 * - `eigenvectors`: n x k, column-major: orthonormal in the inner product of the masses. The
 *   constant, where it is in the span of those of eigenvalue 0, becomes the first one. */
cata_status cata_basis_new(size_t n, size_t k, const double *masses, const double *eigenvalues,
    const double *eigenvectors, size_t ldv, const cata_basis_params *params, cata_basis **basis);

/** Computes the products of at most `order` eigenfunctions, each divided by the constant, made
 * orthonormal (CATA_ORTHO_SINGLE_PASS: nearly) and without those that depend on others: B = Q R, B
 * being all products in the order 1, phi_1, ..., phi_1 phi_1, phi_1 phi_2, ..., and Q the basis.
 *
 * `eigenfunctions`: of cata_basis_new, the constant among them. */
cata_status cata_basis_products(const cata_basis *eigenfunctions, const cata_basis_params *params,
    cata_basis **basis);

/** Frees a basis; a cata_map_fit that uses it stays valid. */
void cata_basis_free(cata_basis *basis);

/** Gets the sizes of a basis: vertices, functions, and all products that they were made of, 0 for a
 * basis of cata_basis_new. Each is NULL where not wanted. */
cata_status cata_basis_size(const cata_basis *basis, size_t *n, size_t *r, size_t *products);

/** Copies a basis, each part NULL where not wanted: `q`: n x r, its functions; `triangle`: r x
 * products, R; `kept`: r elements, ascending: the product, from 0, that each function comes
 * from. The last two are of products only. */
cata_status cata_basis_copy(const cata_basis *basis, int32_t layout, double *q, size_t ldq,
    double *triangle, size_t ldtriangle, size_t *kept);

/** Computes the coefficients C (r x count) of the functions in the span that are nearest to the
 * columns of F (n x count). */
cata_status cata_basis_analysis(const cata_basis *basis, int32_t layout, size_t count,
    const double *f, size_t ldf, double *c, size_t ldc);

/** Computes the functions F (n x count) with the coefficients C (r x count). */
cata_status cata_basis_synthesis(const cata_basis *basis, int32_t layout, size_t count,
    const double *c, size_t ldc, double *f, size_t ldf);

/** Computes G: the columns of F (both n x count) with their coefficients multiplied by `gains`, r
 * elements (exp(-t eigenvalue): what heat does in the time t), and what is outside of the span by
 * `rest`: 0 leaves it out, 1 keeps it. */
cata_status cata_basis_filter(const cata_basis *basis, int32_t layout, size_t count,
    const double *f, size_t ldf, const double *gains, double rest, double *g, size_t ldg);

/** Adds `amount` times the function `index`, from 0, to the columns of F (n x count). */
cata_status cata_basis_add_coefficient(const cata_basis *basis, size_t index, double amount,
    int32_t layout, size_t count, double *f, size_t ldf);

/** Splits the columns of F into LOW + HIGH (all n x count): their part in the span, and the detail
 * that is left. */
cata_status cata_basis_split(const cata_basis *basis, int32_t layout, size_t count, const double *f,
    size_t ldf, double *low, size_t ldlow, double *high, size_t ldhigh);

#define CATA_RESPONSE_LOW_PASS 0 /**< `response`: 1 up to the frequency `first`, 0 beyond. */
#define CATA_RESPONSE_HIGH_PASS 1 /**< `response`: 0 up to the frequency `first`, 1 beyond. */

/** `response`: 1 from the frequency `first` to `second`, 0 elsewhere. */
#define CATA_RESPONSE_BAND_PASS 2
#define CATA_RESPONSE_HEAT 3 /**< `response`: exp(-t frequency), t = `first`: diffusion. */

/** `response`: 1 + s (1 - exp(-t frequency)), t = `first`, s = `second`. */
#define CATA_RESPONSE_SHARPEN 4

/** Computes the gains of a filter for cata_basis_filter.
 * - `response`: CATA_RESPONSE_*, with its numbers `first` and `second`; one that it does not have
 *   is ignored. Frequencies are in units of 1 / length^2, times in units of length^2.
 * - `count`, `frequencies`: eigenvalues, or energies of cata_filter_energies.
 * - `gains`: `count` elements, written.
 * - `rest`: written: the gain beyond all frequencies; NULL where not wanted. */
cata_status cata_filter_gains(int32_t response, double first, double second, size_t count,
    const double *frequencies, double *gains, double *rest);

/** Computes the frequencies of functions: the energy of each, (f, W f) / (f, M f), which for
 * eigenfunctions is the eigenvalue; 0 for the function 0.
 * - `n`, `row_starts`, `columns`, `entries`, `masses`: W and M, as those of cata_eigs.
 * - `count`, `f`: functions, n x count.
 * - `energies`: `count` elements, written. */
cata_status cata_filter_energies(size_t n, const size_t *row_starts, const size_t *columns,
    const double *entries, const double *masses, int32_t layout, size_t count, const double *f,
    size_t ldf, double *energies);

/** A functional map C between two bases of cata_basis_new that is being fitted: r_target x
 * r_source, it takes coefficients of functions on the source to those of functions on the
 * target. */
typedef struct cata_map_fit cata_map_fit;

/** Creates an empty fit, with the threads of `source`. */
cata_status cata_map_fit_new(const cata_basis *source, const cata_basis *target,
    cata_map_fit **fit);

void cata_map_fit_free(cata_map_fit *fit); /**< Frees a fit. */

/** Adds functions that correspond: columns of F (n_source x count) and G (n_target x count).
 * Each pair counts the same. */
cata_status cata_map_fit_functions(cata_map_fit *fit, int32_t layout, size_t count, const double *f,
    size_t ldf, const double *g, size_t ldg);

/** Adds that C commutes with multiplications by such functions, with this weight; 0.1 is usual.
 * A function constrains the map far more in this way. */
cata_status cata_map_fit_operators(cata_map_fit *fit, int32_t layout, size_t count, const double *f,
    size_t ldf, const double *g, size_t ldg, double weight);

/** Adds vertices that correspond, by heat kernels around them. `pairs`: 2 count elements, a
 * vertex of the source and one of the target each. */
cata_status cata_map_fit_landmarks(cata_map_fit *fit, size_t count, const uint32_t *pairs);

/** Adds segments that correspond: a label for each vertex of the source and of the target. Every
 * label, 0 too, must be on both. */
cata_status cata_map_fit_segments(cata_map_fit *fit, const uint32_t *source_labels,
    const uint32_t *target_labels);

/** Adds heat and wave kernel signatures: of `source` and `target`, of cata_basis_new for the same
 * meshes, with more functions than the fit, or as many. */
cata_status cata_map_fit_signatures(cata_map_fit *fit, const cata_basis *source,
    const cata_basis *target);

/** Computes the map C (r_target x r_source, written) that fits best what was added and commutes
 * with the Laplacians; `commutativity` >= 0, usually 1e-3, weighs that. It keeps the constant. */
cata_status cata_map_fit_solve(cata_map_fit *fit, double commutativity, int32_t layout, double *c,
    size_t ldc, const cata_basis_params *params);

/** Iterates closest points: in turns the points of C (r_target x r_source, read and written) and
 * the orthogonal map along them, until these stay the same or `iterations` >= 1 are done.
 * - `source`, `target`: of cata_basis_new.
 * - `points`: n_target elements, written: the vertex of the source for each of the target; NULL
 *   where not wanted. */
cata_status cata_map_icp(const cata_basis *source, const cata_basis *target, size_t iterations,
    int32_t layout, double *c, size_t ldc, uint32_t *points, const cata_basis_params *params);

/** Refines by ZoomOut: in turns the points of a map and the map along them between `step` >= 1
 * functions more, from C (rows x cols, read), a map between the first functions, to the whole MAP
 * (r_target x r_source, written). `source`, `target` and `points` are as in cata_map_icp. */
cata_status cata_map_zoomout(const cata_basis *source, const cata_basis *target, size_t step,
    int32_t layout, size_t rows, size_t cols, const double *c, size_t ldc, double *map,
    size_t ldmap, uint32_t *points, const cata_basis_params *params);

/** Searches for the map of two nearly isometric meshes of which no correspondence is known, and
 * refines it by ZoomOut to the whole MAP (r_target x r_source, written): the one that commutes
 * best with the Laplacians among those that keep the orientation, left and right.
 * - `source`, `target`, `points`: as in cata_map_icp; 40 functions or more are best.
 * - `source_vertices`, `target_vertices`: 3 elements for each vertex of a basis; the faces: 3 for
 *   each.
 * - `is_ambiguous`: written: 1 where another map may be the true one, so that the map is to be
 *   checked, or found from landmarks; 0 otherwise. It is required.
 * - `commutativity`: written: |C L - L' C|^2 / |L|^2 for area 1; `next`: that of the next best
 *   map, infinite without one; `orientation`: written: from -1 to 1, of a map that keeps it near
 *   1. Each is NULL where not wanted. */
cata_status cata_map_search(const cata_basis *source, const cata_basis *target,
    const double *source_vertices, size_t n_source_faces, const uint32_t *source_faces,
    const double *target_vertices, size_t n_target_faces, const uint32_t *target_faces,
    int32_t layout, double *map, size_t ldmap, uint32_t *points, int32_t *is_ambiguous,
    double *commutativity, double *next, double *orientation, const cata_basis_params *params);

/** Computes the points of the map C (r_target x r_source) between any bases: n_target elements,
 * written: for each vertex of the target that of the source whose image is nearest. */
cata_status cata_map_points(const cata_basis *source, const cata_basis *target, int32_t layout,
    const double *c, size_t ldc, uint32_t *points, const cata_basis_params *params);

/** Computes the map O of products of eigenfunctions, r_target x r_source, that a map C of the
 * eigenfunctions implies, since T(f g) = T(f) T(g) (thesis, section 1.3.3). The matrix of all
 * products is not in memory. C must be nearly exact; from points, cata_map_from_points of the
 * products is more accurate.
 * - `source_eigen`, `target_eigen`: of cata_basis_new, the constants among them; `c`: between
 *   them.
 * - `source`, `target`: of cata_basis_products of these, with the same order; `o`: written.
 * - `of_all`: 0: column by column, of the products that are kept (equation 1.18). 1: the least
 *   squares over all products (equation 1.16). */
cata_status cata_product_map(const cata_basis *source_eigen, const cata_basis *target_eigen,
    const cata_basis *source, const cata_basis *target, int32_t layout, const double *c, size_t ldc,
    int32_t of_all, double *o, size_t ldo, const cata_basis_params *params);

/** Computes the map C (r_target x r_source, written) between any bases along points (read). */
cata_status cata_map_from_points(const cata_basis *source, const cata_basis *target,
    const uint32_t *points, int32_t layout, double *c, size_t ldc, const cata_basis_params *params);

/** Carries functions over along points, through the products of eigenfunctions: the same as
 * cata_basis_products of both, cata_map_from_points and cata_transfer_map in turn.
 * - `source`, `target`: of cata_basis_new, the constant among the eigenfunctions.
 * - `points`: n_target elements: the vertex of the source of each vertex of the target.
 * - `f`: F, n_source x count; `g`: G, n_target x count, written. */
cata_status cata_transfer(const cata_basis *source, const cata_basis *target,
    const uint32_t *points, int32_t layout, size_t count, const double *f, size_t ldf, double *g,
    size_t ldg, const cata_basis_params *params);

/** Carries functions over by a map C (r_target x r_source) between any bases: F, n_source x
 * count, to G, n_target x count, written. */
cata_status cata_transfer_map(const cata_basis *source, const cata_basis *target, int32_t layout,
    const double *c, size_t ldc, size_t count, const double *f, size_t ldf, double *g, size_t ldg,
    const cata_basis_params *params);

/** Gives the target mesh the details of the source mesh: heights over the smooth part of the
 * source, carried over by C, along normals in place of its own.
 * - `smooth_source`, `smooth_target`: bases of few functions, whose spans have the smooth
 *   parts.
 * - `source`, `target`, `c`: as in cata_transfer_map.
 * - `positions`: 3 target_n_vertices elements, written: the vertices of the target, moved. */
cata_status cata_transfer_details(size_t n_vertices, const double *vertices, size_t n_faces,
    const uint32_t *faces, size_t target_n_vertices, const double *target_vertices,
    size_t target_n_faces, const uint32_t *target_faces, const cata_basis *smooth_source,
    const cata_basis *smooth_target, const cata_basis *source, const cata_basis *target,
    int32_t layout, const double *c, size_t ldc, double *positions,
    const cata_basis_params *params);

/** Computes ShapeDNA: the k smallest eigenvalues of the Laplacian of a triangle mesh as its
 * signature (Reuter, Wolter and Peinecke 2006).
 * - `k`: number of eigenvalues, at most the vertices that are in a face and not held at zero, and
 *   more than are 0 (cata_mesh_free_components).
 * - `normalized`: 1: they are multiplied by the area, so that they do not depend on the size of
 *   the mesh; 0: they are not.
 * - `signature`: k elements, written: ascending.
 * - `params`: the Laplacian, `threads` and `progress` are used, the rest is only checked. */
cata_status cata_shape_dna(size_t n_vertices, const double *vertices, size_t n_faces,
    const uint32_t *faces, size_t k, int32_t normalized, double *signature,
    const cata_eigs_params *params);

/** Finds the signatures nearest to a query, in Euclidean distance; of equally near ones the first.
 * It looks once at each number, on the calling thread.
 * - `query`: the k numbers of a signature; `signatures`: `count` x k, one after the other.
 * - `indices`, `distances`: `wanted` <= count elements each, written: numbers of signatures
 *   from 0, the nearest first, and their distances. */
cata_status cata_shape_dna_retrieve(size_t k, const double *query, size_t count,
    const double *signatures, size_t wanted, size_t *indices, double *distances);

/** How a template is deformed. */
typedef struct cata_shape_params {
    size_t struct_size; /**< sizeof(cata_shape_params). */
    size_t threads; /**< Threads, at most; 0: all. */
    cata_progress progress; /**< Progress callback; NULL: none. */
    void *progress_user; /**< Passed to `progress`. */
    size_t steps; /**< Steps, at most; 0: 60. */
    /** Mean relative difference of eigenvalues at which it ends, positive; 0: 0.001. */
    double tolerance;
} cata_shape_params;
/** Fills a struct with the defaults. */
cata_status cata_shape_params_init(cata_shape_params *params, size_t struct_size);

/** Deforms a triangle mesh, the template, until the first eigenvalues of its Laplacian are those
 * given (Cosmo et al. 2019): with CATA_BOUNDARY_DIRICHLET, or CATA_BOUNDARY_NEUMANN if the
 * template is closed, whose zeros are left out. Many surfaces have the same eigenvalues; it is one
 * near the template, or falls short of the tolerance, and `error` says so.
 * - `k`, `eigenvalues`: positive, ascending, in units of 1 / length^2.
 * - `positions`: 3 n_vertices elements, written: the vertices, moved.
 * - `found`: k elements, written: the eigenvalues of the result. NULL where not wanted.
 * - `error`: written: their mean relative difference. NULL where not wanted.
 * - `steps`: written: how many were taken. NULL where not wanted. */
cata_status cata_shape_from_spectrum(size_t n_vertices, const double *vertices, size_t n_faces,
    const uint32_t *faces, size_t k, const double *eigenvalues, double *positions, double *found,
    double *error, size_t *steps, const cata_shape_params *params);

/** @} */

/* ==== Descriptors =========================================================================== */
/**
 * @defgroup descriptors Descriptors
 * Numbers for each vertex that tell the points of a shape apart: from eigenpairs (heat and wave
 * kernel signatures, global point signatures), and from the surface around it (SHOT, rings).
 * @code{.c}
 * double values[] = {0, 1}, vectors[] = {1, 1, 1, -1}, times[] = {0, 100}, found[4];
 * cata_descriptor_heat(CATA_COL_MAJOR, 2, 2, values, vectors, 2, 2, times, 0, found, 2, NULL);
 * printf("%g at first, %g in the end\n", found[0], found[2]); // 2 at first, 1 in the end
 * @endcode
 * @{
 */

#define CATA_SHOT_BINS 352 /**< Numbers of a descriptor of cata_descriptor_shot. */

/** Threads and progress of descriptors. */
typedef struct cata_descriptor_params {
    size_t struct_size; /**< sizeof(cata_descriptor_params). */
    size_t threads; /**< Threads, at most; 0: all. */
    cata_progress progress; /**< Progress callback; NULL: none. */
    void *progress_user; /**< Passed to `progress`. */
} cata_descriptor_params;
/** Fills a struct with the defaults. */
cata_status cata_descriptor_params_init(cata_descriptor_params *params, size_t struct_size);

/** Computes heat kernel signatures (Sun, Ovsjanikov and Guibas 2009): for each vertex and time t
 * the sum of exp(-t eigenvalue) times the square of the eigenfunction there.
 * - `k`, `eigenvalues`, `eigenvectors`: as cata_mesh_eigs computes them, n x k.
 * - `count`, `times`: at least 0, in units of length^2; those of cata_descriptor_heat_times are
 *   usual.
 * - `scaled`: 1: each column is divided by the heat trace, so that times compare; 0: it is not.
 * - `signature`: n x count, written, in units of 1 / area, or of 1 where scaled. */
cata_status cata_descriptor_heat(int32_t layout, size_t n, size_t k, const double *eigenvalues,
    const double *eigenvectors, size_t ldv, size_t count, const double *times, int32_t scaled,
    double *signature, size_t ldsignature, const cata_descriptor_params *params);

/** Computes times for cata_descriptor_heat: from 4 ln 10 / the largest eigenvalue to 4 ln 10 / the
 * smallest one that is not 0, in equal ratios. `times`: `count` elements, written, ascending. */
cata_status cata_descriptor_heat_times(size_t k, const double *eigenvalues, size_t count,
    double *times);

/** Computes the heat at each vertex, per area, after the time `time` when it was all at the vertex
 * `source` at first: `heat`, n elements, written. The rest as in cata_descriptor_heat. */
cata_status cata_descriptor_heat_kernel(int32_t layout, size_t n, size_t k,
    const double *eigenvalues, const double *eigenvectors, size_t ldv, uint32_t source, double time,
    double *heat);

/** Computes wave kernel signatures (Aubry, Schlickewei and Cremers 2011): for each vertex and
 * energy the mean of the squares of eigenfunctions there, with weights that fall with the distance
 * of the logarithm of the eigenvalue from the energy.
 * - `count`, `energies`: logarithms of eigenvalues; `sigma`: the width of the weights, positive:
 *   both usually of cata_descriptor_wave_scales.
 * - `signature`: n x count, written, in units of 1 / area. The rest as in cata_descriptor_heat. */
cata_status cata_descriptor_wave(int32_t layout, size_t n, size_t k, const double *eigenvalues,
    const double *eigenvectors, size_t ldv, size_t count, const double *energies, double sigma,
    double *signature, size_t ldsignature, const cata_descriptor_params *params);

/** Computes energies and their width for cata_descriptor_wave, at equal distances. `energies`:
 * `count` elements, written, ascending; `sigma`: written. */
cata_status cata_descriptor_wave_scales(size_t k, const double *eigenvalues, size_t count,
    double *energies, double *sigma);

/** Computes global point signatures (Rustamov 2007): eigenfunctions divided by the root of their
 * eigenvalues, for those that are not 0. Signs are those of the eigenfunctions.
 * - `count`: written: the number of these eigenvalues.
 * - `signature`: n x k, written: n x count, and zeros. The rest as in cata_descriptor_heat. */
cata_status cata_descriptor_points(int32_t layout, size_t n, size_t k, const double *eigenvalues,
    const double *eigenvectors, size_t ldv, size_t *count, double *signature, size_t ldsignature);

/** Computes signatures of histograms of orientations, SHOT (Tombari, Salti and Di Stefano 2010):
 * the normals in the parts of a ball around each vertex. They stay the same when the mesh is moved
 * or, with the radius, scaled. Zeros where fewer than five other vertices are in the ball.
 * - `radius`: of the ball, in the unit of the mesh, positive.
 * - `signature`: n_vertices x CATA_SHOT_BINS, written: rows of norm 1. */
cata_status cata_descriptor_shot(size_t n_vertices, const double *vertices, size_t n_faces,
    const uint32_t *faces, double radius, int32_t layout, double *signature, size_t ldsignature,
    const cata_descriptor_params *params);

/** Computes means of functions over rings around each vertex, by distances along edges: a
 * descriptor that bending leaves the same.
 * - `radius`: of the outermost ring, in the unit of the mesh, positive; `rings`: at least 1.
 * - `count`, `f`: functions, n_vertices x count.
 * - `signature`: n_vertices x (rings (1 + count)), written: for each ring, from the middle, its
 *   share of the area of all, and the means of the functions. */
cata_status cata_descriptor_rings(size_t n_vertices, const double *vertices, size_t n_faces,
    const uint32_t *faces, double radius, size_t rings, int32_t layout, size_t count,
    const double *f, size_t ldf, double *signature, size_t ldsignature,
    const cata_descriptor_params *params);

/** @} */

/* ==== Spectral unions ======================================================================= */
/**
 * @defgroup unions Spectral unions
 * The spectrum of a union of parts from those of the parts, by a network (thesis, chapter 2).
 * @code{.c}
 * double parts[2 * CATA_UNION_EIGENVALUES], found[CATA_UNION_EIGENVALUES];
 * for (int i = 0; i < 2 * CATA_UNION_EIGENVALUES; i++) parts[i] = 12.0 * (1 + i % 20);
 * cata_unions *unions;
 * cata_unions_new(NULL, &unions);
 * cata_unions_predict(unions, 2, parts, found, NULL);
 * cata_unions_free(unions);
 * @endcode
 * @{
 */

#define CATA_UNION_EIGENVALUES 20 /**< Eigenvalues of a spectrum of cata_unions_predict. */

/** The spectral union operator: a network with its weights. */
typedef struct cata_unions cata_unions;

/** Threads and progress of cata_unions_locate. */
typedef struct cata_unions_params {
    size_t struct_size; /**< sizeof(cata_unions_params). */
    size_t threads; /**< Threads, at most; 0: all. */
    cata_progress progress; /**< Progress callback; NULL: none. */
    void *progress_user; /**< Passed to `progress`. */
} cata_unions_params;

/** Creates the network that predicts spectra of unions.
 *
 * `weights`: a file of `catamaran unions train`, NUL-terminated; NULL: the weights that come
 * with the library. CATA_ERR_IO when something is wrong with the file. */
cata_status cata_unions_new(const char *weights, cata_unions **unions);

void cata_unions_free(cata_unions *unions); /**< Frees a network. */

/** Predicts the first eigenvalues of the union of parts of a surface, from those of the parts:
 * Dirichlet spectra, in whatever unit.
 * - `parts`: their number, at least 1.
 * - `spectra`: CATA_UNION_EIGENVALUES elements for each part, ascending and positive, one part
 *   after the other.
 * - `spectrum`: CATA_UNION_EIGENVALUES elements, written: ascending, positive, none larger than
 *   that of a part of the same number. The order of the parts does not matter, bit for bit.
 * - `ood_score`: written: how unlike the parts are to those of the training; above 1 they are
 *   further out than 99.5 % of its pairs, and the prediction is a guess. Below 1 the prediction
 *   may be wrong, too. NULL where not wanted. */
cata_status cata_unions_predict(const cata_unions *unions, size_t parts, const double *spectra,
    double *spectrum, double *ood_score);
/** Fills a struct with the defaults. */
cata_status cata_unions_params_init(cata_unions_params *params, size_t struct_size);

/** Finds where the union of parts is on the template of the network, the mesh that
 * `catamaran unions template` writes; CATA_ERR_SHAPE and CATA_ERR_ARGUMENT for another mesh. Each
 * call computes the eigenfunctions of the template.
 * - `parts`, `spectra`: as those of cata_unions_predict.
 * - `indicator`: n_vertices elements, written: about 1 inside of the union and 0 outside; the
 *   union is what is above 1/2. Mirror images have the same spectrum: it is one of the two. */
cata_status cata_unions_locate(const cata_unions *unions, size_t parts, const double *spectra,
    size_t n_vertices, const double *vertices, size_t n_faces, const uint32_t *faces,
    double *indicator, const cata_unions_params *params);

/** Computes a spectrum between two: (1 - t) first + t second.
 *
 * `first`, `second`, `spectrum`: CATA_UNION_EIGENVALUES elements each, the first two ascending
 * and positive, the last written; it may be one of the others. `t`: in [0, 1]. */
cata_status cata_unions_interpolate(const double *first, const double *second, double t,
    double *spectrum);

/** @} */

/* ==== Plants ================================================================================ */
/**
 * @defgroup plants Plants
 * Plants that lose water and wilt (thesis, chapter 4): the water in their nodes, the stiffness
 * that follows from it, and the pose of rods with that stiffness and weight. SI units.
 * @code{.c}
 * cata_plant *plant;
 * if (cata_plant_grow(100, 1, NULL, &plant) == CATA_OK) {
 *     double day = 86400, water[100];
 *     if (cata_plant_water_curve(plant, 100, NULL, 1, &day, 0, NULL, water) == CATA_OK) {
 *         printf("%g kg in node 0 after a day\n", water[0]);
 *     }
 *     cata_plant_free(plant);
 * }
 * @endcode
 * @{
 */

#define CATA_NO_PARENT UINT32_MAX /**< The parent of the root of a plant. */
#define CATA_PLANT_STEM 0 /**< A kind of segments: stem. */
#define CATA_PLANT_LEAF 1 /**< A kind of segments: a vein of a leaf, which loses water. */
#define CATA_PLANT_PINNED 2 /**< Added to a kind: the segment is held where it is. */

/** The water in a plant: its constants, the current state, and the data of the time steps. */
typedef struct cata_plant cata_plant;

/** The constants of the water and the stiffness of a plant. */
typedef struct cata_plant_params {
    size_t struct_size; /**< sizeof(cata_plant_params). */
    size_t threads; /**< Threads, at most; 0: all. */
    cata_progress progress; /**< Progress callback. */
    void *progress_user; /**< Passed to `progress`. */
    double loss; /**< Loss of leaves, in kg / (s m^2); 60 g / (h m^2) is 1.667e-5. */
    double intake; /**< Water that the root takes from the soil, in kg / s. */
    /** Conductance of a segment, as a part of that of a pipe as wide; 0: 1e-9. */
    double conductance;
    double modulus; /**< Pressure in full cells, in Pa; 0: 1e6. */
    double viscosity; /**< Viscosity of the sap, in Pa s; 0: 1e-3. */
    double density; /**< Water in a cubic metre of full tissue, in kg; 0: 1000. */
    double elasticity_full; /**< Modulus of elasticity of full cells, in Pa; 0: 5e7. */
    double elasticity_dry; /**< Modulus of dry cells, in Pa (literal: must be 0); 0: 3e5. */
    double elasticity_steepness; /**< Steepness of the curve (literal: in 1/g); 0: 10. */
    /** Relative water content at the steepest point (literal: in grams, default 0); 0: 0.75. */
    double elasticity_shift;
    /** 1: full / (1 + exp(-steepness (g - shift))), g grams of water (thesis, equation 4.9). */
    int32_t elasticity_literal;
} cata_plant_params;
/** Fills a struct with the defaults. */
cata_status cata_plant_params_init(cata_plant_params *params, size_t struct_size);

/** Creates a plant of n >= 1 segments, each named after the node at its end.
 * - `tails`: 3 n elements: x, y, z of the end of each.
 * - `radii`: n elements, positive.
 * - `parents`: n elements: the segment at whose end each begins; CATA_NO_PARENT for the root.
 * - `kinds`: n elements: CATA_PLANT_STEM or CATA_PLANT_LEAF, each also + CATA_PLANT_PINNED.
 * - `base`: 3 elements: where the root begins; NULL: it is as long as its first child, and
 *   goes straight on into it.
 *
 * Returns CATA_ERR_MESH for a node without positive radius or length, or that is not on one
 * tree with one root. */
cata_status cata_plant_new(size_t n, const double *tails, const double *radii,
    const uint32_t *parents, const int32_t *kinds, const double *base,
    const cata_plant_params *params, cata_plant **plant);

/** Reads the plant in a file: .txt (the reference format: `verts N`, ...), .swc, .mtg or .obj
 * (polylines), each also as .gz, .xz or .bz2. `path` is in UTF-8. */
cata_status cata_plant_read(const char *path, const cata_plant_params *params, cata_plant **plant);

/** Reads the plant in a file as cata_plant_read does, in the units of the file.
 * - `unit`: 2 numbers: metres in a unit of lengths, and in one of radii; NULL: 1 and 1.
 * - `individual`: the name of one of several plants in an .mtg file, such as P3, in UTF-8;
 *   NULL or an empty text: the file has one plant. The error without a name lists the names. */
cata_status cata_plant_read_with(const char *path, const double *unit, const char *individual,
    const cata_plant_params *params, cata_plant **plant);

/** Grows a random plant of n >= 1 nodes, the same for the same seed. */
cata_status cata_plant_grow(size_t n, uint64_t seed, const cata_plant_params *params,
    cata_plant **plant);

void cata_plant_free(cata_plant *plant); /**< Frees a plant. */

/** Returns the number of nodes of a plant, n in all calls below; 0 for NULL. */
size_t cata_plant_size(const cata_plant *plant);

/** Gets the segments of a plant, as cata_plant_new takes them; NULL for what is not wanted. */
cata_status cata_plant_segments(const cata_plant *plant, size_t n, double *tails, double *radii,
    uint32_t *parents, int32_t *kinds, double *base);

/** Gets the water of every node when its cells are full, in kg: the state of a healthy plant. */
cata_status cata_plant_full_water(const cata_plant *plant, size_t n, double *water);

/** Sets the loss of all leaves, in kg / (s m^2), from now on. */
cata_status cata_plant_set_loss(cata_plant *plant, double loss);

/** Sets the water that the root takes from the soil, in kg / s, from now on. */
cata_status cata_plant_set_intake(cata_plant *plant, double intake);

/** Multiplies the conductance between a node, not the root, and its parent by `factor`, from
 * now on; 0 cuts the connection. */
cata_status cata_plant_weaken(cata_plant *plant, size_t node, double factor);

/** Computes the rates at which the modes of the water decay, n elements, ascending, in 1 / s.
 * Dense, of order n^3: for small plants. */
cata_status cata_plant_rates(const cata_plant *plant, size_t n, double *rates);

/** Computes the water of every node `seconds` after it was `water`, without time steps. `water`,
 * `result` (written): n elements in kg each, which may be the same. */
cata_status cata_plant_water_after(const cata_plant *plant, size_t n, const double *water,
    double seconds, double *result);

/** Computes the water of every node at many times.
 * - `water`: n elements: in kg, at time 0; NULL: full cells.
 * - `times`: n_times elements: seconds from 0, ascending.
 * - `intervals`: 2 n_intervals elements: seconds and loss of each part of a day, again and
 *   again from time 0 on. Without any the loss is that of the plant.
 * - `result`: n_times x n elements, written: in kg. */
cata_status cata_plant_water_curve(const cata_plant *plant, size_t n, const double *water,
    size_t n_times, const double *times, size_t n_intervals, const double *intervals,
    double *result);

/** Makes `water`, n elements in kg, the current state, from which cata_plant_step continues in
 * steps of `step` seconds; NULL: full cells. */
cata_status cata_plant_start(cata_plant *plant, size_t n, const double *water, double step);

/** Computes `count` steps; changes since the last step apply from now on. `water`: n elements,
 * written: in kg; NULL: not wanted. Steps before a cancelled one are done. */
cata_status cata_plant_step(cata_plant *plant, size_t count, size_t n, double *water);

/** Computes the modulus of elasticity of every segment, in Pa, from its water, in kg: a logistic
 * curve from `elasticity_dry` to `elasticity_full`. */
cata_status cata_plant_stiffness(const cata_plant *plant, size_t n, const double *water,
    double *moduli);

/** A plant whose segments have weight and whose joints have stiffness, in a pose. */
typedef struct cata_plant_rods cata_plant_rods;

/** The constants of rods. */
typedef struct cata_plant_rods_params {
    size_t struct_size; /**< sizeof(cata_plant_rods_params). */
    size_t threads; /**< Threads, at most; rods take one. */
    cata_progress progress; /**< Progress callback. */
    void *progress_user; /**< Passed to `progress`. */
    double gravity[3]; /**< In m / s^2; all 0: 0, 0, -9.81. */
    double poisson; /**< Poisson's ratio, above -1 and at most 0.5; 0: 0.3. */
    double dry_density; /**< Mass of a cubic metre of tissue without its water, in kg; 0: 100. */
    /** For cata_plant_rods_relax: torque out of balance / the largest of a weight; 0: 1e-8. */
    double tolerance;
    size_t iterations; /**< Most iterations of cata_plant_rods_relax; 0: 200. */
    double step; /**< Seconds of a step of cata_plant_rods_step; 0: 1 / 60. */
    size_t step_iterations; /**< Iterations of cata_plant_rods_step; 0: 3. */
    double damping; /**< The rate at which velocities decay, in 1 / s; 0: 1. */
} cata_plant_rods_params;
/** Fills a struct with the defaults. */
cata_status cata_plant_rods_params_init(cata_plant_rods_params *params, size_t struct_size);

/** Creates the rods of a plant with full cells, in the pose as given. They may outlive it. */
cata_status cata_plant_rods_new(const cata_plant *plant, const cata_plant_rods_params *params,
    cata_plant_rods **rods);

void cata_plant_rods_free(cata_plant_rods *rods); /**< Frees rods. */

/** Sets the modulus of elasticity of every segment, in Pa, and its water, in kg, n elements
 * each. Pose and velocities stay. */
cata_status cata_plant_rods_set_state(cata_plant_rods *rods, size_t n, const double *moduli,
    const double *water);

/** Sets the pose, at rest. `rotations`: 4 n elements: how each segment has turned since the
 * plant was given, a quaternion (w, x, y, z); NULL: not at all. */
cata_status cata_plant_rods_set_pose(cata_plant_rods *rods, size_t n, const double *rotations);

/** Gets the pose: `heads` and `tails`, 3 n elements each, where segments begin and end, and 4 n of
 * `rotations`, as in cata_plant_rods_set_pose; NULL where not wanted. */
cata_status cata_plant_rods_pose(const cata_plant_rods *rods, size_t n, double *heads,
    double *tails, double *rotations);

/** Moves the pose to one near it in which stiffness and weight are in balance, at rest.
 * `iterations`, `residual`: written: those taken, and what is left, as `tolerance` measures it;
 * NULL where not wanted. After an error the pose is that of the last iteration. */
cata_status cata_plant_rods_relax(cata_plant_rods *rods, size_t *iterations, double *residual);

/** Lets the plant move for `count` steps. `gap`: written: the largest between a segment and its
 * parent, in metres; NULL: not wanted. Steps before a cancelled one are done. */
cata_status cata_plant_rods_step(cata_plant_rods *rods, size_t count, double *gap);

/** Gets the pose as a mesh of tubes of `sides` >= 3 sides and radii of at least `thinnest` metres.
 * Segment v has the vertices from 2 v `sides` on, and the faces. `vertices`, `faces`: 6 n `sides`
 * elements each, written; NULL where not wanted. */
cata_status cata_plant_rods_tubes(const cata_plant_rods *rods, size_t n, size_t sides,
    double thinnest, double *vertices, uint32_t *faces);

/** Lets a plant wilt: from full cells on cata_plant_water_curve, and at each time the pose in
 * which it then rests.
 * - `rods`: of this plant, for their constants; NULL: the defaults.
 * - `water`, `moduli`, `tails`, `rotations`: n_times x n, n, 3 n and 4 n elements, written, as
 *   in the calls above; NULL where not wanted. */
cata_status cata_plant_wilt(const cata_plant *plant, const cata_plant_rods *rods, size_t n_times,
    const double *times, size_t n_intervals, const double *intervals, size_t n, double *water,
    double *moduli, double *tails, double *rotations);

/** @} */

/* ==== Slime moulds ========================================================================== */
/**
 * @defgroup slime Slime moulds
 * Agents on a surface that leave trails in its texture (thesis, chapter 3). Textures are size
 * x size texels, rows along u, the first at v = 0.
 * @code{.c}
 * double square[12] = {0, 0, 0, 1, 0, 0, 1, 1, 0, 0, 1, 0}, coverage = 0;
 * uint32_t faces[6] = {0, 1, 2, 0, 2, 3};
 * cata_slime_params params = {.struct_size = sizeof params, .agents = 1000, .size = 64};
 * cata_slime *slime;
 * if (cata_slime_new(4, square, 2, faces, NULL, NULL, NULL, &params, &slime) == CATA_OK) {
 *     cata_slime_step(slime, 30);
 *     cata_slime_coverage(slime, 0, &coverage, NULL);
 *     cata_slime_free(slime);
 * }
 * @endcode
 * @{
 */

#define CATA_SLIME_TURNS_RANDOM 0 /**< `turns`: at random, up to the turn speed. */
#define CATA_SLIME_TURNS_EVEN 1 /**< `turns`: always at the turn speed. */
#define CATA_SLIME_BLUR_SURFACE 0 /**< `blur`: over the surface, across seams. */
#define CATA_SLIME_BLUR_TEXTURE 1 /**< `blur`: of the texture alone. */
#define CATA_SLIME_LENGTHS_SURFACE 0 /**< `lengths`: those of the surface. */
#define CATA_SLIME_LENGTHS_TEXTURE 1 /**< `lengths`: those of the texture, of side 1. */
#define CATA_SLIME_SIZE 2048 /**< `size`, where it is 0. */

/** Slime moulds on a surface. */
typedef struct cata_slime cata_slime;

/** Properties of slime moulds (thesis, table 3.1; docs/algorithms/slime.md). Lengths are in
 * hundredths of the square root of the area of the surface, times in seconds. */
typedef struct cata_slime_params {
    size_t struct_size; /**< sizeof(cata_slime_params). */
    size_t threads; /**< Threads, at most; 0: all. */
    cata_progress progress; /**< Progress callback, called after each step. */
    void *progress_user; /**< Passed to `progress`. */
    size_t agents; /**< Number of agents, below 2^32; 0: 1,000,000. */
    size_t species; /**< Number of species, from 1 to 15; 0: 1. */
    size_t size; /**< Texels of a side of the texture, a multiple of 32, at most 16384; 0: 2048. */
    /** An OpenCL device (see Devices), which keeps agents and textures between calls; NULL: the
     * processor. The bytes are the same where devices round as processors do. */
    const char *device;
    uint32_t seed; /**< Seed of all random numbers. */
    /** 0: steps that are exact; else the number of sub-steps that are projected (thesis,
     * algorithm 3.1). */
    uint32_t substeps;
    double time_step; /**< Seconds of a step; 0: 1 / 30. */
    double movement_speed; /**< Hundredths a second, such as 1 to 2; 0: 1.5. */
    double turn_speed; /**< Degrees a second; 0: 1800. */
    /** Distance from an agent to its sensors, in hundredths, such as 0.4 to 2; 0: 1. */
    double vision_distance;
    double vision_angle; /**< Angle between sensors, in degrees, such as 10 to 50; 0: 30. */
    /** Pheromone that evaporates in a second, where an agent leaves 1, such as 0.2 to 1; 0: 0.4. */
    double evaporation_rate;
    double diffusion_rate; /**< Blurs a second; 0: 6. */
    int32_t turns; /**< One of CATA_SLIME_TURNS_*. */
    int32_t blur; /**< One of CATA_SLIME_BLUR_*. */
    int32_t lengths; /**< One of CATA_SLIME_LENGTHS_*. */
} cata_slime_params;
/** Fills a struct with the defaults. */
cata_status cata_slime_params_init(cata_slime_params *params, size_t struct_size);

/** Creates a simulation: agents spread over a surface, and a texture without pheromone.
 * - `uv`: 6 n_faces elements: u, v of the three corners of each face, from 0 to 1; NULL: every
 *   triangle gets a place of its own in the texture, which cata_slime_uv gives.
 * - `start`: a texture: not 0 where agents start; NULL: anywhere.
 * - `ground`: a texture: 0 free, 1 obstacle, 2 attractor; NULL: all free.
 *
 * Returns CATA_ERR_MESH for an edge of three faces or more, and for a face without area, in
 * space or in the texture; CATA_ERR_BACKEND when the device refuses. */
cata_status cata_slime_new(size_t n_vertices, const double *vertices, size_t n_faces,
    const uint32_t *faces, const double *uv, const uint8_t *start, const uint8_t *ground,
    const cata_slime_params *params, cata_slime **slime);

void cata_slime_free(cata_slime *slime); /**< Frees a simulation. */

/** Computes `steps` steps. Those before a cancelled one are done. */
cata_status cata_slime_step(cata_slime *slime, uint32_t steps);

/** Gets the texels of a side of a texture, species, triangles, and steps that are done; NULL where
 * not wanted. */
cata_status cata_slime_size(const cata_slime *slime, size_t *size, size_t *species, size_t *faces,
    uint32_t *steps);

/** Gets the texture of a species (from 0) as it is now: pheromone, from 0 to 1. */
cata_status cata_slime_texture(const cata_slime *slime, size_t species, float *texture);

/** Computes how much of the surface a species covers (thesis, equation 3.2): the mean of its
 * pheromone, and the part of the surface that has any; NULL where not wanted. */
cata_status cata_slime_coverage(const cata_slime *slime, size_t species, double *coverage,
    double *presence);

/** Gets the texture coordinates of the corners of faces, as cata_slime_new takes them. */
cata_status cata_slime_uv(const cata_slime *slime, double *uv);

/** @} */

/* ==== Newton fractals ======================================================================= */
/**
 * @defgroup newton Newton fractals
 * Bicomplex fractals, evaluated anywhere in space (thesis, chapter 7).
 * @code{.c}
 * cata_newton *newton;
 * uint16_t roots[16 * 16];
 * float convergence[16 * 16];
 * if (cata_newton_new(NULL, &newton) == CATA_OK) {
 *     cata_newton_plane(newton, 16, 16, 0, 0, 3, roots, convergence);
 *     cata_newton_free(newton);
 * }
 * @endcode
 * @{
 */

#define CATA_NEWTON_THESIS 0 /**< Equation 7.3: from -1 (at a root) to the iterations. */
#define CATA_NEWTON_SHADER 1 /**< That of the thesis authors' shader: from 0 to 1. */

/** A Newton fractal, which is evaluated at points. */
typedef struct cata_newton cata_newton;

/** The polynomial of a Newton fractal, and how it is evaluated. */
typedef struct cata_newton_params {
    size_t struct_size; /**< sizeof(cata_newton_params). */
    size_t threads; /**< Threads, at most; 0: all. */
    cata_progress progress; /**< Progress callback. */
    void *progress_user; /**< Passed to `progress`. */
    size_t root_count; /**< Roots of the polynomial, at most 64; 0: it is z^`power` - 1. */
    /** 2 `root_count` elements: real and imaginary part of each root, within 1e4 of 0. */
    const double *roots;
    const char *device; /**< An OpenCL device (see Devices); NULL: the processor. */
    double scale; /**< Factor of points after `offset` and `w` are added; 0: 1. */
    double theta; /**< The theta of the gradient, from -10 to 20; 0: 3.5. */
    double w; /**< The fourth coordinate of all points, which cata_newton_set_w changes. */
    double offset[3]; /**< Added to x, y and z of each point. */
    uint32_t power; /**< With `root_count` 0: from 2 to 64; 0: 3. */
    uint32_t iterations; /**< Iterations, at most 1000; 0: 32. */
    int32_t gradient; /**< CATA_NEWTON_THESIS or CATA_NEWTON_SHADER. */
} cata_newton_params;
/** Fills a struct with the defaults. */
cata_status cata_newton_params_init(cata_newton_params *params, size_t struct_size);

/** Creates a Newton fractal in four dimensions (bicomplex numbers; thesis, chapter 7). A polynomial
 * with n roots has n^2 here, numbered `a n + b`; those of z^n - 1 are exp(2 pi i a / n) and exp(2
 * pi i b / n). */
cata_status cata_newton_new(const cata_newton_params *params, cata_newton **newton);

void cata_newton_free(cata_newton *newton); /**< Frees a fractal. */

/** Changes the fourth coordinate of all points. */
cata_status cata_newton_set_w(cata_newton *newton, double w);

/** Computes the fractal at points in space, such as the vertices of a mesh.
 * - `positions`: 3 `count` elements: x, y, z of less than 2^31 points, within 1e9 of 0.
 * - `roots`: `count` elements, written: the number of the root that each point converges to.
 * - `convergence`: `count` elements, written: how slowly. */
cata_status cata_newton_points(const cata_newton *newton, size_t count, const float *positions,
    uint16_t *roots, float *convergence);

/** Computes the fractal on the plane z = 0: at the centres of the pixels of a picture `extent`
 * wide, at most 65,536 a side and less than 2^31 in all, rows from the top (large y). */
cata_status cata_newton_plane(const cata_newton *newton, uint32_t width, uint32_t height,
    double center_x, double center_y, double extent, uint16_t *roots, float *convergence);

/** Computes colours of points: each root has its own, darker the slower a point converges.
 * `colors`: 3 `count` elements, written: red, green and blue of each (sRGB). */
cata_status cata_newton_colors(const cata_newton *newton, size_t count, const uint16_t *roots,
    const float *convergence, uint8_t *colors);

/** @} */

/* ==== Devices =============================================================================== */
/**
 * @defgroup devices Devices
 * OpenCL devices, where the library has CATA_CAP_OPENCL. `device` of parameters is a number,
 * or a part of a name; "" is the first GPU, or else the first device.
 * @code{.c}
 * char name[256];
 * size_t count = 0;
 * cata_device_count(&count);
 * for (size_t i = 0; i < count && cata_device_name(i, sizeof name, name) == CATA_OK; i++) {
 *     printf("%s\n", name);
 * }
 * @endcode
 * @{
 */

#define CATA_DEVICE_CPU 0 /**< A kind of devices: the processor of this machine. */
#define CATA_DEVICE_GPU 1 /**< A kind of devices: a graphics card. */
#define CATA_DEVICE_OTHER 2 /**< A kind of devices: anything else. */

/** Gets the number of devices, at least 1. CATA_ERR_BACKEND: the message says what is missing. */
cata_status cata_device_count(size_t *count);

/** Gets the name of the device `index` (from 0): `size` elements of `name`, cut to fit, and NUL. */
cata_status cata_device_name(size_t index, size_t size, char *name);

/** Gets the kind of the device `index` (from 0): one of CATA_DEVICE_*. */
cata_status cata_device_kind(size_t index, int32_t *kind);

/** @} */

/* ==== MPI =================================================================================== */
/**
 * @defgroup mpi MPI
 * Products, least squares, eigenpairs and orthonormal columns of matrices that are spread over
 * the ranks of a communicator. Functions are collective unless they say Local, and take one
 * call at a time for a world.
 * @code{.c}
 * double rows[] = {1, 2, 3, 4}; // two on each rank
 * cata_world *world;
 * cata_symmetric *c;
 * cata_world_from_comm(MPI_COMM_WORLD, &world);
 * cata_world_ata_rows_f64(world, CATA_ROW_MAJOR, 2, 2, 1, rows, 2, NULL, &c);
 * cata_symmetric_free(c);
 * cata_world_free(world);
 * @endcode
 * @{
 */

#define CATA_BY_ROWS 141 /**< `spread`: every rank has rows of A, in any order and number. */
#define CATA_BY_COLUMNS 142 /**< `spread`: every rank has columns of A, in order. */

/** A symmetric matrix, float or double, whose lower triangle is spread over the ranks of a
 * world. */
typedef struct cata_symmetric cata_symmetric;

/** The ranks of an MPI communicator that work together; it has a communicator of its own.
 *
 * The library never initializes or finalizes MPI. MPI is called by the thread that calls; other
 * threads compute, so that MPI_THREAD_FUNNELED is needed (MPI_Init_thread).
 *
 * Collective functions are called by all ranks of the world, in the same order and with the same
 * numbers unless said otherwise; `params` may differ in `threads` and progress. If one rank fails,
 * every rank returns an error: its own there, CATA_ERR_RANK on the others, with a message that
 * names the rank, except for a world that is NULL. A panic aborts the job (MPI_Abort); so does, by
 * default, an error of MPI itself. */
typedef struct cata_world cata_world;

/** What a rank has sent and received: words are matrix entries. The few numbers by which ranks
 * agree on shapes and errors are not counted. */
typedef struct cata_traffic {
    size_t struct_size; /**< sizeof(cata_traffic). */
    uint64_t words_sent; /**< Entries sent. */
    uint64_t words_received; /**< Entries received. */
    uint64_t messages_sent; /**< Messages sent. */
    uint64_t messages_received; /**< Messages received. */
} cata_traffic;

/** Creates the world of the ranks of an MPI communicator, of which a duplicate is made. Collective
 * over it. CATA_ERR_ARGUMENT before MPI_Init and after MPI_Finalize.
 *
 * `fortran_comm`: MPI_Comm_c2f of the communicator; catamaran_mpi.h has cata_world_from_comm,
 * which takes the communicator itself. */
cata_status cata_world_new(int32_t fortran_comm, cata_world **world);

/** Frees a world. Collective; after MPI_Finalize local, and leaves the communicator to MPI. */
void cata_world_free(cata_world *world);

/** Gets the rank of the caller, from 0. Local. */
cata_status cata_world_rank(const cata_world *world, size_t *rank);

/** Gets the number of ranks, at least 1. Local. */
cata_status cata_world_size(const cata_world *world, size_t *size);

/** Gets what this rank has sent and received since the world was made. Local. The struct_size of
 * `traffic` is read. */
cata_status cata_world_traffic(const cata_world *world, cata_traffic *traffic);

/** Sets the entries of a message above which it is cut in several, 1 to 2^30; 2^30 in a new
 * world. Local, but all ranks must set the same before the next collective call. */
cata_status cata_world_set_longest_message(const cata_world *world, size_t entries);

/** Computes C = alpha A^T A where every rank has some rows of A, in any order and number; C is left
 * spread over the ranks. Collective. The result depends, by rounding, on the number of ranks and
 * on which rank has which rows.
 * - `layout`, `m`, `a`: of the rows of this rank, m x n, its own on each rank.
 * - `n`, `alpha`: the same on all ranks. */
cata_status cata_world_ata_rows_f64(const cata_world *world, int32_t layout, size_t m, size_t n,
    double alpha, const double *a, size_t lda, const cata_ata_params *params, cata_symmetric **c);

/** Computes cata_world_ata_rows_f64 in float. */
cata_status cata_world_ata_rows_f32(const cata_world *world, int32_t layout, size_t m, size_t n,
    float alpha, const float *a, size_t lda, const cata_ata_params *params, cata_symmetric **c);

/** Solves least squares where every rank has some rows of A, of B and of the weights, in any order
 * and number; every rank gets the whole of X and of the result. Collective. The result does not
 * depend on the number of ranks, nor on which rank has which rows, bit for bit.
 * - `layout`, `m`, `a`, `b`, `weights`: of the rows of this rank, as in cata_lstsq; `weights`
 *   is NULL on all ranks or on none.
 * - `x`, `result`: as in cata_lstsq; what is wanted may differ between the ranks.
 * - `params`: progress is that of the second pass over the rows of this rank. */
cata_status cata_world_lstsq(const cata_world *world, int32_t layout, size_t m, size_t n, size_t k,
    const double *a, size_t lda, const double *b, size_t ldb, const double *weights, double *x,
    size_t ldx, cata_lstsq_result *result, const cata_lstsq_params *params);

/** Computes C = alpha A^T A where every rank has some columns of A (m x cols), in the order of the
 * ranks, as cata_world_ata_rows_f64. Cheaper than that where A is not much longer than wide. */
cata_status cata_world_ata_columns(const cata_world *world, int32_t layout, size_t m, size_t cols,
    double alpha, const double *a, size_t lda, const cata_ata_params *params, cata_symmetric **c);

/** Computes C := alpha A^T A + beta C where the rank `root` has A, m x n, and C, n x n: by AtA-D,
 * or by distributing rows of A, whichever should be faster. Collective. The result depends, by
 * rounding, on the number of ranks. C is untouched after an error in arguments, unspecified in its
 * wanted part after any other.
 * - `alpha`: the same on all ranks.
 * - `layout` to `lda`, `beta` to `ldc`: on the root as in cata_ata_f64; ignored on other ranks. */
cata_status cata_world_ata_root(const cata_world *world, size_t root, int32_t layout, int32_t uplo,
    size_t m, size_t n, double alpha, const double *a, size_t lda, double beta, double *c,
    size_t ldc, const cata_ata_params *params);

/** Computes C := alpha A^T A + beta C for block-cyclic A, m x n, and C, n x n, as ScaLAPACK has
 * them; what PDSYRK does with TRANS = 'T' to whole matrices. Collective. A copy of A is
 * redistributed; the rounding depends on the number of ranks and on the layout of A.
 * - `uplo`, `alpha`, `beta`: as in cata_ata_f64; with CATA_BOTH and beta != 0 C must be
 *   symmetric.
 * - `a`: A's entries on this rank: column-major, with leading dimension LLD_ of `desc_a`.
 * - `desc_a`: 9 numbers: DTYPE_ (1), CTXT_ (ignored), M_ >= 0, N_ >= 0, MB_ >= 1, NB_ >= 1,
 *   RSRC_, CSRC_ (from 0, a row and a column of the grid), LLD_ (at least 1 and the rows on
 *   this rank; ignored outside of the grid). The same on all ranks but for CTXT_ and LLD_.
 * - `c`, `desc_c`: C likewise, written; M_ and N_ are A's N_, the blocks any.
 * - `grid_rows`, `grid_cols`: the process grid, of the first ranks, at least 1 x 1.
 * - `grid_order`: CATA_ROW_MAJOR when ranks are numbered along the rows of the grid, as by
 *   Cblacs_gridinit with "R", or CATA_COL_MAJOR, along its columns. */
cata_status cata_world_ata_cyclic(const cata_world *world, int32_t uplo, double alpha,
    const double *a, const int32_t *desc_a, double beta, double *c, const int32_t *desc_c,
    size_t grid_rows, size_t grid_cols, int32_t grid_order, const cata_ata_params *params);

/** Computes C := alpha A A^T + beta C as cata_world_ata_cyclic, m x m; PDSYRK with TRANS = 'N'. M_
 * and N_ of `desc_c` are A's M_. */
cata_status cata_world_aat_cyclic(const cata_world *world, int32_t uplo, double alpha,
    const double *a, const int32_t *desc_a, double beta, double *c, const int32_t *desc_c,
    size_t grid_rows, size_t grid_cols, int32_t grid_order, const cata_ata_params *params);

/** Computes eigenpairs as those of cata_eigs where every rank has some rows of W, in the order of
 * the ranks. Collective. Every rank gets all eigenvalues and residuals and its rows of the
 * eigenvectors. The basis, most of the memory, is spread; W and its factor are on every rank.
 * - `own`: rows of this rank, its own on each rank; `n`: all rows.
 * - `row_starts`, `columns`, `entries`, `masses`: of these rows, columns from 0 to n - 1.
 * - `eigenvectors`: own x k, written, column-major. */
cata_status cata_world_eigs(const cata_world *world, size_t own, size_t n, const size_t *row_starts,
    const size_t *columns, const double *entries, const double *masses, size_t k,
    double *eigenvalues, double *eigenvectors, size_t ldv, double *residuals,
    const cata_eigs_params *params);

/** Computes cata_ortho_gram_schmidt where every rank has some rows of A and masses, in the order of
 * the ranks: `own` of this rank. Collective. Every rank gets its rows of Q and all of `r`, which
 * is c x c, `kept` and `rank`; A is unspecified after errors. CATA_ORTHO_RANK_REVEALING is
 * CATA_ERR_UNSUPPORTED. */
cata_status cata_world_gram_schmidt(const cata_world *world, int32_t layout, size_t own, size_t c,
    double *a, size_t lda, const double *masses, double *r, size_t ldr, size_t *kept, size_t *rank,
    const cata_ortho_params *params);

/** Computes cata_ortho_cholesky_qr for rows that are distributed in the same way. */
cata_status cata_world_cholesky_qr(const cata_world *world, int32_t layout, size_t own, size_t c,
    double *a, size_t lda, const double *masses, double *r, size_t ldr,
    const cata_ortho_params *params);

/** Gets the number of rows and columns of a distributed matrix. Local. */
cata_status cata_symmetric_n(const cata_symmetric *symmetric, size_t *n);

/** Frees the part of a distributed matrix that this rank holds. Local. */
void cata_symmetric_free(cata_symmetric *symmetric);

/** Puts the whole of a distributed matrix of doubles, made by all ranks of `world`, into C, n x
 * n, on the rank `root`, as cata_ata_f64 does; other ranks' `layout` to `ldc` are ignored.
 * Collective. */
cata_status cata_symmetric_gather_f64(const cata_symmetric *symmetric, const cata_world *world,
    size_t root, int32_t layout, int32_t uplo, double *c, size_t ldc);

/** Gathers a matrix of floats as cata_symmetric_gather_f64. */
cata_status cata_symmetric_gather_f32(const cata_symmetric *symmetric, const cata_world *world,
    size_t root, int32_t layout, int32_t uplo, float *c, size_t ldc);

/** Checks that a distributed matrix of doubles, made by all ranks of `world`, is alpha A^T A, up
 * to rounding, as cata_verify_f64 does. Collective; all ranks get the same answer.
 * - `spread`: CATA_BY_ROWS or CATA_BY_COLUMNS: how A is spread.
 * - `layout`, `rows`, `cols`, `a`: of this rank's part of A. */
cata_status cata_symmetric_verify_f64(const cata_symmetric *symmetric, const cata_world *world,
    int32_t spread, int32_t layout, size_t rows, size_t cols, double alpha, const double *a,
    size_t lda, int32_t rounds, uint64_t seed, int32_t *passed, double *residual,
    double *tolerance);

/** Checks a product in float as cata_symmetric_verify_f64; the check itself is in double. */
cata_status cata_symmetric_verify_f32(const cata_symmetric *symmetric, const cata_world *world,
    int32_t spread, int32_t layout, size_t rows, size_t cols, double alpha, const float *a,
    size_t lda, int32_t rounds, uint64_t seed, int32_t *passed, double *residual,
    double *tolerance);

/** @} */

#ifdef __cplusplus
} // extern "C"
#endif // __cplusplus

#endif // CATAMARAN_H
