use std::ops::ControlFlow;

use super::*;
use crate::mesh::Edges;
use catamaran::base::Rng;

/// Returns a lattice of n^3 points on a cube of side 2 `half` around the origin.
fn cube(n: usize, half: f64) -> Lattice {
    let step = 2.0 * half / n as f64;
    Lattice { counts: [n; 3], origin: [step / 2.0 - half; 3], step: [step; 3] }
}

fn length(p: [f64; 3]) -> f64 {
    p.iter().map(|x| x * x).sum::<f64>().sqrt()
}

fn of(lattice: &Lattice, value: impl Fn([f64; 3]) -> f64, rim: Rim) -> TriMesh {
    let values: Vec<f32> = lattice.points().into_iter().map(|p| value(p) as f32).collect();
    isosurface(lattice, &values, 0.0, rim, Par::Threads(2), Progress::none()).unwrap()
}

fn euler(mesh: &TriMesh) -> i64 {
    mesh.euler_characteristic(&Edges::new(mesh))
}

/// Asserts that the mesh is a closed, oriented manifold.
fn assert_closed(mesh: &TriMesh) {
    let edges = Edges::new(mesh);
    assert!((0..edges.len()).all(|e| edges.faces(e).len() == 2));
    assert!(mesh.inconsistent_edges(&edges).is_empty());
    mesh.require_closed().unwrap();
}

#[test]
fn balls_and_tori_have_their_volume_shape_and_outside() {
    let ball = of(&cube(40, 1.5), |p| 1.0 - length(p), Rim::Closed);
    assert_closed(&ball);
    assert_eq!(euler(&ball), 2);
    let volume = 4.0 / 3.0 * std::f64::consts::PI;
    // The faces cut through the ball: the volume is too small by a share of some (h / r)^2 / 2.
    let found = ball.volume().unwrap();
    assert!((found / volume - 1.0).abs() < 3e-3, "{found}");
    // Linear interpolation along edges of length up to sqrt(3) h has an error of their square / 8
    // r.
    let bound = 3.0 * 0.075_f64.powi(2) / 8.0 * 1.1;
    assert!(ball.vertices().iter().all(|&p| (length(p) - 1.0).abs() < bound));

    let torus = |p: [f64; 3]| 0.4 - length([length([p[0], p[1], 0.0]) - 1.0, p[2], 0.0]);
    let torus = of(&cube(48, 1.6), torus, Rim::Closed);
    assert_closed(&torus);
    assert_eq!(euler(&torus), 0);
    let volume = 2.0 * std::f64::consts::PI.powi(2) * 0.16;
    let found = torus.volume().unwrap();
    assert!((found / volume - 1.0).abs() < 1e-2, "{found}");

    let two = |p: [f64; 3]| 0.3 - length([p[0].abs() - 0.5, p[1], p[2]]);
    assert_eq!(euler(&of(&cube(30, 1.0), two, Rim::Closed)), 4);
}

#[test]
fn a_full_lattice_is_its_box_with_bevelled_edges() {
    let lattice = Lattice { counts: [3, 4, 5], origin: [0.5, 0.25, 1.0], step: [1.0, 0.5, 2.0] };
    let mesh = of(&lattice, |_| 1.0, Rim::Closed);
    assert_closed(&mesh);
    assert_eq!(euler(&mesh), 2);
    assert_eq!(mesh.bounding_box(), Some([[0.0; 3], [3.0, 2.0, 10.0]]));
    // Edges of the box are bevelled where no diagonal of a cell meets them.
    let volume = mesh.volume().unwrap();
    assert!((55.0..60.0).contains(&volume), "{volume}");
    assert!(of(&lattice, |_| -1.0, Rim::Closed).faces().is_empty());
    assert!(of(&lattice, |_| 1.0, Rim::Open).faces().is_empty());
}

#[test]
fn any_values_give_a_closed_manifold() {
    for seed in 0..6 {
        let mut rng = Rng::new(seed);
        let lattice = Lattice { counts: [9, 7, 8], origin: [0.0; 3], step: [1.0, 2.0, 0.5] };
        // Some values equal the level, where vertices could coincide.
        let values: Vec<f32> =
            (0..9 * 7 * 8).map(|_| (3.0 * rng.uniform()).floor() as f32 - 1.0).collect();
        let mesh =
            isosurface(&lattice, &values, 0.0, Rim::Closed, Par::Seq, Progress::none()).unwrap();
        assert_closed(&mesh);
        assert!(mesh.volume().unwrap() > 0.0 && mesh.faces_without_area().is_empty());
        let labels: Vec<u16> = (0..9 * 7 * 8).map(|_| (4.0 * rng.uniform()) as u16).collect();
        let mut volume = 0.0;
        for label in 0..4 {
            let (par, none) = (Par::Threads(2), Progress::none());
            let mesh = label_surface(&lattice, &labels, label, Rim::Closed, par, none).unwrap();
            assert_closed(&mesh);
            volume += mesh.volume().unwrap();
        }
        // The faces do not overlap.
        assert!(volume < 9.0 * 14.0 * 4.0, "{volume}");
    }
}

#[test]
fn an_open_surface_ends_at_the_outermost_points() {
    let lattice = cube(20, 1.0);
    let mesh = of(&lattice, |p| 1.1 - length(p), Rim::Open);
    let edges = Edges::new(&mesh);
    mesh.require_manifold().unwrap();
    let boundary: Vec<u32> = edges.boundary().collect();
    assert!(!boundary.is_empty());
    let end = 0.95;
    for &e in &boundary {
        let [a, b] = edges.ends()[e as usize].map(|v| mesh.vertices()[v as usize]);
        let on = |c: usize| (a[c].abs() - end).abs() < 1e-9 && (a[c] - b[c]).abs() < 1e-9;
        assert!((0..3).any(on), "{a:?} {b:?}");
    }
    let closed = of(&lattice, |p| 1.1 - length(p), Rim::Closed);
    assert_closed(&closed);
    assert_eq!(euler(&closed), 2);
}

#[test]
fn threads_change_nothing_and_a_callback_stops() {
    let lattice = cube(24, 1.5);
    let label = |p: &[f64; 3]| u16::from(length(*p) < 1.0) + 2 * u16::from(p[0] > 0.2 * p[1]);
    let labels: Vec<u16> = lattice.points().iter().map(label).collect();
    let label_at = |points: &[[f64; 3]]| Ok(points.iter().map(label).collect());
    let none = Progress::none();
    let run = |par| label_surface_by(&lattice, &labels, 3, Rim::Closed, label_at, par, none);
    let one = run(Par::Seq).unwrap();
    assert_closed(&one);
    assert_eq!(run(Par::Threads(4)).unwrap(), one);
    for limit in [0.0, 0.3, 0.6, 0.95] {
        let stop = |fraction: f64| match fraction > limit {
            true => ControlFlow::Break(()),
            false => ControlFlow::Continue(()),
        };
        let (par, progress) = (Par::Threads(2), Progress::new(&stop));
        let stopped = label_surface_by(&lattice, &labels, 3, Rim::Closed, label_at, par, progress);
        assert_eq!(stopped, Err(Error::Cancelled), "{limit}");
    }
}

#[test]
fn what_is_wrong_is_named() {
    let lattice = cube(4, 1.0);
    let run = |lattice: &Lattice, values: &[f32], rim| {
        isosurface(lattice, values, 0.0, rim, Par::Seq, Progress::none()).unwrap_err()
    };
    let mut values = vec![0.0; 64];
    assert!(matches!(run(&lattice, &values[1..], Rim::Closed), Error::Shape { .. }));
    values[17] = f32::NAN;
    let wrong = Error::NonFinite { what: "values", index: (0, 17) };
    assert_eq!(run(&lattice, &values, Rim::Closed), wrong);
    let level = isosurface(&lattice, &[0.0; 64], f32::NAN, Rim::Closed, Par::Seq, Progress::none());
    assert_eq!(level.unwrap_err().to_string(), "level: must not be NaN");
    values[17] = f32::INFINITY;
    let found = isosurface(&lattice, &values, 0.0, Rim::Closed, Par::Seq, Progress::none());
    assert_eq!(euler(&found.unwrap()), 2, "an infinite value is inside");
    let flat = Lattice { counts: [4, 4, 1], ..lattice };
    assert!(
        run(&flat, &values[..16], Rim::Open)
            .to_string()
            .contains("needs 2 points in each direction")
    );
    let still = Lattice { step: [1.0, 0.0, 1.0], ..lattice };
    assert!(run(&still, &values, Rim::Closed).to_string().contains("positive"));
    let none = Lattice { counts: [0, 4, 4], ..lattice };
    assert!(run(&none, &[], Rim::Closed).to_string().contains("needs a point in each direction"));
    let few = label_surface_by(
        &lattice,
        &[vec![1; 32], vec![0; 32]].concat(),
        1,
        Rim::Closed,
        |_| Ok(vec![]),
        Par::Seq,
        Progress::none(),
    );
    assert!(matches!(few, Err(Error::Shape { what: "labels of points", .. })));
}
