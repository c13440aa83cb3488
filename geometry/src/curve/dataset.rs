//! Generates curves for tests of reconstruction from a seed, as in section 6.4.1 of the thesis.

use crate::mesh::{Dijkstra, Graph, Search, SearchLimits, TriMesh};
use catamaran::base::{Result, Rng};

/// The least number of vertices of a generated curve.
pub const LEAST_VERTICES: usize = 100;
/// Number of walks that fail, or are too short, after which the generator gives up.
const ATTEMPTS: usize = 400;

/// Generates curves on one mesh.
///
/// ```
/// use catamaran_geometry::curve::dataset::{Generator, LEAST_VERTICES};
/// use catamaran_geometry::mesh::{Graph, families};
///
/// let graph = Graph::of_mesh(&families::icosphere(5)?);
/// let curve = Generator::new(&graph, 1)?.curve()?.unwrap();
/// assert!(curve.len() >= LEAST_VERTICES);
/// let next = |i: usize| curve[(i + 1) % curve.len()];
/// let is_edge = |i: usize| graph.neighbours(curve[i]).any(|(v, _)| v == next(i));
/// assert!((0..curve.len()).all(is_edge));
/// # Ok::<(), catamaran::Error>(())
/// ```
pub struct Generator<'g> {
    graph: &'g Graph,
    from_start: Dijkstra<'g>,
    from_top: Dijkstra<'g>,
    back: Search,
    rng: Rng,
}

impl<'g> Generator<'g> {
    /// Creates a generator of curves on the mesh of this graph; the same seed gives the same
    /// curves.
    ///
    /// # Errors
    /// [`Error::OutOfMemory`](catamaran::Error::OutOfMemory).
    pub fn new(graph: &'g Graph, seed: u64) -> Result<Self> {
        Ok(Self {
            graph,
            from_start: Dijkstra::new(graph),
            from_top: Dijkstra::new(graph),
            back: Search::new(graph.len())?,
            rng: Rng::new(seed),
        })
    }

    /// Returns the next closed curve, of at least [`LEAST_VERTICES`] vertices, each adjacent to the
    /// previous one and the last to the first; `None` when 400 walks gave none.
    ///
    /// A walk goes from a vertex s to random neighbours farther from s, up to a vertex m without
    /// such a neighbour. Then it goes sideways, away from m and as near as possible to the distance
    /// of m from s, for a random number of steps. At last it returns to s by the shortest path that
    /// avoids the walk.
    ///
    /// # Errors
    /// None in practice.
    pub fn curve(&mut self) -> Result<Option<Vec<u32>>> {
        for _ in 0..ATTEMPTS {
            if let Some(curve) = self.walk()?.filter(|curve| curve.len() >= LEAST_VERTICES) {
                return Ok(Some(curve));
            }
        }
        Ok(None)
    }

    fn walk(&mut self) -> Result<Option<Vec<u32>>> {
        if self.graph.is_empty() {
            return Ok(None);
        }
        let graph = self.graph;
        let start = below(&mut self.rng, graph.len()) as u32;
        self.from_start.search(&[(start, 0.0)], &SearchLimits::default())?;
        let height = self.from_start.distances();
        let mut curve = vec![start];
        let mut at = start;
        loop {
            // The vertices are farther from s, and therefore not visited before.
            let up: Vec<u32> = (graph.neighbours(at).map(|(u, _)| u))
                .filter(|&u| height[u as usize] > height[at as usize])
                .collect();
            if up.is_empty() {
                break;
            }
            at = up[below(&mut self.rng, up.len())];
            curve.push(at);
        }
        if at == start {
            return Ok(None); // a vertex without edges
        }
        let top = height[at as usize];
        self.from_top.search(&[(at, 0.0)], &SearchLimits::default())?;
        let away = self.from_top.distances();
        let least = curve.len() / 4;
        let steps = least + below(&mut self.rng, curve.len() - least + 1);
        for _ in 0..steps {
            let off = |u: u32| (height[u as usize] - top).abs();
            let next = (graph.neighbours(at).map(|(u, _)| u))
                .filter(|u| away[*u as usize] > away[at as usize] && !curve.contains(u))
                .min_by(|&u, &v| off(u).total_cmp(&off(v)));
            let Some(next) = next else { break };
            at = next;
            curve.push(at);
        }
        let Some(path) = self.way_back(at, start, &curve) else { return Ok(None) };
        curve.extend(&path[1..path.len() - 1]);
        Ok(Some(curve))
    }

    fn way_back(&mut self, from: u32, to: u32, walk: &[u32]) -> Option<Vec<u32>> {
        let walked: std::collections::HashSet<u32> =
            walk.iter().copied().filter(|&v| v != to).collect();
        self.back.start(&[from]);
        while let Some((v, length)) = self.back.next() {
            if v == to {
                return Some(self.back.path(v));
            }
            for (u, edge) in self.graph.neighbours(v) {
                if !walked.contains(&u) {
                    self.back.relax(v, u, length + edge, 0.0);
                }
            }
        }
        None
    }
}

/// Returns a random number below n, which is not 0.
fn below(rng: &mut Rng, n: usize) -> usize {
    (rng.bits() % n as u64) as usize
}

/// The method by which samples are selected from the vertices of a curve.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Sampling {
    /// The same number of steps between successive samples (up to rounding).
    Even,
    /// Each vertex with the same probability.
    Random,
}

/// Samples of a curve, in random order.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Samples {
    /// Vertices, in random order.
    pub vertices: Vec<u32>,
    /// The order of the samples on the curve, as indices of `vertices`.
    pub order: Vec<u32>,
}

/// Returns k samples of a curve, at most as many as it has vertices.
///
/// ```
/// use catamaran::base::Rng;
/// use catamaran_geometry::curve::dataset::{Sampling, samples};
///
/// let curve: Vec<u32> = (100..120).collect();
/// let found = samples(&curve, 5, Sampling::Even, &mut Rng::new(1));
/// let ordered: Vec<u32> = found.order.iter().map(|&i| found.vertices[i as usize]).collect();
/// assert_eq!(ordered, [100, 104, 108, 112, 116]);
/// ```
pub fn samples(curve: &[u32], k: usize, sampling: Sampling, rng: &mut Rng) -> Samples {
    let n = curve.len();
    let k = k.min(n);
    let places: Vec<usize> = match sampling {
        Sampling::Even => (0..k).map(|i| i * n / k).collect(),
        Sampling::Random => {
            let mut all: Vec<usize> = (0..n).collect();
            shuffle(&mut all, rng);
            all.truncate(k);
            all.sort_unstable();
            all
        }
    };
    let mut shuffled: Vec<usize> = (0..k).collect();
    shuffle(&mut shuffled, rng);
    let mut order = vec![0; k];
    for (number, &place) in (0..).zip(&shuffled) {
        order[place] = number;
    }
    let vertices = shuffled.into_iter().map(|i| curve[places[i]]).collect();
    Samples { vertices, order }
}

/// Shuffles uniformly (Fisher and Yates).
fn shuffle(items: &mut [usize], rng: &mut Rng) {
    for i in (1..items.len()).rev() {
        items.swap(i, below(rng, i + 1));
    }
}

/// Returns the mesh scaled to the volume 1. A mesh that is not closed and oriented is scaled to the
/// surface area of a ball of volume 1.
///
/// ```
/// use catamaran_geometry::{curve::dataset::scaled, mesh::families};
///
/// assert!((scaled(&families::icosphere(2)?)?.volume().unwrap() - 1.0).abs() < 1e-12);
/// # Ok::<(), catamaran::Error>(())
/// ```
///
/// # Errors
/// [`Error::Mesh`](catamaran::Error::Mesh) when the coordinates are not finite afterwards, as for a
/// mesh without area.
pub fn scaled(mesh: &TriMesh) -> Result<TriMesh> {
    let factor = match mesh.volume().map(f64::abs) {
        Some(volume) if volume > 0.0 => (1.0 / volume).cbrt(),
        _ => {
            let ball = (36.0 * std::f64::consts::PI).cbrt();
            (ball / mesh.area()).sqrt()
        }
    };
    let vertices = mesh.vertices().iter().map(|p| p.map(|x| x * factor)).collect();
    TriMesh::new(vertices, mesh.faces().to_vec())
}
