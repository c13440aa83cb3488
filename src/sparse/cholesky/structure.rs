//! The structure of a factor: which columns have which rows.

use super::graph::{Graph, Lists, Looks, NONE};
use crate::base::{Result, push, repeated, reserved, room};

/// Columns of a factor with one pattern, and those with nearly one.
#[derive(Debug)]
pub(super) struct Structure {
    /// The rows of the matrix in the order of elimination.
    pub order: Vec<u32>,
    pub nodes: Vec<Columns>,
    /// The rows below the triangles of the nodes, as rows of the matrix.
    pub rows: Vec<u32>,
}

/// Columns that follow each other.
#[derive(Debug, Clone, Copy)]
pub(super) struct Columns {
    pub columns: usize,
    /// The rows below their triangle are those from `first` on, `below` of them.
    pub first: usize,
    pub below: usize,
}

/// Supernodes while they are found.
struct Tree<'g> {
    /// The columns of node k are `items[starts[k]..starts[k + 1]]`, as rows of the matrix.
    items: &'g [u32],
    starts: Vec<u32>,
    nodes: Vec<Columns>,
    parents: Vec<u32>,
    rows: Vec<u32>,
}

impl Structure {
    /// Finds the structure of the factor when groups of vertices, of which each has the same later
    /// neighbours, are eliminated one after another. Vertices in no group are not eliminated: they
    /// are only rows.
    pub fn new(graph: &Graph, groups: &Lists) -> Result<Self> {
        let tree = Tree::new(graph, groups)?;
        let into = tree.merged()?;
        tree.in_postorder(&into)
    }
}

impl<'g> Tree<'g> {
    fn new(graph: &Graph, groups: &'g Lists) -> Result<Self> {
        let (n, count) = (graph.n(), groups.len());
        // The group of each vertex, and the last one that has it as a row.
        let mut seen = repeated((NONE, NONE), n)?;
        for k in 0..count {
            groups.of(k).iter().for_each(|&v| seen[v as usize].0 = k as u32);
        }
        // The nodes whose first row below is in a group, and those after each one of them.
        let (mut child, mut sibling) = (repeated(NONE, count)?, repeated(NONE, count)?);
        let mut node_of: Vec<u32> = reserved(count)?;
        let mut looks = Looks::default();
        let mut tree = Self {
            items: &groups.items,
            starts: reserved(count + 1)?,
            nodes: reserved(count)?,
            parents: reserved(count)?,
            rows: reserved(graph.neighbours.len())?,
        };
        for k in 0..count as u32 {
            let (first, mut parent) = (tree.rows.len(), NONE);
            let rows = &mut tree.rows;
            let mut add = |rows: &mut Vec<u32>, v: u32| {
                let (group, last) = &mut seen[v as usize];
                if *group > k && *last != k {
                    *last = k;
                    parent = parent.min(*group);
                    rows.push(v);
                }
            };
            let mut c = child[k as usize];
            while c != NONE {
                let Columns { first, below, .. } = tree.nodes[c as usize];
                room(rows, below)?;
                (first..first + below).for_each(|i| add(rows, rows[i]));
                looks.add(below)?;
                c = sibling[c as usize];
            }
            for &v in groups.of(k as usize) {
                let neighbours = graph.of(v as usize);
                room(rows, neighbours.len())?;
                neighbours.iter().for_each(|&v| add(rows, v));
                looks.add(neighbours.len())?;
            }
            let (columns, below) = (groups.of(k as usize).len(), rows.len() - first);
            match tree.nodes.last_mut().zip(tree.parents.last_mut()) {
                // The columns before have the same rows.
                Some((last, above)) if *above == k && last.below == columns + below => {
                    rows.copy_within(first.., last.first);
                    rows.truncate(last.first + below);
                    last.columns += columns;
                    last.below = below;
                    *above = parent;
                }
                _ => {
                    tree.starts.push(groups.starts[k as usize]);
                    tree.nodes.push(Columns { columns, first, below });
                    tree.parents.push(parent);
                }
            }
            let node = tree.nodes.len() as u32 - 1;
            node_of.push(node);
            if parent != NONE {
                sibling[node as usize] = std::mem::replace(&mut child[parent as usize], node);
            }
        }
        tree.starts.push(groups.items.len() as u32);
        let above = tree.parents.iter_mut().filter(|parent| **parent != NONE);
        above.for_each(|parent| *parent = node_of[*parent as usize]);
        Ok(tree)
    }

    /// Returns the columns of a node, as rows of the matrix.
    fn columns(&self, node: usize) -> &'g [u32] {
        &self.items[self.starts[node] as usize..self.starts[node + 1] as usize]
    }

    /// Merges nodes into their parents where that adds few zeros; returns for each node the one
    /// that has its columns.
    fn merged(&self) -> Result<Vec<u32>> {
        let count = self.nodes.len();
        let (mut child, mut sibling) = (repeated(NONE, count)?, repeated(NONE, count)?);
        let mut columns = reserved(count)?;
        columns.extend(self.nodes.iter().map(|node| node.columns));
        let mut zeros = repeated(0usize, count)?;
        let mut into: Vec<u32> = reserved(count)?;
        into.extend(0..count as u32);
        let mut children: Vec<u32> = Vec::new();
        for p in 0..count {
            children.clear();
            let mut c = child[p];
            while c != NONE {
                push(&mut children, c)?;
                c = sibling[c as usize];
            }
            // Those with the largest fronts first.
            let front = |c: u32| self.nodes[c as usize].below;
            children.sort_unstable_by_key(|&c| (std::cmp::Reverse(front(c)), c));
            for &c in &children {
                let c = c as usize;
                let below = self.nodes[p].below;
                let new = columns[c] * (columns[p] + below - self.nodes[c].below);
                let (all, wide) = (new + zeros[c] + zeros[p], columns[c] + columns[p]);
                let entries = wide * (wide + 1) / 2 + wide * below;
                if new == 0 || allows(wide, all, entries) {
                    columns[p] = wide;
                    zeros[p] = all;
                    into[c] = p as u32;
                }
            }
            if self.parents[p] != NONE {
                sibling[p] = std::mem::replace(&mut child[self.parents[p] as usize], p as u32);
            }
        }
        // Parents are later.
        for c in (0..count).rev() {
            into[c] = into[into[c] as usize];
        }
        Ok(into)
    }

    /// Returns the nodes that others are merged into, in a postorder.
    fn in_postorder(self, into: &[u32]) -> Result<Structure> {
        let count = self.nodes.len();
        let (mut child, mut sibling) = (repeated(NONE, count)?, repeated(NONE, count)?);
        // The nodes that are merged into each one, ascending.
        let (mut part, mut next) = (repeated(NONE, count)?, repeated(NONE, count)?);
        for k in (0..count).rev() {
            let root = into[k] as usize;
            next[k] = std::mem::replace(&mut part[root], k as u32);
            if root == k && self.parents[k] != NONE {
                let parent = into[self.parents[k] as usize] as usize;
                sibling[k] = std::mem::replace(&mut child[parent], k as u32);
            }
        }
        let n = self.items.len();
        let (mut order, mut nodes) = (reserved(n)?, reserved(count)?);
        let mut above: Vec<u32> = Vec::new();
        for root in (0..count).filter(|&k| into[k] as usize == k && self.parents[k] == NONE) {
            push(&mut above, root as u32)?;
            while let Some(&node) = above.last() {
                let node = node as usize;
                let down = child[node];
                if down != NONE {
                    child[node] = sibling[down as usize];
                    push(&mut above, down)?;
                    continue;
                }
                above.pop();
                let start = order.len();
                let mut k = part[node];
                while k != NONE {
                    order.extend_from_slice(self.columns(k as usize));
                    k = next[k as usize];
                }
                nodes.push(Columns { columns: order.len() - start, ..self.nodes[node] });
            }
        }
        Ok(Structure { order, nodes, rows: self.rows })
    }
}

/// Returns whether a supernode of so many columns may have so many zeros among its entries.
fn allows(columns: usize, zeros: usize, entries: usize) -> bool {
    // Wider ones are faster to compute with, zeros slower.
    const MOST: [(usize, f64); 3] = [(8, 0.3), (32, 0.15), (usize::MAX, 0.05)];
    let is_few = |part: f64| zeros as f64 <= part * entries as f64;
    MOST.iter().any(|&(widest, part)| columns <= widest && is_few(part))
}

#[cfg(test)]
mod tests {
    use super::super::graph::tests::{eliminated, graphs};
    use super::super::minimum::minimum_degree;
    use super::*;

    /// Checks that the nodes have the rows of the factor, and few others; returns the structure.
    fn checked(name: &str, graph: &Graph, groups: &Lists) -> Structure {
        let found = Structure::new(graph, groups).unwrap();
        let mut sorted = found.order.clone();
        sorted.sort_unstable();
        assert_eq!(sorted, (0..graph.n() as u32).collect::<Vec<_>>(), "{name}");
        let later = eliminated(graph, &found.order);
        let mut start = 0;
        for node in &found.nodes {
            let columns = &found.order[start..start + node.columns];
            let below = &found.rows[node.first..node.first + node.below];
            // The last column has all rows.
            let (mut rows, mut last) =
                (below.to_vec(), later[columns[columns.len() - 1] as usize].clone());
            rows.sort_unstable();
            last.sort_unstable();
            assert_eq!(rows, last, "{name}");
            let mut zeros = 0;
            for (j, &column) in columns.iter().enumerate() {
                let rest = [&columns[j + 1..], below].concat();
                let of_column = &later[column as usize];
                assert!(of_column.iter().all(|row| rest.contains(row)), "{name}");
                zeros += rest.len() - of_column.len();
            }
            let entries = node.columns * (node.columns + 1) / 2 + node.columns * node.below;
            assert!(10 * zeros <= 3 * entries, "{name}");
            start += node.columns;
        }
        assert_eq!(start, graph.n(), "{name}");
        found
    }

    #[test]
    fn nodes_have_the_rows_of_the_factor() {
        for (name, graph) in graphs() {
            checked(name, &graph, &minimum_degree(&graph, None).unwrap());
            // Its tree is no postorder.
            let order = (0..graph.n() as u32).collect();
            checked(name, &graph, &Lists::singles(order).unwrap());
        }
    }

    #[test]
    fn columns_of_a_full_matrix_are_one_node_in_their_order() {
        let graphs = graphs();
        let (_, graph) = graphs.iter().find(|(name, _)| *name == "full, of high degree").unwrap();
        let order: Vec<u32> = (0..130).map(|i| 7 * i % 130).collect();
        let found = checked("full", graph, &Lists::singles(order.clone()).unwrap());
        assert_eq!(found.order, order);
        assert!(matches!(found.nodes[..], [Columns { columns: 130, below: 0, .. }]));
        // Their rows are not all kept while they are found.
        assert!(found.rows.len() < 130, "{}", found.rows.len());
    }
}
