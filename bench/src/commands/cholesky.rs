//! `cholesky`: analysis, factorization and solution with the Laplacian of meshes, plus their mass,
//! beside CHOLMOD, each in a separate process.

use std::path::{Path, PathBuf};
use std::time::Instant;

use catamaran::Par;
use catamaran::base::{Progress, Rng};
use catamaran::faer::Mat;
use catamaran::sparse::{Cholesky, CholeskyOptions, CsMat, multiply};
use catamaran_bench::child::{self, Report};
use catamaran_bench::exchange::{get_vector, put_vector};
use catamaran_bench::race::median;
use catamaran_bench::{Result, host, input, record};
use catamaran_geometry::mesh::{LaplacianKind, LaplacianOptions, TriMesh, laplacian};

use super::Contest;
use super::spectrum::meshes;

/// Right-hand sides.
const RIGHT: usize = 8;

/// The meshes of CATAMARAN_DATA that are raced by default: 43k, 317k and 1.24 M vertices.
const MESHES: [&str; 3] = ["armadillo43k.obj.gz", "mni152_wm317k.ply.xz", "mni152_wm1p24M.ply.xz"];

#[derive(clap::Args)]
pub struct Arguments {
    /// Meshes; by default the armadillo and two of a brain (43k, 317k and 1.24 M vertices) where
    /// CATAMARAN_DATA (default ../shared) has them, else a generated terrain of 100,489 vertices.
    meshes: Vec<PathBuf>,
    #[command(flatten)]
    contest: Contest,
}

pub fn run(arguments: &Arguments) -> Result<()> {
    if let Some(folder) = &arguments.contest.solve {
        return solve(folder, arguments.contest.threads[0]);
    }
    let cholmod = arguments.contest.libraries.join("bin/cholmod");
    if !cholmod.exists() {
        return Err("no CHOLMOD: run scripts/rivals first".into());
    }
    let host = host::describe(&[]);
    println!("{host}\nseconds: ours, and CHOLMOD's\n");
    println!(
        "{:<14} {:>9} {:>2} {:>7} {:>7} {:>7} {:>7} {:>7} {:>7} {:>9} {:>9} {:>9} {:>9}",
        "mesh",
        "vertices",
        "th",
        "analyse",
        "",
        "factor",
        "",
        "solve",
        "",
        "entries",
        "",
        "residual",
        ""
    );
    let mut lines = Vec::new();
    let mut paths = arguments.meshes.clone();
    if paths.is_empty() {
        let folder = input::data_folder().join("meshes");
        paths.extend(MESHES.map(|name| folder.join(name)).into_iter().filter(|path| path.exists()));
    }
    for (name, mesh) in meshes(&paths)? {
        let folder = tempfile::tempdir()?;
        let place = folder.path().display().to_string();
        let n = prepare(folder.path(), &mesh)?;
        for &threads in &arguments.contest.threads {
            let t = threads.to_string();
            let ours = ["cholesky", "--solve", &place, "--threads", &t];
            let found = race(&ours, &cholmod, &place, threads, arguments.contest.repeat)?;
            let [ours, theirs] = &found;
            print!("{name:<14} {n:>9} {threads:>2}");
            (0..3).for_each(|k| print!(" {:>7.3} {:>7.3}", ours[k], theirs[k]));
            print!(" {:>9.0} {:>9.0}", ours[3], theirs[3]);
            println!(" {:>9.1e} {:>9.1e}", ours[4], theirs[4]);
            let both = ours.iter().zip(theirs).map(|(a, b)| format!("{a:.4e},{b:.4e}"));
            let both: Vec<_> = both.collect();
            let repeat = arguments.contest.repeat;
            lines.push(format!("{name},{n},{threads},{repeat},{}", both.join(",")));
        }
    }
    if let Some(name) = &arguments.contest.record {
        let header = "mesh,vertices,threads,repetitions,ours_analysis_s,cholmod_analysis_s,\
                      ours_factor_s,cholmod_factor_s,ours_solve_s,cholmod_solve_s,ours_entries,\
                      cholmod_entries,ours_residual,cholmod_residual";
        let (name, csv) = (format!("{name}.csv"), record::csv(header, lines));
        println!("\nrecorded in {}", record::write(&[(&name, csv), ("host.txt", host)])?.display());
    }
    Ok(())
}

/// Runs both in turns; returns the medians of the further numbers of their reports.
fn race(
    ours: &[&str],
    cholmod: &Path,
    place: &str,
    threads: usize,
    repeat: usize,
) -> Result<[Vec<f64>; 2]> {
    let this = std::env::current_exe()?;
    let mut reports = [Vec::new(), Vec::new()];
    for _ in 0..repeat.max(1) {
        reports[0].push(child::run(&this, ours, threads)?.rest);
        reports[1].push(child::run(cholmod, &[place], threads)?.rest);
    }
    if reports.iter().flatten().any(|rest| rest.len() != 5) {
        return Err("cholesky: a report without all numbers".into());
    }
    let number = |reports: &[Vec<f64>], k: usize| median(reports.iter().map(|r| r[k]).collect());
    Ok(reports.map(|reports| (0..5).map(|k| number(&reports, k)).collect()))
}

/// Writes the matrix and the right-hand sides for both contenders; returns the number of rows.
fn prepare(folder: &Path, mesh: &TriMesh) -> Result<usize> {
    // Faces without area have the tufted kind only.
    let tufted = LaplacianOptions::new().kind(LaplacianKind::Tufted);
    let problem =
        laplacian(mesh, &LaplacianOptions::new()).or_else(|_| laplacian(mesh, &tufted))?;
    let mut matrix = problem.stiffness;
    let n = matrix.rows();
    for i in 0..n {
        let entry = matrix.get_mut(i, i).ok_or("a row without a diagonal entry")?;
        *entry += problem.mass.diagonal(i);
    }
    let as_f64 = |indices: &[usize]| indices.iter().map(|&i| i as f64).collect::<Vec<_>>();
    put_vector(folder, "data", matrix.data())?;
    put_vector(folder, "indices", &as_f64(matrix.indices()))?;
    put_vector(folder, "indptr", &as_f64(matrix.indptr().raw_storage()))?;
    let mut rng = Rng::new(1);
    let right: Vec<f64> = (0..RIGHT * n).map(|_| rng.uniform() - 0.5).collect();
    put_vector(folder, "right", &right)?;
    Ok(n)
}

/// Solves the problem with this library, in a separate process.
fn solve(folder: &Path, threads: usize) -> Result<()> {
    let [indptr, indices] = ["indptr", "indices"].map(|name| get_vector(folder, name));
    let whole = |values: Vec<f64>| values.into_iter().map(|x| x as usize).collect::<Vec<_>>();
    let (indptr, indices) = (whole(indptr?), whole(indices?));
    let n = indptr.len() - 1;
    let matrix = CsMat::new((n, n), indptr, indices, get_vector(folder, "data")?);
    let right = get_vector(folder, "right")?;
    let mut x = Mat::from_fn(n, RIGHT, |i, j| right[j * n + i]);
    let options = CholeskyOptions::new().threads(threads);
    child::forget_peak();
    let [before, _] = child::memory();
    let start = Instant::now();
    let mut cholesky = Cholesky::analyse(matrix.view(), &options)?;
    let analysis = start.elapsed().as_secs_f64();
    cholesky.factor(matrix.view(), Progress::none())?;
    let factor = start.elapsed().as_secs_f64() - analysis;
    cholesky.solve_in_place(x.as_mut())?;
    let all = start.elapsed().as_secs_f64();
    let [_, peak] = child::memory();
    let mut image = Mat::zeros(n, RIGHT);
    multiply(matrix.view(), x.as_ref(), image.as_mut(), Par::Seq)?;
    let gap = |j: usize, i: usize| (image[(i, j)] - right[j * n + i]).abs();
    let residual = (0..RIGHT)
        .flat_map(|j| (0..n).map(move |i| (j, i)))
        .map(|(j, i)| gap(j, i))
        .fold(0.0, f64::max);
    let rest = [analysis, factor, all - analysis - factor, cholesky.entries() as f64, residual];
    println!("{}", Report::line(all, peak.saturating_sub(before), &rest));
    Ok(())
}
