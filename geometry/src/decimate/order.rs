//! Numbers vertices along a curve through space, so that near ones are near in memory.

use super::patch::{Compact, Patch};
use crate::mesh::TriMesh;
use crate::mesh::intersections::Curve;
use catamaran::base::{Result, reserved};

/// A mesh in another order, with its origin.
pub(super) struct Ordered {
    pub mesh: TriMesh,
    /// For each vertex its number before.
    pub vertices: Vec<u32>,
    /// For each face its number before.
    pub faces: Vec<u32>,
}

/// Difference of the numbers of two vertices whose data are in a processor's own memory at the same
/// time: some 200 bytes for each vertex between.
const NEAR: u32 = 2048;

/// Share of the edges, as one of so many, that may be longer than that.
const SHARE: usize = 20;

/// Returns whether neighbours are often far from each other in memory, which makes walks over the
/// surface wait. Grids that are numbered row by row are not scattered.
pub(super) fn is_scattered(mesh: &TriMesh) -> bool {
    let far = mesh.faces().iter().filter(|[a, b, _]| a.abs_diff(*b) > NEAR).count();
    SHARE * far > mesh.faces().len()
}

/// Returns the mesh with vertices in the order of the curve, and faces in the order of their lowest
/// vertices.
///
/// # Errors
/// [`Error::OutOfMemory`](catamaran::base::Error::OutOfMemory).
pub(super) fn along_curve(mesh: &TriMesh) -> Result<Ordered> {
    let curve = Curve::through(mesh.bounding_box().unwrap_or([[0.0; 3]; 2]));
    let vertices = sorted(mesh.vertices().iter().map(|&p| curve.place(p)))?;
    let mut numbers = reserved(vertices.len())?;
    numbers.resize(vertices.len(), 0u32);
    vertices.iter().zip(0..).for_each(|(&old, new)| numbers[old as usize] = new);
    let renumbered = |face: &[u32; 3]| face.map(|v| numbers[v as usize]);
    let lowest = |face: &[u32; 3]| renumbered(face).into_iter().min().unwrap_or(0);
    let faces = sorted(mesh.faces().iter().map(|face| u64::from(lowest(face))))?;
    let positions = vertices.iter().map(|&v| mesh.vertices()[v as usize]).collect();
    let corners = faces.iter().map(|&f| renumbered(&mesh.faces()[f as usize])).collect();
    Ok(Ordered { mesh: TriMesh::new(positions, corners)?, vertices, faces })
}

/// Returns the patch without what was removed from it, in the order of the curve.
///
/// # Errors
/// As [`along_curve`].
pub(super) fn pack(patch: Patch) -> Result<Patch> {
    let stretch = patch.stretch.clone();
    let Compact { positions, anchors, locked, kept, faces, .. } = patch.compact();
    let Ordered { mesh, vertices, .. } = along_curve(&TriMesh::new(positions, faces)?)?;
    let locked = vertices.iter().map(|&v| locked[v as usize]).collect();
    let anchors = vertices.into_iter().map(|v| anchors[v as usize]).collect();
    let (positions, faces) = mesh.into_parts();
    let mut packed = Patch::new(positions, anchors, faces);
    packed.lock(locked, kept);
    packed.stretch = stretch;
    Ok(packed)
}

/// Returns the numbers of items in the order of their keys, equal ones in their own order.
fn sorted(keys: impl ExactSizeIterator<Item = u64>) -> Result<Vec<u32>> {
    let mut pairs = reserved(keys.len())?;
    pairs.extend(keys.zip(0u32..));
    pairs.sort_unstable();
    let mut order = reserved(pairs.len())?;
    order.extend(pairs.into_iter().map(|(_, item)| item));
    Ok(order)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::mesh::families;

    #[test]
    fn the_mesh_is_the_same_and_neighbours_are_near_each_other() {
        let (vertices, faces) = families::icosphere(5).unwrap().into_parts();
        // Every second vertex comes first.
        let half = vertices.len().div_ceil(2) as u32;
        let number = |v: u32| v / 2 + half * (v % 2);
        let mut moved = vertices.clone();
        vertices.iter().zip(0..).for_each(|(&p, v)| moved[number(v) as usize] = p);
        let faces = faces.iter().map(|face| face.map(number)).collect();
        let mesh = TriMesh::new(moved, faces).unwrap();
        assert!(is_scattered(&mesh));
        let ordered = along_curve(&mesh).unwrap();
        assert!(!is_scattered(&ordered.mesh));
        for (p, &old) in ordered.mesh.vertices().iter().zip(&ordered.vertices) {
            assert_eq!(*p, mesh.vertices()[old as usize]);
        }
        for (face, &old) in ordered.mesh.faces().iter().zip(&ordered.faces) {
            let before = face.map(|v| ordered.vertices[v as usize]);
            assert_eq!(before, mesh.faces()[old as usize]);
        }
        assert!(!is_scattered(&families::grid(1000, 4).unwrap()));
    }
}
