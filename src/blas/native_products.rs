//! What our own kernels compute as a back end.

use faer::{MatMut, MatRef};

use super::backend::{Backend, Kernels, Rates};
use super::native::Native;
use crate::base::{Par, Progress, Scratch, Tracker};
use crate::kernel::packed::{
    self, Destination, Job, Operand, Part, Product, Shape, Source, is_small, run, run_small,
    scratch_len,
};

/// Rows and columns of the blocks of C whose operands are packed together.
const BLOCK: usize = 2048;

/// Scalars that packed operands may take: 8 MB in f64.
const BUDGET: usize = 1 << 20;

impl Native {
    /// The part of `C := alpha A^T B + beta C`, B being A when `None`.
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
        let kernel = T::kernel(self.isa());
        let shape = Shape { depth: a.nrows(), rows: n, cols: k, same: b.is_none() };
        if is_small(shape) {
            let source = |matrix| Source { coefficient: T::ONE, matrix, scale: None };
            let (mut left, mut right) = (source(a), source(b.unwrap_or(a)));
            let mut target = destination.block(0..n, 0..k, alpha, beta);
            let mut shape = shape;
            if by_columns {
                (left, right) = (right, left);
                target = target.transposed();
                (shape.rows, shape.cols) = (k, n);
            }
            // SAFETY: C is borrowed for the length of this call.
            return unsafe { run_small(kernel, left, right, target, shape) };
        }
        let mut products = Vec::new();
        for i in (0..n).step_by(BLOCK) {
            for j in (0..k).step_by(BLOCK) {
                let (rows, cols) = (BLOCK.min(n - i), BLOCK.min(k - j));
                let same = b.is_none() && i == j;
                let product = Product {
                    left: side(a, i, rows),
                    right: if same { vec![] } else { side(b.unwrap_or(a), j, cols) },
                    targets: vec![destination.block(i..i + rows, j..j + cols, alpha, beta)],
                    shape: Shape { depth: a.nrows(), rows, cols, same },
                };
                products.push(if by_columns { product.transposed() } else { product });
            }
        }
        let shapes = products.iter().map(|p| p.shape);
        let len = scratch_len::<T>(kernel.geometry(), shapes, BUDGET, 1);
        let mut scratch = Scratch::new::<T>(len).expect("a few megabytes");
        let progress = &Tracker::new(Progress::none(), 0.0);
        let job = Job { kernel, products: &products, budget: BUDGET, progress };
        // SAFETY: C is borrowed for the length of this call.
        unsafe { run(&job, Par::Seq, scratch.as_mut_slice()) };
    }
}

/// Some columns, as one side of a product.
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

impl Backend for Native {
    fn name(&self) -> &str {
        "native"
    }

    fn description(&self) -> &str {
        self.isa().name()
    }

    fn native(&self) -> Option<&Self> {
        Some(self)
    }

    fn rates(&self) -> Rates {
        let packed::Rates { flops, update_bytes, .. } = Self::rates(self);
        Rates {
            gemm_flops: flops,
            gemm_half_side: 36.0,
            syrk_flops: flops,
            syrk_half_side: 60.0,
            add_bytes: update_bytes,
        }
    }
}
