use std::ops::ControlFlow;

use faer::{MatMut, MatRef};

use super::kernels::Kernels;
use crate::base::{Par, Progress, Scratch, Tracker, triangle_len};
use crate::kernel::packed::{
    self, Destination, FloatIsa, FloatOperand, Job, Kernel, KernelProduct, Part, Shape, Source,
    is_small, run, run_small, scratch_len,
};

/// The kernels of this crate, for one instruction set: one product at a time, on the calling
/// thread.
///
/// [`product`](crate::product) does not call them through [`Kernels`], but uses more of their
/// features: threads that share packed operands, and additions fused into packing and writing.
///
/// ```
/// use catamaran::blas::{Kernels, Native};
/// use catamaran::{faer::Mat, kernel::packed::{FloatIsa, Rates}};
///
/// let native = Native::new(FloatIsa::Portable, Rates::of(FloatIsa::Portable));
/// let (a, mut c) = (Mat::<f64>::ones(5, 3), Mat::zeros(3, 3));
/// native.syrk(1.0, a.as_ref(), 0.0, c.as_mut());
/// assert_eq!((c[(2, 1)], c[(1, 2)]), (5.0, 0.0)); // the lower triangle
/// ```
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Native {
    isa: FloatIsa,
    rates: packed::Rates,
}

/// Rows and columns of the blocks of C whose operands are packed together.
const BLOCK: usize = 2048;

/// Scalars that packed operands may take: 8 MB in f64.
const BUDGET: usize = 1 << 20;

impl Native {
    /// Creates the kernels for `isa`, or the portable kernels if this machine does not support it.
    /// The planner assumes `rates`.
    pub fn new(isa: FloatIsa, rates: packed::Rates) -> Self {
        let usable = isa.refusal().is_none();
        Self { isa: if usable { isa } else { FloatIsa::Portable }, rates }
    }

    /// Returns the instruction set.
    pub fn isa(&self) -> FloatIsa {
        self.isa
    }

    /// Returns the speed that the planner assumes.
    pub fn rates(&self) -> packed::Rates {
        self.rates
    }

    /// Returns whether a product ends before it could be shared by threads.
    #[inline]
    pub(crate) fn is_small(&self, m: usize, n: usize, k: usize, same: bool) -> bool {
        is_small(Shape { depth: m, rows: n, cols: k, same }, true)
    }

    /// Computes one part of `C := alpha A^T B + beta C`. B is A when `None`. A request to stop
    /// leaves C unfinished.
    ///
    /// The function is inlined into its callers, so that a small product is not slowed down
    /// by the differences between them.
    #[inline(always)]
    fn product<T: FloatOperand>(
        self,
        alpha: T,
        a: MatRef<'_, T>,
        b: Option<MatRef<'_, T>>,
        beta: T,
        c: MatMut<'_, T>,
        part: Part,
        progress: Option<Progress<'_>>,
    ) -> ControlFlow<()> {
        let (n, k) = (c.nrows(), c.ncols());
        assert_eq!((a.nrows(), a.ncols()), (b.unwrap_or(a).nrows(), n));
        assert_eq!(b.unwrap_or(a).ncols(), k);
        let by_columns = c.row_stride() == 1 && c.col_stride() != 1;
        let destination = Destination::new(c, part);
        let kernel = T::kernel(self.isa);
        let mut shape = Shape { depth: a.nrows(), rows: n, cols: k, same: b.is_none() };
        let source = |matrix| Source { coefficient: T::ONE, matrix, scale: None };
        let (mut left, mut right) = (a, b.unwrap_or(a));
        let plain = source(left).is_plain(shape.depth, n) && source(right).is_plain(shape.depth, k);
        if !is_small(shape, plain) {
            return large_product(
                kernel,
                alpha,
                a,
                b,
                beta,
                &destination,
                part,
                by_columns,
                progress,
            );
        }
        let mut target = destination.block(0..n, 0..k, alpha, beta);
        if by_columns {
            (left, right) = (right, left);
            target = target.transposed();
            (shape.rows, shape.cols) = (k, n);
        }
        // SAFETY: this call borrows C mutably, so nobody else uses the matrix of the target.
        unsafe { run_small(kernel, source(left), source(right), &mut target, shape) };
        ControlFlow::Continue(())
    }
}

/// Computes [`Native::product`] for matrices that are worth packing block by block.
#[inline(never)]
fn large_product<T: FloatOperand>(
    kernel: &'static dyn Kernel<T>,
    alpha: T,
    a: MatRef<'_, T>,
    b: Option<MatRef<'_, T>>,
    beta: T,
    destination: &Destination<'_, T>,
    part: Part,
    by_columns: bool,
    progress: Option<Progress<'_>>,
) -> ControlFlow<()> {
    let right = b.unwrap_or(a);
    let (n, k) = (a.ncols(), right.ncols());
    let mut products = Vec::new();
    for i in (0..n).step_by(BLOCK) {
        for j in (0..k).step_by(BLOCK) {
            let (rows, cols) = (BLOCK.min(n - i), BLOCK.min(k - j));
            let same = b.is_none() && i == j;
            let product = KernelProduct {
                left: side(a, i, rows),
                right: if same { vec![] } else { side(right, j, cols) },
                targets: vec![destination.block(i..i + rows, j..j + cols, alpha, beta)],
                shape: Shape { depth: a.nrows(), rows, cols, same },
            };
            products.push(if by_columns { product.transposed() } else { product });
        }
    }
    let shapes = products.iter().map(|p| p.shape);
    let len = scratch_len::<T>(kernel.geometry(), shapes, BUDGET, 1);
    let Ok(mut scratch) = Scratch::new::<T>(len) else {
        product_in_pieces(kernel, alpha, a, right, beta, destination, part);
        return ControlFlow::Continue(());
    };
    let entries = if matches!(part, Part::Lower) { triangle_len(n) } else { n * k };
    let work = entries as f64 * a.nrows() as f64;
    let progress = &progress.map_or_else(Tracker::unwatched, |p| Tracker::new(p, work));
    let job = Job { kernel, products: &products, budget: BUDGET, progress };
    // SAFETY: this call borrows C mutably, so nobody else uses the matrices of the targets.
    unsafe { run(&job, Par::Seq, scratch.as_mut_slice()) };
    progress.state()
}

/// Computes [`large_product`] without memory, which was refused: by small products, slower and with
/// other rounding errors.
fn product_in_pieces<T: FloatOperand>(
    kernel: &'static dyn Kernel<T>,
    alpha: T,
    a: MatRef<'_, T>,
    b: MatRef<'_, T>,
    beta: T,
    destination: &Destination<'_, T>,
    part: Part,
) {
    /// Rows and columns of a piece of C, and rows of A that are summed together: small products.
    const SIDE: usize = 32;
    const DEPTH: usize = 1024;
    let source = |matrix| Source { coefficient: T::ONE, matrix, scale: None };
    let (m, n, k) = (a.nrows(), a.ncols(), b.ncols());
    for i in (0..n).step_by(SIDE) {
        let all = if matches!(part, Part::Lower) { k.min(i + SIDE) } else { k };
        for j in (0..all).step_by(SIDE) {
            let (rows, cols) = (SIDE.min(n - i), SIDE.min(k - j));
            for first in (0..m).step_by(DEPTH) {
                let depth = DEPTH.min(m - first);
                let (left, right) =
                    (a.submatrix(first, i, depth, rows), b.submatrix(first, j, depth, cols));
                let beta = if first == 0 { beta } else { T::ONE };
                let mut target = destination.block(i..i + rows, j..j + cols, alpha, beta);
                let shape = Shape { depth, rows, cols, same: false };
                // SAFETY: C is borrowed for the length of the caller's call.
                unsafe { run_small(kernel, source(left), source(right), &mut target, shape) };
            }
        }
    }
}

/// Returns some columns as one side of a product.
fn side<T: FloatOperand>(matrix: MatRef<'_, T>, first: usize, count: usize) -> Vec<Source<'_, T>> {
    vec![Source { coefficient: T::ONE, matrix: matrix.subcols(first, count), scale: None }]
}

impl<T: FloatOperand> Kernels<T> for Native {
    fn gemm(&self, alpha: T, a: MatRef<'_, T>, b: MatRef<'_, T>, beta: T, c: MatMut<'_, T>) {
        let _ = self.product(alpha, a, Some(b), beta, c, Part::All, None);
    }

    fn syrk(&self, alpha: T, a: MatRef<'_, T>, beta: T, c: MatMut<'_, T>) {
        let _ = self.product(alpha, a, None, beta, c, Part::Lower, None);
    }

    fn gemmt(&self, alpha: T, a: MatRef<'_, T>, b: MatRef<'_, T>, beta: T, c: MatMut<'_, T>) {
        let _ = self.product(alpha, a, Some(b), beta, c, Part::Lower, None);
    }

    fn compute(
        &self,
        triangle: bool,
        alpha: T,
        a: MatRef<'_, T>,
        b: Option<MatRef<'_, T>>,
        beta: T,
        c: MatMut<'_, T>,
        progress: Progress<'_>,
    ) -> ControlFlow<()> {
        let part = if triangle { Part::Lower } else { Part::All };
        self.product(alpha, a, b, beta, c, part, Some(progress))?;
        progress.tell(1.0)
    }
}

#[cfg(test)]
mod tests {
    use faer::Mat;

    use super::*;
    use crate::base::Rng;

    fn kernel<T: FloatOperand>() -> &'static dyn Kernel<T> {
        T::kernel(FloatIsa::best())
    }

    #[test]
    fn without_memory_products_are_made_of_small_ones() {
        let mut rng = Rng::new(7);
        let mut random = |rows, cols| {
            Mat::<f64>::from_fn(rows, cols, |_, _| (rng.uniform() * 9.0).floor() - 4.0)
        };
        for (m, n, k) in [(1500, 70, 70), (2100, 33, 33), (3, 90, 90)] {
            let (a, b, c) = (random(m, n), random(m, k), random(n, k));
            for part in [Part::All, Part::Lower] {
                let mut found = c.clone();
                let destination = Destination::new(found.as_mut(), part);
                let kernel = kernel();
                product_in_pieces(kernel, 2.0, a.as_ref(), b.as_ref(), 3.0, &destination, part);
                let expected = a.transpose() * &b * 2.0 + &c * 3.0;
                for (i, j) in (0..n).flat_map(|i| (0..k).map(move |j| (i, j))) {
                    let wanted = matches!(part, Part::All) || i >= j;
                    let entry = if wanted { expected[(i, j)] } else { c[(i, j)] };
                    assert_eq!(found[(i, j)], entry, "{m} {n} {k}, ({i}, {j})");
                }
            }
        }
    }
}
