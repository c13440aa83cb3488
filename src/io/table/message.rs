//! Parts of messages.

use std::path::Path;

use super::encoding;
use crate::base::Error;
use crate::io::source::error;

/// Characters of a field or a row in a message.
const EXCERPT: usize = 30;

/// Returns an option for a message. The command line writes its own names of options in the place
/// of these.
pub(in crate::io) fn option(name: &str) -> String {
    format!("option `{name}`")
}

/// Returns the beginning of a field or a row in quotes, for a message of one line.
pub(super) fn excerpt(field: &[u8]) -> String {
    let text = encoding::text(field);
    match text.char_indices().nth(EXCERPT) {
        Some((end, _)) => format!("{:?}", format!("{}...", &text[..end])),
        None => format!("{text:?}"),
    }
}

/// Returns a number of fields for a message.
pub(super) fn fields(count: usize) -> String {
    match count {
        1 => "1 field".into(),
        count => format!("{count} fields"),
    }
}

/// Returns the error for a table without rows, behind so many lines.
pub(super) fn no_rows(path: &Path, lines: usize, dropped: u64) -> Error {
    let what = match dropped {
        0 => "the file ends without a row of numbers".into(),
        rows => {
            let columns = option("columns");
            format!("each of its {rows} rows has a missing cell; {columns} leaves columns out")
        }
    };
    error(path, lines + 1, what)
}
