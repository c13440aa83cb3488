use std::path::Path;

use faer::{Mat, MatRef};

use super::network::{K, gemm};
use super::spectrum;
use super::tensors::{Tensor, Tensors, to_bytes};
use crate::base::{Error, Result};
use crate::dense;

/// A perceptron from the spectrum of a region to the region on one template, as coefficients of the template's eigenfunctions
/// (thesis, section 2.6.2, but for the coefficients: docs/decisions/0026).
///
/// Eigenfunctions have no sign of their own, and others that span the same space do as well. So the values that
/// those of the training have at some vertices, the anchors, are kept, and [`Localizer::on`] turns others into these.
#[derive(Debug, Clone, PartialEq)]
pub struct Localizer {
    /// Numbers of neurons, K at first and the number of eigenfunctions at last.
    widths: Vec<usize>,
    /// For each layer its weights, inputs x outputs by rows, and a bias for each output.
    parameters: Vec<f32>,
    mean: Vec<f32>,
    deviation: Vec<f32>,
    /// Vertices of the template.
    anchors: Vec<usize>,
    /// For each anchor the values of all eigenfunctions.
    values: Vec<f32>,
    vertices: usize,
}

/// What a localizer is made of.
#[derive(Debug, Clone, PartialEq)]
pub struct LocalizerParts {
    /// Numbers of neurons: K, those of hidden layers (rectified), the number of eigenfunctions.
    pub widths: Vec<usize>,
    /// For each layer its weights, inputs x outputs by rows, and a bias for each output.
    pub parameters: Vec<f32>,
    /// K means of logarithms of eigenvalues.
    pub mean: Vec<f32>,
    /// Their deviations.
    pub deviation: Vec<f32>,
    /// Vertices of the template, more than there are eigenfunctions.
    pub anchors: Vec<usize>,
    /// Anchors x eigenfunctions.
    pub values: Vec<f32>,
    /// Vertices of the template.
    pub vertices: usize,
}

impl Localizer {
    /// From what training gives.
    ///
    /// # Errors
    /// [`Error::Argument`] and [`Error::Shape`] name what does not fit.
    pub fn new(parts: LocalizerParts) -> Result<Self> {
        let LocalizerParts { widths, parameters, mean, deviation, anchors, values, vertices } =
            parts;
        let refuse = |what, why: &str| Err(Error::Argument { what, why: why.into() });
        if widths.len() < 2 || widths[0] != K || widths.iter().any(|w| !(1..=4096).contains(w)) {
            return refuse("widths", "must begin with 20 and lie between 1 and 4096");
        }
        let modes = widths[widths.len() - 1];
        let len = widths.windows(2).map(|pair| (pair[0] + 1) * pair[1]).sum();
        Error::check_shape("parameters", (len, 1), (parameters.len(), 1))?;
        Error::check_shape("mean", (K, 1), (mean.len(), 1))?;
        Error::check_shape("deviation", (K, 1), (deviation.len(), 1))?;
        Error::check_shape("values", (anchors.len() * modes, 1), (values.len(), 1))?;
        if deviation.iter().any(|x| !x.is_normal()) {
            return refuse("deviation", "must not be zero");
        }
        if anchors.len() < modes || anchors.iter().any(|&v| v >= vertices) {
            return refuse("anchors", "must be vertices, at least as many as eigenfunctions");
        }
        Ok(Self { widths, parameters, mean, deviation, anchors, values, vertices })
    }

    /// From the bytes of a file that [`Localizer::to_bytes`] made.
    ///
    /// # Errors
    /// [`Error::Argument`] says what is wrong with it.
    pub fn from_bytes(bytes: &[u8]) -> Result<Self> {
        let tensors = Tensors::new(bytes)?;
        let whole = |name: &str| -> Result<Vec<usize>> {
            let values = tensors.values(name, tensors.len(name))?;
            Ok(values.iter().map(|&x| x as usize).collect())
        };
        let (widths, anchors) = (whole("widths")?, whole("anchors")?);
        let modes = widths.last().copied().unwrap_or(0);
        let values = |name: &str, len| tensors.values(name, len);
        Self::new(LocalizerParts {
            parameters: values("parameters", tensors.len("parameters"))?,
            mean: values("mean", K)?,
            deviation: values("deviation", K)?,
            values: values("values", anchors.len().saturating_mul(modes))?,
            vertices: values("vertices", 1)?[0] as usize,
            widths,
            anchors,
        })
    }

    /// From a file (safetensors).
    ///
    /// # Errors
    /// [`Error::Io`] names the file.
    pub fn read(path: &Path) -> Result<Self> {
        let refuse = |what: String| Error::Io { path: path.into(), line: 0, what };
        let bytes = std::fs::read(path).map_err(|e| refuse(e.to_string()))?;
        Self::from_bytes(&bytes).map_err(|e| refuse(e.to_string()))
    }

    /// A file of it, in the safetensors format.
    ///
    /// # Errors
    /// [`Error::Argument`] when the format can't hold it.
    pub fn to_bytes(&self) -> Result<Vec<u8>> {
        // Vertex numbers below 2^24, as floats.
        let whole = |values: &[usize]| values.iter().map(|&x| x as f32).collect::<Vec<f32>>();
        let (widths, anchors) = (whole(&self.widths), whole(&self.anchors));
        let vertices = whole(&[self.vertices]);
        let modes = self.eigenfunctions();
        to_bytes(vec![
            ("widths", Tensor::new(widths.len(), &widths)),
            ("parameters", Tensor::new(self.parameters.len(), &self.parameters)),
            ("mean", Tensor::new(K, &self.mean)),
            ("deviation", Tensor::new(K, &self.deviation)),
            ("anchors", Tensor::new(anchors.len(), &anchors)),
            ("values", Tensor::new(modes, &self.values)),
            ("vertices", Tensor::new(1, &vertices)),
        ])
    }

    /// Number of eigenfunctions.
    pub fn eigenfunctions(&self) -> usize {
        self.widths[self.widths.len() - 1]
    }

    /// Vertices of the template.
    pub fn vertices(&self) -> usize {
        self.vertices
    }

    /// Coefficients of the indicator function of a region, in the eigenfunctions of the training.
    ///
    /// - `region`: its first K Dirichlet eigenvalues, in the template's unit of length.
    ///
    /// # Errors
    /// [`Error::Shape`], [`Error::NonFinite`] and [`Error::Argument`] name `region`.
    pub fn coefficients(&self, region: &[f64]) -> Result<Vec<f32>> {
        let region = spectrum::check("region", region)?;
        let mut x: Vec<f32> =
            (0..K).map(|i| (region[i].ln() as f32 - self.mean[i]) / self.deviation[i]).collect();
        let mut start = 0;
        for (layer, pair) in self.widths.windows(2).enumerate() {
            let (inner, columns) = (pair[0], pair[1]);
            let (weights, bias) =
                self.parameters[start..start + (inner + 1) * columns].split_at(inner * columns);
            start += (inner + 1) * columns;
            let mut y = bias.to_vec();
            gemm((1, inner, columns), &x, (inner, 1), weights, &mut y);
            if layer + 2 < self.widths.len() {
                y.iter_mut().for_each(|y| *y = y.max(0.0));
            }
            x = y;
        }
        Ok(x)
    }

    /// The localizer on a template with these eigenfunctions (vertices x their number), whatever their signs are.
    ///
    /// # Errors
    /// [`Error::Shape`] for another template; [`Error::Argument`] when the functions are not those of the template.
    pub fn on(&self, functions: MatRef<'_, f64>) -> Result<LocalizerOn<'_>> {
        /// Largest share of the anchors' values that the functions do not reach.
        const TOLERANCE: f64 = 0.05;
        let modes = self.eigenfunctions();
        Error::check_shape("functions", (self.vertices, modes), functions.shape())?;
        let (m, wrong) = (self.anchors.len(), "not the eigenfunctions of the template");
        let refuse = || Error::Argument { what: "functions", why: wrong.into() };
        let at = Mat::from_fn(m, modes, |i, j| functions[(self.anchors[i], j)]);
        let wanted = Mat::from_fn(m, modes, |i, j| f64::from(self.values[i * modes + j]));
        // Least squares by the normal equations: anchors are many and spread out.
        let mut factor = at.transpose() * &at;
        let mut turn = at.transpose() * &wanted;
        dense::cholesky(factor.as_mut())?.map_err(|_| refuse())?;
        for i in 0..modes {
            for j in i + 1..modes {
                factor[(i, j)] = 0.0;
            }
        }
        dense::lower_solve_in_place(factor.as_ref(), turn.as_mut());
        dense::upper_solve_in_place(factor.transpose(), turn.as_mut());
        let rest = (&at * &turn - &wanted).norm_l2();
        if rest.is_nan() || rest > TOLERANCE * wanted.norm_l2() {
            return Err(refuse());
        }
        Ok(LocalizerOn { localizer: self, functions: functions * turn })
    }
}

/// A [`Localizer`] on its template.
#[derive(Debug, Clone)]
pub struct LocalizerOn<'a> {
    localizer: &'a Localizer,
    functions: Mat<f64>,
}

impl LocalizerOn<'_> {
    /// For each vertex about 1 inside of the region with this spectrum and 0 outside; the region is what is above 1/2. Mirror
    /// images have the same spectrum, and one of them is found.
    ///
    /// # Errors
    /// As [`Localizer::coefficients`].
    pub fn indicator(&self, region: &[f64]) -> Result<Vec<f64>> {
        let coefficients = self.localizer.coefficients(region)?;
        let column = Mat::from_fn(coefficients.len(), 1, |i, _| f64::from(coefficients[i]));
        let values = &self.functions * column;
        Ok((0..values.nrows()).map(|v| values[(v, 0)]).collect())
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::base::Rng;

    const MODES: usize = 3;
    const VERTICES: usize = 40;

    fn functions() -> Mat<f64> {
        Mat::from_fn(VERTICES, MODES, |v, j| (0.1 * v as f64 * (j + 1) as f64).cos())
    }

    fn localizer() -> Localizer {
        let mut rng = Rng::new(2);
        let anchors: Vec<usize> = (0..10).map(|i| 4 * i).collect();
        let functions = functions();
        Localizer::new(LocalizerParts {
            widths: vec![K, 5, MODES],
            parameters: (0..21 * 5 + 6 * MODES).map(|_| rng.normal() as f32).collect(),
            mean: vec![1.0; K],
            deviation: vec![2.0; K],
            values: anchors
                .iter()
                .flat_map(|&v| (0..MODES).map(move |j| (v, j)))
                .map(|(v, j)| functions[(v, j)] as f32)
                .collect(),
            anchors,
            vertices: VERTICES,
        })
        .unwrap()
    }

    fn region() -> Vec<f64> {
        (0..K).map(|i| (i + 1) as f64).collect()
    }

    #[test]
    fn the_result_does_not_depend_on_signs_and_rotations_of_eigenfunctions() {
        let localizer = localizer();
        let functions = functions();
        let (sin, cos) = 0.7_f64.sin_cos();
        let turned = Mat::from_fn(VERTICES, MODES, |v, j| match j {
            0 => -functions[(v, 0)],
            1 => cos * functions[(v, 1)] - sin * functions[(v, 2)],
            _ => sin * functions[(v, 1)] + cos * functions[(v, 2)],
        });
        let one = localizer.on(functions.as_ref()).unwrap().indicator(&region()).unwrap();
        let other = localizer.on(turned.as_ref()).unwrap().indicator(&region()).unwrap();
        let coefficients = localizer.coefficients(&region()).unwrap();
        for v in 0..VERTICES {
            let sum: f64 = (0..MODES).map(|j| f64::from(coefficients[j]) * functions[(v, j)]).sum();
            assert!((one[v] - sum).abs() < 1e-5 && (one[v] - other[v]).abs() < 1e-5);
        }
    }

    #[test]
    fn files_give_the_same_localizer_back() {
        let localizer = localizer();
        let bytes = localizer.to_bytes().unwrap();
        assert_eq!(Localizer::from_bytes(&bytes).unwrap(), localizer);
        assert_eq!(localizer.to_bytes().unwrap(), bytes);
        assert!(Localizer::from_bytes(&bytes[..100]).is_err());
    }

    #[test]
    fn another_template_and_what_is_no_spectrum_are_refused() {
        let localizer = localizer();
        let wrong = Mat::from_fn(VERTICES, MODES, |v, j| ((v * v + j) % 7) as f64);
        assert!(localizer.on(wrong.as_ref()).is_err());
        assert!(matches!(
            localizer.on(functions().as_ref().subrows(0, 30)).unwrap_err(),
            Error::Shape { what: "functions", .. }
        ));
        assert!(localizer.coefficients(&[1.0; 7]).unwrap_err().to_string().starts_with("region"));
    }
}
