//! Contenders in separate processes that take turns, and their reports.

use std::path::{Path, PathBuf};

use super::ours::Task;
use crate::child::{self, Report};
use crate::race::median;
use crate::{Result, host};

/// The options of contenders that take turns.
#[derive(Debug, Clone)]
pub struct Turns {
    /// The Python that has the rivals.
    pub python: PathBuf,
    /// Number of threads of all contenders.
    pub threads: usize,
    /// Number of runs of all contenders.
    pub repeat: usize,
}

/// The reports of one contender on its runs.
#[derive(Debug, Clone)]
pub(super) struct Runs {
    /// `ours`, or a method of bench/rivals/gram.py.
    pub name: &'static str,
    reports: Vec<Report>,
    /// Ratio of its seconds to ours in the same repetition: the median.
    pub ratio: f64,
}

/// Column names of [`Runs::figures`].
pub(super) const FIGURES: [&str; 3] = ["s", "time over ours", "MB"];

impl Turns {
    /// Runs a task in a folder by this library and by the `methods` of bench/rivals/gram.py, in
    /// turns. A contender that fails is left out from then on, with a line on stderr.
    ///
    /// # Errors
    /// When no contender succeeds.
    pub(super) fn run(
        &self,
        task: Task,
        folder: &Path,
        methods: &[&'static str],
    ) -> Result<Vec<Runs>> {
        let names = std::iter::once(OURS).chain(methods.iter().copied());
        let mut runs: Vec<Option<Runs>> = names.map(|name| Some(Runs::new(name))).collect();
        for _ in 0..self.repeat.max(1) {
            for slot in &mut runs {
                let Some(run) = slot else { continue };
                match self.once(task, folder, run.name) {
                    Ok(report) => run.reports.push(report),
                    Err(error) => {
                        eprintln!("left out: {}: {error}", run.name);
                        *slot = None;
                    }
                }
            }
        }
        let mut runs: Vec<Runs> = runs.into_iter().flatten().collect();
        let first = runs.first().ok_or("no contender is left")?;
        if first.name == OURS {
            let ours = first.seconds();
            runs.iter_mut().for_each(|run| run.ratio = run.ratio_to(&ours));
        }
        Ok(runs)
    }

    fn once(&self, task: Task, folder: &Path, name: &str) -> Result<Report> {
        let (place, threads) = (folder.display().to_string(), self.threads.to_string());
        if name == OURS {
            let arguments =
                ["gram", "--solve", &place, "--task", task.name(), "--threads", &threads];
            return child::run(&std::env::current_exe()?, &arguments, self.threads);
        }
        let arguments = [&child::script("gram.py"), task.name(), &place, name];
        child::run(&self.python, &arguments, self.threads)
    }

    /// Computes the reference results by bench/rivals/gram.py.
    pub(super) fn reference(&self, folder: &Path) -> Result<()> {
        let place = folder.display().to_string();
        let arguments = [&child::script("gram.py"), "reference", place.as_str()];
        child::run(&self.python, &arguments, host::cores()).map(|_| ())
    }
}

/// The name of our side.
pub(super) const OURS: &str = "ours";

impl Runs {
    fn new(name: &'static str) -> Self {
        Self { name, reports: Vec::new(), ratio: f64::NAN }
    }

    fn seconds(&self) -> Vec<f64> {
        self.reports.iter().map(|report| report.seconds).collect()
    }

    fn ratio_to(&self, ours: &[f64]) -> f64 {
        median(self.seconds().iter().zip(ours).map(|(own, ours)| own / ours).collect())
    }

    /// Returns the median seconds, the ratio, and the median of the bytes in MB: see [`FIGURES`].
    pub fn figures(&self) -> Vec<f64> {
        let bytes = median(self.reports.iter().map(|report| report.bytes).collect());
        vec![median(self.seconds()), self.ratio, bytes / 1e6]
    }
}

/// Returns [`FIGURES`] and the names of further columns.
pub(super) fn columns(errors: &[&str]) -> Vec<String> {
    FIGURES.iter().chain(errors).map(|name| (*name).to_owned()).collect()
}
