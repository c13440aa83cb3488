//! Basics for all modules: scalars, errors, threads, workspaces, progress, random numbers.

mod builder;
#[cfg(feature = "geometry")]
mod checks;
mod disjoint;
mod error;
mod memory;
mod par;
mod plain;
mod progress;
mod rng;
mod scalar;
mod search;
#[cfg(feature = "geometry")]
mod sets;
mod simd;
pub(crate) mod steps;
mod version;
mod workspace;

pub(crate) use builder::builder;
#[cfg(feature = "geometry")]
pub(crate) use checks::{at_least, at_least_zero, positive};
pub(crate) use disjoint::{Disjoint, SharedPtr};
pub use error::{Cause, Error, Result};
pub(crate) use memory::check_allocation;
pub use memory::{available_memory, check_request, limit_memory};
pub(crate) use par::{Latch, tickets};
pub use par::{Par, Pin, ThreadPool, available_cores};
pub(crate) use plain::Plain;
pub use progress::Progress;
pub(crate) use progress::Tracker;
pub use rng::Rng;
pub use scalar::Real;
pub(crate) use search::first_that;
#[cfg(feature = "geometry")]
pub(crate) use sets::Sets;
pub(crate) use simd::widest;
pub(crate) use version::data_caches;
pub use version::{VERSION, VersionNumber, cpu_features, version};
pub use workspace::{Arena, Workspace, release_memory};
pub(crate) use workspace::{Scratch, zeros};
pub(crate) use workspace::{push, reserved};
