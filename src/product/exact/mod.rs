//! The exact path: A^T B in integers modulo small coprime numbers, as exact as its inputs' rounding
//! to 55 bits.
//!
//! Columns are scaled by powers of two and rounded to integers, products are computed modulo N
//! numbers of 8 bits by the byte instructions of the CPU, and the Chinese remainder theorem gives
//! the products back ("Ozaki scheme II", Ozaki, Uchino and Imamura 2025, here for symmetric
//! products on CPUs). Everything between the two roundings is exact, so that the result is the same
//! bytes for any number of threads, any order of blocks and any instruction set. See
//! docs/algorithms/exact.md.

mod blocking;
mod columns;
mod job;
mod layout;
mod non_finite;
mod product;
mod sink;
pub(crate) mod small;
mod store;
#[cfg(test)]
mod tests;

use faer::prelude::ReborrowMut;
use faer::{MatMut, MatRef};

use self::job::Job;
use self::product::{Round, Worker};
use self::sink::{Floats, Integers, Sink};
use self::store::Residents;
use super::combine::{scale, scale_lower};
use super::options::AtaOptions;
use crate::base::{Arena, Disjoint, Par, Real, Result, Tracker};
use crate::kernel::int8::{
    Integer, IntegerIsa, IntegerModuli, IntegerOperand, Kernel, Moduli, Modulus, PANEL, PanelBlock,
    Slice,
};

pub(crate) use self::columns::Columns;
pub(crate) use self::layout::ExactLayout;
pub(crate) use self::non_finite::{Flags, Signs};
pub(crate) use self::sink::TriangleRows;

/// Returns the expected seconds on one core, if each operand is converted `conversions` times.
pub(crate) fn estimate(
    isa: IntegerIsa,
    [m, n, k]: [usize; 3],
    moduli: usize,
    symmetric: bool,
    conversions: f64,
) -> f64 {
    let rates = isa.rates();
    let [m, n, k] = [m, n, k].map(|side| side.max(1) as f64);
    let entries = if symmetric { n * (n + PANEL as f64) / 2.0 } else { n * k };
    let operands = if symmetric { m * n } else { m * (n + k) };
    let (moduli, converted) = (moduli as f64, conversions * operands);
    /// Seconds that do not grow with the operands.
    const START: f64 = 3e-4;
    // Short products pay for loading and storing the sums.
    let products = entries * (m + 64.0) / rates.products;
    START + moduli * (products + converted / rates.conversions + entries / rates.recombinations)
}

/// Returns the elements of scratch that [`execute`] needs.
pub(crate) fn scratch_len<T: IntegerOperand>(
    [m, n, k]: [usize; 3],
    layout: &ExactLayout,
    threads: usize,
) -> usize {
    let layout = &layout.for_threads(threads);
    let norms = columns::scratch_len::<T>(m, n).max(columns::scratch_len::<T>(m, k));
    let slices = layout.stores().map(slices_len::<T>).into_iter().fold(0, usize::saturating_add);
    let batch = Arena::<T>::len_of::<PanelBlock<i8>>(batch_blocks(layout));
    let workers = Worker::scratch_len::<T>(layout) * workers(layout, threads);
    // The memory of the norms is free again when the rest is needed.
    norms.max(slices.saturating_add(batch).saturating_add(workers))
}

fn slices_len<T: Real>(bytes: usize) -> usize {
    Arena::<T>::len_of::<Slice>(bytes / size_of::<Slice>())
}

/// Returns the blocks of residues that there is room for in the largest batch.
fn batch_blocks(layout: &ExactLayout) -> usize {
    let (_, places) = layout.largest_batch();
    layout.moduli * places
}

/// Returns how many threads can be busy with products.
fn workers(layout: &ExactLayout, threads: usize) -> usize {
    let (units, _) = layout.largest_batch();
    threads.min(layout.moduli * units).max(1)
}

/// Computes `C := alpha A^T B + beta C`; B is `None` for A^T A, and only the lower triangle is
/// touched where the layout is symmetric.
pub(crate) fn execute<T: IntegerOperand>(
    kernel: &dyn Kernel,
    layout: &ExactLayout,
    alpha: T,
    a: MatRef<'_, T>,
    b: Option<MatRef<'_, T>>,
    beta: T,
    mut c: MatMut<'_, T>,
    options: &AtaOptions<'_>,
    scratch: &mut [T],
) -> Result<()> {
    let symmetric = layout.symmetric;
    if a.nrows() == 0 || alpha == T::ZERO {
        if symmetric {
            scale_lower(c, beta)
        } else {
            scale(c, beta)
        }
        return Ok(());
    }
    let par = options.par;
    let layout = &layout.for_threads(par.threads());
    let moduli = Moduli::of(layout.moduli);
    let mut arena = Arena::new(scratch);
    let mut columns = |m| Columns::new(kernel, m, moduli, par, &mut arena);
    let (of_a, of_b) = (columns(a), b.map(columns));
    let left = (a, &of_a);
    let right = (b.unwrap_or(a), of_b.as_ref().unwrap_or(&of_a));
    let signs = Signs::of_product(left, right, par)?;
    let sink = Floats {
        alpha,
        beta,
        moduli,
        left: left.1,
        right: right.1,
        symmetric,
        c: Disjoint::new(c.rb_mut()),
    };
    let more = signs.as_ref().map_or(0.0, |signs| signs.cost(symmetric));
    let progress = Tracker::new(options.progress, cost(layout) + more);
    let list = &moduli.list;
    multiply(kernel, layout, list, [left, right], sink, par, &progress, &mut arena);
    if let Some(signs) = signs {
        signs.add(alpha, symmetric, c, par, &progress);
    }
    progress.finish()
}

/// An operand of an integer product, and the powers of two that its columns are multiplied by
/// before they are rounded to integers.
pub(crate) type Scaled<'a, T> = (MatRef<'a, T>, &'a Columns);

/// Adds the integer product of `left^T right`, of finite entries, to the part of the triangle
/// `sums` that begins at `corner`, or subtracts it; of a symmetric layout only the lower triangle
/// of the product.
///
/// The caller ensures that all entries of the product are below P/2 ([`IntegerModuli::count_for`]),
/// and that sums do not overflow.
pub(crate) fn accumulate<T: IntegerOperand, I: Integer>(
    kernel: &dyn Kernel,
    layout: &ExactLayout,
    operands: [Scaled<'_, T>; 2],
    sums: &TriangleRows<'_, I>,
    corner: (usize, usize),
    subtract: bool,
    options: &AtaOptions<'_>,
    scratch: &mut [T],
) -> Result<()> {
    let layout = &layout.for_threads(options.par.threads());
    let moduli = &IntegerModuli::new(layout.moduli);
    let shape = (operands[0].0.ncols(), operands[1].0.ncols());
    let sink = Integers { moduli, sums, corner, shape, symmetric: layout.symmetric, subtract };
    let progress = Tracker::new(options.progress, cost(layout));
    let arena = &mut Arena::new(scratch);
    options.on_cores(|| {
        let list = &moduli.list;
        multiply(kernel, layout, list, operands, sink, options.par, &progress, arena);
    });
    progress.finish()
}

/// Returns the work that progress counts: products of panels, for each step and modulus.
fn cost(layout: &ExactLayout) -> f64 {
    layout.panel_pairs() as f64 * layout.steps as f64 * layout.moduli as f64
}

/// Passes the residues of `left^T right` to the sink, block by block, until a request to stop.
fn multiply<T: IntegerOperand>(
    kernel: &dyn Kernel,
    layout: &ExactLayout,
    moduli: &[Modulus],
    [left, right]: [Scaled<'_, T>; 2],
    sink: impl Sink,
    par: Par,
    progress: &Tracker<'_>,
    arena: &mut Arena<'_, T>,
) {
    let mut residents =
        Residents::new(layout.stores().map(|bytes| arena.take_as(bytes / size_of::<Slice>())));
    let residues: &mut [PanelBlock<i8>] = arena.take_as(batch_blocks(layout));
    let mut workers: Vec<_> =
        (0..workers(layout, par.threads())).map(|_| Worker::new(arena, layout)).collect();
    let job = Job { layout, sink, residues: Disjoint::of_slice(residues), progress };
    for pair in layout.pairs() {
        for batch in layout.batches(pair) {
            for chunk in layout.chunks() {
                let continued = chunk.start > 0;
                let [left, right] = residents.load(layout, pair, chunk, |store, need, extent| {
                    let (matrix, columns) = if need.operand == 0 { left } else { right };
                    store.fill(kernel, matrix, columns, moduli, extent, par);
                });
                let round = Round { kernel, layout, moduli, left, right, continued };
                job.multiply(&mut workers, &round, &batch);
                if progress.state().is_break() {
                    return;
                }
            }
            job.recombine(&mut workers, kernel, &batch);
        }
    }
}
