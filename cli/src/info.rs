//! `catamaran info`.

use anyhow::Result;
use catamaran::base::{IsaLevel, VERSION, available_cores, cpu_features, isa_limit};
use catamaran::kernel::packed::Rates;
use catamaran::kernel::{int8, packed};

use crate::report::{head, row};
use crate::{backend, device};

/// Width of a label, in characters.
pub const WIDTH: usize = 14;

/// The commit that the program is built from; empty outside of the repository.
const COMMIT: &str = env!("CATAMARAN_COMMIT");

/// The features of the package, and whether the program is built with each.
const FEATURES: [(&str, bool); 5] = [
    ("columnar", cfg!(feature = "columnar")),
    ("hdf5", cfg!(feature = "hdf5")),
    ("mpi", cfg!(feature = "mpi")),
    ("opencl", cfg!(feature = "opencl")),
    ("openblas", cfg!(feature = "openblas")),
];

/// Print the version and features of the program, and what it finds on this machine.
///
/// The lines name the commit, the MPI library and HDF5, the CPU, the BLAS back ends, the
/// instruction sets of the native kernels and of the exact path, the rates that `tune` measured,
/// and the OpenCL devices.
#[derive(clap::Args)]
pub struct Args {
    /// Also load this CBLAS library and print its description.
    #[arg(long, value_name = "LIBRARY")]
    backend: Option<String>,
}

/// Runs the subcommand.
pub fn run(args: &Args) -> Result<()> {
    row!("version", version = VERSION; "{:WIDTH$}{VERSION}", "catamaran")?;
    built()?;
    let cpu = cpu_model();
    row!("cpu", name = cpu; "{:WIDTH$}{cpu}", "cpu")?;
    let cores = available_cores();
    row!("cores", count = cores; "{:WIDTH$}{cores} in the affinity mask", "cores")?;
    let names = cpu_features();
    let known = if names.is_empty() { "none known".into() } else { names.join(" ") };
    row!("instructions", names = names; "{:WIDTH$}{known}", "instructions")?;
    limit()?;
    let back_ends = ["native", "openblas"].into_iter().chain(args.backend.as_deref());
    back_ends.into_iter().try_for_each(back_end)?;
    head(format_args!("{:WIDTH$}any CBLAS library: --backend PATH", ""))?;

    let best = packed::FloatIsa::best();
    for (i, isa) in packed::FloatIsa::ALL.into_iter().enumerate() {
        kernels(first(i, "native path"), isa.name(), isa.refusal(), isa == best)?;
    }
    let usable = packed::FloatIsa::ALL.into_iter().filter(|i| i.refusal().is_none());
    for (i, isa) in usable.enumerate() {
        rates(first(i, "rates"), isa)?;
    }
    let best = int8::IntegerIsa::best();
    for (i, isa) in int8::IntegerIsa::ALL.into_iter().enumerate() {
        kernels(first(i, "exact path"), isa.name(), isa.refusal(), isa == best)?;
    }
    device::report()
}

/// Returns the label on the first line of a block, and an empty one on the others.
pub fn first(line: usize, label: &'static str) -> &'static str {
    if line == 0 { label } else { "" }
}

/// Reports the limit on the instruction sets of this process.
fn limit() -> Result<()> {
    let limit = isa_limit()?;
    let what = if limit == IsaLevel::Amx { "none" } else { limit.name() };
    row!("limit", isa = limit.name(); "{:WIDTH$}{what} (CATAMARAN_ISA)", "limit")
}

/// Returns the long form of the version: the version, and the lines of [`run`] on how the program
/// is built.
pub fn long_version() -> String {
    let lines = build().map(|(label, text)| format!("{label:WIDTH$}{text}\n"));
    format!("catamaran {VERSION}\n{}", lines.concat())
}

/// Returns the commit, the features, the MPI library and the version of HDF5 of this program, with
/// labels. A library that it does not have says how to build it.
fn build() -> [(&'static str, String); 4] {
    #[cfg(feature = "mpi")]
    let mpi = catamaran::ranks::mpi_version();
    #[cfg(not(feature = "mpi"))]
    let mpi = "not in this build (build with --features mpi)".to_owned();
    #[cfg(feature = "hdf5")]
    let hdf5 = catamaran::io::hdf5_version();
    #[cfg(not(feature = "hdf5"))]
    let hdf5 = "not in this build (build with --features hdf5)".to_owned();
    let or = |text: String, empty: &str| if text.is_empty() { empty.into() } else { text };
    [
        ("commit", or(COMMIT.into(), "unknown")),
        ("features", or(features().join(" "), "none")),
        ("MPI", mpi),
        ("HDF5", hdf5),
    ]
}

/// Returns the names of the features that the program is built with.
fn features() -> Vec<&'static str> {
    FEATURES.into_iter().filter(|(_, is_built)| *is_built).map(|(name, _)| name).collect()
}

/// Reports how this program is built.
fn built() -> Result<()> {
    let [(label, commit), (features_label, features_text), (_, mpi), (_, hdf5)] = build();
    row!("commit", commit = COMMIT; "{label:WIDTH$}{commit}")?;
    row!("features", names = features(); "{features_label:WIDTH$}{features_text}")?;
    row!("mpi", available = cfg!(feature = "mpi"), library = mpi; "{:WIDTH$}{mpi}", "MPI")?;
    row!("hdf5", available = cfg!(feature = "hdf5"), library = hdf5; "{:WIDTH$}{hdf5}", "HDF5")
}

fn back_end(name: &str) -> Result<()> {
    let label = "back end";
    if name == "openblas" && cfg!(not(feature = "openblas")) {
        let what = "openblas: not in this build (build with --features openblas)";
        return row!("back_end", name = name, available = false; "{label:WIDTH$}{what}");
    }
    let found = backend::find(name)?;
    let (name, about) = (found.name(), found.description());
    row!(
        "back_end",
        name = name,
        description = about,
        available = true;
        "{label:WIDTH$}{name}{}{about}",
        if about.is_empty() { "" } else { ": " }
    )
}

/// Reports whether the kernels of an instruction set are used, available or refused.
fn kernels(label: &str, isa: &str, refusal: Option<&'static str>, is_best: bool) -> Result<()> {
    let state = refusal.unwrap_or(if is_best { "used" } else { "available" });
    row!(
        "kernels",
        isa = isa,
        available = refusal.is_none(),
        used = is_best;
        "{label:WIDTH$}{isa}: {state}"
    )
}

/// Reports where the planner takes the rates of an instruction set from.
fn rates(label: &str, isa: packed::FloatIsa) -> Result<()> {
    let path = Rates::path(isa).filter(|path| path.exists());
    let loaded = path.as_ref().map(|path| Rates::load(path, isa));
    let path = path.map(|path| path.display().to_string());
    let from = match (&loaded, &path) {
        (Some(Ok(_)), Some(path)) => format!("measured, {path}"),
        (Some(Err(e)), _) => format!("built in, as this file is refused: {e}"),
        _ => "built in (`catamaran tune` measures them)".into(),
    };
    row!(
        "rates",
        isa = isa.name(),
        measured = matches!(loaded, Some(Ok(_))),
        path = path;
        "{label:WIDTH$}{}: {from}",
        isa.name()
    )
}

/// Returns the name that the CPU reports.
pub fn cpu_model() -> String {
    #[cfg(target_arch = "x86_64")]
    if let Some(brand) = raw_cpuid::CpuId::new().get_processor_brand_string() {
        return brand.as_str().trim().to_owned();
    }
    format!("unknown ({})", std::env::consts::ARCH)
}

#[cfg(test)]
mod tests {
    use std::collections::BTreeSet;

    use super::*;

    #[test]
    fn the_features_are_those_of_the_package() {
        let package: toml::Table = include_str!("../Cargo.toml").parse().unwrap();
        let features = package["features"].as_table().unwrap().keys().map(String::as_str);
        let features: BTreeSet<_> = features.filter(|name| *name != "default").collect();
        assert_eq!(FEATURES.map(|(name, _)| name).into_iter().collect::<BTreeSet<_>>(), features);
    }
}
