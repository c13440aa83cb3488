//! Perfect difference covers: lines of the projective planes over finite fields.
//!
//! The `N = q^2 + q + 1` points of the plane over the field of q elements are the powers of a
//! suitable element x of the field of `q^3` elements, up to factors of the small field. The points
//! of a line, as exponents modulo N, have every difference exactly once. Source: J. Singer, "A
//! theorem in finite projective geometry and some applications to number theory" (1938).

/// The largest order of a plane that is used: more than 65,536 points.
const LARGEST: usize = 256;

/// Returns q if a plane has `points = q^2 + q + 1` points, q a power of a prime.
pub(super) fn order_of_plane(points: usize) -> Option<usize> {
    let q = points.isqrt();
    let is_plane = (2..=LARGEST).contains(&q) && q * q + q + 1 == points;
    (is_plane && root_of_power(q).is_some()).then_some(q)
}

/// Returns the prime p and the exponent k if `q = p^k`, q at least 2.
fn root_of_power(q: usize) -> Option<(usize, usize)> {
    let p = (2..=q).find(|p| q.is_multiple_of(*p))?;
    let k = q.ilog(p) as usize;
    (p.pow(k as u32) == q).then_some((p, k))
}

/// Returns the points of a line of the plane of `order`, a power of a prime: `order + 1` residues
/// modulo `order^2 + order + 1`, ascending from 0.
pub(super) fn line(order: usize) -> Vec<usize> {
    let Some((p, k)) = root_of_power(order) else { unreachable!("{order} is no power of a prime") };
    // Some polynomial with few terms is irreducible, and x has enough powers: up to order 64 that
    // is among the first 65.
    (1..).find_map(|code| Ring::new(p, k, code)?.line()).unwrap_or_default()
}

/// Polynomials over the integers modulo p, modulo a polynomial of degree 3 k: a field of `q^3`
/// elements, `q = p^k`, if that is irreducible.
struct Ring {
    p: usize,
    q: usize,
    /// `x^(3 k)` as a polynomial of lower degree; lowest terms first.
    overflow: Vec<usize>,
    /// For each power of x its q-th power.
    frobenius: Vec<Vec<usize>>,
}

impl Ring {
    /// Creates the ring whose polynomial has the digits of `code` in base p as coefficients;
    /// `None` if x divides it.
    fn new(p: usize, k: usize, mut code: usize) -> Option<Self> {
        let digit = |_| {
            let digit = code % p;
            code /= p;
            digit
        };
        let overflow: Vec<usize> = (0..3 * k).map(digit).collect();
        let mut ring = Self { p, q: p.pow(k as u32), overflow, frobenius: Vec::new() };
        if ring.overflow[0] == 0 {
            return None;
        }
        // x^q, and its powers.
        let mut image = ring.one();
        (0..ring.q).for_each(|_| ring.multiply_by_x(&mut image));
        let mut power = ring.one();
        for _ in 0..3 * k {
            let next = ring.product(&power, &image);
            ring.frobenius.push(std::mem::replace(&mut power, next));
        }
        Some(ring)
    }

    fn one(&self) -> Vec<usize> {
        let mut one = vec![0; self.overflow.len()];
        one[0] = 1;
        one
    }

    fn multiply_by_x(&self, y: &mut [usize]) {
        y.rotate_right(1);
        let high = std::mem::take(&mut y[0]);
        self.add(y, high, &self.overflow);
    }

    /// Adds `factor z` to y.
    fn add(&self, y: &mut [usize], factor: usize, z: &[usize]) {
        y.iter_mut().zip(z).for_each(|(y, z)| *y = (*y + factor * z) % self.p);
    }

    fn product(&self, y: &[usize], z: &[usize]) -> Vec<usize> {
        let mut product = vec![0; y.len()];
        for &coefficient in y.iter().rev() {
            self.multiply_by_x(&mut product);
            self.add(&mut product, coefficient, z);
        }
        product
    }

    /// Returns `y^q`, which is linear in y.
    fn raised(&self, y: &[usize]) -> Vec<usize> {
        let mut sum = vec![0; y.len()];
        y.iter()
            .zip(&self.frobenius)
            .for_each(|(&factor, image)| self.add(&mut sum, factor, image));
        sum
    }

    /// Returns the exponents of x, below `q^2 + q + 1`, whose trace over the field of q elements is
    /// zero, moved to 0; `None` unless these are a line.
    fn line(&self) -> Option<Vec<usize>> {
        let points = self.q * self.q + self.q + 1;
        let mut power = self.one();
        let mut line = Vec::new();
        for exponent in 0..points {
            let once = self.raised(&power);
            let twice = self.raised(&once);
            if (0..power.len()).all(|i| (power[i] + once[i] + twice[i]).is_multiple_of(self.p)) {
                line.push(exponent);
            }
            if line.len() > self.q + 1 {
                return None;
            }
            self.multiply_by_x(&mut power);
        }
        let first = *line.first()?;
        line.iter_mut().for_each(|point| *point -= first);
        // In a ring that is no field, or where x has too few powers, differences occur twice.
        let mut seen = vec![false; points];
        let mut is_new =
            |a: usize, b: usize| !std::mem::replace(&mut seen[(a + points - b) % points], true);
        let perfect = line.len() == self.q + 1
            && line.iter().all(|&a| line.iter().all(|&b| a == b || is_new(a, b)));
        perfect.then_some(line)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn planes_of_prime_powers_are_found_and_no_others() {
        let orders: Vec<usize> = (2..3000).filter_map(order_of_plane).collect();
        let expected = [
            2, 3, 4, 5, 7, 8, 9, 11, 13, 16, 17, 19, 23, 25, 27, 29, 31, 32, 37, 41, 43, 47, 49, 53,
        ];
        assert_eq!(orders, expected);
        assert_eq!(order_of_plane(255 * 255 + 255 + 1), None);
    }

    #[test]
    fn any_two_shifts_of_a_line_have_one_point_in_common() {
        for order in [2, 3, 4, 5, 7, 8, 9, 16, 25, 27, 32, 61, 64] {
            let (line, points) = (line(order), order * order + order + 1);
            assert!(line[0] == 0 && line.is_sorted() && line.len() == order + 1);
            for shift in 1..points {
                let both = line.iter().filter(|&a| line.contains(&((a + shift) % points)));
                assert_eq!(both.count(), 1, "order {order}, shift {shift}");
            }
        }
    }
}
