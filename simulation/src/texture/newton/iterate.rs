//! The iteration. `simulation/src/opencl/kernels/newton.cl` does the same in the same order; change
//! both.
//!
//! A step of z^n - 1 is equation 7.2 of the thesis, z := ((n - 1) z + (1 / z)^(n - 1)) / n, the
//! power by repeated squaring. A step of a polynomial with given roots is z := z - 1 / (1 / (z -
//! r_1) + 1 / (z - r_2) + ...).

// Everything is `inline(always)`: functions that are not inlined, closures above all, are compiled
// without the wide registers.
use pulp::{Simd, WithSimd};

use super::lanes::{Lanes, MOST_LANES, Mask, TO_NEAREST, to_nearest};
use super::options::Parameters;
use super::points::Cursor;
use catamaran::base::arch;

/// Marks the number of a root that a point does not reach; numbers are below 64^2.
pub(super) const UNREACHED: u16 = 1 << 15;

/// Values with |z|^2 below this count as 0.
const ZERO: f32 = 1e-30;
/// |step|^2 that stands for a step to infinity.
const ENDLESS: f32 = 1e30;
/// A longer step counts as this long: 1 / (1 + exp(d + theta) - exp(theta)) is 0 for all theta.
const LONG: f32 = 30.0;

/// A complex number in each lane.
#[derive(Clone, Copy)]
struct Complex<S: Simd> {
    re: Lanes<S>,
    im: Lanes<S>,
}

impl<S: Simd> Complex<S> {
    #[inline(always)]
    fn times(self, other: Self) -> Self {
        Self {
            re: self.re * other.re - self.im * other.im,
            im: self.re * other.im + self.im * other.re,
        }
    }

    #[inline(always)]
    fn minus(self, other: Self) -> Self {
        Self { re: self.re - other.re, im: self.im - other.im }
    }

    #[inline(always)]
    fn scaled(self, by: Lanes<S>) -> Self {
        Self { re: self.re * by, im: self.im * by }
    }

    /// Returns |z|^2.
    #[inline(always)]
    fn norm2(self) -> Lanes<S> {
        self.re * self.re + self.im * self.im
    }

    /// Returns 1 / z; `norm2` is |z|^2.
    #[inline(always)]
    fn inverse(self, norm2: Lanes<S>) -> Self {
        let all = norm2.all(1.0) / norm2;
        Self { re: self.re * all, im: norm2.all(0.0) - self.im * all }
    }

    #[inline(always)]
    fn select(mask: Mask<S>, yes: Self, no: Self) -> Self {
        Self { re: mask.select(yes.re, no.re), im: mask.select(yes.im, no.im) }
    }
}

/// Computes the fractal at as many points as `roots` and `convergence` have, from the position of
/// `cursor` on.
pub(super) fn evaluate(
    parameters: &Parameters,
    cursor: Cursor<'_>,
    roots: &mut [u16],
    convergence: &mut [f32],
) {
    arch().dispatch(Block { parameters, cursor, roots, convergence });
}

struct Block<'a> {
    parameters: &'a Parameters,
    cursor: Cursor<'a>,
    roots: &'a mut [u16],
    convergence: &'a mut [f32],
}

impl WithSimd for Block<'_> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: Simd>(self, simd: S) {
        let Self { parameters, mut cursor, roots, convergence } = self;
        let mut memory = [[0.0; MOST_LANES]; 3];
        let outputs = roots.chunks_mut(S::F32_LANES).zip(convergence.chunks_mut(S::F32_LANES));
        for (roots, convergence) in outputs {
            for lane in 0..roots.len() {
                let point = cursor.advance();
                for c in 0..3 {
                    memory[c][lane] = point[c];
                }
            }
            let [x, y, z] = &memory;
            let (x, y, z) = (Lanes::load(simd, x), Lanes::load(simd, y), Lanes::load(simd, z));
            let (root, t) = iterate(parameters, x, y, z);
            root.store(&mut memory[0]);
            t.store(&mut memory[1]);
            for (lane, (root, t)) in roots.iter_mut().zip(convergence).enumerate() {
                *root = memory[0][lane] as u16;
                *t = memory[1][lane];
            }
        }
    }
}

/// Returns the number of the root, plus [`UNREACHED`] for a point that does not reach it, and t.
#[inline(always)]
fn iterate<S: Simd>(p: &Parameters, x: Lanes<S>, y: Lanes<S>, z: Lanes<S>) -> (Lanes<S>, Lanes<S>) {
    let scale = x.all(p.scale);
    let x = (x + x.all(p.offset[0])) * scale;
    let y = (y + y.all(p.offset[1])) * scale;
    let z = (z + z.all(p.offset[2])) * scale;
    let w = x.all(p.offset[3]) * scale;
    let mut alpha = Complex { re: x + w, im: y - z };
    let mut beta = Complex { re: x - w, im: y + z };
    let mut sum = x.all(0.0);
    // No lane has converged yet.
    let mut active = sum.is_below(x.all(1.0));
    for _ in 0..p.steps {
        let (next_alpha, step_alpha) = step(p, alpha);
        let (next_beta, step_beta) = step(p, beta);
        let step2 = (step_alpha + step_beta) * x.all(0.5);
        let length = if p.squared { step2 } else { step2.sqrt() };
        let excess = exp_minus_one(length.min(x.all(LONG))) * x.all(p.gain);
        sum = active.select(sum + excess / (excess + x.all(1.0)), sum);
        alpha = Complex::select(active, next_alpha, alpha);
        beta = Complex::select(active, next_beta, beta);
        active = active & !step2.is_below(x.all(p.arrived));
        if !active.any() {
            break;
        }
    }
    let root = root_of(p, alpha) * x.all(p.degree as f32) + root_of(p, beta);
    let root = root + active.select(x.all(f32::from(UNREACHED)), x.all(0.0));
    (root, sum * x.all(p.factor) + x.all(p.shift))
}

/// Returns the next iterate of Newton's method from z, and the square of the step.
#[inline(always)]
fn step<S: Simd>(p: &Parameters, z: Complex<S>) -> (Complex<S>, Lanes<S>) {
    if p.roots.is_empty() { step_of_power(p, z) } else { step_of_roots(p, z) }
}

#[inline(always)]
fn step_of_power<S: Simd>(p: &Parameters, z: Complex<S>) -> (Complex<S>, Lanes<S>) {
    let norm2 = z.norm2();
    let nearest = norm2.all(p.nearest);
    let near = norm2.is_below(nearest);
    if !near.any() {
        let to = mean_with_power(p, z, z.inverse(norm2));
        return (to, to.minus(z).norm2());
    }
    // The same direction at a distance whose power is finite.
    let zero = norm2.is_below(norm2.all(ZERO));
    let away = (nearest / norm2.max(norm2.all(ZERO))).sqrt();
    let moved = Complex::select(near, z.scaled(away), z);
    let inverse = moved.inverse(zero.select(norm2.all(1.0), moved.norm2()));
    let to = Complex::select(zero, z, mean_with_power(p, z, inverse));
    (to, zero.select(norm2.all(ENDLESS), to.minus(z).norm2()))
}

/// Returns ((n - 1) z + inverse^(n - 1)) / n.
#[inline(always)]
fn mean_with_power<S: Simd>(p: &Parameters, z: Complex<S>, inverse: Complex<S>) -> Complex<S> {
    let n = z.re.all(p.degree as f32);
    let (ours, other) = (z.re.all((p.degree - 1) as f32) / n, z.re.all(1.0) / n);
    let power = power(inverse, p.degree - 1);
    Complex { re: z.re * ours + power.re * other, im: z.im * ours + power.im * other }
}

/// Returns z^n, n >= 1.
#[inline(always)]
fn power<S: Simd>(z: Complex<S>, n: u32) -> Complex<S> {
    let mut result = z;
    for bit in (0..n.ilog2()).rev() {
        result = result.times(result);
        if n >> bit & 1 == 1 {
            result = result.times(z);
        }
    }
    result
}

#[inline(always)]
fn step_of_roots<S: Simd>(p: &Parameters, z: Complex<S>) -> (Complex<S>, Lanes<S>) {
    let nothing = z.re.all(0.0);
    let zero = nothing.all(ZERO);
    let mut sum = Complex { re: nothing, im: nothing };
    let mut closest = nothing.all(f32::MAX);
    for &[re, im] in &p.roots {
        let away = z.minus(Complex { re: nothing.all(re), im: nothing.all(im) });
        let norm2 = away.norm2();
        closest = closest.min(norm2);
        let inverse = away.inverse(norm2.max(zero));
        sum = Complex { re: sum.re + inverse.re, im: sum.im + inverse.im };
    }
    let norm2 = sum.norm2();
    let (at_root, endless) = (closest.is_below(zero), norm2.is_below(zero));
    let to = z.minus(sum.inverse(norm2.max(zero)));
    let to = Complex::select(at_root, z, Complex::select(endless, z, to));
    let step2 = endless.select(nothing.all(ENDLESS), to.minus(z).norm2());
    (to, at_root.select(nothing, step2))
}

/// Returns exp(x) - 1 for x from 0 to [`LONG`], with a relative error of about 1e-7, even for small
/// x: x = n ln 2 + r, and exp(x) - 1 = 2^n (exp(r) - 1) + (2^n - 1), exp(r) - 1 by its Taylor
/// series.
#[inline(always)]
fn exp_minus_one<S: Simd>(x: Lanes<S>) -> Lanes<S> {
    let shifted = to_nearest(x * x.all(std::f32::consts::LOG2_E));
    let n = shifted - x.all(TO_NEAREST);
    // ln 2 in two parts; the first has so few bits that its product with n is exact.
    let r = (x - n * x.all(0.693_359_4)) - n * x.all(-2.121_944_4e-4);
    let mut series = x.all(1.0 / 5040.0);
    for divisor in [720.0, 120.0, 24.0, 6.0, 2.0] {
        series = series * r + x.all(1.0 / divisor);
    }
    let small = (series * r) * r + r;
    let power = shifted.power_of_two();
    power * small + (power - x.all(1.0))
}

/// Returns the number, from 0, of the root nearest to z.
#[inline(always)]
fn root_of<S: Simd>(p: &Parameters, z: Complex<S>) -> Lanes<S> {
    if p.roots.is_empty() { root_by_angle(p, z) } else { root_by_distance(p, z) }
}

/// Returns the number of the root by angle: root k of z^n - 1 has the angle 2 pi k / n.
#[inline(always)]
fn root_by_angle<S: Simd>(p: &Parameters, z: Complex<S>) -> Lanes<S> {
    let n = z.re.all(p.degree as f32);
    let k = to_nearest(turn(z) * n) - n.all(TO_NEAREST);
    k.is_below(n.all(0.0)).select(k + n, k)
}

/// Returns the angle of z as a fraction of the full turn, from -1/2 to 1/2; 0 for 0. The error is
/// about 1e-7: arctangent by Abramowitz and Stegun, equation 4.4.49.
#[inline(always)]
fn turn<S: Simd>(z: Complex<S>) -> Lanes<S> {
    const SERIES: [f32; 9] = [
        0.002_866_225_7,
        -0.016_165_737,
        0.042_909_614,
        -0.075_289_64,
        0.106_562_64,
        -0.142_089,
        0.199_935_51,
        -0.333_331_45,
        1.0,
    ];
    let (x, y) = (z.re.abs(), z.im.abs());
    let (low, high) = (x.min(y), x.max(y));
    // Avoids 0 / 0.
    let q = low / high.max(z.re.all(1e-30));
    let q2 = q * q;
    let mut series = z.re.all(0.0);
    for coefficient in SERIES {
        series = series * q2 + z.re.all(coefficient);
    }
    let eighth = series * q * z.re.all(0.5 / std::f32::consts::PI);
    let quarter = x.is_below(y).select(z.re.all(0.25) - eighth, eighth);
    let half = z.re.is_below(z.re.all(0.0)).select(z.re.all(0.5) - quarter, quarter);
    z.im.is_below(z.re.all(0.0)).select(z.re.all(0.0) - half, half)
}

#[inline(always)]
fn root_by_distance<S: Simd>(p: &Parameters, z: Complex<S>) -> Lanes<S> {
    let (mut best, mut closest) = (z.re.all(0.0), z.re.all(f32::MAX));
    for (k, &[re, im]) in p.roots.iter().enumerate() {
        let norm2 = z.minus(Complex { re: z.re.all(re), im: z.re.all(im) }).norm2();
        let closer = norm2.is_below(closest);
        best = closer.select(z.re.all(k as f32), best);
        closest = closer.select(norm2, closest);
    }
    best
}
