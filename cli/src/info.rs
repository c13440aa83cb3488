//! `catamaran info`.

use std::io::{self, Write};

use anyhow::Result;
use catamaran::base::{VERSION, available_cores, cpu_features};
use catamaran::kernel::int8::Instance;

use crate::backend;

/// Print the version, the CPU, the BLAS back ends and the instruction sets of the exact path.
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
    for (i, instance) in Instance::ALL.into_iter().enumerate() {
        let state = match instance.refusal() {
            Some(why) => why,
            None if instance == Instance::best() => "used",
            None => "available",
        };
        let label = if i == 0 { "exact path" } else { "" };
        writeln!(out, "{label:14}{}: {state}", instance.name())?;
    }
    Ok(())
}

/// What the CPU calls itself.
pub fn cpu_model() -> String {
    #[cfg(target_arch = "x86_64")]
    if let Some(brand) = raw_cpuid::CpuId::new().get_processor_brand_string() {
        return brand.as_str().trim().to_owned();
    }
    format!("unknown ({})", std::env::consts::ARCH)
}
