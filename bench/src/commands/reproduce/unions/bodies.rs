//! Bodies that no training has: their parts as point clouds (figure 2.8), and predicted spectra.

use catamaran::Par;
use catamaran_bench::spectral::thesis::Data;
use catamaran_bench::{Result, input};
use catamaran_training::evaluate::{
    Bodies, CloudError, Frame, REAL_SHAPES, body_clouds, errors, held_out,
};
use catamaran_training::families::{Family, Model};

use super::super::{Arguments, Report};
use super::{faust, weights};

/// The columns of the record.
pub const HEADER: &str = "table,bodies,cut,part,points,relative,first,score,top-1";

/// Vertices of a generated body.
const VERTICES: usize = 2500;
const SEED: u64 = 31;

/// Number of bodies of each kind whose spectra are predicted.
const COUNT: usize = 5;

/// Reports how far the spectra of clouds are from those of meshes, and predicted from computed
/// ones.
pub fn run(report: &mut Report, arguments: &Arguments) -> Result<()> {
    report.say(
        "# Chapter 2: bodies that no training has\n\n## Point clouds (figure 2.8)\n\nDirichlet spectra of parts as clouds of \
         their vertices beside those of their meshes: mean relative error of 20 eigenvalues, and the first one over that of the mesh. Refused: \
         clouds whose boundary cannot be seen.\n\n\
         | body | vertices | parts | refused | mean % | worst % | of | first, least | first, largest |\n|---|---|---|---|---|---|---|---|---|",
    );
    let model = Model::new(Family::Humanoid, VERTICES)?;
    for bodies in Bodies::ALL {
        let mesh = bodies.shape(&model, SEED, 0)?;
        let name = format!("generated, {}", bodies.name());
        let found = body_clouds(&mesh, Frame { up: 2, side: 0 }, Par::all())?;
        clouds(report, &name, mesh.vertices().len(), found);
    }
    let folder = input::data_folder().join("meshes");
    for shape in REAL_SHAPES.iter().filter(|shape| shape.human) {
        match shape.mesh(&folder, Par::all()) {
            Ok((mesh, frame)) => {
                let found = body_clouds(&mesh, frame, Par::all())?;
                clouds(report, shape.name, mesh.vertices().len(), found);
            }
            Err(why) => report.say(&format!("| {} | {why} | | | | | | | |", shape.name)),
        }
    }
    let network = weights(arguments)?;
    report.say(&format!(
        "\n## Predicted spectra\n\nMean relative errors of the network on {COUNT} generated bodies of each kind, and the share of \
         pairs whose score is above 1.\n\n| bodies | pairs | error % | score > 1, % |\n|---|---|---|---|"
    ));
    let pairs = held_out(SEED, COUNT, Par::all())?;
    for bodies in Bodies::ALL {
        let own: Vec<_> = pairs.iter().filter(|(of, _)| *of == bodies).map(|(_, p)| *p).collect();
        let error = errors(&network, &own)?.relative;
        let mut above = 0;
        for pair in &own {
            above += usize::from(network.ood_score(&[&pair.first, &pair.second])? > 1.0);
        }
        let (name, share) = (bodies.name(), above as f64 / own.len().max(1) as f64);
        report.say(&format!(
            "| {name} | {} | {:.2} | {:.1} |",
            own.len(),
            100.0 * error,
            100.0 * share
        ));
        report.lines.push(format!("predicted,{name},,,,{error:.6e},,,"));
    }
    match Data::find() {
        Ok(data) => faust::tables(report, &data, &network),
        Err(why) => {
            report.say(&format!("\nFAUST was not measured: {why}."));
            Ok(())
        }
    }
}

/// Reports the clouds of the parts of a body; parts without a spectrum are only counted.
fn clouds(
    report: &mut Report,
    name: &str,
    vertices: usize,
    all: Vec<catamaran::Result<CloudError>>,
) {
    let count = all.len();
    let found: Vec<CloudError> = all.into_iter().filter_map(catamaran::Result::ok).collect();
    let mean = found.iter().map(|cloud| cloud.mean).sum::<f64>() / found.len().max(1) as f64;
    let Some(worst) = found.iter().max_by(|a, b| a.mean.total_cmp(&b.mean)) else { return };
    let [least, largest] = found.iter().fold([f64::INFINITY, 0.0], |[least, largest], cloud| {
        [least.min(cloud.first), f64::max(largest, cloud.first)]
    });
    report.say(&format!(
        "| {name} | {vertices} | {count} | {} | {:.1} | {:.1} | {}, part {} | {least:.3} | {largest:.3} |",
        count - found.len(),
        100.0 * mean,
        100.0 * worst.mean,
        worst.cut,
        worst.part + 1
    ));
    let name = name.replace(',', "");
    report.lines.extend(found.iter().map(|cloud| {
        let CloudError { cut, part, points, mean, first } = cloud;
        format!("clouds,{name},{},{part},{points},{mean:.6e},{first:.6e},,", cut.replace(',', ""))
    }));
}
