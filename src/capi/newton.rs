//! # Newton fractals
//!
//! Bicomplex fractals, evaluated anywhere in space (thesis, chapter 7).

use std::ffi::{c_char, c_void};
use std::mem::offset_of;

use super::boundary::{boundary, text};
use super::params::{Versioned, init, read};
use super::pointer::{check_size, output, slice, slice_mut};
use super::progress::{cata_progress, par, watcher};
#[cfg(not(feature = "opencl"))]
use super::status::CATA_ERR_UNSUPPORTED;
use super::status::{CATA_ERR_ARGUMENT, CATA_ERR_SHAPE, Failure, cata_status};
use crate::Par;
use crate::base::Progress;
#[cfg(feature = "opencl")]
use crate::opencl::{Device, evaluate_newton};
use crate::texture::newton::{
    Fractal, Gradient, Grid, Newton, NewtonOptions, Points, Polynomial, darkened, root_color,
};

/// Equation 7.3 of the thesis: from -1 (at a root) to the number of iterations.
pub const CATA_NEWTON_THESIS: i32 = 0;
/// The gradient of the shader of the thesis' authors: from 0 to 1.
pub const CATA_NEWTON_SHADER: i32 = 1;

/// What a Newton fractal is of.
#[repr(C)]
#[derive(Debug, Clone, Copy)]
pub struct cata_newton_params {
    /// sizeof(cata_newton_params).
    pub struct_size: usize,
    /// Threads, at most; 0: all.
    pub threads: usize,
    /// Told of progress; NULL: nobody.
    pub progress: cata_progress,
    /// Handed to `progress`.
    pub progress_user: *mut c_void,
    /// Elements of `roots` / 2: roots of the polynomial, at most 64; 0: the polynomial is
    /// z^`power` - 1.
    pub root_count: usize,
    /// 2 `root_count` elements, read by cata_newton_new: real and imaginary part of each root,
    /// within 1e4 of 0. NULL when there are none.
    pub roots: *const f64,
    /// NULL: the processor. Else an OpenCL device: its number or a part of its name,
    /// NUL-terminated; "" is the first GPU, or else the first device. Needs CATA_CAP_OPENCL.
    pub device: *const c_char,
    /// What points are multiplied by after `offset` and `w` are added; 0: 1.
    pub scale: f64,
    /// The theta of the gradient, from -10 to 20; 0: 3.5.
    pub theta: f64,
    /// The fourth coordinate of all points.
    pub w: f64,
    /// Added to x, y and z of each point.
    pub offset: [f64; 3],
    /// With `root_count` 0: from 2 to 64; 0: 3.
    pub power: u32,
    /// Iterations, at most 1000; 0: 32.
    pub iterations: u32,
    /// CATA_NEWTON_THESIS or CATA_NEWTON_SHADER.
    pub gradient: i32,
}

impl Versioned for cata_newton_params {
    const NAME: &'static str = "cata_newton_params";
    const FIRST_SIZE: usize = offset_of!(Self, gradient) + size_of::<i32>();
}

/// A fractal that points can be asked of. Made by cata_newton_new; for one thread at a time.
pub struct cata_newton {
    newton: Newton,
    options: NewtonOptions,
    par: Par,
    progress: cata_progress,
    user: *mut c_void,
    #[cfg(feature = "opencl")]
    device: Option<Device>,
}

/// Fills a struct with the defaults.
///
/// # Safety
/// `params` points to `struct_size` writable bytes.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn cata_newton_params_init(
    params: *mut cata_newton_params,
    struct_size: usize,
) -> cata_status {
    // SAFETY: the promises are the same.
    unsafe { init(params, struct_size) }
}

/// A Newton fractal in four dimensions (bicomplex numbers; thesis, chapter 7). A polynomial with
/// n roots has n^2 here, numbered `a n + b`; those of z^n - 1 are exp(2 pi i a / n) and exp(2 pi
/// i b / n).
///
/// Returns CATA_ERR_BACKEND when there is no such device or no OpenCL on this machine.
///
/// # Safety
/// The pointers are as described.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn cata_newton_new(
    params: *const cata_newton_params,
    newton: *mut *mut cata_newton,
) -> cata_status {
    boundary(|| {
        // SAFETY: the caller's promise.
        let out = unsafe { output("newton", newton) }?;
        let mut options = NewtonOptions::default();
        let mut made = cata_newton {
            newton: Newton::new(&options)?,
            options: options.clone(),
            par: Par::all(),
            progress: None,
            user: std::ptr::null_mut(),
            #[cfg(feature = "opencl")]
            device: None,
        };
        if !params.is_null() {
            // SAFETY: the caller's promise.
            let (params, roots) = unsafe {
                let params = read(params)?;
                check_size::<f64>("params.roots", params.root_count, 2)?;
                (params, slice("params.roots", params.roots, 2 * params.root_count)?)
            };
            fill(&mut options, &params, roots)?;
            made.newton = Newton::new(&options)?;
            made.options = options;
            made.par = par(params.threads);
            (made.progress, made.user) = (params.progress, params.progress_user);
            if !params.device.is_null() {
                // SAFETY: the caller's promise.
                let name = unsafe { text("params.device", params.device) }?;
                let name = name.to_str();
                let name =
                    name.map_err(|_| Failure::new(CATA_ERR_ARGUMENT, "params.device: not UTF-8"))?;
                open(&mut made, name)?;
            }
        }
        *out = Box::into_raw(Box::new(made));
        Ok(())
    })
}

fn fill(
    options: &mut NewtonOptions,
    params: &cata_newton_params,
    roots: &[f64],
) -> Result<(), Failure> {
    let given = |x: f64, default: f64| if x == 0.0 { default } else { x };
    options.polynomial = match (roots, params.power) {
        ([], 0) => Polynomial::Power(3),
        ([], power) => Polynomial::Power(power),
        (roots, 0) => Polynomial::Roots(roots.as_chunks().0.to_vec()),
        (_, power) => {
            let why = format!("params.power: must be 0 where roots are given, is {power}");
            return Err(Failure::new(CATA_ERR_ARGUMENT, why));
        }
    };
    if params.iterations > 0 {
        options.iterations = params.iterations;
    }
    options.scale = given(params.scale, options.scale);
    options.theta = given(params.theta, options.theta);
    (options.w, options.offset) = (params.w, params.offset);
    options.gradient = match params.gradient {
        CATA_NEWTON_THESIS => Gradient::Thesis,
        CATA_NEWTON_SHADER => Gradient::Shader,
        other => {
            let why = format!("params.gradient: must be a CATA_NEWTON_* value, is {other}");
            return Err(Failure::new(CATA_ERR_ARGUMENT, why));
        }
    };
    Ok(())
}

#[cfg(feature = "opencl")]
fn open(newton: &mut cata_newton, name: &str) -> Result<(), Failure> {
    newton.device = Some(Device::open(name)?);
    Ok(())
}

#[cfg(not(feature = "opencl"))]
fn open(_newton: &mut cata_newton, _name: &str) -> Result<(), Failure> {
    Err(Failure::new(CATA_ERR_UNSUPPORTED, "params.device: built without the feature opencl"))
}

/// Gives a fractal back.
///
/// `newton`: from cata_newton_new, not used any more afterwards; NULL is ignored.
///
/// # Safety
/// `newton` is NULL or from cata_newton_new, and was not given back before.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn cata_newton_free(newton: *mut cata_newton) {
    if !newton.is_null() {
        // SAFETY: from Box::into_raw, and the caller's promise.
        drop(unsafe { Box::from_raw(newton) });
    }
}

/// Changes the fourth coordinate of all points, as time goes on.
///
/// - `newton`: from cata_newton_new, not NULL.
/// - `w`: the coordinate; finite.
///
/// Not thread-safe for one fractal.
///
/// # Safety
/// The pointer is as described.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn cata_newton_set_w(newton: *mut cata_newton, w: f64) -> cata_status {
    boundary(|| {
        // SAFETY: the caller's promise.
        let newton = unsafe { output("newton", newton) }?;
        let options = NewtonOptions { w, ..newton.options.clone() };
        newton.newton = Newton::new(&options)?;
        newton.options = options;
        Ok(())
    })
}

/// The fractal at points in space, such as the vertices of a mesh.
///
/// - `newton`: from cata_newton_new, not NULL.
/// - `count`: points, less than 2^31.
/// - `positions`: 3 `count` elements, read: x, y, z of each point.
/// - `roots`: `count` elements, written: the number of the root that each point converges to.
/// - `convergence`: `count` elements, written: how slowly.
///
/// Returns CATA_ERR_NON_FINITE for a point that is not finite or beyond 1e9, CATA_ERR_BACKEND
/// when the device refuses.
///
/// Not thread-safe for one fractal.
///
/// # Safety
/// The pointers are as described.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn cata_newton_points(
    newton: *const cata_newton,
    count: usize,
    positions: *const f32,
    roots: *mut u16,
    convergence: *mut f32,
) -> cata_status {
    boundary(|| {
        check_size::<f32>("positions", count, 3)?;
        // SAFETY: the caller's promise.
        let (newton, positions) =
            unsafe { (known(newton)?, slice("positions", positions, 3 * count)?) };
        // SAFETY: the caller's promise.
        unsafe { write(newton, Points::List(positions.as_chunks().0), count, roots, convergence) }
    })
}

/// The fractal on the plane z = 0: at the centres of the pixels of a picture, rows from the top
/// (large y).
///
/// - `newton`: from cata_newton_new, not NULL.
/// - `width`, `height`: pixels, at most 65,536 each and less than 2^31 in all.
/// - `center_x`, `center_y`: the middle of the picture.
/// - `extent`: how wide it is, positive.
/// - `roots`: `width` `height` elements, written: the number of the root of each pixel.
/// - `convergence`: `width` `height` elements, written: how slowly it converges.
///
/// Returns what cata_newton_points returns; outputs are untouched unless it is CATA_OK.
///
/// Not thread-safe for one fractal.
///
/// # Safety
/// The pointers are as described.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn cata_newton_plane(
    newton: *const cata_newton,
    width: u32,
    height: u32,
    center_x: f64,
    center_y: f64,
    extent: f64,
    roots: *mut u16,
    convergence: *mut f32,
) -> cata_status {
    boundary(|| {
        if !(extent > 0.0 && extent.is_finite()) {
            let why = format!("extent: must be positive, is {extent}");
            return Err(Failure::new(CATA_ERR_ARGUMENT, why));
        }
        let Some(count) = (width as usize).checked_mul(height as usize) else {
            return Err(Failure::new(CATA_ERR_SHAPE, "width, height: beyond the address space"));
        };
        let grid = Grid::plane(width, height, [center_x, center_y], extent);
        // SAFETY: the caller's promise.
        unsafe { write(known(newton)?, Points::Grid(grid), count, roots, convergence) }
    })
}

/// Colours of points: each root has its own, darker the slower a point converges.
///
/// - `newton`: from cata_newton_new, not NULL.
/// - `count`: points.
/// - `roots`, `convergence`: `count` elements each, read: as cata_newton_points or
///   cata_newton_plane wrote them.
/// - `colors`: 3 `count` elements, written: red, green and blue of each point, as screens have
///   them (sRGB).
///
/// Not thread-safe for one fractal.
///
/// # Safety
/// The pointers are as described.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn cata_newton_colors(
    newton: *const cata_newton,
    count: usize,
    roots: *const u16,
    convergence: *const f32,
    colors: *mut u8,
) -> cata_status {
    boundary(|| {
        check_size::<u8>("colors", count, 3)?;
        // SAFETY: the caller's promise.
        let (newton, roots, convergence, colors) = unsafe {
            (
                &known(newton)?.newton,
                slice("roots", roots, count)?,
                slice("convergence", convergence, count)?,
                slice_mut("colors", colors, 3 * count)?,
            )
        };
        let points = roots.iter().zip(convergence).zip(colors.as_chunks_mut::<3>().0);
        for ((&root, &t), color) in points {
            *color = darkened(root_color(root, newton.roots()), newton.share(t));
        }
        Ok(())
    })
}

/// # Safety
/// `newton` is NULL or from cata_newton_new and not given back.
unsafe fn known<'a>(newton: *const cata_newton) -> Result<&'a cata_newton, Failure> {
    // SAFETY: passed on to the caller.
    unsafe { newton.as_ref() }.ok_or_else(|| Failure::null("newton"))
}

/// # Safety
/// `roots` and `convergence` are as slice_mut wants them.
unsafe fn write(
    newton: &cata_newton,
    points: Points<'_>,
    count: usize,
    roots: *mut u16,
    convergence: *mut f32,
) -> Result<(), Failure> {
    // SAFETY: passed on to the caller.
    let (roots, convergence) = unsafe {
        (slice_mut("roots", roots, count)?, slice_mut("convergence", convergence, count)?)
    };
    let watch = watcher(newton.progress, newton.user);
    let fractal =
        evaluate(newton, points, watch.as_ref().map_or(Progress::none(), Progress::from))?;
    roots.copy_from_slice(&fractal.roots);
    convergence.copy_from_slice(&fractal.convergence);
    Ok(())
}

fn evaluate(
    newton: &cata_newton,
    points: Points<'_>,
    progress: Progress<'_>,
) -> Result<Fractal, Failure> {
    #[cfg(feature = "opencl")]
    if let Some(device) = &newton.device {
        return Ok(evaluate_newton(device, &newton.newton, points, progress)?);
    }
    Ok(newton.newton.evaluate(points, newton.par, progress)?)
}
