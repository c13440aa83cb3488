//! A folder, a program, and an oracle.

use std::fs;
use std::path::PathBuf;
use std::process::{Command, Output};

use catamaran::io::read_arrays;
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

/// The calls of the program in the shell blocks of a document, at least one: lines that begin with
/// its name, without the name and without comments.
#[allow(dead_code)]
pub fn calls(document: &str) -> Vec<&str> {
    let blocks = document.split("```").skip(1).step_by(2);
    // Blocks of another language have its name: `catamaran = ...` may stand in a TOML file.
    let shell = blocks.filter_map(|block| block.strip_prefix("sh\n").or(block.strip_prefix('\n')));
    let lines = shell.flat_map(str::lines).filter_map(|line| line.strip_prefix("catamaran "));
    let calls: Vec<&str> = lines.map(|line| line.split(" #").next().unwrap_or(line)).collect();
    assert!(!calls.is_empty(), "no call in {document}");
    calls
}

/// The commands that a help text lists: in sections, or below `Commands:`.
#[allow(dead_code)]
pub fn subcommands(help: &str) -> Vec<String> {
    let (_, rest) = help.split_once("Usage: ").expect("a help text");
    let lines = rest.lines().take_while(|line| !line.trim_start().starts_with('-'));
    // Lines that go on with a sentence are indented further, and arguments begin with a bracket.
    let names = lines.filter_map(|line| line.strip_prefix("  ")?.split(' ').next());
    let names = names.filter(|name| name.starts_with(|c: char| c.is_ascii_lowercase()));
    names.map(str::to_owned).collect()
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

    /// [`Folder::run`], which must fail with one line on stderr besides notes, leaving the folder
    /// as it was.
    pub fn fail(&self, arguments: &str) -> String {
        let before = self.names();
        let run = self.run(arguments);
        assert_eq!(run.code, Some(1), "{arguments}: {}{}", run.stdout, run.stderr);
        let lines = run.stderr.lines().filter(|line| !line.starts_with("note: "));
        assert_eq!(lines.count(), 1, "{}", run.stderr);
        assert_eq!(self.names(), before, "{arguments}");
        run.stderr
    }

    pub fn write_npy<T: Entry>(&self, name: &str, shape: &[u64], values: &[T]) {
        self.write(name, npy("False", shape, values));
    }

    /// [`Folder::write_npy`] of a matrix whose values come by rows, in a file by columns.
    pub fn write_fortran_npy(&self, name: &str, shape: &[u64; 2], values: &[f64]) {
        let [m, n] = shape.map(|extent| extent as usize);
        let by_columns = (0..n).flat_map(|j| (0..m).map(move |i| values[i * n + j]));
        self.write(name, npy("True", shape, &by_columns.collect::<Vec<_>>()));
    }

    /// The entries of an array of several dimensions by rows, which has this shape and entries of
    /// type T in the file.
    pub fn read_npy<T: Entry>(&self, name: &str, shape: &[usize]) -> Vec<T> {
        let bytes = fs::read(self.path(name)).expect("the output");
        let (header, entries) = bytes.split_at(HEADER);
        let extents: Vec<String> = shape.iter().map(usize::to_string).collect();
        let dict = format!(
            "{{'descr': '{}', 'fortran_order': False, 'shape': ({}), }}",
            T::DESCR,
            extents.join(", ")
        );
        assert!(
            header[10..].starts_with(dict.as_bytes()),
            "{name}: {} instead of {dict}",
            header.escape_ascii()
        );
        let len = shape.iter().product::<usize>();
        assert_eq!(entries.len(), len * size_of::<T>(), "{name}");
        entries.chunks(size_of::<T>()).map(T::from_bytes).collect()
    }

    /// The shape of an array of an .npz file, and its entries by rows.
    pub fn read_npz(&self, file: &str, name: &str) -> (Vec<usize>, Vec<f64>) {
        let arrays = read_arrays(&self.path(file)).expect("the output");
        if let Ok(values) = arrays.vector(name) {
            return (vec![values.len()], values);
        }
        let matrix = arrays.matrix(name).expect("an array of numbers");
        let (matrix, (m, n)) = (matrix.as_ref(), matrix.shape());
        let entries = (0..m).flat_map(|i| (0..n).map(move |j| matrix[(i, j)])).collect();
        (vec![m, n], entries)
    }
}

/// A type of entries of arrays.
pub trait Entry: Copy {
    /// The type string of numpy.
    const DESCR: &'static str;
    fn to_bytes(self) -> Vec<u8>;
    fn from_bytes(bytes: &[u8]) -> Self;
}

macro_rules! entries {
    ($($type:ident $descr:literal),*) => {$(
        impl Entry for $type {
            const DESCR: &'static str = $descr;

            fn to_bytes(self) -> Vec<u8> {
                self.to_le_bytes().into()
            }

            fn from_bytes(bytes: &[u8]) -> Self {
                Self::from_le_bytes(bytes.try_into().expect("a whole entry"))
            }
        }
    )*};
}

entries!(f32 "<f4", f64 "<f8", i64 "<i8");

/// Bytes before the entries of an array.
const HEADER: usize = 128;

fn npy<T: Entry>(fortran_order: &str, shape: &[u64], values: &[T]) -> Vec<u8> {
    let shape: String = shape.iter().map(|extent| format!("{extent}, ")).collect();
    let dict = format!(
        "{{'descr': '{}', 'fortran_order': {fortran_order}, 'shape': ({shape}), }}",
        T::DESCR
    );
    let mut bytes = b"\x93NUMPY\x01\x00\x76\x00".to_vec();
    bytes.extend(format!("{dict:117}\n").bytes());
    bytes.extend(values.iter().flat_map(|value| value.to_bytes()));
    bytes
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
