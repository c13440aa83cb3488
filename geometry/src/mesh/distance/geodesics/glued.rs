use std::f64::consts::{PI, TAU};

use super::trace_end::TraceEnd;
use crate::mesh::slots::{next, previous};
use crate::mesh::topology::corners;
use crate::mesh::vector::{Vector, cross, dot, norm, scale, sub, unit};
use crate::mesh::{Adjacency, Edges, TriMesh};
use catamaran::base::{Error, Result};

/// Shortest edge, in the unit of the mesh: the squares of areas beside shorter ones underflow.
const SHORTEST: f64 = 1e-75;

/// Deviation of an angle from pi that counts as straight, in radians. A larger one costs windows
/// that lead nowhere, and changes no distance.
const STRAIGHT: f64 = 1e-6;

/// The vertices at which a shortest path can have a corner.
#[derive(Debug, Clone, Copy, PartialEq)]
enum Bend {
    /// The angle around the vertex is less than 2 pi: none.
    Nowhere,
    /// Inside the surface, with this angle around the vertex, at least 2 pi.
    Inside(f64),
    /// On the boundary.
    Boundary,
    /// The surface meets itself here, or three faces meet along an edge.
    Anywhere,
}

/// A face, unfolded into a plane: the edge of a slot goes from the origin to `(length, 0)`.
#[derive(Debug, Clone, Copy)]
pub(super) struct Unfolded {
    pub length: f64,
    /// The third corner, whose second coordinate is not negative.
    pub apex: [f64; 2],
}

impl Unfolded {
    /// Returns the same face with the ends of its edge exchanged.
    pub fn reversed(self) -> Self {
        let [x, y] = self.apex;
        Self { apex: [self.length - x, y], ..self }
    }
}

/// The faces of a mesh, glued along their edges. Edges may have any number of faces, and faces may
/// disagree about which side is outside.
#[derive(Debug)]
pub(super) struct Glued<'m> {
    mesh: &'m TriMesh,
    edges: Edges,
    /// The slots that start at each vertex.
    slots: Adjacency,
    bends: Vec<Bend>,
}

impl<'m> Glued<'m> {
    /// Glues the faces of a mesh.
    ///
    /// # Errors
    /// [`Error::Mesh`] names an edge that is shorter than 1e-75; those of [`TriMesh::check_size`].
    pub fn new(mesh: &'m TriMesh) -> Result<Self> {
        mesh.check_size()?;
        let edges = Edges::new(mesh);
        let n = mesh.vertices().len();
        let slots = Adjacency::from_pairs(n, || corners(mesh.faces()));
        let mut glued = Self { mesh, edges, slots, bends: Vec::new() };
        for (e, row) in glued.edges.corners().rows().enumerate() {
            let length = glued.length(row[0]);
            if length < SHORTEST {
                let what = format!("is too short ({length:e}) to unfold its faces");
                return Err(Error::Mesh { what, element: glued.edges.name(e) });
            }
        }
        let angle =
            |v: u32| glued.slots_at(v).iter().map(|&corner| glued.corner(corner)).sum::<f64>();
        let inside = |v| match angle(v) {
            total if total < TAU - STRAIGHT => Bend::Nowhere,
            total => Bend::Inside(total),
        };
        let mut bends: Vec<Bend> = (0..n as u32).map(inside).collect();
        for (row, &[a, b]) in glued.edges.corners().rows().zip(glued.edges.ends()) {
            for v in [a, b] {
                let bend = &mut bends[v as usize];
                match row.len() {
                    1 if *bend != Bend::Anywhere => *bend = Bend::Boundary,
                    1 | 2 => {}
                    _ => *bend = Bend::Anywhere,
                }
            }
        }
        for (bend, fans) in bends.iter_mut().zip(mesh.fans(&glued.edges)) {
            if fans > 1 {
                *bend = Bend::Anywhere;
            }
        }
        glued.bends = bends;
        Ok(glued)
    }

    pub fn mesh(&self) -> &'m TriMesh {
        self.mesh
    }

    /// Returns the vertex at which a slot starts.
    pub fn tail(&self, slot: u32) -> u32 {
        self.mesh.faces().as_flattened()[slot as usize]
    }

    /// Returns the slots that start at a vertex: one in each of its faces.
    pub fn slots_at(&self, vertex: u32) -> &[u32] {
        self.slots.row(vertex as usize)
    }

    /// Returns the slots of the same edge in other faces.
    pub fn across(&self, slot: u32) -> impl Iterator<Item = u32> + '_ {
        let edge = self.edges.of_corners()[slot as usize];
        self.edges.corners().row(edge as usize).iter().copied().filter(move |&other| other != slot)
    }

    /// Returns the length of the edge of a slot.
    pub fn length(&self, slot: u32) -> f64 {
        norm(self.along(slot))
    }

    /// Returns the face of a slot, unfolded along the edge of the slot.
    pub fn unfolded(&self, slot: u32) -> Unfolded {
        let along = self.along(slot);
        let to_apex = sub(self.position(previous(slot)), self.position(slot));
        let length = norm(along);
        let apex = [dot(to_apex, along) / length, norm(cross(along, to_apex)) / length];
        Unfolded { length, apex }
    }

    /// Returns the place of a corner of the face of a slot, unfolded along the edge of the slot.
    pub fn place(&self, slot: u32, vertex: u32) -> [f64; 2] {
        let Unfolded { length, apex } = self.unfolded(slot);
        if vertex == self.tail(slot) {
            [0.0, 0.0]
        } else if vertex == self.tail(next(slot)) {
            [length, 0.0]
        } else {
            apex
        }
    }

    /// Returns the place of a point of the face of a slot, by its barycentric coordinates, in the
    /// face unfolded along the edge of the slot.
    pub fn local(&self, slot: u32, weights: [f64; 3]) -> [f64; 2] {
        let Unfolded { length, apex: [x, y] } = self.unfolded(slot);
        let [head, third] = [next(slot), previous(slot)].map(|s| weights[s as usize % 3]);
        [head * length + third * x, third * y]
    }

    /// Returns whether the face of a slot has no area.
    pub fn is_flat(&self, slot: u32) -> bool {
        self.unfolded(slot).apex[1] <= 0.0
    }

    /// Returns the directions in space of the axes of a face that is unfolded along the edge of a
    /// slot. The second is zero for a face without area.
    pub fn axes(&self, slot: u32) -> [Vector; 2] {
        let along = unit(self.along(slot));
        let to_apex = sub(self.position(previous(slot)), self.position(slot));
        [along, unit(sub(to_apex, scale(along, dot(to_apex, along))))]
    }

    /// Returns whether paths may end at a vertex because the surface does: at its boundary, or
    /// because it meets itself there.
    pub fn end_at(&self, vertex: u32) -> Option<TraceEnd> {
        match self.bends[vertex as usize] {
            Bend::Nowhere | Bend::Inside(_) => None,
            Bend::Boundary => Some(TraceEnd::Boundary),
            Bend::Anywhere => Some(TraceEnd::NonManifold),
        }
    }

    /// Returns the slot of the edge of `slot` in the only other face of the edge, or why there is
    /// none.
    pub fn beyond_edge(&self, slot: u32) -> std::result::Result<u32, TraceEnd> {
        let mut others = self.across(slot);
        match (others.next(), others.next()) {
            (Some(other), None) => Ok(other),
            (None, _) => Err(TraceEnd::Boundary),
            (Some(_), Some(_)) => Err(TraceEnd::NonManifold),
        }
    }

    /// Returns the direction that has half of the angle around a vertex, inside the surface, on
    /// either side of the direction at this `angle` from the slot `edge` at the vertex, into its
    /// face: as a slot and an angle likewise.
    pub fn opposite(&self, vertex: u32, edge: u32, angle: f64) -> (u32, f64) {
        let angles = self.slots_at(vertex).iter().map(|&corner| self.corner(corner));
        let half = 0.5 * angles.sum::<f64>();
        let (mut edge, mut turned) = (edge, -angle);
        loop {
            let corner = self.corner_of(vertex, edge);
            let size = self.corner(corner);
            let other = self.across(self.other_edge(corner, edge)).next();
            match other {
                Some(other) if turned + size < half => {
                    edge = other;
                    turned += size;
                }
                _ => return (edge, (half - turned).clamp(0.0, size)),
            }
        }
    }

    /// Returns the angle of the face at the vertex where a slot starts.
    pub fn corner(&self, slot: u32) -> f64 {
        let [x, y] = self.unfolded(slot).apex;
        y.atan2(x)
    }

    /// Passes to `each` the slots that start at `vertex` in the faces where a shortest path may
    /// continue that arrives inside the face of the slot `edge`, an edge at the vertex, at this
    /// `angle` from it; the whole angle around the vertex is on either side at least pi.
    pub fn beyond(&self, vertex: u32, edge: u32, angle: f64, each: &mut impl FnMut(u32)) {
        match self.bends[vertex as usize] {
            Bend::Nowhere => {}
            Bend::Anywhere => self.slots_at(vertex).iter().for_each(|&corner| each(corner)),
            Bend::Inside(total) => {
                self.turn(vertex, edge, -angle, total - PI + STRAIGHT, each);
            }
            Bend::Boundary => {
                let corner = self.corner_of(vertex, edge);
                let other = self.other_edge(corner, edge);
                self.turn(vertex, edge, -angle, f64::INFINITY, each);
                self.turn(vertex, other, angle - self.corner(corner), f64::INFINITY, each);
            }
        }
    }

    /// Turns around a vertex, from the edge of a slot over its face and on, and passes the faces
    /// between the angles pi and `most`; the edge is at the angle `start`.
    fn turn(&self, vertex: u32, edge: u32, start: f64, most: f64, each: &mut impl FnMut(u32)) {
        let (mut edge, mut angle) = (edge, start);
        while angle <= most {
            let corner = self.corner_of(vertex, edge);
            angle += self.corner(corner);
            if angle >= PI - STRAIGHT {
                each(corner);
            }
            match self.across(self.other_edge(corner, edge)).next() {
                Some(other) => edge = other,
                None => return,
            }
        }
    }

    /// Returns the slot that starts at `vertex` in the face of `edge`, an edge at the vertex.
    pub fn corner_of(&self, vertex: u32, edge: u32) -> u32 {
        if self.tail(edge) == vertex { edge } else { next(edge) }
    }

    /// Returns the other of the two edges of a face at the vertex where `corner` starts.
    fn other_edge(&self, corner: u32, edge: u32) -> u32 {
        if edge == corner { previous(corner) } else { corner }
    }

    fn position(&self, slot: u32) -> Vector {
        self.mesh.vertices()[self.tail(slot) as usize]
    }

    fn along(&self, slot: u32) -> Vector {
        sub(self.position(next(slot)), self.position(slot))
    }
}
