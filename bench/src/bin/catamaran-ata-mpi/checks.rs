//! The checks of `--check` on the last product.

use std::fmt;

use catamaran::base::triangle_len;
use catamaran::ranks::plan::{Bricks, Chunks, Machine, Mode, difference_cover, predict};
use catamaran_bench::input::Shape;

use crate::job::Job;
use crate::report::Cost;

/// A value that must not exceed its limit.
#[derive(Debug, Clone, PartialEq)]
pub struct Check {
    /// Description of the value.
    pub what: String,
    /// The value; a NaN fails.
    pub value: f64,
    /// The limit, finite.
    pub limit: f64,
}

impl Check {
    /// Returns whether the value is within its limit.
    pub fn passed(&self) -> bool {
        self.limit.is_finite() && self.value <= self.limit
    }
}

impl fmt::Display for Check {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Self { what, value, limit } = self;
        // `!passed` may be a NaN, for which `>` would be false.
        let sign = if self.passed() { "<=" } else { "> " };
        let values = if value.fract() == 0.0 && limit.fract() == 0.0 {
            format!("{value:>9} {sign} {limit:<9}")
        } else {
            format!("{value:>9.1e} {sign} {limit:<9.1e}")
        };
        write!(f, "{what:<46}{values}  {}", verdict(self.passed()))
    }
}

/// Returns `PASSED` or `FAILED`.
pub fn verdict(passed: bool) -> &'static str {
    if passed { "PASSED" } else { "FAILED" }
}

/// Largest number of entries of a message of MPI, whose counts have 32 bits.
const LONGEST: usize = 1 << 30;

/// Checks the words and messages of the rank with the most against the plan, which is exact where
/// parts are even.
pub fn of_plan<T>(job: &Job, ranks: usize, counted: Cost) -> Vec<Check> {
    let Job { mode, shape: Shape { m, n }, .. } = *job;
    let planned = predict(mode, ranks, m, n, &Machine::default());
    let words = Check {
        what: "words, difference from the plan".into(),
        // Shares of a triangle are quotients in floating point.
        value: (counted.words - planned.words.round()).abs(),
        limit: unevenness(mode, ranks, m, n) as f64,
    };
    // Longer messages are cut. In `deal`, the plan counts blocks of f64: the same number of bytes
    // of f32 is more rows.
    let longest = m.saturating_mul(n).max(n.saturating_mul(n));
    let other_blocks = mode == Mode::Deal && size_of::<T>() != size_of::<f64>();
    if other_blocks || longest > LONGEST {
        return vec![words];
    }
    let messages = Check {
        what: "messages, difference from the plan".into(),
        value: (counted.messages - planned.messages).abs(),
        limit: 0.0,
    };
    vec![words, messages]
}

/// Returns the number of words by which the rank with the most may differ from the plan, which
/// assumes equal parts.
fn unevenness(mode: Mode, ranks: usize, m: usize, n: usize) -> usize {
    // A part of a chunk may be a word longer or shorter than another one.
    let of_chunks = |chunks: Chunks| {
        let len = |c| triangle_len(chunks.rows(c).end) - triangle_len(chunks.rows(c).start);
        let uneven = (0..chunks.count()).filter(|&c| !len(c).is_multiple_of(ranks)).count();
        uneven * (ranks - 1)
    };
    match mode {
        Mode::Tree => 0,
        Mode::Rows => of_chunks(Chunks::new(m, n, ranks)),
        // Every rank has a sum of n rows.
        Mode::Deal => of_chunks(Chunks::new(n * ranks, n, ranks)),
        Mode::Columns if n.is_multiple_of(ranks) => 0,
        // A rank may see one column less of each of the others.
        Mode::Columns => (difference_cover(ranks).len() - 1) * m,
        Mode::Bricks => {
            let bricks = Bricks::new(ranks, m, n);
            let (columns, slices) = (bricks.blocks().ranks(), bricks.slices());
            let is_even = n.is_multiple_of(columns) && m.is_multiple_of(slices);
            let seen = difference_cover(columns).len();
            // A row or a column less of each block, and its sums; a word of each part of the sums.
            let less = (seen - 1) * (m.div_ceil(slices) + n.div_ceil(columns)) + n + 1;
            let in_parts = if bricks.blocks().len(0).is_multiple_of(slices) { 0 } else { slices };
            if is_even { in_parts } else { less + in_parts }
        }
    }
}

#[cfg(test)]
mod tests {
    use catamaran::SchemeChoice;

    use super::*;

    #[test]
    fn only_finite_values_within_a_finite_limit_pass() {
        let passed = |value, limit| Check { what: String::new(), value, limit }.passed();
        assert!(passed(0.0, 0.0) && passed(1e-12, 1e-11));
        assert!(!passed(1.0, 0.0) && !passed(f64::NAN, 1.0) && !passed(f64::INFINITY, 1.0));
        assert!(!passed(0.0, f64::NAN) && !passed(0.0, f64::INFINITY));
    }

    #[test]
    fn planned_thirds_of_a_triangle_are_whole_words() {
        let shape = Shape { m: 531, n: 257 };
        let job = Job { mode: Mode::Rows, shape, seed: 1, threads: 1, scheme: SchemeChoice::Auto };
        let cost = Cost { words: (triangle_len(257) / 3 * 2) as f64, messages: 2.0 };
        assert!(of_plan::<f64>(&job, 3, cost).iter().all(Check::passed));
    }

    #[test]
    fn a_word_or_message_more_than_planned_fails_where_parts_are_even() {
        for (_, mode) in Mode::NAMES {
            let shape = Shape { m: 640, n: 256 };
            let job = Job { mode, shape, seed: 1, threads: 1, scheme: SchemeChoice::Auto };
            let planned = predict(mode, 4, shape.m, shape.n, &Machine::default());
            let cost = Cost { words: planned.words, messages: planned.messages };
            let passed = |cost| of_plan::<f64>(&job, 4, cost).iter().all(Check::passed);
            assert!(passed(cost), "{mode}");
            let more = |words, messages| Cost {
                words: cost.words + words,
                messages: cost.messages + messages,
            };
            assert!(!passed(more(1.0, 0.0)), "{mode}");
            assert!(!passed(more(0.0, 1.0)), "{mode}");
        }
    }
}
