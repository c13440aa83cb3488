//! Eigenpairs of small sparse matrices, against Jacobi's rotations, and solutions with them.

use std::ffi::c_void;
use std::{ptr, slice};

use catamaran::base::Rng;
use catamaran_capi::*;

use super::buffers::Matrix;
use super::choices::Choices;
use super::oracle::{dot, norm};
use super::params::{Params, field};
use super::refusal::{check_accepted, check_refused};

/// A symmetric positive semi-definite matrix by rows, and masses.
struct Pencil {
    n: usize,
    dense: Vec<Vec<f64>>,
    starts: Vec<usize>,
    columns: Vec<usize>,
    entries: Vec<f64>,
    masses: Vec<f64>,
    weighted: bool,
}

impl Pencil {
    /// Chooses the Laplacian of a graph, with eigenvalues of many multiplicities, and something on
    /// its diagonal.
    fn new(choices: &mut Choices<'_>) -> Self {
        let n = choices.below(40);
        let kind = choices.below(4);
        let mut numbers = choices.rng();
        let mut dense = vec![vec![0.0; n]; n];
        let mut edge = |i: usize, j: usize, w: f64| {
            if i != j {
                dense[i][i] += w;
                dense[j][j] += w;
                dense[i][j] -= w;
                dense[j][i] -= w;
            }
        };
        for i in 0..n {
            match kind {
                0 => edge(i, (i + 1) % n, 1.0),
                1 => edge(i, (3 * i + 1) % n, numbers.uniform() + 0.1),
                2 => (0..i).for_each(|j| edge(i, j, 1.0)),
                _ => {} // no edge at all
            }
        }
        let shift = choices.pick(&[0.0, 0.5, 1e6]);
        (0..n).for_each(|i| dense[i][i] += shift);
        let weighted = choices.one_in(2);
        let masses = (0..n).map(|_| if weighted { numbers.uniform() + 0.1 } else { 1.0 }).collect();
        let (mut starts, mut columns, mut entries) = (vec![0], Vec::new(), Vec::new());
        for (i, row) in dense.iter().enumerate() {
            for (j, &x) in row.iter().enumerate().filter(|&(j, &x)| x != 0.0 || i == j) {
                columns.push(j);
                entries.push(x);
            }
            starts.push(columns.len());
        }
        Self { n, dense, starts, columns, entries, masses, weighted }
    }

    fn masses(&self) -> *const f64 {
        if self.weighted { self.masses.as_ptr() } else { ptr::null() }
    }

    /// Returns all eigenvalues, ascending.
    fn eigenvalues(&self) -> Vec<f64> {
        let n = self.n;
        let scaled =
            |i: usize, j: usize| self.dense[i][j] / (self.masses[i] * self.masses[j]).sqrt();
        let mut a: Vec<Vec<f64>> = (0..n).map(|i| (0..n).map(|j| scaled(i, j)).collect()).collect();
        for _ in 0..30 {
            for p in 0..n {
                for q in p + 1..n {
                    if a[p][q] != 0.0 {
                        rotate(&mut a, p, q);
                    }
                }
            }
        }
        let mut values: Vec<f64> = (0..n).map(|i| a[i][i]).collect();
        values.sort_by(f64::total_cmp);
        values
    }

    /// Returns the largest eigenvalue, about.
    fn size(&self) -> f64 {
        let row = |i: usize| norm(self.dense[i].iter().copied()) / self.masses[i];
        (0..self.n).map(row).fold(0.0, f64::max)
    }
}

/// Makes the entry (p, q) of a symmetric matrix 0 by a rotation.
fn rotate(a: &mut [Vec<f64>], p: usize, q: usize) {
    let theta = (a[q][q] - a[p][p]) / (2.0 * a[p][q]);
    let t = theta.signum() / (theta.abs() + (theta * theta + 1.0).sqrt());
    let t = if theta == 0.0 { 1.0 } else { t };
    let c = 1.0 / (t * t + 1.0).sqrt();
    let s = t * c;
    for row in a.iter_mut() {
        (row[p], row[q]) = (c * row[p] - s * row[q], s * row[p] + c * row[q]);
    }
    for k in 0..a.len() {
        (a[p][k], a[q][k]) = (c * a[p][k] - s * a[q][k], s * a[p][k] + c * a[q][k]);
    }
}

/// Makes a call of one of the functions.
pub fn call(choices: &mut Choices<'_>) {
    let pencil = Pencil::new(choices);
    if choices.one_in(4) {
        return solutions(choices, &pencil);
    }
    let mut refused = None;
    let r = &mut refused;
    let bad = [2, -1, i32::MIN];
    let value = cata_eigs_params {
        struct_size: 0,
        threads: choices.pick(&[1, 0, 3]),
        progress: None,
        progress_user: ptr::null_mut(),
        max_restarts: choices.pick(&[0, 200]),
        seed: choices.below(256) as u64,
        tolerance: field(
            choices,
            "tolerance: ",
            &[0.0, 1e-9, 1e-4],
            &[-1.0, 1.0, f64::NAN, 1e-300],
            r,
        ),
        shift: 0.0,
        has_shift: field(choices, "params.has_shift: ", &[0], &bad, r),
        verify_count: field(choices, "params.verify_count: ", &[0, 1], &bad, r),
        laplacian: field(choices, "params.laplacian: ", &[0, 1, 2], &[3, -1, 99], r),
        mass: field(choices, "params.mass: ", &[0, 1, 2], &[3, -1, 99], r),
        boundary: field(choices, "params.boundary: ", &[0, 1], &bad, r),
    };
    let params = Params::new(choices, value, refused);
    match choices.below(4) {
        0 => sliced(choices, &pencil, &params),
        1 => count(choices, &pencil, &params),
        _ => pairs(choices, &pencil, &params),
    }
}

fn pairs(choices: &mut Choices<'_>, pencil: &Pencil, params: &Params<cata_eigs_params>) {
    let n = pencil.n;
    let k = choices.below(n + 2);
    let mut values = Matrix::<f64>::output(choices, k);
    let mut residuals = Matrix::<f64>::output(choices, k);
    let mut vectors = Matrix::<f64>::new(choices, CATA_COL_MAJOR, (n, k), 1, |_, _| f64::NAN);
    let overlap = choices.one_in(16) && k > 0 && n > 0;
    let what = format!("eigs {n}, {k}, {:?}, {overlap}", params.value);
    // SAFETY: the memory of the arrays, or arguments that must be refused.
    let status = unsafe {
        let (starts, columns) = (pencil.starts.as_ptr(), pencil.columns.as_ptr());
        let (entries, masses) = (pencil.entries.as_ptr(), pencil.masses());
        let (pv, pr) = (values.pointer_mut(), residuals.pointer_mut());
        let place = if overlap { pv } else { vectors.pointer_mut() };
        let (ldv, params) = (vectors.ld, params.pointer());
        cata_eigs(n, starts, columns, entries, masses, k, pv, place, ldv, pr, params)
    };
    let mut names = params.refused.clone();
    if k > n {
        names.extend(["k", "options.k"]);
    }
    if overlap {
        names.push("eigenvectors: ");
    }
    if !names.is_empty() {
        [&values, &residuals, &vectors].iter().for_each(|x| x.check_untouched(&what));
        return check_refused(&what, status, &names);
    }
    check_accepted(&what, status);
    vectors.check_changes(&what, |_, _| true);
    let exact = pencil.eigenvalues();
    let found: Vec<f64> = (0..k).map(|i| values.get(0, i)).collect();
    check_values(&what, &found, &exact, pencil.size(), tolerance(&params.value));
    for i in 0..k {
        for j in 0..=i {
            let entry = |r: usize| (vectors.get(r, i) * pencil.masses[r], vectors.get(r, j));
            let error = (dot((0..n).map(entry)) - f64::from(i == j)).abs();
            assert!(error <= 1e-8, "{what}: ({i}, {j}) is off by {error}");
        }
    }
}

fn tolerance(params: &cata_eigs_params) -> f64 {
    if params.tolerance == 0.0 { 1e-9 } else { params.tolerance }
}

fn check_values(what: &str, found: &[f64], exact: &[f64], size: f64, tolerance: f64) {
    for (i, (found, exact)) in found.iter().zip(exact).enumerate() {
        let error = (found - exact).abs();
        let bound = (1e-10 + tolerance) * size;
        assert!(error <= bound, "{what}: eigenvalue {i} is {found}, not {exact}");
    }
}

/// Takes slices.
extern "C" fn take(
    count: usize,
    values: *const f64,
    _: *const f64,
    _: usize,
    _: *const f64,
    user: *mut c_void,
) -> i32 {
    // SAFETY: what cata_eigs_sliced hands out, and the vector that it was called with.
    let (found, slice) =
        unsafe { (&mut *user.cast::<Vec<f64>>(), slice::from_raw_parts(values, count)) };
    found.extend(slice);
    0
}

fn sliced(choices: &mut Choices<'_>, pencil: &Pencil, params: &Params<cata_eigs_params>) {
    let n = pencil.n;
    let k = choices.below(n + 1);
    let mut found = Vec::<f64>::new();
    let what = format!("eigs_sliced {n}, {k}, {:?}", params.value);
    // SAFETY: the memory of the arrays, or arguments that must be refused.
    let status = unsafe {
        let (starts, columns) = (pencil.starts.as_ptr(), pencil.columns.as_ptr());
        let (entries, masses) = (pencil.entries.as_ptr(), pencil.masses());
        let (user, params) = ((&raw mut found).cast(), params.pointer());
        let memory = 1 << 26;
        cata_eigs_sliced(n, starts, columns, entries, masses, k, memory, Some(take), user, params)
    };
    if !params.refused.is_empty() {
        assert!(found.is_empty(), "{what}");
        return check_refused(&what, status, &params.refused);
    }
    check_accepted(&what, status);
    assert_eq!(found.len(), k, "{what}");
    check_values(&what, &found, &pencil.eigenvalues(), pencil.size(), tolerance(&params.value));
}

fn count(choices: &mut Choices<'_>, pencil: &Pencil, params: &Params<cata_eigs_params>) {
    let n = pencil.n;
    let mut rng: Rng = choices.rng();
    let value = rng.uniform() * 1.2 * pencil.size() + 0.123;
    let mut found = usize::MAX;
    let what = format!("eigs_count {n}, {value}, {:?}", params.value);
    // SAFETY: the memory of the arrays, or arguments that must be refused.
    let status = unsafe {
        let (starts, columns) = (pencil.starts.as_ptr(), pencil.columns.as_ptr());
        let (entries, masses) = (pencil.entries.as_ptr(), pencil.masses());
        let params = params.pointer();
        cata_eigs_count(n, starts, columns, entries, masses, value, &mut found, params)
    };
    // Only the progress callback is used.
    if !params.refused.is_empty() && params.refused != ["tolerance: "] {
        assert_eq!(found, usize::MAX, "{what}");
        return check_refused(&what, status, &params.refused);
    }
    let exact = pencil.eigenvalues();
    if exact.iter().any(|x| (x - value).abs() <= 1e-9 * pencil.size()) {
        return; // it may be one of them
    }
    check_accepted(&what, status);
    assert_eq!(found, exact.iter().filter(|&&x| x < value).count(), "{what}");
}

/// Solves with the matrix of a pencil, of which all triangles are stored.
fn solutions(choices: &mut Choices<'_>, pencil: &Pencil) {
    let n = pencil.n;
    let mut refused = None;
    let r = &mut refused;
    let triangles = [0, CATA_UPPER, CATA_LOWER, CATA_BOTH];
    let value = cata_cholesky_params {
        struct_size: 0,
        threads: choices.pick(&[1, 0, 3]),
        progress: None,
        progress_user: ptr::null_mut(),
        order: ptr::null(),
        tolerance: field(choices, "tolerance: ", &[0.0, 1e-10], &[-1.0, 1.0, f64::NAN], r),
        triangle: field(choices, "params.triangle: ", &triangles, &[1, -1, 124], r),
        semidefinite: field(choices, "params.semidefinite: ", &[1], &[2, -1, i32::MIN], r),
    };
    let params = Params::new(choices, value, refused);
    let what = format!("cholesky {n}, {:?}", params.value);
    let mut handle: *mut cata_cholesky = ptr::null_mut();
    let (starts, columns) = (pencil.starts.as_ptr(), pencil.columns.as_ptr());
    // SAFETY: the memory of the arrays, or arguments that must be refused.
    let status =
        unsafe { cata_cholesky_analyse(n, starts, columns, params.pointer(), &mut handle) };
    if !params.refused.is_empty() {
        assert!(handle.is_null(), "{what}");
        return check_refused(&what, status, &params.refused);
    }
    check_accepted(&what, status);

    let layout = choices.pick(&[CATA_COL_MAJOR, CATA_ROW_MAJOR]);
    let count = choices.below(11);
    let rows: Vec<usize> = (0..choices.below(5)).map(|i| (7 * i + 1) % n.max(1)).collect();
    let rows = if n == 0 { Vec::new() } else { rows };
    let mut numbers = choices.rng();
    let y: Vec<Vec<f64>> =
        (0..count).map(|_| (0..n).map(|_| numbers.uniform() - 0.5).collect()).collect();
    let right = |i: usize, c: usize| dot((0..n).map(|j| (pencil.dense[i][j], y[c][j])));
    let b = Matrix::<f64>::new(choices, layout, (n, count), 1, right);
    let mut x = Matrix::<f64>::new(choices, layout, (n, count), 1, right);
    let mut some = Matrix::<f64>::new(choices, layout, (rows.len(), count), 1, |_, _| f64::NAN);
    let (mut held_count, mut held) = (0, vec![usize::MAX; n]);
    // SAFETY: the memory of the arrays; all rows have room in `held`.
    unsafe {
        let entries = pencil.entries.as_ptr();
        check_accepted(&what, cata_cholesky_factor(handle, starts, columns, entries));
        let (px, ldx) = (x.pointer_mut(), x.ld);
        check_accepted(&what, cata_cholesky_solve(handle, layout, count, px, ldx));
        let (pb, ldb, ps, lds) = (b.pointer(), b.ld, some.pointer_mut(), some.ld);
        let (len, wanted) = (rows.len(), rows.as_ptr());
        let status = cata_cholesky_solve_rows(handle, layout, count, pb, ldb, len, wanted, ps, lds);
        check_accepted(&what, status);
        let null = ptr::null_mut();
        check_accepted(&what, cata_cholesky_size(handle, null, null, &mut held_count));
        check_accepted(&what, cata_cholesky_held(handle, held.as_mut_ptr()));
        cata_cholesky_free(handle);
    }
    b.check_untouched(&what);
    x.check_changes(&what, |_, _| true);
    some.check_changes(&what, |_, _| true);
    for c in 0..count {
        for i in 0..n {
            let product = dot((0..n).map(|j| (pencil.dense[i][j], x.get(j, c))));
            let error = (product - b.get(i, c)).abs();
            assert!(error <= 1e-10 * pencil.size(), "{what}: ({i}, {c}) is off by {error}");
        }
        assert!(held[..held_count].iter().all(|&row| x.get(row, c) == 0.0), "{what}");
        let same = |(i, &row): (usize, &usize)| some.get(i, c).to_bits() == x.get(row, c).to_bits();
        assert!(rows.iter().enumerate().all(same), "{what}: other rows");
    }
}
