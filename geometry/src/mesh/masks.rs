//! Masks of vertices, and the parts of a mesh that they select.

use super::{HeatMethod, HeatOptions, Part, TriMesh};
use catamaran::base::{Error, Par, Result};

impl TriMesh {
    /// Returns the part of the faces whose three vertices are in the mask.
    ///
    /// ```
    /// use catamaran_geometry::mesh::families;
    ///
    /// let square = families::grid(2, 2)?;
    /// let left = square.masked(&square.half_space([1.0, 0.0, 0.0], 0.5))?;
    /// assert_eq!(left.faces.len(), 4);
    /// # Ok::<(), catamaran::Error>(())
    /// ```
    ///
    /// # Errors
    /// [`Error::Shape`] unless the mask has an entry for each vertex.
    pub fn masked(&self, mask: &[bool]) -> Result<Part> {
        Error::check_shape("mask", (self.vertices().len(), 1), (mask.len(), 1))?;
        let kept = |f: &u32| self.faces()[*f as usize].iter().all(|&v| mask[v as usize]);
        let faces: Vec<u32> = (0..self.faces().len() as u32).filter(kept).collect();
        self.submesh(&faces)
    }

    /// Returns a mask of the vertices at most `radius` from the vertex `centre` along the surface,
    /// by the heat method.
    ///
    /// ```
    /// use catamaran::Par;
    /// use catamaran_geometry::mesh::families;
    ///
    /// let sphere = families::icosphere(2)?;
    /// let cap = sphere.ball(0, 0.5, Par::all())?;
    /// assert!(cap[0] && cap.iter().filter(|&&inside| inside).count() < 20);
    /// # Ok::<(), catamaran::Error>(())
    /// ```
    ///
    /// # Errors
    /// As [`HeatMethod::new`] and [`HeatMethod::distances`].
    pub fn ball(&self, centre: u32, radius: f64, par: Par) -> Result<Vec<bool>> {
        let heat = HeatMethod::new(self, &HeatOptions { par, ..HeatOptions::default() })?;
        Ok(heat.distances(&[centre])?.into_iter().map(|distance| distance <= radius).collect())
    }

    /// Returns a mask of the vertices p with `<normal, p> <= offset`. The example of
    /// [`TriMesh::masked`] shows its use.
    pub fn half_space(&self, normal: [f64; 3], offset: f64) -> Vec<bool> {
        let below = |p: &[f64; 3]| (0..3).map(|k| normal[k] * p[k]).sum::<f64>() <= offset;
        self.vertices().iter().map(below).collect()
    }
}
