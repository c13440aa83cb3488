//! The exact path: A^T B in integers modulo small primes, as exact as its inputs' rounding to 55 bits.
//!
//! Columns are scaled by powers of two and rounded to integers, products are computed modulo N numbers
//! of 8 bits by the byte instructions of the CPU, and the Chinese remainder theorem gives the products
//! back ("Ozaki scheme II", Ozaki, Uchino and Imamura 2025, here for symmetric products on CPUs). Everything
//! between the two roundings is exact, so that the result is the same bytes for any number of threads, any
//! order of blocks and any instruction set. See docs/algorithms/exact.md.

mod columns;
mod lanes;
mod layout;
mod non_finite;
mod product;
mod store;
#[cfg(test)]
mod tests;

use std::sync::Mutex;
use std::sync::atomic::{AtomicUsize, Ordering};

use faer::prelude::ReborrowMut;
use faer::{MatMut, MatRef};

use self::columns::Columns;
use self::lanes::Shared;
use self::layout::Unit;
use self::product::{Lane, Round, Target};
use self::store::Residents;
use super::combine::{scale, scale_lower};
use super::exec::{Blocks, Tracker};
use super::options::AtaOptions;
use crate::base::{Arena, Error, Par, Real, Result};
use crate::kernel::int8::{Block, Instance, Kernel, Moduli, Operand, PANEL, Slice};

pub(crate) use self::layout::Layout;

/// Expected seconds on one core.
pub(crate) fn estimate(
    instance: Instance,
    [m, n, k]: [usize; 3],
    moduli: usize,
    symmetric: bool,
) -> f64 {
    let rates = instance.rates();
    let [m, n, k] = [m, n, k].map(|side| side.max(1) as f64);
    let entries = if symmetric { n * (n + PANEL as f64) / 2.0 } else { n * k };
    let operands = if symmetric { m * n } else { m * (n + k) };
    let moduli = moduli as f64;
    // Short products pay for the sums' way in and out of the registers.
    let products = entries * (m + 64.0) / rates.products;
    moduli * (products + operands / rates.conversions + entries / rates.recombinations)
}

/// Elements of scratch that [`execute`] needs.
pub(crate) fn scratch_len<T: Operand>(
    [m, n, k]: [usize; 3],
    layout: &Layout,
    threads: usize,
) -> usize {
    let norms = columns::scratch_len::<T>(m, n).max(columns::scratch_len::<T>(m, k));
    let slices: usize = layout.stores().iter().map(|bytes| slices_len::<T>(*bytes)).sum();
    let kept = Arena::<T>::len_of::<Block<i8>>(kept_blocks(layout));
    let lanes = Lane::scratch_len::<T>(layout) * lanes(layout, threads);
    // The norms are done with before the rest is needed.
    norms.max(slices + kept + lanes)
}

fn slices_len<T: Real>(bytes: usize) -> usize {
    Arena::<T>::len_of::<Slice>(bytes / size_of::<Slice>())
}

/// Blocks of residues kept between the chunks of a round.
fn kept_blocks(layout: &Layout) -> usize {
    if layout.accumulates() { layout.moduli * layout.largest_round() } else { 0 }
}

/// Threads that can be busy with products.
fn lanes(layout: &Layout, threads: usize) -> usize {
    let blocks = |panels: usize, size: usize| panels.div_ceil(layout.groups).div_ceil(size);
    let units = blocks(layout.left, layout.block.0) * blocks(layout.right, layout.block.1);
    threads.min(units * if layout.accumulates() { layout.moduli } else { 1 }).max(1)
}

/// `C := alpha A^T B + beta C`; B is `None` for A^T A, and only the lower triangle is touched where the
/// layout is symmetric.
pub(crate) fn execute<T: Operand>(
    kernel: &dyn Kernel,
    layout: &Layout,
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
    let moduli = &Moduli::new(layout.moduli);
    let mut arena = Arena::new(scratch);
    let of_a = Columns::new(kernel, a, moduli, options.par, &mut arena);
    let of_b = b.map(|b| Columns::new(kernel, b, moduli, options.par, &mut arena));
    let left = (a, &of_a);
    let right = (b.unwrap_or(a), of_b.as_ref().unwrap_or(&of_a));
    let mut residents =
        Residents::new(layout.stores().map(|bytes| arena.take_as(bytes / size_of::<Slice>())));
    let kept: &mut [Block<i8>] = arena.take_as(kept_blocks(layout));
    let kept = &Shared::new(kept);
    let lanes: Vec<_> = (0..lanes(layout, options.par.threads()))
        .map(|_| Mutex::new(Lane::new(&mut arena, layout)))
        .collect();
    let par = Par::Threads(lanes.len());

    let target = Target { alpha, beta, moduli, left: left.1, right: right.1, symmetric };
    let pairs = layout.pairs();
    let cost: usize = pairs.iter().flat_map(|&p| layout.units(p)).map(|u| layout.cost(&u)).sum();
    let progress = Tracker::new(options, (cost * layout.steps * moduli.len()) as f64);
    let destination = Blocks::new(c.rb_mut());
    for pair in pairs {
        let units = layout.units(pair);
        for chunk in layout.chunks() {
            let continued = chunk.start > 0;
            let [left, right] =
                residents.load(layout, pair, chunk.clone(), |store, need, extent| {
                    let (matrix, columns) = if need.operand == 0 { left } else { right };
                    store.fill(kernel, matrix, columns, moduli, extent, options.par);
                });
            let round = Round { kernel, layout, moduli, left, right, continued };
            let done = |unit: &Unit, moduli: usize| {
                progress.add((layout.cost(unit) * chunk.len() * moduli) as f64);
            };
            if layout.accumulates() {
                let count = units.len() * moduli.len();
                each(&lanes, par, count, &progress, |lane, i| {
                    let (l, unit) = (i / units.len(), &units[i % units.len()]);
                    let place = |i, j| l * layout.largest_round() + layout.place(pair, i, j);
                    // SAFETY: a pair of panels is in one unit, and each unit is taken once for each modulus.
                    unsafe { round.multiply(unit, l, lane.left, lane.sums, kept, place) };
                    done(unit, 1);
                });
            } else {
                each(&lanes, par, units.len(), &progress, |lane, i| {
                    let unit = &units[i];
                    let residues = &Shared::new(&mut *lane.residues);
                    let place = |l: usize| {
                        move |i: usize, j: usize| {
                            let (rows, cols) = (unit.rows.len(), unit.cols.len());
                            (l * cols + j - unit.cols.start) * rows + i - unit.rows.start
                        }
                    };
                    for l in 0..moduli.len() {
                        // SAFETY: the residues are this thread's own.
                        unsafe {
                            round.multiply(unit, l, lane.left, lane.sums, residues, place(l))
                        };
                    }
                    // SAFETY: nobody writes the residues now; blocks of C are in one unit each.
                    unsafe { write(&target, kernel, layout, unit, residues, place, &destination) };
                    done(unit, moduli.len());
                });
            }
            if progress.cancelled() {
                return Err(Error::Cancelled);
            }
        }
        if layout.accumulates() {
            each(&lanes, par, units.len(), &progress, |_, i| {
                let place = |l: usize| {
                    move |i: usize, j: usize| l * layout.largest_round() + layout.place(pair, i, j)
                };
                // SAFETY: nobody writes the residues now; blocks of C are in one unit each.
                unsafe { write(&target, kernel, layout, &units[i], kept, place, &destination) };
            });
        }
    }
    non_finite::add(alpha, left, right, symmetric, c);
    Ok(())
}

/// Calls `work` for `0..count`, each once, from as many threads as there are lanes.
fn each<'a>(
    lanes: &[Mutex<Lane<'a>>],
    par: Par,
    count: usize,
    progress: &Tracker<'_>,
    work: impl Fn(&mut Lane<'a>, usize) + Sync,
) {
    let next = AtomicUsize::new(0);
    par.run_lanes(|lane| {
        let mut lane = lanes[lane].lock().expect("one lane, one lock");
        loop {
            let i = next.fetch_add(1, Ordering::Relaxed);
            if i >= count || progress.cancelled() {
                return;
            }
            work(&mut lane, i);
        }
    });
}

/// Writes a block of C from its residues, those of panels (i, j) modulo the l-th number at `place(l)(i, j)`.
///
/// # Safety
/// Nobody writes the residues, and nobody uses the block of C, meanwhile.
unsafe fn write<T: Operand, P: Fn(usize, usize) -> usize>(
    target: &Target<'_, T>,
    kernel: &dyn Kernel,
    layout: &Layout,
    unit: &Unit,
    residues: &Shared<'_, Block<i8>>,
    place: impl Fn(usize) -> P,
    destination: &Blocks<'_, T>,
) {
    for j in unit.cols.clone() {
        for i in layout.first_row(unit, j)..unit.rows.end {
            // SAFETY: the caller's promise.
            let residues = |l: usize| unsafe {
                let at = place(l)(i, j);
                &residues.slice(at..at + 1)[0]
            };
            let (rows, cols) = (panel(i, destination.nrows()), panel(j, destination.ncols()));
            // SAFETY: the caller's promise; blocks of different panels are disjoint.
            let c = unsafe { destination.block(rows, cols) };
            target.write(kernel, (i, j), residues, c);
        }
    }
}

/// The rows or columns of panel `i` among `count`.
fn panel(i: usize, count: usize) -> std::ops::Range<usize> {
    i * PANEL..count.min((i + 1) * PANEL)
}
