//! Runs a [`Plan`] on the native kernels.


use faer::{MatMut, MatRef};

use super::exec::Tracker;
use super::fused::{self, Block, FusedProduct};
use super::options::AtaOptions;
use super::plan::Plan;
use super::recurse::Op;
use crate::base::{Error, Result};
use crate::kernel::packed::{
    Destination, Instance, Job, Operand, Part, Product, Source, run,
};

/// `C := alpha A^T B + beta C` by `plan`; B is `None` for A^T A. Symmetric plans touch only the
/// lower triangle.
pub(crate) fn execute<T: Operand>(
    instance: Instance,
    plan: &Plan,
    alpha: T,
    a: MatRef<'_, T>,
    b: Option<MatRef<'_, T>>,
    beta: T,
    c: MatMut<'_, T>,
    options: &AtaOptions<'_>,
    scratch: &mut [T],
) -> Result<()> {
    let op = if !plan.symmetric { Op::Gemm } else if b.is_none() { Op::Syrk } else { Op::Gemmt };
    let program = fused::products(&plan.recursion, op, a.nrows(), a.ncols(), b.unwrap_or(a).ncols());
    let tracker = Tracker::new(options, program.iter().map(|p| p.flops(plan.symmetric) / 2.0).sum());
    let progress = |work: f64| {
        tracker.add(work);
        !tracker.cancelled()
    };
    let part = if plan.symmetric { Part::Lower } else { Part::All };
    let by_columns = c.row_stride() == 1 && c.col_stride() != 1;
    let destination = Destination::new(c, part);
    let products: Vec<_> = program
        .iter()
        .map(|p| {
            let product = bind(p, alpha, a, b.unwrap_or(a), beta, &destination);
            if by_columns { product.transposed() } else { product }
        })
        .collect();
    let kernel = T::kernel(instance);
    let job = Job { kernel, products: &products, budget: 8 << 20, progress: &progress };
    // SAFETY: `c` is ours.
    if unsafe { run(&job, options.par, scratch) } { Ok(()) } else { Err(Error::Cancelled) }
}

fn bind<'a, T: Operand>(
    product: &FusedProduct,
    alpha: T,
    a: MatRef<'a, T>,
    b: MatRef<'a, T>,
    beta: T,
    c: &Destination<'_, T>,
) -> Product<'a, T> {
    let sources = |blocks: &[Block], matrix: MatRef<'a, T>| {
        let source = |b: &Block| Source {
            coefficient: T::from_f64(f64::from(b.coefficient)),
            matrix: matrix.submatrix(b.rows.start, b.cols.start, b.rows.len(), b.cols.len()),
        };
        blocks.iter().map(source).collect()
    };
    let target = |o: &Block| {
        let coefficient = alpha * T::from_f64(f64::from(o.coefficient));
        c.block(o.rows.clone(), o.cols.clone(), coefficient, if o.first { beta } else { T::ONE })
    };
    Product {
        left: sources(&product.left, a),
        right: sources(&product.right, b),
        targets: product.outputs.iter().map(target).collect(),
        shape: product.shape,
    }
}
