//! Help texts of at most [`COLUMNS`] columns. clap wraps no lines without its feature `wrap_help`,
//! which needs another package.

use clap::Command;
use clap::error::ErrorKind;

/// Columns of a line of help at most.
const COLUMNS: usize = 100;

/// Returns an error of clap that prints help with wrapped lines, and any other as it is.
pub fn wrapped(error: clap::Error) -> clap::Error {
    let words: &[&str] = match error.kind() {
        ErrorKind::DisplayHelp => &["catamaran", "--help"],
        ErrorKind::DisplayHelpOnMissingArgumentOrSubcommand => &["catamaran"],
        _ => return error,
    };
    let text = error.render().ansi().to_string();
    let lines: Vec<String> = text.lines().map(wrap).collect();
    // An error with this text: clap chooses the stream, the exit code and whether to use colours.
    let command = Command::new("catamaran").arg_required_else_help(true);
    let printed = command.override_help(lines.join("\n")).try_get_matches_from(words);
    printed.err().unwrap_or(error)
}

/// Returns a line in lines of at most [`COLUMNS`] columns, where its words allow it.
fn wrap(line: &str) -> String {
    let indent = indent(line).min(COLUMNS / 2);
    let (mut text, mut column) = (String::new(), 0);
    for word in line.split_inclusive(' ') {
        let width = columns(word.trim_end());
        if width > 0 && column > indent && column + width > COLUMNS {
            text.truncate(text.trim_end().len());
            text.push('\n');
            text.push_str(&" ".repeat(indent));
            column = indent;
        }
        text.push_str(word);
        column += columns(word);
    }
    text
}

/// Returns the column in which a line goes on: that of its text, after the name of an option, the
/// dash of a value or the word before a usage.
fn indent(line: &str) -> usize {
    let text = line.trim_start_matches(' ');
    let start = line.len() - text.len();
    match text.split_once("  ") {
        Some((name, rest)) => {
            let gap = 2 + rest.len() - rest.trim_start_matches(' ').len();
            start + columns(name) + gap
        }
        None if text.starts_with("- ") => start + "- ".len(),
        None if text.contains("Usage:") => start + "Usage: ".len(),
        None => start,
    }
}

/// Returns the number of columns of a text, without those of styles (`ESC [ ... m`).
fn columns(text: &str) -> usize {
    let (mut count, mut is_style) = (0, false);
    for c in text.chars() {
        match c {
            '\x1b' => is_style = true,
            'm' if is_style => is_style = false,
            _ if is_style => (),
            _ => count += 1,
        }
    }
    count
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn lines_go_on_below_their_text() {
        let words = "word ".repeat(30);
        for (begin, column) in [
            ("          ", 10),
            ("      --quiet              ", 27),
            ("          - winograd: ", 12),
            ("\x1b[1m\x1b[4mUsage:\x1b[0m ", 7),
            ("  \x1b[1m-h\x1b[0m, \x1b[1m--help\x1b[0m  ", 14),
            ("", 0),
        ] {
            let text = wrap(&format!("{begin}{words}"));
            let lines: Vec<&str> = text.lines().collect();
            assert!(lines.len() > 1, "{text}");
            for line in &lines[1..] {
                assert_eq!(line.len() - line.trim_start().len(), column, "{text}");
            }
            assert!(lines.iter().all(|line| columns(line) <= COLUMNS), "{text}");
            // The next word of a line does not fit.
            assert!(columns(lines[0]) + " word".len() > COLUMNS, "{text}");
            assert_eq!(text.matches("word").count(), 30, "{text}");
        }
    }

    #[test]
    fn lines_that_fit_and_words_that_do_not_stay_as_they_are() {
        let (short, long) = ("  ata        Compute  A", format!("    {}", "x".repeat(200)));
        assert_eq!(wrap(short), short);
        assert_eq!(wrap(&long), long);
    }

    #[test]
    fn help_is_printed_where_clap_would_print_it() {
        for (words, is_error) in [(&["x", "--help"][..], false), (&["x"][..], true)] {
            let command = Command::new("x").about("word ".repeat(30)).arg_required_else_help(true);
            let plain = command.try_get_matches_from(words).unwrap_err();
            assert!(plain.to_string().lines().any(|line| line.len() > COLUMNS), "{plain}");
            let kind = plain.kind();
            let wrapped = wrapped(plain);
            assert_eq!((wrapped.kind(), wrapped.use_stderr()), (kind, is_error));
            assert!(wrapped.to_string().lines().all(|line| line.len() <= COLUMNS), "{wrapped}");
        }
    }
}
