//! Calls that go to the next library, here a fake one whose results are recognized.

use std::ffi::CString;
use std::path::{Path, PathBuf};
use std::process::Command;

use super::calls::{SPELLINGS, gemm, syrk};
use super::child::{auto_computes, errors, run};
use super::oracle::{Matrix, Part};

const FAKE: &str = "CATAMARAN_BLAS_TEST_FAKE";

/// Compiles the fake library into `folder`.
pub fn fake(folder: &Path) -> PathBuf {
    let source = Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/suite/fake.rs");
    let library = folder.join("libfake.so");
    let status = Command::new(std::env::var_os("RUSTC").unwrap_or_else(|| "rustc".into()))
        .args(["--crate-type", "cdylib", "--crate-name", "fake", "--edition", "2021", "-C"])
        .args(["panic=abort", "--cap-lints", "allow", "-o"])
        .args([&library, &source])
        .status()
        .unwrap();
    assert!(status.success());
    library
}

/// Runs the task of a child.
pub fn task(name: &str) {
    match name {
        "forward" => forward(),
        "load later" => {
            assert_eq!((small(), large()), (3.0, 300.0));
            load();
            forward();
        }
        "small" => assert_eq!(small(), 1.0),
        "forward all" => {
            assert_eq!((small(), large()), (1.0, 1.0));
        }
        other => panic!("no task {other}"),
    }
}

/// Loads the fake library locally, as Python does with extensions.
fn load() {
    let path = CString::new(std::env::var(FAKE).unwrap()).unwrap();
    // SAFETY: a library without initializers.
    let handle = unsafe { libc::dlopen(path.as_ptr(), libc::RTLD_NOW | libc::RTLD_LOCAL) };
    assert!(!handle.is_null());
}

/// Returns the first entry of A^T A for A of ones, n x n, by one of the spellings.
fn first(spelling: usize, n: usize) -> f64 {
    let a = Matrix::<f64>::new(n, n, false, 0, || 1.0);
    let mut c = Matrix::<f64>::new(n, n, false, 0, || 0.0);
    syrk(SPELLINGS[spelling], Part::Lower, (&a, true), [1.0, 0.0], &mut c);
    c.at(0, 0)
}

fn small() -> f64 {
    first(0, 3)
}

fn large() -> f64 {
    first(0, 300)
}

/// Checks what is forwarded, and what is not.
fn forward() {
    let ours = |theirs| if auto_computes() { 300.0 } else { theirs };
    // Twice, because the second call takes another way.
    for _ in 0..2 {
        assert_eq!((small(), large()), (1.0, ours(1.0)));
        assert_eq!((first(7, 3), first(7, 300)), (2.0, ours(2.0)));
    }
    let ones = |n| Matrix::<f64>::new(n, n, false, 0, || 1.0);
    let (a, mut c) = (ones(300), ones(300));
    let sides = [(&a, false), (&a, false)];
    // No work, and a leading dimension that is wrong.
    gemm(SPELLINGS[5], (Part::All, ""), sides, [0.0, 1.0], &mut c);
    assert_eq!(c.at(0, 0), 3300.0);
    c.leading = 299;
    gemm(SPELLINGS[5], (Part::All, ""), sides, [1.0, 1.0], &mut c);
    assert_eq!(c.data[0], 3299.0);
    // The lengths of the letters arrive.
    let (a, mut c) = (ones(3), ones(3));
    gemm(SPELLINGS[0], (Part::Upper, "gemmt"), [(&a, true), (&a, true)], [1.0, 0.0], &mut c);
    assert_eq!(c.at(0, 0), 42.0);
    // A spelling that the fake library lacks.
    assert_eq!(first(1, 3), 3.0);
}

#[test]
fn a_library_loaded_for_all_is_next() {
    let folder = tempfile::tempdir().unwrap();
    let fake = fake(folder.path());
    run("forward", &[&fake], &[]);
    run("forward all", &[&fake], &[("CATAMARAN_BLAS", "off")]);
    let output = run("forward", &[&fake], &[("CATAMARAN_BLAS_VERBOSE", "1")]);
    let report = errors(&output);
    let line = report.lines().find(|line| line.contains(" dsyrk_: ")).unwrap();
    let (computed, forwarded, reasons) =
        if auto_computes() { (2, 2, "small 2") } else { (0, 4, "small 2, slower 2") };
    assert!(line.contains(&format!("dsyrk_: 4 calls, {computed} computed in ")), "{report}");
    assert!(line.contains(&format!(", {forwarded} forwarded in ")), "{report}");
    assert!(line.ends_with(&format!("({reasons}) to {}", fake.display())), "{report}");
    let line = report.lines().find(|line| line.contains(" cblas_dgemm: ")).unwrap();
    assert!(line.contains("(arguments 1, trivial 1)"), "{report}");
}

#[test]
fn a_library_loaded_later_and_for_itself_alone_is_found() {
    let folder = tempfile::tempdir().unwrap();
    let fake = fake(folder.path());
    run("load later", &[], &[(FAKE, fake.to_str().unwrap())]);
}

#[test]
fn a_process_that_gained_nothing_says_so_in_one_line() {
    let folder = tempfile::tempdir().unwrap();
    let fake = fake(folder.path());
    let hints = |task, variables: &[(&str, &str)]| {
        let report = errors(&run(task, &[&fake], variables));
        report.matches("catamaran-blas: nothing gained: auto forwarded all large products").count()
    };
    let portable = ("CATAMARAN_ISA", "portable");
    assert_eq!(hints("forward", &[portable]), 1);
    assert_eq!(hints("forward", &[portable, ("CATAMARAN_BLAS_VERBOSE", "1")]), 1);
    assert_eq!(hints("forward", &[portable, ("CATAMARAN_BLAS_VERBOSE", "0")]), 0);
    assert_eq!(hints("forward all", &[portable, ("CATAMARAN_BLAS", "off")]), 0);
    assert_eq!(hints("two calls", &[portable, ("CATAMARAN_BLAS", "reproducible")]), 0);
    // Small products are not worth a word, nor is a process in which some were faster here.
    assert_eq!(hints("small", &[portable]), 0);
    assert_eq!(hints("forward", &[]), usize::from(!auto_computes()));
}

#[test]
fn the_instruction_set_is_limited_and_a_wrong_limit_is_named() {
    let ours = |isa| errors(&run("bytes", &[], &[("CATAMARAN_ISA", isa)]));
    let wrong = ours("avx3");
    let line = "CATAMARAN_ISA: must be portable, neon, dotprod, i8mm, avx2, avxvnni, avx512, vnni \
        or amx, not \"avx3\"";
    assert_eq!(wrong.matches(line).count(), 1, "{wrong}");
    assert!(!ours("avx2").contains("CATAMARAN_ISA"));
}

#[test]
fn the_other_modes_forward_nothing_but_what_they_can_not_compute() {
    let folder = tempfile::tempdir().unwrap();
    let fake = fake(folder.path());
    for mode in ["reproducible", "max"] {
        let variables = [("CATAMARAN_BLAS", mode), ("CATAMARAN_BLAS_VERBOSE", "1")];
        let report = errors(&run("two calls", &[&fake], &variables));
        assert!(report.contains("dsyrk_: 2 calls, 2 computed in "), "{report}");
        assert!(!report.contains("reported once"), "{report}");
        let variables = [("CATAMARAN_BLAS", mode), ("CATAMARAN_BLAS_MEMORY", "100")];
        let report = errors(&run("forward all", &[&fake], &variables));
        let line = format!(
            "dsyrk_: forwarded in spite of mode {mode}: it takes more than CATAMARAN_BLAS_MEMORY"
        );
        assert_eq!(report.matches(&line).count(), 1, "{report}");
    }
}
