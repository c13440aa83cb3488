/// `layout`: entry (i, j) is `a[i * lda + j]`.
pub const CATA_ROW_MAJOR: i32 = 101;
/// `layout`: entry (i, j) is `a[i + j * lda]`.
pub const CATA_COL_MAJOR: i32 = 102;

/// `uplo`: the triangle on and above the diagonal.
pub const CATA_UPPER: i32 = 121;
/// `uplo`: the triangle on and below the diagonal.
pub const CATA_LOWER: i32 = 122;
/// `uplo`: both, equal; with beta != 0 the old lower one is read.
pub const CATA_BOTH: i32 = 123;
