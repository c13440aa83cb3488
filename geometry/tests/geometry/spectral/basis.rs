//! Eigenbases and orthogonalized eigenproducts.

use catamaran::base::Progress;
use catamaran::faer::{Mat, MatRef};
use catamaran::sparse::{CsMat, Mass};
use catamaran::{Error, Par};
use catamaran_geometry::mesh::families;
use catamaran_geometry::spectral::{
    Basis, Eigenbasis, Orthogonalization, ProductBasis, ProductBasisOptions, TruncatedProducts,
    relative_errors,
};

use crate::common::{bits, gaussian};
use crate::surface::{THREADS, blob, coordinates, eigenbasis, laplacian};

const OURS: Orthogonalization = Orthogonalization::SinglePass;
const OURS_STAR: Orthogonalization = Orthogonalization::Reorthogonalized;

pub fn products(
    eigenbasis: &Eigenbasis,
    order: usize,
    orthogonalization: Orthogonalization,
) -> ProductBasis {
    let options = ProductBasisOptions::new().orthogonalization(orthogonalization);
    ProductBasis::new(eigenbasis, order, &options).unwrap()
}

/// The products B, by the definition.
fn all_products(eigenbasis: &Eigenbasis, basis: &ProductBasis) -> Mat<f64> {
    let constant = eigenbasis.constant().unwrap();
    let f = eigenbasis.functions();
    Mat::from_fn(f.nrows(), basis.products().len(), |x, j| {
        let factors = basis.products().factors(j).unwrap();
        factors.iter().map(|&i| f[(x, i)] / constant).product()
    })
}

fn gram(basis: &Basis) -> Mat<f64> {
    let Mass::Lumped(mass) = basis.mass() else { panic!("a lumped mass") };
    let q = basis.functions();
    let weighted = Mat::from_fn(q.nrows(), q.ncols(), |i, j| mass[i] * q[(i, j)]);
    q.transpose() * weighted
}

fn distance(a: MatRef<'_, f64>, b: MatRef<'_, f64>) -> f64 {
    (a - b).norm_max()
}

/// Eigenfunctions of a ring of n equal masses: the constant, cosines and sines.
fn ring(n: usize, frequencies: usize) -> Eigenbasis {
    let values = (0..=2 * frequencies).map(|i| (i.div_ceil(2) as f64).powi(2)).collect();
    let vectors = Mat::from_fn(n, 2 * frequencies + 1, |x, i| {
        let angle = std::f64::consts::TAU * (x * i.div_ceil(2)) as f64 / n as f64;
        match i {
            0 => 1.0,
            _ if i % 2 == 1 => std::f64::consts::SQRT_2 * angle.cos(),
            _ => std::f64::consts::SQRT_2 * angle.sin(),
        }
    });
    Eigenbasis::new(values, vectors, Mass::Lumped(vec![1.0 / n as f64; n])).unwrap()
}

#[test]
fn the_constant_is_made_the_first_function_of_a_mesh_in_several_pieces() {
    // Three separate points with masses 1, 2, 3, whose null space comes in some rotation.
    let mass = [1.0, 2.0, 3.0f64];
    let rotation = gaussian::<f64>(3, 3, 4).qr().compute_thin_Q();
    let vectors = Mat::from_fn(3, 3, |i, j| rotation[(i, j)] / mass[i].sqrt());
    let basis = Eigenbasis::new(vec![0.0; 3], vectors, Mass::Lumped(mass.to_vec())).unwrap();
    assert_eq!(basis.constant(), Some(1.0 / 6f64.sqrt()));
    assert!(basis.functions().col(0).iter().all(|&x| x == 1.0 / 6f64.sqrt()));
    assert!(distance(gram(basis.basis()).as_ref(), Mat::identity(3, 3).as_ref()) < 1e-14);
}

#[test]
fn fewer_eigenfunctions_than_components_are_said_to_be_the_reason_that_there_are_no_products() {
    let (mesh, k) = (families::spheres(6, 1).unwrap(), 4);
    let few = eigenbasis(&mesh, k);
    let refused = ProductBasis::new(&few, 2, &ProductBasisOptions::new()).unwrap_err().to_string();
    assert!(refused.contains("all 4 eigenvalues are zero"), "{refused}");
    assert!(refused.contains("more functions than the mesh has components"), "{refused}");
    ProductBasis::new(&eigenbasis(&mesh, 6), 1, &ProductBasisOptions::new()).unwrap();
}

#[test]
fn a_basis_without_the_constant_has_no_products() {
    let sine = Mat::from_fn(99, 1, |i, _| {
        (std::f64::consts::PI * (i + 1) as f64 / 100.0).sin() * 2f64.sqrt()
    });
    let mass = Mass::Lumped(vec![0.01; 99]);
    let basis = Eigenbasis::new(vec![std::f64::consts::PI.powi(2)], sine, mass).unwrap();
    assert_eq!(basis.constant(), None);
    let error = ProductBasis::new(&basis, 2, &ProductBasisOptions::default()).unwrap_err();
    assert!(matches!(error, Error::Argument { what: "eigenbasis", .. }), "{error}");
}

#[test]
fn products_of_a_single_pass_that_depend_on_each_other_are_an_error_about_the_method() {
    // A regular grid has many products that are nearly combinations of others.
    let eigen = eigenbasis(&families::grid(16, 16).unwrap(), 41);
    let error = ProductBasis::new(&eigen, 3, &ProductBasisOptions::new()).unwrap_err();
    assert!(matches!(error, Error::Argument { what: "orthogonalization", .. }), "{error}");
    let said = error.to_string();
    assert!(said.contains("a single pass over 12341 products leaves dependent"), "{said}");
    assert!(products(&eigen, 3, Orthogonalization::RankRevealing).len() <= 289);
}

#[test]
fn the_reorthogonalized_basis_is_orthonormal_and_spans_the_products() {
    let eigen = eigenbasis(&blob(2), 6);
    for order in [0, 1, 2, 3] {
        let basis = products(&eigen, order, OURS_STAR);
        let identity = Mat::<f64>::identity(basis.len(), basis.len());
        assert!(distance(gram(basis.basis()).as_ref(), identity.as_ref()) < 1e-12);
        let b = all_products(&eigen, &basis);
        let qr = basis.functions() * basis.r();
        assert!(distance(qr.as_ref(), b.as_ref()) < 1e-7 * b.norm_max());
        for (j, &column) in basis.kept().iter().enumerate() {
            assert!(basis.r()[(j, column)] > 0.0);
            assert!((j + 1..basis.len()).all(|i| basis.r()[(i, column)] == 0.0));
        }
    }
}

#[test]
fn products_of_one_factor_are_the_eigenfunctions() {
    let eigen = eigenbasis(&blob(2), 9);
    for mode in [OURS, OURS_STAR] {
        let basis = products(&eigen, 1, mode);
        assert_eq!(basis.kept(), (0..9).collect::<Vec<_>>());
        assert!(distance(basis.functions(), eigen.functions()) < 1e-10);
    }
}

#[test]
fn powers_of_one_function_and_the_constant_alone_are_bases_too() {
    let eigen = eigenbasis(&blob(2), 2);
    let basis = products(&eigen, 4, OURS_STAR);
    assert_eq!(basis.len(), 5);
    let eigen = eigen.truncated(1).unwrap();
    let basis = products(&eigen, 3, OURS);
    assert_eq!((basis.len(), basis.products().len()), (1, 1));
    assert!(distance(basis.functions(), eigen.functions()) < 1e-12);
}

#[test]
fn a_product_in_the_span_of_those_before_it_is_dropped() {
    // cos^2 + sin^2 = 1, and products of frequencies 1 and 2 are of frequencies 1 and 3.
    let basis = products(&ring(60, 1), 2, OURS_STAR);
    assert_eq!(basis.kept(), [0, 1, 2, 3, 4]);
    // Trigonometric polynomials of frequency at most 2 * 3 have 13 dimensions.
    assert_eq!(products(&ring(60, 3), 2, OURS_STAR).len(), 13);
    assert_eq!(products(&ring(60, 3), 3, OURS_STAR).len(), 19);
}

#[test]
fn squares_of_the_first_harmonics_of_the_sphere_are_dependent() {
    // x^2 + y^2 + z^2 = 1: of the 10 products of order 2 one is dropped.
    let sphere = families::icosphere(2).unwrap();
    let (_, mass) = laplacian(&sphere);
    let area: f64 = mass.iter().sum();
    let square: f64 = (0..mass.len()).map(|i| mass[i] * sphere.vertices()[i][0].powi(2)).sum();
    let vectors = Mat::from_fn(mass.len(), 4, |i, j| match j {
        0 => 1.0 / area.sqrt(),
        _ => sphere.vertices()[i][j - 1] / square.sqrt(),
    });
    let eigen = Eigenbasis::new(vec![0.0, 2.0, 2.0, 2.0], vectors, Mass::Lumped(mass)).unwrap();
    for mode in [OURS, OURS_STAR] {
        let basis = products(&eigen, 2, mode);
        assert_eq!(basis.kept(), (0..9).collect::<Vec<_>>());
    }
}

#[test]
fn the_single_pass_projects_by_least_squares() {
    let eigen = eigenbasis(&blob(2), 8);
    let basis = products(&eigen, 3, OURS);
    let star = products(&eigen, 3, OURS_STAR);
    assert!(basis.len() < star.len(), "{} {}", basis.len(), star.len());
    // What is in the span comes back, though the basis is not orthogonal.
    let inside = basis.functions() * gaussian::<f64>(basis.len(), 2, 1);
    let back = basis.basis().approximation(inside.as_ref(), Par::Seq).unwrap();
    assert!(distance(back.as_ref(), inside.as_ref()) < 1e-9 * inside.norm_max());
    // The larger space approximates at least as well.
    let f = coordinates(&blob(2));
    let error = |basis: &Basis| {
        let g = basis.approximation(f.as_ref(), Par::Seq).unwrap();
        relative_errors(f.as_ref(), g.as_ref(), basis.mass()).unwrap()
    };
    let (k, ours, all) = (error(eigen.basis()), error(basis.basis()), error(star.basis()));
    for c in 0..3 {
        assert!(all[c] <= ours[c] + 1e-12 && ours[c] < k[c], "{k:?} {ours:?} {all:?}");
    }
}

#[test]
fn everything_is_the_same_for_a_full_mass_that_happens_to_be_diagonal() {
    let (mesh, k) = (blob(1), 4);
    let (_, mass) = laplacian(&mesh);
    let lumped = eigenbasis(&mesh, k);
    let mut full = sprs::TriMat::new((mass.len(), mass.len()));
    for (i, m) in mass.iter().enumerate() {
        full.add_triplet(i, i, *m);
    }
    let full: CsMat<f64> = full.to_csr();
    let full =
        Eigenbasis::new(lumped.values().to_vec(), lumped.functions().to_owned(), Mass::Full(full));
    let (a, b) = (products(&lumped, 2, OURS), products(&full.unwrap(), 2, OURS));
    assert_eq!(a.kept(), b.kept());
    assert!(distance(a.functions(), b.functions()) < 1e-9);
    let f = coordinates(&mesh);
    let (a, b) =
        (a.basis().analysis(f.as_ref(), Par::Seq), b.basis().analysis(f.as_ref(), Par::Seq));
    assert!(distance(a.unwrap().as_ref(), b.unwrap().as_ref()) < 1e-9);
}

#[test]
fn bases_do_not_depend_on_the_size_of_the_mesh() {
    let mesh = blob(1);
    let (vertices, faces) = mesh.clone().into_parts();
    let large = vertices.into_iter().map(|p| p.map(|x| 1024.0 * x)).collect();
    let large = catamaran_geometry::mesh::TriMesh::new(large, faces).unwrap();
    let (a, b) = (eigenbasis(&mesh, 5), eigenbasis(&large, 5));
    let (a, b) = (products(&a, 3, OURS), products(&b, 3, OURS));
    assert_eq!(a.kept(), b.kept());
}

#[test]
fn truncated_products_are_the_least_coefficients() {
    let eigen = eigenbasis(&blob(2), 4);
    let basis = products(&eigen, 2, OURS_STAR);
    assert_eq!(basis.len(), 10);
    let f = coordinates(&blob(2));
    let all = TruncatedProducts::new(&basis, 0.0).unwrap();
    assert_eq!(all.rank(), 10);
    let a = all.analysis(f.as_ref(), Par::Seq).unwrap();
    let back = all.synthesis(a.as_ref(), Par::Seq).unwrap();
    let expected = basis.basis().approximation(f.as_ref(), Par::Seq).unwrap();
    assert!(distance(back.as_ref(), expected.as_ref()) < 1e-10);
    let b = all_products(&eigen, &basis);
    assert!(distance((&b * &a).as_ref(), expected.as_ref()) < 1e-8);
    // Dependent products: of all coefficients the shortest ones.
    let ring = ring(60, 1);
    let basis = products(&ring, 2, OURS_STAR);
    let least = TruncatedProducts::new(&basis, 1e-8).unwrap();
    assert_eq!(least.rank(), 5);
    let one = Mat::<f64>::ones(60, 1);
    let a = least.analysis(one.as_ref(), Par::Seq).unwrap();
    // 1 = x + y (2 cos^2 + 2 sin^2), x + 2 y = 1, with the least x^2 + 2 y^2: y = x.
    let third = 1.0 / 3.0;
    for (j, expected) in [third, 0.0, 0.0, third, 0.0, third].into_iter().enumerate() {
        assert!((a[(j, 0)] - expected).abs() < 1e-12, "{a:?}");
    }
    // A higher threshold uses fewer.
    let mut few = TruncatedProducts::new(&basis, 0.9).unwrap();
    assert!(few.rank() < 5);
    let refused = TruncatedProducts::new(&basis, 1.0).map(drop);
    assert!(matches!(refused, Err(Error::Argument { what: "threshold", .. })), "{refused:?}");
    let refused = few.set_threshold(f64::NAN);
    assert!(matches!(refused, Err(Error::Argument { what: "threshold", .. })), "{refused:?}");
    few.set_threshold(1e-8).unwrap();
    assert_eq!(few.analysis(one.as_ref(), Par::Seq).unwrap(), a);
}

#[test]
fn threads_do_not_change_a_bit() {
    let eigen = eigenbasis(&blob(2), 7);
    let f = coordinates(&blob(2));
    for orthogonalization in [OURS, OURS_STAR] {
        let mut all = THREADS.into_iter().map(|par| {
            let options = ProductBasisOptions::new()
                .orthogonalization(orthogonalization)
                .par(par)
                .progress(Progress::none());
            let basis = ProductBasis::new(&eigen, 3, &options).unwrap();
            let g = basis.basis().approximation(f.as_ref(), par).unwrap();
            (bits(basis.functions()), bits(basis.r()), bits(g.as_ref()))
        });
        let first = all.next().unwrap();
        assert!(all.all(|other| other == first));
    }
}

#[test]
fn dirty_input_is_refused_by_name() {
    let mass = || Mass::Lumped(vec![1.0, 2.0]);
    let refused = |values: &[f64], vectors: Mat<f64>, mass: Mass| {
        Eigenbasis::new(values.to_vec(), vectors, mass).unwrap_err()
    };
    let two = || Mat::<f64>::identity(2, 2);
    let error = refused(&[1.0], two(), mass());
    assert!(matches!(error, Error::Shape { what: "eigenvalues", .. }), "{error}");
    let error = refused(&[2.0, 1.0], two(), mass());
    assert!(matches!(error, Error::Argument { what: "eigenvalues", .. }), "{error}");
    let error = refused(&[1.0, f64::NAN], two(), mass());
    assert!(matches!(error, Error::NonFinite { what: "eigenvalues", index: (1, 0) }), "{error}");
    let error = refused(&[1.0, 2.0], two(), Mass::Lumped(vec![1.0]));
    assert!(matches!(error, Error::Shape { what: "mass", .. }), "{error}");
    let mut nan = two();
    nan[(1, 0)] = f64::NAN;
    let error = refused(&[1.0, 2.0], nan, mass());
    assert!(matches!(error, Error::NonFinite { what: "functions", index: (1, 0) }), "{error}");

    let twice = Mat::from_fn(2, 2, |i, _| i as f64);
    let error = Basis::independent(twice, mass(), Par::Seq).unwrap_err();
    assert!(error.to_string().contains("function 1"), "{error}");
    let basis = Basis::orthonormal(two(), Mass::Lumped(vec![1.0; 2])).unwrap();
    let three = Mat::<f64>::ones(3, 1);
    assert!(matches!(basis.analysis(three.as_ref(), Par::Seq), Err(Error::Shape { .. })));
    assert!(matches!(basis.synthesis(three.as_ref(), Par::Seq), Err(Error::Shape { .. })));
}

#[test]
fn errors_are_relative_to_the_function() {
    let f = Mat::from_fn(2, 3, |i, j| if j == 0 { 1.0 + i as f64 } else { 0.0 });
    let mut g = f.clone();
    g[(1, 0)] = 0.0;
    g[(0, 1)] = 1.0;
    let errors = relative_errors(f.as_ref(), g.as_ref(), &Mass::Lumped(vec![1.0, 2.0])).unwrap();
    assert!((errors[0] - (8.0f64 / 9.0).sqrt()).abs() < 1e-15);
    assert_eq!(errors[1..], [f64::INFINITY, 0.0]);
}
