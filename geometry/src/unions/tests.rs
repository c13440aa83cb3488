use std::f64::consts::PI;

use super::*;
use crate::mesh::families::{disk, figure, grid, icosphere};
use crate::mesh::{Boundary, CloudOptions, LaplacianKind, LaplacianOptions, MassKind, TriMesh};
use catamaran::base::{Error, Par};

fn spectra(mesh: &TriMesh) -> PartSpectra<'_> {
    PartSpectra::new(mesh, &LaplacianOptions::default()).unwrap()
}

fn scaled(mesh: &TriMesh, factors: [f64; 3]) -> TriMesh {
    let moved = |p: &[f64; 3]| std::array::from_fn(|k| factors[k] * p[k]);
    TriMesh::new(mesh.vertices().iter().map(moved).collect(), mesh.faces().to_vec()).unwrap()
}

fn assert_near(found: &[f64], expected: &[f64], tolerance: f64) {
    assert_eq!(found.len(), expected.len());
    for (i, (x, y)) in found.iter().zip(expected).enumerate() {
        assert!((x - y).abs() <= tolerance * y.abs().max(1.0), "value {i}: {x}, not {y}");
    }
}

/// Returns the sums of squares `pi^2 (i^2 / a^2 + j^2 / b^2)` from i, j = `from` on, ascending.
fn of_rectangle(a: f64, b: f64, from: usize, k: usize) -> Vec<f64> {
    let of = |n: usize, side: f64| (PI * n as f64 / side).powi(2);
    let mut values: Vec<f64> =
        (from..40).flat_map(|i| (from..40).map(move |j| of(i, a) + of(j, b))).collect();
    values.sort_by(f64::total_cmp);
    values.truncate(k);
    values
}

/// The squares of zeros of Bessel functions (Abramowitz and Stegun, table 9.5); zeros of order 1
/// and more occur twice.
const OF_UNIT_DISK: [f64; 8] = {
    const J01: f64 = 2.404_825_557_695_773;
    const J11: f64 = 3.831_705_970_207_512;
    const J21: f64 = 5.135_622_301_840_683;
    const J02: f64 = 5.520_078_110_286_311;
    const J31: f64 = 6.380_161_895_923_984;
    [J01 * J01, J11 * J11, J11 * J11, J21 * J21, J21 * J21, J02 * J02, J31 * J31, J31 * J31]
};

#[test]
fn a_half_of_a_square_is_a_rectangle() {
    let mesh = grid(60, 60).unwrap();
    let [low, high] = mesh.bounding_box().unwrap();
    let side = high[0] - low[0];
    let half = mesh.half_space([1.0, 0.0, 0.0], low[0] + side / 2.0 + 1e-9);
    let parts = spectra(&mesh);
    let expected = of_rectangle(side / 2.0, side, 1, 6);
    assert_near(&parts.dirichlet(&half, 6).unwrap(), &expected, 0.02);
    let expected = of_rectangle(side / 2.0, side, 0, 6);
    assert_near(&parts.neumann(&half, 6).unwrap(), &expected, 0.02);
}

#[test]
fn a_ball_in_a_plane_is_a_disk() {
    let mesh = scaled(&disk(60, 90).unwrap(), [2.0, 2.0, 1.0]);
    let [low, high] = mesh.bounding_box().unwrap();
    let radius = (high[0] - low[0]) / 2.0;
    let centre: Vec<f64> = mesh.vertices().iter().map(|p| p[0].hypot(p[1])).collect();
    // Half the radius of the disk, plus half a ring: the boundary of the part is its last ring of
    // vertices.
    let inner: Vec<bool> = centre.iter().map(|&r| r < radius * 30.5 / 60.0).collect();
    let expected = OF_UNIT_DISK.map(|value| value / (radius / 2.0).powi(2));
    assert_near(&spectra(&mesh).dirichlet(&inner, 8).unwrap(), &expected, 0.02);
}

#[test]
fn balls_are_geodesic_and_masks_give_their_faces() {
    let sphere = icosphere(4).unwrap();
    let pole = sphere.vertices()[0];
    let cap = sphere.ball(0, 1.0, Par::Seq).unwrap();
    for (p, inside) in sphere.vertices().iter().zip(&cap) {
        let angle = (0..3).map(|k| p[k] * pole[k]).sum::<f64>().clamp(-1.0, 1.0).acos();
        assert!((angle - 1.0).abs() < 0.08 || *inside == (angle < 1.0), "{angle}");
    }
    let part = sphere.masked(&cap).unwrap();
    assert!(part.vertices.iter().all(|&v| cap[v as usize]));
    // The area is 2 pi (1 - cos r), less half an edge all around.
    assert!((part.mesh.area() / (2.0 * PI * (1.0 - 1f64.cos())) - 1.0).abs() < 0.1);
}

#[test]
fn the_part_as_a_mesh_of_its_own_has_the_same_spectrum() {
    let mesh = figure(3, 0.4).unwrap();
    let mask = mesh.half_space([0.3, 0.2, 1.0], 1.5);
    for mass in [MassKind::Barycentric, MassKind::Consistent] {
        let options = LaplacianOptions { mass, ..LaplacianOptions::default() };
        let found = PartSpectra::new(&mesh, &options).unwrap().dirichlet(&mask, 20).unwrap();
        let own = ShapeDnaOptions {
            k: 20,
            normalized: false,
            laplacian: LaplacianOptions { boundary: Boundary::Dirichlet, ..options },
            ..ShapeDnaOptions::default()
        };
        let part = mesh.masked(&mask).unwrap().mesh;
        assert_near(&found, &shape_dna(&part, &own).unwrap(), 1e-9);
    }
}

#[test]
fn of_two_parts_the_inner_one_has_the_larger_eigenvalues() {
    let mesh = figure(3, 0.7).unwrap();
    for kind in [LaplacianKind::Cotangent, LaplacianKind::IntrinsicDelaunay, LaplacianKind::Tufted]
    {
        let options = LaplacianOptions { kind, ..LaplacianOptions::default() };
        let parts = PartSpectra::new(&mesh, &options).unwrap();
        let mut before: Option<Vec<f64>> = None;
        for offset in [0.0, 1.0, 2.5, 4.0, 100.0] {
            let mask = mesh.half_space([0.2, 0.1, 1.0], offset);
            let values = parts.dirichlet(&mask, 20).unwrap();
            if let Some(before) = before {
                for (outer, inner) in values.iter().zip(&before) {
                    assert!(*outer <= inner * (1.0 + 1e-9), "{kind:?} {offset}: {outer} {inner}");
                }
            }
            before = Some(values);
        }
    }
}

#[test]
fn eigenvalues_go_as_one_over_area_and_signatures_stay() {
    let mesh = figure(2, 0.3).unwrap();
    let large = scaled(&mesh, [3.0; 3]);
    let mask = mesh.half_space([0.0, 0.0, 1.0], 2.0);
    let one = spectra(&mesh).dirichlet(&mask, 20).unwrap();
    let ninth: Vec<f64> = spectra(&large).dirichlet(&mask, 20).unwrap();
    assert_near(&ninth.iter().map(|x| 9.0 * x).collect::<Vec<_>>(), &one, 1e-9);
    let options = ShapeDnaOptions::default();
    let [one, same] = [&mesh, &large].map(|mesh| shape_dna(mesh, &options).unwrap());
    assert_near(&same, &one, 1e-9);
}

#[test]
fn poses_are_retrieved_with_their_figure() {
    let figures = [[1.0, 1.0, 1.0], [1.0, 1.0, 1.3], [1.3, 1.0, 1.0]];
    let options = ShapeDnaOptions::default();
    let signature = |pose: f64, factors: [f64; 3]| {
        // Stretched before the pose, along the arms or the trunk.
        let mesh = figure(2, pose).unwrap();
        shape_dna(&scaled(&mesh, if pose == 0.0 { factors } else { [1.0; 3] }), &options).unwrap()
    };
    let all: Vec<Vec<f64>> = figures.iter().map(|&factors| signature(0.0, factors)).collect();
    let posed = signature(0.6, [1.0; 3]);
    let found = retrieve(&posed, &all, 2, Par::Seq).unwrap();
    assert_eq!(found[0].index, 0);
    assert!(found.len() == 2 && found[0].distance < 0.5 * found[1].distance, "{found:?}");
}

#[test]
fn retrieval_is_by_distance_then_by_number_for_any_number_of_threads() {
    let all: Vec<[f64; 1]> = (0..10_007).map(|i| [f64::from(i % 13)]).collect();
    let one = retrieve(&[3.2], &all, 2000, Par::Seq).unwrap();
    assert_eq!(retrieve(&[3.2], &all, 2000, Par::Threads(3)).unwrap(), one);
    assert_eq!((one[0].index, one[1].index), (3, 16));
    let sorted = one.windows(2).all(|w| (w[0].distance, w[0].index) < (w[1].distance, w[1].index));
    assert!(sorted && one.len() == 2000);
    assert!(retrieve(&[], &[[0.0; 0]; 2], 5, Par::Seq).unwrap().len() == 2);
    assert!(retrieve(&[1.0], &[[0.0; 1]; 0], 5, Par::Seq).unwrap().is_empty());
    let refused = retrieve(&[1.0], &[vec![1.0], vec![]], 1, Par::Seq).unwrap_err();
    assert!(matches!(refused, Error::Shape { what: "signature", .. }));
    let refused = retrieve(&[1.0], &[[f64::NAN]], 1, Par::Seq).unwrap_err();
    assert!(matches!(refused, Error::NonFinite { what: "signature", index: (0, 0) }));
}

#[test]
fn parts_without_enough_inside_are_refused() {
    let mesh = icosphere(2).unwrap();
    let parts = spectra(&mesh);
    let nothing = vec![false; mesh.vertices().len()];
    assert!(parts.dirichlet(&nothing, 0).unwrap().is_empty());
    let refused = parts.dirichlet(&nothing, 1).unwrap_err();
    assert!(matches!(refused, Error::Argument { what: "k", .. }));
    assert!(matches!(parts.dirichlet(&[true], 1).unwrap_err(), Error::Shape { what: "mask", .. }));
    let none = parts.neumann(&nothing, 1).unwrap_err().to_string();
    assert_eq!(none, "k: must be at most 0, the number of vertices of the part, is 1");
    let all = vec![true; mesh.vertices().len()];
    assert!(parts.dirichlet(&all, 1).unwrap()[0].abs() < 1e-9);
}

#[test]
fn clouds_with_a_component_without_boundary_are_refused() {
    let ball = icosphere(3).unwrap().into_parts().0;
    let half = ball.iter().filter(|p| p[2] > 0.0).map(|p| [p[0] + 3.0, p[1], p[2]]);
    let cap: Vec<[f64; 3]> = half.clone().collect();
    assert!(cloud_spectrum(&cap, 1, &CloudOptions::new()).unwrap()[0] > 1.0);
    let both: Vec<[f64; 3]> = ball.iter().copied().chain(half).collect();
    for points in [ball, both] {
        for k in [1, 5] {
            let refused = cloud_spectrum(&points, k, &CloudOptions::new()).unwrap_err();
            assert!(matches!(refused, Error::Argument { what: "points", .. }), "{refused}");
        }
    }
}

#[test]
fn a_signature_of_zeros_alone_is_refused() {
    let mesh = crate::mesh::families::spheres(3, 1).unwrap();
    let of = |k| shape_dna(&mesh, &ShapeDnaOptions::new().k(k));
    for k in 0..4 {
        let why = of(k).unwrap_err().to_string();
        assert!(why.contains("k: must be more than 3"), "{why}");
    }
    let found = of(4).unwrap();
    assert!(found[..3] == [0.0; 3] && found[3] > 0.0, "{found:?}");
    let dirichlet = LaplacianOptions::new().boundary(Boundary::Dirichlet);
    let flat = ShapeDnaOptions::new().laplacian(dirichlet).k(0);
    let why = shape_dna(&grid(4, 4).unwrap(), &flat).unwrap_err().to_string();
    assert!(why.contains("k: must be at least 1"), "{why}");
}
