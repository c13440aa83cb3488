//! Too little memory.

use std::sync::OnceLock;

use crate::commands::{LINES, SLOW, VARYING, command_of, folder_for, inputs, is_one_of};
use crate::scene::{Limit, all_files, check_files, files, run_limited, whole};
use crate::{is_full, record};

/// Limits for each line.
fn steps() -> usize {
    if is_full() { 12 } else { 2 }
}

/// The precision of a bisection, in bytes.
const STEP: u64 = 1 << 20;

/// Enough for any of the lines: 8 GiB.
const ENOUGH: u64 = 8 << 30;

/// The least memory with which `succeeds`, from what fails to what succeeds.
fn least(mut fails: u64, mut enough: u64, mut succeeds: impl FnMut(u64) -> bool) -> u64 {
    while enough - fails > STEP {
        // Sizes are guessed by their logarithms.
        let middle = ((fails as f64 * enough as f64).sqrt() as u64).clamp(fails + 1, enough - 1);
        if succeeds(middle) { enough = middle } else { fails = middle }
    }
    enough
}

/// What the program needs to say its version.
fn base() -> u64 {
    static BASE: OnceLock<u64> = OnceLock::new();
    *BASE.get_or_init(|| {
        least(STEP, ENOUGH, |bytes| {
            let folder = crate::common::Folder::new();
            run_limited(&folder, "--version", Limit::Memory(bytes)).run.code == Some(0)
        })
    })
}

/// Whether a message is about what ran out.
fn is_about_memory(said: &str) -> bool {
    let words = ["memory", "threads", "os error 11", "os error 12"];
    words.iter().any(|word| said.contains(word))
}

#[test]
fn too_little_memory_is_an_error_and_leaves_nothing_in_part() {
    inputs();
    for line in LINES.iter().filter(|line| is_full() || !is_one_of(line, SLOW)) {
        let whole = whole(line);
        let fails = |bytes| {
            let context = format!("{line}, {} KiB of memory", bytes >> 10);
            let folder = folder_for(line);
            let inputs = all_files(&folder.path("."));
            let limited = run_limited(&folder, line, Limit::Memory(bytes));
            let found = files(&folder, &inputs);
            check_files(line, &found, None, &context);
            if limited.run.code == Some(0) {
                assert!(is_one_of(line, VARYING) || found == whole, "{context}");
                return false;
            }
            let stderr = &limited.run.stderr;
            assert_eq!(limited.signal, None, "{context}: {stderr}");
            assert_eq!(limited.run.code, Some(1), "{context}: {stderr}");
            // The standard library has its own lines, in pieces when several threads abort.
            let ours: Vec<&str> = stderr.split("catamaran: ").skip(1).collect();
            assert_eq!(ours.len(), 1, "{context}: {stderr}");
            assert!(is_about_memory(ours[0]), "{context}: {stderr}");
            true
        };
        let (mut failed, mut tried) = (0, 0);
        let need = if is_full() {
            least(base(), ENOUGH, |bytes| {
                tried += 1;
                let has_failed = fails(bytes);
                failed += usize::from(has_failed);
                !has_failed
            })
        } else {
            4 * base()
        };
        let ratio = need as f64 / base() as f64;
        for i in 0..steps() {
            let share = (i as f64 + 0.5) / steps() as f64;
            tried += 1;
            failed += usize::from(fails((base() as f64 * ratio.powf(share)) as u64));
        }
        let need = if is_full() { format!(", needs {} MiB", need >> 20) } else { String::new() };
        let outcomes = format!("{failed} errors, {} results{need}", tried - failed);
        record("little memory", &command_of(line), tried, &outcomes);
    }
}
