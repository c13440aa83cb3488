use super::super::TriMesh;
use super::super::measure::is_flat;
use super::super::vector::{cross, dot, norm, sub};
use catamaran::base::{Error, Par, Result};

/// Number of faces that a thread takes at a time.
const BLOCK: usize = 1 << 14;

/// Operations for an element.
pub(super) const OPERATIONS: f64 = 50.0;

/// The contribution of a triangle to the matrices. Edge k joins corners k and k + 1 (mod 3) and is
/// opposite to corner k + 2.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Element {
    /// Half the cotangent of the angle opposite to each edge.
    pub weights: [f64; 3],
    /// The area of the triangle.
    pub area: f64,
}

impl Element {
    /// Computes the element of a triangle from its corners; `None` when it has no area.
    fn of_positions(p: [[f64; 3]; 3]) -> Option<Self> {
        if is_flat(p) {
            return None;
        }
        let edges = [sub(p[1], p[0]), sub(p[2], p[1]), sub(p[0], p[2])];
        let double = norm(cross(edges[0], edges[1]));
        // Edge k + 1 ends at corner k + 2, and edge k + 2 starts there.
        let weights =
            std::array::from_fn(|k| -dot(edges[(k + 1) % 3], edges[(k + 2) % 3]) / (2.0 * double));
        Some(Self { weights, area: 0.5 * double })
    }

    /// Computes the element of a triangle from the lengths of its edges.
    pub fn of_lengths(l: [f64; 3]) -> Self {
        let area = area(l);
        let square = l.map(|x| x * x);
        let weights = std::array::from_fn(|k| {
            (square[(k + 1) % 3] + square[(k + 2) % 3] - square[k]) / (8.0 * area)
        });
        Self { weights, area }
    }

    /// Returns whether the area is positive and all numbers are finite.
    pub fn is_sound(&self) -> bool {
        self.area > 0.0 && self.area.is_finite() && self.weights.iter().all(|w| w.is_finite())
    }

    /// Returns the element scaled by a share.
    pub fn scaled(self, share: f64) -> Self {
        Self { weights: self.weights.map(|w| w * share), area: self.area * share }
    }

    /// Returns the area of the part of the triangle that is nearest to corner k; in obtuse
    /// triangles, the share that Meyer et al. define instead.
    pub fn mixed_voronoi(&self, k: usize) -> f64 {
        // Edge k + 1 is opposite to corner k.
        let obtuse = |k: usize| self.weights[(k + 1) % 3] < 0.0;
        if obtuse(k) {
            return self.area / 2.0;
        }
        if obtuse((k + 1) % 3) || obtuse((k + 2) % 3) {
            return self.area / 4.0;
        }
        let w = self.weights;
        // The square of an edge is twice the area times the sum of the cotangents at its ends. The
        // pairwise products of the cotangents of a triangle sum to 1; the division by `all` is
        // needed for an element that is a share of a triangle.
        let share = |e: usize| (w[(e + 1) % 3] + w[(e + 2) % 3]) * w[e];
        let all = 4.0 * (w[0] * w[1] + w[1] * w[2] + w[2] * w[0]);
        self.area * (share(k) + share((k + 2) % 3)) / all
    }
}

/// Returns the area of a triangle with these edges: Kahan, Miscalculating Area and Angles of a
/// Needle-like Triangle (2014). NaN if there is no such triangle.
pub(super) fn area(mut l: [f64; 3]) -> f64 {
    l.sort_unstable_by(|x, y| y.total_cmp(x));
    let [a, b, c] = l;
    0.25 * ((a + (b + c)) * (c - (a - b)) * (c + (a - b)) * (a + (b - c))).sqrt()
}

/// Computes the elements of the faces of a mesh.
pub(crate) fn of_mesh(mesh: &TriMesh, par: Par) -> Result<Vec<Element>> {
    let (vertices, faces) = (mesh.vertices(), mesh.faces());
    let operations = OPERATIONS * BLOCK as f64;
    let blocks = par.map_blocks_asking(faces.len(), BLOCK, operations, |range| {
        range
            .map(|f| {
                let found = Element::of_positions(faces[f].map(|v| vertices[v as usize]));
                found.filter(Element::is_sound).ok_or_else(|| {
                    let refused = no_area(f, "; the tufted Laplacian allows this");
                    mesh.check_size().err().unwrap_or(refused)
                })
            })
            .collect::<Result<Vec<_>>>()
    })?;
    let mut elements = Vec::with_capacity(faces.len());
    for block in blocks {
        elements.extend(block?);
    }
    Ok(elements)
}

/// Returns the error for a face that has no area.
pub(super) fn no_area(face: usize, advice: &str) -> Error {
    Error::Mesh { what: format!("has no area{advice}"), element: format!("face {face}") }
}
