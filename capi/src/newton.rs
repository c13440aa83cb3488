//! # Newton fractals
//!
//! Bicomplex fractals, evaluated anywhere in space (thesis, chapter 7).
//!
//! ```c
//! cata_newton *newton;
//! uint16_t roots[16 * 16];
//! float convergence[16 * 16];
//! if (cata_newton_new(NULL, &newton) == CATA_OK) {
//!     cata_newton_plane(newton, 16, 16, 0, 0, 3, roots, convergence);
//!     cata_newton_free(newton);
//! }
//! ```

use std::ffi::{c_char, c_void};

use super::boundary::boundary;
use super::device::chosen;
use super::params::{Params, init, or_default, params, read_or_zeros};
use super::pointer::{free, hand_over, known, known_mut, output, slice, slice_mut};
use super::progress::{Caller, cata_progress};
use super::status::{CATA_ERR_SHAPE, Failure, cata_status};
use catamaran::Par;
use catamaran::base::Progress;
use catamaran_simulation::texture::newton::{
    Fractal, Gradient, Grid, Newton, NewtonOptions, Points, Polynomial, darkened, root_color,
};

/// Equation 7.3: from -1 (at a root) to the iterations.
pub const CATA_NEWTON_THESIS: i32 = 0;
/// That of the thesis authors' shader: from 0 to 1.
pub const CATA_NEWTON_SHADER: i32 = 1;

/// The polynomial of a Newton fractal, and how it is evaluated.
#[repr(C)]
#[derive(Debug, Clone, Copy)]
pub struct cata_newton_params {
    /// sizeof(cata_newton_params).
    pub struct_size: usize,
    /// Threads, at most; 0: all.
    pub threads: usize,
    /// Progress callback.
    pub progress: cata_progress,
    /// Passed to `progress`.
    pub progress_user: *mut c_void,
    /// Roots of the polynomial, at most 64; 0: it is z^`power` - 1.
    pub root_count: usize,
    /// 2 `root_count` elements: real and imaginary part of each root, within 1e4 of 0.
    pub roots: *const f64,
    /// An OpenCL device (see Devices); NULL: the processor.
    pub device: *const c_char,
    /// Factor of points after `offset` and `w` are added; 0: 1.
    pub scale: f64,
    /// The theta of the gradient, from -10 to 20; 0: 3.5.
    pub theta: f64,
    /// The fourth coordinate of all points, which cata_newton_set_w changes.
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

params!(cata_newton_params, gradient: i32);

/// A Newton fractal, which is evaluated at points.
pub struct cata_newton {
    newton: Newton,
    options: NewtonOptions,
    par: Par,
    caller: Caller,
    #[cfg(feature = "opencl")]
    device: Option<super::device::Device>,
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
    // SAFETY: clause `structs` (`params`).
    unsafe { init(params, struct_size) }
}

/// Creates a Newton fractal in four dimensions (bicomplex numbers; thesis, chapter 7). A polynomial
/// with n roots has n^2 here, numbered `a n + b`; those of z^n - 1 are exp(2 pi i a / n) and exp(2
/// pi i b / n).
///
/// # Safety
/// The pointers are as described.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn cata_newton_new(
    params: *const cata_newton_params,
    newton: *mut *mut cata_newton,
) -> cata_status {
    boundary(|| {
        // SAFETY: clause `memory` (`newton`, one value).
        let out = unsafe { output("newton", newton) }?;
        // SAFETY: clause `memory` (`params.roots`, `2 * params.root_count` elements), clause
        // `structs` (`params`).
        let (params, roots, device) = unsafe {
            let params = read_or_zeros("params", params)?;
            let roots = slice("params.roots", params.roots.cast::<[f64; 2]>(), params.root_count)?;
            (params, roots, params.device)
        };
        let options = options(&params, roots)?;
        let newton = Newton::new(&options)?;
        // SAFETY: clause `passed on` (`chosen`).
        let device = unsafe { chosen(device) }?;
        #[cfg(not(feature = "opencl"))]
        let None = device;
        let made = cata_newton {
            newton,
            options,
            par: params.par(),
            caller: params.caller(),
            #[cfg(feature = "opencl")]
            device,
        };
        hand_over(out, made);
        Ok(())
    })
}

/// Returns the options of the caller.
pub(super) fn options(
    params: &cata_newton_params,
    roots: &[[f64; 2]],
) -> Result<NewtonOptions, Failure> {
    let default = NewtonOptions::default();
    let polynomial = match (roots, params.power) {
        ([], 0) => Polynomial::Power(3),
        ([], power) => {
            if power < 2 || power as usize > Polynomial::MOST_ROOTS {
                let any = format!("from 2 to {}", Polynomial::MOST_ROOTS);
                return Err(Failure::argument("params.power", any, power));
            }
            Polynomial::Power(power)
        }
        (roots, 0) => Polynomial::Roots(roots.to_vec()),
        (_, power) => {
            return Err(Failure::argument("params.power", "0 where roots are given", power));
        }
    };
    Ok(NewtonOptions::new()
        .polynomial(polynomial)
        .iterations(or_default(params.iterations, default.iterations))
        .scale(or_default(params.scale, default.scale))
        .theta(or_default(params.theta, default.theta))
        .w(params.w)
        .offset(params.offset)
        .gradient(match params.gradient {
            CATA_NEWTON_THESIS => Gradient::Thesis,
            CATA_NEWTON_SHADER => Gradient::Shader,
            other => {
                return Err(Failure::argument("params.gradient", "a CATA_NEWTON_* value", other));
            }
        }))
}

/// Frees a fractal.
///
/// # Safety
/// `newton` is NULL or from cata_newton_new, and has not been freed before.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn cata_newton_free(newton: *mut cata_newton) {
    // SAFETY: clause `handles` (`newton`).
    unsafe { free(newton) };
}

/// Changes the fourth coordinate of all points.
///
/// # Safety
/// The pointer is as described.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn cata_newton_set_w(newton: *mut cata_newton, w: f64) -> cata_status {
    boundary(|| {
        // SAFETY: clause `handles` (`newton`).
        let newton = unsafe { known_mut("newton", newton) }?;
        let options = newton.options.clone().w(w);
        newton.newton = Newton::new(&options)?;
        newton.options = options;
        Ok(())
    })
}

/// Computes the fractal at points in space, such as the vertices of a mesh.
///
/// - `positions`: 3 `count` elements: x, y, z of less than 2^31 points, within 1e9 of 0.
/// - `roots`: `count` elements, written: the number of the root that each point converges to.
/// - `convergence`: `count` elements, written: how slowly.
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
        // SAFETY: clause `memory` (`positions`, `3 * count` elements), clause `handles` (`newton`),
        // clause `passed on` (`write`).
        unsafe {
            let newton = known("newton", newton)?;
            let positions = slice("positions", positions.cast::<[f32; 3]>(), count)?;
            write(newton, Points::List(positions), count, roots, convergence)
        }
    })
}

/// Computes the fractal on the plane z = 0: at the centres of the pixels of a picture `extent`
/// wide, at most 65,536 a side and less than 2^31 in all, rows from the top (large y).
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
            return Err(Failure::argument("extent", "positive", extent));
        }
        let Some(count) = (width as usize).checked_mul(height as usize) else {
            return Err(Failure::new(CATA_ERR_SHAPE, "width, height: exceed the address space"));
        };
        let grid = Grid::plane(width, height, [center_x, center_y], extent);
        // SAFETY: clause `handles` (`newton`), clause `passed on` (`write`).
        unsafe { write(known("newton", newton)?, Points::Grid(grid), count, roots, convergence) }
    })
}

/// Computes colours of points: each root has its own, darker the slower a point converges.
/// `colors`: 3 `count` elements, written: red, green and blue of each (sRGB).
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
        // SAFETY: clause `memory` (`roots`, `count` elements; `convergence`, `count` elements;
        // `colors`, `3 * count` elements), clause `handles` (`newton`).
        let (newton, roots, convergence, colors) = unsafe {
            (
                &known("newton", newton)?.newton,
                slice("roots", roots, count)?,
                slice("convergence", convergence, count)?,
                slice_mut("colors", colors.cast::<[u8; 3]>(), count)?,
            )
        };
        let points = roots.iter().zip(convergence).zip(colors);
        for ((&root, &t), color) in points {
            *color = darkened(root_color(root, newton.roots()), newton.share(t));
        }
        Ok(())
    })
}

/// Writes the fractal at points.
///
/// # Safety
/// `roots` and `convergence` are as slice_mut wants them.
unsafe fn write(
    newton: &cata_newton,
    points: Points<'_>,
    count: usize,
    roots: *mut u16,
    convergence: *mut f32,
) -> Result<(), Failure> {
    // SAFETY: clause `memory` (`roots`, `count` elements; `convergence`, `count` elements).
    let (roots, convergence) = unsafe {
        (slice_mut("roots", roots, count)?, slice_mut("convergence", convergence, count)?)
    };
    let fractal = newton.caller.with(|progress| evaluate(newton, points, progress))?;
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
        return Ok(catamaran_simulation::opencl::evaluate_newton(
            device,
            &newton.newton,
            points,
            progress,
        )?);
    }
    Ok(newton.newton.evaluate(points, newton.par, progress)?)
}
