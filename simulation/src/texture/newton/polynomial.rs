use faer::c64;

use super::roots;
use catamaran::base::{Error, Result};

/// The polynomial of a fractal.
#[derive(Debug, Clone, PartialEq)]
pub enum Polynomial {
    /// z^n - 1, n from 2 to [`Polynomial::MOST_ROOTS`]. Root a is exp(2 pi i a / n).
    Power(u32),
    /// The product of all (z - root). A root is a real and an imaginary part within 1e4 of zero;
    /// there are 1 to [`Polynomial::MOST_ROOTS`] roots, of which the largest is 0 or at least 1e-12
    /// from zero. Root a is the a-th one. Convergence to a multiple root is slow, and among equal
    /// roots the first one is reported.
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

    /// Returns the distance of the largest root from 0.
    pub(super) fn largest_root(&self) -> f64 {
        match self {
            Self::Power(_) => 1.0,
            Self::Roots(roots) => roots.iter().map(|[re, im]| re.hypot(*im)).fold(0.0, f64::max),
        }
    }

    /// Creates the polynomial `c[0] z^n + c[1] z^(n - 1) + ... + c[n]`, where each c is a real and
    /// an imaginary part, in the order of numpy. Its roots are ordered by real, then by imaginary
    /// part. They are the eigenvalues of the companion matrix, improved by Newton's method, or
    /// where these are not good enough those of the iteration of Aberth and Ehrlich: the polynomial
    /// with these roots has the given coefficients to within 1e-3 of the sizes of their terms, and
    /// most often to rounding. Roots that make the same polynomial, to within rounding, when they
    /// coincide are equal: the eigenvalues of (z - 1)^5 are five numbers around 1.
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
    /// [`Polynomial::MOST_ROOTS`] or no finite roots, or when its coefficients do not determine its
    /// roots well enough; [`Error::NonFinite`] names a coefficient.
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
        let found = match roots::roots(&coefficients) {
            Ok(found) => found,
            Err(why) => return refuse(why.into()),
        };
        let mut roots: Vec<[f64; 2]> = found.iter().map(|root| [root.re, root.im]).collect();
        roots.sort_by(|a, b| a[0].total_cmp(&b[0]).then(a[1].total_cmp(&b[1])));
        Ok(Self::Roots(roots))
    }
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

    /// Asserts that each root is found once, to this part of its size.
    fn finds(coefficients: &[[f64; 2]], wanted: &[[f64; 2]], tolerance: f64) {
        let mut found = roots(coefficients);
        assert_eq!(found.len(), wanted.len());
        for &[re, im] in wanted {
            let off = |root: &[f64; 2]| (root[0] - re).hypot(root[1] - im) / re.hypot(im);
            let nearest =
                (0..found.len()).min_by(|&i, &j| off(&found[i]).total_cmp(&off(&found[j])));
            let nearest = found.swap_remove(nearest.unwrap());
            assert!(off(&nearest) <= tolerance, "{nearest:?} in place of {re} + {im} i");
        }
    }

    #[test]
    fn roots_of_any_size_are_found() {
        for (degree, power) in [
            (4, -20),
            (3, -21),
            (3, 15),
            (5, 15),
            (3, 30),
            (8, 12),
            (8, 16),
            (12, 18),
            (20, 20),
            (64, 128),
            (64, -250),
        ] {
            let mut coefficients = vec![[0.0, 0.0]; degree + 1];
            (coefficients[0], coefficients[degree]) = ([1.0, 0.0], [-(10_f64.powi(power)), 0.0]);
            let size = 10_f64.powf(f64::from(power) / degree as f64);
            let turn = |k: usize| std::f64::consts::TAU * k as f64 / degree as f64;
            let wanted: Vec<[f64; 2]> =
                (0..degree).map(|k| [size * turn(k).cos(), size * turn(k).sin()]).collect();
            finds(&coefficients, &wanted, 1e-12);
            // So are those of a multiple.
            coefficients.iter_mut().flatten().for_each(|c| *c *= 1e-40);
            finds(&coefficients, &wanted, 1e-12);
        }
        for factor in [1e300, 1e-300] {
            let coefficients = [[factor, 0.0], [0.0, 0.0], [-factor, 0.0]];
            finds(&coefficients, &[[-1.0, 0.0], [1.0, 0.0]], 1e-15);
        }
    }

    #[test]
    fn roots_of_widely_different_sizes_are_found() {
        let one = c64::new(1.0, 0.0);
        finds(&[[1.0, 0.0], [-1e10, 0.0], [1.0, 0.0]], &[[1e10, 0.0], [1e-10, 0.0]], 1e-15);
        for wanted in [
            vec![[1e-6, 0.0], [2e-6, 0.0], [1e3, 0.0], [-3e3, 0.0], [1.0, 0.0]],
            vec![[1e-10, 0.0], [0.0, 2e-10], [1e10, 0.0], [0.0, -1e9], [1e4, 1e4], [-1e-3, 0.0]],
        ] {
            finds(&product(&wanted, one), &wanted, 1e-12);
        }
        // z^64 + 1e30 z^63 + 1, with powers that overflow.
        let mut coefficients = vec![[0.0, 0.0]; 65];
        (coefficients[0], coefficients[1], coefficients[64]) =
            ([1.0, 0.0], [1e30, 0.0], [1.0, 0.0]);
        let size = 1e-30_f64.powf(1.0 / 63.0);
        let turn = |k: usize| std::f64::consts::PI * (2 * k + 1) as f64 / 63.0;
        let mut wanted: Vec<[f64; 2]> =
            (0..63).map(|k| [size * turn(k).cos(), size * turn(k).sin()]).collect();
        wanted.push([-1e30, 0.0]);
        finds(&coefficients, &wanted, 1e-12);
        // Roots at 0 are exact beside others.
        let found = roots(&product(&[[0.0, 0.0], [0.0, 0.0], [3e-9, 0.0]], one));
        assert_eq!(found[..2], [[0.0, 0.0]; 2]);
    }

    #[test]
    fn roots_that_coefficients_do_not_tell_are_refused() {
        let mut many = vec![[1.0, 0.0]; 20];
        many.push([1.5, 0.0]);
        let steps: Vec<[f64; 2]> = (1..=30).map(|k| [f64::from(k), 0.0]).collect();
        for wanted in [many, steps] {
            let coefficients = product(&wanted, c64::new(1.0, 0.0));
            let refused = Polynomial::from_coefficients(&coefficients).unwrap_err().to_string();
            assert!(refused.contains("polynomial: roundings of the coefficients"), "{refused}");
        }
        // The roots 1 to 10 are told well enough.
        let steps: Vec<[f64; 2]> = (1..=10).map(|k| [f64::from(k), 0.0]).collect();
        finds(&product(&steps, c64::new(1.0, 0.0)), &steps, 1e-8);
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
