//! The plan of the exact path, as data: which residues are in memory at which time, and which
//! blocks of C are computed from them. Shapes and counts only.

use std::ops::Range;

use super::blocking::Blocking;
use crate::kernel::int8::{Block, DEPTH, PANEL, STEP};

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
pub(crate) struct Layout {
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

impl Layout {
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
        let (left, right) = (n.div_ceil(PANEL), k.div_ceil(PANEL));
        let steps = m.div_ceil(STEP);
        let columns = if same { left } else { left + right };
        let step_bytes = moduli * columns * PANEL * STEP;
        let operands = m * bytes * if same { n } else { n + k };
        let budget = memory.map_or(operands + ALLOWANCE, |bytes| bytes / 2);
        let tall_store = memory.map_or(TALL_STORE, |bytes| TALL_STORE.min(bytes / 4));
        let batch = memory.map_or(BATCH, |bytes| BATCH.min(bytes / 4));
        let c_bytes = moduli * PANEL * PANEL * pairs(symmetric, left, right);
        let tall = m > 2 * n.max(k);
        // Whole pieces of the usual depth.
        let tall_chunk = (tall_store / step_bytes.max(1)).max(TALL_STEPS) / DEPTH * DEPTH;
        let (chunk, groups) = if step_bytes * steps <= if tall { tall_store } else { budget } {
            (steps, 1)
        } else if tall && c_bytes + step_bytes * tall_chunk <= budget {
            (tall_chunk, 1)
        } else {
            let fits = |groups: usize| {
                let two = if same {
                    2 * left.div_ceil(groups)
                } else {
                    left.div_ceil(groups) + right.div_ceil(groups)
                };
                moduli * two * PANEL * STEP * steps <= budget
            };
            (steps, (2..=left.max(right)).find(|&g| fits(g)).unwrap_or(left.max(right)).max(1))
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

    /// Returns the mean number of products of blocks, of all moduli, in a batch.
    fn products_in_batch(&self) -> usize {
        let batches: Vec<Batch> = self.all_batches().collect();
        let units: usize = batches.iter().map(|batch| batch.units.len()).sum();
        self.moduli * units / batches.len().max(1)
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
            self.moduli * panels.div_ceil(self.groups) * PANEL * STEP * self.chunk.min(self.steps)
        };
        match (self.same, self.groups) {
            (true, 1) => [bytes(self.left), 0],
            _ => [bytes(self.left), bytes(self.right)],
        }
    }

    /// Returns the rounds, in an order that keeps residues in memory while later rounds need them.
    pub fn pairs(&self) -> Vec<Pair> {
        let wanted = |left: usize| 0..if self.symmetric { left + 1 } else { self.groups };
        let mut open: Vec<Pair> = (0..self.groups)
            .flat_map(|left| wanted(left).map(move |right| Pair { left, right }))
            .collect();
        let mut order: Vec<Pair> = Vec::new();
        let mut held: Vec<Need> = Vec::new();
        while !open.is_empty() {
            let loads = |p: &Pair| self.needs(*p).iter().filter(|n| !held.contains(n)).count();
            let next = (0..open.len()).min_by_key(|&i| loads(&open[i])).unwrap_or(0);
            let pair = open.remove(next);
            let needs = self.needs(pair);
            // There are two stores. A round of one group with itself leaves the other alone.
            if needs[0] != needs[1] {
                held.clear();
            }
            held.extend(needs);
            order.push(pair);
        }
        order
    }

    /// Returns how often an entry of the operands is converted to residues, on average.
    pub fn conversions(&self) -> f64 {
        if self.groups == 1 {
            return 1.0;
        }
        let (mut held, mut loads): (Vec<Need>, usize) = (Vec::new(), 0);
        for pair in self.pairs() {
            let needs = self.needs(pair);
            let missing: Vec<_> = needs.into_iter().filter(|need| !held.contains(need)).collect();
            loads += if needs[0] == needs[1] { missing.len().min(1) } else { missing.len() };
            if needs[0] != needs[1] {
                held.clear();
            }
            held.extend(needs);
        }
        let all = if self.same { self.groups } else { 2 * self.groups };
        loads as f64 / all as f64
    }

    /// Returns the groups of panels that each side of a round consists of.
    pub fn needs(&self, pair: Pair) -> [Need; 2] {
        let operand = if self.same { 0 } else { 1 };
        [Need { operand: 0, group: pair.left }, Need { operand, group: pair.right }]
    }

    /// Returns the batches of all rounds, in order.
    pub fn all_batches(&self) -> impl Iterator<Item = Batch> {
        self.pairs().into_iter().flat_map(|pair| self.batches(pair))
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
        let most = self.batch / (self.moduli * size_of::<Block<i8>>());
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

/// Returns the pairs of panels, of the lower triangle or all.
fn pairs(triangle: bool, left: usize, right: usize) -> usize {
    if triangle { left * (left + 1) / 2 } else { left * right }
}
