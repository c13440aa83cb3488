//! The work on the blocks of C, by all threads.

use super::clock::Clock;
use super::layout::{Batch, Layout, Unit};
use super::product::{Round, Worker};
use super::sink::Sink;
use crate::base::{Disjoint, Tracker, tickets};
use crate::kernel::int8::{Block, Kernel};

/// What all rounds share.
pub(super) struct Job<'j, 'm, S> {
    pub layout: &'j Layout,
    pub sink: S,
    /// Residues of a batch of C, modulus by modulus.
    pub residues: Disjoint<'m, Block<i8>>,
    pub progress: &'j Tracker<'j>,
    pub clock: &'j Clock,
}

impl<S: Sink> Job<'_, '_, S> {
    /// Multiplies the blocks of a batch over a chunk of rows: all of them modulo one number, whose
    /// residues then stay in the last cache, before those modulo the next.
    pub fn multiply(&self, workers: &mut [Worker<'_>], round: &Round<'_, '_>, batch: &Batch) {
        let units = &batch.units;
        tickets(workers, units.len() * self.layout.moduli, |worker, i| {
            let (l, unit) = (i / units.len(), &units[i % units.len()]);
            let place = |i: usize, j: usize| l * batch.places + unit.place(i, j);
            self.clock.time(
                |s| &mut s.products,
                1,
                || {
                    // SAFETY: a unit has places of its own, and is taken once for each modulus.
                    unsafe { round.multiply(unit, l, worker.left, &self.residues, place) };
                },
            );
            self.progress.add((self.layout.cost(unit) * round.steps()) as f64)
        });
    }

    /// Writes the blocks of a batch from their residues.
    pub fn recombine(&self, workers: &mut [Worker<'_>], kernel: &dyn Kernel, batch: &Batch) {
        tickets(workers, batch.units.len(), |_, i| {
            // SAFETY: nobody writes the residues now; a block of C is in one unit.
            unsafe { self.write(kernel, &batch.units[i], batch.places) };
            self.progress.state()
        });
    }

    /// Writes a block of C from its residues, of which `places` are those modulo one number.
    ///
    /// # Safety
    /// Nobody writes the residues, and nobody uses the block of C, meanwhile.
    unsafe fn write(&self, kernel: &dyn Kernel, unit: &Unit, places: usize) {
        self.clock.time(
            |s| &mut s.recombination,
            1,
            || {
                for j in unit.cols.clone() {
                    for i in self.layout.first_row(unit, j)..unit.rows.end {
                        let place = |l: usize| l * places + unit.place(i, j);
                        // SAFETY: the caller's promise.
                        let residues = |l: usize| unsafe { self.residues.read(place(l)) };
                        // SAFETY: the caller's promise; blocks of different panels are disjoint.
                        unsafe { self.sink.take(kernel, (i, j), residues) };
                    }
                }
            },
        );
    }
}
