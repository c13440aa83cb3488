//! Newton's fractals in four dimensions, by bicomplex numbers (thesis, chapter 7).
//!
//! A point (x, y, z, w) is the bicomplex number x + y i + z j + w k with i^2 = j^2 = -1 and k = i
//! j, k^2 = +1. In the idempotent basis e = (1 + k) / 2, e' = (1 - k) / 2 it is alpha e + beta e'
//! with alpha = (x + w) + (y - z) i and beta = (x - w) + (y + z) i, and Newton's method for a
//! polynomial runs independently in alpha and in beta. A polynomial with n roots in C has n^2
//! bicomplex roots, one for each pair; root a e + b e' has the number `a n + b`, where a and b
//! count from 0.
//!
//! [`Newton`] computes, for each of many points, which root it converges to and how fast
//! ([`Gradient`]), in single precision, by additions, multiplications, divisions and square roots
//! alone, each rounded to the nearest: all machines give the same bits, as do all numbers of
//! threads. See `docs/algorithms/newton.md`.

mod basin;
mod convergence;
mod inlay;
mod iterate;
mod lanes;
mod material;
mod options;
mod palette;
mod points;
mod polynomial;
mod roots;
#[cfg(test)]
mod tests;
mod texels;
mod volume;

pub use convergence::Gradient;
pub use inlay::Inlay;
pub use options::NewtonOptions;
pub use palette::{UNREACHED_COLOR, darkened, root_color};
pub use points::{Grid, Points};
pub use polynomial::Polynomial;
pub use texels::{Texels, texels};
pub use volume::{VolumeFormat, Voxels, write_volume};

use catamaran::base::{Par, Progress, Result, Tracker, check_request, reserved};
use options::Parameters;
use points::Cursor;

/// Compiles the code of the guide.
#[cfg(doctest)]
#[doc = include_str!("../../../../docs/guide/newton.md")]
struct Guide;

/// The values of a fractal at points: the root that each point converges to, and how fast.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Fractal {
    /// The number of the root, `a n + b`.
    pub roots: Vec<u16>,
    /// t of [`Gradient`].
    pub convergence: Vec<f32>,
    /// Indices of the points that reach no root within the iterations, ascending; their root is
    /// the one nearest to where they are then.
    pub unreached: Vec<u32>,
}

/// Newton's method for a bicomplex polynomial (thesis, chapter 7), with its parameters prepared.
///
/// ```
/// use catamaran::{Par, base::Progress};
/// use catamaran_simulation::texture::newton::{Grid, Newton, NewtonOptions, Points, Polynomial};
///
/// let newton = Newton::new(&NewtonOptions::new().polynomial(Polynomial::Power(3)))?;
/// let plane = Grid::plane(32, 32, [0.0, 0.0], 2.0);
/// let fractal = newton.evaluate(Points::Grid(plane), Par::all(), Progress::none())?;
/// assert_eq!(fractal.roots.len(), 32 * 32);
/// assert!(fractal.roots.iter().all(|&root| root < 9));
/// assert!(fractal.unreached.is_empty());
/// # Ok::<(), catamaran::Error>(())
/// ```
#[derive(Debug, Clone, PartialEq)]
pub struct Newton {
    pub(crate) parameters: Parameters,
}

/// Number of points that a thread computes at a time.
const BLOCK: usize = 4096;

impl Newton {
    /// Creates Newton's method with these options.
    ///
    /// # Errors
    /// [`Error::Argument`](catamaran::Error::Argument) for an option out of the range given in
    /// [`NewtonOptions`] and [`Polynomial`].
    pub fn new(options: &NewtonOptions) -> Result<Self> {
        Ok(Self { parameters: options.parameters()? })
    }

    /// Returns the number n of roots in C; the fractal has n^2 roots.
    pub fn roots(&self) -> usize {
        self.parameters.degree as usize
    }

    /// Returns t as a fraction of its range: 0 for a point at its root, 1 for a point that never
    /// converges.
    pub fn share(&self, t: f32) -> f64 {
        let Parameters { factor, shift, steps, .. } = self.parameters;
        (f64::from((t - shift) / factor) / f64::from(steps)).clamp(0.0, 1.0)
    }

    /// Computes the fractal at these points. Points on the null cone (alpha or beta is 0 to within
    /// 1e-15), where a step is undefined, do not move, and count as far from convergence.
    ///
    /// # Errors
    /// [`Error::NonFinite`](catamaran::Error::NonFinite) names a point that is not finite, or
    /// farther than 1e9 from the origin after scaling;
    /// [`Error::Argument`](catamaran::Error::Argument) for 2^31 points or more;
    /// [`Error::OutOfMemory`](catamaran::Error::OutOfMemory);
    /// [`Error::Cancelled`](catamaran::Error::Cancelled).
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
            // The remaining blocks check the state of the tracker.
            let _ = tracker.add(1.0);
        });
        tracker.finish()?;
        fractal.marked()
    }
}

impl Fractal {
    /// Allocates a fractal of `len` points, which are not yet computed.
    pub(crate) fn with_len(len: usize) -> Result<Self> {
        let bytes = len as f64 * (size_of::<u16>() + size_of::<f32>()) as f64;
        check_request("points", format_args!("{len} points"), bytes)?;
        let (roots, convergence) = (reserved(len)?, reserved(len)?);
        let mut fractal = Self { roots, convergence, unreached: vec![] };
        fractal.roots.resize(len, 0);
        fractal.convergence.resize(len, 0.0);
        Ok(fractal)
    }

    /// Lists the points that reach no root, and removes their marks.
    pub(crate) fn marked(mut self) -> Result<Self> {
        let is_marked = |root: &u16| root & iterate::UNREACHED != 0;
        self.unreached = reserved(self.roots.iter().filter(|root| is_marked(root)).count())?;
        // There are fewer than 2^31 points.
        let numbers = (0_u32..).zip(&mut self.roots).filter(|(_, root)| is_marked(root));
        self.unreached.extend(numbers.map(|(i, root)| {
            *root &= !iterate::UNREACHED;
            i
        }));
        Ok(self)
    }
}
