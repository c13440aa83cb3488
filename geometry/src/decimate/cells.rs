//! Voronoi cells of samples along the edges of a mesh, grown by Dijkstra's algorithm from each
//! sample.

use std::cmp::Reverse;
use std::collections::BinaryHeap;
use std::sync::atomic::{AtomicU64, Ordering};

use super::surface::Surface;
use catamaran::base::{Par, Result, ask, count, reserved, spend};

/// A partition of the vertices of a mesh: each vertex belongs to its nearest sample, along edges.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Cells {
    of_vertices: Vec<u32>,
    /// In units of length.
    distances: Vec<f32>,
    /// The same in this unit, a power of 2, where units of length would not suit single precision.
    scaled: Option<(f64, Vec<f32>)>,
}

/// Size of a mesh, and inverse of its size, up to which distances in units of length suit single
/// precision: a factor of 10^18 is left for long paths and for short edges.
const LARGEST_UNSCALED: f64 = (1u64 << 63) as f64;

impl Cells {
    /// Marks a vertex that no sample reaches: one without a face, or in a component without a
    /// sample.
    pub const NONE: u32 = u32::MAX;

    /// Returns for each vertex of the mesh the number of its cell, from 0, or [`Cells::NONE`].
    /// Among equally near samples, the first one counts.
    pub fn of_vertices(&self) -> &[u32] {
        &self.of_vertices
    }

    /// Returns for each vertex of the mesh its distance along edges to the sample of its cell, in
    /// units of length, in single precision, whose range ends at 3e38 and 1e-38 (that of
    /// [`Cells::lengths`] does not); infinite for vertices in no cell.
    pub fn distances(&self) -> &[f32] {
        &self.distances
    }

    /// Returns the [`Cells::distances`] of a mesh of any size, each with a relative error of about
    /// 1e-7, as they are sums in single precision relative to the size of the mesh.
    ///
    /// ```
    /// use catamaran_geometry::{decimate::FarthestPoints, mesh::TriMesh};
    ///
    /// let corners = vec![[0.0; 3], [3e-50, 0.0, 0.0], [0.0, 4e-50, 0.0]];
    /// let mesh = TriMesh::new(corners, vec![[0, 1, 2]])?;
    /// let lengths = FarthestPoints::new(&mesh, Some(0))?.cells().lengths();
    /// assert!((lengths[2] / 4e-50 - 1.0).abs() < 1e-6);
    /// # Ok::<(), catamaran::Error>(())
    /// ```
    pub fn lengths(&self) -> Vec<f64> {
        let (unit, distances) = match &self.scaled {
            Some((unit, distances)) => (*unit, distances),
            None => (1.0, &self.distances),
        };
        distances.iter().map(|&distance| unit * f64::from(distance)).collect()
    }

    /// Returns the largest of the [`Cells::lengths`] of vertices in a cell; 0 without such a
    /// vertex.
    pub fn radius(&self) -> f64 {
        self.lengths().into_iter().filter(|length| length.is_finite()).fold(0.0, f64::max)
    }

    /// Returns the same cells for other vertices: vertex v is the former vertex `old[v]`, if that
    /// exists.
    pub(super) fn seen_from(&self, old: &[u32]) -> Self {
        let at = |&v: &u32| v as usize;
        let known = |v: usize| self.of_vertices.get(v).copied().unwrap_or(Self::NONE);
        let seen = |distances: &[f32]| -> Vec<f32> {
            let far = |v: usize| distances.get(v).copied().unwrap_or(f32::INFINITY);
            old.iter().map(at).map(far).collect()
        };
        Self {
            of_vertices: old.iter().map(at).map(known).collect(),
            distances: seen(&self.distances),
            scaled: self.scaled.as_ref().map(|(unit, distances)| (*unit, seen(distances))),
        }
    }
}

/// A vertex that is not reached: farther than every distance.
const FREE: u64 = u64::MAX;

/// Packs distance and cell into one number; the lower number of a vertex wins. Distances are not
/// negative, so that their bits have the order of the numbers.
fn pack(distance: f32, cell: u32) -> u64 {
    u64::from(distance.to_bits()) << 32 | u64::from(cell)
}

fn distance_of(state: u64) -> f32 {
    if state == FREE { f32::INFINITY } else { f32::from_bits((state >> 32) as u32) }
}

/// The state of growing cells.
///
/// Each sample runs Dijkstra's algorithm as long as it wins, and several do so at the same time.
/// The state of a vertex only decreases, and at the end it is the least state over all paths,
/// whatever the order. Therefore the result is the same for any number of threads.
pub(super) struct Growth {
    state: Vec<AtomicU64>,
    par: Par,
}

/// The start of a cell.
#[derive(Debug, Clone, Copy)]
pub(super) struct Seed {
    pub vertex: u32,
    pub distance: f32,
    pub cell: u32,
}

/// Vertices to be visited, the nearest first: distance and vertex as one number.
type Queue = BinaryHeap<Reverse<u64>>;

/// Number of seeds that one thread takes at a time.
const BATCH: usize = 8;

/// Operations that a step of growth is equal to: it waits for memory.
const STEP: f64 = 100.0;

impl Growth {
    /// Creates a state without cells.
    pub fn new(surface: &Surface<'_>, par: Par) -> Result<Self> {
        let mut state = reserved(surface.len())?;
        state.resize_with(surface.len(), || AtomicU64::new(FREE));
        Ok(Self { state, par })
    }

    /// Removes all vertices from their cells.
    pub fn clear(&mut self) {
        self.state.iter_mut().for_each(|state| *state.get_mut() = FREE);
    }

    /// Returns the distance of a vertex from the seed of its cell.
    pub fn distance(&self, v: u32) -> f32 {
        distance_of(self.state[v as usize].load(Ordering::Relaxed))
    }

    /// Returns the cell of a vertex, or [`Cells::NONE`] if it is in none.
    pub fn cell(&self, v: u32) -> u32 {
        self.state[v as usize].load(Ordering::Relaxed) as u32
    }

    /// Grows all seeds up to the distance `cutoff` (relative to the surface's scale).
    ///
    /// # Errors
    /// [`Error::Cancelled`](catamaran::Error::Cancelled), after whole cells.
    pub fn grow(&self, surface: &Surface<'_>, seeds: &[Seed], cutoff: f32) -> Result<()> {
        if self.par.threads() == 1 {
            let mut queue = Queue::new();
            for seed in seeds {
                self.grow_one::<true>(surface, seed, cutoff, &mut queue);
                ask()?;
            }
            return Ok(());
        }
        let operations = STEP * (surface.len() * BATCH) as f64 / seeds.len().max(1) as f64;
        let done = self.par.map_blocks_asking(seeds.len(), BATCH, operations, |range| {
            let mut queue = Queue::new();
            seeds[range]
                .iter()
                .for_each(|seed| self.grow_one::<false>(surface, seed, cutoff, &mut queue));
        });
        done.map(|_| ())
    }

    /// Continues growth beyond the cut-off to all vertices that can be reached.
    ///
    /// # Errors
    /// [`Error::Cancelled`](catamaran::Error::Cancelled).
    pub fn grow_on(&self, surface: &Surface<'_>) -> Result<()> {
        let free = |v: u32| self.state[v as usize].load(Ordering::Relaxed) == FREE;
        let mut queue = Queue::new();
        for v in 0..surface.len() as u32 {
            if !free(v) && surface.links(v).iter().any(|link| free(link.to)) {
                queue.push(Reverse(pack(self.distance(v), v)));
            }
        }
        while let Some(Reverse(entry)) = queue.pop() {
            spend(STEP)?;
            let (from, v) = (distance_of(entry), entry as u32);
            let cell = self.cell(v);
            if self.state[v as usize].load(Ordering::Relaxed) != pack(from, cell) {
                continue;
            }
            for link in surface.links(v) {
                let through = from + link.length;
                if self.improve::<true>(link.to, pack(through, cell)) {
                    queue.push(Reverse(pack(through, link.to)));
                }
            }
        }
        Ok(())
    }

    /// Grows one seed; `ALONE` when no other thread grows.
    fn grow_one<const ALONE: bool>(
        &self,
        surface: &Surface<'_>,
        seed: &Seed,
        cutoff: f32,
        queue: &mut Queue,
    ) {
        let cell = seed.cell;
        queue.clear();
        if self.improve::<ALONE>(seed.vertex, pack(seed.distance, cell)) {
            queue.push(Reverse(pack(seed.distance, seed.vertex)));
        }
        while let Some(Reverse(entry)) = queue.pop() {
            if ALONE {
                count(STEP);
            }
            let (from, v) = (distance_of(entry), entry as u32);
            if self.state[v as usize].load(Ordering::Relaxed) != pack(from, cell) {
                continue; // another seed is nearer now
            }
            for link in surface.links(v) {
                let through = from + link.length;
                if through <= cutoff && self.improve::<ALONE>(link.to, pack(through, cell)) {
                    queue.push(Reverse(pack(through, link.to)));
                }
            }
        }
    }

    fn improve<const ALONE: bool>(&self, v: u32, state: u64) -> bool {
        let place = &self.state[v as usize];
        let mut now = place.load(Ordering::Relaxed);
        if ALONE {
            if state < now {
                place.store(state, Ordering::Relaxed);
            }
            return state < now;
        }
        while state < now {
            match place.compare_exchange_weak(now, state, Ordering::Relaxed, Ordering::Relaxed) {
                Ok(_) => return true,
                Err(other) => now = other,
            }
        }
        false
    }

    /// Returns the grown cells, with distances in units of length: the relative ones times
    /// [`Surface::scale`].
    pub fn cells(&self, scale: f64) -> Cells {
        let vertices = 0..self.state.len() as u32;
        let lengths = |scale: f64| -> Vec<f32> {
            let length = |v: u32| (f64::from(self.distance(v)) * scale) as f32;
            vertices.clone().map(length).collect()
        };
        let is_usual = (1.0 / LARGEST_UNSCALED..=LARGEST_UNSCALED).contains(&scale);
        let unit = 2f64.powi(scale.log2().floor() as i32);
        Cells {
            of_vertices: vertices.clone().map(|v| self.cell(v)).collect(),
            distances: lengths(scale),
            scaled: (!is_usual).then(|| (unit, lengths(scale / unit))),
        }
    }
}
