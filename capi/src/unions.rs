//! # Spectral unions
//!
//! The spectrum of a union of parts from those of the parts, by a network (thesis, chapter 2).
//!
//! ```c
//! double parts[2 * CATA_UNION_EIGENVALUES], found[CATA_UNION_EIGENVALUES];
//! for (int i = 0; i < 2 * CATA_UNION_EIGENVALUES; i++) parts[i] = 12.0 * (1 + i % 20);
//! cata_unions *unions;
//! cata_unions_new(NULL, &unions);
//! cata_unions_predict(unions, 2, parts, found, NULL);
//! cata_unions_free(unions);
//! ```

use std::ffi::{c_char, c_void};

use super::boundary::{boundary, path};
use super::params::{Params, init, params, with_params};
use super::pointer::{
    copied, free, hand_over, known, mesh, optional_output, output, put, slice, slice_mut,
};
use super::progress::cata_progress;
use super::status::cata_status;
use catamaran::base::Progress;
use catamaran_geometry::unions::{K, SpectralUnion, interpolate};

/// Eigenvalues of a spectrum of cata_unions_predict.
pub const CATA_UNION_EIGENVALUES: usize = 20;

const _: () = assert!(CATA_UNION_EIGENVALUES == K);

/// The spectral union operator: a network with its weights.
pub struct cata_unions {
    model: SpectralUnion,
}

/// Creates the network that predicts spectra of unions.
///
/// `weights`: a file of `catamaran unions train`, NUL-terminated; NULL: the weights that come
/// with the library. CATA_ERR_IO when something is wrong with the file.
///
/// # Safety
/// The pointers are as described.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn cata_unions_new(
    weights: *const c_char,
    unions: *mut *mut cata_unions,
) -> cata_status {
    boundary(|| {
        // SAFETY: clause `memory` (`unions`, one value).
        let place = unsafe { output("unions", unions) }?;
        let model = if weights.is_null() {
            SpectralUnion::pretrained()?
        } else {
            // SAFETY: clause `texts` (`weights`).
            let path = unsafe { path("weights", weights) }?;
            SpectralUnion::read(&path)?
        };
        hand_over(place, cata_unions { model });
        Ok(())
    })
}

/// Frees a network.
///
/// # Safety
/// The pointer is as described.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn cata_unions_free(unions: *mut cata_unions) {
    // SAFETY: clause `handles` (`unions`).
    unsafe { free(unions) };
}

/// Predicts the first eigenvalues of the union of parts of a surface, from those of the parts:
/// Dirichlet spectra, in whatever unit.
///
/// - `parts`: their number, at least 1.
/// - `spectra`: CATA_UNION_EIGENVALUES elements for each part, ascending and positive, one part
///   after the other.
/// - `spectrum`: CATA_UNION_EIGENVALUES elements, written: ascending, positive, none larger than
///   that of a part of the same number. The order of the parts does not matter, bit for bit.
/// - `ood_score`: written: how unlike the parts are to those of the training; above 1 they are
///   further out than 99.5 % of its pairs, and the prediction is a guess. Below 1 the prediction
///   may be wrong, too. NULL where not wanted.
///
/// # Safety
/// The pointers are as described.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn cata_unions_predict(
    unions: *const cata_unions,
    parts: usize,
    spectra: *const f64,
    spectrum: *mut f64,
    ood_score: *mut f64,
) -> cata_status {
    boundary(|| {
        // SAFETY: clause `memory` (`spectra`, `K * parts` elements; `spectrum`, `K` elements;
        // `ood_score`, one value), clause `handles` (`unions`).
        let (unions, spectra, spectrum, ood_score) = unsafe {
            (
                known("unions", unions)?,
                slice("spectra", spectra.cast::<[f64; K]>(), parts)?,
                slice_mut("spectrum", spectrum, K)?,
                optional_output("ood_score", ood_score)?,
            )
        };
        let parts: Vec<&[f64]> = spectra.iter().map(<[f64; K]>::as_slice).collect();
        let union = unions.model.predict_all(&parts)?;
        let score = ood_score.is_some().then(|| unions.model.ood_score(&parts)).transpose()?;
        put(ood_score, score.unwrap_or_default());
        spectrum.copy_from_slice(&union);
        Ok(())
    })
}

/// Threads and progress of cata_unions_locate.
#[repr(C)]
#[derive(Debug, Clone, Copy)]
pub struct cata_unions_params {
    /// sizeof(cata_unions_params).
    pub struct_size: usize,
    /// Threads, at most; 0: all.
    pub threads: usize,
    /// Progress callback; NULL: none.
    pub progress: cata_progress,
    /// Passed to `progress`.
    pub progress_user: *mut c_void,
}

params!(cata_unions_params, progress_user: *mut c_void);

/// Fills a struct with the defaults.
///
/// # Safety
/// `params` points to `struct_size` writable bytes.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn cata_unions_params_init(
    params: *mut cata_unions_params,
    struct_size: usize,
) -> cata_status {
    // SAFETY: clause `structs` (`params`).
    unsafe { init(params, struct_size) }
}

/// Finds where the union of parts is on the template of the network, the mesh that
/// `catamaran unions template` writes; CATA_ERR_SHAPE and CATA_ERR_ARGUMENT for another mesh. Each
/// call computes the eigenfunctions of the template.
///
/// - `parts`, `spectra`: as those of cata_unions_predict.
/// - `indicator`: n_vertices elements, written: about 1 inside of the union and 0 outside; the
///   union is what is above 1/2. Mirror images have the same spectrum: it is one of the two.
///
/// # Safety
/// The pointers are as described.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn cata_unions_locate(
    unions: *const cata_unions,
    parts: usize,
    spectra: *const f64,
    n_vertices: usize,
    vertices: *const f64,
    n_faces: usize,
    faces: *const u32,
    indicator: *mut f64,
    params: *const cata_unions_params,
) -> cata_status {
    boundary(|| {
        // SAFETY: clause `memory` (`spectra`, `K * parts` elements; the mesh, 3 numbers a vertex
        // and 3 indices a face; `indicator`, `n_vertices` elements), clause `handles` (`unions`).
        let (unions, spectra, template, indicator) = unsafe {
            (
                known("unions", unions)?,
                slice("spectra", spectra.cast::<[f64; K]>(), parts)?,
                mesh(n_vertices, vertices, n_faces, faces)?,
                slice_mut("indicator", indicator, n_vertices)?,
            )
        };
        let parts: Vec<&[f64]> = spectra.iter().map(<[f64; K]>::as_slice).collect();
        let work = |params: &cata_unions_params, progress: Progress<'_>| {
            let found = unions.model.locate(&parts)?;
            let localizer = unions.model.localizer();
            let on = localizer.on_mesh_watched(&template, params.par(), progress)?;
            Ok(on.indicator(&found)?)
        };
        // SAFETY: clause `structs` (`params`).
        indicator.copy_from_slice(&unsafe { with_params(params, work) }?);
        Ok(())
    })
}

/// Computes a spectrum between two: (1 - t) first + t second.
///
/// `first`, `second`, `spectrum`: CATA_UNION_EIGENVALUES elements each, the first two ascending
/// and positive, the last written; it may be one of the others. `t`: in [0, 1].
///
/// # Safety
/// The pointers are as described.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn cata_unions_interpolate(
    first: *const f64,
    second: *const f64,
    t: f64,
    spectrum: *mut f64,
) -> cata_status {
    boundary(|| {
        // SAFETY: clause `memory` (`first`, `K` elements; `second`, `K` elements; `spectrum`, `K`
        // elements).
        let (first, second, spectrum) = unsafe {
            let (first, second) = (copied("first", first, K)?, copied("second", second, K)?);
            (first, second, slice_mut("spectrum", spectrum, K)?)
        };
        spectrum.copy_from_slice(&interpolate(&first, &second, t)?);
        Ok(())
    })
}
