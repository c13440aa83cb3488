//! The kernel for AMX: tiles of 16 x 64 bytes, 16384 multiplications an instruction. The steps that are
//! no products of tiles are those of the AVX-512 kernel.

use std::arch::asm;
use std::arch::x86_64::{__cpuid, __cpuid_count, _xgetbv};
use std::sync::OnceLock;

use super::avx512::Vnni;
use super::kernel::{Kernel, Session};
use super::moduli::{Moduli, Modulus};
use super::tile::{Block, Powers, Quarter, Residues, Slice, Tile, TileNorms, WIDTH};

/// Exists only where AMX works: what makes the assembly below sound.
pub(super) struct Amx {
    others: &'static Vnni,
}

impl Amx {
    /// The kernel, or why there is none. The first call asks the system for the use of the tiles.
    pub fn new() -> Result<&'static Self, &'static str> {
        static AMX: OnceLock<Result<Amx, &'static str>> = OnceLock::new();
        AMX.get_or_init(Self::detect).as_ref().map_err(|why| *why)
    }

    fn detect() -> Result<Self, &'static str> {
        let others = Vnni::new()?;
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
        if !permitted() {
            return Err("the system refuses the AMX tiles to this process (arch_prctl)");
        }
        Ok(Self { others })
    }

    /// For tests that emulate the instructions.
    #[cfg(test)]
    pub fn unchecked() -> Result<Self, &'static str> {
        Ok(Self { others: Vnni::new()? })
    }
}

#[target_feature(enable = "xsave")]
fn xgetbv() -> u64 {
    // SAFETY: the caller has the instruction, and register 0 always exists.
    unsafe { _xgetbv(0) }
}

/// Linux gives the tiles' memory to a process that asks for it.
#[cfg(target_os = "linux")]
fn permitted() -> bool {
    const ARCH_REQ_XCOMP_PERM: libc::c_ulong = 0x1023;
    const XFEATURE_XTILEDATA: libc::c_ulong = 18;
    // SAFETY: changes nothing but the permission.
    unsafe { libc::syscall(libc::SYS_arch_prctl, ARCH_REQ_XCOMP_PERM, XFEATURE_XTILEDATA) == 0 }
}

/// Elsewhere the first use of a tile would decide.
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

    fn convert_f64(
        &self,
        tile: &Tile<f64>,
        powers: &Powers<f64>,
        moduli: &Moduli,
        out: &mut [&mut Residues],
    ) {
        self.others.convert_f64(tile, powers, moduli, out);
    }

    fn convert_f32(
        &self,
        tile: &Tile<f32>,
        powers: &Powers<f32>,
        moduli: &Moduli,
        out: &mut [&mut Residues],
    ) {
        self.others.convert_f32(tile, powers, moduli, out);
    }

    /// A left tile has the bytes of a column side by side: it is the right one's transpose, by dwords.
    fn to_left(&self, right: &[Slice], left: &mut [Slice]) {
        self.others.transpose(right, left);
    }

    fn multiply(&self, left: &[Slice], right: &[Slice], sums: &mut Block<i32>, ahead: *const i8) {
        assert_eq!(left.len(), right.len());
        // SAFETY: `self` exists, so the CPU has the instructions, and both operands are that long. The
        // session that the caller has to hold shapes the tiles; without one the CPU traps.
        unsafe { multiply(left, right, sums, ahead) }
    }

    fn reduce(&self, sums: &Block<i32>, modulus: &Modulus, out: &mut Block<i8>) {
        self.others.reduce(sums, modulus, out);
    }

    fn recombine(
        &self,
        residues: &[&Quarter<i8>],
        moduli: &Moduli,
        rows: &[i32; WIDTH],
        columns: &[i32; WIDTH],
        out: &mut Quarter<f64>,
    ) {
        self.others.recombine(residues, moduli, rows, columns, out);
    }

    fn spin(&self, count: usize) -> Option<usize> {
        const ROUND: usize = 4 * 16 * 16 * 64;
        let rounds = count.div_ceil(ROUND).max(1);
        // SAFETY: `self` exists, so the CPU has the instructions; the caller holds a session.
        unsafe {
            asm!(
                "2:",
                "tdpbssd tmm0, tmm4, tmm6",
                "tdpbssd tmm1, tmm4, tmm7",
                "tdpbssd tmm2, tmm5, tmm6",
                "tdpbssd tmm3, tmm5, tmm7",
                "dec {rounds}",
                "jnz 2b",
                rounds = inout(reg) rounds => _,
                out("tmm0") _, out("tmm1") _, out("tmm2") _, out("tmm3") _,
                options(nostack, nomem),
            );
        }
        Some(rounds * ROUND)
    }

    fn session(&self) -> Session {
        // SAFETY: `self` exists, so the CPU has the instruction; the configuration is valid.
        unsafe { asm!("ldtilecfg [{}]", in(reg) &CONFIG, options(nostack, readonly)) };
        Session(Some(|| {
            // SAFETY: only made where the CPU has the instruction.
            unsafe { asm!("tilerelease", options(nostack, nomem)) };
        }))
    }
}

/// One block of assembly, since the compiler knows nothing of tiles: tmm0 to tmm3 hold the quarters of
/// the sums, tmm4 and tmm5 the left tiles, tmm6 and tmm7 the right ones. The left operand streams from the
/// second-level cache: the next step's lines are fetched between the products.
///
/// # Safety
/// The CPU has AMX-INT8, the tiles are configured, and `left` and `right` have the same length.
unsafe fn multiply(left: &[Slice], right: &[Slice], sums: &mut Block<i32>, ahead: *const i8) {
    // SAFETY: reads `left.len()` steps of both operands, reads and writes the sums; prefetches may
    // go anywhere.
    unsafe {
        asm!(
            "tileloadd tmm0, [{sums} + {line}*1]",
            "tileloadd tmm1, [{sums} + {line}*1 + 1024]",
            "tileloadd tmm2, [{sums} + {line}*1 + 2048]",
            "tileloadd tmm3, [{sums} + {line}*1 + 3072]",
            "test {steps}, {steps}",
            "jz 3f",
            "2:",
            "tileloadd tmm4, [{left} + {line}*1]",
            "tileloadd tmm6, [{right} + {line}*1]",
            "prefetcht0 [{left} + 2048]",
            "prefetcht0 [{left} + 2112]",
            "prefetcht0 [{left} + 2176]",
            "prefetcht0 [{left} + 2240]",
            "prefetcht0 [{left} + 2304]",
            "prefetcht0 [{left} + 2368]",
            "prefetcht0 [{left} + 2432]",
            "prefetcht0 [{left} + 2496]",
            "tdpbssd tmm0, tmm4, tmm6",
            "tileloadd tmm7, [{right} + {line}*1 + 1024]",
            "prefetcht0 [{left} + 2560]",
            "prefetcht0 [{left} + 2624]",
            "prefetcht0 [{left} + 2688]",
            "prefetcht0 [{left} + 2752]",
            "prefetcht0 [{left} + 2816]",
            "prefetcht0 [{left} + 2880]",
            "prefetcht0 [{left} + 2944]",
            "prefetcht0 [{left} + 3008]",
            "tdpbssd tmm1, tmm4, tmm7",
            "tileloadd tmm5, [{left} + {line}*1 + 1024]",
            "prefetcht0 [{left} + 3072]",
            "prefetcht0 [{left} + 3136]",
            "prefetcht0 [{left} + 3200]",
            "prefetcht0 [{left} + 3264]",
            "prefetcht0 [{left} + 3328]",
            "prefetcht0 [{left} + 3392]",
            "prefetcht0 [{left} + 3456]",
            "prefetcht0 [{left} + 3520]",
            "tdpbssd tmm2, tmm5, tmm6",
            "prefetcht0 [{left} + 3584]",
            "prefetcht0 [{left} + 3648]",
            "prefetcht0 [{left} + 3712]",
            "prefetcht0 [{left} + 3776]",
            "prefetcht0 [{left} + 3840]",
            "prefetcht0 [{left} + 3904]",
            "prefetcht0 [{left} + 3968]",
            "prefetcht0 [{left} + 4032]",
            "tdpbssd tmm3, tmm5, tmm7",
            "prefetcht1 [{ahead}]",
            "prefetcht1 [{ahead} + 64]",
            "prefetcht1 [{ahead} + 128]",
            "prefetcht1 [{ahead} + 192]",
            "add {left}, 2048",
            "add {right}, 2048",
            "add {ahead}, 256",
            "dec {steps}",
            "jnz 2b",
            "3:",
            "tilestored [{sums} + {line}*1], tmm0",
            "tilestored [{sums} + {line}*1 + 1024], tmm1",
            "tilestored [{sums} + {line}*1 + 2048], tmm2",
            "tilestored [{sums} + {line}*1 + 3072], tmm3",
            left = inout(reg) left.as_ptr() => _,
            right = inout(reg) right.as_ptr() => _,
            ahead = inout(reg) ahead => _,
            steps = inout(reg) left.len() => _,
            sums = in(reg) sums.as_mut_ptr(),
            line = in(reg) 64_usize,
            out("tmm0") _, out("tmm1") _, out("tmm2") _, out("tmm3") _,
            out("tmm4") _, out("tmm5") _, out("tmm6") _, out("tmm7") _,
            options(nostack),
        );
    }
}
