//! Races the water solver against others, each in a separate process, in turns.

use std::path::Path;
use std::time::Instant;

use catamaran::Par;
use catamaran::faer::MatRef;
use catamaran::io::{Matrix, Output, Overwrite, ReadOptions, read, write};
use catamaran_simulation::plant::families::{GrowthOptions, grow};
use catamaran_simulation::plant::{Bdf6, Start};

use super::{Part, Subject};
use crate::race::median;
use crate::{Result, child};

/// Number of steps that are timed together.
const STEPS: usize = 20;

/// Names of rivals in bench/rivals/plant.py, and the largest number of nodes that they get.
const RIVALS: [(&str, usize); 5] = [
    ("splu", 1_000_000),
    ("klu", 1_000_000),
    ("expm_multiply", 2_000),
    ("bdf", 10_000),
    ("cvode", 10_000),
];

/// Returns seconds of a factorization, of a step of BDF6 and of the water at the half-time, with
/// ours on two threads and on one, and the errors of the rivals' water relative to ours.
///
/// # Errors
/// When a process of ours fails; rivals that fail are left out.
pub fn race(largest: usize, repeat: usize, libraries: &Path) -> Result<Part> {
    let python = child::python(libraries);
    let mut rows = Vec::new();
    for nodes in
        [2_000, 10_000, 100_000, 1_000_000, 10_000_000].into_iter().filter(|n| *n <= largest)
    {
        let plant = grow(&GrowthOptions::new().nodes(nodes))?;
        let subject = Subject::new(format!("{nodes}"), plant)?;
        let folder = tempfile::tempdir()?;
        prepare(folder.path(), &subject)?;
        let mut ours: [Vec<[f64; 3]>; 2] = Default::default();
        let rivals: Vec<_> = RIVALS.iter().filter(|(_, most)| nodes <= *most).collect();
        let mut theirs: Vec<Vec<[f64; 4]>> = vec![vec![]; rivals.len()];
        for _ in 0..repeat {
            for (times, threads) in ours.iter_mut().zip([1, 2]) {
                times.push(run(&subject, threads)?);
            }
            let Some(python) = &python else { continue };
            for (times, (name, _)) in theirs.iter_mut().zip(&rivals) {
                let place = folder.path().display().to_string();
                match child::run(python, &[&child::script("plant.py"), &place, name], 1) {
                    Ok(report) => {
                        let at = |i: usize| report.rest.get(i).copied().unwrap_or(f64::NAN);
                        times.push([report.seconds, at(0), at(1), error(folder.path())?]);
                    }
                    Err(error) => eprintln!("left out: {error}"),
                }
            }
        }
        for (times, threads) in ours.iter().zip([1, 2]) {
            let name = format!("{nodes} nodes, ours, {threads} threads");
            rows.push((name, medians(times, &[0, 1, 2]).into_iter().chain([f64::NAN]).collect()));
        }
        for (times, (name, _)) in theirs.iter().zip(&rivals).filter(|(times, _)| !times.is_empty())
        {
            let mut values = medians(times, &[1, 2, 0]);
            values.push(median(times.iter().map(|t| t[3]).collect()));
            rows.push((format!("{nodes} nodes, {name}"), values));
        }
    }
    let columns = ["factor, s", "step, s", "water at the half-time, s", "error beside ours"];
    Ok(Part {
        figure: "race",
        title: format!("generated plants, medians of {repeat} interleaved runs"),
        columns: columns.map(String::from).into(),
        rows,
        plots: vec![],
    })
}

fn medians<const N: usize>(times: &[[f64; N]], order: &[usize]) -> Vec<f64> {
    order.iter().map(|&i| median(times.iter().map(|t| t[i]).collect())).collect()
}

/// Returns seconds of a factorization, a step and the water at the half-time.
fn run(subject: &Subject, threads: usize) -> Result<[f64; 3]> {
    let par = if threads == 1 { Par::Seq } else { Par::Threads(threads) };
    let full = subject.model.full();
    let step = subject.half_time() / 16.0;
    let mut bdf = Bdf6::new(&subject.model, &full, step, Start::Constant, par)?;
    let start = Instant::now();
    bdf.restart(&subject.model, step)?;
    let factor = start.elapsed().as_secs_f64();
    bdf.step();
    let start = Instant::now();
    (0..STEPS).for_each(|_| bdf.step());
    let one = start.elapsed().as_secs_f64() / STEPS as f64;
    let start = Instant::now();
    subject.model.water_after(&full, subject.half_time(), par)?;
    Ok([factor, one, start.elapsed().as_secs_f64()])
}

/// Writes the problem, and our solution, for the rivals.
fn prepare(folder: &Path, subject: &Subject) -> Result<()> {
    let put = |name: &str, values: &[f64]| -> Result<()> {
        let output = Output::create(&folder.join(name), Overwrite::Replace)?;
        Ok(write(output, MatRef::from_column_major_slice(values, values.len(), 1))?)
    };
    let model = &subject.model;
    let parents: Vec<f64> =
        (0..model.len()).map(|v| subject.plant.parent(v).map_or(-1.0, |p| p as f64)).collect();
    put("parents.npy", &parents)?;
    put("full.npy", &model.full())?;
    put("exchanges.npy", &model.exchanges())?;
    put("losses.npy", &model.losses())?;
    put("seconds.npy", &[subject.half_time()])?;
    put("ours.npy", &model.water_after(&model.full(), subject.half_time(), Par::all())?)
}

/// Returns the largest difference of a rival's water from ours, relative to the largest water.
fn error(folder: &Path) -> Result<f64> {
    let get = |name: &str| -> Result<Vec<f64>> {
        match read(&folder.join(name), &ReadOptions::default())? {
            Matrix::F64(dense) => Ok(dense.as_ref().col(0).iter().copied().collect()),
            _ => Err(format!("{name}: the numbers must be doubles").into()),
        }
    };
    let (ours, theirs) = (get("ours.npy")?, get("theirs.npy")?);
    let largest = ours.iter().copied().fold(0.0, f64::max);
    let gaps = ours.iter().zip(&theirs).map(|(a, b)| (a - b).abs() / largest);
    Ok(gaps.fold(0.0, f64::max))
}
