//! Products of weighted and centred rows, and of sparse ones.

use std::ptr;

use catamaran_capi::*;

use super::buffers::Matrix;
use super::choices::Choices;
use super::entries::{Entries, Real, factor};
use super::oracle::{Expected, dot};
use super::params::{Nearness, field, of_product};
use super::refusal::{check_accepted, check_refused};

/// Checks the wanted entries of C against X^T W X of finite rows. Bounds are relative to the sizes
/// of the columns, the largest entries of A and of what is subtracted, and to all weights: sums of
/// integers round to a grid of the largest entry, and cancel what lies in a mean.
fn check<T: Real>(
    what: &str,
    uplo: i32,
    (alpha, beta): (T, T),
    (x, weights, sizes): (&[Vec<f64>], &[f64], &[f64]),
    c: &Matrix<T>,
    nearness: Nearness,
) {
    let wanted = |i: usize, j: usize| match uplo {
        CATA_UPPER => i <= j,
        CATA_LOWER => i >= j,
        _ => true,
    };
    c.check_changes(what, wanted);
    let len = x.len();
    let unit = (len + 4) as f64 * T::UNIT;
    let total: f64 = weights.iter().map(|w| w.abs()).sum();
    let largest = sizes.iter().fold(0.0_f64, |most, &x| most.max(x));
    for i in 0..c.rows {
        for j in 0..c.cols {
            if !wanted(i, j) {
                continue;
            }
            let old = if uplo == CATA_BOTH && i < j { c.old(j, i, 0) } else { c.old(i, j, 0) };
            let expected = Expected {
                alpha: alpha.wide(),
                sum: dot(x.iter().zip(weights).map(|(row, w)| (row[i], row[j] * w))),
                beta: beta.wide(),
                old: old.wide(),
                bound: match nearness {
                    Nearness::Largest => {
                        256.0 * unit * (len + 1) as f64 * total * largest * largest
                    }
                    _ => 8.0 * unit * total * sizes[i] * sizes[j],
                },
                as_loops: true,
                spread: false,
                unit: if nearness == Nearness::Loops { T::UNIT } else { 64.0 * T::UNIT },
                tiny: 4.0 * (len + 1) as f64 * T::SMALLEST,
            };
            let got = c.get(i, j);
            assert!(expected.allows(got.wide()), "{what}: ({i}, {j}) is {got:?}: {expected:?}");
        }
    }
}

/// Chooses the entries of A, which is not read with an alpha of 0.
fn of_a<T: Real>(alpha: T, choices: &mut Choices<'_>) -> Entries {
    if alpha.wide() == 0.0 { Entries::any(choices) } else { Entries::finite(choices) }
}

/// Makes a call with dense rows.
pub fn dense<T: Real>(choices: &mut Choices<'_>) {
    let layout = choices.pick(&[CATA_ROW_MAJOR, CATA_COL_MAJOR]);
    let uplo = choices.pick(&[CATA_BOTH, CATA_LOWER, CATA_UPPER]);
    let (m, n) = (choices.side(), choices.side());
    let (alpha, beta): (T, T) = (factor(choices), factor(choices));
    let mut entries = of_a(alpha, choices);
    let a = Matrix::<T>::new(choices, layout, (m, n), 1, |i, j| entries.next(i, j));
    let mut old = Entries::finite(choices);
    let mut c = Matrix::<T>::new(choices, layout, (n, n), 1, |i, j| old.next(i, j));
    let mut refused = None;
    let centerings = [CATA_CENTER_NONE, CATA_CENTER_MEAN, CATA_CENTER_GIVEN];
    let centering = field(choices, "centering: ", &centerings, &[-1, 3], &mut refused);
    let weighted = choices.one_in(2);
    let mut numbers = choices.rng();
    // Of one sign about a mean, whose sum of weights is then far from 0.
    let mut weight = || match centering {
        CATA_CENTER_MEAN => numbers.uniform() + 0.1,
        _ => numbers.normal(),
    };
    let weights = Matrix::<T>::new(choices, CATA_ROW_MAJOR, (1, m), 1, |_, _| T::of(weight()));
    let center =
        Matrix::<T>::new(choices, CATA_ROW_MAJOR, (1, n), 1, |_, _| T::of(numbers.normal()));
    let (params, nearness) = of_product(choices);
    let what = format!("rows {m} x {n}, {centering}, {weighted}, {:?}", params.value);
    // SAFETY: the matrices own their memory, which has the sides and leading dimensions passed.
    let status = unsafe {
        let pw = if weighted { weights.pointer() } else { ptr::null() };
        let (pa, pc, center, params) =
            (a.pointer(), c.pointer_mut(), center.pointer(), params.pointer());
        T::ROWS(layout, uplo, m, n, alpha, pa, a.ld, pw, centering, center, beta, pc, c.ld, params)
    };
    a.check_untouched(&what);
    weights.check_untouched(&what);
    let names: Vec<_> = params.refused.iter().copied().chain(refused).collect();
    if !names.is_empty() {
        c.check_untouched(&what);
        return check_refused(&what, status, &names);
    }
    if centering == CATA_CENTER_MEAN && m == 0 {
        // There is no mean; nothing is said about it.
        return;
    }
    check_accepted(&what, status);
    let weights: Vec<f64> =
        (0..m).map(|i| if weighted { weights.get(0, i).wide() } else { 1.0 }).collect();
    let total: f64 = weights.iter().sum();
    let middle = |j: usize| match centering {
        CATA_CENTER_MEAN => dot((0..m).map(|i| (a.get(i, j).wide(), weights[i]))) / total,
        CATA_CENTER_GIVEN => center.get(0, j).wide(),
        _ => 0.0,
    };
    let middles: Vec<f64> = (0..n).map(middle).collect();
    let x: Vec<Vec<f64>> =
        (0..m).map(|i| (0..n).map(|j| a.get(i, j).wide() - middles[j]).collect()).collect();
    let most = |j: usize| (0..m).fold(0.0_f64, |most, i| most.max(a.get(i, j).wide().abs()));
    let sizes: Vec<f64> = (0..n).map(|j| most(j) + middles[j].abs()).collect();
    check(&what, uplo, (alpha, beta), (&x, &weights, &sizes), &c, nearness);
}

/// Makes a call with sparse rows.
pub fn sparse<T: Real>(choices: &mut Choices<'_>) {
    let layout = choices.pick(&[CATA_ROW_MAJOR, CATA_COL_MAJOR]);
    let uplo = choices.pick(&[CATA_BOTH, CATA_LOWER, CATA_UPPER]);
    let (m, n) = (choices.side(), choices.side());
    let (alpha, beta): (T, T) = (factor(choices), factor(choices));
    let density = choices.pick(&[0.1, 0.5, 0.0, 1.0]);
    let mut entries = of_a(alpha, choices);
    let mut numbers = choices.rng();
    let mut x = vec![vec![0.0; n]; m];
    let (mut starts, mut columns, mut values) = (vec![0_usize], Vec::new(), Vec::<T>::new());
    for i in 0..m {
        for j in (0..n).filter(|_| numbers.uniform() < density) {
            let value: T = entries.next(i, j);
            x[i][j] = value.wide();
            columns.push(j);
            values.push(value);
        }
        starts.push(columns.len());
    }
    let mut refused = None;
    let count = columns.len();
    match choices.below(32) {
        31 if m > 0 => (starts[0], refused) = (1, Some("row_starts")),
        30 if count > 0 => (columns[count / 2], refused) = (n, Some("row_starts")),
        29 if count > 0 => (starts[m / 2], refused) = (count + 9, Some("row_starts")),
        _ => {}
    }
    // A last start that is larger would have the library read beyond the arrays.
    if starts[m] != count || (refused.is_some() && starts[0] == 0 && m < 2) {
        return;
    }
    let weighted = choices.one_in(2);
    let weights: Vec<f64> = (0..m).map(|_| numbers.normal()).collect();
    let mut old = Entries::finite(choices);
    let mut c = Matrix::<T>::new(choices, layout, (n, n), 1, |i, j| old.next(i, j));
    let (params, _) = of_product(choices);
    let what = format!("sparse {m} x {n}, {count}, {weighted}, {:?}", params.value);
    // SAFETY: the memory of the arrays.
    let status = unsafe {
        let pw = if weighted { weights.as_ptr() } else { ptr::null() };
        let (ps, pj, px) = (starts.as_ptr(), columns.as_ptr(), values.as_ptr());
        let (pc, params) = (c.pointer_mut(), params.pointer());
        T::SPARSE(layout, uplo, m, n, alpha, ps, pj, px, pw, beta, pc, c.ld, params)
    };
    let names: Vec<_> = params.refused.iter().copied().chain(refused).collect();
    if !names.is_empty() {
        c.check_untouched(&what);
        return check_refused(&what, status, &names);
    }
    check_accepted(&what, status);
    let weights = if weighted { weights } else { vec![1.0; m] };
    let most = |j: usize| x.iter().fold(0.0_f64, |most, row| most.max(row[j].abs()));
    let sizes: Vec<f64> = (0..n).map(most).collect();
    check(&what, uplo, (alpha, beta), (&x, &weights, &sizes), &c, Nearness::Norms);
}
