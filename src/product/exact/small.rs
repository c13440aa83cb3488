//! Small products: their integers are multiplied as such. The result is that of the residues, since
//! both are the same integers, rounded once; but no tiles have to be filled.

use faer::prelude::{Reborrow, ReborrowMut};
use faer::{MatMut, MatRef};

use super::columns::{self, Columns};
use super::non_finite::Signs;
use super::sink::write_entry;
use crate::base::{Arena, Par, Real, Result, Tracker, widest};
use crate::kernel::int8::{
    IntegerIsa, IntegerOperand, Kernel, LANES, Lanes, Moduli, OnLanes, PANEL, Right, Row, STEP,
    norms, power_of_two, products, scaled, to_integers,
};
use crate::product::options::AtaOptions;

/// Returns the seconds of a product of A m x n and B m x k, if it takes less time by its integers
/// than by residues.
///
/// The choice does not change the result. The rates were measured with the kernels of this folder
/// on one core of a Zen 4.
pub(crate) fn seconds<T: IntegerOperand>(
    isa: IntegerIsa,
    [m, n, k]: [usize; 3],
    moduli: usize,
    symmetric: bool,
) -> Option<f64> {
    /// Cost of the conversion of an entry to an integer, in products of parts.
    const ENTRY: f64 = 8.0;
    /// Cost of rounding an entry of C, in products of parts.
    const RESULT: f64 = 20.0;
    /// Seconds of a product by residues that do not grow with the sides.
    const START: f64 = 1e-5;
    /// Most seconds of a product by integers, which takes one thread and has no progress.
    const MOST: f64 = 2e-3;
    let half = if symmetric { 0.5 } else { 1.0 };
    let real = |side: usize| side as f64;
    let padded = |side: usize, to: usize| side.next_multiple_of(to) as f64;
    let rates = isa.rates();
    let results = half * padded(n, LANES) * padded(k, LANES);
    let entries = real(m) * (padded(n, LANES) + padded(k, LANES));
    let integers =
        (results * real(m) * T::PARTS as f64 + entries * ENTRY + results * RESULT) / rates.integers;
    let (height, left, right) = (padded(m, STEP), padded(n, PANEL), padded(k, PANEL));
    let operands = height * if symmetric { left } else { left + right };
    let blocks = half * left * right;
    let residues = blocks * height / rates.products
        + operands / rates.conversions
        + blocks / rates.recombinations;
    (integers < MOST.min(START + moduli as f64 * residues)).then_some(integers)
}

/// Returns the elements of scratch that [`execute`] needs.
pub(crate) fn scratch_len<T: IntegerOperand>([m, n, k]: [usize; 3], same: bool) -> usize {
    let strips = (if same { n } else { n.saturating_add(k) }).div_ceil(LANES);
    let rows = m.saturating_mul(strips);
    let bands = m.div_ceil(STEP);
    Arena::<T>::len_of::<Row>(rows)
        + Arena::<T>::len_of::<[i32; LANES]>(rows)
        + Arena::<T>::len_of::<[i32; LANES]>(strips)
        + Arena::<T>::len_of::<[f64; LANES]>(strips)
        + Arena::<T>::len_of::<[i32; LANES]>(bands)
        + Arena::<T>::len_of::<[f64; LANES]>(bands)
}

/// Computes what [`execute`](super::execute) computes with so many moduli; a symmetric product is
/// the lower triangle.
pub(crate) fn execute<T: IntegerOperand>(
    kernel: &dyn Kernel,
    moduli: usize,
    symmetric: bool,
    alpha: T,
    a: MatRef<'_, T>,
    b: Option<MatRef<'_, T>>,
    beta: T,
    c: MatMut<'_, T>,
    options: &AtaOptions<'_>,
    scratch: &mut [T],
) -> Result<()> {
    // The transposed product has the same entries.
    let (a, b, mut c) = match b {
        Some(b) if !symmetric && is_better_transposed(c.rb()) => (b, Some(a), c.transpose_mut()),
        _ => (a, b, c),
    };
    let lanes = kernel.lanes();
    let limit = columns::limit(Moduli::of(moduli), a.nrows());
    let strips = lanes.run(Convert { a, b, limit, arena: Arena::new(scratch) });
    let signs = if strips.non_finite.is_empty() { None } else { strips.signs(a, b)? };
    lanes.run(Multiply { strips: &strips, symmetric, alpha, beta, c: c.rb_mut() });
    let Some(signs) = signs else { return options.progress.report(1.0) };
    let progress = Tracker::new(options.progress, 1.0);
    signs.add(alpha, symmetric, c, Par::Seq, &progress);
    progress.finish()
}

/// Returns whether strips of the columns of C have fewer empty places than strips of its rows, or
/// about as many and adjacent entries.
fn is_better_transposed<T>(c: MatRef<'_, T>) -> bool {
    let strips = |along: usize, across: usize| along.div_ceil(LANES) * across;
    let (rows, columns) = (strips(c.nrows(), c.ncols()), strips(c.ncols(), c.nrows()));
    // Entries that are not adjacent are written one by one.
    let adjacent = c.col_stride() == 1 && c.row_stride() != 1;
    4 * columns < 3 * rows || (adjacent && 3 * columns <= 4 * rows)
}

/// The integers of the columns of A, and then those of B, in strips of [`LANES`] columns.
struct Strips<'a> {
    /// Columns of A if there is another operand, else 0: the first column of the right side.
    right: usize,
    /// Entries of a column.
    height: usize,
    /// Strip by strip.
    rows: &'a mut [Row],
    /// The sums of both parts of each integer.
    both: &'a mut [[i32; LANES]],
    /// Columns are multiplied by `2^exponent` before they are rounded to integers.
    exponents: &'a mut [[i32; LANES]],
    /// `2^-exponent`, if [`Strips::moderate`].
    units: &'a mut [[f64; LANES]],
    /// Whether a product of an integer and two units is rounded once.
    moderate: bool,
    /// Columns with a NaN or an infinity, in order; they count as zeros.
    non_finite: Vec<usize>,
}

impl Strips<'_> {
    fn signs<T: Real>(&self, a: MatRef<'_, T>, b: Option<MatRef<'_, T>>) -> Result<Option<Signs>> {
        let columns = |non_finite| Columns { exponents: Vec::new(), non_finite, wide: false };
        let Some(b) = b else {
            let columns = columns(self.non_finite.clone());
            return Signs::of_product((a, &columns), (a, &columns), Par::Seq);
        };
        let of_b = self.non_finite.partition_point(|&j| j < self.right);
        let right = columns(self.non_finite[of_b..].iter().map(|j| j - self.right).collect());
        let left = columns(self.non_finite[..of_b].to_vec());
        Signs::of_product((a, &left), (b, &right), Par::Seq)
    }

    /// Returns column j of the right side, and its exponent and unit.
    #[inline(always)]
    fn right(&self, j: usize) -> (Right<'_>, i32, f64) {
        let (strip, lane) = ((self.right + j) / LANES, (self.right + j) % LANES);
        let range = strip * self.height..(strip + 1) * self.height;
        let right = Right { rows: &self.rows[range.clone()], both: &self.both[range], lane };
        (right, self.exponents[strip][lane], self.units[strip][lane])
    }
}

/// The largest exponent for which powers of two and their inverses have moderate products.
const MODERATE: i32 = 600;

/// Converts the operands to integers.
struct Convert<'a, 'm, T> {
    a: MatRef<'m, T>,
    b: Option<MatRef<'m, T>>,
    /// The largest norm of a column before it is rounded.
    limit: f64,
    arena: Arena<'a, T>,
}

impl<'a, T: IntegerOperand> OnLanes for Convert<'a, '_, T> {
    type Output = Strips<'a>;

    #[inline(always)]
    fn run<L: Lanes>(self, lanes: L) -> Strips<'a> {
        let Self { a, b, limit, mut arena } = self;
        let height = a.nrows();
        let right = if b.is_some() { a.ncols() } else { 0 };
        let columns = a.ncols() + b.map_or(0, |b| b.ncols());
        let count = columns.div_ceil(LANES);
        let mut strips = Strips {
            right,
            height,
            rows: arena.take_as(count * height),
            both: arena.take_as(count * height),
            exponents: arena.take_as(count),
            units: arena.take_as(count),
            moderate: true,
            non_finite: Vec::new(),
        };
        let bounds = Bounds::new(limit, height);
        for strip in 0..count {
            let first = strip * LANES;
            let range = strip * height..(strip + 1) * height;
            let rows = &mut strips.rows[range.clone()];
            let of_a = a.ncols().saturating_sub(first).min(LANES);
            if of_a > 0 {
                fill(lanes, a.subcols(first, of_a), 0, rows);
            }
            if let Some(b) = b.filter(|_| of_a < LANES) {
                let from = (first + of_a) - a.ncols();
                let of_b = (b.ncols() - from).min(LANES - of_a);
                fill(lanes, b.subcols(from, of_b), of_a, rows);
            }
            let present = (columns - first).min(LANES);
            let exponents = &mut strips.exponents[strip];
            let powers = match bounds.exponents::<L, T>(lanes, rows, present) {
                Some(found) => {
                    lanes.store_low(found, exponents);
                    let bias = lanes.splat_integer(1023);
                    let power = lanes.shift_left::<52>(lanes.add_integers(bias, found));
                    let unit = lanes.shift_left::<52>(lanes.sub_integers(bias, found));
                    lanes.store(lanes.floats(unit), &mut strips.units[strip]);
                    lanes.floats(power)
                }
                None => {
                    let found = exponents_of_any::<T>(rows, limit, &mut arena);
                    let missing = (0..present).filter(|&j| found[j].is_none());
                    strips.non_finite.extend(missing.map(|j| first + j));
                    let mut powers = [0.0; LANES];
                    for (j, found) in found.into_iter().enumerate() {
                        let found = found.unwrap_or(0);
                        let fits = found.abs() <= MODERATE;
                        strips.moderate &= fits;
                        exponents[j] = found;
                        strips.units[strip][j] = if fits { power_of_two(-found) } else { 0.0 };
                        powers[j] = power_of_two(found - enlarged(found));
                    }
                    lanes.load(&powers)
                }
            };
            to_integers::<L, T>(lanes, rows, powers, &mut strips.both[range]);
        }
        strips
    }
}

/// Reads at most [`LANES`] columns into the lanes from `first` on. The lanes after these become
/// zero; those before keep their entries.
#[inline(always)]
fn fill<L: Lanes, T: IntegerOperand>(lanes: L, a: MatRef<'_, T>, first: usize, rows: &mut [Row]) {
    let range = first..first + a.ncols();
    let (down, along) = (a.row_stride(), a.col_stride());
    if along == 1 {
        for (i, row) in rows.iter_mut().enumerate() {
            let from = a.as_ptr().wrapping_offset(i as isize * down);
            // SAFETY: the entries of a row are adjacent, as `range` is long; `rows` has as many
            // rows as `a`.
            put(lanes, unsafe { T::read(lanes, from, range.clone()) }, first, row);
        }
    } else if down == 1 {
        for (block, rows) in rows.chunks_mut(LANES).enumerate() {
            let mut columns = [lanes.splat(0.0); LANES];
            for j in 0..LANES {
                if range.contains(&j) {
                    let from = a.as_ptr().wrapping_offset((j - first) as isize * along);
                    let from = from.wrapping_add(block * LANES);
                    // SAFETY: the entries of a column are adjacent; `rows` has as many rows as `a`,
                    // in chunks, so that each chunk ends inside the column.
                    columns[j] = unsafe { T::read(lanes, from, 0..rows.len()) };
                }
            }
            let columns = lanes.transpose(columns);
            // A loop of fixed length keeps the vectors in registers.
            for i in 0..LANES {
                if let Some(row) = rows.get_mut(i) {
                    put(lanes, columns[i], first, row);
                }
            }
        }
    } else {
        for (i, row) in rows.iter_mut().enumerate() {
            let mut entries = [0.0; LANES];
            for (j, entry) in entries[range.clone()].iter_mut().enumerate() {
                *entry = a[(i, j)].to_f64();
            }
            put(lanes, lanes.load(&entries), first, row);
        }
    }
}

/// Writes entries to the lanes of a row from `first` on; the others are zero.
#[inline(always)]
fn put<L: Lanes>(lanes: L, entries: L::Floats, first: usize, row: &mut Row) {
    let entries = lanes.bits(entries);
    let all = if first == 0 { entries } else { lanes.or(lanes.load_row(row), entries) };
    lanes.store_row(all, row);
}

/// What decides the exponents of columns.
///
/// The exponent of a column is the largest q for which `2^q |a|` is below the limit, but with a
/// bound of |a| that is a sum of integers ([`columns`]). The square of that bound exceeds that of
/// |a| by at most a factor of `1 + sqrt(m) / 2^18 + m / 2^37`, so that the norm itself nearly
/// always gives the same exponent.
struct Bounds {
    /// The bits of the squared limit, less and more than it by what the bound and roundings may be
    /// wrong.
    squares: [i64; 2],
}

impl Bounds {
    fn new(limit: f64, height: usize) -> Self {
        /// Relative errors of roundings: those of sums of fewer than `2^22` squares.
        const ROUNDING: f64 = 1.0 / (1 << 30) as f64;
        let square = (limit * limit).to_bits() as i64;
        let excess = (height as f64).sqrt() / f64::from(1 << 18) + height as f64 * 2e-11;
        // A relative difference d changes the bits by less than 2^53 d.
        let bits = |difference: f64| (difference * (1_u64 << 53) as f64) as i64;
        Self { squares: [square - bits(excess + ROUNDING), square + bits(ROUNDING)] }
    }

    /// Returns the exponents of the columns of a strip; lanes beyond its columns are ignored.
    /// `None` if some exponents are not certain, or entries have extreme sizes.
    #[inline(always)]
    fn exponents<L: Lanes, T: IntegerOperand>(
        &self,
        lanes: L,
        rows: &[Row],
        present: usize,
    ) -> Option<L::Integers> {
        /// Squares between those of these numbers, and their sums, are normal numbers.
        const RANGE: [f64; 2] = [power_of_two(-450), power_of_two(480)];
        const ROWS: usize = 1 << 22;
        const ABSENT: [f64; 2 * LANES] =
            [0., 0., 0., 0., 0., 0., 0., 0., 1., 1., 1., 1., 1., 1., 1., 1.];
        if rows.len() > ROWS {
            return None;
        }
        let magnitude = lanes.splat_integer(i64::MAX);
        let absent = lanes.load(ABSENT[LANES - present..].first_chunk().unwrap());
        let mut largest = absent;
        for row in rows {
            let size = lanes.floats(lanes.and(lanes.load_row(row), magnitude));
            largest = lanes.max(size, largest);
        }
        if !lanes.all_within(largest, RANGE[0], RANGE[1]) {
            return None;
        }
        let mut sums = [absent; 4];
        let (fours, rest) = rows.as_chunks::<4>();
        for four in fours {
            for i in 0..4 {
                let entries = lanes.floats(lanes.load_row(&four[i]));
                sums[i] = lanes.mul_add(entries, entries, sums[i]);
            }
        }
        for row in rest {
            let entries = lanes.floats(lanes.load_row(row));
            sums[0] = lanes.mul_add(entries, entries, sums[0]);
        }
        let sum = lanes.add(lanes.add(sums[0], sums[1]), lanes.add(sums[2], sums[3]));
        // A NaN is not within.
        if !lanes.all_within(sum, 0.0, f64::MAX) {
            return None;
        }
        let sum = lanes.bits(sum);
        // The difference of bits, divided by 2^52 and rounded down, is log2 of the quotient rounded
        // down, of which half is wanted.
        let mut found = [sum; 2];
        for (found, square) in found.iter_mut().zip(self.squares) {
            let quotient = lanes.sub_integers(lanes.splat_integer(square), sum);
            *found = lanes.shift_right_signed::<53>(quotient);
        }
        if !lanes.all_equal(found[0], found[1]) {
            return None;
        }
        if T::PARTS > 1 {
            return Some(found[0]);
        }
        // The integers of f32 are limited too.
        let exponent = lanes.shift_right::<52>(lanes.bits(largest));
        let most = lanes.splat_integer(i64::from(T::INTEGER_BITS) + 1022);
        Some(lanes.min_integers(found[0], lanes.sub_integers(most, exponent)))
    }
}

/// Returns the power of two that the entries of a column of this exponent are multiplied by first,
/// since `2^exponent` may overflow.
fn enlarged(exponent: i32) -> i32 {
    if exponent > 900 { 400 } else { 0 }
}

/// Returns the exponents of the columns of a strip, `None` for those with an entry that is not
/// finite, which become zeros. Entries of the other columns are multiplied as [`enlarged`] says.
#[cold]
#[inline(never)]
fn exponents_of_any<T: IntegerOperand>(
    rows: &mut [Row],
    limit: f64,
    arena: &mut Arena<'_, T>,
) -> [Option<i32>; LANES] {
    let mut arena = arena.nested();
    let bands = rows.len().div_ceil(STEP);
    let exponents = arena.take_as::<[i32; LANES]>(bands);
    let squares = arena.take_as::<[f64; LANES]>(bands);
    let entry = |[low, high]: [i32; 2]| {
        f64::from_bits(u64::from(low.cast_unsigned()) | u64::from(high.cast_unsigned()) << 32)
    };
    let found = widest(
        #[inline(always)]
        || {
            for (band, rows) in rows.chunks(STEP).enumerate() {
                let mut entries = [[0.0; LANES]; STEP];
                for (entries, row) in entries.iter_mut().zip(rows) {
                    for j in 0..LANES {
                        entries[j] = entry(row[j]);
                    }
                }
                let norms = norms(&entries[..rows.len()]);
                (exponents[band], squares[band]) = (norms.exponents, norms.squares);
            }
            columns::combine::<T, _>(exponents, squares, limit)
        },
    );
    for j in 0..LANES {
        let factor = match found[j] {
            None => 0.0,
            Some(exponent) => power_of_two(enlarged(exponent)),
        };
        if factor == 1.0 {
            continue;
        }
        for row in &mut *rows {
            let value = if factor == 0.0 { 0.0 } else { entry(row[j]) * factor };
            let bits = value.to_bits();
            row[j] = [bits as i32, (bits >> 32) as i32];
        }
    }
    found
}

/// Computes the entries of C.
struct Multiply<'s, 'a, 'c, T> {
    strips: &'s Strips<'a>,
    symmetric: bool,
    alpha: T,
    beta: T,
    c: MatMut<'c, T>,
}

impl<T: IntegerOperand> OnLanes for Multiply<'_, '_, '_, T> {
    type Output = ();

    #[inline(always)]
    fn run<L: Lanes>(mut self, lanes: L) {
        let columns = self.c.ncols();
        let mut col = 0;
        if L::COLUMNS == 4 {
            while col + 4 <= columns {
                self.columns::<L, 4>(lanes, col);
                col += 4;
            }
        }
        while col + 2 <= columns {
            self.columns::<L, 2>(lanes, col);
            col += 2;
        }
        if col < columns {
            self.columns::<L, 1>(lanes, col);
        }
    }
}

impl<T: IntegerOperand> Multiply<'_, '_, '_, T> {
    /// Computes the columns from `col` on, which is a multiple of their number.
    #[inline(always)]
    fn columns<L: Lanes, const COUNT: usize>(&mut self, lanes: L, col: usize) {
        let strips = self.strips;
        let mut right = [strips.right(col); COUNT];
        for (j, right) in right.iter_mut().enumerate().skip(1) {
            *right = strips.right(col + j);
        }
        let mut factors = [right[0].0; COUNT];
        for (factor, right) in factors.iter_mut().zip(&right) {
            *factor = right.0;
        }
        let first = if self.symmetric { col / LANES } else { 0 };
        for strip in first..self.c.nrows().div_ceil(LANES) {
            let left = &strips.rows[strip * strips.height..(strip + 1) * strips.height];
            let found = products::<L, T, COUNT>(lanes, left, factors);
            let present = 0..(self.c.nrows() - strip * LANES).min(LANES);
            // Zeros elsewhere: products of other columns must not raise exceptions.
            // SAFETY: a strip has LANES units, and `present` at most as many numbers.
            let units = unsafe { lanes.read_f64(strips.units[strip].as_ptr(), present.clone()) };
            for (j, &(_, exponent, unit)) in right.iter().enumerate() {
                let value = if strips.moderate {
                    lanes.mul(lanes.mul(found[j], units), lanes.splat(unit))
                } else {
                    let mut values = [0.0; LANES];
                    lanes.store(found[j], &mut values);
                    for i in present.clone() {
                        values[i] = scaled(values[i], -(strips.exponents[strip][i] + exponent));
                    }
                    lanes.load(&values)
                };
                self.write(lanes, value, strip * LANES, col + j);
            }
        }
    }

    /// Writes values to the entries of a column from `row` on; of a triangle, to those from the
    /// diagonal on.
    #[inline(always)]
    fn write<L: Lanes>(&mut self, lanes: L, values: L::Floats, row: usize, col: usize) {
        let (alpha, beta) = (self.alpha, self.beta);
        let above = if self.symmetric { col.saturating_sub(row) } else { 0 };
        let range = above..(self.c.nrows() - row).min(LANES);
        if range.is_empty() {
            return;
        }
        let (down, along) = (self.c.row_stride(), self.c.col_stride());
        let offset = (row + above) as isize * down + col as isize * along;
        let to = self.c.as_ptr_mut().wrapping_offset(offset);
        if down == 1 && alpha == T::ONE && beta == T::ZERO {
            // SAFETY: the entries of a column of C are adjacent; `range` ends at its last row and
            // begins at `to`.
            unsafe { T::write(lanes, values, to, range) };
            return;
        }
        let mut of_lanes = [0.0; LANES];
        lanes.store(values, &mut of_lanes);
        for (i, &value) in of_lanes[range].iter().enumerate() {
            // SAFETY: `to` is entry (row + above, col) of C, which is borrowed, and `range` ends at
            // the last row.
            write_entry(alpha, beta, value, unsafe { &mut *to.offset(i as isize * down) });
        }
    }
}
