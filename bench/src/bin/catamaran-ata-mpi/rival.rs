//! The rival's side: pdsyrk or pssyrk, with the best of several distributions.

use std::fmt;

use catamaran::Real;
use catamaran::ranks::plan::Mode;
use catamaran_bench::Result;

use crate::job::Job;
use crate::ranks::Ranks;
use crate::scalapack::{Distributed, Grid, Scalapack};

/// Sides of blocks to try.
const BLOCKS: [usize; 3] = [64, 128, 256];
/// Runs of each distribution before the race; the first one includes the creation of threads and
/// buffers.
const TRIALS: usize = 2;

/// The distribution of the rival's matrices.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Distribution {
    /// Rows and columns of processes.
    grid: [usize; 2],
    /// Rows and columns of a block.
    block: usize,
    /// Whether the rival gets A^T.
    transposed: bool,
}

impl Distribution {
    /// Returns the distributions to try on this number of ranks: A on all grids of more than one
    /// row; A^T on a row of processes, where it is faster.
    fn all(ranks: usize) -> impl Iterator<Item = Self> {
        let rows = (1..=ranks).filter(move |rows| ranks.is_multiple_of(*rows));
        rows.flat_map(move |rows| {
            let grid = [rows, ranks / rows];
            BLOCKS.map(|block| Self { grid, block, transposed: rows == 1 })
        })
    }

    /// Returns the process grid of the distribution.
    pub fn grid<'s, T>(&self, scalapack: &'s Scalapack<T>) -> Grid<'s, T> {
        scalapack.grid(self.grid[0], self.grid[1])
    }
}

impl fmt::Display for Distribution {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Self { grid: [rows, cols], block, transposed } = self;
        write!(f, "{} {rows}x{cols} NB {block}", if *transposed { "A^T" } else { "A" })
    }
}

/// A product and its operands in memory.
pub struct Pdsyrk<'g, T> {
    transposed: bool,
    a: Distributed<'g, T>,
    c: Distributed<'g, T>,
    /// A and C on the root alone, if they are there before and after the product.
    whole: Option<[Distributed<'g, T>; 2]>,
}

impl<'g, T: Real> Pdsyrk<'g, T> {
    /// Generates this rank's part of A.
    ///
    /// # Errors
    /// When there is not enough memory, or a side is too long.
    pub fn new(grid: &'g Grid<'_, T>, job: Job, distribution: Distribution) -> Result<Self> {
        let (m, n) = (job.shape.m, job.shape.n);
        let Distribution { block, transposed, .. } = distribution;
        let shape = if transposed { [n, m] } else { [m, n] };
        let entry = |i, j| if transposed { job.entry(j, i) } else { job.entry(i, j) };
        let nan = |_, _| T::from_f64(f64::NAN);
        let c = grid.matrix([n; 2], [block; 2], nan)?;
        let (a, whole) = match job.mode {
            // A single block holds everything.
            Mode::Tree | Mode::Deal => {
                let whole = [grid.matrix(shape, shape, entry)?, grid.matrix([n; 2], [n; 2], nan)?];
                (grid.matrix(shape, [block; 2], nan)?, Some(whole))
            }
            _ => (grid.matrix(shape, [block; 2], entry)?, None),
        };
        Ok(Self { transposed, a, c, whole })
    }

    /// Invalidates the previous result.
    pub fn forget(&mut self) {
        self.c.entries.fill(T::from_f64(f64::NAN));
        if let Some([_, c]) = &mut self.whole {
            c.entries.fill(T::from_f64(f64::NAN));
        }
    }

    /// Computes the product, including transfers from and to the root if A and C are there.
    pub fn run(&mut self) {
        if let Some([a, _]) = &self.whole {
            self.a.copy_from_one(a);
        }
        self.c.set_to_syrk(&self.a, self.transposed);
        if let Some([_, c]) = &mut self.whole {
            c.copy_lower_from(&self.c);
        }
    }

    /// Returns C on the root, n x n, column-major, in its lower triangle; empty on other ranks.
    ///
    /// # Errors
    /// When there is not enough memory.
    pub fn into_lower(self, grid: &Grid<'_, T>, ranks: &Ranks<'_>, n: usize) -> Result<Vec<T>> {
        let Self { a, c, whole, .. } = self;
        drop(a);
        if let Some([_, c]) = whole {
            return Ok(c.entries);
        }
        let mut whole = ranks.agree(grid.matrix([n; 2], [n; 2], |_, _| T::ZERO))?;
        whole.copy_lower_from(&c);
        Ok(whole.entries)
    }
}

/// Returns the fastest distribution, the same on every rank; calls `tell` for each one.
///
/// # Errors
/// As [`Pdsyrk::new`].
pub fn fastest<T: Real>(
    scalapack: &Scalapack<T>,
    ranks: &Ranks<'_>,
    job: Job,
    tell: impl Fn(&Distribution, f64),
) -> Result<Distribution> {
    let mut best: Option<(f64, Distribution)> = None;
    for distribution in Distribution::all(ranks.count()) {
        let grid = distribution.grid(scalapack);
        let mut product = ranks.agree(Pdsyrk::new(&grid, job, distribution))?;
        let seconds = (0..TRIALS).map(|_| ranks.largest(ranks.time(|| product.run()).0));
        let seconds = seconds.fold(f64::INFINITY, f64::min);
        tell(&distribution, seconds);
        if best.is_none_or(|(least, _)| seconds < least) {
            best = Some((seconds, distribution));
        }
    }
    best.map(|(_, distribution)| distribution).ok_or_else(|| "no distribution to try".into())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_grid_is_tried() {
        for ranks in 1..=12 {
            let all: Vec<_> = Distribution::all(ranks).collect();
            assert!(all.iter().all(|d| d.grid[0] * d.grid[1] == ranks));
            assert!(all.iter().any(|d| d.grid == [ranks, 1]));
            assert!(all.iter().any(|d| d.grid == [1, ranks] && d.transposed));
        }
        assert_eq!(Distribution::all(4).count(), 9);
    }
}
