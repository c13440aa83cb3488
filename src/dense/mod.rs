//! Dense linear algebra on top of faer, on one thread where more threads would change the rounding.

mod eigen;
mod memory;
mod narrow;
mod qr;
mod rows;
mod svd;
mod tall;
mod triangular;

pub use eigen::{SymmetricEigen, symmetric_eigen};
pub(crate) use qr::pivots;
pub(crate) use svd::right_singular;

// For the other crates of this workspace: no part of the interface.
#[doc(hidden)]
pub use memory::{buffer, columns, filled, zeros};
#[doc(hidden)]
pub use qr::qr_least_squares;
#[doc(hidden)]
pub use rows::{ROW_BLOCK, by_pieces, copy, for_row_blocks};
#[doc(hidden)]
pub use svd::{Svd, thin_svd};
#[doc(hidden)]
pub use tall::{multiply_in_place, subtract_product, transposed_product};
#[doc(hidden)]
pub use triangular::{cholesky, divide_by_upper, lower_solve_in_place, upper_solve_in_place};
