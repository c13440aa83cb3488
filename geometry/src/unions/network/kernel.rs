//! Small dense arithmetic. Every sum has one order, with one rounding for each term, so that
//! results depend neither on the CPU nor on the grouping of rows.

use std::array::from_fn;
use std::ops::Range;

use pulp::{Scalar, Simd, WithSimd};

use catamaran::base::{Real, arch};

/// A scalar with the operations that a network needs.
pub trait Number: Real + Lanes {
    /// Returns the square root.
    fn sqrt(self) -> Self;
    /// Returns `self * factor + term`, rounded once.
    fn mul_add(self, factor: Self, term: Self) -> Self;
    /// Returns the exponential function.
    fn exp(self) -> Self;
    /// Returns sine and cosine.
    fn sin_cos(self) -> (Self, Self);
}

macro_rules! number {
    ($($type:ty),*) => {$(
        impl Number for $type {
            fn sqrt(self) -> Self {
                self.sqrt()
            }

            #[inline(always)]
            fn mul_add(self, factor: Self, term: Self) -> Self {
                self.mul_add(factor, term)
            }

            fn exp(self) -> Self {
                self.exp()
            }

            fn sin_cos(self) -> (Self, Self) {
                self.sin_cos()
            }
        }
    )*};
}

number!(f32, f64);

/// Scalars in SIMD vectors.
pub trait Lanes: Sized {
    /// The vector of these scalars.
    type Vector<S: Simd>: Copy;

    /// Returns the number of scalars in a vector.
    fn lanes<S: Simd>() -> usize;
    /// Returns `x` in all lanes.
    fn splat<S: Simd>(simd: S, x: Self) -> Self::Vector<S>;
    /// Loads the first vectors of `x`.
    fn load<S: Simd, const N: usize>(x: &[Self]) -> [Self::Vector<S>; N];
    /// Stores vectors at the beginning of `x`.
    fn store<S: Simd, const N: usize>(x: &mut [Self], vectors: [Self::Vector<S>; N]);
    /// Returns `a * b + c`, rounded once.
    fn fused<S: Simd>(
        simd: S,
        a: Self::Vector<S>,
        b: Self::Vector<S>,
        c: Self::Vector<S>,
    ) -> Self::Vector<S>;
}

macro_rules! lanes {
    ($type:ty: $vector:ident, $lanes:ident, $splat:ident, $load:ident, $store:ident, $fused:ident) => {
        impl Lanes for $type {
            type Vector<S: Simd> = S::$vector;

            #[inline(always)]
            fn lanes<S: Simd>() -> usize {
                S::$lanes
            }

            #[inline(always)]
            fn splat<S: Simd>(simd: S, x: Self) -> S::$vector {
                simd.$splat(x)
            }

            #[inline(always)]
            fn load<S: Simd, const N: usize>(x: &[Self]) -> [S::$vector; N] {
                *S::$load(x).0.first_chunk().unwrap()
            }

            #[inline(always)]
            fn store<S: Simd, const N: usize>(x: &mut [Self], vectors: [S::$vector; N]) {
                *S::$store(x).0.first_chunk_mut().unwrap() = vectors;
            }

            #[inline(always)]
            fn fused<S: Simd>(simd: S, a: S::$vector, b: S::$vector, c: S::$vector) -> S::$vector {
                simd.$fused(a, b, c)
            }
        }
    };
}

lanes!(f32: f32s, F32_LANES, splat_f32s, as_simd_f32s, as_mut_simd_f32s, mul_add_f32s);
lanes!(f64: f64s, F64_LANES, splat_f64s, as_simd_f64s, as_mut_simd_f64s, mul_add_f64s);

/// Computes `c += a b` with b (inner x columns) and c (rows x columns) by rows; entry (i, k) of a
/// is `a[i * strides.0 + k * strides.1]`.
///
/// ```
/// use catamaran_geometry::unions::network::gemm;
///
/// let mut c = [1.0_f32, 0.0];
/// gemm((1, 2, 2), &[2.0, 3.0], (2, 1), &[1.0, 0.0, 0.0, 1.0], &mut c);
/// assert_eq!(c, [3.0, 3.0]);
/// ```
///
/// # Panics
/// When a slice is too short.
pub fn gemm<T: Number>(
    (rows, inner, columns): (usize, usize, usize),
    a: &[T],
    strides: (usize, usize),
    b: &[T],
    c: &mut [T],
) {
    arch().dispatch(Gemm { rows, inner, columns, a, strides, b, c });
}

struct Gemm<'a, T> {
    rows: usize,
    inner: usize,
    columns: usize,
    a: &'a [T],
    strides: (usize, usize),
    b: &'a [T],
    c: &'a mut [T],
}

impl<T: Number> WithSimd for Gemm<'_, T> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: Simd>(mut self, simd: S) {
        for start in (0..self.inner).step_by(DEPTH) {
            let terms = start..self.inner.min(start + DEPTH);
            if self.columns >= T::lanes::<S>() {
                self.add(simd, terms);
            } else if self.columns > 0 {
                self.add(Scalar, terms);
            }
        }
    }
}

/// Number of terms that are added at a time: the part of a that a tile needs for them stays in the
/// first-level cache.
const DEPTH: usize = 128;

/// Number of scalars in the longest vectors.
const MOST_LANES: usize = 16;

impl<T: Number> Gemm<'_, T> {
    /// Adds some of the terms, tile by tile of c. The sums of a tile stay in registers: 12 vectors
    /// with 16 registers, 24 with 32. Tiles of fewer rows are wider, because 8 sums at once hide
    /// the latency of an addition.
    #[inline(always)]
    fn add<S: Simd>(&mut self, simd: S, terms: Range<usize>) {
        let terms = &terms;
        if S::REGISTER_COUNT >= 32 {
            let row = self.add_to_rows::<S, 8, 3>(simd, terms, 0);
            let row = self.add_to_rows::<S, 4, 6>(simd, terms, row);
            let row = self.add_to_rows::<S, 2, 6>(simd, terms, row);
            self.add_to_rows::<S, 1, 12>(simd, terms, row);
        } else {
            let row = self.add_to_rows::<S, 4, 3>(simd, terms, 0);
            let row = self.add_to_rows::<S, 2, 4>(simd, terms, row);
            self.add_to_rows::<S, 1, 8>(simd, terms, row);
        }
    }

    /// Adds the terms to the rows from `row` on, in tiles of `TALL` rows and `WIDE` vectors, or of
    /// one vector where columns run out. Returns the first row left over.
    #[inline(always)]
    fn add_to_rows<S: Simd, const TALL: usize, const WIDE: usize>(
        &mut self,
        simd: S,
        terms: &Range<usize>,
        mut row: usize,
    ) -> usize {
        let Self { rows, columns, a, strides, b, .. } = *self;
        if row + TALL > rows {
            return row;
        }
        let lanes = T::lanes::<S>();
        let b = &b[terms.start * columns..];
        let mut packed = [[T::ZERO; TALL]; DEPTH];
        let packed = &mut packed[..terms.len()];
        while row + TALL <= rows {
            pack(&a[row * strides.0 + terms.start * strides.1..], strides, packed);
            let c = &mut self.c[row * columns..];
            let mut column = 0;
            while column + WIDE * lanes <= columns {
                let (b, c) = (&b[column..], &mut c[column..]);
                tile::<T, S, TALL, WIDE>(simd, packed, (b, columns), (c, columns));
                column += WIDE * lanes;
            }
            while column + lanes <= columns {
                let (b, c) = (&b[column..], &mut c[column..]);
                tile::<T, S, TALL, 1>(simd, packed, (b, columns), (c, columns));
                column += lanes;
            }
            if column < columns {
                // The last vector of columns may overlap columns that are done already; their new
                // sums are dropped.
                let last = columns - lanes;
                let mut sums = [[T::ZERO; MOST_LANES]; TALL];
                for i in 0..TALL {
                    sums[i][..lanes].copy_from_slice(&c[i * columns + last..][..lanes]);
                }
                let (b, new) = (&b[last..], sums.as_flattened_mut());
                tile::<T, S, TALL, 1>(simd, packed, (b, columns), (new, MOST_LANES));
                for i in 0..TALL {
                    c[i * columns + column..][..columns - column]
                        .copy_from_slice(&sums[i][column - last..lanes]);
                }
            }
            row += TALL;
        }
        row
    }
}

/// Packs the first rows of `a` by columns.
#[inline(always)]
fn pack<T: Number, const TALL: usize>(a: &[T], strides: (usize, usize), packed: &mut [[T; TALL]]) {
    if strides.0 == 1 {
        for (k, packed) in packed.iter_mut().enumerate() {
            packed.copy_from_slice(&a[k * strides.1..][..TALL]);
        }
    } else if strides.1 == 1 {
        let rows: [_; TALL] = from_fn(|i| &a[i * strides.0..][..packed.len()]);
        for (k, packed) in packed.iter_mut().enumerate() {
            *packed = from_fn(|i| rows[i][k]);
        }
    } else {
        for (k, packed) in packed.iter_mut().enumerate() {
            *packed = from_fn(|i| a[i * strides.0 + k * strides.1]);
        }
    }
}

/// Computes `c += a b` for `TALL` rows of c and the first `WIDE` vectors of each, with `a` by
/// columns. Rows of b and c come with their strides.
#[inline(always)]
fn tile<T: Number, S: Simd, const TALL: usize, const WIDE: usize>(
    simd: S,
    a: &[[T; TALL]],
    (b, b_stride): (&[T], usize),
    (c, c_stride): (&mut [T], usize),
) {
    let mut sums: [[_; WIDE]; TALL] = from_fn(|i| T::load::<S, WIDE>(&c[i * c_stride..]));
    for (k, a) in a.iter().enumerate() {
        let b = T::load::<S, WIDE>(&b[k * b_stride..]);
        for i in 0..TALL {
            let a = T::splat(simd, a[i]);
            for j in 0..WIDE {
                sums[i][j] = T::fused(simd, a, b[j], sums[i][j]);
            }
        }
    }
    for i in 0..TALL {
        T::store(&mut c[i * c_stride..], sums[i]);
    }
}

/// Returns the sum of `f(0..n)`, by eight partial sums.
#[inline(always)]
pub fn sum<T: Number>(n: usize, f: impl Fn(usize) -> T) -> T {
    let mut parts = [T::ZERO; 8];
    let whole = n - n % 8;
    for start in (0..whole).step_by(8) {
        for lane in 0..8 {
            parts[lane] += f(start + lane);
        }
    }
    for i in whole..n {
        parts[i - whole] += f(i);
    }
    ((parts[0] + parts[4]) + (parts[2] + parts[6]))
        + ((parts[1] + parts[5]) + (parts[3] + parts[7]))
}

/// Applies layer normalization (Ba, Kiros and Hinton 2016): `unit` gets each row of `x` minus its
/// mean, divided by its standard deviation; `y` gets `unit` times `scale` plus `shift`; `inverse`
/// gets the inverse regularized deviations.
///
/// # Panics
/// When a slice is too short.
pub fn normalize<T: Number>(
    x: &[T],
    [scale, shift]: [&[T]; 2],
    unit: &mut [T],
    inverse: &mut [T],
    y: &mut [T],
) {
    let width = scale.len();
    let count = T::from_f64(width as f64);
    for (row, x) in x.chunks_exact(width).enumerate() {
        let unit = &mut unit[row * width..(row + 1) * width];
        let y = &mut y[row * width..(row + 1) * width];
        let mean = sum(width, |j| x[j]) / count;
        let variance = sum(width, |j| (x[j] - mean) * (x[j] - mean)) / count;
        inverse[row] = T::ONE / (variance + T::from_f64(1e-5)).sqrt();
        for j in 0..width {
            unit[j] = (x[j] - mean) * inverse[row];
            y[j] = unit[j] * scale[j] + shift[j];
        }
    }
}

#[cfg(test)]
mod tests {
    use pulp::Arch;

    use super::*;
    use catamaran::base::Rng;

    /// Returns the instruction sets of this machine.
    fn instruction_sets() -> Vec<Arch> {
        let mut sets = vec![arch(), Arch::Scalar];
        #[cfg(target_arch = "x86_64")]
        sets.extend(pulp::x86::V3::try_new().map(Arch::V3));
        sets
    }

    fn products_are_those_of_the_definition<T: Number>(
        (rows, inner, columns): (usize, usize, usize),
    ) {
        let mut rng = Rng::new(3);
        let mut random = |n: usize| (0..n).map(|_| T::from_f64(rng.normal())).collect::<Vec<_>>();
        let (a, b, c) = (random(3 * rows * inner), random(inner * columns), random(rows * columns));
        for strides in [(inner, 1), (1, rows), (3 * inner, 2)] {
            let mut expected = c.clone();
            for i in 0..rows {
                for j in 0..columns {
                    for k in 0..inner {
                        let (a, b) = (a[i * strides.0 + k * strides.1], b[k * columns + j]);
                        let sum = &mut expected[i * columns + j];
                        *sum = a.mul_add(b, *sum);
                    }
                }
            }
            for set in instruction_sets() {
                let (a, b, mut found) = (&a, &b, c.clone());
                set.dispatch(Gemm { rows, inner, columns, a, strides, b, c: &mut found });
                let bits = |x: &[T]| x.iter().map(|x| x.to_f64().to_bits()).collect::<Vec<_>>();
                let case = format!("{rows} {inner} {columns} {strides:?} {set:?}");
                assert_eq!(bits(&found), bits(&expected), "{case}");
            }
        }
    }

    #[test]
    fn products_are_those_of_the_definition_to_the_bit() {
        for rows in [0, 1, 2, 3, 7, 15] {
            for inner in [0, 1, 5, 128, 131] {
                for columns in [0, 1, 3, 8, 13, 16, 31, 100, 201] {
                    products_are_those_of_the_definition::<f32>((rows, inner, columns));
                    products_are_those_of_the_definition::<f64>((rows, inner, columns));
                }
            }
        }
    }

    #[test]
    fn rows_are_normalized() {
        let x: Vec<f64> = (0..3 * 13).map(|i| ((i * i) % 17) as f64).collect();
        let (mut unit, mut y, mut inverse) = (vec![0.0; 39], vec![0.0; 39], vec![0.0; 3]);
        normalize(&x, [&[2.0; 13], &[1.0; 13]], &mut unit, &mut inverse, &mut y);
        for row in 0..3 {
            let unit = &unit[row * 13..(row + 1) * 13];
            assert!(unit.iter().sum::<f64>().abs() < 1e-12);
            assert!((unit.iter().map(|x| x * x).sum::<f64>() / 13.0 - 1.0).abs() < 1e-4);
            assert!((y[row * 13] - 2.0 * unit[0] - 1.0).abs() < 1e-12);
        }
    }
}
