//! Small products: their integers are multiplied as such. The result is that of the residues, since
//! both are the same integers, rounded once; but no tiles have to be filled.

use faer::prelude::ReborrowMut;
use faer::{MatMut, MatRef};

use super::columns::{self, Columns};
use super::non_finite::Signs;
use super::sink::write_entry;
use crate::base::{Arena, Par, Result, Tracker, widest};
use crate::kernel::int8::{
    IntegerIsa, IntegerOperand, Kernel, LANES, MOST_PARTS, MOST_ROWS, Moduli, PANEL, Powers,
    Products, Row, STEP, norms, scaled, transpose,
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
    /// Seconds of an entry that becomes an integer.
    const ENTRY: f64 = 1e-9;
    /// Seconds of an entry of C that is rounded.
    const RESULT: f64 = 3e-9;
    /// Seconds of a product by residues that do not grow with the sides.
    const START: f64 = 1e-5;
    /// Most seconds of a product by integers, which takes one thread and has no progress.
    const MOST: f64 = 1e-3;
    let half = if symmetric { 0.5 } else { 1.0 };
    let real = |side: usize| side as f64;
    let padded = |side: usize, to: usize| side.next_multiple_of(to) as f64;
    let rates = isa.rates();
    let results = half * padded(n, LANES) * padded(k, LANES);
    let integers = results * real(m) * T::PARTS as f64 / rates.integers
        + real(m) * (padded(n, LANES) + padded(k, LANES)) * ENTRY
        + results * RESULT;
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
    let strips = |columns: usize| {
        Arena::<T>::len_of::<Row>(m.saturating_mul(columns.div_ceil(LANES) * T::PARTS))
    };
    let bands = m.div_ceil(STEP);
    let one = Arena::<T>::len_of::<[T; LANES]>(m)
        + Arena::<T>::len_of::<[i32; LANES]>(bands)
        + Arena::<T>::len_of::<[f64; LANES]>(bands);
    one + strips(n) + if same { 0 } else { strips(k) }
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
    mut c: MatMut<'_, T>,
    options: &AtaOptions<'_>,
    scratch: &mut [T],
) -> Result<()> {
    let moduli = Moduli::of(moduli);
    let arena = &mut Arena::new(scratch);
    let mut strips = |a| Strips::new(a, moduli, arena);
    let (of_a, of_b) = (strips(a), b.map(strips));
    let (b, of_b) = (b.unwrap_or(a), of_b.as_ref().unwrap_or(&of_a));
    let signs = Signs::of_product((a, &of_a.columns), (b, &of_b.columns), Par::Seq)?;
    widest(
        #[inline(always)]
        || multiply(kernel, [&of_a, of_b], symmetric, alpha, beta, c.rb_mut()),
    );
    let progress = Tracker::new(options.progress, 1.0);
    if let Some(signs) = signs {
        signs.add(alpha, symmetric, c, Par::Seq, &progress);
    }
    progress.finish()
}

/// The integers of an operand, in strips of [`LANES`] columns.
struct Strips<'a> {
    columns: Columns,
    /// Strip by strip, and in each the parts of the integers one after another.
    rows: &'a [Row],
    height: usize,
}

impl<'a> Strips<'a> {
    fn new<T: IntegerOperand>(a: MatRef<'_, T>, moduli: &Moduli, arena: &mut Arena<'a, T>) -> Self {
        let (height, n) = a.shape();
        let count = n.div_ceil(LANES);
        let rows = arena.take_as::<Row>(count * T::PARTS * height);
        let mut arena = arena.nested();
        let entries = arena.take_as::<[T; LANES]>(height);
        let bands = height.div_ceil(STEP);
        let exponents = arena.take_as::<[i32; LANES]>(bands);
        let squares = arena.take_as::<[f64; LANES]>(bands);
        let limit = columns::limit(moduli, height);
        let found =
            rows.chunks_exact_mut((T::PARTS * height).max(1)).enumerate().map(|(strip, rows)| {
                let first = strip * LANES;
                let a = a.subcols(first, LANES.min(n - first));
                widest(
                    #[inline(always)]
                    || {
                        load(a, entries);
                        for (band, rows) in entries.chunks(STEP).enumerate() {
                            let norms = norms(rows);
                            (exponents[band], squares[band]) = (norms.exponents, norms.squares);
                        }
                        let mut found = columns::combine::<T, _>(exponents, squares, limit);
                        convert(entries, found, rows);
                        found[a.ncols()..].fill(Some(0));
                        found
                    },
                )
            });
        Self { columns: Columns::of_groups(count, found), rows, height }
    }

    /// Returns a strip: its parts one after another.
    #[inline(always)]
    fn strip<T: IntegerOperand>(&self, strip: usize) -> &[Row] {
        let len = T::PARTS * self.height;
        &self.rows[strip * len..(strip + 1) * len]
    }
}

/// Reads at most [`LANES`] columns; the last takes the place of those that are missing.
#[inline(always)]
fn load<T: IntegerOperand>(a: MatRef<'_, T>, entries: &mut [[T; LANES]]) {
    let (m, n) = a.shape();
    let column = |j: usize| a.col(j.min(n - 1));
    if a.col_stride() == 1 {
        for (i, row) in entries.iter_mut().enumerate() {
            // SAFETY: the n entries of a row are adjacent.
            let found = unsafe { std::slice::from_raw_parts(a.row(i).as_ptr(), n) };
            row[..n].copy_from_slice(found);
            row[n..].fill(found[n - 1]);
        }
        return;
    }
    if a.row_stride() != 1 {
        for j in 0..LANES {
            for (row, &entry) in entries.iter_mut().zip(column(j).iter()) {
                row[j] = entry;
            }
        }
        return;
    }
    let columns: [_; LANES] = std::array::from_fn(|j| {
        // SAFETY: the m entries of a column are adjacent.
        unsafe { std::slice::from_raw_parts(column(j).as_ptr(), m) }.as_chunks::<LANES>()
    });
    let (whole, rest) = entries.as_chunks_mut::<LANES>();
    for (i, rows) in whole.iter_mut().enumerate() {
        transpose(columns.map(|(chunks, _)| &chunks[i]), rows);
    }
    for (i, row) in rest.iter_mut().enumerate() {
        *row = columns.map(|(_, rest)| rest[i]);
    }
}

/// Writes the parts of the integers of a strip one after another; columns that are not finite count
/// as zeros.
#[inline(always)]
fn convert<T: IntegerOperand>(
    entries: &mut [[T; LANES]],
    found: [Option<i32>; LANES],
    rows: &mut [Row],
) {
    for j in (0..LANES).filter(|&j| found[j].is_none()) {
        entries.iter_mut().for_each(|row| row[j] = T::ZERO);
    }
    let mut exponents = [0; LANES];
    exponents.iter_mut().zip(found).for_each(|(exponent, found)| *exponent = found.unwrap_or(0));
    let Powers { first, second } = Powers::<T, LANES>::new(exponents);
    let mut parts = rows.chunks_exact_mut(entries.len());
    let mut parts: [_; MOST_PARTS] = std::array::from_fn(|_| parts.next().unwrap_or_default());
    for (i, row) in entries.iter().enumerate() {
        let scaled = std::array::from_fn(|j| row[j] * first[j] * second[j]);
        // SAFETY: `combine` chooses powers that keep norms below the bound.
        let integers = unsafe { T::parts(scaled) };
        for (part, integers) in parts.iter_mut().zip(integers).take(T::PARTS) {
            part[i] = integers;
        }
    }
}

/// Computes the entries of C.
#[inline(always)]
fn multiply<T: IntegerOperand>(
    kernel: &dyn Kernel,
    [left, right]: [&Strips<'_>; 2],
    symmetric: bool,
    alpha: T,
    beta: T,
    mut c: MatMut<'_, T>,
) {
    let (rows, cols) = c.shape();
    let mut products = [[[0; LANES]; LANES]; MOST_PARTS];
    let mut sums = products;
    for right_strip in 0..cols.div_ceil(LANES) {
        let first = if symmetric { right_strip } else { 0 };
        for left_strip in first..rows.div_ceil(LANES) {
            let strips = [left.strip::<T>(left_strip), right.strip::<T>(right_strip)];
            add_up::<T>(kernel, strips, left.height, &mut products, &mut sums);
            let row = left_strip * LANES;
            let of_rows = left.columns.exponents[row..].first_chunk::<LANES>().unwrap();
            for (j, col) in (right_strip * LANES..cols).take(LANES).enumerate() {
                let of_col = right.columns.exponents[col];
                let mut values = T::values(&sums, j);
                for (value, of_row) in values.iter_mut().zip(of_rows) {
                    *value = scaled(*value, -(of_row + of_col));
                }
                // Above the diagonal of a triangle nothing is written.
                let above = if symmetric { col.saturating_sub(row) } else { 0 };
                let end = rows.min(row + LANES);
                if let Some(values) = values[..end - row].get(above..) {
                    let entries = c.rb_mut().col_mut(col).subrows_mut(row + above, values.len());
                    for (entry, &value) in entries.iter_mut().zip(values) {
                        write_entry(alpha, beta, value, entry);
                    }
                }
            }
        }
    }
}

/// Computes the sums of products of two strips; `products` is scratch.
#[inline(always)]
fn add_up<T: IntegerOperand>(
    kernel: &dyn Kernel,
    [left, right]: [&[Row]; 2],
    height: usize,
    products: &mut [Products; MOST_PARTS],
    sums: &mut [Products; MOST_PARTS],
) {
    sums.fill([[0; LANES]; LANES]);
    for first in (0..height).step_by(MOST_ROWS) {
        let rows = first..height.min(first + MOST_ROWS);
        for (part, products) in products.iter_mut().take(T::PARTS).enumerate() {
            let [left, right] = [left, right].map(|strip| &strip[part * height..][rows.clone()]);
            kernel.multiply_strips(left, right, products);
        }
        T::accumulate(products, sums);
    }
}
