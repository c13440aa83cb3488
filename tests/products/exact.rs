//! The exact path as callers see it: special values, limits, and the same bytes whatever happens.

use catamaran::base::Rng;
use catamaran::blas::BlasReal;
use catamaran::faer::{Mat, MatRef};
use catamaran::rows::{Center, DenseRows, RowOptions, ata_rows};
use catamaran::{
    Accuracy, AtaOptions, Error, Par, Plan, SchemeChoice, Uplo, ata_into, atb_into,
    kernel::int8::IntegerIsa,
};

use crate::common::{bits, gaussian};

fn reproducible() -> AtaOptions<'static> {
    AtaOptions::new().reproducible(true).uplo(Uplo::Both).threads(2)
}

fn product<T: BlasReal>(a: MatRef<'_, T>, options: &AtaOptions<'_>) -> Mat<T> {
    let mut c = Mat::from_fn(a.ncols(), a.ncols(), |_, _| T::ZERO);
    ata_into(T::ONE, a, T::ZERO, c.as_mut(), options).unwrap();
    c
}

fn uniform<T: BlasReal>(m: usize, n: usize, seed: u64) -> Mat<T> {
    let mut rng = Rng::new(seed);
    Mat::from_fn(m, n, |_, _| T::from_f64(2.0 * rng.uniform() - 1.0))
}

#[test]
fn threads_layouts_and_the_order_of_rows_do_not_change_a_byte() {
    for (m, n) in [(700, 90), (90, 300), (9000, 33)] {
        let a = gaussian::<f64>(m, n, 1);
        let expected = bits(product(a.as_ref(), &reproducible()).as_ref());
        for threads in [1, 3, 7] {
            let options = reproducible().threads(threads);
            assert_eq!(bits(product(a.as_ref(), &options).as_ref()), expected, "{threads} threads");
        }
        let by_rows = a.transpose().to_owned();
        assert_eq!(bits(product(by_rows.transpose(), &reproducible()).as_ref()), expected);
        let turned = a.as_ref().reverse_rows();
        assert_eq!(bits(product(turned, &reproducible()).as_ref()), expected, "rows reversed");
        // Rows in another order could choose another power of two where a norm is within 1e-6 of a
        // step. Here none is. 7919 is a prime, and divides none of the heights.
        let shuffled = Mat::from_fn(m, n, |i, j| a[((i * 7919) % m, j)]);
        assert_eq!(
            bits(product(shuffled.as_ref(), &reproducible()).as_ref()),
            expected,
            "shuffled"
        );
        let scheme = reproducible().scheme(SchemeChoice::Exact).reproducible(false);
        assert_eq!(bits(product(a.as_ref(), &scheme).as_ref()), expected, "by name");
    }
}

/// FNV-1a over the bits.
fn checksum<T: BlasReal>(c: MatRef<'_, T>) -> u64 {
    let step = |hash: u64, byte: u8| (hash ^ u64::from(byte)).wrapping_mul(0x100_0000_01b3);
    let bytes = bits(c).into_iter().flat_map(u64::to_le_bytes);
    bytes.fold(0xcbf2_9ce4_8422_2325, step)
}

fn golden<T: BlasReal>(accuracy: Accuracy) -> u64 {
    let (m, n) = (333, 77);
    let a = uniform::<T>(m, n, 42);
    let options = reproducible().accuracy(accuracy);
    let start = uniform::<T>(n, n, 43);
    let mut c = Mat::from_fn(n, n, |i, j| start[(i.max(j), i.min(j))]);
    ata_into(T::from_f64(0.3), a.as_ref(), T::from_f64(0.7), c.as_mut(), &options).unwrap();
    checksum(c.as_ref())
}

/// These numbers were computed without AMX; a machine with it, or any other, must find them too.
#[test]
fn every_machine_finds_the_same_bytes() {
    let found = [Accuracy::Fast, Accuracy::Default, Accuracy::Max]
        .map(|accuracy| [golden::<f64>(accuracy), golden::<f32>(accuracy)]);
    println!("isa {}: {found:#018x?}", IntegerIsa::best().name());
    assert_eq!(found, GOLDEN);
}

/// By accuracy (fast, default, max); f64, then f32.
const GOLDEN: [[u64; 2]; 3] = [
    [0x0f59_d103_a3e4_6f25, 0xb631_2e2d_a2ce_4459],
    [0x02bc_98c2_b39a_381c, 0x7ace_bf9c_50a9_a630],
    [0xd76b_f1d1_054f_8df6, 0x0d3c_b6a8_32e5_0d14],
];

#[test]
fn weights_and_centres_are_reproducible_too() {
    let (m, n) = (500, 40);
    let a = uniform::<f64>(m, n, 5);
    let weights: Vec<f64> = (0..m).map(|i| (i % 5) as f64 - 1.5).collect();
    let run = |threads: usize| {
        let options = reproducible().threads(threads);
        let rows = RowOptions::new().weights(&weights[..]).center(Center::Mean);
        let mut c = Mat::zeros(n, n);
        ata_rows(1.0, &mut DenseRows(a.as_ref()), &rows, 0.0, c.as_mut(), &options).unwrap();
        c
    };
    let c = run(1);
    assert_eq!(bits(c.as_ref()), bits(run(4).as_ref()));
    let total: f64 = weights.iter().sum();
    let mean: Vec<f64> =
        (0..n).map(|j| (0..m).map(|i| weights[i] * a[(i, j)]).sum::<f64>() / total).collect();
    for j in 0..n {
        for i in 0..n {
            let term = |k: usize| weights[k] * (a[(k, i)] - mean[i]) * (a[(k, j)] - mean[j]);
            let sum: f64 = (0..m).map(term).sum();
            assert!((c[(i, j)] - sum).abs() < 1e-11, "({i}, {j}): {} for {sum}", c[(i, j)]);
        }
    }
}

/// What the classical algorithm makes of NaN and infinities, term by term.
fn by_definition(a: MatRef<'_, f64>, b: MatRef<'_, f64>, i: usize, j: usize) -> f64 {
    (0..a.nrows()).map(|k| a[(k, i)] * b[(k, j)]).sum()
}

fn same(x: f64, y: f64) -> bool {
    x.to_bits() == y.to_bits() || x.is_nan() && y.is_nan()
}

#[test]
fn nan_and_infinities_reach_exactly_the_entries_that_they_should() {
    let (m, n) = (100, 40);
    let clean = gaussian::<f64>(m, n, 7);
    let mut a = clean.clone();
    a[(3, 2)] = f64::NAN;
    a[(5, 4)] = f64::INFINITY;
    a[(6, 4)] = f64::NEG_INFINITY;
    a[(5, 9)] = f64::INFINITY;
    a[(70, 33)] = f64::NEG_INFINITY;
    a[(70, 20)] = 0.0;
    a[(99, 39)] = f64::NAN;
    a[(98, 39)] = f64::INFINITY;
    let special = [2, 4, 9, 33, 39];
    let zeroed = Mat::from_fn(m, n, |i, j| if special.contains(&j) { 0.0 } else { a[(i, j)] });
    let finite = product(zeroed.as_ref(), &reproducible());
    for uplo in [Uplo::Lower, Uplo::Upper, Uplo::Both] {
        let c = product(a.as_ref(), &reproducible().uplo(uplo));
        for j in 0..n {
            for i in 0..n {
                let wanted = match uplo {
                    Uplo::Lower => i >= j,
                    Uplo::Upper => i <= j,
                    Uplo::Both => true,
                };
                let right = if !wanted {
                    0.0
                } else if special.contains(&i) || special.contains(&j) {
                    by_definition(a.as_ref(), a.as_ref(), i, j)
                } else {
                    finite[(i, j)]
                };
                assert!(same(c[(i, j)], right), "({i}, {j}): {}, not {right}", c[(i, j)]);
            }
        }
    }
    // A general product: either operand may bring them.
    let b =
        Mat::from_fn(m, 30, |i, j| if (i, j) == (50, 11) { f64::INFINITY } else { clean[(i, j)] });
    let mut c = Mat::zeros(n, 30);
    atb_into(-2.0, a.as_ref(), b.as_ref(), 0.0, c.as_mut(), &reproducible()).unwrap();
    for j in 0..30 {
        for i in 0..n {
            let right = -2.0 * by_definition(a.as_ref(), b.as_ref(), i, j);
            let close = same(c[(i, j)], right) || (c[(i, j)] - right).abs() < 1e-12;
            assert!(close, "({i}, {j}): {}, not {right}", c[(i, j)]);
        }
    }
}

/// Columns that are infinite throughout, partly, with either sign, beside zeros and NaN, across
/// words of 64 rows: as the definition, whatever the number of threads. The work is one pass over
/// A, and for each pair of columns one over a 64th of their rows: 3000^2 of them took minutes when
/// each term was looked at.
#[test]
fn any_pattern_of_infinities_gives_what_the_definition_gives() {
    for (m, n) in [(1, 1), (63, 5), (64, 9), (65, 17), (200, 40)] {
        for all in [false, true] {
            let mut rng = Rng::new(m as u64);
            let a = Mat::from_fn(m, n, |_, j| {
                let kind = (rng.uniform() * 40.0) as usize;
                match (kind, j % 4) {
                    _ if all => f64::INFINITY,
                    (0, 1 | 2) => f64::INFINITY,
                    (1, 2) => f64::NEG_INFINITY,
                    (2, 3) if j % 8 == 3 => f64::NAN,
                    (3, 0) => 0.0,
                    (4, _) => -0.5,
                    _ => 0.25,
                }
            });
            let one = product(a.as_ref(), &reproducible().threads(1).uplo(Uplo::Both));
            let c = product(a.as_ref(), &reproducible().threads(3).uplo(Uplo::Both));
            assert_eq!(bits(c.as_ref()), bits(one.as_ref()));
            for (i, j) in (0..n).flat_map(|i| (0..n).map(move |j| (i, j))) {
                let right = by_definition(a.as_ref(), a.as_ref(), i, j);
                let close = c[(i, j)] == right || same(c[(i, j)], right);
                assert!(close, "({i}, {j}): {}, not {right}", c[(i, j)]);
            }
        }
    }
}

#[test]
#[ignore = "long: scripts/test --long"]
fn a_large_product_of_infinities_is_infinite() {
    let a = Mat::from_fn(3000, 3000, |_, _| f64::INFINITY);
    let c = product(a.as_ref(), &reproducible());
    assert!(c[(2999, 0)] == f64::INFINITY && c[(2999, 2999)] == f64::INFINITY);
}

#[test]
fn alpha_zero_does_not_look_at_a() {
    let a = Mat::from_fn(10, 4, |_, _| f64::NAN);
    let mut c = Mat::from_fn(4, 4, |i, j| (i * j) as f64);
    ata_into(0.0, a.as_ref(), 2.0, c.as_mut(), &reproducible()).unwrap();
    assert_eq!(c, Mat::from_fn(4, 4, |i, j| 2.0 * (i * j) as f64));
}

#[test]
fn columns_of_any_size_are_as_exact_as_others() {
    // Powers of two from the subnormal to the largest, and zeros: products are exact where they are
    // numbers.
    let exponents = [-1074, -1060, -1030, -600, -537, -1, 0, 30, 500, 511, 1000];
    let (m, n) = (9, exponents.len() + 1);
    let integers = crate::common::integers::<f64>(m, n, 11);
    let power = |e: i32| f64::from(e / 2).exp2() * f64::from(e - e / 2).exp2();
    let a =
        Mat::from_fn(m, n, |i, j| exponents.get(j).map_or(0.0, |&e| integers[(i, j)] * power(e)));
    let c = product(a.as_ref(), &reproducible());
    for j in 0..n {
        for i in 0..n {
            let sum: f64 = (0..m).map(|k| integers[(k, i)] * integers[(k, j)]).sum();
            let right = match (exponents.get(i), exponents.get(j)) {
                (Some(p), Some(q)) => {
                    let e = p + q;
                    // Three factors: half of -2148 is no exponent.
                    sum * power(e / 2) * power(e - e / 2)
                }
                _ => 0.0,
            };
            assert_eq!(
                c[(i, j)],
                right,
                "columns of 2^{:?} and 2^{:?}",
                exponents.get(i),
                exponents.get(j)
            );
        }
    }
}

#[test]
fn a_huge_range_inside_a_column_is_cut_off_relative_to_its_norm() {
    // Beside 1 an entry of 2^-70 is nothing at 55 bits; beside its like it counts.
    let (m, small) = (64, 2f64.powi(-70));
    let a = Mat::from_fn(m, 3, |i, j| match (i, j) {
        (0, 0) => 1.0,
        (_, 0) | (_, 1) => small,
        _ => 1.0,
    });
    let c = product(a.as_ref(), &reproducible());
    let norms: Vec<f64> = (0..3).map(|j| c[(j, j)].sqrt()).collect();
    for j in 0..3 {
        for i in 0..3 {
            let right = by_definition(a.as_ref(), a.as_ref(), i, j);
            let error = (c[(i, j)] - right).abs() / (norms[i] * norms[j]);
            assert!(error <= 1.7e-16, "({i}, {j}): {error:e}");
        }
    }
    assert_eq!(c[(1, 1)], m as f64 * small * small);
}

#[test]
fn sums_of_more_rows_than_32_bits_hold_are_right() {
    // All residues are those of one number: sums grow as fast as they can.
    let most = (1 << 17) - 64;
    for m in [most - 1, most, most + 1, 1 << 17, 2 * most + 1] {
        let (x, y) = (-(2f64.powi(40)) + 1.0, 12345.0);
        let a = Mat::from_fn(m, 2, |_, j| if j == 0 { x } else { y });
        let c = product(a.as_ref(), &reproducible());
        let right = |p: f64, q: f64| (m as i128 * p as i128 * q as i128) as f64;
        for (i, p) in [x, y].into_iter().enumerate() {
            for (j, q) in [x, y].into_iter().enumerate() {
                let relative = (c[(i, j)] / right(p, q) - 1.0).abs();
                assert!(relative <= 2.3e-16, "{m} rows, ({i}, {j}): {relative:e}");
            }
        }
    }
}

#[test]
fn results_beyond_the_range_are_infinite_and_those_below_it_zero() {
    for m in [1, 130] {
        let a = Mat::from_fn(m, 3, |_, j| [f64::MAX, f64::MIN_POSITIVE, 1.0][j]);
        let c = product(a.as_ref(), &reproducible());
        assert_eq!(c[(0, 0)], f64::INFINITY);
        assert_eq!(c[(1, 1)], 0.0);
        assert_eq!(c[(2, 2)], m as f64);
        let middle = m as f64 * (f64::MAX * f64::MIN_POSITIVE);
        assert!((c[(1, 0)] / middle - 1.0).abs() <= 2.3e-16, "{} for {middle}", c[(1, 0)]);
        // The norm of the first column is no f64 for m = 130; its product with the last one may be.
        let expected = m as f64 * f64::MAX;
        assert!(c[(2, 0)] == expected || (c[(2, 0)] / expected - 1.0).abs() <= 2.3e-16);
    }
}

/// The largest error of `A^T B`, relative to the norms of the columns, against sums in
/// double-double.
fn error<T: BlasReal>(a: &Mat<T>, b: &Mat<T>, c: &Mat<T>) -> f64 {
    let dot = |(a, i): (&Mat<T>, usize), (b, j): (&Mat<T>, usize)| {
        let (mut high, mut low) = (0.0_f64, 0.0_f64);
        for k in 0..a.nrows() {
            let (x, y) = (a[(k, i)].to_f64(), b[(k, j)].to_f64());
            let product = x * y;
            let sum = high + product;
            let part = sum - high;
            low += (high - (sum - part)) + (product - part) + x.mul_add(y, -product);
            high = sum;
        }
        (high, low)
    };
    let norms =
        |a: &Mat<T>| -> Vec<f64> { (0..a.ncols()).map(|j| dot((a, j), (a, j)).0.sqrt()).collect() };
    let (norms_a, norms_b) = (norms(a), norms(b));
    let mut largest = 0.0_f64;
    for j in 0..b.ncols() {
        for i in 0..a.ncols() {
            let (high, low) = dot((a, i), (b, j));
            let difference = (c[(i, j)].to_f64() - high) - low;
            largest = largest.max(difference.abs() / (norms_a[i] * norms_b[j]));
        }
    }
    largest
}

fn check_errors<T: BlasReal>(limits: [f64; 3]) {
    for (m, n) in [(40, 30), (1000, 60)] {
        let mut rng = Rng::new(9);
        let graded = gaussian::<T>(m, n, 3);
        let inputs = [
            uniform::<T>(m, n, 1),
            gaussian::<T>(m, n, 2),
            Mat::from_fn(m, n, |i, j| {
                graded[(i, j)] * T::from_f64(f64::from(j as i32 - 20).exp2())
            }),
            Mat::from_fn(m, n, |_, _| {
                T::from_f64((rng.uniform() - 0.5) * (4.0 * rng.normal()).exp())
            }),
        ];
        for (kind, a) in inputs.iter().enumerate() {
            let classical =
                AtaOptions::new().scheme(SchemeChoice::Classical).accuracy(Accuracy::Classical);
            let classical = error(a, a, &product(a.as_ref(), &classical.uplo(Uplo::Both)));
            let accuracies = [Accuracy::Fast, Accuracy::Default, Accuracy::Max];
            for (accuracy, limit) in accuracies.into_iter().zip(limits) {
                let options = reproducible().accuracy(accuracy);
                let error = error(a, a, &product(a.as_ref(), &options));
                assert!(error <= limit, "input {kind}, {accuracy:?}: {error:e}");
                if accuracy != Accuracy::Fast {
                    assert!(error <= classical, "input {kind}: {error:e}, classical {classical:e}");
                }
            }
        }
    }
}

#[test]
fn errors_stay_within_the_bounds_of_each_accuracy() {
    let u = f64::EPSILON / 2.0;
    check_errors::<f64>([u + 2.6e-15, u + 1.9e-16, u + 1.3e-17]);
    let u = f64::from(f32::EPSILON) / 2.0;
    check_errors::<f32>([u + 4.5e-7, u + 2.9e-8, u + 1.9e-9]);
}

/// Entries of a general product are far below the norms of its columns, and so are the errors of
/// the classical one.
fn check_errors_of_general_products<T: BlasReal>() {
    let (m, n, k) = (4000, 40, 30);
    for (a, b) in [
        (uniform::<T>(m, n, 1), uniform::<T>(m, k, 2)),
        (gaussian::<T>(m, n, 3), gaussian::<T>(m, k, 4)),
    ] {
        let error = |scheme| {
            let options = AtaOptions::new().scheme(scheme);
            let mut c = Mat::from_fn(n, k, |_, _| T::ZERO);
            atb_into(T::ONE, a.as_ref(), b.as_ref(), T::ZERO, c.as_mut(), &options).unwrap();
            error(&a, &b, &c)
        };
        let (exact, classical) = (error(SchemeChoice::Exact), error(SchemeChoice::Classical));
        assert!(2.0 * exact <= classical, "{exact:e}, classical {classical:e}");
    }
}

#[test]
fn general_products_have_half_the_error_of_classical_ones_by_default() {
    check_errors_of_general_products::<f64>();
    check_errors_of_general_products::<f32>();
}

#[test]
fn accuracy_max_is_the_exact_path_and_classical_is_not() {
    let plan = |accuracy| {
        let options = AtaOptions::new().accuracy(accuracy);
        Plan::ata::<f64>(500, 400, &options).unwrap()
    };
    assert!(plan(Accuracy::Max).is_exact());
    assert!(!plan(Accuracy::Classical).is_exact());
    let named = AtaOptions::new().scheme(SchemeChoice::Exact);
    for ([m, n, k], way) in [([5000, 400, 300], "modulo 8 numbers"), ([5, 4, 3], "integers")] {
        let plan = Plan::atb::<f32>(m, n, k, &named).unwrap();
        assert!(plan.is_exact() && !plan.is_fast());
        let text = plan.to_string();
        assert!(text.contains(way) && text.contains(IntegerIsa::best().name()), "{text}");
    }
}

#[test]
fn without_amx_the_planner_takes_the_exact_path_only_when_asked() {
    let automatic = Plan::ata::<f64>(4096, 4096, &AtaOptions::default()).unwrap();
    assert_eq!(automatic.is_exact(), IntegerIsa::best() == IntegerIsa::Amx);
}

#[test]
fn no_other_scheme_is_reproducible() {
    for (name, scheme) in SchemeChoice::NAMES {
        let options = reproducible().scheme(scheme);
        let mut c = Mat::<f64>::zeros(3, 3);
        let result = ata_into(1.0, Mat::ones(4, 3).as_ref(), 0.0, c.as_mut(), &options);
        match scheme {
            SchemeChoice::Auto | SchemeChoice::Exact => assert_eq!(result, Ok(()), "{name}"),
            _ => assert!(matches!(result, Err(Error::Argument { what: "scheme", .. })), "{name}"),
        }
    }
}

#[test]
fn it_can_be_cancelled_and_tells_how_far_it_is() {
    use std::ops::ControlFlow;
    use std::sync::Mutex;
    let a = uniform::<f64>(500, 300, 3);
    let told = Mutex::new(Vec::new());
    let listen = |fraction: f64| {
        told.lock().unwrap().push(fraction);
        ControlFlow::Continue(())
    };
    product(a.as_ref(), &reproducible().progress(&listen).par(Par::Seq));
    let told = told.into_inner().unwrap();
    assert!(told.len() > 2 && told.is_sorted() && told.last() == Some(&1.0), "{told:?}");
    let stop = |_: f64| ControlFlow::Break(());
    let mut c = Mat::zeros(300, 300);
    let options = reproducible().progress(&stop);
    assert_eq!(ata_into(1.0, a.as_ref(), 0.0, c.as_mut(), &options), Err(Error::Cancelled));
}
