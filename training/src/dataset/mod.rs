//! The data set: spectra of parts and of their unions.

mod file;
mod generate;
mod plan;

use catamaran::Result;
use catamaran::faer::Mat;
use catamaran::mesh::TriMesh;

pub use file::{read, write};
pub use generate::generate;
pub use plan::DatasetOptions;

/// Eigenvalues of every spectrum.
pub const EIGENVALUES: usize = 20;

/// What training and evaluation read. Spectra are those of hard Dirichlet conditions where the part
/// ends (and where the surface ends), ascending, in units of 1 / length^2, not scaled; areas belong
/// to them.
///
/// In a file, every array is called as its field, after the name of its group: `samples_part1`,
/// `shapes_spectrum`, `triples_whole`, and `template0_vertices` for the template of family 0.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Dataset {
    /// One a family, in the order of their numbers (see [`Samples::family`]); none of creatures.
    pub templates: Vec<Template>,
    /// Pairs of parts of one shape, with their union.
    pub samples: Samples,
    /// Complete shapes, to retrieve from.
    pub shapes: Shapes,
    /// Three parts of one shape, for associativity.
    pub triples: Triples,
}

impl Dataset {
    /// Keeps of the samples to train on those of the first known humanoids only, this many: what
    /// table 2.2 of the thesis asks for with one. The other known ones are unknown then.
    pub fn retain_identities(&mut self, count: usize) {
        let samples = &mut self.samples;
        for i in 0..samples.knowledge.len() {
            if samples.knowledge[i] == KNOWN_IDENTITY && samples.identity[i] >= count {
                samples.knowledge[i] = UNKNOWN_IDENTITY;
            }
        }
        let kept: Vec<bool> = (0..samples.part1.len())
            .map(|i| {
                samples.split[i] != TRAIN || samples.family[i] == 0 && samples.identity[i] < count
            })
            .collect();
        fn retain<T>(column: &mut Vec<T>, kept: &[bool]) {
            let mut kept = kept.iter();
            column.retain(|_| kept.next().is_none_or(|kept| *kept));
        }
        let Samples { part1, part2, union, areas, family, identity, body, pose, .. } = samples;
        [part1, part2, union].into_iter().for_each(|column| retain(column, &kept));
        retain(areas, &kept);
        [family, identity, body, pose].into_iter().for_each(|column| retain(column, &kept));
        let Samples { mask1, mask2, mask_union, remeshed, split, knowledge, .. } = samples;
        [mask1, mask2, mask_union, remeshed, split, knowledge]
            .into_iter()
            .for_each(|column| retain(column, &kept));
    }
}

/// The first eigenvalues of a part, ascending.
pub type Spectrum = [f64; EIGENVALUES];

/// A shape in rest pose, to whose vertices those of every shape of the family correspond.
#[derive(Debug, Clone, PartialEq)]
pub struct Template {
    /// Positions, vertices x 3.
    pub vertices: Vec<[f64; 3]>,
    /// Three vertices a face.
    pub faces: Vec<usize>,
    /// For each vertex the one that is its mirror image (itself in the plane x = 0).
    pub mirror: Vec<usize>,
    /// Area of each vertex: a third of its faces. The inner product of the eigenfunctions.
    pub mass: Vec<f64>,
    /// First 128 eigenvalues (Neumann), fewer if there are fewer vertices.
    pub eigenvalues: Vec<f64>,
    /// Their eigenfunctions, vertices x 128, orthonormal.
    pub eigenfunctions: Mat<f64>,
    /// Ids of all masks of parts and of unions, ascending. An id is a hash of the mask.
    pub masks: Vec<usize>,
    /// The masks, one after the other, each in as many words of 64 bits as it takes: bit `v % 64`
    /// of word `v / 64` says whether vertex v is in it.
    pub mask_words: Vec<usize>,
}

impl Template {
    /// The shape.
    ///
    /// # Errors
    /// As [`TriMesh::new`], for a file that is broken.
    pub fn mesh(&self) -> Result<TriMesh> {
        let faces = self.faces.chunks_exact(3).map(|f| [f[0] as u32, f[1] as u32, f[2] as u32]);
        TriMesh::new(self.vertices.clone(), faces.collect())
    }

    /// The vertices in a mask, ascending; `None` if there is no such mask.
    pub fn mask(&self, id: usize) -> Option<Vec<usize>> {
        let words = self.vertices.len().div_ceil(WORD);
        let at = self.masks.binary_search(&id).ok()? * words;
        let words = self.mask_words.get(at..at + words)?;
        let inside = |v: &usize| words[v / WORD] >> (v % WORD) & 1 == 1;
        Some((0..self.vertices.len()).filter(inside).collect())
    }
}

/// Vertices a word.
const WORD: usize = 64;

/// A mask in words.
fn packed(mask: &[bool]) -> Vec<usize> {
    let word = |bits: &[bool]| bits.iter().rev().fold(0, |word, &bit| word << 1 | usize::from(bit));
    mask.chunks(WORD).map(word).collect()
}

/// A column an entry: one for each of n pairs.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Samples {
    /// Spectrum of the first part, n x 20.
    pub part1: Vec<Spectrum>,
    /// Spectrum of the second part, n x 20.
    pub part2: Vec<Spectrum>,
    /// Spectrum of the union, n x 20.
    pub union: Vec<Spectrum>,
    /// Areas of first part, second part and union, n x 3.
    pub areas: Vec<[f64; 3]>,
    /// Family: 0 humanoids, 1 quadrupeds, 2 headphones, 3 sheets, 4 creatures (to train on).
    pub family: Vec<usize>,
    /// Identity, numbered from 0 in its family.
    pub identity: Vec<usize>,
    /// Body type of the identity: 0 (A), 1 (B) or 2 (caricatures of A, to train on).
    pub body: Vec<usize>,
    /// Pose, numbered from 0 in its identity; every identity has its own.
    pub pose: Vec<usize>,
    /// Id of the mask of the first part.
    pub mask1: Vec<usize>,
    /// Id of the mask of the second part.
    pub mask2: Vec<usize>,
    /// Id of the mask of the union.
    pub mask_union: Vec<usize>,
    /// 1 if 30 % of the vertices were removed before parts were cut, else 0.
    pub remeshed: Vec<usize>,
    /// What it is for: [`TRAIN`], [`TEST_A`] or [`TEST_B`].
    pub split: Vec<usize>,
    /// How strange the shape is: [`KNOWN_IDENTITY`], [`UNKNOWN_IDENTITY`], [`UNKNOWN_BODY`] or
    /// [`UNKNOWN_FAMILY`].
    pub knowledge: Vec<usize>,
}

/// A sample to train on: of a known identity, a caricature or a creature; remeshed only where parts
/// are the shape's own.
pub const TRAIN: usize = 0;
/// A pose or a pair of parts that no training sample has; its union one has, or nearly, in another
/// pose, identity or pair.
pub const TEST_A: usize = 1;
/// A union that no training sample has.
pub const TEST_B: usize = 2;

/// Training samples have this identity.
pub const KNOWN_IDENTITY: usize = 0;
/// Training samples have other identities of this body type.
pub const UNKNOWN_IDENTITY: usize = 1;
/// Training samples have the other body type only.
pub const UNKNOWN_BODY: usize = 2;
/// Training samples have another family only.
pub const UNKNOWN_FAMILY: usize = 3;

/// Complete shapes: closed ones have a first eigenvalue of zero.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Shapes {
    /// Spectrum, n x 20.
    pub spectrum: Vec<Spectrum>,
    /// Area.
    pub area: Vec<f64>,
    /// As in [`Samples`].
    pub family: Vec<usize>,
    /// As in [`Samples`].
    pub identity: Vec<usize>,
    /// As in [`Samples`].
    pub body: Vec<usize>,
    /// As in [`Samples`].
    pub pose: Vec<usize>,
    /// As in [`Samples`].
    pub knowledge: Vec<usize>,
}

/// Parts 1, 2, 3 of a shape, of which 1 meets 2 and 2 meets 3.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Triples {
    /// Spectrum of part 1, n x 20.
    pub part1: Vec<Spectrum>,
    /// Spectrum of part 2, n x 20.
    pub part2: Vec<Spectrum>,
    /// Spectrum of part 3, n x 20.
    pub part3: Vec<Spectrum>,
    /// Spectrum of the union of 1 and 2, n x 20.
    pub union12: Vec<Spectrum>,
    /// Spectrum of the union of 2 and 3, n x 20.
    pub union23: Vec<Spectrum>,
    /// Spectrum of the union of all three, n x 20.
    pub whole: Vec<Spectrum>,
    /// As in [`Samples`].
    pub family: Vec<usize>,
    /// As in [`Samples`].
    pub identity: Vec<usize>,
    /// As in [`Samples`].
    pub pose: Vec<usize>,
    /// Id of the mask of the union of all three.
    pub mask: Vec<usize>,
    /// As in [`Samples`].
    pub knowledge: Vec<usize>,
}
