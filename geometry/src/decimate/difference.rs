//! Distances between two meshes (thesis, equation 5.8).

use std::borrow::Cow;

use rstar::RTree;

use super::bound::bound;
use crate::mesh::vector::{Vector, distance, middle, sub};
use crate::mesh::{TriMesh, Triangles, squares};
use catamaran::base::{Error, Par, Result};

/// Distances between a mesh and its decimation. Vertices without a face do not count.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Difference {
    /// The largest distance of a vertex of either mesh from the surface of the other, in units of
    /// length.
    pub hausdorff: f64,
    /// An upper bound of the distance of any point of either surface from the other surface, in
    /// units of length: the Hausdorff distance of the surfaces, up to rounding and at most 1 %
    /// more. (Only for surfaces of very many different parts it may be farther above.)
    pub hausdorff_bound: f64,
    /// The mean square of the distances of the vertices of one mesh from the surface of the other,
    /// plus the same in the other direction, in units of length squared.
    pub chamfer: f64,
    /// H of equation 5.8 as printed: the largest distance of a vertex of the first mesh from the
    /// vertices of the second.
    pub printed_hausdorff: f64,
    /// C of equation 5.8 as printed. Its first sum is over the second mesh only, and therefore 0,
    /// so that C is the mean square of the distances of the vertices of the second mesh from those
    /// of the first.
    pub printed_chamfer: f64,
}

impl Difference {
    /// Measures the distances between `first` and `second` in O(V log F).
    ///
    /// ```
    /// use catamaran::Par;
    /// use catamaran_geometry::{decimate::Difference, mesh::families};
    ///
    /// let mesh = families::icosphere(2)?;
    /// let found = Difference::between(&mesh, &mesh, Par::Seq)?;
    /// assert_eq!((found.hausdorff, found.chamfer), (0.0, 0.0));
    /// assert!(found.hausdorff_bound < 1e-15);
    /// # Ok::<(), catamaran::Error>(())
    /// ```
    ///
    /// # Errors
    /// [`Error::Mesh`] when one of them has no face, and that of [`TriMesh::check_size`];
    /// [`Error::Cancelled`].
    pub fn between(first: &TriMesh, second: &TriMesh, par: Par) -> Result<Self> {
        let first = Measured::new(first)?;
        let second = first.beside(second)?;
        let squared = first.squares(&second, par);
        let hausdorff = largest(&squared);
        let points = |mesh: &Measured<'_>| RTree::bulk_load(mesh.points());
        Ok(Self {
            hausdorff,
            hausdorff_bound: first.bound(&second, &squared, par)?,
            chamfer: squared.iter().zip([&first, &second]).map(|(all, of)| of.mean(all)).sum(),
            printed_hausdorff: most(&squares(&first.points(), &points(&second), par)).sqrt(),
            printed_chamfer: mean(&squares(&second.points(), &points(&first), par)),
        })
    }
}

/// Distance of a box from the origin, relative to its diagonal, from which on positions lose digits
/// that distances need.
const FAR: f64 = 1024.0;

/// A mesh of which distances are measured.
pub(super) struct Measured<'m> {
    /// The mesh, moved to the origin if it is far away.
    mesh: Cow<'m, TriMesh>,
    /// The point that is moved to the origin.
    origin: Vector,
    faces: Triangles,
    /// Whether each vertex has a face.
    used: Vec<bool>,
}

impl<'m> Measured<'m> {
    /// Prepares a mesh.
    ///
    /// # Errors
    /// [`Error::Mesh`] when it has no face, and that of [`TriMesh::check_size`].
    pub fn new(mesh: &'m TriMesh) -> Result<Self> {
        let [low, high] = mesh.bounding_box().unwrap_or_default();
        let (centre, far) = (middle(low, high), FAR * distance(low, high));
        // Subtracting a coordinate of the same size is exact.
        Self::moved(mesh, centre.map(|x| if x.abs() > far { x } else { 0.0 }))
    }

    /// Prepares another mesh, moved as this one.
    ///
    /// # Errors
    /// As [`Measured::new`].
    pub fn beside<'n>(&self, mesh: &'n TriMesh) -> Result<Measured<'n>> {
        Measured::moved(mesh, self.origin)
    }

    fn moved(mesh: &'m TriMesh, origin: Vector) -> Result<Self> {
        mesh.check_size()?;
        if mesh.faces().is_empty() {
            return Err(Error::Mesh { what: "has no face".into(), element: "mesh".into() });
        }
        let mesh = if origin == [0.0; 3] {
            Cow::Borrowed(mesh)
        } else {
            let vertices = mesh.vertices().iter().map(|&p| sub(p, origin)).collect();
            Cow::Owned(TriMesh::new(vertices, mesh.faces().to_vec())?)
        };
        Ok(Self { faces: Triangles::of(&mesh), used: mesh.referenced(), mesh, origin })
    }

    /// Returns the squares of the distances of the vertices of either mesh from the surface of the
    /// other one; 0 for those without a face.
    pub fn squares(&self, other: &Self, par: Par) -> [Vec<f64>; 2] {
        [(self, other), (other, self)].map(|(of, from)| {
            let mut squares = from.faces.squares(of.mesh.vertices(), par);
            squares.iter_mut().zip(&of.used).filter(|x| !x.1).for_each(|(square, _)| *square = 0.0);
            squares
        })
    }

    /// Returns an upper bound of the Hausdorff distance from these [`Measured::squares`].
    ///
    /// # Errors
    /// [`Error::Cancelled`].
    pub fn bound(&self, other: &Self, [out, back]: &[Vec<f64>; 2], par: Par) -> Result<f64> {
        let known = most(out).max(most(back)).sqrt();
        let [of_self, known] = bound(&self.mesh, &other.faces, out, known, par)?;
        let [of_other, _] = bound(&other.mesh, &self.faces, back, known, par)?;
        Ok(of_self.max(of_other))
    }

    fn points(&self) -> Vec<Vector> {
        let used = self.mesh.vertices().iter().zip(&self.used).filter(|x| *x.1);
        used.map(|(&p, _)| p).collect()
    }

    fn mean(&self, squares: &[f64]) -> f64 {
        let count = self.used.iter().filter(|&&used| used).count();
        squares.iter().sum::<f64>() / count.max(1) as f64
    }
}

/// Returns the largest distance of a vertex, from [`Measured::squares`].
pub(super) fn largest([out, back]: &[Vec<f64>; 2]) -> f64 {
    most(out).max(most(back)).sqrt()
}

fn most(squares: &[f64]) -> f64 {
    squares.iter().copied().fold(0.0, f64::max)
}

fn mean(squares: &[f64]) -> f64 {
    squares.iter().sum::<f64>() / squares.len().max(1) as f64
}
