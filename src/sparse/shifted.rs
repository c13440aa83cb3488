use faer::sparse::{SparseColMatRef, SymbolicSparseColMatRef};
use sprs::CsMatView;

use super::Mass;

/// The lower triangle of `W - sigma M` by columns, its diagonal always stored: the same pattern for
/// every sigma.
pub struct Shifted<'a> {
    stiffness: CsMatView<'a, f64>,
    mass: &'a Mass,
    column_starts: Vec<usize>,
    rows: Vec<usize>,
}

impl<'a> Shifted<'a> {
    /// Finds the places of the entries of `W - sigma M`.
    pub fn new(stiffness: CsMatView<'a, f64>, mass: &'a Mass) -> Self {
        let mut shifted = Self { stiffness, mass, column_starts: vec![0], rows: Vec::new() };
        for j in 0..stiffness.rows() {
            let mut rows = Vec::new();
            shifted.for_column(j, |i, _, _| rows.push(i));
            shifted.rows.extend(rows);
            shifted.column_starts.push(shifted.rows.len());
        }
        shifted
    }

    /// Calls `entry(row, of W, of M)` for the places of column j, from the diagonal down. Symmetric
    /// matrices: rows are columns.
    fn for_column(&self, j: usize, mut entry: impl FnMut(usize, f64, f64)) {
        let w = self.stiffness.outer_view(j).expect("as many rows as columns");
        let mut w = Cursor::new(w.indices(), w.data(), j);
        let diagonal;
        let row;
        let mut m = match self.mass {
            Mass::Lumped(masses) => {
                diagonal = ([j], [masses[j]]);
                Cursor::new(&diagonal.0, &diagonal.1, j)
            }
            Mass::Full(matrix) => {
                row = matrix.outer_view(j).expect("as many rows as W");
                Cursor::new(row.indices(), row.data(), j)
            }
        };
        let mut next = Some(j);
        while let Some(i) = next {
            entry(i, w.take(i), m.take(i));
            next = w.row().into_iter().chain(m.row()).min();
        }
    }

    /// Returns the number of rows.
    pub(crate) fn len(&self) -> usize {
        self.stiffness.rows()
    }

    /// Returns the bytes of the pattern, and of the entries while they exist.
    pub fn bytes(&self) -> usize {
        (self.column_starts.len() + 2 * self.rows.len()) * size_of::<usize>()
    }

    /// Returns the entries of the matrix for this sigma.
    pub fn values(&self, sigma: f64) -> Vec<f64> {
        let mut values = Vec::with_capacity(self.rows.len());
        for j in 0..self.len() {
            self.for_column(j, |_, w, m| values.push(w - sigma * m));
        }
        values
    }

    /// Returns the matrix with these entries.
    pub fn matrix<'b>(&'b self, values: &'b [f64]) -> SparseColMatRef<'b, usize, f64> {
        SparseColMatRef::new(self.symbolic(), values)
    }

    /// Returns the places of the entries.
    pub fn symbolic(&self) -> SymbolicSparseColMatRef<'_, usize> {
        let n = self.len();
        SymbolicSparseColMatRef::new_checked(n, n, &self.column_starts, None, &self.rows)
    }
}

/// A position in a sparse column that only moves down.
struct Cursor<'a> {
    rows: &'a [usize],
    values: &'a [f64],
}

impl<'a> Cursor<'a> {
    /// Creates a cursor at the first entry at or below `first`.
    fn new(rows: &'a [usize], values: &'a [f64], first: usize) -> Self {
        let skipped = rows.partition_point(|&i| i < first);
        Self { rows: &rows[skipped..], values: &values[skipped..] }
    }

    /// Returns the row of the cursor's entry.
    fn row(&self) -> Option<usize> {
        self.rows.first().copied()
    }

    /// Returns the entry of row i and steps on, if the cursor is there; otherwise returns 0.
    fn take(&mut self, i: usize) -> f64 {
        if self.row() != Some(i) {
            return 0.0;
        }
        let value = self.values[0];
        (self.rows, self.values) = (&self.rows[1..], &self.values[1..]);
        value
    }
}
