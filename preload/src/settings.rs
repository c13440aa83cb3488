//! Settings from the environment, read at the first call that is not forwarded at once.

use std::fmt::Display;
use std::sync::OnceLock;

use catamaran::Par;
use catamaran::base::obey_omp_num_threads;

/// Which products are computed here.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum Mode {
    /// Those that are expected to be faster here.
    #[default]
    Auto,
    /// All, by the exact path: the same bytes on every machine.
    Reproducible,
    /// All, by the exact path with errors hardly larger than those of rounded results.
    Max,
    /// None.
    Off,
}

impl Mode {
    const NAMES: [(&'static str, Self); 4] = [
        ("auto", Self::Auto),
        ("reproducible", Self::Reproducible),
        ("max", Self::Max),
        ("off", Self::Off),
    ];

    /// Returns its name in the environment.
    pub fn name(self) -> &'static str {
        Self::NAMES.iter().find(|(_, mode)| *mode == self).map_or("", |(name, _)| name)
    }
}

/// Memory that a call may take beyond its operands by default, in bytes: small beside operands that
/// are worth a plan, since a BLAS can't report a lack of memory.
const DEFAULT_MEMORY: usize = 64 << 20;

/// The settings of this process.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Settings {
    /// `CATAMARAN_BLAS`.
    pub mode: Mode,
    /// `CATAMARAN_BLAS_VERBOSE`: counts and times calls, and reports them at exit.
    pub verbose: bool,
    /// Whether to say at exit that `auto` gained nothing: unless `CATAMARAN_BLAS_VERBOSE=0`.
    pub hints: bool,
    /// Those of [`Par::all`], which reads variables of its own.
    pub threads: usize,
    /// `CATAMARAN_BLAS_MEMORY`: bytes that a call may take beyond its operands; `None`: any number.
    pub memory: Option<usize>,
}

impl Settings {
    /// Returns the settings of this process.
    pub fn get() -> &'static Self {
        static SETTINGS: OnceLock<Settings> = OnceLock::new();
        SETTINGS.get_or_init(|| {
            obey_omp_num_threads();
            Self::read(&|name| Some(std::env::var_os(name)?.to_string_lossy().into_owned()))
        })
    }

    /// Returns whether small products may be forwarded without a look at the settings.
    pub fn forwards_small(&self) -> bool {
        !self.verbose && matches!(self.mode, Mode::Auto | Mode::Off)
    }

    fn read(variable: &dyn Fn(&str) -> Option<String>) -> Self {
        let verbose = read(variable, "CATAMARAN_BLAS_VERBOSE", "0 or 1", switch);
        let modes = "auto, reproducible, max or off";
        Self {
            mode: read(variable, "CATAMARAN_BLAS", modes, mode).unwrap_or_default(),
            verbose: verbose == Some(true),
            hints: verbose != Some(false),
            threads: Par::all().threads(),
            memory: read(
                variable,
                "CATAMARAN_BLAS_MEMORY",
                "bytes (as in 67108864, 512M or 4G) or unlimited",
                memory,
            )
            .unwrap_or(Some(DEFAULT_MEMORY)),
        }
    }
}

/// Returns the value of a variable, or `None`, with a line on standard error, if it is invalid.
fn read<V>(
    variable: &dyn Fn(&str) -> Option<String>,
    name: &str,
    wanted: &str,
    parse: impl Fn(&str) -> Option<V>,
) -> Option<V> {
    let text = variable(name)?;
    let text = text.trim();
    if text.is_empty() {
        return None;
    }
    let value = parse(text);
    if value.is_none() {
        complain(&format!("{name}={text}: must be {wanted}; the default is used"));
    }
    value
}

/// Writes a line to standard error, where that is open.
pub fn complain(what: &dyn Display) {
    use std::io::Write;
    let _ = writeln!(std::io::stderr(), "catamaran-blas: {what}");
}

fn switch(text: &str) -> Option<bool> {
    match text {
        "0" => Some(false),
        "1" => Some(true),
        _ => None,
    }
}

fn mode(text: &str) -> Option<Mode> {
    Mode::NAMES.iter().find(|(name, _)| *name == text).map(|(_, mode)| *mode)
}

fn memory(text: &str) -> Option<Option<usize>> {
    if text == "unlimited" {
        return Some(None);
    }
    let digits = text.trim_end_matches(|c: char| c.is_ascii_alphabetic());
    let shift = match text[digits.len()..].to_ascii_lowercase().as_str() {
        "" | "b" => 0,
        "k" | "kib" | "kb" => 10,
        "m" | "mib" | "mb" => 20,
        "g" | "gib" | "gb" => 30,
        _ => return None,
    };
    let bytes: usize = digits.parse().ok()?;
    bytes.checked_mul(1 << shift).map(Some)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn settings(variables: &[(&str, &str)]) -> Settings {
        Settings::read(&|name| {
            variables.iter().find(|(n, _)| *n == name).map(|(_, value)| (*value).to_owned())
        })
    }

    #[test]
    fn an_empty_environment_gives_the_defaults() {
        let expected = Settings {
            mode: Mode::Auto,
            verbose: false,
            hints: true,
            threads: Par::all().threads(),
            memory: Some(64 << 20),
        };
        assert_eq!(settings(&[]), expected);
        assert_eq!(settings(&[("CATAMARAN_BLAS", " ")]), expected);
    }

    #[test]
    fn variables_are_read() {
        for (name, mode) in Mode::NAMES {
            assert_eq!(settings(&[("CATAMARAN_BLAS", name)]).mode, mode);
            assert_eq!(mode.name(), name);
        }
        assert!(settings(&[("CATAMARAN_BLAS_VERBOSE", "1")]).verbose);
        let silent = settings(&[("CATAMARAN_BLAS_VERBOSE", "0")]);
        assert!(!silent.verbose && !silent.hints);
        for (text, bytes) in
            [("100", Some(100)), ("3k", Some(3072)), ("2GiB", Some(2 << 30)), ("unlimited", None)]
        {
            assert_eq!(settings(&[("CATAMARAN_BLAS_MEMORY", text)]).memory, bytes);
        }
    }

    #[test]
    fn what_is_no_value_leaves_the_default() {
        for (name, text) in [
            ("CATAMARAN_BLAS", "fast"),
            ("CATAMARAN_BLAS_VERBOSE", "yes"),
            ("CATAMARAN_BLAS_MEMORY", "1T"),
            ("CATAMARAN_BLAS_MEMORY", "99999999999G"),
        ] {
            assert_eq!(settings(&[(name, text)]), settings(&[]), "{name}={text}");
        }
    }
}
