//! Masks over the vertices of a mesh, and the parts that they cut out.

use super::{HeatMethod, HeatOptions, Part, TriMesh};
use crate::base::{Error, Par, Result};

impl TriMesh {
    /// The part of the faces whose three vertices are in the mask.
    ///
    /// # Errors
    /// [`Error::Shape`] unless the mask has an entry for each vertex.
    pub fn masked(&self, mask: &[bool]) -> Result<Part> {
        Error::check_shape("mask", (self.vertices().len(), 1), (mask.len(), 1))?;
        let kept = |f: &u32| self.faces()[*f as usize].iter().all(|&v| mask[v as usize]);
        let faces: Vec<u32> = (0..self.faces().len() as u32).filter(kept).collect();
        self.submesh(&faces)
    }

    /// The vertices at most `radius` from `centre` along the surface (heat method), as a mask.
    ///
    /// # Errors
    /// As [`HeatMethod::new`] and [`HeatMethod::distances`].
    pub fn ball(&self, centre: u32, radius: f64, par: Par) -> Result<Vec<bool>> {
        let heat = HeatMethod::new(self, &HeatOptions { par, ..HeatOptions::default() })?;
        Ok(heat.distances(&[centre])?.into_iter().map(|distance| distance <= radius).collect())
    }

    /// The vertices p with `<normal, p> <= offset`, as a mask.
    pub fn half_space(&self, normal: [f64; 3], offset: f64) -> Vec<bool> {
        let below = |p: &[f64; 3]| (0..3).map(|k| normal[k] * p[k]).sum::<f64>() <= offset;
        self.vertices().iter().map(below).collect()
    }
}
