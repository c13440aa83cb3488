use std::cmp::Reverse;
use std::collections::BinaryHeap;
use std::iter::successors;

use catamaran::base::{Result, count, reserved};

/// Marks the absence of a vertex.
pub(super) const NONE: u32 = u32::MAX;

/// The state of a vertex, which belongs to the current search only if `stamp` says so.
#[derive(Debug, Clone, Copy)]
struct Label {
    distance: f64,
    predecessor: u32,
    origin: u32,
    /// Twice the number of the search, from 1, plus one when the distance is final.
    stamp: u64,
}

const BLANK: Label = Label { distance: f64::INFINITY, predecessor: NONE, origin: NONE, stamp: 0 };

/// Operations that a step of a search is equal to: it waits for memory.
const STEP: f64 = 100.0;

/// A search for shortest paths (Dijkstra 1959) that the caller drives: [`Search::next`] returns the
/// next vertex, and the caller passes its neighbours, with any cost, to [`Search::relax`]. A new
/// search starts in constant time.
#[derive(Debug, Clone)]
pub(crate) struct Search {
    labels: Vec<Label>,
    current: u64,
    /// Estimated lengths of whole paths, as bits, which have the order of non-negative numbers;
    /// equal lengths are ordered by vertex.
    heap: BinaryHeap<Reverse<(u64, u32)>>,
    settled: usize,
}

impl Default for Search {
    fn default() -> Self {
        Self { labels: Vec::new(), current: 2, heap: BinaryHeap::new(), settled: 0 }
    }
}

impl Search {
    /// Creates a search over this number of vertices.
    ///
    /// # Errors
    /// [`Error::OutOfMemory`](catamaran::Error::OutOfMemory).
    pub fn new(vertices: usize) -> Result<Self> {
        let mut search = Self { labels: reserved(vertices)?, ..Self::default() };
        search.grow(vertices);
        Ok(search)
    }

    /// Allocates state for more vertices, such as those that a refinement added.
    pub fn grow(&mut self, vertices: usize) {
        if vertices > self.labels.len() {
            self.labels.resize(vertices, BLANK);
        }
    }

    /// Returns the number of vertices settled by all searches.
    pub fn settled(&self) -> usize {
        self.settled
    }

    /// Forgets the search.
    pub fn clear(&mut self) {
        self.current += 2;
        self.heap.clear();
    }

    /// Starts a new search from these vertices; the origin of a path is the index of its source in
    /// the list.
    pub fn start(&mut self, sources: &[u32]) {
        self.clear();
        for (origin, &v) in (0..).zip(sources) {
            self.offer(v, 0.0, 0.0, NONE, origin);
        }
    }

    /// Ends the search: forgets the vertices whose distance is not final.
    pub fn stop(&mut self) {
        for Reverse((_, v)) in self.heap.drain() {
            let label = &mut self.labels[v as usize];
            if label.stamp == self.current {
                *label = BLANK;
            }
        }
    }

    /// Returns the next vertex whose distance is final, and the distance.
    #[inline]
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
    #[inline]
    pub fn relax(&mut self, from: u32, vertex: u32, distance: f64, rest: f64) {
        if self.labels[vertex as usize].stamp != self.current + 1 {
            self.offer(vertex, distance, rest, from, self.labels[from as usize].origin);
        }
    }

    /// Offers a path of this length from `origin` to `vertex` by way of `from`, [`NONE`] at the
    /// source itself. Unlike [`Search::relax`], it also changes final distances, which new sources
    /// can shorten.
    #[inline]
    pub fn offer(&mut self, vertex: u32, distance: f64, rest: f64, from: u32, origin: u32) {
        let label = &mut self.labels[vertex as usize];
        if label.stamp < self.current || distance < label.distance {
            *label = Label { distance, predecessor: from, origin, stamp: self.current };
            self.heap.push(Reverse(((distance + rest).to_bits(), vertex)));
        }
    }

    /// Returns the distance and the origin of a vertex; `None` unless they are final.
    #[inline]
    pub fn known(&self, vertex: u32) -> Option<(f64, u32)> {
        self.label(vertex).map(|label| (label.distance, label.origin))
    }

    /// Returns the vertex before this one on its path; `None` for sources and for vertices whose
    /// distance is not final.
    pub fn predecessor(&self, vertex: u32) -> Option<u32> {
        self.label(vertex).map(|label| label.predecessor).filter(|&v| v != NONE)
    }

    /// Returns the path to a vertex from its source, both included; empty unless it is final.
    pub fn path(&self, vertex: u32) -> Vec<u32> {
        let end = self.label(vertex).map(|_| vertex);
        let mut path: Vec<u32> = successors(end, |&v| self.predecessor(v)).collect();
        path.reverse();
        path
    }

    fn label(&self, vertex: u32) -> Option<&Label> {
        self.labels.get(vertex as usize).filter(|label| label.stamp == self.current + 1)
    }
}
