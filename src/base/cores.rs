//! How many threads calls use by default.

use std::io::Write;
use std::sync::OnceLock;
use std::sync::atomic::{AtomicBool, Ordering};

/// Returns the number of cores in the affinity mask of this process, or fewer where the CPU quota
/// of a control group allows fewer; at least 1. Both are read on the first call.
///
/// ```
/// use catamaran::{Par, base::available_cores};
///
/// assert!(Par::all().threads() <= available_cores());
/// ```
pub fn available_cores() -> usize {
    // Asking the system takes longer than a small product.
    static CORES: OnceLock<usize> = OnceLock::new();
    *CORES.get_or_init(|| std::thread::available_parallelism().map_or(1, |n| n.get()))
}

/// Whether `OMP_NUM_THREADS` counts.
static OPENMP: AtomicBool = AtomicBool::new(false);

/// Makes [`Par::all`](super::Par::all) obey `OMP_NUM_THREADS` where `CATAMARAN_NUM_THREADS` is not
/// set: for interfaces to programs that limit the threads of all their libraries by this variable,
/// as those to Python and BLAS do. To be called before the first use of [`Par`](super::Par).
pub fn obey_omp_num_threads() {
    OPENMP.store(true, Ordering::Relaxed);
}

/// Returns the number of threads that calls use by default outside of rayon's pools. The variables
/// are read on the first call.
pub(super) fn allowed_threads() -> usize {
    static ALLOWED: OnceLock<usize> = OnceLock::new();
    *ALLOWED.get_or_init(|| {
        let variable = |name: &str| Some(std::env::var_os(name)?.to_string_lossy().into_owned());
        let complain = |line: &str| {
            // Where standard error is closed, nobody reads it.
            let _ = writeln!(std::io::stderr(), "{line}");
        };
        limit(available_cores(), OPENMP.load(Ordering::Relaxed), &variable, &complain)
    })
}

/// Returns the least of the cores, of `RAYON_NUM_THREADS`, and of the first variable of our own
/// that is set. `complain` gets a line for a variable of our own that is no number.
fn limit(
    cores: usize,
    openmp: bool,
    variable: &dyn Fn(&str) -> Option<String>,
    complain: &dyn Fn(&str),
) -> usize {
    let count = |text: &str| text.trim().parse().ok().filter(|&count: &usize| count > 0);
    // As rayon does it, other texts, and 0, mean that there is no limit.
    let of_rayon = variable("RAYON_NUM_THREADS").and_then(|text| count(&text));
    let read = |name: &str| {
        let text = variable(name).filter(|text| !text.trim().is_empty())?;
        // A list has the numbers of nested levels; the first one is ours.
        let found = count(text.split(',').next().unwrap_or_default());
        if found.is_none() {
            let text = text.trim();
            complain(&format!(
                "catamaran: {name}={text}: must be a number from 1; the default is used"
            ));
        }
        found
    };
    let own = read("CATAMARAN_NUM_THREADS")
        .or_else(|| if openmp { read("OMP_NUM_THREADS") } else { None });
    [of_rayon, own].into_iter().flatten().fold(cores, usize::min)
}

#[cfg(test)]
mod tests {
    use std::cell::RefCell;

    use super::*;

    /// Returns the limit on eight cores, and the complaints.
    fn limit_of(openmp: bool, variables: &[(&str, &str)]) -> (usize, Vec<String>) {
        let lines = RefCell::new(Vec::new());
        let variable = |name: &str| {
            variables.iter().find(|(n, _)| *n == name).map(|(_, text)| (*text).to_owned())
        };
        let complain = |line: &str| lines.borrow_mut().push(line.to_owned());
        (limit(8, openmp, &variable, &complain), lines.into_inner())
    }

    #[test]
    fn variables_lower_the_number_of_threads_and_never_raise_it() {
        for (openmp, variables, expected) in [
            (true, &[][..], 8),
            (false, &[("CATAMARAN_NUM_THREADS", "3")], 3),
            (false, &[("CATAMARAN_NUM_THREADS", "100")], 8),
            (false, &[("CATAMARAN_NUM_THREADS", " ")], 8),
            (false, &[("RAYON_NUM_THREADS", "2")], 2),
            (false, &[("RAYON_NUM_THREADS", "0")], 8),
            (false, &[("RAYON_NUM_THREADS", "2"), ("CATAMARAN_NUM_THREADS", "5")], 2),
            (false, &[("RAYON_NUM_THREADS", "5"), ("CATAMARAN_NUM_THREADS", "2")], 2),
            (false, &[("OMP_NUM_THREADS", "2")], 8),
            (true, &[("OMP_NUM_THREADS", "2")], 2),
            (true, &[("OMP_NUM_THREADS", "4,2")], 4),
            (true, &[("OMP_NUM_THREADS", "1"), ("CATAMARAN_NUM_THREADS", "3")], 3),
        ] {
            assert_eq!(limit_of(openmp, variables), (expected, vec![]), "{variables:?}");
        }
    }

    #[test]
    fn what_is_no_number_is_named_and_leaves_the_default() {
        for text in ["0", "-1", "many", "1.5", "99999999999999999999"] {
            let (threads, lines) = limit_of(true, &[("CATAMARAN_NUM_THREADS", text)]);
            assert_eq!((threads, lines.len()), (8, 1), "{text}");
            let start = format!("catamaran: CATAMARAN_NUM_THREADS={text}: must be ");
            assert!(lines[0].starts_with(&start), "{lines:?}");
        }
        let both = [("CATAMARAN_NUM_THREADS", "x"), ("OMP_NUM_THREADS", "1")];
        assert_eq!(limit_of(true, &both).0, 1);
    }
}
