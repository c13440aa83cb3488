//! The engine: runs any [`Scheme`] level by level, in scratch allocated once.
//!
//! Each level needs three matrices, named as in the thesis: P for a sum of blocks of A, Q for a
//! sum of blocks of B, M for a product that goes into several blocks of C. A sum of one block is
//! that block itself; a product with one destination goes straight there.

use std::ops::ControlFlow;

use faer::prelude::{IntoConst, Reborrow, ReborrowMut};
use faer::{MatMut, MatRef};

use crate::base::{Arena, Real, Tracker, even_part};
use crate::blas::Kernels;
use crate::product::combine::{
    accumulate, accumulate_lower_lines, combine, mirror_lower, scale, scale_lower,
};
use crate::product::plan::{Extent, LevelScratch, Op, Recursion, cheapest_update, leading};
use crate::product::schemes::{ProductKind, Scheme, SchemeProduct, Term};

/// Runs a [`Recursion`] over one back end.
pub(crate) struct Engine<'a, T> {
    pub(crate) kernels: &'a dyn Kernels<T>,
    pub(crate) recursion: &'a Recursion,
    pub(crate) tracker: &'a Tracker<'a>,
}

/// `C := alpha op(A, B) + beta C`: A is m x n, B is m x k, C is n x k (k = n if symmetric, and then
/// only the lower triangle of C is touched). For [`Op::Syrk`] B must be A.
pub(crate) struct Node<'a, T> {
    pub(crate) op: Op,
    pub(crate) alpha: T,
    pub(crate) a: MatRef<'a, T>,
    pub(crate) b: MatRef<'a, T>,
    pub(crate) beta: T,
    pub(crate) c: MatMut<'a, T>,
}

impl<T: Real> Node<'_, T> {
    /// Computes `C := beta C`.
    fn scale(&mut self) {
        if self.op.symmetric() {
            scale_lower(self.c.rb_mut(), self.beta);
        } else {
            scale(self.c.rb_mut(), self.beta);
        }
    }

    /// Cuts A and B to the columns that C has room for, and C to their product.
    fn fitted(mut self) -> Self {
        let rows = self.a.ncols().min(self.c.nrows());
        let cols = self.b.ncols().min(self.c.ncols());
        if rows < self.c.nrows() || cols < self.c.ncols() {
            // The rest of C is still scaled by beta.
            self.scale();
            self.beta = T::ONE;
        }
        Self {
            a: self.a.subcols(0, rows),
            b: self.b.subcols(0, cols),
            c: self.c.submatrix_mut(0, 0, rows, cols),
            ..self
        }
    }
}

impl<T: Real> Engine<'_, T> {
    /// Computes a node, and adds `work` to what the tracker knows as done, part by part. On a
    /// request to stop C is left unfinished.
    pub(crate) fn run(&self, node: Node<'_, T>, work: f64, scratch: &mut [T]) -> ControlFlow<()> {
        self.compute(node, Some(work), Arena::new(scratch), self.recursion.fast_levels)
    }

    /// Computes a node as a part of a larger one; without `work`, it does not ask the callback.
    fn compute(
        &self,
        mut node: Node<'_, T>,
        work: Option<f64>,
        arena: Arena<'_, T>,
        fast_levels: usize,
    ) -> ControlFlow<()> {
        /// Operations between two requests, at least.
        const PIECE: f64 = 1e7;
        let (m, n, k) = (node.a.nrows(), node.a.ncols(), node.b.ncols());
        if let Some(work) = work
            && 2.0 * m as f64 * n as f64 * k as f64 <= PIECE
        {
            self.compute(node, None, arena, fast_levels)?;
            return self.tracker.add(work);
        }
        if n == 0 || k == 0 {
            return ControlFlow::Continue(());
        }
        if m == 0 {
            node.scale();
            return ControlFlow::Continue(());
        }
        if let Some(id) = self.recursion.choose(node.op.symmetric(), m, n, k, fast_levels) {
            return self.level(id.scheme(), node, work, arena, fast_levels);
        }
        let Node { op, alpha, a, b, beta, c } = node;
        if let Some(work) = work {
            let b = (op != Op::Syrk).then_some(b);
            return self.tracker.part(work, |progress| {
                self.kernels.compute(op != Op::Gemm, alpha, a, b, beta, c, progress)
            });
        }
        match op {
            Op::Syrk => self.kernels.syrk(alpha, a, beta, c),
            Op::Gemmt => self.kernels.gemmt(alpha, a, b, beta, c),
            Op::Gemm => self.kernels.gemm(alpha, a, b, beta, c),
        }
        ControlFlow::Continue(())
    }

    /// Computes one level of `scheme`.
    fn level(
        &self,
        scheme: &Scheme,
        node: Node<'_, T>,
        work: Option<f64>,
        mut arena: Arena<'_, T>,
        fast_levels: usize,
    ) -> ControlFlow<()> {
        let Node { op, alpha, a, b, beta, mut c } = node;
        let fast_levels = fast_levels - usize::from(scheme.is_fast());
        let need = LevelScratch::of(scheme, op, a.nrows(), a.ncols(), b.ncols());
        let mut factors = Factors {
            left_blocks: Grid { view: a, rows: scheme.inner, cols: scheme.left },
            right_blocks: Grid { view: b, rows: scheme.inner, cols: scheme.right },
            p: SumBuffer::new(need.p, a, arena.take(need.p.len())),
            q: SumBuffer::new(need.q, b, arena.take(need.q.len())),
        };
        let product_memory = arena.take(need.m.len());
        // Whether a block of C has received its first product, which brings beta with it.
        let mut touched = vec![false; scheme.left * scheme.right];
        let mut beta_for = |t: Term| {
            let first = !std::mem::replace(&mut touched[t.row * scheme.right + t.col], true);
            if first { beta } else { T::ONE }
        };

        let weight = |product: &SchemeProduct| match op.of_product(product.kind) {
            Op::Gemm => 1.0,
            Op::Syrk | Op::Gemmt => 0.5,
        };
        let weights: f64 = scheme.products.iter().map(weight).sum();
        for product in &scheme.products {
            let work = work.map(|work| work * weight(product) / weights);
            let op_of_product = op.of_product(product.kind);
            let (sign, left, right) = factors.of(product, op_of_product == Op::Syrk);

            if let &[out] = &product.outputs[..]
                && product.kind != ProductKind::SyrkFull
            {
                let child = Node {
                    op: op_of_product,
                    alpha: alpha * sign * small(out.coefficient),
                    a: left,
                    b: right,
                    beta: beta_for(out),
                    c: block_mut(c.rb_mut(), scheme, out),
                };
                self.compute(child.fitted(), work, arena.nested(), fast_levels)?;
                continue;
            }

            let mut product_matrix =
                scratch_matrix(&mut *product_memory, left.ncols(), right.ncols(), need.m, c.rb());
            let child = Node {
                op: op_of_product,
                alpha: alpha * sign,
                a: left,
                b: right,
                beta: T::ZERO,
                c: product_matrix.rb_mut(),
            };
            self.compute(child, work, arena.nested(), fast_levels)?;
            if product.kind == ProductKind::SyrkFull && op_of_product == Op::Syrk {
                mirror_lower(product_matrix.rb_mut());
            }
            let outputs: Vec<_> = product.outputs.iter().map(|&out| (out, beta_for(out))).collect();
            distribute(c.rb_mut(), scheme, op, &outputs, product_matrix.rb());
        }
        ControlFlow::Continue(())
    }
}

/// Adds `product` to every block of C in `outputs`, after scaling the block by its beta: a strip of
/// `product` goes to all of them while it stays in the cache.
fn distribute<T: Real>(
    mut c: MatMut<'_, T>,
    scheme: &Scheme,
    op: Op,
    outputs: &[(Term, T)],
    product: MatRef<'_, T>,
) {
    /// Elements of a strip: half of a second-level cache of 1 MiB.
    const STRIP: usize = 1 << 16;
    let by_rows = c.col_stride() == 1;
    // Blocks may be larger than the product; the rest is scaled by beta.
    let (rows, cols) = (c.nrows().div_ceil(scheme.left), c.ncols().div_ceil(scheme.right));
    let (lines, len) = if by_rows { (rows, cols) } else { (cols, rows) };
    let step = (STRIP / len.max(1)).max(1);
    for start in (0..lines).step_by(step) {
        for &(out, beta) in outputs {
            let dst = block_mut(c.rb_mut(), scheme, out);
            let coefficient = small(out.coefficient);
            let end = (start + step).min(if by_rows { dst.nrows() } else { dst.ncols() });
            let strip = start.min(end)..end;
            if op.symmetric() && out.row == out.col {
                accumulate_lower_lines(dst, strip, beta, coefficient, product);
            } else if by_rows {
                let from = strip.start.min(product.nrows())..strip.end.min(product.nrows());
                let src = product.subrows(from.start, from.len());
                accumulate(dst.subrows_mut(strip.start, strip.len()), beta, coefficient, src);
            } else {
                let from = strip.start.min(product.ncols())..strip.end.min(product.ncols());
                let src = product.subcols(from.start, from.len());
                accumulate(dst.subcols_mut(strip.start, strip.len()), beta, coefficient, src);
            }
        }
    }
}

fn small<T: Real>(coefficient: i8) -> T {
    T::from_f64(f64::from(coefficient))
}

fn block_mut<'a, T>(c: MatMut<'a, T>, scheme: &Scheme, out: Term) -> MatMut<'a, T> {
    let rows = even_part(0..c.nrows(), scheme.left, out.row);
    let cols = even_part(0..c.ncols(), scheme.right, out.col);
    c.submatrix_mut(rows.start, cols.start, rows.len(), cols.len())
}

/// A view cut into blocks.
#[derive(Clone, Copy)]
struct Grid<'a, T> {
    view: MatRef<'a, T>,
    rows: usize,
    cols: usize,
}

impl<'a, T> Grid<'a, T> {
    /// Returns the columns of a sum of `terms`: those of its block, or of the widest block there
    /// is.
    fn width(&self, terms: &[Term]) -> usize {
        match terms {
            &[term] => self.block(term).ncols(),
            _ => self.view.ncols().div_ceil(self.cols),
        }
    }

    fn block(&self, term: Term) -> MatRef<'a, T> {
        let rows = even_part(0..self.view.nrows(), self.rows, term.row);
        let cols = even_part(0..self.view.ncols(), self.cols, term.col);
        self.view.submatrix(rows.start, cols.start, rows.len(), cols.len())
    }
}

/// Computes the factors of the products of a scheme.
struct Factors<'a, T> {
    left_blocks: Grid<'a, T>,
    right_blocks: Grid<'a, T>,
    p: SumBuffer<'a, T>,
    q: SumBuffer<'a, T>,
}

impl<T: Real> Factors<'_, T> {
    /// Returns the sign of `product` and its factors, which are equal if `same`.
    fn of(&mut self, product: &SchemeProduct, same: bool) -> (T, MatRef<'_, T>, MatRef<'_, T>) {
        // A product of which half is computed must be square.
        let widen = product.kind == ProductKind::Gemmt
            && self.left_blocks.width(&product.left) != self.right_blocks.width(&product.right);
        let (left_sign, left) = self.p.sum(&product.left, self.left_blocks, widen);
        let (right_sign, right) = if same {
            (left_sign, left)
        } else {
            self.q.sum(&product.right, self.right_blocks, widen)
        };
        // Rows that only one of the two has are multiplied by zeros in the other.
        let m = left.nrows().min(right.nrows());
        (left_sign * right_sign, left.subrows(0, m), right.subrows(0, m))
    }
}

/// P or Q: holds the last sum that had more than one term, and computes the next one from it when
/// that takes fewer terms.
struct SumBuffer<'a, T> {
    extent: Extent,
    memory: &'a mut [T],
    row_major: bool,
    held: Vec<Term>,
}

impl<'a, T: Real> SumBuffer<'a, T> {
    /// Creates a buffer that is stored in the order of `like`.
    fn new(extent: Extent, like: MatRef<'_, T>, memory: &'a mut [T]) -> Self {
        Self { extent, memory, row_major: like.col_stride() == 1, held: Vec::new() }
    }

    /// Returns the sum of `terms` over `grid`, up to the returned sign. A sum of one block is that
    /// block, unless it must be widened to the full extent with zeros.
    fn sum<'s>(&'s mut self, terms: &[Term], grid: Grid<'s, T>, widen: bool) -> (T, MatRef<'s, T>) {
        if let &[term] = terms
            && term.coefficient.abs() == 1
            && !widen
        {
            return (small(term.coefficient), grid.block(term));
        }
        let (reuse, change) = cheapest_update(&self.held, terms);
        let blocks: Vec<_> =
            change.iter().map(|&t| (small(t.coefficient), grid.block(t))).collect();
        let Extent { rows, cols } = self.extent;
        let mut sum = matrix(self.memory, rows, cols, self.extent, self.row_major);
        if reuse != 1 || !blocks.is_empty() {
            combine(sum.rb_mut(), small(reuse), &blocks);
        }
        self.held.clear();
        self.held.extend_from_slice(terms);
        (T::ONE, sum.into_const())
    }
}

/// Returns a rows x cols matrix at the start of `memory`, stored in the order of `like`.
fn scratch_matrix<'a, T>(
    memory: &'a mut [T],
    rows: usize,
    cols: usize,
    extent: Extent,
    like: MatRef<'_, T>,
) -> MatMut<'a, T> {
    matrix(memory, rows, cols, extent, like.col_stride() == 1)
}

fn matrix<T>(
    memory: &mut [T],
    rows: usize,
    cols: usize,
    extent: Extent,
    row_major: bool,
) -> MatMut<'_, T> {
    if row_major {
        // Not `from_row_major_slice_with_stride_mut`, which swaps the strides (faer 0.24.4).
        let stride = leading(extent.cols);
        MatMut::from_column_major_slice_with_stride_mut(memory, cols, rows, stride).transpose_mut()
    } else {
        MatMut::from_column_major_slice_with_stride_mut(memory, rows, cols, leading(extent.rows))
    }
}

#[cfg(test)]
mod tests {
    use faer::{Mat, MatRef};

    use super::*;
    use crate::base::{Progress, Rng};
    use crate::blas::{self, BlasReal};
    use crate::product::plan::{Base, scratch_len};
    use crate::product::schemes::SchemeId;

    fn integers(m: usize, n: usize, seed: u64) -> Mat<f64> {
        let mut rng = Rng::new(seed);
        Mat::from_fn(m, n, |_, _| (rng.uniform() * 9.0).floor() - 4.0)
    }

    /// Runs `op` by one table alone, with NaN in all scratch and in the triangle that is not
    /// computed.
    fn check(id: SchemeId, op: Op, a: MatRef<'_, f64>, b: MatRef<'_, f64>) {
        let (m, n, k) = (a.nrows(), a.ncols(), b.ncols());
        let recursion = Recursion {
            symmetric: if op.symmetric() { vec![id] } else { vec![] },
            general: if op.symmetric() { vec![] } else { vec![id] },
            base: Base { general: 1, symmetric: 1 },
            fast_levels: 2,
        };
        let backend = blas::native();
        let tracker = Tracker::new(Progress::none(), 1.0);
        let kernels = f64::kernels(backend.as_ref());
        let engine = Engine { kernels, recursion: &recursion, tracker: &tracker };
        let mut scratch = vec![f64::NAN; scratch_len(&recursion, op, m, n, k)];
        let wanted = |i, j| !op.symmetric() || i >= j;
        let start = |i: usize, j: usize| (i * 3 + j) as f64;
        let mut c = Mat::from_fn(n, k, |i, j| if wanted(i, j) { start(i, j) } else { f64::NAN });
        let node = Node { op, alpha: 2.0, a, b, beta: -1.0, c: c.as_mut() };
        assert!(engine.run(node, 1.0, &mut scratch).is_continue());
        for j in 0..k {
            for i in 0..n {
                let sum: f64 = (0..m).map(|r| a[(r, i)] * b[(r, j)]).sum();
                let what = format!("{id} {op:?} {m} x {n}, {k} at ({i}, {j})");
                if wanted(i, j) {
                    assert_eq!(c[(i, j)], 2.0 * sum - start(i, j), "{what}");
                } else {
                    assert!(c[(i, j)].is_nan(), "{what}");
                }
            }
        }
    }

    #[test]
    fn every_table_is_exact_on_integer_blocks_with_poison_around() {
        for id in SchemeId::ALL {
            for (m, n, k) in [(20, 12, 28), (21, 13, 29), (7, 30, 11), (5, 5, 5), (64, 17, 3)] {
                let (a, b, square) = (integers(m, n, 1), integers(m, k, 2), integers(m, n, 3));
                if id.scheme().symmetric {
                    check(id, Op::Syrk, a.as_ref(), a.as_ref());
                    check(id, Op::Gemmt, a.as_ref(), square.as_ref());
                } else {
                    check(id, Op::Gemm, a.as_ref(), b.as_ref());
                }
            }
        }
    }
}
