use super::Graph;
use super::search::{NONE, Search};
use catamaran::base::{Error, Result, ask};

/// Limits at which a search of [`Dijkstra`] stops; by default there are none.
///
/// ```
/// use catamaran_geometry::mesh::{Dijkstra, Graph, SearchLimits};
///
/// let graph = Graph::new(3, &[(0, 1, 1.0), (1, 2, 1.0)])?;
/// let mut search = Dijkstra::new(&graph);
/// search.search(&[(0, 0.0)], &SearchLimits { targets: &[1], ..SearchLimits::default() })?;
/// assert_eq!(search.distances(), [0.0, 1.0, f64::INFINITY]);
/// # Ok::<(), catamaran::Error>(())
/// ```
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct SearchLimits<'a> {
    /// Vertices farther than this are not reached; in units of length, default infinite.
    pub cutoff: f64,
    /// The search ends as soon as all of these vertices are reached. Empty by default: the search
    /// visits all vertices.
    pub targets: &'a [u32],
}

impl Default for SearchLimits<'_> {
    fn default() -> Self {
        Self { cutoff: f64::INFINITY, targets: &[] }
    }
}

/// Shortest paths along the edges of a graph from the nearest of several sources (Dijkstra 1959).
///
/// One solver serves many searches: a search starts in constant time, so that a local search costs
/// O(m log m) for m visited edges, whatever the size of the graph.
///
/// ```
/// use catamaran_geometry::mesh::{Dijkstra, Graph, SearchLimits};
///
/// let graph = Graph::new(3, &[(0, 1, 1.0), (1, 2, 2.0), (0, 2, 5.0)])?;
/// let mut search = Dijkstra::new(&graph);
/// search.search(&[(0, 0.0)], &SearchLimits::default())?;
/// assert_eq!((search.distance(2), search.path(2)), (3.0, vec![0, 1, 2]));
/// # Ok::<(), catamaran::Error>(())
/// ```
#[derive(Debug, Clone)]
pub struct Dijkstra<'g> {
    graph: &'g Graph,
    search: Search,
    is_target: Vec<bool>,
    /// Vertices whose distance is final, in the order in which they were reached.
    reached: Vec<u32>,
}

impl<'g> Dijkstra<'g> {
    /// Creates a solver for a graph. The solver takes 25 bytes for each vertex.
    pub fn new(graph: &'g Graph) -> Self {
        let mut search = Search::default();
        search.grow(graph.len());
        Self { graph, search, is_target: vec![false; graph.len()], reached: Vec::new() }
    }

    /// Forgets the previous search and starts from `sources`: vertices, each with an initial
    /// distance (usually 0).
    ///
    /// # Errors
    /// [`Error::Argument`] names a source or target out of range, a distance that is negative or
    /// not finite, or a cut-off that is negative or not a number; the solver is then in the state
    /// before any search.
    pub fn search(&mut self, sources: &[(u32, f64)], limits: &SearchLimits<'_>) -> Result<()> {
        self.reset();
        self.check(sources, limits)?;
        let mut missing = 0;
        for &target in limits.targets {
            let mark = &mut self.is_target[target as usize];
            missing += usize::from(!*mark);
            *mark = true;
        }
        self.start(sources, limits.cutoff);
        let done = self.run(limits.cutoff, (missing > 0).then_some(missing));
        self.search.stop();
        for &target in limits.targets {
            self.is_target[target as usize] = false;
        }
        done
    }

    /// Adds sources to those of the previous search, which must have had neither cut-off nor
    /// targets, and visits only the vertices that are nearer to the new sources, as farthest point
    /// sampling needs. Afterwards [`Dijkstra::reached`] returns those vertices, the nearest first.
    ///
    /// ```
    /// use catamaran_geometry::mesh::{Dijkstra, Graph, SearchLimits};
    ///
    /// let graph = Graph::new(4, &[(0, 1, 1.0), (1, 2, 1.0), (2, 3, 1.0)])?;
    /// let mut search = Dijkstra::new(&graph);
    /// search.search(&[(0, 0.0)], &SearchLimits::default())?;
    /// search.insert(&[(3, 0.0)])?;
    /// assert_eq!(search.distances(), [0.0, 1.0, 1.0, 0.0]);
    /// assert_eq!(search.reached(), [3, 2]);
    /// # Ok::<(), catamaran::Error>(())
    /// ```
    ///
    /// # Errors
    /// [`Error::Argument`] as in [`Dijkstra::search`]; nothing is changed then.
    pub fn insert(&mut self, sources: &[(u32, f64)]) -> Result<()> {
        let limits = SearchLimits::default();
        self.check(sources, &limits)?;
        self.reached.clear();
        self.start(sources, limits.cutoff);
        let done = self.run(limits.cutoff, None);
        if done.is_err() {
            self.reset();
        }
        done
    }

    /// Returns the distance of a vertex, infinite if the search did not reach it (or the graph does
    /// not have it).
    pub fn distance(&self, vertex: u32) -> f64 {
        self.search.known(vertex).map_or(f64::INFINITY, |known| known.0)
    }

    /// Returns the distances of all vertices, infinite for vertices that the search did not reach.
    pub fn distances(&self) -> Vec<f64> {
        (0..self.graph.len() as u32).map(|v| self.distance(v)).collect()
    }

    /// Returns the vertex before this one on its shortest path; `None` for sources and for vertices
    /// that the search did not reach.
    pub fn predecessor(&self, vertex: u32) -> Option<u32> {
        self.search.predecessor(vertex)
    }

    /// Returns the nearest source of a vertex, `None` if the search did not reach the vertex.
    pub fn origin(&self, vertex: u32) -> Option<u32> {
        self.search.known(vertex).map(|known| known.1)
    }

    /// Returns the vertices that the last search reached, the nearest first.
    pub fn reached(&self) -> &[u32] {
        &self.reached
    }

    /// Returns the shortest path to a vertex from its source, both included; empty if the search
    /// did not reach the vertex.
    pub fn path(&self, vertex: u32) -> Vec<u32> {
        self.search.path(vertex)
    }

    fn reset(&mut self) {
        self.search.clear();
        self.reached.clear();
    }

    fn check(&self, sources: &[(u32, f64)], limits: &SearchLimits<'_>) -> Result<()> {
        let n = self.graph.len();
        let there = |what, v: u32| {
            let why = || format!("vertex {v} is out of range: {n} vertices, numbered from 0");
            if (v as usize) < n { Ok(()) } else { Err(Error::Argument { what, why: why() }) }
        };
        for &(v, start) in sources {
            there("sources", v)?;
            if !(start >= 0.0 && start.is_finite()) {
                let why = format!("vertex {v} has distance {start}, must be finite and at least 0");
                return Err(Error::Argument { what: "sources", why });
            }
        }
        for &v in limits.targets {
            there("targets", v)?;
        }
        if limits.cutoff.is_nan() || limits.cutoff < 0.0 {
            let why = format!("must be at least 0, is {}", limits.cutoff);
            return Err(Error::Argument { what: "cutoff", why });
        }
        Ok(())
    }

    fn start(&mut self, sources: &[(u32, f64)], cutoff: f64) {
        for &(v, start) in sources {
            // Minus zero, which is allowed, has other bits than zero.
            let start = start + 0.0;
            if start <= cutoff {
                self.search.offer(v, start, 0.0, NONE, v);
            }
        }
    }

    /// Takes vertices in the order of their distance until none is left, or none of the `missing`
    /// targets.
    fn run(&mut self, cutoff: f64, mut missing: Option<usize>) -> Result<()> {
        while let Some((v, from)) = self.search.next() {
            ask()?;
            self.reached.push(v);
            if let Some(missing) = missing.as_mut().filter(|_| self.is_target[v as usize]) {
                *missing -= 1;
                if *missing == 0 {
                    return Ok(());
                }
            }
            let origin = self.origin(v).unwrap_or(NONE);
            for (neighbour, length) in self.graph.neighbours(v) {
                let through = from + length;
                // A sum that overflows reaches nothing.
                if through <= cutoff && through.is_finite() {
                    self.search.offer(neighbour, through, 0.0, v, origin);
                }
            }
        }
        Ok(())
    }
}
