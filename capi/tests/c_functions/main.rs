//! Random calls of the functions of C, valid ones and others, against plain loops: a short run of
//! what `scripts/fuzz 600 c_functions` does for minutes.

mod calls;

use std::time::{Duration, Instant};

use catamaran::base::Rng;

/// Calls of one kind.
const CALLS: usize = 300;

/// Makes calls of these kinds, whose other choices come from a seed.
fn run(kinds: std::ops::Range<u8>, seed: u64) {
    for kind in kinds {
        let mut rng = Rng::new(256 * seed + u64::from(kind));
        for _ in 0..CALLS {
            let mut bytes: Vec<u8> = (0..12).flat_map(|_| rng.bits().to_le_bytes()).collect();
            bytes[0] = kind;
            let call = std::panic::catch_unwind(|| calls::call(&bytes));
            assert!(call.is_ok(), "for the bytes {bytes:?}");
        }
    }
}

#[test]
fn dense_products_are_those_of_plain_loops() {
    run(0..5, 0);
}

#[test]
fn complex_products_are_those_of_plain_loops() {
    run(5..7, 0);
}

#[test]
fn products_of_rows_are_those_of_plain_loops() {
    run(7..11, 0);
}

#[test]
fn accumulators_have_the_sums_of_plain_loops() {
    run(11..12, 0);
}

#[test]
fn results_of_gram_matrices_satisfy_their_equations() {
    run(12..13, 0);
}

#[test]
fn orthonormal_columns_are_factors() {
    run(13..14, 0);
}

#[test]
fn eigenvalues_are_those_of_rotations_and_solutions_satisfy_their_equations() {
    run(14..15, 0);
}

#[test]
fn parameters_are_refused_by_name() {
    run(15..16, 0);
}

/// What `scripts/fuzz 600 c_functions` does, without libFuzzer and AddressSanitizer.
#[test]
#[ignore = "long: scripts/test --long"]
fn ten_minutes_of_calls_are_those_of_plain_loops() {
    let start = Instant::now();
    let mut seed = 0;
    while start.elapsed() < Duration::from_secs(600) {
        seed += 1;
        run(0..16, seed);
    }
    eprintln!("{} calls", seed as usize * 16 * CALLS);
}
