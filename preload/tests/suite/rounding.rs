//! Callers that round otherwise than to nearest: their mode never enters what is computed here, and
//! `auto` forwards to another library where there is one.

use std::ffi::c_int;

use super::calls::{SPELLINGS, syrk};
use super::child::{auto_computes, errors, run};
use super::host::fake;
use super::oracle::{Matrix, Part, Random, Scalar};

unsafe extern "C" {
    fn fesetround(mode: c_int) -> c_int;
    fn fegetround() -> c_int;
}

/// Upward, downward and toward zero, as `fenv.h` has them.
const MODES: [c_int; 3] = if cfg!(target_arch = "aarch64") {
    [0x40_0000, 0x80_0000, 0xc0_0000]
} else {
    [0x800, 0x400, 0xc00]
};

const NEAREST: c_int = 0;

fn set(mode: c_int) {
    // SAFETY: functions of C's mathematical library. Between these calls this program only calls
    // the library, and compares bytes.
    assert_eq!(unsafe { fesetround(mode) }, 0);
}

fn is(mode: c_int) -> bool {
    // SAFETY: `fegetround` of C reads the mode of this thread, and nothing else.
    unsafe { fegetround() == mode }
}

/// Runs the task of a child: `rounding MODE`, or `rounding forwarded`.
pub fn task(name: &str) {
    let word = name.rsplit(' ').next().unwrap();
    match word.parse() {
        Ok(mode) => first_call(mode),
        Err(_) => forwarded(),
    }
}

/// Returns a random matrix whose product with itself is rounded.
fn random<T: Scalar>(rows: usize, cols: usize) -> Matrix<T> {
    let mut random = Random(29);
    Matrix::new(rows, cols, false, 0, || random.number())
}

/// Returns the bits of A^T A, computed in this mode.
fn product<T: Scalar>(mode: c_int, a: &Matrix<T>) -> Vec<u64> {
    let mut c = Matrix::new(a.cols, a.cols, false, 0, || 0.0);
    set(mode);
    syrk(SPELLINGS[0], Part::Lower, (a, true), [1.0, 0.0], &mut c);
    assert!(is(mode), "the mode of the caller is gone");
    set(NEAREST);
    c.bits()
}

/// Checks that the first product of a process, made in this mode, is that to nearest; and so are
/// those after it. The large one is worth threads.
fn first_call(mode: c_int) {
    let (large, small) = (random::<f64>(310, 300), random::<f32>(30, 20));
    let products = |mode| [product(mode, &large), product(mode, &small)];
    let first = products(mode);
    let nearest = products(NEAREST);
    let later = products(mode);
    assert!(first == nearest, "the first products");
    assert!(later == nearest, "later products");
}

fn forwarded() {
    // What the fake library writes.
    let one = 1.0_f64.to_bits();
    let [small, large] = [3, 300].map(|n| random::<f64>(n, n));
    let expected = product(NEAREST, &large);
    for mode in MODES {
        assert_eq!((product(mode, &small)[0], product(mode, &large)[0]), (one, one));
    }
    assert_eq!(expected[0] != one, auto_computes());
    assert!(product(NEAREST, &large) == expected);
}

#[test]
fn the_mode_of_the_caller_never_enters_a_product() {
    let bytes = |mode: &str, rounding: c_int, threads: &str| {
        let variables = [("CATAMARAN_BLAS", mode), ("CATAMARAN_NUM_THREADS", threads)];
        run(&format!("rounding {rounding}"), &[], &variables);
    };
    // No other library has the symbols, so that `auto` computes everything too.
    for mode in ["reproducible", "max", "auto"] {
        for rounding in MODES {
            bytes(mode, rounding, "1");
            bytes(mode, rounding, "4");
        }
    }
}

#[test]
fn auto_forwards_calls_that_do_not_round_to_nearest() {
    let folder = tempfile::tempdir().unwrap();
    let fake = fake(folder.path());
    let report = errors(&run("rounding forwarded", &[&fake], &[("CATAMARAN_BLAS_VERBOSE", "1")]));
    let line = report.lines().find(|line| line.contains(" dsyrk_: ")).unwrap();
    // Three modes, a small and a large product each.
    assert!(line.contains("rounding 6"), "{report}");
}
