//! Back-propagation through the transformer of [`catamaran::unions::network`].

mod attention;
mod backward;

pub use backward::{Backward, initial_parameters};
