//! Reads that fail: at the beginning of a file, and in the middle.

use std::fs;
use std::os::unix::fs::symlink;
use std::path::{Path, PathBuf};
use std::process::Command;

use crate::commands::{LINES, READERS, folder_for, inputs, inputs_of, is_slow};
use crate::common::{Folder, Run};
use crate::scene::all_files;
use crate::{Tally, is_full};

/// It opens, and a read at its beginning fails with EIO: nothing is mapped at address 0.
const FAILING: &str = "/proc/self/mem";

/// Every line with each of its inputs.
fn read_files() -> impl Iterator<Item = (&'static str, String)> {
    let inputs_of = |line: &'static str| {
        let mut inputs: Vec<_> = inputs_of(line).into_iter().map(String::from).collect();
        let state = "w.safetensors.state.npz".to_owned();
        if folder_for(line).path(&state).exists() {
            inputs.push(state);
        }
        inputs.into_iter().map(move |name| (line, name))
    };
    LINES.iter().chain(READERS).flat_map(move |line| inputs_of(line))
}

#[test]
fn a_read_that_fails_is_an_error_that_names_the_file() {
    let mut tally = Tally::default();
    for (line, name) in read_files() {
        let folder = folder_for(line);
        fs::remove_file(folder.path(&name)).unwrap();
        symlink(FAILING, folder.path(&name)).unwrap();
        check(&folder, line, &name, folder.program());
        tally.add(line, true);
    }
    tally.record("failing read");
}

#[test]
fn a_read_that_fails_amid_a_file_is_an_error_that_names_the_file() {
    let built = Folder::new();
    let shim = shim(&built);
    let mut tally = Tally::default();
    for (line, name) in read_files() {
        let path = inputs().path(&name);
        let size = fs::metadata(&path).unwrap().len();
        if size < 2 || is_slow(line) && !is_full() {
            continue;
        }
        let folder = folder_for(line);
        let mut command = folder.program();
        command.env("LD_PRELOAD", &shim);
        command.env("CATAMARAN_EIO_FILE", &name).env("CATAMARAN_EIO_BYTES", (size / 2).to_string());
        check(&folder, line, &name, command);
        tally.add(line, true);
    }
    tally.record("read failing amid a file");
}

/// The program must fail, name the file, and leave nothing.
fn check(folder: &Folder, line: &str, name: &str, mut command: Command) {
    let before = all_files(&folder.path("."));
    let run = Run::new(command.args(line.split_whitespace()).output().unwrap());
    let said = &run.stderr;
    assert_eq!(run.code, Some(1), "{line}: {name}: {said}");
    assert_eq!(said.lines().count(), 1, "{line}: {name}: {said}");
    assert!(said.starts_with("catamaran: ") && said.contains(name), "{line}: {name}: {said}");
    let after = all_files(&folder.path("."));
    assert!(before.keys().eq(after.keys()), "{line}: {name}: {:?}", after.keys());
}

/// The library of `eio.c`.
fn shim(folder: &Folder) -> PathBuf {
    let source = Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/faults/eio.c");
    let library = folder.path("eio.so");
    let mut compiler = Command::new("cc");
    compiler.args(["-shared", "-fPIC", "-Wall", "-Werror", "-o"]).arg(&library).arg(source);
    assert!(compiler.arg("-ldl").status().expect("a C compiler").success());
    library
}
