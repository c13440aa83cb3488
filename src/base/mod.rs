//! What everything stands on: scalars, errors, threads, workspaces, progress, randomness.

mod blocks;
mod error;
mod par;
mod progress;
mod rng;
mod scalar;
mod version;
mod workspace;

pub use error::{Error, Result};
pub use par::{Par, Pin, Team, available_cores};
pub use progress::{Flow, Progress};
pub use rng::Rng;
pub use scalar::Real;
pub(crate) use version::second_level_cache;
pub use version::{VERSION, VersionNumber, cpu_features, version};
pub use workspace::{Arena, Workspace, release_memory};
pub(crate) use workspace::{Scratch, reserved, zeros};
