//! Parameter structs of meshes, plants and textures, on small inputs: a handle, or an error that
//! names the field; and the check of products.

use std::ptr;

use catamaran_capi::*;

use super::buffers::Matrix;
use super::choices::Choices;
use super::entries::{Entries, Real};
use super::params::{Params, field};
use super::refusal::{check_accepted, check_refused, message};

/// An octahedron.
const VERTICES: [f64; 18] =
    [1., 0., 0., 0., 1., 0., -1., 0., 0., 0., -1., 0., 0., 0., 1., 0., 0., -1.];
const FACES: [u32; 24] = [0, 1, 4, 1, 2, 4, 2, 3, 4, 3, 0, 4, 1, 0, 5, 2, 1, 5, 3, 2, 5, 0, 3, 5];
const NAN: f64 = f64::NAN;

/// Makes a call of one of the functions.
pub fn call(choices: &mut Choices<'_>) {
    match choices.below(10) {
        0 => decimation(choices),
        1 => curve(choices),
        2 => plant(choices),
        3 => newton(choices),
        4 => slime(choices),
        5 => mesh_eigenpairs(choices),
        6 => repair(choices),
        7 => heat(choices),
        8 => verification::<f32>(choices),
        _ => verification::<f64>(choices),
    }
}

/// Checks a call that makes a handle, and frees it.
fn made<P: Copy, H>(
    what: &str,
    params: &Params<P>,
    make: impl FnOnce(*const P, *mut *mut H) -> cata_status,
    free: unsafe extern "C" fn(*mut H),
) {
    let mut handle = ptr::null_mut();
    let status = make(params.pointer(), &mut handle);
    if params.refused.is_empty() {
        check_accepted(what, status);
        assert!(!handle.is_null(), "{what}: no handle");
    } else {
        let said = message();
        let named = params.refused.iter().any(|name| said.contains(name.trim_end_matches(": ")));
        let right = status != CATA_OK && status != CATA_ERR_PANIC && named && handle.is_null();
        assert!(right, "{what}: {status}, {said} instead of {:?}", params.refused);
    }
    // SAFETY: NULL or alive, and freed once.
    unsafe { free(handle) };
}

fn decimation(choices: &mut Choices<'_>) {
    let mut refused = None;
    let r = &mut refused;
    let flags = [2, -1];
    let value = cata_decimation_params {
        struct_size: 0,
        threads: choices.pick(&[1, 0, 3]),
        progress: None,
        progress_user: ptr::null_mut(),
        method: field(choices, "method", &[0, 0, 1], &[2, -1], r),
        lloyd: field(choices, "lloyd", &[0, 2, CATA_NO_PASSES], &[-2, i32::MIN], r),
        relaxation: field(choices, "relaxation", &[0, 2, CATA_NO_PASSES], &[-2], r),
        first: choices.pick(&[0, 5]),
        has_first: field(choices, "has_first", &[0, 1], &flags, r),
        cut_narrow_handles: field(choices, "cut_narrow_handles", &[0, 1], &flags, r),
        keep_edges: field(choices, "keep_edges", &[0, 0, 1], &flags, r),
        locked: ptr::null(),
        n_locked: 0,
        uniform: field(choices, "uniform", &[0, 1], &flags, r),
        density: ptr::null(),
        n_density: 0,
        curvature: field(choices, "curvature", &[0.0, 1.0, 9.0], &[0.5, NAN], r),
    };
    let n = if value.keep_edges == 1 || value.method == 1 { 6 } else { choices.pick(&[6, 5, 20]) };
    let params = Params::new(choices, value, refused);
    let make = |params: *const _, place: *mut *mut _| {
        // SAFETY: the arrays of the mesh, a live struct and a place.
        unsafe { cata_decimation_new(6, VERTICES.as_ptr(), 8, FACES.as_ptr(), n, params, place) }
    };
    if value.method == 1 && refused.is_none() {
        return; // the thesis's algorithm may have to give up on so small a mesh
    }
    made(&format!("decimation {n}, {value:?}"), &params, make, cata_decimation_free);
}

fn curve(choices: &mut Choices<'_>) {
    let mut refused = None;
    let r = &mut refused;
    let flags = [2, -1];
    let faithful = field(choices, "faithful", &[0, 1], &flags, r);
    let drop_outliers: &[i32] = if faithful == 0 { &[0, 1] } else { &[0] };
    let value = cata_curve_params {
        struct_size: 0,
        threads: 0,
        progress: None,
        progress_user: ptr::null_mut(),
        candidates: choices.pick(&[0, 3]),
        start: 0,
        faithful,
        open: field(choices, "open", &[0, 1], &flags, r),
        single: field(choices, "single", &[0, 1], &flags, r),
        points: field(choices, "points", &[0, 1], &flags, r),
        smooth: field(choices, "smooth", &[0, 1], &flags, r),
        reserved: 0,
        drop_outliers: field(choices, "drop_outliers", drop_outliers, &flags, r),
    };
    let params = Params::new(choices, value, refused);
    let mut solver = ptr::null_mut();
    let samples = [0_u32, 2, 1, 3];
    // SAFETY: the arrays of the mesh and a place.
    let status =
        unsafe { cata_curve_solver_new(6, VERTICES.as_ptr(), 8, FACES.as_ptr(), &mut solver) };
    check_accepted("curve_solver", status);
    let make = |params: *const _, place: *mut *mut _| {
        // SAFETY: a live solver and struct, the samples and a place.
        unsafe { cata_curve_solver_find(solver, 4, samples.as_ptr(), params, place) }
    };
    made(&format!("curve {value:?}"), &params, make, cata_curves_free);
    // SAFETY: alive, and freed once.
    unsafe { cata_curve_solver_free(solver) };
}

fn repair(choices: &mut Choices<'_>) {
    let mut refused = None;
    let r = &mut refused;
    let flags = [2, -1];
    let value = cata_repair_params {
        struct_size: 0,
        threads: 0,
        progress: None,
        progress_user: ptr::null_mut(),
        tolerance: choices.pick(&[0.0, 1e-3]),
        keep_largest: choices.pick(&[0, 1]),
        drop_specks: field(choices, "drop_specks", &[0.0, 0.5], &[-0.5, 1.5, NAN], r),
        fill_holes: choices.pick(&[0, 10]),
        everything: field(choices, "everything", &[0, 1], &flags, r),
        weld: field(choices, "weld", &[0, 1, 2, 3], &[4, -1], r),
        drop_duplicates: field(choices, "drop_duplicates", &[0, 1], &flags, r),
        drop_degenerate: field(choices, "drop_degenerate", &[0, 1], &flags, r),
        compact: field(choices, "compact", &[0, 1], &flags, r),
        cut: field(choices, "cut", &[0, 1], &flags, r),
        orient: field(choices, "orient", &[0, 1], &flags, r),
    };
    let params = Params::new(choices, value, refused);
    let mut file = ptr::null_mut();
    // SAFETY: the arrays of the mesh and a place.
    let status = unsafe { cata_mesh_file_new(6, VERTICES.as_ptr(), 8, FACES.as_ptr(), &mut file) };
    check_accepted("mesh_file", status);
    let make = |params: *const _, place: *mut *mut _| {
        // SAFETY: a live mesh and struct, and a place.
        unsafe { cata_repair_new(file, params, place) }
    };
    made(&format!("repair {value:?}"), &params, make, cata_repair_free);
    // SAFETY: alive, and freed once.
    unsafe { cata_mesh_file_free(file) };
}

fn heat(choices: &mut Choices<'_>) {
    let mut refused = None;
    let r = &mut refused;
    let value = cata_distance_params {
        struct_size: 0,
        threads: choices.pick(&[1, 0, 3]),
        progress: None,
        progress_user: ptr::null_mut(),
        time: field(choices, "time", &[0.0, 2.0], &[-1.0, NAN, f64::INFINITY], r),
        cutoff: 0.0,
        flow: field(choices, "flow", &[0, 1, 2], &[3, -1], r),
    };
    let params = Params::new(choices, value, refused);
    let make = |params: *const _, place: *mut *mut _| {
        // SAFETY: the arrays of the mesh, a live struct and a place.
        unsafe { cata_heat_new(6, VERTICES.as_ptr(), 8, FACES.as_ptr(), params, place) }
    };
    made(&format!("heat {value:?}"), &params, make, cata_heat_free);
}

fn plant(choices: &mut Choices<'_>) {
    let mut refused = None;
    let r = &mut refused;
    let bad = [-1.0, NAN, f64::INFINITY];
    let value = cata_plant_params {
        struct_size: 0,
        threads: choices.pick(&[1, 0]),
        progress: None,
        progress_user: ptr::null_mut(),
        loss: field(choices, "loss", &[0.0, 1.667e-5], &bad[1..], r),
        intake: field(choices, "intake", &[0.0, 1e-9], &bad[1..], r),
        conductance: field(choices, "conduct", &[0.0, 1e-9], &bad, r),
        modulus: field(choices, "modulus", &[0.0, 1e5], &bad, r),
        viscosity: field(choices, "viscosity", &[0.0, 1e-2], &bad, r),
        density: field(choices, "density", &[0.0, 900.0], &bad, r),
        elasticity_full: field(choices, "full", &[0.0, 4e7], &bad, r),
        elasticity_dry: field(choices, "dry", &[0.0, 1e5], &bad, r),
        elasticity_steepness: field(choices, "steepness", &[0.0, 5.0], &bad, r),
        elasticity_shift: field(choices, "shift", &[0.0, 0.5], &[NAN, f64::INFINITY], r),
        elasticity_literal: field(choices, "elasticity_literal", &[0], &[2, -1], r),
    };
    let params = Params::new(choices, value, refused);
    let seed = choices.below(256) as u64;
    let make = |params: *const _, place: *mut *mut _| {
        // SAFETY: a live struct and a place.
        unsafe { cata_plant_grow(5, seed, params, place) }
    };
    made(&format!("plant {value:?}"), &params, make, cata_plant_free);
}

fn newton(choices: &mut Choices<'_>) {
    let mut refused = None;
    let r = &mut refused;
    let bad = [NAN, f64::INFINITY];
    let value = cata_newton_params {
        struct_size: 0,
        threads: choices.pick(&[1, 0]),
        progress: None,
        progress_user: ptr::null_mut(),
        root_count: 0,
        roots: ptr::null(),
        device: ptr::null(),
        scale: field(choices, "scale", &[0.0, 2.0], &bad, r),
        theta: field(choices, "theta", &[0.0, -10.0, 20.0], &[-11.0, 21.0, NAN], r),
        w: field(choices, "w", &[0.0, 1.0], &bad, r),
        offset: [0.0, field(choices, "offset", &[0.0, 1.0], &bad, r), 0.0],
        power: field(choices, "power", &[0, 2, 64], &[1, 65, u32::MAX], r),
        iterations: field(choices, "iterations", &[0, 1, 1000], &[1001, u32::MAX], r),
        gradient: field(choices, "gradient", &[0, 1], &[2, -1], r),
    };
    let params = Params::new(choices, value, refused);
    let make = |params: *const _, place: *mut *mut _| {
        // SAFETY: a live struct and a place.
        unsafe { cata_newton_new(params, place) }
    };
    made(&format!("newton {value:?}"), &params, make, cata_newton_free);
}

fn slime(choices: &mut Choices<'_>) {
    let mut refused = None;
    let r = &mut refused;
    let bad = [-1.0, NAN, f64::INFINITY];
    let value = cata_slime_params {
        struct_size: 0,
        threads: choices.pick(&[1, 0]),
        progress: None,
        progress_user: ptr::null_mut(),
        agents: 10,
        species: field(choices, "species", &[0, 1, 2], &[16, usize::MAX], r),
        size: field(choices, "size", &[32, 64], &[33, 16416, usize::MAX], r),
        device: ptr::null(),
        seed: 1,
        substeps: choices.pick(&[0, 3]),
        time_step: field(choices, "time_step", &[0.0, 0.1], &bad, r),
        movement_speed: field(choices, "movement_speed", &[0.0, 2.0], &bad, r),
        turn_speed: field(choices, "turn_speed", &[0.0, 100.0], &bad, r),
        vision_distance: field(choices, "vision_distance", &[0.0, 2.0], &bad, r),
        vision_angle: field(choices, "vision_angle", &[0.0, 50.0], &bad, r),
        evaporation_rate: field(choices, "evaporation_rate", &[0.0, 1.0], &bad, r),
        diffusion_rate: field(choices, "diffusion_rate", &[0.0, 3.0], &bad, r),
        turns: field(choices, "turns", &[0, 1], &[99, -1], r),
        blur: field(choices, "blur", &[0, 1], &[99, -1], r),
        lengths: field(choices, "lengths", &[0, 1], &[99, -1], r),
    };
    let params = Params::new(choices, value, refused);
    let make = |params: *const _, place: *mut *mut _| {
        let (null, none) = (ptr::null(), ptr::null());
        // SAFETY: the arrays of the mesh, a live struct and a place.
        unsafe {
            cata_slime_new(6, VERTICES.as_ptr(), 8, FACES.as_ptr(), null, none, none, params, place)
        }
    };
    made(&format!("slime {value:?}"), &params, make, cata_slime_free);
}

fn mesh_eigenpairs(choices: &mut Choices<'_>) {
    let mut vertices = VERTICES;
    let mut faces = FACES;
    let broken = choices.below(8);
    match broken {
        5 => vertices[choices.below(18)] = NAN,
        6 => faces[choices.below(24)] = choices.pick(&[6, u32::MAX]),
        _ => {}
    }
    let k = choices.below(8);
    let mut values = Matrix::<f64>::output(choices, k);
    let mut vectors = Matrix::<f64>::new(choices, CATA_COL_MAJOR, (6, k), 1, |_, _| NAN);
    let mut masses = Matrix::<f64>::output(choices, 6);
    let what = format!("mesh_eigs {k}, {broken}");
    // SAFETY: the arrays of the mesh, and places for the results.
    let status = unsafe {
        let (pv, pf) = (vertices.as_ptr(), faces.as_ptr());
        let (values, place) = (values.pointer_mut(), vectors.pointer_mut());
        let (none, masses) = (ptr::null_mut(), masses.pointer_mut());
        cata_mesh_eigs(6, pv, 8, pf, k, values, place, vectors.ld, none, masses, ptr::null())
    };
    if k > 6 || (5..7).contains(&broken) {
        [&values, &vectors, &masses].iter().for_each(|x| x.check_untouched(&what));
        let names = ["k", "vert", "face", "options.k"];
        return check_refused(&what, status, &names);
    }
    check_accepted(&what, status);
    vectors.check_changes(&what, |_, _| true);
    for (i, expected) in [0.0, 2.0, 2.0, 2.0, 3.0, 3.0].into_iter().enumerate().take(k) {
        let got = values.get(0, i);
        assert!((got - expected).abs() <= 1e-8, "{what}: {i} is {got}, not {expected}");
    }
}

fn verification<T: Real>(choices: &mut Choices<'_>) {
    let layout = choices.pick(&[CATA_ROW_MAJOR, CATA_COL_MAJOR]);
    let uplo = choices.pick(&[CATA_BOTH, CATA_LOWER, CATA_UPPER]);
    let (m, n) = (choices.side(), choices.side());
    let mut entries = Entries::finite(choices);
    let a = Matrix::<T>::new(choices, layout, (m, n), 1, |i, j| entries.next(i, j));
    let mut c = Matrix::<T>::new(choices, layout, (n, n), 1, |_, _| T::of(0.0));
    let (alpha, zero) = (T::of(1.5), T::of(0.0));
    // SAFETY: the matrices own their memory, which has the sides and leading dimensions passed.
    let status = unsafe {
        let (pa, pc) = (a.pointer(), c.pointer_mut());
        T::ATA(layout, uplo, m, n, alpha, pa, a.ld, zero, pc, c.ld, ptr::null())
    };
    check_accepted("verify", status);
    c.accept();
    // With many more, a sum of equal rounding errors exceeds the tolerance.
    let rounds = choices.pick(&[20, 20, 1, 5, 0, -1, 1001]);
    let (mut passed, mut residual, mut tolerance) = (-1, NAN, NAN);
    let what = format!("verify {m} x {n}, {uplo}, {rounds}");
    // SAFETY: the memory of the matrices, and places.
    let status = unsafe {
        let (pa, pc, pp) = (a.pointer(), c.pointer(), &mut passed);
        let (pr, pt) = (&mut residual, &mut tolerance);
        T::VERIFY(layout, uplo, m, n, 1.5, pa, a.ld, pc, c.ld, rounds, 7, pp, pr, pt)
    };
    a.check_untouched(&what);
    c.check_untouched(&what);
    if !(1..=1000).contains(&rounds) {
        assert!(passed == -1 && residual.is_nan() && tolerance.is_nan(), "{what}: written");
        return check_refused(&what, status, &["rounds"]);
    }
    check_accepted(&what, status);
    assert!(passed == 1 && residual <= tolerance, "{what}: {passed}, {residual}, {tolerance}");
}
