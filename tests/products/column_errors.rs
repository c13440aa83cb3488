//! The promise of the default options: errors are relative to the two columns of an entry, whatever
//! the norms of the others. Fast levels are forced at small sizes by their names.

use std::sync::Arc;

use catamaran::blas::{Backend, BlasReal, native_with};
use catamaran::faer::{Mat, MatRef};
use catamaran::kernel::packed::{FloatIsa, Rates};
use catamaran::rows::{DenseRows, RowOptions, ata_rows};
use catamaran::{Accuracy, AtaOptions, Plan, SchemeChoice, Uplo, ata_into, atb_into};

use crate::common::{backends, gaussian};

/// Our own kernels, with products that seem to cost so much that the planner takes every fast level
/// it may.
fn costly(isa: FloatIsa) -> Arc<dyn Backend> {
    native_with(isa, Rates { flops: 1e8, ..Rates::of(isa) })
}

/// `base` with column j times `2^powers[j]`; `None` for a column of zeros.
fn scaled<T: BlasReal>(base: &Mat<f64>, powers: &[Option<i32>]) -> Mat<T> {
    let entry = |i: usize, j: usize| match powers[j] {
        // In two steps, for one power may not be a number.
        Some(p) => base[(i, j)] * 2_f64.powi(p / 2) * 2_f64.powi(p - p / 2),
        None => 0.0,
    };
    Mat::from_fn(base.nrows(), base.ncols(), |i, j| T::from_f64(entry(i, j)))
}

/// Every eighth column small, graded columns, and one of zeros; `smallest` is the least power of
/// two.
fn spreads(n: usize, smallest: i32) -> Vec<Vec<Option<i32>>> {
    let mut found: Vec<Vec<_>> = [-3, -10, -30, -60, -100, -332, -664, -996]
        .into_iter()
        .filter(|&p| p >= smallest)
        .map(|p| (0..n).map(|j| Some(if j % 8 == 3 { p } else { 0 })).collect())
        .collect();
    found.push((0..n).map(|j| Some(smallest * j as i32 / n as i32)).collect());
    found.push(
        (0..n).map(|j| Some(-smallest / 2 + smallest * (j * 37 % n) as i32 / n as i32)).collect(),
    );
    found.push((0..n).map(|j| (j != 5).then_some(0)).collect());
    found.push((0..n).map(|j| (j != 5).then_some(if j % 8 == 3 { -30 } else { 0 })).collect());
    found
}

/// `A^T B` in twice the precision, rounded, and the products of the norms of its columns.
struct Exact {
    rows: usize,
    products: Mat<f64>,
    norms: Mat<f64>,
}

impl Exact {
    fn new(a: &Mat<f64>, b: &Mat<f64>) -> Self {
        let norms = |m: &Mat<f64>| (0..m.ncols()).map(|j| dot(m, j, m, j).sqrt()).collect();
        let (left, right): (Vec<f64>, Vec<f64>) = (norms(a), norms(b));
        let (n, k) = (a.ncols(), b.ncols());
        Self {
            rows: a.nrows(),
            products: Mat::from_fn(n, k, |i, j| dot(a, i, b, j)),
            norms: Mat::from_fn(n, k, |i, j| left[i] * right[j]),
        }
    }

    /// The largest error of an entry of C by `k u |a_i| |b_j|`, for columns times powers of two.
    fn error<T: BlasReal>(
        &self,
        c: MatRef<'_, T>,
        a_powers: &[Option<i32>],
        b_powers: &[Option<i32>],
        lower: bool,
    ) -> f64 {
        /// Below, products leave the range of the numbers.
        const SMALLEST: [i32; 2] = [-100, -960];
        let smallest = SMALLEST[usize::from(size_of::<T>() == 8)];
        let mut largest = 0.0_f64;
        for j in 0..c.ncols() {
            for i in if lower { j } else { 0 }..c.nrows() {
                let (Some(p), Some(q)) = (a_powers[i], b_powers[j]) else {
                    assert_eq!(c[(i, j)].to_f64(), 0.0, "({i}, {j}) of a column of zeros");
                    continue;
                };
                if p + q < smallest {
                    continue;
                }
                // In two steps, for one power may not be a number.
                let (half, rest) = ((p + q) / 2, (p + q) - (p + q) / 2);
                let entry = c[(i, j)].to_f64() * 2_f64.powi(-half) * 2_f64.powi(-rest);
                let unit = self.rows as f64 * T::UNIT_ROUNDOFF * self.norms[(i, j)];
                let error = (entry - self.products[(i, j)]).abs() / unit;
                assert!(error.is_finite(), "({i}, {j})");
                largest = largest.max(error);
            }
        }
        largest
    }
}

/// A product of columns in twice the precision, rounded.
fn dot(a: &Mat<f64>, i: usize, b: &Mat<f64>, j: usize) -> f64 {
    let (mut sum, mut rest) = (0.0_f64, 0.0_f64);
    for r in 0..a.nrows() {
        let (x, y) = (a[(r, i)], b[(r, j)]);
        let product = x * y;
        rest += x.mul_add(y, -product);
        let before = sum;
        sum += product;
        let virtual_part = sum - before;
        rest += (before - (sum - virtual_part)) + (product - virtual_part);
    }
    sum + rest
}

/// What the issue and the docs of `catamaran::ata` promise.
const FACTOR: f64 = 4.0;

fn check<T: BlasReal>(options: &AtaOptions<'_>, smallest: i32, what: &str) {
    // f32 entries are f64 entries of 24 bits.
    let round =
        |m: Mat<f64>| Mat::from_fn(m.nrows(), m.ncols(), |i, j| T::from_f64(m[(i, j)]).to_f64());
    // Too large for a direct product, which has no scheme.
    let (m, n, k) = (530, 96, 80);
    let (a, b) = (round(gaussian::<f64>(m, n, 1)), round(gaussian::<f64>(m, k, 2)));
    let (gram, product) = (Exact::new(&a, &a), Exact::new(&a, &b));
    for powers in spreads(n, smallest) {
        let mut b_powers: Vec<_> = powers[..k].to_vec();
        b_powers.reverse();
        let (sa, sb) = (scaled::<T>(&a, &powers), scaled::<T>(&b, &b_powers));
        let name = format!("{what}, {}, {powers:?}", T::NAME);

        let mut c = Mat::from_fn(n, n, |_, _| T::ZERO);
        ata_into(T::ONE, sa.as_ref(), T::ZERO, c.as_mut(), options).unwrap();
        let error = gram.error(c.as_ref(), &powers, &powers, true);
        assert!(error <= FACTOR, "ata, {name}: {error}");

        let mut d = Mat::from_fn(n, k, |_, _| T::ZERO);
        atb_into(T::ONE, sa.as_ref(), sb.as_ref(), T::ZERO, d.as_mut(), options).unwrap();
        let error = product.error(d.as_ref(), &powers, &b_powers, false);
        assert!(error <= FACTOR, "atb, {name}: {error}");

        let mut e = Mat::from_fn(n, n, |_, _| T::ZERO);
        let rows = &mut DenseRows(sa.as_ref());
        ata_rows(T::ONE, rows, &RowOptions::new(), T::ZERO, e.as_mut(), options).unwrap();
        let error = gram.error(e.as_ref(), &powers, &powers, true);
        assert!(error <= FACTOR, "ata_rows, {name}: {error}");
    }
}

#[test]
fn small_columns_are_as_accurate_as_large_ones_on_every_instruction_set() {
    for isa in FloatIsa::ALL {
        for scheme in [SchemeChoice::Float, SchemeChoice::Winograd, SchemeChoice::Kgp4] {
            let options = AtaOptions::new().backend(costly(isa)).scheme(scheme).leaf(8);
            let plan = Plan::ata::<f64>(530, 96, &options).unwrap();
            assert!(plan.is_fast(), "{scheme:?}:\n{plan}");
            check::<f64>(&options, -996, &format!("{} {scheme:?}", isa.name()));
            check::<f32>(&options, -100, &format!("{} {scheme:?}", isa.name()));
        }
    }
}

#[test]
fn small_columns_are_accurate_on_the_exact_path_and_on_other_back_ends() {
    check::<f64>(&AtaOptions::new().reproducible(true), -996, "exact");
    check::<f32>(&AtaOptions::new().reproducible(true), -100, "exact");
    for backend in backends() {
        let options = AtaOptions::new().backend(backend).leaf(8);
        check::<f64>(&options, -996, "back end");
    }
}

#[test]
fn a_column_that_is_not_finite_spoils_its_own_products_alone() {
    let a = gaussian::<f64>(150, 64, 3);
    for isa in FloatIsa::ALL {
        for scheme in [SchemeChoice::Winograd, SchemeChoice::Kgp4] {
            let options =
                AtaOptions::new().backend(costly(isa)).scheme(scheme).leaf(8).uplo(Uplo::Both);
            for bad in [f64::NAN, f64::INFINITY] {
                let mut spoilt = a.clone();
                spoilt[(77, 20)] = bad;
                let mut c = Mat::zeros(64, 64);
                ata_into(1.0, spoilt.as_ref(), 0.0, c.as_mut(), &options).unwrap();
                for j in 0..64 {
                    for i in 0..64 {
                        assert_eq!(c[(i, j)].is_finite(), i != 20 && j != 20, "({i}, {j})");
                    }
                }
            }
        }
    }
}

#[test]
fn scaling_changes_nothing_for_columns_of_one_size() {
    let a = gaussian::<f64>(150, 64, 4);
    let options = AtaOptions::new().scheme(SchemeChoice::Winograd).leaf(8);
    let (mut plain, mut scaled) = (Mat::zeros(64, 64), Mat::zeros(64, 64));
    ata_into(1.0, a.as_ref(), 0.0, plain.as_mut(), &options).unwrap();
    let a = Mat::from_fn(150, 64, |i, j| a[(i, j)] * 2_f64.powi(500));
    ata_into(1.0, a.as_ref(), 0.0, scaled.as_mut(), &options).unwrap();
    assert_eq!(scaled, Mat::from_fn(64, 64, |i, j| plain[(i, j)] * 2_f64.powi(1000)));
}

#[test]
fn with_alpha_zero_nothing_is_read() {
    let a = Mat::from_fn(150, 64, |_, _| f64::NAN);
    for (name, scheme) in SchemeChoice::NAMES {
        for backend in backends() {
            let options = AtaOptions::new().scheme(scheme).leaf(8).backend(backend);
            for accuracy in [Accuracy::Default, Accuracy::Classical] {
                let options = options.clone().accuracy(accuracy);
                for (beta, expected) in [(1.0, 1.0), (0.0, 0.0), (-2.0, -2.0)] {
                    let mut c = Mat::from_fn(64, 64, |i, j| if i >= j { 1.0 } else { f64::NAN });
                    ata_into(0.0, a.as_ref(), beta, c.as_mut(), &options).unwrap();
                    assert!((0..64).all(|i| c[(i, i / 2)] == expected), "{name}");
                    assert!((1..64).all(|j| c[(j - 1, j)].is_nan()), "{name}");
                    let mut d = Mat::from_fn(64, 64, |_, _| 1.0);
                    atb_into(0.0, a.as_ref(), a.as_ref(), beta, d.as_mut(), &options).unwrap();
                    assert!(d == Mat::from_fn(64, 64, |_, _| expected), "{name}");
                }
            }
        }
    }
}
