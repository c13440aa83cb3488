//! The residues of a group of columns and a chunk of rows, in memory.

use std::ops::Range;

use faer::MatRef;

use super::columns::{Columns, for_tiles};
use super::layout::{ExactLayout, Extent, Need, Pair, Pieces};
use crate::base::{Disjoint, Par};
use crate::kernel::int8::{Conversion, IntegerOperand, Kernel, Modulus, Powers, Residues, Slice};

/// Residues that are still in the last cache when they are multiplied, in bytes.
const CACHED: usize = 32 << 20;

/// For each modulus, the slices in the order of [`Extent::place`].
pub(super) struct Store<'a> {
    memory: &'a mut [Slice],
    extent: Extent,
}

impl<'a> Store<'a> {
    /// Creates an empty store in `memory`.
    pub fn new(memory: &'a mut [Slice]) -> Self {
        Self { memory, extent: Extent { panels: 0..0, pieces: Pieces::new(0..0, 1) } }
    }

    /// Computes the residues of the part of `a` in `extent`.
    pub fn fill<T: IntegerOperand>(
        &mut self,
        kernel: &dyn Kernel,
        a: MatRef<'_, T>,
        columns: &Columns,
        moduli: &[Modulus],
        extent: Extent,
        par: Par,
    ) {
        let slices = &mut self.memory[..moduli.len() * extent.len()];
        let tiles: &mut [Residues] = slices.as_flattened_mut();
        let far = size_of_val(tiles) > CACHED;
        let tiles = Disjoint::of_slice(tiles);
        let tile_columns = 2 * extent.panels.start..2 * extent.panels.end;
        for_tiles(a, extent.pieces.steps.clone(), tile_columns, par, |tile, band, column| {
            columns.clear_non_finite(tile, column);
            let exponents = columns.exponents_of(column);
            let slice = extent.place(column / 2, band);
            let mut out = Vec::with_capacity(moduli.len());
            for l in 0..moduli.len() {
                // SAFETY: each tile is visited once, and each modulus has a place of its own.
                out.push(unsafe { tiles.get(2 * (l * extent.len() + slice) + column % 2) });
            }
            let out = &mut out;
            if columns.wide {
                let powers = &Powers::new(exponents);
                T::convert_wide(kernel, Conversion { tile, powers, moduli, out, far });
            } else {
                let powers = &Powers::new(exponents);
                T::convert(kernel, Conversion { tile, powers, moduli, out, far });
            }
        });
        self.extent = extent;
    }

    /// Returns the panels and steps that the store holds.
    pub fn extent(&self) -> &Extent {
        &self.extent
    }

    /// Returns the slices of these steps of one panel, within one piece, modulo the l-th modulus.
    pub fn slices(&self, l: usize, panel: usize, steps: Range<usize>) -> &[Slice] {
        let first = l * self.extent.len() + self.extent.place(panel, steps.start);
        &self.memory[first..first + steps.len()]
    }
}

/// The residues in memory: those of two groups.
pub(super) struct Residents<'a> {
    stores: [Store<'a>; 2],
    held: [Option<Need>; 2],
}

impl<'a> Residents<'a> {
    /// Creates two empty stores in `memory`.
    pub fn new(memory: [&'a mut [Slice]; 2]) -> Self {
        Self { stores: memory.map(Store::new), held: [None; 2] }
    }

    /// Returns the residues of both sides of a round, for the steps of `chunk`. `fill` computes
    /// those that are not in memory.
    pub fn load(
        &mut self,
        layout: &ExactLayout,
        pair: Pair,
        chunk: Range<usize>,
        mut fill: impl FnMut(&mut Store<'a>, Need, Extent),
    ) -> [&Store<'a>; 2] {
        let needs = layout.needs(pair);
        for need in needs {
            let panels = layout.group(need);
            let pieces = Pieces::new(chunk.clone(), layout.blocking.depth);
            let extent = Extent { panels, pieces };
            let current = |slot: usize| {
                self.held[slot] == Some(need) && *self.stores[slot].extent() == extent
            };
            if current(0) || current(1) {
                continue;
            }
            // A store that this round does not need. If A and B differ, each has its own store.
            let slot = match (layout.same, self.held[0]) {
                (false, _) => need.operand,
                (true, Some(held)) => usize::from(held != need && needs.contains(&held)),
                (true, None) => 0,
            };
            fill(&mut self.stores[slot], need, extent);
            // The other store may hold an earlier chunk of the same group.
            self.held = self.held.map(|held| held.filter(|&h| h != need));
            self.held[slot] = Some(need);
        }
        needs.map(|need| &self.stores[usize::from(self.held[0] != Some(need))])
    }
}
