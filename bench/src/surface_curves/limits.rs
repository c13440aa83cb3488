//! Measures what keeps H and R of the thesis' section 6.4.2 from their bars: the vertices, the
//! geodesics between samples, or missing information in the samples.

use catamaran::base::Rng;
use catamaran_geometry::curve::dataset::{Generator, Samples, Sampling, samples};
use catamaran_geometry::curve::{CurveOptions, CurveSolver, Mode, Reconstruction, refined};
use catamaran_geometry::mesh::{Edges, Graph, TriMesh};

use super::distances::{hausdorff, root_mean_distance, root_mean_square_distance};
use super::{SIZES, Surface};
use crate::Result;

/// The thesis' bars for H and R.
const NEAR: (f64, f64) = (0.25, 0.07);

/// The method of reconstruction.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Variant {
    /// The robust mode.
    Vertices,
    /// The robust mode on the mesh with the edges near its curve cut in their middle, this number
    /// of times.
    Levels(usize),
    /// The robust mode, smoothed: geodesics between samples.
    Smooth,
    /// Paths along edges between samples in their true order.
    TrueOrder,
    /// Geodesics between samples in their true order.
    TrueSmooth,
}

impl Variant {
    const ALL: [Self; 6] = [
        Self::Vertices,
        Self::Levels(1),
        Self::Levels(2),
        Self::Smooth,
        Self::TrueOrder,
        Self::TrueSmooth,
    ];

    fn name(self) -> String {
        match self {
            Self::Vertices => "robust, along edges".into(),
            Self::Levels(levels) => format!("robust, {levels} levels of Steiner points"),
            Self::Smooth => "robust, smooth".into(),
            Self::TrueOrder => "true order, along edges".into(),
            Self::TrueSmooth => "true order, smooth".into(),
        }
    }
}

/// One reconstruction.
#[derive(Debug, Clone, Copy)]
pub struct Distances {
    mesh: &'static str,
    vertices: usize,
    samples: usize,
    sampling: Sampling,
    variant: Variant,
    /// Distances to the points of the curve: H, R as printed, R with squares.
    points: [f64; 3],
    /// Distances to the lines between the points: H, R as printed.
    lines: [f64; 2],
    /// Mean length of the edges of the true curve.
    edge: f64,
}

/// Reconstructs curves of a mesh by every variant from samples of every kind.
///
/// # Errors
/// The errors of the library.
pub fn measure_limits(surface: &Surface, curves: usize, seed: u64) -> Result<Vec<Distances>> {
    let mesh = &surface.mesh;
    let graph = Graph::of_mesh(mesh);
    let mut generator = Generator::new(&graph, seed)?;
    let mut rng = Rng::new(seed + 1);
    let mut solver = CurveSolver::new(mesh)?;
    let mut runs = Vec::new();
    for _ in 0..curves {
        let Some(curve) = generator.curve()? else { break };
        let truth: Vec<[f64; 3]> = curve.iter().map(|&v| mesh.vertices()[v as usize]).collect();
        let length: f64 = segments(&truth, true).map(|[p, q]| distance(p, q)).sum();
        for count in SIZES {
            for sampling in [Sampling::Even, Sampling::Random] {
                let given = samples(&curve, count, sampling, &mut rng);
                for variant in Variant::ALL {
                    let found = reconstruct(&mut solver, &given, variant)?;
                    let points: Vec<[f64; 3]> =
                        found.curves.iter().flat_map(|c| c.points.iter().copied()).collect();
                    let lines: Vec<[[f64; 3]; 2]> = (found.curves.iter())
                        .flat_map(|c| segments(&c.points, c.closed).collect::<Vec<_>>())
                        .collect();
                    let own: Vec<[[f64; 3]; 2]> = segments(&truth, true).collect();
                    let ahead: Vec<f64> = truth.iter().map(|&p| to_lines(p, &lines)).collect();
                    let back = points.iter().map(|&p| to_lines(p, &own));
                    runs.push(Distances {
                        mesh: surface.name,
                        vertices: mesh.vertices().len(),
                        samples: count,
                        sampling,
                        variant,
                        points: [
                            hausdorff(&truth, &points),
                            root_mean_distance(&truth, &points),
                            root_mean_square_distance(&truth, &points),
                        ],
                        lines: [
                            ahead.iter().copied().chain(back).fold(0.0, f64::max),
                            (ahead.iter().sum::<f64>() / truth.len() as f64).sqrt(),
                        ],
                        edge: length / truth.len() as f64,
                    });
                }
            }
        }
    }
    Ok(runs)
}

fn reconstruct(
    solver: &mut CurveSolver<'_>,
    given: &Samples,
    variant: Variant,
) -> Result<Reconstruction> {
    let ordered: Vec<u32> = given.order.iter().map(|&i| given.vertices[i as usize]).collect();
    let (samples, options) = match variant {
        Variant::TrueOrder | Variant::TrueSmooth => {
            (ordered, CurveOptions::new().mode(Mode::Ordered))
        }
        _ => (given.vertices.clone(), CurveOptions::new()),
    };
    let mut found = solver.reconstruct(&samples, &options)?;
    match variant {
        Variant::Vertices | Variant::TrueOrder => {}
        Variant::Smooth | Variant::TrueSmooth => {
            // Where the geodesics can't be drawn, the curve remains on edges.
            let _ = found.smooth(solver.mesh(), &samples);
        }
        Variant::Levels(levels) => {
            let mut mesh = refined(solver.mesh(), &found.steiner)?;
            for _ in 0..levels {
                mesh = refined(&mesh, &around(&mesh, &found))?;
                found = CurveSolver::new(&mesh)?.reconstruct(&samples, &options)?;
                mesh = refined(&mesh, &found.steiner)?;
            }
        }
    }
    Ok(found)
}

/// Returns the edges of all faces that curves touch.
fn around(mesh: &TriMesh, found: &Reconstruction) -> Vec<[u32; 2]> {
    let mut touched = vec![false; mesh.vertices().len()];
    for &v in found.curves.iter().flat_map(|curve| &curve.path) {
        touched[v as usize] = true;
    }
    let edges = Edges::new(mesh);
    let near = |e: usize| {
        edges.faces(e).any(|f| mesh.faces()[f as usize].iter().any(|&v| touched[v as usize]))
    };
    (0..edges.len()).filter(|&e| near(e)).map(|e| edges.ends()[e]).collect()
}

fn segments(points: &[[f64; 3]], closed: bool) -> impl Iterator<Item = [[f64; 3]; 2]> {
    let next = points.iter().cycle().skip(1);
    let count = points.len() - usize::from(!closed && !points.is_empty());
    points.iter().zip(next).take(count).map(|(&p, &q)| [p, q])
}

fn distance(p: [f64; 3], q: [f64; 3]) -> f64 {
    (0..3).map(|k| (p[k] - q[k]).powi(2)).sum::<f64>().sqrt()
}

/// Returns the distance from a point to the nearest of the lines.
fn to_lines(x: [f64; 3], lines: &[[[f64; 3]; 2]]) -> f64 {
    let square = |&[p, q]: &[[f64; 3]; 2]| {
        let dot = |a: [f64; 3], b: [f64; 3]| (0..3).map(|k| a[k] * b[k]).sum::<f64>();
        let [along, to] = [q, x].map(|y| std::array::from_fn(|k| y[k] - p[k]));
        let t = (dot(along, to) / dot(along, along)).clamp(0.0, 1.0);
        let t = if t.is_nan() { 0.0 } else { t };
        (0..3).map(|k| (to[k] - t * along[k]).powi(2)).sum::<f64>()
    };
    lines.iter().map(square).fold(f64::INFINITY, f64::min).sqrt()
}

/// Returns the tables: shares of runs within the bars, by variant, by number of samples, by mesh.
pub fn limit_tables(runs: &[Distances]) -> String {
    let percent = |own: &mut dyn Iterator<Item = &Distances>, is: fn(&Distances) -> bool| {
        let (all, those) = own.fold((0, 0), |(n, k), r| (n + 1, k + u32::from(is(r))));
        format!("{:.1}", 100.0 * f64::from(those) / f64::from(all.max(1)))
    };
    let written = |r: &Distances| r.points[0] <= NEAR.0 && r.points[1] <= NEAR.1;
    let squared = |r: &Distances| r.points[0] <= NEAR.0 && r.points[2] <= NEAR.1;
    let lines = |r: &Distances| r.lines[0] <= NEAR.0 && r.lines[1] <= NEAR.1;
    let median = |own: &mut dyn Iterator<Item = f64>| {
        let mut all: Vec<f64> = own.collect();
        all.sort_by(f64::total_cmp);
        all.get(all.len() / 2).copied().unwrap_or(f64::NAN)
    };
    let mut text = String::from(
        "**H <= 0.25 and R <= 0.07**, per cent of all runs; R as written, to the points of the \
         curve, to the lines between them, and with squares; and the median of the mean distance, \
         of which R as written is the root (bar: 0.0049)\n\n| curve | as written | as written, to \
         lines | with squares | median distance | to lines |\n\
         |---|---|---|---|---|---|\n",
    );
    let of = |variant: Variant| runs.iter().filter(move |r| r.variant == variant);
    for variant in Variant::ALL {
        text += &format!(
            "| {} | {} | {} | {} | {:.4} | {:.4} |\n",
            variant.name(),
            percent(&mut of(variant), written),
            percent(&mut of(variant), lines),
            percent(&mut of(variant), squared),
            median(&mut of(variant).map(|r| r.points[1].powi(2))),
            median(&mut of(variant).map(|r| r.lines[1].powi(2))),
        );
    }
    text += &format!(
        "\n**The same as written, to lines, by number of samples**\n\n\
         | curve | sampling | {} |\n|---|---|{}\n",
        SIZES.map(|k| k.to_string()).join(" | "),
        "---|".repeat(SIZES.len())
    );
    for variant in Variant::ALL {
        for (sampling, kind) in [(Sampling::Even, "even"), (Sampling::Random, "random")] {
            let cell = |k: usize| {
                let own = of(variant).filter(|r| r.samples == k && r.sampling == sampling);
                percent(&mut own.into_iter(), lines)
            };
            text += &format!("| {} | {kind} | {} |\n", variant.name(), SIZES.map(cell).join(" | "));
        }
    }
    text += "\n**By mesh**, 100 even samples: mean edge of the true curves, and the median \
             of the mean distance to lines\n\n| mesh | vertices | edge |";
    for variant in Variant::ALL {
        text += &format!(" {} |", variant.name());
    }
    text += &format!("\n|---|---|---|{}\n", "---|".repeat(Variant::ALL.len()));
    let mut meshes: Vec<(&str, usize)> = runs.iter().map(|r| (r.mesh, r.vertices)).collect();
    meshes.dedup();
    for (mesh, vertices) in meshes {
        let own = |variant| {
            of(variant)
                .filter(move |r| r.mesh == mesh && r.samples == 100 && r.sampling == Sampling::Even)
        };
        let edge = median(&mut own(Variant::Vertices).map(|r| r.edge));
        text += &format!("| {mesh} | {vertices} | {edge:.4} |");
        for variant in Variant::ALL {
            text += &format!(" {:.4} |", median(&mut own(variant).map(|r| r.lines[1].powi(2))));
        }
        text.push('\n');
    }
    text
}

/// Columns of the record.
pub const LIMITS_HEAD: &str = "mesh,vertices,samples,sampling,curve,edge,hausdorff,\
                               root_mean,root_mean_square,hausdorff_lines,root_mean_lines";

impl Distances {
    /// Returns a line of CSV.
    pub fn line(&self) -> String {
        let sampling = if self.sampling == Sampling::Even { "even" } else { "random" };
        let [h, r, s] = self.points;
        let [hl, rl] = self.lines;
        format!(
            "{},{},{},{sampling},{},{:.5},{h:.5},{r:.5},{s:.5},{hl:.5},{rl:.5}",
            self.mesh,
            self.vertices,
            self.samples,
            self.variant.name().replace(',', ""),
            self.edge,
        )
    }
}
