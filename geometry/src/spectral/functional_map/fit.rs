//! Fits a functional map to functions that correspond (Ovsjanikov et al. 2012).

use std::sync::atomic::{AtomicBool, Ordering};

use faer::{Mat, MatMut, MatRef, Scale};

use super::operators::{Equations, Operators, multiplication};
use crate::spectral::basis::{Basis, times_mass};
use crate::spectral::dense;
use crate::spectral::descriptors::{
    heat_kernel, heat_kernel_signature, heat_times, wave_kernel_signature, wave_scales,
};
use crate::spectral::eigenbasis::Eigenbasis;
use catamaran::base::{Error, Par, Progress, Result, Tracker, at_least_zero};
use catamaran::dense::{for_row_blocks, zeros};

/// Number of heat kernels per landmark, from narrow to wide.
const SCALES: usize = 8;

/// Number of heat kernel signatures, and of wave kernel signatures.
const SIGNATURES: usize = 20;

/// The time of the heat kernels around landmarks that a map commutes with, as a share of the area.
const KERNEL_TIME: f64 = 1e-2;

/// Share of the mean diagonal entry that is added to the diagonal of the equations. With fewer
/// functions than unknowns, and no commutativity, there are many solutions, of which this selects
/// the least one.
const RIDGE: f64 = 1e-12;

/// Share of the progress of a fit with operators that the solution of the rows takes.
const ROWS_SHARE: f64 = 0.1;

/// A least-squares fit of a functional map C between two eigenbases, from functions known on both
/// meshes.
///
/// Minimizes `|C A - B|^2 / |A|^2 + weight |C L - L' C|^2`, where the columns of A and B are the
/// coefficients of the corresponding functions and L, L' the eigenvalues, divided by the largest
/// one: isometries commute with Laplacians. Rows of C are independent of each other and solved for
/// one by one. Where both bases have the constant, it is mapped to itself exactly.
/// [`MapFit::operators`] adds a term that couples the rows; conjugate gradients then solve for all
/// of them.
///
/// ```
/// use catamaran_geometry::spectral::{Eigenbasis, coordinates, functional_map::MapFit};
/// use catamaran_geometry::prelude::*;
/// use catamaran_geometry::mesh::families;
///
/// # let mesh = families::icosphere(2)?;
/// # let operator = laplacian(&mesh, &LaplacianOptions::new())?;
/// # let pairs = eigs(operator.stiffness.view(), &operator.mass, &EigenOptions::new().k(4))?;
/// # let basis = Eigenbasis::new(pairs.values, pairs.vectors, operator.mass)?;
/// // From a sphere to itself, with the same functions and landmarks on both sides.
/// let f = coordinates(&mesh);
/// let mut fit = MapFit::new(&basis, &basis, Par::Seq);
/// fit.functions(f.as_ref(), f.as_ref())?;
/// fit.landmarks(&[(12, 12), (150, 150)])?;
/// let c = fit.solve(MapFit::COMMUTATIVITY)?;
/// assert!((c - Mat::<f64>::identity(4, 4)).norm_max() < 1e-3);
/// # Ok::<(), catamaran::Error>(())
/// ```
pub struct MapFit<'a> {
    source: &'a Eigenbasis,
    target: &'a Eigenbasis,
    par: Par,
    progress: Progress<'a>,
    known: Correspondences,
}

/// The correspondences that were added to a fit.
#[derive(Default)]
pub struct Correspondences {
    /// Coefficients of the functions, one function after the other.
    a: Vec<f64>,
    b: Vec<f64>,
    operators: Vec<Operators>,
}

impl<'a> MapFit<'a> {
    /// A usual weight of the commutativity with the Laplacians.
    pub const COMMUTATIVITY: f64 = 1e-3;

    /// A usual weight of the commutativity with multiplications by functions.
    pub const MULTIPLICATIONS: f64 = 0.1;

    /// Creates a fit of maps from `source` to `target`, without functions yet.
    pub fn new(source: &'a Eigenbasis, target: &'a Eigenbasis, par: Par) -> Self {
        Self::resumed(source, target, par, Correspondences::default())
    }

    /// Creates a fit that continues with the correspondences of an earlier fit between the same
    /// bases, which were borrowed in the meantime.
    #[doc(hidden)]
    pub fn resumed(
        source: &'a Eigenbasis,
        target: &'a Eigenbasis,
        par: Par,
        known: Correspondences,
    ) -> Self {
        Self { source, target, par, progress: Progress::none(), known }
    }

    /// Returns the correspondences that were added.
    #[doc(hidden)]
    pub fn into_known(self) -> Correspondences {
        self.known
    }

    /// Sets a callback for the progress of [`MapFit::solve`], which may cancel.
    pub fn progress(self, progress: impl Into<Progress<'a>>) -> Self {
        Self { progress: progress.into(), ..self }
    }

    /// Adds functions: each column of `f`, n_source x c, corresponds to that of `g`, n_target x c.
    /// Each pair is scaled to norm 1, so that all count the same.
    ///
    /// # Errors
    /// [`Error::Shape`] when the numbers of rows and vertices, or of columns, differ,
    /// [`Error::NonFinite`].
    pub fn functions(&mut self, f: MatRef<'_, f64>, g: MatRef<'_, f64>) -> Result<()> {
        let expected = (self.target.basis().vertices(), f.ncols());
        Error::check_shape("target functions", expected, g.shape())?;
        let a = self.source.analysis(f, self.par)?;
        let b = self.target.analysis(g, self.par)?;
        self.add(a.as_ref(), b.as_ref());
        Ok(())
    }

    /// Adds the condition that C commutes with multiplications by corresponding functions, as
    /// [`MapFit::functions`] takes them (Nogneng and Ovsjanikov 2017): `weight` times the mean of
    /// `|C D - D' C|^2`, where D and D' multiply by a pair of functions, scaled to mean square 1.
    /// This way, a function determines the map far better than by its coefficients alone: few
    /// functions suffice for a large map.
    ///
    /// # Errors
    /// As [`MapFit::functions`]; [`Error::Argument`] for a weight that is not finite or below 0, or
    /// a mesh without area.
    pub fn operators(&mut self, f: MatRef<'_, f64>, g: MatRef<'_, f64>, weight: f64) -> Result<()> {
        let (n, m) = (self.source.basis().vertices(), self.target.basis().vertices());
        Error::check_shape("source functions", (n, f.ncols()), f.shape())?;
        Error::check_shape("target functions", (m, f.ncols()), g.shape())?;
        dense::check_finite("source functions", f)?;
        dense::check_finite("target functions", g)?;
        at_least_zero("weight", weight)?;
        for j in 0..f.ncols() {
            let (f, g) = (f.subcols(j, 1), g.subcols(j, 1));
            let mean = |basis: &Basis, x: MatRef<'_, f64>| -> Result<f64> {
                let weighted = times_mass(basis.mass(), x, self.par)?;
                Ok(x.col(0).transpose() * weighted.col(0) / basis.area()?)
            };
            let means = mean(self.source.basis(), f)? + mean(self.target.basis(), g)?;
            let size = (0.5 * means).sqrt();
            if size > 0.0 {
                let scaled = |x: MatRef<'_, f64>| Scale(1.0 / size) * x;
                self.known.operators.push(Operators {
                    source: multiplication(self.source.basis(), scaled(f).as_ref(), self.par)?,
                    target: multiplication(self.target.basis(), scaled(g).as_ref(), self.par)?,
                    weight: weight / f.ncols().max(1) as f64,
                });
            }
        }
        Ok(())
    }

    /// Adds pairs of vertices (source, target) that correspond, as heat kernels around them at
    /// times derived from the eigenvalues.
    ///
    /// # Errors
    /// [`Error::Argument`] names the first pair that is not a pair of vertices, or says that no
    /// eigenvalue is positive.
    pub fn landmarks(&mut self, pairs: &[(u32, u32)]) -> Result<()> {
        let (n, m) = (self.source.basis().vertices(), self.target.basis().vertices());
        let outside = |&(x, y): &(u32, u32)| x as usize >= n || y as usize >= m;
        if let Some(pair) = pairs.iter().find(|pair| outside(pair)) {
            let why = format!(
                "{pair:?} is not a pair of vertices, {n} on the source and {m} on the target"
            );
            return Err(Error::Argument { what: "landmarks", why });
        }
        if pairs.is_empty() {
            return Ok(());
        }
        // Times in units of the area, the same on both meshes.
        let times = heat_times(&self.source.unit_values()?, SCALES)?;
        let kernels = |basis: &Eigenbasis, vertex: &dyn Fn(usize) -> u32| -> Result<Mat<f64>> {
            let area = basis.basis().area()?;
            Ok(Mat::from_fn(basis.len(), pairs.len() * times.len(), |i, column| {
                let x = vertex(column / times.len()) as usize;
                let time = times[column % times.len()] * area;
                // Times the area, so that the function does not depend on the size of the mesh.
                area * (-basis.values()[i].max(0.0) * time).exp() * basis.functions()[(x, i)]
            }))
        };
        let a = kernels(self.source, &|pair| pairs[pair].0)?;
        let b = kernels(self.target, &|pair| pairs[pair].1)?;
        self.add(a.as_ref(), b.as_ref());
        Ok(())
    }

    /// Adds heat and wave kernel signatures of `source` and `target`, bases of the same meshes,
    /// with at least as many functions: more of them distinguish vertices better. Signatures are
    /// those of the meshes as if scaled to area 1; they do not tell left from right.
    ///
    /// # Errors
    /// [`Error::Shape`] for bases of other meshes, [`Error::Argument`] unless the eigenvalues of
    /// the source have two different positive values.
    pub fn signatures(&mut self, source: &Eigenbasis, target: &Eigenbasis) -> Result<()> {
        self.check_vertices(source, target)?;
        let values = [source.unit_values()?, target.unit_values()?];
        let times = heat_times(&values[0], SIGNATURES)?;
        let scales = wave_scales(&values[0], SIGNATURES)?;
        let signatures = |basis: &Eigenbasis, values: &[f64]| -> Result<[Mat<f64>; 2]> {
            // Their unit, 1 / area, does not matter, but a large one would overflow.
            let area = basis.basis().area()?;
            let heat = heat_kernel_signature(values, basis.functions(), &times, self.par)?;
            let wave = wave_kernel_signature(values, basis.functions(), &scales, self.par)?;
            Ok([heat, wave].map(|signature| Scale(area) * signature))
        };
        let f = signatures(source, &values[0])?;
        let g = signatures(target, &values[1])?;
        for (f, g) in f.iter().zip(&g) {
            self.functions(f.as_ref(), g.as_ref())?;
        }
        Ok(())
    }

    /// Adds the condition of [`MapFit::operators`] for heat kernels around corresponding vertices
    /// (source, target), of `source` and `target`, bases of the same meshes: unlike signatures,
    /// they tell left from right.
    ///
    /// # Errors
    /// [`Error::Shape`] for bases of other meshes, [`Error::Argument`] for a pair that is not a
    /// pair of vertices, and as [`MapFit::operators`].
    pub fn kernels(
        &mut self,
        pairs: &[(u32, u32)],
        source: &Eigenbasis,
        target: &Eigenbasis,
    ) -> Result<()> {
        self.check_vertices(source, target)?;
        let around = |basis: &Eigenbasis, vertices: Vec<u32>| -> Result<Mat<f64>> {
            let area = basis.basis().area()?;
            let (values, functions) = (basis.values(), basis.functions());
            let kernel = |&v: &u32| heat_kernel(values, functions, v as usize, KERNEL_TIME * area);
            let kernels: Vec<Vec<f64>> = vertices.iter().map(kernel).collect::<Result<_>>()?;
            // Times the area, so that the function does not depend on the size of the mesh.
            Ok(Mat::from_fn(functions.nrows(), kernels.len(), |x, j| area * kernels[j][x]))
        };
        let f = around(source, pairs.iter().map(|pair| pair.0).collect())?;
        let g = around(target, pairs.iter().map(|pair| pair.1).collect())?;
        self.operators(f.as_ref(), g.as_ref(), Self::MULTIPLICATIONS)
    }

    /// Returns an error unless these are bases of the same meshes, by their numbers of vertices.
    fn check_vertices(&self, source: &Eigenbasis, target: &Eigenbasis) -> Result<()> {
        for (what, basis, own) in [("source", source, self.source), ("target", target, self.target)]
        {
            let expected = (own.basis().vertices(), basis.len());
            Error::check_shape(what, expected, basis.functions().shape())?;
        }
        Ok(())
    }

    /// Adds segments that correspond: vertices of the same label on both meshes. Label 0 is a label
    /// like any other.
    ///
    /// ```
    /// use catamaran_geometry::spectral::{Eigenbasis, functional_map::MapFit};
    /// use catamaran_geometry::prelude::*;
    /// use catamaran_geometry::mesh::families;
    ///
    /// # let mesh = families::icosphere(2)?;
    /// # let operator = laplacian(&mesh, &LaplacianOptions::new())?;
    /// # let pairs = eigs(operator.stiffness.view(), &operator.mass, &EigenOptions::new().k(4))?;
    /// # let basis = Eigenbasis::new(pairs.values, pairs.vectors, operator.mass)?;
    /// // The eight octants of a sphere.
    /// let octant = |p: &[f64; 3]| (0..3).map(|k| u32::from(p[k] > 0.0) << k).sum();
    /// let labels: Vec<u32> = mesh.vertices().iter().map(octant).collect();
    /// let mut fit = MapFit::new(&basis, &basis, Par::Seq);
    /// fit.segments(&labels, &labels)?;
    /// let c = fit.solve(MapFit::COMMUTATIVITY)?;
    /// assert!((c - Mat::<f64>::identity(4, 4)).norm_max() < 1e-3);
    /// # Ok::<(), catamaran::Error>(())
    /// ```
    ///
    /// # Errors
    /// [`Error::Shape`] unless there is a label for each vertex, [`Error::Argument`] names the
    /// first label that only one of the meshes has.
    pub fn segments(&mut self, source: &[u32], target: &[u32]) -> Result<()> {
        let (n, m) = (self.source.basis().vertices(), self.target.basis().vertices());
        Error::check_shape("source labels", (n, 1), (source.len(), 1))?;
        Error::check_shape("target labels", (m, 1), (target.len(), 1))?;
        let labels = Self::common_labels(source, target)?;
        let indicators = |of: &[u32]| {
            Mat::from_fn(of.len(), labels.len(), |i, j| f64::from(u8::from(of[i] == labels[j])))
        };
        self.functions(indicators(source).as_ref(), indicators(target).as_ref())
    }

    /// Returns the labels of corresponding segments, ascending. The command line refuses labels
    /// that do not correspond by it, before it computes the eigenfunctions.
    ///
    /// # Errors
    /// [`Error::Argument`] names the first label that only one of the meshes has.
    #[doc(hidden)]
    pub fn common_labels(source: &[u32], target: &[u32]) -> Result<Vec<u32>> {
        let distinct = |labels: &[u32]| {
            let mut labels = labels.to_vec();
            labels.sort_unstable();
            labels.dedup();
            labels
        };
        let (labels, others) = (distinct(source), distinct(target));
        let missing =
            |of: &[u32], from: &[u32]| of.iter().copied().find(|l| from.binary_search(l).is_err());
        match missing(&labels, &others).or(missing(&others, &labels)) {
            None => Ok(labels),
            Some(label) => {
                let why = format!("label {label} is on one of the meshes only");
                Err(Error::Argument { what: "labels", why })
            }
        }
    }

    fn add(&mut self, a: MatRef<'_, f64>, b: MatRef<'_, f64>) {
        for j in 0..a.ncols() {
            let norm = (0.5 * (a.col(j).squared_norm_l2() + b.col(j).squared_norm_l2())).sqrt();
            if norm > 0.0 {
                self.known.a.extend(a.col(j).iter().map(|x| x / norm));
                self.known.b.extend(b.col(j).iter().map(|x| x / norm));
            }
        }
    }

    /// Computes the map, r_target x r_source; `commutativity` is the weight of the second term, at
    /// least 0.
    ///
    /// # Errors
    /// [`Error::Argument`] for an invalid weight, or when all functions on the source are zero;
    /// [`Error::OutOfMemory`]; [`Error::Cancelled`]; [`Error::NotConverged`] when conjugate
    /// gradients do not converge, for too many or too different operators.
    pub fn solve(&self, commutativity: f64) -> Result<Mat<f64>> {
        at_least_zero("commutativity", commutativity)?;
        let equations = self.row_equations(commutativity)?;
        let (k, l) = (self.source.len(), self.target.len());
        let mut c = zeros(l, k)?;
        let singular = AtomicBool::new(false);
        let alone = self.known.operators.is_empty();
        let rows = self.progress.part(0.0..if alone { 1.0 } else { ROWS_SHARE });
        let tracker = Tracker::new(rows, l as f64);
        for_row_blocks(c.as_mut(), 1, self.par, |i, row| {
            if row.nrows() == 0 || tracker.state().is_break() {
                return;
            }
            if !equations.solve(i, row) {
                singular.store(true, Ordering::Relaxed);
            }
            // The remaining rows check the state of the tracker.
            let _ = tracker.add(1.0);
        });
        tracker.finish()?;
        if singular.into_inner() {
            let why =
                "do not determine the map; add functions, or increase the commutativity".into();
            return Err(Error::Argument { what: "functions", why });
        }
        if alone {
            return Ok(c);
        }
        let RowEquations { gram, right, size, .. } = &equations;
        Equations {
            gram: Scale(1.0 / size) * gram,
            right: Scale(1.0 / size) * right.transpose(),
            weights: Mat::from_fn(l, k, |i, j| commutativity * equations.difference(i, j).powi(2)),
            operators: &self.known.operators,
            known: equations.known(),
        }
        .solve(c, self.progress.part(ROWS_SHARE..1.0))
    }

    fn row_equations(&self, commutativity: f64) -> Result<RowEquations> {
        let (k, l) = (self.source.len(), self.target.len());
        let known_functions = self.known.a.len() / k.max(1);
        let a = MatRef::from_column_major_slice(&self.known.a, k, known_functions);
        let b = MatRef::from_column_major_slice(&self.known.b, l, known_functions);
        let size = a.squared_norm_l2();
        if size == 0.0 {
            let why = "must not all be zero on the source".into();
            return Err(Error::Argument { what: "functions", why });
        }
        let gram = dense::transposed_product(a.transpose(), a.transpose(), self.par)?;
        let right = dense::transposed_product(a.transpose(), b.transpose(), self.par)?;
        let first = match (self.source.constant(), self.target.constant()) {
            (Some(source), Some(target)) => Some(source / target),
            _ => None,
        };
        let (source_values, target_values) = relative_values(self.source, self.target)?;
        Ok(RowEquations { gram, right, size, first, commutativity, source_values, target_values })
    }
}

/// The equations of a map without operators: its rows are independent of each other.
struct RowEquations {
    /// `A A^T`.
    gram: Mat<f64>,
    /// `A B^T`.
    right: Mat<f64>,
    /// `|A|^2`.
    size: f64,
    /// The first entry of the map where both bases contain the constant: then the first column is
    /// known, and zero below it.
    first: Option<f64>,
    commutativity: f64,
    source_values: Vec<f64>,
    target_values: Vec<f64>,
}

impl RowEquations {
    /// Returns the number of known columns.
    fn known(&self) -> usize {
        usize::from(self.first.is_some())
    }

    /// Returns the difference of the eigenvalues of an entry of the map.
    fn difference(&self, i: usize, j: usize) -> f64 {
        self.source_values[j] - self.target_values[i]
    }

    /// Solves for row i; returns false where the equations do not determine the row.
    fn solve(&self, i: usize, mut row: MatMut<'_, f64>) -> bool {
        let known = self.known();
        let unknown = self.gram.ncols() - known;
        let fixed = if i == 0 { self.first.unwrap_or(0.0) } else { 0.0 };
        let mut equations =
            Mat::from_fn(unknown, unknown, |p, q| self.gram[(p + known, q + known)] / self.size);
        let diagonal: f64 = (0..unknown).map(|p| equations[(p, p)]).sum();
        let ridge = RIDGE * (diagonal / unknown.max(1) as f64).max(f64::MIN_POSITIVE);
        for p in 0..unknown {
            let difference = self.difference(i, p + known);
            equations[(p, p)] += self.commutativity * difference * difference + ridge;
        }
        let mut solution = Mat::from_fn(unknown, 1, |p, _| {
            let with_fixed = if known == 1 { self.gram[(p + 1, 0)] * fixed } else { 0.0 };
            (self.right[(p + known, i)] - with_fixed) / self.size
        });
        let Ok(Ok(factor)) = dense::cholesky(equations) else { return false };
        dense::solve_cholesky(factor.as_ref(), solution.as_mut());
        if known == 1 {
            row[(0, 0)] = fixed;
        }
        row.subcols_mut(known, unknown).copy_from(solution.transpose());
        true
    }
}

/// Returns the eigenvalues of both bases, times the areas, divided by the largest.
fn relative_values(source: &Eigenbasis, target: &Eigenbasis) -> Result<(Vec<f64>, Vec<f64>)> {
    let (mut source, mut target) = (source.unit_values()?, target.unit_values()?);
    let largest = source.iter().chain(&target).copied().fold(f64::MIN_POSITIVE, f64::max);
    source.iter_mut().chain(&mut target).for_each(|value| *value /= largest);
    Ok((source, target))
}
