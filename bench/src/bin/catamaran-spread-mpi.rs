//! `mpirun -n P catamaran-spread-mpi`: measures eigenpairs and Gram-Schmidt of rows that are spread
//! over the ranks: seconds, and the memory of the rank that needs the most.
//! `scripts/race-mpi spread` runs it for many P.

use std::process::ExitCode;

use catamaran::Par;
use catamaran::base::Rng;
use catamaran::faer::Mat;
use catamaran::ortho::GramSchmidtOptions;
use catamaran::ranks::{World, cholesky_qr, eigs, gram_schmidt};
use catamaran::sparse::{CsMat, EigenOptions, Mass};
use catamaran_bench::child::{forget_peak, memory};
use catamaran_bench::curves::{Plot, svg};
use catamaran_bench::race::median;
use catamaran_bench::{Result, host, record};
use clap::{Parser, ValueEnum};
use mpi::collective::SystemOperation;
use mpi::traits::CommunicatorCollectives;

/// Times a spread computation on the ranks of this job, one thread each.
#[derive(Parser)]
struct Arguments {
    what: What,
    /// Rows: of a triangulated grid (the next square number), or of a random matrix.
    #[arg(long, default_value_t = 100_489)]
    rows: usize,
    /// Eigenpairs, or columns of the matrix.
    #[arg(long, default_value_t = 100)]
    columns: usize,
    #[arg(long, default_value_t = 3)]
    repeat: usize,
    /// Put the line into NAME.csv of the host's folder in bench/record, and the table as a picture
    /// into NAME.svg of target/record.
    #[arg(long, value_name = "NAME")]
    record: Option<String>,
}

#[derive(Clone, Copy, PartialEq, ValueEnum)]
enum What {
    /// The smallest eigenpairs of the graph Laplacian of a triangulated grid.
    Eigenpairs,
    GramSchmidt,
    CholeskyQr,
}

const HEADER: &str = "what,rows,columns,ranks,seconds,memory_mb,words_sent,error";
/// Number of columns that identify a line.
const KEYS: usize = 4;

fn main() -> ExitCode {
    match run(&Arguments::parse()) {
        Ok(()) => ExitCode::SUCCESS,
        Err(error) => {
            eprintln!("catamaran-spread-mpi: {error}");
            ExitCode::FAILURE
        }
    }
}

fn run(arguments: &Arguments) -> Result<()> {
    let (universe, _) =
        mpi::initialize_with_threading(mpi::Threading::Funneled).ok_or("MPI is already running")?;
    let world = World::new(&universe.world())?;
    let input = Input::new(arguments, &world)?;
    let (mut seconds, mut bytes, mut words, mut error) = (vec![], 0.0_f64, 0.0_f64, 0.0_f64);
    for _ in 0..arguments.repeat.max(1) {
        world.take_traffic();
        forget_peak();
        let [before, _] = memory();
        world.communicator().barrier();
        let start = std::time::Instant::now();
        let found = input.run(&world, arguments)?;
        seconds.push(largest(&world, start.elapsed().as_secs_f64()));
        let [_, peak] = memory();
        bytes = bytes.max(largest(&world, peak.saturating_sub(before) as f64));
        words = largest(&world, world.take_traffic().words_sent as f64);
        error = error.max(found);
    }
    let line = format!(
        "{},{},{},{},{:.3},{:.1},{words:.0},{error:.2e}",
        arguments.what.to_possible_value().expect("none is skipped").get_name(),
        input.rows(arguments),
        arguments.columns,
        world.size(),
        median(seconds),
        bytes / 1e6
    );
    if world.rank() == 0 {
        println!("{HEADER}\n{line}");
        if let Some(name) = &arguments.record {
            let folder = record::put(name, HEADER, KEYS, &line, host::describe(&[]), picture)?;
            println!("recorded in {}", folder.display());
        }
    }
    Ok(())
}

/// Returns the largest of all ranks' numbers.
fn largest(world: &World, own: f64) -> f64 {
    let mut all = 0.0;
    world.communicator().all_reduce_into(&own, &mut all, SystemOperation::max());
    all
}

/// The rows of this rank.
enum Input {
    Grid { side: usize, laplacian: CsMat<f64> },
    Matrix(Mat<f64>),
}

impl Input {
    fn new(arguments: &Arguments, world: &World) -> Result<Self> {
        let span =
            |n: usize| world.rank() * n / world.size()..(world.rank() + 1) * n / world.size();
        if arguments.what == What::Eigenpairs {
            let side = (arguments.rows as f64).sqrt().ceil() as usize;
            return Ok(Self::Grid { side, laplacian: grid(side, span(side * side)) });
        }
        let mut rng = Rng::new(1 + world.rank() as u64);
        let own = span(arguments.rows).len();
        Ok(Self::Matrix(Mat::from_fn(own, arguments.columns, |_, _| rng.uniform() - 0.5)))
    }

    fn rows(&self, arguments: &Arguments) -> usize {
        match self {
            Self::Grid { side, .. } => side * side,
            Self::Matrix(_) => arguments.rows,
        }
    }

    /// Runs the computation; returns the largest residual, or deviation from orthonormal columns.
    fn run(&self, world: &World, arguments: &Arguments) -> Result<f64> {
        let a = match self {
            Self::Grid { laplacian, .. } => {
                let options = EigenOptions::new().k(arguments.columns).par(Par::Seq);
                let mass = Mass::identity(laplacian.rows());
                let pairs = eigs(world, laplacian.view(), &mass, &options)?;
                return Ok(pairs.residuals.into_iter().fold(0.0, f64::max));
            }
            Self::Matrix(a) => a,
        };
        let mass = Mass::identity(a.nrows());
        let q = if arguments.what == What::GramSchmidt {
            gram_schmidt(world, a.as_ref(), &mass, &GramSchmidtOptions::new().par(Par::Seq))?.q
        } else {
            let mut q = a.clone();
            cholesky_qr(world, q.as_mut(), &mass, Par::Seq)?;
            q
        };
        let gram = q.transpose() * &q;
        let own: Vec<f64> = gram.col_iter().flat_map(|column| column.iter().copied()).collect();
        let mut all = vec![0.0; own.len()];
        world.communicator().all_reduce_into(&own[..], &mut all[..], SystemOperation::sum());
        let ones = (0..gram.nrows()).map(|i| i * (gram.nrows() + 1));
        ones.for_each(|diagonal| all[diagonal] -= 1.0);
        Ok(all.into_iter().fold(0.0, |most, x: f64| most.max(x.abs())))
    }
}

/// Returns some rows of the graph Laplacian of a grid of squares, each cut by a diagonal.
fn grid(side: usize, rows: std::ops::Range<usize>) -> CsMat<f64> {
    let (mut starts, mut columns, mut entries) = (vec![0], vec![], vec![]);
    for row in rows.clone() {
        let (i, j) = ((row / side) as isize, (row % side) as isize);
        let near = [(-1, -1), (-1, 0), (0, -1), (0, 0), (0, 1), (1, 0), (1, 1)];
        let inside = |x: isize| (0..side as isize).contains(&x);
        let near = near.map(|(di, dj)| (i + di, j + dj));
        let near = near.into_iter().filter(|&(i, j)| inside(i) && inside(j));
        let first = columns.len();
        columns.extend(near.map(|(i, j)| i as usize * side + j as usize));
        let degree = (columns.len() - first - 1) as f64;
        entries.extend(columns[first..].iter().map(|&j| if j == row { degree } else { -1.0 }));
        starts.push(columns.len());
    }
    CsMat::new((rows.len(), side * side), starts, columns, entries)
}

/// Returns a picture of the memory and seconds of the table over ranks.
fn picture(table: &str) -> String {
    let rows: Vec<Vec<&str>> =
        table.lines().skip(1).map(|line| line.split(',').collect()).collect();
    let panel = |title: &str, column: usize| {
        let mut series: Vec<(String, Vec<(f64, f64)>)> = vec![];
        for row in &rows {
            let number = |column: usize| row.get(column).and_then(|x| x.parse().ok());
            let (Some(x), Some(y)) = (number(3), number(column)) else { continue };
            let name = format!("{} {} x {}", row[0], row[1], row[2]);
            match series.iter_mut().find(|(other, _)| *other == name) {
                Some((_, points)) => points.push((x, y)),
                None => series.push((name, vec![(x, y)])),
            }
        }
        let (title, across) = (title.into(), "ranks".into());
        Plot { title, across, logarithmic: true, scattered: false, series }
    };
    svg(&[panel("MB on the rank with most", 5), panel("seconds", 4)])
}
