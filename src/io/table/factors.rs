//! The factors of a table: columns of words, whose entries are numbers of levels.

use super::layout::{Layout, Use};
use super::piece::{Levels, Piece, texts};
use super::reading::{ColumnKind, TableReading};

/// The levels of all factors.
#[derive(Debug)]
pub(super) struct Factors {
    /// Where the entries of each factor are in a row.
    places: Vec<usize>,
    levels: Vec<Levels>,
}

impl Factors {
    pub fn new(layout: &Layout) -> Self {
        let mut found: Vec<(usize, usize)> = layout
            .uses
            .iter()
            .filter_map(|used| match used {
                Use::Word(place, factor) => Some((*factor, *place)),
                _ => None,
            })
            .collect();
        found.sort_unstable();
        let places: Vec<usize> = found.into_iter().map(|(_, place)| place).collect();
        let levels = places.iter().map(|_| Levels::default()).collect();
        Self { places, levels }
    }

    /// Adds the words of a piece that are new.
    pub fn learn(&mut self, piece: &Piece) {
        for (known, new) in self.levels.iter_mut().zip(&piece.levels) {
            for word in &new.words {
                known.number(word);
            }
        }
    }

    /// Replaces the numbers of words in rows of a piece by those of all words; false if a word is
    /// not known.
    pub fn translate(&self, piece: &Piece, values: &mut [f64], ncols: usize) -> bool {
        for ((place, known), own) in self.places.iter().zip(&self.levels).zip(&piece.levels) {
            let numbers: Option<Vec<u32>> = own.words.iter().map(|word| known.find(word)).collect();
            let Some(numbers) = numbers else { return false };
            renumber(values, *place, ncols, &numbers);
        }
        true
    }

    /// Sorts the levels, and changes the numbers in rows accordingly.
    pub fn sort(&mut self, values: &mut [f64], ncols: usize) {
        for (place, levels) in self.places.iter().zip(&mut self.levels) {
            let mut words = levels.words.clone();
            words.sort_unstable();
            let mut sorted = Levels::default();
            for word in &words {
                sorted.number(word);
            }
            let ranks: Option<Vec<u32>> =
                levels.words.iter().map(|word| sorted.find(word)).collect();
            renumber(values, *place, ncols, &ranks.unwrap_or_default());
            *levels = sorted;
        }
    }

    /// Gives the levels to the columns of a reading.
    pub fn give_levels(&self, reading: &mut TableReading) {
        let mut given = self.levels.iter().map(|levels| texts(&levels.words));
        for column in &mut reading.columns {
            if let ColumnKind::Factor { levels } = &mut column.kind {
                *levels = given.next().unwrap_or_default();
            }
        }
    }
}

/// Replaces number i by `numbers[i]` in a column of rows; a missing word stays NaN.
fn renumber(values: &mut [f64], place: usize, ncols: usize, numbers: &[u32]) {
    for value in values.iter_mut().skip(place).step_by(ncols) {
        if let Some(&number) = numbers.get(*value as usize).filter(|_| !value.is_nan()) {
            *value = f64::from(number);
        }
    }
}
