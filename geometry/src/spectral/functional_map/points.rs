//! Conversions between functional maps and point-to-point maps.

use faer::{Mat, MatRef, Scale};

use super::nearest::nearest_rows;
use crate::spectral::basis::Basis;
use crate::spectral::dense;
use catamaran::base::{Error, Par, Progress, Result};
use catamaran::dense::zeros;

/// Number of functions whose pull-backs are computed at once, to save memory.
const PANEL: usize = 256;

/// Computes the point-to-point map of a functional map `c` (r_target x r_source) of two bases: for
/// each vertex of the target, the vertex of the source whose image under `c` is nearest in the
/// basis (Ovsjanikov et al. 2012; thesis, section 1.3.4, step 1).
///
/// With Phi and Psi the functions on source and target, row y of Psi, the coefficients of a point
/// mass at y, is matched with the rows of `Phi C^T`, the coefficients of the images of point masses
/// on the source. The images have the mass of an area on the source, so they are divided by the
/// ratio of the areas of target and source; otherwise meshes of different sizes would not match.
/// Among equally near vertices, the first one is taken.
///
/// ```
/// use catamaran_geometry::spectral::{Eigenbasis, functional_map::points_from_map};
/// use catamaran_geometry::prelude::*;
/// use catamaran_geometry::mesh::families;
///
/// # let mesh = families::icosphere(2)?;
/// # let operator = laplacian(&mesh, &LaplacianOptions::new())?;
/// # let pairs = eigs(operator.stiffness.view(), &operator.mass, &EigenOptions::new().k(4))?;
/// # let basis = Eigenbasis::new(pairs.values, pairs.vectors, operator.mass)?;
/// // The identity on functions is the identity on points.
/// let (c, basis) = (Mat::<f64>::identity(4, 4), basis.basis());
/// let points = points_from_map(c.as_ref(), basis, basis, Par::Seq, Progress::none())?;
/// assert!(points.iter().enumerate().all(|(v, &image)| v == image as usize));
/// # Ok::<(), catamaran::Error>(())
/// ```
///
/// # Errors
/// [`Error::Shape`] when the shape of `c` does not fit the bases, [`Error::NonFinite`],
/// [`Error::Argument`] when the source has no vertices, [`Error::OutOfMemory`],
/// [`Error::Cancelled`].
pub fn points_from_map(
    c: MatRef<'_, f64>,
    source: &Basis,
    target: &Basis,
    par: Par,
    progress: Progress<'_>,
) -> Result<Vec<u32>> {
    Error::check_shape("functional map", (target.len(), source.len()), c.shape())?;
    dense::check_finite("functional map", c)?;
    let ratio = target.area()? / source.area()?;
    nearest_images(c, source.functions(), target.functions(), ratio, par, progress)
}

/// Computes [`points_from_map`] from columns of the functions, for meshes with this ratio of areas.
pub(super) fn nearest_images(
    c: MatRef<'_, f64>,
    source: MatRef<'_, f64>,
    target: MatRef<'_, f64>,
    ratio: f64,
    par: Par,
    progress: Progress<'_>,
) -> Result<Vec<u32>> {
    let unscaled = Scale(1.0 / ratio) * c;
    let images = dense::product(source, unscaled.transpose(), par)?;
    nearest_rows(target, images.as_ref(), par, progress)
}

/// Computes the functional map, r_target x r_source, of a point-to-point map: the coefficients of
/// the pulled-back functions `f o points`, nearest in the norm of the target's mass (thesis,
/// section 1.3.4, step 2).
///
/// `points` holds a vertex of the source for each vertex of the target. Any bases are possible:
/// eigenfunctions give the functional map C, orthogonalized products the matrix O.
///
/// ```
/// use catamaran::{Par, faer::{Mat, mat}, sparse::Mass};
/// use catamaran_geometry::spectral::{Basis, functional_map::map_from_points};
///
/// let source = Basis::orthonormal(Mat::identity(2, 2), Mass::identity(2))?;
/// let target = Basis::orthonormal(Mat::identity(3, 3), Mass::identity(3))?;
/// let c = map_from_points(&[0, 1, 1], &source, &target, Par::Seq)?;
/// assert_eq!(c, mat![[1.0, 0.0], [0.0, 1.0], [0.0, 1.0]]);
/// # Ok::<(), catamaran::Error>(())
/// ```
///
/// # Errors
/// [`Error::Shape`] when the numbers of points and target vertices differ, [`Error::Argument`]
/// names the first point that is not a vertex of the source, [`Error::OutOfMemory`].
pub fn map_from_points(
    points: &[u32],
    source: &Basis,
    target: &Basis,
    par: Par,
) -> Result<Mat<f64>> {
    check_points(points, source.vertices(), target.vertices())?;
    let mut c = zeros(target.len(), source.len())?;
    for first in (0..source.len()).step_by(PANEL) {
        let width = PANEL.min(source.len() - first);
        let pulled = pull_back(points, source.functions().subcols(first, width))?;
        let coefficients = target.analysis(pulled.as_ref(), par)?;
        c.as_mut().subcols_mut(first, width).copy_from(&coefficients);
    }
    Ok(c)
}

/// Returns `f o points`: row y of the result is row `points[y]` of `f`.
///
/// ```
/// use catamaran::faer::mat;
/// use catamaran_geometry::spectral::functional_map::pull_back;
///
/// assert_eq!(pull_back(&[1, 0, 1], mat![[2.0], [3.0]].as_ref())?, mat![[3.0], [2.0], [3.0]]);
/// # Ok::<(), catamaran::Error>(())
/// ```
///
/// # Errors
/// [`Error::Argument`] names the first point that is not a row of `f`; [`Error::OutOfMemory`].
pub fn pull_back(points: &[u32], f: MatRef<'_, f64>) -> Result<Mat<f64>> {
    check_points(points, f.nrows(), points.len())?;
    let mut out = zeros(points.len(), f.ncols())?;
    for j in 0..f.ncols() {
        for (y, &x) in points.iter().enumerate() {
            out[(y, j)] = f[(x as usize, j)];
        }
    }
    Ok(out)
}

/// Returns an error unless `points` is a map from `target` vertices to `source` vertices.
fn check_points(points: &[u32], source: usize, target: usize) -> Result<()> {
    Error::check_shape("points", (target, 1), (points.len(), 1))?;
    match points.iter().position(|&x| x as usize >= source) {
        None => Ok(()),
        Some(y) => Err(Error::Argument {
            what: "points",
            why: format!("target vertex {y} is mapped to {}, must be below {source}", points[y]),
        }),
    }
}
