use std::cmp::Reverse;
use std::collections::BinaryHeap;

use super::glued::{Glued, Unfolded};
use crate::mesh::slots::{next, previous};
use catamaran::base::{Error, Result, repeated, spend};

/// Rounding errors of places and lengths, relative to the distance from the source of a window.
const ROUNDING: f64 = 1e-12;

/// Operations that a step of the propagation is equal to.
const STEP: f64 = 300.0;

/// The straight paths from one vertex through one sequence of faces, as far as the edge of a slot,
/// into whose face they go on. The faces are unfolded into the plane of [`Unfolded`].
#[derive(Debug, Clone, Copy)]
pub(super) struct Window {
    pub slot: u32,
    /// The part of the edge that the paths cross: places along it.
    pub ends: [f64; 2],
    /// Where the paths start, at `(x, -y)`, with y > 0.
    pub source: [f64; 2],
    /// The vertex at which the paths start.
    pub origin: u32,
    /// The distance of that vertex from the sources.
    pub distance: f64,
    /// The window before, through whose face the paths came; `None` for the first face.
    pub before: Option<usize>,
}

impl Window {
    /// Returns the same window with the ends of its edge, of this length, exchanged.
    fn reversed(self, length: f64) -> Self {
        let ([p, q], [x, y]) = (self.ends, self.source);
        Self { ends: [length - q, length - p], source: [length - x, y], ..self }
    }
}

/// How the shortest path known reaches a vertex.
#[derive(Debug, Clone, Copy)]
pub(super) enum Arrival {
    /// None is known.
    Unreached,
    /// The vertex is a source.
    Source,
    /// Along the edge of `slot` from the vertex `from`.
    Edge { slot: u32, from: u32 },
    /// Over the face of `slot`, whose third corner it is, from the `source` of the window of this
    /// number.
    Face { slot: u32, source: [f64; 2], number: usize },
}

#[derive(Debug, Clone, Copy)]
struct Label {
    distance: f64,
    arrival: Arrival,
    settled: bool,
}

#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
enum Event {
    Vertex(u32),
    Window(usize),
}

/// Exact distances by windows that propagate from face to face, the nearest first.
///
/// Windows are those of Mitchell, Mount and Papadimitriou (1987). Of several windows that reach the
/// third corner of a face through the same edge, only the nearest splits there (Chen and Han 1990),
/// and windows that are farther than known paths over a corner are dropped (Xin and Wang 2009).
#[derive(Debug)]
pub(super) struct Windows<'g, 'm> {
    glued: &'g Glued<'m>,
    labels: Vec<Label>,
    /// For each slot the nearest window that reaches the third corner of the face: the distance,
    /// and where its path crosses the edge.
    nearest: Vec<(f64, f64)>,
    /// The windows; those of `free` are over.
    windows: Vec<Window>,
    free: Vec<usize>,
    /// Whether windows that are over are kept, for paths.
    keep: bool,
    /// Least distances, as bits, which have the order of non-negative numbers.
    queue: BinaryHeap<Reverse<(u64, Event)>>,
}

impl<'g, 'm> Windows<'g, 'm> {
    /// Propagates windows from the `sources`; with a `target`, until its distance is final, and all
    /// windows are kept.
    ///
    /// # Errors
    /// [`Error::Argument`] names a source out of range; [`Error::OutOfMemory`];
    /// [`Error::Cancelled`].
    pub fn propagate(glued: &'g Glued<'m>, sources: &[u32], target: Option<u32>) -> Result<Self> {
        let n = glued.mesh().vertices().len();
        let unreached =
            Label { distance: f64::INFINITY, arrival: Arrival::Unreached, settled: false };
        let mut all = Self {
            glued,
            labels: repeated(unreached, n)?,
            nearest: repeated((f64::INFINITY, 0.0), 3 * glued.mesh().faces().len())?,
            windows: Vec::new(),
            free: Vec::new(),
            keep: target.is_some(),
            queue: BinaryHeap::new(),
        };
        for &v in sources {
            if v as usize >= n {
                let why = format!("vertex {v} is out of range: {n} vertices, numbered from 0");
                return Err(Error::Argument { what: "sources", why });
            }
            all.offer(v, 0.0, Arrival::Source);
        }
        all.run(target)?;
        Ok(all)
    }

    /// Returns the distance of a vertex, infinite if no path leads there.
    pub fn distance(&self, vertex: u32) -> f64 {
        self.labels[vertex as usize].distance
    }

    /// Returns how the shortest path reaches a vertex.
    pub fn arrival(&self, vertex: u32) -> Arrival {
        self.labels[vertex as usize].arrival
    }

    /// Returns a window by its number.
    pub fn window(&self, number: usize) -> &Window {
        &self.windows[number]
    }

    fn run(&mut self, target: Option<u32>) -> Result<()> {
        while let Some(Reverse((_, event))) = self.queue.pop() {
            spend(STEP)?;
            match event {
                Event::Vertex(v) => {
                    let label = &mut self.labels[v as usize];
                    if label.settled {
                        continue;
                    }
                    label.settled = true;
                    if target == Some(v) {
                        return Ok(());
                    }
                    self.leave(v);
                }
                Event::Window(number) => self.cross(number),
            }
        }
        Ok(())
    }

    fn offer(&mut self, vertex: u32, distance: f64, arrival: Arrival) {
        let label = &mut self.labels[vertex as usize];
        if !label.settled && distance < label.distance {
            (label.distance, label.arrival) = (distance, arrival);
            self.queue.push(Reverse((distance.to_bits(), Event::Vertex(vertex))));
        }
    }

    /// Leads paths on from a vertex: along its edges, and into the faces where a shortest path can
    /// have a corner at the vertex.
    fn leave(&mut self, v: u32) {
        let glued = self.glued;
        let Label { distance, arrival, .. } = self.labels[v as usize];
        for &corner in glued.slots_at(v) {
            for slot in [corner, previous(corner)] {
                let [tail, head] = [slot, next(slot)].map(|s| glued.tail(s));
                let other = if tail == v { head } else { tail };
                let arrival = Arrival::Edge { slot, from: v };
                self.offer(other, distance + glued.length(slot), arrival);
            }
        }
        match arrival {
            Arrival::Unreached => {}
            Arrival::Source => glued.slots_at(v).iter().for_each(|&corner| self.enter(corner)),
            Arrival::Edge { slot, .. } => {
                glued.beyond(v, slot, 0.0, &mut |corner| self.enter(corner));
            }
            Arrival::Face { slot, source: [x, y], .. } => {
                // The angle at the third corner from the first one to the source.
                let [cx, cy] = glued.unfolded(slot).apex;
                let (to_first, to_source) = ([-cx, -cy], [x - cx, -y - cy]);
                let turned = to_first[0] * to_source[1] - to_first[1] * to_source[0];
                let along = to_first[0] * to_source[0] + to_first[1] * to_source[1];
                let angle = turned.abs().atan2(along);
                glued.beyond(v, previous(slot), angle, &mut |corner| self.enter(corner));
            }
        }
    }

    /// Adds the window from the vertex where a slot starts over the face of the slot.
    fn enter(&mut self, corner: u32) {
        let glued = self.glued;
        let (slot, origin) = (next(corner), glued.tail(corner));
        let Unfolded { length, apex } = glued.unfolded(slot);
        // Over a face without area, paths run along edges.
        if apex[1] > 0.0 {
            let distance = self.distance(origin);
            let ends = [0.0, length];
            let window = Window { slot, ends, source: apex, origin, distance, before: None };
            self.add(glued.tail(slot), length, window);
        }
    }

    /// Adds a window that leaves the face of its slot, whose places are counted from the vertex
    /// `start`, in all faces on the other side of the edge.
    fn add(&mut self, start: u32, length: f64, window: Window) {
        let glued = self.glued;
        let ([p, q], [x, y]) = (window.ends, window.source);
        let least = window.distance + (x.max(p).min(q) - x).hypot(y);
        for slot in glued.across(window.slot) {
            let way = if glued.tail(slot) == start { window } else { window.reversed(length) };
            let window = Window { slot, ..way };
            let number = match self.free.pop() {
                Some(number) => {
                    self.windows[number] = window;
                    number
                }
                None => {
                    self.windows.push(window);
                    self.windows.len() - 1
                }
            };
            self.queue.push(Reverse((least.to_bits(), Event::Window(number))));
        }
    }

    /// Leads the paths of a window over the face of its slot.
    fn cross(&mut self, number: usize) {
        let glued = self.glued;
        let window = self.windows[number];
        let face = glued.unfolded(window.slot);
        let ([p, q], [x, y], [cx, cy]) = (window.ends, window.source, face.apex);
        let first = glued.tail(window.slot);
        let second = glued.tail(next(window.slot));
        let third = glued.tail(previous(window.slot));
        // Where the path to the third corner crosses the edge. A path at either end of the window
        // counts as one of both neighbours, so that rounding leaves no gap.
        let crossing = x + (cx - x) * (y / (y + cy));
        let slack = ROUNDING * (face.length + x.abs() + y);
        let (mut left, mut right) = (p < crossing - slack, crossing + slack < q);
        let reaches = p - slack <= crossing && crossing <= q + slack;
        if reaches {
            let distance = window.distance + (cx - x).hypot(cy + y);
            let nearest = &mut self.nearest[window.slot as usize];
            if distance <= nearest.0 * (1.0 + ROUNDING) {
                if distance < nearest.0 {
                    *nearest = (distance, crossing);
                }
            } else if crossing < nearest.1 {
                right = false;
            } else {
                left = false;
            }
            let Window { slot, source, .. } = window;
            self.offer(third, distance, Arrival::Face { slot, source, number });
        }
        let on = Window { before: Some(number), ..window };
        if left {
            let on = Window { slot: previous(window.slot), ..on };
            self.pass(on, [first, second, third], face, reaches);
        }
        if right {
            let on = Window { slot: next(window.slot), ..on.reversed(face.length) };
            self.pass(on, [second, first, third], face.reversed(), reaches);
        }
        if !self.keep {
            self.free.push(number);
        }
    }

    /// Adds the part of a window that leaves a face over the edge from the first to the third
    /// corner, which is the edge of its slot; `face` is unfolded along the edge from the first to
    /// the second. The part ends at the third corner, if the window `reaches` it.
    fn pass(&mut self, window: Window, corners: [u32; 3], face: Unfolded, reaches: bool) {
        let ([p, q], [x, y], [cx, cy]) = (window.ends, window.source, face.apex);
        let side = cx.hypot(cy);
        // The place on the side that is straight behind a place on the edge.
        let behind = |place: f64| {
            let slope = cx * y - cy * (place - x);
            if slope > 0.0 { side * (y * place / slope).clamp(0.0, 1.0) } else { side }
        };
        let (p, q) = (behind(p), if reaches { side } else { behind(q) });
        let source = [(cx * x - cy * y) / side, (cx * y + cy * x) / side];
        if p >= q || source[1] <= 0.0 {
            return;
        }
        // Dropped if a path over one of the corners, along an edge or across the face, cuts off all
        // of the window and is shorter.
        let far = |place: f64| {
            let length = (place - source[0]).hypot(source[1]);
            (window.distance + length) * (1.0 - ROUNDING)
        };
        let [first, second, third] = corners.map(|v| self.distance(v));
        let across = (face.length - p * (cx / side)).hypot(p * (cy / side));
        let is_farther =
            first + q < far(q) || third + (side - p) < far(p) || second + across < far(p);
        if !is_farther {
            self.add(corners[0], side, Window { ends: [p, q], source, ..window });
        }
    }
}
