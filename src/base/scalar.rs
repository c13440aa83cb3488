use std::fmt::{Debug, Display, LowerExp};
use std::ops::{Add, AddAssign, Div, Mul, MulAssign, Neg, Sub, SubAssign};

use super::plain::Plain;

mod sealed {
    pub trait Sealed {}
    impl Sealed for f32 {}
    impl Sealed for f64 {}
}

/// A real scalar: `f32` or `f64`. Sealed.
///
/// ```
/// use catamaran::Real;
///
/// fn sum<T: Real>(values: &[T]) -> T {
///     values.iter().fold(T::ZERO, |sum, &x| sum + x)
/// }
/// assert_eq!(sum(&[0.5_f32, 1.0]), 1.5);
/// assert_eq!((sum(&[0.5_f64, 1.0]), f64::NAME), (1.5, "f64"));
/// ```
pub trait Real:
    sealed::Sealed
    + Plain
    + 'static
    + Default
    + PartialEq
    + PartialOrd
    + Debug
    + Display
    + LowerExp
    + Add<Output = Self>
    + Sub<Output = Self>
    + Mul<Output = Self>
    + Div<Output = Self>
    + Neg<Output = Self>
    + AddAssign
    + SubAssign
    + MulAssign
{
    /// 0.
    const ZERO: Self;
    /// 1.
    const ONE: Self;
    /// Unit roundoff `u`: half the distance from 1 to the next number.
    const UNIT_ROUNDOFF: f64;
    /// `"f32"` or `"f64"`.
    const NAME: &'static str;

    /// Returns the nearest value to `x`.
    fn from_f64(x: f64) -> Self;
    /// Returns the value, exactly.
    fn to_f64(self) -> f64;
    /// Returns |x|.
    fn abs(self) -> Self;
    /// Returns whether the value is neither NaN nor infinite.
    fn is_finite(self) -> bool;
}

macro_rules! real {
    ($t:ident) => {
        impl Real for $t {
            const ZERO: Self = 0.0;
            const ONE: Self = 1.0;
            const UNIT_ROUNDOFF: f64 = $t::EPSILON as f64 / 2.0;
            const NAME: &'static str = stringify!($t);

            #[inline]
            fn from_f64(x: f64) -> Self {
                x as Self
            }
            #[inline]
            fn to_f64(self) -> f64 {
                self as f64
            }
            #[inline]
            fn abs(self) -> Self {
                $t::abs(self)
            }
            #[inline]
            fn is_finite(self) -> bool {
                $t::is_finite(self)
            }
        }
    };
}
real!(f32);
real!(f64);
