//! Plans of products, which say what will run.

use catamaran::Plan as ProductPlan;
use catamaran::base::FloatEnv;
use pyo3::prelude::*;

use crate::error::exception;
use crate::options::{Products, word};

/// What a product will do, and why; see `catamaran.plan`.
#[pyclass(frozen, module = "catamaran")]
pub struct Plan {
    plan: ProductPlan,
    /// The arguments of [`plan`], which make the plan again.
    arguments: Py<PyAny>,
}

/// Returns the plan of A^T A, or of A^T B with B of k columns.
#[pyfunction]
#[pyo3(signature = (m, n, k, scalar, products))]
pub fn plan<'py>(
    py: Python<'py>,
    m: usize,
    n: usize,
    k: Option<usize>,
    scalar: &str,
    products: Products<'py>,
) -> PyResult<Plan> {
    let arguments = (m, n, k, scalar, &products.0).into_pyobject(py)?.into_any().unbind();
    let _nearest = FloatEnv::nearest();
    let options = products.options()?;
    let single = word("dtype", scalar, &[("float64", false), ("float32", true)])?;
    let plan = match (k, single) {
        (None, false) => ProductPlan::ata::<f64>(m, n, &options),
        (None, true) => ProductPlan::ata::<f32>(m, n, &options),
        (Some(k), false) => ProductPlan::atb::<f64>(m, n, k, &options),
        (Some(k), true) => ProductPlan::atb::<f32>(m, n, k, &options),
    };
    Ok(Plan { plan: plan.map_err(exception)?, arguments })
}

#[pymethods]
impl Plan {
    /// Returns whether it computes integer products, which give the same bytes on every machine.
    #[getter]
    fn is_exact(&self) -> bool {
        self.plan.is_exact()
    }

    /// Returns whether any product takes fewer multiplications than the classical count.
    #[getter]
    fn is_fast(&self) -> bool {
        self.plan.is_fast()
    }

    /// Returns the scheme in a word or two.
    #[getter]
    fn scheme(&self) -> String {
        self.plan.scheme()
    }

    /// Returns the instruction set of the integer products; None for others.
    #[getter]
    fn isa(&self) -> Option<&'static str> {
        self.plan.isa()
    }

    /// Returns what pickles store, whose reader plans for its own machine.
    fn __reduce__<'py>(&self, py: Python<'py>) -> PyResult<(Bound<'py, PyAny>, Py<PyAny>)> {
        Ok((py.import("catamaran._catamaran")?.getattr("plan")?, self.arguments.clone_ref(py)))
    }

    fn __repr__(&self) -> String {
        self.plan.to_string().trim_end().to_owned()
    }
}
