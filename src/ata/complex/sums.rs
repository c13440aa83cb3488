//! Sums of real products over blocks of complex rows.

use std::ops::Range;

use faer::complex::Complex;
use faer::prelude::{Reborrow, ReborrowMut};
use faer::{MatMut, MatRef};

use super::stack::Stack;
use crate::ata::gram::block_rows;
use crate::ata::options::{AtaOptions, Uplo};
use crate::ata::plan::{Op, Plan, block_start};
use crate::ata::{Product, execute, scratch_len};
use crate::base::{Arena, Result, Scratch};
use crate::blas::BlasReal;

/// A real product of parts of a [`Stack`] of A and of one of B.
pub(super) struct Term {
    pub op: Op,
    pub left: Range<usize>,
    pub right: Range<usize>,
}

/// The sums of two terms, n x k.
pub(super) struct Sums<'s, T> {
    pub re: MatRef<'s, T>,
    pub im: MatRef<'s, T>,
}

/// Sums the two terms over all rows of A, m x n, and B, m x k, which is A when `None`, block by
/// block, and calls `finish` with the sums, whose rows are contiguous with `rows_first`, else their
/// columns.
///
/// Blocks and their order depend on shapes only, so that the result does not depend on threads.
pub(super) fn with_sums<T: BlasReal>(
    a: MatRef<'_, Complex<T>>,
    b: Option<MatRef<'_, Complex<T>>>,
    terms: &[Term; 2],
    rows_first: bool,
    options: &AtaOptions<'_>,
    finish: impl FnOnce(Sums<'_, T>) + Send,
) -> Result<()> {
    let (m, n) = a.shape();
    let k = b.map_or(n, |b| b.ncols());
    let most = |side: fn(&Term) -> usize| side(&terms[0]).max(side(&terms[1]));
    let of_right = most(|term| term.right.end);
    // Parts that a stack of A has, and one of B.
    let parts = match b {
        Some(_) => [most(|term| term.left.end), of_right],
        None => [most(|term| term.left.end).max(of_right), 0],
    };
    let line = [n, k].into_iter().zip(parts).map(|(n, parts)| n.saturating_mul(parts)).sum();
    let blocks = m.div_ceil(block_rows::<T>(line, false));
    let start = |block| block_start(m, blocks, block);

    // Blocks differ by a row at most: there are the heights of the first one and of the last.
    let heights = [start(1), m - start(blocks - 1)];
    let plan = |term: &Term, height: usize| {
        Plan::new::<T>(term.op, term.left.len() * height, n, k, options)
    };
    let plans = |term| Ok([plan(term, heights[0])?, plan(term, heights[1])?]);
    let plans = [plans(&terms[0])?, plans(&terms[1])?];
    let scratch = plans.iter().flatten().map(|plan| scratch_len::<T>(plan, options.par)).max();
    let scratch = scratch.unwrap_or(0);
    let stacks = [n, k].map(|columns| columns.saturating_mul(heights[1]));
    let stacks = [stacks[0].saturating_mul(parts[0]), stacks[1].saturating_mul(parts[1])];
    let sum = n.saturating_mul(k);
    let len = [sum, sum, stacks[0], stacks[1], scratch].into_iter();
    let mut memory = Scratch::new::<T>(len.fold(0, usize::saturating_add))?;
    let mut arena = Arena::new(memory.as_mut_slice());
    let mut sums = [(); 2].map(|()| match rows_first {
        true => MatMut::from_row_major_slice_mut(arena.take(sum), n, k),
        false => MatMut::from_column_major_slice_mut(arena.take(sum), n, k),
    });
    let stacks = stacks.map(|len| arena.take(len));
    let scratch = arena.take(scratch);

    let [of_a, of_b] = stacks;
    for block in 0..blocks {
        let rows = start(block)..start(block + 1);
        let stack = |x: MatRef<'_, Complex<T>>, parts, memory| {
            let block = x.subrows(rows.start, rows.len());
            Stack::new(block, parts, memory, options.par)
        };
        let (left, right) = options.on_cores(|| {
            (stack(a, parts[0], &mut *of_a), b.map(|b| stack(b, parts[1], &mut *of_b)))
        });
        let right = right.as_ref().unwrap_or(&left);
        for (i, (term, plans)) in terms.iter().zip(&plans).enumerate() {
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
            let plan = &plans[usize::from(rows.len() != heights[0])];
            execute(plan, product, &options.clone().progress(progress), scratch)?;
        }
    }
    let [re, im] = sums.each_ref().map(|sum| sum.rb());
    options.on_cores(|| finish(Sums { re, im }));
    Ok(())
}
