use std::cmp::Ordering;

use crate::base::{Error, Result, reserved};

/// A column of categories: which entries of the column stand for which level.
///
/// In a matrix it becomes one column for each level but the first, the base: 1 in the rows of that
/// level, else 0 (treatment coding, as R and patsy do it). The coefficient of such a column is the
/// difference of its level from the base.
///
/// ```
/// use catamaran::rows::Factor;
///
/// let region = Factor::of_codes("region", vec!["West".into(), "East".into()])?;
/// assert_eq!(region.levels(), ["East", "West"]);
/// assert_eq!(region.columns(), ["region[West]"]);
/// assert_eq!(region.with_base("West")?.columns(), ["region[East]"]);
///
/// let year = Factor::of_numbers("year", vec![2024.0, 2025.0, 999.0])?;
/// assert_eq!(year.levels(), ["999", "2024", "2025"]);
/// # Ok::<(), catamaran::Error>(())
/// ```
#[derive(Debug, Clone, PartialEq)]
pub struct Factor {
    name: String,
    /// The base first.
    levels: Vec<String>,
    /// Entries and the index of the level of each, ascending by entry.
    entries: Vec<(f64, usize)>,
}

impl Factor {
    /// Creates a factor of which entry k, from 0, stands for the k-th of these levels. Levels are
    /// sorted, and the first one is the base: by value if all of them are numbers, else by their
    /// bytes.
    ///
    /// # Errors
    /// [`Error::Argument`] of "factor", which names the factor, for fewer than two levels, for a
    /// level that is there twice, and for two that are the same number (1 and 1.0) where all levels
    /// are numbers; [`Error::OutOfMemory`].
    pub fn of_codes(name: impl Into<String>, levels: Vec<String>) -> Result<Self> {
        let mut factor = Self::in_order(name, levels)?;
        let numbers = factor.numbers();
        let mut order: Vec<usize> = (0..factor.levels.len()).collect();
        order.sort_by(|&i, &j| match &numbers {
            Some(numbers) => numbers[i].total_cmp(&numbers[j]),
            None => factor.levels[i].cmp(&factor.levels[j]),
        });
        factor.arrange(&order);
        Ok(factor)
    }

    /// Creates a factor as [`Factor::of_codes`] does, with the levels in their order and the first
    /// one as base.
    ///
    /// ```
    /// use catamaran::rows::Factor;
    ///
    /// let size = Factor::in_order("size", vec!["small".into(), "large".into()])?;
    /// assert_eq!(size.base(), "small");
    /// assert!(Factor::in_order("size", vec!["small".into()]).is_err());
    /// # Ok::<(), catamaran::Error>(())
    /// ```
    ///
    /// # Errors
    /// As [`Factor::of_codes`].
    pub fn in_order(name: impl Into<String>, levels: Vec<String>) -> Result<Self> {
        let entries = (0..levels.len()).map(|k| (k as f64, k)).collect();
        Self { name: name.into(), levels, entries }.checked()
    }

    /// Creates a factor of which each of these numbers, none of them NaN, is a level, ascending;
    /// the least is the base. Numbers may come more than once.
    ///
    /// # Errors
    /// As [`Factor::of_codes`].
    pub fn of_numbers(name: impl Into<String>, mut numbers: Vec<f64>) -> Result<Self> {
        numbers.sort_by(f64::total_cmp);
        // -0 is 0.
        numbers.iter_mut().for_each(|x| *x += 0.0);
        numbers.dedup();
        let levels = numbers.iter().map(ToString::to_string).collect();
        let entries = numbers.into_iter().enumerate().map(|(k, x)| (x, k)).collect();
        Self { name: name.into(), levels, entries }.checked()
    }

    /// Makes this level the base; the others keep their order. Where all levels are numbers, 1.0 is
    /// the level 1.
    ///
    /// # Errors
    /// [`Error::Argument`] of "factor" when there is no such level.
    pub fn with_base(mut self, level: &str) -> Result<Self> {
        let numbers = self.numbers().unwrap_or_default();
        let base = self.position(level, &numbers).ok_or_else(|| self.unknown(level))?;
        let others = (0..self.levels.len()).filter(|&k| k != base);
        let order: Vec<usize> = std::iter::once(base).chain(others).collect();
        self.arrange(&order);
        Ok(self)
    }

    /// Leaves out the levels that none of these entries stands for, such as those of
    /// [`Survey::entries`](super::Survey::entries). Entries without a level change nothing.
    ///
    /// ```
    /// use catamaran::rows::Factor;
    ///
    /// let levels = ["North", "East", "West"].map(str::to_owned).to_vec();
    /// let region = Factor::in_order("region", levels)?.with_entries(&[2.0, 0.0])?;
    /// assert_eq!(region.levels(), ["North", "West"]);
    /// # Ok::<(), catamaran::Error>(())
    /// ```
    ///
    /// # Errors
    /// As [`Factor::of_codes`].
    pub fn with_entries(&self, entries: &[f64]) -> Result<Self> {
        let mut used = vec![false; self.levels.len()];
        entries.iter().filter_map(|&entry| self.level_of(entry)).for_each(|k| used[k] = true);
        let position: Vec<usize> = used
            .iter()
            .scan(0, |count, &used| {
                let at = *count;
                *count += usize::from(used);
                Some(at)
            })
            .collect();
        let levels = self.levels.iter().zip(&used).filter(|(_, used)| **used);
        let kept = self.entries.iter().filter(|(_, level)| used[*level]);
        Self {
            name: self.name.clone(),
            levels: levels.map(|(level, _)| level.clone()).collect(),
            entries: kept.map(|&(entry, level)| (entry, position[level])).collect(),
        }
        .checked()
    }

    /// Returns this factor for another table, in which entry k of the column, from 0, stands for
    /// the k-th of `levels`: the columns of the matrix stay the same. Where all levels of this
    /// factor are numbers, 1.0 is the level 1.
    ///
    /// ```
    /// use catamaran::rows::Factor;
    ///
    /// let region = Factor::of_codes("region", vec!["East".into(), "West".into()])?;
    /// assert_eq!(region.for_codes(&["West".into()])?.columns(), ["region[West]"]);
    /// let refused = region.for_codes(&["North".into()]).unwrap_err();
    /// assert_eq!(refused.to_string(), "factor: region has no level North, but East, West");
    /// # Ok::<(), catamaran::Error>(())
    /// ```
    ///
    /// # Errors
    /// [`Error::Argument`] of "factor" for a level that this factor does not have.
    pub fn for_codes(&self, levels: &[String]) -> Result<Self> {
        let numbers = self.numbers().unwrap_or_default();
        let index =
            |level: &String| self.position(level, &numbers).ok_or_else(|| self.unknown(level));
        let entries = levels.iter().enumerate().map(|(k, level)| Ok((k as f64, index(level)?)));
        Ok(Self { entries: entries.collect::<Result<_>>()?, ..self.clone() })
    }

    /// Returns this factor for another table, in which the entries of the column are numbers: each
    /// stands for the level that names it, and none for a level that is a word.
    ///
    /// ```
    /// use catamaran::rows::Factor;
    ///
    /// let year = Factor::of_codes("year", vec!["2024".into(), "2025".into()])?;
    /// assert_eq!(year.for_numbers()?, Factor::of_numbers("year", vec![2024.0, 2025.0])?);
    /// let mixed = Factor::of_codes("year", vec!["2024".into(), "unknown".into()])?;
    /// assert_eq!(mixed.for_numbers()?.columns(), ["year[unknown]"]);
    /// # Ok::<(), catamaran::Error>(())
    /// ```
    ///
    /// # Errors
    /// [`Error::Argument`] of "factor" for two levels that are the same number.
    pub fn for_numbers(&self) -> Result<Self> {
        let entries = self.ascending();
        self.check_distinct(&entries)?;
        Ok(Self { entries, ..self.clone() })
    }

    /// Returns the name of the column.
    pub fn name(&self) -> &str {
        &self.name
    }

    /// Returns the levels, the base first.
    pub fn levels(&self) -> &[String] {
        &self.levels
    }

    /// Returns the base.
    pub fn base(&self) -> &str {
        &self.levels[0]
    }

    /// Returns the names of the columns of the matrix, `name[level]`.
    pub fn columns(&self) -> Vec<String> {
        self.levels[1..].iter().map(|level| format!("{}[{level}]", self.name)).collect()
    }

    /// Returns the index of the level, 0 for the base, that an entry stands for.
    pub(super) fn level_of(&self, entry: f64) -> Option<usize> {
        // The entries of codes are their own places.
        let own = self.entries.get(entry as usize).filter(|own| own.0 == entry);
        let order = |own: &(f64, usize)| own.0.partial_cmp(&entry).unwrap_or(Ordering::Less);
        let found = || self.entries.get(self.entries.binary_search_by(order).ok()?);
        own.or_else(found).map(|own| own.1)
    }

    /// Puts the levels with these indices in order.
    fn arrange(&mut self, order: &[usize]) {
        let mut position = vec![0; order.len()];
        order.iter().enumerate().for_each(|(k, &level)| position[level] = k);
        self.entries.iter_mut().for_each(|(_, level)| *level = position[*level]);
        self.levels = order.iter().map(|&level| self.levels[level].clone()).collect();
    }

    fn checked(self) -> Result<Self> {
        if self.levels.len() < 2 {
            let known = self.levels.first().map_or(String::new(), |level| format!(", {level}"));
            let count = if known.is_empty() { "no level" } else { "one level" };
            return Err(self.refused(format!("has {count}{known}: at least two are needed")));
        }
        let mut sorted = reserved(self.levels.len())?;
        sorted.extend(self.levels.iter());
        sorted.sort_unstable();
        if let Some(pair) = sorted.windows(2).find(|pair| pair[0] == pair[1]) {
            return Err(self.refused(format!("has level {} twice", pair[0])));
        }
        let numbers = self.ascending();
        if numbers.len() == self.levels.len() {
            self.check_distinct(&numbers)?;
        }
        Ok(self)
    }

    /// Returns the numbers that the levels are, if all of them are numbers.
    fn numbers(&self) -> Option<Vec<f64>> {
        self.levels.iter().map(|level| number(level)).collect()
    }

    /// Returns the numbers that levels are, ascending, and the index of the level of each.
    fn ascending(&self) -> Vec<(f64, usize)> {
        let levels = self.levels.iter().enumerate();
        let numbers = levels.filter_map(|(k, level)| Some((number(level)?, k)));
        let mut found: Vec<(f64, usize)> = numbers.collect();
        found.sort_by(|a, b| a.0.total_cmp(&b.0));
        found
    }

    /// Checks that no two of these numbers, which ascend, are equal.
    fn check_distinct(&self, numbers: &[(f64, usize)]) -> Result<()> {
        match numbers.windows(2).find(|pair| pair[0].0 == pair[1].0) {
            Some(pair) => {
                let [one, other] = [&self.levels[pair[0].1], &self.levels[pair[1].1]];
                let why = format!("has the levels {one} and {other}, which are the same number");
                Err(self.refused(why))
            }
            None => Ok(()),
        }
    }

    /// Returns the index of a level: of this text, or of the same number among the `numbers` that
    /// all levels are.
    fn position(&self, level: &str, numbers: &[f64]) -> Option<usize> {
        let as_text = self.levels.iter().position(|own| own == level);
        as_text.or_else(|| {
            let wanted = number(level)?;
            numbers.iter().position(|&own| own == wanted)
        })
    }

    pub(super) fn unknown(&self, level: impl std::fmt::Display) -> Error {
        /// Most levels that the message lists.
        const MOST: usize = 8;
        let known = self.levels.iter().take(MOST).cloned().collect::<Vec<_>>().join(", ");
        let more = if self.levels.len() > MOST { ", ..." } else { "" };
        self.refused(format!("has no level {level}, but {known}{more}"))
    }

    fn refused(&self, why: impl std::fmt::Display) -> Error {
        Error::Argument { what: "factor", why: format!("{} {why}", self.name) }
    }
}

/// Returns the number that a text is.
fn number(text: &str) -> Option<f64> {
    text.parse().ok().filter(|number: &f64| number.is_finite())
}
