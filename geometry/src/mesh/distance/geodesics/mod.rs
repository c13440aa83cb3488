//! Exact distances and shortest paths over the faces of a mesh, and traced geodesics.

mod glued;
#[cfg(test)]
mod inside_tests;
mod path;
mod places;
#[cfg(test)]
mod tests;
mod trace;
mod trace_end;
#[cfg(test)]
mod trace_tests;
mod windows;

use crate::mesh::{Site, TriMesh};
use catamaran::base::{Error, Result};
use glued::Glued;
pub use path::GeodesicPath;
use places::Spot;
pub use trace::GeodesicTrace;
pub use trace_end::TraceEnd;
use windows::Windows;

/// Exact distances along the surface of a mesh, up to rounding, the shortest paths over its faces,
/// and geodesics that are traced from a point in a direction.
///
/// Sources and ends are vertices, or points inside faces and on edges. A point whose barycentric
/// coordinates are below 1e-12 at a corner is on the edge opposite to it.
///
/// Windows of straight paths propagate from face to face (Mitchell, Mount and Papadimitriou 1987;
/// Chen and Han 1990; Xin and Wang 2009), on the calling thread. It takes O(F^2 log F) at worst.
/// The mesh may have a boundary, several components, edges of more than two faces, and faces that
/// disagree about which side is outside.
///
/// ```
/// use catamaran_geometry::mesh::{Geodesics, Site, families};
///
/// let square = families::grid(3, 3)?;
/// let distances = Geodesics::new(&square)?.distances(&[Site::Vertex(0)])?;
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
    /// ```
    /// use catamaran_geometry::mesh::{Geodesics, Site, SurfacePoint, families};
    ///
    /// let square = families::grid(1, 1)?;
    /// let middle = SurfacePoint { face: 0, weights: [0.5, 0.0, 0.5] };
    /// let distances = Geodesics::new(&square)?.distances(&[Site::Face(middle)])?;
    /// assert!(distances.iter().all(|distance| (distance - 0.5f64.sqrt()).abs() < 1e-15));
    /// # Ok::<(), catamaran::Error>(())
    /// ```
    ///
    /// # Errors
    /// [`Error::Argument`] names a source that does not exist. [`Error::OutOfMemory`] and
    /// [`Error::Cancelled`].
    pub fn distances(&self, sources: &[Site]) -> Result<Vec<f64>> {
        let windows = Windows::propagate(&self.glued, &self.spots("sources", sources)?, None)?;
        let n = self.glued.mesh().vertices().len() as u32;
        Ok((0..n).map(|v| windows.distance(v)).collect())
    }

    /// Returns the shortest path to `end` from the nearest of the sources. A search for the path
    /// ends when it arrives, but keeps 88 bytes for each window.
    ///
    /// ```
    /// use catamaran_geometry::mesh::{Geodesics, Site, families};
    ///
    /// let square = families::grid(1, 1)?;
    /// let path = Geodesics::new(&square)?.path(&[Site::Vertex(1)], Site::Vertex(2))?;
    /// // Across the middle of the diagonal.
    /// let positions = path.positions(&square);
    /// assert_eq!(positions.len(), 3);
    /// assert!(positions[1].iter().zip([0.5, 0.5, 0.0]).all(|(x, y)| (x - y).abs() < 1e-15));
    /// assert!((path.length - 2f64.sqrt()).abs() < 1e-15);
    /// # Ok::<(), catamaran::Error>(())
    /// ```
    ///
    /// # Errors
    /// [`Error::Argument`] names a source or an end that does not exist. [`Error::OutOfMemory`] and
    /// [`Error::Cancelled`].
    pub fn path(&self, sources: &[Site], end: Site) -> Result<GeodesicPath> {
        self.find(&self.spots("sources", sources)?, &Spot::new(&self.glued, "end", end)?)
    }

    /// Returns the shortest path that leads through all of these points in their order, from the
    /// first to the last. There is no path if one of its parts does not exist.
    ///
    /// # Errors
    /// [`Error::Argument`] for fewer than two points, and for one that does not exist.
    /// [`Error::OutOfMemory`] and [`Error::Cancelled`].
    pub fn path_through(&self, through: &[Site]) -> Result<GeodesicPath> {
        let spots = self.spots("through", through)?;
        if spots.len() < 2 {
            let why = format!("at least two points are needed, got {}", spots.len());
            return Err(Error::Argument { what: "through", why });
        }
        let mut all = GeodesicPath { points: Vec::new(), length: 0.0 };
        for pair in spots.windows(2) {
            let part = self.find(&pair[..1], &pair[1])?;
            if !(all.length + part.length).is_finite() {
                return Ok(GeodesicPath { points: Vec::new(), length: f64::INFINITY });
            }
            let known = usize::from(!all.points.is_empty());
            all.points.extend(part.points.into_iter().skip(known));
            all.length += part.length;
        }
        Ok(all)
    }

    /// Traces the geodesic that leaves `start` in a direction, for a length: the exponential map of
    /// the surface.
    ///
    /// It is straight within faces and across edges. Through a vertex inside the surface it goes on
    /// with equal angles on both sides (Polthier and Schmies, Straightest Geodesics on Polyhedral
    /// Surfaces, 1998). It stops where there is no such way: at the boundary and its vertices, at
    /// edges of more than two faces, and at vertices where the surface meets itself.
    ///
    /// The direction, of any length, is projected onto the plane of the face of `start`. At an edge
    /// or a vertex it may point out of the face: then it goes on over the edge, or through the
    /// vertex, as a geodesic over the face does. At a vertex that no face is named for, the
    /// geodesic starts in the direction of the surface that is nearest; equally near ones are those
    /// of the first face.
    ///
    /// ```
    /// use catamaran_geometry::mesh::{Geodesics, Site, TraceEnd, families};
    ///
    /// let square = families::grid(5, 5)?;
    /// let solver = Geodesics::new(&square)?;
    /// let trace = solver.trace(Site::Vertex(0), [3.0, 4.0, 0.0], 1.0)?;
    /// let last = trace.path.points[trace.path.points.len() - 1].position(&square);
    /// assert!(last.iter().zip([0.6, 0.8, 0.0]).all(|(x, y)| (x - y).abs() < 1e-14));
    /// let trace = solver.trace(Site::Vertex(0), [3.0, 4.0, 0.0], 7.0)?;
    /// assert!(trace.end == TraceEnd::Boundary && (trace.path.length - 1.25).abs() < 1e-14);
    /// # Ok::<(), catamaran::Error>(())
    /// ```
    ///
    /// # Errors
    /// [`Error::Argument`] names a start that does not exist or is in no face, a direction that is
    /// not finite, or has no part in the surface, and a length that is negative or not finite.
    /// [`Error::Mesh`] names the face of the start if it has no area. [`Error::OutOfMemory`] and
    /// [`Error::Cancelled`].
    pub fn trace(&self, start: Site, direction: [f64; 3], length: f64) -> Result<GeodesicTrace> {
        trace::trace(&self.glued, start, direction, length)
    }

    fn spots(&self, what: &'static str, sites: &[Site]) -> Result<Vec<Spot>> {
        sites.iter().map(|&site| Spot::new(&self.glued, what, site)).collect()
    }

    fn find(&self, sources: &[Spot], end: &Spot) -> Result<GeodesicPath> {
        let windows = Windows::propagate(&self.glued, sources, Some(end))?;
        let none = GeodesicPath { points: Vec::new(), length: f64::INFINITY };
        Ok(windows.target().map_or(none, |end| path::path(&self.glued, &windows, end)))
    }
}
