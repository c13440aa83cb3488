//! MatrixMarket (Boisvert, Pozo and Remington 1996): dense arrays, and coordinates through sprs.

use std::fmt::Debug;
use std::io::{self, Write};
use std::ops::Range;
use std::str::FromStr;

use faer::MatRef;
use sprs::TriMat;

use super::columns::Columns;
use super::extents::padded_bytes;
use super::matrix::{Dense, Matrix};
use super::source::Source;
use crate::base::{Result, push, reserved};

#[derive(Clone, Copy, PartialEq)]
enum Symmetry {
    General,
    Symmetric,
    Skew,
}

struct Header {
    coordinate: bool,
    pattern: bool,
    symmetry: Symmetry,
}

pub(super) fn read(source: &mut Source<'_>, columns: &Columns) -> Result<Matrix> {
    let header = header(source)?;
    let sizes = numbers(source, if header.coordinate { 3 } else { 2 })?;
    let (nrows, ncols) = (sizes[0], sizes[1]);
    if header.symmetry != Symmetry::General && nrows != ncols {
        return Err(source.fail(format!("a symmetric matrix must be square: {nrows} x {ncols}")));
    }
    let columns = columns.range(ncols)?;
    if header.coordinate {
        coordinate(source, &header, nrows, ncols, sizes[2], &columns)
    } else {
        array(source, &header, nrows, ncols, columns)
    }
}

fn header(source: &mut Source<'_>) -> Result<Header> {
    let line = source.next_line()?.unwrap_or_default().to_ascii_lowercase();
    let words: Vec<&str> = line.split_ascii_whitespace().collect();
    let ["%%matrixmarket", "matrix", layout, field, symmetry] = words[..] else {
        return Err(source.fail(
            "broken MatrixMarket header: expected \
             '%%MatrixMarket matrix coordinate|array real|integer|pattern general|symmetric|skew-symmetric'",
        ));
    };
    let coordinate = match layout {
        "coordinate" => true,
        "array" => false,
        _ => return Err(source.fail(format!("layout {layout:?} is not coordinate or array"))),
    };
    let pattern = match field {
        "real" | "double" | "integer" => false,
        "pattern" if coordinate => true,
        _ => return Err(source.fail(format!("entries of type {field:?} are not real numbers"))),
    };
    let symmetry = match symmetry {
        "general" => Symmetry::General,
        "symmetric" => Symmetry::Symmetric,
        "skew-symmetric" => Symmetry::Skew,
        _ => return Err(source.fail(format!("symmetry {symmetry:?} is not one of a real matrix"))),
    };
    Ok(Header { coordinate, pattern, symmetry })
}

/// Returns the next line that is neither empty nor a comment.
fn content<'s>(source: &'s mut Source<'_>) -> Result<Option<&'s str>> {
    loop {
        // The line is returned again below: the borrow checker would extend its borrow over the
        // loop.
        match source.next_line()? {
            None => return Ok(None),
            Some(line) if line.trim_ascii().is_empty() || line.starts_with('%') => {}
            Some(_) => return Ok(Some(source.last_line())),
        }
    }
}

/// Reads the size line: `count` whole numbers.
fn numbers(source: &mut Source<'_>, count: usize) -> Result<Vec<usize>> {
    let line = content(source)?.unwrap_or_default().to_owned();
    let sizes: Option<Vec<usize>> =
        line.split_ascii_whitespace().map(|word| word.parse().ok()).collect();
    sizes.filter(|sizes| sizes.len() == count).ok_or_else(|| {
        source.fail(format!("broken size line: expected {count} whole numbers, got {line:?}"))
    })
}

/// Words of an entry while it is read: row, column and value.
const TRIPLET: usize = 3;
/// Words of an entry while the entries are sorted by rows: those and what sprs makes of them.
const WORDS: usize = 2 * TRIPLET;

fn coordinate(
    source: &mut Source<'_>,
    header: &Header,
    nrows: usize,
    ncols: usize,
    entries: usize,
    columns: &Range<usize>,
) -> Result<Matrix> {
    for extent in [nrows, ncols] {
        padded_bytes(&[extent], size_of::<f64>()).map_err(|what| source.fail(what))?;
    }
    let mirrored = header.symmetry != Symmetry::General;
    let most = entries.saturating_mul(if mirrored { 2 } else { 1 });
    let words = nrows.saturating_add(1).saturating_add(most.saturating_mul(WORDS));
    let what = format_args!("a sparse matrix of {nrows} rows and {entries} entries");
    source.check_memory::<usize>(what, words)?;
    let (mut rows, mut cols, mut values) = (Vec::new(), Vec::new(), Vec::new());
    let mut add = |i, j, value| -> Result<()> {
        if columns.contains(&j) {
            push(&mut rows, i)?;
            push(&mut cols, j - columns.start)?;
            push(&mut values, value)?;
        }
        Ok(())
    };
    // Which triangle of a symmetric matrix the file has; the format asks for the lower one.
    let mut is_lower = None;
    for done in 0..entries {
        let Some(line) = content(source)? else {
            return Err(source.fail(format!("truncated: {done} of {entries} entries")));
        };
        let (i, j, value) = match entry(line, header.pattern) {
            Ok(entry) => entry,
            Err(what) => return Err(source.fail(what)),
        };
        if i == 0 || i > nrows || j == 0 || j > ncols {
            return Err(
                source.fail(format!("entry ({i}, {j}) is outside the {nrows} x {ncols} matrix"))
            );
        }
        let (i, j) = (i - 1, j - 1);
        if mirrored && i != j && *is_lower.get_or_insert(i > j) != (i > j) {
            return Err(source.fail("entries in both triangles of a symmetric matrix"));
        }
        match header.symmetry {
            Symmetry::General => add(i, j, value)?,
            Symmetry::Symmetric if i == j => add(i, j, value)?,
            Symmetry::Symmetric => {
                add(i, j, value)?;
                add(j, i, value)?;
            }
            Symmetry::Skew if i == j => {
                return Err(source.fail("an entry on the diagonal of a skew-symmetric matrix"));
            }
            Symmetry::Skew => {
                add(i, j, value)?;
                add(j, i, -value)?;
            }
        }
    }
    nothing_more(source, entries)?;
    // sprs would abort when memory is refused.
    drop(reserved::<usize>(nrows.saturating_add(1) + (WORDS - TRIPLET) * values.len())?);
    let triplets = TriMat::from_triplets((nrows, columns.len()), rows, cols, values);
    Ok(Matrix::Sparse(triplets.to_csr()))
}

fn entry(line: &str, pattern: bool) -> std::result::Result<(usize, usize, f64), String> {
    fn parse<T: FromStr>(word: &str) -> std::result::Result<T, String> {
        word.parse().map_err(|_| format!("{word:?} is not a number"))
    }
    let mut words = line.split_ascii_whitespace();
    match (words.next(), words.next(), words.next(), words.next()) {
        (Some(i), Some(j), None, None) if pattern => Ok((parse(i)?, parse(j)?, 1.0)),
        (Some(i), Some(j), Some(value), None) if !pattern => {
            Ok((parse(i)?, parse(j)?, real(value)?))
        }
        _ => Err(format!(
            "expected {} in {line:?}",
            if pattern { "row column" } else { "row column value" }
        )),
    }
}

/// Returns a number, whose exponent may be that of Fortran.
fn real(word: &str) -> std::result::Result<f64, String> {
    let exponent = |c: char| if matches!(c, 'd' | 'D') { 'e' } else { c };
    word.parse()
        .or_else(|_| word.chars().map(exponent).collect::<String>().parse())
        .map_err(|_| format!("{word:?} is not a number"))
}

fn array(
    source: &mut Source<'_>,
    header: &Header,
    nrows: usize,
    ncols: usize,
    columns: Range<usize>,
) -> Result<Matrix> {
    padded_bytes(&[nrows, ncols], size_of::<f64>()).map_err(|what| source.fail(what))?;
    let len = nrows * ncols;
    source.check_memory::<f64>(format_args!("a {nrows} x {ncols} matrix"), len)?;
    let mut values: Vec<f64> = reserved(len)?;
    if len == 0 {
        nothing_more(source, len)?;
        return Ok(Matrix::F64(Dense::new(values, (nrows, ncols), false, columns)));
    }
    // Column by column; the file of a symmetric matrix has its lower triangle only.
    let mut read = 0;
    for j in 0..ncols {
        let given = match header.symmetry {
            Symmetry::General => 0,
            Symmetry::Symmetric => j,
            Symmetry::Skew => j + 1,
        };
        for i in 0..given.min(nrows) {
            let value = match (header.symmetry, i == j) {
                (Symmetry::Skew, true) => 0.0,
                (Symmetry::Skew, false) => -values[i * nrows + j],
                _ => values[i * nrows + j],
            };
            values.push(value);
        }
        for i in given..nrows {
            read += 1;
            let value = match content(source)? {
                Some(line) => real(line.trim_ascii()),
                None => Err(format!("truncated: no entry for row {}, column {}", i + 1, j + 1)),
            };
            values.push(value.map_err(|what| source.fail(what))?);
        }
    }
    nothing_more(source, read)?;
    Ok(Matrix::F64(Dense::new(values, (nrows, ncols), false, columns)))
}

fn nothing_more(source: &mut Source<'_>, entries: usize) -> Result<()> {
    match content(source)? {
        None => Ok(()),
        Some(_) => Err(source.fail(format!("data after the {entries} entries announced"))),
    }
}

/// Writes an array; `field` is the type of its entries in MatrixMarket.
pub(super) fn write<T: Debug>(
    sink: &mut dyn Write,
    matrix: MatRef<'_, T>,
    field: &str,
) -> io::Result<()> {
    writeln!(sink, "%%MatrixMarket matrix array {field} general")?;
    writeln!(sink, "{} {}", matrix.nrows(), matrix.ncols())?;
    for j in 0..matrix.ncols() {
        for i in 0..matrix.nrows() {
            writeln!(sink, "{:?}", matrix[(i, j)])?;
        }
    }
    Ok(())
}
