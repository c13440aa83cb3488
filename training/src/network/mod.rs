//! Back-propagation through the network of [`catamaran_geometry::unions::network`].

mod backward;

pub use backward::{Backward, Outputs, initial_parameters};
pub(crate) use backward::{add, random_parameters};
