use std::ops::Range;

use super::fused::FusedProduct;
use super::problem::Op;
use super::recursion::Recursion;
use super::scratch::scratch_len;
use super::tree::{Node, Task};
use crate::base::even_part;
use crate::kernel::{int8, packed};
use crate::product::exact::ExactLayout;

/// How a product is computed. Each variant holds all that its executor needs beside the
/// matrices, boxed where it is large: a small product must not pay for moving it.
#[derive(Debug, Clone, PartialEq)]
pub(crate) enum Strategy {
    /// One product on the calling thread: over before another thread has woken up.
    Direct(packed::FloatIsa),
    /// Packed products of sums of blocks, on our own kernels.
    Fused(Box<Fused>),
    /// A recursion for each block of C, over any back end.
    Tasks(Box<Tasks>),
    /// Integer products modulo small coprime numbers.
    Exact(Box<Exact>),
}

/// Products on our own kernels, whose additions are made while packing and writing.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct Fused {
    pub isa: packed::FloatIsa,
    /// The recursion that the programs come from.
    pub recursion: Recursion,
    /// Scalars that packed operands may take, if that is possible.
    pub budget: usize,
    /// Slabs of rows, each with its own partial result, added up in order.
    pub slabs: Vec<Slab>,
}

/// A slab of rows and its products, one after another.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct Slab {
    pub rows: Range<usize>,
    pub program: Vec<FusedProduct>,
    /// The products instead of the program when a column is not finite, because fast levels would
    /// spread that. Empty when the program is classical itself.
    pub classical: Vec<FusedProduct>,
}

impl Fused {
    /// Returns whether some slab has fast levels.
    pub fn is_fast(&self) -> bool {
        self.slabs.iter().any(|slab| !slab.classical.is_empty())
    }
}

/// Blocks of C that threads compute one at a time, by a recursion over a back end.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct Tasks {
    /// Which process computes which block of C.
    pub tree: Node,
    /// The leaves of the tree, the largest first, so that the small ones fill the gaps at the end.
    pub tasks: Vec<Task>,
    /// How rows are cut.
    pub cut: RowSlabs,
    pub recursion: Recursion,
    /// Whether the recursion has levels with additions.
    pub fast: bool,
    /// Whether columns whose norms differ much, or are not finite, make it classical: the caller
    /// has not named a scheme, so that accuracy comes first.
    pub guarded: bool,
}

/// Rows in slabs, each with its own partial result, added up in order. A task takes the chunks of a
/// slab one after another, adding up in C: a tall A would otherwise need sums of blocks as tall.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) struct RowSlabs {
    /// Rows in all.
    pub rows: usize,
    pub slabs: usize,
    /// Chunks of a slab.
    pub chunks: usize,
}

impl RowSlabs {
    /// Returns the rows of each chunk of a slab, in order.
    pub fn chunks_of(self, slab: usize) -> impl Iterator<Item = Range<usize>> {
        let Self { rows, slabs, chunks } = self;
        (slab * chunks..(slab + 1) * chunks)
            .map(move |chunk| even_part(0..rows, slabs * chunks, chunk))
    }

    /// Returns the two lengths of chunks, the shorter one first.
    fn lengths(self) -> [usize; 2] {
        let count = self.slabs * self.chunks;
        [self.rows / count, self.rows.div_ceil(count)]
    }
}

/// The exact path.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct Exact {
    pub isa: int8::IntegerIsa,
    pub layout: ExactLayout,
    /// Whether the product is so small that its integers are multiplied as such; the bytes are the
    /// same.
    pub small: bool,
}

impl Tasks {
    /// Returns the elements of scratch that a thread needs for the tasks of `op`.
    pub fn worker_scratch_len(&self, op: Op) -> usize {
        let mut longest = 0;
        for task in &self.tasks {
            for rows in self.cut.lengths() {
                let (op, n, k) = (task.op(op), task.rows.len(), task.cols.len());
                longest = longest.max(scratch_len(&self.recursion, op, rows, n, k));
            }
        }
        longest
    }
}
