//! The words of a column, and their numbers.

use std::sync::{Arc, Mutex, MutexGuard, OnceLock, PoisonError};

use super::fault::Fault;
use crate::io::limits::LARGER_MAX_MEMORY;
use crate::io::table::Levels;

/// The words of a column, shared by the readers of its groups.
#[derive(Debug)]
pub struct Words {
    numbering: Mutex<Numbering>,
    /// The numbers of the words of the column's dictionary.
    coded: OnceLock<Arc<[Option<i32>]>>,
}

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
        Self::of(Numbering { levels: Levels::default(), left: Some(limit) })
    }

    /// Returns words with the numbers of their places; others have none.
    pub fn closed(words: &[Vec<u8>]) -> Self {
        let mut levels = Levels::default();
        for word in words {
            levels.number(word);
        }
        Self::of(Numbering { levels, left: None })
    }

    fn of(numbering: Numbering) -> Self {
        Self { numbering: numbering.into(), coded: OnceLock::new() }
    }

    /// Returns the numbers of the words of the only dictionary of the column, which are found once
    /// for all groups; `None` for words that are missing.
    ///
    /// # Errors
    /// Words that take too much memory.
    pub fn of_dictionary(&self, words: &[Option<Vec<u8>>]) -> Result<Arc<[Option<i32>]>, Fault> {
        let mut numbering = self.numbering();
        if let Some(known) = self.coded.get() {
            return Ok(known.clone());
        }
        let number =
            |word: &Option<Vec<u8>>| word.as_ref().map(|word| numbering.number(word)).transpose();
        let found: Arc<[_]> = words.iter().map(number).collect::<Result<_, Fault>>()?;
        Ok(self.coded.get_or_init(|| found).clone())
    }

    /// Returns the numbers, for one reader at a time.
    pub fn numbering(&self) -> MutexGuard<'_, Numbering> {
        self.numbering.lock().unwrap_or_else(PoisonError::into_inner)
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

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_words_of_a_dictionary_are_numbered_once() {
        let words = Words::closed(&[b"b".to_vec(), b"a".to_vec()]);
        let dictionary = [Some(b"a".to_vec()), None, Some(b"other".to_vec()), Some(b"b".to_vec())];
        let found = words.of_dictionary(&dictionary).unwrap();
        assert_eq!(*found, [Some(1), None, Some(-1), Some(0)]);
        // The next group has the same.
        assert!(Arc::ptr_eq(&found, &words.of_dictionary(&dictionary).unwrap()));
    }
}
