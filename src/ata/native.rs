//! Runs a [`Plan`] on the native kernels.

use std::ops::Range;
use std::sync::Mutex;

use faer::prelude::{Reborrow, ReborrowMut};
use faer::{MatMut, MatRef};

use super::combine::{accumulate, accumulate_lower};
use super::exec::partial;
use super::fused::{self, Block, FusedProduct};
use super::options::AtaOptions;
use super::plan::Plan;
use super::recurse::block_start;
use crate::base::{Arena, Par, Result, Tracker, tickets};
use crate::kernel::packed::{
    Destination, Isa, Job, Operand, Part, Product, Source, run, scratch_len,
};

/// The products of a plan, for one slab of its rows.
fn program(plan: &Plan, same: bool, rows: usize) -> Vec<FusedProduct> {
    fused::products(&plan.recursion, plan.op(same), rows, plan.n, plan.k)
}

/// Scalars that a packed chunk may take, of which there are two: with the sums of the threads less
/// than half of C, but what the third-level cache of a core holds at most, and a chunk that is worth
/// its while at least.
pub(crate) fn budget<T>(n: usize, k: usize) -> usize {
    const LEAST: usize = 256 << 10;
    const MOST: usize = 64 << 20;
    (n * k / 6).clamp(LEAST / size_of::<T>(), MOST / size_of::<T>())
}

/// Scalars of scratch that one slab needs on `lanes` threads.
fn slab_scratch_len<T: Operand>(isa: Isa, plan: &Plan, same: bool, lanes: usize) -> usize {
    let geometry = T::kernel(isa).geometry();
    let budget = budget::<T>(plan.n, plan.k);
    let len = |rows| {
        let program = program(plan, same, rows);
        scratch_len::<T>(geometry, program.iter().map(|p| p.shape), budget, lanes)
    };
    len(plan.m / plan.slabs).max(len(plan.m.div_ceil(plan.slabs)))
}

/// Scalars of scratch of [`execute`].
pub(crate) fn plan_scratch_len<T: Operand>(
    isa: Isa,
    plan: &Plan,
    same: bool,
    threads: usize,
) -> usize {
    if plan.slabs == 1 {
        return slab_scratch_len::<T>(isa, plan, same, threads);
    }
    let lanes = threads.min(plan.slabs);
    (plan.slabs - 1) * plan.n * plan.k + lanes * slab_scratch_len::<T>(isa, plan, same, 1)
}

/// `C := alpha A^T B + beta C` by `plan`; B is `None` for A^T A. Symmetric plans touch only the
/// lower triangle.
pub(crate) fn execute<T: Operand>(
    isa: Isa,
    plan: &Plan,
    alpha: T,
    a: MatRef<'_, T>,
    b: Option<MatRef<'_, T>>,
    beta: T,
    mut c: MatMut<'_, T>,
    options: &AtaOptions<'_>,
    scratch: &mut [T],
) -> Result<()> {
    let (slabs, same) = (plan.slabs, b.is_none());
    let rows = |i| block_start(plan.m, slabs, i)..block_start(plan.m, slabs, i + 1);
    let programs: Vec<_> = (0..slabs).map(|i| program(plan, same, rows(i).len())).collect();
    let work: f64 = programs.iter().flatten().map(|p| p.work(plan.symmetric)).sum();
    // Over before another thread has woken up.
    let par = if work < 4e6 { Par::Seq } else { options.par };
    let tracker = Tracker::new(options.progress, work);
    let kernel = T::kernel(isa);
    let budget = budget::<T>(plan.n, plan.k);
    let sides = [a, b.unwrap_or(a)];
    // Classical products have componentwise bounds whatever the scales of the columns.
    let scales = plan.is_fast().then(|| sides.map(Scales::of));
    let slab = |i: usize, beta, c: MatMut<'_, T>, par, scratch: &mut [T]| {
        let sides = sides.map(|matrix| sub_rows(matrix, rows(i)));
        let products = bind(plan, &programs[i], alpha, sides, scales.as_ref(), beta, c);
        let job = Job { kernel, products: &products, budget, progress: &tracker };
        // SAFETY: the targets are of `c`, which is borrowed mutably for this call.
        unsafe { run(&job, par, scratch) };
    };
    if slabs == 1 {
        slab(0, beta, c, par, scratch);
    } else {
        let mut arena = Arena::new(scratch);
        let (n, k, row_major) = (plan.n, plan.k, c.col_stride() == 1);
        let mut results = vec![Mutex::new((beta, c.rb_mut()))];
        for _ in 1..slabs {
            let zero = partial(arena.take(n * k), n, k, row_major);
            results.push(Mutex::new((T::ZERO, zero)));
        }
        let par = Par::Threads(par.threads().min(slabs));
        let lane_len = slab_scratch_len::<T>(isa, plan, same, 1);
        let mut workers: Vec<_> = (0..par.threads()).map(|_| arena.take(lane_len)).collect();
        tickets(&mut workers, slabs, |scratch, i| {
            let mut result = results[i].lock().expect("one slab, one lock");
            let (beta, c) = &mut *result;
            slab(i, *beta, c.rb_mut(), Par::Seq, scratch);
            tracker.state()
        });
        let mut results = results.into_iter().map(|r| r.into_inner().expect("no panic").1);
        let Some(mut sum) = results.next() else { return Ok(()) };
        for result in results {
            if plan.symmetric {
                accumulate_lower(sum.rb_mut(), T::ONE, T::ONE, result.rb());
            } else {
                accumulate(sum.rb_mut(), T::ONE, T::ONE, result.rb());
            }
        }
    }
    tracker.finish()
}

fn sub_rows<T>(matrix: MatRef<'_, T>, rows: Range<usize>) -> MatRef<'_, T> {
    matrix.subrows(rows.start, rows.len())
}

/// The products of `program` on matrices.
fn bind<'a, T: Operand>(
    plan: &Plan,
    program: &[FusedProduct],
    alpha: T,
    [a, b]: [MatRef<'a, T>; 2],
    scales: Option<&'a [Scales<T>; 2]>,
    beta: T,
    c: MatMut<'_, T>,
) -> Vec<Product<'a, T>> {
    // Tiles are written by rows.
    let by_columns = c.row_stride() == 1 && c.col_stride() != 1;
    let destination = Destination::new(c, if plan.symmetric { Part::Lower } else { Part::All });
    let destination = match scales {
        Some([left, right]) => destination.unscaling(&left.factors, &right.factors),
        None => destination,
    };
    let sources = |blocks: &[Block], matrix: MatRef<'a, T>, side: usize| {
        let source = |b: &Block| Source {
            coefficient: T::from_f64(f64::from(b.coefficient)),
            matrix: matrix.submatrix(b.rows.start, b.cols.start, b.rows.len(), b.cols.len()),
            scale: scales.map(|s| &s[side].factors[b.cols.clone()]),
        };
        blocks.iter().map(source).collect()
    };
    let target = |o: &Block| {
        let coefficient = alpha * T::from_f64(f64::from(o.coefficient));
        let beta = if o.first { beta } else { T::ONE };
        destination.block(o.rows.clone(), o.cols.clone(), coefficient, beta)
    };
    let product = |p: &FusedProduct| {
        let product = Product {
            left: sources(&p.left, a, 0),
            right: sources(&p.right, b, 1),
            targets: p.outputs.iter().map(target).collect(),
            shape: p.shape,
        };
        if by_columns { product.transposed() } else { product }
    };
    program.iter().map(product).collect()
}

/// Powers of two that bring the columns of a matrix to largest entries between 1 and 2.
struct Scales<T> {
    factors: Vec<T>,
}

impl<T: Operand> Scales<T> {
    fn of(matrix: MatRef<'_, T>) -> Self {
        let mut largest = vec![T::ZERO; matrix.ncols()];
        for i in 0..matrix.nrows() {
            for (j, most) in largest.iter_mut().enumerate() {
                let x = matrix[(i, j)].abs();
                if x > *most {
                    *most = x;
                }
            }
        }
        Self { factors: largest.into_iter().map(scale).collect() }
    }
}

/// The power of two that brings `largest` to between 1 and 2; 1 where there is nothing to scale. Far
/// from the limits of the exponent, so that neither the products nor their quotients leave the range.
fn scale<T: Operand>(largest: T) -> T {
    let largest = largest.to_f64();
    if largest == 0.0 || !largest.is_finite() {
        return T::ONE;
    }
    let most = if size_of::<T>() == 8 { 400 } else { 40 };
    T::from_f64((-largest.log2().floor()).clamp(-f64::from(most), f64::from(most)).exp2())
}
