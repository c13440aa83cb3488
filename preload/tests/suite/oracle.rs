//! Products by their definition, in f64, and random matrices.

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

/// f32 or f64.
pub trait Scalar: Copy + PartialEq + std::fmt::Debug + Send + Sync + 'static {
    const NAME: char;
    const ROUNDOFF: f64;
    fn of(x: f64) -> Self;
    fn to(self) -> f64;
    fn bits(self) -> u64;
}

impl Scalar for f32 {
    const NAME: char = 's';
    const ROUNDOFF: f64 = f32::EPSILON as f64 / 2.0;
    fn of(x: f64) -> Self {
        x as f32
    }
    fn to(self) -> f64 {
        self.into()
    }
    fn bits(self) -> u64 {
        self.to_bits().into()
    }
}

impl Scalar for f64 {
    const NAME: char = 'd';
    const ROUNDOFF: f64 = f64::EPSILON / 2.0;
    fn of(x: f64) -> Self {
        x
    }
    fn to(self) -> f64 {
        self
    }
    fn bits(self) -> u64 {
        self.to_bits()
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

    /// Between -1 and 1.
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
        let mut matrix =
            Self { data: vec![T::of(f64::NAN); lines * leading], rows, cols, leading, by_rows };
        for i in 0..rows {
            for j in 0..cols {
                let at = matrix.place(i, j);
                matrix.data[at] = T::of(entry());
            }
        }
        matrix
    }

    fn place(&self, i: usize, j: usize) -> usize {
        if self.by_rows { i * self.leading + j } else { i + j * self.leading }
    }

    pub fn at(&self, i: usize, j: usize) -> f64 {
        self.data[self.place(i, j)].to()
    }

    /// op(self), entry (i, j).
    pub fn op(&self, transposed: bool, i: usize, j: usize) -> f64 {
        if transposed { self.at(j, i) } else { self.at(i, j) }
    }

    pub fn bits(&self) -> Vec<u64> {
        self.data.iter().map(|x| x.bits()).collect()
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
/// with the norms of the row and the column, four times.
pub fn check<T: Scalar>(
    [a, b]: [(&Matrix<T>, bool); 2],
    [alpha, beta]: [f64; 2],
    part: Part,
    before: &Matrix<T>,
    after: &Matrix<T>,
    context: &str,
) {
    let depth = if a.1 { a.0.rows } else { a.0.cols };
    let row = |i: usize| (0..depth).map(move |l| a.0.op(a.1, i, l));
    let col = |j: usize| (0..depth).map(move |l| b.0.op(b.1, l, j));
    let norm = |x: &mut dyn Iterator<Item = f64>| x.map(|x| x * x).sum::<f64>().sqrt();
    let rows: Vec<f64> = (0..before.rows).map(|i| norm(&mut row(i))).collect();
    let cols: Vec<f64> = (0..before.cols).map(|j| norm(&mut col(j))).collect();
    let (mut expected, mut wanted) = (before.clone(), vec![false; before.data.len()]);
    for i in 0..before.rows {
        for j in 0..before.cols {
            if !part.has(i, j) {
                continue;
            }
            let product: f64 =
                if alpha == 0.0 { 0.0 } else { row(i).zip(col(j)).map(|(x, y)| x * y).sum() };
            let old = if beta == 0.0 { 0.0 } else { beta * before.at(i, j) };
            let place = before.place(i, j);
            expected.data[place] = T::of(alpha * product + old);
            wanted[place] = true;
            let bound = 4.0
                * T::ROUNDOFF
                * ((depth as f64 + 2.0) * alpha.abs() * rows[i] * cols[j] + 4.0 * old.abs());
            let error = (after.at(i, j) - (alpha * product + old)).abs();
            assert!(error <= bound, "{context}: ({i}, {j}): {error:e} > {bound:e}");
        }
    }
    for (place, (now, then)) in after.data.iter().zip(&before.data).enumerate() {
        assert!(wanted[place] || now.bits() == then.bits(), "{context}: {place} was written");
    }
}
