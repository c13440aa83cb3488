//! Measures the rate of products with operands in registers and in each level of the memory, and
//! those of the other steps, for benchmarks.

use std::fmt;
use std::hint::black_box;
use std::time::{Duration, Instant};

use super::tile::{DEPTH, PANEL, PanelBlock, Powers, STEP, Slice, Tile, WIDTH};
use super::{IntegerIsa, Kernel, Moduli, Next, Operands};
use crate::base::{Result, Rng, Workspace};

/// Where an operand comes from.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[non_exhaustive]
pub enum Level {
    /// The first-level data cache: an operand of at most 32 KiB.
    First,
    /// The second-level cache: an operand of 512 KiB.
    Second,
    /// Main memory: an operand of 256 MiB.
    Memory,
}

impl fmt::Display for Level {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.pad(match self {
            Self::First => "L1",
            Self::Second => "L2",
            Self::Memory => "memory",
        })
    }
}

/// The rate of products with operands at given levels.
#[derive(Debug, Clone, PartialEq)]
pub struct Rung {
    /// Level of the left side: one panel in the first-level cache, or 16 in the second.
    pub left: Level,
    /// Level of the right side, of which products take one panel at a time.
    pub right: Level,
    /// Whether residues of earlier rows are added.
    pub continued: bool,
    /// Whether huge pages were asked for; the system may refuse.
    pub huge_pages: bool,
    /// Multiplications of residues per second, on the calling thread.
    pub rate: f64,
}

/// Entries per second of the steps around the products, for f64 and 14 moduli, with all data in the
/// first two levels of the cache, on the calling thread.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct StepRates {
    /// Entries of an operand, whose norms are computed.
    pub norms: f64,
    /// Entries of an operand, which are converted to residues.
    pub conversion: f64,
    /// Entries of C, which are computed from their residues.
    pub recombination: f64,
}

/// Rates of products on registers alone and with operands at each level, and of the other steps.
#[derive(Debug, Clone, PartialEq)]
pub struct Ladder {
    /// Multiplications of residues per second on registers alone; `None` for AVX2 and the portable
    /// kernel.
    pub registers: Option<f64>,
    /// Those on huge pages first, each from the fastest level to the slowest.
    pub rungs: Vec<Rung>,
    /// Rates of the other steps.
    pub steps: StepRates,
}

impl Ladder {
    /// Measures each rung for about a tenth of a second and keeps the fastest run; takes 260 MiB of
    /// memory. Measures the portable kernel if the machine refuses `isa` ([`IntegerIsa::refusal`]).
    ///
    /// # Errors
    /// [`Error::OutOfMemory`](crate::Error::OutOfMemory).
    ///
    /// ```no_run
    /// use catamaran::kernel::int8::{IntegerIsa, Ladder};
    ///
    /// let ladder = Ladder::measure(IntegerIsa::best())?;
    /// for rung in &ladder.rungs {
    ///     println!("{} x {}: {:.2e} a second", rung.left, rung.right, rung.rate);
    /// }
    /// # Ok::<(), catamaran::Error>(())
    /// ```
    pub fn measure(isa: IntegerIsa) -> Result<Self> {
        let kernel = isa.kernel();
        let _session = kernel.session();
        let registers = kernel.spin(1).map(|_| {
            fastest(|| {
                const COUNT: usize = 1 << 27;
                kernel.spin(COUNT).unwrap_or(COUNT)
            })
        });
        let mut rungs = Vec::new();
        for huge_pages in [true, false] {
            let mut data = Data::new(huge_pages)?;
            for (left, right) in [
                (Level::First, Level::First),
                (Level::Second, Level::First),
                (Level::First, Level::Second),
                (Level::Second, Level::Second),
                (Level::Second, Level::Memory),
            ] {
                for continued in [false, true] {
                    let rate = data.rate(kernel, left, right, continued);
                    rungs.push(Rung { left, right, continued, huge_pages, rate });
                }
            }
        }
        Ok(Self { registers, rungs, steps: StepRates::measure(kernel) })
    }
}

impl StepRates {
    fn measure(kernel: &dyn Kernel) -> Self {
        const MODULI: usize = 14;
        /// Tiles, or blocks of C, per run.
        const RUN: usize = 64;
        let moduli = Moduli::of(MODULI);
        let mut rng = Rng::new(1);
        let tile = Tile(std::array::from_fn(|_| std::array::from_fn(|_| rng.normal())));
        let powers = Powers::new([54; WIDTH]);
        let mut residues = vec![[0; STEP * WIDTH]; MODULI];
        let norms = fastest(|| {
            for _ in 0..RUN {
                black_box(kernel.norms_f64(black_box(&tile)));
            }
            RUN * STEP * WIDTH
        });
        let conversion = fastest(|| {
            for _ in 0..RUN {
                let mut out: Vec<_> = residues.iter_mut().collect();
                kernel.convert_f64(black_box(&tile), &powers, &moduli.list, &mut out, false);
            }
            RUN * STEP * WIDTH
        });
        let mut block =
            || [(); 4].map(|()| [[(); WIDTH]; WIDTH].map(|row| row.map(|()| rng.bits() as i8)));
        let residues: Vec<PanelBlock<i8>> = (0..MODULI).map(|_| block()).collect();
        let residues: Vec<&PanelBlock<i8>> = residues.iter().collect();
        let mut out = [[0.0; PANEL]; PANEL];
        let recombination = fastest(|| {
            for _ in 0..RUN {
                let (residues, zeros) = (black_box(&residues), &[0; PANEL]);
                kernel.recombine(residues, moduli, zeros, zeros, Next::NONE, black_box(&mut out));
            }
            RUN * PANEL * PANEL
        });
        Self { norms, conversion, recombination }
    }
}

/// Returns the highest rate, in multiplications per second, of the runs of `work` in a tenth of a
/// second; `work` returns how many it did.
fn fastest(mut work: impl FnMut() -> usize) -> f64 {
    const LENGTH: Duration = Duration::from_millis(100);
    let (begin, mut best) = (Instant::now(), 0.0_f64);
    while begin.elapsed() < LENGTH {
        let start = Instant::now();
        let done = work();
        best = best.max(done as f64 / start.elapsed().as_secs_f64());
    }
    best
}

/// Number of panels of a side in the second-level cache.
const LEFT: usize = 16;
/// Number of panels of the right side in memory.
const FAR: usize = 8192;
/// Number of right panels per run.
const RUN: usize = 64;

/// Operands, and residues for 16 x 16 pairs of panels.
struct Data {
    memory: Workspace<f64>,
    residues: Vec<PanelBlock<i8>>,
    /// The panel of the right side in memory that comes next.
    next: usize,
}

impl Data {
    fn new(huge_pages: bool) -> Result<Self> {
        const SLICES: usize = (FAR + LEFT) * DEPTH;
        let len = SLICES * size_of::<Slice>() / size_of::<f64>();
        let mut memory =
            if huge_pages { Workspace::new(len)? } else { Workspace::on_small_pages(len)? };
        // Random data, since the CPU lowers its clock when many bits change.
        let mut rng = Rng::new(1);
        memory.as_mut_slice().fill_with(|| f64::from_bits(rng.bits()));
        Ok(Self { memory, residues: vec![[[[0; WIDTH]; WIDTH]; 4]; LEFT * LEFT], next: 0 })
    }

    fn rate(&mut self, kernel: &dyn Kernel, left: Level, right: Level, continued: bool) -> f64 {
        let modulus = &Moduli::of(2).list[1];
        let bytes = self.memory.as_slice();
        // SAFETY: any bytes are slices; the workspace is aligned for f64 and as long as stated.
        let slices = unsafe {
            let count = size_of_val(bytes) / size_of::<Slice>();
            std::slice::from_raw_parts(bytes.as_ptr().cast::<Slice>(), count)
        };
        // Half of the steps, so that both sides fit the first-level cache together.
        let depth = if right == Level::First && left == Level::First { DEPTH / 2 } else { DEPTH };
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

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_rung_has_a_rate() {
        let ladder = Ladder::measure(IntegerIsa::best()).unwrap();
        assert_eq!(ladder.rungs.len(), 20);
        assert!(ladder.rungs.iter().all(|rung| rung.rate > 0.0));
        assert!(ladder.registers.is_none_or(|rate| rate > 0.0));
        let StepRates { norms, conversion, recombination } = ladder.steps;
        assert!([norms, conversion, recombination].iter().all(|&rate| rate > 0.0));
    }
}
