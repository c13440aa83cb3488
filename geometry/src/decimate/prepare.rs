//! Prepares the input: cuts it where it is not a manifold, and reports the repairs.

use std::borrow::Cow;

use super::order::{Ordered, along_curve, is_scattered};
use super::resample::{Resampled, resample_with};
use super::surface::Surface;
pub use crate::mesh::Repairs;
use crate::mesh::{TriMesh, manifold};
use catamaran::base::{Error, Par, Progress, Result};

/// A manifold, and its origin in the input.
pub(super) struct Prepared<'m> {
    pub surface: Surface<'m>,
    /// For each vertex of the surface, the vertex of the input; `None` if they are the same.
    pub vertices: Option<Vec<u32>>,
    /// For each face of the surface, the face of the input; `None` if they are the same.
    pub faces: Option<Vec<u32>>,
    /// With a density, the vertices between which each one that was added is; these come last.
    pub origins: Vec<[u32; 4]>,
    pub repairs: Repairs,
}

/// Marks a vertex that the input does not have.
const NEW: u32 = u32::MAX;

impl Prepared<'_> {
    /// Returns the surface with edges whose stretched lengths are at most `longest`; the existing
    /// vertices keep their indices.
    pub fn refined(
        &self,
        longest: f64,
        par: Par,
        progress: Progress<'_>,
    ) -> Result<Prepared<'static>> {
        let Prepared { surface, vertices, faces, origins, repairs } = self;
        let stretch = surface.stretch.factors();
        let (resampled, stretched) = resample_with(&surface.mesh, longest, stretch, progress)?;
        let Resampled { mesh, parents } = resampled;
        let added = stretched.map_or_else(Vec::new, |stretched| stretched.origins);
        let of_input = |v: u32| match vertices {
            Some(vertices) => vertices.get(v as usize).copied().unwrap_or(NEW),
            None => Some(v).filter(|&v| (v as usize) < surface.len()).unwrap_or(NEW),
        };
        Ok(Prepared {
            vertices: Some((0..mesh.vertices().len() as u32).map(of_input).collect()),
            faces: Some(match faces {
                Some(faces) => parents.into_iter().map(|f| faces[f as usize]).collect(),
                None => parents,
            }),
            surface: Surface::new(Cow::Owned(mesh), par)?,
            origins: [origins.as_slice(), &added].concat(),
            repairs: *repairs,
        })
    }
}

/// Prepares the input: cuts it where it is not a manifold, and orients it if possible. With
/// `sorts`, vertices and faces may get another order.
///
/// # Errors
/// [`Error::Mesh`] when there is no face, lengths are out of range, or a vertex can't be cut to a
/// manifold.
pub(super) fn prepare(mesh: Cow<'_, TriMesh>, sorts: bool, par: Par) -> Result<Prepared<'_>> {
    if mesh.faces().is_empty() {
        return Err(Error::Mesh { what: "has no face".into(), element: "mesh".into() });
    }
    if sorts && is_scattered(&mesh) {
        mesh.check_size()?;
        let Ordered { mesh: ordered, vertices, faces } = along_curve(&mesh)?;
        // A mesh that has to be cut is cut in its own order, whose numbers errors name.
        if let (surface, None) = Surface::read(Cow::Owned(ordered), par)? {
            let prepared = whole(surface, par)?;
            return Ok(Prepared { vertices: Some(vertices), faces: Some(faces), ..prepared });
        }
    }
    let (surface, broken) = Surface::read(mesh, par)?;
    if broken.is_some() { cut(&surface.mesh, par) } else { whole(surface, par) }
}

/// Returns the surface of a mesh that is a manifold, oriented if possible.
fn whole(surface: Surface<'_>, par: Par) -> Result<Prepared<'_>> {
    let unreferenced = (0..surface.len() as u32).filter(|&v| surface.links(v).is_empty()).count();
    let mut repairs = Repairs { unreferenced_vertices: unreferenced, ..Repairs::default() };
    let surface = oriented(surface, &mut repairs, par)?;
    Ok(Prepared { surface, vertices: None, faces: None, origins: Vec::new(), repairs })
}

/// Returns the surface with faces flipped so that they agree; parts that are not orientable stay.
fn oriented<'m>(surface: Surface<'m>, repairs: &mut Repairs, par: Par) -> Result<Surface<'m>> {
    if surface.oriented {
        return Ok(surface);
    }
    let Ok(flipped) = surface.mesh.oriented() else { return Ok(surface) };
    repairs.oriented = true;
    Surface::new(Cow::Owned(flipped), par)
}

/// Cuts the mesh to a manifold.
fn cut(mesh: &TriMesh, par: Par) -> Result<Prepared<'static>> {
    let (part, mut repairs) = manifold(mesh)?;
    let surface = oriented(Surface::new(Cow::Owned(part.mesh), par)?, &mut repairs, par)?;
    let (vertices, faces) = (Some(part.vertices), Some(part.faces));
    Ok(Prepared { surface, vertices, faces, origins: Vec::new(), repairs })
}
