//! The task tree of AtA-D (thesis, sections 8.4.1 and 8.4.3): A is on one process, which
//! distributes it down the tree; leaves multiply; results are added on the way up.
//!
//! An inner node for a triangle of C has six children, four triangles and twice the block below the
//! diagonal, once for each half of the rows; half of its processes take that block, which costs
//! twice as much (alpha = 1/2). An inner node for a block has eight. Where the processes are too
//! few for this, or the last level that equation 8.5 allows has more, the block is tiled as in
//! AtA-S, so that nothing is added.
//!
//! Departures: processes are numbered along the tree, not level by level as in figure 8.1; equation
//! 8.5 is read in integers (docs/algorithms/ata.md).

use std::ops::Range;

use crate::base::{even_part, triangle_len};
use crate::product::plan::{Node, Task, rectangle_levels};

/// The task tree for the lower triangle of A^T A.
///
/// ```
/// use catamaran::ranks::plan::TaskTree;
///
/// let tree = TaskTree::new(400, 200, 6);
/// let loads = tree.loads();
/// // Every word that is sent is received.
/// let sent: usize = loads.iter().map(|load| load.words_sent).sum();
/// let received: usize = loads.iter().map(|load| load.words_received).sum();
/// assert!(sent > 0 && sent == received);
/// ```
#[derive(Debug, Clone, PartialEq)]
pub struct TaskTree {
    processes: usize,
    /// Level by level; the root is the first, and parents are before their children.
    nodes: Vec<TreeNode>,
}

/// A node: its owner gets what it reads from the parent's owner, and returns what it computed.
#[derive(Debug, Clone, PartialEq)]
pub struct TreeNode {
    /// The block of C, and the process that owns the node.
    pub task: Task,
    /// Rows of A that are summed over.
    pub sums: Range<usize>,
    /// The node above; `None` for the root.
    pub parent: Option<usize>,
    /// The nodes below, none for a leaf. Their blocks cover this one's; those of two children are
    /// disjoint, or the same.
    pub children: Range<usize>,
    /// Whether no sibling before this node has the same block.
    pub is_first: bool,
}

/// A message to the owner of a child: some rows of the part of A that the child reads.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct PlannedSend {
    /// The child, by its place among the nodes.
    pub child: usize,
    /// The number of the strip, from 0.
    pub strip: usize,
    /// The rows, counted from the first that the child sums over.
    pub rows: Range<usize>,
}

/// The work and traffic of one process; words are entries of A and C.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub struct Load {
    /// Words sent.
    pub words_sent: usize,
    /// Words received.
    pub words_received: usize,
    /// Messages sent.
    pub messages_sent: usize,
    /// Messages received.
    pub messages_received: usize,
    /// Products of scalars: a float, since an integer may not hold them.
    pub products: f64,
    /// Words of memory for A, C and messages; A and C themselves on process 0.
    pub memory: usize,
}

/// Most strips of rows in which a leaf gets its part of A.
pub(crate) const STRIPS: usize = 4;
/// Entries above which a leaf gets strips: 8 MiB of f64, which take longer than a message.
const STRIPPED: usize = 1 << 20;
/// Least number of rows of a strip: products of fewer are slower.
const SHORTEST_STRIP: usize = 1024;

/// Results of others that fit in memory at the same time: one arrives while one is added.
pub(crate) const RESULTS_IN_FLIGHT: usize = 2;

impl TaskTree {
    /// Creates the tree for A m x n on `processes >= 1` processes. Process 0 owns the root. Some
    /// processes own nothing where the matrix is too small for all.
    ///
    /// ```
    /// use catamaran::ranks::plan::TaskTree;
    ///
    /// // The root and six children: four triangles, and twice the block below the diagonal.
    /// let tree = TaskTree::new(400, 200, 6);
    /// assert_eq!((tree.depth(), tree.nodes().len()), (1, 7));
    /// ```
    pub fn new(m: usize, n: usize, processes: usize) -> Self {
        let task = Task { process: 0, triangle: true, rows: 0..n, cols: 0..n };
        let root = TreeNode { task, sums: 0..m, parent: None, children: 0..0, is_first: true };
        let mut nodes = vec![root];
        // Processes and levels that a node has for its part of the tree.
        let mut means = vec![(0..processes, rank_levels(processes))];
        for id in 0.. {
            let Some((share, depth)) = means.get(id).cloned() else { break };
            let before = nodes.len();
            let children = if nodes[id].task.triangle {
                below_triangle(&nodes[id], share, depth)
            } else {
                below_rectangle(&nodes[id], share, depth)
            };
            for Child { task, sums, share, depth } in children {
                // An empty block leaves its processes idle.
                if sums.is_empty() || task.rows.is_empty() || task.cols.is_empty() {
                    continue;
                }
                let same =
                    |node: &TreeNode| node.task.rows == task.rows && node.task.cols == task.cols;
                let is_first = !nodes[before..].iter().any(same);
                nodes.push(TreeNode { task, sums, parent: Some(id), children: 0..0, is_first });
                means.push((share, depth));
            }
            nodes[id].children = before..nodes.len();
        }
        Self { processes, nodes }
    }

    /// Returns the number of processes.
    pub fn processes(&self) -> usize {
        self.processes
    }

    /// Returns all nodes, parents before their children. [`TreeNode::children`] and
    /// [`TreeNode::parent`] are positions in this slice.
    pub fn nodes(&self) -> &[TreeNode] {
        &self.nodes
    }

    /// Returns the number of levels below the root.
    pub fn depth(&self) -> usize {
        let mut depths = vec![0; self.nodes.len()];
        for (id, node) in self.nodes.iter().enumerate() {
            depths[id] = node.parent.map_or(0, |parent| depths[parent] + 1);
        }
        depths.into_iter().max().unwrap_or(0)
    }

    /// Returns whether the owner of node `id` gets its part of A from another process.
    pub fn is_sent(&self, id: usize) -> bool {
        let node = &self.nodes[id];
        node.parent.is_some_and(|parent| self.nodes[parent].task.process != node.task.process)
    }

    /// Returns whether the columns that node `id` reads are adjacent columns of one operand of its
    /// parent, those of its block before those of its rows. They travel as one block then: rows of
    /// A that are whole need not be gathered.
    pub fn is_one_block(&self, id: usize) -> bool {
        let TreeNode { task, parent, .. } = &self.nodes[id];
        let of_triangle = parent.is_some_and(|parent| self.nodes[parent].task.triangle);
        of_triangle && !task.triangle && task.cols.end == task.rows.start
    }

    /// Returns the messages that the owner of `node` sends to its children, in order: the first
    /// strips of all children before the second ones, so that every child begins early.
    ///
    /// ```
    /// use catamaran::ranks::plan::TaskTree;
    ///
    /// let tree = TaskTree::new(400, 200, 2);
    /// let sends: Vec<_> = tree.planned_sends(&tree.nodes()[0]).collect();
    /// assert_eq!(sends.len(), 2);
    /// assert!(sends.iter().all(|send| send.rows == (0..400)));
    /// ```
    pub fn planned_sends(&self, node: &TreeNode) -> impl Iterator<Item = PlannedSend> {
        let children = node.children.clone();
        (0..STRIPS).flat_map(move |strip| {
            let sent = children.clone().filter(|&child| self.is_sent(child));
            sent.filter_map(move |child| {
                let rows = self.nodes[child].strips().nth(strip)?;
                Some(PlannedSend { child, strip, rows })
            })
        })
    }

    /// Returns the nodes whose part of A is sent to `process`, in the order of sending.
    pub fn entries(&self, process: usize) -> Vec<usize> {
        let all = 0..self.nodes.len();
        all.filter(|&id| self.nodes[id].task.process == process && self.is_sent(id)).collect()
    }

    /// Returns the nodes below `id` whose results its owner receives, in the order in which they
    /// are added.
    pub fn results(&self, id: usize) -> Vec<usize> {
        let below = |child| if self.is_sent(child) { vec![child] } else { self.results(child) };
        self.nodes[id].children.clone().flat_map(below).collect()
    }

    /// Computes the load of each process.
    pub fn loads(&self) -> Vec<Load> {
        let mut loads = vec![Load::default(); self.processes];
        let mut longest = vec![0; self.processes];
        for (id, node) in self.nodes.iter().enumerate() {
            let own = node.task.process;
            if node.is_leaf() {
                loads[own].products += node.products();
            }
            if node.parent.is_none() || self.is_sent(id) {
                loads[own].memory += node.input_len() + node.block_len();
            }
            let Some(parent) = node.parent.filter(|_| self.is_sent(id)) else { continue };
            let parent = self.nodes[parent].task.process;
            loads[parent].words_sent += node.input_len();
            loads[own].words_received += node.input_len();
            loads[own].words_sent += node.result_len();
            loads[parent].words_received += node.result_len();
            let strips = node.strips().len();
            loads[parent].messages_sent += strips;
            loads[own].messages_received += strips;
            loads[own].messages_sent += 1;
            loads[parent].messages_received += 1;
            longest[parent] = longest[parent].max(node.result_len());
        }
        for (load, longest) in loads.iter_mut().zip(longest) {
            load.memory += RESULTS_IN_FLIGHT * longest;
        }
        loads
    }
}

impl TreeNode {
    /// Returns whether the node is a product; all others are sums.
    pub fn is_leaf(&self) -> bool {
        self.children.is_empty()
    }

    /// Returns the columns of A that the node reads: one range, or two.
    pub fn columns(&self) -> impl Iterator<Item = Range<usize>> {
        let right = (!self.task.triangle).then(|| self.task.cols.clone());
        std::iter::once(self.task.rows.clone()).chain(right)
    }

    /// Returns the number of entries of A that the node reads.
    pub fn input_len(&self) -> usize {
        self.words_of(self.sums.len())
    }

    /// Returns the number of entries in `rows` rows of the columns that the node reads.
    pub fn words_of(&self, rows: usize) -> usize {
        self.columns().map(|columns| columns.len() * rows).sum()
    }

    /// Returns the ranges of rows of A that travel together, counted from the first of `sums`. An
    /// inner node gets all rows at once, because its owner sends them on. A long leaf gets at most
    /// four strips, and begins when the first has arrived.
    pub fn strips(&self) -> impl ExactSizeIterator<Item = Range<usize>> + use<> {
        let rows = self.sums.len();
        let count = if self.is_leaf() && self.input_len() > STRIPPED {
            (rows / SHORTEST_STRIP).clamp(1, STRIPS)
        } else {
            1
        };
        (0..count).map(move |i| even_part(0..rows, count, i))
    }

    /// Returns the number of entries of the block, with those above the diagonal.
    pub fn block_len(&self) -> usize {
        self.task.rows.len() * self.task.cols.len()
    }

    /// Returns the number of entries of the result as it travels: a packed triangle, or the block.
    pub fn result_len(&self) -> usize {
        if self.task.triangle { triangle_len(self.task.rows.len()) } else { self.block_len() }
    }

    /// Returns the number of products of scalars for the whole node.
    pub fn products(&self) -> f64 {
        self.result_len() as f64 * self.sums.len() as f64
    }
}

/// Returns the number of parallel levels of AtA-D on `p` processes: equation 8.5, `P / 4` rounded
/// down.
///
/// ```
/// use catamaran::ranks::plan::rank_levels;
///
/// assert_eq!(rank_levels(1), 0);
/// assert!(rank_levels(64) >= rank_levels(8));
/// ```
pub fn rank_levels(p: usize) -> usize {
    match p {
        0 | 1 => 0,
        2..=6 => 1,
        _ => 1 + rectangle_levels(p / 4, 8),
    }
}

/// A planned node, and the processes and levels for its part of the tree.
struct Child {
    task: Task,
    sums: Range<usize>,
    share: Range<usize>,
    depth: usize,
}

/// Returns the children for a triangle of C on the processes `share`, at most `depth` levels.
fn below_triangle(node: &TreeNode, share: Range<usize>, depth: usize) -> Vec<Child> {
    let p = share.len();
    if p <= 1 {
        return Vec::new();
    }
    let depth = depth.min(rank_levels(p));
    if depth == 1 && p != 6 {
        return tiles(node, &Node::symmetric(node.task.rows.len(), p), share);
    }
    // Half of the processes to the block below the diagonal, and at least one to each child.
    let middle = share.start + (p / 2).min(p - 4);
    let (below, triangles) = (share.start..middle, middle..share.end);
    let half = |i| even_part(node.task.rows.clone(), 2, i);
    let child = |(rows, cols), l, share: Range<usize>| {
        let task = Task { process: share.start, triangle: rows == cols, rows, cols };
        Child { task, sums: even_part(node.sums.clone(), 2, l), share, depth: depth - 1 }
    };
    let rectangles = (0..2).map(|l| child((half(1), half(0)), l, even_part(below.clone(), 2, l)));
    let squares = (0..4)
        .map(|i| child((half(i / 2), half(i / 2)), i % 2, even_part(triangles.clone(), 4, i)));
    rectangles.chain(squares).collect()
}

/// Returns the children for a block of C on the processes `share`, at most `depth` levels.
fn below_rectangle(node: &TreeNode, share: Range<usize>, depth: usize) -> Vec<Child> {
    let p = share.len();
    if p <= 1 {
        return Vec::new();
    }
    let depth = depth.min(rectangle_levels(p, 8));
    let Task { rows, cols, .. } = &node.task;
    if depth == 1 && p != 8 {
        return tiles(node, &Node::general(rows.len(), cols.len(), p), share);
    }
    let child = |i| {
        let share = even_part(share.clone(), 8, i);
        let (rows, cols) =
            (even_part(rows.clone(), 2, i / 4), even_part(cols.clone(), 2, i / 2 % 2));
        let task = Task { process: share.start, triangle: false, rows, cols };
        Child { task, sums: even_part(node.sums.clone(), 2, i % 2), share, depth: depth - 1 }
    };
    (0..8).map(child).collect()
}

/// Returns the leaves of `tree`, a tree of AtA-S for the block of `node`.
fn tiles(node: &TreeNode, tree: &Node, share: Range<usize>) -> Vec<Child> {
    let shifted = |range: &Range<usize>, by| range.start + by..range.end + by;
    let child = |task: &Task| {
        // From behind: the block below the diagonal goes to the first processes, as in the levels
        // above.
        let process = share.end - 1 - task.process;
        let rows = shifted(&task.rows, node.task.rows.start);
        let cols = shifted(&task.cols, node.task.cols.start);
        let task = Task { process, triangle: task.triangle, rows, cols };
        Child { task, sums: node.sums.clone(), share: process..process + 1, depth: 0 }
    };
    tree.tasks().iter().rev().map(child).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Returns equation 8.5 as printed, `P / 4` in integers.
    fn equation_8_5(p: usize) -> usize {
        match p {
            1 => 0,
            2..=6 => 1,
            _ => {
                let quarter = p / 4;
                let k = (0..).take_while(|&k| quarter >= 8_usize.pow(k)).last().unwrap();
                1 + k as usize + usize::from(!quarter.is_multiple_of(8_usize.pow(k.max(1))))
            }
        }
    }

    fn leaves(tree: &TaskTree) -> impl Iterator<Item = &TreeNode> {
        tree.nodes().iter().filter(|node| node.is_leaf())
    }

    #[test]
    fn depth_is_that_of_equation_8_5_and_all_processes_work() {
        for p in 1..=4096 {
            assert_eq!(rank_levels(p), equation_8_5(p), "P = {p}");
            let tree = TaskTree::new(1 << 16, 1 << 16, p);
            assert_eq!(tree.depth(), equation_8_5(p), "P = {p}");
            let loads = tree.loads();
            assert_eq!(loads.len(), p);
            assert!(loads.iter().all(|load| load.products > 0.0), "P = {p}");
            let mut owned = vec![[0; 2]; p];
            leaves(&tree)
                .for_each(|leaf| owned[leaf.task.process][usize::from(leaf.task.triangle)] += 1);
            // One leaf each; where two processes are left for a triangle, one has both of its
            // triangles.
            let is_usual = |leaves: &[usize; 2]| [[1, 0], [0, 1], [0, 2]].contains(leaves);
            assert!(owned.iter().all(is_usual), "P = {p}");
        }
    }

    /// Counts how often each entry of C gets each row of A.
    fn check_coverage(m: usize, n: usize, p: usize) {
        let tree = TaskTree::new(m, n, p);
        let mut counts = vec![0_u8; n * n * m];
        for leaf in leaves(&tree) {
            let Task { triangle, rows, cols, process } = leaf.task.clone();
            assert!(process < p);
            for i in rows {
                for j in cols.clone().filter(|&j| !triangle || j <= i) {
                    for l in leaf.sums.clone() {
                        counts[(i * n + j) * m + l] += 1;
                    }
                }
            }
        }
        for i in 0..n {
            for j in 0..n {
                for l in 0..m {
                    let expected = u8::from(j <= i);
                    assert_eq!(counts[(i * n + j) * m + l], expected, "{m} x {n}, P = {p}");
                }
            }
        }
    }

    #[test]
    fn every_entry_gets_every_row_once() {
        let shapes = [(0, 0), (0, 3), (3, 0), (1, 1), (1, 13), (13, 1), (7, 11), (2, 3), (31, 4)];
        for p in 1..=4096 {
            for (m, n) in shapes {
                check_coverage(m, n, p);
            }
        }
        for p in [1, 2, 3, 4, 5, 6, 7, 8, 16, 31, 32, 33, 36, 64, 100, 256, 1009, 4096] {
            check_coverage(37, 41, p);
            check_coverage(64, 48, p);
        }
    }

    #[test]
    fn blocks_of_children_cover_their_parent_and_the_first_of_each_is_known() {
        for p in [2, 6, 7, 16, 40, 72, 300] {
            for (m, n) in [(1, 9), (50, 30), (2, 2)] {
                let tree = TaskTree::new(m, n, p);
                for node in tree.nodes().iter().filter(|node| !node.is_leaf()) {
                    let children = &tree.nodes()[node.children.clone()];
                    let first = children.iter().filter(|child| child.is_first);
                    let len: usize = first.map(TreeNode::result_len).sum();
                    assert_eq!(len, node.result_len());
                    let products: f64 = children.iter().map(TreeNode::products).sum();
                    assert_eq!(products, node.products());
                    assert_eq!(node.task.process, children[0].task.process.min(node.task.process));
                }
            }
        }
    }

    #[test]
    fn the_tree_of_figure_8_1_has_its_leaves() {
        let tree = TaskTree::new(64, 64, 16);
        let kinds: Vec<_> = leaves(&tree)
            .map(|leaf| (leaf.task.process, leaf.task.triangle, leaf.sums.len()))
            .collect();
        // Eight processes for C21, in tiles; two for each product of a triangle.
        for process in 0..16 {
            let own: Vec<_> = kinds.iter().filter(|(owner, ..)| *owner == process).collect();
            let rectangle = process < 8 || process % 2 == 0;
            assert_eq!(own.len(), if rectangle { 1 } else { 2 }, "{kinds:?}");
            assert!(own.iter().all(|(_, triangle, rows)| *triangle != rectangle && *rows == 32));
        }
        assert_eq!(tree.nodes()[1..7].iter().filter(|node| !node.task.triangle).count(), 2);
    }

    #[test]
    fn process_0_sends_as_many_messages_as_proposition_8_3_says_where_levels_are_complete() {
        for p in [6, 32, 256, 2048] {
            let tree = TaskTree::new(1024, 1024, p);
            let Load { messages_sent, messages_received, .. } = tree.loads()[0];
            assert_eq!(messages_sent + messages_received, 2 * (7 * (tree.depth() - 1) + 5), "{p}");
        }
    }

    #[test]
    fn blocks_left_of_a_triangle_read_one_block_of_columns() {
        for p in [2, 3, 6, 8, 40] {
            let tree = TaskTree::new(500, 301, p);
            for (id, node) in tree.nodes().iter().enumerate() {
                if tree.is_one_block(id) {
                    let parent = &tree.nodes()[node.parent.unwrap()].task;
                    let [left, right] = node.columns().collect::<Vec<_>>().try_into().unwrap();
                    assert!(parent.triangle && right.end == left.start);
                    assert!(parent.rows.start <= right.start && left.end <= parent.rows.end);
                }
            }
            let below_root = tree.nodes()[0].children.clone();
            let mut left: Vec<_> =
                below_root.filter(|&id| !tree.nodes()[id].task.triangle).collect();
            left.retain(|&id| !tree.is_one_block(id));
            assert!(left.is_empty());
        }
    }

    #[test]
    fn long_leaves_travel_in_strips_which_cover_their_rows() {
        let strips = |m, n, p| {
            let tree = TaskTree::new(m, n, p);
            let leaves = tree.entries(1);
            let node = &tree.nodes()[leaves[0]];
            let strips: Vec<_> = node.strips().collect();
            let rows: Vec<_> = strips.iter().cloned().flatten().collect();
            assert_eq!(rows, (0..node.sums.len()).collect::<Vec<_>>());
            assert_eq!(tree.loads()[1].messages_received, strips.len() * leaves.len());
            strips.len()
        };
        assert_eq!(
            [strips(4096, 4096, 2), strips(2100, 4096, 2), strips(1024, 4096, 2)],
            [4, 2, 1]
        );
        assert_eq!([strips(100_000, 1000, 2), strips(100_000, 10, 2)], [4, 1]);
        // The owner of an inner node sends parts of A on, so it waits for all of it.
        assert!(TaskTree::new(8192, 8192, 32).nodes()[1].strips().len() == 1);
    }

    #[test]
    fn what_is_sent_is_received() {
        for p in [1, 2, 5, 16, 33, 500] {
            let loads = TaskTree::new(300, 200, p).loads();
            let sum = |of: fn(&Load) -> usize| loads.iter().map(of).sum::<usize>();
            assert_eq!(sum(|load| load.words_sent), sum(|load| load.words_received));
            assert_eq!(sum(|load| load.messages_sent), sum(|load| load.messages_received));
            let products: f64 = loads.iter().map(|load| load.products).sum();
            assert_eq!(products, (300 * triangle_len(200)) as f64);
        }
    }

    #[test]
    fn entries_and_results_are_those_that_are_sent() {
        for p in [1, 2, 3, 7, 16, 64, 300] {
            let tree = TaskTree::new(100, 90, p);
            let mut sent = 0;
            for process in 0..p {
                let entries = tree.entries(process);
                sent += entries.len();
                let mut received = tree.results(0).len() * usize::from(process == 0);
                received += entries.iter().map(|&id| tree.results(id).len()).sum::<usize>();
                let load = tree.loads()[process];
                assert_eq!(load.messages_sent, received + entries.len());
                assert_eq!(load.messages_received, received + entries.len());
            }
            assert_eq!(sent, (0..tree.nodes().len()).filter(|&id| tree.is_sent(id)).count());
        }
    }

    #[test]
    fn load_is_even_where_levels_are_complete_and_at_most_twice_the_mean() {
        for p in 1..=4096 {
            let loads = TaskTree::new(1 << 16, 1 << 16, p).loads();
            let most = loads.iter().map(|load| load.products).fold(0.0, f64::max);
            let mean = loads.iter().map(|load| load.products).sum::<f64>() / p as f64;
            let limit = match p {
                1 | 2 | 4 | 16 | 32 | 64 | 256 | 2048 => 1.001,
                // Four products of a triangle and two of twice the work.
                6 => 1.5,
                _ => 2.0,
            };
            assert!(most <= limit * mean, "P = {p}: {}", most / mean);
        }
    }
}
