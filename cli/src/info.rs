//! `catamaran info`.

use std::fmt::Display;
use std::io::{self, Write};

use anyhow::Result;
use catamaran::base::{VERSION, available_cores, cpu_features};
use catamaran::kernel::packed::Rates;
use catamaran::kernel::{int8, packed};

use crate::backend;

/// Print the version, the CPU, the BLAS back ends, the instruction sets of the native kernels and
/// of the exact path, what `tune` has measured, and the OpenCL devices.
#[derive(clap::Args)]
pub struct Args {
    /// Also load this CBLAS library and say what it is.
    #[arg(long, value_name = "LIBRARY")]
    backend: Option<String>,
}

/// Runs the subcommand.
pub fn run(args: &Args) -> Result<()> {
    let mut out = io::stdout().lock();
    writeln!(out, "catamaran     {VERSION}")?;
    writeln!(out, "cpu           {}", cpu_model())?;
    writeln!(out, "cores         {} in the affinity mask", available_cores())?;
    let features = cpu_features();
    let features = if features.is_empty() { "none known".into() } else { features.join(" ") };
    writeln!(out, "instructions  {features}")?;
    let names = ["native", "openblas"].into_iter().chain(args.backend.as_deref());
    for name in names {
        if name == "openblas" && cfg!(not(feature = "openblas")) {
            writeln!(out, "back end      openblas: not in this build (--features openblas)")?;
            continue;
        }
        let found = backend::find(name)?;
        let (name, description) = (found.name(), found.description());
        writeln!(
            out,
            "back end      {name}{}{description}",
            if description.is_empty() { "" } else { ": " }
        )?;
    }
    writeln!(out, "              any CBLAS library: --backend PATH")?;
    let best = packed::Isa::best();
    let states = packed::Isa::ALL.map(|i| (i.name(), state(i.refusal(), i == best)));
    block(&mut out, "native path", &states)?;
    let usable = packed::Isa::ALL.into_iter().filter(|i| i.refusal().is_none());
    let rates: Vec<_> = usable.map(|i| (i.name(), rates(i))).collect();
    block(&mut out, "rates", &rates)?;
    let best = int8::Isa::best();
    let states = int8::Isa::ALL.map(|i| (i.name(), state(i.refusal(), i == best)));
    block(&mut out, "exact path", &states)?;
    for (i, line) in crate::device::described().iter().enumerate() {
        writeln!(out, "{:14}{line}", if i == 0 { "opencl" } else { "" })?;
    }
    Ok(())
}

/// Lines `name: state`, the first one with a label.
fn block(out: &mut impl Write, label: &str, lines: &[(&str, impl Display)]) -> Result<()> {
    for (i, (name, state)) in lines.iter().enumerate() {
        writeln!(out, "{:14}{name}: {state}", if i == 0 { label } else { "" })?;
    }
    Ok(())
}

/// What becomes of an instruction set.
fn state(refusal: Option<&'static str>, is_best: bool) -> &'static str {
    refusal.unwrap_or(if is_best { "used" } else { "available" })
}

/// Where the planner has the rates of an instruction set from.
fn rates(isa: packed::Isa) -> String {
    const NONE: &str = "built in (`catamaran tune` measures them)";
    let Some(path) = Rates::path(isa) else { return NONE.into() };
    if !path.exists() {
        return NONE.into();
    }
    match Rates::load(&path, isa) {
        Ok(_) => format!("measured, {}", path.display()),
        Err(e) => format!("built in, as this file is refused: {e}"),
    }
}

/// What the CPU calls itself.
pub fn cpu_model() -> String {
    #[cfg(target_arch = "x86_64")]
    if let Some(brand) = raw_cpuid::CpuId::new().get_processor_brand_string() {
        return brand.as_str().trim().to_owned();
    }
    format!("unknown ({})", std::env::consts::ARCH)
}
