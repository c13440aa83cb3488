use faer::{MatMut, MatRef};

use super::{Backend, Kernels, Rates};
use crate::base::{Par, Scratch};
use crate::kernel::packed::{
    Destination, Instance, Job, Operand, Part, Product, Shape, Source, run, scratch_len,
};

/// The kernels of this crate, one product at a time, on the calling thread.
#[derive(Clone, Copy)]
pub(super) struct Native(pub Instance);

/// Side of the blocks of C whose operands are packed together.
const BLOCK: usize = 2048;

/// Scalars that packed operands may take.
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
        let kernel = T::kernel(self.0);
        let shapes = products.iter().map(|p| p.shape);
        let len = scratch_len::<T>(kernel.geometry(), shapes, BUDGET, 1);
        let mut scratch = Scratch::new::<T>(len).expect("a few megabytes");
        let job = Job { kernel, products: &products, budget: BUDGET, progress: &|_| true };
        // SAFETY: C is borrowed for the length of this call.
        unsafe { run(&job, Par::Seq, scratch.as_mut_slice()) };
    }
}

/// Some columns, as one side of a product.
fn side<T: Operand>(matrix: MatRef<'_, T>, first: usize, count: usize) -> Vec<Source<'_, T>> {
    vec![Source { coefficient: T::ONE, matrix: matrix.subcols(first, count) }]
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
        self.0.name()
    }

    fn instance(&self) -> Option<Instance> {
        Some(self.0)
    }

    fn rates(&self) -> Rates {
        Rates {
            gemm_flops: 88e9,
            gemm_half_side: 36.0,
            syrk_flops: 90e9,
            syrk_half_side: 350.0,
            add_bytes: 16e9,
        }
    }
}
