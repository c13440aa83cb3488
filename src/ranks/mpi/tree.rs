//! AtA-D, algorithm 8.4 of the thesis: parts of A go down a task tree, parts of C come up.

use std::collections::VecDeque;
use std::ops::Range;

use faer::prelude::ReborrowMut;
use faer::{MatMut, MatRef, RowMut};

use super::form::Form;
use super::memory::Buffer;
use super::pending_send::{PendingSend, PendingSends};
use super::tags::{RESULT, STRIPS};
use super::transfer::Transfer;
use super::world::{MpiReal, Operation, World, fact};
use crate::base::{Real, Result};
use crate::product::{AtaOptions, Uplo, ata_into, atb_into};
use crate::ranks::plan::{PlannedSend, RESULTS_IN_FLIGHT, TaskTree, TreeNode};

/// Runs AtA-D: on the root, process 0, `own` is A and the lower triangle of C.
pub(super) fn run<T: MpiReal>(
    world: &World,
    form: Form,
    alpha: T,
    beta: T,
    own: Option<(MatRef<'_, T>, MatMut<'_, T>)>,
    options: &AtaOptions<'_>,
) -> Result<()> {
    let tree = TaskTree::new(form.m, form.n, world.size());
    let process = form.process(world.rank(), world.size());
    let memory = Memory::new(&tree, process);
    let facts = [fact("m", form.m), fact("n", form.n)];
    let Memory { results, inputs, blocks } = world.begin(Operation::Root, &facts, memory)?;

    let products = tree.loads()[process].products;
    let mut worker = Worker {
        world,
        tree: &tree,
        form,
        alpha,
        options,
        results,
        products: (0.0, products),
        done: Ok(()),
    };
    if let Some((a, lower)) = own {
        worker.run(0, [a, a], beta, lower, &|| false);
    } else {
        worker.run_entries(&tree.entries(process), inputs, blocks);
    }
    world.agree(worker.done)
}

/// Returns `rows` rows of the parts of A that node `id` reads, as [`Worker::start_send`] sends
/// them: the columns for the rows of its block, and those for its columns.
fn operands<'a, T>(
    tree: &TaskTree,
    id: usize,
    form: Form,
    rows: usize,
    entries: &'a [T],
) -> [MatRef<'a, T>; 2] {
    let task = &tree.nodes()[id].task;
    let [of_rows, of_cols] = [task.rows.len(), task.cols.len()];
    if tree.is_one_block(id) {
        let (right, left) = form.part_of_a(entries, rows, of_cols + of_rows).split_at_col(of_cols);
        return [left, right];
    }
    let (left, right) = entries.split_at(rows * of_rows);
    let left = form.part_of_a(left, rows, of_rows);
    [left, if task.triangle { left } else { form.part_of_a(right, rows, of_cols) }]
}

/// Returns the block of C of `node`.
fn block<'a, T>(form: Form, node: &TreeNode, entries: &'a mut [T]) -> MatMut<'a, T> {
    let (rows, cols) = (node.task.rows.len(), node.task.cols.len());
    match form.c_by_rows {
        true => MatMut::from_row_major_slice_mut(entries, rows, cols),
        false => MatMut::from_column_major_slice_mut(entries, rows, cols),
    }
}

/// All memory that a process needs, so that no later allocation can fail.
struct Memory<T> {
    results: Results<T>,
    /// The strips of the nodes that are sent to the process.
    inputs: Vec<Vec<Buffer<T>>>,
    blocks: Vec<Buffer<T>>,
}

impl<T: Real> Memory<T> {
    fn new(tree: &TaskTree, process: usize) -> Result<Self> {
        let nodes = tree.nodes();
        let entries = tree.entries(process);
        let strips = |node: &TreeNode| {
            node.strips()
                .map(|rows| Buffer::of_len(node.words_of(rows.len())))
                .collect::<Result<_>>()
        };
        let inputs = entries.iter().map(|&id| strips(&nodes[id])).collect::<Result<_>>()?;
        let blocks = entries
            .iter()
            .map(|&id| Buffer::of_len(nodes[id].block_len()))
            .collect::<Result<_>>()?;
        let tops = if process == 0 { &[0][..] } else { &entries };
        let expected = tops.iter().flat_map(|&id| tree.results(id)).collect();
        Ok(Self { results: Results::new(tree, expected)?, inputs, blocks })
    }
}

/// Receives the results of other processes in the order in which they are added: the next one
/// arrives while the process does something else.
struct Results<T> {
    /// The nodes whose results are expected.
    expected: VecDeque<usize>,
    under_way: VecDeque<Transfer<T>>,
    spare: Vec<Buffer<T>>,
}

impl<T: Real> Results<T> {
    fn new(tree: &TaskTree, expected: VecDeque<usize>) -> Result<Self> {
        let longest = expected.iter().map(|&id| tree.nodes()[id].result_len()).max().unwrap_or(0);
        let spare =
            (0..RESULTS_IN_FLIGHT).map(|_| Buffer::with_room(longest)).collect::<Result<_>>()?;
        Ok(Self { expected, under_way: VecDeque::new(), spare })
    }
}

struct Worker<'w, T> {
    world: &'w World,
    tree: &'w TaskTree,
    form: Form,
    alpha: T,
    options: &'w AtaOptions<'w>,
    results: Results<T>,
    /// Work done, and all work.
    products: (f64, f64),
    /// The first error. After it the messages continue, with unspecified entries, so that no rank
    /// waits.
    done: Result<()>,
}

impl<T: MpiReal> Worker<'_, T> {
    fn rank(&self, process: usize) -> usize {
        self.form.rank(process, self.world.size())
    }

    /// Receives, runs and returns the nodes `ids`.
    fn run_entries(&mut self, ids: &[usize], inputs: Vec<Vec<Buffer<T>>>, blocks: Vec<Buffer<T>>) {
        let Some(parent) = ids.first().and_then(|&id| self.tree.nodes()[id].parent) else { return };
        let above = self.rank(self.tree.nodes()[parent].task.process);
        let receive = |(i, strip)| Transfer::receive(self.world, strip, above, STRIPS.tag(i));
        let receive = |strips: Vec<_>| (0..).zip(strips).map(receive).collect::<Vec<_>>();
        let inputs: Vec<_> = inputs.into_iter().map(receive).collect();
        let mut returned = Vec::new();
        for ((&id, strips), mut entries) in ids.iter().zip(inputs).zip(blocks) {
            let node = &self.tree.nodes()[id];
            let mut beta = T::ZERO;
            for (rows, strip) in node.strips().zip(strips) {
                let strip = strip.wait();
                let operands = operands(self.tree, id, self.form, rows.len(), &strip);
                let block = block(self.form, node, &mut entries);
                self.run(id, operands, beta, block, &|| false);
                beta = T::ONE;
            }
            if node.task.triangle {
                let len = pack(&mut entries, node.task.rows.len(), self.form.c_by_rows);
                entries.set_len(len);
            }
            returned.push(Transfer::send(self.world, entries, [above], RESULT));
        }
        returned.into_iter().for_each(|result| drop(result.wait()));
    }

    /// Computes `C := beta C` + the product of node `id`. This process has the operands, or some
    /// rows of them if the node is a leaf. `moves` returns whether parts of A are still on their
    /// way from this process.
    fn run(
        &mut self,
        id: usize,
        operands: [MatRef<'_, T>; 2],
        beta: T,
        mut c: MatMut<'_, T>,
        moves: &dyn Fn() -> bool,
    ) {
        self.start_results();
        let tree = self.tree;
        let node = &tree.nodes()[id];
        if node.is_leaf() {
            return self.multiply(node, operands, beta, c, moves);
        }
        // All other processes get what they need before this process begins.
        let sent = tree.planned_sends(node);
        let sent: PendingSends<'_, T> =
            sent.map(|it| self.start_send(node, &it, operands)).collect();
        let moves = || sent.are_moving() | moves();
        for id in node.children.clone() {
            let child = &tree.nodes()[id];
            let rows = within(&child.task.rows, &node.task.rows);
            let cols = within(&child.task.cols, &node.task.cols);
            let block = c.rb_mut().get_mut(rows, cols);
            let beta = if child.is_first { beta } else { T::ONE };
            if tree.is_sent(id) {
                self.add_result(child, beta, block);
            } else {
                self.run(id, operands_of(child, node, operands), beta, block, &moves);
            }
        }
    }

    fn multiply(
        &mut self,
        node: &TreeNode,
        [left, right]: [MatRef<'_, T>; 2],
        beta: T,
        c: MatMut<'_, T>,
        moves: &dyn Fn() -> bool,
    ) {
        if self.done.is_err() {
            return;
        }
        let (done, all) = (self.products.0, self.products.1.max(1.0));
        self.products.0 += node.result_len() as f64 * left.nrows() as f64;
        let (world, alpha) = (self.world, self.alpha);
        let share = done / all..self.products.0 / all;
        self.done = world.with_progress(self.options, share, moves, |options| {
            if node.task.triangle {
                ata_into(alpha, left, beta, c, &AtaOptions { uplo: Uplo::Lower, ..options.clone() })
            } else {
                atb_into(alpha, left, right, beta, c, options)
            }
        });
    }

    /// Starts to send a strip of the operands of a child.
    fn start_send<'a>(
        &self,
        parent: &TreeNode,
        planned: &PlannedSend,
        operands: [MatRef<'a, T>; 2],
    ) -> PendingSend<'a, T>
    where
        Self: 'a,
    {
        let PlannedSend { child: id, strip, rows } = planned;
        let child = &self.tree.nodes()[*id];
        let parts = if self.tree.is_one_block(*id) {
            let columns = child.task.cols.start..child.task.rows.end;
            let sums = within(&child.sums, &parent.sums);
            vec![operands[0].get(sums, within(&columns, &parent.task.rows))]
        } else {
            let parts = operands_of(child, parent, operands);
            parts[..if child.task.triangle { 1 } else { 2 }].to_vec()
        };
        let strips: Vec<_> =
            parts.iter().map(|part| part.subrows(rows.start, rows.len())).collect();
        let (to, tag) = (self.rank(child.task.process), STRIPS.tag(*strip));
        self.form.start_send(self.world, &strips, to, tag)
    }

    /// Starts to receive as many of the next results as there is room for.
    fn start_results(&mut self) {
        while let Some(mut entries) = self.results.spare.pop() {
            let Some(id) = self.results.expected.pop_front() else {
                self.results.spare.push(entries);
                return;
            };
            let node = &self.tree.nodes()[id];
            entries.set_len(node.result_len());
            let from = self.rank(node.task.process);
            let result = Transfer::receive(self.world, entries, from, RESULT);
            self.results.under_way.push_back(result);
        }
    }

    /// Computes `C := beta C` + the next result, which is that of `child`.
    fn add_result(&mut self, child: &TreeNode, beta: T, c: MatMut<'_, T>) {
        self.start_results();
        let Some(result) = self.results.under_way.pop_front() else {
            unreachable!("results are expected in the order of the tree")
        };
        let result = result.wait();
        add(c, beta, &result, child.task.triangle, self.form.c_by_rows);
        self.results.spare.push(result);
    }
}

/// Returns a range inside another one, counted from the start of that.
fn within(range: &Range<usize>, outer: &Range<usize>) -> Range<usize> {
    range.start - outer.start..range.end - outer.start
}

/// Returns the operands of a child, from those of its parent.
fn operands_of<'a, T>(
    child: &TreeNode,
    parent: &TreeNode,
    [left, right]: [MatRef<'a, T>; 2],
) -> [MatRef<'a, T>; 2] {
    let sums = within(&child.sums, &parent.sums);
    [
        left.get(sums.clone(), within(&child.task.rows, &parent.task.rows)),
        right.get(sums, within(&child.task.cols, &parent.task.cols)),
    ]
}

/// Returns the entries of line `line` of a lower triangle of n lines, rows or columns.
fn triangle_line(line: usize, n: usize, by_rows: bool) -> Range<usize> {
    if by_rows { 0..line + 1 } else { line..n }
}

/// Moves the entries of a square of n lines that are not above the diagonal to its front, and
/// returns their number.
fn pack<T: Copy>(square: &mut [T], n: usize, by_rows: bool) -> usize {
    let mut end = 0;
    for line in 0..n {
        let entries = triangle_line(line, n, by_rows);
        let (start, len) = (line * n + entries.start, entries.len());
        square.copy_within(start..start + len, end);
        end += len;
    }
    end
}

/// Computes `C := beta C` + the lines of `result`; with `beta == 0` C is not read.
fn add<T: Real>(c: MatMut<'_, T>, beta: T, result: &[T], triangle: bool, by_rows: bool) {
    let mut c = if by_rows { c } else { c.transpose_mut() };
    let len = c.ncols();
    let mut rest = result;
    for line in 0..c.nrows() {
        let entries = if triangle { triangle_line(line, len, by_rows) } else { 0..len };
        let (terms, others) = rest.split_at(entries.len());
        rest = others;
        let sums = c.rb_mut().row_mut(line).subcols_mut(entries.start, entries.len());
        add_line(sums, beta, terms);
    }
}

fn add_line<T: Real>(mut sums: RowMut<'_, T>, beta: T, terms: &[T]) {
    let add = |(sum, &term): (&mut T, &T)| {
        *sum = if beta == T::ZERO { term } else { beta * *sum + term };
    };
    match sums.rb_mut().try_as_row_major_mut() {
        Some(sums) => sums.as_slice_mut().iter_mut().zip(terms).for_each(add),
        None => sums.iter_mut().zip(terms).for_each(add),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::base::triangle_len;

    #[test]
    fn packed_triangles_are_added_where_they_were() {
        for n in [0_usize, 1, 2, 5, 7] {
            let values: Vec<f64> = (0..n * n).map(|i| i as f64).collect();
            for by_rows in [false, true] {
                let mut packed = values.clone();
                let len = pack(&mut packed, n, by_rows);
                assert_eq!(len, triangle_len(n));
                packed.truncate(len);
                for (beta, stored_by_rows) in
                    [(0.0, true), (0.0, false), (1.0, true), (-2.0, false)]
                {
                    let old = if beta == 0.0 { f64::NAN } else { 3.0 };
                    let mut c = vec![old; n * n];
                    let view = MatMut::from_row_major_slice_mut(&mut c, n, n);
                    let mut c = if stored_by_rows { view } else { view.transpose_mut() };
                    add(c.rb_mut(), beta, &packed, true, by_rows);
                    for i in 0..n {
                        for j in 0..n {
                            let value = if by_rows { values[i * n + j] } else { values[j * n + i] };
                            let expected = match (j <= i, beta == 0.0) {
                                (true, true) => value,
                                (true, false) => beta * old + value,
                                (false, _) => old,
                            };
                            assert_eq!(c[(i, j)].to_bits(), expected.to_bits());
                        }
                    }
                }
            }
        }
    }
}
