//! A^H A and A^H B.

use catamaran_capi::*;

use super::buffers::Matrix;
use super::choices::Choices;
use super::entries::{Entries, Real, factor};
use super::oracle::{Expected, dot, norm};
use super::params::{Nearness, of_product};
use super::refusal::{Fault, check_accepted, check_refused};

/// Makes a call of one of the products.
pub fn call<T: Real>(choices: &mut Choices<'_>) {
    let general = choices.one_in(2);
    let layout = choices.pick(&[CATA_ROW_MAJOR, CATA_COL_MAJOR]);
    let uplo = choices.pick(&[CATA_BOTH, CATA_LOWER, CATA_UPPER]);
    let (m, n) = (choices.side(), choices.side());
    let k = if general { choices.side() } else { n };
    let mut scalar = || {
        let real: T = factor(choices);
        [real, if general { factor(choices) } else { T::of(0.0) }]
    };
    let (alpha, beta) = (scalar(), scalar());
    let mut entries = Entries::any(choices);
    let a = Matrix::<T>::new(choices, layout, (m, n), 2, |i, j| entries.next(i, j));
    let b = Matrix::<T>::new(choices, layout, (m, k), 2, |i, j| entries.next(i, j));
    let mut old = Entries::finite(choices);
    let mut c = Matrix::<T>::new(choices, layout, (n, k), 2, |i, j| old.next(i, j));
    let (params, nearness) = of_product(choices);
    let mut faults = vec![Fault::Layout, Fault::LdA, Fault::LdC];
    if !a.is_empty() && !c.is_empty() {
        faults.push(Fault::Overlap);
    }
    let fault = Fault::pick(choices, &faults);
    let what = format!("complex {m} x {n}, {k}, {general}, {:?}, {fault:?}", params.value);
    let wrong_layout = if fault == Fault::Layout { 0 } else { layout };
    let lda = if fault == Fault::LdA { 0 } else { a.ld };
    let ldc = if fault == Fault::LdC { 0 } else { c.ld };
    let place = if fault == Fault::Overlap { a.pointer().cast_mut() } else { c.pointer_mut() };
    // SAFETY: the memory of the matrices, or arguments that must be refused.
    let status = unsafe {
        let (pa, pb, params) = (a.pointer(), b.pointer(), params.pointer());
        if general {
            let (alpha, beta) = (alpha.as_ptr(), beta.as_ptr());
            T::AHB(wrong_layout, m, n, k, alpha, pa, lda, pb, b.ld, beta, place, ldc, params)
        } else {
            T::AHA(wrong_layout, uplo, m, n, alpha[0], pa, lda, beta[0], place, ldc, params)
        }
    };
    a.check_untouched(&what);
    b.check_untouched(&what);
    let mut names = params.refused.clone();
    names.extend(fault.names());
    if !names.is_empty() {
        c.check_untouched(&what);
        return check_refused(&what, status, &names);
    }
    check_accepted(&what, status);
    let uplo = if general { 0 } else { uplo };
    check(&what, uplo, (alpha, beta), [&a, if general { &b } else { &a }, &c], nearness);
}

/// Checks the wanted entries of C. Bounds are those of the norms of two columns, as alpha and beta
/// mix both parts, and NaN and infinities are only looked for where they must be.
fn check<T: Real>(
    what: &str,
    uplo: i32,
    (alpha, beta): ([T; 2], [T; 2]),
    [a, b, c]: [&Matrix<T>; 3],
    nearness: Nearness,
) {
    let wanted = |i: usize, j: usize| match uplo {
        CATA_UPPER => i <= j,
        CATA_LOWER => i >= j,
        _ => true,
    };
    c.check_changes(what, wanted);
    let len = a.rows;
    let part = |of: &Matrix<T>, r, j, p| of.part(r, j, p).wide();
    let column = |of: &Matrix<T>, j: usize| {
        let parts: Vec<f64> =
            (0..len).flat_map(|r| [part(of, r, j, 0), part(of, r, j, 1)]).collect();
        (norm(parts.iter().copied()), parts.iter().fold(0.0_f64, |most, x| most.max(x.abs())))
    };
    let columns = |of: &Matrix<T>| (0..of.cols).map(|j| column(of, j)).collect::<Vec<_>>();
    let (left, right) = (columns(a), columns(b));
    let largest = |of: &[(f64, f64)]| of.iter().fold(0.0_f64, |most, x| most.max(x.1));
    let largest = largest(&left) * largest(&right);
    let spread = left.iter().chain(&right).any(|x| !x.0.is_finite());
    for i in 0..c.rows {
        for j in 0..c.cols {
            if !wanted(i, j) {
                continue;
            }
            // (x - i y) (u + i v)
            let terms = |r: usize| {
                let (x, y) = (part(a, r, i, 0), part(a, r, i, 1));
                (x, y, part(b, r, j, 0), part(b, r, j, 1))
            };
            let real = dot((0..len).map(terms).flat_map(|(x, y, u, v)| [(x, u), (y, v)]));
            let imaginary = dot((0..len).map(terms).flat_map(|(x, y, u, v)| [(x, v), (-y, u)]));
            let conjugated = uplo == CATA_BOTH && i < j;
            let old = |p: usize| match (conjugated, p) {
                (true, 0) => c.old(j, i, 0).wide(),
                (true, _) => -c.old(j, i, 1).wide(),
                _ if uplo != 0 && i == j && p == 1 => 0.0,
                _ => c.old(i, j, p).wide(),
            };
            let size = len as f64 * T::UNIT;
            let expected = |p: usize| {
                let [ar, ai] = alpha.map(Real::wide);
                let [br, bi] = beta.map(Real::wide);
                let mixed = |x: f64, s: f64, y: f64, t: f64| {
                    let one = if x == 0.0 { 0.0 } else { x * s };
                    one + if y == 0.0 { 0.0 } else { y * t }
                };
                let old_parts = [old(0), old(1)];
                let (sum, old) = match p {
                    0 => (
                        mixed(ar, real, -ai, imaginary),
                        mixed(br, old_parts[0], -bi, old_parts[1]),
                    ),
                    _ => {
                        (mixed(ar, imaginary, ai, real), mixed(br, old_parts[1], bi, old_parts[0]))
                    }
                };
                let bound = match nearness {
                    Nearness::Largest => 512.0 * size * len as f64 * largest,
                    _ => 8.0 * size * left[i].0 * right[j].0,
                };
                let none = ar == 0.0 && ai == 0.0;
                let size_of_old = old_parts[0].abs() + old_parts[1].abs();
                Expected {
                    alpha: if none { 0.0 } else { 1.0 },
                    sum,
                    beta: 1.0,
                    old,
                    bound: bound * (ar.abs() + ai.abs()),
                    as_loops: false,
                    spread,
                    unit: if nearness == Nearness::Loops { 4.0 } else { 64.0 } * T::UNIT,
                    // Both parts of beta C may cancel.
                    tiny: 16.0 * (len + 1) as f64 * T::SMALLEST
                        + 4.0 * T::UNIT * mixed(br.abs(), size_of_old, bi.abs(), size_of_old),
                }
            };
            for p in 0..2 {
                let (got, expected) = (c.part(i, j, p).wide(), expected(p));
                let fixed = uplo != 0 && i == j && p == 1;
                let right = if fixed { got == 0.0 || spread } else { expected.allows(got) };
                assert!(right, "{what}: part {p} of ({i}, {j}) is {got:?}: {expected:?}");
            }
            if uplo == CATA_BOTH && !spread {
                let same = c.part(i, j, 0).bits() == c.part(j, i, 0).bits();
                let conjugate = c.part(i, j, 1).wide() == -c.part(j, i, 1).wide();
                assert!(same && conjugate, "{what}: ({i}, {j}) is not the conjugate");
            }
        }
    }
}
