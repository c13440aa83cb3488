//! Table 6.2 of the thesis (random samples) against ours: by how much of a curve its samples are, and
//! by what becomes of samples that a path runs over.

use catamaran::base::Rng;
use catamaran::curve::dataset::{Generator, Sampling, samples, scaled};
use catamaran::curve::{CurveOptions, CurveSolver, Mode, same_order};
use catamaran::mesh::{Graph, families};

use super::literal::{Passed, walk};
use super::{SIZES, Surface};
use crate::Result;

/// Candidates of the heuristic.
const CANDIDATES: [usize; 3] = [1, 3, 5];
/// Upper ends of the classes of the share of a curve's vertices that are samples.
const CLASSES: [f64; 8] = [0.05, 0.1, 0.2, 0.3, 0.4, 0.6, 0.8, 1.0];
/// The thesis' table 6.2 at 100 samples: l = 1, 3, 5.
const THESIS: [f64; 3] = [22.57, 29.22, 30.82];

/// How the curve was walked.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Walk {
    /// The library's faithful mode: paths keep off samples that wait.
    Faithful,
    /// Paths run over waiting samples, which are lost.
    Lost,
    /// Paths run over waiting samples, which are taken in passing.
    Taken,
}

impl Walk {
    const ALL: [Self; 3] = [Self::Faithful, Self::Lost, Self::Taken];

    fn name(self) -> &'static str {
        match self {
            Self::Faithful => "faithful",
            Self::Lost => "over samples, lost",
            Self::Taken => "over samples, taken in passing",
        }
    }
}

/// One reconstruction.
#[derive(Debug, Clone, Copy)]
pub struct Ordered {
    mesh: &'static str,
    /// Vertices of the true curve.
    vertices: usize,
    samples: usize,
    sampling: Sampling,
    walk: Walk,
    candidates: usize,
    ordered: bool,
}

/// Coarse meshes beside those of the record: here a curve of 100 vertices is a long one.
///
/// # Errors
/// Those of the library.
pub fn coarse() -> Result<Vec<Surface>> {
    let meshes = [
        ("sphere, 2,562", families::icosphere(4)?),
        ("torus, 1,500", families::torus(60, 25, 2.0, 0.8)?),
        ("genus 3, coarse", families::genus(3, 7)?),
    ];
    let surface = |(name, mesh)| Ok(Surface { name, mesh: scaled(&mesh)?, closed: true });
    meshes.into_iter().map(surface).collect()
}

/// Curves of a mesh, each sampled and walked in every way.
///
/// # Errors
/// Those of the library.
pub fn measure_orders(surface: &Surface, curves: usize, seed: u64) -> Result<Vec<Ordered>> {
    let mesh = &surface.mesh;
    let graph = Graph::of_mesh(mesh);
    let mut generator = Generator::new(&graph, seed)?;
    let mut rng = Rng::new(seed + 1);
    let mut solver = CurveSolver::new(mesh)?;
    let mut runs = Vec::new();
    for _ in 0..curves {
        let Some(curve) = generator.curve()? else { break };
        for count in SIZES {
            for sampling in [Sampling::Even, Sampling::Random] {
                let given = samples(&curve, count, sampling, &mut rng);
                for candidates in CANDIDATES {
                    let options = CurveOptions::new().mode(Mode::Faithful).candidates(candidates);
                    for kind in Walk::ALL {
                        let literal =
                            |p| walk(&graph, mesh.vertices(), &given.vertices, candidates, p);
                        let order = match kind {
                            Walk::Faithful => {
                                let found = solver.reconstruct(&given.vertices, &options)?;
                                found.curves.into_iter().next().map_or(Vec::new(), |c| c.order)
                            }
                            Walk::Lost => literal(Passed::Lost),
                            Walk::Taken => literal(Passed::Taken),
                        };
                        runs.push(Ordered {
                            mesh: surface.name,
                            vertices: curve.len(),
                            samples: count,
                            sampling,
                            walk: kind,
                            candidates,
                            ordered: same_order(&order, &given.order),
                        });
                    }
                }
            }
        }
    }
    Ok(runs)
}

/// Per cent in order, with the number of runs.
fn share<'r>(runs: impl Iterator<Item = &'r Ordered>) -> String {
    let (all, right) = runs.fold((0, 0), |(n, k), r| (n + 1, k + u32::from(r.ordered)));
    match all {
        0 => "-".into(),
        _ => format!("{:.1}", 100.0 * f64::from(right) / f64::from(all)),
    }
}

/// The tables.
pub fn density_tables(runs: &[Ordered]) -> String {
    let mut text = String::from(
        "**Right order by the share of the curve's vertices that are samples**, random sampling, per cent of runs, all \
         numbers of samples\n\n| walk | l |",
    );
    let mut low = 0.0;
    for high in CLASSES {
        text += &format!(" {:.0}-{:.0} % |", 100.0 * low, 100.0 * high);
        low = high;
    }
    text += &format!("\n|---|---|{}\n", "---|".repeat(CLASSES.len()));
    for walk in Walk::ALL {
        for candidates in CANDIDATES {
            text += &format!("| {} | {candidates} |", walk.name());
            let mut low = 0.0;
            for high in CLASSES {
                let own = runs.iter().filter(|r| {
                    let part = r.samples as f64 / r.vertices as f64;
                    (r.walk, r.candidates, r.sampling) == (walk, candidates, Sampling::Random)
                        && part > low
                        && part <= high
                });
                text += &format!(" {} |", share(own));
                low = high;
            }
            text.push('\n');
        }
    }
    text += "\n**100 random samples, by mesh**: vertices of a curve (mean), right order in per cent of runs\n\n| mesh | \
             vertices of a curve |";
    for walk in Walk::ALL {
        for candidates in CANDIDATES {
            text += &format!(" {}, l = {candidates} |", walk.name());
        }
    }
    text += &format!("\n|---|---|{}\n", "---|".repeat(9));
    let mut meshes: Vec<&str> = runs.iter().map(|r| r.mesh).collect();
    meshes.dedup();
    let rows = meshes.into_iter().map(Some).chain([None]);
    for mesh in rows {
        let own = || {
            runs.iter()
                .filter(move |r| mesh.is_none_or(|mesh| r.mesh == mesh))
                .filter(|r| r.samples == 100 && r.sampling == Sampling::Random)
        };
        let count = own().count().max(1);
        let mean = own().map(|r| r.vertices).sum::<usize>() as f64 / count as f64;
        text += &format!("| {} | {mean:.0} |", mesh.unwrap_or("all"));
        for walk in Walk::ALL {
            for candidates in CANDIDATES {
                text += &format!(
                    " {} |",
                    share(own().filter(|r| r.walk == walk && r.candidates == candidates))
                );
            }
        }
        text.push('\n');
    }
    text += &format!("| thesis | | {} |", THESIS.map(|x| x.to_string()).join(" | "));
    text += " | | | | | |\n";
    text
}
