//! `catamaran unions predict`.

use std::io::Write as _;
use std::path::PathBuf;

use anyhow::{Result, bail};
use catamaran_geometry::mesh::TriMesh;
use catamaran_geometry::unions::K;

use super::parts::{PartArgs, Template, report_ood};
use crate::common::Force;
use crate::output;
use crate::picture::{PLAIN, Paint, PictureArgs};
use crate::report::{head, row};

/// Predict the spectrum of the union of parts of a surface from those of the parts.
///
/// The parts are meshes with boundary or point clouds (files without faces), in any pose and
/// position, of any connectivity; correspondences of their points are not needed. Prints 20
/// Dirichlet eigenvalues of each part, those predicted for the union, and an out-of-distribution
/// score: above 1 the parts are further out than 99.5 % of the training pairs, and the prediction
/// is a guess. A score below 1 does not mean that the prediction is right.
#[derive(clap::Args)]
pub struct Args {
    #[arg(
        value_name = "PARTS",
        num_args = 2..,
        required = true,
        help = crate::input::mesh_help("Two or more parts")
    )]
    parts: Vec<PathBuf>,
    #[command(flatten)]
    source: PartArgs,
    /// Find the union on this template, a mesh such as that of `unions template`.
    #[arg(long, value_name = "TEMPLATE")]
    localize: Option<PathBuf>,
    #[command(flatten)]
    picture: PictureArgs,
    /// Write the eigenvalues of the parts and of the union to this .csv file, a column for each.
    #[arg(short, long, value_name = "FILE")]
    output: Option<PathBuf>,
    #[command(flatten)]
    force: Force,
}

/// Runs the subcommand.
pub fn run(args: &Args) -> Result<()> {
    if args.parts.len() < 2 {
        bail!("PARTS: a union needs at least two parts");
    }
    let output = args.output.as_deref().map(|path| output::csv(path, args.force)).transpose()?;
    let picture = args.picture.create(args.force)?;
    let model = args.source.model()?;
    let template = |path: &PathBuf| args.source.template(path, &model);
    let template = args.localize.as_ref().map(template).transpose()?;
    let (meshes, spectra): (Vec<TriMesh>, Vec<Vec<f64>>) = args
        .parts
        .iter()
        .map(|path| args.source.read(path))
        .collect::<Result<Vec<_>>>()?
        .into_iter()
        .unzip();
    let parts: Vec<&[f64]> = spectra.iter().map(Vec::as_slice).collect();
    let union = model.predict_all(&parts)?;
    let ood_score = model.ood_score(&parts)?;
    let mut header = String::from("number");
    for part in 1..=parts.len() {
        header += &format!(",part {part}");
    }
    header += ",union";
    let values =
        |i: usize| -> Vec<f64> { parts.iter().map(|part| part[i]).chain([union[i]]).collect() };
    head(format_args!("{}", header.replace(',', "     ")))?;
    for i in 0..K {
        let cells: String = values(i).iter().map(|x| format!(" {x:>10.4}")).collect();
        let of_parts: Vec<f64> = parts.iter().map(|part| part[i]).collect();
        row!(
            "eigenvalue",
            number = i + 1,
            parts = of_parts,
            union = union[i];
            "{:>4}  {cells}",
            i + 1
        )?;
    }
    report_ood(ood_score)?;
    let locate = |template: Template| template.locate(&model, std::slice::from_ref(&parts));
    let found = template.map(locate).transpose()?.unwrap_or_default();
    if let Some(picture) = picture {
        let drawn = meshes.iter().filter(|mesh| !mesh.faces().is_empty());
        let mut panels: Vec<_> = drawn.map(|mesh| (mesh, PLAIN, "part")).collect();
        panels.extend(found.iter().map(|(mesh, inside)| (mesh, Paint::Values(inside), "union")));
        args.picture.draw_shares(picture, &args.parts[0], &panels)?;
    }
    if let Some(mut output) = output {
        let lines: String = (0..K)
            .map(|i| {
                let cells: String = values(i).iter().map(|x| format!(",{x}")).collect();
                format!("{}{cells}\n", i + 1)
            })
            .collect();
        write!(output, "{header}\n{lines}").map_err(|e| output.error(e))?;
        output.commit()?;
    }
    Ok(())
}
