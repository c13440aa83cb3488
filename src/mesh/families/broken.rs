//! Meshes that make algorithms stumble.

use super::super::TriMesh;
use super::draft::{Draft, Seam, at_least, positive, sheet};
use crate::base::Result;

/// A strip of needles: [`grid`](super::grid) squeezed to the height `thinness` (rows stay `rows`), so that with
/// columns = rows its right triangles have legs in the ratio `thinness`, and qualities of about 1.7 `thinness`.
///
/// ```
/// use catamaran::mesh::families;
///
/// let needles = families::slivers(4, 4, 1e-3)?;
/// assert!(needles.qualities().iter().all(|&quality| quality < 2e-3));
/// # Ok::<(), catamaran::Error>(())
/// ```
///
/// # Errors
/// [`Error::Argument`](crate::Error::Argument) without a cell, for too many, or a thinness that is not positive.
pub fn slivers(columns: usize, rows: usize, thinness: f64) -> Result<TriMesh> {
    positive("thinness", thinness)?;
    sheet(columns, rows, Seam::Open, false, |i, j| {
        [i as f64 / columns as f64, thinness * j as f64 / rows as f64, 0.0]
    })
}

/// `count` triangles on one edge, 0 to 1, as pages of a book: V = 2 + count, F = count. The edge is non-manifold from three
/// pages on.
///
/// ```
/// use catamaran::mesh::families;
///
/// assert!(families::pages(2)?.require_manifold().is_ok());
/// assert!(families::pages(3)?.require_manifold().is_err());
/// # Ok::<(), catamaran::Error>(())
/// ```
///
/// # Errors
/// [`Error::Argument`](crate::Error::Argument) without pages or for too many.
pub fn pages(count: usize) -> Result<TriMesh> {
    at_least("count", count, 1)?;
    let mut draft = Draft::with_counts(count.checked_add(2), Some(count))?;
    draft.vertices.extend([[0.0; 3], [0.0, 0.0, 1.0]]);
    for page in 0..count {
        let (sin, cos) = super::draft::turn(page, count).sin_cos();
        draft.vertices.push([cos, sin, 0.5]);
        draft.faces.push([0, 1, page as u32 + 2]);
    }
    draft.finish()
}

/// Two closed tetrahedra that share vertex 0 and nothing else: V = 7, F = 8, Euler characteristic 3; a non-manifold vertex.
///
/// ```
/// use catamaran::mesh::families;
///
/// let mesh = families::bow_tie()?;
/// assert!(mesh.validate().is_closed() && mesh.require_manifold().is_err());
/// # Ok::<(), catamaran::Error>(())
/// ```
///
/// # Errors
/// None.
pub fn bow_tie() -> Result<TriMesh> {
    let mut draft = Draft::with_counts(Some(7), Some(8))?;
    draft.vertices.push([0.0; 3]);
    for (side, first) in [(1.0, 1), (-1.0, 4)] {
        draft.vertices.extend([[side, 0.0, 0.0], [0.0, side, 0.0], [0.0, 0.0, side]]);
        let [a, b, c] = [first, first + 1, first + 2];
        let faces = [[a, b, c], [0, b, a], [0, c, b], [0, a, c]];
        // The mirror image is seen from the other side.
        draft.faces.extend(faces.map(|[u, v, w]| if side > 0.0 { [u, v, w] } else { [u, w, v] }));
    }
    draft.finish()
}
