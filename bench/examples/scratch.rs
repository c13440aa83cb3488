#![allow(missing_docs)]
use catamaran::Par;
use catamaran::mesh::families;
use catamaran::opencl::{Device, SlimeOnDevice};
use catamaran::texture::slime::{Mask, Options, Simulation, Surface, TangentStep, atlas};
fn cpu() -> f64 {
    let s = std::fs::read_to_string("/proc/self/schedstat").unwrap();
    let _ = s;
    let mut total = 0.0;
    for t in std::fs::read_dir("/proc/self/task").unwrap() {
        let p = t.unwrap().path().join("schedstat");
        let s = std::fs::read_to_string(p).unwrap();
        total += s.split_whitespace().next().unwrap().parse::<f64>().unwrap();
    }
    total / 1e6
}
fn main() {
    let a: Vec<String> = std::env::args().collect();
    let what = a[1].as_str();
    let sub: u32 = a[2].parse().unwrap();
    let tangent_step =
        if sub == 0 { TangentStep::Unfold } else { TangentStep::Project { substeps: sub } };
    let options = Options { tangent_step, ..Options::default() };
    let mesh = families::icosphere(4).unwrap();
    let surface = Surface::of_faces(&mesh, atlas(&mesh, options.size).unwrap()).unwrap();
    let mut twin = Simulation::new(surface, &options, &Mask::default()).unwrap();
    let n: u32 = 16;
    if what == "twin" {
        for r in 0..3 {
            let c = cpu();
            let t = std::time::Instant::now();
            twin.run(n, Par::all(), None).unwrap();
            println!(
                "twin {sub} round {r}: cpu {:.1} ms/step, wall {:.1}",
                (cpu() - c) / f64::from(n),
                1e3 * t.elapsed().as_secs_f64() / f64::from(n)
            );
        }
        let c = cpu();
        let t = std::time::Instant::now();
        for _ in 0..4 {
            std::hint::black_box(twin.coverage(Par::all()));
        }
        println!(
            "coverage: cpu {:.1} wall {:.1} {:?}",
            (cpu() - c) / 4.0,
            250.0 * t.elapsed().as_secs_f64(),
            twin.coverage(Par::all())
        );
    } else {
        let device = Device::open("").unwrap();
        let mut k =
            SlimeOnDevice::in_groups(&device, &twin, a.get(3).map(|g| g.parse().unwrap())).unwrap();
        for r in 0..3 {
            let c = cpu();
            let t = std::time::Instant::now();
            k.run(n, None).unwrap();
            println!(
                "device {sub} round {r}: cpu {:.1} ms/step, wall {:.1}",
                (cpu() - c) / f64::from(n),
                1e3 * t.elapsed().as_secs_f64() / f64::from(n)
            );
        }
        let c = cpu();
        let t = std::time::Instant::now();
        for _ in 0..4 {
            std::hint::black_box(k.coverage().unwrap());
        }
        println!(
            "coverage: cpu {:.1} wall {:.1} {:?}",
            (cpu() - c) / 4.0,
            250.0 * t.elapsed().as_secs_f64(),
            k.coverage().unwrap()
        );
    }
}
