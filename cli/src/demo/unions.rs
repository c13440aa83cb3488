//! The station of spectral unions: two parts of a figure in two poses, and the spectrum of what
//! they make together.

use std::time::Instant;

use anyhow::Result;
use catamaran::Par;
use catamaran_geometry::mesh::{LaplacianOptions, TriMesh};
use catamaran_geometry::unions::{K, PartSpectra, SpectralUnion};
use catamaran_training::dataset::DatasetOptions;
use catamaran_training::families::{Family, Model};
use minijinja::context;

use super::Site;
use super::page::Station;
use crate::picture::{Paint, Panel, Scene, Up, View, render};
use crate::progress::Bar;

/// Vertices of the figure, about, and the same when small inputs are wanted.
const VERTICES: usize = 2500;
const SMALL_VERTICES: usize = 1200;
/// A figure that no data set has.
const SEED: u64 = 77;
/// Where the parts begin and end, as shares of the height.
const PARTS: [[f64; 2]; 2] = [[0.5, 1.1], [0.2, 0.65]];
/// Eigenvalues in the table.
const SHOWN: [usize; 6] = [1, 2, 5, 10, 15, 20];

/// Figures stand along z.
const VIEW: View = View { up: Up::Z, ..View::DEFAULT };

/// Computes and describes it.
pub fn station(site: &Site<'_>) -> Result<Station> {
    let bar = Bar::new("unions");
    let count = if site.small { SMALL_VERTICES } else { VERTICES };
    let figure = Model::new(Family::Humanoid, count)?;
    bar.step(0.4)?;
    let poses = [figure.shape(SEED, 0, 0, 0)?, figure.shape(SEED, 0, 0, 1)?];
    let masks = PARTS.map(|[low, high]| between(figure.template(), low, high));
    let both: Vec<bool> = masks[0].iter().zip(&masks[1]).map(|(a, b)| *a || *b).collect();
    let spectrum = |mesh: &TriMesh, mask: &[bool]| {
        PartSpectra::new(mesh, &LaplacianOptions::default())?.dirichlet(mask, K)
    };
    let parts = [spectrum(&poses[0], &masks[0])?, spectrum(&poses[1], &masks[1])?];
    let truth = spectrum(&poses[0], &both)?;
    let model = SpectralUnion::pretrained()?;
    let start = Instant::now();
    let found = model.predict(&parts[0], &parts[1])?;
    let seconds = start.elapsed().as_secs_f64();
    let ood_score = model.ood_score(&[&parts[0], &parts[1]])?;
    bar.step(0.8)?;

    let training = Model::new(Family::Humanoid, DatasetOptions::default().vertices)?;
    let on = model.localizer().on_mesh(training.template(), Par::all())?;
    let located = on.indicator(&model.locate(&[&parts[0], &parts[1]])?)?;
    let located = located.into_iter().map(|x| x.clamp(0.0, 1.0)).collect();
    let painted = [values(&masks[0]), values(&masks[1]), values(&both), located];
    let meshes = [&poses[0], &poses[1], figure.template(), training.template()];
    let titles = ["first part", "second part, another pose", "their union", "found by the network"];
    let panels = meshes.into_iter().zip(&painted).zip(titles).map(|((mesh, values), title)| {
        Panel { mesh, paint: Paint::Values(values), view: VIEW, title }
    });
    let scene =
        Scene { panels: panels.collect(), size: (420, 560), legend: false, ..Scene::default() };
    render(&scene)?.write(site.file("unions.png")?)?;
    drop(bar);

    let error = |values: &dyn Fn(usize) -> f64| {
        100.0 * (0..K).map(|i| (values(i) / truth[i] - 1.0).abs()).sum::<f64>() / K as f64
    };
    let row = |&i: &usize| {
        let cells = [parts[0][i - 1], parts[1][i - 1], found[i - 1], truth[i - 1]];
        std::iter::once(i.to_string()).chain(cells.map(|x| format!("{x:.2}"))).collect()
    };
    let values = context! {
        errors => context! {
            predicted => format!("{:.1}", error(&|i| found[i])),
            smaller_of_parts => format!("{:.0}", error(&|i| parts[0][i].min(parts[1][i]))),
        },
        microseconds => format!("{:.0}", 1e6 * seconds),
        ood_score => format!("{ood_score:.2}"),
        eigenvalues => SHOWN.iter().map(row).collect::<Vec<Vec<_>>>(),
    };
    Station::new("unions", "Spectral unions", include_str!("stations/unions.html"), values)
}

/// Returns the vertices between two shares of the height.
fn between(mesh: &TriMesh, low: f64, high: f64) -> Vec<bool> {
    let [bottom, top] = mesh.bounding_box().unwrap_or_default();
    let at = |share: f64| bottom[2] + share * (top[2] - bottom[2]);
    mesh.vertices().iter().map(|p| (at(low)..=at(high)).contains(&p[2])).collect()
}

fn values(mask: &[bool]) -> Vec<f64> {
    mask.iter().map(|&inside| f64::from(u8::from(inside))).collect()
}
