//! The station of decimation: a figure with many vertices, by the thesis literally and by the
//! default.

use std::time::Instant;

use anyhow::Result;
use catamaran::Par;
use catamaran::base::Progress;
use catamaran::decimate::{
    DecimateOptions, Decimation, Difference, FarthestPoints, Method, Quality, decimate,
};
use catamaran::mesh::{TriMesh, families};

use super::Site;
use super::page::{Figure, Station, Table};
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
    render(&scene)?.write_png(site.file("decimated.png")?)?;
    drop(bar);
    Ok(describe(&mesh, &outcomes))
}

fn panel<'a>(mesh: &'a TriMesh, paint: Paint<'a>, title: &'a str) -> Panel<'a> {
    Panel { mesh, paint, view: VIEW, title }
}

/// The distances from a few farthest points.
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
    render(&scene)?.write_png(site.file("farthest.png")?)
}

fn describe(mesh: &TriMesh, outcomes: &[Outcome]) -> Station {
    let picture =
        |name: &str, alt: &str| format!("<img src=\"{name}\" alt=\"{alt}\" width=\"100%\">");
    let last = outcomes.last();
    let vertices = last.map_or(0, |outcome| outcome.found.mesh.vertices().len());
    Station {
        id: "decimate",
        title: "Decimation",
        text: "<p>A mesh with one vertex in a hundred, of triangles that are nearly equal: samples far from each other, \
               the dual of their cells as faces, vertices moved to the middle of their faces over the surface. The number \
               of vertices is exact, and components, boundary and handles are those of the input.</p>"
            .into(),
        numbers: vec![
            (mesh.vertices().len().to_string(), "vertices before"),
            (vertices.to_string(), "after"),
            (last.map_or_else(String::new, |o| format!("{:.0} ms", o.seconds * 1e3)), "default"),
            (
                last.map_or_else(String::new, |o| format!("{:.3}", o.quality.mean_quality)),
                "mean quality of triangles (1: equilateral)",
            ),
        ],
        figures: vec![
            Figure {
                body: picture("farthest.png", "Distances from farthest points"),
                caption: "Distances along edges from farthest points: each new one is where they are largest.".into(),
                wide: true,
            },
            Figure {
                body: picture("decimated.png", "The decimated figure"),
                caption: "Every three-cycle of cells a face, as the thesis has it, and the default.".into(),
                wide: true,
            },
        ],
        tables: vec![Table {
            caption: "Uniformity, and the distance of either surface from the other's vertices.".into(),
            head: vec![
                "method",
                "faces",
                "mean quality",
                "variation of areas",
                "non-manifold edges",
                "Hausdorff",
                "time",
            ],
            text_columns: 1,
            rows: outcomes
                .iter()
                .map(|o| {
                    vec![
                        o.name.into(),
                        o.found.mesh.faces().len().to_string(),
                        format!("{:.3}", o.quality.mean_quality),
                        format!("{:.3}", o.quality.area_variation),
                        o.quality.non_manifold_edges.to_string(),
                        format!("{:.3}", o.difference.hausdorff),
                        format!("{:.0} ms", o.seconds * 1e3),
                    ]
                })
                .collect(),
        }],
    }
}
