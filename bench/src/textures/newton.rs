//! Newton's fractals: figures 7.1 and 7.2 in numbers, and their speed.

use std::time::Instant;

use catamaran::Par;
use catamaran::base::Progress;
use catamaran_geometry::mesh::{Components, Edges, Rim, TriMesh, families, vertex_areas};
use catamaran_simulation::texture::newton::{
    Fractal, Grid, Newton, NewtonOptions, Points, Polynomial,
};

use super::polar;
use crate::Result;
use crate::plant::Part;
use crate::race::median;

/// Computes figure 7.1: the shares of surfaces that converge to each root of z^3 - 1, and how fast,
/// for w = 0 and 0.25; and figure 7.2: the same for a cube.
///
/// # Errors
/// None in practice.
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
            let found = newton(3, w)?.evaluate(
                Points::List(&positions(mesh)),
                Par::all(),
                Progress::none(),
            )?;
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
    let found = newton(3, 0.0)?.evaluate(grid, Par::all(), Progress::none())?;
    let volume = Part {
        figure: "figure 7.2",
        title: format!("the same of a cube of edge 3 with {side}^3 voxels"),
        columns,
        rows: vec![("cube".into(), shares(&found, &vec![1.0; found.roots.len()]))],
        plots: vec![],
    };
    Ok(vec![surface, volume, basins([100, 200])?])
}

/// Computes figure 7.2b: the surfaces of basins of z^3 - 1 in the cube, with this number of voxels
/// along a side. Other basins are the same by symmetry.
fn basins(sides: [u32; 2]) -> Result<Part> {
    let newton = newton(3, 0.0)?;
    let grids = sides.map(|side| Grid::cube(side, 3.0));
    let mut fractals = Vec::new();
    for grid in grids {
        fractals.push(newton.evaluate(Points::Grid(grid), Par::all(), Progress::none())?);
    }
    let mut rows = Vec::new();
    for root in [0, 1, 4, 5] {
        let surface = |i: usize, rim| {
            newton.basin(&grids[i], &fractals[i], root, rim, Par::all(), Progress::none())
        };
        let closed = surface(1, Rim::Closed)?;
        let voxels = fractals[1].roots.iter().filter(|&&found| found == root).count() as f64;
        let voxel = (3.0 / f64::from(sides[1])).powi(3);
        // Without the surface at the sides of the cube.
        let [coarse, fine] = [surface(0, Rim::Open)?.area(), surface(1, Rim::Open)?.area()];
        let name = format!("root {}, {}", root / 3, root % 3);
        rows.push((
            name,
            vec![
                closed.faces().len() as f64,
                Components::new(&closed).len() as f64,
                closed.euler_characteristic(&Edges::new(&closed)) as f64,
                closed.volume().unwrap_or(f64::NAN) / (voxels * voxel),
                fine,
                2.0 + (fine / coarse).ln() / (f64::from(sides[1]) / f64::from(sides[0])).ln(),
            ],
        ));
    }
    Ok(Part {
        figure: "figure 7.2b",
        title: format!(
            "surfaces of basins of z^3 - 1 in the cube with {1}^3 voxels; the dimension of a border \
             from its area with {0}^3 and {1}^3",
            sides[0], sides[1]
        ),
        columns: [
            "faces",
            "pieces",
            "Euler characteristic",
            "volume over that of its voxels",
            "area of the border",
            "dimension of the border",
        ]
        .map(String::from)
        .into(),
        rows,
        plots: vec![],
    })
}

/// The commands that draw the figures of chapter 7.
pub const PICTURES: &str = "\
**pictures** of chapter 7; `MESH` is any mesh, for `--uv` with texture coordinates

| figure | command |
|---|---|
| 7.1a, 7.2a | `catamaran newton MESH -o colored.ply --picture 7.1a.png` |
| 7.1b | `catamaran newton MESH --uv -o color.png --heights convergence.png` |
| 7.1c | `catamaran newton MESH --uv --write-material 7.1c.glb` |
| 7.2b | `catamaran newton --volume --basins 0 --picture 7.2b.png --view -55,25` |
| 7.2b, as a surface | `catamaran newton --volume --basins 0 -o 7.2b.ply` |
| 7.3 | `catamaran newton MESH --uv --write-material 7.3.glb --inlay stones` |
| all basins | `catamaran newton --volume --picture volume.png` |
";

fn newton(n: u32, w: f64) -> Result<Newton> {
    let polynomial = Polynomial::Power(n);
    Ok(Newton::new(&NewtonOptions::new().polynomial(polynomial).w(w))?)
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

/// Returns nanoseconds for a pixel of a plane of `size` x `size`, with 32 iterations, of this
/// library and of the polar form, in turns, each on the processor and (feature `opencl`) on the
/// first OpenCL device; and the share of pixels whose root differs. The polar form, which is slow,
/// computes a sixteenth of the pixels of each row and column, over the same part of the plane.
///
/// # Errors
/// When a device fails.
pub fn newton_times(size: u32, repeat: usize) -> Result<Vec<Part>> {
    let mut parts = Vec::new();
    let plane = |size: u32| Grid::plane(size, size, [0.0; 2], 3.0);
    let (fine, coarse) = (plane(size), plane((size / 16).max(1)));
    // Created before the closures that borrow them.
    #[cfg(feature = "opencl")]
    let device = catamaran_simulation::opencl::Device::open("")?;
    #[cfg(feature = "opencl")]
    let theirs = polar::OnDevice::new(device.info().index, &coarse)?;
    for power in [3, 7] {
        let ours = newton(power, 0.0)?;
        let (ours, n) = (&ours, power as i32);
        let mut contenders = vec![Contender::new("ours, processor", fine, move |grid| {
            Ok(ours.evaluate(Points::Grid(*grid), Par::all(), Progress::none())?)
        })];
        for stops in [false, true] {
            let name = format!("{}, processor", polar_name(stops));
            contenders.push(Contender::new(&name, coarse, move |grid| {
                Ok(polar::on_processor(grid, n, 32, 3.5, stops))
            }));
        }
        #[cfg(feature = "opencl")]
        {
            let (device, theirs) = (&device, &theirs);
            let on = &device.info().name;
            contenders.push(Contender::new(&format!("ours, {on}"), fine, move |grid| {
                Ok(catamaran_simulation::opencl::evaluate_newton(
                    device,
                    ours,
                    Points::Grid(*grid),
                    Progress::none(),
                )?)
            }));
            for stops in [false, true] {
                let name = format!("{}, {on}", polar_name(stops));
                contenders
                    .push(Contender::new(&name, coarse, move |_| theirs.run(n, 32, 3.5, stops)));
            }
        }
        let title = format!("z^{n} - 1, {size} x {size} pixels, 32 iterations");
        parts.push(race(&title, ours, &contenders, repeat)?);
    }
    Ok(parts)
}

fn polar_name(stops: bool) -> &'static str {
    if stops { "polar form that stops early" } else { "polar form" }
}

type Run<'a> = dyn Fn(&Grid) -> Result<Fractal> + 'a;

/// A timed computation, and its device.
struct Contender<'a> {
    name: String,
    grid: Grid,
    run: Box<Run<'a>>,
}

impl<'a> Contender<'a> {
    fn new(name: &str, grid: Grid, run: impl Fn(&Grid) -> Result<Fractal> + 'a) -> Self {
        Self { name: name.into(), grid, run: Box::new(run) }
    }
}

fn race(title: &str, ours: &Newton, contenders: &[Contender<'_>], repeat: usize) -> Result<Part> {
    // The first run of each builds programs and touches memory, and shows whether they agree.
    let mut different = Vec::new();
    for contender in contenders {
        let found = (contender.run)(&contender.grid)?;
        let expected = ours.evaluate(Points::Grid(contender.grid), Par::all(), Progress::none())?;
        let count = expected.roots.iter().zip(&found.roots).filter(|(a, b)| a != b).count();
        different.push(count as f64 / found.roots.len().max(1) as f64);
    }
    let mut times = vec![Vec::new(); contenders.len()];
    for _ in 0..repeat {
        for (times, contender) in times.iter_mut().zip(contenders) {
            let start = Instant::now();
            let found = (contender.run)(&contender.grid)?;
            times.push(1e9 * start.elapsed().as_secs_f64() / found.roots.len().max(1) as f64);
        }
    }
    let medians: Vec<f64> = times.into_iter().map(median).collect();
    let rows = contenders.iter().zip(&medians).zip(different).map(|((contender, time), other)| {
        (contender.name.clone(), vec![*time, time / medians[0], other])
    });
    Ok(Part {
        figure: "race",
        title: format!("{title}: median of {repeat}, in turns"),
        columns: ["ns a pixel", "over ours on the processor", "share of other roots"]
            .map(String::from)
            .into(),
        rows: rows.collect(),
        plots: vec![],
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn borders_of_basins_are_more_than_surfaces() {
        let part = basins([24, 48]).unwrap();
        assert_eq!(part.rows.len(), 4);
        for (name, values) in &part.rows {
            let [_, pieces, euler, volume, _, dimension] = values[..] else { panic!("{values:?}") };
            assert!(pieces >= 1.0 && euler % 2.0 == 0.0, "{name}: {values:?}");
            assert!((0.7..1.02).contains(&volume), "{name}: {volume}");
            assert!((2.05..3.0).contains(&dimension), "{name}: {dimension}");
        }
    }
}
