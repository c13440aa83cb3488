//! Walks against geodesics that are followed in space, in double precision: where an edge is
//! crossed, the direction is turned around it into the next plane.

use catamaran::base::Rng;
use catamaran_geometry::mesh::{Edges, TriMesh, families};
use catamaran_simulation::texture::slime::{NO_TRIANGLE, Surface, Walker, project, unfold};

use super::support::{square, with_atlas};

type Vector = [f64; 3];

fn sub(a: Vector, b: Vector) -> Vector {
    [0, 1, 2].map(|i| a[i] - b[i])
}

fn along(a: Vector, s: f64, d: Vector) -> Vector {
    [0, 1, 2].map(|i| a[i] + s * d[i])
}

fn dot(a: Vector, b: Vector) -> f64 {
    a[0] * b[0] + a[1] * b[1] + a[2] * b[2]
}

fn cross(a: Vector, b: Vector) -> Vector {
    [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]]
}

fn unit(a: Vector) -> Vector {
    let length = dot(a, a).sqrt();
    a.map(|x| x / length)
}

/// A place in space on a face, and a direction in its plane.
struct Traveller {
    face: usize,
    position: Vector,
    direction: Vector,
}

/// The mesh scaled to area 1, as the surface is.
fn scaled(mesh: &TriMesh) -> TriMesh {
    let factor = 1.0 / mesh.area().sqrt();
    let vertices = mesh.vertices().iter().map(|p| p.map(|x| x * factor)).collect();
    TriMesh::new(vertices, mesh.faces().to_vec()).unwrap()
}

impl Traveller {
    fn of(mesh: &TriMesh, walker: &Walker) -> Self {
        let face = walker.triangle as usize;
        let [a, b, c] = mesh.faces()[face].map(|v| mesh.vertices()[v as usize]);
        let x = unit(sub(b, a));
        let y = cross(unit(cross(sub(b, a), sub(c, a))), x);
        let at = |p: [f32; 2]| [0, 1, 2].map(|i| f64::from(p[0]) * x[i] + f64::from(p[1]) * y[i]);
        Self {
            face,
            position: along(a, 1.0, at(walker.position)),
            direction: unit(at(walker.heading)),
        }
    }

    /// Goes straight until so many edges are crossed, or so far; returns how far.
    fn go(&mut self, mesh: &TriMesh, edges: &Edges, most: usize, length: f64) -> f64 {
        let (mut gone, mut entered) = (0.0, usize::MAX);
        for crossed in 0.. {
            let corners = mesh.faces()[self.face].map(|v| mesh.vertices()[v as usize]);
            let normal = unit(cross(sub(corners[1], corners[0]), sub(corners[2], corners[0])));
            let mut exit = (length - gone, 3);
            for k in 0..3 {
                let edge = edges.of_corners()[3 * self.face + k] as usize;
                let inward = cross(normal, unit(sub(corners[(k + 1) % 3], corners[k])));
                let rate = dot(self.direction, inward);
                let way = -dot(sub(self.position, corners[k]), inward) / rate;
                if edge != entered && rate < 0.0 && way < exit.0 {
                    exit = (way.max(0.0), k);
                }
            }
            let (way, k) = exit;
            // Ends in the middle of the triangle after the last edge.
            let last = crossed == most;
            let way = if last { way / 2.0 } else { way };
            self.position = along(self.position, way, self.direction);
            gone += way;
            if last || k == 3 {
                return gone;
            }
            entered = edges.of_corners()[3 * self.face + k] as usize;
            let faces: Vec<u32> = edges.faces(entered).collect();
            let axis = unit(sub(corners[(k + 1) % 3], corners[k]));
            let outward = cross(axis, normal);
            let (s, t) = (dot(self.direction, axis), dot(self.direction, outward));
            let Some(&next) = faces.iter().find(|&&f| f as usize != self.face) else {
                self.direction = along(along([0.0; 3], s, axis), -t, outward);
                continue;
            };
            self.face = next as usize;
            // Into the next face: towards its corner that is not on the edge.
            let ends = [corners[k], corners[(k + 1) % 3]];
            let opposite = mesh.faces()[self.face].map(|v| mesh.vertices()[v as usize]);
            let opposite = opposite.into_iter().find(|p| !ends.contains(p)).unwrap();
            let there = sub(opposite, ends[0]);
            let inward = unit(along(there, -dot(there, axis), axis));
            self.direction = along(along([0.0; 3], s, axis), t, inward);
        }
        gone
    }
}

fn start(surface: &Surface, rng: &mut Rng) -> Walker {
    let triangle = (rng.uniform() * surface.len() as f64) as u32;
    let [_, b, c] = surface.corners()[triangle as usize];
    let (sin, cos) = (std::f64::consts::TAU * rng.uniform()).sin_cos();
    Walker {
        triangle,
        position: [((b[0] + c[0]) / 3.0) as f32, (c[1] / 3.0) as f32],
        heading: [cos as f32, sin as f32],
    }
}

#[test]
fn a_walk_over_a_hundred_triangles_is_straight() {
    for mesh in [
        families::torus(36, 18, 2.0, 0.7).unwrap(),
        families::icosphere(3).unwrap(),
        families::moebius(60, 6).unwrap(),
        families::terrain(16, 16, 3).unwrap(),
    ] {
        let (surface, space) = (with_atlas(&mesh, 1024), scaled(&mesh));
        let edges = Edges::new(&space);
        let mut rng = Rng::new(5);
        for _ in 0..20 {
            let walker = start(&surface, &mut rng);
            let mut oracle = Traveller::of(&space, &walker);
            let length = oracle.go(&space, &edges, 100, f64::INFINITY);
            let end = Traveller::of(&space, &unfold(&surface, walker, length as f32, true));
            let off = sub(end.position, oracle.position);
            assert!(dot(off, off).sqrt() < 1e-5, "{off:?} after {length}");
            assert!(dot(end.direction, oracle.direction) > 1.0 - 1e-8);
        }
    }
}

#[test]
fn steps_add_up_to_a_walk() {
    let surface = with_atlas(&families::torus(24, 12, 2.0, 0.7).unwrap(), 512);
    let mut rng = Rng::new(1);
    for _ in 0..50 {
        let walker = start(&surface, &mut rng);
        let whole = unfold(&surface, walker, 0.5, true);
        let parts = (0..50).fold(walker, |walker, _| unfold(&surface, walker, 0.01, true));
        assert_eq!(whole.triangle, parts.triangle);
        for i in 0..2 {
            assert!((whole.position[i] - parts.position[i]).abs() < 1e-5);
        }
    }
}

#[test]
fn in_a_plane_both_steps_are_the_same() {
    let surface = square(12);
    let mut rng = Rng::new(2);
    for _ in 0..200 {
        let walker = start(&surface, &mut rng);
        let exact = unfold(&surface, walker, 0.05, true);
        let steps = project(&surface, walker, 0.05 / 64.0, 64, true);
        let uv = |w: &Walker| {
            let r = &surface.records()[w.triangle as usize];
            let [x, y] = w.position;
            [r[21] + r[22] * x + r[23] * y, r[24] + r[25] * x + r[26] * y]
        };
        let (a, b) = (uv(&exact), uv(&steps));
        assert!((a[0] - b[0]).hypot(a[1] - b[1]) < 2e-5, "{a:?} {b:?}");
    }
}

#[test]
fn more_substeps_come_nearer_to_the_geodesic() {
    let mesh = families::icosphere(3).unwrap();
    let (surface, space) = (with_atlas(&mesh, 512), scaled(&mesh));
    let off = |count: u32| {
        let mut rng = Rng::new(3);
        let mut sum = 0.0;
        for _ in 0..100 {
            let walker = start(&surface, &mut rng);
            let exact = Traveller::of(&space, &unfold(&surface, walker, 0.1, true));
            let end = project(&surface, walker, 0.1 / count as f32, count, true);
            let end = Traveller::of(&space, &end);
            let off = sub(end.position, exact.position);
            sum += dot(off, off).sqrt();
        }
        sum / 100.0
    };
    let [one, ten, hundred] = [1, 10, 100].map(off);
    assert!(one > 3.0 * ten && ten > 2.0 * hundred, "{one} {ten} {hundred}");
}

#[test]
fn boundaries_reflect() {
    let surface = square(1);
    // From (0.1, 0.5) to the left by 0.3: back to 0.2.
    let triangle = surface.across().iter().position(|a| a.contains(&NO_TRIANGLE)).unwrap();
    let r = &surface.records()[triangle];
    // The frame is that of the square, turned or not: find heading and place of a walk to u = 0.
    let [a, b] = [r[22], r[23]];
    assert!((a * a + b * b - 1.0).abs() < 1e-6, "the texture keeps lengths");
    let [_, q, s] = surface.corners()[triangle];
    let position = [((q[0] + s[0]) / 3.0) as f32, (s[1] / 3.0) as f32];
    let walker = Walker { triangle: triangle as u32, position, heading: [-a, -b] };
    let u = r[21] + a * position[0] + b * position[1];
    for end in [
        unfold(&surface, walker, u + 0.2, true),
        project(&surface, walker, (u + 0.2) / 40.0, 40, true),
    ] {
        let r = &surface.records()[end.triangle as usize];
        let reached = r[21] + r[22] * end.position[0] + r[23] * end.position[1];
        assert!((reached - 0.2).abs() < 1e-5, "{reached}");
        let forward = r[22] * end.heading[0] + r[23] * end.heading[1];
        assert!((forward - 1.0).abs() < 1e-5);
    }
}

#[test]
fn without_rescaling_lengths_are_those_of_the_texture() {
    // The unit square, twice as wide in the texture as high.
    let mesh = families::grid(4, 4).unwrap();
    let at = |v: u32| {
        let [x, y, _] = mesh.vertices()[v as usize];
        [x, y / 2.0]
    };
    let uv = mesh.faces().iter().map(|face| face.map(at)).collect();
    let surface = Surface::of_faces(&mesh, uv).unwrap();
    let mut rng = Rng::new(4);
    for _ in 0..50 {
        let walker = start(&surface, &mut rng);
        for end in
            [unfold(&surface, walker, 0.02, false), project(&surface, walker, 0.001, 20, false)]
        {
            let place = |w: &Walker| {
                let r = &surface.records()[w.triangle as usize];
                let [x, y] = w.position;
                [r[21] + r[22] * x + r[23] * y, r[24] + r[25] * x + r[26] * y]
            };
            let (a, b) = (place(&walker), place(&end));
            let way = (a[0] - b[0]).hypot(a[1] - b[1]);
            assert!((way - 0.02).abs() < 1e-5, "{way}");
        }
    }
}
