//! `catamaran ata` on files larger than a block, its checkpoints, and `catamaran ata-merge`.

use std::fs;
use std::io::Write as _;
use std::path::Path;
use std::process::{Command, Stdio};
use std::time::Duration;

use catamaran::io::{Output, Overwrite, write_accumulator};
use catamaran::rows::Accumulator;

use crate::common::{Folder, Run, oracle, table, with_input};

const M: usize = 203;
const N: usize = 11;

/// Numbers that every order of additions rounds differently.
fn rough_table(m: usize, n: usize) -> Vec<f64> {
    (0..m * n).map(|k| ((k * 7919 + 13) % 10007) as f64 * 0.37 - 1000.0).collect()
}

#[test]
fn blocks_of_any_height_give_the_product() {
    let (folder, expected) = with_input(M, N);
    folder.write_fortran_npy("f.npy", &[M as u64, N as u64], &table(M, N));
    let weights: Vec<f64> = (0..M).map(|i| i as f64 - 50.0).collect();
    folder.write_npy("w.npy", &[M as u64], &weights);
    let weighted = oracle(&table(M, N), N, Some(&weights));
    for name in ["a.npy", "f.npy"] {
        for rows in [1, 7, 64, 500] {
            let options =
                format!("{name} --block-rows {rows} --verify --require-finite -o c.npy --force");
            folder.succeed(&format!("ata {options}"));
            assert_eq!(folder.read_npy::<f64>("c.npy", &[N; 2]), expected, "{options}");
            folder.succeed(&format!("ata {options} --weights w.npy"));
            assert_eq!(folder.read_npy::<f64>("c.npy", &[N; 2]), weighted, "{options}");
        }
    }
}

#[test]
fn bytes_do_not_depend_on_threads_or_on_the_format_of_the_file() {
    let folder = Folder::new();
    let (m, n) = (700, 40);
    let a = rough_table(m, n);
    folder.write_npy("a.npy", &[m as u64, n as u64], &a);
    folder.write_fortran_npy("f.npy", &[m as u64, n as u64], &a);
    folder.write("a.csv", crate::common::csv(&a, n));
    let mut outputs = Vec::new();
    for name in ["a.npy", "f.npy", "a.csv"] {
        for threads in [1, 2, 3] {
            let options = "--center --block-rows 100 --verify -o c.npy --force";
            folder.succeed(&format!("ata {name} {options} --threads {threads}"));
            outputs.push(fs::read(folder.path("c.npy")).unwrap());
        }
    }
    assert!(outputs.iter().all(|output| *output == outputs[0]));
}

#[test]
fn explain_says_how_often_a_is_read() {
    let (folder, _) = with_input(M, N);
    let report = folder.succeed("ata a.npy --explain");
    assert!(report.contains("203 in 1 blocks of 203") && report.contains("read once"), "{report}");
    let report = folder.succeed("ata a.npy --explain --block-rows 50 --verify");
    assert!(report.contains("203 in 5 blocks of 50"), "{report}");
    assert!(report.contains("one more read of A"), "{report}");
}

#[test]
fn c_larger_than_memory_is_computed_in_strips() {
    let folder = Folder::new();
    let (m, n) = (60, 700);
    let a = table(m, n);
    folder.write_npy("a.npy", &[m as u64, n as u64], &a);
    let expected = oracle(&a, n, None);
    // C has 3.7 MiB.
    let options = "--memory 0.003 --block-rows 16 --explain";
    for (uplo, lower, upper) in
        [("both", true, true), ("lower", true, false), ("upper", false, true)]
    {
        let report = folder.succeed(&format!("ata a.npy {options} --uplo {uplo} -o c.npy --force"));
        assert!(
            report.contains("A is read 2 times") || report.contains("A is read 3 times"),
            "{report}"
        );
        let c = folder.read_npy::<f64>("c.npy", &[n; 2]);
        for (k, (&found, &wanted)) in c.iter().zip(&expected).enumerate() {
            let (i, j) = (k / n, k % n);
            let given = lower && i >= j || upper && i <= j;
            assert_eq!(found, if given { wanted } else { 0.0 }, "{uplo} {i} {j}");
        }
    }
    folder.succeed("ata a.npy -o whole.npy");
    folder.succeed(&format!("ata a.npy {options} -o strips.npy"));
    let read = |name| fs::read(folder.path(name)).unwrap();
    assert!(read("whole.npy") == read("strips.npy"), "the sums are exact, and so is the file");
    // About the mean: the same up to rounding.
    folder.succeed("ata a.npy --covariance -o whole.npy --force");
    folder.succeed(&format!("ata a.npy --covariance {options} -o strips.npy --force"));
    let (whole, strips) = (
        folder.read_npy::<f64>("whole.npy", &[n; 2]),
        folder.read_npy::<f64>("strips.npy", &[n; 2]),
    );
    assert!(whole.iter().zip(&strips).all(|(x, y)| (x - y).abs() < 1e-10));

    // What is not finite is counted over all strips.
    let mut far = table(m, n);
    far[5] = 1e200;
    folder.write_npy("far.npy", &[m as u64, n as u64], &far);
    let run =
        folder.run(&format!("ata far.npy {options} --accuracy classical -o strips.npy --force"));
    assert!(run.stdout.contains("for strips"), "{}", run.stdout);
    let note = "far.npy: all entries are finite, but 1 of 490000 entries of C are not finite";
    assert!(run.stderr.contains(note), "{}", run.stderr);
    // So are squares that underflow, here in a column of the last strip.
    let mut near = table(m, n);
    (0..m).for_each(|i| near[i * n + n - 1] = 1e-170);
    folder.write_npy("near.npy", &[m as u64, n as u64], &near);
    let run =
        folder.run(&format!("ata near.npy {options} --accuracy classical -o strips.npy --force"));
    assert!(run.stderr.contains("near.npy: column 699 (counted from 0) is not"), "{}", run.stderr);

    let fail = |arguments: &str| folder.fail(&format!("ata a.npy {options} {arguments}"));
    assert!(fail("-o c.csv").contains("c.csv: a matrix larger than memory"));
    assert!(fail("").contains("name a file with -o"));
    for option in ["--verify", "--picture p.png", "--checkpoint k", "--accumulator k"] {
        let message = fail(&format!("-o d.npy {option}"));
        assert!(message.contains("needs all of C in memory"), "{message}");
    }
    let message = folder.fail("ata a.npy --memory 0.0001 -o d.npy");
    assert!(message.contains("memory: ") && message.contains("a row of C need"), "{message}");
    assert!(message.contains("blocks of fewer rows need less"), "{message}");
    assert!(message.contains("(--memory), in blocks of --block-rows: "), "{message}");
}

#[test]
fn strips_of_the_exact_path_are_the_bytes_of_the_whole() {
    let folder = Folder::new();
    let (m, n) = (60, 700);
    folder.write_npy("a.npy", &[m as u64, n as u64], &rough_table(m, n));
    let options = "a.npy --scheme exact --threads 1 --center --block-rows 32";
    folder.succeed(&format!("ata {options} -o whole.npy"));
    let mut reads = 0;
    // The scratch of the exact path depends on the machine.
    for memory in [0.05, 0.02, 0.015, 0.01, 0.007, 0.005] {
        let run =
            folder.run(&format!("ata {options} -o strips.npy --force --explain --memory {memory}"));
        if run.code != Some(0) {
            continue;
        }
        reads += usize::from(run.stdout.contains("times, for strips"));
        let read = |name| fs::read(folder.path(name)).unwrap();
        assert!(read("whole.npy") == read("strips.npy"), "{memory} GiB");
    }
    assert!(reads > 0, "or no strip was made");
}

/// Kills the program at moments that a seed gives, and goes on until it succeeds: the bytes of C
/// must be those of a run without a stop.
fn kill_and_resume(kills: usize, seed: u64) {
    let folder = Folder::new();
    let (m, n) = (60_000, 30);
    folder.write_npy("a.npy", &[m as u64, n as u64], &rough_table(m, n));
    let options = "a.npy --center --block-rows 320";
    folder.succeed(&format!("ata {options} -o whole.npy"));
    let arguments =
        format!("ata {options} -o c.npy --checkpoint sums --checkpoint-every 0 --resume");
    let (mut state, mut resumed, mut killed) = (seed, 0, 0);
    while killed < kills {
        let before = fs::metadata(folder.path("sums")).and_then(|about| about.modified()).ok();
        let mut child = folder
            .program()
            .args(arguments.split_whitespace())
            .stdout(Stdio::piped())
            .stderr(Stdio::piped())
            .spawn()
            .unwrap();
        // At least one more checkpoint, so that all the kills together end; then any moment.
        let now = || fs::metadata(folder.path("sums")).and_then(|about| about.modified()).ok();
        while child.try_wait().unwrap().is_none() && now() == before {
            std::thread::sleep(Duration::from_millis(1));
        }
        state = state.wrapping_mul(6364136223846793005).wrapping_add(1442695040888963407);
        std::thread::sleep(Duration::from_micros((state >> 33) % 12_000));
        child.kill().unwrap();
        let run = Run::new(child.wait_with_output().unwrap());
        assert!(run.code.is_none() || run.code == Some(0), "{}", run.stderr);
        resumed += usize::from(run.stdout.contains("resumed     sums: row"));
        if run.code == Some(0) {
            // It was faster than the kill: another one from the first row.
            compare(&folder);
            fs::remove_file(folder.path("c.npy")).unwrap();
        } else {
            killed += 1;
        }
    }
    let report = folder.succeed(&arguments);
    assert!(resumed + usize::from(report.contains("resumed     sums: row")) > 0, "{report}");
    compare(&folder);
    assert!(!folder.path("sums").exists(), "the checkpoint is removed in the end");
}

fn compare(folder: &Folder) {
    let read = |name| fs::read(folder.path(name)).unwrap();
    assert!(read("whole.npy") == read("c.npy"), "the bytes after kills are others");
}

#[test]
fn kill_at_any_moment_and_resume_gives_the_same_bytes() {
    kill_and_resume(3, 1);
}

/// The same, more often.
#[test]
#[ignore = "long: scripts/test --long"]
fn twenty_kills_and_resume_give_the_same_bytes() {
    kill_and_resume(20, 2);
}

/// A run that fails at row 150, with checkpoints, and the bytes of one that does not.
fn interrupted(options: &str) -> (Folder, Vec<u8>) {
    let folder = Folder::new();
    let mut a = rough_table(M, N);
    folder.write_npy("other.npy", &[M as u64, N as u64], &a);
    a[150 * N + 3] = f64::INFINITY;
    folder.write_npy("a.npy", &[M as u64, N as u64], &a);
    folder.succeed(&format!("ata a.npy {options} --block-rows 20 -o whole.npy"));
    let arguments = format!("{options} --block-rows 20 --checkpoint sums --checkpoint-every 0");
    let run = folder.run(&format!("ata a.npy {arguments} --require-finite -o c.npy"));
    assert_eq!(run.code, Some(1), "{}", run.stdout);
    assert!(run.stderr.contains("a.npy: inf at row 150, column 3"), "{}", run.stderr);
    assert!(!folder.path("c.npy").exists());
    let bytes = fs::read(folder.path("whole.npy")).unwrap();
    (folder, bytes)
}

const RESUME: &str = "--block-rows 20 --checkpoint sums --resume -o c.npy";

#[test]
fn last_checkpoint_survives_an_error_and_resumes() {
    for options in ["", "--f32"] {
        let (folder, expected) = interrupted(options);
        let report = folder.succeed(&format!("ata a.npy {options} {RESUME}"));
        assert!(report.contains("resumed     sums: row 140 of 203"), "{report}");
        assert!(fs::read(folder.path("c.npy")).unwrap() == expected, "{options}");
        assert_eq!(folder.names(), ["a.npy", "c.npy", "other.npy", "whole.npy"]);
    }
}

/// Exact sums read all rows once for their bounds, and find what is not finite before they begin.
#[test]
fn exact_sums_refuse_an_infinity_before_the_first_checkpoint() {
    let (folder, expected) = interrupted("--reproducible");
    assert_eq!(folder.names(), ["a.npy", "other.npy", "whole.npy"]);
    folder.succeed(&format!("ata a.npy --reproducible {RESUME}"));
    assert!(fs::read(folder.path("c.npy")).unwrap() == expected);
}

#[test]
fn resuming_what_is_different_says_what() {
    let (folder, _) = interrupted("");
    folder.write_npy("w.npy", &[M as u64], &[1.0; M]);
    for (arguments, expected) in [
        ("other.npy", "A was "),
        ("a.npy --columns 0..10", "sums: made with other options: --columns 0..10 was not given"),
        ("a.npy --scheme exact", "scheme was auto, and is exact now"),
        ("a.npy --center", "centring was none, and is mean now"),
        ("a.npy --accuracy fast", "accuracy was default, and is fast now"),
        ("a.npy --weights w.npy", "weights was none, and is "),
        ("a.npy --f32", "an accumulator of f64, not of f32"),
        ("a.npy --block-rows 21", "sums: --block-rows: the number of rows of a block was 20, and"),
    ] {
        let rest = if arguments.contains("--block-rows") {
            RESUME.replace("--block-rows 20", "")
        } else {
            RESUME.to_owned()
        };
        let message = folder.fail(&format!("ata {arguments} {rest}"));
        assert!(message.contains(expected), "{arguments}: {message}");
    }
    let whole = fs::read(folder.path("sums")).unwrap();
    folder.write("sums", &whole[..whole.len() - 1]);
    let message = folder.fail(&format!("ata a.npy {RESUME}"));
    assert!(message.contains("sums: truncated"), "{message}");
    folder.write("sums", "something else, which is long enough");
    let message = folder.fail(&format!("ata a.npy {RESUME}"));
    assert!(message.contains("sums: not an accumulator"), "{message}");
    folder.write("sums", whole);
    let same = rough_table(M, N);
    folder.write_npy("a.npy", &[M as u64, N as u64], &same);
    let message = folder.fail(&format!("ata a.npy {RESUME}"));
    assert!(message.contains("A was ") && message.contains("modified"), "{message}");
}

#[test]
fn resuming_with_other_options_of_tables_names_them() {
    let folder = Folder::new();
    folder.write("a.csv", "1;2\n3;5\n4;4\n");
    folder.succeed("ata a.csv --separator semicolon --columns 0,1 --accumulator sums");
    let resumed = "ata a.csv -o c.npy --checkpoint sums --resume";
    for (options, how) in [
        (
            "--columns 0,1 --skip 1",
            "--skip 1 was not given, and is now; --separator ';' was given, and is not now",
        ),
        ("--columns 1,0 --separator ;", "--columns 0,1 was given, and --columns 1,0 is now"),
    ] {
        let message = folder.fail(&format!("{resumed} {options}"));
        let expected = format!("sums: made with other options: {how}\n");
        assert!(message.ends_with(&expected), "{options}: {message}");
    }
    folder.write("a.csv", "1;2\n3;5\n4;44\n");
    let message = folder.fail(&format!("{resumed} --columns 0,1 --separator ;"));
    assert!(message.contains("sums: accumulator: A was ") && message.contains("modified"));
    assert!(message.len() < 400 && !message.contains("None"), "{message}");
}

#[test]
fn checkpoints_of_other_options_stay_when_they_are_refused() {
    let (folder, _) = with_input(M, N);
    // Sums of all rows are as good as a checkpoint; those of three processes are chosen.
    folder.succeed("ata a.npy --reproducible --accumulator sums");
    fs::copy(folder.path("sums"), folder.path("sums.0-of-3")).unwrap();
    let resumed = "ata a.npy -o c.npy --reproducible --checkpoint sums --resume";
    let message = folder.fail(&format!("{resumed} --center"));
    let why = "sums.0-of-3: accumulator: centring was none, and is mean now";
    assert!(message.contains(why), "{message}");
    folder.succeed(resumed);
    assert_eq!(folder.names(), ["a.npy", "c.npy"]);
}

#[test]
fn resume_without_a_checkpoint_begins_and_says_so() {
    let (folder, expected) = with_input(M, N);
    let report = folder.succeed("ata a.npy -o c.npy --checkpoint sums --resume");
    assert!(report.contains("resumed     no sums: the run starts from the first row"), "{report}");
    assert_eq!(folder.read_npy::<f64>("c.npy", &[N; 2]), expected);
    assert_eq!(folder.names(), ["a.npy", "c.npy"]);
}

#[test]
fn checkpoint_is_not_replaced_by_accident() {
    let (folder, expected) = with_input(M, N);
    folder.write("sums", "precious");
    let message = folder.fail("ata a.npy -o c.npy --checkpoint sums");
    assert!(message.contains("sums: exists already"), "{message}");
    assert!(message.contains("--resume continues from it"), "{message}");
    assert_eq!(fs::read_to_string(folder.path("sums")).unwrap(), "precious");
    folder.succeed("ata a.npy -o c.npy --checkpoint sums --force");
    assert_eq!(folder.read_npy::<f64>("c.npy", &[N; 2]), expected);
    let message = folder.fail("ata a.npy --checkpoint new");
    assert!(message.contains("--checkpoint needs -o or --accumulator"), "{message}");
    let message = folder.fail("ata a.npy -o d.npy --checkpoint none/sums");
    assert!(message.contains("none/sums: can't be written"), "{message}");
    for options in ["--resume", "--checkpoint-every 5"] {
        assert_eq!(folder.run(&format!("ata a.npy -o d.npy {options}")).code, Some(2));
    }
    let run = folder.run("ata a.npy -o d.npy --checkpoint k --checkpoint-every -1");
    assert_eq!(run.code, Some(2));
}

/// A limit on the size of files stands in for a full disk.
#[cfg(unix)]
#[test]
fn checkpoint_that_can_not_be_written_is_told_and_the_last_one_stays() {
    let folder = Folder::new();
    // The sums have 7 KiB; C is packed.
    let (m, n) = (100, 40);
    folder.write_npy("a.npy", &[m as u64, n as u64], &vec![1.0; m * n]);
    let program = env!("CARGO_BIN_EXE_catamaran");
    let arguments = "ata a.npy --block-rows 40 -o c.npy.gz --checkpoint sums --checkpoint-every 0";
    let script = format!("trap '' XFSZ; ulimit -f 4; exec '{program}' {arguments}");
    let run = Run::new(
        Command::new("sh").arg("-c").arg(script).current_dir(folder.path("")).output().unwrap(),
    );
    assert_eq!(run.code, Some(0), "{}", run.stderr);
    // After the last block none is due.
    assert_eq!(run.stderr.lines().count(), 2, "{}", run.stderr);
    assert!(run.stderr.contains("sums: can't be written: "), "{}", run.stderr);
    assert_eq!(folder.names(), ["a.npy", "c.npy.gz"]);
    folder.succeed("ata a.npy --block-rows 40 -o d.npy");
    assert!(folder.read_npy::<f64>("d.npy", &[n; 2]).iter().all(|&x| x == 100.0));
}

/// The rows of `a` from each bound to the next, in files 0.npy, 1.npy, ...
fn split(folder: &Folder, a: &[f64], n: usize, bounds: &[usize]) -> usize {
    for (i, pair) in bounds.windows(2).enumerate() {
        let rows = &a[pair[0] * n..pair[1] * n];
        folder.write_npy(&format!("{i}.npy"), &[(pair[1] - pair[0]) as u64, n as u64], rows);
    }
    bounds.len() - 1
}

#[test]
fn sums_of_parts_merge_to_the_whole() {
    let (folder, expected) = with_input(M, N);
    let count = split(&folder, &table(M, N), N, &[0, 1, 100, 100, M]);
    for i in 0..count {
        let report = folder.succeed(&format!("ata {i}.npy --accumulator {i}.sums --verify"));
        assert!(report.contains(&format!("kept        {i}.sums")), "{report}");
        folder.succeed(&format!("ata {i}.npy --center --accumulator {i}.centred"));
    }
    let report = folder.succeed("ata-merge 0.sums 1.sums 2.sums 3.sums -o c.npy");
    assert!(
        report.contains("sums        4 files: 203 rows, 11 columns, f64, not centred"),
        "{report}"
    );
    assert_eq!(folder.read_npy::<f64>("c.npy", &[N; 2]), expected);

    // In another grouping, by way of a file.
    folder.succeed("ata-merge 3.centred 1.centred --accumulator some.centred");
    folder.succeed("ata-merge 2.centred some.centred 0.centred --covariance -o d.npy");
    folder.succeed("ata a.npy --covariance -o whole.npy");
    let (found, whole) =
        (folder.read_npy::<f64>("d.npy", &[N; 2]), folder.read_npy::<f64>("whole.npy", &[N; 2]));
    assert!(found.iter().zip(&whole).all(|(x, y)| (x - y).abs() < 1e-12), "{found:?} {whole:?}");
    folder.succeed("ata-merge 0.sums 1.sums 2.sums 3.sums -o l.npy --uplo lower");
    let lower = folder.read_npy::<f64>("l.npy", &[N; 2]);
    assert!((0..N * N).all(|k| lower[k] == if k / N >= k % N { expected[k] } else { 0.0 }));
}

#[test]
fn weighted_sums_give_no_covariance_even_if_their_weights_add_up_to_the_rows() {
    let folder = Folder::new();
    folder.write("a.csv", "1,2\n3,5\n");
    folder.write("b.csv", "4,1\n7,3\n");
    folder.write("w.csv", "0.5\n1.5\n");
    folder.write("v.csv", "1.5\n0.5\n");
    for (sums, of) in [
        ("plain", "b.csv"),
        ("weighted", "a.csv --weights w.csv"),
        ("other", "b.csv --weights v.csv"),
    ] {
        folder.succeed(&format!("ata {of} --center --accumulator {sums}.sums"));
    }
    folder.succeed("ata-merge weighted.sums plain.sums --accumulator mixed.sums");
    folder.succeed("ata-merge weighted.sums other.sums --accumulator both.sums");
    let says = "--covariance needs centred sums without weights";
    for files in ["weighted.sums", "weighted.sums plain.sums", "mixed.sums", "both.sums"] {
        let refused = folder.fail(&format!("ata-merge {files} --covariance -o c.npy"));
        assert!(refused.contains(says), "{files}: {refused}");
    }
    let refused = folder.fail("ata-merge plain.sums mixed.sums --covariance -o c.npy");
    assert!(refused.contains(says), "{refused}");
    folder.succeed("ata-merge plain.sums --covariance -o c.npy");
    assert_eq!(folder.read_npy::<f64>("c.npy", &[2; 2]), [4.5, 3.0, 3.0, 2.0]);
}

#[test]
fn sums_of_other_columns_do_not_merge() {
    let folder = Folder::new();
    folder.write("a.csv", "x,y\n1,10\n2,20\n");
    folder.write("b.csv", "y,x\n30,3\n40,4\n");
    folder.write("c.csv", "x,y\n30,3\n40,4\n");
    folder.write("d.csv", "5,6\n");
    for (sums, of) in [
        ("a", "a.csv"),
        ("b", "b.csv"),
        ("c", "c.csv"),
        ("d", "d.csv"),
        ("x", "a.csv --columns x"),
        ("y", "a.csv --columns y"),
        ("first", "d.csv --columns 0"),
        ("second", "d.csv --columns 1"),
    ] {
        folder.succeed(&format!("ata {of} --accumulator {sums}.sums"));
    }
    let names = |j: usize, name: &str, other: &str| {
        format!("column {j} (counted from 0) is \"{name}\", and \"{other}\" there")
    };
    for (files, names) in [
        ("a.sums b.sums", names(0, "y", "x")),
        ("a.sums c.sums b.sums", names(0, "y", "x")),
        ("x.sums y.sums", names(0, "y", "x")),
        ("d.sums a.sums", "they have names, and none there".into()),
        ("a.sums d.sums", "they have no names, but there".into()),
    ] {
        let refusal = folder.fail(&format!("ata-merge {files} -o m.csv"));
        let path = files.split(' ').next_back().unwrap();
        assert!(refusal.contains(&format!("{path}: sums of other columns than")), "{refusal}");
        assert!(refusal.contains(&names), "{refusal}");
    }
    folder.succeed("ata-merge a.sums c.sums -o m.npy");
    assert_eq!(folder.read_npy::<f64>("m.npy", &[2; 2]), [2505.0, 300.0, 300.0, 525.0]);
}

#[test]
fn columns_without_names_are_known_by_their_numbers() {
    let folder = Folder::new();
    let rows = [2.0, 1.0, 3.0, 5.0, 7.0, 4.0];
    folder.write_npy("a.npy", &[2, 3], &rows);
    folder.write("a.csv", crate::common::csv(&rows, 3));
    for file in ["a.npy", "a.csv"] {
        for (sums, columns) in [
            ("all", ""),
            ("same", "--columns 0,1,2"),
            ("turned", "--columns 1,0,2"),
            ("first", "--columns 0..2"),
            ("last", "--columns 1..3"),
        ] {
            folder.succeed(&format!("ata {file} {columns} --accumulator {sums}.sums --force"));
        }
        for (files, number, other) in
            [("all turned", 1, 0), ("first last", 1, 0), ("turned same", 0, 1)]
        {
            let files = files.replace(' ', ".sums ");
            let refusal = folder.fail(&format!("ata-merge {files}.sums -o m.npy"));
            let which = format!("is number {number} of its file, and number {other} there");
            let which = format!("column 0 (counted from 0) {which}");
            assert!(refusal.contains(&which), "{file} {files}: {refusal}");
        }
        folder.succeed("ata-merge all.sums same.sums -o m.npy --force");
        let twice = oracle(&rows, 3, Some(&[2.0, 2.0]));
        assert_eq!(folder.read_npy::<f64>("m.npy", &[3; 2]), twice, "{file}");
        fs::remove_file(folder.path("m.npy")).unwrap();
    }
}

#[test]
fn sums_without_labels_merge_and_the_result_knows_the_columns_of_the_others() {
    let folder = Folder::new();
    folder.write("a.csv", "x,y\n1,2\n");
    folder.write("b.csv", "y,x\n3,4\n");
    folder.succeed("ata a.csv --accumulator a.sums");
    folder.succeed("ata b.csv --accumulator b.sums");
    // As those of other programs are.
    let sum = Accumulator::<f64>::new(2, false).unwrap();
    let output = Output::create(&folder.path("old.sums"), Overwrite::Never).unwrap();
    write_accumulator(output, &sum).unwrap();
    folder.succeed("ata-merge old.sums a.sums --accumulator merged.sums -o m.npy");
    assert_eq!(folder.read_npy::<f64>("m.npy", &[2; 2]), [1.0, 2.0, 2.0, 4.0]);
    let refusal = folder.fail("ata-merge merged.sums b.sums -o n.npy");
    assert!(refusal.contains("b.sums: sums of other columns than merged.sums"), "{refusal}");
}

#[test]
fn rows_that_count_twice_are_noted() {
    let folder = Folder::new();
    folder.write("a.csv", "1,2\n3,4\n");
    folder.write("b.csv", "5,6\n");
    folder.succeed("ata a.csv --accumulator a.sums");
    folder.succeed("ata a.csv --accumulator again.sums");
    folder.succeed("ata b.csv --accumulator b.sums");
    for (files, note) in [
        ("a.sums b.sums", ""),
        ("a.sums b.sums a.sums", "note: a.sums: sums of the rows in a.sums, which count twice\n"),
        ("a.sums again.sums", "note: again.sums: sums of the rows in a.sums, which count twice\n"),
    ] {
        let run = folder.run(&format!("ata-merge {files} -o c.npy --force"));
        assert_eq!((run.code, run.stderr.as_str()), (Some(0), note), "{files}");
    }
    // Merged sums know what they are made of.
    folder.write("c.csv", "7,8\n");
    folder.succeed("ata c.csv --accumulator c.sums");
    folder.succeed("ata-merge a.sums b.sums --accumulator ab.sums");
    folder.succeed("ata-merge ab.sums c.sums --accumulator abc.sums");
    for (files, note) in [
        ("ab.sums a.sums", "a.sums: sums of some of the rows in ab.sums"),
        ("b.sums abc.sums", "abc.sums: sums of the rows in b.sums"),
    ] {
        let run = folder.run(&format!("ata-merge {files} -o c.npy --force"));
        let note = format!("note: {note}, which count twice\n");
        assert_eq!((run.code, run.stderr), (Some(0), note), "{files}");
    }
    assert_eq!(folder.run("ata-merge ab.sums c.sums -o c.npy --force").stderr, "");
    // Two matrices from the standard input are not the same.
    if cfg!(unix) {
        for (sums, rows) in [("first.sums", "1,2\n"), ("second.sums", "3,4\n")] {
            let mut command = folder.program();
            command.args(["ata", "-", "--accumulator", sums]).stdin(Stdio::piped());
            let mut child = command.spawn().unwrap();
            child.stdin.take().unwrap().write_all(rows.as_bytes()).unwrap();
            assert!(child.wait().unwrap().success());
        }
        assert_eq!(folder.run("ata-merge first.sums second.sums -o c.npy --force").stderr, "");
    }
}

#[test]
fn sums_that_do_not_fit_together_are_refused() {
    let (folder, _) = with_input(M, N);
    folder.succeed("ata a.npy --accumulator a.sums");
    folder.succeed("ata a.npy --accumulator single.sums --f32");
    folder.succeed("ata a.npy --accumulator centred.sums --center");
    folder.succeed("ata a.npy --accumulator narrow.sums --columns 0..3");
    folder.write("text.sums", "text, and enough of it");
    folder.write("one.csv", "1,2,3\n");
    folder.succeed("ata one.csv --accumulator one.sums --center");
    let (broken, _) = interrupted("");
    fs::copy(broken.path("sums"), folder.path("half.sums")).unwrap();
    for (arguments, expected) in [
        ("a.sums single.sums", "single.sums: an accumulator of f32, not of f64"),
        ("a.sums centred.sums", "centred.sums: accumulator: centring: "),
        ("a.sums narrow.sums", "narrow.sums: accumulator: columns: 11 and 3"),
        ("half.sums", "half.sums: a checkpoint at row 140 of 203"),
        ("text.sums", "text.sums: not an accumulator"),
        ("none.sums", "none.sums: no such file"),
        ("a.sums --covariance", "--covariance needs centred sums"),
        ("one.sums --covariance", "--covariance needs at least 2 rows, but the sums have 1"),
    ] {
        let message = folder.fail(&format!("ata-merge {arguments} -o c.npy"));
        assert!(message.contains(expected), "{expected}: {message}");
    }
    assert_eq!(folder.run("ata-merge a.sums").code, Some(2), "no result is asked for");
    let message = folder.fail("ata-merge a.sums -o a.npy");
    assert!(message.contains("a.npy: exists already"), "{message}");
    let message = folder.fail("ata a.npy --accumulator a.sums");
    assert!(message.contains("a.sums: exists already"), "{message}");
}

#[cfg(unix)]
#[test]
fn a_pipe_is_read_as_a_whole() {
    let (folder, expected) = with_input(M, N);
    let pipe = folder.path("p.npy");
    assert!(Command::new("mkfifo").arg(&pipe).status().unwrap().success());
    let whole = fs::read(folder.path("a.npy")).unwrap();
    let writer = std::thread::spawn(move || fs::write(Path::new(&pipe), whole));
    folder.succeed("ata p.npy -o c.npy --verify");
    writer.join().unwrap().unwrap();
    assert_eq!(folder.read_npy::<f64>("c.npy", &[N; 2]), expected);
}

#[cfg(feature = "hdf5")]
#[test]
fn hdf5_is_written_and_read_under_any_name_with_weights() {
    let folder = Folder::new();
    folder.write("a.csv", "1,2\n3,5\n");
    folder.succeed("ata a.csv -o c.h5");
    folder.succeed("ata a.csv -o c.csv");
    fs::copy(folder.path("c.h5"), folder.path("c.nc")).unwrap();
    folder.succeed("ata c.csv -o of-table.csv");
    for (i, name) in ["c.h5", "c.nc", "c.nc:/matrix", "c.h5:matrix"].into_iter().enumerate() {
        folder.succeed(&format!("ata {name} -o of-{i}.csv"));
        let read = |name: &str| fs::read(folder.path(name)).unwrap();
        assert!(read("of-table.csv") == read(&format!("of-{i}.csv")), "{name}");
    }
    folder.write("row.csv", "1,2\n");
    folder.write("two.csv", "2\n");
    folder.succeed("ata two.csv -o w.h5");
    folder.succeed("ata row.csv --weights w.h5:/matrix -o weighted.csv");
    let found = fs::read_to_string(folder.path("weighted.csv")).unwrap();
    assert_eq!(found, "4.0,8.0\n8.0,16.0\n");
    let message = folder.fail("ata c.nc:/none -o d.csv");
    assert!(message.contains("no dataset /none; the file has /matrix (2 x 2)"), "{message}");
}

#[test]
fn files_of_older_formats_say_what_converts_them() {
    let folder = Folder::new();
    folder.write("a.nc", "CDF\x01 and so on");
    let message = folder.fail("ata a.nc -o c.npy");
    assert!(message.contains("a.nc: netCDF in its classic format"), "{message}");
    assert!(message.contains("nccopy -k nc4"), "{message}");
}

#[test]
fn columns_too_many_for_any_product_are_refused_before_a_list_of_them_is_made() {
    let folder = Folder::new();
    let shape = "{'descr': '<f8', 'fortran_order': False, 'shape': (1, 134217728), }";
    let header = [&b"\x93NUMPY\x01\x00\x76\x00"[..], format!("{shape:117}\n").as_bytes()].concat();
    let path = folder.path("a.npy");
    fs::write(&path, &header).unwrap();
    // Zeros, which take no place on the disk.
    let file = fs::OpenOptions::new().write(true).open(&path).unwrap();
    file.set_len(header.len() as u64 + (1 << 30)).unwrap();
    for line in ["ata a.npy -o c.npy", "pca a.npy", "svd a.npy", "lstsq a.npy a.npy"] {
        let run = folder.run(line);
        assert_eq!(run.code, Some(1), "{line}: {}", run.stderr);
        let expected = "a.npy: 1 x 134217728: A^T A takes 128 PiB of memory";
        assert!(run.stderr.contains(expected), "{line}: {}", run.stderr);
    }
}
