//! Families of shapes with identities and poses, generated from a seed.
//!
//! All shapes of a family have the faces of its template and corresponding vertices, so that a mask
//! over the template is a part of every shape.

mod bodies;
mod creatures;
mod field;
mod isosurface;
mod rotation;
mod sheet;
mod skeleton;
mod unusual;
mod weights;

use catamaran::base::Rng;
use catamaran::{Error, Result};
use catamaran_geometry::mesh::{Components, TriMesh};

use field::Field;
use sheet::Sheet;
pub(crate) use skeleton::CARICATURE;
use skeleton::{Skeleton, Spec};
pub use unusual::Unusual;

/// A kind of shapes.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Family {
    /// Humans with 16 bones, whose arms are stretched out at rest.
    Humanoid,
    /// Animals on four legs.
    Quadruped,
    /// Two cups on a band.
    Headphones,
    /// Folded sheets, with a boundary.
    Sheet,
    /// Bodies of random bones. Every one has its own template, see [`Model::creature`].
    Creature,
}

impl Family {
    /// The families whose shapes share a template, in the order of their numbers.
    pub const TEMPLATED: [Self; 4] =
        [Self::Humanoid, Self::Quadruped, Self::Headphones, Self::Sheet];

    /// Returns the number of the family in data sets.
    pub fn number(self) -> usize {
        self as usize
    }
}

/// A family, or one creature, with its template.
#[derive(Debug, Clone)]
pub struct Model {
    family: Family,
    template: TriMesh,
    mirror: Vec<u32>,
    segments: Vec<u32>,
    kind: Kind,
}

#[derive(Debug, Clone)]
enum Kind {
    /// Bones, and for each vertex the bones that move it, with weights that sum to 1.
    Rigged(Skeleton, Vec<Vec<(u32, f64)>>),
    Sheet(Sheet),
}

impl Model {
    /// Creates the family with a template of about `vertices` vertices: at least 500, so that limbs
    /// are thicker than the edges of triangles are long.
    ///
    /// # Errors
    /// [`Error::Argument`] for fewer than 500 vertices, or more than a million, and for creatures,
    /// which have no common template.
    pub fn new(family: Family, vertices: usize) -> Result<Self> {
        let (specs, smoothness): (&[_], _) = match family {
            Family::Humanoid => (&bodies::HUMANOID, 0.012),
            Family::Quadruped => (&bodies::QUADRUPED, 0.012),
            Family::Headphones => (&bodies::HEADPHONES, 0.006),
            Family::Sheet => return Self::sheet(vertices),
            Family::Creature => {
                let why = "must not be `Creature`: creatures have no common template".into();
                return Err(Error::Argument { what: "family", why });
            }
        };
        Self::rigged(family, specs, smoothness, vertices)
    }

    /// Creates a creature with about `vertices` vertices, as in [`new`](Self::new). The same seed
    /// and number give the same creature.
    ///
    /// # Errors
    /// Those of [`new`](Self::new); [`Error::Mesh`] if none of a few attempts gives a surface.
    pub fn creature(seed: u64, number: usize, vertices: usize) -> Result<Self> {
        let attempt = |attempt: u64| {
            let seed = mixed(&[seed, Family::Creature as u64, number as u64, attempt, 0xB0DE]);
            let specs = creatures::specs(vertices, &mut Rng::new(seed));
            let model = Self::rigged(Family::Creature, &specs, creatures::SMOOTHNESS, vertices)?;
            match Components::new(&model.template).len() {
                1 => Ok(model),
                pieces => Err(Error::Mesh {
                    what: format!("{pieces} pieces"),
                    element: format!("creature {number}"),
                }),
            }
        };
        (1..ATTEMPTS).fold(attempt(0), |found, next| match found {
            Err(Error::Mesh { .. }) => attempt(next),
            found => found,
        })
    }

    fn rigged(family: Family, specs: &[Spec], smoothness: f64, vertices: usize) -> Result<Self> {
        check(vertices)?;
        let skeleton = Skeleton::new(specs);
        let field = Field::new(&skeleton, smoothness);
        let isosurface::Symmetric { mesh, mirror } = isosurface::surface(&field, vertices)?;
        let weights = weights::weights(&skeleton, &mesh, &mirror);
        // The bone with the largest weight; the first of equal ones.
        let heaviest = |held: &Vec<(u32, f64)>| {
            held.iter().fold((0, 0.0), |best, &next| if next.1 > best.1 { next } else { best }).0
        };
        let segments = weights.iter().map(heaviest).collect();
        Ok(Self { family, template: mesh, mirror, segments, kind: Kind::Rigged(skeleton, weights) })
    }

    fn sheet(vertices: usize) -> Result<Self> {
        check(vertices)?;
        let sheet = Sheet::new(vertices);
        let (template, mirror) = sheet.template()?;
        let segments = sheet.segments();
        Ok(Self { family: Family::Sheet, template, mirror, segments, kind: Kind::Sheet(sheet) })
    }

    /// Returns the family.
    pub fn family(&self) -> Family {
        self.family
    }

    /// Returns the shape at rest, which is its own mirror image in the plane x = 0, bit for bit.
    pub fn template(&self) -> &TriMesh {
        &self.template
    }

    /// Returns the mirror image of each vertex.
    pub fn mirror(&self) -> &[u32] {
        &self.mirror
    }

    /// Returns, for each vertex, the bone or the tile of the sheet to which it belongs.
    pub fn segments(&self) -> &[u32] {
        &self.segments
    }

    /// Returns the shape of an identity of a body type (0: A, 1: B, 2: a caricature of A) in one of
    /// its poses. The same arguments give the same shape.
    ///
    /// # Errors
    /// None in practice.
    pub fn shape(&self, seed: u64, identity: usize, body: usize, pose: usize) -> Result<TriMesh> {
        let mut of_identity = Rng::new(mixed(&[seed, self.family as u64, identity as u64]));
        let mut of_pose =
            Rng::new(mixed(&[seed, self.family as u64, identity as u64, 1 + pose as u64]));
        let positions = match &self.kind {
            Kind::Rigged(skeleton, weights) => {
                let proportions = skeleton.proportions(body, &mut of_identity);
                let pose = skeleton.pose(1.0, &mut of_pose);
                skeleton.skin(self.template.vertices(), weights, &proportions, &pose)
            }
            Kind::Sheet(sheet) => {
                sheet.folded(self.template.vertices(), body, &mut of_identity, &mut of_pose)
            }
        };
        TriMesh::new(positions, self.template.faces().to_vec())
    }

    /// Returns an unusual human. The same arguments give the same shape.
    ///
    /// # Errors
    /// [`Error::Argument`] for another family than the humanoids.
    pub fn unusual(&self, kind: Unusual, seed: u64, number: usize) -> Result<TriMesh> {
        let Kind::Rigged(skeleton, weights) = &self.kind else { return Err(no_human()) };
        if self.family != Family::Humanoid {
            return Err(no_human());
        }
        let mut rng = Rng::new(mixed(&[seed, kind as u64, number as u64, UNUSUAL]));
        let proportions = kind.proportions(skeleton, &mut rng);
        let pose = skeleton.pose(kind.turned(), &mut rng);
        let positions = skeleton.skin(self.template.vertices(), weights, &proportions, &pose);
        TriMesh::new(positions, self.template.faces().to_vec())
    }
}

fn no_human() -> Error {
    Error::Argument { what: "family", why: "must be `Humanoid`".into() }
}

/// Mixed into the seeds of unusual humans, so that they share no numbers with others.
const UNUSUAL: u64 = 0x0DD;

/// Number of attempts per creature: thin limbs that nearly touch may not give a surface.
const ATTEMPTS: u64 = 20;

fn check(vertices: usize) -> Result<()> {
    if !(500..=1_000_000).contains(&vertices) {
        let why = format!("must be from 500 to 1000000, is {vertices}");
        return Err(Error::Argument { what: "vertices", why });
    }
    Ok(())
}

/// Returns one seed from several numbers (the finalizer of SplitMix64, Steele et al. 2014).
pub(crate) fn mixed(numbers: &[u64]) -> u64 {
    numbers.iter().fold(0x9e37_79b9_7f4a_7c15, |state, &number| {
        let mut z = (state ^ number).wrapping_add(0x9e37_79b9_7f4a_7c15);
        z = (z ^ (z >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
        z ^ (z >> 31)
    })
}

#[cfg(test)]
mod tests;
