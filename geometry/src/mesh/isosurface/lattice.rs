//! Regular lattices of points in rows, columns and layers.

use catamaran::base::{Error, Result};

/// A regular lattice of points in rows, columns and layers. Point (i, j, k) is `origin` + (i
/// `step[0]`, j `step[1]`, k `step[2]`) and has the index i + `counts[0]` (j + `counts[1]` k). Each
/// point stands for the box of one step around it.
///
/// ```
/// use catamaran_geometry::mesh::Lattice;
///
/// let lattice = Lattice { counts: [3, 2, 2], origin: [0.0; 3], step: [0.5, 1.0, 1.0] };
/// assert_eq!(lattice.points()[2], [1.0, 0.0, 0.0]);
/// assert_eq!(lattice.points().len(), 12);
/// ```
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Lattice {
    /// Points along x, y and z.
    pub counts: [usize; 3],
    /// Point (0, 0, 0).
    pub origin: [f64; 3],
    /// Distance from a point to the next one along x, y and z; positive.
    pub step: [f64; 3],
}

/// The treatment of a region at the border of its lattice.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum Rim {
    /// The region ends half a step outside of the outermost points, where the boxes of these points
    /// end: surfaces are closed.
    #[default]
    Closed,
    /// The surface is cut at the outermost points and has a boundary there.
    Open,
}

impl Lattice {
    /// Returns all points, in the order of their indices.
    pub fn points(&self) -> Vec<[f64; 3]> {
        let [nx, ny, nz] = self.counts;
        let at = |i: usize, j: usize, k: usize| self.at([i as f64, j as f64, k as f64]);
        let rows = (0..nz).flat_map(|k| (0..ny).map(move |j| (j, k)));
        rows.flat_map(|(j, k)| (0..nx).map(move |i| at(i, j, k))).collect()
    }

    /// Returns the point at these coordinates, in steps from the origin.
    pub(super) fn at(&self, place: [f64; 3]) -> [f64; 3] {
        std::array::from_fn(|c| self.origin[c] + place[c] * self.step[c])
    }

    pub(super) fn check(&self, given: usize, what: &'static str) -> Result<()> {
        let refused = |why: String| Err(Error::Argument { what: "lattice", why });
        if !self.step.iter().all(|s| s.is_finite() && *s > 0.0) {
            return refused(format!("steps must be positive and finite, are {:?}", self.step));
        }
        if !self.origin.iter().all(|x| x.is_finite()) {
            return refused(format!("the origin must be finite, is {:?}", self.origin));
        }
        let [nx, ny, nz] = self.counts;
        match nx.checked_mul(ny).and_then(|n| n.checked_mul(nz)) {
            Some(points) => Error::check_shape(what, (points, 1), (given, 1)),
            None => refused(format!("{:?} points exceed the memory", self.counts)),
        }
    }
}
