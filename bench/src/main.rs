//! `catamaran-bench`: races against other libraries, and errors beside theirs.

mod commands;

use std::path::Path;

use catamaran_bench::product::Operation;
use catamaran_bench::{Result, host};
use clap::Parser;

use commands::{
    accuracy, batched, cholesky, decimate, functional_map, gram, grid, laplacian, once, ortho,
    race, reproduce, scale, spectrum, stream,
};

/// Races against other libraries, and errors beside theirs.
#[derive(Parser)]
enum Command {
    /// A^T A against the syrk of BLAS libraries.
    Ata(race::Arguments),
    /// A^T B, B of the shape of A, against the gemm of BLAS libraries.
    Atb(race::Arguments),
    /// A^T A at many shapes against the best of syrk and gemm of BLAS libraries.
    Grid(grid::Arguments),
    /// A^T A of many small matrices at once against gemm_batch_strided and a loop of syrk.
    Batched(batched::Arguments),
    /// One contender at one product, in a process of its own.
    Once(once::Arguments),
    /// Errors of A^T A, entry by entry, beside those of the syrk of BLAS libraries.
    Accuracy(accuracy::Arguments),
    /// A^T A on many ranks, as the plans predict it.
    Scale(scale::Arguments),
    /// A^T A of a file, beside reading it alone and computing alone.
    Stream(stream::Arguments),
    /// Eigenpairs of the Laplacian of meshes beside scipy's.
    Spectrum(spectrum::Arguments),
    /// Factorizations of the Laplacian of meshes beside CHOLMOD's.
    Cholesky(cholesky::Arguments),
    /// Tufted Laplacians of meshes beside robust_laplacian's.
    Laplacian(laplacian::Arguments),
    /// A functional map, fitted and refined by ZoomOut, beside pyfmaps.
    FunctionalMap(functional_map::Arguments),
    /// Least squares, singular values and principal components beside numpy, scipy, statsmodels and
    /// scikit-learn.
    Gram(gram::Arguments),
    /// Gram-Schmidt beside column-wise numpy and LAPACK's pivoted QR.
    Ortho(ortho::Arguments),
    /// Decimation of meshes beside other libraries.
    Decimate(decimate::Arguments),
    /// Tables and figures of the thesis, measured again.
    Reproduce(reproduce::Arguments),
}

fn main() {
    let command = Command::parse();
    let beside = |libraries: &Path, run: &dyn Fn() -> Result<()>| {
        host::with_environment_for_rivals(libraries, host::Kernels::OfLibrary).and_then(|()| run())
    };
    let done = match &command {
        Command::Ata(a) => beside(&a.common.libraries, &|| race::run(Operation::Syrk, a)),
        Command::Atb(a) => beside(&a.common.libraries, &|| race::run(Operation::Gemm, a)),
        Command::Grid(a) => beside(&a.common.libraries, &|| grid::run(a)),
        Command::Batched(a) => beside(&a.common.libraries, &|| batched::run(a)),
        Command::Once(a) => beside(&a.libraries, &|| once::print(a)),
        Command::Accuracy(a) => beside(&a.common.libraries, &|| accuracy::run(a)),
        Command::Scale(a) => scale::run(a),
        Command::Stream(a) => stream::run(a),
        Command::Spectrum(a) => spectrum::run(a),
        Command::Cholesky(a) => cholesky::run(a),
        Command::Laplacian(a) => laplacian::run(a),
        Command::FunctionalMap(a) => functional_map::run(a),
        Command::Gram(a) => gram::run(a),
        Command::Ortho(a) => ortho::run(a),
        Command::Decimate(a) => decimate::run(a),
        Command::Reproduce(a) => reproduce::run(a),
    };
    if let Err(error) = done {
        eprintln!("catamaran-bench: {error}");
        std::process::exit(1);
    }
}
