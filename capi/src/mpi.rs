use super::ata_params::{cata_ata_params, with_options};
use super::boundary::boundary;
use super::eigs::{Outputs, cata_eigs_params, mass, with_eigen_options};
use super::lstsq::{LeastSquaresCall, cata_lstsq_params, cata_lstsq_result};
use super::ortho::{CATA_ORTHO_RANK_REVEALING, FactorsOut, cata_ortho_params, with_ortho_options};
use super::outputs::fill;
use super::params::{Params, write};
use super::pointer::{
    Layout, free, hand_over, matrix, matrix_mut, optional_matrix_mut, output, sparse, uplo_from,
};
use super::ranks::{check, collective, cyclic, entries, gather, rows, world as world_of};
use super::status::{CATA_ERR_UNSUPPORTED, Failure, cata_status};
use super::world::{cata_symmetric, cata_traffic, cata_world};
use catamaran::ranks::{
    Operation, World, ata_columns, ata_root, eigs, gram_schmidt_in_place, lstsq,
    watched_cholesky_qr,
};
use catamaran::{Error, Uplo};

/// Creates the world of the ranks of an MPI communicator, of which a duplicate is made. Collective
/// over it. CATA_ERR_ARGUMENT before MPI_Init and after MPI_Finalize.
///
/// `fortran_comm`: MPI_Comm_c2f of the communicator; catamaran_mpi.h has cata_world_from_comm,
/// which takes the communicator itself.
///
/// # Safety
/// The pointer is as described.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn cata_world_new(
    fortran_comm: i32,
    world: *mut *mut cata_world,
) -> cata_status {
    boundary(|| {
        let ours = World::from_fortran(fortran_comm)?;
        let _guard = ours.abort_on_panic();
        // SAFETY: clause `memory` (`world`, one value).
        let place = unsafe { output("world", world) };
        // A world with a rank that did not get it would hang.
        let told = place
            .as_ref()
            .map(|_| ())
            .map_err(|failure| Error::Rank { rank: ours.rank(), why: failure.message.clone() });
        let agreed = ours.agree(told);
        let place = place?;
        agreed?;
        drop(_guard);
        // Not by `hand_over`: MPI may be called by one thread alone.
        *place = Box::into_raw(Box::new(cata_world { world: ours }));
        Ok(())
    })
}

/// Frees a world. Collective; after MPI_Finalize local, and leaves the communicator to MPI.
///
/// # Safety
/// The pointer is as described.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn cata_world_free(world: *mut cata_world) {
    // SAFETY: clause `handles` (`world`).
    unsafe { free(world) };
}

/// Gets the rank of the caller, from 0. Local.
///
/// # Safety
/// The pointers are as described.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn cata_world_rank(
    world: *const cata_world,
    rank: *mut usize,
) -> cata_status {
    boundary(|| {
        // SAFETY: clause `memory` (`rank`, one value), clause `handles` (`world`).
        unsafe { *output("rank", rank)? = world_of(world)?.rank() };
        Ok(())
    })
}

/// Gets the number of ranks, at least 1. Local.
///
/// # Safety
/// The pointers are as described.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn cata_world_size(
    world: *const cata_world,
    size: *mut usize,
) -> cata_status {
    boundary(|| {
        // SAFETY: clause `memory` (`size`, one value), clause `handles` (`world`).
        unsafe { *output("size", size)? = world_of(world)?.size() };
        Ok(())
    })
}

/// Gets what this rank has sent and received since the world was made. Local. The struct_size of
/// `traffic` is read.
///
/// # Safety
/// The pointers are as described: `traffic` has as many bytes as its `struct_size` says.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn cata_world_traffic(
    world: *const cata_world,
    traffic: *mut cata_traffic,
) -> cata_status {
    boundary(|| {
        // SAFETY: clause `handles` (`world`).
        let found = unsafe { world_of(world) }?.traffic();
        let values = cata_traffic {
            struct_size: 0,
            words_sent: found.words_sent,
            words_received: found.words_received,
            messages_sent: found.messages_sent,
            messages_received: found.messages_received,
        };
        // SAFETY: clause `passed on` (`write`).
        unsafe { write("traffic", traffic, &values) }
    })
}

/// Sets the entries of a message above which it is cut in several, 1 to 2^30; 2^30 in a new
/// world. Local, but all ranks must set the same before the next collective call.
///
/// # Safety
/// The pointer is as described.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn cata_world_set_longest_message(
    world: *const cata_world,
    entries: usize,
) -> cata_status {
    boundary(|| {
        // SAFETY: clause `handles` (`world`).
        unsafe { world_of(world) }?.set_longest_message(entries);
        Ok(())
    })
}

/// Computes C = alpha A^T A where every rank has some rows of A, in any order and number; C is left
/// spread over the ranks. Collective. The result depends, by rounding, on the number of ranks and
/// on which rank has which rows.
///
/// - `layout`, `m`, `a`: of the rows of this rank, m x n, its own on each rank.
/// - `n`, `alpha`: the same on all ranks.
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
    // SAFETY: clause `passed on` (`rows`).
    unsafe { rows(world, layout, m, n, alpha, a, lda, params, c) }
}

/// Computes cata_world_ata_rows_f64 in float.
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
    // SAFETY: clause `passed on` (`rows`).
    unsafe { rows(world, layout, m, n, alpha, a, lda, params, c) }
}

/// Solves least squares where every rank has some rows of A, of B and of the weights, in any order
/// and number; every rank gets the whole of X and of the result. Collective. The result does not
/// depend on the number of ranks, nor on which rank has which rows, bit for bit.
///
/// - `layout`, `m`, `a`, `b`, `weights`: of the rows of this rank, as in cata_lstsq; `weights`
///   is NULL on all ranks or on none.
/// - `x`, `result`: as in cata_lstsq; what is wanted may differ between the ranks.
/// - `params`: progress is that of the second pass over the rows of this rank.
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
    // SAFETY: clause `passed on` (`collective`, `LeastSquaresCall::new`).
    unsafe {
        collective(world, Operation::LeastSquares, |entrance| {
            let call = LeastSquaresCall::new(
                layout, m, n, k, a, lda, b, ldb, weights, x, ldx, result, params,
            )?;
            let (a, b, weights) = (call.a, call.b, call.weights);
            let found = call
                .params
                .caller()
                .with(|progress| lstsq(entrance.enter(), a, b, weights, &call.options, progress))?;
            call.finish(&found)
        })
    }
}

/// Computes C = alpha A^T A where every rank has some columns of A (m x cols), in the order of the
/// ranks, as cata_world_ata_rows_f64. Cheaper than that where A is not much longer than wide.
///
/// # Safety
/// The pointers are as described.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn cata_world_ata_columns(
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
    // SAFETY: clause `memory` (`a`, m x `cols`; `c`, one value), clause `structs` (`params`),
    // clause `passed on` (`collective`).
    unsafe {
        collective(world, Operation::Columns, |entrance| {
            let a = matrix("a", Layout::new(layout)?, m, cols, a, lda)?;
            let c = output("c", c)?;
            with_options(params, Uplo::Lower, |options| {
                hand_over(c, cata_symmetric::of(ata_columns(entrance.enter(), alpha, a, options)?));
                Ok(())
            })
        })
    }
}

/// Computes C := alpha A^T A + beta C where the rank `root` has A, m x n, and C, n x n: by AtA-D,
/// or by distributing rows of A, whichever should be faster. Collective. The result depends, by
/// rounding, on the number of ranks. C is untouched after an error in arguments, unspecified in its
/// wanted part after any other.
///
/// - `alpha`: the same on all ranks.
/// - `layout` to `lda`, `beta` to `ldc`: on the root as in cata_ata_f64; ignored on other ranks.
///
/// # Safety
/// The pointers are as described.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn cata_world_ata_root(
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
    // SAFETY: clause `memory` (`a`, m x n; `c`, n x n), clause `structs` (`params`), clause
    // `passed on` (`collective`).
    unsafe {
        collective(world, Operation::Root, |entrance| {
            if entrance.rank() != root {
                return with_options(params, Uplo::Lower, |options| {
                    Ok(ata_root(entrance.enter(), root, alpha, None, beta, None, options)?)
                });
            }
            let (layout, uplo) = (Layout::new(layout)?, uplo_from(uplo)?);
            let a = matrix("a", layout, m, n, a, lda)?;
            // Without columns the product is zero, and m may exceed the address space.
            let a = if n == 0 { a.subrows(0, 0) } else { a };
            let c = matrix_mut("c", layout, n, n, c, ldc)?;
            with_options(params, uplo, |options| {
                Ok(ata_root(entrance.enter(), root, alpha, Some(a), beta, Some(c), options)?)
            })
        })
    }
}

/// Computes C := alpha A^T A + beta C for block-cyclic A, m x n, and C, n x n, as ScaLAPACK has
/// them; what PDSYRK does with TRANS = 'T' to whole matrices. Collective. A copy of A is
/// redistributed; the rounding depends on the number of ranks and on the layout of A.
///
/// - `uplo`, `alpha`, `beta`: as in cata_ata_f64; with CATA_BOTH and beta != 0 C must be
///   symmetric.
/// - `a`: A's entries on this rank: column-major, with leading dimension LLD_ of `desc_a`.
/// - `desc_a`: 9 numbers: DTYPE_ (1), CTXT_ (ignored), M_ >= 0, N_ >= 0, MB_ >= 1, NB_ >= 1,
///   RSRC_, CSRC_ (from 0, a row and a column of the grid), LLD_ (at least 1 and the rows on
///   this rank; ignored outside of the grid). The same on all ranks but for CTXT_ and LLD_.
/// - `c`, `desc_c`: C likewise, written; M_ and N_ are A's N_, the blocks any.
/// - `grid_rows`, `grid_cols`: the process grid, of the first ranks, at least 1 x 1.
/// - `grid_order`: CATA_ROW_MAJOR when ranks are numbered along the rows of the grid, as by
///   Cblacs_gridinit with "R", or CATA_COL_MAJOR, along its columns.
///
/// # Safety
/// The pointers are as described.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn cata_world_ata_cyclic(
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
    // SAFETY: clause `passed on` (`cyclic`).
    unsafe {
        cyclic(
            world, uplo, false, alpha, a, desc_a, beta, c, desc_c, grid_rows, grid_cols,
            grid_order, params,
        )
    }
}

/// Computes C := alpha A A^T + beta C as cata_world_ata_cyclic, m x m; PDSYRK with TRANS = 'N'. M_
/// and N_ of `desc_c` are A's M_.
///
/// # Safety
/// The pointers are as described at `cata_world_ata_cyclic`.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn cata_world_aat_cyclic(
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
    // SAFETY: clause `passed on` (`cyclic`).
    unsafe {
        cyclic(
            world, uplo, true, alpha, a, desc_a, beta, c, desc_c, grid_rows, grid_cols, grid_order,
            params,
        )
    }
}

/// Computes eigenpairs as those of cata_eigs where every rank has some rows of W, in the order of
/// the ranks. Collective. Every rank gets all eigenvalues and residuals and its rows of the
/// eigenvectors. The basis, most of the memory, is spread; W and its factor are on every rank.
///
/// - `own`: rows of this rank, its own on each rank; `n`: all rows.
/// - `row_starts`, `columns`, `entries`, `masses`: of these rows, columns from 0 to n - 1.
/// - `eigenvectors`: own x k, written, column-major.
///
/// # Safety
/// The pointers are as described.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn cata_world_eigs(
    world: *const cata_world,
    own: usize,
    n: usize,
    row_starts: *const usize,
    columns: *const usize,
    entries: *const f64,
    masses: *const f64,
    k: usize,
    eigenvalues: *mut f64,
    eigenvectors: *mut f64,
    ldv: usize,
    residuals: *mut f64,
    params: *const cata_eigs_params,
) -> cata_status {
    // SAFETY: clause `memory` (the CSR arrays), clause `structs` (`params`), clause `passed on`
    // (`collective`, `mass`, `Outputs::new`).
    unsafe {
        collective(world, Operation::Eigenpairs, |entrance| {
            let rows = sparse(own, n, row_starts, columns, entries)?;
            let masses = mass(own, masses)?;
            let outputs = Outputs::new(own, k, eigenvalues, eigenvectors, ldv, residuals)?;
            with_eigen_options(k, params, |options, _| {
                let pairs = eigs(entrance.enter(), rows, &masses, options)?;
                outputs.write(&pairs.values, pairs.vectors.as_ref(), &pairs.residuals);
                Ok(())
            })
        })
    }
}

/// Computes cata_ortho_gram_schmidt where every rank has some rows of A and masses, in the order of
/// the ranks: `own` of this rank. Collective. Every rank gets its rows of Q and all of `r`, which
/// is c x c, `kept` and `rank`; A is unspecified after errors. CATA_ORTHO_RANK_REVEALING is
/// CATA_ERR_UNSUPPORTED.
///
/// # Safety
/// The pointers are as described.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn cata_world_gram_schmidt(
    world: *const cata_world,
    layout: i32,
    own: usize,
    c: usize,
    a: *mut f64,
    lda: usize,
    masses: *const f64,
    r: *mut f64,
    ldr: usize,
    kept: *mut usize,
    rank: *mut usize,
    params: *const cata_ortho_params,
) -> cata_status {
    // SAFETY: clause `memory` (`a`, `own` x c), clause `structs` (`params`), clause `passed on`
    // (`collective`, `mass`, `FactorsOut::new`).
    unsafe {
        collective(world, Operation::GramSchmidt, |entrance| {
            let layout = Layout::new(layout)?;
            let a = matrix_mut("a", layout, own, c, a, lda)?;
            let masses = mass(own, masses)?;
            let results = FactorsOut::new(layout, c, c, r, ldr, kept, rank)?;
            with_ortho_options(params, |options, method| {
                if method == CATA_ORTHO_RANK_REVEALING {
                    let why = "params.method: CATA_ORTHO_RANK_REVEALING is not available";
                    return Err(Failure::new(CATA_ERR_UNSUPPORTED, why));
                }
                results.write(&gram_schmidt_in_place(entrance.enter(), a, &masses, options)?);
                Ok(())
            })
        })
    }
}

/// Computes cata_ortho_cholesky_qr for rows that are distributed in the same way.
///
/// # Safety
/// The pointers are as described.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn cata_world_cholesky_qr(
    world: *const cata_world,
    layout: i32,
    own: usize,
    c: usize,
    a: *mut f64,
    lda: usize,
    masses: *const f64,
    r: *mut f64,
    ldr: usize,
    params: *const cata_ortho_params,
) -> cata_status {
    // SAFETY: clause `memory` (`a`, `own` x c; `r`, c x c), clause `structs` (`params`), clause
    // `passed on` (`collective`, `mass`).
    unsafe {
        collective(world, Operation::CholeskyQr, |entrance| {
            let layout = Layout::new(layout)?;
            let a = matrix_mut("a", layout, own, c, a, lda)?;
            let masses = mass(own, masses)?;
            let r = optional_matrix_mut("r", layout, c, c, r, ldr)?;
            with_ortho_options(params, |options, _| {
                let (par, progress) = (options.par, options.progress);
                let found = watched_cholesky_qr(entrance.enter(), a, &masses, par, progress)?;
                fill(r, found.as_ref());
                Ok(())
            })
        })
    }
}

/// Gets the number of rows and columns of a distributed matrix. Local.
///
/// # Safety
/// The pointers are as described.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn cata_symmetric_n(
    symmetric: *const cata_symmetric,
    n: *mut usize,
) -> cata_status {
    boundary(|| {
        // SAFETY: clause `memory` (`n`, one value), clause `passed on` (`entries`).
        unsafe { *output("n", n)? = entries(symmetric)?.n() };
        Ok(())
    })
}

/// Frees the part of a distributed matrix that this rank holds. Local.
///
/// # Safety
/// The pointer is as described.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn cata_symmetric_free(symmetric: *mut cata_symmetric) {
    // SAFETY: clause `handles` (`symmetric`).
    unsafe { free(symmetric) };
}

/// Puts the whole of a distributed matrix of doubles, made by all ranks of `world`, into C, n x
/// n, on the rank `root`, as cata_ata_f64 does; other ranks' `layout` to `ldc` are ignored.
/// Collective.
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
    // SAFETY: clause `passed on` (`gather`).
    unsafe { gather(symmetric, world, root, layout, uplo, c, ldc) }
}

/// Gathers a matrix of floats as cata_symmetric_gather_f64.
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
    // SAFETY: clause `passed on` (`gather`).
    unsafe { gather(symmetric, world, root, layout, uplo, c, ldc) }
}

/// Checks that a distributed matrix of doubles, made by all ranks of `world`, is alpha A^T A, up
/// to rounding, as cata_verify_f64 does. Collective; all ranks get the same answer.
///
/// - `spread`: CATA_BY_ROWS or CATA_BY_COLUMNS: how A is spread.
/// - `layout`, `rows`, `cols`, `a`: of this rank's part of A.
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
    // SAFETY: clause `passed on` (`check`).
    unsafe {
        check(
            symmetric, world, spread, layout, rows, cols, alpha, a, lda, rounds, seed, passed,
            residual, tolerance,
        )
    }
}

/// Checks a product in float as cata_symmetric_verify_f64; the check itself is in double.
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
    // SAFETY: clause `passed on` (`check`).
    unsafe {
        check(
            symmetric, world, spread, layout, rows, cols, alpha, a, lda, rounds, seed, passed,
            residual, tolerance,
        )
    }
}
