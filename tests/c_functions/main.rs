//! Random calls of the functions of C, valid ones and others, against plain loops: a short run of
//! what `scripts/fuzz 600 c_functions` does for minutes.

mod calls;

use catamaran::base::Rng;

/// Calls of one kind.
const CALLS: usize = 300;

/// Makes calls of these kinds, whose other choices come from a seed.
fn run(kinds: std::ops::Range<u8>) {
    for kind in kinds {
        let mut rng = Rng::new(kind.into());
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
    run(0..5);
}

#[test]
fn complex_products_are_those_of_plain_loops() {
    run(5..7);
}

#[test]
fn products_of_rows_are_those_of_plain_loops() {
    run(7..11);
}

#[test]
fn accumulators_have_the_sums_of_plain_loops() {
    run(11..12);
}

#[test]
fn results_of_gram_matrices_satisfy_their_equations() {
    run(12..13);
}

#[test]
fn orthonormal_columns_are_factors() {
    run(13..14);
}

#[test]
fn eigenvalues_are_those_of_rotations() {
    run(14..15);
}

#[test]
fn parameters_are_refused_by_name() {
    run(15..16);
}
