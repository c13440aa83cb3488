//! Meshes with defects that algorithms must handle.

use super::super::TriMesh;
use super::draft::{Draft, Seam, sheet};
use catamaran::base::{Result, at_least, positive};

/// Generates a strip of needles: [`grid`](super::grid) squeezed to the height `thinness` (rows stay
/// `rows`). With columns = rows, its right triangles have legs in the ratio `thinness` and
/// qualities of about 1.7 `thinness`.
///
/// ```
/// use catamaran_geometry::mesh::families;
///
/// let needles = families::slivers(4, 4, 1e-3)?;
/// assert!(needles.qualities().iter().all(|&quality| quality < 2e-3));
/// # Ok::<(), catamaran::Error>(())
/// ```
///
/// # Errors
/// [`Error::Argument`](catamaran::Error::Argument) without a cell, for too many cells, or for a
/// thinness that is not positive.
pub fn slivers(columns: usize, rows: usize, thinness: f64) -> Result<TriMesh> {
    positive("thinness", thinness)?;
    sheet(columns, rows, Seam::Open, false, |i, j| {
        [i as f64 / columns as f64, thinness * j as f64 / rows as f64, 0.0]
    })
}

/// Generates `count` triangles on one edge, 0 to 1, like the pages of a book: V = 2 + count, F =
/// count. The edge is non-manifold from three pages on.
///
/// ```
/// use catamaran_geometry::mesh::families;
///
/// assert!(families::pages(2)?.require_manifold().is_ok());
/// assert!(families::pages(3)?.require_manifold().is_err());
/// # Ok::<(), catamaran::Error>(())
/// ```
///
/// # Errors
/// [`Error::Argument`](catamaran::Error::Argument) without pages or for too many.
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

/// Generates two closed tetrahedra that share vertex 0 and nothing else: V = 7, F = 8, Euler
/// characteristic 3; a non-manifold vertex.
///
/// ```
/// use catamaran_geometry::mesh::families;
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

/// Returns the triangles of a mesh, each with three vertices of its own: V = 3 F. This is what STL
/// files hold.
///
/// ```
/// use catamaran_geometry::mesh::families;
///
/// let soup = families::soup(&families::icosphere(0)?)?;
/// assert_eq!((soup.vertices().len(), soup.validate().components), (60, 20));
/// # Ok::<(), catamaran::Error>(())
/// ```
///
/// # Errors
/// None in practice.
pub fn soup(mesh: &TriMesh) -> Result<TriMesh> {
    let count = mesh.faces().len();
    let mut draft = Draft::with_counts(count.checked_mul(3), Some(count))?;
    let corners = mesh.faces().as_flattened();
    draft.vertices.extend(corners.iter().map(|&v| mesh.vertices()[v as usize]));
    draft.faces.extend((0..count as u32).map(|f| [3 * f, 3 * f + 1, 3 * f + 2]));
    draft.finish()
}

/// Generates the unit sphere in the form in which programs that keep one texture coordinate for
/// each vertex export it: cut open along a meridian, with a vertex at each pole for each of the
/// `columns`. `rows` count from the south pole to the north pole. V = (columns + 1) (rows - 1) + 2
/// columns, F = 2 columns (rows - 1). With vertices of equal positions welded, the mesh is a
/// sphere.
///
/// ```
/// use catamaran_geometry::mesh::families;
///
/// let split = families::split_sphere(8, 4)?;
/// assert_eq!((split.vertices().len(), split.faces().len()), (43, 48));
/// assert!(!split.validate().is_closed());
/// # Ok::<(), catamaran::Error>(())
/// ```
///
/// # Errors
/// [`Error::Argument`](catamaran::Error::Argument) for fewer than 3 columns or 2 rows, or too many.
pub fn split_sphere(columns: usize, rows: usize) -> Result<TriMesh> {
    at_least("columns", columns, 3)?;
    at_least("rows", rows, 2)?;
    let lines = columns.checked_add(1);
    let between = lines.and_then(|lines| lines.checked_mul(rows - 1));
    let poles = columns.checked_mul(2);
    let faces = poles.and_then(|both| both.checked_mul(rows - 1));
    let vertices = between.zip(poles).and_then(|(a, b)| a.checked_add(b));
    let mut draft = Draft::with_counts(vertices, faces)?;
    for j in 1..rows {
        let (up, height) = super::draft::turn(j, 2 * rows).sin_cos();
        for i in 0..=columns {
            // The last column has exactly the positions of the first one.
            let (sin, cos) = super::draft::turn(i % columns, columns).sin_cos();
            draft.vertices.push([up * cos, up * sin, -height]);
        }
    }
    let first_pole = draft.vertices.len();
    draft.vertices.extend((0..columns).map(|_| [0.0, 0.0, -1.0]));
    draft.vertices.extend((0..columns).map(|_| [0.0, 0.0, 1.0]));
    let number = |i: usize, j: usize| ((j - 1) * (columns + 1) + i) as u32;
    for i in 0..columns {
        draft.faces.push([(first_pole + i) as u32, number(i + 1, 1), number(i, 1)]);
        for j in 1..rows - 1 {
            let [a, b] = [number(i, j), number(i + 1, j)];
            let [c, d] = [number(i + 1, j + 1), number(i, j + 1)];
            draft.faces.extend([[a, b, c], [a, c, d]]);
        }
        let north = (first_pole + columns + i) as u32;
        draft.faces.push([number(i, rows - 1), number(i + 1, rows - 1), north]);
    }
    draft.finish()
}
