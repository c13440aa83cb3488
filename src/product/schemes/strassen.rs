use super::table::ProductKind::Gemm;
use super::table::Table;

/// Strassen 1969: 7 products, 18 additions.
pub(super) static STRASSEN: Table = Table {
    name: "strassen",
    symmetric: false,
    blocks: (2, 2, 2),
    products: &[
        (Gemm, "a00 + a11", "b00 + b11", "c00 + c11"),
        (Gemm, "a10 - a11", "b10 + b11", "c00"),
        (Gemm, "a01 - a00", "b00 + b01", "c11"),
        (Gemm, "a00 + a10", "b11", "c01 - c00"),
        (Gemm, "a00", "b01 - b11", "c01 + c11"),
        (Gemm, "a11", "b10 - b00", "c00 + c10"),
        (Gemm, "a01 + a11", "b00", "c10 - c11"),
    ],
};
