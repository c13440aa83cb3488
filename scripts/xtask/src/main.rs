//! Chores of the repository: `cargo xtask help`.

mod absent;
#[cfg(test)]
mod conventions;
mod declarations;
mod faces;
mod formats;
mod fortran;
mod generated;
mod header;
mod msrv;
mod notice;
mod options;
mod packages;
mod records;

use std::path::{Path, PathBuf};
use std::process::ExitCode;

const HELP: &str = "\
cargo xtask faces             write docs/faces.md: each operation in each face
cargo xtask faces --check     fail if it is not what would be written
cargo xtask header            write include/catamaran.h and capi/src/absent.rs from capi/src
cargo xtask header --check    fail if they are not what would be written
cargo xtask fortran           write include/catamaran.f90 from include/catamaran.h
cargo xtask fortran --check   fail if it is not what would be written
cargo xtask notice            write NOTICE from the packages in Cargo.lock
cargo xtask notice --check    fail if NOTICE is not what would be written
cargo xtask options           write docs/guide/options.md and docs/guide/mesh-files.md
cargo xtask options --check   fail if they are not what would be written
cargo xtask msrv              fail if a dependency needs a newer Rust than we promise
cargo xtask records           list the records of bench/record that are older than their sources";

fn main() -> ExitCode {
    let arguments: Vec<String> = std::env::args().skip(1).collect();
    let arguments: Vec<&str> = arguments.iter().map(String::as_str).collect();
    let outcome = match arguments[..] {
        ["faces"] => faces::FACES.write(&root()),
        ["faces", "--check"] => faces::FACES.check(&root()),
        ["header"] => header::HEADER.write(&root()).and(absent::ABSENT.write(&root())),
        ["header", "--check"] => header::HEADER.check(&root()).and(absent::ABSENT.check(&root())),
        ["fortran"] => fortran::FORTRAN.write(&root()),
        ["fortran", "--check"] => fortran::FORTRAN.check(&root()),
        ["notice"] => notice::NOTICE.write(&root()),
        ["notice", "--check"] => notice::NOTICE.check(&root()),
        ["options"] => options::OPTIONS.write(&root()).and(formats::FORMATS.write(&root())),
        ["options", "--check"] => {
            options::OPTIONS.check(&root()).and(formats::FORMATS.check(&root()))
        }
        ["records"] => records::list(&root()),
        ["msrv"] => msrv::check(&root()),
        ["help" | "--help"] => {
            println!("{HELP}");
            Ok(())
        }
        _ => Err(format!("what is to be done?\n{HELP}")),
    };
    match outcome {
        Ok(()) => ExitCode::SUCCESS,
        Err(message) => {
            eprintln!("xtask: {message}");
            ExitCode::FAILURE
        }
    }
}

/// Returns the root of the repository, wherever cargo was called.
fn root() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("../..")
}

/// Reads a file of the repository.
fn read(path: &Path) -> Result<String, String> {
    std::fs::read_to_string(path).map_err(|e| format!("{}: {e}", path.display()))
}
