//! Compares table 6.2 of the thesis (random samples) with ours: the kind of curve decides. Curves
//! of the generator of section 6.4.1 are compared with geodesic circles on the same meshes, and
//! with a circle in the plane.

use catamaran::base::Rng;
use catamaran_geometry::curve::dataset::{Generator, LEAST_VERTICES, Sampling, samples};
use catamaran_geometry::curve::{CurveOptions, CurveSolver, Mode, same_order};
use catamaran_geometry::mesh::{Dijkstra, Edges, Graph, SearchLimits, TriMesh};

use super::literal::{Passed, walk};
use super::{SIZES, Surface};
use crate::Result;

/// Numbers of candidates of the heuristic.
const CANDIDATES: [usize; 3] = [1, 3, 5];
/// Number of centres to try for a circle.
const ATTEMPTS: usize = 200;
/// Number of trials on the circle in the plane.
const TRIALS: usize = 2000;
/// The thesis' table 6.2, l = 1, 3, 5.
const THESIS: [[f64; 7]; 3] = [
    [60.69, 14.13, 34.34, 28.90, 34.20, 28.84, 22.57],
    [63.43, 24.88, 39.81, 36.60, 37.88, 41.35, 29.22],
    [63.11, 32.12, 41.72, 39.33, 39.61, 41.62, 30.82],
];

/// The kind of the true curve.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Kind {
    /// A walk of section 6.4.1.
    Walk,
    /// The border of the vertices within some distance of one.
    Circle,
}

/// The method that joined the samples.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum By {
    /// The library's faithful mode: paths avoid samples that are not yet visited.
    Faithful,
    /// The text: paths run over such samples, which are lost.
    Lost,
    /// The text: paths run over such samples, which are taken in passing.
    Taken,
    /// The library's robust mode.
    Robust,
}

/// One reconstruction.
#[derive(Debug, Clone, Copy)]
pub struct Ordered {
    mesh: &'static str,
    kind: Kind,
    /// Vertices of the true curve.
    vertices: usize,
    samples: usize,
    by: By,
    candidates: usize,
    ordered: bool,
}

/// Measures curves of both kinds on a mesh, each sampled at random and joined by every method.
///
/// # Errors
/// The errors of the library.
pub fn measure_orders(surface: &Surface, curves: usize, seed: u64) -> Result<Vec<Ordered>> {
    let mesh = &surface.mesh;
    let graph = Graph::of_mesh(mesh);
    let mut generator = Generator::new(&graph, seed)?;
    let mut rng = Rng::new(seed + 1);
    let mut solver = CurveSolver::new(mesh)?;
    let mut runs = Vec::new();
    for kind in [Kind::Walk, Kind::Circle] {
        for _ in 0..curves {
            let curve = match kind {
                Kind::Walk => generator.curve()?,
                Kind::Circle => circle(mesh, &graph, &mut rng)?,
            };
            let Some(curve) = curve else { break };
            for count in SIZES {
                let given = samples(&curve, count, Sampling::Random, &mut rng);
                let mut run = |by, candidates, order: &[u32]| {
                    runs.push(Ordered {
                        mesh: surface.name,
                        kind,
                        vertices: curve.len(),
                        samples: count,
                        by,
                        candidates,
                        ordered: same_order(order, &given.order),
                    });
                };
                let found = solver.reconstruct(&given.vertices, &CurveOptions::new())?;
                match &found.curves[..] {
                    [one] => run(By::Robust, 0, &one.order),
                    _ => run(By::Robust, 0, &[]),
                }
                for candidates in CANDIDATES {
                    let options = CurveOptions::new().mode(Mode::Faithful).candidates(candidates);
                    let found = solver.reconstruct(&given.vertices, &options)?;
                    run(By::Faithful, candidates, &found.curves[0].order);
                    for (by, passed) in [(By::Lost, Passed::Lost), (By::Taken, Passed::Taken)] {
                        let places = mesh.vertices();
                        let order = walk(&graph, places, &given.vertices, candidates, passed);
                        run(by, candidates, &order);
                    }
                }
            }
        }
    }
    Ok(runs)
}

/// Returns the border of a geodesic disk, with at least as many vertices as a curve of the
/// generator.
fn circle(mesh: &TriMesh, graph: &Graph, rng: &mut Rng) -> Result<Option<Vec<u32>>> {
    let mut search = Dijkstra::new(graph);
    for _ in 0..ATTEMPTS {
        let centre = (rng.bits() % graph.len() as u64) as u32;
        search.search(&[(centre, 0.0)], &SearchLimits::default())?;
        let distances = search.distances();
        let farthest = distances.iter().copied().filter(|d| d.is_finite()).fold(0.0, f64::max);
        let radius = farthest * (0.2 + 0.6 * rng.uniform());
        let mask: Vec<bool> = distances.iter().map(|&d| d <= radius).collect();
        let part = mesh.masked(&mask)?;
        let Ok(loops) = part.mesh.boundary_loops(&Edges::new(&part.mesh)) else { continue };
        let Some(longest) = loops.into_iter().max_by_key(Vec::len) else { continue };
        let curve: Vec<u32> = longest.iter().map(|&v| part.vertices[v as usize]).collect();
        let mut each = curve.clone();
        each.sort_unstable();
        each.dedup();
        if curve.len() >= LEAST_VERTICES && each.len() == curve.len() {
            return Ok(Some(curve));
        }
    }
    Ok(None)
}

/// Returns the percentage of random samples of a circle whose order the nearest neighbour finds,
/// when no strands are near each other: at each step the nearer one of both ends of the gap.
fn ideal(samples: usize, rng: &mut Rng) -> f64 {
    let right = (0..TRIALS).filter(|_| {
        let mut places: Vec<f64> = (0..samples).map(|_| rng.uniform()).collect();
        places.sort_by(f64::total_cmp);
        let start = (rng.bits() % samples as u64) as usize;
        let next = |i: usize| (i + 1) % samples;
        let before = |i: usize| (i + samples - 1) % samples;
        let distance = |i: usize, j: usize| {
            let d = (places[i] - places[j]).abs();
            d.min(1.0 - d)
        };
        let (mut at, mut low, mut high) = (start, before(start), next(start));
        let mut turns = [0, 0];
        for _ in 1..samples {
            let ahead = distance(at, high) < distance(at, low);
            if ahead {
                (at, high) = (high, next(high));
            } else {
                (at, low) = (low, before(low));
            }
            turns[usize::from(ahead)] += 1;
        }
        // The last sample is next in both directions.
        turns.contains(&0)
            || turns.contains(&1) && at == if turns[0] == 1 { before(start) } else { next(start) }
    });
    100.0 * right.count() as f64 / TRIALS as f64
}

/// Returns the percentage of runs in order.
fn share<'r>(runs: impl Iterator<Item = &'r Ordered>) -> String {
    let (all, right) = runs.fold((0_u32, 0_u32), |(n, k), r| (n + 1, k + u32::from(r.ordered)));
    match all {
        0 => "-".into(),
        _ => format!("{:.1}", 100.0 * f64::from(right) / f64::from(all)),
    }
}

/// Columns of the record.
pub const ORDERS_HEAD: &str = "mesh,curve,vertices,samples,joined,candidates,ordered";

impl Ordered {
    /// Returns a line of CSV.
    pub fn line(&self) -> String {
        format!(
            "{},{:?},{},{},{:?},{},{}",
            self.mesh,
            self.kind,
            self.vertices,
            self.samples,
            self.by,
            self.candidates,
            self.ordered
        )
    }
}

/// Returns the tables.
pub fn order_tables(runs: &[Ordered]) -> String {
    let head = |first: &str| {
        format!(
            "| {first} | l | {} |\n|---|---|{}\n",
            SIZES.map(|k| k.to_string()).join(" | "),
            "---|".repeat(SIZES.len())
        )
    };
    let row = |name: &str, l: &str, cells: [String; SIZES.len()]| {
        format!("| {name} | {l} | {} |\n", cells.join(" | "))
    };
    let of = |kind, by, candidates| {
        let own = move |r: &&Ordered| (r.kind, r.by, r.candidates) == (kind, by, candidates);
        runs.iter().filter(own)
    };
    let cells = |kind, by, l| SIZES.map(|k| share(of(kind, by, l).filter(|r| r.samples == k)));
    let mut text = String::from(
        "**Right order of random samples, by what the curves are**, per cent of runs\n\n",
    );
    text += &head("curves");
    let kinds = [(Kind::Walk, "walks (section 6.4.1)"), (Kind::Circle, "geodesic circles")];
    for (kind, name) in kinds {
        for l in CANDIDATES {
            text +=
                &row(&format!("{name}, faithful"), &l.to_string(), cells(kind, By::Faithful, l));
        }
        text += &row(&format!("{name}, robust"), "", cells(kind, By::Robust, 0));
    }
    let mut rng = Rng::new(1);
    text += &row(
        "a circle in the plane, nearest neighbour",
        "1",
        SIZES.map(|k| format!("{:.1}", ideal(k, &mut rng))),
    );
    for (l, numbers) in CANDIDATES.iter().zip(THESIS) {
        text += &row("thesis, table 6.2", &l.to_string(), numbers.map(|x| x.to_string()));
    }
    text += "\n**The same walks, by what becomes of samples that a path runs over**\n\n";
    text += &head("samples in the way");
    for (by, name) in [
        (By::Faithful, "are kept clear of"),
        (By::Lost, "are lost (the text)"),
        (By::Taken, "are taken in passing"),
    ] {
        for l in CANDIDATES {
            text += &row(name, &l.to_string(), cells(Kind::Walk, by, l));
        }
    }
    text += "\n**100 random samples, by mesh**, faithful: mean number of vertices of a \
             curve, right order in per cent\n\n| mesh | walk: vertices | l = 1 | l = 5 | circle: \
             vertices | l = 1 | l = 5 |\n|---|---|---|---|---|---|---|\n";
    let mut meshes: Vec<&str> = runs.iter().map(|r| r.mesh).collect();
    meshes.dedup();
    for mesh in meshes {
        text += &format!("| {mesh} |");
        for (kind, _) in kinds {
            let own =
                |l| of(kind, By::Faithful, l).filter(move |r| r.mesh == mesh && r.samples == 100);
            let count = own(1).count().max(1);
            let mean = own(1).map(|r| r.vertices).sum::<usize>() as f64 / count as f64;
            text += &format!(" {mean:.0} | {} | {} |", share(own(1)), share(own(5)));
        }
        text.push('\n');
    }
    text
}
