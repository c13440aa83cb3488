//! Parts of the shapes of a family: masks over the vertices of the template, and pairs of masks.
//!
//! Thesis, section 2.5: regions are geodesic balls, unions of segments and half spaces, with
//! smoothed edges, and pairs consist of regions that overlap. Two spectra can belong to several
//! unions (figure 2.3); of these, only the one with the least area is kept, on the left.

mod draw;
mod pairs;
mod regions;
#[cfg(test)]
mod tests;
mod triples;

use std::collections::BTreeMap;

use catamaran::base::Rng;
use catamaran::{Par, Result};
use catamaran_geometry::mesh::TriMesh;

use crate::families::Model;
pub(crate) use draw::below;
#[cfg(test)]
pub(crate) use pairs::canonical;
pub(crate) use pairs::no_pair;
pub use regions::{Mask, id};
pub(crate) use regions::{Surface, union};

/// Smallest number of vertices that two parts share.
pub const OVERLAP: usize = 50;

/// Numbers of regions, pairs and triples; small templates may give fewer.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct CutOptions {
    /// Number of regions: a third each of geodesic balls, unions of segments, and half spaces.
    pub regions: usize,
    /// Number of pairs of regions.
    pub pairs: usize,
    /// Number of pairs of a region and the union of an earlier pair, which occur in unions of many
    /// parts.
    pub composites: usize,
    /// Number of pairs into which one region is split; the union is then that region. The first
    /// ones split the complete shape.
    pub splits: usize,
    /// Number of triples.
    pub triples: usize,
    /// Seed.
    pub seed: u64,
}

impl Default for CutOptions {
    fn default() -> Self {
        Self { regions: 50, pairs: 90, composites: 0, splits: 60, triples: 12, seed: 1 }
    }
}

/// Two parts and their union, as ids.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub struct Pair {
    /// The parts, the smaller id first.
    pub parts: [usize; 2],
    /// The union.
    pub union: usize,
}

/// Three parts; the first overlaps the second and the second overlaps the third.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub struct Triple {
    /// The parts.
    pub parts: [usize; 3],
    /// The unions of the first two and of the last two.
    pub unions: [usize; 2],
    /// The union of all three.
    pub whole: usize,
}

/// The cuts of a family.
#[derive(Debug, Clone, PartialEq)]
pub struct Cuts {
    /// All masks by their ids, without duplicates.
    pub masks: BTreeMap<usize, Mask>,
    /// The pairs, without duplicates.
    pub pairs: Vec<Pair>,
    /// The triples, without duplicates.
    pub triples: Vec<Triple>,
}

impl Cuts {
    /// Returns the id of the mask that covers everything.
    pub fn complete(&self) -> usize {
        let vertices = self.masks.values().next().map_or(0, Vec::len);
        id(&vec![true; vertices])
    }

    fn keep(&mut self, mask: Mask) -> usize {
        let id = id(&mask);
        self.masks.insert(id, mask);
        id
    }
}

/// Cuts the template of a family. The same options give the same cuts for any number of threads.
///
/// # Errors
/// Those of [`HeatMethod`](catamaran_geometry::mesh::HeatMethod).
pub fn cuts(model: &Model, options: &CutOptions, par: Par) -> Result<Cuts> {
    let surface = Surface::new(model.template(), model.mirror(), par)?;
    cuts_of(&surface, model.segments(), options)
}

/// Cuts a mesh without known symmetry and segments, by balls and planes. The same options give the
/// same cuts for any number of threads.
///
/// # Errors
/// Those of [`HeatMethod`](catamaran_geometry::mesh::HeatMethod).
pub fn cuts_of_mesh(mesh: &TriMesh, options: &CutOptions, par: Par) -> Result<Cuts> {
    let itself: Vec<u32> = (0..mesh.vertices().len() as u32).collect();
    cuts_of(&Surface::new(mesh, &itself, par)?, &[], options)
}

fn cuts_of(surface: &Surface<'_>, segments: &[u32], options: &CutOptions) -> Result<Cuts> {
    let mut rng = Rng::new(crate::families::mixed(&[options.seed, 0xC075]));
    let regions = draw::regions(surface, segments, options.regions, &mut rng)?;
    let mut cuts = Cuts { masks: BTreeMap::new(), pairs: vec![], triples: vec![] };
    pairs::of_regions(surface, [&regions, &regions], options.pairs, &mut cuts, &mut rng);
    let unions: Vec<Mask> = cuts.pairs.iter().map(|pair| cuts.masks[&pair.union].clone()).collect();
    pairs::of_regions(surface, [&unions, &regions], options.composites, &mut cuts, &mut rng);
    pairs::by_splitting(surface, &regions, options.splits, &mut cuts, &mut rng)?;
    triples::find(surface, options.triples, &mut cuts, &mut rng);
    Ok(cuts)
}
