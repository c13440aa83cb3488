//! Contenders in processes of their own that take turns, and what they report.

use std::path::{Path, PathBuf};

use super::ours::Task;
use crate::child::{self, Report};
use crate::race::median;
use crate::{Result, host};

/// How contenders take turns.
#[derive(Debug, Clone)]
pub struct Turns {
    /// The Python that has the rivals.
    pub python: PathBuf,
    /// Threads of everyone.
    pub threads: usize,
    /// Runs of everyone.
    pub repeat: usize,
}

/// The reports of one contender, of runs in turns.
#[derive(Debug, Clone)]
pub(super) struct Runs {
    /// `ours`, or a method of bench/rivals/gram.py.
    pub name: &'static str,
    reports: Vec<Report>,
    /// Seconds over those of ours in the same repetition: the median.
    pub ratio: f64,
}

/// Column names of [`Runs::figures`].
pub(super) const FIGURES: [&str; 3] = ["s", "time over ours", "MB"];

impl Turns {
    /// Lets us and the `methods` of bench/rivals/gram.py do a task in a folder, in turns. A
    /// contender that fails is left out from then on, with a line on stderr.
    ///
    /// # Errors
    /// When nobody does it.
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

    /// Lets bench/rivals/gram.py compute what results are compared with.
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

    /// Median seconds, the ratio, and the median of the bytes in MB: see [`FIGURES`].
    pub fn figures(&self) -> Vec<f64> {
        let bytes = median(self.reports.iter().map(|report| report.bytes).collect());
        vec![median(self.seconds()), self.ratio, bytes / 1e6]
    }
}

/// [`FIGURES`] and the names of further columns.
pub(super) fn columns(errors: &[&str]) -> Vec<String> {
    FIGURES.iter().chain(errors).map(|name| (*name).to_owned()).collect()
}
