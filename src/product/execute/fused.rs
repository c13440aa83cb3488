//! Products on our own kernels, whose additions are made while packing and writing.

use std::sync::Mutex;

use faer::prelude::{Reborrow, ReborrowMut};
use faer::{MatMut, MatRef};

use super::balance::Balance;
use super::product::Product;
use super::tasks::partial;
use crate::base::{Arena, Par, Result, Tracker, tickets};
use crate::blas::BlasReal;
use crate::kernel::packed::{self, Destination, Job, Part, Source};
use crate::product::combine::{accumulate, accumulate_lower};
use crate::product::options::AtaOptions;
use crate::product::plan::{Fused, FusedProduct, Problem, SignedBlock, Slab};

/// Products of scalars that are computed before another thread has woken up.
const WORK_OF_ONE_THREAD: f64 = 4e6;

/// Returns the elements of scratch that [`execute`] needs.
pub(super) fn scratch_len<T: BlasReal>(plan: &Fused, problem: &Problem, par: Par) -> usize {
    match plan.slabs.len() {
        1 => slab_scratch_len::<T>(plan, par.threads()),
        slabs => {
            let partials = (slabs - 1) * problem.n * problem.k;
            partials + par.at_most(slabs).threads() * slab_scratch_len::<T>(plan, 1)
        }
    }
}

/// Returns the elements of scratch that one slab needs on so many threads.
fn slab_scratch_len<T: BlasReal>(plan: &Fused, threads: usize) -> usize {
    let geometry = T::kernel(plan.isa).geometry();
    let of_program = |program: &Vec<FusedProduct>| {
        let shapes = program.iter().map(|p| p.shape);
        packed::scratch_len::<T>(geometry, shapes, plan.budget, threads)
    };
    let of_slab = |slab: &Slab| of_program(&slab.program).max(of_program(&slab.classical));
    plan.slabs.iter().map(of_slab).max().unwrap_or(0)
}

/// Computes `product`; only its lower triangle is touched where the problem is symmetric.
#[inline(never)]
pub(super) fn execute<T: BlasReal>(
    plan: &Fused,
    problem: &Problem,
    product: Product<'_, T>,
    options: &AtaOptions<'_>,
    scratch: &mut [T],
) -> Result<()> {
    let Product { alpha, a, b, beta, mut c, .. } = product;
    let sides = [a, b.unwrap_or(a)];
    let (scales, classical) = match plan.is_fast() {
        true => balance(a, b, options.par),
        // Classical products have componentwise bounds whatever the scales of the columns.
        false => (None, false),
    };
    let program = |i: usize| -> &[FusedProduct] {
        let slab = &plan.slabs[i];
        if classical && !slab.classical.is_empty() { &slab.classical } else { &slab.program }
    };
    let slabs = plan.slabs.len();
    let symmetric = problem.op.symmetric();
    let work: f64 = (0..slabs).flat_map(program).map(|p| p.work(symmetric)).sum();
    let par = if work < WORK_OF_ONE_THREAD { Par::Seq } else { options.par };
    let tracker = Tracker::new(options.progress, work);
    let kernel = T::kernel(plan.isa);
    let slab = |i: usize, beta, c: MatMut<'_, T>, par, scratch: &mut [T]| {
        let rows = &plan.slabs[i].rows;
        let sides = sides.map(|matrix| matrix.subrows(rows.start, rows.len()));
        let part = if symmetric { Part::Lower } else { Part::All };
        let products = bind(program(i), part, alpha, sides, scales.as_ref(), beta, c);
        let job = Job { kernel, products: &products, budget: plan.budget, progress: &tracker };
        // SAFETY: the targets are of `c`, which is borrowed mutably for this call.
        unsafe { packed::run(&job, par, scratch) };
    };
    if slabs == 1 {
        slab(0, beta, c, par, scratch);
        return tracker.finish();
    }
    let mut arena = Arena::new(scratch);
    let row_major = c.col_stride() == 1;
    let mut results = vec![Mutex::new((beta, c.rb_mut()))];
    for _ in 1..slabs {
        let zero = partial(arena.take(problem.n * problem.k), problem, row_major);
        results.push(Mutex::new((T::ZERO, zero)));
    }
    let worker_len = slab_scratch_len::<T>(plan, 1);
    let mut workers: Vec<_> =
        (0..par.at_most(slabs).threads()).map(|_| arena.take(worker_len)).collect();
    tickets(&mut workers, slabs, |scratch, i| {
        let mut result = results[i].lock().expect("one slab, one lock");
        let (beta, c) = &mut *result;
        slab(i, *beta, c.rb_mut(), Par::Seq, scratch);
        tracker.state()
    });
    tracker.finish()?;
    let mut results = results.into_iter().map(|r| r.into_inner().expect("no panic").1);
    let Some(mut sum) = results.next() else { return Ok(()) };
    for result in results {
        if symmetric {
            accumulate_lower(sum.rb_mut(), T::ONE, T::ONE, result.rb());
        } else {
            accumulate(sum.rb_mut(), T::ONE, T::ONE, result.rb());
        }
    }
    Ok(())
}

/// Powers of two for the columns of A, or of B.
struct Scales<T> {
    /// The factors of the columns while they are packed.
    factors: Vec<T>,
    /// The divisors of their products: the same, except for columns of zeros, whose products become
    /// zero this way.
    divisors: Vec<T>,
}

impl<T: BlasReal> Scales<T> {
    fn new(balance: &Balance, columns: usize) -> Self {
        let Balance::Uneven(exponents) = balance else {
            return Self { factors: vec![T::ONE; columns], divisors: vec![T::ONE; columns] };
        };
        let power = |e: i32| T::from_f64(f64::from(e).exp2());
        let of = |zero: f64| {
            exponents.iter().map(|e| e.map_or(T::from_f64(zero), power)).collect::<Vec<_>>()
        };
        Self { factors: of(1.0), divisors: of(f64::INFINITY) }
    }
}

/// Returns the scales that fast levels need, if any, and whether to avoid such levels.
fn balance<T: BlasReal>(
    a: MatRef<'_, T>,
    b: Option<MatRef<'_, T>>,
    par: Par,
) -> (Option<[Scales<T>; 2]>, bool) {
    let left = Balance::of(a, par);
    let right = b.map(|b| (Balance::of(b, par), b.ncols()));
    let of_right = right.as_ref().map_or(&left, |(balance, _)| balance);
    match (&left, of_right) {
        (Balance::NotFinite, _) | (_, Balance::NotFinite) => (None, true),
        (Balance::Even, Balance::Even) => (None, false),
        _ => {
            let k = right.as_ref().map_or(a.ncols(), |(_, k)| *k);
            (Some([Scales::new(&left, a.ncols()), Scales::new(of_right, k)]), false)
        }
    }
}

/// Binds the products of `program` to matrices.
fn bind<'a, T: BlasReal>(
    program: &[FusedProduct],
    part: Part,
    alpha: T,
    [a, b]: [MatRef<'a, T>; 2],
    scales: Option<&'a [Scales<T>; 2]>,
    beta: T,
    c: MatMut<'_, T>,
) -> Vec<packed::KernelProduct<'a, T>> {
    // Tiles are written by rows.
    let by_columns = c.row_stride() == 1 && c.col_stride() != 1;
    let destination = Destination::new(c, part);
    let destination = match scales {
        Some([left, right]) => destination.unscaling(&left.divisors, &right.divisors),
        None => destination,
    };
    let sources = |blocks: &[SignedBlock], matrix: MatRef<'a, T>, side: usize| {
        let source = |b: &SignedBlock| Source {
            coefficient: T::from_f64(f64::from(b.coefficient)),
            matrix: matrix.submatrix(b.rows.start, b.cols.start, b.rows.len(), b.cols.len()),
            scale: scales.map(|s| &s[side].factors[b.cols.clone()]),
        };
        blocks.iter().map(source).collect()
    };
    let target = |o: &SignedBlock| {
        let coefficient = alpha * T::from_f64(f64::from(o.coefficient));
        let beta = if o.first { beta } else { T::ONE };
        destination.block(o.rows.clone(), o.cols.clone(), coefficient, beta)
    };
    let product = |p: &FusedProduct| {
        let product = packed::KernelProduct {
            left: sources(&p.left, a, 0),
            right: sources(&p.right, b, 1),
            targets: p.outputs.iter().map(target).collect(),
            shape: p.shape,
        };
        if by_columns { product.transposed() } else { product }
    };
    program.iter().map(product).collect()
}
