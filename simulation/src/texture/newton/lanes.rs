//! Arithmetic on all lanes of a SIMD vector, with the notation of scalars.

use std::ops::{Add, BitAnd, Div, Mul, Not, Sub};

use pulp::Simd;

/// Numbers in the lanes of a vector.
#[derive(Clone, Copy)]
pub(super) struct Lanes<S: Simd> {
    simd: S,
    values: S::f32s,
}

/// A truth value in each lane.
#[derive(Clone, Copy)]
pub(super) struct Mask<S: Simd> {
    simd: S,
    values: S::m32s,
}

/// Largest number of lanes.
pub(super) const MOST_LANES: usize = 16;

impl<S: Simd> Lanes<S> {
    /// Returns the number in all lanes.
    #[inline(always)]
    pub fn splat(simd: S, x: f32) -> Self {
        Self { simd, values: simd.splat_f32s(x) }
    }

    /// Loads the first numbers of `x`.
    #[inline(always)]
    pub fn load(simd: S, x: &[f32; MOST_LANES]) -> Self {
        Self { simd, values: simd.partial_load_f32s(&x[..S::F32_LANES]) }
    }

    /// Stores the lanes at the beginning of `x`.
    #[inline(always)]
    pub fn store(self, x: &mut [f32; MOST_LANES]) {
        self.simd.partial_store_f32s(&mut x[..S::F32_LANES], self.values);
    }

    /// Returns lanes that all have the same number.
    #[inline(always)]
    pub fn all(self, x: f32) -> Self {
        Self::splat(self.simd, x)
    }

    /// Returns the square root of each lane.
    #[inline(always)]
    pub fn sqrt(self) -> Self {
        Self { values: self.simd.sqrt_f32s(self.values), ..self }
    }

    /// Returns the absolute value of each lane.
    #[inline(always)]
    pub fn abs(self) -> Self {
        Self { values: self.simd.abs_f32s(self.values), ..self }
    }

    /// Returns the smaller number of each lane.
    #[inline(always)]
    pub fn min(self, other: Self) -> Self {
        Self { values: self.simd.min_f32s(self.values, other.values), ..self }
    }

    /// Returns the larger number of each lane.
    #[inline(always)]
    pub fn max(self, other: Self) -> Self {
        Self { values: self.simd.max_f32s(self.values, other.values), ..self }
    }

    /// Returns a mask of the lanes whose number is below that of `other`.
    #[inline(always)]
    pub fn is_below(self, other: Self) -> Mask<S> {
        Mask { simd: self.simd, values: self.simd.less_than_f32s(self.values, other.values) }
    }

    /// Returns 2^n for a number that [`to_nearest`] made.
    #[inline(always)]
    pub fn power_of_two(self) -> Self {
        let simd = self.simd;
        let bits = simd.transmute_u32s_f32s(self.values);
        let shifted = simd.wrapping_dyn_shl_u32s(bits, simd.splat_u32s(23));
        let one = simd.splat_u32s(1.0_f32.to_bits());
        Self { values: simd.transmute_f32s_u32s(simd.add_u32s(shifted, one)), ..self }
    }
}

/// The number 1.5 2^23: its sum with a number below 2^22 has no fraction, and the integer in its
/// lowest bits.
pub(super) const TO_NEAREST: f32 = 12_582_912.0;

/// Returns [`TO_NEAREST`] plus the integer nearest to x.
#[inline(always)]
pub(super) fn to_nearest<S: Simd>(x: Lanes<S>) -> Lanes<S> {
    x + x.all(TO_NEAREST)
}

macro_rules! operator {
    ($name:ident, $method:ident, $call:ident) => {
        impl<S: Simd> $name for Lanes<S> {
            type Output = Self;

            #[inline(always)]
            fn $method(self, other: Self) -> Self {
                Self { values: self.simd.$call(self.values, other.values), ..self }
            }
        }
    };
}
operator!(Add, add, add_f32s);
operator!(Sub, sub, sub_f32s);
operator!(Mul, mul, mul_f32s);
operator!(Div, div, div_f32s);

impl<S: Simd> Mask<S> {
    /// Returns `yes` where the mask is set, `no` elsewhere.
    #[inline(always)]
    pub fn select(self, yes: Lanes<S>, no: Lanes<S>) -> Lanes<S> {
        Lanes { values: self.simd.select_f32s(self.values, yes.values, no.values), ..yes }
    }

    /// Returns whether the mask is set in any lane.
    #[inline(always)]
    pub fn any(self) -> bool {
        self.simd.first_true_m32s(self.values) < S::F32_LANES
    }
}

impl<S: Simd> BitAnd for Mask<S> {
    type Output = Self;

    #[inline(always)]
    fn bitand(self, other: Self) -> Self {
        Self { values: self.simd.and_m32s(self.values, other.values), ..self }
    }
}

impl<S: Simd> Not for Mask<S> {
    type Output = Self;

    #[inline(always)]
    fn not(self) -> Self {
        Self { values: self.simd.not_m32s(self.values), ..self }
    }
}
