//! Lists of rows: those that a process adds, in its order.

use std::fmt;
use std::ops::Range;
use std::str::FromStr;

/// Ranges of rows, one after another.
#[derive(Debug, Clone, Default, PartialEq, Eq)]
pub struct RowList(Vec<Range<usize>>);

impl From<Range<usize>> for RowList {
    fn from(rows: Range<usize>) -> Self {
        Self::default().then(rows)
    }
}

/// Lists rows, or the columns of a file, in this order.
impl FromIterator<usize> for RowList {
    fn from_iter<I: IntoIterator<Item = usize>>(rows: I) -> Self {
        rows.into_iter().fold(Self::default(), |list, row| list.then(row..row + 1))
    }
}

impl RowList {
    /// Returns the list with these rows at its end.
    fn then(mut self, rows: Range<usize>) -> Self {
        match self.0.last_mut() {
            _ if rows.is_empty() => {}
            Some(last) if last.end == rows.start => last.end = rows.end,
            _ => self.0.push(rows),
        }
        self
    }

    /// Returns the list followed by another one.
    pub fn join(self, other: &Self) -> Self {
        other.0.iter().cloned().fold(self, Self::then)
    }

    /// Returns the rows, one after another.
    pub fn iter(&self) -> impl Iterator<Item = usize> + '_ {
        self.0.iter().cloned().flatten()
    }

    /// Returns the number of rows.
    pub fn len(&self) -> usize {
        self.0.iter().map(Range::len).sum()
    }

    /// Returns the rows at these places of the list.
    pub fn part(&self, places: Range<usize>) -> Self {
        let mut start = 0;
        self.0.iter().fold(Self::default(), |part, rows| {
            let own = start..start + rows.len();
            start = own.end;
            let first = places.start.clamp(own.start, own.end) - own.start;
            let end = places.end.clamp(own.start, own.end) - own.start;
            part.then(rows.start + first..rows.start + end.max(first))
        })
    }

    /// Calls `work(place, rows)` with the ranges of rows at these places of the list, each with the
    /// place of its first row, counted from the first of these places.
    pub fn for_each<E>(
        &self,
        places: Range<usize>,
        mut work: impl FnMut(usize, Range<usize>) -> Result<(), E>,
    ) -> Result<(), E> {
        let mut place = 0;
        for rows in self.part(places).0 {
            let len = rows.len();
            work(place, rows)?;
            place += len;
        }
        Ok(())
    }

    /// Returns the values of these rows, of the values of all rows.
    pub fn pick<T: Copy>(&self, values: &[T]) -> Vec<T> {
        self.0.iter().flat_map(|rows| values[rows.clone()].iter().copied()).collect()
    }

    /// Returns the rows of `0..m` that are not in the list; `None` if a row is in it twice or not
    /// in `0..m`.
    pub fn rest(&self, m: usize) -> Option<Self> {
        let mut sorted = self.0.clone();
        sorted.sort_by_key(|rows| rows.start);
        let (mut rest, mut end) = (Self::default(), 0);
        for rows in sorted {
            if rows.start < end || rows.end > m {
                return None;
            }
            rest = rest.then(end..rows.start);
            end = rows.end;
        }
        Some(rest.then(end..m))
    }
}

/// Writes the ranges, as in `0..3,7..9`.
impl fmt::Display for RowList {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        for (i, Range { start, end }) in self.0.iter().enumerate() {
            let comma = if i > 0 { "," } else { "" };
            write!(f, "{comma}{start}..{end}")?;
        }
        Ok(())
    }
}

impl FromStr for RowList {
    type Err = ();

    fn from_str(text: &str) -> Result<Self, ()> {
        let mut ranges = text.split(',').filter(|range| !range.is_empty());
        ranges.try_fold(Self::default(), |list, range| {
            let (start, end) = range.split_once("..").ok_or(())?;
            let number = |text: &str| text.parse::<usize>().map_err(drop);
            let (start, end) = (number(start)?, number(end)?);
            if start < end { Ok(list.then(start..end)) } else { Err(()) }
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn list(text: &str) -> RowList {
        text.parse().unwrap()
    }

    #[test]
    fn lists_are_texts_and_neighbours_join() {
        for text in ["", "0..3", "0..3,7..9", "7..9,0..3"] {
            assert_eq!(list(text).to_string(), text);
        }
        assert_eq!(list("0..3,3..5").to_string(), "0..5");
        let rows = [3, 4, 5, 1, 0];
        assert_eq!(RowList::from_iter(rows).to_string(), "3..6,1..2,0..1");
        assert!(RowList::from_iter(rows).iter().eq(rows));
        assert_eq!(RowList::from(4..4), list(""));
        for text in ["3", "3..", "3..2", "3..3", "a..b", "-1..2"] {
            assert_eq!(text.parse::<RowList>(), Err(()), "{text}");
        }
    }

    #[test]
    fn places_of_a_list_are_rows() {
        let rows = list("10..14,0..2,5..6");
        assert_eq!(rows.len(), 7);
        for (places, expected) in [
            (0..7, "10..14,0..2,5..6"),
            (0..0, ""),
            (3..5, "13..14,0..1"),
            (5..9, "1..2,5..6"),
            (1..2, "11..12"),
        ] {
            assert_eq!(rows.part(places.clone()), list(expected), "{places:?}");
        }
        let mut calls = Vec::new();
        rows.for_each::<()>(3..7, |place, rows| {
            calls.push((place, rows));
            Ok(())
        })
        .unwrap();
        assert_eq!(calls, [(0, 13..14), (1, 0..2), (3, 5..6)]);
        let values: Vec<usize> = (0..20).map(|i| i * i).collect();
        assert_eq!(list("4..6,0..1").pick(&values), [16, 25, 0]);
    }

    #[test]
    fn rows_that_are_missing_are_found_and_rows_twice_are_refused() {
        assert_eq!(list("4..6,0..1").rest(9), Some(list("1..4,6..9")));
        assert_eq!(list("").rest(3), Some(list("0..3")));
        assert_eq!(list("0..3").rest(3), Some(list("")));
        assert_eq!(list("").rest(0), Some(list("")));
        assert_eq!(list("0..3,2..4").rest(9), None);
        assert_eq!(list("0..3").rest(2), None);
    }

    #[test]
    fn parts_of_a_list_and_what_was_before_give_all_rows_once() {
        let before = list("0..4,10..13");
        let rest = before.rest(20).unwrap();
        let own: Vec<_> = [0..5, 5..9, 9..13].map(|places| rest.part(places)).into();
        let all = own.iter().fold(before, |list, own| list.join(own));
        assert_eq!((all.len(), all.rest(20)), (20, Some(list(""))));
    }
}
