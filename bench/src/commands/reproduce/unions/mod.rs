//! Chapter 2: spectral unions of partial shapes.

pub mod bodies;
mod faust;
mod real;
mod retrieval;
mod trained;
mod warning;

use std::fs;
use std::hint::black_box;
use std::ops::ControlFlow;
use std::path::Path;
use std::time::Instant;

use catamaran::Par;
use catamaran::io::{Output, Overwrite};
use catamaran_bench::Result;
use catamaran_bench::curves::Plot;
use catamaran_bench::race::median;
use catamaran_geometry::mesh::LaplacianOptions;
use catamaran_geometry::unions::{PartSpectra, SpectralUnion};
use catamaran_training::dataset::{
    self, Dataset, DatasetOptions, EIGENVALUES, KNOWN_IDENTITY, TEST_A, TEST_B,
};
use catamaran_training::evaluate::{
    Errors, Minimum, Nearest, Perceptron, Predictor, Weyl, associativity, errors, localization,
    select,
};
use catamaran_training::families::{Family, Model};
use catamaran_training::train::Examples;
use catamaran_training::transformer::Transformer;

use super::{Arguments, Report};

/// The columns of the record.
pub const HEADER: &str = "table,test,shapes,predictor,quantity,value";

/// Default path of the data set.
const DATASET: &str = "target/unions.npz";

/// Number of epochs of the perceptron that is a baseline.
const EPOCHS: usize = 60;
const SEED: u64 = 1;

/// Relations of the shapes of the tests to the training, and the closest terms of the thesis.
const KNOWLEDGE: [(&str, &str); 4] = [
    ("known identity", "known man"),
    ("unknown identity", "unknown man"),
    ("unknown body type", "unknown woman"),
    ("unknown family", "-"),
];

/// The thesis' mse and mae (table 2.1), then IoU and accuracy in per cent of table 2.3, by test,
/// relation, and whether remeshed.
const THESIS: [[[[f64; 4]; 2]; 3]; 2] = [
    [
        [[11.14, 2.09, 98.24, 99.09], [29.61, 3.31, 97.70, 98.74]],
        [[13.25, 2.59, 96.26, 97.64], [32.67, 3.60, 95.88, 97.78]],
        [[36.92, 3.93, 96.17, 98.04], [62.33, 5.23, 96.04, 97.66]],
    ],
    [
        [[15.41, 2.59, 97.43, 99.14], [51.20, 4.54, 97.61, 99.11]],
        [[24.05, 3.60, 93.31, 98.23], [75.91, 5.90, 90.85, 97.63]],
        [[64.47, 4.99, 95.74, 98.59], [110.17, 6.78, 96.81, 98.98]],
    ],
];

/// A test of the tables.
#[derive(Clone, Copy)]
struct Test {
    split: usize,
    knowledge: usize,
    remeshed: bool,
}

impl Test {
    fn all() -> impl Iterator<Item = Self> {
        [TEST_A, TEST_B].into_iter().flat_map(|split| {
            [false, true].into_iter().flat_map(move |remeshed| {
                (0..KNOWLEDGE.len()).map(move |knowledge| Self { split, knowledge, remeshed })
            })
        })
    }

    fn letter(&self) -> &'static str {
        if self.split == TEST_A { "A" } else { "B" }
    }

    fn shapes(&self) -> String {
        format!("{}{}", KNOWLEDGE[self.knowledge].0, if self.remeshed { ", remeshed" } else { "" })
    }

    fn thesis(&self) -> Option<[f64; 4]> {
        let of_split = &THESIS[usize::from(self.split == TEST_B)];
        of_split.get(self.knowledge).map(|rows| rows[usize::from(self.remeshed)])
    }
}

/// Reproduces tables 2.1 to 2.4, and associativity (figure 2.9), on the generated data set.
pub fn run(report: &mut Report, arguments: &Arguments) -> Result<()> {
    let path = arguments.data.as_deref().unwrap_or(Path::new(DATASET));
    if arguments.data.is_none() && !path.exists() {
        generate(path)?;
    }
    let dataset = dataset::read(path)?;
    let model = weights(arguments)?;
    report.say(&format!(
        "# Chapter 2, measured again\n\nData set: {} samples of generated shapes, `{}`; the protocol is in docs/algorithms/unions.md. \
         The thesis' numbers, in brackets, are of FAUST and SURREAL, which may not be redistributed: **absolute values are not \
         comparable**, only what becomes of them from row to row.\n",
        dataset.samples.part1.len(),
        path.file_name().unwrap_or_default().to_string_lossy()
    ));
    let thesis = arguments.transformer.as_deref().map(Transformer::read).transpose()?;
    table_errors(report, &dataset, &model, thesis.as_ref())?;
    table_warnings(report, &dataset, &model)?;
    table_associativity(report, &dataset, &model)?;
    report.say(
        "## Table 2.3: regions on a template\n\nIn brackets the thesis' numbers, of a training on six identities.\n",
    );
    let thesis = |test: &Test| test.thesis().map(|[_, _, iou, accuracy]| [iou, accuracy]);
    rows_of_regions(report, &dataset, &model, ("2.3", thesis))?;
    trained::table_single_identity(report, &dataset)?;
    trained::table_family(report, &model)?;
    retrieval::tables(report, &dataset, &model)?;
    let judgements = real::table(report, &model)?;
    warning::table(report, &dataset, &model, &judgements)?;
    times(report, &dataset, &model)
}

/// Returns the network with the given weights, or with those of the library.
fn weights(arguments: &Arguments) -> Result<SpectralUnion> {
    Ok(match &arguments.weights {
        Some(path) => SpectralUnion::read(path)?,
        None => SpectralUnion::pretrained()?,
    })
}

/// Generates the data set of the pretrained weights; the progress is saved beside it, so that an
/// interrupted run continues.
fn generate(path: &Path) -> Result<()> {
    eprintln!("making {}: about an hour of two cores", path.display());
    let parts = path.with_extension("parts");
    let tell = |done: f64| {
        eprint!("\r{:3.0} % ", 100.0 * done);
        ControlFlow::Continue(())
    };
    let found = dataset::generate(&DatasetOptions::default(), &parts, Par::all(), (&tell).into())?;
    eprintln!();
    dataset::write(&found, Output::create(path, Overwrite::Never)?)?;
    Ok(fs::remove_dir_all(&parts)?)
}

/// Reproduces table 2.1, with the baselines.
fn table_errors(
    report: &mut Report,
    dataset: &Dataset,
    model: &SpectralUnion,
    thesis: Option<&Transformer>,
) -> Result<()> {
    let training = Examples::new(dataset, Par::all())?.training;
    let perceptron = Perceptron::fit(&training, EPOCHS, SEED)?;
    let (weyl, nearest) = (Weyl::fit(&training), Nearest::fit(&training));
    let mut predictors: Vec<&dyn Predictor> = vec![model, &Minimum, &weyl, &nearest, &perceptron];
    predictors.extend(thesis.map(|own| own as &dyn Predictor));
    report.say(
        "## Table 2.1: errors of predicted eigenvalues\n\nMean relative error in per cent; mse and mae in units of the shapes; \
         ratio: the smallest mse of the baselines over that of the network.\n",
    );
    let names: Vec<String> = predictors.iter().map(|p| format!("{} %", p.name())).collect();
    report.say(&format!(
        "| test | shapes | pairs | {} | mse (thesis) | mae (thesis) | best baseline mse | ratio |\n|---|---|---{}|---|---|---|---|",
        names.join(" | "),
        "|---".repeat(predictors.len())
    ));
    let mut series: Vec<(String, Vec<(f64, f64)>)> =
        predictors.iter().map(|p| (p.name().to_owned(), Vec::new())).collect();
    let mut row = 0;
    for test in Test::all() {
        let pairs = select(dataset, test.split, test.knowledge, test.remeshed);
        if pairs.is_empty() {
            continue;
        }
        let found: Vec<Errors> =
            predictors.iter().map(|p| errors(*p, &pairs)).collect::<catamaran::Result<_>>()?;
        row += 1;
        for ((predictor, found), (_, points)) in predictors.iter().zip(&found).zip(&mut series) {
            points.push((f64::from(row), 100.0 * found.relative));
            for (quantity, value) in
                [("relative", found.relative), ("mse", found.mse), ("mae", found.mae)]
            {
                report.lines.push(format!(
                    "2.1,{},{},{},{quantity},{value:.6e}",
                    test.letter(),
                    test.shapes().replace(',', ""),
                    predictor.name()
                ));
            }
        }
        let relative: Vec<String> =
            found.iter().map(|f| format!("{:.2}", 100.0 * f.relative)).collect();
        let best = found[1..].iter().map(|f| f.mse).fold(f64::INFINITY, f64::min);
        let [mse, mae] = [0, 1].map(|i| test.thesis().map_or("-".into(), |t| t[i].to_string()));
        report.say(&format!(
            "| {} | {} | {} | {} | {:.3} ({mse}) | {:.3} ({mae}) | {best:.3} | {:.1} |",
            test.letter(),
            test.shapes(),
            found[0].pairs,
            relative.join(" | "),
            found[0].mse,
            found[0].mae,
            best / found[0].mse
        ));
    }
    report.say("");
    report.plots.push(Plot {
        title: "Mean relative error, per cent, of the rows of table 2.1".into(),
        across: "row".into(),
        logarithmic: true,
        scattered: true,
        series,
    });
    Ok(())
}

/// Reports how many pairs of each test count as out of distribution.
fn table_warnings(report: &mut Report, dataset: &Dataset, model: &SpectralUnion) -> Result<()> {
    report.say(
        "## Out-of-distribution score\n\nPairs that are unlike those of the training, by the network's own judgement (`ood_score` above 1), and the mean \
         relative error of these and of the others.\n\n\
         | test | shapes | pairs | above 1 % | error of these % | of the others % |\n|---|---|---|---|---|---|",
    );
    for test in Test::all() {
        let pairs = select(dataset, test.split, test.knowledge, test.remeshed);
        if pairs.is_empty() {
            continue;
        }
        let (mut warned, mut others) = (Vec::new(), Vec::new());
        for pair in &pairs {
            match model.ood_score(&[&pair.first, &pair.second])? {
                x if x > 1.0 => warned.push(*pair),
                _ => others.push(*pair),
            }
        }
        let share = 100.0 * warned.len() as f64 / pairs.len() as f64;
        let [of_warned, of_others] = [&warned, &others].map(|pairs| match pairs.is_empty() {
            true => Ok("-".to_owned()),
            false => errors(model, pairs).map(|found| format!("{:.2}", 100.0 * found.relative)),
        });
        let (letter, shapes) = (test.letter(), test.shapes());
        report.say(&format!(
            "| {letter} | {shapes} | {} | {share:.1} | {} | {} |",
            pairs.len(),
            of_warned?,
            of_others?
        ));
        let shapes = shapes.replace(',', "");
        report.lines.push(format!("ood_score,{letter},{shapes},network,share,{share:.2}"));
    }
    report.say("");
    Ok(())
}

/// Reproduces figure 2.9, in numbers.
fn table_associativity(
    report: &mut Report,
    dataset: &Dataset,
    model: &SpectralUnion,
) -> Result<()> {
    report.say(
        "## Associativity\n\nThree parts at once, where order and grouping can't matter, and by unions of two: (1 2) 3 against 1 (2 3), \
         the share of triples, none of which was trained on, within 5 % in the mean.\n\n\
         | shapes | triples | error at once % | by two: within 5 % | mean difference % | error of (1 2) 3 % |\n|---|---|---|---|---|---|",
    );
    for (knowledge, (name, _)) in KNOWLEDGE.iter().enumerate() {
        let found = associativity(model, dataset, knowledge)?;
        if found.triples == 0 {
            continue;
        }
        report.say(&format!(
            "| {name} | {} | {:.2} | {:.1} % | {:.2} | {:.2} |",
            found.triples,
            100.0 * found.error_at_once,
            100.0 * found.within,
            100.0 * found.difference,
            100.0 * found.error
        ));
        let quantities = [("within", found.within), ("error at once", found.error_at_once)];
        for (quantity, value) in quantities {
            report.lines.push(format!("associativity,-,{name},network,{quantity},{value:.4}"));
        }
    }
    report.say("");
    Ok(())
}

/// Returns IoU and accuracy of a test in the thesis, in per cent.
type ThesisRegions = fn(&Test) -> Option<[f64; 2]>;

/// Reports rows of table 2.2 or 2.3, which differ in the identities of the training, with the
/// thesis' share of each test in brackets.
fn rows_of_regions(
    report: &mut Report,
    dataset: &Dataset,
    model: &SpectralUnion,
    (table, thesis): (&str, ThesisRegions),
) -> Result<()> {
    report.say("| test | shapes | regions | IoU % | accuracy % |\n|---|---|---|---|---|");
    for test in Test::all() {
        let Test { split, knowledge, remeshed } = test;
        let found = localization(model, dataset, split, knowledge, remeshed)?;
        if found.regions == 0 {
            continue;
        }
        let [iou, accuracy] =
            [0, 1].map(|i| thesis(&test).map_or("-".into(), |t| t[i].to_string()));
        report.say(&format!(
            "| {} | {} | {} | {:.2} ({iou}) | {:.2} ({accuracy}) |",
            test.letter(),
            test.shapes(),
            found.regions,
            100.0 * found.intersection_over_union,
            100.0 * found.accuracy
        ));
        report.lines.push(format!(
            "{table},{},{},network,iou,{:.4}",
            test.letter(),
            test.shapes().replace(',', ""),
            found.intersection_over_union
        ));
    }
    report.say("");
    Ok(())
}

/// Reports the time of a prediction, and of the spectra that it replaces.
fn times(report: &mut Report, dataset: &Dataset, model: &SpectralUnion) -> Result<()> {
    let samples = &dataset.samples;
    let seconds = |work: &mut dyn FnMut() -> catamaran::Result<()>| -> Result<f64> {
        let start = Instant::now();
        work()?;
        Ok(start.elapsed().as_secs_f64())
    };
    let predict = |i: usize| {
        seconds(&mut || {
            model.predict(&samples.part1[i], &samples.part2[i]).map(|union| {
                black_box(union);
            })
        })
    };
    let predictions = (0..samples.part1.len().min(999)).map(predict).collect::<Result<_>>()?;
    let surface = Model::new(Family::Humanoid, 7000)?;
    let mesh = surface.template();
    let options = LaplacianOptions::new().par(Par::Seq);
    let spectra = PartSpectra::new(mesh, &options)?;
    let left = mesh.half_space([1.0, 0.0, 0.0], 0.0);
    let [half, complete] = [left, vec![true; mesh.vertices().len()]].map(|mask| {
        let once = |_| seconds(&mut || spectra.dirichlet(&mask, EIGENVALUES).map(drop));
        (0..5).map(once).collect::<Result<Vec<f64>>>()
    });
    report.say(&format!(
        "\n## Times\n\nMedians, one thread. A prediction: {:.3} ms. Twenty Dirichlet eigenvalues of half of a humanoid of {} vertices: \
         {:.3} s, of all of it: {:.3} s.",
        1e3 * median(predictions),
        mesh.vertices().len(),
        median(half?),
        median(complete?)
    ));
    Ok(())
}
