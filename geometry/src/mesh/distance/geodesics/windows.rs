use std::cmp::Reverse;
use std::collections::BinaryHeap;

use super::glued::{Glued, Unfolded};
use super::places::{Place, Spot};
use crate::mesh::SurfacePoint;
use crate::mesh::slots::{next, previous};
use catamaran::base::{Result, repeated, spend};

/// Rounding errors of places and lengths, relative to the distance from the source of a window.
const ROUNDING: f64 = 1e-12;

/// Operations that a step of the propagation is equal to.
const STEP: f64 = 300.0;

/// The straight paths from one node through one sequence of faces, as far as the edge of a slot,
/// into whose face they go on. The faces are unfolded into the plane of [`Unfolded`].
#[derive(Debug, Clone, Copy)]
pub(super) struct Window {
    pub slot: u32,
    /// The part of the edge that the paths cross: places along it.
    pub ends: [f64; 2],
    /// Where the paths start, at `(x, -y)`. y is positive, or 0 for a start on the edge itself,
    /// with a face without area between.
    pub source: [f64; 2],
    /// The node at which the paths start.
    pub origin: u32,
    /// The distance of that node from the sources.
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

/// Returns the place on an edge where the straight line from the source of a window crosses it to
/// `end`, in the face of the window.
pub(super) fn crossing([x, y]: [f64; 2], end: [f64; 2]) -> f64 {
    // From a source on the edge no line crosses it elsewhere, also not along the edge.
    if y > 0.0 { x + (end[0] - x) * (y / (y + end[1])) } else { x }
}

/// How the shortest path known reaches a node.
#[derive(Debug, Clone, Copy)]
pub(super) enum Arrival {
    /// None is known.
    Unreached,
    /// The node is a source.
    Source,
    /// Along the edge of `slot` from the vertex `from`.
    Edge { slot: u32, from: u32 },
    /// Straight from the node `from`, over the face of `slot`. A vertex is where the slot starts,
    /// and sees `from` at this angle from the edge of the slot.
    Direct { slot: u32, angle: f64, from: u32 },
    /// Over the face of `slot` from the `source` of the window of this number; a vertex is the
    /// third corner of the face.
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
    Node(u32),
    Window(usize),
}

/// Exact distances by windows that propagate from face to face, the nearest first.
///
/// Windows are those of Mitchell, Mount and Papadimitriou (1987). Of several windows that reach the
/// third corner of a face through the same edge, only the nearest splits there (Chen and Han 1990),
/// and windows that are farther than known paths over a corner are dropped (Xin and Wang 2009).
///
/// Nodes are the vertices, by their numbers, and after them the sources and the target that are not
/// at vertices.
#[derive(Debug)]
pub(super) struct Windows<'g, 'm> {
    glued: &'g Glued<'m>,
    /// The nodes after the vertices.
    places: Vec<Place>,
    target: Option<u32>,
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
    /// [`Error::OutOfMemory`](catamaran::Error::OutOfMemory) and
    /// [`Error::Cancelled`](catamaran::Error::Cancelled).
    pub fn propagate(
        glued: &'g Glued<'m>,
        sources: &[Spot],
        target: Option<&Spot>,
    ) -> Result<Self> {
        let vertices = glued.mesh().vertices().len();
        let mut places: Vec<Place> = Vec::new();
        let mut node = |spot: &Spot| match spot {
            Spot::Vertex(v) => *v,
            Spot::Place(place) => {
                places.push(place.clone());
                (vertices + places.len() - 1) as u32
            }
        };
        let starts: Vec<u32> = sources.iter().map(&mut node).collect();
        let target = target.map(node);
        let unreached =
            Label { distance: f64::INFINITY, arrival: Arrival::Unreached, settled: false };
        let mut all = Self {
            glued,
            labels: repeated(unreached, vertices + places.len())?,
            places,
            target,
            nearest: repeated((f64::INFINITY, 0.0), 3 * glued.mesh().faces().len())?,
            windows: Vec::new(),
            free: Vec::new(),
            keep: target.is_some(),
            queue: BinaryHeap::new(),
        };
        for start in starts {
            all.offer(start, 0.0, Arrival::Source);
        }
        all.run()?;
        Ok(all)
    }

    /// Returns the node of the target.
    pub fn target(&self) -> Option<u32> {
        self.target
    }

    /// Returns the distance of a node, infinite if no path leads there.
    pub fn distance(&self, node: u32) -> f64 {
        self.labels[node as usize].distance
    }

    /// Returns how the shortest path reaches a node.
    pub fn arrival(&self, node: u32) -> Arrival {
        self.labels[node as usize].arrival
    }

    /// Returns the place of a node, `None` for a vertex.
    pub fn place(&self, node: u32) -> Option<&Place> {
        (node as usize).checked_sub(self.glued.mesh().vertices().len()).map(|i| &self.places[i])
    }

    /// Returns the target and its point in this face, if it is not a vertex, and the face has it.
    fn target_in(&self, face: u32) -> Option<(u32, SurfacePoint)> {
        let target = self.target?;
        Some((target, self.place(target)?.within(face)?))
    }

    /// Returns a window by its number.
    pub fn window(&self, number: usize) -> &Window {
        &self.windows[number]
    }

    fn run(&mut self) -> Result<()> {
        while let Some(Reverse((_, event))) = self.queue.pop() {
            spend(STEP)?;
            match event {
                Event::Node(v) => {
                    let label = &mut self.labels[v as usize];
                    if label.settled {
                        continue;
                    }
                    label.settled = true;
                    if self.target == Some(v) {
                        return Ok(());
                    }
                    self.leave(v);
                }
                Event::Window(number) => self.cross(number),
            }
        }
        Ok(())
    }

    fn offer(&mut self, node: u32, distance: f64, arrival: Arrival) {
        let label = &mut self.labels[node as usize];
        if !label.settled && distance < label.distance {
            (label.distance, label.arrival) = (distance, arrival);
            self.queue.push(Reverse((distance.to_bits(), Event::Node(node))));
        }
    }

    /// Leads paths on from a node.
    fn leave(&mut self, node: u32) {
        match self.place(node).cloned() {
            Some(place) => self.set_out(node, &place),
            None => self.leave_vertex(node),
        }
    }

    /// Leads paths from a source that is not at a vertex over its faces.
    fn set_out(&mut self, node: u32, place: &Place) {
        let glued = self.glued;
        let distance = self.distance(node);
        for point in &place.faces {
            for slot in [0, 1, 2].map(|corner| 3 * point.face + corner) {
                let [x, y] = glued.local(slot, point.weights);
                let arrival = Arrival::Direct { slot, angle: y.atan2(x), from: node };
                self.offer(glued.tail(slot), distance + x.hypot(y), arrival);
                let length = glued.length(slot);
                if y > 0.0 || (glued.is_flat(slot) && x > 0.0 && x < length) {
                    let (ends, source) = ([0.0, length], [x, y]);
                    let window =
                        Window { slot, ends, source, origin: node, distance, before: None };
                    self.add(glued.tail(slot), length, window);
                }
            }
            if let Some((target, other)) = self.target_in(point.face) {
                let slot = 3 * point.face;
                let [from, to] = [*point, other].map(|point| glued.local(slot, point.weights));
                let apart = (to[0] - from[0]).hypot(to[1] - from[1]);
                let arrival = Arrival::Direct { slot, angle: 0.0, from: node };
                self.offer(target, distance + apart, arrival);
            }
        }
    }

    /// Leads paths on from a vertex: along its edges, and into the faces where a shortest path can
    /// have a corner at the vertex.
    fn leave_vertex(&mut self, v: u32) {
        let glued = self.glued;
        let Label { distance, arrival, .. } = self.labels[v as usize];
        for &corner in glued.slots_at(v) {
            for slot in [corner, previous(corner)] {
                let [tail, head] = [slot, next(slot)].map(|s| glued.tail(s));
                let other = if tail == v { head } else { tail };
                let arrival = Arrival::Edge { slot, from: v };
                self.offer(other, distance + glued.length(slot), arrival);
            }
            if let Some((target, point)) = self.target_in(corner / 3) {
                let [x, y] = glued.local(corner, point.weights);
                let arrival = Arrival::Direct { slot: corner, angle: y.atan2(x), from: v };
                self.offer(target, distance + x.hypot(y), arrival);
            }
        }
        match arrival {
            Arrival::Unreached => {}
            Arrival::Source => glued.slots_at(v).iter().for_each(|&corner| self.enter(corner)),
            Arrival::Edge { slot, .. } => {
                glued.beyond(v, slot, 0.0, &mut |corner| self.enter(corner));
            }
            Arrival::Direct { slot, angle, .. } => {
                glued.beyond(v, slot, angle, &mut |corner| self.enter(corner));
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
        // Over a face without area, paths run along edges, unless the vertex is on the other edge.
        if apex[1] > 0.0 || (apex[0] > 0.0 && apex[0] < length) {
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
        let crossing = crossing([x, y], [cx, cy]);
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
        if let Some((target, point)) = self.target_in(window.slot / 3) {
            let [tx, ty] = glued.local(window.slot, point.weights);
            let at = self::crossing([x, y], [tx, ty]);
            if p - slack <= at && at <= q + slack {
                let Window { slot, source, .. } = window;
                let distance = window.distance + (tx - x).hypot(ty + y);
                self.offer(target, distance, Arrival::Face { slot, source, number });
            }
        }
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
