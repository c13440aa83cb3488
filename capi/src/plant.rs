//! # Plants
//!
//! Plants that lose water and wilt (thesis, chapter 4): the water in their nodes, the stiffness
//! that follows from it, and the pose of rods with that stiffness and weight. SI units.
//!
//! ```c
//! cata_plant *plant;
//! if (cata_plant_grow(100, 1, NULL, &plant) == CATA_OK) {
//!     double day = 86400, water[100];
//!     if (cata_plant_water_curve(plant, 100, NULL, 1, &day, 0, NULL, water) == CATA_OK) {
//!         printf("%g kg in node 0 after a day\n", water[0]);
//!     }
//!     cata_plant_free(plant);
//! }
//! ```

use std::ffi::{c_char, c_void};
use std::sync::Arc;

use super::boundary::{boundary, path, utf8};
use super::outputs::{copy, copy_wanted, fill_slice};
use super::params::{Params, flag, init, or_default, params, read_or_zeros};
use super::pointer::{
    check_size, copied, free, hand_over, known, known_mut, optional_slice, optional_slice_mut,
    output, slice, slice_mut,
};
use super::progress::{Caller, cata_progress};
use super::status::{CATA_ERR_ARGUMENT, CATA_ERR_SHAPE, Failure, cata_status};
use catamaran::Par;
use catamaran_simulation::plant::families::{GrowthOptions, grow};
use catamaran_simulation::plant::{
    Bdf6, Conductivity, CurveOptions, Elasticity, Interval, Plant, ReadOptions, Segment,
    SpectralSolution, Start, WaterModel, WaterOptions, water_curve,
};

/// The parent of the root of a plant.
pub const CATA_NO_PARENT: u32 = u32::MAX;
/// A kind of segments: stem.
pub const CATA_PLANT_STEM: i32 = 0;
/// A kind of segments: a vein of a leaf, which loses water.
pub const CATA_PLANT_LEAF: i32 = 1;
/// Added to a kind: the segment is held where it is.
pub const CATA_PLANT_PINNED: i32 = 2;

/// The constants of the water and the stiffness of a plant.
#[repr(C)]
#[derive(Debug, Clone, Copy)]
pub struct cata_plant_params {
    /// sizeof(cata_plant_params).
    pub struct_size: usize,
    /// Threads, at most; 0: all.
    pub threads: usize,
    /// Progress callback.
    pub progress: cata_progress,
    /// Passed to `progress`.
    pub progress_user: *mut c_void,
    /// Loss of leaves, in kg / (s m^2); 60 g / (h m^2) is 1.667e-5.
    pub loss: f64,
    /// Water that the root takes from the soil, in kg / s.
    pub intake: f64,
    /// Conductance of a segment, as a part of that of a pipe as wide; 0: 1e-9.
    pub conductance: f64,
    /// Pressure in full cells, in Pa; 0: 1e6.
    pub modulus: f64,
    /// Viscosity of the sap, in Pa s; 0: 1e-3.
    pub viscosity: f64,
    /// Water in a cubic metre of full tissue, in kg; 0: 1000.
    pub density: f64,
    /// Modulus of elasticity of full cells, in Pa; 0: 5e7.
    pub elasticity_full: f64,
    /// Modulus of dry cells, in Pa (literal: must be 0); 0: 3e5.
    pub elasticity_dry: f64,
    /// Steepness of the curve (literal: in 1/g); 0: 10.
    pub elasticity_steepness: f64,
    /// Relative water content at the steepest point (literal: in grams, default 0); 0: 0.75.
    pub elasticity_shift: f64,
    /// 1: full / (1 + exp(-steepness (g - shift))), g grams of water (thesis, equation 4.9).
    pub elasticity_literal: i32,
}

params!(cata_plant_params, elasticity_shift: f64);

/// The water in a plant: its constants, the current state, and the data of the time steps.
pub struct cata_plant {
    pub(super) graph: Arc<Plant>,
    pub(super) model: WaterModel,
    pub(super) elasticity: Elasticity,
    pub(super) par: Par,
    pub(super) caller: Caller,
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
    // SAFETY: clause `structs` (`params`).
    unsafe { init(params, struct_size) }
}

/// Creates a plant of n >= 1 segments, each named after the node at its end.
///
/// - `tails`: 3 n elements: x, y, z of the end of each.
/// - `radii`: n elements, positive.
/// - `parents`: n elements: the segment at whose end each begins; CATA_NO_PARENT for the root.
/// - `kinds`: n elements: CATA_PLANT_STEM or CATA_PLANT_LEAF, each also + CATA_PLANT_PINNED.
/// - `base`: 3 elements: where the root begins; NULL: it is as long as its first child, and
///   goes straight on into it.
///
/// Returns CATA_ERR_MESH for a node without positive radius or length, or that is not on one
/// tree with one root.
///
/// # Safety
/// The pointers are as described.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn cata_plant_new(
    n: usize,
    tails: *const f64,
    radii: *const f64,
    parents: *const u32,
    kinds: *const i32,
    base: *const f64,
    params: *const cata_plant_params,
    plant: *mut *mut cata_plant,
) -> cata_status {
    boundary(|| {
        // SAFETY: clause `memory` (`tails`, `3 * n` elements; `radii`, `n` elements; `parents`, `n`
        // elements; `kinds`, `n` elements; `base`, `3` elements; `plant`, one value).
        let (tails, radii, parents, kinds, base, place) = unsafe {
            (
                slice("tails", tails.cast::<[f64; 3]>(), n)?,
                slice("radii", radii, n)?,
                slice("parents", parents, n)?,
                slice("kinds", kinds, n)?,
                optional_slice("base", base.cast::<[f64; 3]>(), 1)?,
                output("plant", plant)?,
            )
        };
        let known = CATA_PLANT_LEAF | CATA_PLANT_PINNED;
        if let Some(v) = kinds.iter().position(|kind| kind & !known != 0) {
            let why = format!("kinds: {} of node {v} is no CATA_PLANT_* value", kinds[v]);
            return Err(Failure::new(CATA_ERR_ARGUMENT, why));
        }
        let segment = |v: usize| Segment {
            leaf: kinds[v] & CATA_PLANT_LEAF != 0,
            pinned: kinds[v] & CATA_PLANT_PINNED != 0,
            ..Segment::stem(tails[v], radii[v])
        };
        let segments = (0..n).map(segment).collect();
        let parents: Vec<Option<u32>> =
            parents.iter().map(|&p| (p != CATA_NO_PARENT).then_some(p)).collect();
        let graph = Plant::new(segments, &parents, base.map(|base| base[0]))?;
        // SAFETY: clause `passed on` (`model`).
        hand_over(place, unsafe { model(graph, params) }?);
        Ok(())
    })
}

/// Reads the plant in a file: .txt (the reference format: `verts N`, ...), .swc, .mtg or .obj
/// (polylines), each also as .gz, .xz or .bz2. `path` is in UTF-8.
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
        // SAFETY: clause `memory` (`plant`, one value), clause `texts` (`path`).
        let (path, place) = unsafe { (self::path("path", path)?, output("plant", plant)?) };
        let graph = catamaran_simulation::plant::read(&path)?;
        // SAFETY: clause `passed on` (`model`).
        hand_over(place, unsafe { model(graph, params) }?);
        Ok(())
    })
}

/// Reads the plant in a file as cata_plant_read does, in the units of the file.
///
/// - `unit`: 2 numbers: metres in a unit of lengths, and in one of radii; NULL: 1 and 1.
/// - `individual`: the name of one of several plants in an .mtg file, such as P3, in UTF-8;
///   NULL or an empty text: the file has one plant. The error without a name lists the names.
///
/// # Safety
/// The pointers are as described.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn cata_plant_read_with(
    path: *const c_char,
    unit: *const f64,
    individual: *const c_char,
    params: *const cata_plant_params,
    plant: *mut *mut cata_plant,
) -> cata_status {
    boundary(|| {
        // SAFETY: clause `memory` (`unit`, `2` elements; `plant`, one value), clause `texts`
        // (`path`, `individual`).
        let (path, unit, individual, place) = unsafe {
            (
                self::path("path", path)?,
                optional_slice("unit", unit.cast::<[f64; 2]>(), 1)?,
                (!individual.is_null()).then(|| utf8("individual", individual)).transpose()?,
                output("plant", plant)?,
            )
        };
        let mut options = ReadOptions::new()
            .individual(individual.as_deref().filter(|individual| !individual.is_empty()));
        if let Some(&[unit]) = unit {
            options = options.unit(unit);
        }
        let graph = catamaran_simulation::plant::read_with(&path, &options)?;
        // SAFETY: clause `passed on` (`model`).
        hand_over(place, unsafe { model(graph, params) }?);
        Ok(())
    })
}

/// Grows a random plant of n >= 1 nodes, the same for the same seed.
///
/// # Safety
/// The pointers are as described.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn cata_plant_grow(
    n: usize,
    seed: u64,
    params: *const cata_plant_params,
    plant: *mut *mut cata_plant,
) -> cata_status {
    boundary(|| {
        // SAFETY: clause `memory` (`plant`, one value).
        let place = unsafe { output("plant", plant) }?;
        let graph = grow(&GrowthOptions::new().nodes(n).seed(seed))?;
        // SAFETY: clause `passed on` (`model`).
        hand_over(place, unsafe { model(graph, params) }?);
        Ok(())
    })
}

/// Frees a plant.
///
/// # Safety
/// The pointer is as described.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn cata_plant_free(plant: *mut cata_plant) {
    // SAFETY: clause `handles` (`plant`).
    unsafe { free(plant) };
}

/// Returns the number of nodes of a plant, n in all calls below; 0 for NULL.
///
/// # Safety
/// The pointer is NULL or a live plant.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn cata_plant_size(plant: *const cata_plant) -> usize {
    // SAFETY: clause `handles` (`plant`); NULL gives 0.
    unsafe { plant.as_ref() }.map_or(0, |plant| plant.model.len())
}

/// Gets the segments of a plant, as cata_plant_new takes them; NULL for what is not wanted.
///
/// # Safety
/// The pointers are as described.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn cata_plant_segments(
    plant: *const cata_plant,
    n: usize,
    tails: *mut f64,
    radii: *mut f64,
    parents: *mut u32,
    kinds: *mut i32,
    base: *mut f64,
) -> cata_status {
    boundary(|| {
        // SAFETY: clause `passed on` (`live_of`).
        let graph = unsafe { live_of(plant, n)? }.graph.as_ref();
        let parent = |v| graph.parent(v).map_or(CATA_NO_PARENT, |p| p as u32);
        let kind = |segment: &Segment| {
            i32::from(segment.leaf) * CATA_PLANT_LEAF
                + i32::from(segment.pinned) * CATA_PLANT_PINNED
        };
        let segments = graph.segments();
        let ends: Vec<[f64; 3]> = segments.iter().map(|segment| segment.tail).collect();
        let widths: Vec<f64> = segments.iter().map(|segment| segment.radius).collect();
        let before: Vec<u32> = (0..n).map(parent).collect();
        let of_segments: Vec<i32> = segments.iter().map(kind).collect();
        let origin = graph.base();
        // SAFETY: clause `memory` (`tails`, `3 * n` elements; `radii`, `n` elements; `parents`, `n`
        // elements; `kinds`, `n` elements; `base`, `3` elements).
        unsafe {
            copy_wanted! {
                tails: ends.as_flattened(),
                radii: &widths,
                parents: &before,
                kinds: &of_segments,
                base: &origin,
            }
        }
        Ok(())
    })
}

/// Gets the water of every node when its cells are full, in kg: the state of a healthy plant.
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
        // SAFETY: clause `memory` (`water`, `n` elements), clause `passed on` (`live_of`).
        unsafe { copy("water", water, &live_of(plant, n)?.model.full()) }
    })
}

/// Sets the loss of all leaves, in kg / (s m^2), from now on.
///
/// # Safety
/// `plant` is a live plant.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn cata_plant_set_loss(plant: *mut cata_plant, loss: f64) -> cata_status {
    // SAFETY: clause `passed on` (`change`).
    unsafe { change(plant, |model| model.set_loss(loss)) }
}

/// Sets the water that the root takes from the soil, in kg / s, from now on.
///
/// # Safety
/// `plant` is a live plant.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn cata_plant_set_intake(plant: *mut cata_plant, intake: f64) -> cata_status {
    // SAFETY: clause `passed on` (`change`).
    unsafe { change(plant, |model| model.set_intake(intake)) }
}

/// Multiplies the conductance between a node, not the root, and its parent by `factor`, from
/// now on; 0 cuts the connection.
///
/// # Safety
/// `plant` is a live plant.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn cata_plant_weaken(
    plant: *mut cata_plant,
    node: usize,
    factor: f64,
) -> cata_status {
    // SAFETY: clause `passed on` (`change`).
    unsafe { change(plant, |model| model.weaken(node, factor)) }
}

/// Computes the rates at which the modes of the water decay, n elements, ascending, in 1 / s.
/// Dense, of order n^3: for small plants.
///
/// # Safety
/// The pointers are as described.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn cata_plant_rates(
    plant: *const cata_plant,
    n: usize,
    rates: *mut f64,
) -> cata_status {
    boundary(|| {
        // SAFETY: clause `memory` (`rates`, `n` elements), clause `passed on` (`live_of`).
        let (plant, rates) = unsafe { (live_of(plant, n)?, slice_mut("rates", rates, n)?) };
        rates.copy_from_slice(SpectralSolution::new(&plant.model)?.rates());
        Ok(())
    })
}

/// Computes the water of every node `seconds` after it was `water`, without time steps. `water`,
/// `result` (written): n elements in kg each, which may be the same.
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
        // SAFETY: clause `memory` (`water`, `n` elements), clause `passed on` (`live_of`).
        let (plant, water) = unsafe { (live_of(plant, n)?, copied("water", water, n)?) };
        // SAFETY: clause `memory` (`result`, `n` elements).
        let result = unsafe { slice_mut("result", result, n) }?;
        let after = plant
            .caller
            .with(|progress| plant.model.water_after_with(&water, seconds, plant.par, progress))?;
        result.copy_from_slice(&after);
        Ok(())
    })
}

/// Computes the water of every node at many times.
///
/// - `water`: n elements: in kg, at time 0; NULL: full cells.
/// - `times`: n_times elements: seconds from 0, ascending.
/// - `intervals`: 2 n_intervals elements: seconds and loss of each part of a day, again and
///   again from time 0 on. Without any the loss is that of the plant.
/// - `result`: n_times x n elements, written: in kg.
///
/// # Safety
/// The pointers are as described.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn cata_plant_water_curve(
    plant: *const cata_plant,
    n: usize,
    water: *const f64,
    n_times: usize,
    times: *const f64,
    n_intervals: usize,
    intervals: *const f64,
    result: *mut f64,
) -> cata_status {
    boundary(|| {
        check_size::<f64>("result", n_times, n)?;
        // SAFETY: clause `memory` (`times`, `n_times` elements; `result`, `n_times * n` elements),
        // clause `passed on` (`live_of`, `cycle`).
        let (plant, times, cycle, result) = unsafe {
            (
                live_of(plant, n)?,
                slice("times", times, n_times)?,
                cycle(n_intervals, intervals)?,
                slice_mut("result", result, n_times * n)?,
            )
        };
        // SAFETY: clause `passed on` (`water_or_full`).
        let water = unsafe { water_or_full(plant, water) }?;
        let options = CurveOptions::new().cycle(cycle).par(plant.par);
        let found = plant.caller.with(|progress| {
            water_curve(&plant.model, &water, times, &options.progress(progress))
        })?;
        copy_rows(found.iter().map(Vec::as_slice), Some(result));
        Ok(())
    })
}

/// Makes `water`, n elements in kg, the current state, from which cata_plant_step continues in
/// steps of `step` seconds; NULL: full cells.
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
        // SAFETY: clause `handles` (`plant`).
        let plant = unsafe { known_mut("plant", plant) }?;
        count_is(plant.model.len(), n)?;
        // SAFETY: clause `passed on` (`water_or_full`).
        let water = unsafe { water_or_full(plant, water) }?;
        plant.stepper = Some(Bdf6::new(&plant.model, &water, step, Start::Radau, plant.par)?);
        plant.changed = false;
        Ok(())
    })
}

/// Computes `count` steps; changes since the last step apply from now on. `water`: n elements,
/// written: in kg; NULL: not wanted. Steps before a cancelled one are done.
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
        // SAFETY: clause `memory` (`water`, `n` elements), clause `handles` (`plant`).
        let (plant, water) =
            unsafe { (known_mut("plant", plant)?, optional_slice_mut("water", water, n)?) };
        if water.is_some() {
            count_is(plant.model.len(), n)?;
        }
        let cata_plant { model, stepper, changed, caller, .. } = plant;
        let not_started =
            || Failure::new(CATA_ERR_ARGUMENT, "plant: cata_plant_start has not been called");
        let stepper = stepper.as_mut().ok_or_else(not_started)?;
        if *changed {
            stepper.restart(model, stepper.step_length())?;
            *changed = false;
        }
        caller.with(|progress| stepper.run(count, progress))?;
        fill_slice(water, &stepper.water());
        Ok(())
    })
}

/// Computes the modulus of elasticity of every segment, in Pa, from its water, in kg: a logistic
/// curve from `elasticity_dry` to `elasticity_full`.
///
/// # Safety
/// The pointers are as described.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn cata_plant_stiffness(
    plant: *const cata_plant,
    n: usize,
    water: *const f64,
    moduli: *mut f64,
) -> cata_status {
    boundary(|| {
        // SAFETY: clause `memory` (`water`, `n` elements; `moduli`, `n` elements), clause `passed
        // on` (`live_of`).
        let (plant, water, moduli) = unsafe {
            (live_of(plant, n)?, slice("water", water, n)?, slice_mut("moduli", moduli, n)?)
        };
        moduli.copy_from_slice(&plant.elasticity.moduli(water, &plant.model.full())?);
        Ok(())
    })
}

/// Returns the model of a plant.
///
/// # Safety
/// `params` is NULL or points to a struct as the header describes it.
unsafe fn model(graph: Plant, params: *const cata_plant_params) -> Result<cata_plant, Failure> {
    // SAFETY: clause `structs` (`params`).
    let params = unsafe { read_or_zeros("params", params) }?;
    let default = WaterOptions::default();
    let mut options = WaterOptions::new()
        .loss(params.loss)
        .intake(params.intake)
        .modulus(or_default(params.modulus, default.modulus))
        .viscosity(or_default(params.viscosity, default.viscosity))
        .density(or_default(params.density, default.density));
    if params.conductance != 0.0 {
        options.conductivity = Conductivity::Pipe { scale: params.conductance };
    }
    let elasticity = elasticity(&params)?;
    // The constants are checked even without water to use them on.
    elasticity.moduli(&[1.0], &[1.0])?;
    let model = WaterModel::new(&graph, &options)?;
    Ok(cata_plant {
        graph: Arc::new(graph),
        model,
        elasticity,
        par: params.par(),
        caller: params.caller(),
        stepper: None,
        changed: false,
    })
}

/// Returns the law from water to stiffness.
fn elasticity(params: &cata_plant_params) -> Result<Elasticity, Failure> {
    let mut elasticity = match flag("params.elasticity_literal", params.elasticity_literal)? {
        true => Elasticity::Literal { full: 5e7, steepness: 10.0, shift: 0.0 },
        false => Elasticity::default(),
    };
    match &mut elasticity {
        Elasticity::Relative { dry, .. } => *dry = or_default(params.elasticity_dry, *dry),
        Elasticity::Literal { .. } if params.elasticity_dry != 0.0 => {
            let zero = "0 with params.elasticity_literal";
            return Err(Failure::argument("params.elasticity_dry", zero, params.elasticity_dry));
        }
        Elasticity::Literal { .. } => {}
    }
    let (Elasticity::Relative { full, steepness, shift, .. }
    | Elasticity::Literal { full, steepness, shift }) = &mut elasticity;
    *full = or_default(params.elasticity_full, *full);
    *steepness = or_default(params.elasticity_steepness, *steepness);
    *shift = or_default(params.elasticity_shift, *shift);
    Ok(elasticity)
}

/// Changes a model.
///
/// # Safety
/// `plant` is NULL or a live plant that no other thread uses.
unsafe fn change(
    plant: *mut cata_plant,
    work: impl FnOnce(&mut WaterModel) -> catamaran::Result<()>,
) -> cata_status {
    boundary(|| {
        // SAFETY: clause `handles` (`plant`).
        let plant = unsafe { known_mut("plant", plant) }?;
        work(&mut plant.model)?;
        plant.changed = true;
        Ok(())
    })
}

/// Returns a live plant of n nodes.
///
/// # Safety
/// As [`known`].
pub(super) unsafe fn live_of<'a>(
    plant: *const cata_plant,
    n: usize,
) -> Result<&'a cata_plant, Failure> {
    // SAFETY: clause `handles` (`plant`).
    let plant = unsafe { known("plant", plant) }?;
    count_is(plant.model.len(), n)?;
    Ok(plant)
}

/// Checks that the caller has room for as many numbers as there are nodes.
pub(super) fn count_is(nodes: usize, n: usize) -> Result<(), Failure> {
    if n == nodes {
        return Ok(());
    }
    let why = format!("n: must be {nodes} (nodes of the plant), is {n}");
    Err(Failure::new(CATA_ERR_SHAPE, why))
}

/// Returns the water of all nodes, or that of full cells.
///
/// # Safety
/// `water` is NULL or has as many elements as the plant has nodes.
unsafe fn water_or_full(plant: &cata_plant, water: *const f64) -> Result<Vec<f64>, Failure> {
    // SAFETY: clause `memory` (`water`, `plant.model.len()` elements).
    let water = unsafe { optional_slice("water", water, plant.model.len()) }?;
    Ok(water.map_or_else(|| plant.model.full(), <[f64]>::to_vec))
}

/// Returns losses that follow each other.
///
/// # Safety
/// `intervals` has 2 `count` elements.
pub(super) unsafe fn cycle(count: usize, intervals: *const f64) -> Result<Vec<Interval>, Failure> {
    // SAFETY: clause `memory` (`intervals`, `2 * count` elements).
    let numbers = unsafe { slice("intervals", intervals.cast::<[f64; 2]>(), count) }?;
    Ok(numbers.iter().map(|&[seconds, loss]| Interval { seconds, loss }).collect())
}

/// Copies rows, one after the other, where they are wanted.
pub(super) fn copy_rows<'a>(rows: impl Iterator<Item = &'a [f64]>, place: Option<&mut [f64]>) {
    let Some(mut rest) = place else { return };
    for row in rows {
        let (place, after) = rest.split_at_mut(row.len());
        place.copy_from_slice(row);
        rest = after;
    }
}
