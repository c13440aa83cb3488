//! One pass over rows: block after block, products planned once for each height of blocks, all in
//! one scratch.

use std::ops::Range;

use faer::MatRef;

use crate::base::{Progress, Result, Scratch};
use crate::blas::BlasReal;
use crate::kernel::int8::{Integer, IntegerIsa, Kernel};
use crate::product::exact::{self, Columns, ExactLayout, TriangleRows};
use crate::product::plan::{Op, Plan};
use crate::product::{AtaOptions, Product, execute};

use super::blocks::for_each_block;
use super::source::RowBlocks;

/// The share of the pass for bounds in the progress of two passes.
pub(super) const FIRST_PASS: f64 = 0.1;

/// Calls `work(count, block, weights, pass)` for each block of `height` rows from row `start` on.
/// Rows without columns are one block, as a file may announce any number of them.
pub(super) fn for_each_block_of<'o, T: BlasReal>(
    rows: &mut (dyn RowBlocks<T> + Send),
    weights: Option<&[T]>,
    height: usize,
    start: usize,
    options: &AtaOptions<'o>,
    mut work: impl FnMut(usize, &mut [T], Option<&[T]>, &mut Pass<'o>) -> Result<()>,
) -> Result<()> {
    let m = rows.nrows();
    let height = if rows.ncols() == 0 { m.max(1) } else { height };
    let mut pass = Pass::new(options)?;
    for_each_block(rows, start, height, options.par, |first, block| {
        let count = height.min(m - first);
        let weights = weights.map(|weights| &weights[first..first + count]);
        pass.first = first;
        pass.progress = options.progress.part(share_of_rows(first, count, m));
        work(count, block, weights, &mut pass)
    })
}

/// Returns the share that `count` rows from `first` on, of `m`, have of the whole.
fn share_of_rows(first: usize, count: usize, m: usize) -> Range<f64> {
    let part = |rows: usize| rows as f64 / m.max(1) as f64;
    part(first)..part(first + count)
}

/// What a pass over rows needs beside its sums.
pub(crate) struct Pass<'o> {
    pub options: AtaOptions<'o>,
    /// The number in the source of the first row of the current block.
    pub first: usize,
    /// The part of `options.progress` for the current block.
    pub progress: Progress<'o>,
    /// Memory for rows times weights.
    pub weighted: Scratch,
    pub engine: Engine,
}

/// How columns become integers, and the number of moduli.
pub(crate) struct Scaling {
    /// Column j of the left side is multiplied by `2^powers[0][j]`, of the right side by
    /// `2^powers[1][j]`.
    pub powers: [Vec<i32>; 2],
    /// Whether the integers may be as large as `2^WIDE_BITS`.
    pub wide: bool,
    /// Number of moduli.
    pub moduli: usize,
}

/// The kernels and plans of the products.
pub(crate) struct Engine {
    /// The kernel of the exact path.
    pub kernel: &'static dyn Kernel,
    /// Plans and what they are for: a pass has two heights of blocks at most.
    plans: Vec<((Op, [usize; 3]), Plan)>,
    scratch: Scratch,
}

impl<'o> Pass<'o> {
    /// Creates a pass with these options.
    pub fn new(options: &AtaOptions<'o>) -> Result<Self> {
        Ok(Self {
            options: options.clone(),
            first: 0,
            progress: options.progress,
            weighted: Scratch::default(),
            engine: Engine {
                kernel: IntegerIsa::best().kernel(),
                plans: Vec::new(),
                scratch: Scratch::default(),
            },
        })
    }

    /// Returns the options for the current block, the engine, and the scratch of the weighted rows.
    pub fn parts(&mut self) -> (AtaOptions<'o>, &mut Engine, &mut Scratch) {
        let options = AtaOptions { progress: self.progress, ..self.options.clone() };
        (options, &mut self.engine, &mut self.weighted)
    }
}

impl Engine {
    /// Computes `C := alpha A^T B + beta C`; B is A when it is `None`.
    pub fn multiply<T: BlasReal>(
        &mut self,
        product: Product<'_, T>,
        options: &AtaOptions<'_>,
    ) -> Result<()> {
        let op = match (product.uplo, product.b) {
            (None, _) => Op::Gemm,
            (Some(_), None) => Op::Syrk,
            (Some(_), Some(_)) => Op::Gemmt,
        };
        let (m, n) = product.a.shape();
        let key = (op, [m, n, product.c.ncols()]);
        let plan = match self.plans.iter().position(|(of, _)| *of == key) {
            Some(found) => &self.plans[found].1,
            None => {
                let plan = Plan::new::<T>(op, m, n, product.c.ncols(), options)?;
                self.plans.push((key, plan));
                &self.plans[self.plans.len() - 1].1
            }
        };
        self.scratch.reserve::<T>(plan.scratch_len::<T>(options.par))?;
        execute(plan, product, options, self.scratch.as_mut_slice())
    }

    /// Adds the integers of `X^T Y`, Y the weighted rows or X, to the rows `strip` of the triangle
    /// `sums`, or subtracts them. Columns are multiplied as `scaling` says.
    pub fn integers<T: BlasReal, I: Integer>(
        &mut self,
        x: MatRef<'_, T>,
        y: Option<MatRef<'_, T>>,
        scaling: &Scaling,
        (sums, strip): (&mut [I], &Range<usize>),
        subtract: bool,
        options: &AtaOptions<'_>,
    ) -> Result<()> {
        let sums = &TriangleRows::new(sums, strip.start);
        let of = |m, powers: &[i32], columns: &Range<usize>| {
            let powers = powers[columns.clone()].iter().copied();
            (part(m, columns), Columns::given(powers, scaling.wide))
        };
        let (powers, moduli) = (&scaling.powers, scaling.moduli);
        let (rest, right) = (0..strip.start, y.unwrap_or(x));
        let left = &of(x, &powers[0], strip);
        let share = strip.start as f64 / (strip.start as f64 + strip.len() as f64 / 2.0);
        if !rest.is_empty() {
            let right = &of(right, &powers[1], &rest);
            let options = options.clone().progress(options.progress.part(0.0..share));
            let corner = (strip.start, 0);
            self.add_integers([left, right], moduli, [false; 2], sums, corner, subtract, &options)?;
        }
        let square = &of(right, &powers[1], strip);
        let square = if y.is_none() { left } else { square };
        let options = options.clone().progress(options.progress.part(share..1.0));
        let corner = (strip.start, strip.start);
        let kind = [true, y.is_none()];
        self.add_integers([left, square], moduli, kind, sums, corner, subtract, &options)
    }

    fn add_integers<T: BlasReal, I: Integer>(
        &mut self,
        [left, right]: [&(MatRef<'_, T>, Columns); 2],
        moduli: usize,
        [symmetric, same]: [bool; 2],
        sums: &TriangleRows<'_, I>,
        corner: (usize, usize),
        subtract: bool,
        options: &AtaOptions<'_>,
    ) -> Result<()> {
        let extents = [left.0.nrows(), left.0.ncols(), right.0.ncols()];
        let layout = ExactLayout::new(extents, size_of::<T>(), moduli, symmetric, same);
        let len = exact::scratch_len::<T>(extents, &layout, options.par.threads());
        self.scratch.reserve::<T>(len)?;
        let scratch = self.scratch.as_mut_slice();
        let operands = [(left.0, &left.1), (right.0, &right.1)];
        exact::accumulate(self.kernel, &layout, operands, sums, corner, subtract, options, scratch)
    }
}

/// Returns some columns of a matrix.
pub(super) fn part<'a, T>(x: MatRef<'a, T>, columns: &Range<usize>) -> MatRef<'a, T> {
    x.subcols(columns.start, columns.len())
}
