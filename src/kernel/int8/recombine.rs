//! Reconstructs numbers from residues: the Chinese remainder theorem in exact f64 arithmetic.

use super::integer::Integer;
use super::kernel::Recombination;
use super::moduli::{IntegerModuli, LIMBS, Moduli};
use super::rounding::nearest;
use super::tile::{PanelBlock, Quarter, Square, WIDTH, scaled};
use crate::base::widest;

/// Computes exactly the integers R with these residues, for |R| at most P/2 less one part in 2^20,
/// a margin for the rounding of quotients.
pub(crate) fn integers<I: Integer>(
    residues: &[&Quarter<i8>],
    moduli: &IntegerModuli,
    out: &mut Quarter<I>,
) {
    widest(
        #[inline(always)]
        || match moduli.limbs {
            ..=3 => integers_of::<I, 3>(residues, moduli, out),
            4 => integers_of::<I, 4>(residues, moduli, out),
            5 => integers_of::<I, 5>(residues, moduli, out),
            _ => integers_of::<I, LIMBS>(residues, moduli, out),
        },
    );
}

/// Does [`integers`] with L limbs: `V = sum residue * unit` is congruent to R, so
/// `R = V - round(V / P) P`, limb by limb.
#[inline(always)]
fn integers_of<I: Integer, const L: usize>(
    residues: &[&Quarter<i8>],
    moduli: &IntegerModuli,
    out: &mut Quarter<I>,
) {
    for (i, out) in out.iter_mut().enumerate() {
        let mut limbs = [[0.0; WIDTH]; L];
        for (unit, residues) in moduli.units.iter().zip(residues) {
            for j in 0..WIDTH {
                let r = f64::from(residues[i][j]);
                for (limb, &unit) in limbs.iter_mut().zip(unit) {
                    limb[j] += r * unit;
                }
            }
        }
        for j in 0..WIDTH {
            let terms =
                limbs.iter().zip(&moduli.inverses).map(|(limb, &inverse)| limb[j] * inverse);
            let quotient = terms.sum::<f64>().round_ties_even();
            for (limb, &product) in limbs.iter_mut().zip(&moduli.product) {
                limb[j] -= quotient * product;
            }
        }
        let limbs = limbs.map(|limb| limb.map(|limb| limb as i64));
        for (j, out) in out.iter_mut().enumerate() {
            let mut all = [0; LIMBS];
            all.iter_mut().zip(&limbs).for_each(|(all, limb)| *all = limb[j]);
            *out = I::from_limbs(all);
        }
    }
}

/// Returns the three parts of the integers of row `i` of quarter `quarter`, the highest first.
///
/// `V = sum residue * unit` is congruent to R, so `R = V - round(V / P) P`. Each of the three parts
/// of the sum and of the product has fewer than 53 bits, so that they and their differences are
/// exact, with fused multiply-add (`FUSED`) or without.
#[inline(always)]
fn row<const FUSED: bool>(
    residues: &[&PanelBlock<i8>],
    moduli: &Moduli,
    quarter: usize,
    i: usize,
) -> [[f64; WIDTH]; 3] {
    let mut parts = [[0.0; WIDTH]; 3];
    for (unit, residues) in moduli.units.iter().zip(residues) {
        let residues = &residues[quarter][i];
        for j in 0..WIDTH {
            let r = f64::from(residues[j]);
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

/// Implements [`Kernel::recombine`](super::Kernel::recombine), with fused multiply-add if `FUSED`.
#[inline(always)]
pub(super) fn block<const FUSED: bool>(it: Recombination<'_>, out: &mut Square<f64>) {
    let Recombination { residues, moduli, rows, columns, next } = it;
    for (i, out) in out.iter_mut().enumerate() {
        next.fetch(residues, i);
        for half in 0..2 {
            let quarter = i / WIDTH * 2 + half;
            let [high, middle, low] = row::<FUSED>(residues, moduli, quarter, i % WIDTH);
            for j in 0..WIDTH {
                let value = nearest([high[j], middle[j], low[j]]);
                let column = WIDTH * half + j;
                out[column] = scaled(value, rows[i] + columns[column]);
            }
        }
    }
}

#[inline(always)]
fn multiply_add<const FUSED: bool>(x: f64, y: f64, z: f64) -> f64 {
    if FUSED { x.mul_add(y, z) } else { x * y + z }
}
