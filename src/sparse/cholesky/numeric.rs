//! The values of a factor, one supernode after another: each takes the updates of the earlier ones
//! that have rows in it, and is factorized as a dense matrix (Ng and Peyton, Block sparse Cholesky
//! algorithms on advanced uniprocessor computers, 1993).

use faer::diag::DiagMut;
use faer::dyn_stack::MemStack;
use faer::linalg::cholesky::lblt::factor as pivoted;
use faer::linalg::matmul::matmul;
use faer::linalg::triangular_solve::{
    solve_lower_triangular_in_place, solve_unit_lower_triangular_in_place,
};
use faer::prelude::{IntoConst, ReborrowMut};
use faer::{Accum, MatMut, MatRef};

use super::limits::Limits;
use super::pattern::{Entries, Pattern};
use super::supernode::Supernode;
use crate::base::{
    PIECE, Par, Progress, Result, ask, count, repeated, reserved, room, spend, zeros,
};
use crate::dense::{self, buffer};

/// Marks the end of a list.
const NONE: u32 = u32::MAX;

const SEQ: faer::Par = faer::Par::Seq;

/// B and the order of its pivots, for a matrix that is not positive definite.
#[derive(Debug)]
pub(super) struct Pivots {
    /// The entries of B below its diagonal.
    pub subdiagonal: Vec<f64>,
    /// For each row of the factor the row of the pattern, and the other way round.
    pub forward: Vec<usize>,
    pub inverse: Vec<usize>,
}

impl Pivots {
    pub fn new(n: usize) -> Result<Self> {
        let (mut forward, mut inverse) = (reserved(n)?, reserved(n)?);
        forward.extend(0..n);
        inverse.extend(0..n);
        Ok(Self { subdiagonal: zeros(n)?, forward, inverse })
    }
}

/// Computes the values of `L L^T` for the entries `a` of a matrix, in `memory`, which may have any
/// contents. Returns `Ok(Err(i))` when the pivot of row i of the factor is not allowed: without
/// `limits` it must be positive. Threads share the work of large supernodes; the result is the same
/// for every `par`, bit for bit.
pub(super) fn positive(
    pattern: &Pattern,
    entries: &Entries,
    a: &[f64],
    memory: Vec<f64>,
    mut limits: Option<&mut Limits>,
    par: Par,
    progress: Progress<'_>,
) -> Result<std::result::Result<Vec<f64>, usize>> {
    /// Part of the work between two reports.
    const STEP: f64 = 0.01;
    let work = |node: &Supernode| (node.rows() as f64).powi(2) * node.columns as f64;
    let total = pattern.nodes.iter().map(work).sum::<f64>();
    let (mut done, mut reported) = (0.0, 0.0);
    let mut numeric = Numeric::new(pattern, entries, a, memory, par)?;
    for (s, node) in pattern.nodes.iter().enumerate() {
        numeric.gather(s, None)?;
        if let Err(i) = numeric.factorize(s, limits.as_deref_mut())? {
            return Ok(Err(i));
        }
        numeric.attach(s);
        done += work(node);
        if progress.is_watched() && done - reported >= STEP * total {
            progress.report(done / total)?;
            reported = done;
        }
    }
    Ok(Ok(numeric.values))
}

/// Computes the values of `L B L^T`, and B.
pub(super) fn indefinite(
    pattern: &Pattern,
    entries: &Entries,
    a: &[f64],
) -> Result<(Vec<f64>, Pivots)> {
    let mut numeric = Numeric::new(pattern, entries, a, Vec::new(), Par::Seq)?;
    let mut pivots = Pivots::new(pattern.n)?;
    for s in 0..pattern.nodes.len() {
        numeric.gather(s, Some(&pivots))?;
        numeric.factorize_with_pivots(s, &mut pivots)?;
        numeric.attach(s);
    }
    Ok((numeric.values, pivots))
}

struct Numeric<'a> {
    pattern: &'a Pattern,
    entries: &'a Entries,
    a: &'a [f64],
    par: Par,
    values: Vec<f64>,
    /// For each supernode, the first of the earlier ones whose next rows are in it, and after each
    /// supernode the next one of its list.
    first: Vec<u32>,
    next: Vec<u32>,
    /// Rows below each supernode that have been applied.
    applied: Vec<u32>,
    /// For rows of the current supernode, their place in it.
    place: Vec<u32>,
    /// An update.
    update: Vec<f64>,
    /// The rows of an update that are also columns, times B.
    weighted: Vec<f64>,
}

impl<'a> Numeric<'a> {
    /// Prepares a factorization in `memory`, which may have any contents.
    fn new(
        pattern: &'a Pattern,
        entries: &'a Entries,
        a: &'a [f64],
        mut memory: Vec<f64>,
        par: Par,
    ) -> Result<Self> {
        let count = pattern.nodes.len();
        let values = match memory.len() == pattern.values {
            true => {
                memory.fill(0.0);
                memory
            }
            false => zeros(pattern.values)?,
        };
        Ok(Self {
            pattern,
            entries,
            a,
            par,
            values,
            first: repeated(NONE, count)?,
            next: repeated(NONE, count)?,
            applied: repeated(0, count)?,
            place: repeated(0, pattern.n)?,
            update: Vec::new(),
            weighted: Vec::new(),
        })
    }

    /// Sums the entries of the matrix and the updates of earlier supernodes.
    fn gather(&mut self, s: usize, pivots: Option<&Pivots>) -> Result<()> {
        let node = self.pattern.nodes[s];
        let own = node.start as u32..(node.start + node.columns) as u32;
        for (i, row) in (0..).zip(own.clone().chain(self.pattern.below(s).iter().copied())) {
            self.place[row as usize] = i;
        }
        let panel = &mut self.values[node.range()];
        for (j, column) in panel.chunks_exact_mut(node.rows()).enumerate() {
            for &(row, at) in self.entries.column(node.start + j) {
                column[self.place[row as usize] as usize] += self.a[at];
            }
        }
        let mut d = std::mem::replace(&mut self.first[s], NONE);
        while d != NONE {
            let following = self.next[d as usize];
            self.take_update(s, d as usize, own.end, pivots)?;
            self.attach(d as usize);
            d = following;
        }
        Ok(())
    }

    /// Puts a supernode into the list of the one that its next rows are in.
    fn attach(&mut self, s: usize) {
        if let Some(&row) = self.pattern.below(s).get(self.applied[s] as usize) {
            // Rows of the border are in no supernode.
            let Some(&target) = self.pattern.owner.get(row as usize) else { return };
            self.next[s] = self.first[target as usize];
            self.first[target as usize] = s as u32;
        }
    }

    /// Subtracts from supernode s, which ends before row `end`, the product of rows of the earlier
    /// supernode d.
    fn take_update(&mut self, s: usize, d: usize, end: u32, pivots: Option<&Pivots>) -> Result<()> {
        let (node, from) = (self.pattern.nodes[s], self.pattern.nodes[d]);
        let done = self.applied[d] as usize;
        let rows = &self.pattern.below(d)[done..];
        let width = rows.partition_point(|&row| row < end);
        self.applied[d] += width as u32;
        let (earlier, panel) = self.values.split_at_mut(node.values);
        let panel = &mut panel[..node.rows() * node.columns];
        let source = from.panel(&earlier[from.range()]).subrows(from.columns + done, rows.len());
        let k = from.columns;
        let across = match pivots {
            None => source.subrows(0, width),
            Some(pivots) => {
                resize(&mut self.weighted, width * k)?;
                let mut across = MatMut::from_column_major_slice_mut(&mut self.weighted, width, k);
                across.copy_from(source.subrows(0, width));
                let blocks = from.blocks(&earlier[..], &pivots.subdiagonal);
                blocks.for_each(|(i, block)| block.multiply_columns(across.rb_mut(), i));
                across.into_const()
            }
        };
        // Pieces of rows do not depend on the number of threads, which compute some at a time.
        let piece = (PIECE / (2 * width * k)).clamp(1, rows.len());
        let pieces = rows.len().div_ceil(piece);
        let par = if pieces > 1 { self.par } else { Par::Seq };
        let together = par.at_most(pieces).threads();
        for start in (0..rows.len()).step_by(piece * together) {
            let end = rows.len().min(start + piece * together);
            resize(&mut self.update, (end - start) * width)?;
            let firsts = (start..end).step_by(piece);
            let products = firsts.clone().zip(self.update.chunks_mut(piece * width));
            par.for_each(products, |_, (first, product)| {
                let height = product.len() / width;
                let product = MatMut::from_column_major_slice_mut(product, height, width);
                let left = source.subrows(first, height);
                matmul(product, Accum::Replace, left, across.transpose(), 1.0, SEQ);
            });
            count((2 * piece.min(end - start) * width * k) as f64);
            for (first, product) in firsts.zip(self.update.chunks(piece * width)) {
                let height = product.len() / width;
                for (j, update) in product.chunks_exact(height).enumerate() {
                    let column = (rows[j] as usize - node.start) * node.rows();
                    let column = &mut panel[column..column + node.rows()];
                    // Above the diagonal there is nothing.
                    let skipped = j.saturating_sub(first).min(height);
                    for (row, x) in rows[first + skipped..].iter().zip(&update[skipped..]) {
                        column[self.place[*row as usize] as usize] -= x;
                    }
                }
            }
            ask()?;
        }
        Ok(())
    }

    /// Factorizes a supernode. Returns `Ok(Err(i))` when the pivot of row i of the factor is not
    /// allowed: without `limits` it must be positive.
    fn factorize(
        &mut self,
        s: usize,
        mut limits: Option<&mut Limits>,
    ) -> Result<std::result::Result<(), usize>> {
        let node = self.pattern.nodes[s];
        let (mut triangle, mut below) = node.parts(&mut self.values[node.range()]);
        let held = limits.as_ref().map_or(0, |limits| limits.held.len());
        let done = match limits.as_deref_mut() {
            Some(limits) => limits.factorize(triangle.rb_mut(), node.start)?,
            None if node.columns == 1 => root(&mut triangle[(0, 0)]),
            None => dense::cholesky(triangle.rb_mut())?,
        };
        if let Err(j) = done {
            return Ok(Err(node.start + j));
        }
        if node.columns == 1 {
            let root = triangle[(0, 0)];
            below.rb_mut().col_mut(0).iter_mut().for_each(|x| *x /= root);
        } else {
            solve_below(node, triangle.into_const(), below.rb_mut(), self.par, |l, x| {
                solve_lower_triangular_in_place(l, x, SEQ);
            })?;
        }
        Ok(match limits {
            Some(limits) => limits.clear_below(held, node.start, self.pattern.below(s), below),
            None => Ok(()),
        })
    }

    /// Factorizes a supernode with pivots inside of it.
    fn factorize_with_pivots(&mut self, s: usize, pivots: &mut Pivots) -> Result<()> {
        let node = self.pattern.nodes[s];
        let (start, n) = (node.start, node.columns);
        let subdiagonal = &mut pivots.subdiagonal[start..start + n];
        let (mut triangle, mut below) = node.parts(&mut self.values[node.range()]);
        if n > 1 {
            let (mut forward, mut inverse) = (vec![0usize; n], vec![0usize; n]);
            let scratch = pivoted::cholesky_in_place_scratch::<usize, f64>;
            let mut memory = buffer(scratch(n, SEQ, Default::default()))?;
            count((n * n * n / 3) as f64);
            pivoted::cholesky_in_place(
                triangle.rb_mut(),
                DiagMut::from_slice_mut(subdiagonal),
                &mut forward,
                &mut inverse,
                SEQ,
                MemStack::new(&mut memory),
                Default::default(),
            );
            for i in 0..n {
                pivots.forward[start + i] = start + forward[i];
                pivots.inverse[start + i] = start + inverse[i];
            }
            let mut row = vec![0.0; n];
            for i in 0..node.below {
                (0..n).for_each(|j| row[j] = below[(i, forward[j])]);
                (0..n).for_each(|j| below[(i, j)] = row[j]);
            }
            solve_below(node, triangle.as_ref(), below.rb_mut(), self.par, |l, x| {
                solve_unit_lower_triangular_in_place(l, x, SEQ);
            })?;
        }
        let blocks = node.blocks(&self.values, &pivots.subdiagonal).collect::<Vec<_>>();
        let (_, mut below) = node.parts(&mut self.values[node.range()]);
        for (i, block) in blocks {
            block.divide_columns(below.rb_mut(), i);
        }
        Ok(())
    }
}

/// Replaces a pivot by its root, if it is positive.
fn root(pivot: &mut f64) -> std::result::Result<(), usize> {
    if pivot.is_nan() || *pivot <= 0.0 {
        return Err(0);
    }
    *pivot = pivot.sqrt();
    Ok(())
}

/// Changes the length of a list, or returns an error when memory is refused.
pub(super) fn resize(list: &mut Vec<f64>, len: usize) -> Result<()> {
    room(list, len.saturating_sub(list.len()))?;
    list.resize(len, 0.0);
    Ok(())
}

/// Solves for the rows below the triangle L of a supernode, in pieces that do not depend on the
/// number of threads.
fn solve_below(
    node: Supernode,
    l: MatRef<'_, f64>,
    below: MatMut<'_, f64>,
    par: Par,
    solve: impl Fn(MatRef<'_, f64>, MatMut<'_, f64>) + Sync,
) -> Result<()> {
    let (n, height) = (node.columns, below.nrows());
    let piece = (PIECE / (n * n)).max(1);
    if height <= piece {
        if height > 0 {
            solve(l, below.transpose_mut());
        }
        return spend((height * n * n) as f64);
    }
    let (mut pieces, mut rest) = (Vec::new(), below);
    while rest.nrows() > 0 {
        let height = piece.min(rest.nrows());
        let (head, tail) = rest.split_at_row_mut(height);
        pieces.push(head);
        rest = tail;
    }
    par.for_each_asking(pieces.into_iter(), (piece * n * n) as f64, |_, rows| {
        solve(l, rows.transpose_mut());
    })
}
