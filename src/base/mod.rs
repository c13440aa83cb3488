//! Basics for all modules: scalars, errors, threads, workspaces, progress, random numbers.

mod builder;
mod checks;
mod cores;
mod disjoint;
mod error;
mod float_env;
mod isa;
mod memory;
mod operations;
mod par;
mod plain;
mod pool;
mod progress;
mod rng;
mod scalar;
mod search;
mod sets;
mod simd;
pub(crate) mod steps;
mod version;
mod watch;
mod workspace;

#[doc(hidden)]
pub use crate::builder;
#[doc(hidden)]
pub use checks::{at_least, at_least_zero, finite, positive, within};
pub use cores::{available_cores, obey_omp_num_threads};
pub(crate) use disjoint::{Disjoint, SharedPtr};
pub use error::{Cause, Error, Result};
pub use float_env::FloatEnv;
pub use isa::{IsaLevel, isa_limit, set_isa_limit};
pub(crate) use memory::check_allocation;
pub use memory::{available_memory, check_request, limit_memory};
#[cfg(debug_assertions)]
#[doc(hidden)]
pub use operations::measure;
#[doc(hidden)]
pub use operations::{apart, ask, count, spend};
pub(crate) use par::PIECE;
pub use par::Par;
#[doc(hidden)]
pub use par::{Latch, tickets};
pub(crate) use plain::Plain;
pub use pool::{Pin, ThreadPool, release_threads, use_own_threads_only};
pub use progress::Progress;
#[doc(hidden)]
pub use progress::Tracker;
pub use rng::Rng;
pub use scalar::Real;
pub(crate) use search::first_that;
#[doc(hidden)]
pub use sets::Sets;
pub(crate) use simd::widest;
#[doc(hidden)]
pub use simd::{arch, has_fused};
pub(crate) use version::data_caches;
pub use version::{VERSION, VersionNumber, cpu_features, version};
pub use workspace::{Arena, Workspace, release_memory};
#[doc(hidden)]
pub use workspace::{Scratch, reserved, zeros};
#[doc(hidden)]
pub use workspace::{push, repeated, room};
