use faer::{MatMut, MatRef};

use super::{Backend, Kernels, Rates, gemmt_by_gemm};
use crate::base::Real;

/// The `gemm` crate.
pub(super) struct Native;

impl<T: Real> Kernels<T> for Native {
    fn gemm(&self, alpha: T, a: MatRef<'_, T>, b: MatRef<'_, T>, beta: T, c: MatMut<'_, T>) {
        assert_eq!((a.nrows(), a.ncols()), (b.nrows(), c.nrows()));
        assert_eq!(b.ncols(), c.ncols());
        if c.nrows() == 0 || c.ncols() == 0 {
            return;
        }
        // SAFETY: the views are valid for their shapes and strides, which are passed unchanged
        // (A transposed by swapping its strides); `c` is borrowed mutably, so it overlaps neither
        // input; with `read_dst == false` the old contents of `c` are not read.
        unsafe {
            gemm::gemm(
                c.nrows(),
                c.ncols(),
                a.nrows(),
                c.as_ptr_mut(),
                c.col_stride(),
                c.row_stride(),
                beta != T::ZERO,
                a.as_ptr(),
                a.row_stride(),
                a.col_stride(),
                b.as_ptr(),
                b.col_stride(),
                b.row_stride(),
                beta,
                alpha,
                false,
                false,
                false,
                gemm::Parallelism::None,
            );
        }
    }

    fn syrk(&self, alpha: T, a: MatRef<'_, T>, beta: T, c: MatMut<'_, T>) {
        gemmt_by_gemm(self, alpha, a, a, beta, c);
    }

    fn gemmt(&self, alpha: T, a: MatRef<'_, T>, b: MatRef<'_, T>, beta: T, c: MatMut<'_, T>) {
        gemmt_by_gemm(self, alpha, a, b, beta, c);
    }
}

impl Backend for Native {
    fn name(&self) -> &str {
        "gemm"
    }

    fn description(&self) -> &str {
        "pure Rust (crate gemm)"
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
