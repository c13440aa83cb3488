//! Eigenproducts of the Laplacian, functional maps, filters, descriptors (thesis, chapter 1).
