//! `catamaran lstsq`, `catamaran pca` and `catamaran svd`, from outside.

use std::fs;
use std::process::Stdio;

use catamaran::faer::{Mat, mat};
use catamaran::io::{Arrays, read_arrays};
use serde_json::{Value, json};

use crate::common::{Folder, Run, calls, csv, table, with_input};

/// Longley's data with the names of the columns (NIST StRD, dataset Longley; public domain).
const LONGLEY: &str = "\
employed,deflator,gnp,unemployed,armed,population,year
60323,83.0,234289,2356,1590,107608,1947
61122,88.5,259426,2325,1456,108632,1948
60171,88.2,258054,3682,1616,109773,1949
61187,89.5,284599,3351,1650,110929,1950
63221,96.2,328975,2099,3099,112075,1951
63639,98.1,346999,1932,3594,113270,1952
64989,99.0,365385,1870,3547,115094,1953
63761,100.0,363112,3578,3350,116219,1954
66019,101.2,397469,2904,3048,117388,1955
67857,104.6,419180,2822,2857,118734,1956
68169,108.4,442769,2936,2798,120445,1957
66513,110.8,444546,4681,2637,121950,1958
68655,112.6,482704,3813,2552,123366,1959
69564,114.2,502601,3931,2514,125368,1960
69331,115.7,518173,4806,2572,127852,1961
70551,116.9,554894,4007,2827,130081,1962
";

/// Certified coefficients and standard deviations, without and then of the constant.
const COEFFICIENTS: [f64; 6] = [
    15.0618722713733,
    -0.358191792925910e-1,
    -2.02022980381683,
    -1.03322686717359,
    -0.511041056535807e-1,
    1829.15146461355,
];
const ERRORS: [f64; 6] = [
    84.9149257747669,
    0.334910077722432e-1,
    0.488399681651699,
    0.214274163161675,
    0.226073200069370,
    455.478499142212,
];
const CONSTANT: [f64; 2] = [-3482258.63459582, 890420.383607373];

fn arrays(folder: &Folder, name: &str) -> Arrays {
    read_arrays(&folder.path(name)).unwrap()
}

fn bytes(folder: &Folder, name: &str) -> Vec<u8> {
    fs::read(folder.path(name)).unwrap()
}

/// [`Folder::succeed`], and what it said on stderr.
fn noted(folder: &Folder, arguments: &str) -> String {
    let run = folder.run(arguments);
    assert_eq!(run.code, Some(0), "{arguments}: {}", run.stderr);
    run.stderr
}

fn assert_close(found: &[f64], expected: &[f64], allowed: f64) {
    assert_eq!(found.len(), expected.len());
    for (x, y) in found.iter().zip(expected) {
        assert!((x - y).abs() <= allowed * y.abs(), "{found:?} {expected:?}");
    }
}

#[test]
fn certified_coefficients_come_out_by_the_names_of_the_header() {
    let folder = Folder::new();
    folder.write("longley.csv", LONGLEY);
    let report =
        folder.succeed("lstsq longley.csv --by-column employed --intercept -o x.npz -o x.json");
    let found = arrays(&folder, "x.npz");
    // The certified values are those of the decimal numbers, which are read rounded.
    let x = found.matrix("x").unwrap();
    assert_close(x.col_as_slice(0), &COEFFICIENTS, 1e-12);
    assert_close(found.matrix("standard_error").unwrap().col_as_slice(0), &ERRORS, 1e-12);
    assert_close(&found.vector("intercept").unwrap(), &CONSTANT[..1], 1e-12);
    assert_close(&found.vector("intercept_error").unwrap(), &CONSTANT[1..], 1e-12);
    assert_close(&found.vector("r_squared").unwrap(), &[0.995479004577296], 1e-13);
    assert_close(&found.vector("residual_norm").unwrap(), &[3.0 * 304.854073561965], 1e-12);
    assert_eq!(found.indices("degrees_of_freedom").unwrap(), [9]);
    assert_eq!(found.indices("rank").unwrap(), [6]);
    let line = |name: &str| {
        let line = report.lines().find(|line| line.starts_with(name)).unwrap();
        line.split_whitespace().map(str::to_owned).collect::<Vec<_>>()
    };
    assert_eq!(line("column"), ["column", "coefficient", "standard", "error", "t", "p"]);
    assert_eq!(line("unemployed")[4], "0.0025");
    assert_eq!(line("unemployed")[3], "-4.136");
    assert_eq!(line("intercept")[3], "-3.911");
    assert_eq!(line("rows"), ["rows", "16"]);
    assert_eq!(line("freedom")[1], "9");
    let json = fs::read_to_string(folder.path("x.json")).unwrap();
    let names = r#""columns": ["deflator", "gnp", "unemployed", "armed", "population", "year"]"#;
    assert!(json.contains(names) && json.contains(r#""name": "employed""#), "{json}");
}

#[test]
fn result_is_the_same_bytes_for_every_format_block_and_number_of_threads() {
    let folder = Folder::new();
    let (m, n) = (61, 7);
    let all = table(m, n);
    let columns = |range: std::ops::Range<usize>| -> Vec<f64> {
        all.chunks(n).flat_map(|row| row[range.clone()].to_vec()).collect()
    };
    folder.write("all.csv", csv(&all, n));
    folder.write_npy("all.npy", &[m as u64, n as u64], &all);
    folder.write_npy("a.npy", &[m as u64, 5], &columns(0..5));
    folder.write_fortran_npy("f.npy", &[m as u64, 5], &columns(0..5));
    folder.write_npy("b.npy", &[m as u64, 2], &columns(5..7));
    folder.write("b.csv", csv(&columns(5..7), 2));
    folder.succeed("lstsq a.npy b.npy --intercept -o x.npz");
    assert_eq!(arrays(&folder, "x.npz").matrix("x").unwrap().shape(), (5, 2));
    for (arguments, same) in [
        ("a.npy b.csv --threads 1", true),
        ("f.npy b.npy --threads 2 --block-rows 7", true),
        ("a.npy b.npy --block-rows 1", true),
        ("all.csv --by-column 5,6 --block-rows 13", true),
        ("all.npy --by-column 5,6", true),
        ("all.npy --by-column 6,5", false),
    ] {
        folder.succeed(&format!("lstsq {arguments} --intercept -o y.npz --force"));
        assert_eq!(bytes(&folder, "x.npz") == bytes(&folder, "y.npz"), same, "{arguments}");
    }
    // Numbers are those of the file, whatever columns are used.
    folder.succeed("lstsq all.npy --columns 1..7 --by-column 6 -o y.json");
    let json = fs::read_to_string(folder.path("y.json")).unwrap();
    assert!(json.contains(r#""columns": ["1", "2", "3", "4", "5"]"#), "{json}");
}

#[test]
fn predictions_of_targets_without_names_are_read_back() {
    let folder = Folder::new();
    let entry = |i: usize| ((i * i + 7 * i) % 23) as f64 / 4.0;
    folder.write_npy("x.npy", &[20, 2], &(0..40).map(entry).collect::<Vec<_>>());
    folder.write_npy("y.npy", &[20, 2], &(40..80).map(entry).collect::<Vec<_>>());
    folder.succeed("lstsq x.npy y.npy -o m.json");
    folder.succeed("predict m.json x.npy -o p.csv");
    let text = fs::read_to_string(folder.path("p.csv")).unwrap();
    assert!(text.starts_with("\"0\",\"1\"\n"), "{text}");
    let report = folder.succeed("ata p.csv");
    assert!(report.contains("p.csv: 20 x 2"), "{report}");
}

#[test]
fn json_of_a_small_problem() {
    let folder = Folder::new();
    folder.write("a.csv", "a b,t,y\n1,0,1\n1,1,3\n1,2,5\n");
    folder.succeed("lstsq a.csv --by-column y -o x.json");
    let json = fs::read_to_string(folder.path("x.json")).unwrap();
    let mut found: Value = serde_json::from_str(&json).unwrap();
    for name in ["condition", "digits"] {
        assert!(found.as_object_mut().unwrap().remove(name).unwrap().is_f64(), "{json}");
    }
    let target = found["targets"][0].as_object_mut().unwrap();
    assert_eq!(target.remove("x_low").unwrap().as_array().unwrap().len(), 2);
    // An exact fit: t and F are infinite, which JSON does not have.
    let expected = json!({
        "columns": ["a b", "t"],
        "terms": [{"column": "a b"}, {"column": "t"}],
        "targets": [{
            "name": "y",
            "x": [1.0, 2.0],
            "standard_error": [0.0, 0.0],
            "t": [null, null],
            "p": [0.0, 0.0],
            "r_squared": 1.0,
            "adjusted_r_squared": 1.0,
            "f_statistic": null,
            "f_p": 0.0,
            "residual_deviation": 0.0,
            "residual_norm": 0.0
        }],
        "confidence": null,
        "rows": 3,
        "left_out": 0,
        "observations": 3,
        "rank": 2,
        "dependent": [],
        "degrees_of_freedom": 1
    });
    assert_eq!(found, expected);
    let lines: Vec<&str> = json.lines().take(3).collect();
    assert_eq!(lines[0..2], ["{", r#"  "columns": ["a b", "t"],"#], "{json}");
}

/// R's mtcars (Motor Trend, 1974).
const MTCARS: &str = include_str!("../../../tests/common/tables/mtcars.csv");

#[test]
fn p_values_intervals_and_f_are_those_of_r() {
    // lm(mpg ~ wt + hp)
    let folder = Folder::new();
    let fields = |line: &str| -> Vec<String> {
        let fields: Vec<&str> = line.split(',').collect();
        [fields[0], fields[5], fields[3]].map(str::to_owned).into()
    };
    let table: Vec<String> = MTCARS.lines().map(|line| fields(line).join(",")).collect();
    folder.write("cars.csv", table.join("\n"));
    let report = folder.succeed(
        "lstsq cars.csv --by-column mpg --intercept --confidence 0.95 --covariance -o x.npz \
         -o x.json",
    );
    let found = arrays(&folder, "x.npz");
    let column = |name: &str| found.matrix(name).unwrap().col_as_slice(0).to_vec();
    let vector = |name: &str| found.vector(name).unwrap();
    assert_close(&column("p"), &[1.1196471362000246e-6, 0.0014512285315694147], 1e-12);
    assert_close(&column("t"), &[-6.128695219810418, -3.518711910208783], 1e-12);
    assert_close(&column("lower"), &[-5.1719160406755345, -0.050240776871073596], 1e-12);
    assert_close(&column("upper"), &[-2.5837454441338266, -0.0133051170932484], 1e-12);
    assert_close(&vector("intercept_p"), &[2.5654585119836858e-20], 1e-12);
    assert_close(&vector("intercept_upper"), &[40.49715778063592], 1e-12);
    assert_close(&vector("f_statistic"), &[69.21121339177775], 1e-12);
    assert_close(&vector("f_p"), &[9.109054385221927e-12], 1e-12);
    assert_close(&vector("adjusted_r_squared"), &[0.8148396209781563], 1e-12);
    assert_close(&vector("residual_deviation"), &[2.593411777226565], 1e-12);
    let covariance = found.matrix("covariance").unwrap();
    assert_eq!(covariance.shape(), (3, 3));
    assert_close(&[covariance[(0, 2)]], &[0.00014847005265084415], 1e-12);
    let line = |name: &str| report.lines().find(|line| line.starts_with(name)).unwrap().to_owned();
    let words: Vec<_> = line("wt").split_whitespace().skip(4).map(str::to_owned).collect();
    assert_eq!(words, ["1.12e-6", "-5.171916e0", "-2.583745e0"], "{report}");
    let f = "F           69.211 with 2 and 29 degrees of freedom, p 9.11e-12";
    assert_eq!(line("F "), f);
    // predict(fit, data.frame(wt = 3, hp = 150), interval = "prediction")
    folder.write("new.csv", "hp,name,wt\n150,1,3\n");
    folder.succeed("predict x.json new.csv --interval observation -o p.csv");
    let text = fs::read_to_string(folder.path("p.csv")).unwrap();
    let (titles, values) = text.trim_end().split_once('\n').unwrap();
    assert_eq!(titles, "mpg,mpg_lower,mpg_upper");
    let values: Vec<f64> = values.split(',').map(|x| x.parse().unwrap()).collect();
    let width = 2.045229642132704 * 2.638403439745562;
    let right = 20.827835841909007;
    assert_close(&values, &[right, right - width, right + width], 1e-12);
    assert!(folder.succeed("predict x.json new.csv").contains("2.082783584190901e1"));
    // Names are checked.
    folder.write("other.csv", "hp,weight\n150,3\n");
    let message = folder.fail("predict x.json other.csv");
    assert!(
        message.contains("other.csv: has no column wt; the columns are hp, weight"),
        "{message}"
    );
    let message = folder.fail("predict new.csv new.csv");
    assert!(message.contains("new.csv: not a model that `lstsq -o FIT.json` wrote"), "{message}");
    folder.succeed("lstsq cars.csv --by-column mpg -o plain.json");
    let message = folder.fail("predict plain.json new.csv --interval mean");
    assert!(message.contains("plain.json: has no covariance for --interval"), "{message}");
}

#[test]
fn a_column_in_place_of_a_table_names_its_option() {
    let folder = Folder::new();
    folder.write("a.csv", "x,y\n0,1\n1,3\n2,5\n");
    let message = folder.fail("lstsq a.csv y");
    assert!(message.contains("--by-column y") && message.contains("no such file"), "{message}");
    assert!(!folder.fail("lstsq a.csv z").contains("--by-column"));
}

#[test]
fn predictions_of_complete_rows_have_the_numbers_of_their_rows() {
    let folder = Folder::new();
    folder.write("fit.csv", "x,y\n0,1\n1,3\n2,5\n");
    folder.succeed("lstsq fit.csv --by-column y --intercept -o fit.json");
    folder.write("new.csv", "x\n4\nNA\n6\nNA\nNA\n9\n");
    let predicted = |options: &str| {
        folder.succeed(&format!("predict fit.json new.csv {options} -o p.csv --force"));
        let text = fs::read_to_string(folder.path("p.csv")).unwrap();
        let (titles, rows) = text.split_once('\n').unwrap();
        let numbers = rows.lines().flat_map(|line| line.split(','));
        (titles.to_owned(), numbers.map(|x| x.parse().unwrap()).collect::<Vec<f64>>())
    };
    let (titles, numbers) = predicted("--missing drop");
    assert_eq!(titles, "row,y");
    assert_close(&numbers, &[0.0, 9.0, 2.0, 13.0, 5.0, 19.0], 1e-12);
    let (titles, numbers) = predicted("--missing nan");
    assert_eq!((titles.as_str(), numbers.len()), ("y", 6));
    let shown = folder.succeed("predict fit.json new.csv --missing drop");
    let rows: Vec<&str> =
        shown.lines().skip(2).filter_map(|line| line.split_whitespace().next()).collect();
    assert_eq!(rows, ["0", "2", "5"], "{shown}");
}

#[test]
fn factors_have_the_coefficients_of_r_and_predict_by_their_levels() {
    // lm(mpg ~ wt + factor(cyl))
    let folder = Folder::new();
    let fields = |line: &str| -> String {
        let fields: Vec<&str> = line.split(',').collect();
        [fields[0], fields[1], fields[5]].join(",")
    };
    let table: Vec<String> = MTCARS.lines().map(fields).collect();
    folder.write("cars.csv", table.join("\n"));
    let report =
        folder.succeed("lstsq cars.csv --by-column mpg --intercept --factor cyl -o x.json");
    assert!(report.contains("cyl: 3 levels, compared with 4"), "{report}");
    let json = fs::read_to_string(folder.path("x.json")).unwrap();
    let found: Value = serde_json::from_str(&json).unwrap();
    assert_eq!(found["columns"], json!(["cyl[6]", "cyl[8]", "wt"]));
    assert_eq!(found["terms"][0], json!({"column": "cyl", "levels": ["4", "6", "8"]}));
    let numbers = |name: &str| -> Vec<f64> {
        let values = found["targets"][0][name].as_array().unwrap();
        values.iter().map(|x| x.as_f64().unwrap()).collect()
    };
    let x = [-4.255582401971285, -6.070859680490879, -3.2056132561928647];
    assert_close(&numbers("x"), &x, 1e-12);
    let p = [0.004717833899868905, 0.0009991893236754117, 0.00021304346026846004];
    assert_close(&numbers("p"), &p, 1e-12);
    let note = noted(&folder, "lstsq cars.csv --by-column mpg --factor 1");
    let said =
        "cars.csv: without --intercept the base of each factor has the coefficient 0: cyl[4]";
    assert!(note.contains(said), "{note}");
    // Another base: the same model.
    folder.succeed("lstsq cars.csv --by-column mpg --intercept --factor cyl=8 -o y.json");
    folder.write("new.csv", "cyl,wt\n6,3\n8,3\n4,2.5\n");
    let predicted = |model: &str| -> Vec<f64> {
        folder.succeed(&format!("predict {model} new.csv -o p.csv --force"));
        let text = fs::read_to_string(folder.path("p.csv")).unwrap();
        text.lines().skip(1).map(|line| line.parse().unwrap()).collect()
    };
    assert_close(&predicted("x.json"), &predicted("y.json"), 1e-13);
    folder.write("new.csv", "cyl,wt\n5,3\n");
    let message = folder.fail("predict x.json new.csv");
    let says = "new.csv: column cyl: the fit has no level 5, but ";
    assert!(message.contains(says) && message.contains("in row 0"), "{message}");
    for (option, said) in [
        ("cyl=5", "cars.csv: factor: cyl has no level 5, but 4, 6, 8"),
        ("color", "cars.csv: no column color for --factor; A has cyl, wt"),
        (
            "cyl --columns mpg,wt",
            "cars.csv: no column cyl for --factor; A has wt; --columns leaves out the others",
        ),
    ] {
        let message = folder.fail(&format!("lstsq cars.csv --by-column mpg --factor {option}"));
        assert!(message.contains(said), "{message}");
    }
}

/// Tables as R's `write.csv` writes its data sets, and what 60 digits give: set, term, and three
/// numbers of each (`scripts/differential-statistics --expected`).
const AIRQUALITY: &str = include_str!("../../../tests/common/tables/airquality.csv");
const TOOTH_GROWTH: &str = include_str!("../../../tests/common/tables/ToothGrowth.csv");
const WARPBREAKS: &str = include_str!("../../../tests/common/tables/warpbreaks.csv");
const EXPECTED: &str = include_str!("../../../tests/common/tables/expected.csv");

#[test]
fn tables_of_r_have_the_statistics_of_multiprecision_by_one_command() {
    let folder = Folder::new();
    let columns = "--columns Ozone,Solar.R,Wind,Temp,Month --missing drop";
    for (set, text, options, left_out) in [
        ("airquality", AIRQUALITY, format!("Ozone --factor Month {columns}"), 42),
        ("ToothGrowth", TOOTH_GROWTH, "len --factor supp=VC,dose".into(), 0),
        ("warpbreaks", WARPBREAKS, "breaks --factor wool --factor tension=L".into(), 0),
    ] {
        folder.write(&format!("{set}.csv"), text);
        let output = format!("{set}.json");
        folder.succeed(&format!("lstsq {set}.csv --intercept --by-column {options} -o {output}"));
        let json = fs::read_to_string(folder.path(&output)).unwrap();
        let found: Value = serde_json::from_str(&json).unwrap();
        assert_eq!(found["left_out"], json!(left_out), "{set}");
        let columns = found["columns"].as_array().unwrap();
        let target = &found["targets"][0];
        let number = |value: &Value| value.as_f64().unwrap();
        let of_set = |line: &'static str| line.strip_prefix(set)?.strip_prefix(',');
        let mut terms = 0;
        for line in EXPECTED.lines().filter_map(of_set) {
            let (term, right) = line.split_once(',').unwrap();
            let right: Vec<f64> = right.split(',').map(|x| x.parse().unwrap()).collect();
            let found = match columns.iter().position(|column| column == term) {
                Some(j) => ["x", "standard_error", "p"].map(|name| number(&target[name][j])),
                None if term == "F" => {
                    ["r_squared", "f_statistic", "f_p"].map(|name| number(&target[name]))
                }
                None => ["", "_error", "_p"].map(|end| number(&target[format!("intercept{end}")])),
            };
            assert_close(&found, &right, 1e-12);
            terms += 1;
        }
        assert_eq!(terms, columns.len() + 2, "{set}");
    }
}

#[test]
fn rows_with_missing_values_are_left_out_on_request_and_counted() {
    let folder = Folder::new();
    let nan = f64::NAN;
    let rows = [
        [1.0, 0.5, 2.0],
        [nan, 1.0, 1.0],
        [2.0, 0.25, 3.5],
        [3.0, 2.0, nan],
        [4.0, -1.0, 5.0],
        [5.0, 7.0, 4.0],
    ];
    folder.write_npy("a.npy", &[6, 3], &rows.concat());
    let complete: Vec<[f64; 3]> =
        rows.into_iter().filter(|row| row.iter().all(|x| !x.is_nan())).collect();
    folder.write_npy("b.npy", &[4, 3], &complete.concat());
    folder.write("w.csv", "1\n9\n2\n9\n0\n1\n");
    folder.write("v.csv", "1\n2\n0\n1\n");
    let line = "lstsq a.npy --by-column 2 --intercept --weights w.csv -o x.json";
    let message = folder.fail(line);
    assert!(message.contains("NaN at row 1, column 0"), "{message}");
    let run = folder.run(&format!("{line} --missing drop"));
    assert_eq!(run.code, Some(0), "{}", run.stderr);
    let note = "note: a.npy: 2 rows with a missing cell left out, 4 used";
    assert!(run.stderr.contains(note), "{}", run.stderr);
    assert!(run.stdout.contains("rows        4, 2 left out"), "{}", run.stdout);
    assert!(run.stdout.contains("weighted    3 rows"), "{}", run.stdout);
    folder.succeed("lstsq b.npy --by-column 2 --intercept --weights v.csv -o y.json");
    let read = |name: &str| -> Value {
        serde_json::from_str(&fs::read_to_string(folder.path(name)).unwrap()).unwrap()
    };
    let (x, y) = (read("x.json"), read("y.json"));
    assert_eq!((&x["targets"], &x["degrees_of_freedom"]), (&y["targets"], &json!(0)));
    assert_eq!((&x["left_out"], &y["left_out"]), (&json!(2), &json!(0)));
    let message = folder.fail("lstsq a.npy --by-column 2 --factor 0");
    assert!(message.contains("a.npy: a value is missing in row 1 (counted from 0)"), "{message}");
    assert!(message.contains("--missing drop"), "{message}");
    // The value that is missing first is one of B.
    folder.write("g.csv", "x,g\n1,a\n2,b\n3,a\n4,b\n5,a\n");
    folder.write("y.csv", "y\n1\nNA\n3\n4\n6\n");
    let line = "lstsq g.csv y.csv --factor g --missing";
    let message = folder.fail(&format!("{line} nan"));
    let says = "y.csv: a value is missing in row 1 (counted from 0), column y; --missing drop";
    assert!(message.contains(says) && !message.contains("g.csv: a value"), "{message}");
    let run = folder.run(&format!("{line} drop"));
    let note = "note: g.csv, y.csv: 1 row with a missing cell left out, 4 used";
    assert!(run.code == Some(0) && run.stderr.contains(note), "{}", run.stderr);
}

#[test]
fn factors_of_words_are_fitted_and_predicted_by_their_levels() {
    let folder = Folder::new();
    // Differences of 10 and 20 from Bonn, and a slope of 3.
    folder.write(
        "a.csv",
        "ort;note;x;y\nUlm;gut;1,5;24,5\nBonn;so;1;3\nKiel;gut;2;16\nBonn;NA;2;6\n\
         NA;so;7;1\nUlm;gut;0;20\nKiel;;0;10\nUlm;so;NA;2\n",
    );
    let fit = "lstsq a.csv --by-column y --intercept --factor ort";
    let message = folder.fail(fit);
    let missing = "a.csv:6: column 1 (ort): \"NA\" where a word should be";
    assert!(message.contains(missing), "{message}");
    let run = folder.run(&format!("{fit} --missing drop -o x.json"));
    assert_eq!(run.code, Some(0), "{}", run.stderr);
    // A missing cell in a column that is not used drops no row.
    assert!(run.stderr.contains("1 text column left out (note)"), "{}", run.stderr);
    assert!(
        run.stderr.contains("a.csv: 2 rows with a missing cell left out, 6 used"),
        "{}",
        run.stderr
    );
    assert!(run.stdout.contains("ort: 3 levels, compared with Bonn"), "{}", run.stdout);
    let json = fs::read_to_string(folder.path("x.json")).unwrap();
    let found: Value = serde_json::from_str(&json).unwrap();
    assert_eq!(found["columns"], json!(["ort[Kiel]", "ort[Ulm]", "x"]));
    let x: Vec<f64> =
        found["targets"][0]["x"].as_array().unwrap().iter().map(|x| x.as_f64().unwrap()).collect();
    assert_close(&x, &[10.0, 20.0, 3.0], 1e-13);
    // Other columns, another order, and levels that the model has.
    folder.write("new.csv", "x,z,ort\n2,NA,Ulm\nNA,1,Bonn\n4,2,Bonn\n");
    let message = folder.fail("predict x.json new.csv");
    assert!(message.contains("new.csv:3: column 1 (x): \"NA\""), "{message}");
    let predicted = |missing: &str| -> Vec<f64> {
        folder.succeed(&format!("predict x.json new.csv --missing {missing} -o p.csv --force"));
        let text = fs::read_to_string(folder.path("p.csv")).unwrap();
        let last = |line: &str| line.rsplit(',').next().unwrap().parse().unwrap();
        text.lines().skip(1).map(last).collect()
    };
    assert_close(&predicted("drop"), &[26.0, 12.0], 1e-13);
    let all = predicted("nan");
    assert!(all.len() == 3 && all[1].is_nan());
    assert_close(&[all[0], all[2]], &[26.0, 12.0], 1e-13);
    folder.write("other.csv", "x,ort\n2,Ulm\n4,Jena\n");
    let message = folder.fail("predict x.json other.csv");
    assert!(
        message.contains("other.csv: column ort: the fit has no level Jena, but Bonn, Kiel, Ulm"),
        "{message}"
    );
    // One word among numbers makes a factor of words.
    folder.write("mixed.csv", "k,y\n10,1\n9,2\nx,4\n9,2\n10,1\n");
    let report = folder.succeed("lstsq mixed.csv --by-column y --intercept --factor k=9");
    assert!(report.contains("k: 3 levels, compared with 9"), "{report}");
    let message = folder.fail("lstsq mixed.csv --by-column k --factor k");
    assert!(message.contains("mixed.csv: column k has words: a factor is no target"), "{message}");
}

#[test]
fn levels_that_are_the_same_number_are_never_two() {
    let folder = Folder::new();
    // In a column of numbers they are one level.
    folder.write("numbers.csv", "k,y\n1,1\n1.0,3\n2,5\n2,7\n");
    let fit = "--by-column y --intercept --factor k";
    let report = folder.succeed(&format!("lstsq numbers.csv {fit} -o x.json"));
    assert!(report.contains("k: 2 levels, compared with 1"), "{report}");
    // A word makes a column of words, in a row that is left out.
    folder.write("words.csv", "k,y\n1,1\n1.0,3\n2,5\n2,7\nx,NA\n");
    let message = folder.fail(&format!("lstsq words.csv {fit} --missing drop"));
    let same = "words.csv: factor: k has the levels 1 and 1.0, which are the same number";
    assert!(message.contains(same), "{message}");
    // The level that the fit lacks is the word.
    let message = folder.fail("predict x.json words.csv");
    assert!(message.contains("column k: the fit has no level x, but 1, 2"), "{message}");
}

#[test]
fn factors_of_many_levels_are_fitted_as_their_columns_are() {
    let folder = Folder::new();
    let level = |i: usize| format!("l{:02}", i * 7 % 45);
    let numbers = |i: usize| format!("{},{}", (i * i) as f64 / 7.0, (i * 31 % 57) as f64 / 3.0);
    let (mut table, mut columns) = ("k,x,y\n".to_owned(), String::new());
    columns += &(1..45).map(|l| format!("k[l{l:02}],")).collect::<String>();
    columns += "x,y\n";
    for i in 0..200 {
        table += &format!("{},{}\n", level(i), numbers(i));
        for l in 1..45 {
            columns += if level(i) == format!("l{l:02}") { "1," } else { "0," };
        }
        columns += &format!("{}\n", numbers(i));
    }
    folder.write("a.csv", table);
    folder.write("b.csv", columns);
    folder.write("w.csv", (0..200).map(|i| format!("{}\n", i % 4)).collect::<String>());
    let targets = |line: &str| -> Value {
        folder.succeed(&format!("lstsq {line} --by-column y --intercept -o x.json --force"));
        let found = fs::read_to_string(folder.path("x.json")).unwrap();
        let found: Value = serde_json::from_str(&found).unwrap();
        assert_eq!(found["columns"].as_array().unwrap().len(), 45);
        found["targets"].clone()
    };
    for weights in ["", "--weights w.csv"] {
        let right = targets(&format!("b.csv {weights}"));
        for threads in [1, 3] {
            let line = format!("a.csv --factor k {weights} --threads {threads} --block-rows 30");
            assert_eq!(targets(&line), right, "{line}");
        }
    }
}

#[test]
fn rows_of_two_files_with_missing_cells_are_left_out_together() {
    let folder = Folder::new();
    folder.write("a.csv", "x\n1\nNA\n3\n4\n7\n");
    folder.write("b.csv", "y\n1\n2\nNA\n5\n6\n");
    folder.write("w.csv", "1\n9\n9\n2\n3\n");
    folder.write("c.csv", "x,y,w\n1,1,1\n4,5,2\n7,6,3\n");
    folder.write("v.csv", "1\n2\n3\n");
    folder.succeed("lstsq a.csv b.csv --weights w.csv --missing drop -o x.json");
    folder.succeed("lstsq c.csv --columns x,y --by-column y --weights v.csv -o y.json");
    let read = |name: &str| -> Value {
        serde_json::from_str(&fs::read_to_string(folder.path(name)).unwrap()).unwrap()
    };
    let (x, y) = (read("x.json"), read("y.json"));
    assert_eq!((&x["targets"], &x["left_out"]), (&y["targets"], &json!(2)));
    let components = |command: &str| -> Vec<String> {
        let report = folder.succeed(command);
        report
            .lines()
            .skip_while(|line| !line.starts_with("component"))
            .map(str::to_owned)
            .collect()
    };
    folder.write_npy("a.npy", &[3, 2], &[1.0, 2.0, f64::NAN, 5.0, 3.0, 1.0]);
    folder.write_npy("b.npy", &[2, 2], &[1.0, 2.0, 3.0, 1.0]);
    folder.write("u.csv", "1\n9\n2\n");
    folder.write("t.csv", "1\n2\n");
    let left = components("pca a.npy --missing drop --weights u.csv");
    assert_eq!(left, components("pca b.npy --weights t.csv"));
    assert!(folder.fail("pca a.npy").contains("NaN at row 1, column 0"));
}

#[test]
fn weights_count_as_repetitions_and_ridge_shrinks() {
    let folder = Folder::new();
    let rows = [[1.0, 2.0, 3.0], [4.0, -1.0, 1.0], [2.0, 2.0, 9.0], [7.0, 5.0, -2.0]];
    let weights = [3.0, 0.0, 1.0, 2.0];
    folder.write("a.csv", csv(&rows.concat(), 3));
    folder.write("w.csv", csv(&weights, 1));
    let repeated = rows.iter().zip(weights).flat_map(|(row, w)| vec![*row; w as usize]);
    folder.write("r.csv", csv(&repeated.collect::<Vec<_>>().concat(), 3));
    folder.succeed("lstsq a.csv --by-column 2 --weights w.csv --intercept -o x.npz");
    folder.succeed("lstsq r.csv --by-column 2 --intercept -o y.npz");
    let (x, y) = (arrays(&folder, "x.npz"), arrays(&folder, "y.npz"));
    assert_eq!(x.matrix("x").unwrap(), y.matrix("x").unwrap());
    for name in ["intercept", "r_squared", "residual_norm"] {
        assert_eq!(x.vector(name).unwrap(), y.vector(name).unwrap(), "{name}");
    }
    folder.write("i.csv", "1,0,2\n0,1,4\n");
    folder.succeed("lstsq i.csv --by-column 2 --ridge 1 -o z.npz");
    assert_eq!(arrays(&folder, "z.npz").matrix("x").unwrap(), mat![[1.0], [2.0]]);
}

#[test]
fn dependent_columns_give_the_solution_of_least_norm_and_a_note() {
    let folder = Folder::new();
    folder.write("a.csv", "u,v,y\n1,1,2\n2,2,4\n");
    let note = noted(&folder, "lstsq a.csv --by-column y -o x.npz");
    assert!(note.starts_with("note: a.csv: column "), "{note}");
    assert!(note.contains("depends on others; X is the solution of least norm"), "{note}");
    let found = arrays(&folder, "x.npz");
    assert_eq!(found.matrix("x").unwrap(), mat![[1.0], [1.0]]);
    assert_eq!(found.indices("rank").unwrap(), [1]);
    let message = folder.fail("lstsq a.csv --by-column y --refuse-dependent -o y.npz");
    assert!(message.contains("a.csv: column ") && message.contains("depends on"), "{message}");
    // A prediction for a row in which v is not u is arbitrary; a note says so.
    folder.succeed("lstsq a.csv --by-column y -o x.json");
    folder.write("new.csv", "u,v\n1,3\n");
    let note = noted(&folder, "predict x.json new.csv");
    assert!(
        note.starts_with("note: x.json: column ")
            && note.ends_with(
                " depends on others in the rows of the fit: predictions of rows where this is not \
                 so are arbitrary\n"
            ),
        "{note}"
    );
    // Fewer rows than columns.
    folder.write("wide.csv", "3,4,25\n");
    noted(&folder, "lstsq wide.csv --by-column 2 -o z.npz");
    assert_eq!(arrays(&folder, "z.npz").matrix("x").unwrap(), mat![[3.0], [4.0]]);
}

#[test]
fn many_columns_are_cut_short_on_the_screen() {
    let folder = Folder::new();
    let (m, n) = (80, 60);
    folder.write_npy("a.npy", &[m as u64, n as u64], &table(m, n));
    let report = folder.succeed("lstsq a.npy --by-column 59");
    assert!(report.contains("... and 9 more"), "{report}");
    let report = folder.succeed("svd a.npy");
    assert!(report.contains("... and 10 more"), "{report}");
}

#[test]
fn errors_name_the_file_and_the_cause() {
    let folder = Folder::new();
    folder.write("a.csv", "x,y\n1,2\n3,5\n5,4\n");
    folder.write("short.csv", "1\n2\n");
    folder.write("minus.csv", "1\n-1\n1\n");
    folder.write("nan.csv", "1,2\n3,nan\n5,4\n");
    folder.write_npy("nan.npy", &[2, 2], &[1.0, 2.0, 3.0, f64::NAN]);
    folder.write("b.csv", "1\n2\ninf\n");
    folder.write_npy::<f64>("none.npy", &[0, 3], &[]);
    folder.write_npy::<f64>("thin.npy", &[3, 0], &[]);
    folder.write_npy("three.npy", &[3, 3], &table(3, 3));
    folder.write("zero.csv", "0\n0\n0\n");
    folder.write("one.csv", "1,2\n");
    folder.write("unit.csv", "1\n");
    folder.write("far.csv", "x,y,z\n1,1e-170,1\n3,2e-170,2\n5,5e-170,1\n");
    folder.write("long.csv", "1e200\n2\n3\n");
    folder.write("old.npz", "precious");
    for (arguments, expected) in [
        ("lstsq far.csv --by-column x", "far.csv: the squared length of column y is out of the"),
        ("lstsq far.csv --columns 1..3 --by-column z", "far.csv: the squared length of column y"),
        ("lstsq a.csv long.csv", "long.csv: the squared length of column 0 is out of the range"),
        ("pca far.csv -o x.npz", "far.csv: the squared length of column y is out of the range"),
        ("svd long.csv -o x.npz", "long.csv: the squared length of column 0 is out of the range"),
        ("lstsq a.csv short.csv", "short.csv: 2 x 1 where the 3 rows of a.csv need 3 rows"),
        ("lstsq a.csv --by-column z -o x.npz", "a.csv: no column z for --by-column; A has x, y"),
        ("lstsq a.csv --by-column y --weights short.csv", "short.csv: 2 x 1 where the 3 rows"),
        (
            "lstsq a.csv --by-column y --weights minus.csv -o x.npz",
            "minus.csv: weights: weight 1 (counted from 0) is negative: -1",
        ),
        ("pca a.csv --weights minus.csv", "minus.csv: weights: weight 1"),
        ("lstsq nan.csv --by-column 1 -o x.npz", "nan.csv:2: column 2: \"nan\" where a"),
        ("lstsq a.csv b.csv -o x.npz", "b.csv: inf at row 2, column 0"),
        ("pca nan.csv -o x.npz --missing nan", "nan.csv: NaN at row 1, column 1"),
        ("svd nan.csv -o x.npz --left --missing nan", "nan.csv: NaN at row 1, column 1"),
        ("lstsq a.csv --by-column y -o old.npz", "old.npz: exists already (--force"),
        ("pca a.csv -o old.npz", "old.npz: exists already (--force"),
        ("svd a.csv -o old.npz", "old.npz: exists already (--force"),
        ("svd a.csv --checkpoint old.npz", "old.npz: exists already (--force"),
        ("lstsq a.csv --by-column y -o x.csv", "x.csv: the name must end in .json, .npz, .h5"),
        ("lstsq a.csv --by-column y -o x.npy", "x.npy: the name must end in .json, .npz, .h5"),
        ("lstsq a.csv --by-column y --ridge -1", "--ridge -1: a finite number of at least 0"),
        ("lstsq absent.npy --by-column 0", "absent.npy"),
        // Before A is read: there is a NaN in it.
        ("pca nan.npy -k 3", "nan.npy: -k 3, where there are 2 columns"),
        ("pca none.npy -o x.npz", "none.npy: no rows"),
        ("lstsq none.npy --by-column 0 --intercept", "none.npy: no rows"),
        ("lstsq none.npy --by-column 0", "none.npy: no rows"),
        ("lstsq none.npy none.npy -o x.npz", "none.npy: no rows"),
        ("lstsq thin.npy minus.csv", "thin.npy: no columns"),
        ("lstsq a.csv thin.npy -o x.npz", "thin.npy: no columns"),
        ("lstsq minus.csv --by-column 0", "minus.csv: no columns besides those of --by-column"),
        ("svd thin.npy", "thin.npy: no columns"),
        ("pca a.csv --weights zero.csv", "zero.csv: all weights are zero"),
        ("pca one.csv", "one.csv: one row, but a variance needs two"),
        ("pca one.csv --weights unit.csv", "unit.csv: the --weights add up to 1, but a variance"),
        ("lstsq a.csv --by-column y --weights zero.csv", "zero.csv: all weights are zero"),
        ("ata a.csv --center --weights zero.csv", "zero.csv: weights: they sum to zero"),
        ("ata a.csv --center --weights zero.csv --scheme exact", "zero.csv: weights: they sum to"),
        ("pca a.csv --picture p.jpg", "p.jpg: the name of a picture must end in .png or .svg"),
    ] {
        let message = folder.fail(arguments);
        assert!(message.contains(expected), "{arguments}: {message}");
    }
    assert_eq!(bytes(&folder, "old.npz"), b"precious");
    for arguments in [
        "lstsq a.csv",
        "lstsq a.csv b.csv --by-column y",
        "svd a.csv --left",
        "pca a.csv -k 0",
        "svd a.csv --columns 1..1",
        "pca a.csv --variance 1.5",
        "pca a.csv --variance 0",
    ] {
        assert_eq!(folder.run(arguments).code, Some(2), "{arguments}");
    }
}

#[test]
fn components_scores_and_shares_of_a_line() {
    let folder = Folder::new();
    folder.write("a.csv", "1,1\n3,3\n5,5\n");
    let report = folder.succeed("pca a.csv -o pca.npz --scores --picture scree.svg");
    assert!(report.contains("kept        1 components of 2 columns"), "{report}");
    assert!(report.contains("variance     share  cumulative\n"), "{report}");
    let found = arrays(&folder, "pca.npz");
    let close = |found: &[f64], expected: &[f64]| assert_close(found, expected, 1e-14);
    close(&found.vector("explained_variance").unwrap(), &[8.0]);
    close(&found.vector("explained_variance_ratio").unwrap(), &[1.0]);
    close(&found.vector("singular_values").unwrap(), &[4.0]);
    assert_eq!(found.vector("mean").unwrap(), [3.0, 3.0]);
    assert_eq!(found.vector("scale").unwrap(), [1.0, 1.0]);
    let half = 0.5_f64.sqrt();
    assert!((found.matrix("components").unwrap() - mat![[half, half]]).norm_l2() < 1e-15);
    let root = 8_f64.sqrt();
    let scores = mat![[-root], [0.0], [root]];
    assert!((found.matrix("scores").unwrap() - scores).norm_l2() < 1e-14);
    let svg = fs::read_to_string(folder.path("scree.svg")).unwrap();
    assert!(svg.contains("share of the variance") && svg.ends_with("</svg>\n"), "{svg}");
}

#[test]
fn whitened_scores_of_standardized_columns_are_uncorrelated_with_variance_one() {
    let folder = Folder::new();
    // More rows than a block of the second pass.
    let (m, n) = (5003, 4);
    let mut a = table(m, n);
    a.iter_mut().enumerate().for_each(|(i, x)| *x += (i % n * i % 31) as f64);
    folder.write_npy("a.npy", &[m as u64, n as u64], &a);
    folder.succeed("pca a.npy -k 3 --standardize --whiten --scores -o pca.npz");
    let found = arrays(&folder, "pca.npz");
    let scores = found.matrix("scores").unwrap();
    assert_eq!(scores.shape(), (m, 3));
    let covariance = scores.transpose() * &scores * (1.0 / (m as f64 - 1.0));
    assert!((covariance - Mat::<f64>::identity(3, 3)).norm_l2() < 1e-12);
    let mean = Mat::<f64>::full(1, m, 1.0) * &scores;
    assert!(mean.norm_l2() < 1e-9);
    // The variances of standardized columns sum to their number.
    let variance: f64 = found.vector("explained_variance").unwrap().iter().sum();
    let ratio: f64 = found.vector("explained_variance_ratio").unwrap().iter().sum();
    assert!((variance - n as f64 * ratio).abs() < 1e-12);
    folder.succeed("pca a.npy --variance 0.7 --standardize -o share.npz");
    let few = arrays(&folder, "share.npz").vector("explained_variance_ratio").unwrap();
    assert!(few.iter().sum::<f64>() >= 0.7 && few[..few.len() - 1].iter().sum::<f64>() < 0.7);
}

#[test]
fn correlations_of_columns_are_written_and_those_of_a_constant_are_nan() {
    let folder = Folder::new();
    folder.write_npy("a.npy", &[3, 3], &[1.0_f64, 1.0, 5.0, 2.0, 3.0, 5.0, 3.0, 2.0, 5.0]);
    folder.succeed("pca a.npy --correlations r.npy");
    let found = folder.read_npy::<f64>("r.npy", &[3, 3]);
    assert_close(&[found[0], found[1], found[3], found[4]], &[1.0, 0.5, 0.5, 1.0], 1e-15);
    assert!([2, 5, 6, 7, 8].iter().all(|&i| found[i].is_nan()), "{found:?}");
    assert!(folder.fail("pca a.npy --correlations r.npy").contains("exists already"));
    assert!(folder.fail("pca a.npy --correlations r.npz").contains("r.npz"));
}

#[test]
fn singular_values_keep_their_digits_and_the_factors_give_a() {
    let folder = Folder::new();
    folder.write("a.csv", "3,0,0\n0,1e-9,0\n0,0,0\n0,0,0\n");
    let report = folder.succeed("svd a.csv -o svd.npz --left --orthogonality");
    assert!(report.contains("rank        2 of 3 columns"), "{report}");
    let distance = "A^T A - I   largest entry 8.000000e0, Frobenius norm 8.124038e0";
    assert!(report.contains(distance), "{report}");
    let found = arrays(&folder, "svd.npz");
    assert_eq!(found.vector("values").unwrap(), [3.0, 1e-9, 0.0]);
    assert_eq!(
        (found.matrix("u").unwrap().shape(), found.matrix("v").unwrap().shape()),
        ((4, 2), (3, 2))
    );
    // Singular values that are too far from the largest leave no digits of u.
    folder.write("far.csv", "3,1e-30\n0,2e-30\n4,1e-30\n");
    let note = noted(&folder, "svd far.csv -o far.npz --left");
    let digits = "note: far.csv: the last 1 of 2 columns of u have fewer than three correct digits";
    assert!(note.starts_with(digits), "{note}");
    assert_eq!(noted(&folder, "svd far.csv -o far.npz --force"), "");

    let (m, n) = (4999, 6);
    let a = table(m, n);
    folder.write_npy("a.npy", &[m as u64, n as u64], &a);
    folder.succeed("svd a.npy -o svd.npz --left --force");
    let found = arrays(&folder, "svd.npz");
    let (u, v) = (found.matrix("u").unwrap(), found.matrix("v").unwrap());
    assert!((u.transpose() * &u - Mat::<f64>::identity(n, n)).norm_l2() < 1e-12);
    let values = found.vector("values").unwrap();
    let scaled = Mat::from_fn(m, n, |i, j| u[(i, j)] * values[j]);
    let product = scaled * v.transpose();
    let difference = Mat::from_fn(m, n, |i, j| product[(i, j)] - a[i * n + j]);
    assert!(difference.norm_max() < 1e-12);
}

/// Runs a command until it is killed after it has saved its sums in `sums`.
fn kill_after_a_checkpoint(folder: &Folder, arguments: &str) {
    loop {
        let mut command = folder.program();
        command.args(arguments.split_whitespace()).stdout(Stdio::piped()).stderr(Stdio::piped());
        let mut child = command.spawn().unwrap();
        while child.try_wait().unwrap().is_none() && !folder.path("sums").exists() {
            std::thread::sleep(std::time::Duration::from_millis(1));
        }
        child.kill().unwrap();
        let run = Run::new(child.wait_with_output().unwrap());
        if run.code.is_none() {
            break;
        }
        // It was faster than the kill.
        assert_eq!(run.code, Some(0), "{}", run.stderr);
        fs::remove_file(folder.path("x.npz")).unwrap();
    }
}

#[test]
fn a_run_that_was_killed_goes_on_to_the_same_bytes() {
    let folder = Folder::new();
    let (m, n) = (60_000, 24);
    folder.write_npy("a.npy", &[m as u64, n as u64], &table(m, n));
    let options = "lstsq a.npy --by-column 0 --intercept --block-rows 300";
    folder.succeed(&format!("{options} -o whole.npz"));
    let arguments = format!("{options} -o x.npz --checkpoint sums --checkpoint-every 0 --resume");
    kill_after_a_checkpoint(&folder, &arguments);
    let other = arguments.replace("--intercept", "");
    let message = folder.fail(&other);
    assert!(message.contains("sums: accumulator: centring was mean, and is none now"), "{message}");
    let report = folder.succeed(&arguments);
    assert!(report.contains("resumed     sums: row "), "{report}");
    assert!(bytes(&folder, "x.npz") == bytes(&folder, "whole.npz"));
    assert!(!folder.path("sums").exists(), "the checkpoint is removed in the end");
}

#[test]
fn a_run_that_leaves_rows_out_goes_on_with_the_same_rows_only() {
    let folder = Folder::new();
    let (m, n) = (60_000, 24);
    let mut a = table(m, n);
    for row in [5, 30_000, m - 1] {
        a[row * n + 3] = f64::NAN;
    }
    folder.write_npy("a.npy", &[m as u64, n as u64], &a);
    let options = "lstsq a.npy --by-column 0 --missing drop --block-rows 300";
    folder.succeed(&format!("{options} -o whole.npz"));
    let arguments = format!("{options} -o x.npz --checkpoint sums --checkpoint-every 0 --resume");
    kill_after_a_checkpoint(&folder, &arguments);
    let message = folder.fail(&arguments.replace(" --missing drop", ""));
    let says = "sums: made with other options: --missing drop was given, and is not now";
    assert!(message.contains(says), "{message}");
    let report = folder.succeed(&arguments);
    assert!(report.contains("resumed     sums: row "), "{report}");
    assert!(bytes(&folder, "x.npz") == bytes(&folder, "whole.npz"));
}

#[test]
fn sums_of_another_kind_are_not_gone_on_with() {
    let (folder, _) = with_input(37, 5);
    folder.succeed("ata a.npy --accumulator sums");
    let message = folder.fail("svd a.npy --checkpoint sums --resume");
    assert!(message.contains("sums: accumulator: sums was nothing, and is extended"), "{message}");
}

/// Inputs of the guides.
fn guide_folder() -> Folder {
    let folder = Folder::new();
    folder.write("longley.csv", LONGLEY);
    let (m, n) = (200, 6);
    folder.write_npy("A.npy", &[m as u64, n as u64], &table(m, n));
    folder.write_npy("b.npy", &[m as u64], &table(m, 1));
    let weights: Vec<f64> = (0..m).map(|i| (i % 4) as f64).collect();
    folder.write_npy("w.npy", &[m as u64], &weights);
    folder.write("cars.csv", MTCARS);
    folder.write("airquality.csv", AIRQUALITY);
    folder
}

#[test]
fn the_commands_of_the_guides_run() {
    let guides = [
        include_str!("../../../docs/guide/least-squares.md"),
        include_str!("../../../docs/guide/principal-components.md"),
    ];
    for guide in guides {
        let folder = guide_folder();
        calls(guide).into_iter().for_each(|call| drop(folder.succeed(call)));
    }
}
