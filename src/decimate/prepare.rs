//! Input made a manifold: what is not is cut apart, and told.

use std::borrow::Cow;
use std::fmt;

use super::surface::Surface;
use crate::base::{Error, Par, Result};
use crate::mesh::{Edges, TriMesh};

/// What was done to the input to make it a manifold whose faces agree on what is outside.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
#[non_exhaustive]
pub struct Repairs {
    /// Faces left out because another one has the same vertices.
    pub repeated_faces: usize,
    /// Edges of more than two faces, along which the mesh was cut: each of the faces has a boundary there now.
    pub cut_edges: usize,
    /// Vertices at which the surface met itself, which are several now.
    pub split_vertices: usize,
    /// Whether faces were flipped to agree with their neighbours.
    pub oriented: bool,
    /// Vertices that no face has, left out.
    pub unreferenced_vertices: usize,
}

impl fmt::Display for Repairs {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let counted = [
            (self.repeated_faces, "repeated faces left out"),
            (self.cut_edges, "edges of more than two faces cut"),
            (self.split_vertices, "vertices split where the surface meets itself"),
            (self.unreferenced_vertices, "vertices without a face left out"),
        ];
        let mut parts: Vec<String> = counted
            .into_iter()
            .filter(|(count, _)| *count > 0)
            .map(|(count, what)| format!("{count} {what}"))
            .collect();
        if self.oriented {
            parts.push("faces flipped to agree".into());
        }
        if parts.is_empty() { f.write_str("none") } else { f.write_str(&parts.join(", ")) }
    }
}

/// A manifold, and where it comes from.
pub(super) struct Prepared<'m> {
    pub surface: Surface<'m>,
    /// For each vertex of the surface that of the input; `None`: the same.
    pub vertices: Option<Vec<u32>>,
    /// For each face of the surface that of the input; `None`: the same.
    pub faces: Option<Vec<u32>>,
    pub repairs: Repairs,
}

/// The input, cut where it is not a manifold, and oriented if it can be.
///
/// # Errors
/// [`Error::Mesh`] when there is no face, lengths are out of range, or a vertex at which no cut helps.
pub(super) fn prepare(mesh: Cow<'_, TriMesh>, par: Par) -> Result<Prepared<'_>> {
    if mesh.faces().is_empty() {
        return Err(Error::Mesh { what: "it has no face".into(), element: "mesh".into() });
    }
    let (surface, broken) = Surface::read(mesh, par)?;
    if broken.is_some() {
        return cut(&surface.mesh, par);
    }
    let unreferenced = (0..surface.len() as u32).filter(|&v| surface.links(v).is_empty()).count();
    let mut repairs = Repairs { unreferenced_vertices: unreferenced, ..Repairs::default() };
    let surface = oriented(surface, &mut repairs, par)?;
    Ok(Prepared { surface, vertices: None, faces: None, repairs })
}

/// With faces flipped where that makes them agree; what is not orientable stays as it is.
fn oriented<'m>(surface: Surface<'m>, repairs: &mut Repairs, par: Par) -> Result<Surface<'m>> {
    if surface.oriented {
        return Ok(surface);
    }
    let Ok(flipped) = surface.mesh.oriented() else { return Ok(surface) };
    repairs.oriented = true;
    Surface::new(Cow::Owned(flipped), par)
}

/// Repeated faces left out, then every fan of faces at a vertex a vertex of its own, where fans do not go over edges of more
/// than two faces (Gueziec et al., Cutting and Stitching, 2001).
fn cut(mesh: &TriMesh, par: Par) -> Result<Prepared<'static>> {
    let mut repeated = vec![false; mesh.faces().len()];
    for [face, _] in mesh.repeated_faces() {
        repeated[face as usize] = true;
    }
    let kept: Vec<u32> = (0..repeated.len() as u32).filter(|&f| !repeated[f as usize]).collect();
    let part = mesh.submesh(&kept)?;
    let mut repairs = Repairs {
        repeated_faces: repeated.len() - kept.len(),
        unreferenced_vertices: mesh.unreferenced_vertices().len(),
        ..Repairs::default()
    };
    let mesh = part.mesh;
    let edges = Edges::new(&mesh);
    repairs.cut_edges = edges.non_manifold().count();
    let (of_corners, origins) = fans(&mesh, &edges);
    let mut fans_of = vec![0; mesh.vertices().len()];
    origins.iter().for_each(|&v| fans_of[v as usize] += 1);
    repairs.split_vertices = fans_of.iter().filter(|&&fans| fans > 1).count();
    let positions = origins.iter().map(|&v| mesh.vertices()[v as usize]).collect();
    let (corners, _) = of_corners.as_chunks::<3>();
    let vertices = origins.iter().map(|&v| part.vertices[v as usize]).collect();
    let mesh = TriMesh::new(positions, corners.to_vec())?;
    let surface = oriented(Surface::new(Cow::Owned(mesh), par)?, &mut repairs, par)?;
    Ok(Prepared { surface, vertices: Some(vertices), faces: Some(kept), repairs })
}

/// For each corner the number of its fan, by the vertex of the fans, and for each fan its vertex.
fn fans(mesh: &TriMesh, edges: &Edges) -> (Vec<u32>, Vec<u32>) {
    let faces = mesh.faces();
    let mut of_corners = vec![u32::MAX; 3 * faces.len()];
    let mut origins = Vec::new();
    let mut open = Vec::new();
    for (v, row) in (0..).zip(mesh.vertex_faces().rows()) {
        for &face in row {
            let corner_at = |f: u32| {
                (3 * f..3 * f + 3)
                    .find(|&c| faces[f as usize][c as usize % 3] == v)
                    .unwrap_or(3 * f)
            };
            if of_corners[corner_at(face) as usize] != u32::MAX {
                continue;
            }
            let fan = origins.len() as u32;
            origins.push(v);
            open.push(face);
            while let Some(face) = open.pop() {
                let corner = corner_at(face);
                if of_corners[corner as usize] != u32::MAX {
                    continue;
                }
                of_corners[corner as usize] = fan;
                // The two edges of this face at v: they start at this corner and at the one before.
                let before = if corner % 3 == 0 { corner + 2 } else { corner - 1 };
                for edge in [corner, before].map(|c| edges.of_corners()[c as usize]) {
                    if let &[a, b] = edges.corners().row(edge as usize) {
                        open.extend([a / 3, b / 3].into_iter().filter(|&f| f != face));
                    }
                }
            }
        }
    }
    (of_corners, origins)
}
