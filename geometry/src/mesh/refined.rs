//! Refined meshes, and where their vertices and faces come from.

use super::TriMesh;
use catamaran::base::{Error, Result};

/// Position of a vertex of a refined mesh on the coarser mesh: at a vertex, on an edge or on a
/// face.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Origin {
    /// Vertices of the coarser mesh, all of one face; vertices of weight 0 are arbitrary.
    pub vertices: [u32; 3],
    /// The weights of the vertices; they sum to 1 up to rounding.
    pub weights: [f64; 3],
}

impl Origin {
    /// Creates the origin of a vertex that is at vertex `v` of the mesh.
    pub fn vertex(v: u32) -> Self {
        Self { vertices: [v; 3], weights: [1.0, 0.0, 0.0] }
    }

    /// Returns the weighted mean of positions on one face.
    pub(crate) fn between(parts: &[(Self, f64)]) -> Self {
        let mut sum = Self { vertices: [u32::MAX; 3], weights: [0.0; 3] };
        let mut count = 0;
        for (origin, share) in parts {
            for (&v, &weight) in origin.vertices.iter().zip(&origin.weights) {
                let weight = weight * share;
                if weight == 0.0 {
                    continue;
                }
                let known = sum.vertices[..count].iter().position(|&u| u == v);
                let at = known.unwrap_or(count);
                // A face has three vertices.
                if at == 3 {
                    continue;
                }
                count = count.max(at + 1);
                sum.vertices[at] = v;
                sum.weights[at] += weight;
            }
        }
        for at in count..3 {
            sum.vertices[at] = sum.vertices[0];
        }
        sum
    }

    /// Returns the weight of a vertex.
    pub(crate) fn share(&self, vertex: u32) -> f64 {
        let all = self.vertices.iter().zip(self.weights);
        all.filter(|(v, _)| **v == vertex).map(|(_, weight)| weight).sum()
    }
}

/// A mesh that covers the same surface as a coarser mesh with more vertices and faces. Its first
/// vertices are those of the coarser mesh.
///
/// ```
/// use catamaran_geometry::mesh::{Refined, families};
///
/// let refined = Refined::new(families::grid(1, 1)?);
/// assert_eq!(refined.faces, [0, 1]);
/// assert_eq!(refined.shares(&[true, false])?, [1.0, 0.0]);
/// # Ok::<(), catamaran::Error>(())
/// ```
#[derive(Debug, Clone, PartialEq)]
pub struct Refined {
    /// The finer mesh.
    pub mesh: TriMesh,
    /// For each face, the face of the coarser mesh that contains it.
    pub faces: Vec<u32>,
    /// For each vertex, its position on the coarser mesh.
    pub vertices: Vec<Origin>,
}

impl Refined {
    /// Creates the trivial refinement, which is the mesh itself.
    pub fn new(mesh: TriMesh) -> Self {
        let faces = (0..mesh.faces().len() as u32).collect();
        let vertices = (0..mesh.vertices().len() as u32).map(Origin::vertex).collect();
        Self { mesh, faces, vertices }
    }

    /// Returns the composition of two refinements: `finer` refines the mesh of `self`, and the
    /// result refines the mesh that `self` refines.
    ///
    /// # Panics
    /// When `finer` refines a mesh of more vertices or faces.
    #[must_use]
    pub fn then(&self, finer: Refined) -> Self {
        let faces = finer.faces.iter().map(|&f| self.faces[f as usize]).collect();
        let on_mesh = |origin: &Origin| {
            let parts = std::array::from_fn::<_, 3, _>(|i| {
                (self.vertices[origin.vertices[i] as usize], origin.weights[i])
            });
            Origin::between(&parts)
        };
        let vertices = finer.vertices.iter().map(on_mesh).collect();
        Self { mesh: finer.mesh, faces, vertices }
    }

    /// Returns for each face of the coarser mesh the share of its area that pieces in the mask
    /// cover: exactly 0 or 1 where none or all of its pieces are. For faces without area, returns
    /// the share of the number of pieces.
    ///
    /// # Errors
    /// [`Error::Shape`] unless the mask has an entry for each face of the finer mesh.
    pub fn shares(&self, mask: &[bool]) -> Result<Vec<f64>> {
        Error::check_shape("mask", (self.faces.len(), 1), (mask.len(), 1))?;
        let count = self.faces.iter().map(|&f| f as usize + 1).max().unwrap_or(0);
        // Area and number of all pieces and of those in the mask.
        let mut sums = vec![[0.0; 4]; count];
        for ((&face, area), &within) in self.faces.iter().zip(self.mesh.face_areas()).zip(mask) {
            let sum = &mut sums[face as usize];
            sum[0] += area;
            sum[1] += 1.0;
            if within {
                sum[2] += area;
                sum[3] += 1.0;
            }
        }
        let share = |[area, all, own_area, own]: [f64; 4]| match own {
            0.0 => 0.0,
            _ if own == all => 1.0,
            _ if area > 0.0 => own_area / area,
            _ => own / all,
        };
        Ok(sums.into_iter().map(share).collect())
    }
}
