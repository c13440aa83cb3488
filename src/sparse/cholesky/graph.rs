//! The graph of a symmetric matrix: which rows share entries.

use std::ops::Range;

use faer::sparse::SymbolicSparseColMatRef;

use crate::base::{Result, repeated, reserved, spend};

/// Operations to which looking at a neighbour is equal, roughly.
const LOOK: f64 = 8.0;

/// Marks that there is no vertex.
pub(super) const NONE: u32 = u32::MAX;

/// Counts the neighbours that are looked at, and asks now and then whether to go on.
#[derive(Debug, Default)]
pub(super) struct Looks(usize);

impl Looks {
    /// Counts some more.
    #[inline(always)]
    pub fn add(&mut self, count: usize) -> Result<()> {
        /// Looks between two requests.
        const SOME: usize = 1 << 16;
        self.0 += count + 1;
        if self.0 < SOME {
            return Ok(());
        }
        spend(LOOK * std::mem::take(&mut self.0) as f64)
    }
}

/// The neighbours of each row, without itself.
#[derive(Debug, Clone, Default)]
pub(super) struct Graph {
    /// Those of row v are `starts[v]..starts[v + 1]` of the neighbours.
    pub starts: Vec<usize>,
    pub neighbours: Vec<u32>,
}

impl Graph {
    /// Finds the neighbours in a matrix, of which the entries below the diagonal are read.
    pub fn new(matrix: SymbolicSparseColMatRef<'_, usize>) -> Result<Self> {
        let n = matrix.ncols();
        // Counts of row v are two places behind it, so that filling moves them to their starts.
        let mut starts = repeated(0usize, n + 2)?;
        for j in 0..n {
            let mut below = 0;
            for &i in matrix.row_idx_of_col_raw(j).iter().filter(|i| **i > j) {
                starts[i + 2] += 1;
                below += 1;
            }
            starts[j + 2] += below;
        }
        for v in 2..n + 2 {
            starts[v] += starts[v - 1];
        }
        let mut neighbours = repeated(0u32, starts[n + 1])?;
        for j in 0..n {
            let mut next = starts[j + 1];
            for &i in matrix.row_idx_of_col_raw(j).iter().filter(|i| **i > j) {
                neighbours[next] = i as u32;
                next += 1;
                neighbours[starts[i + 1]] = j as u32;
                starts[i + 1] += 1;
            }
            starts[j + 1] = next;
        }
        starts.truncate(n + 1);
        Ok(Self { starts, neighbours })
    }

    /// Returns the graph of the first n vertices.
    pub fn first(&self, n: usize) -> Result<Self> {
        let mut starts = reserved(n + 1)?;
        starts.push(0);
        let mut neighbours = reserved(self.starts[n])?;
        for v in 0..n {
            neighbours.extend(self.of(v).iter().filter(|&&other| (other as usize) < n));
            starts.push(neighbours.len());
        }
        Ok(Self { starts, neighbours })
    }

    /// Returns the number of vertices.
    pub fn n(&self) -> usize {
        self.starts.len() - 1
    }

    fn range(&self, v: usize) -> Range<usize> {
        self.starts[v]..self.starts[v + 1]
    }

    /// Returns the neighbours of a vertex.
    pub fn of(&self, v: usize) -> &[u32] {
        &self.neighbours[self.range(v)]
    }

    /// Returns the number of neighbours of a vertex.
    pub fn degree(&self, v: usize) -> usize {
        self.range(v).len()
    }
}

/// Lists of items that are `0..` one after another: list k is `items[starts[k]..starts[k + 1]]`.
#[derive(Debug, Default)]
pub(super) struct Lists {
    pub starts: Vec<u32>,
    pub items: Vec<u32>,
}

impl Lists {
    /// Sorts `0..of.len()` by their lists `of[i]`, less than `count`, those of one list ascending.
    pub fn sorted(of: &[u32], count: usize) -> Result<Self> {
        let mut starts = repeated(0u32, count + 2)?;
        of.iter().for_each(|&k| starts[k as usize + 2] += 1);
        for k in 2..count + 2 {
            starts[k] += starts[k - 1];
        }
        let mut items = repeated(0u32, of.len())?;
        for (i, &k) in (0..).zip(of) {
            let next = &mut starts[k as usize + 1];
            items[*next as usize] = i;
            *next += 1;
        }
        starts.truncate(count + 1);
        Ok(Self { starts, items })
    }

    /// Returns the lists of one item each.
    pub fn singles(items: Vec<u32>) -> Result<Self> {
        let mut starts = reserved(items.len() + 1)?;
        starts.extend(0..=items.len() as u32);
        Ok(Self { starts, items })
    }

    pub fn len(&self) -> usize {
        self.starts.len() - 1
    }

    pub fn of(&self, k: usize) -> &[u32] {
        &self.items[self.starts[k] as usize..self.starts[k + 1] as usize]
    }
}

#[cfg(test)]
pub(super) mod tests {
    use super::*;
    use crate::base::Rng;

    /// Returns the graph with these edges.
    pub fn of_edges(n: usize, edges: impl IntoIterator<Item = (usize, usize)>) -> Graph {
        let mut lists = vec![Vec::new(); n];
        for (i, j) in edges.into_iter().filter(|(i, j)| i != j) {
            lists[i].push(j as u32);
            lists[j].push(i as u32);
        }
        let mut graph = Graph { starts: vec![0], neighbours: Vec::new() };
        for list in &mut lists {
            list.sort_unstable();
            list.dedup();
            graph.neighbours.extend_from_slice(list);
            graph.starts.push(graph.neighbours.len());
        }
        graph
    }

    /// Returns the grid of a x b vertices, with one diagonal in each square.
    pub fn grid(a: usize, b: usize) -> Graph {
        let steps = [(1, 0), (0, 1), (1, 1)];
        let edges = (0..a * b).flat_map(|v| steps.map(|(i, j)| (v, v / b + i, v % b + j)));
        let inside = edges.filter(|&(_, i, j)| i < a && j < b);
        of_edges(a * b, inside.map(|(v, i, j)| (v, i * b + j)))
    }

    /// Returns graphs with their names.
    pub fn graphs() -> Vec<(&'static str, Graph)> {
        let mut rng = Rng::new(5);
        let mut node = |n: usize| (rng.bits() % n as u64) as usize;
        let random: Vec<_> = (0..600).map(|_| (node(200), node(200))).collect();
        let apart = (0..30).map(|v| (v, (v + 2) % 30));
        vec![
            ("no vertices", of_edges(0, [])),
            ("one vertex", of_edges(1, [])),
            ("no edges", of_edges(5, [])),
            ("path", of_edges(40, (1..40).map(|v| (v - 1, v)))),
            ("two circles", of_edges(30, apart)),
            ("full", of_edges(20, (0..400).map(|k| (k / 20, k % 20)))),
            ("full, of high degree", of_edges(130, (0..130 * 130).map(|k| (k / 130, k % 130)))),
            // Of high degree: 500 is more than ten roots of 501.
            ("star", of_edges(501, (1..501).map(|v| (0, v)))),
            ("grid", grid(13, 17)),
            ("random", of_edges(200, random)),
        ]
    }

    /// Returns the later neighbours of each vertex when it is eliminated.
    pub fn eliminated(graph: &Graph, order: &[u32]) -> Vec<Vec<u32>> {
        let n = graph.n();
        let mut near = vec![vec![false; n]; n];
        for v in 0..n {
            graph.of(v).iter().for_each(|&other| near[v][other as usize] = true);
        }
        let mut is_left = vec![true; n];
        let mut found = vec![Vec::new(); n];
        for &v in order {
            is_left[v as usize] = false;
            let later: Vec<usize> = (0..n).filter(|&i| is_left[i] && near[v as usize][i]).collect();
            for &i in &later {
                later.iter().filter(|&&j| j != i).for_each(|&j| near[i][j] = true);
            }
            found[v as usize] = later.into_iter().map(|i| i as u32).collect();
        }
        found
    }

    #[test]
    fn neighbours_are_those_of_both_triangles() {
        // Entries above the diagonal are ignored.
        let (starts, rows) = ([0, 3, 5, 6, 8], [0, 2, 3, 0, 3, 2, 3, 1]);
        let matrix = SymbolicSparseColMatRef::new_unsorted_checked(4, 4, &starts, None, &rows);
        let graph = Graph::new(matrix).unwrap();
        let neighbours: Vec<_> = (0..4).map(|v| graph.of(v)).collect();
        assert_eq!(neighbours, [&[2, 3][..], &[3], &[0], &[0, 1]]);
    }
}
