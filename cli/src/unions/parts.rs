//! The parts of a union, and the network that predicts it.

use std::path::{Path, PathBuf};

use anyhow::{Context, Result, anyhow, bail};
use catamaran::Par;
use catamaran_geometry::mesh::{
    Boundary, CloudOptions, Components, LaplacianOptions, TriMesh, free_components,
};
use catamaran_geometry::unions::{K, LocalizerOn, PartSpectra, SpectralUnion, cloud_spectrum};

use crate::input::MeshArgs;
use crate::pieces::Pieces;
use crate::report::{report, row};

/// The options of the network and of its input.
#[derive(clap::Args)]
pub struct PartArgs {
    /// Weights of the network: .safetensors, of `unions train` or `unions tune` [default: those of
    /// the program].
    #[arg(long, value_name = "FILE")]
    weights: Option<PathBuf>,
    #[command(flatten)]
    repair: MeshArgs,
}

/// A template with a number for each of its vertices: about 1 in a region, 0 outside.
pub type Localized = (TriMesh, Vec<f64>);

impl PartArgs {
    /// Returns the network with the weights of the file, or with those of the program.
    pub fn model(&self) -> Result<SpectralUnion> {
        model(self.weights.as_deref())
    }

    /// Reads a part and computes its Dirichlet spectrum; a part without faces is a point cloud of a
    /// surface.
    pub fn read(&self, path: &Path) -> Result<(TriMesh, Vec<f64>)> {
        let mesh = self.repair.read(path)?.mesh;
        let spectrum = spectrum(&mesh).with_context(|| path.display().to_string())?;
        if !mesh.faces().is_empty() {
            Pieces::new(&mesh, path, &self.repair, &Boundary::Dirichlet)?.note();
        }
        Ok((mesh, spectrum))
    }

    /// Reads a template.
    pub fn template(&self, path: &Path, model: &SpectralUnion) -> Result<Template> {
        let mesh = self.repair.read(path)?.mesh;
        let on = model.localizer().on_mesh(&mesh, Par::all());
        Ok(Template { on: on.with_context(|| path.display().to_string())?, mesh })
    }
}

/// A template on which unions are found.
pub struct Template {
    mesh: TriMesh,
    on: LocalizerOn,
}

impl Template {
    /// Computes the regions of unions, one for each list of parts.
    pub fn locate(&self, model: &SpectralUnion, unions: &[Vec<&[f64]>]) -> Result<Vec<Localized>> {
        let locate = |parts: &Vec<&[f64]>| {
            let inside = self.on.indicator(&model.locate(parts)?)?;
            let count = inside.iter().filter(|x| **x > 0.5).count();
            let all = self.mesh.vertices().len();
            report!(
                "region",
                vertices = count,
                template_vertices = all;
                "{count} of {all} vertices of the template"
            )?;
            Ok((self.mesh.clone(), inside.iter().map(|x| x.clamp(0.0, 1.0)).collect()))
        };
        unions.iter().map(locate).collect()
    }
}

/// Returns the network with the weights of a file, or with those of the program.
pub fn model(weights: Option<&Path>) -> Result<SpectralUnion> {
    Ok(match weights {
        Some(path) => SpectralUnion::read(path)?,
        None => SpectralUnion::pretrained()?,
    })
}

/// Reports an out-of-distribution score and what it measures, which is not the error: of the tests,
/// half of the wrong predictions score below 1, and half of those that score above 1 are right
/// (docs/model-card-unions.md).
pub fn report_ood(score: f64) -> Result<()> {
    let verdict = if score > 1.0 {
        "further out than 99.5 % of the training pairs, so the prediction is a guess"
    } else {
        "no further out than 99.5 % of the training pairs; the error of the prediction is unknown"
    };
    row!("ood_score", score = score; "out-of-distribution score {score:.2}: {verdict}")
}

fn spectrum(mesh: &TriMesh) -> Result<Vec<f64>> {
    if mesh.faces().is_empty() {
        return cloud_spectrum(mesh.vertices(), K, &CloudOptions::new()).map_err(too_small);
    }
    let closed = free_components(mesh, &Boundary::Dirichlet)?;
    if closed > 0 {
        let count = Components::new(mesh).len();
        bail!(
            "a component is closed ({closed} of {count}): each component of a part needs a boundary"
        );
    }
    let all = vec![true; mesh.vertices().len()];
    let spectra = PartSpectra::new(mesh, &LaplacianOptions::default())?;
    spectra.dirichlet(&all, K).map_err(too_small)
}

/// Says that a shape has too few vertices, where an error of the library is about the number of
/// eigenvalues, which no option sets.
fn too_small(error: catamaran::Error) -> anyhow::Error {
    match error {
        catamaran::Error::Argument { what: "k", .. } => {
            anyhow!("too few vertices: the {K} eigenvalues need as many that are not on a boundary")
        }
        error => error.into(),
    }
}
