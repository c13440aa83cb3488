//! Parts of a surface, and their spectra.

use crate::mesh::{
    Adjacency, Boundary, CloudOptions, Edges, Laplacian, LaplacianOptions, TriMesh,
    cloud_laplacian, laplacian,
};
use catamaran::base::{Error, Par, Progress, Result};
use catamaran::sparse::{EigenOptions, eigs};

/// Residual of eigenpairs; the relative error of eigenvalues is about its square.
const TOLERANCE: f64 = 1e-4;

/// First eigenvalue times the area, below which a component of points has no boundary; a disk has
/// 18, and a sphere with a tiny hole about 6 / ln(1 / its relative size).
const FREE: f64 = 1e-6;

/// Computes the spectra of parts of one surface, whose Laplacian is assembled once.
///
/// A part is a mask: for each vertex, whether it belongs to the part. The faces of the part are
/// those whose three vertices belong to it.
///
/// With Dirichlet conditions, eigenfunctions are zero at the vertices on the edge of the part, and
/// on the boundary of the surface: the matrices are principal submatrices of those of the surface.
/// So, if one part contains another, no eigenvalue of the inner part is smaller than that of the
/// same index of the outer part (domain monotonicity, here by Cauchy's interlacing, exactly for
/// these matrices). A complete closed surface has no vertex to hold at zero: its first eigenvalue
/// is 0.
///
/// ```
/// use catamaran_geometry::{mesh::{LaplacianOptions, families}, unions::PartSpectra};
///
/// let mesh = families::icosphere(3)?;
/// let spectra = PartSpectra::new(&mesh, &LaplacianOptions::new())?;
/// let above = |z: f64| mesh.vertices().iter().map(|p| p[2] > z).collect::<Vec<_>>();
/// let (small, large) = (spectra.dirichlet(&above(0.3), 5)?, spectra.dirichlet(&above(-0.3), 5)?);
/// // A larger domain has smaller eigenvalues.
/// assert!(large.iter().zip(&small).all(|(large, small)| large <= small));
/// # Ok::<(), catamaran::Error>(())
/// ```
#[derive(Debug, Clone)]
pub struct PartSpectra<'m> {
    mesh: &'m TriMesh,
    options: LaplacianOptions,
    operator: Laplacian,
    neighbours: Adjacency,
    on_boundary: Vec<bool>,
    progress: Progress<'m>,
}

impl<'m> PartSpectra<'m> {
    /// Assembles the Laplacian of the surface. The boundary conditions of the options have no
    /// effect.
    ///
    /// # Errors
    /// As [`laplacian()`].
    pub fn new(mesh: &'m TriMesh, options: &LaplacianOptions) -> Result<Self> {
        let options = LaplacianOptions { boundary: Boundary::Neumann, ..options.clone() };
        let operator = laplacian(mesh, &options)?;
        let edges = Edges::new(mesh);
        let mut on_boundary = vec![false; mesh.vertices().len()];
        for v in edges.boundary().flat_map(|e| edges.ends()[e as usize]) {
            on_boundary[v as usize] = true;
        }
        let neighbours = mesh.vertex_neighbors();
        let progress = Progress::none();
        Ok(Self { mesh, options, operator, neighbours, on_boundary, progress })
    }

    /// Sets a callback for the progress of each spectrum, from 0 to 1, which may cancel.
    pub fn progress(self, progress: impl Into<Progress<'m>>) -> Self {
        Self { progress: progress.into(), ..self }
    }

    /// Computes the k smallest eigenvalues of the part under Dirichlet conditions, ascending; in
    /// units of 1 / length^2.
    ///
    /// # Errors
    /// [`Error::Shape`] unless the mask has an entry for each vertex; [`Error::Argument`] when the
    /// part has fewer than k vertices inside; as [`eigs`] otherwise.
    pub fn dirichlet(&self, mask: &[bool], k: usize) -> Result<Vec<f64>> {
        self.progress.watch(|| {
            let inside = self.inside(mask)?;
            let operator = self.operator.restricted(&inside)?;
            self.eigenvalues(&operator, k, INNER)
        })
    }

    /// Computes the k smallest eigenvalues of the part under Neumann conditions, ascending: 0 for
    /// each of its components, then the positive ones; in units of 1 / length^2.
    ///
    /// ```
    /// use catamaran_geometry::{mesh::{LaplacianOptions, families}, unions::PartSpectra};
    ///
    /// let mesh = families::icosphere(2)?;
    /// let spectra = PartSpectra::new(&mesh, &LaplacianOptions::new())?;
    /// let upper: Vec<bool> = mesh.vertices().iter().map(|p| p[2] > -0.1).collect();
    /// let values = spectra.neumann(&upper, 3)?;
    /// assert!(values[0].abs() < 1e-6 && values[1] > 1.0);
    /// # Ok::<(), catamaran::Error>(())
    /// ```
    ///
    /// # Errors
    /// As [`PartSpectra::dirichlet`], and as [`laplacian()`] of the part.
    pub fn neumann(&self, mask: &[bool], k: usize) -> Result<Vec<f64>> {
        self.progress.watch(|| {
            let part = self.mesh.masked(mask)?;
            self.eigenvalues(&laplacian(&part.mesh, &self.options)?, k, "vertices of the part")
        })
    }

    /// Returns for each vertex whether it is inside of the part: the vertex and its neighbours
    /// belong to the part, and the vertex is not on the boundary of the surface.
    ///
    /// ```
    /// use catamaran_geometry::{mesh::{LaplacianOptions, families}, unions::PartSpectra};
    ///
    /// let mesh = families::grid(4, 4)?;
    /// let spectra = PartSpectra::new(&mesh, &LaplacianOptions::new())?;
    /// let inside = spectra.inside(&[true; 25])?;
    /// assert_eq!(inside.iter().filter(|&&is_inside| is_inside).count(), 9);
    /// # Ok::<(), catamaran::Error>(())
    /// ```
    ///
    /// # Errors
    /// [`Error::Shape`] unless the mask has an entry for each vertex.
    pub fn inside(&self, mask: &[bool]) -> Result<Vec<bool>> {
        let n = self.on_boundary.len();
        Error::check_shape("mask", (n, 1), (mask.len(), 1))?;
        let inside = |v: usize| {
            let around = self.neighbours.row(v);
            let closed = around.iter().all(|&w| mask[w as usize]);
            mask[v] && !self.on_boundary[v] && closed && !around.is_empty()
        };
        Ok((0..n).map(inside).collect())
    }

    fn eigenvalues(&self, operator: &Laplacian, k: usize, rows: &str) -> Result<Vec<f64>> {
        eigenvalues(operator, k, rows, self.options.par, self.progress)
    }
}

/// Computes the k smallest Dirichlet eigenvalues of the part of a surface that points were sampled
/// from (thesis, figure 2.8), ascending, in units of 1 / length^2: eigenvalues of
/// [`cloud_laplacian`], with functions zero at the points that their neighbours do not surround.
/// The boundary of the options has no effect.
///
/// ```
/// use catamaran_geometry::{mesh::CloudOptions, unions::cloud_spectrum};
///
/// let points: Vec<[f64; 3]> =
///     (0..31 * 31).map(|i| [f64::from(i / 31) / 30.0, f64::from(i % 31) / 30.0, 0.0]).collect();
/// let first = cloud_spectrum(&points, 1, &CloudOptions::new())?[0];
/// // The first eigenvalue of the unit square, 2 pi^2.
/// assert!((first / 19.74 - 1.0).abs() < 0.02);
/// # Ok::<(), catamaran::Error>(())
/// ```
///
/// # Errors
/// As [`cloud_laplacian`] and [`eigs`]; [`Error::Argument`] when fewer than k points are inside, or
/// when a component of the points has no boundary that can be seen.
pub fn cloud_spectrum(points: &[[f64; 3]], k: usize, options: &CloudOptions) -> Result<Vec<f64>> {
    let operator = cloud_laplacian(points, &options.clone().boundary(Boundary::Dirichlet))?;
    let values = eigenvalues(&operator, k, INNER, options.par, Progress::none())?;
    let area: f64 = (0..operator.mass.len()).map(|i| operator.mass.diagonal(i)).sum();
    if values.first().is_some_and(|first| first * area < FREE) {
        let why = "a component has no boundary that can be seen: each component of a part needs \
                   one, wider than two spacings of the points";
        return Err(Error::Argument { what: "points", why: why.into() });
    }
    Ok(values)
}

/// What errors call the rows of an operator with zeros on the boundary.
const INNER: &str = "inner vertices";

/// Computes the k smallest eigenvalues of an operator. `rows` is what errors call its rows.
fn eigenvalues(
    operator: &Laplacian,
    k: usize,
    rows: &str,
    par: Par,
    progress: Progress<'_>,
) -> Result<Vec<f64>> {
    let most = operator.kept.len();
    if k > most {
        let why = format!("must be at most {most}, the number of {rows}, is {k}");
        return Err(Error::Argument { what: "k", why });
    }
    let options = EigenOptions::new().k(k).tolerance(TOLERANCE).par(par).progress(progress);
    Ok(eigs(operator.stiffness.view(), &operator.mass, &options)?.values)
}
