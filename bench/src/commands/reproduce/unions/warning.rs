//! The predictions that a threshold of the out-of-distribution score detects.

use catamaran_bench::Result;
use catamaran_geometry::unions::SpectralUnion;
use catamaran_training::dataset::{Dataset, UNKNOWN_FAMILY};
use catamaran_training::evaluate::{
    DOCUMENTED_THRESHOLD, Detection, Judgement, THRESHOLDS, WRONG, select,
};

use super::super::Report;
use super::Test;

/// Reports precision and recall of thresholds, on the tests of the data set and on real shapes.
pub fn table(
    report: &mut Report,
    dataset: &Dataset,
    model: &SpectralUnion,
    real: &[Judgement],
) -> Result<()> {
    let mut tests = Vec::new();
    for test in Test::all() {
        let human = test.knowledge != UNKNOWN_FAMILY;
        for pair in select(dataset, test.split, test.knowledge, test.remeshed) {
            tests.push(Judgement::of(model, &pair, human)?);
        }
    }
    report.say(&format!(
        "## Warning\n\n`ood_score` above a threshold as a detector of predictions that are wrong by more than {:.0} % in the mean, and of \
         parts that are not of a human: precision is the share of what is flagged that is so, recall the share of what is so that is \
         flagged. In bold: the threshold of the documentation.",
        100.0 * WRONG
    ));
    for (name, judgements) in [("tests of the data set", &tests[..]), ("real shapes", real)] {
        of_set(report, name, judgements);
    }
    report.say("");
    Ok(())
}

fn of_set(report: &mut Report, name: &str, judgements: &[Judgement]) {
    let wrong: Vec<_> = judgements.iter().map(Judgement::wrong).collect();
    let not_human: Vec<_> = judgements.iter().map(Judgement::not_human).collect();
    let share = |of: &[(f64, bool)]| {
        let count = of.iter().filter(|(_, label)| *label).count();
        100.0 * count as f64 / of.len().max(1) as f64
    };
    report.say(&format!(
        "\n{} pairs of {name}: {:.1} % wrong, {:.1} % not human.\n\n\
         | threshold | flagged % | wrong: precision % | recall % | not human: precision % | recall % |\n|---|---|---|---|---|---|",
        judgements.len(),
        share(&wrong),
        share(&not_human)
    ));
    let percent = |share: Option<f64>| share.map_or("-".into(), |x| format!("{:.1}", 100.0 * x));
    for threshold in THRESHOLDS {
        let [wrong, not_human] = [&wrong, &not_human].map(|all| Detection::at(threshold, all));
        let mark = if threshold == DOCUMENTED_THRESHOLD { "**" } else { "" };
        report.say(&format!(
            "| {mark}{threshold:.1}{mark} | {:.1} | {} | {} | {} | {} |",
            100.0 * wrong.flagged as f64 / judgements.len().max(1) as f64,
            percent(wrong.precision()),
            percent(wrong.recall()),
            percent(not_human.precision()),
            percent(not_human.recall())
        ));
        for (label, found) in [("wrong", wrong), ("not human", not_human)] {
            for (quantity, share) in [("precision", found.precision()), ("recall", found.recall())]
            {
                let share = share.map_or(String::new(), |share| format!("{share:.4}"));
                let quantity = format!("{label} {quantity} at {threshold:.1}");
                report.lines.push(format!("warning,-,{name},network,{quantity},{share}"));
            }
        }
    }
}
