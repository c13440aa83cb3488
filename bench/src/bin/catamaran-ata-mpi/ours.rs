//! Our side of the race: the parts of A of this rank, and the product.

use std::ops::Range;
use std::path::Path;

use catamaran::io::RowFile;
use catamaran::product::{Verification, verify};
use catamaran::ranks::plan::{Bricks, Mode, Place};
use catamaran::ranks::{
    MpiReal, Symmetric, World, ata_bricks, ata_columns, ata_deal, ata_rows, ata_tree,
};
use catamaran::rows::RowBlocks;
use catamaran::{AtaOptions, Uplo, ranks};
use catamaran_bench::Result;
use faer::{MatMut, MatRef};

use crate::job::{Job, filled};
use crate::ranks::Ranks;

/// The rank that has A and C in the modes [`from one rank`](Place::OneRank), and that gathers
/// results.
pub const ROOT: usize = 0;

/// A product and its operands in memory.
pub struct Ours<'w, T> {
    world: &'w World,
    job: Job,
    options: AtaOptions<'static>,
    /// Those of the mode `bricks`.
    bricks: Bricks,
    /// The rows and columns of A that this rank has.
    part: [Range<usize>; 2],
    /// These parts of A, row-major.
    a: Vec<T>,
    /// C, n x n, row-major, on the root if it is in one place; otherwise empty.
    c: Vec<T>,
    result: Option<Symmetric<T>>,
}

impl<'w, T: MpiReal> Ours<'w, T> {
    /// Generates this rank's part of A, or reads its rows from `file`.
    ///
    /// # Errors
    /// When there is not enough memory, or the file can't be read.
    pub fn new(world: &'w World, job: Job, file: Option<&Path>) -> Result<Self> {
        let (m, n) = (job.shape.m, job.shape.n);
        let share = |len: usize| {
            let start = |rank: usize| (len as u128 * rank as u128 / world.size() as u128) as usize;
            start(world.rank())..start(world.rank() + 1)
        };
        let is_root = world.rank() == ROOT;
        let bricks = Bricks::new(world.size(), m, n);
        let part = match job.mode {
            Mode::Tree | Mode::Deal if is_root => [0..m, 0..n],
            Mode::Tree | Mode::Deal => [0..0, 0..n],
            Mode::Rows => [share(m), 0..n],
            Mode::Columns => [0..m, share(n)],
            Mode::Bricks => [bricks.rows(world.rank()), bricks.columns(world.rank())],
        };
        let [rows, cols] = &part;
        let mut a = filled(rows.len(), cols.len(), |i, j| match file {
            None => job.entry(rows.start + i, cols.start + j),
            Some(_) => T::ZERO,
        })?;
        if let Some(file) = file {
            let out = MatMut::from_row_major_slice_mut(&mut a, rows.len(), cols.len());
            RowBlocks::<T>::read(&mut RowFile::open(file)?, rows.start, out)?;
        }
        let side = if job.mode.place() == Place::OneRank && is_root { n } else { 0 };
        let c = filled(side, side, |_, _| T::from_f64(f64::NAN))?;
        let options = job.options();
        Ok(Self { world, job, options, bricks, part, a, c, result: None })
    }

    /// Drops the previous result, or makes it invalid.
    pub fn forget(&mut self) {
        self.result = None;
        self.c.fill(T::from_f64(f64::NAN));
    }

    /// Computes the product.
    ///
    /// # Errors
    /// The errors of the library, on all ranks.
    pub fn run(&mut self) -> Result<()> {
        let (world, one) = (self.world, T::ONE);
        let a = view(&self.a, &self.part);
        match self.job.mode {
            Mode::Tree | Mode::Deal => {
                let n = self.job.shape.n;
                let mine = (world.rank() == ROOT)
                    .then(|| (a, MatMut::from_row_major_slice_mut(&mut self.c, n, n)));
                let (a, c) = mine.unzip();
                let product = if self.job.mode == Mode::Tree { ata_tree } else { ata_deal };
                product(world, ROOT, one, a, T::ZERO, c, &self.options)?;
            }
            Mode::Rows => self.result = Some(ata_rows(world, one, a, &self.options)?),
            Mode::Columns => {
                self.result = Some(ata_columns(world, one, a, &self.options)?);
            }
            Mode::Bricks => {
                self.result = Some(ata_bricks(world, one, &self.bricks, a, &self.options)?);
            }
        }
        Ok(())
    }

    /// Checks the last result with `rounds` random vectors; returns the verdict, at least on the
    /// root.
    ///
    /// # Errors
    /// The errors of the library; on the root only if C is there.
    pub fn verify(&self, rounds: u32) -> Result<Option<Verification>> {
        let a = view(&self.a, &self.part);
        let distributed = match self.job.mode {
            Mode::Rows => ranks::Distributed::Rows(a),
            Mode::Bricks => ranks::Distributed::Bricks(a, &self.bricks),
            _ => ranks::Distributed::Columns(a),
        };
        let (n, seed) = (self.job.shape.n, self.job.seed);
        Ok(match &self.result {
            Some(result) => {
                Some(ranks::verify(self.world, 1.0, distributed, result, rounds, seed)?)
            }
            None if self.world.rank() == ROOT => {
                let c = MatRef::from_row_major_slice(&self.c, n, n);
                Some(verify(1.0, a, c, Uplo::Lower, rounds, seed)?)
            }
            None => None,
        })
    }

    /// Returns C on the root, n x n, row-major, in its lower triangle; empty on other ranks.
    ///
    /// # Errors
    /// The errors of the library, and when there is not enough memory; on all ranks.
    pub fn into_lower(mut self, ranks: &Ranks<'_>) -> Result<Vec<T>> {
        let Some(result) = self.result else { return Ok(self.c) };
        let side = if self.world.rank() == ROOT { self.job.shape.n } else { 0 };
        self.a = Vec::new();
        self.c = ranks.agree(filled(side, side, |_, _| T::from_f64(f64::NAN)))?;
        let c = MatMut::from_row_major_slice_mut(&mut self.c, side, side);
        result.gather(self.world, ROOT, (side > 0).then_some(c), Uplo::Lower)?;
        Ok(self.c)
    }
}

fn view<'a, T>(a: &'a [T], [rows, cols]: &[Range<usize>; 2]) -> MatRef<'a, T> {
    MatRef::from_row_major_slice(a, rows.len(), cols.len())
}
