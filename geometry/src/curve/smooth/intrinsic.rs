use std::f64::consts::PI;

use crate::mesh::slots::{self, NONE, next, previous};
use crate::mesh::vector::distance;
use crate::mesh::{Edges, TriMesh};

/// The side of a joint with its smaller wedge, counter-clockwise.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Side {
    /// From the first slot to the second.
    FromFirst,
    /// From the second to the first.
    FromSecond,
}

/// A triangulation of the surface by straight lines, represented by their lengths and by their
/// directions at vertices (Sharp, Soliman and Crane, Navigating Intrinsic Triangulations, 2019).
pub(super) struct Intrinsic {
    faces: Vec<[u32; 3]>,
    twins: Vec<u32>,
    lengths: Vec<f64>,
    /// The angle of each slot at its tail, counter-clockwise from a fixed slot.
    directions: Vec<f64>,
    edges: Vec<u32>,
    /// One slot of each edge.
    slots: Vec<u32>,
    flipped: Vec<bool>,
    /// The angle around each vertex.
    totals: Vec<f64>,
    /// Whether each vertex is on the boundary.
    open: Vec<bool>,
}

impl Intrinsic {
    /// Creates the triangulation of the faces themselves, which must be manifold and oriented.
    pub fn new(mesh: &TriMesh, edges: &Edges) -> Self {
        let tails = mesh.faces().as_flattened();
        let p = mesh.vertices();
        let of_corners = edges.of_corners().to_vec();
        let mut twins = vec![NONE; tails.len()];
        let mut slots = Vec::with_capacity(edges.len());
        for row in edges.corners().rows() {
            slots.push(row[0]);
            if let &[s, t] = row {
                twins[s as usize] = t;
                twins[t as usize] = s;
            }
        }
        let length =
            |s: u32| distance(p[tails[s as usize] as usize], p[tails[next(s) as usize] as usize]);
        let lengths = (0..tails.len() as u32).map(length).collect();
        let count = slots.len();
        let mut all = Self {
            twins,
            lengths,
            directions: vec![f64::NAN; tails.len()],
            edges: of_corners,
            slots,
            flipped: vec![false; count],
            totals: vec![0.0; p.len()],
            open: vec![false; p.len()],
            faces: mesh.faces().to_vec(),
        };
        all.lay_directions();
        all
    }

    fn lay_directions(&mut self) {
        let all = 0..self.twins.len() as u32;
        // At the boundary, the angles start at the slot without a predecessor, elsewhere at any
        // slot.
        let first = all.clone().filter(|&s| self.twins[s as usize] == NONE).collect::<Vec<_>>();
        for &s in &first {
            let tail = self.tail(s);
            self.open[tail as usize] = true;
        }
        for start in first.into_iter().chain(all) {
            if !self.directions[start as usize].is_nan() {
                continue;
            }
            let (mut s, mut angle) = (start, 0.0);
            while s != NONE && self.directions[s as usize].is_nan() {
                self.directions[s as usize] = angle;
                angle += self.corner(s);
                s = self.twins[previous(s) as usize];
            }
            let tail = self.tail(start);
            self.totals[tail as usize] = angle;
        }
    }

    /// Returns the angle at the tail of a slot in its face.
    pub fn corner(&self, s: u32) -> f64 {
        let [a, b, c] = [s, next(s), previous(s)].map(|s| self.lengths[s as usize]);
        angle(a, c, b)
    }

    /// Returns the directions of all slots at their tails.
    pub fn directions(&self) -> &[f64] {
        &self.directions
    }

    /// Returns the opposite slots of all slots.
    pub fn twins(&self) -> &[u32] {
        &self.twins
    }

    /// Returns the direction of a slot at its tail.
    pub fn direction(&self, slot: u32) -> f64 {
        self.directions[slot as usize]
    }

    /// Returns the length of a slot.
    pub fn length(&self, slot: u32) -> f64 {
        self.lengths[slot as usize]
    }

    /// Returns the angle around a vertex.
    pub fn total(&self, vertex: u32) -> f64 {
        self.totals[vertex as usize]
    }

    /// Returns whether an edge is an edge of the mesh.
    pub fn is_original(&self, edge: u32) -> bool {
        !self.flipped[edge as usize]
    }

    /// Returns the slot of an edge that starts at a vertex; on the boundary, where it may not
    /// exist, returns a slot of the face beside it.
    pub fn slot(&self, edge: u32, tail: u32) -> u32 {
        let slot = self.slots[edge as usize];
        let twin = self.twins[slot as usize];
        if self.tail(slot) != tail && twin != NONE { twin } else { slot }
    }

    /// Returns the other end of an edge.
    pub fn other_end(&self, edge: u32, vertex: u32) -> u32 {
        let slot = self.slots[edge as usize];
        let [a, b] = [slot, next(slot)].map(|s| self.tail(s));
        if a == vertex { b } else { a }
    }

    /// Returns the side on which two slots from one vertex enclose less than pi; `None` if they do
    /// not, or at the boundary, where paths stay.
    pub fn wedge(&self, first: u32, second: u32, straight: f64) -> Option<Side> {
        let v = self.tail(first);
        if v != self.tail(second) || self.open[v as usize] {
            return None;
        }
        let total = self.totals[v as usize];
        let ahead =
            (self.directions[second as usize] - self.directions[first as usize]).rem_euclid(total);
        let (angle, side) = if ahead <= total - ahead {
            (ahead, Side::FromFirst)
        } else {
            (total - ahead, Side::FromSecond)
        };
        (angle < PI - straight).then_some(side)
    }

    /// Flips edges at v between two of its edges, counter-clockwise, as long as the outer angle of
    /// one is less than pi, and returns the edges of the outer arc, from the end of the first edge
    /// on; `None` when an edge can't flip.
    pub fn flip_out(&mut self, v: u32, from: u32, to: u32, straight: f64) -> Option<Vec<u32>> {
        // Every flip removes one edge from the wedge, and adds none.
        'again: loop {
            let mut arc = Vec::new();
            let mut s = self.slot(from, v);
            loop {
                arc.push(self.edges[next(s) as usize]);
                let t = self.twins[previous(s) as usize];
                if t == NONE || arc.len() > self.twins.len() {
                    return None;
                }
                if self.edges[t as usize] == to {
                    return Some(arc);
                }
                // The angles at the far end, on both sides of the edge.
                let outer = self.corner(previous(s)) + self.corner(next(t));
                let inner = self.corner(s) + self.corner(t);
                if outer < PI - straight && inner < PI - straight && self.flip(t) {
                    continue 'again;
                }
                s = t;
            }
        }
    }

    /// Flips an interior edge in a convex quadrilateral, unless it would become a loop; returns
    /// whether it did.
    fn flip(&mut self, h: u32) -> bool {
        let t = self.twins[h as usize];
        if t == NONE || t / 3 == h / 3 {
            return false;
        }
        let [to_a, from_a, to_b, from_b] = [previous(h), next(t), previous(t), next(h)];
        let [c, d] = [to_a, to_b].map(|s| self.tail(s));
        if c == d {
            return false;
        }
        let [ca, ad, db, bc] = [to_a, from_a, to_b, from_b].map(|s| self.length(s));
        let at_a = self.corner(h) + self.corner(from_a);
        let length = (ca * ca + ad * ad - 2.0 * ca * ad * at_a.cos()).max(0.0).sqrt();
        let edge = self.edges[h as usize];
        // The new edge lies after c to a, and after d to b.
        let turned =
            |s: u32, by: f64| (self.direction(s) + by).rem_euclid(self.total(self.tail(s)));
        let at_c = turned(to_a, angle(ca, length, ad));
        let at_d = turned(to_b, angle(db, length, bc));
        let moved = slots::flip(&mut self.faces, &mut self.twins, h);
        let old = moved.map(|(s, _)| (self.edges[s as usize], self.length(s), self.direction(s)));
        for ((_, s), (edge, length, direction)) in moved.into_iter().zip(old) {
            self.set(s, edge, length, direction);
        }
        // Slot 0 of both triangles: from c to d, and back.
        self.set(h / 3 * 3, edge, length, at_c);
        self.set(t / 3 * 3, edge, length, at_d);
        self.flipped[edge as usize] = true;
        true
    }

    fn set(&mut self, s: u32, edge: u32, length: f64, direction: f64) {
        self.edges[s as usize] = edge;
        self.slots[edge as usize] = s;
        self.lengths[s as usize] = length;
        self.directions[s as usize] = direction;
    }

    fn tail(&self, s: u32) -> u32 {
        self.faces.as_flattened()[s as usize]
    }
}

/// Returns the angle between sides a and b of a triangle, opposite to c.
fn angle(a: f64, b: f64, c: f64) -> f64 {
    let cosine = (a * a + b * b - c * c) / (2.0 * a * b);
    if cosine.is_finite() { cosine.clamp(-1.0, 1.0).acos() } else { 0.0 }
}
