//! Back-propagation through the network of [`catamaran::unions::network`].

mod backward;

pub use backward::{Backward, Outputs, initial_parameters};
pub(crate) use backward::{add, random_parameters};
