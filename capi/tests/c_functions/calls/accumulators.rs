//! Accumulators: rows in blocks, some removed again, merged.

use std::ptr;

use catamaran_capi::*;

use super::buffers::Matrix;
use super::choices::Choices;
use super::oracle::dot;
use super::params::{Params, field};
use super::refusal::{check_accepted, check_refused};

struct Handle(*mut cata_accumulator);

impl Drop for Handle {
    fn drop(&mut self) {
        // SAFETY: NULL or alive, and freed once.
        unsafe { cata_accumulator_free(self.0) };
    }
}

fn create(n: usize, params: &Params<cata_accumulator_params>) -> (Handle, cata_status) {
    let mut place = ptr::null_mut();
    // SAFETY: a live struct and a place.
    let status = unsafe { cata_accumulator_new(n, params.pointer(), &mut place) };
    (Handle(place), status)
}

/// Adds or removes some of the rows.
fn change(own: &Handle, a: &Matrix<f64>, layout: i32, from: usize, weights: &[f64], remove: bool) {
    let start = if layout == CATA_ROW_MAJOR { from * a.ld } else { from };
    let work = if remove { cata_accumulator_remove } else { cata_accumulator_add };
    // SAFETY: rows of the matrix, and as many weights.
    let status = unsafe {
        let rows = a.pointer().wrapping_add(start);
        work(own.0, layout, weights.len(), rows, a.ld, weights.as_ptr())
    };
    check_accepted("accumulator_add", status);
}

/// Returns C of an accumulator, row-major.
fn gram(own: &Handle, n: usize, alpha: f64) -> Vec<f64> {
    let mut c = vec![f64::NAN; n * n];
    // SAFETY: the memory of the array.
    let status = unsafe {
        cata_accumulator_gram(own.0, CATA_ROW_MAJOR, CATA_BOTH, alpha, c.as_mut_ptr(), n.max(1))
    };
    check_accepted("accumulator_gram", status);
    c
}

/// Makes an accumulator and reads it.
pub fn call(choices: &mut Choices<'_>) {
    let layout = choices.pick(&[CATA_ROW_MAJOR, CATA_COL_MAJOR]);
    let (m, n) = (choices.side(), choices.below(20));
    let mut numbers = choices.rng();
    let integers = choices.one_in(2);
    let a = Matrix::<f64>::new(choices, layout, (m, n), 1, |_, _| match integers {
        true => (20.0 * numbers.uniform()).floor() - 10.0,
        false => numbers.uniform() * 20.0 - 10.0,
    });
    let weights: Vec<f64> = (0..m).map(|_| (4.0 * numbers.uniform()).floor() + 0.5).collect();
    let (lower, upper) = (vec![-10.0; n], vec![10.0; n]);
    let mut refused = None;
    let sums = field(choices, "params.sums: ", &[0, 1, 2], &[-1, 3], &mut refused);
    let centered = field(choices, "params.centered: ", &[0, 1], &[2, -1], &mut refused);
    let value = cata_accumulator_params {
        struct_size: 0,
        threads: choices.pick(&[1, 0, 3]),
        progress: None,
        progress_user: ptr::null_mut(),
        lower: lower.as_ptr(),
        upper: upper.as_ptr(),
        rows: 1000,
        largest_weight: 4.0,
        sums,
        centered,
    };
    let params = Params::new(choices, value, refused);
    let what = format!("accumulator {m} x {n}, {sums}, {centered}");
    let (own, status) = create(n, &params);
    if !params.refused.is_empty() {
        assert!(own.0.is_null(), "{what}: a handle after an error");
        return check_refused(&what, status, &params.refused);
    }
    check_accepted(&what, status);
    let cut = if m == 0 { 0 } else { choices.below(m) };
    change(&own, &a, layout, 0, &weights[..cut], false);
    let before = gram(&own, n, 1.0);
    change(&own, &a, layout, cut, &weights[cut..], false);
    check(&what, &own, &a, &weights, n, centered == 1);
    if sums == CATA_SUMS_FLOAT {
        return;
    }
    let whole = gram(&own, n, 1.0);
    change(&own, &a, layout, cut, &weights[cut..], true);
    let again = gram(&own, n, 1.0);
    assert!(same(&again, &before), "{what}: rows that were removed are still there");
    let (other, _) = create(n, &params);
    change(&other, &a, layout, cut, &weights[cut..], false);
    // SAFETY: two live accumulators.
    check_accepted(&what, unsafe { cata_accumulator_merge(own.0, other.0) });
    assert!(same(&gram(&own, n, 1.0), &whole), "{what}: merged sums differ");
}

fn same(x: &[f64], y: &[f64]) -> bool {
    x.iter().map(|x| x.to_bits()).eq(y.iter().map(|y| y.to_bits()))
}

fn check(what: &str, own: &Handle, a: &Matrix<f64>, weights: &[f64], n: usize, centered: bool) {
    let m = weights.len();
    let (mut rows, mut weight, mut mean) = (0_u64, 0.0, vec![f64::NAN; n]);
    // SAFETY: places for the numbers, and n elements.
    let status = unsafe { cata_accumulator_rows(own.0, &mut rows, &mut weight, mean.as_mut_ptr()) };
    check_accepted(what, status);
    let total: f64 = weights.iter().sum();
    assert!(rows == m as u64 && (weight - total).abs() <= 1e-12 * total, "{what}: {rows} {weight}");
    let middle = |j: usize| match centered && m > 0 {
        true => dot((0..m).map(|i| (weights[i], a.get(i, j)))) / total,
        false => 0.0,
    };
    let middles: Vec<f64> = (0..n).map(middle).collect();
    for (j, (mean, middle)) in mean.iter().zip(&middles).enumerate() {
        // No rows have no mean.
        let right = m == 0 || (mean - middle).abs() <= 1e-12;
        assert!(right, "{what}: mean {j} is {mean}, not {middle}");
    }
    let c = gram(own, n, 0.5);
    for i in 0..n {
        for j in 0..n {
            let pair =
                |r: usize| (weights[r] * (a.get(r, i) - middles[i]), a.get(r, j) - middles[j]);
            let exact = 0.5 * dot((0..m).map(pair));
            let bound = 1e-14 * (m * m + 1) as f64 * 400.0;
            let got = c[i * n + j];
            assert!((got - exact).abs() <= bound, "{what}: ({i}, {j}) is {got}, not {exact}");
        }
    }
}
