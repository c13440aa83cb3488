//! One rank has A and distributes its rows.

use std::ops::Range;

use super::machine::Machine;
use crate::base::triangle_len;

/// Returns the rows of A, m x n, that each of `ranks >= 1` processes gets, in order. Process 0
/// sends the rows.
///
/// On `machine` all processes end at the same time. Process 0 sends nothing to itself, so it keeps
/// more rows if messages are slower, and all of them if sending costs more than computing.
///
/// ```
/// use catamaran::ranks::plan::{Machine, row_shares};
///
/// let parts = row_shares(4, 1000, 50, &Machine { seconds_per_word: 0.0, ..Machine::default() });
/// assert_eq!(parts, [0..250, 250..500, 500..750, 750..1000]);
/// ```
pub fn row_shares(ranks: usize, m: usize, n: usize, machine: &Machine) -> Vec<Range<usize>> {
    let others = ranks.saturating_sub(1);
    let compute = 2.0 * triangle_len(n) as f64 / machine.flops;
    let travel = n as f64 * machine.seconds_per_word;
    // Seconds for a row of process 0, and for one of each other process: the largest of its
    // transfer, its product, and the transfers of the rows of all others.
    let slowest = (travel + compute).max(others as f64 * travel);
    let kept = slowest / (slowest + others as f64 * compute);
    let kept = if kept.is_finite() { (m as f64 * kept).ceil() as usize } else { m };
    let kept = kept.clamp(m.div_ceil(ranks.max(1)), m);
    let bound = |k: usize| kept + ((m - kept) as u128 * k as u128 / others.max(1) as u128) as usize;
    let first = std::iter::once(0..kept);
    first.chain((0..others).map(|k| bound(k)..bound(k + 1))).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_row_is_dealt_once_and_most_are_kept() {
        for ranks in [1, 2, 3, 4, 7, 64, 1000] {
            for (m, n) in [(0, 5), (1, 1), (7, 0), (1000, 10), (600_000, 500), (4096, 4096)] {
                let parts = row_shares(ranks, m, n, &Machine::default());
                assert_eq!(parts.len(), ranks);
                assert_eq!((parts[0].start, parts[ranks - 1].end), (0, m));
                assert!(parts.windows(2).all(|two| two[0].end == two[1].start));
                assert!(parts.iter().all(|rows| rows.len() <= parts[0].len().max(1)));
            }
        }
    }

    #[test]
    fn shares_are_even_where_messages_cost_nothing_and_all_stays_where_they_cost_everything() {
        let free = Machine { seconds_per_word: 0.0, ..Machine::default() };
        assert!(row_shares(4, 1000, 50, &free).iter().all(|rows| rows.len() == 250));
        let dear = Machine { seconds_per_word: 1e9, ..Machine::default() };
        assert_eq!(row_shares(4, 1000, 50, &dear)[0], 0..1000);
    }
}
