//! The execution of the plans, over MPI.

mod bricks;
mod call;
mod columns;
mod components;
mod cyclic;
mod deal;
mod digits;
mod domains;
mod eigen;
mod exchange;
mod factor;
mod form;
mod gram;
mod memory;
mod moves;
mod node;
mod ortho;
mod pairs;
mod pending_send;
mod reduction;
mod requests;
mod root;
mod rows;
mod same;
mod scatter;
mod spread;
mod stream;
mod symmetric;
mod tags;
mod transfer;
mod travel;
mod tree;
mod verify;
mod version;
mod world;

pub use bricks::ata_bricks;
pub use columns::ata_columns;
pub use cyclic::{CyclicMut, CyclicRef, aat_cyclic, ata_cyclic};
pub use eigen::eigs;
pub use exchange::gather_rows;
pub use gram::lstsq;
pub use node::Node;
pub use ortho::{cholesky_qr, gram_schmidt, gram_schmidt_in_place};
pub use root::{ata_deal, ata_root, ata_tree};
pub use rows::{ata_rows, sum_symmetric};
pub use same::agree_rows;
pub use stream::{agree_bounds, merge_accumulators};
pub use symmetric::Symmetric;
pub use verify::{Distributed, verify};
pub use version::mpi_version;
pub use world::{MpiReal, Traffic, World};

// For the other crates of this workspace: no part of the interface.
#[doc(hidden)]
pub use ortho::watched_cholesky_qr;
#[doc(hidden)]
pub use same::agree_numbers;
#[doc(hidden)]
pub use world::Operation;
