//! Runs contenders in separate processes, and reads seconds and memory of one call each.

use std::path::{Path, PathBuf};
use std::process::Command;

use crate::Result;
use crate::race::median;

/// The report of a process on its call: seconds, peak memory in addition to its input, and further
/// numbers.
#[derive(Debug, Clone)]
pub struct Report {
    /// Seconds of the call itself.
    pub seconds: f64,
    /// Bytes of memory at the peak, minus those before the call.
    pub bytes: f64,
    /// Further numbers.
    pub rest: Vec<f64>,
}

impl Report {
    /// Returns the line that [`run`] reads.
    pub fn line(seconds: f64, bytes: u64, rest: &[f64]) -> String {
        let rest: Vec<_> = rest.iter().map(f64::to_string).collect();
        format!("{seconds} {bytes} {}", rest.join(" "))
    }
}

/// Runs `program` with `arguments`, its libraries on `threads` threads, and reads the report that
/// is its last line.
///
/// # Errors
/// Those of [`numbers`], and when there are fewer than two.
pub fn run(program: &Path, arguments: &[&str], threads: usize) -> Result<Report> {
    match numbers(program, arguments, threads)?[..] {
        [seconds, bytes, ref rest @ ..] => Ok(Report { seconds, bytes, rest: rest.to_vec() }),
        _ => Err(format!("{}: no numbers on its last line", named(program, arguments)).into()),
    }
}

/// Runs `program` with `arguments`, its libraries on `threads` threads, and reads the numbers of
/// its last line.
///
/// # Errors
/// When it can't be started or fails.
pub fn numbers(program: &Path, arguments: &[&str], threads: usize) -> Result<Vec<f64>> {
    let mut command = Command::new(program);
    command.args(arguments).env_remove("OPENBLAS_CORETYPE");
    for name in ["OPENBLAS_NUM_THREADS", "OMP_NUM_THREADS", "MKL_NUM_THREADS"] {
        command.env(name, threads.to_string());
    }
    let output = command.stderr(std::process::Stdio::inherit()).output()?;
    if !output.status.success() {
        return Err(format!("{}: {}", named(program, arguments), output.status).into());
    }
    let text = String::from_utf8_lossy(&output.stdout);
    let line = text.lines().last().unwrap_or_default();
    Ok(line.split_whitespace().filter_map(|word| word.parse().ok()).collect())
}

fn named(program: &Path, arguments: &[&str]) -> String {
    format!("{} {}", program.display(), arguments.join(" "))
}

/// Reports of this library and of a rival, in turns.
pub struct Duel(Vec<[Report; 2]>);

impl Duel {
    /// Runs `ours` of this program, then a script of bench/rivals with its arguments, `repeat`
    /// times.
    ///
    /// # Errors
    /// Those of [`run`].
    pub fn new(
        ours: &[&str],
        python: &Path,
        rival: (&str, &[&str]),
        threads: usize,
        repeat: usize,
    ) -> Result<Self> {
        let this = std::env::current_exe()?;
        let script = script(rival.0);
        let theirs: Vec<&str> =
            std::iter::once(script.as_str()).chain(rival.1.iter().copied()).collect();
        let turn = |_| Ok([run(&this, ours, threads)?, run(python, &theirs, threads)?]);
        (0..repeat.max(1)).map(turn).collect::<Result<_>>().map(Self)
    }

    /// Returns medians of seconds: ours and theirs.
    pub fn seconds(&self) -> [f64; 2] {
        [0, 1].map(|who| median(self.0.iter().map(|pair| pair[who].seconds).collect()))
    }

    /// Returns medians of bytes: ours and theirs.
    pub fn bytes(&self) -> [f64; 2] {
        [0, 1].map(|who| median(self.0.iter().map(|pair| pair[who].bytes).collect()))
    }

    /// Returns the ratio of their seconds to ours: the median over the repetitions.
    pub fn ratio(&self) -> f64 {
        median(self.0.iter().map(|[ours, theirs]| theirs.seconds / ours.seconds).collect())
    }

    /// Returns the further numbers of the first repetition: ours and theirs.
    pub fn rest(&self) -> [&[f64]; 2] {
        [0, 1].map(|who| self.0[0][who].rest.as_slice())
    }
}

/// Returns the Python of scripts/rivals, if it has scipy.
pub fn python(rivals: &Path) -> Option<PathBuf> {
    let python = rivals.join("bin/python");
    let found = Command::new(&python).args(["-c", "import scipy"]).output();
    found.is_ok_and(|output| output.status.success()).then_some(python)
}

/// Returns the path of a script of bench/rivals.
pub fn script(name: &str) -> String {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("rivals").join(name).display().to_string()
}

/// Resets the peak of [`memory`].
pub fn forget_peak() {
    // Without the reset, the peak could be that of reading the input.
    let _ = std::fs::write("/proc/self/clear_refs", "5");
}

/// Returns bytes of memory of this process: now, and at the peak.
pub fn memory() -> [u64; 2] {
    let status = std::fs::read_to_string("/proc/self/status").unwrap_or_default();
    ["VmRSS:", "VmHWM:"].map(|key| {
        let line = status.lines().find_map(|line| line.strip_prefix(key));
        let kilobytes = line.and_then(|line| line.split_whitespace().next()?.parse::<u64>().ok());
        kilobytes.unwrap_or(0) << 10
    })
}
