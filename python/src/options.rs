//! Words and numbers of Python as options of the library.

use catamaran::{Accuracy, AtaOptions, Par, SchemeChoice, Uplo};
use catamaran_geometry::mesh::{Boundary, LaplacianKind, LaplacianOptions, MassKind};
use catamaran_geometry::spectral::Orthogonalization;
use pyo3::exceptions::PyTypeError;
use pyo3::prelude::*;
use pyo3::types::PyString;

use crate::array::Array;
use crate::error::refused;

/// The value that a word stands for.
pub fn word<T: Copy>(name: &str, found: &str, known: &[(&str, T)]) -> PyResult<T> {
    if let Some((_, value)) = known.iter().find(|(word, _)| *word == found) {
        return Ok(*value);
    }
    let words: Vec<_> = known.iter().map(|(word, _)| format!("'{word}'")).collect();
    Err(refused(name, format_args!("'{found}' is not one of {}", words.join(", "))))
}

/// Threads: all cores by default.
pub fn par(threads: Option<i64>) -> PyResult<Par> {
    match threads {
        None => Ok(Par::all()),
        Some(1) => Ok(Par::Seq),
        Some(threads) => match usize::try_from(threads) {
            Err(_) | Ok(0) => Err(refused("threads", "must be at least 1")),
            Ok(threads) => Ok(Par::Threads(threads)),
        },
    }
}

/// How products are computed, as a tuple: uplo, scheme, accuracy, reproducible, threads.
#[derive(FromPyObject)]
pub struct Products<'py>(String, String, Bound<'py, PyAny>, bool, Option<i64>);

impl Products<'_> {
    /// As options of the library.
    pub fn options(&self) -> PyResult<AtaOptions<'static>> {
        let Self(part, scheme, error, reproducible, threads) = self;
        Ok(AtaOptions::new()
            .uplo(uplo(part)?)
            .scheme(word("scheme", scheme, &SchemeChoice::NAMES)?)
            .accuracy(accuracy(error)?)
            .reproducible(*reproducible)
            .par(par(*threads)?))
    }
}

/// The part of a symmetric result.
pub fn uplo(name: &str) -> PyResult<Uplo> {
    let known = [("both", Uplo::Both), ("lower", Uplo::Lower), ("upper", Uplo::Upper)];
    word("uplo", name, &known)
}

/// A word, or the factor that errors may grow by.
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

/// The Laplacian of a mesh. `boundary` is a word or an array of vertices.
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

/// Which triangles a Laplacian is made of.
pub fn laplacian_kind(kind: &str) -> PyResult<LaplacianKind> {
    let known = [
        ("cotangent", LaplacianKind::Cotangent),
        ("intrinsic", LaplacianKind::IntrinsicDelaunay),
        ("tufted", LaplacianKind::Tufted),
    ];
    word("kind", kind, &known)
}

fn limits(boundary: &Bound<'_, PyAny>) -> PyResult<Boundary> {
    if let Ok(name) = boundary.cast::<PyString>() {
        let known = [("neumann", false), ("dirichlet", true)];
        let dirichlet = word("boundary", name.to_cow()?.as_ref(), &known)?;
        return Ok(if dirichlet { Boundary::Dirichlet } else { Boundary::Neumann });
    }
    Ok(Boundary::Mixed(vertices("boundary", boundary)?))
}

/// Numbers of vertices, from 0; whether a mesh has them is for the library to say.
pub fn vertices(name: &str, object: &Bound<'_, PyAny>) -> PyResult<Vec<u32>> {
    let array = Array::<i64>::new(name, object, &[1])?;
    let entries = array.entries();
    let numbers = entries.iter().map(|&v| {
        u32::try_from(v)
            .map_err(|_| refused(name, format_args!("{v} is not the number of a vertex")))
    });
    numbers.collect()
}

/// How products of eigenfunctions are orthogonalized.
pub fn orthogonalization(method: &str) -> PyResult<Orthogonalization> {
    let known = [
        ("single_pass", Orthogonalization::SinglePass),
        ("reorthogonalized", Orthogonalization::Reorthogonalized),
        ("rank_revealing", Orthogonalization::RankRevealing),
    ];
    word("method", method, &known)
}
