//! Table 2.4, other distances, and the errors that retrieval tolerates.

use catamaran_bench::Result;
use catamaran_geometry::unions::{MetricOptions, SpectralUnion};
use catamaran_training::dataset::Dataset;
use catamaran_training::evaluate::{Disturbance, Retrieval, RetrievalStudy, Source};

use super::super::Report;
use super::{KNOWLEDGE, KNOWN_IDENTITY, SEED};

/// Top-1, top-5 and top-10 of the thesis, in per cent.
const THESIS: [(Source, &str, [f64; 3]); 2] = [
    (Source::Predicted, "predicted union", [86.14, 97.75, 99.20]),
    (Source::True, "ShapeDNA, true spectrum", [86.59, 96.81, 97.72]),
];

/// Standard deviations of relative errors, in per cent.
const SIZES: [f64; 6] = [0.25, 0.5, 1.0, 2.0, 3.0, 4.0];
/// Factors of the network's errors.
const FACTORS: [f64; 3] = [0.25, 0.5, 1.0];

/// Reports all tables.
pub fn tables(report: &mut Report, dataset: &Dataset, model: &SpectralUnion) -> Result<()> {
    let study = RetrievalStudy::new(model, dataset)?;
    let metrics = [false, true].map(|scale_free| MetricOptions::new().scale_free(scale_free));
    table_thesis(report, &study, &metrics)?;
    errors(report, &study);
    table_tolerance(report, &study, &metrics[0])
}

fn table_thesis(
    report: &mut Report,
    study: &RetrievalStudy,
    metrics: &[MetricOptions; 2],
) -> Result<()> {
    let [errors, poses] = study.fitted_to();
    report.say(&format!(
        "## Table 2.4: retrieval of complete shapes\n\n{} queries; nearest of the other shapes by eigenvalues, as in the thesis (in \
         brackets), and by how likely a query is another pose of a shape (`RetrievalMetric`): normal distributions of logarithms of eigenvalues 2 to \
         20, fitted to errors of {errors} predictions that were trained on and to {poses} shapes, without the identity of the query.\n\n\
         | signature | distance | top-1 % | top-5 % | top-10 % |\n|---|---|---|---|---|",
        study.euclidean(Source::Predicted)?.queries
    ));
    for (source, name, thesis) in THESIS {
        let found = study.euclidean(source)?;
        let cells: Vec<String> =
            found.top.iter().zip(thesis).map(|(x, t)| format!("{:.2} ({t})", 100.0 * x)).collect();
        report.say(&format!("| {name} | Euclidean | {} |", cells.join(" | ")));
        let known = KNOWLEDGE[KNOWN_IDENTITY].0;
        report.lines.push(format!("2.4,-,{known},network,top-1,{:.4}", found.top[0]));
        for (metric, distance) in metrics.iter().zip(["likelihood", "likelihood, of any size"]) {
            let found = study.by_likelihood(source, metric)?;
            let cells = found.top.map(|x| format!("{:.2}", 100.0 * x));
            report.say(&format!("| {name} | {distance} | {} |", cells.join(" | ")));
            report.lines.push(format!(
                "retrieval,-,{},network,top-1 {},{:.4}",
                name.replace(',', ""),
                distance.replace(',', ""),
                found.top[0]
            ));
        }
    }
    Ok(())
}

fn errors(report: &mut Report, study: &RetrievalStudy) {
    let errors = study.errors_by_index();
    let cells = errors.map(|error| format!("{:.2}", 100.0 * error));
    let header: Vec<String> = (0..errors.len()).map(|i| (i + 2).to_string()).collect();
    report.say(&format!(
        "\nMean relative error in per cent of the predictions of the queries, by number of the eigenvalue:\n\n\
         | {} |\n{}|\n| {} |",
        header.join(" | "),
        "|---".repeat(errors.len()),
        cells.join(" | ")
    ));
    for (i, error) in errors.iter().enumerate() {
        report.lines.push(format!("retrieval,-,queries,network,relative of {},{error:.6e}", i + 2));
    }
}

fn table_tolerance(
    report: &mut Report,
    study: &RetrievalStudy,
    options: &MetricOptions,
) -> Result<()> {
    report.say(
        "\n## Errors that retrieval tolerates\n\nTop-1 in per cent of queries by true spectra of complete shapes with errors of a known \
         size, by Euclidean distance and by likelihood (fitted to such errors).\n\n\
         | error | size | Euclidean | likelihood |\n|---|---|---|---|",
    );
    let mut row = |name: &str, size: String, [euclidean, likelihood]: [Retrieval; 2]| {
        let [e, l] = [euclidean, likelihood].map(|found| found.top[0]);
        report.say(&format!("| {name} | {size} | {:.1} | {:.1} |", 100.0 * e, 100.0 * l));
        report.lines.push(format!("tolerance,-,{name} {size},Euclidean,top-1,{e:.4}"));
        report.lines.push(format!("tolerance,-,{name} {size},likelihood,top-1,{l:.4}"));
    };
    let none = study.disturbed(&Disturbance::Independent(0.0), options, SEED)?;
    row("none", "0".into(), none);
    let independent: fn(f64) -> Disturbance<'static> = Disturbance::Independent;
    let kinds =
        [("of each eigenvalue", independent), ("growing with the eigenvalue", Disturbance::Drift)];
    for (name, kind) in kinds {
        for size in SIZES {
            let found = study.disturbed(&kind(size / 100.0), options, SEED)?;
            row(name, format!("{size} %"), found);
        }
    }
    let model = study.error_model()?;
    for factor in FACTORS {
        let found = study.disturbed(&Disturbance::Modelled(&model, factor), options, SEED)?;
        row("drawn like those of the network", format!("x {factor}"), found);
    }
    for factor in FACTORS {
        row("of the network", format!("x {factor}"), study.improved(factor, options)?);
    }
    report.say("");
    Ok(())
}
