//! A reference of about 100 bits: double-double numbers, the exponential by squaring a non-negative
//! matrix, elimination by the definition.

use std::f64::consts::PI;
use std::ops::{Add, Div, Mul};

use catamaran_simulation::plant::{Conductivity, Plant, WaterOptions};

/// An unevaluated sum of two numbers (Dekker 1971).
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Double(f64, f64);

impl Double {
    pub fn new(x: f64) -> Self {
        Self(x, 0.0)
    }

    pub fn value(self) -> f64 {
        self.0 + self.1
    }

    fn normal(hi: f64, lo: f64) -> Self {
        let sum = hi + lo;
        Self(sum, lo - (sum - hi))
    }
}

impl Add for Double {
    type Output = Self;
    fn add(self, other: Self) -> Self {
        let sum = self.0 + other.0;
        let part = sum - self.0;
        let error = (self.0 - (sum - part)) + (other.0 - part);
        Self::normal(sum, error + self.1 + other.1)
    }
}

impl Mul for Double {
    type Output = Self;
    fn mul(self, other: Self) -> Self {
        let product = self.0 * other.0;
        let error = self.0.mul_add(other.0, -product);
        Self::normal(product, error + self.0 * other.1 + self.1 * other.0)
    }
}

impl Div for Double {
    type Output = Self;
    fn div(self, other: Self) -> Self {
        let negative = |x: f64| Self::new(-x);
        let first = self.0 / other.0;
        let rest = self + other * negative(first);
        let second = rest.0 / other.0;
        let rest = rest + other * negative(second);
        Self::normal(first, second) + Self::new(rest.0 / other.0)
    }
}

/// A complex number of about 100 bits.
#[derive(Debug, Clone, Copy)]
struct Complex {
    re: Double,
    im: Double,
}

impl Complex {
    fn real(re: Double) -> Self {
        Self { re, im: Double::new(0.0) }
    }

    fn scaled(self, s: Double) -> Self {
        Self { re: self.re * s, im: self.im * s }
    }

    fn inverse(self) -> Self {
        let scale = Double::new(1.0) / (self.re * self.re + self.im * self.im);
        Self { re: self.re * scale, im: self.im * scale * Double::new(-1.0) }
    }

    /// By the series of a 1024th of it, and squares.
    fn exponential(self) -> Self {
        const SQUARINGS: i32 = 10;
        let small = self.scaled(Double::new(0.5_f64.powi(SQUARINGS)));
        let one = Self::real(Double::new(1.0));
        let (mut sum, mut term) = (one, one);
        for k in 1..=24 {
            term = (term * small).scaled(Double::new(1.0) / Double::new(f64::from(k)));
            sum = sum + term;
        }
        (0..SQUARINGS).fold(sum, |power, _| power * power)
    }
}

impl Add for Complex {
    type Output = Self;
    fn add(self, other: Self) -> Self {
        Self { re: self.re + other.re, im: self.im + other.im }
    }
}

impl Mul for Complex {
    type Output = Self;
    fn mul(self, other: Self) -> Self {
        let minus = self.im * other.im * Double::new(-1.0);
        Self { re: self.re * other.re + minus, im: self.re * other.im + self.im * other.re }
    }
}

#[test]
fn double_double_divides_and_keeps_a_hundred_bits() {
    let [a, b] = [1.0 / 3.0, 0.7].map(Double::new);
    let back = a / b * b;
    assert!((back + Double::new(-1.0 / 3.0)).value().abs() < 1e-31);
    let tiny = Double::new(1.0) + Double::new(1e-25);
    assert_eq!((tiny + Double::new(-1.0)).value(), 1e-25);
}

/// The model by its definition, node by node.
pub struct Coefficients {
    pub parents: Vec<Option<usize>>,
    pub full: Vec<f64>,
    pub exchange: Vec<f64>,
    pub losses: Vec<f64>,
}

impl Coefficients {
    pub fn new(plant: &Plant, options: &WaterOptions) -> Self {
        let Conductivity::Pipe { scale } = options.conductivity else { panic!("a pipe") };
        let resistance = |v: usize| {
            let r = plant.segments()[v].radius;
            8.0 * options.viscosity * plant.lengths()[v] / (PI * r.powi(4)) / scale
        };
        let nodes = 0..plant.len();
        let parents: Vec<_> = nodes.clone().map(|v| plant.parent(v)).collect();
        let full: Vec<_> = nodes.clone().map(|v| options.density * plant.volume(v)).collect();
        let exchange = |v: usize| {
            let edge = |p| 2.0 / (resistance(p) + resistance(v));
            plant.parent(v).map_or(0.0, |p| options.modulus * options.density * edge(p))
        };
        let losses = nodes.clone().map(|v| options.loss * plant.leaf_area(v) / full[v]).collect();
        Self { parents, exchange: nodes.map(exchange).collect(), full, losses }
    }

    /// The largest rate at which a node alone would lose its water, in 1 / s.
    pub fn fastest_rate(&self) -> f64 {
        let mut sums = self.losses.clone();
        for v in 0..sums.len() {
            if let Some(p) = self.parents[v] {
                sums[v] += self.exchange[v] / self.full[v];
                sums[p] += self.exchange[v] / self.full[p];
            }
        }
        sums.into_iter().fold(0.0, f64::max)
    }

    /// exp(S t) water: `exp(S t) = (e^(-q h) exp((S + q) h))^(2^s)`, with `S + q >= 0`, so that
    /// nothing is subtracted.
    pub fn water_after(&self, water: &[f64], seconds: f64) -> Vec<f64> {
        let n = self.full.len();
        let squarings = (self.fastest_rate() * seconds).log2().ceil().max(0.0) as i32 + 6;
        let h = seconds / 2.0_f64.powi(squarings);
        // S h, whose entries are at most 1 / 64: a Taylor series of 14 terms is 30 digits.
        let zero = Double::new(0.0);
        let mut step = vec![zero; n * n];
        for v in 0..n {
            step[v * n + v] = step[v * n + v] + Double::new(-self.losses[v]) * Double::new(h);
            if let Some(p) = self.parents[v] {
                let w = Double::new(self.exchange[v]) * Double::new(h);
                for (a, b) in [(v, p), (p, v)] {
                    // Out of b into a.
                    let rate = w / Double::new(self.full[b]);
                    step[a * n + b] = step[a * n + b] + rate;
                    step[b * n + b] = step[b * n + b] + rate * Double::new(-1.0);
                }
            }
        }
        let mut power = identity(n);
        let mut sum = identity(n);
        for k in 1..=14 {
            power = product(&power, &step, n);
            let factor = Double::new(1.0) / Double::new(f64::from(k));
            power.iter_mut().for_each(|x| *x = *x * factor);
            sum.iter_mut().zip(&power).for_each(|(s, x)| *s = *s + *x);
        }
        for _ in 0..squarings {
            sum = product(&sum, &sum, n);
        }
        let row =
            |i: usize| (0..n).fold(zero, |s, j| s + sum[i * n + j] * Double::new(water[j])).value();
        (0..n).map(row).collect()
    }

    /// exp(S t) water by the integral of `e^z (z - S t)^-1 water / (2 pi i)` along a parabola
    /// (Weideman and Trefethen 2007), whose error with N points is about 2.85^-N: for large plants.
    pub fn water_by_contour(&self, water: &[f64], seconds: f64) -> Vec<f64> {
        const N: f64 = 56.0;
        // About 2 pi / N; any interval will do.
        const H: f64 = 0.112;
        const PI_REST: f64 = 1.2246467991473532e-16;
        let n = self.full.len();
        let order = self.preorder();
        let exact = |a: f64, b: f64| Double::new(a) * Double::new(b);
        let couplings: Vec<Complex> =
            self.exchange.iter().map(|w| Complex::real(exact(*w, seconds))).collect();
        let mut sums = vec![Double::new(0.0); n];
        for k in 0..28 {
            let u = exact(H, f64::from(k) + 0.5);
            let z = Complex {
                re: exact(N, 0.1309) + u * u * exact(-N, 0.1194),
                im: u * Double::new(0.25 * N),
            };
            let slope = Complex { re: u * exact(-N, 0.2388), im: Double::new(0.25 * N) };
            let weight = z.exponential() * slope;
            let mut d: Vec<Complex> = (0..n)
                .map(|v| {
                    let rate = Complex::real(exact(self.losses[v], seconds));
                    (z + rate).scaled(Double::new(self.full[v]))
                })
                .collect();
            let mut x: Vec<Complex> =
                water.iter().map(|w| Complex::real(Double::new(*w))).collect();
            for &v in order.iter().rev() {
                let pivot = (d[v] + couplings[v]).inverse();
                if let Some(p) = self.parents[v] {
                    let f = couplings[v] * pivot;
                    d[p] = d[p] + d[v] * f;
                    x[p] = x[p] + x[v] * f;
                }
                d[v] = pivot;
            }
            for &v in &order {
                x[v] = x[v] * d[v];
                if let Some(p) = self.parents[v] {
                    x[v] = x[v] + x[p] * couplings[v] * d[v];
                }
                sums[v] = sums[v] + (weight * x[v]).im;
            }
        }
        let pi = Double::new(PI) + Double::new(PI_REST);
        (0..n).map(|v| (sums[v] * exact(H, self.full[v]) / pi).value()).collect()
    }

    /// The nodes, parents before children.
    fn preorder(&self) -> Vec<usize> {
        let n = self.full.len();
        let mut children = vec![vec![]; n];
        let mut order = Vec::with_capacity(n);
        for v in 0..n {
            match self.parents[v] {
                Some(p) => children[p].push(v),
                None => order.push(v),
            }
        }
        let mut i = 0;
        while i < order.len() {
            let next = std::mem::take(&mut children[order[i]]);
            order.extend(next);
            i += 1;
        }
        order
    }

    /// The smallest eigenvalue of -S by inverse iteration.
    pub fn slowest_rate(&self) -> f64 {
        let n = self.full.len();
        let order = self.preorder();
        let double = |x: &Vec<f64>| x.iter().map(|&x| Double::new(x)).collect::<Vec<_>>();
        let (full, losses, w) = (double(&self.full), double(&self.losses), double(&self.exchange));
        let mut mode = vec![Double::new(1.0); n];
        let mut rate = 0.0;
        for _ in 0..60 {
            let mut d: Vec<Double> = (0..n).map(|v| full[v] * losses[v]).collect();
            let mut b: Vec<Double> = (0..n).map(|v| full[v] * mode[v]).collect();
            for &v in order.iter().rev() {
                if let Some(p) = self.parents[v] {
                    let f = w[v] / (d[v] + w[v]);
                    d[p] = d[p] + d[v] * f;
                    b[p] = b[p] + b[v] * f;
                }
            }
            let mut x = vec![Double::new(0.0); n];
            for &v in &order {
                x[v] = match self.parents[v] {
                    Some(p) => (b[v] + w[v] * x[p]) / (d[v] + w[v]),
                    None => b[v] / d[v],
                };
            }
            let sum = |f: &dyn Fn(usize) -> Double| (0..n).fold(Double::new(0.0), |s, v| s + f(v));
            let above = sum(&|v| full[v] * mode[v] * x[v]);
            let below = sum(&|v| full[v] * x[v] * x[v]);
            rate = (above / below).value();
            let largest = x.iter().map(|x| x.value()).fold(0.0, f64::max);
            mode = x.iter().map(|&x| x / Double::new(largest)).collect();
        }
        rate
    }
}

fn identity(n: usize) -> Vec<Double> {
    (0..n * n).map(|i| Double::new(if i % (n + 1) == 0 { 1.0 } else { 0.0 })).collect()
}

fn product(a: &[Double], b: &[Double], n: usize) -> Vec<Double> {
    let mut c = vec![Double::new(0.0); n * n];
    for i in 0..n {
        for k in 0..n {
            let x = a[i * n + k];
            if x.value() != 0.0 {
                for j in 0..n {
                    c[i * n + j] = c[i * n + j] + x * b[k * n + j];
                }
            }
        }
    }
    c
}

/// Mean squared error as a part of the mean square, as in figure 4.4 of the thesis.
pub fn relative_mse(water: &[f64], exact: &[f64]) -> f64 {
    let error: f64 = water.iter().zip(exact).map(|(a, b)| (a - b) * (a - b)).sum();
    error / exact.iter().map(|x| x * x).sum::<f64>()
}
