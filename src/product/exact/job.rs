//! The work on the blocks of C, by all threads.

use std::cmp::Reverse;
use std::ops::Range;

use super::layout::{Batch, ExactLayout, Unit};
use super::product::{Round, Worker};
use super::sink::Sink;
use crate::base::{Disjoint, Tracker, tickets};
use crate::kernel::int8::{Kernel, MOST_MODULI, PanelBlock};

/// Data that all rounds share.
pub(super) struct Job<'j, 'm, S> {
    pub layout: &'j ExactLayout,
    pub sink: S,
    /// Residues of a batch of C, modulus by modulus.
    pub residues: Disjoint<'m, PanelBlock<i8>>,
    pub progress: &'j Tracker<'j>,
}

impl<S: Sink> Job<'_, '_, S> {
    /// Multiplies the blocks of a batch over a chunk of rows: all of them modulo one number, whose
    /// residues then stay in the last cache, before those modulo the next.
    pub fn multiply(&self, workers: &mut [Worker<'_>], round: &Round<'_, '_>, batch: &Batch) {
        let units = &batch.units;
        tickets(workers, units.len() * self.layout.moduli, |worker, i| {
            let (l, unit) = (i / units.len(), &units[i % units.len()]);
            let place = |i: usize, j: usize| l * batch.places + unit.place(i, j);
            // SAFETY: a unit has places of its own, and is taken once for each modulus.
            unsafe { round.multiply(unit, l, worker.left, &self.residues, place) };
            self.progress.add((self.layout.cost(unit) * round.steps()) as f64)
        });
    }

    /// Writes the blocks of a batch from their residues.
    pub fn recombine(&self, workers: &mut [Worker<'_>], kernel: &dyn Kernel, batch: &Batch) {
        let by_rows = self.sink.is_by_rows();
        // Row panels or column panels of the units, each with the panels that it meets.
        let mut lines: Vec<(&Unit, usize, Range<usize>)> = Vec::new();
        for unit in &batch.units {
            let Unit { rows, cols, .. } = unit;
            if by_rows {
                lines.extend(rows.clone().map(|i| (unit, i, self.layout.cols_of(unit, i))));
            } else {
                lines.extend(cols.clone().map(|j| (unit, j, self.layout.rows_of(unit, j))));
            }
        }
        // The longest first, so that the short ones fill the gaps at the end.
        lines.sort_by_key(|(_, _, others)| Reverse(others.len()));
        tickets(workers, lines.len(), |_, at| {
            let (unit, line, others) = &lines[at];
            for other in others.clone() {
                let block = if by_rows { (*line, other) } else { (other, *line) };
                // SAFETY: no thread writes the residues now; a block of C is in one line of one
                // unit.
                unsafe { self.write(kernel, batch, unit, block) };
            }
            self.progress.state()
        });
    }

    /// Writes a block of C from its residues.
    ///
    /// # Safety
    /// No thread writes the residues, and no other thread uses the block, meanwhile.
    unsafe fn write(
        &self,
        kernel: &dyn Kernel,
        batch: &Batch,
        unit: &Unit,
        (i, j): (usize, usize),
    ) {
        let (moduli, place) = (self.layout.moduli, unit.place(i, j));
        let next = if self.sink.is_by_rows() { unit.rows.len() } else { 1 };
        // SAFETY: the contract: no thread writes the residues, nor uses this block, meanwhile;
        // blocks of different panels are disjoint.
        unsafe {
            let mut residues = [self.residues.read(place); MOST_MODULI];
            for (l, residues) in residues[..moduli].iter_mut().enumerate() {
                *residues = self.residues.read(l * batch.places + place);
            }
            self.sink.take(kernel, (i, j), &residues[..moduli], next);
        }
    }
}
