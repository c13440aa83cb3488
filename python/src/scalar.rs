//! The scalars of arrays, as numpy knows them.

use numpy::Element;
use numpy::npyffi::NPY_TYPES;

/// A scalar that arrays may have.
pub trait Scalar: Element + Copy + Send + Sync + 'static {
    /// Its number in numpy's list of types.
    const NUMBER: i32;
    /// Its name in messages.
    const NAME: &'static str;
}

macro_rules! scalars {
    ($($type:ty, $number:expr, $name:expr;)*) => {
        $(impl Scalar for $type {
            const NUMBER: i32 = $number as i32;
            const NAME: &'static str = $name;
        })*
    };
}

scalars! {
    f32, NPY_TYPES::NPY_FLOAT, "float32";
    f64, NPY_TYPES::NPY_DOUBLE, "float64";
    catamaran::faer::c32, NPY_TYPES::NPY_CFLOAT, "complex64";
    catamaran::faer::c64, NPY_TYPES::NPY_CDOUBLE, "complex128";
    u8, NPY_TYPES::NPY_UBYTE, "uint8";
    i64, NPY_TYPES::NPY_LONG, "int64";
    usize, NPY_TYPES::NPY_ULONG, "uint64";
}
