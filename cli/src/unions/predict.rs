//! `catamaran unions predict`.

use std::io::Write as _;
use std::path::{Path, PathBuf};

use anyhow::{Context, Result, bail};
use catamaran::Par;
use catamaran::io::{Output, Overwrite};
use catamaran::mesh::{CloudOptions, LaplacianOptions, TriMesh};
use catamaran::unions::{K, PartSpectra, SpectralUnion, cloud_spectrum};

use crate::input::MeshArgs;
use crate::picture::{PLAIN, Paint, PictureArgs};
use crate::report::report;

/// Predict the spectrum of the union of parts of a surface from the spectra of the parts.
///
/// The parts are meshes with boundary or point clouds (files without faces), in any pose and
/// position, of any connectivity; which of their points correspond is not needed. Prints 20
/// Dirichlet eigenvalues of each part, those predicted for the union, and how unlike the shapes of
/// the training the parts are: above 1 the prediction is unreliable.
#[derive(clap::Args)]
pub struct Args {
    /// Two parts or more: .obj, .ply, .off, .stl, .glb or .gltf, each also as .gz or .xz.
    #[arg(value_name = "PARTS", num_args = 2.., required = true)]
    parts: Vec<PathBuf>,
    /// Other weights than those that come with the program: .safetensors, of `unions train`.
    #[arg(long, value_name = "FILE")]
    weights: Option<PathBuf>,
    /// Find the union on this template, a mesh: that of `unions template`.
    #[arg(long, value_name = "TEMPLATE")]
    localize: Option<PathBuf>,
    #[command(flatten)]
    repair: MeshArgs,
    #[command(flatten)]
    picture: PictureArgs,
    /// Write the eigenvalues of the parts and of the union, in columns: .csv.
    #[arg(short, long, value_name = "FILE")]
    output: Option<PathBuf>,
    /// Replace files that exist.
    #[arg(long)]
    force: bool,
}

/// Runs the subcommand.
pub fn run(args: &Args) -> Result<()> {
    if args.parts.len() < 2 {
        bail!("a union is of two parts or more");
    }
    let overwrite = if args.force { Overwrite::Replace } else { Overwrite::Never };
    let output = args.output.as_deref().map(|path| Output::create(path, overwrite)).transpose()?;
    let picture = args.picture.create(overwrite)?;
    let model = model(args.weights.as_deref())?;
    let meshes: Vec<TriMesh> =
        args.parts.iter().map(|path| Ok(args.repair.read(path)?.mesh)).collect::<Result<_>>()?;
    let spectra: Vec<Vec<f64>> = args
        .parts
        .iter()
        .zip(&meshes)
        .map(|(path, mesh)| spectrum(mesh).with_context(|| path.display().to_string()))
        .collect::<Result<_>>()?;
    let parts: Vec<&[f64]> = spectra.iter().map(Vec::as_slice).collect();
    let union = model.predict_all(&parts)?;
    let ood_score = model.ood_score(&parts)?;
    let mut header = String::from("number");
    for part in 1..=parts.len() {
        header += &format!(",part {part}");
    }
    header += ",union";
    let row =
        |i: usize| -> Vec<f64> { parts.iter().map(|part| part[i]).chain([union[i]]).collect() };
    report(format_args!("{}", header.replace(',', "     ")))?;
    for i in 0..K {
        let cells: String = row(i).iter().map(|x| format!(" {x:>10.4}")).collect();
        report(format_args!("{:>4}  {cells}", i + 1))?;
    }
    let verdict = if ood_score > 1.0 {
        "unlike the training data, so the prediction is unreliable"
    } else {
        "like the training data"
    };
    report(format_args!("out-of-distribution score {ood_score:.2}: {verdict}"))?;
    let localized = |template: &PathBuf| localized(template, &args.repair, &model, &parts);
    let found = args.localize.as_ref().map(localized).transpose()?;
    if let Some((mesh, inside)) = &found {
        let (count, all) = (inside.iter().filter(|x| **x > 0.5).count(), mesh.vertices().len());
        report(format_args!("region    {count} of {all} vertices of the template"))?;
    }
    if let Some(picture) = picture {
        let clipped: Option<Vec<f64>> =
            found.as_ref().map(|(_, inside)| inside.iter().map(|x| x.clamp(0.0, 1.0)).collect());
        let drawn = meshes.iter().filter(|mesh| !mesh.faces().is_empty());
        let mut panels: Vec<_> = drawn.map(|mesh| (mesh, PLAIN, "part")).collect();
        if let (Some((mesh, _)), Some(inside)) = (&found, &clipped) {
            panels.push((mesh, Paint::Values(inside), "union"));
        }
        args.picture.draw_shares(picture, &args.parts[0], &panels)?;
    }
    if let Some(mut output) = output {
        let lines: String = (0..K)
            .map(|i| {
                let cells: String = row(i).iter().map(|x| format!(",{x}")).collect();
                format!("{}{cells}\n", i + 1)
            })
            .collect();
        write!(output, "{header}\n{lines}").map_err(|e| output.error(e))?;
        output.commit()?;
    }
    Ok(())
}

/// The weights of a file, or those that come with the program.
fn model(path: Option<&Path>) -> Result<SpectralUnion> {
    Ok(match path {
        Some(path) => SpectralUnion::read(path)?,
        None => SpectralUnion::pretrained()?,
    })
}

/// The Dirichlet spectrum of a mesh, or of the surface that points without faces are from.
fn spectrum(mesh: &TriMesh) -> Result<Vec<f64>> {
    if mesh.faces().is_empty() {
        return Ok(cloud_spectrum(mesh.vertices(), K, &CloudOptions::new())?);
    }
    let all = vec![true; mesh.vertices().len()];
    let spectra = PartSpectra::new(mesh, &LaplacianOptions::default())?;
    Ok(spectra.dirichlet(&all, K)?)
}

/// A template, and about 1 for each vertex in the union of these parts, 0 outside.
fn localized(
    template: &Path,
    repair: &MeshArgs,
    model: &SpectralUnion,
    parts: &[&[f64]],
) -> Result<(TriMesh, Vec<f64>)> {
    let named = || template.display().to_string();
    let mesh = repair.read(template)?.mesh;
    let on = model.localizer().on_mesh(&mesh, Par::all()).with_context(named)?;
    let inside = on.indicator(&model.locate(parts)?)?;
    Ok((mesh, inside))
}
