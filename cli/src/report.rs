//! What goes to stdout and stderr.
//!
//! A line on stdout is a record: a name, values with names, and the same as text. `--json` prints
//! the record as a JSON object, and everything else prints the text; [`report!`], [`row!`] and
//! [`status!`] take both, so that no line exists in one form only. Keys are in `snake_case`; a key
//! ends with the unit of its value where the value has one.

use std::fmt::Arguments;
use std::io::{self, Write};
use std::sync::atomic::{AtomicBool, AtomicU8, Ordering};
use std::time::Duration;

use anyhow::Result;
use catamaran::io::LARGER_MAX_MEMORY;
use serde::{Serialize, Serializer};
use serde_json::Value;

use crate::arguments;

/// Columns of a label, before a blank.
const WIDTH: usize = 11;

/// Results, what was done, notes and progress bars.
const ALL: u8 = 0;
/// Results and notes.
const QUIET: u8 = 1;
/// Nothing but errors.
const SILENT: u8 = 2;

/// The current volume: [`ALL`], [`QUIET`] or [`SILENT`].
static VOLUME: AtomicU8 = AtomicU8::new(ALL);

/// Whether lines are JSON.
static JSON: AtomicBool = AtomicBool::new(false);

/// Suppresses status lines and progress bars (`--quiet`).
pub fn be_quiet() {
    VOLUME.fetch_max(QUIET, Ordering::Relaxed);
}

/// Suppresses everything but errors, because another process prints the same lines.
#[cfg(feature = "mpi")]
pub fn be_silent() {
    VOLUME.fetch_max(SILENT, Ordering::Relaxed);
}

/// Prints records as JSON from now on (`--json`).
pub fn use_json() {
    JSON.store(true, Ordering::Relaxed);
}

/// Returns whether progress bars and status lines are suppressed.
pub fn is_quiet() -> bool {
    VOLUME.load(Ordering::Relaxed) > ALL
}

/// Returns whether lines are JSON.
pub fn is_json() -> bool {
    JSON.load(Ordering::Relaxed)
}

/// Returns how many rows of a table are printed: `most` as text, and all of them as JSON.
pub fn shown(most: usize) -> usize {
    if JSON.load(Ordering::Relaxed) { usize::MAX } else { most }
}

/// Prints a result: `report!("record": "label", key = value; "text {}", argument)`. The label, in a
/// separate column before the text, is the name of the record by default.
macro_rules! report {
    ($record:literal $(: $label:expr)? $(, $key:ident = $value:expr)*; $($text:tt)+) => {
        $crate::report::print(
            $crate::report::Kind::Result,
            $crate::report::Name::of($record)$(.with_label($label))?,
            $crate::report::fields!($($key = $value),*),
            format_args!($($text)+),
        )
    };
}

/// Prints a status line, which `--quiet` suppresses; otherwise like [`report!`].
macro_rules! status {
    ($record:literal $(: $label:expr)? $(, $key:ident = $value:expr)*; $($text:tt)+) => {
        $crate::report::print(
            $crate::report::Kind::Status,
            $crate::report::Name::of($record)$(.with_label($label))?,
            $crate::report::fields!($($key = $value),*),
            format_args!($($text)+),
        )
    };
}

/// Prints a result without a label column: `row!("record", key = value; "text")`.
macro_rules! row {
    ($record:literal $(, $key:ident = $value:expr)*; $($text:tt)+) => {
        $crate::report::report!($record: "" $(, $key = $value)*; $($text)+)
    };
}

/// Names and values, converted when they are needed.
macro_rules! fields {
    ($($key:ident = $value:expr),*) => {
        &|| vec![$((stringify!($key), $crate::report::value(&$value))),*]
    };
}

pub(crate) use {fields, report, row, status};

/// Whether `--quiet` suppresses a line.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Kind {
    Result,
    Status,
}

/// The name of a record, and the label of its text.
#[derive(Debug, Clone, Copy)]
pub struct Name<'a> {
    record: &'static str,
    label: &'a str,
}

impl<'a> Name<'a> {
    /// Returns a name that is also the label.
    pub const fn of(record: &'static str) -> Self {
        Self { record, label: record }
    }

    /// Returns the name with another label; an empty label prints the text alone.
    pub const fn with_label(self, label: &'a str) -> Self {
        Self { label, ..self }
    }
}

/// Keys and values of a record.
type Fields = Vec<(&'static str, Value)>;

/// Converts a value of a record; a value that JSON does not have, such as NaN, becomes `null`.
pub fn value(value: &impl Serialize) -> Value {
    serde_json::to_value(value).unwrap_or(Value::Null)
}

/// Prints a record; [`report!`], [`row!`] and [`status!`] call this function.
///
/// # Errors
/// Stdout can't be written. A closed pipe, as in `... --report | head -1`, is no error: there may
/// be files to write.
pub fn print(
    kind: Kind,
    name: Name<'_>,
    fields: &dyn Fn() -> Fields,
    text: Arguments<'_>,
) -> Result<()> {
    let volume = VOLUME.load(Ordering::Relaxed);
    if volume >= SILENT || volume >= QUIET && kind == Kind::Status {
        return Ok(());
    }
    if JSON.load(Ordering::Relaxed) {
        return write_line(&json(name.record, fields())?);
    }
    match name.label {
        "" => write_line(&text.to_string()),
        label => write_line(&format!("{label:<WIDTH$} {text}")),
    }
}

/// Prints a line that JSON leaves out, such as the header of a table.
///
/// # Errors
/// As [`print`].
pub fn head(text: Arguments<'_>) -> Result<()> {
    let is_shown = VOLUME.load(Ordering::Relaxed) < SILENT && !JSON.load(Ordering::Relaxed);
    if is_shown { write_line(&text.to_string()) } else { Ok(()) }
}

fn write_line(line: &str) -> Result<()> {
    match io::stdout().write_all(format!("{line}\n").as_bytes()) {
        Err(e) if e.kind() == io::ErrorKind::BrokenPipe => Ok(()),
        written => Ok(written?),
    }
}

/// Returns a record as one JSON object, its name first.
fn json(record: &'static str, fields: Fields) -> serde_json::Result<String> {
    struct Record(&'static str, Fields);
    impl Serialize for Record {
        fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
            let name = Value::from(self.0);
            let name = std::iter::once(("record", &name));
            serializer.collect_map(name.chain(self.1.iter().map(|(key, value)| (*key, value))))
        }
    }
    serde_json::to_string(&Record(record, fields))
}

/// Prints an error on stderr, after the name of the program. The line is one write: other ranks
/// write to stderr too, and a line that is written in pieces would mix with theirs.
pub fn complain(line: Arguments<'_>) {
    // A closed stderr leaves no place for a message.
    let _ = io::stderr().write_all(format!("catamaran: {line}\n").as_bytes());
}

/// Prints a note on stderr, in one write like [`complain`].
pub fn note(line: Arguments<'_>) {
    if VOLUME.load(Ordering::Relaxed) < SILENT {
        // A closed stderr leaves no place for a message.
        let _ = io::stderr().write_all(format!("note: {line}\n").as_bytes());
    }
}

/// Returns the text of an error with its context. An error of the library already contains the text
/// of its sources, and names the library's option for the memory of a file, and its arguments, in
/// whose place the text has those of the command line.
pub fn message(error: &anyhow::Error) -> String {
    let mut message = String::new();
    for cause in error.chain() {
        if !message.is_empty() {
            message += ": ";
        }
        if let Some(error) = cause.downcast_ref::<catamaran::Error>() {
            message += &arguments::message(error);
            break;
        }
        message += &cause.to_string();
    }
    with_flags(&message.replace(LARGER_MAX_MEMORY, "a larger --input-limit allows it"))
}

/// Replaces the options that messages of the library name, as in "option `missing_words`", by those
/// of the command line.
fn with_flags(message: &str) -> String {
    let mut parts = message.split("option `");
    let mut found = parts.next().unwrap_or_default().to_owned();
    for part in parts {
        match part.split_once('`') {
            Some(("header", rest)) => found += &format!("--header or --no-header{rest}"),
            Some(("index", rest)) => found += &format!("--index or --no-index{rest}"),
            Some((name, rest)) => {
                let rest = rest.strip_prefix(" =").unwrap_or(rest);
                found += &format!("--{}{rest}", name.replace('_', "-"));
            }
            None => found += part,
        }
    }
    found
}

/// Formats a time with its unit.
pub fn seconds(time: Duration) -> String {
    match time.as_secs_f64() {
        s if s < 1e-3 => format!("{:.1} us", s * 1e6),
        s if s < 1.0 => format!("{:.1} ms", s * 1e3),
        s => format!("{s:.2} s"),
    }
}

#[cfg(test)]
mod tests {
    use anyhow::Context;

    use super::*;

    #[test]
    fn a_record_is_a_json_object_of_one_line_with_its_name_first() {
        let path = "a \"b\" \\ \t\n\u{e9}\u{1}";
        let fields: &dyn Fn() -> Fields =
            fields!(path = path, count = 3, seconds = 0.1, first = None::<u8>);
        let line = json("samples", fields()).unwrap();
        let text = r#"a \"b\" \\ \t\né\u0001"#;
        assert_eq!(
            line,
            format!(
                r#"{{"record":"samples","path":"{text}","count":3,"seconds":0.1,"first":null}}"#
            )
        );
        let read: Value = serde_json::from_str(&line).unwrap();
        assert_eq!(read["path"], path);
    }

    #[test]
    fn numbers_that_are_not_finite_are_null() {
        let values = [f64::NAN, f64::INFINITY, -1.5];
        let fields: &dyn Fn() -> Fields = fields!(one = f64::NEG_INFINITY, all = values, n = 1e300);
        let line = json("row", fields()).unwrap();
        assert_eq!(line, r#"{"record":"row","one":null,"all":[null,null,-1.5],"n":1e+300}"#);
    }

    #[test]
    fn a_message_about_memory_names_the_option_of_the_command_line() {
        let what = format!("too much: {LARGER_MAX_MEMORY}");
        let error = Err::<(), _>(catamaran::Error::file("a.npy", what)).context("weights");
        let said = message(&error.unwrap_err());
        assert_eq!(said, "weights: a.npy: too much: a larger --input-limit allows it");
    }

    #[test]
    fn a_message_names_the_options_of_the_command_line() {
        let what = "option `missing` = drop, option `missing_words` or option `header` decides";
        let error = anyhow::Error::from(catamaran::Error::file("a.csv", what));
        let said = "a.csv: --missing drop, --missing-words or --header or --no-header decides";
        assert_eq!(message(&error), said);
    }

    #[test]
    fn a_message_has_the_context_and_no_cause_twice() {
        let refused = || io::Error::from(io::ErrorKind::PermissionDenied);
        let cause = refused().to_string();
        let error = Err::<(), _>(catamaran::Error::io("a.npy", refused())).context("weights");
        assert_eq!(message(&error.unwrap_err()), format!("weights: a.npy: {cause}"));
        let error = Err::<(), _>(refused()).context("weights").unwrap_err();
        assert_eq!(message(&error), format!("weights: {cause}"));
    }
}
