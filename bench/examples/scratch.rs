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
    if what == "drift" {
        return drift(&a);
    }
    if what == "thick" {
        return thick(&a);
    }
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

fn drift(a: &[String]) {
    // rate size agents turn angle distance speed noise diffusion
    let f = |i: usize| a[i].parse::<f64>().unwrap();
    let options = Options {
        evaporation_rate: f(2),
        size: f(3) as usize,
        agents: f(4) as usize,
        turn_speed: f(5),
        vision_angle: f(6),
        vision_distance: f(7),
        movement_speed: f(8),
        turn_noise: f(9),
        diffusion_rate: f(10),
        ..Options::default()
    };
    let mesh = families::torus(48, 24, 1.0, 0.5).unwrap();
    let _ = &mesh;
    let surface = torus(48, 24);
    let mut all = Simulation::new(surface, &options, &Mask::default()).unwrap();
    let (mut c, mut pr) = (vec![], vec![]);
    for _ in 0..300 {
        all.run(10, Par::all(), None).unwrap();
        let x = all.coverage(Par::all())[0];
        c.push(x.coverage);
        pr.push(x.presence);
    }
    let m = |v: &[f64], i: usize, j: usize| v[i..j].iter().sum::<f64>() / (j - i) as f64;
    let peak = c.iter().cloned().fold(0.0, f64::max);
    let at = c.iter().position(|&x| x == peak).unwrap();
    println!(
        "{:?}: peak {peak:.3} at {:.1} s; 10s {:.4} 20s {:.4} 30s {:.4} 50s {:.4} 65s {:.4} 95s {:.4} drift {:.1} %; presence 70 s {:.4}",
        &a[2..],
        at as f64 / 3.0,
        m(&c, 27, 33),
        m(&c, 57, 63),
        m(&c, 87, 93),
        m(&c, 147, 153),
        m(&c, 180, 210),
        m(&c, 270, 300),
        100.0 * (m(&c, 270, 300) / m(&c, 180, 210) - 1.0),
        m(&pr, 207, 213)
    );
}
fn torus(columns: usize, rows: usize) -> Surface {
    use std::f64::consts::TAU;
    let place = |u: f64, v: f64| {
        let ring = 1.0 + 0.5 * (TAU * v).cos();
        [ring * (TAU * u).cos(), ring * (TAU * u).sin(), 0.5 * (TAU * v).sin()]
    };
    let part = |i: usize, of: usize| i as f64 / of as f64;
    let mut vertices = vec![];
    for i in 0..columns {
        for j in 0..rows {
            vertices.push(place(part(i, columns), part(j, rows)));
        }
    }
    let (mut faces, mut uv) = (vec![], vec![]);
    for i in 0..columns {
        for j in 0..rows {
            let cs = [[i, j], [i + 1, j], [i + 1, j + 1], [i, j + 1]];
            for face in [[0, 1, 2], [0, 2, 3]] {
                faces.push(face.map(|k: usize| {
                    let [i, j] = cs[k];
                    (i % columns * rows + j % rows) as u32
                }));
                uv.push(face.map(|k: usize| [part(cs[k][0], columns), part(cs[k][1], rows)]));
            }
        }
    }
    Surface::of_faces(&catamaran::mesh::TriMesh::new(vertices, faces).unwrap(), uv).unwrap()
}

fn thick(a: &[String]) {
    use catamaran::texture::slime::Pattern;
    // dt turn steps noise size agents scale
    let f = |i: usize| a[i].parse::<f64>().unwrap();
    let k = f(8);
    for angle in [10.0, 20.0, 30.0, 40.0, 50.0] {
        let options = Options {
            time_step: f(2),
            turn_speed: f(3),
            turn_noise: f(5),
            size: f(6) as usize,
            agents: f(7) as usize,
            movement_speed: 1.5 * k,
            vision_distance: k,
            vision_angle: angle,
            ..Options::default()
        };
        let mesh = families::grid(8, 8).unwrap();
        let at = |v: u32| [mesh.vertices()[v as usize][0], mesh.vertices()[v as usize][1]];
        let surface =
            Surface::of_faces(&mesh, mesh.faces().iter().map(|face| face.map(at)).collect())
                .unwrap();
        let mut all = Simulation::new(surface, &options, &Mask::default()).unwrap();
        all.run(f(4) as u32, Par::all(), None).unwrap();
        let p = |t: f32| Pattern::of(all.texture(0), options.size, t).unwrap();
        let (q, r, u) = (p(0.1), p(0.3), p(0.6));
        println!(
            "{:?} angle {angle}: thickness .1 {:.2} .3 {:.2} .6 {:.2}; gap {:.2} covered {:.3} cells {}",
            &a[2..],
            q.thickness,
            r.thickness,
            u.thickness,
            r.gap,
            r.covered,
            r.cells
        );
    }
}
