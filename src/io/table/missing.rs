//! The words of missing cells.

use super::number::{self, Notation};

/// The words that stand for a missing cell by default: those of `pandas.read_csv` (pandas 2), and
/// the point of SAS.
const DEFAULT: [&str; 19] = [
    "#N/A", "#N/A N/A", "#NA", "-1.#IND", "-1.#QNAN", "-NaN", "-nan", "1.#IND", "1.#QNAN", "<NA>",
    "N/A", "NA", "NULL", "NaN", "None", "n/a", "nan", "null", ".",
];

/// The words of missing cells of a table, besides the empty cell.
#[derive(Debug, Clone)]
pub(super) struct MissingWords {
    words: Vec<Vec<u8>>,
    /// The values of words that are numbers in the notation of the table: `-999` also stands for
    /// `-999.0`.
    pub numbers: Vec<f64>,
}

impl MissingWords {
    /// Returns the words of the caller, or those by default. No notation is known yet.
    pub fn new(words: Option<&[String]>) -> Self {
        let bytes = |word: &str| word.trim().as_bytes().to_vec();
        let words = match words {
            None => DEFAULT.iter().map(|&word| bytes(word)).collect(),
            Some(words) => words.iter().map(|word| bytes(word)).collect(),
        };
        Self { words, numbers: Vec::new() }
    }

    /// Reads words that are numbers in the notation of a table, or in the usual one, in which
    /// options are written.
    pub fn read_in(self, notation: Notation) -> Self {
        let value = |word: &Vec<u8>| {
            number::parse(word, notation).or_else(|| number::parse(word, number::PLAIN))
        };
        let numbers = self.words.iter().filter_map(value).filter(|value| !value.is_nan()).collect();
        Self { numbers, ..self }
    }

    /// Returns whether a field, without blanks around it, is missing.
    pub fn holds(&self, field: &[u8]) -> bool {
        field.is_empty() || self.words.iter().any(|word| word == field)
    }
}
