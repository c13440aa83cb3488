//! Files of the repository that are generated: written, or checked for drift.

use std::path::Path;

/// A generated file.
pub struct Generated {
    /// Its path in the repository.
    pub name: &'static str,
    /// What it is made from.
    pub source: &'static str,
    /// The command that writes it.
    pub command: &'static str,
    /// Its content.
    pub generate: fn(&Path) -> Result<String, String>,
}

impl Generated {
    /// Writes the file.
    pub fn write(&self, root: &Path) -> Result<(), String> {
        let path = root.join(self.name);
        std::fs::write(&path, (self.generate)(root)?)
            .map_err(|e| format!("{}: {e}", path.display()))
    }

    /// Fails if the file on disk is not up to date.
    pub fn check(&self, root: &Path) -> Result<(), String> {
        let (is, should_be) = (super::read(&root.join(self.name))?, (self.generate)(root)?);
        if is == should_be {
            return Ok(());
        }
        let line = is.lines().zip(should_be.lines()).take_while(|(a, b)| a == b).count();
        let of = |text: &str| text.lines().nth(line).unwrap_or("(end of file)").to_owned();
        Err(format!(
            "{} has drifted from {}: run `{}` and commit it.\n\
             line {}\n  is        {}\n  should be {}",
            self.name,
            self.source,
            self.command,
            line + 1,
            of(&is),
            of(&should_be)
        ))
    }
}
