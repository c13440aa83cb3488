//! Training of the localizer, which finds regions on a template from their spectra (thesis, section 2.6.2).

use std::collections::BTreeMap;

use catamaran::base::{Flow, Progress};
use catamaran::decimate::FarthestPoints;
use catamaran::unions::{K, Localizer, LocalizerParts};
use catamaran::{Error, Result};

use crate::dataset::{Dataset, Spectrum, TEST_B, TRAIN, Template};
use crate::mlp::{Mlp, Schedule};

/// How a localizer is trained.
#[derive(Clone, Copy)]
pub struct RegionOptions<'a> {
    /// Which template; default 0.
    pub family: usize,
    /// Passes over the data; default 60.
    pub epochs: usize,
    /// Neurons of each of the two hidden layers; default 256.
    pub hidden: usize,
    /// Of everything random; default 1.
    pub seed: u64,
    /// Told of progress; default none.
    pub progress: Option<Progress<'a>>,
}

impl Default for RegionOptions<'_> {
    fn default() -> Self {
        Self { family: 0, epochs: 60, hidden: 256, seed: 1, progress: None }
    }
}

/// Anchors for each eigenfunction.
const ANCHORS: usize = 2;
/// Deviation of logarithms of eigenvalues by which they are disturbed, common to all, and growing to this at the last one: unions
/// are predicted, and meshes are coarse.
const DRIFT: f64 = 0.01;
/// The same for each alone.
const JITTER: f64 = 0.003;

/// Trains on the spectra and masks of the parts and unions of the training samples; unions that test are left out.
///
/// The loss is the squared distance of functions on the template, which is that of coefficients, and the smaller one of those
/// to a region and to its mirror image.
///
/// # Errors
/// [`Error::Argument`] when there is no such template, or nothing to train on; [`Error::Cancelled`].
pub fn train_regions(dataset: &Dataset, options: &RegionOptions<'_>) -> Result<Localizer> {
    let refuse = |what, why: &str| Error::Argument { what, why: why.into() };
    let template = dataset
        .templates
        .get(options.family)
        .ok_or_else(|| refuse("family", "the data set has no such template"))?;
    let (regions, examples) = examples(dataset, options.family, template)?;
    if examples.is_empty() {
        return Err(refuse("data set", "no regions to train on"));
    }
    let (mean, deviation) = units(&examples);
    let modes = template.eigenfunctions.ncols();
    let mut mlp = Mlp::new(&[K, options.hidden, options.hidden, modes], options.seed);
    let schedule = Schedule { epochs: options.epochs, rate: 2e-3, batch: 64, seed: options.seed };
    mlp.train(
        examples.len(),
        &schedule,
        |i, rng| {
            let drift = DRIFT * rng.normal();
            (0..K)
                .map(|j| {
                    let noise = drift * (j + 1) as f64 / K as f64 + JITTER * rng.normal();
                    let log = examples[i].1[j].ln() + noise;
                    (log as f32 - mean[j]) / deviation[j]
                })
                .collect()
        },
        |i, found, gradient| {
            let distance = |wanted: &[f32]| {
                found.iter().zip(wanted).map(|(x, y)| f64::from((x - y) * (x - y))).sum::<f64>()
            };
            let [region, mirrored] = &regions[examples[i].0];
            let (near, far) = (distance(region), distance(mirrored));
            let wanted = if near <= far { region } else { mirrored };
            for ((gradient, x), y) in gradient.iter_mut().zip(found).zip(wanted) {
                *gradient = 2.0 * (x - y);
            }
            near.min(far)
        },
        |epoch, _| match options.progress {
            Some(tell) if tell((epoch + 1) as f64 / options.epochs as f64) == Flow::Cancel => {
                Err(Error::Cancelled)
            }
            _ => Ok(()),
        },
    )?;
    let anchors = anchors(template, ANCHORS * modes)?;
    let values = anchors
        .iter()
        .flat_map(|&v| (0..modes).map(move |j| template.eigenfunctions[(v, j)] as f32))
        .collect();
    Localizer::new(LocalizerParts {
        widths: mlp.widths,
        parameters: mlp.parameters,
        mean,
        deviation,
        anchors,
        values,
        vertices: template.vertices.len(),
    })
}

/// Coefficients of a region and of its mirror image.
type Region = [Vec<f32>; 2];
/// A spectrum, and the number of its region.
type Example = (usize, Spectrum);

/// All regions, and spectra with the number of their region.
fn examples(
    dataset: &Dataset,
    family: usize,
    template: &Template,
) -> Result<(Vec<Region>, Vec<Example>)> {
    let samples = &dataset.samples;
    let own = || (0..samples.part1.len()).filter(|&i| samples.family[i] == family);
    let tested: Vec<usize> =
        own().filter(|&i| samples.split[i] == TEST_B).map(|i| samples.mask_union[i]).collect();
    // Each spectrum of a shape once.
    let mut spectra = BTreeMap::new();
    for i in own().filter(|&i| samples.split[i] == TRAIN) {
        let key = |mask: usize| (mask, samples.identity[i], samples.pose[i]);
        spectra.insert(key(samples.mask1[i]), samples.part1[i]);
        spectra.insert(key(samples.mask2[i]), samples.part2[i]);
        spectra.insert(key(samples.mask_union[i]), samples.union[i]);
    }
    let mut numbers = BTreeMap::new();
    let (mut regions, mut examples) = (Vec::new(), Vec::new());
    for ((mask, _, _), spectrum) in spectra {
        // A complete closed surface needs no localizing, and its first eigenvalue has no logarithm.
        if tested.contains(&mask) || spectrum[0] <= 1e-6 * spectrum[K - 1] {
            continue;
        }
        let number = match numbers.get(&mask) {
            Some(&number) => number,
            None => {
                let vertices = template.mask(mask).ok_or_else(|| Error::Argument {
                    what: "data set",
                    why: format!("no mask {mask} on template {family}"),
                })?;
                let mirrored: Vec<usize> = vertices.iter().map(|&v| template.mirror[v]).collect();
                regions
                    .push([coefficients(template, &vertices), coefficients(template, &mirrored)]);
                numbers.insert(mask, regions.len() - 1);
                regions.len() - 1
            }
        };
        examples.push((number, spectrum));
    }
    Ok((regions, examples))
}

/// Of the indicator function, in the eigenfunctions.
fn coefficients(template: &Template, vertices: &[usize]) -> Vec<f32> {
    let functions = &template.eigenfunctions;
    (0..functions.ncols())
        .map(|j| vertices.iter().map(|&v| template.mass[v] * functions[(v, j)]).sum::<f64>() as f32)
        .collect()
}

/// Means and deviations of logarithms of eigenvalues.
fn units(examples: &[Example]) -> (Vec<f32>, Vec<f32>) {
    let count = examples.len() as f64;
    let of = |j: usize| {
        let logs = || examples.iter().map(move |(_, spectrum)| spectrum[j].ln());
        let mean = logs().sum::<f64>() / count;
        let variance = logs().map(|x| (x - mean) * (x - mean)).sum::<f64>() / count;
        (mean as f32, variance.sqrt().max(1e-3) as f32)
    };
    (0..K).map(of).unzip()
}

/// Vertices far from one another.
fn anchors(template: &Template, count: usize) -> Result<Vec<usize>> {
    let mesh = template.mesh()?;
    let mut sampler = FarthestPoints::new(&mesh, None)?;
    sampler.extend_to(count.min(template.vertices.len()), None)?;
    let mut anchors: Vec<usize> = sampler.samples().iter().map(|&v| v as usize).collect();
    anchors.sort_unstable();
    Ok(anchors)
}
