//! Results from a Gram matrix in extended precision: least squares, principal components, singular
//! values, correlations, orthonormal columns.
//!
//! All functions start from an [`ExtendedGram`](crate::rows::ExtendedGram) of A, which takes one
//! pass over the rows. Where the entries of A are exact, results are at least as accurate as those
//! of an orthogonal factorization of A in f64, as long as the condition number of A with columns of
//! norm 1 is below 2^48 or so.

mod cholesky;
mod columns;
mod condition;
mod correlation;
mod double;
mod jacobi;
mod least_squares;
mod orthogonality;
mod pairs;
mod predict;
mod principal;
mod qr;
mod refine;
mod row_space;
mod rows;
mod singular;
mod slices;
mod spread;
mod statistics;
mod tails;
#[cfg(test)]
mod tests;
mod triangular;

pub use cholesky::{PivotedCholesky, Pivoting};
pub use correlation::correlation;
pub use double::DoubleDouble;
pub use least_squares::{LeastSquares, LeastSquaresOptions, RankDeficiency};
pub use orthogonality::{Orthogonality, orthogonality};
pub use pairs::sum_of_pairs;
pub use predict::{Interval, LinearModel, Uncertainty};
pub use principal::{Components, PrincipalComponents, PrincipalComponentsOptions};
pub use qr::GramQr;
#[cfg(feature = "mpi")]
pub(crate) use rows::named_by_matrix;
pub use rows::{
    JoinedRows, check_weights, lstsq, lstsq_rows, pca, pca_rows, singular_values,
    singular_values_rows,
};
pub use singular::SingularValues;
#[cfg(feature = "mpi")]
pub(crate) use spread::Spread;
pub use tails::{f_probability, t_probability, t_quantile};
