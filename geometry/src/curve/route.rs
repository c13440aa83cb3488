//! Finds paths between successive samples that do not meet: first separately, then by negotiation
//! (McMurchie and Ebeling 1995), at last with Steiner points.

use super::surface::Surface;
use crate::mesh::Search;
use crate::mesh::vector::distance;
use catamaran::base::{Progress, Result};

/// Number of rounds of negotiation, and the factor by which the price of a shared vertex grows in
/// each.
const ROUNDS: usize = 40;
const GROWTH: f64 = 1.5;
/// Share of the progress of negotiation that the first paths take.
const FIRST_PATHS: f64 = 5.0 / 9.0;
/// Limit of the vertices that negotiation may settle: a multiple of those that all first paths
/// settled, and a constant that takes a fraction of a second, whatever the mesh.
const PATIENCE: usize = 40;
const MOST_SETTLED: usize = 1_500_000;

/// The mark of a vertex that belongs to a sample.
const SAMPLE: u8 = 1;

/// The two vertices of samples that a path shall connect.
pub(super) type Net = (u32, u32);

/// Finds paths on a surface, with marks and counts for each vertex, which are all 0 before and
/// after.
pub(super) struct Router<'a, 'm> {
    pub surface: &'a mut Surface<'m>,
    pub search: &'a mut Search,
    /// [`SAMPLE`] or 0.
    pub marks: &'a mut Vec<u8>,
    /// Number of paths that use each vertex.
    pub users: &'a mut Vec<u16>,
    /// Number of times that more than one path wanted each vertex.
    pub history: &'a mut Vec<f32>,
}

impl Router<'_, '_> {
    /// Finds a path for each net; `None` where there is none. Paths meet only at their ends.
    /// `samples` are the vertices that paths of other samples must avoid.
    ///
    /// # Errors
    /// [`Error::Cancelled`](catamaran::Error::Cancelled);
    /// [`Error::Argument`](catamaran::Error::Argument) for too many vertices.
    pub fn route(
        &mut self,
        nets: &[Net],
        samples: &[u32],
        steiner: bool,
        progress: Progress<'_>,
    ) -> Result<Vec<Option<Vec<u32>>>> {
        for &v in samples {
            self.marks[v as usize] = SAMPLE;
        }
        let mut paths = vec![None; nets.len()];
        let mut wanted = Vec::new();
        let done =
            self.negotiate(nets, &mut paths, &mut wanted, progress.part(0.0..0.9)).and_then(|()| {
                self.keep_apart(nets, &mut paths);
                self.insist(nets, &mut paths, steiner, progress.part(0.9..1.0))
            });
        for &v in samples {
            self.marks[v as usize] = 0;
        }
        for v in wanted {
            self.history[v as usize] = 0.0;
        }
        for path in paths.iter().flatten() {
            self.count(path, false);
        }
        self.marks.truncate(self.surface.mesh().vertices().len());
        self.users.truncate(self.surface.mesh().vertices().len());
        self.history.truncate(self.surface.mesh().vertices().len());
        done.map(|()| paths)
    }

    /// Adds a path to the counts of its inner vertices, or subtracts it.
    fn count(&mut self, path: &[u32], add: bool) {
        for &v in path.get(1..path.len().saturating_sub(1)).unwrap_or_default() {
            let users = &mut self.users[v as usize];
            *users = if add { users.saturating_add(1) } else { users.saturating_sub(1) };
        }
    }

    /// Returns the cheapest path of a net, where the cost of an edge is its length times a factor
    /// for shared vertices. Without a price, vertices of other paths are forbidden.
    fn path(&mut self, (from, to): Net, price: Option<f64>) -> Option<Vec<u32>> {
        let aim = self.surface.position(to);
        self.search.start(&[from]);
        while let Some((v, cost)) = self.search.next() {
            if v == to {
                return Some(self.search.path(v));
            }
            for (u, length) in self.surface.neighbours(v) {
                let i = u as usize;
                if u == to {
                    self.search.relax(v, u, cost + length, 0.0);
                } else if self.marks[i] != SAMPLE {
                    let users = f64::from(self.users[i]);
                    let factor = match price {
                        Some(price) => (1.0 + f64::from(self.history[i])) * (1.0 + price * users),
                        None if self.users[i] > 0 => continue,
                        None => 1.0,
                    };
                    let rest = distance(self.surface.position(u), aim);
                    self.search.relax(v, u, cost + length * factor, rest);
                }
            }
        }
        None
    }

    fn is_contested(&self, path: &[u32]) -> bool {
        path.iter().any(|&v| self.users[v as usize] > 1)
    }

    /// Repeats until no vertex is used twice, or the limit is reached. A net without a path has
    /// none, whatever the other paths are.
    fn negotiate(
        &mut self,
        nets: &[Net],
        paths: &mut [Option<Vec<u32>>],
        wanted: &mut Vec<u32>,
        progress: Progress<'_>,
    ) -> Result<()> {
        let before = self.search.settled();
        let [first_paths, rounds] =
            [0.0..FIRST_PATHS, FIRST_PATHS..1.0].map(|part| progress.part(part));
        for (i, &net) in nets.iter().enumerate() {
            first_paths.report(i as f64 / nets.len() as f64)?;
            paths[i] = self.path(net, Some(0.0));
            if let Some(path) = &paths[i] {
                self.count(path, true);
            }
        }
        let first = self.search.settled() - before;
        let budget = before + (PATIENCE * first).min(first + MOST_SETTLED);
        let mut price = 1.0;
        for round in 0..ROUNDS {
            rounds.report(round as f64 / ROUNDS as f64)?;
            let mut contested = false;
            for (i, &net) in nets.iter().enumerate() {
                let Some(path) = paths[i].take_if(|path| self.is_contested(path)) else { continue };
                if self.search.settled() > budget {
                    paths[i] = Some(path);
                    return Ok(());
                }
                contested = true;
                self.count(&path, false);
                paths[i] = self.path(net, Some(price));
                if let Some(path) = &paths[i] {
                    self.count(path, true);
                }
            }
            if !contested {
                return Ok(());
            }
            for path in paths.iter().flatten() {
                for &v in path {
                    if self.users[v as usize] > 1 {
                        if self.history[v as usize] == 0.0 {
                            wanted.push(v);
                        }
                        self.history[v as usize] += 1.0;
                    }
                }
            }
            price *= GROWTH;
        }
        Ok(())
    }

    /// Drops paths that meet others, those with the most conflicts first, until none does.
    fn keep_apart(&mut self, nets: &[Net], paths: &mut [Option<Vec<u32>>]) {
        loop {
            let meetings =
                |path: &Vec<u32>| path.iter().filter(|&&v| self.users[v as usize] > 1).count();
            let count = |i: usize| paths[i].as_ref().map_or(0, meetings);
            let most = (0..nets.len()).rev().max_by_key(|&i| count(i)).filter(|&i| count(i) > 0);
            let Some(path) = most.and_then(|i| paths[i].take()) else { return };
            self.count(&path, false);
        }
    }

    /// Finds paths that avoid the others for the nets without a path; inserts Steiner points where
    /// no path exists.
    ///
    /// The existing paths are arcs, and disjoint arcs do not separate a connected surface without
    /// boundary, so that on such a surface every net gets a path.
    fn insist(
        &mut self,
        nets: &[Net],
        paths: &mut [Option<Vec<u32>>],
        steiner: bool,
        progress: Progress<'_>,
    ) -> Result<()> {
        for (i, &net) in nets.iter().enumerate() {
            if paths[i].is_some() {
                continue;
            }
            progress.report(i as f64 / nets.len() as f64)?;
            paths[i] = self.path(net, None);
            if paths[i].is_none() && steiner {
                let mut around: Vec<Vec<u32>> = paths.iter().flatten().cloned().collect();
                // Samples that no path has reached are obstacles, too.
                around.extend(
                    nets.iter()
                        .flat_map(|&(a, b)| [vec![a], vec![b]])
                        .filter(|end| !paths.iter().flatten().any(|path| path.contains(&end[0]))),
                );
                self.surface.refine_around(&around)?;
                let vertices = self.surface.len();
                self.search.grow(vertices);
                self.marks.resize(vertices, 0);
                self.users.resize(vertices, 0);
                self.history.resize(vertices, 0.0);
                paths[i] = self.path(net, None);
            }
            if let Some(path) = &paths[i] {
                self.count(path, true);
            }
        }
        Ok(())
    }
}
