//! What a caller may decide about a text table.

use crate::base::{Error, Par, Result, options};

/// What separates the fields of a row.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[non_exhaustive]
pub enum Separator {
    /// An ASCII character, such as a comma.
    Char(char),
    /// Runs of blanks and tabs.
    Blanks,
}

impl From<char> for Separator {
    fn from(separator: char) -> Self {
        match separator {
            ' ' => Self::Blanks,
            other => Self::Char(other),
        }
    }
}

/// What becomes of a row with a missing cell in a column that is used.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[non_exhaustive]
pub enum Missing {
    /// An error names the first such cell.
    Error,
    /// The row is left out; [`TableReading::dropped_rows`](super::TableReading) counts such rows.
    /// An array has no missing cells, and is refused.
    Drop,
    /// The cell becomes NaN.
    Nan,
}

impl Missing {
    /// The names of the values, for faces.
    pub const NAMES: [(&str, Self); 3] =
        [("error", Self::Error), ("drop", Self::Drop), ("nan", Self::Nan)];
}

/// What becomes of a column of words.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[non_exhaustive]
pub enum Words {
    /// It is left out. Where it is named in `columns`, that is an error.
    LeaveOut,
    /// It becomes a factor: its entries are the numbers of levels, from 0.
    Factor,
}

options! {
    /// How the text of a table is read. By default the beginning of the file decides; what it
    /// leaves open is an error that names the option.
    ///
    /// ```
    /// use catamaran::io::{Missing, ReadOptions, TableOptions, read};
    ///
    /// # let folder = tempfile::tempdir().unwrap();
    /// # let path = &folder.path().join("a.csv");
    /// std::fs::write(path, "zeit;druck\n1,5;2\n2,5;NA\n").unwrap();
    /// let table = TableOptions::new().missing(Missing::Drop);
    /// let a = read(path, &ReadOptions::new().table(table))?;
    /// assert_eq!((a.nrows(), a.ncols()), (1, 2));
    /// # Ok::<(), catamaran::Error>(())
    /// ```
    #[derive(Debug, Clone)]
    pub struct TableOptions {
        /// What separates fields; `None`: tab, semicolon, comma, bar or blanks, whichever splits
        /// the rows evenly into numbers.
        separator: Option<Separator> = None, setter into;
        /// The decimal separator, a point or a comma; `None`: the one with which all numbers can be
        /// read.
        decimal: Option<char> = None, setter into;
        /// The separator of groups of three digits: a comma, point, blank or apostrophe. `None`:
        /// none, or the only one with which all numbers can be read.
        thousands: Option<char> = None, setter into;
        /// Whether the first row has the names of the columns; `None`: it has if a field of it is a
        /// word.
        header: Option<bool> = None, setter into;
        /// Number of lines at the start of the file that are left out.
        skip: usize = 0;
        /// The ASCII character that starts a comment, at the start of a line or after a blank;
        /// `None`: `#`, after a blank only where rows need it.
        comment: Option<char> = None, setter into;
        /// What becomes of a row with a missing cell.
        missing: Missing = Missing::Error;
        /// The words of missing cells, besides empty cells; `None`: those of pandas, and a point.
        missing_words: Option<Vec<String>> = None, setter into;
        /// Whether the first column numbers or names the rows, and is left out; `None`: it does if
        /// it has no name and all others have one.
        index: Option<bool> = None, setter into;
        /// The encoding, by a name of the WHATWG standard such as `latin1`; `None`: that of the
        /// byte order mark, else UTF-8, and Windows-1252 for text that is not UTF-8.
        encoding: Option<String> = None, setter into;
        /// What becomes of a column of words.
        words: Words = Words::LeaveOut;
        /// Columns, by their names or their numbers from 0, that become factors if one of their
        /// entries is a word, whatever `words` says. Names that no column has are ignored.
        factors: Vec<String> = Vec::new();
        /// Threads that read numbers. The result does not depend on them.
        par: Par = Par::all();
    }
}

impl TableOptions {
    /// Returns the names and the values, as text, of the options that were given, but for those of
    /// factors. Public for the command line.
    #[doc(hidden)]
    pub fn given(&self) -> Vec<(&'static str, String)> {
        let text = |c: char| format!("{c:?}");
        let flag = |flag: Option<bool>| flag.map(|flag| flag.to_string());
        let separator = self.separator.map(|separator| match separator {
            Separator::Char(c) => text(c),
            Separator::Blanks => text(' '),
        });
        let named = |(_, missing): &(&str, Missing)| *missing == self.missing;
        let missing = Missing::NAMES.into_iter().find(named).map(|(name, _)| name.to_owned());
        let values = [
            ("separator", separator),
            ("decimal", self.decimal.map(text)),
            ("thousands", self.thousands.map(text)),
            ("header", flag(self.header)),
            ("skip", (self.skip > 0).then(|| self.skip.to_string())),
            ("comment", self.comment.map(text)),
            ("missing", missing.filter(|_| self.missing != Missing::Error)),
            ("missing_words", self.missing_words.as_ref().map(|words| words.join(","))),
            ("index", flag(self.index)),
            ("encoding", self.encoding.clone()),
        ];
        values.into_iter().filter_map(|(name, value)| Some((name, value?))).collect()
    }

    /// Returns the options that decide which rows are read, each behind a comma, for the identity
    /// of a file.
    pub(in crate::io) fn identity(&self) -> String {
        let given = self.given().into_iter().map(|(name, value)| format!(", {name} {value}"));
        let words = (self.words == Words::Factor).then(|| ", words as factors".to_owned());
        let names = self.factors.join(", ");
        let factors = (!names.is_empty()).then(|| format!(", factors {names}"));
        given.chain(words).chain(factors).collect()
    }

    /// Checks the characters.
    pub(super) fn check(&self) -> Result<()> {
        let refuse = |what, why: &str| Err(Error::Argument { what, why: why.into() });
        if let Some(Separator::Char(c)) = self.separator
            && (!c.is_ascii() || c.is_ascii_alphanumeric() || "\"\n\r+-.".contains(c))
        {
            return refuse("separator", "must be an ASCII character that is in no number");
        }
        if self.comment.is_some_and(|c| !c.is_ascii_punctuation() || "\"+-.".contains(c)) {
            return refuse("comment", "must be an ASCII character that is in no number");
        }
        if self.decimal.is_some_and(|c| !".,".contains(c)) {
            return refuse("decimal", "must be a point or a comma");
        }
        if self.thousands.is_some_and(|c| !",. '".contains(c)) {
            return refuse("thousands", "must be a comma, a point, a blank or an apostrophe");
        }
        if self.decimal.is_some() && self.decimal == self.thousands {
            return refuse("thousands", "must not be the decimal separator");
        }
        Ok(())
    }
}
