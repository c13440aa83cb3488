//! Bilinear schemes as data: each is a table of products of sums of blocks, and one engine
//! (`execute/recursive.rs`) runs them all. The tests prove every table by the Brent equations.
//!
//! A table splits A into `inner x left` blocks `a<t><i>`, B into `inner x right` blocks `b<t><j>`
//! and C into `left x right` blocks `c<i><j>`, and computes `c<i><j> = sum_t a<t><i>^T b<t><j>`:
//! all of C for a general scheme, the blocks with `i >= j` (on the diagonal: their lower triangle)
//! for a symmetric one. A symmetric scheme holds for `A != B` too.
//!
//! The coefficients are those of the files named by each table in the collections of the authors,
//! turned from upper `X Y^T` to lower `A^T B` (`X = B^T`, `Y = A^T`), with the products in an order
//! that lets each sum be made from the one before it wherever that is cheaper.

use std::fmt;
use std::sync::LazyLock;

/// The part of a product of two sums of blocks that is used.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub enum ProductKind {
    /// All of it.
    Gemm,
    /// Left and right are different sums, and only the lower triangle is used.
    Gemmt,
    /// Left and right are the same sum (when A = B), and only the lower triangle is used.
    Syrk,
    /// Left and right are the same sum, and all of it is used: half is computed, half mirrored.
    SyrkFull,
}
use ProductKind::{Gemm, Gemmt, Syrk, SyrkFull};

/// `coefficient * block(row, col)`.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Term {
    /// Small integer, not zero.
    pub coefficient: i8,
    /// Block row.
    pub row: usize,
    /// Block column.
    pub col: usize,
}

/// One product of a scheme: `sum(outputs) += (sum left)^T (sum right)`.
#[derive(Debug, Clone)]
pub struct SchemeProduct {
    /// The part of the product that is used.
    pub kind: ProductKind,
    /// Sum of blocks of A.
    pub left: Vec<Term>,
    /// Sum of blocks of B.
    pub right: Vec<Term>,
    /// Blocks of C that it is added to.
    pub outputs: Vec<Term>,
}

/// A bilinear scheme for one level of recursion.
#[derive(Debug, Clone)]
pub struct Scheme {
    /// Its name.
    pub name: &'static str,
    /// Whether only the lower triangle of C is computed.
    pub symmetric: bool,
    /// Block rows of A and B.
    pub inner: usize,
    /// Block columns of A, block rows of C.
    pub left: usize,
    /// Block columns of B and of C.
    pub right: usize,
    /// The products, in the order in which they are computed.
    pub products: Vec<SchemeProduct>,
}

/// The name of a scheme.
///
/// ```
/// use catamaran::product::scheme::SchemeId;
///
/// let strassen = SchemeId::Strassen.scheme();
/// assert_eq!(strassen.products.len(), 7);
/// ```
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
#[non_exhaustive]
pub enum SchemeId {
    /// Symmetric: two triangles and the block between them, over all rows; no additions.
    Split,
    /// Symmetric, thesis algorithm 8.1: four triangles and two products; no additions.
    Ata2,
    /// Symmetric, 4 x 4 blocks, RXTX.
    Rxtx,
    /// Symmetric, 4 x 4 blocks, Khoruzhii, Gelss and Pokutta, sparse.
    Kgp4,
    /// Symmetric, 3 x 3 blocks, Khoruzhii, Gelss and Pokutta.
    Kgp3,
    /// General, thesis algorithm 8.2 (RecursiveGEMM): eight products, no additions.
    Classical2,
    /// General, Strassen.
    Strassen,
    /// General, Winograd's variant.
    Winograd,
}

impl SchemeId {
    /// Every scheme.
    pub const ALL: [Self; 8] = [
        Self::Split,
        Self::Ata2,
        Self::Rxtx,
        Self::Kgp4,
        Self::Kgp3,
        Self::Classical2,
        Self::Strassen,
        Self::Winograd,
    ];

    /// Returns the table of the scheme.
    pub fn scheme(self) -> &'static Scheme {
        static PARSED: [LazyLock<Scheme>; 8] = [
            LazyLock::new(|| SPLIT.parse()),
            LazyLock::new(|| ATA2.parse()),
            LazyLock::new(|| RXTX.parse()),
            LazyLock::new(|| KGP4.parse()),
            LazyLock::new(|| KGP3.parse()),
            LazyLock::new(|| CLASSICAL2.parse()),
            LazyLock::new(|| STRASSEN.parse()),
            LazyLock::new(|| WINOGRAD.parse()),
        ];
        &PARSED[self as usize]
    }
}

impl fmt::Display for SchemeId {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(self.scheme().name)
    }
}

impl Scheme {
    /// Returns whether the scheme replaces products by additions, which adds to the rounding error.
    ///
    /// ```
    /// use catamaran::product::scheme::SchemeId;
    ///
    /// let fast = SchemeId::ALL.into_iter().filter(|id| id.scheme().is_fast()).count();
    /// assert!(!SchemeId::Classical2.scheme().is_fast() && fast == 5);
    /// ```
    pub fn is_fast(&self) -> bool {
        self.products.iter().any(|p| p.left.len() > 1 || p.right.len() > 1 || p.outputs.len() > 1)
    }

    /// Returns the multiplications of one level over the classical count, where a half product
    /// counts half.
    ///
    /// ```
    /// use catamaran::product::scheme::SchemeId;
    ///
    /// assert_eq!(SchemeId::Strassen.scheme().flop_ratio(), 7.0 / 8.0);
    /// ```
    pub fn flop_ratio(&self) -> f64 {
        let cost = |p: &SchemeProduct| if p.kind == Gemm { 2.0 } else { 1.0 };
        let ours: f64 = self.products.iter().map(cost).sum();
        let columns = if self.symmetric { self.left } else { 2 * self.right };
        ours / (self.inner * self.left * columns) as f64
    }
}

/// A scheme as written down: sums in the notation of the module's documentation.
struct Table {
    name: &'static str,
    symmetric: bool,
    /// inner, left, right
    blocks: (usize, usize, usize),
    products: &'static [(ProductKind, &'static str, &'static str, &'static str)],
}

impl Table {
    fn parse(&self) -> Scheme {
        let (inner, left, right) = self.blocks;
        let product = |&(kind, l, r, o): &(ProductKind, &str, &str, &str)| SchemeProduct {
            kind,
            left: parse_sum(l, 'a'),
            right: parse_sum(r, 'b'),
            outputs: parse_sum(o, 'c'),
        };
        Scheme {
            name: self.name,
            symmetric: self.symmetric,
            inner,
            left,
            right,
            products: self.products.iter().map(product).collect(),
        }
    }
}

/// Parses `"a00 + a11 - 2a01"`; the tables are constants and the tests parse them all.
fn parse_sum(sum: &str, letter: char) -> Vec<Term> {
    let mut sign = 1;
    let mut terms = Vec::new();
    for word in sum.split_whitespace() {
        match word {
            "+" => sign = 1,
            "-" => sign = -1,
            _ => {
                let (unsigned, sign) = match word.strip_prefix('-') {
                    Some(rest) => (rest, -1),
                    None => (word, sign),
                };
                let (factor, index) = unsigned.split_once(letter).expect("a block name");
                let digit = |i: usize| usize::from(index.as_bytes()[i] - b'0');
                let factor: i8 = if factor.is_empty() { 1 } else { factor.parse().expect("int") };
                terms.push(Term { coefficient: sign * factor, row: digit(0), col: digit(1) });
            }
        }
    }
    terms
}

/// Two triangles and the block between them (thesis, fig. 8.2): what AtA-S splits by.
static SPLIT: Table = Table {
    name: "split",
    symmetric: true,
    blocks: (1, 2, 2),
    products: &[
        (Syrk, "a00", "b00", "c00"),
        (Gemm, "a01", "b00", "c10"),
        (Syrk, "a01", "b01", "c11"),
    ],
};

/// RecursiveGEMM (thesis, algorithm 8.2).
static CLASSICAL2: Table = Table {
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

/// Strassen 1969: 7 products, 18 additions.
static STRASSEN: Table = Table {
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

/// Winograd's variant of Strassen (Probert 1976): 7 products, 15 additions.
static WINOGRAD: Table = Table {
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

/// The 2 x 2 recursion of AtA (thesis, eq. 8.2 and algorithm 8.1): four squares, two products.
static ATA2: Table = Table {
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

/// RXTX (Rybin, Zhang and Luo, arXiv 2505.09814): 26 general products and 8 squares on 4 x 4
/// blocks.
static RXTX: Table = Table {
    name: "rxtx",
    symmetric: true,
    blocks: (4, 4, 4),
    products: &[
        (Gemm, "a11 + a21 - a22", "b11 + b22", "c11 + c21 - c22"),
        (Gemm, "a02 + a03 + a11 + a21 - a12 - a13 - a22", "b11", "c22 - c21"),
        (Syrk, "a20", "b20", "c00"),
        (Gemm, "a13", "b02 + b10 + b12", "c32"),
        (Gemmt, "a12", "b11 + b12 + b32", "c22"),
        (Gemm, "a12 - a32", "b32", "c20 + c32 - c22 - c30"),
        (Syrk, "a10", "b10", "c00"),
        (Gemm, "a32 + a33 - a12", "b32 - b10", "c20 + c32 - c30"),
        (Gemm, "a11 + a21", "b22", "c22 + c32 - c10 - c11 - c21 - c30"),
        (Gemm, "a23 - a11 - a21", "b10 + b22", "c32 - c10 - c30"),
        (Gemm, "a02", "b01 + b02 - b31", "c21 - c31"),
        (Gemm, "a11 + a21 + a32 + a33 - a12 - a13 - a23", "b10", "c32 - c30"),
        (Syrk, "a03", "b03", "c33"),
        (Gemm, "a33", "b30 + b32 - b00", "c30 - c20"),
        (Gemm, "a03 - a13", "b02", "c21 + c32 - c22 - c31"),
        (Gemm, "a02 + a03 - a13", "b02 - b11", "c22 + c31 - c21"),
        (Syrk, "a23", "b23", "c33"),
        (Gemm, "a22 + a32 + a33", "b10 + b30 - b31", "c20"),
        (Gemm, "a02 + a03 + a23", "b01 + b11 - b00", "c31"),
        (Gemm, "a01 + a23", "b00 + b21 - b01 - b11", "c10 + c30 + c31"),
        (Syrk, "a00", "b00", "c00"),
        (Gemm, "a23", "b01 + b11 + b20 + b22 - b00 - b21", "c10 + c30"),
        (Gemm, "a03 + a33 - a01", "b00", "c30 + c31"),
        (Gemmt, "a01 + a21 - a22", "b21 - b11", "c11"),
        (Syrk, "a33", "b33", "c33"),
        (Gemm, "a01", "b01 + b11 - b21", "c10 + c11 + c30 + c31"),
        (Gemm, "a02 - a33", "b00 - b31", "c20 + c31"),
        (Gemm, "a21 + a31 - a23", "b20 - b10", "c10"),
        (Gemm, "a02 + a32 - a31", "b31", "c20 + c21"),
        (Syrk, "a13", "b13", "c33"),
        (Gemm, "a31", "b10 + b30 - b20", "c10 + c11 + c20 + c21"),
        (Syrk, "a30", "b30", "c00"),
        (Gemm, "a22 + a31", "b20 + b31 - b10 - b30", "c11 + c20 + c21"),
        (Gemm, "a22", "b10 + b21 + b22 + b30 - b20 - b31", "c11 + c21"),
    ],
};

/// Sparse member of the orbit of the 4 x 4 scheme of Khoruzhii, Gelss and Pokutta
/// (arXiv 2511.10786): 22 full and 12 half products, every coefficient +-1.
static KGP4: Table = Table {
    name: "kgp",
    symmetric: true,
    blocks: (4, 4, 4),
    products: &[
        (Syrk, "a13", "b13", "c33"),
        (Gemm, "a12 - a13", "b10 - b11", "-c21 - c22"),
        (Gemmt, "a22 - a12", "b10 + b12 - b11", "-c22"),
        (Gemm, "a22 - a13", "b10 + b12 + b22 - b11", "c21 + c22 + c31"),
        (Gemm, "a22", "b01 + b10 + b12 + b22 - b11 - b21", "-c21 - c31"),
        (Syrk, "a23", "b23", "c33"),
        (Syrk, "a30", "b30", "c00"),
        (Gemm, "a13 + a32", "b10 - b31", "c30 - c21 - c22 - c32"),
        (Gemm, "a32", "b02 + b10 + b32 - b31", "c22 + c32 - c20 - c30"),
        (Syrk, "a33", "b33", "c33"),
        (Gemm, "a02 - a03", "b00 - b01", "c20 - c10"),
        (Gemm, "a01 + a02 - a03 - a31", "b00 + b10", "c10"),
        (Gemm, "a31", "b00 + b10 + b20 + b30", "c10"),
        (Gemm, "a01 + a02 - a03 - a11", "b01 + b10", "c20 + c21 - c10"),
        (Syrk, "a20", "b20", "c00"),
        (Gemm, "a01 + a02 - a03 - a11 - a12 - a32", "b10", "-c20 - c21"),
        (Syrk, "a00", "b00", "c00"),
        (Gemm, "a13", "b10 + b12 + b22 - b31", "c21 + c22 + c31 + c32"),
        (Gemm, "a22 - a23", "b20 - b21", "c11 + c31"),
        (Gemmt, "a21 + a22 - a11 - a23", "-b21 - b31", "-c11"),
        (Gemmt, "a11", "b01 + b11 + b21 + b31", "c11"),
        (Gemm, "a03 + a22", "b20 - b01", "c20 - c10 - c11 - c31"),
        (Gemm, "a31 - a03 - a21 - a22", "b20", "-c10 - c11 - c30 - c31"),
        (Gemm, "a23 + a31 - a21 - a22", "b20 + b31", "c11 + c30 + c31"),
        (Gemm, "a23 + a31 - a13 - a21 - a22 - a33", "-b31", "c30 + c31"),
        (Gemm, "a32 - a33", "b31 - b30", "c30 - c32"),
        (Gemm, "a03 - a33", "b31 - b22 - b30 - b32", "c32"),
        (Gemm, "a03 + a23 - a13 - a33", "b22", "c32"),
        (Gemm, "a32 - a03", "b31 - b02 - b30 - b32", "c32 - c20 - c30"),
        (Gemm, "a01 - a03 - a11 - a22", "b01", "c10 + c11 - c20 - c21"),
        (Syrk, "a03", "b03", "c33"),
        (Gemm, "a03", "b20 + b31 - b00 - b02 - b30 - b32", "-c20 - c30"),
        (Syrk, "a10", "b10", "c00"),
        (Gemmt, "a02 - a32", "b02", "c22"),
    ],
};

/// Khoruzhii, Gelss and Pokutta (arXiv 2511.10786): 17 products on 3 x 3 blocks.
static KGP3: Table = Table {
    name: "kgp3",
    symmetric: true,
    blocks: (3, 3, 3),
    products: &[
        (Gemm, "a02 - a22", "b20 - b21", "-c10 - c20"),
        (Syrk, "a11", "b11", "c11"),
        (Gemm, "a01 + a22 - a02 - a21", "b10 + b21 - b20", "c10"),
        (SyrkFull, "a21", "b21", "c10 + c11"),
        (SyrkFull, "a22", "b22", "c20 + c21 + c22"),
        (SyrkFull, "a12", "b12", "c21 + c22"),
        (Syrk, "a00", "b00", "c00"),
        (Syrk, "a20", "b20", "c00"),
        (Gemm, "a11 + a21 - a12 - a22", "b10", "c10"),
        (Gemm, "a01 - a02", "b00 + b20 + b22 - b10 - 2b21", "-c20 - c21"),
        (Gemm, "a01 - a02 - a22", "b21 - b22", "-c20 - c21"),
        (Gemm, "a02 + a12", "b00 + b20 - b01 - b21", "c10 + c20"),
        (Syrk, "a10", "b10", "c00"),
        (SyrkFull, "a01", "b01", "c10 + c11 + c20 + c21"),
        (Gemm, "a01 - a02 - a12", "b00 + b20 - b01 - b10 - b21", "c10 + c20 + c21"),
        (Gemm, "a12", "b00 + b11 + b20 - b01 - b10 - b12 - b21", "c21"),
        (Syrk, "a02", "b02", "c22"),
    ],
};
