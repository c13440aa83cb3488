//! How good predictions are: errors, associativity, regions, retrieval, and the baselines that must
//! be beaten.

mod baselines;
mod metrics;
mod regions;
mod retrieval;

pub use baselines::{Minimum, Nearest, Perceptron, Weyl};
pub use metrics::{Associativity, Errors, Predictor, associativity, errors, select};
pub use regions::{Localization, localization};
pub use retrieval::{Retrieval, retrieval};
