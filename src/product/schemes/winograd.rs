use super::table::ProductKind::Gemm;
use super::table::Table;

/// Winograd's variant of Strassen (Probert 1976): 7 products, 15 additions.
pub(super) static WINOGRAD: Table = Table {
    name: "winograd",
    symmetric: false,
    blocks: (2, 2, 2),
    products: &[
        (Gemm, "a01 - a00", "b01 - b11", "c10 + c11"),
        (Gemm, "a01 + a11 - a00", "b01 - b00 - b11", "-c01 - c10 - c11"),
        (Gemm, "a00", "b00", "c00 + c01 + c10 + c11"),
        (Gemm, "a11", "b01 + b10 - b00 - b11", "c10"),
        (Gemm, "a01 + a11 - a00 - a10", "b11", "-c01"),
        (Gemm, "a01 + a11", "b01 - b00", "c01 + c11"),
        (Gemm, "a10", "b10", "c00"),
    ],
};
