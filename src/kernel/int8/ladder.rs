//! How fast products are from each level of the memory: what [`Isa`] can do at best, and what its
//! operands cost. For benchmarks.

use std::fmt;
use std::time::{Duration, Instant};

use super::tile::{Block, DEPTH, PANEL, STEP, Slice, WIDTH};
use super::{Isa, Kernel, Moduli, Operands};
use crate::base::{Result, Rng, Workspace};

/// Where an operand comes from.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Level {
    /// The first-level data cache: used again at once.
    First,
    /// The second-level cache: 512 KiB, used again and again.
    Second,
    /// Beyond: 256 MiB.
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
    /// Level of the left side: 1 panel in the first-level cache, or 16 in the second.
    pub left: Level,
    /// Level of the right side, one panel at a time.
    pub right: Level,
    /// Whether residues of earlier rows are added.
    pub continued: bool,
    /// Whether the operands are on huge pages, as far as the system gives some.
    pub huge_pages: bool,
    /// Multiplications of residues a second, on the calling thread.
    pub rate: f64,
}

/// Multiplications of residues a second on registers alone, and with operands at all levels.
#[derive(Debug, Clone, PartialEq)]
pub struct Ladder {
    /// `None` for instruction sets whose kernel is the compiler's.
    pub registers: Option<f64>,
    /// The fastest level first.
    pub rungs: Vec<Rung>,
}

impl Ladder {
    /// Measures each rung for about a tenth of a second: the fastest of several runs.
    ///
    /// # Errors
    /// [`Error::OutOfMemory`](crate::Error::OutOfMemory); it takes 600 MiB. A refused instruction
    /// set ([`Isa::refusal`]) is measured as the portable one.
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

/// Multiplications a second of the fastest of several runs of `work`, which says how many it did.
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

/// Panels of the left side in the second-level cache.
const LEFT: usize = 16;
/// Panels of the right side in memory.
const FAR: usize = 8192;
/// Panels that a run takes on the right side.
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
        // Data without a pattern: the CPU lowers its clock when many bits change.
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
        // In the first-level cache both sides have half of the steps, to fit.
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
