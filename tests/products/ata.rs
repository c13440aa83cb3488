//! A^T A, A A^T and A^T B against exact oracles.

use std::ops::ControlFlow;
use std::sync::atomic::{AtomicUsize, Ordering};

use catamaran::base::{Pin, ThreadPool};
use catamaran::blas::BlasReal;
use catamaran::faer::prelude::{Reborrow, ReborrowMut};
use catamaran::faer::{Mat, MatMut, MatRef};
use catamaran::product::{ata_planned, atb_planned, verify};
use catamaran::rows::{Center, DenseRows, RowOptions, ata_rows};
use catamaran::{
    Accuracy, AtaOptions, Error, Par, Plan, SchemeChoice, Uplo, aat, aat_into, ata, ata_into, atb,
    atb_into,
};

use crate::common::{AWKWARD, backends, bits, gaussian, integers, oracle};

fn schemes() -> impl Iterator<Item = SchemeChoice> {
    SchemeChoice::NAMES.into_iter().map(|(_, scheme)| scheme)
}

/// Options that recurse as deep as the shape allows.
fn deep(scheme: SchemeChoice) -> AtaOptions<'static> {
    AtaOptions::new().scheme(scheme).leaf(1).accuracy(Accuracy::Fast).threads(2)
}

/// Checks `ata_planned` in dirty scratch, on a C whose other triangle is poisoned.
fn check_ata<T: BlasReal>(a: MatRef<'_, T>, uplo: Uplo, options: &AtaOptions<'_>) {
    let n = a.ncols();
    let nan = T::from_f64(f64::NAN);
    let wanted = |i: usize, j: usize| match uplo {
        Uplo::Lower => i >= j,
        Uplo::Upper => i <= j,
        Uplo::Both => true,
    };
    for (alpha, beta) in [(1.0, 0.0), (-2.0, 1.0), (3.0, -2.0)] {
        let start = integers::<T>(n, n, 5);
        // A symmetric start, so that "both triangles" is well defined.
        let start = Mat::from_fn(n, n, |i, j| start[(i.max(j), i.min(j))]);
        let expected = oracle(alpha, a, None, a, beta, start.as_ref());
        let poisoned = |i, j| if wanted(i, j) && beta != 0.0 { start[(i, j)] } else { nan };
        let mut c = Mat::from_fn(n, n, poisoned);
        let options = options.clone().uplo(uplo);
        let plan = Plan::ata::<T>(a.nrows(), n, &options).unwrap();
        let mut scratch = vec![nan; plan.scratch_len::<T>(options.par)];
        let (alpha, beta) = (T::from_f64(alpha), T::from_f64(beta));
        let scratch = Some(&mut scratch[..]);
        ata_planned(&plan, alpha, a, beta, c.as_mut(), &options, scratch).unwrap();
        for j in 0..n {
            for i in 0..n {
                let got = c[(i, j)].to_f64();
                if wanted(i, j) {
                    assert_eq!(
                        got,
                        expected[(i, j)],
                        "{:?} {:?} {}x{n} at ({i}, {j})",
                        options.scheme,
                        uplo,
                        a.nrows()
                    );
                } else {
                    assert!(got.is_nan(), "the other triangle was written");
                }
            }
        }
    }
}

#[test]
fn every_scheme_is_exact_on_integers_of_awkward_sizes() {
    for scheme in schemes() {
        for m in AWKWARD {
            for n in AWKWARD {
                check_ata(integers::<f64>(m, n, 1).as_ref(), Uplo::Lower, &deep(scheme));
            }
        }
    }
}

#[test]
fn every_scheme_is_exact_in_f32() {
    for scheme in schemes() {
        for (m, n) in [(33, 29), (64, 64), (17, 90)] {
            check_ata(integers::<f32>(m, n, 2).as_ref(), Uplo::Lower, &deep(scheme));
        }
    }
}

#[test]
fn every_triangle_of_every_scheme_and_backend_is_right() {
    for backend in backends() {
        for scheme in schemes() {
            for uplo in [Uplo::Lower, Uplo::Upper, Uplo::Both] {
                let options = deep(scheme).backend(backend.clone());
                check_ata(integers::<f64>(41, 37, 3).as_ref(), uplo, &options);
            }
        }
    }
}

#[test]
fn leaves_tasks_and_threads_of_all_sizes_agree_with_the_oracle() {
    let a = integers::<f64>(75, 66, 4);
    for scheme in schemes() {
        for leaf in [1, 3, 8, 16, 100] {
            for tasks in [1, 2, 3, 5, 16, 40] {
                let options = deep(scheme).leaf(leaf).tasks(tasks);
                check_ata(a.as_ref(), Uplo::Lower, &options);
            }
        }
    }
}

#[test]
fn any_strides_are_taken() {
    let wide = integers::<f64>(60, 80, 6);
    let views: [(&str, MatRef<'_, f64>); 5] = [
        ("row-major", wide.transpose()),
        ("a part with a longer leading dimension", wide.as_ref().submatrix(3, 5, 40, 30)),
        ("reversed rows", wide.as_ref().reverse_rows()),
        ("reversed columns, transposed", wide.as_ref().reverse_cols().transpose()),
        ("every second row", every_second_row(wide.as_ref())),
    ];
    for backend in backends() {
        for scheme in schemes() {
            for (_, view) in views {
                let options = deep(scheme).backend(backend.clone()).leaf(8);
                check_ata(view, Uplo::Lower, &options);
            }
        }
    }
}

fn every_second_row(a: MatRef<'_, f64>) -> MatRef<'_, f64> {
    // SAFETY: rows 0, 2, 4, ... of `a` lie inside it.
    unsafe {
        MatRef::from_raw_parts(
            a.as_ptr(),
            a.nrows() / 2,
            a.ncols(),
            2 * a.row_stride(),
            a.col_stride(),
        )
    }
}

#[test]
fn c_may_have_any_strides() {
    let a = integers::<f64>(30, 20, 7);
    let expected = oracle(1.0, a.as_ref(), None, a.as_ref(), 0.0, Mat::zeros(20, 20).as_ref());
    for backend in backends() {
        for scheme in schemes() {
            let options = deep(scheme).uplo(Uplo::Both).backend(backend.clone());
            let mut memory = vec![0.0; 4000];
            // SAFETY: 20 x 20 entries with strides 100 and 3 end below 19 * 100 + 19 * 3 < 4000.
            let mut c = unsafe { MatMut::from_raw_parts_mut(memory.as_mut_ptr(), 20, 20, 100, 3) };
            ata_into(1.0, a.as_ref(), 0.0, c.rb_mut(), &options).unwrap();
            assert_eq!(c.rb().to_owned(), expected);
        }
    }
}

#[test]
fn aat_is_ata_of_the_transpose() {
    let a = integers::<f64>(23, 31, 8);
    let mut c = Mat::zeros(23, 23);
    let options = deep(SchemeChoice::Rxtx).uplo(Uplo::Both);
    aat_into(1.0, a.as_ref(), 0.0, c.as_mut(), &options).unwrap();
    let t = a.transpose();
    assert_eq!(c, oracle(1.0, t, None, t, 0.0, c.as_ref()));
}

#[test]
fn atb_is_exact_on_integers_of_awkward_sizes() {
    for scheme in [SchemeChoice::Auto, SchemeChoice::Ata2, SchemeChoice::Winograd] {
        for m in AWKWARD {
            for (n, k) in [(0, 3), (1, 1), (7, 31), (31, 7), (65, 64), (40, 1)] {
                let (a, b) = (integers::<f64>(m, n, 9), integers::<f64>(m, k, 10));
                let start = integers::<f64>(n, k, 11);
                let mut c = start.clone();
                let options = deep(scheme);
                let plan = Plan::atb::<f64>(m, n, k, &options).unwrap();
                let mut scratch = vec![f64::NAN; plan.scratch_len::<f64>(options.par)];
                let scratch = Some(&mut scratch[..]);
                let (av, bv) = (a.as_ref(), b.as_ref());
                atb_planned(&plan, 2.0, av, bv, -1.0, c.as_mut(), &options, scratch).unwrap();
                assert_eq!(
                    c,
                    oracle(2.0, av, None, bv, -1.0, start.as_ref()),
                    "{scheme:?} {m} {n} {k}"
                );
            }
        }
    }
}

#[test]
fn results_are_bitwise_equal_for_any_number_of_threads() {
    for scheme in schemes() {
        for (m, n) in [(300, 270), (5000, 40), (97, 410)] {
            let a = gaussian::<f64>(m, n, 12);
            let run = |par| {
                let mut c = Mat::zeros(n, n);
                let options = deep(scheme).par(par).leaf(32);
                ata_into(1.0, a.as_ref(), 0.0, c.as_mut(), &options).unwrap();
                bits(c.as_ref())
            };
            let sequential = run(Par::Seq);
            for threads in [1, 2, 4, 8] {
                assert!(run(Par::Threads(threads)) == sequential, "{scheme:?} {threads}");
            }
        }
    }
}

#[test]
fn both_triangles_are_bitwise_symmetric() {
    for scheme in schemes() {
        let a = gaussian::<f32>(150, 131, 13);
        let mut c = Mat::zeros(131, 131);
        let options = deep(scheme).uplo(Uplo::Both).leaf(16);
        ata_into(1.0, a.as_ref(), 0.0, c.as_mut(), &options).unwrap();
        assert_eq!(bits(c.as_ref()), bits(c.transpose()));
    }
}

#[test]
fn a_pinned_team_gives_the_same_result() {
    let a = gaussian::<f64>(200, 300, 14);
    let run = || {
        let mut c = Mat::zeros(300, 300);
        ata_into(1.0, a.as_ref(), 0.0, c.as_mut(), &deep(SchemeChoice::Auto)).unwrap();
        c
    };
    let team = ThreadPool::new(2, Pin::Cores).unwrap();
    assert_eq!(team.run(run), run());
}

#[test]
fn every_way_to_a_product_runs_on_pinned_threads_and_gives_the_same_result() {
    let a = gaussian::<f64>(400, 300, 17);
    type Way<'w> = &'w dyn Fn(MatMut<'_, f64>, &AtaOptions<'_>) -> Result<(), Error>;
    let whole: Way<'_> = &|c, options| ata_into(1.0, a.as_ref(), 0.0, c, options);
    let rows: Way<'_> = &|c, options| {
        let mean = RowOptions::new().center(Center::Mean);
        ata_rows(1.0, &mut DenseRows(a.as_ref()), &mean, 0.0, c, options)
    };
    let ways: [(Way<'_>, AtaOptions<'static>); 5] = [
        (whole, deep(SchemeChoice::Auto)),
        (whole, deep(SchemeChoice::Ata2)),
        (whole, deep(SchemeChoice::Exact)),
        (rows, deep(SchemeChoice::Auto)),
        (rows, deep(SchemeChoice::Exact)),
    ];
    let cores = core_affinity::get_core_ids().unwrap();
    for (i, (way, options)) in ways.into_iter().enumerate() {
        let on_one_core = AtomicUsize::new(0);
        let watch = |_: f64| {
            let own = core_affinity::get_core_ids().unwrap();
            on_one_core.fetch_add(usize::from(own.len() == 1), Ordering::Relaxed);
            ControlFlow::Continue(())
        };
        let [mut plain, mut pinned] = [Mat::zeros(300, 300), Mat::zeros(300, 300)];
        way(plain.as_mut(), &options.clone().progress(&watch)).unwrap();
        assert!(cores.len() == 1 || on_one_core.swap(0, Ordering::Relaxed) == 0, "way {i}");
        way(pinned.as_mut(), &options.pin(Pin::Cores).progress(&watch)).unwrap();
        assert!(on_one_core.into_inner() > 0, "way {i}");
        assert_eq!(plain, pinned, "way {i}");
        assert_eq!(core_affinity::get_core_ids().unwrap(), cores);
    }
}

#[test]
fn weights_and_centre_match_the_definition() {
    let (m, n) = (3000, 37);
    let a = integers::<f64>(m, n, 15);
    let weights: Vec<f64> = integers::<f64>(m, 1, 16).col(0).iter().copied().collect();
    let options = deep(SchemeChoice::Kgp4).uplo(Uplo::Both);
    let start = Mat::from_fn(n, n, |i, j| (i + j) as f64);

    let mut c = start.clone();
    let row_options = RowOptions::new().weights(&weights[..]);
    ata_rows(2.0, &mut DenseRows(a.as_ref()), &row_options, 3.0, c.as_mut(), &options).unwrap();
    let av = a.as_ref();
    assert_eq!(c, oracle(2.0, av, Some(&weights), av, 3.0, start.as_ref()));

    let center: Vec<f64> = (0..n).map(|j| j as f64).collect();
    let shifted = Mat::from_fn(m, n, |i, j| a[(i, j)] - center[j]);
    let row_options = RowOptions::new().weights(&weights[..]).center(Center::Given(&center));
    ata_rows(1.0, &mut DenseRows(av), &row_options, 0.0, c.as_mut(), &options).unwrap();
    let sv = shifted.as_ref();
    assert_eq!(c, oracle(1.0, sv, Some(&weights), sv, 0.0, start.as_ref()));
}

#[test]
fn covariance_survives_a_mean_a_million_times_the_deviation() {
    let (m, n) = (4000, 5);
    let noise = gaussian::<f64>(m, n, 17);
    let a = Mat::from_fn(m, n, |i, j| noise[(i, j)] + 1e6);
    let options = AtaOptions::new().uplo(Uplo::Both);
    let row_options = RowOptions::new().center(Center::Mean);
    let alpha = 1.0 / (m as f64 - 1.0);
    let run = |a: MatRef<'_, f64>| {
        let mut c = Mat::zeros(n, n);
        ata_rows(alpha, &mut DenseRows(a), &row_options, 0.0, c.as_mut(), &options).unwrap();
        c
    };
    let difference = run(a.as_ref()) - run(noise.as_ref());
    // Adding 1e6 itself rounds the entries to 1e-10.
    assert!(difference.norm_max() < 1e-9, "{}", difference.norm_max());
}

#[test]
fn a_weighted_mean_of_weight_zero_is_refused() {
    let a = integers::<f64>(3, 2, 18);
    let mut c = Mat::zeros(2, 2);
    let options = AtaOptions::default();
    // In the second, the sum is not zero only by rounding.
    for weights in [[1.0, -1.0, 0.0], [0.1, 0.2, -0.3]] {
        let row_options = RowOptions::new().weights(&weights[..]).center(Center::Mean);
        let mut rows = DenseRows(a.as_ref());
        let result = ata_rows(1.0, &mut rows, &row_options, 0.0, c.as_mut(), &options);
        assert!(matches!(result, Err(Error::Argument { what: "weights", .. })));
    }
}

#[test]
fn f32_input_with_f64_result_is_the_f64_result_of_the_same_numbers() {
    let a = gaussian::<f32>(2500, 30, 19);
    let wide = Mat::from_fn(2500, 30, |i, j| f64::from(a[(i, j)]));
    let options = AtaOptions::new().uplo(Uplo::Both);
    let row_options = RowOptions::new();
    let (mut c, mut d) = (Mat::<f64>::zeros(30, 30), Mat::<f64>::zeros(30, 30));
    ata_rows(1.0, &mut DenseRows(a.as_ref()), &row_options, 0.0, c.as_mut(), &options).unwrap();
    ata_rows(1.0, &mut DenseRows(wide.as_ref()), &row_options, 0.0, d.as_mut(), &options).unwrap();
    assert_eq!(bits(c.as_ref()), bits(d.as_ref()));
}

#[test]
fn no_rows_leave_beta_c() {
    let options = AtaOptions::new().uplo(Uplo::Both);
    let a = Mat::<f64>::zeros(0, 3);
    let mut c = Mat::from_fn(3, 3, |i, j| (i + j) as f64);
    ata_into(1.0, a.as_ref(), 2.0, c.as_mut(), &options).unwrap();
    assert_eq!(c, Mat::from_fn(3, 3, |i, j| 2.0 * (i + j) as f64));
    let row_options = RowOptions::new().center(Center::Mean);
    ata_rows(1.0, &mut DenseRows(a.as_ref()), &row_options, 0.5, c.as_mut(), &options).unwrap();
    assert_eq!(c, Mat::from_fn(3, 3, |i, j| (i + j) as f64));
}

#[test]
fn wrong_shapes_name_the_argument_and_leave_c_alone() {
    let a = integers::<f64>(4, 3, 20);
    let options = AtaOptions::default();
    let mut c = Mat::<f64>::ones(2, 3);
    let error = ata_into(1.0, a.as_ref(), 0.0, c.as_mut(), &options).unwrap_err();
    assert_eq!(error, Error::Shape { what: "C", expected: (3, 3), got: (2, 3) });
    assert_eq!(error.to_string(), "C: expected 3 x 3, got 2 x 3");
    assert_eq!(c, Mat::<f64>::ones(2, 3));

    let b = integers::<f64>(5, 3, 21);
    let mut c = Mat::<f64>::ones(3, 3);
    let error = atb_into(1.0, a.as_ref(), b.as_ref(), 0.0, c.as_mut(), &options).unwrap_err();
    assert_eq!(error, Error::Shape { what: "B", expected: (4, 3), got: (5, 3) });

    let short = RowOptions::new().weights(&[1.0][..]);
    let error = ata_rows(1.0, &mut DenseRows(a.as_ref()), &short, 0.0, c.as_mut(), &options);
    assert!(matches!(error, Err(Error::Shape { what: "weights", .. })));

    let nan = [1.0, f64::NAN, 1.0, 1.0];
    let nan = RowOptions::new().weights(&nan[..]);
    let error = ata_rows(1.0, &mut DenseRows(a.as_ref()), &nan, 0.0, c.as_mut(), &options);
    assert_eq!(error, Err(Error::NonFinite { what: "weights", index: (1, 0) }));
    assert_eq!(c, Mat::<f64>::ones(3, 3));
}

#[test]
fn options_out_of_range_are_refused() {
    let a = integers::<f64>(4, 3, 22);
    let mut c = Mat::zeros(3, 3);
    let defaults = AtaOptions::default;
    for options in [
        defaults().leaf(0),
        defaults().tasks(0),
        defaults().accuracy(Accuracy::Bounded(0.5)),
        defaults().accuracy(Accuracy::Bounded(f64::NAN)),
    ] {
        let result = ata_into(1.0, a.as_ref(), 0.0, c.as_mut(), &options);
        assert!(matches!(result, Err(Error::Argument { .. })));
    }
}

#[test]
fn a_scratch_too_short_is_an_error() {
    let a = integers::<f64>(64, 64, 23);
    let mut c = Mat::zeros(64, 64);
    let options = deep(SchemeChoice::Ata2);
    let options = options.leaf(4);
    let plan = Plan::ata::<f64>(64, 64, &options).unwrap();
    let len = plan.scratch_len::<f64>(options.par);
    assert!(len > 0);
    let mut scratch = vec![0.0; len - 1];
    let scratch = Some(&mut scratch[..]);
    let result = ata_planned(&plan, 1.0, a.as_ref(), 0.0, c.as_mut(), &options, scratch);
    assert_eq!(
        result,
        Err(Error::Shape { what: "scratch", expected: (len, 1), got: (len - 1, 1) })
    );
}

#[test]
fn progress_ends_at_one_and_can_cancel() {
    use std::sync::Mutex;
    let a = gaussian::<f64>(100, 100, 24);
    let mut c = Mat::zeros(100, 100);
    let seen = Mutex::new(Vec::new());
    let note = |fraction| {
        seen.lock().unwrap().push(fraction);
        ControlFlow::Continue(())
    };
    let options = deep(SchemeChoice::Ata2).progress(&note);
    ata_into(1.0, a.as_ref(), 0.0, c.as_mut(), &options).unwrap();
    let seen = seen.into_inner().unwrap();
    assert!(seen.is_sorted());
    assert!((seen.last().unwrap() - 1.0).abs() < 1e-12);

    let cancel = |_| ControlFlow::Break(());
    let options = deep(SchemeChoice::Ata2).progress(&cancel);
    let result = ata_into(1.0, a.as_ref(), 0.0, c.as_mut(), &options);
    assert_eq!(result, Err(Error::Cancelled));
}

#[test]
fn verify_accepts_every_scheme_and_rejects_one_wrong_entry() {
    for scheme in schemes() {
        let a = gaussian::<f64>(400, 150, 25);
        for uplo in [Uplo::Lower, Uplo::Upper, Uplo::Both] {
            let mut c = Mat::from_fn(150, 150, |_, _| f64::NAN);
            let options = deep(scheme).uplo(uplo).leaf(16);
            ata_into(-2.0, a.as_ref(), 0.0, c.as_mut(), &options).unwrap();
            let check = |c: &Mat<f64>| verify(-2.0, a.as_ref(), c.as_ref(), uplo, 20, 1).unwrap();
            assert!(check(&c).passed, "{scheme:?} {uplo:?} {:?}", check(&c));
            let (i, j) = if uplo == Uplo::Upper { (3, 77) } else { (77, 3) };
            c[(i, j)] += 2.1 * check(&c).tolerance;
            assert!(!check(&c).passed, "{scheme:?} {uplo:?}");
            c[(i, j)] = f64::NAN;
            assert!(!check(&c).passed);
        }
    }
}

#[test]
fn default_accuracy_stays_within_four_times_the_classical_error() {
    // Positive entries, all of one size: the worst of the usual distributions for fast products.
    let n = 512;
    for (name, a) in [
        ("gaussian", gaussian::<f32>(n, n, 26)),
        ("positive", Mat::from_fn(n, n, |i, j| (((i * 7919 + j * 104729) % 1009) as f32) / 1009.0)),
    ] {
        let exact = oracle(1.0, a.as_ref(), None, a.as_ref(), 0.0, Mat::zeros(n, n).as_ref());
        let error = |scheme, accuracy| {
            let mut c = Mat::<f32>::zeros(n, n);
            let options =
                AtaOptions::new().uplo(Uplo::Both).scheme(scheme).accuracy(accuracy).leaf(64);
            ata_into(1.0, a.as_ref(), 0.0, c.as_mut(), &options).unwrap();
            Mat::from_fn(n, n, |i, j| f64::from(c[(i, j)]) - exact[(i, j)]).norm_max()
        };
        let classical = error(SchemeChoice::Classical, Accuracy::Classical);
        for scheme in [SchemeChoice::Auto, SchemeChoice::Winograd, SchemeChoice::Kgp4] {
            let fast = error(scheme, Accuracy::Default);
            assert!(fast <= 4.0 * classical, "{name} {scheme:?}: {fast:e} vs {classical:e}");
        }
    }
}

#[test]
fn classical_accuracy_keeps_an_infinity_in_its_row_and_column() {
    let n = 200;
    let mut a = gaussian::<f64>(n, n, 27);
    a[(5, 9)] = f64::INFINITY;
    let mut c = Mat::zeros(n, n);
    let options = AtaOptions::new().accuracy(Accuracy::Classical).leaf(8).uplo(Uplo::Both);
    ata_into(1.0, a.as_ref(), 0.0, c.as_mut(), &options).unwrap();
    for j in 0..n {
        for i in 0..n {
            assert_eq!(c[(i, j)].is_finite(), i != 9 && j != 9);
        }
    }
}

#[test]
fn verify_rejects_what_overflows_and_rounds_out_of_range() {
    let check = |a: f64, c: f64, rounds| {
        let (a, c) = (Mat::from_fn(1, 1, |_, _| a), Mat::from_fn(1, 1, |_, _| c));
        verify(1.0, a.as_ref(), c.as_ref(), Uplo::Lower, rounds, 1)
    };
    assert!(check(2.0, 4.0, 1).unwrap().passed);
    assert!(!check(1e200, 5.0, 1).unwrap().passed);
    assert!(!check(2.0, f64::NAN, 1).unwrap().passed);
    for rounds in [0, 1001, u32::MAX] {
        assert!(matches!(check(2.0, 4.0, rounds), Err(Error::Argument { what: "rounds", .. })));
    }
}

#[test]
fn verify_names_the_first_entry_of_a_that_is_not_finite() {
    // More rows than a block, and one whose squares overflow.
    let (m, n) = (70_000, 20);
    for (i, j, x) in [(0, 0, f64::NAN), (66_000, 13, f64::INFINITY), (69_999, 19, f64::NAN)] {
        let mut a = Mat::<f64>::from_fn(m, n, |i, j| ((3 * i + j) % 7) as f64);
        a[(10, 0)] = 1e200;
        a[(i, j)] = x;
        a[(m - 1, n - 1)] = x;
        let found = verify(1.0, a.as_ref(), Mat::zeros(n, n).as_ref(), Uplo::Lower, 1, 1);
        assert_eq!(found, Err(Error::NonFinite { what: "A", index: (i, j) }));
    }
}

#[test]
fn sizes_that_overflow_are_refused() {
    let options = AtaOptions::default();
    for (m, n) in [(1 << 40, 1 << 40), (usize::MAX, 2), (3, usize::MAX)] {
        let result = Plan::ata::<f64>(m, n, &options);
        assert!(matches!(result, Err(Error::OutOfMemory { .. })), "{m} x {n}");
    }
}

#[test]
fn scratch_of_a_tall_matrix_does_not_grow_with_its_rows() {
    for scheme in [SchemeChoice::Classical, SchemeChoice::Winograd, SchemeChoice::Kgp4] {
        let options = AtaOptions::new().scheme(scheme);
        let len = |m| Plan::ata::<f64>(m, 4096, &options).unwrap().scratch_len::<f64>(options.par);
        for m in [4096, 40 * 4096] {
            assert!(len(m) <= 4096 * 4096 / 2, "{scheme:?}: more than half of C");
        }
    }
}

#[test]
fn a_tall_matrix_taken_in_chunks_is_exact() {
    for scheme in schemes() {
        check_ata(integers::<f64>(1000, 41, 28).as_ref(), Uplo::Lower, &deep(scheme));
        let tasks = deep(scheme).tasks(3);
        check_ata(integers::<f64>(333, 50, 29).as_ref(), Uplo::Both, &tasks);
    }
}

#[test]
fn a_progress_callback_may_use_the_threads_itself() {
    let a = gaussian::<f64>(64, 64, 30);
    let work = |_| {
        let mut c = Mat::zeros(64, 64);
        ata_into(1.0, a.as_ref(), 0.0, c.as_mut(), &deep(SchemeChoice::Winograd)).unwrap();
        ControlFlow::Continue(())
    };
    let mut c = Mat::zeros(64, 64);
    let options = deep(SchemeChoice::Winograd).progress(&work);
    ata_into(1.0, a.as_ref(), 0.0, c.as_mut(), &options).unwrap();
}

#[test]
fn products_without_rows_or_columns_take_any_number_of_the_others() {
    // More columns than the kernels for small products can pack.
    let b = integers::<f64>(9000, 3, 31);
    let mut c = b.clone();
    let none = Mat::<f64>::zeros(0, 9000);
    let empty = Mat::<f64>::zeros(0, 3);
    let options = AtaOptions::default();
    atb_into(1.0, none.as_ref(), empty.as_ref(), 1.0, c.as_mut(), &options).unwrap();
    assert_eq!(c, b);
    atb_into(1.0, none.as_ref(), empty.as_ref(), 0.0, c.as_mut(), &options).unwrap();
    assert_eq!(c, Mat::<f64>::zeros(9000, 3));
    let mut nothing = Mat::<f64>::zeros(0, 3);
    atb_into(1.0, none.transpose(), b.as_ref(), 0.0, nothing.as_mut(), &options).unwrap();
}

#[test]
fn products_in_a_new_matrix_are_those_of_the_default_options() {
    let (a, b) = (integers::<f64>(40, 30, 32), integers::<f64>(40, 20, 33));
    let both = AtaOptions::new().uplo(Uplo::Both);
    let mut c = Mat::zeros(30, 30);
    ata_into(1.0, a.as_ref(), 0.0, c.as_mut(), &both).unwrap();
    assert_eq!(ata(&a).unwrap(), c);
    assert_eq!(ata(a.as_ref()).unwrap(), c);
    assert_eq!(aat(a.transpose()).unwrap(), c);
    // A view with a negative stride: the sums are of integers, in any order.
    assert_eq!(ata(a.as_ref().reverse_rows()).unwrap(), c);
    let mut c = Mat::zeros(30, 20);
    atb_into(1.0, a.as_ref(), b.as_ref(), 0.0, c.as_mut(), &AtaOptions::new()).unwrap();
    assert_eq!(atb(&a, &b).unwrap(), c);
    assert_eq!(ata(Mat::<f32>::zeros(0, 3)).unwrap(), Mat::<f32>::zeros(3, 3));
    assert_eq!(ata(Mat::<f32>::zeros(3, 0)).unwrap().shape(), (0, 0));
}

#[test]
fn a_product_in_a_new_matrix_names_the_matrix_of_another_shape() {
    let (a, b) = (integers::<f64>(4, 3, 34), integers::<f64>(5, 3, 35));
    assert!(matches!(atb(&a, &b), Err(Error::Shape { what: "B", .. })));
}
