//! # Tables
//!
//! The matrix in a file: a text table as spreadsheets, R or pandas write it, .npy, or a dense
//! MatrixMarket file. What the file leaves open is an error that names the field which decides.
//!
//! ```c
//! cata_table *table = NULL;
//! if (cata_table_read("heights.csv", NULL, &table) == CATA_OK) {
//!     size_t rows, columns;
//!     cata_table_shape(table, &rows, &columns, NULL);
//!     double *entries = malloc(rows * columns * sizeof *entries);
//!     cata_table_entries(table, CATA_ROW_MAJOR, entries, columns);
//!     printf("the first column is called %s\n", cata_table_name(table, 0));
//!     free(entries);
//! }
//! cata_table_free(table);
//! ```

use std::ffi::{CString, c_char, c_void};

use faer::Mat;

use super::boundary::{boundary, path, utf8};
use super::outputs::tell;
use super::params::{Params, init, params, read_or_zeros};
use super::pointer::{Layout, free, hand_over, known, matrix_mut, output};
use super::progress::cata_progress;
use super::status::{CATA_ERR_UNSUPPORTED, Failure, cata_status};
use catamaran::io::{
    ColumnKind, Columns, FileContent, FileFormat, Matrix, Missing, ReadOptions, Separator,
    TableOptions, read_file,
};

/// `header`, `index`: the file decides.
pub const CATA_AUTO: i32 = 0;
/// `header`, `index`: there is one.
pub const CATA_YES: i32 = 1;
/// `header`, `index`: there is none.
pub const CATA_NO: i32 = 2;

/// `missing`: a row with a missing cell in a column that is used is an error.
pub const CATA_MISSING_ERROR: i32 = 0;
/// `missing`: such a row is left out.
pub const CATA_MISSING_DROP: i32 = 1;
/// `missing`: such a cell becomes NaN.
pub const CATA_MISSING_NAN: i32 = 2;

/// How a table is read. What is 0 or NULL, the file decides.
#[repr(C)]
#[derive(Debug, Clone, Copy)]
pub struct cata_table_params {
    /// sizeof(cata_table_params).
    pub struct_size: usize,
    /// Threads, at most; 0: all. The result does not depend on them.
    pub threads: usize,
    /// Progress callback; NULL: none.
    pub progress: cata_progress,
    /// Passed to `progress`.
    pub progress_user: *mut c_void,
    /// Bytes of memory that the table may take; 0: a limit that suits usual files.
    pub max_memory: u64,
    /// Lines at the start of the file that are left out.
    pub skip: usize,
    /// Columns that are used: names, numbers from 0, ranges `3..5`, or a list of these between
    /// commas; NULL: all but those of words.
    pub columns: *const c_char,
    /// Names or numbers of columns that become factors if one of their entries is a word, between
    /// commas; NULL: none.
    pub factors: *const c_char,
    /// The words of missing cells, between commas; NULL: those of pandas, such as NA.
    pub missing_words: *const c_char,
    /// The encoding of the text, such as "latin1"; NULL: the file decides.
    pub encoding: *const c_char,
    /// "npy", "mtx" or "table"; NULL: the name of the file, or else its content, decides.
    pub format: *const c_char,
    /// CATA_MISSING_*.
    pub missing: i32,
    /// Whether the first row has the names of the columns: CATA_AUTO, CATA_YES or CATA_NO.
    pub header: i32,
    /// Whether the first column numbers or names the rows, and is left out: CATA_AUTO, CATA_YES or
    /// CATA_NO.
    pub index: i32,
    /// The character between fields; a blank: runs of blanks and tabs. 0: the file decides.
    pub separator: c_char,
    /// '.' or ','; 0: the file decides.
    pub decimal: c_char,
    /// The separator of groups of three digits; 0: the file decides.
    pub thousands: c_char,
    /// The character that starts a comment; 0: '#'.
    pub comment: c_char,
}

params!(cata_table_params, comment: c_char);

/// A matrix that was read, and what is known about its columns. Made by cata_table_read.
pub struct cata_table {
    entries: Mat<f64>,
    columns: Vec<Column>,
    dropped_rows: u64,
    reading: CString,
}

/// What is known about a column.
struct Column {
    name: CString,
    /// The levels of a factor; none for numbers.
    levels: Vec<CString>,
}

/// Fills a struct with the defaults.
///
/// # Safety
/// `params` points to `struct_size` writable bytes.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn cata_table_params_init(
    params: *mut cata_table_params,
    struct_size: usize,
) -> cata_status {
    // SAFETY: clause `structs` (`params`).
    unsafe { init(params, struct_size) }
}

/// Reads the matrix in a file, whose `path` is in UTF-8: a text table or .npy, each also packed
/// (.gz, .xz, .bz2, .zip), an array of .npz (`FILE.npz:NAME`), or .mtx without coordinates.
/// A column of words is left out unless it is a factor. Errors name the file, the line and the
/// column.
///
/// # Safety
/// The pointers are as described.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn cata_table_read(
    path: *const c_char,
    params: *const cata_table_params,
    table: *mut *mut cata_table,
) -> cata_status {
    boundary(|| {
        // SAFETY: clause `memory` (`table`, one value), clause `structs` (`params`), clause `texts`
        // (`path`).
        let (path, params, place) = unsafe {
            (self::path("path", path)?, read_or_zeros("params", params)?, output("table", table)?)
        };
        // SAFETY: clause `texts` (those of `params`).
        let options = unsafe { params.options() }?;
        let caller = params.caller();
        let found = caller.with(|progress| read_file(&path, &options.progress(progress)))?;
        hand_over(place, cata_table::of(found)?);
        Ok(())
    })
}

/// Gets the number of rows, the number of columns, and the number of rows that were left out
/// because a cell is missing. NULL where not wanted.
///
/// # Safety
/// The pointers are as described.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn cata_table_shape(
    table: *const cata_table,
    rows: *mut usize,
    columns: *mut usize,
    dropped_rows: *mut u64,
) -> cata_status {
    boundary(|| {
        // SAFETY: clause `memory` (`rows`, one value; `columns`, one value; `dropped_rows`, one
        // value), clause `handles` (`table`).
        unsafe {
            let table = known("table", table)?;
            let (m, n) = table.entries.shape();
            tell!(rows: m, columns: n, dropped_rows: table.dropped_rows);
        }
        Ok(())
    })
}

/// Gets the entries, rows x columns. An entry of a factor is the number of its level, from 0; a
/// missing cell is NaN.
///
/// # Safety
/// The pointers are as described.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn cata_table_entries(
    table: *const cata_table,
    layout: i32,
    entries: *mut f64,
    ld: usize,
) -> cata_status {
    boundary(|| {
        let layout = Layout::new(layout)?;
        // SAFETY: clause `memory` (`entries`, m x n), clause `handles` (`table`).
        let (table, mut place) = unsafe {
            let table = known("table", table)?;
            let (m, n) = table.entries.shape();
            (table, matrix_mut("entries", layout, m, n, entries, ld)?)
        };
        place.copy_from(&table.entries);
        Ok(())
    })
}

/// Returns the name of a column, in UTF-8; valid until cata_table_free. Empty for NULL, for a
/// column that does not exist, and without names. Never NULL; do not free it.
///
/// # Safety
/// The pointer is as described.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn cata_table_name(table: *const cata_table, column: usize) -> *const c_char {
    // SAFETY: clause `handles` (`table`); NULL gives the default.
    let column = unsafe { table.as_ref() }.and_then(|table| table.columns.get(column));
    column.map_or(c"".as_ptr(), |column| column.name.as_ptr())
}

/// Returns the number of levels of a factor; 0 for NULL, for a column that does not exist, and for
/// one of numbers.
///
/// # Safety
/// The pointer is as described.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn cata_table_levels(table: *const cata_table, column: usize) -> usize {
    // SAFETY: clause `handles` (`table`); NULL gives the default.
    let column = unsafe { table.as_ref() }.and_then(|table| table.columns.get(column));
    column.map_or(0, |column| column.levels.len())
}

/// Returns a level of a factor, from 0, in UTF-8; valid until cata_table_free. Empty where there is
/// none. Never NULL; do not free it.
///
/// # Safety
/// The pointer is as described.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn cata_table_level(
    table: *const cata_table,
    column: usize,
    level: usize,
) -> *const c_char {
    // SAFETY: clause `handles` (`table`); NULL gives the default.
    let column = unsafe { table.as_ref() }.and_then(|table| table.columns.get(column));
    let level = column.and_then(|column| column.levels.get(level));
    level.map_or(c"".as_ptr(), |level| level.as_ptr())
}

/// Returns what was decided about a text table, such as "separator ;, decimal comma, header", and
/// which integers of any format were rounded, in UTF-8; valid until cata_table_free. Empty for NULL
/// and where there is nothing to say. Never NULL; do not free it.
///
/// # Safety
/// The pointer is as described.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn cata_table_reading(table: *const cata_table) -> *const c_char {
    // SAFETY: clause `handles` (`table`); NULL gives the default.
    unsafe { table.as_ref() }.map_or(c"".as_ptr(), |table| table.reading.as_ptr())
}

/// Frees a table.
///
/// # Safety
/// The pointer is as described.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn cata_table_free(table: *mut cata_table) {
    // SAFETY: clause `handles` (`table`).
    unsafe { free(table) };
}

impl cata_table_params {
    /// Returns the options of the library.
    ///
    /// # Safety
    /// The texts are NULL or NUL-terminated.
    unsafe fn options<'a>(&self) -> Result<ReadOptions<'a>, Failure> {
        // SAFETY: clause `texts` (`params.columns`, `params.factors`, `params.missing_words`,
        // `params.encoding`, `params.format`).
        let (columns, factors, words, encoding, format) = unsafe {
            (
                optional_text("params.columns", self.columns)?,
                optional_text("params.factors", self.factors)?,
                optional_text("params.missing_words", self.missing_words)?,
                optional_text("params.encoding", self.encoding)?,
                optional_text("params.format", self.format)?,
            )
        };
        let list = |text: String| text.split(',').map(str::to_owned).collect::<Vec<_>>();
        let missing = match self.missing {
            CATA_MISSING_ERROR => Missing::Error,
            CATA_MISSING_DROP => Missing::Drop,
            CATA_MISSING_NAN => Missing::Nan,
            other => {
                let any = "a CATA_MISSING_* value";
                return Err(Failure::argument("params.missing", any, other));
            }
        };
        let known = |name: String| {
            let found = FileFormat::NAMES.into_iter().find(|(known, _)| *known == name);
            found.map(|(_, format)| format).ok_or_else(|| {
                let names = FileFormat::NAMES.map(|(name, _)| name).join(", ");
                Failure::argument("params.format", format!("one of {names}"), name)
            })
        };
        let table = TableOptions::new()
            .separator(character(self.separator).map(Separator::from))
            .decimal(character(self.decimal))
            .thousands(character(self.thousands))
            .comment(character(self.comment))
            .header(choice("params.header", self.header)?)
            .index(choice("params.index", self.index)?)
            .skip(self.skip)
            .missing(missing)
            .missing_words(words.map(list))
            .encoding(encoding)
            .factors(factors.map(list).unwrap_or_default())
            .par(self.par());
        Ok(ReadOptions::new()
            .columns(columns.map_or(Columns::ALL, |columns| Columns::parse(&columns)))
            .format(format.map(known).transpose()?)
            .table(table)
            .max_memory((self.max_memory > 0).then_some(self.max_memory)))
    }
}

impl cata_table {
    fn of(content: FileContent) -> Result<Self, Failure> {
        let FileContent { matrix, names, reading, rounded, .. } = content;
        let entries = match matrix {
            Matrix::F64(entries) => entries.as_ref().to_owned(),
            Matrix::F32(entries) => {
                let entries = entries.as_ref();
                let (m, n) = entries.shape();
                Mat::from_fn(m, n, |i, j| f64::from(entries[(i, j)]))
            }
            _ => {
                let why = "path: a matrix of coordinates is no table";
                return Err(Failure::new(CATA_ERR_UNSUPPORTED, why));
            }
        };
        let levels = |j: usize| {
            let column = reading.as_ref().and_then(|reading| reading.columns.get(j));
            match column.map(|column| &column.kind) {
                Some(ColumnKind::Factor { levels }) => levels.iter().map(|l| c_text(l)).collect(),
                _ => Vec::new(),
            }
        };
        let name = |j: usize| c_text(names.get(j).map_or("", String::as_str));
        let column = |j: usize| Column { name: name(j), levels: levels(j) };
        Ok(Self {
            columns: (0..entries.ncols()).map(column).collect(),
            entries,
            dropped_rows: reading.as_ref().map_or(0, |reading| reading.dropped_rows),
            reading: c_text(&match (&reading, &rounded) {
                (Some(reading), _) => reading.to_string(),
                (None, Some(rounded)) => rounded.to_string(),
                (None, None) => String::new(),
            }),
        })
    }
}

/// Returns a text for C, which ends before its first NUL.
fn c_text(text: &str) -> CString {
    CString::new(text.split('\0').next().unwrap_or_default()).unwrap_or_default()
}

/// Returns an ASCII character; `None` for 0.
fn character(character: c_char) -> Option<char> {
    // The byte of the character, whether a C char is signed or not.
    (character != 0).then_some(char::from(character as u8))
}

fn choice(what: &str, choice: i32) -> Result<Option<bool>, Failure> {
    match choice {
        CATA_AUTO => Ok(None),
        CATA_YES => Ok(Some(true)),
        CATA_NO => Ok(Some(false)),
        other => Err(Failure::argument(what, "CATA_AUTO, CATA_YES or CATA_NO", other)),
    }
}

/// Returns a text of the caller, or `None` for NULL.
///
/// # Safety
/// `text` is NULL or NUL-terminated.
unsafe fn optional_text(what: &str, text: *const c_char) -> Result<Option<String>, Failure> {
    if text.is_null() {
        return Ok(None);
    }
    // SAFETY: clause `texts` (`text`).
    unsafe { utf8(what, text) }.map(Some)
}
