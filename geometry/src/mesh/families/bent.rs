//! Bending, which changes lengths on thin shapes little, for near-isometric copies.

use super::super::TriMesh;
use catamaran::base::{Error, Result, positive};

/// A bend of space. Space behind `at` stays; a slab of width `length` beyond `at` is bent around a
/// circle, and space behind the slab is turned with it. The middle plane through `at` keeps its
/// lengths; at a height h in direction `towards`, lengths change by the factor 1 - h angle /
/// length.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Bend {
    /// Where the bend begins.
    pub at: [f64; 3],
    /// The direction that is bent, of length 1.
    pub along: [f64; 3],
    /// The direction towards which space is bent, of length 1, orthogonal to `along`.
    pub towards: [f64; 3],
    /// The angle, in radians.
    pub angle: f64,
    /// The width of the slab, above 0.
    pub length: f64,
}

impl Bend {
    /// Returns the position to which the bend moves the point p.
    pub fn apply(&self, p: [f64; 3]) -> [f64; 3] {
        let dot = |a: [f64; 3]| (0..3).map(|k| a[k] * (p[k] - self.at[k])).sum::<f64>();
        let (s, h) = (dot(self.along), dot(self.towards));
        if s <= 0.0 || self.angle == 0.0 {
            return p;
        }
        let radius = self.length / self.angle;
        let (sin, cos) = (s.min(self.length) / radius).sin_cos();
        let beyond = (s - self.length).max(0.0);
        let s_new = (radius - h) * sin + beyond * cos;
        let h_new = radius - (radius - h) * cos + beyond * sin;
        std::array::from_fn(|k| p[k] + (s_new - s) * self.along[k] + (h_new - h) * self.towards[k])
    }

    fn check(&self) -> Result<()> {
        positive("length", self.length)?;
        let dot = |a: [f64; 3], b: [f64; 3]| (0..3).map(|k| a[k] * b[k]).sum::<f64>();
        let near = |value: f64, wanted: f64| (value - wanted).abs() <= 1e-9;
        let units =
            near(dot(self.along, self.along), 1.0) && near(dot(self.towards, self.towards), 1.0);
        if !units || !near(dot(self.along, self.towards), 0.0) || !self.angle.is_finite() {
            return Err(Error::Argument {
                what: "bend",
                why: format!("must have orthogonal unit vectors and a finite angle, is {self:?}"),
            });
        }
        Ok(())
    }
}

/// Returns the mesh with every vertex moved by the bend and with the same faces.
///
/// ```
/// use catamaran_geometry::mesh::families::{Bend, bent, grid};
///
/// let bend = Bend {
///     at: [0.5, 0.0, 0.0],
///     along: [1.0, 0.0, 0.0],
///     towards: [0.0, 0.0, 1.0],
///     angle: std::f64::consts::FRAC_PI_2,
///     length: 0.5,
/// };
/// let mesh = bent(&grid(64, 2)?, &bend)?;
/// assert!((mesh.area() - 1.0).abs() < 1e-3);
/// // A quarter of a circle of length 1/2 rises by its radius.
/// let top = mesh.bounding_box().unwrap()[1][2];
/// assert!((top - 1.0 / std::f64::consts::PI).abs() < 1e-12);
/// # Ok::<(), catamaran::Error>(())
/// ```
///
/// # Errors
/// [`Error::Argument`] unless the directions are orthogonal and of length 1 (to 1e-9), the length
/// is positive and all numbers are finite.
pub fn bent(mesh: &TriMesh, bend: &Bend) -> Result<TriMesh> {
    bend.check()?;
    let vertices = mesh.vertices().iter().map(|&p| bend.apply(p)).collect();
    TriMesh::new(vertices, mesh.faces().to_vec())
}
