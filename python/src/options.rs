//! Words and numbers of Python as options of the library.

use std::path::PathBuf;
use std::sync::atomic::{AtomicUsize, Ordering};

use catamaran::{Accuracy, AtaOptions, Par, SchemeChoice, Uplo, blas};
use catamaran_geometry::mesh::{Boundary, LaplacianKind, LaplacianOptions, MassKind};
use catamaran_geometry::spectral::Orthogonalization;
use numpy::{PyArrayDescrMethods, PyUntypedArrayMethods};
use pyo3::exceptions::{PyOverflowError, PyTypeError, PyValueError};
use pyo3::prelude::*;
use pyo3::types::{PyString, PyTuple};

use crate::array::{Array, untyped};
use crate::error::{exception, refused};

/// Returns the value that a word stands for.
pub fn word<T: Copy>(name: &str, found: &str, known: &[(&str, T)]) -> PyResult<T> {
    if let Some((_, value)) = known.iter().find(|(word, _)| *word == found) {
        return Ok(*value);
    }
    let words: Vec<_> = known.iter().map(|(word, _)| format!("'{word}'")).collect();
    Err(refused(name, format_args!("'{found}' is not one of {}", words.join(", "))))
}

/// Returns the value of an argument; an error names the argument.
pub fn extracted<'py, T>(name: &str, value: &Bound<'py, PyAny>) -> PyResult<T>
where
    T: FromPyObjectOwned<'py>,
{
    let py = value.py();
    value.extract::<T>().map_err(|error| {
        let error: PyErr = error.into();
        let why = format!("{name}: {}", error.value(py));
        if why.starts_with(&format!("{name}: {name}: ")) {
            // Some types know the name of their argument.
            error
        } else if error.is_instance_of::<PyTypeError>(py) {
            PyTypeError::new_err(why)
        } else if error.is_instance_of::<PyOverflowError>(py)
            || error.is_instance_of::<PyValueError>(py)
        {
            PyValueError::new_err(why)
        } else {
            error
        }
    })
}

/// Declares arguments that come as a dictionary, whose keys are the names of the fields; an error
/// names the argument.
macro_rules! arguments {
    ($(#[$doc:meta])* $vis:vis struct $name:ident {
        $($(#[$field_doc:meta])* $field_vis:vis $field:ident: $type:ty,)*
    }) => {
        $(#[$doc])*
        $vis struct $name {
            $($(#[$field_doc])* $field_vis $field: $type,)*
        }

        impl<'py> FromPyObject<'_, 'py> for $name {
            type Error = PyErr;

            fn extract(dict: Borrowed<'_, 'py, PyAny>) -> PyResult<Self> {
                Ok(Self {
                    $($field: $crate::options::extracted(
                        stringify!($field),
                        &dict.get_item(stringify!($field))?,
                    )?,)*
                })
            }
        }
    };
}
pub(crate) use arguments;

/// The most threads of a call that names no number, as threadpoolctl sets it; 0 for all cores.
static LIMIT: AtomicUsize = AtomicUsize::new(0);

/// Sets the number of threads of calls that name none.
#[pyfunction]
pub fn set_num_threads(threads: usize) {
    LIMIT.store(threads, Ordering::Relaxed);
}

/// Returns the number of threads of calls that name none.
#[pyfunction]
pub fn get_num_threads() -> usize {
    default_par().threads()
}

fn default_par() -> Par {
    match LIMIT.load(Ordering::Relaxed) {
        0 => Par::all(),
        limit => Par::Threads(limit.min(Par::all().threads())),
    }
}

/// A number of threads, as an argument; None for the default.
#[derive(Clone, Copy)]
pub struct Threads(Option<i64>);

impl<'py> FromPyObject<'_, 'py> for Threads {
    type Error = PyErr;

    fn extract(threads: Borrowed<'_, 'py, PyAny>) -> PyResult<Self> {
        extracted("threads", &threads).map(Self)
    }
}

/// Returns the threads: all cores by default, or as many as threadpoolctl allows.
pub fn par(threads: Threads) -> PyResult<Par> {
    match threads.0 {
        None => Ok(default_par()),
        Some(1) => Ok(Par::Seq),
        Some(threads) => match usize::try_from(threads) {
            Err(_) | Ok(0) => Err(refused("threads", "must be at least 1")),
            Ok(threads) => Ok(Par::Threads(threads)),
        },
    }
}

/// How products are computed, as a tuple: uplo, scheme, accuracy, reproducible, threads, and the
/// path of a BLAS or None.
pub struct Products<'py>(pub Bound<'py, PyTuple>);

impl<'py> FromPyObject<'_, 'py> for Products<'py> {
    type Error = PyErr;

    fn extract(tuple: Borrowed<'_, 'py, PyAny>) -> PyResult<Self> {
        Ok(Self(tuple.cast::<PyTuple>()?.to_owned()))
    }
}

impl Products<'_> {
    /// As options of the library.
    pub fn options(&self) -> PyResult<AtaOptions<'static>> {
        let [part, scheme, error, reproducible, threads, backend] =
            [0, 1, 2, 3, 4, 5].map(|i| self.0.get_item(i));
        let options = AtaOptions::new()
            .uplo(uplo(&extracted::<String>("uplo", &part?)?)?)
            .scheme(word(
                "scheme",
                &extracted::<String>("scheme", &scheme?)?,
                &SchemeChoice::NAMES,
            )?)
            .accuracy(accuracy(&error?)?)
            .reproducible(extracted("reproducible", &reproducible?)?)
            .par(par(threads?.extract()?)?);
        Ok(match extracted::<Option<PathBuf>>("backend", &backend?)? {
            Some(path) => options.backend(blas::load(&path).map_err(exception)?),
            None => options,
        })
    }
}

/// Returns the part of a symmetric result.
pub fn uplo(name: &str) -> PyResult<Uplo> {
    let known = [("both", Uplo::Both), ("lower", Uplo::Lower), ("upper", Uplo::Upper)];
    word("uplo", name, &known)
}

/// Reads a word, or the factor that errors may grow by.
pub fn accuracy(value: &Bound<'_, PyAny>) -> PyResult<Accuracy> {
    let Ok(name) = value.cast::<PyString>() else {
        let factor = value.extract::<f64>();
        let wrong = |_| PyTypeError::new_err("accuracy: expected a word or a number");
        return Ok(Accuracy::Bounded(factor.map_err(wrong)?));
    };
    let known = [
        ("default", Accuracy::Default),
        ("max", Accuracy::Max),
        ("classical", Accuracy::Classical),
        ("fast", Accuracy::Fast),
    ];
    word("accuracy", name.to_cow()?.as_ref(), &known)
}

/// Returns the Laplacian of a mesh. `boundary` is a word or an array of vertices.
pub fn laplacian(
    kind: &str,
    mass: &str,
    boundary: &Bound<'_, PyAny>,
    par: Par,
) -> PyResult<LaplacianOptions> {
    let mass = word(
        "mass",
        mass,
        &[
            ("barycentric", MassKind::Barycentric),
            ("voronoi", MassKind::MixedVoronoi),
            ("full", MassKind::Consistent),
        ],
    )?;
    Ok(LaplacianOptions::new()
        .kind(laplacian_kind(kind)?)
        .mass(mass)
        .boundary(limits(boundary)?)
        .par(par))
}

/// Returns which triangles a Laplacian is made of.
pub fn laplacian_kind(kind: &str) -> PyResult<LaplacianKind> {
    let known = [
        ("cotangent", LaplacianKind::Cotangent),
        ("intrinsic", LaplacianKind::IntrinsicDelaunay),
        ("tufted", LaplacianKind::Tufted),
    ];
    word("kind", kind, &known)
}

/// Returns where functions are zero: a word or an array of vertices.
pub fn limits(boundary: &Bound<'_, PyAny>) -> PyResult<Boundary> {
    if let Ok(name) = boundary.cast::<PyString>() {
        let known = [("neumann", false), ("dirichlet", true)];
        let dirichlet = word("boundary", name.to_cow()?.as_ref(), &known)?;
        return Ok(if dirichlet { Boundary::Dirichlet } else { Boundary::Neumann });
    }
    Ok(Boundary::Mixed(vertices("boundary", boundary)?))
}

/// Numbers of vertices, from 0; whether a mesh has them is for the library to say.
pub fn vertices(name: &str, object: &Bound<'_, PyAny>) -> PyResult<Vec<u32>> {
    numbers(name, "vertex", object)
}

/// Numbers of faces, as [`vertices`] has those of vertices.
pub fn faces(name: &str, object: &Bound<'_, PyAny>) -> PyResult<Vec<u32>> {
    numbers(name, "face", object)
}

/// Pairs of vertices, a row each.
pub fn pairs(name: &str, object: &Bound<'_, PyAny>) -> PyResult<Vec<[u32; 2]>> {
    let array = Array::<i64>::new(name, object, &[2])?;
    let view = array.view();
    if view.ncols() != 2 {
        return Err(refused(name, format_args!("expected 2 columns, got {}", view.ncols())));
    }
    let number = |v: i64| vertex(name, v);
    (0..view.nrows()).map(|i| Ok([number(view[(i, 0)])?, number(view[(i, 1)])?])).collect()
}

fn numbers(name: &str, of: &str, object: &Bound<'_, PyAny>) -> PyResult<Vec<u32>> {
    let array = untyped(name, object)?;
    if array.dtype().kind() == b'b' {
        // A mask would be the vertices 0 and 1.
        let why = format!("{name}: truth values, expected numbers: numpy.flatnonzero has them");
        return Err(PyTypeError::new_err(why));
    }
    let array = Array::<i64>::new(name, &array, &[1])?;
    let entries = array.entries();
    entries.iter().map(|&number| number_of(name, of, number)).collect()
}

/// Returns the number of a vertex, as [`vertices`] has them.
pub fn vertex(name: &str, number: i64) -> PyResult<u32> {
    number_of(name, "vertex", number)
}

/// Returns the number of a face, as [`faces`] has them.
pub fn face(name: &str, number: i64) -> PyResult<u32> {
    number_of(name, "face", number)
}

fn number_of(name: &str, of: &str, number: i64) -> PyResult<u32> {
    u32::try_from(number)
        .map_err(|_| refused(name, format_args!("{number} is not the number of a {of}")))
}

/// Returns how products of eigenfunctions are orthogonalized.
pub fn orthogonalization(method: &str) -> PyResult<Orthogonalization> {
    let known = [
        ("single_pass", Orthogonalization::SinglePass),
        ("reorthogonalized", Orthogonalization::Reorthogonalized),
        ("rank_revealing", Orthogonalization::RankRevealing),
    ];
    word("method", method, &known)
}
