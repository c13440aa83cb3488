//! A recursion flattened into products of signed sums of blocks, as data: what the native kernels
//! run without scratch matrices. The sums are made while packing, the additions to C while writing.

use std::collections::HashMap;
use std::ops::Range;

use super::problem::Op;
use super::recursion::Recursion;
use crate::base::steps::step;
use crate::base::{even_start, triangle_len};
use crate::kernel::packed::Shape;
use crate::product::schemes::{Scheme, SchemeProduct, Term};

/// A signed block of A, B or C.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(crate) struct SignedBlock {
    pub coefficient: i32,
    pub rows: Range<usize>,
    pub cols: Range<usize>,
    /// For a block of C: whether this product is the first to be added there, which applies beta.
    pub first: bool,
}

/// `outputs += (sum left)^T (sum right)`.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(crate) struct FusedProduct {
    pub left: Vec<SignedBlock>,
    /// The right side; empty when it is the same as the left side.
    pub right: Vec<SignedBlock>,
    pub outputs: Vec<SignedBlock>,
    pub shape: Shape,
}

impl FusedProduct {
    /// Returns the number of products of scalars: the wanted entries times the depth.
    pub fn work(&self, symmetric: bool) -> f64 {
        let Shape { depth, rows, cols, .. } = self.shape;
        let triangle = symmetric && self.outputs.iter().all(|o| o.rows.start == o.cols.start);
        let entries = if triangle { triangle_len(rows) } else { rows * cols };
        entries as f64 * depth as f64
    }
}

/// Returns the products of `op` with A m x n and B m x k, in order.
pub(crate) fn products(
    recursion: &Recursion,
    op: Op,
    m: usize,
    n: usize,
    k: usize,
) -> Vec<FusedProduct> {
    let mut found = Vec::new();
    Node::root(recursion, op, [m, n, k]).flatten(recursion, op.symmetric(), &mut found);
    found
}

/// Returns the sum of `price` over [`products`], in steps that grow with the number of levels only:
/// `price` depends on the extents of the blocks, and on which of them are on the diagonal.
pub(crate) fn total(
    recursion: &Recursion,
    op: Op,
    [m, n, k]: [usize; 3],
    price: impl Fn(&FusedProduct) -> f64,
) -> f64 {
    let root = Node::root(recursion, op, [m, n, k]);
    root.total(recursion, op.symmetric(), &price, &mut HashMap::new())
}

/// What the prices of the products of a node depend on.
#[derive(PartialEq, Eq, Hash)]
struct Key {
    op: Op,
    fast_levels: usize,
    /// Blocks of the left and of the right side.
    sides: [usize; 2],
    /// Extents of the blocks, and how far those of C begin below the diagonal, if they are not all
    /// below it.
    extents: Vec<(usize, usize, usize)>,
}

/// A product that is still to be divided.
struct Node {
    op: Op,
    left: Vec<SignedBlock>,
    right: Vec<SignedBlock>,
    outputs: Vec<SignedBlock>,
    fast_levels: usize,
}

/// What a node is divided into.
enum Divided {
    /// None of its entries is wanted.
    Nothing,
    SchemeProduct(FusedProduct),
    Nodes(Vec<Node>),
}

impl Node {
    /// Returns the extents; rows and columns that a block lacks count as zero.
    fn shape(&self) -> Shape {
        let longest = |blocks: &[SignedBlock], of: fn(&SignedBlock) -> &Range<usize>| {
            blocks.iter().map(|b| of(b).len()).max().unwrap_or(0)
        };
        let depth = longest(&self.left, |b| &b.rows).max(longest(&self.right, |b| &b.rows));
        // Every entry of an output needs one of the product, even a zero, because that applies
        // beta.
        let rows = longest(&self.left, |b| &b.cols).max(longest(&self.outputs, |b| &b.rows));
        let cols = longest(&self.right, |b| &b.cols).max(longest(&self.outputs, |b| &b.cols));
        let (rows, cols) =
            if self.op.symmetric() { (rows.max(cols), rows.max(cols)) } else { (rows, cols) };
        Shape { depth, rows, cols, same: self.op == Op::Syrk }
    }

    fn root(recursion: &Recursion, op: Op, [m, n, k]: [usize; 3]) -> Self {
        let whole = |rows, cols| {
            vec![SignedBlock { coefficient: 1, rows: 0..rows, cols: 0..cols, first: true }]
        };
        let fast_levels = recursion.fast_levels;
        Self { op, left: whole(m, n), right: whole(m, k), outputs: whole(n, k), fast_levels }
    }

    fn key(&self) -> Key {
        let side = |b: &SignedBlock| (b.rows.len(), b.cols.len(), 0);
        let output = |o: &SignedBlock| {
            let is_below = o.rows.start >= o.cols.end;
            let below = o.rows.start.wrapping_sub(o.cols.start);
            (o.rows.len(), o.cols.len(), if is_below { usize::MAX } else { below })
        };
        let of_sides = self.left.iter().chain(&self.right).map(side);
        let extents = of_sides.chain(self.outputs.iter().map(output)).collect();
        let sides = [self.left.len(), self.right.len()];
        Key { op: self.op, fast_levels: self.fast_levels, sides, extents }
    }

    fn flatten(self, recursion: &Recursion, symmetric: bool, found: &mut Vec<FusedProduct>) {
        match self.divided(recursion, symmetric) {
            Divided::Nothing => {}
            Divided::SchemeProduct(product) => found.push(product),
            Divided::Nodes(nodes) => {
                nodes.into_iter().for_each(|node| node.flatten(recursion, symmetric, found));
            }
        }
    }

    fn total(
        self,
        recursion: &Recursion,
        symmetric: bool,
        price: &impl Fn(&FusedProduct) -> f64,
        known: &mut HashMap<Key, f64>,
    ) -> f64 {
        let key = self.key();
        if let Some(&known) = known.get(&key) {
            return known;
        }
        let total = match self.divided(recursion, symmetric) {
            Divided::Nothing => 0.0,
            Divided::SchemeProduct(product) => price(&product),
            Divided::Nodes(nodes) => {
                nodes.into_iter().map(|node| node.total(recursion, symmetric, price, known)).sum()
            }
        };
        known.insert(key, total);
        total
    }

    /// Divides the node once.
    fn divided(mut self, recursion: &Recursion, symmetric: bool) -> Divided {
        step();
        if symmetric {
            // Entries above the diagonal are not needed.
            self.outputs.retain(|o| o.rows.end > o.cols.start);
        }
        if self.outputs.is_empty() {
            return Divided::Nothing;
        }
        let shape = self.shape();
        let Shape { depth, rows, cols, same } = shape;
        let Some(id) = recursion.choose(self.op.symmetric(), depth, rows, cols, self.fast_levels)
        else {
            let Self { left, right, outputs, .. } = self;
            let right = if same { vec![] } else { right };
            return Divided::SchemeProduct(FusedProduct { left, right, outputs, shape });
        };
        let scheme = id.scheme();
        let mut touched = vec![false; self.outputs.len() * scheme.left * scheme.right];
        let nodes = scheme.products.iter().map(|p| self.child(scheme, p, shape, &mut touched));
        Divided::Nodes(nodes.collect())
    }

    fn child(
        &self,
        scheme: &Scheme,
        product: &SchemeProduct,
        shape: Shape,
        touched: &mut [bool],
    ) -> Self {
        let Shape { depth, rows, cols, .. } = shape;
        let of = |blocks: &[SignedBlock], terms: &[Term], extents, parts| {
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

/// Returns the part of `block` for `term`, where blocks of these extents are cut into parts.
fn sub_block(
    block: &SignedBlock,
    term: Term,
    extents: (usize, usize),
    parts: (usize, usize),
) -> SignedBlock {
    let cut = |range: &Range<usize>, extent, parts, i| {
        let at = |i| (range.start + even_start(extent, parts, i)).min(range.end);
        at(i)..at(i + 1)
    };
    SignedBlock {
        coefficient: block.coefficient * i32::from(term.coefficient),
        rows: cut(&block.rows, extents.0, parts.0, term.row),
        cols: cut(&block.cols, extents.1, parts.1, term.col),
        first: block.first,
    }
}

#[cfg(test)]
mod tests {
    use super::super::recursion::Base;
    use super::*;
    use crate::base::Rng;
    use crate::product::schemes::SchemeId::{self, Kgp4, Split, Strassen, Winograd};

    /// Integers by rows.
    struct Matrix {
        cols: usize,
        entries: Vec<i64>,
    }

    impl Matrix {
        fn random(rows: usize, cols: usize, rng: &mut Rng) -> Self {
            let entries = (0..rows * cols).map(|_| (rng.bits() % 19) as i64 - 9).collect();
            Self { cols, entries }
        }

        fn at(&self, i: usize, j: usize) -> i64 {
            self.entries[i * self.cols + j]
        }

        /// Returns the sum of blocks, `depth` x `width`, with zeros where they end.
        fn sum(&self, blocks: &[SignedBlock], depth: usize, width: usize) -> Self {
            let mut sum = Self { cols: width, entries: vec![0; depth * width] };
            for block in blocks {
                assert!(block.rows.len() <= depth && block.cols.len() <= width);
                assert!(block.coefficient != 0);
                for (k, row) in block.rows.clone().enumerate() {
                    for (j, col) in block.cols.clone().enumerate() {
                        let x = i64::from(block.coefficient) * self.at(row, col);
                        sum.entries[k * width + j] += x;
                    }
                }
            }
            sum
        }
    }

    /// Runs a program: each requested entry of C, or `None` where nothing was added.
    fn evaluate(
        program: &[FusedProduct],
        op: Op,
        a: &Matrix,
        b: &Matrix,
        n: usize,
    ) -> Vec<Option<i64>> {
        let k = b.cols;
        let mut c = vec![None; n * k];
        for product in program {
            let Shape { depth, rows, cols, same } = product.shape;
            assert!(!same || op == Op::Syrk && product.right.is_empty() && rows == cols);
            let left = a.sum(&product.left, depth, rows);
            let right = if same {
                a.sum(&product.left, depth, cols)
            } else {
                b.sum(&product.right, depth, cols)
            };
            let dot = |i, j| (0..depth).map(|r| left.at(r, i) * right.at(r, j)).sum::<i64>();
            let sums: Vec<i64> = (0..rows * cols).map(|e| dot(e / cols, e % cols)).collect();
            assert!(!product.outputs.is_empty());
            for output in &product.outputs {
                assert!(output.rows.len() <= rows && output.cols.len() <= cols);
                if op.symmetric() {
                    assert!(output.rows.end > output.cols.start, "above the diagonal: {output:?}");
                }
                for (i, row) in output.rows.clone().enumerate() {
                    for (j, col) in output.cols.clone().enumerate() {
                        if op.symmetric() && row < col {
                            continue;
                        }
                        let entry = &mut c[row * k + col];
                        let sum = i64::from(output.coefficient) * sums[i * cols + j];
                        assert_eq!(output.first, entry.is_none(), "({row}, {col}) of {output:?}");
                        *entry = Some(entry.unwrap_or(0) + sum);
                    }
                }
            }
        }
        c
    }

    fn check(recursion: &Recursion, op: Op, m: usize, n: usize, k: usize, rng: &mut Rng) {
        let a = Matrix::random(m, n, rng);
        let other = Matrix::random(m, k, rng);
        let b = if op == Op::Syrk { &a } else { &other };
        let c = evaluate(&products(recursion, op, m, n, k), op, &a, b, n);
        for i in 0..n {
            for j in 0..k {
                let wanted = !op.symmetric() || i >= j;
                let expected = (0..m).map(|r| a.at(r, i) * b.at(r, j)).sum();
                let expected = wanted.then_some(expected);
                assert_eq!(c[i * k + j], expected, "{op:?} {m} {n} {k}, ({i}, {j}), {recursion:?}");
            }
        }
    }

    /// Returns every recursion that the native kernels may be given, and deeper ones.
    fn recursions() -> impl Iterator<Item = Recursion> {
        let symmetric: [&[SchemeId]; 3] = [&[], &[Split], &[Kgp4, Split]];
        let general: [&[SchemeId]; 3] = [&[], &[Strassen], &[Winograd]];
        symmetric.into_iter().flat_map(move |symmetric| {
            general.into_iter().flat_map(move |general| {
                [1, 2].into_iter().flat_map(move |fast_levels| {
                    [1, 3, 8].into_iter().map(move |side| Recursion {
                        symmetric: symmetric.to_vec(),
                        general: general.to_vec(),
                        base: Base { general: side, symmetric: side },
                        fast_levels,
                    })
                })
            })
        })
    }

    #[test]
    fn symmetric_programs_compute_the_lower_triangle_once() {
        let mut rng = Rng::new(1);
        for recursion in recursions() {
            for (m, n) in [(0, 5), (1, 1), (2, 3), (5, 7), (9, 13), (17, 17), (13, 33), (40, 27)] {
                check(&recursion, Op::Syrk, m, n, n, &mut rng);
                check(&recursion, Op::Gemmt, m, n, n, &mut rng);
            }
        }
    }

    #[test]
    fn general_programs_compute_every_entry_once() {
        let mut rng = Rng::new(2);
        for recursion in recursions() {
            for (m, n, k) in
                [(0, 3, 2), (1, 1, 1), (3, 2, 5), (7, 9, 5), (17, 13, 19), (25, 33, 11)]
            {
                check(&recursion, Op::Gemm, m, n, k, &mut rng);
            }
        }
    }

    #[test]
    fn nothing_is_computed_for_an_empty_result() {
        for recursion in recursions() {
            for (op, n, k) in [(Op::Syrk, 0, 0), (Op::Gemm, 0, 4), (Op::Gemm, 4, 0)] {
                let program = products(&recursion, op, 3, n, k);
                let entries: usize = program.iter().map(|p| p.shape.rows * p.shape.cols).sum();
                assert_eq!(entries, 0, "{op:?}, {recursion:?}");
            }
        }
    }

    #[test]
    fn totals_are_those_of_the_products() {
        // Sums of integers are exact in any order.
        let price = |symmetric: bool| {
            move |p: &FusedProduct| {
                let area = |b: &SignedBlock| b.rows.len() * b.cols.len();
                let read: usize = p.left.iter().chain(&p.right).map(area).sum();
                p.work(symmetric) + (read * p.outputs.len() + p.shape.rows) as f64
            }
        };
        for recursion in recursions() {
            for (op, m, n, k) in [
                (Op::Syrk, 40, 131, 131),
                (Op::Gemmt, 40, 131, 131),
                (Op::Syrk, 1, 64, 64),
                (Op::Gemm, 25, 33, 111),
                (Op::Gemm, 0, 5, 7),
            ] {
                let price = price(op.symmetric());
                let sum: f64 = products(&recursion, op, m, n, k).iter().map(price).sum();
                assert_eq!(total(&recursion, op, [m, n, k], price), sum, "{recursion:?}, {op:?}");
            }
        }
    }

    #[test]
    fn work_is_that_of_the_entries_wanted() {
        let whole = |op| {
            products(&Recursion::none(), op, 10, 20, 20)
                .iter()
                .map(|p| p.work(op.symmetric()))
                .sum()
        };
        let (triangle, square): (f64, f64) = (whole(Op::Syrk), whole(Op::Gemm));
        assert_eq!((triangle, square), (2100.0, 4000.0));
    }
}
