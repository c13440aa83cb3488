//! What will be done, as data: no threads, no matrices, nothing but shapes and counts.

use std::collections::HashMap;
use std::fmt;

use super::exact::{self, Layout};
use super::fused::{self, FusedProduct};
use super::native;
use super::options::{Accuracy, AtaOptions, SchemeChoice};
use super::recurse::{Op, Traffic, block_start, scratch_len};
use super::scheme::SchemeId;
use super::tree::{Node, Task};
use crate::base::{Error, Real, Result};
use crate::blas::{Native, Rates};
use crate::kernel::int8::{Isa, Operand};
use crate::kernel::packed::{self, Blocking};

/// How blocks are taken apart: at each node the first scheme whose blocks are not too small.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Recursion {
    /// For products of which the lower triangle is wanted, in order of preference.
    pub symmetric: Vec<SchemeId>,
    /// For general products, in order of preference.
    pub general: Vec<SchemeId>,
    /// Where it ends.
    pub base: Base,
    /// Levels of schemes with additions, at most.
    pub fast_levels: usize,
}

/// When a block is left to the back end.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Base {
    /// When the next level's blocks would have a side shorter than this (>= 1).
    Side {
        /// For general products.
        general: usize,
        /// For products of which the lower triangle is wanted: back ends need longer sides to be
        /// fast at those.
        symmetric: usize,
    },
    /// When the operands hold at most this many elements (thesis: `cache_size`).
    Cache(usize),
}

impl Base {
    /// The same side for both.
    fn side(side: usize) -> Self {
        Self::Side { general: side, symmetric: side }
    }
}

impl Recursion {
    /// No recursion at all.
    pub fn none() -> Self {
        Self { symmetric: vec![], general: vec![], base: Base::side(1), fast_levels: 0 }
    }

    /// The scheme for a node with A m x n and B m x k, or `None` for the back end.
    pub fn choose(
        &self,
        symmetric: bool,
        m: usize,
        n: usize,
        k: usize,
        fast_levels: usize,
    ) -> Option<SchemeId> {
        if let Base::Cache(size) = self.base
            && m.saturating_mul(if symmetric { n } else { n.saturating_add(k) }) <= size
        {
            return None;
        }
        let side = match self.base {
            Base::Side { symmetric: side, .. } if symmetric => side.max(1),
            Base::Side { general: side, .. } => side.max(1),
            Base::Cache(_) => 1,
        };
        let list = if symmetric { &self.symmetric } else { &self.general };
        list.iter().copied().find(|id| {
            let s = id.scheme();
            (fast_levels > 0 || !s.is_fast())
                // Splitting rows must leave long ones; not splitting them is always allowed.
                && (s.inner == 1 || m / s.inner >= side)
                && n / s.left >= side
                && k / s.right >= side
        })
    }
}

/// A plan for `C := alpha A^T A + beta C` or `C := alpha A^T B + beta C`.
///
/// It depends on the shape, the precision and the options, but never on the number of threads:
/// that is why results don't either.
#[derive(Debug, Clone, PartialEq)]
pub struct Plan {
    pub(crate) m: usize,
    pub(crate) n: usize,
    pub(crate) k: usize,
    /// Lower triangle only.
    pub(crate) symmetric: bool,
    pub(crate) scalar: &'static str,
    /// Which process computes which block of C.
    pub(crate) tree: Node,
    /// Row slabs of A, each with its own partial result, added up in order.
    pub(crate) slabs: usize,
    /// Blocks of rows that a task takes one after another, adding up in C: a tall A would otherwise
    /// need sums of blocks as tall.
    pub(crate) chunks: usize,
    pub(crate) recursion: Recursion,
    /// The exact path instead, with this many moduli.
    pub(crate) exact: Option<usize>,
    /// The native kernels instead: the recursion is flattened, there is one task.
    pub(crate) native: Option<packed::Isa>,
    /// Expected seconds on one core, and those of the classical plan.
    estimate: f64,
    classical_estimate: f64,
}

/// Growth of the max-norm error per fast level, measured on uniform, Gaussian and positive random
/// matrices (docs/algorithms/ata.md): Winograd's variant over a BLAS, and Strassen's algorithm fused.
const ERROR_GROWTH_PER_LEVEL: f64 = 1.9;
const ERROR_GROWTH_PER_FUSED_LEVEL: f64 = 2.4;

/// Elements that count as fitting the cache in the faithful mode: 2 MiB of f64, a second-level cache.
const FAITHFUL_CACHE: usize = 1 << 18;

/// Smallest side of a block when a scheme is asked for by name.
const NAMED_SIDE: usize = 256;

/// Fast levels that the native kernels fuse: more would read every block too often.
const MOST_FUSED: usize = 2;

/// Tasks of the faithful mode; the thesis takes the number of threads, which would make results
/// depend on it.
const FAITHFUL_TASKS: usize = 16;

impl Plan {
    /// The plan of [`ata`](super::ata) for A m x n.
    ///
    /// # Errors
    /// [`Error::Argument`] for options out of range.
    pub fn ata<T: Operand + packed::Operand>(
        m: usize,
        n: usize,
        options: &AtaOptions<'_>,
    ) -> Result<Self> {
        Self::new::<T>(m, n, n, true, options)
    }

    /// The plan of [`atb`](super::atb) for A m x n and B m x k.
    ///
    /// # Errors
    /// [`Error::Argument`] for options out of range.
    pub fn atb<T: Operand + packed::Operand>(
        m: usize,
        n: usize,
        k: usize,
        options: &AtaOptions<'_>,
    ) -> Result<Self> {
        Self::new::<T>(m, n, k, false, options)
    }

    fn new<T: Operand + packed::Operand>(
        m: usize,
        n: usize,
        k: usize,
        symmetric: bool,
        options: &AtaOptions<'_>,
    ) -> Result<Self> {
        check(options)?;
        check_extents(m, n, k)?;
        let machine = Machine::new::<T>(options.backend.rates());
        let fused_levels = allowed_levels(options.accuracy, ERROR_GROWTH_PER_FUSED_LEVEL);
        let native = options.backend.native().filter(|_| match options.scheme {
            SchemeChoice::Auto | SchemeChoice::Float => true,
            SchemeChoice::Winograd | SchemeChoice::Kgp4 => fused_levels <= MOST_FUSED,
            SchemeChoice::Classical | SchemeChoice::Exact => true,
            // Their tables are for an engine that keeps sums, or mirror products.
            SchemeChoice::Ata2 | SchemeChoice::Rxtx | SchemeChoice::Kgp3 => false,
        });
        let tasks = match options.scheme {
            _ if native.is_some() => 1,
            SchemeChoice::Ata2 => options.tasks.unwrap_or(FAITHFUL_TASKS),
            _ => options.tasks.unwrap_or(default_tasks(n, k)),
        };
        let tree = if symmetric { Node::symmetric(n, tasks) } else { Node::general(n, k, tasks) };
        let slabs = match options.scheme {
            SchemeChoice::Ata2 => 1,
            _ if native.is_some() => native_slabs(m, n, k),
            _ => default_slabs(m, n, k),
        };
        let tasks = tree.tasks();
        let chunks_of = |recursion: &Recursion| match options.scheme {
            SchemeChoice::Ata2 => 1,
            _ if native.is_some() || recursion.fast_levels == 0 => 1,
            _ => (m / slabs).div_ceil(n.max(k).max(1)).max(1),
        };
        let seconds = |recursion: &Recursion| {
            if let Some(native) = native {
                let op = if symmetric { Op::Syrk } else { Op::Gemm };
                let program = fused::products(recursion, op, m.div_ceil(slabs), n, k);
                return slabs as f64 * native_seconds::<T>(native, &program, n, k, symmetric);
            }
            let mut memory = HashMap::new();
            let parts = slabs * chunks_of(recursion);
            let rows = m.div_ceil(parts);
            let one = |t: &Task| {
                let (op, n, k) = (t.op(true), t.rows.len(), t.cols.len());
                machine.seconds(recursion, op, [rows, n, k], recursion.fast_levels, &mut memory)
            };
            parts as f64 * tasks.iter().map(one).sum::<f64>()
        };
        let classical = Recursion::none();
        let classical_estimate = seconds(&classical);
        let (general_scheme, allowed) = match native {
            Some(_) => (SchemeId::Strassen, fused_levels.min(MOST_FUSED)),
            None => {
                let allowed = allowed_levels(options.accuracy, ERROR_GROWTH_PER_LEVEL);
                (SchemeId::Winograd, allowed)
            }
        };
        let recursion = match options.scheme {
            SchemeChoice::Auto | SchemeChoice::Float => {
                // Fused levels are not quite as cheap as the model of their traffic says.
                let gain_asked = if native.is_some() { 0.96 } else { 0.98 };
                let shortest = tasks.iter().map(|t| t.rows.len().min(t.cols.len())).min();
                let shortest = shortest.unwrap_or(0).min(m);
                let candidates = candidates(options.leaf, shortest, allowed, general_scheme);
                let best = candidates
                    .into_iter()
                    .map(|r| (seconds(&r), r))
                    .min_by(|a, b| a.0.total_cmp(&b.0))
                    // Within the error of the model the simpler way is the better one.
                    .filter(|(s, _)| *s < gain_asked * classical_estimate);
                best.map_or(classical, |(_, recursion)| recursion)
            }
            SchemeChoice::Classical | SchemeChoice::Exact => classical,
            SchemeChoice::Ata2 => Recursion {
                symmetric: vec![SchemeId::Ata2],
                general: vec![SchemeId::Strassen],
                base: Base::Cache(
                    options.leaf.map_or(FAITHFUL_CACHE, |side| side.saturating_mul(side)),
                ),
                // The thesis knows no limit; who names one gets it.
                fast_levels: match options.accuracy {
                    Accuracy::Default => usize::MAX,
                    _ => allowed,
                },
            },
            scheme => {
                let symmetric = match scheme {
                    SchemeChoice::Rxtx => vec![SchemeId::Rxtx, SchemeId::Split],
                    SchemeChoice::Kgp4 => vec![SchemeId::Kgp4, SchemeId::Split],
                    SchemeChoice::Kgp3 => vec![SchemeId::Kgp3, SchemeId::Split],
                    _ => vec![SchemeId::Split],
                };
                Recursion {
                    symmetric,
                    general: vec![general_scheme],
                    base: Base::side(options.leaf.unwrap_or(NAMED_SIDE)),
                    fast_levels: allowed,
                }
            }
        };
        let chunks = chunks_of(&recursion);
        let mut estimate = seconds(&recursion);
        let moduli = exact_moduli::<T>(options.accuracy);
        let exact_estimate = exact::estimate(Isa::best(), [m, n, k], moduli, symmetric);
        let wanted = options.reproducible
            || options.scheme == SchemeChoice::Exact
            || options.accuracy == Accuracy::Max && options.scheme == SchemeChoice::Auto;
        let better = options.scheme == SchemeChoice::Auto
            && options.accuracy != Accuracy::Classical
            && exact_estimate < 0.98 * estimate;
        let exact = (wanted || better).then_some(moduli);
        if exact.is_some() {
            estimate = exact_estimate;
        }
        let scalar = T::NAME;
        Ok(Self {
            m,
            n,
            k,
            symmetric,
            scalar,
            tree,
            slabs,
            chunks,
            recursion,
            exact,
            native: native.map(Native::isa),
            estimate,
            classical_estimate,
        })
    }

    /// How the exact path divides the work, if it is taken; `same` when B is A.
    pub(crate) fn exact_layout<T: Real>(&self, same: bool) -> Option<Layout> {
        let extents = [self.m, self.n, self.k];
        self.exact.map(|n| Layout::new(extents, size_of::<T>(), n, self.symmetric, same))
    }

    /// Elements of scratch for `threads` threads; `same` when B is A.
    pub(crate) fn scratch_len<T: Operand + packed::Operand>(
        &self,
        threads: usize,
        same: bool,
    ) -> usize {
        if let Some(layout) = self.exact_layout::<T>(same) {
            return exact::scratch_len::<T>([self.m, self.n, self.k], &layout, threads);
        }
        if let Some(isa) = self.native {
            return native::plan_scratch_len::<T>(isa, self, same, threads);
        }
        self.lane_scratch_len(same) * self.lanes(threads) + (self.slabs - 1) * self.n * self.k
    }

    /// What the whole is; `same` when B is A.
    pub(crate) fn op(&self, same: bool) -> Op {
        match (self.symmetric, same) {
            (true, true) => Op::Syrk,
            (true, false) => Op::Gemmt,
            (false, _) => Op::Gemm,
        }
    }

    /// Elements of scratch of one thread.
    pub(crate) fn lane_scratch_len(&self, same: bool) -> usize {
        let mut longest = 0;
        for task in self.tree.tasks() {
            let parts = self.slabs * self.chunks;
            for rows in [self.m / parts, self.m.div_ceil(parts)] {
                let (n, k) = (task.rows.len(), task.cols.len());
                longest = longest.max(scratch_len(&self.recursion, task.op(same), rows, n, k));
            }
        }
        longest
    }

    /// Threads that can be busy.
    pub(crate) fn lanes(&self, threads: usize) -> usize {
        threads.min(self.slabs * self.tree.tasks().len()).max(1)
    }

    /// The row chunks of slab `i`.
    pub(crate) fn chunks(&self, i: usize) -> impl Iterator<Item = std::ops::Range<usize>> {
        let start = |j| block_start(self.m, self.slabs * self.chunks, j);
        (i * self.chunks..(i + 1) * self.chunks).map(move |j| start(j)..start(j + 1))
    }

    /// Whether it is the exact path, which is the same bytes on every machine.
    pub fn is_exact(&self) -> bool {
        self.exact.is_some()
    }

    /// Whether any product is computed with fewer multiplications than the classical count.
    pub fn is_fast(&self) -> bool {
        if self.is_exact() {
            return false;
        }
        let Self { recursion, m, slabs, .. } = self;
        let any =
            |t: &Task| uses_fast(recursion, t.op(true), m / slabs, t.rows.len(), t.cols.len());
        self.tree.tasks().iter().any(any)
    }
}

/// Whether a node of this shape leads to a scheme with additions.
fn uses_fast(recursion: &Recursion, op: Op, m: usize, n: usize, k: usize) -> bool {
    let Some(id) = recursion.choose(op.symmetric(), m, n, k, recursion.fast_levels) else {
        return false;
    };
    let s = id.scheme();
    s.is_fast()
        || s.products.iter().any(|p| {
            let (m, n, k) = (m.div_ceil(s.inner), n.div_ceil(s.left), k.div_ceil(s.right));
            uses_fast(recursion, op.of_product(p.kind), m, n, k)
        })
}

pub(super) fn check(options: &AtaOptions<'_>) -> Result<()> {
    let refuse = |what, why: &str| Err(Error::Argument { what, why: why.into() });
    match options.accuracy {
        Accuracy::Bounded(f) if !f.is_finite() || f < 1.0 => {
            refuse("accuracy", "the error factor must be finite and at least 1")
        }
        _ if options.reproducible
            && !matches!(options.scheme, SchemeChoice::Auto | SchemeChoice::Exact) =>
        {
            refuse("scheme", "only the exact one is reproducible on every machine")
        }
        _ if options.leaf == Some(0) => refuse("leaf", "must be at least 1"),
        _ if options.tasks.is_some_and(|t| t == 0 || t > MAX_TASKS) => {
            refuse("tasks", &format!("must be between 1 and {MAX_TASKS}"))
        }
        _ => Ok(()),
    }
}

/// Matrices that no memory holds are refused before their sizes overflow.
fn check_extents(m: usize, n: usize, k: usize) -> Result<()> {
    const MAX_ENTRIES: usize = isize::MAX as usize / 64;
    for (rows, cols) in [(m, n), (m, k), (n, k)] {
        if rows.checked_mul(cols).is_none_or(|entries| entries > MAX_ENTRIES) {
            let bytes = rows.saturating_mul(cols).saturating_mul(4);
            return Err(Error::OutOfMemory { bytes });
        }
    }
    Ok(())
}

/// More would only cost memory.
const MAX_TASKS: usize = 1 << 16;

fn allowed_levels(accuracy: Accuracy, growth: f64) -> usize {
    match accuracy {
        Accuracy::Max | Accuracy::Classical => 0,
        Accuracy::Bounded(factor) => (factor.ln() / growth.ln()) as usize,
        Accuracy::Default => allowed_levels(Accuracy::Bounded(4.0), growth),
        Accuracy::Fast => usize::MAX,
    }
}

/// Moduli of the exact path; the table of [`Accuracy`].
fn exact_moduli<T: Real>(accuracy: Accuracy) -> usize {
    let (most, default, least) = if size_of::<T>() == 8 { (15, 14, 13) } else { (8, 7, 6) };
    match accuracy {
        Accuracy::Max | Accuracy::Classical => most,
        Accuracy::Bounded(factor) if factor < 8.0 => default,
        Accuracy::Default => default,
        Accuracy::Bounded(_) | Accuracy::Fast => least,
    }
}

/// Few enough tasks that blocks stay long, for long blocks are what back ends are fast at; a caller
/// with many cores may ask for more.
fn default_tasks(n: usize, k: usize) -> usize {
    match n.min(k) {
        0..256 => 1,
        256..1024 => 2,
        1024..12288 => 4,
        12288..24576 => 16,
        _ => 64,
    }
}

/// Slabs for a tall A, whose C offers too few tasks.
fn default_slabs(m: usize, n: usize, k: usize) -> usize {
    let side = n.max(k).max(1);
    if side <= 768 { (m / (16 * side).max(2048)).clamp(1, 8) } else { 1 }
}

/// Slabs for a C that is too small to be shared by threads: a power of two, long enough for the sum of
/// their results not to matter.
fn native_slabs(m: usize, n: usize, k: usize) -> usize {
    const SMALL: usize = 256;
    const SHORTEST: usize = 500;
    /// Rows from which on many threads are worth their while.
    const MANY: usize = 50_000;
    let side = n.max(k);
    if side > SMALL {
        return 1;
    }
    let most = if m < MANY { 4 } else { 16 };
    let slabs = m / SHORTEST.max(5 * side);
    slabs.checked_ilog2().map_or(1, |log| 1 << log).min(most)
}

/// Seconds on one core of a flattened recursion.
fn native_seconds<T: packed::Operand>(
    native: &Native,
    program: &[FusedProduct],
    n: usize,
    k: usize,
    symmetric: bool,
) -> f64 {
    let geometry = T::kernel(native.isa()).geometry();
    let budget = native::budget::<T>(n, k);
    let one = |p: &FusedProduct| {
        let chunks = Blocking::new(geometry, size_of::<T>(), p.shape, budget).chunks(p.shape);
        p.seconds(&native.rates(), size_of::<T>() as f64, chunks, symmetric)
    };
    program.iter().map(one).sum()
}

/// The recursions worth a look, for blocks of C with sides of `shortest` or more.
fn candidates(
    leaf: Option<usize>,
    shortest: usize,
    allowed: usize,
    general_scheme: SchemeId,
) -> Vec<Recursion> {
    /// Shorter blocks never gain, and estimating them would take a visible part of the time.
    const WORTHWHILE: usize = 768;
    let mut found = Vec::new();
    if leaf.is_none() && shortest < WORTHWHILE {
        return found;
    }
    for general in leaf.map_or(vec![256, 384, 512, 768, 1024, 2048], |l| vec![l]) {
        for symmetric in leaf.map_or(vec![512, 1024, 2048, 4096], |l| vec![l]) {
            for fast_levels in 1..=allowed.min(5) {
                for symmetric_schemes in
                    [vec![SchemeId::Split], vec![SchemeId::Kgp4, SchemeId::Split]]
                {
                    found.push(Recursion {
                        symmetric: symmetric_schemes,
                        general: vec![general_scheme],
                        base: Base::Side { general, symmetric },
                        fast_levels,
                    });
                }
            }
        }
    }
    found
}

/// The cost model: seconds on one core.
struct Machine {
    rates: Rates,
    scalar_bytes: f64,
}

impl Machine {
    fn new<T: Real>(rates: Rates) -> Self {
        Self { rates, scalar_bytes: size_of::<T>() as f64 }
    }

    /// Seconds of a product left to the back end.
    fn leaf(&self, op: Op, shape: [usize; 3]) -> f64 {
        let [m, n, k] = shape.map(|side| side.max(1) as f64);
        let Rates { gemm_flops, gemm_half_side, syrk_flops, syrk_half_side, .. } = self.rates;
        let seconds = match op {
            Op::Gemm => {
                2.0 * m * n * k / gemm_flops * (1.0 + gemm_half_side / n + gemm_half_side / k)
            }
            Op::Syrk | Op::Gemmt => m * n * n / syrk_flops * (1.0 + syrk_half_side / n),
        };
        // The rates are those of f64.
        seconds * self.scalar_bytes / 8.0
    }

    fn seconds(
        &self,
        recursion: &Recursion,
        op: Op,
        shape: [usize; 3],
        levels: usize,
        memory: &mut HashMap<(Op, [usize; 3], usize), f64>,
    ) -> f64 {
        let [m, n, k] = shape;
        let Some(id) = recursion.choose(op.symmetric(), m, n, k, levels) else {
            return self.leaf(op, shape);
        };
        if let Some(&known) = memory.get(&(op, shape, levels)) {
            return known;
        }
        let scheme = id.scheme();
        let below = levels - usize::from(scheme.is_fast());
        let child = [m.div_ceil(scheme.inner), n.div_ceil(scheme.left), k.div_ceil(scheme.right)];
        let [cm, cn, ck] = child.map(|x| x as f64);
        let mut total = 0.0;
        for product in &scheme.products {
            let child_op = op.of_product(product.kind);
            total += self.seconds(recursion, child_op, child, below, memory);
        }
        let traffic = Traffic::of(scheme, op);
        let moved = traffic.p * cm * cn + traffic.q * cm * ck + traffic.m * cn * ck;
        total += moved * self.scalar_bytes / self.rates.add_bytes;
        memory.insert((op, shape, levels), total);
        total
    }
}

impl fmt::Display for Plan {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Self { m, n, k, scalar, slabs, recursion, .. } = self;
        let tasks = self.tree.tasks();
        if self.symmetric {
            writeln!(f, "C = A^T A, A {m} x {n}, {scalar}")?;
        } else {
            writeln!(f, "C = A^T B, A {m} x {n}, B {m} x {k}, {scalar}")?;
        }
        if let Some(moduli) = self.exact {
            writeln!(f, "exact      modulo {moduli} numbers of 8 bits, by {}", Isa::best().name())?;
            return self.write_estimate(f);
        }
        let slab_word = if *slabs == 1 { "slab" } else { "slabs" };
        match self.native {
            Some(isa) => {
                let products = fused::products(recursion, self.op(true), m / slabs, *n, *k).len();
                let products = match products {
                    1 => "one product".to_owned(),
                    _ => format!("{products} products with the additions fused"),
                };
                let name = isa.name();
                writeln!(f, "kernels    {name}, {products}, {slabs} {slab_word} of rows")?;
            }
            None => writeln!(
                f,
                "tasks      {} blocks of C on {} levels, {slabs} {slab_word} of rows",
                tasks.len(),
                self.tree.depth(),
            )?,
        }
        let names = |ids: &[SchemeId]| {
            if ids.is_empty() {
                return "back end".to_owned();
            }
            ids.iter().map(ToString::to_string).collect::<Vec<_>>().join(", then ")
        };
        writeln!(f, "symmetric  {}", names(&recursion.symmetric))?;
        writeln!(f, "general    {}", names(&recursion.general))?;
        match recursion.base {
            _ if recursion.symmetric.is_empty() && recursion.general.is_empty() => {}
            Base::Side { general, symmetric } => writeln!(
                f,
                "ends       when a block would be under {general} long, {symmetric} if symmetric"
            )?,
            Base::Cache(size) => writeln!(f, "ends       when the operands hold {size} elements")?,
        }
        match recursion.fast_levels {
            0 => writeln!(f, "fast       no level: classical products only")?,
            _ if !self.is_fast() => writeln!(f, "fast       no level: the blocks are too short")?,
            usize::MAX => writeln!(f, "fast       as many levels as fit")?,
            levels => writeln!(f, "fast       at most {levels} levels")?,
        }
        if self.native.is_none() {
            writeln!(
                f,
                "scratch    {} elements a thread, {} for partial results",
                self.lane_scratch_len(self.symmetric),
                (slabs - 1) * n * k
            )?;
        }
        self.write_estimate(f)
    }
}

impl Plan {
    fn write_estimate(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(
            f,
            "estimate   {:.3} s on one core ({:.3} s classical)",
            self.estimate, self.classical_estimate
        )
    }
}
