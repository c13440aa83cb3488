//! Quotients of integers of 256 bits, rounded once.

use crate::kernel::int8::scaled;

/// An integer below 2^256.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
struct Wide {
    high: u128,
    low: u128,
}

impl Wide {
    fn product(a: u128, b: u128) -> Self {
        const HALF: u128 = u64::MAX as u128;
        let [a0, a1, b0, b1] = [a & HALF, a >> 64, b & HALF, b >> 64];
        let (low, cross, other, high) = (a0 * b0, a0 * b1, a1 * b0, a1 * b1);
        let middle = (low >> 64) + (cross & HALF) + (other & HALF);
        Self {
            high: high + (cross >> 64) + (other >> 64) + (middle >> 64),
            low: low & HALF | middle << 64,
        }
    }

    fn leading_zeros(self) -> u32 {
        match self.high {
            0 => u128::BITS + self.low.leading_zeros(),
            high => high.leading_zeros(),
        }
    }

    /// For `shift` below 256.
    fn shifted(self, shift: u32) -> Self {
        match shift {
            0 => self,
            128.. => Self { high: self.low << (shift - 128), low: 0 },
            _ => Self {
                high: self.high << shift | self.low >> (128 - shift),
                low: self.low << shift,
            },
        }
    }

    fn plus(self, other: Self) -> Option<Self> {
        let (low, carry) = self.low.overflowing_add(other.low);
        let high = self.high.checked_add(other.high)?.checked_add(carry.into())?;
        Some(Self { high, low })
    }

    /// `self - other`, for one that is no larger.
    fn minus(self, other: Self) -> Self {
        let (low, borrow) = self.low.overflowing_sub(other.low);
        Self { high: self.high - other.high - u128::from(borrow), low }
    }
}

/// `(c - a b 2^shift / w) 2^exponent`, rounded once to an f64, and a second time where it is
/// subnormal; `None` when a number on the way has more than 256 bits. `w` is not zero.
pub(super) fn centered(
    c: i128,
    [a, b]: [i128; 2],
    shift: u32,
    w: i128,
    exponent: i32,
) -> Option<f64> {
    let whole = Wide::product(c.unsigned_abs(), w.unsigned_abs());
    let part = Wide::product(a.unsigned_abs(), b.unsigned_abs());
    if part.leading_zeros() < shift {
        return None;
    }
    let part = part.shifted(shift);
    let whole_negative = (c < 0) != (w < 0);
    let part_negative = (a < 0) != (b < 0);
    let (size, negative) = if whole_negative != part_negative {
        (whole.plus(part)?, whole_negative)
    } else if whole >= part {
        (whole.minus(part), whole_negative)
    } else {
        (part.minus(whole), !whole_negative)
    };
    let value = quotient(size, w.unsigned_abs(), exponent);
    Some(if negative != (w < 0) { -value } else { value })
}

/// `n / d 2^exponent`, d not zero.
fn quotient(n: Wide, d: u128, exponent: i32) -> f64 {
    if n == (Wide { high: 0, low: 0 }) {
        return 0.0;
    }
    // Both begin with a one, d against the upper half of n: the quotient is between 1/2 and 2.
    let (of_n, of_d) = (n.leading_zeros(), d.leading_zeros());
    let (n, d) = (n.shifted(of_n), d << of_d);
    let mut bits = u128::from(n.high >= d);
    let mut rest = if n.high >= d { n.high - d } else { n.high };
    // More bits than an f64 has, of which the last one stands for all that follow.
    const MORE: u32 = 64;
    for i in 0..MORE {
        let carry = rest >> 127 != 0;
        rest = rest << 1 | n.low >> (127 - i) & 1;
        let one = carry || rest >= d;
        if one {
            rest = rest.wrapping_sub(d);
        }
        bits = bits << 1 | u128::from(one);
    }
    let inexact = rest != 0 || n.low << MORE != 0;
    let bits = bits << 1 | u128::from(inexact);
    let unit = 128 - of_n as i32 + of_d as i32 - MORE as i32 - 1;
    scaled(bits as f64, exponent + unit)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::base::Rng;

    #[test]
    fn quotients_of_integers_that_fit_in_128_bits_are_rounded_once() {
        let mut rng = Rng::new(1);
        let mut number = |bits: u32| {
            let size = (rng.uniform() * f64::from(bits).exp2()) as i128;
            if rng.uniform() < 0.5 { -size } else { size }
        };
        for _ in 0..20_000 {
            let (c, a, b) = (number(60), number(50), number(50));
            let w = number(40) * 2 + 1;
            // The difference as a fraction, in integers.
            let n = c * w - ((a * b) << 3);
            let found = centered(c, [a, b], 3, w, 0).unwrap();
            let (n, d) = (n.unsigned_abs(), w.unsigned_abs());
            let negative = (c * w - ((a * b) << 3) < 0) != (w < 0);
            let near = if negative { -found } else { found };
            // |found - n / d| <= ulp / 2: with found = k 2^e, compare 2 |k 2^e d - n| with 2^e d.
            if n == 0 {
                assert_eq!(found, 0.0);
                continue;
            }
            assert!(near > 0.0, "{near}");
            let e = ((near.to_bits() >> 52) as i32 - 1075).max(-60);
            let k = (near / f64::from(e).exp2()) as u128;
            if e >= 0 {
                let error = (k << e) * d;
                assert!(2 * error.abs_diff(n) <= d << e);
            } else if n.leading_zeros() as i32 > 1 - e {
                assert!(2 * (k * d).abs_diff(n << -e) <= d);
            }
        }
    }

    #[test]
    fn wide_numbers_come_out_right() {
        let big = 1_i128 << 120;
        // (2^120 3 - 2^200 / 2^100) = 3 2^120 - 2^100
        assert_eq!(
            centered(3 * big, [1 << 100, 1 << 100], 0, 1 << 100, 0),
            Some((3 * big - (1 << 100)) as f64)
        );
        assert_eq!(centered(big, [big, big], 0, big, 0), Some(0.0));
        assert_eq!(centered(big, [big, -big], 0, -big, -121), Some(0.0));
        assert_eq!(centered(0, [1, -1], 120, 3, -120), Some(1.0 / 3.0));
        assert_eq!(centered(1, [1, 2], 120, -3, -120), Some(2.0 / 3.0));
        assert_eq!(centered(i128::MAX, [i128::MAX, i128::MAX], 3, 1, 0), None);
        // A tie is broken by what is far below it: 2^53 + 1 + 2^-60.
        let c = (1_i128 << 113) + (1 << 60) + 1;
        assert_eq!(centered(c, [0, 0], 0, 1, -60), Some(2f64.powi(53) + 2.0));
        assert_eq!(centered(c - 1, [0, 0], 0, 1, -60), Some(2f64.powi(53)));
    }
}
