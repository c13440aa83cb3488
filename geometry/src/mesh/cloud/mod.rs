//! The Laplacian of a point cloud: small triangulations around every point, joined in a tufted
//! cover.
//!
//! Source: Sharp and Crane, A Laplacian for Nonmanifold Triangle Meshes (2020), section 5.7.

mod boundary;
mod sheet;
mod star;

use std::ops::Range;

use super::vector::{dot, doubled_normal, unit};
use super::{Boundary, Laplacian, LaplacianKind, LaplacianOptions, TriMesh, laplacian_rows};
use catamaran::base::{Error, Par, Result, options};
use catamaran::sparse::Mass;

use boundary::{EMPTY, NEARLY_EMPTY, boundary};
use sheet::{BLOCK, Neighbourhoods};
use star::Star;

options! {
    /// Options of [`cloud_laplacian`].
    #[derive(Debug, Clone, PartialEq)]
    pub struct CloudOptions {
        /// Number of nearest points with which each point is triangulated.
        neighbours: usize = 30, check(at least 3);
        /// Condition at the boundary, which consists of loops of points beside which the triangles
        /// leave a gap.
        boundary: Boundary = Boundary::Neumann;
        /// Threads. Their number does not change the result.
        par: Par = Par::all();
    }
}

/// Divisor of the matrices: most triangles are found three times, once from each corner.
const COPIES: f64 = 3.0;

/// Number of nearest points, on any sheet, that surround a point unless it is on the boundary.
const ALL_SHEETS: usize = 12;

/// Least cosine between the normal of a triangle and those of its corners: others cross from one
/// sheet to another.
const ALONG: f64 = 0.3;

/// Computes the Laplacian of the surface that `points` were sampled from.
///
/// Around each point, the nearest points on the same sheet of the surface are turned into its
/// tangent plane, and the triangles at the point are those of the Delaunay triangulation there. The
/// result is the tufted Laplacian of all these triangles, divided by three. The boundary consists
/// of loops of points beside an empty circle; holes of less than two spacings are closed.
///
/// ```
/// use catamaran_geometry::mesh::{CloudOptions, cloud_laplacian, families};
///
/// let points = families::icosphere(2)?.into_parts().0;
/// let found = cloud_laplacian(&points, &CloudOptions::new().neighbours(12))?;
/// assert_eq!(found.kept.len(), points.len());
/// # Ok::<(), catamaran::Error>(())
/// ```
///
/// # Errors
/// [`Error::NonFinite`] for a coordinate; [`Error::Argument`] for fewer than 3 neighbours;
/// [`Error::Mesh`] for points at the same place, and as [`laplacian_rows`].
pub fn cloud_laplacian(points: &[[f64; 3]], options: &CloudOptions) -> Result<Laplacian> {
    cloud_laplacian_rows(points, options, |rows| 0..rows)
}

/// Computes some rows of the Laplacian of a cloud, as [`laplacian_rows`] does of a mesh.
///
/// # Errors
/// Those of [`cloud_laplacian`] and [`laplacian_rows`].
pub fn cloud_laplacian_rows(
    points: &[[f64; 3]],
    options: &CloudOptions,
    share: impl FnOnce(usize) -> Range<usize>,
) -> Result<Laplacian> {
    let Triangles { mesh, open } = triangles(points, options)?;
    let boundary = match &options.boundary {
        Boundary::Dirichlet => Boundary::Mixed(open),
        other => other.clone(),
    };
    let settings = LaplacianOptions {
        kind: LaplacianKind::Tufted,
        boundary,
        par: options.par,
        ..LaplacianOptions::default()
    };
    let mut found = laplacian_rows(&mesh, &settings, share)?;
    found.stiffness.data_mut().iter_mut().for_each(|weight| *weight /= COPIES);
    if let Mass::Lumped(masses) = &mut found.mass {
        masses.iter_mut().for_each(|mass| *mass /= COPIES);
    }
    Ok(found)
}

/// The triangles around all points.
struct Triangles {
    mesh: TriMesh,
    /// The points of the boundary, ascending.
    open: Vec<u32>,
}

fn triangles(points: &[[f64; 3]], options: &CloudOptions) -> Result<Triangles> {
    options.check_ranges()?;
    for (i, p) in points.iter().enumerate() {
        if let Some(j) = p.iter().position(|x| !x.is_finite()) {
            return Err(Error::NonFinite { what: "points", index: (i, j) });
        }
    }
    let cloud = Neighbourhoods::new(points, options.neighbours, options.par)?;
    let stars: Vec<(Star, f64)> = options
        .par
        .map_blocks(points.len(), BLOCK, |block| {
            block.map(|i| star(&cloud, i as u32)).collect::<Vec<_>>()
        })
        .into_iter()
        .flatten()
        .collect();
    let emptiest: Vec<f64> = stars.iter().map(|&(_, emptiest)| emptiest).collect();
    let on_boundary = boundary(&cloud, &emptiest)?;
    let mut faces = Vec::new();
    for ((star, _), &open) in stars.iter().zip(&on_boundary) {
        let fits = |&&(face, emptiness): &&([u32; 3], f64)| {
            !(open && emptiness > EMPTY) && is_along(&cloud, face)
        };
        let count = faces.len();
        faces.extend(star.faces.iter().filter(fits).map(|&(face, _)| face));
        if faces.len() == count {
            faces.extend(star.faces.iter().map(|&(face, _)| face));
        }
    }
    let open = (0u32..).zip(on_boundary).filter_map(|(i, open)| open.then_some(i)).collect();
    Ok(Triangles { mesh: TriMesh::new(points.to_vec(), faces)?, open })
}

/// Returns the triangles around a point, and how empty its surroundings are: among its neighbours
/// on the same sheet, and also among all that are near, which surround a point in a crease.
fn star(cloud: &Neighbourhoods<'_>, centre: u32) -> (Star, f64) {
    let star = Star::new(cloud, centre, &cloud.sheet(centre));
    let mut emptiest = star.emptiest;
    if emptiest > NEARLY_EMPTY {
        let plain = Star::new(cloud, centre, &cloud.nearest(centre, ALL_SHEETS));
        emptiest = emptiest.min(plain.emptiest);
    }
    (star, emptiest)
}

/// Returns whether a triangle lies along the surface at its corners.
fn is_along(cloud: &Neighbourhoods<'_>, face: [u32; 3]) -> bool {
    let normal = unit(doubled_normal(face.map(|i| cloud.points[i as usize])));
    face.iter().all(|&i| dot(normal, cloud.normals[i as usize]).abs() > ALONG)
}

#[cfg(test)]
mod tests;
