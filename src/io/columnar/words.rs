//! The words of a column, and their numbers.

use std::sync::{Mutex, MutexGuard, PoisonError};

use crate::io::table::Levels;

/// The words of a column, shared by the readers of its groups.
#[derive(Debug, Default)]
pub struct Words(Mutex<Numbering>);

/// Numbers of words.
#[derive(Debug, Default)]
pub struct Numbering {
    levels: Levels,
    /// Whether no word is added any more.
    is_closed: bool,
}

impl Words {
    /// Returns words with the numbers of their places; others have none.
    pub fn closed(words: &[Vec<u8>]) -> Self {
        let mut levels = Levels::default();
        for word in words {
            levels.number(word);
        }
        Self(Mutex::new(Numbering { levels, is_closed: true }))
    }

    /// Returns the numbers, for one reader at a time.
    pub fn numbering(&self) -> MutexGuard<'_, Numbering> {
        self.0.lock().unwrap_or_else(PoisonError::into_inner)
    }

    /// Returns the words of which `seen` tells that rows have them, sorted by their bytes.
    pub fn sorted(&self, seen: &[bool]) -> Vec<Vec<u8>> {
        let numbering = self.numbering();
        let words = numbering.levels.words.iter().zip(seen);
        let mut sorted: Vec<_> =
            words.filter(|(_, seen)| **seen).map(|(word, _)| word.clone()).collect();
        sorted.sort_unstable();
        sorted
    }
}

impl Numbering {
    /// Returns the number of a word; -1 if it has none.
    pub fn number(&mut self, word: &[u8]) -> i32 {
        let number = match self.is_closed {
            true => self.levels.find(word),
            false => Some(self.levels.number(word)),
        };
        number.and_then(|number| i32::try_from(number).ok()).unwrap_or(-1)
    }
}

/// Returns the entry for the number of a word.
pub fn entry(number: i32) -> f64 {
    if number < 0 { f64::NAN } else { f64::from(number) }
}
