//! The rows of a table as those of a matrix: complete rows only, and factors as columns of zeros
//! and ones.

use faer::MatMut;

use super::blocks::for_each_block;
use super::coding::Coding;
use super::factor::Factor;
use super::grid::RowBounds;
use super::source::RowBlocks;
use crate::base::{Error, Par, Result, block_rows, push, zeros};

/// What one pass over a table finds for its [`Design`].
#[derive(Debug, Clone, PartialEq)]
#[non_exhaustive]
pub struct Survey {
    /// Rows, ascending, with a NaN in one of the columns that are used.
    pub missing: Vec<usize>,
    /// For each factor the entries of its column in the other rows, ascending, each once.
    pub entries: Vec<Vec<f64>>,
    /// The bounds of all columns in the other rows.
    pub bounds: RowBounds<f64>,
}

impl Survey {
    /// Reads all rows, of which these columns are used, and the entries of these factors.
    ///
    /// ```
    /// use catamaran::{Par, faer::mat, rows::{DenseRows, Survey}};
    ///
    /// let a = mat![[1.0, 7.0, f64::NAN], [f64::NAN, 8.0, 0.0], [2.0, 7.0, 0.0], [3.0, 4.0, 0.0]];
    /// let found = Survey::of(&mut DenseRows(a.as_ref()), &[0, 1], &[1], Par::Seq)?;
    /// assert_eq!((found.missing, found.entries), (vec![1], vec![vec![4.0, 7.0]]));
    /// # Ok::<(), catamaran::Error>(())
    /// ```
    ///
    /// # Errors
    /// [`Error::NonFinite`] of "table" for an infinity in a row that is not missing;
    /// [`Error::Argument`] of "factor" for a column with more than [`Survey::MOST_LEVELS`]
    /// different entries; those of the source; [`Error::OutOfMemory`].
    pub fn of(
        rows: &mut (dyn RowBlocks<f64> + Send),
        used: &[usize],
        factors: &[usize],
        par: Par,
    ) -> Result<Self> {
        let n = rows.ncols();
        check_columns(used.iter().chain(factors).copied(), n)?;
        let entries = vec![Vec::new(); factors.len()];
        let mut found = Self { missing: Vec::new(), entries, bounds: RowBounds::none(n)? };
        let height = block_rows::<f64>(n, false);
        for_each_block(rows, 0, height, par, |first, block| {
            let before = found.missing.len();
            for (i, row) in block.chunks_exact(n.max(1)).enumerate() {
                if used.iter().any(|&j| row[j].is_nan()) {
                    push(&mut found.missing, first + i)?;
                    continue;
                }
                if let Some(&j) = used.iter().find(|&&j| row[j].is_infinite()) {
                    return Err(Error::NonFinite { what: "table", index: (first + i, j) });
                }
                for (entries, &j) in found.entries.iter_mut().zip(factors) {
                    let entry = row[j];
                    // Codes are their own places, once all are there.
                    if entries.get(entry as usize) == Some(&entry) {
                        continue;
                    }
                    let place = entries.binary_search_by(|own: &f64| own.total_cmp(&entry));
                    let Err(place) = place else { continue };
                    if entries.len() == Self::MOST_LEVELS {
                        let why = format!(
                            "column {j} has more than {} different entries",
                            Self::MOST_LEVELS
                        );
                        return Err(Error::Argument { what: "factor", why });
                    }
                    entries.insert(place, entry);
                }
            }
            let Self { missing, bounds, .. } = &mut found;
            let missing = &missing[before..];
            if n > 0 && missing.is_empty() {
                bounds.widen(block, n, par)?;
                return Ok(());
            }
            for (i, row) in block.chunks_exact(n.max(1)).enumerate() {
                if missing.binary_search(&(first + i)).is_err() {
                    bounds.include(row);
                }
            }
            Ok(())
        })?;
        found.bounds.rows = (rows.nrows() - found.missing.len()) as u64;
        Ok(found)
    }

    /// Most levels of a factor: A^T A of more columns is seldom meant.
    pub const MOST_LEVELS: usize = 10_000;
}

/// A column of a table, or the columns that it becomes.
#[derive(Debug, Clone, PartialEq)]
#[non_exhaustive]
pub enum DesignColumn {
    /// The numbers of this column of the table.
    Numbers(usize),
    /// The indicators of the levels, but the base, of the factor in this column of the table.
    Indicators(usize, Factor),
}

impl DesignColumn {
    /// Returns the number of columns of the matrix.
    fn width(&self) -> usize {
        match self {
            Self::Numbers(_) => 1,
            Self::Indicators(_, factor) => factor.levels().len() - 1,
        }
    }

    /// Returns whether a code stands for the columns in coded rows.
    fn is_coded(&self) -> bool {
        /// Threads share the rows of levels: fewer of them would keep few threads busy.
        const LEAST: usize = 32;
        matches!(self, Self::Indicators(..)) && self.width() >= LEAST
    }
}

/// How the rows of a table become those of a matrix.
///
/// ```
/// use catamaran::rows::{DenseRows, Design, DesignColumn, Factor, RowBlocks};
/// use catamaran::faer::{Mat, mat};
///
/// // Columns x and region, of which code 1 is West; one row is incomplete.
/// let table = mat![[0.5, 1.0], [f64::NAN, 0.0], [1.5, 0.0]];
/// let region = Factor::of_codes("region", vec!["East".into(), "West".into()])?;
/// let columns = vec![DesignColumn::Numbers(0), DesignColumn::Indicators(1, region)];
/// let design = Design::new(columns).without_rows(vec![1]);
/// let mut table = DenseRows(table.as_ref());
/// let mut rows = design.rows(&mut table)?;
/// let mut matrix = Mat::zeros(rows.nrows(), rows.ncols());
/// rows.read(0, matrix.as_mut())?;
/// assert_eq!(matrix, mat![[0.5, 1.0], [1.5, 0.0]]);
/// # Ok::<(), catamaran::Error>(())
/// ```
#[derive(Debug, Clone, PartialEq)]
pub struct Design {
    columns: Vec<DesignColumn>,
    /// Rows of the table that are left out, ascending.
    left_out: Vec<usize>,
    /// For each of them the number of rows before it that are not.
    kept_before: Vec<usize>,
}

impl Design {
    /// Creates a design of all rows with these columns.
    pub fn new(columns: Vec<DesignColumn>) -> Self {
        Self { columns, left_out: Vec::new(), kept_before: Vec::new() }
    }

    /// Leaves these rows of the table out, such as [`Survey::missing`].
    pub fn without_rows(mut self, mut rows: Vec<usize>) -> Self {
        rows.sort_unstable();
        rows.dedup();
        self.kept_before = rows.iter().enumerate().map(|(i, row)| row - i).collect();
        self.left_out = rows;
        self
    }

    /// Returns the rows of the table that are left out, ascending.
    pub fn left_out(&self) -> &[usize] {
        &self.left_out
    }

    /// Returns the columns.
    pub fn columns(&self) -> &[DesignColumn] {
        &self.columns
    }

    /// Returns the number of columns of the matrix.
    pub fn ncols(&self) -> usize {
        self.columns.iter().map(DesignColumn::width).sum()
    }

    /// Returns how the rows are coded, if there is a factor of many levels.
    pub fn coding(&self) -> Option<Coding> {
        let (mut numbers, mut factors, mut first) = (Vec::new(), Vec::new(), 0);
        for column in &self.columns {
            let columns = first..first + column.width();
            first = columns.end;
            match column.is_coded() {
                true => factors.push(columns),
                false => numbers.extend(columns),
            }
        }
        (!factors.is_empty()).then(|| Coding::new(numbers, factors))
    }

    /// Returns the bounds of the rows of the matrix for those of the rows of the table that are not
    /// left out, such as [`Survey::bounds`]: they are those that [`RowBounds::of`] finds, if there
    /// is a row of each level.
    ///
    /// # Errors
    /// [`Error::Argument`] when the table does not have the columns, [`Error::OutOfMemory`].
    pub fn bounds(&self, table: &RowBounds<f64>) -> Result<RowBounds<f64>> {
        self.check_table(table.ncols())?;
        table.arranged(self.columns.iter().flat_map(|column| {
            let source = match column {
                DesignColumn::Numbers(j) => Some(*j),
                DesignColumn::Indicators(..) => None,
            };
            std::iter::repeat_n(source, column.width())
        }))
    }

    /// Checks that a table of n columns has those of the design.
    fn check_table(&self, n: usize) -> Result<()> {
        let column = |column: &DesignColumn| match *column {
            DesignColumn::Numbers(j) | DesignColumn::Indicators(j, _) => j,
        };
        check_columns(self.columns.iter().map(column), n)
    }

    /// Returns the numbers, one for each row of the table, that belong to rows of the matrix.
    ///
    /// ```
    /// use catamaran::rows::Design;
    ///
    /// let design = Design::new(Vec::new()).without_rows(vec![0, 2]);
    /// assert_eq!(design.kept(&[1.0, 2.0, 3.0, 4.0])?, [2.0, 4.0]);
    /// # Ok::<(), catamaran::Error>(())
    /// ```
    ///
    /// # Errors
    /// [`Error::OutOfMemory`].
    pub fn kept(&self, numbers: &[f64]) -> Result<Vec<f64>> {
        let mut kept = zeros(numbers.len().saturating_sub(self.left_out.len()))?;
        let is_kept = |&(row, _): &(usize, &f64)| self.left_out.binary_search(&row).is_err();
        let values = numbers.iter().enumerate().filter(is_kept).map(|(_, &number)| number);
        kept.iter_mut().zip(values).for_each(|(to, from)| *to = from);
        Ok(kept)
    }

    /// Returns the rows of the matrix, read from those of the table. A missing entry of a factor,
    /// NaN, makes all its indicators NaN.
    ///
    /// # Errors
    /// [`Error::Argument`] when the table does not have the columns or the rows of the design.
    pub fn rows<'r>(
        &'r self,
        table: &'r mut (dyn RowBlocks<f64> + Send),
    ) -> Result<DesignRows<'r>> {
        self.check_table(table.ncols())?;
        let m = table.nrows();
        if let Some(row) = self.left_out.last().filter(|&&row| row >= m) {
            let why = format!("row {row} is left out, but the table has {m} rows");
            return Err(Error::Argument { what: "design", why });
        }
        Ok(DesignRows { design: self, table, block: Vec::new() })
    }

    /// Returns the row of the table that is row `kept` of the matrix.
    ///
    /// ```
    /// use catamaran::rows::Design;
    ///
    /// let design = Design::new(Vec::new()).without_rows(vec![0, 2]);
    /// assert_eq!([design.row_of_table(0), design.row_of_table(1)], [1, 3]);
    /// ```
    pub fn row_of_table(&self, kept: usize) -> usize {
        self.run(kept).0
    }

    /// Returns the row of the table that is row `kept` of the matrix, and how many rows from there
    /// on follow one another in both.
    fn run(&self, kept: usize) -> (usize, usize) {
        let before = self.kept_before.partition_point(|&count| count <= kept);
        let next = self.kept_before.get(before).map_or(usize::MAX, |count| count - kept);
        (kept + before, next)
    }
}

/// The rows of a [`Design`].
pub struct DesignRows<'r> {
    design: &'r Design,
    table: &'r mut (dyn RowBlocks<f64> + Send),
    /// Rows of the table.
    block: Vec<f64>,
}

impl RowBlocks<f64> for DesignRows<'_> {
    fn nrows(&self) -> usize {
        self.table.nrows() - self.design.left_out.len()
    }

    fn ncols(&self) -> usize {
        self.design.ncols()
    }

    fn read(&mut self, first: usize, out: MatMut<'_, f64>) -> Result<()> {
        self.read_as(first, out, None)
    }

    fn coding(&self) -> Option<Coding> {
        self.design.coding()
    }

    fn read_coded(&mut self, first: usize, out: MatMut<'_, f64>) -> Result<()> {
        let coding = self.design.coding();
        self.read_as(first, out, coding.as_ref().map(|coding| coding.numbers.len()))
    }
}

impl DesignRows<'_> {
    /// Reads rows; as codes from this column on, if there is one.
    fn read_as(
        &mut self,
        first: usize,
        mut out: MatMut<'_, f64>,
        codes: Option<usize>,
    ) -> Result<()> {
        /// Numbers of the table that are read at a time.
        const NUMBERS: usize = 1 << 16;
        let n = self.table.ncols();
        let most = (NUMBERS / n.max(1)).max(1).min(out.nrows());
        if self.block.len() < most * n {
            self.block = zeros(most * n)?;
        }
        let mut done = 0;
        while done < out.nrows() {
            let (row, run) = self.design.run(first + done);
            let count = run.min(most).min(out.nrows() - done);
            let block = &mut self.block[..count * n];
            self.table.read(row, MatMut::from_row_major_slice_mut(block, count, n))?;
            for i in 0..count {
                let entries = &self.block[i * n..(i + 1) * n];
                let coded = self.design.code(entries, codes, |k, x| out[(done + i, k)] = x);
                coded.map_err(|e| in_row(e, row + i))?;
            }
            done += count;
        }
        Ok(())
    }
}

/// Returns the error of an entry with its row in the table.
fn in_row(error: Error, row: usize) -> Error {
    match error {
        Error::Argument { what, why } => {
            Error::Argument { what, why: format!("{why}, in row {row} (counted from 0)") }
        }
        error => error,
    }
}

impl Design {
    /// Calls `set` with the number of each column of the matrix and its entry for a row of the
    /// table; with those of the coded row, if the column of the first code is given.
    fn code(
        &self,
        row: &[f64],
        mut codes: Option<usize>,
        mut set: impl FnMut(usize, f64),
    ) -> Result<()> {
        let mut first = 0;
        for column in &self.columns {
            match column {
                DesignColumn::Numbers(j) => {
                    set(first, row[*j]);
                    first += 1;
                }
                DesignColumn::Indicators(j, factor) => {
                    let (entry, count) = (row[*j], column.width());
                    let level = match entry.is_nan() {
                        true => None,
                        false => Some(factor.level_of(entry).ok_or_else(|| factor.unknown(entry))?),
                    };
                    if let Some(code) = codes.as_mut().filter(|_| column.is_coded()) {
                        set(*code, level.map_or(f64::NAN, |level| level as f64));
                        *code += 1;
                        continue;
                    }
                    let rest = if level.is_none() { f64::NAN } else { 0.0 };
                    (first..first + count).for_each(|k| set(k, rest));
                    if let Some(level) = level.filter(|&level| level > 0) {
                        set(first + level - 1, 1.0);
                    }
                    first += count;
                }
            }
        }
        Ok(())
    }
}

/// Checks that columns are those of a table of n columns.
fn check_columns(mut columns: impl Iterator<Item = usize>, n: usize) -> Result<()> {
    match columns.find(|&column| column >= n) {
        Some(column) => {
            let why = format!("column {column} of a table of {n} columns");
            Err(Error::Argument { what: "design", why })
        }
        None => Ok(()),
    }
}

#[cfg(test)]
mod tests {
    use faer::{Mat, mat};

    use super::*;
    use crate::product::AtaOptions;
    use crate::rows::DenseRows;

    fn read(design: &Design, table: &Mat<f64>, height: usize) -> Result<Mat<f64>> {
        let mut table = DenseRows(table.as_ref());
        let mut rows = design.rows(&mut table)?;
        let mut matrix = Mat::zeros(rows.nrows(), rows.ncols());
        for first in (0..matrix.nrows()).step_by(height) {
            let count = height.min(matrix.nrows() - first);
            rows.read(first, matrix.as_mut().subrows_mut(first, count))?;
        }
        Ok(matrix)
    }

    #[test]
    fn rows_that_are_left_out_do_not_shift_the_others() {
        let table = Mat::from_fn(23, 2, |i, j| (10 * i + j) as f64);
        for left_out in [vec![], vec![0], vec![22], vec![0, 1, 2, 7, 9, 10, 21, 22], vec![5, 3]] {
            let columns = vec![DesignColumn::Numbers(1), DesignColumn::Numbers(0)];
            let design = Design::new(columns).without_rows(left_out.clone());
            let kept: Vec<usize> = (0..23).filter(|row| !left_out.contains(row)).collect();
            let right = Mat::from_fn(kept.len(), 2, |i, j| (10 * kept[i] + 1 - j) as f64);
            for height in [1, 4, 23] {
                assert_eq!(read(&design, &table, height).unwrap(), right, "{left_out:?}");
            }
            let rows: Vec<f64> = (0..23).map(f64::from).collect();
            let weights = design.kept(&rows).unwrap();
            assert!(weights.iter().zip(&kept).all(|(&w, &row)| w == row as f64));
        }
    }

    #[test]
    fn a_factor_has_a_column_for_each_level_but_its_base() {
        let levels = ["b", "c", "a"].map(str::to_owned).to_vec();
        let factor = Factor::of_codes("f", levels).unwrap();
        assert_eq!(factor.columns(), ["f[b]", "f[c]"]);
        let table = mat![[0.0], [1.0], [2.0], [f64::NAN], [0.0]];
        let design = |factor| Design::new(vec![DesignColumn::Indicators(0, factor)]);
        let matrix = read(&design(factor.clone()).without_rows(vec![3]), &table, 2).unwrap();
        assert_eq!(matrix, mat![[1.0, 0.0], [0.0, 1.0], [0.0, 0.0], [1.0, 0.0]]);
        let matrix = read(&design(factor.clone()), &table, 9).unwrap();
        assert!(matrix[(3, 0)].is_nan() && matrix[(3, 1)].is_nan());
        let other = factor.clone().with_base("c").unwrap();
        assert_eq!(other.levels(), ["c", "a", "b"]);
        let matrix = read(&design(other).without_rows(vec![3]), &table, 9).unwrap();
        assert_eq!(matrix, mat![[0.0, 1.0], [0.0, 0.0], [1.0, 0.0], [0.0, 1.0]]);
        // Codes of another table.
        let moved = factor.for_codes(&["a".into(), "b".into()]).unwrap();
        let matrix = read(&design(moved), &mat![[0.0], [1.0]], 9).unwrap();
        assert_eq!(matrix, mat![[0.0, 0.0], [1.0, 0.0]]);
        let refused = read(&design(factor), &mat![[3.0]], 9).unwrap_err();
        let expected = "factor: f has no level 3, but a, b, c, in row 0 (counted from 0)";
        assert_eq!(refused.to_string(), expected);
    }

    #[test]
    fn levels_are_sorted_as_numbers_or_as_words() {
        let sorted = |levels: &[&str]| {
            let levels = levels.iter().map(|&level| level.to_owned()).collect();
            Factor::of_codes("f", levels).map(|factor| factor.levels().join(" "))
        };
        assert_eq!(sorted(&["10", "9", "-1"]), Ok("-1 9 10".into()));
        assert_eq!(sorted(&["10", "9", "x"]), Ok("10 9 x".into()));
        let refused = |levels: &[&str]| sorted(levels).unwrap_err().to_string();
        assert_eq!(refused(&["a", "b", "a"]), "factor: f has level a twice");
        assert_eq!(refused(&["a"]), "factor: f has one level, a: at least two are needed");
        assert_eq!(refused(&[]), "factor: f has no level: at least two are needed");
        let numbers = Factor::of_numbers("g", vec![0.0, 2.5, -0.0, 2.5]).unwrap();
        assert_eq!(numbers.levels(), ["0", "2.5"]);
        assert_eq!(numbers.level_of(-0.0), Some(0));
    }

    #[test]
    fn levels_that_are_the_same_number_are_refused_unless_a_level_is_a_word() {
        let levels = |levels: &[&str]| levels.iter().map(|&level| level.to_owned()).collect();
        let same = "factor: f has the levels 1 and 1.0, which are the same number";
        for equal in [&["1", "1.0", "2"][..], &["2", "1", "-3", "1.0"]] {
            let refused = Factor::of_codes("f", levels(equal)).unwrap_err();
            assert_eq!(refused.to_string(), same);
            assert!(Factor::in_order("f", levels(equal)).is_err());
        }
        let words = Factor::of_codes("f", levels(&["1", "1.0", "x"])).unwrap();
        assert_eq!(words.columns(), ["f[1.0]", "f[x]"]);
        // Without the word.
        assert_eq!(words.with_entries(&[0.0, 1.0]).unwrap_err().to_string(), same);
    }

    #[test]
    fn words_of_another_table_are_the_levels_that_are_the_same_numbers() {
        let fitted = Factor::of_numbers("f", vec![1.0, 2.5]).unwrap();
        let moved = fitted.for_codes(&["2.50".into(), "1.0".into()]).unwrap();
        assert_eq!([0.0, 1.0].map(|code| moved.level_of(code)), [Some(1), Some(0)]);
        let refused = fitted.for_codes(&["1.0".into(), "x".into()]).unwrap_err();
        assert_eq!(refused.to_string(), "factor: f has no level x, but 1, 2.5");
        // Levels are words where one of them is a word.
        let words = Factor::of_codes("f", vec!["1".into(), "x".into()]).unwrap();
        assert!(words.for_codes(&["1.0".into()]).is_err());
        assert!(words.with_base("1.0").is_err());
    }

    #[test]
    fn a_base_is_a_level_also_where_its_number_is_written_in_another_way() {
        let factor = Factor::of_numbers("f", vec![1.0, 2.0, 3.5]).unwrap();
        let moved = factor.clone().with_base("2.0").unwrap();
        assert_eq!(moved.levels(), ["2", "1", "3.5"]);
        assert_eq!([1.0, 2.0].map(|entry| moved.level_of(entry)), [Some(1), Some(0)]);
        let refused = factor.with_base("2.5").unwrap_err();
        assert_eq!(refused.to_string(), "factor: f has no level 2.5, but 1, 2, 3.5");
    }

    #[test]
    fn numbers_of_another_table_are_levels_also_where_others_are_words() {
        let levels = |levels: &[&str]| levels.iter().map(|&level| level.to_owned()).collect();
        let factor = Factor::of_codes("f", levels(&["b", "7", "a", "-2"])).unwrap();
        assert_eq!(factor.levels(), ["-2", "7", "a", "b"]);
        let design = Design::new(vec![DesignColumn::Indicators(0, factor.for_numbers().unwrap())]);
        let matrix = read(&design, &mat![[7.0], [-2.0]], 9).unwrap();
        assert_eq!(matrix, mat![[1.0, 0.0, 0.0], [0.0, 0.0, 0.0]]);
        let matrix = read(&design, &mat![[f64::NAN]], 9).unwrap();
        assert!((0..3).all(|j| matrix[(0, j)].is_nan()));
        let refused = read(&design, &mat![[0.0]], 9).unwrap_err();
        let expected = "factor: f has no level 0, but -2, 7, a, b, in row 0 (counted from 0)";
        assert_eq!(refused.to_string(), expected);
        // Which one of them is 1?
        let refused = Factor::of_codes("f", levels(&["1", "1.0", "x"])).unwrap().for_numbers();
        let same = "factor: f has the levels 1 and 1.0, which are the same number";
        assert_eq!(refused.unwrap_err().to_string(), same);
    }

    #[test]
    fn a_survey_finds_incomplete_rows_and_levels_of_complete_ones() {
        let mut table = Mat::from_fn(500, 3, |i, j| ((i * (j + 1)) % 7) as f64);
        table[(3, 0)] = f64::NAN;
        table[(499, 1)] = f64::NAN;
        table[(7, 2)] = f64::NAN;
        for par in [Par::Seq, Par::Threads(2)] {
            let mut rows = DenseRows(table.as_ref());
            let found = Survey::of(&mut rows, &[0, 1], &[1], par).unwrap();
            assert_eq!(found.missing, [3, 499]);
            assert_eq!(found.entries, [(0..7).map(f64::from).collect::<Vec<_>>()]);
            let kept = Mat::from_fn(498, 3, |i, j| table[(i + usize::from(i > 2), j)]);
            let (mut kept, options) = (DenseRows(kept.as_ref()), AtaOptions::new());
            let bounds = RowBounds::<f64>::of(&mut kept, None, 64, &options).unwrap();
            assert_eq!(found.bounds, bounds);
        }
        table[(8, 1)] = f64::INFINITY;
        let refused = Survey::of(&mut DenseRows(table.as_ref()), &[1], &[], Par::Seq).unwrap_err();
        assert_eq!(refused, Error::NonFinite { what: "table", index: (8, 1) });
        let refused = Survey::of(&mut DenseRows(table.as_ref()), &[3], &[], Par::Seq).unwrap_err();
        assert_eq!(refused.to_string(), "design: column 3 of a table of 3 columns");
    }
}
