//! From residues back to numbers: the Chinese remainder theorem in exact f64 arithmetic.

use super::moduli::Moduli;
use super::tile::{Quarter, WIDTH, power_of_two};

/// A quarter of a block of C from its residues: for row i and column j the integer R of least magnitude, of
/// which |R| < P/2 is known by less than one part in 2^20, times `2^(rows[i] + columns[j])`.
///
/// `V = sum residue * unit` is congruent to R; so `R = V - round(V / P) P`. Each of the three parts of
/// the sum and of the product has fewer than 53 bits, so that they and their differences are exact,
/// with fused multiplications or without (`FUSED`); one rounding follows, and a second one where the
/// result is subnormal.
#[inline(always)]
pub(super) fn quarter<const FUSED: bool>(
    residues: &[&Quarter<i8>],
    moduli: &Moduli,
    rows: &[i32; WIDTH],
    columns: &[i32; WIDTH],
    out: &mut Quarter<f64>,
) {
    for (i, out) in out.iter_mut().enumerate() {
        let mut high = [0.0; WIDTH];
        let mut middle = [0.0; WIDTH];
        let mut low = [0.0; WIDTH];
        for (unit, residues) in moduli.units.iter().zip(residues) {
            for j in 0..WIDTH {
                let r = f64::from(residues[i][j]);
                high[j] = multiply_add::<FUSED>(r, unit[0], high[j]);
                middle[j] = multiply_add::<FUSED>(r, unit[1], middle[j]);
                low[j] = multiply_add::<FUSED>(r, unit[2], low[j]);
            }
        }
        for j in 0..WIDTH {
            let quotient = -((high[j] + middle[j]) * moduli.inverse).round_ties_even();
            let high = multiply_add::<FUSED>(quotient, moduli.product[0], high[j]);
            let middle = multiply_add::<FUSED>(quotient, moduli.product[1], middle[j]);
            let low = multiply_add::<FUSED>(quotient, moduli.product[2], low[j]);
            let (tail, tail_error) = two_sum(middle, low);
            let (head, head_error) = two_sum(high, tail);
            let value = head + (head_error + tail_error);
            // Two factors: one may be no finite number. Below -1300 every value vanishes.
            let exponent = (rows[i] + columns[j]).clamp(-1300, 2040);
            let (first, second) = (exponent >> 1, exponent - (exponent >> 1));
            out[j] = value * power_of_two(first) * power_of_two(second);
        }
    }
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
