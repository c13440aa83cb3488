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
}
