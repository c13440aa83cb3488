//! The roots of a polynomial, from its coefficients: the eigenvalues of the companion matrix, or,
//! where these are not good enough, all roots at once by the method of Aberth and Ehrlich.

use std::f64::consts::TAU;

use catamaran::base::Sets;
use faer::{Mat, c64};

/// Why there are no roots.
const FAR_APART: &str = "the coefficients are too far apart to find the roots";
const UNCERTAIN: &str = "roundings of the coefficients, in double precision, move the roots by \
                         more than a thousandth of their sizes: give the roots instead";

const ZERO: c64 = c64::new(0.0, 0.0);

/// Returns the roots, in no order, of the polynomial `c[0] z^n + ... + c[n]`, n >= 1, whose first
/// coefficient is not 0, or else why they are not found.
pub(super) fn roots(coefficients: &[c64]) -> Result<Vec<c64>, &'static str> {
    let zeros = coefficients.iter().rev().take_while(|c| **c == ZERO).count();
    let rest = &coefficients[..coefficients.len() - zeros];
    let mut roots = vec![ZERO; zeros];
    if rest.len() > 1 {
        let Scaled { coefficients, exponent } = Scaled::new(rest).ok_or(FAR_APART)?;
        let found = roots_of_scaled(&coefficients).ok_or(UNCERTAIN)?;
        roots.extend(found.into_iter().map(|root| times_power_of_two(root, exponent)));
    }
    if roots.iter().all(|root| root.is_finite()) { Ok(roots) } else { Err(FAR_APART) }
}

/// A polynomial of t = z / 2^exponent, divided by a power of two: its first and its last
/// coefficient have about the same size, and the largest one is near 1.
struct Scaled {
    coefficients: Vec<c64>,
    exponent: i32,
}

impl Scaled {
    /// Scales a polynomial whose first and last coefficient are not 0; `None` if these are too
    /// small beside the others.
    fn new(given: &[c64]) -> Option<Self> {
        const LEAST: f64 = 1e-300;
        let degree = given.len() - 1;
        let size = |c: &c64| c.re.abs().max(c.im.abs());
        let [first, last] = [0, degree].map(|k| size(&given[k]).log2());
        let exponent = ((last - first) / degree as f64).round() as i32;
        let raised = |k: usize| exponent * (degree - k) as i32;
        let sizes = given.iter().enumerate().filter(|(_, c)| **c != ZERO);
        let sizes = sizes.map(|(k, c)| size(c).log2() + f64::from(raised(k)));
        let largest = sizes.fold(f64::NEG_INFINITY, f64::max).floor() as i32;
        let scaled = |(k, c): (usize, &c64)| times_power_of_two(*c, raised(k) - largest);
        let coefficients: Vec<c64> = given.iter().enumerate().map(scaled).collect();
        let is_large = [0, degree].iter().all(|&k| size(&coefficients[k]) >= LEAST);
        is_large.then_some(Self { coefficients, exponent })
    }
}

/// Returns `z 2^exponent`.
fn times_power_of_two(mut z: c64, mut exponent: i32) -> c64 {
    /// The power and its inverse are normal numbers.
    const MOST: i32 = 1000;
    while exponent != 0 {
        let step = exponent.clamp(-MOST, MOST);
        z *= 2.0_f64.powi(step);
        exponent -= step;
    }
    z
}

/// Returns the roots of the method whose roots make the given coefficients best; `None` if no
/// method finds good ones.
fn roots_of_scaled(coefficients: &[c64]) -> Option<Vec<c64>> {
    /// The [`deviation`] of roots that no other method can improve much, and that of the worst
    /// roots that are accepted: an error of a pixel in a picture of a thousand.
    const EXACT: f64 = 1e-10;
    const WORST: f64 = 1e-3;
    let mut best = (f64::INFINITY, Vec::new());
    for method in [from_eigenvalues as fn(&[c64]) -> _, from_circles] {
        let Some(found) = method(coefficients) else { continue };
        let off = deviation(coefficients, &found);
        if off < best.0 {
            best = (off, found);
        }
        if best.0 <= EXACT {
            break;
        }
    }
    (best.0 <= WORST).then_some(best.1)
}

/// Returns the eigenvalues of the companion matrix, improved; `None` if they can't be computed.
fn from_eigenvalues(coefficients: &[c64]) -> Option<Vec<c64>> {
    let degree = coefficients.len() - 1;
    let companion = Mat::from_fn(degree, degree, |i, j| match (i, j) {
        (0, j) => -coefficients[j + 1] / coefficients[0],
        (i, j) if i == j + 1 => c64::new(1.0, 0.0),
        _ => ZERO,
    });
    let found = companion.is_all_finite().then(|| companion.eigenvalues().ok()).flatten()?;
    let simple = || found.iter().map(|root| improved(coefficients, *root)).collect();
    Some(merged(coefficients, &found).unwrap_or_else(simple))
}

/// Returns the roots by [`simultaneous`], with multiple roots.
fn from_circles(coefficients: &[c64]) -> Option<Vec<c64>> {
    let found = simultaneous(coefficients);
    Some(merged(coefficients, &found).unwrap_or(found))
}

/// Returns approximations of all roots by the iteration of Aberth (1973) and Ehrlich (1967):
/// Newton's steps, of which each approximation pushes the others away.
fn simultaneous(coefficients: &[c64]) -> Vec<c64> {
    const SWEEPS: usize = 200;
    let degree = coefficients.len() - 1;
    let rounding = degree as f64 * f64::EPSILON;
    let mut roots = on_circles(coefficients);
    // For each root its least residual, and where it was then.
    let mut best: Vec<(f64, c64)> = roots.iter().map(|root| (f64::INFINITY, *root)).collect();
    let mut moving: Vec<usize> = (0..degree).collect();
    for _ in 0..SWEEPS {
        moving.retain(|&i| {
            let at = roots[i];
            let (step, residual) = newton_step(coefficients, at);
            if residual < best[i].0 {
                best[i] = (residual, at);
            } else if best[i].0 <= rounding {
                roots[i] = best[i].1;
                return false;
            }
            let others = roots.iter().filter(|other| **other != at);
            let push: c64 = others.map(|other| (at - *other).finv()).sum();
            let next = at - step.fdiv(c64::new(1.0, 0.0) - step * push);
            if next.is_finite() {
                roots[i] = next;
            }
            true
        });
        if moving.is_empty() {
            break;
        }
    }
    roots
}

/// Returns first approximations of the roots: on circles around 0, one for each edge of Newton's
/// polygon, which tells how many roots have about which size (Bini 1996).
fn on_circles(coefficients: &[c64]) -> Vec<c64> {
    /// A direction in which no polynomial is symmetric, in radians.
    const TILT: f64 = 0.7;
    let degree = coefficients.len() - 1;
    let slope = |a: (usize, f64), b: (usize, f64)| (b.1 - a.1) / (b.0 - a.0) as f64;
    let mut polygon: Vec<(usize, f64)> = Vec::new();
    for (power, c) in coefficients.iter().rev().enumerate().filter(|(_, c)| **c != ZERO) {
        let corner = (power, c.norm().log2());
        while let [.., before, last] = polygon[..]
            && slope(before, last) <= slope(before, corner)
        {
            polygon.pop();
        }
        polygon.push(corner);
    }
    let mut roots = Vec::with_capacity(degree);
    for edge in polygon.windows(2) {
        let (first, count) = (edge[0].0, edge[1].0 - edge[0].0);
        let radius = (-slope(edge[0], edge[1])).exp2();
        for i in 0..count {
            let turn = i as f64 / count as f64 + first as f64 / degree as f64;
            roots.push(c64::from_polar(radius, TAU * turn + TILT));
        }
    }
    roots
}

/// Returns the value of the polynomial at z over that of its derivative, and the size of the value
/// relative to the sum of the sizes of its terms. Outside of the unit circle both are those of the
/// polynomial in 1 / z, which does not overflow.
fn newton_step(coefficients: &[c64], z: c64) -> (c64, f64) {
    let degree = coefficients.len() - 1;
    let is_inside = z.norm() <= 1.0;
    let u = if is_inside { z } else { z.finv() };
    let (mut value, mut slope, mut size) = (ZERO, ZERO, 0.0);
    for k in 0..=degree {
        let c = coefficients[if is_inside { k } else { degree - k }];
        slope = slope * u + value;
        value = value * u + c;
        size = size * u.norm() + c.norm();
    }
    let step = match is_inside {
        true => value.fdiv(slope),
        false => value.fdiv(u * (value * degree as f64 - u * slope)),
    };
    (step, value.norm() / size)
}

/// Returns the roots with multiple roots in place of the approximations around them, which would
/// have a basin each; `None` if there are no multiple roots. Approximations are one root if the
/// polynomial of that root has the given coefficients.
fn merged(coefficients: &[c64], found: &[c64]) -> Option<Vec<c64>> {
    /// The largest and the smallest distance between neighbours around a multiple root, as parts of
    /// their size.
    const FARTHEST: f64 = 0.3;
    const NEAREST: f64 = 1e-9;
    /// Rounding errors of a coefficient, relative to the sum of the sizes of its terms.
    const ROUNDING: f64 = 1e-13;
    let mut distance = FARTHEST;
    while distance > NEAREST {
        let groups = within(found, distance);
        let multiple = groups.iter().enumerate().any(|(i, group)| i != *group as usize);
        let roots: Vec<c64> =
            groups.iter().map(|g| center(coefficients, found, &groups, *g)).collect();
        if multiple && deviation(coefficients, &roots) <= ROUNDING {
            return Some(roots);
        }
        distance *= 0.5;
    }
    None
}

/// Returns a number for each approximation, equal for those that a path of others connects, in
/// steps of at most `distance`, as a part of the larger end of the step.
fn within(found: &[c64], distance: f64) -> Vec<u32> {
    let count = found.len();
    let mut sets = Sets::new(count);
    for i in 0..count {
        for j in 0..i {
            let size = found[i].norm().max(found[j].norm());
            if (found[i] - found[j]).norm() <= distance * size {
                sets.join(i as u32, j as u32);
            }
        }
    }
    (0..count as u32).map(|i| sets.find(i)).collect()
}

/// Returns the m-fold root that a group of m approximations surrounds: the simple root of
/// derivative m - 1 that is near their mean.
fn center(coefficients: &[c64], found: &[c64], groups: &[u32], group: u32) -> c64 {
    let members = found.iter().zip(groups).filter(|(_, other)| **other == group);
    let (mut sum, mut count, mut derivative) = (ZERO, 0.0, coefficients.to_vec());
    for (root, _) in members {
        if count > 0.0 {
            derivative.pop();
            let degree = derivative.len();
            for (i, c) in derivative.iter_mut().enumerate() {
                *c *= (degree - i) as f64;
            }
        }
        sum += *root;
        count += 1.0;
    }
    improved(&derivative, sum * (1.0 / count))
}

/// Returns the largest difference between a coefficient and that of the polynomial with these roots
/// and the same first coefficient, relative to the sum of the sizes of the terms of the latter. A
/// root that is there twice in place of another one makes a difference, too.
fn deviation(coefficients: &[c64], roots: &[c64]) -> f64 {
    let mut roots = roots.to_vec();
    // Products of the largest ones are the first to be needed, and do not vanish.
    roots.sort_by(|a, b| b.norm().total_cmp(&a.norm()));
    let mut product = vec![coefficients[0]];
    let mut sizes = vec![coefficients[0].norm()];
    for root in roots {
        product.push(ZERO);
        sizes.push(0.0);
        for i in (1..product.len()).rev() {
            let (before, size) = (product[i - 1], sizes[i - 1]);
            product[i] -= root * before;
            sizes[i] += root.norm() * size;
        }
    }
    let differences =
        product.iter().zip(coefficients).map(|(found, given)| (*found - *given).norm());
    let parts = differences.zip(sizes).map(|(off, size)| if off == 0.0 { 0.0 } else { off / size });
    // What is not a number has overflown.
    parts.fold(0.0, |worst, off| if off.is_nan() { f64::INFINITY } else { off.max(worst) })
}

/// Returns the root after steps of Newton's method that reduce the value of the polynomial.
fn improved(coefficients: &[c64], mut root: c64) -> c64 {
    const STEPS: usize = 100;
    for _ in 0..STEPS {
        let (value, slope) = evaluate(coefficients, root);
        let next = root - value / slope;
        // The step is not finite where the slope is zero.
        let better = evaluate(coefficients, next).0.norm() < value.norm();
        if !better {
            break;
        }
        root = next;
    }
    root
}

/// Returns the polynomial and its derivative at z, by Horner's rule.
fn evaluate(coefficients: &[c64], z: c64) -> (c64, c64) {
    coefficients.iter().fold((ZERO, ZERO), |(value, slope), c| (value * z + c, slope * z + value))
}
