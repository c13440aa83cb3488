//! What pandas writes about the index of a frame. Source: "Developer: metadata" of pandas' guide.

/// The key of pandas' metadata in Parquet and Arrow files.
pub const KEY: &str = "pandas";

/// Returns the columns that are the index of a frame, as the metadata, JSON, say; none where the
/// index is a range, and where the metadata are of another form.
pub fn index_columns(metadata: &str) -> Vec<String> {
    const LIST: &str = "\"index_columns\"";
    let after = |text: &'_ str, start: &str| -> Option<usize> {
        let rest = text.trim_start();
        rest.starts_with(start).then(|| text.len() - rest.len() + start.len())
    };
    let Some(at) = metadata.find(LIST) else { return Vec::new() };
    let mut rest = &metadata[at + LIST.len()..];
    for start in [":", "["] {
        let Some(at) = after(rest, start) else { return Vec::new() };
        rest = &rest[at..];
    }
    let mut names = Vec::new();
    while let Some(at) = after(rest, "\"") {
        let Some((name, end)) = string(&rest[at..]) else { return Vec::new() };
        names.push(name);
        rest = &rest[at + end..];
        match after(rest, ",") {
            Some(at) => rest = &rest[at..],
            None => break,
        }
    }
    // The list has nothing else.
    if after(rest, "]").is_some() { names } else { Vec::new() }
}

/// Returns a string of JSON without the quote before it, and its bytes with the quote behind it.
fn string(text: &str) -> Option<(String, usize)> {
    let mut units = Vec::new();
    let mut chars = text.char_indices();
    loop {
        let (at, c) = chars.next()?;
        let unit = match c {
            '"' => return Some((String::from_utf16(&units).ok()?, at + 1)),
            '\\' => match chars.next()?.1 {
                'u' => {
                    let digits = text.get(at + 2..at + 6)?;
                    chars = text.char_indices();
                    chars.find(|&(i, _)| i == at + 5)?;
                    units.push(u16::from_str_radix(digits, 16).ok()?);
                    continue;
                }
                'n' => '\n',
                't' => '\t',
                'r' => '\r',
                'b' => '\u{8}',
                'f' => '\u{c}',
                other => other,
            },
            c => c,
        };
        units.extend_from_slice(unit.encode_utf16(&mut [0; 2]));
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn names_of_the_index_are_found_in_the_metadata_of_pandas() {
        let range = r#"{"index_columns": [{"kind": "range", "name": null, "start": 0}]}"#;
        let escaped = r#"{"index_columns":["a \"b\"", "\u00e9\ud83d\ude00"] , "columns": []}"#;
        for (metadata, expected) in [
            (r#"{"index_columns": ["key"], "columns": [{"name": "x"}]}"#, &["key"][..]),
            (escaped, &["a \"b\"", "\u{e9}\u{1f600}"]),
            (r#"{"index_columns": [], "columns": ["x"]}"#, &[]),
            (range, &[]),
            (r#"{"index_columns": ["key", {"kind": "range"}]}"#, &[]),
            (r#"{"index_columns": ["key"#, &[]),
            ("{}", &[]),
        ] {
            assert_eq!(index_columns(metadata), expected, "{metadata}");
        }
    }
}
