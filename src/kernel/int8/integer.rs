//! Integers of 128 and 256 bits, which hold exact sums.

use std::fmt::Debug;

use super::moduli::{LIMB_BITS, LIMBS};
use super::tile::{power_of_two, scaled};
use crate::base::Plain;

/// A signed integer of 128 or 256 bits.
pub(crate) trait Integer: Plain + Default + PartialEq + Debug + 'static {
    /// Returns `sum of limbs[i] 2^(40 i)`, which must fit; limbs may be negative. An integer of 128
    /// bits has three limbs, and the others must be zero.
    fn from_limbs(limbs: [i64; LIMBS]) -> Self;

    /// Returns `self + other`, which must fit.
    fn plus(self, other: Self) -> Self;

    /// Returns `-self`, which must fit.
    fn negated(self) -> Self;

    /// Returns `self + other`; `None` if it does not fit.
    fn checked_plus(self, other: Self) -> Option<Self>;

    /// Returns `self 2^bits`; `None` if its magnitude does not fit 127 or 255 bits.
    fn shifted_left(self, bits: u32) -> Option<Self>;

    /// Returns `a b`; `None` if it does not fit.
    fn product(a: i128, b: i128) -> Option<Self>;

    /// Returns the nearest f64 (ties to even).
    fn to_f64(self) -> f64;
}

impl Integer for i128 {
    #[inline(always)]
    fn from_limbs(limbs: [i64; LIMBS]) -> Self {
        let limb = |i: usize| Self::from(limbs[i]) << (LIMB_BITS as usize * i);
        limb(0).wrapping_add(limb(1)).wrapping_add(limb(2))
    }

    #[inline(always)]
    fn plus(self, other: Self) -> Self {
        // Sums from a damaged file may not fit.
        self.wrapping_add(other)
    }

    #[inline(always)]
    fn negated(self) -> Self {
        self.wrapping_neg()
    }

    fn checked_plus(self, other: Self) -> Option<Self> {
        self.checked_add(other)
    }

    fn shifted_left(self, bits: u32) -> Option<Self> {
        if self == 0 {
            return Some(0);
        }
        (self.unsigned_abs().leading_zeros() > bits).then(|| self << bits)
    }

    fn product(a: i128, b: i128) -> Option<Self> {
        a.checked_mul(b)
    }

    fn to_f64(self) -> f64 {
        self as f64
    }
}

/// An integer from 0 to 2^256 - 1: `high 2^128 + low`.
#[derive(Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Debug)]
pub(crate) struct U256 {
    pub high: u128,
    pub low: u128,
}

impl U256 {
    /// Returns `a b`.
    pub fn product(a: u128, b: u128) -> Self {
        const HALF: u128 = u64::MAX as u128;
        let [a0, a1, b0, b1] = [a & HALF, a >> 64, b & HALF, b >> 64];
        let (low, cross, other, high) = (a0 * b0, a0 * b1, a1 * b0, a1 * b1);
        let middle = (low >> 64) + (cross & HALF) + (other & HALF);
        Self {
            high: high + (cross >> 64) + (other >> 64) + (middle >> 64),
            low: low & HALF | middle << 64,
        }
    }

    /// Returns the number of leading zero bits.
    #[inline(always)]
    pub fn leading_zeros(self) -> u32 {
        match self.high {
            0 => u128::BITS + self.low.leading_zeros(),
            high => high.leading_zeros(),
        }
    }

    /// Shifts left by `bits`, below 256, and drops the bits shifted out.
    #[inline(always)]
    pub fn shifted(self, bits: u32) -> Self {
        match bits {
            0 => self,
            128.. => Self { high: self.low << (bits - 128), low: 0 },
            _ => Self { high: self.high << bits | self.low >> (128 - bits), low: self.low << bits },
        }
    }

    /// Returns `self + other`; `None` if it does not fit.
    pub fn checked_plus(self, other: Self) -> Option<Self> {
        let (low, carry) = self.low.overflowing_add(other.low);
        let high = self.high.checked_add(other.high)?.checked_add(carry.into())?;
        Some(Self { high, low })
    }

    /// Returns `self - other`, for an `other` that is no larger.
    pub fn minus(self, other: Self) -> Self {
        let (low, borrow) = self.low.overflowing_sub(other.low);
        Self { high: self.high - other.high - u128::from(borrow), low }
    }
}

/// A signed integer of 256 bits, in two's complement: `high 2^128 + low`.
#[derive(Clone, Copy, Default, PartialEq, Eq, Debug)]
pub(crate) struct I256 {
    pub high: i128,
    pub low: u128,
}

// SAFETY: two integers of 128 bits, valid for any bits, without padding.
unsafe impl Plain for I256 {}

impl I256 {
    /// Returns whether the number is below zero.
    pub fn is_negative(self) -> bool {
        self.high < 0
    }

    /// Returns `|self|`; the least number, -2^255, stays negative.
    pub fn magnitude(self) -> Self {
        if self.is_negative() { self.negated() } else { self }
    }

    /// Returns the number of these bits in two's complement.
    #[inline(always)]
    pub fn of_bits(bits: U256) -> Self {
        Self { high: bits.high as i128, low: bits.low }
    }

    #[inline(always)]
    fn bits(self) -> U256 {
        U256 { high: self.high as u128, low: self.low }
    }

    /// Returns the number of leading zero bits.
    #[inline(always)]
    pub fn leading_zeros(self) -> u32 {
        self.bits().leading_zeros()
    }

    /// Shifts left by `bits`, below 256, and drops the bits shifted out.
    #[inline(always)]
    fn shl(self, bits: u32) -> Self {
        Self::of_bits(self.bits().shifted(bits))
    }

    /// Returns `value 2^bits`, for at most 127 bits.
    #[inline(always)]
    pub fn of_shifted(value: i128, bits: u32) -> Self {
        Self { high: value >> (i128::BITS - 1), low: value as u128 }.shl(bits)
    }

    /// Converts an f64 that is an integer below 2^255 in magnitude, or -2^255.
    fn from_f64(value: f64) -> Self {
        let exponent = ((value.to_bits() >> 52) & 0x7ff) as i32 - 1075;
        let magnitude = if exponent <= 0 {
            Self { high: 0, low: value.abs() as u128 }
        } else {
            let mantissa = u128::from(value.to_bits() & ((1 << 52) - 1) | 1 << 52);
            Self { high: 0, low: mantissa }.shl(exponent as u32)
        };
        if value < 0.0 { magnitude.negated() } else { magnitude }
    }

    /// Returns `self 2^exponent` as a sum of three f64, each the f64 nearest to the rest after
    /// those before it, rounded once more where it is subnormal.
    #[inline(always)]
    pub fn parts(self, exponent: i32) -> [f64; 3] {
        let parts = self.summed_parts().unwrap_or_else(|| self.rounded_parts());
        parts.map(|part| scaled(part, exponent))
    }

    /// Computes the three parts of `self` with integers.
    #[cold]
    fn rounded_parts(self) -> [f64; 3] {
        let mut rest = self;
        [(); 3].map(|()| {
            let part = rest.to_f64();
            rest = rest.plus(Self::from_f64(part).negated());
            part
        })
    }

    /// Computes the three parts with sums in f64, several times as fast; `None` when one of them is
    /// near a tie, which such sums break without regard to the lowest bits.
    #[inline(always)]
    fn summed_parts(self) -> Option<[f64; 3]> {
        const PIECES: usize = 8;
        let Self { high, low } = self.magnitude();
        let words = [(high as u128 >> 64) as u64, high as u64, (low >> 64) as u64, low as u64];
        // Terms of 32 bits each that do not overlap, the highest first.
        let mut terms: [f64; PIECES] = std::array::from_fn(|k| {
            let half = (words[k / 2] >> (32 * (1 - k % 2))) as u32;
            f64::from(half) * power_of_two(32 * (PIECES - 1 - k) as i32)
        });
        // A sum from the last term to the first is a part, and its errors are the terms of the next
        // part: each term is zero, or no smaller than the sum of those after it.
        let parts: [f64; 4] = std::array::from_fn(|part| {
            let count = PIECES - part;
            let mut sum = terms[count - 1];
            for k in (0..count - 1).rev() {
                let total = terms[k] + sum;
                terms[k] = sum - (total - terms[k]);
                sum = total;
            }
            sum
        });
        /// A little more than 1.
        const MORE: f64 = 1.0 + 1.0 / (1 << 30) as f64;
        let apart = parts.windows(2).all(|pair| pair[0] + MORE * pair[1] == pair[0]);
        let sign = if self.is_negative() { -1.0 } else { 1.0 };
        apart.then(|| [0, 1, 2].map(|part| sign * parts[part]))
    }
}

impl Integer for I256 {
    #[inline(always)]
    fn from_limbs(limbs: [i64; LIMBS]) -> Self {
        let pair = |i: usize| i128::from(limbs[i]) + (i128::from(limbs[i + 1]) << LIMB_BITS);
        let [low, middle, high] = [pair(0), pair(2), pair(4)];
        let low = Self { high: low >> 127, low: low as u128 };
        let middle = Self { high: middle >> 48, low: (middle as u128) << 80 };
        let high = Self { high: high << 32, low: 0 };
        low.plus(middle).plus(high)
    }

    #[inline(always)]
    fn plus(self, other: Self) -> Self {
        let (low, carry) = self.low.overflowing_add(other.low);
        Self { high: self.high.wrapping_add(other.high).wrapping_add(carry.into()), low }
    }

    #[inline(always)]
    fn negated(self) -> Self {
        let (low, carry) = (!self.low).overflowing_add(1);
        Self { high: (!self.high).wrapping_add(carry.into()), low }
    }

    fn checked_plus(self, other: Self) -> Option<Self> {
        let sum = self.plus(other);
        let overflow =
            self.is_negative() == other.is_negative() && sum.is_negative() != self.is_negative();
        (!overflow).then_some(sum)
    }

    fn shifted_left(self, bits: u32) -> Option<Self> {
        if self == Self::default() {
            return Some(self);
        }
        let magnitude = self.magnitude();
        let shifted = (magnitude.leading_zeros() > bits).then(|| magnitude.shl(bits))?;
        Some(if self.is_negative() { shifted.negated() } else { shifted })
    }

    fn product(a: i128, b: i128) -> Option<Self> {
        // No overflow: both magnitudes are at most 2^127.
        let magnitude = Self::of_bits(U256::product(a.unsigned_abs(), b.unsigned_abs()));
        Some(if (a < 0) != (b < 0) { magnitude.negated() } else { magnitude })
    }

    fn to_f64(self) -> f64 {
        if self == Self::default() {
            return 0.0;
        }
        let magnitude = self.magnitude();
        let zeros = magnitude.leading_zeros();
        let top = magnitude.shl(zeros);
        // The top 64 bits, of which the last one is set if any bit below is (sticky).
        let rest = (top.high as u128) << 64 != 0 || top.low != 0;
        let bits = ((top.high as u128) >> 64) as u64 | u64::from(rest);
        let value = scaled(bits as f64, 192 - zeros as i32);
        if self.is_negative() { -value } else { value }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::base::Rng;

    /// Returns a random number of at most `bits` bits and a sign.
    fn number(rng: &mut Rng, bits: u32) -> i128 {
        let random = (u128::from(rng.bits()) << 64 | u128::from(rng.bits())) >> 1;
        let size = (random >> (127 - bits)) as i128 >> (rng.bits() % u64::from(bits));
        if rng.bits().is_multiple_of(2) { size } else { -size }
    }

    fn wide(value: i128) -> I256 {
        I256 { high: value >> 127, low: value as u128 }
    }

    #[test]
    fn integers_of_256_bits_do_what_those_of_128_do() {
        let mut rng = Rng::new(1);
        for _ in 0..10_000 {
            let (a, b) = (number(&mut rng, 126), number(&mut rng, 126));
            assert_eq!(wide(a).plus(wide(b)), wide(a + b));
            assert_eq!(wide(a).negated(), wide(-a));
            assert_eq!(wide(a).to_f64(), a as f64);
            let (c, d) = (number(&mut rng, 63), number(&mut rng, 63));
            assert_eq!(I256::product(c, d), Some(wide(c * d)));
            let bits = (rng.bits() % 60) as u32;
            assert_eq!(wide(c).shifted_left(bits), Some(wide(c << bits)));
            assert_eq!(I256::of_shifted(c, bits), wide(c << bits));
            let limbs = [c, d, a >> 90].map(|v| (v >> 12) as i64);
            let limbs = [limbs[0], limbs[1], limbs[2], 0, 0, 0];
            assert_eq!(I256::from_limbs(limbs), wide(i128::from_limbs(limbs)));
        }
    }

    #[test]
    fn products_without_a_sign_have_all_their_bits() {
        let most = U256::product(u128::MAX, u128::MAX);
        assert_eq!(most, U256 { high: u128::MAX - 1, low: 1 });
        assert_eq!(U256::product(1 << 127, 6), U256 { high: 3, low: 0 });
        assert_eq!((most.leading_zeros(), U256 { high: 0, low: 1 }.leading_zeros()), (0, 255));
        let sum = most.checked_plus(U256 { high: 1, low: u128::MAX - 1 });
        assert_eq!(sum, Some(U256 { high: u128::MAX, low: u128::MAX }));
        assert_eq!(sum.and_then(|sum| sum.checked_plus(U256 { high: 0, low: 1 })), None);
        assert_eq!(sum.map(|sum| sum.minus(most)), Some(U256 { high: 1, low: u128::MAX - 1 }));
    }

    #[test]
    fn products_of_sums_follow_the_distributive_law() {
        let mut rng = Rng::new(2);
        for _ in 0..10_000 {
            let [a, b, c] = [(); 3].map(|()| number(&mut rng, 126));
            let split = I256::product(a, c).unwrap().plus(I256::product(b, c).unwrap());
            assert_eq!(I256::product(a + b, c), Some(split));
        }
    }

    #[test]
    fn what_does_not_fit_is_refused() {
        let top = wide(1).shifted_left(254).unwrap();
        assert_eq!(top.checked_plus(top), None);
        assert_eq!(top.negated().checked_plus(top.negated()).map(|v| v.is_negative()), Some(true));
        assert_eq!(top.shifted_left(1), None);
        assert_eq!(wide(0).shifted_left(300), Some(wide(0)));
        assert_eq!((1_i128 << 100).shifted_left(27), None);
        assert_eq!(i128::product(1 << 100, 1 << 30), None);
    }

    #[test]
    fn three_parts_add_up_to_the_integer() {
        let mut rng = Rng::new(3);
        for _ in 0..10_000 {
            let (a, b) = (number(&mut rng, 80), number(&mut rng, 78));
            let value = I256::product(a, b).unwrap();
            if let Some(parts) = value.summed_parts() {
                assert_eq!(parts, value.rounded_parts(), "{value:?}");
            }
            let parts = value.parts(0);
            let sum = parts.map(I256::from_f64).into_iter().reduce(I256::plus).unwrap();
            assert_eq!(sum, value);
            for i in 0..2 {
                assert_eq!(parts[i] + parts[i + 1], parts[i]);
            }
            assert_eq!(parts[0], value.to_f64());
        }
    }

    #[test]
    fn ties_of_parts_are_broken_by_what_is_far_below() {
        // Sums of a few powers of two: many are ties, of one part or the next.
        let mut rng = Rng::new(4);
        let mut short = 0;
        for _ in 0..100_000 {
            let mut value = I256::default();
            let mut bits = (rng.bits() % 250) as u32;
            for _ in 0..5 {
                let power = wide(1).shifted_left(bits).unwrap();
                value =
                    value.plus(if rng.bits().is_multiple_of(2) { power } else { power.negated() });
                bits = bits.saturating_sub(51 + (rng.bits() % 5) as u32);
            }
            let expected = value.rounded_parts();
            assert_eq!(value.parts(0), expected, "{value:?}");
            if let Some(parts) = value.summed_parts() {
                assert_eq!(parts, expected, "{value:?}");
                short += 1;
            }
        }
        assert!((10_000..90_000).contains(&short), "{short}");
        assert_eq!(I256::default().summed_parts(), Some([0.0; 3]));
        let least = I256 { high: i128::MIN, low: 0 };
        assert_eq!(least.plus(wide(1)).parts(0), [-(255f64.exp2()), 1.0, 0.0]);
    }
}
