//! Many products at once, against as many calls.

use std::ops::ControlFlow;
use std::sync::Mutex;
use std::sync::atomic::{AtomicUsize, Ordering};

use catamaran::base::Progress;
use catamaran::blas::BlasReal;
use catamaran::faer::{Mat, MatMut, MatRef};
use catamaran::product::ata_batched_into;
use catamaran::{AtaOptions, Error, SchemeChoice, Uplo, ata_into};

use crate::common::{bits, gaussian, integers};

fn views<T>(matrices: &[Mat<T>]) -> Vec<MatRef<'_, T>> {
    matrices.iter().map(|a| a.as_ref()).collect()
}

fn views_mut<T>(matrices: &mut [Mat<T>]) -> Vec<MatMut<'_, T>> {
    matrices.iter_mut().map(|c| c.as_mut()).collect()
}

/// Checks a batch of these shapes against single calls, bit for bit, for 1 and 3 threads.
fn check<T: BlasReal>(shapes: &[(usize, usize)], options: &AtaOptions<'_>) {
    let a: Vec<Mat<T>> = (0..).zip(shapes).map(|(i, &(m, n))| gaussian(m, n, i)).collect();
    let start: Vec<Mat<T>> = shapes.iter().map(|&(_, n)| integers(n, n, 5)).collect();
    for (alpha, beta) in [(1.0, 0.0), (-2.0, 3.0), (0.0, 2.0)] {
        let (alpha, beta) = (T::from_f64(alpha), T::from_f64(beta));
        let mut expected = start.clone();
        for (a, c) in a.iter().zip(&mut expected) {
            ata_into(alpha, a.as_ref(), beta, c.as_mut(), options).unwrap();
        }
        for threads in [1, 3] {
            let (mut c, options) = (start.clone(), options.clone().threads(threads));
            ata_batched_into(alpha, &views(&a), beta, &mut views_mut(&mut c), &options).unwrap();
            for (i, (c, expected)) in c.iter().zip(&expected).enumerate() {
                let same = bits(c.as_ref()) == bits(expected.as_ref());
                assert!(same, "matrix {i}, {:?}, {threads} threads", shapes[i]);
            }
        }
    }
}

#[test]
fn a_batch_has_the_bytes_of_single_calls() {
    let sizes = [0, 1, 2, 3, 7, 31];
    let mixed: Vec<_> = sizes.iter().flat_map(|&m| sizes.map(|n| (m, n))).collect();
    for uplo in [Uplo::Lower, Uplo::Upper, Uplo::Both] {
        let options = AtaOptions::new().uplo(uplo);
        let batches: [&[(usize, usize)]; 4] = [&[], &[(5, 3)], &[(13, 11); 500], &mixed];
        for shapes in batches {
            check::<f64>(shapes, &options);
            check::<f32>(shapes, &options);
        }
    }
}

#[test]
fn long_products_and_schemes_with_plans_have_the_bytes_of_single_calls() {
    let shapes = [(3, 2), (400, 300), (7, 5), (150, 170), (1, 1)];
    for scheme in [SchemeChoice::Auto, SchemeChoice::Winograd, SchemeChoice::Exact] {
        check::<f64>(&shapes, &AtaOptions::new().scheme(scheme).uplo(Uplo::Both));
    }
}

#[test]
fn matrices_of_a_batch_may_have_any_strides() {
    const COUNT: usize = 50;
    // The A_i are windows of a series that overlap; the C_i are blocks of columns of one matrix.
    let series = gaussian::<f64>(COUNT + 6, 1, 3);
    let window = |i| {
        let start = series.as_ref().subrows(i, 7).as_ptr();
        // SAFETY: 5 x 3 entries of seven elements of the series, which is borrowed.
        unsafe { MatRef::from_raw_parts(start, 5_usize, 3_usize, 1_isize, 1_isize) }
    };
    let a: Vec<MatRef<'_, f64>> = (0..COUNT).map(window).collect();
    let mut all = Mat::zeros(3, 3 * COUNT);
    let (mut c, mut rest) = (Vec::new(), all.as_mut());
    for _ in 0..COUNT {
        let (first, others) = rest.split_at_col_mut(3);
        c.push(first.transpose_mut());
        rest = others;
    }
    ata_batched_into(1.0, &a, 0.0, &mut c, &AtaOptions::new().threads(3)).unwrap();
    for (i, a) in a.iter().enumerate() {
        let mut expected = Mat::zeros(3, 3);
        let c = expected.as_mut().transpose_mut();
        ata_into(1.0, *a, 0.0, c, &AtaOptions::new()).unwrap();
        let found = all.as_ref().subcols(3 * i, 3);
        assert_eq!(bits(found), bits(expected.as_ref()), "matrix {i}");
    }
}

#[test]
fn errors_of_a_batch_name_the_matrix_before_any_is_written() {
    let a = vec![Mat::<f64>::ones(4, 2); 3];
    let mut c = vec![Mat::<f64>::zeros(2, 2), Mat::zeros(2, 2), Mat::zeros(2, 3)];
    let options = AtaOptions::new();
    let found = ata_batched_into(1.0, &views(&a), 0.0, &mut views_mut(&mut c), &options);
    let message = "C: matrix 2: expected 2 x 2, got 2 x 3";
    assert_eq!(found.unwrap_err().to_string(), message);
    let found = ata_batched_into(1.0, &views(&a), 0.0, &mut views_mut(&mut c[..2]), &options);
    assert_eq!(found, Err(Error::Shape { what: "C", expected: (3, 1), got: (2, 1) }));
    let bad = options.leaf(0);
    let found = ata_batched_into(1.0, &views(&a[..2]), 0.0, &mut views_mut(&mut c[..2]), &bad);
    assert!(matches!(found, Err(Error::Argument { what: "leaf", .. })));
    assert!(c.iter().all(|c| *c == Mat::<f64>::zeros(2, c.ncols())));
}

#[test]
fn a_batch_reports_after_some_products_and_can_be_cancelled() {
    // The first ones are short; three threads compute the last one together.
    let mut shapes = vec![(20, 20); 2000];
    shapes.push((900, 500));
    let a: Vec<_> = (0..).zip(&shapes).map(|(i, &(m, n))| gaussian::<f64>(m, n, i)).collect();
    let mut c: Vec<_> = shapes.iter().map(|&(_, n)| Mat::<f64>::zeros(n, n)).collect();
    for threads in [1, 3] {
        let options = AtaOptions::new().threads(threads);
        let (calls, last) = (AtomicUsize::new(0), Mutex::new(0.0));
        let watch = |fraction: f64| {
            calls.fetch_add(1, Ordering::Relaxed);
            let before = std::mem::replace(&mut *last.lock().unwrap(), fraction);
            assert!(before <= fraction, "{before} {fraction}");
            ControlFlow::Continue(())
        };
        let watched = options.clone().progress(Progress::new(&watch));
        ata_batched_into(1.0, &views(&a), 0.0, &mut views_mut(&mut c), &watched).unwrap();
        assert_eq!(*last.lock().unwrap(), 1.0);
        let calls = calls.load(Ordering::Relaxed);
        assert!((2..shapes.len()).contains(&calls), "{calls} calls");

        for limit in [0.0, 0.5] {
            let stop = |fraction: f64| match fraction > limit {
                true => ControlFlow::Break(()),
                false => ControlFlow::Continue(()),
            };
            let stopped = options.clone().progress(Progress::new(&stop));
            let found = ata_batched_into(1.0, &views(&a), 0.0, &mut views_mut(&mut c), &stopped);
            assert_eq!(found, Err(Error::Cancelled));
        }
    }
}
