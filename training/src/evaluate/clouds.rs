use catamaran::{Par, Result};
use catamaran_geometry::mesh::{CloudOptions, LaplacianOptions, TriMesh};
use catamaran_geometry::unions::{PartSpectra, cloud_spectrum};

use super::{BODY_CUTS, Frame};
use crate::cuts::{Mask, Surface};
use crate::dataset::EIGENVALUES;

/// How far the spectrum of the points of a part is from that of its mesh (thesis, figure 2.8).
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct CloudError {
    /// The names of both parts of the cut.
    pub cut: &'static str,
    /// Which of them it is: 0 or 1.
    pub part: usize,
    /// Number of points.
    pub points: usize,
    /// Mean relative error of the eigenvalues.
    pub mean: f64,
    /// The first eigenvalue over that of the mesh.
    pub first: f64,
}

/// Compares the Dirichlet spectra of the parts of all [`BODY_CUTS`], as meshes and as clouds of
/// their vertices; returns why a cloud has none otherwise.
///
/// # Errors
/// Those of [`PartSpectra`]; of a cloud, those of [`cloud_spectrum`].
pub fn body_clouds(mesh: &TriMesh, frame: Frame, par: Par) -> Result<Vec<Result<CloudError>>> {
    let mirror: Vec<u32> = (0..mesh.vertices().len() as u32).collect();
    let surface = Surface::new(mesh, &mirror, par)?;
    let spectra = PartSpectra::new(mesh, &LaplacianOptions::new().par(par))?;
    let mut found = Vec::new();
    for cut in &BODY_CUTS {
        for (part, mask) in cut.parts(&surface, frame)?.iter().enumerate() {
            let truth = spectra.dirichlet(mask, EIGENVALUES)?;
            let points = points(mesh, mask)?;
            let own = cloud_spectrum(&points, EIGENVALUES, &CloudOptions::new().par(par));
            found.push(own.map(|own| {
                let errors = own.iter().zip(&truth).map(|(own, truth)| (own / truth - 1.0).abs());
                let mean = errors.sum::<f64>() / truth.len() as f64;
                let first = own[0] / truth[0];
                CloudError { cut: cut.name, part, points: points.len(), mean, first }
            }));
        }
    }
    Ok(found)
}

/// Returns the vertices of the faces of a part.
fn points(mesh: &TriMesh, mask: &Mask) -> Result<Vec<[f64; 3]>> {
    Ok(mesh.masked(mask)?.mesh.into_parts().0)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::evaluate::Bodies;
    use crate::families::{Family, Model};

    #[test]
    fn clouds_of_generated_people_have_the_spectra_of_their_meshes() {
        let model = Model::new(Family::Humanoid, 2500).unwrap();
        let frame = Frame { up: 2, side: 0 };
        let mut all = Vec::new();
        for bodies in [Bodies::Usual, Bodies::TypeB] {
            let mesh = bodies.shape(&model, 31, 0).unwrap();
            let found = body_clouds(&mesh, frame, Par::all()).unwrap();
            all.extend(found.into_iter().map(|cloud| (bodies, cloud.unwrap())));
        }
        let mean = all.iter().map(|(_, cloud)| cloud.mean).sum::<f64>() / all.len() as f64;
        let worst = all.iter().max_by(|a, b| a.1.mean.total_cmp(&b.1.mean)).unwrap();
        assert!(mean < 0.03 && worst.1.mean < 0.06, "{mean} {worst:?}");
    }
}
