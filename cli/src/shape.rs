//! A mesh with its first eigenfunctions, for several subcommands.

use std::fmt::Display;
use std::path::Path;

use anyhow::{Context, Result, bail};
use catamaran::Par;
use catamaran::base::check_request;
use catamaran::faer::Mat;
use catamaran::io::{self as files, Matrix};
use catamaran::sparse::{CsMat, EigenOptions, eigs};
use catamaran_geometry::mesh::io::{MeshFile, holds_scalars, read_scalars};
use catamaran_geometry::mesh::{
    Boundary, Laplacian, LaplacianKind, LaplacianOptions, MassKind, TriMesh, laplacian,
};
use catamaran_geometry::spectral::{Eigenbasis, Eigenproducts, Orthogonalization, ProductBasis};
use clap::ValueEnum;

use crate::common::{Threads, as_option};
use crate::defaults::variant;
use crate::input::{self, MeshArgs};
use crate::pieces::{COMPACT, Need, Pieces};
use crate::progress::Bar;
use crate::report::{note, status};
use crate::tables::{self, TableArgs};

/// The options of the Laplacian.
#[derive(clap::Args)]
pub struct LaplacianArgs {
    /// Triangulation of the Laplacian: that of the mesh (cotan), its intrinsic Delaunay
    /// triangulation (intrinsic), or that of its tufted cover (tufted), for meshes with edges of
    /// more than two faces or with faces without area.
    #[arg(
        value_enum,
        long,
        value_name = "KIND",
        default_value_t = variant(LaplacianOptions::default().kind)
    )]
    laplacian: Kind,
    #[command(flatten)]
    pub repair: MeshArgs,
    #[command(flatten)]
    threads: Threads,
}

/// Triangulations of a Laplacian.
#[derive(Clone, Copy, ValueEnum)]
pub enum Kind {
    // As C and Python call it.
    #[value(alias = "cotangent")]
    Cotan,
    Intrinsic,
    Tufted,
}

impl From<Kind> for LaplacianKind {
    fn from(kind: Kind) -> Self {
        match kind {
            Kind::Cotan => Self::Cotangent,
            Kind::Intrinsic => Self::IntrinsicDelaunay,
            Kind::Tufted => Self::Tufted,
        }
    }
}

/// The option of the mass matrix.
#[derive(clap::Args)]
pub struct MassArgs {
    /// Mass matrix: a diagonal (lumped), or the inner product of linear functions (full).
    #[arg(value_enum, long, default_value_t = variant(LaplacianOptions::default().mass))]
    mass: Mass,
}

impl MassArgs {
    pub fn kind(&self) -> MassKind {
        self.mass.into()
    }
}

/// The mass matrix.
#[derive(Clone, Copy, ValueEnum)]
enum Mass {
    Lumped,
    Full,
}

impl From<Mass> for MassKind {
    fn from(mass: Mass) -> Self {
        match mass {
            Mass::Lumped => Self::Barycentric,
            Mass::Full => Self::Consistent,
        }
    }
}

/// How products are orthogonalized.
#[derive(Clone, Copy, ValueEnum)]
pub enum Mode {
    /// One pass of Gram-Schmidt, threshold 1e-2 (the thesis' ours).
    #[value(alias = "ours")]
    SinglePass,
    /// Gram-Schmidt, repeated until orthogonal, threshold 1e-9 (the thesis' ours*).
    #[value(alias = "ours*")]
    Reorthogonalized,
    /// As many products as their numerical rank, by singular values above 1e-9.
    RankRevealing,
}

impl From<Mode> for Orthogonalization {
    fn from(mode: Mode) -> Self {
        match mode {
            Mode::SinglePass => Self::SinglePass,
            Mode::Reorthogonalized => Self::Reorthogonalized,
            Mode::RankRevealing => Self::RankRevealing,
        }
    }
}

/// A mesh whose eigenfunctions are not computed yet, so that the other options of a command can be
/// judged first.
pub struct Prepared<'a> {
    pub file: MeshFile,
    /// Number of components.
    pub components: usize,
    options: &'a LaplacianArgs,
    path: &'a Path,
    operator: Laplacian,
    /// Number of eigenfunctions.
    len: usize,
}

/// A mesh and its spectrum.
pub struct Shape {
    pub file: MeshFile,
    pub stiffness: CsMat<f64>,
    pub eigenbasis: Eigenbasis,
}

impl LaplacianArgs {
    pub fn kind(&self) -> LaplacianKind {
        self.laplacian.into()
    }

    pub fn par(&self) -> Par {
        self.threads.par()
    }

    /// Reads a mesh and computes its first eigenfunctions, as many as the largest of `needs` says.
    pub fn shape(&self, path: &Path, needs: &[Need]) -> Result<Shape> {
        self.prepare(path, needs)?.solve()
    }

    /// Adds to an error of the eigensolver the name of the mesh and, if pairs did not reach the
    /// residual `tolerance`, what may help.
    pub fn unsolved(
        &self,
        error: catamaran::Error,
        name: &dyn Display,
        tolerance: f64,
        shift: Option<f64>,
    ) -> anyhow::Error {
        let context = match error {
            catamaran::Error::NotConverged { .. } => {
                let near = shift.map_or(String::new(), |shift| format!(" near --shift {shift:e}"));
                let help = match (self.laplacian, shift) {
                    (Kind::Cotan, None) => " (long thin triangles need --laplacian intrinsic)",
                    _ => "",
                };
                format!("{name}: residuals of {tolerance:e} were not reached{near}{help}")
            }
            _ => name.to_string(),
        };
        anyhow::Error::from(error).context(context)
    }

    /// Reads a mesh, and refuses one that does not have the eigenfunctions that `needs` says.
    pub fn prepare<'a>(&'a self, path: &'a Path, needs: &[Need]) -> Result<Prepared<'a>> {
        self.prepare_file(self.repair.read(path)?, path, needs)
    }

    /// Prepares a mesh that was read from `path`, as [`LaplacianArgs::prepare`] does.
    pub fn prepare_file<'a>(
        &'a self,
        file: MeshFile,
        path: &'a Path,
        needs: &[Need],
    ) -> Result<Prepared<'a>> {
        has_faces(&file.mesh, path)?;
        // The first of the largest.
        let most = needs.iter().rev().max_by_key(|need| need.len);
        let Need { option, len, .. } = *most.context("no eigenfunctions are needed")?;
        let vertices = file.mesh.vertices().len();
        if len > vertices {
            bail!(
                "{}: {option}: {vertices} vertices, too few for {len} eigenfunctions, the constant \
                 one included",
                path.display()
            );
        }
        let request = format_args!("{len} functions of {vertices} vertices");
        check_request(option, request, 8.0 * len as f64 * vertices as f64)?;
        let pieces = Pieces::new(&file.mesh, path, &self.repair, &Boundary::Neumann)?;
        needs.iter().try_for_each(|need| pieces.check(*need))?;
        let options = LaplacianOptions::new().kind(self.kind()).par(self.par());
        let operator =
            laplacian(&file.mesh, &options).with_context(|| path.display().to_string())?;
        if let Some(vertex) = (0..vertices).find(|&v| operator.kept.get(v) != Some(&v)) {
            let (path, command) = (path.display(), self.repair.mesh_command(path, COMPACT));
            bail!("{path}: vertex {vertex} is in no face ({command} drops such vertices)");
        }
        pieces.note();
        let components = pieces.count();
        Ok(Prepared { file, components, options: self, path, operator, len })
    }
}

impl Prepared<'_> {
    /// Returns the number of vertices.
    pub fn vertices(&self) -> usize {
        self.file.mesh.vertices().len()
    }

    /// Returns the products of at most `order` of `k` eigenfunctions, if there is memory for them.
    pub fn products(&self, k: usize, order: usize) -> Result<Eigenproducts> {
        ProductBasis::products_on(self.vertices(), k, order).map_err(as_option)
    }

    /// Computes the eigenfunctions.
    pub fn solve(self) -> Result<Shape> {
        let (vertices, par) = (self.vertices(), self.options.par());
        let Self { file, path, operator, len, options: of, .. } = self;
        let named = || path.display().to_string();
        let rows = operator.stiffness.rows();
        if len > rows {
            bail!("{}: {len} eigenpairs, where {rows} vertices are free: -k", named());
        }
        let bar = Bar::new("spectrum");
        let update = |fraction| bar.update(fraction);
        let options = EigenOptions::new().k(len).par(par).progress(&update);
        let pairs = eigs(operator.stiffness.view(), &operator.mass, &options)
            .map_err(|error| of.unsolved(error, &path.display(), options.tolerance, None))?;
        drop(bar);
        let worst = pairs.residuals.iter().copied().fold(0.0, f64::max);
        let eigenbasis =
            Eigenbasis::new(pairs.values, pairs.vectors, operator.mass).with_context(named)?;
        let (path, faces) = (named(), file.mesh.faces().len());
        status!(
            "mesh",
            path = path,
            vertices = vertices,
            faces = faces,
            eigenpairs = len,
            largest_residual = worst;
            "{path}: {vertices} vertices, {faces} faces; {len} eigenpairs, residuals up to \
             {worst:.0e}"
        )?;
        Ok(Shape { file, stiffness: operator.stiffness, eigenbasis })
    }
}

/// Returns an error about a mesh without faces, such as a point cloud.
pub fn has_faces(mesh: &TriMesh, path: &Path) -> Result<()> {
    if mesh.faces().is_empty() {
        let path = path.display();
        bail!("{path}: has no faces; `catamaran spectrum` has eigenfunctions of point clouds");
    }
    Ok(())
}

/// Reads a matrix of finite numbers with a row for each of `rows` vertices: a table, or the values
/// of vertices in a file of a mesh or of FreeSurfer.
pub fn functions(path: &Path, rows: usize, table: &TableArgs) -> Result<Mat<f64>> {
    let matrix = match holds_scalars(path) {
        true => {
            let columns = read_scalars(path, &input::source())?;
            let count = columns.first().map_or(0, |column| column.values.len());
            if let Some(other) = columns.iter().find(|column| column.values.len() != count) {
                let (path, name, length) = (path.display(), &other.name, other.values.len());
                bail!("{path}: {length} values of {name:?}, and {count} of the first function");
            }
            Mat::from_fn(count, columns.len(), |i, j| columns[j].values[i])
        }
        false => dense(path, table)?,
    };
    if matrix.nrows() != rows {
        bail!("{}: {} rows for {rows} vertices", path.display(), matrix.nrows());
    }
    let mut places = (0..rows).flat_map(|i| (0..matrix.ncols()).map(move |j| (i, j)));
    if let Some((i, j)) = places.find(|&place| !matrix[place].is_finite()) {
        bail!("{}: not finite at row {i}, column {j} (counted from 0)", path.display());
    }
    Ok(matrix)
}

/// Reads a dense matrix of numbers.
pub fn dense(path: &Path, table: &TableArgs) -> Result<Mat<f64>> {
    let options = table.read();
    // Of several files the options may apply to one only.
    let content = files::read_one_of_several(path, &options)?;
    if let Some(reading) = &content.reading {
        tables::say(path, reading, &options)?;
    }
    if let Some(rounded) = &content.rounded {
        note(format_args!("{}: {rounded}", path.display()));
    }
    match content.matrix {
        Matrix::F64(dense) => Ok(dense.as_ref().to_owned()),
        Matrix::F32(dense) => {
            let dense = dense.as_ref();
            Ok(Mat::from_fn(dense.nrows(), dense.ncols(), |i, j| f64::from(dense[(i, j)])))
        }
        Matrix::Complex(_) => {
            bail!("{}: complex numbers, where real ones are needed", path.display())
        }
        _ => bail!("{}: the matrix must be dense, but is sparse", path.display()),
    }
}

/// Returns vertex numbers as a matrix of one column.
pub fn column(vertices: &[u32]) -> Mat<i64> {
    Mat::from_fn(vertices.len(), 1, |i, _| i64::from(vertices[i]))
}

/// Reads a whole number of at least 0 for each of `rows` vertices.
pub fn labels(path: &Path, rows: usize, table: &TableArgs) -> Result<Vec<u32>> {
    let matrix = functions(path, rows, table)?;
    if matrix.ncols() != 1 {
        bail!("{}: {} columns instead of 1", path.display(), matrix.ncols());
    }
    let label = |(i, &x): (usize, &f64)| {
        if x.fract() != 0.0 || !(0.0..=f64::from(u32::MAX)).contains(&x) {
            bail!("{}: row {i}: {x} is not the number of a segment (from 0)", path.display());
        }
        Ok(x as u32)
    };
    matrix.col(0).iter().enumerate().map(label).collect()
}

/// Reads a matrix of vertex numbers: column j has numbers of vertices of a mesh with `counts[j]`
/// vertices.
pub fn vertices(path: &Path, counts: &[usize], table: &TableArgs) -> Result<Vec<Vec<u32>>> {
    let matrix = dense(path, table)?;
    if matrix.ncols() != counts.len() {
        bail!("{}: {} columns instead of {}", path.display(), matrix.ncols(), counts.len());
    }
    let vertex = |i: usize, j: usize| {
        let number = matrix[(i, j)];
        if number.fract() != 0.0 || number < 0.0 || number >= counts[j] as f64 {
            let count = counts[j];
            bail!("{}: row {i}: {number} is not one of {count} vertices (from 0)", path.display());
        }
        Ok(number as u32)
    };
    (0..matrix.nrows()).map(|i| (0..counts.len()).map(|j| vertex(i, j)).collect()).collect()
}

/// Returns the mesh with its vertices moved, without normals, which no longer fit.
pub fn moved(mut file: MeshFile, positions: &Mat<f64>, path: &Path) -> Result<MeshFile> {
    if let Some(vertex) =
        (0..positions.nrows()).find(|&i| (0..3).any(|c| !positions[(i, c)].is_finite()))
    {
        bail!("{}: the new position of vertex {vertex} is not finite", path.display());
    }
    let vertices = (0..positions.nrows()).map(|i| [0, 1, 2].map(|c| positions[(i, c)])).collect();
    file.mesh = TriMesh::new(vertices, file.mesh.faces().to_vec())?;
    file.normals = None;
    Ok(file)
}
