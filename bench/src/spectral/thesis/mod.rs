//! Tables 1.2 to 1.6 on the thesis' own shapes: functions transferred along the points that
//! `catamaran transfer A B` finds, and from landmarks.

mod data;
mod matlab;
mod pipelines;
mod table;

pub use data::{Data, SETS, Set};
pub use table::{Table, measure};
