use std::collections::HashSet;
use std::ops::ControlFlow;

use super::dataset::{Generator, Sampling, samples, scaled};
use super::*;
use crate::mesh::vector::distance;
use crate::mesh::{Adjacency, Graph, Search, SurfacePoint, TriMesh, families, shapes};
use catamaran::base::{Error, Progress, Rng};

const FAITHFUL: CurveOptions<'_> = CurveOptions {
    mode: Mode::Faithful,
    open: false,
    count: Count::Automatic,
    steiner: true,
    drop_outliers: false,
    candidates: 5,
    start: 0,
    progress: Progress::none(),
};

fn robust() -> CurveOptions<'static> {
    CurveOptions::default()
}

fn found(mesh: &TriMesh, samples: &[u32], options: &CurveOptions<'_>) -> Reconstruction {
    CurveSolver::new(mesh).unwrap().reconstruct(samples, options).unwrap()
}

fn refusal(mesh: &TriMesh, samples: &[u32], options: &CurveOptions<'_>) -> String {
    CurveSolver::new(mesh).unwrap().reconstruct(samples, options).unwrap_err().to_string()
}

/// Asserts steps along edges, no vertex twice in all curves, samples in their order, and lengths
/// that are those of the edges.
fn check(mesh: &TriMesh, samples: &[u32], result: &Reconstruction) {
    let refined = refined(mesh, &result.steiner).unwrap();
    let edges: Adjacency = refined.vertex_neighbors();
    let mut seen = HashSet::new();
    for curve in &result.curves {
        let mut length = 0.0;
        let ends = curve.path.iter().zip(curve.path.iter().cycle().skip(1));
        for (&v, &u) in ends.take(curve.path.len() - usize::from(!curve.closed)) {
            assert!(edges.row(v as usize).contains(&u), "{v} {u}");
            length += distance(refined.vertices()[v as usize], refined.vertices()[u as usize]);
        }
        assert!((length - curve.length).abs() <= 1e-12 * length, "{length} {}", curve.length);
        assert!(curve.path.iter().all(|&v| seen.insert(v)), "a vertex twice");
        let on_path: Vec<u32> = (curve.path.iter())
            .filter_map(|v| samples.iter().position(|s| s == v))
            .map(|i| i as u32)
            .collect();
        assert_eq!(on_path[..], curve.order[..on_path.len()]);
        let points: Vec<_> = curve.path.iter().map(|&v| refined.vertices()[v as usize]).collect();
        assert_eq!(points, curve.points);
    }
    if result.outcome.is_complete() {
        let off = [&result.left_out[..], &result.outliers].concat();
        let left_out = |i: usize| off.contains(&(i as u32));
        assert!(samples.iter().enumerate().all(|(i, v)| seen.contains(v) != left_out(i)));
    }
}

/// Returns a vertex of a square grid of n x n cells in the plane.
fn at(n: u32, x: u32, y: u32) -> u32 {
    y * (n + 1) + x
}

#[test]
fn the_four_corners_of_a_square_are_joined_by_its_sides() {
    let mesh = shapes::grid(8, 8);
    let corners = [at(8, 1, 1), at(8, 7, 7), at(8, 7, 1), at(8, 1, 7)];
    for options in [robust(), FAITHFUL] {
        let result = found(&mesh, &corners, &options);
        check(&mesh, &corners, &result);
        assert_eq!(result.outcome, Outcome::Closed);
        assert!(same_order(&result.curves[0].order, &[0, 2, 1, 3]), "{:?}", result.curves[0].order);
        assert_eq!(result.length(), 24.0);
        assert!(result.steiner.is_empty());
    }
}

#[test]
fn an_open_curve_has_its_ends_where_samples_end() {
    let mesh = shapes::grid(12, 4);
    let line: Vec<u32> = [8, 2, 10, 4, 6].map(|x| at(12, x, 2)).to_vec();
    let options = CurveOptions { open: true, ..robust() };
    let result = found(&mesh, &line, &options);
    check(&mesh, &line, &result);
    assert_eq!(result.outcome, Outcome::Open);
    assert_eq!(result.curves[0].order, [1, 3, 4, 0, 2]);
    assert_eq!(result.length(), 8.0);
    let options = CurveOptions { open: true, start: 1, ..FAITHFUL };
    let result = found(&mesh, &line, &options);
    check(&mesh, &line, &result);
    assert_eq!(
        (result.outcome, &result.curves[0].order[..]),
        (Outcome::Open, &[1, 3, 4, 0, 2][..])
    );
}

#[test]
fn the_angle_decides_among_candidates() {
    // From 0 over 1, the nearest sample is 2, but 3 lies straight ahead.
    let mesh = shapes::grid(20, 8);
    let points = [at(20, 2, 4), at(20, 6, 4), at(20, 6, 7), at(20, 10, 4), at(20, 14, 1)];
    let order = |candidates| {
        let options = CurveOptions { candidates, ..FAITHFUL };
        found(&mesh, &points, &options).curves[0].order.clone()
    };
    assert_eq!(order(1)[..3], [0, 1, 2]);
    assert_eq!(order(3)[..3], [0, 1, 3]);
}

#[test]
fn two_rings_far_apart_are_two_curves_unless_one_is_asked_for() {
    let mesh = families::cylinder(24, 60, 1.0, 20.0).unwrap();
    let ring = |row: u32| (0..24).step_by(3).map(move |i| 61 * i + row);
    let both: Vec<u32> = ring(10).chain(ring(50)).collect();
    let result = found(&mesh, &both, &robust());
    check(&mesh, &both, &result);
    assert_eq!((result.outcome, result.curves.len()), (Outcome::Closed, 2));
    assert!(result.curves.iter().all(|curve| curve.order.len() == 8 && curve.path.len() == 24));
    let one = found(&mesh, &both, &CurveOptions { count: Count::One, ..robust() });
    assert_eq!(one.curves.len(), 1);
}

#[test]
fn samples_on_two_components_are_two_curves_or_disconnected() {
    let mesh = families::spheres(2, 2).unwrap();
    let n = mesh.vertices().len() as u32 / 2;
    let both = [0, 1, 5, n, n + 1, n + 5];
    let result = found(&mesh, &both, &robust());
    check(&mesh, &both, &result);
    assert_eq!((result.outcome, result.curves.len()), (Outcome::Closed, 2));
    let disconnected = Outcome::Disconnected { components: 2 };
    assert_eq!(
        found(&mesh, &both, &CurveOptions { count: Count::One, ..robust() }).outcome,
        disconnected
    );
    let result = found(&mesh, &both, &FAITHFUL);
    assert_eq!(result.outcome, disconnected);
    assert_eq!(result.curves[0].order.len(), 3, "the first component is walked all the same");
}

#[test]
fn samples_on_components_with_fewer_than_three_are_left_out_and_others_get_their_curve() {
    let mesh = families::spheres(4, 2).unwrap();
    let n = mesh.vertices().len() as u32 / 4;
    // One sample on the third sphere, two on the first, three on the second, none on the last.
    let samples = [2 * n, 0, n, n + 1, n + 5, 7];
    let result = found(&mesh, &samples, &robust());
    check(&mesh, &samples, &result);
    assert_eq!((result.outcome, result.curves.len()), (Outcome::Closed, 1));
    assert_eq!(result.left_out, [0, 1, 5]);
    // Without a component of three samples there is no curve, and its length is 0, not -0.
    let result = found(&mesh, &[2 * n, 0, 7], &robust());
    assert_eq!(result.outcome, Outcome::Disconnected { components: 2 });
    assert_eq!((result.left_out.len(), result.length().to_bits()), (3, 0));
}

/// Returns a torus, samples around its outer equator, and these with four strays among them, two of
/// which are beside each other.
fn with_strays() -> (TriMesh, Vec<u32>, Vec<u32>) {
    let mesh = families::torus(60, 30, 2.0, 0.8).unwrap();
    let around: Vec<u32> = (0..60).map(|i| 30 * ((7 * i) % 60)).collect();
    let mut all = around.clone();
    // Vertices 30 i + j lie around the tube at i: a quarter above and below.
    for (place, stray) in [(3, 308), (8, 922), (15, 1508), (16, 1509)] {
        all.insert(place, stray);
    }
    (mesh, around, all)
}

#[test]
fn without_its_outliers_a_curve_is_that_of_the_other_samples() {
    let (mesh, around, all) = with_strays();
    let drop = CurveOptions { drop_outliers: true, ..robust() };
    let alone = found(&mesh, &around, &robust());
    let result = found(&mesh, &all, &drop);
    check(&mesh, &all, &result);
    assert_eq!(result.outliers, [3, 8, 15, 16]);
    assert_eq!((result.outcome, result.left_out.len()), (Outcome::Closed, 0));
    assert_eq!(result.curves.len(), 1);
    assert_eq!(result.curves[0].path, alone.curves[0].path);
    let at = |samples: &[u32], order: &[u32]| -> Vec<u32> {
        order.iter().map(|&i| samples[i as usize]).collect()
    };
    let orders = (at(&all, &result.curves[0].order), at(&around, &alone.curves[0].order));
    assert_eq!(orders.0, orders.1);
    assert_eq!(result.length().to_bits(), alone.length().to_bits());
    // The strays make the curve longer where they stay, and no sample of the curve is dropped.
    let spiky = found(&mesh, &all, &robust());
    assert!(spiky.outliers.is_empty() && spiky.length() > 1.3 * alone.length());
    assert_eq!(found(&mesh, &around, &drop), alone);
}

#[test]
fn outliers_of_open_and_ordered_curves_are_dropped_and_their_ends_stay() {
    let mesh = shapes::grid(30, 12);
    // A line of samples 2 apart; strays 10 beside its middle, and 15 beyond its end.
    let line: Vec<u32> = (1..8).map(|i| at(30, 2 * i, 2)).collect();
    let with = |place: usize, stray: u32| {
        let mut all = line.clone();
        all.insert(place, stray);
        all
    };
    for mode in [Mode::Robust, Mode::Ordered] {
        let options = CurveOptions { open: true, drop_outliers: true, mode, ..robust() };
        let straight = found(&mesh, &line, &options);
        assert_eq!((straight.outcome, straight.length()), (Outcome::Open, 12.0), "{mode:?}");
        for (place, stray) in [(4, at(30, 9, 12)), (7, at(30, 29, 2))] {
            let result = found(&mesh, &with(place, stray), &options);
            assert_eq!(result.outliers, [place as u32], "{mode:?}");
            assert_eq!(result.curves[0].path, straight.curves[0].path);
        }
        // Five times the usual distance: a long gap at the end.
        let result = found(&mesh, &with(7, at(30, 24, 2)), &options);
        assert_eq!((result.outliers.len(), result.length()), (0, 22.0), "{mode:?}");
    }
}

#[test]
fn a_smooth_curve_is_not_held_by_an_outlier_that_it_runs_over() {
    let mesh = shapes::grid(30, 12);
    // Along a line that edges do not follow, and back.
    let slanted = (0..7).map(|i| at(30, 2 + 3 * i, 8 - i));
    let back = [(20, 5), (20, 8)].into_iter().chain((0..7).map(|i| (20 - 3 * i, 11)));
    let samples: Vec<u32> = slanted.chain(back.map(|(x, y)| at(30, x, y))).collect();
    let options = CurveOptions { drop_outliers: true, mode: Mode::Ordered, ..robust() };
    let mut alone = found(&mesh, &samples, &options);
    let path = alone.curves[0].path.clone();
    alone.smooth(&mesh, &samples).unwrap();
    let second = path.iter().position(|&v| v == samples[1]).unwrap();
    assert!(second > 3);
    for &on_the_way in &path[1..second] {
        // Far away in the order.
        let mut all = samples.clone();
        all.insert(12, on_the_way);
        let mut result = found(&mesh, &all, &options);
        assert_eq!((&result.outliers[..], &result.curves[0].path), (&[12][..], &path));
        result.smooth(&mesh, &all).unwrap();
        assert_eq!(result.length().to_bits(), alone.length().to_bits());
    }
}

#[test]
fn samples_alone_on_a_component_are_left_out_of_the_one_curve_of_the_others() {
    let mesh = families::spheres(2, 2).unwrap();
    let n = mesh.vertices().len() as u32 / 2;
    let both = [n, 0, 1, n + 1, 5, 9];
    for mode in [Mode::Robust, Mode::Ordered] {
        let one = CurveOptions { count: Count::One, mode, ..robust() };
        let disconnected = Outcome::Disconnected { components: 2 };
        assert_eq!(found(&mesh, &both, &one).outcome, disconnected);
        let result = found(&mesh, &both, &CurveOptions { drop_outliers: true, ..one });
        assert_eq!((result.outcome, &result.left_out[..]), (Outcome::Closed, &[0, 3][..]));
        check(&mesh, &both, &result);
    }
    let faithful = CurveOptions { drop_outliers: true, ..FAITHFUL };
    let why = refusal(&mesh, &both, &faithful);
    assert_eq!(why, "drop_outliers: the faithful mode takes every sample");
}

#[test]
fn at_least_half_of_the_samples_stay() {
    // Each power of four is an outlier to the lower ones.
    let mesh = shapes::grid(16384, 1);
    let out_and_back = [0, 4, 64, 1024, 16384, 4096, 256, 16, 1];
    let mode = Mode::Ordered;
    let options = CurveOptions { drop_outliers: true, steiner: false, mode, ..robust() };
    let result = found(&mesh, &out_and_back, &options);
    assert_eq!(result.outliers, [3, 4, 5, 6]);
    assert_eq!(found(&mesh, &out_and_back[..4], &options).outliers.len(), 0);
}

#[test]
fn bad_samples_are_refused_by_number() {
    let mesh = shapes::sphere(1);
    for options in [robust(), FAITHFUL] {
        assert_eq!(refusal(&mesh, &[1, 2], &options), "samples: must be at least 3, are 2");
        assert_eq!(refusal(&mesh, &[], &options), "samples: must be at least 3, are 0");
        assert_eq!(
            refusal(&mesh, &[1, 2, 42], &options),
            "samples: sample 2 is vertex 42, out of range: 42 vertices"
        );
        assert_eq!(
            refusal(&mesh, &[7, 2, 3, 7], &options),
            "samples: sample 3 is vertex 7, as sample 0"
        );
    }
    let none = CurveOptions { candidates: 0, ..FAITHFUL };
    assert_eq!(refusal(&mesh, &[1, 2, 3], &none), "candidates: must be at least 1, is 0");
    let beyond = CurveOptions { start: 3, ..FAITHFUL };
    assert_eq!(refusal(&mesh, &[1, 2, 3], &beyond), "start: must be below 3, is 3");
    let (mut vertices, faces) = mesh.into_parts();
    vertices.push([0.0; 3]);
    let loose = TriMesh::new(vertices, faces).unwrap();
    assert_eq!(refusal(&loose, &[1, 2, 42], &robust()), "vertex 42: sample 2 is in no face");
    let empty = TriMesh::new(vec![], vec![]).unwrap();
    assert!(refusal(&empty, &[0, 1, 2], &robust()).contains("vertex 0, out of range: 0 vertices"));
}

#[test]
fn a_strip_that_a_curve_cannot_come_back_on_is_said_to_be_one() {
    // The samples span a strip one cell wide: no path leads back past them.
    let mesh = shapes::grid(9, 1);
    let across = [at(9, 2, 0), at(9, 4, 0), at(9, 4, 1), at(9, 6, 0), at(9, 6, 1), at(9, 8, 0)];
    let result = found(&mesh, &across[..], &CurveOptions { steiner: false, ..robust() });
    check(&mesh, &across, &result);
    assert!(!matches!(result.outcome, Outcome::Disconnected { .. } | Outcome::Open));
    let middle = [at(9, 0, 0), at(9, 3, 0), at(9, 3, 1), at(9, 9, 1)];
    let result = found(&mesh, &middle, &FAITHFUL);
    check(&mesh, &middle, &result);
}

#[test]
fn steiner_points_make_room_where_vertices_leave_none() {
    // The six corners of an octahedron: all vertices are samples, in an order in which paths would
    // have to cross.
    let mesh = families::icosphere(0).unwrap();
    let surface = &mut surface::Surface::new(std::borrow::Cow::Borrowed(&mesh));
    let n = mesh.vertices().len();
    let mut search = Search::new(n).unwrap();
    let (mut marks, mut users, mut history) = (vec![0; n], vec![0; n], vec![0.0; n]);
    let all: Vec<u32> = (0..n as u32).collect();
    // In an icosahedron, 0 and 3, 1 and 2 are opposite each other, so that no edge joins them.
    let nets: Vec<(u32, u32)> = vec![(0, 3), (3, 1), (1, 2), (2, 5), (5, 4), (4, 0)];
    for (steiner, complete) in [(false, false), (true, true)] {
        let mut router = route::Router {
            surface,
            search: &mut search,
            marks: &mut marks,
            users: &mut users,
            history: &mut history,
        };
        let paths = router.route(&nets, &all, steiner, Progress::none()).unwrap();
        assert_eq!(paths.iter().all(Option::is_some), complete);
        let inner: Vec<u32> =
            paths.iter().flatten().flat_map(|p| p[1..p.len() - 1].to_vec()).collect();
        assert_eq!(inner.iter().collect::<HashSet<_>>().len(), inner.len(), "paths meet");
        assert!(inner.iter().all(|v| !all.contains(v)), "a path over a sample");
        assert_eq!((marks.len(), marks.iter().sum::<u8>(), users.iter().sum::<u16>()), (n, 0, 0));
    }
    assert!(surface.len() > n);
}

#[test]
fn a_tour_through_points_of_a_circle_goes_around_it() {
    let mesh = families::disk(40, 96).unwrap();
    let ring: Vec<u32> = (0..96).map(|i| 1 + 30 * 96 + i).collect();
    let mut rng = Rng::new(3);
    for k in [4, 5, 7, 8, 13, 40] {
        let x = samples(&ring, k, Sampling::Even, &mut rng);
        let result = found(&mesh, &x.vertices, &robust());
        check(&mesh, &x.vertices, &result);
        assert!(same_order(&result.curves[0].order, &x.order), "{k}");
    }
}

#[test]
fn results_do_not_depend_on_what_was_reconstructed_before() {
    let mesh = families::torus(40, 20, 2.0, 0.8).unwrap();
    let samples = [0, 405, 210, 600, 102, 707, 333, 555];
    for options in [robust(), FAITHFUL] {
        let mut solver = CurveSolver::new(&mesh).unwrap();
        let first = solver.reconstruct(&samples, &options).unwrap();
        solver.reconstruct(&[3, 99, 501, 640], &robust()).unwrap();
        solver.reconstruct(&[3, 99, 501, 640], &FAITHFUL).unwrap();
        assert!(solver.reconstruct(&[3, 3, 3], &options).is_err());
        let again = solver.reconstruct(&samples, &options).unwrap();
        assert_eq!(first, again);
        check(&mesh, &samples, &first);
    }
}

#[test]
fn a_call_can_be_cancelled_and_leaves_the_solver_as_it_was() {
    let mesh = families::torus(40, 20, 2.0, 0.8).unwrap();
    let samples = [0, 405, 210, 600, 102];
    for options in [robust(), FAITHFUL] {
        let mut solver = CurveSolver::new(&mesh).unwrap();
        let whole = solver.reconstruct(&samples, &options).unwrap();
        for limit in [0.0, 0.3, 0.6] {
            let watch = move |fraction: f64| {
                if fraction < limit { ControlFlow::Continue(()) } else { ControlFlow::Break(()) }
            };
            let cancelled = CurveOptions { progress: (&watch).into(), ..options.clone() };
            assert_eq!(solver.reconstruct(&samples, &cancelled), Err(Error::Cancelled));
        }
        assert_eq!(solver.reconstruct(&samples, &options).unwrap(), whole);
    }
}

#[test]
fn curves_of_the_data_set_are_closed_paths_that_a_seed_gives_again() {
    let mesh = scaled(&families::torus(120, 50, 2.0, 0.8).unwrap()).unwrap();
    assert!((mesh.volume().unwrap() - 1.0).abs() < 1e-9);
    let graph = Graph::of_mesh(&mesh);
    let edges = mesh.vertex_neighbors();
    let mut generator = Generator::new(&graph, 5).unwrap();
    let curves: Vec<Vec<u32>> = (0..3).map(|_| generator.curve().unwrap().unwrap()).collect();
    for curve in &curves {
        assert!(curve.len() >= dataset::LEAST_VERTICES);
        for (&v, u) in curve.iter().zip(curve.iter().cycle().skip(1)) {
            assert!(edges.row(v as usize).contains(u));
        }
        assert_eq!(curve.iter().collect::<HashSet<_>>().len(), curve.len());
    }
    let mut again = Generator::new(&graph, 5).unwrap();
    assert!(curves.iter().all(|curve| again.curve().unwrap().as_ref() == Some(curve)));
    assert_ne!(Generator::new(&graph, 6).unwrap().curve().unwrap().as_ref(), Some(&curves[0]));
    // A mesh that is too small for such a curve.
    let small = Graph::of_mesh(&families::icosphere(1).unwrap());
    assert_eq!(Generator::new(&small, 1).unwrap().curve().unwrap(), None);
}

#[test]
fn samples_have_the_order_of_their_curve() {
    let curve: Vec<u32> = (100..230).collect();
    let mut rng = Rng::new(1);
    for sampling in [Sampling::Even, Sampling::Random] {
        for k in [0, 1, 10, 97, 130, 200] {
            let x = samples(&curve, k, sampling, &mut rng);
            let ordered: Vec<u32> = x.order.iter().map(|&i| x.vertices[i as usize]).collect();
            assert_eq!(ordered.len(), k.min(130));
            assert!(ordered.is_sorted_by(|a, b| a < b));
        }
    }
    let x = samples(&curve, 10, Sampling::Even, &mut rng);
    let mut places = x.vertices.clone();
    places.sort_unstable();
    assert_eq!(places, (0..10).map(|i| 100 + 13 * i).collect::<Vec<u32>>());
}

#[test]
fn orders_are_equal_up_to_rotation_and_reversal() {
    assert!(same_order(&[2, 3, 0, 1], &[0, 1, 2, 3]) && same_order(&[1, 0, 3, 2], &[0, 1, 2, 3]));
    assert!(!same_order(&[0, 2, 1, 3], &[0, 1, 2, 3]) && !same_order(&[0, 1], &[0, 1, 2]));
    assert!(same_order(&[], &[]) && !same_order(&[4, 1, 2], &[0, 1, 2]));
}

#[test]
fn sites_are_snapped_or_inserted() {
    let mesh = shapes::grid(2, 1);
    let third = 1.0 / 3.0;
    let on_face = |face, weights| Site::Face(SurfacePoint { face, weights });
    let sites = [
        Site::Vertex(5),
        Site::Near([1.9, 0.2, 3.0]),
        on_face(0, [0.1, 0.2, 0.7]),
        on_face(0, [third, third, third]),
        on_face(0, [0.5, 0.0, 0.5]),
        on_face(1, [0.5, 0.5, 0.0]),
        on_face(1, [0.0, 1.0, 0.0]),
    ];
    let snapped = place(&mesh, &sites, Placement::Snap).unwrap();
    assert_eq!((snapped.mesh, &snapped.vertices[..3]), (None, &[5, 2, 4][..]));
    let inserted = place(&mesh, &sites, Placement::Insert).unwrap();
    // The middle of the diagonal is one point, given on either face.
    assert_eq!(inserted.vertices, [5, 2, 6, 7, 8, 8, 4]);
    let refined = inserted.mesh.unwrap().mesh;
    assert_eq!(refined.vertices()[8], [0.5, 0.5, 0.0]);
    assert!((refined.area() - mesh.area()).abs() < 1e-14);
    assert!(refined.face_normals().iter().all(|n| n[2] == 1.0), "a face is turned over");
    assert!(refined.require_manifold().is_ok());
    let refused = |site| place(&mesh, &[site], Placement::Insert).unwrap_err().to_string();
    assert!(refused(Site::Vertex(6)).contains("site 0: vertex 6 is out of range: 6 vertices"));
    let beyond = refused(on_face(4, [1.0, 0.0, 0.0]));
    assert!(beyond.contains("site 0: face 4 is out of range: 4 faces"), "{beyond}");
    assert!(refused(on_face(0, [1.0, 0.5, -0.5])).contains("barycentric"));
    assert!(refused(Site::Near([f64::NAN; 3])).contains("site 0"));
}

#[test]
fn sites_of_one_face_are_inserted_where_positions_do_not_tell_their_places() {
    let sites = |all: &[[f64; 3]]| {
        let site = |&weights| Site::Face(SurfacePoint { face: 0, weights });
        all.iter().map(site).collect::<Vec<_>>()
    };
    // Far from the origin, the first point is rounded to an edge.
    let far = [[1e9, 0.0, 0.0], [1e9 + 1.0, 0.0, 0.0], [1e9, 1.0, 0.0]];
    let mesh = TriMesh::new(far.into(), vec![[0, 1, 2]]).unwrap();
    let given = sites(&[[0.5, 1e-8, 0.5 - 1e-8], [0.25, 0.5, 0.25], [0.25, 0.25, 0.5]]);
    let refined = place(&mesh, &given, Placement::Insert).unwrap().mesh.unwrap();
    assert_eq!(refined.mesh.faces().len(), 7);
    assert!((refined.mesh.area() - 0.5).abs() < 1e-6, "{}", refined.mesh.area());
    // A face without area.
    let line = [[0.0; 3], [1.0, 0.0, 0.0], [2.0, 0.0, 0.0]];
    let mesh = TriMesh::new(line.into(), vec![[0, 1, 2]]).unwrap();
    let given = sites(&[[0.5, 0.25, 0.25], [0.25, 0.25, 0.5]]);
    let refined = place(&mesh, &given, Placement::Insert).unwrap().mesh.unwrap();
    assert_eq!(refined.mesh.faces().len(), 5);
    for (site, weights) in [(3, [0.5, 0.25, 0.25]), (4, [0.25, 0.25, 0.5])] {
        let origin = refined.vertices[site];
        assert!((0..3).all(|v| (origin.share(v) - weights[v as usize]).abs() < 1e-15));
    }
}

#[test]
fn steiner_points_are_on_edges() {
    let mesh = shapes::grid(2, 2);
    for (ends, why) in [([0, 0], "no edge joins 0 and 0"), ([0, 8], "no edge joins 0 and 8")] {
        let said = refined(&mesh, &[ends]).unwrap_err().to_string();
        assert!(said.contains(why), "{said}");
    }
    // Of an earlier point.
    assert!(refined(&mesh, &[[0, 1], [9, 1]]).is_ok());
    assert!(refined(&mesh, &[[0, 1], [0, 1]]).is_err());
}

/// Runs a part of `scripts/reproduce curves` with known counts: for each mode the runs that closed,
/// those without Steiner points, and those with the right order.
#[test]
fn counts_on_a_part_of_the_data_set_are_as_they_were() {
    // Meshes whose vertices need square roots only, so that they are the same on every machine.
    let meshes = [families::icosphere(5).unwrap(), families::genus(3, 14).unwrap()];
    let mut counts = [[0; 3]; 2];
    let mut runs = 0;
    for mesh in meshes {
        let mesh = scaled(&mesh).unwrap();
        let graph = Graph::of_mesh(&mesh);
        let mut generator = Generator::new(&graph, 6).unwrap();
        let mut rng = Rng::new(7);
        let mut solver = CurveSolver::new(&mesh).unwrap();
        for _ in 0..4 {
            let curve = generator.curve().unwrap().unwrap();
            for (k, sampling) in [
                (10, Sampling::Even),
                (25, Sampling::Even),
                (25, Sampling::Random),
                (70, Sampling::Even),
                (100, Sampling::Random),
            ] {
                let x = samples(&curve, k, sampling, &mut rng);
                runs += 1;
                for (options, counts) in [FAITHFUL, robust()].iter().zip(&mut counts) {
                    let result = solver.reconstruct(&x.vertices, options).unwrap();
                    check(&mesh, &x.vertices, &result);
                    let closed = result.outcome == Outcome::Closed;
                    let right =
                        result.curves.len() == 1 && same_order(&result.curves[0].order, &x.order);
                    counts[0] += usize::from(closed);
                    counts[1] += usize::from(closed && result.steiner.is_empty());
                    counts[2] += usize::from(right);
                }
            }
        }
    }
    assert_eq!(runs, 40);
    assert_eq!(counts, [[32, 32, 17], [40, 40, 28]]);
}

/// Returns the length of a polygon, including the edge back to its start when it is closed.
fn polygon_length(points: &[[f64; 3]], closed: bool) -> f64 {
    let next = points.iter().cycle().skip(1);
    let count = points.len() - usize::from(!closed);
    points.iter().zip(next).take(count).map(|(&p, &q)| distance(p, q)).sum()
}

fn along(path: &[u32], closed: bool) -> Curve {
    let waypoints = path.iter().map(|&v| Waypoint::Vertex(v)).collect();
    Curve { order: vec![], path: path.to_vec(), points: vec![], waypoints, closed, length: 0.0 }
}

#[test]
fn a_path_in_the_plane_becomes_a_straight_line() {
    let mesh = shapes::grid(9, 7);
    // Up, then to the right, inside of the grid, from (1, 1) to (8, 5).
    let path: Vec<u32> = (1..5).map(|y| at(9, 1, y)).chain((1..=8).map(|x| at(9, x, 5))).collect();
    let result = smooth(&mesh, &[along(&path, false)], &[], 10_000).unwrap();
    assert!(result.converged);
    let straight = 65.0_f64.sqrt();
    assert!((result.lengths[0] - straight).abs() < 1e-9, "{:?}", result.lengths);
    assert!((polygon_length(&result.points[0], false) - straight).abs() < 1e-6);
    // With its corner marked, the curve stays as it is.
    let result = smooth(&mesh, &[along(&path, false)], &[at(9, 1, 5)], 10_000).unwrap();
    assert_eq!((result.lengths[0], result.steps), (11.0, 0));
    // A single step is not enough.
    assert!(!smooth(&mesh, &[along(&path, false)], &[], 1).unwrap().converged);
}

#[test]
fn smooth_curves_run_through_the_samples_and_stay_on_the_surface() {
    let mesh = families::icosphere(4).unwrap();
    let samples = [3, 700, 1200, 2000, 150, 999];
    let found = found(&mesh, &samples, &robust());
    let refined = refined(&mesh, &found.steiner).unwrap();
    let result = smooth(&refined, &found.curves, &samples, 100_000).unwrap();
    assert!(result.converged && result.lengths[0] < found.length());
    let points = &result.points[0];
    let length = polygon_length(points, true);
    assert!((length - result.lengths[0]).abs() < 1e-4 * length, "{length} {:?}", result.lengths);
    for &v in &samples {
        assert!(points.contains(&mesh.vertices()[v as usize]));
    }
    // Great circles between samples, up to the distance of the polyhedron from the sphere.
    let order = &found.curves[0].order;
    let arcs: f64 = (order.iter().zip(order.iter().cycle().skip(1)))
        .map(|(&i, &j)| {
            let [p, q] = [i, j].map(|i| mesh.vertices()[samples[i as usize] as usize]);
            2.0 * (distance(p, q) / 2.0).asin()
        })
        .sum();
    assert!((length / arcs - 1.0).abs() < 0.01, "{length} {arcs}");
}

#[test]
fn curves_of_the_data_set_are_smoothed_without_crossings() {
    let mesh = scaled(&families::genus(2, 10).unwrap()).unwrap();
    let graph = Graph::of_mesh(&mesh);
    let mut generator = Generator::new(&graph, 1).unwrap();
    let mut rng = Rng::new(2);
    for _ in 0..3 {
        let curve = generator.curve().unwrap().unwrap();
        let x = samples(&curve, 25, Sampling::Even, &mut rng);
        let found = found(&mesh, &x.vertices, &robust());
        let refined = refined(&mesh, &found.steiner).unwrap();
        let result = smooth(&refined, &found.curves, &x.vertices, 100_000).unwrap();
        assert!(result.lengths[0] < found.length());
        let drawn = polygon_length(&result.points[0], true);
        assert!((drawn / result.lengths[0] - 1.0).abs() < 1e-4, "{drawn} {:?}", result.lengths);
    }
}

#[test]
fn what_cannot_be_smoothed_is_said() {
    let mesh = shapes::grid(4, 4);
    let told = |mesh: &TriMesh, path: &[u32]| {
        smooth(mesh, &[along(path, false)], &[], 10).unwrap_err().to_string()
    };
    assert!(told(&mesh, &[0, 7]).contains("no edge from vertex 0 to 7"));
    assert!(told(&mesh, &[0, 1, 0]).contains("vertex 0 occurs twice"));
    assert!(told(&mesh, &[25]).contains("vertex 25 is out of range: 25 vertices"));
    assert!(told(&families::pages(3).unwrap(), &[0]).contains("faces"));
    let none = smooth(&mesh, &[], &[], 10).unwrap();
    assert!(none.converged && none.points.is_empty());
}
