//! Newton's fractals in four dimensions, by bicomplex numbers (thesis, chapter 7).
//!
//! A point (x, y, z, w) is the bicomplex number x + y i + z j + w k with i^2 = j^2 = -1 and k = i j, k^2 = +1. In the
//! idempotent basis e = (1 + k) / 2, e' = (1 - k) / 2 it is alpha e + beta e' with alpha = (x + w) + (y - z) i and
//! beta = (x - w) + (y + z) i, and Newton's method for a polynomial runs in alpha and in beta, each by itself. A polynomial
//! with n roots in C has n^2 here, one for each pair; root a e + b e' has the number `a n + b`, where a and b count from 0.
//!
//! [`Newton`] computes, for each of many points, which root it converges to and how fast ([`Gradient`]), in single precision,
//! by additions, multiplications, divisions and square roots alone, each rounded to the nearest: all machines give the same
//! bits, as do all numbers of threads. See `docs/algorithms/newton.md`.

mod iterate;
mod lanes;
mod palette;
mod points;
#[cfg(test)]
mod tests;
mod texels;

pub use palette::{darkened, root_color};
pub use points::{Grid, Points};
pub use texels::{Texels, texels};

use crate::base::{Error, Par, Progress, Result, Tracker, reserved};
use points::Cursor;

/// The polynomial whose roots are looked for.
#[derive(Debug, Clone, PartialEq)]
pub enum Polynomial {
    /// z^n - 1, n from 2 to [`Polynomial::MOST_ROOTS`]. Root a is exp(2 pi i a / n).
    Power(u32),
    /// The product of all (z - root), each root a real and an imaginary part within 1e4 of zero; from 1 to
    /// [`Polynomial::MOST_ROOTS`] of them. Root a is the a-th one. What is there twice is approached slowly, and of several
    /// equal ones the first is found.
    Roots(Vec<[f64; 2]>),
}

impl Polynomial {
    /// Roots in C, at most.
    pub const MOST_ROOTS: usize = 64;

    /// Roots in C, n; there are n^2 bicomplex ones.
    pub fn roots(&self) -> usize {
        match self {
            Self::Power(n) => *n as usize,
            Self::Roots(roots) => roots.len(),
        }
    }
}

/// How the speed of convergence becomes a number t. With d_k the length of step k, P iterations and f(d) = 1 / (1 + exp(d +
/// theta) - exp(theta)), which is 1 for a point that stays and 0 for one that goes far:
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum Gradient {
    /// Equation 7.3: t = P - (f(d_0) + ... + f(d_P)), P + 1 terms: from -1 (at a root) to P. P + 1 steps are taken.
    #[default]
    Thesis,
    /// What the shader of the authors computes: t = (P - (f(e_0) + ... + f(e_{P-1}))) / P, from 0 to 1, with
    /// e_k = d_k^2, no square root taken.
    Shader,
}

/// What a fractal is of.
#[derive(Debug, Clone, PartialEq)]
pub struct NewtonOptions {
    /// The polynomial; z^3 - 1 by default.
    pub polynomial: Polynomial,
    /// Iterations P, from 1 to 1,000; 32 by default.
    pub iterations: u32,
    /// Theta of [`Gradient`], from -10 to 20; 3.5 by default. The larger, the earlier a point counts as not converged.
    pub theta: f64,
    /// How t is computed.
    pub gradient: Gradient,
    /// What points are multiplied by, after `offset` and `w` have been added; 1 by default.
    pub scale: f64,
    /// What is added to x, y and z of each point; 0 by default.
    pub offset: [f64; 3],
    /// The fourth coordinate of each point: fixed, or a time; 0 by default.
    pub w: f64,
}

impl Default for NewtonOptions {
    fn default() -> Self {
        Self {
            polynomial: Polynomial::Power(3),
            iterations: 32,
            theta: 3.5,
            gradient: Gradient::default(),
            scale: 1.0,
            offset: [0.0; 3],
            w: 0.0,
        }
    }
}

/// What points converge to, and how fast.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Fractal {
    /// The number of the root, `a n + b`.
    pub roots: Vec<u16>,
    /// t of [`Gradient`].
    pub convergence: Vec<f32>,
}

/// Newton's method, ready for points.
#[derive(Debug, Clone, PartialEq)]
pub struct Newton {
    pub(crate) parameters: Parameters,
}

/// What the loops, here and on devices, need to know.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct Parameters {
    /// The roots, for [`Polynomial::Roots`]; empty for powers.
    pub roots: Vec<[f32; 2]>,
    /// Roots in C.
    pub degree: u32,
    /// Steps taken.
    pub steps: u32,
    /// Whether steps are measured squared.
    pub squared: bool,
    /// exp(theta).
    pub gain: f32,
    /// t is `factor` times the sum of the 1 - f(d_k), plus `shift`.
    pub factor: f32,
    pub shift: f32,
    pub scale: f32,
    /// Added before scaling: x, y, z, w.
    pub offset: [f32; 4],
    /// Squared, the distance from the null cone below which z^(1 - n) would overflow.
    pub nearest: f32,
}

/// Points that a thread computes before it looks for others.
const BLOCK: usize = 4096;
/// Coordinates, scaled, are not beyond this: their squares and quotients then are numbers.
const FARTHEST: f64 = 1e9;
/// |z^(1 - n)| at most, for the square of it to be a number.
const LARGEST: f64 = 1e18;

impl Newton {
    /// Newton's method with these options.
    ///
    /// # Errors
    /// [`Error::Argument`] for what is out of the range that [`NewtonOptions`] and [`Polynomial`] say.
    pub fn new(options: &NewtonOptions) -> Result<Self> {
        let out = |what: &'static str, why: String| Err(Error::Argument { what, why });
        let n = options.polynomial.roots();
        let (least, most) = match options.polynomial {
            Polynomial::Power(_) => (2, Polynomial::MOST_ROOTS),
            Polynomial::Roots(_) => (1, Polynomial::MOST_ROOTS),
        };
        if !(least..=most).contains(&n) {
            return out("polynomial", format!("{n} roots, where {least} to {most} are possible"));
        }
        let roots = match &options.polynomial {
            Polynomial::Power(_) => Vec::new(),
            Polynomial::Roots(roots) => {
                if let Some(i) = roots.iter().position(|r| !r.iter().all(|x| x.abs() <= 1e4)) {
                    return out("polynomial", format!("root {i}, {:?}, is beyond 1e4", roots[i]));
                }
                roots.iter().map(|root| root.map(|x| x as f32)).collect()
            }
        };
        let iterations = options.iterations;
        if !(1..=1000).contains(&iterations) {
            return out("iterations", format!("must be from 1 to 1,000, is {iterations}"));
        }
        let theta = options.theta;
        if !(-10.0..=20.0).contains(&theta) {
            return out("theta", format!("must be from -10 to 20, is {theta}"));
        }
        let numbers = [options.scale, options.w, options.offset[0], options.offset[1]];
        if !numbers.iter().chain(&options.offset[2..]).all(|x| x.abs() <= FARTHEST) {
            return out("scale, offset or w", format!("beyond {FARTHEST:e}, or not a number"));
        }
        let squared = options.gradient == Gradient::Shader;
        let [x, y, z] = options.offset;
        let parameters = Parameters {
            roots,
            degree: n as u32,
            steps: if squared { iterations } else { iterations + 1 },
            squared,
            gain: theta.exp() as f32,
            factor: if squared { 1.0 / iterations as f32 } else { 1.0 },
            shift: if squared { 0.0 } else { -1.0 },
            scale: options.scale as f32,
            offset: [x, y, z, options.w].map(|x| x as f32),
            nearest: LARGEST.powf(-2.0 / (n as f64 - 1.0).max(1.0)) as f32,
        };
        Ok(Self { parameters })
    }

    /// Roots in C, n; the fractal has n^2.
    pub fn roots(&self) -> usize {
        self.parameters.degree as usize
    }

    /// t as a part of its range: 0 for a point at its root, 1 for one that goes on for ever.
    pub fn share(&self, t: f32) -> f64 {
        let Parameters { factor, shift, steps, .. } = self.parameters;
        (f64::from((t - shift) / factor) / f64::from(steps)).clamp(0.0, 1.0)
    }

    /// The fractal at these points. Points at the null cone (alpha or beta is 0 to within 1e-15), where a step has no length,
    /// stay where they are, and count as far from convergence.
    ///
    /// # Errors
    /// [`Error::NonFinite`] names a point that is not finite, or farther than 1e9 from the origin after scaling;
    /// [`Error::Argument`] for 2^31 points or more; [`Error::OutOfMemory`]; [`Error::Cancelled`].
    pub fn evaluate(
        &self,
        points: Points<'_>,
        par: Par,
        progress: Progress<'_>,
    ) -> Result<Fractal> {
        let count = points.check(&self.parameters)?;
        let mut fractal = Fractal::with_len(count)?;
        let blocks = fractal.roots.chunks_mut(BLOCK).zip(fractal.convergence.chunks_mut(BLOCK));
        let number = count.div_ceil(BLOCK) as f64;
        let tracker = Tracker::new(progress, number);
        par.for_each(blocks, |i, (roots, convergence)| {
            if tracker.state().is_break() {
                return;
            }
            iterate::evaluate(&self.parameters, Cursor::new(points, i * BLOCK), roots, convergence);
            // The blocks that are left look at the tracker's state.
            let _ = tracker.add(1.0);
        });
        tracker.finish().map(|()| fractal)
    }
}

impl Fractal {
    /// That of `len` points, none of them computed.
    pub(crate) fn with_len(len: usize) -> Result<Self> {
        let mut fractal = Self { roots: reserved(len)?, convergence: reserved(len)? };
        fractal.roots.resize(len, 0);
        fractal.convergence.resize(len, 0.0);
        Ok(fractal)
    }
}
