//! Where the factor of a sparse matrix has entries.

use faer::sparse::SymbolicSparseColMatRef;

use super::structure::Structure;
use super::supernode::Supernode;
use crate::base::{Result, push, repeated, reserved, room};

/// Most columns of a supernode. Wider ones are cut, so that each step takes few operations; pivots
/// are chosen inside the pieces.
const WIDEST: usize = 256;

/// The supernodes of a factor and the rows of their columns.
#[derive(Debug, Default)]
pub(super) struct Pattern {
    /// Rows of the factor. Those after the last column are the border.
    pub n: usize,
    pub nodes: Vec<Supernode>,
    /// The rows below the triangles, ascending for each supernode; those of supernode s are
    /// `rows[starts[s]..starts[s + 1]]`.
    rows: Vec<u32>,
    starts: Vec<usize>,
    /// The supernode of each column.
    pub owner: Vec<u32>,
    /// Number of values of the factor.
    pub values: usize,
}

impl Pattern {
    /// Cuts the supernodes of a factor.
    pub fn new(structure: &Structure) -> Result<Self> {
        let Structure { order, nodes, rows } = structure;
        let n = order.len();
        let mut place = repeated(0u32, n)?;
        (0..).zip(order).for_each(|(i, &row)| place[row as usize] = i);
        let mut pattern =
            Self { n, owner: reserved(n)?, nodes: reserved(nodes.len())?, ..Self::default() };
        push(&mut pattern.starts, 0)?;
        let mut below: Vec<u32> = Vec::new();
        let mut first = 0;
        for node in nodes {
            let rows = &rows[node.first..node.first + node.below];
            below.clear();
            room(&mut below, rows.len())?;
            below.extend(rows.iter().map(|&row| place[row as usize]));
            below.sort_unstable();
            let end = first + node.columns;
            for start in (first..end).step_by(WIDEST) {
                let cut = end.min(start + WIDEST);
                room(&mut pattern.rows, end - cut + below.len())?;
                pattern.rows.extend(cut as u32..end as u32);
                pattern.rows.extend_from_slice(&below);
                pattern.push(start, cut - start)?;
            }
            first = end;
        }
        Ok(pattern)
    }

    /// Adds the supernode of the rows that have been added.
    fn push(&mut self, start: usize, columns: usize) -> Result<()> {
        let below = self.rows.len() - self.starts[self.nodes.len()];
        room(&mut self.owner, columns)?;
        self.owner.resize(start + columns, self.nodes.len() as u32);
        push(&mut self.nodes, Supernode { start, columns, below, values: self.values })?;
        self.values += (columns + below) * columns;
        push(&mut self.starts, self.rows.len())
    }

    /// Returns the rows below the triangle of a supernode, ascending.
    pub fn below(&self, s: usize) -> &[u32] {
        &self.rows[self.starts[s]..self.starts[s + 1]]
    }

    /// Returns the number of columns of the factor.
    pub fn columns(&self) -> usize {
        self.owner.len()
    }

    /// Returns the number of rows below all triangles.
    pub fn all_below(&self) -> usize {
        self.rows.len()
    }
}

/// The entries of a matrix by the columns of its factor.
#[derive(Debug)]
pub(super) struct Entries {
    /// Those of column j are `starts[j]..starts[j + 1]`.
    starts: Vec<usize>,
    /// The row of the factor, and the index of the entry in the matrix.
    places: Vec<(u32, usize)>,
}

impl Entries {
    /// Finds the entries in the lower triangle of a matrix; row i of the factor is row `order[i]`
    /// of the matrix.
    pub fn new(matrix: SymbolicSparseColMatRef<'_, usize>, order: &[usize]) -> Result<Self> {
        let mut place = repeated(0u32, order.len())?;
        (0..).zip(order).for_each(|(i, &row)| place[row] = i);
        // Counts of column j are two places behind it, so that filling moves them to their starts.
        let n = order.len();
        let mut starts = repeated(0usize, n + 2)?;
        for j in 0..n {
            let own = place[j];
            for &i in matrix.row_idx_of_col_raw(j).iter().filter(|i| **i >= j) {
                starts[place[i].min(own) as usize + 2] += 1;
            }
        }
        for j in 2..n + 2 {
            starts[j] += starts[j - 1];
        }
        let mut places = repeated((0, 0), starts[n + 1])?;
        for j in 0..n {
            let own = place[j];
            let entries = matrix.col_range(j).zip(matrix.row_idx_of_col_raw(j));
            for (at, &i) in entries.filter(|(_, i)| **i >= j) {
                let (column, row) = (place[i].min(own), place[i].max(own));
                let next = &mut starts[column as usize + 1];
                places[*next] = (row, at);
                *next += 1;
            }
        }
        starts.truncate(n + 1);
        Ok(Self { starts, places })
    }

    /// Returns the rows of a column of the factor and the indices of their entries.
    pub fn column(&self, j: usize) -> &[(u32, usize)] {
        &self.places[self.starts[j]..self.starts[j + 1]]
    }

    /// Returns the bytes that this takes.
    pub fn bytes(&self) -> usize {
        size_of_val(&self.starts[..]) + size_of_val(&self.places[..])
    }
}
