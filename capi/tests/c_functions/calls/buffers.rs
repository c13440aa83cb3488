//! Matrices in memory with guards: whatever a call may not write has the same bits afterwards.

use std::fmt::Debug;

use catamaran_capi::{CATA_COL_MAJOR, CATA_ROW_MAJOR};

use super::choices::Choices;

/// An element of a buffer.
pub trait Element: Copy + Debug {
    /// What is between the lines of matrices and around them: a NaN where there is one, so that
    /// reading it shows.
    const GUARD: Self;

    fn bits(self) -> u64;
}

impl Element for f64 {
    const GUARD: Self = f64::from_bits(0x7ff8_dead_beef_0001);

    fn bits(self) -> u64 {
        self.to_bits()
    }
}

impl Element for f32 {
    const GUARD: Self = f32::from_bits(0x7fc0_beef);

    fn bits(self) -> u64 {
        self.to_bits().into()
    }
}

impl Element for usize {
    const GUARD: Self = 0xdead_beef;

    fn bits(self) -> u64 {
        self as u64
    }
}

impl Element for i32 {
    const GUARD: Self = 0x0bad_beef;

    fn bits(self) -> u64 {
        self as u64
    }
}

/// A rows x cols matrix of elements of `width` numbers (2 for complex ones) with a leading
/// dimension, between guards.
pub struct Matrix<T> {
    pub rows: usize,
    pub cols: usize,
    pub ld: usize,
    width: usize,
    layout: i32,
    guard: usize,
    data: Vec<T>,
    before: Vec<T>,
}

impl<T: Element> Matrix<T> {
    /// Creates a matrix with these entries; the choices are its leading dimension and its guards.
    pub fn new(
        choices: &mut Choices<'_>,
        layout: i32,
        (rows, cols): (usize, usize),
        width: usize,
        mut entry: impl FnMut(usize, usize) -> T,
    ) -> Self {
        let (lines, line) = if layout == CATA_COL_MAJOR { (cols, rows) } else { (rows, cols) };
        let ld = line.max(1) + choices.pick(&[0, 1, 3, 8, 13]);
        let guard = choices.pick(&[0, 1, 4, 9]);
        let extent = if line == 0 || lines == 0 { 0 } else { (lines - 1) * ld + line };
        let data = vec![T::GUARD; guard + extent * width + guard];
        let before = Vec::new();
        let mut matrix = Self { rows, cols, ld, width, layout, guard, data, before };
        for i in 0..rows {
            for j in 0..cols {
                for part in 0..width {
                    let at = matrix.at(i, j, part);
                    matrix.data[at] = entry(i * width + part, j);
                }
            }
        }
        matrix.before = matrix.data.clone();
        matrix
    }

    /// Creates an array of guards that is written.
    pub fn output(choices: &mut Choices<'_>, len: usize) -> Self {
        let mut array = Self::new(choices, CATA_ROW_MAJOR, (1, len), 1, |_, _| T::GUARD);
        array.ld = len;
        array
    }

    fn at(&self, i: usize, j: usize, part: usize) -> usize {
        let element = if self.layout == CATA_COL_MAJOR { i + j * self.ld } else { i * self.ld + j };
        self.guard + element * self.width + part
    }

    pub fn pointer(&self) -> *const T {
        self.data[self.guard..].as_ptr()
    }

    pub fn pointer_mut(&mut self) -> *mut T {
        self.data[self.guard..].as_mut_ptr()
    }

    /// Returns whether there is no element to point to.
    pub fn is_empty(&self) -> bool {
        self.rows == 0 || self.cols == 0
    }

    pub fn get(&self, i: usize, j: usize) -> T {
        self.data[self.at(i, j, 0)]
    }

    pub fn part(&self, i: usize, j: usize, part: usize) -> T {
        self.data[self.at(i, j, part)]
    }

    /// Returns what an entry was when the matrix was created.
    pub fn old(&self, i: usize, j: usize, part: usize) -> T {
        self.before[self.at(i, j, part)]
    }

    /// Forgets what the matrix was before.
    pub fn accept(&mut self) {
        self.before.clone_from(&self.data);
    }

    /// # Panics
    /// When anything but the wanted entries has changed.
    pub fn check_changes(&self, what: &str, wanted: impl Fn(usize, usize) -> bool) {
        let mut may = vec![false; self.data.len()];
        for i in 0..self.rows {
            for j in 0..self.cols {
                for part in 0..self.width {
                    may[self.at(i, j, part)] = wanted(i, j);
                }
            }
        }
        for (at, (now, before)) in self.data.iter().zip(&self.before).enumerate() {
            let same = now.bits() == before.bits();
            assert!(same || may[at], "{what}: element {at} was {before:?}, and is {now:?}");
        }
    }

    /// # Panics
    /// When anything has changed.
    pub fn check_untouched(&self, what: &str) {
        self.check_changes(what, |_, _| false);
    }
}
