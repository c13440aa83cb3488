//! The kernel for AMX: tiles of 16 x 64 bytes, 16384 multiplications per instruction. The other
//! steps are those of the AVX-512 kernel.

use std::arch::asm;
use std::arch::x86_64::{__cpuid, __cpuid_count, _xgetbv};
use std::sync::OnceLock;

use super::avx512::{Reduction, Sums, Vnni};
use super::kernel::{Conversion, Kernel, Operands, Recombination, Session};
use super::lane_set::LaneSet;
use super::tile::{DEPTH, PanelBlock, Slice, Square, Tile, TileNorms};
use crate::base::IsaLevel;

/// The kernel. A value exists only if AMX works, so the assembly below is sound.
pub(super) struct Amx {
    others: &'static Vnni,
}

impl Amx {
    /// Returns the kernel, or why this machine can't use it. The first call asks the system for
    /// permission to use the tiles.
    pub fn new() -> Result<&'static Self, &'static str> {
        static AMX: OnceLock<Result<Amx, &'static str>> = OnceLock::new();
        AMX.get_or_init(Self::detect).as_ref().map_err(|why| *why)
    }

    fn detect() -> Result<Self, &'static str> {
        IsaLevel::Amx.permitted()?;
        let others = Vnni::new()?;
        enabled()?;
        if !permitted() {
            return Err("the system refuses the AMX tiles to this process (arch_prctl)");
        }
        Ok(Self { others })
    }

    /// Creates the kernel for tests that emulate the instructions, all of which trap: fails where
    /// the CPU performs those that need no permission.
    #[cfg(test)]
    pub fn emulated() -> Result<Self, &'static str> {
        match enabled() {
            Ok(()) => Err("the CPU has AMX"),
            Err(_) => Ok(Self { others: Vnni::new()? }),
        }
    }
}

/// Checks that the CPU has the instructions and that the system has enabled the tiles.
fn enabled() -> Result<(), &'static str> {
    let has = |register: u32, bit: u32| register >> bit & 1 == 1;
    if __cpuid(0).eax < 7 {
        return Err("the CPU has no AMX");
    }
    let features = __cpuid_count(7, 0).edx;
    if !has(features, 24) || !has(features, 25) {
        return Err("the CPU has no AMX-INT8");
    }
    if !has(__cpuid(1).ecx, 27) {
        return Err("the system does not manage extended registers (OSXSAVE)");
    }
    // SAFETY: OSXSAVE says that the instruction exists.
    let enabled = unsafe { xgetbv() };
    if enabled >> 17 & 3 != 3 {
        return Err("the system has not enabled the AMX tiles (XCR0)");
    }
    Ok(())
}

#[target_feature(enable = "xsave")]
fn xgetbv() -> u64 {
    // SAFETY: the CPU has the instruction, and register 0 always exists.
    unsafe { _xgetbv(0) }
}

/// Asks Linux for permission to use the tiles, and returns whether it is granted.
#[cfg(target_os = "linux")]
fn permitted() -> bool {
    const ARCH_REQ_XCOMP_PERM: libc::c_ulong = 0x1023;
    const XFEATURE_XTILEDATA: libc::c_ulong = 18;
    // SAFETY: the arguments of this request are numbers, so that the system accesses no memory of
    // this process; it changes the permission only.
    unsafe { libc::syscall(libc::SYS_arch_prctl, ARCH_REQ_XCOMP_PERM, XFEATURE_XTILEDATA) == 0 }
}

/// Returns false: other systems offer no such request, and the first use of a tile might trap.
#[cfg(not(target_os = "linux"))]
fn permitted() -> bool {
    false
}

/// The shapes of the tiles, as `ldtilecfg` reads them.
#[repr(C, align(64))]
struct Config {
    palette: u8,
    start_row: u8,
    reserved: [u8; 14],
    row_bytes: [u16; 16],
    rows: [u8; 16],
}

/// Eight tiles of 16 rows of 64 bytes.
static CONFIG: Config = Config {
    palette: 1,
    start_row: 0,
    reserved: [0; 14],
    row_bytes: [64, 64, 64, 64, 64, 64, 64, 64, 0, 0, 0, 0, 0, 0, 0, 0],
    rows: [16, 16, 16, 16, 16, 16, 16, 16, 0, 0, 0, 0, 0, 0, 0, 0],
};

impl Kernel for Amx {
    fn norms_f64(&self, tile: &Tile<f64>) -> TileNorms {
        self.others.norms_f64(tile)
    }

    fn norms_f32(&self, tile: &Tile<f32>) -> TileNorms {
        self.others.norms_f32(tile)
    }

    fn convert_f64(&self, it: Conversion<'_, '_, f64>) {
        self.others.convert_f64(it);
    }

    fn convert_wide(&self, it: Conversion<'_, '_, f64>) {
        self.others.convert_wide(it);
    }

    fn convert_f32(&self, it: Conversion<'_, '_, f32>) {
        self.others.convert_f32(it);
    }

    fn to_left(&self, right: &[Slice], left: &mut [Slice]) {
        // A row of a left tile is a column of the operand: a right tile transposed by dwords.
        self.others.transpose(right, left);
    }

    fn product(&self, operands: &Operands<'_>, residues: &mut [PanelBlock<i8>]) {
        // SAFETY: `self` exists, so the CPU has the instructions. The caller holds a session, which
        // configures the tiles; without one the CPU traps.
        unsafe { product(operands, residues) }
    }

    fn recombine(&self, it: Recombination<'_>, out: &mut Square<f64>) {
        self.others.recombine(it, out);
    }

    fn lanes(&self) -> LaneSet {
        self.others.lanes()
    }

    fn session(&self) -> Session {
        // SAFETY: `self` exists, so the CPU has the instruction; the configuration is valid.
        unsafe { asm!("ldtilecfg [{}]", in(reg) &CONFIG, options(nostack, readonly)) };
        Session(Some(|| {
            // SAFETY: a session of this kernel exists only if the CPU has the instruction.
            unsafe { asm!("tilerelease", options(nostack, nomem)) };
        }))
    }
}

/// Implements [`Kernel::product`]. The sums of a pair of panels leave the tiles for the first-level
/// cache, and the vector units reduce them while the tiles multiply the next pair.
///
/// # Safety
/// The CPU has AMX-INT8, and the tiles are configured.
#[target_feature(enable = "avx512f,avx512bw,avx512dq,avx512vl,avx512vnni,fma")]
unsafe fn product(operands: &Operands<'_>, residues: &mut [PanelBlock<i8>]) {
    let Operands { right, next, modulus, continued, .. } = *operands;
    let reduction = Reduction::new(modulus);
    let mut sums = Sums::ZERO;
    let mut before: Option<&mut PanelBlock<i8>> = None;
    for (i, (left, residues)) in operands.left_panels(residues.len()).zip(residues).enumerate() {
        let ahead = next.as_ptr().cast::<i8>().wrapping_add(i * right.len() * AHEAD);
        // SAFETY: the contract: the CPU has AMX-INT8, and the caller of the method holds a session,
        // which configures the tiles. `left_panels` yields panels as long as `right`, at most
        // `DEPTH`, as `Operands` says.
        unsafe { multiply(left, right, ahead, &mut sums, before.take(), &reduction, continued) };
        before = Some(residues);
    }
    if let Some(last) = before {
        reduction.reduce(&sums, continued, last);
    }
}

/// Bytes of the next right panel that one step prefetches: all of the panel in 16 products.
const AHEAD: usize = 128;

/// Assembly for row `$row` of the four rows of a step of [`Reduction::reduce`]: computes the second
/// sums in register `$sum`, by way of the first sums in `$digits`.
#[rustfmt::skip]
macro_rules! first_sums {
    ($row:literal, $sum:literal, $digits:literal) => {
        concat!(
            "vpmovsxbd zmm", $sum, "{{k1}}{{z}}, [{residues} + 16*", $row, "]\n",
            "vpaddd zmm", $sum, ", zmm", $sum, ", [{rows} + 64*", $row, "]\n",
            "vpxord zmm", $sum, ", zmm", $sum, ", zmm20\n",
            "vmovdqa64 zmm", $digits, ", zmm21\n",
            "vpdpbusd zmm", $digits, ", zmm", $sum, ", zmm22\n",
            "vmovdqa64 zmm", $sum, ", zmm24\n",
            "vpdpbusd zmm", $sum, ", zmm", $digits, ", zmm23\n",
        )
    };
}

/// Assembly for the rest of a step of [`Reduction::reduce`]; prefetches residues of the next pair
/// of panels, which are written soon, and advances to the next four rows.
macro_rules! finish {
    () => {
        concat!(
            "vpackssdw zmm0, zmm0, zmm1\n",
            "vpackssdw zmm2, zmm2, zmm3\n",
            "vpmulhrsw zmm4, zmm0, zmm25\n",
            "vpmulhrsw zmm5, zmm2, zmm25\n",
            "vpmulhrsw zmm4, zmm4, zmm26\n",
            "vpmulhrsw zmm5, zmm5, zmm26\n",
            "vpmullw zmm4, zmm4, zmm27\n",
            "vpmullw zmm5, zmm5, zmm27\n",
            "vpsubw zmm0, zmm0, zmm4\n",
            "vpsubw zmm2, zmm2, zmm5\n",
            "vpacksswb zmm0, zmm0, zmm2\n",
            "vpermd zmm0, zmm28, zmm0\n",
            "vmovdqu64 [{residues}], zmm0\n",
            "prefetchw [{residues} + 1024]\n",
            "add {residues}, 64\n",
            "add {rows}, 256\n",
        )
    };
}

/// Assembly that prefetches for the next right panel and advances to the next step.
macro_rules! advance {
    () => {
        concat!(
            "prefetcht1 [{ahead}]\n",
            "prefetcht1 [{ahead} + 64]\n",
            "add {ahead}, 128\n",
            "add {left}, 2048\n",
            "add {right}, 2048\n",
        )
    };
}

/// Computes the product of two panels into `sums`, and meanwhile reduces the old sums to the
/// residues `before`, if any. One block of assembly, since the compiler does not allocate tiles:
/// tmm0 to tmm3 hold the quarters of the sums, tmm4 and tmm5 the left tiles, tmm6 and tmm7 the
/// right tiles.
///
/// The left operand comes from the second-level cache, by loads (`tileloaddt1`) that leave the
/// right operand in the first.
///
/// # Safety
/// The CPU has AMX-INT8, the tiles are configured, and `left` and `right` have the same length, at
/// most [`DEPTH`].
#[target_feature(enable = "avx512f,avx512bw,avx512dq,avx512vl,avx512vnni,fma")]
unsafe fn multiply(
    left: &[Slice],
    right: &[Slice],
    ahead: *const i8,
    sums: &mut Sums,
    before: Option<&mut PanelBlock<i8>>,
    reduction: &Reduction,
    continued: bool,
) {
    let steps = right.len();
    // A step reduces four rows of sums; the rest of the 64 rows follow the last step.
    let (both, alone, rest) =
        if before.is_some() { (steps, 0, DEPTH - steps) } else { (0, steps, 0) };
    let residues = before.map_or(std::ptr::null_mut(), |block| block.as_mut_ptr());
    let wanted: u16 = if continued { !0 } else { 0 };
    let sums = sums.0.as_mut_ptr();
    // SAFETY: reads `steps` steps of both operands, reads and writes the sums, and the residues
    // if there are any; any address may be prefetched.
    unsafe {
        asm!(
            "tilezero tmm0",
            "tilezero tmm1",
            "tilezero tmm2",
            "tilezero tmm3",
            "test {both}, {both}",
            "jz 3f",
            "2:",
            "tileloaddt1 tmm4, [{left} + {line}*1]",
            "tileloadd tmm6, [{right} + {line}*1]",
            first_sums!(0, 0, 4),
            "tdpbssd tmm0, tmm4, tmm6",
            "tileloaddt1 tmm5, [{left} + {line}*1 + 1024]",
            first_sums!(1, 1, 5),
            "tdpbssd tmm2, tmm5, tmm6",
            "tileloadd tmm7, [{right} + {line}*1 + 1024]",
            first_sums!(2, 2, 6),
            "tdpbssd tmm1, tmm4, tmm7",
            first_sums!(3, 3, 7),
            "tdpbssd tmm3, tmm5, tmm7",
            finish!(),
            advance!(),
            "dec {both}",
            "jnz 2b",
            "3:",
            "test {alone}, {alone}",
            "jz 5f",
            "4:",
            "tileloaddt1 tmm4, [{left} + {line}*1]",
            "tileloadd tmm6, [{right} + {line}*1]",
            "tdpbssd tmm0, tmm4, tmm6",
            "tileloaddt1 tmm5, [{left} + {line}*1 + 1024]",
            "tdpbssd tmm2, tmm5, tmm6",
            "tileloadd tmm7, [{right} + {line}*1 + 1024]",
            "tdpbssd tmm1, tmm4, tmm7",
            "tdpbssd tmm3, tmm5, tmm7",
            advance!(),
            "dec {alone}",
            "jnz 4b",
            "5:",
            "test {rest}, {rest}",
            "jz 7f",
            "6:",
            first_sums!(0, 0, 4),
            first_sums!(1, 1, 5),
            first_sums!(2, 2, 6),
            first_sums!(3, 3, 7),
            finish!(),
            "dec {rest}",
            "jnz 6b",
            "7:",
            "tilestored [{sums} + {line}*1], tmm0",
            "tilestored [{sums} + {line}*1 + 1024], tmm1",
            "tilestored [{sums} + {line}*1 + 2048], tmm2",
            "tilestored [{sums} + {line}*1 + 3072], tmm3",
            left = inout(reg) left.as_ptr() => _,
            right = inout(reg) right.as_ptr() => _,
            ahead = inout(reg) ahead => _,
            residues = inout(reg) residues => _,
            rows = inout(reg) sums => _,
            sums = in(reg) sums,
            both = inout(reg) both => _,
            alone = inout(reg) alone => _,
            rest = inout(reg) rest => _,
            line = in(reg) 64_usize,
            in("k1") wanted,
            in("zmm20") reduction.bias,
            in("zmm21") reduction.start,
            in("zmm22") reduction.weights,
            in("zmm23") reduction.second_weights,
            in("zmm24") reduction.centre,
            in("zmm25") reduction.inverse,
            in("zmm26") reduction.shift,
            in("zmm27") reduction.p,
            in("zmm28") reduction.rows,
            out("zmm0") _, out("zmm1") _, out("zmm2") _, out("zmm3") _,
            out("zmm4") _, out("zmm5") _, out("zmm6") _, out("zmm7") _,
            out("tmm0") _, out("tmm1") _, out("tmm2") _, out("tmm3") _,
            out("tmm4") _, out("tmm5") _, out("tmm6") _, out("tmm7") _,
            options(nostack),
        );
    }
}
