use faer::ColMut;
use faer::sparse::{SparseColMatRef, SymbolicSparseColMatRef};
use sprs::CsMat;

use super::super::laplacian::{Complex, Element, ROUNDING, assemble, of_mesh};
use super::super::{LaplacianKind, MassKind, TriMesh};
use crate::base::{Error, Par, Result, Sets, builder, positive};
use crate::sparse::{Factor, Inverse, Mass, Symbolic};

/// Smallest heat whose direction of flow is reliable: smaller numbers have lost digits.
const COLD: f64 = 1e-290;

/// Options of [`HeatMethod`].
#[derive(Debug, Clone, Copy, PartialEq)]
#[non_exhaustive]
pub struct HeatOptions {
    /// Time of the heat flow, in units of the squared mean edge length; positive, default 1. A
    /// longer time gives smoother distances.
    pub time: f64,
    /// Triangulation; default [`LaplacianKind::Cotangent`]. The other kinds are more accurate on
    /// triangles of low quality, and allow faces without area.
    pub kind: LaplacianKind,
    /// Threads; default [`Par::all`]. Does not change the result.
    pub par: Par,
}

impl Default for HeatOptions {
    fn default() -> Self {
        Self { time: 1.0, kind: LaplacianKind::default(), par: Par::all() }
    }
}

builder! { HeatOptions {
    time: f64,
    kind: LaplacianKind,
    par: Par,
}}

/// Distances along the surface by the heat method: Crane, Weischedel and Wardetzky, Geodesics in
/// Heat (2013), with Neumann conditions at the boundary. The error is a few edge lengths; the
/// distances are not exact.
///
/// Creating the solver takes two sparse Cholesky factorizations; each set of sources takes two
/// solves.
///
/// ```
/// use catamaran::mesh::{HeatMethod, HeatOptions, families};
///
/// let sphere = families::icosphere(3)?;
/// let distances = HeatMethod::new(&sphere, &HeatOptions::new())?.distances(&[0])?;
/// assert!(distances[0].abs() < 1e-6);
/// assert!((distances.iter().copied().fold(0.0, f64::max) - std::f64::consts::PI).abs() < 0.2);
/// # Ok::<(), catamaran::Error>(())
/// ```
#[derive(Debug)]
pub struct HeatMethod {
    faces: Vec<[u32; 3]>,
    elements: Vec<Element>,
    /// Factor of M + t W.
    heat: Factor,
    /// Factor of W, with one vertex of every component held at zero.
    poisson: Factor,
    /// The component of every vertex: its vertex with the lowest number.
    components: Vec<u32>,
    par: Par,
}

impl HeatMethod {
    /// Creates a solver for a mesh.
    ///
    /// # Errors
    /// [`Error::Argument`] for a time that is not positive and finite, or when the Laplacian is not
    /// positive definite to working precision, which bad triangles can do to
    /// [`LaplacianKind::Cotangent`]; those of [`laplacian`](fn@super::super::laplacian);
    /// [`Error::OutOfMemory`].
    pub fn new(mesh: &TriMesh, options: &HeatOptions) -> Result<Self> {
        let n = mesh.vertices().len();
        positive("time", options.time)?;
        let plain = Complex::of_mesh(mesh)?;
        let lengths = plain.lengths.as_flattened();
        let mean = lengths.iter().map(|l| l / lengths.len() as f64).sum::<f64>();
        let (faces, elements, rounding) = match options.kind {
            LaplacianKind::Cotangent => (plain.into_faces(), of_mesh(mesh, options.par)?, 0.0),
            kind => {
                let complex = Complex::delaunay(mesh, kind)?;
                let elements = complex.elements()?;
                (complex.into_faces(), elements, ROUNDING)
            }
        };
        let components = components(n, &faces);
        let (stiffness, mass) =
            assemble(n, &faces, &elements, rounding, MassKind::Barycentric, options.par);
        let (Mass::Lumped(mass), time) = (mass, options.time * mean * mean) else {
            let why = "barycentric masses are not a diagonal".into();
            return Err(Error::Argument { what: "mass", why });
        };
        let starts = stiffness.indptr();
        // The matrix is symmetric: storage by rows and by columns is the same.
        let places = SymbolicSparseColMatRef::new_checked(
            n,
            n,
            starts.raw_storage(),
            None,
            stiffness.indices(),
        );
        let symbolic = Symbolic::new(places)?;
        let factor = |matrix: &CsMat<f64>| {
            let found = symbolic.positive(SparseColMatRef::new(places, matrix.data()))?;
            found.filter(Factor::is_finite).ok_or_else(|| {
                let why = "its Laplacian is not positive definite to working precision; \
                           the tufted Laplacian avoids this";
                Error::Argument { what: "mesh", why: why.into() }
            })
        };
        let in_no_face = |v: usize| mass[v] == 0.0;
        let heat = factor(&with_entries(&stiffness, |i, j, w| match (i == j, in_no_face(i)) {
            (true, true) => 1.0,
            (true, false) => time * w + mass[i],
            (false, _) => time * w,
        }))?;
        let held = |v: usize| components[v] as usize == v;
        let poisson =
            factor(&with_entries(&stiffness, |i, j, w| match (i == j, held(i) || held(j)) {
                (true, true) => 1.0,
                (false, true) => 0.0,
                (_, false) => w,
            }))?;
        Ok(Self { faces, elements, heat, poisson, components, par: options.par })
    }

    /// Returns the distance of every vertex from the nearest of the sources: 0 at sources, infinite
    /// in components without a source.
    ///
    /// ```
    /// use catamaran::mesh::{HeatMethod, HeatOptions, families};
    ///
    /// let cylinder = families::cylinder(24, 8, 1.0, 2.0)?;
    /// let bottom: Vec<u32> = (0..cylinder.vertices().len() as u32)
    ///     .filter(|&v| cylinder.vertices()[v as usize][2] == 0.0)
    ///     .collect();
    /// let distances = HeatMethod::new(&cylinder, &HeatOptions::new())?.distances(&bottom)?;
    /// let farthest = distances.iter().copied().fold(0.0, f64::max);
    /// assert!((farthest - 2.0).abs() < 0.1);
    /// # Ok::<(), catamaran::Error>(())
    /// ```
    ///
    /// # Errors
    /// [`Error::Argument`] names a source that does not exist. [`Error::Mesh`] names a vertex which
    /// is too many edges away (about 650 with time 1) for heat to arrive: use a longer time.
    pub fn distances(&self, sources: &[u32]) -> Result<Vec<f64>> {
        let n = self.components.len();
        let mut right = vec![0.0; n];
        let mut warm = vec![false; n];
        for &source in sources {
            let Some(heat) = right.get_mut(source as usize) else {
                let why = format!("vertex {source} is out of range: {n} vertices, numbered from 0");
                return Err(Error::Argument { what: "sources", why });
            };
            *heat = 1.0;
            warm[self.components[source as usize] as usize] = true;
        }
        let warm = |v: usize| warm[self.components[v] as usize];
        let mut heat = right;
        self.heat.solve(ColMut::from_slice_mut(&mut heat).as_mat_mut(), self.par)?;
        let is_cold = |v: usize| heat[v].is_nan() || heat[v].abs() <= COLD;
        if let Some(v) = (0..n).find(|&v| warm(v) && is_cold(v)) {
            let what = "too many edges away for heat to arrive; use a longer time".into();
            return Err(Error::Mesh { what, element: format!("vertex {v}") });
        }
        let mut slopes = self.against_the_flow(&heat);
        for (v, slope) in slopes.iter_mut().enumerate() {
            if self.components[v] as usize == v {
                *slope = 0.0;
            }
        }
        let mut distances = slopes;
        self.poisson.solve(ColMut::from_slice_mut(&mut distances).as_mat_mut(), self.par)?;
        let mut least = vec![f64::INFINITY; n];
        for v in 0..n {
            let least = &mut least[self.components[v] as usize];
            *least = least.min(distances[v]);
        }
        for (v, distance) in distances.iter_mut().enumerate() {
            let from = least[self.components[v] as usize];
            *distance = if warm(v) { *distance - from } else { f64::INFINITY };
        }
        for &source in sources {
            distances[source as usize] = 0.0;
        }
        Ok(distances)
    }

    /// Returns the unit field against the gradient of heat u, integrated against the gradients of
    /// the hat functions: on a triangle with stiffness S this is `-S u / |grad u|`, and
    /// `area |grad u|^2 = u^T S u`.
    fn against_the_flow(&self, heat: &[f64]) -> Vec<f64> {
        let mut slopes = vec![0.0; heat.len()];
        for (face, element) in self.faces.iter().zip(&self.elements) {
            let u = face.map(|v| heat[v as usize]);
            let rise = [u[1] - u[0], u[2] - u[1], u[0] - u[2]];
            // Far from the source heat is tiny, and its square zero.
            let size = rise.iter().fold(0.0_f64, |m, d| m.max(d.abs()));
            if size == 0.0 {
                continue;
            }
            let rise = rise.map(|d| d / size);
            let w = element.weights;
            let energy: f64 = (0..3).map(|k| w[k] * rise[k] * rise[k]).sum();
            if energy <= 0.0 {
                continue; // the sum is rounding error: the triangle is a sliver
            }
            let unit = (element.area / energy).sqrt();
            for k in 0..3 {
                let before = (k + 2) % 3;
                slopes[face[k] as usize] += unit * (w[k] * rise[k] - w[before] * rise[before]);
            }
        }
        slopes
    }
}

/// Returns a matrix with the same sparsity pattern and other entries.
fn with_entries(matrix: &CsMat<f64>, entry: impl Fn(usize, usize, f64) -> f64) -> CsMat<f64> {
    let mut other = matrix.clone();
    for (i, mut row) in other.outer_iterator_mut().enumerate() {
        for (j, w) in row.iter_mut() {
            *w = entry(i, j, *w);
        }
    }
    other
}

/// Returns for each vertex the lowest vertex of its component.
fn components(n: usize, faces: &[[u32; 3]]) -> Vec<u32> {
    let mut sets = Sets::new(n);
    for &[a, b, c] in faces {
        sets.join(a, b);
        sets.join(a, c);
    }
    (0..n as u32).map(|v| sets.find(v)).collect()
}
