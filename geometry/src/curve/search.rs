use std::cmp::Reverse;
use std::collections::BinaryHeap;

use catamaran::base::{Result, count, reserved};

/// Marks the absence of a vertex.
const NONE: u32 = u32::MAX;

/// The state of a vertex, which belongs to the current search only if `stamp` says so.
#[derive(Debug, Clone, Copy)]
struct Label {
    distance: f64,
    predecessor: u32,
    origin: u32,
    /// Twice the number of the search, plus one when the distance is final.
    stamp: u64,
}

const BLANK: Label = Label { distance: f64::INFINITY, predecessor: NONE, origin: NONE, stamp: 0 };

/// Operations that a step of a search is equal to: it waits for memory.
const STEP: f64 = 100.0;

/// A search for shortest paths (Dijkstra 1959) that the caller drives: [`Search::next`] returns the
/// next vertex, and the caller passes its neighbours, with any cost, to [`Search::relax`]. A new
/// search starts in constant time.
pub(super) struct Search {
    labels: Vec<Label>,
    current: u64,
    /// Estimated lengths of whole paths, as bits, which have the order of non-negative numbers;
    /// equal lengths are ordered by vertex.
    heap: BinaryHeap<Reverse<(u64, u32)>>,
    settled: usize,
}

impl Search {
    /// Creates a search over this number of vertices.
    ///
    /// # Errors
    /// [`Error::OutOfMemory`](catamaran::Error::OutOfMemory).
    pub fn new(vertices: usize) -> Result<Self> {
        let mut labels = reserved(vertices)?;
        labels.resize(vertices, BLANK);
        Ok(Self { labels, current: 0, heap: BinaryHeap::new(), settled: 0 })
    }

    /// Allocates state for vertices that a refinement added.
    pub fn grow(&mut self, vertices: usize) {
        if vertices > self.labels.len() {
            self.labels.resize(vertices, BLANK);
        }
    }

    /// Returns the number of vertices settled by all searches.
    pub fn settled(&self) -> usize {
        self.settled
    }

    /// Starts a new search from these vertices; the origin of a path is the index of its source in
    /// the list.
    pub fn start(&mut self, sources: &[u32]) {
        self.current += 2;
        self.heap.clear();
        for (origin, &v) in (0..).zip(sources) {
            self.labels[v as usize] =
                Label { distance: 0.0, predecessor: NONE, origin, stamp: self.current };
            self.heap.push(Reverse((0.0_f64.to_bits(), v)));
        }
    }

    /// Returns the next vertex whose distance is final, and the distance.
    pub fn next(&mut self) -> Option<(u32, f64)> {
        while let Some(Reverse((_, v))) = self.heap.pop() {
            count(STEP);
            let label = &mut self.labels[v as usize];
            if label.stamp == self.current {
                label.stamp = self.current + 1;
                self.settled += 1;
                return Some((v, label.distance));
            }
        }
        None
    }

    /// Offers a path of this length to `vertex` by way of `from`. `rest` is a lower bound of the
    /// remaining length from `vertex` to the target of the search (Hart, Nilsson and Raphael 1968),
    /// which must be consistent along edges; 0 without a target.
    pub fn relax(&mut self, from: u32, vertex: u32, distance: f64, rest: f64) {
        let origin = self.labels[from as usize].origin;
        let current = self.current;
        let label = &mut self.labels[vertex as usize];
        let better = if label.stamp >= current {
            label.stamp == current && distance < label.distance
        } else {
            true
        };
        if better {
            *label = Label { distance, predecessor: from, origin, stamp: current };
            self.heap.push(Reverse(((distance + rest).to_bits(), vertex)));
        }
    }

    /// Returns the distance and the origin of a vertex; `None` unless they are final.
    pub fn known(&self, vertex: u32) -> Option<(f64, u32)> {
        let label = self.labels[vertex as usize];
        (label.stamp == self.current + 1).then_some((label.distance, label.origin))
    }

    /// Returns the path to a reached vertex from its source, both included.
    pub fn path(&self, vertex: u32) -> Vec<u32> {
        let mut path = vec![vertex];
        let mut at = vertex;
        while self.labels[at as usize].predecessor != NONE {
            at = self.labels[at as usize].predecessor;
            path.push(at);
        }
        path.reverse();
        path
    }
}
