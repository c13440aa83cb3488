use std::cell::Cell;

use faer::MatMut;
use faer::prelude::ReborrowMut;

use super::memory::{entries, put_entries};
use super::world::{Fact, Operation, World};
use crate::base::Result;

/// A call during which the ranks meet several times. A rank that fails between two meetings reports
/// this at the next one, and all ranks then return an error.
pub(super) struct Call<'w> {
    pub world: &'w World,
    /// Whether all ranks know already that the call has failed.
    over: Cell<bool>,
}

impl<'w> Call<'w> {
    /// Calls `work` on all ranks, which must call it with the same `facts`.
    ///
    /// # Errors
    /// As [`World::begin`] and [`World::agree`].
    pub fn run<X>(
        world: &'w World,
        operation: Operation,
        facts: &[Fact],
        work: impl FnOnce(&Self) -> Result<X>,
    ) -> Result<X> {
        let _guard = world.abort_on_panic();
        world.begin(operation, facts, Ok(()))?;
        let call = Self { world, over: Cell::new(false) };
        let done = work(&call);
        if call.over.get() { done } else { world.agree(done) }
    }

    /// Waits for the other ranks; returns `Ok` on every rank if it is `Ok` on every rank. Call it
    /// before anything that ranks do together.
    pub fn meet<X>(&self, own: Result<X>) -> Result<X> {
        let met = self.world.agree(own);
        self.over.set(met.is_err());
        met
    }

    /// Computes the sum over the ranks of their matrices, on every rank.
    pub fn sum(&self, mut partial: MatMut<'_, f64>) -> Result<()> {
        let mut values = self.meet(entries(partial.as_ref()))?;
        // MPI promises the same result on every rank, bit for bit, so that all ranks decide alike.
        self.world.sum(&mut values);
        put_entries(partial.rb_mut(), &values);
        Ok(())
    }
}
