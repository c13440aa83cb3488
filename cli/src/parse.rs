//! Parsers of the values of options.

use std::error::Error as _;
use std::num::{IntErrorKind, ParseIntError};
use std::ops::Range;
use std::time::Duration;

use catamaran::{Accuracy, SchemeChoice, Uplo};
use catamaran_geometry::mesh::Weld;
use clap::builder::PossibleValuesParser;
use clap::builder::TypedValueParser as _;
use clap::error::{ContextKind, ErrorKind};
use clap::{Arg, ArgMatches, Command};

/// Names of accuracies.
const ACCURACIES: [(&str, Accuracy); 4] = [
    ("max", Accuracy::Max),
    ("classical", Accuracy::Classical),
    ("default", Accuracy::Default),
    ("fast", Accuracy::Fast),
];

/// Returns the command with options that take negative numbers as values, so that each says which
/// numbers it accepts. Otherwise clap would take `-1` for an option.
pub fn with_negative_numbers(command: Command) -> Command {
    let change = |arg: Arg| match arg.is_positional() || !arg.get_action().takes_values() {
        true => arg,
        false => arg.allow_negative_numbers(true),
    };
    command.mut_args(change).mut_subcommands(with_negative_numbers)
}

/// Returns the program and the commands that a command line names, the innermost last, each with
/// its arguments.
pub fn levels<'a>(
    program: &'a Command,
    matches: &'a ArgMatches,
) -> impl Iterator<Item = (&'a Command, &'a ArgMatches)> {
    std::iter::successors(Some((program, matches)), |&(command, matches)| {
        let (name, matches) = matches.subcommand()?;
        Some((command.find_subcommand(name)?, matches))
    })
}

/// Returns the error of a whole number with a reason that says what is expected, where that of the
/// standard library says only what is wrong.
pub fn explained(error: clap::Error, command: &Command) -> clap::Error {
    let reason = error.source().and_then(|source| source.downcast_ref::<ParseIntError>());
    let expected = match reason.map(ParseIntError::kind) {
        Some(IntErrorKind::InvalidDigit) => "a whole number, not negative",
        Some(IntErrorKind::Zero) => "at least 1; without the option, the command chooses",
        _ => return error,
    };
    let (option, value) =
        (error.get(ContextKind::InvalidArg), error.get(ContextKind::InvalidValue));
    let (Some(option), Some(value)) = (option, value) else { return error };
    let why = format!(
        "invalid value '{value}' for '{option}': expected {expected}\n\n\
         For more information, try '--help'.\n"
    );
    clap::Error::raw(ErrorKind::ValueValidation, why).with_cmd(command)
}

/// Parses `lower`, `upper` or `both`.
pub fn uplo() -> impl clap::builder::TypedValueParser<Value = Uplo> {
    PossibleValuesParser::new(["lower", "upper", "both"]).map(|name| match name.as_str() {
        "lower" => Uplo::Lower,
        "upper" => Uplo::Upper,
        _ => Uplo::Both,
    })
}

/// Parses the name of a scheme.
pub fn scheme() -> impl clap::builder::TypedValueParser<Value = SchemeChoice> {
    PossibleValuesParser::new(SchemeChoice::NAMES.map(|(name, _)| name)).map(|name| {
        let found = SchemeChoice::NAMES.into_iter().find(|(known, _)| *known == name);
        found.map_or(SchemeChoice::Auto, |(_, scheme)| scheme)
    })
}

/// Returns the name of a scheme.
pub fn scheme_name(scheme: SchemeChoice) -> &'static str {
    let found = SchemeChoice::NAMES.into_iter().find(|(_, known)| *known == scheme);
    found.map_or("another", |(name, _)| name)
}

/// Parses the name of an accuracy, or a factor.
pub fn accuracy(text: &str) -> Result<Accuracy, String> {
    if let Some((_, accuracy)) = ACCURACIES.into_iter().find(|(name, _)| *name == text) {
        return Ok(accuracy);
    }
    match text.parse() {
        Ok(factor) if factor >= 1.0 && f64::is_finite(factor) => Ok(Accuracy::Bounded(factor)),
        _ => Err("expected max, classical, default, fast, or a number that is at least 1".into()),
    }
}

/// Returns the name of an accuracy.
pub fn accuracy_name(accuracy: Accuracy) -> &'static str {
    let found = ACCURACIES.into_iter().find(|(_, known)| *known == accuracy);
    found.map_or("another", |(name, _)| name)
}

/// Parses a range `FIRST..END` of at least one number.
pub fn columns(text: &str) -> Result<Range<usize>, String> {
    let bounds = text.split_once("..").map(|(first, end)| (first.parse(), end.parse()));
    match bounds {
        Some((Ok(first), Ok(end))) if first < end => Ok(first..end),
        _ => Err("expected FIRST..END with FIRST < END, such as 0..64".into()),
    }
}

/// Parses a number of minutes, which may have a fraction.
pub fn minutes(text: &str) -> Result<Duration, String> {
    let minutes = text.parse::<f64>().ok().map(|m| Duration::try_from_secs_f64(60.0 * m));
    match minutes {
        Some(Ok(time)) => Ok(time),
        _ => Err("expected a number of minutes of at least 0".into()),
    }
}

/// Parses a number of GiB, which may have a fraction, and returns bytes.
pub fn gibibytes(text: &str) -> Result<usize, String> {
    match text.parse::<f64>() {
        Ok(gib) if gib > 0.0 && gib.is_finite() => Ok((gib * f64::from(1 << 30)) as usize),
        _ => Err("expected a number of GiB above 0".into()),
    }
}

/// Parses a confidence, above 0 and below 1.
pub fn confidence(text: &str) -> Result<f64, String> {
    number(text, |x| x > 0.0 && x < 1.0, "a number above 0 and below 1")
}

/// Parses N numbers separated by commas.
pub fn numbers<const N: usize>(text: &str) -> Result<[f64; N], String> {
    let all: Result<Vec<f64>, _> = text.split(',').map(|word| word.trim().parse()).collect();
    let all = all.map_err(|e| format!("expected {N} numbers separated by commas: {e}"))?;
    all.try_into().map_err(|all: Vec<f64>| {
        format!("expected {N} numbers separated by commas, not {}", all.len())
    })
}

/// Parses N finite numbers separated by commas.
pub fn finite_numbers<const N: usize>(text: &str) -> Result<[f64; N], String> {
    let all = numbers(text)?;
    match all.iter().all(|x| x.is_finite()) {
        true => Ok(all),
        false => Err(format!("expected {N} finite numbers separated by commas")),
    }
}

/// Parses a finite number.
pub fn finite(text: &str) -> Result<f64, String> {
    number(text, |_| true, "a finite number")
}

/// Parses a finite number above 0.
pub fn positive(text: &str) -> Result<f64, String> {
    number(text, |x| x > 0.0, "a finite number above 0")
}

/// Parses a finite number of at least 0.
pub fn at_least_zero(text: &str) -> Result<f64, String> {
    number(text, |x| x >= 0.0, "a finite number of at least 0")
}

/// Parses a share.
pub fn share(text: &str) -> Result<f64, String> {
    number(text, |x| (0.0..=1.0).contains(&x), "a number from 0 to 1")
}

/// Parses a finite number that fits what is expected.
fn number(text: &str, fits: impl Fn(f64) -> bool, expected: &str) -> Result<f64, String> {
    let number = text.trim().parse().ok().filter(|x: &f64| x.is_finite() && fits(*x));
    number.ok_or_else(|| format!("expected {expected}"))
}

/// Parses a number of frames, at least 1: each may be a file, of which a folder should not hold
/// more.
pub fn frame_count(text: &str) -> Result<usize, String> {
    const MOST: usize = 100_000;
    match text.parse() {
        Ok(count) if (1..=MOST).contains(&count) => Ok(count),
        _ => Err(format!("expected a whole number from 1 to {MOST}")),
    }
}

/// Parses a whole number of at least 1.
pub fn at_least_one(text: &str) -> Result<usize, String> {
    match text.parse() {
        Ok(count) if count > 0 => Ok(count),
        _ => Err("expected a whole number of at least 1".into()),
    }
}

/// Parses what `--weld` joins: vertices within a distance, or `seams`.
pub fn weld(text: &str) -> Result<Weld, String> {
    match text.parse() {
        _ if text == "seams" => Ok(Weld::Seams),
        Ok(length) if length >= 0.0 && f64::is_finite(length) => Ok(Weld::Within(length)),
        _ => Err("expected a length of at least 0, or `seams`; name a file before --weld".into()),
    }
}
