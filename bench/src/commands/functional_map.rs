//! `functional-map`: a functional map fitted to descriptors and refined by ZoomOut, beside pyfmaps,
//! each in a separate process.

use std::path::Path;
use std::time::Instant;

use catamaran::Par;
use catamaran::base::Progress;
use catamaran::faer::Mat;
use catamaran::sparse::Mass;
use catamaran_bench::child::{self, Duel, Report};
use catamaran_bench::exchange::{get, get_vector, put, put_vector};
use catamaran_bench::spectral::{Pair, Shape, Shapes};
use catamaran_bench::{Result, host, record};
use catamaran_geometry::spectral::Eigenbasis;
use catamaran_geometry::spectral::descriptors::{wave_kernel_signature, wave_scales};
use catamaran_geometry::spectral::functional_map::{MapFit, zoomout};

/// Number of descriptors: energies of the wave kernel signature.
const DESCRIPTORS: usize = 40;

use super::Contest;

#[derive(clap::Args)]
pub struct Arguments {
    /// Functions that are fitted, the constant one included.
    #[arg(short, default_value_t = 20)]
    k: usize,
    /// Functions that ZoomOut ends with.
    #[arg(long, default_value_t = 100)]
    functions: usize,
    /// Functions more in each of its steps.
    #[arg(long, default_value_t = 5)]
    step: usize,
    #[command(flatten)]
    contest: Contest,
}

pub fn run(arguments: &Arguments) -> Result<()> {
    if let Some(folder) = &arguments.contest.solve {
        return solve(folder, arguments);
    }
    if arguments.functions < arguments.k || arguments.step == 0 {
        return Err("--functions must be more than --k, and --step at least 1".into());
    }
    let python =
        child::python(&arguments.contest.libraries).ok_or("no scipy: run scripts/rivals first")?;
    let host = host::describe(&[]);
    let (k, most, step) = (arguments.k, arguments.functions, arguments.step);
    println!("{host}\n{k} functions fitted, then by {step} to {most}\n");
    println!(
        "{:<32} {:>9} {:>2} {:>8} {:>8} {:>6} {:>8} {:>8} {:>7} {:>7} {:>8} {:>8}",
        "pair",
        "vertices",
        "th",
        "ours s",
        "pyfmaps",
        "ratio",
        "fit s",
        "pyfmaps",
        "ours MB",
        "pyfmaps",
        "error",
        "pyfmaps"
    );
    let mut lines = Vec::new();
    for pair in pairs(most)? {
        let folder = tempfile::tempdir()?;
        prepare(folder.path(), &pair)?;
        let name = format!("{} to {}", pair.source.name, pair.target.name);
        let n = pair.target.mesh.vertices().len();
        for &threads in &arguments.contest.threads {
            let place = folder.path().display().to_string();
            let [k, step, t] = [k, step, threads].map(|number| number.to_string());
            let ours =
                ["functional-map", "--solve", &place, "-k", &k, "--step", &step, "--threads", &t];
            let rival = ("functional_map.py", &[place.as_str(), &k, &step][..]);
            let duel = Duel::new(&ours, &python, rival, threads, arguments.contest.repeat)?;
            let ([ours, theirs], ratio) = (duel.seconds(), duel.ratio());
            let [fit, their_fit] =
                duel.rest().map(|rest| rest.first().copied().unwrap_or(f64::NAN));
            let [mb, their_mb] = duel.bytes().map(|bytes| bytes / 1e6);
            let error = |file: &str| -> Result<f64> {
                Ok(distance(&pair, &get_vector(folder.path(), file)?))
            };
            let (error, their_error) = (error("our-points")?, error("points")?);
            println!(
                "{name:<32} {n:>9} {threads:>2} {ours:>8.3} {theirs:>8.3} {ratio:>6.2} {fit:>8.3} {their_fit:>8.3} \
                 {mb:>7.0} {their_mb:>7.0} {error:>8.5} {their_error:>8.5}"
            );
            lines.push(format!(
                "{name},{n},{k},{most},{step},{threads},{},{ours:.4},{theirs:.4},{ratio:.3},{fit:.4},{their_fit:.4},\
                 {mb:.0},{their_mb:.0},{error:.6},{their_error:.6}",
                arguments.contest.repeat
            ));
        }
    }
    if let Some(name) = &arguments.contest.record {
        let header = "pair,vertices,k,functions,step,threads,repetitions,ours_s,pyfmaps_s,ratio,ours_fit_s,\
                      pyfmaps_fit_s,ours_mb,pyfmaps_mb,ours_error,pyfmaps_error";
        let (name, csv) = (format!("{name}.csv"), record::csv(header, lines));
        println!("\nrecorded in {}", record::write(&[(&name, csv), ("host.txt", host)])?.display());
    }
    Ok(())
}

/// Returns two poses of a figure, and two people if there are data.
fn pairs(functions: usize) -> Result<Vec<Pair>> {
    let shapes = Shapes::new(false);
    let poses = shapes.isometric(functions - 1)?.into_iter().take(1);
    Ok(poses.chain(shapes.people(functions - 1)?.into_iter().take(1)).collect())
}

/// Returns the mean distance of the points of the source from the true ones, relative to the square
/// root of its area.
fn distance(pair: &Pair, points: &[f64]) -> f64 {
    let position = |v: usize| pair.source.mesh.vertices()[v];
    let apart = |(&found, &truth): (&f64, &u32)| {
        let (p, q) = (position(found as usize), position(truth as usize));
        (0..3).map(|i| (p[i] - q[i]).powi(2)).sum::<f64>().sqrt()
    };
    points.iter().zip(&pair.truth).map(apart).sum::<f64>() / points.len().max(1) as f64
}

/// Writes the problem for both contenders.
fn prepare(folder: &Path, pair: &Pair) -> Result<()> {
    for (side, shape) in [("source", &*pair.source), ("target", &*pair.target)] {
        let Shape { mesh, eigenbasis, .. } = shape;
        let Mass::Lumped(mass) = eigenbasis.basis().mass() else {
            return Err("a full mass".into());
        };
        let name = |what: &str| format!("{what}_{side}");
        let (points, faces) = (mesh.vertices(), mesh.faces());
        let (values, functions) = (eigenbasis.values(), eigenbasis.functions());
        let waves = wave_scales(values, DESCRIPTORS)?;
        let descriptors = wave_kernel_signature(values, functions, &waves, Par::all())?;
        put(
            folder,
            &name("vertices"),
            Mat::from_fn(points.len(), 3, |i, j| points[i][j]).as_ref(),
        )?;
        let faces = Mat::from_fn(faces.len(), 3, |i, j| f64::from(faces[i][j]));
        put(folder, &name("faces"), faces.as_ref())?;
        put_vector(folder, &name("values"), values)?;
        put(folder, &name("functions"), functions)?;
        put_vector(folder, &name("mass"), mass)?;
        put(folder, &name("descriptors"), descriptors.as_ref())?;
    }
    Ok(())
}

/// Solves the problem with this library, in a separate process.
fn solve(folder: &Path, arguments: &Arguments) -> Result<()> {
    let par = Par::Threads(arguments.contest.threads[0]);
    let basis = |side: &str| -> Result<Eigenbasis> {
        let of = |what: &str| format!("{what}_{side}");
        let mass = Mass::Lumped(get_vector(folder, &of("mass"))?);
        let values = get_vector(folder, &of("values"))?;
        Ok(Eigenbasis::new(values, get(folder, &of("functions"))?, mass)?)
    };
    let (source, target) = (basis("source")?, basis("target")?);
    let [f, g] = ["source", "target"].map(|side| get(folder, &format!("descriptors_{side}")));
    let (f, g) = (f?, g?);
    child::forget_peak();
    let [before, _] = child::memory();
    let start = Instant::now();
    let (few, few_target) = (source.truncated(arguments.k)?, target.truncated(arguments.k)?);
    let mut fit = MapFit::new(&few, &few_target, par);
    fit.functions(f.as_ref(), g.as_ref())?;
    let c = fit.solve(MapFit::COMMUTATIVITY)?;
    let fitted = start.elapsed().as_secs_f64();
    let refined =
        zoomout(c.as_ref(), source.basis(), target.basis(), arguments.step, par, Progress::none())?;
    let seconds = start.elapsed().as_secs_f64();
    let [_, peak] = child::memory();
    let points: Vec<f64> = refined.points.into_iter().map(f64::from).collect();
    put_vector(folder, "our-points", &points)?;
    println!("{}", Report::line(seconds, peak.saturating_sub(before), &[fitted]));
    Ok(())
}
