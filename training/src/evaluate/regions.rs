use catamaran::Result;
use catamaran::unions::{K, Localizer};

use super::Predictor;
use crate::dataset::Dataset;

/// How well regions are found on a template.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Localization {
    /// Unions looked for.
    pub regions: usize,
    /// Mean intersection over union, of the region or of its mirror image, whichever is nearer.
    pub intersection_over_union: f64,
    /// Mean share of vertices that are rightly inside or outside.
    pub accuracy: f64,
}

/// Predicts the spectra of unions of the template's family (0), finds their regions, and compares; complete shapes are left out.
///
/// # Errors
/// Of spectra that are none, and of a localizer of another template.
pub fn localization(
    predictor: &dyn Predictor,
    localizer: &Localizer,
    dataset: &Dataset,
    split: usize,
    knowledge: usize,
    remeshed: bool,
) -> Result<Localization> {
    let samples = &dataset.samples;
    let Some(template) = dataset.templates.first() else {
        return Ok(Localization { regions: 0, intersection_over_union: 0.0, accuracy: 0.0 });
    };
    let on = localizer.on(template.eigenfunctions.as_ref())?;
    let n = template.vertices.len();
    let (mut regions, mut shares, mut accuracy) = (0, 0.0, 0.0);
    for i in 0..samples.part1.len() {
        let kind = (samples.family[i], samples.split[i], samples.knowledge[i], samples.remeshed[i]);
        if kind != (0, split, knowledge, usize::from(remeshed)) {
            continue;
        }
        let Some(mask) = template.mask(samples.mask_union[i]).filter(|mask| mask.len() < n) else {
            continue;
        };
        let union = predictor.predict(&samples.part1[i], &samples.part2[i])?;
        let mut inside = vec![false; n];
        for (inside, value) in inside.iter_mut().zip(on.indicator(&union[..K])?) {
            *inside = value > 0.5;
        }
        let score = |region: &mut dyn Iterator<Item = usize>| {
            let mut wanted = vec![false; n];
            region.for_each(|v| wanted[v] = true);
            let count = |of: fn(bool, bool) -> bool| {
                inside.iter().zip(&wanted).filter(|&(&a, &b)| of(a, b)).count() as f64
            };
            (count(|a, b| a && b) / count(|a, b| a || b).max(1.0), count(|a, b| a == b) / n as f64)
        };
        let there = score(&mut mask.iter().copied());
        let mirrored = score(&mut mask.iter().map(|&v| template.mirror[v]));
        let best = if there.0 >= mirrored.0 { there } else { mirrored };
        regions += 1;
        shares += best.0;
        accuracy += best.1;
    }
    let count = f64::max(1.0, regions as f64);
    Ok(Localization {
        regions,
        intersection_over_union: shares / count,
        accuracy: accuracy / count,
    })
}
