//! What becomes of outputs once a program has discarded them.

use std::process::Command;
use std::sync::mpsc;
use std::time::Duration;

use catamaran::io::{Output, Overwrite, discard_unfinished, try_discard_unfinished};

/// Calls of outputs after all of them were discarded, by a thread that the test can give up.
#[test]
#[ignore = "closes all outputs of its process: run by discarded_outputs_stay_errors"]
fn outputs_after_they_were_discarded() {
    let (tell, told) = mpsc::channel();
    std::thread::spawn(move || {
        let folder = tempfile::tempdir().unwrap();
        let create = |name: &str| Output::create(&folder.path().join(name), Overwrite::Replace);
        let names = || -> Vec<String> {
            let entries = std::fs::read_dir(folder.path()).unwrap();
            entries.map(|e| e.unwrap().file_name().into_string().unwrap()).collect()
        };
        let [begun, dropped, kept] = ["a", "b", "c"].map(|name| create(name).unwrap());
        kept.commit().unwrap();
        discard_unfinished();
        assert_eq!(names(), ["c"]);
        drop(dropped);
        for refused in [begun.commit(), create("d").map(drop), create("c").map(drop)] {
            let what = refused.unwrap_err().to_string();
            assert!(what.contains("discarded its unfinished files"), "{what}");
        }
        assert!(try_discard_unfinished(Duration::from_secs(1)));
        assert_eq!(names(), ["c"]);
        tell.send(()).unwrap();
    });
    told.recv_timeout(Duration::from_secs(60)).expect("no call waits");
}

#[test]
fn discarded_outputs_stay_errors() {
    let tests = Command::new(std::env::current_exe().unwrap())
        .args(["--ignored", "--exact", "outputs_after_they_were_discarded"])
        .output()
        .unwrap();
    let text = String::from_utf8_lossy(&tests.stdout).into_owned();
    assert!(tests.status.success() && text.contains("1 passed"), "{text}");
}
