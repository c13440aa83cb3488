//! Basics for all modules: scalars, errors, threads, workspaces, progress, random numbers.

mod builder;
#[cfg(feature = "geometry")]
mod checks;
mod cores;
mod disjoint;
mod error;
mod float_env;
mod isa;
mod memory;
#[cfg(feature = "geometry")]
mod operations;
mod par;
mod plain;
mod pool;
mod progress;
mod rng;
mod scalar;
mod search;
#[cfg(feature = "geometry")]
mod sets;
mod simd;
pub(crate) mod steps;
mod version;
mod watch;
mod workspace;

pub(crate) use builder::builder;
#[cfg(feature = "geometry")]
pub(crate) use checks::{at_least, at_least_zero, finite, positive, within};
pub use cores::{available_cores, obey_omp_num_threads};
pub(crate) use disjoint::{Disjoint, SharedPtr};
pub use error::{Cause, Error, Result};
pub use float_env::FloatEnv;
pub use isa::{IsaLevel, isa_limit, set_isa_limit};
#[cfg(feature = "geometry")]
pub(crate) use memory::check_allocation;
pub use memory::{available_memory, check_request, limit_memory};
#[cfg(all(test, feature = "unions"))]
pub(crate) use operations::measure;
#[cfg(feature = "geometry")]
pub(crate) use operations::{apart, ask, count, spend};
#[cfg(feature = "geometry")]
pub(crate) use par::PIECE;
pub use par::Par;
pub(crate) use par::{Latch, tickets};
pub(crate) use plain::Plain;
pub use pool::{Pin, ThreadPool, release_threads, use_own_threads_only};
pub use progress::Progress;
pub(crate) use progress::Tracker;
pub use rng::Rng;
pub use scalar::Real;
pub(crate) use search::first_that;
#[cfg(feature = "geometry")]
pub(crate) use sets::Sets;
pub(crate) use simd::widest;
#[cfg(feature = "geometry")]
pub(crate) use simd::{arch, has_fused};
pub(crate) use version::data_caches;
pub use version::{VERSION, VersionNumber, cpu_features, version};
pub use workspace::{Arena, Workspace, release_memory};
pub(crate) use workspace::{Scratch, reserved, zeros};
#[cfg(feature = "geometry")]
pub(crate) use workspace::{push, repeated, room};
