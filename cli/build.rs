//! The commit that the program is built from, as `CATAMARAN_COMMIT`: empty outside of the
//! repository.

use std::path::Path;
use std::process::Command;

fn main() {
    println!("cargo::rerun-if-changed=build.rs");
    let mut commit = None;
    // A package that lies in another repository does not have its commits.
    if git(&["rev-parse", "--show-prefix"]).as_deref() == Some("cli/") {
        commit = git(&["rev-parse", "--short=12", "HEAD"]);
        watch();
    }
    println!("cargo::rustc-env=CATAMARAN_COMMIT={}", commit.unwrap_or_default());
}

/// Makes cargo run this script again after a commit or a checkout. A file that does not exist
/// would make it run each time.
fn watch() {
    let branch = git(&["symbolic-ref", "--quiet", "HEAD"]);
    // A branch in packed-refs has no file of its own, but HEAD has a log.
    for name in ["HEAD", "logs/HEAD"].into_iter().chain(branch.as_deref()) {
        let path = git(&["rev-parse", "--git-path", name]).unwrap_or_default();
        if Path::new(&path).is_file() {
            println!("cargo::rerun-if-changed={path}");
        }
    }
}

/// Returns what git prints, without the end of the line; nothing if it fails.
fn git(arguments: &[&str]) -> Option<String> {
    let mut command = Command::new("git");
    // A hook of git sets these, and then the folder of the package counts as the whole tree.
    command.env_remove("GIT_DIR").env_remove("GIT_WORK_TREE");
    let output = command.args(arguments).output().ok()?;
    let text = String::from_utf8(output.stdout).ok()?;
    output.status.success().then(|| text.trim().to_owned())
}
