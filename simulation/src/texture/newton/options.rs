//! The options of a fractal, and the parameters that the loops derive from them.

use super::convergence::Gradient;
use super::polynomial::Polynomial;
use catamaran::base::{Error, Result, options, within};

options! {
    /// Options of a fractal.
    #[derive(Debug, Clone, PartialEq)]
    pub struct NewtonOptions {
        /// The polynomial.
        polynomial: Polynomial = Polynomial::Power(3);
        /// The number P of iterations.
        iterations: u32 = 32, range "from 1 to 1,000";
        /// Theta of [`Gradient`]. The larger theta, the shorter the steps that count as not
        /// converged.
        theta: f64 = 3.5, check(from -10.0 to 20.0);
        /// The formula of t.
        gradient: Gradient = Gradient::Thesis;
        /// Factor by which points are multiplied, after `offset` and `w` have been added.
        scale: f64 = 1.0, check(from -1e9 to 1e9);
        /// Vector that is added to x, y and z of each point.
        offset: [f64; 3] = [0.0; 3], range "from -1e9 to 1e9";
        /// The fourth coordinate of each point, a constant or a time.
        w: f64 = 0.0, check(from -1e9 to 1e9);
    }
}

/// The parameters of the loops, on the CPU and on devices.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct Parameters {
    /// The roots, for [`Polynomial::Roots`]; empty for powers.
    pub roots: Vec<[f32; 2]>,
    /// Number of roots in C.
    pub degree: u32,
    /// Number of steps.
    pub steps: u32,
    /// Whether the squares of step lengths are measured.
    pub squared: bool,
    /// exp(theta).
    pub gain: f32,
    /// t is `factor` times the sum of the 1 - f(d_k), plus `shift`.
    pub factor: f32,
    pub shift: f32,
    pub scale: f32,
    /// Added before scaling: x, y, z, w.
    pub offset: [f32; 4],
    /// The square of the distance from the null cone below which z^(1 - n) would overflow.
    pub nearest: f32,
    /// A point has converged when |step|^2 is below this: the next step would be rounding error.
    pub arrived: f32,
}

/// Bound of scaled coordinates, within which their squares and quotients are finite. The ranges of
/// `scale`, `offset` and `w` say it as a number.
pub(super) const FARTHEST: f64 = 1e9;
/// Bound of |z^(1 - n)|, within which its square is finite.
const LARGEST: f64 = 1e18;
/// [`Parameters::arrived`], unless all roots are small.
const ARRIVED: f32 = 1e-10;
/// The largest root below which [`ARRIVED`] shrinks with it: there the step is a thousandth of the
/// root.
const SMALL: f64 = 1e-2;
/// The least size of the largest root: squares of shorter steps count as 0.
const LEAST: f64 = 1e-12;

impl NewtonOptions {
    /// Returns the parameters of the loops, or an error that names an option out of its range.
    pub(super) fn parameters(&self) -> Result<Parameters> {
        let out = |what: &'static str, why: String| Err(Error::Argument { what, why });
        let n = self.polynomial.roots();
        let (least, most) = match self.polynomial {
            Polynomial::Power(_) => (2, Polynomial::MOST_ROOTS),
            Polynomial::Roots(_) => (1, Polynomial::MOST_ROOTS),
        };
        if !(least..=most).contains(&n) {
            return out("polynomial", format!("must have {least} to {most} roots, has {n}"));
        }
        let roots = match &self.polynomial {
            Polynomial::Power(_) => Vec::new(),
            Polynomial::Roots(roots) => {
                if let Some(i) = roots.iter().position(|r| !r.iter().all(|x| x.abs() <= 1e4)) {
                    let why = format!("root {i} must be within +-1e4, is {:?}", roots[i]);
                    return out("polynomial", why);
                }
                roots.iter().map(|root| root.map(|x| x as f32)).collect()
            }
        };
        let size = self.polynomial.largest_root();
        if size > 0.0 && size < LEAST {
            let why = format!("the largest root must be 0 or at least 1e-12 from 0, is {size:.1e}");
            return out("polynomial", why);
        }
        let iterations = self.iterations;
        if !(1..=1000).contains(&iterations) {
            return out("iterations", format!("must be from 1 to 1,000, is {iterations}"));
        }
        self.check_ranges()?;
        self.offset.iter().try_for_each(|x| within("offset", *x, -FARTHEST, FARTHEST))?;
        let squared = self.gradient == Gradient::Shader;
        let [x, y, z] = self.offset;
        Ok(Parameters {
            roots,
            degree: n as u32,
            steps: if squared { iterations } else { iterations + 1 },
            squared,
            gain: self.theta.exp() as f32,
            factor: if squared { 1.0 / iterations as f32 } else { 1.0 },
            shift: if squared { 0.0 } else { -1.0 },
            scale: self.scale as f32,
            offset: [x, y, z, self.w].map(|x| x as f32),
            nearest: LARGEST.powf(-2.0 / (n as f64 - 1.0).max(1.0)) as f32,
            arrived: ARRIVED * arrival(size).powi(2),
        })
    }
}

/// Returns the length of the last step of a point, as a part of that of roots that are not small.
fn arrival(size: f64) -> f32 {
    if size > 0.0 { (size / SMALL).min(1.0) as f32 } else { 1.0 }
}
