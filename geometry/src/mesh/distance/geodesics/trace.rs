use super::glued::{Glued, Unfolded};
use super::path::GeodesicPath;
use super::places::{Support, cleaned, support};
use super::trace_end::TraceEnd;
use crate::mesh::slots::{next, previous};
use crate::mesh::vector::{Vector, add, dot, norm, scale};
use crate::mesh::{Site, SurfacePoint, nearest_vertex};
use catamaran::base::{Error, Result, spend};

/// Angles, in radians, and shares of an edge below this are 0: the geodesic runs along the edge, or
/// through the vertex.
const NEAR: f64 = 1e-11;

/// Part of the length that may be missing at the end, from rounding.
const SHORT: f64 = 1e-12;

/// Deviation, in radians, at which a direction still is in a face, or of a direction from the
/// normal of a surface: what is left of it in the surface is rounding error.
const ASKEW: f64 = 1e-9;

/// Operations that a step over a face is equal to.
const STEP: f64 = 200.0;

/// A geodesic from a point in a direction.
#[derive(Debug, Clone, PartialEq)]
pub struct GeodesicTrace {
    /// Where it starts, crosses edges, passes vertices and ends, and its length: the length asked
    /// for, or less if it stops.
    pub path: GeodesicPath,
    /// How it ends.
    pub end: TraceEnd,
    /// The direction at its end, of length 1, in the plane of the face of the last point: a trace
    /// from the last point in the opposite direction leads back. The direction of the caller, if
    /// the geodesic stops where it starts.
    pub direction: [f64; 3],
}

/// Traces a geodesic: see [`Geodesics::trace`](super::Geodesics::trace).
pub(super) fn trace(
    glued: &Glued<'_>,
    start: Site,
    direction: [f64; 3],
    length: f64,
) -> Result<GeodesicTrace> {
    let refused = |what, why| Err(Error::Argument { what, why });
    let largest = direction.iter().fold(0.0_f64, |most, x| most.max(x.abs()));
    if !(largest > 0.0 && direction.iter().all(|x| x.is_finite())) {
        return refused("direction", format!("must be finite and not 0, is {direction:?}"));
    }
    if !(length >= 0.0 && length.is_finite()) {
        return refused("length", format!("must be finite and at least 0, is {length}"));
    }
    // Two divisions: the squares of large and of small numbers are out of range.
    let direction = direction.map(|x| x / largest);
    let direction = scale(direction, 1.0 / norm(direction));
    let tracer = Tracer { glued };
    match tracer.set_out(start, direction)? {
        Start { ray: Ok(ray), point } => tracer.follow(ray, point, length),
        Start { ray: Err(end), point } => {
            // A geodesic of length 0 is complete where it starts.
            let end = if length == 0.0 { TraceEnd::Complete } else { end };
            let path = GeodesicPath { points: vec![point], length: 0.0 };
            Ok(GeodesicTrace { path, end, direction })
        }
    }
}

/// What a ray starts from in its face.
#[derive(Debug, Clone, Copy, PartialEq)]
enum On {
    Inside,
    /// The edge of the slot.
    Edge,
    /// The vertex where the slot starts.
    Vertex,
}

/// A ray over a face that is unfolded along the edge of `slot`.
#[derive(Debug, Clone, Copy)]
struct Ray {
    slot: u32,
    at: [f64; 2],
    /// The direction, of length 1.
    toward: [f64; 2],
    on: On,
}

/// The next ray of a geodesic, or why there is none.
type Onward = std::result::Result<Ray, TraceEnd>;

/// Where a geodesic starts, and its first ray, unless it ends there.
struct Start {
    point: SurfacePoint,
    ray: Onward,
}

/// Where a ray leaves its face.
enum Exit {
    /// Over the edge of `slot`, at this share from its start; the ray has these components along
    /// the edge and away from the face.
    Edge { slot: u32, share: f64, along: f64, away: f64 },
    /// At the vertex where `slot` starts, at this angle from the edge of the slot.
    Vertex { slot: u32, angle: f64 },
}

struct Tracer<'g, 'm> {
    glued: &'g Glued<'m>,
}

impl Tracer<'_, '_> {
    fn follow(&self, first: Ray, start: SurfacePoint, length: f64) -> Result<GeodesicTrace> {
        let (mut points, mut ray, mut rest) = (vec![start], first, length);
        let end = loop {
            spend(STEP)?;
            let (exit, far) = self.leave(&ray);
            if rest <= far + SHORT * length {
                points.push(self.point(&ray, rest.min(far)));
                rest = 0.0;
                break TraceEnd::Complete;
            }
            rest -= far;
            let bytes = size_of::<SurfacePoint>();
            points.try_reserve(1).map_err(|_| Error::OutOfMemory { bytes })?;
            points.push(match exit {
                Exit::Edge { slot, share, .. } => SurfacePoint::on_edge(slot, share),
                Exit::Vertex { slot, .. } => SurfacePoint::on_edge(slot, 0.0),
            });
            match self.beyond(exit) {
                Ok(on) => ray = on,
                Err(end) => break end,
            }
        };
        let mesh = self.glued.mesh();
        // Of a start at a vertex or an edge, and the end, the later one is in the face of the ray.
        points.dedup_by(|later, kept| {
            let is_same = later.position(mesh) == kept.position(mesh);
            if is_same {
                *kept = *later;
            }
            is_same
        });
        let [along, up] = self.glued.axes(ray.slot);
        let direction = add(scale(along, ray.toward[0]), scale(up, ray.toward[1]));
        Ok(GeodesicTrace { path: GeodesicPath { points, length: length - rest }, end, direction })
    }

    /// Returns where a ray leaves its face, and how far that is.
    fn leave(&self, ray: &Ray) -> (Exit, f64) {
        let Unfolded { length, apex } = self.glued.unfolded(ray.slot);
        let corners = [[0.0, 0.0], [length, 0.0], apex];
        let [dx, dy] = ray.toward;
        // Along an edge to its end.
        let to_corner = |k: usize| {
            let [x, y] = corners[k];
            (self.at_vertex(ray, corners, k), (x - ray.at[0]).hypot(y - ray.at[1]))
        };
        match ray.on {
            On::Inside => {}
            On::Edge if dy <= NEAR => return to_corner(if dx > 0.0 { 1 } else { 0 }),
            On::Edge => {}
            On::Vertex => {
                let (angle, corner) = (dy.atan2(dx), apex[1].atan2(apex[0]));
                if angle <= NEAR {
                    return to_corner(1);
                }
                if angle >= corner - NEAR {
                    return to_corner(2);
                }
            }
        }
        // Edge k leads from corner k to the next one; the face is on its left.
        let candidates = match ray.on {
            On::Inside => 0..3,
            On::Edge => 1..3,
            On::Vertex => 1..2,
        };
        let cross = |a: [f64; 2], b: [f64; 2]| a[0] * b[1] - a[1] * b[0];
        let minus = |a: [f64; 2], b: [f64; 2]| [a[0] - b[0], a[1] - b[1]];
        let mut found: Option<(f64, f64, usize)> = None;
        for k in candidates {
            let (a, edge) = (corners[k], minus(corners[(k + 1) % 3], corners[k]));
            let outward = cross(ray.toward, edge);
            if outward > 0.0 {
                let to_edge = minus(a, ray.at);
                let far = (cross(to_edge, edge) / outward).max(0.0);
                let share = (cross(to_edge, ray.toward) / outward).clamp(0.0, 1.0);
                if found.is_none_or(|(least, ..)| far < least) {
                    found = Some((far, share, k));
                }
            }
        }
        let Some((far, share, k)) = found else {
            // Of a face without area, whose edges all have the direction of the ray.
            return to_corner(if dx > 0.0 { 1 } else { 0 });
        };
        let slot = self.slots(ray.slot)[k];
        let exit = if share <= NEAR {
            self.at_vertex(ray, corners, k)
        } else if share >= 1.0 - NEAR {
            self.at_vertex(ray, corners, (k + 1) % 3)
        } else {
            let edge = minus(corners[(k + 1) % 3], corners[k]);
            let size = edge[0].hypot(edge[1]);
            let along = (dx * edge[0] + dy * edge[1]) / size;
            Exit::Edge { slot, share, along, away: cross(ray.toward, edge) / size }
        };
        (exit, far)
    }

    fn slots(&self, slot: u32) -> [u32; 3] {
        [slot, next(slot), previous(slot)]
    }

    /// Returns the exit of a ray at a corner of its face.
    fn at_vertex(&self, ray: &Ray, corners: [[f64; 2]; 3], k: usize) -> Exit {
        let [p, q] = [corners[k], corners[(k + 1) % 3]];
        let (edge, back) = ([q[0] - p[0], q[1] - p[1]], ray.toward.map(|x| -x));
        let turned = edge[0] * back[1] - edge[1] * back[0];
        let along = edge[0] * back[0] + edge[1] * back[1];
        Exit::Vertex { slot: self.slots(ray.slot)[k], angle: turned.abs().atan2(along) }
    }

    /// Returns the ray beyond an exit, or why there is none.
    fn beyond(&self, exit: Exit) -> Onward {
        match exit {
            Exit::Edge { slot, share, along, away } => {
                let other = self.glued.beyond_edge(slot)?;
                let length = self.glued.length(other);
                let is_same_way = self.glued.tail(other) == self.glued.tail(slot);
                let (share, along) =
                    if is_same_way { (share, along) } else { (1.0 - share, -along) };
                let size = along.hypot(away);
                let toward = [along / size, away / size];
                Ok(Ray { slot: other, at: [share * length, 0.0], toward, on: On::Edge })
            }
            Exit::Vertex { slot, angle } => {
                let vertex = self.glued.tail(slot);
                if let Some(end) = self.glued.end_at(vertex) {
                    return Err(end);
                }
                let (edge, angle) = self.glued.opposite(vertex, slot, angle);
                let corner = self.glued.corner_of(vertex, edge);
                let size = self.glued.corner(corner);
                Ok(from_corner(corner, if edge == corner { angle } else { size - angle }))
            }
        }
    }

    /// Returns the point of a ray at this distance from its start.
    fn point(&self, ray: &Ray, far: f64) -> SurfacePoint {
        let Unfolded { length, apex } = self.glued.unfolded(ray.slot);
        let [x, y] = [0, 1].map(|k| ray.at[k] + far * ray.toward[k]);
        let third = if apex[1] > 0.0 { (y / apex[1]).clamp(0.0, 1.0) } else { 0.0 };
        let head = ((x - third * apex[0]) / length).clamp(0.0, 1.0 - third);
        let mut weights = [0.0; 3];
        for (slot, weight) in
            self.slots(ray.slot).into_iter().zip([1.0 - head - third, head, third])
        {
            weights[slot as usize % 3] = weight.max(0.0);
        }
        SurfacePoint { face: ray.slot / 3, weights }
    }

    /// Finds the first ray in this direction, of length 1.
    fn set_out(&self, start: Site, direction: Vector) -> Result<Start> {
        let mesh = self.glued.mesh();
        if let Some(why) = start.fault(mesh) {
            return Err(Error::Argument { what: "start", why });
        }
        let point = match start {
            Site::Vertex(v) => return self.nearest(v, direction),
            Site::Near(point) => {
                let none = || Error::Argument { what: "start", why: "no vertex has a face".into() };
                let found = nearest_vertex(mesh, &mesh.referenced(), point);
                return self.nearest(found.ok_or_else(none)?, direction);
            }
            Site::Face(point) => cleaned(point),
        };
        let support = support(point);
        let slot = match support {
            Support::Vertex(slot) | Support::Edge(slot) => slot,
            Support::Face => 3 * point.face,
        };
        if self.glued.is_flat(slot) {
            let what = "has no area, so that it has no directions".into();
            return Err(Error::Mesh { what, element: format!("face {}", point.face) });
        }
        let [x, y] = self.glued.axes(slot).map(|axis| dot(direction, axis));
        let size = x.hypot(y);
        if size <= ASKEW {
            let why = format!("is perpendicular to face {}", point.face);
            return Err(Error::Argument { what: "direction", why });
        }
        let toward = [x / size, y / size];
        let at = self.glued.local(slot, point.weights);
        Ok(match support {
            Support::Face => Start { point, ray: Ok(Ray { slot, at, toward, on: On::Inside }) },
            Support::Edge(_) if toward[1] >= -NEAR => {
                Start { point, ray: Ok(Ray { slot, at, toward, on: On::Edge }) }
            }
            Support::Edge(_) => {
                let share = point.weights[next(slot) as usize % 3];
                let [along, away] = [toward[0], -toward[1]];
                Start { point, ray: self.beyond(Exit::Edge { slot, share, along, away }) }
            }
            Support::Vertex(_) => {
                let corner = self.glued.corner(slot);
                let is_inside = |angle: f64| angle >= -ASKEW && angle <= corner + ASKEW;
                let (ahead, behind) = (y.atan2(x), (-y).atan2(-x));
                if is_inside(ahead) {
                    Start { point, ray: Ok(from_corner(slot, ahead.clamp(0.0, corner))) }
                } else if is_inside(behind) {
                    let angle = behind.clamp(0.0, corner);
                    Start { point, ray: self.beyond(Exit::Vertex { slot, angle }) }
                } else {
                    self.nearest(self.glued.tail(slot), direction)?
                }
            }
        })
    }

    /// Finds the first ray from a vertex: the one that is nearest to a direction.
    fn nearest(&self, vertex: u32, direction: Vector) -> Result<Start> {
        let refused = |what, why| Err(Error::Argument { what, why });
        // The cosine of the angle between ray and direction, the ray, and whether it is one at the
        // boundary that the direction leads beyond.
        let mut best: Option<(f64, u32, f64, bool)> = None;
        let mut part_in_faces = 0.0_f64;
        for &corner in self.glued.slots_at(vertex) {
            let [x, y] = self.glued.axes(corner).map(|axis| dot(direction, axis));
            let (angle, size) = (y.atan2(x), self.glued.corner(corner));
            part_in_faces = part_in_faces.max(x.hypot(y));
            let cosine = |ray: f64| x * ray.cos() + y * ray.sin();
            let (ray, edge) = if angle >= 0.0 && angle <= size {
                (angle, None)
            } else if cosine(0.0) >= cosine(size) {
                (0.0, Some(corner))
            } else {
                (size, Some(previous(corner)))
            };
            let is_boundary = |edge| self.glued.beyond_edge(edge) == Err(TraceEnd::Boundary);
            let is_beyond = edge.is_some_and(|e| (angle - ray).abs() > ASKEW && is_boundary(e));
            if best.is_none_or(|(most, ..)| cosine(ray) > most) {
                best = Some((cosine(ray), corner, ray, is_beyond));
            }
        }
        let Some((cosine, corner, ray, is_beyond)) = best else {
            return refused("start", format!("vertex {vertex} is in no face"));
        };
        let point = SurfacePoint::on_edge(corner, 0.0);
        // Out of the surface over its boundary, and not up from it.
        let is_at_boundary = self.glued.end_at(vertex) == Some(TraceEnd::Boundary);
        let is_out = is_beyond || (is_at_boundary && cosine <= ASKEW);
        if is_out && part_in_faces > ASKEW {
            return Ok(Start { point, ray: Err(TraceEnd::Boundary) });
        }
        if cosine <= ASKEW {
            let why = format!("points away from the surface at vertex {vertex}");
            return refused("direction", why);
        }
        Ok(Start { point, ray: Ok(from_corner(corner, ray)) })
    }
}

/// Returns the ray from the vertex where a slot starts, at this angle from its edge.
fn from_corner(slot: u32, angle: f64) -> Ray {
    Ray { slot, at: [0.0, 0.0], toward: [angle.cos(), angle.sin()], on: On::Vertex }
}
