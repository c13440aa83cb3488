use std::collections::BTreeMap;
use std::path::Path;

use catamaran::base::{Error, Result, options};
use catamaran::dense;
use faer::{Mat, Scale};
use serde::{Deserialize, Serialize};

options! {
    /// Options of fitting a [`RetrievalMetric`].
    #[derive(Debug, Clone, PartialEq)]
    pub struct MetricOptions {
        /// Number of eigenvalues at the start of each spectrum that are zero and left out: one for
        /// each component of a shape without a vertex that is held at zero.
        zeros: usize = 1, range "less than the number of eigenvalues";
        /// Whether shapes that differ only in size count as the same.
        scale_free: bool = false;
        /// Share of the covariance of errors that is replaced by their mean variance, equal for all
        /// eigenvalues and independent: predictions for new shapes have errors that do not occur in
        /// the fit.
        shrinkage: f64 = 0.5, check(from 0.0 to 1.0);
        /// Whether the differences of identities are taken as much larger than those of poses,
        /// instead of estimated, which needs many identities.
        poses_only: bool = false;
        /// What the eigenvalues are, in words that the file of the metric keeps.
        spectrum: String = String::new(), setter into;
    }
}

/// Added to the variance of each logarithm within an identity: differences of 0.1 % are caused by
/// the mesh.
const NOISE: f64 = 1e-6;

/// The least eigenvalue that is no zero, as a share of the largest one of its spectrum.
const LEAST: f64 = 1e-9;

/// A distance between spectra that is small for two poses of one shape: how unlikely it is that
/// both have the same identity. It is fitted to shapes of known identity in several poses. The
/// query may also be a predicted spectrum with errors.
///
/// The logarithms of eigenvalues are the sum of those of the identity, a contribution of the pose,
/// and errors of the prediction, each normally distributed. Let W be the covariance of poses, T
/// that of all shapes, m their mean, and C and e the covariance and the mean of errors. Given a
/// shape g, a query q of the same identity is then normally distributed about
/// `m + e + (1 - W T^-1) (g - m)` with covariance `S = 2 W - W T^-1 W + C`. The distance is the
/// Mahalanobis distance of this distribution. If identities differ much more than poses (T is
/// large; `poses_only` of [`MetricOptions`]), it is that of q - e - g for the covariance `2 W + C`.
///
/// Source: Ioffe, Probabilistic Linear Discriminant Analysis (2006).
///
/// ```
/// use catamaran_geometry::unions::{MetricOptions, RetrievalMetric};
///
/// // Two shapes of two poses each, whose third eigenvalue depends on the pose.
/// let spectra = [[0.0, 2.0, 5.0], [0.0, 2.02, 6.0], [0.0, 3.0, 5.5], [0.0, 3.01, 7.0]];
/// let options = MetricOptions::new().poses_only(true);
/// let metric = RetrievalMetric::fit(&spectra, &[0, 0, 1, 1], &[], &options)?;
/// let query = [0.0, 2.01, 7.0];
/// assert!(metric.distance(&query, &spectra[0])? < metric.distance(&query, &spectra[3])?);
/// # Ok::<(), catamaran::Error>(())
/// ```
#[derive(Debug, Clone, PartialEq)]
pub struct RetrievalMetric {
    zeros: usize,
    scale_free: bool,
    spectrum: String,
    /// m + e, which is subtracted from queries.
    query_mean: Vec<f64>,
    /// The inverse Cholesky factor of S.
    of_query: Mat<f64>,
    /// m.
    shape_mean: Vec<f64>,
    /// The same factor, multiplied by `1 - W T^-1`.
    of_shape: Mat<f64>,
}

impl RetrievalMetric {
    /// Fits a metric to spectra of k eigenvalues, of shapes with these identities, some of which
    /// have several poses, and to errors of predictions for such shapes: the logarithms of the
    /// k - `zeros` last predicted eigenvalues minus those of the true ones. For queries with true
    /// spectra, there are no errors.
    ///
    /// With p = k - zeros logarithms, 2 p + 3 identities are necessary, and several times as many
    /// are better: the inverse of a covariance that is estimated from n identities is too large by
    /// the factor `(n - 1) / (n - p - 2)` on average (mean of the inverse Wishart distribution),
    /// which is 2 for this number. Estimated from fewer, it makes new identities seem impossible,
    /// and Euclidean distances give better results. With `poses_only` this covariance is not used.
    /// Without errors, the poses that identities have beside their first ones must be p at least,
    /// and better several times as many; fewer do not determine the covariance of poses.
    ///
    /// # Errors
    /// [`Error::Argument`] for options out of their ranges, for fewer identities and poses, with
    /// the number that is necessary, for eigenvalues that are not positive, and for shapes that
    /// differ less than their poses; [`Error::Shape`] for lists of different lengths;
    /// [`Error::NonFinite`].
    pub fn fit<S: AsRef<[f64]>>(
        spectra: &[S],
        identities: &[usize],
        errors: &[Vec<f64>],
        options: &MetricOptions,
    ) -> Result<Self> {
        options.check_ranges()?;
        let &MetricOptions { zeros, scale_free, shrinkage, poses_only, .. } = options;
        Error::check_shape("identities", (spectra.len(), 1), (identities.len(), 1))?;
        let k = spectra.first().map_or(0, |spectrum| spectrum.as_ref().len());
        if zeros >= k {
            let why = format!("must be less than the number of eigenvalues, {k}, is {zeros}");
            return Err(refuse("zeros", why));
        }
        let size = k - zeros;
        let mut logs = Vec::with_capacity(spectra.len());
        for (row, spectrum) in spectra.iter().enumerate() {
            let spectrum = spectrum.as_ref();
            Error::check_shape("spectra", (k, 1), (spectrum.len(), 1))?;
            logs.push(logarithms("spectra", row, spectrum, zeros, scale_free)?);
        }
        let mut deviations = Vec::with_capacity(errors.len());
        for (row, error) in errors.iter().enumerate() {
            Error::check_shape("errors", (size, 1), (error.len(), 1))?;
            if let Some(column) = error.iter().position(|x| !x.is_finite()) {
                return Err(Error::NonFinite { what: "errors", index: (row, column) });
            }
            deviations.push(sized(error.clone(), scale_free));
        }
        let (errors, poses) = (deviations, Poses::new(&logs, identities));
        poses.check(size, poses_only, errors.is_empty())?;

        let (shape_mean, error_mean) = (mean(&logs, size), mean(&errors, size));
        let within = second_moment(&poses.deviations, size) + diagonal(NOISE, size);
        let spread = covariance(&errors, &error_mean);
        let variance = (0..size).map(|i| spread[(i, i)]).sum::<f64>() / size as f64;
        let spread = spread * Scale(1.0 - shrinkage) + diagonal(shrinkage * variance, size);
        // W T^-1.
        let share = if poses_only {
            Mat::<f64>::zeros(size, size)
        } else {
            let total = covariance(&logs, &shape_mean) + diagonal(NOISE, size);
            let why = "must have a finite covariance";
            let inverse = inverse_factor(total)?.ok_or_else(|| refuse("spectra", why.into()))?;
            product(&product(&within, &transposed(&inverse)), &inverse)
        };
        let scatter = &within * Scale(2.0) - product(&share, &within) + spread;
        let why = "must differ more than their poses";
        let of_query = inverse_factor(scatter)?.ok_or_else(|| refuse("spectra", why.into()))?;
        let of_shape = &of_query - product(&of_query, &share);
        let query_mean = shape_mean.iter().zip(&error_mean).map(|(m, e)| m + e).collect();
        let spectrum = options.spectrum.clone();
        Ok(Self { zeros, scale_free, spectrum, query_mean, of_query, shape_mean, of_shape })
    }

    /// Returns the number of eigenvalues of the spectra that it compares.
    pub fn k(&self) -> usize {
        self.zeros + self.shape_mean.len()
    }

    /// Returns the number of eigenvalues at the start of a spectrum that are left out.
    pub fn zeros(&self) -> usize {
        self.zeros
    }

    /// Returns what the eigenvalues are, in the words of the [`MetricOptions`].
    pub fn spectrum(&self) -> &str {
        &self.spectrum
    }

    /// Computes the signature of a query of [`k`](Self::k) eigenvalues. Its distance from a shape
    /// is the Euclidean distance of their signatures, as [`retrieve`](super::retrieve) compares
    /// them.
    ///
    /// # Errors
    /// [`Error::Shape`] for another number of eigenvalues, [`Error::NonFinite`], and
    /// [`Error::Argument`] for one that is not positive behind the zeros.
    pub fn of_query(&self, query: &[f64]) -> Result<Vec<f64>> {
        self.query(0, query)
    }

    /// Computes the signature of a shape among which queries search.
    ///
    /// # Errors
    /// As [`of_query`](Self::of_query).
    pub fn of_shape(&self, shape: &[f64]) -> Result<Vec<f64>> {
        self.shape(0, shape)
    }

    /// Computes the distance of a query from a shape; a pure number, about the square root of
    /// k - zeros if both have the same identity. It is not symmetric.
    ///
    /// # Errors
    /// As [`of_query`](Self::of_query).
    pub fn distance(&self, query: &[f64], shape: &[f64]) -> Result<f64> {
        Ok(self.distances(&[query], &[shape])?[(0, 0)])
    }

    /// Computes the [`distance`](Self::distance) of each query from each shape: a row for each
    /// query, a column for each shape.
    ///
    /// # Errors
    /// As [`of_query`](Self::of_query).
    pub fn distances<S: AsRef<[f64]>>(&self, queries: &[S], shapes: &[S]) -> Result<Mat<f64>> {
        let query = |(row, x): (usize, &S)| self.query(row, x.as_ref());
        let shape = |(row, x): (usize, &S)| self.shape(row, x.as_ref());
        let queries = queries.iter().enumerate().map(query).collect::<Result<Vec<_>>>()?;
        let shapes = shapes.iter().enumerate().map(shape).collect::<Result<Vec<_>>>()?;
        Ok(Mat::from_fn(queries.len(), shapes.len(), |i, j| {
            let pairs = queries[i].iter().zip(&shapes[j]);
            pairs.map(|(x, y)| (x - y) * (x - y)).sum::<f64>().sqrt()
        }))
    }

    fn query(&self, row: usize, spectrum: &[f64]) -> Result<Vec<f64>> {
        self.signature("query", row, spectrum, &self.query_mean, &self.of_query)
    }

    fn shape(&self, row: usize, spectrum: &[f64]) -> Result<Vec<f64>> {
        self.signature("shape", row, spectrum, &self.shape_mean, &self.of_shape)
    }

    fn signature(
        &self,
        what: &'static str,
        row: usize,
        spectrum: &[f64],
        mean: &[f64],
        matrix: &Mat<f64>,
    ) -> Result<Vec<f64>> {
        Error::check_shape(what, (self.k(), 1), (spectrum.len(), 1))?;
        let logs = logarithms(what, row, spectrum, self.zeros, self.scale_free)?;
        let logs = difference(&logs, mean);
        let entry = |i: usize| logs.iter().enumerate().map(|(j, x)| matrix[(i, j)] * x).sum();
        Ok((0..logs.len()).map(entry).collect())
    }

    /// Returns the bytes of a file of the metric, in JSON; the same metric gives the same bytes.
    ///
    /// # Errors
    /// [`Error::Argument`] when the format can't store the metric.
    pub fn to_bytes(&self) -> Result<Vec<u8>> {
        let file = File {
            format: FORMAT.into(),
            version: VERSION,
            spectrum: self.spectrum.clone(),
            zeros: self.zeros,
            scale_free: self.scale_free,
            query_mean: self.query_mean.clone(),
            shape_mean: self.shape_mean.clone(),
            of_query: rows(&self.of_query),
            of_shape: rows(&self.of_shape),
        };
        let mut bytes =
            serde_json::to_vec_pretty(&file).map_err(|e| refuse("metric", e.to_string()))?;
        bytes.push(b'\n');
        Ok(bytes)
    }

    /// Returns the metric of the bytes of a file.
    ///
    /// # Errors
    /// [`Error::Argument`] unless [`to_bytes`](Self::to_bytes) of this version wrote them.
    pub fn from_bytes(bytes: &[u8]) -> Result<Self> {
        let broken = |e: serde_json::Error| refuse("metric", format!("not a metric: {e}"));
        let Head { format, version } = serde_json::from_slice(bytes).map_err(broken)?;
        if format != FORMAT {
            return Err(refuse("metric", format!("not a metric: its format is {format:?}")));
        }
        if version != VERSION {
            let why = format!("has version {version}, only {VERSION} can be read");
            return Err(refuse("metric", why));
        }
        let file: File = serde_json::from_slice(bytes).map_err(broken)?;
        let size = file.shape_mean.len();
        if size == 0 || file.zeros.checked_add(size).is_none() {
            return Err(refuse("metric", "has no eigenvalues, or too many zeros".into()));
        }
        let vector = |name: &str, values: &[f64]| {
            if values.len() != size {
                let why = format!("{name}: must have {size} numbers, has {}", values.len());
                return Err(refuse("metric", why));
            }
            match values.iter().position(|x| !x.is_finite()) {
                Some(at) => Err(refuse("metric", format!("{name}: number {at} is not finite"))),
                None => Ok(()),
            }
        };
        let matrix = |name: &str, rows: &[Vec<f64>]| {
            if rows.len() != size {
                let why = format!("{name}: must have {size} rows, has {}", rows.len());
                return Err(refuse("metric", why));
            }
            rows.iter().try_for_each(|row| vector(name, row))?;
            Ok(Mat::from_fn(size, size, |i, j| rows[i][j]))
        };
        vector("query_mean", &file.query_mean)?;
        vector("shape_mean", &file.shape_mean)?;
        Ok(Self {
            of_query: matrix("of_query", &file.of_query)?,
            of_shape: matrix("of_shape", &file.of_shape)?,
            zeros: file.zeros,
            scale_free: file.scale_free,
            spectrum: file.spectrum,
            query_mean: file.query_mean,
            shape_mean: file.shape_mean,
        })
    }

    /// Reads a metric from a file.
    ///
    /// # Errors
    /// [`Error::Io`] names the file.
    pub fn read(path: &Path) -> Result<Self> {
        let bytes = std::fs::read(path).map_err(|e| Error::io(path, e))?;
        Self::from_bytes(&bytes).map_err(|e| Error::file(path, e.to_string()))
    }
}

const FORMAT: &str = "catamaran retrieval metric";
const VERSION: u32 = 1;

/// The start of a file, of any version.
#[derive(Deserialize)]
struct Head {
    format: String,
    version: u32,
}

#[derive(Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
struct File {
    format: String,
    version: u32,
    spectrum: String,
    zeros: usize,
    scale_free: bool,
    query_mean: Vec<f64>,
    shape_mean: Vec<f64>,
    of_query: Vec<Vec<f64>>,
    of_shape: Vec<Vec<f64>>,
}

fn refuse(what: &'static str, why: String) -> Error {
    Error::Argument { what, why }
}

/// What poses tell about the covariance within an identity.
struct Poses {
    identities: usize,
    /// Number of poses that identities have beside the first one.
    further: usize,
    /// The deviations from the mean of each identity with several poses, scaled so that their
    /// second moment is an unbiased estimate of the covariance.
    deviations: Vec<Vec<f64>>,
}

impl Poses {
    fn new(logs: &[Vec<f64>], identities: &[usize]) -> Self {
        let mut of: BTreeMap<usize, Vec<Vec<f64>>> = BTreeMap::new();
        for (identity, logs) in identities.iter().zip(logs) {
            of.entry(*identity).or_default().push(logs.clone());
        }
        let (identities, mut further, mut deviations) = (of.len(), 0, Vec::new());
        for poses in of.into_values().filter(|poses| poses.len() > 1) {
            let count = poses.len() as f64;
            let (mean, scale) = (mean(&poses, poses[0].len()), (count / (count - 1.0)).sqrt());
            further += poses.len() - 1;
            for pose in poses {
                let own = difference(&pose, &mean);
                deviations.push(own.into_iter().map(|x| scale * x).collect());
            }
        }
        Self { identities, further, deviations }
    }

    /// Refuses too few identities and poses for so many logarithms.
    fn check(&self, size: usize, poses_only: bool, no_errors: bool) -> Result<()> {
        let needed = 2 * size + 3;
        if !poses_only && self.identities < needed {
            let why = format!(
                "for {size} eigenvalues that are not zero, must be of at least {needed} \
                 identities, are of {}: the covariance of fewer makes new identities seem \
                 impossible; use fewer eigenvalues, or poses_only",
                self.identities
            );
            return Err(refuse("spectra", why));
        }
        let needed = if no_errors { size } else { 1 };
        if self.further < needed {
            let why = format!(
                "for {size} eigenvalues that are not zero, identities must have at least {needed} \
                 poses beside their first ones, have {}: fewer do not determine the covariance of \
                 poses",
                self.further
            );
            return Err(refuse("spectra", why));
        }
        Ok(())
    }
}

/// Computes the logarithms of the eigenvalues behind the zeros.
fn logarithms(
    what: &'static str,
    row: usize,
    spectrum: &[f64],
    zeros: usize,
    scale_free: bool,
) -> Result<Vec<f64>> {
    if let Some(column) = spectrum.iter().position(|x| !x.is_finite()) {
        return Err(Error::NonFinite { what, index: (row, column) });
    }
    let largest = spectrum.iter().fold(0.0, |most: f64, &x| most.max(x));
    let is_zero = |&&x: &&f64| x <= 0.0 || x < LEAST * largest;
    let rest = &spectrum[zeros..];
    if let Some(value) = rest.iter().find(is_zero) {
        let why = format!(
            "eigenvalues behind the {zeros} that are left out as zeros must be positive, but \
             spectrum {row} (from 0) has {value:e}"
        );
        return Err(refuse(what, why));
    }
    Ok(sized(rest.iter().map(|x| x.ln()).collect(), scale_free))
}

/// Returns the logarithms, minus their mean if `scale_free`.
fn sized(mut logs: Vec<f64>, scale_free: bool) -> Vec<f64> {
    if scale_free {
        let mean = logs.iter().sum::<f64>() / logs.len() as f64;
        logs.iter_mut().for_each(|x| *x -= mean);
    }
    logs
}

fn difference(a: &[f64], b: &[f64]) -> Vec<f64> {
    a.iter().zip(b).map(|(x, y)| x - y).collect()
}

/// Computes the mean of samples of this size; 0 for no samples.
fn mean(samples: &[Vec<f64>], size: usize) -> Vec<f64> {
    let count = samples.len().max(1) as f64;
    (0..size).map(|i| samples.iter().map(|sample| sample[i]).sum::<f64>() / count).collect()
}

/// Computes the covariance of samples with this mean; 0 for no samples.
fn covariance(samples: &[Vec<f64>], mean: &[f64]) -> Mat<f64> {
    let deviations: Vec<_> = samples.iter().map(|sample| difference(sample, mean)).collect();
    second_moment(&deviations, mean.len())
}

fn second_moment(samples: &[Vec<f64>], size: usize) -> Mat<f64> {
    let count = samples.len().max(1) as f64;
    let entry = |i: usize, j: usize| samples.iter().map(|x| x[i] * x[j]).sum::<f64>() / count;
    Mat::from_fn(size, size, entry)
}

/// Returns the identity matrix times a number.
fn diagonal(value: f64, size: usize) -> Mat<f64> {
    Mat::from_fn(size, size, |i, j| if i == j { value } else { 0.0 })
}

/// Computes a product of small matrices, in the same order for any number of threads.
fn product(a: &Mat<f64>, b: &Mat<f64>) -> Mat<f64> {
    let inner = a.ncols();
    Mat::from_fn(a.nrows(), b.ncols(), |i, j| (0..inner).map(|l| a[(i, l)] * b[(l, j)]).sum())
}

fn transposed(matrix: &Mat<f64>) -> Mat<f64> {
    matrix.transpose().to_owned()
}

/// Computes the inverse of the lower Cholesky factor; `None` unless the matrix is positive definite
/// and the inverse is finite.
fn inverse_factor(mut matrix: Mat<f64>) -> Result<Option<Mat<f64>>> {
    if dense::cholesky(matrix.as_mut())?.is_err() {
        return Ok(None);
    }
    let mut inverse = Mat::<f64>::identity(matrix.nrows(), matrix.nrows());
    dense::lower_solve_in_place(matrix.as_ref(), inverse.as_mut());
    let n = inverse.nrows();
    let is_finite = (0..n * n).all(|at| inverse[(at / n, at % n)].is_finite());
    Ok(is_finite.then_some(inverse))
}

fn rows(matrix: &Mat<f64>) -> Vec<Vec<f64>> {
    (0..matrix.nrows()).map(|i| (0..matrix.ncols()).map(|j| matrix[(i, j)]).collect()).collect()
}

#[cfg(test)]
mod tests;
