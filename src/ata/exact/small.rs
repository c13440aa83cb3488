//! Small products: their integers are multiplied as machine words. The result is that of the
//! residues, since both are the same integers, rounded once; but no tiles have to be filled.

use faer::prelude::ReborrowMut;
use faer::{MatMut, MatRef};

use super::columns::{self, Columns};
use super::non_finite::Signs;
use super::sink::write_entry;
use crate::ata::options::AtaOptions;
use crate::base::{Arena, Par, Result, Tracker, widest};
use crate::kernel::int8::{Isa, Moduli, Operand, PANEL, STEP, power_of_two, scaled};

/// Returns whether a product of A m x n and B m x k takes less time by words than by residues.
///
/// The answer does not change the result. The rates were measured with the kernels of this folder
/// on one core of a Zen 4.
pub(crate) fn pays<T: Operand>(
    isa: Isa,
    [m, n, k]: [usize; 3],
    moduli: usize,
    symmetric: bool,
) -> bool {
    /// Seconds of a product of words, and of an entry that becomes a word.
    const PRODUCT: [f64; 2] = [1.5e-10, 4.5e-10];
    const ENTRY: f64 = 2e-9;
    /// Seconds of a product by residues that do not grow with the sides.
    const START: f64 = 1e-5;
    /// Most seconds of a product by words, which takes one thread and has no progress.
    const MOST: f64 = 1e-3;
    let product = PRODUCT[usize::from(size_of::<T>() == 8)];
    let half = if symmetric { 0.5 } else { 1.0 };
    let real = |side: usize| side as f64;
    let padded = |side: usize, to: usize| side.next_multiple_of(to) as f64;
    let words = half * real(m) * real(n) * real(k) * product + real(m) * real(n.max(k)) * ENTRY;
    let rates = isa.rates();
    let (height, left, right) = (padded(m, STEP), padded(n, PANEL), padded(k, PANEL));
    let operands = height * if symmetric { left } else { left + right };
    let blocks = half * left * right;
    let residues = blocks * height / rates.products
        + operands / rates.conversions
        + blocks / rates.recombinations;
    words < MOST.min(START + moduli as f64 * residues)
}

/// Returns the elements of scratch that [`execute`] needs.
pub(crate) fn scratch_len<T: Operand>([m, n, k]: [usize; 3], same: bool) -> usize {
    let words = |columns: usize| Arena::<T>::len_of::<T::Word>(m * columns);
    columns::few_scratch_len::<T>(m) + words(n) + if same { 0 } else { words(k) }
}

/// Computes what [`execute`](super::execute) computes with so many moduli; a symmetric product is
/// the lower triangle.
pub(crate) fn execute<T: Operand>(
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
    let mut integers = |a| Integers::new(a, moduli, arena);
    let (of_a, of_b) = (integers(a), b.map(integers));
    let left = (a, &of_a.columns);
    let right = (b.unwrap_or(a), &of_b.as_ref().unwrap_or(&of_a).columns);
    let signs = Signs::of_product(left, right, Par::Seq)?;
    let of_b = of_b.as_ref().unwrap_or(&of_a);
    widest(
        #[inline(always)]
        || multiply([&of_a, of_b], alpha, beta, c.rb_mut(), symmetric),
    );
    let progress = Tracker::new(options.progress, 1.0);
    if let Some(signs) = signs {
        signs.add(alpha, symmetric, c, Par::Seq, &progress);
    }
    progress.finish()
}

/// An operand in words.
struct Integers<'a, T: Operand> {
    columns: Columns,
    /// Column by column.
    words: &'a [T::Word],
    height: usize,
}

impl<'a, T: Operand> Integers<'a, T> {
    fn new(a: MatRef<'_, T>, moduli: &Moduli, arena: &mut Arena<'a, T>) -> Self {
        let (m, n) = a.shape();
        let words = arena.take_as::<T::Word>(m * n);
        let columns = Columns::of_few(a, moduli, arena);
        let mut arena = arena.nested();
        let copy = arena.take(m);
        widest(
            #[inline(always)]
            || {
                for j in 0..n {
                    let words = &mut words[j * m..(j + 1) * m];
                    if columns.non_finite.binary_search(&j).is_ok() {
                        words.fill(T::Word::default());
                        continue;
                    }
                    let (column, exponent) = (columns::read(a, j, copy), columns.exponents[j]);
                    let first = T::from_f64(power_of_two(exponent >> 1));
                    let second = T::from_f64(power_of_two(exponent - (exponent >> 1)));
                    for (word, &x) in words.iter_mut().zip(column) {
                        // SAFETY: the column is finite, and `Columns` chooses powers that keep it
                        // below the bound.
                        *word = unsafe { (x * first * second).word() };
                    }
                }
            },
        );
        Self { columns, words, height: m }
    }

    #[inline(always)]
    fn column(&self, j: usize) -> &[T::Word] {
        &self.words[j * self.height..(j + 1) * self.height]
    }
}

/// Computes the entries of C.
#[inline(always)]
fn multiply<T: Operand>(
    [left, right]: [&Integers<'_, T>; 2],
    alpha: T,
    beta: T,
    mut c: MatMut<'_, T>,
    symmetric: bool,
) {
    let (rows, cols) = c.shape();
    for j in 0..cols {
        let (column, exponent) = (right.column(j), right.columns.exponents[j]);
        let first = if symmetric { j } else { 0 };
        let entries = c.rb_mut().col_mut(j).subrows_mut(first, rows - first);
        for (i, entry) in (first..).zip(entries.iter_mut()) {
            let exponent = -(left.columns.exponents[i] + exponent);
            let value = scaled(T::dot(left.column(i), column), exponent);
            write_entry(alpha, beta, value, entry);
        }
    }
}
