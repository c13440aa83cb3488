//! Tables that need a training: with one identity, and for another family.

use catamaran::Par;
use catamaran::base::Progress;
use catamaran_bench::Result;
use catamaran_geometry::mesh::TriMesh;
use catamaran_geometry::unions::SpectralUnion;
use catamaran_training::dataset::{Dataset, TEST_B};
use catamaran_training::families::{Family, Model};
use catamaran_training::train::{Examples, TrainOptions, Trainer};
use catamaran_training::tune::{TuneOptions, family_examples, start};

use super::super::Report;
use super::{Test, rows_of_regions};

/// IoU and accuracy in per cent of table 2.2 of the thesis, by test, knowledge, and whether
/// remeshed.
const THESIS: [[[[f64; 2]; 2]; 3]; 2] = [
    [
        [[99.28, 99.61], [98.54, 99.06]],
        [[93.78, 95.83], [91.44, 94.08]],
        [[94.19, 96.32], [93.47, 95.56]],
    ],
    [
        [[97.96, 98.55], [93.04, 97.33]],
        [[87.58, 92.52], [83.69, 91.08]],
        [[96.05, 98.46], [95.59, 98.43]],
    ],
];

/// Reproduces table 2.2: regions, after a training on one identity.
pub fn table_single_identity(report: &mut Report, dataset: &Dataset) -> Result<()> {
    let mut single = dataset.clone();
    single.retain_identities(1);
    let examples = Examples::new(&single, Par::all())?;
    let pairs = examples.training.len();
    let options = TrainOptions::default();
    let mut trainer = Trainer::new(examples, options, None, Par::all())?;
    for _ in 0..options.epochs {
        trainer.epoch()?;
    }
    report.say(&format!(
        "## Table 2.2: regions on a template, one identity\n\nA network trained on the {pairs} pairs of one identity, {} passes. In \
         brackets the thesis' numbers.\n",
        options.epochs
    ));
    let thesis = |test: &Test| {
        let of_split = &THESIS[usize::from(test.split == TEST_B)];
        of_split.get(test.knowledge).map(|rows| rows[usize::from(test.remeshed)])
    };
    rows_of_regions(report, &single, &trainer.model()?, ("2.2", thesis))
}

/// Number of vertices of a quadruped, and number of quadrupeds.
const VERTICES: usize = 2500;
const MESHES: usize = 50;

/// Reports fine-tuning (thesis, section 2.5) to quadrupeds, as `catamaran unions tune` does it,
/// beside a training on quadrupeds alone.
pub fn table_family(report: &mut Report, model: &SpectralUnion) -> Result<()> {
    let family = Model::new(Family::Quadruped, VERTICES)?;
    // None of these quadrupeds is in the data set.
    let meshes: Vec<TriMesh> = (0..MESHES)
        .map(|identity| family.shape(77, 1000 + identity, identity % 2, 0))
        .collect::<catamaran::Result<_>>()?;
    let options = TuneOptions::default();
    let examples = family_examples(&meshes, model, &options, Par::all(), Progress::none())?;
    let (settings, state) = start(model, &options);
    let run = |settings: TrainOptions, state| -> Result<[f64; 2]> {
        let mut trainer = Trainer::new(examples.clone(), settings, state, Par::all())?;
        let before = trainer.best_error();
        for _ in 0..settings.epochs {
            trainer.epoch()?;
        }
        Ok([before, trainer.best_error()])
    };
    let [before, after] = run(settings, Some(state))?;
    let from_nothing = TrainOptions { epochs: settings.epochs, ..TrainOptions::default() };
    let [_, alone] = run(from_nothing, None)?;
    report.say(&format!(
        "## Fine-tuning\n\n{MESHES} quadrupeds, {} pairs of parts to learn from, {} of meshes kept aside; {} passes. Mean errors of \
         logarithms of eigenvalues, in per cent.\n\n| network | error % |\n|---|---|\n\
         | of humans | {:.2} |\n| the same, fitted | {:.2} |\n| trained on quadrupeds only | {:.2} |\n",
        examples.training.len(),
        examples.validation.len(),
        settings.epochs,
        100.0 * before,
        100.0 * after,
        100.0 * alone
    ));
    for (predictor, error) in [("before", before), ("tuned", after), ("alone", alone)] {
        report.lines.push(format!("tune,-,quadrupeds,{predictor},relative,{error:.6e}"));
    }
    Ok(())
}
