//! Powers of two that keep squares of lengths in range.

use faer::prelude::{Reborrow, ReborrowMut};
use faer::{ColMut, MatMut};

use crate::base::{Error, Result};
use crate::dense::zeros;
use crate::kernel::int8::scaled;
use crate::sparse::InnerSpace;

/// What the columns of a matrix were divided by: powers of two, and 1 where the largest entry is
/// between 2^-128 and 2^128.
pub(super) struct ColumnPowers(Vec<i32>);

impl ColumnPowers {
    /// Divides columns whose largest entry is far from 1 by powers of two, the same on all
    /// processes, so that squares of lengths neither overflow nor underflow.
    pub fn bring_near_one(a: MatMut<'_, f64>, space: &dyn InnerSpace) -> Result<Self> {
        /// Exponents of a bin; those of the middle one are between -128 and 128.
        const WIDTH: i32 = 256;
        /// Bins below and above the middle one: exponents lie between -1074 and 1023.
        const BESIDE: i32 = 4;
        const BINS: usize = 2 * BESIDE as usize + 1;
        // How many processes have the largest entry of a column in each bin.
        let mut counts = zeros(BINS, a.ncols())?;
        for (j, column) in a.rb().col_iter().enumerate() {
            let largest = column.norm_max();
            if largest > 0.0 {
                let bin = (largest.log2() as i32 + WIDTH / 2).div_euclid(WIDTH) + BESIDE;
                counts[(bin as usize, j)] = 1.0;
            }
        }
        space.sum(counts.as_mut())?;
        let exponent = |j: usize| {
            let highest = (0..BINS).rev().find(|&bin| counts[(bin, j)] > 0.0);
            highest.map_or(0, |bin| (bin as i32 - BESIDE) * WIDTH)
        };
        let exponents: Vec<i32> = (0..a.ncols()).map(exponent).collect();
        for (column, &exponent) in a.col_iter_mut().zip(&exponents) {
            multiply_by_power(column, -exponent);
        }
        Ok(Self(exponents))
    }

    /// Multiplies the columns of the factor R by the powers.
    ///
    /// # Errors
    /// [`Error::Argument`] of "A" for a column whose length overflows.
    pub fn undo(&self, r: MatMut<'_, f64>) -> Result<()> {
        for (j, (mut column, &exponent)) in r.col_iter_mut().zip(&self.0).enumerate() {
            multiply_by_power(column.rb_mut(), exponent);
            if column.iter().any(|x| !x.is_finite()) {
                let why = format!("column {j} is too long: its length overflows");
                return Err(Error::Argument { what: "A", why });
            }
        }
        Ok(())
    }
}

/// Multiplies a column by `2^exponent`.
fn multiply_by_power(column: ColMut<'_, f64>, exponent: i32) {
    if exponent != 0 {
        column.iter_mut().for_each(|x| *x = scaled(*x, exponent));
    }
}
