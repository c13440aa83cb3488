use super::table::ProductKind::{Gemm, Syrk};
use super::table::Table;

/// The 2 x 2 recursion of AtA (thesis, eq. 8.2 and algorithm 8.1): four squares, two products.
pub(super) static ATA2: Table = Table {
    name: "ata2",
    symmetric: true,
    blocks: (2, 2, 2),
    products: &[
        (Syrk, "a00", "b00", "c00"),
        (Syrk, "a10", "b10", "c00"),
        (Syrk, "a01", "b01", "c11"),
        (Syrk, "a11", "b11", "c11"),
        (Gemm, "a01", "b00", "c10"),
        (Gemm, "a11", "b10", "c10"),
    ],
};
