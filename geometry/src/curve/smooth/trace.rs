use super::super::result::Waypoint;
use super::intrinsic::Intrinsic;
use crate::mesh::TriMesh;
use crate::mesh::slots::{next, previous};
use crate::mesh::vector::{Vector, distance};

/// Largest number of faces that a line may cross.
const MOST_FACES: usize = 100_000;
/// Largest distance between the end of a line and its target, relative to its length.
const MISS: f64 = 1e-5;

/// A piece of a line, on one face.
pub(super) struct Chord {
    pub face: u32,
    pub ends: [Vector; 2],
    /// The end of the chord.
    pub at: Waypoint,
}

/// Traces straight lines over the mesh.
pub(super) struct Tracer<'m> {
    mesh: &'m TriMesh,
    twins: Vec<u32>,
    directions: Vec<f64>,
    corners: Vec<f64>,
    totals: Vec<f64>,
    /// A slot of each vertex; on the boundary, the first one.
    starts: Vec<u32>,
}

impl<'m> Tracer<'m> {
    /// Creates a tracer from a triangulation without flipped edges.
    pub fn new(mesh: &'m TriMesh, intrinsic: &Intrinsic) -> Self {
        let count = 3 * mesh.faces().len() as u32;
        let mut starts = vec![u32::MAX; mesh.vertices().len()];
        for (s, &v) in (0..).zip(mesh.faces().as_flattened()) {
            if intrinsic.direction(s) == 0.0 {
                starts[v as usize] = s;
            }
        }
        Self {
            mesh,
            twins: intrinsic.twins().to_vec(),
            directions: intrinsic.directions().to_vec(),
            corners: (0..count).map(|s| intrinsic.corner(s)).collect(),
            totals: (0..mesh.vertices().len() as u32).map(|v| intrinsic.total(v)).collect(),
            starts,
        }
    }

    fn tail(&self, slot: u32) -> u32 {
        self.mesh.faces()[slot as usize / 3][slot as usize % 3]
    }

    fn place(&self, vertex: u32) -> Vector {
        self.mesh.vertices()[vertex as usize]
    }

    /// Traces the line of this length from a vertex in a direction, which ends at `target`; `None`
    /// when it does not.
    pub fn trace(&self, from: u32, direction: f64, length: f64, target: u32) -> Option<Vec<Chord>> {
        let mut s = self.starts[from as usize];
        let total = self.totals[from as usize];
        let direction = if total > 0.0 { direction.rem_euclid(total) } else { 0.0 };
        while direction >= self.directions[s as usize] + self.corners[s as usize] {
            let ahead = self.twins[previous(s) as usize];
            if ahead == u32::MAX || ahead == self.starts[from as usize] {
                break; // rounding: the line ends in the last face
            }
            s = ahead;
        }
        let (sin, cos) = (direction - self.directions[s as usize]).sin_cos();
        let end = [length * cos, length * sin];
        // The face in its plane, with a corner at the origin and the slot along x.
        let far = next(s);
        let (right_vertex, left_vertex) = (self.tail(far), self.tail(previous(s)));
        let (sin, cos) = self.corners[s as usize].sin_cos();
        let near = self.place(from);
        let mut right = [distance(near, self.place(right_vertex)), 0.0];
        let reach = distance(near, self.place(left_vertex));
        let mut left = [reach * cos, reach * sin];
        let miss = MISS * length;
        let arrived =
            |p: [f64; 2], v: u32| v == target && (p[0] - end[0]).hypot(p[1] - end[1]) <= miss;
        let mut entered = near;
        let mut chords = Vec::new();
        if arrived(right, right_vertex) || arrived(left, left_vertex) {
            let at = Waypoint::Vertex(target);
            chords.push(Chord { face: s / 3, ends: [near, self.place(target)], at });
            return Some(chords);
        }
        let mut edge = far;
        for _ in 0..MOST_FACES {
            // The exit lies between right and left.
            let (r, l) = (turn(end, right), turn(end, left));
            let share = if l - r > 0.0 { (-r / (l - r)).clamp(0.0, 1.0) } else { 0.5 };
            let crossed = [edge, next(edge)].map(|s| self.tail(s));
            let [p, q] = crossed.map(|v| self.place(v));
            let leaves: Vector = std::array::from_fn(|k| p[k] + share * (q[k] - p[k]));
            let at = Waypoint::Edge { ends: crossed, share };
            chords.push(Chord { face: edge / 3, ends: [entered, leaves], at });
            entered = leaves;
            let twin = self.twins[edge as usize];
            if twin == u32::MAX {
                return None;
            }
            // The apex of the next face, on the other side of the edge.
            let apex = self.tail(previous(twin));
            let along = [left[0] - right[0], left[1] - right[1]];
            let across = along[0].hypot(along[1]);
            let (sin, cos) = self.corners[next(twin) as usize].sin_cos();
            let reach = distance(self.place(apex), self.place(self.tail(next(twin)))) / across;
            let place = [
                right[0] + reach * (cos * along[0] + sin * along[1]),
                right[1] + reach * (cos * along[1] - sin * along[0]),
            ];
            if arrived(place, apex) {
                let at = Waypoint::Vertex(apex);
                chords.push(Chord { face: twin / 3, ends: [entered, self.place(apex)], at });
                return Some(chords);
            }
            if turn(end, place) > 0.0 {
                // The line passes to the right of the apex.
                left = place;
                edge = next(twin);
            } else {
                right = place;
                edge = previous(twin);
            }
        }
        None
    }
}

/// Returns a positive number when b lies to the left of a.
fn turn(a: [f64; 2], b: [f64; 2]) -> f64 {
    a[0] * b[1] - a[1] * b[0]
}
