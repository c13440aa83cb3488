use catamaran::base::{Error, Result, reserved};
use catamaran_geometry::mesh::TriMesh;

/// Number of texels between triangles, so that no triangle gets texels of another.
const GAP: f64 = 2.0;
/// Least length of the legs of the triangles, in texels.
const SHORTEST_LEG: f64 = 3.0;

/// Returns the number of cells along a side of the grid, with two triangles in a cell.
fn cells(faces: usize) -> usize {
    ((faces.div_ceil(2)) as f64).sqrt().ceil() as usize
}

/// Returns the size of the smallest texture that has room for the [`atlas`] of this many faces: a
/// multiple of 32, in texels of a side.
///
/// ```
/// use catamaran_geometry::mesh::families;
/// use catamaran_simulation::texture::slime::{atlas, smallest_size};
///
/// let mesh = families::icosphere(1)?;
/// let size = smallest_size(mesh.faces().len());
/// assert!(size % 32 == 0 && atlas(&mesh, size).is_ok());
/// # Ok::<(), catamaran::Error>(())
/// ```
pub fn smallest_size(faces: usize) -> usize {
    let cell = SHORTEST_LEG + 2.0 * GAP + 1.0;
    ((cells(faces) as f64 * cell) as usize).next_multiple_of(32).max(32)
}

/// Computes texture coordinates for a mesh without any: every triangle is a chart of its own, half
/// a cell of a square grid, with its longest edge as the diagonal. Charts are two texels apart in a
/// texture of `size` x `size` texels.
///
/// ```
/// use catamaran_geometry::mesh::families;
/// use catamaran_simulation::texture::slime::{atlas, smallest_size};
///
/// let mesh = families::icosphere(1)?;
/// let uv = atlas(&mesh, smallest_size(mesh.faces().len()))?;
/// assert_eq!(uv.len(), mesh.faces().len());
/// assert!(uv.iter().flatten().flatten().all(|x| (0.0..=1.0).contains(x)));
/// assert!(atlas(&mesh, 32).is_err());
/// # Ok::<(), catamaran::Error>(())
/// ```
///
/// # Errors
/// [`Error::Argument`] when the size is below [`smallest_size`], [`Error::OutOfMemory`].
pub fn atlas(mesh: &TriMesh, size: usize) -> Result<Vec<[[f64; 2]; 3]>> {
    let faces = mesh.faces();
    let least = smallest_size(faces.len());
    if size < least {
        let why = format!("must be at least {least} for {} triangles, is {size}", faces.len());
        return Err(Error::Argument { what: "size", why });
    }
    let side = cells(faces.len()).max(1);
    let cell = size as f64 / side as f64;
    let leg = cell - 2.0 * GAP - 1.0;
    let mut uv = reserved(faces.len())?;
    for (f, face) in faces.iter().enumerate() {
        let corner = [f / 2 % side, f / 2 / side].map(|i| i as f64 * cell);
        // From the right angle along both legs; the second triangle of a cell is rotated by half a
        // turn.
        let (start, sign) = if f % 2 == 0 { (GAP / 2.0, 1.0) } else { (cell - GAP / 2.0, -1.0) };
        let right = corner.map(|x| x + start);
        let places = [right, [right[0] + sign * leg, right[1]], [right[0], right[1] + sign * leg]];
        let first = opposite_longest(face.map(|v| mesh.vertices()[v as usize]));
        let mut corners = [[0.0; 2]; 3];
        for (k, place) in places.into_iter().enumerate() {
            corners[(first + k) % 3] = place.map(|x| x / size as f64);
        }
        uv.push(corners);
    }
    Ok(uv)
}

/// Returns the corner opposite to the longest edge.
fn opposite_longest(corners: [[f64; 3]; 3]) -> usize {
    let square = |k: usize| {
        let (a, b) = (corners[(k + 1) % 3], corners[(k + 2) % 3]);
        (0..3).map(|i| (a[i] - b[i]).powi(2)).sum::<f64>()
    };
    let longest = |a: usize, b: usize| if square(b) > square(a) { b } else { a };
    longest(longest(0, 1), 2)
}
