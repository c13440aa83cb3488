//! The kernel for AVX2: products of 16-bit numbers, added in pairs. The other steps are the portable ones in
//! wider registers.

use std::arch::x86_64::*;

use super::kernel::{Kernel, product_by_pairs};
use super::moduli::{Moduli, Modulus};
use super::tile::{Block, Powers, Quarter, Residues, Slice, Tile, TileNorms, WIDTH, tile_norms};
use super::{portable, recombine};

/// Exists only where the CPU has the instructions: what makes the calls below sound.
pub(super) struct Avx2(());

static AVX2: Avx2 = Avx2(());

impl Avx2 {
    /// The kernel, or why there is none.
    pub fn new() -> Result<&'static Self, &'static str> {
        let found = is_x86_feature_detected!("avx2") && is_x86_feature_detected!("fma");
        if found { Ok(&AVX2) } else { Err("the CPU has no AVX2 with FMA") }
    }
}

/// Calls a function with the instructions of this module enabled.
macro_rules! enabled {
    ($function:expr => ($($name:ident: $t:ty),*) $(-> $out:ty)?) => {{
        #[target_feature(enable = "avx2,fma")]
        fn run($($name: $t),*) $(-> $out)? {
            $function($($name),*)
        }
        // SAFETY: a method of `Avx2`, which exists only where the CPU has the instructions.
        unsafe { run($($name),*) }
    }};
}

impl Kernel for Avx2 {
    fn norms_f64(&self, tile: &Tile<f64>) -> TileNorms {
        enabled!(tile_norms => (tile: &Tile<f64>) -> TileNorms)
    }

    fn norms_f32(&self, tile: &Tile<f32>) -> TileNorms {
        enabled!(tile_norms => (tile: &Tile<f32>) -> TileNorms)
    }

    fn convert_f64(
        &self,
        tile: &Tile<f64>,
        powers: &Powers<f64>,
        moduli: &Moduli,
        out: &mut [&mut Residues],
        _far: bool,
    ) {
        enabled!(portable::convert =>
            (tile: &Tile<f64>, powers: &Powers<f64>, moduli: &Moduli, out: &mut [&mut Residues]))
    }

    fn convert_f32(
        &self,
        tile: &Tile<f32>,
        powers: &Powers<f32>,
        moduli: &Moduli,
        out: &mut [&mut Residues],
        _far: bool,
    ) {
        enabled!(portable::convert =>
            (tile: &Tile<f32>, powers: &Powers<f32>, moduli: &Moduli, out: &mut [&mut Residues]))
    }

    fn product(
        &self,
        left: &[Slice],
        right: &[Slice],
        _next: &[Slice],
        modulus: &Modulus,
        continued: bool,
        residues: &mut [Block<i8>],
    ) {
        product_by_pairs(
            left,
            right,
            continued,
            residues,
            // SAFETY: `self` exists, so the CPU has the instructions.
            |left, right, sums| unsafe { multiply(left, right, sums) },
            |sums, out| {
                enabled!(portable::reduce =>
                    (sums: &Block<i32>, modulus: &Modulus, out: &mut Block<i8>))
            },
        );
    }

    fn recombine(
        &self,
        residues: &[&Quarter<i8>],
        moduli: &Moduli,
        rows: &[i32; WIDTH],
        columns: &[i32; WIDTH],
        out: &mut Quarter<f64>,
    ) {
        enabled!(recombine::quarter::<true> => (
            residues: &[&Quarter<i8>],
            moduli: &Moduli,
            rows: &[i32; WIDTH],
            columns: &[i32; WIDTH],
            out: &mut Quarter<f64>
        ))
    }
}

/// Rows of a quarter whose sums are held in registers.
const HELD: usize = 2;

/// Every entry is held as two sums, of the first and of the last two of each four products.
#[target_feature(enable = "avx2,fma")]
fn multiply(left: &[Slice], right: &[Slice], sums: &mut Block<i32>) {
    for (quarter, sums) in sums.iter_mut().enumerate() {
        for (first, sums) in sums.chunks_exact_mut(HELD).enumerate() {
            let mut held = [[_mm256_setzero_si256(); 4]; HELD];
            for (left, right) in left.iter().zip(right) {
                let (left, right) = (&left[quarter / 2], &right[quarter % 2]);
                for (left, right) in left.chunks_exact(64).zip(right.chunks_exact(64)) {
                    let four: [_; HELD] = std::array::from_fn(|r| {
                        // SAFETY: dword `HELD first + r` of the 16 of this row.
                        let dword = unsafe {
                            left.as_ptr().add(4 * (HELD * first + r)).cast::<i32>().read_unaligned()
                        };
                        _mm256_broadcastq_epi64(_mm_cvtepi8_epi16(_mm_cvtsi32_si128(dword)))
                    });
                    for c in 0..4 {
                        // SAFETY: 16 bytes from 16 c on of this row's 64.
                        let bytes = unsafe { _mm_loadu_si128(right.as_ptr().add(16 * c).cast()) };
                        let right = _mm256_cvtepi8_epi16(bytes);
                        for (held, four) in held.iter_mut().zip(four) {
                            held[c] = _mm256_add_epi32(held[c], _mm256_madd_epi16(four, right));
                        }
                    }
                }
            }
            for (sums, held) in sums.iter_mut().zip(held) {
                for (c, held) in held.into_iter().enumerate() {
                    let mut pairs = [0_i32; 8];
                    // SAFETY: 8 elements.
                    unsafe { _mm256_storeu_si256(pairs.as_mut_ptr().cast(), held) };
                    for (sum, pair) in sums[4 * c..].iter_mut().zip(pairs.chunks_exact(2)) {
                        *sum = sum.wrapping_add(pair[0].wrapping_add(pair[1]));
                    }
                }
            }
        }
    }
}
