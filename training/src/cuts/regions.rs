//! Connected regions of a template, as masks.

use catamaran::{Par, Result};
use catamaran_geometry::mesh::{Adjacency, HeatMethod, HeatOptions, TriMesh, vertex_areas};

/// For each vertex of the template, whether it belongs to the region.
pub type Mask = Vec<bool>;

/// Distances are multiples of this share of the square root of the area. Their last digits differ
/// from CPU to CPU, and would decide between mirror images, which are equally far away.
const STEP: f64 = 1.0 / (1 << 20) as f64;

/// A template with the data that cuts require.
pub(crate) struct Surface<'m> {
    pub mesh: &'m TriMesh,
    pub mirror: &'m [u32],
    pub areas: Vec<f64>,
    pub neighbours: Adjacency,
    heat: HeatMethod,
    /// Unit of the distances.
    step: f64,
}

impl<'m> Surface<'m> {
    pub fn new(mesh: &'m TriMesh, mirror: &'m [u32], par: Par) -> Result<Self> {
        let heat = HeatMethod::new(mesh, &HeatOptions::new().par(par))?;
        let (areas, neighbours) = (vertex_areas(mesh), mesh.vertex_neighbors());
        let step = STEP * areas.iter().sum::<f64>().sqrt();
        Ok(Self { mesh, mirror, areas, neighbours, heat, step })
    }

    pub fn len(&self) -> usize {
        self.mirror.len()
    }

    /// Returns the geodesic distances from a vertex, rounded so that they are the same on all CPUs.
    pub fn distances(&self, from: u32) -> Result<Vec<f64>> {
        let mut distances = self.heat.distances(&[from])?;
        distances.iter_mut().for_each(|d| *d = (*d / self.step).round() * self.step);
        Ok(distances)
    }

    pub fn area(&self, mask: &[bool]) -> f64 {
        (0..self.len()).filter(|&v| mask[v]).map(|v| self.areas[v]).sum()
    }

    /// Returns the area of a mask relative to that of the surface.
    pub fn share(&self, mask: &[bool]) -> f64 {
        self.area(mask) / self.areas.iter().sum::<f64>()
    }

    pub fn mirrored(&self, mask: &[bool]) -> Mask {
        self.mirror.iter().map(|&m| mask[m as usize]).collect()
    }

    /// Returns the area of a mask on the left, the side of positive x, minus that on the right.
    pub fn leaning(&self, mask: &[bool]) -> f64 {
        let side = |v: usize| match self.mesh.vertices()[v][0] {
            x if x > 0.0 => self.areas[v],
            x if x < 0.0 => -self.areas[v],
            _ => 0.0,
        };
        (0..self.len()).filter(|&v| mask[v]).map(side).sum()
    }

    /// Returns the mask with a smooth edge and without holes of single vertices: in each round, a
    /// vertex adopts the value of the majority of its neighbours; the largest piece is kept.
    pub fn smoothed(&self, mask: &[bool]) -> Mask {
        let mut level: Vec<f64> = mask.iter().map(|&inside| f64::from(u8::from(inside))).collect();
        // Makes the width of the smoothing independent of the resolution.
        let rounds = (self.len() as f64 / 400.0).ceil() as usize;
        for _ in 0..rounds {
            let mean = |(v, around): (usize, &[u32])| {
                let sum: f64 = around.iter().map(|&w| level[w as usize]).sum();
                0.5 * level[v] + 0.5 * sum / around.len().max(1) as f64
            };
            level = self.neighbours.rows().enumerate().map(mean).collect();
        }
        let smooth: Mask = level.iter().map(|&x| x > 0.5).collect();
        self.largest_piece(&smooth)
    }

    /// Returns the number of vertices in the mask whose neighbours are all in the mask.
    pub fn inside(&self, mask: &[bool]) -> usize {
        let closed = |v: &usize| self.neighbours.row(*v).iter().all(|&w| mask[w as usize]);
        (0..self.len()).filter(|&v| mask[v]).filter(closed).count()
    }

    /// Returns the piece with the largest number of vertices.
    pub fn largest_piece(&self, mask: &[bool]) -> Mask {
        let mut left = mask.to_vec();
        let mut best: Vec<u32> = Vec::new();
        for start in 0..self.len() {
            if !std::mem::take(&mut left[start]) {
                continue;
            }
            let mut piece = vec![start as u32];
            let mut next = 0;
            while let Some(&v) = piece.get(next) {
                next += 1;
                for &w in self.neighbours.row(v as usize) {
                    if std::mem::take(&mut left[w as usize]) {
                        piece.push(w);
                    }
                }
            }
            if piece.len() > best.len() {
                best = piece;
            }
        }
        let mut largest = vec![false; self.len()];
        best.iter().for_each(|&v| largest[v as usize] = true);
        largest
    }
}

/// Returns the number of vertices in both masks.
pub(super) fn overlap(a: &[bool], b: &[bool]) -> usize {
    a.iter().zip(b).filter(|(a, b)| **a && **b).count()
}

/// Returns the union of two masks.
pub(crate) fn union(a: &[bool], b: &[bool]) -> Mask {
    a.iter().zip(b).map(|(a, b)| *a || *b).collect()
}

/// Returns a number that identifies a mask (FNV-1a over its vertices).
pub fn id(mask: &[bool]) -> usize {
    let inside = (0u64..).zip(mask).filter(|(_, inside)| **inside).map(|(v, _)| v);
    let hash = inside.fold(0xcbf2_9ce4_8422_2325u64, |hash, v| {
        v.to_le_bytes()
            .iter()
            .fold(hash, |hash, &byte| (hash ^ u64::from(byte)).wrapping_mul(0x0100_0000_01b3))
    });
    hash as usize
}
