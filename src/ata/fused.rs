//! A recursion flattened into products of signed sums of blocks, as data: what the native kernels run
//! without scratch matrices. The sums are made while packing, the additions to C while writing.

use std::ops::Range;

use super::plan::Recursion;
use super::recurse::{Op, block_start};
use super::scheme::{Product, Scheme, Term};
use crate::kernel::packed::{Rates, Shape};

/// A signed block of A, B or C.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(crate) struct Block {
    pub coefficient: i32,
    pub rows: Range<usize>,
    pub cols: Range<usize>,
    /// Of C: the first product to arrive here, which brings beta with it.
    pub first: bool,
}

/// `outputs += (sum left)^T (sum right)`.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(crate) struct FusedProduct {
    pub left: Vec<Block>,
    /// Empty when it is the same as the left side.
    pub right: Vec<Block>,
    pub outputs: Vec<Block>,
    pub shape: Shape,
}

impl FusedProduct {
    /// Products of scalars: the entries that somebody wants, times the depth.
    pub fn work(&self, symmetric: bool) -> f64 {
        let Shape { depth, rows, cols, .. } = self.shape;
        let triangle = symmetric && self.outputs.iter().all(|o| o.rows.start == o.cols.start);
        let entries = if triangle { rows * (rows + 1) / 2 } else { rows * cols };
        entries as f64 * depth as f64
    }

    /// Seconds on one core, in `chunks` chunks of rows.
    pub fn seconds(&self, rates: &Rates, scalar_bytes: f64, chunks: usize, symmetric: bool) -> f64 {
        /// Share of the time for additions to C that products do not hide.
        const SEEN: f64 = 0.5;
        let Shape { depth, rows, cols, same } = self.shape;
        let work = self.work(symmetric);
        let area = |b: &Block| b.rows.len() as f64 * b.cols.len() as f64;
        let read: f64 = self.left.iter().chain(&self.right).map(area).sum();
        let packed = (rows + if same { 0 } else { cols }) as f64 * depth as f64;
        let entries = work / depth.max(1) as f64;
        let updated = 2.0 * (self.outputs.len() * chunks) as f64 * entries;
        // The rate of products is that of f64.
        scalar_bytes
            * (work / 4.0 / rates.flops
                + read / rates.read_bytes
                + packed / rates.pack_bytes
                + SEEN * updated / rates.update_bytes)
    }
}

/// The products of `op` with A m x n and B m x k, in order.
pub(crate) fn products(
    recursion: &Recursion,
    op: Op,
    m: usize,
    n: usize,
    k: usize,
) -> Vec<FusedProduct> {
    let whole = |rows, cols| Block { coefficient: 1, rows: 0..rows, cols: 0..cols, first: true };
    let root = Node {
        op,
        left: vec![whole(m, n)],
        right: vec![whole(m, k)],
        outputs: vec![whole(n, k)],
        fast_levels: recursion.fast_levels,
    };
    let mut found = Vec::new();
    root.flatten(recursion, op.symmetric(), &mut found);
    found
}

/// A product before it is taken apart.
struct Node {
    op: Op,
    left: Vec<Block>,
    right: Vec<Block>,
    outputs: Vec<Block>,
    fast_levels: usize,
}

impl Node {
    /// Extents: what a block lacks counts as zero.
    fn shape(&self) -> Shape {
        let longest = |blocks: &[Block], of: fn(&Block) -> &Range<usize>| {
            blocks.iter().map(|b| of(b).len()).max().unwrap_or(0)
        };
        let depth = longest(&self.left, |b| &b.rows).max(longest(&self.right, |b| &b.rows));
        // Every entry of an output needs one of the product, be it zero: beta comes with it.
        let rows = longest(&self.left, |b| &b.cols).max(longest(&self.outputs, |b| &b.rows));
        let cols = longest(&self.right, |b| &b.cols).max(longest(&self.outputs, |b| &b.cols));
        let (rows, cols) =
            if self.op.symmetric() { (rows.max(cols), rows.max(cols)) } else { (rows, cols) };
        Shape { depth, rows, cols, same: self.op == Op::Syrk }
    }

    fn flatten(mut self, recursion: &Recursion, symmetric: bool, found: &mut Vec<FusedProduct>) {
        if symmetric {
            // Nobody wants what lies above the diagonal.
            self.outputs.retain(|o| o.rows.end > o.cols.start);
        }
        if self.outputs.is_empty() {
            return;
        }
        let shape = self.shape();
        let Shape { depth, rows, cols, same } = shape;
        match recursion.choose(self.op.symmetric(), depth, rows, cols, self.fast_levels) {
            Some(id) => {
                let scheme = id.scheme();
                let mut touched = vec![false; self.outputs.len() * scheme.left * scheme.right];
                for product in &scheme.products {
                    self.child(scheme, product, shape, &mut touched)
                        .flatten(recursion, symmetric, found);
                }
            }
            None => {
                let Self { left, right, outputs, .. } = self;
                found.push(FusedProduct {
                    left,
                    right: if same { vec![] } else { right },
                    outputs,
                    shape,
                });
            }
        }
    }

    fn child(
        &self,
        scheme: &Scheme,
        product: &Product,
        shape: Shape,
        touched: &mut [bool],
    ) -> Self {
        let Shape { depth, rows, cols, .. } = shape;
        let of = |blocks: &[Block], terms: &[Term], extents, parts| {
            let mut sum = Vec::with_capacity(blocks.len() * terms.len());
            for block in blocks {
                sum.extend(terms.iter().map(|&t| sub_block(block, t, extents, parts)));
            }
            sum.retain(|b| !b.rows.is_empty() && !b.cols.is_empty());
            sum
        };
        let mut outputs = Vec::with_capacity(self.outputs.len() * product.outputs.len());
        for (o, output) in self.outputs.iter().enumerate() {
            for &t in &product.outputs {
                let mut block = sub_block(output, t, (rows, cols), (scheme.left, scheme.right));
                let i = (o * scheme.left + t.row) * scheme.right + t.col;
                block.first = output.first && !std::mem::replace(&mut touched[i], true);
                outputs.push(block);
            }
        }
        outputs.retain(|b| !b.rows.is_empty() && !b.cols.is_empty());
        Self {
            op: self.op.of_product(product.kind),
            left: of(&self.left, &product.left, (depth, rows), (scheme.inner, scheme.left)),
            right: of(&self.right, &product.right, (depth, cols), (scheme.inner, scheme.right)),
            outputs,
            fast_levels: self.fast_levels - usize::from(scheme.is_fast()),
        }
    }
}

/// The part of `block` that belongs to `term`, where blocks of these extents are cut into parts.
fn sub_block(block: &Block, term: Term, extents: (usize, usize), parts: (usize, usize)) -> Block {
    let cut = |range: &Range<usize>, extent, parts, i| {
        let at = |i| (range.start + block_start(extent, parts, i)).min(range.end);
        at(i)..at(i + 1)
    };
    Block {
        coefficient: block.coefficient * i32::from(term.coefficient),
        rows: cut(&block.rows, extents.0, parts.0, term.row),
        cols: cut(&block.cols, extents.1, parts.1, term.col),
        first: block.first,
    }
}
