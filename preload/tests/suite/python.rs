//! numpy with the library in front of its own BLAS, where there is a Python that has numpy.

use std::fs::OpenOptions;
use std::io::Write;
use std::path::{Path, PathBuf};
use std::process::Command;

use super::child::{auto_computes, preloaded};

/// Products of integers, which numpy computes without BLAS, are exact in floating point too.
const SCRIPT: &str = "
import numpy as np
rng = np.random.default_rng(1)
a, b = (rng.integers(-8, 9, (400, 250)) for _ in range(2))
gram, outer, product = a.T @ a, a @ a.T, a.T @ b
for dtype in (np.float64, np.float32):
    x, y = a.astype(dtype), b.astype(dtype)
    for found, expected in ((x.T @ x, gram), (x @ x.T, outer), (x.T @ y, product)):
        assert found.dtype == dtype and (found == expected).all()
    small = x[:5, :7]
    assert (small.T @ small == a[:5, :7].T @ a[:5, :7]).all()
for dtype in (np.complex128, np.complex64):
    z = (a + 1j * b).astype(dtype)
    found = z.conj().T @ z
    assert found.dtype == dtype and (found.real == gram + b.T @ b).all()
    assert (found.imag == product - product.T).all()
centred = a - a.mean(axis=0)
assert abs(np.cov(a.T) - np.einsum('ki,kj->ij', centred, centred) / 399).max() < 1e-11
";

/// Returns a Python that has numpy: one that is named, those of scripts/test-blas and
/// scripts/rivals, or the system's.
fn python() -> Option<PathBuf> {
    let target = std::env::current_exe().unwrap();
    let target = target.ancestors().nth(3).unwrap();
    let named = std::env::var_os("CATAMARAN_BLAS_PYTHON").map(PathBuf::from);
    let candidates = named
        .into_iter()
        .chain([target.join("test-blas/bin/python"), target.join("rivals/bin/python")])
        .chain([PathBuf::from("python3")]);
    let has_numpy = |python: &PathBuf| {
        let output = Command::new(python).args(["-c", "import numpy"]).output();
        output.is_ok_and(|output| output.status.success())
    };
    candidates.into_iter().find(has_numpy)
}

fn run(python: &Path, variables: &[(&str, &str)]) -> String {
    let output = preloaded(python, &[], variables).args(["-c", SCRIPT]).output().unwrap();
    let errors = String::from_utf8_lossy(&output.stderr).into_owned();
    assert!(output.status.success(), "{variables:?}: {errors}");
    errors
}

#[test]
fn numpy_computes_by_us_and_forwards_the_rest() {
    let Some(python) = python() else {
        // scripts/test reports what is in this file.
        if let Some(list) = std::env::var_os("CATAMARAN_SKIPPED") {
            let mut list = OpenOptions::new().create(true).append(true).open(list).unwrap();
            writeln!(list, "skipped: no Python with numpy to preload libcatamaran_blas.so")
                .unwrap();
        }
        return;
    };
    let report = run(&python, &[("CATAMARAN_BLAS_VERBOSE", "1")]);
    let line = report.lines().find(|line| line.contains("dsyrk")).expect("calls of dsyrk");
    assert_eq!(line.contains(" 0 computed in "), !auto_computes(), "{report}");
    assert!(line.contains("small "), "{report}");
    assert!(line.ends_with(".so") && line.contains("blas"), "{report}");
    let report =
        run(&python, &[("CATAMARAN_BLAS_VERBOSE", "1"), ("CATAMARAN_BLAS", "reproducible")]);
    assert!(report.lines().any(|l| l.contains("dsyrk") && !l.contains("forwarded")), "{report}");
    run(&python, &[("CATAMARAN_BLAS", "max"), ("CATAMARAN_NUM_THREADS", "1")]);
    assert_eq!(run(&python, &[("CATAMARAN_BLAS", "off")]), "");
}
