//! `once`: one contender computes one product in a process of its own, so that its memory can be
//! told; other commands run it in turns.

use std::path::{Path, PathBuf};

use catamaran::base::{Pin, ThreadPool};
use catamaran_bench::Result;
use catamaran_bench::child::{self, Report};
use catamaran_bench::contender::{Contender, Scalar, scheme_named};
use catamaran_bench::input::{Distribution, Shape, matrix};
use catamaran_bench::product::{Operation, Product};
use catamaran_bench::race::{Rules, race};
use catamaran_bench::reference::Reference;

use super::{SAMPLE, Type, backend, ours, rival};

#[derive(clap::Args)]
pub struct Arguments {
    /// A rival, or SCHEME/BACKEND of this library, such as ata2:tasks=16/native.
    contender: String,
    /// The shape of A.
    shape: Shape,
    /// A^T B instead of A^T A.
    #[arg(long)]
    atb: bool,
    /// Type of the entries.
    #[arg(long, value_enum, default_value = "f64")]
    r#type: Type,
    /// Threads.
    #[arg(long, default_value_t = 1)]
    threads: usize,
    /// Where scripts/rivals installed the libraries.
    #[arg(long, default_value = "target/rivals")]
    pub libraries: PathBuf,
}

/// Prints the seconds of a call, the bytes of C and of all that the contender needs besides, and
/// the error: the line that [`run`] reads.
pub fn print(arguments: &Arguments) -> Result<()> {
    let Arguments { contender, libraries, .. } = arguments;
    let contender = match contender.split_once('/') {
        // The path of a rival NAME=PATH has slashes, too.
        Some((scheme, name))
            if scheme_named(scheme.split(':').next().unwrap_or(scheme)).is_ok() =>
        {
            ours(scheme, &backend(name, libraries)?)?
        }
        _ => rival(contender, libraries)?,
    };
    let line = match arguments.r#type {
        Type::F64 => measured::<f64>(&contender, arguments),
        Type::F32 => measured::<f32>(&contender, arguments),
    };
    println!("{}", line?);
    Ok(())
}

fn measured<T: Scalar>(contender: &Contender, arguments: &Arguments) -> Result<String> {
    let Arguments { shape, threads, .. } = *arguments;
    let operand = |seed| matrix::<T>(shape, Distribution::Uniform, seed);
    let a = operand(1);
    let b = arguments.atb.then(|| operand(2));
    let product = match &b {
        Some(b) => Product::gemm(shape, &a, b),
        None => Product::syrk(shape, &a),
    };
    let reference = Reference::new(&product, SAMPLE, 1);
    let team = ThreadPool::new(threads, Pin::No)?;
    let rules = Rules { repeat: 1, deadline: None, patience: None };
    child::forget_peak();
    let [before, _] = child::memory();
    let outcomes =
        race(std::slice::from_ref(contender), product, threads, &team, &reference, &rules)?;
    let [_, peak] = child::memory();
    Ok(Report::line(outcomes[0].median(), peak - before, &[outcomes[0].error]))
}

/// Runs `contender` once in another process: the report's further number is the error.
///
/// # Errors
/// When it fails, as with a wrong result.
pub fn run(
    contender: &str,
    operation: Operation,
    shape: Shape,
    scalar: Type,
    threads: usize,
    libraries: &Path,
) -> Result<Report> {
    let (shape, t) = (format!("{}x{}", shape.m, shape.n), threads.to_string());
    let libraries = libraries.display().to_string();
    let mut arguments = vec!["once", contender, &shape, "--type", scalar.name(), "--threads", &t];
    arguments.extend(["--libraries", &libraries]);
    if operation == Operation::Gemm {
        arguments.push("--atb");
    }
    child::run(&std::env::current_exe()?, &arguments, threads)
}
