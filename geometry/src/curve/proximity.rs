//! Finds the samples near each sample: the dual of their geodesic Voronoi diagram, computed only as
//! far as needed.

use std::collections::BTreeMap;

use super::surface::Surface;
use crate::mesh::Search;
use crate::mesh::vector::distance;
use catamaran::base::{Result, Sets, ask};

/// Radius to which cells grow, relative to the radius at which all samples are connected.
const REACH: f64 = 2.0;
/// Largest number of nearest samples that are kept for each sample.
const NEAREST: usize = 32;
/// Distance of a sample that is not kept, relative to the farthest one that is.
const BEYOND: f64 = 3.0;

/// The nearest samples of each sample, along the edges of the mesh through neighbouring cells.
pub(super) struct Proximity {
    /// For each sample, other samples and their distances, by index.
    rows: Vec<Vec<(u32, f64)>>,
    /// For each sample, the other samples of its row, the nearest first.
    nearest: Vec<Vec<u32>>,
    /// For each sample, the distance beyond which samples are not in its row.
    horizon: Vec<f64>,
    positions: Vec<[f64; 3]>,
}

impl Proximity {
    /// Computes the neighbours of samples on one component.
    pub fn new(surface: &Surface<'_>, search: &mut Search, samples: &[u32]) -> Result<Self> {
        let dual = dual(surface, search, samples)?;
        let count = samples.len();
        let (mut rows, mut nearest, mut horizon) = (Vec::new(), Vec::new(), Vec::new());
        for from in 0..count as u32 {
            let mut row = Vec::new();
            ask()?;
            search.start(&[from]);
            while let Some((i, to_i)) = search.next() {
                if i != from {
                    row.push((i, to_i));
                    if row.len() == NEAREST {
                        break;
                    }
                }
                for &(j, length) in &dual[i as usize] {
                    search.relax(i, j, to_i + length, 0.0);
                }
            }
            horizon.push(row.last().map_or(0.0, |r| r.1));
            nearest.push(row.iter().map(|r| r.0).collect());
            row.sort_unstable_by_key(|r| r.0);
            rows.push(row);
        }
        let positions = samples.iter().map(|&v| surface.position(v)).collect();
        Ok(Self { rows, nearest, horizon, positions })
    }

    /// Returns the number of samples.
    pub fn len(&self) -> usize {
        self.rows.len()
    }

    /// Returns the nearest samples, the nearest first.
    pub fn nearest(&self, i: u32) -> &[u32] {
        &self.nearest[i as usize]
    }

    /// Returns the distance of two samples; an estimate for samples that are far apart.
    pub fn distance(&self, i: u32, j: u32) -> f64 {
        let row = &self.rows[i as usize];
        if let Ok(at) = row.binary_search_by_key(&j, |r| r.0) {
            return row[at].1;
        }
        let row = &self.rows[j as usize];
        if let Ok(at) = row.binary_search_by_key(&i, |r| r.0) {
            return row[at].1;
        }
        let (i, j) = (i as usize, j as usize);
        let straight = distance(self.positions[i], self.positions[j]);
        BEYOND * straight.max(self.horizon[i]).max(self.horizon[j])
    }

    /// Returns the position of a sample.
    pub fn position(&self, i: u32) -> [f64; 3] {
        self.positions[i as usize]
    }
}

/// Returns for each sample those whose cells touch its own, with the length of the shortest path
/// through both cells.
fn dual(
    surface: &Surface<'_>,
    search: &mut Search,
    samples: &[u32],
) -> Result<Vec<Vec<(u32, f64)>>> {
    // Sorted, so that the result does not depend on the order in which cells meet.
    let mut edges: BTreeMap<(u32, u32), f64> = BTreeMap::new();
    let mut sets = Sets::new(samples.len());
    let mut apart = samples.len();
    let mut limit = f64::INFINITY;
    search.start(samples);
    while let Some((v, to_v)) = search.next() {
        ask()?;
        if to_v > limit {
            break;
        }
        let Some((_, cell)) = search.known(v) else { break };
        for (u, length) in surface.neighbours(v) {
            search.relax(v, u, to_v + length, 0.0);
            let Some((to_u, other)) = search.known(u).filter(|known| known.1 != cell) else {
                continue;
            };
            let through = to_v + length + to_u;
            let least = edges.entry((cell.min(other), cell.max(other))).or_insert(f64::INFINITY);
            *least = least.min(through);
            if sets.find(cell) != sets.find(other) {
                sets.join(cell, other);
                apart -= 1;
                if apart == 1 {
                    limit = REACH * to_v;
                }
            }
        }
    }
    let mut dual = vec![Vec::new(); samples.len()];
    for ((i, j), length) in edges {
        dual[i as usize].push((j, length));
        dual[j as usize].push((i, length));
    }
    Ok(dual)
}
