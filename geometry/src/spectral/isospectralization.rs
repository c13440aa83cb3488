//! Finds a surface with a given spectrum: a template is deformed until it has the given eigenvalues
//! (isospectralization; Cosmo et al. 2019. Thesis, section 2.6.1, figures 2.2 and 2.5).

use faer::Mat;

use crate::mesh::vector::{add, cross, dot, doubled_normal, norm, scale, sub};
use crate::mesh::{
    Boundary, Edges, Laplacian, LaplacianOptions, TriMesh, free_components, laplacian,
};
use catamaran::base::{Error, Par, Progress, Result, options};
use catamaran::dense::{
    cholesky, lower_solve_in_place, transposed_product, upper_solve_in_place, zeros,
};
use catamaran::sparse::{EigenOptions, Factor, Inverse, Shifted, Symbolic, eigs};

options! {
    /// Options of [`shape_from_spectrum`].
    #[derive(Debug, Clone)]
    pub struct ShapeOptions<'a> {
        /// Maximum number of steps.
        steps: usize = 60;
        /// Mean relative difference of eigenvalues at which the deformation stops.
        tolerance: f64 = 1e-3, check(at least 0);
        /// Threads. Their number does not change the result.
        par: Par = Par::all();
        /// Callback for progress, which may cancel.
        progress: Progress<'a> = Progress::none(), setter into;
    }
}

/// A template that [`shape_from_spectrum`] deformed.
#[derive(Debug, Clone)]
pub struct ShapeFromSpectrum {
    /// The faces of the template, with other positions.
    pub mesh: TriMesh,
    /// Its first eigenvalues, as many as were given.
    pub eigenvalues: Vec<f64>,
    /// Their mean relative difference from the given eigenvalues.
    pub error: f64,
    /// Number of steps taken.
    pub steps: usize,
}

/// Deforms a template until the first eigenvalues of its cotangent Laplacian with barycentric
/// masses are `eigenvalues`: with a Dirichlet boundary, or, if the template is closed, a Neumann
/// one; the zeros of closed components are left out. The eigenvalues are positive and ascending, in
/// 1 / length^2.
///
/// The size is fitted first. Then each step is one of Levenberg and Marquardt for the relative
/// differences, with the displacement that has the least `integral of |grad d|^2 + |d|^2 / area`
/// among those of the same effect, so that the surface stays smooth. A step that would turn a face
/// over, shrink it to less than a fifth, or flatten it, is shortened. Many surfaces have the same
/// eigenvalues; the result is one of them near the template. Many spectra are those of no surface
/// near it: then the result falls short of the tolerance, see [`ShapeFromSpectrum::error`].
///
/// ```
/// use catamaran_geometry::{mesh::{TriMesh, families}, spectral::{ShapeOptions, shape_from_spectrum}};
///
/// let sphere = families::icosphere(2)?;
/// let stretched = sphere.vertices().iter().map(|p| [p[0], 1.1 * p[1], 1.2 * p[2]]).collect();
/// let template = TriMesh::new(stretched, sphere.faces().to_vec())?;
/// // The eigenvalues of a sphere of radius 1.
/// let wanted = [2.0, 2.0, 2.0, 6.0, 6.0, 6.0, 6.0, 6.0];
/// let found = shape_from_spectrum(&template, &wanted, &ShapeOptions::new().tolerance(0.01))?;
/// assert!(found.error <= 0.01);
/// # Ok::<(), catamaran::Error>(())
/// ```
///
/// # Errors
/// [`Error::Argument`] names "eigenvalues" that are not positive and ascending, or more than the
/// template has; [`Error::NonFinite`]; those of [`laplacian`](crate::mesh::laplacian()) and
/// [`eigs`](catamaran::sparse::eigs()); [`Error::Cancelled`].
pub fn shape_from_spectrum(
    template: &TriMesh,
    eigenvalues: &[f64],
    options: &ShapeOptions<'_>,
) -> Result<ShapeFromSpectrum> {
    check(eigenvalues)?;
    options.check_ranges()?;
    let wanted = Wanted::new(template, eigenvalues, options.par)?;
    let as_given = wanted.shape(template.vertices().to_vec())?;
    // Eigenvalues scale with 1 / length^2.
    let ratios = as_given.values.iter().zip(eigenvalues).map(|(found, wanted)| found / wanted);
    let factor = (ratios.sum::<f64>() / eigenvalues.len() as f64).sqrt();
    let sized = template.vertices().iter().map(|p| scale(*p, factor)).collect();
    let mut now = wanted.shape(sized).map_err(|error| match error {
        // The template itself has a spectrum.
        Error::Mesh { .. } => {
            let why = format!("are out of range: the template would be {factor:e} times as large");
            Error::Argument { what: "eigenvalues", why }
        }
        other => other,
    })?;
    let (mut damping, mut steps) = (1e-3, 0);
    while steps < options.steps && now.error() > options.tolerance {
        options.progress.report(steps as f64 / options.steps as f64)?;
        let metric = Metric::new(&now.mesh, options.par)?;
        let directions = metric.directions(&now, &wanted)?;
        let mut better = None;
        while better.is_none() && damping < DAMPING_LIMIT {
            let step = directions.step(&now.residuals, damping, template.vertices().len())?;
            match wanted.tried(wanted.moved(&now, &step))? {
                Some(next) if next.cost() < now.cost() => better = Some(next),
                _ => damping *= 10.0,
            }
        }
        let Some(next) = better else { break };
        (now, damping) = (next, (0.1 * damping).max(LEAST_DAMPING));
        steps += 1;
    }
    options.progress.report(1.0)?;
    let error = now.error();
    Ok(ShapeFromSpectrum { mesh: now.mesh, eigenvalues: now.values, error, steps })
}

/// Damping, relative to the mean diagonal, above which steps are too short to matter.
const DAMPING_LIMIT: f64 = 1e6;
const LEAST_DAMPING: f64 = 1e-6;

fn check(eigenvalues: &[f64]) -> Result<()> {
    let what = "eigenvalues";
    let refuse = |why: String| Err(Error::Argument { what, why });
    if let Some(i) = eigenvalues.iter().position(|x| !x.is_finite()) {
        return Err(Error::NonFinite { what, index: (i, 0) });
    }
    let Some(&first) = eigenvalues.first() else { return refuse("must not be empty".into()) };
    if first <= 0.0 {
        let advice = if first == 0.0 { ": leave zeros out" } else { "" };
        return refuse(format!("must be positive, but the first one is {first:e}{advice}"));
    }
    if let Some(i) = (1..eigenvalues.len()).find(|&i| eigenvalues[i] < eigenvalues[i - 1]) {
        let (x, before) = (eigenvalues[i], eigenvalues[i - 1]);
        return refuse(format!("must ascend, but number {i} (from 0), {x:e}, follows {before:e}"));
    }
    Ok(())
}

/// The data that all shapes have in common.
struct Wanted<'a> {
    faces: &'a [[u32; 3]],
    eigenvalues: &'a [f64],
    boundary: Boundary,
    /// Number of zero eigenvalues, which are below the given ones.
    zeros: usize,
    par: Par,
}

/// A deformed template, with its spectrum.
struct Shape {
    mesh: TriMesh,
    values: Vec<f64>,
    /// Relative differences from the given eigenvalues.
    residuals: Vec<f64>,
    /// The eigenfunctions, n x k, zero on a Dirichlet boundary.
    vectors: Mat<f64>,
}

impl<'a> Wanted<'a> {
    fn new(template: &'a TriMesh, eigenvalues: &'a [f64], par: Par) -> Result<Self> {
        let closed = Edges::new(template).boundary().next().is_none();
        let boundary = if closed { Boundary::Neumann } else { Boundary::Dirichlet };
        // A template with a boundary may have closed components, too.
        let zeros = free_components(template, &boundary)?;
        Ok(Self { faces: template.faces(), eigenvalues, boundary, zeros, par })
    }

    fn shape(&self, vertices: Vec<[f64; 3]>) -> Result<Shape> {
        let mesh = TriMesh::new(vertices, self.faces.to_vec())?;
        let options = LaplacianOptions::new().boundary(self.boundary.clone()).par(self.par);
        let laplacian = laplacian(&mesh, &options)?;
        let (k, most) = (self.eigenvalues.len(), laplacian.kept.len() - self.zeros);
        if k > most {
            let why = format!("must be at most the {most} that the template has, are {k}");
            return Err(Error::Argument { what: "eigenvalues", why });
        }
        let options = EigenOptions::new().k(self.zeros + k).par(self.par);
        let pairs = eigs(laplacian.stiffness.view(), &laplacian.mass, &options)?;
        let vectors = laplacian.extend(pairs.vectors.as_ref().subcols(self.zeros, k))?;
        let values = pairs.values[self.zeros..].to_vec();
        let ratios = values.iter().zip(self.eigenvalues);
        let residuals = ratios.map(|(found, wanted)| found / wanted - 1.0).collect();
        Ok(Shape { mesh, values, residuals, vectors })
    }

    /// Returns the shape with these positions; `None` if it has no spectrum, because the step to it
    /// was too long.
    fn tried(&self, vertices: Vec<[f64; 3]>) -> Result<Option<Shape>> {
        match self.shape(vertices) {
            Ok(shape) => Ok(Some(shape)),
            Err(Error::Mesh { .. } | Error::NonFinite { .. } | Error::NotConverged { .. }) => {
                Ok(None)
            }
            Err(e) => Err(e),
        }
    }

    /// Returns the positions after a step, shortened until every face keeps its orientation, enough
    /// of its area, and a height. Steps that shrink a face again and again would leave one without
    /// area.
    fn moved(&self, shape: &Shape, step: &[[f64; 3]]) -> Vec<[f64; 3]> {
        /// Least share of the area of a face that a step must leave.
        const KEPT: f64 = 0.2;
        /// Least height of a face, as a share of its longest edge, that a step may leave, unless
        /// the height was less before.
        const FLATTEST: f64 = 1e-2;
        let mut length = 1.0;
        loop {
            let moved: Vec<[f64; 3]> = shape
                .mesh
                .vertices()
                .iter()
                .zip(step)
                .map(|(p, d)| add(*p, scale(*d, length)))
                .collect();
            let is_sound = |face: &[u32; 3]| {
                let before = normal(shape.mesh.vertices(), face);
                let least = FLATTEST.min(flatness(shape.mesh.vertices(), face));
                dot(before, normal(&moved, face)) >= KEPT * dot(before, before)
                    && flatness(&moved, face) >= least
            };
            if self.faces.iter().all(is_sound) {
                return moved;
            }
            length *= 0.5;
        }
    }
}

/// Returns the normal of a face, scaled to twice its area.
fn normal(vertices: &[[f64; 3]], face: &[u32; 3]) -> [f64; 3] {
    doubled_normal(face.map(|v| vertices[v as usize]))
}

/// Returns the height of a face over its longest edge, as a share of that edge.
fn flatness(vertices: &[[f64; 3]], face: &[u32; 3]) -> f64 {
    let corners = face.map(|v| vertices[v as usize]);
    let edges = [0, 1, 2].map(|j| sub(corners[(j + 1) % 3], corners[j]));
    let longest = edges.map(|edge| dot(edge, edge)).into_iter().fold(0.0, f64::max);
    norm(normal(vertices, face)) / longest
}

impl Shape {
    /// Returns the mean size of the residuals.
    fn error(&self) -> f64 {
        self.residuals.iter().map(|r| r.abs()).sum::<f64>() / self.residuals.len() as f64
    }

    /// Returns the sum of the squares of the residuals.
    fn cost(&self) -> f64 {
        self.residuals.iter().map(|r| r * r).sum()
    }

    /// Returns the gradient of eigenvalue i with respect to the positions, for vectors of length 1
    /// in the inner product: of `phi^T W phi - lambda phi^T M phi`, face by face.
    fn gradient(&self, faces: &[[u32; 3]], i: usize) -> Vec<[f64; 3]> {
        let phi = self.vectors.col(i);
        let mut gradient = vec![[0.0; 3]; self.mesh.vertices().len()];
        for face in faces {
            let u = face.map(|v| phi[v as usize]);
            let corners = face.map(|v| self.mesh.vertices()[v as usize]);
            // Edge j is opposite corner j.
            let edges: [[f64; 3]; 3] =
                std::array::from_fn(|j| sub(corners[(j + 2) % 3], corners[(j + 1) % 3]));
            let normal = normal(self.mesh.vertices(), face);
            let twice_area = norm(normal);
            let area = 0.5 * twice_area;
            let sum = (0..3).fold([0.0; 3], |sum, j| add(sum, scale(edges[j], u[j])));
            // The contributions of this face to phi^T W phi and to phi^T M phi, divided by the
            // area.
            let energy = dot(sum, sum) / (4.0 * area);
            let square = u.iter().map(|u| u * u).sum::<f64>() / 3.0;
            for (j, &v) in face.iter().enumerate() {
                let of_area = scale(cross(normal, edges[j]), 0.5 / twice_area);
                let of_sum = (u[(j + 1) % 3] - u[(j + 2) % 3]) / (2.0 * area);
                let of_face = add(
                    scale(sum, of_sum),
                    scale(of_area, -energy / area - self.values[i] * square),
                );
                let entry = &mut gradient[v as usize];
                *entry = add(*entry, of_face);
            }
        }
        gradient
    }
}

/// The inner product of displacements, `W + M / area` of a shape (Neumann), in factorized form.
struct Metric {
    factor: Factor,
    /// The vertices with faces.
    kept: Vec<usize>,
}

impl Metric {
    fn new(shape: &TriMesh, par: Par) -> Result<Self> {
        let Laplacian { stiffness, mass, kept, .. } =
            laplacian(shape, &LaplacianOptions::new().par(par))?;
        let area: f64 = (0..kept.len()).map(|i| mass.diagonal(i)).sum();
        let shifted = Shifted::new(stiffness.view(), &mass);
        let factor = Symbolic::new(shifted.symbolic())?
            .positive(shifted.matrix(&shifted.values(-1.0 / area)))?;
        let Some(factor) = factor else {
            let why = "the Laplacian of a deformed template is not positive semi-definite".into();
            return Err(Error::Argument { what: "template", why });
        };
        Ok(Self { factor, kept })
    }

    /// Returns the directions of steepest ascent of the relative eigenvalues.
    fn directions(&self, shape: &Shape, wanted: &Wanted<'_>) -> Result<Directions<'_>> {
        let k = wanted.eigenvalues.len();
        let mut slopes = zeros(self.kept.len(), 3 * k)?;
        for (i, eigenvalue) in wanted.eigenvalues.iter().enumerate() {
            let gradient = shape.gradient(wanted.faces, i);
            for (row, &v) in self.kept.iter().enumerate() {
                (0..3).for_each(|c| slopes[(row, 3 * i + c)] = gradient[v][c] / eigenvalue);
            }
        }
        let mut steepest = slopes.clone();
        self.factor.solve(steepest.as_mut(), wanted.par)?;
        let products = transposed_product(slopes.as_ref(), steepest.as_ref(), wanted.par)?;
        let gram = Mat::from_fn(k, k, |i, j| {
            (0..3).map(|c| products[(3 * i + c, 3 * j + c)]).sum::<f64>()
        });
        Ok(Directions { steepest, gram, kept: &self.kept })
    }
}

/// For each eigenvalue, the displacement of steepest ascent, in columns x, y and z.
struct Directions<'m> {
    steepest: Mat<f64>,
    /// The increase of each relative eigenvalue by each displacement.
    gram: Mat<f64>,
    kept: &'m [usize],
}

impl Directions<'_> {
    /// Returns the displacement that removes the residuals, to first order, with damping relative
    /// to the mean diagonal of the Gram matrix.
    fn step(&self, residuals: &[f64], damping: f64, vertices: usize) -> Result<Vec<[f64; 3]>> {
        let k = residuals.len();
        let mean = (0..k).map(|i| self.gram[(i, i)]).sum::<f64>() / k as f64;
        let mut factor = self.gram.clone();
        (0..k).for_each(|i| factor[(i, i)] += damping * mean);
        let mut weights = Mat::from_fn(k, 1, |i, _| residuals[i]);
        let mut step = vec![[0.0; 3]; vertices];
        if cholesky(factor.as_mut())?.is_err() {
            return Ok(step);
        }
        lower_solve_in_place(factor.as_ref(), weights.as_mut());
        upper_solve_in_place(factor.transpose(), weights.as_mut());
        for (row, &v) in self.kept.iter().enumerate() {
            for c in 0..3 {
                let along = |i: usize| weights[(i, 0)] * self.steepest[(row, 3 * i + c)];
                step[v][c] = -(0..k).map(along).sum::<f64>();
            }
        }
        Ok(step)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::mesh::families;
    use catamaran::base::Rng;

    /// Returns a template with distinct eigenvalues: a sphere, scaled along the axes and roughened.
    fn bumpy(level: u32, axes: [f64; 3]) -> TriMesh {
        let sphere = families::icosphere(level).unwrap();
        let mut rng = Rng::new(4);
        let mut moved = |p: &[f64; 3]| -> [f64; 3] {
            std::array::from_fn(|c| axes[c] * p[c] * (1.0 + 0.02 * (rng.uniform() - 0.5)))
        };
        let vertices = sphere.vertices().iter().map(&mut moved).collect();
        TriMesh::new(vertices, sphere.faces().to_vec()).unwrap()
    }

    /// Returns a rectangle with these sides, and with a boundary.
    fn sheet(a: f64, b: f64) -> TriMesh {
        let grid = families::grid(14, 12).unwrap();
        let vertices = grid.vertices().iter().map(|p| [a * p[0], b * p[1], 0.0]).collect();
        TriMesh::new(vertices, grid.faces().to_vec()).unwrap()
    }

    #[test]
    fn gradients_of_eigenvalues_are_those_of_differences() {
        let mut rng = Rng::new(7);
        for template in [bumpy(2, [1.0, 1.2, 1.5]), sheet(1.0, 1.3)] {
            let eigenvalues = [1.0, 2.0, 3.0, 4.0];
            let wanted = Wanted::new(&template, &eigenvalues, Par::Seq).unwrap();
            let shape = wanted.shape(template.vertices().to_vec()).unwrap();
            let direction: Vec<[f64; 3]> = (0..template.vertices().len())
                .map(|_| std::array::from_fn(|_| rng.uniform() - 0.5))
                .collect();
            let at = |t: f64| {
                let along = shape.mesh.vertices().iter().zip(&direction);
                wanted.shape(along.map(|(p, d)| add(*p, scale(*d, t))).collect()).unwrap().values
            };
            let (t, [before, after]) = (1e-6, [at(-1e-6), at(1e-6)]);
            for i in 0..eigenvalues.len() {
                let gradient = shape.gradient(wanted.faces, i);
                let slope: f64 = gradient.iter().zip(&direction).map(|(g, d)| dot(*g, *d)).sum();
                let expected = (after[i] - before[i]) / (2.0 * t);
                let scale = expected.abs() + shape.values[i];
                assert!((slope - expected).abs() < 1e-5 * scale, "{i}: {slope}, not {expected}");
            }
        }
    }

    #[test]
    fn a_template_gets_the_spectrum_of_another_shape() {
        let spectrum = |mesh: &TriMesh| {
            let wanted = Wanted::new(mesh, &[1.0; 12], Par::Seq).unwrap();
            wanted.shape(mesh.vertices().to_vec()).unwrap().values
        };
        for (template, other) in [
            (bumpy(3, [1.0, 1.1, 1.25]), bumpy(3, [1.4, 0.9, 1.1])),
            (sheet(1.0, 1.3), sheet(0.8, 2.0)),
        ] {
            let eigenvalues = spectrum(&other);
            let options = ShapeOptions::new().tolerance(1e-4).par(Par::Seq);
            let found = shape_from_spectrum(&template, &eigenvalues, &options).unwrap();
            assert!(found.error <= 1e-4 && found.steps < 40, "{} {}", found.error, found.steps);
            let again = spectrum(&found.mesh);
            for (found, wanted) in again.iter().zip(&eigenvalues) {
                assert!((found / wanted - 1.0).abs() < 2e-3);
            }
            let threads = options.par(Par::Threads(2));
            let same = shape_from_spectrum(&template, &eigenvalues, &threads).unwrap();
            assert_eq!(found.mesh, same.mesh);
        }
    }

    #[test]
    fn zeros_of_closed_components_beside_an_open_one_are_left_out() {
        let (grid, ball) = (sheet(1.0, 1.3), bumpy(1, [1.0, 1.2, 1.5]));
        let first = grid.vertices().len() as u32;
        let vertices = [grid.vertices(), ball.vertices()].concat();
        let moved = ball.faces().iter().map(|face| face.map(|v| v + first));
        let faces = grid.faces().iter().copied().chain(moved).collect();
        let both = TriMesh::new(vertices, faces).unwrap();
        let wanted = Wanted::new(&both, &[1.0; 4], Par::Seq).unwrap();
        let values = wanted.shape(both.vertices().to_vec()).unwrap().values;
        assert!(values.iter().all(|value| *value > 0.1), "{values:?}");
    }

    #[test]
    fn a_spectrum_of_no_shape_nearby_leaves_a_sound_mesh_and_a_smaller_error() {
        // Ascending numbers that grow much slower, or faster, than those of any surface, and one
        // that stands alone.
        let slow: Vec<f64> = (0..20).map(|i| 5.0 + 0.01 * f64::from(i)).collect();
        let fast: Vec<f64> = (0..12).map(|i| 1.7_f64.powi(i)).collect();
        let lone: Vec<f64> = (0..20).map(|i| if i == 0 { 0.02 } else { f64::from(i) }).collect();
        let ball = bumpy(2, [1.0, 1.1, 1.25]);
        let figure = families::figure(1, 0.2).unwrap();
        for template in [&ball, &figure, &sheet(1.0, 1.3)] {
            for eigenvalues in [&slow, &fast, &lone] {
                let with = |steps: usize| {
                    let options = ShapeOptions::new().steps(steps).par(Par::Seq);
                    shape_from_spectrum(template, eigenvalues, &options).unwrap()
                };
                let cost = |found: &ShapeFromSpectrum| -> f64 {
                    let ratios = found.eigenvalues.iter().zip(eigenvalues);
                    ratios.map(|(found, wanted)| (found / wanted - 1.0).powi(2)).sum()
                };
                let (before, after) = (with(0), with(12));
                assert!(cost(&after) < cost(&before), "{} {}", cost(&before), cost(&after));
                assert!(after.mesh.faces_without_area().is_empty());
            }
        }
    }

    #[test]
    fn what_is_no_spectrum_is_refused_by_name() {
        let template = families::icosphere(1).unwrap();
        let with = |eigenvalues: &[f64]| {
            let found = shape_from_spectrum(&template, eigenvalues, &ShapeOptions::new());
            found.map_err(|e| e.to_string()).unwrap_err()
        };
        assert!(with(&[]).contains("eigenvalues: must not be empty"));
        assert!(with(&[0.0, 1.0]).contains("leave zeros out"));
        assert!(with(&[-1.0, 1.0]).ends_with("the first one is -1e0"));
        assert!(with(&[2.0, 1.0]).contains("must ascend, but number 1 (from 0), 1e0, follows 2e0"));
        assert!(with(&[1e300, 2e300]).starts_with("eigenvalues: are out of range"));
        assert!(with(&[1e-300, 2e-300]).starts_with("eigenvalues: are out of range"));
        assert!(with(&[1.0, f64::NAN]).contains("eigenvalues"));
        let said = "eigenvalues: must be at most the 41 that the template has, are 42";
        assert_eq!(with(&[1.0; 42]), said);
        // Of nine vertices, one is not on the boundary.
        let grid = families::grid(2, 2).unwrap();
        let said = shape_from_spectrum(&grid, &[20.0, 50.0], &ShapeOptions::new()).unwrap_err();
        assert!(said.to_string().contains("at most the 1 that the template has"), "{said}");
    }
}
