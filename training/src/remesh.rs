//! Removes vertices of a mesh by edge collapses, so that the same surface has other triangles.

use std::cmp::Reverse;
use std::collections::BinaryHeap;

use catamaran::Result;
use catamaran::base::Rng;
use catamaran_geometry::mesh::vector::{dot, norm};
use catamaran_geometry::mesh::{Edges, TriMesh};

/// A mesh of some of the vertices of another mesh.
#[derive(Debug, Clone, PartialEq)]
pub struct Remeshed {
    /// The mesh.
    pub mesh: TriMesh,
    /// For each vertex, its number in the original mesh.
    pub vertices: Vec<u32>,
}

/// Edges are collapsed in the order of their lengths, each multiplied by a random number from 1 to
/// this.
const DISORDER: f64 = 2.0;

/// Cosine of the largest angle by which a face may turn.
const LEAST_COSINE: f64 = 0.5;

/// Smallest quality that a collapse may give a face (as in [`TriMesh::qualities`]), unless the face
/// was worse before.
const LEAST_QUALITY: f64 = 0.25;

/// Removes the given share of the vertices, or fewer where that is not possible. A collapse moves
/// one end of an edge to the other, which keeps its position, so that a mask over the vertices of
/// the mesh restricts to the vertices that are left. Short edges are collapsed first, in an order
/// that depends on the seed as well; the boundary and the topology do not change.
///
/// # Errors
/// None in practice.
pub fn remove_vertices(mesh: &TriMesh, share: f64, seed: u64) -> Result<Remeshed> {
    let n = mesh.vertices().len();
    let mut draft = Draft::new(mesh);
    let mut rng = Rng::new(seed);
    let edges = Edges::new(mesh);
    let mut waiting: BinaryHeap<Reverse<(u64, [u32; 2])>> = BinaryHeap::new();
    let key = |draft: &Draft, [a, b]: [u32; 2], rng: &mut Rng| {
        (draft.length(a, b) * (1.0 + (DISORDER - 1.0) * rng.uniform())).to_bits()
    };
    for &[a, b] in edges.ends() {
        let ends = if rng.bits() & 1 == 0 { [a, b] } else { [b, a] };
        waiting.push(Reverse((key(&draft, ends, &mut rng), ends)));
    }
    let mut left = (share.clamp(0.0, 1.0) * n as f64).round() as usize;
    while left > 0 {
        let Some(Reverse((_, [gone, kept]))) = waiting.pop() else { break };
        if !draft.collapse(gone, kept) && !draft.collapse(kept, gone) {
            continue;
        }
        left -= 1;
        let kept = if draft.around[gone as usize].is_empty() { kept } else { gone };
        for neighbour in draft.neighbours(kept) {
            let ends = [neighbour, kept];
            waiting.push(Reverse((key(&draft, ends, &mut rng), ends)));
        }
    }
    draft.finish()
}

/// A mesh during the collapses.
struct Draft<'m> {
    positions: &'m [[f64; 3]],
    faces: Vec<Option<[u32; 3]>>,
    /// Faces of each vertex.
    around: Vec<Vec<u32>>,
    on_boundary: Vec<bool>,
}

impl<'m> Draft<'m> {
    fn new(mesh: &'m TriMesh) -> Self {
        let edges = Edges::new(mesh);
        let mut on_boundary = vec![false; mesh.vertices().len()];
        for v in edges.boundary().flat_map(|e| edges.ends()[e as usize]) {
            on_boundary[v as usize] = true;
        }
        Self {
            positions: mesh.vertices(),
            faces: mesh.faces().iter().copied().map(Some).collect(),
            around: mesh.vertex_faces().rows().map(<[u32]>::to_vec).collect(),
            on_boundary,
        }
    }

    fn length(&self, a: u32, b: u32) -> f64 {
        let d: [f64; 3] = self.difference(a, b);
        d.iter().map(|x| x * x).sum::<f64>().sqrt()
    }

    fn difference(&self, a: u32, b: u32) -> [f64; 3] {
        let [p, q] = [a, b].map(|v| self.positions[v as usize]);
        std::array::from_fn(|k| q[k] - p[k])
    }

    fn face(&self, f: u32) -> [u32; 3] {
        self.faces[f as usize].unwrap_or([u32::MAX; 3])
    }

    fn neighbours(&self, v: u32) -> Vec<u32> {
        let mut found: Vec<u32> = self.around[v as usize]
            .iter()
            .flat_map(|&f| self.face(f))
            .filter(|&w| w != v)
            .collect();
        found.sort_unstable();
        found.dedup();
        found
    }

    /// Returns the normal of a face, times twice its area.
    fn normal(&self, [a, b, c]: [u32; 3]) -> [f64; 3] {
        let (u, v) = (self.difference(a, b), self.difference(a, c));
        [u[1] * v[2] - u[2] * v[1], u[2] * v[0] - u[0] * v[2], u[0] * v[1] - u[1] * v[0]]
    }

    fn quality(&self, face: [u32; 3]) -> f64 {
        let [a, b, c] = face;
        let lengths = [self.length(a, b), self.length(b, c), self.length(c, a)];
        let longest = lengths.into_iter().fold(0.0, f64::max);
        let perimeter: f64 = lengths.into_iter().sum();
        let area = norm(self.normal(face)) / 2.0;
        4.0 * 3f64.sqrt() * area / (perimeter * longest)
    }

    /// Moves vertex `gone` onto `kept`, unless the mesh would not be a surface afterwards or a face
    /// would turn too far. Returns whether it moved.
    fn collapse(&mut self, gone: u32, kept: u32) -> bool {
        if self.on_boundary[gone as usize] {
            return false;
        }
        let (lost, moved): (Vec<u32>, Vec<u32>) =
            self.around[gone as usize].iter().partition(|&&f| self.face(f).contains(&kept));
        let [of_gone, of_kept] = [gone, kept].map(|v| self.neighbours(v));
        let common = of_gone.iter().filter(|v| of_kept.contains(v)).count();
        // The link condition (Dey et al. 1999); another vertex with three faces must not lose one.
        if lost.len() != 2 || common != 2 || of_gone.len() < 4 {
            return false;
        }
        let opposite = |f: &u32| self.face(*f).into_iter().find(|&v| v != gone && v != kept);
        if lost.iter().filter_map(opposite).any(|v| self.around[v as usize].len() < 4) {
            return false;
        }
        for &f in &moved {
            let before = self.face(f);
            let after = before.map(|v| if v == gone { kept } else { v });
            let (m, n) = (self.normal(before), self.normal(after));
            let cosine = dot(m, n) / (norm(m) * norm(n));
            let enough = self.quality(before).min(LEAST_QUALITY);
            // A face without area has no normal, and its cosine is NaN.
            if !(cosine >= LEAST_COSINE && self.quality(after) >= enough) {
                return false;
            }
        }
        for &f in &lost {
            for v in self.face(f) {
                self.around[v as usize].retain(|&g| g != f);
            }
            self.faces[f as usize] = None;
        }
        for &f in &moved {
            let after = self.face(f).map(|v| if v == gone { kept } else { v });
            self.faces[f as usize] = Some(after);
            self.around[kept as usize].push(f);
        }
        self.around[gone as usize].clear();
        true
    }

    fn finish(self) -> Result<Remeshed> {
        let faces = self.faces.into_iter().flatten().collect();
        let part = TriMesh::new(self.positions.to_vec(), faces)?.without_unreferenced();
        Ok(Remeshed { mesh: part.mesh, vertices: part.vertices })
    }
}

#[cfg(test)]
mod tests {
    use catamaran_geometry::mesh::families::{grid, icosphere};
    use catamaran_geometry::mesh::{Edges, Genus};

    use super::*;

    #[test]
    fn a_share_of_the_vertices_goes_and_the_surface_stays() {
        let sphere = icosphere(4).unwrap();
        let found = remove_vertices(&sphere, 0.3, 7).unwrap();
        let n = sphere.vertices().len();
        assert_eq!(found.mesh.vertices().len(), n - (0.3 * n as f64).round() as usize);
        let edges = Edges::new(&found.mesh);
        edges.require_manifold().unwrap();
        assert_eq!(found.mesh.genus(&edges).unwrap(), Genus::Orientable(0));
        assert!((found.mesh.area() / sphere.area() - 1.0).abs() < 0.01);
        for (new, &old) in found.vertices.iter().enumerate() {
            assert_eq!(found.mesh.vertices()[new], sphere.vertices()[old as usize]);
        }
        assert_eq!(remove_vertices(&sphere, 0.3, 7).unwrap(), found);
        assert_ne!(remove_vertices(&sphere, 0.3, 8).unwrap(), found);
    }

    #[test]
    fn the_boundary_stays_and_flat_stays_flat() {
        let flat = grid(20, 20).unwrap();
        let found = remove_vertices(&flat, 0.3, 1).unwrap();
        assert!((found.mesh.area() - flat.area()).abs() < 1e-12);
        let boundary = |mesh: &TriMesh| Edges::new(mesh).boundary().count();
        assert_eq!(boundary(&found.mesh), boundary(&flat));
    }

    #[test]
    fn what_has_nothing_to_remove_stays() {
        let square = grid(1, 1).unwrap();
        assert_eq!(remove_vertices(&square, 1.0, 0).unwrap().mesh, square);
        let sphere = icosphere(1).unwrap();
        assert_eq!(remove_vertices(&sphere, 0.0, 0).unwrap().mesh, sphere);
        let least = remove_vertices(&sphere, 1.0, 0).unwrap();
        assert!(least.mesh.vertices().len() >= 4);
    }
}
