//! The matrix O, and transfer through it.

use catamaran::base::Progress;
use catamaran::faer::linalg::solvers::Solve;
use catamaran::faer::{Mat, MatRef};
use catamaran::{Error, Par};
use catamaran_geometry::mesh::TriMesh;
use catamaran_geometry::spectral::functional_map::{map_from_points, points_from_map, pull_back};
use catamaran_geometry::spectral::{
    Eigenbasis, Orthogonalization, ProductBasis, ProductMap, Transfer, TruncatedProducts,
    relative_errors, split, transfer_details, transform_by_columns, transform_of_all_products,
};

use super::basis::products;
use crate::common::{bits, gaussian};
use crate::surface::{THREADS, blob, coordinates, eigenbasis, shuffled};

const OURS: Orthogonalization = Orthogonalization::SinglePass;
const OURS_STAR: Orthogonalization = Orthogonalization::Reorthogonalized;

struct Pair {
    source: Eigenbasis,
    target: Eigenbasis,
    points: Vec<u32>,
    c: Mat<f64>,
}

fn pair(len: usize) -> Pair {
    let mesh = blob(2);
    let (other, points) = shuffled(&mesh, 0.5);
    let (source, target) = (eigenbasis(&mesh, len), eigenbasis(&other, len));
    let c = map_from_points(&points, source.basis(), target.basis(), Par::Seq).unwrap();
    Pair { source, target, points, c }
}

fn bases(pair: &Pair, order: usize, mode: Orthogonalization) -> (ProductBasis, ProductBasis) {
    (products(&pair.source, order, mode), products(&pair.target, order, mode))
}

fn distance(a: MatRef<'_, f64>, b: MatRef<'_, f64>) -> f64 {
    (a - b).norm_max()
}

#[test]
fn on_an_isometric_pair_all_three_ways_are_the_pull_back() {
    for (len, order) in [(2, 3), (5, 1), (5, 2), (4, 3)] {
        let pair = pair(len);
        for mode in [OURS, OURS_STAR] {
            let (source, target) = bases(&pair, order, mode);
            let map = ProductMap::new(pair.c.as_ref(), &pair.source, &pair.target, order).unwrap();
            let points =
                map_from_points(&pair.points, source.basis(), target.basis(), Par::Seq).unwrap();
            let pulled = pull_back(&pair.points, source.functions()).unwrap();
            let image = target.functions() * &points;
            assert!(distance(image.as_ref(), pulled.as_ref()) < 1e-8 * pulled.norm_max());
            let columns = transform_by_columns(&map, &source, &target, Par::Seq).unwrap();
            let scale = points.norm_max();
            assert!(distance(columns.as_ref(), points.as_ref()) < 1e-6 * scale, "{len} {order}");
            // The kept products alone span the space; with a threshold of 1e-2 the others are not
            // exactly in it.
            if mode == OURS_STAR {
                let all = transform_of_all_products(&map, &source, &target, Par::Seq).unwrap();
                assert!(distance(all.as_ref(), points.as_ref()) < 1e-6 * scale, "{len} {order}");
            }
        }
    }
}

#[test]
fn the_formulas_are_those_of_the_thesis_for_any_map() {
    let pair = pair(3);
    let (source, target) = bases(&pair, 2, OURS_STAR);
    assert_eq!((source.len(), target.len()), (6, 6));
    let mut c = &pair.c + gaussian::<f64>(3, 3, 5);
    c[(0, 0)] = pair.source.constant().unwrap() / pair.target.constant().unwrap();
    c[(1, 0)] = 0.0;
    c[(2, 0)] = 0.0;
    let map = ProductMap::new(c.as_ref(), &pair.source, &pair.target, 2).unwrap();
    // C~ from the explicit Kronecker product: rows and columns 1, phi_1, phi_2, of functions
    // divided by the constant.
    let scale = pair.target.constant().unwrap() / pair.source.constant().unwrap();
    let c = Mat::from_fn(3, 3, |i, j| scale * c[(i, j)]);
    let tuples = [[0, 0], [0, 1], [0, 2], [1, 1], [1, 2], [2, 2]];
    let extended = Mat::from_fn(6, 6, |row, column| {
        let ([h, p], [i, j]) = (tuples[row], tuples[column]);
        let one_way = c[(h, i)] * c[(p, j)];
        if h == p { one_way } else { one_way + c[(p, i)] * c[(h, j)] }
    });
    let columns = map.columns(&[0, 1, 2, 3, 4, 5], Par::Seq).unwrap();
    assert!(distance(columns.as_ref(), extended.as_ref()) < 1e-14 * extended.norm_max());

    let (rs, rt) = (source.r(), target.r());
    let normal = rs * rs.transpose();
    let right = rt * &extended * rs.transpose();
    let by_1_16 = normal.partial_piv_lu().solve(right.transpose()).transpose().to_owned();
    let found = transform_of_all_products(&map, &source, &target, Par::Seq).unwrap();
    assert!(distance(found.as_ref(), by_1_16.as_ref()) < 1e-8 * by_1_16.norm_max());

    let mut by_1_18 = Mat::<f64>::zeros(6, 6);
    for i in 0..6 {
        for j in 0..6 {
            let image: f64 = (0..6).map(|l| rt[(j, l)] * extended[(l, i)]).sum();
            let before: f64 = (0..i).map(|h| rs[(h, i)] * by_1_18[(j, h)]).sum();
            by_1_18[(j, i)] = (image - before) / rs[(i, i)];
        }
    }
    let found = transform_by_columns(&map, &source, &target, Par::Seq).unwrap();
    assert!(distance(found.as_ref(), by_1_18.as_ref()) < 1e-11 * by_1_18.norm_max());
    // As many products as dimensions: the two are the same.
    assert!(distance(by_1_16.as_ref(), by_1_18.as_ref()) < 1e-8 * by_1_16.norm_max());
}

#[test]
fn products_carry_functions_that_the_eigenfunctions_can_not() {
    let pair = pair(6);
    let f = coordinates(&blob(2));
    let truth = pull_back(&pair.points, f.as_ref()).unwrap();
    let mass = pair.target.basis().mass();
    let errors = |g: Mat<f64>| relative_errors(truth.as_ref(), g.as_ref(), mass).unwrap();
    let eigen = Transfer::new(pair.source.basis(), pair.target.basis(), pair.c.clone()).unwrap();
    let k = errors(eigen.apply(f.as_ref(), Par::Seq).unwrap());
    // The points come from the functional map, as in section 1.3.4.
    let (s, t) = (pair.source.basis(), pair.target.basis());
    let points = points_from_map(pair.c.as_ref(), s, t, Par::Seq, Progress::none()).unwrap();
    assert_eq!(points, pair.points);
    for mode in [OURS, OURS_STAR] {
        let (source, target) = bases(&pair, 3, mode);
        let o = map_from_points(&points, source.basis(), target.basis(), Par::Seq).unwrap();
        let transfer = Transfer::new(source.basis(), target.basis(), o).unwrap();
        let ours = errors(transfer.apply(f.as_ref(), Par::Seq).unwrap());
        assert!(ours.iter().zip(&k).all(|(a, b)| *a < 0.6 * b), "{ours:?} {k:?}");
    }
    // The baseline: coefficients of products, by C~.
    let (source, target) = bases(&pair, 3, OURS_STAR);
    let map = ProductMap::new(pair.c.as_ref(), &pair.source, &pair.target, 3).unwrap();
    let from = TruncatedProducts::new(&source, 4e-3).unwrap();
    let to = TruncatedProducts::new(&target, 0.0).unwrap();
    let a = map.apply(from.analysis(f.as_ref(), Par::Seq).unwrap().as_ref(), Par::Seq).unwrap();
    let prods = errors(to.synthesis(a.as_ref(), Par::Seq).unwrap());
    assert!(prods.iter().zip(&k).all(|(a, b)| a < b), "{prods:?} {k:?}");
}

#[test]
fn transfer_is_exact_within_the_span() {
    let pair = pair(4);
    let (source, target) = bases(&pair, 2, OURS);
    let o = map_from_points(&pair.points, source.basis(), target.basis(), Par::Seq).unwrap();
    let transfer = Transfer::new(source.basis(), target.basis(), o).unwrap();
    let f = source.functions() * gaussian::<f64>(source.len(), 3, 8);
    let g = transfer.apply(f.as_ref(), Par::Seq).unwrap();
    let truth = pull_back(&pair.points, f.as_ref()).unwrap();
    assert!(distance(g.as_ref(), truth.as_ref()) < 1e-9 * truth.norm_max());
}

#[test]
fn threads_do_not_change_a_bit() {
    let pair = pair(5);
    let (source, target) = bases(&pair, 3, OURS);
    let map = ProductMap::new(pair.c.as_ref(), &pair.source, &pair.target, 3).unwrap();
    let mut all = THREADS.into_iter().map(|par| {
        let points = map_from_points(&pair.points, source.basis(), target.basis(), par).unwrap();
        let columns = transform_by_columns(&map, &source, &target, par).unwrap();
        let all = transform_of_all_products(&map, &source, &target, par).unwrap();
        [points, columns, all].map(|o| bits(o.as_ref()))
    });
    let first = all.next().unwrap();
    assert!(all.all(|other| other == first));
}

#[test]
fn maps_of_other_products_are_refused() {
    let pair = pair(4);
    let (source, target) = bases(&pair, 2, OURS);
    let map = ProductMap::new(pair.c.as_ref(), &pair.source, &pair.target, 3).unwrap();
    for transform in [transform_by_columns, transform_of_all_products] {
        let error = transform(&map, &source, &target, Par::Seq).unwrap_err();
        assert!(matches!(error, Error::Argument { what: "map", .. }), "{error}");
    }
    let wrong = pair.c.get(..3, ..);
    let error = ProductMap::new(wrong, &pair.source, &pair.target, 2).unwrap_err();
    assert!(matches!(error, Error::Shape { what: "functional map", .. }), "{error}");
    let wrong = Transfer::new(source.basis(), target.basis(), Mat::zeros(2, 2));
    assert!(matches!(wrong.unwrap_err(), Error::Shape { what: "map", .. }));
}

#[test]
fn details_come_back_on_a_smooth_copy_of_the_mesh() {
    let mesh = blob(2);
    let eigen = eigenbasis(&mesh, 60);
    let smooth = eigen.truncated(5).unwrap();
    let parts = split(smooth.basis(), coordinates(&mesh).as_ref(), Par::Seq).unwrap();
    assert!((&parts.low + &parts.high - coordinates(&mesh)).norm_max() < 1e-14);
    let low = (0..mesh.vertices().len()).map(|i| [0, 1, 2].map(|c| parts.low[(i, c)])).collect();
    let low = TriMesh::new(low, mesh.faces().to_vec()).unwrap();
    let identity = Mat::identity(60, 60);
    let transfer = Transfer::new(eigen.basis(), eigen.basis(), identity).unwrap();
    let bases = (smooth.basis(), smooth.basis());
    let result = transfer_details(&mesh, &low, bases, &transfer, Par::Seq).unwrap();
    let mass = eigen.basis().mass();
    let error = |mesh: &TriMesh, other: &TriMesh| {
        relative_errors(coordinates(mesh).as_ref(), coordinates(other).as_ref(), mass).unwrap()
    };
    // Along the normal most of what the low part lacks.
    let (before, after) = (error(&mesh, &low), error(&mesh, &result));
    assert!((0..3).all(|c| after[c] < 0.75 * before[c]), "{before:?} {after:?}");
    // Of its own detail, a mesh without heights keeps what lies along its smooth part, and nothing
    // else.
    let nothing = Transfer::new(eigen.basis(), eigen.basis(), Mat::zeros(60, 60)).unwrap();
    let flat = transfer_details(&mesh, &mesh, bases, &nothing, Par::Seq).unwrap();
    for (v, normal) in low.vertex_normals().iter().enumerate() {
        let at = |mesh: &TriMesh, c: usize| mesh.vertices()[v][c];
        let height = |mesh: &TriMesh| -> f64 {
            (0..3).map(|c| normal[c] * (at(mesh, c) - at(&low, c))).sum()
        };
        assert!(height(&flat).abs() < 1e-12);
        for c in 0..3 {
            let lost = at(&mesh, c) - at(&flat, c);
            assert!((lost - height(&mesh) * normal[c]).abs() < 1e-12);
        }
    }
    // A target of another mesh than its basis is refused.
    let other = blob(1);
    let refused = transfer_details(&mesh, &other, bases, &transfer, Par::Seq).unwrap_err();
    assert!(matches!(refused, Error::Shape { .. }), "{refused}");
}
