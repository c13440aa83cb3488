use faer::{Mat, MatRef};

use super::tensors::{Tensor, Tensors, rounded};
use crate::mesh::{LaplacianOptions, TriMesh, laplacian};
use catamaran::base::{Error, Par, Progress, Result};
use catamaran::dense;
use catamaran::sparse::{EigenOptions, eigs};

/// The template on which [`SpectralUnion::locate`](super::SpectralUnion::locate) finds regions, as
/// coefficients of its eigenfunctions (thesis, section 2.6.2; the coefficients:
/// docs/algorithms/unions.md).
///
/// Eigenfunctions have no sign of their own, and other bases span the same space. So the localizer
/// keeps the values of the eigenfunctions of the training at some vertices, the anchors, and
/// [`Localizer::on`] transforms other eigenfunctions into these.
#[derive(Debug, Clone, PartialEq)]
pub struct Localizer {
    modes: usize,
    /// The vertices of the template at which values are known.
    anchors: Vec<usize>,
    /// For each anchor, the values of all eigenfunctions.
    values: Vec<f32>,
    vertices: usize,
}

impl Localizer {
    /// Creates a localizer from the anchors of the training, on a template of `vertices` vertices.
    ///
    /// - `modes`: number of eigenfunctions;
    /// - `anchors`: vertices, at least as many as eigenfunctions;
    /// - `values`: for each anchor, the values of all eigenfunctions; rounded to half precision, as
    ///   in files.
    ///
    /// ```
    /// use catamaran::Par;
    /// use catamaran_geometry::{mesh::{LaplacianOptions, families, laplacian}, unions::Localizer};
    /// use catamaran::sparse::{EigenOptions, eigs};
    ///
    /// // Two eigenfunctions of a template, with all vertices as anchors.
    /// let template = families::icosphere(1)?;
    /// let operator = laplacian(&template, &LaplacianOptions::new())?;
    /// let pairs = eigs(operator.stiffness.view(), &operator.mass, &EigenOptions::new().k(2))?;
    /// let n = template.vertices().len();
    /// let at = |v: usize| [0, 1].map(|i| pairs.vectors[(v, i)] as f32);
    /// let localizer = Localizer::new(2, (0..n).collect(), (0..n).flat_map(at).collect(), n)?;
    /// // A region that is the first eigenfunction, a constant.
    /// let found = localizer.on(pairs.vectors.as_ref())?.indicator(&[1.0, 0.0])?;
    /// assert!((found[0] - found[9]).abs() < 1e-3);
    /// # Ok::<(), catamaran::Error>(())
    /// ```
    ///
    /// # Errors
    /// [`Error::Argument`] and [`Error::Shape`] name the argument that does not fit;
    /// [`Error::NonFinite`].
    pub fn new(
        modes: usize,
        anchors: Vec<usize>,
        mut values: Vec<f32>,
        vertices: usize,
    ) -> Result<Self> {
        Error::check_shape("values", (anchors.len().saturating_mul(modes), 1), (values.len(), 1))?;
        if anchors.len() < modes || anchors.iter().any(|&v| v >= vertices) {
            let why = "must be vertices of the template, at least as many as eigenfunctions".into();
            return Err(Error::Argument { what: "anchors", why });
        }
        if let Some(at) = values.iter().position(|x| !x.is_finite()) {
            return Err(Error::NonFinite { what: "values", index: (at / modes, at % modes) });
        }
        values.iter_mut().for_each(|x| *x = rounded(*x));
        Ok(Self { modes, anchors, values, vertices })
    }

    /// Creates a localizer from the tensors of a file.
    pub(super) fn from_tensors(tensors: &Tensors<'_>, modes: usize) -> Result<Self> {
        let anchors = tensors.values("anchors", tensors.len("anchors"))?;
        let anchors: Vec<usize> = anchors.iter().map(|&x| x as usize).collect();
        let values = tensors.values("anchor_values", anchors.len().saturating_mul(modes))?;
        let vertices = tensors.values("template_vertices", 1)?[0] as usize;
        Self::new(modes, anchors, values, vertices)
    }

    /// Returns the whole numbers of a file: the anchors, and then the number of vertices. They are
    /// floats below 2^24, which are exact.
    pub(super) fn whole(&self) -> Vec<f32> {
        self.anchors.iter().chain([&self.vertices]).map(|&x| x as f32).collect()
    }

    /// Returns the tensors of a file; `whole` are those of [`Localizer::whole`].
    pub(super) fn tensors<'a>(&'a self, whole: &'a [f32]) -> [(&'a str, Tensor<'a>); 3] {
        let (anchors, vertices) = whole.split_at(self.anchors.len());
        [
            ("anchors", Tensor::new(1, anchors)),
            ("anchor_values", Tensor::half(self.modes, &self.values)),
            ("template_vertices", Tensor::new(1, vertices)),
        ]
    }

    /// Returns the number of eigenfunctions.
    pub fn modes(&self) -> usize {
        self.modes
    }

    /// Returns the number of vertices of the template.
    pub fn vertices(&self) -> usize {
        self.vertices
    }

    /// Computes the localizer on the mesh of its template.
    ///
    /// # Errors
    /// [`Error::Shape`] and [`Error::Argument`] for another mesh; as [`laplacian()`] and [`eigs`].
    pub fn on_mesh(&self, template: &TriMesh, par: Par) -> Result<LocalizerOn> {
        self.on_mesh_watched(template, par, Progress::none())
    }

    /// Computes the same as [`Localizer::on_mesh`], with a callback for the progress of the
    /// eigenfunctions, which may cancel.
    ///
    /// # Errors
    /// As [`Localizer::on_mesh`], [`Error::Cancelled`].
    pub fn on_mesh_watched(
        &self,
        template: &TriMesh,
        par: Par,
        progress: Progress<'_>,
    ) -> Result<LocalizerOn> {
        progress.watch(|| self.on_template(template, par, progress))
    }

    fn on_template(
        &self,
        template: &TriMesh,
        par: Par,
        progress: Progress<'_>,
    ) -> Result<LocalizerOn> {
        // Checked before the expensive work.
        Error::check_shape("template", (self.vertices, 3), (template.vertices().len(), 3))?;
        let settings = LaplacianOptions { par, ..LaplacianOptions::default() };
        let operator = laplacian(template, &settings)?;
        let options = EigenOptions::new().k(self.modes).par(par).progress(progress);
        let pairs = eigs(operator.stiffness.view(), &operator.mass, &options)?;
        self.on(operator.extend(pairs.vectors.as_ref())?.as_ref())
    }

    /// Computes the localizer on a template with these eigenfunctions (vertices x number), whatever
    /// their signs.
    ///
    /// # Errors
    /// [`Error::Shape`] for another template; [`Error::Argument`] when the functions are not those
    /// of the template.
    pub fn on(&self, functions: MatRef<'_, f64>) -> Result<LocalizerOn> {
        /// Largest share of the anchors' values that the functions may leave unexplained.
        const TOLERANCE: f64 = 0.05;
        let modes = self.modes;
        Error::check_shape("functions", (self.vertices, modes), functions.shape())?;
        let (m, wrong) = (self.anchors.len(), "are not the eigenfunctions of the template");
        let refuse = || Error::Argument { what: "functions", why: wrong.into() };
        let at = Mat::from_fn(m, modes, |i, j| functions[(self.anchors[i], j)]);
        let wanted = Mat::from_fn(m, modes, |i, j| f64::from(self.values[i * modes + j]));
        // Least squares by the normal equations, which are well conditioned: anchors are many and
        // spread out.
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
        Ok(LocalizerOn { functions: functions * turn })
    }
}

/// A [`Localizer`] on its template.
#[derive(Debug, Clone)]
pub struct LocalizerOn {
    functions: Mat<f64>,
}

impl LocalizerOn {
    /// Returns a value for each vertex, about 1 inside of the region with these coefficients and 0
    /// outside; the region consists of the vertices with values above 1/2. Mirror images have the
    /// same spectrum, so the region may be the mirror image.
    ///
    /// # Errors
    /// [`Error::Shape`] unless there is a coefficient for each eigenfunction.
    pub fn indicator(&self, coefficients: &[f32]) -> Result<Vec<f64>> {
        let modes = self.functions.ncols();
        Error::check_shape("coefficients", (modes, 1), (coefficients.len(), 1))?;
        let column = Mat::from_fn(modes, 1, |i, _| f64::from(coefficients[i]));
        let values = &self.functions * column;
        Ok((0..values.nrows()).map(|v| values[(v, 0)]).collect())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const MODES: usize = 3;
    const VERTICES: usize = 40;
    const COEFFICIENTS: [f32; MODES] = [0.7, -1.2, 0.4];

    fn functions() -> Mat<f64> {
        Mat::from_fn(VERTICES, MODES, |v, j| (0.1 * v as f64 * (j + 1) as f64).cos())
    }

    fn localizer() -> Localizer {
        let anchors: Vec<usize> = (0..10).map(|i| 4 * i).collect();
        let functions = functions();
        let at = anchors.iter().flat_map(|&v| (0..MODES).map(move |j| (v, j)));
        let values = at.map(|(v, j)| functions[(v, j)] as f32).collect();
        Localizer::new(MODES, anchors, values, VERTICES).unwrap()
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
        let one = localizer.on(functions.as_ref()).unwrap().indicator(&COEFFICIENTS).unwrap();
        let other = localizer.on(turned.as_ref()).unwrap().indicator(&COEFFICIENTS).unwrap();
        for v in 0..VERTICES {
            let sum: f64 = (0..MODES).map(|j| f64::from(COEFFICIENTS[j]) * functions[(v, j)]).sum();
            // Values at anchors have half precision.
            assert!((one[v] - sum).abs() < 2e-3 && (one[v] - other[v]).abs() < 1e-9);
        }
    }

    #[test]
    fn eigenfunctions_of_the_template_can_be_cancelled() {
        let mesh = crate::mesh::families::icosphere(1).unwrap();
        let n = mesh.vertices().len();
        let localizer = Localizer::new(1, vec![0], vec![1.0], n).unwrap();
        let stop = |_| std::ops::ControlFlow::Break(());
        let found = localizer.on_mesh_watched(&mesh, Par::Seq, Progress::new(&stop));
        assert!(matches!(found, Err(Error::Cancelled)));
    }

    #[test]
    fn values_that_are_not_finite_are_named() {
        let refused = Localizer::new(2, vec![0, 1], vec![1.0, 0.0, 0.5, f32::NAN], 3).unwrap_err();
        assert_eq!(refused, Error::NonFinite { what: "values", index: (1, 1) });
    }

    #[test]
    fn another_template_and_other_coefficients_are_refused() {
        let localizer = localizer();
        let wrong = Mat::from_fn(VERTICES, MODES, |v, j| ((v * v + j) % 7) as f64);
        assert!(localizer.on(wrong.as_ref()).is_err());
        assert!(matches!(
            localizer.on(functions().as_ref().subrows(0, 30)).unwrap_err(),
            Error::Shape { what: "functions", .. }
        ));
        let on = localizer.on(functions().as_ref()).unwrap();
        assert!(on.indicator(&[1.0; 7]).unwrap_err().to_string().starts_with("coefficients"));
        let refused = |anchors: Vec<usize>, vertices: usize| {
            let values = vec![0.0; 2 * anchors.len()];
            Localizer::new(2, anchors, values, vertices).unwrap_err().to_string()
        };
        assert!(refused(vec![0], 9).starts_with("anchors"));
        assert!(refused(vec![0, 9], 9).starts_with("anchors"));
    }
}
