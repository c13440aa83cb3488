//! The task tree of AtA-S (thesis, section 8.4.1): which process computes which block of C.
//!
//! Every leaf owns a distinct block of C and reads whole columns of A (fig. 8.2), so no process
//! ever waits for another. Half of the processes take the block below the diagonal, which costs
//! twice as much as either triangle. The depth is that of equation 8.6, in integer arithmetic.

use std::ops::Range;

use super::problem::Op;
use crate::base::even_part;

/// What a leaf computes: the block `C[rows, cols]`, from columns `rows` of A and `cols` of B.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Task {
    /// The process that computes it.
    pub process: usize,
    /// Whether only the lower triangle is computed (`rows == cols`).
    pub triangle: bool,
    /// Rows of C.
    pub rows: Range<usize>,
    /// Columns of C.
    pub cols: Range<usize>,
}

/// A node of the task tree.
///
/// ```
/// use catamaran::product::{Node, thread_levels};
///
/// let tree = Node::symmetric(100, 4);
/// let squares = tree.tasks().into_iter().filter(|task| !task.triangle);
/// assert_eq!(tree.depth(), thread_levels(4));
/// // Half of the processes compute the block below the diagonal.
/// assert_eq!(squares.map(|task| task.rows.len() * task.cols.len()).sum::<usize>(), 2500);
/// ```
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum Node {
    /// One task.
    Leaf(Task),
    /// A block split among several processes; the children's blocks are disjoint and cover it.
    Inner(Vec<Node>),
}

impl Node {
    /// Creates the tree for the lower triangle of an n x n matrix on `processes >= 1` processes.
    pub fn symmetric(n: usize, processes: usize) -> Self {
        triangle(0..n, 0..processes, thread_levels(processes))
    }

    /// Creates the tree for an n x k matrix on `processes >= 1` processes.
    ///
    /// ```
    /// use catamaran::product::Node;
    ///
    /// let tasks = Node::general(100, 60, 4).tasks();
    /// assert_eq!(tasks.iter().map(|task| task.rows.len() * task.cols.len()).sum::<usize>(), 6000);
    /// ```
    pub fn general(n: usize, k: usize, processes: usize) -> Self {
        rectangle(0..n, 0..k, 0..processes, rectangle_levels(processes.max(1), 4))
    }

    /// Returns the leaves from left to right, without empty blocks.
    pub fn tasks(&self) -> Vec<Task> {
        match self {
            Self::Leaf(task) if task.rows.is_empty() || task.cols.is_empty() => Vec::new(),
            Self::Leaf(task) => vec![task.clone()],
            Self::Inner(children) => children.iter().flat_map(Self::tasks).collect(),
        }
    }

    /// Returns the number of levels below this node.
    pub fn depth(&self) -> usize {
        match self {
            Self::Leaf(_) => 0,
            Self::Inner(children) => 1 + children.iter().map(Self::depth).max().unwrap_or(0),
        }
    }
}

impl Task {
    /// Returns the operation of this task when the whole product is `op`.
    pub(crate) fn op(&self, op: Op) -> Op {
        if self.triangle { op } else { Op::Gemm }
    }

    /// Returns the share of the work: entries of C.
    pub(crate) fn cost(&self) -> f64 {
        let area = self.rows.len() as f64 * self.cols.len() as f64;
        if self.triangle { area / 2.0 } else { area }
    }
}

/// Returns the number of parallel levels of AtA-S on `p` processes: equation 8.6, `P / 2` rounded
/// down.
///
/// ```
/// use catamaran::product::thread_levels;
///
/// assert_eq!([1, 2, 4].map(thread_levels), [0, 1, 2]);
/// ```
pub fn thread_levels(p: usize) -> usize {
    match p {
        0 | 1 => 0,
        2 | 3 => 1,
        _ => 1 + rectangle_levels(p / 2, 4),
    }
}

/// Returns the part of equations 8.5 (8 children of a node) and 8.6 (4 children) for the general
/// block on `p >= 1` processes: `k + sign(p mod children^max(k, 1))`, `k` the largest with
/// `children^k <= p`. One process too counts as a level.
pub(crate) fn rectangle_levels(p: usize, children: usize) -> usize {
    let k = p.ilog(children);
    k as usize + usize::from(!p.is_multiple_of(children.pow(k.max(1))))
}

/// Returns the tree of `C[span, span]`, lower triangle, on `processes`, at most `depth` levels.
fn triangle(span: Range<usize>, processes: Range<usize>, depth: usize) -> Node {
    let p = processes.len();
    if p <= 1 || depth == 0 {
        let (rows, cols) = (span.clone(), span);
        return Node::Leaf(Task { process: processes.start, triangle: true, rows, cols });
    }
    let [upper, lower] = [0, 1].map(|i| even_part(span.clone(), 2, i));
    let first = processes.start;
    // Half to the block below the diagonal; with two processes one takes both triangles.
    let below = if depth == 1 { (p - 2).max(1) } else { p / 2 };
    let triangles = p - below;
    let (at, second) = match triangles {
        1 => (first..first + 1, first..first + 1),
        t => (first..first + t.div_ceil(2), first + t.div_ceil(2)..first + t),
    };
    Node::Inner(vec![
        triangle(upper.clone(), at, depth - 1),
        triangle(lower.clone(), second, depth - 1),
        rectangle(lower, upper, first + triangles..processes.end, depth - 1),
    ])
    .flattened_when(depth == 1)
}

/// Returns the tree of `C[rows, cols]` on `processes`, at most `depth` levels deep (one more when
/// depth is 0 and there are several processes; the caller then flattens it).
fn rectangle(
    rows: Range<usize>,
    cols: Range<usize>,
    processes: Range<usize>,
    depth: usize,
) -> Node {
    let p = processes.len();
    if p <= 1 {
        return Node::Leaf(Task { process: processes.start, triangle: false, rows, cols });
    }
    // The last level takes all processes at once, in as square a grid as divides them.
    let depth = depth.min(rectangle_levels(p, 4));
    let parts = if depth <= 1 { p } else { 4 };
    let (down, across) = grid(parts);
    let mut children = Vec::with_capacity(parts);
    for i in 0..down {
        for j in 0..across {
            let child = i * across + j;
            children.push(rectangle(
                even_part(rows.clone(), down, i),
                even_part(cols.clone(), across, j),
                even_part(processes.clone(), parts, child),
                depth.saturating_sub(1),
            ));
        }
    }
    Node::Inner(children)
}

/// Returns `parts = down * across`, as square as possible.
fn grid(parts: usize) -> (usize, usize) {
    let down = (1..=parts.isqrt()).rev().find(|d| parts.is_multiple_of(*d)).unwrap_or(1);
    (down, parts / down)
}

impl Node {
    /// Replaces the children by the grandchildren, if `flatten` is set.
    fn flattened_when(self, flatten: bool) -> Self {
        match self {
            Self::Inner(children) if flatten => Self::Inner(
                children
                    .into_iter()
                    .flat_map(|child| match child {
                        Self::Inner(grandchildren) => grandchildren,
                        leaf => vec![leaf],
                    })
                    .collect(),
            ),
            node => node,
        }
    }
}
