//! Prints the rates of tiles with operands in registers and in each level of the memory, for every
//! instruction set of this machine:
//!
//! ```text
//! cargo test --release -p catamaran --lib packed::tests::ladder -- --ignored --nocapture
//! ```

use super::super::geometry::Geometry;
use super::super::tile::{Row, Side};
use super::super::write::LARGEST_TILE;
use super::isas;
use crate::base::{Rng, Workspace};
use crate::kernel::packed::{FloatIsa, FloatOperand};
use crate::kernel::rate::fastest;

/// Bytes of the operands of tiles that follow each other: one, or as many as a level holds.
const LEVELS: [(&str, usize); 3] = [("first", 0), ("second", 384 << 10), ("third", 8 << 20)];

/// Levels of the left side, of which a tile takes a strip, and of the right side, of which it takes
/// a panel.
const SIDES: [[usize; 2]; 6] = [[0, 0], [0, 1], [1, 0], [1, 1], [0, 2], [2, 0]];

/// Tiles of a run.
const RUN: usize = 256;

#[test]
#[ignore = "measures for some seconds"]
fn rates_of_tiles() {
    for isa in isas() {
        rates::<f64>(isa);
        rates::<f32>(isa);
    }
}

fn rates<T: FloatOperand>(isa: FloatIsa) {
    let lanes = T::kernel(isa).geometry().lanes;
    let peak = registers(isa).map(|rate| rate * lanes as f64);
    let text = |rate: f64| match peak {
        Some(peak) => format!("{:7.1} GF/s {:5.1} %", 2e-9 * rate, 100.0 * rate / peak),
        None => format!("{:7.1} GF/s", 2e-9 * rate),
    };
    println!("\n{}, {}: registers {}", isa.name(), T::NAME, peak.map_or("-".into(), text));
    for sides in SIDES {
        // Half of the steps where both sides are to fit the first-level cache together.
        for steps in if sides == SIDES[0] { [64, 128] } else { [128, 320] } {
            let [left, right] = sides.map(|side| LEVELS[side].0);
            let rate = rate::<T>(isa, sides.map(|side| LEVELS[side].1), steps);
            println!("{left:<6} x {right:<6} {steps:4} steps {}", text(rate));
        }
    }
}

/// Returns the multiplications of vectors per second on registers alone; `None` for the portable
/// kernel. The isa is one of this machine.
fn registers(isa: FloatIsa) -> Option<f64> {
    #[cfg(target_arch = "x86_64")]
    const ROUNDS: usize = 1 << 14;
    /// Independent sums, which fill the pipelines.
    #[cfg(target_arch = "x86_64")]
    const SUMS: usize = 12;
    #[cfg(target_arch = "x86_64")]
    macro_rules! products {
        ($register:literal) => {
            // SAFETY: the CPU has the instructions, and only registers are touched.
            fastest(|| unsafe {
                std::arch::asm!(
                    "2:",
                    concat!("vfmadd231pd ", $register, "0, ", $register, "12, ", $register, "13"),
                    concat!("vfmadd231pd ", $register, "1, ", $register, "12, ", $register, "13"),
                    concat!("vfmadd231pd ", $register, "2, ", $register, "12, ", $register, "13"),
                    concat!("vfmadd231pd ", $register, "3, ", $register, "12, ", $register, "13"),
                    concat!("vfmadd231pd ", $register, "4, ", $register, "12, ", $register, "13"),
                    concat!("vfmadd231pd ", $register, "5, ", $register, "12, ", $register, "13"),
                    concat!("vfmadd231pd ", $register, "6, ", $register, "12, ", $register, "13"),
                    concat!("vfmadd231pd ", $register, "7, ", $register, "12, ", $register, "13"),
                    concat!("vfmadd231pd ", $register, "8, ", $register, "12, ", $register, "13"),
                    concat!("vfmadd231pd ", $register, "9, ", $register, "12, ", $register, "13"),
                    concat!("vfmadd231pd ", $register, "10, ", $register, "12, ", $register, "13"),
                    concat!("vfmadd231pd ", $register, "11, ", $register, "12, ", $register, "13"),
                    "dec {rounds}",
                    "jnz 2b",
                    rounds = inout(reg) ROUNDS => _,
                    out("ymm0") _, out("ymm1") _, out("ymm2") _, out("ymm3") _,
                    out("ymm4") _, out("ymm5") _, out("ymm6") _, out("ymm7") _,
                    out("ymm8") _, out("ymm9") _, out("ymm10") _, out("ymm11") _,
                    options(nostack, nomem),
                );
                SUMS * ROUNDS
            })
        };
    }
    match isa {
        #[cfg(target_arch = "x86_64")]
        FloatIsa::Avx512 => Some(products!("zmm")),
        #[cfg(target_arch = "x86_64")]
        FloatIsa::Avx2 => Some(products!("ymm")),
        _ => None,
    }
}

/// Returns the multiplications of scalars per second of tiles with so many `steps`, whose left and
/// right sides come from operands of so many `bytes`.
fn rate<T: FloatOperand>(isa: FloatIsa, bytes: [usize; 2], steps: usize) -> f64 {
    let kernel = T::kernel(isa);
    let Geometry { rows, width, .. } = kernel.geometry();
    let panel = steps * width;
    let [lefts, rights] = bytes.map(|bytes| (bytes / (panel * size_of::<T>())).max(1));
    let mut memory = Workspace::<T>::new((lefts + rights) * panel).unwrap();
    let mut rng = Rng::new(1);
    memory.as_mut_slice().fill_with(|| T::from_f64(rng.uniform() - 0.5));
    let side = |i: usize| Side {
        start: memory.as_slice()[i * panel..].as_ptr(),
        row_stride: width as isize,
        panel_stride: panel,
    };
    // A left side in the first-level cache is one strip, else all strips of its panels.
    let strips = if lefts == 1 { 1 } else { lefts * (width / rows) };
    let left = |i: usize| side(0).at_column(i % strips * rows, width);
    let mut sums = [T::ZERO; LARGEST_TILE];
    let mut next = 0;
    fastest(|| {
        for _ in 0..RUN {
            let row = Row {
                steps,
                left: left(next),
                right: side(lefts + next % rights),
                next_left: left(next + 1).start,
                next_right: left(next + 1).start,
                next_lines: 0,
                panels: 0..1,
                wanted: 0..width,
                sums: sums.as_mut_ptr(),
                kept: true,
                add: false,
                targets: &[],
                corner: 0,
            };
            // SAFETY: the sides hold `steps` rows, the sums a tile.
            unsafe { kernel.multiply_row(&row) };
            next += 1;
        }
        RUN * steps * rows * width
    })
}
