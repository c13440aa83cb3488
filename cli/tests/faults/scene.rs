//! What a command leaves, with and without a fault.

use std::collections::BTreeMap;
use std::fs;
use std::os::unix::process::{CommandExt as _, ExitStatusExt as _};
use std::path::Path;
use std::process::{Command, Output};
use std::sync::{Mutex, OnceLock};

use crate::Tally;
use crate::commands::{VARYING, folder_for, is_one_of};
use crate::common::{Folder, Run};

/// Relative names of files, and their bytes.
pub type Files = BTreeMap<String, Vec<u8>>;

/// All files below a folder, except inputs of the line.
pub fn files(folder: &Folder, inputs: &Files) -> Files {
    let mut found = all_files(&folder.path("."));
    // PoCL keeps compiled kernels where its user's caches are.
    found.retain(|name, _| !inputs.contains_key(name) && !name.starts_with("cache/pocl/"));
    found
}

/// All files below a folder; none where there is no folder.
pub fn all_files(folder: &Path) -> Files {
    let mut found = Files::new();
    let Ok(entries) = fs::read_dir(folder) else { return found };
    for entry in entries.map(Result::unwrap) {
        let name = entry.file_name().to_string_lossy().into_owned();
        if entry.path().is_dir() {
            let inner = all_files(&entry.path());
            found
                .extend(inner.into_iter().map(|(inner, bytes)| (format!("{name}/{inner}"), bytes)));
        } else {
            // What can't be read, such as the memory of a process, is no output.
            found.insert(name, fs::read(entry.path()).unwrap_or_default());
        }
    }
    found
}

/// Whether the file is one that appears only while a command is at work.
pub fn is_temporary(name: &str) -> bool {
    let last = name.rsplit('/').next().unwrap();
    last.starts_with(".catamaran-") || last.ends_with(".tmp")
}

/// What a command leaves when nothing goes wrong; each line is run once.
pub fn whole(line: &str) -> Files {
    static KNOWN: OnceLock<Mutex<BTreeMap<String, Files>>> = OnceLock::new();
    let known = KNOWN.get_or_init(Mutex::default);
    if let Some(files) = known.lock().unwrap().get(line) {
        return files.clone();
    }
    let folder = folder_for(line);
    let inputs = all_files(&folder.path("."));
    folder.succeed(line);
    let found = files(&folder, &inputs);
    known.lock().unwrap().insert(line.into(), found.clone());
    found
}

/// A resource of the process, and how much of it there is.
#[derive(Debug, Clone, Copy)]
pub enum Limit {
    /// Bytes of a file: a write beyond fails, as on a full disk.
    FileSize(u64),
    /// Bytes of address space.
    Memory(u64),
}

/// A run with a limit.
pub struct Limited {
    pub run: Run,
    pub signal: Option<i32>,
}

/// Runs a line with a limit.
pub fn run_limited(folder: &Folder, line: &str, limit: Limit) -> Limited {
    let mut command = folder.program();
    command.args(line.split_whitespace());
    // Only the lines that a user sees who did not ask for more.
    command.env_remove("RUST_BACKTRACE");
    // A thread of a linked OpenBLAS (0.3.21) that gets no memory asks for ever, also at exit.
    command.env("OPENBLAS_NUM_THREADS", "1");
    limit_to(&mut command, limit);
    let output: Output = command.output().expect("the program starts");
    let signal = output.status.signal();
    Limited { run: Run::new(output), signal }
}

/// A line run with a limit in a folder of its own, and the files around that run.
pub struct Attempt {
    pub limited: Limited,
    pub folder: Folder,
    pub inputs: Files,
    pub has_failed: bool,
}

/// Runs a line with a limit and counts the outcome. What it leaves is whole, and all of it where
/// the line succeeds.
pub fn attempt(line: &str, limit: Limit, tally: &mut Tally, context: &str) -> Attempt {
    let folder = folder_for(line);
    let inputs = all_files(&folder.path("."));
    let limited = run_limited(&folder, line, limit);
    let found = files(&folder, &inputs);
    check_files(line, &found, None, context);
    let has_failed = limited.run.code != Some(0);
    tally.add(line, has_failed);
    assert!(has_failed || is_one_of(line, VARYING) || found == whole(line), "{context}");
    Attempt { limited, folder, inputs, has_failed }
}

fn limit_to(command: &mut Command, limit: Limit) {
    let (resource, bytes) = match limit {
        Limit::FileSize(bytes) => (libc::RLIMIT_FSIZE, bytes),
        Limit::Memory(bytes) => (libc::RLIMIT_AS, bytes),
    };
    let limit = libc::rlimit { rlim_cur: bytes, rlim_max: bytes };
    // SAFETY: a system call that allocates nothing, on a value that the closure owns.
    unsafe {
        command.pre_exec(move || match libc::setrlimit(resource, &limit) {
            0 => Ok(()),
            _ => Err(std::io::Error::last_os_error()),
        });
    }
}

/// The lines on stderr that are errors, without notes and what `tune` says there that it does.
pub fn complaints(run: &Run) -> Vec<&str> {
    let is_other = |line: &str| line.starts_with("measuring ") || line.starts_with("note: ");
    run.stderr.lines().filter(|line| !is_other(line)).collect()
}

/// Checks that every output is whole or as before, and that no temporary file is there.
pub fn check_files(line: &str, found: &Files, before: Option<&[u8]>, context: &str) {
    let whole = if is_one_of(line, VARYING) { Files::new() } else { whole(line) };
    for (name, bytes) in found {
        assert!(!is_temporary(name), "{context}: {name} is left");
        if is_one_of(line, VARYING) || is_kept(line, name) {
            continue;
        }
        let expected = whole.get(name);
        assert!(expected.is_some(), "{context}: {name} is no output");
        let kept = before.is_some_and(|before| before == bytes);
        assert!(kept || expected == Some(bytes), "{context}: {name} is not whole");
    }
}

/// What a command that failed leaves to go on from.
fn is_kept(line: &str, name: &str) -> bool {
    line.starts_with("unions dataset") && name.contains(".npz.parts/")
}
