//! # MPI
//!
//! Products of matrices that are spread over the ranks of a communicator (catamaran_mpi.h, too).
//!
//! ```c
//! cata_world *world;
//! cata_symmetric *c;
//! cata_world_from_comm(MPI_COMM_WORLD, &world);
//! cata_world_ata_rows_f64(world, CATA_ROW_MAJOR, m, n, 1, rows, n, NULL, &c);
//! ```

use std::mem::offset_of;

#[cfg(feature = "mpi")]
use super::entries::Entries;
use super::params::Versioned;

/// The ranks of an MPI communicator that work together; made by cata_world_new, given back by
/// cata_world_free.
///
/// It has a communicator of its own, so that no message of the caller is mistaken for one of the
/// library's. The library never initialises or finalises MPI. MPI is called by the thread that
/// calls, which must be one that may do so; other threads compute, so that MPI_THREAD_FUNNELED is
/// needed (MPI_Init_thread).
///
/// Functions that are called collective are called by all ranks of the world, in the same order
/// and with the same numbers unless said otherwise. An error on one rank is an error on all: its
/// own there, CATA_ERR_RANK on the others, with a message that names the rank. What one rank
/// alone notices of a world that is NULL, or freed, can't be told to the others. A panic aborts
/// the job (MPI_Abort), as the others would wait for ever; so does, unless the communicator has
/// another error handler, an error of MPI itself.
pub struct cata_world {
    #[cfg(feature = "mpi")]
    pub(super) world: crate::mpi::World,
}

/// A symmetric matrix, float or double, whose lower triangle is spread over the ranks of a world;
/// made by cata_world_ata_rows_f64 and the like, given back by cata_symmetric_free.
pub struct cata_symmetric {
    #[cfg(feature = "mpi")]
    pub(super) entries: Entries,
}

/// What a rank has sent and received: words are matrix entries. The few numbers by which ranks
/// agree on shapes and errors are not counted.
#[repr(C)]
#[derive(Debug, Clone, Copy)]
pub struct cata_traffic {
    /// sizeof(cata_traffic).
    pub struct_size: usize,
    /// Entries sent.
    pub words_sent: u64,
    /// Entries received.
    pub words_received: u64,
    /// Messages sent.
    pub messages_sent: u64,
    /// Messages received.
    pub messages_received: u64,
}

impl Versioned for cata_traffic {
    const NAME: &'static str = "cata_traffic";
    const FIRST_SIZE: usize = offset_of!(Self, messages_received) + size_of::<u64>();
}

/// `spread`: every rank has rows of A, in any order and number.
pub const CATA_BY_ROWS: i32 = 141;
/// `spread`: every rank has columns of A, in the order of the ranks.
pub const CATA_BY_COLUMNS: i32 = 142;
