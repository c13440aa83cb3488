//! The bones that move each vertex, and their weights.

use catamaran_geometry::mesh::TriMesh;

use super::field::to_flesh;
use super::skeleton::Skeleton;

/// Distance beyond which a bone does not move a vertex, relative to the thickness of the nearest
/// bone.
const REACH: f64 = 1.0;

/// Smaller weights are set to zero.
const LEAST: f64 = 1e-3;

/// Computes for each vertex the bones that move it, with weights that sum to 1: the nearest bone
/// and its neighbours in the skeleton, weighted by distance and smoothed over the surface. Mirror
/// images have mirrored weights.
pub(super) fn weights(skeleton: &Skeleton, mesh: &TriMesh, mirror: &[u32]) -> Vec<Vec<(u32, f64)>> {
    let bones = skeleton.bones.len();
    let mut dense: Vec<Vec<f64>> = Vec::with_capacity(mirror.len());
    for &p in mesh.vertices() {
        let distances: Vec<f64> = skeleton.bones.iter().map(|bone| to_flesh(bone, p)).collect();
        let nearest = (0..bones).fold(0, |a, b| if distances[b] < distances[a] { b } else { a });
        let reach = REACH * skeleton.bones[nearest].radii[0];
        let raw = (0..bones).map(|b| match skeleton.adjacent(nearest, b) {
            true => (1.0 - (distances[b] - distances[nearest]) / reach).max(0.0).powi(2),
            false => 0.0,
        });
        dense.push(normalized(raw.collect()));
    }
    // The number of rounds makes the width of the smoothing independent of the resolution.
    let rounds = (mirror.len() as f64 / 250.0).ceil() as usize;
    let neighbours = mesh.vertex_neighbors();
    for _ in 0..rounds {
        let mean = |(v, around): (usize, &[u32])| {
            let share = 0.5 / around.len().max(1) as f64;
            (0..bones)
                .map(|b| {
                    let sum: f64 = around.iter().map(|&w| dense[w as usize][b]).sum();
                    0.5 * dense[v][b] + share * sum
                })
                .collect()
        };
        dense = neighbours.rows().enumerate().map(mean).collect();
    }
    let sparse = |v: usize| {
        let own = &dense[v];
        let other = &dense[mirror[v] as usize];
        let both = (0..bones).map(|b| 0.5 * (own[b] + other[skeleton.bones[b].mirror]));
        let kept = both.map(|w| if w < LEAST { 0.0 } else { w }).collect();
        let weights: Vec<f64> = normalized(kept);
        (0u32..).zip(weights).filter(|&(_, w)| w > 0.0).collect()
    };
    (0..mirror.len()).map(sparse).collect()
}

fn normalized(weights: Vec<f64>) -> Vec<f64> {
    let sum: f64 = weights.iter().sum();
    weights.into_iter().map(|w| w / sum).collect()
}
