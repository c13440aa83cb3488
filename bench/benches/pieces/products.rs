//! Products: leaf kernels per back end, packing, fast levels, making a plan, tiny products.

use std::path::Path;
use std::sync::Arc;

use catamaran::blas::{self, Backend, BlasReal};
use catamaran::faer::{Mat, MatRef};
use catamaran::{Accuracy, AtaOptions, Par, Plan, SchemeChoice, ata_into, atb_into};
use catamaran_bench::input::{Distribution, Shape, matrix};
use catamaran_bench::library::find;
use criterion::{BenchmarkId, Criterion, Throughput};

pub fn all(criterion: &mut Criterion) {
    leaves(criterion);
    packing(criterion);
    one_level(criterion);
    fused_additions(criterion);
    plans(criterion);
    tiny(criterion);
}

fn backends() -> Vec<(&'static str, Arc<dyn Backend>)> {
    let rivals = Path::new(concat!(env!("CARGO_MANIFEST_DIR"), "/../target/rivals"));
    let mut found = vec![("native", blas::native())];
    for name in ["mkl", "openblas"] {
        let library = find(name, rivals).and_then(|path| blas::load(&path).ok());
        found.extend(library.map(|library| (name, library)));
    }
    found
}

fn square(n: usize) -> Vec<f64> {
    matrix(Shape { m: n, n }, Distribution::Uniform, 1)
}

fn leaves(criterion: &mut Criterion) {
    for (name, backend) in backends() {
        let _held = backend.single_threaded();
        let kernels = f64::kernels(backend.as_ref());
        let mut group = criterion.benchmark_group(format!("leaf/{name}"));
        for n in [128, 256, 512, 1024] {
            let a = square(n);
            let a = MatRef::from_row_major_slice(&a, n, n);
            let mut c = Mat::zeros(n, n);
            group.bench_function(BenchmarkId::new("gemm", n), |b| {
                b.iter(|| kernels.gemm(1.0, a, a, 0.0, c.as_mut().transpose_mut()));
            });
            group.bench_function(BenchmarkId::new("syrk", n), |b| {
                b.iter(|| kernels.syrk(1.0, a, 0.0, c.as_mut().transpose_mut()));
            });
        }
    }
}

/// A^T B for a B of few columns: each entry of A is packed for 8 multiply-adds.
fn packing(criterion: &mut Criterion) {
    const N: usize = 1024;
    const FEW: usize = 8;
    let backend = blas::native();
    let kernels = f64::kernels(backend.as_ref());
    let (a, b) = (square(N), matrix(Shape { m: N, n: FEW }, Distribution::Uniform, 2));
    let b = MatRef::from_row_major_slice(&b, N, FEW);
    let mut c = Mat::zeros(N, FEW);
    let mut group = criterion.benchmark_group("packing");
    group.throughput(Throughput::Bytes(size_of_val(&a[..]) as u64));
    let by_rows = MatRef::from_row_major_slice(&a, N, N);
    for (name, a) in [("A by rows", by_rows), ("A by columns", by_rows.transpose())] {
        group.bench_function(BenchmarkId::new(name, N), |bencher| {
            bencher.iter(|| kernels.gemm(1.0, a, b, 0.0, c.as_mut()));
        });
    }
}

fn sequential(scheme: SchemeChoice, leaf: Option<usize>) -> AtaOptions<'static> {
    AtaOptions::new().par(Par::Seq).scheme(scheme).leaf(leaf)
}

/// One level of each scheme over 256-long leaves: what its sums of blocks cost beside them.
fn one_level(criterion: &mut Criterion) {
    let mut group = criterion.benchmark_group("one level");
    for (name, scheme) in SchemeChoice::NAMES {
        let n = match scheme {
            SchemeChoice::Kgp4 | SchemeChoice::Rxtx => 1024,
            SchemeChoice::Kgp3 => 768,
            SchemeChoice::Winograd => 512,
            _ => continue,
        };
        let a = square(n);
        let a = MatRef::from_row_major_slice(&a, n, n);
        let mut c = Mat::zeros(n, n);
        let options = sequential(scheme, Some(256)).tasks(1);
        group.bench_function(BenchmarkId::new(name, n), |b| {
            b.iter(|| ata_into(1.0, a, 0.0, c.as_mut(), &options).expect("valid options"));
        });
    }
}

/// The same product without fast levels and with as many as go down to blocks of 64, of which a
/// good part of the time is additions made while packing and writing.
fn fused_additions(criterion: &mut Criterion) {
    const N: usize = 512;
    let a = square(N);
    let a = MatRef::from_row_major_slice(&a, N, N);
    let mut c = Mat::zeros(N, N);
    let mut group = criterion.benchmark_group("fused additions");
    for (name, scheme) in
        [("none", SchemeChoice::Classical), ("down to 64", SchemeChoice::Winograd)]
    {
        let options = sequential(scheme, Some(64)).tasks(1).accuracy(Accuracy::Fast);
        group.bench_function(BenchmarkId::new(name, N), |b| {
            b.iter(|| atb_into(1.0, a, a, 0.0, c.as_mut(), &options).expect("valid options"));
        });
    }
}

fn plans(criterion: &mut Criterion) {
    let mut group = criterion.benchmark_group("plan");
    for n in [64, 1024, 16384] {
        let options = sequential(SchemeChoice::Auto, None);
        group.bench_function(BenchmarkId::new("auto", n), |b| {
            b.iter(|| Plan::ata::<f64>(n, n, &options).expect("valid options"));
        });
    }
}

fn tiny(criterion: &mut Criterion) {
    let mut group = criterion.benchmark_group("latency");
    for n in [8, 32, 64, 128] {
        let a = square(n);
        let a = MatRef::from_row_major_slice(&a, n, n);
        let mut c = Mat::zeros(n, n);
        let options = sequential(SchemeChoice::Auto, None);
        group.bench_function(BenchmarkId::new("ata", n), |b| {
            b.iter(|| ata_into(1.0, a, 0.0, c.as_mut(), &options).expect("valid options"));
        });
    }
}
