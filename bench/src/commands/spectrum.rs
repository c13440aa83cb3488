//! `spectrum`: eigenpairs of the Laplacian of meshes beside scipy's, each solution in a separate
//! process.

use std::path::{Path, PathBuf};
use std::time::Instant;

use catamaran::sparse::{CsMat, EigenOptions, Mass, eigs};
use catamaran_bench::child::{self, Duel, Report};
use catamaran_bench::exchange::{get_vector, put_vector};
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
        "{:<14} {:>9} {:>2} {:>9} {:>9} {:>6} {:>7} {:>7} {:>9} {:>9} {:>9}",
        "mesh",
        "vertices",
        "th",
        "ours s",
        "scipy s",
        "ratio",
        "ours MB",
        "scipy",
        "residual",
        "scipy",
        "difference"
    );
    let mut lines = Vec::new();
    for (name, mesh) in meshes(&arguments.meshes)? {
        let folder = tempfile::tempdir()?;
        let n = mesh.vertices().len();
        prepare(folder.path(), &mesh)?;
        for &threads in &arguments.contest.threads {
            let outcome = race(arguments, folder.path(), &python, threads)?;
            let Outcome { ours, scipy, ratio, bytes, residuals, difference } = outcome;
            let [mb, scipy_mb] = bytes.map(|bytes| bytes / 1e6);
            let [residual, scipy_residual] = residuals;
            println!(
                "{name:<14} {n:>9} {threads:>2} {ours:>9.2} {scipy:>9.2} {ratio:>6.2} {mb:>7.0} {scipy_mb:>7.0} \
                 {residual:>9.1e} {scipy_residual:>9.1e} {difference:>9.1e}"
            );
            lines.push(format!(
                "{name},{n},{},{threads},{},{ours:.4},{scipy:.4},{ratio:.3},{mb:.0},{scipy_mb:.0},{residual:.2e},\
                 {scipy_residual:.2e},{difference:.2e}",
                arguments.k, arguments.contest.repeat
            ));
        }
    }
    if let Some(name) = &arguments.contest.record {
        let header = "mesh,vertices,k,threads,repetitions,ours_s,scipy_s,ratio,ours_mb,scipy_mb,ours_residual,\
                      scipy_residual,value_difference";
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

struct Outcome {
    ours: f64,
    scipy: f64,
    /// Ratio of scipy's seconds to ours: the median over the repetitions.
    ratio: f64,
    bytes: [f64; 2],
    residuals: [f64; 2],
    /// Largest difference of eigenvalues, relative to the largest one.
    difference: f64,
}

fn race(arguments: &Arguments, folder: &Path, python: &Path, threads: usize) -> Result<Outcome> {
    let (k, t, place) =
        (arguments.k.to_string(), threads.to_string(), folder.display().to_string());
    let ours = ["spectrum", "--solve", &place, "-k", &k, "--threads", &t];
    let duel =
        Duel::new(&ours, python, ("eigsh.py", &[&place, &k]), threads, arguments.contest.repeat)?;
    let (values, theirs) = (get_vector(folder, "our-values")?, get_vector(folder, "values")?);
    let largest = theirs.last().copied().unwrap_or(1.0);
    let differences = values.iter().zip(&theirs).map(|(x, y)| (x - y).abs() / largest);
    // The first value of a connected mesh is zero, and can't be a divisor.
    let scipy_residuals = get_vector(folder, "residuals")?;
    let positive =
        scipy_residuals.iter().zip(&theirs).filter(|(_, value)| **value > 1e-6 * largest);
    let [ours, scipy] = duel.seconds();
    Ok(Outcome {
        ours,
        scipy,
        ratio: duel.ratio(),
        bytes: duel.bytes(),
        residuals: [
            duel.rest()[0].first().copied().unwrap_or(f64::NAN),
            positive.map(|(residual, _)| *residual).fold(0.0, f64::max),
        ],
        difference: differences.fold(0.0, f64::max),
    })
}
