//! Cuts meshes where they are not manifolds.

use std::fmt;

use super::super::{Edges, Part, TriMesh};
use super::rebuild::{Rebuild, corners_of};
use super::report::RepairStep;
use catamaran::base::Result;

/// The changes that made the input a manifold whose faces agree about which side is outside.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
#[non_exhaustive]
pub struct Repairs {
    /// Number of faces left out because an earlier face has the same vertices.
    pub repeated_faces: usize,
    /// Number of edges of more than two faces, along which the mesh was cut: each of their faces
    /// has a boundary there now.
    pub cut_edges: usize,
    /// Number of vertices at which the surface met itself, and which were split into several.
    pub split_vertices: usize,
    /// Whether faces were flipped to agree with their neighbours.
    pub oriented: bool,
    /// Number of vertices without a face, which were left out.
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

/// Returns the mesh as a manifold: repeated faces and vertices without a face are left out, then
/// every fan of faces at a vertex becomes a vertex of its own, where fans end at edges of more than
/// two faces (Gueziec et al., 2001). Several vertices of the part may come from one vertex of the
/// mesh. Faces are not flipped.
pub(crate) fn manifold(mesh: &TriMesh) -> Result<(Part, Repairs)> {
    let mut repeated = vec![false; mesh.faces().len()];
    for [face, _] in mesh.repeated_faces() {
        repeated[face as usize] = true;
    }
    let kept: Vec<u32> = (0..repeated.len() as u32).filter(|&f| !repeated[f as usize]).collect();
    let part = mesh.submesh(&kept)?;
    let fans = Fans::of(&part.mesh);
    let repairs = Repairs {
        repeated_faces: repeated.len() - kept.len(),
        cut_edges: fans.cut_edges,
        split_vertices: fans.split_vertices,
        unreferenced_vertices: mesh.unreferenced_vertices().len(),
        ..Repairs::default()
    };
    let positions = fans.origins.iter().map(|&v| part.mesh.vertices()[v as usize]).collect();
    let vertices = fans.origins.iter().map(|&v| part.vertices[v as usize]).collect();
    let mesh = TriMesh::new(positions, fans.faces)?;
    Ok((Part { mesh, vertices, faces: kept }, repairs))
}

/// Returns the mesh cut where it is not a manifold; `None` when it is one.
pub(super) fn cut(mesh: &TriMesh) -> (Option<Rebuild>, RepairStep) {
    let Fans { faces, origins, cut_edges, split_vertices } = Fans::of(mesh);
    let step = RepairStep::Cut { edges: cut_edges, vertices: split_vertices };
    let corners = (0..faces.len() as u32).map(corners_of).collect();
    let rebuild =
        Rebuild { vertices: origins, faces, corners, insertions: Vec::new(), joined: None };
    (step.changed().then_some(rebuild), step)
}

/// A mesh with a vertex for each fan of faces.
struct Fans {
    faces: Vec<[u32; 3]>,
    /// For each fan, its vertex in the original mesh.
    origins: Vec<u32>,
    cut_edges: usize,
    split_vertices: usize,
}

impl Fans {
    fn of(mesh: &TriMesh) -> Self {
        let edges = Edges::new(mesh);
        let (of_corners, origins) = fans(mesh, &edges);
        let mut fans_of = vec![0; mesh.vertices().len()];
        origins.iter().for_each(|&v| fans_of[v as usize] += 1);
        Self {
            faces: of_corners.as_chunks::<3>().0.to_vec(),
            origins,
            cut_edges: edges.non_manifold().count(),
            split_vertices: fans_of.iter().filter(|&&fans| fans > 1).count(),
        }
    }
}

/// Returns for each corner the index of its fan, and for each fan its vertex. Fans are ordered by
/// vertex; a vertex without a face has one fan without a face.
fn fans(mesh: &TriMesh, edges: &Edges) -> (Vec<u32>, Vec<u32>) {
    let faces = mesh.faces();
    let mut of_corners = vec![u32::MAX; 3 * faces.len()];
    let mut origins = Vec::new();
    let mut open = Vec::new();
    for (v, row) in (0..).zip(mesh.vertex_faces().rows()) {
        if row.is_empty() {
            origins.push(v);
        }
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
                // The two edges of this face at v start at this corner and at the previous one.
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
