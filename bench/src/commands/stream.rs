//! `stream`: A^T A of a file beside reading it alone and computing alone.

use std::path::{Path, PathBuf};
use std::process::Command;
use std::time::Instant;

use catamaran::base::{available_cores, block_rows};
use catamaran::io::{Output, Overwrite, RowFile, write};
use catamaran::rows::{Accumulator, RowBlocks, stream};
use catamaran::{AtaOptions, Par, Uplo};
use catamaran_bench::input::{Distribution, Shape, matrix};
use catamaran_bench::race::median;
use catamaran_bench::{Result, host, record};
use faer::{MatMut, MatRef};

#[derive(clap::Args)]
pub struct Arguments {
    /// Shapes of A, f64: N or MxN.
    #[arg(
        long,
        value_delimiter = ',',
        default_value = "4000000x32,500000x256,131072x1024,32768x4096"
    )]
    sizes: Vec<Shape>,
    /// Where the file of A goes, of which there is one at a time.
    #[arg(long, default_value = "target")]
    folder: PathBuf,
    /// Threads.
    #[arg(long, default_value_t = available_cores())]
    threads: usize,
    /// Repetitions.
    #[arg(long, default_value_t = 5)]
    repeat: usize,
    /// Leave the file in the page cache, instead of asking the system to forget it before each
    /// reading.
    #[arg(long)]
    cached: bool,
    /// Writes NAME.csv and host.txt under bench/record.
    #[arg(long, value_name = "NAME")]
    record: Option<String>,
}

/// Seconds of reading alone, computing alone, and the stream.
type Sample = [f64; 3];

pub fn run(arguments: &Arguments) -> Result<()> {
    let host = host::describe(&[]);
    let cache = if arguments.cached { "from the page cache" } else { "page cache dropped by dd" };
    print!("{host}\nthreads   {}; {cache}\n\n", arguments.threads);
    println!("{:>16} {:>9} {:>9} {:>9} {:>6}", "m x n", "read GB/s", "comp GB/s", "GB/s", "ratio");
    let mut lines = Vec::new();
    for &shape in &arguments.sizes {
        let file = arguments.folder.join("catamaran-bench-stream.npy");
        let samples = measure(arguments, shape, &file);
        std::fs::remove_file(&file)?;
        let samples = samples?;
        let bytes = 8.0 * shape.m as f64 * shape.n as f64;
        let [read, compute, streamed] =
            [0, 1, 2].map(|k| bytes / 1e9 / median(samples.iter().map(|s| s[k]).collect()));
        // Relative to the slower one of the same repetition.
        let ratio = median(samples.iter().map(|s| s[0].max(s[1]) / s[2]).collect());
        let size = format!("{} x {}", shape.m, shape.n);
        println!("{size:>16} {read:>9.2} {compute:>9.2} {streamed:>9.2} {ratio:>6.3}");
        lines.push(format!(
            "{},{},f64,{},{},{},{read:.3},{compute:.3},{streamed:.3},{ratio:.3}",
            shape.m, shape.n, arguments.threads, arguments.repeat, !arguments.cached
        ));
    }
    if let Some(name) = &arguments.record {
        let header = "m,n,type,threads,repetitions,cold,read_gbs,compute_gbs,stream_gbs,ratio";
        let (name, csv) = (format!("{name}.csv"), record::csv(header, lines));
        let folder = record::write(&[(&name, csv), ("host.txt", host)])?;
        println!("\nrecorded in {}", folder.display());
    }
    Ok(())
}

fn measure(arguments: &Arguments, shape: Shape, file: &Path) -> Result<Vec<Sample>> {
    let Shape { m, n } = shape;
    let a = matrix::<f64>(shape, Distribution::Uniform, 1);
    let view = MatRef::from_row_major_slice(&a, m, n);
    write(Output::create(file, Overwrite::Replace)?, view)?;
    // The trace of C, which does not depend on the algorithm.
    let trace: f64 = a.iter().map(|x| x * x).sum();
    let height = block_rows::<f64>(n, false);
    let mut block = a[..height.min(m) * n].to_vec();
    drop(a);

    let options = AtaOptions::new().par(Par::Threads(arguments.threads));
    let mut samples = Vec::new();
    for _ in 0..arguments.repeat {
        let mut sample = [0.0; 3];
        forget(arguments, file)?;
        let mut rows = RowFile::open(file)?;
        sample[0] = timed(|| {
            for first in (0..m).step_by(height) {
                let count = height.min(m - first);
                let out = MatMut::from_row_major_slice_mut(&mut block[..count * n], count, n);
                rows.read(first, out)?;
            }
            Ok(())
        })?;
        let mut sum = Accumulator::<f64>::new(n, false)?;
        sample[1] = timed(|| {
            for first in (0..m).step_by(height) {
                let count = height.min(m - first);
                let rows = MatRef::from_row_major_slice(&block[..count * n], count, n);
                sum.add_block(rows, None, &options)?;
            }
            Ok(())
        })?;
        drop(sum);
        forget(arguments, file)?;
        let mut rows = RowFile::open(file)?;
        let mut sum = Accumulator::<f64>::new(n, false)?;
        sample[2] =
            timed(|| Ok(stream(&mut rows, None, height, &mut sum, &options, &mut |_| Ok(()))?))?;
        let c = sum.finish(1.0, Uplo::Lower)?;
        let found: f64 = (0..n).map(|j| c.as_ref()[(j, j)]).sum();
        if (found - trace).abs() > 1e-9 * trace {
            return Err(format!(
                "{m} x {n}: wrong result, the trace is {found}, should be {trace}"
            )
            .into());
        }
        samples.push(sample);
    }
    Ok(samples)
}

fn timed(work: impl FnOnce() -> Result<()>) -> Result<f64> {
    let start = Instant::now();
    work()?;
    Ok(start.elapsed().as_secs_f64())
}

/// Drops the file from the page cache with dd, which needs no root privileges and does not disturb
/// other programs.
fn forget(arguments: &Arguments, file: &Path) -> Result<()> {
    if arguments.cached {
        return Ok(());
    }
    let mut input = std::ffi::OsString::from("if=");
    input.push(file);
    let done =
        Command::new("dd").arg(input).args(["iflag=nocache", "count=0", "status=none"]).status()?;
    if done.success() { Ok(()) } else { Err("dd failed; --cached does without it".into()) }
}
