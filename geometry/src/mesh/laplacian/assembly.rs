use std::ops::Range;

use sprs::CsMat;

use super::super::topology::{Adjacency, corners};
use super::{Element, MassKind};
use catamaran::base::{Par, Result};
use catamaran::sparse::Mass;

/// Number of rows that a thread takes at a time.
const BLOCK: usize = 1 << 13;

/// Operations for a corner of a triangle, roughly, with its two edges.
const CORNER: f64 = 50.0;

/// A block of rows of the matrices.
#[derive(Default)]
struct Rows {
    /// Number of entries of each row.
    counts: Vec<usize>,
    columns: Vec<usize>,
    stiffness: Vec<f64>,
    /// Entries of the full mass matrix; empty if the mass is lumped.
    full: Vec<f64>,
    /// One mass for each row; empty if the mass is full.
    lumped: Vec<f64>,
}

/// Sums the elements into these rows of the matrices of n vertices. A face may have a vertex twice
/// (see [`super::Complex`]). Weights that are negative by less than `rounding`, relative to 1 and
/// to the sizes of their summands, are set to zero.
///
/// Every row is summed separately in the order of faces, so that the result is symmetric bit for
/// bit and the same for any number of threads.
pub(crate) fn assemble(
    n: usize,
    rows: Range<usize>,
    faces: &[[u32; 3]],
    elements: &[Element],
    rounding: f64,
    kind: MassKind,
    par: Par,
) -> Result<(CsMat<f64>, Mass)> {
    let corners = Adjacency::from_pairs(n, || corners(faces));
    let operations = CORNER * corners.items().len() as f64 * BLOCK as f64 / n.max(1) as f64;
    let blocks = par.map_blocks_asking(rows.len(), BLOCK, operations, |range| {
        let mut block = Rows::default();
        let mut edges = Vec::new();
        for vertex in range.map(|i| rows.start + i) {
            block.push(vertex, corners.row(vertex), faces, elements, rounding, kind, &mut edges);
        }
        block
    })?;
    let entries = blocks.iter().map(|b| b.columns.len()).sum();
    let mut starts = Vec::with_capacity(rows.len() + 1);
    starts.push(0);
    let mut columns = Vec::with_capacity(entries);
    let mut stiffness = Vec::with_capacity(entries);
    let mut full = Vec::new();
    let mut lumped = Vec::new();
    let mut end = 0;
    for block in blocks {
        for count in block.counts {
            end += count;
            starts.push(end);
        }
        columns.extend(block.columns);
        stiffness.extend(block.stiffness);
        full.extend(block.full);
        lumped.extend(block.lumped);
    }
    let mass = match kind {
        MassKind::Consistent => {
            Mass::Full(CsMat::new((rows.len(), n), starts.clone(), columns.clone(), full))
        }
        MassKind::Barycentric | MassKind::MixedVoronoi => Mass::Lumped(lumped),
    };
    Ok((CsMat::new((rows.len(), n), starts, columns, stiffness), mass))
}

impl Rows {
    /// Appends the row of a vertex from its corners; `edges` is a buffer.
    fn push(
        &mut self,
        vertex: usize,
        corners: &[u32],
        faces: &[[u32; 3]],
        elements: &[Element],
        rounding: f64,
        kind: MassKind,
        edges: &mut Vec<(u32, u32)>,
    ) {
        // Neighbours with the edge that joins them, 3 face + edge, ascending, so that both ends of
        // an edge of several faces sum its weights in the same order.
        edges.clear();
        let (mut own, mut lumped) = (0.0, 0.0);
        for &corner in corners {
            let (face, k) = (corner / 3, corner % 3);
            let element = &elements[face as usize];
            let others = [((k + 1) % 3, k), ((k + 2) % 3, (k + 2) % 3)];
            for (other, edge) in others {
                edges.push((faces[face as usize][other as usize], 3 * face + edge));
            }
            own += element.area / 6.0;
            lumped += match kind {
                MassKind::MixedVoronoi => element.mixed_voronoi(k as usize),
                MassKind::Barycentric | MassKind::Consistent => element.area / 3.0,
            };
        }
        edges.sort_unstable();
        let before = self.columns.len();
        let mut diagonal = 0.0;
        let mut diagonal_at = None;
        for run in edges.chunk_by(|a, b| a.0 == b.0) {
            let neighbour = run[0].0 as usize;
            let (mut weight, mut mass, mut size) = (0.0, 0.0, 0.0);
            for &(_, edge) in run {
                let element = &elements[edge as usize / 3];
                let half_cotangent: f64 = element.weights[edge as usize % 3];
                weight += half_cotangent;
                size += 1.0 + half_cotangent.abs();
                mass += element.area / 12.0;
            }
            if neighbour == vertex {
                // An edge from a vertex to itself has no weight: its differences are zero.
                own += mass;
                continue;
            }
            if weight < 0.0 && weight > -rounding * size {
                weight = 0.0;
            }
            diagonal += weight;
            if neighbour > vertex && diagonal_at.is_none() {
                diagonal_at = Some(self.reserve(vertex, kind));
            }
            self.columns.push(neighbour);
            self.stiffness.push(-weight);
            if kind == MassKind::Consistent {
                self.full.push(mass);
            }
        }
        let at = diagonal_at.unwrap_or_else(|| self.reserve(vertex, kind));
        self.stiffness[at] = diagonal;
        match kind {
            MassKind::Consistent => self.full[at] = own,
            MassKind::Barycentric | MassKind::MixedVoronoi => self.lumped.push(lumped),
        }
        self.counts.push(self.columns.len() - before);
    }

    /// Appends an empty entry of this column.
    fn reserve(&mut self, column: usize, kind: MassKind) -> usize {
        self.columns.push(column);
        self.stiffness.push(0.0);
        if kind == MassKind::Consistent {
            self.full.push(0.0);
        }
        self.columns.len() - 1
    }
}
