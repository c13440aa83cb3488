//! Named arrays of f32 in the safetensors format.

use std::borrow::Cow;

use safetensors::{Dtype, SafeTensors, View};

use crate::base::{Error, Result};

/// A matrix that is written.
pub(super) struct Tensor<'a> {
    shape: [usize; 2],
    values: &'a [f32],
}

impl<'a> Tensor<'a> {
    /// `values` in rows of `columns`.
    pub(super) fn new(columns: usize, values: &'a [f32]) -> Self {
        Self { shape: [values.len() / columns.max(1), columns], values }
    }
}

impl View for Tensor<'_> {
    fn dtype(&self) -> Dtype {
        Dtype::F32
    }

    fn shape(&self) -> &[usize] {
        &self.shape
    }

    fn data(&self) -> Cow<'_, [u8]> {
        self.values.iter().flat_map(|x| x.to_le_bytes()).collect::<Vec<u8>>().into()
    }

    fn data_len(&self) -> usize {
        4 * self.values.len()
    }
}

/// The bytes of a file of these tensors; the same tensors give the same bytes.
pub(super) fn to_bytes(tensors: Vec<(&str, Tensor<'_>)>) -> Result<Vec<u8>> {
    safetensors::serialize(tensors, None)
        .map_err(|e| Error::Argument { what: "weights", why: e.to_string() })
}

/// Tensors of a file.
pub(super) struct Tensors<'a>(SafeTensors<'a>);

impl<'a> Tensors<'a> {
    pub(super) fn new(bytes: &'a [u8]) -> Result<Self> {
        SafeTensors::deserialize(bytes).map(Self).map_err(|e| refuse(e.to_string()))
    }

    /// The tensor of this name, with `len` elements, all finite.
    pub(super) fn values(&self, name: &str, len: usize) -> Result<Vec<f32>> {
        let tensor = self.0.tensor(name).map_err(|e| refuse(e.to_string()))?;
        if tensor.dtype() != Dtype::F32 || tensor.data().len() != 4 * len {
            let (dtype, shape) = (tensor.dtype(), tensor.shape());
            return Err(refuse(format!(
                "{name}: {len} elements of F32 are needed, it is {dtype:?} of shape {shape:?}"
            )));
        }
        let values: Vec<f32> =
            tensor.data().as_chunks::<4>().0.iter().map(|x| f32::from_le_bytes(*x)).collect();
        match values.iter().position(|x| !x.is_finite()) {
            Some(at) => Err(refuse(format!("{name}: element {at} is not finite"))),
            None => Ok(values),
        }
    }

    /// The number of elements of a tensor, 0 if there is none.
    pub(super) fn len(&self, name: &str) -> usize {
        self.0.tensor(name).map_or(0, |tensor| tensor.data().len() / 4)
    }
}

fn refuse(why: String) -> Error {
    Error::Argument { what: "weights", why }
}
