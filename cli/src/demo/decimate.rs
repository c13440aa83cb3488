//! The station of decimation: a figure with many vertices, by the thesis literally and by the
//! default.

use std::time::Instant;

use anyhow::{Context, Result};
use catamaran::Par;
use catamaran::base::Progress;
use catamaran_geometry::decimate::{
    DecimateOptions, Decimation, Difference, FarthestPoints, Method, Quality, decimate,
};
use catamaran_geometry::mesh::{TriMesh, families};
use minijinja::context;
use minijinja::value::Value;

use super::Site;
use super::page::Station;
use crate::picture::{PLAIN, Paint, Panel, Scene, Up, View, render};
use crate::progress::Bar;

/// Size of the figure (F = 300 cells^2), and the same when small inputs are wanted.
const CELLS: usize = 40;
const SMALL_CELLS: usize = 12;
/// Vertices of the input for one of the result.
const REDUCTION: usize = 120;
/// Samples whose cells are shown.
const SHOWN: usize = 60;

const VIEW: View = View { azimuth: 20.0, elevation: 8.0, up: Up::Z, ..View::DEFAULT };

/// One line of the table.
struct Outcome {
    name: &'static str,
    found: Decimation,
    quality: Quality,
    difference: Difference,
    seconds: f64,
}

/// Computes and describes it.
pub fn station(site: &Site<'_>) -> Result<Station> {
    let bar = Bar::new("decimate");
    let mesh = families::figure(if site.small { SMALL_CELLS } else { CELLS }, 0.4)?;
    let n = mesh.vertices().len() / REDUCTION;
    cells(site, &mesh)?;
    bar.step(0.3)?;
    let methods = [("thesis literally", Method::Thesis), ("default", Method::Uniform)];
    let mut outcomes = Vec::new();
    for (name, method) in methods {
        let start = Instant::now();
        let found = decimate(&mesh, n, &DecimateOptions::new().method(method))?;
        let seconds = start.elapsed().as_secs_f64();
        let quality = Quality::of(&found.mesh);
        let difference = Difference::between(&mesh, &found.mesh, Par::all())?;
        outcomes.push(Outcome { name, found, quality, difference, seconds });
    }
    bar.step(0.8)?;
    let panels = outcomes.iter().map(|outcome| panel(&outcome.found.mesh, PLAIN, outcome.name));
    let scene = Scene {
        panels: panels.collect(),
        size: (620, 680),
        edges: true,
        smooth: false,
        ..Scene::default()
    };
    render(&scene)?.write(site.file("decimated.png")?)?;
    drop(bar);
    describe(&mesh, &outcomes)
}

fn panel<'a>(mesh: &'a TriMesh, paint: Paint<'a>, title: &'a str) -> Panel<'a> {
    Panel { mesh, paint, view: VIEW, title }
}

/// Draws the distances from a few farthest points.
fn cells(site: &Site<'_>, mesh: &TriMesh) -> Result<()> {
    let mut points = FarthestPoints::new(mesh, None)?;
    let mut distances = Vec::new();
    for n in [SHOWN / 10, SHOWN] {
        points.extend_to(n, Progress::none())?;
        let far: Vec<f64> = points.cells().distances().iter().map(|&d| f64::from(d)).collect();
        distances.push((far, format!("{n} samples")));
    }
    let panels =
        distances.iter().map(|(values, title)| panel(mesh, Paint::Values(values), title)).collect();
    let scene = Scene { panels, size: (620, 680), legend: false, ..Scene::default() };
    render(&scene)?.write(site.file("farthest.png")?)
}

fn describe(mesh: &TriMesh, outcomes: &[Outcome]) -> Result<Station> {
    let default = outcomes.last().context("no method")?;
    let values = context! {
        vertices => mesh.vertices().len(),
        default => context! {
            vertices => default.found.mesh.vertices().len(),
            ..row(default)
        },
        outcomes => outcomes.iter().map(row).collect::<Vec<_>>(),
    };
    Station::new("decimate", "Decimation", include_str!("stations/decimate.html"), values)
}

/// Returns a row of the table.
fn row(outcome: &Outcome) -> Value {
    let Outcome { name, found, quality, difference, seconds } = outcome;
    context! {
        name => *name,
        faces => found.mesh.faces().len(),
        mean_quality => format!("{:.3}", quality.mean_quality),
        area_variation => format!("{:.3}", quality.area_variation),
        non_manifold_edges => quality.non_manifold_edges,
        hausdorff => format!("{:.3}", difference.hausdorff),
        milliseconds => format!("{:.0}", seconds * 1e3),
    }
}
