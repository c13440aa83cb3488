//! Solutions with a supernodal factor: sweeps down and up the elimination tree.
//!
//! Eight right-hand sides lie side by side, so that an entry of L is read once for all of them and
//! a row of them is one register. Different threads sweep independent parts of the tree; the parts
//! are the same for any number of threads.

use std::ops::Range;
use std::sync::Mutex;

use faer::MatMut;
use faer::prelude::ReborrowMut;

use super::parts::split;
use super::pattern::Pattern;
use super::supernode::{Block, Row, Supernode, WIDTH};
use crate::base::{
    Disjoint, Par, Result, has_fused, push, repeated, reserved, spend, widest, zeros,
};

/// The order in which the supernodes of a factor are applied, and to which rows.
#[derive(Debug, Default)]
pub(super) struct Sweeps {
    nodes: Vec<Node>,
    /// For each row below the triangle of a supernode, the row of its part.
    targets: Vec<u32>,
    /// Independent subtrees.
    subtrees: Vec<Part>,
    /// The nodes above all subtrees.
    top: Part,
    /// Rows of right-hand sides, kept from one solution to the next.
    kept: Mutex<Vec<Row>>,
    /// Whether to multiply and add at once.
    pub fused: bool,
}

#[derive(Debug)]
struct Node {
    supernode: Supernode,
    /// The first of the supernode's rows in its part.
    first: usize,
    /// The supernode's range of [`Sweeps::targets`].
    targets: Range<usize>,
}

/// Supernodes that one thread sweeps, on rows of right-hand sides in memory of their own.
#[derive(Debug, Default)]
struct Part {
    nodes: Range<usize>,
    /// For each of its own rows, the row of the right-hand side.
    own: Vec<u32>,
    /// For each row of the top that it changes, that row. These rows follow its own. Those of the
    /// top itself are the border.
    above: Vec<u32>,
    /// Number of values of the factor.
    values: usize,
}

/// The values of a factor, and the entries of B below its diagonal, if there is a B.
#[derive(Debug, Clone, Copy)]
struct Factor<'a> {
    values: &'a [f64],
    subdiagonal: Option<&'a [f64]>,
}

/// What is done between the sweeps with the number of columns and the rows of the border.
type Between<'b> = dyn FnMut(usize, &mut [Row]) -> Result<()> + 'b;

impl Sweeps {
    /// Creates the sweeps for factors with these supernodes. Row `i` of the factor is row
    /// `order[i]` of right-hand sides, and row `place(i)` of the factor is row `i` of its pattern
    /// (pivots inside supernodes). Rows of the border are those of right-hand sides in no part.
    pub fn new(
        pattern: &Pattern,
        order: impl Fn(usize) -> usize,
        place: impl Fn(usize) -> usize,
    ) -> Result<Self> {
        let supernodes = &pattern.nodes;
        let parent = |s: usize| {
            let owner = |&row: &u32| pattern.owner.get(row as usize).map(|&node| node as usize);
            pattern.below(s).first().and_then(owner)
        };
        let mut parents = reserved(supernodes.len())?;
        parents.extend((0..supernodes.len()).map(parent));
        let work = |s: usize| (supernodes[s].columns + supernodes[s].below) * supernodes[s].columns;
        let (subtrees, top) = split(&parents, work);

        let rows_of = |nodes: &[usize]| -> Result<Vec<usize>> {
            let mut rows = reserved(nodes.iter().map(|&s| supernodes[s].columns).sum())?;
            for &s in nodes {
                rows.extend(supernodes[s].start..supernodes[s].start + supernodes[s].columns);
            }
            Ok(rows)
        };
        const NONE: u32 = u32::MAX;
        let mut row_of_top = repeated(NONE, pattern.n)?;
        let border = pattern.columns()..pattern.n;
        let of_top = rows_of(&top)?.into_iter().chain(border.clone());
        (0..).zip(of_top).for_each(|(i, row)| row_of_top[row] = i);

        let mut sweeps = Self {
            nodes: reserved(supernodes.len())?,
            targets: reserved(pattern.all_below())?,
            subtrees: vec![],
            top: Part::default(),
            kept: Mutex::default(),
            fused: has_fused(),
        };
        let mut row_of_part = repeated(NONE, pattern.n)?;
        let mut part = |nodes: &[usize], border: Range<usize>| -> Result<Part> {
            let own = rows_of(nodes)?;
            (0..).zip(&own).for_each(|(i, &row)| row_of_part[row] = i);
            let (mut above, mut first, start) = (Vec::new(), 0, sweeps.nodes.len());
            let values = nodes.iter().map(|&s| supernodes[s].range().len()).sum();
            for row in border {
                row_of_part[row] = (own.len() + above.len()) as u32;
                push(&mut above, row)?;
            }
            for &s in nodes {
                let targets = sweeps.targets.len();
                for row in pattern.below(s).iter().map(|&row| place(row as usize)) {
                    if row_of_part[row] == NONE {
                        row_of_part[row] = (own.len() + above.len()) as u32;
                        push(&mut above, row)?;
                    }
                    sweeps.targets.push(row_of_part[row]);
                }
                let targets = targets..sweeps.targets.len();
                sweeps.nodes.push(Node { supernode: supernodes[s], first, targets });
                first += supernodes[s].columns;
            }
            own.iter().chain(&above).for_each(|&row| row_of_part[row] = NONE);
            let (mut own_rows, mut rows_above) = (reserved(own.len())?, reserved(above.len())?);
            own_rows.extend(own.iter().map(|&row| order(row) as u32));
            rows_above.extend(above.iter().map(|&row| row_of_top[row]));
            let nodes = start..sweeps.nodes.len();
            Ok(Part { nodes, own: own_rows, above: rows_above, values })
        };
        let subtrees =
            subtrees.iter().map(|nodes| part(nodes, 0..0)).collect::<Result<Vec<_>>>()?;
        let top = part(&top, border)?;
        (sweeps.subtrees, sweeps.top) = (subtrees, top);
        Ok(sweeps)
    }

    /// Returns the blocks of B in `L B L^T`; `subdiagonal` has the entries of B below the diagonal.
    pub fn blocks<'s>(
        &'s self,
        values: &'s [f64],
        subdiagonal: &'s [f64],
    ) -> impl Iterator<Item = Block> + use<'s> {
        let of = move |node: &'s Node| node.supernode.blocks(values, subdiagonal);
        self.nodes.iter().flat_map(of).map(|(_, block)| block)
    }

    /// Returns the number of rows of right-hand sides in all parts.
    fn rows(&self) -> usize {
        self.subtrees.iter().chain([&self.top]).map(Part::rows).sum()
    }

    /// Solves `X := A^-1 X` for the matrix with these values of its factor: `L L^T`, or, where
    /// `subdiagonal` has the entries of B below the diagonal, `L B L^T`, of which the values have B
    /// in place of the unit diagonal of L. The result is the same for every `par`, bit for bit.
    pub fn solve(
        &self,
        values: &[f64],
        subdiagonal: Option<&[f64]>,
        x: MatMut<'_, f64>,
        par: Par,
    ) -> Result<()> {
        self.solve_for(values, subdiagonal, x, &vec![true; self.subtrees.len()], par)
    }

    /// Returns for each subtree whether one of its rows of right-hand sides is wanted.
    pub fn subtrees_of(&self, is_wanted: impl Fn(usize) -> bool) -> Vec<bool> {
        let wants = |part: &Part| part.own.iter().any(|&row| is_wanted(row as usize));
        self.subtrees.iter().map(wants).collect()
    }

    /// Computes [`Sweeps::solve`] of the rows of some of the subtrees, and of those above all
    /// subtrees; the others keep the right-hand sides.
    pub fn solve_for(
        &self,
        values: &[f64],
        subdiagonal: Option<&[f64]>,
        x: MatMut<'_, f64>,
        is_wanted: &[bool],
        par: Par,
    ) -> Result<()> {
        let factor = Factor { values, subdiagonal };
        self.solve_both(factor, x, is_wanted, &mut |_, _| Ok(()), par)
    }

    /// Computes [`Sweeps::solve`] of the rows before a border. Between the sweeps, `between` gets
    /// the number of columns and what the rows before it add to the rows of the border, for which
    /// it puts the solution there.
    pub fn solve_around(
        &self,
        values: &[f64],
        subdiagonal: Option<&[f64]>,
        x: MatMut<'_, f64>,
        between: &mut Between<'_>,
        par: Par,
    ) -> Result<()> {
        let all = vec![true; self.subtrees.len()];
        self.solve_both(Factor { values, subdiagonal }, x, &all, between, par)
    }

    fn solve_both(
        &self,
        factor: Factor<'_>,
        mut x: MatMut<'_, f64>,
        is_wanted: &[bool],
        between: &mut Between<'_>,
        par: Par,
    ) -> Result<()> {
        let mut kept = self.kept.try_lock();
        let mut own = Vec::new();
        let rows = kept.as_deref_mut().unwrap_or(&mut own);
        if rows.is_empty() {
            *rows = zeros(self.rows())?;
        }
        let solve_block = match (factor.subdiagonal.is_some(), self.fused) {
            (false, false) => Self::solve_block::<false, false>,
            (false, true) => Self::solve_block::<false, true>,
            (true, false) => Self::solve_block::<true, false>,
            (true, true) => Self::solve_block::<true, true>,
        };
        for first in (0..x.ncols()).step_by(WIDTH) {
            let width = WIDTH.min(x.ncols() - first);
            let x = x.rb_mut().subcols_mut(first, width);
            solve_block(self, factor, x, is_wanted, rows, between, par)?;
        }
        Ok(())
    }

    /// Computes [`Sweeps::solve_for`] for at most [`WIDTH`] columns, with memory for all rows of
    /// all parts. With `UNIT` the factor is that of `L B L^T`; for `FUSED` see
    /// [`Supernode::down`].
    fn solve_block<const UNIT: bool, const FUSED: bool>(
        &self,
        factor: Factor<'_>,
        x: MatMut<'_, f64>,
        is_wanted: &[bool],
        rows: &mut [Row],
        between: &mut Between<'_>,
        par: Par,
    ) -> Result<()> {
        let columns = x.ncols();
        let x = Disjoint::new(x);
        let (top, mut rest) = rows.split_at_mut(self.top.rows());
        let mut subtrees = Vec::with_capacity(self.subtrees.len());
        for part in &self.subtrees {
            let (own, others) = rest.split_at_mut(part.rows());
            subtrees.push((part, own));
            rest = others;
        }
        let largest = self.subtrees.iter().map(|part| part.values).max().unwrap_or(0);
        let operations = operations_of(largest);
        par.for_each_asking(subtrees.iter_mut(), operations, |_, (part, rows)| {
            // SAFETY: each row belongs to one part only, each part to one call of this closure, and
            // nobody else has X, which is borrowed.
            unsafe { part.gather(&x, rows) };
            self.down::<UNIT, FUSED>(part.nodes.clone(), factor, rows);
        })?;
        // SAFETY: `for_each_asking` has returned, so no part of a subtree is being computed, and
        // nobody else has X, which is borrowed.
        unsafe { self.top.gather(&x, top) };
        for (part, rows) in &subtrees {
            for (&row, change) in part.above.iter().zip(&rows[part.own.len()..]) {
                let row = &mut top[row as usize];
                *row = std::array::from_fn(|j| row[j] + change[j]);
            }
        }
        for run in self.runs(&self.top) {
            self.down::<UNIT, FUSED>(run.nodes, factor, top);
            spend(operations_of(run.values))?;
        }
        between(columns, &mut top[self.top.own.len()..])?;
        for run in self.runs(&self.top).into_iter().rev() {
            self.up::<UNIT, FUSED>(run.nodes, factor, top);
            spend(operations_of(run.values))?;
        }
        // SAFETY: no other part is being computed on any thread, and nobody else has X, which is
        // borrowed.
        unsafe { self.top.scatter(&x, top) };
        let top = &*top;
        let wanted = subtrees.into_iter().zip(is_wanted).filter(|(_, is_wanted)| **is_wanted);
        par.for_each_asking(wanted, operations, |_, ((part, rows), _)| {
            for (row, &i) in rows[part.own.len()..].iter_mut().zip(&part.above) {
                *row = top[i as usize];
            }
            self.up::<UNIT, FUSED>(part.nodes.clone(), factor, rows);
            // SAFETY: each row belongs to one part only, and each part to one call of this closure.
            unsafe { part.scatter(&x, rows) };
        })
    }

    /// Returns the nodes of a part in runs, after each of which a sweep asks whether to go on.
    fn runs(&self, part: &Part) -> Vec<Run> {
        /// Values of a run, unless it is a single node.
        const VALUES: usize = 1 << 20;
        let mut runs: Vec<Run> = Vec::new();
        for s in part.nodes.clone() {
            let values = self.nodes[s].supernode.range().len();
            match runs.last_mut() {
                Some(run) if run.values + values <= VALUES => {
                    run.nodes.end = s + 1;
                    run.values += values;
                }
                _ => runs.push(Run { nodes: s..s + 1, values }),
            }
        }
        runs
    }

    /// Computes `x := L^-1 x` of the rows of these nodes of a part, and the updates of the rows
    /// above.
    fn down<const UNIT: bool, const FUSED: bool>(
        &self,
        nodes: Range<usize>,
        factor: Factor<'_>,
        x: &mut [Row],
    ) {
        let nodes = &self.nodes[nodes];
        widest(
            #[inline(always)]
            || {
                for node in nodes {
                    let targets = &self.targets[node.targets.clone()];
                    node.supernode.down::<UNIT, FUSED>(factor.values, node.first, targets, x);
                }
            },
        );
    }

    /// Computes `x := B^-1 x` and `x := L^-T x` of the rows of these nodes of a part; the rows
    /// above are known.
    fn up<const UNIT: bool, const FUSED: bool>(
        &self,
        nodes: Range<usize>,
        factor: Factor<'_>,
        x: &mut [Row],
    ) {
        let Factor { values, subdiagonal } = factor;
        let (nodes, mut rows) = (&self.nodes[nodes], Vec::new());
        widest(
            #[inline(always)]
            || {
                for Node { supernode, first, targets } in nodes.iter().rev() {
                    let own = *first..first + supernode.columns;
                    if UNIT {
                        for (i, block) in supernode.blocks(values, subdiagonal.unwrap_or(&[])) {
                            block.solve(&mut x[first + i..]);
                        }
                    }
                    rows.clear();
                    rows.extend_from_slice(&x[own.clone()]);
                    rows.extend(self.targets[targets.clone()].iter().map(|&i| x[i as usize]));
                    supernode.up::<UNIT, FUSED>(values, &mut rows);
                    x[own].copy_from_slice(&rows[..supernode.columns]);
                }
            },
        );
    }
}

/// Nodes of a part that follow each other.
struct Run {
    nodes: Range<usize>,
    /// Number of values of the factor.
    values: usize,
}

/// Returns the operations of a sweep over so many values, for eight columns, whether they are used
/// or not.
fn operations_of(values: usize) -> f64 {
    2.0 * WIDTH as f64 * values as f64
}

impl Part {
    fn rows(&self) -> usize {
        self.own.len() + self.above.len()
    }

    /// Copies its own rows from X, and clears those above.
    ///
    /// # Safety
    /// No thread writes its own rows of X meanwhile.
    unsafe fn gather(&self, x: &Disjoint<'_, f64>, rows: &mut [Row]) {
        let (own, above) = rows.split_at_mut(self.own.len());
        above.fill([0.0; WIDTH]);
        for j in 0..x.ncols() {
            let column = x.pointer(&(0..x.nrows()), &(j..j + 1));
            for (row, &i) in own.iter_mut().zip(&self.own) {
                // SAFETY: rows of the factor are rows of X; no thread writes this one.
                row[j] = unsafe { *column.at(i as isize * x.row_stride()) };
            }
        }
    }

    /// Copies its own rows to X.
    ///
    /// # Safety
    /// No other thread reads or writes its own rows of X meanwhile.
    unsafe fn scatter(&self, x: &Disjoint<'_, f64>, rows: &[Row]) {
        for j in 0..x.ncols() {
            let column = x.pointer(&(0..x.nrows()), &(j..j + 1));
            for (row, &i) in rows.iter().zip(&self.own) {
                // SAFETY: rows of the factor are rows of X; by the contract no other thread uses
                // this one.
                unsafe { *column.at(i as isize * x.row_stride()) = row[j] };
            }
        }
    }
}
