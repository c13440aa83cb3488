//! Basics for all modules: scalars, errors, threads, workspaces, progress, random numbers.

mod blocks;
mod builder;
mod byte_size;
mod checks;
mod cores;
mod disjoint;
mod error;
mod float_env;
mod huge_pages;
mod isa;
mod memory;
mod operations;
mod options;
mod par;
mod plain;
mod pool;
mod progress;
mod rng;
mod scalar;
mod search;
mod sets;
mod simd;
mod split;
pub(crate) mod steps;
mod triangle;
mod version;
mod watch;
mod workspace;

pub use blocks::block_rows;
pub(crate) use byte_size::byte_size;
pub(crate) use checks::finite_weights;
pub use cores::{available_cores, obey_omp_num_threads};
pub(crate) use disjoint::{Disjoint, SharedPtr};
pub use error::{Cause, Error, Result};
pub use float_env::FloatEnv;
pub use isa::{IsaLevel, isa_limit, set_isa_limit};
pub use memory::{available_memory, check_request, limit_memory};
pub(crate) use memory::{check_allocation, filled, with_room};
pub use options::Field;
pub(crate) use par::PIECE;
pub use par::Par;
pub(crate) use plain::Plain;
pub use pool::{Pin, ThreadPool, release_threads, use_own_threads_only};
#[cfg(feature = "mpi")]
pub(crate) use pool::{core_ids, share_cores};
pub use progress::Progress;
pub use rng::Rng;
pub use scalar::Real;
pub(crate) use search::first_that;
pub(crate) use simd::widest;
pub(crate) use split::{even_part, even_start};
pub use triangle::triangle_len;
pub(crate) use triangle::{triangle_row_of, triangle_rows};
pub(crate) use version::data_caches;
pub use version::{VERSION, VersionNumber, cpu_features, version};
pub use workspace::{Arena, Workspace, release_memory};

// For the other crates of this workspace: no part of the interface.
#[doc(hidden)]
pub use crate::{builder, options};
#[doc(hidden)]
pub use checks::{above, at_least, at_least_zero, finite, positive, within};
#[cfg(debug_assertions)]
#[doc(hidden)]
pub use operations::measure;
#[doc(hidden)]
pub use operations::{apart, ask, count, spend};
#[doc(hidden)]
pub use par::{Latch, tickets};
#[doc(hidden)]
pub use progress::Tracker;
#[doc(hidden)]
pub use sets::Sets;
#[doc(hidden)]
pub use simd::{arch, has_fused};
#[doc(hidden)]
pub use workspace::{Scratch, push, repeated, reserved, room, zeros};
