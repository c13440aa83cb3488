use faer::{MatMut, MatRef};

use super::kernels::Kernels;
use crate::base::{Par, Scratch, Tracker};
use crate::kernel::packed::{
    self, Destination, Isa, Job, Kernel, Operand, Part, Product, Shape, Source, is_small, run,
    run_small, scratch_len,
};

/// The kernels of this crate, for one instruction set: one product at a time, on the calling
/// thread.
///
/// [`ata`](mod@crate::ata) does not call them through [`Kernels`], but uses more of their features:
/// threads that share packed operands, and additions fused into packing and writing.
///
/// ```
/// use catamaran::blas::{Kernels, Native};
/// use catamaran::{faer::Mat, kernel::packed::{Isa, Rates}};
///
/// let native = Native::new(Isa::Portable, Rates::of(Isa::Portable));
/// let (a, mut c) = (Mat::<f64>::ones(5, 3), Mat::zeros(3, 3));
/// native.syrk(1.0, a.as_ref(), 0.0, c.as_mut());
/// assert_eq!((c[(2, 1)], c[(1, 2)]), (5.0, 0.0)); // the lower triangle
/// ```
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Native {
    isa: Isa,
    rates: packed::Rates,
}

/// Rows and columns of the blocks of C whose operands are packed together.
const BLOCK: usize = 2048;

/// Scalars that packed operands may take: 8 MB in f64.
const BUDGET: usize = 1 << 20;

impl Native {
    /// Creates the kernels for `isa`, or the portable kernels if this machine does not support it.
    /// The planner assumes `rates`.
    pub fn new(isa: Isa, rates: packed::Rates) -> Self {
        let usable = isa.refusal().is_none();
        Self { isa: if usable { isa } else { Isa::Portable }, rates }
    }

    /// Returns the instruction set.
    pub fn isa(&self) -> Isa {
        self.isa
    }

    /// Returns the speed that the planner assumes.
    pub fn rates(&self) -> packed::Rates {
        self.rates
    }

    /// Returns whether a product ends before it could be planned: at most about 30 microseconds.
    #[inline]
    pub(crate) fn is_small(&self, m: usize, n: usize, k: usize, same: bool) -> bool {
        is_small(Shape { depth: m, rows: n, cols: k, same })
    }

    /// Computes one part of `C := alpha A^T B + beta C`. B is A when `None`.
    ///
    /// The function is inlined into its three callers, so that a small product is not slowed down
    /// by the differences between them.
    #[inline(always)]
    fn product<T: Operand>(
        self,
        alpha: T,
        a: MatRef<'_, T>,
        b: Option<MatRef<'_, T>>,
        beta: T,
        c: MatMut<'_, T>,
        part: Part,
    ) {
        let (n, k) = (c.nrows(), c.ncols());
        assert_eq!((a.nrows(), a.ncols()), (b.unwrap_or(a).nrows(), n));
        assert_eq!(b.unwrap_or(a).ncols(), k);
        let by_columns = c.row_stride() == 1 && c.col_stride() != 1;
        let destination = Destination::new(c, part);
        let kernel = T::kernel(self.isa);
        let mut shape = Shape { depth: a.nrows(), rows: n, cols: k, same: b.is_none() };
        if !is_small(shape) {
            return large_product(kernel, alpha, a, b, beta, &destination, by_columns);
        }
        let source = |matrix| Source { coefficient: T::ONE, matrix, scale: None };
        let (mut left, mut right) = (source(a), source(b.unwrap_or(a)));
        let mut target = destination.block(0..n, 0..k, alpha, beta);
        if by_columns {
            (left, right) = (right, left);
            target = target.transposed();
            (shape.rows, shape.cols) = (k, n);
        }
        // SAFETY: C is borrowed for the length of this call.
        unsafe { run_small(kernel, left, right, target, shape) };
    }
}

/// Computes [`Native::product`] for matrices that are worth packing block by block.
#[inline(never)]
fn large_product<T: Operand>(
    kernel: &'static dyn Kernel<T>,
    alpha: T,
    a: MatRef<'_, T>,
    b: Option<MatRef<'_, T>>,
    beta: T,
    destination: &Destination<'_, T>,
    by_columns: bool,
) {
    let right = b.unwrap_or(a);
    let (n, k) = (a.ncols(), right.ncols());
    let mut products = Vec::new();
    for i in (0..n).step_by(BLOCK) {
        for j in (0..k).step_by(BLOCK) {
            let (rows, cols) = (BLOCK.min(n - i), BLOCK.min(k - j));
            let same = b.is_none() && i == j;
            let product = Product {
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
    let mut scratch = Scratch::new::<T>(len).expect("a few megabytes");
    let progress = &Tracker::unwatched();
    let job = Job { kernel, products: &products, budget: BUDGET, progress };
    // SAFETY: C is borrowed for the length of this call.
    unsafe { run(&job, Par::Seq, scratch.as_mut_slice()) };
}

/// Returns some columns as one side of a product.
fn side<T: Operand>(matrix: MatRef<'_, T>, first: usize, count: usize) -> Vec<Source<'_, T>> {
    vec![Source { coefficient: T::ONE, matrix: matrix.subcols(first, count), scale: None }]
}

impl<T: Operand> Kernels<T> for Native {
    fn gemm(&self, alpha: T, a: MatRef<'_, T>, b: MatRef<'_, T>, beta: T, c: MatMut<'_, T>) {
        self.product(alpha, a, Some(b), beta, c, Part::All);
    }

    fn syrk(&self, alpha: T, a: MatRef<'_, T>, beta: T, c: MatMut<'_, T>) {
        self.product(alpha, a, None, beta, c, Part::Lower);
    }

    fn gemmt(&self, alpha: T, a: MatRef<'_, T>, b: MatRef<'_, T>, beta: T, c: MatMut<'_, T>) {
        self.product(alpha, a, Some(b), beta, c, Part::Lower);
    }
}
