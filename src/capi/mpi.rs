// Without the feature the functions are there, and do nothing with what they get.
#![cfg_attr(not(feature = "mpi"), allow(unused_variables))]

use super::ata_params::cata_ata_params;
use super::boundary::boundary;
use super::lstsq::{cata_lstsq_params, cata_lstsq_result};
#[cfg(feature = "mpi")]
use super::ranks;
use super::status::cata_status;
#[cfg(not(feature = "mpi"))]
use super::status::{CATA_ERR_UNSUPPORTED, Failure};
use super::world::{cata_symmetric, cata_traffic, cata_world};

/// The call where the feature is there.
#[cfg(feature = "mpi")]
macro_rules! with_mpi {
    ($call:expr) => {
        boundary(|| {
            // SAFETY: the caller's promise.
            #[allow(unused_unsafe)]
            unsafe {
                $call
            }
        })
    };
}

#[cfg(not(feature = "mpi"))]
macro_rules! with_mpi {
    ($call:expr) => {
        boundary(|| Err(Failure::new(CATA_ERR_UNSUPPORTED, "built without the feature mpi")))
    };
}

/// The world of the ranks of an MPI communicator, of which a duplicate is made. Collective over
/// it. catamaran_mpi.h has cata_world_from_comm, which takes the communicator itself.
///
/// - `fortran_comm`: MPI_Comm_c2f of the communicator.
/// - `world`: one pointer, not NULL; written on success only. Free it by cata_world_free.
///
/// Returns CATA_ERR_ARGUMENT when MPI is not initialised or is finalised already, or for a handle
/// of no communicator.
///
/// Not thread-safe: MPI_Comm_dup is called.
///
/// # Safety
/// The pointer is as described.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn cata_world_new(
    fortran_comm: i32,
    world: *mut *mut cata_world,
) -> cata_status {
    with_mpi!(ranks::new(fortran_comm, world))
}

/// Gives a world back. Collective; after MPI_Finalize it is local, and leaves the communicator to
/// MPI.
///
/// `world`: made by cata_world_new and not yet freed; NULL does nothing.
///
/// Not thread-safe.
///
/// # Safety
/// The pointer is as described.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn cata_world_free(world: *mut cata_world) {
    with_mpi!(ranks::free(world));
}

/// The rank of the caller, from 0. Local.
///
/// `world`: not NULL. `rank`: one size_t, not NULL; written on success.
///
/// # Safety
/// The pointers are as described.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn cata_world_rank(
    world: *const cata_world,
    rank: *mut usize,
) -> cata_status {
    with_mpi!(ranks::number("rank", rank, ranks::world(world)?.rank()))
}

/// The number of ranks, at least 1. Local.
///
/// `world`: not NULL. `size`: one size_t, not NULL; written on success.
///
/// # Safety
/// The pointers are as described.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn cata_world_size(
    world: *const cata_world,
    size: *mut usize,
) -> cata_status {
    with_mpi!(ranks::number("size", size, ranks::world(world)?.size()))
}

/// What this rank has sent and received since the world was made. Local.
///
/// `world`: not NULL. `traffic`: one struct, not NULL, whose struct_size is set; the other fields
/// are written on success.
///
/// Not thread-safe.
///
/// # Safety
/// The pointers are as described: `traffic` has as many bytes as its `struct_size` says.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn cata_world_traffic(
    world: *const cata_world,
    traffic: *mut cata_traffic,
) -> cata_status {
    with_mpi!(ranks::traffic(world, traffic))
}

/// Sets the entries of a message above which it is cut in several; 2^30 in a new world. Local,
/// but all ranks must set the same before the next collective call.
///
/// `world`: not NULL. `entries`: any; taken as 1 if it is 0, and as 2^30 if it is more.
///
/// Not thread-safe.
///
/// # Safety
/// The pointer is as described.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn cata_world_set_longest_message(
    world: *const cata_world,
    entries: usize,
) -> cata_status {
    with_mpi!(ranks::set_longest_message(world, entries))
}

/// C = alpha A^T A where every rank has some rows of A, in any order and number, 0 included; C is
/// left spread over the ranks. Collective.
///
/// - `world`: not NULL.
/// - `layout`: of the rows of this rank; CATA_ROW_MAJOR or CATA_COL_MAJOR, its own on each rank.
/// - `m`: rows of this rank, its own on each rank.
/// - `n`: columns of A.
/// - `a`: the rows of this rank, read. Row-major: m lines of `lda` >= max(1, n) elements, the
///   last one of n. Column-major: n lines of `lda` >= max(1, m) elements, the last one of m.
///   call. May differ between the ranks where it does not change the result.
/// - `c`: one pointer, not NULL; written on success only. Free it by cata_symmetric_free.
///
/// Returns CATA_ERR_RANK when n, alpha or the precision differ between the ranks.
///
/// The result depends, by rounding, on the number of ranks and on which rank has which rows; not
/// on that of threads.
///
/// Not thread-safe: one call at a time for a world.
///
/// # Safety
/// The pointers are as described.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn cata_world_ata_rows_f64(
    world: *const cata_world,
    layout: i32,
    m: usize,
    n: usize,
    alpha: f64,
    a: *const f64,
    lda: usize,
    params: *const cata_ata_params,
    c: *mut *mut cata_symmetric,
) -> cata_status {
    with_mpi!(ranks::rows(world, layout, m, n, alpha, a, lda, params, c))
}

/// As cata_world_ata_rows_f64, in float.
///
/// Not thread-safe: one call at a time for a world.
///
/// # Safety
/// The pointers are as described at `cata_world_ata_rows_f64`.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn cata_world_ata_rows_f32(
    world: *const cata_world,
    layout: i32,
    m: usize,
    n: usize,
    alpha: f32,
    a: *const f32,
    lda: usize,
    params: *const cata_ata_params,
    c: *mut *mut cata_symmetric,
) -> cata_status {
    with_mpi!(ranks::rows(world, layout, m, n, alpha, a, lda, params, c))
}

/// Least squares where every rank has some rows of A, of B and of the weights, in any order and
/// number, 0 included; every rank gets the whole of X and of the result. Collective.
///
/// - `world`: not NULL.
/// - `layout`, `m`, `a`, `lda`, `b`, `ldb`, `weights`: of the rows of this rank, its own on each
///   rank, as in cata_lstsq; `weights` is NULL on all ranks or on none.
/// - `n`, `k`: as in cata_lstsq, the same on all ranks.
/// - `x`, `ldx`, `result`: as in cata_lstsq; what is wanted may differ between the ranks.
/// - `params`: as in cata_lstsq; `threads` and `progress` may differ between the ranks.
///   Progress is that of the second pass over the rows of this rank.
///
/// Returns CATA_ERR_RANK when arguments differ between the ranks.
///
/// The result does not depend on the number of ranks or of threads, nor on which rank has which
/// rows, bit for bit.
///
/// Not thread-safe: one call at a time for a world.
///
/// # Safety
/// The pointers are as described.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn cata_world_lstsq(
    world: *const cata_world,
    layout: i32,
    m: usize,
    n: usize,
    k: usize,
    a: *const f64,
    lda: usize,
    b: *const f64,
    ldb: usize,
    weights: *const f64,
    x: *mut f64,
    ldx: usize,
    result: *mut cata_lstsq_result,
    params: *const cata_lstsq_params,
) -> cata_status {
    with_mpi!(ranks::least_squares(
        world, layout, m, n, k, a, lda, b, ldb, weights, x, ldx, result, params
    ))
}

/// C = alpha A^T A where every rank has some columns of A, in the order of the ranks, 0 included;
/// C is left spread over the ranks. Collective. Cheaper than cata_world_ata_rows_f64 where A is
/// not much longer than wide.
///
/// - `m`: rows of A.
/// - `cols`: columns of this rank, its own on each rank.
/// - `a`: the columns of this rank, read: an m x cols matrix as in cata_world_ata_rows_f64.
/// - The rest as there.
///
/// Returns what that does.
///
/// Not thread-safe: one call at a time for a world.
///
/// # Safety
/// The pointers are as described.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn cata_world_ata_columns_f64(
    world: *const cata_world,
    layout: i32,
    m: usize,
    cols: usize,
    alpha: f64,
    a: *const f64,
    lda: usize,
    params: *const cata_ata_params,
    c: *mut *mut cata_symmetric,
) -> cata_status {
    with_mpi!(ranks::columns(world, layout, m, cols, alpha, a, lda, params, c))
}

/// As cata_world_ata_columns_f64, in float.
///
/// Not thread-safe: one call at a time for a world.
///
/// # Safety
/// The pointers are as described at `cata_world_ata_columns_f64`.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn cata_world_ata_columns_f32(
    world: *const cata_world,
    layout: i32,
    m: usize,
    cols: usize,
    alpha: f32,
    a: *const f32,
    lda: usize,
    params: *const cata_ata_params,
    c: *mut *mut cata_symmetric,
) -> cata_status {
    with_mpi!(ranks::columns(world, layout, m, cols, alpha, a, lda, params, c))
}

/// C := alpha A^T A + beta C where one rank has A, m x n, and C, n x n: by AtA-D, or by dealing
/// rows of A, whichever should be faster for this shape and number of ranks. Collective.
///
/// - `world`: not NULL.
/// - `root`: the rank that has them, from 0.
/// - `alpha`: the same on all ranks.
/// - `layout`, `uplo`, `m`, `n`, `a`, `lda`, `beta`, `c`, `ldc`: on the root as in cata_ata_f64;
///   ignored on other ranks.
///
/// Returns CATA_ERR_RANK when the roots, alpha or the precision differ between the ranks. C is
/// untouched after an error in arguments, and holds unspecified values in its wanted part after
/// any other.
///
/// The result depends, by rounding, on the number of ranks; not on that of threads.
///
/// Not thread-safe: one call at a time for a world.
///
/// # Safety
/// The pointers are as described.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn cata_world_ata_root_f64(
    world: *const cata_world,
    root: usize,
    layout: i32,
    uplo: i32,
    m: usize,
    n: usize,
    alpha: f64,
    a: *const f64,
    lda: usize,
    beta: f64,
    c: *mut f64,
    ldc: usize,
    params: *const cata_ata_params,
) -> cata_status {
    with_mpi!(ranks::root(world, root, layout, uplo, m, n, alpha, a, lda, beta, c, ldc, params))
}

/// As cata_world_ata_root_f64, in float.
///
/// Not thread-safe: one call at a time for a world.
///
/// # Safety
/// The pointers are as described at `cata_world_ata_root_f64`.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn cata_world_ata_root_f32(
    world: *const cata_world,
    root: usize,
    layout: i32,
    uplo: i32,
    m: usize,
    n: usize,
    alpha: f32,
    a: *const f32,
    lda: usize,
    beta: f32,
    c: *mut f32,
    ldc: usize,
    params: *const cata_ata_params,
) -> cata_status {
    with_mpi!(ranks::root(world, root, layout, uplo, m, n, alpha, a, lda, beta, c, ldc, params))
}

/// C := alpha A^T A + beta C for block-cyclic A, m x n, and C, n x n, as ScaLAPACK has them; what
/// PDSYRK does with TRANS = 'T' to whole matrices. Collective.
///
/// - `world`: not NULL.
/// - `uplo`: CATA_UPPER, CATA_LOWER or CATA_BOTH: the part of C that is wanted; the strict
///   triangle that is not, and what lies between columns, is neither read nor written.
/// - `alpha`, `beta`: any; with beta == 0 C is not read, so it may be uninitialised. Otherwise,
///   with CATA_BOTH, it must be symmetric: each triangle is added to its own old one.
/// - `a`: A's entries on this rank, read: column-major, with leading dimension LLD_ of `desc_a`.
/// - `desc_a`: 9 numbers, not NULL: DTYPE_ (1), CTXT_ (ignored), M_ >= 0, N_ >= 0, MB_ >= 1, NB_
///   >= 1, RSRC_, CSRC_ (from 0, a row and a column of the grid), LLD_ (at least 1 and the rows
///   on this rank; ignored outside of the grid). The same on all ranks but for CTXT_ and LLD_.
/// - `c`: C's entries on this rank, written, as `a` with `desc_c`. No element of A may be one of
///   C's.
/// - `desc_c`: as `desc_a`; M_ and N_ are A's N_. Its blocks and first processes may be others.
/// - `grid_rows`, `grid_cols`: the process grid, at least 1 x 1, not more than the ranks of the
///   world, of which it is the first ones.
/// - `grid_order`: CATA_ROW_MAJOR when ranks are numbered along the rows of the grid, as by
///   Cblacs_gridinit with "R", or CATA_COL_MAJOR, along its columns.
///
/// A is dealt out anew, in a copy, as rows or columns, whichever costs fewer words. The result
/// depends, by rounding, on the number of ranks and on how A is dealt out; not on the number of
/// threads.
///
/// Not thread-safe: one call at a time for a world.
///
/// # Safety
/// The pointers are as described.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn cata_world_ata_cyclic_f64(
    world: *const cata_world,
    uplo: i32,
    alpha: f64,
    a: *const f64,
    desc_a: *const i32,
    beta: f64,
    c: *mut f64,
    desc_c: *const i32,
    grid_rows: usize,
    grid_cols: usize,
    grid_order: i32,
    params: *const cata_ata_params,
) -> cata_status {
    with_mpi!(ranks::cyclic(
        world, uplo, false, alpha, a, desc_a, beta, c, desc_c, grid_rows, grid_cols, grid_order,
        params
    ))
}

/// As cata_world_ata_cyclic_f64, in float; PSSYRK.
///
/// Not thread-safe: one call at a time for a world.
///
/// # Safety
/// The pointers are as described at `cata_world_ata_cyclic_f64`.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn cata_world_ata_cyclic_f32(
    world: *const cata_world,
    uplo: i32,
    alpha: f32,
    a: *const f32,
    desc_a: *const i32,
    beta: f32,
    c: *mut f32,
    desc_c: *const i32,
    grid_rows: usize,
    grid_cols: usize,
    grid_order: i32,
    params: *const cata_ata_params,
) -> cata_status {
    with_mpi!(ranks::cyclic(
        world, uplo, false, alpha, a, desc_a, beta, c, desc_c, grid_rows, grid_cols, grid_order,
        params
    ))
}

/// C := alpha A A^T + beta C for block-cyclic A, m x n, and C, m x m; what PDSYRK does with TRANS
/// = 'N' to whole matrices. Collective. M_ and N_ of `desc_c` are A's M_; the rest as in
/// cata_world_ata_cyclic_f64.
///
/// Not thread-safe: one call at a time for a world.
///
/// # Safety
/// The pointers are as described at `cata_world_ata_cyclic_f64`.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn cata_world_aat_cyclic_f64(
    world: *const cata_world,
    uplo: i32,
    alpha: f64,
    a: *const f64,
    desc_a: *const i32,
    beta: f64,
    c: *mut f64,
    desc_c: *const i32,
    grid_rows: usize,
    grid_cols: usize,
    grid_order: i32,
    params: *const cata_ata_params,
) -> cata_status {
    with_mpi!(ranks::cyclic(
        world, uplo, true, alpha, a, desc_a, beta, c, desc_c, grid_rows, grid_cols, grid_order,
        params
    ))
}

/// As cata_world_aat_cyclic_f64, in float.
///
/// Not thread-safe: one call at a time for a world.
///
/// # Safety
/// The pointers are as described at `cata_world_ata_cyclic_f64`.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn cata_world_aat_cyclic_f32(
    world: *const cata_world,
    uplo: i32,
    alpha: f32,
    a: *const f32,
    desc_a: *const i32,
    beta: f32,
    c: *mut f32,
    desc_c: *const i32,
    grid_rows: usize,
    grid_cols: usize,
    grid_order: i32,
    params: *const cata_ata_params,
) -> cata_status {
    with_mpi!(ranks::cyclic(
        world, uplo, true, alpha, a, desc_a, beta, c, desc_c, grid_rows, grid_cols, grid_order,
        params
    ))
}

/// Rows and columns of a distributed matrix. Local.
///
/// `symmetric`: not NULL. `n`: one size_t, not NULL; written on success.
///
/// # Safety
/// The pointers are as described.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn cata_symmetric_n(
    symmetric: *const cata_symmetric,
    n: *mut usize,
) -> cata_status {
    with_mpi!(ranks::number("n", n, ranks::entries(symmetric)?.n()))
}

/// Gives the part that this rank has of a distributed matrix back. Local, before or after the end
/// of its world.
///
/// `symmetric`: made by this library and not yet freed; NULL does nothing.
///
/// # Safety
/// The pointer is as described.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn cata_symmetric_free(symmetric: *mut cata_symmetric) {
    with_mpi!(ranks::free_symmetric(symmetric));
}

/// Puts the whole of a distributed matrix of doubles into C on one rank. Collective.
///
/// - `symmetric`: not NULL; made by a call of all ranks of `world`, in double.
/// - `world`: not NULL.
/// - `root`: the rank that gets C, from 0.
/// - `layout`, `uplo`, `c`, `ldc`: on the root C, n x n, as in cata_ata_f64; ignored on other
///   ranks.
///
/// Not thread-safe: one call at a time for a world.
///
/// # Safety
/// The pointers are as described.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn cata_symmetric_gather_f64(
    symmetric: *const cata_symmetric,
    world: *const cata_world,
    root: usize,
    layout: i32,
    uplo: i32,
    c: *mut f64,
    ldc: usize,
) -> cata_status {
    with_mpi!(ranks::gather(symmetric, world, root, layout, uplo, c, ldc))
}

/// As cata_symmetric_gather_f64, of floats.
///
/// Not thread-safe: one call at a time for a world.
///
/// # Safety
/// The pointers are as described at `cata_symmetric_gather_f64`.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn cata_symmetric_gather_f32(
    symmetric: *const cata_symmetric,
    world: *const cata_world,
    root: usize,
    layout: i32,
    uplo: i32,
    c: *mut f32,
    ldc: usize,
) -> cata_status {
    with_mpi!(ranks::gather(symmetric, world, root, layout, uplo, c, ldc))
}

/// Checks that a distributed matrix of doubles is alpha A^T A, up to rounding, with `rounds`
/// random vectors (Freivalds 1977). Collective; all ranks get the same answer.
///
/// - `symmetric`: not NULL; n x n, in double, made by a call of all ranks of `world`. Read.
/// - `world`: not NULL.
/// - `spread`: CATA_BY_ROWS or CATA_BY_COLUMNS: how A is spread.
/// - `layout`: of this rank's part of A.
/// - `rows`, `cols`: of this rank's part of A: any number of rows and n columns, or as many rows
///   as A and any number of columns, n on all ranks together.
/// - `a`, `lda`: this rank's part of A, read, as in cata_world_ata_rows_f64 or
///   cata_world_ata_columns_f64.
/// - `rounds`: 1 to 1000. A matrix with an entry wrong by more than twice the tolerance passes
///   with probability at most 2^-rounds.
/// - `seed`: of the random vectors; the same seed gives the same answer.
/// - `passed`, `residual`, `tolerance`: as in cata_verify_f64.
///
/// Returns CATA_OK, whether it passed or not.
///
/// Not thread-safe: one call at a time for a world.
///
/// # Safety
/// The pointers are as described.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn cata_symmetric_verify_f64(
    symmetric: *const cata_symmetric,
    world: *const cata_world,
    spread: i32,
    layout: i32,
    rows: usize,
    cols: usize,
    alpha: f64,
    a: *const f64,
    lda: usize,
    rounds: i32,
    seed: u64,
    passed: *mut i32,
    residual: *mut f64,
    tolerance: *mut f64,
) -> cata_status {
    with_mpi!(ranks::check(
        symmetric, world, spread, layout, rows, cols, alpha, a, lda, rounds, seed, passed,
        residual, tolerance
    ))
}

/// As cata_symmetric_verify_f64, for a product in float. The check itself is in double.
///
/// Not thread-safe: one call at a time for a world.
///
/// # Safety
/// The pointers are as described at `cata_symmetric_verify_f64`.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn cata_symmetric_verify_f32(
    symmetric: *const cata_symmetric,
    world: *const cata_world,
    spread: i32,
    layout: i32,
    rows: usize,
    cols: usize,
    alpha: f64,
    a: *const f32,
    lda: usize,
    rounds: i32,
    seed: u64,
    passed: *mut i32,
    residual: *mut f64,
    tolerance: *mut f64,
) -> cata_status {
    with_mpi!(ranks::check(
        symmetric, world, spread, layout, rows, cols, alpha, a, lda, rounds, seed, passed,
        residual, tolerance
    ))
}
