//! `catamaran spectrum`.

use std::ops::Range;
use std::path::PathBuf;
use std::time::{Duration, Instant};

use anyhow::{Context, Result, anyhow, bail};
use catamaran::io::{Array, ArraysWriter, Output};
use catamaran::sparse::{CsMat, EigenOptions, Eigenpairs, eigs_two_level};
use catamaran_geometry::decimate::{DecimateOptions, decimate};
use catamaran_geometry::mesh::{
    Boundary, CloudOptions, Laplacian, LaplacianOptions, MassKind, TriMesh, cloud_laplacian_rows,
    laplacian_rows,
};
use clap::ValueEnum;

use crate::common::Force;
use crate::defaults::{stated, variant};
use crate::picture::{Paint, PictureArgs};
use crate::pieces::Pieces;
use crate::progress::Bar;
use crate::ranks::Ranks;
use crate::report::{head, note, report, row, seconds, shown, status};
use crate::rows::{fingerprint, fingerprint_of_indices};
use crate::shape::{LaplacianArgs, MassArgs};
use crate::{output, parse};

/// Compute eigenvalues and eigenfunctions of the Laplacian of a triangle mesh.
///
/// A file without faces is a point cloud: its Laplacian is that of triangles around each point, for
/// any --laplacian.
///
/// The output file has three arrays: `eigenvalues` (k, ascending), `eigenvectors` (vertices x k,
/// orthonormal in the inner product of the mass matrix) and `residuals` (k), |W phi - lambda M phi|
/// / |W phi|.
///
/// Under `mpirun` (where MPI is built in) each process has some rows of the matrices and of the
/// eigenvectors, until these are written; each process uses `--threads`.
#[derive(clap::Args)]
pub struct Args {
    #[arg(value_name = "MESH", help = crate::input::mesh_help("The mesh"))]
    input: PathBuf,
    /// Write the arrays to this .npz file, or .h5 where HDF5 is built in.
    #[arg(short, long, value_name = "FILE")]
    output: Option<PathBuf>,
    /// Number of eigenpairs, at most the number of free vertices: all, or with --boundary dirichlet
    /// those that are not on the boundary.
    #[arg(
        short,
        default_value_t = EigenOptions::default().k,
        value_name = "NUMBER",
        value_parser = parse::at_least_one
    )]
    k: usize,
    /// Compute the eigenvalues nearest to this number instead of the smallest ones.
    #[arg(long, value_name = "NUMBER", value_parser = parse::finite)]
    shift: Option<f64>,
    #[command(flatten)]
    laplacian: LaplacianArgs,
    #[command(flatten)]
    mass: MassArgs,
    /// Condition at the boundary: the normal derivative is zero (neumann), or the function is zero
    /// (dirichlet).
    #[arg(value_enum, long, default_value_t = variant(LaplacianOptions::default().boundary))]
    boundary: Edge,
    #[arg(
        long,
        value_name = "NUMBER",
        value_parser = tolerance,
        help = stated(
            "Largest residual allowed: if a pair exceeds it, the command fails after it has \
             written all results",
            format_args!(
                "{:e}; a pair that rounding keeps above it gives a note",
                EigenOptions::default().tolerance
            )
        )
    )]
    tolerance: Option<f64>,
    /// Check, by another factorization, that no eigenvalue is missing.
    #[arg(long)]
    verify: bool,
    #[arg(
        long,
        value_name = "GIB",
        value_parser = parse::gibibytes,
        help = stated(
            "Most memory of the eigensolver, in GiB. If all pairs at once would take more, they \
             are computed and written in slices of the spectrum, and a count of the eigenvalues \
             makes sure that none is missing. With --shift there are no slices, and too little \
             memory is an error. Works in one process only, not under `mpirun`",
            MEMORY as f64 / GIB
        )
    )]
    memory: Option<usize>,
    /// Compute approximate pairs, in less memory and, of a million vertices, in two thirds of the
    /// time: those of the mesh decimated to this number of vertices, interpolated to all vertices
    /// and improved there. Eigenvalues are too large: by 0.1 % on average and 0.5 % at most for
    /// scans with even triangles, 5,000 VERTICES or more and 100 times as many as pairs (-k); by
    /// several per cent with fewer vertices (2 % for a body of 1,000, which are few for its limbs)
    /// or long thin triangles. Works with `--boundary neumann` only.
    #[arg(
        long,
        value_name = "VERTICES",
        conflicts_with_all = ["shift", "tolerance", "verify", "memory"]
    )]
    via_decimation: Option<usize>,
    #[command(flatten)]
    picture: PictureArgs,
    #[command(flatten)]
    force: Force,
}

/// Parses a tolerance that the eigensolver accepts.
fn tolerance(text: &str) -> Result<f64, String> {
    let accepted = parse::finite(text).ok().filter(|x| (1e-14..=1e-2).contains(x));
    accepted.ok_or_else(|| "expected a number from 1e-14 to 1e-2".into())
}

/// The condition at the boundary.
#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
enum Edge {
    Neumann,
    Dirichlet,
}

impl From<Edge> for Boundary {
    fn from(edge: Edge) -> Self {
        match edge {
            Edge::Neumann => Self::Neumann,
            Edge::Dirichlet => Self::Dirichlet,
        }
    }
}

/// Runs the subcommand.
pub fn run(args: &Args) -> Result<()> {
    let ranks = Ranks::join()?;
    let done = run_as(args, &ranks);
    ranks.end(done)
}

impl Args {
    /// Refuses `--via-decimation` and `--memory` where they do not work.
    fn check(&self, ranks: &Ranks) -> Result<()> {
        if self.via_decimation.is_some() && ranks.size() > 1 {
            bail!("--via-decimation runs in one process: use --threads instead of mpirun");
        }
        if self.via_decimation.is_some() && self.boundary == Edge::Dirichlet {
            bail!("--via-decimation needs --boundary neumann");
        }
        if self.memory.is_some() && ranks.size() > 1 {
            bail!("--memory limits one process: it can't be combined with mpirun");
        }
        if let Some(n) = self.via_decimation.filter(|&n| n < self.k) {
            bail!("--via-decimation {n}: too few vertices for the {} eigenpairs of -k", self.k);
        }
        Ok(())
    }

    fn laplacian_options(&self) -> LaplacianOptions {
        LaplacianOptions::new()
            .kind(self.laplacian.kind())
            .mass(self.mass.kind())
            .boundary(self.boundary.into())
            .par(self.laplacian.par())
    }
}

/// Reports the eigenvalues and how they were computed, in `time`.
fn report_pairs(args: &Args, results: &Results<'_>, time: Duration) -> Result<()> {
    status!(
        "eigenpairs",
        count = args.k,
        seconds = time.as_secs_f64();
        "{} in {}",
        args.k,
        seconds(time)
    )?;
    if results.slices > 1 {
        status!("slices", count = results.slices; "{}", results.slices)?;
    }
    if let Some(n) = args.via_decimation {
        status!("decimation", vertices = n; "to {n} vertices: the pairs are approximate")?;
    }
    let (_, largest) = results.worst.unwrap_or_default();
    report!("residual", largest = largest; "{largest:.1e} at most")?;
    let pairs = results.values.iter().zip(&results.residuals).enumerate();
    let listed = shown(SHOWN).min(args.k);
    for (i, (value, residual)) in pairs.take(listed) {
        row!(
            "eigenvalue",
            number = i,
            value = value,
            residual = residual;
            "{i:>10}  {value:<22.15e} {residual:.1e}"
        )?;
    }
    if listed < args.k {
        head(format_args!("{:>10}  {:.15e}", args.k - 1, results.values[args.k - 1]))?;
    }
    Ok(())
}

fn run_as(args: &Args, ranks: &Ranks) -> Result<()> {
    let begin = || -> Result<_> {
        args.check(ranks)?;
        let path = args.output.as_deref().filter(|_| ranks.is_first());
        let output = path.map(|path| output::arrays(path, args.force)).transpose()?;
        let picture = match ranks.is_first() {
            true => args.picture.create(args.force)?,
            false => None,
        };
        Ok((output, picture, args.laplacian.repair.read(&args.input)?.mesh))
    };
    let (output, picture, mesh) = ranks.meet(begin())?;
    check_same(args, ranks, &mesh)?;
    let operator = assemble(args, ranks, &mesh)?;
    ranks.meet(check_count(args, &mesh, operator.kept.len()))?;
    ranks.report(args.laplacian.par().threads())?;

    let start = Instant::now();
    let bar = Bar::new("spectrum");
    let watch = |fraction| bar.update(fraction);
    let tolerance = args.tolerance.unwrap_or(EigenOptions::default().tolerance);
    let options = EigenOptions::new()
        .k(args.k)
        .shift(args.shift)
        .tolerance(tolerance)
        .verify_count(args.verify)
        .par(args.laplacian.par())
        .progress(&watch);
    let mut results = ranks.meet(Results::new(output, &operator, args.k))?;
    let (found, mesh) = match args.via_decimation {
        Some(n) => {
            let found = via_decimation(&mesh, n, &operator, &options);
            (found.and_then(|pairs| results.take(&pairs, ranks)), Some(mesh))
        }
        None => {
            // Only pictures need the mesh from here on.
            let mesh = picture.is_some().then_some(mesh);
            let (stiffness, mass) = (&operator.stiffness, &operator.mass);
            let take = |slice| results.take(&slice, ranks);
            (ranks.eigenpairs(stiffness, mass, &options, args.memory.unwrap_or(MEMORY), take), mesh)
        }
    };
    let found = found.map_err(|error| match error {
        catamaran::Error::Argument { what: "memory", why } => {
            anyhow!("{}: --memory: {}", args.input.display(), in_gibibytes(&why))
        }
        error => args.laplacian.unsolved(error, &args.input.display(), tolerance, args.shift),
    });
    ranks.meet(found)?;
    drop(bar);
    report_pairs(args, &results, start.elapsed())?;
    if let (Some(picture), Some(mesh)) = (picture, mesh) {
        results.draw(args, &mesh, picture)?;
    }
    let worst = results.worst.unwrap_or_default();
    results.finish()?;
    if args.via_decimation.is_some() {
        return Ok(());
    }
    // The first process has written all results by now.
    ranks.meet(check_residual(args, ranks, worst, tolerance))
}

/// Returns the text of an error about too little memory in the unit of --memory: the least number
/// that is enough, where the error has it in bytes.
fn in_gibibytes(why: &str) -> String {
    let number = |text: &str| text.split(' ').next()?.parse::<f64>().ok();
    match why.strip_prefix("must be at least ").and_then(number) {
        Some(bytes) => {
            // Four digits after the point, rounded up.
            format!("must be at least {} GiB", (1e4 * bytes / GIB).ceil() / 1e4)
        }
        None => format!("{why} (the unit of the option is GiB, {GIB} bytes)"),
    }
}

/// Checks that all processes have read the same mesh.
///
/// # Errors
/// A process has another one; the error names it, and what differs.
fn check_same(args: &Args, ranks: &Ranks, mesh: &TriMesh) -> Result<()> {
    let (vertices, faces) = (mesh.vertices().as_flattened(), mesh.faces().as_flattened());
    let numbers = [
        ("the number of vertices", mesh.vertices().len()),
        ("the number of faces", mesh.faces().len()),
        ("the fingerprint of the vertices", fingerprint(vertices) as usize),
        ("the fingerprint of the faces", fingerprint_of_indices(faces) as usize),
    ];
    ranks.same_numbers(&numbers).with_context(|| args.input.display().to_string())
}

/// Computes the rows of this process of the matrices of the Laplacian.
fn assemble(args: &Args, ranks: &Ranks, mesh: &TriMesh) -> Result<Laplacian> {
    let name = args.input.display();
    let start = Instant::now();
    let options = args.laplacian_options();
    let is_cloud = mesh.faces().is_empty();
    let share = |rows| ranks.share(rows, 1);
    let operator = match is_cloud {
        true => cloud(args, mesh, share),
        false => laplacian_rows(mesh, &options, share).with_context(|| name.to_string()),
    };
    // A fault may be in the rows of one process only.
    let operator = ranks.meet(operator)?;
    let (entries, time) = (ranks.total(operator.stiffness.nnz()), start.elapsed());
    let (rows, vertices) = (operator.kept.len(), operator.vertices);
    status!(
        "mesh",
        path = name.to_string(),
        vertices = vertices,
        free = rows;
        "{name}: {vertices} vertices, {rows} of them free"
    )?;
    status!(
        "matrices",
        entries = entries,
        seconds = time.as_secs_f64();
        "{entries} entries, in {}",
        seconds(time)
    )?;
    Ok(operator)
}

/// Refuses more eigenpairs than rows, and notes the components of the mesh.
fn check_count(args: &Args, mesh: &TriMesh, rows: usize) -> Result<()> {
    if args.k > rows {
        let default = EigenOptions::default().k;
        let default = if args.k == default { " (the default)" } else { "" };
        let name = args.input.display();
        bail!("{name}: -k {}{default}, where {rows} vertices are free", args.k);
    }
    if args.shift.is_none() && !mesh.faces().is_empty() {
        let options = args.laplacian_options();
        Pieces::new(mesh, &args.input, &args.laplacian.repair, &options.boundary)?.note();
    }
    Ok(())
}

/// Computes the matrices of the Laplacian of the vertices of a mesh without faces.
///
/// # Errors
/// An option that needs faces.
fn cloud(
    args: &Args,
    mesh: &TriMesh,
    share: impl FnOnce(usize) -> Range<usize>,
) -> Result<Laplacian> {
    let name = args.input.display();
    if args.via_decimation.is_some() || args.mass.kind() == MassKind::Consistent {
        bail!("{name}: has no faces, which --via-decimation and --mass full need");
    }
    let options = CloudOptions::new().boundary(args.boundary.into()).par(args.laplacian.par());
    cloud_laplacian_rows(mesh.vertices(), &options, share).with_context(|| name.to_string())
}

/// Refuses a largest residual above --tolerance; above the default tolerance there is a note.
fn check_residual(
    args: &Args,
    ranks: &Ranks,
    (pair, residual): (usize, f64),
    tolerance: f64,
) -> Result<()> {
    if residual <= tolerance {
        return Ok(());
    }
    let missed = format!(
        "{}: eigenpair {pair} (from 0) has a residual of {residual:.1e}, above the tolerance of \
         {tolerance:e}: rounding does not let the solver reach less",
        args.input.display()
    );
    if args.tolerance.is_some() {
        bail!(missed);
    }
    if ranks.is_first() {
        note(format_args!("{missed}"));
    }
    Ok(())
}

/// Computes pairs of the operator of a mesh from those of the mesh with n vertices.
fn via_decimation(
    mesh: &TriMesh,
    n: usize,
    operator: &Laplacian,
    options: &EigenOptions<'_>,
) -> catamaran::Result<Eigenpairs> {
    let (par, progress) = (options.par, options.progress);
    let smaller = DecimateOptions::new().par(par).progress(progress.part(0.0..0.6));
    let weights = decimate(mesh, n, &smaller)?.weights(mesh, par)?;
    let weights = rows(&weights, operator.kept.iter().copied());
    let options = options.clone().progress(progress.part(0.6..1.0));
    eigs_two_level(operator.stiffness.view(), &operator.mass, weights.view(), &options)
}

/// Returns the chosen rows of a matrix.
fn rows(matrix: &CsMat<f64>, chosen: impl Iterator<Item = usize>) -> CsMat<f64> {
    let (mut starts, mut columns, mut values) = (vec![0], Vec::new(), Vec::new());
    for row in chosen.filter_map(|i| matrix.outer_view(i)) {
        columns.extend_from_slice(row.indices());
        values.extend_from_slice(row.data());
        starts.push(columns.len());
    }
    CsMat::new((starts.len() - 1, matrix.cols()), starts, columns, values)
}

/// Collects and writes the pairs, slice by slice.
struct Results<'a> {
    operator: &'a Laplacian,
    writer: Option<ArraysWriter>,
    path: String,
    values: Vec<f64>,
    residuals: Vec<f64>,
    /// The number and the residual of the pair with the largest residual.
    worst: Option<(usize, f64)>,
    /// The first eigenfunctions.
    drawn: Vec<Vec<f64>>,
    slices: usize,
}

impl<'a> Results<'a> {
    fn new(output: Option<Output>, operator: &'a Laplacian, k: usize) -> Result<Self> {
        let path = output.as_ref().map(|output| output.path().display().to_string());
        let mut writer = output.map(ArraysWriter::new).transpose()?;
        if let Some(writer) = &mut writer {
            writer.matrix_by_columns("eigenvectors", operator.vertices, k)?;
        }
        Ok(Self {
            operator,
            writer,
            path: path.unwrap_or_default(),
            values: Vec::new(),
            residuals: Vec::new(),
            worst: None,
            drawn: Vec::new(),
            slices: 0,
        })
    }

    fn take(&mut self, slice: &Eigenpairs, ranks: &Ranks) -> catamaran::Result<()> {
        self.slices += 1;
        if let Some((pair, residual)) = slice.worst()
            && self.worst.is_none_or(|(_, before)| residual > before)
        {
            self.worst = Some((self.residuals.len() + pair, residual));
        }
        self.values.extend(&slice.values);
        self.residuals.extend(&slice.residuals);
        // The other processes have no vectors.
        if !ranks.is_first() {
            return Ok(());
        }
        for j in 0..slice.values.len() {
            let vector = self.operator.extend(slice.vectors.as_ref().subcols(j, 1))?;
            if let Some(writer) = &mut self.writer {
                writer.columns(vector.as_ref())?;
            }
            if self.drawn.len() < DRAWN {
                self.drawn.push(vector.col(0).iter().copied().collect());
            }
        }
        Ok(())
    }

    /// Draws the first eigenfunctions on the mesh.
    fn draw(&self, args: &Args, mesh: &TriMesh, picture: Output) -> Result<()> {
        let titles: Vec<_> = self.values.iter().map(|value| format!("{value:.4}")).collect();
        let panel =
            |(values, title)| (mesh, Paint::Values(Vec::as_slice(values)), String::as_str(title));
        let panels: Vec<_> = self.drawn.iter().zip(&titles).map(panel).collect();
        args.picture.draw(picture, &args.input, &panels)
    }

    fn finish(self) -> Result<()> {
        let Some(mut writer) = self.writer else { return Ok(()) };
        writer.array("eigenvalues", Array::Vector(&self.values))?;
        writer.array("residuals", Array::Vector(&self.residuals))?;
        writer.finish()?;
        status!("written", path = self.path; "{}", self.path)
    }
}

/// Bytes of a GiB.
const GIB: f64 = (1 << 30) as f64;

/// The default of --memory, in bytes: 4.5 GiB.
const MEMORY: usize = 9 << 29;

/// Eigenvalues in the table.
const SHOWN: usize = 10;

/// Eigenfunctions in the picture.
const DRAWN: usize = 4;
