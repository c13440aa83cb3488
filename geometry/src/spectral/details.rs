//! Transfer of geometric detail (thesis, section 1.4.1).

use faer::{Mat, MatRef};

use super::basis::Basis;
use super::transfer::Transfer;
use crate::mesh::TriMesh;
use catamaran::base::{Error, Par, Result};

/// Returns the coordinates of the vertices (XYZ): three columns.
///
/// ```
/// use catamaran_geometry::{mesh::families, spectral::coordinates};
///
/// let mesh = families::icosphere(1)?;
/// assert_eq!(coordinates(&mesh)[(7, 2)], mesh.vertices()[7][2]);
/// # Ok::<(), catamaran::Error>(())
/// ```
pub fn coordinates(mesh: &TriMesh) -> Mat<f64> {
    Mat::from_fn(mesh.vertices().len(), 3, |i, j| mesh.vertices()[i][j])
}

/// Functions split into their part in a span and the remaining detail.
#[derive(Debug, Clone)]
pub struct Split {
    /// The nearest functions in the span, n x c.
    pub low: Mat<f64>,
    /// The detail, n x c: the difference between the functions and `low`.
    pub high: Mat<f64>,
}

/// Splits the columns of `f`, n x c, into their part in the span of a basis, such as a few
/// eigenfunctions, and the detail.
///
/// ```
/// use catamaran::{Par, faer::{Mat, mat}, sparse::Mass};
/// use catamaran_geometry::spectral::{Basis, split};
///
/// let basis = Basis::orthonormal(Mat::identity(3, 2), Mass::identity(3))?;
/// let parts = split(&basis, mat![[1.0], [2.0], [3.0]].as_ref(), Par::Seq)?;
/// assert_eq!((parts.low, parts.high), (mat![[1.0], [2.0], [0.0]], mat![[0.0], [0.0], [3.0]]));
/// # Ok::<(), catamaran::Error>(())
/// ```
///
/// # Errors
/// As [`Basis::analysis`].
pub fn split(basis: &Basis, f: MatRef<'_, f64>, par: Par) -> Result<Split> {
    let low = basis.approximation(f, par)?;
    let high = f - &low;
    Ok(Split { low, high })
}

/// Replaces the detail of the target by that of the source, as heights over the smooth part.
///
/// `smooth` is a basis of low frequencies on each mesh (source, target), which splits the
/// coordinates into a smooth part and detail. The height of the source over its smooth part, along
/// the normals of that part, is transferred by `transfer`, scaled by the ratio of lengths where the
/// sizes differ, and replaces the height of the target over its own smooth part. Heights, unlike
/// positions, do not depend on the pose. Detail of the target tangential to its smooth part stays:
/// thin limbs consist mostly of it, because few low frequencies represent them.
///
/// [`Transfer::apply`] replaces all coordinates of the target by those of the source, as in figure
/// 1.13.
///
/// ```
/// use catamaran_geometry::spectral::{Eigenbasis, Transfer, transfer_details};
/// use catamaran_geometry::prelude::*;
/// use catamaran_geometry::mesh::families;
///
/// # let mesh = families::icosphere(2)?;
/// # let operator = laplacian(&mesh, &LaplacianOptions::new())?;
/// # let pairs = eigs(operator.stiffness.view(), &operator.mass, &EigenOptions::new().k(4))?;
/// # let basis = Eigenbasis::new(pairs.values, pairs.vectors, operator.mass)?;
/// // A sphere that gets its own detail changes little: four functions represent it nearly.
/// let basis = basis.basis();
/// let transfer = Transfer::new(basis, basis, Mat::identity(4, 4))?;
/// let found = transfer_details(&mesh, &mesh, (basis, basis), &transfer, Par::Seq)?;
/// let near = |p: &[f64; 3], q: &[f64; 3]| (0..3).all(|k| (p[k] - q[k]).abs() < 0.02);
/// assert!(found.vertices().iter().zip(mesh.vertices()).all(|(p, q)| near(p, q)));
/// # Ok::<(), catamaran::Error>(())
/// ```
///
/// # Errors
/// [`Error::Shape`] when a basis or the transfer belongs to another mesh, and as
/// [`Transfer::apply`] and [`TriMesh::new`].
pub fn transfer_details(
    source: &TriMesh,
    target: &TriMesh,
    smooth: (&Basis, &Basis),
    transfer: &Transfer<'_>,
    par: Par,
) -> Result<TriMesh> {
    let (_, carried) = heights(source, smooth.0, par)?;
    let (normals, own) = heights(target, smooth.1, par)?;
    let carried = transfer.apply(carried.as_ref(), par)?;
    Error::check_shape("transfer", own.shape(), carried.shape())?;
    let scale = (smooth.1.area()? / smooth.0.area()?).sqrt();
    let mut positions = coordinates(target);
    for (i, normal) in normals.iter().enumerate() {
        let change = scale * carried[(i, 0)] - own[(i, 0)];
        for c in 0..3 {
            positions[(i, c)] += change * normal[c];
        }
    }
    moved(target, positions.as_ref())
}

/// Returns the normals of the mesh of the low part of the coordinates, and the height of each
/// vertex along its normal.
fn heights(mesh: &TriMesh, basis: &Basis, par: Par) -> Result<(Vec<[f64; 3]>, Mat<f64>)> {
    let parts = split(basis, coordinates(mesh).as_ref(), par)?;
    let normals = moved(mesh, parts.low.as_ref())?.vertex_normals();
    let height = |i: usize| (0..3).map(|c| parts.high[(i, c)] * normals[i][c]).sum();
    let heights = Mat::from_fn(normals.len(), 1, |i, _| height(i));
    Ok((normals, heights))
}

/// Returns the mesh with its vertices at these positions.
fn moved(mesh: &TriMesh, positions: MatRef<'_, f64>) -> Result<TriMesh> {
    let vertices = (0..positions.nrows()).map(|i| [0, 1, 2].map(|c| positions[(i, c)])).collect();
    TriMesh::new(vertices, mesh.faces().to_vec())
}
