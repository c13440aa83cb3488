//! Races contenders of decimation.

use catamaran_geometry::mesh::TriMesh;

use super::measures::text;
use super::{Contender, Input, Inputs, Job, Measures, Rivals, Soundness};
use crate::Result;
use crate::child::Report;
use crate::race::median;

/// The result of one contender on one mesh.
pub struct Row {
    /// The contender.
    pub contender: Contender,
    /// Repetitions measured.
    pub repetitions: usize,
    /// Median seconds.
    pub seconds: f64,
    /// Ratio of its seconds to ours (or to those of the first contender): the median over the
    /// repetitions.
    pub ratio: f64,
    /// Median bytes at the peak, minus those before the call.
    pub bytes: f64,
    /// The resulting mesh.
    pub made: TriMesh,
    /// The measures of the result.
    pub measures: Measures,
}

impl Row {
    /// Returns the columns of [`line`](Self::line).
    pub fn header() -> String {
        format!(
            "contender,repetitions,seconds,ratio,mb,vertices,faces,quality,quality_deviation,least_quality,mean_area,\
             area_variation,{},hausdorff,input_to_result,result_to_input,mean_input_to_result,mean_result_to_input",
            Soundness::header("")
        )
    }

    /// Returns a line of a record.
    pub fn line(&self) -> String {
        let Measures { vertices, faces, soundness, quality: q, distances } = &self.measures;
        format!(
            "{},{},{:.4},{:.3},{:.0},{vertices},{faces},{:.4},{:.4},{:.4},{:.4e},{:.4},{},{:.3e},{:.3e},{:.3e},{:.3e},{:.3e}",
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
            soundness.line(),
            self.measures.hausdorff(),
            distances.out.largest,
            distances.back.largest,
            distances.out.mean,
            distances.back.mean
        )
    }

    /// The columns of [`markdown`](Self::markdown).
    pub const TITLES: &str = "| contender | s | x ours | MB | vertices | Q | CV | least Q | intersecting | non-manifold \
                              | components | loops | genus | Hausdorff | mean to result | mean to input |\n\
                              |---|---|---|---|---|---|---|---|---|---|---|---|---|---|---|---|";

    /// Returns a row of a Markdown table.
    pub fn markdown(&self) -> String {
        let Measures { vertices, soundness: s, quality: q, distances, .. } = &self.measures;
        format!(
            "| {} | {:.2} | {:.2} | {:.0} | {vertices} | {:.3} | {:.3} | {:.3} | {} | {} | {} | {} | {} | {:.1e} | {:.1e} | {:.1e} |",
            self.contender.name(),
            self.seconds,
            self.ratio,
            self.bytes / 1e6,
            q.mean_quality,
            q.area_variation,
            q.least_quality,
            s.intersecting,
            s.non_manifold_edges,
            s.components,
            text(&s.boundary_loops, "-"),
            text(&s.genus, "-"),
            self.measures.hausdorff(),
            distances.out.mean,
            distances.back.mean
        )
    }
}

/// Largest time of a contender, in seconds, for it to be measured again.
const PATIENCE: f64 = 30.0;

/// Decimates `input` to `n` vertices by the installed `contenders`, in turn, `repeat` times. Slow
/// contenders are measured once; those that fail are left out with a line on stderr.
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
    let faces = input.faces_for(n);
    for repetition in 0..repeat {
        for (contender, reports) in &mut runs {
            let slow = reports.iter().flatten().any(|report| report.seconds > PATIENCE);
            let failed = repetition > 0 && reports[0].is_none();
            if slow || failed {
                reports.push(None);
                continue;
            }
            let job = Job { input: &input.path, n, faces, threads, output: &output(*contender) };
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
    let finished: Vec<_> =
        runs.iter().filter(|(_, reports)| reports.iter().any(Option::is_some)).collect();
    let paths: Vec<_> = finished.iter().map(|(contender, _)| output(*contender)).collect();
    let paths: Vec<_> = paths.iter().map(|path| path.as_path()).collect();
    let mut rows = Vec::new();
    for ((contender, reports), cgal) in finished.iter().zip(rivals.intersecting_faces(&paths)) {
        let measured: Vec<_> = reports.iter().flatten().collect();
        let pairs = reports.iter().zip(yardstick);
        let ratios =
            pairs.filter_map(|(own, first)| Some(own.as_ref()?.seconds / first.as_ref()?.seconds));
        let made = catamaran_geometry::mesh::io::read(&output(*contender))?.mesh;
        rows.push(Row {
            contender: *contender,
            repetitions: measured.len(),
            seconds: median(measured.iter().map(|report| report.seconds).collect()),
            ratio: median(ratios.collect()),
            bytes: median(measured.iter().map(|report| report.bytes).collect()),
            measures: Measures::new(&input.mesh, &made, cgal)?,
            made,
        });
    }
    Ok(rows)
}
