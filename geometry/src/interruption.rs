//! Calls that take long ask whether to go on, at least every 10^8 operations: counted, not timed.

use std::ops::ControlFlow;
use std::sync::atomic::{AtomicUsize, Ordering};

use faer::Mat;

use crate::decimate::{DecimateOptions, FarthestPoints, decimate};
use crate::mesh::{
    Dijkstra, Geodesics, Graph, HeatMethod, HeatOptions, LaplacianKind, LaplacianOptions,
    SearchLimits, Site, TriMesh, families, laplacian,
};
use crate::unions::{ShapeDnaOptions, shape_dna};
use catamaran::base::{Error, Par, Progress, Result, Rng, measure};
use catamaran::ortho::{GramSchmidtOptions, cholesky_qr, gram_schmidt};
use catamaran::product::{AtaOptions, SchemeChoice, ata_into};
use catamaran::solve::{LeastSquaresOptions, lstsq, singular_values};
use catamaran::sparse::{
    Cholesky, CholeskyOptions, EigenOptions, Mass, count_below, eigs, eigs_sliced,
};

/// Most operations between two requests.
const MOST: f64 = 1e8;

/// Checks work of at least so many operations on one thread: it asks often enough, and ends at the
/// first request to stop.
fn check(name: &str, least: f64, work: impl Fn(Progress<'_>) -> Result<()>) {
    let requests = AtomicUsize::new(0);
    let go_on = |_: f64| {
        requests.fetch_add(1, Ordering::Relaxed);
        ControlFlow::Continue(())
    };
    let (longest, total) = measure::operations(|| {
        let progress = Progress::new(&go_on);
        progress.watch(|| work(progress)).unwrap();
    });
    let requests = requests.into_inner();
    println!("{name}: {total:.1e} operations, {requests} requests, {longest:.1e} at most between");
    assert!(total >= least, "{name}: {total:e} operations of {least:e} are counted");
    assert!(longest <= MOST, "{name}: {longest:e} operations between two requests");
    let stop = |_: f64| ControlFlow::Break(());
    let (_, total) = measure::operations(|| {
        let progress = Progress::new(&stop);
        assert_eq!(progress.watch(|| work(progress)), Err(Error::Cancelled), "{name}");
    });
    assert!(total <= MOST, "{name}: {total:e} operations after a request to stop");
}

fn random(m: usize, n: usize) -> Mat<f64> {
    let mut rng = Rng::new(5);
    Mat::from_fn(m, n, |_, _| rng.normal())
}

fn sphere(subdivisions: u32) -> TriMesh {
    families::icosphere(subdivisions).unwrap()
}

#[test]
fn laplacians_ask() {
    let mesh = sphere(7);
    let faces = mesh.faces().len() as f64;
    for kind in [LaplacianKind::Cotangent, LaplacianKind::IntrinsicDelaunay, LaplacianKind::Tufted]
    {
        let options = LaplacianOptions::new().kind(kind).par(Par::Seq);
        let least = if kind == LaplacianKind::Cotangent { 100.0 } else { 300.0 };
        check(&format!("{kind:?}"), least * faces, |_| laplacian(&mesh, &options).map(drop));
    }
}

#[test]
fn factorizations_and_eigenpairs_ask() {
    let mesh = sphere(5);
    let l = laplacian(&mesh, &LaplacianOptions::new().par(Par::Seq)).unwrap();
    let (w, m) = (l.stiffness.view(), &l.mass);
    let options = EigenOptions::new().k(30).par(Par::Seq);
    check("eigs", 1e9, |progress| eigs(w, m, &options.clone().progress(progress)).map(drop));
    check("eigs, watched only", 1e9, |_| eigs(w, m, &options).map(drop));
    let near = options.clone().shift(20.5).verify_count(true);
    check("eigs near a shift", 1e9, |_| eigs(w, m, &near).map(drop));
    check("eigs in slices", 1e9, |_| eigs_sliced(w, m, &options, 1 << 26, |_| Ok(())));
    check("count_below", 5e7, |_| count_below(w, m, 20.5).map(drop));
    let semidefinite = CholeskyOptions::new().semidefinite(true).par(Par::Seq);
    check("Cholesky::new", 1e7, |progress| {
        Cholesky::new(w, &semidefinite.clone().progress(progress)).map(drop)
    });
    let (cholesky, b) = (Cholesky::new(w, &semidefinite).unwrap(), random(w.rows(), 64));
    check("Cholesky::solve", 2e7, |_| cholesky.solve(b.as_ref()).map(drop));
    let signature = ShapeDnaOptions::new().k(30).laplacian(LaplacianOptions::new().par(Par::Seq));
    check("shape_dna", 1e9, |progress| {
        shape_dna(&mesh, &signature.clone().progress(progress)).map(drop)
    });
}

#[test]
fn small_eigenproblems_are_solved_apart() {
    // Operations of another thread are not counted.
    let n = 500;
    let l = laplacian(&families::grid(24, 19).unwrap(), &LaplacianOptions::new()).unwrap();
    let all = EigenOptions::new().k(n - 100).par(Par::Seq);
    check("eigs of a small matrix", 0.0, |_| eigs(l.stiffness.view(), &l.mass, &all).map(drop));
    // While the other thread works, the callback gets the same fraction again.
    let fractions = std::sync::Mutex::new(Vec::new());
    let note = |fraction: f64| {
        fractions.lock().unwrap().push(fraction);
        ControlFlow::Continue(())
    };
    Progress::new(&note).watch(|| eigs(l.stiffness.view(), &l.mass, &all)).unwrap();
    let fractions = fractions.into_inner().unwrap();
    assert!(fractions.windows(2).any(|pair| pair[0] == pair[1]), "{fractions:?}");
}

#[test]
fn distances_ask() {
    let mesh = sphere(6);
    let heat = HeatMethod::new(&mesh, &HeatOptions::new().par(Par::Seq)).unwrap();
    check("HeatMethod::new", 2e8, |_| {
        HeatMethod::new(&mesh, &HeatOptions::new().par(Par::Seq)).map(drop)
    });
    check("HeatMethod::distances", 1e7, |_| heat.distances(&[7]).map(drop));
    let graph = Graph::of_mesh(&sphere(7));
    let coarse = sphere(5);
    let exact = Geodesics::new(&coarse).unwrap();
    check("Geodesics", 2e7, |_| exact.distances(&[Site::Vertex(7)]).map(drop));
    check("Geodesics::trace", 1e7, |_| {
        exact.trace(Site::Vertex(7), [1.0, 2.0, 3.0], 1e4).map(drop)
    });
    check("Dijkstra", 1e7, |_| Dijkstra::new(&graph).search(&[(7, 0.0)], &SearchLimits::default()));
}

#[test]
fn decimation_asks() {
    let mesh = sphere(5);
    let options = DecimateOptions::new().par(Par::Seq);
    check("decimate", 1e8, |progress| decimate(&mesh, 1500, &options.progress(progress)).map(drop));
    check("farthest points", 5e6, |progress| {
        FarthestPoints::new(&mesh, None)?.extend_to(3000, progress)
    });
}

#[test]
fn least_squares_and_singular_values_ask() {
    let a = random(700, 350);
    let b = random(700, 2);
    let options = LeastSquaresOptions::new().par(Par::Seq);
    check("lstsq", 2e8, |_| lstsq(a.as_ref(), b.as_ref(), None, &options).map(drop));
    check("svd", 2e8, |_| singular_values(a.as_ref(), Par::Seq).map(drop));
}

#[test]
fn orthogonalizations_ask() {
    let a = random(20_000, 150);
    let mass = Mass::identity(20_000);
    check("cholesky_qr", 1e8, |_| cholesky_qr(a.clone().as_mut(), &mass, Par::Seq).map(drop));
    let options = GramSchmidtOptions::reorthogonalized().par(Par::Seq);
    check("gram_schmidt", 1e6, |progress| {
        gram_schmidt(a.as_ref(), &mass, &options.clone().progress(progress)).map(drop)
    });
}

/// The fractions that products of our own kernels tell are shares of their operations: no two that
/// follow each other differ by more than 10^8 operations. Operations are those of the classical
/// product, also for exact products, which take as many for each modulus.
#[test]
fn products_ask() {
    let n = 900;
    let a = random(n, n);
    let operations = (n * n * n) as f64;
    for scheme in [
        SchemeChoice::Float,
        SchemeChoice::Classical,
        SchemeChoice::Exact,
        SchemeChoice::Winograd,
        SchemeChoice::Ata2,
        SchemeChoice::Rxtx,
        SchemeChoice::Kgp3,
        SchemeChoice::Kgp4,
    ] {
        let told = std::sync::Mutex::new(vec![0.0]);
        let note = |fraction: f64| {
            told.lock().unwrap().push(fraction);
            ControlFlow::Continue(())
        };
        let options = AtaOptions::new().scheme(scheme).par(Par::Seq).progress(&note);
        let mut c = Mat::zeros(n, n);
        ata_into(1.0, a.as_ref(), 0.0, c.as_mut(), &options).unwrap();
        let told = told.into_inner().unwrap();
        let widest = told.windows(2).map(|pair| pair[1] - pair[0]).fold(0.0, f64::max);
        println!(
            "{scheme:?}: {} requests, {:.1e} at most between",
            told.len(),
            widest * operations
        );
        assert!(widest * operations <= MOST, "{scheme:?}: {:e}", widest * operations);
    }
}
