use faer::Mat;

use super::cholesky::{PivotedCholesky, Pivoting, check_lengths, exponent, named, tolerance};
use super::columns::Columns;
use super::double::{TripleSum, scaled};
use super::refine::{Outcome, Refined};
use super::row_space::RowSpace;
use super::spread::{Spread, deviations};
use crate::base::{Error, Par, Result, options};
use crate::dense::zeros;
use crate::rows::ExtendedGram;

/// What happens when columns of A depend on others, as far as the precision can tell.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[non_exhaustive]
pub enum RankDeficiency {
    /// The solution of least norm is returned.
    MinimumNorm,
    /// An error names the columns.
    Refuse,
}

options! {
    /// How [`LeastSquares`] solves.
    ///
    /// ```
    /// use catamaran::solve::{LeastSquaresOptions, RankDeficiency};
    ///
    /// let options = LeastSquaresOptions::new()
    ///     .intercept(true)
    ///     .ridge(0.1)
    ///     .rank_deficiency(RankDeficiency::Refuse);
    /// assert!(options.standard_errors);
    /// ```
    #[derive(Debug, Clone, Copy, PartialEq)]
    pub struct LeastSquaresOptions {
        /// Multiple of `|X|^2` that is added to the minimized sum; the intercept is not part of X.
        ridge: f64 = 0.0, check(at least 0);
        /// Whether a constant is fitted too; the matrix must be about the mean.
        intercept: bool = false;
        /// What happens when columns depend on others.
        rank_deficiency: RankDeficiency = RankDeficiency::MinimumNorm;
        /// Whether standard errors and the covariance of coefficients are computed, which takes a
        /// few times as long as the solution.
        standard_errors: bool = true;
        /// Threads. Their number does not change the result.
        par: Par = Par::all();
    }
}

/// The solution X (n x k) of `min |A X - B|^2 + ridge |X|^2` for tall A (m x n) and B (m x k), from
/// the Gram matrix of `[A B]`: one pass over the rows.
///
/// X comes from a Cholesky factor in double-double and is refined with all three parts of the Gram
/// matrix, until corrections are below 2^-60 of each coefficient (Bjorck 1987, for normal equations
/// that are not rounded). See [`LeastSquares::digits`].
///
/// ```
/// use catamaran::rows::ExtendedGram;
/// use catamaran::solve::{LeastSquares, LeastSquaresOptions};
/// use catamaran::faer::mat;
///
/// // A line through (0, 1), (1, 3) and (2, 5): columns 1, t and the target.
/// let rows = mat![[1.0, 0.0, 1.0], [1.0, 1.0, 3.0], [1.0, 2.0, 5.0]];
/// let c = rows.transpose() * &rows;
/// let gram = ExtendedGram::from_f64(c.as_ref(), 3, &[])?;
/// let found = LeastSquares::from_gram(&gram, 1, &LeastSquaresOptions::new())?;
/// assert_eq!(found.coefficients, mat![[1.0], [2.0]]);
/// assert_eq!((found.residual_norms[0], found.r_squared[0]), (0.0, 1.0));
/// # Ok::<(), catamaran::Error>(())
/// ```
#[derive(Debug, Clone)]
#[non_exhaustive]
pub struct LeastSquares {
    /// n x k.
    pub coefficients: Mat<f64>,
    /// What rounding to f64 removed from the coefficients, n x k.
    pub coefficients_low: Mat<f64>,
    /// The constant of each of the k targets; zeros without [`LeastSquaresOptions::intercept`].
    pub intercepts: Vec<f64>,
    /// `|A x - b|` for each target, from the Schur complement of B; 0 where it is below the
    /// rounding of the matrix.
    pub residual_norms: Vec<f64>,
    /// `1 - |A x - b|^2 / |b|^2`, with b about its mean where the matrix is; 1 for a residual of 0.
    pub r_squared: Vec<f64>,
    /// The F statistic of each target, that all coefficients but the intercept are 0: the square
    /// of the fit (about its mean where the matrix is) over the rank, over that of the residual
    /// over the degrees of freedom. Infinite for a residual of 0; NaN with a ridge, for rank 0 and
    /// without degrees of freedom.
    pub f_statistics: Vec<f64>,
    /// The standard error of each coefficient, n x k; with columns that depend on others, that of
    /// the solution of least norm. NaN without degrees of freedom, 0 x 0 when not requested.
    pub standard_errors: Mat<f64>,
    /// The standard error of each intercept; none without intercept or when not requested.
    pub intercept_errors: Vec<f64>,
    /// Columns of A that do not depend on others, as far as the precision can tell.
    pub rank: usize,
    /// The other columns.
    pub dependent: Vec<usize>,
    /// Estimate of the condition number of A (of A over `ridge^(1/2) I`), about the mean where the
    /// matrix is: [`PivotedCholesky::condition`].
    pub condition: f64,
    /// Rows whose weight is not 0.
    pub observations: u64,
    /// Observations less the rank, and less one more where the matrix is about the mean.
    pub degrees_of_freedom: u64,
    /// Decimal digits of the coefficients, relative to the largest when columns have norm 1, that
    /// agree with the exact solution for the rows as they are given, from 0 to 15.95: those of
    /// `n K^2 2^-156` where no entry was rounded, else of `n K^2 2^-80`, with K as in
    /// [`PivotedCholesky::scaled_condition`]. `n K^2 2^-104` counts where refinement ended early.
    pub digits: f64,
    /// None unless standard errors were requested.
    pub(crate) spread: Option<Spread>,
}

/// The squared lengths of a residual and of the fit, for a scaled target.
struct Squares {
    residual: f64,
    fit: f64,
}

/// Columns of A and targets of a Gram matrix.
struct Problem<'a> {
    gram: &'a ExtendedGram,
    /// Columns of A.
    n: usize,
    ridge: f64,
    /// Scales of the targets.
    exponents: Vec<i32>,
}

impl Problem<'_> {
    /// Returns an entry of the matrix that is inverted.
    fn entry(&self, i: usize, j: usize) -> [f64; 3] {
        let entry = self.gram.entry(i, j);
        if i != j || self.ridge == 0.0 {
            return entry;
        }
        let mut sum = TripleSum::default();
        sum.add_parts(entry);
        sum.add(self.ridge);
        sum.parts()
    }

    /// Returns an entry of `A^T B`, scaled, in the order of the factor.
    fn right(&self, factor: &PivotedCholesky, i: usize, q: usize) -> [f64; 3] {
        let column = factor.order[i];
        let exponent = -factor.exponents[column] - self.exponents[q];
        self.gram.entry(column, self.n + q).map(|part| scaled(part, exponent))
    }

    /// Returns `A^T B`, scaled, in the order of the factor and without dependent columns.
    fn right_sides(&self, factor: &PivotedCholesky) -> Result<Columns<3>> {
        let targets = self.exponents.len();
        let mut right = Columns::new(factor.rank, targets)?;
        for q in 0..targets {
            (0..factor.rank).for_each(|i| right.set(i, q, self.right(factor, i, q)));
        }
        Ok(right)
    }

    /// Returns the square of a target, scaled.
    fn square(&self, q: usize) -> [f64; 3] {
        let at = self.n + q;
        self.gram.entry(at, at).map(|part| scaled(part, -2 * self.exponents[q]))
    }

    /// Returns `|A x - b|^2` of each target, scaled, and what it is less than `|b|^2`, for a
    /// solution and the residual of its equations.
    ///
    /// It is `b^T b - x^T A^T b - x^T r`, with r the residual of the equations without the ridge,
    /// so that errors of x enter only as squares.
    fn squares(&self, factor: &PivotedCholesky, x: &Columns<2>, rest: &Columns<3>) -> Vec<Squares> {
        // The accuracy of sums in three parts, and of those of rounded entries.
        let unit = 2f64.powi(if self.gram.is_exact() { -150 } else { -79 });
        let squares = |q: usize| {
            let mut sum = TripleSum::default();
            sum.add_parts(self.square(q));
            let mut size = self.square(q)[0].sqrt();
            for i in 0..factor.rank {
                let value = x.double(q, i);
                let minus = [-value.hi, -value.lo, 0.0];
                sum.add_products(self.right(factor, i, q), minus);
                sum.add_products(rest.get(i, q), minus);
                // The ridge makes the residual larger by ridge x.
                let ridge = scaled(self.ridge, -2 * factor.exponents[factor.order[i]]);
                let square = value * value;
                sum.add_products([square.hi, square.lo, 0.0], [-ridge, 0.0, 0.0]);
                size += 2.0 * value.hi.abs();
            }
            let residual = sum.double().hi;
            let noise = (factor.rank + 2) as f64 * unit * size * size;
            let mut fit = TripleSum::default();
            fit.add_parts(self.square(q));
            fit.add_parts(sum.parts().map(|part| -part));
            let fit = fit.double().hi;
            let positive = |square: f64| if square > noise { square } else { 0.0 };
            Squares { residual: positive(residual), fit: positive(fit) }
        };
        (0..self.exponents.len()).map(squares).collect()
    }

    /// Returns [`LeastSquares::residual_norms`], from [`Problem::squares`].
    fn residual_norms(&self, squares: &[Squares]) -> Vec<f64> {
        let norms = squares.iter().zip(&self.exponents);
        norms.map(|(square, &exponent)| scaled(square.residual.sqrt(), exponent)).collect()
    }

    /// Returns [`LeastSquares::r_squared`], from [`Problem::squares`].
    fn r_squared(&self, squares: &[Squares]) -> Vec<f64> {
        let share = |(q, square): (usize, &Squares)| match square.residual == 0.0 {
            true => 1.0,
            false => 1.0 - square.residual / self.square(q)[0],
        };
        squares.iter().enumerate().map(share).collect()
    }

    /// Returns [`LeastSquares::f_statistics`], from [`Problem::squares`].
    fn f_statistics(&self, squares: &[Squares], rank: usize, freedom: u64) -> Vec<f64> {
        let statistic = |square: &Squares| match self.ridge == 0.0 && rank > 0 && freedom > 0 {
            true => square.fit / rank as f64 / (square.residual / freedom as f64),
            false => f64::NAN,
        };
        squares.iter().map(statistic).collect()
    }

    /// Returns the two parts of the coefficients, n x k, from those of the scaled targets, by rows
    /// in the order of the factor.
    fn coefficients(
        &self,
        factor: &PivotedCholesky,
        x: &Columns<2>,
    ) -> Result<(Mat<f64>, Mat<f64>)> {
        let targets = self.exponents.len();
        let (mut high, mut low) = (zeros(self.n, targets)?, zeros(self.n, targets)?);
        for (i, &column) in factor.order().iter().enumerate() {
            for q in 0..targets {
                let value = x.double(q, i).scaled(self.exponents[q]);
                (high[(column, q)], low[(column, q)]) = (value.hi, value.lo);
            }
        }
        Ok((high, low))
    }
}

/// Completes solutions of the scaled equations, which have no dependent columns.
struct Completion<'a> {
    factor: &'a PivotedCholesky,
    /// None without dependent columns.
    row_space: Option<RowSpace>,
    par: Par,
}

impl Completion<'_> {
    /// Adds the dependent columns to solutions, by rows in the order of the factor, and undoes the
    /// scaling of all columns.
    fn of(&self, rows: &Columns<2>) -> Result<Columns<2>> {
        let mut all = Columns::new(rows.rows, self.factor.n())?;
        for i in 0..self.factor.rank {
            (0..rows.rows).for_each(|q| all.set(q, i, rows.get(q, i)));
        }
        self.factor.rescale(&mut all);
        if let Some(row_space) = &self.row_space {
            row_space.project(&mut all, self.par)?;
        }
        Ok(all)
    }
}

impl LeastSquares {
    /// Solves with the last `targets` columns of the rows as B, and the other columns as A. The
    /// result is the same, bit for bit, for every `options.par`.
    ///
    /// ```
    /// use catamaran::rows::ExtendedGram;
    /// use catamaran::faer::mat;
    /// use catamaran::solve::{LeastSquares, LeastSquaresOptions, RankDeficiency};
    ///
    /// // Both columns of A are equal: the solution of least norm is (1, 1).
    /// let rows = mat![[1.0, 1.0, 2.0], [2.0, 2.0, 4.0]];
    /// let c = rows.transpose() * &rows;
    /// let gram = ExtendedGram::from_f64(c.as_ref(), 2, &[])?;
    /// let options = LeastSquaresOptions::new();
    /// let found = LeastSquares::from_gram(&gram, 1, &options)?;
    /// assert!(found.rank == 1 && (found.coefficients[(0, 0)] - 1.0).abs() < 1e-15);
    /// let refuse = options.rank_deficiency(RankDeficiency::Refuse);
    /// assert!(LeastSquares::from_gram(&gram, 1, &refuse).is_err());
    /// # Ok::<(), catamaran::Error>(())
    /// ```
    ///
    /// # Errors
    /// [`Error::Argument`] when `targets` is 0 or more than the columns, for options out of range,
    /// for an intercept of a matrix that is not about the mean, and for columns that depend on
    /// others if they are refused; else as [`PivotedCholesky::from_gram`], of "A" or "B".
    pub fn from_gram(
        gram: &ExtendedGram,
        targets: usize,
        options: &LeastSquaresOptions,
    ) -> Result<Self> {
        let par = options.par;
        let problem = checked(gram, targets, options)?;
        let n = problem.n;
        let entry = |i: usize, j: usize| problem.entry(i, j);
        let least = tolerance(n, gram.is_exact());
        let factor = PivotedCholesky::of(n, least, Pivoting::Scaled, par, entry)?;
        let rank = factor.rank();
        if options.rank_deficiency == RankDeficiency::Refuse {
            refuse_dependent(factor.dependent())?;
        }
        let refined = Refined::new(&factor, par, entry)?;
        let right = problem.right_sides(&factor)?;
        let (x, outcome) = refined.solve(&right)?;
        let squares = problem.squares(&factor, &x, &refined.residual(&right, &x)?);
        let row_space = match rank < n {
            true => Some(RowSpace::new(&factor, &refined, par, entry)?),
            false => None,
        };
        let completion = Completion { factor: &factor, row_space, par };
        let (coefficients, coefficients_low) =
            problem.coefficients(&factor, &completion.of(&x)?)?;
        let centered = u64::from(!gram.mean().is_empty());
        let freedom = gram.observations().saturating_sub(rank as u64 + centered);
        let mut found = Self {
            intercepts: vec![0.0; targets],
            residual_norms: problem.residual_norms(&squares),
            r_squared: problem.r_squared(&squares),
            f_statistics: problem.f_statistics(&squares, rank, freedom),
            coefficients,
            coefficients_low,
            standard_errors: Mat::new(),
            intercept_errors: Vec::new(),
            rank,
            dependent: factor.dependent().to_vec(),
            condition: factor.condition()?,
            observations: gram.observations(),
            degrees_of_freedom: freedom,
            digits: digits(&factor, gram.is_exact(), outcome)?,
            spread: None,
        };
        if options.intercept {
            found.intercepts = (0..targets).map(|q| found.intercept(gram, q)).collect();
        }
        if options.standard_errors {
            let spread = completion.of(&spread(&problem, &factor, par)?)?;
            let spread = Spread::new(gram, factor.order(), &spread, options.intercept)?;
            found.add_errors(&spread, options.intercept)?;
            found.spread = Some(spread);
        }
        Ok(found)
    }

    /// Returns the intercept of target q, `mean b - mean a^T x`.
    fn intercept(&self, gram: &ExtendedGram, q: usize) -> f64 {
        let n = self.coefficients.nrows();
        let mut sum = TripleSum::default();
        let triple = |[hi, lo]: [f64; 2]| [hi, lo, 0.0];
        sum.add_parts(triple(gram.mean()[n + q]));
        for j in 0..n {
            let x = [-self.coefficients[(j, q)], -self.coefficients_low[(j, q)], 0.0];
            sum.add_products(triple(gram.mean()[j]), x);
        }
        sum.rounded()
    }

    /// Computes standard errors.
    fn add_errors(&mut self, spread: &Spread, intercept: bool) -> Result<()> {
        let (n, targets) = self.coefficients.shape();
        let deviations = deviations(&self.residual_norms, self.degrees_of_freedom);
        let mut errors = zeros(n, targets)?;
        for j in 0..n {
            let length = spread.length(j);
            (0..targets).for_each(|q| errors[(j, q)] = deviations[q] * length);
        }
        self.standard_errors = errors;
        if intercept {
            let length = spread.intercept_length();
            self.intercept_errors = deviations.iter().map(|d| d * length).collect();
        }
        Ok(())
    }
}

/// Checks the arguments and returns the problem.
fn checked<'a>(
    gram: &'a ExtendedGram,
    targets: usize,
    options: &LeastSquaresOptions,
) -> Result<Problem<'a>> {
    let refuse = |what, why| Err(Error::Argument { what, why });
    if targets == 0 || targets > gram.n() {
        let why = match gram.n() {
            0 => "must be at least 1, but the rows have no columns".into(),
            n => format!("must be from 1 to {n} (columns), but is {targets}"),
        };
        return refuse("targets", why);
    }
    options.check_ranges()?;
    if options.intercept && gram.mean().len() != gram.n() {
        return refuse("intercept", "needs a Gram matrix about the mean".into());
    }
    let n = gram.n() - targets;
    check_lengths(gram, n)?;
    let exponents = (n..gram.n()).map(|b| exponent(gram.entry(b, b)[0])).collect();
    Ok(Problem { gram, n, ridge: options.ridge, exponents })
}

/// Returns an error that names the columns, if there are any.
fn refuse_dependent(columns: &[usize]) -> Result<()> {
    let verb = match columns.len() {
        0 => return Ok(()),
        1 => "depends",
        _ => "depend",
    };
    let why = format!("{} {verb} on others", named(columns));
    Err(Error::Argument { what: "A", why })
}

/// Returns F, scaled and by rows, for which `F F^T` is the covariance of coefficients whose
/// residuals have variance 1: `F = R^-1`, and `(C + ridge I)^-1 R^T` for the R of C with a ridge.
fn spread(problem: &Problem<'_>, factor: &PivotedCholesky, par: Par) -> Result<Columns<2>> {
    if problem.ridge == 0.0 {
        return factor.inverse(par);
    }
    let n = problem.n;
    let entry = |i: usize, j: usize| problem.gram.entry(i, j);
    let least = tolerance(n, problem.gram.is_exact());
    let plain = PivotedCholesky::of(n, least, Pivoting::Scaled, par, entry)?;
    let mut position = vec![0; n];
    plain.order().iter().enumerate().for_each(|(i, &column)| position[column] = i);
    let mut rows = Columns::new(plain.rank(), factor.rank())?;
    for (i, &column) in factor.order()[..factor.rank()].iter().enumerate() {
        let exponent = plain.exponents[column] - factor.exponents[column];
        for k in 0..plain.rank() {
            let value = plain.lower.double(position[column], k).scaled(exponent);
            rows.set_double(k, i, value);
        }
    }
    factor.solve_transposed(&mut rows, par)?;
    factor.solve(&mut rows, par)?;
    Ok(rows)
}

/// Returns [`LeastSquares::digits`].
fn digits(factor: &PivotedCholesky, exact: bool, outcome: Outcome) -> Result<f64> {
    let unit = match (exact, outcome) {
        (true, Outcome::Converged) => -156,
        (true, Outcome::Stalled) => -104,
        (false, _) => -80,
    };
    let condition = factor.scaled_condition()?;
    let error = factor.n().max(1) as f64 * condition * condition * 2f64.powi(unit);
    let most = f64::from(f64::MANTISSA_DIGITS) * std::f64::consts::LOG10_2;
    Ok((-error.log10()).clamp(0.0, most))
}
