//! Contenders side by side.

use catamaran::mesh::TriMesh;

use super::{Contender, Input, Inputs, Job, Measures, Rivals};
use crate::Result;
use crate::child::Report;
use crate::race::median;

/// One contender at one mesh.
pub struct Row {
    /// Who.
    pub contender: Contender,
    /// Repetitions measured.
    pub repetitions: usize,
    /// Median seconds.
    pub seconds: f64,
    /// Its seconds over ours (or over those of the first contender): the median over the repetitions.
    pub ratio: f64,
    /// Median bytes at the peak, less those before the call.
    pub bytes: f64,
    /// The result.
    pub made: TriMesh,
    /// What it is like.
    pub measures: Measures,
}

impl Row {
    /// The columns of [`line`](Self::line).
    pub const HEADER: &str = "contender,repetitions,seconds,ratio,mb,vertices,faces,quality,quality_deviation,\
                              least_quality,mean_area,area_variation,non_manifold_edges,components,hausdorff,chamfer";

    /// For a record.
    pub fn line(&self) -> String {
        let Measures { vertices, faces, components, quality: q, difference } = &self.measures;
        format!(
            "{},{},{:.4},{:.3},{:.0},{vertices},{faces},{:.4},{:.4},{:.4},{:.4e},{:.4},{},{components},{:.3e},{:.3e}",
            self.contender.name(),
            self.repetitions,
            self.seconds,
            self.ratio,
            self.bytes / 1e6,
            q.mean_quality,
            q.quality_deviation,
            q.least_quality,
            q.mean_area,
            q.area_variation,
            q.non_manifold_edges,
            difference.hausdorff,
            difference.chamfer
        )
    }

    /// The columns of [`markdown`](Self::markdown).
    pub const TITLES: &str = "| contender | s | x ours | MB | vertices | Q | CV | least Q | non-manifold | components \
                              | Hausdorff | Chamfer |\n|---|---|---|---|---|---|---|---|---|---|---|---|";

    /// For people.
    pub fn markdown(&self) -> String {
        let Measures { vertices, components, quality: q, difference, .. } = &self.measures;
        format!(
            "| {} | {:.2} | {:.2} | {:.0} | {vertices} | {:.3} | {:.3} | {:.3} | {} | {components} | {:.1e} | {:.1e} |",
            self.contender.name(),
            self.seconds,
            self.ratio,
            self.bytes / 1e6,
            q.mean_quality,
            q.area_variation,
            q.least_quality,
            q.non_manifold_edges,
            difference.hausdorff,
            difference.chamfer
        )
    }
}

/// How long a contender may take to be measured again, in seconds.
const PATIENCE: f64 = 30.0;

/// `contenders` that are installed decimate `input` to `n` vertices, in turn, `repeat` times. Slow ones are measured once,
/// those that fail are left out with a line on stderr.
///
/// # Errors
/// When no result can be read.
pub fn race(
    contenders: &[Contender],
    rivals: &Rivals,
    inputs: &Inputs,
    input: &Input,
    n: usize,
    threads: usize,
    repeat: usize,
) -> Result<Vec<Row>> {
    let mut runs: Vec<(Contender, Vec<Option<Report>>)> =
        contenders.iter().filter(|c| rivals.have(**c)).map(|c| (*c, Vec::new())).collect();
    let output =
        |contender: Contender| inputs.scratch().join(format!("made-{}.ply", contender.name()));
    for repetition in 0..repeat {
        for (contender, reports) in &mut runs {
            let slow = reports.iter().flatten().any(|report| report.seconds > PATIENCE);
            let failed = repetition > 0 && reports[0].is_none();
            if slow || failed {
                reports.push(None);
                continue;
            }
            let job = Job { input: &input.path, n, threads, output: &output(*contender) };
            reports.push(contender.run(rivals, &job).map_or_else(
                |error| {
                    eprintln!("{} at {}: {error}", contender.name(), input.name);
                    None
                },
                Some,
            ));
        }
    }
    let Some((_, yardstick)) = runs.first() else { return Ok(Vec::new()) };
    let mut rows = Vec::new();
    for (contender, reports) in &runs {
        let measured: Vec<_> = reports.iter().flatten().collect();
        if measured.is_empty() {
            continue;
        }
        let pairs = reports.iter().zip(yardstick);
        let ratios =
            pairs.filter_map(|(own, first)| Some(own.as_ref()?.seconds / first.as_ref()?.seconds));
        let made = catamaran::mesh::io::read(&output(*contender))?.mesh;
        rows.push(Row {
            contender: *contender,
            repetitions: measured.len(),
            seconds: median(measured.iter().map(|report| report.seconds).collect()),
            ratio: median(ratios.collect()),
            bytes: median(measured.iter().map(|report| report.bytes).collect()),
            measures: Measures::new(&input.mesh, &made)?,
            made,
        });
    }
    Ok(rows)
}
