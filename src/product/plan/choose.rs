//! Chooses the strategy of a product: the cheapest one within the requested accuracy.

use super::cost::{FusedCost, RecursionCost};
use super::fused::{self, FusedProduct};
use super::problem::{Op, Problem};
use super::recursion::{Base, Recursion};
use super::strategy::{Exact, Fused, RowSlabs, Slab, Strategy, Tasks};
use super::tree::Node;
use crate::base::{Real, even_part};
use crate::blas::{BlasReal, Native};
use crate::kernel::int8;
use crate::product::exact::{self, ExactLayout};
use crate::product::options::{Accuracy, AtaOptions, SchemeChoice};
use crate::product::schemes::SchemeId;

/// A strategy and the seconds on one core that it is expected to take.
pub(super) struct Choice {
    pub strategy: Strategy,
    pub seconds: f64,
    /// Expected seconds of products in floating point without fast levels.
    pub classical_seconds: f64,
}

/// Growth of the max-norm error per fast level, measured on uniform, Gaussian and positive random
/// matrices (docs/algorithms/ata.md): Winograd's variant over a BLAS, and Strassen's algorithm
/// fused.
const ERROR_GROWTH_PER_LEVEL: f64 = 1.9;
const ERROR_GROWTH_PER_FUSED_LEVEL: f64 = 2.4;

/// Growth of the error that [`Accuracy::Default`] allows.
const DEFAULT_GROWTH: f64 = 4.0;

/// Base case of the faithful mode: below this side one more level cost more time than it saved,
/// with OpenBLAS and with our own kernels as leaves (docs/decisions/0003).
const FAITHFUL_BASE: Base = Base { general: 1536, symmetric: 1536 };

/// Smallest side of a block for a scheme that is requested by name.
const NAMED_SIDE: usize = 256;

/// Most fast levels that our own kernels fuse: more would read every block too often.
const MOST_FUSED: usize = 2;

/// Share of the classical time that a fast plan must stay below: within the error of the models the
/// simpler plan is better. Fused levels are not quite as cheap as the model of their traffic
/// predicts.
const GAIN_OF_FUSED: f64 = 0.96;
const GAIN_OF_TASKS: f64 = 0.98;
const GAIN_OF_EXACT: f64 = 0.98;

/// Returns the strategy for `problem`. Small products are chosen inline: they take no longer than
/// the choice.
#[inline]
pub(super) fn choose<T: BlasReal>(problem: Problem, options: &AtaOptions<'_>) -> Choice {
    match direct_kernels(&problem, options) {
        Some(native) => direct(native),
        None => cheapest_strategy::<T>(native_for(options), problem, options),
    }
}

/// Returns the strategy for a `problem` that is worth an estimate.
#[inline(never)]
fn cheapest_strategy<T: BlasReal>(
    native: Option<&Native>,
    problem: Problem,
    options: &AtaOptions<'_>,
) -> Choice {
    let float = |options: &AtaOptions<'_>| match native {
        Some(native) => fused::<T>(native, problem, options),
        None => tasks::<T>(problem, options),
    };
    if options.asks_for_exact() {
        let classical = AtaOptions { scheme: SchemeChoice::Classical, ..options.clone() };
        return exact::<T>(problem, options, float(&classical).classical_seconds);
    }
    let float = float(options);
    if options.scheme != SchemeChoice::Auto || options.accuracy == Accuracy::Classical {
        return float;
    }
    let exact = exact::<T>(problem, options, float.classical_seconds);
    if exact.seconds < GAIN_OF_EXACT * float.seconds { exact } else { float }
}

/// Returns our own kernels, when they are the back end and fuse the scheme.
fn native_for<'o>(options: &'o AtaOptions<'_>) -> Option<&'o Native> {
    options.backend.native().filter(|_| match options.scheme {
        SchemeChoice::Auto | SchemeChoice::Float => true,
        SchemeChoice::Winograd | SchemeChoice::Kgp4 => {
            allowed_levels(options.accuracy, ERROR_GROWTH_PER_FUSED_LEVEL) <= MOST_FUSED
        }
        SchemeChoice::Classical | SchemeChoice::Exact => true,
        // The tables of these need an engine that keeps sums, or mirror products.
        SchemeChoice::Ata2 | SchemeChoice::Rxtx | SchemeChoice::Kgp3 => false,
    })
}

/// Returns our own kernels if the product ends before threads could share it, and the options leave
/// the choice.
#[inline]
pub(crate) fn direct_kernels<'o>(
    problem: &Problem,
    options: &'o AtaOptions<'_>,
) -> Option<&'o Native> {
    let free = matches!(
        options.scheme,
        SchemeChoice::Auto | SchemeChoice::Float | SchemeChoice::Classical
    ) && !options.asks_for_exact();
    let small = |native: &&Native| native.is_small(problem.m, problem.n, problem.k, problem.same());
    native_for(options).filter(|_| free).filter(small)
}

fn direct(native: &Native) -> Choice {
    /// Most seconds of a direct product.
    const SECONDS: f64 = 2e-4;
    let strategy = Strategy::Direct(native.isa());
    Choice { strategy, seconds: SECONDS, classical_seconds: SECONDS }
}

/// Returns the fused strategy on our own kernels.
fn fused<T: BlasReal>(native: &Native, problem: Problem, options: &AtaOptions<'_>) -> Choice {
    let Problem { op, m, n, k } = problem;
    let slabs = fused_slabs(m, n, k);
    let budget = packing_budget::<T>(n, k, options.memory);
    let cost = FusedCost {
        rates: native.rates(),
        geometry: T::kernel(native.isa()).geometry(),
        scalar_bytes: size_of::<T>(),
        budget,
        symmetric: op.symmetric(),
    };
    let program = |recursion: &Recursion, rows| fused::products(recursion, op, rows, n, k);
    let seconds = |recursion: &Recursion| {
        let shape = [m.div_ceil(slabs), n, k];
        slabs as f64 * fused::total(recursion, op, shape, |product| cost.product(product))
    };
    let classical = Recursion::none();
    let classical_seconds = seconds(&classical);
    let allowed = allowed_levels(options.accuracy, ERROR_GROWTH_PER_FUSED_LEVEL).min(MOST_FUSED);
    let (recursion, seconds) = match options.scheme {
        SchemeChoice::Auto | SchemeChoice::Float => {
            let found = candidates(options.leaf, m.min(n).min(k), allowed, SchemeId::Strassen);
            let found = found.into_iter().map(|recursion| recursion.of_few_triangles(n)).collect();
            cheapest(found, seconds, GAIN_OF_FUSED, classical_seconds)
        }
        SchemeChoice::Winograd | SchemeChoice::Kgp4 => {
            let named = named(options, SchemeId::Strassen, allowed).of_few_triangles(n);
            let seconds = seconds(&named);
            (named, seconds)
        }
        _ => (classical.clone(), classical_seconds),
    };
    let slab = |i: usize| {
        let rows = even_part(0..m, slabs, i);
        let fast = recursion.is_fast(op, rows.len(), n, k);
        let program_of = |recursion| -> Vec<FusedProduct> { program(recursion, rows.len()) };
        Slab {
            program: program_of(&recursion),
            classical: if fast { program_of(&classical) } else { Vec::new() },
            rows: rows.clone(),
        }
    };
    let slabs = (0..slabs).map(slab).collect();
    let strategy = Strategy::Fused(Box::new(Fused { isa: native.isa(), recursion, budget, slabs }));
    Choice { strategy, seconds, classical_seconds }
}

/// Returns the recursive strategy over any back end.
fn tasks<T: BlasReal>(problem: Problem, options: &AtaOptions<'_>) -> Choice {
    let Problem { op, m, n, k } = problem;
    let faithful = options.scheme == SchemeChoice::Ata2;
    let default = if faithful { faithful_tasks(op, n, k) } else { default_tasks(n, k) };
    let count = options.tasks.unwrap_or(default);
    let tree = if op.symmetric() { Node::symmetric(n, count) } else { Node::general(n, k, count) };
    let mut tasks = tree.tasks();
    let slabs = if faithful { 1 } else { task_slabs(m, n, k) };
    let chunks_of = |recursion: &Recursion| match recursion.fast_levels {
        0 => 1,
        _ if faithful => 1,
        _ => (m / slabs).div_ceil(n.max(k).max(1)).max(1),
    };
    let mut cost = RecursionCost::new::<T>(options.backend.rates());
    let mut seconds = |recursion: &Recursion| {
        let parts = slabs * chunks_of(recursion);
        let rows = m.div_ceil(parts);
        let one = |t: &super::tree::Task| {
            cost.seconds(recursion, t.op(op), [rows, t.rows.len(), t.cols.len()])
        };
        parts as f64 * tasks.iter().map(one).sum::<f64>()
    };
    let classical = Recursion::none();
    let classical_seconds = seconds(&classical);
    let allowed = allowed_levels(options.accuracy, ERROR_GROWTH_PER_LEVEL);
    let mut guarded = false;
    let (recursion, seconds) = match options.scheme {
        SchemeChoice::Auto | SchemeChoice::Float => {
            guarded = true;
            let shortest = tasks.iter().map(|t| t.rows.len().min(t.cols.len())).min();
            let shortest = shortest.unwrap_or(0).min(m);
            let found = candidates(options.leaf, shortest, allowed, SchemeId::Winograd);
            cheapest(found, seconds, GAIN_OF_TASKS, classical_seconds)
        }
        SchemeChoice::Classical | SchemeChoice::Exact => (classical, classical_seconds),
        _ => {
            let recursion = if faithful {
                thesis(options, allowed)
            } else {
                named(options, SchemeId::Winograd, allowed)
            };
            let seconds = seconds(&recursion);
            (recursion, seconds)
        }
    };
    let cut = RowSlabs { rows: m, slabs, chunks: chunks_of(&recursion) };
    let rows = m / (slabs * cut.chunks);
    let fast = tasks.iter().any(|t| recursion.is_fast(t.op(op), rows, t.rows.len(), t.cols.len()));
    tasks.sort_by(|a, b| b.cost().total_cmp(&a.cost()));
    let strategy = Strategy::Tasks(Box::new(Tasks { tree, tasks, cut, recursion, fast, guarded }));
    Choice { strategy, seconds, classical_seconds }
}

/// Returns the exact strategy.
fn exact<T: BlasReal>(
    problem: Problem,
    options: &AtaOptions<'_>,
    classical_seconds: f64,
) -> Choice {
    let Problem { op, m, n, k } = problem;
    let isa = int8::IntegerIsa::best();
    let (symmetric, same) = (op.symmetric(), problem.same());
    let moduli = exact_moduli::<T>(options.accuracy, symmetric);
    let sides = [m, n, k];
    let layout =
        ExactLayout::within(options.memory, sides, size_of::<T>(), moduli, symmetric, same);
    // Without a limit of memory only matrices that take days are converted more than once.
    let conversions = if options.memory.is_some() { layout.conversions() } else { 1.0 };
    let seconds = exact::estimate(isa, sides, moduli, symmetric, conversions);
    let bytes = exact::small::scratch_len::<T>(sides, same).saturating_mul(size_of::<T>());
    let small = exact::small::seconds::<T>(isa, sides, moduli, symmetric)
        .filter(|_| options.memory.is_none_or(|most| bytes <= most));
    let strategy = Strategy::Exact(Box::new(Exact { isa, layout, small: small.is_some() }));
    let seconds = match options.scheme {
        // The estimate of small products is too rough for a choice between kinds of schemes.
        SchemeChoice::Auto => seconds,
        _ => small.unwrap_or(seconds),
    };
    Choice { strategy, seconds, classical_seconds }
}

/// Returns the cheapest recursion if it takes less than `gain` of the classical time, else none.
fn cheapest(
    found: Vec<Recursion>,
    mut seconds: impl FnMut(&Recursion) -> f64,
    gain: f64,
    classical_seconds: f64,
) -> (Recursion, f64) {
    found
        .into_iter()
        .map(|recursion| (seconds(&recursion), recursion))
        .min_by(|a, b| a.0.total_cmp(&b.0))
        .filter(|(seconds, _)| *seconds < gain * classical_seconds)
        .map_or((Recursion::none(), classical_seconds), |(seconds, best)| (best, seconds))
}

/// Returns the recursion of a scheme that the caller named.
fn named(options: &AtaOptions<'_>, general: SchemeId, fast_levels: usize) -> Recursion {
    let symmetric = match options.scheme {
        SchemeChoice::Rxtx => vec![SchemeId::Rxtx, SchemeId::Split],
        SchemeChoice::Kgp4 => vec![SchemeId::Kgp4, SchemeId::Split],
        SchemeChoice::Kgp3 => vec![SchemeId::Kgp3, SchemeId::Split],
        _ => vec![SchemeId::Split],
    };
    let base = Base::side(options.leaf.unwrap_or(NAMED_SIDE));
    Recursion { symmetric, general: vec![general], base, fast_levels }
}

/// Returns algorithm 8.1 of the thesis.
fn thesis(options: &AtaOptions<'_>, allowed: usize) -> Recursion {
    Recursion {
        symmetric: vec![SchemeId::Ata2],
        general: vec![SchemeId::Strassen],
        base: options.leaf.map_or(FAITHFUL_BASE, Base::side),
        // The thesis has no limit; an accuracy that the caller sets limits the levels.
        fast_levels: if options.accuracy == Accuracy::Default { usize::MAX } else { allowed },
    }
}

/// Returns the recursions worth a look, for blocks of C with sides of `shortest` or more.
fn candidates(
    leaf: Option<usize>,
    shortest: usize,
    allowed: usize,
    general_scheme: SchemeId,
) -> Vec<Recursion> {
    /// Shorter blocks never gain, and estimating them would take a visible part of the time.
    const WORTHWHILE: usize = 768;
    /// Deeper recursions never gain.
    const DEEPEST: usize = 5;
    let mut found = Vec::new();
    if leaf.is_none() && shortest < WORTHWHILE {
        return found;
    }
    for general in leaf.map_or(vec![256, 384, 512, 768, 1024, 2048], |l| vec![l]) {
        for symmetric in leaf.map_or(vec![512, 1024, 2048, 4096], |l| vec![l]) {
            for fast_levels in 1..=allowed.min(DEEPEST) {
                for symmetric_schemes in
                    [vec![SchemeId::Split], vec![SchemeId::Kgp4, SchemeId::Split]]
                {
                    found.push(Recursion {
                        symmetric: symmetric_schemes,
                        general: vec![general_scheme],
                        base: Base { general, symmetric },
                        fast_levels,
                    });
                }
            }
        }
    }
    found
}

fn allowed_levels(accuracy: Accuracy, growth: f64) -> usize {
    match accuracy {
        Accuracy::Max | Accuracy::Classical => 0,
        Accuracy::Bounded(factor) => (factor.ln() / growth.ln()) as usize,
        Accuracy::Default => allowed_levels(Accuracy::Bounded(DEFAULT_GROWTH), growth),
        Accuracy::Fast => usize::MAX,
    }
}

/// Returns the number of moduli of the exact path; the table of [`Accuracy`].
///
/// The rounding of the columns is relative to their norms, and so is the largest error of a
/// classical `A^T A`, that of its diagonal. The entries of a general product are usually far below
/// the norms, and so are the errors of the classical one: by default it takes a modulus more.
fn exact_moduli<T: Real>(accuracy: Accuracy, symmetric: bool) -> usize {
    /// The growth from which the fewest moduli are enough.
    const COARSE: f64 = 8.0;
    let most = if size_of::<T>() == 8 { 15 } else { 8 };
    let (default, least) = (most - usize::from(symmetric), most - 2);
    match accuracy {
        Accuracy::Max | Accuracy::Classical => most,
        Accuracy::Bounded(factor) if factor < COARSE => default,
        Accuracy::Default => default,
        Accuracy::Bounded(_) | Accuracy::Fast => least,
    }
}

/// Returns so few tasks that blocks stay long, because back ends are fast at long blocks. A caller
/// with many cores may set more.
fn default_tasks(n: usize, k: usize) -> usize {
    match n.min(k) {
        0..256 => 1,
        256..1024 => 2,
        1024..12288 => 4,
        12288..24576 => 16,
        _ => 64,
    }
}

/// Returns the tasks of the faithful mode: few, so that a general block is long enough for
/// Strassen's algorithm, and half as many for A^T B, which consists of such a block. The thesis
/// uses the number of threads, which would make results depend on it; a caller may set that too.
fn faithful_tasks(op: Op, n: usize, k: usize) -> usize {
    let tasks = match n.min(k) {
        0..4096 => 1,
        4096..12288 => 2,
        12288..24576 => 8,
        _ => 32,
    };
    if op.symmetric() { tasks } else { (tasks / 2).max(1) }
}

/// Returns the slabs for a tall A, whose C offers too few tasks.
fn task_slabs(m: usize, n: usize, k: usize) -> usize {
    let side = n.max(k).max(1);
    if side <= 768 { (m / (16 * side).max(2048)).clamp(1, 8) } else { 1 }
}

/// Returns the slabs for a C that is too small to be shared by threads: a power of two, with slabs
/// so long that the sum of their results does not matter.
fn fused_slabs(m: usize, n: usize, k: usize) -> usize {
    const SMALL: usize = 256;
    const SHORTEST: usize = 500;
    /// Rows from which on more slabs pay off.
    const MANY: usize = 50_000;
    let side = n.max(k);
    if side > SMALL {
        return 1;
    }
    let most = if m < MANY { 4 } else { 16 };
    let slabs = m / SHORTEST.max(5 * side);
    slabs.checked_ilog2().map_or(1, |log| 1 << log).min(most)
}

/// Returns the scalars that one of two packed chunks may take: with the sums of the threads less
/// than half of C, at most what the third-level cache of a core holds, and at least a chunk that
/// pays off. Of `memory` two chunks leave a quarter for the sums.
fn packing_budget<T>(n: usize, k: usize, memory: Option<usize>) -> usize {
    const LEAST: usize = 2 << 20;
    const MOST: usize = 64 << 20;
    let most = memory.map_or(MOST, |bytes| (bytes / 8 * 3).clamp(LEAST, MOST));
    (n * k / 6).clamp(LEAST / size_of::<T>(), most / size_of::<T>())
}
