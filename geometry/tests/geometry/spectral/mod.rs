//! Eigenproducts, functional maps, transfer and filters, on generated surfaces.

mod basis;
mod filter;
mod maps;
mod theory;
mod transfer;
