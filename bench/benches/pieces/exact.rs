//! The exact path: products that conversion to residues and recombination dominate.

use catamaran::faer::{Mat, MatRef};
use catamaran::{AtaOptions, Par, SchemeChoice, ata_into};
use catamaran_bench::input::{Distribution, Shape, matrix};
use criterion::{BenchmarkId, Criterion, Throughput};

pub fn all(criterion: &mut Criterion) {
    piece(criterion, "residues", Shape { m: 65_536, n: 64 }, |shape| shape.m * shape.n);
    let triangle = |shape: Shape| shape.n * (shape.n + 1) / 2;
    piece(criterion, "recombination", Shape { m: 64, n: 1024 }, triangle);
}

/// Seconds of A^T A on the instruction set that `CATAMARAN_ISA` allows; throughput in `entries`.
fn piece(criterion: &mut Criterion, name: &str, shape: Shape, entries: impl Fn(Shape) -> usize) {
    let Shape { m, n } = shape;
    let a = matrix::<f64>(shape, Distribution::Uniform, 1);
    let a = MatRef::from_row_major_slice(&a, m, n);
    let mut c = Mat::zeros(n, n);
    let options = AtaOptions::new().par(Par::Seq).scheme(SchemeChoice::Exact);
    let mut group = criterion.benchmark_group(name);
    group.throughput(Throughput::Elements(entries(shape) as u64));
    group.bench_function(BenchmarkId::from_parameter(shape), |b| {
        b.iter(|| ata_into(1.0, a, 0.0, c.as_mut(), &options).expect("valid options"));
    });
}
