//! Regions of a mesh: sets of its faces, such as those that curves enclose, and operations on them.

mod enclosed;
#[cfg(test)]
mod tests;

pub use enclosed::Side;

use crate::mesh::{Edges, Part, TriMesh};
use catamaran::base::{Error, Result};

/// A set of faces of a mesh.
///
/// ```
/// use catamaran_geometry::curve::Region;
///
/// let (one, two) = (Region::new(vec![true, true, false]), Region::new(vec![false, true, false]));
/// assert_eq!(one.difference(&two)?.faces(), [0]);
/// assert_eq!(one.union(&two)?.complement().faces(), [2]);
/// # Ok::<(), catamaran::Error>(())
/// ```
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Region {
    inside: Vec<bool>,
}

impl Region {
    /// Creates the region of the faces whose entry is true.
    pub fn new(inside: Vec<bool>) -> Self {
        Self { inside }
    }

    /// Returns for each face of the mesh whether it is inside.
    pub fn mask(&self) -> &[bool] {
        &self.inside
    }

    /// Returns the faces inside, ascending.
    pub fn faces(&self) -> Vec<u32> {
        (0..).zip(&self.inside).filter(|(_, inside)| **inside).map(|(f, _)| f).collect()
    }

    /// Returns whether no face is inside.
    pub fn is_empty(&self) -> bool {
        !self.inside.contains(&true)
    }

    /// Returns the union of two regions: the faces in one of them or both.
    ///
    /// # Errors
    /// [`Error::Shape`] for regions of meshes with different numbers of faces, for this operation
    /// and the following ones.
    pub fn union(&self, other: &Self) -> Result<Self> {
        self.combined(other, |a, b| a | b)
    }

    /// Returns the intersection of two regions: the faces in both.
    ///
    /// # Errors
    /// As [`Region::union`].
    pub fn intersection(&self, other: &Self) -> Result<Self> {
        self.combined(other, |a, b| a & b)
    }

    /// Returns the difference of two regions: the faces of this region that are not in the other.
    ///
    /// # Errors
    /// As [`Region::union`].
    pub fn difference(&self, other: &Self) -> Result<Self> {
        self.combined(other, |a, b| a & !b)
    }

    /// Returns the symmetric difference of two regions: the faces in one of them, but not in both.
    ///
    /// ```
    /// use catamaran_geometry::curve::Region;
    ///
    /// let one = Region::new(vec![true, true, false]);
    /// let two = Region::new(vec![false, true, true]);
    /// assert_eq!(one.symmetric_difference(&two)?.faces(), [0, 2]);
    /// assert_eq!(one.intersection(&two)?.faces(), [1]);
    /// # Ok::<(), catamaran::Error>(())
    /// ```
    ///
    /// # Errors
    /// As [`Region::union`].
    pub fn symmetric_difference(&self, other: &Self) -> Result<Self> {
        self.combined(other, |a, b| a ^ b)
    }

    /// Returns the faces that are not in the region.
    #[must_use]
    pub fn complement(&self) -> Self {
        Self { inside: self.inside.iter().map(|inside| !inside).collect() }
    }

    fn combined(&self, other: &Self, of: impl Fn(bool, bool) -> bool) -> Result<Self> {
        Error::check_shape("region", (self.inside.len(), 1), (other.inside.len(), 1))?;
        let both = self.inside.iter().zip(&other.inside);
        Ok(Self { inside: both.map(|(&a, &b)| of(a, b)).collect() })
    }

    /// Returns the area of the faces inside.
    ///
    /// ```
    /// use catamaran_geometry::{curve::Region, mesh::families};
    ///
    /// let square = families::grid(1, 1)?;
    /// assert_eq!(Region::new(vec![true, false]).area(&square)?, 0.5);
    /// # Ok::<(), catamaran::Error>(())
    /// ```
    ///
    /// # Errors
    /// [`Error::Shape`] for a mesh with another number of faces, for this operation and the
    /// following ones.
    pub fn area(&self, mesh: &TriMesh) -> Result<f64> {
        self.check(mesh)?;
        let areas = mesh.face_areas().into_iter().zip(&self.inside);
        Ok(areas.filter(|(_, inside)| **inside).fold(0.0, |sum, (area, _)| sum + area))
    }

    /// Returns the edges with faces both inside and outside, ascending.
    ///
    /// ```
    /// use catamaran_geometry::{curve::Region, mesh::families};
    ///
    /// let square = families::grid(1, 1)?;
    /// assert_eq!(Region::new(vec![true, false]).boundary(&square)?.len(), 1);
    /// # Ok::<(), catamaran::Error>(())
    /// ```
    ///
    /// # Errors
    /// As [`Region::area`].
    pub fn boundary(&self, mesh: &TriMesh) -> Result<Vec<[u32; 2]>> {
        self.check(mesh)?;
        let edges = Edges::new(mesh);
        let mixed = |e: usize| {
            let mut sides = edges.faces(e).map(|f| self.inside[f as usize]);
            let first = sides.next();
            sides.any(|side| Some(side) != first)
        };
        Ok((0..edges.len()).filter(|&e| mixed(e)).map(|e| edges.ends()[e]).collect())
    }

    /// Returns the faces inside as a mesh, with the original indices of its vertices and faces.
    ///
    /// ```
    /// use catamaran_geometry::{curve::Region, mesh::families};
    ///
    /// let part = Region::new(vec![false, true]).part(&families::grid(1, 1)?)?;
    /// assert_eq!((part.mesh.vertices().len(), part.faces), (3, vec![1]));
    /// # Ok::<(), catamaran::Error>(())
    /// ```
    ///
    /// # Errors
    /// As [`Region::area`].
    pub fn part(&self, mesh: &TriMesh) -> Result<Part> {
        self.check(mesh)?;
        mesh.submesh(&self.faces())
    }

    fn check(&self, mesh: &TriMesh) -> Result<()> {
        Error::check_shape("region", (mesh.faces().len(), 1), (self.inside.len(), 1))
    }
}
