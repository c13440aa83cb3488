//! Products of the default options, in a new matrix.

use faer::Mat;
use faer::complex::Complex;
use faer::mat::AsMatRef;

use super::options::{AtaOptions, Uplo};
use super::{aha_into, ahb_into, ata_into, atb_into};
use crate::base::{Result, filled};
use crate::blas::BlasReal;

/// Returns `A^T A`, both triangles.
///
/// A is m x n, a [`Mat`] or a view of any strides, or a reference to either; any sizes, 0 included.
/// The result is n x n. [`ata_into`] takes options, factors, and memory for C.
///
/// ```
/// use catamaran::{ata, faer::mat};
///
/// let a = mat![[1.0, 2.0], [3.0, 4.0], [5.0, 6.0]];
/// assert_eq!(ata(&a)?, mat![[35.0, 44.0], [44.0, 56.0]]);
/// # Ok::<(), catamaran::Error>(())
/// ```
///
/// # Errors
/// [`Error::OutOfMemory`](crate::Error::OutOfMemory) when memory for the result or for the scratch
/// is refused.
pub fn ata<T: BlasReal>(a: impl AsMatRef<T = T, Rows = usize, Cols = usize>) -> Result<Mat<T>> {
    let a = a.as_mat_ref();
    let mut c = filled(a.ncols(), a.ncols(), |_, _| T::ZERO)?;
    ata_into(T::ONE, a, T::ZERO, c.as_mut(), &both())?;
    Ok(c)
}

/// Returns `A A^T`, both triangles: [`ata`] of the transposed view. A is m x n, the result m x m.
/// [`aat_into`](super::aat_into) takes options, factors, and memory for C.
///
/// ```
/// use catamaran::{aat, faer::mat};
///
/// assert_eq!(aat(mat![[3.0, 4.0]])?, mat![[25.0]]);
/// # Ok::<(), catamaran::Error>(())
/// ```
///
/// # Errors
/// As [`ata`].
pub fn aat<T: BlasReal>(a: impl AsMatRef<T = T, Rows = usize, Cols = usize>) -> Result<Mat<T>> {
    ata(a.as_mat_ref().transpose())
}

/// Returns `A^T B`. A is m x n, B is m x k, as in [`ata`]; the result is n x k. [`atb_into`] takes
/// options, factors, and memory for C.
///
/// ```
/// use catamaran::{atb, faer::mat};
///
/// let (a, b) = (mat![[1.0, 2.0], [3.0, 4.0]], mat![[1.0], [10.0]]);
/// assert_eq!(atb(&a, &b)?, mat![[31.0], [42.0]]);
/// # Ok::<(), catamaran::Error>(())
/// ```
///
/// # Errors
/// [`Error::Shape`](crate::Error::Shape) when B has not m rows; else as [`ata`].
pub fn atb<T: BlasReal>(
    a: impl AsMatRef<T = T, Rows = usize, Cols = usize>,
    b: impl AsMatRef<T = T, Rows = usize, Cols = usize>,
) -> Result<Mat<T>> {
    let (a, b) = (a.as_mat_ref(), b.as_mat_ref());
    let mut c = filled(a.ncols(), b.ncols(), |_, _| T::ZERO)?;
    atb_into(T::ONE, a, b, T::ZERO, c.as_mut(), &AtaOptions::new())?;
    Ok(c)
}

/// Returns `A^H A` of a complex matrix, both triangles: the upper one is the conjugate of the lower
/// one, bit for bit. A is m x n, as in [`ata`]; the result is n x n and Hermitian. [`aha_into`]
/// takes options, factors, and memory for C.
///
/// ```
/// use catamaran::{aha, faer::{c64, mat}};
///
/// let a = mat![[c64::new(0.0, 2.0), c64::new(1.0, 1.0)]];
/// let c = aha(&a)?;
/// assert_eq!((c[(0, 0)], c[(1, 1)]), (c64::new(4.0, 0.0), c64::new(2.0, 0.0)));
/// assert_eq!((c[(1, 0)], c[(0, 1)]), (c64::new(2.0, 2.0), c64::new(2.0, -2.0)));
/// # Ok::<(), catamaran::Error>(())
/// ```
///
/// # Errors
/// As [`ata`].
pub fn aha<T: BlasReal>(
    a: impl AsMatRef<T = Complex<T>, Rows = usize, Cols = usize>,
) -> Result<Mat<Complex<T>>> {
    let a = a.as_mat_ref();
    let mut c = filled(a.ncols(), a.ncols(), |_, _| complex::<T>(T::ZERO))?;
    aha_into(T::ONE, a, T::ZERO, c.as_mut(), &both())?;
    Ok(c)
}

/// Returns `A^H B` of complex matrices. A is m x n, B is m x k, as in [`ata`]; the result is n x k.
/// [`ahb_into`] takes options, factors, and memory for C.
///
/// ```
/// use catamaran::{ahb, faer::{c64, mat}};
///
/// let (a, b) = (mat![[c64::new(0.0, 1.0)]], mat![[c64::new(2.0, 0.0), c64::new(0.0, 3.0)]]);
/// assert_eq!(ahb(&a, &b)?, mat![[c64::new(0.0, -2.0), c64::new(3.0, 0.0)]]);
/// # Ok::<(), catamaran::Error>(())
/// ```
///
/// # Errors
/// As [`atb`].
pub fn ahb<T: BlasReal>(
    a: impl AsMatRef<T = Complex<T>, Rows = usize, Cols = usize>,
    b: impl AsMatRef<T = Complex<T>, Rows = usize, Cols = usize>,
) -> Result<Mat<Complex<T>>> {
    let (a, b) = (a.as_mat_ref(), b.as_mat_ref());
    let mut c = filled(a.ncols(), b.ncols(), |_, _| complex::<T>(T::ZERO))?;
    ahb_into(complex(T::ONE), a, b, complex(T::ZERO), c.as_mut(), &AtaOptions::new())?;
    Ok(c)
}

/// Returns the default options, for both triangles.
fn both() -> AtaOptions<'static> {
    AtaOptions::new().uplo(Uplo::Both)
}

/// Returns a complex number without an imaginary part.
fn complex<T: BlasReal>(re: T) -> Complex<T> {
    Complex { re, im: T::ZERO }
}
