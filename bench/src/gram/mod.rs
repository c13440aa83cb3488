//! Applications of A^T A: least squares, singular values, principal components and orthonormal
//! bases from an extended Gram matrix, beside numpy, scipy, statsmodels and scikit-learn.

mod digits;
mod gram_time;
mod least_squares;
mod orthogonality;
pub mod ours;
mod principal_components;
mod singular_values;
mod turns;
pub mod walsh;

/// The data sets of `tests/common/nist`.
#[path = "../../../tests/common/nist.rs"]
pub mod nist;

pub use digits::digits;
pub use gram_time::gram_time;
pub use least_squares::least_squares;
pub use orthogonality::orthogonality;
pub use principal_components::principal_components;
pub use singular_values::singular_values;
pub use turns::Turns;
