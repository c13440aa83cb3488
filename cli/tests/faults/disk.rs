//! Full disks.

use std::fs;

use crate::commands::{LINES, VARYING, command_of, folder_for, inputs, is_one_of, is_slow};
use crate::common::Folder;
use crate::scene::{
    Files, Limit, Limited, all_files, attempt, check_files, complaints, files, run_limited, whole,
};
use crate::{Tally, is_full};

/// Bytes that still fit.
fn limits(line: &str) -> &'static [u64] {
    if is_full() && !is_slow(line) { &[0, 7, 100, 1000, 4000, 16_000, 64_000] } else { &[7, 1000] }
}

/// What is in a file that shall be replaced.
const BEFORE: &[u8] = b"before";

/// Lines that write files, and what they write; the slow ones in the full suite only.
fn writers() -> impl Iterator<Item = (&'static str, Files)> {
    let lines = LINES.iter().filter(|line| is_full() || !is_slow(line));
    lines.map(|&line| (line, whole(line))).filter(|(_, whole)| !whole.is_empty())
}

/// One line that names what could not be written; the status is that of an error.
fn check_failure(limited: &Limited, whole: &Files, context: &str) {
    let complaints = complaints(&limited.run);
    assert_eq!(limited.signal, None, "{context}");
    assert_eq!(limited.run.code, Some(1), "{context}: {}", limited.run.stderr);
    assert_eq!(complaints.len(), 1, "{context}: {}", limited.run.stderr);
    let said = complaints[0];
    let names = |name: &&String| said.contains(&***name) || said.contains(".npz.parts/");
    assert!(whole.keys().any(|name| names(&name)), "{context}: {said}");
    assert!(said.starts_with("catamaran: ") && said.contains("os error 27"), "{context}: {said}");
}

#[test]
fn a_full_disk_is_an_error_and_leaves_nothing_in_part() {
    let mut tally = Tally::default();
    for (line, whole) in writers() {
        let mut has_ever_failed = false;
        for &limit in limits(line) {
            let context = format!("{line}, files of {limit} bytes");
            let attempt = attempt(line, Limit::FileSize(limit), &mut tally, &context);
            if attempt.has_failed {
                has_ever_failed = true;
                check_failure(&attempt.limited, &whole, &context);
                if is_full() && !is_one_of(line, VARYING) {
                    goes_on(&attempt.folder, line, &attempt.inputs, &whole);
                }
            }
        }
        assert!(has_ever_failed, "{line}: wrote beyond the limit");
    }
    tally.record("full disk");
}

/// Once there is room again, the same line succeeds.
fn goes_on(folder: &Folder, line: &str, inputs: &Files, whole: &Files) {
    for name in files(folder, inputs).keys().filter(|name| whole.contains_key(*name)) {
        fs::remove_file(folder.path(name)).unwrap();
    }
    folder.succeed(line);
    assert!(files(folder, inputs) == *whole, "{line}");
}

#[test]
fn a_full_disk_leaves_what_would_be_replaced_as_it_was() {
    let mut tally = Tally::default();
    for (line, whole) in writers() {
        let help = inputs().succeed(&format!("{} --help", command_of(line)));
        if !help.contains("--force") || is_one_of(line, VARYING) {
            continue;
        }
        for &limit in limits(line) {
            let context = format!("{line} --force, files of {limit} bytes");
            let folder = folder_for(line);
            let inputs = all_files(&folder.path("."));
            for name in whole.keys() {
                let path = folder.path(name);
                fs::create_dir_all(path.parent().unwrap()).unwrap();
                fs::write(path, BEFORE).unwrap();
            }
            let limited = run_limited(&folder, &format!("{line} --force"), Limit::FileSize(limit));
            let found = files(&folder, &inputs);
            let has_failed = limited.run.code != Some(0);
            tally.add(line, has_failed);
            if has_failed {
                check_failure(&limited, &whole, &context);
            }
            check_files(line, &found, Some(BEFORE), &context);
            for name in whole.keys() {
                assert!(found.contains_key(name), "{context}: {name} is gone");
            }
        }
    }
    tally.record("full disk, --force");
}
