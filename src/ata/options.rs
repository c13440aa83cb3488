use std::sync::Arc;

use crate::base::{Par, Progress};
use crate::blas::{self, Backend};

/// Which triangle of the symmetric result is wanted.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum Uplo {
    /// The lower one; the strict upper one is neither read nor written.
    #[default]
    Lower,
    /// The upper one; the strict lower one is neither read nor written.
    Upper,
    /// Both, equal bit for bit. With `beta != 0` the old lower triangle is what is read.
    Both,
}

/// What a product may cost in accuracy. Errors are in the maximum norm, relative to those of the
/// classical algorithm on the same input.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub enum Accuracy {
    /// Classical products only: componentwise bounds, infinities and NaN stay where they belong.
    Classical,
    /// Fast levels as long as the expected growth of the error stays within this factor (>= 1).
    Bounded(f64),
    /// The default: `Bounded(4.0)`.
    #[default]
    Default,
    /// As many fast levels as pay off.
    Fast,
}

/// Which recursion to run.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum SchemeChoice {
    /// Whatever the planner expects to be fastest within the accuracy asked for.
    #[default]
    Auto,
    /// No fast products: blocks over the back end.
    Classical,
    /// The faithful mode of the thesis: algorithm 8.1 (AtA) over Strassen, base case by cache size.
    Ata2,
    /// [`SchemeId::Split`](super::scheme::SchemeId::Split) over Winograd's variant.
    Winograd,
    /// RXTX over Winograd's variant.
    Rxtx,
    /// The sparse 4 x 4 scheme of Khoruzhii, Gelss and Pokutta over Winograd's variant.
    Kgp4,
    /// Their 3 x 3 scheme over Winograd's variant.
    Kgp3,
}

impl SchemeChoice {
    /// Every choice and its name on the command line.
    pub const NAMES: [(&'static str, Self); 7] = [
        ("auto", Self::Auto),
        ("classical", Self::Classical),
        ("ata2", Self::Ata2),
        ("winograd", Self::Winograd),
        ("rxtx", Self::Rxtx),
        ("kgp", Self::Kgp4),
        ("kgp3", Self::Kgp3),
    ];
}

/// How [`ata`](super::ata) and its relatives work; the default suits most callers.
#[derive(Clone)]
pub struct AtaOptions<'a> {
    /// Which triangle; default [`Uplo::Lower`].
    pub uplo: Uplo,
    /// Threads; default all cores of the affinity mask. Does not change the result.
    pub par: Par,
    /// Which recursion; default [`SchemeChoice::Auto`].
    pub scheme: SchemeChoice,
    /// Error allowed to fast products; default [`Accuracy::Default`].
    pub accuracy: Accuracy,
    /// What computes the leaves; default [`blas::native()`].
    pub backend: Arc<dyn Backend>,
    /// Smallest block side a fast level may produce (elements, >= 1); in [`SchemeChoice::Ata2`] the
    /// side of the square that fits the cache. `None`: what the planner finds best.
    pub leaf: Option<usize>,
    /// Tasks that C is split into, whatever the number of threads; `None`: by shape.
    pub tasks: Option<usize>,
    /// Told of progress; may cancel.
    pub progress: Option<Progress<'a>>,
}

impl Default for AtaOptions<'_> {
    fn default() -> Self {
        Self {
            uplo: Uplo::default(),
            par: Par::all(),
            scheme: SchemeChoice::default(),
            accuracy: Accuracy::default(),
            backend: blas::native(),
            leaf: None,
            tasks: None,
            progress: None,
        }
    }
}
