//! Vectors of eight numbers: the arithmetic of small products is written once for all of them.
//!
//! A value of a type that implements [`Lanes`] exists only where the CPU has its instructions.

use std::ops::Range;

/// Numbers of a vector, and columns of a strip.
pub(crate) const LANES: usize = 8;
/// One row of a strip: of each integer its two halves, the lower first.
pub(crate) type Row = [[i32; 2]; LANES];

/// Operations on vectors of eight f64 or i64.
pub(crate) trait Lanes: Copy {
    /// Eight f64.
    type Floats: Copy;
    /// Eight i64.
    type Integers: Copy;
    /// Columns of the right side whose sums fit the registers: 2 or 4.
    const COLUMNS: usize;

    /// Reads `range.len()` adjacent numbers into these lanes; the others are zero.
    ///
    /// # Safety
    /// `from` points to `range.len()` numbers.
    unsafe fn read_f64(self, from: *const f64, range: Range<usize>) -> Self::Floats;
    /// Reads like [`Lanes::read_f64`].
    ///
    /// # Safety
    /// As for [`Lanes::read_f64`].
    unsafe fn read_f32(self, from: *const f32, range: Range<usize>) -> Self::Floats;
    /// Writes these lanes to adjacent numbers.
    ///
    /// # Safety
    /// `to` points to `range.len()` numbers.
    unsafe fn write_f64(self, x: Self::Floats, to: *mut f64, range: Range<usize>);
    /// Writes like [`Lanes::write_f64`], rounded.
    ///
    /// # Safety
    /// As for [`Lanes::write_f64`].
    unsafe fn write_f32(self, x: Self::Floats, to: *mut f32, range: Range<usize>);
    /// Returns the j-th numbers of all vectors as the j-th vector.
    fn transpose(self, rows: [Self::Floats; LANES]) -> [Self::Floats; LANES];

    fn load(self, from: &[f64; LANES]) -> Self::Floats;
    fn store(self, x: Self::Floats, to: &mut [f64; LANES]);
    fn load_row(self, from: &Row) -> Self::Integers;
    fn store_row(self, x: Self::Integers, to: &mut Row);
    /// Stores the lower halves.
    fn store_low(self, x: Self::Integers, to: &mut [i32; LANES]);

    fn splat(self, x: f64) -> Self::Floats;
    fn splat_integer(self, x: i64) -> Self::Integers;
    /// Returns integers whose lower halves are x; the upper ones have any value.
    fn splat_low(self, x: i32) -> Self::Integers;

    fn add(self, x: Self::Floats, y: Self::Floats) -> Self::Floats;
    fn sub(self, x: Self::Floats, y: Self::Floats) -> Self::Floats;
    fn mul(self, x: Self::Floats, y: Self::Floats) -> Self::Floats;
    /// Returns the larger numbers, unspecified for NaN.
    fn max(self, x: Self::Floats, y: Self::Floats) -> Self::Floats;
    /// Returns `x y + z`, rounded once or twice.
    fn mul_add(self, x: Self::Floats, y: Self::Floats, z: Self::Floats) -> Self::Floats;
    /// Returns whether all numbers are between these, and so none is NaN.
    fn all_within(self, x: Self::Floats, least: f64, most: f64) -> bool;
    /// Returns all bits where the number is not zero, else none.
    fn where_nonzero(self, x: Self::Floats) -> Self::Integers;
    fn bits(self, x: Self::Floats) -> Self::Integers;
    fn floats(self, x: Self::Integers) -> Self::Floats;

    fn add_integers(self, x: Self::Integers, y: Self::Integers) -> Self::Integers;
    fn sub_integers(self, x: Self::Integers, y: Self::Integers) -> Self::Integers;
    fn and(self, x: Self::Integers, y: Self::Integers) -> Self::Integers;
    fn or(self, x: Self::Integers, y: Self::Integers) -> Self::Integers;
    fn xor(self, x: Self::Integers, y: Self::Integers) -> Self::Integers;
    fn min_integers(self, x: Self::Integers, y: Self::Integers) -> Self::Integers;
    fn all_equal(self, x: Self::Integers, y: Self::Integers) -> bool;
    /// Returns the products of the lower halves, which have signs.
    fn mul_low(self, x: Self::Integers, y: Self::Integers) -> Self::Integers;
    fn shift_left<const BITS: u32>(self, x: Self::Integers) -> Self::Integers;
    /// Shifts zeros in.
    fn shift_right<const BITS: u32>(self, x: Self::Integers) -> Self::Integers;
    /// Divides by `2^BITS`, rounding down.
    fn shift_right_signed<const BITS: u32>(self, x: Self::Integers) -> Self::Integers;
}

/// Work on vectors of any kind; its method is `#[inline(always)]`.
pub(crate) trait OnLanes {
    type Output;
    fn run<L: Lanes>(self, lanes: L) -> Self::Output;
}

/// Vectors in plain Rust.
#[derive(Clone, Copy)]
pub(crate) struct PortableLanes;

/// Returns the vector of `$value` for each lane `$i`.
macro_rules! each {
    ($i:ident => $value:expr) => {{
        let mut found = [Default::default(); LANES];
        for $i in 0..LANES {
            found[$i] = $value;
        }
        found
    }};
}

impl Lanes for PortableLanes {
    type Floats = [f64; LANES];
    type Integers = [i64; LANES];
    const COLUMNS: usize = 2;

    #[inline(always)]
    unsafe fn read_f64(self, from: *const f64, range: Range<usize>) -> [f64; LANES] {
        // SAFETY: the contract: `from` points to `range.len()` aligned numbers, which nobody writes
        // meanwhile.
        let from = unsafe { std::slice::from_raw_parts(from, range.len()) };
        let mut found = [0.0; LANES];
        for (found, &x) in found[range].iter_mut().zip(from) {
            *found = x;
        }
        found
    }

    #[inline(always)]
    unsafe fn read_f32(self, from: *const f32, range: Range<usize>) -> [f64; LANES] {
        // SAFETY: the contract: `from` points to `range.len()` aligned numbers, which nobody writes
        // meanwhile.
        let from = unsafe { std::slice::from_raw_parts(from, range.len()) };
        let mut found = [0.0; LANES];
        for (found, &x) in found[range].iter_mut().zip(from) {
            *found = f64::from(x);
        }
        found
    }

    #[inline(always)]
    unsafe fn write_f64(self, x: [f64; LANES], to: *mut f64, range: Range<usize>) {
        // SAFETY: the contract: `to` points to `range.len()` aligned numbers, which nobody else
        // uses meanwhile.
        let to = unsafe { std::slice::from_raw_parts_mut(to, range.len()) };
        for (to, &x) in to.iter_mut().zip(&x[range]) {
            *to = x;
        }
    }

    #[inline(always)]
    unsafe fn write_f32(self, x: [f64; LANES], to: *mut f32, range: Range<usize>) {
        // SAFETY: the contract: `to` points to `range.len()` aligned numbers, which nobody else
        // uses meanwhile.
        let to = unsafe { std::slice::from_raw_parts_mut(to, range.len()) };
        for (to, &x) in to.iter_mut().zip(&x[range]) {
            *to = x as f32;
        }
    }

    #[inline(always)]
    fn transpose(self, rows: [[f64; LANES]; LANES]) -> [[f64; LANES]; LANES] {
        let mut columns = [[0.0; LANES]; LANES];
        for (i, row) in rows.iter().enumerate() {
            for (column, &x) in columns.iter_mut().zip(row) {
                column[i] = x;
            }
        }
        columns
    }

    #[inline(always)]
    fn load(self, from: &[f64; LANES]) -> [f64; LANES] {
        *from
    }

    #[inline(always)]
    fn store(self, x: [f64; LANES], to: &mut [f64; LANES]) {
        *to = x;
    }

    #[inline(always)]
    fn load_row(self, from: &Row) -> [i64; LANES] {
        each!(i => i64::from(from[i][1]) << 32 | i64::from(from[i][0] as u32))
    }

    #[inline(always)]
    fn store_row(self, x: [i64; LANES], to: &mut Row) {
        for (to, x) in to.iter_mut().zip(x) {
            *to = [x as i32, (x >> 32) as i32];
        }
    }

    #[inline(always)]
    fn store_low(self, x: [i64; LANES], to: &mut [i32; LANES]) {
        for (to, x) in to.iter_mut().zip(x) {
            *to = x as i32;
        }
    }

    #[inline(always)]
    fn splat(self, x: f64) -> [f64; LANES] {
        [x; LANES]
    }

    #[inline(always)]
    fn splat_integer(self, x: i64) -> [i64; LANES] {
        [x; LANES]
    }

    #[inline(always)]
    fn splat_low(self, x: i32) -> [i64; LANES] {
        [i64::from(x); LANES]
    }

    #[inline(always)]
    fn add(self, x: [f64; LANES], y: [f64; LANES]) -> [f64; LANES] {
        each!(i => x[i] + y[i])
    }

    #[inline(always)]
    fn sub(self, x: [f64; LANES], y: [f64; LANES]) -> [f64; LANES] {
        each!(i => x[i] - y[i])
    }

    #[inline(always)]
    fn mul(self, x: [f64; LANES], y: [f64; LANES]) -> [f64; LANES] {
        each!(i => x[i] * y[i])
    }

    #[inline(always)]
    fn max(self, x: [f64; LANES], y: [f64; LANES]) -> [f64; LANES] {
        each!(i => if x[i] > y[i] { x[i] } else { y[i] })
    }

    #[inline(always)]
    fn mul_add(self, x: [f64; LANES], y: [f64; LANES], z: [f64; LANES]) -> [f64; LANES] {
        each!(i => x[i] * y[i] + z[i])
    }

    #[inline(always)]
    fn all_within(self, x: [f64; LANES], least: f64, most: f64) -> bool {
        x.iter().all(|x| (least..=most).contains(x))
    }

    #[inline(always)]
    fn where_nonzero(self, x: [f64; LANES]) -> [i64; LANES] {
        each!(i => -i64::from(x[i] != 0.0))
    }

    #[inline(always)]
    fn bits(self, x: [f64; LANES]) -> [i64; LANES] {
        each!(i => x[i].to_bits() as i64)
    }

    #[inline(always)]
    fn floats(self, x: [i64; LANES]) -> [f64; LANES] {
        each!(i => f64::from_bits(x[i] as u64))
    }

    #[inline(always)]
    fn add_integers(self, x: [i64; LANES], y: [i64; LANES]) -> [i64; LANES] {
        each!(i => x[i].wrapping_add(y[i]))
    }

    #[inline(always)]
    fn sub_integers(self, x: [i64; LANES], y: [i64; LANES]) -> [i64; LANES] {
        each!(i => x[i].wrapping_sub(y[i]))
    }

    #[inline(always)]
    fn and(self, x: [i64; LANES], y: [i64; LANES]) -> [i64; LANES] {
        each!(i => x[i] & y[i])
    }

    #[inline(always)]
    fn or(self, x: [i64; LANES], y: [i64; LANES]) -> [i64; LANES] {
        each!(i => x[i] | y[i])
    }

    #[inline(always)]
    fn xor(self, x: [i64; LANES], y: [i64; LANES]) -> [i64; LANES] {
        each!(i => x[i] ^ y[i])
    }

    #[inline(always)]
    fn min_integers(self, x: [i64; LANES], y: [i64; LANES]) -> [i64; LANES] {
        each!(i => x[i].min(y[i]))
    }

    #[inline(always)]
    fn all_equal(self, x: [i64; LANES], y: [i64; LANES]) -> bool {
        x == y
    }

    #[inline(always)]
    fn mul_low(self, x: [i64; LANES], y: [i64; LANES]) -> [i64; LANES] {
        each!(i => i64::from(x[i] as i32) * i64::from(y[i] as i32))
    }

    #[inline(always)]
    fn shift_left<const BITS: u32>(self, x: [i64; LANES]) -> [i64; LANES] {
        each!(i => x[i] << BITS)
    }

    #[inline(always)]
    fn shift_right<const BITS: u32>(self, x: [i64; LANES]) -> [i64; LANES] {
        each!(i => (x[i] as u64 >> BITS) as i64)
    }

    #[inline(always)]
    fn shift_right_signed<const BITS: u32>(self, x: [i64; LANES]) -> [i64; LANES] {
        each!(i => x[i] >> BITS)
    }
}

/// Defines methods of [`Lanes`] by instructions.
#[cfg(target_arch = "x86_64")]
macro_rules! by_instructions {
    ($(fn $name:ident($($x:ident: $t:ty),*) -> $out:ty { $body:expr })*) => {
        $(
            #[inline(always)]
            fn $name(self, $($x: $t),*) -> $out {
                // SAFETY: `self` exists, so the CPU has the instructions; references are to as
                // many numbers as the instructions read or write.
                unsafe { $body }
            }
        )*
    };
}
#[cfg(target_arch = "x86_64")]
pub(super) use by_instructions;
