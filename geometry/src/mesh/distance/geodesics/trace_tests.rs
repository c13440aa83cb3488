//! Geodesics that are traced from a point in a direction.

use std::f64::consts::TAU;

use super::tests::{check_parts, cone, cube, moved};
use super::*;
use crate::mesh::vector::{add, distance, dot, norm, scale, sub, unit};
use crate::mesh::{SurfacePoint, families, shapes};
use catamaran::base::Rng;

fn last(mesh: &TriMesh, trace: &GeodesicTrace) -> [f64; 3] {
    trace.path.points.last().unwrap().position(mesh)
}

fn random_start(mesh: &TriMesh, rng: &mut Rng) -> SurfacePoint {
    let face = (rng.bits() % mesh.faces().len() as u64) as u32;
    let weights = [0, 1, 2].map(|_| 0.05 + rng.uniform());
    let sum: f64 = weights.iter().sum();
    SurfacePoint { face, weights: weights.map(|w| w / sum) }
}

fn random_direction(rng: &mut Rng) -> [f64; 3] {
    [0, 1, 2].map(|_| 2.0 * rng.uniform() - 1.0)
}

#[test]
fn a_trace_on_a_plane_is_a_straight_line_and_stops_at_its_boundary() {
    let mut rng = Rng::new(5);
    let is_inside = |p: [f64; 3]| p[..2].iter().all(|x| *x > 0.5 && *x < 8.5);
    let mesh = moved(&shapes::grid(9, 9), |p| {
        let by = if is_inside(p) { 0.3 } else { 0.0 };
        [p[0] + by * (2.0 * rng.uniform() - 1.0), p[1] + by * (2.0 * rng.uniform() - 1.0), 0.0]
    });
    let solver = Geodesics::new(&mesh).unwrap();
    let mut stops = 0;
    for _ in 0..200 {
        let start = random_start(&mesh, &mut rng);
        let (from, mut to) = (start.position(&mesh), random_direction(&mut rng));
        let given = to;
        to[2] = 0.0;
        let to = unit(to);
        // Until the square ends.
        let ends = (0..2).map(|k| (if to[k] > 0.0 { 9.0 - from[k] } else { -from[k] }) / to[k]);
        let most = ends.fold(f64::INFINITY, f64::min);
        let length = 6.0 * rng.uniform();
        let trace = solver.trace(start.into(), given, length).unwrap();
        let far = length.min(most);
        assert!((trace.path.length - far).abs() < 1e-11, "{} and {far}", trace.path.length);
        assert_eq!(trace.end == TraceEnd::Boundary, length > most);
        stops += usize::from(length > most);
        let exact = add(from, scale(to, far));
        assert!(distance(last(&mesh, &trace), exact) < 1e-11, "{exact:?}");
        assert!(distance(trace.direction, to) < 1e-11);
        check_parts(&mesh, &trace.path);
    }
    assert!(stops > 20 && stops < 180, "{stops}");
}

#[test]
fn a_trace_through_flat_vertices_and_along_edges_is_straight() {
    let mesh = shapes::grid(8, 8);
    let solver = Geodesics::new(&mesh).unwrap();
    // From vertex 30 = (3, 3): along edges, diagonals, and to vertices over edges.
    for to in [[1, 0], [0, 1], [-1, 0], [0, -1], [1, 1], [-1, -1], [1, -1], [-1, 2], [2, 1]] {
        let to = [f64::from(to[0]), f64::from(to[1]), 0.0];
        let trace = solver.trace(Site::Vertex(30), to, 1.25 * norm(to)).unwrap();
        let exact = add([3.0, 3.0, 0.0], scale(to, 1.25));
        assert!(distance(last(&mesh, &trace), exact) < 1e-12, "{to:?}");
        assert_eq!(trace.end, TraceEnd::Complete);
        assert!(distance(trace.direction, unit(to)) < 1e-12);
        check_parts(&mesh, &trace.path);
    }
    // From every corner and the middle of every edge of a face, out of the face too.
    for weights in [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0], [0.5, 0.5, 0.0]] {
        for face in 54..58 {
            let start = SurfacePoint { face, weights };
            for i in 0..24 {
                let (y, x) = (TAU * f64::from(i) / 24.0).sin_cos();
                let trace = solver.trace(start.into(), [x, y, 0.7], 1.0).unwrap();
                let exact = add(start.position(&mesh), [x, y, 0.0]);
                assert!(distance(last(&mesh, &trace), exact) < 1e-12, "{start:?} {x} {y}");
            }
        }
    }
}

#[test]
fn a_trace_on_a_cube_is_straight_on_the_unfolded_sides() {
    let mesh = cube();
    let solver = Geodesics::new(&mesh).unwrap();
    // The side y = 0 has the faces [0, 1, 4] and [1, 5, 4]: here (0.3, 0, 0.2) on the former.
    let start = SurfacePoint { face: 4, weights: [0.5, 0.3, 0.2] };
    assert!(distance(start.position(&mesh), [0.3, 0.0, 0.2]) < 1e-15);
    // Around the four upright sides, which are a strip.
    for (slope, length) in [(0.0, 4.0), (0.05, 2.9), (0.1, 5.1), (-0.04, 3.3)] {
        let trace = solver.trace(start.into(), [1.0, 0.0, slope], length).unwrap();
        let size = f64::hypot(1.0, slope);
        let (along, z) = (0.3 + length / size, 0.2 + slope * length / size);
        let (side, x) = (along.floor() as usize % 4, along.fract());
        let exact = [[x, 0.0, z], [1.0, x, z], [1.0 - x, 1.0, z], [0.0, 1.0 - x, z]][side];
        let found = last(&mesh, &trace);
        assert!(distance(found, exact) < 1e-12, "{slope} {length}: {found:?} and {exact:?}");
        check_parts(&mesh, &trace.path);
    }
    // Over the upper edge onto the side z = 1.
    let trace = solver.trace(start.into(), [0.2, 0.0, 1.0], 1.3 * f64::hypot(1.0, 0.2)).unwrap();
    assert!(distance(last(&mesh, &trace), [0.3 + 0.26, 0.5, 1.0]) < 1e-12);
    assert!(distance(trace.direction, unit([0.2, 1.0, 0.0])) < 1e-12);
    // Along an edge, through a corner of three right angles: half of them leads halfway between the
    // edges of the side beyond.
    let trace = solver.trace(Site::Vertex(0), [1.0, 0.0, 0.0], 1.0 + 0.5 * 2f64.sqrt()).unwrap();
    assert!(distance(last(&mesh, &trace), [1.0, 0.5, 0.5]) < 1e-12, "{trace:?}");
}

#[test]
fn a_trace_through_the_tip_of_a_cone_has_equal_angles_on_both_sides() {
    // Pointed, flat, and saddles of more than a full turn around the tip.
    for (up, down) in [(0.8, 0.8), (0.0, 0.0), (0.6, -0.6), (2.0, -2.0)] {
        let (mesh, _) = cone(12, 5, up, down);
        let p = mesh.vertices();
        let solver = Geodesics::new(&mesh).unwrap();
        for ray in 0..12_u32 {
            // From the second ring by way of the first and the tip to between rings 2 and 3.
            let (from, opposite) = (1 + 12 + ray, 1 + (ray + 6) % 12);
            let to = scale(p[from as usize], -1.0);
            let beyond = 2.5 * norm(p[opposite as usize]);
            let trace = solver.trace(Site::Vertex(from), to, norm(to) + beyond).unwrap();
            let exact = scale(p[opposite as usize], 2.5);
            let found = last(&mesh, &trace);
            assert!(distance(found, exact) < 1e-11, "{up} {down} {ray}: {found:?}, {exact:?}");
            check_parts(&mesh, &trace.path);
        }
    }
}

#[test]
fn traces_around_a_sphere_close_the_better_the_finer_it_is() {
    let mut rng = Rng::new(2);
    for level in 2..=5 {
        let mesh = shapes::sphere(level);
        let solver = Geodesics::new(&mesh).unwrap();
        let sides = mesh.faces().iter().flat_map(|&face| {
            let corners = mesh.corners_of(face);
            [0, 1, 2].map(|k| distance(corners[k], corners[(k + 1) % 3]))
        });
        let longest = sides.fold(0.0, f64::max);
        let (mut sum, mut worst) = (0.0, 0.0_f64);
        let count = 40;
        for _ in 0..count {
            let start = random_start(&mesh, &mut rng);
            let trace = solver.trace(start.into(), random_direction(&mut rng), TAU).unwrap();
            let gap = distance(last(&mesh, &trace), start.position(&mesh));
            sum += gap;
            worst = worst.max(gap);
        }
        // A geodesic passes each vertex, of a curvature of h^2, on one side or the other: of the
        // 1 / h vertices on its way a gap of about h^1.5 is left. Measured on these levels: means
        // of 0.9 to 2.1 h^2, largest gaps of 0.4 to 0.55 h.
        let mean = sum / f64::from(count);
        assert!(mean < 4.0 * longest.powi(2), "level {level}: {mean}");
        assert!(worst < longest, "level {level}: {worst}");
    }
}

#[test]
fn a_trace_from_the_end_of_another_in_the_opposite_direction_returns() {
    let mut rng = Rng::new(13);
    let figure = families::figure(3, 0.3).unwrap();
    let (saddle, _) = cone(12, 5, 0.6, -0.6);
    let moebius = families::moebius(14, 3).unwrap();
    for mesh in [figure, saddle, moebius, cube(), shapes::shaken(&shapes::sphere(2), 0.02, 3)] {
        let solver = Geodesics::new(&mesh).unwrap();
        for _ in 0..40 {
            let start = random_start(&mesh, &mut rng);
            let length = 2.0 * rng.uniform();
            let there = solver.trace(start.into(), random_direction(&mut rng), length).unwrap();
            check_parts(&mesh, &there.path);
            let (end, far) = (*there.path.points.last().unwrap(), there.path.length);
            let back = solver.trace(end.into(), scale(there.direction, -1.0), far).unwrap();
            assert!(back.end == TraceEnd::Complete && back.path.length == far);
            let (from, to) = (start.position(&mesh), last(&mesh, &back));
            assert!(distance(from, to) < 1e-8, "{start:?}, {far}: {from:?} and {to:?}");
        }
    }
}

#[test]
fn a_trace_goes_on_from_its_end() {
    let mut rng = Rng::new(23);
    let mesh = families::figure(3, 0.3).unwrap();
    let solver = Geodesics::new(&mesh).unwrap();
    for _ in 0..40 {
        let start = random_start(&mesh, &mut rng);
        let direction = random_direction(&mut rng);
        let whole = solver.trace(start.into(), direction, 1.0).unwrap();
        let half = solver.trace(start.into(), direction, 0.4).unwrap();
        let middle = *half.path.points.last().unwrap();
        let rest = solver.trace(middle.into(), half.direction, 0.6).unwrap();
        assert!(distance(last(&mesh, &whole), last(&mesh, &rest)) < 1e-9);
        // The points where it crosses edges are on the way too.
        if let [first, crossing, ..] = whole.path.points[..] {
            let to = sub(crossing.position(&mesh), first.position(&mesh));
            // The crossing, in the face that the geodesic leaves there.
            let far = norm(to);
            let on = solver.trace(crossing.into(), to, 1.0 - far).unwrap();
            if first.face == crossing.face {
                assert!(distance(last(&mesh, &whole), last(&mesh, &on)) < 1e-8);
            }
        }
    }
}

#[test]
fn a_trace_stops_where_more_than_one_way_leads_on() {
    // Five pages on one edge.
    let mesh = families::pages(5).unwrap();
    let solver = Geodesics::new(&mesh).unwrap();
    let start = SurfacePoint { face: 2, weights: [0.3, 0.3, 0.4] };
    let [from, edge] = [start, SurfacePoint { face: 2, weights: [0.5, 0.5, 0.0] }]
        .map(|point| point.position(&mesh));
    let trace = solver.trace(start.into(), sub(edge, from), 5.0).unwrap();
    assert_eq!(trace.end, TraceEnd::NonManifold);
    assert!((trace.path.length - distance(edge, from)).abs() < 1e-14);
    // Away from it, out of the page.
    let trace = solver.trace(start.into(), sub(from, edge), 5.0).unwrap();
    assert_eq!(trace.end, TraceEnd::Boundary);
    // Through the vertex that two closed surfaces share.
    let mesh = families::bow_tie().unwrap();
    let solver = Geodesics::new(&mesh).unwrap();
    let [shared, other] = [0, mesh.faces()[0].into_iter().find(|&v| v != 0).unwrap()];
    let p = mesh.vertices();
    let to = sub(p[shared as usize], p[other as usize]);
    let trace = solver.trace(Site::Vertex(other), to, 2.0 * norm(to)).unwrap();
    assert_eq!(trace.end, TraceEnd::NonManifold);
    assert!((trace.path.length - norm(to)).abs() < 1e-14);
}

#[test]
fn a_trace_from_a_vertex_starts_in_the_nearest_direction_or_is_refused() {
    let mesh = cube();
    let solver = Geodesics::new(&mesh).unwrap();
    // Inside the cube, nearest to the diagonal of the side z = 0.
    let trace = solver.trace(Site::Vertex(0), [1.0, 1.0, 0.2], 0.5).unwrap();
    assert!(distance(last(&mesh, &trace), scale(unit([1.0, 1.0, 0.0]), 0.5)) < 1e-14);
    // Outside the cube, nearest to an edge.
    let trace = solver.trace(Site::Vertex(0), [1.0, -0.2, -0.2], 0.5).unwrap();
    assert!(distance(last(&mesh, &trace), [0.5, 0.0, 0.0]) < 1e-14);
    let near = solver.trace(Site::Near([-0.1; 3]), [1.0, -0.2, -0.2], 0.5).unwrap();
    assert_eq!(near, trace);
    let said =
        |start, direction, length| solver.trace(start, direction, length).unwrap_err().to_string();
    let away = said(Site::Vertex(0), [-1.0; 3], 1.0);
    assert!(away.starts_with("direction: points away from the surface at vertex 0"), "{away}");
    let side = Site::Face(SurfacePoint { face: 0, weights: [0.2, 0.3, 0.5] });
    let normal = said(side, [0.0, 0.0, 2.0], 1.0);
    assert!(normal.starts_with("direction: is perpendicular to face 0"), "{normal}");
    assert!(said(side, [0.0; 3], 1.0).starts_with("direction: must be finite and not 0"));
    assert!(said(side, [f64::NAN, 0.0, 0.0], 1.0).starts_with("direction: must be finite"));
    assert!(said(side, [1.0, 0.0, 0.0], -1.0).starts_with("length: must be finite"));
    assert!(said(side, [1.0, 0.0, 0.0], f64::INFINITY).starts_with("length: must be finite"));
    // Directions of any length.
    for size in [1e-300, 1e300] {
        let trace = solver.trace(side, [size, 0.0, 0.0], 0.25).unwrap();
        assert!((dot(trace.direction, [1.0, 0.0, 0.0]) - 1.0).abs() < 1e-14);
    }
    // Without a length there is a point, and from the boundary no way leads out.
    let trace = solver.trace(side, [1.0, 0.0, 0.0], 0.0).unwrap();
    assert_eq!((trace.path.points.len(), trace.end), (1, TraceEnd::Complete));
    let square = shapes::grid(2, 2);
    let solver = Geodesics::new(&square).unwrap();
    for to in [[-1.0, 0.0, 0.0], [-1.0, 0.2, 0.0], [-1.0, -1.0, 0.0]] {
        // The vertex (0, 1).
        let trace = solver.trace(Site::Vertex(3), to, 1.0).unwrap();
        assert_eq!((trace.end, trace.path.length), (TraceEnd::Boundary, 0.0), "{to:?}");
    }
    let up = solver.trace(Site::Vertex(3), [0.0, 0.0, 1.0], 1.0).unwrap_err().to_string();
    assert!(up.starts_with("direction: points away from the surface at vertex 3"), "{up}");
}
