//! Describes the machine and the process for a record, and sets the environment that rivals need
//! before they are loaded.

use std::path::Path;
use std::process::Command;

use catamaran::base::{IsaLevel, cpu_features, isa_limit};

use crate::Result;
use crate::library::{Rival, find};
use crate::peak::Peak;

/// Returns the model of the CPU, as Linux names it.
pub fn cpu_model() -> String {
    let info = std::fs::read_to_string("/proc/cpuinfo").unwrap_or_default();
    field(&info, "model name").unwrap_or("unknown CPU").to_owned()
}

fn field<'a>(text: &'a str, key: &str) -> Option<&'a str> {
    let line = text.lines().find(|l| l.starts_with(key))?;
    Some(line.split_once(':')?.1.trim())
}

/// Returns the number of cores of the machine, which may be more than this process may use.
pub fn cores() -> usize {
    let info = std::fs::read_to_string("/proc/cpuinfo").unwrap_or_default();
    info.lines().filter(|line| line.starts_with("processor")).count().max(1)
}

/// Returns a folder name for machines like this one: CPU model and cores.
pub fn kind() -> String {
    kind_of(&cpu_model(), cores())
}

/// Returns today's date, as `2026-11-23`, in UTC.
pub fn date() -> String {
    output("date", &["-u", "+%Y-%m-%d"])
}

fn kind_of(model: &str, cores: usize) -> String {
    let plain = model.replace("(R)", "").replace("(TM)", "").to_lowercase();
    let words: Vec<_> =
        plain.split(|c: char| !c.is_ascii_alphanumeric()).filter(|w| !w.is_empty()).collect();
    format!("{}-{cores}c", words.join("-"))
}

/// Returns the description of the host of a record.
pub fn describe(rivals: &[&Rival]) -> String {
    let info = std::fs::read_to_string("/proc/meminfo").unwrap_or_default();
    let flags = std::fs::read_to_string("/proc/cpuinfo").unwrap_or_default();
    let flags = field(&flags, "flags").unwrap_or_default();
    let amx: Vec<_> = flags.split(' ').filter(|f| f.starts_with("amx")).collect();
    let mut text = format!(
        "cpu       {}\ncores     {}\nflags     {} {}\nlimit     {}\nmemory    {}\nrustc     {}\n\
         date      {}\ncommit    {}\nload      {}\n",
        cpu_model(),
        cores(),
        cpu_features().join(" "),
        amx.join(" "),
        isa_limit().map_or("none", IsaLevel::name),
        field(&info, "MemTotal").unwrap_or("unknown"),
        output("rustc", &["--version"]),
        output("date", &["-u", "+%Y-%m-%d %H:%M UTC"]),
        output("git", &["describe", "--always", "--dirty"]),
        std::fs::read_to_string("/proc/loadavg").unwrap_or_default().trim(),
    );
    for rival in rivals {
        text += &format!("{:<9} {}\n", rival.name, rival.version);
    }
    text
}

/// Returns the line about the speed limit of a core, measured before and after everything else.
pub fn describe_peak(before: Peak, after: Peak) -> String {
    format!(
        "peak      {:.1} GFLOP/s before, {:.1} after (one core, f64 multiply-adds, {})\n",
        before.gflops, after.gflops, after.instructions
    )
}

fn output(program: &str, arguments: &[&str]) -> String {
    let output = Command::new(program).args(arguments).output();
    output
        .map_or_else(|_| "unknown".into(), |o| String::from_utf8_lossy(&o.stdout).trim().to_owned())
}

/// Kernels of BLIS, by their numbers: BLIS 0.9 takes any name for 0.
const BLIS_SKX: (&str, &str) = ("BLIS_ARCH_TYPE", "0");
const BLIS_HASWELL: (&str, &str) = ("BLIS_ARCH_TYPE", "3");

/// The variables that limit rivals to AVX2, as `CATAMARAN_ISA=avx2` limits ours. faer has none.
const AVX2_KERNELS: [(&str, &str); 3] =
    [("MKL_ENABLE_INSTRUCTIONS", "AVX2"), ("OPENBLAS_CORETYPE", "Haswell"), BLIS_HASWELL];

/// Restarts this program when the environment is not the one that the rivals need: most read it
/// when they are loaded, and setting it in a running process is too late.
///
/// # Errors
/// When `CATAMARAN_ISA` names no level, or the program can't be started again.
pub fn with_environment_for_rivals(folder: &Path, openblas: Kernels) -> Result<()> {
    let intel = find("mkl", folder)
        .and_then(|p| Some(p.parent()?.join("libiomp5.so").exists()))
        .unwrap_or(true);
    let mut wanted = vec![
        ("MKL_THREADING_LAYER", if intel { "INTEL" } else { "GNU" }),
        ("MKL_INTERFACE_LAYER", "LP64"),
        ("MKL_DYNAMIC", "FALSE"),
        // Idle threads of one contender must not spin during the time of the next: 1 ms, 2^20
        // cycles.
        ("KMP_BLOCKTIME", "1"),
        ("OPENBLAS_THREAD_TIMEOUT", "20"),
    ];
    let mut unwanted = vec!["OPENBLAS_NUM_THREADS", "OMP_NUM_THREADS"];
    if isa_limit()? < IsaLevel::Avx512 {
        wanted.extend(AVX2_KERNELS);
    } else {
        if intel_avx512() && std::env::var_os("BLIS_ARCH_TYPE").is_none() {
            wanted.push(BLIS_SKX);
        }
        match openblas {
            Kernels::OfOldLibrary if intel_avx512() => {
                wanted.push(("OPENBLAS_CORETYPE", "SkylakeX"));
            }
            // A kernel set forced on OpenBLAS makes it slower.
            _ => unwanted.push("OPENBLAS_CORETYPE"),
        }
    }
    let right = wanted.iter().all(|(k, v)| std::env::var(k).is_ok_and(|x| x == *v))
        && unwanted.iter().all(|k| std::env::var_os(k).is_none());
    if right {
        return Ok(());
    }
    let mut again = Command::new(std::env::current_exe()?);
    again.args(std::env::args_os().skip(1)).envs(wanted);
    for key in unwanted {
        again.env_remove(key);
    }
    Err(std::os::unix::process::CommandExt::exec(&mut again).into())
}

/// The origin of the choice of OpenBLAS's kernels.
#[derive(Clone, Copy)]
pub enum Kernels {
    /// The library.
    OfLibrary,
    /// This program, on Intel CPUs with AVX-512: the library of the system may be older than the
    /// CPU, and then takes the kernels of Prescott (Debian 12 on Emerald Rapids: 13 GFLOP/s of
    /// pdsyrk on one core).
    OfOldLibrary,
}

/// Returns whether BLIS needs help: it selects kernels by the model number, which virtual machines
/// change, and then falls back to AVX2.
fn intel_avx512() -> bool {
    let info = std::fs::read_to_string("/proc/cpuinfo").unwrap_or_default();
    field(&info, "vendor_id") == Some("GenuineIntel") && cpu_features().contains(&"avx512f")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn kinds_are_folder_names() {
        assert_eq!(
            kind_of("Intel(R) Xeon(R) Processor @ 2.60GHz", 2),
            "intel-xeon-processor-2-60ghz-2c"
        );
    }
}
