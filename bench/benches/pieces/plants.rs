//! Plants: elimination from the leaves of a tree to its root, and substitution back.

use catamaran::Par;
use catamaran_simulation::plant::families::{GrowthOptions, grow};
use catamaran_simulation::plant::{Bdf6, Start, WaterModel, WaterOptions};
use criterion::{BenchmarkId, Criterion, Throughput};

pub fn all(criterion: &mut Criterion) {
    const NODES: usize = 100_000;
    /// Seconds.
    const STEP: f64 = 60.0;
    let plant = grow(&GrowthOptions::new().nodes(NODES)).expect("valid options");
    let model = WaterModel::new(&plant, &WaterOptions::new()).expect("valid options");
    let mut bdf =
        Bdf6::new(&model, &model.full(), STEP, Start::Constant, Par::Seq).expect("valid options");
    let mut group = criterion.benchmark_group("elimination on trees");
    group.throughput(Throughput::Elements(NODES as u64));
    group.bench_function(BenchmarkId::new("factor", NODES), |b| {
        b.iter(|| bdf.restart(&model, STEP).expect("the same model"));
    });
    group.bench_function(BenchmarkId::new("solve", NODES), |b| b.iter(|| bdf.step()));
}
