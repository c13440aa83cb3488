//! MatrixMarket (Boisvert, Pozo and Remington 1996): dense arrays, and coordinates through sprs.

use std::fmt::Debug;
use std::io::{self, Write};
use std::ops::{AddAssign, Neg, Range};
use std::str::SplitAsciiWhitespace;

use faer::{MatRef, c64};
use sprs::TriMat;

use super::columns::Columns;
use super::extents::padded_bytes;
use super::matrix::{Dense, Matrix};
use super::rounding::RoundedIntegers;
use super::source::Source;
use super::table::{option, rounded_words};
use crate::base::{Result, push, reserved};

#[derive(Clone, Copy, PartialEq)]
enum Symmetry {
    General,
    Symmetric,
    Skew,
    Hermitian,
}

impl Symmetry {
    /// Returns the entry on the other side of the diagonal.
    fn mirrored<E: Entry>(self, value: E) -> E {
        match self {
            Self::General | Self::Symmetric => value,
            Self::Skew => -value,
            Self::Hermitian => value.conjugate(),
        }
    }
}

#[derive(Clone, Copy, PartialEq)]
enum Field {
    Real,
    Pattern,
    Complex,
}

struct Header {
    coordinate: bool,
    field: Field,
    symmetry: Symmetry,
}

/// An entry of a matrix.
trait Entry: Copy + AddAssign + Neg<Output = Self> {
    const ZERO: Self;
    const ONE: Self;
    /// What a line has for an entry.
    const WORDS: &'static str;

    /// Takes an entry from the words of a line; `None` if they are too few.
    fn take(words: &mut SplitAsciiWhitespace<'_>) -> Option<std::result::Result<Self, String>>;

    fn conjugate(self) -> Self;

    /// Returns whether the entry may be on the diagonal of a Hermitian matrix.
    fn is_real(self) -> bool;
}

impl Entry for f64 {
    const ZERO: Self = 0.0;
    const ONE: Self = 1.0;
    const WORDS: &'static str = "value";

    fn take(words: &mut SplitAsciiWhitespace<'_>) -> Option<std::result::Result<Self, String>> {
        Some(real(words.next()?))
    }

    fn conjugate(self) -> Self {
        self
    }

    fn is_real(self) -> bool {
        true
    }
}

impl Entry for c64 {
    const ZERO: Self = Self { re: 0.0, im: 0.0 };
    const ONE: Self = Self { re: 1.0, im: 0.0 };
    const WORDS: &'static str = "real imaginary";

    fn take(words: &mut SplitAsciiWhitespace<'_>) -> Option<std::result::Result<Self, String>> {
        let (re, im) = (f64::take(words)?, f64::take(words)?);
        Some(re.and_then(|re| Ok(Self { re, im: im? })))
    }

    fn conjugate(self) -> Self {
        self.conj()
    }

    fn is_real(self) -> bool {
        self.im == 0.0
    }
}

/// Reads a matrix, and returns which integers in these columns were rounded.
pub(super) fn read(
    source: &mut Source<'_>,
    columns: &Columns,
) -> Result<(Matrix, Option<RoundedIntegers>)> {
    let header = header(source)?;
    let sizes = numbers(source, if header.coordinate { 3 } else { 2 })?;
    let (nrows, ncols) = (sizes[0], sizes[1]);
    if header.symmetry != Symmetry::General && nrows != ncols {
        return Err(source.fail(format!("a symmetric matrix must be square: {nrows} x {ncols}")));
    }
    let mirrors = header.symmetry != Symmetry::General;
    let (is_kept, columns) = (columns.kept(ncols)?, columns.range(ncols)?);
    let (shape, mut found) = ((nrows, ncols), None);
    // A line has an entry and its mirror image.
    let rounded = &mut |line: usize, i: usize, j: usize, count: usize| {
        if count > 0 && (is_kept(j) || mirrors && is_kept(i)) {
            RoundedIntegers::add(&mut found, count as u64, || format!("line {line}"));
        }
    };
    let matrix = match (header.coordinate, header.field) {
        (true, Field::Complex) => {
            complex_coordinate(source, &header, shape, sizes[2], columns, rounded)?
        }
        (true, _) => coordinate(source, &header, shape, sizes[2], &columns, rounded)?,
        (false, Field::Complex) => {
            let values = array::<c64>(source, &header, shape, rounded)?;
            Matrix::Complex(Dense::new(values, shape, false, columns))
        }
        (false, _) => {
            let values = array::<f64>(source, &header, shape, rounded)?;
            Matrix::F64(Dense::new(values, shape, false, columns))
        }
    };
    Ok((matrix, found))
}

/// Takes the line, the row and the column of an entry, and the number of its integers that were
/// rounded.
type Rounded<'a> = &'a mut dyn FnMut(usize, usize, usize, usize);

fn header(source: &mut Source<'_>) -> Result<Header> {
    let line = source.next_line()?.unwrap_or_default().to_ascii_lowercase();
    let words: Vec<&str> = line.split_ascii_whitespace().collect();
    let ["%%matrixmarket", "matrix", layout, field, symmetry] = words[..] else {
        let format = option("format");
        return Err(source.fail(format!(
            "broken MatrixMarket header: expected \
             '%%MatrixMarket matrix coordinate|array real|integer|complex|pattern \
             general|symmetric|skew-symmetric|hermitian'; {format} = table reads other text"
        )));
    };
    let coordinate = match layout {
        "coordinate" => true,
        "array" => false,
        _ => return Err(source.fail(format!("layout {layout:?} is not coordinate or array"))),
    };
    let field = match field {
        "real" | "double" | "integer" | "unsigned-integer" => Field::Real,
        "complex" => Field::Complex,
        "pattern" if coordinate => Field::Pattern,
        _ => return Err(source.fail(format!("entries of type {field:?} are not numbers"))),
    };
    let symmetry = match symmetry {
        "general" => Symmetry::General,
        "symmetric" => Symmetry::Symmetric,
        "skew-symmetric" => Symmetry::Skew,
        "hermitian" if field == Field::Complex => Symmetry::Hermitian,
        _ => {
            let kind = if field == Field::Complex { "complex" } else { "real" };
            let what = format!("symmetry {symmetry:?} is not one of a {kind} matrix");
            return Err(source.fail(what));
        }
    };
    Ok(Header { coordinate, field, symmetry })
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
    (nrows, ncols): (usize, usize),
    count: usize,
    columns: &Range<usize>,
    rounded: Rounded<'_>,
) -> Result<Matrix> {
    for extent in [nrows, ncols] {
        padded_bytes(&[extent], size_of::<f64>()).map_err(|what| source.fail(what))?;
    }
    let mirrored = header.symmetry != Symmetry::General;
    let most = count.saturating_mul(if mirrored { 2 } else { 1 });
    let words = nrows.saturating_add(1).saturating_add(most.saturating_mul(WORDS));
    let what = format_args!("a sparse matrix of {nrows} rows and {count} entries");
    source.check_memory::<usize>(what, words)?;
    let (mut rows, mut cols, mut values) = (Vec::new(), Vec::new(), Vec::new());
    entries(source, header, (nrows, ncols), count, rounded, |i, j, value: f64| {
        if columns.contains(&j) {
            push(&mut rows, i)?;
            push(&mut cols, j - columns.start)?;
            push(&mut values, value)?;
        }
        Ok(())
    })?;
    // sprs would abort when memory is refused.
    drop(reserved::<usize>(nrows.saturating_add(1) + (WORDS - TRIPLET) * values.len())?);
    let triplets = TriMat::from_triplets((nrows, columns.len()), rows, cols, values);
    Ok(Matrix::Sparse(triplets.to_csr()))
}

/// Reads the coordinates of a complex matrix, which becomes a dense one.
fn complex_coordinate(
    source: &mut Source<'_>,
    header: &Header,
    shape: (usize, usize),
    count: usize,
    columns: Range<usize>,
    rounded: Rounded<'_>,
) -> Result<Matrix> {
    let len = entries_of::<c64>(source, shape)?;
    let mut values: Vec<c64> = reserved(len)?;
    values.resize(len, c64::ZERO);
    entries(source, header, shape, count, rounded, |i, j, value: c64| {
        values[i * shape.1 + j] += value;
        Ok(())
    })?;
    Ok(Matrix::Complex(Dense::new(values, shape, true, columns)))
}

/// Returns the number of entries of a dense matrix, which memory can hold.
fn entries_of<E>(source: &Source<'_>, (nrows, ncols): (usize, usize)) -> Result<usize> {
    padded_bytes(&[nrows, ncols], size_of::<E>()).map_err(|what| source.fail(what))?;
    let len = nrows * ncols;
    source.check_memory::<E>(format_args!("a {nrows} x {ncols} matrix"), len)?;
    Ok(len)
}

/// Reads the lines of coordinates, and gives each entry and its mirror image to `add`.
fn entries<E: Entry>(
    source: &mut Source<'_>,
    header: &Header,
    (nrows, ncols): (usize, usize),
    count: usize,
    rounded: Rounded<'_>,
    mut add: impl FnMut(usize, usize, E) -> Result<()>,
) -> Result<()> {
    let Header { symmetry, field, .. } = *header;
    // Which triangle of a symmetric matrix the file has; the format asks for the lower one.
    let mut is_lower = None;
    for done in 0..count {
        let Some(line) = content(source)? else {
            return Err(source.fail(format!("truncated: {done} of {count} entries")));
        };
        let found = match field {
            Field::Pattern => pattern(line).map(|(i, j)| (i, j, None)),
            Field::Real | Field::Complex => entry(line).map(|(i, j, value)| (i, j, Some(value))),
        };
        let integers = if field == Field::Pattern { 0 } else { rounded_words(line, 2) };
        let (i, j, value) = match found {
            Ok(entry) => entry,
            Err(what) => return Err(source.fail(what)),
        };
        if i == 0 || i > nrows || j == 0 || j > ncols {
            return Err(
                source.fail(format!("entry ({i}, {j}) is outside the {nrows} x {ncols} matrix"))
            );
        }
        let (i, j, value) = (i - 1, j - 1, value.unwrap_or(E::ONE));
        rounded(source.line(), i, j, integers);
        if symmetry == Symmetry::General {
            add(i, j, value)?;
            continue;
        }
        if i == j {
            check_diagonal(source, symmetry, value)?;
            add(i, j, value)?;
            continue;
        }
        if *is_lower.get_or_insert(i > j) != (i > j) {
            return Err(source.fail("entries in both triangles of a symmetric matrix"));
        }
        add(i, j, value)?;
        add(j, i, symmetry.mirrored(value))?;
    }
    nothing_more(source, count)
}

/// Refuses an entry on the diagonal that the symmetry excludes.
fn check_diagonal<E: Entry>(source: &Source<'_>, symmetry: Symmetry, value: E) -> Result<()> {
    match symmetry {
        Symmetry::Skew => Err(source.fail("an entry on the diagonal of a skew-symmetric matrix")),
        Symmetry::Hermitian if !value.is_real() => {
            Err(source.fail("an entry that is not real on the diagonal of a Hermitian matrix"))
        }
        _ => Ok(()),
    }
}

fn index(word: &str) -> std::result::Result<usize, String> {
    word.parse().map_err(|_| format!("{word:?} is not a whole number of at least 1"))
}

fn pattern(line: &str) -> std::result::Result<(usize, usize), String> {
    let mut words = line.split_ascii_whitespace();
    match (words.next(), words.next(), words.next()) {
        (Some(i), Some(j), None) => Ok((index(i)?, index(j)?)),
        _ => Err(format!("expected row column in {line:?}")),
    }
}

fn entry<E: Entry>(line: &str) -> std::result::Result<(usize, usize, E), String> {
    let mut words = line.split_ascii_whitespace();
    match (words.next(), words.next(), E::take(&mut words), words.next()) {
        (Some(i), Some(j), Some(value), None) => Ok((index(i)?, index(j)?, value?)),
        _ => Err(format!("expected row column {} in {line:?}", E::WORDS)),
    }
}

/// Returns a number, whose exponent may be that of Fortran.
fn real(word: &str) -> std::result::Result<f64, String> {
    let exponent = |c: char| if matches!(c, 'd' | 'D') { 'e' } else { c };
    word.parse()
        .or_else(|_| word.chars().map(exponent).collect::<String>().parse())
        .map_err(|_| format!("{word:?} is not a number"))
}

/// Reads the entries of an array, column by column; the file of a symmetric matrix has its lower
/// triangle only.
fn array<E: Entry>(
    source: &mut Source<'_>,
    header: &Header,
    (nrows, ncols): (usize, usize),
    rounded: Rounded<'_>,
) -> Result<Vec<E>> {
    let symmetry = header.symmetry;
    let len = entries_of::<E>(source, (nrows, ncols))?;
    let mut values: Vec<E> = reserved(len)?;
    let mut read = 0;
    // A matrix without rows may have many columns.
    let columns = if len == 0 { 0 } else { ncols };
    for j in 0..columns {
        let given = match symmetry {
            Symmetry::General => 0,
            Symmetry::Symmetric | Symmetry::Hermitian => j,
            Symmetry::Skew => j + 1,
        };
        for i in 0..given.min(nrows) {
            values.push(match i == j {
                true => E::ZERO,
                false => symmetry.mirrored(values[i * nrows + j]),
            });
        }
        for i in given..nrows {
            read += 1;
            let Some(line) = content(source)? else {
                let (i, j) = (i + 1, j + 1);
                return Err(source.fail(format!("truncated: no entry for row {i}, column {j}")));
            };
            let integers = rounded_words(line, 0);
            let value: E = match one(line) {
                Ok(value) => value,
                Err(what) => return Err(source.fail(what)),
            };
            rounded(source.line(), i, j, integers);
            if i == j {
                check_diagonal(source, symmetry, value)?;
            }
            values.push(value);
        }
    }
    nothing_more(source, read)?;
    Ok(values)
}

/// Returns the entry of a line.
fn one<E: Entry>(line: &str) -> std::result::Result<E, String> {
    let mut words = line.split_ascii_whitespace();
    match (E::take(&mut words), words.next()) {
        (Some(value), None) => value,
        (Some(_), Some(_)) => Err(format!("{:?} is not a number", line.trim_ascii())),
        (None, _) => Err(format!("expected {} in {line:?}", E::WORDS)),
    }
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

/// Writes an array of complex numbers.
pub(super) fn write_complex(sink: &mut dyn Write, matrix: MatRef<'_, c64>) -> io::Result<()> {
    writeln!(sink, "%%MatrixMarket matrix array complex general")?;
    writeln!(sink, "{} {}", matrix.nrows(), matrix.ncols())?;
    for j in 0..matrix.ncols() {
        for i in 0..matrix.nrows() {
            writeln!(sink, "{:?} {:?}", matrix[(i, j)].re, matrix[(i, j)].im)?;
        }
    }
    Ok(())
}
