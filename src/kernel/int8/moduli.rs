//! The moduli, and the constants of the arithmetic modulo them.

use std::sync::OnceLock;

/// The moduli, pairwise coprime, the largest first: products of residues are at most 2^14 in
/// magnitude. Below 128 the [`Modulus::inverse`] would not fit 16 bits.
const MODULI: [i32; MOST_MODULI] = [
    256, 255, 253, 251, 247, 241, 239, 233, 229, 227, 223, 217, 211, 199, 197, 193, 191, 181, 179,
    173, 167, 163, 157, 151, 149, 139, 137, 131,
];

/// Number of moduli of the longest integers; their product has 214 bits.
pub(crate) const MOST_MODULI: usize = 28;

/// Number of moduli of the most accurate results in f64; their product has 118 bits.
const MOST_FLOAT_MODULI: usize = 15;

/// Bits of each part of a number modulo P. Sums of 15 residues times a part stay below 2^52, so
/// that they and their differences are exact in f64.
const PART_BITS: u32 = 41;

/// Bits of the lower word of a wide number, which is signed; the higher word has 32.
pub(super) const WORD_BITS: u32 = 50;

/// log2 of the largest magnitude of a wide number.
pub(crate) const WIDE_BITS: i32 = 80;

/// Bits of a limb. Sums of 28 residues times a limb stay below 2^52, so that they and their
/// differences are exact in f64.
pub(super) const LIMB_BITS: u32 = 40;

/// Number of limbs of the product of all moduli.
pub(super) const LIMBS: usize = 6;

/// One modulus, and how to reduce to it by dot products of bytes.
///
/// A number is biased to be unsigned; its bytes are digits to the base 256. The dot product of the
/// digits with `256^i mod p`, plus a constant, is congruent to the number and lies in `[0, 2^19)`.
/// A second such product, of the three bytes of the first, fits 16 bits, and a Barrett step
/// reduces it to 8.
#[derive(Debug, Clone)]
pub(crate) struct Modulus {
    /// The modulus, 131..=256.
    pub p: i32,
    /// `256^i mod p`, symmetric.
    pub weights: [i8; 8],
    /// `2^WORD_BITS 256^i mod p`, symmetric, for the higher word of a wide number.
    pub high_weights: [i8; 4],
    /// Congruent to `-2^63`: removes the bias of a 64-bit number, and makes the sum non-negative.
    pub start_64: i32,
    /// Congruent to `-2^31`, for 32-bit numbers.
    pub start_32: i32,
    /// Congruent to `-2^63 - 2^(WORD_BITS + 31)`, for numbers of two words.
    pub start_wide: i32,
    /// A multiple of p that centres the second sum about zero.
    pub centre: i32,
    /// 2^22 / p, rounded, less one: then every residue fits 8 bits (tested exhaustively).
    pub inverse: i16,
}

/// Returns `v mod p` in `[-p/2, p/2)`.
fn symmetric(v: i128, p: i32) -> i32 {
    let r = v.rem_euclid(p.into()) as i32;
    if r > (p - 1) / 2 { r - p } else { r }
}

impl Modulus {
    fn new(p: i32) -> Self {
        let weights: [i32; 8] = std::array::from_fn(|i| symmetric(1 << (8 * i), p));
        let high_weights: [i32; 4] =
            std::array::from_fn(|i| symmetric(1 << (WORD_BITS as usize + 8 * i), p));
        let negative = |weights: &[i32]| weights.iter().map(|&w| 255 * w.min(0)).sum::<i32>();
        let start = |negative: i32, bias: i128| {
            let residue = (-bias).rem_euclid(p.into()) as i32;
            residue + ((-negative - residue).max(0) + p - 1) / p * p
        };
        let (low, high) = Self::second_range(&weights);
        let middle = (f64::from(low + high) / 2.0 / f64::from(p)).round() as i32;
        Self {
            p,
            weights: weights.map(|w| w as i8),
            high_weights: high_weights.map(|w| w as i8),
            start_64: start(negative(&weights), 1 << 63),
            start_32: start(negative(&weights[..4]), 1 << 31),
            start_wide: start(
                negative(&weights) + negative(&high_weights),
                (1 << 63) + (1 << (WORD_BITS + 31)),
            ),
            centre: -middle * p,
            inverse: ((f64::from(1 << 22) / f64::from(p)).round() - 1.0) as i16,
        }
    }

    /// Returns the three weights of the second dot product, and a zero.
    pub fn second_weights(&self) -> [i8; 4] {
        [self.weights[0], self.weights[1], self.weights[2], 0]
    }

    /// Returns the least and the largest second sum, without `centre`; the third byte of the first
    /// sum is at most 7.
    fn second_range(weights: &[i32; 8]) -> (i32, i32) {
        let terms = [255 * weights[0], 255 * weights[1], 7 * weights[2]];
        (terms.iter().map(|t| t.min(&0)).sum(), terms.iter().map(|t| t.max(&0)).sum())
    }
}

/// The first `count` moduli, and the reconstruction of a number from its residues.
///
/// Numbers modulo their product P are kept in three parts of 41 bits each, the highest first, each
/// an f64 that holds it exactly with its weight.
#[derive(Debug, Clone)]
pub(crate) struct Moduli {
    /// The moduli, in the order of residues.
    pub list: Vec<Modulus>,
    /// For each modulus the number below P that is 1 modulo this one and 0 modulo the others.
    pub units: Vec<[f64; 3]>,
    /// P.
    pub product: [f64; 3],
    /// Number of parts of P and of the numbers below it; the others are zero.
    pub parts: usize,
    /// 1 / P, rounded.
    pub inverse: f64,
    /// The largest norm of a column: the product of two such norms is below P/2, with a margin for
    /// the rounding of quotients.
    pub largest_norm: f64,
}

/// Returns the first `count` moduli.
fn first(count: usize) -> Vec<Modulus> {
    MODULI[..count].iter().map(|&p| Modulus::new(p)).collect()
}

/// Returns the inverse of `residue` modulo p.
fn inverse(residue: i32, p: i32) -> i32 {
    (1..p).find(|i| residue * i % p == 1).expect("the moduli are coprime")
}

impl Moduli {
    /// Returns the reconstruction from residues modulo the first `count` moduli,
    /// 2..=[`MOST_FLOAT_MODULI`]. It is computed once: that takes longer than a small product.
    pub fn of(count: usize) -> &'static Self {
        static KNOWN: [OnceLock<Moduli>; MOST_FLOAT_MODULI + 1] =
            [const { OnceLock::new() }; MOST_FLOAT_MODULI + 1];
        KNOWN[count].get_or_init(|| Self::new(count))
    }

    /// Creates the reconstruction from residues modulo the first `count` moduli, 2..=15.
    fn new(count: usize) -> Self {
        let list = first(count);
        let product: u128 = list.iter().map(|m| m.p as u128).product();
        let bits = u128::BITS - product.leading_zeros();
        let top = |i: u32| bits.saturating_sub(i * PART_BITS);
        let bottoms = [1, 2, 3].map(top);
        let parts = |v: u128| -> [f64; 3] {
            std::array::from_fn(|i| {
                let below = v & ((1 << top(i as u32)) - 1);
                (below >> bottoms[i] << bottoms[i]) as f64
            })
        };
        let unit = |m: &Modulus| {
            let others = product / m.p as u128;
            let residue = (others % m.p as u128) as i32;
            parts(others * inverse(residue, m.p) as u128)
        };
        Self {
            units: list.iter().map(unit).collect(),
            list,
            product: parts(product),
            parts: bits.div_ceil(PART_BITS) as usize,
            inverse: 1.0 / product as f64,
            largest_norm: (product as f64 / 2.0).sqrt() * (1.0 - 1.0 / f64::from(1 << 20)),
        }
    }
}

/// The first `count` moduli, and the reconstruction of an integer from its residues.
///
/// Integers below the product P are kept in limbs of 40 bits, the lowest first.
#[derive(Debug, Clone)]
pub(crate) struct IntegerModuli {
    /// The moduli, in the order of residues.
    pub list: Vec<Modulus>,
    /// For each modulus the number below P that is 1 modulo this one and 0 modulo the others.
    pub units: Vec<[f64; LIMBS]>,
    /// P.
    pub product: [f64; LIMBS],
    /// The weight `2^(40 i)` of each limb divided by P, rounded.
    pub inverses: [f64; LIMBS],
    /// Number of limbs of P.
    pub limbs: usize,
}

/// An integer of 240 bits: limbs of 40 bits, the lowest first.
#[derive(Clone, Copy)]
struct Limbs([u64; LIMBS]);

impl Limbs {
    fn product(factors: impl Iterator<Item = i32>) -> Self {
        let mut one = Self([0; LIMBS]);
        one.0[0] = 1;
        factors.fold(one, |product, factor| product.times(factor))
    }

    fn times(mut self, factor: i32) -> Self {
        let mut carry = 0;
        for limb in &mut self.0 {
            carry += *limb * factor as u64;
            *limb = carry & ((1 << LIMB_BITS) - 1);
            carry >>= LIMB_BITS;
        }
        debug_assert_eq!(carry, 0);
        self
    }

    fn modulo(self, p: i32) -> i32 {
        let down = self.0.iter().rev();
        down.fold(0, |rest, limb| ((rest << LIMB_BITS) + limb) % p as u64) as i32
    }

    fn to_f64(self) -> [f64; LIMBS] {
        self.0.map(|limb| limb as f64)
    }
}

impl IntegerModuli {
    /// Creates the reconstruction from residues modulo the first `count` moduli,
    /// 2..=[`MOST_MODULI`].
    pub fn new(count: usize) -> Self {
        let list = first(count);
        let product = Limbs::product(list.iter().map(|m| m.p));
        let unit = |m: &Modulus| {
            let others = Limbs::product(list.iter().map(|m| m.p).filter(|&p| p != m.p));
            others.times(inverse(others.modulo(m.p), m.p)).to_f64()
        };
        let limbs = LIMBS - product.0.iter().rev().take_while(|&&limb| limb == 0).count();
        let size = 2f64.powf(Self::bits(count));
        Self {
            units: list.iter().map(unit).collect(),
            list,
            product: product.to_f64(),
            inverses: std::array::from_fn(|i| f64::from(LIMB_BITS * i as u32).exp2() / size),
            limbs,
        }
    }

    /// Returns log2 of P for `count` moduli.
    pub fn bits(count: usize) -> f64 {
        MODULI[..count].iter().map(|&p| f64::from(p).log2()).sum()
    }

    /// Returns the least number of moduli, 2 or more, for integers of magnitudes up to `2^bits`;
    /// `None` when all moduli together are not enough.
    pub fn count_for(bits: i32) -> Option<usize> {
        // One bit for the sign, and a margin for the rounding of quotients.
        (2..=MOST_MODULI).find(|&count| Self::bits(count) >= f64::from(bits) + 1.01)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn gcd(a: i32, b: i32) -> i32 {
        if b == 0 { a } else { gcd(b, a % b) }
    }

    #[test]
    fn the_moduli_are_pairwise_coprime() {
        for (i, &a) in MODULI.iter().enumerate() {
            assert!(MODULI[..i].iter().all(|&b| gcd(a, b) == 1), "{a}");
        }
    }

    /// Returns the rounding product of 16-bit numbers, as `vpmulhrsw` does.
    fn mulhrs(a: i32, b: i32) -> i32 {
        (((a * b + (1 << 14)) >> 15) as i16).into()
    }

    #[test]
    fn every_second_sum_is_reduced_to_a_byte() {
        for m in first(MOST_MODULI) {
            let (low, high) = Modulus::second_range(&m.weights.map(i32::from));
            for t in low + m.centre..=high + m.centre {
                assert!(i16::try_from(t).is_ok(), "p = {}: {t}", m.p);
                let quotient = mulhrs(mulhrs(t, m.inverse.into()), 256);
                let residue = t - quotient * m.p;
                assert!((-128..128).contains(&residue), "p = {}: {t} to {residue}", m.p);
            }
        }
    }

    #[test]
    fn the_first_sums_are_in_range_and_lose_the_bias() {
        for m in first(MOST_MODULI) {
            let both = [&m.weights[..], &m.high_weights].concat();
            let wide_bias = (1 << 63) + (1 << (WORD_BITS + 31));
            for (weights, start, bias) in [
                (&m.weights[..], m.start_64, 1i128 << 63),
                (&m.weights[..4], m.start_32, 1 << 31),
                (&both, m.start_wide, wide_bias),
            ] {
                let weights = weights.iter().map(|&w| i32::from(w));
                let low: i32 = start + weights.clone().map(|w| 255 * w.min(0)).sum::<i32>();
                let high: i32 = start + weights.map(|w| 255 * w.max(0)).sum::<i32>();
                assert!(low >= 0 && high < 8 << 16, "p = {}: {low}..{high}", m.p);
                assert_eq!((i128::from(start) + bias).rem_euclid(m.p.into()), 0);
            }
        }
    }

    #[test]
    fn the_parts_of_a_unit_add_up_to_it() {
        for count in 2..=MOST_FLOAT_MODULI {
            let moduli = Moduli::new(count);
            let whole = |parts: &[f64; 3]| parts.iter().map(|&p| p as u128).sum::<u128>();
            let product = whole(&moduli.product);
            assert_eq!(product, MODULI[..count].iter().map(|&p| p as u128).product());
            for (i, unit) in moduli.units.iter().enumerate() {
                assert_eq!(unit[moduli.parts..], [0.0; 3][moduli.parts..], "{count} moduli");
                for (j, m) in moduli.list.iter().enumerate() {
                    assert_eq!(whole(unit) % m.p as u128, u128::from(i == j));
                }
            }
        }
    }

    #[test]
    fn the_limbs_of_a_unit_are_one_modulo_its_modulus_and_zero_modulo_the_others() {
        for count in [2, 3, 5, 6, 15, 23, MOST_MODULI] {
            let moduli = IntegerModuli::new(count);
            for (i, unit) in moduli.units.iter().enumerate() {
                let unit = Limbs(unit.map(|limb| limb as u64));
                for (j, m) in moduli.list.iter().enumerate() {
                    assert_eq!(unit.modulo(m.p), i32::from(i == j));
                }
                // Below P: the highest limb that differs is smaller.
                let mut limbs = unit.to_f64().into_iter().zip(moduli.product).rev();
                assert!(limbs.find(|(a, b)| a != b).is_some_and(|(a, b)| a < b));
            }
        }
    }
}
