//! Chapter 6 of the thesis, measured again: figures 6.5, 6.6, 6.9 to 6.11, tables 6.1 and 6.2,
//! faithful and robust side by side, on curves of the generator of section 6.4.1.
//!
//! The thesis' meshes are not available, so its numbers only serve as orientation. All shares are
//! of all runs, including those that failed.

mod distances;
mod limits;
mod literal;
mod meshes;
mod orders;
mod runs;
mod summary;

pub use limits::{Distances, LIMITS_HEAD, limit_tables, measure_limits};
pub use meshes::{Surface, surfaces};
pub use orders::{ORDERS_HEAD, Ordered, measure_orders, order_tables};
pub use runs::{Method, Run, SIZES, measure};
pub use summary::{Cell, bars, cells, distance_tables, failures, order_table, plots};
