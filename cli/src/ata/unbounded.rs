//! Entries of C that are not finite.

use std::ops::Range;

use anyhow::Result;
use catamaran::Uplo;
use catamaran::blas::BlasReal;
use catamaran::faer::MatRef;

use crate::report::note;

/// How many entries of C are not finite.
#[derive(Default)]
pub struct Unbounded {
    count: usize,
    all: usize,
}

impl Unbounded {
    /// Counts the entries of C in the triangles of `uplo`.
    pub fn of<T: BlasReal>(c: MatRef<'_, T>, uplo: Uplo) -> Self {
        let mut found = Self::default();
        if uplo == Uplo::Upper {
            (0..c.nrows()).for_each(|i| found.add_row(c, i, i, i + 1..c.ncols(), 1));
        } else {
            found.add(c, 0, uplo);
        }
        found
    }

    /// Counts entries by one flag for each: whether the entry is finite.
    pub fn among(finite: impl Iterator<Item = bool>) -> Self {
        finite.fold(Self::default(), |found, is_finite| Self {
            count: found.count + usize::from(!is_finite),
            all: found.all + 1,
        })
    }

    /// Counts the entries of further rows of the lower triangle, the first of which is row `first`
    /// of C, and with `uplo` both their mirror images.
    pub fn add<T: BlasReal>(&mut self, rows: MatRef<'_, T>, first: usize, uplo: Uplo) {
        let images = if uplo == Uplo::Both { 2 } else { 1 };
        for i in 0..rows.nrows() {
            let diagonal = first + i;
            self.add_row(rows, i, diagonal, 0..diagonal, images);
        }
    }

    /// Counts the entry of row `i` on the diagonal, and those beside it `images` times.
    fn add_row<T: BlasReal>(
        &mut self,
        rows: MatRef<'_, T>,
        i: usize,
        diagonal: usize,
        beside: Range<usize>,
        images: usize,
    ) {
        self.all += images * beside.len() + 1;
        let found = beside.filter(|&j| !rows[(i, j)].is_finite()).count();
        self.count += images * found + usize::from(!rows[(i, diagonal)].is_finite());
    }

    /// Returns whether all entries are finite.
    pub fn is_none(&self) -> bool {
        self.count == 0
    }

    /// Returns a text with the number of these entries and that of all entries.
    pub fn text(&self) -> String {
        format!("{} of {} entries of C are not finite", self.count, self.all)
    }

    /// Notes the entries, if there are any, of a product of these files in this precision. `cause`
    /// returns an entry of a file that is not finite, with its place; it is asked only then.
    pub fn note(
        &self,
        files: &str,
        scalar: &str,
        cause: impl FnOnce() -> Result<Option<String>>,
    ) -> Result<()> {
        if self.is_none() {
            return Ok(());
        }
        let counted = self.text();
        match cause()? {
            Some(cause) => note(format_args!("{cause}; {counted}")),
            None => note(format_args!(
                "{files}: all entries are finite, but {counted}: sums are out of the range of \
                 {scalar}"
            )),
        }
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use catamaran::faer::Mat;

    use super::*;

    #[test]
    fn entries_are_counted_in_the_triangles_that_are_computed() {
        let c = Mat::from_fn(4, 4, |i, j| match (i, j) {
            (2, 2) => f64::NAN,
            (3, 1) => f64::INFINITY,
            // The mirror image, which differs to tell triangles apart.
            (1, 3) => f64::NEG_INFINITY,
            (0, 3) => f64::INFINITY,
            _ => 1.0,
        });
        let found = |uplo| {
            let found = Unbounded::of(c.as_ref(), uplo);
            (found.count, found.all)
        };
        assert_eq!(found(Uplo::Lower), (2, 10));
        assert_eq!(found(Uplo::Upper), (3, 10));
        assert_eq!(found(Uplo::Both), (3, 16));
        let mut strips = Unbounded::default();
        strips.add(c.as_ref().subrows(0, 3), 0, Uplo::Both);
        strips.add(c.as_ref().subrows(3, 1), 3, Uplo::Both);
        assert_eq!((strips.count, strips.all), (3, 16));
    }
}
