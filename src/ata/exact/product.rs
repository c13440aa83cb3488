//! Blocks of C modulo one number.

use super::layout::{DEPTH, Layout, SLAB, Unit};
use super::store::Store;
use crate::base::{Arena, Disjoint, Real};
use crate::kernel::int8::{Block, Kernel, Moduli, Slice, WIDTH};

/// The memory of one thread.
pub(super) struct Worker<'a> {
    /// The left side of a block, one slab of it.
    pub left: &'a mut [Slice],
    /// Sums of the block.
    pub sums: &'a mut [Block<i32>],
    /// Its residues, modulus by modulus; unused where they are kept for all of C.
    pub residues: &'a mut [Block<i8>],
}

impl<'a> Worker<'a> {
    pub fn new<T: Real>(arena: &mut Arena<'a, T>, layout: &Layout) -> Self {
        let [left, sums, residues] = Self::lengths(layout);
        Self {
            left: arena.take_as(left),
            sums: arena.take_as(sums),
            residues: arena.take_as(residues),
        }
    }

    fn lengths(layout: &Layout) -> [usize; 3] {
        let pairs = layout.block.0 * layout.block.1;
        let kept = if layout.accumulates() { 0 } else { layout.moduli * pairs };
        [layout.block.0 * SLAB.min(layout.chunk), pairs, kept]
    }

    pub fn scratch_len<T: Real>(layout: &Layout) -> usize {
        let [left, sums, residues] = Self::lengths(layout);
        Arena::<T>::len_of::<Slice>(left)
            + Arena::<T>::len_of::<Block<i32>>(sums)
            + Arena::<T>::len_of::<Block<i8>>(residues)
    }
}

/// Products of the residues of a group of A and one of B, over a chunk of rows.
pub(super) struct Round<'r, 'm> {
    pub kernel: &'r dyn Kernel,
    pub layout: &'r Layout,
    pub moduli: &'r Moduli,
    pub left: &'r Store<'m>,
    pub right: &'r Store<'m>,
    /// Whether to add to the residues of an earlier chunk.
    pub continued: bool,
}

impl Round<'_, '_> {
    /// Steps of its chunk.
    pub fn steps(&self) -> usize {
        self.left.extent().steps.len()
    }

    /// Block `unit` of the product modulo the `l`-th number; the residues of panels (i, j) go to
    /// `residues[place(i, j)]`.
    ///
    /// # Safety
    /// Nobody else uses these places meanwhile.
    pub unsafe fn multiply(
        &self,
        unit: &Unit,
        l: usize,
        left: &mut [Slice],
        sums: &mut [Block<i32>],
        residues: &Disjoint<'_, Block<i8>>,
        place: impl Fn(usize, usize) -> usize,
    ) {
        let Self { kernel, layout, .. } = self;
        let _session = kernel.session();
        let all = &self.left.extent().steps;
        let slabs = all.len().div_ceil(SLAB);
        let bound = |i: usize| all.start + all.len() * i / slabs;
        for slab in 0..slabs {
            let steps = bound(slab)..bound(slab + 1);
            for (i, left) in unit.rows.clone().zip(left.chunks_exact_mut(steps.len())) {
                kernel.to_left(self.left.slices(l, i, steps.clone()), left);
            }
            for j in unit.cols.clone() {
                let rows = layout.first_row(unit, j)..unit.rows.end;
                let right = self.right.slices(l, j, steps.clone());
                // What comes next on the right is fetched a share at a time.
                let next = (j + 1).min(unit.cols.end - 1);
                let mut ahead = self.right.slices(l, next, steps.clone()).as_ptr().cast::<i8>();
                let share = size_of::<Slice>() * DEPTH / rows.len().max(1);
                for first in (0..steps.len()).step_by(DEPTH) {
                    let depth = first..steps.len().min(first + DEPTH);
                    for i in rows.clone() {
                        let at = (j - unit.cols.start) * unit.rows.len() + i - unit.rows.start;
                        let sums = &mut sums[at];
                        // SAFETY: the caller's promise; the reference dies with this product.
                        let residues = unsafe { residues.get(place(i, j)) };
                        if slab == 0 && first == 0 {
                            start(sums, self.continued.then_some(&*residues));
                        }
                        let left = &left[(i - unit.rows.start) * steps.len()..][depth.clone()];
                        kernel.multiply(left, &right[depth.clone()], sums, ahead);
                        ahead = ahead.wrapping_add(share);
                        if slab + 1 == slabs && depth.end == steps.len() {
                            kernel.reduce(sums, &self.moduli.list[l], residues);
                        }
                    }
                }
            }
        }
    }
}

/// Sums begin with the residues of the rows before, or with zeros.
fn start(sums: &mut Block<i32>, residues: Option<&Block<i8>>) {
    match residues {
        None => *sums = [[[0; WIDTH]; WIDTH]; 4],
        Some(residues) => {
            let residues = residues.as_flattened().as_flattened();
            for (sum, &r) in sums.as_flattened_mut().as_flattened_mut().iter_mut().zip(residues) {
                *sum = r.into();
            }
        }
    }
}
