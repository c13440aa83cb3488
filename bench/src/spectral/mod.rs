//! Chapter 1 of the thesis, measured again: theorem 1.1, figures 1.4 to 1.6, 1.10 to 1.17, 1.19 and
//! 1.20, tables 1.1 to 1.6.
//!
//! The protocol is the thesis', on other shapes, so that its numbers are comparable with ours in
//! the order of the methods, not in their values. [`thesis`] has tables 1.2 to 1.6 on the thesis'
//! shapes, as far as they are public.

mod approximation;
mod cases;
mod filters;
mod frequencies;
mod functions;
mod noise;
mod prods;
mod ranks;
mod refinement;
mod shapes;
mod signals;
mod stability;
mod table;
pub mod thesis;
mod transfer;

pub use approximation::approximation;
pub use cases::{Case, Known, METHODS, approximated, colours, heat, transferred};
pub use filters::filters;
pub use frequencies::{Frequencies, eigenpowers, frequencies};
pub use noise::{PRODUCTS, cardinality, noise};
pub use ranks::ranks;
pub use refinement::{REFINEMENTS, refinement};
pub use shapes::{Pair, Shape, Shapes, nearest_vertices};
pub use stability::{MOST, sizes, stability};
pub use table::{Table, average};
pub use transfer::{SETTINGS, Setting, transfer};
