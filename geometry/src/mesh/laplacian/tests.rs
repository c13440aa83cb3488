use faer::{Mat, Side};
use sprs::CsMat;

use super::*;
use crate::mesh::{families, shapes};
use catamaran::base::Par;
use catamaran::sparse::Mass;

const KINDS: [LaplacianKind; 3] =
    [LaplacianKind::Cotangent, LaplacianKind::IntrinsicDelaunay, LaplacianKind::Tufted];
const MASSES: [MassKind; 3] = [MassKind::Barycentric, MassKind::MixedVoronoi, MassKind::Consistent];

fn options(kind: LaplacianKind, mass: MassKind) -> LaplacianOptions {
    LaplacianOptions { kind, mass, par: Par::Seq, ..Default::default() }
}

fn dense(matrix: &CsMat<f64>) -> Mat<f64> {
    Mat::from_fn(matrix.rows(), matrix.cols(), |i, j| matrix.get(i, j).copied().unwrap_or(0.0))
}

fn dense_mass(mass: &Mass) -> Mat<f64> {
    match mass {
        Mass::Lumped(d) => Mat::from_fn(d.len(), d.len(), |i, j| if i == j { d[i] } else { 0.0 }),
        Mass::Full(matrix) => dense(matrix),
    }
}

fn sum(mass: &Mass) -> f64 {
    match mass {
        Mass::Lumped(d) => d.iter().sum(),
        Mass::Full(matrix) => matrix.data().iter().sum(),
    }
}

fn area(mesh: &TriMesh) -> f64 {
    Complex::of_mesh(mesh).unwrap().lengths.iter().map(|&l| element::area(l)).sum()
}

fn eigenvalues(matrix: &Mat<f64>) -> Vec<f64> {
    matrix.self_adjoint_eigenvalues(Side::Lower).unwrap()
}

fn largest_difference(a: &CsMat<f64>, b: &CsMat<f64>) -> f64 {
    (dense(a) - dense(b)).norm_max()
}

/// Asserts symmetry bit for bit, zero row sums, no negative eigenvalue, and a positive mass whose
/// sum is the area.
fn check(l: &Laplacian, area: f64, tolerance: f64, name: &str) {
    let w = dense(&l.stiffness);
    assert!(w == w.transpose().to_owned(), "{name}: not symmetric");
    let size = w.norm_max().max(1e-300);
    for (i, row) in l.stiffness.outer_iterator().enumerate() {
        let sum: f64 = row.data().iter().sum();
        assert!(sum.abs() <= 1e-13 * size, "{name}: row {i} sums to {sum}");
    }
    if w.nrows() > 0 {
        assert!(eigenvalues(&w)[0] >= -1e-13 * size * w.nrows() as f64, "{name}: not PSD");
        assert!(eigenvalues(&dense_mass(&l.mass))[0] > 0.0, "{name}: mass");
    }
    assert!((sum(&l.mass) - area).abs() <= tolerance * area, "{name}: {} {area}", sum(&l.mass));
}

fn all_nonnegative(l: &Laplacian) -> bool {
    l.stiffness.iter().all(|(&w, (i, j))| i == j || w <= 0.0)
}

#[test]
fn a_triangle_has_its_textbook_matrices() {
    let triangle =
        TriMesh::new(vec![[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]], vec![[0, 1, 2]])
            .unwrap();
    let w = [[1.0, -0.5, -0.5], [-0.5, 0.5, 0.0], [-0.5, 0.0, 0.5]];
    let masses = [
        [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]].map(|r| r.map(|x| x / 6.0)),
        [[2.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]].map(|r| r.map(|x| x / 8.0)),
        [[2.0, 1.0, 1.0], [1.0, 2.0, 1.0], [1.0, 1.0, 2.0]].map(|r| r.map(|x| x / 24.0)),
    ];
    for kind in KINDS {
        for (mass, expected) in MASSES.into_iter().zip(masses) {
            let l = laplacian(&triangle, &options(kind, mass)).unwrap();
            let difference = dense(&l.stiffness) - Mat::from_fn(3, 3, |i, j| w[i][j]);
            assert!(difference.norm_max() < 1e-15, "{kind:?}: {difference:?}");
            let difference = dense_mass(&l.mass) - Mat::from_fn(3, 3, |i, j| expected[i][j]);
            assert!(difference.norm_max() < 1e-15, "{kind:?} {mass:?}: {difference:?}");
        }
    }
}

#[test]
fn an_obtuse_triangle_gives_half_of_its_area_to_the_obtuse_corner() {
    let triangle =
        TriMesh::new(vec![[0.0, 0.0, 0.0], [4.0, 0.0, 0.0], [2.0, 1.0, 0.0]], vec![[0, 1, 2]])
            .unwrap();
    let l = laplacian(&triangle, &options(LaplacianKind::Cotangent, MassKind::MixedVoronoi));
    assert_eq!(l.unwrap().mass, Mass::Lumped(vec![0.5, 0.5, 1.0]));
}

#[test]
fn a_square_grid_has_the_five_point_stencil() {
    let mesh = shapes::grid(4, 3);
    let l = laplacian(&mesh, &options(LaplacianKind::Cotangent, MassKind::Barycentric)).unwrap();
    let inside = 5 + 1;
    let row = l.stiffness.outer_view(inside).unwrap();
    let entries: Vec<_> = row.iter().filter(|e| *e.1 != 0.0).map(|(j, &w)| (j, w)).collect();
    assert_eq!(entries, [(1, -1.0), (5, -1.0), (6, 4.0), (7, -1.0), (11, -1.0)]);
    let Mass::Lumped(mass) = l.mass else { panic!("a diagonal was asked for") };
    assert!((mass[inside] - 1.0).abs() < 1e-15);
}

#[test]
fn every_kind_is_symmetric_semi_definite_and_knows_constants_and_area() {
    let meshes = [
        ("sphere", shapes::sphere(2)),
        ("shaken sphere", shapes::shaken(&shapes::sphere(2), 0.1, 1)),
        ("grid", shapes::grid(5, 3)),
        ("shaken grid", shapes::shaken(&shapes::grid(5, 4), 0.4, 2)),
        ("two", shapes::both(&shapes::grid(2, 2), &shapes::sphere(1), 5.0)),
        ("empty", TriMesh::new(vec![], vec![]).unwrap()),
    ];
    for (name, mesh) in meshes {
        for kind in KINDS {
            for mass in MASSES {
                let l = laplacian(&mesh, &options(kind, mass)).unwrap();
                let name = format!("{name} {kind:?} {mass:?}");
                assert_eq!(l.kept, (0..mesh.vertices().len()).collect::<Vec<_>>());
                // The mass of another triangulation of the same surface has the same sum, the area.
                check(&l, area(&mesh), 1e-12, &name);
                if kind == LaplacianKind::Tufted
                    || (kind != LaplacianKind::Cotangent && name.contains("sphere"))
                {
                    assert!(all_nonnegative(&l), "{name}");
                }
            }
        }
    }
}

#[test]
fn robust_kinds_are_the_cotangent_one_where_it_is_delaunay() {
    let mesh = shapes::sphere(3);
    let l = KINDS.map(|k| laplacian(&mesh, &options(k, MassKind::Consistent)).unwrap());
    for other in &l[1..] {
        assert!(largest_difference(&l[0].stiffness, &other.stiffness) < 1e-12);
        let difference = dense_mass(&l[0].mass) - dense_mass(&other.mass);
        assert!(difference.norm_max() < 1e-15);
    }
}

#[test]
fn flips_in_the_plane_give_the_delaunay_triangulation() {
    // In a flat kite, the short diagonal is the Delaunay edge.
    let vertices = vec![[-3.0, 0.0, 0.0], [3.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, -1.0, 0.0]];
    let long = TriMesh::new(vertices.clone(), vec![[0, 1, 2], [1, 0, 3]]).unwrap();
    let short = TriMesh::new(vertices, vec![[0, 3, 2], [3, 1, 2]]).unwrap();
    let flipped = options(LaplacianKind::IntrinsicDelaunay, MassKind::Barycentric);
    let plain = options(LaplacianKind::Cotangent, MassKind::Barycentric);
    let (flipped, plain) =
        (laplacian(&long, &flipped).unwrap(), laplacian(&short, &plain).unwrap());
    // Outside of the common pattern there are no entries.
    assert!(largest_difference(&flipped.stiffness, &plain.stiffness) < 1e-14);
    let (Mass::Lumped(a), Mass::Lumped(b)) = (flipped.mass, plain.mass) else { panic!() };
    assert!(a.iter().zip(&b).all(|(x, y)| (x - y).abs() < 1e-14));
}

#[test]
fn flips_of_a_sheared_grid_restore_the_square_one() {
    // Integer shears map the lattice to itself: the Delaunay edges are those of squares again.
    let square = shapes::grid(8, 8);
    let sheared: Vec<_> =
        square.vertices().iter().map(|p| [p[0] + 3.0 * p[1], p[1], 0.0]).collect();
    let sheared = TriMesh::new(sheared, square.faces().to_vec()).unwrap();
    let l = laplacian(&sheared, &options(LaplacianKind::IntrinsicDelaunay, MassKind::Barycentric))
        .unwrap();
    // Vertex (4, 4) of the grid lies at x = 16; these are its neighbours in the lattice, as grid
    // indices.
    let index = |x: i32, y: i32| (y * 9 + x - 3 * y) as usize;
    let row = l.stiffness.outer_view(index(16, 4)).unwrap();
    let entries: Vec<_> =
        row.iter().filter(|e| e.1.abs() > 1e-9).map(|(j, &w)| (j, w.round())).collect();
    let mut expected: Vec<_> = [(16, 3), (15, 4), (17, 4), (16, 5)]
        .into_iter()
        .filter(|&(x, y)| (0..9).contains(&(x - 3 * y)))
        .map(|(x, y)| (index(x, y), -1.0))
        .chain([(index(16, 4), 4.0)])
        .collect();
    expected.sort_by_key(|e| e.0);
    assert_eq!(entries, expected);
}

#[test]
fn spherical_harmonics_have_eigenvalues_l_times_l_plus_one() {
    let mesh = shapes::sphere(3);
    for kind in KINDS {
        let l = laplacian(&mesh, &options(kind, MassKind::Barycentric)).unwrap();
        let Mass::Lumped(mass) = &l.mass else { panic!("a diagonal was asked for") };
        let w = dense(&l.stiffness);
        let n = mass.len();
        let scaled = Mat::from_fn(n, n, |i, j| w[(i, j)] / (mass[i] * mass[j]).sqrt());
        let values = eigenvalues(&scaled);
        assert!(values[0].abs() < 1e-10, "{kind:?}");
        let mut at = 1;
        for degree in 1..5 {
            let exact = f64::from(degree * (degree + 1));
            for value in &values[at..at + 2 * degree as usize + 1] {
                // The error of linear elements grows with lambda h^2.
                assert!(
                    (value / exact - 1.0).abs() < 0.005 * exact,
                    "{kind:?}: {value} for {exact}"
                );
            }
            at += 2 * degree as usize + 1;
        }
    }
}

#[test]
fn a_face_without_area_is_named_by_the_plain_kind_and_borne_by_the_others() {
    let mut vertices = shapes::grid(3, 3).into_parts().0;
    vertices[5] = vertices[4]; // equal positions: two faces collapse, others change
    let mesh = TriMesh::new(vertices, shapes::grid(3, 3).into_parts().1).unwrap();
    let error = laplacian(&mesh, &options(KINDS[0], MASSES[0])).unwrap_err();
    assert!(error.to_string().starts_with("face 1: has no area"), "{error}");
    for kind in &KINDS[1..] {
        for mass in MASSES {
            let l = laplacian(&mesh, &options(*kind, mass)).unwrap();
            check(&l, area(&mesh), 1e-3, &format!("{kind:?} {mass:?}"));
        }
    }
    // All vertices have the same position, so no length is positive.
    let point = TriMesh::new(vec![[1.0; 3]; 3], vec![[0, 1, 2]]).unwrap();
    for kind in KINDS {
        assert!(laplacian(&point, &options(kind, MASSES[0])).is_err());
    }
}

#[test]
fn numbers_out_of_range_are_errors() {
    for size in [1e-200, 1e200] {
        let vertices = vec![[0.0; 3], [size, 0.0, 0.0], [0.0, size, 0.0]];
        let mesh = TriMesh::new(vertices, vec![[0, 1, 2]]).unwrap();
        for kind in KINDS {
            let error = laplacian(&mesh, &options(kind, MASSES[0])).unwrap_err();
            assert!(matches!(error, Error::Mesh { .. }), "{kind:?} {size}: {error}");
        }
    }
}

#[test]
fn an_edge_of_three_faces_needs_the_tufted_kind() {
    let mesh = families::pages(3).unwrap();
    let error =
        laplacian(&mesh, &options(LaplacianKind::IntrinsicDelaunay, MASSES[0])).unwrap_err();
    assert!(error.to_string().starts_with("edge 0-1: has three faces"), "{error}");
    let plain = laplacian(&mesh, &options(LaplacianKind::Cotangent, MASSES[2])).unwrap();
    let tufted = laplacian(&mesh, &options(LaplacianKind::Tufted, MASSES[2])).unwrap();
    check(&plain, area(&mesh), 1e-14, "plain");
    check(&tufted, area(&mesh), 1e-14, "tufted");
    // No angle is obtuse, so the cover is Delaunay already.
    assert!(largest_difference(&plain.stiffness, &tufted.stiffness) < 1e-14);
}

#[test]
fn neighbours_that_disagree_on_the_outside_need_the_tufted_kind() {
    let mut faces = shapes::sphere(1).into_parts().1;
    faces[3].swap(0, 1);
    let mesh = TriMesh::new(shapes::sphere(1).into_parts().0, faces).unwrap();
    let error =
        laplacian(&mesh, &options(LaplacianKind::IntrinsicDelaunay, MASSES[0])).unwrap_err();
    assert!(error.to_string().contains("disagree about which side"), "{error}");
    let tufted = laplacian(&mesh, &options(LaplacianKind::Tufted, MASSES[0])).unwrap();
    let plain = laplacian(&mesh, &options(LaplacianKind::Cotangent, MASSES[0])).unwrap();
    assert!(largest_difference(&plain.stiffness, &tufted.stiffness) < 1e-12);
}

#[test]
fn any_triangles_have_a_tufted_laplacian() {
    for seed in 0..60 {
        let n = 4 + (seed % 13) as u32;
        let mesh = shapes::soup(n, 3 + seed as usize % 17, seed);
        for mass in MASSES {
            let l = match laplacian(&mesh, &options(LaplacianKind::Tufted, mass)) {
                Ok(l) => l,
                Err(error) => panic!("seed {seed} {mass:?}: {error}"),
            };
            assert!(all_nonnegative(&l), "seed {seed} {mass:?}");
            check(&l, sum(&l.mass), 1e-12, &format!("seed {seed} {mass:?}"));
        }
    }
}

#[test]
fn vertices_in_no_face_are_left_out() {
    let (mut vertices, faces) = shapes::sphere(1).into_parts();
    let n = vertices.len();
    vertices.push([9.0; 3]);
    let lonely = TriMesh::new(vertices, faces).unwrap();
    for kind in KINDS {
        let with = laplacian(&lonely, &options(kind, MASSES[2])).unwrap();
        let without = laplacian(&shapes::sphere(1), &options(kind, MASSES[2])).unwrap();
        assert_eq!((with.vertices, without.vertices), (n + 1, n));
        assert_eq!((with.stiffness, with.mass), (without.stiffness, without.mass));
        assert_eq!(with.kept, without.kept);
    }
    let none = TriMesh::new(vec![[0.0; 3]; 2], vec![]).unwrap();
    let l = laplacian(&none, &options(KINDS[0], MASSES[2])).unwrap();
    assert_eq!((l.kept.len(), l.stiffness.shape(), l.mass.len()), (0, (0, 0), 0));
}

#[test]
fn dirichlet_removes_the_boundary_and_mixed_what_it_is_told() {
    let mesh = shapes::grid(4, 3);
    for kind in KINDS {
        for mass in MASSES {
            let neumann = options(kind, mass);
            let dirichlet = LaplacianOptions { boundary: Boundary::Dirichlet, ..neumann.clone() };
            let all = laplacian(&mesh, &neumann).unwrap();
            let inner = laplacian(&mesh, &dirichlet).unwrap();
            assert_eq!(inner.kept, [6, 7, 8, 11, 12, 13]);
            let full = [dense(&all.stiffness), dense_mass(&all.mass)];
            let less = [dense(&inner.stiffness), dense_mass(&inner.mass)];
            for (full, less) in full.iter().zip(&less) {
                let expected = Mat::from_fn(6, 6, |i, j| full[(inner.kept[i], inner.kept[j])]);
                assert!(*less == expected, "{kind:?} {mass:?}");
            }
            assert!(eigenvalues(&less[0])[0] > 0.1, "{kind:?}: definite without constants");
            let mixed = Boundary::Mixed(vec![0, 19, 7]);
            let mixed = laplacian(&mesh, &LaplacianOptions { boundary: mixed, ..neumann }).unwrap();
            assert_eq!(mixed.kept.len(), 17);
            let functions = Mat::from_fn(17, 2, |i, j| (i + 20 * j) as f64 + 1.0);
            let extended = mixed.extend(functions.as_ref()).unwrap();
            assert_eq!((extended.nrows(), extended[(7, 0)], extended[(1, 0)]), (20, 0.0, 1.0));
            assert!(mixed.restrict(extended.as_ref()).unwrap() == functions);
            assert!(mixed.restrict(functions.as_ref()).is_err());
            assert!(mixed.extend(extended.as_ref()).is_err());
        }
    }
    let closed = LaplacianOptions { boundary: Boundary::Dirichlet, ..Default::default() };
    assert_eq!(laplacian(&shapes::sphere(0), &closed).unwrap().kept.len(), 12);
    let beyond = LaplacianOptions { boundary: Boundary::Mixed(vec![20]), ..Default::default() };
    let error = laplacian(&mesh, &beyond).unwrap_err();
    assert!(error.to_string().starts_with("vertex 20: "), "{error}");
}

#[test]
fn the_number_of_threads_changes_no_bit() {
    // The mesh has more vertices than one block.
    let mesh = shapes::shaken(&shapes::grid(130, 131), 0.45, 3);
    for kind in KINDS {
        let at = |threads| {
            let par = Par::Threads(threads);
            let options = LaplacianOptions { par, ..options(kind, MassKind::Consistent) };
            laplacian(&mesh, &options).unwrap()
        };
        let one = at(1);
        assert!(one == at(2) && one == at(3), "{kind:?}");
    }
}

#[test]
fn rows_of_any_share_are_those_of_the_whole_laplacian() {
    let mesh = families::grid(7, 5).unwrap();
    for kind in [LaplacianKind::Cotangent, LaplacianKind::Tufted] {
        for (boundary, mass) in [
            (Boundary::Neumann, MassKind::Barycentric),
            (Boundary::Dirichlet, MassKind::Consistent),
            (Boundary::Mixed(vec![0, 3, 47]), MassKind::MixedVoronoi),
        ] {
            let options = LaplacianOptions::new().kind(kind).boundary(boundary).mass(mass);
            let whole = laplacian(&mesh, &options).unwrap();
            let n = whole.kept.len();
            for rows in [0..n, 0..0, n..n, 3..4, 5..n - 2] {
                let own = laplacian_rows(&mesh, &options, |_| rows.clone()).unwrap();
                assert_eq!((own.stiffness.rows(), &own.kept), (rows.len(), &whole.kept));
                for (i, row) in rows.clone().enumerate() {
                    assert_eq!(own.stiffness.outer_view(i), whole.stiffness.outer_view(row));
                    match (&own.mass, &whole.mass) {
                        (Mass::Lumped(own), Mass::Lumped(all)) => assert_eq!(own[i], all[row]),
                        (Mass::Full(own), Mass::Full(all)) => {
                            assert_eq!(own.outer_view(i), all.outer_view(row));
                        }
                        _ => panic!("a mass of another kind"),
                    }
                }
            }
            assert!(laplacian_rows(&mesh, &options, |n| 1..n + 1).is_err());
        }
    }
}
