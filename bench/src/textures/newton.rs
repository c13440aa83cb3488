//! Newton's fractals: what figures 7.1 and 7.2 show in numbers, and how fast it is.

use std::time::Instant;

use catamaran::Par;
use catamaran::mesh::{TriMesh, families, vertex_areas};
use catamaran::texture::newton::{Fractal, Grid, Newton, NewtonOptions, Points, Polynomial};

use super::polar;
use crate::Result;
use crate::plant::Part;
use crate::race::median;

/// Figure 7.1: how much of surfaces goes to each root of z^3 - 1 and how fast, for w = 0 and 0.25; figure 7.2: the same of a
/// cube.
///
/// # Errors
/// None that is to be expected.
pub fn newton_figures() -> Result<Vec<Part>> {
    let surfaces = [
        ("sphere", families::icosphere(6)?),
        ("torus", families::torus(400, 200, 1.0, 0.4)?),
        ("figure", families::figure(60, 0.5)?),
    ];
    let mut columns: Vec<String> =
        (0..9).map(|root| format!("share of root {}, {}", root / 3, root % 3)).collect();
    columns.extend(["mean of t".into(), "share with t above 10".into()]);
    let mut rows = Vec::new();
    for (name, mesh) in &surfaces {
        for w in [0.0, 0.25] {
            let areas = vertex_areas(mesh);
            let found = newton(3, w)?.evaluate(Points::List(&positions(mesh)), Par::all(), None)?;
            rows.push((format!("{name}, w = {w}"), shares(&found, &areas)));
        }
    }
    let surface = Part {
        figure: "figure 7.1",
        title: "what of a surface goes to which root of z^3 - 1 (by area), and how slowly (equation 7.3)".into(),
        columns: columns.clone(),
        rows,
        plots: vec![],
    };
    let side = 200;
    let grid = Points::Grid(Grid::cube(side, 3.0));
    let found = newton(3, 0.0)?.evaluate(grid, Par::all(), None)?;
    let volume = Part {
        figure: "figure 7.2",
        title: format!("the same of a cube of edge 3 with {side}^3 voxels"),
        columns,
        rows: vec![("cube".into(), shares(&found, &vec![1.0; found.roots.len()]))],
        plots: vec![],
    };
    Ok(vec![surface, volume])
}

fn newton(n: u32, w: f64) -> Result<Newton> {
    let polynomial = Polynomial::Power(n);
    Ok(Newton::new(&NewtonOptions { polynomial, w, ..NewtonOptions::default() })?)
}

fn positions(mesh: &TriMesh) -> Vec<[f32; 3]> {
    mesh.vertices().iter().map(|p| p.map(|x| x as f32)).collect()
}

fn shares(found: &Fractal, weights: &[f64]) -> Vec<f64> {
    let all: f64 = weights.iter().sum();
    let mut shares = vec![0.0; 11];
    for ((&root, &t), weight) in found.roots.iter().zip(&found.convergence).zip(weights) {
        shares[usize::from(root)] += weight / all;
        shares[9] += weight / all * f64::from(t);
        shares[10] += if t > 10.0 { weight / all } else { 0.0 };
    }
    shares
}

/// Seconds for `size` x `size` pixels of a plane and 32 iterations, ours and the polar form, in turns, each on the processor
/// and (feature `opencl`) on the first OpenCL device; with the share of pixels whose root differs from that of ours.
///
/// # Errors
/// Where a device refuses.
pub fn newton_times(size: u32, repeat: usize) -> Result<Vec<Part>> {
    let mut parts = Vec::new();
    for n in [3, 7] {
        let grid = Grid::plane(size, size, [0.0; 2], 3.0);
        let ours = newton(n, 0.0)?;
        let n = n as i32;
        let mut contenders: Vec<Contender<'_>> = vec![
            (
                "ours, processor".into(),
                Box::new(|| Ok(ours.evaluate(Points::Grid(grid), Par::all(), None)?)),
            ),
            (
                "polar form, processor".into(),
                Box::new(|| Ok(polar::on_processor(&grid, n, 32, 3.5, false))),
            ),
            (
                "polar form that stops early, processor".into(),
                Box::new(|| Ok(polar::on_processor(&grid, n, 32, 3.5, true))),
            ),
        ];
        #[cfg(feature = "opencl")]
        let (device, theirs) = {
            let device = catamaran::opencl::Device::open("")?;
            let pixels = size as usize * size as usize;
            let theirs = polar::OnDevice::new(device.info().index, pixels)?;
            (device, theirs)
        };
        #[cfg(feature = "opencl")]
        {
            let name = device.info().name.clone();
            let points = Points::Grid(grid);
            let (device, theirs, ours) = (&device, &theirs, &ours);
            contenders.push((
                format!("ours, {name}"),
                Box::new(move || {
                    Ok(catamaran::opencl::evaluate_newton(device, ours, points, None)?)
                }),
            ));
            contenders.push((
                format!("polar form, {name}"),
                Box::new(move || theirs.run(&grid, n, 32, 3.5, false)),
            ));
            contenders.push((
                format!("polar form that stops early, {name}"),
                Box::new(move || theirs.run(&grid, n, 32, 3.5, true)),
            ));
        }
        parts.push(race(
            &format!("z^{n} - 1, {size} x {size} pixels, 32 iterations"),
            &contenders,
            repeat,
        )?);
    }
    Ok(parts)
}

/// A name, and what is timed.
type Contender<'a> = (String, Box<dyn Fn() -> Result<Fractal> + 'a>);

fn race(title: &str, contenders: &[Contender<'_>], repeat: usize) -> Result<Part> {
    // The first run of each builds programs and touches memory, and says whether they agree.
    let mut different = Vec::new();
    let mut first: Option<Fractal> = None;
    for (_, run) in contenders {
        let found = run()?;
        let reference = first.get_or_insert_with(|| found.clone());
        let count = reference.roots.iter().zip(&found.roots).filter(|(a, b)| a != b).count();
        different.push(count as f64 / found.roots.len().max(1) as f64);
    }
    drop(first);
    let mut times = vec![Vec::new(); contenders.len()];
    for _ in 0..repeat {
        for (times, (_, run)) in times.iter_mut().zip(contenders) {
            let start = Instant::now();
            let found = run()?;
            times.push(start.elapsed().as_secs_f64());
            drop(found);
        }
    }
    let medians: Vec<f64> = times.into_iter().map(median).collect();
    let rows =
        contenders.iter().zip(&medians).zip(different).map(|(((name, _), seconds), other)| {
            (name.clone(), vec![*seconds, seconds / medians[0], other])
        });
    Ok(Part {
        figure: "race",
        title: format!("{title}: median of {repeat}, in turns"),
        columns: vec![
            "seconds".into(),
            "times ours on the processor".into(),
            "share of other roots".into(),
        ],
        rows: rows.collect(),
        plots: vec![],
    })
}
