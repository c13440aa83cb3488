//! A^T A and its kernels: against oracles, exact values and invariants.

mod ata;
mod backends;
mod batched;
mod column_errors;
#[path = "../common/mod.rs"]
mod common;
mod complex;
mod exact;
mod extended;
mod native;
mod plan;
mod properties;
mod schemes;
mod stream;
