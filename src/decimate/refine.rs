//! Samples added where cells are no dual of a triangulation.

use super::batches::seeds;
use super::cells::Growth;
use super::dual::faults;
use super::stages::Stages;
use super::surface::Surface;
use crate::base::{Par, Result};

/// Splits cells at their farthest vertices until the dual of all is a triangulation of the surface. It ends: when every
/// vertex is a sample, the dual is the surface itself.
///
/// # Errors
/// [`Error::Cancelled`](crate::base::Error::Cancelled).
pub(super) fn refine(
    surface: &Surface<'_>,
    growth: &Growth,
    samples: &mut Vec<u32>,
    par: Par,
    stages: Stages<'_>,
) -> Result<()> {
    for round in 1.. {
        stages.report(1.0 - 1.0 / f64::from(round))?;
        let bad = faults(surface, growth, samples.len(), par);
        if bad.is_empty() {
            break;
        }
        let first = samples.len();
        samples.extend(split(surface, growth, samples.len(), &bad));
        if samples.len() == first {
            break; // nothing can be split: the caller checks what comes of it
        }
        growth.grow(surface, &seeds(samples, first), f32::INFINITY);
    }
    Ok(())
}

/// The vertices of these cells farthest from their samples; where a cell is one vertex only, that of the largest neighbour.
fn split(surface: &Surface<'_>, growth: &Growth, cells: usize, bad: &[u32]) -> Vec<u32> {
    // The farthest vertex of each cell; the sample itself is none.
    let mut farthest = vec![(0.0f32, u32::MAX); cells];
    let mut only = vec![u32::MAX; cells];
    for v in 0..surface.len() as u32 {
        let (cell, distance) = (growth.cell(v) as usize, growth.distance(v));
        if cell >= cells {
            continue;
        }
        only[cell] = v;
        if distance > farthest[cell].0 {
            farthest[cell] = (distance, v);
        }
    }
    let mut chosen: Vec<u32> = bad
        .iter()
        .filter_map(|&cell| {
            let of_cell = |cell: u32| farthest[cell as usize];
            let v = match of_cell(cell) {
                (_, u32::MAX) => {
                    let neighbours = surface.links(only[cell as usize]).iter();
                    let others = neighbours.map(|link| of_cell(growth.cell(link.to)));
                    others.max_by(|a, b| a.0.total_cmp(&b.0).then(b.1.cmp(&a.1)))?.1
                }
                (_, v) => v,
            };
            (v != u32::MAX).then_some(v)
        })
        .collect();
    chosen.sort_unstable();
    chosen.dedup();
    chosen
}
