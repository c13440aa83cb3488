//! Cuts meshes open along edges.

use super::walls::Walls;
use crate::mesh::{Part, TriMesh};
use catamaran::base::{Result, Sets};

/// Cuts a mesh open along edges: a vertex whose faces the edges separate becomes several vertices,
/// one for each part. Faces keep their order; new vertices follow those of the mesh. Takes O(V +
/// F).
///
/// If the mesh has no other contacts at single points, its pieces are the
/// [components](crate::mesh::Components) of the result. Edges that end inside of the surface leave
/// a slit, whose end remains one vertex.
///
/// ```
/// use catamaran_geometry::curve::cut;
/// use catamaran_geometry::mesh::{Components, families};
///
/// // Cut a grid of 2 x 1 squares along the edge between them.
/// let mesh = families::grid(2, 1)?;
/// let open = cut(&mesh, &[[2, 3]])?;
/// assert_eq!(Components::new(&open.mesh).len(), 2);
/// assert_eq!(open.vertices[6..], [2, 3]);
/// # Ok::<(), catamaran::Error>(())
/// ```
///
/// # Errors
/// [`Error::Argument`](catamaran::Error::Argument) for two vertices that are not joined by an edge.
pub fn cut(mesh: &TriMesh, along: &[[u32; 2]]) -> Result<Part> {
    let walls = Walls::new(mesh, along)?;
    let mut at_wall = vec![false; mesh.vertices().len()];
    for &v in along.as_flattened() {
        at_wall[v as usize] = true;
    }
    // Corners of a vertex that are connected across edges that are not cut.
    let faces = mesh.faces();
    let mut fans = Sets::new(3 * faces.len());
    let corner = |face: u32, v: u32| {
        let place = faces[face as usize].iter().position(|&u| u == v);
        3 * face + place.unwrap_or_default() as u32
    };
    for (e, ends) in walls.edges.ends().iter().enumerate() {
        if walls.is_wall[e] || !ends.iter().any(|&v| at_wall[v as usize]) {
            continue;
        }
        let row: Vec<u32> = walls.edges.faces(e).collect();
        for pair in row.windows(2) {
            for &v in ends {
                fans.join(corner(pair[0], v), corner(pair[1], v));
            }
        }
    }
    let mut vertices: Vec<u32> = (0..mesh.vertices().len() as u32).collect();
    let mut of_fans = vec![u32::MAX; 3 * faces.len()];
    let mut used = vec![false; vertices.len()];
    let mut cut_faces = Vec::with_capacity(faces.len());
    for (f, face) in (0..).zip(faces) {
        let mut own = *face;
        for (i, v) in (0..).zip(&mut own) {
            if !at_wall[*v as usize] {
                continue;
            }
            let fan = fans.find(3 * f + i) as usize;
            if of_fans[fan] == u32::MAX {
                // The first fan keeps the vertex.
                let old = *v as usize;
                of_fans[fan] = if used[old] { vertices.len() as u32 } else { *v };
                if used[old] {
                    vertices.push(*v);
                }
                used[old] = true;
            }
            *v = of_fans[fan];
        }
        cut_faces.push(own);
    }
    let positions = vertices.iter().map(|&v| mesh.vertices()[v as usize]).collect();
    let faces = (0..cut_faces.len() as u32).collect();
    Ok(Part { mesh: TriMesh::new(positions, cut_faces)?, vertices, faces })
}
