//! # Slime moulds
//!
//! Agents on a surface that leave trails in its texture (thesis, chapter 3).

use std::ffi::c_void;
use std::mem::offset_of;

use super::boundary::boundary;
use super::params::{Versioned, flag, init, read};
use super::pointer::{check_size, mesh, optional_output, output, slice, slice_mut};
use super::progress::{cata_progress, par, watcher};
use super::status::{CATA_ERR_ARGUMENT, Failure, cata_status};
use crate::Par;
use crate::base::Progress;
use crate::texture::slime::{Blur, Mask, Options, Simulation, Surface, TangentStep, atlas};

/// What slime moulds are like (thesis, table 3.1; docs/algorithms/slime.md). Lengths are in
/// hundredths of the square root of the area of the surface, times in seconds of the simulation.
#[repr(C)]
#[derive(Debug, Clone, Copy)]
pub struct cata_slime_params {
    /// sizeof(cata_slime_params).
    pub struct_size: usize,
    /// Threads, at most; 0: all.
    pub threads: usize,
    /// Number of agents, below 2^32; 0: 1,000,000.
    pub agents: usize,
    /// Number of species, from 1 to 15; 0: 1.
    pub species: usize,
    /// Texels of a side of the texture, a multiple of 32, at most 16384; 0: 2048.
    pub size: usize,
    /// Of all randomness.
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
    /// From an agent to its sensors, in hundredths, such as 0.4 to 2; 0: 1.
    pub vision_distance: f64,
    /// Between sensors, in degrees, such as 10 to 50; 0: 30.
    pub vision_angle: f64,
    /// What evaporates in a second, such as 0.2 to 1; 0: 0.4.
    pub evaporation_rate: f64,
    /// Blurs a second; 0: 6.
    pub diffusion_rate: f64,
    /// 1: all turns are as large as the turn speed says; 0: up to that.
    pub even_turns: i32,
    /// 1: the blur is that of the texture alone; 0: it crosses seams.
    pub plain_blur: i32,
    /// 1: lengths are those of the texture, of side 1; 0: of the surface.
    pub no_length_rescaling: i32,
}

impl Versioned for cata_slime_params {
    const NAME: &'static str = "cata_slime_params";
    const FIRST_SIZE: usize = offset_of!(Self, no_length_rescaling) + size_of::<i32>();
}

/// Slime moulds on a surface. Made by cata_slime_new; for one thread at a time unless it is only
/// read.
pub struct cata_slime {
    simulation: Simulation,
    par: Par,
}

/// Fills a struct with the defaults.
///
/// # Safety
/// `params` points to `struct_size` writable bytes.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn cata_slime_params_init(
    params: *mut cata_slime_params,
    struct_size: usize,
) -> cata_status {
    // SAFETY: the promises are the same.
    unsafe { init(params, struct_size) }
}

/// Agents spread over a surface, and a texture without pheromone.
///
/// - `positions`: 3 `vertices` elements, read: x, y, z of each vertex.
/// - `triangles`: 3 `faces` elements, read: three vertices of each face, from 0.
/// - `uv`: 6 `faces` elements, read: u, v of the three corners of each face, from 0 to 1; NULL:
///   every triangle gets a place of its own in the texture, which cata_slime_uv gives.
/// - `start`: size x size elements (of the texture), read: not 0 where agents start; NULL:
///   anywhere.
/// - `ground`: size x size elements, read: 0 free, 1 obstacle, 2 attractor; NULL: all free.
/// - `slime`: one pointer, not NULL, written: to be given to cata_slime_free.
///
/// Textures have rows along u, the first at v = 0.
///
/// Returns CATA_ERR_MESH for an edge of three faces or more, and for a face without area, in
/// space or in the texture; the message names it.
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
        check_size::<f64>("uv", n_faces, 6)?;
        // SAFETY: the caller's promise.
        let (mesh, slime) =
            unsafe { (mesh(n_vertices, vertices, n_faces, faces)?, output("slime", slime)?) };
        // SAFETY: the caller's promise.
        let (options, par) = unsafe { options(params) }?;
        options.check()?;
        let uv = match uv.is_null() {
            true => atlas(&mesh, options.size)?,
            false => {
                // SAFETY: the caller's promise.
                let uv = unsafe { slice("uv", uv, 6 * n_faces) }?;
                uv.as_chunks::<2>().0.as_chunks::<3>().0.to_vec()
            }
        };
        let texels = options.size * options.size;
        let mut mask = Mask::default();
        if !start.is_null() {
            // SAFETY: the caller's promise.
            mask.start =
                unsafe { slice("start", start, texels) }?.iter().map(|&s| s != 0).collect();
        }
        if !ground.is_null() {
            // SAFETY: the caller's promise.
            mask.ground = unsafe { slice("ground", ground, texels) }?.to_vec();
        }
        let surface = Surface::of_faces(&mesh, uv)?;
        let simulation = Simulation::new(surface, &options, &mask)?;
        *slime = Box::into_raw(Box::new(cata_slime { simulation, par }));
        Ok(())
    })
}

/// What the caller asks for.
///
/// # Safety
/// `params` is NULL or points to a struct as the header describes it.
unsafe fn options(params: *const cata_slime_params) -> Result<(Options, Par), Failure> {
    let default = Options::default();
    if params.is_null() {
        return Ok((default, Par::all()));
    }
    // SAFETY: the caller's promise.
    let params = unsafe { read(params) }?;
    let count = |value: usize, default: usize| if value == 0 { default } else { value };
    let real = |value: f64, default: f64| if value == 0.0 { default } else { value };
    let options = Options {
        agents: count(params.agents, default.agents),
        species: count(params.species, default.species),
        size: count(params.size, default.size),
        seed: params.seed,
        time_step: real(params.time_step, default.time_step),
        movement_speed: real(params.movement_speed, default.movement_speed),
        turn_speed: real(params.turn_speed, default.turn_speed),
        vision_distance: real(params.vision_distance, default.vision_distance),
        vision_angle: real(params.vision_angle, default.vision_angle),
        evaporation_rate: real(params.evaporation_rate, default.evaporation_rate),
        diffusion_rate: real(params.diffusion_rate, default.diffusion_rate),
        turn_noise: if flag("params.even_turns", params.even_turns)? { 0.0 } else { 1.0 },
        tangent_step: match params.substeps {
            0 => TangentStep::Unfold,
            substeps => TangentStep::Project { substeps },
        },
        blur: match flag("params.plain_blur", params.plain_blur)? {
            true => Blur::Gaussian,
            false => Blur::SeamAware,
        },
        length_rescaling: !flag("params.no_length_rescaling", params.no_length_rescaling)?,
    };
    Ok((options, par(params.threads)))
}

/// Gives a simulation back.
///
/// `slime`: from cata_slime_new, not used any more afterwards; NULL is ignored.
///
/// # Safety
/// `slime` is NULL or from cata_slime_new, and was not given back before.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn cata_slime_free(slime: *mut cata_slime) {
    if !slime.is_null() {
        // SAFETY: from Box::into_raw, and the caller's promise.
        drop(unsafe { Box::from_raw(slime) });
    }
}

/// Goes `steps` steps ahead (0 included).
///
/// - `slime`: from cata_slime_new, not NULL.
/// - `progress`: told after each step; NULL: nobody.
/// - `progress_user`: handed to `progress` as it is; may be NULL.
///
/// After CATA_ERR_CANCELLED the steps before are done, and it can go on.
///
/// Not for two threads at once on the same simulation.
///
/// # Safety
/// The pointers are as described.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn cata_slime_step(
    slime: *mut cata_slime,
    steps: u32,
    progress: cata_progress,
    progress_user: *mut c_void,
) -> cata_status {
    boundary(|| {
        // SAFETY: the caller's promise.
        let slime = unsafe { slime.as_mut() }.ok_or_else(|| Failure::null("slime"))?;
        let watch = watcher(progress, progress_user);
        let watch = watch.as_ref().map_or(Progress::none(), Progress::from);
        Ok(slime.simulation.run(steps, slime.par, watch)?)
    })
}

/// How large a simulation is.
///
/// - `slime`: from cata_slime_new, not NULL.
/// - `size`, `species`, `faces`: one element each, written: texels of a side of the texture,
///   species, and triangles. NULL where not wanted.
/// - `steps`: one element, written: steps done. NULL where not wanted.
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
        // SAFETY: the caller's promise.
        let (simulation, outputs, steps) = unsafe {
            (
                &known(slime)?.simulation,
                [
                    optional_output("size", size)?,
                    optional_output("species", species)?,
                    optional_output("faces", faces)?,
                ],
                optional_output("steps", steps)?,
            )
        };
        let numbers =
            [simulation.texels().size(), simulation.species(), simulation.surface().len()];
        for (output, number) in outputs.into_iter().zip(numbers) {
            if let Some(output) = output {
                *output = number;
            }
        }
        if let Some(steps) = steps {
            *steps = simulation.state().step;
        }
        Ok(())
    })
}

/// The texture of a species, as it is now.
///
/// - `slime`: from cata_slime_new, not NULL.
/// - `species`: its number, from 0.
/// - `texture`: size x size elements, written: pheromone from 0 to 1, rows along u, the first at
///   v = 0.
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
        // SAFETY: the caller's promise.
        let simulation = unsafe { &known(slime)?.simulation };
        check_species(simulation, species)?;
        let own = simulation.texture(species);
        // SAFETY: the caller's promise.
        unsafe { slice_mut("texture", texture, own.len()) }?.copy_from_slice(own);
        Ok(())
    })
}

/// How much of the surface a species covers (thesis, equation 3.2).
///
/// - `slime`: from cata_slime_new, not NULL.
/// - `species`: its number, from 0.
/// - `coverage`: one element, written: the mean of the pheromone, from 0 to 1. NULL where not
///   wanted.
/// - `presence`: one element, written: the part of the surface that has any. NULL where not
///   wanted.
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
        // SAFETY: the caller's promise.
        let (slime, coverage, presence) = unsafe {
            (
                known(slime)?,
                optional_output("coverage", coverage)?,
                optional_output("presence", presence)?,
            )
        };
        check_species(&slime.simulation, species)?;
        let found = slime.simulation.coverage(slime.par)[species];
        if let Some(coverage) = coverage {
            *coverage = found.coverage;
        }
        if let Some(presence) = presence {
            *presence = found.presence;
        }
        Ok(())
    })
}

/// The texture coordinates of the corners of faces: those that were given, or those of the atlas.
///
/// - `slime`: from cata_slime_new, not NULL.
/// - `uv`: 6 elements a face, written: u, v of its three corners.
///
/// # Safety
/// The pointers are as described.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn cata_slime_uv(slime: *const cata_slime, uv: *mut f64) -> cata_status {
    boundary(|| {
        // SAFETY: the caller's promise.
        let own = unsafe { known(slime)? }.simulation.surface().uv().as_flattened().as_flattened();
        // SAFETY: the caller's promise.
        unsafe { slice_mut("uv", uv, own.len()) }?.copy_from_slice(own);
        Ok(())
    })
}

/// The handle, which must not be NULL.
///
/// # Safety
/// `slime` is NULL or from cata_slime_new, and not given back while the reference lives.
unsafe fn known<'a>(slime: *const cata_slime) -> Result<&'a cata_slime, Failure> {
    // SAFETY: the caller's promise.
    unsafe { slime.as_ref() }.ok_or_else(|| Failure::null("slime"))
}

fn check_species(simulation: &Simulation, species: usize) -> Result<(), Failure> {
    let count = simulation.species();
    if species < count {
        return Ok(());
    }
    let why = format!("species: {species} of {count} (numbered from 0)");
    Err(Failure::new(CATA_ERR_ARGUMENT, why))
}
