//! A folder, a program, and an oracle.

use std::fs::{self, File};
use std::path::{Path, PathBuf};
use std::process::{Command, Output};

use npyz::WriterBuilder;
use tempfile::TempDir;

/// A temporary folder in which the program runs.
pub struct Folder(TempDir);

/// A folder with an m x n matrix A in a.npy, and A^T A.
#[allow(dead_code)]
pub fn with_input(m: usize, n: usize) -> (Folder, Vec<f64>) {
    let folder = Folder::new();
    let a = table(m, n);
    folder.write_npy("a.npy", &[m as u64, n as u64], &a);
    let c = oracle(&a, n, None);
    (folder, c)
}

/// What a run said and returned.
pub struct Run {
    pub code: Option<i32>,
    pub stdout: String,
    pub stderr: String,
}

/// Where the program finds its cache directory, inside of the folder.
pub const CACHE: &str = "cache";

#[allow(dead_code)]
impl Folder {
    pub fn new() -> Self {
        Self(tempfile::tempdir().expect("a temporary folder"))
    }

    pub fn path(&self, name: &str) -> PathBuf {
        self.0.path().join(name)
    }

    pub fn write(&self, name: &str, content: impl AsRef<[u8]>) {
        fs::write(self.path(name), content).expect("a temporary file");
    }

    /// Names of all files, sorted.
    pub fn names(&self) -> Vec<String> {
        let entries = fs::read_dir(self.0.path()).expect("the folder");
        let mut names: Vec<String> =
            entries.map(|e| e.expect("an entry").file_name().to_string_lossy().into()).collect();
        names.sort();
        names
    }

    /// `catamaran` in this folder.
    pub fn program(&self) -> Command {
        let mut command = Command::new(env!("CARGO_BIN_EXE_catamaran"));
        command.current_dir(self.0.path());
        // What the user has measured stays out of tests, and the other way round.
        for variable in ["XDG_CACHE_HOME", "HOME", "LOCALAPPDATA"] {
            command.env(variable, self.path(CACHE));
        }
        command
    }

    /// Runs `catamaran` with arguments separated by blanks.
    pub fn run(&self, arguments: &str) -> Run {
        let output = self.program().args(arguments.split_whitespace()).output();
        Run::new(output.expect("the program starts"))
    }

    /// [`Folder::run`], which must succeed.
    pub fn succeed(&self, arguments: &str) -> String {
        let run = self.run(arguments);
        assert_eq!(run.code, Some(0), "{arguments}: {}", run.stderr);
        run.stdout
    }

    /// [`Folder::run`], which must fail with one line on stderr, leaving the folder as it was.
    pub fn fail(&self, arguments: &str) -> String {
        let before = self.names();
        let run = self.run(arguments);
        assert_eq!(run.code, Some(1), "{arguments}: {}{}", run.stdout, run.stderr);
        assert_eq!(run.stderr.lines().count(), 1, "{}", run.stderr);
        assert_eq!(self.names(), before, "{arguments}");
        run.stderr
    }

    pub fn write_npy<T: npyz::Serialize + npyz::AutoSerialize + Copy>(
        &self,
        name: &str,
        shape: &[u64],
        values: &[T],
    ) {
        let file = File::create(self.path(name)).expect("a temporary file");
        let mut writer = npyz::WriteOptions::new()
            .default_dtype()
            .shape(shape)
            .writer(file)
            .begin_nd()
            .expect("a header");
        writer.extend(values.iter().copied()).expect("entries");
        writer.finish().expect("a whole file");
    }

    /// [`Folder::write_npy`] of a matrix whose values come by rows, in a file by columns.
    pub fn write_fortran_npy(&self, name: &str, shape: &[u64; 2], values: &[f64]) {
        let [m, n] = shape.map(|extent| extent as usize);
        let by_columns = (0..n).flat_map(|j| (0..m).map(move |i| values[i * n + j]));
        let file = File::create(self.path(name)).expect("a temporary file");
        let mut writer = npyz::WriteOptions::new()
            .default_dtype()
            .order(npyz::Order::Fortran)
            .shape(shape)
            .writer(file)
            .begin_nd()
            .expect("a header");
        writer.extend(by_columns).expect("entries");
        writer.finish().expect("a whole file");
    }

    pub fn read_npy<T: npyz::Deserialize>(&self, name: &str) -> Vec<T> {
        read_npy(&self.path(name))
    }
}

impl Run {
    pub fn new(output: Output) -> Self {
        Self {
            code: output.status.code(),
            stdout: String::from_utf8_lossy(&output.stdout).into(),
            stderr: String::from_utf8_lossy(&output.stderr).into(),
        }
    }
}

fn read_npy<T: npyz::Deserialize>(path: &Path) -> Vec<T> {
    let bytes = fs::read(path).expect("the output");
    npyz::NpyFile::new(&bytes[..]).expect("a header").into_vec().expect("entries")
}

/// Whole numbers, so that sums are exact whatever their order.
#[allow(dead_code)]
pub fn table(m: usize, n: usize) -> Vec<f64> {
    (0..m * n).map(|k| ((k * 7919 + 13) % 23) as f64 - 11.0).collect()
}

/// A^T W A of the m x n matrix A, by rows.
#[allow(dead_code)]
pub fn oracle(a: &[f64], n: usize, weights: Option<&[f64]>) -> Vec<f64> {
    let mut c = vec![0.0; n * n];
    for (i, row) in a.chunks(n).enumerate() {
        let weight = weights.map_or(1.0, |w| w[i]);
        for (j, x) in row.iter().enumerate() {
            for (k, y) in row.iter().enumerate() {
                c[j * n + k] += weight * x * y;
            }
        }
    }
    c
}

/// Rows of numbers as text.
#[allow(dead_code)]
pub fn csv(a: &[f64], n: usize) -> String {
    let row = |row: &[f64]| row.iter().map(f64::to_string).collect::<Vec<_>>().join(",") + "\n";
    a.chunks(n).map(row).collect()
}
