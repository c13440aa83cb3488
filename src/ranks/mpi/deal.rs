//! A and C on one rank, the root, which distributes the rows of A.

use std::collections::VecDeque;

use faer::prelude::{IntoConst, Reborrow, ReborrowMut};
use faer::{MatMut, MatRef};

use super::form::Form;
use super::memory::Buffer;
use super::pending_send::PendingSends;
use super::rows::sum_symmetric;
use super::tags::DEALT;
use super::transfer::Transfer;
use super::world::{MpiReal, Operation, World, fact};
use crate::base::{Result, block_rows};
use crate::product::{AtaOptions, Uplo, ata_into};
use crate::ranks::plan::{Machine, row_shares};

/// Computes the product: on the root, process 0, `own` is A and the lower triangle of C.
pub(super) fn run<T: MpiReal>(
    world: &World,
    form: Form,
    alpha: T,
    beta: T,
    own: Option<(MatRef<'_, T>, MatMut<'_, T>)>,
    options: &AtaOptions<'_>,
) -> Result<()> {
    let size = world.size();
    let parts = row_shares(size, form.m, form.n, &Machine::default());
    let rows = parts[form.process(world.rank(), size)].len();
    let height = block_rows::<T>(form.n, false);
    let facts = [fact("m", form.m), fact("n", form.n)];
    // The root computes in the memory of its matrices.
    let memory =
        if own.is_some() { Hand::new(0, 0, height) } else { Hand::new(rows, form.n, height) };
    let mut hand = world.begin(Operation::Root, &facts, memory)?;

    let lower = AtaOptions { uplo: Uplo::Lower, ..options.clone() };
    let Some((a, mut c)) = own else {
        let sum = hand.play(world, form, alpha, height, &lower);
        let sum = sum_symmetric(world, world.agree(sum)?)?;
        return sum.gather(world, form.root, None, Uplo::Lower);
    };
    // The root sends everything that the other ranks need before it begins to compute.
    let blocks = |process: usize| {
        let rows = parts[process].clone();
        let to = form.rank(process, size);
        let end = rows.end;
        rows.step_by(height).map(move |first| (to, first..end.min(first + height)))
    };
    let longest = parts[1..].iter().map(|rows| rows.len().div_ceil(height)).max().unwrap_or(0);
    let sends: PendingSends<'_, T> = (0..longest)
        .flat_map(|round| (1..size).filter_map(move |process| blocks(process).nth(round)))
        .map(|(to, rows)| form.start_send(world, &[a.subrows(rows.start, rows.len())], to, DEALT))
        .collect();
    let a = a.subrows(0, rows);
    let done = world.with_progress(&lower, 0.0..1.0, &|| sends.are_moving(), |options| {
        ata_into(alpha, a, beta, c.rb_mut(), options)
    });
    drop(sends);
    world.agree(done)?;
    let sum = sum_symmetric(world, c.rb())?;
    sum.gather(world, form.root, Some(c), Uplo::Lower)
}

/// The memory of a rank that the root sends rows to.
struct Hand<T> {
    rows: usize,
    sum: Buffer<T>,
    blocks: Vec<Buffer<T>>,
}

impl<T: MpiReal> Hand<T> {
    fn new(rows: usize, n: usize, height: usize) -> Result<Self> {
        let block = || Buffer::of_len(rows.min(height) * n);
        let count = rows.div_ceil(height).min(2);
        let blocks = (0..count).map(|_| block()).collect::<Result<_>>()?;
        let mut sum = Buffer::of_len(n * n)?;
        if rows == 0 {
            sum.fill(T::ZERO);
        }
        Ok(Self { rows, sum, blocks })
    }

    /// Receives the blocks, each while the product of the one before is added to the sum. Returns
    /// the sum.
    fn play(
        &mut self,
        world: &World,
        form: Form,
        alpha: T,
        height: usize,
        options: &AtaOptions<'_>,
    ) -> Result<MatRef<'_, T>> {
        let n = form.n;
        let mut sum = MatMut::from_row_major_slice_mut(&mut self.sum, n, n);
        let count = |first: usize| height.min(self.rows - first);
        let mut starts = (0..self.rows).step_by(height);
        let mut receive = |mut block: Buffer<T>| {
            let first = starts.next()?;
            block.set_len(count(first) * n);
            Some(Transfer::receive(world, block, form.root, DEALT))
        };
        let mut arriving: VecDeque<_> =
            std::mem::take(&mut self.blocks).into_iter().filter_map(&mut receive).collect();
        let mut done = Ok(());
        let mut first = 0;
        while let Some(block) = arriving.pop_front() {
            let block = block.wait();
            let part = form.part_of_a(&block, block.len() / n.max(1), n);
            // A rank that fails continues to receive, so that the root need not wait.
            if done.is_ok() {
                let share = |rows: usize| rows as f64 / self.rows as f64;
                let share = share(first)..share(first + part.nrows());
                let beta = if first == 0 { T::ZERO } else { T::ONE };
                done = world.with_progress(options, share, &|| false, |options| {
                    ata_into(alpha, part, beta, sum.rb_mut(), options)
                });
            }
            first += part.nrows();
            arriving.extend(receive(block));
        }
        done.map(|()| sum.into_const())
    }
}
