//! Eigenproducts (thesis, section 1.3): the dictionary of products of eigenfunctions, their
//! orthogonalization or the products themselves as a basis, and transfer by a functional map.

mod dictionary;
mod orthogonalized;
mod product_map;
mod transfer_matrix;
mod truncated;

pub use dictionary::Eigenproducts;
pub use orthogonalized::{Orthogonalization, ProductBasis, ProductBasisOptions};
pub use product_map::ProductMap;
pub use transfer_matrix::{transform_by_columns, transform_of_all_products};
pub use truncated::TruncatedProducts;
