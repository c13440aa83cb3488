//! Random shapes, strides and options (proptest).

use catamaran::faer::{Mat, MatRef};
use catamaran::{Accuracy, AtaOptions, SchemeChoice, Uplo, ata_into, atb_into};
use proptest::prelude::*;

use crate::common::{backends, integers, oracle};

/// A view of `m x n` entries with these spacings inside a larger matrix, possibly reversed.
fn view(
    memory: &Mat<f64>,
    m: usize,
    n: usize,
    (row_step, col_step): (usize, usize),
    (flip_rows, flip_cols, transpose): (bool, bool, bool),
) -> MatRef<'_, f64> {
    let (rows, cols) = if transpose { (n, m) } else { (m, n) };
    // SAFETY: the memory has at least `rows * row_step` rows and `cols * col_step` columns.
    let mut v = unsafe {
        MatRef::from_raw_parts(
            memory.as_ptr(),
            rows,
            cols,
            memory.row_stride() * row_step as isize,
            memory.col_stride() * col_step as isize,
        )
    };
    if flip_rows {
        v = v.reverse_rows();
    }
    if flip_cols {
        v = v.reverse_cols();
    }
    if transpose { v.transpose() } else { v }
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 150, failure_persistence: None, ..Default::default() })]

    #[test]
    fn ata_is_exact_for_any_shape_stride_and_option(
        m in 0_usize..70,
        n in 0_usize..70,
        steps in (1_usize..3, 1_usize..3),
        flips: (bool, bool, bool),
        scheme in 0..SchemeChoice::NAMES.len(),
        leaf in 1_usize..40,
        tasks in 1_usize..20,
        threads in 1_usize..4,
        uplo in 0_usize..3,
        alpha in -3..3,
        beta in -2..2,
        backend in 0..backends().len(),
        seed: u64,
    ) {
        let memory = integers::<f64>(140, 140, seed);
        let a = view(&memory, m, n, steps, flips);
        let start = integers::<f64>(n, n, seed ^ 1);
        let start = Mat::from_fn(n, n, |i, j| start[(i.max(j), i.min(j))]);
        let (alpha, beta) = (f64::from(alpha), f64::from(beta));
        let uplo = [Uplo::Lower, Uplo::Upper, Uplo::Both][uplo];
        let options = AtaOptions::new().uplo(uplo).threads(threads).scheme(SchemeChoice::NAMES[scheme].1).accuracy(Accuracy::Fast).backend(backends()[backend].clone()).leaf(leaf).tasks(tasks);
        let mut c = start.clone();
        ata_into(alpha, a, beta, c.as_mut(), &options).unwrap();
        let full = oracle(alpha, a, None, a, beta, start.as_ref());
        let expected = Mat::from_fn(n, n, |i, j| {
            let wanted = match uplo {
                Uplo::Lower => i >= j,
                Uplo::Upper => i <= j,
                Uplo::Both => true,
            };
            if wanted { full[(i, j)] } else { start[(i, j)] }
        });
        prop_assert_eq!(c, expected);
    }

    #[test]
    fn atb_is_exact_for_any_shape_stride_and_option(
        (m, n, k) in (0_usize..60, 0_usize..60, 0_usize..60),
        steps in (1_usize..3, 1_usize..3),
        flips: (bool, bool, bool),
        scheme in 0..SchemeChoice::NAMES.len(),
        leaf in 1_usize..30,
        tasks in 1_usize..20,
        backend in 0..backends().len(),
        seed: u64,
    ) {
        let (left, right) = (integers::<f64>(120, 120, seed), integers::<f64>(120, 120, !seed));
        let a = view(&left, m, n, steps, flips);
        let b = view(&right, m, k, steps, (flips.1, flips.2, flips.0));
        let options = AtaOptions::new().threads(2).scheme(SchemeChoice::NAMES[scheme].1).accuracy(Accuracy::Fast).backend(backends()[backend].clone()).leaf(leaf).tasks(tasks);
        let mut c = Mat::from_fn(n, k, |_, _| f64::NAN);
        atb_into(1.0, a, b, 0.0, c.as_mut(), &options).unwrap();
        prop_assert_eq!(c, oracle(1.0, a, None, b, 0.0, Mat::zeros(n, k).as_ref()));
    }
}
