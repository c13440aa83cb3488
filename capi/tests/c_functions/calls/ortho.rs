//! Orthonormal columns.

use std::ptr;

use catamaran_capi::*;

use super::buffers::Matrix;
use super::choices::Choices;
use super::entries::Entries;
use super::oracle::{dot, norm};
use super::params::{Params, field};
use super::refusal::{Fault, check_accepted, check_refused};

/// Makes a call of one of the functions.
pub fn call(choices: &mut Choices<'_>) {
    let layout = choices.pick(&[CATA_ROW_MAJOR, CATA_COL_MAJOR]);
    let (n, c) = (choices.side(), choices.below(30));
    let cholesky = choices.one_in(3);
    let mut entries = Entries::finite(choices);
    let mut a = Matrix::<f64>::new(choices, layout, (n, c), 1, |i, j| entries.next(i, j));
    let mut numbers = choices.rng();
    let weighted = choices.one_in(2);
    let masses: Vec<f64> = (0..n).map(|_| numbers.uniform() + 0.1).collect();
    let rows = if cholesky { c } else { n.min(c) };
    let mut r = Matrix::<f64>::new(choices, layout, (rows, c), 1, |_, _| f64::NAN);
    let mut kept = Matrix::<usize>::output(choices, c);
    let mut refused = None;
    let thresholds = [0.0, 0.0, 1e-8];
    let value = cata_ortho_params {
        struct_size: 0,
        threads: choices.pick(&[1, 0, 3]),
        progress: None,
        progress_user: ptr::null_mut(),
        threshold: match cholesky {
            true => 0.0,
            false => {
                field(choices, "threshold: ", &thresholds, &[2.0, -1.0, f64::NAN], &mut refused)
            }
        },
        method: field(choices, "params.method: ", &[0, 1, 3], &[4, -1], &mut refused),
    };
    let params = Params::new(choices, value, refused);
    let fault = Fault::pick(choices, &[Fault::Layout, Fault::LdA]);
    let what = format!("ortho {n} x {c}, {cholesky}, {weighted}, {value:?}, {fault:?}");
    let mut rank = usize::MAX;
    // SAFETY: the memory of the matrices, or arguments that must be refused.
    let status = unsafe {
        let wrong = if fault == Fault::Layout { 0 } else { layout };
        let lda = if fault == Fault::LdA { 0 } else { a.ld };
        let (pa, pr, pk) = (a.pointer_mut(), r.pointer_mut(), kept.pointer_mut());
        let pm = if weighted { masses.as_ptr() } else { ptr::null() };
        if cholesky {
            cata_ortho_cholesky_qr(wrong, n, c, pa, lda, pm, pr, r.ld, params.pointer())
        } else {
            let params = params.pointer();
            cata_ortho_gram_schmidt(wrong, n, c, pa, lda, pm, pr, r.ld, pk, &mut rank, params)
        }
    };
    let mut names = params.refused.clone();
    names.extend(fault.names());
    if !names.is_empty() {
        a.check_untouched(&what);
        untouched(&what, &r, &kept, rank);
        return check_refused(&what, status, &names);
    }
    a.check_changes(&what, |_, _| true);
    if cholesky && status == CATA_ERR_ARGUMENT {
        // Columns that depend on others, as those of few rows or of one number do.
        return untouched(&what, &r, &kept, rank);
    }
    check_accepted(&what, status);
    let masses = if weighted { masses } else { vec![1.0; n] };
    let rank = if cholesky { c } else { rank };
    r.check_changes(&what, |_, _| true);
    kept.check_changes(&what, |_, j| !cholesky && j < rank);
    check(&what, &a, &r, rank, &masses);
}

fn untouched(what: &str, r: &Matrix<f64>, kept: &Matrix<usize>, rank: usize) {
    r.check_untouched(what);
    kept.check_untouched(what);
    assert_eq!(rank, usize::MAX, "{what}");
}

/// Q^T M Q = I, and Q R = A but for what was dropped.
fn check(what: &str, a: &Matrix<f64>, r: &Matrix<f64>, rank: usize, masses: &[f64]) {
    let (n, c) = (a.rows, a.cols);
    for i in 0..rank {
        for j in 0..=i {
            let product = dot((0..n).map(|k| (a.get(k, i) * masses[k], a.get(k, j))));
            let error = (product - f64::from(i == j)).abs();
            // One projection orthogonalizes columns of a condition number of 100 this well.
            assert!(error <= 1e-9, "{what}: ({i}, {j}) of Q^T M Q is off by {error}");
        }
    }
    for j in 0..c {
        let size = norm((0..n).map(|k| a.old(k, j, 0)));
        for k in 0..n {
            let product = dot((0..rank).map(|i| (a.get(k, i), r.get(i, j))));
            let error = (product - a.old(k, j, 0)).abs();
            assert!(error <= 0.1 * size, "{what}: ({k}, {j}) of Q R is off by {error}");
        }
    }
}
