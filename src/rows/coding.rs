//! Which columns are the indicators of factors, so that one code stands for them.

use std::ops::Range;

/// Which columns of a matrix are the indicators of the levels of a factor, so that one code stands
/// for all of them.
///
/// A coded row has the entries of the other columns, in their order, and then for each factor 0 for
/// the base, k for the k-th column of the factor, or NaN for a missing level.
/// [`RowBlocks::read_coded`](super::RowBlocks::read_coded) reads rows in this form. Sums in
/// extended precision are the same as those of the whole rows, and take less memory and time.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Coding {
    /// Columns of numbers, ascending.
    pub(super) numbers: Vec<usize>,
    /// The columns of each factor, ascending.
    pub(super) factors: Vec<Range<usize>>,
}

impl Coding {
    /// Creates a coding; every column is one of the numbers, or one of a factor.
    pub(super) fn new(numbers: Vec<usize>, factors: Vec<Range<usize>>) -> Self {
        Self { numbers, factors }
    }

    /// Returns the number of entries of a coded row.
    pub fn width(&self) -> usize {
        self.numbers.len() + self.factors.len()
    }

    /// Returns the number of columns of the matrix.
    pub(super) fn ncols(&self) -> usize {
        self.numbers.len() + self.factors.iter().map(Range::len).sum::<usize>()
    }

    /// Returns the column of the matrix, or the first one, that entry `at` of a coded row is of.
    pub(super) fn column(&self, at: usize) -> usize {
        let factor = || self.factors[at - self.numbers.len()].start;
        self.numbers.get(at).copied().unwrap_or_else(factor)
    }

    /// Returns ranges of columns, one after another, each of numbers or of one factor, which is cut
    /// into so many parts.
    pub(super) fn groups(&self, parts: usize) -> Vec<Range<usize>> {
        /// Columns of numbers that one thread takes: entries of a cache line.
        const NUMBERS: usize = 8;
        let (mut groups, mut next) = (Vec::new(), 0);
        let mut cut = |columns: Range<usize>, most: usize| {
            let firsts = columns.clone().step_by(most);
            groups.extend(firsts.map(|first| first..columns.end.min(first + most)));
        };
        for factor in &self.factors {
            cut(next..factor.start, NUMBERS);
            cut(factor.clone(), factor.len().div_ceil(parts));
            next = factor.end;
        }
        cut(next..self.ncols(), NUMBERS);
        groups
    }
}
