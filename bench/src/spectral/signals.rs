//! The functions that are approximated and transferred (thesis, section 1.4.3).

use catamaran::Par;
use catamaran::faer::Mat;
use catamaran_geometry::spectral::coordinates;
use catamaran_geometry::spectral::descriptors::{
    RingOptions, ShotOptions, geodesic_rings, heat_kernel_signature, heat_times, shot,
    wave_kernel_signature, wave_scales,
};

use super::functions::{channels, geodesic_cells, heat_kernels, random};
use super::shapes::Shape;
use crate::Result;

/// Number of eigenfunctions of "HK K", and of the signatures.
pub const MANY: usize = 200;
/// The time of heat kernels, on shapes of area 1.
const TIME: f64 = 1e-3;
/// Number of scales of a signature, and of those that are used.
const SCALES: [usize; 2] = [100, 10];
/// Number of random functions of each kind.
const COUNT: usize = 10;
/// Radius of local descriptors, on shapes of area 1.
const RADIUS: f64 = 0.08;
/// Share of the area of an indicator.
const SHARE: f64 = 0.1;

/// The names of the functions, in the order of the tables; the last one stands for AWFT.
pub const NAMES: [&str; 9] = ["HK k", "HK K", "HKS", "WKS", "Rand", "XYZ", "Ind", "SHOT", "rings"];

/// Functions of each name, one matrix each.
pub type Signals = [Mat<f64>; NAMES.len()];

/// Returns the functions of each name, n x anything; `k` is the number of eigenfunctions of "HK k".
///
/// # Errors
/// The errors of the library.
pub fn signals(shape: &Shape, k: usize) -> Result<Signals> {
    let par = Par::all();
    let (few, many) = (shape.first(k)?, shape.first(MANY)?);
    let [scales, used] = SCALES;
    let times = heat_times(many.values(), scales)?;
    let heat = heat_kernel_signature(many.values(), many.functions(), &times, par)?;
    let waves = wave_scales(many.values(), scales)?;
    let waves = wave_kernel_signature(many.values(), many.functions(), &waves, par)?;
    let heat = channels(heat.as_ref(), used)?;
    let ring_options = RingOptions::new(RADIUS, 4).par(par);
    let some_heat = channels(heat.as_ref(), 3)?;
    Ok([
        heat_kernels(few.values(), few.functions(), TIME, COUNT, 1)?,
        heat_kernels(many.values(), many.functions(), TIME, COUNT, 1)?,
        heat,
        channels(waves.as_ref(), used)?,
        random(shape.mesh.vertices().len(), COUNT, 2),
        coordinates(&shape.mesh),
        geodesic_cells(&shape.mesh, SHARE, COUNT, 3)?,
        shot(&shape.mesh, &ShotOptions::new(RADIUS).par(par))?,
        geodesic_rings(&shape.mesh, some_heat.as_ref(), &ring_options)?,
    ])
}
