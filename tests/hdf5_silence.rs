//! Errors of the HDF5 library are errors of this one, and nothing is printed.
//!
//! A binary of its own: HDF5 locks the files that it opens, and a process started meanwhile would
//! inherit the lock.

use std::fs;
use std::process::Command;

use catamaran::faer::Mat;
use catamaran::io::RowFile;
use catamaran::rows::RowBlocks;

/// Errors of every kind of call: opening, reading attributes and entries, and in several threads,
/// for HDF5 keeps one state of printing for each.
#[test]
#[ignore = "run by hdf5_prints_nothing_of_its_own, in a process of its own"]
fn errors_in_several_threads() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("a.h5");
    let file = hdf5::File::create(&path).unwrap();
    let dataset = file.new_dataset::<f64>().shape((13, 7)).create("x").unwrap();
    dataset.write_raw(&[0.0; 91]).unwrap();
    drop((dataset, file));
    let bytes = fs::read(&path).unwrap();
    let mut truncated = RowFile::open(&path).unwrap();
    fs::write(&path, &bytes[..bytes.len() / 2]).unwrap();
    assert!(truncated.read(0, Mat::<f64>::zeros(13, 7).as_mut()).is_err());
    drop(truncated);
    for _ in 0..3 {
        let path = path.clone();
        let refused = std::thread::spawn(move || {
            let missing = format!("{}:/none", path.display());
            RowFile::open(&path).is_err() && RowFile::open(missing).is_err()
        });
        assert!(refused.join().unwrap());
    }
}

#[test]
fn hdf5_prints_nothing_of_its_own() {
    let tests = Command::new(std::env::current_exe().unwrap())
        .args(["--ignored", "--nocapture", "errors_in_several_threads"])
        .output()
        .unwrap();
    let text = String::from_utf8_lossy(&tests.stdout).into_owned();
    assert!(tests.status.success() && text.contains("1 passed"), "{text}");
    assert_eq!(String::from_utf8_lossy(&tests.stderr), "");
}
