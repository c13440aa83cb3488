//! Contenders in processes of their own: seconds and memory of one call each.

use std::path::{Path, PathBuf};
use std::process::Command;

use crate::Result;

/// What a process said of its call: seconds, bytes that it took at most beside its input, and whatever follows.
#[derive(Debug, Clone)]
pub struct Report {
    /// Seconds of the call alone.
    pub seconds: f64,
    /// Bytes of memory at the peak, less those before the call.
    pub bytes: f64,
    /// Further numbers.
    pub rest: Vec<f64>,
}

impl Report {
    /// The line that [`run`] reads.
    pub fn line(seconds: f64, bytes: u64, rest: &[f64]) -> String {
        let rest: Vec<_> = rest.iter().map(f64::to_string).collect();
        format!("{seconds} {bytes} {}", rest.join(" "))
    }
}

/// Runs `program` with `arguments`, its libraries on `threads` threads, and reads the numbers of its last line.
///
/// # Errors
/// When it can't be started or fails, or prints something else.
pub fn run(program: &Path, arguments: &[&str], threads: usize) -> Result<Report> {
    let mut command = Command::new(program);
    command.args(arguments).env_remove("OPENBLAS_CORETYPE");
    for name in ["OPENBLAS_NUM_THREADS", "OMP_NUM_THREADS", "MKL_NUM_THREADS"] {
        command.env(name, threads.to_string());
    }
    let output = command.stderr(std::process::Stdio::inherit()).output()?;
    let named = || format!("{} {}", program.display(), arguments.join(" "));
    if !output.status.success() {
        return Err(format!("{}: {}", named(), output.status).into());
    }
    let text = String::from_utf8_lossy(&output.stdout);
    let line = text.lines().last().unwrap_or_default();
    let numbers: Vec<f64> = line.split_whitespace().filter_map(|word| word.parse().ok()).collect();
    match numbers[..] {
        [seconds, bytes, ref rest @ ..] => Ok(Report { seconds, bytes, rest: rest.to_vec() }),
        _ => Err(format!("{}: no numbers in {line:?}", named()).into()),
    }
}

/// The Python that scripts/rivals made, if it has scipy.
pub fn python(rivals: &Path) -> Option<PathBuf> {
    let python = rivals.join("bin/python");
    let found = Command::new(&python).args(["-c", "import scipy"]).output();
    found.is_ok_and(|output| output.status.success()).then_some(python)
}

/// A script of bench/rivals.
pub fn script(name: &str) -> String {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("rivals").join(name).display().to_string()
}

/// From now on the peak of [`memory`] is that of what follows.
pub fn forget_peak() {
    // Without it, the peak is that of reading the input, if that took more.
    let _ = std::fs::write("/proc/self/clear_refs", "5");
}

/// Bytes of memory of this process: now, and at the peak.
pub fn memory() -> [u64; 2] {
    let status = std::fs::read_to_string("/proc/self/status").unwrap_or_default();
    ["VmRSS:", "VmHWM:"].map(|key| {
        let line = status.lines().find_map(|line| line.strip_prefix(key));
        let kilobytes = line.and_then(|line| line.split_whitespace().next()?.parse::<u64>().ok());
        kilobytes.unwrap_or(0) << 10
    })
}
