//! Graphs divided among processes, by the means of nested dissection. A graph is the rows of a
//! matrix with the weights of the edges, integers below 2^32.

use sprs::CsMatView;

use super::coarse::Weighted;
use super::dissection;
use super::graph::NONE;
use crate::base::{Result, Rng, repeated, reserved};

/// How much heavier than half a half may be, relative to it.
const SLACK: f64 = 0.03;

/// Halvings of the part of a process, where parts are joined: processes are no power of two.
const FINER: u32 = 3;

/// Returns pairs of the first vertices of a graph, of which `rows` are the rows, and the pair of
/// each vertex. Both of a pair are neighbours, or the same.
pub(crate) fn paired(
    rows: CsMatView<'_, f64>,
    vertices: &[f64],
) -> Result<(Vec<[u32; 2]>, Vec<u32>)> {
    Weighted::of_rows(rows, vertices)?.paired(Some(&mut Rng::new(1)))
}

/// Returns the share of each vertex of a graph, of `count` shares of about equal weight, with few
/// edges between them. Neighbours in the tree of halves have neighbouring numbers.
pub(crate) fn shared(rows: CsMatView<'_, f64>, vertices: &[f64], count: usize) -> Result<Vec<u32>> {
    if count == 1 {
        return repeated(0, vertices.len());
    }
    let halvings = count.next_power_of_two().ilog2();
    let depth = if count.is_power_of_two() { halvings } else { halvings + FINER };
    let part = match dissection::parts(Weighted::of_rows(rows, vertices)?, depth, SLACK)? {
        Some(part) if count.is_power_of_two() => return Ok(part),
        part => part,
    };
    // Runs of parts, or of vertices in their own order, by the middles of what they weigh.
    let mut runs = vec![0.0; 1 << depth];
    let run = |v: usize| match &part {
        Some(part) => part[v] as usize,
        None => (v << depth) / vertices.len(),
    };
    (0..vertices.len()).for_each(|v| runs[run(v)] += vertices[v]);
    let total: f64 = runs.iter().sum();
    let mut before = 0.0;
    for weight in &mut runs {
        let middle = before + 0.5 * *weight;
        before += *weight;
        *weight = ((middle / total.max(1.0) * count as f64) as usize).min(count - 1) as f64;
    }
    let mut share = reserved(vertices.len())?;
    share.extend((0..vertices.len()).map(|v| runs[run(v)] as u32));
    Ok(share)
}

/// Returns for each vertex whether it is among those without which no edge is between two shares:
/// few of them. `cut` are the edges between shares, from the lower number to the higher one.
pub(crate) fn separator(cut: &[[u32; 2]], share: &[u32]) -> Result<Vec<bool>> {
    let halving = dissection::separator(cut, share)?;
    Ok(halving.into_iter().map(|halving| halving != NONE).collect())
}

#[cfg(test)]
mod tests {
    use sprs::{CsMat, TriMat};

    use super::*;

    /// Returns the grid of a x b vertices.
    fn grid(a: usize, b: usize) -> CsMat<f64> {
        let mut entries = TriMat::new((a * b, a * b));
        for v in 0..a * b {
            for (i, j) in [(v / b + 1, v % b), (v / b, v % b + 1)] {
                if i < a && j < b {
                    entries.add_triplet(v, i * b + j, 1.0);
                    entries.add_triplet(i * b + j, v, 1.0);
                }
            }
        }
        entries.to_csr()
    }

    #[test]
    fn shares_of_a_grid_are_alike_and_little_is_between_them() {
        // Each with the most vertices between the shares; joined parts have longer borders.
        for (count, most) in [(1, 0), (2, 44), (3, 170), (4, 110), (5, 280), (7, 320), (8, 210)] {
            let graph = grid(40, 60);
            let n = graph.rows();
            let share = shared(graph.view(), &vec![1.0; n], count).unwrap();
            let sizes: Vec<usize> =
                (0..count).map(|k| share.iter().filter(|&&s| s as usize == k).count()).collect();
            let mean = n as f64 / count as f64;
            let is_near = |&size: &usize| (size as f64 / mean - 1.0).abs() < 0.25;
            assert!(sizes.iter().all(is_near), "{count}: {sizes:?}");
            let mut cut = Vec::new();
            for (v, row) in graph.outer_iterator().enumerate() {
                let higher = row.indices().iter().filter(|&&other| share[v] < share[other]);
                cut.extend(higher.map(|&other| [v as u32, other as u32]));
            }
            let between = separator(&cut, &share).unwrap();
            assert!(cut.iter().all(|ends| ends.iter().any(|&v| between[v as usize])));
            let found = between.iter().filter(|is_between| **is_between).count();
            assert!(found <= most, "{count}: {found} between");
        }
    }

    #[test]
    fn graphs_that_cannot_be_made_coarser_are_divided_in_their_order() {
        // Stars of 50,000 vertices, in which few find a partner.
        let n = 50_000;
        let mut entries = TriMat::new((n, n));
        for v in (0..n).filter(|v| v % 1000 != 0) {
            entries.add_triplet(v, v - v % 1000, 1.0);
            entries.add_triplet(v - v % 1000, v, 1.0);
        }
        let graph: CsMat<f64> = entries.to_csr();
        for count in [2, 3] {
            let share = shared(graph.view(), &vec![1.0; n], count).unwrap();
            assert!(share.is_sorted());
            let largest = (0..count)
                .map(|k| share.iter().filter(|&&s| s as usize == k).count())
                .max()
                .unwrap();
            assert!(largest * count < n * 5 / 4, "{largest}");
        }
        assert!(shared(CsMat::zero((0, 0)).view(), &[], 3).unwrap().is_empty());
    }

    #[test]
    fn pairs_are_neighbours_among_the_rows() {
        let graph = grid(9, 7);
        // The first five rows of the grid of vertices.
        let rows = graph.slice_outer(0..35);
        let (pairs, into) = paired(rows.view(), &[1.0; 35]).unwrap();
        assert!(pairs.len() < 25, "{}", pairs.len());
        for (p, &[v, other]) in pairs.iter().enumerate() {
            assert!(v == other || graph.get(v as usize, other as usize).is_some());
            assert!([v, other].iter().all(|&v| into[v as usize] == p as u32));
        }
        assert_eq!(into.len(), 35);
    }
}
