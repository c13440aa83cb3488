//! The floating-point environment, for what Python's side computes.

use catamaran::base::FloatEnv;
use pyo3::prelude::*;

/// A context in which numbers are rounded to nearest and subnormal ones stay, on its thread.
#[pyclass(unsendable, module = "catamaran")]
pub struct Nearest {
    guard: Option<FloatEnv>,
}

#[pymethods]
impl Nearest {
    #[new]
    fn new() -> Self {
        Self { guard: None }
    }

    fn __enter__(&mut self) {
        self.guard = Some(FloatEnv::nearest());
    }

    #[pyo3(signature = (*_exception))]
    fn __exit__(&mut self, _exception: &Bound<'_, PyAny>) {
        self.guard = None;
    }
}
