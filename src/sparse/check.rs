use sprs::CsMatView;

use crate::base::{Error, Result, reserved, spend};

/// Asymmetry that may be rounding, relative to the entries and to the diagonal.
const SYMMETRY: f64 = 1e-10;

/// Operations that finding an entry of a row is equal to.
const SEARCHED: f64 = 20.0;

/// Operations that reading an entry is equal to.
const PASSED: f64 = 5.0;

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
    if is_symmetric(matrix, &diagonal)? {
        return Ok(());
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

/// Returns whether a square matrix is symmetric up to rounding, given the magnitudes on its
/// diagonal, in one pass: the entries before the diagonal of a row are met in their order as those
/// after the diagonals of earlier rows.
fn is_symmetric(matrix: CsMatView<'_, f64>, diagonal: &[f64]) -> Result<bool> {
    let starts = matrix.indptr();
    let (starts, indices, entries) = (starts.raw_storage(), matrix.indices(), matrix.data());
    let offset = starts.first().copied().unwrap_or(0);
    // The next entry before the diagonal of each row.
    let mut next = reserved(diagonal.len())?;
    next.extend(starts[..diagonal.len()].iter().map(|start| start - offset));
    let agree = |i: usize, j: usize, pair: [f64; 2]| is_close(pair, [diagonal[i], diagonal[j]]);
    for i in 0..diagonal.len() {
        let (from, to) = (next[i], starts[i + 1] - offset);
        spend(PASSED * (to - from) as f64)?;
        for k in from..to {
            let (j, x) = (indices[k], entries[k]);
            if j < i && !agree(i, j, [x, 0.0]) {
                // The earlier row has no entry for it.
                return Ok(false);
            }
            if j <= i {
                continue;
            }
            let end = starts[j + 1] - offset;
            let mut mirrored = 0.0;
            while next[j] < end && indices[next[j]] <= i {
                let (at, other) = (next[j], indices[next[j]]);
                next[j] += 1;
                if other == i {
                    mirrored = entries[at];
                } else if !agree(j, other, [entries[at], 0.0]) {
                    return Ok(false);
                }
            }
            if !agree(i, j, [x, mirrored]) {
                return Ok(false);
            }
        }
    }
    Ok(true)
}

/// Checks that entries (i, j) and (j, i) agree up to rounding, given these magnitudes on the
/// diagonal.
pub(crate) fn check_mirrored(
    what: &'static str,
    (i, j): (usize, usize),
    [x, mirrored]: [f64; 2],
    [at_i, at_j]: [f64; 2],
) -> Result<()> {
    if is_close([x, mirrored], [at_i, at_j]) {
        return Ok(());
    }
    let why = format!("not symmetric: entry ({i}, {j}) is {x:e}, ({j}, {i}) is {mirrored:e}");
    Err(Error::Argument { what, why })
}

/// Returns whether two mirrored entries agree up to rounding, given the diagonal of their rows.
fn is_close([x, mirrored]: [f64; 2], [at_i, at_j]: [f64; 2]) -> bool {
    let scale = || x.abs().max(mirrored.abs()) + (at_i * at_j).sqrt();
    x == mirrored || (x - mirrored).abs() <= SYMMETRY * scale()
}

#[cfg(test)]
mod tests {
    use sprs::{CsMat, TriMat};

    use super::*;
    use crate::base::Rng;

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
    /// Returns whether the entries of a matrix agree with their mirrored ones, one by one.
    fn agree(matrix: &CsMat<f64>) -> bool {
        let of = |i: usize, j: usize| matrix.get(i, j).copied().unwrap_or(0.0);
        let n = matrix.rows();
        let mut pairs = (0..n).flat_map(|i| (0..n).map(move |j| (i, j)));
        pairs.all(|(i, j)| is_close([of(i, j), of(j, i)], [of(i, i).abs(), of(j, j).abs()]))
    }

    #[test]
    fn one_pass_finds_what_single_entries_show() {
        let mut rng = Rng::new(6);
        let mut below = |n: usize| (rng.bits() % n as u64) as usize;
        let mut symmetric = 0;
        for k in 0..2000 {
            let n = 1 + below(6);
            let mut dense = vec![0.0; n * n];
            for _ in 0..below(2 * n) {
                let (i, j) = (below(n), below(n));
                // Some are 0 although they are stored, and most have a mirrored one.
                let x = [0.0, 1.0, 2.0, 1e-11][below(4)];
                dense[i * n + j] = x;
                dense[j * n + i] = x;
            }
            if k % 2 == 0 {
                dense[below(n * n)] += [1.0, 1e-12][below(2)];
            }
            let mut entries = TriMat::new((n, n));
            for at in 0..n * n {
                if dense[at] != 0.0 || below(4) == 0 {
                    entries.add_triplet(at / n, at % n, dense[at]);
                }
            }
            let matrix: CsMat<f64> = entries.to_csr();
            let expected = agree(&matrix);
            symmetric += usize::from(expected);
            assert_eq!(check_symmetric("A", matrix.view()).is_ok(), expected, "{dense:?}");
            let diagonal: Vec<f64> =
                (0..n).map(|i| matrix.get(i, i).map_or(0.0, |x| x.abs())).collect();
            assert_eq!(is_symmetric(matrix.view(), &diagonal).unwrap(), expected, "{dense:?}");
        }
        assert!(symmetric > 800 && symmetric < 1800, "{symmetric}");
    }
}
