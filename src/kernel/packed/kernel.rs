//! The steps of a packed product behind one trait, instantiated for an instruction set and a
//! scalar.

use super::geometry::{Area, Geometry};
use super::in_place::InPlace;
use super::operands::Source;
use super::pack::Panels;
use super::tile::Row;

/// The steps of a packed product, for one instruction set and scalar.
pub(crate) trait Kernel<T>: Sync {
    /// Returns the extents of the tiles.
    fn geometry(&self) -> Geometry;

    /// Computes a row of tiles, and writes it to the targets if it is complete.
    ///
    /// # Safety
    /// The sides hold `steps` rows, the sums a tile per panel (one tile unless `kept`); nobody else
    /// uses the sums and these entries of the targets.
    unsafe fn multiply_row(&self, row: &Row<'_, T>);

    /// Computes the entries of the rectangle that the targets want, and writes them if they are
    /// complete.
    ///
    /// # Safety
    /// The sides hold `steps` rows and these columns, the sums all tiles (one tile unless `kept`);
    /// nobody else uses the sums and these entries of the targets.
    unsafe fn multiply_in_place(&self, product: &InPlace<'_, T>);

    /// Writes the panels that hold columns `area.cols` of the sum of `sources`, rows `area.rows`:
    /// the i-th panel at `out.start + i * out.stride`, row after row, WIDTH columns each. Entries
    /// that a source lacks are zero, and so are the columns that pad the last panel.
    ///
    /// # Safety
    /// `out` has room for all panels.
    unsafe fn pack(&self, sources: &[Source<'_, T>], area: &Area, out: Panels<T>);
}

/// Instantiates the algorithm: `instantiate!(Kernel, scalar, Vectors, attributes)`. The kernel
/// exists only where the CPU has the instructions.
macro_rules! instantiate {
    ($kernel:ident, $t:ident, $vectors:ty, $($enable:tt)*) => {
        impl super::kernel::Kernel<$t> for $kernel {
            fn geometry(&self) -> super::geometry::Geometry {
                use super::vectors::Vectors as V;
                const { assert!(<$vectors>::WIDTH.is_multiple_of(<$vectors>::ROWS)) };
                super::geometry::Geometry {
                    lanes: <$vectors as V>::LANES,
                    rows: <$vectors as V>::ROWS,
                    width: <$vectors as V>::WIDTH,
                    tuning: const { &<$vectors as V>::TUNING },
                }
            }

            unsafe fn multiply_row(&self, row: &super::tile::Row<'_, $t>) {
                $($enable)*
                unsafe fn multiply_row(row: &super::tile::Row<'_, $t>) {
                    use super::tile::multiply_row;
                    use super::vectors::Vectors as V;
                    // SAFETY: the attributes of this function enable the instructions of the
                    // vectors; operands, sums and targets are those of the method, which has the
                    // same contract.
                    unsafe { multiply_row::<$vectors, { <$vectors as V>::ROWS }, { <$vectors as V>::COUNT }>(row) }
                }
                // SAFETY: `self` exists, so `new` has found the instructions; the contract of the
                // method is that of the function.
                unsafe { multiply_row(row) }
            }

            unsafe fn multiply_in_place(&self, product: &super::in_place::InPlace<'_, $t>) {
                $($enable)*
                unsafe fn multiply_in_place(product: &super::in_place::InPlace<'_, $t>) {
                    use super::vectors::Vectors as V;
                    const ROWS: usize = <$vectors as V>::ROWS;
                    const COUNT: usize = <$vectors as V>::COUNT;
                    // SAFETY: the attributes of this function enable the instructions of the
                    // vectors; operands, sums and targets are those of the method, which has the
                    // same contract.
                    unsafe { super::in_place::multiply_in_place::<$vectors, ROWS, COUNT>(product) }
                }
                // SAFETY: `self` exists, so `new` has found the instructions; the contract of the
                // method is that of the function.
                unsafe { multiply_in_place(product) }
            }

            unsafe fn pack(
                &self,
                sources: &[super::operands::Source<'_, $t>],
                area: &super::geometry::Area,
                out: super::pack::Panels<$t>,
            ) {
                $($enable)*
                unsafe fn pack(
                    sources: &[super::operands::Source<'_, $t>],
                    area: &super::geometry::Area,
                    out: super::pack::Panels<$t>,
                ) {
                    // SAFETY: the attributes of this function enable the instructions of the
                    // vectors; `out` has room for all panels by the contract of the method.
                    unsafe { super::pack::pack::<$vectors>(sources, area, out) }
                }
                // SAFETY: `self` exists, so `new` has found the instructions; the contract of the
                // method is that of the function.
                unsafe { pack(sources, area, out) }
            }
        }
    };
}
pub(super) use instantiate;
