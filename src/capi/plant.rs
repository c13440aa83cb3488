//! # Plants
//!
//! Water in a plant: diffusion, wilting (thesis, chapter 4).

use std::ffi::c_char;
use std::mem::offset_of;
use std::path::PathBuf;

use super::boundary::{boundary, text};
use super::params::{Versioned, init, read};
use super::pointer::{output, slice, slice_mut};
use super::progress::par;
use super::status::{CATA_ERR_ARGUMENT, CATA_ERR_NULL, CATA_ERR_SHAPE, Failure, cata_status};
use crate::Par;
use crate::plant::{
    Bdf6, Conductivity, Elasticity, Plant, Segment, Start, WaterModel, WaterOptions,
};

/// The parent of the root of a plant.
pub const CATA_NO_PARENT: u32 = u32::MAX;

/// The constants of the water of a plant, in SI units.
#[repr(C)]
#[derive(Debug, Clone, Copy)]
pub struct cata_plant_params {
    /// sizeof(cata_plant_params).
    pub struct_size: usize,
    /// Threads, at most; 0: all.
    pub threads: usize,
    /// What leaves lose, in kg / (s m^2), at least 0; 60 g / (h m^2) is 1.667e-5.
    pub loss: f64,
    /// What the root takes from the soil, in kg / s, at least 0.
    pub intake: f64,
    /// Conductance of a segment, as a part of that of a pipe as wide; positive; 0: 1e-9.
    pub conductance: f64,
    /// Pressure in full cells, in Pa; positive; 0: 1e6.
    pub modulus: f64,
    /// Viscosity of the sap, in Pa s; positive; 0: 1e-3.
    pub viscosity: f64,
    /// Water in a cubic metre of full tissue, in kg; positive; 0: 1000.
    pub density: f64,
}

impl Versioned for cata_plant_params {
    const NAME: &'static str = "cata_plant_params";
    const FIRST_SIZE: usize = offset_of!(Self, density) + size_of::<f64>();
}

/// The water in a plant: its constants, the present, and what it takes to go on. Opaque.
pub struct cata_plant {
    model: WaterModel,
    par: Par,
    stepper: Option<Bdf6>,
    /// Whether the model has changed since the last step.
    changed: bool,
}

/// Fills a struct with the defaults.
///
/// # Safety
/// `params` points to `struct_size` writable bytes.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn cata_plant_params_init(
    params: *mut cata_plant_params,
    struct_size: usize,
) -> cata_status {
    // SAFETY: the promises are the same.
    unsafe { init(params, struct_size) }
}

/// The model of the water of a plant of n segments.
///
/// - `n`: at least 1.
/// - `tails`: 3 n elements, read: x, y, z of the end of every segment, in metres.
/// - `radii`: n elements, read: in metres, positive.
/// - `parents`: n elements, read: the segment at whose end each begins, below n; CATA_NO_PARENT
///   for the root.
/// - `leaves`: n elements, read: 1 for a vein of a leaf, 0 for stem.
/// - `base`: 3 elements, read: where the root segment begins; NULL: it goes straight on into its
///   first child and is as long.
/// - `plant`: written: the model, to be given to cata_plant_free.
///
/// Returns CATA_ERR_MESH for a node on a cycle, isolated, a second root, or without positive
/// radius or length; the message names it.
///
/// # Safety
/// The pointers are as described.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn cata_plant_new(
    n: usize,
    tails: *const f64,
    radii: *const f64,
    parents: *const u32,
    leaves: *const i32,
    base: *const f64,
    params: *const cata_plant_params,
    plant: *mut *mut cata_plant,
) -> cata_status {
    boundary(|| {
        let length = n.checked_mul(3).ok_or_else(|| {
            Failure::new(CATA_ERR_SHAPE, "tails: 3 n elements exceed the address space")
        })?;
        // SAFETY: the caller's promise.
        let (tails, radii, parents, leaves, base, place) = unsafe {
            (
                slice("tails", tails, length)?,
                slice("radii", radii, n)?,
                slice("parents", parents, n)?,
                slice("leaves", leaves, n)?,
                if base.is_null() { None } else { Some(slice("base", base, 3)?) },
                output("plant", plant)?,
            )
        };
        let segment = |v: usize| Segment {
            leaf: leaves[v] != 0,
            ..Segment::stem([0, 1, 2].map(|i| tails[3 * v + i]), radii[v])
        };
        let segments = (0..n).map(segment).collect();
        let parents: Vec<Option<u32>> =
            parents.iter().map(|&p| (p != CATA_NO_PARENT).then_some(p)).collect();
        let plant = Plant::new(segments, &parents, base.map(|b| [b[0], b[1], b[2]]))?;
        // SAFETY: the caller's promise.
        *place = unsafe { model(&plant, params) }?;
        Ok(())
    })
}

/// The model of the water of the plant in a file: .txt (the reference format: `verts N`, ...),
/// .swc, .mtg or .obj (polylines), each also as .gz or .xz.
///
/// - `path`: NUL-terminated, in UTF-8.
/// - `params`, `plant`: as in cata_plant_new.
///
/// Returns what cata_plant_new returns, or CATA_ERR_IO with the file and the line in the message.
///
/// # Safety
/// The pointers are as described.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn cata_plant_read(
    path: *const c_char,
    params: *const cata_plant_params,
    plant: *mut *mut cata_plant,
) -> cata_status {
    boundary(|| {
        // SAFETY: the caller's promise.
        let (path, place) = unsafe { (text("path", path)?, output("plant", plant)?) };
        let path = path.to_str().map_err(|_| Failure::new(CATA_ERR_ARGUMENT, "path: not UTF-8"))?;
        let plant = crate::plant::read(&PathBuf::from(path))?;
        // SAFETY: the caller's promise.
        *place = unsafe { model(&plant, params) }?;
        Ok(())
    })
}

/// Gives a model back.
///
/// # Safety
/// The pointer is as described.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn cata_plant_free(plant: *mut cata_plant) {
    boundary(|| {
        if !plant.is_null() {
            // SAFETY: it came from `Box::into_raw`, and the caller promises to free it once.
            drop(unsafe { Box::from_raw(plant) });
        }
        Ok(())
    });
}

/// The number of nodes of a plant; 0 for NULL.
///
/// # Safety
/// The pointer is NULL or a live model.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn cata_plant_size(plant: *const cata_plant) -> usize {
    // SAFETY: the caller's promise.
    unsafe { plant.as_ref() }.map_or(0, |plant| plant.model.len())
}

/// The water of every node when its cells are full, in kg: how a healthy plant begins.
///
/// - `plant`: a live model.
/// - `n`: cata_plant_size.
/// - `water`: n elements, written.
///
/// # Safety
/// The pointers are as described.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn cata_plant_full_water(
    plant: *const cata_plant,
    n: usize,
    water: *mut f64,
) -> cata_status {
    boundary(|| {
        // SAFETY: the caller's promise.
        let (plant, water) = unsafe { (live(plant)?, slice_mut("water", water, n)?) };
        copy(&plant.model.full(), water)
    })
}

/// Sets what all leaves lose, in kg / (s m^2), from now on: another weather.
///
/// Not for two threads at once on the same model.
///
/// # Safety
/// `plant` is a live model.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn cata_plant_set_loss(plant: *mut cata_plant, loss: f64) -> cata_status {
    // SAFETY: the caller's promise.
    unsafe { change(plant, |model| model.set_loss(loss)) }
}

/// Sets what the root takes from the soil, in kg / s, from now on.
///
/// Returns and threads: as cata_plant_set_loss.
///
/// # Safety
/// `plant` is a live model.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn cata_plant_set_intake(plant: *mut cata_plant, intake: f64) -> cata_status {
    // SAFETY: the caller's promise.
    unsafe { change(plant, |model| model.set_intake(intake)) }
}

/// Multiplies the conductance between a node (below cata_plant_size, not the root) and its parent
/// by `factor`, at least 0, from now on; 0 cuts the connection.
///
/// Returns and threads: as cata_plant_set_loss.
///
/// # Safety
/// `plant` is a live model.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn cata_plant_weaken(
    plant: *mut cata_plant,
    node: usize,
    factor: f64,
) -> cata_status {
    // SAFETY: the caller's promise.
    unsafe { change(plant, |model| model.weaken(node, factor)) }
}

/// The water of every node some time after it was `water`, at once, without time steps: for any
/// times. Does not read or change the present of cata_plant_start.
///
/// - `plant`: a live model.
/// - `n`: cata_plant_size.
/// - `water`: n elements, read: in kg, finite.
/// - `seconds`: at least 0.
/// - `result`: n elements, written: in kg. May be the same memory as `water`.
///
/// # Safety
/// The pointers are as described.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn cata_plant_water_after(
    plant: *const cata_plant,
    n: usize,
    water: *const f64,
    seconds: f64,
    result: *mut f64,
) -> cata_status {
    boundary(|| {
        // SAFETY: the caller's promise. The copy ends what is borrowed before `result` is written.
        let (plant, water) = unsafe { (live(plant)?, slice("water", water, n)?.to_vec()) };
        // SAFETY: the caller's promise.
        let result = unsafe { slice_mut("result", result, n) }?;
        copy(&plant.model.water_after(&water, seconds, plant.par)?, result)
    })
}

/// Makes `water` the present, from which cata_plant_step goes on.
///
/// - `plant`: a live model.
/// - `n`: cata_plant_size.
/// - `water`: n elements, read: in kg, finite; NULL: full cells.
/// - `step`: seconds of a step, positive.
///
/// Not for two threads at once on the same model.
///
/// # Safety
/// The pointers are as described.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn cata_plant_start(
    plant: *mut cata_plant,
    n: usize,
    water: *const f64,
    step: f64,
) -> cata_status {
    boundary(|| {
        // SAFETY: the caller's promise.
        let plant = unsafe { live_mut(plant) }?;
        let water = match water.is_null() {
            true => plant.model.full(),
            // SAFETY: the caller's promise.
            false => unsafe { slice("water", water, n) }?.to_vec(),
        };
        plant.stepper = Some(Bdf6::new(&plant.model, &water, step, Start::Radau, plant.par)?);
        plant.changed = false;
        Ok(())
    })
}

/// Goes `count` steps ahead (0 included) and gives the water there.
///
/// - `plant`: a live model, after cata_plant_start. What was changed since the last step counts
///   from now on.
/// - `n`: cata_plant_size.
/// - `water`: n elements, written: in kg; NULL: not wanted.
///
/// Not for two threads at once on the same model.
///
/// # Safety
/// The pointers are as described.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn cata_plant_step(
    plant: *mut cata_plant,
    count: usize,
    n: usize,
    water: *mut f64,
) -> cata_status {
    boundary(|| {
        // SAFETY: the caller's promise.
        let plant = unsafe { live_mut(plant) }?;
        let cata_plant { model, stepper, changed, .. } = plant;
        let Some(stepper) = stepper else {
            let why = "plant: cata_plant_start has not been called";
            return Err(Failure::new(CATA_ERR_ARGUMENT, why));
        };
        let water = match water.is_null() {
            true => None,
            // SAFETY: the caller's promise.
            false => Some(unsafe { slice_mut("water", water, n) }?),
        };
        if water.is_some() && n != model.len() {
            return Err(size(model.len(), n));
        }
        if std::mem::take(changed) {
            stepper.restart(model, stepper.step_length())?;
        }
        (0..count).for_each(|_| stepper.step());
        water.map_or(Ok(()), |water| copy(&stepper.water(), water))
    })
}

/// The modulus of elasticity of every node, from its water: `dry + (full - dry) (s(k (w - x)) -
/// s(-k x)) / (s(k (1 - x)) - s(-k x))` of the relative water content w, with s the logistic
/// function.
///
/// - `plant`: a live model.
/// - `n`: cata_plant_size.
/// - `water`: n elements, read: in kg.
/// - `full`, `dry`: of full cells and of dry ones, in Pa; 0 < dry <= full; such as 5e7 and 3e5.
/// - `steepness`: k, positive; such as 10.
/// - `shift`: x; such as 0.75.
/// - `moduli`: n elements, written: in Pa.
///
/// # Safety
/// The pointers are as described.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn cata_plant_stiffness(
    plant: *const cata_plant,
    n: usize,
    water: *const f64,
    full: f64,
    dry: f64,
    steepness: f64,
    shift: f64,
    moduli: *mut f64,
) -> cata_status {
    boundary(|| {
        // SAFETY: the caller's promise.
        let (plant, water, moduli) =
            unsafe { (live(plant)?, slice("water", water, n)?, slice_mut("moduli", moduli, n)?) };
        let elasticity = Elasticity::Relative { dry, full, steepness, shift };
        copy(&elasticity.moduli(water, &plant.model.full())?, moduli)
    })
}

/// A model on the heap.
///
/// # Safety
/// `params` is NULL or points to a struct as the header describes it.
unsafe fn model(
    plant: &Plant,
    params: *const cata_plant_params,
) -> Result<*mut cata_plant, Failure> {
    let mut options = WaterOptions { loss: 0.0, ..WaterOptions::default() };
    let mut threads = 0;
    if !params.is_null() {
        // SAFETY: the caller's promise.
        let params = unsafe { read(params) }?;
        threads = params.threads;
        options.loss = params.loss;
        options.intake = params.intake;
        let given = |value: f64, default: f64| if value == 0.0 { default } else { value };
        if params.conductance != 0.0 {
            options.conductivity = Conductivity::Pipe { scale: params.conductance };
        }
        options.modulus = given(params.modulus, options.modulus);
        options.viscosity = given(params.viscosity, options.viscosity);
        options.density = given(params.density, options.density);
    }
    let model = WaterModel::new(plant, &options)?;
    let plant = cata_plant { model, par: par(threads), stepper: None, changed: false };
    Ok(Box::into_raw(Box::new(plant)))
}

/// Changes a model.
///
/// # Safety
/// `plant` is NULL or a live model that nobody else uses.
unsafe fn change(
    plant: *mut cata_plant,
    work: impl FnOnce(&mut WaterModel) -> crate::Result<()>,
) -> cata_status {
    boundary(|| {
        // SAFETY: the caller's promise.
        let plant = unsafe { live_mut(plant) }?;
        work(&mut plant.model)?;
        plant.changed = true;
        Ok(())
    })
}

/// # Safety
/// `plant` is NULL or a live model that nobody changes during `'a`.
unsafe fn live<'a>(plant: *const cata_plant) -> Result<&'a cata_plant, Failure> {
    // SAFETY: the caller's promise.
    unsafe { plant.as_ref() }.ok_or_else(|| Failure::new(CATA_ERR_NULL, "plant: NULL"))
}

/// # Safety
/// `plant` is NULL or a live model that nobody else uses during `'a`.
unsafe fn live_mut<'a>(plant: *mut cata_plant) -> Result<&'a mut cata_plant, Failure> {
    // SAFETY: the caller's promise.
    unsafe { plant.as_mut() }.ok_or_else(|| Failure::new(CATA_ERR_NULL, "plant: NULL"))
}

fn copy(values: &[f64], place: &mut [f64]) -> Result<(), Failure> {
    if values.len() != place.len() {
        return Err(size(values.len(), place.len()));
    }
    place.copy_from_slice(values);
    Ok(())
}

fn size(nodes: usize, n: usize) -> Failure {
    Failure::new(CATA_ERR_SHAPE, format!("n: must be {nodes} (nodes of the plant), is {n}"))
}
