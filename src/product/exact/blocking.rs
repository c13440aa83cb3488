//! The parts of the residues that stay in each cache while they are multiplied.

use crate::base::data_caches;
use crate::kernel::int8::{DEPTH, Slice};

/// The extents of a block of C, the piece of a product that one thread takes.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) struct Blocking {
    /// Panels of its left side, of which `depth` steps stay in the second-level cache.
    pub rows: usize,
    /// Panels of its right side, one of which, `depth` steps of it, stays in the first-level cache.
    pub cols: usize,
    /// Steps of a product: the residues of the block are read and written once for so many.
    pub depth: usize,
}

/// Panels of the right side: the left one is rearranged once for so many.
const COLS: usize = 128;

/// Panels of the right side to which blocks are narrowed before they are lowered.
const NARROW: usize = 16;

/// Panels below which no side of a block is halved.
const LEAST: usize = 8;

impl Blocking {
    /// Chooses the blocking of products of matrices of `left` and `right` panels, on this machine.
    pub fn new(left: usize, right: usize) -> Self {
        Self::for_caches(data_caches(), left, right)
    }

    /// Chooses the blocking for these caches: the right panel takes two thirds of the first-level
    /// cache, the left side a quarter of the second.
    fn for_caches([first, second]: [usize; 2], left: usize, right: usize) -> Self {
        let depth = (first / 3 * 2 / size_of::<Slice>()).clamp(1, DEPTH);
        let most_rows = (second / 4 / (depth * size_of::<Slice>())).max(1);
        // Blocks of equal height, because low blocks are slow.
        let rows = left.div_ceil(left.div_ceil(most_rows).max(1)).max(1);
        let cols = right.clamp(1, COLS);
        Self { rows, cols, depth }
    }

    /// Halves the blocks along the side where that costs less; returns whether it did. Narrow
    /// blocks rearrange the left side more often, low ones load the right side more often.
    pub fn halve(&mut self) -> bool {
        let Self { rows, cols, .. } = self;
        let narrows = *cols > NARROW || (*rows <= LEAST && *cols > LEAST);
        if !narrows && *rows <= LEAST {
            return false;
        }
        let side = if narrows { cols } else { rows };
        *side = side.div_ceil(2);
        true
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn parts_fit_their_caches() {
        for first in [8 << 10, 32 << 10, 48 << 10, 128 << 10] {
            for second in [256 << 10, 512 << 10, 1 << 20, 2 << 20, 16 << 20] {
                for (left, right) in [(1, 1), (3, 200), (32, 32), (128, 128), (1000, 1000)] {
                    let Blocking { rows, cols, depth } =
                        Blocking::for_caches([first, second], left, right);
                    let context = format!("{first}, {second}, {left} x {right}");
                    assert!((1..=DEPTH).contains(&depth), "{context}");
                    assert!((1..=left).contains(&rows) && (1..=right).contains(&cols), "{context}");
                    let slice = size_of::<Slice>();
                    assert!(depth * slice < first, "{context}: right panel");
                    assert!(
                        rows == 1 || 2 * rows * depth * slice <= second,
                        "{context}: left side"
                    );
                }
            }
        }
    }

    #[test]
    fn the_machine_on_which_it_was_measured_gets_what_was_fastest() {
        let sapphire_rapids = [48 << 10, 2 << 20];
        let blocking = Blocking::for_caches(sapphire_rapids, 128, 128);
        assert_eq!(blocking, Blocking { rows: 16, cols: 128, depth: 16 });
    }
}
