//! Chapter 1 of the thesis, measured again: theorem 1.1, figures 1.4 to 1.6 and 1.10, tables 1.1 to 1.4.
//!
//! The thesis' shapes can't be had here: the protocol is the same, on other shapes, so that its numbers stand beside
//! ours for the order of the methods, not for their values.

mod approximation;
mod frequencies;
mod ranks;
mod shapes;
mod signals;
mod stability;
mod table;
mod transfer;

pub use approximation::approximation;
pub use frequencies::{eigenpowers, frequencies};
pub use ranks::ranks;
pub use shapes::{Pair, Shape, Shapes};
pub use stability::stability;
pub use table::{Table, average};
pub use transfer::{Setting, transfer};
