use std::borrow::Cow;

use faer::ColMut;
use faer::sparse::{SparseColMatRef, SymbolicSparseColMatRef};
use sprs::CsMat;

use super::super::laplacian::{Complex, Element, ROUNDING, assemble, of_mesh};
use super::super::{LaplacianKind, MassKind, TriMesh};
use super::bounds::Bounds;
use super::finer::finer;
use catamaran::base::{Error, Par, Result, Sets, options};
use catamaran::sparse::{Factor, Inverse, Mass, Symbolic};

/// Smallest heat whose direction of flow is reliable: smaller numbers have lost digits.
const COLD: f64 = 1e-290;

options! {
    /// Options of [`HeatMethod`].
    #[derive(Debug, Clone, Copy, PartialEq)]
    pub struct HeatOptions {
        /// Time of the heat flow, in units of the squared mean edge length of the triangulation on
        /// which it flows. A longer time gives smoother distances.
        time: f64 = 1.0, check(positive);
        /// Triangulation on which heat flows: with [`LaplacianKind::Tufted`] the intrinsic Delaunay
        /// triangulation for any mesh. On the triangles of the mesh itself
        /// ([`LaplacianKind::Cotangent`]), long triangles can make distances wrong by half and
        /// more.
        kind: LaplacianKind = LaplacianKind::Tufted;
        /// Threads. Their number does not change the result.
        par: Par = Par::all();
    }
}

/// Distances along the surface by the heat method: Crane, Weischedel and Wardetzky, Geodesics in
/// Heat (2013), with Neumann conditions at the boundary.
///
/// The distances are not exact; docs/algorithms/laplacian.md bounds the errors. Heat flows on the
/// intrinsic Delaunay triangulation, and a mesh of fewer than 500 faces is refined for it. Results
/// are at least the straight distance through space and at most the length of the shortest path
/// along edges of the mesh or of the triangulation.
///
/// Creating the solver takes two sparse Cholesky factorizations; each set of sources takes two
/// solves and a search along edges.
///
/// ```
/// use catamaran_geometry::mesh::{HeatMethod, HeatOptions, families};
///
/// let sphere = families::icosphere(3)?;
/// let distances = HeatMethod::new(&sphere, &HeatOptions::new())?.distances(&[0])?;
/// assert!(distances[0].abs() < 1e-6);
/// assert!((distances.iter().copied().fold(0.0, f64::max) - std::f64::consts::PI).abs() < 0.2);
/// # Ok::<(), catamaran::Error>(())
/// ```
#[derive(Debug)]
pub struct HeatMethod {
    /// Number of vertices of the mesh: the first of those that heat flows through.
    vertices: usize,
    faces: Vec<[u32; 3]>,
    elements: Vec<Element>,
    bounds: Bounds,
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
        options.check_ranges()?;
        let vertices = mesh.vertices().len();
        let (mut triangles, mut mesh) = (Triangles::new(mesh, options)?, Cow::Borrowed(mesh));
        // Only now, so that errors name vertices and faces of the given mesh.
        if let Some(finer) = finer(&mesh)? {
            triangles = Triangles::new(&finer, options)?;
            mesh = Cow::Owned(finer);
        }
        let (n, mean) = (mesh.vertices().len(), triangles.mean_length());
        let Triangles { faces, lengths, elements, rounding } = triangles;
        let bounds = Bounds::new(&mesh, &faces, &lengths)?;
        let components = components(n, &faces);
        let (stiffness, mass) =
            assemble(n, 0..n, &faces, &elements, rounding, MassKind::Barycentric, options.par)?;
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
                let advice = match options.kind {
                    LaplacianKind::Tufted => "",
                    _ => "; the tufted Laplacian avoids this",
                };
                let why =
                    format!("its Laplacian is not positive definite to working precision{advice}");
                Error::Argument { what: "mesh", why }
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
        Ok(Self { vertices, faces, elements, bounds, heat, poisson, components, par: options.par })
    }

    /// Returns the distance of every vertex from the nearest of the sources: 0 at sources, infinite
    /// in components without a source.
    ///
    /// ```
    /// use catamaran_geometry::mesh::{HeatMethod, HeatOptions, families};
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
            if source as usize >= self.vertices {
                let count = self.vertices;
                let why =
                    format!("vertex {source} is out of range: {count} vertices, numbered from 0");
                return Err(Error::Argument { what: "sources", why });
            }
            right[source as usize] = 1.0;
            warm[self.components[source as usize] as usize] = true;
        }
        let warm = |v: usize| warm[self.components[v] as usize];
        let mut heat = right;
        self.heat.solve(ColMut::from_slice_mut(&mut heat).as_mat_mut(), self.par)?;
        let is_cold = |v: usize| heat[v].is_nan() || heat[v].abs() <= COLD;
        if let Some(v) = (0..self.vertices).find(|&v| warm(v) && is_cold(v)) {
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
        self.bounds.impose(sources, &self.components, &mut distances)?;
        distances.truncate(self.vertices);
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

/// The triangles on which heat flows.
struct Triangles {
    faces: Vec<[u32; 3]>,
    /// Lengths of the edges; edge k joins corners k and k + 1 (mod 3).
    lengths: Vec<[f64; 3]>,
    elements: Vec<Element>,
    /// Weights that are negative by less than this are zero; see [`assemble`].
    rounding: f64,
}

impl Triangles {
    fn new(mesh: &TriMesh, options: &HeatOptions) -> Result<Self> {
        let (complex, elements, rounding) = match options.kind {
            LaplacianKind::Cotangent => (Complex::of_mesh(mesh)?, of_mesh(mesh, options.par)?, 0.0),
            kind => {
                let complex = Complex::delaunay(mesh, kind)?;
                let elements = complex.elements()?;
                (complex, elements, ROUNDING)
            }
        };
        let Complex { faces, lengths, .. } = complex;
        Ok(Self { faces, lengths, elements, rounding })
    }

    /// Returns the mean length of the edges of all triangles, or 0 without triangles.
    fn mean_length(&self) -> f64 {
        let lengths = self.lengths.as_flattened();
        lengths.iter().map(|l| l / lengths.len() as f64).sum()
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
