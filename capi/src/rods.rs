//! Rods: the positions of the segments of a plant.

use std::ffi::c_void;
use std::sync::Arc;

use super::boundary::boundary;
use super::outputs::{copy_wanted, fill_mesh};
use super::params::{Params, init, or_default, params, read_or_zeros};
use super::plant::{cata_plant, copy_rows, count_is, cycle, live_of};
use super::pointer::{
    check_size, free, hand_over, known, known_mut, optional_output, optional_slice,
    optional_slice_mut, output, put, slice,
};
use super::progress::{Caller, cata_progress};
use super::status::{CATA_ERR_ARGUMENT, Failure, cata_status};
use catamaran_simulation::plant::{
    Motion, MotionOptions, Plant, Pose, RelaxOptions, RodOptions, Rods, WiltOptions, tubes, wilt,
};

/// The constants of rods.
#[repr(C)]
#[derive(Debug, Clone, Copy)]
pub struct cata_plant_rods_params {
    /// sizeof(cata_plant_rods_params).
    pub struct_size: usize,
    /// Threads, at most; rods take one.
    pub threads: usize,
    /// Progress callback.
    pub progress: cata_progress,
    /// Passed to `progress`.
    pub progress_user: *mut c_void,
    /// In m / s^2; all 0: 0, 0, -9.81.
    pub gravity: [f64; 3],
    /// Poisson's ratio, above -1 and at most 0.5; 0: 0.3.
    pub poisson: f64,
    /// Mass of a cubic metre of tissue without its water, in kg; 0: 100.
    pub dry_density: f64,
    /// For cata_plant_rods_relax: torque out of balance / the largest of a weight; 0: 1e-8.
    pub tolerance: f64,
    /// Most iterations of cata_plant_rods_relax; 0: 200.
    pub iterations: usize,
    /// Seconds of a step of cata_plant_rods_step; 0: 1 / 60.
    pub step: f64,
    /// Iterations of cata_plant_rods_step; 0: 3.
    pub step_iterations: usize,
    /// The rate at which velocities decay, in 1 / s; 0: 1.
    pub damping: f64,
}

params!(cata_plant_rods_params, damping: f64);

/// A plant whose segments have weight and whose joints have stiffness, in a pose.
pub struct cata_plant_rods {
    graph: Arc<Plant>,
    rods: Rods,
    pose: Pose,
    /// The motion since the last step; `None` after the pose has been set.
    motion: Option<Motion>,
    tolerance: f64,
    iterations: usize,
    motion_options: MotionOptions,
    caller: Caller,
}

/// Fills a struct with the defaults.
///
/// # Safety
/// `params` points to `struct_size` writable bytes.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn cata_plant_rods_params_init(
    params: *mut cata_plant_rods_params,
    struct_size: usize,
) -> cata_status {
    // SAFETY: clause `structs` (`params`).
    unsafe { init(params, struct_size) }
}

/// Creates the rods of a plant with full cells, in the pose as given. They may outlive it.
///
/// # Safety
/// The pointers are as described.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn cata_plant_rods_new(
    plant: *const cata_plant,
    params: *const cata_plant_rods_params,
    rods: *mut *mut cata_plant_rods,
) -> cata_status {
    boundary(|| {
        // SAFETY: clause `memory` (`rods`, one value), clause `handles` (`plant`).
        let (plant, place) = unsafe { (known("plant", plant)?, output("rods", rods)?) };
        // SAFETY: clause `structs` (`params`).
        let params = unsafe { read_or_zeros("params", params) }?;
        let (default, rest) = (RodOptions::default(), RelaxOptions::default());
        let options = RodOptions::new()
            .gravity(or_default(params.gravity, default.gravity))
            .poisson(or_default(params.poisson, default.poisson))
            .dry_density(or_default(params.dry_density, default.dry_density));
        let moving = MotionOptions::default();
        let motion_options = MotionOptions::new()
            .step(or_default(params.step, moving.step))
            .iterations(or_default(params.step_iterations, moving.iterations))
            .damping(or_default(params.damping, moving.damping));
        let tolerance = or_default(params.tolerance, rest.tolerance);
        if !(1e-12..=1e-2).contains(&tolerance) {
            return Err(Failure::argument("params.tolerance", "from 1e-12 to 1e-2", tolerance));
        }
        let full = plant.model.full();
        let mut made = Rods::new(&plant.graph, &options)?;
        made.set_state(&plant.elasticity.moduli(&full, &full)?, &full)?;
        let pose = made.rest_pose();
        // The options are checked now, not by the first step.
        Motion::new(&made, &pose, &motion_options)?;
        let made = cata_plant_rods {
            graph: plant.graph.clone(),
            rods: made,
            pose,
            motion: None,
            tolerance,
            iterations: or_default(params.iterations, rest.max_iterations),
            motion_options,
            caller: params.caller(),
        };
        hand_over(place, made);
        Ok(())
    })
}

/// Frees rods.
///
/// # Safety
/// The pointer is as described.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn cata_plant_rods_free(rods: *mut cata_plant_rods) {
    // SAFETY: clause `handles` (`rods`).
    unsafe { free(rods) };
}

/// Sets the modulus of elasticity of every segment, in Pa, and its water, in kg, n elements
/// each. Pose and velocities stay.
///
/// # Safety
/// The pointers are as described.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn cata_plant_rods_set_state(
    rods: *mut cata_plant_rods,
    n: usize,
    moduli: *const f64,
    water: *const f64,
) -> cata_status {
    boundary(|| {
        // SAFETY: clause `memory` (`moduli`, `n` elements; `water`, `n` elements), clause `handles`
        // (`rods`).
        let (rods, moduli, water) = unsafe {
            (known_mut("rods", rods)?, slice("moduli", moduli, n)?, slice("water", water, n)?)
        };
        count_is(rods.rods.len(), n)?;
        let mut changed = rods.rods.clone();
        changed.set_state(moduli, water)?;
        if let Some(motion) = &mut rods.motion {
            motion.set_rods(&changed)?;
        }
        rods.rods = changed;
        Ok(())
    })
}

/// Sets the pose, at rest. `rotations`: 4 n elements: how each segment has turned since the
/// plant was given, a quaternion (w, x, y, z); NULL: not at all.
///
/// # Safety
/// The pointers are as described.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn cata_plant_rods_set_pose(
    rods: *mut cata_plant_rods,
    n: usize,
    rotations: *const f64,
) -> cata_status {
    boundary(|| {
        // SAFETY: clause `handles` (`rods`).
        let rods = unsafe { known_mut("rods", rods) }?;
        count_is(rods.rods.len(), n)?;
        // SAFETY: clause `memory` (`rotations`, `4 * n` elements).
        let rotations = unsafe { optional_slice("rotations", rotations.cast::<[f64; 4]>(), n) }?;
        let pose = match rotations {
            None => rods.rods.rest_pose(),
            Some(rotations) => rods.rods.pose(rotations)?,
        };
        (rods.pose, rods.motion) = (pose, None);
        Ok(())
    })
}

/// Gets the pose: `heads` and `tails`, 3 n elements each, where segments begin and end, and 4 n of
/// `rotations`, as in cata_plant_rods_set_pose; NULL where not wanted.
///
/// # Safety
/// The pointers are as described.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn cata_plant_rods_pose(
    rods: *const cata_plant_rods,
    n: usize,
    heads: *mut f64,
    tails: *mut f64,
    rotations: *mut f64,
) -> cata_status {
    boundary(|| {
        // SAFETY: clause `handles` (`rods`).
        let rods = unsafe { known("rods", rods) }?;
        count_is(rods.rods.len(), n)?;
        let pose = &rods.pose;
        // SAFETY: clause `memory` (`heads`, `3 * n` elements; `tails`, `3 * n` elements;
        // `rotations`, `4 * n` elements).
        unsafe {
            copy_wanted! {
                heads: pose.heads.as_flattened(),
                tails: pose.tails.as_flattened(),
                rotations: pose.rotations.as_flattened(),
            }
        }
        Ok(())
    })
}

/// Moves the pose to one near it in which stiffness and weight are in balance, at rest.
/// `iterations`, `residual`: written: those taken, and what is left, as `tolerance` measures it;
/// NULL where not wanted. After an error the pose is that of the last iteration.
///
/// # Safety
/// The pointers are as described.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn cata_plant_rods_relax(
    rods: *mut cata_plant_rods,
    iterations: *mut usize,
    residual: *mut f64,
) -> cata_status {
    boundary(|| {
        // SAFETY: clause `memory` (`iterations`, one value; `residual`, one value), clause
        // `handles` (`rods`).
        let (rods, iterations, residual) = unsafe {
            (
                known_mut("rods", rods)?,
                optional_output("iterations", iterations)?,
                optional_output("residual", residual)?,
            )
        };
        rods.motion = None;
        let options = RelaxOptions::new().tolerance(rods.tolerance).max_iterations(rods.iterations);
        let done = rods
            .caller
            .with(|progress| rods.rods.relax(&mut rods.pose, &options.progress(progress)))?;
        put(iterations, done.iterations);
        put(residual, done.residual);
        Ok(())
    })
}

/// Lets the plant move for `count` steps. `gap`: written: the largest between a segment and its
/// parent, in metres; NULL: not wanted. Steps before a cancelled one are done.
///
/// # Safety
/// The pointers are as described.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn cata_plant_rods_step(
    rods: *mut cata_plant_rods,
    count: usize,
    gap: *mut f64,
) -> cata_status {
    boundary(|| {
        // SAFETY: clause `memory` (`gap`, one value), clause `handles` (`rods`).
        let (handle, gap) = unsafe { (known_mut("rods", rods)?, optional_output("gap", gap)?) };
        let cata_plant_rods { rods, pose, motion, motion_options, caller, .. } = handle;
        let motion = match motion {
            Some(motion) => motion,
            none => none.insert(Motion::new(rods, pose, motion_options)?),
        };
        let done = caller.with(|progress| motion.run(count, progress));
        *pose = motion.pose();
        done?;
        put(gap, motion.largest_gap());
        Ok(())
    })
}

/// Gets the pose as a mesh of tubes of `sides` >= 3 sides and radii of at least `thinnest` metres.
/// Segment v has the vertices from 2 v `sides` on, and the faces. `vertices`, `faces`: 6 n `sides`
/// elements each, written; NULL where not wanted.
///
/// # Safety
/// The pointers are as described.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn cata_plant_rods_tubes(
    rods: *const cata_plant_rods,
    n: usize,
    sides: usize,
    thinnest: f64,
    vertices: *mut f64,
    faces: *mut u32,
) -> cata_status {
    boundary(|| {
        // SAFETY: clause `handles` (`rods`).
        let rods = unsafe { known("rods", rods) }?;
        count_is(rods.rods.len(), n)?;
        check_size::<[f64; 6]>("vertices", n, sides)?;
        let mesh = tubes(&rods.graph, &rods.pose, sides, thinnest)?;
        // SAFETY: clause `passed on` (`fill_mesh`).
        unsafe { fill_mesh(&mesh, vertices, faces) }
    })
}

/// Lets a plant wilt: from full cells on cata_plant_water_curve, and at each time the pose in
/// which it then rests.
///
/// - `rods`: of this plant, for their constants; NULL: the defaults.
/// - `water`, `moduli`, `tails`, `rotations`: n_times x n, n, 3 n and 4 n elements, written, as
///   in the calls above; NULL where not wanted.
///
/// # Safety
/// The pointers are as described.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn cata_plant_wilt(
    plant: *const cata_plant,
    rods: *const cata_plant_rods,
    n_times: usize,
    times: *const f64,
    n_intervals: usize,
    intervals: *const f64,
    n: usize,
    water: *mut f64,
    moduli: *mut f64,
    tails: *mut f64,
    rotations: *mut f64,
) -> cata_status {
    boundary(|| {
        check_size::<[f64; 4]>("rotations", n_times, n)?;
        let count = n_times * n;
        // SAFETY: clause `memory` (`times`, `n_times` elements), clause `handles` (`rods`), clause
        // `passed on` (`live_of`, `cycle`).
        let (plant, rods, times, cycle) = unsafe {
            (
                live_of(plant, n)?,
                rods.as_ref(),
                slice("times", times, n_times)?,
                cycle(n_intervals, intervals)?,
            )
        };
        // SAFETY: clause `memory` (`water`, `count` elements; `moduli`, `count` elements; `tails`,
        // `3 * count` elements; `rotations`, `4 * count` elements).
        let (water, moduli, tails, rotations) = unsafe {
            (
                optional_slice_mut("water", water, count)?,
                optional_slice_mut("moduli", moduli, count)?,
                optional_slice_mut("tails", tails, 3 * count)?,
                optional_slice_mut("rotations", rotations, 4 * count)?,
            )
        };
        let default;
        let rods = match rods {
            Some(rods) if rods.graph == plant.graph => &rods.rods,
            Some(_) => {
                return Err(Failure::new(CATA_ERR_ARGUMENT, "rods: belong to another plant"));
            }
            None => {
                default = Rods::new(&plant.graph, &RodOptions::default())?;
                &default
            }
        };
        let options = WiltOptions::new().elasticity(plant.elasticity).cycle(cycle).par(plant.par);
        let found = plant
            .caller
            .with(|progress| wilt(&plant.model, rods, times, &options.progress(progress)))?;
        copy_rows(found.water.iter().map(Vec::as_slice), water);
        copy_rows(found.moduli.iter().map(Vec::as_slice), moduli);
        let of_poses = found.poses.iter().map(|pose| pose.tails.as_flattened());
        copy_rows(of_poses, tails);
        let of_poses = found.poses.iter().map(|pose| pose.rotations.as_flattened());
        copy_rows(of_poses, rotations);
        Ok(())
    })
}
