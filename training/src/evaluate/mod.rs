//! How good predictions are: errors, associativity, and baselines.
