use faer::{Mat, c64};

use catamaran::base::{Error, Result, Sets};

/// The polynomial of a fractal.
#[derive(Debug, Clone, PartialEq)]
pub enum Polynomial {
    /// z^n - 1, n from 2 to [`Polynomial::MOST_ROOTS`]. Root a is exp(2 pi i a / n).
    Power(u32),
    /// The product of all (z - root). A root is a real and an imaginary part within 1e4 of zero;
    /// there are 1 to [`Polynomial::MOST_ROOTS`] roots. Root a is the a-th one. Convergence to a
    /// multiple root is slow, and among equal roots the first one is reported.
    Roots(Vec<[f64; 2]>),
}

impl Polynomial {
    /// The greatest number of roots in C.
    pub const MOST_ROOTS: usize = 64;

    /// Returns the number n of roots in C; there are n^2 bicomplex roots.
    pub fn roots(&self) -> usize {
        match self {
            Self::Power(n) => *n as usize,
            Self::Roots(roots) => roots.len(),
        }
    }

    /// Creates the polynomial `c[0] z^n + c[1] z^(n - 1) + ... + c[n]`, where each c is a real and
    /// an imaginary part, in the order of numpy. Its roots are ordered by real, then by imaginary
    /// part. They are the eigenvalues of the companion matrix, improved by Newton's method. Roots
    /// that make the same polynomial, to within rounding, when they coincide are equal: the
    /// eigenvalues of (z - 1)^5 are five numbers around 1.
    ///
    /// ```
    /// use catamaran_simulation::texture::newton::Polynomial;
    ///
    /// // z^2 - 3 z + 2
    /// let found = Polynomial::from_coefficients(&[[1.0, 0.0], [-3.0, 0.0], [2.0, 0.0]])?;
    /// let Polynomial::Roots(roots) = found else { unreachable!() };
    /// assert!((roots[0][0] - 1.0).abs() < 1e-15 && (roots[1][0] - 2.0).abs() < 1e-15);
    /// # Ok::<(), catamaran::Error>(())
    /// ```
    ///
    /// # Errors
    /// [`Error::Argument`] names "polynomial" when the polynomial is constant, has a degree above
    /// [`Polynomial::MOST_ROOTS`], or has no finite roots; [`Error::NonFinite`] names a
    /// coefficient.
    pub fn from_coefficients(coefficients: &[[f64; 2]]) -> Result<Self> {
        if let Some(i) = coefficients.iter().position(|c| !c.iter().all(|x| x.is_finite())) {
            return Err(Error::NonFinite { what: "polynomial", index: (i, 0) });
        }
        let refuse = |why: String| Err(Error::Argument { what: "polynomial", why });
        let mut coefficients: Vec<c64> =
            coefficients.iter().map(|&[re, im]| c64::new(re, im)).collect();
        let zero = c64::new(0.0, 0.0);
        let leading = coefficients.iter().position(|c| *c != zero).unwrap_or(coefficients.len());
        coefficients.drain(..leading);
        if coefficients.len() < 2 {
            return refuse("must not be constant".into());
        }
        let degree = coefficients.len() - 1;
        if degree > Self::MOST_ROOTS {
            return refuse(format!("degree must be from 1 to {}, is {degree}", Self::MOST_ROOTS));
        }
        let companion = Mat::from_fn(degree, degree, |i, j| match (i, j) {
            (0, j) => -coefficients[j + 1] / coefficients[0],
            (i, j) if i == j + 1 => c64::new(1.0, 0.0),
            _ => zero,
        });
        let eigenvalues = companion.is_all_finite().then(|| companion.eigenvalues().ok());
        let Some(found) = eigenvalues.flatten() else {
            return refuse("the coefficients are too far apart to find the roots".into());
        };
        let found = merged(&coefficients, &found)
            .unwrap_or_else(|| found.iter().map(|root| improved(&coefficients, *root)).collect());
        let mut roots: Vec<[f64; 2]> = found.iter().map(|root| [root.re, root.im]).collect();
        roots.sort_by(|a, b| a[0].total_cmp(&b[0]).then(a[1].total_cmp(&b[1])));
        Ok(Self::Roots(roots))
    }
}

/// Returns the roots with multiple roots in place of the eigenvalues around them, which would have
/// a basin each; `None` if there are no multiple roots. Eigenvalues are one root if the polynomial
/// of that root has the given coefficients.
fn merged(coefficients: &[c64], eigenvalues: &[c64]) -> Option<Vec<c64>> {
    /// The largest and the smallest distance between neighbours around a multiple root, as parts of
    /// the size of the largest root.
    const FARTHEST: f64 = 0.3;
    const NEAREST: f64 = 1e-9;
    let size = eigenvalues.iter().map(|root| root.norm()).fold(0.0, f64::max);
    let mut distance = FARTHEST * size;
    while distance > NEAREST * size {
        let groups = within(eigenvalues, distance);
        let multiple = groups.iter().enumerate().any(|(i, group)| i != *group as usize);
        let roots: Vec<c64> =
            groups.iter().map(|g| center(coefficients, eigenvalues, &groups, *g)).collect();
        if multiple && has_roots(coefficients, &roots) {
            return Some(roots);
        }
        distance *= 0.5;
    }
    None
}

/// Returns a number for each eigenvalue, equal for those that a path of others connects, in steps
/// of at most `distance`.
fn within(eigenvalues: &[c64], distance: f64) -> Vec<u32> {
    let count = eigenvalues.len();
    let mut sets = Sets::new(count);
    for i in 0..count {
        for j in 0..i {
            if (eigenvalues[i] - eigenvalues[j]).norm() <= distance {
                sets.join(i as u32, j as u32);
            }
        }
    }
    (0..count as u32).map(|i| sets.find(i)).collect()
}

/// Returns the m-fold root that a group of m eigenvalues surrounds: the simple root of derivative
/// m - 1 that is near their mean.
fn center(coefficients: &[c64], eigenvalues: &[c64], groups: &[u32], group: u32) -> c64 {
    let members = eigenvalues.iter().zip(groups).filter(|(_, other)| **other == group);
    let (mut sum, mut count, mut derivative) = (c64::new(0.0, 0.0), 0.0, coefficients.to_vec());
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

/// Returns whether a polynomial with these roots, and the first of these coefficients, has the
/// others, too.
fn has_roots(coefficients: &[c64], roots: &[c64]) -> bool {
    /// Rounding errors of a coefficient, relative to the sum of the sizes of its terms.
    const ROUNDING: f64 = 1e-13;
    let mut product = vec![coefficients[0]];
    let mut sizes = vec![coefficients[0].norm()];
    for root in roots {
        product.push(c64::new(0.0, 0.0));
        sizes.push(0.0);
        for i in (1..product.len()).rev() {
            let (before, size) = (product[i - 1], sizes[i - 1]);
            product[i] -= *root * before;
            sizes[i] += root.norm() * size;
        }
    }
    let mut all = product.iter().zip(coefficients).zip(&sizes);
    all.all(|((found, given), size)| (*found - *given).norm() <= ROUNDING * size)
}

/// Returns the root after steps of Newton's method that reduce the value of the polynomial.
fn improved(coefficients: &[c64], mut root: c64) -> c64 {
    const STEPS: usize = 8;
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
    let zero = c64::new(0.0, 0.0);
    coefficients.iter().fold((zero, zero), |(value, slope), c| (value * z + c, slope * z + value))
}

#[cfg(test)]
mod tests {
    use super::*;
    use catamaran::base::Rng;

    fn roots(coefficients: &[[f64; 2]]) -> Vec<[f64; 2]> {
        match Polynomial::from_coefficients(coefficients).unwrap() {
            Polynomial::Roots(roots) => roots,
            Polynomial::Power(_) => unreachable!(),
        }
    }

    /// Returns the coefficients of the product of all (z - root), times a factor.
    fn product(roots: &[[f64; 2]], factor: c64) -> Vec<[f64; 2]> {
        let mut coefficients = vec![factor];
        for &[re, im] in roots {
            let root = c64::new(re, im);
            coefficients.push(c64::new(0.0, 0.0));
            for i in (1..coefficients.len()).rev() {
                let before = coefficients[i - 1];
                coefficients[i] -= root * before;
            }
        }
        coefficients.into_iter().map(|c| [c.re, c.im]).collect()
    }

    #[test]
    fn roots_of_a_product_are_found_again() {
        let mut rng = Rng::new(4);
        for degree in [1, 2, 3, 7, 13] {
            let mut wanted: Vec<[f64; 2]> = (0..degree)
                .map(|_| [2.0 * rng.uniform() - 1.0, 2.0 * rng.uniform() - 1.0])
                .collect();
            wanted.sort_by(|a, b| a[0].total_cmp(&b[0]));
            let mut coefficients = vec![[0.0, 0.0]; 2];
            coefficients.extend(product(&wanted, c64::new(3.0, -2.0)));
            let found = roots(&coefficients);
            assert_eq!(found.len(), degree);
            for (found, wanted) in found.iter().zip(&wanted) {
                assert!((0..2).all(|k| (found[k] - wanted[k]).abs() < 1e-9), "{degree}");
            }
        }
    }

    #[test]
    fn roots_of_unity_and_equal_roots_are_found() {
        let mut coefficients = vec![[0.0, 0.0]; 65];
        (coefficients[0], coefficients[64]) = ([1.0, 0.0], [-1.0, 0.0]);
        assert!(roots(&coefficients).iter().all(|[re, im]| (re.hypot(*im) - 1.0).abs() < 1e-14));
        let triple = product(&[[0.5, 0.0]; 3], c64::new(1.0, 0.0));
        assert!(roots(&triple).iter().all(|[re, im]| (re - 0.5).hypot(*im) < 1e-4));
        assert_eq!(roots(&[[1.0, 0.0], [0.0, 0.0], [0.0, 0.0]]), [[0.0, 0.0]; 2]);
    }

    #[test]
    fn multiple_roots_are_equal_and_near_roots_are_not() {
        let one = c64::new(1.0, 0.0);
        let distinct = |wanted: &[[f64; 2]]| {
            let mut found = roots(&product(wanted, c64::new(2.0, 1.0)));
            let near = |root: &[f64; 2]| {
                wanted.iter().any(|[re, im]| (root[0] - re).hypot(root[1] - im) < 1e-9)
            };
            assert!(found.len() == wanted.len() && found.iter().all(near), "{found:?}");
            found.dedup();
            found.len()
        };
        let [a, b] = [[1.0, 0.0], [-1.0, 0.0]];
        assert_eq!(distinct(&[a; 2]), 1);
        assert_eq!(distinct(&[a; 20]), 1);
        assert_eq!(distinct(&[a, a, a, b, b]), 2);
        assert_eq!(distinct(&[[0.0, 1.0], [0.0, 1.0], [0.0, -1.0], [0.5, 0.0]]), 3);
        assert_eq!(distinct(&[a, [1.001, 0.0]]), 2);
        assert_eq!(distinct(&[a, [1.00001, 0.0]]), 2);
        let unity: Vec<[f64; 2]> = (0..16)
            .map(|k| (std::f64::consts::PI * f64::from(k) / 8.0).sin_cos())
            .map(|(sin, cos)| [cos, sin])
            .collect();
        assert_eq!(distinct(&unity), 16);
        // (z - 1)^2 as written: both roots are exactly 1.
        assert_eq!(roots(&product(&[a; 2], one)), [a; 2]);
    }

    #[test]
    fn what_has_no_roots_is_refused_by_name() {
        let number = |x: f64| [x, 0.0];
        for (coefficients, why) in [
            (vec![], "constant"),
            (vec![number(0.0), number(7.0)], "constant"),
            (vec![number(1.0); 66], "is 65"),
            (vec![number(1e-300), number(1e300)], "too far apart"),
            (vec![number(1.0), number(f64::NAN)], "polynomial"),
        ] {
            let refused = Polynomial::from_coefficients(&coefficients).unwrap_err().to_string();
            assert!(refused.contains(why) && refused.contains("polynomial"), "{refused}");
        }
    }
}
