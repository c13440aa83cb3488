//! Block-cyclic matrices, as in ScaLAPACK: blocks of rows and of columns are dealt out cyclically
//! to the rows and columns of a grid of processes.
//!
//! Source: J. Choi, J. Demmel, I. Dhillon et al., "ScaLAPACK: a portable linear algebra library for
//! distributed memory computers" (1996), and its users' guide, section 4.3.
//!
//! [`Parts`] and [`Delivery`] redistribute such matrices for a product, and back: which rank sends
//! which entries to which, in an order that both sides know without communication.

use std::ops::Range;

use super::bricks::Bricks;
use super::cost::{Mode, predict};
use super::layout::TriangleLayout;
use super::machine::Machine;
use crate::base::{Error, Result, even_part};
use crate::product::Uplo;

/// The only type of descriptor that ScaLAPACK has for dense matrices.
const DENSE: i32 = 1;

/// Indices `0..len` dealt out in blocks: block k goes to part `(first + k) mod parts`.
///
/// ```
/// use catamaran::ranks::plan::{BlockCyclic, Grid, GridOrder};
///
/// // 10 rows in blocks of 3, dealt out to the two rows of a grid.
/// let grid = Grid::new(2, 1, GridOrder::Rows)?;
/// let a = BlockCyclic::new("A", (10, 4), (3, 4), (0, 0), grid)?;
/// let rows = a.rows();
/// assert!(rows.runs(1, 0..10).eq([3..6, 9..10]));
/// assert_eq!((rows.count(0), rows.count(1)), (6, 4));
/// assert_eq!((rows.owner(7), rows.local(7), rows.global(0, 4)), (0, 4, 7));
/// # Ok::<(), catamaran::Error>(())
/// ```
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Dealing {
    len: usize,
    block: usize,
    parts: usize,
    first: usize,
}

impl Dealing {
    /// Returns the number of indices.
    pub fn len(&self) -> usize {
        self.len
    }

    /// Returns whether there are no indices.
    pub fn is_empty(&self) -> bool {
        self.len == 0
    }

    /// Returns the number of indices of a block.
    pub fn block(&self) -> usize {
        self.block
    }

    /// Returns the part that has the first block.
    pub fn first(&self) -> usize {
        self.first
    }

    /// Returns the part that has `index`.
    pub fn owner(&self, index: usize) -> usize {
        (self.first + index / self.block) % self.parts
    }

    /// Returns the position of `index` among the indices of its owner, from 0.
    pub fn local(&self, index: usize) -> usize {
        index / self.block / self.parts * self.block + index % self.block
    }

    /// Returns the index that `part` has at position `local`: the inverse of [`Dealing::local`].
    pub fn global(&self, part: usize, local: usize) -> usize {
        (local / self.block * self.parts + self.distance(part)) * self.block + local % self.block
    }

    /// Returns the number of indices that `part` has: NUMROC of ScaLAPACK.
    pub fn count(&self, part: usize) -> usize {
        self.count_below(part, self.len)
    }

    /// Returns the number of indices below `end` that `part` has.
    pub fn count_below(&self, part: usize, end: usize) -> usize {
        let (whole, distance) = (end / self.block, self.distance(part));
        let blocks = (whole + self.parts - 1 - distance) / self.parts;
        let rest = if whole % self.parts == distance { end % self.block } else { 0 };
        blocks * self.block + rest
    }

    /// Returns the indices of `part` within a range, as ascending ranges; their positions in the
    /// part ascend too.
    pub fn runs(&self, part: usize, within: Range<usize>) -> impl Iterator<Item = Range<usize>> {
        let (dealing, end) = (*self, self.count_below(part, within.end));
        let mut local = self.count_below(part, within.start);
        std::iter::from_fn(move || {
            let len = (dealing.block - local % dealing.block).min(end.saturating_sub(local));
            let start = dealing.global(part, local);
            local += len;
            (len > 0).then(|| start..start + len)
        })
    }

    /// Returns the number of blocks from the first part to `part`.
    fn distance(&self, part: usize) -> usize {
        (part + self.parts - self.first) % self.parts
    }
}

/// How ranks are numbered in a grid.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum GridOrder {
    /// Along the rows: `Cblacs_gridinit` with "R".
    Rows,
    /// Along the columns: `Cblacs_gridinit` with "C".
    Columns,
}

/// The first ranks as a grid of rows x columns.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Grid {
    rows: usize,
    cols: usize,
    order: GridOrder,
}

impl Grid {
    /// Creates a grid of the ranks from 0 to `rows * cols - 1`.
    ///
    /// ```
    /// use catamaran::ranks::plan::{Grid, GridOrder};
    ///
    /// let grid = Grid::new(2, 3, GridOrder::Columns)?;
    /// assert_eq!((grid.rank(1, 0), grid.place(1)), (1, Some((1, 0))));
    /// assert_eq!(grid.place(6), None);
    /// # Ok::<(), catamaran::Error>(())
    /// ```
    ///
    /// # Errors
    /// [`Error::Argument`] when there is no row, no column, or more than 2^31 - 1 ranks.
    pub fn new(rows: usize, cols: usize, order: GridOrder) -> Result<Self> {
        let fits = rows.checked_mul(cols).is_some_and(|size| size <= i32::MAX as usize);
        if rows == 0 || cols == 0 || !fits {
            let why = format!("must have from 1 to 2^31 - 1 ranks, is {rows} x {cols}");
            return Err(Error::Argument { what: "grid", why });
        }
        Ok(Self { rows, cols, order })
    }

    /// Returns the number of rows of the grid.
    pub fn rows(&self) -> usize {
        self.rows
    }

    /// Returns the number of columns of the grid.
    pub fn cols(&self) -> usize {
        self.cols
    }

    /// Returns how the ranks are numbered.
    pub fn order(&self) -> GridOrder {
        self.order
    }

    /// Returns the number of ranks in the grid.
    pub fn size(&self) -> usize {
        self.rows * self.cols
    }

    /// Returns the rank in a row and a column.
    pub fn rank(&self, row: usize, col: usize) -> usize {
        match self.order {
            GridOrder::Rows => row * self.cols + col,
            GridOrder::Columns => col * self.rows + row,
        }
    }

    /// Returns the row and the column of a rank; `None` if the rank is not in the grid.
    pub fn place(&self, rank: usize) -> Option<(usize, usize)> {
        (rank < self.size()).then(|| match self.order {
            GridOrder::Rows => (rank / self.cols, rank % self.cols),
            GridOrder::Columns => (rank % self.rows, rank / self.rows),
        })
    }

    fn transpose(self) -> Self {
        let order = match self.order {
            GridOrder::Rows => GridOrder::Columns,
            GridOrder::Columns => GridOrder::Rows,
        };
        Self { rows: self.cols, cols: self.rows, order }
    }
}

/// A matrix whose rows and columns are dealt out to a [`Grid`]: entry (i, j) belongs to the rank in
/// the row that has i and the column that has j.
///
/// The rank keeps its entries as a matrix of its rows and columns, in ascending order.
///
/// ```
/// use catamaran::ranks::plan::{BlockCyclic, Grid, GridOrder};
///
/// // 5 x 4 in blocks of 2 x 2 on a grid of 2 x 2 ranks.
/// let grid = Grid::new(2, 2, GridOrder::Rows)?;
/// let a = BlockCyclic::new("A", (5, 4), (2, 2), (0, 0), grid)?;
/// assert_eq!(a.local_shape(0), (3, 2)); // rows 0, 1 and 4, columns 0 and 1
/// assert_eq!(a.owner(2, 3), 3);
/// # Ok::<(), catamaran::Error>(())
/// ```
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct BlockCyclic {
    grid: Grid,
    rows: Dealing,
    cols: Dealing,
}

impl BlockCyclic {
    /// Creates the layout of a matrix of `shape` in blocks of `block` rows and columns. The first
    /// block is in row and column `first` of the grid. `what` names the matrix in errors.
    ///
    /// # Errors
    /// [`Error::Argument`] for a block without rows or columns, or a `first` outside of the grid.
    pub fn new(
        what: &'static str,
        shape: (usize, usize),
        block: (usize, usize),
        first: (usize, usize),
        grid: Grid,
    ) -> Result<Self> {
        let dealing = |len, (block_name, block), (first_name, first), parts| {
            let refuse = |field: &str, range: String, value: usize| {
                let why = format!("{field} must be {range}, is {value}");
                Err(Error::Argument { what, why })
            };
            match (block, first) {
                (0, _) => refuse(block_name, "at least 1".into(), 0),
                (_, first) if first >= parts => {
                    refuse(first_name, format!("0 to {}, within the grid", parts - 1), first)
                }
                _ => Ok(Dealing { len, block, parts, first }),
            }
        };
        let rows = dealing(shape.0, ("MB_", block.0), ("RSRC_", first.0), grid.rows)?;
        let cols = dealing(shape.1, ("NB_", block.1), ("CSRC_", first.1), grid.cols)?;
        Ok(Self { grid, rows, cols })
    }

    /// Reads a ScaLAPACK descriptor, and returns the matrix and the leading dimension of its part
    /// on `rank`.
    ///
    /// The nine numbers are DTYPE_ (1), CTXT_ (ignored: `grid` says it), M_, N_, MB_, NB_, RSRC_,
    /// CSRC_ and LLD_, which is at least 1 and the rows of the part, and ignored on ranks outside
    /// of the grid. `what` names the descriptor in errors.
    ///
    /// ```
    /// use catamaran::ranks::plan::{BlockCyclic, Grid, GridOrder};
    ///
    /// let grid = Grid::new(2, 2, GridOrder::Rows)?;
    /// let descriptor = [1, -1, 10, 6, 3, 2, 1, 0, 6];
    /// let (matrix, leading) = BlockCyclic::from_descriptor("desc", &descriptor, grid, 3)?;
    /// assert_eq!((matrix.shape(), matrix.local_shape(3), leading), ((10, 6), (6, 2), 6));
    /// # Ok::<(), catamaran::Error>(())
    /// ```
    ///
    /// # Errors
    /// [`Error::Argument`], which names the field.
    pub fn from_descriptor(
        what: &'static str,
        descriptor: &[i32; 9],
        grid: Grid,
        rank: usize,
    ) -> Result<(Self, usize)> {
        let &[kind, _, m, n, mb, nb, first_row, first_col, leading] = descriptor;
        if kind != DENSE {
            let why = format!("DTYPE_ must be {DENSE}, a dense matrix, is {kind}");
            return Err(Error::Argument { what, why });
        }
        let natural = |field: &str, value: i32| {
            usize::try_from(value).map_err(|_| {
                let why = format!("{field} must not be negative, is {value}");
                Error::Argument { what, why }
            })
        };
        let shape = (natural("M_", m)?, natural("N_", n)?);
        let block = (natural("MB_", mb)?, natural("NB_", nb)?);
        let first = (natural("RSRC_", first_row)?, natural("CSRC_", first_col)?);
        let matrix = Self::new(what, shape, block, first, grid)?;
        let rows = matrix.local_shape(rank).0.max(1);
        if grid.place(rank).is_none() {
            return Ok((matrix, rows));
        }
        let leading = natural("LLD_", leading)?;
        if leading < rows {
            let why = format!("LLD_ must be at least {rows}, the rows on this rank, is {leading}");
            return Err(Error::Argument { what, why });
        }
        Ok((matrix, leading))
    }

    /// Returns the grid of processes.
    pub fn grid(&self) -> Grid {
        self.grid
    }

    /// Returns how rows are dealt out to the rows of the grid.
    pub fn rows(&self) -> &Dealing {
        &self.rows
    }

    /// Returns how columns are dealt out to the columns of the grid.
    pub fn cols(&self) -> &Dealing {
        &self.cols
    }

    /// Returns the number of rows and of columns of the whole matrix.
    pub fn shape(&self) -> (usize, usize) {
        (self.rows.len, self.cols.len)
    }

    /// Returns the number of rows and of columns of the part of `rank`; (0, 0) outside of the grid.
    pub fn local_shape(&self, rank: usize) -> (usize, usize) {
        self.grid
            .place(rank)
            .map_or((0, 0), |(row, col)| (self.rows.count(row), self.cols.count(col)))
    }

    /// Returns the rank that has the entry (i, j).
    pub fn owner(&self, i: usize, j: usize) -> usize {
        self.grid.rank(self.rows.owner(i), self.cols.owner(j))
    }

    /// Returns the transposed matrix on the transposed grid: the same entries on the same ranks.
    pub fn transpose(&self) -> Self {
        Self { grid: self.grid.transpose(), rows: self.cols, cols: self.rows }
    }
}

/// Which product a block-cyclic A is cut for.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum CutInto {
    /// Every rank gets some rows, for [`Chunks`](super::Chunks).
    Rows,
    /// Every rank gets some columns, for [`Blocks`](super::Blocks).
    Columns,
    /// Ranks get some rows of some columns, for [`Bricks::new`].
    Bricks,
}

/// A block-cyclic A, m x n, as about equal parts of rows, of columns, or of both, one for each
/// rank; some ranks may have none of [`Bricks`].
///
/// The order of rows does not matter to a product. Rows are counted here by one row of the grid
/// after another, so that the part of a rank and the entries that another one holds have a
/// contiguous piece in common, most rows stay in their row of the grid, and there is at most one
/// message from each rank to another.
///
/// ```
/// use catamaran::ranks::plan::{BlockCyclic, CutInto, Grid, GridOrder, Parts};
///
/// let grid = Grid::new(2, 2, GridOrder::Rows)?;
/// let a = BlockCyclic::new("A", (1000, 10), (8, 8), (0, 0), grid)?;
/// let parts = Parts::new(a, 4);
/// assert_eq!(parts.cut(), CutInto::Rows);
/// assert_eq!((0..4).map(|rank| parts.shape(rank).0).sum::<usize>(), 1000);
/// # Ok::<(), catamaran::Error>(())
/// ```
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Parts {
    matrix: BlockCyclic,
    ranks: usize,
    cut: CutInto,
    bricks: Bricks,
    /// Where the rows of each row of the grid begin in this order, and the end.
    starts: Vec<usize>,
}

/// The entries of one rank's part that another rank holds.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Piece {
    /// Rows of the piece, among those that the holder has.
    pub rows: Range<usize>,
    /// Columns of the piece, among those that the holder has.
    pub cols: Range<usize>,
    /// The position of the first of these rows in the part.
    pub first_row: usize,
}

impl Piece {
    /// Returns the number of entries.
    pub fn len(&self) -> usize {
        self.rows.len() * self.cols.len()
    }

    /// Returns whether there are no entries.
    pub fn is_empty(&self) -> bool {
        self.len() == 0
    }
}

impl Parts {
    /// Creates the parts of the cut with which the fewest words travel, the redistribution
    /// included. [`Bricks`] must be faster too, as [`predict`] says for [`Machine::default`],
    /// because they may leave ranks without work.
    ///
    /// To the words of the product come, for each of P ranks, `m n / P (1 - 1/Q)` for rows, where
    /// the grid has Q columns, `m n / P` for columns, and `m n / B` for B bricks.
    pub fn new(matrix: BlockCyclic, ranks: usize) -> Self {
        let (m, n) = matrix.shape();
        let machine = Machine::default();
        let [rows, columns, bricks] = [Mode::Rows, Mode::Columns, Mode::Bricks]
            .map(|mode| predict(mode, ranks, m, n, &machine));
        let share = m as f64 * n as f64 / ranks as f64;
        let of_rows = rows.words + share * (1.0 - 1.0 / matrix.grid.cols as f64);
        let of_columns = columns.words + share;
        let (cut, words, seconds) = if of_rows <= of_columns {
            (CutInto::Rows, of_rows, rows.seconds)
        } else {
            (CutInto::Columns, of_columns, columns.seconds)
        };
        let parts = Self::with_cut(matrix, ranks, cut);
        let of_bricks = bricks.words + share * ranks as f64 / parts.bricks.used() as f64;
        let is_better = of_bricks < words && bricks.seconds < seconds;
        if is_better { Self { cut: CutInto::Bricks, ..parts } } else { parts }
    }

    /// Creates the parts of this cut.
    pub fn with_cut(matrix: BlockCyclic, ranks: usize, cut: CutInto) -> Self {
        let mut starts = vec![0];
        for row in 0..matrix.grid.rows {
            starts.push(starts[row] + matrix.rows.count(row));
        }
        let bricks = Bricks::new(ranks, matrix.rows.len, matrix.cols.len);
        Self { matrix, ranks, cut, bricks, starts }
    }

    /// Returns whether the parts are rows, columns or bricks.
    pub fn cut(&self) -> CutInto {
        self.cut
    }

    /// Returns the bricks of [`CutInto::Bricks`].
    pub fn bricks(&self) -> &Bricks {
        &self.bricks
    }

    /// Returns the number of rows and of columns of the part of `rank`.
    pub fn shape(&self, rank: usize) -> (usize, usize) {
        (self.rows(rank).len(), self.cols(rank).len())
    }

    /// Returns the columns of A in the part of `rank`.
    pub fn cols(&self, rank: usize) -> Range<usize> {
        match self.cut {
            CutInto::Rows => 0..self.matrix.cols.len,
            CutInto::Columns => even_part(0..self.matrix.cols.len, self.ranks, rank),
            CutInto::Bricks => self.bricks.columns(rank),
        }
    }

    /// Returns the rows in the part of `rank`, in the order of the rows of the grid.
    fn rows(&self, rank: usize) -> Range<usize> {
        let m = self.matrix.rows.len;
        match (self.cut, self.matrix.grid.place(rank)) {
            (CutInto::Columns, _) => 0..m,
            (CutInto::Bricks, _) => self.bricks.rows(rank),
            // So that the ranks of one row of the grid follow each other, however they are
            // numbered.
            (CutInto::Rows, Some((row, col))) => {
                even_part(0..m, self.ranks, row * self.matrix.grid.cols + col)
            }
            (CutInto::Rows, None) => even_part(0..m, self.ranks, rank),
        }
    }

    /// Returns the piece of the part of rank `to` that rank `from` holds; `None` when it is empty
    /// or `from` is outside of the grid.
    ///
    /// ```
    /// use catamaran::ranks::plan::{BlockCyclic, CutInto, Grid, GridOrder, Parts, Piece};
    ///
    /// let grid = Grid::new(1, 2, GridOrder::Rows)?;
    /// let a = BlockCyclic::new("A", (8, 4), (8, 2), (0, 0), grid)?;
    /// // Rank 0 holds the first two columns; the part of rank 1 is the last four rows.
    /// let parts = Parts::with_cut(a, 2, CutInto::Rows);
    /// assert_eq!(parts.piece(0, 1), Some(Piece { rows: 4..8, cols: 0..2, first_row: 0 }));
    /// # Ok::<(), catamaran::Error>(())
    /// ```
    pub fn piece(&self, from: usize, to: usize) -> Option<Piece> {
        let (row, col) = self.matrix.grid.place(from)?;
        let (rows, cols) = (self.rows(to), self.cols(to));
        let held = self.starts[row]..self.starts[row + 1];
        let both = rows.start.clamp(held.start, held.end)..rows.end.clamp(held.start, held.end);
        let dealt = &self.matrix.cols;
        let piece = Piece {
            rows: both.start - held.start..both.end - held.start,
            cols: dealt.count_below(col, cols.start)..dealt.count_below(col, cols.end),
            first_row: both.start.saturating_sub(rows.start),
        };
        (!piece.is_empty()).then_some(piece)
    }

    /// Returns the position, in the part of rank `to`, of column `col` of the columns that `from`
    /// holds. The column must be one of the piece of [`Parts::piece`].
    pub fn place_of_col(&self, from: usize, to: usize, col: usize) -> usize {
        let grid_col = self.matrix.grid.place(from).map_or(0, |(_, grid_col)| grid_col);
        self.matrix.cols.global(grid_col, col) - self.cols(to).start
    }
}

/// The redistribution of a symmetric result to a block-cyclic C.
///
/// ```
/// use catamaran::Uplo;
/// use catamaran::ranks::plan::{BlockCyclic, Chunks, Delivery, Grid, GridOrder, TriangleLayout};
///
/// // Two ranks hold the lower triangle; both triangles of C go to rank 0.
/// let result = TriangleLayout::Chunks(Chunks::with_count(3, 2, 1));
/// let grid = Grid::new(1, 1, GridOrder::Rows)?;
/// let target = BlockCyclic::new("C", (3, 3), (3, 3), (0, 0), grid)?;
/// let delivery = Delivery { result: &result, target, uplo: Uplo::Both };
/// assert_eq!(delivery.len(0, 0) + delivery.len(1, 0), 9);
/// # Ok::<(), catamaran::Error>(())
/// ```
#[derive(Debug, Clone)]
pub struct Delivery<'l> {
    /// Which rank holds which entries of the result.
    pub result: &'l TriangleLayout,
    /// The layout of C, n x n.
    pub target: BlockCyclic,
    /// The triangles of C that are delivered.
    pub uplo: Uplo,
}

/// Entries that are adjacent both in the result and in C.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Run {
    /// Position of the first entry among those that the sender holds.
    pub at: usize,
    /// Number of entries.
    pub len: usize,
    /// Row of the first entry in the receiver's part of C.
    pub row: usize,
    /// Column of the first entry there.
    pub col: usize,
    /// Whether the entries follow down the column, not along the row.
    pub down: bool,
}

impl Delivery<'_> {
    /// Calls `each` with the runs that rank `from` sends to rank `to`, in order.
    pub fn runs(&self, from: usize, to: usize, mut each: impl FnMut(Run)) {
        let Some((grid_row, grid_col)) = self.target.grid.place(to) else { return };
        let (rows, cols) = (&self.target.rows, &self.target.cols);
        let mut start = 0;
        for segment in self.result.segments(from) {
            let (i, first) = (segment.row, segment.cols.start);
            // Entry (i, j) goes to (i, j), or to (j, i), or to both.
            if self.uplo != Uplo::Upper && rows.owner(i) == grid_row {
                for run in cols.runs(grid_col, segment.cols.clone()) {
                    let (row, col) = (rows.local(i), cols.local(run.start));
                    let at = start + run.start - first;
                    each(Run { at, len: run.len(), row, col, down: false });
                }
            }
            if self.uplo != Uplo::Lower && cols.owner(i) == grid_col {
                // With both triangles the diagonal is delivered once.
                let beyond = if self.uplo == Uplo::Both { i } else { i + 1 };
                let mirrored = first..segment.cols.end.min(beyond);
                for run in rows.runs(grid_row, mirrored) {
                    let (row, col) = (rows.local(run.start), cols.local(i));
                    let at = start + run.start - first;
                    each(Run { at, len: run.len(), row, col, down: true });
                }
            }
            start += segment.cols.len();
        }
    }

    /// Returns the number of entries that rank `from` sends to rank `to`.
    pub fn len(&self, from: usize, to: usize) -> usize {
        let mut len = 0;
        self.runs(from, to, |run| len += run.len);
        len
    }
}

#[cfg(test)]
mod tests {
    use super::super::{Blocks, Chunks};
    use super::*;

    /// Returns every dealing with few indices.
    fn dealings() -> impl Iterator<Item = Dealing> {
        let all = (0..14).flat_map(|len| (1..6).map(move |block| (len, block)));
        all.flat_map(|(len, block)| {
            (1..5).flat_map(move |parts| {
                (0..parts).map(move |first| Dealing { len, block, parts, first })
            })
        })
    }

    /// Returns the indices of each part, dealt one at a time.
    fn dealt(dealing: &Dealing) -> Vec<Vec<usize>> {
        let mut hands = vec![Vec::new(); dealing.parts];
        let mut part = dealing.first;
        for index in 0..dealing.len {
            if index > 0 && index % dealing.block == 0 {
                part = (part + 1) % dealing.parts;
            }
            hands[part].push(index);
        }
        hands
    }

    #[test]
    fn indices_are_where_dealing_one_at_a_time_puts_them() {
        for dealing in dealings() {
            for (part, hand) in dealt(&dealing).iter().enumerate() {
                assert_eq!(dealing.count(part), hand.len(), "{dealing:?}");
                for (local, &index) in hand.iter().enumerate() {
                    assert_eq!(dealing.owner(index), part, "{dealing:?}");
                    assert_eq!(dealing.local(index), local, "{dealing:?}");
                    assert_eq!(dealing.global(part, local), index, "{dealing:?}");
                }
                for end in 0..=dealing.len {
                    let below = hand.iter().filter(|&&index| index < end).count();
                    assert_eq!(dealing.count_below(part, end), below, "{dealing:?}");
                }
            }
        }
    }

    #[test]
    fn runs_are_the_indices_of_a_part_within_a_range() {
        for dealing in dealings() {
            for (part, hand) in dealt(&dealing).iter().enumerate() {
                for (start, end) in [(0, dealing.len), (1, dealing.len), (2, 5), (3, 3), (6, 7)] {
                    let within = start..end.min(dealing.len);
                    let runs: Vec<_> = dealing.runs(part, within.clone()).collect();
                    assert!(runs.iter().all(|run| !run.is_empty() && run.len() <= dealing.block));
                    let wanted = hand.iter().copied().filter(|index| within.contains(index));
                    assert!(runs.into_iter().flatten().eq(wanted), "{dealing:?} {within:?}");
                }
            }
        }
    }

    #[test]
    fn counts_beyond_32_bits_of_products_are_right() {
        let dealing = Dealing { len: i32::MAX as usize, block: 7, parts: 1000, first: 999 };
        let total: usize = (0..1000).map(|part| dealing.count(part)).sum();
        assert_eq!(total, dealing.len);
        let last = dealing.len - 1;
        assert_eq!(dealing.global(dealing.owner(last), dealing.local(last)), last);
        // Blocks larger than the matrix: all of it is on one process.
        let one = Dealing { len: 10, block: i32::MAX as usize, parts: 3, first: 2 };
        assert_eq!([0, 1, 2].map(|part| one.count(part)), [0, 0, 10]);
    }

    #[test]
    fn grids_number_their_ranks_in_both_orders() {
        for order in [GridOrder::Rows, GridOrder::Columns] {
            let grid = Grid::new(2, 3, order).unwrap();
            for rank in 0..6 {
                let (row, col) = grid.place(rank).unwrap();
                assert!(row < 2 && col < 3 && grid.rank(row, col) == rank);
                assert_eq!(grid.transpose().place(rank), Some((col, row)));
            }
            assert_eq!(grid.place(6), None);
        }
        assert_eq!(Grid::new(2, 3, GridOrder::Rows).unwrap().place(1), Some((0, 1)));
        assert_eq!(Grid::new(2, 3, GridOrder::Columns).unwrap().place(1), Some((1, 0)));
        assert!(Grid::new(0, 3, GridOrder::Rows).is_err());
        assert!(Grid::new(usize::MAX, 2, GridOrder::Rows).is_err());
    }

    #[test]
    fn wrong_descriptors_name_the_field() {
        let grid = Grid::new(2, 2, GridOrder::Rows).unwrap();
        let good = [1, -1, 10, 6, 3, 2, 1, 0, 6];
        let (matrix, leading) = BlockCyclic::from_descriptor("desc", &good, grid, 3).unwrap();
        // Rows 3..6 and 9 are on the first row of the grid, the other six on the second one.
        assert_eq!((matrix.shape(), matrix.local_shape(3), leading), ((10, 6), (6, 2), 6));
        assert_eq!(matrix.local_shape(0), (4, 4));
        let wrong = [
            (0, 2, "DTYPE_ must be 1"),
            (2, -1, "M_ must not be negative, is -1"),
            (3, -5, "N_"),
            (4, 0, "MB_ must be at least 1, is 0"),
            (5, -2, "NB_"),
            (6, 2, "RSRC_ must be 0 to 1, within the grid, is 2"),
            (7, -1, "CSRC_"),
            (8, 5, "LLD_ must be at least 6, the rows on this rank, is 5"),
        ];
        for (field, value, text) in wrong {
            let mut descriptor = good;
            descriptor[field] = value;
            let error = BlockCyclic::from_descriptor("desc", &descriptor, grid, 3).unwrap_err();
            assert!(error.to_string().starts_with(&format!("desc: {text}")), "{error}");
        }
        // Outside of the grid there is no local part.
        let outside = [1, -1, 10, 6, 3, 2, 1, 0, 0];
        let (matrix, _) = BlockCyclic::from_descriptor("desc", &outside, grid, 4).unwrap();
        assert_eq!(matrix.local_shape(4), (0, 0));
    }

    /// Returns matrices of a shape on small grids.
    fn matrices(shape: (usize, usize)) -> Vec<BlockCyclic> {
        let mut all = Vec::new();
        for (rows, cols) in [(1, 1), (1, 3), (3, 1), (2, 2), (2, 3)] {
            for order in [GridOrder::Rows, GridOrder::Columns] {
                let grid = Grid::new(rows, cols, order).unwrap();
                for block in [(1, 1), (2, 3), (4, 1), (100, 100)] {
                    let first = (rows - 1, cols / 2);
                    all.push(BlockCyclic::new("A", shape, block, first, grid).unwrap());
                }
            }
        }
        all
    }

    #[test]
    fn every_entry_of_a_is_sent_to_one_part_and_rows_stay_together() {
        for shape in [(0, 3), (5, 0), (1, 1), (7, 5), (13, 11)] {
            for matrix in matrices(shape) {
                let cuts = [(6, CutInto::Rows), (6, CutInto::Columns), (7, CutInto::Rows)];
                for (ranks, cut) in cuts.into_iter().chain([(18, CutInto::Bricks)]) {
                    let parts = Parts::with_cut(matrix, ranks, cut);
                    let mut seen = vec![0; shape.0 * shape.1];
                    for to in 0..ranks {
                        let (height, width) = parts.shape(to);
                        // The row of A in each row of the part, and what has been filled.
                        let mut row_of = vec![None; height];
                        let mut filled = vec![false; height * width];
                        for from in 0..ranks {
                            let Some(piece) = parts.piece(from, to) else { continue };
                            let (grid_row, grid_col) = matrix.grid.place(from).unwrap();
                            for (offset, local_row) in piece.rows.clone().enumerate() {
                                let i = matrix.rows.global(grid_row, local_row);
                                let row = piece.first_row + offset;
                                assert_eq!(*row_of[row].get_or_insert(i), i);
                                for local_col in piece.cols.clone() {
                                    let j = matrix.cols.global(grid_col, local_col);
                                    assert_eq!(matrix.owner(i, j), from);
                                    let col = parts.place_of_col(from, to, local_col);
                                    assert_eq!(parts.cols(to).start + col, j);
                                    assert!(!filled[row * width + col]);
                                    filled[row * width + col] = true;
                                    seen[i * shape.1 + j] += 1;
                                }
                            }
                        }
                        assert!(filled.iter().all(|&f| f), "{matrix:?} {cut:?}");
                    }
                    assert!(seen.iter().all(|&count| count == 1), "{matrix:?} {cut:?}");
                }
            }
        }
    }

    #[test]
    fn tall_matrices_are_cut_into_rows_and_square_ones_into_columns_or_bricks() {
        let cut = |m, n, side| {
            let grid = Grid::new(side, side, GridOrder::Rows).unwrap();
            let matrix = BlockCyclic::new("A", (m, n), (64, 64), (0, 0), grid).unwrap();
            Parts::new(matrix, side * side).cut()
        };
        assert_eq!(cut(600_000, 500, 2), CutInto::Rows);
        assert_eq!(cut(600_000, 500, 16), CutInto::Rows);
        assert_eq!(cut(10_000, 10_000, 4), CutInto::Columns);
        assert_eq!(cut(500, 600_000, 4), CutInto::Columns);
        assert_eq!(cut(0, 0, 1), CutInto::Rows);
        // Words count beside the products.
        assert_eq!(cut(500, 500, 8), CutInto::Bricks);
    }

    #[test]
    fn every_wanted_entry_of_c_is_delivered_once() {
        for n in [0, 1, 5, 13] {
            let layouts = |ranks: usize| {
                let widths: Vec<usize> =
                    (0..ranks).map(|r| even_part(0..n, ranks, r).len()).collect();
                let chunks = Chunks::with_count(n, ranks, 2);
                let bricks = Bricks::with_counts(ranks, (9, n), 3, 2).unwrap();
                [
                    TriangleLayout::Chunks(chunks),
                    TriangleLayout::Blocks(Blocks::new(&widths)),
                    TriangleLayout::Bricks(bricks),
                ]
            };
            for target in matrices((n, n)) {
                for ranks in [6, 7] {
                    for result in layouts(ranks) {
                        for uplo in [Uplo::Lower, Uplo::Upper, Uplo::Both] {
                            check_delivery(&Delivery { result: &result, target, uplo });
                        }
                    }
                }
            }
        }
    }

    fn check_delivery(delivery: &Delivery<'_>) {
        let Delivery { result, target, uplo } = delivery;
        let (n, ranks) = (result.n(), result.ranks());
        let mut seen = vec![0; n * n];
        for from in 0..ranks {
            let held: Vec<(usize, usize)> = result
                .segments(from)
                .flat_map(|segment| segment.cols.map(move |j| (segment.row, j)))
                .collect();
            for to in 0..ranks {
                let mut len = 0;
                delivery.runs(from, to, |run| {
                    let (grid_row, grid_col) = target.grid.place(to).unwrap();
                    for k in 0..run.len {
                        let (down, along) = if run.down { (k, 0) } else { (0, k) };
                        let i = target.rows.global(grid_row, run.row + down);
                        let j = target.cols.global(grid_col, run.col + along);
                        assert_eq!(held[run.at + k], (i.max(j), i.min(j)));
                        seen[i * n + j] += 1;
                    }
                    len += run.len;
                });
                assert_eq!(delivery.len(from, to), len);
            }
        }
        for i in 0..n {
            for j in 0..n {
                let wanted = match uplo {
                    Uplo::Lower => i >= j,
                    Uplo::Upper => i <= j,
                    Uplo::Both => true,
                };
                assert_eq!(seen[i * n + j], usize::from(wanted), "({i}, {j}) of {delivery:?}");
            }
        }
    }
}
