//! Draws curves on a surface as thin tubes that lie on it, and samples as small balls.

use anyhow::Result;
use catamaran_geometry::curve::Curve;
use catamaran_geometry::mesh::vector::{Vector, cross, norm, sub};
use catamaran_geometry::mesh::{TriMesh, families};

use super::image::Rgb;

/// Radius of a tube, relative to the diagonal of the bounding box.
const TUBE: f64 = 0.0035;
/// Radius of a ball, relative to the diagonal of the bounding box.
const BALL: f64 = 0.008;
/// Sides of a tube.
const SIDES: usize = 6;
/// The angle between neighbouring sides of a tube, in radians.
const STEP: f64 = std::f64::consts::TAU / SIDES as f64;

const SURFACE: Rgb = [205, 214, 224];
const SAMPLE: Rgb = [30, 34, 42];
/// Colours of the curves, one after the other.
const CURVES: [Rgb; 4] = [[214, 40, 57], [29, 92, 196], [26, 138, 68], [222, 138, 16]];

/// Returns the mesh with these curves and samples on it, and a colour for each vertex.
pub fn with_curves(
    mesh: &TriMesh,
    curves: &[Curve],
    samples: &[Vector],
) -> Result<(TriMesh, Vec<Rgb>)> {
    let [low, high] = mesh.bounding_box().unwrap_or_default();
    let diagonal = norm(sub(high, low));
    let (mut vertices, mut faces) = mesh.clone().into_parts();
    let mut colors = vec![SURFACE; vertices.len()];
    let lift = Lift::new(mesh, TUBE * diagonal);
    for (curve, color) in curves.iter().zip(CURVES.into_iter().cycle()) {
        let points: Vec<Vector> = curve.points.iter().map(|&p| lift.above(p)).collect();
        let next = points.iter().skip(1).chain(points.first().filter(|_| curve.closed));
        for (&from, &to) in points.iter().zip(next) {
            tube(&mut vertices, &mut faces, from, to, TUBE * diagonal);
        }
        colors.resize(vertices.len(), color);
    }
    let ball = families::icosphere(1)?;
    for p in samples {
        let first = vertices.len() as u32;
        let place = |q: &Vector| std::array::from_fn(|k| p[k] + BALL * diagonal * q[k]);
        vertices.extend(ball.vertices().iter().map(place));
        faces.extend(ball.faces().iter().map(|face| face.map(|v| first + v)));
    }
    colors.resize(vertices.len(), SAMPLE);
    Ok((TriMesh::new(vertices, faces)?, colors))
}

/// Moves points off a surface along its normals, so that tubes around them are not half inside.
struct Lift<'a> {
    mesh: &'a TriMesh,
    normals: Vec<Vector>,
    /// Vertices of faces, ordered by x.
    sorted: Vec<u32>,
    height: f64,
}

impl<'a> Lift<'a> {
    fn new(mesh: &'a TriMesh, height: f64) -> Self {
        let mut sorted: Vec<u32> = mesh.faces().as_flattened().to_vec();
        let x = |v: &u32| mesh.vertices()[*v as usize][0];
        sorted.sort_unstable_by(|a, b| x(a).total_cmp(&x(b)).then(a.cmp(b)));
        sorted.dedup();
        Self { mesh, normals: mesh.vertex_normals(), sorted, height }
    }

    /// Returns the point above p, by the normal of the vertex nearest to p.
    fn above(&self, p: Vector) -> Vector {
        let Some(vertex) = self.nearest(p) else { return p };
        let normal = self.normals[vertex as usize];
        std::array::from_fn(|k| p[k] + self.height * normal[k])
    }

    fn nearest(&self, p: Vector) -> Option<u32> {
        let at = |v: u32| self.mesh.vertices()[v as usize];
        let start = self.sorted.partition_point(|&v| at(v)[0] < p[0]);
        let (below, above) = self.sorted.split_at(start);
        let mut best: Option<(f64, u32)> = None;
        let mut look = |v: u32| {
            let far = best.map_or(f64::INFINITY, |(distance, _)| distance);
            let distance = norm(sub(at(v), p));
            if distance < far {
                best = Some((distance, v));
            }
            (at(v)[0] - p[0]).abs() <= far
        };
        // The search goes away from p along x, until x alone is farther than the nearest vertex so
        // far.
        let _ = above.iter().all(|&v| look(v));
        let _ = below.iter().rev().all(|&v| look(v));
        best.map(|(_, vertex)| vertex)
    }
}

/// Adds the sides of a prism around a line, without ends.
fn tube(
    vertices: &mut Vec<Vector>,
    faces: &mut Vec<[u32; 3]>,
    from: Vector,
    to: Vector,
    radius: f64,
) {
    let along = sub(to, from);
    let length = norm(along);
    if length == 0.0 {
        return;
    }
    let along = along.map(|x| x / length);
    let least = (0..3).min_by(|&i, &j| along[i].abs().total_cmp(&along[j].abs())).unwrap_or(0);
    let mut axis = [0.0; 3];
    axis[least] = 1.0;
    let side = cross(along, axis);
    let side = side.map(|x| x / norm(side));
    let other = cross(along, side);
    let first = vertices.len() as u32;
    for end in [from, to] {
        for i in 0..SIDES {
            let (sin, cos) = (i as f64 * STEP).sin_cos();
            vertices
                .push(std::array::from_fn(|k| end[k] + radius * (cos * side[k] + sin * other[k])));
        }
    }
    let n = SIDES as u32;
    for i in 0..n {
        let j = (i + 1) % n;
        faces.push([first + i, first + j, first + n + j]);
        faces.push([first + i, first + n + j, first + n + i]);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_tube_lies_on_its_surface_and_does_not_sink_into_it() {
        let mesh = families::icosphere(3).unwrap();
        // A great circle, between vertices.
        let points: Vec<Vector> = (0..60)
            .map(|i| {
                let (sin, cos) = (f64::from(i) * std::f64::consts::TAU / 60.0).sin_cos();
                [0.6 * cos, sin, 0.8 * cos]
            })
            .collect();
        let (order, path) = (vec![], vec![]);
        let waypoints = Vec::new();
        let curve = Curve { order, path, points, waypoints, closed: true, length: 0.0 };
        let (painted, colors) = with_curves(&mesh, &[curve], &[]).unwrap();
        let on_tube = |v: &usize| colors[*v] == CURVES[0];
        let all = (0..colors.len()).filter(on_tube).map(|v| norm(painted.vertices()[v]));
        let heights: Vec<f64> = all.map(|r| r - 1.0).collect();
        let radius = TUBE * 12.0_f64.sqrt();
        assert!(heights.len() == 60 * 2 * SIDES);
        assert!(heights.iter().all(|&h| h > -0.1 * radius && h < 2.1 * radius), "{heights:?}");
    }
}
