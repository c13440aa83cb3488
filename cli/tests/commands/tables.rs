//! Tables as people have them: the options of all commands that read matrices, and what they say.

use std::collections::BTreeSet;
use std::fs;
use std::io::Write;
use std::path::Path;
use std::process::Stdio;

use crate::common::{Folder, oracle};

/// What `ata` computes of `[[1, 2], [3, 5], [4, 4]]`.
const C: [f64; 4] = [26.0, 33.0, 33.0, 45.0];

#[test]
fn options_decide_what_a_file_leaves_open_in_every_command() {
    let folder = Folder::new();
    folder.write("names.csv", "400,410\n0.10,0.20\n0.11,0.25\n0.15,0.10\n");
    folder
        .write("quoted.csv", "x,y\n\"10,000\",\"5,500\"\n\"12,500\",\"6,100\"\n\"9,750\",\"4\"\n");
    folder.write("missing.csv", "x,y\n1,2\nNA,3\n4,5\n6,9\n");
    for (file, asked, decides) in [
        ("names.csv", "--header or --no-header", "--no-header"),
        ("quoted.csv", "--decimal or --thousands", "--thousands comma"),
        ("missing.csv", "--missing drop", "--missing drop"),
    ] {
        for command in ["ata FILE", "lstsq FILE --by-column 1", "pca FILE", "svd FILE"] {
            let command = command.replace("FILE", file);
            let said = folder.fail(&command);
            assert!(said.contains(&format!("{file}:")) && said.contains(asked), "{said}");
            folder.succeed(&format!("{command} {decides}"));
        }
    }
}

#[test]
fn columns_are_names_numbers_ranges_or_lists_of_every_format() {
    let folder = Folder::new();
    folder.write("a.csv", "id,x,y,z\nu,9,1,2\nv,8,3,5\nw,7,4,4\n");
    for columns in ["y,z", "2..4", "2,z"] {
        folder.succeed(&format!("ata a.csv --columns {columns} -o c.npy --force"));
        assert_eq!(folder.read_npy::<f64>("c.npy", &[2; 2]), C, "{columns}");
    }
    let said = folder.fail("ata a.csv --columns id,y");
    assert!(said.contains("a.csv:2: column id has words, such as \"u\""), "{said}");
    let said = folder.fail("ata a.csv --columns q");
    assert!(said.contains("a.csv: columns: no column q; the columns are id, x, y, z"), "{said}");
    folder.write("years.csv", "k,1990,1991\n1,2,3\n4,5,7\n");
    let said = folder.fail("ata years.csv --columns 1990..1991");
    assert!(said.contains("1..3 ends with 1991, 1..2 before it"), "{said}");
    folder.write("b.csv", "5,1,2\n6,3,5\n7,4,4\n");
    folder.write_npy("b.npy", &[3, 3], &[5.0, 1.0, 2.0, 6.0, 3.0, 5.0, 7.0, 4.0, 4.0]);
    for file in ["b.csv", "b.npy"] {
        folder.succeed(&format!("ata {file} --columns 2,1 -o c.npy --force"));
        assert_eq!(folder.read_npy::<f64>("c.npy", &[2; 2]), [45.0, 33.0, 33.0, 26.0], "{file}");
    }
}

#[test]
fn what_was_decided_is_said_once() {
    let folder = Folder::new();
    folder.write("a.csv", "ort;x;y\nUlm;1,0;2\nBonn;3,0;5\nKiel;4,0;4\n");
    let run = folder.run("ata a.csv -o c.npy");
    let said = "note: a.csv: separator ;, decimal comma, header, 1 text column left out (ort)\n";
    assert_eq!((run.code, run.stderr.as_str()), (Some(0), said));
    assert_eq!(folder.read_npy::<f64>("c.npy", &[2; 2]), C);
    let said = folder.succeed("--json ata a.csv -o c.npy --force");
    assert!(said.contains(r#""record":"table","path":"a.csv","separator":";""#), "{said}");
    folder.write("b.csv", "x,y\n1,2\n3,5\n4,4\n");
    assert_eq!(folder.run("ata b.csv").stderr, "");
    folder.write("d.csv", "x,id\n1.5,2\n2,9007199254740993\n3,4\n");
    let said = "note: d.csv: separator ,, decimal point, header, an integer beyond 2^53 rounded, \
                in line 3, column 2 (id)\n";
    assert_eq!(folder.run("ata d.csv").stderr, said);
    assert!(folder.succeed("--json ata d.csv").contains(r#""rounded_integers":1"#));
    let head = "%%MatrixMarket matrix array integer general\n3 1\n";
    folder.write("e.mtx", format!("{head}1\n9007199254740993\n9007199254740995\n"));
    let said = "note: e.mtx: 2 integers beyond 2^53 rounded, the first in line 4\n";
    assert_eq!(folder.run("ata e.mtx").stderr, said);
    folder.write_npy("f.npy", &[3, 1], &[1, (1_i64 << 53) + 1, -1]);
    let said = "note: f.npy: integers beyond 2^53 rounded, the first in row 1, column 0 (counted \
                from 0)\n";
    assert_eq!(folder.run("ata f.npy").stderr, said);
    // Numbers are those of the file, also where columns are left out.
    let said = folder.succeed("lstsq a.csv --by-column 2");
    assert!(said.lines().any(|line| line.starts_with("x ")), "{said}");
}

#[test]
fn stdin_and_files_without_an_ending_are_read_by_their_content() {
    let folder = Folder::new();
    folder.write("table", "1 2\n3 5\n4 4\n");
    folder.write("a.csv", "1,2\n3,5\n4,4\n");
    folder.succeed("ata table -o c.npy");
    assert_eq!(folder.read_npy::<f64>("c.npy", &[2; 2]), C);
    folder.succeed("ata a.csv --format table --separator comma -o c.npy --force");
    if cfg!(unix) {
        let mut command = folder.program();
        command.args(["ata", "-", "-o", "d.npy"]).stdin(Stdio::piped());
        let mut child = command.spawn().unwrap();
        child.stdin.take().unwrap().write_all(b"1;2\n3;5\n4;4\n").unwrap();
        assert!(child.wait().unwrap().success());
        assert_eq!(folder.read_npy::<f64>("d.npy", &[2; 2]), C);
    }
}

#[test]
fn every_command_that_reads_tables_has_the_same_options() {
    let folder = Folder::new();
    let options = |command: &str| -> BTreeSet<String> {
        let help = folder.succeed(&format!("{command} --help"));
        let (_, tables) = help.split_once("Options of input tables:").expect(command);
        let lines =
            tables.lines().skip(1).take_while(|line| line.is_empty() || line.starts_with(' '));
        let names = lines.filter_map(|line| line.trim_start().strip_prefix("--"));
        names.map(|name| name.split_whitespace().next().unwrap().to_owned()).collect()
    };
    let known = options("ata");
    for name in ["separator", "decimal", "thousands", "header", "no-header", "skip", "comment"] {
        assert!(known.contains(name), "{name}");
    }
    for name in ["missing", "missing-words", "index", "no-index", "encoding", "format"] {
        assert!(known.contains(name), "{name}");
    }
    for command in ["lstsq", "predict", "pca", "svd", "filter", "transfer", "unions shape"] {
        assert_eq!(options(command), known, "{command}");
    }
}

#[test]
fn words_of_missing_cells_may_begin_with_a_minus() {
    let folder = Folder::new();
    folder.write("a.csv", "x,y\n1,2\n-999,7\n3,5\n9,none\n-1e3,6\n4,4\n");
    for words in ["-999,none,-1e3", "-1e3,-999,none", "none,-999,-1e3"] {
        let line = format!("ata a.csv --missing drop --missing-words {words} -o c.npy --force");
        folder.succeed(&line);
        assert_eq!(folder.read_npy::<f64>("c.npy", &[2; 2]), C, "{words}");
    }
}

#[test]
fn options_of_text_are_refused_where_no_file_has_text() {
    let folder = Folder::new();
    folder.write_npy("a.npy", &[4, 2], &[1.0, 2.0, 3.0, 5.0, 4.0, 4.0, 6.0, 9.0]);
    folder.write("a.csv", "1,2\n3,5\n4,4\n6,9\n");
    folder.write("b.csv", "u\n1\n2\n3\n5\n");
    folder.write("w.csv", "1\n2\n1\n3\n");
    for (option, name, tables) in [
        ("--separator tab", "--separator", "text tables"),
        ("--decimal comma", "--decimal", "text tables"),
        ("--header", "--header or --no-header", "text tables"),
        ("--skip 2", "--skip", "text tables"),
        ("--missing-words -999", "--missing-words", "text tables"),
        ("--encoding latin1", "--encoding", "text tables"),
        ("--no-index", "--index or --no-index", "tables"),
    ] {
        for command in ["ata a.npy", "pca a.npy", "svd a.npy", "lstsq a.npy --by-column 1"] {
            let said = folder.fail(&format!("{command} {option}"));
            let why = format!("a.npy: {name} applies to {tables}, and this file is an array\n");
            assert!(said.ends_with(&why), "{command} {option}: {said}");
        }
    }
    // They apply to another file.
    for line in [
        "lstsq a.npy b.csv --header",
        "lstsq a.csv a.npy --no-header",
        "ata a.npy --times b.csv --header",
        "ata a.npy --weights w.csv --separator comma",
        "pca a.npy --weights w.csv --missing-words none",
    ] {
        folder.succeed(line);
    }
    for line in ["ata a.npy --weights w.csv --skip 1", "pca a.npy --weights a.npy --decimal ,"] {
        let said = folder.fail(line);
        assert!(said.contains("a.npy: --") && said.contains(" applies to text tables"), "{said}");
    }
}

#[test]
fn rows_of_an_array_are_dropped_only_where_nan_is_a_missing_value() {
    let folder = Folder::new();
    folder.write_npy("a.npy", &[4, 2], &[1.0, 2.0, f64::NAN, 3.0, 4.0, 5.0, 6.0, 9.0]);
    folder.write("a.mtx", "%%MatrixMarket matrix array real general\n2 1\n1\nnan\n");
    for file in ["a.npy", "a.mtx"] {
        let said = folder.fail(&format!("ata {file} --missing drop"));
        let why = "--missing drop: an array has no missing cells; its NaN are numbers";
        assert!(said.contains(&format!("{file}: {why}")), "{said}");
    }
    folder.succeed("ata a.npy -o c.npy");
    assert!(folder.read_npy::<f64>("c.npy", &[2; 2])[0].is_nan());
    folder.succeed("pca a.npy --missing drop");
}

#[test]
fn rows_that_belong_to_those_of_another_file_are_not_dropped() {
    let folder = Folder::new();
    folder.write("a.csv", "x\n1\nNA\n3\n4\n");
    folder.write("c.csv", "y\n1\n2\n3\n5\n");
    let said = folder.fail("ata a.csv --weights c.csv --missing drop");
    let why = "a.csv: --missing drop leaves out rows (1), so that the rows of c.csv";
    assert!(said.contains(why), "{said}");
    // Weights have the notation of A.
    folder.write("d.csv", "x;y\n1;2\n3;5\n4;4\n");
    folder.write("w.csv", "1,000\n2,000\n1,000\n");
    folder.succeed("ata d.csv --weights w.csv --decimal , --header -o c.npy");
    let weighted = [1.0 + 18.0 + 16.0, 2.0 + 30.0 + 16.0, 48.0, 4.0 + 50.0 + 16.0];
    assert_eq!(folder.read_npy::<f64>("c.npy", &[2; 2]), weighted);
}

#[test]
fn complex_matrices_are_multiplied_by_their_conjugates() {
    let folder = Folder::new();
    let head = "%%MatrixMarket matrix coordinate complex general\n2 1 2\n";
    folder.write("a.mtx", format!("{head}1 1 1 2\n2 1 0 -3\n"));
    let said = folder.succeed("ata a.mtx --explain");
    assert!(said.lines().any(|line| line.trim() == "14+0i"), "{said}");
    folder.succeed("ata a.mtx -o c.mtx --reproducible --require-finite");
    let c = fs::read_to_string(folder.path("c.mtx")).unwrap();
    assert_eq!(c, "%%MatrixMarket matrix array complex general\n1 1\n14.0 0.0\n");
    folder.write("d.mtx", format!("{head}1 1 1 0\n2 1 0 1\n"));
    folder.succeed("ata a.mtx --times d.mtx -o e.mtx --require-finite");
    let c = fs::read_to_string(folder.path("e.mtx")).unwrap();
    assert_eq!(c, "%%MatrixMarket matrix array complex general\n1 1\n-2.0 -2.0\n");
    folder.write("r.mtx", "%%MatrixMarket matrix array real general\n2 1\n1\n2\n");
    let said = folder.fail("ata a.mtx --times r.mtx -o x.mtx");
    assert!(said.contains("r.mtx: must be real or complex as a.mtx is"), "{said}");
    let said = folder.fail("ata a.mtx -o c.csv");
    assert!(said.contains("c.csv: complex numbers: the name must end in .npy or .mtx"), "{said}");
    let said = folder.fail("ata a.mtx --covariance");
    assert!(said.contains("a.mtx: --covariance: for real numbers only"), "{said}");
    for command in ["pca a.mtx", "svd a.mtx", "lstsq a.mtx a.mtx"] {
        let said = folder.fail(command);
        assert!(said.contains("a.mtx: complex numbers, where real ones"), "{command}: {said}");
    }
    folder.write("b.mtx", format!("{head}1 1 1 2\n2 1 nan 0\n"));
    let said = folder.fail("ata b.mtx --require-finite");
    assert!(said.contains("b.mtx: NaN+0i at row 1, column 0"), "{said}");
}

/// The rows of `inputs/tables/a.csv.xz` and of the arrays beside it.
const RANDOM: [f64; 18] = [
    0.001_230_153_357_482_574_2,
    0.298_745_537_508_469_9,
    -0.274_137_855_362_217_6,
    -0.890_591_838_757_274_2,
    -0.454_670_785_171_722_55,
    -0.991_646_554_996_462_4,
    0.060_143_602_597_438_485,
    1.340_215_245_554_533_5,
    -0.492_206_518_551_329_63,
    -0.620_474_899_819_940_4,
    0.489_842_050_185_198_2,
    0.356_887_008_160_060_75,
    0.105_414_248_997_898_56,
    -0.930_468_044_708_204_7,
    -0.029_251_822_463_273_49,
    0.695_303_194_458_287_8,
    -1.344_214_547_285_082,
    -0.457_615_761_040_218_17,
];

/// Every file of `inputs/tables` in the folder that `CATAMARAN_DATA` names.
#[test]
fn every_table_that_people_sent_is_read_right_or_says_what_decides() {
    let Some(inputs) = crate::inputs::data("inputs/tables") else { return };
    let small = vec![1.0, 2.0, 3.0, 5.0, 4.0, 4.0];
    let spectra = vec![0.10, 0.20, 0.30, 0.11, 0.25, 0.28, 0.09, 0.18, 0.35, 0.15, 0.22, 0.31];
    let populations = vec![10e3, 5.5e3, 12.5e3, 6.1e3, 9.75e3, 4.8e3, 11e3, 7e3];
    let complete = vec![1.0, 2.0, 4.0, 5.0, 6.0, 8.0];
    let german = vec![0.5, 1.25, 20.0, 1.0, 1.75, 21.5, 1.5, 2.5, 19.25, 2.0, 2.0, 22.0];
    let positive: Vec<f64> = RANDOM.map(|x| x.max(0.0)).into();
    let is_positive: Vec<f64> = RANDOM.map(|x| f64::from(x > 0.0)).into();
    let read = [
        ("thousands_quoted_head.csv --thousands ,", 2, populations),
        ("spectra.csv --columns 1..4", 3, spectra.clone()),
        ("spectra.csv", 3, spectra.clone()),
        ("spectra_num.csv --header", 3, spectra),
        ("r_writetable.txt", 3, vec![1.5, 2.0, 0.5, 3.5, 5.0, 0.25, 4.0, 4.0, 1.0, 6.0, 1.0, 2.0]),
        ("na_first.csv --missing drop", 2, small.clone()),
        ("infnames.csv", 2, small.clone()),
        ("decimal_comma.csv", 3, german),
        ("thousands_de.csv --columns 1..3", 2, vec![1299.99, 3.0, 899.5, 5.0, 2100.0, 1.0]),
        ("na_words.csv --missing drop", 2, complete.clone()),
        ("na_empty.csv --missing drop", 2, complete),
        ("utf16.csv", 2, small.clone()),
        ("pipe.csv", 2, small.clone()),
        ("trailing_comma.csv", 2, small.clone()),
        ("trailing_comment.txt", 2, small.clone()),
        ("cr_only.csv", 2, small.clone()),
        ("savetxt_header.csv", 2, small),
        ("tab_blank_mixed.txt", 3, vec![1.0, 2.0, 3.0, 4.0, 5.0, 6.0, 7.0, 8.0, 1.0]),
        ("quoted_head_semi.csv", 2, vec![1.0, 2.0, 2.0, 4.5, 3.0, 5.0]),
        ("quoted_head_comma.csv", 2, vec![170.0, 65.0, 180.0, 80.0, 165.0, 58.0, 175.0, 77.0]),
        ("names_comma.csv", 2, vec![1.0, 3.0, 2.0, 4.0, 4.0, 9.0]),
        ("fortran_d.txt", 2, vec![1.0, 0.25, 3.0, 10.0, 2.0, 0.0]),
        ("dexp.mtx", 2, vec![1.0, 0.0, 0.25, -4.0]),
        ("bool.npy", 3, is_positive),
        ("g.npy", 3, RANDOM.into()),
        ("one.npz", 3, RANDOM.into()),
        ("one.npz:a", 3, RANDOM.into()),
        ("sparse.npz", 3, positive),
        ("a.csv.xz", 3, RANDOM.into()),
        ("c.npy.xz", 3, RANDOM.into()),
    ];
    let refused = [
        ("thousands_quoted_head.csv", ":2: column 1", "--decimal or --thousands decides"),
        ("spectra_num.csv", ":1: ", "--header or --no-header decides"),
        ("na_first.csv", ":1: column 1: \"NA\"", "--missing drop"),
        ("na_words.csv", ":3: column 1 (x): \"NA\"", "--missing drop"),
        ("na_empty.csv", ":3: column 1 (x): nothing", "--missing drop"),
    ];
    let folder = Folder::new();
    let mut known: BTreeSet<String> = ["rnd.c".to_owned()].into();
    for (call, n, a) in &read {
        folder.succeed(&format!("ata {}/{call} -o c.npy --force", inputs.display()));
        let found = folder.read_npy::<f64>("c.npy", &[*n; 2]);
        for (x, y) in found.iter().zip(oracle(a, *n, None)) {
            assert!((x - y).abs() <= 1e-12 * y.abs().max(1.0), "{call}: {found:?}");
        }
        known.insert(call.split([' ', ':']).next().unwrap().to_owned());
    }
    for (name, place, option) in refused {
        for command in ["ata FILE", "lstsq FILE --by-column 1", "pca FILE", "svd FILE"] {
            let file = inputs.join(name).display().to_string();
            let said = folder.fail(&command.replace("FILE", &file));
            assert!(said.contains(&(file + place)) && said.contains(option), "{command}: {said}");
        }
    }
    let hermitian = inputs.join("herm.mtx");
    folder.succeed(&format!("ata {} -o h.mtx", hermitian.display()));
    let c = fs::read_to_string(folder.path("h.mtx")).unwrap();
    // 2^2 + |0.5 + 1.25i|^2, then 5 times 0.5 - 1.25i.
    assert!(c.ends_with("\n2 2\n5.8125 0.0\n2.5 -6.25\n2.5 6.25\n10.8125 0.0\n"), "{c}");
    known.insert("herm.mtx".into());
    let names = fs::read_dir(&inputs).unwrap().map(|entry| entry.unwrap().file_name());
    let unknown: Vec<_> = names.filter(|name| !known.contains(name.to_str().unwrap())).collect();
    assert!(unknown.is_empty(), "{unknown:?}");
}

#[cfg(feature = "columnar")]
#[test]
fn parquet_and_arrow_files_are_tables() {
    let folder = Folder::new();
    let files = Path::new(env!("CARGO_MANIFEST_DIR")).join("../tests/common/columnar");
    for kind in ["parquet", "arrow"] {
        let (kinds, missing) = (format!("kinds.{kind}"), format!("missing.{kind}"));
        for name in [&kinds, &missing] {
            fs::copy(files.join(name), folder.path(name)).unwrap();
        }
        folder.succeed(&format!("ata {kinds} --columns i8,bool -o c.npy --force"));
        // The sums of (i - 25)^2, of i - 25 and of 1, the last two over multiples of 3.
        let c = folder.read_npy::<f64>("c.npy", &[2; 2]);
        assert_eq!(c, [10425.0, -17.0, -17.0, 17.0]);
        // The content decides, where the name is that of a text.
        fs::copy(files.join(&kinds), folder.path("kinds.csv")).unwrap();
        folder.succeed("ata kinds.csv --columns i8,bool -o text.npy --force");
        assert_eq!(folder.read_npy::<f64>("text.npy", &[2; 2]), c);
        let said = folder.fail(&format!("ata {kinds} --columns f64,day"));
        assert!(said.contains("column day has dates, not numbers"), "{said}");
        let said = folder.fail(&format!("ata {missing} --columns x,y"));
        assert!(said.contains("column x") && said.contains("--missing"), "{said}");
        let with = "--columns f64,word --by-column f64 --factor word --intercept";
        folder.succeed(&format!("lstsq {kinds} {with}"));
        let run =
            folder.run(&format!("ata {missing} --columns x,y --missing drop -o d.npy --force"));
        let said = format!("note: {missing}: 7 rows with missing cells left out");
        assert!(run.stderr.contains(&said), "{}", run.stderr);
    }
}
