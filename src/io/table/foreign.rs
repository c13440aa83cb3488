//! Files that are no tables: recognized so that the error says what they are and what converts
//! them.

use super::message::{excerpt, option};

/// Lines that are looked at.
const LINES: usize = 20;

/// Returns what a text is, and at which line from 1 that shows, if it is no table.
pub(super) fn text(text: &[u8]) -> Option<(usize, String)> {
    let lines: Vec<(usize, &str)> = text
        .split(|&byte| byte == b'\n')
        .enumerate()
        .filter_map(|(i, line)| Some((i + 1, std::str::from_utf8(line).ok()?.trim())))
        .filter(|(_, line)| !line.is_empty() && !line.starts_with('#'))
        .take(LINES)
        .collect();
    let &(first, start) = lines.first()?;
    let begins =
        |word: &str| start.get(..word.len()).is_some_and(|start| start.eq_ignore_ascii_case(word));
    let found = |what: &str| Some((first, what.to_owned()));
    if begins("<!doctype html") || begins("<html") {
        return found("a web page, not a table: save the file that it links to");
    }
    if begins("<?xml") {
        return found("XML, not a table");
    }
    if begins("%PDF-") {
        return found("a PDF, not a table");
    }
    if begins("@relation") {
        let is_data = |line: &[u8]| line.trim_ascii().eq_ignore_ascii_case(b"@data");
        let data = text.split(|&byte| byte == b'\n').position(is_data);
        let (skip, until) =
            (option("skip"), data.map_or(String::new(), |i| format!(" = {}", i + 1)));
        return Some((first, format!("ARFF: {skip}{until} leaves out the lines up to @data")));
    }
    if is_json(start) {
        return found(
            "JSON or a printed array, not a table: numpy.savetxt, numpy.save or pandas' to_csv \
             writes a file that is read",
        );
    }
    if let Some((number, rule)) = lines.iter().take(3).find(|(_, line)| is_rule(line)) {
        let rule = excerpt(rule.as_bytes());
        return Some((
            *number,
            format!(
                "{rule} is a line between the rows of a printed table: `psql --csv`, `mysql \
                 --batch` or pandas' to_csv writes a file that is read"
            ),
        ));
    }
    if is_svmlight(&lines) {
        return found(
            "pairs of an index and a value, as libsvm (svmlight) has them, which are not read: \
             sklearn.datasets.load_svmlight_file reads them, and scipy.sparse.save_npz writes an \
             .npz that is",
        );
    }
    if lines.iter().all(|(_, line)| is_vowpal(line)) {
        return found("names and values as Vowpal Wabbit has them, which are not read");
    }
    None
}

/// Returns what a file with zero bytes is.
pub(super) fn binary(head: &[u8]) -> String {
    const KINDS: [(usize, &[u8], &str); 11] = [
        (0, b"\xd0\xcf\x11\xe0", "an Excel workbook (.xls): save a sheet as CSV"),
        (0, b"$FL2", "a file of SPSS: write.csv(haven::read_sav(FILE), ...) in R writes a table"),
        (0, b"$FL3", "a file of SPSS: write.csv(haven::read_sav(FILE), ...) in R writes a table"),
        (
            0,
            b"<stata_dta>",
            "a file of Stata: its export delimited, or pandas.read_stata, writes a table",
        ),
        (
            12,
            b"\xc2\xea\x81\x60",
            "a file of SAS: pandas.read_sas(FILE).to_csv(...) writes a table",
        ),
        (0, b"X\n\0", "a file of R (.rds): write.csv(readRDS(FILE), ...) writes a table"),
        (0, b"RDX", "a file of R (.RData): load(FILE) and write.csv write a table"),
        (
            0,
            b"SQLite format 3\0",
            "a database of SQLite: sqlite3 -header -csv FILE 'select ...' writes a table",
        ),
        (257, b"ustar", "a tar archive: unpack it first"),
        (0, b"\xff\xff\xff\xff", "a stream of Arrow: pyarrow.feather.write_feather writes a file"),
        (0, b"ORC", "ORC: pyarrow.parquet.write_table writes a file that is read"),
    ];
    let is_kind = |(at, magic, _): &&(usize, &[u8], &str)| {
        head.get(*at..).is_some_and(|head| head.starts_with(magic))
    };
    match KINDS.iter().find(is_kind) {
        Some((.., kind)) => (*kind).into(),
        None if matches!(head, [0x80, 2..=5, ..]) => {
            "a pickle of Python: to_csv or numpy.save writes a file that is read".into()
        }
        None if is_utf32(head) => {
            "text in UTF-32, which is not read: iconv -t utf-8 writes text that is".into()
        }
        None => "not text: it has a zero byte".into(),
    }
}

/// Returns whether characters have four bytes each, or were two in UTF-16, whose mark is the start
/// of that of UTF-32.
fn is_utf32(head: &[u8]) -> bool {
    let is_text = |a: u8, b: u8| a.is_ascii_graphic() && b.is_ascii() && b != 0;
    match *head {
        [0, a, 0, b, 0, ..] if a != 0 => is_text(a, b),
        [a, 0, 0, 0, b, 0, 0, 0, ..] | [0, 0, 0, a, 0, 0, 0, b, ..] => is_text(a, b),
        _ => false,
    }
}

/// Returns whether a line begins an array of JSON, of Python or of numpy, or an object.
fn is_json(line: &str) -> bool {
    let (Some(first), rest) = (line.chars().next(), line.get(1..).unwrap_or_default()) else {
        return false;
    };
    let second = rest.trim_start().chars().next();
    match (first, second) {
        ('{', Some('"' | '\'')) | ('[', Some('[' | '{' | '"')) => true,
        ('[', Some('0'..='9' | '-' | '+' | '.')) => line.trim_end_matches(',').ends_with(']'),
        _ => false,
    }
}

/// Returns whether a line is drawn of signs.
fn is_rule(line: &str) -> bool {
    line.contains("---")
        && line.contains(['+', '|'])
        && line.chars().all(|c| matches!(c, '+' | '-' | '|' | ':' | ' '))
}

/// Returns whether rows are a label, or several between commas, and pairs `index:value` in the
/// order of their indices, of which some are no times of day.
fn is_svmlight(lines: &[(usize, &str)]) -> bool {
    let is_number = |text: &str| text.parse::<f64>().is_ok();
    let (mut pairs, mut times) = (0, 0);
    for (_, line) in lines {
        let line = line.split('#').next().unwrap_or_default();
        let mut tokens = line.split_whitespace();
        if !tokens.next().is_some_and(|label| label.split(',').all(is_number)) {
            return false;
        }
        let mut last = None;
        for (place, token) in tokens.enumerate() {
            let Some((index, value)) = token.split_once(':') else { return false };
            if !is_number(value) {
                return false;
            }
            if place == 0 && index == "qid" {
                continue;
            }
            match index.parse::<u64>() {
                Ok(index) if last.is_none_or(|last| index > last) => last = Some(index),
                _ => return false,
            }
            let is_minute = value.len() == 2 && value.parse::<u8>().is_ok_and(|v| v < 60);
            times += usize::from(is_minute && last < Some(24));
            pairs += 1;
        }
    }
    pairs > times
}

/// Returns whether a line is a label, a bar and names, of which some have values.
fn is_vowpal(line: &str) -> bool {
    let Some((label, features)) = line.split_once('|') else { return false };
    let is_number = |text: &str| text.parse::<f64>().is_ok();
    let is_value = |token: &str| token.split_once(':').is_some_and(|(_, value)| is_number(value));
    // The first word behind the bar is the name of a space, which begins there.
    let begins = features.starts_with(|c: char| c.is_alphabetic());
    label.split_whitespace().next().is_some_and(is_number)
        && begins
        && features.split_whitespace().skip(1).any(is_value)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn texts_that_are_no_tables_are_recognized() {
        for (given, line, part) in [
            ("1 1:1.5 2:2\n-1 1:3.5\n1\n", 1, "load_svmlight_file"),
            ("# x\n\n+1 3:1 10:1 # y\n-1 4:1\n", 3, "libsvm"),
            ("1 qid:1 1:1.5 2:2\n2 qid:1 2:5\n", 1, "libsvm"),
            ("1,3 1:0.1 2:1\n2 1:0.2\n", 1, "libsvm"),
            ("1 |f a:1 b:2\n-1 |f a:3\n", 1, "Vowpal Wabbit"),
            ("[[1.5 2. ]\n [3.5 5. ]]\n", 1, "numpy.savetxt"),
            ("[1.5, 2],\n[3.5, 5]\n", 1, "JSON"),
            ("{\"a\": 1}\n", 1, "JSON"),
            ("\n<!DOCTYPE HTML>\n", 2, "web page"),
            ("<?xml version='1.0'?>\n", 1, "XML"),
            ("%PDF-1.4\n", 1, "PDF"),
            ("% x\n@relation r\n@attribute a numeric\n@DATA\n1\n", 1, ""),
            ("@relation r\n@attribute a numeric\n@DATA\n1\n", 1, "option `skip` = 3 leaves"),
            (" a | b\n---+---\n 1 | 2\n", 2, "`psql --csv`"),
            ("+---+---+\n| a | b |\n+---+---+\n", 1, "mysql"),
            ("| a | b |\n|---|:--|\n| 1 | 2 |\n", 2, "printed table"),
        ] {
            match text(given.as_bytes()) {
                Some((at, what)) => {
                    assert!(at == line && what.contains(part), "{given}: {at}: {what}");
                }
                None => assert_eq!(part, "", "{given}"),
            }
        }
    }

    #[test]
    fn tables_are_taken_for_no_other_file() {
        for table in [
            "1,2\n3,4\n",
            "a,b\n1,2\n",
            "1.5 12:30\n2.5 13:45\n",
            "1 2:1 1:5\n",
            "1 a:2\n",
            "1|2\n3|4\n",
            "1 | 2:30\n",
            "     [,1] [,2]\n[1,] 1 2\n[2,] 3 4\n",
            "[1] 1 2 3\n",
            "---,+\n1,2\n",
            "-|-\n1|2\n",
            "",
            "# only\n",
        ] {
            assert_eq!(text(table.as_bytes()), None, "{table}");
        }
    }

    #[test]
    fn binary_files_are_named() {
        for (head, part) in [
            (&b"\xd0\xcf\x11\xe0\xa1\0"[..], ".xls"),
            (b"X\n\0\0\0\x03", "readRDS"),
            (b"\x80\x04\x95\0", "pickle"),
            (b"\0a\0,\0b\0", "UTF-32"),
            (b"a\0\0\0,\0\0\0", "UTF-32"),
            (b"\0\0\0a\0\0\0,", "UTF-32"),
            (&[&[b'a'; 257][..], b"ustar\0"].concat(), "tar archive"),
            (b"1,2\n3\0,4", "not text: it has a zero byte"),
        ] {
            assert!(binary(head).contains(part), "{head:?}: {}", binary(head));
        }
    }
}
