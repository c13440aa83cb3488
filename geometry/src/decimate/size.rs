//! Relations between the numbers of vertices and faces and the length of edges.

use crate::mesh::vector::distance;
use crate::mesh::{Edges, TriMesh};
use catamaran::base::{Error, Result, at_least, positive};

/// Computes the length of the edges when `n` vertices are spread over an area by equilateral
/// triangles, of which there are 2 n: sqrt(4 A_E / sqrt 3) with A_E = area / (2 n), in units of
/// length. (The thesis has 3 n triangles and a factor 2, which fits neither.)
///
/// ```
/// use catamaran_geometry::decimate::edge_length_for;
///
/// // 2 n equilateral triangles with this side have the given area.
/// let side = edge_length_for(10.0, 100)?;
/// assert!((200.0 * side * side * 3_f64.sqrt() / 4.0 - 10.0).abs() < 1e-12);
/// # Ok::<(), catamaran::Error>(())
/// ```
///
/// # Errors
/// [`Error::Argument`] when n is 0, or the area is not positive and finite.
pub fn edge_length_for(area: f64, n: usize) -> Result<f64> {
    at_least("n", n, 1)?;
    positive("area", area)?;
    Ok((2.0 * area / (n as f64 * 3f64.sqrt())).sqrt())
}

/// Computes the number of vertices for edges of this length: the inverse of [`edge_length_for`],
/// rounded, at least 1.
///
/// ```
/// use catamaran_geometry::decimate::{edge_length_for, vertices_for_edge_length};
///
/// assert_eq!(vertices_for_edge_length(10.0, edge_length_for(10.0, 100)?)?, 100);
/// # Ok::<(), catamaran::Error>(())
/// ```
///
/// # Errors
/// [`Error::Argument`] when the length or the area is not positive and finite, or the number of
/// vertices is more than a mesh can have.
pub fn vertices_for_edge_length(area: f64, length: f64) -> Result<usize> {
    positive("area", area)?;
    positive("length", length)?;
    let n = 2.0 * area / (3f64.sqrt() * length * length);
    if n >= f64::from(u32::MAX) {
        let why = format!("{length:e} needs {n:.1e} vertices, more than a mesh can have");
        return Err(Error::Argument { what: "length", why });
    }
    Ok((n.round() as usize).max(1))
}

/// Computes the number of vertices at which a decimation of `mesh` has `faces` faces. For a closed
/// mesh, the number is exact up to one face. For a mesh with boundary, it is an estimate, which
/// assumes edges of the same length along the boundary.
///
/// ```
/// use catamaran_geometry::{decimate::vertices_for_faces, mesh::families};
///
/// assert_eq!(vertices_for_faces(&families::icosphere(3)?, 196)?, 100);
/// # Ok::<(), catamaran::Error>(())
/// ```
///
/// # Errors
/// [`Error::Argument`] when `faces` is 0, or the mesh has no area.
pub fn vertices_for_faces(mesh: &TriMesh, faces: usize) -> Result<usize> {
    at_least("faces", faces, 1)?;
    // 3 F = 2 E - B and V - E + F = chi, with B edges on the boundary.
    let edges = Edges::new(mesh);
    let lengths = edges.boundary().map(|e| {
        let [a, b] = edges.ends()[e as usize].map(|v| mesh.vertices()[v as usize]);
        distance(a, b)
    });
    let boundary: f64 = lengths.sum();
    let length = edge_length_for(mesh.area(), faces.div_ceil(2))?;
    let chi = mesh.euler_characteristic(&edges) as f64;
    let n = (faces as f64 + boundary / length) / 2.0 + chi;
    Ok(n.round().max(1.0) as usize)
}
