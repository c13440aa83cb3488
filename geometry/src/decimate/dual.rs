//! The dual of a partition into cells.

use super::cells::Growth;
use super::surface::Surface;
use crate::mesh::has_corner_twice;
use catamaran::base::Par;

/// Number of vertices or faces that one thread takes at a time.
const BLOCK: usize = 1 << 16;

/// Returns the input triangles with three cells each, as faces between cells, in the order of the
/// input.
pub(super) fn faces(surface: &Surface<'_>, growth: &Growth, par: Par) -> Vec<[u32; 3]> {
    let all = surface.mesh.faces();
    let blocks = par.map_blocks(all.len(), BLOCK, |range| {
        let cells = all[range].iter().map(|face| face.map(|v| growth.cell(v)));
        cells.filter(|cells| !has_corner_twice(cells)).collect::<Vec<_>>()
    });
    blocks.concat()
}

/// Returns every three-cycle of the graph of cells (thesis, section 5.3.3), oriented like a
/// triangle of the input with these cells if there is one, otherwise ascending. In general, the
/// result is no manifold.
pub(super) fn three_cycles(surface: &Surface<'_>, growth: &Growth, par: Par) -> Vec<[u32; 3]> {
    let mut edges: Vec<[u32; 2]> = Vec::new();
    for v in 0..surface.len() as u32 {
        let cell = growth.cell(v);
        let others = surface.links(v).iter().map(|link| growth.cell(link.to));
        edges.extend(others.filter(|&other| other > cell).map(|other| [cell, other]));
    }
    edges.sort_unstable();
    edges.dedup();
    let above = |a: u32| {
        let start = edges.partition_point(|edge| edge[0] < a);
        let end = edges.partition_point(|edge| edge[0] <= a);
        edges[start..end].iter().map(|edge| edge[1])
    };
    let sorted = |mut face: [u32; 3]| {
        face.sort_unstable();
        face
    };
    let mut corners: Vec<_> =
        faces(surface, growth, par).into_iter().map(|face| (sorted(face), face)).collect();
    corners.sort_unstable();
    let mut cycles = Vec::new();
    for &[a, b] in &edges {
        for c in above(b).filter(|&c| edges.binary_search(&[a, c]).is_ok()) {
            let first = corners.partition_point(|corner| corner.0 < [a, b, c]);
            let as_there = corners.get(first).filter(|corner| corner.0 == [a, b, c]);
            cycles.push(as_there.map_or([a, b, c], |corner| corner.1));
        }
    }
    cycles
}
