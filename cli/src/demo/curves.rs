//! The station of curves: a curve of the generator, its samples, and what two ways make of them.

use std::time::Instant;

use anyhow::{Context, Result};
use catamaran::base::Rng;
use catamaran_geometry::curve::dataset::{Generator, Samples, Sampling, samples, scaled};
use catamaran_geometry::curve::{
    Curve, CurveOptions, CurveSolver, Drawing, Mode, Reconstruction, Region, Side, cut, same_order,
};
use catamaran_geometry::mesh::{Components, Graph, TriMesh, families};
use minijinja::context;

use super::Site;
use super::page::Station;
use crate::picture::{Paint, Panel, Scene, Up, View, render, with_curves};

type Rgb = [u8; 3];
use crate::progress::Bar;

/// Samples of the curve that is shown, and of those in the table.
const SHOWN: usize = 25;
const SIZES: [usize; 3] = [10, 25, 55];
/// Curves in the table, and the same when small inputs are wanted.
const CURVES: usize = 12;
const SMALL_CURVES: usize = 3;
const SEED: u64 = 11;

/// Cells around the torus of the regions, and around its tube.
const AROUND: u32 = 160;
const TUBE: u32 = 70;
const INSIDE: Rgb = [245, 174, 64];
const OUTSIDE: Rgb = [205, 214, 224];
/// Colours of the pieces of the mesh that is cut.
const PIECES: [Rgb; 4] = [OUTSIDE, [245, 174, 64], [120, 182, 130], [110, 156, 214]];
/// How far apart pieces are drawn.
const APART: f64 = 0.12;

/// One line of the table, of `runs` reconstructions.
#[derive(Default)]
struct Line {
    runs: usize,
    closed: usize,
    ordered: usize,
    seconds: f64,
}

impl Line {
    fn sum(self, other: &Self) -> Self {
        Self {
            runs: self.runs + other.runs,
            closed: self.closed + other.closed,
            ordered: self.ordered + other.ordered,
            seconds: self.seconds + other.seconds,
        }
    }

    fn per_cent(&self, part: usize) -> String {
        format!("{:.0}", 100.0 * part as f64 / self.runs.max(1) as f64)
    }

    /// Returns the mean milliseconds of a run.
    fn milliseconds(&self) -> f64 {
        1e3 * self.seconds / self.runs.max(1) as f64
    }
}

/// Computes and describes it.
pub fn station(site: &Site<'_>) -> Result<Station> {
    let bar = Bar::new("curves");
    let mesh = scaled(&families::torus(160, 70, 2.0, 0.9)?)?;
    let graph = Graph::of_mesh(&mesh);
    let mut generator = Generator::new(&graph, SEED)?;
    let mut solver = CurveSolver::new(&mesh)?;
    let mut rng = Rng::new(SEED);
    let count = if site.small { SMALL_CURVES } else { CURVES };
    let mut lines: [[Line; 2]; SIZES.len()] = Default::default();
    let mut shown = None;
    for number in 0..count {
        bar.step(number as f64 / count as f64)?;
        let curve = generator.curve()?.context("no curve on the torus")?;
        for (lines, k) in lines.iter_mut().zip(SIZES) {
            let given = samples(&curve, k, Sampling::Even, &mut rng);
            let found = [Mode::Faithful, Mode::Robust].map(|mode| {
                let start = Instant::now();
                let options = CurveOptions::new().mode(mode);
                let found = solver.reconstruct(&given.vertices, &options);
                (found, start.elapsed().as_secs_f64())
            });
            let mut both = Vec::new();
            for ((found, seconds), line) in found.into_iter().zip(lines) {
                let found = found?;
                line.runs += 1;
                line.closed += usize::from(found.outcome.is_complete());
                line.ordered += usize::from(is_right(&found, &given));
                line.seconds += seconds;
                both.push(found);
            }
            if k == SHOWN && shown.is_none() {
                picture(site, &mesh, &given, &both)?;
                shown = Some(both[1].curves.first().map_or(0, |c| c.path.len()));
            }
        }
    }
    drop(bar);
    regions(site)?;
    describe(&mesh, &lines, shown.unwrap_or_default())
}

/// Draws two selections of a few samples each, what sets make of them, and the mesh in pieces.
fn regions(site: &Site<'_>) -> Result<()> {
    let mesh = scaled(&families::torus(AROUND as usize, TUBE as usize, 2.0, 0.9)?)?;
    let mut drawing = Drawing::new(mesh)?;
    // Of ellipses, without an order: by steps of three.
    let ellipse = |along: f64, across: f64| -> Vec<u32> {
        let corner = |i: u32| {
            let angle = f64::from(3 * i % 8) * std::f64::consts::TAU / 8.0;
            let x = (along + 17.0 * angle.cos()).round().rem_euclid(f64::from(AROUND)) as u32;
            let y = (across + 12.0 * angle.sin()).round().rem_euclid(f64::from(TUBE)) as u32;
            x * TUBE + y
        };
        (0..8).map(corner).collect()
    };
    let layers = [ellipse(-42.0, 12.0), ellipse(-25.0, 18.0)];
    for layer in &layers {
        drawing.add(layer, &CurveOptions::new())?;
    }
    drawing.smooth()?;
    let drawn = drawing.inscribe()?;
    let whole = &drawn.refined.mesh;
    let walls = |curves: &[Curve]| curves.iter().flat_map(Curve::edges).collect::<Vec<_>>();
    let [a, b] = [0, 1].map(|i| Region::enclosed(whole, &walls(&drawn.layers[i]), &Side::Small));
    let (a, b) = (a?, b?);
    let open = cut(whole, &walls(&drawn.layers.concat()))?;
    let places: Vec<_> = layers.concat().iter().map(|&v| whole.vertices()[v as usize]).collect();
    let mut painted = Vec::new();
    for region in [a.union(&b)?, a.intersection(&b)?, a.difference(&b)?] {
        let (mesh, mut colors) = with_curves(&open.mesh, &drawn.layers.concat(), &places)?;
        colors[..open.mesh.vertices().len()].fill(OUTSIDE);
        for v in region.faces().iter().flat_map(|&f| open.mesh.faces()[f as usize]) {
            colors[v as usize] = INSIDE;
        }
        painted.push((mesh, colors));
    }
    painted.push(apart(&open.mesh)?);
    let view = View { azimuth: 20.0, elevation: 50.0, up: Up::Z, ..View::DEFAULT };
    let titles = ["union", "intersection", "difference", "cut into pieces"];
    let panels = painted.iter().zip(titles).map(|((mesh, colors), title)| Panel {
        mesh,
        paint: Paint::Colors(colors),
        view,
        title,
    });
    let scene = Scene { panels: panels.collect(), size: (420, 380), ..Scene::default() };
    render(&scene)?.write(site.file("regions.png")?)
}

/// Returns the components of a mesh, each of its colour and moved away from the middle of the
/// first.
fn apart(mesh: &TriMesh) -> Result<(TriMesh, Vec<Rgb>)> {
    let components = Components::new(mesh);
    let middle = |c: u32| {
        let own = components.of_vertices().iter().zip(mesh.vertices()).filter(|(of, _)| **of == c);
        let (sum, count) = own.fold(([0.0; 3], 0.0), |(sum, count): ([f64; 3], f64), (_, p)| {
            (std::array::from_fn(|k| sum[k] + p[k]), count + 1.0)
        });
        sum.map(|x: f64| x / count)
    };
    let largest = components.largest().unwrap_or_default() as u32;
    let from = middle(largest);
    let moves: Vec<[f64; 3]> = (0..components.len() as u32)
        .map(|c| {
            let to = middle(c);
            let away: [f64; 3] = std::array::from_fn(|k| to[k] - from[k]);
            let length = away.iter().map(|x| x * x).sum::<f64>().sqrt();
            if c == largest { [0.0; 3] } else { away.map(|x| APART * x / length) }
        })
        .collect();
    let (mut vertices, faces) = mesh.clone().into_parts();
    let mut colors = Vec::new();
    for (p, &c) in vertices.iter_mut().zip(components.of_vertices()) {
        let step = moves[c as usize];
        *p = std::array::from_fn(|k| p[k] + step[k]);
        colors.push(PIECES[(c as usize + PIECES.len() - largest as usize) % PIECES.len()]);
    }
    Ok((TriMesh::new(vertices, faces)?, colors))
}

fn is_right(found: &Reconstruction, given: &Samples) -> bool {
    matches!(&found.curves[..], [curve] if same_order(&curve.order, &given.order))
}

fn picture(
    site: &Site<'_>,
    mesh: &TriMesh,
    given: &Samples,
    found: &[Reconstruction],
) -> Result<()> {
    let places: Vec<_> = given.vertices.iter().map(|&v| mesh.vertices()[v as usize]).collect();
    let painted = [
        with_curves(mesh, &[], &places)?,
        with_curves(mesh, &found[0].curves, &places)?,
        with_curves(mesh, &found[1].curves, &places)?,
    ];
    let view = View { azimuth: 20.0, elevation: 50.0, up: Up::Z, ..View::DEFAULT };
    let titles = ["samples", "from sample to sample", "order first"];
    let panels = painted.iter().zip(titles).map(|((mesh, colors), title)| Panel {
        mesh,
        paint: Paint::Colors(colors),
        view,
        title,
    });
    let scene = Scene { panels: panels.collect(), size: (520, 460), ..Scene::default() };
    render(&scene)?.write(site.file("curves.png")?)
}

fn describe(mesh: &TriMesh, lines: &[[Line; 2]], path: usize) -> Result<Station> {
    let robust = lines.iter().fold(Line::default(), |sum, [_, robust]| sum.sum(robust));
    let mut rows = Vec::new();
    for (line, samples) in lines.iter().zip(SIZES) {
        for (line, mode) in line.iter().zip(["faithful, l = 5", "robust"]) {
            rows.push(context! {
                mode,
                samples,
                closed => line.per_cent(line.closed),
                ordered => line.per_cent(line.ordered),
                milliseconds => format!("{:.1}", line.milliseconds()),
            });
        }
    }
    let values = context! {
        vertices => mesh.vertices().len(),
        path,
        robust => context! {
            closed => robust.per_cent(robust.closed),
            milliseconds => format!("{:.0}", robust.milliseconds()),
        },
        shown => SHOWN,
        lines => rows,
    };
    Station::new("curves", "Curves through samples", include_str!("stations/curves.html"), values)
}
