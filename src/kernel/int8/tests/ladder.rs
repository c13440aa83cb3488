//! Prints the rates of products with operands in registers and in each level of the memory, and
//! those of the other steps, for every instruction set of this machine:
//!
//! ```text
//! cargo test --release -p catamaran --lib int8::tests::ladder -- --ignored --nocapture
//! ```

use std::hint::black_box;

use super::super::*;
use crate::base::{Rng, Workspace};
use crate::kernel::rate::fastest;

/// Where an operand comes from.
#[derive(Debug, Clone, Copy, PartialEq)]
enum Level {
    /// The first-level data cache: an operand of at most 32 KiB.
    First,
    /// The second-level cache: an operand of 512 KiB.
    Second,
    /// Main memory: an operand of 256 MiB.
    Memory,
}

/// Levels of the left side, which is one panel or 16, and of the right side, of which products take
/// one panel at a time.
const LEVELS: [[Level; 2]; 5] = [
    [Level::First, Level::First],
    [Level::Second, Level::First],
    [Level::First, Level::Second],
    [Level::Second, Level::Second],
    [Level::Second, Level::Memory],
];

/// Panels of a side in the second-level cache.
const LEFT: usize = 16;
/// Panels of the right side in memory.
const FAR: usize = 8192;
/// Right panels, tiles or blocks of C of a run.
const RUN: usize = 64;

#[test]
#[ignore = "measures for some seconds, in 260 MiB"]
fn rates_of_the_kernels() {
    for isa in IntegerIsa::ALL.into_iter().filter(|isa| isa.refusal().is_none()) {
        let kernel = isa.kernel();
        let _session = kernel.session();
        let peak = registers(isa);
        // A multiplication and an addition are two operations.
        let text = |rate: f64| match peak {
            Some(peak) => format!("{:9.1} GOP/s {:5.1} %", 2e-9 * rate, 100.0 * rate / peak),
            None => format!("{:9.1} GOP/s", 2e-9 * rate),
        };
        println!("\n{}: registers {}", isa.name(), peak.map_or("-".into(), text));
        let mut data = Data::new();
        for sides in LEVELS {
            for continued in [false, true] {
                let rate = data.rate(kernel, sides, continued);
                let old = if continued { "added to old residues" } else { "new" };
                let [left, right] = sides.map(|side| format!("{side:?}"));
                println!("{left:<6} x {right:<6} {} {old}", text(rate));
            }
        }
        for (step, rate) in steps(kernel) {
            println!("{step:<13} {:6.3} ns an entry (f64, in caches)", 1e9 / rate);
        }
    }
}

/// Returns the multiplications per second on registers alone; `None` for kernels without
/// AVX-512. The caller holds a session.
fn registers(isa: IntegerIsa) -> Option<f64> {
    const ROUNDS: usize = 1 << 17;
    match isa {
        #[cfg(target_arch = "x86_64")]
        IntegerIsa::Amx => Some(fastest(|| {
            // SAFETY: the CPU has the instructions, the tiles are configured, and only registers
            // are touched.
            unsafe {
                std::arch::asm!(
                    "2:",
                    "tdpbssd tmm0, tmm4, tmm6",
                    "tdpbssd tmm1, tmm4, tmm7",
                    "tdpbssd tmm2, tmm5, tmm6",
                    "tdpbssd tmm3, tmm5, tmm7",
                    "dec {rounds}",
                    "jnz 2b",
                    rounds = inout(reg) ROUNDS => _,
                    out("tmm0") _, out("tmm1") _, out("tmm2") _, out("tmm3") _,
                    options(nostack, nomem),
                );
            }
            ROUNDS * 4 * 16 * 16 * 64
        })),
        #[cfg(target_arch = "x86_64")]
        IntegerIsa::Vnni => Some(fastest(|| {
            // Twelve independent instructions fill the pipelines.
            // SAFETY: the CPU has the instructions; only registers are touched.
            unsafe {
                std::arch::asm!(
                    "2:",
                    "vpdpbusd zmm0, zmm12, zmm13",
                    "vpdpbusd zmm1, zmm12, zmm13",
                    "vpdpbusd zmm2, zmm12, zmm13",
                    "vpdpbusd zmm3, zmm12, zmm13",
                    "vpdpbusd zmm4, zmm12, zmm13",
                    "vpdpbusd zmm5, zmm12, zmm13",
                    "vpdpbusd zmm6, zmm12, zmm13",
                    "vpdpbusd zmm7, zmm12, zmm13",
                    "vpdpbusd zmm8, zmm12, zmm13",
                    "vpdpbusd zmm9, zmm12, zmm13",
                    "vpdpbusd zmm10, zmm12, zmm13",
                    "vpdpbusd zmm11, zmm12, zmm13",
                    "dec {rounds}",
                    "jnz 2b",
                    rounds = inout(reg) ROUNDS => _,
                    out("zmm0") _, out("zmm1") _, out("zmm2") _, out("zmm3") _,
                    out("zmm4") _, out("zmm5") _, out("zmm6") _, out("zmm7") _,
                    out("zmm8") _, out("zmm9") _, out("zmm10") _, out("zmm11") _,
                    options(nostack, nomem),
                );
            }
            ROUNDS * 12 * 64
        })),
        _ => None,
    }
}

/// Operands, and residues for 16 x 16 pairs of panels.
struct Data {
    memory: Workspace<f64>,
    residues: Vec<PanelBlock<i8>>,
    /// The panel of the right side in memory that comes next.
    next: usize,
}

impl Data {
    fn new() -> Self {
        let len = (FAR + LEFT) * DEPTH * size_of::<Slice>() / size_of::<f64>();
        let mut memory = Workspace::new(len).unwrap();
        // Random data, since the CPU lowers its clock when many bits change.
        let mut rng = Rng::new(1);
        memory.as_mut_slice().fill_with(|| f64::from_bits(rng.bits()));
        Self { memory, residues: vec![[[[0; WIDTH]; WIDTH]; 4]; LEFT * LEFT], next: 0 }
    }

    /// Returns the multiplications of residues per second with operands at these levels.
    fn rate(&mut self, kernel: &dyn Kernel, [left, right]: [Level; 2], continued: bool) -> f64 {
        let modulus = &Moduli::of(2).list[1];
        let bytes = self.memory.as_slice();
        // SAFETY: any bytes are slices; the workspace is aligned for f64 and as long as stated.
        let slices = unsafe {
            let count = size_of_val(bytes) / size_of::<Slice>();
            std::slice::from_raw_parts(bytes.as_ptr().cast::<Slice>(), count)
        };
        // Half of the steps, so that both sides fit the first-level cache together.
        let depth = if [left, right] == LEVELS[0] { DEPTH / 2 } else { DEPTH };
        let (lefts, rights) = slices.split_at(LEFT * DEPTH);
        let panels = if left == Level::First { 1 } else { LEFT };
        let left = &lefts[..panels * depth];
        let panel = |i: usize| &rights[i * depth..(i + 1) * depth];
        let (residues, far) = (&mut self.residues, &mut self.next);
        fastest(|| {
            for i in 0..RUN {
                let (this, next) = match right {
                    Level::First => (0, 0),
                    Level::Second => (i % LEFT, (i + 1) % LEFT),
                    Level::Memory => {
                        let this = *far;
                        *far = (this + 1) % FAR;
                        (this, *far)
                    }
                };
                let residues = &mut residues[i % LEFT * LEFT..][..panels];
                let (right, next) = (panel(this), panel(next));
                kernel.product(&Operands { left, right, next, modulus, continued }, residues);
            }
            RUN * panels * depth * PANEL * PANEL * STEP
        })
    }
}

/// Returns the entries per second of the steps around the products, for f64 and 14 moduli, with all
/// data in the first two levels of the cache.
fn steps(kernel: &dyn Kernel) -> [(&'static str, f64); 3] {
    let moduli = Moduli::of(14);
    let count = moduli.list.len();
    let mut rng = Rng::new(1);
    let tile = Tile([(); STEP].map(|()| [(); WIDTH].map(|()| rng.normal())));
    let powers = Powers::new([54; WIDTH]);
    let mut residues = vec![[0; STEP * WIDTH]; count];
    let norms = fastest(|| {
        for _ in 0..RUN {
            black_box(kernel.norms_f64(black_box(&tile)));
        }
        RUN * STEP * WIDTH
    });
    let conversion = fastest(|| {
        for _ in 0..RUN {
            let out = &mut residues.iter_mut().collect::<Vec<_>>();
            let (tile, powers, moduli) = (black_box(&tile), &powers, &moduli.list[..]);
            kernel.convert_f64(Conversion { tile, powers, moduli, out, far: false });
        }
        RUN * STEP * WIDTH
    });
    let mut block =
        || [(); 4].map(|()| [[(); WIDTH]; WIDTH].map(|row| row.map(|()| rng.bits() as i8)));
    let residues: Vec<PanelBlock<i8>> = (0..count).map(|_| block()).collect();
    let residues: Vec<&PanelBlock<i8>> = residues.iter().collect();
    let mut out = [[0.0; PANEL]; PANEL];
    let recombination = fastest(|| {
        for _ in 0..RUN {
            let (residues, rows, columns) = (&black_box(&residues)[..], &[0; PANEL], &[0; PANEL]);
            let it = Recombination { residues, moduli, rows, columns, next: Next::NONE };
            kernel.recombine(it, black_box(&mut out));
        }
        RUN * PANEL * PANEL
    });
    [("norms", norms), ("conversion", conversion), ("recombination", recombination)]
}
