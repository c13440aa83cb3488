//! `mpirun -n P catamaran-ata-mpi`: A^T A on many ranks, beside ScaLAPACK's pdsyrk in the same run.
//!
//! See README.md of the package for what is measured and how.

mod job;
mod ours;
mod ranks;
mod report;
mod rival;
mod scalapack;

use std::path::{Path, PathBuf};
use std::time::Duration;

use catamaran::mpi::{MpiReal, World};
use catamaran_bench::input::Shape;
use catamaran_bench::race::Outcome;
use catamaran_bench::{Result, host, peak, record};
use clap::Parser;

use job::{Job, Mode};
use ours::Ours;
use ranks::Ranks;
use report::{Cost, Row, Times};
use rival::Pdsyrk;
use scalapack::Scalapack;

/// A^T A on the ranks of mpirun, repeated and measured.
#[derive(Parser)]
#[command(name = "catamaran-ata-mpi")]
struct Arguments {
    /// Rows of A.
    #[arg(short, default_value_t = 4096)]
    m: usize,
    /// Columns of A.
    #[arg(short, default_value_t = 4096)]
    n: usize,
    /// Where A is, and where C shall be.
    #[arg(long, value_enum, default_value_t = Mode::Auto)]
    mode: Mode,
    /// Entries are f32 instead of f64.
    #[arg(long)]
    f32: bool,
    /// Threads of each rank.
    #[arg(long, default_value_t = 1, value_parser = clap::value_parser!(u16).range(1..))]
    threads: u16,
    /// Repetitions; one more comes first, and is not counted.
    #[arg(long, default_value_t = 5, value_parser = clap::value_parser!(u16).range(1..))]
    repeat: u16,
    /// Seed of A.
    #[arg(long, default_value_t = 1)]
    seed: u64,
    /// Checks the last result: with random vectors, and against the rival's.
    #[arg(long)]
    check: bool,
    /// Prints words and messages of a rank beside the lower bound, and the distributions that the rival tries.
    #[arg(long)]
    explain: bool,
    /// Whom to race: pdsyrk, of the system's ScaLAPACK for this MPI, or pdsyrk=PATH of another one.
    #[arg(long)]
    rival: Option<Rival>,
    /// Writes the race into NAME.csv, in the place of an earlier one of the same shape, and host.txt under
    /// bench/record.
    #[arg(long, value_name = "NAME")]
    record: Option<String>,
}

#[derive(Clone)]
struct Rival {
    path: Option<PathBuf>,
}

impl std::str::FromStr for Rival {
    type Err = String;

    fn from_str(text: &str) -> std::result::Result<Self, String> {
        match text.split_once('=') {
            Some(("pdsyrk", path)) => Ok(Self { path: Some(path.into()) }),
            None if text == "pdsyrk" => Ok(Self { path: None }),
            _ => Err("no such rival: pdsyrk, or pdsyrk=PATH".into()),
        }
    }
}

/// How long the speed of all cores together is measured.
const PEAK_TIME: Duration = Duration::from_millis(200);
/// Random vectors of the check.
const ROUNDS: u32 = 20;

fn main() {
    let arguments = Arguments::parse();
    let done = host::with_environment_for_rivals(Path::new("target/rivals"))
        .and_then(|()| with_mpi(&arguments));
    if let Err(error) = done {
        // Errors are those of all ranks, and one tells them.
        if !error.to_string().is_empty() {
            eprintln!("catamaran-ata-mpi: {error}");
        }
        std::process::exit(1);
    }
}

/// The race between the start and the end of MPI; the error is empty but on rank 0.
fn with_mpi(arguments: &Arguments) -> Result<()> {
    let (universe, _) = mpi::initialize_with_threading(mpi::Threading::Funneled)
        .ok_or("MPI runs already")?;
    let comm = universe.world();
    let ranks = Ranks(&comm);
    let done = if arguments.f32 {
        race::<f32>(arguments, &ranks)
    } else {
        race::<f64>(arguments, &ranks)
    };
    done.map_err(|error| if ranks.own() == 0 { error } else { "".into() })
}

fn race<T: MpiReal>(arguments: &Arguments, ranks: &Ranks<'_>) -> Result<()> {
    let say = |text: &str| {
        if ranks.own() == 0 {
            println!("{text}");
        }
    };
    let world = World::new(ranks.0);
    let job = arguments.job(ranks.count());
    let threads = rayon::ThreadPoolBuilder::new().num_threads(job.threads).build_global();
    ranks.agree(threads.map_err(Into::into))?;
    let mpi_version = mpi_version();
    let peak = Peak::measure(ranks, &job, size_of::<T>());
    say(&format!(
        "A {} x {} {}, mode {}\nranks     {} x {} threads on {} machines, {mpi_version}\n{peak}",
        job.shape.m,
        job.shape.n,
        name_of::<T>(),
        job.mode,
        ranks.count(),
        job.threads,
        ranks.machines(),
    ));

    let mut ours = ranks.agree(Ours::<T>::new(&world, job))?;
    // The first run pays for threads and buffers.
    ours.run()?;
    let load = |r: &Rival| ranks.agree(Scalapack::load(r.path.as_deref(), &mpi_version, job.threads));
    let scalapack = arguments.rival.as_ref().map(load).transpose()?;
    let tell = |distribution: &Distribution, seconds: f64| {
        if arguments.explain {
            say(&format!("          {distribution}: {seconds:.6} s"));
        }
    };
    let distribution = scalapack.as_ref().map(|s| fastest(s, ranks, job, tell)).transpose()?;
    let chosen = scalapack.as_ref().zip(distribution);
    let grid = chosen.map(|(scalapack, distribution)| {
        say(&format!("rival     pdsyrk, {}; {distribution}", scalapack.description));
        (distribution.grid(scalapack), distribution)
    });
    let new = |(grid, distribution)| ranks.agree(Pdsyrk::new(grid, job, *distribution));
    let mut rival = grid.as_ref().map(|(g, d)| new((g, d))).transpose()?;
    if let Some(rival) = &mut rival {
        rival.run();
    }

    say(&format!("\n{}", report::HEADER));
    let mut all_times = Vec::new();
    let mut rival_seconds = Vec::new();
    let mut cost = Cost::default();
    for repetition in 1..=usize::from(arguments.repeat) {
        // By turns, so that none always follows the other.
        for turn in 0..2 {
            if (repetition + turn) % 2 == 1 {
                let (times, counted) = measure(&mut ours, &world, ranks)?;
                all_times.push(times);
                cost = counted;
            } else if let Some(rival) = &mut rival {
                rival.forget();
                rival_seconds.push(ranks.largest(ranks.time(|| rival.run()).0));
            }
        }
        let (times, rival) = (&all_times[repetition - 1], rival_seconds.last());
        let rival = rival.map(|&seconds| (seconds, seconds / times.wall));
        say(&report::line(&repetition.to_string(), &job, times, peak.gflops, rival));
    }
    let outcome = |contender: &str, is_rival, seconds| Outcome {
        contender: contender.to_owned(),
        is_rival,
        seconds,
        error: 0.0,
    };
    let own = outcome("cata", false, all_times.iter().map(|t| t.wall).collect());
    let theirs = rival.is_some().then(|| outcome("pdsyrk", true, rival_seconds));
    let ratio = theirs.as_ref().map(|theirs| (theirs.median(), own.ratio_to(theirs)));
    say(&report::line("med.", &job, &Times::median(&all_times), peak.gflops, ratio));

    let mut error = None;
    if arguments.check {
        let verification = ours.verify(ROUNDS)?;
        let verdict = verification.map(|v| v.passed);
        if let Some(v) = verification {
            say(&format!("\nverified  {}, residual {:.1e} of {:.1e}", v.passed, v.residual, v.tolerance));
        }
        let wrong = verdict == Some(false);
        ranks.agree(if wrong { Err("the result is wrong".into()) } else { Ok(()) })?;
        if let (Some(rival), Some((grid, _))) = (rival, &grid) {
            let n = job.shape.n;
            let (own, theirs) = (ours.into_lower()?, rival.into_lower(grid, ranks, n)?);
            if ranks.own() == ours::ROOT {
                let difference = report::difference(n, &own, &theirs);
                say(&format!("error     {difference:.1e} of the largest entry, beside pdsyrk"));
                error = Some(difference);
            }
        }
    }
    let bound = bounds::of(&job, ranks.count());
    if arguments.explain {
        say(&format!("\n{}", bounds::describe(&cost, &bound)));
    }
    let Some(name) = &arguments.record else { return Ok(()) };
    let row = Row {
        job: &job,
        ranks: ranks.count(),
        scalar: name_of::<T>(),
        ours: &own,
        rival: theirs.as_ref().zip(grid.as_ref().map(|(_, d)| d.to_string())),
        error,
        words: cost.words,
        bound: bound.words,
    };
    let library = scalapack.as_ref().map_or("none", |s| &s.description);
    let host = format!("{}mpi       {mpi_version}\nscalapack {library}\n{peak}\n", host::describe(&[]));
    let written = if ranks.own() == ours::ROOT {
        record::put(name, Row::HEADER, Row::KEYS, &row.to_string(), host).map(Some)
    } else {
        Ok(None)
    };
    if let Some(folder) = ranks.agree(written)? {
        say(&format!("\nrecorded in {}", folder.display()));
    }
    Ok(())
}

/// One repetition of ours: its times, and what it sent.
fn measure<T: MpiReal>(ours: &mut Ours<'_, T>, world: &World, ranks: &Ranks<'_>) -> Result<(Times, Cost)> {
    ours.forget();
    world.take_traffic();
    world.take_work_time();
    let (wall, done) = ranks.time(|| ours.run());
    done?;
    let compute = world.take_work_time().as_secs_f64();
    let traffic = world.take_traffic();
    let words = traffic.words_sent.max(traffic.words_received);
    let messages = traffic.messages_sent.max(traffic.messages_received);
    let times = Times {
        compute: ranks.largest(compute),
        communication: ranks.largest(wall - compute),
        wall: ranks.largest(wall),
    };
    let cost =
        Cost { words: ranks.largest(words as f64), messages: ranks.largest(messages as f64) };
    Ok((times, cost))
}
