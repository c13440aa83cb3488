//! Transfer of functions between meshes (thesis, section 1.4.4).

use faer::{Mat, MatRef};

use super::basis::Basis;
use super::dense;
use catamaran::base::{Error, Par, Result};

/// A transfer of functions from a source to a target through two bases and a matrix between them: C
/// with eigenfunctions, or O with orthogonalized products.
///
/// ```
/// use catamaran::{Par, faer::{Mat, mat}, sparse::Mass};
/// use catamaran_geometry::spectral::{Basis, Transfer};
///
/// // From two vertices to three, of which the last two are images of the second.
/// let source = Basis::orthonormal(Mat::identity(2, 2), Mass::identity(2))?;
/// let target = Basis::orthonormal(Mat::identity(3, 3), Mass::identity(3))?;
/// let map = mat![[1.0, 0.0], [0.0, 1.0], [0.0, 1.0]];
/// let transfer = Transfer::new(&source, &target, map)?;
/// let found = transfer.apply(mat![[5.0], [7.0]].as_ref(), Par::Seq)?;
/// assert_eq!(found, mat![[5.0], [7.0], [7.0]]);
/// # Ok::<(), catamaran::Error>(())
/// ```
#[derive(Debug, Clone)]
pub struct Transfer<'a> {
    source: &'a Basis,
    target: &'a Basis,
    map: Mat<f64>,
}

impl<'a> Transfer<'a> {
    /// Creates a transfer by `map`, r_target x r_source.
    ///
    /// # Errors
    /// [`Error::Shape`] when the shape of the map does not fit the bases, [`Error::NonFinite`].
    pub fn new(source: &'a Basis, target: &'a Basis, map: Mat<f64>) -> Result<Self> {
        Error::check_shape("map", (target.len(), source.len()), map.shape())?;
        dense::check_finite("map", map.as_ref())?;
        Ok(Self { source, target, map })
    }

    /// Returns the matrix.
    pub fn map(&self) -> MatRef<'_, f64> {
        self.map.as_ref()
    }

    /// Computes the functions on the target, n_target x c, that correspond to the columns of `f`,
    /// n_source x c.
    ///
    /// # Errors
    /// [`Error::Shape`] when `f` has not as many rows as the source has vertices,
    /// [`Error::NonFinite`], [`Error::OutOfMemory`].
    pub fn apply(&self, f: MatRef<'_, f64>, par: Par) -> Result<Mat<f64>> {
        let coefficients = self.source.analysis(f, par)?;
        let images = dense::product(self.map.as_ref(), coefficients.as_ref(), par)?;
        self.target.synthesis(images.as_ref(), par)
    }
}
