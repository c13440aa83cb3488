//! Transfer of functions between meshes (thesis, section 1.4.4).

use faer::{Mat, MatRef};

use super::basis::Basis;
use super::dense;
use crate::base::{Error, Par, Result};

/// Transfer of functions from a source to a target through two bases and a matrix between them: C and eigenfunctions, or O and
/// orthogonalised products.
#[derive(Debug, Clone)]
pub struct Transfer<'a> {
    source: &'a Basis,
    target: &'a Basis,
    map: Mat<f64>,
}

impl<'a> Transfer<'a> {
    /// Transfer by `map`, r_target x r_source.
    ///
    /// # Errors
    /// [`Error::Shape`] when the map is of another shape, [`Error::NonFinite`].
    pub fn new(source: &'a Basis, target: &'a Basis, map: Mat<f64>) -> Result<Self> {
        Error::check_shape("map", (target.len(), source.len()), map.shape())?;
        dense::check_finite("map", map.as_ref())?;
        Ok(Self { source, target, map })
    }

    /// The matrix.
    pub fn map(&self) -> MatRef<'_, f64> {
        self.map.as_ref()
    }

    /// The functions on the target, n_target x c, that correspond to the columns of `f`, n_source x c.
    ///
    /// # Errors
    /// [`Error::Shape`] when `f` has not as many rows as the source has vertices, [`Error::NonFinite`],
    /// [`Error::OutOfMemory`].
    pub fn apply(&self, f: MatRef<'_, f64>, par: Par) -> Result<Mat<f64>> {
        let coefficients = self.source.analysis(f, par)?;
        let images = dense::product(self.map.as_ref(), coefficients.as_ref(), par)?;
        self.target.synthesis(images.as_ref(), par)
    }
}
