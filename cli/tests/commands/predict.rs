//! `catamaran predict`, and the models that `catamaran lstsq` writes for it, from outside.

use std::fs;

use crate::common::{Folder, csv};

/// Rows of two columns and of the first plus twice the second.
const ROWS: [[f64; 3]; 5] = [
    [1.0, 10.0, 21.0],
    [2.0, 30.0, 62.0],
    [3.0, 20.0, 43.0],
    [4.0, 70.0, 144.0],
    [5.0, 10.0, 25.0],
];

/// A table of which column y is twice column a plus three times the column without a name.
const UNNAMED: &str = "y,a,,z\n0,0,0,0\n5,1,1,5\n16,2,4,10\n12,3,2,4\n14,4,2,9\n";

/// The predictions of a model of one target.
fn predicted(folder: &Folder, arguments: &str) -> Vec<f64> {
    folder.succeed(&format!("predict {arguments} -o p.csv --force"));
    let text = fs::read_to_string(folder.path("p.csv")).unwrap();
    text.lines().skip(1).map(|line| line.parse().unwrap()).collect()
}

fn assert_close(found: &[f64], expected: &[f64]) {
    assert_eq!(found.len(), expected.len(), "{found:?}");
    for (x, y) in found.iter().zip(expected) {
        assert!((x - y).abs() <= 1e-12 * y.abs(), "{found:?} {expected:?}");
    }
}

/// A folder with [`ROWS`] in fit.csv, without a header, and their model in fit.json.
fn numbered() -> Folder {
    let folder = Folder::new();
    folder.write("fit.csv", csv(&ROWS.concat(), 3));
    folder.succeed("lstsq fit.csv --by-column 2 -o fit.json");
    folder
}

#[test]
fn the_only_column_without_a_name_is_found_wherever_it_is() {
    let folder = Folder::new();
    folder.write("fit.csv", UNNAMED);
    folder.write("new.csv", "a,,z\n1,1,5\n2,4,10\n3,2,4\n");
    for (columns, model) in [("--columns y,a,2", "some.json"), ("", "all.json")] {
        folder.succeed(&format!("lstsq fit.csv --by-column y {columns} -o {model}"));
        let found = predicted(&folder, &format!("{model} fit.csv"));
        assert_close(&found[1..], &[5.0, 16.0, 12.0, 14.0]);
        assert_close(&predicted(&folder, &format!("{model} new.csv")), &[5.0, 16.0, 12.0]);
    }
    folder.write("none.csv", "a,b,z\n1,1,5\n2,4,10\n");
    let message = folder.fail("predict some.json none.csv");
    let says = "none.csv: has no column with an empty name; the columns are a, b, z";
    assert!(message.contains(says), "{message}");
    folder.write("two.csv", "a,,,z\n1,1,1,5\n2,4,4,10\n");
    let message = folder.fail("predict some.json two.csv");
    assert!(message.contains("two.csv: two columns have no name, of which"), "{message}");
}

#[test]
fn a_fit_of_numbered_columns_takes_those_of_tables_without_names() {
    let folder = numbered();
    let targets: Vec<f64> = ROWS.iter().map(|row| row[2]).collect();
    assert_close(&predicted(&folder, "fit.json fit.csv"), &targets);
    folder.write_npy("new.npy", &[2, 2], &[10.0, 1.0, 30.0, 2.0]);
    assert_close(&predicted(&folder, "fit.json new.npy"), &[12.0, 34.0]);
    // Names that are the numbers, as pandas writes them.
    folder.write("pandas.csv", "\"1\",\"0\"\n1,10\n2,30\n");
    assert_close(&predicted(&folder, "fit.json pandas.csv"), &[12.0, 34.0]);
}

#[test]
fn a_fit_of_numbered_columns_refuses_other_names_until_they_are_left_out() {
    let folder = numbered();
    folder.write("new.csv", "b,a\n10,1\n30,2\n");
    let message = folder.fail("predict fit.json new.csv");
    let says = "new.csv: the columns of the fit have numbers, such as 0, and those of the table \
                have names, such as b; --no-header, with --skip for the line of names, takes \
                numbers";
    assert!(message.contains(says), "{message}");
    let found = predicted(&folder, "fit.json new.csv --no-header --skip 1");
    assert_close(&found, &[12.0, 34.0]);
    // The number of one column is the name of another one.
    folder.write("mixed.csv", "\"1\",\"x\"\n10,1\n30,2\n");
    let message = folder.fail("predict fit.json mixed.csv");
    let says = "mixed.csv: has not all of the columns called 0, 1";
    assert!(message.contains(says), "{message}");
    // The target comes first in the rows of the fit, and last in the table.
    let rows: Vec<f64> = ROWS.iter().flat_map(|&[a, b, y]| [y, a, b]).collect();
    folder.write("first.csv", csv(&rows, 3));
    folder.succeed("lstsq first.csv --by-column 0 -o first.json");
    folder.write("named.csv", "a,b,y\n10,1,0\n30,2,0\n");
    assert!(folder.fail("predict first.json named.csv").contains("numbers, such as 1, and"));
}

#[test]
fn names_that_are_numbers_of_other_columns_are_no_numbers() {
    let folder = Folder::new();
    folder.write("fit.csv", format!("\"1\",\"2\",\"y\"\n{}", csv(&ROWS.concat(), 3)));
    folder.succeed("lstsq fit.csv --by-column y -o fit.json");
    let targets: Vec<f64> = ROWS.iter().map(|row| row[2]).collect();
    assert_close(&predicted(&folder, "fit.json fit.csv"), &targets);
    folder.write_npy("new.npy", &[2, 3], &[10.0, 1.0, 5.0, 30.0, 2.0, 7.0]);
    let message = folder.fail("predict fit.json new.npy");
    let says = "new.npy: has no column called 1: its columns have no names";
    assert!(message.contains(says), "{message}");
    folder.write("new.csv", "x,z,w\n10,1,5\n30,2,7\n");
    let message = folder.fail("predict fit.json new.csv");
    assert!(message.contains("new.csv: has no column called 1"), "{message}");
}

#[test]
fn two_columns_of_one_name_are_told_at_the_fit_and_refused_by_predict() {
    let folder = Folder::new();
    for (header, which) in [("a,y,a", "are called a"), ("a,y,,", "have no name")] {
        let rest = if header.ends_with(',') { ",4" } else { "" };
        let rows = ["1,2,3", "2,4,1", "3,6,2"].map(|row| format!("{row}{rest}\n")).concat();
        folder.write("fit.csv", format!("{header}\n{rows}"));
        let run = folder.run("lstsq fit.csv --by-column y -o fit.json --force");
        let note = format!("note: fit.csv: two columns {which}: `predict` will refuse fit.json");
        assert!(run.code == Some(0) && run.stderr.contains(&note), "{}", run.stderr);
        let message = folder.fail("predict fit.json fit.csv");
        let says = format!("fit.json: two columns of the fit {which}");
        assert!(message.contains(&says), "{message}");
        // No model is written.
        let run = folder.run("lstsq fit.csv --by-column y -o fit.npz --force");
        assert!(!run.stderr.contains("two columns"), "{}", run.stderr);
    }
    folder.write("one.csv", "a,y\n1,2\n2,4\n3,6\n");
    folder.succeed("lstsq one.csv --by-column y -o one.json");
    folder.write("two.csv", "a,b,a\n1,1,1\n");
    let message = folder.fail("predict one.json two.csv");
    let says = "two.csv: two columns are called a, of which the fit had one";
    assert!(message.contains(says) && !message.contains("give a number"), "{message}");
}

#[test]
fn a_number_is_a_level_also_where_other_levels_are_words() {
    let folder = Folder::new();
    folder.write("fit.csv", "g,x,y\n7,0,1\na,1,3\n7,2,2\na,3,6\nb,1,5\nb,2,4\n");
    folder.succeed("lstsq fit.csv --by-column y --intercept --factor g -o fit.json");
    folder.write("words.csv", "g,x\n7,1\na,1\n");
    folder.write("number.csv", "g,x\n7,1\n");
    let right = predicted(&folder, "fit.json words.csv");
    assert_close(&predicted(&folder, "fit.json number.csv"), &right[..1]);
    folder.write("other.csv", "g,x\n8,1\n");
    let message = folder.fail("predict fit.json other.csv");
    let says = "other.csv: column g: the fit has no level 8, but 7, a, b, in row 0";
    assert!(message.contains(says), "{message}");
}

#[test]
fn a_base_may_be_written_as_in_the_table() {
    let folder = Folder::new();
    folder.write("fit.csv", "y,g\n1,1.0\n2,2.0\n4,3.0\n4,1.0\n6,2.0\n");
    let report = folder.succeed("lstsq fit.csv --by-column y --factor g=2.0");
    assert!(report.contains("g: 3 levels, compared with 2"), "{report}");
}

#[test]
fn a_factor_of_too_many_levels_is_called_by_its_name() {
    let folder = Folder::new();
    let row = |i: usize| format!("{},{},{},{}\n", i % 7, i % 5, i % 3, i);
    folder.write("a.csv", format!("y,a,b,g\n{}", (0..10_001).map(row).collect::<String>()));
    let message = folder.fail("lstsq a.csv --by-column y --factor g");
    let says = "a.csv: factor: g has more than 10000 different entries";
    assert!(message.contains(says) && !message.contains("column 2"), "{message}");
}

#[test]
fn words_in_the_place_that_is_the_name_of_a_factor_are_no_numbers() {
    let folder = Folder::new();
    let rows = "1,p,0\n2,q,1\n4,p,2\n4,r,1\n7,q,0\n8,q,2\n";
    folder.write("a.csv", format!("y,c,\"1\"\n{rows}"));
    let message = folder.fail("lstsq a.csv --by-column y --factor 1");
    let says = "a.csv: column c has words, and --factor names another column";
    assert!(message.contains(says), "{message}");
    folder.succeed("lstsq a.csv --by-column y --columns y,1 --factor 1");
}

#[test]
fn infinities_are_refused_with_the_column_of_the_table() {
    let folder = Folder::new();
    folder.write("fit.csv", "a,y\n1,2\n2,4\n3,6\n");
    folder.succeed("lstsq fit.csv --by-column y -o fit.json");
    folder.write("new.csv", "b,a\n2,1\n3,inf\n");
    for missing in ["error", "nan"] {
        let message = folder.fail(&format!("predict fit.json new.csv --missing {missing}"));
        let says = "catamaran: new.csv: inf at row 1, column 1 (a), counted from 0\n";
        assert!(message.ends_with(says), "{message}");
    }
    let folder = numbered();
    folder.write_npy("new.npy", &[2, 2], &[10.0, 1.0, 30.0, f64::NAN]);
    let message = folder.fail("predict fit.json new.npy");
    assert!(message.ends_with("new.npy: NaN at row 1, column 1 (counted from 0)\n"), "{message}");
}

#[test]
fn predictions_that_are_out_of_range_are_refused_and_none_is_nan() {
    let folder = Folder::new();
    folder.write("fit.csv", "a,y\n1,2\n2,4\n3,6.5\n");
    folder.succeed("lstsq fit.csv --by-column y --covariance -o fit.json");
    folder.write("new.csv", "a\n3\nNA\n1e308\n");
    let says = "new.csv: the prediction of row 2 (counted from 0) is out of the range of f64";
    for options in ["--missing nan", "--missing drop", "--missing nan --interval mean"] {
        let message = folder.fail(&format!("predict fit.json new.csv {options} -o p.csv"));
        assert!(message.contains(says), "{message}");
    }
    folder.write("new.csv", "a\n1e307\n");
    assert!(predicted(&folder, "fit.json new.csv")[0] > 2e307);
    // Without degrees of freedom there is no interval, and a prediction still is.
    folder.write("two.csv", "u,v,y\n1,0,1\n0,1,2\n");
    folder.succeed("lstsq two.csv --by-column y --covariance -o two.json");
    folder.succeed("predict two.json two.csv --interval mean");
}

#[test]
fn a_file_that_is_no_model_is_said_to_be_none() {
    let folder = Folder::new();
    folder.write("fit.csv", "a,y\n1,2\n2,4\n3,6\n");
    folder.succeed("lstsq fit.csv --by-column y -o fit.npz");
    let message = folder.fail("predict fit.npz fit.csv");
    let says = "fit.npz: not a model, which `lstsq -o` writes where the name ends in .json";
    assert!(message.contains(says), "{message}");
    assert!(folder.fail("predict none.json fit.csv").contains("none.json: no such file"));
}
