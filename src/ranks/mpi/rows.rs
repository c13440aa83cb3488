//! Rows of A on every rank: local products, reduced and scattered chunk by chunk.

use std::cell::RefCell;
use std::ops::Range;

use faer::prelude::{IntoConst, ReborrowMut};
use faer::{MatMut, MatRef};

use super::digits::{PARTS, part_of, whole};
use super::memory::Buffer;
use super::reduction::Reduction;
use super::stream::joined_bounds;
use super::symmetric::Symmetric;
use super::world::{MpiReal, Operation, World, fact, flag, number_fact, scalar_fact};
use crate::base::{Error, Progress, Result, block_rows, reserved};
use crate::product::{AtaOptions, Uplo, ata_into, atb_into};
use crate::ranks::plan::{Chunks, TriangleLayout};
use crate::rows::{DenseRows, RowBounds, exact_sums};

/// Computes `C = alpha A^T A` where every rank has some `rows` of A, in any order and number,
/// possibly none.
///
/// Each rank sends and receives `(1 - 1/P) n (n + 1) / 2` words, in `ceil(log2 P)` messages for
/// every chunk of C, while it computes the next one. Rows are m_r x n with any strides; beside them
/// and its part of C a rank holds a few chunks of C, which for large n are less than a part.
/// `options.uplo` does not matter. The result depends, by rounding, on the number of ranks and on
/// the distribution of the rows.
///
/// On the exact path, which is used if the options request it, C has the same bytes for any number
/// of ranks and any distribution of the rows. The ranks agree on the bounds of the rows, and their
/// sums are integers ([`Accumulator::exact`](crate::rows::Accumulator::exact)), which are added in
/// parts of 32 bits, at five times the traffic of f64.
///
/// ```no_run
/// use catamaran::ranks::{World, ata_rows};
/// use catamaran::{AtaOptions, Uplo, faer::Mat};
///
/// let start = mpi::initialize_with_threading(mpi::Threading::Funneled);
/// let (universe, _) = start.expect("MPI is started once");
/// let world = World::new(&universe.world())?;
/// // Every rank has 100 rows.
/// let own = Mat::<f64>::from_fn(100, 8, |i, j| (world.rank() + i * j % 7) as f64);
/// let result = ata_rows(&world, 1.0, own.as_ref(), &AtaOptions::new())?;
/// assert_eq!(result.n(), 8);
/// // All of C on rank 0.
/// let mut c = (world.rank() == 0).then(|| Mat::zeros(8, 8));
/// result.gather(&world, 0, c.as_mut().map(|c| c.as_mut()), Uplo::Both)?;
/// # Ok::<(), catamaran::Error>(())
/// ```
///
/// # Errors
/// [`Error::Rank`] when n, alpha or the precision differ, or another rank failed; else as
/// [`ata_into`].
pub fn ata_rows<T: MpiReal>(
    world: &World,
    alpha: T,
    rows: MatRef<'_, T>,
    options: &AtaOptions<'_>,
) -> Result<Symmetric<T>> {
    let _guard = world.abort_on_panic();
    let n = rows.ncols();
    let exact = flag("the exact path", options.asks_for_exact());
    let facts = [fact("n", n), scalar_fact::<T>(), number_fact("alpha", alpha), exact];
    world.begin(Operation::Rows, &facts, Ok(()))?;
    let m = world.gather_numbers(rows.nrows()).iter().sum();
    let chunks = Chunks::new(m, n, world.size());
    if options.asks_for_exact() {
        return reduce_exact(world, alpha, rows, chunks, options);
    }
    let panel = Buffer::<T>::of_len(chunks.longest_panel());
    reduce(world, chunks, panel, |panel, span, meanwhile| {
        let panel = &mut panel[..span.len() * span.end];
        let mut panel = MatMut::from_row_major_slice_mut(panel, span.len(), span.end);
        let share = |rows: usize| (rows as f64 / n as f64).powi(2);
        world.with_progress(options, share(span.start)..share(span.end), meanwhile, |options| {
            panel_product(alpha, rows, span, panel.rb_mut(), options)
        })?;
        Ok(panel.into_const())
    })
}

/// Computes the sum over the ranks of their symmetric matrices `c`, n x n, of which the lower
/// triangles are read.
///
/// ```no_run
/// use catamaran::{faer::Mat, ranks::{World, sum_symmetric}};
///
/// # let start = mpi::initialize_with_threading(mpi::Threading::Funneled);
/// # let (universe, _) = start.expect("MPI is started once");
/// # let world = World::new(&universe.world())?;
/// let result = sum_symmetric(&world, Mat::<f64>::identity(8, 8).as_ref())?;
/// // The entries on the diagonal are the number of ranks.
/// assert!(result.entries().iter().all(|&x| x == 0.0 || x == world.size() as f64));
/// # Ok::<(), catamaran::Error>(())
/// ```
///
/// # Errors
/// [`Error::Rank`] when n or the precision differ, or another rank failed; [`Error::Shape`],
/// [`Error::OutOfMemory`].
pub fn sum_symmetric<T: MpiReal>(world: &World, c: MatRef<'_, T>) -> Result<Symmetric<T>> {
    let _guard = world.abort_on_panic();
    let n = c.ncols();
    let square = Error::check_shape("C", (n, n), c.shape());
    world.begin(Operation::Sum, &[fact("n", n), scalar_fact::<T>()], square)?;
    // Every rank has n rows of C.
    let chunks = Chunks::new(n * world.size(), n, world.size());
    reduce(world, chunks, Ok(c), |c, span, _| Ok(c.get(span.clone(), ..span.end)))
}

/// Sums the chunks over the ranks. `panel` computes the rows of the next chunk, up to the diagonal
/// and beyond, and calls its last argument from time to time.
fn reduce<T: MpiReal, S>(
    world: &World,
    chunks: Chunks,
    prepared: Result<S>,
    panel: impl for<'s> Fn(&'s mut S, Range<usize>, &dyn Fn() -> bool) -> Result<MatRef<'s, T>>,
) -> Result<Symmetric<T>> {
    let own = world.rank();
    let prepared = prepared
        .and_then(|state| Ok((state, Reduction::new(&chunks, own)?, reserved(chunks.len(own))?)));
    let (mut state, reduction, mut entries) = world.agree(prepared)?;

    // The reduction of a chunk continues while the next one is computed.
    let reduction = RefCell::new(reduction);
    let advance = || {
        reduction.borrow_mut().advance(world);
        false
    };
    let mut done = Ok(());
    for chunk in 0..chunks.count() {
        // A rank that fails continues with unspecified entries, so that no rank waits for it.
        let computed = match &done {
            Ok(()) => panel(&mut state, chunks.rows(chunk), &advance).map(Some),
            Err(_) => Ok(None),
        };
        let mut reduction = reduction.borrow_mut();
        entries.extend_from_slice(reduction.finish(world));
        match computed {
            Ok(Some(rows)) => reduction.fill(chunk, rows),
            Ok(None) => {}
            Err(e) => done = Err(e),
        }
        reduction.start(world, chunk);
    }
    entries.extend_from_slice(reduction.borrow_mut().finish(world));
    drop(reduction);
    world.agree(done)?;
    Ok(Symmetric::new(TriangleLayout::Chunks(chunks), own, entries))
}

/// Computes [`ata_rows`] in integers.
fn reduce_exact<T: MpiReal>(
    world: &World,
    alpha: T,
    rows: MatRef<'_, T>,
    chunks: Chunks,
    options: &AtaOptions<'_>,
) -> Result<Symmetric<T>> {
    let (own, n) = (world.rank(), rows.ncols());
    let height = block_rows::<T>(n, false);
    let quiet = options.clone().progress(Progress::none());
    let bounds = RowBounds::<T>::of(&mut DenseRows(rows), None, height, &quiet);
    let bounds = joined_bounds(world, &world.agree(bounds)?)?;
    let memory = Buffer::<f64>::of_len(chunks.longest_panel())
        .and_then(|panel| Ok((panel, Reduction::<f64>::new(&chunks, own)?)))
        .and_then(|(panel, reduction)| Ok((panel, reduction, reserved(chunks.len(own))?)));
    let (mut panel, mut reduction, mut entries) = world.agree(memory)?;
    let mut done = Ok(());
    for chunk in 0..chunks.count() {
        let span = chunks.rows(chunk);
        let share = |rows: usize| (rows as f64 / n.max(1) as f64).powi(2);
        // A rank that fails continues with zeros, so that no rank waits for it.
        let sums = match &done {
            Ok(()) => {
                let share = share(span.start)..share(span.end);
                world.with_progress(options, share, &|| false, |options| {
                    exact_sums(&mut DenseRows(rows), &bounds, span.clone(), options)
                })
            }
            Err(_) => Err(Error::Cancelled),
        };
        let mut sums_of_own = vec![[0.0; PARTS]; chunks.entries(chunk, own).len()];
        for part in 0..PARTS {
            if let Ok(sums) = &sums {
                let memory = &mut panel[..span.len() * span.end];
                let mut panel = MatMut::from_row_major_slice_mut(memory, span.len(), span.end);
                for i in span.clone() {
                    for j in 0..=i {
                        panel[(i - span.start, j)] = part_of(sums.entry(i, j), part);
                    }
                }
                reduction.fill(chunk, panel.into_const());
            }
            reduction.start(world, chunk);
            for (parts, &sum) in sums_of_own.iter_mut().zip(reduction.finish(world)) {
                parts[part] = sum;
            }
        }
        if let Ok(sums) = &sums {
            let places = chunks.segments_of(chunk, own);
            let places = places.flat_map(|s| s.cols.map(move |j| (s.row, j)));
            for ((i, j), parts) in places.zip(&sums_of_own) {
                let (c, flags) = whole(parts);
                entries.push(T::from_f64(alpha.to_f64() * sums.value(i, j, c, flags)));
            }
        }
        done = done.and(sums.map(drop));
    }
    drop(reduction);
    world.agree(done)?;
    Ok(Symmetric::new(TriangleLayout::Chunks(chunks), own, entries))
}

/// Computes rows `span` of `alpha A^T A`, up to the diagonal; beyond it the panel is not touched.
fn panel_product<T: MpiReal>(
    alpha: T,
    a: MatRef<'_, T>,
    span: Range<usize>,
    panel: MatMut<'_, T>,
    options: &AtaOptions<'_>,
) -> Result<()> {
    let left = a.subcols(span.start, span.len());
    let (before, diagonal) = panel.split_at_col_mut(span.start);
    if span.start > 0 {
        atb_into(alpha, left, a.subcols(0, span.start), T::ZERO, before, options)?;
    }
    ata_into(alpha, left, T::ZERO, diagonal, &AtaOptions { uplo: Uplo::Lower, ..options.clone() })
}
