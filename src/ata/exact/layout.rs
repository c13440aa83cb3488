//! What the exact path will do, as data: which residues are in memory when, and which blocks of C are made of
//! them. Shapes and counts only.

use std::ops::Range;

use crate::kernel::int8::{MOST_ROWS, PANEL, STEP};

/// Memory that residues may take beyond the size of the operands; leaves room for a dozen threads in 256 MiB.
const ALLOWANCE: usize = 192 << 20;
/// Residues of a tall matrix in memory at a time: enough for long products, few enough for caches
/// and page tables.
const TALL_STORE: usize = 64 << 20;
/// Steps of a chunk of a tall matrix, at least: its sums are reduced once a chunk.
const TALL_STEPS: usize = 8192 / STEP;
/// Panels of a block of C: its left side stays in the second-level cache.
const BLOCK_ROWS: usize = 8;
const BLOCK_COLS: usize = 32;
/// Steps of the left side of a block that are in the cache at a time.
pub(super) const SLAB: usize = 2048 / STEP;
/// Steps of one product of panels: the right one stays in the first-level cache.
pub(super) const DEPTH: usize = 512 / STEP;

/// The division of the work. Panels are 32 columns, steps 64 rows.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(crate) struct Layout {
    /// Only the lower triangle of C.
    pub symmetric: bool,
    /// B is A.
    pub same: bool,
    /// Moduli.
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
    /// Panels of a block of C.
    pub block: (usize, usize),
}

/// Which residues a store holds.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(crate) struct Extent {
    pub panels: Range<usize>,
    pub steps: Range<usize>,
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
}

impl Layout {
    /// For A m x n and B m x k, with entries of `bytes` bytes.
    pub fn new(
        [m, n, k]: [usize; 3],
        bytes: usize,
        moduli: usize,
        symmetric: bool,
        same: bool,
    ) -> Self {
        let (left, right) = (n.div_ceil(PANEL), k.div_ceil(PANEL));
        let steps = m.div_ceil(STEP);
        let most_steps = MOST_ROWS / STEP;
        let columns = if same { left } else { left + right };
        let step_bytes = moduli * columns * PANEL * STEP;
        let operands = m * bytes * if same { n } else { n + k };
        let budget = operands + ALLOWANCE;
        let c_bytes = moduli * PANEL * PANEL * pairs(symmetric, left, right);
        let tall = m > 2 * n.max(k) || steps > most_steps;
        let tall_chunk = (TALL_STORE / step_bytes.max(1)).clamp(TALL_STEPS, most_steps);
        let (chunk, groups) = if steps <= most_steps
            && step_bytes * steps <= if tall { TALL_STORE } else { budget }
        {
            (steps, 1)
        } else if tall && c_bytes + step_bytes * tall_chunk <= budget {
            (tall_chunk, 1)
        } else {
            let chunk = steps.min(most_steps);
            let fits = |groups: usize| {
                let two = if same {
                    2 * left.div_ceil(groups)
                } else {
                    left.div_ceil(groups) + right.div_ceil(groups)
                };
                moduli * two * PANEL * STEP * chunk <= budget
            };
            (chunk, (2..=left.max(right)).find(|&g| fits(g)).unwrap_or(left.max(right)).max(1))
        };
        // Blocks enough for a few threads.
        let block = (left.div_ceil(4).clamp(1, BLOCK_ROWS), right.clamp(1, BLOCK_COLS));
        Self { symmetric, same, moduli, left, right, steps, chunk: chunk.max(1), groups, block }
    }

    /// Whether C is the sum over several chunks.
    pub fn accumulates(&self) -> bool {
        self.chunk < self.steps
    }

    /// The panels of a group.
    pub fn group(&self, need: Need) -> Range<usize> {
        let panels = if need.operand == 0 { self.left } else { self.right };
        need.group * panels / self.groups..(need.group + 1) * panels / self.groups
    }

    /// Steps, chunk by chunk.
    pub fn chunks(&self) -> impl Iterator<Item = Range<usize>> + '_ {
        (0..self.steps).step_by(self.chunk).map(|first| first..self.steps.min(first + self.chunk))
    }

    /// Stores and the most residues that each holds, in bytes.
    pub fn stores(&self) -> [usize; 2] {
        let bytes = |panels: usize| {
            self.moduli * panels.div_ceil(self.groups) * PANEL * STEP * self.chunk.min(self.steps)
        };
        match (self.same, self.groups) {
            (true, 1) => [bytes(self.left), 0],
            _ => [bytes(self.left), bytes(self.right)],
        }
    }

    /// The rounds, in an order that keeps residues while they are needed.
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

    /// What either side of a round is made of.
    pub fn needs(&self, pair: Pair) -> [Need; 2] {
        let operand = if self.same { 0 } else { 1 };
        [Need { operand: 0, group: pair.left }, Need { operand, group: pair.right }]
    }

    /// The blocks of a round, the largest first, so that the small ones fill the gaps at the end.
    pub fn units(&self, pair: Pair) -> Vec<Unit> {
        let split = |all: Range<usize>, size: usize| {
            let end = all.end;
            all.step_by(size).map(move |first| first..end.min(first + size)).collect::<Vec<_>>()
        };
        let [left, right] = self.needs(pair).map(|need| self.group(need));
        let (rows, cols) = (split(left, self.block.0), split(right, self.block.1));
        let mut units: Vec<Unit> = cols
            .iter()
            .flat_map(|c| rows.iter().map(|r| Unit { rows: r.clone(), cols: c.clone() }))
            .filter(|u| self.cost(u) > 0)
            .collect();
        units.sort_by_key(|u| std::cmp::Reverse(self.cost(u)));
        units
    }

    /// Pairs of panels in a block.
    pub fn cost(&self, unit: &Unit) -> usize {
        unit.cols.clone().map(|col| unit.rows.end.saturating_sub(self.first_row(unit, col))).sum()
    }

    /// The first panel of rows that column panel `col` of a block needs.
    pub fn first_row(&self, unit: &Unit, col: usize) -> usize {
        if self.symmetric { unit.rows.start.max(col) } else { unit.rows.start }
    }

    /// Blocks of 32 x 32 residues, per modulus, of the largest round.
    pub fn largest_round(&self) -> usize {
        let longest = |panels: usize| panels.div_ceil(self.groups);
        pairs(self.triangular(), longest(self.left), longest(self.right))
    }

    /// Where the residues of panel pair (i, j) are among those of a round.
    pub fn place(&self, pair: Pair, i: usize, j: usize) -> usize {
        let [rows, cols] = self.needs(pair).map(|need| self.group(need));
        let (i, j) = (i - rows.start, j - cols.start);
        if self.triangular() { i * (i + 1) / 2 + j } else { i * cols.len() + j }
    }

    /// Whether the only round is for a triangle.
    fn triangular(&self) -> bool {
        self.symmetric && self.groups == 1
    }
}

/// Pairs of panels, of the lower triangle or all.
fn pairs(triangle: bool, left: usize, right: usize) -> usize {
    if triangle { left * (left + 1) / 2 } else { left * right }
}
