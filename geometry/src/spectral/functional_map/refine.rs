//! Refines functional maps by way of point-to-point maps.

use faer::{Mat, MatRef, Scale};

use super::points::{nearest_images, pull_back};
use crate::spectral::basis::{Basis, times_mass};
use crate::spectral::dense;
use catamaran::base::{Error, Par, Progress, Result};

/// A refined functional map with its point-to-point map.
#[derive(Debug, Clone)]
pub struct Refined {
    /// The functional map, r_target x r_source.
    pub map: Mat<f64>,
    /// The point-to-point map from which `map` was computed: a vertex of the source for each vertex
    /// of the target.
    pub points: Vec<u32>,
}

/// Refines a map by iterative closest points in the spectral embedding (Ovsjanikov et al. 2012,
/// section 6.2): alternates between the point-to-point map of `c` and the orthogonal matrix
/// (Procrustes) that fits these points best, until the points stay the same or `iterations` (at
/// least 1) are done.
///
/// `c` is r_target x r_source, for orthonormal bases. The matrix is orthogonal up to a factor for
/// meshes of different areas.
///
/// ```
/// use catamaran_geometry::spectral::{Eigenbasis, functional_map::icp};
/// use catamaran_geometry::prelude::*;
/// use catamaran_geometry::mesh::families;
///
/// # let mesh = families::icosphere(2)?;
/// # let operator = laplacian(&mesh, &LaplacianOptions::new())?;
/// # let pairs = eigs(operator.stiffness.view(), &operator.mass, &EigenOptions::new().k(4))?;
/// # let basis = Eigenbasis::new(pairs.values, pairs.vectors, operator.mass)?;
/// # let basis = basis.basis();
/// // A map with errors of 5 % becomes the identity again.
/// let c = Mat::from_fn(4, 4, |i, j| if i == j { 1.0 } else { 0.05 });
/// let found = icp(c.as_ref(), basis, basis, 10, Par::Seq, Progress::none())?;
/// assert!((&found.map - Mat::<f64>::identity(4, 4)).norm_max() < 0.05);
/// assert!((found.map.transpose() * &found.map - Mat::<f64>::identity(4, 4)).norm_max() < 1e-12);
/// # Ok::<(), catamaran::Error>(())
/// ```
///
/// # Errors
/// [`Error::Shape`] when the shape of `c` does not fit the bases, [`Error::NonFinite`],
/// [`Error::Argument`] for zero iterations, a basis that is not orthonormal or a mesh without area,
/// [`Error::OutOfMemory`], [`Error::Cancelled`].
pub fn icp(
    c: MatRef<'_, f64>,
    source: &Basis,
    target: &Basis,
    iterations: usize,
    par: Par,
    progress: Progress<'_>,
) -> Result<Refined> {
    Error::check_shape("functional map", (target.len(), source.len()), c.shape())?;
    dense::check_finite("functional map", c)?;
    if iterations == 0 {
        return Err(Error::Argument { what: "iterations", why: "must be at least 1".into() });
    }
    let pair = Pair::new(source, target, par)?;
    let mut map = c.to_owned();
    let mut points = Vec::new();
    for done in 0..iterations {
        let at = |i: usize| i as f64 / iterations as f64;
        let before = std::mem::take(&mut points);
        points = pair.points(map.as_ref(), progress.part(at(done)..at(done + 1)))?;
        if points == before {
            break;
        }
        let free = pair.map(&points, map.shape())?;
        let svd = dense::thin_svd("functional map", free.as_ref())?;
        map = Scale(pair.ratio.sqrt()) * dense::product(svd.u.as_ref(), svd.v.transpose(), par)?;
    }
    Ok(Refined { map, points })
}

/// Refines a map by ZoomOut (Melzi et al. 2019): alternates between the point-to-point map of `c`
/// and the functional map of these points with `step` (at least 1) more functions on both sides,
/// until all functions of the two bases are used.
///
/// `c` is k_target x k_source, for the first functions of the bases, at most all of them. The basis
/// whose functions are used up first stays complete while the other one grows.
///
/// Any orthonormal bases are possible (thesis, section 1.5): eigenfunctions, or orthogonalized
/// eigenproducts ([`Reorthogonalized`](crate::spectral::Orthogonalization::Reorthogonalized)). The
/// first products are the eigenfunctions themselves, so that a map between eigenfunctions can be
/// the start.
///
/// ```
/// use catamaran_geometry::spectral::{Eigenbasis, functional_map::zoomout};
/// use catamaran_geometry::prelude::*;
/// use catamaran_geometry::mesh::families;
///
/// # let mesh = families::icosphere(2)?;
/// # let operator = laplacian(&mesh, &LaplacianOptions::new())?;
/// # let pairs = eigs(operator.stiffness.view(), &operator.mass, &EigenOptions::new().k(9))?;
/// # let basis = Eigenbasis::new(pairs.values, pairs.vectors, operator.mass)?;
/// # let basis = basis.basis();
/// // From a map of four functions to one of nine.
/// let c = Mat::<f64>::identity(4, 4);
/// let found = zoomout(c.as_ref(), basis, basis, 1, Par::Seq, Progress::none())?;
/// assert!((found.map - Mat::<f64>::identity(9, 9)).norm_max() < 1e-8);
/// assert!(found.points.iter().enumerate().all(|(v, &image)| v == image as usize));
/// # Ok::<(), catamaran::Error>(())
/// ```
///
/// # Errors
/// [`Error::Shape`] when `c` has more rows or columns than the bases have functions,
/// [`Error::NonFinite`], [`Error::Argument`] for a step of 0, a map without rows or columns, a
/// basis that is not orthonormal or a mesh without area, [`Error::OutOfMemory`],
/// [`Error::Cancelled`].
pub fn zoomout(
    c: MatRef<'_, f64>,
    source: &Basis,
    target: &Basis,
    step: usize,
    par: Par,
    progress: Progress<'_>,
) -> Result<Refined> {
    let full = (target.len(), source.len());
    let (mut rows, mut columns) = c.shape();
    if rows > full.0 || columns > full.1 {
        return Err(Error::Shape { what: "functional map", expected: full, got: c.shape() });
    }
    dense::check_finite("functional map", c)?;
    if step == 0 {
        return Err(Error::Argument { what: "step", why: "must be at least 1, is 0".into() });
    }
    if rows == 0 || columns == 0 {
        let why = format!("is {rows} x {columns}, must not be empty");
        return Err(Error::Argument { what: "functional map", why });
    }
    let pair = Pair::new(source, target, par)?;
    let steps = (full.0 - rows).max(full.1 - columns).div_ceil(step);
    let step_of = |i: usize| {
        let at = |i: usize| i as f64 / (steps + 1) as f64;
        progress.part(at(i)..at(i + 1))
    };
    let mut map = c.to_owned();
    for done in 0..steps {
        let points = pair.points(map.as_ref(), step_of(done))?;
        (rows, columns) = ((rows + step).min(full.0), (columns + step).min(full.1));
        map = pair.map(&points, (rows, columns))?;
    }
    // The map of the last step, so that map and points belong together.
    let points = pair.points(map.as_ref(), step_of(steps))?;
    let map = pair.map(&points, full)?;
    Ok(Refined { map, points })
}

/// Two orthonormal bases between which maps are refined.
struct Pair<'a> {
    source: &'a Basis,
    target: &'a Basis,
    /// The mass of the target times its functions.
    weighted: Mat<f64>,
    /// Area of the target divided by that of the source.
    ratio: f64,
    par: Par,
}

impl<'a> Pair<'a> {
    fn new(source: &'a Basis, target: &'a Basis, par: Par) -> Result<Self> {
        for (what, basis) in [("source", source), ("target", target)] {
            if !basis.is_orthonormal() {
                let why = "its functions are not orthonormal, such as those of a single pass";
                return Err(Error::Argument { what, why: why.into() });
            }
        }
        let ratio = target.area()? / source.area()?;
        let weighted = times_mass(target.mass(), target.functions(), par)?;
        Ok(Self { source, target, weighted, ratio, par })
    }

    /// Returns the point-to-point map of a map between the first functions.
    fn points(&self, map: MatRef<'_, f64>, progress: Progress<'_>) -> Result<Vec<u32>> {
        let source = self.source.functions().subcols(0, map.ncols());
        let target = self.target.functions().subcols(0, map.nrows());
        nearest_images(map, source, target, self.ratio, self.par, progress)
    }

    /// Returns the functional map of a point-to-point map, between the first functions.
    fn map(&self, points: &[u32], (rows, columns): (usize, usize)) -> Result<Mat<f64>> {
        let pulled = pull_back(points, self.source.functions().subcols(0, columns))?;
        let weighted = self.weighted.subcols(0, rows);
        dense::transposed_product(weighted, pulled.as_ref(), self.par)
    }
}
