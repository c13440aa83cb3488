//! How files of matrices are read.

use std::path::Path;

use super::columns::Columns;
use super::names::FileFormat;
use super::table::{Missing, TableOptions, option};
use crate::base::{Error, Progress, Result, options};

options! {
    /// How [`read`](crate::io::read()) reads. The default reads everything.
    ///
    /// ```
    /// use catamaran::io::{ReadOptions, read};
    ///
    /// # let folder = tempfile::tempdir().unwrap();
    /// # let path = &folder.path().join("a.csv");
    /// std::fs::write(path, "1,2,text\n3,4,text\n").unwrap();
    /// let a = read(path, &ReadOptions::new().columns(0..2).max_memory(1_000_000))?;
    /// assert_eq!((a.nrows(), a.ncols()), (2, 2));
    /// # Ok::<(), catamaran::Error>(())
    /// ```
    #[derive(Debug, Clone)]
    pub struct ReadOptions<'a> {
        /// Columns to keep. In a text table the others may hold anything.
        columns: Columns = Columns::ALL, setter into;
        /// The format; `None`: the one that the name of the file ends in, or else that of its
        /// content.
        format: Option<FileFormat> = None, setter into;
        /// How the text of a table is read.
        table: TableOptions = TableOptions::new();
        /// As `SourceOptions::max_memory`: of the entries, too. It also bounds the size of the
        /// file, whichever columns are kept.
        max_memory: Option<u64> = None, setter into;
        /// Receives the fraction of the file that has been read; may cancel.
        progress: Progress<'a> = Progress::none(), setter into;
    }
}

/// Options of tables for the notation of text, which that of weights shares.
const NOTATION: [&str; 6] =
    ["separator", "decimal", "thousands", "comment", "missing_words", "encoding"];

/// Returns whether an option of tables applies to a file of this format; `None` is an array.
fn applies(name: &str, format: Option<FileFormat>) -> bool {
    match (name, format) {
        ("missing", _) | (_, Some(FileFormat::Table)) => true,
        ("index", Some(format)) => format.is_columnar(),
        _ => false,
    }
}

impl ReadOptions<'_> {
    /// Checks that no rows are to be left out of an array: it has no missing cells, and its NaN are
    /// numbers. Public for the command line, which reads arrays block by block.
    ///
    /// # Errors
    /// [`Error::Io`] names the file and the option.
    #[doc(hidden)]
    pub fn check_array(&self, path: &Path) -> Result<()> {
        if self.table.missing != Missing::Drop {
            return Ok(());
        }
        let option = option("missing");
        let what = format!("{option} = drop: an array has no missing cells; its NaN are numbers");
        Err(Error::file(path, what))
    }

    /// Checks that each option of tables that was given applies to a file of one of these formats,
    /// the first of which is that of the file at `path`; `None` is an array. The options of
    /// notation also apply to weights in text, if there may be some. Public for the command line,
    /// which reads several files with the same options.
    ///
    /// # Errors
    /// [`Error::Io`] names the file and the option.
    #[doc(hidden)]
    pub fn check_effects(
        &self,
        path: &Path,
        formats: &[Option<FileFormat>],
        has_weights: bool,
    ) -> Result<()> {
        let is_idle = |(name, _): &(&str, String)| {
            let of_weights = has_weights && NOTATION.contains(name);
            !of_weights && !formats.iter().any(|&format| applies(name, format))
        };
        let Some((name, _)) = self.table.given().into_iter().find(is_idle) else { return Ok(()) };
        let tables = if name == "index" { "tables" } else { "text tables" };
        let kind = match formats.first().copied().flatten() {
            Some(FileFormat::Parquet) => "Parquet",
            Some(FileFormat::Arrow) => "Arrow",
            _ => "an array",
        };
        let what = format!("{} applies to {tables}, and this file is {kind}", option(name));
        Err(Error::file(path, what))
    }
}
