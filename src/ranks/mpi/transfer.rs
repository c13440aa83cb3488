use ::mpi::ffi;
use ::mpi::point_to_point::{Destination, Source};
use ::mpi::raw::AsRaw;
use ::mpi::topology::Communicator;

use super::memory::Buffer;
use super::requests::Requests;
use super::tags::Tag;
use super::world::{MpiReal, Traffic, World};

/// A message on its way that owns its entries until it has arrived.
pub(super) struct Transfer<T> {
    buffer: Buffer<T>,
    requests: Requests,
}

impl<T: MpiReal> Transfer<T> {
    /// Starts to send `buffer` to each of the ranks `to`; a long buffer is sent in several
    /// messages.
    pub(super) fn send(
        world: &World,
        buffer: Buffer<T>,
        to: impl IntoIterator<Item = usize>,
        tag: Tag,
    ) -> Self {
        let datatype = T::equivalent_datatype();
        let mut transfer = Self { buffer, requests: Requests::default() };
        for to in to {
            for part in transfer.buffer.chunks(world.longest_message()) {
                // SAFETY: the entries stay in place on the heap until the request has ended: only
                // then are they returned, and a transfer that is dropped waits for it.
                transfer.requests.start(|request| unsafe {
                    ffi::MPI_Isend(
                        part.as_ptr().cast(),
                        part.len() as i32,
                        datatype.as_raw(),
                        to as i32,
                        tag.number(),
                        world.raw(),
                        request,
                    );
                });
                world.count(Traffic {
                    words_sent: part.len() as u64,
                    messages_sent: 1,
                    ..Traffic::default()
                });
            }
        }
        transfer
    }

    /// Starts to receive as many entries as `buffer` has from rank `from`, sent by
    /// [`Transfer::send`] with the same tag.
    pub(super) fn receive(world: &World, mut buffer: Buffer<T>, from: usize, tag: Tag) -> Self {
        let mut requests = Requests::default();
        let datatype = T::equivalent_datatype();
        for part in buffer.chunks_mut(world.longest_message()) {
            // SAFETY: the entries stay in place on the heap, and nothing else accesses them, until
            // the request has ended: only then are they returned, and a transfer that is dropped
            // waits for it. A part has at most `longest_message` entries, of the type `datatype`.
            requests.start(|request| unsafe {
                ffi::MPI_Irecv(
                    part.as_mut_ptr().cast(),
                    part.len() as i32,
                    datatype.as_raw(),
                    from as i32,
                    tag.number(),
                    world.raw(),
                    request,
                );
            });
        }
        world.count(Traffic {
            words_received: buffer.len() as u64,
            messages_received: requests.len() as u64,
            ..Traffic::default()
        });
        Self { buffer, requests }
    }
}

impl<T> Transfer<T> {
    /// Returns whether the transfer has ended.
    pub(super) fn has_ended(&mut self) -> bool {
        self.requests.have_ended()
    }

    /// Waits for the end, and returns the entries.
    pub(super) fn wait(mut self) -> Buffer<T> {
        self.requests.wait();
        std::mem::take(&mut self.buffer)
    }
}

/// Sends `entries` to rank `to`, and returns when they may be changed.
pub(super) fn send<T: MpiReal>(world: &World, entries: &[T], to: usize, tag: Tag) {
    for part in entries.chunks(world.longest_message()) {
        world.communicator().process_at_rank(to as i32).send_with_tag(part, tag.number());
        let (words_sent, messages_sent) = (part.len() as u64, 1);
        world.count(Traffic { words_sent, messages_sent, ..Traffic::default() });
    }
}

/// Receives `entries` from rank `from`, sent as many and with the same tag.
pub(super) fn receive<T: MpiReal>(world: &World, entries: &mut [T], from: usize, tag: Tag) {
    for part in entries.chunks_mut(world.longest_message()) {
        let (words_received, messages_received) = (part.len() as u64, 1);
        world.communicator().process_at_rank(from as i32).receive_into_with_tag(part, tag.number());
        world.count(Traffic { words_received, messages_received, ..Traffic::default() });
    }
}

impl<T> Drop for Transfer<T> {
    fn drop(&mut self) {
        if self.requests.is_empty() {
            return;
        }
        if std::thread::panicking() {
            // The receiver may never come, and the job is about to be aborted: the entries stay.
            std::mem::forget(std::mem::take(&mut self.buffer));
        } else {
            self.requests.wait();
        }
    }
}
