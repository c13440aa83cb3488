use std::cell::RefCell;
use std::marker::PhantomData;

use ::mpi::Address;
use ::mpi::datatype::{UncommittedUserDatatype, UserDatatype};
use ::mpi::ffi;
use ::mpi::raw::AsRaw;
use faer::MatRef;

use super::requests::Requests;
use super::tags::Tag;
use super::world::{MpiReal, PANICKED, Traffic, World};

/// Blocks of matrices on their way to another rank, sent without a copy.
///
/// A value must never be forgotten: its destructor keeps the blocks in place until they have been
/// read.
pub(super) struct PendingSend<'a, T> {
    world: &'a World,
    requests: Requests,
    blocks: PhantomData<MatRef<'a, T>>,
}

impl<'a, T: MpiReal> PendingSend<'a, T> {
    /// Starts to send `blocks`, one after another and each column by column, to rank `to`, which
    /// receives all their entries with one
    /// [`Transfer::receive`](super::transfer::Transfer::receive).
    pub(super) fn send(world: &'a World, blocks: &[MatRef<'a, T>], to: usize, tag: Tag) -> Self {
        let len: usize = blocks.iter().map(|block| block.nrows() * block.ncols()).sum();
        let longest = world.longest_message();
        let mut send = Self { world, requests: Requests::default(), blocks: PhantomData };
        for start in (0..len).step_by(longest) {
            let parts = parts(blocks, start, longest.min(len - start));
            send.start(&parts, to, tag);
        }
        let (words_sent, messages_sent) = (len as u64, send.requests.len() as u64);
        world.count(Traffic { words_sent, messages_sent, ..Traffic::default() });
        send
    }

    /// Starts one message of all the entries of `parts`, at least one.
    fn start(&mut self, parts: &[MatRef<'a, T>], to: usize, tag: Tag) {
        let first = parts[0].as_ptr();
        let distance = |part: &MatRef<'_, T>| part.as_ptr() as Address - first as Address;
        let types: Vec<_> = parts.iter().map(|&part| datatype(part)).collect();
        let distances: Vec<_> = parts.iter().map(distance).collect();
        let message = UserDatatype::structured(&vec![1; parts.len()], &distances, &types);
        let (world, tag) = (self.world.raw(), tag.number());
        // SAFETY: the datatype covers the entries of the parts and nothing else; they are borrowed
        // until the request has ended, since the send that is dropped waits for it. MPI keeps
        // the datatype until then.
        self.requests.start(|request| unsafe {
            ffi::MPI_Isend(first.cast(), 1, message.as_raw(), to as i32, tag, world, request);
        });
    }
}

impl<T> Drop for PendingSend<'_, T> {
    fn drop(&mut self) {
        if std::thread::panicking() {
            // The receiver may never come, and memory that is being sent can't be released.
            use ::mpi::topology::Communicator;
            self.world.communicator().abort(PANICKED);
        }
        self.requests.wait();
    }
}

/// Several pending sends; the destructor waits for all.
pub(super) struct PendingSends<'a, T>(RefCell<Vec<PendingSend<'a, T>>>);

impl<'a, T> FromIterator<PendingSend<'a, T>> for PendingSends<'a, T> {
    fn from_iter<I: IntoIterator<Item = PendingSend<'a, T>>>(sends: I) -> Self {
        Self(RefCell::new(sends.into_iter().collect()))
    }
}

impl<T> PendingSends<'_, T> {
    /// Returns whether some sends have not ended. Long messages may travel in pieces, also those of
    /// adjacent entries, and MPI moves each piece only when this rank asks for its state.
    pub(super) fn are_moving(&self) -> bool {
        let mut sends = self.0.borrow_mut();
        sends.retain_mut(|send| !send.requests.have_ended());
        !sends.is_empty()
    }
}

/// Returns the entries from `start`, `len` of them, of blocks one after another, as parts of
/// columns and whole columns.
fn parts<'a, T>(blocks: &[MatRef<'a, T>], start: usize, len: usize) -> Vec<MatRef<'a, T>> {
    let mut parts = Vec::new();
    let (mut skipped, mut left) = (start, len);
    for &block in blocks {
        let rows = block.nrows();
        let size = rows * block.ncols();
        let end = size.min(skipped + left);
        let mut at = skipped.min(size);
        skipped -= at;
        left -= end - at;
        while at < end {
            let (row, col) = (at % rows, at / rows);
            let whole = if row == 0 { (end - at) / rows } else { 0 };
            let part = match whole {
                0 => block.get(row..rows.min(row + end - at), col..col + 1),
                _ => block.get(.., col..col + whole),
            };
            at += part.nrows() * part.ncols();
            parts.push(part);
        }
    }
    parts
}

/// Returns the datatype of the entries of `part`, column by column.
fn datatype<T: MpiReal>(part: MatRef<'_, T>) -> UncommittedUserDatatype {
    type Type = UncommittedUserDatatype;
    let scalar = T::equivalent_datatype();
    let bytes = |stride: isize| stride as Address * size_of::<T>() as Address;
    // The entries of a message can be counted by an i32, and so can its sides.
    let (rows, cols) = (part.nrows() as i32, part.ncols() as i32);
    let next_col = bytes(part.col_stride());
    if part.row_stride() == 1 {
        Type::heterogeneous_vector(cols, rows, next_col, &scalar)
    } else {
        let column = Type::heterogeneous_vector(rows, 1, bytes(part.row_stride()), &scalar);
        Type::heterogeneous_vector(cols, 1, next_col, &column)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn parts_are_the_entries_in_order() {
        let values: Vec<f64> = (0..35).map(f64::from).collect();
        let a = MatRef::from_column_major_slice(&values[..20], 4, 5);
        let b = MatRef::from_column_major_slice(&values[20..], 5, 3);
        for start in 0..35 {
            for len in 1..=35 - start {
                let mut found = Vec::new();
                let parts = parts(&[a, b], start, len);
                assert!(parts.len() <= 6);
                for part in parts {
                    part.col_iter().for_each(|col| found.extend(col.iter().copied()));
                }
                assert_eq!(found, values[start..start + len]);
            }
        }
    }

    #[test]
    fn empty_blocks_have_no_parts() {
        let empty = MatRef::from_column_major_slice(&[0.0_f64; 0], 0, 5);
        let one = MatRef::from_column_major_slice(&[1.0], 1, 1);
        assert_eq!(parts(&[empty, one, empty], 0, 1).len(), 1);
    }
}
