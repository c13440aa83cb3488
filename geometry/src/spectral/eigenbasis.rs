//! The first eigenfunctions of the Laplacian as a basis.

use faer::{Mat, MatRef};

use super::basis::Basis;
use catamaran::base::{Error, Par, Result};
use catamaran::sparse::Mass;

/// Eigenvalues below this share of the largest one, or of 1 / area, count as zero.
const NULL: f64 = 1e-8;

/// Largest deficit of the squared norm of the constant function in the null space.
const CONSTANT: f64 = 1e-6;

/// The first eigenfunctions of a Laplacian, `W phi = lambda M phi`, orthonormal in the inner
/// product of the mass M.
///
/// Where the constant is among the functions with eigenvalue zero, as it is unless boundary values
/// are prescribed, it becomes the first function, positive. A mesh of several components has
/// several such functions, which any rotation maps to equally good ones: they are rotated so that
/// the constant is among them.
///
/// ```
/// use catamaran_geometry::prelude::*;
/// use catamaran_geometry::{mesh::families, spectral::Eigenbasis};
///
/// let operator = laplacian(&families::icosphere(2)?, &LaplacianOptions::new())?;
/// let pairs = eigs(operator.stiffness.view(), &operator.mass, &EigenOptions::new().k(4))?;
/// let basis = Eigenbasis::new(pairs.values, pairs.vectors, operator.mass)?;
/// let constant = basis.constant().unwrap();
/// assert!((constant * basis.basis().area()?.sqrt() - 1.0).abs() < 1e-12);
/// # Ok::<(), catamaran::Error>(())
/// ```
#[derive(Debug, Clone)]
pub struct Eigenbasis {
    values: Vec<f64>,
    basis: Basis,
    constant: Option<f64>,
}

impl Eigenbasis {
    /// Creates a basis of these eigenpairs: `values` ascending, `vectors` n x r, M-orthonormal
    /// (which is not checked).
    ///
    /// # Errors
    /// [`Error::Shape`] when the numbers of values, columns, rows and masses differ,
    /// [`Error::NonFinite`], [`Error::Argument`] when the values do not ascend.
    pub fn new(values: Vec<f64>, vectors: Mat<f64>, mass: Mass) -> Result<Self> {
        Error::check_shape("eigenvalues", (vectors.ncols(), 1), (values.len(), 1))?;
        if let Some(index) = values.iter().position(|value| !value.is_finite()) {
            return Err(Error::NonFinite { what: "eigenvalues", index: (index, 0) });
        }
        if let Some(index) = (1..values.len()).find(|&i| values[i] < values[i - 1]) {
            let why = format!("must ascend, but value {index} is less than the one before it");
            return Err(Error::Argument { what: "eigenvalues", why });
        }
        let mut basis = Basis::orthonormal(vectors, mass)?;
        let constant = constant_first(&values, &mut basis)?;
        Ok(Self { values, basis, constant })
    }

    /// Returns the basis of the first `len` functions; of all of them if there are fewer.
    ///
    /// ```
    /// use catamaran::{faer::Mat, sparse::Mass};
    /// use catamaran_geometry::spectral::Eigenbasis;
    ///
    /// let vectors = Mat::<f64>::identity(3, 3);
    /// let basis = Eigenbasis::new(vec![1.0, 2.0, 4.0], vectors, Mass::identity(3))?;
    /// assert_eq!(basis.truncated(2)?.values(), [1.0, 2.0]);
    /// # Ok::<(), catamaran::Error>(())
    /// ```
    ///
    /// # Errors
    /// [`Error::OutOfMemory`].
    pub fn truncated(&self, len: usize) -> Result<Self> {
        let len = len.min(self.len());
        let functions = self.functions().subcols(0, len).to_owned();
        let basis = Basis::orthonormal(functions, self.basis.mass().clone())?;
        let constant = self.constant.filter(|_| len > 0);
        Ok(Self { values: self.values[..len].to_vec(), basis, constant })
    }

    /// Returns the functions with their inner product.
    pub fn basis(&self) -> &Basis {
        &self.basis
    }

    /// Returns the eigenvalues, ascending; in units of 1 / length^2.
    pub fn values(&self) -> &[f64] {
        &self.values
    }

    /// Returns the eigenvalues of the mesh as if scaled to area 1, which have no unit.
    pub(super) fn unit_values(&self) -> Result<Vec<f64>> {
        let area = self.basis.area()?;
        Ok(self.values.iter().map(|value| value * area).collect())
    }

    /// Returns the functions, n x r; in units of 1 / length.
    pub fn functions(&self) -> MatRef<'_, f64> {
        self.basis.functions()
    }

    /// Returns the number of functions, the constant included.
    pub fn len(&self) -> usize {
        self.values.len()
    }

    /// Returns whether the basis has no functions.
    pub fn is_empty(&self) -> bool {
        self.values.is_empty()
    }

    /// Returns the value of the first function where that function is the constant,
    /// `1 / sqrt(area)`; `None` otherwise.
    pub fn constant(&self) -> Option<f64> {
        self.constant
    }

    /// Returns [`Eigenbasis::constant`], or an error that names the argument `what`.
    pub(super) fn need_constant(&self, what: &'static str) -> Result<f64> {
        self.constant.ok_or_else(|| {
            let (len, area) = (self.len(), self.basis.area().unwrap_or(f64::INFINITY));
            // Eigenfunctions of eigenvalue zero, one for each component, come first.
            let why = match null_count(&self.values, area) {
                null if null == len => format!(
                    "all {len} eigenvalues are zero: to contain the constant, the basis needs more \
                     functions than the mesh has components"
                ),
                _ => "the constant is not among the eigenfunctions (prescribed boundary values?)"
                    .into(),
            };
            Error::Argument { what, why }
        })
    }

    /// Computes the coefficients of `f`, as [`Basis::analysis`] does.
    ///
    /// # Errors
    /// As [`Basis::analysis`].
    pub fn analysis(&self, f: MatRef<'_, f64>, par: Par) -> Result<Mat<f64>> {
        self.basis.analysis(f, par)
    }
}

/// Returns how many of these eigenvalues, which ascend, are zero on a mesh of this area.
fn null_count(values: &[f64], area: f64) -> usize {
    let largest = values.last().copied().unwrap_or(0.0);
    let zero = NULL * largest.max(1.0 / area);
    values.partition_point(|&value| value <= zero)
}

/// Makes the constant the first function if it lies in the null space; returns its value.
fn constant_first(values: &[f64], basis: &mut Basis) -> Result<Option<f64>> {
    let Ok(area) = basis.area() else { return Ok(None) };
    let null = null_count(values, area);
    if null == 0 {
        return Ok(None);
    }
    let value = 1.0 / area.sqrt();
    // Coefficients of the normalized constant in the null space: a vector of norm 1 if the constant
    // lies there.
    let ones = Mat::<f64>::ones(basis.vertices(), 1);
    let parts = basis.analysis(ones.as_ref(), Par::Seq)?;
    let mut parts: Vec<f64> = parts.col(0).iter().take(null).map(|part| part * value).collect();
    let norm: f64 = parts.iter().map(|part| part * part).sum();
    if (norm - 1.0).abs() > CONSTANT {
        return Ok(None);
    }
    parts.iter_mut().for_each(|part| *part /= norm.sqrt());
    basis.reflect(&parts);
    // Up to rounding it is constant already.
    basis.set_constant(0, value);
    Ok(Some(value))
}
