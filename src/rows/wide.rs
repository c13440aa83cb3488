//! Quotients of integers of 256 bits, rounded once.

use crate::kernel::int8::{I256, Integer, U256, scaled};

/// An integer type of exact sums.
pub(crate) trait SumInteger: Integer {
    /// Whether the type is that of extended precision.
    const EXTENDED: bool;

    /// Returns `(self - a b 2^shift / w) 2^exponent`, rounded once; `None` when an intermediate
    /// number has more than 256 bits. `w` is not zero.
    fn centered(self, sums: [i128; 2], shift: u32, w: i128, exponent: i32) -> Option<f64>;
}

impl SumInteger for i128 {
    const EXTENDED: bool = false;

    fn centered(self, sums: [i128; 2], shift: u32, w: i128, exponent: i32) -> Option<f64> {
        centered(self, sums, shift, w, exponent)
    }
}

impl SumInteger for I256 {
    const EXTENDED: bool = true;

    fn centered(self, sums: [i128; 2], shift: u32, w: i128, exponent: i32) -> Option<f64> {
        centered_parts(self, sums, shift, w, exponent).map(|parts| parts[0])
    }
}

/// Returns `(c - a b 2^shift / w) 2^exponent` as a sum of three f64; `None` when an intermediate
/// integer has more than 255 bits. `w` is not zero.
pub(super) fn centered_parts(
    c: I256,
    [a, b]: [i128; 2],
    shift: u32,
    w: i128,
    exponent: i32,
) -> Option<[f64; 3]> {
    /// Bits below the unit of c that are enough for three f64.
    const MORE: u32 = 160;
    let (n, d) = (U256::product(a.unsigned_abs(), b.unsigned_abs()), w.unsigned_abs());
    // The quotient and c get as many additional bits as there is room for.
    let bits = (256 - n.leading_zeros() + shift + d.leading_zeros() + 1).saturating_sub(u128::BITS);
    let room = c.magnitude().leading_zeros().min(256_u32.checked_sub(bits)?);
    let more = room.checked_sub(2)?.min(MORE);
    let quotient = divided(n, shift + more, d);
    let quotient = I256::of_bits(quotient);
    let negative = [a, b, w].iter().filter(|&&x| x < 0).count() % 2 == 1;
    let quotient = if negative { quotient.negated() } else { quotient };
    let value = c.shifted_left(more)?.checked_plus(quotient.negated())?;
    Some(value.parts(exponent - more as i32))
}

/// Returns `a / w 2^exponent` as a sum of two f64; `w` is not zero.
pub(super) fn mean_parts(a: i128, w: i128, exponent: i32) -> [f64; 2] {
    let [high, low, _] = centered_parts(I256::default(), [a, 1], 0, w, exponent)
        .expect("a quotient is no longer than its dividend");
    [-high, -low]
}

/// Returns the largest integer up to `n 2^shift / d`, which has at most 256 bits; d is not zero.
fn divided(n: U256, shift: u32, d: u128) -> U256 {
    const WORD: u32 = u64::BITS;
    let zeros = d.leading_zeros();
    let d = d << zeros;
    // The dividend has at most 256 bits more than d.
    let mut words = [0_u64; 8];
    let (skipped, bits) = (((shift + zeros) / WORD) as usize, (shift + zeros) % WORD);
    let parts = [n.low as u64, (n.low >> WORD) as u64, n.high as u64, (n.high >> WORD) as u64];
    for (i, part) in parts.into_iter().enumerate().filter(|&(_, part)| part != 0) {
        let both = u128::from(part) << bits;
        words[skipped + i] |= both as u64;
        words[skipped + i + 1] |= (both >> WORD) as u64;
    }
    let (mut rest, mut quotient) = (0, U256 { high: 0, low: 0 });
    for word in words.into_iter().rev() {
        let digit;
        (digit, rest) = divided_digit(rest, word, d);
        quotient = quotient.shifted(WORD);
        quotient.low |= u128::from(digit);
    }
    quotient
}

/// Returns quotient and remainder of `(rest 2^64 + word) / d`, for `rest` below d, whose first bit
/// is set: a digit of a long division by two digits (Knuth 1997, volume 2, 4.3.1, algorithm D).
fn divided_digit(rest: u128, word: u64, d: u128) -> (u64, u128) {
    let [upper, lower] = [d >> 64, d & u128::from(u64::MAX)];
    // The digit is too large by 2 at most.
    let mut digit = (rest / upper).min(u128::from(u64::MAX));
    let mut head = rest - digit * upper;
    while head >> 64 == 0 && digit * lower > (head << 64 | u128::from(word)) {
        digit -= 1;
        head += upper;
    }
    let left = (head << 64 | u128::from(word)).wrapping_sub(digit * lower);
    (digit as u64, left)
}

/// Returns `(c - a b 2^shift / w) 2^exponent`, rounded once to an f64, and a second time where it
/// is subnormal; `None` when an intermediate number has more than 256 bits. `w` is not zero.
pub(super) fn centered(
    c: i128,
    [a, b]: [i128; 2],
    shift: u32,
    w: i128,
    exponent: i32,
) -> Option<f64> {
    let whole = U256::product(c.unsigned_abs(), w.unsigned_abs());
    let part = U256::product(a.unsigned_abs(), b.unsigned_abs());
    if part.leading_zeros() < shift {
        return None;
    }
    let part = part.shifted(shift);
    let whole_negative = (c < 0) != (w < 0);
    let part_negative = (a < 0) != (b < 0);
    let (size, negative) = if whole_negative != part_negative {
        (whole.checked_plus(part)?, whole_negative)
    } else if whole >= part {
        (whole.minus(part), whole_negative)
    } else {
        (part.minus(whole), !whole_negative)
    };
    let value = quotient(size, w.unsigned_abs(), exponent);
    Some(if negative != (w < 0) { -value } else { value })
}

/// Returns `n / d 2^exponent`, d not zero.
fn quotient(n: U256, d: u128, exponent: i32) -> f64 {
    if n == (U256 { high: 0, low: 0 }) {
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
        // A tie is decided by a bit far below it: 2^53 + 1 + 2^-60.
        let c = (1_i128 << 113) + (1 << 60) + 1;
        assert_eq!(centered(c, [0, 0], 0, 1, -60), Some(2f64.powi(53) + 2.0));
        assert_eq!(centered(c - 1, [0, 0], 0, 1, -60), Some(2f64.powi(53)));
    }

    #[test]
    fn extended_quotients_are_those_of_short_ones_with_more_bits() {
        let mut rng = Rng::new(2);
        let mut number = |bits: u32| {
            let size = (rng.uniform() * f64::from(bits).exp2()) as i128;
            if rng.uniform() < 0.5 { -size } else { size }
        };
        for _ in 0..20_000 {
            let (c, a, b) = (number(50), number(30), number(30));
            let w = number(20) * 2 + 1;
            let wide = I256 { high: c >> 127, low: c as u128 };
            let parts = centered_parts(wide, [a, b], 3, w, 0).unwrap();
            assert_eq!(Some(parts[0]), centered(c, [a, b], 3, w, 0), "{c} - {a} {b} 8 / {w}");
            // w times the parts is the numerator; of the last two parts, as fractions of 2^60.
            let n = c * w - ((a * b) << 3);
            let unit = 60.0_f64.exp2();
            let product = |x: f64| I256::product((x * unit) as i128, w).unwrap();
            let sum = parts.map(product).into_iter().reduce(I256::plus).unwrap();
            let n = I256 { high: n >> 127, low: n as u128 }.shifted_left(60).unwrap();
            let error = sum.plus(n.negated()).to_f64();
            assert!(error.abs() <= 4.0 * w.abs() as f64, "{error}");
        }
    }

    #[test]
    fn long_divisions_are_those_of_integers_of_any_size() {
        use num_bigint::BigUint;

        let mut rng = Rng::new(3);
        // Estimates of digits fail for long runs of equal bits.
        let mut random = || {
            let x = (0..6).fold(0_u128, |x, _| {
                let count = rng.bits() % 40;
                x << count | if rng.bits().is_multiple_of(2) { 0 } else { (1 << count) - 1 }
            });
            x >> (rng.bits() % 128)
        };
        let big = |n: U256| (BigUint::from(n.high) << 128) + n.low;
        let mut longest = 0;
        for _ in 0..200_000 {
            let (a, b, d) = (random(), random(), random().max(1));
            let n = U256::product(a, b);
            let room = 383_u32.saturating_sub(d.leading_zeros() + 256 - n.leading_zeros());
            let shift = room.min((a % 200) as u32);
            let expected: BigUint = (big(n) << shift) / d;
            if expected.bits() > 256 {
                continue;
            }
            longest = longest.max(expected.bits());
            assert_eq!(big(divided(n, shift, d)), expected, "{n:?} 2^{shift} / {d}");
        }
        assert!(longest > 250, "{longest}");
    }

    #[test]
    fn extended_quotients_of_long_numbers_have_all_their_bits() {
        // (3 2^120 2^100 - 2^100 2^100 / 2^100) with the shift: 3 2^220 - 2^160.
        let c = I256::product(3 << 120, 1 << 100).unwrap();
        let found = centered_parts(c, [1 << 100, 1 << 100], 60, 1 << 100, 0).unwrap();
        assert_eq!(found, [3.0 * 2f64.powi(220), -(2f64.powi(160)), 0.0]);
        let third = centered_parts(I256::default(), [1, 1], 0, -3, 5).unwrap();
        assert_eq!(third[0], 32.0 / 3.0);
        // 3 (head + tail) is 32, to the last bit of the tail.
        let rest = third[0].mul_add(-3.0, 32.0);
        assert_eq!(third[1], rest / 3.0);
        assert_eq!(centered_parts(c, [i128::MAX, i128::MAX], 10, 1, 0), None);
        assert_eq!(mean_parts(-7, 2, 1), [-7.0, 0.0]);
    }
}
