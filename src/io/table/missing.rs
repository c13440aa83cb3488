//! The words of missing cells.

use super::number::{self, NOTATIONS, PLAIN};

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
    /// Whether a word can be read as a number, so that words come first.
    pub has_numbers: bool,
    /// The values of words that are numbers: `-999` also stands for `-999.0`.
    pub numbers: Vec<f64>,
}

impl MissingWords {
    /// Returns the words of the caller, or those by default.
    pub fn new(words: Option<&[String]>) -> Self {
        let bytes = |word: &str| word.trim().as_bytes().to_vec();
        match words {
            None => Self {
                words: DEFAULT.iter().map(|&w| bytes(w)).collect(),
                has_numbers: false,
                numbers: Vec::new(),
            },
            Some(words) => {
                let words: Vec<Vec<u8>> = words.iter().map(|word| bytes(word)).collect();
                let value = |word: &Vec<u8>| {
                    number::parse(word, PLAIN).or_else(|| number::parse(word, NOTATIONS[1]))
                };
                let numbers: Vec<f64> =
                    words.iter().filter_map(value).filter(|value| !value.is_nan()).collect();
                let has_numbers =
                    !numbers.is_empty() || words.iter().any(|word| number::readings(word) != 0);
                Self { words, has_numbers, numbers }
            }
        }
    }

    /// Returns whether a field, without blanks around it, is missing.
    pub fn holds(&self, field: &[u8]) -> bool {
        field.is_empty() || self.words.iter().any(|word| word == field)
    }
}
