//! Real people and other shapes, cut in the same way as for the training.

use std::collections::BTreeSet;
use std::path::Path;

use catamaran::Par;
use catamaran_bench::{Result, input};
use catamaran_geometry::unions::SpectralUnion;
use catamaran_training::evaluate::{
    BodyCut, DOCUMENTED_THRESHOLD, Judgement, Minimum, REAL_SHAPES, RealShape, errors,
};

use super::super::Report;

/// Reports the errors on each cut of each shape; returns judgements of the predictions.
pub fn table(report: &mut Report, model: &SpectralUnion) -> Result<Vec<Judgement>> {
    let folder = input::data_folder().join("meshes");
    let found = REAL_SHAPES.iter().map(|shape| Cuts::of(shape, &folder, model));
    let (people, others): (Vec<Cuts>, Vec<Cuts>) =
        found.collect::<Result<Vec<_>>>()?.into_iter().partition(|cuts| cuts.shape.human);
    report.say(
        "## Real shapes\n\nThe spectra of two parts of a shape and of their union, all computed; mean relative errors. Goal on people: \
         10 %. Cuts in brackets have another union if a part is mirrored, and are left out of the means.\n\n\
         | shape | cut | network % | minimum % | score |\n|---|---|---|---|---|",
    );
    people.iter().for_each(|cuts| row_for_each(report, cuts));
    let clear: Vec<&Done> = people.iter().flat_map(Cuts::clear).collect();
    let [network, minimum] = means(&clear);
    report.say(&format!("| **all** | {} | **{network}** | {minimum} | |", clear.len()));
    report.say(
        "\nOthers, cut likewise; last, cuts that are not pairs as the data set has them.\n\n\
         | shape | cuts | network % | minimum % | score > 1, % | left out |\n|---|---|---|---|---|---|",
    );
    others.iter().for_each(|cuts| row(report, cuts));
    report.say("");
    let all = people.iter().chain(&others);
    Ok(all.flat_map(Cuts::clear).map(|done| done.judgement).collect())
}

/// A cut, and the results of its prediction.
struct Done {
    cut: &'static BodyCut,
    judgement: Judgement,
    /// Error of the minimum of both spectra.
    minimum: f64,
}

/// The results for a shape.
struct Cuts {
    shape: &'static RealShape,
    done: Vec<Done>,
    /// Why other cuts are left out.
    left_out: Vec<String>,
}

impl Cuts {
    fn of(shape: &'static RealShape, folder: &Path, model: &SpectralUnion) -> Result<Self> {
        let mut found = Self { shape, done: vec![], left_out: vec![] };
        match shape.pairs(folder, Par::all()) {
            Err(why) => found.left_out.push(why.to_string()),
            Ok(pairs) => {
                for (cut, pair) in pairs {
                    match pair {
                        Err(why) => found.left_out.push(why.to_string()),
                        Ok(pair) => found.done.push(Done {
                            cut,
                            judgement: Judgement::of(model, &pair, shape.human)?,
                            minimum: errors(&Minimum, &[pair])?.relative,
                        }),
                    }
                }
            }
        }
        Ok(found)
    }

    fn clear(&self) -> impl Iterator<Item = &Done> {
        self.done.iter().filter(|done| done.cut.clear)
    }

    fn reasons(&self) -> String {
        let reasons: BTreeSet<&str> = self.left_out.iter().map(String::as_str).collect();
        match self.left_out.len() {
            0 => String::new(),
            count => {
                format!("{count}: {}", reasons.into_iter().collect::<Vec<_>>().join("; "))
            }
        }
    }

    fn lines(&self) -> impl Iterator<Item = String> {
        self.done.iter().flat_map(|Done { cut, judgement, minimum }| {
            let values = [
                ("network", "relative", judgement.error),
                ("minimum", "relative", *minimum),
                ("network", "ood_score", judgement.score),
            ];
            let (cut, shape) = (cut.name.replace(',', ""), self.shape.name);
            values.map(|(whose, what, value)| {
                format!("real,{cut},{shape},{whose},{what},{value:.6e}")
            })
        })
    }
}

fn row_for_each(report: &mut Report, cuts: &Cuts) {
    let name = cuts.shape.name;
    for Done { cut, judgement, minimum } in &cuts.done {
        let cut = if cut.clear { cut.name.into() } else { format!("({})", cut.name) };
        let Judgement { error, score, .. } = judgement;
        let [error, minimum] = [error, minimum].map(|x| 100.0 * x);
        report.say(&format!("| {name} | {cut} | {error:.1} | {minimum:.1} | {score:.2} |"));
    }
    if !cuts.left_out.is_empty() {
        report.say(&format!("| {name} | left out, {} | | | |", cuts.reasons()));
    }
    report.lines.extend(cuts.lines());
}

fn row(report: &mut Report, cuts: &Cuts) {
    let clear: Vec<&Done> = cuts.clear().collect();
    let [network, minimum] = means(&clear);
    let flagged = |done: &&&Done| done.judgement.score > DOCUMENTED_THRESHOLD;
    let flagged = percent(clear.iter().filter(flagged).count() as f64, clear.len(), 0);
    report.say(&format!(
        "| {} | {} | {network} | {minimum} | {flagged} | {} |",
        cuts.shape.name,
        clear.len(),
        cuts.reasons()
    ));
    report.lines.extend(cuts.lines());
}

/// Returns the mean errors of network and minimum, in per cent.
fn means(done: &[&Done]) -> [String; 2] {
    let sum = |of: fn(&Done) -> f64| done.iter().map(|done| of(done)).sum();
    [sum(|done| done.judgement.error), sum(|done| done.minimum)]
        .map(|sum| percent(sum, done.len(), 1))
}

fn percent(sum: f64, count: usize, digits: usize) -> String {
    match count {
        0 => "-".into(),
        _ => format!("{:.digits$}", 100.0 * sum / count as f64),
    }
}
