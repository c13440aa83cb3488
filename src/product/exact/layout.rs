//! The plan of the exact path, as data: which residues are in memory at which time, and which
//! blocks of C are computed from them. Shapes and counts only.

use std::ops::Range;

use super::blocking::Blocking;
use crate::base::steps::step;
use crate::base::{first_that, triangle_len};
use crate::kernel::int8::{DEPTH, PANEL, PanelBlock, STEP};

/// Memory that residues of the operands may take beyond the size of these; with a batch and a dozen
/// threads it stays below 256 MiB.
const ALLOWANCE: usize = 112 << 20;
/// Residues of a tall matrix in memory at a time: few enough for the last cache, from which
/// products read each of them only a few times.
const TALL_STORE: usize = 32 << 20;
/// Least number of steps of a chunk of a tall matrix: threads wait for each other at its end.
const TALL_STEPS: usize = 2048 / STEP;
/// Residues of C in memory at a time where it is not the sum of several chunks.
const BATCH: usize = 128 << 20;

/// The division of the work. Panels are 32 columns, steps 64 rows.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(crate) struct ExactLayout {
    /// Whether only the lower triangle of C is computed.
    pub symmetric: bool,
    /// Whether B is A.
    pub same: bool,
    /// Number of moduli.
    pub moduli: usize,
    /// Panels of A.
    pub left: usize,
    /// Panels of B.
    pub right: usize,
    /// Steps of both.
    pub steps: usize,
    /// Steps whose residues are in memory at a time.
    pub chunk: usize,
    /// Groups of panels of each operand; the residues of two groups are in memory at a time.
    pub groups: usize,
    /// Residues of C in memory at a time, in bytes, where C is not the sum of several chunks.
    pub batch: usize,
    /// The parts that stay in each cache.
    pub blocking: Blocking,
}

/// Which residues a store holds.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(crate) struct Extent {
    pub panels: Range<usize>,
    pub pieces: Pieces,
}

impl Extent {
    /// Returns the number of slices modulo one number.
    pub fn len(&self) -> usize {
        self.panels.len() * self.pieces.steps.len()
    }

    /// Returns the position of a slice among those modulo one number: piece by piece, and panel by
    /// panel in each. That is the order of the products; and panels a power of two apart would
    /// compete for the same lines of a cache.
    pub fn place(&self, panel: usize, step: usize) -> usize {
        let piece = self.pieces.around(step);
        let before = (piece.start - self.pieces.steps.start) * self.panels.len();
        before + (panel - self.panels.start) * piece.len() + step - piece.start
    }
}

/// Steps of a chunk, in pieces of equal length, give or take one: short ones are slow.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(crate) struct Pieces {
    pub steps: Range<usize>,
    pub count: usize,
}

impl Pieces {
    /// Cuts the steps into the fewest pieces of at most `depth` steps.
    pub fn new(steps: Range<usize>, depth: usize) -> Self {
        let count = steps.len().div_ceil(depth);
        Self { steps, count }
    }

    /// Returns the steps of piece `i`.
    pub fn get(&self, i: usize) -> Range<usize> {
        let bound = |i: usize| self.steps.start + self.steps.len() * i / self.count;
        bound(i)..bound(i + 1)
    }

    /// Returns the steps of the piece that `step` is in.
    pub fn around(&self, step: usize) -> Range<usize> {
        self.get(((step - self.steps.start + 1) * self.count - 1) / self.steps.len())
    }
}

/// A group of panels of an operand, 0 for A and 1 for B.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) struct Need {
    pub operand: usize,
    pub group: usize,
}

/// One round: the residues of a group of A and one of B give a part of C.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) struct Pair {
    pub left: usize,
    pub right: usize,
}

/// A block of C, in panels.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(crate) struct Unit {
    pub rows: Range<usize>,
    pub cols: Range<usize>,
    /// Where its residues begin among those of its batch, for each modulus.
    pub first: usize,
}

impl Unit {
    /// Returns the position of the residues of panels (i, j) among those of the batch: column by
    /// column.
    pub fn place(&self, i: usize, j: usize) -> usize {
        self.first + (j - self.cols.start) * self.rows.len() + i - self.rows.start
    }
}

/// Blocks of C whose residues are in memory at a time.
#[derive(Debug, Clone, PartialEq, Eq, Default)]
pub(crate) struct Batch {
    /// The largest first, so that the small ones fill the gaps at the end.
    pub units: Vec<Unit>,
    /// Pairs of panels that there is room for, for each modulus; an odd number.
    pub places: usize,
}

impl ExactLayout {
    /// Creates the layout for A m x n and B m x k, with entries of `bytes` bytes.
    pub fn new(
        sides: [usize; 3],
        bytes: usize,
        moduli: usize,
        symmetric: bool,
        same: bool,
    ) -> Self {
        Self::within(None, sides, bytes, moduli, symmetric, same)
    }

    /// Creates the layout that takes about `memory` bytes, if that is possible: half for the
    /// residues of the operands, a quarter for those of C.
    pub fn within(
        memory: Option<usize>,
        [m, n, k]: [usize; 3],
        bytes: usize,
        moduli: usize,
        symmetric: bool,
        same: bool,
    ) -> Self {
        debug_assert!(symmetric || !same);
        let (left, right) = (n.div_ceil(PANEL), k.div_ceil(PANEL));
        let steps = m.div_ceil(STEP);
        // Saturating: a padded row of 64 columns can be 64 times as long as the row.
        let residues = |panels: usize, steps: usize| {
            (moduli * PANEL * STEP).saturating_mul(panels).saturating_mul(steps)
        };
        let columns = if same { left } else { left + right };
        let operands = (m * bytes).saturating_mul(if same { n } else { n + k });
        let budget = memory.map_or(operands.saturating_add(ALLOWANCE), |bytes| bytes / 2);
        let tall_store = memory.map_or(TALL_STORE, |bytes| TALL_STORE.min(bytes / 4));
        let batch = memory.map_or(BATCH, |bytes| BATCH.min(bytes / 4));
        let c_bytes = (moduli * PANEL * PANEL).saturating_mul(pairs(symmetric, left, right));
        let tall = m > 2 * n.max(k);
        // Whole pieces of the usual depth.
        let step_bytes = residues(columns, 1);
        let tall_chunk = (tall_store / step_bytes.max(1)).max(TALL_STEPS) / DEPTH * DEPTH;
        let (chunk, groups) = if residues(columns, steps) <= if tall { tall_store } else { budget }
        {
            (steps, 1)
        } else if tall && residues(columns, tall_chunk).saturating_add(c_bytes) <= budget {
            (tall_chunk, 1)
        } else {
            let most = left.max(right).max(1);
            let fits = |groups: usize| {
                let of_two = if same {
                    2 * left.div_ceil(groups)
                } else {
                    left.div_ceil(groups) + right.div_ceil(groups)
                };
                residues(of_two, steps) <= budget
            };
            (steps, first_that(2.min(most)..most, fits))
        };
        let blocking = Blocking::new(left, right);
        let chunk = chunk.max(1);
        Self { symmetric, same, moduli, left, right, steps, chunk, groups, batch, blocking }
    }

    /// Returns the layout with blocks halved until there are several for each of `threads` threads,
    /// which wait for each other at the end of a batch. The result is the same.
    pub fn for_threads(&self, threads: usize) -> Self {
        /// Products of blocks in a batch, for each thread. With more of them, threads wait less at
        /// the end, but low blocks load the right side more often. Measured with 2 threads.
        const SHARE: usize = 3;
        let mut layout = self.clone();
        if threads > 1 {
            while layout.products_in_batch() < SHARE * threads && layout.blocking.halve() {}
        }
        layout
    }

    /// Returns about how many products of blocks, of all moduli, a batch has on average over the
    /// rounds, in batches of whole blocks.
    fn products_in_batch(&self) -> usize {
        let units = match self.groups {
            1 => self.largest_round().0,
            groups => {
                let Blocking { rows, cols, .. } = self.blocking;
                let right = blocks(self.right, groups, cols);
                let all = blocks(self.left, groups, rows).saturating_mul(right);
                // On the diagonal rounds have half as many.
                all / groups / if self.symmetric { groups + 1 } else { groups }
            }
        };
        let batches = if self.accumulates() {
            1
        } else {
            let place = self.blocking.rows * self.blocking.cols;
            units.div_ceil((self.most_places() / place).max(1))
        };
        self.moduli * units / batches.max(1)
    }

    /// Returns an upper bound on the blocks of a batch and on its pairs of panels.
    pub fn largest_batch(&self) -> (usize, usize) {
        let (units, places) = self.largest_round();
        if self.accumulates() {
            return (units, places | 1);
        }
        // A block that is larger than a batch is a batch of its own.
        let most = self.most_places().max(self.blocking.rows * self.blocking.cols);
        (units.min(most), places.min(most) | 1)
    }

    /// Returns the pairs of panels that there is memory for in a batch, for each modulus.
    fn most_places(&self) -> usize {
        self.batch / (self.moduli * size_of::<PanelBlock<i8>>())
    }

    /// Returns the blocks of the largest round, and the pairs of panels in them.
    fn largest_round(&self) -> (usize, usize) {
        let Blocking { rows, cols, .. } = self.blocking;
        let [left, right] = [self.left, self.right].map(|panels| panels.div_ceil(self.groups));
        if !self.symmetric || self.groups > 1 {
            return (left.div_ceil(rows) * right.div_ceil(cols), left * right);
        }
        // Rows of blocks end at the diagonal: those of full height at `rows`, `2 rows` and so on.
        let (full, rest) = (left / rows, left % rows);
        let last = if rest > 0 { left.div_ceil(cols) } else { 0 };
        let units = sum_of_floors(full, cols, rows, rows + cols - 1) + last;
        (units, rows * rows * triangle_len(full) + rest * left)
    }

    /// Returns the pairs of panels of C that are computed.
    pub fn panel_pairs(&self) -> usize {
        pairs(self.symmetric, self.left, self.right)
    }

    /// Returns whether C is the sum over several chunks.
    pub fn accumulates(&self) -> bool {
        self.chunk < self.steps
    }

    /// Returns the panels of a group.
    pub fn group(&self, need: Need) -> Range<usize> {
        let panels = if need.operand == 0 { self.left } else { self.right };
        need.group * panels / self.groups..(need.group + 1) * panels / self.groups
    }

    /// Returns the steps of each chunk, in order.
    pub fn chunks(&self) -> impl Iterator<Item = Range<usize>> + '_ {
        (0..self.steps).step_by(self.chunk).map(|first| first..self.steps.min(first + self.chunk))
    }

    /// Returns the most bytes of residues that each store holds.
    pub fn stores(&self) -> [usize; 2] {
        let bytes = |panels: usize| {
            let slices = panels.div_ceil(self.groups).saturating_mul(self.chunk.min(self.steps));
            (self.moduli * PANEL * STEP).saturating_mul(slices)
        };
        match (self.same, self.groups) {
            (true, 1) => [bytes(self.left), 0],
            _ => [bytes(self.left), bytes(self.right)],
        }
    }

    /// Returns the rounds, in an order in which each needs at most one group that the round before
    /// it did not: A's groups one after another, each with those of B, beginning with the one that
    /// the last round had. If B is A, a round of a group with itself needs no second one, and is
    /// second, while both stores stay as they are.
    pub fn pairs(&self) -> impl Iterator<Item = Pair> + use<> {
        let Self { groups, symmetric, same, .. } = *self;
        (0..groups).flat_map(move |left| {
            let first = match (symmetric, same, left) {
                (false, _, 0) => [0; 2],
                (false, _, left) => [groups - 1 - usize::from(left.is_multiple_of(2)); 2],
                (true, false, left) => [left.saturating_sub(1); 2],
                (true, true, left) => [left.saturating_sub(2), left],
            };
            let count = if first[0] == first[1] { 1 } else { 2 };
            let rest = 0..if symmetric { left + 1 } else { groups };
            let rest = rest.filter(move |right| !first.contains(right));
            first.into_iter().take(count).chain(rest).map(move |right| Pair { left, right })
        })
    }

    /// Returns how often an entry of the operands is converted to residues, on average: the groups
    /// that the rounds of [`ExactLayout::pairs`] load over those that there are.
    pub fn conversions(&self) -> f64 {
        if self.groups == 1 {
            return 1.0;
        }
        let groups = self.groups as f64;
        // One a round, and the first needs two; with A alone rounds on the diagonal need none.
        let rounds = match (self.symmetric, self.same) {
            (true, true) => groups * (groups - 1.0) / 2.0,
            (true, false) => groups * (groups + 1.0) / 2.0,
            (false, _) => groups * groups,
        };
        (rounds + 1.0) / if self.same { groups } else { 2.0 * groups }
    }

    /// Returns the groups of panels that each side of a round consists of.
    pub fn needs(&self, pair: Pair) -> [Need; 2] {
        let operand = if self.same { 0 } else { 1 };
        [Need { operand: 0, group: pair.left }, Need { operand, group: pair.right }]
    }

    /// Returns the blocks of a round, in batches: a single batch where the blocks are sums over
    /// several chunks.
    pub fn batches(&self, pair: Pair) -> Vec<Batch> {
        let split = |all: Range<usize>, size: usize| {
            let end = all.end;
            all.step_by(size).map(move |first| first..end.min(first + size)).collect::<Vec<_>>()
        };
        let [left, right] = self.needs(pair).map(|need| self.group(need));
        let rows = split(left, self.blocking.rows);
        let most = self.most_places();
        let mut batches = vec![Batch::default()];
        // Neighbours share the residues of a side.
        for cols in split(right, self.blocking.cols) {
            for rows in &rows {
                // Columns beyond the last row are above the diagonal.
                let end = if self.symmetric { cols.end.min(rows.end) } else { cols.end };
                let cols = cols.start..end;
                if cols.is_empty() {
                    continue;
                }
                let places = rows.len() * cols.len();
                let full = batches.last().is_none_or(|batch| batch.places + places > most);
                if full && !self.accumulates() {
                    batches.push(Batch::default());
                }
                if let Some(batch) = batches.last_mut() {
                    batch.units.push(Unit { rows: rows.clone(), cols, first: batch.places });
                    batch.places += places;
                }
            }
        }
        for batch in &mut batches {
            batch.units.sort_by_key(|u| std::cmp::Reverse(self.cost(u)));
            // An odd distance between the residues of a pair, which are recombined together, so
            // that they do not all compete for the same lines of the cache.
            batch.places |= 1;
        }
        batches
    }

    /// Returns the number of pairs of panels in a block.
    pub fn cost(&self, unit: &Unit) -> usize {
        unit.cols.clone().map(|col| self.rows_of(unit, col).len()).sum()
    }

    /// Returns the row panels of a block that its column panel `col` needs.
    pub fn rows_of(&self, unit: &Unit, col: usize) -> Range<usize> {
        let first = if self.symmetric { unit.rows.start.max(col) } else { unit.rows.start };
        first.min(unit.rows.end)..unit.rows.end
    }

    /// Returns the column panels of a block that its row panel `row` needs.
    pub fn cols_of(&self, unit: &Unit, row: usize) -> Range<usize> {
        let end = if self.symmetric { unit.cols.end.min(row + 1) } else { unit.cols.end };
        unit.cols.start..end.max(unit.cols.start)
    }
}

/// Returns how many blocks of `size` panels all groups together have.
fn blocks(panels: usize, groups: usize, size: usize) -> usize {
    let (short, long) = (panels / groups, panels % groups);
    long * (short + 1).div_ceil(size) + (groups - long) * short.div_ceil(size)
}

/// Returns the pairs of panels, of the lower triangle or all.
fn pairs(triangle: bool, left: usize, right: usize) -> usize {
    if triangle { triangle_len(left) } else { left * right }
}

/// Returns the sum of `(factor i + summand) / divisor`, rounded down, for all `i < count`, in as
/// many steps as Euclid's algorithm takes for the factor and the divisor.
fn sum_of_floors(count: usize, divisor: usize, factor: usize, summand: usize) -> usize {
    step();
    if count == 0 {
        return 0;
    }
    let whole = factor / divisor * (count * (count - 1) / 2) + summand / divisor * count;
    let (factor, summand) = (factor % divisor, summand % divisor);
    let end = factor * count + summand;
    // The points below the line, counted along the other axis.
    whole + sum_of_floors(end / divisor, factor, divisor, end % divisor)
}
