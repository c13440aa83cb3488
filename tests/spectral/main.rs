//! Eigenproducts, functional maps, transfer and filters, on generated surfaces.

#[path = "../common/mod.rs"]
mod common;
#[path = "../common/surface.rs"]
mod surface;

mod basis;
mod filter;
mod maps;
mod theory;
mod transfer;
