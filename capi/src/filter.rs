use super::boundary::boundary;
use super::eigs::mass;
use super::pointer::{Layout, matrix, optional_output, put, slice, slice_mut, sparse};
use super::status::{CATA_ERR_NON_FINITE, Failure, cata_status};
use catamaran_geometry::spectral::{Response, dirichlet_energies};

/// `response`: 1 up to the frequency `first`, 0 beyond.
pub const CATA_RESPONSE_LOW_PASS: i32 = 0;
/// `response`: 0 up to the frequency `first`, 1 beyond.
pub const CATA_RESPONSE_HIGH_PASS: i32 = 1;
/// `response`: 1 from the frequency `first` to `second`, 0 elsewhere.
pub const CATA_RESPONSE_BAND_PASS: i32 = 2;
/// `response`: exp(-t frequency), t = `first`: diffusion.
pub const CATA_RESPONSE_HEAT: i32 = 3;
/// `response`: 1 + s (1 - exp(-t frequency)), t = `first`, s = `second`.
pub const CATA_RESPONSE_SHARPEN: i32 = 4;

/// Computes the gains of a filter for cata_basis_filter.
///
/// - `response`: CATA_RESPONSE_*, with its numbers `first` and `second`; one that it does not have
///   is ignored. Frequencies are in units of 1 / length^2, times in units of length^2.
/// - `count`, `frequencies`: eigenvalues, or energies of cata_filter_energies.
/// - `gains`: `count` elements, written.
/// - `rest`: written: the gain beyond all frequencies; NULL where not wanted.
///
/// # Safety
/// The pointers are as described.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn cata_filter_gains(
    response: i32,
    first: f64,
    second: f64,
    count: usize,
    frequencies: *const f64,
    gains: *mut f64,
    rest: *mut f64,
) -> cata_status {
    boundary(|| {
        // SAFETY: clause `memory` (`frequencies`, `count` elements; `gains`, `count` elements;
        // `rest`, one value).
        let (frequencies, gains, rest) = unsafe {
            (
                slice("frequencies", frequencies, count)?,
                slice_mut("gains", gains, count)?,
                optional_output("rest", rest)?,
            )
        };
        let (response, has_second) = match response {
            CATA_RESPONSE_LOW_PASS => (Response::LowPass(first), false),
            CATA_RESPONSE_HIGH_PASS => (Response::HighPass(first), false),
            CATA_RESPONSE_BAND_PASS => (Response::BandPass(first, second), true),
            CATA_RESPONSE_HEAT => (Response::Heat(first), false),
            CATA_RESPONSE_SHARPEN => (Response::Sharpen { time: first, amount: second }, true),
            other => return Err(Failure::argument("response", "a CATA_RESPONSE_* value", other)),
        };
        for (what, number, is_used) in [("first", first, true), ("second", second, has_second)] {
            if is_used && number.is_nan() {
                let why = format!("{what}: must be a number, is {number}");
                return Err(Failure::new(CATA_ERR_NON_FINITE, why));
            }
        }
        gains.iter_mut().zip(frequencies).for_each(|(gain, &x)| *gain = response.gain(x));
        put(rest, response.limit());
        Ok(())
    })
}

/// Computes the frequencies of functions: the energy of each, (f, W f) / (f, M f), which for
/// eigenfunctions is the eigenvalue; 0 for the function 0.
///
/// - `n`, `row_starts`, `columns`, `entries`, `masses`: W and M, as those of cata_eigs.
/// - `count`, `f`: functions, n x count.
/// - `energies`: `count` elements, written.
///
/// # Safety
/// The pointers are as described.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn cata_filter_energies(
    n: usize,
    row_starts: *const usize,
    columns: *const usize,
    entries: *const f64,
    masses: *const f64,
    layout: i32,
    count: usize,
    f: *const f64,
    ldf: usize,
    energies: *mut f64,
) -> cata_status {
    boundary(|| {
        let layout = Layout::new(layout)?;
        // SAFETY: clause `memory` (the CSR arrays; `f`, n x `count`; `energies`, `count` elements),
        // clause `passed on` (`mass`).
        let (w, m, f, energies) = unsafe {
            (
                sparse(n, n, row_starts, columns, entries)?,
                mass(n, masses)?,
                matrix("f", layout, n, count, f, ldf)?,
                slice_mut("energies", energies, count)?,
            )
        };
        energies.copy_from_slice(&dirichlet_energies(f, w, &m)?);
        Ok(())
    })
}
