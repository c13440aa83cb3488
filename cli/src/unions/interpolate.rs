//! `catamaran unions interpolate`.

use std::fmt::Write as _;
use std::io::Write as _;
use std::path::PathBuf;

use anyhow::{Result, bail};
use catamaran_geometry::unions::{K, interpolate};

use super::parts::{PartArgs, report_ood};
use crate::common::Force;
use crate::output;
use crate::picture::{Paint, PictureArgs};
use crate::report::row;

/// Interpolate between the spectra of two parts, and predict unions with a third.
///
/// With --localize this is figure 2.10 of the thesis: the region of the union on a template while
/// one part turns into another. An interpolated spectrum may not be that of any surface; the
/// out-of-distribution score says which parts are further out than 99.5 % of the training pairs.
#[derive(clap::Args)]
pub struct Args {
    #[arg(
        value_name = "PART",
        num_args = 3,
        required = true,
        help = crate::input::mesh_help("The first part, the last part, and the part that stays")
    )]
    parts: Vec<PathBuf>,
    /// Number of unions from the first part to the last, 2 to 1000.
    #[arg(long, value_name = "N", default_value_t = 5, value_parser = clap::value_parser!(u16).range(2..=1000))]
    steps: u16,
    #[command(flatten)]
    source: PartArgs,
    /// Find the unions on this template, a mesh such as that of `unions template`.
    #[arg(long, value_name = "TEMPLATE")]
    localize: Option<PathBuf>,
    #[command(flatten)]
    picture: PictureArgs,
    /// Write the eigenvalues of the unions to this .csv file, a column for each union.
    #[arg(short, long, value_name = "FILE")]
    output: Option<PathBuf>,
    #[command(flatten)]
    force: Force,
}

/// Runs the subcommand.
pub fn run(args: &Args) -> Result<()> {
    if args.picture.path().is_some() && args.localize.is_none() {
        bail!("--picture draws the regions of unions: it needs --localize");
    }
    let output = args.output.as_deref().map(|path| output::csv(path, args.force)).transpose()?;
    let picture = args.picture.create(args.force)?;
    let model = args.source.model()?;
    let template = match &args.localize {
        Some(path) => Some((path, args.source.template(path, &model)?)),
        None => None,
    };
    let read = |path: &PathBuf| Ok(args.source.read(path)?.1);
    let spectra: Vec<Vec<f64>> = args.parts.iter().map(read).collect::<Result<_>>()?;
    let times: Vec<f64> =
        (0..args.steps).map(|i| f64::from(i) / f64::from(args.steps - 1)).collect();
    let between: Vec<[f64; K]> = times
        .iter()
        .map(|&t| interpolate(&spectra[0], &spectra[1], t))
        .collect::<Result<_, _>>()?;
    let pairs: Vec<Vec<&[f64]>> = between.iter().map(|part| vec![&part[..], &spectra[2]]).collect();
    let mut unions = Vec::new();
    for (t, parts) in times.iter().zip(&pairs) {
        let union = model.predict_all(parts)?;
        row!(
            "union",
            t = t,
            eigenvalues = union;
            "t = {t:.2}  eigenvalues from {:.4} to {:.4}",
            union[0],
            union[K - 1]
        )?;
        report_ood(model.ood_score(parts)?)?;
        unions.push(union);
    }
    if let Some((path, template)) = template {
        let found = template.locate(&model, &pairs)?;
        if let Some(picture) = picture {
            let names: Vec<String> = times.iter().map(|t| format!("{t:.2}")).collect();
            let panels: Vec<_> = found
                .iter()
                .zip(&names)
                .map(|((mesh, inside), name)| (mesh, Paint::Values(inside), name.as_str()))
                .collect();
            args.picture.draw_shares(picture, path, &panels)?;
        }
    }
    if let Some(mut output) = output {
        let mut text = String::from("number");
        times.iter().try_for_each(|t| write!(text, ",{t}"))?;
        for i in 0..K {
            write!(text, "\n{}", i + 1)?;
            unions.iter().try_for_each(|union| write!(text, ",{}", union[i]))?;
        }
        writeln!(output, "{text}").map_err(|e| output.error(e))?;
        output.commit()?;
    }
    Ok(())
}
