use std::fmt;
use std::sync::Arc;

use crate::base::{Error, Par, Pin, Progress, Result, options};
use crate::blas::{self, Backend};

/// Which triangle of the symmetric result is computed.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Uplo {
    /// The lower triangle; the strict upper one is neither read nor written.
    Lower,
    /// The upper triangle; the strict lower one is neither read nor written.
    Upper,
    /// Both triangles, equal bit for bit. With `beta != 0` the old lower triangle is read.
    Both,
}

/// What a product may cost in accuracy. Errors are in the maximum norm, relative to those of the
/// classical algorithm on the same input.
///
/// The exact path ([`SchemeChoice::Exact`]) derives a number N of moduli from it. With `P` their
/// product and `u` the unit roundoff, an entry of `A^T B` is wrong by at most `(u + 4 sqrt(m / P) +
/// 4 m / P) |a_i| |b_j|`, with the Euclidean norms of its columns; the expected error is about `(u
/// / 2 + sqrt(2 / P)) |a_i| |b_j|`, for any m.
///
/// | | N, f64 | `sqrt(2 / P)` | N, f32 | `sqrt(2 / P)` |
/// |---|---|---|---|---|
/// | `Max`, `Classical`; `Default`, `Bounded(f)` of `A^T B` | 15 | 2.6e-18 | 8 | 3.8e-10 |
/// | `Default`, `Bounded(f)` of `A^T A` | 14 | 3.7e-17 | 7 | 5.8e-9 |
/// | `Fast`, `Bounded(f >= 8)` | 13 | 5.2e-16 | 6 | 9.0e-8 |
#[derive(Debug, Clone, Copy, PartialEq)]
#[non_exhaustive]
pub enum Accuracy {
    /// The exact path, on any machine: no entry has a larger error than a correctly rounded result
    /// by more than a few percent of the unit roundoff, relative to the norms of its columns. As
    /// `Classical` with a scheme other than [`SchemeChoice::Auto`] and [`SchemeChoice::Exact`].
    Max,
    /// Classical products only: componentwise bounds.
    Classical,
    /// Fast levels as long as the expected growth of the error stays within this factor (>= 1).
    Bounded(f64),
    /// `Bounded(4.0)` for fast levels; the exact path where it is faster, with errors no larger
    /// than the classical ones.
    Default,
    /// As many fast levels as pay off.
    Fast,
}

/// Which recursion to run.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[non_exhaustive]
pub enum SchemeChoice {
    /// The recursion that the planner expects to be fastest within the requested accuracy.
    Auto,
    /// As `Auto`, but without the exact path.
    Float,
    /// No fast products: blocks computed by the back end.
    Classical,
    /// The faithful mode of the thesis: algorithm 8.1 (AtA) over Strassen, base case by a measured
    /// side.
    Ata2,
    /// [`SchemeId::Split`](super::schemes::SchemeId::Split) over Winograd's variant. With the
    /// native kernels, which share no sums, over Strassen's algorithm, which then adds less.
    Winograd,
    /// RXTX over Winograd's variant.
    Rxtx,
    /// The sparse 4 x 4 scheme of Khoruzhii, Gelss and Pokutta over Winograd's variant; with the
    /// native kernels over Strassen's.
    Kgp4,
    /// Their 3 x 3 scheme over Winograd's variant.
    Kgp3,
    /// Integer products modulo small coprime numbers: one rounding of the columns, one of the
    /// result, and none between them. [`Accuracy`] determines the unit of the first rounding.
    Exact,
}

impl SchemeChoice {
    /// Every choice and its name on the command line.
    pub const NAMES: [(&'static str, Self); 9] = [
        ("auto", Self::Auto),
        ("float", Self::Float),
        ("classical", Self::Classical),
        ("ata2", Self::Ata2),
        ("winograd", Self::Winograd),
        ("rxtx", Self::Rxtx),
        ("kgp", Self::Kgp4),
        ("kgp3", Self::Kgp3),
        ("exact", Self::Exact),
    ];
}

options! {
    /// How [`ata_into`](super::ata_into) and its relatives work; the default suits most callers.
    ///
    /// ```
    /// use catamaran::{Accuracy, AtaOptions, Uplo};
    ///
    /// let options = AtaOptions::new().uplo(Uplo::Both).threads(4).accuracy(Accuracy::Max);
    /// ```
    #[derive(Clone)]
    pub struct AtaOptions<'a> {
        /// Which triangle of the result is computed.
        ///
        /// ```
        /// use catamaran::{AtaOptions, Uplo, ata_into, faer::mat};
        ///
        /// // The strict lower triangle is not written.
        /// let (a, mut c) = (mat![[1.0, 2.0]], mat![[0.0, 0.0], [7.0, 0.0]]);
        /// ata_into(1.0, a.as_ref(), 0.0, c.as_mut(), &AtaOptions::new().uplo(Uplo::Upper))?;
        /// assert_eq!(c, mat![[1.0, 2.0], [7.0, 4.0]]);
        /// # Ok::<(), catamaran::Error>(())
        /// ```
        uplo: Uplo = Uplo::Lower;
        /// Threads that a call may use. Their number does not change the result.
        par: Par = Par::all();
        /// Whether threads stay on one core each. The result does not depend on it.
        ///
        /// With [`Pin::Cores`] a call runs on pinned threads of this library, which are kept for
        /// later calls with as many threads, and the calling thread waits. Calls at the same time
        /// share these threads, so pin only where one call at a time uses the machine. [`Par::Seq`]
        /// and the smallest products run on the calling thread, on any core.
        ///
        /// ```
        /// use catamaran::{AtaOptions, Uplo, ata_into, base::Pin, faer::Mat};
        ///
        /// let (a, mut c) = (Mat::<f64>::identity(600, 400), Mat::zeros(400, 400));
        /// let options = AtaOptions::new().threads(2).pin(Pin::Cores).uplo(Uplo::Both);
        /// ata_into(1.0, a.as_ref(), 0.0, c.as_mut(), &options)?;
        /// assert_eq!(c, Mat::<f64>::identity(400, 400));
        /// # Ok::<(), catamaran::Error>(())
        /// ```
        pin: Pin = Pin::No;
        /// Which recursion runs.
        ///
        /// ```
        /// use catamaran::{AtaOptions, Plan, SchemeChoice};
        ///
        /// let options = AtaOptions::new().scheme(SchemeChoice::Exact);
        /// assert!(Plan::ata::<f64>(100, 50, &options)?.is_exact());
        /// # Ok::<(), catamaran::Error>(())
        /// ```
        scheme: SchemeChoice = SchemeChoice::Auto;
        /// The error that fast products may cause.
        ///
        /// ```
        /// use catamaran::{Accuracy, AtaOptions, Plan};
        ///
        /// let options = AtaOptions::new().accuracy(Accuracy::Classical);
        /// assert!(!Plan::ata::<f64>(8000, 8000, &options)?.is_fast());
        /// # Ok::<(), catamaran::Error>(())
        /// ```
        accuracy: Accuracy = Accuracy::Default;
        /// Whether results are the same bytes on every machine, for any number of threads. Every
        /// product then takes [`SchemeChoice::Exact`], and no other scheme may be set. On CPUs
        /// without AMX it is slower than the classical algorithm.
        ///
        /// ```
        /// use catamaran::{AtaOptions, Plan, SchemeChoice};
        ///
        /// let options = AtaOptions::new().reproducible(true);
        /// assert!(Plan::ata::<f64>(100, 50, &options)?.is_exact());
        /// assert!(Plan::ata::<f64>(100, 50, &options.scheme(SchemeChoice::Rxtx)).is_err());
        /// # Ok::<(), catamaran::Error>(())
        /// ```
        reproducible: bool = false;
        /// The back end that computes the leaves.
        backend: Arc<dyn Backend> = blas::native();
        /// The smallest block side (in elements) that a fast level may produce; in
        /// [`SchemeChoice::Ata2`] any level. `None` leaves it to the planner.
        leaf: Option<usize> = None, range "at least 1", setter into;
        /// The number of tasks that C is split into, whatever the number of threads. With `None`
        /// the shape decides. The native kernels divide C in their own way and need no tasks,
        /// except for the schemes of the thesis, RXTX and Kgp3.
        tasks: Option<usize> = None, range "from 1 to 65536", setter into;
        /// The bytes of scratch that plans over the native kernels and plans of the exact path aim
        /// at, for all threads together. `None` takes what is fastest.
        ///
        /// Products of many rows may need more:
        /// [`Plan::scratch_len`](super::Plan::scratch_len) returns the number. A plan with
        /// smaller steps rounds differently, except on the exact path.
        memory: Option<usize> = None, setter into;
        /// The callback that receives progress and may cancel.
        ///
        /// ```
        /// use std::ops::ControlFlow;
        /// use catamaran::base::Progress;
        /// use catamaran::{AtaOptions, Error, ata_into, faer::Mat};
        ///
        /// let stop = |_: f64| ControlFlow::Break(());
        /// let options = AtaOptions::new().progress(Progress::new(&stop));
        /// let (a, mut c) = (Mat::<f64>::ones(500, 400), Mat::zeros(400, 400));
        /// let result = ata_into(1.0, a.as_ref(), 0.0, c.as_mut(), &options);
        /// assert!(matches!(result, Err(Error::Cancelled)));
        /// ```
        progress: Progress<'a> = Progress::none(), setter own;
    }
}

impl fmt::Debug for AtaOptions<'_> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_struct("AtaOptions")
            .field("uplo", &self.uplo)
            .field("par", &self.par)
            .field("pin", &self.pin)
            .field("scheme", &self.scheme)
            .field("accuracy", &self.accuracy)
            .field("reproducible", &self.reproducible)
            .field("backend", &self.backend.name())
            .field("leaf", &self.leaf)
            .field("tasks", &self.tasks)
            .field("memory", &self.memory)
            .field("progress", &self.progress)
            .finish()
    }
}

/// More tasks would only cost memory.
const MAX_TASKS: usize = 1 << 16;

impl AtaOptions<'_> {
    /// Calls `work` on pinned threads, if [`AtaOptions::pin()`] requests them.
    pub(crate) fn on_cores<R: Send>(&self, work: impl FnOnce() -> R + Send) -> R {
        self.par.on_cores(self.pin, work)
    }

    /// Checks the options.
    ///
    /// # Errors
    /// [`Error::Argument`] that names the option out of range.
    pub(crate) fn check(&self) -> Result<()> {
        let refuse = |what, why: &str| Err(Error::Argument { what, why: why.into() });
        match self.accuracy {
            Accuracy::Bounded(f) if !f.is_finite() || f < 1.0 => {
                refuse("accuracy", "the error factor must be finite and at least 1")
            }
            _ if self.reproducible
                && !matches!(self.scheme, SchemeChoice::Auto | SchemeChoice::Exact) =>
            {
                refuse("scheme", "only the exact scheme is reproducible on every machine")
            }
            _ if self.leaf == Some(0) => refuse("leaf", "must be at least 1"),
            _ if self.tasks.is_some_and(|t| t == 0 || t > MAX_TASKS) => {
                refuse("tasks", &format!("must be between 1 and {MAX_TASKS}"))
            }
            _ => Ok(()),
        }
    }
}

impl<'a> AtaOptions<'a> {
    /// Returns whether the exact path is requested by name: by [`AtaOptions::reproducible()`],
    /// [`SchemeChoice::Exact`] or [`Accuracy::Max`]. Sums of blocks of rows are then exact too.
    pub fn asks_for_exact(&self) -> bool {
        self.reproducible
            || self.scheme == SchemeChoice::Exact
            || self.accuracy == Accuracy::Max && self.scheme == SchemeChoice::Auto
    }

    /// Sets [`progress`](#structfield.progress), whose lifetime may be a shorter one.
    pub fn progress<'b>(self, progress: impl Into<Progress<'b>>) -> AtaOptions<'b>
    where
        'a: 'b,
    {
        AtaOptions { progress: progress.into(), ..self }
    }
}
