use sprs::CsMatView;

use super::Mass;

/// Sum of a row of W that is still rounding, relative to the sum of its magnitudes.
const ROUNDING: f64 = 1e-12;

/// The null vectors of W that can be seen without arithmetic: each is 1 on one connected component of the graph of W
/// and M, if the rows of W there sum to zero, and 0 elsewhere. As lists of rows, in the order of their first rows.
pub(crate) fn null_components(stiffness: CsMatView<'_, f64>, mass: &Mass) -> Vec<Vec<usize>> {
    let n = stiffness.rows();
    let mut parent: Vec<usize> = (0..n).collect();
    fn root(parent: &mut [usize], mut i: usize) -> usize {
        while parent[i] != i {
            parent[i] = parent[parent[i]];
            i = parent[i];
        }
        i
    }
    let mut join = |matrix: CsMatView<'_, f64>| {
        for (i, row) in matrix.outer_iterator().enumerate() {
            for (j, _) in row.iter().filter(|&(_, &x)| x != 0.0) {
                let (a, b) = (root(&mut parent, i), root(&mut parent, j));
                // The first row of a component is its root.
                parent[a.max(b)] = a.min(b);
            }
        }
    };
    join(stiffness);
    if let Mass::Full(matrix) = mass {
        join(matrix.view());
    }
    let mut components = vec![Some(Vec::new()); n];
    for (i, row) in stiffness.outer_iterator().enumerate() {
        let (sum, magnitude) =
            row.data().iter().fold((0.0, 0.0), |(s, m), x| (s + x, m + f64::abs(*x)));
        let component = &mut components[root(&mut parent, i)];
        if f64::abs(sum) > ROUNDING * magnitude {
            *component = None;
        }
        if let Some(rows) = component {
            rows.push(i);
        }
    }
    components.into_iter().flatten().filter(|rows| !rows.is_empty()).collect()
}
