//! Sparse symmetric matrices: inner products, products, solutions and eigenpairs
//! (docs/algorithms/eigen.md, docs/algorithms/cholesky.md).

mod around;
mod certificate;
mod check;
mod cholesky;
mod components;
mod count;
mod eigenpairs;
mod eigs;
mod lanczos;
mod mass;
mod options;
#[cfg(test)]
mod path;
mod problem;
mod product;
mod select;
mod shifted;
mod slices;
mod small;
mod space;
mod two_level;

#[cfg(feature = "mpi")]
pub(crate) use check::check_mirrored;
pub use cholesky::{Cholesky, CholeskyOptions, Triangle};
#[cfg(feature = "mpi")]
pub(crate) use cholesky::{paired, separator, shared};
pub use components::free_components;
pub use count::count_below;
pub use eigenpairs::Eigenpairs;
pub use eigs::eigs;
#[cfg(feature = "mpi")]
pub(crate) use eigs::{check as check_problem, is_dense, one_window, without_iteration};
pub use mass::Mass;
pub use options::EigenOptions;
#[cfg(feature = "mpi")]
pub(crate) use problem::{Outline, Problem};
pub use product::multiply;
#[cfg(feature = "mpi")]
pub(crate) use product::{multiply_by_differences, multiply_magnitudes, row_sum};
pub use slices::eigs_sliced;
#[cfg(feature = "mpi")]
pub(crate) use space::{Pencil, Shifts};
/// The sparse matrix, by rows, from crate sprs.
pub use sprs::{CsMat, CsMatView};
pub use two_level::eigs_two_level;

// For the other crates of this workspace: no part of the interface.
#[doc(hidden)]
pub use cholesky::{Factor, Symbolic};
#[doc(hidden)]
pub use select::select;
#[doc(hidden)]
pub use shifted::Shifted;
#[doc(hidden)]
pub use space::{InnerSpace, Inverse};
