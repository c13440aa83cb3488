use super::lane_set::LaneSet;
use super::moduli::{Moduli, Modulus};
use super::tile::{
    DEPTH, PANEL, PanelBlock, Powers, Residues, Slice, Square, Tile, TileNorms, WIDTH, fetch_lines,
};

/// The steps of the exact path, for one instruction set. All implementations agree.
pub(crate) trait Kernel: Sync {
    /// Computes bounds of the columns of a tile.
    fn norms_f64(&self, tile: &Tile<f64>) -> TileNorms;
    /// Computes bounds of the columns of a tile.
    fn norms_f32(&self, tile: &Tile<f32>) -> TileNorms;

    /// Computes the residues of a tile; the integers are below 2^62 in magnitude.
    fn convert_f64(&self, it: Conversion<'_, '_, f64>);
    /// Computes the residues of a tile; the integers are below 2^31 in magnitude.
    fn convert_f32(&self, it: Conversion<'_, '_, f32>);
    /// Computes the residues of a tile; the magnitudes of the integers are at most
    /// 2^[`WIDE_BITS`](super::WIDE_BITS).
    fn convert_wide(&self, it: Conversion<'_, '_, f64>);

    /// Rearranges residues for the left side of [`Kernel::product`].
    fn to_left(&self, right: &[Slice], left: &mut [Slice]) {
        left.copy_from_slice(right);
    }

    /// Computes the products of several left panels: `residues[i]` becomes `left_i^T right`, plus
    /// its old value if `continued`, modulo `operands.modulus`, between -128 and 127.
    fn product(&self, operands: &Operands<'_>, residues: &mut [PanelBlock<i8>]);

    /// Computes a block of C from its residues: entry (i, j) is the integer of
    /// [`integers`](super::integers), rounded to the nearest f64, times `2^(rows[i] + columns[j])`.
    /// A subnormal result is rounded once more. Prefetches `next` meanwhile.
    fn recombine(&self, it: Recombination<'_>, out: &mut Square<f64>);

    /// Returns the vectors for small products.
    fn lanes(&self) -> LaneSet;

    /// Prepares the calling thread for [`Kernel::product`] until the session is dropped. Sessions
    /// of one thread must not overlap.
    fn session(&self) -> Session {
        Session(None)
    }
}

/// A tile whose columns are multiplied by `powers` and rounded to integers (ties to even).
pub(crate) struct Conversion<'a, 'o, T, P = T> {
    pub tile: &'a Tile<T>,
    pub powers: &'a Powers<P>,
    pub moduli: &'a [Modulus],
    /// Where the residues modulo each of the moduli are written.
    pub out: &'a mut [&'o mut Residues],
    /// Whether the residues fit no cache: a kernel that can then stores past the caches.
    pub far: bool,
}

/// The residues of a block of C, one block for each modulus, and the exponents of its rows and
/// columns.
#[derive(Clone, Copy)]
pub(crate) struct Recombination<'a> {
    pub residues: &'a [&'a PanelBlock<i8>],
    pub moduli: &'a Moduli,
    pub rows: &'a [i32; PANEL],
    pub columns: &'a [i32; PANEL],
    pub next: Next,
}

/// The block that follows in [`Kernel::recombine`]. All addresses are hints.
#[derive(Clone, Copy)]
pub(crate) struct Next {
    /// How far its residues are from those of this block, in blocks.
    pub residues: usize,
    /// The first of its 32 lines in C.
    pub line: *const u8,
    /// Bytes between its lines.
    pub stride: isize,
    /// Bytes of a line.
    pub len: usize,
}

impl Next {
    /// No block follows.
    pub const NONE: Self = Self { residues: 0, line: std::ptr::null(), stride: 0, len: 0 };

    /// Prefetches part `i`, 0..32, of the residues and the entries of the next block: all in one
    /// burst is slower.
    #[inline(always)]
    pub fn fetch(&self, residues: &[&PanelBlock<i8>], i: usize) {
        for block in residues.iter().skip(i % 2).step_by(2) {
            let next = std::ptr::from_ref::<PanelBlock<i8>>(block).wrapping_add(self.residues);
            fetch_lines(next.cast::<u8>().wrapping_add(64 * (i / 2)), 1);
        }
        fetch_lines(self.line.wrapping_offset(i as isize * self.stride), self.len.div_ceil(64));
    }
}

/// The operands of [`Kernel::product`].
#[derive(Clone, Copy)]
pub(crate) struct Operands<'a> {
    /// Slices from [`Kernel::to_left`], panel after panel, as many of each panel as `right` has.
    pub left: &'a [Slice],
    /// The slices of a panel, at most [`DEPTH`].
    pub right: &'a [Slice],
    /// The next panel of the right side, which may be prefetched.
    pub next: &'a [Slice],
    pub modulus: &'a Modulus,
    /// Whether to add the residues of earlier rows.
    pub continued: bool,
}

impl<'a> Operands<'a> {
    /// Returns the slices of each of the left panels.
    ///
    /// # Panics
    /// Unless there are `panels` left panels, of the length of the right one.
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

/// Implements [`Kernel::product`] with the sums of a pair of panels in memory: `add` adds the
/// product of two panels to sums, `reduce` reduces sums to residues.
#[inline(always)]
pub(super) fn product_by_pairs(
    operands: &Operands<'_>,
    residues: &mut [PanelBlock<i8>],
    add: impl Fn(&[Slice], &[Slice], &mut PanelBlock<i32>),
    reduce: impl Fn(&PanelBlock<i32>, &Modulus, &mut PanelBlock<i8>),
) {
    for (left, residues) in operands.left_panels(residues.len()).zip(residues) {
        let mut sums: PanelBlock<i32> = if operands.continued {
            residues.map(|quarter| quarter.map(|row| row.map(i32::from)))
        } else {
            [[[0; WIDTH]; WIDTH]; 4]
        };
        add(left, operands.right, &mut sums);
        reduce(&sums, operands.modulus, residues);
    }
}
