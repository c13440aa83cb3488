//! Tests whether the dual of a partition into cells is a triangulation of the same surface.

use super::cells::Growth;
use super::surface::Surface;
use catamaran::base::Par;

/// Number of vertices that one thread takes at a time.
const BLOCK: usize = 1 << 14;

/// Returns those of the `doubtful` cells and their neighbours that have to be split so that the
/// dual is a triangulation of the surface, ascending. `sizes` are the numbers of vertices of all
/// cells, and `inside` tells which cells may not touch the boundary.
///
/// A cell is the part of the surface around its vertices; two cells meet along arcs across their
/// mixed edges, three cells meet in corners within triangles of three cells. The dual is a
/// triangulation when every cell is a disk that touches the boundary at most once, two cells meet
/// in no more than one arc, every arc has a corner, three cells meet in no more than one, and every
/// cell has one (the closed ball property: Edelsbrunner and Shah 1997, here of graph cells). All of
/// these conditions are counts: the Euler characteristic V - E + F of the inside of a cell is 1 for
/// a disk, and that of mixed edges and mixed triangles is the number of arcs.
pub(super) fn faults(
    surface: &Surface<'_>,
    growth: &Growth,
    doubtful: &[bool],
    sizes: &[u32],
    inside: impl Fn(usize) -> bool,
    par: Par,
) -> Vec<u32> {
    let cells = doubtful.len();
    let counts = par.map_blocks(surface.len(), BLOCK, |range| {
        let mut counts = Counts::default();
        for v in range {
            counts.add_vertex(surface, growth, doubtful, v as u32);
        }
        counts
    });
    let mut euler = vec![0i64; cells];
    let mut touches = vec![0i64; cells];
    let (mut arcs, mut triples) = (Vec::new(), Vec::new());
    for counts in counts {
        for (cell, change) in counts.within {
            euler[cell as usize] += i64::from(change);
        }
        for (cell, change) in counts.boundary {
            touches[cell as usize] += i64::from(change);
        }
        arcs.extend(counts.arcs);
        triples.extend(counts.triples);
    }
    arcs.sort_unstable();
    triples.sort_unstable();

    let mut bad = vec![false; cells];
    // Cells of one vertex can't be split: of several cells that violate a condition together, the
    // largest is split.
    let blame = |cells: &[u32], bad: &mut Vec<bool>| {
        if let Some(&cell) = cells.iter().max_by_key(|&&c| (sizes[c as usize], u32::MAX - c)) {
            bad[cell as usize] = true;
        }
    };
    let mut has_corner = vec![false; cells];
    triples.iter().flatten().for_each(|&cell| has_corner[cell as usize] = true);
    for cell in (0..cells).filter(|&cell| doubtful[cell]) {
        // A cell without a corner would be lost; if it can't be split, its neighbours must be.
        let strays = touches[cell] > 0 && inside(cell);
        bad[cell] = euler[cell] != 1 || touches[cell] > 1 || !has_corner[cell] || strays;
    }
    for group in triples.chunk_by(|a, b| a == b).filter(|group| group.len() > 1) {
        blame(&group[0], &mut bad);
    }
    // Arcs that have a corner.
    let mut cornered: Vec<u64> =
        triples.iter().flat_map(|&[a, b, c]| [pair(a, b), pair(a, c), pair(b, c)]).collect();
    cornered.sort_unstable();
    for group in arcs.chunk_by(|a, b| a.0 == b.0) {
        let between = group[0].0;
        let count: i64 = group.iter().map(|&(_, change)| i64::from(change)).sum();
        if count != 1 || cornered.binary_search(&between).is_err() {
            blame(&[(between >> 32) as u32, between as u32], &mut bad);
        }
    }
    (0..cells as u32).filter(|&cell| bad[cell as usize]).collect()
}

/// The contributions of the vertices of a block, with the edges and faces of which they are the
/// lowest vertex in a doubtful cell.
#[derive(Default)]
struct Counts {
    within: Vec<(u32, i32)>,
    boundary: Vec<(u32, i32)>,
    arcs: Vec<(u64, i32)>,
    triples: Vec<[u32; 3]>,
}

impl Counts {
    fn add_vertex(&mut self, surface: &Surface<'_>, growth: &Growth, doubtful: &[bool], v: u32) {
        let own = growth.cell(v);
        let is_doubtful = |cell: u32| doubtful.get(cell as usize) == Some(&true);
        if !is_doubtful(own) {
            return;
        }
        let links = surface.links(v);
        // An edge or face belongs to this vertex unless a lower vertex of it is in a doubtful cell,
        // too.
        let ours = |to: u32, cell: u32| to > v || !is_doubtful(cell);
        let mut change = 1;
        let open = surface.on_boundary[v as usize];
        let last = links.len().wrapping_sub(1);
        let mut before =
            if open { None } else { links.last().map(|link| (link.to, growth.cell(link.to))) };
        for (k, link) in links.iter().enumerate() {
            let (to, cell) = (link.to, growth.cell(link.to));
            if ours(to, cell) {
                if cell == own {
                    change -= 1;
                } else {
                    self.arcs.push((pair(own, cell), 1));
                }
            }
            if let Some((other, there)) =
                before.filter(|&(other, there)| ours(to, cell) && ours(other, there))
            {
                debug_assert_ne!(other, to);
                if cell == own && there == own {
                    change += 1;
                } else if cell == own || cell == there {
                    self.arcs.push((pair(own, there), -1));
                } else if there == own {
                    self.arcs.push((pair(own, cell), -1));
                } else {
                    let mut triple = [own, cell, there];
                    triple.sort_unstable();
                    self.triples.push(triple);
                }
            }
            if open && (k == 0 || k == last) && to > v && cell == own {
                add(&mut self.boundary, own, -1);
            }
            before = Some((to, cell));
        }
        add(&mut self.within, own, change);
        if open {
            add(&mut self.boundary, own, 1);
        }
    }
}

/// Adds to the last entry if it is of the same cell, as neighbours in the list often are.
fn add(list: &mut Vec<(u32, i32)>, cell: u32, change: i32) {
    match list.last_mut() {
        Some(last) if last.0 == cell => last.1 += change,
        _ => list.push((cell, change)),
    }
}

fn pair(a: u32, b: u32) -> u64 {
    u64::from(a.min(b)) << 32 | u64::from(a.max(b))
}
