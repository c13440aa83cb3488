use super::table::ProductKind::Gemm;
use super::table::Table;

/// RecursiveGEMM (thesis, algorithm 8.2).
pub(super) static CLASSICAL2: Table = Table {
    name: "classical2",
    symmetric: false,
    blocks: (2, 2, 2),
    products: &[
        (Gemm, "a00", "b00", "c00"),
        (Gemm, "a10", "b10", "c00"),
        (Gemm, "a00", "b01", "c01"),
        (Gemm, "a10", "b11", "c01"),
        (Gemm, "a01", "b00", "c10"),
        (Gemm, "a11", "b10", "c10"),
        (Gemm, "a01", "b01", "c11"),
        (Gemm, "a11", "b11", "c11"),
    ],
};
