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
mod isospectralization;
mod lift;
mod transfer;

pub use basis::{Basis, relative_errors};
pub use details::{Split, coordinates, split, transfer_details};
pub use eigenbasis::Eigenbasis;
pub use eigenproducts::{
    Eigenproducts, Orthogonalization, ProductBasis, ProductBasisOptions, ProductMap,
    TruncatedProducts, transform_by_columns, transform_of_all_products,
};
pub use filter::{Response, add_coefficient, dirichlet_energies, filter};
pub use isospectralization::{ShapeFromSpectrum, ShapeOptions, shape_from_spectrum};
pub use lift::Lift;
pub use transfer::Transfer;
