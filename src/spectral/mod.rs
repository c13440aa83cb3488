//! Eigenproducts of the Laplacian, functional maps, filters, descriptors (thesis, chapter 1).

pub mod descriptors;
pub mod test_functions;
