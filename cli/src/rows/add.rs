//! The pass that adds rows to sums: with checkpoints, and beside other processes.

use std::mem;
use std::ops::ControlFlow;

use catamaran::AtaOptions;
use catamaran::base::Progress;
use catamaran::blas::BlasReal;
use catamaran::rows::{Accumulator, RowBlocks, stream};

use super::checkpoint::Checkpoint;
use crate::progress::Bar;
use crate::ranks::Ranks;
use crate::signals;

/// Where progress goes: a bar, and the part of it from one fraction to another.
pub struct Shown<'a> {
    pub bar: &'a Bar,
    pub part: std::ops::Range<f64>,
}

/// Adds the rows that `sum` lacks, in blocks of `height` rows, and waits until all processes have
/// done so. After a signal the sums are saved, if there is a checkpoint: they are whole after a
/// block only, which is finished first.
///
/// # Errors
/// As [`stream`]; [`catamaran::Error::Cancelled`] after a signal, or the failure of another
/// process.
pub fn add_rows<T: BlasReal>(
    ranks: &Ranks,
    mut checkpoint: Option<Checkpoint>,
    rows: &mut (dyn RowBlocks<T> + Send),
    weights: Option<&[T]>,
    height: usize,
    sum: &mut Accumulator<T>,
    options: &AtaOptions<'_>,
    shown: Shown<'_>,
) -> catamaran::Result<()> {
    let saves = checkpoint.is_some();
    // The signal waits for the end of the block, and for the file.
    let saving = saves.then(signals::finish_first);
    let update = |fraction| {
        shown.bar.show(fraction);
        if !saves && signals::check().is_err() {
            return ControlFlow::Break(());
        }
        ControlFlow::Continue(())
    };
    let options = options.clone().progress(Progress::new(&update).part(shown.part.clone()));
    let mut is_stopped = false;
    let mut after_block = |sum: &Accumulator<T>| {
        let go_on = ranks.check();
        if let Some(checkpoint) = &mut checkpoint {
            match go_on {
                Ok(()) => checkpoint.after_block(sum),
                Err(_) => {
                    checkpoint.save(sum);
                    is_stopped = true;
                }
            }
        }
        go_on
    };
    let mut done = stream(rows, weights, height, sum, &options, &mut after_block);
    if let Some(checkpoint) = &checkpoint {
        done = done.map_err(|error| checkpoint.of_blocks(error));
    }
    if done.is_ok() {
        done = ranks.gather_up();
        if let (Err(_), Some(checkpoint)) = (&done, &checkpoint) {
            checkpoint.save(sum);
            is_stopped = true;
        }
    }
    if is_stopped && ranks.size() > 1 {
        ranks.note_stop();
        // Others may save their sums still: this process ends when they have done so.
        mem::forget(saving);
    }
    done
}
