//! Too little memory.

use std::fs;
use std::os::unix::fs::symlink;
use std::sync::OnceLock;

use crate::commands::{LINES, inputs, is_slow};
use crate::common::Folder;
use crate::scene::{Limit, Limited, attempt, run_limited};
use crate::{Tally, is_full};

/// Limits for a line.
fn steps(line: &str) -> usize {
    match is_full() {
        true if is_slow(line) => 4,
        true => 12,
        false => 2,
    }
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
            let folder = Folder::new();
            run_limited(&folder, "--version", Limit::Memory(bytes)).run.code == Some(0)
        })
    })
}

/// Whether a message is about what ran out.
fn is_about_memory(said: &str) -> bool {
    let words = ["memory", "threads", "os error 11", "os error 12"];
    words.iter().any(|word| said.contains(word))
}

/// Checks that a run with too little memory ended in order.
fn check_failure(limited: &Limited, context: &str) {
    let stderr = &limited.run.stderr;
    assert_eq!(limited.signal, None, "{context}: {stderr}");
    assert_eq!(limited.run.code, Some(1), "{context}: {stderr}");
    // The standard library has its own lines, in pieces when several threads abort.
    let ours: Vec<&str> = stderr.split("catamaran: ").skip(1).collect();
    assert_eq!(ours.len(), 1, "{context}: {stderr}");
    assert!(is_about_memory(ours[0]), "{context}: {stderr}");
}

#[test]
fn too_little_memory_is_an_error_and_leaves_nothing_in_part() {
    let mut tally = Tally::default();
    for line in LINES.iter().filter(|line| is_full() || !is_slow(line)) {
        let mut succeeds = |bytes| {
            let context = format!("{line}, {} KiB of memory", bytes >> 10);
            let attempt = attempt(line, Limit::Memory(bytes), &mut tally, &context);
            if attempt.has_failed {
                check_failure(&attempt.limited, &context);
            }
            !attempt.has_failed
        };
        let need = if is_full() && !is_slow(line) {
            least(base(), ENOUGH, &mut succeeds)
        } else {
            4 * base()
        };
        let ratio = need as f64 / base() as f64;
        for i in 0..steps(line) {
            let share = (i as f64 + 0.5) / steps(line) as f64;
            succeeds((base() as f64 * ratio.powf(share)) as u64);
        }
    }
    tally.record("little memory");
}

#[test]
fn too_little_memory_leaves_the_checkpoint() {
    // It would fail with enough memory, too, at its last row.
    let line =
        "ata broken.npy --require-finite -o c.npy --block-rows 100 --checkpoint a.part --resume";
    let mut tally = Tally::default();
    for i in 0..8 {
        let folder = Folder::new();
        symlink(inputs().path("broken.npy"), folder.path("broken.npy")).unwrap();
        fs::copy(inputs().path("a.part"), folder.path("a.part")).unwrap();
        let bytes = base() + i * STEP;
        let limited = run_limited(&folder, line, Limit::Memory(bytes));
        let has_failed = !limited.run.stderr.contains("broken.npy: inf at row");
        tally.add(line, has_failed);
        if has_failed {
            check_failure(&limited, &format!("{line}, {} KiB of memory", bytes >> 10));
        }
        assert_eq!(folder.names(), ["a.part", "broken.npy"], "{}", limited.run.stderr);
        let kept = |folder: &Folder| fs::read(folder.path("a.part")).unwrap();
        assert!(kept(&folder) == kept(inputs()));
    }
    let [others, failed] = tally.0["ata"];
    assert!(failed > 0 && others > 0, "{failed} failed, {others} came to the last row");
    tally.record("little memory, with a checkpoint");
}
