//! # MPI
//!
//! Products, least squares, eigenpairs and orthonormal columns of matrices that are spread over
//! the ranks of a communicator. Functions are collective unless they say Local, and take one
//! call at a time for a world.
//!
//! ```c
//! double rows[] = {1, 2, 3, 4}; // two on each rank
//! cata_world *world;
//! cata_symmetric *c;
//! cata_world_from_comm(MPI_COMM_WORLD, &world);
//! cata_world_ata_rows_f64(world, CATA_ROW_MAJOR, 2, 2, 1, rows, 2, NULL, &c);
//! cata_symmetric_free(c);
//! cata_world_free(world);
//! ```

use super::entries::Entries;
use super::params::versioned;

/// The ranks of an MPI communicator that work together; it has a communicator of its own.
///
/// The library never initializes or finalizes MPI. MPI is called by the thread that calls; other
/// threads compute, so that MPI_THREAD_FUNNELED is needed (MPI_Init_thread).
///
/// Collective functions are called by all ranks of the world, in the same order and with the same
/// numbers unless said otherwise; `params` may differ in `threads` and progress. If one rank fails,
/// every rank returns an error: its own there, CATA_ERR_RANK on the others, with a message that
/// names the rank, except for a world that is NULL. A panic aborts the job (MPI_Abort); so does, by
/// default, an error of MPI itself.
pub struct cata_world {
    pub(super) world: catamaran::ranks::World,
}

/// A symmetric matrix, float or double, whose lower triangle is spread over the ranks of a
/// world.
pub struct cata_symmetric {
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

versioned!(cata_traffic, messages_received: u64);

/// `spread`: every rank has rows of A, in any order and number.
pub const CATA_BY_ROWS: i32 = 141;
/// `spread`: every rank has columns of A, in order.
pub const CATA_BY_COLUMNS: i32 = 142;
