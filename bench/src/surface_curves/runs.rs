use std::time::Instant;

use catamaran::base::Rng;
use catamaran_geometry::curve::dataset::{Generator, Sampling, samples};
use catamaran_geometry::curve::{CurveOptions, CurveSolver, Mode, Outcome, same_order};
use catamaran_geometry::mesh::Graph;

use super::Surface;
use super::distances::{hausdorff, root_mean_distance, root_mean_square_distance};
use crate::Result;

/// Numbers of samples.
pub const SIZES: [usize; 7] = [10, 25, 40, 55, 70, 85, 100];

/// The method of reconstruction.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub enum Method {
    /// The thesis' algorithm with this many candidates.
    Faithful(usize),
    /// The robust mode of this library.
    Robust,
}

impl Method {
    /// All methods, in the order of tables.
    pub const ALL: [Self; 4] =
        [Self::Faithful(1), Self::Faithful(3), Self::Faithful(5), Self::Robust];

    /// Returns the name in tables.
    pub fn name(self) -> String {
        match self {
            Self::Faithful(candidates) => format!("faithful, l = {candidates}"),
            Self::Robust => "robust".into(),
        }
    }

    fn options(self) -> CurveOptions<'static> {
        match self {
            Self::Faithful(candidates) => {
                CurveOptions::new().mode(Mode::Faithful).candidates(candidates)
            }
            Self::Robust => CurveOptions::default(),
        }
    }
}

/// The result of one reconstruction.
#[derive(Debug, Clone, Copy)]
pub struct Run {
    /// The mesh.
    pub mesh: &'static str,
    /// Number of vertices of the mesh.
    pub vertices: usize,
    /// Whether it is connected and without boundary.
    pub closed_mesh: bool,
    /// Number of samples.
    pub samples: usize,
    /// The method by which samples were selected.
    pub sampling: Sampling,
    /// The method of reconstruction.
    pub method: Method,
    /// Whether the curve is closed, through all samples.
    pub closed: bool,
    /// Whether it is closed, and has no Steiner points.
    pub on_vertices: bool,
    /// Whether there is one curve with the samples in their order.
    pub ordered: bool,
    /// Hausdorff distance to the true curve.
    pub hausdorff: f64,
    /// R as printed in the thesis.
    pub root_mean: f64,
    /// R with squares.
    pub root_mean_square: f64,
    /// Seconds, without the creation of the solver.
    pub seconds: f64,
}

/// Generates `curves` curves on a mesh and reconstructs each from samples of every size and kind by
/// every method.
///
/// # Errors
/// The errors of the library.
pub fn measure(surface: &Surface, curves: usize, seed: u64) -> Result<Vec<Run>> {
    let mesh = &surface.mesh;
    let graph = Graph::of_mesh(mesh);
    let mut generator = Generator::new(&graph, seed)?;
    let mut rng = Rng::new(seed + 1);
    let mut solver = CurveSolver::new(mesh)?;
    let mut runs = Vec::new();
    for _ in 0..curves {
        let Some(curve) = generator.curve()? else { break };
        let truth: Vec<[f64; 3]> = curve.iter().map(|&v| mesh.vertices()[v as usize]).collect();
        for count in SIZES {
            for sampling in [Sampling::Even, Sampling::Random] {
                let given = samples(&curve, count, sampling, &mut rng);
                for method in Method::ALL {
                    let start = Instant::now();
                    let found = solver.reconstruct(&given.vertices, &method.options())?;
                    let seconds = start.elapsed().as_secs_f64();
                    let points: Vec<[f64; 3]> =
                        found.curves.iter().flat_map(|c| c.points.iter().copied()).collect();
                    let closed = found.outcome == Outcome::Closed;
                    let single = found.curves.len() == 1;
                    runs.push(Run {
                        mesh: surface.name,
                        vertices: mesh.vertices().len(),
                        closed_mesh: surface.closed,
                        samples: count,
                        sampling,
                        method,
                        closed,
                        on_vertices: closed && found.steiner.is_empty(),
                        ordered: single && same_order(&found.curves[0].order, &given.order),
                        hausdorff: hausdorff(&truth, &points),
                        root_mean: root_mean_distance(&truth, &points),
                        root_mean_square: root_mean_square_distance(&truth, &points),
                        seconds,
                    });
                }
            }
        }
    }
    Ok(runs)
}
