use sprs::CsMatView;

use super::Mass;
use super::check::check_symmetric;
use super::product::row_sum;
use crate::base::{Result, Sets};

/// Counts the eigenvalues of `W phi = lambda M phi` that are zero because W is a Laplacian: one for
/// each connected component of the graph of W and M in which the rows of W sum to zero (to within
/// rounding). W is n x n, symmetric, with all entries stored, by rows.
///
/// ```
/// use catamaran::sparse::{CsMat, Mass, free_components};
///
/// // Two vertices that an edge joins, one that is held at zero, and one alone.
/// let edge = [1.0, -1.0, -1.0, 1.0, 2.0];
/// let w = CsMat::new((4, 4), vec![0, 2, 4, 5, 5], vec![0, 1, 0, 1, 2], edge.to_vec());
/// assert_eq!(free_components(w.view(), &Mass::identity(4))?, 2);
/// # Ok::<(), catamaran::Error>(())
/// ```
///
/// # Errors
/// [`Error::Shape`](crate::Error::Shape), [`Error::NonFinite`](crate::Error::NonFinite) and
/// [`Error::Argument`](crate::Error::Argument) name W ("stiffness") or "mass", as
/// [`eigs`](super::eigs()) does.
pub fn free_components(stiffness: CsMatView<'_, f64>, mass: &Mass) -> Result<usize> {
    check_symmetric("stiffness", stiffness)?;
    mass.check(stiffness.rows())?;
    Ok(null_components(stiffness, mass).len())
}

/// Returns the null vectors of W that can be seen without arithmetic: each is 1 on one connected
/// component of the graph of W and M, if the rows of W there sum to zero, and 0 elsewhere. They are
/// lists of rows, in the order of their first rows.
pub(crate) fn null_components(stiffness: CsMatView<'_, f64>, mass: &Mass) -> Vec<Vec<usize>> {
    let n = stiffness.rows();
    let mut sets = Sets::new(n);
    let mut join = |matrix: CsMatView<'_, f64>| {
        for (i, row) in matrix.outer_iterator().enumerate() {
            let entries = row.iter().filter(|&(_, &x)| x != 0.0);
            entries.for_each(|(j, _)| sets.join(i as u32, j as u32));
        }
    };
    join(stiffness);
    if let Mass::Full(matrix) = mass {
        join(matrix.view());
    }
    let mut components = vec![Some(Vec::new()); n];
    for (i, row) in stiffness.outer_iterator().enumerate() {
        let component = &mut components[sets.find(i as u32) as usize];
        if row_sum(row.data()) != 0.0 {
            *component = None;
        }
        if let Some(rows) = component {
            rows.push(i);
        }
    }
    components.into_iter().flatten().filter(|rows| !rows.is_empty()).collect()
}

#[cfg(test)]
mod tests {
    use sprs::TriMat;

    use super::*;

    #[test]
    fn components_with_rows_that_sum_to_zero_are_found_in_the_order_of_their_rows() {
        let mut entries = TriMat::new((7, 7));
        // 0 - 4 and 1 - 2 - 6 are free; 5 is held; 3 is alone.
        for (a, b) in [(0, 4), (1, 2), (2, 6)] {
            for (i, j, x) in [(a, b, -2.0), (b, a, -2.0), (a, a, 2.0), (b, b, 2.0)] {
                entries.add_triplet(i, j, x);
            }
        }
        entries.add_triplet(5, 5, 1.0);
        let w = entries.to_csr::<usize>();
        let found = null_components(w.view(), &Mass::identity(7));
        assert_eq!(found, [vec![0, 4], vec![1, 2, 6], vec![3]]);
        // A mass matrix that joins two of the components.
        let mut entries = TriMat::new((7, 7));
        (0..7).for_each(|i| entries.add_triplet(i, i, 1.0));
        entries.add_triplet(0, 1, 0.1);
        entries.add_triplet(1, 0, 0.1);
        let found = null_components(w.view(), &Mass::Full(entries.to_csr()));
        assert_eq!(found, [vec![0, 1, 2, 4, 6], vec![3]]);
    }
}
