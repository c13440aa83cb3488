//! `spectrum`: eigenpairs of the Laplacian of meshes beside scipy's and PRIMME's, each solution in
//! a separate process.

use std::path::{Path, PathBuf};
use std::time::Instant;

use catamaran::sparse::{CsMat, EigenOptions, Mass, eigs};
use catamaran_bench::child::{self, Report};
use catamaran_bench::exchange::{get_vector, put_vector};
use catamaran_bench::race::median;
use catamaran_bench::{Result, host, record};
use catamaran_geometry::mesh::{LaplacianOptions, families, laplacian};

use super::Contest;

#[derive(clap::Args)]
pub struct Arguments {
    /// Meshes; by default a generated terrain of 100,489 vertices, and the armadillo if
    /// CATAMARAN_DATA (default ../shared) has it.
    meshes: Vec<PathBuf>,
    /// Eigenpairs.
    #[arg(short, default_value_t = 101)]
    k: usize,
    /// The rivals: solvers of bench/rivals/eigsh.py.
    #[arg(long, value_delimiter = ',', default_value = "cholmod,cholespy,primme")]
    rivals: Vec<String>,
    #[command(flatten)]
    contest: Contest,
}

pub fn run(arguments: &Arguments) -> Result<()> {
    if let Some(folder) = &arguments.contest.solve {
        return solve(folder, arguments.k, arguments.contest.threads[0]);
    }
    let python =
        child::python(&arguments.contest.libraries).ok_or("no scipy: run scripts/rivals first")?;
    let host = host::describe(&[]);
    println!("{host}\nk = {}\n", arguments.k);
    println!(
        "{:<16} {:>8} {:>2} {:<9} {:>8} {:>8} {:>6} {:>7} {:>7} {:>9} {:>9} {:>10}",
        "mesh",
        "vertices",
        "th",
        "rival",
        "ours s",
        "its s",
        "ratio",
        "ours MB",
        "its MB",
        "residual",
        "its",
        "difference"
    );
    let mut lines = Vec::new();
    for (name, mesh) in meshes(&arguments.meshes)? {
        let folder = tempfile::tempdir()?;
        let n = mesh.vertices().len();
        prepare(folder.path(), &mesh)?;
        for &threads in &arguments.contest.threads {
            for outcome in race(arguments, folder.path(), &python, threads)? {
                let Outcome { rival, seconds, ratio, bytes, residuals, difference } = outcome;
                let ([ours, its], [mb, its_mb]) = (seconds, bytes.map(|bytes| bytes / 1e6));
                let [residual, its_residual] = residuals;
                println!(
                    "{name:<16} {n:>8} {threads:>2} {rival:<9} {ours:>8.2} {its:>8.2} {ratio:>6.2} {mb:>7.0} \
                     {its_mb:>7.0} {residual:>9.1e} {its_residual:>9.1e} {difference:>10.1e}"
                );
                lines.push(format!(
                    "{name},{n},{},{threads},{},{rival},{ours:.4},{its:.4},{ratio:.3},{mb:.0},{its_mb:.0},\
                     {residual:.2e},{its_residual:.2e},{difference:.2e}",
                    arguments.k, arguments.contest.repeat
                ));
            }
        }
    }
    if let Some(name) = &arguments.contest.record {
        let header = "mesh,vertices,k,threads,repetitions,rival,ours_s,rival_s,ratio,ours_mb,rival_mb,\
                      ours_residual,rival_residual,value_difference";
        let (name, csv) = (format!("{name}.csv"), record::csv(header, lines));
        println!("\nrecorded in {}", record::write(&[(&name, csv), ("host.txt", host)])?.display());
    }
    Ok(())
}

/// Returns the meshes at these paths, or the default ones, with their names.
pub fn meshes(paths: &[PathBuf]) -> Result<Vec<(String, catamaran_geometry::mesh::TriMesh)>> {
    let read = |path: &Path| -> Result<_> {
        let name = path.file_name().unwrap_or_default().to_string_lossy();
        let name = name.split('.').next().unwrap_or_default().to_owned();
        Ok((name, catamaran_geometry::mesh::io::read(path)?.mesh))
    };
    if !paths.is_empty() {
        return paths.iter().map(|path| read(path)).collect();
    }
    let mut found = vec![("terrain".to_owned(), families::terrain(316, 316, 1)?)];
    let data = catamaran_bench::input::data_folder();
    let armadillo = data.join("meshes/armadillo43k.obj.gz");
    if armadillo.exists() {
        found.push(read(&armadillo)?);
    }
    Ok(found)
}

/// Writes the problem for both contenders.
fn prepare(folder: &Path, mesh: &catamaran_geometry::mesh::TriMesh) -> Result<()> {
    let problem = laplacian(mesh, &LaplacianOptions::default())?;
    let Mass::Lumped(mass) = &problem.mass else { return Err("a full mass".into()) };
    let as_f64 = |indices: &[usize]| indices.iter().map(|&i| i as f64).collect::<Vec<_>>();
    put_vector(folder, "data", problem.stiffness.data())?;
    put_vector(folder, "indices", &as_f64(problem.stiffness.indices()))?;
    put_vector(folder, "indptr", &as_f64(problem.stiffness.indptr().raw_storage()))?;
    put_vector(folder, "mass", mass)
}

/// Solves the problem with this library, in a separate process.
fn solve(folder: &Path, k: usize, threads: usize) -> Result<()> {
    let mass = get_vector(folder, "mass")?;
    let n = mass.len();
    let [indptr, indices] = ["indptr", "indices"].map(|name| get_vector(folder, name));
    let whole = |values: Vec<f64>| values.into_iter().map(|x| x as usize).collect::<Vec<_>>();
    let stiffness =
        CsMat::new((n, n), whole(indptr?), whole(indices?), get_vector(folder, "data")?);
    let mass = Mass::Lumped(mass);
    let [before, _] = child::memory();
    let start = Instant::now();
    let options = EigenOptions::new().k(k).threads(threads);
    let pairs = eigs(stiffness.view(), &mass, &options)?;
    let seconds = start.elapsed().as_secs_f64();
    let [_, peak] = child::memory();
    put_vector(folder, "our-values", &pairs.values)?;
    let largest = pairs.residuals.iter().copied().fold(0.0, f64::max);
    println!("{}", Report::line(seconds, peak - before, &[largest]));
    Ok(())
}

/// This library beside one rival: of each pair, ours comes first.
struct Outcome {
    rival: String,
    seconds: [f64; 2],
    /// Ratio of the rival's seconds to ours: the median over the repetitions.
    ratio: f64,
    bytes: [f64; 2],
    residuals: [f64; 2],
    /// Largest difference of eigenvalues, relative to the largest one.
    difference: f64,
}

/// Runs this library and all rivals in turns.
fn race(
    arguments: &Arguments,
    folder: &Path,
    python: &Path,
    threads: usize,
) -> Result<Vec<Outcome>> {
    let (k, t, place) =
        (arguments.k.to_string(), threads.to_string(), folder.display().to_string());
    let ours = ["spectrum", "--solve", &place, "-k", &k, "--threads", &t];
    let this = std::env::current_exe()?;
    let script = child::script("eigsh.py");
    let mut reports = vec![Vec::new(); 1 + arguments.rivals.len()];
    // Of each rival: its largest residual, and its difference from our values.
    let mut accuracy = vec![[f64::NAN; 2]; arguments.rivals.len()];
    for _ in 0..arguments.contest.repeat.max(1) {
        reports[0].push(child::run(&this, &ours, threads)?);
        for (i, rival) in arguments.rivals.iter().enumerate() {
            reports[1 + i].push(child::run(python, &[&script, &place, &k, rival], threads)?);
            accuracy[i] = compared(folder)?;
        }
    }
    let of = |reports: &[Report], number: fn(&Report) -> f64| {
        median(reports.iter().map(number).collect())
    };
    let (ours, rivals) = reports.split_first().ok_or("no contender")?;
    let residual = ours[0].rest.first().copied().unwrap_or(f64::NAN);
    let outcome = |((rival, theirs), accuracy): ((&String, &Vec<Report>), &[f64; 2])| Outcome {
        rival: rival.clone(),
        seconds: [ours, theirs].map(|reports| of(reports, |report| report.seconds)),
        ratio: median(ours.iter().zip(theirs).map(|(a, b)| b.seconds / a.seconds).collect()),
        bytes: [ours, theirs].map(|reports| of(reports, |report| report.bytes)),
        residuals: [residual, accuracy[0]],
        difference: accuracy[1],
    };
    Ok(arguments.rivals.iter().zip(rivals).zip(&accuracy).map(outcome).collect())
}

/// Returns the largest residual of the rival's pairs, and the largest difference of its eigenvalues
/// from ours, relative to the largest one.
fn compared(folder: &Path) -> Result<[f64; 2]> {
    let (values, theirs) = (get_vector(folder, "our-values")?, get_vector(folder, "values")?);
    let largest = theirs.last().copied().unwrap_or(1.0);
    let differences = values.iter().zip(&theirs).map(|(x, y)| (x - y).abs() / largest);
    // The first value of a connected mesh is zero, and can't be a divisor.
    let residuals = get_vector(folder, "residuals")?;
    let positive = residuals.iter().zip(&theirs).filter(|(_, value)| **value > 1e-6 * largest);
    Ok([
        positive.map(|(residual, _)| *residual).fold(0.0, f64::max),
        differences.fold(0.0, f64::max),
    ])
}
