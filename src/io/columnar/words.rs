//! The words of a column, and their numbers.

use std::sync::{Mutex, MutexGuard, PoisonError};

use super::fault::Fault;
use crate::io::limits::LARGER_MAX_MEMORY;
use crate::io::table::Levels;

/// The words of a column, shared by the readers of its groups.
#[derive(Debug)]
pub struct Words(Mutex<Numbering>);

/// Numbers of words.
#[derive(Debug)]
pub struct Numbering {
    levels: Levels,
    /// Bytes of memory that further words may take; `None`: no word is added any more.
    left: Option<u64>,
}

impl Words {
    /// Returns no words; those that are added take at most `limit` bytes of memory.
    pub fn new(limit: u64) -> Self {
        Self(Mutex::new(Numbering { levels: Levels::default(), left: Some(limit) }))
    }

    /// Returns words with the numbers of their places; others have none.
    pub fn closed(words: &[Vec<u8>]) -> Self {
        let mut levels = Levels::default();
        for word in words {
            levels.number(word);
        }
        Self(Mutex::new(Numbering { levels, left: None }))
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
    ///
    /// # Errors
    /// Words that take too much memory.
    pub fn number(&mut self, word: &[u8]) -> Result<i32, Fault> {
        let number = match (self.levels.find(word), &mut self.left) {
            (Some(number), _) => number,
            (None, None) => return Ok(-1),
            (None, Some(left)) => {
                // Levels have each word twice.
                let bytes = 2 * (word.len() + size_of::<Vec<u8>>()) as u64;
                let most = || format!("words of more bytes than it may take: {LARGER_MAX_MEMORY}");
                *left = left.checked_sub(bytes).ok_or_else(most)?;
                self.levels.number(word)
            }
        };
        i32::try_from(number).map_err(|_| "more words than have numbers".into())
    }
}

/// Returns the entry for the number of a word.
pub fn entry(number: i32) -> f64 {
    if number < 0 { f64::NAN } else { f64::from(number) }
}
