//! Entries of C that a NaN or an infinity of A or B reaches: what the classical algorithm gives, without
//! its overflows.

use faer::prelude::Reborrow;
use faer::{MatMut, MatRef};

use super::columns::Columns;
use crate::base::Real;

/// The entries of a column that are not finite.
enum Column {
    /// There is a NaN, which alone decides.
    Nan,
    /// The rows of the infinities.
    Infinite(Vec<usize>),
}

impl Column {
    fn of<T: Real>(a: MatRef<'_, T>, j: usize) -> Self {
        let mut rows = Vec::new();
        for i in 0..a.nrows() {
            let value = a[(i, j)].to_f64();
            if value.is_nan() {
                return Self::Nan;
            }
            if value.is_infinite() {
                rows.push(i);
            }
        }
        Self::Infinite(rows)
    }
}

/// Adds to C what the columns that counted as zeros contribute. Every term that is not finite
/// decides alone or with its opposite, so that the others need not be looked at.
pub(super) fn add<T: Real>(
    alpha: T,
    (a, left): (MatRef<'_, T>, &Columns),
    (b, right): (MatRef<'_, T>, &Columns),
    symmetric: bool,
    mut c: MatMut<'_, T>,
) {
    if left.non_finite.is_empty() && right.non_finite.is_empty() {
        return;
    }
    let of = |m: MatRef<'_, T>, columns: &Columns| {
        let mut all: Vec<Option<Column>> = (0..m.ncols()).map(|_| None).collect();
        for &j in &columns.non_finite {
            all[j] = Some(Column::of(m, j));
        }
        all
    };
    let (rows, cols) = (of(a, left), of(b, right));
    let mut add = |i: usize, j: usize| {
        let sum = sum(a.rb(), i, rows[i].as_ref(), b.rb(), j, cols[j].as_ref());
        let value = c[(i, j)] + alpha * T::from_f64(sum);
        // One NaN, whatever the machine made of it.
        c[(i, j)] = if value.to_f64().is_nan() { T::from_f64(f64::NAN) } else { value };
    };
    for &i in &left.non_finite {
        for j in 0..if symmetric { i + 1 } else { b.ncols() } {
            add(i, j);
        }
    }
    for &j in &right.non_finite {
        for i in if symmetric { j } else { 0 }..a.ncols() {
            if rows[i].is_none() {
                add(i, j);
            }
        }
    }
}

/// The sum of the products of column i of A and j of B that are not finite.
fn sum<T: Real>(
    a: MatRef<'_, T>,
    i: usize,
    left: Option<&Column>,
    b: MatRef<'_, T>,
    j: usize,
    right: Option<&Column>,
) -> f64 {
    let mut sum = 0.0;
    for column in [left, right].into_iter().flatten() {
        match column {
            Column::Nan => return f64::NAN,
            // A row with two infinities counts twice, which changes nothing.
            Column::Infinite(rows) => {
                for &k in rows {
                    sum += a[(k, i)].to_f64() * b[(k, j)].to_f64();
                }
            }
        }
    }
    sum
}
