//! The threads of a process: how many calls start, how long they are kept, and what limits them.

#![cfg(target_os = "linux")]

use std::process::Command;

use catamaran::base::{Pin, ThreadPool, available_cores, release_threads};
use catamaran::faer::Mat;
use catamaran::{AtaOptions, Par, ata_into};

/// The variable that makes this program print how many threads some calls start.
const ROLE: &str = "CATAMARAN_TEST_OF_THREADS";

/// Returns the number of threads of this process.
fn count() -> usize {
    std::fs::read_dir("/proc/self/task").unwrap().count()
}

/// Returns the number of threads once those that have ended are gone from the list of the system.
fn settled(expected: usize) -> usize {
    for _ in 0..1000 {
        if count() <= expected {
            break;
        }
        std::thread::sleep(std::time::Duration::from_millis(1));
    }
    count()
}

/// Computes 42 products, large enough for threads with every instruction set.
fn products(options: &AtaOptions<'_>) -> Vec<Mat<f64>> {
    let product = |i: usize| {
        let a = Mat::from_fn(1000, 300 + i, |p, q| ((p * q + i) % 17) as f64 / 16.0);
        let mut c = Mat::zeros(300 + i, 300 + i);
        ata_into(1.0, a.as_ref(), 0.0, c.as_mut(), options).unwrap();
        c
    };
    (0..42).map(product).collect()
}

/// One test, so that no other one starts threads meanwhile.
#[test]
fn a_process_keeps_the_threads_of_its_calls_until_it_releases_them() {
    if std::env::var_os(ROLE).is_some() {
        let before = count();
        products(&AtaOptions::new());
        products(&AtaOptions::new().reproducible(true));
        println!("started {} of {}", count() - before, Par::all().threads());
        return;
    }
    let (before, cores) = (count(), available_cores());
    let expected = products(&AtaOptions::new().par(Par::Seq));
    assert_eq!(count(), before);
    for _ in 0..2 {
        for threads in [2, 3] {
            assert!(products(&AtaOptions::new().threads(threads)) == expected);
            // The default pool, and a wider one.
            let wide = if threads > cores { threads.next_multiple_of(cores) } else { 1 };
            let most = (cores.max(2) - 1) + (wide - 1);
            assert!(count() <= before + most, "{threads} threads: {} more", count() - before);
        }
        assert!(products(&AtaOptions::new().threads(2).pin(Pin::Cores)) == expected);
        release_threads();
        assert_eq!(settled(before), before);
    }
    let pool = ThreadPool::new(2, Pin::No).unwrap();
    assert!(pool.run(|| products(&AtaOptions::new().threads(4))) == expected);
    assert_eq!(count(), before + 2);
    drop(pool);
    assert_eq!(settled(before), before);
    limits();
}

/// Checks that variables limit the number of threads.
fn limits() {
    let cores = available_cores();
    for (variables, threads) in [
        (&[][..], cores),
        (&[("CATAMARAN_NUM_THREADS", "1")], 1),
        (&[("RAYON_NUM_THREADS", "1")], 1),
        (&[("RAYON_NUM_THREADS", "1"), ("CATAMARAN_NUM_THREADS", "2")], 1),
        (&[("CATAMARAN_NUM_THREADS", "2")], cores.min(2)),
        (&[("CATAMARAN_NUM_THREADS", "1000000")], cores),
        // It counts in Python and in BLAS only.
        (&[("OMP_NUM_THREADS", "1")], cores),
    ] {
        let mut command = Command::new(std::env::current_exe().unwrap());
        for name in ["RAYON", "CATAMARAN", "OMP"] {
            command.env_remove(format!("{name}_NUM_THREADS"));
        }
        let output =
            command.env(ROLE, "1").arg("--nocapture").envs(variables.iter().copied()).output();
        let output = String::from_utf8(output.unwrap().stdout).unwrap();
        let line = format!("started {} of {threads}\n", threads - 1);
        assert!(output.contains(&line), "{variables:?}: {output}");
    }
}
