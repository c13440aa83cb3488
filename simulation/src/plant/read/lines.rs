use catamaran::base::{Error, Result};
use catamaran::io::Source;

/// Reads the lines of a text file; every error names the last line read.
pub(super) struct Lines<'a>(Source<'a>);

impl<'a> Lines<'a> {
    /// Creates a reader of the lines of a source.
    pub fn new(source: Source<'a>) -> Self {
        Self(source)
    }

    /// Returns the next line that is not blank, trimmed, or `None` at the end.
    pub fn next(&mut self) -> Result<Option<String>> {
        loop {
            let Some(bytes) = self.0.next_bytes()? else { return Ok(None) };
            let text = std::str::from_utf8(bytes).map(|line| line.trim().to_owned());
            match text {
                Ok(line) if line.is_empty() => {}
                Ok(line) => return Ok(Some(line)),
                Err(_) => return Err(self.fail("is not text (UTF-8)")),
            }
        }
    }

    /// Returns the next line that is not only a comment, with its leading tabs, and without the
    /// comment after a `#`. Bytes that are not UTF-8 are read as Latin-1.
    pub fn next_row(&mut self) -> Result<Option<String>> {
        loop {
            let Some(bytes) = self.0.next_bytes()? else { return Ok(None) };
            let text = match std::str::from_utf8(bytes) {
                Ok(text) => text.to_owned(),
                Err(_) => bytes.iter().copied().map(char::from).collect(),
            };
            let row = text.split('#').next().unwrap_or_default();
            if !row.trim().is_empty() {
                return Ok(Some(row.to_owned()));
            }
        }
    }

    /// Returns the next line, or an error at the end of the file.
    pub fn expect(&mut self, what: &str) -> Result<String> {
        match self.next()? {
            Some(line) => Ok(line),
            None => Err(self.fail(format!("the file ends before {what}"))),
        }
    }

    /// Returns the error `what` at this line.
    pub fn fail(&self, what: impl Into<String>) -> Error {
        self.0.fail(what)
    }

    /// Parses a finite number.
    pub fn number(&self, what: &str, word: Option<&str>) -> Result<f64> {
        let word = word.unwrap_or_default().trim();
        let number = word.parse().ok().filter(|x: &f64| x.is_finite());
        number.ok_or_else(|| self.fail(format!("{what}: {word:?} is not a finite number")))
    }

    /// Parses the coordinates x, y and z in units of `unit` metres.
    pub fn point<'w>(
        &self,
        words: &mut impl Iterator<Item = &'w str>,
        unit: f64,
    ) -> Result<[f64; 3]> {
        let mut coordinate = |what| self.number(what, words.next()).map(|number| unit * number);
        Ok([coordinate("x")?, coordinate("y")?, coordinate("z")?])
    }

    /// Parses 0 or 1.
    pub fn flag(&self, what: &str, word: Option<&str>) -> Result<bool> {
        match self.number(what, word)? {
            0.0 => Ok(false),
            1.0 => Ok(true),
            other => Err(self.fail(format!("{what}: must be 0 or 1, is {other}"))),
        }
    }

    /// Returns an error if there is a word left: a number with a decimal comma, for example, is two
    /// words, and shifts all that follow.
    pub fn end<'w>(&self, mut words: impl Iterator<Item = &'w str>, expected: &str) -> Result<()> {
        match words.next() {
            Some(word) => Err(self.fail(format!("{word:?} is one too many: expected {expected}"))),
            None => Ok(()),
        }
    }

    /// Parses a whole number from 0, which may have the form 3.0.
    pub fn count(&self, what: &str, word: Option<&str>) -> Result<usize> {
        let value = self.number(what, word)?;
        if value >= 0.0 && value < f64::from(u32::MAX) && value.fract() == 0.0 {
            return Ok(value as usize);
        }
        Err(self.fail(format!("{what}: {value} is not a whole number from 0")))
    }
}
