//! Sums over a few ranks, scattered evenly.

use std::ops::Range;

use super::memory::Buffer;
use super::tags::ROUNDS;
use super::transfer::Transfer;
use super::world::{MpiReal, World};
use crate::base::{Result, even_part};
use crate::ranks::plan::rounds;

/// The reduction of `len` numbers over `count` ranks, `step` apart, from `first` on. Each rank
/// sends every number that is not its own once, in `ceil(log2 count)` messages.
pub(super) struct Scatter<T> {
    first: usize,
    step: usize,
    count: usize,
    /// The number of this rank among them.
    own: usize,
    len: usize,
    outgoing: Buffer<T>,
    incoming: Buffer<T>,
}

impl<T: MpiReal> Scatter<T> {
    /// Allocates memory for one message each way. This rank is `first + own step`.
    pub(super) fn new([first, step, count]: [usize; 3], own: usize, len: usize) -> Result<Self> {
        let (outgoing, incoming) = (Buffer::default(), Buffer::default());
        let mut scatter = Self { first, step, count, own, len, outgoing, incoming };
        let rounds = rounds(count);
        let longest = |of: &dyn Fn(&Range<usize>) -> Range<usize>| {
            rounds.iter().map(|round| scatter.len_of(of(&round.parts))).max().unwrap_or(0)
        };
        let outgoing = Buffer::with_room(longest(&|parts| parts.clone()))?;
        let incoming = Buffer::with_room(longest(&|parts| 0..parts.len()))?;
        (scatter.outgoing, scatter.incoming) = (outgoing, incoming);
        Ok(scatter)
    }

    /// Returns the numbers that the rank `i` after this one gets.
    fn part(&self, i: usize) -> Range<usize> {
        even_part(0..self.len, self.count, (self.own + i) % self.count)
    }

    fn len_of(&self, parts: Range<usize>) -> usize {
        parts.map(|i| self.part(i).len()).sum()
    }

    /// Sums `terms` over the ranks. Afterwards those of this rank, which are returned, are sums,
    /// and the others unspecified.
    pub(super) fn sum<'t>(&mut self, world: &World, terms: &'t mut [T]) -> &'t [T] {
        let (own, count) = (self.own, self.count);
        let rank = |i: usize| self.first + i % count * self.step;
        for (k, round) in rounds(count).into_iter().enumerate() {
            let parts = round.parts;
            let (to, from) = (rank(own + parts.start), rank(own + count - parts.start));
            let mut incoming = std::mem::take(&mut self.incoming);
            incoming.set_len(self.len_of(0..parts.len()));
            let mut outgoing = std::mem::take(&mut self.outgoing);
            outgoing.set_len(0);
            parts.clone().for_each(|i| outgoing.extend_from_slice(&terms[self.part(i)]));
            let arriving = Transfer::receive(world, incoming, from, ROUNDS.tag(k));
            let leaving = Transfer::send(world, outgoing, [to], ROUNDS.tag(k));
            let incoming = arriving.wait();
            let mut rest = &incoming[..];
            for i in 0..parts.len() {
                let sums = &mut terms[self.part(i)];
                let (part, others) = rest.split_at(sums.len());
                sums.iter_mut().zip(part).for_each(|(sum, &term)| *sum += term);
                rest = others;
            }
            (self.incoming, self.outgoing) = (incoming, leaving.wait());
        }
        &terms[self.part(0)]
    }
}
