//! The Laplacians, distances and descriptors together: spectra against exact ones, and meshes as
//! they are found.

use catamaran::base::Par;
use catamaran::sparse::{EigenOptions, Eigenpairs, Mass, eigs, free_components};
use catamaran_geometry::mesh::{
    Boundary, Dijkstra, Graph, HeatMethod, HeatOptions, Laplacian, LaplacianKind, LaplacianOptions,
    MassKind, SearchLimits, TriMesh, families, io, laplacian,
};
use catamaran_geometry::spectral::descriptors::{
    heat_kernel_signature, heat_times, wave_kernel_signature, wave_scales,
};

const KINDS: [LaplacianKind; 3] =
    [LaplacianKind::Cotangent, LaplacianKind::IntrinsicDelaunay, LaplacianKind::Tufted];

fn options(kind: LaplacianKind) -> LaplacianOptions {
    LaplacianOptions::new().kind(kind)
}

fn spectrum(laplacian: &Laplacian, k: usize) -> Eigenpairs {
    let options = EigenOptions::new().k(k);
    eigs(laplacian.stiffness.view(), &laplacian.mass, &options).unwrap()
}

#[test]
fn a_fine_sphere_has_multiplets_for_every_kind_and_mass() {
    let mesh = families::icosphere(4).unwrap();
    for kind in KINDS {
        for mass in [MassKind::Barycentric, MassKind::MixedVoronoi, MassKind::Consistent] {
            let l = laplacian(&mesh, &options(kind).mass(mass)).unwrap();
            let values = spectrum(&l, 36).values;
            assert!(values[0].abs() < 1e-9);
            for degree in 1..6 {
                let exact = (degree * (degree + 1)) as f64;
                for value in &values[degree * degree..(degree + 1) * (degree + 1)] {
                    let error = value / exact - 1.0;
                    assert!(error.abs() < 2e-3 * exact, "{kind:?} {mass:?}: {value} for {exact}");
                }
            }
        }
    }
}

#[test]
fn a_square_has_the_spectra_of_its_boundary_conditions() {
    let mesh = families::grid(40, 40).unwrap();
    let square = std::f64::consts::PI.powi(2);
    // Sums of two squares, from 0 (Neumann) or from 1 (Dirichlet).
    let cases = [
        (Boundary::Neumann, [0.0, 1.0, 1.0, 2.0, 4.0, 4.0, 5.0, 5.0]),
        (Boundary::Dirichlet, [2.0, 5.0, 5.0, 8.0, 10.0, 10.0, 13.0, 13.0]),
    ];
    for (boundary, exact) in cases {
        let options = LaplacianOptions::new().boundary(boundary);
        let values = spectrum(&laplacian(&mesh, &options).unwrap(), exact.len()).values;
        for (value, exact) in values.iter().zip(exact) {
            assert!((value / square - exact).abs() < 0.01 * exact + 1e-8, "{value} for {exact}");
        }
    }
}

#[test]
fn signatures_are_the_same_on_isometric_shapes_and_on_equal_points() {
    // An open cylinder and the same one cut to another numbering: turned by one step around.
    let (around, along) = (24, 10);
    let mesh = families::cylinder(around, along, 1.0, 2.0).unwrap();
    let l = laplacian(&mesh, &LaplacianOptions::default()).unwrap();
    let pairs = spectrum(&l, 30);
    // Whole multiplets only: the last gap that is one.
    let k = (2..30).rev().find(|&k| pairs.values[k] - pairs.values[k - 1] > 1e-3).unwrap();
    let (values, vectors) = (&pairs.values[..k], pairs.vectors.as_ref().subcols(0, k));
    let times = heat_times(values, 6).unwrap();
    let scales = wave_scales(values, 6).unwrap();
    let hks = heat_kernel_signature(values, vectors, &times, Par::Seq).unwrap();
    let wks = wave_kernel_signature(values, vectors, &scales, Par::Seq).unwrap();
    let height = |v: usize| mesh.vertices()[v][2];
    let mut compared = 0;
    for v in 1..mesh.vertices().len() {
        for u in (0..v).filter(|&u| (height(u) - height(v)).abs() < 1e-12) {
            for j in 0..6 {
                assert!((hks[(u, j)] - hks[(v, j)]).abs() < 1e-7 * hks[(v, j)].abs());
                assert!((wks[(u, j)] - wks[(v, j)]).abs() < 1e-7 * wks[(v, j)].abs().max(1e-3));
            }
            compared += 1;
        }
    }
    assert_eq!(compared, (along + 1) * around * (around - 1) / 2);
    let (rim, waist) = (0, (0..mesh.vertices().len()).find(|&v| height(v) == 1.0).unwrap());
    assert!(hks[(rim, 0)] > 1.5 * hks[(waist, 0)], "at the rim heat has half the room");
}

/// A mesh of the shared folder.
fn real(name: &str) -> Option<TriMesh> {
    let path = crate::common::data(&format!("meshes/{name}"))?;
    Some(io::read(&path).unwrap().mesh)
}

#[test]
fn bad_meshes_have_a_tufted_laplacian() {
    let names = [
        "chair_9545_nonmanifold.obj.gz",
        "cycloidal_nonmanifold.ply.gz",
        "adis16480_slivers.stl.gz",
        "cheese_genus133.off.gz",
        "blade.off.gz",
        "moebius.obj.gz",
    ];
    for name in names {
        let Some(mesh) = real(name) else { continue };
        let l = laplacian(&mesh, &options(LaplacianKind::Tufted)).unwrap();
        for (i, row) in l.stiffness.outer_iterator().enumerate() {
            let (mut sum, mut size) = (0.0, 0.0);
            for (j, &w) in row.iter() {
                assert!(i == j || w <= 0.0, "{name}: {i} {j} {w}");
                sum += w;
                size += w.abs();
            }
            assert!(sum.abs() <= 1e-13 * size, "{name}: row {i}");
        }
        let Mass::Lumped(mass) = &l.mass else { panic!("a diagonal is the default") };
        let (sum, area) = (mass.iter().sum::<f64>(), mesh.area());
        assert!((sum / area - 1.0).abs() < 1e-2, "{name}: {sum} of {area}");
    }
}

#[test]
fn slivers_have_an_intrinsic_delaunay_laplacian_with_the_spectrum_of_the_tufted_one() {
    for name in ["adis16480_slivers.stl.gz", "cheese_genus133.off.gz"] {
        let Some(mesh) = real(name) else { continue };
        let values = [LaplacianKind::IntrinsicDelaunay, LaplacianKind::Tufted].map(|kind| {
            let l = laplacian(&mesh, &options(kind)).unwrap();
            // Closed meshes: every edge is inside.
            assert!(l.stiffness.iter().all(|(&w, (i, j))| i == j || w <= 0.0), "{name} {kind:?}");
            spectrum(&l, 8).values
        });
        // Without boundary the cover is two copies of the surface, joined at vertices alone. They
        // may differ in the diagonals of quadrilaterals on a circle, and so in their lumped masses.
        for (a, b) in values[0].iter().zip(&values[1]) {
            assert!((a - b).abs() < 1e-3 * values[1][7], "{name}: {a} {b}");
        }
    }
}

#[test]
fn heat_distances_on_a_real_mesh_are_a_little_shorter_than_those_along_edges() {
    let Some(mesh) = real("spot.obj.gz") else { return };
    let solver = HeatMethod::new(&mesh, &HeatOptions::default()).unwrap();
    let heat = solver.distances(&[0]).unwrap();
    let graph = Graph::of_mesh(&mesh);
    let mut search = Dijkstra::new(&graph);
    search.search(&[(0, 0.0)], &SearchLimits::default()).unwrap();
    let along = search.distances();
    let farthest = along.iter().copied().fold(0.0, f64::max);
    for (v, (h, d)) in heat.iter().zip(along).enumerate() {
        assert!(*h < d + 0.03 * farthest && *h > 0.7 * d - 0.03 * farthest, "{v}: {h} {d}");
    }
}

#[test]
fn free_components_are_counted_and_have_eigenvalues_that_are_exactly_zero() {
    use catamaran_geometry::mesh;
    let scaled = |mesh: TriMesh, x: f64| {
        let (mut vertices, faces) = mesh.into_parts();
        vertices.iter_mut().flatten().for_each(|p| *p *= x);
        TriMesh::new(vertices, faces).unwrap()
    };
    let torus = families::torus(16, 8, 1.0, 0.3).unwrap();
    for mesh in [
        families::icosphere(0).unwrap(),
        families::spheres(4, 0).unwrap(),
        families::spheres(3, 3).unwrap(),
        scaled(families::spheres(2, 2).unwrap(), 1e-5),
        families::grid(5, 4).unwrap(),
        families::bow_tie().unwrap(),
        scaled(torus, 1e4),
    ] {
        for boundary in [Boundary::Neumann, Boundary::Dirichlet, Boundary::Mixed(vec![0])] {
            for kind in [LaplacianKind::Cotangent, LaplacianKind::Tufted] {
                let how = LaplacianOptions::new().kind(kind).boundary(boundary.clone());
                let found = laplacian(&mesh, &how).unwrap();
                let count = free_components(found.stiffness.view(), &found.mass).unwrap();
                assert_eq!(count, mesh::free_components(&mesh, &boundary).unwrap());
                let k = (count + 2).min(found.kept.len());
                let pairs =
                    eigs(found.stiffness.view(), &found.mass, &EigenOptions::new().k(k)).unwrap();
                let zeros = pairs.values.iter().take_while(|value| **value == 0.0).count();
                assert_eq!(zeros, count, "{boundary:?} {kind:?}: {:?}", pairs.values);
            }
        }
    }
    let outside = Boundary::Mixed(vec![42]);
    let refused = mesh::free_components(&families::icosphere(0).unwrap(), &outside).unwrap_err();
    assert!(refused.to_string().contains("is out of range: 12 vertices"), "{refused}");
}
