mod glued;
mod path;
#[cfg(test)]
mod tests;
mod windows;

use crate::mesh::TriMesh;
use catamaran::base::{Error, Result};
use glued::Glued;
pub use path::GeodesicPath;
use windows::Windows;

/// Exact distances along the surface of a mesh, up to rounding, and the shortest paths over its
/// faces.
///
/// Windows of straight paths propagate from face to face (Mitchell, Mount and Papadimitriou 1987;
/// Chen and Han 1990; Xin and Wang 2009), on the calling thread. It takes O(F^2 log F) at worst.
/// The mesh may have a boundary, several components, edges of more than two faces, and faces that
/// disagree about which side is outside.
///
/// ```
/// use catamaran_geometry::mesh::{Geodesics, families};
///
/// let square = families::grid(3, 3)?;
/// let distances = Geodesics::new(&square)?.distances(&[0])?;
/// assert!((distances[6] - 5f64.sqrt() / 3.0).abs() < 1e-14); // 1 to the right, 2 up
/// # Ok::<(), catamaran::Error>(())
/// ```
#[derive(Debug)]
pub struct Geodesics<'m> {
    glued: Glued<'m>,
}

impl<'m> Geodesics<'m> {
    /// Prepares a mesh, in O(V + F).
    ///
    /// # Errors
    /// [`Error::Mesh`] names an edge without length (shorter than 1e-75); those of
    /// [`TriMesh::check_size`].
    pub fn new(mesh: &'m TriMesh) -> Result<Self> {
        Ok(Self { glued: Glued::new(mesh)? })
    }

    /// Returns the distance of every vertex from the nearest of the sources: 0 at sources, infinite
    /// in components without a source.
    ///
    /// # Errors
    /// [`Error::Argument`] names a source that does not exist. [`Error::OutOfMemory`] and
    /// [`Error::Cancelled`].
    pub fn distances(&self, sources: &[u32]) -> Result<Vec<f64>> {
        let windows = Windows::propagate(&self.glued, sources, None)?;
        let n = self.glued.mesh().vertices().len() as u32;
        Ok((0..n).map(|v| windows.distance(v)).collect())
    }

    /// Returns the shortest path to the vertex `to` from the nearest of the sources. A search for
    /// the path ends when it arrives, but keeps 88 bytes for each window.
    ///
    /// ```
    /// use catamaran_geometry::mesh::{Geodesics, families};
    ///
    /// let square = families::grid(1, 1)?;
    /// let path = Geodesics::new(&square)?.path(&[1], 2)?;
    /// // Across the middle of the diagonal.
    /// let positions = path.positions(&square);
    /// assert_eq!(positions.len(), 3);
    /// assert!(positions[1].iter().zip([0.5, 0.5, 0.0]).all(|(x, y)| (x - y).abs() < 1e-15));
    /// assert!((path.length - 2f64.sqrt()).abs() < 1e-15);
    /// # Ok::<(), catamaran::Error>(())
    /// ```
    ///
    /// # Errors
    /// [`Error::Argument`] names a vertex that does not exist. [`Error::OutOfMemory`] and
    /// [`Error::Cancelled`].
    pub fn path(&self, sources: &[u32], to: u32) -> Result<GeodesicPath> {
        let n = self.glued.mesh().vertices().len();
        if to as usize >= n {
            let why = format!("vertex {to} is out of range: {n} vertices, numbered from 0");
            return Err(Error::Argument { what: "targets", why });
        }
        let windows = Windows::propagate(&self.glued, sources, Some(to))?;
        Ok(path::path(&self.glued, &windows, to))
    }

    /// Returns the shortest path to the first of the vertices `through` from the nearest of the
    /// sources, and on to the other vertices, in their order. There is no path if one of its parts
    /// does not exist.
    ///
    /// # Errors
    /// As [`Geodesics::path`]; [`Error::Argument`] without vertices.
    pub fn path_through(&self, sources: &[u32], through: &[u32]) -> Result<GeodesicPath> {
        let Some((&first, others)) = through.split_first() else {
            return Err(Error::Argument { what: "targets", why: "there are none".into() });
        };
        let mut all = self.path(sources, first)?;
        let mut from = first;
        for &to in others {
            let part = self.path(&[from], to)?;
            if !(all.length + part.length).is_finite() {
                return Ok(GeodesicPath { points: Vec::new(), length: f64::INFINITY });
            }
            all.points.extend(part.points.into_iter().skip(1));
            all.length += part.length;
            from = to;
        }
        Ok(all)
    }
}
