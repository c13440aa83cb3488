//! What the exports of `mpi` do, where the feature is there.

use std::cell::Cell;

use super::ata_params::{cata_ata_params, with_options};
use super::eigs::{Outputs, cata_eigs_params, mass, with_eigen_options};
use super::entries::{Entries, Held};
use super::lstsq::{LeastSquaresCall, cata_lstsq_params, cata_lstsq_result};
use super::ortho::{CATA_ORTHO_RANK_REVEALING, FactorsOut, cata_ortho_params, with_ortho_options};
use super::params::write;
use super::pointer::{
    Layout, matrix, matrix_mut, optional_output, output, slice, sparse, uplo_from,
};
use super::progress::watcher;
use super::status::{CATA_ERR_ARGUMENT, CATA_ERR_UNSUPPORTED, Failure};
use super::world::{CATA_BY_COLUMNS, CATA_BY_ROWS, cata_symmetric, cata_traffic, cata_world};
use crate::ata::distributed::{BlockCyclic, Grid, GridOrder};
use crate::base::Progress;
use crate::mpi::{
    CyclicMut, CyclicRef, Distributed, Operation, Symmetric, World, aat_cyclic, ata_columns,
    ata_cyclic, ata_root, ata_rows, eigs, gram_schmidt_in_place, lstsq, verify,
    watched_cholesky_qr,
};
use crate::{AtaOptions, Error, Uplo};

type Outcome = Result<(), Failure>;

/// The only way from the checks that one rank makes of its arguments to what all ranks do
/// together.
pub(super) struct Entrance<'w> {
    world: &'w World,
    passed: Cell<bool>,
}

impl<'w> Entrance<'w> {
    fn enter(&self) -> &'w World {
        self.passed.set(true);
        self.world
    }
}

/// Does `work`; if it fails before it enters, the other ranks, who have begun `operation`, are
/// told.
///
/// # Safety
/// `world` is NULL or alive.
unsafe fn collective(
    world: *const cata_world,
    operation: Operation,
    work: impl FnOnce(&Entrance<'_>) -> Outcome,
) -> Outcome {
    // SAFETY: the caller's promise.
    let world = unsafe { self::world(world) }?;
    let _guard = world.abort_on_panic();
    let entrance = Entrance { world, passed: Cell::new(false) };
    let outcome = work(&entrance);
    if let (Err(failure), false) = (&outcome, entrance.passed.get()) {
        let own = Error::Rank { rank: world.rank(), why: failure.message.clone() };
        // It can only end in that error.
        let _ = world.begin(operation, &[], Err::<(), _>(own));
    }
    outcome
}

/// # Safety
/// NULL or alive.
pub(super) unsafe fn world<'w>(world: *const cata_world) -> Result<&'w World, Failure> {
    // SAFETY: the caller's promise.
    unsafe { world.as_ref() }.map(|w| &w.world).ok_or_else(|| Failure::null("world"))
}

/// # Safety
/// NULL or alive.
pub(super) unsafe fn entries<'s>(matrix: *const cata_symmetric) -> Result<&'s Entries, Failure> {
    // SAFETY: the caller's promise.
    unsafe { matrix.as_ref() }.map(|m| &m.entries).ok_or_else(|| Failure::null("symmetric"))
}

/// # Safety
/// As the header describes the arguments; so below.
pub(super) unsafe fn new(fortran_comm: i32, world: *mut *mut cata_world) -> Outcome {
    let ours = World::from_fortran(fortran_comm)?;
    let _guard = ours.abort_on_panic();
    // SAFETY: the caller's promise.
    let place = unsafe { output("world", world) };
    // A world with a rank that knows nothing of it would hang.
    let told = place
        .as_ref()
        .map(|_| ())
        .map_err(|failure| Error::Rank { rank: ours.rank(), why: failure.message.clone() });
    let agreed = ours.agree(told);
    let place = place?;
    agreed?;
    drop(_guard);
    *place = Box::into_raw(Box::new(cata_world { world: ours }));
    Ok(())
}

/// # Safety
/// As the header says.
pub(super) unsafe fn free(world: *mut cata_world) -> Outcome {
    if !world.is_null() {
        // SAFETY: it came from `Box::into_raw`, and the caller promises to free it once.
        drop(unsafe { Box::from_raw(world) });
    }
    Ok(())
}

/// # Safety
/// As the header says.
pub(super) unsafe fn free_symmetric(matrix: *mut cata_symmetric) -> Outcome {
    if !matrix.is_null() {
        // SAFETY: it came from `Box::into_raw`, and the caller promises to free it once.
        drop(unsafe { Box::from_raw(matrix) });
    }
    Ok(())
}

/// Writes a number.
///
/// # Safety
/// As the header says.
pub(super) unsafe fn number(what: &str, place: *mut usize, value: usize) -> Outcome {
    // SAFETY: the caller's promise.
    *unsafe { output(what, place) }? = value;
    Ok(())
}

/// # Safety
/// As the header says.
pub(super) unsafe fn traffic(world: *const cata_world, place: *mut cata_traffic) -> Outcome {
    // SAFETY: the caller's promise.
    let found = unsafe { self::world(world) }?.traffic();
    let traffic = cata_traffic {
        struct_size: 0,
        words_sent: found.words_sent,
        words_received: found.words_received,
        messages_sent: found.messages_sent,
        messages_received: found.messages_received,
    };
    // SAFETY: the caller's promise.
    unsafe { write("traffic", place, &traffic) }
}

/// # Safety
/// As the header says.
pub(super) unsafe fn set_longest_message(world: *const cata_world, entries: usize) -> Outcome {
    // SAFETY: the caller's promise.
    unsafe { self::world(world) }?.set_longest_message(entries);
    Ok(())
}

/// # Safety
/// As the header says.
pub(super) unsafe fn rows<T: Held>(
    world: *const cata_world,
    layout: i32,
    m: usize,
    n: usize,
    alpha: T,
    a: *const T,
    lda: usize,
    params: *const cata_ata_params,
    c: *mut *mut cata_symmetric,
) -> Outcome {
    // SAFETY: the caller's promise.
    unsafe {
        collective(world, Operation::Rows, |entrance| {
            let a = matrix("a", Layout::new(layout)?, m, n, a, lda)?;
            // Without columns there is nothing to multiply, and m may be beyond counting.
            let a = if n == 0 { a.subrows(0, 0) } else { a };
            let c = output("c", c)?;
            with_options(params, Uplo::Lower, |options| {
                let result = ata_rows(entrance.enter(), alpha, a, options)?;
                *c = handle(result);
                Ok(())
            })
        })
    }
}

/// # Safety
/// As the header says.
pub(super) unsafe fn columns(
    world: *const cata_world,
    layout: i32,
    m: usize,
    cols: usize,
    alpha: f64,
    a: *const f64,
    lda: usize,
    params: *const cata_ata_params,
    c: *mut *mut cata_symmetric,
) -> Outcome {
    // SAFETY: the caller's promise.
    unsafe {
        collective(world, Operation::Columns, |entrance| {
            let a = matrix("a", Layout::new(layout)?, m, cols, a, lda)?;
            let c = output("c", c)?;
            with_options(params, Uplo::Lower, |options| {
                let result = ata_columns(entrance.enter(), alpha, a, options)?;
                *c = handle(result);
                Ok(())
            })
        })
    }
}

fn handle<T: Held>(matrix: Symmetric<T>) -> *mut cata_symmetric {
    Box::into_raw(Box::new(cata_symmetric { entries: T::hold(matrix) }))
}

/// # Safety
/// As the header says.
pub(super) unsafe fn root(
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
) -> Outcome {
    // SAFETY: the caller's promise.
    unsafe {
        collective(world, Operation::Root, |entrance| {
            if entrance.world.rank() != root {
                return with_options(params, Uplo::Lower, |options| {
                    Ok(ata_root(entrance.enter(), root, alpha, None, beta, None, options)?)
                });
            }
            let (layout, uplo) = (Layout::new(layout)?, uplo_from(uplo)?);
            let a = matrix("a", layout, m, n, a, lda)?;
            // Without columns there is nothing to multiply, and m may be beyond counting.
            let a = if n == 0 { a.subrows(0, 0) } else { a };
            let c = matrix_mut("c", layout, n, n, c, ldc)?;
            with_options(params, uplo, |options| {
                Ok(ata_root(entrance.enter(), root, alpha, Some(a), beta, Some(c), options)?)
            })
        })
    }
}

/// # Safety
/// As the header says.
pub(super) unsafe fn cyclic(
    world: *const cata_world,
    uplo: i32,
    transposed: bool,
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
) -> Outcome {
    // SAFETY: the caller's promise.
    unsafe {
        collective(world, Operation::Cyclic, |entrance| {
            let uplo = uplo_from(uplo)?;
            let order = match Layout::new(grid_order) {
                Ok(Layout::RowMajor) => GridOrder::Rows,
                Ok(Layout::ColMajor) => GridOrder::Columns,
                Err(failure) => {
                    let why = failure.message.replacen("layout", "grid_order", 1);
                    return Err(Failure::new(failure.status, why));
                }
            };
            let grid = Grid::new(grid_rows, grid_cols, order)?;
            let rank = entrance.world.rank();
            let described = |what, numbers| -> Result<(BlockCyclic, usize), Failure> {
                let numbers = slice(what, numbers, 9)?;
                let mut descriptor = [0; 9];
                descriptor.copy_from_slice(numbers);
                Ok(BlockCyclic::from_descriptor(what, &descriptor, grid, rank)?)
            };
            let (of_a, lda) = described("desc_a", desc_a)?;
            let (of_c, ldc) = described("desc_c", desc_c)?;
            let (rows, cols) = of_a.local_shape(rank);
            let entries = matrix("a", Layout::ColMajor, rows, cols, a, lda)?;
            let a = CyclicRef { matrix: of_a, entries };
            let (rows, cols) = of_c.local_shape(rank);
            let entries = matrix_mut("c", Layout::ColMajor, rows, cols, c, ldc)?;
            let c = CyclicMut { matrix: of_c, entries };
            with_options(params, uplo, |options: &AtaOptions<'_>| {
                let product = if transposed { aat_cyclic } else { ata_cyclic };
                Ok(product(entrance.enter(), alpha, a, beta, c, options)?)
            })
        })
    }
}

/// # Safety
/// As the header says.
pub(super) unsafe fn least_squares(
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
) -> Outcome {
    // SAFETY: the caller's promise.
    unsafe {
        collective(world, Operation::LeastSquares, |entrance| {
            let call = LeastSquaresCall::new(
                layout, m, n, k, a, lda, b, ldb, weights, x, ldx, result, params,
            )?;
            let watch = watcher(call.params.progress, call.params.progress_user);
            let progress = watch.as_ref().map_or(Progress::none(), Progress::from);
            let (a, b, weights) = (call.a, call.b, call.weights);
            let found = lstsq(entrance.enter(), a, b, weights, &call.options, progress)?;
            call.finish(&found);
            Ok(())
        })
    }
}

/// # Safety
/// As the header says.
pub(super) unsafe fn eigenpairs(
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
) -> Outcome {
    // SAFETY: the caller's promise.
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

/// # Safety
/// As the header says.
pub(super) unsafe fn gram_schmidt(
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
) -> Outcome {
    // SAFETY: the caller's promise.
    unsafe {
        collective(world, Operation::GramSchmidt, |entrance| {
            let layout = Layout::new(layout)?;
            let a = matrix_mut("a", layout, own, c, a, lda)?;
            let masses = mass(own, masses)?;
            let results = FactorsOut::new(layout, c, c, r, ldr, kept, rank)?;
            with_ortho_options(params, |options, method| {
                if method == CATA_ORTHO_RANK_REVEALING {
                    let why = "params.method: CATA_ORTHO_RANK_REVEALING is not for ranks";
                    return Err(Failure::new(CATA_ERR_UNSUPPORTED, why));
                }
                results.write(&gram_schmidt_in_place(entrance.enter(), a, &masses, options)?);
                Ok(())
            })
        })
    }
}

/// # Safety
/// As the header says.
pub(super) unsafe fn cholesky_qr(
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
) -> Outcome {
    // SAFETY: the caller's promise.
    unsafe {
        collective(world, Operation::CholeskyQr, |entrance| {
            let layout = Layout::new(layout)?;
            let a = matrix_mut("a", layout, own, c, a, lda)?;
            let masses = mass(own, masses)?;
            let r = match r.is_null() {
                true => None,
                false => Some(matrix_mut("r", layout, c, c, r, ldr)?),
            };
            with_ortho_options(params, |options, _| {
                let (par, progress) = (options.par, options.progress);
                let found = watched_cholesky_qr(entrance.enter(), a, &masses, par, progress)?;
                if let Some(mut r) = r {
                    r.copy_from(&found);
                }
                Ok(())
            })
        })
    }
}

/// # Safety
/// As the header says.
pub(super) unsafe fn gather<T: Held>(
    symmetric: *const cata_symmetric,
    world: *const cata_world,
    root: usize,
    layout: i32,
    uplo: i32,
    c: *mut T,
    ldc: usize,
) -> Outcome {
    // SAFETY: the caller's promise.
    unsafe {
        collective(world, Operation::Gather, |entrance| {
            let symmetric = of_world::<T>(symmetric, entrance.world)?;
            let n = symmetric.n();
            if entrance.world.rank() != root {
                return Ok(symmetric.gather(entrance.enter(), root, None, Uplo::Lower)?);
            }
            let (layout, uplo) = (Layout::new(layout)?, uplo_from(uplo)?);
            let c = matrix_mut("c", layout, n, n, c, ldc)?;
            Ok(symmetric.gather(entrance.enter(), root, Some(c), uplo)?)
        })
    }
}

/// # Safety
/// As the header says.
pub(super) unsafe fn check<T: Held>(
    symmetric: *const cata_symmetric,
    world: *const cata_world,
    spread: i32,
    layout: i32,
    rows: usize,
    cols: usize,
    alpha: f64,
    a: *const T,
    lda: usize,
    rounds: i32,
    seed: u64,
    passed: *mut i32,
    residual: *mut f64,
    tolerance: *mut f64,
) -> Outcome {
    // SAFETY: the caller's promise.
    unsafe {
        collective(world, Operation::Verify, |entrance| {
            let symmetric = of_world::<T>(symmetric, entrance.world)?;
            let a = matrix("a", Layout::new(layout)?, rows, cols, a, lda)?;
            let a = match spread {
                CATA_BY_ROWS => Distributed::Rows(a),
                CATA_BY_COLUMNS => Distributed::Columns(a),
                other => {
                    let why = format!(
                        "spread: must be CATA_BY_ROWS (141) or CATA_BY_COLUMNS (142), is {other}"
                    );
                    return Err(Failure::new(CATA_ERR_ARGUMENT, why));
                }
            };
            let rounds = u32::try_from(rounds).unwrap_or(0);
            let passed = output("passed", passed)?;
            let residual = optional_output("residual", residual)?;
            let tolerance = optional_output("tolerance", tolerance)?;
            let found = verify(entrance.enter(), alpha, a, symmetric, rounds, seed)?;
            *passed = found.passed.into();
            if let Some(out) = residual {
                *out = found.residual;
            }
            if let Some(out) = tolerance {
                *out = found.tolerance;
            }
            Ok(())
        })
    }
}

/// The matrix behind a handle, if it is of this precision and of as many ranks as the world.
///
/// # Safety
/// NULL or alive.
unsafe fn of_world<'s, T: Held>(
    symmetric: *const cata_symmetric,
    world: &World,
) -> Result<&'s Symmetric<T>, Failure> {
    // SAFETY: the caller's promise.
    let Some(matrix) = T::held(unsafe { entries(symmetric) }?) else {
        let why = format!("symmetric: holds another type than {}", T::NAME);
        return Err(Failure::new(CATA_ERR_ARGUMENT, why));
    };
    let (its, ranks) = (matrix.layout().ranks(), world.size());
    if its != ranks {
        let why = format!("symmetric: spread over {its} ranks, the world has {ranks}");
        return Err(Failure::new(CATA_ERR_ARGUMENT, why));
    }
    Ok(matrix)
}
