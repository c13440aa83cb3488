//! Lloyd passes: samples move to the centroids of their cells.

use super::batches::seeds;
use super::cells::Growth;
use super::surface::Surface;
use crate::mesh::vector::{Vector, distance, scale};
use catamaran::base::Result;

/// Moves each sample to the vertex of its cell nearest to the centroid of the cell, and grows cells
/// again. `areas` are the weights of the vertices, such as their areas. Samples for which `stays`
/// holds do not move.
pub(super) fn pass(
    surface: &Surface<'_>,
    growth: &mut Growth,
    samples: &mut [u32],
    areas: &[f64],
    stays: impl Fn(u32) -> bool,
    cutoff: f32,
) -> Result<()> {
    let mut sums: Vec<(Vector, f64)> = vec![([0.0; 3], 0.0); samples.len()];
    let each = || (0..surface.len() as u32).map(|v| (v, growth.cell(v) as usize));
    for (v, cell) in each() {
        if let Some((sum, weight)) = sums.get_mut(cell) {
            let (p, area) = (surface.position(v), areas[v as usize]);
            (0..3).for_each(|k| sum[k] += area * p[k]);
            *weight += area;
        }
    }
    let centroids: Vec<Vector> = sums
        .into_iter()
        .zip(samples.iter())
        .map(
            |((sum, weight), &sample)| {
                if weight > 0.0 { scale(sum, 1.0 / weight) } else { surface.position(sample) }
            },
        )
        .collect();
    // Nothing is nearer to a sample that stays.
    let least = |&sample: &u32| if stays(sample) { f64::NEG_INFINITY } else { f64::INFINITY };
    let mut nearest: Vec<f64> = samples.iter().map(least).collect();
    for (v, cell) in each() {
        if let Some(least) = nearest.get_mut(cell) {
            let found = distance(surface.position(v), centroids[cell]);
            if found < *least {
                *least = found;
                samples[cell] = v;
            }
        }
    }
    growth.clear();
    growth.grow(surface, &seeds(samples, 0), cutoff)?;
    growth.grow_on(surface)
}
