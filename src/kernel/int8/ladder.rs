//! Measures the rate of products with operands in registers and in each level of the memory, for
//! benchmarks.

use std::fmt;
use std::time::{Duration, Instant};

use super::tile::{Block, DEPTH, PANEL, STEP, Slice, WIDTH};
use super::{Isa, Kernel, Moduli, Operands};
use crate::base::{Result, Rng, Workspace};

/// Where an operand comes from.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
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

/// Rates of products on registers alone and with operands at each level.
#[derive(Debug, Clone, PartialEq)]
pub struct Ladder {
    /// Multiplications of residues per second on registers alone; `None` for AVX2 and the portable
    /// kernel.
    pub registers: Option<f64>,
    /// Those on huge pages first, each from the fastest level to the slowest.
    pub rungs: Vec<Rung>,
}

impl Ladder {
    /// Measures each rung for about a tenth of a second and keeps the fastest run; takes 260 MiB of
    /// memory. Measures the portable kernel if the machine refuses `isa` ([`Isa::refusal`]).
    ///
    /// # Errors
    /// [`Error::OutOfMemory`](crate::Error::OutOfMemory).
    ///
    /// ```no_run
    /// use catamaran::kernel::int8::{Isa, Ladder};
    ///
    /// let ladder = Ladder::measure(Isa::best())?;
    /// for rung in &ladder.rungs {
    ///     println!("{} x {}: {:.2e} a second", rung.left, rung.right, rung.rate);
    /// }
    /// # Ok::<(), catamaran::Error>(())
    /// ```
    pub fn measure(isa: Isa) -> Result<Self> {
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
        Ok(Self { registers, rungs })
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
    residues: Vec<Block<i8>>,
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
        let modulus = &Moduli::new(2).list[1];
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
        let ladder = Ladder::measure(Isa::best()).unwrap();
        assert_eq!(ladder.rungs.len(), 20);
        assert!(ladder.rungs.iter().all(|rung| rung.rate > 0.0));
        assert!(ladder.registers.is_none_or(|rate| rate > 0.0));
    }
}
