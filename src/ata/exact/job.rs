//! The work on the blocks of C, by all threads.

use std::ops::ControlFlow;

use super::clock::Clock;
use super::layout::{Layout, Pair, Unit};
use super::product::{Round, Worker};
use super::sink::Sink;
use crate::base::{Disjoint, Tracker, tickets};
use crate::kernel::int8::{Block, Kernel};

/// What all rounds share.
pub(super) struct Job<'j, 'm, S> {
    pub layout: &'j Layout,
    pub sink: S,
    /// Residues of C between the chunks of a round.
    pub kept: Disjoint<'m, Block<i8>>,
    pub progress: &'j Tracker<'j>,
    pub clock: &'j Clock,
}

impl<S: Sink> Job<'_, '_, S> {
    /// Multiplies and writes C, block by block: for rounds of one chunk.
    pub fn finish(&self, workers: &mut [Worker<'_>], round: &Round<'_, '_>, pair: Pair) {
        let units = self.layout.units(pair);
        let moduli = self.layout.moduli;
        tickets(workers, units.len(), |worker, i| {
            let unit = &units[i];
            let residues = &Disjoint::of_slice(&mut *worker.residues);
            let (rows, cols) = (unit.rows.len(), unit.cols.len());
            let place = |l: usize| {
                move |i: usize, j: usize| {
                    (l * cols + j - unit.cols.start) * rows + i - unit.rows.start
                }
            };
            self.clock.time(
                |s| &mut s.products,
                1,
                || {
                    for l in 0..moduli {
                        let (left, sums) = (&mut *worker.left, &mut *worker.sums);
                        // SAFETY: the residues are this thread's own.
                        unsafe { round.multiply(unit, l, left, sums, residues, place(l)) };
                    }
                },
            );
            // SAFETY: as above; a block of C is in one unit.
            unsafe { self.write(round.kernel, unit, residues, place) };
            self.done(round, unit, moduli)
        });
    }

    /// Adds the product of a chunk to the residues kept.
    pub fn accumulate(&self, workers: &mut [Worker<'_>], round: &Round<'_, '_>, pair: Pair) {
        let units = self.layout.units(pair);
        tickets(workers, units.len() * self.layout.moduli, |worker, i| {
            let (l, unit) = (i / units.len(), &units[i % units.len()]);
            self.clock.time(
                |s| &mut s.products,
                1,
                || {
                    let (left, sums) = (&mut *worker.left, &mut *worker.sums);
                    // SAFETY: a pair of panels is in one unit, which is taken once for each modulus.
                    unsafe { round.multiply(unit, l, left, sums, &self.kept, self.place(pair, l)) };
                },
            );
            self.done(round, unit, 1)
        });
    }

    /// Writes C from the residues kept.
    pub fn recombine(&self, workers: &mut [Worker<'_>], kernel: &dyn Kernel, pair: Pair) {
        let units = self.layout.units(pair);
        tickets(workers, units.len(), |_, i| {
            // SAFETY: nobody writes the residues now; a block of C is in one unit.
            unsafe { self.write(kernel, &units[i], &self.kept, |l| self.place(pair, l)) };
            self.progress.state()
        });
    }

    /// Where the residues kept modulo the l-th number are.
    fn place(&self, pair: Pair, l: usize) -> impl Fn(usize, usize) -> usize {
        let (layout, first) = (self.layout, l * self.layout.largest_round());
        move |i, j| first + layout.place(pair, i, j)
    }

    fn done(&self, round: &Round<'_, '_>, unit: &Unit, moduli: usize) -> ControlFlow<()> {
        self.progress.add((self.layout.cost(unit) * round.steps() * moduli) as f64)
    }

    /// Writes a block of C from its residues, those of panels (i, j) modulo the l-th number at
    /// `place(l)(i, j)`.
    ///
    /// # Safety
    /// Nobody writes the residues, and nobody uses the block of C, meanwhile.
    unsafe fn write<P: Fn(usize, usize) -> usize>(
        &self,
        kernel: &dyn Kernel,
        unit: &Unit,
        residues: &Disjoint<'_, Block<i8>>,
        place: impl Fn(usize) -> P,
    ) {
        self.clock.time(
            |s| &mut s.recombination,
            1,
            || {
                for j in unit.cols.clone() {
                    for i in self.layout.first_row(unit, j)..unit.rows.end {
                        // SAFETY: the caller's promise.
                        let residues = |l: usize| unsafe { residues.read(place(l)(i, j)) };
                        // SAFETY: the caller's promise; blocks of different panels are disjoint.
                        unsafe { self.sink.take(kernel, (i, j), residues) };
                    }
                }
            },
        );
    }
}
