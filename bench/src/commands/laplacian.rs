//! `laplacian`: the tufted Laplacian of meshes beside robust_laplacian's, each in a separate
//! process.

use std::path::{Path, PathBuf};
use std::time::Instant;

use catamaran::Par;
use catamaran::faer::{Mat, MatRef};
use catamaran::sparse::{Mass, multiply};
use catamaran_bench::child::{self, Duel, Report};
use catamaran_bench::exchange::{get, put};
use catamaran_bench::{Result, host, record};
use catamaran_geometry::mesh::{Laplacian, LaplacianKind, LaplacianOptions, TriMesh, laplacian};

use super::Contest;
use super::spectrum::meshes;

#[derive(clap::Args)]
pub struct Arguments {
    /// Meshes; by default a generated terrain of 100,489 vertices, and the armadillo if
    /// CATAMARAN_DATA (default ../shared) has it.
    meshes: Vec<PathBuf>,
    #[command(flatten)]
    contest: Contest,
}

pub fn run(arguments: &Arguments) -> Result<()> {
    if let Some(folder) = &arguments.contest.solve {
        return solve(folder, arguments.contest.threads[0]);
    }
    let python =
        child::python(&arguments.contest.libraries).ok_or("no scipy: run scripts/rivals first")?;
    let host = host::describe(&[]);
    println!("{host}");
    println!(
        "{:<14} {:>9} {:>2} {:>9} {:>9} {:>6} {:>7} {:>7} {:>10}",
        "mesh", "vertices", "th", "ours s", "robust s", "ratio", "ours MB", "robust", "difference"
    );
    let mut lines = Vec::new();
    for (name, mesh) in meshes(&arguments.meshes)? {
        let folder = tempfile::tempdir()?;
        let n = mesh.vertices().len();
        let place = folder.path().display().to_string();
        prepare(folder.path(), &mesh)?;
        for &threads in &arguments.contest.threads {
            let t = threads.to_string();
            let ours = ["laplacian", "--solve", &place, "--threads", &t];
            let rival = ("laplacian.py", &[place.as_str()][..]);
            let duel = Duel::new(&ours, &python, rival, threads, arguments.contest.repeat)?;
            let ([ours, robust], ratio) = (duel.seconds(), duel.ratio());
            let [mb, robust_mb] = duel.bytes().map(|bytes| bytes / 1e6);
            // Area and energies, which a Delaunay triangulation determines.
            let [mine, theirs] = duel.rest();
            let pairs = mine.iter().zip(theirs);
            let difference = pairs.map(|(x, y)| (x - y).abs() / y.abs()).fold(0.0, f64::max);
            println!(
                "{name:<14} {n:>9} {threads:>2} {ours:>9.3} {robust:>9.3} {ratio:>6.2} {mb:>7.0} {robust_mb:>7.0} \
                 {difference:>10.1e}"
            );
            lines.push(format!(
                "{name},{n},{threads},{},{ours:.4},{robust:.4},{ratio:.3},{mb:.0},{robust_mb:.0},{difference:.2e}",
                arguments.contest.repeat
            ));
        }
    }
    if let Some(name) = &arguments.contest.record {
        let header =
            "mesh,vertices,threads,repetitions,ours_s,robust_s,ratio,ours_mb,robust_mb,difference";
        let (name, csv) = (format!("{name}.csv"), record::csv(header, lines));
        println!("\nrecorded in {}", record::write(&[(&name, csv), ("host.txt", host)])?.display());
    }
    Ok(())
}

/// Writes the mesh for both contenders.
fn prepare(folder: &Path, mesh: &TriMesh) -> Result<()> {
    let (points, faces) = (mesh.vertices(), mesh.faces());
    let points = Mat::from_fn(points.len(), 3, |i, j| points[i][j]);
    put(folder, "vertices", points.as_ref())?;
    put(folder, "faces", Mat::from_fn(faces.len(), 3, |i, j| f64::from(faces[i][j])).as_ref())
}

/// Solves the problem with this library, in a separate process.
fn solve(folder: &Path, threads: usize) -> Result<()> {
    let (points, faces) = (get(folder, "vertices")?, get(folder, "faces")?);
    let row = |matrix: &Mat<f64>, i: usize| [matrix[(i, 0)], matrix[(i, 1)], matrix[(i, 2)]];
    let mesh = TriMesh::new(
        (0..points.nrows()).map(|i| row(&points, i)).collect(),
        (0..faces.nrows()).map(|i| row(&faces, i).map(|v| v as u32)).collect(),
    )?;
    let par = Par::Threads(threads);
    child::forget_peak();
    let [before, _] = child::memory();
    let start = Instant::now();
    let options = LaplacianOptions::new().kind(LaplacianKind::Tufted).par(par);
    let found = laplacian(&mesh, &options)?;
    let seconds = start.elapsed().as_secs_f64();
    let [_, peak] = child::memory();
    println!(
        "{}",
        Report::line(seconds, peak.saturating_sub(before), &outcome(&found, points.as_ref())?)
    );
    Ok(())
}

/// Returns the area, and the energies of the coordinates.
fn outcome(found: &Laplacian, points: MatRef<'_, f64>) -> Result<Vec<f64>> {
    let Mass::Lumped(mass) = &found.mass else { return Err("a full mass".into()) };
    let x = found.restrict(points)?;
    let mut image = Mat::zeros(x.nrows(), 3);
    multiply(found.stiffness.view(), x.as_ref(), image.as_mut(), Par::Seq)?;
    let energies = (0..3).map(|j| x.col(j).transpose() * image.col(j));
    Ok(std::iter::once(mass.iter().sum()).chain(energies).collect())
}
