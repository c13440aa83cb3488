//! Named arrays in the safetensors format, in single or half precision, or of whole numbers.

use std::borrow::Cow;

use half::f16;
use safetensors::{Dtype, SafeTensors, View};

use catamaran::base::{Error, Result};

/// A matrix to be written.
pub(super) struct Tensor<'a> {
    dtype: Dtype,
    shape: [usize; 2],
    values: &'a [f32],
}

impl<'a> Tensor<'a> {
    /// Creates a tensor of `values` in rows of `columns`.
    pub(super) fn new(columns: usize, values: &'a [f32]) -> Self {
        let shape = [values.len() / columns.max(1), columns];
        Self { dtype: Dtype::F32, shape, values }
    }

    /// Creates a tensor in half precision, of numbers that are [`rounded`].
    pub(super) fn half(columns: usize, values: &'a [f32]) -> Self {
        Self { dtype: Dtype::F16, ..Self::new(columns, values) }
    }

    /// Creates a tensor of whole numbers from -127 to 127.
    pub(super) fn whole(columns: usize, values: &'a [f32]) -> Self {
        Self { dtype: Dtype::I8, ..Self::new(columns, values) }
    }
}

/// Returns the nearest number in half precision, with an absolute value of at most 65504.
pub(super) fn rounded(x: f32) -> f32 {
    f16::from_f32(x.clamp(f16::MIN.to_f32(), f16::MAX.to_f32())).to_f32()
}

impl View for Tensor<'_> {
    fn dtype(&self) -> Dtype {
        self.dtype
    }

    fn shape(&self) -> &[usize] {
        &self.shape
    }

    fn data(&self) -> Cow<'_, [u8]> {
        let values = self.values.iter();
        let bytes: Vec<u8> = match self.dtype {
            Dtype::F16 => values.flat_map(|&x| f16::from_f32(x).to_le_bytes()).collect(),
            Dtype::I8 => values.map(|&x| x as i8 as u8).collect(),
            _ => values.flat_map(|x| x.to_le_bytes()).collect(),
        };
        bytes.into()
    }

    fn data_len(&self) -> usize {
        self.values.len() * self.dtype.bitsize() / 8
    }
}

/// Returns the bytes of a file with these tensors; the same tensors give the same bytes.
pub(super) fn to_bytes(tensors: Vec<(&str, Tensor<'_>)>) -> Result<Vec<u8>> {
    safetensors::serialize(tensors, None)
        .map_err(|e| Error::Argument { what: "weights", why: e.to_string() })
}

/// The tensors of a file.
pub(super) struct Tensors<'a>(SafeTensors<'a>);

impl<'a> Tensors<'a> {
    pub(super) fn new(bytes: &'a [u8]) -> Result<Self> {
        SafeTensors::deserialize(bytes).map(Self).map_err(|e| refuse(e.to_string()))
    }

    /// Returns the values of the tensor of this name, with `len` elements, all finite.
    pub(super) fn values(&self, name: &str, len: usize) -> Result<Vec<f32>> {
        let tensor = self.0.tensor(name).map_err(|e| refuse(e.to_string()))?;
        let data = tensor.data();
        let values: Vec<f32> = match tensor.dtype() {
            Dtype::F32 => data.as_chunks().0.iter().map(|x| f32::from_le_bytes(*x)).collect(),
            Dtype::F16 => {
                data.as_chunks().0.iter().map(|x| f16::from_le_bytes(*x).to_f32()).collect()
            }
            Dtype::I8 => data.iter().map(|&x| f32::from(x as i8)).collect(),
            other => return Err(refuse(format!("{name}: must be F32, F16 or I8, is {other:?}"))),
        };
        if values.len() != len {
            let shape = tensor.shape();
            return Err(refuse(format!(
                "{name}: must have {len} elements, has the shape {shape:?}"
            )));
        }
        match values.iter().position(|x| !x.is_finite()) {
            Some(at) => Err(refuse(format!("{name}: element {at} is not finite"))),
            None => Ok(values),
        }
    }

    /// Returns the number of elements of a tensor; 0 if the tensor is missing.
    pub(super) fn len(&self, name: &str) -> usize {
        self.0.tensor(name).map_or(0, |tensor| tensor.shape().iter().product())
    }
}

fn refuse(why: String) -> Error {
    Error::Argument { what: "weights", why }
}
