//! Bases of eigenfunctions and of their products, functional maps, transfer of functions.

use catamaran::Par;
use catamaran::base::{FloatEnv, Progress};
use catamaran::faer::Mat;
use catamaran::sparse::{EigenOptions, Mass, eigs};
use catamaran_geometry::mesh::{Boundary, LaplacianOptions, laplacian};
use catamaran_geometry::spectral::descriptors::{
    global_point_signature, heat_kernel_signature, heat_times, wave_kernel_signature, wave_scales,
};
use catamaran_geometry::spectral::functional_map::{
    FoundMap, MapFit, icp, map_from_points, points_from_map, search_map, zoomout,
};
use catamaran_geometry::spectral::{
    Eigenbasis as Basis, Orthogonalization, ProductBasis, ProductBasisOptions, ProductMap,
    ShapeOptions, Transfer, add_coefficient, filter, shape_from_spectrum as deformed,
    transfer_details as details, transform_by_columns, transform_of_all_products,
};
use pyo3::prelude::*;

use crate::array::{Array, from_matrix, from_vec};
use crate::error::{exception, refused};
use crate::mesh::{Mesh, arrays, mesh, numbers};
use crate::options::{Threads, laplacian_kind, orthogonalization, pairs, par, vertices, word};
use crate::sparse::{Parts, mass as mass_of, mass_parts};
use crate::surface::{Pieces, Surface};
use crate::task::{Length, run};

/// Eigenfunctions of a mesh; see `catamaran.Eigenbasis`.
#[pyclass(frozen, subclass, module = "catamaran._catamaran")]
pub struct Eigenbasis {
    basis: Basis,
    pieces: Pieces,
}

/// Refuses fewer eigenfunctions than components: a component without its constant function would
/// move to the origin.
fn check_count(len: usize, (count, _, left, ..): Pieces) -> catamaran::Result<()> {
    if len >= count || count < 2 {
        return Ok(());
    }
    let hint = match left < count {
        true => format!("; weld=True joins them into {left}"),
        false => String::new(),
    };
    let why = format!(
        "{count} components, each with a constant function of its own: {len} eigenfunctions, the \
         constant one included, are too few, {count} or more are enough{hint}"
    );
    Err(catamaran::Error::Argument { what: "k", why })
}

/// A basis as arrays, and the components of the mesh: values, functions, and the diagonal of the
/// mass.
type BasisParts<'py> = (Bound<'py, PyAny>, Bound<'py, PyAny>, Bound<'py, PyAny>, Pieces);

/// Returns the first eigenfunctions of a mesh; see `catamaran.Eigenbasis`.
#[pyfunction]
#[pyo3(signature = (v, f, k, kind, weld, threads, progress))]
pub fn eigenbasis<'py>(
    py: Python<'py>,
    v: &Bound<'py, PyAny>,
    f: &Bound<'py, PyAny>,
    k: usize,
    kind: &str,
    weld: bool,
    threads: Threads,
    progress: Option<Py<PyAny>>,
) -> PyResult<BasisParts<'py>> {
    let (surface, par) = (Surface::new(v, f, weld)?, par(threads)?);
    let options = LaplacianOptions::new().kind(laplacian_kind(kind)?).par(par);
    let (pairs, mass, pieces) = run(py, Length::Long, progress, move |progress| {
        let found = laplacian(&surface.mesh, &options)?;
        let missing = (0..found.vertices).find(|&v| found.kept.get(v) != Some(&v));
        if let Some(vertex) = missing {
            let element = format!("vertex {}", surface.firsts()(vertex));
            return Err(catamaran::Error::Mesh { what: "it is in no face".into(), element });
        }
        let pieces = surface.pieces(&Boundary::Neumann)?;
        check_count(k, pieces)?;
        let search = EigenOptions::new().k(k).par(par).progress(progress);
        let mut pairs = eigs(found.stiffness.view(), &found.mass, &search)?;
        pairs.vectors = surface.extend(pairs.vectors);
        Ok((pairs, surface.shares(found.mass), pieces))
    })?;
    // Of triangles, as the options have it.
    let Mass::Lumped(masses) = mass else { return Err(refused("mass", "is not a diagonal")) };
    let functions = from_matrix(py, pairs.vectors.as_ref())?.into_any();
    let masses = from_vec(py, masses).into_any();
    Ok((from_vec(py, pairs.values).into_any(), functions, masses, pieces))
}

#[pymethods]
impl Eigenbasis {
    /// Makes a basis of the arrays that [`eigenbasis`] returns.
    #[new]
    #[pyo3(signature = (values, functions, mass, pieces))]
    fn new(
        values: &Bound<'_, PyAny>,
        functions: &Bound<'_, PyAny>,
        mass: &Bound<'_, PyAny>,
        pieces: Pieces,
    ) -> PyResult<Self> {
        let values = Array::<f64>::new("values", values, &[1])?.entries().into_owned();
        let functions = Array::<f64>::new("functions", functions, &[2])?.view().to_owned();
        let mass = mass_of(Some(mass), functions.nrows())?;
        let _nearest = FloatEnv::nearest();
        let basis = Basis::new(values, functions, mass).map_err(exception)?;
        Ok(Self { basis, pieces })
    }

    #[getter]
    fn _pieces(&self) -> Pieces {
        self.pieces
    }

    fn __len__(&self) -> usize {
        self.basis.len()
    }

    #[getter]
    fn values<'py>(&self, py: Python<'py>) -> Bound<'py, PyAny> {
        from_vec(py, self.basis.values().to_vec()).into_any()
    }

    #[getter]
    fn functions<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyAny>> {
        Ok(from_matrix(py, self.basis.functions())?.into_any())
    }

    fn _mass<'py>(&self, py: Python<'py>) -> Parts<'py> {
        mass_parts(py, self.basis.basis().mass().clone())
    }

    /// Functions with each coefficient multiplied by its gain, and what is left by `rest`.
    #[pyo3(signature = (f, gains, rest, threads))]
    fn _filter<'py>(
        &self,
        py: Python<'py>,
        f: &Bound<'py, PyAny>,
        gains: &Bound<'py, PyAny>,
        rest: f64,
        threads: Threads,
    ) -> PyResult<Bound<'py, PyAny>> {
        let f = Array::<f64>::new("functions", f, &[1, 2])?;
        let gains = Array::<f64>::new("gain", gains, &[1])?.entries().into_owned();
        let (basis, view, par) = (self.basis.basis(), f.view(), par(threads)?);
        let found = run(py, Length::Long, None, move |_| filter(basis, view, &gains, rest, par))?;
        Ok(from_matrix(py, found.as_ref())?.into_any())
    }

    /// Functions with `amount` more of one coefficient.
    #[pyo3(signature = (f, index, amount))]
    fn _add_coefficient<'py>(
        &self,
        py: Python<'py>,
        f: &Bound<'py, PyAny>,
        index: usize,
        amount: f64,
    ) -> PyResult<Bound<'py, PyAny>> {
        let f = Array::<f64>::new("functions", f, &[1, 2])?;
        let _nearest = FloatEnv::nearest();
        let found = add_coefficient(self.basis.basis(), f.view(), index, amount);
        Ok(from_matrix(py, found.map_err(exception)?.as_ref())?.into_any())
    }

    /// Returns global point signatures.
    fn _point_signature<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyAny>> {
        let _nearest = FloatEnv::nearest();
        let found = global_point_signature(self.basis.values(), self.basis.functions());
        Ok(from_matrix(py, found.map_err(exception)?.as_ref())?.into_any())
    }

    /// Returns heat kernel signatures at these times, or at the usual ones, and the times.
    #[pyo3(signature = (times, count, threads))]
    fn _heat_signature<'py>(
        &self,
        py: Python<'py>,
        times: Option<&Bound<'py, PyAny>>,
        count: usize,
        threads: Threads,
    ) -> PyResult<(Bound<'py, PyAny>, Bound<'py, PyAny>)> {
        let (values, functions) = (self.basis.values(), self.basis.functions());
        let _nearest = FloatEnv::nearest();
        let times = match times {
            Some(times) => Array::<f64>::new("times", times, &[1])?.entries().into_owned(),
            None => heat_times(values, count).map_err(exception)?,
        };
        let (par, at) = (par(threads)?, &times);
        let found = run(py, Length::Long, None, move |_| {
            heat_kernel_signature(values, functions, at, par)
        })?;
        Ok((from_matrix(py, found.as_ref())?.into_any(), from_vec(py, times).into_any()))
    }

    /// Returns wave kernel signatures at the usual energies, and the energies.
    #[pyo3(signature = (count, threads))]
    fn _wave_signature<'py>(
        &self,
        py: Python<'py>,
        count: usize,
        threads: Threads,
    ) -> PyResult<(Bound<'py, PyAny>, Bound<'py, PyAny>)> {
        let (values, functions) = (self.basis.values(), self.basis.functions());
        let _nearest = FloatEnv::nearest();
        let scales = wave_scales(values, count).map_err(exception)?;
        let (par, at) = (par(threads)?, &scales);
        let found = run(py, Length::Long, None, move |_| {
            wave_kernel_signature(values, functions, at, par)
        })?;
        Ok((from_matrix(py, found.as_ref())?.into_any(), from_vec(py, scales.energies).into_any()))
    }
}

/// A product basis as arrays: functions, R, kept products, factors of all products, from 1, and 0
/// where there are fewer.
type Products<'py> = (Bound<'py, PyAny>, Bound<'py, PyAny>, Bound<'py, PyAny>, Vec<Vec<usize>>);

/// Returns orthogonalized products of eigenfunctions; see `catamaran.eigenproducts`.
#[pyfunction]
#[pyo3(signature = (basis, order, method, threads, progress))]
pub fn eigenproducts<'py>(
    py: Python<'py>,
    basis: &Bound<'py, Eigenbasis>,
    order: usize,
    method: &str,
    threads: Threads,
    progress: Option<Py<PyAny>>,
) -> PyResult<Products<'py>> {
    let (method, par) = (orthogonalization(method)?, par(threads)?);
    let basis = &basis.get().basis;
    let found = run(py, Length::Long, progress, move |progress| {
        let options =
            ProductBasisOptions::new().orthogonalization(method).par(par).progress(progress);
        ProductBasis::new(basis, order, &options)
    })?;
    let kept: Vec<i64> = found.kept().iter().map(|&column| column as i64).collect();
    let factors = found.kept().iter().filter_map(|&index| found.products().factors(index));
    Ok((
        from_matrix(py, found.functions())?.into_any(),
        from_matrix(py, found.r())?.into_any(),
        from_vec(py, kept).into_any(),
        factors.collect(),
    ))
}

/// Iterations of ICP, at most.
const ITERATIONS: usize = 20;

/// Eigenfunctions that ZoomOut adds at a time to a map that was fitted.
const STEP: usize = 1;

#[derive(Clone, Copy)]
enum Refinement {
    None,
    Icp,
    ZoomOut,
}

/// A functional map, the points that it says correspond, and why it may be wrong; see
/// `catamaran.functional_map`.
#[pyfunction]
#[pyo3(signature = (
    source, target, meshes, k, landmarks, functions, signatures, commutativity, refine, threads,
    progress
))]
pub fn functional_map<'py>(
    py: Python<'py>,
    source: &Bound<'py, Eigenbasis>,
    target: &Bound<'py, Eigenbasis>,
    meshes: Option<(Mesh<'py>, Mesh<'py>)>,
    k: (usize, usize),
    landmarks: Option<&Bound<'py, PyAny>>,
    functions: Option<(Bound<'py, PyAny>, Bound<'py, PyAny>)>,
    signatures: bool,
    commutativity: f64,
    refine: &str,
    threads: Threads,
    progress: Option<Py<PyAny>>,
) -> PyResult<(Bound<'py, PyAny>, Bound<'py, PyAny>, Option<&'static str>)> {
    let par = par(threads)?;
    for (basis, len) in [(source, k.0), (target, k.1)] {
        check_count(len, basis.get().pieces).map_err(exception)?;
    }
    let known =
        [("none", Refinement::None), ("icp", Refinement::Icp), ("zoomout", Refinement::ZoomOut)];
    let refine = word("refine", refine, &known)?;
    let landmarks = landmarks.map(|rows| pairs("landmarks", rows)).transpose()?;
    let known = functions
        .map(|(f, g)| {
            let f = Array::<f64>::new("functions", &f, &[2])?;
            Ok::<_, PyErr>((f, Array::<f64>::new("functions", &g, &[2])?))
        })
        .transpose()?;
    let known = known.as_ref().map(|(f, g)| (f.view(), g.view()));
    // Without a correspondence the map is searched for.
    let meshes = meshes
        .map(|((v, f), (w, g))| Ok::<_, PyErr>((mesh(&v, &f)?, mesh(&w, &g)?)))
        .transpose()?;
    let (source, target) = (&source.get().basis, &target.get().basis);
    let found = run(py, Length::Long, progress, move |progress| {
        let low = (source.truncated(k.0)?, target.truncated(k.1)?);
        if let Some((from, to)) = &meshes {
            let (searching, refining) = (progress.part(0.0..0.5), progress.part(0.5..1.0));
            let found = search_map((from, source), (to, target), par, searching)?;
            let (bases, doubt) = ((low.0.basis(), low.1.basis()), found.doubt());
            let (c, step) = match refine {
                Refinement::ZoomOut => (found.map, FoundMap::STEP),
                _ => (found.between(bases, (source, target), par, Progress::none())?, STEP),
            };
            let found = refined(c, (source, target), &low, (refine, step), par, refining)?;
            return Ok((found, doubt));
        }
        let mut fit = MapFit::new(&low.0, &low.1, par);
        if let Some(pairs) = &landmarks {
            let pairs: Vec<(u32, u32)> = pairs.iter().map(|&[v, w]| (v, w)).collect();
            fit.landmarks(&pairs)?;
        }
        if let Some((f, g)) = known {
            fit.functions(f, g)?;
        }
        if signatures {
            fit.signatures(source, target)?;
        }
        let c = fit.solve(commutativity)?;
        Ok((refined(c, (source, target), &low, (refine, STEP), par, progress)?, None))
    })?;
    let ((map, points), doubt) = found;
    Ok((from_matrix(py, map.as_ref())?.into_any(), numbers(py, points), doubt))
}

fn refined(
    c: Mat<f64>,
    all: (&Basis, &Basis),
    low: &(Basis, Basis),
    (refine, step): (Refinement, usize),
    par: Par,
    progress: Progress<'_>,
) -> catamaran::Result<(Mat<f64>, Vec<u32>)> {
    let (view, bases) = (c.as_ref(), (low.0.basis(), low.1.basis()));
    let found = match refine {
        Refinement::None => {
            let points = points_from_map(view, bases.0, bases.1, par, progress)?;
            return Ok((c, points));
        }
        Refinement::Icp => icp(view, low.0.basis(), low.1.basis(), ITERATIONS, par, progress)?,
        Refinement::ZoomOut => zoomout(view, all.0.basis(), all.1.basis(), step, par, progress)?,
    };
    Ok((found.map, found.points))
}

/// Returns the map of orthogonalized products that a functional map implies; see
/// `catamaran.product_map`.
#[pyfunction]
#[pyo3(signature = (source, target, map, order, method, all, threads, progress))]
pub fn product_map<'py>(
    py: Python<'py>,
    source: &Bound<'py, Eigenbasis>,
    target: &Bound<'py, Eigenbasis>,
    map: &Bound<'py, PyAny>,
    order: usize,
    method: &str,
    all: bool,
    threads: Threads,
    progress: Option<Py<PyAny>>,
) -> PyResult<Bound<'py, PyAny>> {
    let (method, par) = (orthogonalization(method)?, par(threads)?);
    let map = Array::<f64>::new("map", map, &[2])?;
    let (source, target, c) = (&source.get().basis, &target.get().basis, map.view());
    let found = run(py, Length::Long, progress, move |progress| {
        let (source, target) = (source.truncated(c.ncols())?, target.truncated(c.nrows())?);
        let products = |basis: &Basis, part| {
            let options = ProductBasisOptions::new().orthogonalization(method).par(par);
            ProductBasis::new(basis, order, &options.progress(progress.part(part)))
        };
        let (from, to) = (products(&source, 0.0..0.4)?, products(&target, 0.4..0.8)?);
        let map = ProductMap::new(c, &source, &target, order)?;
        match all {
            true => transform_of_all_products(&map, &from, &to, par),
            false => transform_by_columns(&map, &from, &to, par),
        }
    })?;
    Ok(from_matrix(py, found.as_ref())?.into_any())
}

/// How functions go from a mesh to another one.
struct Route {
    points: Vec<u32>,
    k: (usize, usize),
    order: usize,
    method: Orthogonalization,
    par: Par,
}

impl Route {
    /// Calls `work` with the transfer between the products of eigenfunctions.
    fn with_transfer<R>(
        &self,
        source: &Basis,
        target: &Basis,
        progress: Progress<'_>,
        work: impl FnOnce(&Transfer<'_>) -> catamaran::Result<R>,
    ) -> catamaran::Result<R> {
        let basis = |basis: &Basis, k: usize, part| -> catamaran::Result<ProductBasis> {
            let options = ProductBasisOptions::new()
                .orthogonalization(self.method)
                .par(self.par)
                .progress(progress.part(part));
            ProductBasis::new(&basis.truncated(k)?, self.order, &options)
        };
        let (from, to) = (basis(source, self.k.0, 0.0..0.4)?, basis(target, self.k.1, 0.4..0.8)?);
        let map = map_from_points(&self.points, from.basis(), to.basis(), self.par)?;
        work(&Transfer::new(from.basis(), to.basis(), map)?)
    }
}

/// Functions on the target; see `catamaran.transfer`.
#[pyfunction]
#[pyo3(signature = (source, target, functions, points, k, order, method, threads, progress))]
pub fn transfer<'py>(
    py: Python<'py>,
    source: &Bound<'py, Eigenbasis>,
    target: &Bound<'py, Eigenbasis>,
    functions: &Bound<'py, PyAny>,
    points: &Bound<'py, PyAny>,
    k: (usize, usize),
    order: usize,
    method: &str,
    threads: Threads,
    progress: Option<Py<PyAny>>,
) -> PyResult<Bound<'py, PyAny>> {
    let (method, par) = (orthogonalization(method)?, par(threads)?);
    for (basis, len) in [(source, k.0), (target, k.1)] {
        check_count(len, basis.get().pieces).map_err(exception)?;
    }
    let route = Route { points: vertices("points", points)?, k, order, method, par };
    let f = Array::<f64>::new("functions", functions, &[1, 2])?;
    let (source, target, view) = (&source.get().basis, &target.get().basis, f.view());
    let found = run(py, Length::Long, progress, move |progress| {
        route.with_transfer(source, target, progress, |transfer| transfer.apply(view, par))
    })?;
    Ok(from_matrix(py, found.as_ref())?.into_any())
}

/// The vertices of the target with the details of the source; see `catamaran.transfer_details`.
/// Each mesh comes with its basis.
#[pyfunction]
#[pyo3(signature = (
    source_mesh, target_mesh, source, target, smooth, points, k, order, method, threads, progress
))]
pub fn transfer_details<'py>(
    py: Python<'py>,
    source_mesh: Mesh<'py>,
    target_mesh: Mesh<'py>,
    source: &Bound<'py, Eigenbasis>,
    target: &Bound<'py, Eigenbasis>,
    smooth: usize,
    points: &Bound<'py, PyAny>,
    k: (usize, usize),
    order: usize,
    method: &str,
    threads: Threads,
    progress: Option<Py<PyAny>>,
) -> PyResult<Mesh<'py>> {
    let (method, par) = (orthogonalization(method)?, par(threads)?);
    for (basis, len) in [(source, k.0.min(smooth)), (target, k.1.min(smooth))] {
        check_count(len, basis.get().pieces).map_err(exception)?;
    }
    let route = Route { points: vertices("points", points)?, k, order, method, par };
    let meshes = (mesh(&source_mesh.0, &source_mesh.1)?, mesh(&target_mesh.0, &target_mesh.1)?);
    let (source, target) = (&source.get().basis, &target.get().basis);
    let found = run(py, Length::Long, progress, move |progress| {
        let low = (source.truncated(smooth)?, target.truncated(smooth)?);
        route.with_transfer(source, target, progress, |transfer| {
            details(&meshes.0, &meshes.1, (low.0.basis(), low.1.basis()), transfer, par)
        })
    })?;
    arrays(py, found)
}

/// Returns a template whose first eigenvalues are these: the mesh, its eigenvalues, their
/// difference and the number of steps; see `catamaran.shape_from_spectrum`.
#[pyfunction]
#[pyo3(signature = (v, f, eigenvalues, steps, tolerance, threads, progress))]
pub fn shape_from_spectrum<'py>(
    py: Python<'py>,
    v: &Bound<'py, PyAny>,
    f: &Bound<'py, PyAny>,
    eigenvalues: &Bound<'py, PyAny>,
    steps: usize,
    tolerance: f64,
    threads: Threads,
    progress: Option<Py<PyAny>>,
) -> PyResult<(Mesh<'py>, Bound<'py, PyAny>, f64, usize)> {
    let (template, par) = (mesh(v, f)?, par(threads)?);
    let wanted = Array::<f64>::new("eigenvalues", eigenvalues, &[1])?.entries().into_owned();
    let found = run(py, Length::Long, progress, move |progress| {
        let options =
            ShapeOptions::new().steps(steps).tolerance(tolerance).par(par).progress(progress);
        deformed(&template, &wanted, &options)
    })?;
    let values = from_vec(py, found.eigenvalues).into_any();
    Ok((arrays(py, found.mesh)?, values, found.error, found.steps))
}
