use super::moduli::{Moduli, Modulus};
use super::tile::{Block, DEPTH, Powers, Quarter, Residues, Slice, Tile, TileNorms, WIDTH};

/// The steps of the exact path, for one instruction set. All find the same numbers.
pub(crate) trait Kernel: Sync {
    /// Bounds of the columns of a tile.
    fn norms_f64(&self, tile: &Tile<f64>) -> TileNorms;
    /// As [`Kernel::norms_f64`].
    fn norms_f32(&self, tile: &Tile<f32>) -> TileNorms;

    /// Multiplies the columns by powers of two, rounds to integers (ties to even) of less than 2^62
    /// in magnitude, and writes the residues modulo the i-th modulus into `out[i]`;
    /// past the caches, if the kernel can, where these are too small for all of them (`far`).
    fn convert_f64(
        &self,
        tile: &Tile<f64>,
        powers: &Powers<f64>,
        moduli: &[Modulus],
        out: &mut [&mut Residues],
        far: bool,
    );
    /// As [`Kernel::convert_f64`]; the integers are of less than 2^31.
    fn convert_f32(
        &self,
        tile: &Tile<f32>,
        powers: &Powers<f32>,
        moduli: &[Modulus],
        out: &mut [&mut Residues],
        far: bool,
    );

    /// As [`Kernel::convert_f64`]; the integers are of at most 2^[`WIDE_BITS`](super::WIDE_BITS).
    fn convert_wide(
        &self,
        tile: &Tile<f64>,
        powers: &Powers<f64>,
        moduli: &[Modulus],
        out: &mut [&mut Residues],
        far: bool,
    );

    /// Rearranges residues for the left side of [`Kernel::product`].
    fn to_left(&self, right: &[Slice], left: &mut [Slice]) {
        left.copy_from_slice(right);
    }

    /// Computes the products of several panels: `residues[i]` becomes `left_i^T right` modulo one
    /// number, plus what it was if `continued`, between -128 and 127.
    fn product(&self, operands: &Operands<'_>, residues: &mut [Block<i8>]);

    /// See [`super::recombine::quarter`].
    fn recombine(
        &self,
        residues: &[&Quarter<i8>],
        moduli: &Moduli,
        rows: &[i32; WIDTH],
        columns: &[i32; WIDTH],
        out: &mut Quarter<f64>,
    );

    /// At least `count` multiplications of residues on registers alone, `None` where that means
    /// nothing; how many.
    fn spin(&self, _count: usize) -> Option<usize> {
        None
    }

    /// Prepares the calling thread for [`Kernel::product`], until the session is dropped. Sessions
    /// of one thread do not overlap.
    fn session(&self) -> Session {
        Session(None)
    }
}

/// What [`Kernel::product`] multiplies, modulo one number.
#[derive(Clone, Copy)]
pub(crate) struct Operands<'a> {
    /// From [`Kernel::to_left`]: the slices of panel after panel, as many of each as `right` has.
    pub left: &'a [Slice],
    /// The slices of a panel, at most [`DEPTH`].
    pub right: &'a [Slice],
    /// The panel of the right side that follows; it may be fetched meanwhile.
    pub next: &'a [Slice],
    pub modulus: &'a Modulus,
    /// Whether to add to the residues of earlier rows.
    pub continued: bool,
}

impl<'a> Operands<'a> {
    /// Returns the slices of each of the left panels.
    ///
    /// # Panics
    /// Unless there are `panels` of them, of the length of the right one.
    #[inline(always)]
    pub fn left_panels(&self, panels: usize) -> impl Iterator<Item = &'a [Slice]> {
        let (left, steps) = (self.left, self.right.len());
        assert!(steps <= DEPTH && left.len() == panels * steps);
        (0..panels).map(move |i| &left[i * steps..(i + 1) * steps])
    }
}

/// Undoes what [`Kernel::session`] did to the thread.
pub(crate) struct Session(pub(super) Option<fn()>);

impl Drop for Session {
    fn drop(&mut self) {
        if let Some(end) = self.0 {
            end();
        }
    }
}

/// [`Kernel::product`] of kernels that keep the sums of two panels in memory: `add` adds the
/// product of two panels to sums, `reduce` takes residues of sums.
#[inline(always)]
pub(super) fn product_by_pairs(
    operands: &Operands<'_>,
    residues: &mut [Block<i8>],
    add: impl Fn(&[Slice], &[Slice], &mut Block<i32>),
    reduce: impl Fn(&Block<i32>, &Modulus, &mut Block<i8>),
) {
    for (left, residues) in operands.left_panels(residues.len()).zip(residues) {
        let mut sums: Block<i32> = if operands.continued {
            residues.map(|quarter| quarter.map(|row| row.map(i32::from)))
        } else {
            [[[0; WIDTH]; WIDTH]; 4]
        };
        add(left, operands.right, &mut sums);
        reduce(&sums, operands.modulus, residues);
    }
}
