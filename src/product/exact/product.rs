//! Blocks of C modulo one number.

use super::layout::{ExactLayout, Unit};
use super::store::Store;
use crate::base::{Arena, Disjoint, Real};
use crate::kernel::int8::{Kernel, Modulus, Operands, PanelBlock, Slice};

/// The memory of one thread.
pub(super) struct Worker<'a> {
    /// The left side of a block, as many steps of it as a product takes.
    pub left: &'a mut [Slice],
}

impl<'a> Worker<'a> {
    /// Takes the memory of one thread from `arena`.
    pub fn new<T: Real>(arena: &mut Arena<'a, T>, layout: &ExactLayout) -> Self {
        Self { left: arena.take_as(Self::slices(layout)) }
    }

    fn slices(layout: &ExactLayout) -> usize {
        layout.blocking.rows * layout.blocking.depth.min(layout.chunk)
    }

    /// Returns the elements of T that [`Worker::new`] takes.
    pub fn scratch_len<T: Real>(layout: &ExactLayout) -> usize {
        Arena::<T>::len_of::<Slice>(Self::slices(layout))
    }
}

/// Products of the residues of a group of A and one of B, over a chunk of rows.
pub(super) struct Round<'r, 'm> {
    pub kernel: &'r dyn Kernel,
    pub layout: &'r ExactLayout,
    pub moduli: &'r [Modulus],
    pub left: &'r Store<'m>,
    pub right: &'r Store<'m>,
    /// Whether to add to the residues of an earlier chunk.
    pub continued: bool,
}

impl Round<'_, '_> {
    /// Returns the number of steps of the chunk.
    pub fn steps(&self) -> usize {
        self.left.extent().pieces.steps.len()
    }

    /// Computes block `unit` of the product modulo the `l`-th number. The residues of the panels
    /// `i` of column panel `j` go to `residues[place(i, j)]` and on.
    ///
    /// # Safety
    /// No other thread uses these places meanwhile.
    pub unsafe fn multiply(
        &self,
        unit: &Unit,
        l: usize,
        left: &mut [Slice],
        residues: &Disjoint<'_, PanelBlock<i8>>,
        place: impl Fn(usize, usize) -> usize,
    ) {
        let Self { kernel, layout, .. } = self;
        let _session = kernel.session();
        let modulus = &self.moduli[l];
        let pieces = &self.left.extent().pieces;
        for piece in 0..pieces.count {
            let steps = pieces.get(piece);
            let depth = steps.len();
            let continued = self.continued || piece > 0;
            for (i, left) in unit.rows.clone().zip(left.chunks_exact_mut(depth)) {
                kernel.to_left(self.left.slices(l, i, steps.clone()), left);
            }
            for j in unit.cols.clone() {
                let rows = layout.rows_of(unit, j);
                let left = &left[(rows.start - unit.rows.start) * depth..][..rows.len() * depth];
                let [right, next] = [j, (j + 1).min(unit.cols.end - 1)]
                    .map(|j| self.right.slices(l, j, steps.clone()));
                let first = place(rows.start, j);
                // SAFETY: no other thread uses the places of this unit, by the contract, and each
                // pair of a piece and a column takes them one after another: the reference ends
                // with this product. The range is checked.
                let residues = unsafe { residues.range(first..first + rows.len()) };
                kernel.product(&Operands { left, right, next, modulus, continued }, residues);
            }
        }
    }
}
