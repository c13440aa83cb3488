use std::ops::ControlFlow;

use super::*;
use crate::mesh::vector::Vector;
use crate::mesh::{TriMesh, shapes};
use catamaran::base::Rng;

/// Returns two points of mass 1/2 with eigenvalues 0 and 2: the constant, and a change of sign.
fn two_points() -> (Vec<f64>, Mat<f64>) {
    (vec![0.0, 2.0], Mat::from_fn(2, 2, |i, j| if (i, j) == (1, 1) { -1.0 } else { 1.0 }))
}

fn random_pairs(n: usize, k: usize, seed: u64) -> (Vec<f64>, Mat<f64>) {
    let mut rng = Rng::new(seed);
    let mut values: Vec<f64> = (0..k).map(|i| (i * i) as f64 + rng.uniform()).collect();
    if k > 0 {
        values[0] = 1e-14;
    }
    (values, Mat::from_fn(n, k, |_, _| rng.normal()))
}

fn difference(a: &Mat<f64>, b: &Mat<f64>) -> f64 {
    assert_eq!(a.shape(), b.shape());
    (a - b).norm_max()
}

/// Returns the mesh after a rotation and a translation.
fn moved(mesh: &TriMesh) -> TriMesh {
    let (s, c) = 0.7_f64.sin_cos();
    let (t, d) = 1.9_f64.sin_cos();
    let rotate = |p: &Vector| {
        let q = [c * p[0] - s * p[1], s * p[0] + c * p[1], p[2]];
        [q[0] + 3.0, d * q[1] - t * q[2] - 1.0, t * q[1] + d * q[2] + 0.5]
    };
    let vertices = mesh.vertices().iter().map(rotate).collect();
    TriMesh::new(vertices, mesh.faces().to_vec()).unwrap()
}

fn bumpy() -> TriMesh {
    shapes::shaken(&shapes::sphere(3), 0.04, 11)
}

#[test]
fn heat_on_two_points_is_known() {
    let (values, vectors) = two_points();
    let e = (-2.0_f64 * 0.3).exp();
    let hks = heat_kernel_signature(&values, vectors.as_ref(), &[0.0, 0.3], Par::Seq).unwrap();
    let expected = Mat::from_fn(2, 2, |_, t| if t == 0 { 2.0 } else { 1.0 + e });
    assert!(difference(&hks, &expected) < 1e-15);
    let kernel = heat_kernel(&values, vectors.as_ref(), 0, 0.3).unwrap();
    assert!((kernel[0] - 1.0 - e).abs() < 1e-15 && (kernel[1] - 1.0 + e).abs() < 1e-15);
    assert!((heat_trace(&values, 0.3) - 1.0 - e).abs() < 1e-15);
    let gps = global_point_signature(&values, vectors.as_ref()).unwrap();
    assert!(
        difference(&gps, &Mat::from_fn(2, 1, |i, _| [0.5_f64.sqrt(), -(0.5_f64.sqrt())][i]))
            < 1e-15
    );
}

#[test]
fn scales_are_those_of_the_papers() {
    let values = [0.0, 1e-13, 2.0, 5.0, 32.0];
    let times = heat_times(&values, 5).unwrap();
    let ln10 = std::f64::consts::LN_10;
    assert!((times[4] / (2.0 * ln10) - 1.0).abs() < 1e-14);
    assert!((times[0] / (ln10 / 8.0) - 1.0).abs() < 1e-14);
    assert!(times.windows(2).all(|t| (t[1] / t[0] - 2.0).abs() < 1e-13));
    let WaveScales { energies, sigma } = wave_scales(&values, 9).unwrap();
    let apart = energies[1] - energies[0];
    assert!((sigma / apart - 7.0).abs() < 1e-12);
    assert!((energies[0] - 2.0 * sigma - 2.0_f64.ln()).abs() < 1e-12);
    assert!((energies[8] + 2.0 * sigma - 32.0_f64.ln()).abs() < 1e-12);
    assert_eq!(heat_times(&values, 1).unwrap().len(), 1);
    assert_eq!(wave_scales(&values, 0).unwrap().energies, [0.0; 0]);
    for nothing in [&[][..], &[0.0], &[0.0, -1.0]] {
        assert!(heat_times(nothing, 3).is_err() && wave_scales(nothing, 3).is_err());
    }
    assert!(wave_scales(&[0.0, 3.0], 3).is_err());
    assert!(heat_times(&[f64::NAN], 3).is_err());
}

#[test]
fn wave_signatures_are_weighted_means_of_squares() {
    let (values, vectors) = random_pairs(7, 6, 1);
    let scales = WaveScales { energies: vec![values[3].ln(), 500.0, -500.0], sigma: 1e-3 };
    let wks = wave_kernel_signature(&values, vectors.as_ref(), &scales, Par::Seq).unwrap();
    for x in 0..7 {
        // Sigma is so small that the nearest eigenvalue has all the weight.
        for (e, i) in [(0, 3), (1, 5), (2, 1)] {
            let square = vectors[(x, i)].powi(2);
            assert!((wks[(x, e)] - square).abs() < 1e-12 * square.max(1.0));
        }
    }
    let ones = Mat::from_fn(3, 6, |_, _| 1.0);
    let scales = wave_scales(&values, 20).unwrap();
    let wks = wave_kernel_signature(&values, ones.as_ref(), &scales, Par::Seq).unwrap();
    assert!(difference(&wks, &Mat::from_fn(3, 20, |_, _| 1.0)) < 1e-14);
}

#[test]
fn signatures_do_not_depend_on_signs_or_on_the_basis_of_a_multiplet() {
    let (mut values, vectors) = random_pairs(50, 8, 2);
    values[5] = values[4];
    let (s, c) = 0.4_f64.sin_cos();
    let other = Mat::from_fn(50, 8, |i, j| match j {
        4 => c * vectors[(i, 4)] - s * vectors[(i, 5)],
        5 => s * vectors[(i, 4)] + c * vectors[(i, 5)],
        j => vectors[(i, j)] * if j % 2 == 0 { -1.0 } else { 1.0 },
    });
    let (times, scales) = (heat_times(&values, 9).unwrap(), wave_scales(&values, 9).unwrap());
    let both = [&vectors, &other].map(|phi| {
        let hks = heat_kernel_signature(&values, phi.as_ref(), &times, Par::Seq).unwrap();
        (hks, wave_kernel_signature(&values, phi.as_ref(), &scales, Par::Seq).unwrap())
    });
    assert!(difference(&both[0].0, &both[1].0) < 1e-12);
    assert!(difference(&both[0].1, &both[1].1) < 1e-12);
}

#[test]
fn heat_signatures_are_the_diagonal_of_the_kernel() {
    let (values, vectors) = random_pairs(11, 5, 3);
    let hks = heat_kernel_signature(&values, vectors.as_ref(), &[0.2], Par::Seq).unwrap();
    for x in 0..11 {
        let kernel = heat_kernel(&values, vectors.as_ref(), x, 0.2).unwrap();
        assert!((kernel[x] - hks[(x, 0)]).abs() < 1e-13);
    }
}

#[test]
fn wrong_arguments_of_signatures_are_named() {
    let (values, vectors) = two_points();
    let v = vectors.as_ref();
    assert!(matches!(
        heat_kernel_signature(&values[..1], v, &[1.0], Par::Seq),
        Err(Error::Shape { what: "eigenvectors", .. })
    ));
    for time in [-1.0, f64::NAN, f64::INFINITY] {
        let refused = heat_kernel_signature(&values, v, &[time], Par::Seq);
        assert!(matches!(refused, Err(Error::Argument { what: "times", .. })), "{time}");
        let refused = heat_kernel(&values, v, 0, time);
        assert!(matches!(refused, Err(Error::Argument { what: "times", .. })), "{time}");
    }
    let refused = heat_kernel(&values, v, 2, 1.0);
    assert!(matches!(refused, Err(Error::Argument { what: "source", .. })), "{refused:?}");
    let mut holed = vectors.clone();
    holed[(1, 1)] = f64::NAN;
    assert_eq!(
        global_point_signature(&values, holed.as_ref()),
        Err(Error::NonFinite { what: "eigenvectors", index: (1, 1) })
    );
    for sigma in [0.0, f64::NAN] {
        let scales = WaveScales { energies: vec![0.0], sigma };
        let refused = wave_kernel_signature(&values, v, &scales, Par::Seq);
        assert!(matches!(refused, Err(Error::Argument { what: "sigma", .. })), "{sigma}");
    }
    let empty = heat_kernel_signature(&[], Mat::<f64>::zeros(0, 0).as_ref(), &[1.0], Par::Seq);
    assert_eq!(empty.unwrap().shape(), (0, 1));
}

fn shot_of(mesh: &TriMesh, radius: f64, par: Par) -> Mat<f64> {
    shot(mesh, &ShotOptions { radius, par, progress: Progress::none() }).unwrap()
}

fn rings_of(mesh: &TriMesh, functions: &Mat<f64>, par: Par) -> Mat<f64> {
    let options = RingOptions { radius: 0.7, rings: 4, par, progress: Progress::none() };
    geodesic_rings(mesh, functions.as_ref(), &options).unwrap()
}

#[test]
fn shot_follows_rigid_motions_and_scale() {
    let mesh = bumpy();
    let still = shot_of(&mesh, 0.5, Par::Seq);
    assert_eq!(still.shape(), (mesh.vertices().len(), 352));
    for i in 0..still.nrows() {
        assert!((still.row(i).norm_l2() - 1.0).abs() < 1e-12);
        assert!((0..352).all(|j| still[(i, j)] >= 0.0));
    }
    assert!(difference(&still, &shot_of(&moved(&mesh), 0.5, Par::Seq)) < 1e-6);
    let larger = mesh.vertices().iter().map(|p| p.map(|x| 1e6 * x)).collect();
    let larger = TriMesh::new(larger, mesh.faces().to_vec()).unwrap();
    assert!(difference(&still, &shot_of(&larger, 0.5e6, Par::Seq)) < 1e-9);
}

#[test]
fn shot_tells_a_bump_from_a_plane_and_agrees_on_equal_places() {
    // Two bumps of the same shape on a plane, which differ by a translation only.
    let mesh = shapes::grid(40, 20);
    let height = |p: &Vector, at: f64| {
        let (x, y) = (p[0] - at, p[1] - 10.0);
        3.0 * (-(x * x + 2.0 * y * y + 0.3 * x * y + 0.2 * x) / 8.0).exp()
    };
    let lifted = mesh.vertices().iter().map(|p| [p[0], p[1], height(p, 10.0) + height(p, 30.0)]);
    let mesh = TriMesh::new(lifted.collect(), mesh.faces().to_vec()).unwrap();
    let all = shot_of(&mesh, 4.0, Par::Seq);
    let apart = |a: usize, b: usize| {
        (0..352).map(|j| (all[(a, j)] - all[(b, j)]).powi(2)).sum::<f64>().sqrt()
    };
    let at = |x: usize, y: usize| y * 41 + x;
    for (x, y) in [(10, 10), (11, 8), (8, 11)] {
        assert!(apart(at(x, y), at(x + 20, y)) < 1e-6, "{x} {y}");
    }
    assert!(apart(at(10, 10), at(20, 10)) > 0.3);
    assert!(apart(at(11, 8), at(8, 11)) > 0.1);
}

#[test]
fn shot_of_lonely_vertices_is_zero_and_its_radius_is_checked() {
    let mesh = shapes::grid(3, 3);
    assert_eq!(shot_of(&mesh, 0.5, Par::Seq).norm_max(), 0.0);
    for radius in [0.0, -1.0, f64::NAN, f64::INFINITY] {
        assert!(
            shot(&mesh, &ShotOptions { radius, par: Par::Seq, progress: Progress::none() })
                .is_err()
        );
    }
    let empty = TriMesh::new(vec![], vec![]).unwrap();
    assert_eq!(shot_of(&empty, 1.0, Par::Seq).shape(), (0, 352));
}

#[test]
fn neighbours_in_cells_are_those_of_a_plain_search() {
    let mut rng = Rng::new(5);
    let points: Vec<Vector> =
        (0..300).map(|_| [rng.uniform(), 5.0 * rng.uniform(), -rng.uniform()]).collect();
    for radius in [0.05, 0.3, 9.0] {
        let cells = cells::Cells::new(&points, radius);
        for p in &points {
            let mut found = Vec::new();
            cells.near(p, radius, |i, _| found.push(i as usize));
            found.sort_unstable();
            let near = |i: &usize| crate::mesh::vector::distance(*p, points[*i]) <= radius;
            assert_eq!(found, (0..300).filter(near).collect::<Vec<_>>());
        }
    }
}

#[test]
fn rings_are_intrinsic_and_have_means_and_shares() {
    let mesh = bumpy();
    let n = mesh.vertices().len();
    let functions = Mat::from_fn(n, 2, |i, j| if j == 0 { 3.0 } else { (i % 5) as f64 });
    let rings = rings_of(&mesh, &functions, Par::Seq);
    assert_eq!(rings.shape(), (n, 12));
    for v in 0..n {
        let shares: f64 = (0..4).map(|r| rings[(v, 3 * r)]).sum();
        assert!((shares - 1.0).abs() < 1e-12);
        for r in 0..4 {
            assert!((rings[(v, 3 * r + 1)] - 3.0).abs() < 1e-12);
            assert!((0.0..=4.0).contains(&rings[(v, 3 * r + 2)]));
        }
    }
    assert!(difference(&rings, &rings_of(&moved(&mesh), &functions, Par::Seq)) < 1e-9);
    // A sheet rolled up along its lines is isometric to a flat sheet.
    let flat = shapes::grid(12, 7);
    let rolled = flat.vertices().iter().map(|p| {
        let (s, c) = (p[0] * 0.2).sin_cos();
        let chord = 1.0 / (2.0 * 0.1_f64.sin());
        [chord * s, p[1], chord * c]
    });
    let rolled = TriMesh::new(rolled.collect(), flat.faces().to_vec()).unwrap();
    let functions = Mat::from_fn(flat.vertices().len(), 1, |i, _| (i % 7) as f64);
    let options = RingOptions { radius: 3.1, rings: 3, par: Par::Seq, progress: Progress::none() };
    let of = |mesh| geodesic_rings(mesh, functions.as_ref(), &options).unwrap();
    assert!(difference(&of(&flat), &of(&rolled)) < 1e-9);
}

#[test]
fn rings_check_their_arguments() {
    let mesh = shapes::grid(2, 2);
    let functions = Mat::<f64>::zeros(9, 1);
    let good = RingOptions { radius: 1.0, rings: 2, par: Par::Seq, progress: Progress::none() };
    assert!(geodesic_rings(&mesh, functions.as_ref(), &good).is_ok());
    let options = [
        (RingOptions { radius: 0.0, ..good }, "radius"),
        (RingOptions { rings: 0, ..good }, "rings"),
    ];
    for (bad, name) in options {
        let refused = geodesic_rings(&mesh, functions.as_ref(), &bad);
        assert!(matches!(refused, Err(Error::Argument { what, .. }) if what == name), "{name}");
    }
    let refused = geodesic_rings(&mesh, functions.as_ref().subrows(0, 8), &good);
    assert!(matches!(refused, Err(Error::Shape { what: "functions", .. })), "{refused:?}");
    let nan = Mat::from_fn(9, 1, |_, _| f64::NAN);
    let refused = geodesic_rings(&mesh, nan.as_ref(), &good);
    assert_eq!(refused, Err(Error::NonFinite { what: "functions", index: (0, 0) }));
}

#[test]
fn descriptors_are_the_same_bytes_on_any_number_of_threads() {
    let mesh = bumpy();
    let n = mesh.vertices().len();
    let (values, vectors) = random_pairs(3000, 13, 6);
    let functions = Mat::from_fn(n, 1, |i, _| i as f64);
    let at = |threads| {
        let par = Par::Threads(threads);
        let times = heat_times(&values, 5).unwrap();
        let hks = heat_kernel_signature(&values, vectors.as_ref(), &times, par).unwrap();
        [hks, shot_of(&mesh, 0.5, par), rings_of(&mesh, &functions, par)]
    };
    let one = at(1);
    assert!(one == at(2) && one == at(3));
}

#[test]
fn long_work_tells_its_progress_and_can_be_cancelled() {
    let mesh = bumpy();
    let seen = std::sync::Mutex::new(Vec::new());
    let progress = |done: f64| {
        seen.lock().unwrap().push(done);
        ControlFlow::Continue(())
    };
    let options = ShotOptions { radius: 0.3, par: Par::Seq, progress: (&progress).into() };
    shot(&mesh, &options).unwrap();
    let seen = seen.lock().unwrap().clone();
    assert!(seen.is_sorted() && seen.last() == Some(&1.0));
    let cancel = |_: f64| ControlFlow::Break(());
    let options = ShotOptions { progress: (&cancel).into(), ..options };
    assert_eq!(shot(&mesh, &options).unwrap_err(), Error::Cancelled);
}
