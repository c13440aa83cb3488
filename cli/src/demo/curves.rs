//! The station of curves: a curve of the generator, its samples, and what two ways make of them.

use std::time::Instant;

use anyhow::{Context, Result};
use catamaran::base::Rng;
use catamaran::curve::dataset::{Generator, Samples, Sampling, samples, scaled};
use catamaran::curve::{CurveOptions, CurveSolver, Mode, Reconstruction, same_order};
use catamaran::mesh::{Graph, TriMesh, families};

use super::Site;
use super::page::{Figure, Station, Table};
use crate::picture::{Paint, Panel, Scene, Up, View, render, with_curves};
use crate::progress::Bar;

/// Samples of the curve that is shown, and of those in the table.
const SHOWN: usize = 25;
const SIZES: [usize; 3] = [10, 25, 55];
/// Curves in the table, and the same when small inputs are wanted.
const CURVES: usize = 12;
const SMALL_CURVES: usize = 3;
const SEED: u64 = 11;

/// One line of the table, of `runs` reconstructions.
#[derive(Default)]
struct Line {
    runs: usize,
    closed: usize,
    ordered: usize,
    seconds: f64,
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
    Ok(describe(&mesh, &lines, shown.unwrap_or_default()))
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
    render(&scene)?.write_png(site.file("curves.png")?)
}

fn describe(mesh: &TriMesh, lines: &[[Line; 2]], path: usize) -> Station {
    let all = |mode: usize| {
        lines.iter().fold(Line::default(), |sum, line| Line {
            runs: sum.runs + line[mode].runs,
            closed: sum.closed + line[mode].closed,
            ordered: sum.ordered + line[mode].ordered,
            seconds: sum.seconds + line[mode].seconds,
        })
    };
    let per_cent = |part: usize, line: &Line| {
        format!("{:.0} %", 100.0 * part as f64 / line.runs.max(1) as f64)
    };
    let (robust, mut rows) = (all(1), Vec::new());
    for (line, k) in lines.iter().zip(SIZES) {
        for (line, mode) in line.iter().zip(["faithful, l = 5", "robust"]) {
            rows.push(vec![
                mode.to_owned(),
                k.to_string(),
                per_cent(line.closed, line),
                per_cent(line.ordered, line),
                format!("{:.1} ms", 1e3 * line.seconds / line.runs.max(1) as f64),
            ]);
        }
    }
    Station {
        id: "curves",
        title: "Curves through samples",
        text: "<p>Samples of a closed curve on a surface, in no order. Going from one to the next (the thesis' algorithm) \
               can end in a corner that the curve itself has closed; deciding the order of all first, and then letting \
               paths give way to one another, can't.</p>"
            .into(),
        numbers: vec![
            (mesh.vertices().len().to_string(), "vertices of the surface"),
            (path.to_string(), "vertices of the curve that is shown"),
            (per_cent(robust.closed, &robust), "of the robust mode's curves are closed"),
            (
                format!("{:.0} ms", 1e3 * robust.seconds / robust.runs.max(1) as f64),
                "for one of them",
            ),
        ],
        figures: vec![Figure {
            body: "<img src=\"curves.png\" alt=\"Samples on a torus and two curves through them\" width=\"100%\">".into(),
            caption: format!("{SHOWN} samples of a curve, and what the two modes make of them."),
            wide: true,
        }],
        tables: vec![Table {
            caption: "Curves of the generator, evenly sampled: closed ones, and those in the right order.".into(),
            head: vec!["mode", "samples", "closed", "right order", "time"],
            text_columns: 1,
            rows,
        }],
    }
}
