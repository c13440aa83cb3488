use catamaran::{Par, Result};
use catamaran_geometry::mesh::{LaplacianOptions, TriMesh};
use catamaran_geometry::unions::PartSpectra;

use crate::cuts::{CutOptions, Mask, cuts};
use crate::dataset::{EIGENVALUES, Spectrum};
use crate::families::{Family, Model, Unusual};
use crate::train::Pair;

/// A kind of humans of [`held_out`].
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Bodies {
    /// Body type A, as in the training.
    Usual,
    /// Body type B, which is not in the training.
    TypeB,
    /// A kind outside of the range of the training.
    Unusual(Unusual),
}

impl Bodies {
    /// All kinds.
    pub const ALL: [Self; 6] = [
        Self::Usual,
        Self::TypeB,
        Self::Unusual(Unusual::Child),
        Self::Unusual(Unusual::Heavy),
        Self::Unusual(Unusual::Lanky),
        Self::Unusual(Unusual::Contorted),
    ];

    /// Returns the name of the kind in tables.
    pub fn name(self) -> &'static str {
        match self {
            Self::Usual => "usual",
            Self::TypeB => "type B",
            Self::Unusual(Unusual::Child) => "child",
            Self::Unusual(Unusual::Heavy) => "heavy",
            Self::Unusual(Unusual::Lanky) => "lanky",
            Self::Unusual(Unusual::Contorted) => "contorted",
        }
    }

    /// Returns the human of this kind with a number.
    ///
    /// # Errors
    /// As [`Model::unusual`].
    pub fn shape(self, model: &Model, seed: u64, number: usize) -> Result<TriMesh> {
        match self {
            Self::Usual => model.shape(seed, number, 0, 0),
            Self::TypeB => model.shape(seed, number, 1, 0),
            Self::Unusual(kind) => model.unusual(kind, seed, number),
        }
    }
}

/// Number of vertices of the bodies.
const VERTICES: usize = 2_500;

/// Computes the spectra of pairs of parts of generated humans of each kind, `count` of them, with
/// the same cuts for all: those that data sets are made of, with another seed.
///
/// # Errors
/// Those of [`cuts`] and [`PartSpectra`].
pub fn held_out(seed: u64, count: usize, par: Par) -> Result<Vec<(Bodies, Pair)>> {
    let model = Model::new(Family::Humanoid, VERTICES)?;
    let options = CutOptions { regions: 24, pairs: 12, composites: 4, splits: 8, triples: 0, seed };
    let cuts = cuts(&model, &options, par)?;
    let mut found = Vec::new();
    for bodies in Bodies::ALL {
        for number in 0..count {
            let mesh = bodies.shape(&model, seed, number)?;
            let spectra = PartSpectra::new(&mesh, &LaplacianOptions::new().par(par))?;
            let spectrum = |mask: &Mask| -> Result<Spectrum> {
                let values = spectra.dirichlet(mask, EIGENVALUES)?;
                Ok(std::array::from_fn(|i| values[i]))
            };
            for pair in &cuts.pairs {
                let [first, second] = pair.parts.map(|part| spectrum(&cuts.masks[&part]));
                let union = spectrum(&cuts.masks[&pair.union])?;
                found.push((bodies, Pair { first: first?, second: second?, union, regions: None }));
            }
        }
    }
    Ok(found)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::evaluate::errors;
    use catamaran_geometry::unions::SpectralUnion;

    #[test]
    fn the_shipped_weights_predict_the_spectra_of_bodies_that_no_training_has() {
        let network = SpectralUnion::pretrained().unwrap();
        let pairs = held_out(31, 1, Par::all()).unwrap();
        for (bodies, most) in [(Bodies::Usual, 0.08), (Bodies::TypeB, 0.09)] {
            let own: Vec<Pair> =
                pairs.iter().filter(|(of, _)| *of == bodies).map(|(_, pair)| *pair).collect();
            let found = errors(&network, &own).unwrap();
            assert!(found.pairs > 10 && found.relative < most, "{bodies:?}: {found:?}");
        }
    }
}
