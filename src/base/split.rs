//! Even splits of a range.

use std::ops::Range;

/// Returns part `i` of `parts` of a range. Parts differ by at most one in length, the shorter ones
/// first, so that two halves are floor and ceiling as in the thesis.
pub(crate) fn even_part(range: Range<usize>, parts: usize, i: usize) -> Range<usize> {
    let start = |i| range.start + even_start(range.len(), parts, i);
    start(i)..start(i + 1)
}

/// Returns the start of part `i` of [`even_part`] of `0..len`.
pub(crate) fn even_start(len: usize, parts: usize, i: usize) -> usize {
    let long = len % parts;
    let short_blocks = parts - long;
    (len / parts) * i + i.saturating_sub(short_blocks)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn parts_follow_each_other_and_the_shorter_ones_come_first() {
        assert_eq!([0, 1].map(|i| even_part(3..10, 2, i)), [3..6, 6..10]);
        for (len, parts) in [(0, 3), (2, 5), (17, 4), (16, 4)] {
            let all: Vec<_> = (0..parts).map(|i| even_part(7..7 + len, parts, i)).collect();
            assert_eq!((all[0].start, all[parts - 1].end), (7, 7 + len));
            for pair in all.windows(2) {
                assert_eq!(pair[0].end, pair[1].start);
                assert!((0..=1).contains(&(pair[1].len() - pair[0].len())));
            }
        }
    }
}
