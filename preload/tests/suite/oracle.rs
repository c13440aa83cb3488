//! Products by their definition, in f64, and random matrices.

use catamaran::faer::{c32, c64};

/// A matrix of `rows` x `cols`, stored by columns or by rows with a leading dimension, and NaN
/// between the lines.
#[derive(Debug, Clone)]
pub struct Matrix<T> {
    pub data: Vec<T>,
    pub rows: usize,
    pub cols: usize,
    pub leading: usize,
    pub by_rows: bool,
}

/// f32, f64, or complex numbers of them.
pub trait Scalar: Copy + PartialEq + std::fmt::Debug + Send + Sync + 'static {
    type Real: Copy;
    const NAME: char;
    const ROUNDOFF: f64;
    const IS_COMPLEX: bool;
    fn of(x: c64) -> Self;
    fn to(self) -> c64;
    fn real(x: f64) -> Self::Real;
    fn bits(self) -> [u64; 2];

    /// Returns a factor of `gemm` that is complex where matrices are.
    fn factor(x: f64) -> c64 {
        let simple = !Self::IS_COMPLEX || x == 0.0 || x == 1.0;
        c64::new(x, if simple { 0.0 } else { 0.5 - x })
    }
}

macro_rules! real {
    ($t:ty, $name:literal) => {
        impl Scalar for $t {
            type Real = $t;
            const NAME: char = $name;
            const ROUNDOFF: f64 = <$t>::EPSILON as f64 / 2.0;
            const IS_COMPLEX: bool = false;
            fn of(x: c64) -> Self {
                x.re as $t
            }
            fn to(self) -> c64 {
                c64::new(self.into(), 0.0)
            }
            fn real(x: f64) -> $t {
                x as $t
            }
            fn bits(self) -> [u64; 2] {
                [self.to_bits().into(), 0]
            }
        }
    };
}

macro_rules! complex {
    ($t:ty, $real:ty, $name:literal) => {
        impl Scalar for $t {
            type Real = $real;
            const NAME: char = $name;
            const ROUNDOFF: f64 = <$real>::EPSILON as f64 / 2.0;
            const IS_COMPLEX: bool = true;
            fn of(x: c64) -> Self {
                <$t>::new(x.re as $real, x.im as $real)
            }
            fn to(self) -> c64 {
                c64::new(self.re.into(), self.im.into())
            }
            fn real(x: f64) -> $real {
                x as $real
            }
            fn bits(self) -> [u64; 2] {
                [self.re.to_bits().into(), self.im.to_bits().into()]
            }
        }
    };
}

real!(f32, 's');
real!(f64, 'd');
complex!(c32, f32, 'c');
complex!(c64, f64, 'z');

/// op(X): X, its transpose, or the conjugate of that.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Trans {
    No,
    Transposed,
    Conjugated,
}

impl From<bool> for Trans {
    fn from(transposed: bool) -> Self {
        if transposed { Self::Transposed } else { Self::No }
    }
}

impl Trans {
    pub fn transposes(self) -> bool {
        self != Self::No
    }
}

/// A sequence of numbers that look random (xorshift of 64 bits).
pub struct Random(pub u64);

impl Random {
    fn next(&mut self) -> u64 {
        self.0 ^= self.0 << 13;
        self.0 ^= self.0 >> 7;
        self.0 ^= self.0 << 17;
        self.0
    }

    /// Returns a number between -1 and 1.
    pub fn number(&mut self) -> f64 {
        (self.next() >> 11) as f64 / (1_u64 << 52) as f64 - 1.0
    }
}

impl<T: Scalar> Matrix<T> {
    pub fn new(
        rows: usize,
        cols: usize,
        by_rows: bool,
        gap: usize,
        mut entry: impl FnMut() -> f64,
    ) -> Self {
        let (lines, length) = if by_rows { (rows, cols) } else { (cols, rows) };
        let leading = length.max(1) + gap;
        let mut matrix = Self {
            data: vec![T::of(c64::new(f64::NAN, f64::NAN)); lines * leading],
            rows,
            cols,
            leading,
            by_rows,
        };
        for i in 0..rows {
            for j in 0..cols {
                let at = matrix.place(i, j);
                let im = if T::IS_COMPLEX { entry() } else { 0.0 };
                matrix.data[at] = T::of(c64::new(entry(), im));
            }
        }
        matrix
    }

    fn place(&self, i: usize, j: usize) -> usize {
        if self.by_rows { i * self.leading + j } else { i + j * self.leading }
    }

    /// Returns entry (i, j).
    pub fn value(&self, i: usize, j: usize) -> c64 {
        self.data[self.place(i, j)].to()
    }

    /// Returns the real part of entry (i, j).
    pub fn at(&self, i: usize, j: usize) -> f64 {
        self.value(i, j).re
    }

    /// Returns entry (i, j) of op(self).
    pub fn op(&self, trans: Trans, i: usize, j: usize) -> c64 {
        match trans {
            Trans::No => self.value(i, j),
            Trans::Transposed => self.value(j, i),
            Trans::Conjugated => self.value(j, i).conj(),
        }
    }

    pub fn bits(&self) -> Vec<u64> {
        self.data.iter().flat_map(|x| x.bits()).collect()
    }
}

impl<T: Scalar> PartialEq for Matrix<T> {
    fn eq(&self, other: &Self) -> bool {
        self.bits() == other.bits()
    }
}

/// Which entries of C are wanted.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Part {
    All,
    Lower,
    Upper,
}

impl Part {
    fn has(self, i: usize, j: usize) -> bool {
        match self {
            Self::All => true,
            Self::Lower => i >= j,
            Self::Upper => i <= j,
        }
    }
}

/// Checks `after`, which was `before`, against `alpha op(a) op(b) + beta before`: entries that are
/// not wanted, and gaps, have the same bits; others are within the bound of the classical algorithm
/// with the norms of the row and the column, four times, and eight times where they are complex.
pub fn check<T: Scalar, O: Into<Trans> + Copy>(
    sides: [(&Matrix<T>, O); 2],
    [alpha, beta]: [c64; 2],
    part: Part,
    before: &Matrix<T>,
    after: &Matrix<T>,
    context: &str,
) {
    let [a, b] = sides.map(|(matrix, trans)| (matrix, trans.into()));
    let depth = if a.1.transposes() { a.0.rows } else { a.0.cols };
    let row = |i: usize| (0..depth).map(move |l| a.0.op(a.1, i, l));
    let col = |j: usize| (0..depth).map(move |l| b.0.op(b.1, l, j));
    let norm = |x: &mut dyn Iterator<Item = c64>| x.map(|x| x.norm_sqr()).sum::<f64>().sqrt();
    let rows: Vec<f64> = (0..before.rows).map(|i| norm(&mut row(i))).collect();
    let cols: Vec<f64> = (0..before.cols).map(|j| norm(&mut col(j))).collect();
    let (zero, one) = (c64::new(0.0, 0.0), c64::new(1.0, 0.0));
    // `herk` makes the diagonal real, unless there is nothing to do.
    let nothing = (alpha == zero || depth == 0) && beta == one;
    let hermitian = T::IS_COMPLEX && part != Part::All && !nothing;
    let mut wanted = vec![false; before.data.len()];
    for i in 0..before.rows {
        for j in 0..before.cols {
            if !part.has(i, j) {
                continue;
            }
            let product: c64 =
                if alpha == zero { zero } else { row(i).zip(col(j)).map(|(x, y)| x * y).sum() };
            let mut old = if beta == zero { zero } else { beta * before.value(i, j) };
            wanted[before.place(i, j)] = true;
            if hermitian && i == j {
                old.im = 0.0;
                assert_eq!(after.value(i, j).im, 0.0, "{context}: ({i}, {j})");
            }
            let size = (depth as f64 + 2.0) * alpha.norm() * rows[i] * cols[j] + 4.0 * old.norm();
            let bound = if T::IS_COMPLEX { 8.0 } else { 4.0 } * T::ROUNDOFF * size;
            let error = after.value(i, j) - (alpha * product + old);
            let error = error.re.abs().max(error.im.abs());
            assert!(error <= bound, "{context}: ({i}, {j}): {error:e} > {bound:e}");
        }
    }
    for (place, (now, then)) in after.data.iter().zip(&before.data).enumerate() {
        assert!(wanted[place] || now.bits() == then.bits(), "{context}: {place} was written");
    }
}
