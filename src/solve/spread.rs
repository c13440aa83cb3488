//! The root of the covariance of coefficients, and lengths in it.

use faer::Mat;

use super::columns::Columns;
use super::double::DoubleDouble;
use super::tails::t_quantile;
use crate::base::{Error, Result};
use crate::dense::zeros;
use crate::rows::ExtendedGram;

/// A root of the covariance of coefficients: F, for which `F F^T` is that covariance when residuals
/// have variance 1.
#[derive(Debug, Clone)]
pub(crate) struct Spread {
    /// F^T, r x n.
    pub root: Mat<f64>,
    /// The row of F for the intercept, r numbers, less what [`Spread::weight`] adds; none without
    /// intercept.
    pub constant: Vec<f64>,
    /// The mean of each column with an intercept, else zeros.
    pub mean: Vec<f64>,
    /// The sum of the weights with an intercept, else infinity: its inverse is the variance of
    /// the mean of the targets.
    pub weight: f64,
}

impl Spread {
    /// Creates a spread of n columns to be overwritten, with the most rows that a root has.
    #[cfg(feature = "mpi")]
    pub fn blank(n: usize, intercept: bool) -> Result<Self> {
        let constant = vec![0.0; if intercept { n } else { 0 }];
        Ok(Self { root: zeros(n, n)?, constant, mean: vec![0.0; n], weight: f64::INFINITY })
    }

    /// Creates the spread from F, by rows in this order of the columns.
    pub(super) fn new(
        gram: &ExtendedGram,
        order: &[usize],
        rows: &Columns<2>,
        intercept: bool,
    ) -> Result<Self> {
        let n = order.len();
        let mut root = zeros(rows.rows, n)?;
        for (i, &column) in order.iter().enumerate() {
            let row = &rows.col(i, 0)[0][..rows.rows];
            root.col_as_slice_mut(column).copy_from_slice(row);
        }
        if !intercept {
            return Ok(Self {
                root,
                constant: Vec::new(),
                mean: vec![0.0; n],
                weight: f64::INFINITY,
            });
        }
        let mut sum = Columns::<2>::new(rows.rows, 1)?;
        let mut constant = sum.pairs_mut(0, 0);
        constant.subtract(
            rows.columns(),
            n,
            #[inline(always)]
            |i| {
                let [hi, lo] = gram.mean()[order[i]];
                DoubleDouble { hi, lo }
            },
        );
        constant.normalize();
        let constant = sum.col(0, 0)[0][..rows.rows].to_vec();
        let mean = gram.mean()[..n].iter().map(|mean| mean[0]).collect();
        Ok(Self { root, constant, mean, weight: gram.weight() })
    }

    /// Returns the standard error of a coefficient when residuals have variance 1.
    pub fn length(&self, column: usize) -> f64 {
        norm(self.root.col_as_slice(column))
    }

    /// Returns the standard error of the intercept when residuals have variance 1.
    pub fn intercept_length(&self) -> f64 {
        norm(&self.constant).hypot(self.weight.sqrt().recip())
    }
}

/// Returns the Euclidean norm of a vector, whose squares may be out of range.
pub(super) fn norm(x: &[f64]) -> f64 {
    let largest = x.iter().fold(0.0_f64, |a, b| a.max(b.abs()));
    if largest == 0.0 {
        // Zeros, or NaN.
        return x.iter().sum::<f64>().abs();
    }
    let sum: f64 = x.iter().map(|x| (x / largest) * (x / largest)).sum();
    largest * sum.sqrt()
}

/// Returns the standard deviations of residuals of these norms.
pub(super) fn deviations(norms: &[f64], freedom: u64) -> Vec<f64> {
    let root = (freedom as f64).sqrt();
    let deviation = |norm| if freedom > 0 { norm / root } else { f64::NAN };
    norms.iter().map(|&norm| deviation(norm)).collect()
}

/// Returns the t quantile of confidence intervals.
pub(super) fn confidence_factor(confidence: f64, freedom: u64) -> Result<f64> {
    if confidence > 0.0 && confidence < 1.0 {
        return Ok(t_quantile(1.0 - confidence, freedom as f64));
    }
    let why = format!("must be above 0 and below 1, is {confidence}");
    Err(Error::Argument { what: "confidence", why })
}
