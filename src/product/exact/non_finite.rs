//! Computes the entries of C that a NaN or an infinity of A or B reaches, as in the classical
//! algorithm, but without its overflows.
//!
//! A term that is not finite determines the sum, alone or with its opposite, so that finite terms
//! do not matter. Such a term follows from an infinite factor and the signs of both factors: a few
//! bits of each entry are enough.

use faer::{MatMut, MatRef};

use super::columns::Columns;
use crate::base::{Disjoint, Error, Par, Real, Result, Tracker};

/// Rows of a word.
const BITS: usize = u64::BITS as usize;

/// Bits of [`BITS`] entries of a column.
#[derive(Debug, Clone, Copy, Default)]
struct Word {
    positive: u64,
    negative: u64,
    infinite: u64,
}

/// The columns of an operand as sets of rows.
struct Columnwise {
    /// Column by column.
    words: Vec<Word>,
    /// Words of a column.
    height: usize,
    /// Whether a column has neither an infinity nor a NaN.
    finite: Vec<bool>,
    /// Whether a column has a NaN, which determines all its products.
    nan: Vec<bool>,
}

impl Columnwise {
    fn new<T: Real>(a: MatRef<'_, T>, non_finite: &[usize], par: Par) -> Result<Self> {
        let (m, n) = a.shape();
        let height = m.div_ceil(BITS);
        let mut words: Vec<Word> = Vec::new();
        let bytes = height.saturating_mul(n).saturating_mul(size_of::<Word>());
        words.try_reserve_exact(height * n).map_err(|_| Error::OutOfMemory { bytes })?;
        words.resize(height * n, Word::default());
        let mut finite = vec![true; n];
        non_finite.iter().for_each(|&j| finite[j] = false);
        let shared = Disjoint::of_slice(&mut words);
        let nan = par.map_blocks(height, 1, |bands| {
            let mut nan = vec![false; n];
            for band in bands {
                // SAFETY: each band is visited once, and has words of its own in every column.
                let word = |j: usize| unsafe { shared.get(j * height + band) };
                for i in band * BITS..m.min((band + 1) * BITS) {
                    for (j, nan) in nan.iter_mut().enumerate() {
                        let (value, word) = (a[(i, j)].to_f64(), word(j));
                        word.positive |= u64::from(value > 0.0) << (i % BITS);
                        word.negative |= u64::from(value < 0.0) << (i % BITS);
                        word.infinite |= u64::from(value.is_infinite()) << (i % BITS);
                        *nan |= value.is_nan();
                    }
                }
            }
            nan
        });
        let any = |j: usize| nan.iter().any(|of_bands| of_bands[j]);
        let nan = (0..n).map(any).collect();
        Ok(Self { words, height, finite, nan })
    }

    fn column(&self, j: usize) -> &[Word] {
        &self.words[j * self.height..(j + 1) * self.height]
    }
}

/// The kinds of terms of an entry of C that are not finite.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub(crate) struct Flags(pub u8);

impl Flags {
    const PLUS: u8 = 1;
    const MINUS: u8 = 2;
    /// A NaN among the terms, or infinities of both signs: the same for any order of the terms.
    const NAN: u8 = 3;

    /// Every flag.
    pub const MOST: u8 = Self::NAN;

    /// Returns the sum of the terms; `None` when there are none.
    pub fn sum(self) -> Option<f64> {
        match self.0 {
            0 => None,
            Self::PLUS => Some(f64::INFINITY),
            Self::MINUS => Some(f64::NEG_INFINITY),
            _ => Some(f64::NAN),
        }
    }

    /// Returns the flags of `x^T y`: of infinities times a sign, or times zero.
    fn of(x: &[Word], y: &[Word]) -> Self {
        let mut found = 0;
        for (x, y) in x.iter().zip(y) {
            let terms = x.infinite | y.infinite;
            if terms == 0 {
                continue;
            }
            let plus = x.positive & y.positive | x.negative & y.negative;
            let minus = x.positive & y.negative | x.negative & y.positive;
            found |= u8::from(terms & plus != 0) * Self::PLUS;
            found |= u8::from(terms & minus != 0) * Self::MINUS;
            found |= u8::from(terms & !(plus | minus) != 0) * Self::NAN;
            if found == Self::NAN {
                break;
            }
        }
        Self(found)
    }
}

/// The operands of a product of which one has columns that are not finite.
pub(crate) struct Signs {
    left: Columnwise,
    /// `None` when it is the same as the left operand.
    right: Option<Columnwise>,
}

impl Signs {
    /// Finds the columns of A and B that are not finite; returns `None` when all columns are
    /// finite.
    pub fn of_product<T: Real>(
        (a, left): (MatRef<'_, T>, &Columns),
        (b, right): (MatRef<'_, T>, &Columns),
        par: Par,
    ) -> Result<Option<Self>> {
        if left.non_finite.is_empty() && right.non_finite.is_empty() {
            return Ok(None);
        }
        let same = std::ptr::eq(left, right);
        let right = (!same).then(|| Columnwise::new(b, &right.non_finite, par)).transpose()?;
        Ok(Some(Self { left: Columnwise::new(a, &left.non_finite, par)?, right }))
    }

    fn right(&self) -> &Columnwise {
        self.right.as_ref().unwrap_or(&self.left)
    }

    /// Returns the flags of entry (i, j) of C.
    pub fn flags(&self, i: usize, j: usize) -> Flags {
        let (left, right) = (&self.left, self.right());
        if left.finite[i] && right.finite[j] {
            return Flags(0);
        }
        if left.nan[i] || right.nan[j] {
            return Flags(Flags::NAN);
        }
        Flags::of(left.column(i), right.column(j))
    }

    /// Returns the work of a row of C with all its columns, in the unit of [`super::cost`]: a
    /// product of panels takes as long as a comparison of about 150 words.
    fn row_cost(&self) -> f64 {
        (self.right().finite.len() * self.left.height) as f64 / 150.0
    }

    /// Returns the work of [`Signs::add`].
    pub fn cost(&self, symmetric: bool) -> f64 {
        let rows = self.left.finite.len() as f64;
        self.row_cost() * if symmetric { rows / 2.0 } else { rows }
    }

    /// Adds to C what the columns that counted as zeros contribute.
    pub fn add<T: Real>(
        &self,
        alpha: T,
        symmetric: bool,
        c: MatMut<'_, T>,
        par: Par,
        progress: &Tracker<'_>,
    ) {
        let (n, k) = c.shape();
        let c = Disjoint::new(c);
        let share = self.cost(symmetric) / n.max(1) as f64;
        par.tickets(n, |i| {
            let columns = if symmetric { i + 1 } else { k };
            // SAFETY: each row is visited once.
            let mut row = unsafe { c.block(i..i + 1, 0..columns) };
            for j in 0..columns {
                if let Some(sum) = self.flags(i, j).sum() {
                    let value = row[(0, j)] + alpha * T::from_f64(sum);
                    // The same NaN on every machine.
                    let value = if value.to_f64().is_nan() { T::from_f64(f64::NAN) } else { value };
                    row[(0, j)] = value;
                }
            }
            progress.add(share)
        });
    }
}
