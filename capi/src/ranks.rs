//! Shared parts of the exports of `mpi`.

use std::cell::Cell;

use super::ata_params::{cata_ata_params, with_options};
use super::boundary::boundary;
use super::entries::{Entries, Held};
use super::pointer::{
    Layout, array, hand_over, known, matrix, matrix_mut, optional_output, output, put, uplo_from,
};
use super::status::{CATA_ERR_ARGUMENT, Failure, cata_status};
use super::world::{CATA_BY_COLUMNS, CATA_BY_ROWS, cata_symmetric, cata_world};
use catamaran::ranks::plan::{BlockCyclic, Grid, GridOrder};
use catamaran::ranks::{
    CyclicMut, CyclicRef, Distributed, Operation, Symmetric, World, aat_cyclic, ata_cyclic,
    ata_rows, verify,
};
use catamaran::{AtaOptions, Error, Uplo};

type Outcome = Result<(), Failure>;

/// Leads from the checks that one rank makes of its arguments to the collective work: the world is
/// available through it only.
pub(super) struct Entrance<'w> {
    world: &'w World,
    passed: Cell<bool>,
}

impl<'w> Entrance<'w> {
    /// Returns the rank of the caller.
    pub fn rank(&self) -> usize {
        self.world.rank()
    }

    /// Returns the world, and records that the work has entered it.
    pub fn enter(&self) -> &'w World {
        self.passed.set(true);
        self.world
    }
}

/// Implements a collective function by `work`. If it fails before it enters, the other ranks, which
/// have begun `operation`, are informed.
///
/// # Safety
/// `world` is NULL or alive.
pub(super) unsafe fn collective(
    world: *const cata_world,
    operation: Operation,
    work: impl FnOnce(&Entrance<'_>) -> Outcome,
) -> cata_status {
    boundary(|| {
        // SAFETY: clause `passed on` (`world`).
        let world = unsafe { self::world(world) }?;
        let _guard = world.abort_on_panic();
        let entrance = Entrance { world, passed: Cell::new(false) };
        let outcome = work(&entrance);
        if let (Err(failure), false) = (&outcome, entrance.passed.get()) {
            let own = Error::Rank { rank: world.rank(), why: failure.message.clone() };
            // This call can only return that error.
            let _ = world.begin(operation, &[], Err::<(), _>(own));
        }
        outcome
    })
}

/// Returns the world of a handle.
///
/// # Safety
/// NULL or alive.
pub(super) unsafe fn world<'w>(world: *const cata_world) -> Result<&'w World, Failure> {
    // SAFETY: clause `handles` (`world`), which takes one call at a time, though most take it as
    // const; NULL gives `None`.
    let world = unsafe { world.as_ref() }.ok_or_else(|| Failure::null("world"))?;
    Ok(&world.world)
}

/// Returns the entries of a handle.
///
/// # Safety
/// NULL or alive.
pub(super) unsafe fn entries<'s>(matrix: *const cata_symmetric) -> Result<&'s Entries, Failure> {
    // SAFETY: clause `handles` (`symmetric`).
    unsafe { known("symmetric", matrix) }.map(|m| &m.entries)
}

/// Implements `cata_world_ata_rows_*`.
///
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
) -> cata_status {
    // SAFETY: clause `memory` (`a`, m x n; `c`, one value), clause `structs` (`params`), clause
    // `passed on` (`collective`).
    unsafe {
        collective(world, Operation::Rows, |entrance| {
            let a = matrix("a", Layout::new(layout)?, m, n, a, lda)?;
            // Without columns the product is zero, and m may exceed the address space.
            let a = if n == 0 { a.subrows(0, 0) } else { a };
            let c = output("c", c)?;
            with_options(params, Uplo::Lower, |options| {
                hand_over(c, cata_symmetric::of(ata_rows(entrance.enter(), alpha, a, options)?));
                Ok(())
            })
        })
    }
}

impl cata_symmetric {
    pub(super) fn of<T: Held>(matrix: Symmetric<T>) -> Self {
        Self { entries: T::hold(matrix) }
    }
}

/// Implements `cata_world_ata_cyclic` and `cata_world_aat_cyclic`.
///
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
) -> cata_status {
    // SAFETY: clause `memory` (`a` and `c`, the entries on this rank, by their descriptors, of 9
    // elements each), clause `structs` (`params`), clause `passed on` (`collective`).
    unsafe {
        collective(world, Operation::Cyclic, |entrance| {
            let uplo = uplo_from(uplo)?;
            let order = match Layout::named("grid_order", grid_order)? {
                Layout::RowMajor => GridOrder::Rows,
                Layout::ColMajor => GridOrder::Columns,
            };
            let grid = Grid::new(grid_rows, grid_cols, order)?;
            let rank = entrance.world.rank();
            let described = |what, numbers| -> Result<(BlockCyclic, usize), Failure> {
                Ok(BlockCyclic::from_descriptor(what, &array(what, numbers)?, grid, rank)?)
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

/// Implements `cata_symmetric_gather_*`.
///
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
) -> cata_status {
    // SAFETY: clause `memory` (`c`, n x n), clause `passed on` (`collective`).
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

/// Implements `cata_symmetric_verify_*`.
///
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
) -> cata_status {
    // SAFETY: clause `memory` (`a`, `rows` x `cols`; `passed`, one value; `residual`, one value;
    // `tolerance`, one value), clause `passed on` (`collective`).
    unsafe {
        collective(world, Operation::Verify, |entrance| {
            let symmetric = of_world::<T>(symmetric, entrance.world)?;
            let a = matrix("a", Layout::new(layout)?, rows, cols, a, lda)?;
            let a = match spread {
                CATA_BY_ROWS => Distributed::Rows(a),
                CATA_BY_COLUMNS => Distributed::Columns(a),
                other => {
                    let any = "CATA_BY_ROWS (141) or CATA_BY_COLUMNS (142)";
                    return Err(Failure::argument("spread", any, other));
                }
            };
            if !(1..=1000).contains(&rounds) {
                return Err(Failure::argument("rounds", "1 to 1000", rounds));
            }
            let passed = output("passed", passed)?;
            let residual = optional_output("residual", residual)?;
            let tolerance = optional_output("tolerance", tolerance)?;
            let found = verify(entrance.enter(), alpha, a, symmetric, rounds as u32, seed)?;
            *passed = found.passed.into();
            put(residual, found.residual);
            put(tolerance, found.tolerance);
            Ok(())
        })
    }
}

/// Returns the matrix of a handle, if it has this precision and as many ranks as the world.
///
/// # Safety
/// NULL or alive.
unsafe fn of_world<'s, T: Held>(
    symmetric: *const cata_symmetric,
    world: &World,
) -> Result<&'s Symmetric<T>, Failure> {
    // SAFETY: clause `passed on` (`entries`).
    let Some(matrix) = T::held(unsafe { entries(symmetric) }?) else {
        let why = format!("symmetric: does not hold entries of type {}", T::NAME);
        return Err(Failure::new(CATA_ERR_ARGUMENT, why));
    };
    let (its, ranks) = (matrix.layout().ranks(), world.size());
    if its != ranks {
        let why = format!("symmetric: spread over {its} ranks, but the world has {ranks}");
        return Err(Failure::new(CATA_ERR_ARGUMENT, why));
    }
    Ok(matrix)
}
