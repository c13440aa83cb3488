//! Textures: agents of slime moulds, Newton's method.

use catamaran::Par;
use catamaran::base::Progress;
use catamaran_geometry::mesh::families;
use catamaran_simulation::texture::newton::{Grid, Newton, NewtonOptions, Points, Polynomial};
use catamaran_simulation::texture::slime::{Mask, Options, Simulation, Surface, TangentStep};
use criterion::{BenchmarkId, Criterion, Throughput};

pub fn all(criterion: &mut Criterion) {
    agents(criterion);
    newton(criterion);
}

/// Frames of many agents on a small texture, so that little of the time is diffusion.
fn agents(criterion: &mut Criterion) {
    const AGENTS: usize = 100_000;
    let mesh = families::grid(40, 40).expect("a small grid");
    let at = |v: u32| [mesh.vertices()[v as usize][0], mesh.vertices()[v as usize][1]];
    let flat: Vec<_> = mesh.faces().iter().map(|face| face.map(at)).collect();
    let mut group = criterion.benchmark_group("agents");
    group.throughput(Throughput::Elements(AGENTS as u64));
    for (name, tangent_step) in
        [("unfolded", TangentStep::Unfold), ("projected", TangentStep::Project { substeps: 10 })]
    {
        let surface = Surface::of_faces(&mesh, flat.clone()).expect("a flat grid");
        let options = Options::new().agents(AGENTS).size(256).tangent_step(tangent_step);
        let mut simulation =
            Simulation::new(surface, &options, &Mask::default()).expect("valid options");
        group.bench_function(BenchmarkId::new(name, AGENTS), |b| {
            b.iter(|| simulation.step(Par::Seq));
        });
    }
}

fn newton(criterion: &mut Criterion) {
    const SIDE: u32 = 256;
    let plane = Points::Grid(Grid::plane(SIDE, SIDE, [0.0, 0.0], 2.0));
    let mut group = criterion.benchmark_group("newton");
    group.throughput(Throughput::Elements(u64::from(SIDE * SIDE)));
    for degree in [3, 8] {
        let options = NewtonOptions::new().polynomial(Polynomial::Power(degree));
        let newton = Newton::new(&options).expect("valid options");
        group.bench_function(BenchmarkId::new("power", degree), |b| {
            b.iter(|| newton.evaluate(plane, Par::Seq, Progress::none()).expect("a plane"));
        });
    }
}
