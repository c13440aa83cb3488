//! numpy with the library in front of its own BLAS, where there is a Python that has numpy.

use std::fs::{self, File, OpenOptions};
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

/// Returns a Python that has numpy: the one that `CATAMARAN_BLAS_PYTHON` names, which must have it;
/// else one of those that scripts keep beside this program, or the system's.
fn python() -> Option<PathBuf> {
    if let Some(named) = std::env::var_os("CATAMARAN_BLAS_PYTHON").map(PathBuf::from) {
        assert!(has_numpy(&named), "CATAMARAN_BLAS_PYTHON={}: no numpy there", named.display());
        return Some(named);
    }
    let program = std::env::current_exe().unwrap();
    let target = program.ancestors().nth(3).unwrap();
    let system = PathBuf::from("python3");
    kept(target).into_iter().chain([system]).find(|python| has_numpy(python))
}

/// Returns the Pythons of scripts/python-environment, scripts/test-blas and scripts/rivals, as far
/// as they are in `target`.
fn kept(target: &Path) -> Vec<PathBuf> {
    let environments = fs::read_dir(target.join("python")).into_iter().flatten().flatten();
    environments
        .map(|environment| environment.path())
        // Of the others, packages are missing.
        .filter(|environment| environment.join("complete").exists())
        .chain([target.join("test-blas"), target.join("rivals")])
        .map(|environment| environment.join("bin/python"))
        .filter(|python| python.exists())
        .collect()
}

fn has_numpy(python: &Path) -> bool {
    let output = Command::new(python).args(["-c", "import numpy"]).output();
    output.is_ok_and(|output| output.status.success())
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

#[test]
fn environments_of_scripts_are_found_when_they_are_complete() {
    let target = tempfile::tempdir().unwrap();
    assert!(kept(target.path()).is_empty());
    let environments = ["python/venv-1", "python/venv-2", "python/wheels", "rivals"];
    let [partial, complete, wheels, rivals] = environments.map(|name| target.path().join(name));
    for environment in [&partial, &complete, &rivals] {
        fs::create_dir_all(environment.join("bin")).unwrap();
        File::create(environment.join("bin/python")).unwrap();
    }
    fs::create_dir_all(wheels).unwrap();
    File::create(complete.join("complete")).unwrap();
    assert_eq!(kept(target.path()), [complete, rivals].map(|path| path.join("bin/python")));
}
