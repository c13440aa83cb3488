//! The race: this library and the rival in turns, the times of each repetition, and the report.

use std::time::Duration;
use std::{fs, thread};

use catamaran::Par;
use catamaran::base::available_cores;
use catamaran::ranks::{Launch, MpiReal, Traffic, World, mpi_version};
use catamaran_bench::race::Outcome;
use catamaran_bench::{Result, host, peak, record};

use crate::arguments::Arguments;
use crate::checks::{self, Check};
use crate::job::Job;
use crate::ours::{Ours, ROOT};
use crate::picture;
use crate::ranks::Ranks;
use crate::report::{self, Cost, Counted, Times};
use crate::rival::{Distribution, Pdsyrk, fastest};
use crate::row::Row;
use crate::scalapack::{Grid, Scalapack};
use crate::scaling;

/// Duration of the measurement of the speed of all cores together.
const PEAK_TIME: Duration = Duration::from_millis(200);
/// Number of random vectors of the check.
const ROUNDS: u32 = 20;

/// Runs the race on all ranks; rank 0 reports. Returns whether all checks passed, on every rank.
///
/// # Errors
/// On all ranks if any rank has an error.
pub fn race<T: MpiReal>(arguments: &Arguments, ranks: &Ranks<'_>) -> Result<bool> {
    let setting = Setting::prepare::<T>(arguments, ranks)?;
    setting.introduce::<T>();
    if let Some(name) = &arguments.scaling {
        setting.scale::<T>(name)?;
        return Ok(true);
    }

    let job = setting.job;
    let world = World::new(ranks.0)?;
    let mut ours = ranks.agree(Ours::<T>::new(&world, job, arguments.file.as_deref()))?;
    // The first run includes the creation of threads and buffers.
    ours.run()?;
    let scalapack = setting.load_rival::<T>()?;
    let seat = scalapack.as_ref().map(|s| setting.find_seat(s)).transpose()?;
    let mut rival = seat.as_ref().map(|seat| setting.enter(seat)).transpose()?;

    let measured = setting.measure(&world, &mut ours, rival.as_mut())?;

    let verdict = if arguments.check {
        setting.check(ours, rival.zip(seat.as_ref()), measured.counted.most)?
    } else {
        Verdict::default()
    };
    let passed = setting.all_passed(&verdict.checks);
    if arguments.explain {
        let costs = report::costs(&job, ranks.count(), &measured.counted);
        setting.say(&format!("\n{costs}"));
    }
    let row = Row {
        job: &job,
        ranks: ranks.count(),
        scalar: scalar::<T>(),
        ours: &measured.ours(),
        times: Times::median(&measured.times),
        peak: setting.peak,
        rival: measured.rival().zip(seat.as_ref().map(|seat| seat.distribution.to_string())),
        residual: verdict.residual,
        error: verdict.error,
        passed: arguments.check.then_some(passed),
        counted: measured.counted,
    };
    setting.say(&format!("\n{}", report::summary(&row, &verdict.checks)));
    let library = seat.as_ref().map_or("none", |seat| seat.library);
    ranks.agree(on_root(ranks, || setting.write_tables(&row, library, passed)))?;
    Ok(passed)
}

/// What holds for the whole race.
struct Setting<'a> {
    arguments: &'a Arguments,
    ranks: &'a Ranks<'a>,
    job: Job,
    /// Version of the MPI library.
    mpi: String,
    /// Speed limit of all ranks in GFLOP/s.
    peak: f64,
    /// The line of the report about it.
    peak_line: String,
}

impl<'a> Setting<'a> {
    /// Checks the launcher and the tables, starts the threads and measures the peak.
    fn prepare<T: MpiReal>(arguments: &'a Arguments, ranks: &'a Ranks<'a>) -> Result<Self> {
        let mpi = mpi_version();
        if let Some(launch) = Launch::of_process() {
            launch.check(ranks.count(), &mpi)?;
        }
        // A table that can't take the row is reported before the work, not after it.
        ranks.agree(on_root(ranks, || check_tables(arguments)))?;
        let mut job = arguments.job(ranks.count());
        // All ranks use as many threads as the one that may use the fewest.
        job.threads = -ranks.largest(-(Par::Threads(job.threads).threads() as f64)) as usize;
        let threads = rayon::ThreadPoolBuilder::new().num_threads(job.threads).build_global();
        ranks.agree(threads.map_err(Into::into))?;
        let (peak, peak_line) = peak_of_all::<T>(ranks, job.threads);
        Ok(Self { arguments, ranks, job, mpi, peak, peak_line })
    }

    /// Prints a line of the report, on the root.
    fn say(&self, text: &str) {
        if self.ranks.own() == ROOT {
            println!("{text}");
        }
    }

    /// Reports what is about to be measured, and where.
    fn introduce<T: MpiReal>(&self) {
        let Self { ranks, job, mpi, .. } = self;
        let machines = ranks.machines();
        self.say(&format!("A         {job}, {}", scalar::<T>()));
        self.say(&format!(
            "ranks     {}, machines: {}, threads of a rank: {}, cores it may use: {}, {mpi}",
            ranks.count(),
            machines,
            job.threads,
            available_cores()
        ));
        self.say(&self.peak_line);
        self.say(&report::memory_line::<T>(job, ranks.count()));
        self.note_too_many_threads();
        if let Some(note) = report::note_of_faster_mode(job, ranks.count()) {
            self.say(&note);
        }
    }

    fn note_too_many_threads(&self) {
        let Self { ranks, job, arguments, .. } = self;
        let asked = usize::from(arguments.threads);
        if job.threads < asked {
            self.say(&format!(
                "note      {} threads of a rank instead of {asked}: at most {} for each core",
                job.threads,
                Par::MOST_PER_CORE
            ));
        }
        let cores_needed = ranks.on_this_machine() * job.threads;
        if ranks.largest(cores_needed as f64 / host::cores() as f64) > 1.0 {
            self.say("note      more threads than cores on a machine: times say little");
        } else if ranks.largest(job.threads as f64 / available_cores() as f64) > 1.0 {
            self.say(
                "note      more threads of a rank than cores it may use: mpirun --bind-to, srun -c",
            );
        }
    }

    /// Measures the scaling, and writes its table and picture.
    fn scale<T: MpiReal>(&self, name: &str) -> Result<()> {
        let Self { arguments, ranks, job, .. } = self;
        self.say(&format!("\n{}", scaling::TITLE));
        let tell = |point: &scaling::Point| self.say(&point.to_string());
        let points = scaling::measure::<T>(arguments, *job, ranks, scalar::<T>(), tell)?;
        let written = on_root(ranks, || {
            let put = |ending: &str, text: String| {
                let path = format!("{name}.{ending}");
                fs::write(&path, text).map_err(|error| format!("{path}: {error}"))
            };
            let lines = points.iter().map(scaling::Point::csv);
            put("csv", record::csv(scaling::HEADER, lines))?;
            Ok(put("svg", scaling::picture(&points))?)
        });
        ranks.agree(written)?;
        self.say(&format!("written to {name}.csv and {name}.svg"));
        Ok(())
    }

    /// Loads the rival's library, if the race has a rival.
    fn load_rival<T: MpiReal>(&self) -> Result<Option<Scalapack<T>>> {
        let Some(rival) = &self.arguments.rival else { return Ok(None) };
        let loaded = Scalapack::<T>::load(rival.path.as_deref(), &self.mpi, self.job.threads);
        self.ranks.agree(loaded).map(Some)
    }

    /// Tries the rival's distributions and returns the fastest.
    fn find_seat<'s, T: MpiReal>(&self, scalapack: &'s Scalapack<T>) -> Result<Seat<'s, T>> {
        let tell = |distribution: &Distribution, seconds: f64| {
            if self.arguments.explain {
                self.say(&format!("tried     pdsyrk, {distribution}: {seconds:.6} s"));
            }
        };
        let distribution = fastest(scalapack, self.ranks, self.job, tell)?;
        let grid = distribution.grid(scalapack);
        Ok(Seat { distribution, grid, library: &scalapack.description })
    }

    /// Creates the rival and lets it run once, as ours has.
    fn enter<'g, T: MpiReal>(&self, seat: &'g Seat<'_, T>) -> Result<Pdsyrk<'g, T>> {
        let Seat { distribution, grid, library } = seat;
        let mut rival = self.ranks.agree(Pdsyrk::new(grid, self.job, *distribution))?;
        rival.run();
        self.say(&format!("rival     pdsyrk, {distribution}; {library}"));
        Ok(rival)
    }

    /// Runs and reports all repetitions.
    fn measure<T: MpiReal>(
        &self,
        world: &World,
        ours: &mut Ours<'_, T>,
        mut rival: Option<&mut Pdsyrk<'_, T>>,
    ) -> Result<Measured> {
        self.say(&format!("\n{}", report::HEADER));
        let mut measured = Measured::default();
        for repetition in 1..=usize::from(self.arguments.repeat) {
            measured.repeat(repetition, self.ranks, world, ours, rival.as_deref_mut())?;
            self.say(&measured.line(repetition - 1, &self.job, self.peak));
        }
        self.say(&measured.median_line(&self.job, self.peak));
        Ok(measured)
    }

    /// Checks our last result, also against the rival's, and the largest cost of a rank against
    /// the plan.
    fn check<T: MpiReal>(
        &self,
        ours: Ours<'_, T>,
        rival: Option<(Pdsyrk<'_, T>, &Seat<'_, T>)>,
        most: Cost,
    ) -> Result<Verdict> {
        let Self { ranks, job, .. } = self;
        let mut verdict = Verdict::default();
        if let Some(verification) = ranks.agree(ours.verify(ROUNDS))? {
            verdict.residual = Some(verification.residual);
            verdict.checks.push(Check {
                what: format!("residual, {ROUNDS} random vectors"),
                value: verification.residual,
                limit: verification.tolerance,
            });
        }
        if let Some((rival, seat)) = rival {
            let value = difference(job, ours, rival, &seat.grid, ranks)?;
            verdict.error = Some(value);
            verdict.checks.push(Check {
                what: "difference from pdsyrk over the largest entry".into(),
                value,
                limit: T::UNIT_ROUNDOFF * job.shape.m.max(32) as f64,
            });
        }
        verdict.checks.extend(checks::of_plan::<T>(job, ranks.count(), most));
        Ok(verdict)
    }

    /// Returns whether all checks passed, the same on every rank.
    fn all_passed(&self, checks: &[Check]) -> bool {
        // Rank 0 decides, because only it has all results in every mode.
        let failed = self.ranks.own() == ROOT && !checks.iter().all(Check::passed);
        self.ranks.largest(f64::from(u8::from(failed))) == 0.0
    }

    /// Writes the row to the tables of `--csv` and `--record`; `library` describes the rival's.
    fn write_tables(&self, row: &Row<'_>, library: &str, passed: bool) -> Result<()> {
        let Self { arguments, mpi, peak_line, .. } = self;
        let line = row.to_string();
        if let Some(path) = &arguments.csv {
            record::append(path, Row::HEADER, &line)?;
            self.say(&format!("appended to {}", path.display()));
        }
        // Wrong results are not recorded.
        if let Some(name) = arguments.record.as_ref().filter(|_| passed) {
            let about = format!("mpi       {mpi}\nscalapack {library}\n{peak_line}\n");
            let host = host::describe(&[]) + &about;
            let folder = record::put(name, Row::HEADER, Row::KEYS, &line, host, picture::of_table)?;
            self.say(&format!("recorded in {}", folder.display()));
        }
        Ok(())
    }
}

/// Does `work` on the root only.
fn on_root(ranks: &Ranks<'_>, work: impl FnOnce() -> Result<()>) -> Result<()> {
    if ranks.own() == ROOT { work() } else { Ok(()) }
}

/// Returns an error if the table of `--csv`, `--scaling` or `--record` has other columns, or can't
/// be written.
fn check_tables(arguments: &Arguments) -> Result<()> {
    let table = arguments.csv.as_deref();
    table.map_or(Ok(()), |path| record::check_writable(path, Row::HEADER))?;
    if let Some(name) = &arguments.scaling {
        record::check_writable(format!("{name}.csv").as_ref(), scaling::HEADER)?;
    }
    let Some(record) = arguments.record.as_deref().map(record::table) else { return Ok(()) };
    if let Some(folder) = record.parent() {
        fs::create_dir_all(folder).map_err(|e| format!("{}: {e}", folder.display()))?;
    }
    record::check_writable(&record, Row::HEADER)
}

/// How the rival takes part: its fastest distribution.
struct Seat<'s, T> {
    distribution: Distribution,
    grid: Grid<'s, T>,
    /// Description of its library.
    library: &'s str,
}

/// The results of the checks.
#[derive(Default)]
struct Verdict {
    /// Residual of the random vectors.
    residual: Option<f64>,
    /// Largest difference of the two results, relative to the largest entry.
    error: Option<f64>,
    checks: Vec<Check>,
}

/// The measurements of the repetitions.
#[derive(Default)]
struct Measured {
    times: Vec<Times>,
    rival_seconds: Vec<f64>,
    /// Traffic of one repetition of ours; all repetitions are alike.
    counted: Counted,
}

impl Measured {
    /// Runs one repetition of both, with alternating order.
    fn repeat<T: MpiReal>(
        &mut self,
        repetition: usize,
        ranks: &Ranks<'_>,
        world: &World,
        ours: &mut Ours<'_, T>,
        mut rival: Option<&mut Pdsyrk<'_, T>>,
    ) -> Result<()> {
        for turn in 0..2 {
            if (repetition + turn) % 2 == 1 {
                ours.forget();
                world.take_traffic();
                world.take_work_time();
                let (wall, done) = ranks.time(|| ours.run());
                done?;
                let compute = world.take_work_time().as_secs_f64();
                self.times.push(Times {
                    compute: ranks.largest(compute),
                    communication: ranks.largest(wall - compute),
                    wall: ranks.largest(wall),
                });
                self.counted = count(ranks, world.take_traffic());
            } else if let Some(rival) = &mut rival {
                rival.forget();
                self.rival_seconds.push(ranks.largest(ranks.time(|| rival.run()).0));
            }
        }
        Ok(())
    }

    fn line(&self, i: usize, job: &Job, peak: f64) -> String {
        let rival = self.rival_seconds.get(i).map(|&s| (s, s / self.times[i].wall));
        report::line(&(i + 1).to_string(), job, &self.times[i], peak, rival)
    }

    fn median_line(&self, job: &Job, peak: f64) -> String {
        let rival = self.rival().map(|rival| (rival.median(), self.ours().ratio_to(&rival)));
        report::line("med.", job, &Times::median(&self.times), peak, rival)
    }

    fn ours(&self) -> Outcome {
        outcome("cata", false, self.times.iter().map(|times| times.wall).collect())
    }

    fn rival(&self) -> Option<Outcome> {
        let seconds = &self.rival_seconds;
        (!seconds.is_empty()).then(|| outcome("pdsyrk", true, seconds.clone()))
    }
}

fn outcome(contender: &str, is_rival: bool, seconds: Vec<f64>) -> Outcome {
    Outcome { contender: contender.into(), is_rival, seconds, error: 0.0 }
}

/// Counts the traffic of all ranks.
fn count(ranks: &Ranks<'_>, traffic: Traffic) -> Counted {
    let [words_sent, words_received, messages_sent, messages_received] = [
        traffic.words_sent,
        traffic.words_received,
        traffic.messages_sent,
        traffic.messages_received,
    ]
    .map(|count| count as f64);
    let both_ways =
        Cost { words: words_sent + words_received, messages: messages_sent + messages_received };
    let most = Cost {
        words: ranks.largest(words_sent.max(words_received)),
        messages: ranks.largest(messages_sent.max(messages_received)),
    };
    Counted { most, both_ways }
}

/// Returns the difference of our last result from the rival's, on the root; see
/// [`report::difference`].
fn difference<T: MpiReal>(
    job: &Job,
    ours: Ours<'_, T>,
    rival: Pdsyrk<'_, T>,
    grid: &Grid<'_, T>,
    ranks: &Ranks<'_>,
) -> Result<f64> {
    let n = job.shape.n;
    let (ours, rival) = (ours.into_lower(ranks)?, rival.into_lower(grid, ranks, n)?);
    Ok(if ranks.own() == ROOT { report::difference(n, &ours, &rival) } else { 0.0 })
}

/// Returns GFLOP/s of all threads of all ranks together, in the precision of T, and a line of the
/// report.
fn peak_of_all<T>(ranks: &Ranks<'_>, threads: usize) -> (f64, String) {
    let (_, peaks) = ranks.time(|| {
        thread::scope(|scope| {
            let all: Vec<_> =
                (0..threads).map(|_| scope.spawn(|| peak::sustained(PEAK_TIME))).collect();
            all.into_iter().filter_map(|thread| thread.join().ok()).collect::<Vec<_>>()
        })
    });
    // A register holds twice as many f32.
    let per_f64 = (8 / size_of::<T>()) as f64;
    let sum = ranks.sum(per_f64 * peaks.iter().map(|peak| peak.gflops).sum::<f64>());
    let instructions = peaks.first().map_or("no instructions", |peak| peak.instructions);
    let what =
        format!("all ranks at the same time, {} multiply-adds, {instructions}", scalar::<T>());
    (sum, format!("peak      {sum:.1} GFLOP/s ({what})"))
}

fn scalar<T>() -> &'static str {
    if size_of::<T>() == 8 { "f64" } else { "f32" }
}
