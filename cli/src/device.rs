//! Where kernels run: `--device`.

use anyhow::Result;
#[cfg(feature = "opencl")]
use catamaran_simulation::opencl::DeviceInfo;

use crate::info::WIDTH;
#[cfg(feature = "opencl")]
use crate::info::first;
use crate::report::row;
#[cfg(feature = "opencl")]
use crate::report::{seconds, status};
#[cfg(feature = "opencl")]
use crate::signals;

/// The device that does the work.
#[derive(clap::Args)]
pub struct DeviceArgs {
    /// Device that computes: `cpu` (without OpenCL), or an OpenCL device by its number or a part of
    /// its name, as `catamaran info` lists them; `opencl` is the first GPU, or the first device if
    /// there is no GPU.
    #[arg(long, value_name = "cpu|NAME", default_value = "cpu")]
    device: String,
}

/// An OpenCL device that is ready.
#[cfg(feature = "opencl")]
pub type Device = catamaran_simulation::opencl::Device;

/// A device, of which this build has none.
#[cfg(not(feature = "opencl"))]
pub enum Device {}

impl DeviceArgs {
    /// Opens the device; `None` stands for the CPU without OpenCL.
    pub fn open(&self) -> Result<Option<Device>> {
        match self.device.as_str() {
            "cpu" => Ok(None),
            "opencl" => opened("").map(Some),
            name => opened(name).map(Some),
        }
    }
}

#[cfg(feature = "opencl")]
fn opened(name: &str) -> Result<Device> {
    signals::kept(|| Device::open_timed(name)).map_err(crate::common::as_option)
}

#[cfg(not(feature = "opencl"))]
fn opened(name: &str) -> Result<Device> {
    anyhow::bail!("--device {name}: OpenCL is not in this build (build with --features opencl)")
}

/// Returns the name of a device.
#[cfg(feature = "opencl")]
pub fn name(device: &Device) -> &str {
    &device.info().name
}

/// Returns the name of a device.
#[cfg(not(feature = "opencl"))]
pub fn name(device: &Device) -> &str {
    match *device {}
}

/// Reports how long kernels and transfers of the device took, by its own clock.
#[cfg(feature = "opencl")]
pub fn report_times(device: Option<&Device>) -> Result<()> {
    let Some(device) = device else { return Ok(()) };
    let Some(times) = device.times()? else { return Ok(()) };
    let name = name(device);
    status!(
        "device",
        name = name,
        kernel_seconds = times.kernels.as_secs_f64(),
        transfer_seconds = times.transfers.as_secs_f64();
        "{name}: kernels {}, transfers {}",
        seconds(times.kernels),
        seconds(times.transfers)
    )
}

/// Reports nothing: there is no device.
#[cfg(not(feature = "opencl"))]
pub fn report_times(device: Option<&Device>) -> Result<()> {
    match device {
        Some(device) => match *device {},
        None => Ok(()),
    }
}

/// Reports each device, or why there is none, for `catamaran info`.
#[cfg(feature = "opencl")]
pub fn report() -> Result<()> {
    let devices = match catamaran_simulation::opencl::devices() {
        Ok(devices) => devices,
        Err(e) => return none(&e.to_string()),
    };
    for (i, device) in devices.iter().enumerate() {
        let DeviceInfo { index, name, platform, compute_units: units, memory, .. } = device;
        let gib = *memory as f64 / f64::from(1 << 30);
        row!(
            "opencl",
            available = true,
            index = index,
            name = name,
            platform = platform,
            compute_units = units,
            bytes = memory;
            "{:WIDTH$}{index}: {name}, {platform}, {units} units, {gib:.1} GiB",
            first(i, "opencl")
        )?;
    }
    Ok(())
}

/// Reports that there is no device, for `catamaran info`.
#[cfg(not(feature = "opencl"))]
pub fn report() -> Result<()> {
    none("not in this build (build with --features opencl)")
}

fn none(why: &str) -> Result<()> {
    row!("opencl", available = false, reason = why; "{:WIDTH$}{why}", "opencl")
}
