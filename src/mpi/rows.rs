//! Rows of A on every rank: local products, reduced and scattered chunk by chunk.

use std::cell::RefCell;
use std::ops::Range;

use faer::prelude::{IntoConst, ReborrowMut};
use faer::{MatMut, MatRef};

use super::reduction::Reduction;
use super::symmetric::Symmetric;
use super::world::{MpiReal, Operation, World, number_fact, scalar_fact};
use crate::ata::distributed::{Chunks, Layout};
use crate::ata::{AtaOptions, Uplo, ata, atb};
use crate::base::{Error, Result, Workspace, reserved};

/// `C = alpha A^T A` where every rank has some `rows` of A, in any order and number, 0 included.
///
/// Each rank sends and receives `(1 - 1/P) n (n + 1) / 2` words, in `ceil(log2 P)` messages for every chunk of C,
/// while it computes the next one. Rows are m_r x n with any strides; beside them and its part of C
/// a rank holds a few chunks of C, which for large n are less than a part. `options.uplo` does not matter.
/// The result depends, by rounding, on the number of ranks and on which rank has which rows.
///
/// # Errors
/// [`Error::Rank`] when n, alpha or the precision differ, or another rank failed; else as [`ata`].
pub fn ata_rows<T: MpiReal>(
    world: &World,
    alpha: T,
    rows: MatRef<'_, T>,
    options: &AtaOptions<'_>,
) -> Result<Symmetric<T>> {
    let _guard = world.abort_on_panic();
    let n = rows.ncols();
    let facts = [("n", n), scalar_fact::<T>(), number_fact("alpha", alpha)];
    world.begin(Operation::Rows, &facts, Ok(()))?;
    let m = world.gather_numbers(rows.nrows()).iter().sum();
    let chunks = Chunks::new(m, n, world.size());
    let panel = Workspace::<T>::new(chunks.longest_panel());
    reduce(world, chunks, panel, |panel, span, meanwhile| {
        let panel = &mut panel.as_mut_slice()[..span.len() * span.end];
        let mut panel = MatMut::from_row_major_slice_mut(panel, span.len(), span.end);
        let share = |rows: usize| (rows as f64 / n as f64).powi(2);
        world.with_progress(options, share(span.start)..share(span.end), meanwhile, |options| {
            panel_product(alpha, rows, span, panel.rb_mut(), options)
        })?;
        Ok(panel.into_const())
    })
}

/// The sum over the ranks of their symmetric matrices `c`, n x n, of which the lower triangles are read.
///
/// # Errors
/// [`Error::Rank`] when n or the precision differ, or another rank failed; [`Error::Shape`],
/// [`Error::OutOfMemory`].
pub fn sum_symmetric<T: MpiReal>(world: &World, c: MatRef<'_, T>) -> Result<Symmetric<T>> {
    let _guard = world.abort_on_panic();
    let n = c.ncols();
    let square = Error::check_shape("C", (n, n), c.shape());
    world.begin(Operation::Sum, &[("n", n), scalar_fact::<T>()], square)?;
    // Every rank has n rows of C.
    let chunks = Chunks::new(n * world.size(), n, world.size());
    reduce(world, chunks, Ok(c), |c, span, _| Ok(c.get(span.clone(), ..span.end)))
}

/// Sums the chunks over the ranks: `panel` gives the rows of the next one, up to the diagonal and beyond, and
/// calls its last argument now and then.
fn reduce<T: MpiReal, S>(
    world: &World,
    chunks: Chunks,
    prepared: Result<S>,
    panel: impl for<'s> Fn(&'s mut S, Range<usize>, &dyn Fn()) -> Result<MatRef<'s, T>>,
) -> Result<Symmetric<T>> {
    let own = world.rank();
    let prepared = prepared
        .and_then(|state| Ok((state, Reduction::new(&chunks, own)?, reserved(chunks.len(own))?)));
    let (mut state, reduction, mut entries) = world.agree(prepared)?;

    // The reduction of a chunk goes on while the next one is computed.
    let reduction = RefCell::new(reduction);
    let advance = || reduction.borrow_mut().advance(world);
    let mut done = Ok(());
    for chunk in 0..chunks.count() {
        // A rank that fails goes on with whatever it has, so that nobody waits for it.
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
    Ok(Symmetric::new(Layout::Chunks(chunks), own, entries))
}

/// Rows `span` of `alpha A^T A`, up to the diagonal; beyond it the panel is not touched.
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
        atb(alpha, left, a.subcols(0, span.start), T::ZERO, before, options)?;
    }
    ata(alpha, left, T::ZERO, diagonal, &AtaOptions { uplo: Uplo::Lower, ..options.clone() })
}
