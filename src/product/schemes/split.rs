use super::table::ProductKind::{Gemm, Syrk};
use super::table::Table;

/// Two triangles and the block between them (thesis, fig. 8.2): what AtA-S splits by.
pub(super) static SPLIT: Table = Table {
    name: "split",
    symmetric: true,
    blocks: (1, 2, 2),
    products: &[
        (Syrk, "a00", "b00", "c00"),
        (Gemm, "a01", "b00", "c10"),
        (Syrk, "a01", "b01", "c11"),
    ],
};
