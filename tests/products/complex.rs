//! A^H A and A^H B of complex matrices, against integers, double-double and faer.

use std::ops::ControlFlow;
use std::sync::Mutex;

use catamaran::base::{Pin, Rng};
use catamaran::blas::BlasReal;
use catamaran::faer::complex::Complex;
use catamaran::faer::{Mat, MatMut, MatRef, Scale, c32, c64};
use catamaran::product::{ComplexPlan, aha_planned, ahb_planned};
use catamaran::{
    Accuracy, AtaOptions, Error, Par, SchemeChoice, Uplo, aha, aha_into, ahb, ahb_into,
};

use crate::common::{AWKWARD, backends, bits};

const UPLOS: [Uplo; 3] = [Uplo::Lower, Uplo::Upper, Uplo::Both];

fn schemes() -> impl Iterator<Item = SchemeChoice> {
    SchemeChoice::NAMES.into_iter().map(|(_, scheme)| scheme)
}

/// Options that recurse on shapes of a few dozen.
fn deep(scheme: SchemeChoice) -> AtaOptions<'static> {
    AtaOptions::new().scheme(scheme).leaf(8).accuracy(Accuracy::Fast).threads(2)
}

fn complex<T: BlasReal>(re: f64, im: f64) -> Complex<T> {
    Complex { re: T::from_f64(re), im: T::from_f64(im) }
}

fn zeros<T: BlasReal>(n: usize, k: usize) -> Mat<Complex<T>> {
    Mat::from_fn(n, k, |_, _| complex(0.0, 0.0))
}

/// Gaussian integers so small that all sums of their products are exact, in f32 too.
fn integers<T: BlasReal>(m: usize, n: usize, seed: u64) -> Mat<Complex<T>> {
    let mut rng = Rng::new(seed);
    let mut part = || (rng.uniform() * 9.0).floor() - 4.0;
    Mat::from_fn(m, n, |_, _| complex(part(), part()))
}

fn gaussian<T: BlasReal>(m: usize, n: usize, seed: u64) -> Mat<Complex<T>> {
    let mut rng = Rng::new(seed);
    Mat::from_fn(m, n, |_, _| complex(rng.normal(), rng.normal()))
}

/// Entry (i, j) of `A^H B` for Gaussian integers, in integers.
fn dot<T: BlasReal>(
    a: MatRef<'_, Complex<T>>,
    b: MatRef<'_, Complex<T>>,
    i: usize,
    j: usize,
) -> [i64; 2] {
    let parts = |z: &Complex<T>| [z.re.to_f64() as i64, z.im.to_f64() as i64];
    a.col(i).iter().zip(b.col(j).iter()).fold([0, 0], |[re, im], (a, b)| {
        let ([x, y], [u, v]) = (parts(a), parts(b));
        [re + x * u + y * v, im + x * v - y * u]
    })
}

/// `s z` for Gaussian integers.
fn product([a, b]: [i64; 2], [c, d]: [i64; 2]) -> [i64; 2] {
    [a * c - b * d, a * d + b * c]
}

fn assert_equal<T: BlasReal>(got: Complex<T>, right: [i64; 2], context: impl Fn() -> String) {
    let got = [got.re.to_f64(), got.im.to_f64()];
    assert_eq!(got, right.map(|x| x as f64), "{}", context());
}

/// The bits of both parts of every entry.
fn all_bits<T: BlasReal>(c: MatRef<'_, Complex<T>>) -> [Vec<u64>; 2] {
    let part = |of: fn(Complex<T>) -> T| {
        bits(Mat::from_fn(c.nrows(), c.ncols(), |i, j| of(c[(i, j)])).as_ref())
    };
    [part(|z| z.re), part(|z| z.im)]
}

/// Checks `aha` with a C that is not a number wherever it is not to be read.
fn check_aha<T: BlasReal>(a: MatRef<'_, Complex<T>>, uplo: Uplo, options: &AtaOptions<'_>) {
    let n = a.ncols();
    let nan = complex::<T>(f64::NAN, f64::NAN);
    let wanted = |i: usize, j: usize| match uplo {
        Uplo::Lower => i >= j,
        Uplo::Upper => i <= j,
        Uplo::Both => true,
    };
    // With both, the old lower triangle is what is read.
    let read = |i: usize, j: usize| wanted(i, j) && (uplo != Uplo::Both || i >= j);
    let old = integers::<T>(n, n, 77);
    for (alpha, beta) in [(1, 0), (-2, 1), (3, -2)] {
        let mut c = Mat::from_fn(n, n, |i, j| match (read(i, j) && beta != 0, i == j) {
            (false, _) => nan,
            // Imaginary parts of the diagonal are not read either.
            (true, true) => Complex { im: T::from_f64(f64::NAN), ..old[(i, j)] },
            (true, false) => old[(i, j)],
        });
        let options = options.clone().uplo(uplo);
        let factor = |x: i64| T::from_f64(x as f64);
        aha_into(factor(alpha), a, factor(beta), c.as_mut(), &options).unwrap();
        for (i, j) in (0..n).flat_map(|i| (0..n).map(move |j| (i, j))) {
            let context = || format!("{:?} {uplo:?} {}x{n} ({i}, {j})", options.scheme, a.nrows());
            if !wanted(i, j) {
                assert!(c[(i, j)].re.to_f64().is_nan(), "written: {}", context());
                continue;
            }
            let [re, im] = dot(a, a, i, j);
            let mirrored = !read(i, j);
            let kept = if mirrored { old[(j, i)] } else { old[(i, j)] };
            let sign = if mirrored { -1 } else { 1 };
            let kept = [kept.re.to_f64() as i64, sign * kept.im.to_f64() as i64];
            let im = if i == j { 0 } else { alpha * im + beta * kept[1] };
            assert_equal(c[(i, j)], [alpha * re + beta * kept[0], im], context);
        }
    }
}

#[test]
fn every_scheme_is_exact_on_gaussian_integers_of_awkward_sizes() {
    for scheme in schemes() {
        for m in [0, 1, 3, 31, 65] {
            for (n, uplo) in AWKWARD.into_iter().zip(UPLOS.into_iter().cycle()) {
                check_aha(integers::<f64>(m, n, 1).as_ref(), uplo, &deep(scheme));
            }
        }
    }
}

#[test]
fn every_triangle_of_every_scheme_back_end_and_precision_is_right() {
    for (backend, scheme) in
        backends().into_iter().flat_map(|b| schemes().map(move |s| (b.clone(), s)))
    {
        for uplo in UPLOS {
            let options = deep(scheme).backend(backend.clone());
            check_aha(integers::<f64>(41, 139, 2).as_ref(), uplo, &options);
            check_aha(integers::<f32>(90, 37, 3).as_ref(), uplo, &options);
        }
    }
}

#[test]
fn every_accuracy_and_the_reproducible_way_are_exact_on_gaussian_integers() {
    use Accuracy::{Bounded, Classical, Default, Fast, Max};
    let a = integers::<f64>(75, 66, 4);
    for accuracy in [Max, Classical, Bounded(1.0), Bounded(20.0), Default, Fast] {
        for uplo in UPLOS {
            let options = AtaOptions::new().accuracy(accuracy);
            check_aha(a.as_ref(), uplo, &options);
            check_aha(a.as_ref(), uplo, &options.reproducible(true));
        }
    }
}

#[test]
fn more_rows_than_a_block_are_summed_block_by_block() {
    // 64 MiB hold 381300 rows of 11 columns, in two parts, and 254200 in three.
    let a = integers::<f64>(400_003, 11, 5);
    for scheme in [SchemeChoice::Auto, SchemeChoice::Exact] {
        let options = AtaOptions::new().scheme(scheme).uplo(Uplo::Both);
        let mut c = zeros(11, 11);
        aha_into(1.0, a.as_ref(), 0.0, c.as_mut(), &options).unwrap();
        let mut d = zeros(11, 2);
        let b = a.as_ref().subcols(3, 2);
        ahb_into(complex(1.0, 0.0), a.as_ref(), b, complex(0.0, 0.0), d.as_mut(), &options)
            .unwrap();
        for i in 0..11 {
            for j in 0..=i {
                let [re, im] = dot(a.as_ref(), a.as_ref(), i, j);
                assert_equal(c[(i, j)], [re, im], || format!("({i}, {j})"));
                assert_equal(c[(j, i)], [re, -im], || format!("({j}, {i})"));
            }
            for j in 3..5 {
                assert_eq!(d[(i, j - 3)], c[(i, j)]);
            }
        }
    }
}

#[test]
fn ahb_is_exact_on_gaussian_integers_with_complex_factors() {
    for scheme in schemes() {
        for m in [0, 1, 16, 31, 65] {
            for (n, k) in [(0, 3), (1, 1), (7, 31), (31, 7), (65, 64), (40, 1)] {
                let (a, b) = (integers::<f64>(m, n, 6), integers::<f64>(m, k, 7));
                for (alpha, beta) in [([2, -1], [0, 0]), ([1, 0], [1, 0]), ([0, 3], [-1, 2])] {
                    let old = integers::<f64>(n, k, 8);
                    let nan = complex(f64::NAN, f64::NAN);
                    let zero = beta == [0, 0];
                    let mut c = Mat::from_fn(n, k, |i, j| if zero { nan } else { old[(i, j)] });
                    let factor = |s: [i64; 2]| complex(s[0] as f64, s[1] as f64);
                    let (av, bv) = (a.as_ref(), b.as_ref());
                    let options = deep(scheme);
                    ahb_into(factor(alpha), av, bv, factor(beta), c.as_mut(), &options).unwrap();
                    for (i, j) in (0..n).flat_map(|i| (0..k).map(move |j| (i, j))) {
                        let new = product(alpha, dot(av, bv, i, j));
                        let kept = [old[(i, j)].re as i64, old[(i, j)].im as i64];
                        let kept = product(beta, kept);
                        let right = [new[0] + kept[0], new[1] + kept[1]];
                        let context = || format!("{scheme:?} {m} {n} {k} ({i}, {j})");
                        assert_equal(c[(i, j)], right, context);
                    }
                }
            }
        }
    }
}

#[test]
fn any_strides_are_taken() {
    let wide = integers::<f64>(60, 80, 9);
    // SAFETY: rows 0, 2, 4, ... of `wide` lie inside it.
    let every_second_row = unsafe {
        MatRef::from_raw_parts(wide.as_ptr(), 30, 80, 2 * wide.row_stride(), wide.col_stride())
    };
    let views = [
        wide.transpose(),
        wide.as_ref().submatrix(3, 5, 40, 30),
        wide.as_ref().reverse_rows(),
        wide.as_ref().reverse_cols().transpose(),
        wide.as_ref().reverse_rows_and_cols(),
        every_second_row,
    ];
    let options = AtaOptions::new();
    for view in views {
        for scheme in [SchemeChoice::Auto, SchemeChoice::Exact] {
            check_aha(view, Uplo::Lower, &options.clone().scheme(scheme));
        }
        let b = integers::<f64>(view.nrows(), 7, 10);
        let mut c = zeros::<f64>(7, view.ncols());
        let (one, zero) = (complex(1.0, 0.0), complex(0.0, 0.0));
        let turned = c.as_mut().transpose_mut().reverse_rows_mut();
        ahb_into(one, view, b.as_ref(), zero, turned, &options).unwrap();
        for i in 0..view.ncols() {
            for j in 0..7 {
                let right = dot(view, b.as_ref(), view.ncols() - 1 - i, j);
                assert_equal(c[(j, i)], right, || format!("({i}, {j})"));
            }
        }
    }
}

#[test]
fn c_may_have_any_strides() {
    let a = integers::<f64>(30, 20, 11);
    for uplo in UPLOS {
        for (row_stride, col_stride) in [(100, 3), (3, 100), (-3, 100), (100, -1)] {
            let nothing = complex::<f64>(0.5, 0.5);
            let mut memory = vec![nothing; 4000];
            // SAFETY: 20 x 20 entries, with strides of either sign, are within 2000 of the middle.
            let c = unsafe {
                let start = memory.as_mut_ptr().add(if col_stride < 0 { 30 } else { 60 });
                MatMut::from_raw_parts_mut(start, 20, 20, row_stride, col_stride)
            };
            aha_into(1.0, a.as_ref(), 0.0, c, &AtaOptions::new().uplo(uplo)).unwrap();
            let mut written = 0;
            for (i, j) in (0..20).flat_map(|i| (0..20).map(move |j| (i, j))) {
                let start = if col_stride < 0 { 30 } else { 60 };
                let at = start + i as isize * row_stride + j as isize * col_stride;
                let wanted = match uplo {
                    Uplo::Lower => i >= j,
                    Uplo::Upper => i <= j,
                    Uplo::Both => true,
                };
                if wanted {
                    written += 1;
                    let right = dot(a.as_ref(), a.as_ref(), i, j);
                    assert_equal(memory[at as usize], right, || format!("{uplo:?} ({i}, {j})"));
                }
            }
            let untouched = memory.iter().filter(|&&z| z == nothing).count();
            assert_eq!(untouched, 4000 - written);
        }
    }
}

#[test]
fn both_triangles_are_conjugates_bit_for_bit_and_the_diagonal_is_real() {
    for scheme in schemes() {
        let a = gaussian::<f32>(150, 231, 12);
        let mut c = zeros(231, 231);
        let options = deep(scheme).uplo(Uplo::Both).leaf(16);
        aha_into(1.5, a.as_ref(), 0.0, c.as_mut(), &options).unwrap();
        aha_into(-0.3, a.as_ref(), 0.7, c.as_mut(), &options).unwrap();
        for (i, j) in (0..231).flat_map(|i| (0..i).map(move |j| (i, j))) {
            let (below, above): (c32, c32) = (c[(i, j)], c[(j, i)]);
            assert_eq!(below.re.to_bits(), above.re.to_bits());
            assert_eq!(below.im.to_bits(), (-above.im).to_bits(), "{scheme:?} ({i}, {j})");
        }
        assert!((0..231).all(|i| c[(i, i)].im.to_bits() == 0 && c[(i, i)].re > 0.0));
    }
}

#[test]
fn results_are_bitwise_equal_for_any_number_of_threads() {
    for scheme in schemes() {
        for (m, n) in [(300, 120), (3000, 24)] {
            let (a, b) = (gaussian::<f64>(m, n, 13), gaussian::<f64>(m, 23, 14));
            let run = |options: AtaOptions<'_>| {
                let options = options.uplo(Uplo::Both).leaf(32);
                let (mut c, mut d) = (zeros(n, n), gaussian(n, 23, 15));
                aha_into(1.0, a.as_ref(), 0.0, c.as_mut(), &options).unwrap();
                let (alpha, beta) = (c64::new(0.3, -1.0), c64::new(0.7, 0.1));
                ahb_into(alpha, a.as_ref(), b.as_ref(), beta, d.as_mut(), &options).unwrap();
                (all_bits(c.as_ref()), all_bits(d.as_ref()))
            };
            let sequential = run(deep(scheme).par(Par::Seq));
            for threads in [2, 5] {
                assert!(run(deep(scheme).threads(threads)) == sequential, "{scheme:?} {threads}");
            }
            assert!(run(deep(scheme).pin(Pin::Cores)) == sequential, "{scheme:?} pinned");
        }
    }
}

/// Both parts of the dot product in double-double, to about 2^-100 of the sum of their terms.
fn exact_dot<T: BlasReal>(
    a: MatRef<'_, Complex<T>>,
    b: MatRef<'_, Complex<T>>,
    i: usize,
    j: usize,
) -> [(f64, f64); 2] {
    let add = |(high, low): (f64, f64), x: f64, y: f64| {
        let product = x * y;
        let sum = high + product;
        let part = sum - high;
        let lost = (high - (sum - part)) + (product - part) + x.mul_add(y, -product);
        (sum, low + lost)
    };
    let mut sums = [(0.0, 0.0); 2];
    for (a, b) in a.col(i).iter().zip(b.col(j).iter()) {
        let [x, y, u, v] = [a.re, a.im, b.re, b.im].map(|x| x.to_f64());
        sums[0] = add(add(sums[0], x, u), y, v);
        sums[1] = add(add(sums[1], x, v), -y, u);
    }
    sums
}

/// The largest error of a part of `C = A^H B`, relative to the norms of the columns.
fn error<T: BlasReal>(
    a: MatRef<'_, Complex<T>>,
    b: MatRef<'_, Complex<T>>,
    c: MatRef<'_, Complex<T>>,
) -> f64 {
    let norms = |a: MatRef<'_, Complex<T>>| -> Vec<f64> {
        (0..a.ncols()).map(|j| exact_dot(a, a, j, j)[0].0.sqrt()).collect()
    };
    let (of_a, of_b) = (norms(a), norms(b));
    let mut largest = 0.0_f64;
    for (i, of_a) in of_a.iter().enumerate() {
        for (j, of_b) in of_b.iter().enumerate() {
            let parts = [c[(i, j)].re, c[(i, j)].im];
            for (part, (high, low)) in parts.into_iter().zip(exact_dot(a, b, i, j)) {
                largest = largest.max(((part.to_f64() - high) - low).abs() / (of_a * of_b));
            }
        }
    }
    largest
}

/// The errors of `aha` and of `ahb`.
fn errors<T: BlasReal>(
    a: MatRef<'_, Complex<T>>,
    b: MatRef<'_, Complex<T>>,
    options: &AtaOptions<'_>,
) -> [f64; 2] {
    let options = options.clone().uplo(Uplo::Both);
    let (mut c, mut d) = (zeros(a.ncols(), a.ncols()), zeros(a.ncols(), b.ncols()));
    aha_into(T::ONE, a, T::ZERO, c.as_mut(), &options).unwrap();
    ahb_into(complex(1.0, 0.0), a, b, complex(0.0, 0.0), d.as_mut(), &options).unwrap();
    [error(a, a, c.as_ref()), error(a, b, d.as_ref())]
}

fn check_errors<T: BlasReal>(max: f64) {
    for (m, n) in [(40, 30), (1000, 60)] {
        let graded = gaussian::<T>(m, n, 16);
        let scale = |j: usize| T::from_f64(f64::from(j as i32 - 20).exp2());
        let inputs = [
            gaussian::<T>(m, n, 17),
            Mat::from_fn(m, n, |i, j| {
                let z = graded[(i, j)];
                Complex { re: z.re * scale(j), im: z.im * scale(j) }
            }),
            // Imaginary parts are far below the real ones: Karatsuba would lose them.
            Mat::from_fn(m, n, |i, j| Complex {
                re: graded[(i, j)].re,
                im: graded[(i, j)].im * scale(0),
            }),
        ];
        let b = gaussian::<T>(m, 23, 18);
        for (kind, a) in inputs.iter().enumerate() {
            let bound = 8.0 * m as f64 * T::UNIT_ROUNDOFF;
            for scheme in [SchemeChoice::Auto, SchemeChoice::Float, SchemeChoice::Classical] {
                let options = AtaOptions::new().scheme(scheme).leaf(16);
                let found = errors(a.as_ref(), b.as_ref(), &options);
                assert!(found.iter().all(|e| *e <= bound), "{kind} {scheme:?}: {found:?}");
            }
            let options = AtaOptions::new().accuracy(Accuracy::Max);
            let found = errors(a.as_ref(), b.as_ref(), &options);
            assert!(found.iter().all(|e| *e <= max), "{kind}, exact: {found:?}");
        }
    }
}

#[test]
fn errors_stay_within_the_stated_bounds() {
    // Those of `Accuracy::Max`: one rounding, and a few percent.
    check_errors::<f64>(1.05 * f64::EPSILON / 2.0);
    check_errors::<f32>(1.05 * f64::from(f32::EPSILON) / 2.0);
}

#[test]
#[ignore = "long: scripts/test --long"]
fn errors_of_blocks_of_rows_add_up_to_a_rounding_for_each() {
    let a = gaussian::<f64>(400_003, 11, 19);
    let options = AtaOptions::new().accuracy(Accuracy::Max);
    let found = errors(a.as_ref(), a.as_ref().subcols(0, 2), &options);
    assert!(found.iter().all(|e| *e <= 3.0 * f64::EPSILON / 2.0), "{found:?}");
}

#[test]
fn small_imaginary_parts_keep_their_digits() {
    // X is of size 1, Y of 1e-12: terms of the imaginary part are 1e-12 of those of the real one.
    let noise = gaussian::<f64>(200, 40, 20);
    let a = Mat::from_fn(200, 40, |i, j| c64::new(noise[(i, j)].re, 1e-12 * noise[(i, j)].im));
    let mut c = zeros(40, 40);
    let options = AtaOptions::new().scheme(SchemeChoice::Classical);
    aha_into(1.0, a.as_ref(), 0.0, c.as_mut(), &options).unwrap();
    for (i, j) in (0..40).flat_map(|i| (0..i).map(move |j| (i, j))) {
        let (high, low) = exact_dot(a.as_ref(), a.as_ref(), i, j)[1];
        let error = ((c[(i, j)].im - high) - low).abs();
        assert!(error <= 1e-12 * 800.0 * f64::EPSILON, "({i}, {j}): {error:e}");
    }
}

#[test]
fn the_exact_path_cancels_imaginary_parts_before_it_rounds() {
    // A = (1 + 2 i) G with a real G: A^H A is real.
    let g = gaussian::<f64>(300, 40, 21);
    let a = Mat::from_fn(300, 40, |i, j| c64::new(g[(i, j)].re, 2.0 * g[(i, j)].re));
    let mut c = zeros(40, 40);
    let options = AtaOptions::new().accuracy(Accuracy::Max);
    aha_into(1.0, a.as_ref(), 0.0, c.as_mut(), &options).unwrap();
    for (i, j) in (0..40).flat_map(|i| (0..=i).map(move |j| (i, j))) {
        let norms = (c[(i, i)].re * c[(j, j)].re).sqrt();
        assert!(c[(i, j)].im.abs() <= 0.1 * f64::EPSILON * norms, "({i}, {j}): {}", c[(i, j)]);
    }
}

#[test]
fn products_agree_with_those_of_faer() {
    let (a, b) = (gaussian::<f64>(120, 50, 22), gaussian::<f64>(120, 31, 23));
    let (mut c, mut d) = (zeros(50, 50), zeros(50, 31));
    let options = AtaOptions::new().uplo(Uplo::Both);
    aha_into(1.0, a.as_ref(), 0.0, c.as_mut(), &options).unwrap();
    let (alpha, zero) = (c64::new(0.5, 2.0), c64::new(0.0, 0.0));
    ahb_into(alpha, a.as_ref(), b.as_ref(), zero, d.as_mut(), &options).unwrap();
    let difference = (c - a.adjoint() * &a).norm_max();
    assert!(difference < 1e-12, "{difference:e}");
    let difference = (d - Scale(alpha) * (a.adjoint() * &b)).norm_max();
    assert!(difference < 1e-12, "{difference:e}");
}

/// FNV-1a over the bits.
fn checksum<T: BlasReal>(c: MatRef<'_, Complex<T>>) -> u64 {
    let step = |hash: u64, byte: u8| (hash ^ u64::from(byte)).wrapping_mul(0x100_0000_01b3);
    let bytes = all_bits(c).into_iter().flatten().flat_map(u64::to_le_bytes);
    bytes.fold(0xcbf2_9ce4_8422_2325, step)
}

fn golden<T: BlasReal>() -> [u64; 2] {
    let mut rng = Rng::new(42);
    let mut part = || 2.0 * rng.uniform() - 1.0;
    let a = Mat::from_fn(333, 77, |_, _| complex::<T>(part(), part()));
    let options = AtaOptions::new().reproducible(true).uplo(Uplo::Both);
    let (mut c, mut d) = (zeros(77, 77), zeros(77, 33));
    aha_into(T::from_f64(0.3), a.as_ref(), T::ZERO, c.as_mut(), &options).unwrap();
    let b = a.as_ref().subcols(11, 33);
    ahb_into(complex(0.3, 0.7), a.as_ref(), b, complex(0.0, 0.0), d.as_mut(), &options).unwrap();
    // The bytes do not depend on layouts either.
    let by_rows = a.transpose().to_owned();
    let mut again = zeros(77, 77);
    let turned = again.as_mut().transpose_mut();
    aha_into(T::from_f64(0.3), by_rows.transpose(), T::ZERO, turned, &options).unwrap();
    assert_eq!(all_bits(again.transpose()), all_bits(c.as_ref()));
    [checksum(c.as_ref()), checksum(d.as_ref())]
}

/// A machine with another instruction set must find these numbers too.
#[test]
fn every_machine_finds_the_same_bytes() {
    let found = [golden::<f64>(), golden::<f32>()];
    println!("{found:#018x?}");
    assert_eq!(found, GOLDEN);
}

/// f64, then f32; of `aha`, then of `ahb`.
const GOLDEN: [[u64; 2]; 2] = [
    [0x367f_611d_58f8_5249, 0x8561_4e36_5d7f_cab7],
    [0x1062_989b_96d5_e9a4, 0x756e_2056_ab06_23cf],
];

#[test]
fn nan_and_infinities_do_what_they_do_term_by_term() {
    let (m, n) = (100, 30);
    let mut a = integers::<f64>(m, n, 24);
    a[(3, 2)].re = f64::NAN;
    a[(5, 4)].im = f64::INFINITY;
    a[(6, 9)].re = f64::NEG_INFINITY;
    a[(6, 9)].im = f64::INFINITY;
    a[(70, 20)] = c64::new(0.0, 0.0);
    a[(70, 23)].re = f64::INFINITY;
    let by_definition = |i: usize, j: usize| {
        let term = |k: usize| {
            let (a, b) = (a[(k, i)], a[(k, j)]);
            [a.re * b.re, a.im * b.im, a.re * b.im, -(a.im * b.re)]
        };
        (0..m).map(term).fold([0.0, 0.0], |[re, im], [p, q, r, s]| [re + p + q, im + r + s])
    };
    let same = |x: f64, y: f64| x == y || x.is_nan() && y.is_nan();
    for scheme in [SchemeChoice::Classical, SchemeChoice::Exact] {
        for uplo in UPLOS {
            let mut c = zeros(n, n);
            let options = AtaOptions::new().scheme(scheme).uplo(uplo);
            aha_into(1.0, a.as_ref(), 0.0, c.as_mut(), &options).unwrap();
            let mut d = zeros(n, n);
            let (one, zero) = (c64::new(1.0, 0.0), c64::new(0.0, 0.0));
            ahb_into(one, a.as_ref(), a.as_ref(), zero, d.as_mut(), &options).unwrap();
            for (i, j) in (0..n).flat_map(|i| (0..n).map(move |j| (i, j))) {
                let [re, im] = by_definition(i, j);
                let context = format!("{scheme:?} {uplo:?} ({i}, {j}), {re} {im}");
                let d = d[(i, j)];
                assert!(same(d.re, re) && same(d.im, im), "A^H B {context}: {d}");
                if uplo == Uplo::Both || (uplo == Uplo::Lower) == (i > j) || i == j {
                    let (c, im) = (c[(i, j)], if i == j { 0.0 } else { im });
                    assert!(same(c.re, re) && same(c.im, im), "A^H A {context}: {c}");
                }
            }
        }
    }
}

#[test]
fn alpha_zero_and_no_rows_leave_beta_c() {
    let nan = c64::new(f64::NAN, f64::NAN);
    for (rows, alpha) in [(3, 0.0), (0, f64::NAN)] {
        let a = Mat::full(rows, 70, nan);
        for options in [AtaOptions::new(), AtaOptions::new().reproducible(true)] {
            let old = integers::<f64>(70, 70, 25);
            let mut c = old.clone();
            aha_into(alpha, a.as_ref(), 2.0, c.as_mut(), &options.clone().uplo(Uplo::Both))
                .unwrap();
            for (i, j) in (0..70).flat_map(|i| (0..i).map(move |j| (i, j))) {
                assert_eq!(c[(i, j)], old[(i, j)] * 2.0);
                assert_eq!(c[(j, i)], old[(i, j)].conj() * 2.0);
                assert_eq!(c[(i, i)], c64::new(2.0 * old[(i, i)].re, 0.0));
            }
            let (mut d, beta) = (old.clone(), c64::new(0.0, 1.0));
            let (av, alpha) = (a.as_ref(), c64::new(alpha, alpha));
            ahb_into(alpha, av, av, beta, d.as_mut(), &options).unwrap();
            assert_eq!(d, Mat::from_fn(70, 70, |i, j| c64::new(-old[(i, j)].im, old[(i, j)].re)));
            ahb_into(alpha, av, av, c64::new(0.0, 0.0), d.as_mut(), &options).unwrap();
            assert_eq!(d, zeros(70, 70));
        }
    }
}

#[test]
fn an_infinite_part_stays_in_its_part_when_the_factor_is_real() {
    let a = Mat::full(1, 1, c64::new(f64::MAX, 0.0));
    let b = Mat::full(1, 1, c64::new(2.0, 1.0));
    let (two, zero) = (c64::new(2.0, 0.0), c64::new(0.0, 0.0));
    let mut c = zeros(1, 1);
    ahb_into(two, a.as_ref(), b.as_ref(), zero, c.as_mut(), &AtaOptions::new()).unwrap();
    assert_eq!(c[(0, 0)], c64::new(f64::INFINITY, f64::INFINITY));
    let b = Mat::full(1, 1, c64::new(2.0, 0.0));
    ahb_into(two, a.as_ref(), b.as_ref(), zero, c.as_mut(), &AtaOptions::new()).unwrap();
    assert_eq!(c[(0, 0)], c64::new(f64::INFINITY, 0.0));
}

#[test]
fn wrong_arguments_are_named_and_leave_c_alone() {
    let options = AtaOptions::new();
    let (one, zero) = (c64::new(1.0, 0.0), c64::new(0.0, 0.0));
    let (a, b) = (integers::<f64>(4, 3, 26), integers::<f64>(5, 3, 27));
    let mut c = Mat::full(2, 3, one);
    let found = aha_into(1.0, a.as_ref(), 0.0, c.as_mut(), &options);
    assert_eq!(found, Err(Error::Shape { what: "C", expected: (3, 3), got: (2, 3) }));
    let found = ahb_into(one, a.as_ref(), a.as_ref(), zero, c.as_mut(), &options);
    assert_eq!(found, Err(Error::Shape { what: "C", expected: (3, 3), got: (2, 3) }));
    let found = ahb_into(one, a.as_ref(), b.as_ref(), zero, c.as_mut(), &options);
    assert_eq!(found, Err(Error::Shape { what: "B", expected: (4, 3), got: (5, 3) }));
    let mut c = Mat::full(3, 3, one);
    for rows in [0, 4] {
        let a = a.as_ref().subrows(0, rows);
        let wrong = options.clone().tasks(0);
        let found = aha_into(1.0, a, 0.0, c.as_mut(), &wrong);
        assert!(matches!(found, Err(Error::Argument { what: "tasks", .. })), "{found:?}");
        let wrong = options.clone().scheme(SchemeChoice::Rxtx).reproducible(true);
        let found = ahb_into(one, a, a, zero, c.as_mut(), &wrong);
        assert!(matches!(found, Err(Error::Argument { what: "scheme", .. })), "{found:?}");
    }
    assert_eq!(c, Mat::full(3, 3, one));
}

#[test]
fn progress_never_decreases_and_cancelling_leaves_c_alone() {
    let a = gaussian::<f64>(700, 300, 28);
    let (one, zero) = (c64::new(1.0, 0.0), c64::new(0.0, 0.0));
    type Call<'c> = &'c dyn Fn(MatMut<'_, c64>, &AtaOptions<'_>) -> Result<(), Error>;
    let hermitian: Call<'_> = &|c, options| aha_into(1.0, a.as_ref(), 0.0, c, options);
    let general: Call<'_> = &|c, options| ahb_into(one, a.as_ref(), a.as_ref(), zero, c, options);
    for call in [hermitian, general] {
        for scheme in [SchemeChoice::Auto, SchemeChoice::Kgp4, SchemeChoice::Exact] {
            let told = Mutex::new(Vec::new());
            let listen = |fraction: f64| {
                told.lock().unwrap().push(fraction);
                ControlFlow::Continue(())
            };
            let options = AtaOptions::new().scheme(scheme).threads(2);
            let mut c = zeros(300, 300);
            call(c.as_mut(), &options.clone().progress(&listen)).unwrap();
            let told = told.into_inner().unwrap();
            assert!(told.len() > 2 && told.is_sorted(), "{scheme:?}: {told:?}");
            assert_eq!(told.last(), Some(&1.0));
            for limit in [0.0, 0.6, 1.0] {
                let stop = |fraction: f64| match fraction < limit {
                    true => ControlFlow::Continue(()),
                    false => ControlFlow::Break(()),
                };
                let mut c = Mat::full(300, 300, one);
                let found = call(c.as_mut(), &options.clone().progress(&stop));
                assert_eq!(found, Err(Error::Cancelled));
                assert_eq!(c, Mat::full(300, 300, one));
            }
        }
    }
}

#[test]
fn cancelling_leaves_c_alone_where_it_is_only_scaled() {
    let (one, two, zero) = (complex(1.0, 0.0), complex(2.0, 0.0), complex(0.0, 0.0));
    let stop = |_: f64| ControlFlow::Break(());
    let (options, stopped) = (AtaOptions::new(), AtaOptions::new().progress(&stop));
    for (m, alpha) in [(0, 1.0), (4, 0.0)] {
        let a = zeros::<f64>(m, 3);
        let mut c = Mat::<c64>::full(3, 3, one);
        let hermitian = aha_into(alpha, a.as_ref(), 2.0, c.as_mut(), &stopped);
        let alpha = complex(alpha, 0.0);
        let general = ahb_into(alpha, a.as_ref(), a.as_ref(), two, c.as_mut(), &stopped);
        assert_eq!((hermitian, general), (Err(Error::Cancelled), Err(Error::Cancelled)));
        assert_eq!(c, Mat::full(3, 3, one));
        ahb_into(alpha, a.as_ref(), a.as_ref(), zero, c.as_mut(), &options).unwrap();
        assert_eq!(c, zeros::<f64>(3, 3));
    }
}

#[test]
fn plans_give_transposed_and_conjugated_products_in_blocks_that_memory_allows() {
    let (m, n, k) = (701, 5, 3);
    let (a, b) = (integers::<f64>(m, n, 41), integers::<f64>(m, k, 42));
    let conjugate = |x: &Mat<c64>| Mat::from_fn(x.nrows(), x.ncols(), |i, j| x[(i, j)].conj());
    let (one, zero) = (complex(1.0, 0.0), complex(0.0, 0.0));
    let product = |a: &Mat<c64>, b: &Mat<c64>| {
        Mat::from_fn(a.ncols(), b.ncols(), |i, j| {
            let [re, im] = dot(a.as_ref(), b.as_ref(), i, j);
            complex::<f64>(re as f64, im as f64)
        })
    };
    for memory in [None, Some(1 << 16), Some(1)] {
        let options = AtaOptions::new().memory(memory);
        let ahb = ComplexPlan::ahb::<f64>(m, n, k, &options).unwrap();
        let atb = ComplexPlan::atb::<f64>(m, n, k, &options).unwrap();
        for (plan, conj_a, conj_b) in [
            (&ahb, true, false),
            (&ahb.clone().conjugated(), false, true),
            (&atb, false, false),
            (&atb.clone().conjugated(), true, true),
        ] {
            let left = if conj_a { a.clone() } else { conjugate(&a) };
            let right = if conj_b { conjugate(&b) } else { b.clone() };
            let mut c = Mat::full(n, k, complex(f64::NAN, f64::NAN));
            ahb_planned(plan, one, a.as_ref(), b.as_ref(), zero, c.as_mut(), &options).unwrap();
            assert_eq!(c, product(&left, &right), "{conj_a} {conj_b} {memory:?}");
        }
        let aha = ComplexPlan::aha::<f64>(m, n, &options).unwrap();
        for (plan, left) in [(&aha, a.clone()), (&aha.clone().conjugated(), conjugate(&a))] {
            let mut c = zeros::<f64>(n, n);
            let both = options.clone().uplo(Uplo::Both);
            aha_planned(plan, 1.0, a.as_ref(), 0.0, c.as_mut(), &both).unwrap();
            assert_eq!(c, product(&left, &left), "{memory:?}");
        }
        let bytes = 8 * ahb.scratch_len::<f64>(Par::Threads(2)).max(1);
        assert!(memory != Some(1 << 16) || bytes <= 1 << 16, "{bytes}");
    }
}

#[test]
fn plans_of_other_complex_products_are_refused() {
    let (options, a) = (AtaOptions::new(), integers::<f64>(4, 3, 43));
    let (one, zero) = (complex(1.0, 0.0), complex(0.0, 0.0));
    let run = |plan: &ComplexPlan| {
        let mut c = zeros::<f64>(3, 3);
        ahb_planned(plan, one, a.as_ref(), a.as_ref(), zero, c.as_mut(), &options)
    };
    let plan = ComplexPlan::ahb::<f32>(4, 3, 3, &options).unwrap();
    assert!(matches!(run(&plan), Err(Error::Argument { what: "plan", .. })));
    let plan = ComplexPlan::aha::<f64>(4, 3, &options).unwrap();
    assert!(matches!(run(&plan), Err(Error::Argument { what: "plan", .. })));
    let plan = ComplexPlan::ahb::<f64>(5, 3, 3, &options).unwrap();
    assert!(matches!(run(&plan), Err(Error::Shape { what: "A", .. })));
}

#[test]
fn complex_products_in_a_new_matrix_are_those_of_the_default_options() {
    let (a, b) = (integers::<f32>(20, 6, 44), integers::<f32>(20, 4, 45));
    let mut c = zeros::<f32>(6, 6);
    let both = AtaOptions::new().uplo(Uplo::Both);
    aha_into(1.0, a.as_ref(), 0.0, c.as_mut(), &both).unwrap();
    assert_eq!(aha(&a).unwrap(), c);
    let mut d = zeros::<f32>(6, 4);
    let (one, zero) = (complex(1.0, 0.0), complex(0.0, 0.0));
    ahb_into(one, a.as_ref(), b.as_ref(), zero, d.as_mut(), &AtaOptions::new()).unwrap();
    assert_eq!(ahb(&a, &b).unwrap(), d);
    assert!(matches!(ahb(&a, b.subrows(0, 19)), Err(Error::Shape { what: "B", .. })));
}
