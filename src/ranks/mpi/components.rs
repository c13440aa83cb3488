//! Null vectors of a distributed matrix that can be seen without arithmetic.

use faer::Mat;
use sprs::CsMatView;

use super::call::Call;
use super::exchange::{Rows, gather_lists};
use super::spread::SpreadMatrix;
use crate::base::{Result, Sets};
use crate::sparse::row_sum;

/// Finds the components that `sparse::free_components` counts, of matrices with distributed rows:
/// for each, in the order of their first rows, those of its rows that this rank has. `matrices` are
/// W and, if it is full, M; `stiffness` has this rank's rows of W.
pub(super) fn null_components(
    call: &Call<'_>,
    rows: &Rows,
    stiffness: CsMatView<'_, f64>,
    matrices: &[&SpreadMatrix],
) -> Result<Vec<Vec<usize>>> {
    let own = rows.own();
    // The components of the graph of this rank's rows.
    let mut sets = Sets::new(own.len());
    let entries = |matrix: &SpreadMatrix, each: &mut dyn FnMut(usize, usize)| {
        for (i, row) in matrix.rows().outer_iterator().enumerate() {
            row.iter().filter(|&(_, &x)| x != 0.0).for_each(|(j, _)| each(i, j));
        }
    };
    for matrix in matrices {
        entries(matrix, &mut |i, j| {
            if j < own.len() {
                sets.join(i as u32, j as u32);
            }
        });
    }
    let first: Vec<usize> = (0..own.len()).map(|i| sets.find(i as u32) as usize).collect();
    let mut fixed = vec![false; own.len()];
    for (i, row) in stiffness.outer_iterator().enumerate() {
        fixed[first[i]] |= row_sum(row.data()) != 0.0;
    }
    // Those of all ranks by their first rows, and which of them touch.
    let mut parts = Vec::new();
    for i in (0..own.len()).filter(|&i| first[i] == i) {
        parts.extend([(own.start + i) as f64, f64::from(u8::from(fixed[i]))]);
    }
    let firsts = Mat::from_fn(own.len(), 1, |i, _| (own.start + first[i]) as f64);
    let mut pairs = Vec::new();
    for matrix in matrices {
        let all = matrix.extended(call, firsts.as_ref())?;
        entries(matrix, &mut |i, j| {
            if j >= own.len() {
                pairs.push([all[(i, 0)], all[(j, 0)]]);
            }
        });
    }
    pairs.sort_unstable_by(|a, b| a[0].total_cmp(&b[0]).then(a[1].total_cmp(&b[1])));
    pairs.dedup();
    let (parts, _) = gather_lists(call, &parts)?;
    let (pairs, _) = gather_lists(call, pairs.as_flattened())?;
    let ((parts, _), (pairs, _)) = (parts.as_chunks::<2>(), pairs.as_chunks::<2>());
    let place = |row: f64| parts.partition_point(|part| part[0] < row);
    let mut joined = Sets::new(parts.len());
    pairs.iter().for_each(|&[a, b]| joined.join(place(a) as u32, place(b) as u32));
    let component: Vec<usize> = (0..parts.len()).map(|p| joined.find(p as u32) as usize).collect();
    // The first part of a component has its rows.
    let mut found: Vec<Option<Vec<usize>>> =
        component.iter().enumerate().map(|(p, &first)| (first == p).then(Vec::new)).collect();
    for (&component, part) in component.iter().zip(parts) {
        if part[1] != 0.0 {
            found[component] = None;
        }
    }
    for (i, &first) in first.iter().enumerate() {
        let part = place((own.start + first) as f64);
        if let Some(rows) = &mut found[component[part]] {
            rows.push(own.start + i);
        }
    }
    Ok(found.into_iter().flatten().collect())
}
