//! Training on a few shapes of a family, starting from weights trained on another family (thesis,
//! section 2.5).

use std::collections::BTreeMap;

use catamaran::base::{Pin, Progress, ThreadPool};
use catamaran::{Error, Par, Result};
use catamaran_geometry::mesh::{LaplacianOptions, TriMesh};
use catamaran_geometry::unions::{K, PartSpectra, SpectralUnion};
use rayon::prelude::*;

use crate::adam::Adam;
use crate::cuts::{CutOptions, cuts_of_mesh};
use crate::families::mixed;
use crate::train::{Examples, Pair, State, TrainOptions};

/// Options of fitting weights to a family.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct TuneOptions {
    /// Approximate number of pairs of parts per mesh.
    pub pairs: usize,
    /// One of this many meshes is reserved for validation.
    pub aside: usize,
    /// Number of passes over the pairs.
    pub epochs: usize,
    /// Largest learning rate of the optimizer: lower than that of a training from the beginning, so
    /// that less of the previous training is lost.
    pub rate: f64,
    /// Seed of the cuts and of the training.
    pub seed: u64,
}

impl Default for TuneOptions {
    fn default() -> Self {
        Self { pairs: 60, aside: 10, epochs: 20, rate: 1e-3, seed: 1 }
    }
}

/// Cuts parts out of meshes and computes the spectra of the parts and of their unions. The result
/// does not depend on the number of threads.
///
/// # Errors
/// Those of [`family_pairs`] and [`divide_pairs`]; [`Error::Cancelled`].
pub fn family_examples(
    meshes: &[TriMesh],
    base: &SpectralUnion,
    options: &TuneOptions,
    par: Par,
    progress: Progress<'_>,
) -> Result<Examples> {
    let pairs = meshes.iter().enumerate().map(|(number, mesh)| {
        progress.report(number as f64 / meshes.len() as f64)?;
        family_pairs(mesh, number, options, par)
    });
    divide_pairs(pairs.collect::<Result<_>>()?, base, options)
}

/// Divides the pairs of each mesh of a family, those of [`family_pairs`], into those of the
/// training and those of the validation.
///
/// # Errors
/// [`Error::Argument`] for fewer than two meshes, and when there are no pairs for the training, or
/// none for the validation.
pub fn divide_pairs(
    pairs: Vec<Vec<Pair>>,
    base: &SpectralUnion,
    options: &TuneOptions,
) -> Result<Examples> {
    if pairs.len() < 2 {
        let why = format!("must be at least 2, one of them for validation, is {}", pairs.len());
        return Err(Error::Argument { what: "meshes", why });
    }
    let (mut training, mut validation) = (Vec::new(), Vec::new());
    let aside = options.aside.clamp(2, pairs.len());
    for (number, pairs) in pairs.into_iter().enumerate() {
        let of = if (number + 1) % aside == 0 { &mut validation } else { &mut training };
        of.extend(pairs);
    }
    Examples::of_family(training, validation, base.localizer().clone())
}

/// Cuts pairs of parts out of the mesh with this number in its family, from 0, and computes the
/// spectra of the parts and of their unions. There may be no pairs. The result does not depend on
/// the number of threads.
///
/// # Errors
/// Those of [`PartSpectra::new`] and [`catamaran_geometry::mesh::HeatMethod`].
pub fn family_pairs(
    mesh: &TriMesh,
    number: usize,
    options: &TuneOptions,
    par: Par,
) -> Result<Vec<Pair>> {
    let (count, seed) = (options.pairs, mixed(&[options.seed, number as u64, 0x7E4E]));
    let options = CutOptions {
        regions: count.div_ceil(3),
        pairs: count.div_ceil(2),
        composites: 0,
        splits: count / 2,
        triples: 0,
        seed,
    };
    let cuts = cuts_of_mesh(mesh, &options, par)?;
    let parts = PartSpectra::new(mesh, &LaplacianOptions::new().par(Par::Seq))?;
    let spectrum = |(&id, mask): (&usize, &Vec<bool>)| {
        let values = parts.dirichlet(mask, K)?;
        Ok((id, std::array::from_fn(|i| values[i])))
    };
    let team = ThreadPool::new(par.threads(), Pin::No)?;
    let spectra: BTreeMap<usize, [f64; K]> =
        team.run(|| cuts.masks.par_iter().map(spectrum).collect::<Result<_>>())?;
    let pair = |pair: &crate::cuts::Pair| Pair {
        first: spectra[&pair.parts[0]],
        second: spectra[&pair.parts[1]],
        union: spectra[&pair.union],
        regions: None,
    };
    Ok(cuts.pairs.iter().map(pair).collect())
}

/// Returns the options and the state with which a training continues from the weights of `base`.
pub fn start(base: &SpectralUnion, options: &TuneOptions) -> (TrainOptions, State) {
    let parameters = base.parameters().to_vec();
    let state = State {
        adam: Adam::new(parameters.len()),
        best: parameters.clone(),
        parameters,
        history: Vec::new(),
        scaling: base.scaling().clone(),
    };
    let TuneOptions { epochs, rate, seed, .. } = *options;
    let sizes = base.architecture();
    (TrainOptions { sizes, epochs, rate, seed, ..TrainOptions::default() }, state)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::families::{Family, Model};
    use crate::train::Trainer;

    fn quadrupeds(count: usize) -> Vec<TriMesh> {
        let model = Model::new(Family::Quadruped, 900).unwrap();
        (0..count).map(|identity| model.shape(3, identity, 0, 0).unwrap()).collect()
    }

    #[test]
    fn a_few_shapes_of_a_family_lower_the_error_on_others_of_it() {
        let base = SpectralUnion::pretrained().unwrap();
        let options = TuneOptions { pairs: 24, aside: 4, epochs: 6, ..TuneOptions::default() };
        let examples =
            |par| family_examples(&quadrupeds(8), &base, &options, par, Progress::none()).unwrap();
        let own = examples(Par::Threads(2));
        assert_eq!(own.training, examples(Par::Seq).training);
        let (settings, state) = start(&base, &options);
        let mut trainer = Trainer::new(own, settings, Some(state), Par::all()).unwrap();
        let before = trainer.best_error();
        for _ in 0..options.epochs {
            trainer.epoch().unwrap();
        }
        assert!(trainer.best_error() < 0.9 * before, "{} {before}", trainer.best_error());
        // The meshes of the training are in distribution.
        let pair = &trainer.examples().validation[0];
        let score = trainer.model().unwrap().ood_score(&[&pair.first, &pair.second]).unwrap();
        assert!(score < 2.0, "{score}");
    }

    #[test]
    fn one_mesh_is_too_few() {
        let base = SpectralUnion::pretrained().unwrap();
        let refused = divide_pairs(vec![vec![]], &base, &TuneOptions::default());
        assert!(refused.unwrap_err().to_string().starts_with("meshes: must be at least 2"));
        let refused = divide_pairs(vec![vec![]; 2], &base, &TuneOptions::default());
        assert!(refused.unwrap_err().to_string().starts_with("meshes: too few pairs"));
    }
}
