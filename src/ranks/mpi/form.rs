use ::mpi::collective::Root;
use ::mpi::topology::Communicator;
use faer::{MatMut, MatRef};

use super::pending_send::PendingSend;
use super::tags::Tag;
use super::world::{MpiReal, World};
use crate::product::Uplo;

/// What the root broadcasts to the other ranks.
#[derive(Clone, Copy)]
pub(super) struct Form {
    pub(super) root: usize,
    pub(super) m: usize,
    pub(super) n: usize,
    /// Whether A and its parts are stored, and sent, row by row, and not column by column.
    a_by_rows: bool,
    /// The same for C, transposed if its upper triangle is wanted.
    pub(super) c_by_rows: bool,
}

impl Form {
    /// Returns the form of the root on all ranks.
    pub(super) fn broadcast<T>(
        world: &World,
        root: usize,
        matrices: Option<&(MatRef<'_, T>, MatMut<'_, T>)>,
        uplo: Uplo,
    ) -> Self {
        let mut numbers = [0_u64; 4];
        if let Some((a, c)) = matrices {
            let by_rows = |x: isize, y: isize| x.unsigned_abs() > y.unsigned_abs();
            let c_by_rows = by_rows(c.row_stride(), c.col_stride()) != (uplo == Uplo::Upper);
            let a_by_rows = by_rows(a.row_stride(), a.col_stride());
            numbers = [a.nrows() as u64, a.ncols() as u64, a_by_rows.into(), c_by_rows.into()];
        }
        world.communicator().process_at_rank(root as i32).broadcast_into(&mut numbers);
        let [m, n, a_by_rows, c_by_rows] = numbers;
        let (m, n) = (m as usize, n as usize);
        Self { root, m, n, a_by_rows: a_by_rows != 0, c_by_rows: c_by_rows != 0 }
    }

    /// Returns the number of this rank in plans, in which the root is process 0.
    pub(super) fn process(self, rank: usize, size: usize) -> usize {
        (rank + size - self.root) % size
    }

    /// Returns the rank of a process.
    pub(super) fn rank(self, process: usize, size: usize) -> usize {
        (process + self.root) % size
    }

    /// Returns a view of a part of A that was sent by [`Form::start_send`].
    pub(super) fn part_of_a<T>(self, entries: &[T], rows: usize, cols: usize) -> MatRef<'_, T> {
        match self.a_by_rows {
            true => MatRef::from_row_major_slice(entries, rows, cols),
            false => MatRef::from_column_major_slice(entries, rows, cols),
        }
    }

    /// Starts to send parts of A to rank `to`.
    pub(super) fn start_send<'a, T: MpiReal>(
        self,
        world: &'a World,
        parts: &[MatRef<'a, T>],
        to: usize,
        tag: Tag,
    ) -> PendingSend<'a, T> {
        if self.a_by_rows {
            let parts: Vec<_> = parts.iter().map(|part| part.transpose()).collect();
            PendingSend::send(world, &parts, to, tag)
        } else {
            PendingSend::send(world, parts, to, tag)
        }
    }
}
