//! What one level of a scheme needs beside its products: scratch for the sums, and their traffic.

use std::collections::HashMap;

use super::problem::Op;
use super::recursion::Recursion;
use crate::base::steps::step;
use crate::product::schemes::{ProductKind, Scheme, SchemeProduct, Term};

/// Returns the leading dimension of a scratch matrix: page-sized distances collide in the cache.
pub(crate) fn leading(len: usize) -> usize {
    if len >= 256 && len.is_multiple_of(64) { len + 16 } else { len }
}

/// The shape of a scratch matrix; zero by zero when a level does not need it.
#[derive(Debug, Clone, Copy, Default)]
pub(crate) struct Extent {
    pub rows: usize,
    pub cols: usize,
}

impl Extent {
    /// Returns the number of elements, enough for storage by rows and by columns.
    pub fn len(self) -> usize {
        (self.rows * leading(self.cols)).max(leading(self.rows) * self.cols)
    }
}

/// What one level needs beside what its products need.
pub(crate) struct LevelScratch {
    pub p: Extent,
    pub q: Extent,
    pub m: Extent,
}

impl LevelScratch {
    /// Returns what one level of `scheme` needs for A m x n and B m x k.
    pub fn of(scheme: &Scheme, op: Op, m: usize, n: usize, k: usize) -> Self {
        let rows = m.div_ceil(scheme.inner);
        let (left, right) = (n.div_ceil(scheme.left), k.div_ceil(scheme.right));
        let needs =
            |used: bool, rows, cols| if used { Extent { rows, cols } } else { Extent::default() };
        let products = || scheme.products.iter();
        let widened =
            |p: &SchemeProduct| p.kind == ProductKind::Gemmt && !n.is_multiple_of(scheme.left);
        let square = |p: &SchemeProduct| op.of_product(p.kind) == Op::Syrk;
        Self {
            p: needs(products().any(|p| p.left.len() > 1 || widened(p)), rows, left),
            q: needs(
                products().any(|p| p.right.len() > 1 && !square(p) || widened(p)),
                rows,
                right,
            ),
            m: needs(
                products().any(|p| p.outputs.len() > 1 || p.kind == ProductKind::SyrkFull),
                left,
                right,
            ),
        }
    }

    fn len(&self) -> usize {
        self.p.len() + self.q.len() + self.m.len()
    }
}

/// Returns the elements of scratch that a recursion needs for A m x n and B m x k.
pub(crate) fn scratch_len(recursion: &Recursion, op: Op, m: usize, n: usize, k: usize) -> usize {
    /// Operation, m, n, k, fast levels left.
    type Key = (Op, [usize; 3], usize);
    fn visit(recursion: &Recursion, key: Key, known: &mut HashMap<Key, usize>) -> usize {
        let (op, [m, n, k], levels) = key;
        let Some(id) = recursion.choose(op.symmetric(), m, n, k, levels) else { return 0 };
        if let Some(&len) = known.get(&key) {
            return len;
        }
        step();
        let scheme = id.scheme();
        let levels = levels - usize::from(scheme.is_fast());
        let own = LevelScratch::of(scheme, op, m, n, k).len();
        let mut below = 0;
        // Blocks come in at most two lengths along each extent.
        let both = |len: usize, parts: usize| [len / parts, len.div_ceil(parts)];
        for product in &scheme.products {
            let child = op.of_product(product.kind);
            for m in both(m, scheme.inner) {
                for n in both(n, scheme.left) {
                    for k in both(k, scheme.right) {
                        if !child.symmetric() || n == k {
                            let key = (child, [m, n, k], levels);
                            below = below.max(visit(recursion, key, known));
                        }
                    }
                }
            }
        }
        known.insert(key, own + below);
        own + below
    }
    visit(recursion, (op, [m, n, k], recursion.fast_levels), &mut HashMap::new())
}

/// What the sums of one level move: transfers of a block of A's, of B's and of C's size, counting
/// reads, writes, and the read that a write to uncached memory implies.
pub(crate) struct Traffic {
    pub(crate) p: f64,
    pub(crate) q: f64,
    pub(crate) m: f64,
}

impl Traffic {
    pub(crate) fn of(scheme: &Scheme, op: Op) -> Self {
        let sums = |sum_of: fn(&SchemeProduct) -> &[Term], skip_squares: bool| {
            let mut held: &[Term] = &[];
            let mut moved = 0;
            for product in &scheme.products {
                let terms = sum_of(product);
                if terms.len() > 1 && !(skip_squares && op.of_product(product.kind) == Op::Syrk) {
                    let (_, change) = cheapest_update(held, terms);
                    moved += change.len() + 2;
                    held = terms;
                }
            }
            moved as f64
        };
        let outputs = scheme.products.iter().map(|p| p.outputs.len()).filter(|&n| n > 1);
        Self {
            p: sums(|p| &p.left, false),
            q: sums(|p| &p.right, true),
            m: outputs.map(|n| 1.0 + 2.0 * n as f64).sum(),
        }
    }
}

/// Returns how to compute the sum `wanted` from the sum `held`: `wanted = reuse * held + change`,
/// with reuse 0, 1 or -1, whichever reads least.
pub(crate) fn cheapest_update(held: &[Term], wanted: &[Term]) -> (i8, Vec<Term>) {
    let mut best = (0, wanted.to_vec());
    if held.is_empty() {
        return best;
    }
    for reuse in [1, -1] {
        let mut change: Vec<Term> = wanted.to_vec();
        for &h in held {
            match change.iter_mut().find(|t| (t.row, t.col) == (h.row, h.col)) {
                Some(t) => t.coefficient -= reuse * h.coefficient,
                None => change.push(Term { coefficient: -reuse * h.coefficient, ..h }),
            }
        }
        change.retain(|t| t.coefficient != 0);
        // Updating in place reads the held sum too.
        if change.len() + 1 < best.1.len() + usize::from(best.0 != 0) {
            best = (reuse, change);
        }
    }
    best
}
