//! Curves: the search for a curve through samples without an order.

use catamaran::base::Rng;
use catamaran_geometry::curve::dataset::{Generator, Sampling, samples};
use catamaran_geometry::curve::{CurveOptions, CurveSolver, Mode};
use catamaran_geometry::mesh::{Graph, families};
use criterion::{BenchmarkId, Criterion};

pub fn all(criterion: &mut Criterion) {
    let mesh = families::icosphere(5).expect("a small sphere");
    let graph = Graph::of_mesh(&mesh);
    let mut generator = Generator::new(&graph, 1).expect("a small graph");
    let curve = generator.curve().expect("a small graph").expect("a curve on a sphere");
    let mut solver = CurveSolver::new(&mesh).expect("a small mesh");
    let mut group = criterion.benchmark_group("curve search");
    for count in [25, 100] {
        let given = samples(&curve, count, Sampling::Even, &mut Rng::new(2)).vertices;
        for (name, options) in [
            ("robust", CurveOptions::new()),
            ("faithful", CurveOptions::new().mode(Mode::Faithful).candidates(3)),
        ] {
            group.bench_function(BenchmarkId::new(name, count), |b| {
                b.iter(|| solver.reconstruct(&given, &options).expect("samples of the mesh"));
            });
        }
    }
}
