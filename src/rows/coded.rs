//! Sums of rows of which many columns are the indicators of factors, read as codes: the products of
//! numbers as a matrix product, all others by adding at the place of a row's level, one level of a
//! factor after another.

use std::ops::Range;

use super::blocks::CodedRows;
use super::coding::Coding;
use super::exact::{ExactSums, first_beyond, halves, is_rounded, joined};
use super::pass::{Pass, for_each_block_of};
use super::source::RowBlocks;
use crate::base::{Error, Real, Result, repeated, reserved, triangle_len, triangle_rows, widest};
use crate::blas::BlasReal;
use crate::kernel::int8::{I256, Integer, WIDE_BITS};
use crate::product::AtaOptions;

/// Calls [`for_each_block_of`] with rows, or with their coded form.
pub(super) fn for_each_block_as<'o, T: BlasReal>(
    coding: Option<&Coding>,
    rows: &mut (dyn RowBlocks<T> + Send),
    weights: Option<&[T]>,
    height: usize,
    start: usize,
    options: &AtaOptions<'o>,
    work: impl FnMut(usize, &mut [T], Option<&[T]>, &mut Pass<'o>) -> Result<()>,
) -> Result<()> {
    match coding {
        Some(coding) => {
            let mut rows = CodedRows::new(rows, coding);
            for_each_block_of(&mut rows, weights, height, start, options, work)
        }
        None => for_each_block_of(rows, weights, height, start, options, work),
    }
}

/// The place of a base, which has no column.
const BASE: usize = usize::MAX;

/// Groups of columns for each thread: levels have any number of rows.
const GROUPS: usize = 4;

/// The levels of a factor in the rows of a block.
struct Levels {
    /// The columns of the factor.
    columns: Range<usize>,
    /// The column of the level of each row, or [`BASE`].
    places: Vec<usize>,
    /// The rows that have a column, by level.
    rows: Vec<usize>,
    /// Where the rows of each level end.
    ends: Vec<usize>,
}

impl Levels {
    /// Sorts the rows of these places by level.
    fn new(columns: Range<usize>, places: Vec<usize>) -> Result<Self> {
        let levels = || places.iter().enumerate().filter(|&(_, &place)| place != BASE);
        // The beginning of each level, which sorting moves to its end.
        let mut ends = repeated(0_usize, columns.len())?;
        levels().for_each(|(_, &place)| ends[place - columns.start] += 1);
        let mut count = 0_usize;
        for end in &mut ends {
            (*end, count) = (count, count + *end);
        }
        let mut rows = repeated(0_usize, count)?;
        for (i, &place) in levels() {
            let end = &mut ends[place - columns.start];
            rows[*end] = i;
            *end += 1;
        }
        Ok(Self { columns, places, rows, ends })
    }

    /// Returns the rows of the level with column j, in their order.
    fn rows(&self, j: usize) -> &[usize] {
        let level = j - self.columns.start;
        let start = if level == 0 { 0 } else { self.ends[level - 1] };
        &self.rows[start..self.ends[level]]
    }
}

impl<T: BlasReal> ExactSums<T, I256> {
    /// Adds a block of `count` coded rows, or subtracts it: the sums become what
    /// [`ExactSums::add`] makes of the whole rows. The entries are overwritten.
    pub fn add_coded(
        &mut self,
        coding: &Coding,
        count: usize,
        block: &mut [T],
        weights: Option<&[T]>,
        subtract: bool,
        pass: &mut Pass<'_>,
    ) -> Result<()> {
        let (n, width) = (coding.numbers.len(), coding.width());
        self.check(count, weights, subtract)?;
        if let Some(at) = block.iter().position(|x| !x.is_finite()) {
            let index = (pass.first + at / width, coding.column(at % width));
            return Err(Error::NonFinite { what: "rows", index });
        }
        let par = pass.options.par;
        let levels = pass.options.on_cores(|| {
            let of_factor = |f: Range<usize>| self.levels(coding, f.start, block);
            par.map_blocks(coding.factors.len(), 1, of_factor)
        });
        let levels = levels.into_iter().collect::<Result<Vec<_>>>()?;
        for i in 0..count {
            block.copy_within(i * width..i * width + n, i * n);
        }
        let block = &mut block[..count * n];
        let mut own = Self::on(self.grid.of_columns(&coding.numbers), 0..n, self.centered)?;
        // Looks for rounded entries until there is one.
        own.rounded = self.rounded;
        own.add(count, block, weights, false, pass).map_err(|error| {
            let beyond = (n > 0).then(|| first_beyond(block, &own.grid.lower, &own.grid.upper));
            beyond.flatten().map_or(error, |(j, x)| self.beyond(coding.numbers[j], x))
        })?;

        let factors = [false, true].map(|side| self.grid.factors(side));
        let ones =
            |side: &Vec<[f64; 2]>| side.iter().map(|&factors| integer(T::ONE, factors)).collect();
        let ones = [ones(&factors[0]), ones(&factors[1])];
        let products = Products { coding, block, levels, weights, factors, ones, subtract };
        let (options, ..) = pass.parts();
        let mut rest = &mut self.entries[..];
        let parts = GROUPS * options.par.threads();
        let groups = coding.groups(parts).into_iter().map(|columns| {
            let len = triangle_len(columns.end) - triangle_len(columns.start);
            let (entries, others) = std::mem::take(&mut rest).split_at_mut(len);
            rest = others;
            (columns, entries)
        });
        let groups: Vec<_> = groups.collect();
        options.on_cores(|| {
            options.par.for_each(groups.into_iter(), |_, (columns, entries)| {
                widest(
                    #[inline(always)]
                    || products.add(&columns, entries),
                );
            });
        });
        for (i, row) in triangle_rows(&mut own.entries, 0..n) {
            let first = triangle_len(coding.numbers[i]);
            for (&entry, &j) in row.iter().zip(&coding.numbers) {
                products.add_to(&mut self.entries[first + j], entry);
            }
        }
        let sign = if subtract { -1 } else { 1 };
        if self.centered {
            for (&sum, &j) in own.sums.iter().zip(&coding.numbers) {
                self.sums[j] = self.sums[j].wrapping_add(sign * sum);
            }
            products.for_each_level(|rows, j| {
                self.sums[j] = self.sums[j].wrapping_add(sign * products.sum_of_ones(rows, j));
            });
        }
        self.rounded |= own.rounded;
        if !self.rounded {
            products.for_each_level(|rows, j| self.rounded |= products.is_rounded(rows, j));
        }
        for (weight, own) in self.weights.iter_mut().zip(own.weights) {
            *weight = weight.wrapping_add(sign * own);
        }
        (self.rows, self.weightless) = match subtract {
            true => (self.rows - own.rows, self.weightless - own.weightless),
            false => (self.rows + own.rows, self.weightless + own.weightless),
        };
        Ok(())
    }

    /// Returns the levels of factor `f` in coded rows.
    fn levels(&self, coding: &Coding, f: usize, block: &[T]) -> Result<Levels> {
        let (n, width, columns) = (coding.numbers.len(), coding.width(), &coding.factors[f]);
        let mut places = reserved(block.len() / width)?;
        for row in block.chunks_exact(width) {
            let code = row[n + f].to_f64() as usize;
            if code > columns.len() {
                let why = format!("code {code} of a factor of {} columns", columns.len());
                return Err(Error::Argument { what: "rows", why });
            }
            let place = if code == 0 { BASE } else { columns.start + code - 1 };
            if code > 0 && self.grid.upper[place] < T::ONE {
                return Err(self.beyond(place, 1.0));
            }
            places.push(place);
        }
        Levels::new(columns.clone(), places)
    }
}

/// Rows whose integers, of a little more than [`WIDE_BITS`] bits, have sums of 128 bits.
const RUN: usize = 1 << 24;

/// The products of a block that a factor is part of.
struct Products<'b, T> {
    coding: &'b Coding,
    /// The numbers of the rows, row after row.
    block: &'b [T],
    /// For each factor.
    levels: Vec<Levels>,
    weights: Option<&'b [T]>,
    /// What entries are multiplied by on the left and the right side, as in a grid.
    factors: [Vec<[f64; 2]>; 2],
    /// What 1 becomes in each column on the left and the right side: a power of two, or zero.
    ones: [Vec<i128>; 2],
    subtract: bool,
}

impl<T: BlasReal> Products<'_, T> {
    /// Adds to rows of the triangle, those of some numbers or of some levels of a factor.
    #[inline(always)]
    fn add(&self, columns: &Range<usize>, entries: &mut [I256]) {
        let of = |factor: &Range<usize>| factor.contains(&columns.start);
        match self.coding.factors.iter().position(of) {
            Some(factor) => self.add_levels(factor, columns, entries),
            None => self.add_numbers(columns, entries),
        }
    }

    /// Adds products of levels with the numbers and levels of columns before them: the rows of a
    /// level have one row of the triangle.
    #[inline(always)]
    fn add_levels(&self, factor: usize, columns: &Range<usize>, entries: &mut [I256]) {
        const { assert!(WIDE_BITS + 1 + (RUN.ilog2() as i32) < 127) };
        let (n, first) = (self.coding.numbers.len(), triangle_len(columns.start));
        let before = self.coding.numbers.partition_point(|&j| j < columns.start);
        let numbers = &self.coding.numbers[..before];
        let mut sums = vec![0_i128; before];
        for k in columns.clone() {
            let row = &mut entries[triangle_len(k) - first..][..=k];
            let unit = self.ones[0][k];
            for rows in self.levels[factor].rows(k).chunks(RUN) {
                sums.fill(0);
                for &i in rows {
                    let terms = self.block[i * n..].iter().zip(numbers);
                    for (sum, (&x, &j)) in sums.iter_mut().zip(terms) {
                        *sum += self.right(i, x, j);
                    }
                }
                for (&sum, &j) in sums.iter().zip(numbers) {
                    self.add_to(&mut row[j], times(unit, sum));
                }
                for Levels { places, .. } in &self.levels[..factor] {
                    for &i in rows {
                        if let Some(entry) = row.get_mut(places[i]) {
                            self.add_to(entry, times(unit, self.one(i, places[i])));
                        }
                    }
                }
                self.add_to(&mut row[k], times(unit, self.sum_of_ones(rows, k)));
            }
        }
    }

    /// Adds products of numbers with levels of columns before them.
    #[inline(always)]
    fn add_numbers(&self, columns: &Range<usize>, entries: &mut [I256]) {
        let (n, first) = (self.coding.numbers.len(), triangle_len(columns.start));
        let skipped = self.coding.numbers.partition_point(|&j| j < columns.start);
        let count = self.coding.factors.partition_point(|factor| factor.start < columns.start);
        let levels = &self.levels[..count];
        if levels.is_empty() {
            return;
        }
        for (i, row) in self.block.chunks_exact(n).enumerate() {
            for (&x, j) in row[skipped..].iter().zip(columns.clone()) {
                let left = integer(x, self.factors[0][j]);
                let row = &mut entries[triangle_len(j) - first..][..=j];
                for Levels { places, .. } in levels {
                    let Some(entry) = row.get_mut(places[i]) else { continue };
                    let right = self.one(i, places[i]);
                    let product = match self.weights {
                        None => times(right, left),
                        // Both have fewer bits than half of the sum.
                        Some(_) => I256::product(left, right).unwrap_or_default(),
                    };
                    self.add_to(entry, product);
                }
            }
        }
    }

    /// Calls `work` with the rows of each level and its column.
    fn for_each_level(&self, mut work: impl FnMut(&[usize], usize)) {
        for levels in &self.levels {
            levels.columns.clone().for_each(|j| work(levels.rows(j), j));
        }
    }

    /// Returns the integer that an indicator of row i becomes in column j on the right side.
    #[inline(always)]
    fn one(&self, i: usize, j: usize) -> i128 {
        match self.weights {
            None => self.ones[1][j],
            Some(_) => self.right(i, T::ONE, j),
        }
    }

    /// Returns the sum of the integers of [`Products::one`] for some rows.
    #[inline(always)]
    fn sum_of_ones(&self, rows: &[usize], j: usize) -> i128 {
        match self.weights {
            None => self.ones[1][j].wrapping_mul(rows.len() as i128),
            Some(_) => rows.iter().fold(0, |sum: i128, &i| sum.wrapping_add(self.one(i, j))),
        }
    }

    /// Returns the integer that the entry x of row i becomes in column j on the right side.
    #[inline(always)]
    fn right(&self, i: usize, x: T, j: usize) -> i128 {
        let factors = self.factors[1][j];
        let Some(weights) = self.weights else { return integer(x, factors) };
        let product = weights[i] * x;
        let rest = weights[i].to_f64().mul_add(x.to_f64(), -product.to_f64());
        integer(product, factors) + integer(T::from_f64(rest), factors)
    }

    /// Returns whether an indicator of these rows in column j is not on the grid.
    fn is_rounded(&self, rows: &[usize], j: usize) -> bool {
        let [left, right] = [0, 1].map(|side| &self.factors[side][j..=j]);
        let of_weights = || match self.weights {
            None => is_rounded(&[T::ONE], right),
            Some(weights) => rows.iter().any(|&i| is_rounded(&weights[i..=i], right)),
        };
        !rows.is_empty() && (is_rounded(&[T::ONE], left) || of_weights())
    }

    /// Adds a term to a sum, or subtracts it.
    #[inline(always)]
    fn add_to(&self, sum: &mut I256, term: I256) {
        *sum = sum.plus(if self.subtract { term.negated() } else { term });
    }
}

/// Returns the integer that an entry becomes.
#[inline(always)]
fn integer<T: Real>(x: T, [first, second]: [f64; 2]) -> i128 {
    joined(halves(x.to_f64() * first * second))
}

/// Returns `unit value`, for a unit that is a power of two or zero.
#[inline(always)]
fn times(unit: i128, value: i128) -> I256 {
    match unit {
        0 => I256::default(),
        _ => I256::of_shifted(value, unit.trailing_zeros()),
    }
}

#[cfg(test)]
mod tests {
    use faer::{Mat, MatMut};

    use super::*;
    use crate::base::{Par, Rng};
    use crate::rows::{
        Accumulator, Center, DenseRows, Design, DesignColumn, DesignRows, ExtendedGram, Factor,
        RowBounds, RowOptions, ata_extended, stream,
    };

    /// Rows that can be read as codes only.
    struct CodesOnly<'r>(DesignRows<'r>);

    impl RowBlocks<f64> for CodesOnly<'_> {
        fn nrows(&self) -> usize {
            self.0.nrows()
        }

        fn ncols(&self) -> usize {
            self.0.ncols()
        }

        fn read(&mut self, _: usize, _: MatMut<'_, f64>) -> Result<()> {
            panic!("whole rows are read")
        }

        fn coding(&self) -> Option<Coding> {
            self.0.coding()
        }

        fn read_coded(&mut self, first: usize, out: MatMut<'_, f64>) -> Result<()> {
            self.0.read_coded(first, out)
        }
    }

    const ROWS: usize = 700;

    /// Returns rows of numbers, and in columns 1, 3 and 4 of codes of 50, 40 and 3 levels.
    fn table() -> Mat<f64> {
        let mut rng = Rng::new(5);
        Mat::from_fn(ROWS, 6, |i, j| match j {
            1 => (i * 7 % 50) as f64,
            3 => (i / 3 % 40) as f64,
            4 => (i % 3) as f64,
            _ => rng.uniform() - 0.3,
        })
    }

    fn design() -> Design {
        let factor = |j: usize, count: usize| {
            let levels = (0..count).map(|k| k.to_string()).collect();
            DesignColumn::Indicators(j, Factor::in_order(format!("f{j}"), levels).unwrap())
        };
        let column = |j: usize| match j {
            1 => factor(j, 50),
            3 => factor(j, 40),
            4 => factor(j, 3),
            _ => DesignColumn::Numbers(j),
        };
        Design::new((0..6).map(column).collect())
    }

    /// Returns the whole rows.
    fn whole(design: &Design, table: &Mat<f64>) -> Mat<f64> {
        let mut table = DenseRows(table.as_ref());
        let mut rows = design.rows(&mut table).unwrap();
        let mut all = Mat::zeros(rows.nrows(), rows.ncols());
        rows.read(0, all.as_mut()).unwrap();
        all
    }

    fn assert_same(found: &ExtendedGram, right: &ExtendedGram) {
        let about = |gram: &ExtendedGram| {
            let counts = (gram.n(), gram.rows(), gram.observations(), gram.is_exact());
            (counts, gram.weight(), gram.mean().to_vec())
        };
        assert_eq!(about(found), about(right));
        for i in 0..found.n() {
            for j in 0..=i {
                let [found, right] = [found, right].map(|g| g.entry(i, j).map(f64::to_bits));
                assert_eq!(found, right, "({i}, {j})");
            }
        }
    }

    #[test]
    fn sums_of_codes_have_the_bits_of_those_of_whole_rows() {
        let (table, design) = (table(), design().without_rows(vec![5, 6, 699]));
        let all = whole(&design, &table);
        let mut rng = Rng::new(6);
        let of_row = |i: usize| if i.is_multiple_of(9) { 0.0 } else { rng.uniform() };
        let plain: Vec<f64> = (0..all.nrows()).map(of_row).collect();
        // Weights of many sizes are rounded, which is known afterwards.
        let sized = plain.iter().enumerate().map(|(i, w)| w * 2f64.powi(-(i as i32 % 90)));
        let sized: Vec<f64> = sized.collect();
        for weights in [None, Some(&plain[..]), Some(&sized[..])] {
            for center in [Center::No, Center::Mean] {
                let row_options = RowOptions::new().weights(weights).center(center);
                let options = AtaOptions::new().par(Par::Seq);
                let rows = &mut DenseRows(all.as_ref());
                let right = ata_extended(rows, &row_options, &options).unwrap();
                for par in [Par::Seq, Par::Threads(3)] {
                    let mut table = DenseRows(table.as_ref());
                    let mut rows = CodesOnly(design.rows(&mut table).unwrap());
                    let options = AtaOptions::new().par(par);
                    let found = ata_extended(&mut rows, &row_options, &options).unwrap();
                    assert_same(&found, &right);
                }
            }
        }
    }

    #[test]
    fn codes_are_removed_and_merged_exactly() {
        let (table, design, options) = (table(), design(), AtaOptions::new());
        let all = whole(&design, &table);
        let bounds =
            RowBounds::<f64>::of(&mut DenseRows(all.as_ref()), None, 64, &options).unwrap();
        let of_table =
            RowBounds::<f64>::of(&mut DenseRows(table.as_ref()), None, 64, &options).unwrap();
        assert_eq!(design.bounds(&of_table).unwrap(), bounds);
        let new = || Accumulator::extended(&bounds, true).unwrap();
        let (mut both, mut first, mut last, mut right) = (new(), new(), new(), new());
        let change = |sum: &mut Accumulator<f64>, start: usize, count: usize, remove: bool| {
            let mut part = DenseRows(table.as_ref().subrows(start, count));
            let mut rows = CodesOnly(design.rows(&mut part).unwrap());
            match remove {
                true => sum.remove_rows(&mut rows, None, &options).unwrap(),
                false => sum.add_rows(&mut rows, None, &options).unwrap(),
            }
        };
        change(&mut both, 0, ROWS, false);
        change(&mut both, 0, 300, true);
        right.add_block(all.as_ref().subrows(300, ROWS - 300), None, &options).unwrap();
        assert_same(
            &both.finish_extended(Par::Seq).unwrap(),
            &right.try_clone().unwrap().finish_extended(Par::Seq).unwrap(),
        );
        change(&mut first, 0, 300, false);
        change(&mut last, 300, ROWS - 300, false);
        first.merge(last).unwrap();
        right.add_block(all.as_ref().subrows(0, 300), None, &options).unwrap();
        assert_same(
            &first.finish_extended(Par::Seq).unwrap(),
            &right.finish_extended(Par::Seq).unwrap(),
        );
    }

    #[test]
    fn levels_of_no_row_and_of_all_rows_have_the_sums_of_whole_rows() {
        let (mut table, design, options) = (table(), design(), AtaOptions::new());
        let weights: Vec<f64> = (0..ROWS).map(|i| (i % 5) as f64 / 3.0).collect();
        // The base, the first column of the factor, and its last one.
        for code in [0.0, 1.0, 49.0] {
            (0..ROWS).for_each(|i| table[(i, 1)] = code);
            let all = whole(&design, &table);
            let bound = |x: f64| vec![x; all.ncols()];
            let bounds = RowBounds::new(bound(-1.0), bound(1.0), 2 * ROWS as u64).unwrap();
            // Without given weights, those of rows are 1.
            let weighted = bounds.clone().with_weights(2.0).unwrap();
            for (bounds, weights) in
                [(&bounds, None), (&weighted, None), (&weighted, Some(&weights[..]))]
            {
                let new = || Accumulator::extended(bounds, true).unwrap();
                let (mut found, mut right) = (new(), new());
                for _ in 0..2 {
                    let mut table = DenseRows(table.as_ref());
                    let mut rows = CodesOnly(design.rows(&mut table).unwrap());
                    found.add_rows(&mut rows, weights, &options).unwrap();
                    right.add_block(all.as_ref(), weights, &options).unwrap();
                }
                assert_same(
                    &found.finish_extended(Par::Seq).unwrap(),
                    &right.finish_extended(Par::Seq).unwrap(),
                );
            }
        }
    }

    #[test]
    fn integers_are_the_nearest_ones() {
        let mut rng = Rng::new(7);
        let largest = 2f64.powi(WIDE_BITS);
        let mut numbers = vec![0.0, -0.0, 0.5, 1.5, 2f64.powi(39), -largest, largest];
        for _ in 0..10_000 {
            let size = (f64::from(WIDE_BITS) * rng.uniform()).exp2();
            numbers.push(rng.normal().clamp(-1.0, 1.0) * size);
            // Ties beyond 2^40.
            numbers.push((rng.normal() * 2f64.powi(45)).round() + 0.5);
            numbers.push((rng.normal() * 2f64.powi(20)).round() * 2f64.powi(39));
        }
        for x in numbers {
            assert_eq!(integer(x, [1.0; 2]), x.round_ties_even() as i128, "{x}");
        }
    }

    #[test]
    fn what_is_not_finite_is_named_by_its_column_of_the_matrix() {
        let (design, options) = (design(), AtaOptions::new());
        // Columns: a number, 49 of factor 1, a number, 39 of factor 3, 2 of factor 4, a number.
        for (column, named) in [(0, 0), (1, 1), (2, 50), (3, 51), (4, 90), (5, 92)] {
            let mut table = table();
            table[(17, column)] = f64::NAN;
            let mut table = DenseRows(table.as_ref());
            let mut rows = CodesOnly(design.rows(&mut table).unwrap());
            let refused = ata_extended(&mut rows, &RowOptions::<f64>::new(), &options);
            let expected = Error::NonFinite { what: "rows", index: (17, named) };
            assert_eq!(refused.unwrap_err(), expected);
        }
    }

    #[test]
    fn what_is_not_finite_is_named_by_its_row_of_the_source() {
        let (mut table, design, options) = (table(), design(), AtaOptions::new());
        let all = whole(&design, &table);
        let bounds =
            RowBounds::<f64>::of(&mut DenseRows(all.as_ref()), None, 64, &options).unwrap();
        table[(17, 2)] = f64::NAN;
        for block_rows in [5, 64] {
            let mut sum = Accumulator::extended(&bounds, false).unwrap();
            let mut part = DenseRows(table.as_ref());
            let mut rows = CodesOnly(design.rows(&mut part).unwrap());
            let refused = stream(&mut rows, None, block_rows, &mut sum, &options, &mut |_| Ok(()));
            let expected = Error::NonFinite { what: "rows", index: (17, 50) };
            assert_eq!(refused.unwrap_err(), expected, "blocks of {block_rows}");
        }
    }

    #[test]
    fn what_is_beyond_its_bounds_is_named_by_its_column_of_the_matrix() {
        let (mut table, design, options) = (table(), design(), AtaOptions::new());
        let all = whole(&design, &table);
        let bounds =
            RowBounds::<f64>::of(&mut DenseRows(all.as_ref()), None, 64, &options).unwrap();
        let mut sum = Accumulator::extended(&bounds, false).unwrap();
        table[(17, 2)] = 5.0;
        let mut part = DenseRows(table.as_ref());
        let mut rows = CodesOnly(design.rows(&mut part).unwrap());
        let refused = sum.add_rows(&mut rows, None, &options).unwrap_err().to_string();
        assert!(refused.starts_with("rows: 5 in column 50 is beyond its bounds"), "{refused}");
        assert_eq!(sum.rows(), 0);
    }
}
