//! Small dense arithmetic. Every sum is taken in one order, with one rounding a term, so that results depend neither on the CPU
//! nor on how rows are grouped.

use pulp::{Arch, Simd, WithSimd};

use crate::base::Real;

/// A scalar with what a network needs.
pub trait Number: Real {
    /// The square root.
    fn sqrt(self) -> Self;
    /// `self * factor + term`, rounded once.
    fn mul_add(self, factor: Self, term: Self) -> Self;
    /// The exponential function.
    fn exp(self) -> Self;
    /// Sine and cosine.
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

/// `c += a b` with b (inner x columns) and c (rows x columns) by rows; entry (i, k) of a is `a[i * strides.0 + k * strides.1]`.
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
    Arch::new().dispatch(Gemm { rows, inner, columns, a, strides, b, c });
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
    fn with_simd<S: Simd>(mut self, _: S) {
        let mut column = 0;
        while column + 32 <= self.columns {
            self.strip::<32>(column);
            column += 32;
        }
        while column + 4 <= self.columns {
            self.strip::<4>(column);
            column += 4;
        }
        while column < self.columns {
            self.strip::<1>(column);
            column += 1;
        }
    }
}

impl<T: Number> Gemm<'_, T> {
    /// `WIDE` columns.
    #[inline(always)]
    fn strip<const WIDE: usize>(&mut self, column: usize) {
        let mut row = 0;
        // Twice 32 sums are what the registers of AVX2 hold; with more of them compilers spill.
        while row + 2 <= self.rows {
            self.tile::<2, WIDE>(row, column);
            row += 2;
        }
        while row < self.rows {
            self.tile::<1, WIDE>(row, column);
            row += 1;
        }
    }

    #[inline(always)]
    fn tile<const TALL: usize, const WIDE: usize>(&mut self, row: usize, column: usize) {
        let mut sums = [[T::ZERO; WIDE]; TALL];
        for i in 0..TALL {
            let start = (row + i) * self.columns + column;
            sums[i].copy_from_slice(&self.c[start..start + WIDE]);
        }
        for k in 0..self.inner {
            let start = k * self.columns + column;
            let b = &self.b[start..start + WIDE];
            for i in 0..TALL {
                let a = self.a[(row + i) * self.strides.0 + k * self.strides.1];
                for j in 0..WIDE {
                    sums[i][j] = a.mul_add(b[j], sums[i][j]);
                }
            }
        }
        for i in 0..TALL {
            let start = (row + i) * self.columns + column;
            self.c[start..start + WIDE].copy_from_slice(&sums[i]);
        }
    }
}

/// The sum of `f(0..n)` by eight partial sums.
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

/// Layer normalisation (Ba, Kiros and Hinton 2016): each row of `x` less its mean, over its standard deviation, goes to
/// `unit`; that times `scale` plus `shift` to `y`; one over the deviations, regularised, to `inverse`.
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
    use super::*;
    use crate::base::Rng;

    #[test]
    fn products_are_those_of_the_definition_with_any_strides() {
        let mut rng = Rng::new(3);
        for (rows, inner, columns) in [(0, 3, 3), (1, 1, 1), (3, 0, 2), (5, 7, 33), (8, 20, 64)] {
            let mut random = |n: usize| (0..n).map(|_| rng.normal()).collect::<Vec<f64>>();
            let (a, b, c) = (random(rows * inner), random(inner * columns), random(rows * columns));
            for strides in [(inner, 1), (1, rows)] {
                let mut found = c.clone();
                gemm((rows, inner, columns), &a, strides, &b, &mut found);
                for i in 0..rows {
                    for j in 0..columns {
                        let sum: f64 = (0..inner)
                            .map(|k| a[i * strides.0 + k * strides.1] * b[k * columns + j])
                            .sum();
                        assert!((found[i * columns + j] - c[i * columns + j] - sum).abs() < 1e-12);
                    }
                }
            }
        }
    }

    #[test]
    fn rows_are_normalised() {
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
