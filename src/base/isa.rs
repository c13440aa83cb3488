//! The limit on the instruction sets that this process uses.

use std::sync::{Once, OnceLock};

use super::error::{Error, Result};

/// The environment variable with the name of the limit.
const VARIABLE: &str = "CATAMARAN_ISA";

/// The instruction sets that kernels are written for; each level includes those before it that the
/// architecture of the CPU has.
///
/// ```
/// use catamaran::base::IsaLevel;
///
/// assert!(IsaLevel::Avx2 < IsaLevel::Avx512);
/// assert_eq!(IsaLevel::ALL.map(IsaLevel::name)[0], "portable");
/// ```
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
#[non_exhaustive]
pub enum IsaLevel {
    /// Plain Rust, compiled for any CPU of the architecture.
    Portable,
    /// NEON, which every AArch64 CPU has.
    Neon,
    /// NEON with dot products of bytes.
    Dotprod,
    /// NEON with products of 2 x 8 matrices of bytes.
    I8mm,
    /// AVX2 with FMA and BMI2.
    Avx2,
    /// AVX2 with dot products of bytes (AVX-VNNI).
    AvxVnni,
    /// AVX-512 (F, VL, DQ, BW).
    Avx512,
    /// AVX-512 with dot products of bytes (VNNI).
    Vnni,
    /// Intel's matrix tiles (AMX-INT8).
    Amx,
}

impl IsaLevel {
    /// All levels, the smallest first.
    pub const ALL: [Self; 9] = [
        Self::Portable,
        Self::Neon,
        Self::Dotprod,
        Self::I8mm,
        Self::Avx2,
        Self::AvxVnni,
        Self::Avx512,
        Self::Vnni,
        Self::Amx,
    ];

    /// Returns the name that `CATAMARAN_ISA` takes: `portable`, `neon`, `dotprod`, `i8mm`, `avx2`,
    /// `avxvnni`, `avx512`, `vnni` or `amx`.
    pub fn name(self) -> &'static str {
        match self {
            Self::Portable => "portable",
            Self::Neon => "neon",
            Self::Dotprod => "dotprod",
            Self::I8mm => "i8mm",
            Self::Avx2 => "avx2",
            Self::AvxVnni => "avxvnni",
            Self::Avx512 => "avx512",
            Self::Vnni => "vnni",
            Self::Amx => "amx",
        }
    }

    /// Checks that the limit of this process permits the level. The error says why not, in the form
    /// in which kernels say what the CPU lacks.
    ///
    /// An invalid limit is reported once on standard error, and permits everything: the functions
    /// that ask have no way to return an error.
    pub(crate) fn permitted(self) -> std::result::Result<(), &'static str> {
        static REPORTED: Once = Once::new();
        match limit() {
            Ok(limit) if self <= *limit => Ok(()),
            Ok(_) => Err("above the limit that CATAMARAN_ISA or the program sets"),
            Err(why) => {
                REPORTED.call_once(|| {
                    use std::io::Write;
                    let line = format!("catamaran: {VARIABLE}: {why}; there is no limit");
                    let _ = writeln!(std::io::stderr(), "{line}");
                });
                Ok(())
            }
        }
    }
}

/// Returns the limit on the instruction sets of this process: the level that [`set_isa_limit`] set,
/// else the one that the environment variable `CATAMARAN_ISA` names, else the highest.
///
/// The variable is read once, by this function or by the first product. With a limit, the kernels
/// compute what they compute on a CPU that has no more than these instruction sets. Dense
/// decompositions (by faer) and other BLAS libraries choose their instructions themselves.
///
/// ```
/// use catamaran::base::{IsaLevel, isa_limit};
///
/// if std::env::var_os("CATAMARAN_ISA").is_none() {
///     assert_eq!(isa_limit()?, IsaLevel::Amx);
/// }
/// # Ok::<(), catamaran::Error>(())
/// ```
///
/// # Errors
/// [`Error::Argument`] when the variable holds no name of a level; the process then has no limit,
/// and the first product reports the variable on standard error.
pub fn isa_limit() -> Result<IsaLevel> {
    limit().clone().map_err(|why| Error::Argument { what: VARIABLE, why })
}

/// Sets the limit on the instruction sets of this process, in place of `CATAMARAN_ISA`. Call it
/// before any other function of this crate.
///
/// ```standalone_crate
/// use catamaran::base::{IsaLevel, isa_limit, set_isa_limit};
///
/// set_isa_limit(IsaLevel::Avx2)?;
/// assert_eq!(isa_limit()?, IsaLevel::Avx2);
/// assert!(set_isa_limit(IsaLevel::Portable).is_err()); // too late
/// # Ok::<(), catamaran::Error>(())
/// ```
///
/// # Errors
/// [`Error::Argument`] when another limit is in use already.
pub fn set_isa_limit(level: IsaLevel) -> Result<()> {
    let found = LIMIT.get_or_init(|| Ok(level));
    if *found == Ok(level) {
        return Ok(());
    }
    let used = found.as_ref().map_or("no limit", |found| found.name());
    let why = format!("can't become {}: {used} is in use already", level.name());
    Err(Error::Argument { what: "limit on instruction sets", why })
}

static LIMIT: OnceLock<std::result::Result<IsaLevel, String>> = OnceLock::new();

fn limit() -> &'static std::result::Result<IsaLevel, String> {
    LIMIT.get_or_init(|| match std::env::var_os(VARIABLE) {
        Some(text) => parse(&text.to_string_lossy()),
        None => Ok(IsaLevel::Amx),
    })
}

/// Returns the limit that a text names: the highest level if it is empty.
fn parse(text: &str) -> std::result::Result<IsaLevel, String> {
    let text = text.trim();
    if text.is_empty() {
        return Ok(IsaLevel::Amx);
    }
    let found = IsaLevel::ALL.into_iter().find(|level| level.name() == text);
    found.ok_or_else(|| {
        let [others @ .., last] = IsaLevel::ALL.map(IsaLevel::name);
        format!("must be {} or {last}, not {text:?}", others.join(", "))
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_level_is_parsed_by_its_name_and_nothing_else_is() {
        assert!(IsaLevel::ALL.is_sorted(), "a limit permits the levels before it");
        for level in IsaLevel::ALL {
            assert_eq!(parse(level.name()), Ok(level));
            assert_eq!(parse(&format!(" {} ", level.name())), Ok(level));
        }
        assert_eq!(parse(" "), Ok(IsaLevel::Amx));
        for text in ["AVX2", "avx", "avx3", "none", "avx2,fma"] {
            let why = parse(text).unwrap_err();
            let all =
                "must be portable, neon, dotprod, i8mm, avx2, avxvnni, avx512, vnni or amx, not ";
            assert!(why.contains(all) && why.contains(text), "{why}");
        }
    }

    #[test]
    fn levels_up_to_the_limit_are_permitted() {
        let limit = isa_limit().expect("tests run with a valid limit");
        for level in IsaLevel::ALL {
            assert_eq!(level.permitted().is_ok(), level <= limit, "{level:?}");
        }
        assert_eq!(set_isa_limit(limit), Ok(()));
    }
}
