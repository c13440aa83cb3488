//! `catamaran-bench`: races against other libraries, and errors beside theirs.

mod commands;

use catamaran_bench::host;
use catamaran_bench::product::Operation;
use clap::Parser;

use commands::{accuracy, race};

/// Races against other libraries, and errors beside theirs.
#[derive(Parser)]
enum Command {
    /// A^T A against the syrk of BLAS libraries.
    Ata(race::Arguments),
    /// A^T B, B of the shape of A, against the gemm of BLAS libraries.
    Atb(race::Arguments),
    /// Errors of A^T A, entry by entry, beside those of the syrk of BLAS libraries.
    Accuracy(accuracy::Arguments),
}

fn main() {
    let command = Command::parse();
    let libraries = match &command {
        Command::Ata(arguments) | Command::Atb(arguments) => &arguments.libraries,
        Command::Accuracy(arguments) => &arguments.libraries,
    };
    let done = host::with_environment_for_rivals(libraries).and_then(|()| match &command {
        Command::Ata(arguments) => race::run(Operation::Syrk, arguments),
        Command::Atb(arguments) => race::run(Operation::Gemm, arguments),
        Command::Accuracy(arguments) => accuracy::run(arguments),
    });
    if let Err(error) = done {
        eprintln!("catamaran-bench: {error}");
        std::process::exit(1);
    }
}
