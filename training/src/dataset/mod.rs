//! The data set: spectra of parts and of their unions.

mod file;
mod generate;
mod plan;

use catamaran::Result;
use catamaran::faer::Mat;
use catamaran_geometry::mesh::TriMesh;

pub use file::{read, write};
pub use generate::{generate, remove_shapes};
pub use plan::DatasetOptions;

/// Number of eigenvalues of every spectrum.
pub const EIGENVALUES: usize = 20;

/// The data of training and evaluation. Spectra have hard Dirichlet conditions on the boundary of
/// the part and of the surface. They ascend, in units of 1 / length^2, and are not scaled; areas
/// belong to them.
///
/// In a file, the name of each array consists of the names of its group and its field:
/// `samples_part1`, `shapes_spectrum`, `triples_whole`, and `template0_vertices` for the template
/// of family 0.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Dataset {
    /// One template per family, in the order of their numbers (see [`Samples::family`]); creatures
    /// have none.
    pub templates: Vec<Template>,
    /// Pairs of parts of one shape, with their union.
    pub samples: Samples,
    /// Complete shapes, for retrieval.
    pub shapes: Shapes,
    /// Triples of parts of one shape, for associativity.
    pub triples: Triples,
}

impl Dataset {
    /// Restricts the training samples to the first `count` known humanoids; the other known ones
    /// count as unknown then. Table 2.2 of the thesis requires one.
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

/// A shape in rest pose. The vertices of every shape of the family correspond to its vertices.
#[derive(Debug, Clone, PartialEq)]
pub struct Template {
    /// Positions, vertices x 3.
    pub vertices: Vec<[f64; 3]>,
    /// Vertices of each face, three per face.
    pub faces: Vec<usize>,
    /// For each vertex, its mirror image (itself in the plane x = 0).
    pub mirror: Vec<usize>,
    /// Area of each vertex, a third of that of its faces. It defines the inner product of the
    /// eigenfunctions.
    pub mass: Vec<f64>,
    /// The first 128 eigenvalues (Neumann), or fewer if there are fewer vertices.
    pub eigenvalues: Vec<f64>,
    /// The eigenfunctions, vertices x 128, orthonormal.
    pub eigenfunctions: Mat<f64>,
    /// Ids of all masks of parts and of unions, ascending. An id is a hash of the mask.
    pub masks: Vec<usize>,
    /// The masks, one after the other, each packed into words of 64 bits: bit `v % 64` of word
    /// `v / 64` is 1 if vertex v is in the mask.
    pub mask_words: Vec<usize>,
}

impl Template {
    /// Creates the mesh of the shape.
    ///
    /// # Errors
    /// Those of [`TriMesh::new`], when the file is invalid.
    pub fn mesh(&self) -> Result<TriMesh> {
        let faces = self.faces.chunks_exact(3).map(|f| [f[0] as u32, f[1] as u32, f[2] as u32]);
        TriMesh::new(self.vertices.clone(), faces.collect())
    }

    /// Returns the vertices of a mask, ascending; `None` if the mask does not exist.
    pub fn mask(&self, id: usize) -> Option<Vec<usize>> {
        let words = self.vertices.len().div_ceil(WORD);
        let at = self.masks.binary_search(&id).ok()? * words;
        let words = self.mask_words.get(at..at + words)?;
        let inside = |v: &usize| words[v / WORD] >> (v % WORD) & 1 == 1;
        Some((0..self.vertices.len()).filter(inside).collect())
    }
}

/// Number of vertices per word.
const WORD: usize = 64;

/// Packs a mask into words.
fn packed(mask: &[bool]) -> Vec<usize> {
    let word = |bits: &[bool]| bits.iter().rev().fold(0, |word, &bit| word << 1 | usize::from(bit));
    mask.chunks(WORD).map(word).collect()
}

/// The pairs as columns, each with one entry per pair.
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
    /// Family: 0 humanoids, 1 quadrupeds, 2 headphones, 3 sheets, 4 creatures (training only).
    pub family: Vec<usize>,
    /// Identity, numbered from 0 within the family.
    pub identity: Vec<usize>,
    /// Body type of the identity: 0 (A), 1 (B) or 2 (caricatures of A, training only).
    pub body: Vec<usize>,
    /// Pose, numbered from 0 within the identity; identities do not share poses.
    pub pose: Vec<usize>,
    /// Id of the mask of the first part.
    pub mask1: Vec<usize>,
    /// Id of the mask of the second part.
    pub mask2: Vec<usize>,
    /// Id of the mask of the union.
    pub mask_union: Vec<usize>,
    /// 1 if 30 % of the vertices were removed before the parts were cut, else 0.
    pub remeshed: Vec<usize>,
    /// Use of the sample: [`TRAIN`], [`TEST_A`] or [`TEST_B`].
    pub split: Vec<usize>,
    /// How the shape differs from those of the training: [`KNOWN_IDENTITY`], [`UNKNOWN_IDENTITY`],
    /// [`UNKNOWN_BODY`] or [`UNKNOWN_FAMILY`].
    pub knowledge: Vec<usize>,
}

/// A training sample: of a known identity, a caricature or a creature. It is remeshed only if the
/// shape has its own parts.
pub const TRAIN: usize = 0;
/// A test sample with a pose or a pair of parts that is in no training sample; its union, or nearly
/// its union, is in one, in another pose, identity or pair.
pub const TEST_A: usize = 1;
/// A test sample with a union that is in no training sample.
pub const TEST_B: usize = 2;

/// Some training samples have this identity.
pub const KNOWN_IDENTITY: usize = 0;
/// Some training samples have other identities of this body type.
pub const UNKNOWN_IDENTITY: usize = 1;
/// Training samples have only the other body type.
pub const UNKNOWN_BODY: usize = 2;
/// Training samples have only other families.
pub const UNKNOWN_FAMILY: usize = 3;

/// Complete shapes. The first eigenvalue of a closed shape is zero.
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

/// Triples of parts 1, 2 and 3 of a shape; 1 overlaps 2, and 2 overlaps 3.
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
