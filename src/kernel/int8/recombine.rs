//! From residues back to numbers: the Chinese remainder theorem in exact f64 arithmetic.

use super::moduli::Moduli;
use super::tile::{Quarter, WIDTH, power_of_two};

/// The integers R of least magnitude, of which |R| < P/2 is known by less than one part in 2^20,
/// with these residues. All arithmetic is exact, as in [`quarter`].
pub(crate) fn integers(residues: &[&Quarter<i8>], moduli: &Moduli, out: &mut Quarter<i128>) {
    let units = moduli.bottoms.map(|bottom| power_of_two(-(bottom as i32)));
    // Dispatched once, so that the loops inside use the widest registers there are.
    pulp::Arch::new().dispatch(
        #[inline(always)]
        || {
            for (i, out) in out.iter_mut().enumerate() {
                let parts = row::<false>(residues, moduli, i);
                // In units of their own the parts are below 2^53.
                let parts: [[i64; WIDTH]; 3] =
                    std::array::from_fn(|p| parts[p].map(|part| (part * units[p]) as i64));
                for (j, out) in out.iter_mut().enumerate() {
                    *out = (0..3).map(|p| i128::from(parts[p][j]) << moduli.bottoms[p]).sum();
                }
            }
        },
    );
}

/// The three parts of the integers of row `i` of a quarter.
///
/// `V = sum residue * unit` is congruent to R; so `R = V - round(V / P) P`. Each of the three parts of
/// the sum and of the product has fewer than 53 bits, so that they and their differences are exact,
/// with fused multiplications or without (`FUSED`).
#[inline(always)]
fn row<const FUSED: bool>(
    residues: &[&Quarter<i8>],
    moduli: &Moduli,
    i: usize,
) -> [[f64; WIDTH]; 3] {
    let mut parts = [[0.0; WIDTH]; 3];
    for (unit, residues) in moduli.units.iter().zip(residues) {
        for j in 0..WIDTH {
            let r = f64::from(residues[i][j]);
            for (part, &unit) in parts.iter_mut().zip(unit) {
                part[j] = multiply_add::<FUSED>(r, unit, part[j]);
            }
        }
    }
    for j in 0..WIDTH {
        let quotient = -((parts[0][j] + parts[1][j]) * moduli.inverse).round_ties_even();
        for (part, &product) in parts.iter_mut().zip(&moduli.product) {
            part[j] = multiply_add::<FUSED>(quotient, product, part[j]);
        }
    }
    parts
}

/// A quarter of a block of C from its residues: for row i and column j the integer of [`integers`]
/// times `2^(rows[i] + columns[j])`, rounded once, and a second time where the result is subnormal.
#[inline(always)]
pub(super) fn quarter<const FUSED: bool>(
    residues: &[&Quarter<i8>],
    moduli: &Moduli,
    rows: &[i32; WIDTH],
    columns: &[i32; WIDTH],
    out: &mut Quarter<f64>,
) {
    for (i, out) in out.iter_mut().enumerate() {
        let [high, middle, low] = row::<FUSED>(residues, moduli, i);
        for j in 0..WIDTH {
            let (tail, tail_error) = two_sum(middle[j], low[j]);
            let (head, head_error) = two_sum(high[j], tail);
            let value = head + (head_error + tail_error);
            out[j] = scaled(value, rows[i] + columns[j]);
        }
    }
}

/// `value 2^exponent`, for a value that is no more than P: rounded where it is subnormal.
#[inline(always)]
pub(crate) fn scaled(value: f64, exponent: i32) -> f64 {
    // Two factors: one may be no finite number. Below -1300 every value vanishes.
    let exponent = exponent.clamp(-1300, 2040);
    let (first, second) = (exponent >> 1, exponent - (exponent >> 1));
    value * power_of_two(first) * power_of_two(second)
}

#[inline(always)]
fn multiply_add<const FUSED: bool>(x: f64, y: f64, z: f64) -> f64 {
    if FUSED { x.mul_add(y, z) } else { x * y + z }
}

/// `x + y`, and what rounding took from it (Knuth 1969).
#[inline(always)]
fn two_sum(x: f64, y: f64) -> (f64, f64) {
    let sum = x + y;
    let part = sum - x;
    (sum, (x - (sum - part)) + (y - part))
}
