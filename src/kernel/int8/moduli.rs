//! The moduli, and the constants of the arithmetic modulo them.

/// Pairwise coprime, the largest first: products of residues fit in 15 bits.
const MODULI: [i32; MOST_MODULI] =
    [256, 255, 253, 251, 247, 241, 239, 233, 229, 227, 223, 217, 211, 199, 197];

/// Moduli of the most accurate variant; their product has 118 bits.
pub(crate) const MOST_MODULI: usize = 15;

/// Bits of each part of a number modulo P. Sums of 15 residues times a part stay below 2^52, so that they
/// are exact in f64, and so is what is left of two such sums.
const PART_BITS: u32 = 41;

/// One modulus, and how to reduce to it by dot products of bytes.
///
/// A number is biased to be unsigned; its bytes are digits to the base 256. The dot product of the
/// digits with `256^i mod p`, plus a constant, is congruent to the number and lies in `[0, 2^20)`. A second
/// such product of the three bytes of that brings it to 16 bits, and a Barrett step to 8.
#[derive(Debug, Clone)]
pub(crate) struct Modulus {
    /// 2..=256.
    pub p: i32,
    /// `256^i mod p`, symmetric.
    pub weights: [i8; 8],
    /// Congruent to `-2^63`: takes the bias of a 64-bit number out, and makes the sum positive.
    pub start_64: i32,
    /// The same for `-2^31` and 32-bit numbers.
    pub start_32: i32,
    /// A multiple of p that centres the second sum.
    pub centre: i32,
    /// About 2^22 / p. Less one: then no quotient is wrong (tested exhaustively).
    pub inverse: i16,
}

/// `v mod p` in `[-p/2, p/2)`.
fn symmetric(v: i128, p: i32) -> i32 {
    let r = v.rem_euclid(p.into()) as i32;
    if r > (p - 1) / 2 { r - p } else { r }
}

impl Modulus {
    fn new(p: i32) -> Self {
        let weights: [i32; 8] = std::array::from_fn(|i| symmetric(1 << (8 * i), p));
        let start = |digits: usize, bias: i128| {
            let negative: i32 = weights[..digits].iter().map(|&w| 255 * w.min(0)).sum();
            let residue = (-bias).rem_euclid(p.into()) as i32;
            residue + ((-negative - residue).max(0) + p - 1) / p * p
        };
        let (low, high) = Self::second_range(&weights);
        let middle = (f64::from(low + high) / 2.0 / f64::from(p)).round() as i32;
        Self {
            p,
            weights: weights.map(|w| w as i8),
            start_64: start(8, 1 << 63),
            start_32: start(4, 1 << 31),
            centre: -middle * p,
            inverse: ((f64::from(1 << 22) / f64::from(p)).round() - 1.0) as i16,
        }
    }

    /// The three factors of the second dot product.
    pub fn second_weights(&self) -> [i8; 4] {
        [self.weights[0], self.weights[1], self.weights[2], 0]
    }

    /// Between which numbers the second sum lies, without `centre`; its third byte is at most 3.
    fn second_range(weights: &[i32; 8]) -> (i32, i32) {
        let terms = [255 * weights[0], 255 * weights[1], 3 * weights[2]];
        (terms.iter().map(|t| t.min(&0)).sum(), terms.iter().map(|t| t.max(&0)).sum())
    }
}

/// The first `count` moduli, and the reconstruction of a number from its residues.
///
/// Numbers modulo their product P are kept in three parts of 41 bits each, the highest first, each
/// an f64 that holds it exactly with its weight.
#[derive(Debug, Clone)]
pub(crate) struct Moduli {
    /// In the order of residues.
    pub list: Vec<Modulus>,
    /// For each modulus the number below P that is 1 modulo it and 0 modulo the others.
    pub units: Vec<[f64; 3]>,
    /// P.
    pub product: [f64; 3],
    /// log2 of the unit of each part: all parts of it are multiples.
    pub bottoms: [u32; 3],
    /// 1 / P, rounded.
    pub inverse: f64,
    /// Norms up to this: the product of two is below P/2, with a margin for the rounding of quotients.
    pub largest_norm: f64,
}

impl Moduli {
    /// `count` moduli, 2..=15.
    pub fn new(count: usize) -> Self {
        let list: Vec<Modulus> = MODULI[..count].iter().map(|&p| Modulus::new(p)).collect();
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
            let inverse =
                (1..m.p).find(|i| residue * i % m.p == 1).expect("the moduli are coprime");
            parts(others * inverse as u128)
        };
        Self {
            units: list.iter().map(unit).collect(),
            list,
            product: parts(product),
            bottoms,
            inverse: 1.0 / product as f64,
            largest_norm: (product as f64 / 2.0).sqrt() * (1.0 - 1.0 / f64::from(1 << 20)),
        }
    }

    /// How many.
    pub fn len(&self) -> usize {
        self.list.len()
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

    /// The rounding product of 16-bit numbers, as the instruction does it.
    fn mulhrs(a: i32, b: i32) -> i32 {
        (((a * b + (1 << 14)) >> 15) as i16).into()
    }

    #[test]
    fn every_second_sum_is_reduced_to_a_byte() {
        for m in Moduli::new(MOST_MODULI).list {
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
        for m in Moduli::new(MOST_MODULI).list {
            for (digits, start, bias) in [(8, m.start_64, 1i128 << 63), (4, m.start_32, 1 << 31)] {
                let weights = m.weights[..digits].iter().map(|&w| i32::from(w));
                let low: i32 = start + weights.clone().map(|w| 255 * w.min(0)).sum::<i32>();
                let high: i32 = start + weights.map(|w| 255 * w.max(0)).sum::<i32>();
                assert!(low >= 0 && high < 4 << 16, "p = {}: {low}..{high}", m.p);
                assert_eq!((i128::from(start) + bias).rem_euclid(m.p.into()), 0);
            }
        }
    }

    #[test]
    fn the_parts_of_a_unit_add_up_to_it() {
        for count in 2..=MOST_MODULI {
            let moduli = Moduli::new(count);
            let whole = |parts: &[f64; 3]| parts.iter().map(|&p| p as u128).sum::<u128>();
            let product = whole(&moduli.product);
            assert_eq!(product, MODULI[..count].iter().map(|&p| p as u128).product());
            for (i, unit) in moduli.units.iter().enumerate() {
                for (j, m) in moduli.list.iter().enumerate() {
                    assert_eq!(whole(unit) % m.p as u128, u128::from(i == j));
                }
            }
        }
    }
}
