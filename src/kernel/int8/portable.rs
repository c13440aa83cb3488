//! The kernel in plain Rust: for any CPU, and what the others are compared with.

use super::moduli::{Moduli, Modulus};
use super::tile::{
    Block, Powers, Quarter, Residues, STEP, Slice, Tile, TileNorms, WIDTH, tile_norms,
};
use super::{Kernel, recombine};
use crate::base::Real;

pub(crate) struct Portable;

impl Kernel for Portable {
    fn norms_f64(&self, tile: &Tile<f64>) -> TileNorms {
        tile_norms(tile)
    }

    fn norms_f32(&self, tile: &Tile<f32>) -> TileNorms {
        tile_norms(tile)
    }

    fn convert_f64(
        &self,
        tile: &Tile<f64>,
        powers: &Powers<f64>,
        moduli: &Moduli,
        out: &mut [&mut Residues],
    ) {
        convert(tile, powers, moduli, out);
    }

    fn convert_f32(
        &self,
        tile: &Tile<f32>,
        powers: &Powers<f32>,
        moduli: &Moduli,
        out: &mut [&mut Residues],
    ) {
        convert(tile, powers, moduli, out);
    }

    fn multiply(&self, left: &[Slice], right: &[Slice], sums: &mut Block<i32>, _ahead: *const i8) {
        // With the widest registers there are: sums of integers may come in any order.
        pulp::Arch::new().dispatch(
            #[inline(always)]
            || multiply(left, right, sums),
        );
    }

    fn reduce(&self, sums: &Block<i32>, modulus: &Modulus, out: &mut Block<i8>) {
        let sums = sums.as_flattened().as_flattened();
        for (out, &sum) in out.as_flattened_mut().as_flattened_mut().iter_mut().zip(sums) {
            *out = residue(sum.into(), modulus.p);
        }
    }

    fn recombine(
        &self,
        residues: &[&Quarter<i8>],
        moduli: &Moduli,
        rows: &[i32; WIDTH],
        columns: &[i32; WIDTH],
        out: &mut Quarter<f64>,
    ) {
        recombine::quarter::<false>(residues, moduli, rows, columns, out);
    }
}

/// `v mod p`, between -128 and 127.
fn residue(v: i64, p: i32) -> i8 {
    let r = v.rem_euclid(p.into());
    (if r > i64::from(p - 1) / 2 { r - i64::from(p) } else { r }) as i8
}

fn convert<T: Real>(
    tile: &Tile<T>,
    powers: &Powers<T>,
    moduli: &Moduli,
    out: &mut [&mut Residues],
) {
    let mut integers = [[0; WIDTH]; STEP];
    for (line, row) in integers.iter_mut().zip(&tile.0) {
        for (j, integer) in line.iter_mut().enumerate() {
            let scaled = row[j] * powers.first[j] * powers.second[j];
            *integer = scaled.to_f64().round_ties_even() as i64;
        }
    }
    for (modulus, out) in moduli.list.iter().zip(out) {
        for (i, row) in integers.iter().enumerate() {
            for (j, &integer) in row.iter().enumerate() {
                out[64 * (i / 4) + 4 * j + i % 4] = residue(integer, modulus.p);
            }
        }
    }
}

#[inline(always)]
fn multiply(left: &[Slice], right: &[Slice], sums: &mut Block<i32>) {
    for (quarter, sums) in sums.iter_mut().enumerate() {
        for (left, right) in left.iter().zip(right) {
            let (left, right) = (&left[quarter / 2], &right[quarter % 2]);
            for (left, right) in left.chunks_exact(64).zip(right.chunks_exact(64)) {
                let right: [i16; 64] = std::array::from_fn(|i| right[i].into());
                for (left, sums) in left.chunks_exact(4).zip(sums.iter_mut()) {
                    let left: [i16; 4] = std::array::from_fn(|i| left[i].into());
                    for (j, sum) in sums.iter_mut().enumerate() {
                        let product = |i: usize| i32::from(left[i]) * i32::from(right[4 * j + i]);
                        *sum += (product(0) + product(1)) + (product(2) + product(3));
                    }
                }
            }
        }
    }
}
