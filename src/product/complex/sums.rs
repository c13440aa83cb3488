//! Sums of real products over blocks of complex rows.

use faer::complex::Complex;
use faer::prelude::{Reborrow, ReborrowMut};
use faer::{MatMut, MatRef};

use super::plan::{ComplexPlan, Kind};
use super::stack::Stack;
use crate::base::{Arena, Result, Scratch};
use crate::blas::BlasReal;
use crate::product::options::{AtaOptions, Uplo};
use crate::product::plan::Op;
use crate::product::{Product, execute};

/// The sums of two terms, n x k.
pub(super) struct Sums<'s, T> {
    pub re: MatRef<'s, T>,
    pub im: MatRef<'s, T>,
}

/// Sums the two terms of `plan` over all rows of A, m x n, and B, m x k, which is A when `None`,
/// block by block, and calls `finish` with the sums, whose rows are contiguous with `rows_first`,
/// else their columns.
///
/// Blocks and their order depend on the plan only, so that the result does not depend on threads.
pub(super) fn with_sums<T: BlasReal>(
    plan: &ComplexPlan,
    a: MatRef<'_, Complex<T>>,
    b: Option<MatRef<'_, Complex<T>>>,
    rows_first: bool,
    options: &AtaOptions<'_>,
    finish: impl FnOnce(Sums<'_, T>) + Send,
) -> Result<()> {
    let ([_, n, k], parts, blocks) = (plan.sides, plan.parts(), plan.blocks);
    let [sum, of_a, of_b, scratch] = plan.lens::<T>(options.par);
    let mut memory = Scratch::new::<T>(plan.scratch_len::<T>(options.par))?;
    let mut arena = Arena::new(memory.as_mut_slice());
    let mut sums = [(); 2].map(|()| match rows_first {
        true => MatMut::from_row_major_slice_mut(arena.take(sum), n, k),
        false => MatMut::from_column_major_slice_mut(arena.take(sum), n, k),
    });
    let [of_a, of_b, scratch] = [of_a, of_b, scratch].map(|len| arena.take(len));

    for block in 0..blocks {
        let rows = plan.rows(block);
        let stack = |x: MatRef<'_, Complex<T>>, parts, exchanged, memory| {
            let block = x.subrows(rows.start, rows.len());
            Stack::new(block, parts, exchanged, memory, options.par)
        };
        let (left, right) = options.on_cores(|| {
            let exchanged = plan.kind == Kind::Atb;
            let right = b.map(|b| stack(b, parts[1], exchanged, &mut *of_b));
            (stack(a, parts[0], false, &mut *of_a), right)
        });
        let right = right.as_ref().unwrap_or(&left);
        for (i, (term, plans)) in plan.terms.iter().zip(&plan.plans).enumerate() {
            let share = |i: usize| (2 * block + i) as f64 / (2 * blocks) as f64;
            let progress = options.progress.part(share(i)..share(i + 1));
            let product = Product {
                alpha: T::ONE,
                a: left.parts(&term.left),
                b: (term.op != Op::Syrk).then(|| right.parts(&term.right)),
                beta: if block == 0 { T::ZERO } else { T::ONE },
                c: sums[i].rb_mut(),
                uplo: (term.op != Op::Gemm).then_some(Uplo::Lower),
            };
            let own = &plans[usize::from(rows.len() != plan.rows(0).len())];
            execute(own, product, &options.clone().progress(progress), scratch)?;
        }
    }
    let [re, im] = sums.each_ref().map(|sum| sum.rb());
    options.on_cores(|| finish(Sums { re, im }));
    Ok(())
}
