//! The lower triangle of a symmetric matrix that is stored by rows or by columns, whole or in part.

use faer::sparse::SymbolicSparseColMatRef;
use sprs::CsMatView;

use super::super::check::check_symmetric;
use super::options::Triangle;
use crate::base::{Error, Result, repeated, reserved, spend, zeros};

/// Operations to which reading an entry is equal, roughly.
const READ: f64 = 4.0;

/// Where the lower triangle has entries, by columns. The diagonal comes first in each column,
/// whether it is stored or not.
#[derive(Debug)]
pub(super) struct Lower {
    triangle: Triangle,
    /// Column j is `starts[j]..starts[j + 1]` of the entries.
    starts: Vec<usize>,
    /// The row of each entry.
    rows: Vec<usize>,
}

impl Lower {
    /// Finds the places of the entries of a matrix, of which one triangle is read.
    pub fn new<T: Copy>(a: CsMatView<'_, T>, triangle: Triangle) -> Result<Self> {
        let n = a.rows();
        Error::check_shape("A", (n, n), a.shape())?;
        if n > i32::MAX as usize {
            let why = format!("{n} rows, {} are possible", i32::MAX);
            return Err(Error::Argument { what: "A", why });
        }
        match is_by_columns(a, triangle) {
            true => Self::of_columns(a, triangle),
            false => Self::of_rows(a, triangle),
        }
    }

    /// Computes [`Lower::new`] where a line of the matrix ends with a column of the lower triangle,
    /// from the diagonal on.
    fn of_columns<T: Copy>(a: CsMatView<'_, T>, triangle: Triangle) -> Result<Self> {
        let n = a.rows();
        let after = |j: usize, indices: &[usize]| indices.partition_point(|&i| i <= j);
        let mut starts = reserved(n + 1)?;
        starts.push(0);
        let mut all = 0;
        for (j, line) in a.outer_iterator().enumerate() {
            all += 1 + line.nnz() - after(j, line.indices());
            starts.push(all);
        }
        let mut rows = reserved(all)?;
        for (j, line) in a.outer_iterator().enumerate() {
            spend(READ * line.nnz() as f64)?;
            rows.push(j);
            rows.extend_from_slice(&line.indices()[after(j, line.indices())..]);
        }
        Ok(Self { triangle, starts, rows })
    }

    /// Computes [`Lower::new`] where a line of the matrix begins with a row of the lower triangle,
    /// up to the diagonal.
    fn of_rows<T: Copy>(a: CsMatView<'_, T>, triangle: Triangle) -> Result<Self> {
        let n = a.rows();
        let mut starts = repeated(1usize, n + 1)?;
        starts[0] = 0;
        for_each(a, triangle, |row, column, _| {
            starts[column + 1] += usize::from(row != column);
            Ok(())
        })?;
        for j in 0..n {
            starts[j + 1] += starts[j];
        }
        let mut lower = Self { triangle, rows: repeated(0, starts[n])?, starts };
        let mut next = lower.below_the_diagonal()?;
        for j in 0..n {
            lower.rows[lower.starts[j]] = j;
        }
        for_each(a, triangle, |row, column, _| {
            if row != column {
                lower.rows[next[column]] = row;
                next[column] += 1;
            }
            Ok(())
        })?;
        Ok(lower)
    }

    /// Returns the number of rows of the matrix.
    pub fn n(&self) -> usize {
        self.starts.len() - 1
    }

    /// Returns the bytes that this takes.
    pub fn bytes(&self) -> usize {
        size_of_val(&self.starts[..]) + size_of_val(&self.rows[..])
    }

    /// Returns the places of the entries.
    pub fn places(&self) -> SymbolicSparseColMatRef<'_, usize> {
        let n = self.n();
        SymbolicSparseColMatRef::new_checked(n, n, &self.starts, None, &self.rows)
    }

    /// Returns the entries of a matrix in these places; those that it does not store are 0.
    pub fn values(&self, a: CsMatView<'_, f64>) -> Result<Vec<f64>> {
        let n = self.n();
        Error::check_shape("A", (n, n), a.shape())?;
        if self.triangle == Triangle::Both {
            check_symmetric("A", a)?;
        }
        let named = |row: usize, column: usize| match self.triangle {
            Triangle::Upper => (column, row),
            _ => (row, column),
        };
        let mut values = zeros(self.rows.len())?;
        let mut next = self.below_the_diagonal()?;
        for_each(a, self.triangle, |row, column, x| {
            if !x.is_finite() {
                return Err(Error::NonFinite { what: "A", index: named(row, column) });
            }
            let mut place = self.starts[column];
            if row != column {
                let end = self.starts[column + 1];
                place = next[column];
                while place < end && self.rows[place] < row {
                    place += 1;
                }
                if place == end || self.rows[place] != row {
                    let (i, j) = named(row, column);
                    let why = format!("entry ({i}, {j}) is not in the pattern that was analysed");
                    return Err(Error::Argument { what: "A", why });
                }
                next[column] = place + 1;
            }
            values[place] = x;
            Ok(())
        })?;
        Ok(values)
    }

    /// Returns the diagonal entry of a row, given the entries.
    pub fn diagonal(&self, values: &[f64], row: usize) -> f64 {
        values[self.starts[row]]
    }

    /// Returns for each column where its entries below the diagonal begin.
    fn below_the_diagonal(&self) -> Result<Vec<usize>> {
        let mut next = reserved(self.n())?;
        next.extend(self.starts[..self.n()].iter().map(|start| start + 1));
        Ok(next)
    }
}

/// Returns whether columns of the lower triangle are read from the ends of the lines of a matrix:
/// of two equal triangles always.
fn is_by_columns<T>(a: CsMatView<'_, T>, triangle: Triangle) -> bool {
    match triangle {
        Triangle::Both => true,
        Triangle::Lower => a.is_csc(),
        Triangle::Upper => a.is_csr(),
    }
}

/// Calls `visit(row, column, entry)` for the entries of a triangle, as those of the lower one. The
/// rows of each column ascend.
fn for_each<T: Copy>(
    a: CsMatView<'_, T>,
    triangle: Triangle,
    mut visit: impl FnMut(usize, usize, T) -> Result<()>,
) -> Result<()> {
    let is_after = is_by_columns(a, triangle);
    for (outer, line) in a.outer_iterator().enumerate() {
        spend(READ * line.nnz() as f64)?;
        for (inner, &x) in line.iter() {
            if inner == outer || (inner > outer) == is_after {
                visit(inner.max(outer), inner.min(outer), x)?;
            }
        }
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use sprs::{CsMat, TriMat};

    use super::*;

    /// Returns the entries (i, j) with 10 i + j as values, both triangles equal, except that the
    /// triangle that is not wanted has other values.
    fn matrix(triangle: Triangle) -> TriMat<f64> {
        let mut entries = TriMat::new((4, 4));
        for (i, j) in [(0, 0), (2, 0), (3, 0), (2, 1), (3, 2), (3, 3)] {
            let x = (10 * i + j) as f64;
            let (below, above) = match triangle {
                Triangle::Lower => (x, -1.0),
                Triangle::Upper => (-1.0, x),
                Triangle::Both => (x, x),
            };
            entries.add_triplet(i, j, if i == j { x } else { below });
            if i != j {
                entries.add_triplet(j, i, above);
            }
        }
        entries
    }

    #[test]
    fn the_lower_triangle_is_the_same_from_any_storage() {
        for triangle in [Triangle::Lower, Triangle::Upper, Triangle::Both] {
            let matrix = matrix(triangle);
            for a in [matrix.to_csr::<usize>(), matrix.to_csc()] {
                let lower = Lower::new(a.view(), triangle).unwrap();
                assert_eq!(lower.starts, [0, 3, 5, 7, 8], "{triangle:?}");
                assert_eq!(lower.rows, [0, 2, 3, 1, 2, 2, 3, 3], "{triangle:?}");
                let values = lower.values(a.view()).unwrap();
                // Rows 1 and 2 have no diagonal entry.
                assert_eq!(values, [0.0, 20.0, 30.0, 0.0, 21.0, 0.0, 32.0, 33.0], "{triangle:?}");
                assert_eq!(lower.diagonal(&values, 3), 33.0);
            }
        }
    }

    #[test]
    fn other_values_may_leave_places_empty_and_not_add_any() {
        let of = |places: &[(usize, usize)]| -> CsMat<f64> {
            let mut entries = TriMat::new((3, 3));
            places.iter().for_each(|&(i, j)| entries.add_triplet(i, j, (i + j) as f64));
            entries.to_csr()
        };
        let all = of(&[(0, 0), (1, 0), (2, 0), (2, 2)]);
        let lower = Lower::new(all.view(), Triangle::Lower).unwrap();
        let fewer = of(&[(2, 0)]);
        assert_eq!(lower.values(fewer.view()).unwrap(), [0.0, 0.0, 2.0, 0.0, 0.0]);
        // The diagonal always has places.
        assert_eq!(lower.values(of(&[(1, 1)]).view()).unwrap(), [0.0, 0.0, 0.0, 2.0, 0.0]);
        let refused = lower.values(of(&[(2, 1)]).view()).unwrap_err().to_string();
        assert_eq!(refused, "A: entry (2, 1) is not in the pattern that was analysed");
        let refused = lower.values(CsMat::zero((4, 4)).view()).unwrap_err();
        assert!(matches!(refused, Error::Shape { what: "A", .. }));
    }

    #[test]
    fn numbers_that_are_not_finite_are_named_where_they_are_stored() {
        for triangle in [Triangle::Lower, Triangle::Upper, Triangle::Both] {
            let mut entries = TriMat::new((3, 3));
            let place = if triangle == Triangle::Upper { (0, 2) } else { (2, 0) };
            entries.add_triplet(place.0, place.1, f64::NAN);
            for a in [entries.to_csr::<usize>(), entries.to_csc()] {
                let lower = Lower::new(a.view(), triangle).unwrap();
                let refused = lower.values(a.view()).unwrap_err();
                assert_eq!(refused, Error::NonFinite { what: "A", index: place }, "{triangle:?}");
            }
        }
    }
}
