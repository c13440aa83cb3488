//! Summarizes a set of races for every contender.

use super::{Contender, Row, Soundness};

/// The values of one run for a [`summary`].
#[derive(Debug, Clone)]
pub struct Run {
    /// Index of the mesh and number of vertices: runs of the same case are compared.
    pub case: usize,
    /// The contender.
    pub contender: Contender,
    /// Number of vertices of the result over the requested number.
    pub size: f64,
    /// Number of intersecting faces in excess of the input, relative to the faces of the result.
    pub excess: f64,
    /// Whether the topology is that of the input; `None` when that is not a manifold.
    pub topology: Option<bool>,
    /// Hausdorff distance from the input.
    pub hausdorff: f64,
    /// Mean quality of the faces.
    pub quality: f64,
    /// Seconds.
    pub seconds: f64,
}

impl Run {
    /// Creates the run of a contender that was asked for `n` vertices.
    pub fn new(case: usize, input: &Soundness, n: usize, row: &Row) -> Self {
        let measures = &row.measures;
        let more = measures.soundness.intersecting.more_than(&input.intersecting);
        Self {
            case,
            contender: row.contender,
            size: measures.vertices as f64 / n as f64,
            excess: more as f64 / measures.faces as f64,
            topology: measures.soundness.is_topology_of(input),
            hausdorff: measures.hausdorff(),
            quality: measures.quality.mean_quality,
            seconds: row.seconds,
        }
    }

    /// Returns whether the result has about the requested size, so that its distances are
    /// comparable.
    fn has_size(&self) -> bool {
        (self.size - 1.0).abs() <= SIZE_TOLERANCE
    }
}

/// Largest relative deviation of the size of results whose distances are compared.
const SIZE_TOLERANCE: f64 = 0.05;

/// Returns a table of all contenders, whose columns README.md explains.
pub fn summary(runs: &[Run]) -> String {
    let titles = "| contender | runs | of n vertices | without new intersections | largest share of new ones | topology kept \
                  | ours is as near | Q | s | x ours |\n|---|---|---|---|---|---|---|---|---|---|";
    let lines = Contender::ALL.map(|contender| line(contender, runs)).into_iter().flatten();
    lines.fold(titles.to_owned(), |text, line| text + "\n" + &line)
}

/// Returns the line of a contender; `None` when it did not run.
fn line(contender: Contender, runs: &[Run]) -> Option<String> {
    let own: Vec<&Run> = runs.iter().filter(|run| run.contender == contender).collect();
    if own.is_empty() {
        return None;
    }
    let count = |is: &dyn Fn(&Run) -> bool| own.iter().filter(|run| is(run)).count();
    let of_ours = |run: &Run| {
        runs.iter().find(|other| other.case == run.case && other.contender == Contender::Ours)
    };
    let pairs: Vec<(&Run, &Run)> =
        own.iter().filter_map(|run| Some((*run, of_ours(run)?))).collect();
    let compared: Vec<_> =
        pairs.iter().filter(|(run, ours)| run.has_size() && ours.has_size()).collect();
    let near = compared.iter().filter(|(run, ours)| ours.hausdorff <= run.hausdorff).count();
    let [seconds, our_seconds] = pairs.iter().fold([0.0, 0.0], |[all, of_ours], (run, ours)| {
        [all + run.seconds, of_ours + ours.seconds]
    });
    Some(format!(
        "| {} | {} | {} | {} | {:.2} % | {} of {} | {near} of {} | {:.3} | {seconds:.2} | {:.2} |",
        contender.name(),
        own.len(),
        count(&Run::has_size),
        count(&|run| run.excess == 0.0),
        100.0 * own.iter().map(|run| run.excess).fold(0.0, f64::max),
        count(&|run| run.topology == Some(true)),
        count(&|run| run.topology.is_some()),
        compared.len(),
        own.iter().map(|run| run.quality).sum::<f64>() / own.len() as f64,
        seconds / our_seconds
    ))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn contenders_are_summed_up_beside_ours() {
        let ours = Run {
            case: 0,
            contender: Contender::Ours,
            size: 1.0,
            excess: 0.0,
            topology: Some(true),
            hausdorff: 0.02,
            quality: 0.9,
            seconds: 0.5,
        };
        let theirs =
            Run { contender: Contender::Pyacvd, seconds: 2.0, quality: 0.5, ..ours.clone() };
        let runs = [
            ours.clone(),
            Run { excess: 0.25, topology: Some(false), ..theirs.clone() },
            Run { case: 1, topology: None, ..ours.clone() },
            // Nearer, but with more vertices than requested.
            Run {
                case: 1,
                size: 1.2,
                hausdorff: 0.0,
                topology: None,
                quality: 0.7,
                ..theirs.clone()
            },
            // No run to compare with.
            Run { case: 2, hausdorff: 0.0, quality: 0.9, seconds: 50.0, ..theirs },
        ];
        let table = summary(&runs);
        let lines: Vec<_> = table.lines().skip(2).collect();
        assert_eq!(
            lines,
            [
                "| ours | 2 | 2 | 2 | 0.00 % | 1 of 1 | 2 of 2 | 0.900 | 1.00 | 1.00 |",
                "| pyacvd | 3 | 2 | 2 | 25.00 % | 1 of 2 | 1 of 1 | 0.700 | 4.00 | 4.00 |",
            ]
        );
        let columns = table.lines().map(|line| line.matches('|').count());
        assert!(columns.clone().all(|count| count == columns.clone().next().unwrap()));
    }
}
