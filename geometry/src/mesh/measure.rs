//! Areas, normals, volume, quality and scale. Sums run in the order of the faces, so that results
//! do not depend on the number of threads.

use super::vector::{self, add, cross, dot, norm, sub, unit};
use super::{Edges, TriMesh};
use catamaran::base::{Error, Result};

/// A face counts as without area when its area is at most this times the square of its longest
/// edge: the rounding error of a degenerate triangle is not larger.
const FLAT: f64 = 8.0 * f64::EPSILON;

/// Largest coordinate and least size of a mesh for which fourth powers of lengths, as in squared
/// areas, neither overflow nor vanish.
const LARGEST: f64 = 1e70;
const LEAST: f64 = 1e-70;

/// Largest exponent of the factor by which coordinates are scaled before they are measured: larger
/// powers of two, or their inverses, are not normal.
const MOST_EXPONENT: f64 = 1000.0;

/// The size to which [`TriMesh::normalized`] scales.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Normalization {
    /// Total area 1, the centroid of the surface at the origin.
    UnitArea,
    /// Longest side of the bounding box 1, its middle at the origin.
    UnitBox,
}

impl TriMesh {
    /// Returns twice the area of face f times its unit normal.
    fn doubled_normal(&self, face: [u32; 3]) -> [f64; 3] {
        vector::doubled_normal(self.corners_of(face))
    }

    pub(super) fn corners_of(&self, face: [u32; 3]) -> [[f64; 3]; 3] {
        face.map(|v| self.vertices()[v as usize])
    }

    /// Returns the area of each face.
    ///
    /// ```
    /// use catamaran_geometry::mesh::families;
    ///
    /// assert_eq!(families::grid(2, 1)?.face_areas(), [0.25; 4]);
    /// # Ok::<(), catamaran::Error>(())
    /// ```
    pub fn face_areas(&self) -> Vec<f64> {
        self.faces().iter().map(|&f| norm(self.doubled_normal(f)) / 2.0).collect()
    }

    /// Returns the total area.
    pub fn area(&self) -> f64 {
        // `sum` of nothing is -0.
        self.faces().iter().fold(0.0, |sum, &f| sum + norm(self.doubled_normal(f)) / 2.0)
    }

    /// Returns the unit normal of each face; zero for faces without area.
    ///
    /// ```
    /// use catamaran_geometry::mesh::families;
    ///
    /// assert_eq!(families::grid(1, 1)?.face_normals(), [[0.0, 0.0, 1.0]; 2]);
    /// # Ok::<(), catamaran::Error>(())
    /// ```
    pub fn face_normals(&self) -> Vec<[f64; 3]> {
        self.faces().iter().map(|&f| unit(self.doubled_normal(f))).collect()
    }

    /// Returns the unit normal of each vertex: the mean of the normals of its faces weighted by
    /// area; zero where that mean is zero.
    ///
    /// ```
    /// use catamaran_geometry::mesh::families;
    ///
    /// let sphere = families::icosphere(2)?;
    /// let (normal, position) = (sphere.vertex_normals()[7], sphere.vertices()[7]);
    /// let cosine: f64 = (0..3).map(|k| normal[k] * position[k]).sum();
    /// assert!(cosine > 0.99);
    /// # Ok::<(), catamaran::Error>(())
    /// ```
    pub fn vertex_normals(&self) -> Vec<[f64; 3]> {
        let mut sums = vec![[0.0; 3]; self.vertices().len()];
        for &face in self.faces() {
            let normal = self.doubled_normal(face);
            for v in face {
                let sum = &mut sums[v as usize];
                *sum = add(*sum, normal);
            }
        }
        sums.into_iter().map(unit).collect()
    }

    /// Returns the volume inside the mesh, negative when its faces are seen clockwise from outside;
    /// `None` unless the mesh has faces, is closed (every edge has two faces) and oriented (both
    /// run along the edge in opposite directions).
    ///
    /// ```
    /// use catamaran_geometry::mesh::families;
    ///
    /// let volume = families::icosphere(3)?.volume().unwrap();
    /// assert!((volume / (4.0 / 3.0 * std::f64::consts::PI) - 1.0).abs() < 0.02);
    /// assert_eq!(families::grid(2, 2)?.volume(), None);
    /// # Ok::<(), catamaran::Error>(())
    /// ```
    pub fn volume(&self) -> Option<f64> {
        let edges = Edges::new(self);
        let is_closed = !edges.is_empty() && edges.corners().rows().all(|row| row.len() == 2);
        if !is_closed || !self.inconsistent_edges(&edges).is_empty() {
            return None;
        }
        // The sum of cones over the faces, with their tip on the mesh: its digits suffice far away
        // from the origin, too.
        let tip = *self.vertices().first()?;
        let cone = |&face: &[u32; 3]| {
            let [a, b, c] = self.corners_of(face).map(|p| sub(p, tip));
            dot(a, cross(b, c))
        };
        Some(self.faces().iter().map(cone).sum::<f64>() / 6.0)
    }

    /// Returns the quality of each face, `Q(t) = 2 sqrt(3) A / (S l)` with area A, half the
    /// perimeter S and longest edge l (thesis, section 5): 1 for equilateral triangles, 0 for
    /// triangles without area.
    ///
    /// ```
    /// use catamaran_geometry::mesh::families;
    ///
    /// let qualities = families::icosphere(1)?.qualities();
    /// assert!(qualities.iter().all(|&q| q > 0.8 && q <= 1.0 + 1e-12));
    /// # Ok::<(), catamaran::Error>(())
    /// ```
    pub fn qualities(&self) -> Vec<f64> {
        self.faces().iter().map(|&face| quality(self.corners_of(face))).collect()
    }

    /// Returns the faces without area: at most 8 eps times the square of their longest edge, which
    /// is what rounding leaves.
    pub fn faces_without_area(&self) -> Vec<u32> {
        let flat = |&face: &[u32; 3]| is_flat(self.corners_of(face));
        (0..).zip(self.faces()).filter(|(_, face)| flat(face)).map(|(f, _)| f).collect()
    }

    /// Returns the lowest and the highest coordinates of the surface, or of all vertices when there
    /// are no faces; `None` when there are no vertices. A vertex in no face is not of the surface.
    ///
    /// ```
    /// use catamaran_geometry::mesh::families;
    ///
    /// assert_eq!(families::grid(1, 1)?.bounding_box(), Some([[0.0; 3], [1.0, 1.0, 0.0]]));
    /// # Ok::<(), catamaran::Error>(())
    /// ```
    pub fn bounding_box(&self) -> Option<[[f64; 3]; 2]> {
        let corners = self.faces().as_flattened().iter().map(|&v| self.vertices()[v as usize]);
        box_of(corners).or_else(|| box_of(self.vertices().iter().copied()))
    }

    /// Checks that areas of the mesh can be computed: coordinates are at most 1e70, and the longest
    /// side of the bounding box is at least 1e-70, or 0.
    ///
    /// ```
    /// use catamaran_geometry::mesh::TriMesh;
    ///
    /// let far = TriMesh::new(vec![[0.0; 3], [1.0, 0.0, 1e80], [0.0, 1.0, 0.0]], vec![[0, 1, 2]])?;
    /// assert!(far.check_size().unwrap_err().to_string().starts_with("vertex 1: "));
    /// # Ok::<(), catamaran::Error>(())
    /// ```
    ///
    /// # Errors
    /// [`Error::Mesh`] names the first vertex that is too far out, or the mesh if it is too small.
    pub fn check_size(&self) -> Result<()> {
        let is_far = |p: &[f64; 3]| p.iter().any(|x| x.abs() > LARGEST);
        if let Some(v) = self.vertices().iter().position(is_far) {
            let p = self.vertices()[v];
            return Err(Error::Mesh {
                what: format!("position {p:?} is out of range: at most {LARGEST:e} is possible"),
                element: format!("vertex {v}"),
            });
        }
        let longest = self.longest_side();
        if longest > 0.0 && longest < LEAST {
            return Err(Error::Mesh {
                what: format!(
                    "the longest side of its bounding box, {longest:e}, is out of range: at least \
                     {LEAST:e} is needed"
                ),
                element: "mesh".into(),
            });
        }
        Ok(())
    }

    /// Returns the longest side of the bounding box; 0 when there are no vertices.
    fn longest_side(&self) -> f64 {
        let [low, high] = self.bounding_box().unwrap_or_default();
        (0..3).map(|k| high[k] - low[k]).fold(0.0, f64::max)
    }

    /// Returns the mesh moved and uniformly scaled to the size `to`. Coordinates may be of any
    /// size, those that [`TriMesh::check_size`] refuses included.
    ///
    /// ```
    /// use catamaran_geometry::mesh::{Normalization, families};
    ///
    /// let unit = families::torus(20, 10, 2.0, 0.5)?.normalized(Normalization::UnitArea)?;
    /// assert!((unit.area() - 1.0).abs() < 1e-12);
    /// # Ok::<(), catamaran::Error>(())
    /// ```
    ///
    /// # Errors
    /// [`Error::Mesh`] when the area or the box is zero.
    pub fn normalized(&self, to: Normalization) -> Result<TriMesh> {
        // A power of two rounds nothing, and afterwards no area overflows or vanishes.
        let largest = self.vertices().as_flattened().iter().fold(0.0, |a: f64, x| a.max(x.abs()));
        let exponent = largest.log2().floor().clamp(-MOST_EXPONENT, MOST_EXPONENT);
        let factor = 2f64.powi(-(exponent as i32));
        let near = self.vertices().iter().map(|&p| vector::scale(p, factor)).collect();
        TriMesh::new(near, self.faces().to_vec())?.moved_to(to)
    }

    /// Returns the mesh moved and scaled, if its areas can be computed.
    fn moved_to(&self, to: Normalization) -> Result<TriMesh> {
        let (centre, size) = match to {
            Normalization::UnitArea => (self.centroid(), self.area().sqrt()),
            Normalization::UnitBox => {
                let [low, high] = self.bounding_box().unwrap_or_default();
                (std::array::from_fn(|k| low[k] / 2.0 + high[k] / 2.0), self.longest_side())
            }
        };
        if !(size.is_normal() && centre.iter().all(|x: &f64| x.is_finite())) {
            return Err(Error::Mesh {
                what: format!("can't be scaled: its size is {size}"),
                element: "mesh".into(),
            });
        }
        let moved = |&p: &[f64; 3]| sub(p, centre).map(|x| x / size);
        TriMesh::new(self.vertices().iter().map(moved).collect(), self.faces().to_vec())
    }

    /// Returns the centroid of the surface; not finite when it has no area.
    fn centroid(&self) -> [f64; 3] {
        let mut sum = [0.0; 3];
        for &face in self.faces() {
            let weight = norm(self.doubled_normal(face)) / 2.0;
            let [a, b, c] = self.corners_of(face);
            let third = add(add(a, b), c).map(|x| weight * x / 3.0);
            sum = add(sum, third);
        }
        sum.map(|x| x / self.area())
    }
}

/// Returns whether a triangle has no area: at most 8 eps times the square of its longest edge.
pub(super) fn is_flat([a, b, c]: [[f64; 3]; 3]) -> bool {
    let edges = [sub(b, a), sub(c, b), sub(a, c)];
    // Scaled, so that the squares of very small or very large lengths neither vanish nor overflow.
    let size = edges.as_flattened().iter().fold(0.0, |most: f64, x| most.max(x.abs()));
    if size == 0.0 {
        return true;
    }
    let [ab, bc, ca] = edges.map(|edge| edge.map(|x| x / size));
    let longest = norm(ab).max(norm(bc)).max(norm(ca));
    norm(cross(ab, ca)) / 2.0 <= FLAT * longest * longest
}

/// Returns the quality Q of a triangle with these corners, as in [`TriMesh::qualities`].
pub(crate) fn quality([a, b, c]: [[f64; 3]; 3]) -> f64 {
    let edges = [sub(b, a), sub(c, b), sub(a, c)];
    let lengths = edges.map(norm);
    let longest = lengths.into_iter().fold(0.0, f64::max);
    let half = lengths.into_iter().sum::<f64>() / 2.0;
    let area = norm(vector::doubled_normal([a, b, c])) / 2.0;
    if longest > 0.0 { 2.0 * 3f64.sqrt() * area / (half * longest) } else { 0.0 }
}

/// Returns the lowest and the highest coordinates of points, if there are any.
fn box_of(mut points: impl Iterator<Item = [f64; 3]>) -> Option<[[f64; 3]; 2]> {
    let first = points.next()?;
    Some(points.fold([first, first], |[low, high], p| {
        [std::array::from_fn(|k| low[k].min(p[k])), std::array::from_fn(|k| high[k].max(p[k]))]
    }))
}
