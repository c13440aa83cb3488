//! Solutions with a supernodal factor: sweeps down and up the elimination tree.
//!
//! Eight right-hand sides lie side by side, so that an entry of L is read once for all of them and
//! a row of them is one register. Different threads sweep independent parts of the tree; the parts
//! are the same for any number of threads.

use std::ops::Range;
use std::sync::Mutex;

use faer::MatMut;
use faer::prelude::ReborrowMut;
use faer::sparse::linalg::cholesky::supernodal::SymbolicSupernodalCholesky;

use super::parts::split;
use super::supernode::{Row, Supernode, WIDTH};
use crate::base::{Disjoint, Par, Result, has_fused, widest, zeros};

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
    /// For each row of the top that it changes, that row. These rows follow its own.
    above: Vec<u32>,
}

/// The values of a factor, and the entries of B below its diagonal, if there is a B.
#[derive(Debug, Clone, Copy)]
struct Factor<'a> {
    values: &'a [f64],
    subdiagonal: &'a [f64],
}

impl Sweeps {
    /// Creates the sweeps for factors with these supernodes. Row `i` of the factor is row
    /// `order[i]` of right-hand sides, and row `place(i)` of the factor is row `i` of its pattern
    /// (pivots inside supernodes).
    pub fn new(
        symbolic: &SymbolicSupernodalCholesky<usize>,
        order: impl Fn(usize) -> usize,
        place: impl Fn(usize) -> usize,
    ) -> Self {
        let supernodes = supernodes(symbolic);
        let mut owner = vec![0; symbolic.nrows()];
        for (s, node) in supernodes.iter().enumerate() {
            owner[node.start..][..node.columns].fill(s);
        }
        let pattern = |s: usize| symbolic.supernode(s).pattern();
        let parents: Vec<_> =
            (0..supernodes.len()).map(|s| pattern(s).iter().map(|&i| owner[i]).min()).collect();
        let work = |s: usize| (supernodes[s].columns + supernodes[s].below) * supernodes[s].columns;
        let (subtrees, top) = split(&parents, work);

        let rows_of = |nodes: &[usize]| -> Vec<usize> {
            let rows =
                |&s: &usize| supernodes[s].start..supernodes[s].start + supernodes[s].columns;
            nodes.iter().flat_map(rows).collect()
        };
        const NONE: u32 = u32::MAX;
        let mut row_of_top = vec![NONE; symbolic.nrows()];
        (0..).zip(rows_of(&top)).for_each(|(i, row)| row_of_top[row] = i);

        let mut sweeps = Self {
            nodes: Vec::with_capacity(supernodes.len()),
            targets: Vec::with_capacity(symbolic.row_idx().len()),
            subtrees: vec![],
            top: Part::default(),
            kept: Mutex::default(),
            fused: has_fused(),
        };
        let mut row_of_part = vec![NONE; symbolic.nrows()];
        let mut part = |nodes: &[usize]| {
            let own = rows_of(nodes);
            (0..).zip(&own).for_each(|(i, &row)| row_of_part[row] = i);
            let (mut above, mut first, start) = (Vec::new(), 0, sweeps.nodes.len());
            for &s in nodes {
                let targets = sweeps.targets.len();
                for row in pattern(s).iter().map(|&row| place(row)) {
                    if row_of_part[row] == NONE {
                        row_of_part[row] = (own.len() + above.len()) as u32;
                        above.push(row);
                    }
                    sweeps.targets.push(row_of_part[row]);
                }
                let targets = targets..sweeps.targets.len();
                sweeps.nodes.push(Node { supernode: supernodes[s], first, targets });
                first += supernodes[s].columns;
            }
            own.iter().chain(&above).for_each(|&row| row_of_part[row] = NONE);
            Part {
                nodes: start..sweeps.nodes.len(),
                own: own.iter().map(|&row| order(row) as u32).collect(),
                above: above.iter().map(|&row| row_of_top[row]).collect(),
            }
        };
        let subtrees = subtrees.iter().map(|nodes| part(nodes)).collect();
        let top = part(&top);
        (sweeps.subtrees, sweeps.top) = (subtrees, top);
        sweeps
    }

    /// Returns the number of negative eigenvalues of B in `L B L^T`; `subdiagonal` has the entries
    /// of B below the diagonal.
    pub fn negative(&self, values: &[f64], subdiagonal: &[f64]) -> usize {
        let blocks = |node: &Node| {
            node.supernode
                .blocks(values, subdiagonal)
                .map(|(_, block)| block.negative())
                .sum::<usize>()
        };
        self.nodes.iter().map(blocks).sum()
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
        mut x: MatMut<'_, f64>,
        par: Par,
    ) -> Result<()> {
        let mut kept = self.kept.try_lock();
        let mut own = Vec::new();
        let rows = kept.as_deref_mut().unwrap_or(&mut own);
        if rows.is_empty() {
            *rows = zeros(self.rows())?;
        }
        let solve_block = match (subdiagonal.is_some(), self.fused) {
            (false, false) => Self::solve_block::<false, false>,
            (false, true) => Self::solve_block::<false, true>,
            (true, false) => Self::solve_block::<true, false>,
            (true, true) => Self::solve_block::<true, true>,
        };
        let factor = Factor { values, subdiagonal: subdiagonal.unwrap_or(&[]) };
        for first in (0..x.ncols()).step_by(WIDTH) {
            let width = WIDTH.min(x.ncols() - first);
            solve_block(self, factor, x.rb_mut().subcols_mut(first, width), rows, par);
        }
        Ok(())
    }

    /// Computes [`Sweeps::solve`] for at most [`WIDTH`] columns, with memory for all rows of all
    /// parts. With `UNIT` the factor is that of `L B L^T`; for `FUSED` see [`Supernode::down`].
    fn solve_block<const UNIT: bool, const FUSED: bool>(
        &self,
        factor: Factor<'_>,
        x: MatMut<'_, f64>,
        rows: &mut [Row],
        par: Par,
    ) {
        let x = Disjoint::new(x);
        let (top, mut rest) = rows.split_at_mut(self.top.rows());
        let mut subtrees = Vec::with_capacity(self.subtrees.len());
        for part in &self.subtrees {
            let (own, others) = rest.split_at_mut(part.rows());
            subtrees.push((part, own));
            rest = others;
        }
        par.for_each(subtrees.iter_mut(), |_, (part, rows)| {
            // SAFETY: each row belongs to one part only.
            unsafe { part.gather(&x, rows) };
            self.down::<UNIT, FUSED>(part, factor, rows);
        });
        // SAFETY: as above, and no other part is being computed.
        unsafe { self.top.gather(&x, top) };
        for (part, rows) in &subtrees {
            for (&row, change) in part.above.iter().zip(&rows[part.own.len()..]) {
                let row = &mut top[row as usize];
                *row = std::array::from_fn(|j| row[j] + change[j]);
            }
        }
        self.down::<UNIT, FUSED>(&self.top, factor, top);
        self.up::<UNIT, FUSED>(&self.top, factor, top);
        // SAFETY: as above.
        unsafe { self.top.scatter(&x, top) };
        let top = &*top;
        par.for_each(subtrees.into_iter(), |_, (part, rows)| {
            for (row, &i) in rows[part.own.len()..].iter_mut().zip(&part.above) {
                *row = top[i as usize];
            }
            self.up::<UNIT, FUSED>(part, factor, rows);
            // SAFETY: as above.
            unsafe { part.scatter(&x, rows) };
        });
    }

    /// Computes `x := L^-1 x` of the part's own rows, and the updates of the rows above.
    fn down<const UNIT: bool, const FUSED: bool>(
        &self,
        part: &Part,
        factor: Factor<'_>,
        x: &mut [Row],
    ) {
        widest(
            #[inline(always)]
            || {
                for node in &self.nodes[part.nodes.clone()] {
                    let targets = &self.targets[node.targets.clone()];
                    node.supernode.down::<UNIT, FUSED>(factor.values, node.first, targets, x);
                }
            },
        );
    }

    /// Computes `x := B^-1 x` and `x := L^-T x` of the part's own rows; the rows above are known.
    fn up<const UNIT: bool, const FUSED: bool>(
        &self,
        part: &Part,
        factor: Factor<'_>,
        x: &mut [Row],
    ) {
        let Factor { values, subdiagonal } = factor;
        let mut rows = Vec::new();
        widest(
            #[inline(always)]
            || {
                for Node { supernode, first, targets } in
                    self.nodes[part.nodes.clone()].iter().rev()
                {
                    let own = *first..first + supernode.columns;
                    if UNIT {
                        for (i, block) in supernode.blocks(values, subdiagonal) {
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
                // SAFETY: as in `gather`.
                unsafe { *column.at(i as isize * x.row_stride()) = row[j] };
            }
        }
    }
}

/// Returns the supernodes of a factor, in its order.
fn supernodes(symbolic: &SymbolicSupernodalCholesky<usize>) -> Vec<Supernode> {
    let (starts, ends) = (symbolic.supernode_begin(), symbolic.supernode_end());
    let supernode = |s: usize| Supernode {
        start: starts[s],
        columns: ends[s] - starts[s],
        below: symbolic.supernode(s).pattern().len(),
        values: symbolic.col_ptr_for_val()[s],
    };
    (0..symbolic.n_supernodes()).map(supernode).collect()
}
