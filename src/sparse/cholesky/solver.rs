use faer::prelude::{Reborrow, ReborrowMut};
use faer::{Mat, MatMut, MatRef};
use sprs::CsMatView;

use super::Symbolic;
use super::limits::Limits;
use super::lower::Lower;
use super::numeric;
use super::options::CholeskyOptions;
use super::supernode::WIDTH;
use super::sweeps::Sweeps;
use crate::base::{Error, Par, Progress, Result, repeated, reserved};
use crate::dense;

/// A sparse Cholesky factorization `A = L L^T` of a symmetric positive definite or semidefinite
/// matrix A (n x n), and solutions of `A X = B`.
///
/// The rows are eliminated in the order of approximate minimum degree (Amestoy, Davis and Duff
/// 1996), from 100,000 rows on after nested dissection, or in a given one, by supernodes.
/// [`Cholesky::analyse`] finds the order and the pattern of L; [`Cholesky::factor`] computes L, any
/// number of times for other values in the same places. Results are the same, bit for bit, for any
/// number of threads.
///
/// **Semidefinite matrices.** With [`CholeskyOptions::semidefinite`], a row whose pivot is zero up
/// to rounding is held ([`Cholesky::held`]): its unknown is 0, and its equation is left out. If
/// `A X = B` has a solution, the equations of held rows hold up to rounding, and X is the solution
/// with zeros in those rows; otherwise X solves the equations of the other rows. A Laplacian has
/// one such row for each component of its graph. Negative pivots are errors.
///
/// While a call runs, it asks the callback that watches the thread whether to stop
/// ([`Progress::watch`]).
///
/// ```
/// use catamaran::faer::mat;
/// use catamaran::sparse::{Cholesky, CholeskyOptions, CsMat};
///
/// // 2 on the diagonal, -1 beside it.
/// let (starts, columns) = (vec![0, 2, 5, 7], vec![0, 1, 0, 1, 2, 1, 2]);
/// let entries = vec![2.0, -1.0, -1.0, 2.0, -1.0, -1.0, 2.0];
/// let mut a = CsMat::new((3, 3), starts, columns, entries);
/// let mut cholesky = Cholesky::new(a.view(), &CholeskyOptions::new())?;
/// let x = cholesky.solve(mat![[1.0], [0.0], [1.0]].as_ref())?;
/// assert!((x - mat![[1.0], [1.0], [1.0]]).norm_max() < 1e-14);
///
/// // Other values in the same places.
/// a.scale(2.0);
/// cholesky.factor(a.view(), Default::default())?;
/// let x = cholesky.solve_rows(mat![[2.0], [0.0], [2.0]].as_ref(), &[1])?;
/// assert!((x[(0, 0)] - 1.0).abs() < 1e-14);
/// # Ok::<(), catamaran::Error>(())
/// ```
#[derive(Debug)]
pub struct Cholesky {
    lower: Lower,
    symbolic: Symbolic,
    sweeps: Sweeps,
    semidefinite: bool,
    tolerance: f64,
    par: Par,
    /// The values of L, or memory for them.
    values: Vec<f64>,
    /// What else the last factorization found; `None` when it failed, or there was none.
    factored: Option<Factored>,
}

#[derive(Debug)]
struct Factored {
    /// The held rows of A, ascending.
    held: Vec<usize>,
    weakest: Option<(usize, f64)>,
}

impl Cholesky {
    /// Analyses and factorizes A, stored by rows or by columns.
    ///
    /// # Errors
    /// Those of [`Cholesky::analyse`] and [`Cholesky::factor`].
    pub fn new(a: CsMatView<'_, f64>, options: &CholeskyOptions<'_>) -> Result<Self> {
        /// Part of the work that the analysis is.
        const ANALYSIS: f64 = 0.3;
        let progress = options.progress;
        let analysis = progress.part(0.0..ANALYSIS);
        let mut cholesky =
            Self::analyse(a, &CholeskyOptions { progress: analysis, ..options.clone() })?;
        cholesky.factor(a, progress.part(ANALYSIS..1.0))?;
        Ok(cholesky)
    }

    /// Finds the order of elimination and the pattern of L for all matrices with entries in the
    /// places of A, stored by rows or by columns, whose values, of any type, are not read. The
    /// diagonal is part of the pattern.
    ///
    /// ```
    /// use catamaran::sparse::{Cholesky, CholeskyOptions, CsMat};
    ///
    /// let cholesky = Cholesky::analyse(CsMat::<f64>::eye(5).view(), &CholeskyOptions::new())?;
    /// assert_eq!((cholesky.n(), cholesky.entries()), (5, 5));
    /// # Ok::<(), catamaran::Error>(())
    /// ```
    ///
    /// # Errors
    /// [`Error::Shape`] of "A" when it is not square, and of "order"; [`Error::Argument`] of "A"
    /// with 2^31 rows or more, of "order" and of "tolerance"; [`Error::OutOfMemory`],
    /// [`Error::Cancelled`].
    pub fn analyse<T: Copy>(a: CsMatView<'_, T>, options: &CholeskyOptions<'_>) -> Result<Self> {
        let tolerance = options.tolerance_for(a.rows())?;
        options.progress.watch(|| {
            options.progress.report(0.0)?;
            let lower = Lower::new(a, options.triangle)?;
            options.check_order(lower.n())?;
            let symbolic = match options.order {
                Some(order) => Symbolic::in_order(lower.places(), order)?,
                None => Symbolic::new(lower.places())?,
            };
            let sweeps = Sweeps::new(&symbolic.pattern, |i| symbolic.order[i], |i| i)?;
            options.progress.report(1.0)?;
            Ok(Self {
                lower,
                symbolic,
                sweeps,
                semidefinite: options.semidefinite,
                tolerance,
                par: options.par,
                values: Vec::new(),
                factored: None,
            })
        })
    }

    /// Computes L for a matrix that has no entries outside of the pattern that was analysed, stored
    /// by rows or by columns; places without an entry are 0. After an error there is no factor, and
    /// the next call may still succeed.
    ///
    /// # Errors
    /// [`Error::Argument`] of "A" names the row at which elimination fails when A is not positive
    /// definite, or semidefinite where that is enough; the first entry outside of the pattern; or
    /// entries that are not symmetric. [`Error::Shape`] and [`Error::NonFinite`] of "A",
    /// [`Error::OutOfMemory`], [`Error::Cancelled`].
    pub fn factor(&mut self, a: CsMatView<'_, f64>, progress: Progress<'_>) -> Result<()> {
        self.factored = None;
        progress.watch(|| {
            progress.report(0.0)?;
            let entries = self.lower.values(a)?;
            let Symbolic { pattern, entries: places, order } = &self.symbolic;
            let mut diagonal = reserved(order.len())?;
            diagonal.extend(order.iter().map(|&row| self.lower.diagonal(&entries, row)));
            let mut limits = Limits::new(diagonal, self.tolerance, self.semidefinite);
            let (memory, par) = (std::mem::take(&mut self.values), self.par);
            let limited = Some(&mut limits);
            let found =
                numeric::positive(pattern, places, &entries, memory, limited, par, progress)?;
            self.values = found.map_err(|i| self.not_definite(order[i]))?;
            if !self.values.iter().all(|x| x.is_finite()) {
                let why = "its factor overflows".into();
                return Err(Error::Argument { what: "A", why });
            }
            let weakest = self.weakest_of(&limits);
            let mut held: Vec<usize> = limits.held.iter().map(|&i| order[i]).collect();
            held.sort_unstable();
            progress.report(1.0)?;
            self.factored = Some(Factored { held, weakest });
            Ok(())
        })
    }

    /// Returns the error about a matrix whose elimination fails at this row.
    fn not_definite(&self, row: usize) -> Error {
        let why = match self.semidefinite {
            true => format!("not positive semidefinite (elimination fails at row {row})"),
            false => format!(
                "not positive definite (elimination fails at row {row}); singular matrices need \
                 the option semidefinite"
            ),
        };
        Error::Argument { what: "A", why }
    }

    /// Returns [`Cholesky::weakest`] of the values.
    fn weakest_of(&self, limits: &Limits) -> Option<(usize, f64)> {
        let Symbolic { pattern, order, .. } = &self.symbolic;
        let mut held = limits.held.iter().peekable();
        let mut weakest: Option<(usize, f64)> = None;
        for node in &pattern.nodes {
            let panel = node.panel(&self.values[node.range()]);
            for j in 0..node.columns {
                let i = node.start + j;
                if held.next_if_eq(&&i).is_some() {
                    continue;
                }
                let ratio = panel[(j, j)] / limits.diagonal[i] * panel[(j, j)];
                if weakest.is_none_or(|(_, least)| ratio < least) {
                    weakest = Some((order[i], ratio));
                }
            }
        }
        weakest
    }

    /// Solves `A X = B` for any number of right-hand sides (n x c, any strides), eight at a time.
    ///
    /// # Errors
    /// [`Error::Shape`] and [`Error::NonFinite`] of "B"; [`Error::Argument`] of "A" when it is not
    /// factorized; [`Error::OutOfMemory`], [`Error::Cancelled`].
    pub fn solve(&self, b: MatRef<'_, f64>) -> Result<Mat<f64>> {
        let mut x = dense::filled(b.nrows(), b.ncols(), |i, j| b[(i, j)])?;
        self.solve_in_place(x.as_mut())?;
        Ok(x)
    }

    /// Replaces B by the solution of `A X = B`, as [`Cholesky::solve`]. After
    /// [`Error::Cancelled`], B holds unspecified values.
    ///
    /// ```
    /// use catamaran::faer::Mat;
    /// use catamaran::sparse::{Cholesky, CholeskyOptions, CsMat};
    ///
    /// let mut x = Mat::<f64>::ones(3, 2);
    /// let cholesky = Cholesky::new(CsMat::eye(3).view(), &CholeskyOptions::new())?;
    /// cholesky.solve_in_place(x.as_mut())?;
    /// assert_eq!(x, Mat::<f64>::ones(3, 2));
    /// # Ok::<(), catamaran::Error>(())
    /// ```
    ///
    /// # Errors
    /// As [`Cholesky::solve`].
    pub fn solve_in_place(&self, mut b: MatMut<'_, f64>) -> Result<()> {
        let factored = self.check(b.rb())?;
        self.sweeps.solve(&self.values, None, b.rb_mut(), self.par)?;
        for &row in &factored.held {
            (0..b.ncols()).for_each(|j| b[(row, j)] = 0.0);
        }
        Ok(())
    }

    /// Returns some rows of the solution X of `A X = B`, in the order of `rows`, in which a row may
    /// be more than once. Memory is that of these rows and of eight columns; what the rows do not
    /// depend on is left out of the back substitution.
    ///
    /// # Errors
    /// As [`Cholesky::solve`], and [`Error::Argument`] of "rows" names one that does not exist.
    pub fn solve_rows(&self, b: MatRef<'_, f64>, rows: &[usize]) -> Result<Mat<f64>> {
        let n = self.n();
        let factored = self.check(b)?;
        let mut is_wanted = repeated(false, n)?;
        for &row in rows {
            if row >= n {
                let why = format!("row {row} is out of range: {n} rows, numbered from 0");
                return Err(Error::Argument { what: "rows", why });
            }
            is_wanted[row] = true;
        }
        let subtrees = self.sweeps.subtrees_of(|row| is_wanted[row]);
        let is_held: Vec<bool> =
            rows.iter().map(|row| factored.held.binary_search(row).is_ok()).collect();
        let mut found = dense::zeros(rows.len(), b.ncols())?;
        let mut block = dense::zeros(n, WIDTH.min(b.ncols()))?;
        for first in (0..b.ncols()).step_by(WIDTH) {
            let width = WIDTH.min(b.ncols() - first);
            let mut x = block.as_mut().subcols_mut(0, width);
            x.copy_from(b.subcols(first, width));
            self.sweeps.solve_for(&self.values, None, x.rb_mut(), &subtrees, self.par)?;
            for (i, &row) in rows.iter().enumerate().filter(|&(i, _)| !is_held[i]) {
                (0..width).for_each(|j| found[(i, first + j)] = x[(row, j)]);
            }
        }
        Ok(found)
    }

    /// Checks that there is a factor, and the right-hand sides.
    fn check(&self, b: MatRef<'_, f64>) -> Result<&Factored> {
        let Some(factored) = &self.factored else {
            let why = "not factorized: the last factorization failed, or there was none".into();
            return Err(Error::Argument { what: "A", why });
        };
        Error::check_shape("B", (self.n(), b.ncols()), b.shape())?;
        for j in 0..b.ncols() {
            if let Some(i) = (0..b.nrows()).find(|&i| !b[(i, j)].is_finite()) {
                return Err(Error::NonFinite { what: "B", index: (i, j) });
            }
        }
        Ok(factored)
    }

    /// Returns the number of rows of A.
    pub fn n(&self) -> usize {
        self.lower.n()
    }

    /// Returns the number of entries of L that are stored, zeros among them.
    pub fn entries(&self) -> usize {
        let of = |columns: usize, below: usize| columns * (columns + 1) / 2 + columns * below;
        self.symbolic.pattern.nodes.iter().map(|node| of(node.columns, node.below)).sum()
    }

    /// Returns about how many bytes the analysis and the factor take.
    pub fn bytes(&self) -> usize {
        self.symbolic.bytes() + self.lower.bytes()
    }

    /// Returns whether there is a factor: whether the last factorization succeeded.
    pub fn is_factored(&self) -> bool {
        self.factored.is_some()
    }

    /// Returns the rows of A that are held at zero, ascending: none of a definite matrix. Which
    /// rows of dependent ones are held depends on the order of elimination.
    pub fn held(&self) -> &[usize] {
        match &self.factored {
            Some(factored) => &factored.held,
            None => &[],
        }
    }

    /// Returns the row of A with the smallest pivot relative to its diagonal entry, and this ratio:
    /// at 1e-12, solutions may lose 12 digits. Held rows do not count. `None` without a factor, or
    /// without other rows.
    ///
    /// ```
    /// use catamaran::sparse::{Cholesky, CholeskyOptions, CsMat};
    ///
    /// // Singular but for rounding.
    /// let entries = vec![1.0, -1.0, -1.0, 1.0 + 1e-15];
    /// let a = CsMat::new((2, 2), vec![0, 2, 4], vec![0, 1, 0, 1], entries);
    /// let cholesky = Cholesky::new(a.view(), &CholeskyOptions::new())?;
    /// assert!(cholesky.weakest().is_some_and(|(_, ratio)| ratio < 1e-14));
    /// # Ok::<(), catamaran::Error>(())
    /// ```
    pub fn weakest(&self) -> Option<(usize, f64)> {
        self.factored.as_ref().and_then(|factored| factored.weakest)
    }
}
