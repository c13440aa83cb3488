//! Many products at once.

use std::ops::ControlFlow;
use std::sync::OnceLock;

use faer::prelude::ReborrowMut;
use faer::{MatMut, MatRef};

use super::options::AtaOptions;
use super::plan::{Op, Problem, direct_kernels};
use super::{Product, ata_into, execute_direct};
use crate::base::{Error, Par, Progress, Result, Tracker};
use crate::blas::BlasReal;

/// Fixed cost of a product, in multiplications that take as long.
const CALL: f64 = 1e3;

/// Multiplications between two checks for a request to stop; for fewer, starting a thread gains
/// nothing.
const BLOCK: f64 = 1e6;

/// Most multiplications of a product that one thread computes, whatever the batch: about 0.1 ms.
const SHORT: f64 = BLOCK;

/// Most multiplications of one in a batch of many: some milliseconds.
const LONG: f64 = (1 << 26) as f64;

/// Computes `C_i := alpha A_i^T A_i + beta C_i` for every i, the triangle or triangles of
/// `options.uplo`.
///
/// A_i is m x n, C_i is n x n; any strides and sizes, which may differ between products. A slice of
/// views is what an array of matrices at a fixed distance, or of blocks of one matrix, gives. The
/// threads share the products, except long ones, which they compute together, one after the other.
/// Each result has the bytes of [`ata_into`], for every `options.par`.
///
/// ```
/// use catamaran::{AtaOptions, Uplo, faer::{MatMut, MatRef}, product::ata_batched_into};
///
/// // 1000 matrices of 3 x 2, by rows, one after the other.
/// let (a, mut c) = (vec![1.0; 1000 * 3 * 2], vec![0.0; 1000 * 2 * 2]);
/// let left: Vec<_> = a.chunks(6).map(|a| MatRef::from_row_major_slice(a, 3, 2)).collect();
/// let products = c.chunks_mut(4).map(|c| MatMut::from_row_major_slice_mut(c, 2, 2));
/// let mut products: Vec<_> = products.collect();
/// let options = AtaOptions::new().uplo(Uplo::Both);
/// ata_batched_into(1.0, &left, 0.0, &mut products, &options)?;
/// assert_eq!(c, [3.0; 4000]);
/// # Ok::<(), catamaran::Error>(())
/// ```
///
/// # Errors
/// [`Error::Shape`] when C has not as many matrices as A, [`Error::Argument`] that names the first
/// C_i that is not n x n, and [`Error::OutOfMemory`] for sizes beyond the address space, before a
/// C_i is written. Else as [`ata_into`], with some of the C_i unspecified.
pub fn ata_batched_into<T: BlasReal>(
    alpha: T,
    a: &[MatRef<'_, T>],
    beta: T,
    c: &mut [MatMut<'_, T>],
    options: &AtaOptions<'_>,
) -> Result<()> {
    options.check()?;
    Error::check_shape("C", (a.len(), 1), (c.len(), 1))?;
    let mut total = 0.0;
    let mut checked = (0, 0);
    for (i, (a, c)) in a.iter().zip(c.iter()).enumerate() {
        let ((m, n), (rows, cols)) = (a.shape(), c.shape());
        if (rows, cols) != (n, n) {
            let why = format!("matrix {i}: expected {n} x {n}, got {rows} x {cols}");
            return Err(Error::Argument { what: "C", why });
        }
        if (m, n) != checked {
            Problem::new(Op::Syrk, m, n, n)?;
            checked = (m, n);
        }
        total += work(*a);
    }
    if a.is_empty() {
        return options.progress.report(1.0);
    }
    let longest = (total / options.par.threads() as f64).clamp(SHORT, LONG);
    let together = |a: MatRef<'_, T>| work(a) > longest;
    let mut done: f64 = a.iter().filter(|&&a| !together(a)).map(|&a| work(a)).sum();
    // Again, in the order in which `done` grows: the last fraction is 1.
    let total = a.iter().filter(|&&a| together(a)).fold(done, |sum, &a| sum + work(a));

    let size = (BLOCK * a.len() as f64 / total).ceil() as usize;
    let par = options.par.at_most(a.len().div_ceil(size));
    let tracker = Tracker::new(options.progress.part(0.0..done / total), done);
    let failed = OnceLock::new();
    // The tracker reports, not each product.
    let silent = |_: f64| ControlFlow::Continue(());
    let alone = options.clone().par(Par::Seq).progress(Progress::new(&silent));
    options.on_cores(|| {
        par.for_each(a.chunks(size).zip(c.chunks_mut(size)), |_, (a, c)| {
            let mut spent = 0.0;
            // The kernels are looked up once for products of one shape.
            let (mut shape, mut kernels) = ((0, 0), None);
            for (&a, c) in a.iter().zip(c).filter(|&(&a, _)| !together(a)) {
                if tracker.state().is_break() || failed.get().is_some() {
                    return;
                }
                let (m, n) = a.shape();
                if shape != (m, n) {
                    shape = (m, n);
                    kernels = direct_kernels(&Problem { op: Op::Syrk, m, n, k: n }, &alone);
                }
                let c = c.rb_mut();
                let result = match kernels {
                    Some(native) => {
                        let uplo = Some(options.uplo);
                        let product = Product { alpha, a, b: None, beta, c, uplo };
                        execute_direct(native, Op::Syrk, product)
                    }
                    None => ata_into(alpha, a, beta, c, &alone),
                };
                if let Err(error) = result {
                    let _ = failed.set(error);
                }
                spent += work(a);
            }
            // The tracker remembers a request to stop.
            let _ = tracker.add(spent);
        });
    });
    tracker.finish()?;
    if let Some(error) = failed.into_inner() {
        return Err(error);
    }

    for (&a, c) in a.iter().zip(c).filter(|&(&a, _)| together(a)) {
        let before = done / total;
        done += work(a);
        let progress = options.progress.part(before..done / total);
        ata_into(alpha, a, beta, c.rb_mut(), &options.clone().progress(progress))?;
    }
    Ok(())
}

/// Returns the cost of a product in multiplications, its fixed cost included.
fn work<T>(a: MatRef<'_, T>) -> f64 {
    let (m, n) = (a.nrows() as f64, a.ncols() as f64);
    0.5 * (m + 1.0) * n * n + CALL
}
