//! The exact path: its stages, by the clock that is in it.

use std::time::Duration;

use catamaran::faer::{Mat, MatRef};
use catamaran::kernel::int8::IntegerIsa;
use catamaran::product::{Stages, exact_stages};
use catamaran::{AtaOptions, Par};
use catamaran_bench::input::{Distribution, Shape, matrix};
use criterion::{BenchmarkId, Criterion, Throughput};

pub fn all(criterion: &mut Criterion) {
    // Much conversion, and much recombination.
    stage(
        criterion,
        "residues",
        Shape { m: 4096, n: 64 },
        |shape| shape.m * shape.n,
        |s| s.conversion,
    );
    let triangle = |shape: Shape| shape.n * (shape.n + 1) / 2;
    stage(criterion, "recombination", Shape { m: 64, n: 1024 }, triangle, |s| s.recombination);
}

/// Seconds of a stage of A^T A, on every instruction set of the machine; throughput in `entries`.
fn stage(
    criterion: &mut Criterion,
    name: &str,
    shape: Shape,
    entries: impl Fn(Shape) -> usize,
    seconds: fn(&Stages) -> f64,
) {
    let Shape { m, n } = shape;
    let a = matrix::<f64>(shape, Distribution::Uniform, 1);
    let a = MatRef::from_row_major_slice(&a, m, n);
    let mut c = Mat::zeros(n, n);
    let options = AtaOptions::new().par(Par::Seq);
    let mut group = criterion.benchmark_group(name);
    group.throughput(Throughput::Elements(entries(shape) as u64));
    for isa in IntegerIsa::ALL.into_iter().filter(|isa| isa.refusal().is_none()) {
        group.bench_function(BenchmarkId::new(isa.name(), shape), |b| {
            b.iter_custom(|count| {
                let mut once =
                    || exact_stages(isa, a, c.as_mut(), &options).expect("an isa of this machine");
                Duration::from_secs_f64((0..count).map(|_| seconds(&once())).sum())
            });
        });
    }
}
