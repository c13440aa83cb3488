//! Runs a simulation on a device.

use anyhow::Result;
use catamaran_simulation::texture::slime::{Coverage, Simulation};

use crate::device::Device;

/// The kernels on a device.
#[cfg(feature = "opencl")]
pub struct OnDevice(catamaran_simulation::opencl::SlimeOnDevice);

#[cfg(feature = "opencl")]
impl OnDevice {
    /// Copies the simulation to the device.
    pub fn new(device: &Device, simulation: &Simulation) -> Result<Self> {
        Ok(Self(catamaran_simulation::opencl::SlimeOnDevice::new(device, simulation)?))
    }

    /// Computes at least one and at most `most` steps, and returns the coverage after each.
    pub fn advance(&mut self, most: u32) -> Result<Vec<Vec<Coverage>>> {
        Ok(self.0.advance(most)?)
    }

    /// Copies the texture of a species as bytes.
    pub fn frame(&mut self, species: usize, frame: &mut [u8]) -> Result<()> {
        Ok(self.0.frame(species, frame)?)
    }

    /// Copies the state of the device to the simulation.
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
    pub fn advance(&mut self, _most: u32) -> Result<Vec<Vec<Coverage>>> {
        match self.0 {}
    }

    /// Never called.
    pub fn frame(&mut self, _species: usize, _frame: &mut [u8]) -> Result<()> {
        match self.0 {}
    }

    /// Never called.
    pub fn give_back(&self, _simulation: &mut Simulation) -> Result<()> {
        match self.0 {}
    }
}
