//! Orders of elimination in which each subtree of the elimination tree is contiguous, as supernodes
//! need it.

use faer::sparse::SymbolicSparseColMatRef;

use crate::base::{Result, push, repeated, reserved, spend};

/// Marks that there is no other row.
const NONE: u32 = u32::MAX;

/// Operations to which a step in the elimination tree is equal, roughly.
const STEP: f64 = 10.0;

/// Returns the rows of a matrix, of which the lower triangle is read, in a postorder of the
/// elimination tree of this order: the factor has as many entries.
pub(super) fn postordered(
    matrix: SymbolicSparseColMatRef<'_, usize>,
    order: &[usize],
) -> Result<Vec<usize>> {
    let parents = parents(matrix, order)?;
    let n = order.len();
    let (mut child, mut sibling) = (repeated(NONE, n)?, repeated(NONE, n)?);
    for i in (0..n).rev().filter(|&i| parents[i] != NONE) {
        let parent = parents[i] as usize;
        sibling[i] = std::mem::replace(&mut child[parent], i as u32);
    }
    let (mut found, mut above) = (reserved(n)?, Vec::new());
    for root in (0..n).filter(|&i| parents[i] == NONE) {
        push(&mut above, root)?;
        while let Some(&node) = above.last() {
            match child[node] {
                NONE => {
                    found.push(order[node]);
                    above.pop();
                }
                next => {
                    child[node] = sibling[next as usize];
                    push(&mut above, next as usize)?;
                }
            }
        }
    }
    Ok(found)
}

/// Returns the parent in the elimination tree of each row of the factor, [`NONE`] for roots
/// (Liu 1990).
fn parents(matrix: SymbolicSparseColMatRef<'_, usize>, order: &[usize]) -> Result<Vec<u32>> {
    let n = order.len();
    let mut place = repeated(0u32, n)?;
    (0..).zip(order).for_each(|(i, &row)| place[row] = i);
    let pairs = || {
        let place = &place;
        (0..n).flat_map(move |j| {
            let below = matrix.row_idx_of_col_raw(j).iter().filter(move |i| **i > j);
            below.map(move |&i| (place[i].min(place[j]), place[i].max(place[j]) as usize))
        })
    };
    // For each row of the factor, the earlier ones that it has entries with.
    let mut starts = repeated(0usize, n + 1)?;
    for (_, later) in pairs() {
        starts[later + 1] += 1;
    }
    for i in 0..n {
        starts[i + 1] += starts[i];
    }
    let mut next = reserved(n + 1)?;
    next.extend_from_slice(&starts);
    let mut earlier = repeated(0u32, starts[n])?;
    for (first, later) in pairs() {
        earlier[next[later]] = first;
        next[later] += 1;
    }
    // Ancestors are shortcuts to the root of the tree so far.
    let (mut parents, mut ancestors) = (repeated(NONE, n)?, repeated(NONE, n)?);
    for i in 0..n {
        let rows = &earlier[starts[i]..starts[i + 1]];
        spend(STEP * rows.len() as f64)?;
        for &row in rows {
            let mut row = row as usize;
            while ancestors[row] != i as u32 {
                let above = std::mem::replace(&mut ancestors[row], i as u32);
                if above == NONE {
                    parents[row] = i as u32;
                    break;
                }
                row = above as usize;
            }
        }
    }
    Ok(parents)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Returns the column starts and the rows of the lower triangle of a graph, with the diagonal.
    fn lower(n: usize, mut edges: Vec<(usize, usize)>) -> (Vec<usize>, Vec<usize>) {
        edges.extend((0..n).map(|i| (i, i)));
        let mut edges: Vec<_> = edges.into_iter().map(|(i, j)| (i.min(j), i.max(j))).collect();
        edges.sort_unstable();
        edges.dedup();
        let starts = (0..=n).map(|j| edges.partition_point(|&(column, _)| column < j)).collect();
        (starts, edges.into_iter().map(|(_, row)| row).collect())
    }

    #[test]
    fn the_tree_of_a_path_is_known() {
        // 0 - 1 - 2 - 3 - 4, eliminated as 1, 3, 0, 2, 4: row 2 joins 1, 3, and then 0 and 4.
        let (starts, rows) = lower(5, (1..5).map(|i| (i - 1, i)).collect());
        let matrix = SymbolicSparseColMatRef::new_checked(5, 5, &starts, None, &rows);
        let order = [1, 3, 0, 2, 4];
        assert_eq!(parents(matrix, &order).unwrap(), [2, 3, 3, 4, NONE]);
        assert_eq!(postordered(matrix, &order).unwrap(), [3, 1, 0, 2, 4]);
    }

    #[test]
    fn subtrees_become_contiguous_and_keep_their_parents() {
        let mut rng = crate::base::Rng::new(4);
        for n in [0, 1, 2, 13, 101] {
            let mut node = || rng.bits() as usize % n.max(1);
            let edges = (0..n).map(|_| (node(), node())).collect();
            let (starts, rows) = lower(n, edges);
            let matrix = SymbolicSparseColMatRef::new_checked(n, n, &starts, None, &rows);
            // A step that is prime to n.
            let order: Vec<usize> = (0..n).map(|i| (5 * i + 3) % n).collect();
            let after = postordered(matrix, &order).unwrap();
            let mut sorted = after.clone();
            sorted.sort_unstable();
            assert_eq!(sorted, (0..n).collect::<Vec<_>>());
            // By rows of the matrix.
            let tree = |order: &[usize]| {
                let mut found = vec![None; n];
                for (i, parent) in parents(matrix, order).unwrap().into_iter().enumerate() {
                    found[order[i]] = order.get(parent as usize).copied();
                }
                found
            };
            assert_eq!(tree(&after), tree(&order), "n = {n}");
            // The rows below each one end at it.
            let parents = parents(matrix, &after).unwrap();
            let mut first: Vec<usize> = (0..n).collect();
            let mut size = vec![1; n];
            for i in 0..n {
                assert_eq!(i + 1 - size[i], first[i], "n = {n}, row {i}");
                if parents[i] != NONE {
                    let parent = parents[i] as usize;
                    assert!(parent > i);
                    first[parent] = first[parent].min(first[i]);
                    size[parent] += size[i];
                }
            }
        }
    }
}
