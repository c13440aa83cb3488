//! Adds samples where cells have no triangulation as their dual.

use super::batches::seeds;
use super::cells::Growth;
use super::faults::faults;
use super::locks::Locks;
use super::surface::Surface;
use catamaran::base::{Par, Progress, Result};

/// Splits cells at their farthest vertices until the dual of all is a triangulation of the surface.
/// The cell of a locked vertex inside is split, too, if it touches the boundary, where its vertex
/// would have to go. It terminates, because the dual is the surface itself when every vertex is a
/// sample.
///
/// # Errors
/// [`Error::Cancelled`](catamaran::base::Error::Cancelled).
pub(super) fn refine(
    surface: &Surface<'_>,
    growth: &Growth,
    samples: &mut Vec<u32>,
    locks: &Locks,
    par: Par,
    progress: Progress<'_>,
) -> Result<()> {
    let mut census = Census::new(surface, samples.len());
    for round in 1.. {
        progress.report(1.0 - 1.0 / f64::from(round))?;
        census.update(growth, samples.len());
        let inside = |cell: usize| {
            let v = samples[cell];
            locks.contains(v) && !surface.on_boundary[v as usize]
        };
        let bad = faults(surface, growth, &census.doubtful, &census.sizes, inside, par);
        let first = samples.len();
        samples.extend(census.split(surface, growth, samples, &bad));
        if samples.len() == first {
            break; // no cell is at fault, or none can be split: the caller checks the result
        }
        // A cell that was found to be right stays so as long as no cell nearby changes.
        census.doubtful.fill(false);
        bad.into_iter().for_each(|cell| census.doubtful[cell as usize] = true);
        growth.grow(surface, &seeds(samples, first), f32::INFINITY)?;
    }
    Ok(())
}

/// The state of the cells between rounds.
struct Census {
    /// For each vertex its cell.
    cells: Vec<u32>,
    /// For each cell its number of vertices.
    sizes: Vec<u32>,
    /// For each cell its vertex farthest from the sample, and its distance; the sample itself does
    /// not count.
    farthest: Vec<(f32, u32)>,
    /// The cells that were at fault or have changed.
    doubtful: Vec<bool>,
}

impl Census {
    fn new(surface: &Surface<'_>, cells: usize) -> Self {
        Self {
            cells: vec![u32::MAX; surface.len()],
            sizes: Vec::new(),
            farthest: Vec::new(),
            doubtful: vec![true; cells],
        }
    }

    fn update(&mut self, growth: &Growth, cells: usize) {
        self.doubtful.resize(cells, true);
        self.sizes.clear();
        self.sizes.resize(cells, 0);
        self.farthest.clear();
        self.farthest.resize(cells, (0.0, u32::MAX));
        for (v, before) in (0..).zip(&mut self.cells) {
            let cell = growth.cell(v);
            if cell as usize >= cells {
                continue; // a vertex without a face
            }
            if cell != *before {
                self.doubtful[cell as usize] = true;
                if let Some(doubtful) = self.doubtful.get_mut(*before as usize) {
                    *doubtful = true;
                }
                *before = cell;
            }
            self.sizes[cell as usize] += 1;
            let distance = growth.distance(v);
            let farthest = &mut self.farthest[cell as usize];
            if distance > farthest.0 {
                *farthest = (distance, v);
            }
        }
    }

    /// Returns the vertices of these cells farthest from their samples; for a cell of one vertex,
    /// that of its largest neighbour.
    fn split(
        &self,
        surface: &Surface<'_>,
        growth: &Growth,
        samples: &[u32],
        bad: &[u32],
    ) -> Vec<u32> {
        let of_cell = |cell: u32| self.farthest[cell as usize];
        let chosen = bad.iter().filter_map(|&cell| match of_cell(cell) {
            (_, u32::MAX) => {
                let neighbours = surface.links(samples[cell as usize]).iter();
                let others = neighbours.map(|link| of_cell(growth.cell(link.to)));
                Some(others.max_by(|a, b| a.0.total_cmp(&b.0).then(b.1.cmp(&a.1)))?.1)
            }
            (_, v) => Some(v),
        });
        let mut chosen: Vec<u32> = chosen.filter(|&v| v != u32::MAX).collect();
        chosen.sort_unstable();
        chosen.dedup();
        chosen
    }
}
