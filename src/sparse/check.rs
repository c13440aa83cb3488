use sprs::CsMatView;

use crate::base::{Error, Result, spend};

/// Asymmetry that may be rounding, relative to the entries and to the diagonal.
const SYMMETRY: f64 = 1e-10;

/// Operations that finding an entry of a row is equal to.
const SEARCHED: f64 = 20.0;

/// Checks that the matrix is square, finite and symmetric; errors name `what` and the entry, its
/// row first.
pub(crate) fn check_symmetric(what: &'static str, matrix: CsMatView<'_, f64>) -> Result<()> {
    let n = matrix.rows();
    Error::check_shape(what, (n, n), matrix.shape())?;
    let place = |outer: usize, inner: usize| match matrix.is_csr() {
        true => (outer, inner),
        false => (inner, outer),
    };
    let mut diagonal = vec![0.0; n];
    for (i, row) in matrix.outer_iterator().enumerate() {
        for (j, &x) in row.iter() {
            if !x.is_finite() {
                return Err(Error::NonFinite { what, index: place(i, j) });
            }
            if i == j {
                diagonal[i] = x.abs();
            }
        }
    }
    for (i, row) in matrix.outer_iterator().enumerate() {
        spend(SEARCHED * row.nnz() as f64)?;
        for (j, &x) in row.iter().filter(|&(j, _)| j != i) {
            let mirrored = matrix.outer_view(j).and_then(|row| row.get(i).copied()).unwrap_or(0.0);
            check_mirrored(what, place(i, j), [x, mirrored], [diagonal[i], diagonal[j]])?;
        }
    }
    Ok(())
}

/// Checks that entries (i, j) and (j, i) agree up to rounding, given these magnitudes on the
/// diagonal.
pub(crate) fn check_mirrored(
    what: &'static str,
    (i, j): (usize, usize),
    [x, mirrored]: [f64; 2],
    [at_i, at_j]: [f64; 2],
) -> Result<()> {
    let scale = x.abs().max(mirrored.abs()) + (at_i * at_j).sqrt();
    if (x - mirrored).abs() <= SYMMETRY * scale {
        return Ok(());
    }
    let why = format!("not symmetric: entry ({i}, {j}) is {x:e}, ({j}, {i}) is {mirrored:e}");
    Err(Error::Argument { what, why })
}

#[cfg(test)]
mod tests {
    use sprs::TriMat;

    use super::*;

    #[test]
    fn entries_at_fault_are_named_by_row_and_column_in_either_storage() {
        let matrix = |x: f64| {
            let mut entries = TriMat::new((3, 3));
            entries.add_triplet(0, 2, x);
            entries.add_triplet(2, 0, 1.0);
            entries
        };
        for x in [f64::NAN, 2.0] {
            let by_rows = check_symmetric("A", matrix(x).to_csr::<usize>().view()).unwrap_err();
            let by_columns = check_symmetric("A", matrix(x).to_csc::<usize>().view()).unwrap_err();
            if x.is_nan() {
                assert_eq!(by_rows, Error::NonFinite { what: "A", index: (0, 2) });
                assert_eq!(by_columns, by_rows);
            } else {
                let why = "entry (2, 0) is 1e0, (0, 2) is 2e0";
                assert!(by_columns.to_string().contains(why), "{by_columns}");
            }
        }
    }
}
