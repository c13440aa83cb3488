//! Callbacks of progress that compute: they call the library and rayon from inside of it.

use std::ops::ControlFlow;
use std::sync::atomic::{AtomicBool, AtomicUsize, Ordering};
use std::sync::mpsc::{RecvTimeoutError, channel};
use std::time::Duration;

use catamaran::base::Rng;
use catamaran::faer::Mat;
use catamaran::{Accuracy, AtaOptions, Error, Par, SchemeChoice, ata_into};

/// What a round takes at most, many times over.
const PATIENCE: Duration = Duration::from_secs(60);

/// Does `work`; ends the process when it takes too long: a deadlock can't be left in another way.
fn without_deadlock<R>(what: &str, work: impl FnOnce() -> R) -> R {
    let (done, wait) = channel::<()>();
    let label = what.to_owned();
    let watchdog = std::thread::spawn(move || {
        if wait.recv_timeout(PATIENCE) == Err(RecvTimeoutError::Timeout) {
            eprintln!("{label}: hangs");
            std::process::abort();
        }
    });
    let result = work();
    drop(done);
    watchdog.join().expect("the watchdog");
    result
}

fn random(m: usize, n: usize) -> Mat<f64> {
    let mut rng = Rng::new(1);
    Mat::from_fn(m, n, |_, _| 2.0 * rng.uniform() - 1.0)
}

/// The schemes of each executor: the native kernels' own, tasks, the recursion, and the exact path.
const SCHEMES: [SchemeChoice; 5] = [
    SchemeChoice::Float,
    SchemeChoice::Classical,
    SchemeChoice::Ata2,
    SchemeChoice::Rxtx,
    SchemeChoice::Exact,
];

#[test]
fn callbacks_may_call_the_library_and_rayon() {
    let (a, small) = (random(260, 260), random(90, 90));
    let product = |a: &Mat<f64>, options: &AtaOptions<'_>| {
        let mut c = Mat::zeros(a.ncols(), a.ncols());
        ata_into(1.0, a.as_ref(), 0.0, c.as_mut(), options).map(|()| c)
    };
    let expected_small = product(&small, &AtaOptions::new().par(Par::Seq)).unwrap();
    for scheme in SCHEMES {
        let options = AtaOptions::new().scheme(scheme).accuracy(Accuracy::Fast).tasks(8);
        let expected = product(&a, &options.clone().par(Par::Seq)).unwrap();
        for round in 0..40 {
            let threads = 2 + round % 3;
            let (calls, inside) = (AtomicUsize::new(0), AtomicBool::new(false));
            let callback = |_: f64| {
                assert!(!inside.swap(true, Ordering::SeqCst), "two calls at a time");
                let inner = AtaOptions::new().threads(2);
                let (left, right) = rayon::join(
                    || product(&small, &inner).unwrap(),
                    || product(&small, &inner).unwrap(),
                );
                assert!(left == expected_small && right == expected_small);
                calls.fetch_add(1, Ordering::Relaxed);
                inside.store(false, Ordering::SeqCst);
                ControlFlow::Continue(())
            };
            let options = options.clone().threads(threads).progress(&callback);
            let what = format!("{scheme:?} on {threads} threads, round {round}");
            let found = without_deadlock(&what, || product(&a, &options)).unwrap();
            assert!(found == expected, "{what}");
            assert!(calls.into_inner() > 0, "{what}");
        }
    }
}

#[test]
fn a_callback_that_computes_may_stop_the_work() {
    let a = random(260, 260);
    for scheme in SCHEMES {
        for round in 0..10 {
            let callback = |_: f64| {
                let mut c = Mat::zeros(260, 260);
                let inner = AtaOptions::new().threads(2);
                ata_into(1.0, a.as_ref(), 0.0, c.as_mut(), &inner).unwrap();
                ControlFlow::Break(())
            };
            let options = AtaOptions::new()
                .scheme(scheme)
                .tasks(8)
                .threads(2 + round % 3)
                .progress(&callback);
            let mut c = Mat::zeros(260, 260);
            let what = format!("{scheme:?}, round {round}");
            let outcome =
                without_deadlock(&what, || ata_into(1.0, a.as_ref(), 0.0, c.as_mut(), &options));
            assert_eq!(outcome, Err(Error::Cancelled), "{what}");
        }
    }
}
