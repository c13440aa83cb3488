//! Matrices that are distributed over the ranks of an MPI communicator: A^T A, by the plans of
//! [`plan`]; Gram-Schmidt and eigenpairs, by the algorithms of [`ortho`](crate::ortho) and
//! [`sparse`](crate::sparse), and least squares by that of [`solve`](crate::solve), where every
//! rank has some rows. Plans and [`Launch`] need no MPI; all else needs the feature `mpi`.
//!
//! Every function is collective: all ranks of the `World` call it, with the same options. If one
//! rank fails, every rank returns an error ([`Error::Rank`](crate::Error::Rank)). A panic aborts
//! the job, because the other ranks would wait forever; by default, so does an error of MPI itself.
//! Results depend on the number of ranks, but not on the number of threads or the order of
//! messages.

mod launcher;
#[cfg(feature = "mpi")]
mod mpi;
pub mod plan;

pub use self::launcher::Launch;
#[cfg(feature = "mpi")]
pub use self::mpi::*;
