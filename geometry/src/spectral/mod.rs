//! Eigenproducts of the Laplacian, functional maps, filters, descriptors (thesis, chapter 1).
//!
//! See docs/algorithms/spectral.md for the mathematics.

mod basis;
mod dense;
pub mod descriptors;
mod details;
mod eigenbasis;
mod eigenproducts;
mod filter;
pub mod functional_map;
mod product_basis;
mod product_map;
mod shape;
pub mod test_functions;
mod transfer;
mod transform;
mod truncated_products;

pub use basis::{Basis, relative_errors};
pub use details::{Split, split, transfer_details};
pub use eigenbasis::Eigenbasis;
pub use eigenproducts::Eigenproducts;
pub use filter::{Response, add_coefficient, dirichlet_energies, filter};
pub use product_basis::{Orthogonalization, ProductBasis, ProductBasisOptions};
pub use product_map::ProductMap;
pub use shape::{ShapeFromSpectrum, ShapeOptions, shape_from_spectrum};
pub use transfer::Transfer;
pub use transform::{transform_by_columns, transform_of_all_products};
pub use truncated_products::TruncatedProducts;
