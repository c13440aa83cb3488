//! # Slime moulds
//!
//! Agents on a surface that leave trails in its texture (thesis, chapter 3). Textures are size
//! x size texels, rows along u, the first at v = 0.
//!
//! ```c
//! double square[12] = {0, 0, 0, 1, 0, 0, 1, 1, 0, 0, 1, 0}, coverage = 0;
//! uint32_t faces[6] = {0, 1, 2, 0, 2, 3};
//! cata_slime_params params = {.struct_size = sizeof params, .agents = 1000, .size = 64};
//! cata_slime *slime;
//! if (cata_slime_new(4, square, 2, faces, NULL, NULL, NULL, &params, &slime) == CATA_OK) {
//!     cata_slime_step(slime, 30);
//!     cata_slime_coverage(slime, 0, &coverage, NULL);
//!     cata_slime_free(slime);
//! }
//! ```

use std::ffi::{c_char, c_void};

use super::boundary::boundary;
use super::device::chosen;
use super::outputs::{copy, tell};
use super::params::{Params, init, or_default, params, read_or_zeros};
use super::pointer::{free, hand_over, known, known_mut, mesh, optional_slice, output, slice_mut};
use super::progress::{Caller, cata_progress};
use super::status::{Failure, cata_status};
use catamaran::Par;
#[cfg(feature = "opencl")]
use catamaran_simulation::opencl::SlimeOnDevice;
use catamaran_simulation::texture::slime::{
    Blur, Coverage, Mask, Options, Simulation, Surface, TangentStep, atlas,
};

/// `turns`: at random, up to the turn speed.
pub const CATA_SLIME_TURNS_RANDOM: i32 = 0;
/// `turns`: always at the turn speed.
pub const CATA_SLIME_TURNS_EVEN: i32 = 1;
/// `blur`: over the surface, across seams.
pub const CATA_SLIME_BLUR_SURFACE: i32 = 0;
/// `blur`: of the texture alone.
pub const CATA_SLIME_BLUR_TEXTURE: i32 = 1;
/// `lengths`: those of the surface.
pub const CATA_SLIME_LENGTHS_SURFACE: i32 = 0;
/// `lengths`: those of the texture, of side 1.
pub const CATA_SLIME_LENGTHS_TEXTURE: i32 = 1;

/// `size`, where it is 0.
pub const CATA_SLIME_SIZE: usize = 2048;

/// Properties of slime moulds (thesis, table 3.1; docs/algorithms/slime.md). Lengths are in
/// hundredths of the square root of the area of the surface, times in seconds.
#[repr(C)]
#[derive(Debug, Clone, Copy)]
pub struct cata_slime_params {
    /// sizeof(cata_slime_params).
    pub struct_size: usize,
    /// Threads, at most; 0: all.
    pub threads: usize,
    /// Progress callback, called after each step.
    pub progress: cata_progress,
    /// Passed to `progress`.
    pub progress_user: *mut c_void,
    /// Number of agents, below 2^32; 0: 1,000,000.
    pub agents: usize,
    /// Number of species, from 1 to 15; 0: 1.
    pub species: usize,
    /// Texels of a side of the texture, a multiple of 32, at most 16384; 0: 2048.
    pub size: usize,
    /// An OpenCL device (see Devices), which keeps agents and textures between calls; NULL: the
    /// processor. The bytes are the same where devices round as processors do.
    pub device: *const c_char,
    /// Seed of all random numbers.
    pub seed: u32,
    /// 0: steps that are exact; else the number of sub-steps that are projected (thesis,
    /// algorithm 3.1).
    pub substeps: u32,
    /// Seconds of a step; 0: 1 / 30.
    pub time_step: f64,
    /// Hundredths a second, such as 1 to 2; 0: 1.5.
    pub movement_speed: f64,
    /// Degrees a second; 0: 1800.
    pub turn_speed: f64,
    /// Distance from an agent to its sensors, in hundredths, such as 0.4 to 2; 0: 1.
    pub vision_distance: f64,
    /// Angle between sensors, in degrees, such as 10 to 50; 0: 30.
    pub vision_angle: f64,
    /// Pheromone that evaporates in a second, where an agent leaves 1, such as 0.2 to 1; 0: 0.4.
    pub evaporation_rate: f64,
    /// Blurs a second; 0: 6.
    pub diffusion_rate: f64,
    /// One of CATA_SLIME_TURNS_*.
    pub turns: i32,
    /// One of CATA_SLIME_BLUR_*.
    pub blur: i32,
    /// One of CATA_SLIME_LENGTHS_*.
    pub lengths: i32,
}

params!(cata_slime_params, lengths: i32);

/// Slime moulds on a surface.
pub struct cata_slime {
    /// With a device: the surface, and the initial agents and textures.
    simulation: Simulation,
    #[cfg(feature = "opencl")]
    on_device: Option<Box<SlimeOnDevice>>,
    par: Par,
    caller: Caller,
}

// SAFETY: all functions of OpenCL are thread-safe but the one that sets an argument of a kernel.
// Of the functions that take a const simulation, only the coverage calls it, under a lock.
#[cfg(feature = "opencl")]
unsafe impl Sync for cata_slime {}

/// Fills a struct with the defaults.
///
/// # Safety
/// `params` points to `struct_size` writable bytes.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn cata_slime_params_init(
    params: *mut cata_slime_params,
    struct_size: usize,
) -> cata_status {
    // SAFETY: clause `structs` (`params`).
    unsafe { init(params, struct_size) }
}

/// Creates a simulation: agents spread over a surface, and a texture without pheromone.
///
/// - `uv`: 6 n_faces elements: u, v of the three corners of each face, from 0 to 1; NULL: every
///   triangle gets a place of its own in the texture, which cata_slime_uv gives.
/// - `start`: a texture: not 0 where agents start; NULL: anywhere.
/// - `ground`: a texture: 0 free, 1 obstacle, 2 attractor; NULL: all free.
///
/// Returns CATA_ERR_MESH for an edge of three faces or more, and for a face without area, in
/// space or in the texture; CATA_ERR_BACKEND when the device refuses.
///
/// # Safety
/// The pointers are as described.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn cata_slime_new(
    n_vertices: usize,
    vertices: *const f64,
    n_faces: usize,
    faces: *const u32,
    uv: *const f64,
    start: *const u8,
    ground: *const u8,
    params: *const cata_slime_params,
    slime: *mut *mut cata_slime,
) -> cata_status {
    boundary(|| {
        // SAFETY: clause `memory` (the mesh, 3 numbers a vertex and 3 indices a face; `slime`, one
        // value).
        let (mesh, slime) =
            unsafe { (mesh(n_vertices, vertices, n_faces, faces)?, output("slime", slime)?) };
        // SAFETY: clause `structs` (`params`).
        let params = unsafe { read_or_zeros("params", params) }?;
        let options = options(&params)?;
        options.check()?;
        // SAFETY: clause `passed on` (`chosen`).
        let device = unsafe { chosen(params.device) }?;
        let texels = options.size * options.size;
        // SAFETY: clause `memory` (`uv`, `6 * n_faces` elements; `start`, `texels` elements;
        // `ground`, `texels` elements).
        let (uv, start, ground) = unsafe {
            (
                optional_slice("uv", uv.cast::<[[f64; 2]; 3]>(), n_faces)?,
                optional_slice("start", start, texels)?,
                optional_slice("ground", ground, texels)?,
            )
        };
        let uv = match uv {
            None => atlas(&mesh, options.size)?,
            Some(uv) => uv.to_vec(),
        };
        let mask = Mask {
            start: start.unwrap_or_default().iter().map(|&texel| texel != 0).collect(),
            ground: ground.unwrap_or_default().to_vec(),
        };
        let surface = Surface::of_faces(&mesh, uv)?;
        let simulation = Simulation::new(surface, &options, &mask)?;
        #[cfg(feature = "opencl")]
        let on_device = match device {
            Some(device) => Some(Box::new(SlimeOnDevice::new(&device, &simulation)?)),
            None => None,
        };
        #[cfg(not(feature = "opencl"))]
        let None = device;
        let made = cata_slime {
            simulation,
            #[cfg(feature = "opencl")]
            on_device,
            par: params.par(),
            caller: params.caller(),
        };
        hand_over(slime, made);
        Ok(())
    })
}

/// Returns the options of the caller.
pub(super) fn options(params: &cata_slime_params) -> Result<Options, Failure> {
    let default = Options::default();
    let [turns, blur, lengths] =
        [("turns", params.turns), ("blur", params.blur), ("lengths", params.lengths)];
    Ok(Options::new()
        .agents(or_default(params.agents, default.agents))
        .species(or_default(params.species, default.species))
        .size(or_default(params.size, CATA_SLIME_SIZE))
        .seed(params.seed)
        .time_step(or_default(params.time_step, default.time_step))
        .movement_speed(or_default(params.movement_speed, default.movement_speed))
        .turn_speed(or_default(params.turn_speed, default.turn_speed))
        .vision_distance(or_default(params.vision_distance, default.vision_distance))
        .vision_angle(or_default(params.vision_angle, default.vision_angle))
        .evaporation_rate(or_default(params.evaporation_rate, default.evaporation_rate))
        .diffusion_rate(or_default(params.diffusion_rate, default.diffusion_rate))
        .turn_noise(if is_second(turns)? { 0.0 } else { 1.0 })
        .tangent_step(match params.substeps {
            0 => TangentStep::Unfold,
            substeps => TangentStep::Project { substeps },
        })
        .blur(if is_second(blur)? { Blur::Gaussian } else { Blur::SeamAware })
        .length_rescaling(!is_second(lengths)?))
}

/// Returns whether a field has the second of its two values.
fn is_second((field, value): (&str, i32)) -> Result<bool, Failure> {
    match value {
        0 | 1 => Ok(value == 1),
        _ => {
            let any = format!("a CATA_SLIME_{}_* value", field.to_uppercase());
            Err(Failure::argument(&format!("params.{field}"), any, value))
        }
    }
}

/// Frees a simulation.
///
/// # Safety
/// `slime` is NULL or from cata_slime_new, and has not been freed before.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn cata_slime_free(slime: *mut cata_slime) {
    // SAFETY: clause `handles` (`slime`).
    unsafe { free(slime) };
}

/// Computes `steps` steps. Those before a cancelled one are done.
///
/// # Safety
/// The pointer is as described.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn cata_slime_step(slime: *mut cata_slime, steps: u32) -> cata_status {
    boundary(|| {
        // SAFETY: clause `handles` (`slime`).
        let slime = unsafe { known_mut("slime", slime) }?;
        slime.caller.with(|progress| {
            #[cfg(feature = "opencl")]
            if let Some(on_device) = &mut slime.on_device {
                return Ok(on_device.run(steps, progress)?);
            }
            Ok(slime.simulation.run(steps, slime.par, progress)?)
        })
    })
}

/// Gets the texels of a side of a texture, species, triangles, and steps that are done; NULL where
/// not wanted.
///
/// # Safety
/// The pointers are as described.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn cata_slime_size(
    slime: *const cata_slime,
    size: *mut usize,
    species: *mut usize,
    faces: *mut usize,
    steps: *mut u32,
) -> cata_status {
    boundary(|| {
        // SAFETY: clause `memory` (`size`, one value; `species`, one value; `faces`, one value;
        // `steps`, one value), clause `handles` (`slime`).
        unsafe {
            let slime = known("slime", slime)?;
            let own = &slime.simulation;
            tell! {
                size: own.texels().size(),
                species: own.species(),
                faces: own.surface().len(),
                steps: slime.steps(),
            }
        }
        Ok(())
    })
}

/// Gets the texture of a species (from 0) as it is now: pheromone, from 0 to 1.
///
/// # Safety
/// The pointers are as described.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn cata_slime_texture(
    slime: *const cata_slime,
    species: usize,
    texture: *mut f32,
) -> cata_status {
    boundary(|| {
        // SAFETY: clause `handles` (`slime`).
        let slime = unsafe { known("slime", slime)? };
        check_species(&slime.simulation, species)?;
        let own = slime.simulation.texture(species);
        // SAFETY: clause `memory` (`texture`, `own.len()` elements).
        let texture = unsafe { slice_mut("texture", texture, own.len()) }?;
        #[cfg(feature = "opencl")]
        if let Some(on_device) = &slime.on_device {
            return Ok(on_device.read_texture(species, texture)?);
        }
        texture.copy_from_slice(own);
        Ok(())
    })
}

/// Computes how much of the surface a species covers (thesis, equation 3.2): the mean of its
/// pheromone, and the part of the surface that has any; NULL where not wanted.
///
/// # Safety
/// The pointers are as described.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn cata_slime_coverage(
    slime: *const cata_slime,
    species: usize,
    coverage: *mut f64,
    presence: *mut f64,
) -> cata_status {
    boundary(|| {
        // SAFETY: clause `memory` (`coverage`, one value; `presence`, one value), clause `handles`
        // (`slime`).
        unsafe {
            let slime = known("slime", slime)?;
            check_species(&slime.simulation, species)?;
            let found = slime.coverage()?[species];
            tell!(coverage: found.coverage, presence: found.presence);
        }
        Ok(())
    })
}

/// Gets the texture coordinates of the corners of faces, as cata_slime_new takes them.
///
/// # Safety
/// The pointers are as described.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn cata_slime_uv(slime: *const cata_slime, uv: *mut f64) -> cata_status {
    boundary(|| {
        // SAFETY: clause `memory` (`uv`, 6 elements a face), clause `handles` (`slime`).
        unsafe {
            let own = known("slime", slime)?.simulation.surface().uv();
            copy("uv", uv, own.as_flattened().as_flattened())
        }
    })
}

fn check_species(simulation: &Simulation, species: usize) -> Result<(), Failure> {
    let count = simulation.species();
    if species < count {
        Ok(())
    } else {
        Err(Failure::beyond("species", count, "species", species))
    }
}

impl cata_slime {
    fn steps(&self) -> u32 {
        #[cfg(feature = "opencl")]
        if let Some(on_device) = &self.on_device {
            return on_device.steps();
        }
        self.simulation.state().step
    }

    fn coverage(&self) -> Result<Vec<Coverage>, Failure> {
        #[cfg(feature = "opencl")]
        if let Some(on_device) = &self.on_device {
            return Ok(on_device.coverage()?);
        }
        Ok(self.simulation.coverage(self.par))
    }
}
