//! Tests of whole tables: those that people have, and generated dialects.

use std::io::Write as _;
use std::path::Path;

use faer::{Mat, mat};
use proptest::prelude::*;

use super::*;
use crate::base::{Error, Par};
use crate::io::tests::{Folder, doubles, npy};
use crate::io::{Columns, FileContent, FileFormat, Matrix, ReadOptions, TableFile, read_file};
use crate::rows::RowBlocks;

fn options(table: TableOptions) -> ReadOptions<'static> {
    ReadOptions::new().table(table)
}

fn auto() -> ReadOptions<'static> {
    ReadOptions::new()
}

/// Reads a table, and checks that it is the same by blocks.
fn content(text: impl AsRef<[u8]>, options: &ReadOptions<'_>) -> Result<FileContent, Error> {
    let folder = Folder::new();
    let path = folder.file("a.csv", text);
    let content = read_file(&path, options);
    let file = TableFile::open(&path, options);
    match (&content, file) {
        (Ok(content), Ok(Some(mut file))) => {
            let shape = (content.matrix.nrows(), content.matrix.ncols());
            assert_eq!((file.nrows(), file.ncols()), shape);
            assert_eq!(Some(file.reading()), content.reading.as_ref());
            let mut blocks = Mat::<f64>::zeros(shape.0, shape.1);
            for first in (0..shape.0).step_by(3).rev() {
                let count = 3.min(shape.0 - first);
                file.read(first, blocks.as_mut().subrows_mut(first, count)).unwrap();
            }
            same(&blocks, &doubles(&content.matrix));
        }
        (Err(_), Err(_)) | (_, Ok(None)) => {}
        // The entries are read later. A reader that failed fails again.
        (Err(e), Ok(Some(mut file))) => {
            let mut blocks = Mat::<f64>::zeros(file.nrows(), file.ncols());
            assert_eq!(file.read(0, blocks.as_mut()).unwrap_err(), *e);
            assert_eq!(file.read(0, blocks.as_mut()).unwrap_err(), *e);
        }
        (Ok(_), Err(e)) => panic!("{e}"),
    }
    content
}

fn same(a: &Mat<f64>, b: &Mat<f64>) {
    assert_eq!(a.shape(), b.shape());
    for j in 0..a.ncols() {
        for i in 0..a.nrows() {
            let (x, y) = (a[(i, j)], b[(i, j)]);
            assert!(x == y || x.is_nan() && y.is_nan(), "{x} and {y} at {i}, {j}");
        }
    }
}

/// Checks the numbers and the names of a table, and returns what was decided.
fn check(
    text: impl AsRef<[u8]>,
    options: &ReadOptions<'_>,
    rows: &[&[f64]],
    names: &[&str],
) -> TableReading {
    let shown = String::from_utf8_lossy(text.as_ref()).into_owned();
    let content = content(text, options).unwrap_or_else(|e| panic!("{shown:?}: {e}"));
    let ncols = rows.first().map_or(0, |row| row.len());
    let expected = Mat::from_fn(rows.len(), ncols, |i, j| rows[i][j]);
    same(&doubles(&content.matrix), &expected);
    assert_eq!(content.names, names, "{shown:?}");
    content.reading.unwrap()
}

/// Checks that a table is refused at a line, by a message with these parts.
fn refused(text: &str, options: &ReadOptions<'_>, line: usize, parts: &[&str]) {
    let error = content(text, options).map(|content| content.reading).unwrap_err();
    let said = error.to_string();
    assert!(said.contains(&format!("a.csv:{line}: ")), "{text:?}: {said}");
    assert!(parts.iter().all(|part| said.contains(part)), "{text:?}: {said}");
}

const SMALL: &[&[f64]] = &[&[1.0, 2.0], &[3.0, 5.0], &[4.0, 4.0]];

#[test]
fn numbers_with_thousands_separators_need_an_option() {
    let text = "pop,area\n\"10,000\",\"5,500\"\n\"12,500\",\"6,100\"\n";
    refused(text, &auto(), 2, &["column 1", "\"10,000\"", "`thousands`", "`decimal`"]);
    let rows: &[&[f64]] = &[&[10_000.0, 5500.0], &[12_500.0, 6100.0]];
    let thousands = options(TableOptions::new().thousands(','));
    let reading = check(text, &thousands, rows, &["pop", "area"]);
    assert!(reading.to_string().contains("thousands comma"), "{reading}");
    let rows: &[&[f64]] = &[&[10.0, 5.5], &[12.5, 6.1]];
    check(text, &options(TableOptions::new().decimal(',')), rows, &["pop", "area"]);
    // Both signs in a number decide.
    check(
        "x;y\n\"1,299.99\";3\n\"12,000\";5\n",
        &auto(),
        &[&[1299.99, 3.0], &[12_000.0, 5.0]],
        &["x", "y"],
    );
}

#[test]
fn numbers_that_may_be_names_need_an_option() {
    let text = "400,410,420\n0.10,0.20,0.30\n0.11,0.25,0.28\n";
    refused(text, &auto(), 1, &["names of columns or the first row of numbers", "`header`"]);
    let rows: &[&[f64]] = &[&[400.0, 410.0, 420.0], &[0.10, 0.20, 0.30], &[0.11, 0.25, 0.28]];
    let header = |header| options(TableOptions::new().header(header));
    check(text, &header(true), &rows[1..], &["400", "410", "420"]);
    check(text, &header(false), rows, &[]);
    refused("1990,1991\n5,7\n6,9\n", &auto(), 1, &["`header`"]);
    refused("1990,1991,1992\n1200,1900,1700\n1300,1800,1500\n", &auto(), 1, &["`header`"]);
    let years = |i: usize| format!("{},{}\n", 1200 + 37 * i % 100, 1900 - 41 * i % 100);
    let years: String = (0..25).map(years).collect();
    refused(&format!("1990,1991\n{years}"), &auto(), 1, &["`header`"]);
    refused("10,20,30\n1,2,3\n4,5,7\n", &auto(), 1, &["`header`"]);
    check("10,20,30\n40,50,60\n", &auto(), &[&[10.0, 20.0, 30.0], &[40.0, 50.0, 60.0]], &[]);
    // Numbers like those below them are numbers, and so are those at the end of a sorted column.
    let sorted = |i: usize| format!("{},{}\n", i + 1, 100 + i * i);
    let sorted: String = (0..25).map(sorted).collect();
    assert_eq!(content(format!("0,99\n{sorted}"), &auto()).unwrap().matrix.nrows(), 26);
    check("1,2\n3,4\n5,6\n", &auto(), &[&[1.0, 2.0], &[3.0, 4.0], &[5.0, 6.0]], &[]);
    check("1,2\n3,5\n4,4\n", &auto(), SMALL, &[]);
}

#[test]
fn a_first_row_that_counts_the_columns_needs_an_option() {
    let counted = |first: usize, n: usize| {
        (first..first + n).map(|j| j.to_string()).collect::<Vec<_>>().join(",") + "\n"
    };
    let rows = |m: usize, n: usize, entry: &dyn Fn(usize, usize) -> String| -> String {
        let row = |i: usize| (0..n).map(|j| entry(i, j)).collect::<Vec<_>>().join(",") + "\n";
        (0..m).map(row).collect()
    };
    let noise = |i: usize, j: usize| (i * 7919 + j * 104_729 + i * i * j) % 997;
    let fraction = |i: usize, j: usize| format!("{:.3}", noise(i, j) as f64 / 10.0 + 0.001);
    let byte = |i: usize, j: usize| (noise(i, j) % 256).to_string();
    for first in [0, 1] {
        for (m, n) in [(1, 4), (2, 4), (3, 20), (12, 2), (8, 3), (1000, 20)] {
            let text = counted(first, n) + &rows(m, n, &fraction);
            refused(&text, &auto(), 1, &["names of columns", "`header`"]);
        }
        refused(&(counted(first, 50) + &rows(9, 50, &byte)), &auto(), 1, &["`header`"]);
    }
    // As the start of a curve, or as rows that count on.
    for text in [
        "0,1\n0.1,0.995\n0.2,0.980\n0.3,0.955\n".to_owned(),
        "0,1,2\n0.1,1.2,1.9\n0.2,1.3,1.7\n".into(),
        rows(30, 5, &|i, j| (5 * i + j).to_string()),
        rows(30, 5, &|i, j| (i + j).to_string()),
    ] {
        assert_eq!(content(&text, &auto()).unwrap().matrix.nrows(), text.lines().count(), "{text}");
    }
}

#[test]
fn a_word_makes_a_header_of_years() {
    let text = "sample,400,410\ns1,0.10,0.20\ns2,0.11,0.25\n";
    let rows: &[&[f64]] = &[&[0.10, 0.20], &[0.11, 0.25]];
    let reading = check(text, &auto(), rows, &["400", "410"]);
    assert!(reading.header && reading.left_out == ["sample"], "{reading}");
    check(text, &auto().columns(1..3), rows, &["400", "410"]);
    check(
        text,
        &auto().columns(Columns::parse("410,400")),
        &[&[0.2, 0.1], &[0.25, 0.11]],
        &["410", "400"],
    );
    let by_hand = "Country,1990,1991\nAT,1,2\nDE,3,4\n";
    check(by_hand, &auto(), &[&[1.0, 2.0], &[3.0, 4.0]], &["1990", "1991"]);
    // Words above words, an index without a name, a year without numbers.
    let nan = options(TableOptions::new().missing(Missing::Nan));
    let rows: &[&[f64]] = &[&[1.0, 2.0, f64::NAN], &[3.0, 4.0, f64::NAN]];
    for text in
        ["name,1990,1991,1992\nAT,1,2,\nDE,3,4,\n", ",name,1990,1991,1992\n0,AT,1,2,\n1,DE,3,4,\n"]
    {
        check(text, &nan, rows, &["1990", "1991", "1992"]);
    }
}

#[test]
fn words_in_columns_of_words_do_not_make_a_header_of_numbers() {
    let text = "5.1,3.5,setosa\n4.9,3.0,setosa\n7.0,3.2,versicolor\n";
    let reading = check(text, &auto(), &[&[5.1, 3.5], &[4.9, 3.0], &[7.0, 3.2]], &[]);
    assert_eq!(reading.left_out, ["2"]);
    refused("5.1,3.5,one\n4.9,3.0,two\n7.0,3.2,three\n", &auto(), 1, &["`header`"]);
}

#[test]
fn row_numbers_are_left_out() {
    let rows: &[&[f64]] = &[&[1.5, 2.0], &[3.5, 5.0]];
    for text in [
        "\"x\" \"y\"\n\"1\" 1.5 2\n\"2\" 3.5 5\n",
        "\"x\" \"y\"\n\"a b\" 1.5 2\n\"c\" 3.5 5\n",
        "\"x\" \"y\"\n\"1947\" 1.5 2\n\"1949\" 3.5 5\n",
        "\"\",\"x\",\"y\"\n\"1\",1.5,2\n\"2\",3.5,5\n",
        ",x,y\n0,1.5,2\n7,3.5,5\n",
    ] {
        let reading = check(text, &auto(), rows, &["x", "y"]);
        assert!(reading.index && reading.to_string().contains("index column left out"), "{text}");
    }
    let text = ",x\n0,1.5\n7,3.5\n";
    let index = |index| options(TableOptions::new().index(index));
    check(text, &index(false), &[&[0.0, 1.5], &[7.0, 3.5]], &["", "x"]);
    check("i,x\n0,1.5\n7,3.5\n", &index(true), &[&[1.5], &[3.5]], &["x"]);
    let all_quoted = "\"x\",\"y\"\n\"5\",\"1.5\",\"2\"\n\"9\",\"3.5\",\"5\"\n";
    for text in ["x,y\n5,1.5,2\n9,3.5,5\n", all_quoted] {
        refused(text, &auto(), 1, &["`index`", "`skip`"]);
    }
}

#[test]
fn years_above_an_index_without_a_name_or_in_quotes_are_names() {
    let rows: &[&[f64]] = &[&[5.0, 7.0], &[6.0, 9.0]];
    for text in [
        ",1990,1991\nAT,5,7\nDE,6,9\n",
        ",1990,1991\n0,5,7\n1,6,9\n",
        "\"\",\"1990\",\"1991\"\n\"1\",5,7\n\"2\",6,9\n",
        "\"1990\" \"1991\"\n\"AT\" 5 7\n\"DE\" 6 9\n",
        "1990;1991\n1;5;7\n2;6;9\n",
    ] {
        let reading = check(text, &auto(), rows, &["1990", "1991"]);
        assert!(reading.index && reading.has_numbers_in_header, "{text}");
    }
    let reading = check("\"1990\",\"1991\"\n5,7\n6,9\n", &auto(), rows, &["1990", "1991"]);
    assert!(!reading.index, "{reading}");
    // pandas without names of columns.
    check(",0,1\n0,5,7\n1,6,9\n", &auto(), rows, &["0", "1"]);
    refused(",1990,1991\n3,5,7\n5,6,9\n", &auto(), 1, &["column 1: nothing", "`missing`"]);
    refused("1990;1991\n3;5;7\n9;6;9\n", &auto(), 1, &["2 fields in this row", "`header`"]);
    // Where all numbers are in quotes, these say nothing.
    check("\"1\",\"2\"\n\"3\",\"5\"\n\"4\",\"4\"\n", &auto(), SMALL, &[]);
}

#[test]
fn what_no_name_can_be_is_data() {
    let nan = options(TableOptions::new().missing(Missing::Nan));
    let drop = options(TableOptions::new().missing(Missing::Drop));
    let text = "NA,NA\n1,2\n3,5\n4,4\n";
    assert_eq!(check(text, &drop, SMALL, &[]).dropped_rows, 1);
    let missing: &[&[f64]] = &[&[f64::NAN; 2], SMALL[0], SMALL[1], SMALL[2]];
    check(text, &nan, missing, &[]);
    refused(text, &auto(), 1, &["column 1: \"NA\"", "`missing`"]);
    check("0,5;1,25\n1,0;1,75\n", &auto(), &[&[0.5, 1.25], &[1.0, 1.75]], &[]);
    check(" 1.0D+00 2.5D-01\n 3.0D+00 1.0D+01\n", &auto(), &[&[1.0, 0.25], &[3.0, 10.0]], &[]);
    // Names that are words for numbers.
    check("inf,nan\n1,2\n3,5\n4,4\n", &auto(), SMALL, &["inf", "nan"]);
    check("1,-inf\n2,3\n", &auto(), &[&[1.0, f64::NEG_INFINITY], &[2.0, 3.0]], &[]);
}

#[test]
fn rows_with_missing_cells_are_refused_dropped_or_nan() {
    let drop = options(TableOptions::new().missing(Missing::Drop));
    for word in ["NA", "", ".", "NaN", "NULL", "#N/A", "null", "\"\""] {
        let text = format!("x,y\n1,2\n{word},3\n4,5\n");
        refused(&text, &auto(), 3, &["column 1 (x)", "where a number should be", "`missing`"]);
        let reading = check(&text, &drop, &[&[1.0, 2.0], &[4.0, 5.0]], &["x", "y"]);
        assert_eq!(reading.dropped_rows, 1);
        assert!(reading.to_string().contains("1 row with a missing cell left out"), "{reading}");
        // Only the columns that are used count.
        check(&text, &auto().columns(1..2), &[&[2.0], &[3.0], &[5.0]], &["y"]);
    }
    let words = TableOptions::new().missing(Missing::Drop).missing_words(vec!["-999".to_owned()]);
    for missing in ["-999", "-999.0", "-9.99e2"] {
        let text = format!("1,2\n{missing},3\n4,5\n");
        check(text, &options(words.clone()), &[&[1.0, 2.0], &[4.0, 5.0]], &[]);
    }
    check("1;2,5\n-999,00;3\n4;5\n", &options(words.clone()), &[&[1.0, 2.5], &[4.0, 5.0]], &[]);
    // In a file with decimal points, a word with a comma is no number with a decimal comma.
    let comma = TableOptions::new().missing(Missing::Drop).missing_words(vec!["9,5".to_owned()]);
    check("1;2.5\n9.5;3\n4;5\n", &options(comma), &[&[1.0, 2.5], &[9.5, 3.0], &[4.0, 5.0]], &[]);
    let infinity = TableOptions::new().missing(Missing::Drop).missing_words(vec!["inf".to_owned()]);
    check("x,y\n1,2\ninf,3\n4,5\n", &options(infinity), &[&[1.0, 2.0], &[4.0, 5.0]], &["x", "y"]);
    // Errors of spreadsheets are no comments.
    for word in ["#DIV/0!", "#VALUE!", "#NAME?", "#NV"] {
        let text = format!("x,y\n1,2\n{word},3\n4,5\n");
        refused(&text, &auto(), 3, &[word, "`missing_words`"]);
        let drop = TableOptions::new().missing(Missing::Drop).missing_words(vec![word.to_owned()]);
        check(&text, &options(drop), &[&[1.0, 2.0], &[4.0, 5.0]], &["x", "y"]);
    }
    refused("1,2\nNA,3\n4,5\n", &options(words), 2, &["\"NA\" is not a number"]);
    let none = content("x\nNA\nNA\nNA\n", &drop).map(drop_reading).unwrap_err().to_string();
    assert!(none.contains("each of its 3 rows has a missing cell"), "{none}");
    assert!(none.contains("`columns`"), "{none}");
}

fn drop_reading(content: FileContent) -> Option<TableReading> {
    content.reading
}

#[test]
fn other_notations_are_read_when_the_file_decides() {
    let names = ["zeit", "druck"];
    let rows: &[&[f64]] = &[&[0.0, 1.25], &[1.5, 2.5]];
    let reading = check("zeit;druck\n0;1,25\n1,5;2,5\n", &auto(), rows, &names);
    assert_eq!(reading.to_string(), "separator ;, decimal comma, header");
    assert!(!reading.is_plain());
    let text = "produkt;preis;menge\n1;1.299,99;3\n2;899,50;5\n";
    let rows: &[&[f64]] = &[&[1299.99, 3.0], &[899.5, 5.0]];
    check(text, &auto().columns(1..3), rows, &["preis", "menge"]);
    check("a b\n=\"1\" \"2\"\n", &auto(), &[&[1.0, 2.0]], &["a", "b"]);
    check("a;b\n\"1e5\";\"2,5\"\n", &auto(), &[&[1e5, 2.5]], &["a", "b"]);
    check("sep=;\nx;y\n1;2\n", &auto(), &[&[1.0, 2.0]], &["x", "y"]);
    // Thin blanks, the minus sign of typesetters, Fortran's exponents of three digits.
    let rows: &[&[f64]] = &[&[1234.0, -2.5], &[12345.0, 1.5]];
    for blank in ["\u{a0}", "\u{2007}", "\u{2009}", "\u{202f}"] {
        let text = format!("a;b\n1{blank}234;\u{2212}2,5\n12{blank}345;1,5\n");
        check(text, &auto(), rows, &["a", "b"]);
    }
    check(b"a;b\n1\xa0234;-2,5\n12\xa0345;1,5\n", &auto(), rows, &["a", "b"]);
    let rows: &[&[f64]] = &[&[1.5e-101, 0.2], &[3.0, 5.0]];
    check("1.5-101 2.0-001\n3.0+000 5.0+000\n", &auto(), rows, &[]);
    check("1e5,2E-1\n3d2,4\n", &auto(), &[&[1e5, 0.2], &[300.0, 4.0]], &[]);
    check("x\n0,5\n2,05\n", &auto(), &[&[0.5], &[2.05]], &["x"]);
    // One column below its name, or two below a title.
    for text in ["x\n0,5\n2,25\n", "Made by hand\n0,5\n2,25\n"] {
        refused(text, &auto(), 2, &["\"0,5\"", "`decimal`", "`skip` = 1"]);
        let commas = options(TableOptions::new().decimal(','));
        let name = text.lines().next().unwrap();
        check(text, &commas, &[&[0.5], &[2.25]], &[name]);
        check(text, &options(TableOptions::new().skip(1)), &[&[0.0, 5.0], &[2.0, 25.0]], &[]);
    }
    let nan = options(TableOptions::new().missing(Missing::Nan));
    let rows: &[&[f64]] = &[&[6.5], &[2.25], &[0.5], &[f64::NAN], &[7.0]];
    check("x\n6,5\n2,25\n0,5\n\"\"\n7\n", &nan, rows, &["x"]);
    refused("x\n1,5\n2,25\n", &auto(), 2, &["`index`", "`decimal`"]);
    refused("x\n5,000\n2,500\n", &auto(), 2, &["\"5,000\" is 5 with", "5000", "`thousands`"]);
    check("x\n1,5\n2,25\n", &options(TableOptions::new().decimal(',')), &[&[1.5], &[2.25]], &["x"]);
    // One column with points between thousands, or two columns.
    for text in ["1.234,50\n2.500,75\n", "999,5\n-1.234,50\n"] {
        refused(
            text,
            &auto(),
            text.lines().position(|l| l.contains('.')).unwrap() + 1,
            &["1.234,50\" is two numbers", "`separator`", "`decimal`"],
        );
    }
    let (commas, by_commas) =
        (TableOptions::new().decimal(','), TableOptions::new().separator(Separator::Char(',')));
    let text = "1.234,50\n2.500,75\n";
    check(text, &options(commas), &[&[1234.5], &[2500.75]], &[]);
    check(text, &options(by_commas), &[&[1.234, 50.0], &[2.5, 75.0]], &[]);
    check("1.234.567,89\n2,5\n", &auto(), &[&[1_234_567.89], &[2.5]], &[]);
    check("0.234,5\n2.500,75\n", &auto(), &[&[0.234, 5.0], &[2.5, 75.0]], &[]);
    refused("x\n1.000,5\n2.000,7\n", &auto(), 2, &["\"1.000,5\"", "`decimal`", "`skip` = 1"]);
    // What comes late decides nothing.
    let late = "x;y\n".to_owned() + &"1;2\n".repeat(30_000) + "1,5;2\n";
    refused(&late, &auto(), 30_002, &["\"1,5\"", "`decimal`"]);
    refused("x;y\n0,5;1.25\n", &auto(), 2, &["column 2: \"1.25\"", "`decimal`"]);
}

#[test]
fn words_before_decimal_commas_are_divided_by_their_quotes_or_an_option() {
    let rows: &[&[f64]] = &[&[1.5], &[2.25], &[3.5]];
    for separator in ["|", " ", ";", "\t"] {
        let lines = [("a", "1,5"), ("b", "2,25"), ("c", "3,5")]
            .map(|(word, number)| format!("\"{word}\"{separator}{number}\n"));
        let reading = check("\"x\"\n".to_owned() + &lines.concat(), &auto(), rows, &["x"]);
        assert!(reading.index && reading.decimal == ',', "{reading}");
    }
    let by = |separator: char| options(TableOptions::new().separator(Separator::from(separator)));
    for (text, other) in [("x\na|1,5\nb|2,25\n", '|'), ("x\na 1,5\nb 2,25\n", ' ')] {
        refused(text, &auto(), 2, &["between commas, or between b", "`separator`", "`decimal`"]);
        let commas = options(TableOptions::new().decimal(','));
        for options in [&commas, &by(other)] {
            check(text, options, &[&[1.5], &[2.25]], &["x"]);
        }
        check(text, &by(','), &[&[5.0], &[25.0]], &["x"]);
    }
    refused("Route 66,5\nRoute 7,8\n", &auto(), 1, &["`separator`"]);
    let named = "n,x\nRoute 66,5\nRoute 7,8\n";
    assert_eq!(check(named, &auto(), &[&[5.0], &[8.0]], &["x"]).left_out, ["n"]);
}

#[test]
fn separators_and_comments_of_every_kind_are_read() {
    let names = &["a", "b"][..];
    for text in [
        "a|b\n1|2\n3|5\n4|4\n",
        "a,b,\n1,2,\n3,5,\n4,4,\n",
        "a,b\n1,2,\n3,5,\n4,4,\n",
        "a,b\r1,2\r3,5\r4,4\r",
        "a;b\r\n1;2\r\n3;5\r\n4;4",
        "# a,b\n1.0e+00,2.0e+00\n3.0,5.0\n4.0,4.0\n",
        "a b # names\n1 2 # first\n3 5 # second\n4 4\n",
        "\"a\"\t\"b\"\n1\t2\n3\t5\n4\t4\n",
    ] {
        check(text, &auto(), SMALL, names);
    }
    check("1 2 # first\n3 5 # second\n4 4\n", &auto(), SMALL, &[]);
    check(
        "1\t2 3\n4\t5 6\n7\t8 1\n",
        &auto(),
        &[&[1.0, 2.0, 3.0], &[4.0, 5.0, 6.0], &[7.0, 8.0, 1.0]],
        &[],
    );
    check("1.0, 2.0 # first\n3, 5\n4, 4\n", &auto(), SMALL, &[]);
    check("% a b\n1 2\n", &options(TableOptions::new().comment('%')), &[&[1.0, 2.0]], &["a", "b"]);
    check(
        "a:b\n1:2\n",
        &options(TableOptions::new().separator(Separator::Char(':'))),
        &[&[1.0, 2.0]],
        &["a", "b"],
    );
    // A comma in each number is no separator where the names have another one.
    let reading = check("Name|Wert\nA B|1,5\nC|2,5\n", &auto(), &[&[1.5], &[2.5]], &["Wert"]);
    assert_eq!(reading.left_out, ["Name"]);
    let cities = "city\tpop\nNew York\t8,336,817\nLos Angeles\t3,979,576\n";
    check(cities, &auto(), &[&[8_336_817.0], &[3_979_576.0]], &["pop"]);
    // Separators at the end of some rows, and several at the end of each, as spreadsheets leave
    // them; a text that DOS ended.
    for text in [
        "a,b\n1,2,\n3,5\n4,4,\n",
        "a,b,\n1,2\n3,5\n4,4,\n",
        "a,b,,\n1,2,,\n3,5,,\n4,4,,\n",
        "\"sep=;\"\na;b\n1;2\n3;5\n4;4\n",
        "a,b\r\n1,2\r\n3,5\r\n4,4\r\n\x1a",
    ] {
        check(text, &auto(), SMALL, names);
    }
    let cut = "a,b,,\n".to_owned() + &"1,2,,\n".repeat(1000) + "3,5,7,\n";
    refused(&cut, &auto(), 1002, &["\"7\" behind the separator"]);
    let reading = check("#,a,b\n1,1,2\n", &auto(), &[&[1.0, 1.0, 2.0]], &["#", "a", "b"]);
    assert!(reading.left_out.is_empty());
    // Lines that end in two ways.
    for text in ["1 2\r3 4\n5 6\r7 8\n", "1\r2\n3\r4\n", "a,b\u{2028}1,2\u{2028}3,5\n"] {
        refused(text, &auto(), 1, &["end of a line"]);
    }
    refused("1~2\n3~5\n", &auto(), 2, &["no column of numbers", "`separator`"]);
    let late = "a,b,\n".to_owned() + &"1,2,\n".repeat(1000) + "3,5,7\n";
    refused(&late, &auto(), 1002, &["\"7\" behind the separator"]);
}

#[test]
fn names_may_have_separators() {
    check(
        "\"Height, cm\",\"Weight, kg\"\n170,65\n180,80\n",
        &auto(),
        &[&[170.0, 65.0], &[180.0, 80.0]],
        &["Height, cm", "Weight, kg"],
    );
    check(
        "\"time; s\",\"x\"\n1,2\n2,4.5\n",
        &auto(),
        &[&[1.0, 2.0], &[2.0, 4.5]],
        &["time; s", "x"],
    );
}

#[test]
fn rows_that_are_comments_are_mentioned() {
    let names = &["id", "x"][..];
    let reading = check("id,x\n1,2\n#2,7\n3,5\n4,4\n", &auto(), SMALL, names);
    assert!(!reading.is_plain() && reading.to_string().ends_with("commented rows left out"));
    let all = "id,x\n#1,2\n#3,5\n";
    refused(all, &auto(), 4, &["ends without a row", "`comment`"]);
    let percent = options(TableOptions::new().comment('%'));
    check(all, &percent, &[&[2.0], &[5.0]], &["x"]);
    let reading = check("id x\n1 2\n# twice\n# or more\n3 5\n4 4\n", &auto(), SMALL, names);
    assert!(reading.is_plain(), "{reading}");
    // Behind the beginning that decides how the table is read.
    let has_some = |text: &str, options: &ReadOptions<'_>| {
        content(text, options).unwrap().reading.unwrap().has_commented_rows
    };
    // Before the first row, and in tables of one column.
    let first = "#0.5,2.25\n3,4\n5,7\n6,1\n";
    for text in [first, "\n# by hand\n# 0.5,2.25\n3,4\n5,7\n6,1\n", "#5\n3\n7\n"] {
        assert!(has_some(text, &auto()), "{text:?}");
    }
    for text in ["x\n#5\n3\n7\n", "x\n3\n# 5\n7\n"] {
        assert!(has_some(text, &auto()), "{text:?}");
    }
    assert!(!has_some(first, &options(TableOptions::new().skip(1))));
    // Names, words, and what is above the header.
    for text in ["#a,b\n3,4\n5,7\n", "# by hand\nx\n3\n7\n", "#1,2\na,b\n3,4\n5,6\n"] {
        assert!(!has_some(text, &auto()), "{text:?}");
    }
    let mut text = String::from("x,y\n# 1 and 2\n") + &"1,2\n".repeat(20_000);
    assert!(content(&text, &auto()).unwrap().reading.unwrap().is_plain());
    text.push_str("#3,4\n5,6\n");
    assert!(content(&text, &auto()).unwrap().reading.unwrap().has_commented_rows);
    text.push_str("3,4 # c\n");
    refused(&text, &auto(), 20_005, &["\"4 # c\" is not a number", "`comment` = # ends rows"]);
}

#[test]
fn names_in_quotes_may_be_longer_than_the_beginning_of_a_file() {
    let n = 1200;
    let name = |j: usize| format!("name {j} {}\n(unit)", "x".repeat(45));
    let names: Vec<String> = (0..n).map(name).collect();
    let quoted: Vec<String> = names.iter().map(|name| format!("\"{name}\"")).collect();
    for rows in [3, 60] {
        let mut text = quoted.join(",") + "\n";
        for i in 0..rows {
            let row: Vec<String> = (0..n).map(|j| ((7 * j + 3 * i) % 11).to_string()).collect();
            text += &(row.join(",") + "\n");
        }
        let found = content(&text, &auto()).unwrap();
        assert_eq!((found.matrix.nrows(), &found.names), (rows, &names));
    }
}

#[test]
fn quoted_words_may_be_more_than_numbers() {
    // write.csv of R's warpbreaks, and of a table with a word of several words.
    let text = "\"\",\"breaks\",\"wool\",\"tension\"\n\"1\",26,\"A\",\"L\"\n\"2\",30,\"B\",\"M\"\n";
    let reading = check(text, &auto(), &[&[26.0], &[30.0]], &["breaks"]);
    assert!(reading.index);
    assert_eq!(reading.left_out, ["wool", "tension"]);
    // write.table with decimal commas.
    let text = "\"k\" \"x\" \"y\"\n\"a b\" \"c d\" 66 94,25\n\"e f\" \"g\" 17 2,5\n";
    check(text, &auto(), &[&[66.0, 94.25], &[17.0, 2.5]], &["x", "y"]);
    let text = "\"wool\",\"place\",\"breaks\"\n\"A\",\"New York\",26\n\"B\",\"Ulm\",30\n";
    check(text, &auto(), &[&[26.0], &[30.0]], &["breaks"]);
}

#[test]
fn text_in_other_encodings_is_read() {
    let utf16 = |text: &str| -> Vec<u8> {
        [0xfeff].into_iter().chain(text.encode_utf16()).flat_map(u16::to_le_bytes).collect()
    };
    let reading =
        check(utf16("c1,h\u{f6}he\n1,2\n3,5\n4,4\n"), &auto(), SMALL, &["c1", "h\u{f6}he"]);
    assert_eq!(reading.encoding, "UTF-16LE");
    let reading = check(b"c1,h\xf6he\n1,2\n3,5\n4,4\n", &auto(), SMALL, &["c1", "h\u{f6}he"]);
    assert_eq!(reading.encoding, "windows-1252");
    let latin = options(TableOptions::new().encoding("latin1".to_owned()));
    check(b"c1,h\xf6he\n1,2\n3,5\n4,4\n", &latin, SMALL, &["c1", "h\u{f6}he"]);
    check("\u{feff}c1,c2\n1,2\n3,5\n4,4\n", &auto(), SMALL, &["c1", "c2"]);
}

#[test]
fn lines_at_the_start_may_be_skipped() {
    let skip = |lines| options(TableOptions::new().skip(lines));
    check("Made by hand\n\nx,y\n1,2\n3,5\n4,4\n", &skip(2), SMALL, &["x", "y"]);
    check("x,y\nm,kg\n1,2\n3,5\n4,4\n", &skip(1), SMALL, &["m", "kg"]);
    let reading = check("x,y\nm,kg\n1,2\n3,5\n4,4\n", &skip(2), SMALL, &[]);
    assert!(reading.to_string().contains("2 lines skipped, no header"), "{reading}");
}

#[test]
fn messages_about_lines_above_a_table_show_them() {
    for (text, line, shown) in [
        ("Made by hand\nx,y\n1,2\n3,5\n", 1, "\"Made by hand\""),
        ("Made by hand\nx,y,z\n1,2,3\n3,5,4\n", 1, "\"Made by hand\""),
        ("Sales, made by hand\nx,y,z\n1,2,3\n3,5,4\n", 1, "\"Sales made by hand\""),
        ("x,y\nm,kg\n1,2\n3,5\n", 2, "\"m kg\""),
        ("size,size,mass\nx,y,z\n1,2,3\n4,5,6\n", 2, "\"x y z\""),
        ("Title\nx\n1\n2\n", 2, "\"x\""),
    ] {
        refused(text, &auto(), line, &[shown, "`skip`"]);
    }
}

#[test]
fn the_content_says_what_a_name_does_not() {
    let gzip = |text: &[u8]| {
        let mut packed = flate2::write::GzEncoder::new(Vec::new(), flate2::Compression::fast());
        packed.write_all(text).unwrap();
        packed.finish().unwrap()
    };
    let zip = |text: &[u8]| {
        let mut archive = zip::ZipWriter::new(std::io::Cursor::new(Vec::new()));
        let options = zip::write::SimpleFileOptions::default();
        archive.start_file("a", options).unwrap();
        archive.write_all(text).unwrap();
        archive.finish().unwrap().into_inner()
    };
    let bzip2 = |text: &[u8]| {
        let mut encoder = bzip2::write::BzEncoder::new(Vec::new(), bzip2::Compression::fast());
        encoder.write_all(text).unwrap();
        encoder.finish().unwrap()
    };
    #[cfg(feature = "columnar")]
    let zstd = |text: &[u8]| {
        ruzstd::encoding::compress_to_vec(text, ruzstd::encoding::CompressionLevel::Fastest)
    };
    let folder = Folder::new();
    let text = b"a;b\n1;2\n3;5\n4;4\n";
    let array = npy("<f4", "False", "(1, 2)", &[0; 8]);
    let market = b"%%MatrixMarket matrix array real general\n1 2\n0\n0\n";
    for (name, bytes, rows) in [
        ("table", text.to_vec(), 3),
        ("a.dat", text.to_vec(), 3),
        ("a.asc", text.to_vec(), 3),
        ("a.txt", text.to_vec(), 3),
        ("market.csv", market.to_vec(), 1),
        ("market.txt.gz", gzip(market), 1),
        ("packed", gzip(text), 3),
        ("packed.csv", gzip(text), 3),
        ("packed.dat.gz", gzip(text), 3),
        ("array", array.clone(), 1),
        ("array.dat", gzip(&array), 1),
        ("packed.csv.bz2", bzip2(text), 3),
        ("packed.csv", [bzip2(&text[..7]), bzip2(&text[7..])].concat(), 3),
        ("array.bz2", bzip2(&array), 1),
        ("zipped.csv", zip(text), 3),
        ("zipped.csv.zip", zip(text), 3),
        ("array.zip", zip(&array), 1),
        ("zipped.csv.gz", zip(text), 3),
        #[cfg(feature = "columnar")]
        ("packed.csv.zst", zstd(text), 3),
        #[cfg(feature = "columnar")]
        ("array.gz", zstd(&array), 1),
        ("market", market.to_vec(), 1),
    ] {
        let found = read_file(&folder.file(name, bytes), &auto()).unwrap();
        assert_eq!((found.matrix.nrows(), found.matrix.ncols()), (rows, 2), "{name}");
    }
    let format = auto().format(FileFormat::Table);
    let said = read_file(&folder.file("a.npy", text), &format).map(|found| found.names);
    assert_eq!(said.unwrap(), ["a", "b"]);
    for (name, bytes, why) in [
        ("a.csv", &b"BZh91AY&SY"[..], "a.csv: truncated: the file ends too early"),
        ("a.csv.bz2", text, "a.csv.bz2: is not a .bz2 file"),
        ("a.csv", b"PK\x03\x04....", "a.csv: damaged .zip file"),
        ("a.csv.gz", text, "a.csv.gz: is not a .gz file"),
        #[cfg(not(feature = "columnar"))]
        ("a.csv", b"\x28\xb5\x2f\xfd.....", "build it with --features columnar"),
    ] {
        let path = folder.file(name, bytes);
        let said = read_file(&path, &auto()).unwrap_err().to_string();
        assert!(said.contains(why), "{said}");
        // Whoever reads blocks of rows gets the same, or is sent to that reader.
        match TableFile::open(&path, &auto()) {
            Ok(file) => assert!(file.is_none(), "{name}"),
            Err(e) => assert_eq!(e.to_string(), said),
        }
    }
}

#[test]
fn a_first_row_with_a_number_and_what_is_hardly_a_name_has_two_readings() {
    let cells = [
        "1.5*", "<0.5", "(2)", "$3", "5%", "1.5x10^2", "?", "-", "12:30", "#DIV/0!", "\\N", "n.a.",
    ];
    for cell in cells {
        let text = format!("{cell},2\n3.5,5\n4,4\n6,1\n");
        let both = ["names of columns or the first row", "option `header` decides"];
        refused(&text, &auto(), 1, &both);
        let header = options(TableOptions::new().header(Some(true)));
        let rows: &[&[f64]] = &[&[3.5, 5.0], &[4.0, 4.0], &[6.0, 1.0]];
        check(&text, &header, rows, &[cell, "2"]);
        let no_header = options(TableOptions::new().header(Some(false)));
        refused(&text, &no_header, 1, &["is not a number"]);
        // Beside names it is one, and so are several.
        check(format!("x,{cell}\n3.5,5\n4,4\n6,1\n"), &auto(), rows, &["x", cell]);
        check(format!("{cell},{cell}\n3.5,5\n4,4\n6,1\n"), &auto(), rows, &[cell, cell]);
    }
    let rows: &[&[f64]] = &[&[3.5, 5.0], &[4.0, 4.0], &[6.0, 1.0]];
    check("T2,2\n3.5,5\n4,4\n6,1\n", &auto(), rows, &["T2", "2"]);
    // Any word beside a fraction that could be one of its column.
    refused("trace,2.5\n3.5,5\n4,4\n6,1\n", &auto(), 1, &["names of columns or the first row"]);
    refused("3.25,offline\n3.5,5\n4,4\n6,1\n", &auto(), 1, &["option `header` decides"]);
    check("T2,99.5\n3.5,5\n4,4\n6,1\n", &auto(), rows, &["T2", "99.5"]);
    check("\"T2\",\"2.5\"\n3.5,5\n4,4\n6,1\n", &auto(), rows, &["T2", "2.5"]);
}

#[test]
fn quotes_that_backslashes_make_part_of_a_field_are_read_where_fields_are_torn_without_them() {
    let rows: &[&[f64]] = &[&[1.5, 2.0], &[3.5, 5.0], &[4.25, 4.0]];
    for names in [
        [r#""say \"hi\"""#, "x", "y"],
        [r#""say \"hi, you\"""#, "\"x\"", "y"],
        [r#""5\" pipe, 3""#, r#""3\" pipe""#, "y"],
        [r#""5\", 3\"""#, r#""3\",1""#, r#""a\", 7, b""#],
        // Without escapes each row has five fields, of which the second is a number.
        [r#""a\", 7, b""#; 3],
    ] {
        let [a, b, c] = names;
        let text = format!("name,a,b\n{a},1.5,2\n{b},3.5,5\n{c},4.25,4\n");
        let reading = check(&text, &auto(), rows, &["a", "b"]);
        assert!(reading.has_escaped_quotes, "{text}");
        let said = "1 text column left out (name)";
        let said = format!(r#"separator ,, decimal point, header, \" read as a quote, {said}"#);
        assert_eq!(reading.to_string(), said);
        let below = text.strip_prefix("name,a,b\n").unwrap();
        check(below, &options(TableOptions::new().header(Some(false))), rows, &[]);
    }
    // Paths end with a backslash before the quote.
    let text = "path,a\n\"C:\\x\\\",1.5\n\"C:\\\",2\n\"D\",4\n";
    let reading = check(text, &auto(), &[&[1.5], &[2.0], &[4.0]], &["a"]);
    assert!(!reading.has_escaped_quotes);
    // Two quotes are one of the field, as always.
    let text = "name,a\n\"say \"\"hi\"\"\",1.5\n\"y\",2\n\"z\",4\n";
    assert!(!check(text, &auto(), &[&[1.5], &[2.0], &[4.0]], &["a"]).has_escaped_quotes);
}

#[test]
fn rows_in_quotes_are_named() {
    let quoted = "\"a,b\"\n\"1.5,2\"\n\"3.5,5\"\n\"4,4.5\"\n";
    refused(quoted, &auto(), 2, &["\"1.5,2\"; each row is in quotes"]);
}

#[test]
fn files_that_are_no_tables_are_named_with_what_converts_them() {
    let svmlight = "1 1:1.5 2:2\n-1 1:3.5\n1 2:4\n";
    refused(svmlight, &auto(), 1, &["libsvm", "load_svmlight_file", "scipy.sparse.save_npz"]);
    refused("# x\n1 qid:1 1:2\n", &auto(), 2, &["libsvm"]);
    refused("t\n[[1.5 2. ]\n [3.5 5. ]]\n", &options(TableOptions::new().skip(1)), 2, &["array"]);
    let arff = "@relation r\n@attribute a real\n@data\n1,2\n3.5,5\n";
    refused(arff, &auto(), 1, &["ARFF: option `skip` = 3 leaves out"]);
    let rows: &[&[f64]] = &[&[1.0, 2.0], &[3.5, 5.0]];
    check(arff, &options(TableOptions::new().skip(3)), rows, &[]);
    // A separator says that it is a table.
    let table = TableOptions::new().separator(Some(Separator::Blanks)).header(Some(false));
    let blank = options(table);
    check("1 1:1.5\n2 1:2\n", &blank.columns(Columns::parse("0")), &[&[1.0], &[2.0]], &[]);
}

#[test]
fn integers_that_are_rounded_are_counted() {
    let said = |text: &str, options: &ReadOptions<'_>| {
        let reading = content(text, options).unwrap().reading.unwrap();
        assert!(reading.rounded.is_none() || !reading.is_plain(), "{text}");
        reading.to_string()
    };
    let text = "x,id\n1,9007199254740992\n2.5,9007199254740993\n7,-9007199254740995\n3,4\n";
    let large = 2.0_f64.powi(53);
    let rows: &[&[f64]] = &[&[1.0, large], &[2.5, large], &[7.0, -large - 4.0], &[3.0, 4.0]];
    let rounded = check(text, &auto(), rows, &["x", "id"]).rounded.unwrap();
    assert_eq!((rounded.count, &rounded.place[..]), (2, "line 3, column 2 (id)"));
    let all = "2 integers beyond 2^53 rounded, the first in line 3, column 2 (id)";
    assert!(said(text, &auto()).ends_with(all));
    // Only cells that are used count, and no missing ones.
    assert!(!said(text, &auto().columns(Columns::parse("x"))).contains("2^53"));
    let missing = TableOptions::new().missing(Missing::Drop);
    let words = Some(vec!["9007199254740993".to_owned()]);
    let one = said(text, &options(missing.clone().missing_words(words)));
    assert!(one.ends_with("an integer beyond 2^53 rounded, in line 4, column 2 (id)"), "{one}");
    let dropped = said("1.5,2\nNA,9007199254740993\n3,4\n5,7\n", &options(missing));
    assert!(!dropped.contains("2^53"), "{dropped}");
    let quoted = "\"a\nb\",c\n1,2\n3,4\n5,\"9007199254740993\"\n";
    assert!(said(quoted, &auto()).contains("in line 5, column 2 (c)"));
    let german = said("a;b\n0,5;9.007.199.254.740.993\n1,5;2\n2,5;3\n", &auto());
    assert!(
        german.ends_with("an integer beyond 2^53 rounded, in line 2, column 2 (b)"),
        "{german}"
    );
    assert!(!said("1,0.12345678901234567\n2,12345678901234567e3\n", &auto()).contains("2^53"));
    // Counted by several threads, in order.
    let mut many = "1,2\n".repeat(600_000);
    many += "9007199254740993,1\n";
    many += &"3,4\n".repeat(600_000);
    many += "9007199254740993,1\n";
    let folder = Folder::new();
    let path = folder.file("many.csv", &many);
    for threads in [1, 3] {
        let threads = options(TableOptions::new().par(Par::Threads(threads)));
        let counted = read_file(&path, &threads).unwrap().reading.unwrap().to_string();
        assert!(counted.contains("2 integers beyond 2^53 rounded, the"), "{counted}");
        assert!(counted.ends_with("the first in line 600001, column 1"), "{counted}");
    }
}

#[test]
fn columns_of_words_are_left_out_or_factors() {
    let text = "city,x\nUlm,1\nBonn,2\nUlm,3\n\"\",4\n";
    let reading = check(text, &auto(), &[&[1.0], &[2.0], &[3.0], &[4.0]], &["x"]);
    assert_eq!(reading.left_out, ["city"]);
    let named = content(text, &auto().columns(Columns::parse("city,x"))).map(drop_reading);
    assert!(named.unwrap_err().to_string().contains("column city has words, such as \"Ulm\""));
    let factor = TableOptions::new().words(Words::Factor).missing(Missing::Drop);
    let rows: &[&[f64]] = &[&[1.0, 1.0], &[0.0, 2.0], &[1.0, 3.0]];
    let reading = check(text, &options(factor), rows, &["city", "x"]);
    let levels = ["Bonn", "Ulm"].map(str::to_owned).to_vec();
    assert_eq!(reading.columns[0].kind, ColumnKind::Factor { levels });
    assert_eq!((reading.columns[1].number, reading.dropped_rows), (1, 1));
}

#[test]
fn options_out_of_their_range_are_named() {
    for (table, name) in [
        (TableOptions::new().decimal('x'), "decimal"),
        (TableOptions::new().thousands('_'), "thousands"),
        (TableOptions::new().decimal(',').thousands(','), "thousands"),
        (TableOptions::new().separator(Separator::Char('e')), "separator"),
        (TableOptions::new().separator(Separator::Char('.')), "separator"),
        (TableOptions::new().comment('\u{a7}'), "comment"),
        (TableOptions::new().encoding("latin-99".to_owned()), "encoding"),
    ] {
        let error = content("1,2\n", &options(table)).map(drop_reading).unwrap_err();
        assert!(matches!(&error, Error::Argument { what, .. } if *what == name), "{error}");
    }
}

#[test]
fn blank_lines_between_the_rows_of_one_column_are_missing_cells() {
    let with = |missing| options(TableOptions::new().missing(missing));
    for text in ["x\n1\n\n2\n", "x\r\n1\r\n\r\n2\r\n", "x\n1\n  \n# a\n2\n\n\n", "\nx\n1\n\n2"] {
        let line = if text.starts_with('\n') { 4 } else { 3 };
        refused(
            text,
            &auto(),
            line,
            &["a blank line", "column 1 (x): nothing", "`missing` = drop"],
        );
        let reading = check(text, &with(Missing::Drop), &[&[1.0], &[2.0]], &["x"]);
        assert_eq!(reading.dropped_rows, 1, "{text:?}");
        check(text, &with(Missing::Nan), &[&[1.0], &[f64::NAN], &[2.0]], &["x"]);
    }
    // Below the header, and between words.
    check("x\n\n1\n2\n", &with(Missing::Nan), &[&[f64::NAN], &[1.0], &[2.0]], &["x"]);
    let words = options(TableOptions::new().words(Words::Factor).missing(Missing::Nan));
    check("c\nb\n\na\n", &words, &[&[1.0], &[f64::NAN], &[0.0]], &["c"]);
    // Elsewhere they divide nothing.
    check("\n1\n2\n\n", &auto(), &[&[1.0], &[2.0]], &[]);
    check("1,2\n\n3,5\n\n4,4\n", &auto(), SMALL, &[]);
}

#[test]
fn blank_lines_are_counted_where_threads_divide_the_text() {
    // Runs of them, one longer than a piece, with comments in between.
    let (mut text, mut expected) = (String::from("x\n"), Vec::new());
    for i in 0..400_000_usize {
        let blanks = if i == 200_000 { 3 << 20 } else { usize::from(i % 1000 < 3) * (i % 5) };
        if i > 0 {
            text.extend(std::iter::repeat_n('\n', blanks));
            expected.extend(std::iter::repeat_n(f64::NAN, blanks));
        }
        if i % 5000 == 0 {
            text.push_str("# here\n");
        }
        text.push_str(&format!("{i}.5\n"));
        expected.push(i as f64 + 0.5);
    }
    let expected = Mat::from_fn(expected.len(), 1, |i, _| expected[i]);
    let folder = Folder::new();
    let path = folder.file("a.csv", &text);
    for threads in [1, 3] {
        let par = Par::Threads(threads);
        let options = options(TableOptions::new().missing(Missing::Nan).par(par));
        same(&doubles(&read_file(&path, &options).unwrap().matrix), &expected);
        let mut file = TableFile::open(&path, &options).unwrap().unwrap();
        assert_eq!(file.nrows(), expected.nrows());
        let mut blocks = Mat::<f64>::zeros(file.nrows(), 1);
        for first in (0..file.nrows()).step_by(500_000).rev() {
            let count = 500_000.min(file.nrows() - first);
            file.read(first, blocks.as_mut().subrows_mut(first, count)).unwrap();
        }
        same(&blocks, &expected);
    }
}

#[test]
fn quotes_that_swallow_rows_are_refused() {
    let text = "n,a\nx,1\n\"y,2\nq,7\nr,8\n\"z,3\nw,4\n";
    refused(text, &auto(), 3, &["several lines", "text behind its closing quote"]);
    let text = "n,a\nx,1\n\"y\nq\",2\n\"\"\"z\"\"\n\",3\n";
    check(text, &auto(), &[&[1.0], &[2.0], &[3.0]], &["a"]);
}

#[test]
fn points_between_semicolons_may_be_between_thousands() {
    refused("a;b\n1.234;2\n3.456;4\n", &auto(), 2, &["1.234", "1234", "`thousands`"]);
    for (text, first) in [("a;b\n1.234;2\n0.456;4\n", 1.234), ("a;b\n1.25;2\n0.456;4\n", 1.25)] {
        check(text, &auto(), &[&[first, 2.0], &[0.456, 4.0]], &["a", "b"]);
    }
}

#[test]
fn quotes_that_stay_open_lose_no_row() {
    refused("x,s\n1,\"a\n2,b\n3,c\n", &auto(), 2, &["quote"]);
}

/// How a generated table is written.
#[derive(Debug, Clone)]
struct Dialect {
    separator: &'static str,
    decimal: char,
    line_end: &'static str,
    has_quotes: bool,
    has_header: bool,
    has_index: bool,
    has_trailing: bool,
    ends: bool,
    /// Columns of words before those of numbers; none without a header.
    words: usize,
    has_quoted_words: bool,
}

fn dialects() -> impl Strategy<Value = Dialect> {
    let separators = prop::sample::select(vec![",", ";", "\t", "|", "  ", ", "]);
    let line_ends = prop::sample::select(vec!["\n", "\r\n", "\r"]);
    let flags = proptest::array::uniform7(any::<bool>());
    (separators, line_ends, flags, 0_usize..4).prop_map(|(separator, line_end, flags, words)| {
        let [comma, has_quotes, has_header, has_index, has_trailing, ends, quoted] = flags;
        let is_comma = separator.starts_with(',');
        Dialect {
            separator,
            decimal: if comma && (!is_comma || has_quotes && separator == ",") { ',' } else { '.' },
            line_end,
            // After a blank a quote is none.
            has_quotes: has_quotes && separator != ", ",
            has_header: has_header || has_index,
            has_index,
            has_trailing: has_trailing && !separator.ends_with(' '),
            ends,
            words: if has_header || has_index { words } else { 0 },
            has_quoted_words: quoted && separator != ", ",
        }
    })
}

impl Dialect {
    fn line(&self, fields: impl Iterator<Item = String>) -> String {
        let quoted = fields.map(|f| if self.has_quotes { format!("\"{f}\"") } else { f });
        let end = if self.has_trailing { self.separator } else { "" };
        quoted.collect::<Vec<_>>().join(self.separator) + end
    }

    /// Returns the words of a row.
    fn words(&self, i: usize) -> impl Iterator<Item = String> + '_ {
        (0..self.words).map(move |j| {
            let word = ["A", "New York", "x-1", "Ulm"][(3 * i + j) % 4];
            match self.has_quoted_words {
                true if self.has_quotes => word.to_owned(),
                true => format!("\"{word}\""),
                false => word.replace(' ', "_"),
            }
        })
    }

    fn write(&self, rows: &[Vec<f64>]) -> String {
        let mut lines = Vec::new();
        if self.has_header {
            let names = (0..rows[0].len()).map(|j| format!("col {j}").replace(' ', "_"));
            let index = (self.has_index && self.separator != "  ").then(String::new);
            let words = (0..self.words).map(|j| format!("words_{j}"));
            lines.push(self.line(index.into_iter().chain(words).chain(names)));
        }
        for (i, row) in rows.iter().enumerate() {
            let index = self.has_index.then(|| format!("{}", i + 1));
            let numbers =
                row.iter().map(|x| format!("{x:?}").replace('.', &self.decimal.to_string()));
            lines.push(self.line(index.into_iter().chain(self.words(i)).chain(numbers)));
        }
        let end = if self.ends { self.line_end } else { "" };
        lines.join(self.line_end) + end
    }
}

proptest! {
    #![proptest_config(ProptestConfig { failure_persistence: None, ..ProptestConfig::default() })]

    #[test]
    fn tables_in_generated_dialects_are_read_back(
        dialect in dialects(),
        // A fraction in each number: with integers only, a dialect may be another one, too.
        rows in (2_usize..5).prop_flat_map(|n| {
            let number = (-9999_i32..9999).prop_map(|x| f64::from(x) + 0.5);
            prop::collection::vec(prop::collection::vec(number, n), 2..40)
        }),
    ) {
        let text = dialect.write(&rows);
        let fail = |e| TestCaseError::fail(format!("{text}: {e}"));
        let found = content(&text, &auto()).map_err(fail)?;
        let expected = Mat::from_fn(rows.len(), rows[0].len(), |i, j| rows[i][j]);
        prop_assert_eq!(doubles(&found.matrix), expected, "{:?}", text);
        prop_assert_eq!(found.names.len(), if dialect.has_header { rows[0].len() } else { 0 });
    }
}

#[test]
fn named_columns_of_words_are_factors_and_others_are_left_out() {
    let folder = Folder::new();
    let path = folder.file("a.csv", "u,v,x,k\nb,p,1,10\na,q,2,9\nb,p,3,w\n");
    let read = |factors: &[&str], columns: &str| {
        let factors = factors.iter().map(|&name| name.to_owned()).collect();
        let columns = if columns.is_empty() { Columns::ALL } else { Columns::parse(columns) };
        let options = options(TableOptions::new().factors(factors)).columns(columns);
        read_file(&path, &options)
            .map(|content| (doubles(&content.matrix), content.reading.unwrap()))
    };
    let (found, reading) = read(&["u", "k", "none"], "").unwrap();
    same(&found, &mat![[1.0, 1.0, 0.0], [0.0, 2.0, 1.0], [1.0, 3.0, 2.0]]);
    assert_eq!(reading.left_out, ["v"]);
    let kinds: Vec<_> = reading.columns.iter().map(|column| column.kind.clone()).collect();
    let levels = |words: &[&str]| ColumnKind::Factor {
        levels: words.iter().map(|&word| word.to_owned()).collect(),
    };
    assert_eq!(kinds, [levels(&["a", "b"]), ColumnKind::Numbers, levels(&["10", "9", "w"])]);
    // By number; numbers stay numbers; only what is asked for may be words.
    let (found, _) = read(&["1", "x"], "x,v").unwrap();
    same(&found, &mat![[1.0, 0.0], [2.0, 1.0], [3.0, 0.0]]);
    let said = read(&["u"], "v,u").unwrap_err().to_string();
    assert!(said.contains("column v has words"), "{said}");
}

#[test]
fn an_identity_names_the_options_that_were_given() {
    let folder = Folder::new();
    let path = folder.file("a.csv", "title\n1;2\n3;4\n");
    let table = TableOptions::new().separator(Separator::Char(';')).header(false).skip(1);
    let file = TableFile::open(&path, &options(table).columns(0..1)).unwrap().unwrap();
    let said = ", 2 x 1, columns 0..1, separator ';', header false, skip 1, ";
    assert!(file.identity().contains(said), "{}", file.identity());
}

#[test]
fn the_result_does_not_depend_on_threads_or_blocks() {
    let row = |i: usize| format!("{}.5,{},w{}\n", i % 977, i * i % 1013, i % 7);
    let text: String = (0..400_000).map(row).collect();
    let table = TableOptions::new().words(Words::Factor);
    let folder = Folder::new();
    let path = folder.file("a.csv", text);
    let options = |par| options(table.clone().par(par));
    let read = |par| doubles(&read_file(&path, &options(par)).unwrap().matrix);
    let found = read(Par::Seq);
    same(&found, &read(Par::Threads(4)));
    let mut file = TableFile::open(&path, &options(Par::Threads(3))).unwrap().unwrap();
    let mut blocks = Mat::<f64>::zeros(found.nrows(), found.ncols());
    for first in [300_000, 0, 100_000, 200_000] {
        file.read(first, blocks.as_mut().subrows_mut(first, 100_000)).unwrap();
    }
    same(&found, &blocks);
    assert_eq!(found.shape(), (400_000, 3));
    let expected = |i: usize| [(i % 977) as f64 + 0.5, (i * i % 1013) as f64, (i % 7) as f64];
    for i in (0..400_000).step_by(997) {
        assert_eq!([0, 1, 2].map(|j| found[(i, j)]), expected(i));
    }
}

#[test]
fn a_file_that_changes_while_it_is_read_is_refused() {
    let folder = Folder::new();
    let path = folder.file("a.csv", "1.5,2\n3,4\n");
    let mut file = TableFile::open(&path, &auto()).unwrap().unwrap();
    let other = file.try_clone().unwrap();
    assert_eq!(file.identity(), other.identity());
    std::fs::write(&path, "1.5,2\n").unwrap();
    let mut out = Mat::<f64>::zeros(2, 2);
    let said = file.read(0, out.as_mut()).unwrap_err().to_string();
    assert!(said.contains("shrank"), "{said}");
    assert!(other.try_clone().is_err());
}

/// The files of `inputs/tables` in the folder that `CATAMARAN_DATA` names.
#[test]
fn the_tables_that_people_sent_are_read_right() {
    let Some(data) = std::env::var_os("CATAMARAN_DATA") else { return };
    let folder = Path::new(&data).join("inputs/tables");
    if !folder.is_dir() {
        return;
    }
    let read = |name: &str, options: &ReadOptions<'_>| read_file(&folder.join(name), options);
    let numbers = |name: &str, options: &ReadOptions<'_>, rows: &[&[f64]]| {
        let content = read(name, options).unwrap_or_else(|e| panic!("{e}"));
        let expected = Mat::from_fn(rows.len(), rows[0].len(), |i, j| rows[i][j]);
        same(&doubles(&content.matrix), &expected);
        content
    };
    let refused = |name: &str, parts: &[&str]| {
        let said = read(name, &auto()).map(drop_reading).unwrap_err().to_string();
        assert!(parts.iter().all(|part| said.contains(part)), "{said}");
    };
    refused("thousands_quoted_head.csv", &["thousands_quoted_head.csv:2", "`thousands`"]);
    refused("spectra_num.csv", &["`header`"]);
    let spectra: &[&[f64]] =
        &[&[0.10, 0.20, 0.30], &[0.11, 0.25, 0.28], &[0.09, 0.18, 0.35], &[0.15, 0.22, 0.31]];
    numbers("spectra.csv", &auto().columns(1..4), spectra);
    numbers("spectra_num.csv", &options(TableOptions::new().header(true)), spectra);
    let r = numbers(
        "r_writetable.txt",
        &auto(),
        &[&[1.5, 2.0, 0.5], &[3.5, 5.0, 0.25], &[4.0, 4.0, 1.0], &[6.0, 1.0, 2.0]],
    );
    assert_eq!(r.names, ["x", "y", "z"]);
    for name in [
        "infnames.csv",
        "utf16.csv",
        "pipe.csv",
        "trailing_comma.csv",
        "trailing_comment.txt",
        "cr_only.csv",
        "savetxt_header.csv",
        "a.csv.xz",
    ] {
        if name == "a.csv.xz" {
            read(name, &auto()).unwrap();
        } else {
            numbers(name, &auto(), SMALL);
        }
    }
    assert_eq!(read("savetxt_header.csv", &auto()).unwrap().names, ["a", "b"]);
    numbers(
        "tab_blank_mixed.txt",
        &auto(),
        &[&[1.0, 2.0, 3.0], &[4.0, 5.0, 6.0], &[7.0, 8.0, 1.0]],
    );
    let semi = numbers("quoted_head_semi.csv", &auto(), &[&[1.0, 2.0], &[2.0, 4.5], &[3.0, 5.0]]);
    assert_eq!(semi.names, ["time; s", "x"]);
    assert_eq!(read("names_comma.csv", &auto()).unwrap().names, ["a,b", "y"]);
    let comma = read("quoted_head_comma.csv", &auto()).unwrap();
    assert_eq!(comma.names, ["Height, cm", "Weight, kg"]);
    numbers("fortran_d.txt", &auto(), &[&[1.0, 0.25], &[3.0, 10.0], &[2.0, 0.0]]);
    numbers("dexp.mtx", &auto(), &[&[1.0, 0.0], &[0.25, -4.0]]);
    let drop = options(TableOptions::new().missing(Missing::Drop));
    for name in ["na_words.csv", "na_empty.csv"] {
        let complete = numbers(name, &drop, &[&[1.0, 2.0], &[4.0, 5.0], &[6.0, 8.0]]);
        assert_eq!(complete.reading.unwrap().dropped_rows, 1);
    }
    let first = numbers("na_first.csv", &drop, SMALL);
    assert_eq!(first.reading.unwrap().dropped_rows, 1);
    let decimal = read("decimal_comma.csv", &auto()).unwrap();
    assert_eq!(doubles(&decimal.matrix)[(2, 2)], 19.25);
    numbers(
        "thousands_de.csv",
        &auto().columns(1..3),
        &[&[1299.99, 3.0], &[899.5, 5.0], &[2100.0, 1.0]],
    );
    for name in ["bool.npy", "g.npy", "c.npy.xz", "one.npz"] {
        assert!(matches!(read(name, &auto()).unwrap().matrix, Matrix::F64(_) | Matrix::F32(_)));
    }
    assert!(matches!(read("sparse.npz", &auto()).unwrap().matrix, Matrix::Sparse(_)));
}
