//! The scalars of products, their functions, and entries of matrices.

use catamaran::base::Rng;
use catamaran_capi::*;

use super::buffers::Element;
use super::choices::Choices;

type Params = *const cata_ata_params;
type Symmetric<T> = unsafe extern "C" fn(
    i32,
    i32,
    usize,
    usize,
    T,
    *const T,
    usize,
    T,
    *mut T,
    usize,
    Params,
) -> cata_status;
type General<T> = unsafe extern "C" fn(
    i32,
    usize,
    usize,
    usize,
    T,
    *const T,
    usize,
    *const T,
    usize,
    T,
    *mut T,
    usize,
    Params,
) -> cata_status;
type ComplexGeneral<T> = unsafe extern "C" fn(
    i32,
    usize,
    usize,
    usize,
    *const T,
    *const T,
    usize,
    *const T,
    usize,
    *const T,
    *mut T,
    usize,
    Params,
) -> cata_status;
type SymmetricLen = unsafe extern "C" fn(usize, usize, Params, *mut usize) -> cata_status;
type GeneralLen = unsafe extern "C" fn(usize, usize, usize, Params, *mut usize) -> cata_status;
type SymmetricIn<T> = unsafe extern "C" fn(
    i32,
    i32,
    usize,
    usize,
    T,
    *const T,
    usize,
    T,
    *mut T,
    usize,
    *mut T,
    usize,
    Params,
) -> cata_status;
type GeneralIn<T> = unsafe extern "C" fn(
    i32,
    usize,
    usize,
    usize,
    T,
    *const T,
    usize,
    *const T,
    usize,
    T,
    *mut T,
    usize,
    *mut T,
    usize,
    Params,
) -> cata_status;
type Rows<T> = unsafe extern "C" fn(
    i32,
    i32,
    usize,
    usize,
    T,
    *const T,
    usize,
    *const T,
    i32,
    *const T,
    T,
    *mut T,
    usize,
    Params,
) -> cata_status;
type Sparse<T> = unsafe extern "C" fn(
    i32,
    i32,
    usize,
    usize,
    T,
    *const usize,
    *const usize,
    *const T,
    *const f64,
    T,
    *mut T,
    usize,
    Params,
) -> cata_status;
type Verify<T> = unsafe extern "C" fn(
    i32,
    i32,
    usize,
    usize,
    f64,
    *const T,
    usize,
    *const T,
    usize,
    i32,
    u64,
    *mut i32,
    *mut f64,
    *mut f64,
) -> cata_status;

/// float or double, with the functions for it.
pub trait Real: Element {
    const UNIT: f64;
    /// The smallest normal number.
    const SMALLEST: f64;
    const ATA: Symmetric<Self>;
    const AAT: Symmetric<Self>;
    const AHA: Symmetric<Self>;
    const ATB: General<Self>;
    const AHB: ComplexGeneral<Self>;
    const ATA_LEN: SymmetricLen;
    const ATB_LEN: GeneralLen;
    const ATA_IN: SymmetricIn<Self>;
    const ATB_IN: GeneralIn<Self>;
    const ROWS: Rows<Self>;
    const SPARSE: Sparse<Self>;
    const VERIFY: Verify<Self>;

    fn of(x: f64) -> Self;

    fn wide(self) -> f64;
}

macro_rules! real {
    ($real:ty, $unit:literal, $ata:ident $aat:ident $aha:ident $atb:ident $ahb:ident $ata_len:ident
     $atb_len:ident $ata_in:ident $atb_in:ident $rows:ident $sparse:ident $verify:ident) => {
        impl Real for $real {
            const UNIT: f64 = $unit;
            const SMALLEST: f64 = <$real>::MIN_POSITIVE as f64;
            const ATA: Symmetric<Self> = $ata;
            const AAT: Symmetric<Self> = $aat;
            const AHA: Symmetric<Self> = $aha;
            const ATB: General<Self> = $atb;
            const AHB: ComplexGeneral<Self> = $ahb;
            const ATA_LEN: SymmetricLen = $ata_len;
            const ATB_LEN: GeneralLen = $atb_len;
            const ATA_IN: SymmetricIn<Self> = $ata_in;
            const ATB_IN: GeneralIn<Self> = $atb_in;
            const ROWS: Rows<Self> = $rows;
            const SPARSE: Sparse<Self> = $sparse;
            const VERIFY: Verify<Self> = $verify;

            fn of(x: f64) -> Self {
                x as Self
            }

            fn wide(self) -> f64 {
                self.into()
            }
        }
    };
}

real!(f64, 1.1102230246251565e-16, cata_ata_f64 cata_aat_f64 cata_aha_c64 cata_atb_f64 cata_ahb_c64
    cata_ata_scratch_len_f64 cata_atb_scratch_len_f64 cata_ata_with_scratch_f64
    cata_atb_with_scratch_f64 cata_ata_rows_f64 cata_ata_sparse_f64 cata_verify_f64);
real!(f32, 5.960464477539063e-8, cata_ata_f32 cata_aat_f32 cata_aha_c32 cata_atb_f32 cata_ahb_c32
    cata_ata_scratch_len_f32 cata_atb_scratch_len_f32 cata_ata_with_scratch_f32
    cata_atb_with_scratch_f32 cata_ata_rows_f32 cata_ata_sparse_f32 cata_verify_f32);

/// Entries of a kind.
pub struct Entries {
    kind: usize,
    rng: Rng,
}

impl Entries {
    /// Chooses entries of any kind, NaN and infinities too.
    pub fn any(choices: &mut Choices<'_>) -> Self {
        Self { kind: choices.below(8), rng: choices.rng() }
    }

    /// Chooses entries of which some are NaN or infinite.
    pub fn broken(choices: &mut Choices<'_>) -> Self {
        Self { kind: choices.pick(&[6, 7]), rng: choices.rng() }
    }

    /// Chooses finite entries that are not subnormal.
    pub fn finite(choices: &mut Choices<'_>) -> Self {
        Self { kind: choices.below(5), rng: choices.rng() }
    }

    /// Returns the entry (i, j).
    pub fn next<T: Real>(&mut self, i: usize, j: usize) -> T {
        let normal = self.rng.normal();
        T::of(match self.kind {
            0 => normal,
            1 => (4.0 * self.rng.uniform()).floor() * self.rng.sign(),
            // Lines of very different norms.
            2 => normal * (2.0_f64).powi((7 * (i % 3) + 5 * (j % 4)) as i32 - 14),
            3 => 0.3,
            4 if self.rng.uniform() < 0.8 => 0.0,
            4 => normal,
            5 => normal * T::SMALLEST,
            6 if self.rng.uniform() < 0.02 => f64::NAN,
            7 if self.rng.uniform() < 0.02 => f64::INFINITY * self.rng.sign(),
            _ => normal,
        })
    }
}

/// Chooses a factor of a product.
pub fn factor<T: Real>(choices: &mut Choices<'_>) -> T {
    T::of(choices.pick(&[1.0, 1.0, 0.0, -1.0, 2.5, -0.0, 1e-3]))
}
