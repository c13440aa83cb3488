//! The solution of least norm where columns depend on others.

use super::cholesky::{PivotedCholesky, Pivoting};
use super::columns::Columns;
use super::double::{DoubleDouble, scaled};
use super::refine::Refined;
use crate::base::{Par, Result, widest};

/// The projection of solutions x of a problem whose last columns depend on the first ones to those
/// of least norm: the dependent columns are `A_1 S`, and all solutions are `(x_1 - S z, z)`.
pub(super) struct RowSpace {
    /// S by rows.
    dependence: Columns<2>,
    /// The factor of `I + S^T S`.
    factor: PivotedCholesky,
}

impl RowSpace {
    /// Computes the row space of a matrix with these entries and this factor.
    pub fn new(
        factor: &PivotedCholesky,
        refined: &Refined<'_>,
        par: Par,
        entry: impl Fn(usize, usize) -> [f64; 3],
    ) -> Result<Self> {
        let (rank, others) = (factor.rank, factor.dependent());
        let exponent = |column: usize| factor.exponents[column];
        let mut products = Columns::new(rank, others.len())?;
        for (l, &b) in others.iter().enumerate() {
            for (i, &a) in factor.order[..rank].iter().enumerate() {
                let by = -exponent(a) - exponent(b);
                products.set(i, l, entry(a, b).map(|part| scaled(part, by)));
            }
        }
        let (mut dependence, _) = refined.solve(&products)?;
        for (i, &a) in factor.order[..rank].iter().enumerate() {
            for (l, &b) in others.iter().enumerate() {
                let value = dependence.double(l, i).scaled(exponent(b) - exponent(a));
                dependence.set_double(l, i, value);
            }
        }
        let count = others.len();
        let mut squares = Columns::<2>::new(count, count)?;
        (0..count).for_each(|l| squares.set_double(l, l, DoubleDouble::ONE));
        add_transposed(&mut squares, &dependence, &dependence);
        let entry = |l: usize, m: usize| {
            let [hi, lo] = squares.get(l, m);
            [hi, lo, 0.0]
        };
        let factor = PivotedCholesky::of(count, 0.0, Pivoting::Natural, par, entry)?;
        Ok(Self { dependence, factor })
    }

    /// Replaces solutions, by rows in the order of the columns, by those of least norm.
    pub fn project(&self, x: &mut Columns<2>, par: Par) -> Result<()> {
        let (rank, count) = (self.dependence.cols, self.dependence.rows);
        let mut z = Columns::new(x.rows, count)?;
        add_transposed(&mut z, &self.dependence, x);
        self.factor.solve_symmetric(&mut z, par)?;
        widest(
            #[inline(always)]
            || {
                for i in 0..rank {
                    let mut row = x.pairs_mut(i, 0);
                    row.subtract(
                        z.columns(),
                        count,
                        #[inline(always)]
                        |l| self.dependence.double(l, i),
                    );
                    row.normalize();
                }
            },
        );
        for l in 0..count {
            for q in 0..x.rows {
                x.set_double(q, rank + l, z.double(q, l));
            }
        }
        Ok(())
    }
}

/// Computes `to := to + S^T X`, all by rows; X may have more rows than S.
fn add_transposed(to: &mut Columns<2>, s: &Columns<2>, x: &Columns<2>) {
    widest(
        #[inline(always)]
        || {
            for l in 0..to.cols {
                let mut row = to.pairs_mut(l, 0);
                row.subtract(
                    x.columns(),
                    s.cols,
                    #[inline(always)]
                    |i| -s.double(l, i),
                );
                row.normalize();
            }
        },
    );
}
