//! Filters of functions in the spectrum of a basis (thesis, section 1.4.2).

use faer::{Mat, MatRef};

use super::basis::{Basis, times_mass};
use super::dense;
use catamaran::base::{Error, Par, Result};
use catamaran::sparse::{CsMatView, Mass};

/// The gain of a filter for each frequency. A frequency is an eigenvalue, or the Dirichlet energy
/// of a basis function, in 1 / length^2.
///
/// ```
/// use catamaran_geometry::spectral::Response;
///
/// assert_eq!(Response::BandPass(1.0, 2.0).gain(1.5), 1.0);
/// assert_eq!(Response::LowPass(1.0).gain(1.5), 0.0);
/// assert_eq!(Response::Sharpen { time: 1.0, amount: 0.5 }.limit(), 1.5);
/// ```
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Response {
    /// 1 up to this frequency, 0 beyond.
    LowPass(f64),
    /// 0 up to this frequency, 1 beyond.
    HighPass(f64),
    /// 1 from the first to the second frequency, both included, 0 elsewhere.
    BandPass(f64, f64),
    /// `exp(-t frequency)`: diffusion for the time t, in length^2.
    Heat(f64),
    /// `1 + amount (1 - exp(-t frequency))`: amplifies what diffusion for the time t removes.
    Sharpen {
        /// Time, in length^2.
        time: f64,
        /// Additional gain of the highest frequencies.
        amount: f64,
    },
}

impl Response {
    /// Returns the gain for a frequency.
    pub fn gain(self, frequency: f64) -> f64 {
        let pass = |passes: bool| f64::from(u8::from(passes));
        match self {
            Self::LowPass(cutoff) => pass(frequency <= cutoff),
            Self::HighPass(cutoff) => pass(frequency > cutoff),
            Self::BandPass(from, to) => pass((from..=to).contains(&frequency)),
            Self::Heat(time) => (-time * frequency.max(0.0)).exp(),
            Self::Sharpen { time, amount } => 1.0 - amount * (-time * frequency.max(0.0)).exp_m1(),
        }
    }

    /// Returns the gain for frequencies beyond every frequency of a basis.
    pub fn limit(self) -> f64 {
        self.gain(f64::MAX)
    }
}

/// Multiplies the coefficients of functions by gains.
///
/// `f` is n x c, and there is a gain for each function of the basis. The part of `f` outside of the
/// span is multiplied by `rest`: 0 removes it, as in the thesis, and 1 keeps detail that is finer
/// than the basis.
///
/// ```
/// use catamaran_geometry::spectral::{Eigenbasis, Response, coordinates, filter};
/// use catamaran_geometry::prelude::*;
/// use catamaran_geometry::mesh::families;
///
/// # let mesh = families::icosphere(2)?;
/// # let operator = laplacian(&mesh, &LaplacianOptions::new())?;
/// # let pairs = eigs(operator.stiffness.view(), &operator.mass, &EigenOptions::new().k(9))?;
/// # let basis = Eigenbasis::new(pairs.values, pairs.vectors, operator.mass)?;
/// // On the unit sphere, the coordinates are eigenfunctions of the eigenvalue 2.
/// let f = coordinates(&mesh);
/// let gains: Vec<f64> = basis.values().iter().map(|&x| Response::HighPass(3.0).gain(x)).collect();
/// let high = filter(basis.basis(), f.as_ref(), &gains, 0.0, Par::Seq)?;
/// assert!(high.norm_max() < 0.01);
/// # Ok::<(), catamaran::Error>(())
/// ```
///
/// # Errors
/// [`Error::Shape`] when `f` does not have n rows, or the numbers of gains and functions differ,
/// [`Error::NonFinite`], [`Error::OutOfMemory`].
pub fn filter(
    basis: &Basis,
    f: MatRef<'_, f64>,
    gains: &[f64],
    rest: f64,
    par: Par,
) -> Result<Mat<f64>> {
    Error::check_shape("gains", (basis.len(), 1), (gains.len(), 1))?;
    if let Some(index) = gains.iter().position(|gain| !gain.is_finite()) {
        return Err(Error::NonFinite { what: "gains", index: (index, 0) });
    }
    if !rest.is_finite() {
        return Err(Error::NonFinite { what: "rest", index: (0, 0) });
    }
    let mut coefficients = basis.analysis(f, par)?;
    for j in 0..coefficients.ncols() {
        for (i, gain) in gains.iter().enumerate() {
            coefficients[(i, j)] *= gain - rest;
        }
    }
    let mut out = basis.synthesis(coefficients.as_ref(), par)?;
    for j in 0..out.ncols() {
        for i in 0..out.nrows() {
            out[(i, j)] += rest * f[(i, j)];
        }
    }
    Ok(out)
}

/// Adds `amount` times one function of the basis to every column of `f`, which changes a single
/// coefficient (figure 1.15).
///
/// ```
/// use catamaran::{faer::{Mat, mat}, sparse::Mass};
/// use catamaran_geometry::spectral::{Basis, add_coefficient};
///
/// let basis = Basis::orthonormal(Mat::identity(3, 2), Mass::identity(3))?;
/// let f = mat![[1.0], [1.0], [1.0]];
/// assert_eq!(add_coefficient(&basis, f.as_ref(), 1, 0.5)?, mat![[1.0], [1.5], [1.0]]);
/// # Ok::<(), catamaran::Error>(())
/// ```
///
/// # Errors
/// [`Error::Shape`] when `f` does not have n rows, [`Error::Argument`] when the function does not
/// exist.
pub fn add_coefficient(
    basis: &Basis,
    f: MatRef<'_, f64>,
    index: usize,
    amount: f64,
) -> Result<Mat<f64>> {
    Error::check_shape("functions", (basis.vertices(), f.ncols()), f.shape())?;
    if index >= basis.len() {
        let why = format!("{index} is not one of the {} functions", basis.len());
        return Err(Error::Argument { what: "index", why });
    }
    let function = basis.functions().col(index);
    Ok(Mat::from_fn(f.nrows(), f.ncols(), |i, j| f[(i, j)] + amount * function[i]))
}

/// Computes the Dirichlet energy `<q, W q> / <q, q>` of each function (thesis, definition 7): for
/// eigenfunctions the eigenvalue, for products the closest equivalent of a frequency.
///
/// `functions` is n x r, the stiffness matrix W and the mass are n x n. The energy of the function
/// zero is 0.
///
/// ```
/// use catamaran_geometry::prelude::*;
/// use catamaran_geometry::{mesh::families, spectral::dirichlet_energies};
///
/// let Laplacian { stiffness, mass, .. } =
///     laplacian(&families::icosphere(2)?, &LaplacianOptions::new())?;
/// let pairs = eigs(stiffness.view(), &mass, &EigenOptions::new().k(4))?;
/// let energies = dirichlet_energies(pairs.vectors.as_ref(), stiffness.view(), &mass)?;
/// assert!(energies.iter().zip(&pairs.values).all(|(x, y)| (x - y).abs() < 1e-8));
/// # Ok::<(), catamaran::Error>(())
/// ```
///
/// # Errors
/// [`Error::Shape`] when the shapes do not fit, [`Error::NonFinite`], [`Error::OutOfMemory`].
pub fn dirichlet_energies(
    functions: MatRef<'_, f64>,
    stiffness: CsMatView<'_, f64>,
    mass: &Mass,
) -> Result<Vec<f64>> {
    let n = functions.nrows();
    Error::check_shape("stiffness", (n, n), (stiffness.rows(), stiffness.cols()))?;
    Error::check_shape("mass", (n, n), (mass.len(), mass.len()))?;
    dense::check_finite("functions", functions)?;
    let energy = |j: usize| -> Result<f64> {
        let q = functions.col(j);
        let weighted = times_mass(mass, functions.subcols(j, 1), Par::Seq)?;
        let square: f64 = q.transpose() * weighted.col(0);
        // W is symmetric: storage by rows and by columns is the same.
        let outer = stiffness.outer_iterator().enumerate();
        let energy: f64 =
            outer.map(|(i, row)| q[i] * row.iter().map(|(l, w)| w * q[l]).sum::<f64>()).sum();
        Ok(if square == 0.0 { 0.0 } else { energy / square })
    };
    (0..functions.ncols()).map(energy).collect()
}
