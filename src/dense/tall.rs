//! Products of tall matrices with narrow ones, by blocks of rows, so that no data is packed that is
//! used only once.

use std::sync::Mutex;

use faer::linalg::matmul::matmul;
use faer::prelude::{Reborrow, ReborrowMut};
use faer::{Accum, Mat, MatMut, MatRef};

use super::memory::zeros;
use super::narrow;
use super::rows::{block, by_pieces, pieces};
use crate::base::{Par, Result, spend};

/// Largest number of rows of a block of a sum. It determines the rounding of the sum.
const SUMMED: usize = 4096;

/// Largest number of rows of a block of a product without sums over rows.
const BLOCK: usize = 1024;

/// Computes `A^T B` for A (n x p) and a narrow B (n x q): the sum over blocks of rows, in their
/// order. The result is the same for every `par`, bit for bit.
///
/// # Errors
/// [`Error::Cancelled`](crate::Error::Cancelled) and
/// [`Error::OutOfMemory`](crate::Error::OutOfMemory), as for the other products.
pub fn transposed_product(a: MatRef<'_, f64>, b: MatRef<'_, f64>, par: Par) -> Result<Mat<f64>> {
    let operations = 2 * a.ncols() * b.ncols();
    let block = block(operations, SUMMED);
    let mut sum = zeros(a.ncols(), b.ncols())?;
    for (first, height, spent) in pieces(a.nrows(), block, operations, par.threads()) {
        let (a, b) = (a.subrows(first, height), b.subrows(first, height));
        let parts = par.map_blocks(height, block, |rows| -> Result<Mat<f64>> {
            let mut product = zeros(a.ncols(), b.ncols())?;
            let (a, b) = (a.subrows(rows.start, rows.len()), b.subrows(rows.start, rows.len()));
            if narrow::serves(a, b) {
                narrow::add_transposed(product.as_mut(), a, b);
            } else {
                matmul(product.as_mut(), Accum::Replace, a.transpose(), b, 1.0, faer::Par::Seq);
            }
            Ok(product)
        });
        for part in parts {
            sum += part?;
        }
        spend(spent)?;
    }
    Ok(sum)
}

/// Computes `X := X - A B` for A (n x p) and a narrow X (n x q). The result is the same for every
/// `par`, bit for bit.
///
/// # Errors
/// [`Error::Cancelled`](crate::Error::Cancelled) when the callback asks to stop.
pub fn subtract_product(
    x: MatMut<'_, f64>,
    a: MatRef<'_, f64>,
    b: MatRef<'_, f64>,
    par: Par,
) -> Result<()> {
    let operations = 2 * a.ncols() * x.ncols();
    let block = block(operations, BLOCK);
    by_pieces(x, block, operations, par, |first, x| {
        let a = a.subrows(first, x.nrows());
        if narrow::serves(a, x.rb()) {
            narrow::subtract(x, a, b);
        } else {
            matmul(x, Accum::Add, a, b, -1.0, faer::Par::Seq);
        }
    })
}

/// Computes `X := X S` in place: S is p x q, `q <= p`, X has p columns, of which the first q hold
/// the result. The result is the same for every `par`, bit for bit.
///
/// # Errors
/// [`Error::OutOfMemory`](crate::Error::OutOfMemory) when memory is refused, and `Cancelled`.
pub fn multiply_in_place(x: MatMut<'_, f64>, s: MatRef<'_, f64>, par: Par) -> Result<()> {
    let operations = 2 * s.nrows() * s.ncols();
    let block = block(operations, BLOCK);
    let refused = Mutex::new(None);
    by_pieces(x, block, operations, par, |_, mut x| {
        let mut product = match zeros(x.nrows(), s.ncols()) {
            Ok(product) => product,
            Err(e) => return *refused.lock().expect("no panic") = Some(e),
        };
        matmul(product.as_mut(), Accum::Replace, x.rb(), s, 1.0, faer::Par::Seq);
        x.rb_mut().subcols_mut(0, s.ncols()).copy_from(&product);
    })?;
    refused.into_inner().expect("no panic").map_or(Ok(()), Err)
}
