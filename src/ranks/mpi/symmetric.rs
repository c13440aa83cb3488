use faer::MatMut;
use faer::prelude::ReborrowMut;

use super::call::Call;
use super::exchange::all_gather;
use super::memory::Buffer;
use super::tags::GATHER;
use super::transfer::{receive, send};
use super::world::{MpiReal, Operation, World, fact};
use crate::base::{Error, Real, Result};
use crate::product::Uplo;
use crate::ranks::plan::TriangleLayout;

/// A symmetric matrix whose lower triangle is distributed over the ranks.
///
/// ```no_run
/// use catamaran::ranks::{World, ata_rows};
/// use catamaran::{AtaOptions, Uplo, faer::Mat};
///
/// # let start = mpi::initialize_with_threading(mpi::Threading::Funneled);
/// # let (universe, _) = start.expect("MPI is started once");
/// # let world = World::new(&universe.world())?;
/// let own = Mat::<f64>::ones(100, 8);
/// let spread = ata_rows(&world, 1.0, own.as_ref(), &AtaOptions::new())?;
/// let mut c = (world.rank() == 0).then(|| Mat::zeros(8, 8));
/// spread.gather(&world, 0, c.as_mut().map(|c| c.as_mut()), Uplo::Both)?;
/// assert!(c.is_none_or(|c| c[(0, 7)] == 100.0 * world.size() as f64));
/// # Ok::<(), catamaran::Error>(())
/// ```
#[derive(Debug, Clone)]
pub struct Symmetric<T> {
    layout: TriangleLayout,
    rank: usize,
    /// The entries of this rank, in the order of its segments.
    entries: Vec<T>,
}

impl<T: Real> Symmetric<T> {
    /// Creates the matrix from the `entries` of `rank`.
    pub(super) fn new(layout: TriangleLayout, rank: usize, entries: Vec<T>) -> Self {
        debug_assert_eq!(layout.len(rank), entries.len());
        Self { layout, rank, entries }
    }

    /// Returns the number of rows and columns.
    pub fn n(&self) -> usize {
        self.layout.n()
    }

    /// Returns the layout: which rank holds which entries.
    pub fn layout(&self) -> &TriangleLayout {
        &self.layout
    }

    /// Returns the entries of this rank, in the order of its segments.
    pub fn entries(&self) -> &[T] {
        &self.entries
    }

    /// Calls `each(i, j, entries (i, j..))` for every segment of this rank, in order.
    pub fn for_each_segment(&self, mut each: impl FnMut(usize, usize, &[T])) {
        let mut rest = &self.entries[..];
        for segment in self.layout.segments(self.rank) {
            let (entries, others) = rest.split_at(segment.cols.len());
            each(segment.row, segment.cols.start, entries);
            rest = others;
        }
    }
}

impl<T: MpiReal> Symmetric<T> {
    /// Gathers the whole matrix in `c` on rank `root`, the triangles of `uplo`. The other ranks
    /// pass `None`.
    ///
    /// # Errors
    /// [`Error::Shape`] when C is not n x n or missing on the root, [`Error::OutOfMemory`];
    /// [`Error::Rank`].
    pub fn gather(
        &self,
        world: &World,
        root: usize,
        c: Option<MatMut<'_, T>>,
        uplo: Uplo,
    ) -> Result<()> {
        let _guard = world.abort_on_panic();
        let is_root = world.rank() == root;
        let longest = (0..world.size()).map(|rank| self.layout.len(rank)).max().unwrap_or(0);
        let prepared = world.check_root(root).and_then(|()| match &c {
            Some(c) if is_root => Error::check_shape("C", (self.n(), self.n()), c.shape())
                .and_then(|()| Buffer::of_len(longest)),
            None if is_root => {
                Err(Error::Argument { what: "C", why: "missing on the root".into() })
            }
            _ => Ok(Buffer::default()),
        });
        let facts = [fact("n", self.n()), fact("root", root)];
        let mut buffer = world.begin(Operation::Gather, &facts, prepared)?;
        let Some(mut c) = c.filter(|_| is_root) else {
            send(world, &self.entries, root, GATHER);
            return Ok(());
        };
        for rank in 0..world.size() {
            let entries = if rank == root {
                &self.entries[..]
            } else {
                // One rank at a time, so that no more memory than a share is needed.
                let entries = &mut buffer[..self.layout.len(rank)];
                receive(world, entries, rank, GATHER);
                entries
            };
            let mut entries = entries.iter();
            for segment in self.layout.segments(rank) {
                for (j, &entry) in segment.cols.zip(&mut entries) {
                    put(c.rb_mut(), segment.row, j, entry, uplo);
                }
            }
        }
        Ok(())
    }
}

impl<T: MpiReal> Symmetric<T> {
    /// Writes the whole matrix, both triangles, into `c` (n x n) on every rank.
    pub(super) fn spread(&self, call: &Call<'_>, mut c: MatMut<'_, T>) -> Result<()> {
        let lens: Vec<usize> = (0..call.world.size()).map(|rank| self.layout.len(rank)).collect();
        let entries = all_gather(call, &self.entries, &lens)?;
        let mut entries = entries.iter();
        for rank in 0..call.world.size() {
            for segment in self.layout.segments(rank) {
                for (j, &entry) in segment.cols.zip(&mut entries) {
                    put(c.rb_mut(), segment.row, j, entry, Uplo::Both);
                }
            }
        }
        Ok(())
    }
}

/// Writes an entry of the lower triangle into the triangles of `uplo`.
fn put<T: Copy>(mut c: MatMut<'_, T>, i: usize, j: usize, value: T, uplo: Uplo) {
    if uplo != Uplo::Upper {
        c[(i, j)] = value;
    }
    if uplo != Uplo::Lower {
        c[(j, i)] = value;
    }
}
