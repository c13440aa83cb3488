//! How good predictions are: errors, associativity, and the baselines that must be beaten.

mod baselines;
mod metrics;

pub use baselines::{Minimum, Nearest, Perceptron, Weyl};
pub use metrics::{Associativity, Errors, Predictor, associativity, errors, select};
