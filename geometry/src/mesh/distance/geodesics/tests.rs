use std::f64::consts::TAU;

use super::*;
use crate::mesh::slots::{next, previous};
use crate::mesh::vector::distance;
use crate::mesh::{Dijkstra, Edges, Graph, SearchLimits, families, shapes};
use catamaran::base::Rng;

fn sites(vertices: &[u32]) -> Vec<Site> {
    vertices.iter().copied().map(Site::Vertex).collect()
}

fn geodesics(mesh: &TriMesh, sources: &[u32]) -> Vec<f64> {
    Geodesics::new(mesh).unwrap().distances(&sites(sources)).unwrap()
}

/// Checks distances from a source to 1e-11 of the largest.
fn check(name: &str, mesh: &TriMesh, source: u32, exact: impl Fn(usize) -> f64) {
    let found = geodesics(mesh, &[source]);
    let largest = (0..found.len()).map(&exact).fold(0.0, f64::max);
    for (v, d) in found.iter().enumerate() {
        let right = exact(v);
        assert!(
            (d - right).abs() <= 1e-11 * largest,
            "{name}: from {source} to {v}: {d} instead of {right}"
        );
    }
}

pub(super) fn moved(mesh: &TriMesh, mut to: impl FnMut([f64; 3]) -> [f64; 3]) -> TriMesh {
    let vertices = mesh.vertices().iter().map(|&p| to(p)).collect();
    TriMesh::new(vertices, mesh.faces().to_vec()).unwrap()
}

#[test]
fn exact_distances_on_convex_plane_regions_are_euclidean_for_any_triangles() {
    let mut rng = Rng::new(3);
    let square = shapes::grid(9, 9);
    let is_inside = |p: [f64; 3]| p[..2].iter().all(|x| *x > 0.5 && *x < 8.5);
    let irregular = moved(&square, |p| {
        let by = if is_inside(p) { 0.3 } else { 0.0 };
        [p[0] + by * (2.0 * rng.uniform() - 1.0), p[1] + by * (2.0 * rng.uniform() - 1.0), 0.0]
    });
    for (name, mesh) in [
        ("squares", square.clone()),
        ("irregular", irregular),
        ("sheared", moved(&square, |[x, y, _]| [x + 3.0 * y, y, 0.0])),
        ("stretched", moved(&square, |[x, y, _]| [100.0 * x, y, 0.0])),
        ("tilted", moved(&square, |[x, y, _]| [x, y, 0.7 * x - 1.3 * y])),
        ("disk", families::disk(5, 12).unwrap()),
        ("slivers", families::slivers(8, 5, 1e-3).unwrap()),
        ("large", moved(&square, |p| p.map(|x| 1e60 * x))),
        ("small", moved(&square, |p| p.map(|x| 1e-60 * x))),
    ] {
        let p = mesh.vertices();
        for source in [0, p.len() as u32 / 3, p.len() as u32 / 2] {
            check(name, &mesh, source, |v| distance(p[v], p[source as usize]));
        }
    }
}

#[test]
fn exact_distances_on_a_cylinder_are_those_of_the_unrolled_plane() {
    let (around, along) = (24, 8);
    let mesh = families::cylinder(around, along, 1.0, 2.0).unwrap();
    let side = 2.0 * (TAU / 2.0 / around as f64).sin();
    let row = along + 1;
    for source in [0, 4, 40] {
        check("cylinder", &mesh, source as u32, |v| {
            let turn = (v / row).abs_diff(source / row);
            let across = side * turn.min(around - turn) as f64;
            across.hypot(0.25 * (v % row).abs_diff(source % row) as f64)
        });
    }
}

/// Returns a cone of equal sectors with its tip at vertex 0 and then `rings` rings, and the angle
/// of a sector at the tip; every other ray rises by `up`, and the others by `down`, for each ring.
pub(super) fn cone(sectors: usize, rings: usize, up: f64, down: f64) -> (TriMesh, f64) {
    let ray = |i: usize| {
        let angle = TAU * i as f64 / sectors as f64;
        [angle.cos(), angle.sin(), if i.is_multiple_of(2) { up } else { down }]
    };
    let mut vertices = vec![[0.0; 3]];
    for ring in 1..=rings {
        vertices.extend((0..sectors).map(|i| ray(i).map(|x| x * ring as f64)));
    }
    let at = |ring: usize, i: usize| (1 + ring * sectors + i % sectors) as u32;
    let mut faces = Vec::new();
    for i in 0..sectors {
        faces.push([0, at(0, i), at(0, i + 1)]);
        for ring in 1..rings {
            let [a, b] = [at(ring - 1, i), at(ring - 1, i + 1)];
            let [c, d] = [at(ring, i), at(ring, i + 1)];
            faces.extend([[a, c, d], [a, d, b]]);
        }
    }
    let (a, b) = (distance(ray(0), [0.0; 3]), distance(ray(1), [0.0; 3]));
    let chord = distance(ray(0), ray(1));
    let sector = ((a * a + b * b - chord * chord) / (2.0 * a * b)).acos();
    (TriMesh::new(vertices, faces).unwrap(), sector)
}

#[test]
fn exact_distances_on_cones_are_those_of_the_unrolled_plane_or_lead_over_the_tip() {
    // Pointed, flat, and saddles of more than a full turn around the tip.
    for (up, down, least, most) in [
        (0.8, 0.8, 4.0, 5.0),
        (0.0, 0.0, TAU, TAU),
        (0.6, -0.6, 14.0, 15.0),
        (2.0, -2.0, 26.0, 28.0),
    ] {
        let (sectors, rings) = (12, 5);
        let (mesh, sector) = cone(sectors, rings, up, down);
        let total = sectors as f64 * sector;
        assert!(total >= least - 1e-9 && total <= most + 1e-9, "{total}");
        let p = mesh.vertices();
        let from_tip = |v: usize| distance(p[v], p[0]);
        // Inner rings, from which a straight line leaves the region nowhere.
        for source in [0, 1, 14, 27] {
            let exact = |v: usize| {
                let ray = |v: usize| (v + sectors - 1) % sectors;
                let (a, b) = (from_tip(source), from_tip(v));
                if a == 0.0 || b == 0.0 {
                    return a + b;
                }
                let turn = ray(v).abs_diff(ray(source));
                let angle = sector * turn.min(sectors - turn) as f64;
                if angle >= TAU / 2.0 {
                    return a + b;
                }
                (a * a + b * b - 2.0 * a * b * angle.cos()).max(0.0).sqrt()
            };
            check(&format!("cone {up} {down}"), &mesh, source as u32, exact);
        }
    }
}

pub(super) fn cube() -> TriMesh {
    let corner = |i: u32| [i & 1, i >> 1 & 1, i >> 2 & 1].map(f64::from);
    let faces = [
        [0, 2, 1],
        [1, 2, 3],
        [4, 5, 6],
        [5, 7, 6],
        [0, 1, 4],
        [1, 5, 4],
        [2, 6, 3],
        [3, 6, 7],
        [0, 4, 2],
        [2, 4, 6],
        [1, 3, 5],
        [3, 7, 5],
    ];
    TriMesh::new((0..8).map(corner).collect(), faces.to_vec()).unwrap()
}

#[test]
fn the_exact_distance_of_opposite_corners_of_a_cube_is_the_root_of_5() {
    let mesh = cube();
    for source in 0..8 {
        check("cube", &mesh, source, |v| {
            // 0, 1, the diagonal of a side, and over two sides.
            [0.0, 1.0, 2f64.sqrt(), 5f64.sqrt()][(v as u32 ^ source).count_ones() as usize]
        });
    }
}

/// Returns distances by definition: straight paths between all pairs of vertices through all
/// sequences of faces, and shortest chains of them.
fn by_all_sequences(mesh: &TriMesh, sources: &[u32]) -> Vec<f64> {
    let n = mesh.vertices().len();
    let edges = Edges::new(mesh);
    let mut straight = vec![vec![f64::INFINITY; n]; n];
    let mut all = Sequences { mesh, edges: &edges, found: Vec::new() };
    for corner in 0..3 * mesh.faces().len() as u32 {
        let slot = next(corner);
        let [a, b, v] = [slot, next(slot), corner].map(|s| all.tail(s));
        let sides = [all.apart(v, a), all.apart(v, b)];
        let p = [sides[0], 0.0];
        let q = third([0.0; 2], p, sides[1], all.apart(a, b));
        all.found = vec![(a, sides[0]), (b, sides[1])];
        all.go_on(slot, [(a, p), (b, q)], [p, q], &mut vec![corner / 3]);
        for &(u, length) in &all.found {
            let known = &mut straight[v as usize][u as usize];
            *known = known.min(length);
        }
    }
    let mut distances = vec![f64::INFINITY; n];
    for &source in sources {
        distances[source as usize] = 0.0;
    }
    for _ in 0..n {
        for (v, row) in straight.iter().enumerate() {
            for (u, length) in row.iter().enumerate() {
                distances[u] = distances[u].min(distances[v] + length);
            }
        }
    }
    distances
}

/// Returns the point to the left of a-b at these distances from a and b.
fn third(a: [f64; 2], b: [f64; 2], from_a: f64, from_b: f64) -> [f64; 2] {
    let along = [b[0] - a[0], b[1] - a[1]];
    let length = along[0].hypot(along[1]);
    let x = (length * length + from_a * from_a - from_b * from_b) / (2.0 * length);
    let y = (from_a * from_a - x * x).max(0.0).sqrt();
    let [s, t] = along.map(|k| k / length);
    [a[0] + x * s - y * t, a[1] + x * t + y * s]
}

fn turn(a: [f64; 2], b: [f64; 2]) -> f64 {
    (a[0] * b[1] - a[1] * b[0]) / (a[0].hypot(a[1]) * b[0].hypot(b[1]))
}

/// A vertex, and its place in the plane.
type Placed = (u32, [f64; 2]);

/// Sequences of different faces, unfolded around the origin.
struct Sequences<'a> {
    mesh: &'a TriMesh,
    edges: &'a Edges,
    /// The vertices seen from the origin, and how far away they are.
    found: Vec<(u32, f64)>,
}

impl Sequences<'_> {
    fn tail(&self, slot: u32) -> u32 {
        self.mesh.faces().as_flattened()[slot as usize]
    }

    fn apart(&self, a: u32, b: u32) -> f64 {
        distance(self.mesh.vertices()[a as usize], self.mesh.vertices()[b as usize])
    }

    /// Continues over the edge of a slot with what is seen between two directions; ends and
    /// directions are counter-clockwise.
    fn go_on(&mut self, slot: u32, ends: [Placed; 2], seen: [[f64; 2]; 2], faces: &mut Vec<u32>) {
        let edges = self.edges;
        let edge = edges.of_corners()[slot as usize];
        let [right, left] = ends;
        for &other in edges.corners().row(edge as usize) {
            if faces.contains(&(other / 3)) {
                continue;
            }
            let apex = self.tail(previous(other));
            // Away from the origin: to the right of the edge, seen counter-clockwise.
            let [a, b] = [left, right].map(|(v, _)| self.apart(v, apex));
            let tip = third(left.1, right.1, a, b);
            if turn(seen[0], tip) > -1e-11 && turn(tip, seen[1]) > -1e-11 {
                self.found.push((apex, tip[0].hypot(tip[1])));
            }
            let mut sides = [previous(other), next(other)];
            if self.tail(other) != right.0 {
                sides.reverse();
            }
            faces.push(other / 3);
            let ends = [[right, (apex, tip)], [(apex, tip), left]];
            for (side, ends) in sides.into_iter().zip(ends) {
                let [first, last] = ends.map(|(_, place)| place);
                let first = if turn(seen[0], first) > 0.0 { first } else { seen[0] };
                let last = if turn(last, seen[1]) > 0.0 { last } else { seen[1] };
                if turn(first, last) > 1e-13 {
                    self.go_on(side, ends, [first, last], faces);
                }
            }
            faces.pop();
        }
    }
}

/// Returns a small grid with random heights, of the kind of this round.
pub(super) fn random_surface(round: usize, rng: &mut Rng) -> TriMesh {
    let (x, y) = [(2, 2), (3, 2), (4, 1), (3, 3)][round % 4];
    // Heights of few values, so that paths tie and run through vertices, or of many.
    let height = |rng: &mut Rng| match round % 3 {
        0 => [0.0, 1.0][(rng.bits() % 2) as usize],
        1 => [0.0, 0.5, 3.0][(rng.bits() % 3) as usize],
        _ => 2.0 * rng.uniform(),
    };
    let (vertices, mut faces) =
        moved(&shapes::grid(x, y), |[x, y, _]| [x, y, height(rng)]).into_parts();
    // Faces of both orientations, holes, and edges of three faces.
    for face in &mut faces {
        if rng.bits().is_multiple_of(2) {
            face.swap(0, 1);
        }
    }
    if round.is_multiple_of(5) {
        faces.retain(|_| rng.uniform() < 0.85);
    }
    if round.is_multiple_of(7) {
        faces.push([0, x + 2, vertices.len() as u32 - 1]);
    }
    TriMesh::new(vertices, faces).unwrap()
}

#[test]
fn exact_distances_are_those_of_all_sequences_of_faces() {
    let mut rng = Rng::new(11);
    for round in 0..120 {
        let mesh = random_surface(round, &mut rng);
        let n = mesh.vertices().len() as u32;
        let sources = [(rng.bits() % u64::from(n)) as u32, n - 1];
        let sources = &sources[..1 + round % 2];
        let (found, exact) = (geodesics(&mesh, sources), by_all_sequences(&mesh, sources));
        for (v, (d, right)) in found.iter().zip(&exact).enumerate() {
            assert!(
                d == right || (d - right).abs() < 1e-10,
                "round {round}, from {sources:?} to {v}: {d} instead of {right}"
            );
        }
    }
}

#[test]
fn exact_distances_are_a_metric_between_straight_lines_and_paths_along_edges() {
    let mesh = families::figure(3, 0.3).unwrap();
    let p = mesh.vertices();
    let sources = [0, p.len() / 3, p.len() / 2];
    let found = sources.map(|source| geodesics(&mesh, &[source as u32]));
    let graph = Graph::of_mesh(&mesh);
    let mut search = Dijkstra::new(&graph);
    for (source, distances) in sources.iter().zip(&found) {
        search.search(&[(*source as u32, 0.0)], &SearchLimits::default()).unwrap();
        for v in 0..p.len() {
            let d = distances[v];
            assert!(d >= distance(p[v], p[*source]) - 1e-10, "{v}");
            assert!(d <= search.distance(v as u32) + 1e-10, "{v}");
        }
        for (other, to) in sources.iter().zip(&found) {
            assert!((distances[*other] - to[*source]).abs() < 1e-10);
            let apart = distances[*other];
            assert!((0..p.len()).all(|v| (distances[v] - to[v]).abs() <= apart + 1e-10));
        }
    }
    // The nearest of several.
    let all = geodesics(&mesh, &sources.map(|source| source as u32));
    for v in 0..p.len() {
        let nearest = found.iter().map(|distances| distances[v]).fold(f64::INFINITY, f64::min);
        assert!((all[v] - nearest).abs() < 1e-10, "{v}");
    }
}

#[test]
fn exact_distances_on_a_sphere_tend_to_arcs() {
    let mesh = shapes::sphere(3);
    let p = mesh.vertices();
    let found = geodesics(&mesh, &[0]);
    for (d, q) in found.iter().zip(p) {
        let arc = (0..3).map(|k| p[0][k] * q[k]).sum::<f64>().clamp(-1.0, 1.0).acos();
        // The polyhedron is inside the sphere, by less than 1 %.
        assert!(*d <= arc + 1e-12 && *d >= 0.99 * arc, "{d} and {arc}");
    }
}

#[test]
fn exact_distances_do_not_depend_on_orientations_or_the_order_of_faces() {
    let mesh = families::moebius(14, 3).unwrap();
    let (vertices, faces) = mesh.clone().into_parts();
    let turned = faces.iter().rev().map(|&[a, b, c]| [c, b, a]).collect();
    let turned = TriMesh::new(vertices, turned).unwrap();
    for (a, b) in geodesics(&mesh, &[5]).into_iter().zip(geodesics(&turned, &[5])) {
        assert!((a - b).abs() < 1e-12, "{a} and {b}");
    }
}

#[test]
fn exact_distances_are_infinite_where_no_source_is_and_wrong_input_is_named() {
    let (mut vertices, faces) =
        shapes::both(&shapes::sphere(1), &shapes::sphere(1), 5.0).into_parts();
    vertices.push([0.0, 9.0, 0.0]);
    let n = vertices.len();
    let mesh = TriMesh::new(vertices.clone(), faces.clone()).unwrap();
    let found = geodesics(&mesh, &[3, 3]);
    assert!(found[..n / 2].iter().all(|d| d.is_finite()) && found[3] == 0.0);
    assert!(found[n / 2..].iter().all(|&d| d == f64::INFINITY));
    assert!(geodesics(&mesh, &[]).iter().all(|&d| d == f64::INFINITY));
    assert_eq!(geodesics(&mesh, &[n as u32 - 1])[n - 1], 0.0);
    let solver = Geodesics::new(&mesh).unwrap();
    let beyond = Site::Vertex(n as u32);
    let refused = solver.distances(&[beyond]);
    assert!(matches!(refused, Err(Error::Argument { what: "sources", .. })));
    let refused = solver.path(&[Site::Vertex(0)], beyond);
    assert!(matches!(refused, Err(Error::Argument { what: "end", .. })));
    for through in [vec![], sites(&[0]), vec![beyond, Site::Vertex(0)]] {
        let refused = solver.path_through(&through);
        assert!(matches!(refused, Err(Error::Argument { what: "through", .. })));
    }
    let none = solver.path_through(&sites(&[0, 1, n as u32 - 1, 2])).unwrap();
    assert!(none.points.is_empty() && none.length == f64::INFINITY);
    // An edge without length.
    let [a, b, _] = faces[0];
    vertices[a as usize] = vertices[b as usize];
    let mesh = TriMesh::new(vertices, faces).unwrap();
    let error = Geodesics::new(&mesh).unwrap_err().to_string();
    assert!(error.contains("edge") && error.contains("too short"), "{error}");
}

/// Checks that both ends of each part of a path are in a common face, and that the lengths of the
/// parts add up.
pub(super) fn check_parts(mesh: &TriMesh, path: &GeodesicPath) {
    let points = path.positions(mesh);
    let length: f64 = points.windows(2).map(|pair| distance(pair[0], pair[1])).sum();
    assert!((length - path.length).abs() < 1e-9, "{length} and {}", path.length);
    for pair in path.points.windows(2) {
        let support = |i: usize| {
            let face = mesh.faces()[pair[i].face as usize];
            (0..3).filter(move |&k| pair[i].weights[k] > 0.0).map(move |k| face[k])
        };
        let both: Vec<u32> = support(0).chain(support(1)).collect();
        let has_both = |face: &[u32; 3]| both.iter().all(|v| face.contains(v));
        assert!(mesh.faces().iter().any(has_both), "{pair:?}");
    }
}

#[test]
fn the_parts_of_exact_paths_are_as_long_as_the_distance() {
    let (saddle, _) = cone(12, 5, 2.0, -2.0);
    let book = families::pages(5).unwrap();
    for mesh in [saddle, book, cube(), shapes::grid(7, 7), families::figure(3, 0.3).unwrap()] {
        let n = mesh.vertices().len() as u32;
        let solver = Geodesics::new(&mesh).unwrap();
        let sources = [n / 2, 1];
        let found = solver.distances(&sites(&sources)).unwrap();
        for to in (0..n).step_by(1 + n as usize / 40) {
            let path = solver.path(&sites(&sources), Site::Vertex(to)).unwrap();
            assert!((path.length - found[to as usize]).abs() < 1e-12);
            let points = path.positions(&mesh);
            let start = points[0];
            assert!(sources.iter().any(|&v| mesh.vertices()[v as usize] == start));
            assert_eq!(points.last(), Some(&mesh.vertices()[to as usize]));
            check_parts(&mesh, &path);
        }
    }
}

#[test]
fn an_exact_path_through_vertices_is_the_paths_one_after_the_other() {
    let mesh = shapes::grid(6, 6);
    let solver = Geodesics::new(&mesh).unwrap();
    let path = solver.path_through(&sites(&[0, 15, 40, 40, 6])).unwrap();
    let p = mesh.vertices();
    let length = distance(p[0], p[15]) + distance(p[15], p[40]) + distance(p[40], p[6]);
    assert!((path.length - length).abs() < 1e-12);
    let points = path.positions(&mesh);
    for v in [0, 15, 40, 6] {
        assert!(points.contains(&p[v]), "{v}");
    }
}
