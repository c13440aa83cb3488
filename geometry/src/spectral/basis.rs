//! Functions on a mesh as coefficients in a basis: analysis and synthesis in the inner product of
//! the mass.

use faer::{Mat, MatRef};

use super::dense;
use catamaran::base::{Error, Par, Result};
use catamaran::dense::zeros;
use catamaran::sparse::Mass;

/// Number of columns that are weighted at once: M X of all functions would take as much memory as
/// the functions.
const PANEL: usize = 256;

/// A function depends on those before it, up to rounding, if less than this share of its square is
/// left beyond them.
const DEPENDENT: f64 = 1e-14;

/// Linearly independent functions on the n vertices of a mesh, as the columns of Q, and the inner
/// product `<f, g> = f^T M g` of its mass.
///
/// ```
/// use catamaran::{Par, faer::Mat, sparse::Mass};
/// use catamaran_geometry::spectral::Basis;
///
/// // The functions 1 and x on four points; x^2 is nearest to 3 x - 1.
/// let functions = Mat::from_fn(4, 2, |i, j| (i as f64).powi(j as i32));
/// let basis = Basis::independent(functions, Mass::identity(4), Par::Seq)?;
/// let square = Mat::from_fn(4, 1, |i, _| (i * i) as f64);
/// let found = basis.analysis(square.as_ref(), Par::Seq)?;
/// assert!((found[(0, 0)] + 1.0).abs() < 1e-12 && (found[(1, 0)] - 3.0).abs() < 1e-12);
/// # Ok::<(), catamaran::Error>(())
/// ```
#[derive(Debug, Clone)]
pub struct Basis {
    functions: Mat<f64>,
    mass: Mass,
    /// The Cholesky factor of `Q^T M Q`; `None` for the identity.
    gram: Option<Mat<f64>>,
}

impl Basis {
    /// Creates a basis of functions that are orthonormal, `Q^T M Q = I`, which is not checked.
    ///
    /// `functions` is n x r, the mass n x n.
    ///
    /// # Errors
    /// [`Error::Shape`] when the mass does not have n vertices, [`Error::NonFinite`],
    /// [`Error::Argument`] for a mass that is not positive or symmetric.
    pub fn orthonormal(functions: Mat<f64>, mass: Mass) -> Result<Self> {
        mass.check(functions.nrows())?;
        dense::check_finite("functions", functions.as_ref())?;
        Ok(Self { functions, mass, gram: None })
    }

    /// Creates a basis of functions that are linearly independent but need not be orthogonal:
    /// projections onto their span are by least squares.
    ///
    /// # Errors
    /// As [`Basis::orthonormal`]; [`Error::Argument`] names the first function that is, up to
    /// rounding, a combination of those before it.
    pub fn independent(functions: Mat<f64>, mass: Mass, par: Par) -> Result<Self> {
        let mut basis = Self::orthonormal(functions, mass)?;
        let q = basis.functions.as_ref();
        let gram = basis.inner_products(q, par)?;
        let squares: Vec<f64> = (0..basis.len()).map(|j| gram[(j, j)]).collect();
        let dependent = |column: usize| Error::Argument {
            what: "functions",
            why: format!("function {column} is a linear combination of those before it"),
        };
        let factor = dense::cholesky(gram)?.map_err(dependent)?;
        let is_lost = |j: &usize| factor[(*j, *j)].powi(2) <= DEPENDENT * squares[*j];
        if let Some(column) = (0..basis.len()).find(is_lost) {
            return Err(dependent(column));
        }
        basis.gram = Some(factor);
        Ok(basis)
    }

    /// Returns the functions, n x r.
    pub fn functions(&self) -> MatRef<'_, f64> {
        self.functions.as_ref()
    }

    /// Returns whether the functions are orthonormal, as those of [`Basis::orthonormal`] are.
    pub fn is_orthonormal(&self) -> bool {
        self.gram.is_none()
    }

    /// Returns the inner product.
    pub fn mass(&self) -> &Mass {
        &self.mass
    }

    /// Returns the number n of vertices.
    pub fn vertices(&self) -> usize {
        self.functions.nrows()
    }

    /// Returns the number r of functions.
    pub fn len(&self) -> usize {
        self.functions.ncols()
    }

    /// Returns whether the basis has no functions.
    pub fn is_empty(&self) -> bool {
        self.len() == 0
    }

    /// Computes the coefficients, r x c, of the functions in the span that are nearest to the
    /// columns of `f`, n x c, in the norm of the mass.
    ///
    /// ```
    /// use catamaran::{Par, faer::{Mat, mat}, sparse::Mass};
    /// use catamaran_geometry::spectral::Basis;
    ///
    /// let basis = Basis::orthonormal(Mat::identity(3, 2), Mass::identity(3))?;
    /// let f = mat![[5.0], [6.0], [7.0]];
    /// assert_eq!(basis.analysis(f.as_ref(), Par::Seq)?, mat![[5.0], [6.0]]);
    /// assert_eq!(basis.approximation(f.as_ref(), Par::Seq)?, mat![[5.0], [6.0], [0.0]]);
    /// # Ok::<(), catamaran::Error>(())
    /// ```
    ///
    /// # Errors
    /// [`Error::Shape`] when `f` does not have n rows, [`Error::NonFinite`],
    /// [`Error::OutOfMemory`].
    pub fn analysis(&self, f: MatRef<'_, f64>, par: Par) -> Result<Mat<f64>> {
        Error::check_shape("functions", (self.vertices(), f.ncols()), f.shape())?;
        dense::check_finite("functions", f)?;
        let mut coefficients = self.inner_products(f, par)?;
        if let Some(factor) = &self.gram {
            dense::solve_cholesky(factor.as_ref(), coefficients.as_mut());
        }
        Ok(coefficients)
    }

    /// Computes the functions, n x c, with these coefficients, r x c.
    ///
    /// ```
    /// use catamaran::{Par, faer::{Mat, mat}, sparse::Mass};
    /// use catamaran_geometry::spectral::Basis;
    ///
    /// let basis = Basis::orthonormal(Mat::identity(3, 2), Mass::identity(3))?;
    /// let f = basis.synthesis(mat![[5.0], [6.0]].as_ref(), Par::Seq)?;
    /// assert_eq!(f, mat![[5.0], [6.0], [0.0]]);
    /// # Ok::<(), catamaran::Error>(())
    /// ```
    ///
    /// # Errors
    /// [`Error::Shape`] when there are not r rows, [`Error::OutOfMemory`].
    pub fn synthesis(&self, coefficients: MatRef<'_, f64>, par: Par) -> Result<Mat<f64>> {
        let expected = (self.len(), coefficients.ncols());
        Error::check_shape("coefficients", expected, coefficients.shape())?;
        dense::product(self.functions(), coefficients, par)
    }

    /// Computes the nearest functions in the span: analysis, then synthesis (thesis, section
    /// 1.4.3). The example of [`Basis::analysis`] shows both.
    ///
    /// # Errors
    /// As [`Basis::analysis`].
    pub fn approximation(&self, f: MatRef<'_, f64>, par: Par) -> Result<Mat<f64>> {
        self.synthesis(self.analysis(f, par)?.as_ref(), par)
    }

    /// Reflects the first functions, which are orthonormal, so that the combination with these
    /// coefficients, of norm 1, comes first (Householder 1958).
    pub(super) fn reflect(&mut self, coefficients: &[f64]) {
        // The mirror maps `coefficients` to the first axis; the sign avoids cancellation.
        let sign = if coefficients[0] > 0.0 { -1.0 } else { 1.0 };
        let mut normal = coefficients.to_vec();
        normal[0] -= sign;
        let scale = 2.0 / normal.iter().map(|x| x * x).sum::<f64>();
        for i in 0..self.vertices() {
            let mut along = 0.0;
            for (j, x) in normal.iter().enumerate() {
                along += x * self.functions[(i, j)];
            }
            for (j, x) in normal.iter().enumerate() {
                self.functions[(i, j)] -= scale * along * x;
            }
            self.functions[(i, 0)] *= sign;
        }
    }

    /// Makes a function constant.
    pub(super) fn set_constant(&mut self, column: usize, value: f64) {
        self.functions.col_mut(column).fill(value);
    }

    /// Returns the area of the mesh, `1^T M 1`.
    ///
    /// ```
    /// use catamaran::{faer::Mat, sparse::Mass};
    /// use catamaran_geometry::spectral::Basis;
    ///
    /// assert_eq!(Basis::orthonormal(Mat::identity(3, 2), Mass::identity(3))?.area()?, 3.0);
    /// # Ok::<(), catamaran::Error>(())
    /// ```
    ///
    /// # Errors
    /// [`Error::Argument`] when the area is not positive, as without vertices.
    pub fn area(&self) -> Result<f64> {
        let weighted = times_mass(&self.mass, Mat::ones(self.vertices(), 1).as_ref(), Par::Seq)?;
        let area: f64 = weighted.col(0).iter().sum();
        if area.is_finite() && area > 0.0 {
            return Ok(area);
        }
        Err(Error::Argument { what: "mass", why: format!("the area must be positive, is {area}") })
    }

    /// Computes `Q^T M F`.
    fn inner_products(&self, f: MatRef<'_, f64>, par: Par) -> Result<Mat<f64>> {
        let mut out = zeros(self.len(), f.ncols())?;
        for first in (0..f.ncols()).step_by(PANEL) {
            let width = PANEL.min(f.ncols() - first);
            let weighted = times_mass(&self.mass, f.subcols(first, width), par)?;
            let into = out.as_mut().subcols_mut(first, width);
            dense::transposed_product_into(self.functions(), weighted.as_ref(), into, par)?;
        }
        Ok(out)
    }
}

/// Computes the error `|f_j - g_j| / |f_j|` of each column, in the norm of the mass, of an
/// approximation or a transfer g of f (thesis, sections 1.4.3 and 1.4.4).
///
/// Both are n x c. The error is 0 where both columns are zero, and infinite where only f is zero.
///
/// ```
/// use catamaran::{faer::mat, sparse::Mass};
/// use catamaran_geometry::spectral::relative_errors;
///
/// let (f, g) = (mat![[2.0], [4.0]], mat![[1.0], [2.0]]);
/// assert_eq!(relative_errors(f.as_ref(), g.as_ref(), &Mass::identity(2))?, [0.5]);
/// # Ok::<(), catamaran::Error>(())
/// ```
///
/// # Errors
/// [`Error::Shape`] when shapes differ or the mass does not have n vertices, [`Error::NonFinite`].
pub fn relative_errors(f: MatRef<'_, f64>, g: MatRef<'_, f64>, mass: &Mass) -> Result<Vec<f64>> {
    Error::check_shape("approximation", f.shape(), g.shape())?;
    Error::check_shape("mass", (f.nrows(), f.nrows()), (mass.len(), mass.len()))?;
    dense::check_finite("functions", f)?;
    dense::check_finite("approximation", g)?;
    let squares = |x: MatRef<'_, f64>| -> Result<Vec<f64>> {
        let weighted = times_mass(mass, x, Par::Seq)?;
        let square = |j: usize| x.col(j).transpose() * weighted.col(j);
        Ok((0..x.ncols()).map(square).collect())
    };
    let errors = squares((f - g).as_ref())?;
    let relative = |(error, norm): (f64, f64)| {
        if error == 0.0 { 0.0 } else { (error.max(0.0) / norm.max(0.0)).sqrt() }
    };
    Ok(errors.into_iter().zip(squares(f)?).map(relative).collect())
}

/// Computes `M X`.
pub(super) fn times_mass(mass: &Mass, x: MatRef<'_, f64>, par: Par) -> Result<Mat<f64>> {
    let mut out = zeros(x.nrows(), x.ncols())?;
    mass.multiply(x, out.as_mut(), par)?;
    Ok(out)
}
