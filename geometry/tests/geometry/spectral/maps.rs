//! Functional maps: from functions and landmarks, from points, refined.

use std::ops::ControlFlow;

use catamaran::base::Progress;
use catamaran::faer::{Mat, MatRef};
use catamaran::{Error, Par};
use catamaran_geometry::decimate::{DecimateOptions, decimate};
use catamaran_geometry::mesh::{TriMesh, families};
use catamaran_geometry::spectral::functional_map::{
    FoundMap, MapFit, icp, map_from_points, points_from_map, pull_back, search_map, zoomout,
};
use catamaran_geometry::spectral::{
    Eigenbasis, Lift, Orthogonalization, ProductBasis, ProductBasisOptions, Transfer,
};

use crate::common::{bits, gaussian};
use crate::surface::{THREADS, blob, coordinates, eigenbasis, shuffled};

/// Two eigenbases of the same surface, in another order of vertices and another size, and the true
/// points.
fn pair(len: usize) -> (Eigenbasis, Eigenbasis, Vec<u32>) {
    let mesh = blob(3);
    let (other, points) = shuffled(&mesh, 2.5);
    (eigenbasis(&mesh, len), eigenbasis(&other, len), points)
}

const LANDMARKS: [u32; 5] = [3, 50, 121, 300, 511];

fn landmarks(points: &[u32]) -> Vec<(u32, u32)> {
    let target = |x: u32| points.iter().position(|&p| p == x).unwrap() as u32;
    LANDMARKS.iter().map(|&x| (x, target(x))).collect()
}

fn distance(a: MatRef<'_, f64>, b: MatRef<'_, f64>) -> f64 {
    (a - b).norm_max()
}

#[test]
fn the_map_of_a_mesh_to_itself_is_the_identity() {
    let eigen = eigenbasis(&blob(2), 12);
    let mut fit = MapFit::new(&eigen, &eigen, Par::Seq);
    let f = eigen.functions() * gaussian::<f64>(12, 20, 2);
    fit.functions(f.as_ref(), f.as_ref()).unwrap();
    for weight in [0.0, 1e-3, 1.0] {
        let c = fit.solve(weight).unwrap();
        assert!(distance(c.as_ref(), Mat::identity(12, 12).as_ref()) < 1e-7, "{weight}");
    }
    let points: Vec<u32> = (0..eigen.basis().vertices() as u32).collect();
    let c = map_from_points(&points, eigen.basis(), eigen.basis(), Par::Seq).unwrap();
    assert!(distance(c.as_ref(), Mat::identity(12, 12).as_ref()) < 1e-12);
    assert_eq!(
        points_from_map(c.as_ref(), eigen.basis(), eigen.basis(), Par::Seq, Progress::none()),
        Ok(points)
    );
}

#[test]
fn functions_determine_the_map_of_a_shuffled_mesh_and_the_map_the_points() {
    let (source, target, points) = pair(15);
    let exact = map_from_points(&points, source.basis(), target.basis(), Par::Seq).unwrap();
    let f = source.functions() * gaussian::<f64>(15, 30, 2);
    let g = pull_back(&points, f.as_ref()).unwrap();
    let mut fit = MapFit::new(&source, &target, Par::Seq);
    fit.functions(f.as_ref(), g.as_ref()).unwrap();
    let c = fit.solve(MapFit::COMMUTATIVITY).unwrap();
    assert!(distance(c.as_ref(), exact.as_ref()) < 1e-6 * exact.norm_max());
    // An isometry up to size: the map is diagonal, signs times the ratio of lengths, and so
    // commutes with Laplacians.
    for i in 0..15 {
        for j in 0..15 {
            let expected = if i == j { 2.5 } else { 0.0 };
            assert!((c[(i, j)].abs() - expected).abs() < 1e-5);
        }
    }
    let found =
        points_from_map(c.as_ref(), source.basis(), target.basis(), Par::Seq, Progress::none());
    assert_eq!(found.unwrap(), points);
}

#[test]
fn multiplications_by_few_functions_determine_a_map_that_their_coefficients_do_not() {
    let (source, target, points) = pair(18);
    let exact = map_from_points(&points, source.basis(), target.basis(), Par::Seq).unwrap();
    let f = source.functions() * gaussian::<f64>(18, 3, 2);
    let g = pull_back(&points, f.as_ref()).unwrap();
    let fit = |weight: Option<f64>, par: Par| {
        let mut fit = MapFit::new(&source, &target, par);
        fit.functions(f.as_ref(), g.as_ref()).unwrap();
        if let Some(weight) = weight {
            fit.operators(f.as_ref(), g.as_ref(), weight).unwrap();
        }
        fit.solve(0.0).unwrap()
    };
    let gap = |c: &Mat<f64>| distance(c.as_ref(), exact.as_ref()) / exact.norm_max();
    assert!(gap(&fit(None, Par::Seq)) > 0.1);
    let c = fit(Some(MapFit::MULTIPLICATIONS), Par::Seq);
    assert!(gap(&c) < 1e-5, "{}", gap(&c));
    assert_eq!(fit(Some(MapFit::MULTIPLICATIONS), Par::Threads(3)), c);
    let told = std::sync::Mutex::new(vec![]);
    let tell = |fraction: f64| {
        told.lock().unwrap().push(fraction);
        ControlFlow::Continue(())
    };
    let mut watched = MapFit::new(&source, &target, Par::Seq).progress(&tell);
    watched.operators(f.as_ref(), g.as_ref(), 0.1).unwrap();
    watched.functions(f.as_ref(), g.as_ref()).unwrap();
    watched.solve(0.0).unwrap();
    let told = told.lock().unwrap().clone();
    assert!(told.len() > 5 && told.is_sorted() && told.last() == Some(&1.0), "{told:?}");
    let stop = |_| ControlFlow::Break(());
    assert_eq!(watched.progress(&stop).solve(0.0), Err(Error::Cancelled));
    let mut refused = MapFit::new(&source, &target, Par::Seq);
    let wrong = refused.operators(f.as_ref(), g.as_ref(), f64::NAN).unwrap_err();
    assert!(wrong.to_string().starts_with("weight: "));
    let short = f.as_ref().subrows(0, 5);
    assert!(matches!(
        refused.operators(short, g.as_ref(), 1.0),
        Err(Error::Shape { what: "source functions", .. })
    ));
}

#[test]
fn landmarks_and_zoomout_recover_the_permutation_exactly() {
    let (source, target, points) = pair(40);
    let (low, other) = (source.truncated(8).unwrap(), target.truncated(8).unwrap());
    let mut fit = MapFit::new(&low, &other, Par::Seq);
    fit.landmarks(&landmarks(&points)).unwrap();
    let c = fit.solve(MapFit::COMMUTATIVITY).unwrap();
    for step in [1, 5] {
        let refined =
            zoomout(c.as_ref(), source.basis(), target.basis(), step, Par::all(), Progress::none())
                .unwrap();
        assert_eq!(refined.points, points);
        assert_eq!(refined.map.shape(), (40, 40));
        let exact = map_from_points(&points, source.basis(), target.basis(), Par::Seq).unwrap();
        assert!(distance(refined.map.as_ref(), exact.as_ref()) < 1e-9);
    }
    let refined =
        icp(c.as_ref(), low.basis(), other.basis(), 30, Par::all(), Progress::none()).unwrap();
    let scaled = refined.map.transpose() * &refined.map;
    let identity = Mat::from_fn(8, 8, |i, j| if i == j { 6.25 } else { 0.0 });
    assert!(distance(scaled.as_ref(), identity.as_ref()) < 1e-9);
    let right = refined.points.iter().zip(&points).filter(|(a, b)| a == b).count();
    assert!(right * 10 > points.len() * 9, "{right} of {}", points.len());
}

#[test]
fn zoomout_goes_on_in_products_from_few_eigenfunctions() {
    let (source, target, points) = pair(8);
    let mut fit = MapFit::new(&source, &target, Par::Seq);
    fit.landmarks(&landmarks(&points)).unwrap();
    let c = fit.solve(MapFit::COMMUTATIVITY).unwrap();
    let products = |basis: &Eigenbasis, orthogonalization| {
        let options = ProductBasisOptions::new().orthogonalization(orthogonalization);
        ProductBasis::new(basis, 2, &options).unwrap().into_basis()
    };
    let [from, to] = [&source, &target].map(|b| products(b, Orthogonalization::Reorthogonalized));
    assert_eq!((from.len(), to.len()), (36, 36));
    // The first products are the eigenfunctions, and C is a map between them.
    assert!(distance(from.functions().subcols(0, 8), source.functions()) < 1e-9);
    let refined = zoomout(c.as_ref(), &from, &to, 7, Par::Seq, Progress::none()).unwrap();
    assert_eq!(refined.points, points);
    let exact = map_from_points(&points, &from, &to, Par::Seq).unwrap();
    assert!(distance(refined.map.as_ref(), exact.as_ref()) < 1e-9);
    // Products of one pass are not orthonormal, and their coefficients are no inner products.
    let rough = products(&target, Orthogonalization::SinglePass);
    for (source, target, culprit) in [(&from, &rough, "target"), (&rough, &to, "source")] {
        let refused = zoomout(c.as_ref(), source, target, 7, Par::Seq, Progress::none());
        assert!(matches!(refused, Err(Error::Argument { what, .. }) if what == culprit));
        let square = Mat::<f64>::identity(target.len(), source.len());
        let refused = icp(square.as_ref(), source, target, 7, Par::Seq, Progress::none());
        assert!(matches!(refused, Err(Error::Argument { what, .. }) if what == culprit));
    }
}

#[test]
fn segments_determine_a_map() {
    let (source, target, points) = pair(6);
    // Cells of the nearest of some vertices, by a function that both meshes know.
    let labels: Vec<u32> = (0..points.len())
        .map(|x| (0..3).map(|i| u32::from(source.functions()[(x, i + 1)] > 0.0) << i).sum())
        .collect();
    let moved: Vec<u32> = points.iter().map(|&x| labels[x as usize]).collect();
    let mut fit = MapFit::new(&source, &target, Par::Seq);
    fit.segments(&labels, &moved).unwrap();
    let c = fit.solve(MapFit::COMMUTATIVITY).unwrap();
    let exact = map_from_points(&points, source.basis(), target.basis(), Par::Seq).unwrap();
    assert!(distance(c.as_ref(), exact.as_ref()) < 1e-5);
}

#[test]
fn bases_of_different_sizes_map_to_each_other() {
    let (source, target, points) = pair(20);
    let small = target.truncated(13).unwrap();
    let mut fit = MapFit::new(&source, &small, Par::Seq);
    fit.landmarks(&landmarks(&points)).unwrap();
    assert_eq!(fit.solve(1e-2).unwrap().shape(), (13, 20));
    let c = map_from_points(&points, source.basis(), target.basis(), Par::Seq).unwrap();
    let refined =
        zoomout(c.get(..4, ..6), source.basis(), small.basis(), 3, Par::Seq, Progress::none())
            .unwrap();
    assert_eq!(refined.map.shape(), (13, 20));
    let refined =
        icp(c.get(..13, ..), source.basis(), small.basis(), 3, Par::Seq, Progress::none()).unwrap();
    assert_eq!(refined.map.shape(), (13, 20));
}

#[test]
fn threads_do_not_change_a_bit() {
    let (source, target, points) = pair(14);
    let low = (source.truncated(6).unwrap(), target.truncated(6).unwrap());
    let mut all = THREADS.into_iter().map(|par| {
        let mut fit = MapFit::new(&low.0, &low.1, par);
        fit.landmarks(&landmarks(&points)).unwrap();
        let c = fit.solve(MapFit::COMMUTATIVITY).unwrap();
        let zoomed =
            zoomout(c.as_ref(), source.basis(), target.basis(), 2, par, Progress::none()).unwrap();
        let closest =
            icp(c.as_ref(), low.0.basis(), low.1.basis(), 4, par, Progress::none()).unwrap();
        (bits(c.as_ref()), bits(zoomed.map.as_ref()), zoomed.points, bits(closest.map.as_ref()))
    });
    let first = all.next().unwrap();
    assert!(all.all(|other| other == first));
}

#[test]
fn dirty_input_is_refused_by_name_and_refinement_can_be_cancelled() {
    let eigen = eigenbasis(&blob(1), 5);
    let n = eigen.basis().vertices() as u32;
    let mut fit = MapFit::new(&eigen, &eigen, Par::Seq);
    let argument = |error: Error, name: &str| {
        assert!(matches!(error, Error::Argument { what, .. } if what == name), "{error}");
    };
    argument(fit.solve(1.0).unwrap_err(), "functions");
    let zero = Mat::<f64>::zeros(n as usize, 1);
    fit.functions(zero.as_ref(), Mat::ones(n as usize, 1).as_ref()).unwrap();
    argument(fit.solve(1.0).unwrap_err(), "functions");
    argument(fit.landmarks(&[(0, 0), (1, n)]).unwrap_err(), "landmarks");
    let labels = vec![1; n as usize];
    let mut others = labels.clone();
    others[3] = 7;
    let error = fit.segments(&labels, &others).unwrap_err();
    assert!(error.to_string().contains("label 7"), "{error}");
    assert!(matches!(fit.segments(&labels[1..], &others), Err(Error::Shape { .. })));
    fit.landmarks(&[(0, 0)]).unwrap();
    argument(fit.solve(-1.0).unwrap_err(), "commutativity");
    argument(fit.solve(f64::NAN).unwrap_err(), "commutativity");
    // One landmark and no commutativity: the least of many maps, but a finite one.
    assert!(fit.solve(0.0).unwrap().norm_max().is_finite());

    let c = Mat::<f64>::identity(5, 5);
    argument(
        icp(c.as_ref(), eigen.basis(), eigen.basis(), 0, Par::Seq, Progress::none()).unwrap_err(),
        "iterations",
    );
    argument(
        zoomout(c.as_ref(), eigen.basis(), eigen.basis(), 0, Par::Seq, Progress::none())
            .unwrap_err(),
        "step",
    );
    let large = Mat::<f64>::identity(6, 6);
    let error =
        zoomout(large.as_ref(), eigen.basis(), eigen.basis(), 1, Par::Seq, Progress::none())
            .unwrap_err();
    assert!(matches!(error, Error::Shape { what: "functional map", .. }), "{error}");
    let points = vec![n; n as usize];
    let error = map_from_points(&points, eigen.basis(), eigen.basis(), Par::Seq).unwrap_err();
    assert!(error.to_string().contains("target vertex 0"), "{error}");
    let cancel = |_: f64| ControlFlow::Break(());
    let stopped =
        zoomout(c.get(..2, ..2), eigen.basis(), eigen.basis(), 1, Par::Seq, (&cancel).into());
    assert_eq!(stopped.unwrap_err(), Error::Cancelled);
}

/// Returns the same surface seen from inside.
fn inside_out(mesh: &TriMesh) -> TriMesh {
    let faces = mesh.faces().iter().map(|&[a, b, c]| [a, c, b]).collect();
    TriMesh::new(mesh.vertices().to_vec(), faces).unwrap()
}

#[test]
fn a_map_is_found_without_correspondences_also_inside_out() {
    let mesh = blob(3);
    let (other, points) = shuffled(&mesh, 2.5);
    let (source, target) = (eigenbasis(&mesh, 45), eigenbasis(&other, 45));
    let exact = map_from_points(&points, source.basis(), target.basis(), Par::Seq).unwrap();
    let search = |other: &TriMesh, par: Par| {
        search_map((&mesh, &source), (other, &target), par, Progress::none()).unwrap()
    };
    let found = search(&other, Par::Seq);
    assert!(found.orientation > 0.95 && !found.is_ambiguous(), "{}", told(&found));
    assert_eq!(found.map.shape(), (40, 40));
    // Samples of one mesh are not those of the other.
    let first = exact.as_ref().submatrix(0, 0, 10, 10);
    assert!(distance(found.map.as_ref().submatrix(0, 0, 10, 10), first) < 0.2 * 2.5);
    let refined =
        zoomout(found.map.as_ref(), source.basis(), target.basis(), 5, Par::Seq, Progress::none());
    assert_eq!(refined.unwrap().points, points);
    for par in THREADS {
        let again = search(&other, par);
        assert_eq!(bits(again.map.as_ref()), bits(found.map.as_ref()));
    }
    assert_eq!(search(&inside_out(&other), Par::Seq).map, found.map);
    let low = (source.truncated(8).unwrap(), target.truncated(12).unwrap());
    let bases = (low.0.basis(), low.1.basis());
    let c = found.between(bases, (&source, &target), Par::Seq, Progress::none()).unwrap();
    let expected = map_from_points(&points, bases.0, bases.1, Par::Seq).unwrap();
    assert!(distance(c.as_ref(), expected.as_ref()) < 0.1 * 2.5);
}

#[test]
fn a_mirrored_mesh_has_no_good_map_and_a_symmetric_one_has_two() {
    let mesh = blob(3);
    let reflected = mesh.vertices().iter().map(|&[x, y, z]| [-x, y, z]).collect();
    let mirrored = inside_out(&TriMesh::new(reflected, mesh.faces().to_vec()).unwrap());
    let (source, target) = (eigenbasis(&mesh, 40), eigenbasis(&mirrored, 40));
    let search = |a: (&TriMesh, &Eigenbasis), b: (&TriMesh, &Eigenbasis)| {
        search_map(a, b, Par::Seq, Progress::none()).unwrap()
    };
    // The exact map turns the surface over, and any that does not is worse by far.
    let itself = search((&mesh, &source), (&mesh, &source));
    let found = search((&mesh, &source), (&mirrored, &target));
    assert!(itself.commutativity < 1e-3, "{}", told(&itself));
    assert!(found.mirrored.is_some_and(|exact| exact < 1e-3), "{}", told(&found));
    let doubt = found.doubt().unwrap();
    assert_eq!(doubt, "a map that exchanges left and right fits better", "{}", told(&found));
    // Every turn about its axis takes a torus to itself.
    let torus = families::torus(30, 15, 2.0, 0.8).unwrap();
    let basis = eigenbasis(&torus, 40);
    let found = search((&torus, &basis), (&torus, &basis));
    assert_eq!(found.doubt(), Some("another map fits almost as well"), "{}", told(&found));
    // A half turn takes the figure to itself, and keeps the orientation.
    let figure = families::figure(3, 0.0).unwrap();
    let basis = eigenbasis(&figure, 40);
    let found = search((&figure, &basis), (&figure, &basis));
    assert!(found.orientation > 0.9, "{}", told(&found));
    let close = |next: f64| next < 3.0 * found.commutativity + 0.02;
    assert!(found.next.is_some_and(close), "{}", told(&found));
}

/// Says what a search found, without the map.
fn told(found: &FoundMap) -> String {
    let FoundMap { commutativity, orientation, next, mirrored, .. } = found;
    format!(
        "commutativity {commutativity}, orientation {orientation}, next {next:?}, mirrored \
         {mirrored:?}"
    )
}

#[test]
fn a_search_refuses_too_few_functions_and_other_meshes() {
    let mesh = blob(2);
    let (few, basis) = (eigenbasis(&mesh, 2), eigenbasis(&mesh, 12));
    let search = |mesh: &TriMesh, basis: &Eigenbasis| {
        search_map((mesh, basis), (mesh, basis), Par::Seq, Progress::none())
    };
    assert!(matches!(search(&mesh, &few), Err(Error::Argument { what: "eigenbasis", .. })));
    assert!(matches!(search(&blob(1), &basis), Err(Error::Shape { what: "source", .. })));
    let stop = |_| ControlFlow::Break(());
    let stopped = search_map((&mesh, &basis), (&mesh, &basis), Par::Seq, (&stop).into());
    assert_eq!(stopped.unwrap_err(), Error::Cancelled);
}

#[test]
fn more_signatures_than_functions_determine_a_map_of_any_size() {
    let (source, target, points) = pair(40);
    let low = (source.truncated(12).unwrap(), target.truncated(12).unwrap());
    let exact = map_from_points(&points, low.0.basis(), low.1.basis(), Par::Seq).unwrap();
    let mut fit = MapFit::new(&low.0, &low.1, Par::Seq);
    fit.signatures(&source, &target).unwrap();
    let c = fit.solve(MapFit::COMMUTATIVITY).unwrap();
    assert!(distance(c.as_ref(), exact.as_ref()) < 1e-2 * exact.norm_max());
    fit.kernels(&landmarks(&points), &source, &target).unwrap();
    let c = fit.solve(MapFit::COMMUTATIVITY).unwrap();
    assert!(distance(c.as_ref(), exact.as_ref()) < 1e-3 * exact.norm_max());
    let other = eigenbasis(&blob(2), 12);
    assert!(matches!(fit.signatures(&other, &target), Err(Error::Shape { what: "source", .. })));
}

/// Returns functions transferred along points through the products of 8 eigenfunctions.
fn transferred(
    (source, target): (&Eigenbasis, &Eigenbasis),
    points: &[u32],
    f: MatRef<'_, f64>,
) -> Mat<f64> {
    let products = |basis: &Eigenbasis| {
        ProductBasis::new(&basis.truncated(9).unwrap(), 2, &ProductBasisOptions::new()).unwrap()
    };
    let (from, to) = (products(source), products(target));
    let map = map_from_points(points, from.basis(), to.basis(), Par::Seq).unwrap();
    Transfer::new(from.basis(), to.basis(), map).unwrap().apply(f, Par::Seq).unwrap()
}

#[test]
fn a_map_between_decimations_is_lifted_to_the_meshes() {
    let mesh = blob(4);
    let (other, truth) = shuffled(&mesh, 2.5);
    let f = coordinates(&mesh);
    let expected = pull_back(&truth, f.as_ref()).unwrap();
    let error = |g: &Mat<f64>| (g - &expected).norm_l2() / expected.norm_l2();
    let (source, target) = (eigenbasis(&mesh, 9), eigenbasis(&other, 9));
    let full = error(&transferred((&source, &target), &truth, f.as_ref()));

    let coarse = |mesh: &TriMesh| {
        let found = decimate(mesh, 800, &DecimateOptions::new().par(Par::Seq)).unwrap();
        let lift = Lift::new(mesh, &found, Par::Seq).unwrap();
        let basis = eigenbasis(&found.mesh, 60);
        (found.mesh, basis, lift)
    };
    let (from, to) = (coarse(&mesh), coarse(&other));
    let place = |x: u32| truth.iter().position(|&p| p == x).unwrap();
    let near = |x: u32| (from.2.nearest()[x as usize], to.2.nearest()[place(x)]);
    let known = [3, 50, 121, 300, 511, 1000, 1700, 2400].map(near);
    let low = (from.1.truncated(31).unwrap(), to.1.truncated(31).unwrap());
    let mut fit = MapFit::new(&low.0, &low.1, Par::Seq);
    fit.landmarks(&known).unwrap();
    fit.signatures(&from.1, &to.1).unwrap();
    let c = fit.solve(MapFit::COMMUTATIVITY).unwrap();
    let (c, bases) = (c.as_ref(), (from.1.basis(), to.1.basis()));
    let points = zoomout(c, bases.0, bases.1, 1, Par::Seq, Progress::none()).unwrap().points;
    let f_coarse = from.2.restrict(f.as_ref()).unwrap();
    let g = transferred((&from.1, &to.1), &points, f_coarse.as_ref());
    let lifted = error(&to.2.prolong(g.as_ref()).unwrap());
    // The error of the products alone, and that of faces of a third of the vertices with it.
    assert!(full > 0.01 && full < 0.02 && lifted < 0.04, "{lifted} after {full}");

    // Vertices of the mesh have points of the decimation, less than an edge away.
    let corners = from.2.corners();
    let found = to.2.nearest().iter().map(|&y| corners[points[y as usize] as usize]);
    let apart = found.zip(&truth).map(|(x, &y)| {
        let (p, q) = (mesh.vertices()[x as usize], mesh.vertices()[y as usize]);
        (0..3).map(|i| (p[i] - q[i]).powi(2)).sum::<f64>().sqrt()
    });
    let mean = apart.sum::<f64>() / truth.len() as f64;
    let edge = (2.3 * from.0.area() / from.0.faces().len() as f64).sqrt();
    assert!(mean < edge, "{mean} of edges of {edge}");
}

#[test]
fn functions_are_linear_between_a_mesh_and_its_decimation() {
    let mesh = families::grid(12, 12).unwrap();
    let found = decimate(&mesh, 60, &DecimateOptions::new().par(Par::Seq)).unwrap();
    let lift = Lift::new(&mesh, &found, Par::Seq).unwrap();
    // On a flat mesh, linear functions are kept exactly.
    let f = coordinates(&mesh);
    let coarse = lift.restrict(f.as_ref()).unwrap();
    assert!(distance(coarse.as_ref(), coordinates(&found.mesh).as_ref()) < 1e-9);
    let fine = lift.prolong(coarse.as_ref()).unwrap();
    let inside = |p: &[f64; 3]| (0..2).all(|i| p[i] > 0.2 && p[i] < 0.8);
    let extent = mesh.vertices().iter().flatten().copied().fold(0.0, f64::max);
    for (v, p) in mesh.vertices().iter().enumerate() {
        let scaled = p.map(|x| x / extent);
        if inside(&scaled) {
            assert!((0..3).all(|j| (fine[(v, j)] - f[(v, j)]).abs() < 1e-9), "{v}");
        }
    }
    let short = f.as_ref().subrows(0, 9);
    assert!(matches!(lift.restrict(short), Err(Error::Shape { what: "functions", .. })));
    assert!(matches!(lift.prolong(short), Err(Error::Shape { what: "functions", .. })));
    let other = families::grid(5, 5).unwrap();
    assert!(matches!(Lift::new(&other, &found, Par::Seq), Err(Error::Shape { .. })));
}
