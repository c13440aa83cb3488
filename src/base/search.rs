//! Binary search among numbers.

use std::ops::Range;

use super::steps::step;

/// Returns the first number of `range` of which `holds` is true, or the end of the range. If it is
/// true of a number, it is true of larger ones.
pub(crate) fn first_that(range: Range<usize>, holds: impl Fn(usize) -> bool) -> usize {
    let Range { mut start, mut end } = range;
    while start < end {
        step();
        let middle = start.midpoint(end);
        if holds(middle) { end = middle } else { start = middle + 1 }
    }
    start
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_first_number_of_a_range_is_found() {
        for first in 0..12 {
            assert_eq!(first_that(2..9, |i| i >= first), first.clamp(2, 9));
        }
        assert_eq!(first_that(5..5, |_| true), 5);
    }
}
