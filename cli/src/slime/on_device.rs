//! A simulation whose steps a device takes.

use anyhow::Result;
use catamaran::texture::slime::{Coverage, Simulation};

use crate::device::Device;

/// The kernels on a device.
#[cfg(feature = "opencl")]
pub struct OnDevice(catamaran::opencl::SlimeOnDevice);

#[cfg(feature = "opencl")]
impl OnDevice {
    /// From where the simulation is.
    pub fn new(device: &Device, simulation: &Simulation) -> Result<Self> {
        Ok(Self(catamaran::opencl::SlimeOnDevice::new(device, simulation)?))
    }

    /// One step, and what is covered then.
    pub fn step(&mut self) -> Result<Vec<Coverage>> {
        self.0.run(1, catamaran::base::Progress::none())?;
        Ok(self.0.coverage()?)
    }

    /// Brings the simulation to where the device is.
    pub fn give_back(&self, simulation: &mut Simulation) -> Result<()> {
        Ok(self.0.give_back(simulation)?)
    }
}

/// There is no device in this build.
#[cfg(not(feature = "opencl"))]
pub struct OnDevice(std::convert::Infallible);

#[cfg(not(feature = "opencl"))]
impl OnDevice {
    /// Never called.
    pub fn new(device: &Device, _simulation: &Simulation) -> Result<Self> {
        match *device {}
    }

    /// Never called.
    pub fn step(&mut self) -> Result<Vec<Coverage>> {
        match self.0 {}
    }

    /// Never called.
    pub fn give_back(&self, _simulation: &mut Simulation) -> Result<()> {
        match self.0 {}
    }
}
