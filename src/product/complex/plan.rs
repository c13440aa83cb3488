//! Plans of complex products, as data: real products of blocks of rows.

use std::ops::Range;

use crate::base::{Par, Result, block_rows, even_part};
use crate::blas::BlasReal;
use crate::product::options::AtaOptions;
use crate::product::plan::{Op, Plan};

/// A real product of parts of a [`Stack`](super::stack::Stack) of A and of one of B.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Term {
    pub op: Op,
    pub left: Range<usize>,
    pub right: Range<usize>,
}

/// Which product, with the parts of A and B in its terms.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Kind {
    /// `A^H A`.
    Aha,
    /// `A^H B`.
    Ahb,
    /// `A^T B`.
    Atb,
}

/// A plan for `C := alpha A^H A + beta C`, `alpha A^H B + beta C` or `alpha A^T B + beta C` of
/// complex matrices: one plan for many calls, and the memory of a call before it runs.
///
/// It depends on the shape, the precision and the options, but never on the number of threads.
/// With [`AtaOptions::memory`] blocks of rows are as small as necessary, down to 128 rows; the
/// sums, as large as C, always stay in memory. The rounding of the result depends on these blocks.
///
/// ```
/// use catamaran::{AtaOptions, Par, product::ComplexPlan};
///
/// let options = AtaOptions::new().memory(64 << 20);
/// let plan = ComplexPlan::ahb::<f64>(100_000, 500, 300, &options)?;
/// assert!(8 * plan.scratch_len::<f64>(Par::Threads(2)) <= 64 << 20);
/// # Ok::<(), catamaran::Error>(())
/// ```
#[derive(Debug, Clone, PartialEq)]
pub struct ComplexPlan {
    pub(super) kind: Kind,
    /// Whether the product is conjugated before it is multiplied by alpha.
    pub(super) conjugated: bool,
    /// Rows of A, columns of A and of B.
    pub(super) sides: [usize; 3],
    pub(super) blocks: usize,
    /// The sums of these are the real and the imaginary part.
    pub(super) terms: [Term; 2],
    /// For each term, the plans for the height of the first block and of the last one. Heights
    /// differ by a row at most.
    pub(super) plans: [[Plan; 2]; 2],
}

impl ComplexPlan {
    /// Plans `A^H A` for A m x n.
    ///
    /// ```
    /// use catamaran::{AtaOptions, product::ComplexPlan};
    ///
    /// let plan = ComplexPlan::aha::<f64>(1000, 100, &AtaOptions::new().reproducible(true))?;
    /// assert!(plan.is_exact());
    /// # Ok::<(), catamaran::Error>(())
    /// ```
    ///
    /// # Errors
    /// As [`Plan::ata`].
    pub fn aha<T: BlasReal>(m: usize, n: usize, options: &AtaOptions<'_>) -> Result<Self> {
        // Antisymmetric, so the fast schemes for symmetric products do not apply: a general product
        // and its transpose. The exact path has no schemes, and rounds the difference once.
        let imaginary = if options.asks_for_exact() {
            Term { op: Op::Gemmt, left: 0..2, right: 1..3 }
        } else {
            Term { op: Op::Gemm, left: 0..1, right: 1..2 }
        };
        let terms = [Term { op: Op::Syrk, left: 0..2, right: 0..2 }, imaginary];
        Self::new::<T>(Kind::Aha, [m, n, n], terms, options)
    }

    /// Plans `A^H B` for A m x n and B m x k.
    ///
    /// # Errors
    /// As [`Plan::ata`].
    pub fn ahb<T: BlasReal>(
        m: usize,
        n: usize,
        k: usize,
        options: &AtaOptions<'_>,
    ) -> Result<Self> {
        let term = |right| Term { op: Op::Gemm, left: 0..2, right };
        Self::new::<T>(Kind::Ahb, [m, n, k], [term(0..2), term(1..3)], options)
    }

    /// Plans `A^T B`, without a conjugate, for A m x n and B m x k.
    ///
    /// # Errors
    /// As [`Plan::ata`].
    pub fn atb<T: BlasReal>(
        m: usize,
        n: usize,
        k: usize,
        options: &AtaOptions<'_>,
    ) -> Result<Self> {
        // The parts of B are V, U and -V.
        let term = |right| Term { op: Op::Gemm, left: 0..2, right };
        Self::new::<T>(Kind::Atb, [m, n, k], [term(1..3), term(0..2)], options)
    }

    /// Returns the plan of the conjugate of the product: `A^T conj(A)`, `A^T conj(B)`,
    /// `A^H conj(B)`.
    ///
    /// ```
    /// use catamaran::{AtaOptions, product::{ComplexPlan, ahb_planned}, faer::{Mat, c64}};
    ///
    /// // A^T conj(B) of one entry each: i times 1.
    /// let options = AtaOptions::new();
    /// let plan = ComplexPlan::ahb::<f64>(1, 1, 1, &options)?.conjugated();
    /// let (i, one, zero) = (c64::new(0.0, 1.0), c64::new(1.0, 0.0), c64::new(0.0, 0.0));
    /// let (a, b, mut c) = (Mat::full(1, 1, i), Mat::full(1, 1, one), Mat::zeros(1, 1));
    /// ahb_planned(&plan, one, a.as_ref(), b.as_ref(), zero, c.as_mut(), &options)?;
    /// assert_eq!(c[(0, 0)], i);
    /// # Ok::<(), catamaran::Error>(())
    /// ```
    #[must_use]
    pub fn conjugated(mut self) -> Self {
        self.conjugated = !self.conjugated;
        self
    }

    fn new<T: BlasReal>(
        kind: Kind,
        sides: [usize; 3],
        terms: [Term; 2],
        options: &AtaOptions<'_>,
    ) -> Result<Self> {
        options.check()?;
        let [m, n, k] = sides;
        let line = line(kind, &terms, sides);
        let sums = n.saturating_mul(k).saturating_mul(2 * size_of::<T>());
        let mut rows = block_rows::<T>(line, false);
        if let Some(bytes) = options.memory {
            /// Rows of the least block, whose products are still long enough to be fast.
            const LEAST: usize = 128;
            // The other half is for the scratch of the products.
            let half = bytes.saturating_sub(sums) / 2;
            let fits = half / line.saturating_mul(size_of::<T>()).max(1);
            rows = rows.min(fits.max(LEAST));
        }
        let blocks = m.div_ceil(rows.max(1)).max(1);
        let heights = [0, blocks - 1].map(|block| even_part(0..m, blocks, block).len());
        let stacks = line.saturating_mul(heights[1]).saturating_mul(size_of::<T>());
        let left = options.memory.map(|bytes| bytes.saturating_sub(sums).saturating_sub(stacks));
        let options = options.clone().memory(left);
        let plan = |term: &Term, height: usize| {
            Plan::new::<T>(term.op, term.left.len() * height, n, k, &options)
        };
        let plans = |term| Ok([plan(term, heights[0])?, plan(term, heights[1])?]);
        let plans = [plans(&terms[0])?, plans(&terms[1])?];
        Ok(Self { kind, conjugated: false, sides, blocks, terms, plans })
    }

    /// Returns the rows of a block.
    pub(super) fn rows(&self, block: usize) -> Range<usize> {
        even_part(0..self.sides[0], self.blocks, block)
    }

    /// Returns the numbers of parts of a stack of A and of one of B.
    pub(super) fn parts(&self) -> [usize; 2] {
        parts(self.kind, &self.terms)
    }

    /// Returns the elements of the sums, the stacks and the scratch of the real products.
    pub(super) fn lens<T: BlasReal>(&self, par: Par) -> [usize; 4] {
        let [_, n, k] = self.sides;
        let height = self.rows(self.blocks - 1).len();
        let parts = self.parts();
        let stack = |side: usize, parts: usize| side.saturating_mul(height).saturating_mul(parts);
        let scratch = self.plans.iter().flatten().map(|plan| plan.scratch_len::<T>(par)).max();
        [n.saturating_mul(k), stack(n, parts[0]), stack(k, parts[1]), scratch.unwrap_or(0)]
    }

    /// Returns the real elements that a product by this plan takes on so many threads, beside A, B
    /// and C.
    pub fn scratch_len<T: BlasReal>(&self, par: Par) -> usize {
        let [sum, rest @ ..] = self.lens::<T>(par);
        rest.into_iter().fold(sum.saturating_mul(2), usize::saturating_add)
    }

    /// Returns the largest of the [`Plan::expected_ratio`] of the real products.
    pub fn expected_ratio(&self) -> f64 {
        self.plans.iter().flatten().map(Plan::expected_ratio).fold(0.0, f64::max)
    }

    /// Returns the instruction set of the real products; `None` when a back end computes them.
    pub fn isa(&self) -> Option<&'static str> {
        self.plans[0][0].isa()
    }

    /// Returns whether all real products take the exact path.
    pub fn is_exact(&self) -> bool {
        self.plans.iter().flatten().all(Plan::is_exact)
    }
}

fn parts(kind: Kind, terms: &[Term; 2]) -> [usize; 2] {
    let most = |side: fn(&Term) -> usize| side(&terms[0]).max(side(&terms[1]));
    let of_right = most(|term| term.right.end);
    match kind {
        Kind::Aha => [most(|term| term.left.end).max(of_right), 0],
        Kind::Ahb | Kind::Atb => [most(|term| term.left.end), of_right],
    }
}

/// Returns the elements of a row of the stacks.
fn line(kind: Kind, terms: &[Term; 2], [_, n, k]: [usize; 3]) -> usize {
    [n, k].into_iter().zip(parts(kind, terms)).map(|(n, parts)| n.saturating_mul(parts)).sum()
}
