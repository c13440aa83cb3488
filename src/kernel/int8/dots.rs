//! Products by dot products of bytes in registers of 32 bytes (AVX-VNNI), for the kernel for AVX2.
//!
//! The algorithm is written once in terms of [`Dots`] and inlined into functions that enable its
//! instructions, so that tests run it with an emulated instruction on CPUs that lack it.

use std::arch::x86_64::*;

use super::avx2::{Avx2, finish};
use super::kernel::{Operands, product_by_pairs};
use super::moduli::Modulus;
use super::tile::{PanelBlock, Quarter, STEP, Slice, WIDTH};
use crate::base::IsaLevel;

/// Dot products of four bytes.
trait Dots {
    /// Adds to each dword of `sums` the products of the four unsigned bytes of `left` and the four
    /// signed bytes of `right`.
    ///
    /// # Safety
    /// The CPU has the instructions.
    unsafe fn add(sums: __m256i, left: __m256i, right: __m256i) -> __m256i;
}

/// `vpdpbusd` of AVX-VNNI.
struct Instruction;

impl Dots for Instruction {
    #[inline(always)]
    unsafe fn add(sums: __m256i, left: __m256i, right: __m256i) -> __m256i {
        // SAFETY: the contract: the CPU has AVX-VNNI. No memory is accessed.
        unsafe { _mm256_dpbusd_avx_epi32(sums, left, right) }
    }
}

/// Returns the kernel for AVX2 with these dot products, or why this machine can't use it.
pub(super) fn kernel() -> Result<&'static Avx2, &'static str> {
    // SAFETY: `kernel` returns it only where AVX2, FMA and AVX-VNNI have been detected, which
    // `product` enables.
    static KERNEL: Avx2 = unsafe { Avx2::with_dots(product) };
    IsaLevel::AvxVnni.permitted()?;
    Avx2::new()?;
    let found = is_x86_feature_detected!("avxvnni");
    if found { Ok(&KERNEL) } else { Err("the CPU has no AVX-VNNI") }
}

/// Implements [`Kernel::product`](super::kernel::Kernel::product), with the left side biased by
/// 128.
///
/// # Safety
/// The CPU has these instructions.
#[target_feature(enable = "avx2,fma,avxvnni")]
unsafe fn product(operands: &Operands<'_>, residues: &mut [PanelBlock<i8>]) {
    // SAFETY: the attribute enables AVX2, FMA and AVX-VNNI, the instructions of `Instruction`.
    unsafe { product_by::<Instruction>(operands, residues) }
}

/// Implements [`product`] by dot products of any kind.
///
/// # Safety
/// The CPU has AVX2, FMA and the instructions of `D`, as for every function below.
#[inline(always)]
unsafe fn product_by<D: Dots>(operands: &Operands<'_>, residues: &mut [PanelBlock<i8>]) {
    // SAFETY: the CPU has the instructions by the contract, which that of each function called
    // repeats.
    unsafe {
        let excess = &excess::<D>(operands.right);
        product_by_pairs(
            operands,
            residues,
            #[inline(always)]
            |left, right, sums| multiply::<D>(left, right, excess, sums),
            #[inline(always)]
            |sums, modulus, out| reduce::<D>(sums, modulus, out),
        );
    }
}

/// Returns 128 times the sum of each of the 16 columns of both tiles of the right side.
#[inline(always)]
unsafe fn excess<D: Dots>(right: &[Slice]) -> [[__m256i; 2]; 2] {
    // SAFETY: the CPU has the instructions, as `product_by` says; chunks are 32 bytes, a register,
    // and loads take any alignment.
    unsafe {
        // The instruction reads this weight as unsigned: +128.
        let weights = _mm256_set1_epi8(i8::MIN);
        let mut excess = [[_mm256_setzero_si256(); 2]; 2];
        for slice in right {
            for (tile, excess) in slice.iter().zip(&mut excess) {
                for (i, bytes) in tile.as_chunks::<32>().0.iter().enumerate() {
                    let bytes = _mm256_loadu_si256(bytes.as_ptr().cast());
                    excess[i % 2] = D::add(excess[i % 2], weights, bytes);
                }
            }
        }
        excess
    }
}

/// Steps of a chunk of both operands (32 KiB), which stays in the first-level cache for all passes.
const CACHED: usize = 8;

/// Adds the product of two panels, of which the left one is biased by 128, to the sums, and
/// subtracts `excess`, by which each column is then too large.
#[inline(always)]
unsafe fn multiply<D: Dots>(
    left: &[Slice],
    right: &[Slice],
    excess: &[[__m256i; 2]; 2],
    sums: &mut PanelBlock<i32>,
) {
    // SAFETY: the CPU has the instructions, as `product_by` says; eight sums are a register, and
    // loads and stores take any alignment. The rows passed to `add_rows` end at WIDTH, as asserted.
    unsafe {
        for (quarter, sums) in sums.iter_mut().enumerate() {
            for row in sums {
                for (eight, &excess) in
                    row.as_chunks_mut::<8>().0.iter_mut().zip(&excess[quarter % 2])
                {
                    let at = eight.as_mut_ptr().cast::<__m256i>();
                    _mm256_storeu_si256(at, _mm256_sub_epi32(_mm256_loadu_si256(at), excess));
                }
            }
        }
        for (left, right) in left.chunks(CACHED).zip(right.chunks(CACHED)) {
            for (quarter, sums) in sums.iter_mut().enumerate() {
                // All rows. Ten sums at once hide the five cycles that the instruction takes; six
                // rows of two registers leave three of 16 for the operands.
                const { assert!(6 + 5 + 5 == WIDTH) };
                add_rows::<D, 6>(left, right, quarter, 0, sums);
                add_rows::<D, 5>(left, right, quarter, 6, sums);
                add_rows::<D, 5>(left, right, quarter, 11, sums);
            }
        }
    }
}

/// Adds the products of HELD rows of a quarter, from `first` on, whose sums are held in registers.
#[inline(always)]
unsafe fn add_rows<D: Dots, const HELD: usize>(
    left: &[Slice],
    right: &[Slice],
    quarter: usize,
    first: usize,
    sums: &mut Quarter<i32>,
) {
    // SAFETY: the CPU has the instructions, as `product_by` says; `first + HELD` is at most WIDTH,
    // and a row of 16 sums is two registers. Offset k of a tile is followed by 64 bytes, which hold
    // 16 dwords and two registers.
    unsafe {
        let mut held = [[_mm256_setzero_si256(); 2]; HELD];
        for (r, held) in held.iter_mut().enumerate() {
            for (half, held) in held.iter_mut().enumerate() {
                *held = _mm256_loadu_si256(sums[first + r].as_ptr().add(8 * half).cast());
            }
        }
        for (left, right) in left.iter().zip(right) {
            let (left, right) = (&left[quarter / 2], &right[quarter % 2]);
            for k in (0..STEP * WIDTH).step_by(64) {
                let dwords = left.as_ptr().add(k).cast::<i32>();
                let columns = right.as_ptr().add(k).cast::<__m256i>();
                let columns = [_mm256_loadu_si256(columns), _mm256_loadu_si256(columns.add(1))];
                for (r, held) in held.iter_mut().enumerate() {
                    let four = _mm256_set1_epi32(dwords.add(first + r).read_unaligned());
                    held[0] = D::add(held[0], four, columns[0]);
                    held[1] = D::add(held[1], four, columns[1]);
                }
            }
        }
        for (r, held) in held.iter().enumerate() {
            for (half, &held) in held.iter().enumerate() {
                _mm256_storeu_si256(sums[first + r].as_mut_ptr().add(8 * half).cast(), held);
            }
        }
    }
}

/// Reduces sums to residues between -128 and 127, as [`portable`](super::portable) does.
#[inline(always)]
unsafe fn reduce<D: Dots>(sums: &PanelBlock<i32>, modulus: &Modulus, out: &mut PanelBlock<i8>) {
    // SAFETY: the CPU has the instructions, as `product_by` says; chunks are 32 sums, four
    // registers, and 32 bytes, one.
    unsafe {
        let (bias, start) = (_mm256_set1_epi32(i32::MIN), _mm256_set1_epi32(modulus.start_32));
        let [w0, w1, w2, w3, ..] = modulus.weights.map(|weight| weight as u8);
        let weights = _mm256_set1_epi32(i32::from_le_bytes([w0, w1, w2, w3]));
        // Packing takes the low halves of registers, then the high ones.
        let order = _mm256_setr_epi32(0, 4, 1, 5, 2, 6, 3, 7);
        let sums = sums.as_flattened().as_flattened();
        let out = out.as_flattened_mut().as_flattened_mut();
        for (sums, out) in sums.as_chunks::<32>().0.iter().zip(out.as_chunks_mut::<32>().0) {
            let mut found = [bias; 4];
            for (i, found) in found.iter_mut().enumerate() {
                let sums = _mm256_loadu_si256(sums.as_ptr().add(8 * i).cast());
                let first = D::add(start, _mm256_xor_si256(sums, bias), weights);
                // Without the sign: modulo 256 a residue of 128 is also -128.
                *found = _mm256_and_si256(finish(first, modulus.p), _mm256_set1_epi32(0xff));
            }
            let [f0, f1, f2, f3] = found;
            let (low, high) = (_mm256_packus_epi32(f0, f1), _mm256_packus_epi32(f2, f3));
            let bytes = _mm256_permutevar8x32_epi32(_mm256_packus_epi16(low, high), order);
            _mm256_storeu_si256(out.as_mut_ptr().cast(), bytes);
        }
    }
}

/// The instruction in terms of AVX2.
#[cfg(test)]
struct Emulation;

#[cfg(test)]
impl Dots for Emulation {
    #[inline(always)]
    unsafe fn add(sums: __m256i, left: __m256i, right: __m256i) -> __m256i {
        // SAFETY: the contract: the CPU has AVX2. No memory is accessed.
        unsafe {
            let even_left = _mm256_and_si256(left, _mm256_set1_epi16(0xff));
            let even_right = _mm256_srai_epi16::<8>(_mm256_slli_epi16::<8>(right));
            let even = _mm256_madd_epi16(even_left, even_right);
            let (odd_left, odd_right) =
                (_mm256_srli_epi16::<8>(left), _mm256_srai_epi16::<8>(right));
            let odd = _mm256_madd_epi16(odd_left, odd_right);
            _mm256_add_epi32(sums, _mm256_add_epi32(even, odd))
        }
    }
}

/// Returns [`kernel`] with the instruction emulated, or why this machine can't use it.
#[cfg(test)]
pub(super) fn emulated_kernel() -> Result<&'static Avx2, &'static str> {
    // SAFETY: `emulated_kernel` returns it only where `Avx2::new` has found AVX2 and FMA, which
    // `emulated_product` enables.
    static KERNEL: Avx2 = unsafe { Avx2::with_dots(emulated_product) };
    Avx2::new().map(|_| &KERNEL)
}

/// Computes [`product`] with the instruction emulated.
///
/// # Safety
/// The CPU has AVX2 and FMA.
#[cfg(test)]
#[target_feature(enable = "avx2,fma")]
unsafe fn emulated_product(operands: &Operands<'_>, residues: &mut [PanelBlock<i8>]) {
    // SAFETY: the attribute enables AVX2 and FMA, all that `Emulation` needs.
    unsafe { product_by::<Emulation>(operands, residues) }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::base::Rng;

    type Eight = [i32; 8];

    /// Defines a function that computes eight dot products by `$add`.
    macro_rules! dots {
        ($name:ident, $features:tt, $add:path) => {
            #[target_feature(enable = $features)]
            fn $name(operands: &[Eight; 3]) -> Eight {
                let mut found = [0; 8];
                // SAFETY: registers of 8 elements; the CPU has the instructions.
                unsafe {
                    let [sums, left, right] =
                        [0, 1, 2].map(|i: usize| _mm256_loadu_si256(operands[i].as_ptr().cast()));
                    _mm256_storeu_si256(found.as_mut_ptr().cast(), $add(sums, left, right));
                }
                found
            }
        };
    }
    dots!(emulated, "avx2", Emulation::add);
    dots!(avx_vnni, "avx2,avxvnni", Instruction::add);
    // The same instruction as AVX-512 encodes it, which more CPUs have.
    dots!(avx512, "avx512vnni,avx512vl", _mm256_dpbusd_epi32);

    #[test]
    fn the_instruction_and_its_emulation_are_exact_in_every_lane() {
        let mut rng = Rng::new(9);
        let mut eight = || -> Eight {
            // Extremes are frequent, since they overflow sums.
            [(); 8].map(|()| match rng.bits() % 8 {
                0 => i32::MIN,
                1 => i32::MAX,
                2 => -1,
                3 => i32::from_le_bytes([128; 4]),
                _ => rng.bits() as i32,
            })
        };
        for _ in 0..1000 {
            let operands = &[eight(), eight(), eight()];
            let [sums, left, right] = operands;
            let expected: Eight = std::array::from_fn(|i| {
                let pairs = left[i].to_le_bytes().into_iter().zip(right[i].to_le_bytes());
                let products = pairs.map(|(l, r)| i32::from(l) * i32::from(r as i8));
                products.fold(sums[i], i32::wrapping_add)
            });
            if is_x86_feature_detected!("avx2") {
                // SAFETY: the CPU has the instructions.
                assert_eq!(unsafe { emulated(operands) }, expected, "{operands:?}");
            }
            if is_x86_feature_detected!("avx2") && is_x86_feature_detected!("avxvnni") {
                // SAFETY: the CPU has the instructions.
                assert_eq!(unsafe { avx_vnni(operands) }, expected, "{operands:?}");
            }
            if is_x86_feature_detected!("avx512vnni") && is_x86_feature_detected!("avx512vl") {
                // SAFETY: the CPU has the instructions.
                assert_eq!(unsafe { avx512(operands) }, expected, "{operands:?}");
            }
        }
    }
}
