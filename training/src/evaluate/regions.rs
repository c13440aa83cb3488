use catamaran::Result;
use catamaran_geometry::unions::SpectralUnion;

use crate::dataset::Dataset;

/// How accurately regions are found on a template.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Localization {
    /// Number of unions.
    pub regions: usize,
    /// Mean intersection over union, with the region or its mirror image, whichever is nearer.
    pub intersection_over_union: f64,
    /// Mean share of the vertices that are correctly inside or outside.
    pub accuracy: f64,
}

/// Finds the unions of the template's family (0) on the template, and compares them with the true
/// ones; complete shapes are left out.
///
/// # Errors
/// When a spectrum is invalid, or the network belongs to another template.
pub fn localization(
    model: &SpectralUnion,
    dataset: &Dataset,
    split: usize,
    knowledge: usize,
    remeshed: bool,
) -> Result<Localization> {
    let samples = &dataset.samples;
    let Some(template) = dataset.templates.first() else {
        return Ok(Localization { regions: 0, intersection_over_union: 0.0, accuracy: 0.0 });
    };
    let on = model.localizer().on(template.eigenfunctions.as_ref())?;
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
        let found = model.locate(&[&samples.part1[i], &samples.part2[i]])?;
        let mut inside = vec![false; n];
        for (inside, value) in inside.iter_mut().zip(on.indicator(&found)?) {
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

#[cfg(test)]
mod tests {
    use catamaran::Par;
    use catamaran_geometry::mesh::LaplacianOptions;
    use catamaran_geometry::unions::{K, PartSpectra};

    use super::*;
    use crate::dataset::DatasetOptions;
    use crate::families::{Family, Model};

    /// Both parts are the vertices above these shares of the height, of figures with seeds that no
    /// data set has, each in another pose.
    #[test]
    fn pretrained_weights_find_the_upper_half_of_figures() {
        let family = Model::new(Family::Humanoid, DatasetOptions::default().vertices).unwrap();
        let template = family.template();
        let [bottom, top] = template.bounding_box().unwrap();
        let height = |v: usize| (template.vertices()[v][2] - bottom[2]) / (top[2] - bottom[2]);
        let n = template.vertices().len();
        let between = |low, high| -> Vec<bool> {
            (0..n).map(|v| (low..=high).contains(&height(v))).collect()
        };
        let parts = [between(0.7, 1.1), between(0.5, 0.8)];
        let model = SpectralUnion::pretrained().unwrap();
        let on = model.localizer().on_mesh(template, Par::all()).unwrap();
        let share = |seed: u64| {
            let spectra = [0, 1].map(|pose| {
                let shape = family.shape(seed, 0, 0, pose).unwrap();
                let spectra = PartSpectra::new(&shape, &LaplacianOptions::default()).unwrap();
                spectra.dirichlet(&parts[pose], K).unwrap()
            });
            let found = on.indicator(&model.locate(&[&spectra[0], &spectra[1]]).unwrap()).unwrap();
            let inside = |v: usize| found[v] > 0.5;
            let wanted = |v: usize| parts[0][v] || parts[1][v];
            let count = |of: &dyn Fn(usize) -> bool| (0..n).filter(|&v| of(v)).count() as f64;
            count(&|v| inside(v) && wanted(v)) / count(&|v| inside(v) || wanted(v))
        };
        let shares = [77, 78, 79, 80].map(share);
        assert!(shares.iter().sum::<f64>() > 0.85 * 4.0, "{shares:?}");
    }
}
