use std::f64::consts::PI;

use super::*;
use catamaran::sparse::{EigenOptions, eigs};

fn values(points: &[[f64; 3]], options: &CloudOptions, k: usize) -> Vec<f64> {
    let found = cloud_laplacian(points, options).unwrap();
    let wanted = EigenOptions::new().k(k);
    eigs(found.stiffness.view(), &found.mass, &wanted).unwrap().values
}

/// Returns points spread over the unit sphere along a spiral.
fn sphere(n: usize) -> Vec<[f64; 3]> {
    let point = |i: usize| {
        let z = 1.0 - (2 * i + 1) as f64 / n as f64;
        let (sin, cos) = (i as f64 * PI * (3.0 - 5f64.sqrt())).sin_cos();
        let r = (1.0 - z * z).sqrt();
        [r * cos, r * sin, z]
    };
    (0..n).map(point).collect()
}

#[test]
fn points_on_a_sphere_have_its_spectrum_and_area() {
    let points = sphere(2000);
    let found = cloud_laplacian(&points, &CloudOptions::default()).unwrap();
    let Mass::Lumped(masses) = &found.mass else { panic!() };
    assert!((masses.iter().sum::<f64>() / (4.0 * PI) - 1.0).abs() < 0.02);
    for (i, value) in values(&points, &CloudOptions::default(), 16).iter().enumerate() {
        let l = i.isqrt() as f64;
        assert!((value - l * (l + 1.0)).abs() < 0.02 * l * (l + 1.0) + 1e-9, "{i}: {value}");
    }
}

#[test]
fn points_of_a_grid_have_the_spectrum_of_the_square() {
    let side = 41;
    let points: Vec<[f64; 3]> = (0..side * side)
        .map(|i| [(i / side) as f64 / 40.0, (i % side) as f64 / 40.0, 0.0])
        .collect();
    let options = CloudOptions { boundary: Boundary::Dirichlet, ..CloudOptions::default() };
    let found = cloud_laplacian(&points, &options).unwrap();
    assert_eq!(found.kept.len(), 39 * 39);
    let found = values(&points, &options, 4);
    for (value, squares) in found.iter().zip([2.0, 5.0, 5.0, 8.0]) {
        assert!((value / (squares * PI * PI) - 1.0).abs() < 0.02, "{value}");
    }
}

#[test]
fn the_result_is_the_same_for_any_number_of_threads() {
    let points = sphere(700);
    let one = CloudOptions { par: Par::Seq, ..CloudOptions::default() };
    let other = CloudOptions { par: Par::Threads(3), ..CloudOptions::default() };
    assert_eq!(cloud_laplacian(&points, &one), cloud_laplacian(&points, &other));
}

#[test]
fn what_is_no_cloud_is_refused() {
    let options = CloudOptions::default();
    assert!(cloud_laplacian(&[], &options).unwrap().kept.is_empty());
    assert!(cloud_laplacian(&[[0.0; 3]], &options).unwrap().kept.is_empty());
    let twice = [[0.0; 3], [1.0, 0.0, 0.0], [0.0; 3]];
    assert!(matches!(cloud_laplacian(&twice, &options).unwrap_err(), Error::Mesh { .. }));
    let broken = [[0.0, f64::NAN, 0.0]];
    let refused = cloud_laplacian(&broken, &options).unwrap_err();
    assert_eq!(refused, Error::NonFinite { what: "points", index: (0, 1) });
    let few = CloudOptions { neighbours: 2, ..options };
    let refused = cloud_laplacian(&sphere(10), &few).unwrap_err();
    assert!(matches!(refused, Error::Argument { what: "neighbours", .. }));
}
