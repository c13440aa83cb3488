//! Processes with the library in front of all others.

use std::path::Path;
use std::process::{Command, Output};

use catamaran::faer::{c32, c64};
use catamaran::kernel::packed::FloatIsa;

use super::calls::{Convention, SPELLINGS, Spelling, gemm, syrk};
use super::library;
use super::oracle::{Matrix, Part, Random, Scalar, Trans, check};

/// The variable with the task of a child.
const TASK: &str = "CATAMARAN_BLAS_TEST_TASK";

/// Returns a command that runs `program` with the library, and then `more`, loaded before all
/// others. Of the variables that the library reads, only these are set.
pub fn preloaded(program: &Path, more: &[&Path], variables: &[(&str, &str)]) -> Command {
    let mut command = Command::new(program);
    let ours = library::path();
    let list: Vec<_> = std::iter::once(ours.as_path()).chain(more.iter().copied()).collect();
    let list = list.iter().map(|path| path.to_str().unwrap()).collect::<Vec<_>>().join(":");
    for name in ["", "_VERBOSE", "_MEMORY"] {
        command.env_remove(format!("CATAMARAN_BLAS{name}"));
    }
    for name in ["CATAMARAN", "OMP", "RAYON"] {
        command.env_remove(format!("{name}_NUM_THREADS"));
    }
    command.env("LD_PRELOAD", list).envs(variables.iter().copied());
    command
}

/// Returns whether `auto` computes a product of 300 x 300 on this CPU, within `CATAMARAN_ISA`;
/// elsewhere it forwards it.
pub fn auto_computes() -> bool {
    FloatIsa::best() == FloatIsa::Avx512
}

/// Runs a task in a process of its own and returns its output; fails when the task does.
pub fn run(task: &str, more: &[&Path], variables: &[(&str, &str)]) -> Output {
    let output = preloaded(&std::env::current_exe().unwrap(), more, variables)
        .args(["child::in_child", "--exact", "--nocapture"])
        .env(TASK, task)
        .output()
        .unwrap();
    let text = |bytes: &[u8]| String::from_utf8_lossy(bytes).into_owned();
    assert!(
        output.status.success(),
        "{task} {variables:?}: {}\n{}\n{}",
        output.status,
        text(&output.stdout),
        text(&output.stderr)
    );
    output
}

/// Returns what a process wrote to standard error.
pub fn errors(output: &Output) -> String {
    String::from_utf8_lossy(&output.stderr).into_owned()
}

/// Runs the task of a child; not a test by itself.
#[test]
fn in_child() {
    let Ok(task) = std::env::var(TASK) else { return };
    match task.as_str() {
        "parameters" => {
            parameters::<f64>();
            parameters::<f32>();
            parameters::<c64>();
            parameters::<c32>();
        }
        "bytes" => {
            let real = [hash::<f64>(), hash::<f32>()];
            let [a, b, c, d] = [real[0], real[1], hash::<c64>(), hash::<c32>()];
            println!("bytes {a:016x} {b:016x} {c:016x} {d:016x}");
        }
        "fork" => {
            fork::<f64>();
            fork::<c64>();
        }
        "many threads" => {
            many_threads::<f64>();
            many_threads::<c64>();
        }
        "overlap" => {
            overlap::<f64>();
            overlap::<c64>();
        }
        "wrong" => wrong(),
        "two calls" => two_calls(),
        name if name.starts_with("rounding ") => super::rounding::task(name),
        other => super::host::task(other),
    }
}

/// Checks all parameters of all routines, at small sides and at some that are worth a plan.
fn parameters<T: Scalar>() {
    const FACTORS: [[f64; 2]; 6] =
        [[1.0, 0.0], [0.0, 0.0], [0.0, 1.0], [-0.5, 1.0], [0.75, -2.0], [1.0, 1.0]];
    let small: Vec<[usize; 3]> =
        vec![[0, 3, 2], [3, 0, 2], [3, 2, 0], [1, 1, 1], [2, 5, 7], [13, 7, 31], [37, 17, 41]];
    // Only the first spelling of a convention tries everything.
    let first = |spelling: &Spelling| spelling.prefix.len() <= 6 && !spelling.wide;
    for spelling in SPELLINGS {
        let sides = if first(&spelling) { &small[..] } else { &small[4..6] };
        let factors = if first(&spelling) { &FACTORS[..] } else { &FACTORS[3..5] };
        for &sides in sides {
            for &factors in factors {
                products::<T>(spelling, sides, factors);
            }
        }
    }
    products::<T>(SPELLINGS[0], [160, 130, 210], [-0.5, 0.0]);
    products::<T>(SPELLINGS[9], [131, 150, 230], [1.5, 0.5]);
}

fn products<T: Scalar>(spelling: Spelling, [m, n, k]: [usize; 3], factors: [f64; 2]) {
    let mut random = Random(4711);
    let orders: &[bool] = match spelling.convention {
        Convention::Fortran => &[false],
        Convention::Cblas => &[false, true],
    };
    let beta_is_zero = factors[1] == 0.0;
    for &by_rows in orders {
        let mut matrix = |rows: usize, cols: usize, transposed: bool, gap: usize| {
            let (rows, cols) = if transposed { (cols, rows) } else { (rows, cols) };
            Matrix::<T>::new(rows, cols, by_rows, gap, || random.number())
        };
        // What C holds does not matter when beta is 0.
        let fill = || if beta_is_zero { f64::NAN } else { 0.25 };
        let result = |rows, cols| Matrix::<T>::new(rows, cols, by_rows, 3, fill);
        let context =
            |what: &str| format!("{what} {spelling:?} {m} {n} {k} {factors:?} by rows: {by_rows}");
        let (real, complex) = (factors.map(|x| c64::new(x, 0.0)), factors.map(T::factor));
        let all = [Trans::No, Trans::Transposed, Trans::Conjugated];
        let other = if T::IS_COMPLEX { Trans::Conjugated } else { Trans::Transposed };
        for trans_a in all {
            let transposed = trans_a.transposes();
            let a = matrix(m, k, transposed, 2);
            for part in [Part::Lower, Part::Upper] {
                let before = result(m, m);
                let mut c = before.clone();
                syrk(spelling, part, (&a, transposed), factors, &mut c);
                let sides = [(&a, Trans::No), (&a, other)];
                let sides = if transposed { [sides[1], sides[0]] } else { sides };
                check(sides, real, part, &before, &c, &context("syrk"));
            }
            for trans_b in all {
                let b = matrix(k, n, trans_b.transposes(), 1);
                let before = result(m, n);
                let mut c = before.clone();
                let sides = [(&a, trans_a), (&b, trans_b)];
                gemm(spelling, (Part::All, ""), sides, factors, &mut c);
                check(sides, complex, Part::All, &before, &c, &context("gemm"));
                if T::IS_COMPLEX {
                    continue;
                }

                let b = matrix(k, m, trans_b.transposes(), 0);
                for (part, name) in [(Part::Lower, "gemmt"), (Part::Upper, "gemmtr")] {
                    let before = result(m, m);
                    let mut c = before.clone();
                    let sides = [(&a, trans_a), (&b, trans_b)];
                    gemm(spelling, (part, name), sides, factors, &mut c);
                    check(sides, complex, part, &before, &c, &context(name));
                }
            }
        }
    }
}

/// Returns the lower triangle of A^T A, A k x n.
pub fn gram<T: Scalar>(n: usize, k: usize) -> Matrix<T> {
    let mut random = Random(17);
    let a = Matrix::<T>::new(k, n, false, 0, || random.number());
    let mut c = Matrix::new(n, n, false, 0, || 0.0);
    syrk(SPELLINGS[0], Part::Lower, (&a, true), [1.0, 0.0], &mut c);
    c
}

/// Returns a number that differs when the bytes of some results do.
fn hash<T: Scalar>() -> u64 {
    let mut random = Random(23);
    let a = Matrix::<T>::new(400, 300, false, 0, || random.number());
    let b = Matrix::<T>::new(400, 200, true, 0, || random.number() * 1e3);
    let b = Matrix { rows: b.cols, cols: b.rows, by_rows: false, ..b };
    let mut c = Matrix::new(300, 300, false, 0, || 0.5);
    syrk(SPELLINGS[0], Part::Upper, (&a, true), [1.0, 1.0], &mut c);
    let mut d = Matrix::new(300, 200, false, 0, || 0.5);
    gemm(SPELLINGS[0], (Part::All, ""), [(&a, true), (&b, true)], [2.0, 1.0], &mut d);
    // Small products, which are computed in another way where that is faster.
    let small = [3, 40].map(|n| gram::<T>(n, n + 60).bits());
    let mut hash = 0xcbf2_9ce4_8422_2325_u64;
    for bits in c.bits().into_iter().chain(d.bits()).chain(small.into_iter().flatten()) {
        hash = (hash ^ bits).wrapping_mul(0x0100_0000_01b3);
    }
    hash
}

/// Checks that children of a process that has computed, and is computing, compute the same.
fn fork<T: Scalar>() {
    let expected = gram::<T>(300, 300);
    std::thread::scope(|scope| {
        scope.spawn(|| {
            for _ in 0..10 {
                assert_eq!(gram(300, 300), expected);
            }
        });
        for _ in 0..5 {
            // SAFETY: the child only computes, and ends without the handlers of its parent; if it
            // hangs, the alarm ends it.
            let status = unsafe {
                let child = libc::fork();
                assert!(child >= 0);
                if child == 0 {
                    libc::alarm(20);
                    libc::_exit(i32::from(gram(300, 300) != expected));
                }
                let mut status = 0;
                assert_eq!(libc::waitpid(child, &raw mut status, 0), child);
                status
            };
            assert_eq!(status, 0, "a child hung or computed something else");
        }
    });
    assert_eq!(gram(300, 300), expected);
}

fn many_threads<T: Scalar>() {
    let expected = gram::<T>(300, 300);
    std::thread::scope(|scope| {
        for _ in 0..8 {
            scope.spawn(|| {
                for _ in 0..4 {
                    assert_eq!(gram(300, 300), expected);
                }
            });
        }
    });
}

/// Checks products whose C is a part of the memory of A: beside A, and on it.
fn overlap<T: Scalar>() {
    let (name, trans) = if T::IS_COMPLEX { ("zherk_", b'C') } else { ("dsyrk_", b'T') };
    let op = if T::IS_COMPLEX { Trans::Conjugated } else { Trans::Transposed };
    for n in [5, 200] {
        let mut random = Random(5);
        let both = Matrix::<T>::new(2 * n, 2 * n, false, 0, || random.number());
        let part = |matrix: &Matrix<T>, start: usize| Matrix {
            data: matrix.data[start..].to_vec(),
            rows: n,
            cols: n,
            leading: 2 * n,
            by_rows: false,
        };
        // A is the upper left block; C is the lower left one, or one that begins inside of A.
        for start in [n, n / 2] {
            let (a, before) = (part(&both, 0), part(&both, start));
            let mut memory = both.data.clone();
            let f = super::calls::symbol(name);
            type F<S, T> = unsafe extern "C" fn(
                *const u8,
                *const u8,
                *const i32,
                *const i32,
                *const S,
                *const T,
                *const i32,
                *const S,
                *mut T,
                *const i32,
            );
            let [side, leading] = [n, 2 * n].map(|x| x as i32);
            let [alpha, beta] = [1.0, 0.5].map(T::real);
            let base = memory.as_mut_ptr();
            // SAFETY: the signature of BLAS; both blocks are inside of `memory`.
            unsafe {
                let f = std::mem::transmute::<*mut libc::c_void, F<T::Real, T>>(f);
                f(
                    &b'U',
                    &trans,
                    &side,
                    &side,
                    &alpha,
                    base,
                    &leading,
                    &beta,
                    base.add(start),
                    &leading,
                );
            }
            let after = part(&Matrix { data: memory, ..both.clone() }, start);
            let sides = [(&a, op), (&a, Trans::No)];
            let factors = [1.0, 0.5].map(|x| c64::new(x, 0.0));
            // Of the memory only C is written, so that all else has the bits that it had.
            check(sides, factors, Part::Upper, &before, &after, &format!("{n} {start}"));
        }
    }
}

/// Checks that calls with wrong arguments change nothing.
fn wrong() {
    let a = Matrix::<f64>::new(3, 3, false, 0, || 1.0);
    let mut c = Matrix::<f64>::new(3, 3, false, 0, || 2.0);
    let short = Matrix { leading: 2, ..a.clone() };
    syrk(SPELLINGS[0], Part::Lower, (&short, false), [1.0, 0.0], &mut c);
    let mut short_c = Matrix { leading: 1, ..c.clone() };
    let sides = [(&a, false), (&a, false)];
    gemm(SPELLINGS[5], (Part::All, ""), sides, [1.0, 0.0], &mut short_c);
    assert!(c.data.iter().chain(&short_c.data).all(|&x| x == 2.0));
}

fn two_calls() {
    gram::<f64>(3, 3);
    gram::<f64>(200, 200);
}

#[test]
fn every_parameter_gives_what_the_definition_says() {
    std::thread::scope(|scope| {
        for mode in ["auto", "reproducible", "max", "off"] {
            scope.spawn(move || run("parameters", &[], &[("CATAMARAN_BLAS", mode)]));
        }
    });
}

/// Returns the line of the task `bytes`.
fn bytes(variables: &[(&str, &str)]) -> String {
    let text = String::from_utf8(run("bytes", &[], variables).stdout).unwrap();
    let at = text.find("bytes ").expect("the line of the task");
    text[at..at + 73].to_owned()
}

#[test]
fn results_are_the_same_bytes_for_any_number_of_threads() {
    for mode in ["auto", "reproducible", "max"] {
        let of = |threads| bytes(&[("CATAMARAN_BLAS", mode), ("CATAMARAN_NUM_THREADS", threads)]);
        let bytes = ["1", "2", "4"].map(of);
        assert!(bytes.iter().all(|b| *b == bytes[0]), "{mode}: {bytes:?}");
    }
}

#[test]
fn reproducible_bytes_are_the_same_for_every_instruction_set() {
    for mode in ["reproducible", "max"] {
        let of = |isa| bytes(&[("CATAMARAN_BLAS", mode), ("CATAMARAN_ISA", isa)]);
        let bytes = ["", "portable", "avx2", "avxvnni", "avx512", "vnni"].map(of);
        assert!(bytes.iter().all(|b| *b == bytes[0]), "{mode}: {bytes:?}");
    }
}

#[test]
fn forked_processes_compute_too() {
    run("fork", &[], &[("CATAMARAN_NUM_THREADS", "3")]);
}

#[test]
fn many_threads_may_call_at_once() {
    run("many threads", &[], &[("CATAMARAN_NUM_THREADS", "2")]);
}

#[test]
fn a_result_inside_of_an_operand_is_computed_apart_and_one_beside_it_is_not() {
    run("overlap", &[], &[]);
}

#[test]
fn without_another_library_wrong_arguments_are_named() {
    let output = run("wrong", &[], &[]);
    let errors = errors(&output);
    for line in [
        "catamaran-blas: dsyrk_: parameter number 7 has an illegal value",
        "catamaran-blas: cblas_dgemm: parameter number 14 has an illegal value",
    ] {
        assert!(errors.contains(line), "{errors}");
    }
}

#[test]
fn calls_are_reported_at_exit_on_request() {
    let variables = [("CATAMARAN_BLAS_VERBOSE", "1"), ("OMP_NUM_THREADS", "2")];
    let report = errors(&run("two calls", &[], &variables));
    assert!(report.contains(", auto, 2 threads, 64 MiB"), "{report}");
    assert!(report.contains("catamaran-blas: dsyrk_: 2 calls, 2 computed in "), "{report}");
    assert!(!errors(&run("two calls", &[], &[])).contains("catamaran-blas"));
}

#[test]
fn values_that_are_none_are_named_once() {
    let variables = [
        ("CATAMARAN_BLAS", "quick"),
        ("CATAMARAN_BLAS_VERBOSE", "2"),
        ("CATAMARAN_BLAS_MEMORY", "64X"),
        ("CATAMARAN_NUM_THREADS", "none"),
    ];
    let errors = errors(&run("two calls", &[], &variables));
    for (name, value) in variables {
        let start = format!(": {name}={value}: must be ");
        assert_eq!(errors.matches(&start).count(), 1, "{errors}");
    }
}
