//! The dual of a partition into cells, and whether it is a triangulation of the same surface.

use super::cells::Growth;
use super::surface::Surface;
use crate::base::Par;

/// Vertices or faces that one thread takes at a time.
const BLOCK: usize = 1 << 16;

/// The input triangles with three cells each, as faces between cells, in the order of the input.
pub(super) fn faces(surface: &Surface<'_>, growth: &Growth, par: Par) -> Vec<[u32; 3]> {
    let all = surface.mesh.faces();
    let blocks = par.map_blocks(all.len(), BLOCK, |range| {
        let cells = all[range].iter().map(|face| face.map(|v| growth.cell(v)));
        cells.filter(|&[a, b, c]| a != b && b != c && c != a).collect::<Vec<_>>()
    });
    blocks.concat()
}

/// Every three-cycle of the graph of cells (thesis, section 5.3.3), the way a triangle of the input with these cells runs if
/// there is one, ascending else. Not a manifold in general.
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

/// The cells that have to be split before the dual is a triangulation of the surface, ascending.
///
/// A cell is the part of the surface around its vertices; two cells meet along arcs across their mixed edges, three in the
/// corners within triangles of three cells. The dual is a triangulation when every cell is a disk that touches the boundary
/// at most once, two cells meet in no more than one arc, every arc has a corner, three cells meet in no more than one, and
/// every cell has one (the closed ball property: Edelsbrunner and Shah 1997, here of graph cells). All of these are counts:
/// the Euler characteristic V - E + F of what is within a cell is 1 for a disk, and that of mixed edges and mixed triangles
/// is the number of arcs.
pub(super) fn faults(surface: &Surface<'_>, growth: &Growth, cells: usize, par: Par) -> Vec<u32> {
    let corners = faces(surface, growth, par);
    let mut euler = vec![0i64; cells];
    let mut touches = vec![0i64; cells];
    let mut sizes = vec![0u32; cells];
    let counts = par.map_blocks(surface.len(), BLOCK, |range| {
        let mut counts = Counts::default();
        for v in range {
            counts.add_vertex(surface, growth, v as u32);
        }
        counts
    });
    let mut arcs = Vec::new();
    for counts in counts {
        for (cell, change) in counts.within {
            euler[cell as usize] += i64::from(change);
        }
        for (cell, change) in counts.boundary {
            touches[cell as usize] += i64::from(change);
        }
        arcs.extend(counts.arcs);
    }
    let all = surface.mesh.faces();
    let within = par.map_blocks(all.len(), BLOCK, |range| {
        let mut within: Vec<(u32, i32)> = Vec::new();
        let mut arcs = Vec::new();
        for face in &all[range] {
            let [a, b, c] = face.map(|v| growth.cell(v));
            if a == b && b == c {
                add(&mut within, a, 1);
            } else if a == b || a == c {
                arcs.push((pair(b, if a == b { c } else { a }), -1));
            } else if b == c {
                arcs.push((pair(a, b), -1));
            }
        }
        (within, arcs)
    });
    for (within, more) in within {
        for (cell, change) in within {
            euler[cell as usize] += i64::from(change);
        }
        arcs.extend(more);
    }
    for v in 0..surface.len() as u32 {
        if let Some(size) = sizes.get_mut(growth.cell(v) as usize) {
            *size += 1;
        }
    }
    let mut bad = vec![false; cells];
    // Cells of one vertex are what they are: of several that are at fault together, the largest is split.
    let blame = |cells: &[u32], bad: &mut Vec<bool>| {
        if let Some(&cell) = cells.iter().max_by_key(|&&c| (sizes[c as usize], u32::MAX - c)) {
            bad[cell as usize] = true;
        }
    };
    for cell in 0..cells {
        if euler[cell] != 1 || touches[cell] > 1 {
            bad[cell] = true;
        }
    }
    let mut triples: Vec<[u32; 3]> = corners
        .iter()
        .map(|&corner| {
            let mut triple = corner;
            triple.sort_unstable();
            triple
        })
        .collect();
    triples.sort_unstable();
    for group in triples.chunk_by(|a, b| a == b).filter(|group| group.len() > 1) {
        blame(&group[0], &mut bad);
    }
    // Arcs that have a corner.
    let mut cornered: Vec<u64> =
        triples.iter().flat_map(|&[a, b, c]| [pair(a, b), pair(a, c), pair(b, c)]).collect();
    cornered.sort_unstable();
    arcs.sort_unstable();
    for group in arcs.chunk_by(|a, b| a.0 == b.0) {
        let between = group[0].0;
        let count: i64 = group.iter().map(|&(_, change)| i64::from(change)).sum();
        if count != 1 || cornered.binary_search(&between).is_err() {
            blame(&[(between >> 32) as u32, between as u32], &mut bad);
        }
    }
    // A cell in no corner would be lost; when it can't be split, its neighbours must.
    let mut has_corner = vec![false; cells];
    triples.iter().flatten().for_each(|&cell| has_corner[cell as usize] = true);
    for cell in (0..cells).filter(|&cell| !has_corner[cell]) {
        bad[cell] = true;
    }
    (0..cells as u32).filter(|&cell| bad[cell as usize]).collect()
}

/// What the vertices of a block and the edges to higher vertices add.
#[derive(Default)]
struct Counts {
    within: Vec<(u32, i32)>,
    boundary: Vec<(u32, i32)>,
    arcs: Vec<(u64, i32)>,
}

impl Counts {
    fn add_vertex(&mut self, surface: &Surface<'_>, growth: &Growth, v: u32) {
        let links = surface.links(v);
        if links.is_empty() {
            return;
        }
        let cell = growth.cell(v);
        let mut change = 1;
        for link in links.iter().filter(|link| link.to > v) {
            let other = growth.cell(link.to);
            if other == cell {
                change -= 1;
            } else {
                self.arcs.push((pair(cell, other), 1));
            }
        }
        add(&mut self.within, cell, change);
        if let Some(ends) = surface.along_boundary(v) {
            let same = ends.iter().filter(|&&to| to > v && growth.cell(to) == cell).count();
            add(&mut self.boundary, cell, 1 - same as i32);
        }
    }
}

/// Adds to the last entry when that is of the same cell: neighbours in the list often are.
fn add(list: &mut Vec<(u32, i32)>, cell: u32, change: i32) {
    match list.last_mut() {
        Some(last) if last.0 == cell => last.1 += change,
        _ => list.push((cell, change)),
    }
}

fn pair(a: u32, b: u32) -> u64 {
    u64::from(a.min(b)) << 32 | u64::from(a.max(b))
}
