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

mod ata2;
mod classical;
mod kgp;
mod rxtx;
mod split;
mod strassen;
mod table;
mod winograd;

use std::fmt;
use std::sync::LazyLock;

use ata2::ATA2;
use classical::CLASSICAL2;
use kgp::{KGP3, KGP4};
use rxtx::RXTX;
use split::SPLIT;
use strassen::STRASSEN;
pub use table::{ProductKind, Scheme, SchemeProduct, Term};
use winograd::WINOGRAD;

/// The name of a scheme.
///
/// ```
/// use catamaran::product::schemes::SchemeId;
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
