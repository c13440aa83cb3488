//! Tails of Student's t and of the F distribution.
//!
//! The incomplete beta function is a positive factor times the integral of a positive function,
//! which the trapezoidal rule computes after a double-exponential substitution (Takahasi and Mori
//! 1974). The factor is evaluated as by Loader (2000): no term of the exponent is larger than the
//! exponent. Nothing cancels, so that small probabilities have a small relative error for any
//! degrees of freedom; continued fractions with logarithms of gamma functions lose the digits that
//! 10^7 degrees of freedom take.

use std::f64::consts::{FRAC_2_PI, TAU};

/// Returns the probability that a value of Student's t distribution is as far from 0 as `t`, or
/// farther, at either side: the p value of a t statistic with `freedom` degrees of freedom, at
/// least 1.
///
/// The relative error is below `2^-50 (1 + |ln p|)`, that of a rounded `t` included. NaN for a NaN
/// and for less than one degree of freedom.
///
/// ```
/// use catamaran::solve::t_probability;
///
/// assert!((t_probability(2.262_157_162_798_206, 9.0) - 0.05).abs() < 1e-15);
/// assert_eq!(t_probability(f64::INFINITY, 9.0), 0.0);
/// ```
pub fn t_probability(t: f64, freedom: f64) -> f64 {
    if freedom == 1.0 {
        // The square of t may be out of range where the probability is not.
        return FRAC_2_PI * 1_f64.atan2(t.abs());
    }
    f_probability(t * t, 1.0, freedom)
}

/// Returns the `t >= 0` that a value of Student's t distribution, with `freedom` degrees of freedom
/// of at least 1, exceeds in size with this `probability`, from 0 to 1: the half-width of a
/// confidence interval in standard errors, for a probability of 1 minus the confidence.
///
/// NaN for a probability out of range and for less than one degree of freedom.
///
/// ```
/// use catamaran::solve::t_quantile;
///
/// assert!((t_quantile(0.05, 1.0) - 12.706_204_736_174_7).abs() < 1e-13);
/// assert_eq!((t_quantile(1.0, 5.0), t_quantile(0.0, 5.0)), (0.0, f64::INFINITY));
/// ```
pub fn t_quantile(probability: f64, freedom: f64) -> f64 {
    /// Steps of Newton's method and of bisection: a few in all but the farthest tails.
    const MOST: usize = 200;
    if !(0.0..=1.0).contains(&probability) || freedom.is_nan() || freedom < 1.0 {
        return f64::NAN;
    }
    if probability == 0.0 || probability == 1.0 {
        return if probability == 0.0 { f64::INFINITY } else { 0.0 };
    }
    let (mut low, mut high) = (0.0_f64, f64::INFINITY);
    let mut t = 1.0_f64;
    for _ in 0..MOST {
        let found = t_probability(t, freedom);
        if found == probability {
            return t;
        }
        if found > probability {
            low = t;
        } else {
            high = t;
        }
        // Newton's method for the logarithms, where the tail is nearly a line.
        let slope = 2.0 * t * t_density(t, freedom) / found;
        let mut next = t * ((found / probability).ln() / slope).exp();
        if (next - t).abs() <= 2.0 * f64::EPSILON * t {
            return next;
        }
        // False for NaN, from probabilities that are too small.
        if !(low < next && next < high) {
            next = match (low > 0.0, high < f64::INFINITY) {
                (true, true) => low.sqrt() * high.sqrt(),
                (_, true) => 0.5 * high,
                (_, false) => 2.0 * low,
            };
        }
        if next == low || next == high {
            return next;
        }
        t = next;
    }
    t
}

/// Returns the probability that a value of the F distribution is at least `f`: the p value of an F
/// statistic with `numerator` and `denominator` degrees of freedom, each at least 1.
///
/// The relative error is below `2^-50 (1 + |ln p|)`, that of a rounded `f` included. NaN for a NaN
/// and for less than one degree of freedom.
///
/// ```
/// use catamaran::solve::f_probability;
///
/// assert!((f_probability(330.3, 6.0, 9.0) / 4.983_041_240_487_61e-10 - 1.0).abs() < 1e-13);
/// assert_eq!(f_probability(1.0, 5.0, 5.0), 0.5);
/// ```
pub fn f_probability(f: f64, numerator: f64, denominator: f64) -> f64 {
    if f.is_nan() || !(numerator >= 1.0 && denominator >= 1.0) {
        return f64::NAN;
    }
    if f <= 0.0 {
        return 1.0;
    }
    if f == 1.0 && numerator == denominator {
        return 0.5;
    }
    // The tail behind the mode is the one without cancellation.
    match f >= 1.0 {
        true => upper_tail(f, numerator, denominator),
        false => 1.0 - upper_tail(1.0 / f, denominator, numerator),
    }
}

/// Returns [`f_probability`] for `f >= 1`.
///
/// With `a = denominator / 2`, `b = numerator / 2` and `x = a / (a + b f)`, it is the incomplete
/// beta function `I_x(a, b)`: the integral over `w > 0` of
/// `exp(-a w) (1 + r (1 - exp(-w)))^(b - 1)` with `r = x / (1 - x)`, times
/// `x^a (1 - x)^(b - 1) / B(a, b)`.
fn upper_tail(f: f64, numerator: f64, denominator: f64) -> f64 {
    /// Distance of two nodes.
    const STEP: f64 = 1.0 / 16.0;
    /// Nodes at either side of 0 beyond which nothing is left to add.
    const NODES: [i32; 2] = [-80, 96];
    let (a, b) = (0.5 * denominator, 0.5 * numerator);
    let (inverse, sum) = (1.0 / f, numerator + denominator);
    // (a + b f) / f, times 2.
    let scale = denominator * inverse + numerator;
    // x over its mean, 1 - x over its mean, and how far both are from 1.
    let (of_x, of_rest) = (sum * inverse / scale, sum / scale);
    let (by_x, by_rest) =
        (numerator * (inverse - 1.0) / scale, denominator * (1.0 - inverse) / scale);
    let exponent = a * log_deviation(of_x, by_x)
        + b * log_deviation(of_rest, by_rest)
        + (stirling_error(a + b) - stirling_error(a) - stirling_error(b));
    let factor = exponent.exp() * (a * b / (0.5 * sum) / TAU).sqrt();
    let (r, rest) = (denominator * inverse / numerator, numerator / scale);
    // What the integrand falls off by: its slope at 0, and its curvature.
    let (slope, curvature) = match b > 1.0 {
        true => (a - (b - 1.0) * r, (b - 1.0) * r * (1.0 + r)),
        false => (a, 0.0),
    };
    let width = 1.0 / slope.max(curvature.sqrt());
    let mut integral = 0.0;
    for node in NODES[0]..=NODES[1] {
        let u = f64::from(node) * STEP;
        let fall = (-u).exp();
        let w = width * (u - fall).exp();
        let value = ((b - 1.0) * (-r * (-w).exp_m1()).ln_1p() - a * w).exp();
        integral += value * w * (1.0 + fall);
    }
    (factor / rest * integral * STEP).min(1.0)
}

/// Returns the density of Student's t distribution at t.
fn t_density(t: f64, freedom: f64) -> f64 {
    let a = 0.5 * freedom;
    // The logarithm of Gamma(a + 1/2) / Gamma(a) / sqrt(a).
    let ratio =
        a * log_deviation(1.0 + 0.5 / a, 0.5 / a) + stirling_error(a + 0.5) - stirling_error(a);
    (ratio - (a + 0.5) * (t * t / freedom).ln_1p()).exp() / TAU.sqrt()
}

/// Returns `ln(ratio) - difference`, where `ratio` is `1 + difference`.
fn log_deviation(ratio: f64, difference: f64) -> f64 {
    if difference.abs() > 0.5 {
        return ratio.ln() - difference;
    }
    let r = difference / (2.0 + difference);
    r * (2.0 * inverse_tanh_rest(r * r) - difference)
}

/// Returns the logarithm of `Gamma(z)` over Stirling's `(2 pi / z)^(1/2) (z / e)^z`, `z >= 1/2`.
fn stirling_error(z: f64) -> f64 {
    /// From here on the series below is exact.
    const LEAST: f64 = 16.0;
    const SERIES: [f64; 7] = [
        1.0 / 12.0,
        -1.0 / 360.0,
        1.0 / 1260.0,
        -1.0 / 1680.0,
        1.0 / 1188.0,
        -691.0 / 360_360.0,
        1.0 / 156.0,
    ];
    if z < LEAST {
        let r = 1.0 / (2.0 * z + 1.0);
        return stirling_error(z + 1.0) + inverse_tanh_rest(r * r);
    }
    let square = 1.0 / (z * z);
    SERIES.iter().rev().fold(0.0, |sum, term| sum * square + term) / z
}

/// Returns `artanh(r) / r - 1` for a square of r of at most 1/4.
fn inverse_tanh_rest(square: f64) -> f64 {
    /// Terms after which less than 2^-53 of the first is left.
    const TERMS: u32 = 25;
    (1..=TERMS).rev().fold(0.0, |sum, k| (sum + 1.0 / f64::from(2 * k + 1)) * square)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Checks a probability against a value of 20 digits, from mpmath 1.3 with 60 digits.
    #[track_caller]
    fn near(found: f64, right: f64) {
        let bound = f64::EPSILON * 4.0 * (1.0 + right.ln().abs());
        assert!((found / right - 1.0).abs() <= bound, "{found:e} and not {right:e}");
    }

    #[test]
    fn p_values_of_t_have_their_digits_in_the_farthest_tails() {
        for (t, freedom, right) in [
            (1e-9, 4.0, 0.999_999_999_25),
            (1e-3, 2.0, 0.999_292_893_395_590_1),
            (0.3, 1.0, 0.814_452_841_844_515_3),
            (0.3, 7.0, 0.772_890_050_402_134_2),
            (1.0, 1.0, 0.5),
            (1.5, 2.0, 0.272_393_124_891_001_1),
            (2.0, 10.0, 0.073_388_034_770_740_37),
            (2.5, 3.0, 0.087_706_647_008_065_55),
            (12.5, 29.0, 3.339_479_901_457_512e-13),
            (40.0, 1000.0, 1.047_885_215_517_336e-209),
            (1e5, 6.0, 6.749_999_989_368_75e-29),
            (1e60, 3.0, 2.205_315_581_687_168_6e-180),
            (3e200, 1.0, 2.122_065_907_891_938e-201),
            (0.7, 1e7, 0.483_927_320_730_188_35),
            (1.96, 1e7, 0.049_995_818_025_314_19),
            (30.0, 1e7, 1.001_461_369_081_78e-197),
            (5.0, 1e9, 5.733_032_403_951_628e-7),
        ] {
            near(t_probability(t, freedom), right);
            assert_eq!(t_probability(-t, freedom), t_probability(t, freedom));
        }
        assert_eq!((t_probability(0.0, 3.0), t_probability(f64::INFINITY, 1.0)), (1.0, 0.0));
        assert!(t_probability(f64::NAN, 3.0).is_nan() && t_probability(1.0, 0.0).is_nan());
    }

    #[test]
    fn p_values_of_f_have_their_digits_in_the_farthest_tails() {
        for (f, numerator, denominator, right) in [
            (1e-4, 3.0, 8.0, 0.999_998_493_176_185_3),
            (0.5, 3.0, 7.0, 0.694_036_387_568_813_7),
            (0.9, 300.0, 1e4, 0.889_611_277_650_320_7),
            (2.0, 2.0, 9.0, 0.191_137_634_576_891_3),
            (4.26, 2.0, 9.0, 0.049_910_030_381_548_974),
            (6.9, 6.0, 2000.0, 2.871_825_200_158_140_4e-7),
            (330.3, 6.0, 9.0, 4.983_041_240_487_61e-10),
            (1e5, 20.0, 12.0, 2.334_940_660_503_933e-28),
        ] {
            near(f_probability(f, numerator, denominator), right);
        }
        assert_eq!(f_probability(90.0, 50.0, 1000.0), 0.0);
        assert_eq!(f_probability(f64::INFINITY, 5.0, 5.0), 0.0);
        assert_eq!((f_probability(1.0, 5.0, 5.0), f_probability(0.0, 5.0, 5.0)), (0.5, 1.0));
        assert!(
            f_probability(1.0, 0.0, 5.0).is_nan() && f_probability(f64::NAN, 1.0, 1.0).is_nan()
        );
    }

    #[test]
    fn quantiles_of_t_have_14_digits() {
        for (probability, freedom, right) in [
            (0.05, 1.0, 12.706_204_736_174_705),
            (0.05, 9.0, 2.262_157_162_798_205_3),
            (0.01, 28.0, 2.763_262_455_461_444_7),
            (1e-12, 5.0, 452.539_224_333_400_74),
            (0.05, 1000.0, 1.962_339_080_826_408_5),
            (0.5, 3.0, 0.764_892_328_404_345_3),
            (1e-100, 2.0, 1e50),
        ] {
            let found = t_quantile(probability, freedom);
            let bound = 1e-14 * (1.0 + probability.ln().abs());
            assert!((found / right - 1.0).abs() < bound, "{found} and not {right}");
        }
        for freedom in [1.0, 2.0, 30.0, 1e6] {
            for probability in [0.99, 0.5, 1e-3, 1e-9] {
                near(t_probability(t_quantile(probability, freedom), freedom), probability);
            }
        }
        assert!(t_quantile(1.5, 3.0).is_nan() && t_quantile(0.5, 0.0).is_nan());
    }
}
