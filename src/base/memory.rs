//! How much memory there is, and whether a request fits: allocations beyond it succeed on Linux,
//! and the process is killed when it uses them.

use std::fmt::Display;
use std::mem::MaybeUninit;
use std::slice;
use std::sync::atomic::{AtomicU64, Ordering};

use faer::Mat;

use super::byte_size::byte_size;
use super::huge_pages::ask_for_huge_pages;
use super::{Error, Result};

/// The limit that a caller has set; 0 without one.
static LIMIT: AtomicU64 = AtomicU64::new(0);

/// Requests below this size are not compared with the memory of the machine.
const SMALL: usize = 64 << 20;

/// Sets how many bytes of memory a single request of this process may need, instead of
/// [`available_memory`]; `None` removes the limit. Requests are arguments that decide how large a
/// result is, such as a number of vertices.
///
/// Public for the command line: `--input-limit`.
#[doc(hidden)]
pub fn limit_memory(bytes: impl Into<Option<u64>>) {
    LIMIT.store(bytes.into().map_or(0, |bytes| bytes.max(1)), Ordering::Relaxed);
}

/// Returns how many bytes of memory this process can still take: the least of the memory that Linux
/// reports as available, of what its control groups leave, and of its limit of address space.
/// Without any of these, as on other systems, `u64::MAX`.
///
/// ```
/// assert!(catamaran::base::available_memory() > 1 << 20);
/// ```
pub fn available_memory() -> u64 {
    system::available().into_iter().min().unwrap_or(u64::MAX)
}

/// Returns [`Error::Argument`] when `request`, the value of argument `what`, needs more than the
/// memory allowed. `bytes` is a lower bound, so that what fits is never refused.
///
/// Public for the command line, which creates results from several calls.
///
/// # Errors
/// As above.
#[doc(hidden)]
pub fn check_request(what: &'static str, request: impl Display, bytes: f64) -> Result<()> {
    let limit = LIMIT.load(Ordering::Relaxed);
    let (allowed, are) = match limit {
        0 if bytes < SMALL as f64 => return Ok(()),
        0 => (available_memory(), "available"),
        limit => (limit, "allowed (--input-limit)"),
    };
    if bytes <= allowed as f64 {
        return Ok(());
    }
    let (needed, allowed) = (byte_size(bytes), byte_size(allowed as f64));
    let why = format!("{request} would take at least {needed} of memory, {allowed} are {are}");
    Err(Error::Argument { what, why })
}

/// Returns [`Error::OutOfMemory`] for a single allocation that is larger than the memory there is:
/// Linux would grant it, and kill the process later. A larger `--input-limit` permits more than the
/// system reports as available.
pub(crate) fn check_allocation(bytes: usize) -> Result<()> {
    let fits = || {
        let allowed = available_memory().max(LIMIT.load(Ordering::Relaxed));
        bytes as u64 <= allowed
    };
    if bytes < SMALL || (bytes <= isize::MAX as usize && fits()) {
        return Ok(());
    }
    Err(Error::OutOfMemory { bytes })
}

/// Returns the matrix of `entry(i, j)`. faer's own constructors abort when memory is refused.
///
/// # Errors
/// [`Error::OutOfMemory`] when memory is refused.
pub(crate) fn filled<T>(
    rows: usize,
    cols: usize,
    entry: impl FnMut(usize, usize) -> T,
) -> Result<Mat<T>> {
    let mut matrix = with_room(rows, cols)?;
    matrix.resize_with(rows, cols, entry);
    Ok(matrix)
}

/// Returns an empty matrix with room for so many entries.
///
/// # Errors
/// [`Error::OutOfMemory`] when memory is refused.
pub(crate) fn with_room<T>(rows: usize, cols: usize) -> Result<Mat<T>> {
    let bytes = rows.saturating_mul(cols).saturating_mul(size_of::<T>());
    check_allocation(bytes)?;
    let mut matrix = Mat::<T>::new();
    matrix.try_reserve(rows, cols).map_err(|_| Error::OutOfMemory { bytes })?;
    // SAFETY: there is room for at least so many entries in one block, which has none so far.
    let block = unsafe {
        slice::from_raw_parts_mut(matrix.as_ptr_mut().cast::<MaybeUninit<T>>(), rows * cols)
    };
    ask_for_huge_pages(block);
    Ok(matrix)
}

#[cfg(target_os = "linux")]
mod system {
    use std::fs::read_to_string;
    use std::path::{Path, PathBuf};

    /// Returns the limits that are known.
    pub fn available() -> Vec<u64> {
        let machine = read_to_string("/proc/meminfo").ok().and_then(|text| of_meminfo(&text));
        let groups = read_to_string("/proc/self/cgroup").unwrap_or_default();
        machine.into_iter().chain(of_groups(&groups)).chain(of_address_space()).collect()
    }

    /// Returns the memory that is available, and what can still be swapped out.
    pub fn of_meminfo(text: &str) -> Option<u64> {
        let bytes = |name: &str| {
            let line = text.lines().find_map(|line| line.strip_prefix(name))?;
            line.trim().strip_suffix("kB")?.trim().parse::<u64>().ok()?.checked_mul(1024)
        };
        bytes("MemAvailable:")?.checked_add(bytes("SwapFree:").unwrap_or(0))
    }

    /// Returns what each control group of the process leaves: those of the unified hierarchy, or
    /// that of the memory controller of version 1.
    fn of_groups(text: &str) -> Vec<u64> {
        let mut found = Vec::new();
        for line in text.lines() {
            let mut parts = line.splitn(3, ':').skip(1);
            let (Some(controllers), Some(group)) = (parts.next(), parts.next()) else { continue };
            let (root, most, used) = match controllers {
                "" => ("/sys/fs/cgroup", "memory.max", "memory.current"),
                _ if controllers.split(',').any(|name| name == "memory") => {
                    ("/sys/fs/cgroup/memory", "memory.limit_in_bytes", "memory.usage_in_bytes")
                }
                _ => continue,
            };
            // In a container the path may be that of the host: then only the root is there.
            let folder = PathBuf::from(root).join(group.trim_start_matches('/'));
            let ancestors = folder.ancestors().take_while(|folder| folder.starts_with(root));
            found.extend(ancestors.filter_map(|folder| of_group(folder, most, used)));
        }
        found
    }

    /// Returns what one group leaves. Pages of files count as used, and are given up when memory is
    /// short. In version 1, limit and use are of all groups below, and so are the pages named
    /// `total_`; Slurm sets the limit of a job, and runs it two levels lower.
    pub fn of_group(folder: &Path, most: &str, used: &str) -> Option<u64> {
        let read = |name: &str| read_to_string(folder.join(name)).ok();
        let number = |name: &str| read(name)?.trim().parse::<u64>().ok();
        let stat = read("memory.stat").unwrap_or_default();
        let bytes = |name: &str| {
            let mut pairs = stat.lines().filter_map(|line| line.split_once(' '));
            pairs.find(|(other, _)| *other == name)?.1.parse::<u64>().ok()
        };
        let below = |all: &str, own: &str| bytes(all).or_else(|| bytes(own)).unwrap_or(0);
        let files = below("total_inactive_file", "inactive_file")
            .saturating_add(below("total_active_file", "active_file"));
        Some(number(most)?.saturating_sub(number(used)?.saturating_sub(files)))
    }

    /// Returns what RLIMIT_AS leaves.
    fn of_address_space() -> Option<u64> {
        // SAFETY: the structure is plain numbers, and the call only writes to it.
        let limit = unsafe {
            let mut limit: libc::rlimit = std::mem::zeroed();
            (libc::getrlimit(libc::RLIMIT_AS, &mut limit) == 0).then_some(limit.rlim_cur)
        };
        let limit = limit.filter(|&limit| limit != libc::RLIM_INFINITY)?;
        let text = read_to_string("/proc/self/statm").ok()?;
        let pages: u64 = text.split_whitespace().next()?.parse().ok()?;
        // SAFETY: `sysconf` takes no pointer, and any name is allowed.
        let page = unsafe { libc::sysconf(libc::_SC_PAGESIZE) };
        Some(limit.saturating_sub(pages.saturating_mul(page.unsigned_abs())))
    }
}

#[cfg(not(target_os = "linux"))]
mod system {
    pub fn available() -> Vec<u64> {
        Vec::new()
    }
}

#[cfg(all(test, target_os = "linux"))]
mod tests {
    use super::system::{of_group, of_meminfo};
    use super::*;

    #[test]
    fn available_memory_is_read_in_kib() {
        let text = "MemTotal:       100 kB\nMemAvailable:    64 kB\n";
        assert_eq!(of_meminfo(text), Some(65536));
        let swap = "MemAvailable:    64 kB\nSwapFree:    1 kB\n";
        assert_eq!(of_meminfo(swap), Some(66560));
        assert_eq!(of_meminfo("MemTotal: 1 kB"), None);
        assert_eq!(of_meminfo("MemAvailable: much"), None);
    }

    #[test]
    fn allocations_larger_than_the_machine_are_refused() {
        let most = available_memory();
        assert!(most > 1 << 20 && most < 1 << 50);
        assert!(check_allocation(usize::try_from(most).unwrap().saturating_mul(2)).is_err());
        assert!(check_allocation(1 << 20).is_ok());
        // As large as all memory of the machine and what it may swap: Linux grants it.
        let len = usize::try_from(most).unwrap() / 8 * 5 / 4;
        assert!(crate::base::reserved::<f64>(len).is_err());
        assert!(crate::base::zeros::<f64>(len).is_err());
        assert!(crate::base::Workspace::<f64>::new(len).is_err());
    }

    #[test]
    fn a_request_beyond_the_memory_says_how_much() {
        let refused = check_request("n", "9 vertices", 1e15).unwrap_err().to_string();
        assert!(
            refused.starts_with("n: 9 vertices would take at least 931322.57 GiB"),
            "{refused}"
        );
        assert!(refused.contains("available"), "{refused}");
        assert!(check_request("n", "9 vertices", 1e3).is_ok());
    }

    #[test]
    fn a_group_leaves_its_limit_less_what_is_used_beside_files() {
        let folder = tempfile::tempdir().unwrap();
        let write =
            |name: &str, text: &str| std::fs::write(folder.path().join(name), text).unwrap();
        let left = || of_group(folder.path(), "memory.max", "memory.current");
        assert_eq!(left(), None);
        write("memory.max", "1000\n");
        write("memory.current", "700\n");
        assert_eq!(left(), Some(300));
        write("memory.stat", "anon 1\nfile 250\ninactive_file 150\nactive_file 50\n");
        assert_eq!(left(), Some(500));
        write("memory.current", "2000\n");
        assert_eq!(left(), Some(0));
        write("memory.max", "max\n");
        assert_eq!(left(), None);
    }

    #[test]
    fn a_group_of_version_1_leaves_the_pages_of_files_of_the_groups_below_it() {
        let folder = tempfile::tempdir().unwrap();
        let write =
            |name: &str, text: &str| std::fs::write(folder.path().join(name), text).unwrap();
        write("memory.limit_in_bytes", "1000\n");
        write("memory.usage_in_bytes", "700\n");
        // The processes are in a group below, whose pages count here as used.
        let below = "total_inactive_file 400\ntotal_active_file 50\n";
        write("memory.stat", &format!("inactive_file 0\nactive_file 0\n{below}"));
        let left = of_group(folder.path(), "memory.limit_in_bytes", "memory.usage_in_bytes");
        assert_eq!(left, Some(750));
    }
}
