//! `catamaran ata`, from outside.

use std::fmt::Write as _;
use std::fs::{self, File};
use std::io::Write as _;
use std::process::Command;

use crate::common::{Folder, Run, csv, oracle, table, with_input};

const M: usize = 37;
const N: usize = 11;

#[test]
fn every_format_gives_the_same_product() {
    let (folder, expected) = with_input(M, N);
    let a = table(M, N);
    folder.write("a.csv", csv(&a, N));
    folder.write("a.tsv", csv(&a, N).replace(',', "\t"));
    let mut packed = flate2::write::GzEncoder::new(
        File::create(folder.path("a.csv.gz")).unwrap(),
        flate2::Compression::fast(),
    );
    packed.write_all(csv(&a, N).as_bytes()).unwrap();
    packed.finish().unwrap();
    let mut array = format!("%%MatrixMarket matrix array integer general\n{M} {N}\n");
    let mut coordinate =
        format!("%%MatrixMarket matrix coordinate integer general\n{M} {N} {}\n", M * N);
    for j in 0..N {
        for i in 0..M {
            writeln!(array, "{}", a[i * N + j]).unwrap();
            writeln!(coordinate, "{} {} {}", i + 1, j + 1, a[i * N + j]).unwrap();
        }
    }
    folder.write("a.mtx", array);
    folder.write("sparse.mtx", coordinate);
    for name in ["a.npy", "a.csv", "a.tsv", "a.csv.gz", "a.mtx", "sparse.mtx"] {
        folder.succeed(&format!("ata {name} -o c.npy --force --verify"));
        assert_eq!(folder.read_npy::<f64>("c.npy", &[N; 2]), expected, "{name}");
    }
}

#[test]
fn report_tells_shape_time_rate_check_and_files() {
    let (folder, _) = with_input(M, N);
    let report = folder.succeed("ata a.npy -o c.npy --verify");
    for part in
        ["a.npy: 37 x 11, f64", "11 x 11, f64, both", "GFLOP/s", "check       passed", "c.npy"]
    {
        assert!(report.contains(part), "{part:?} in {report}");
    }
}

#[test]
fn products_with_another_matrix_are_sums_over_blocks_of_rows() {
    let (folder, _) = with_input(M, N);
    let (a, b) = (table(M, N), table(M, 3));
    folder.write("a.csv", csv(&a, N));
    folder.write_npy("b.npy", &[M as u64, 3], &b);
    let entry = |p: usize| (0..M).map(|i| a[i * N + p / 3] * b[i * 3 + p % 3]).sum::<f64>();
    let expected: Vec<f64> = (0..N * 3).map(entry).collect();
    for line in ["a.npy", "a.csv", "a.npy --block-rows 5", "a.npy --scheme exact --require-finite"]
    {
        folder.succeed(&format!("ata {line} --times b.npy -o c.npy --force"));
        assert_eq!(folder.read_npy::<f64>("c.npy", &[N, 3]), expected, "{line}");
    }
    folder.succeed("ata a.npy --columns 1..3 --times b.npy --f32 -o c.npy --force");
    let few: Vec<f32> = expected[3..9].iter().map(|&x| x as f32).collect();
    assert_eq!(folder.read_npy::<f32>("c.npy", &[2, 3]), few);
    folder.write_npy("short.npy", &[2, 3], &table(2, 3));
    for (line, says) in [
        ("--times short.npy", "short.npy: 2 rows, where a.npy has 37"),
        ("--times b.npy --center", "--times can't be combined with --center"),
        ("--times b.npy --uplo lower", "--times can't be combined with --uplo"),
    ] {
        let said = folder.fail(&format!("ata a.npy -o x.npy {line}"));
        assert!(said.contains(says), "{line}: {said}");
    }
    // Stdin can't be both matrices.
    for line in ["ata - --times - -o x.npy", "lstsq - - -o x.npz"] {
        let run = folder.run(line);
        assert_eq!(run.code, Some(2), "{line}");
        assert!(run.stderr.contains("stdin (`-`) can't be both"), "{line}: {}", run.stderr);
    }
    // A small C is printed, a larger one needs a file.
    let printed = folder.succeed("ata a.npy --columns 1..3 --times b.npy");
    let row = |line: &str| line.split_whitespace().map(|word| word.parse().ok()).collect();
    let found: Vec<f64> = printed.lines().filter_map(row).flat_map(|row: Vec<f64>| row).collect();
    let near = |(x, y): (&f64, &f64)| (x - y).abs() <= 1e-5 * y.abs();
    assert!(found.len() == 6 && found.iter().zip(&expected[3..9]).all(near), "{printed}");
    let said = folder.fail("ata a.npy --times b.npy");
    assert!(said.contains("C is 11 x 3: --times needs -o"), "{said}");
}

#[test]
fn product_is_written_in_every_format() {
    let (folder, expected) = with_input(M, N);
    for name in ["c.csv", "c.mtx", "c.npy.gz"] {
        folder.succeed(&format!("ata a.npy -o {name}"));
        // Read back by the program itself, as the A of another product.
        folder.succeed(&format!("ata {name} -o cc.npy --force"));
        assert_eq!(folder.read_npy::<f64>("cc.npy", &[N; 2]), oracle(&expected, N, None), "{name}");
    }
    folder.succeed("ata a.npy -o c.txt");
    let text = fs::read_to_string(folder.path("c.txt")).unwrap();
    let values: Vec<f64> = text.split_whitespace().map(|v| v.parse().unwrap()).collect();
    assert_eq!(values, expected);
}

#[test]
fn sparse_input_is_never_made_dense_when_sparse_is_faster() {
    const ROWS: usize = 400;
    const COLUMNS: usize = 60;
    let folder = Folder::new();
    let mut a = vec![0.0; ROWS * COLUMNS];
    let mut text =
        format!("%%MatrixMarket matrix coordinate real general\n{ROWS} {COLUMNS} {}\n", 3 * ROWS);
    for i in 0..ROWS {
        for k in 0..3 {
            let (j, value) = ((i * 31 + k * 17) % COLUMNS, (i % 5) as f64 + k as f64 - 2.0);
            a[i * COLUMNS + j] += value;
            writeln!(text, "{} {} {value}", i + 1, j + 1).unwrap();
        }
    }
    folder.write("a.mtx", text);
    let weights: Vec<f64> = (0..ROWS).map(|i| (i % 3) as f64).collect();
    folder.write_npy("w.npy", &[ROWS as u64], &weights);
    let report = folder.succeed("ata a.mtx --explain --verify -o c.npy");
    assert!(report.contains("outer product of each row, 2400 multiplications"), "{report}");
    assert_eq!(folder.read_npy::<f64>("c.npy", &[COLUMNS; 2]), oracle(&a, COLUMNS, None));
    folder.succeed("ata a.mtx --weights w.npy --verify -o c.npy --force");
    assert_eq!(folder.read_npy::<f64>("c.npy", &[COLUMNS; 2]), oracle(&a, COLUMNS, Some(&weights)));
    // A scheme asked for by name runs on dense blocks of rows.
    let report = folder.succeed("ata a.mtx --explain --scheme winograd --verify -o c.npy --force");
    assert!(report.contains("block by block"), "{report}");
    assert_eq!(folder.read_npy::<f64>("c.npy", &[COLUMNS; 2]), oracle(&a, COLUMNS, None));
}

#[test]
fn one_triangle_leaves_zeros_in_the_other() {
    let (folder, expected) = with_input(M, N);
    for (uplo, lower) in [("lower", true), ("upper", false)] {
        folder
            .succeed(&format!("ata a.npy -o c.npy --force --verify --uplo {uplo} --picture c.png"));
        let c = folder.read_npy::<f64>("c.npy", &[N; 2]);
        for i in 0..N {
            for j in 0..N {
                let given = if lower { i >= j } else { i <= j };
                assert_eq!(c[i * N + j], if given { expected[i * N + j] } else { 0.0 });
            }
        }
    }
}

#[test]
fn weights_as_row_or_column_multiply_the_rows() {
    let (folder, _) = with_input(M, N);
    let weights: Vec<f64> = (0..M).map(|i| i as f64 - 5.0).collect();
    folder.write_npy("column.npy", &[M as u64], &weights);
    folder.write("row.csv", csv(&weights, M));
    for name in ["column.npy", "row.csv"] {
        folder.succeed(&format!("ata a.npy --weights {name} -o c.npy --force --verify"));
        assert_eq!(
            folder.read_npy::<f64>("c.npy", &[N; 2]),
            oracle(&table(M, N), N, Some(&weights))
        );
    }
}

#[test]
fn covariance_is_the_centred_product_over_m_minus_one() {
    let (folder, _) = with_input(M, N);
    let mut a = table(M, N);
    for j in 0..N {
        let mean = (0..M).map(|i| a[i * N + j]).sum::<f64>() / M as f64;
        (0..M).for_each(|i| a[i * N + j] -= mean);
    }
    let scatter = oracle(&a, N, None);
    folder.succeed("ata a.npy --center --verify -o scatter.npy");
    folder.succeed("ata a.npy --covariance --verify -o covariance.npy");
    let close = |x: f64, y: f64| (x - y).abs() <= 1e-12 * scatter[0].abs();
    let (found, covariance) = (
        folder.read_npy::<f64>("scatter.npy", &[N; 2]),
        folder.read_npy::<f64>("covariance.npy", &[N; 2]),
    );
    assert!(found.iter().zip(&scatter).all(|(&x, &y)| close(x, y)));
    let divided = scatter.iter().map(|s| s / (M - 1) as f64);
    assert!(covariance.iter().zip(divided).all(|(&x, y)| close(x, y)));
}

#[test]
fn precision_follows_the_input_unless_asked_for() {
    let (folder, expected) = with_input(M, N);
    let single: Vec<f32> = table(M, N).iter().map(|&v| v as f32).collect();
    let expected32: Vec<f32> = expected.iter().map(|&v| v as f32).collect();
    folder.write_npy("s.npy", &[M as u64, N as u64], &single);
    for (arguments, is_single) in
        [("s.npy", true), ("s.npy --f64", false), ("a.npy", false), ("a.npy --f32", true)]
    {
        folder.succeed(&format!("ata {arguments} --verify -o c.npy --force"));
        if is_single {
            assert_eq!(folder.read_npy::<f32>("c.npy", &[N; 2]), expected32, "{arguments}");
        } else {
            assert_eq!(folder.read_npy::<f64>("c.npy", &[N; 2]), expected, "{arguments}");
        }
    }
}

#[test]
fn every_scheme_and_accuracy_gives_the_product() {
    let folder = Folder::new();
    let (m, n) = (200, 90);
    folder.write_npy("a.npy", &[m as u64, n as u64], &table(m, n));
    let expected = oracle(&table(m, n), n, None);
    for scheme in ["auto", "classical", "ata2", "winograd", "rxtx", "kgp", "kgp3", "exact"] {
        let exact = ["auto", "exact"].contains(&scheme);
        let accuracies = ["classical", "default", "fast", "2.5", "max"];
        for accuracy in accuracies.into_iter().filter(|&accuracy| exact || accuracy != "max") {
            let options = format!("--scheme {scheme} --accuracy {accuracy} --threads 2 --verify");
            folder.succeed(&format!("ata a.npy -o c.npy --force {options}"));
            assert_eq!(folder.read_npy::<f64>("c.npy", &[n; 2]), expected, "{options}");
        }
    }
}

/// Entries of 40 bits, whose sums the classical algorithm rounds on the way, and the true sums.
fn wide_table(m: usize, n: usize) -> (Vec<f64>, Vec<f64>) {
    let entry = |k: usize| (k as i64 * 7919 + 13) * 1_000_003 % (1 << 40) - (1 << 39);
    let a: Vec<i64> = (0..m * n).map(entry).collect();
    let mut c = vec![0_i128; n * n];
    for row in a.chunks(n) {
        for i in 0..n {
            for j in 0..n {
                c[i * n + j] += i128::from(row[i]) * i128::from(row[j]);
            }
        }
    }
    (a.iter().map(|&x| x as f64).collect(), c.iter().map(|&x| x as f64).collect())
}

#[test]
fn reproducible_is_the_true_product_for_any_threads_and_layout() {
    let (m, n) = (301, 43);
    let (a, expected) = wide_table(m, n);
    let folder = Folder::new();
    folder.write_npy("a.npy", &[m as u64, n as u64], &a);
    folder.write_fortran_npy("f.npy", &[m as u64, n as u64], &a);
    folder.write("a.csv", csv(&a, n));
    let mut outputs = Vec::new();
    for input in ["a.npy", "f.npy", "a.csv"] {
        for options in [
            "--threads 1 --reproducible",
            "--threads 2 --reproducible",
            "--scheme exact --reproducible --accuracy fast",
            "--scheme exact",
            "--accuracy max",
        ] {
            folder.succeed(&format!("ata {input} -o c.npy --force --verify {options}"));
            assert_eq!(folder.read_npy::<f64>("c.npy", &[n; 2]), expected, "{input} {options}");
            outputs.push(fs::read(folder.path("c.npy")).unwrap());
        }
    }
    assert!(outputs.iter().all(|output| *output == outputs[0]));
    folder.succeed("ata a.npy -o c.npy --force --scheme classical");
    assert_ne!(
        folder.read_npy::<f64>("c.npy", &[n; 2]),
        expected,
        "or the sums above prove nothing"
    );
}

#[test]
fn reproducible_product_of_a_sparse_file_takes_the_exact_path() {
    let (m, n) = (60, 20);
    let (values, _) = wide_table(m, 1);
    let mut text = format!("%%MatrixMarket matrix coordinate real general\n{m} {n} {}\n", 2 * m);
    let mut a = vec![0.0; m * n];
    for (i, value) in values.iter().enumerate() {
        for j in [i % 3, 3 + i % 2] {
            a[i * n + j] = *value;
            writeln!(text, "{} {} {value}", i + 1, j + 1).unwrap();
        }
    }
    let folder = Folder::new();
    folder.write("a.mtx", text);
    folder.write_npy("a.npy", &[m as u64, n as u64], &a);
    folder.succeed("ata a.npy -o dense.npy --reproducible");
    let report = folder.succeed("ata a.mtx -o sparse.npy --explain");
    assert!(report.contains("outer product of each row"), "{report}");
    for option in ["--reproducible", "--accuracy max"] {
        let report = folder.succeed(&format!("ata a.mtx -o c.npy --force --explain {option}"));
        assert!(report.contains("exact "), "{report}");
        let read = |name| fs::read(folder.path(name)).unwrap();
        assert_eq!(read("c.npy"), read("dense.npy"), "{option}");
        assert_ne!(read("c.npy"), read("sparse.npy"), "or it proves nothing");
    }
}

#[test]
fn options_of_the_exact_path_refuse_other_schemes() {
    let (folder, _) = with_input(M, N);
    for option in ["--reproducible", "--accuracy max"] {
        for scheme in ["float", "classical", "ata2", "winograd", "rxtx", "kgp", "kgp3"] {
            let message = folder.fail(&format!("ata a.npy -o c.npy {option} --scheme {scheme}"));
            let both = message.contains(option) && message.contains(&format!("--scheme {scheme}"));
            assert!(both, "{message}");
        }
    }
}

#[test]
fn explain_of_the_exact_path_names_moduli_and_threads_but_no_back_end() {
    // Longer than a product by integers may take, on every instruction set.
    let (folder, _) = with_input(8000, 300);
    for (options, moduli) in [
        ("--scheme exact --accuracy fast", 13),
        ("--reproducible", 14),
        ("--accuracy max", 15),
        ("--reproducible --f32", 7),
    ] {
        let report = folder.succeed(&format!("ata a.npy --threads 2 --explain {options}"));
        assert!(report.contains(&format!("exact      modulo {moduli} numbers")), "{report}");
        assert!(report.contains("threads    2"), "{report}");
        assert!(!report.contains("back end"), "{report}");
    }
}

#[test]
fn columns_are_half_open() {
    let (folder, expected) = with_input(M, N);
    folder.succeed("ata a.npy --columns 2..5 -o c.npy");
    let c = folder.read_npy::<f64>("c.npy", &[3; 2]);
    for i in 0..3 {
        assert_eq!(c[3 * i..][..3], expected[(i + 2) * N + 2..][..3]);
    }
    let message = folder.fail("ata a.npy --columns 2..12 -o d.npy");
    assert!(message.contains("a.npy: columns: 2..12 is not inside the 11 columns"), "{message}");
}

#[test]
fn the_plan_says_how_many_threads_a_product_takes() {
    let (folder, _) = with_input(M, N);
    let small = folder.succeed("ata a.npy --threads 2 -o c.npy");
    assert!(small.contains("direct, by") && small.contains(", 1 thread; --explain"), "{small}");
    let explained = folder.succeed("ata a.npy --threads 2 --explain -o d.npy");
    assert!(explained.contains(", 1 thread\n"), "{explained}");
    let (folder, _) = with_input(2000, 300);
    let large = folder.succeed("ata a.npy --threads 2 -o c.npy");
    assert!(large.contains(", 2 threads; --explain"), "{large}");
}

#[test]
fn explain_prints_the_plan_before_computing() {
    let (folder, _) = with_input(M, N);
    let report = folder.succeed("ata a.npy --explain");
    let plan = report.find("plan        C = A^T A, A 37 x 11, f64").expect("a plan");
    assert!(plan < report.find("time ").expect("a time"));
    assert!(report.contains("estimate"), "{report}");
}

#[test]
fn picture_is_a_square_png() {
    let (folder, _) = with_input(M, N);
    folder.succeed("ata a.npy --picture c.png");
    let decoder =
        png::Decoder::new(std::io::BufReader::new(File::open(folder.path("c.png")).unwrap()));
    let mut reader = decoder.read_info().unwrap();
    let mut pixels = vec![0; reader.output_buffer_size().unwrap()];
    let info = reader.next_frame(&mut pixels).unwrap();
    assert_eq!((info.width, info.height), (506, 506));
    // The diagonal is 1: the red end of the scale.
    assert_eq!(pixels[..3], pixels[pixels.len() - 3..]);
    assert!(pixels[0] > 2 * pixels[2], "{:?}", &pixels[..3]);
}

#[test]
fn files_are_replaced_only_by_force() {
    let (folder, expected) = with_input(M, N);
    for option in ["-o", "--picture"] {
        folder.write("there.npy", "precious");
        let message = folder.fail(&format!("ata a.npy {option} there.npy"));
        assert!(message.contains("there.npy: exists already (--force replaces it)"), "{message}");
        assert_eq!(fs::read_to_string(folder.path("there.npy")).unwrap(), "precious");
    }
    folder.succeed("ata a.npy -o there.npy --force");
    assert_eq!(folder.read_npy::<f64>("there.npy", &[N; 2]), expected);
}

#[test]
fn bad_input_is_one_line_that_names_file_and_line() {
    let (folder, _) = with_input(M, N);
    let whole = fs::read(folder.path("a.npy")).unwrap();
    folder.write("short.npy", &whole[..whole.len() - 1]);
    folder.write("long.npy", [&whole[..], b"x"].concat());
    folder.write("header.npy", b"\x93NUMPY garbage");
    folder.write("header.mtx", "%%MatrixMarket tensor\n");
    folder.write("ragged.csv", "1,2\n3,4\n5\n");
    folder.write("text.csv", "1,2\n3,x\n");
    for (name, expected) in [
        ("none.npy", "none.npy: no such file"),
        ("short.npy", "short.npy: truncated"),
        ("long.npy", "long.npy: data after"),
        ("header.npy", "header.npy: broken npy header"),
        ("header.mtx", "header.mtx:1: broken MatrixMarket header"),
        ("ragged.csv", "ragged.csv:3: 1 field in"),
        ("text.csv", "text.csv:2: column 2: \"x\" is not a number"),
        ("a.xls", "a.xls: no such file"),
    ] {
        let message = folder.fail(&format!("ata {name} -o c.npy"));
        assert!(message.contains(expected), "{expected:?} in {message}");
    }
    let message = folder.fail("ata a.npy -o c.xls");
    assert!(message.contains("c.xls: unknown kind of file"), "{message}");
    let message = folder.fail("ata a.npy -o none/c.npy");
    assert!(message.contains("none/c.npy: can't be written"), "{message}");
    let message = folder.fail("ata a.npy --backend ./none.so -o c.npy");
    assert!(message.contains("none.so"), "{message}");
}

#[test]
fn require_finite_names_the_entry_that_is_not_finite() {
    let folder = Folder::new();
    folder.write("a.csv", "1,2,3\n4,5,NaN\n7,8,9\n");
    let message = folder.fail("ata a.csv -o c.npy --require-finite --missing nan");
    assert!(message.contains("a.csv: NaN at row 1, column 2"), "{message}");
    folder.write("b.csv", "1,-inf\n");
    let message = folder.fail("ata b.csv -o c.npy --require-finite");
    assert!(message.contains("b.csv: -inf at row 0, column 1"), "{message}");
    folder.succeed("ata a.csv -o c.npy --missing nan");
    assert!(folder.read_npy::<f64>("c.npy", &[3; 2])[8].is_nan());
}

#[test]
fn entries_of_c_that_are_not_finite_are_counted_in_a_note() {
    let folder = Folder::new();
    folder.write("a.csv", "1e200,1,0\n2,3,4\n");
    folder.write("nan.csv", "1,2,3\n4,5,NaN\n");
    let header = "%%MatrixMarket matrix coordinate real general";
    let few = "\n1 1 1e200\n2 2 1\n3 1 5\n";
    folder.write("a.mtx", format!("{header}\n3 3 3{few}"));
    folder.write("sparse.mtx", format!("{header}\n90 90 3{few}"));
    let finite = "all entries are finite, but";
    let range = "of C are not finite: sums are out of the range of";
    for (arguments, note) in [
        ("a.csv", format!("a.csv: {finite} 1 of 9 entries {range} f64")),
        ("a.csv --uplo lower", format!("a.csv: {finite} 1 of 6 entries {range} f64")),
        ("a.csv --require-finite -o c.npy", format!("a.csv: {finite} 1 of 9 entries {range} f64")),
        ("a.csv --f32 --uplo upper", format!("a.csv: {finite} 3 of 6 entries {range} f32")),
        ("a.csv --reproducible", format!("a.csv: {finite} 1 of 9 entries {range} f64")),
        ("a.mtx", format!("a.mtx: {finite} 1 of 9 entries {range} f64")),
        ("sparse.mtx", format!("sparse.mtx: {finite} 1 of 8100 entries {range} f64")),
        (
            "nan.csv --missing nan",
            "nan.csv: NaN at row 1, column 2 (counted from 0); 5 of 9 entries of C are not finite"
                .into(),
        ),
    ] {
        let run = folder.run(&format!("ata {arguments}"));
        assert_eq!((run.code, run.stderr), (Some(0), format!("note: {note}\n")), "{arguments}");
    }
    folder.succeed("ata a.csv --accumulator sums");
    let run = folder.run("ata-merge sums -o merged.npy");
    assert_eq!(run.stderr, "note: 1 of 9 entries of C are not finite\n");
    folder.write("b.csv", "1e150,1\n");
    assert_eq!(folder.run("ata b.csv").stderr, "");
}

#[test]
fn squares_of_a_column_that_underflow_are_noted() {
    let folder = Folder::new();
    folder.write("a.csv", "1,1e-170,0\n2,2e-170,0\n");
    folder.write("single.csv", "1,1e-30\n2,1e-30\n");
    folder.write("weights.csv", "0\n1\n");
    folder.write("first.csv", "1,1e-170\n2,0\n");
    let header = "%%MatrixMarket matrix coordinate real general";
    folder.write("sparse.mtx", format!("{header}\n90 90 2\n1 1 1\n2 7 1e-200\n"));
    folder.write(
        "complex.mtx",
        "%%MatrixMarket matrix array complex general\n2 2\n1 0\n0 1\n0 1e-170\n0 0\n",
    );
    let note = |file: &str, column: usize, what: &str, scalar: &str| {
        let double = if scalar == "f32" { ", or use --f64" } else { "" };
        format!(
            "note: {file}: column {column} (counted from 0) is not {what}, but its entry on the \
             diagonal of C is too small for {scalar}: multiply the column by a power of \
             ten{double}\n"
        )
    };
    for (arguments, note) in [
        ("a.csv", note("a.csv", 1, "zero", "f64")),
        ("a.csv --uplo upper", note("a.csv", 1, "zero", "f64")),
        ("a.csv --reproducible", note("a.csv", 1, "zero", "f64")),
        ("a.csv --center", note("a.csv", 1, "constant", "f64")),
        ("single.csv --f32", note("single.csv", 1, "zero", "f32")),
        ("single.csv --f32 --center", String::new()),
        ("single.csv", String::new()),
        ("first.csv", note("first.csv", 1, "zero", "f64")),
        ("first.csv --weights weights.csv", String::new()),
        ("sparse.mtx", note("sparse.mtx", 6, "zero", "f64")),
        ("complex.mtx", note("complex.mtx", 1, "zero", "f64")),
    ] {
        let run = folder.run(&format!("ata {arguments}"));
        assert_eq!((run.code, run.stderr), (Some(0), note), "{arguments}");
    }
}

#[test]
fn columns_that_are_constant_in_single_precision_are_all_noted() {
    let folder = Folder::new();
    let rows = ["1000000000,1,1000000000000", "1000000001,2,1000000000003", "1000000002,3,1e12"];
    folder.write("a.csv", format!("a,b,c\n{}\n", rows.join("\n")));
    let run = folder.run("ata a.csv --f32 --covariance");
    let note = "note: a.csv: rounded to f32, columns 0 (a), 2 (c) are constant, which makes the \
                diagonal of C 0 there: leave --f32 out\n";
    assert_eq!((run.code, run.stderr.as_str()), (Some(0), note));
    assert_eq!(folder.run("ata a.csv --covariance").stderr, "");
}

#[test]
fn entries_of_other_products_that_are_not_finite_are_noted() {
    let folder = Folder::new();
    folder.write("a.csv", "1e200,1\n2,3\n");
    folder.write("nan.csv", "1,2\nNaN,4\n");
    let header = "%%MatrixMarket matrix array complex general\n2 1\n";
    folder.write("z.mtx", format!("{header}1e200 0\n0 1\n"));
    folder.write("inf.mtx", format!("{header}1 0\n0 inf\n"));
    let counted =
        |count: usize, all: usize| format!("{count} of {all} entries of C are not finite");
    let range = "sums are out of the range of f64";
    for (arguments, note) in [
        (
            "a.csv --times a.csv",
            format!("a.csv, a.csv: all entries are finite, but {}: {range}", counted(1, 4)),
        ),
        (
            "a.csv --times nan.csv --missing nan",
            format!("nan.csv: NaN at row 1, column 0 (counted from 0); {}", counted(2, 4)),
        ),
        ("z.mtx", format!("z.mtx: all entries are finite, but {}: {range}", counted(1, 1))),
        (
            "z.mtx --times z.mtx",
            format!("z.mtx, z.mtx: all entries are finite, but {}: {range}", counted(1, 1)),
        ),
        (
            "inf.mtx",
            format!("inf.mtx: 0+infi at row 1, column 0 (counted from 0); {}", counted(1, 1)),
        ),
    ] {
        let run = folder.run(&format!("ata {arguments}"));
        assert_eq!((run.code, run.stderr), (Some(0), format!("note: {note}\n")), "{arguments}");
    }
}

#[test]
fn failed_check_writes_nothing() {
    let folder = Folder::new();
    let unknown = "the check can't tell, and nothing is written";
    for (rows, options, why) in [
        ("1,2\n3,nan\n", "--missing nan", "a.csv: NaN at row 1, column 1 (counted from 0)"),
        ("1,2\n3,inf\n", "", "a.csv: inf at row 1, column 1 (counted from 0)"),
        ("1,2\n3,-inf\n", "--center", "a.csv: -inf at row 1, column 1 (counted from 0)"),
        (
            "1,2\n3,nan\n",
            "--covariance --missing nan",
            "a.csv: NaN at row 1, column 1 (counted from 0)",
        ),
        ("1,2\n3,1e200\n", "", "in f64 the squares of a column add up to infinity"),
    ] {
        folder.write("a.csv", rows);
        let options = format!("-o c.npy --picture c.png --verify {options}");
        let message = folder.fail(&format!("ata a.csv {options}"));
        assert!(message.contains(&format!("{unknown}: {why}")), "{options}: {message}");
    }
}

#[test]
fn weights_that_do_not_fit_are_refused() {
    let (folder, _) = with_input(M, N);
    folder.write("w.csv", "1\n2\n3\n");
    let message = folder.fail("ata a.npy --weights w.csv -o c.npy");
    assert!(
        message.contains("w.csv: 3 x 1 where the 37 rows of a.npy need 37 weights"),
        "{message}"
    );
    folder.write("nan.csv", "1\nnan\n".to_owned() + &"2\n".repeat(M - 2));
    folder.write("word.csv", "1\nnone\n".to_owned() + &"2\n".repeat(M - 2));
    // Advice for A would not help.
    for (weights, what) in [
        ("nan.csv", "nan.csv:2: column 1: \"nan\" where a number should be"),
        ("word.csv", "word.csv:2: column 1: \"none\" is not a number"),
    ] {
        for command in ["ata a.npy", "pca a.npy --missing drop", "lstsq a.npy --by-column 0"] {
            let message = folder.fail(&format!("{command} --weights {weights}"));
            let expected = format!("{what}: each row needs a weight\n");
            assert!(message.ends_with(&expected), "{command}: {message}");
        }
    }
}

#[test]
fn weights_too_small_for_exact_sums_are_refused_by_their_file() {
    let folder = Folder::new();
    folder.write("a.csv", "y,a,b\n1,2,3\n2,5,1\n3,4,9\n4,4,2\n");
    folder.write("w.csv", "1e-300\n2e-300\n1e-300\n1e-300\n");
    for command in ["pca a.csv", "lstsq a.csv --by-column y", "ata a.csv --center --reproducible"] {
        let message = folder.fail(&format!("{command} --weights w.csv"));
        let expected = "w.csv: the weights are too small: the largest is 2e-300";
        assert!(message.contains(expected), "{command}: {message}");
    }
    folder.succeed("ata a.csv --center --weights w.csv");
}

#[test]
fn what_is_not_finite_is_named_by_its_column_in_the_file() {
    let folder = Folder::new();
    folder.write("a.csv", "y,q,a,b\n1,1,2,3\n2,2,5,1\n3,5,inf,9\n4,4,4,2\n");
    folder.write("text.csv", "name,x,a\nu,1,2\nv,3,inf\nw,5,1\n");
    let inf = f64::INFINITY;
    folder.write_npy("a.npy", &[3, 3], &[1.0, 2.0, 3.0, 4.0, 5.0, inf, 7.0, 8.0, 9.0]);
    let complex = "%%MatrixMarket matrix array complex general\n1 2\n1 0\ninf 0\n";
    folder.write("a.mtx", complex);
    let named = "a.csv: inf at row 2, column 2 (a), counted from 0";
    let numbered = "a.npy: inf at row 1, column 2 (counted from 0)";
    for (arguments, expected) in [
        ("pca a.csv --columns a,b", named),
        ("svd a.csv --columns a,b", named),
        ("lstsq a.csv --columns y,a,b --by-column y", named),
        ("ata a.csv --columns b,a --require-finite", named),
        ("ata text.csv --require-finite", "inf at row 1, column 2 (a), counted from 0"),
        ("pca a.npy --columns 2,0", numbered),
        ("ata a.npy --columns 1..3 --require-finite", numbered),
        ("ata a.mtx --columns 1 --require-finite", "inf+0i at row 0, column 1 (counted from 0)"),
    ] {
        let message = folder.fail(arguments);
        assert!(message.contains(expected), "{arguments}: {message}");
    }
    let run = folder.run("ata a.csv --columns b,a");
    assert!(run.stderr.starts_with(&format!("note: {named}; ")), "{}", run.stderr);
}

#[test]
fn a_product_too_large_for_memory_is_refused() {
    let folder = Folder::new();
    folder
        .write("wide.mtx", "%%MatrixMarket matrix coordinate real general\n1 99999999 1\n1 1 1\n");
    let message = folder.fail("ata wide.mtx -o c.npy");
    assert!(message.contains("C of 99999999 x 99999999 entries: out of memory"), "{message}");
}

#[test]
fn a_header_gets_the_memory_that_its_file_may_take() {
    let folder = Folder::new();
    let header = "%%MatrixMarket matrix coordinate real general\n";
    folder.write("tall.mtx", format!("{header}150000000 3 1\n1 1 2\n"));
    let message = folder.fail("ata tall.mtx -o c.npy");
    assert!(message.contains("1.12 GiB") && message.contains("--input-limit"), "{message}");
    folder.write("tall.mtx", format!("{header}1000000 3 1\n1 1 2\n"));
    let message = folder.fail("ata tall.mtx -o c.npy --input-limit 0.001");
    assert!(message.contains("this file may take 1.02 MiB"), "{message}");
    assert!(message.ends_with(": a larger --input-limit allows it\n"), "{message}");
    assert!(!message.contains("max_memory"), "{message}");
    folder.succeed("ata tall.mtx -o c.npy --input-limit 0.01");
    assert_eq!(folder.read_npy::<f64>("c.npy", &[3; 2])[0], 4.0);
}

#[test]
fn rows_without_columns_are_refused_or_take_no_time() {
    let folder = Folder::new();
    for shape in [[1 << 63, 0], [0, 1 << 63]] {
        folder.write_npy::<f64>("a.npy", &shape, &[]);
        for command in ["ata a.npy -o c.npy", "pca a.npy", "svd a.npy"] {
            let message = folder.fail(command);
            let [m, n] = shape;
            let why = format!("a.npy: shape too large: ({m}, {n})");
            assert!(message.contains(&why), "{message}");
        }
    }
    folder.write_npy::<f64>("a.npy", &[1 << 40, 0], &[]);
    folder.succeed("ata a.npy --verify --require-finite -o c.npy");
    assert!(folder.read_npy::<f64>("c.npy", &[0, 0]).is_empty());
    for command in ["pca a.npy", "svd a.npy"] {
        assert!(folder.fail(command).contains("a.npy: no columns"));
    }
}

#[test]
fn unknown_options_say_what_is_known() {
    let (folder, _) = with_input(M, N);
    let run = folder.run("ata a.npy --scheme magic");
    assert_eq!(run.code, Some(2));
    assert!(run.stderr.contains("magic") && run.stderr.contains("rxtx"), "{}", run.stderr);
    let run = folder.run("ata a.npy --accuracy 0.5");
    assert_eq!(run.code, Some(2));
    assert!(
        run.stderr.contains("at least 1") && run.stderr.contains("max, classical"),
        "{}",
        run.stderr
    );
}

/// A limit on the size of files stands in for a full disk: both fail in the middle of a write.
#[cfg(unix)]
#[test]
fn full_disk_is_one_line_and_leaves_nothing() {
    let folder = Folder::new();
    let n = 100;
    folder.write_npy("a.npy", &[1, n as u64], &table(1, n));
    for option in ["-o c.npy", "-o c.csv", "--picture c.png"] {
        let program = env!("CARGO_BIN_EXE_catamaran");
        let script = format!("trap '' XFSZ; ulimit -f 1; exec '{program}' ata a.npy {option}");
        let mut shell = Command::new("sh");
        shell.arg("-c").arg(script).current_dir(folder.path(""));
        let run = Run::new(shell.output().unwrap());
        assert_eq!(run.code, Some(1), "{}", run.stdout);
        assert_eq!(run.stderr.lines().count(), 1, "{}", run.stderr);
        assert!(run.stderr.contains(": can't be written: "), "{}", run.stderr);
        assert_eq!(folder.names(), ["a.npy"], "{option}");
    }
}

#[cfg(unix)]
#[test]
fn ctrl_c_leaves_nothing() {
    let folder = Folder::new();
    assert!(Command::new("mkfifo").arg(folder.path("a.csv")).status().unwrap().success());
    let mut child = folder
        .program()
        .args(["ata", "a.csv", "-o", "c.npy"])
        .stderr(std::process::Stdio::piped())
        .stdout(std::process::Stdio::null())
        .spawn()
        .unwrap();
    // Opening waits for the reader: from here on the program is at work.
    let mut pipe = File::options().write(true).open(folder.path("a.csv")).unwrap();
    pipe.write_all(b"1,2\n").unwrap();
    assert!(
        Command::new("kill").args(["-INT", &child.id().to_string()]).status().unwrap().success()
    );
    // It notices at its next piece of input.
    while child.try_wait().unwrap().is_none() {
        let _ = pipe.write_all(b"3,4\n");
        std::thread::sleep(std::time::Duration::from_millis(5));
    }
    let run = Run::new(child.wait_with_output().unwrap());
    assert_eq!((run.code, run.stderr.as_str()), (Some(130), "catamaran: cancelled\n"));
    assert_eq!(folder.names(), ["a.csv"]);
}

#[test]
fn thousands_of_threads_are_capped_with_a_note() {
    let folder = Folder::new();
    folder.write_npy("a.npy", &[700, 700], &table(700, 700));
    let report = folder.succeed("ata a.npy --threads 8000 --explain -o c.npy");
    let cores = std::thread::available_parallelism().unwrap().get();
    let note = format!("threads     {} instead of 8000: at most 4 for each core", 4 * cores);
    assert_eq!(report.matches(&note).count(), 1, "{report}");
    folder.succeed("ata a.npy -o few.npy");
    let read = |name| fs::read(folder.path(name)).unwrap();
    assert!(read("c.npy") == read("few.npy"));
    assert!(!folder.succeed("ata a.npy --threads 1 --explain").contains("instead of"));
}

#[test]
fn pinned_threads_write_the_same_bytes_by_every_way_to_c() {
    let folder = Folder::new();
    folder.write_npy("a.npy", &[700, 300], &table(700, 300));
    let ways =
        ["", "--scheme exact", "--center --scheme winograd", "--block-rows 64 --reproducible"];
    for way in ways {
        let plain = folder.succeed(&format!("ata a.npy {way} --explain -o plain.npy --force"));
        assert!(!plain.contains("pinned"), "{plain}");
        let options = "--threads 2 --pin --verify --explain -o pinned.npy --force";
        let pinned = folder.succeed(&format!("ata a.npy {way} {options}"));
        assert!(pinned.contains(", pinned"), "{pinned}");
        let read = |name| fs::read(folder.path(name)).unwrap();
        assert!(read("plain.npy") == read("pinned.npy"), "{way}");
    }
}

#[test]
fn a_small_product_without_a_file_is_printed() {
    let folder = Folder::new();
    folder.write("a.csv", "1,2\n3,4\n0.5,-1\n");
    let said = folder.succeed("ata a.csv");
    let rows: Vec<Vec<&str>> = said.lines().map(|line| line.split_whitespace().collect()).collect();
    assert!(
        rows.contains(&vec!["10.2500", "13.5000"]) && rows.contains(&vec!["13.5000", "21"]),
        "{said}"
    );
    assert!(said.contains("-o FILE"), "{said}");
    // It is a result, not a status line; the half that is not computed is zero, as in a file.
    let said = folder.succeed("ata a.csv --quiet --uplo lower");
    let rows: Vec<Vec<&str>> = said.lines().map(|line| line.split_whitespace().collect()).collect();
    assert_eq!(rows, [["10.2500", "0"], ["13.5000", "21"]]);
    let said = folder.succeed("--json ata a.csv");
    assert!(said.contains("\"record\":\"row\",\"number\":1,\"entries\":[13.5,21.0]"), "{said}");
    let said = folder.succeed("ata a.csv -o c.npy");
    assert!(!said.contains("13.5000") && !said.contains("hint"), "{said}");
}

#[test]
fn a_large_product_without_a_file_is_summarized() {
    let (folder, c) = with_input(30, 12);
    let range = |values: &mut dyn Iterator<Item = f64>| {
        values.fold((f64::MAX, f64::MIN), |(low, high), x| (low.min(x), high.max(x)))
    };
    let (least, largest) = range(&mut (0..12).map(|i| c[13 * i]));
    let (low, high) = range(&mut (0..144).filter(|k| k % 13 != 0).map(|k| c[k]));
    let norm = c.iter().map(|x| x * x).sum::<f64>().sqrt();
    for uplo in ["both", "lower", "upper"] {
        let said = folder.succeed(&format!("ata a.npy --quiet --uplo {uplo}"));
        let lines: Vec<&str> = said.lines().collect();
        assert_eq!(lines[0], format!("diagonal    {least} to {largest}"), "{uplo}");
        assert_eq!(lines[1], format!("others      {low} to {high}"), "{uplo}");
        let digits: f64 = lines[2].split_whitespace().nth(1).unwrap().parse().unwrap();
        assert!((digits / norm - 1.0).abs() < 1e-5, "{said}");
    }
    assert!(folder.succeed("ata a.npy").contains("-o FILE writes all 12 x 12 entries"));
}
