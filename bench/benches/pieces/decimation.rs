//! Decimation: farthest points.

use catamaran::base::Progress;
use catamaran_geometry::decimate::FarthestPoints;
use catamaran_geometry::mesh::families;
use criterion::{BenchmarkId, Criterion};

pub fn all(criterion: &mut Criterion) {
    const SIDE: usize = 200;
    let mesh = families::terrain(SIDE, SIDE, 1).expect("valid sizes");
    let mut group = criterion.benchmark_group("farthest points");
    for samples in [100, 1000] {
        group.bench_function(BenchmarkId::new("terrain", samples), |b| {
            b.iter(|| {
                let mut points = FarthestPoints::new(&mesh, Some(0)).expect("a mesh");
                points.extend_to(samples, Progress::none()).expect("enough vertices");
                points
            });
        });
    }
}
