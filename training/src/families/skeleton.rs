//! Bones, the proportions of identities, and poses.

use catamaran::base::Rng;
use catamaran_geometry::mesh::vector::{Vector, add, distance, dot, scale, sub};

use super::rotation::{Rotation, about, compose, mirrored, rotate};

/// The body type whose proportions differ from the template `EXAGGERATION` times as much as those
/// of type A.
pub(crate) const CARICATURE: usize = 2;
const EXAGGERATION: f64 = 3.0;

/// An entry of the list of bones: a bone in the middle, or one on the side of positive x with its
/// mirror image.
pub(super) struct Spec {
    /// The number of the parent in the list, which comes before; the first bone is its own parent.
    pub parent: usize,
    pub head: Vector,
    pub tail: Vector,
    /// Radii of the body at head and tail.
    pub radii: [f64; 2],
    /// Ranges of the rotation vector about the head, in radians.
    pub turns: [[f64; 2]; 3],
    /// Factors of length and thickness in body type B.
    pub body_b: [f64; 2],
}

/// A bone of a skeleton.
#[derive(Debug, Clone)]
pub(super) struct Bone {
    pub parent: usize,
    pub mirror: usize,
    pub head: Vector,
    pub tail: Vector,
    pub radii: [f64; 2],
    turns: [[f64; 2]; 3],
    body_b: [f64; 2],
    /// Number of the entry; bones of an entry share the factors of an identity.
    spec: usize,
}

/// The bones; parents come first.
#[derive(Debug, Clone)]
pub(super) struct Skeleton {
    pub bones: Vec<Bone>,
}

/// Factors of length and thickness of the bones of an identity.
pub(super) struct Proportions(Vec<[f64; 2]>);

/// The placement of a bone, in a pose of an identity.
struct Placed {
    /// Head at rest; then the head in the pose, and the rotation from rest.
    rest: Vector,
    head: Vector,
    rotation: Rotation,
}

impl Skeleton {
    pub fn new(specs: &[Spec]) -> Self {
        let mut bones: Vec<Bone> = Vec::new();
        // Right and left bone of every entry.
        let mut numbers: Vec<[usize; 2]> = Vec::new();
        for (number, spec) in specs.iter().enumerate() {
            let right = bones.len();
            let middle = spec.head[0] == 0.0 && spec.tail[0] == 0.0;
            let left = if middle { right } else { right + 1 };
            numbers.push([right, left]);
            let parents = numbers[spec.parent];
            bones.push(Bone {
                parent: parents[0],
                mirror: left,
                head: spec.head,
                tail: spec.tail,
                radii: spec.radii,
                turns: spec.turns,
                body_b: spec.body_b,
                spec: number,
            });
            if !middle {
                let [x, y, z] = spec.turns;
                bones.push(Bone {
                    parent: parents[1],
                    mirror: right,
                    head: mirrored(spec.head),
                    tail: mirrored(spec.tail),
                    // The mirror image of a rotation has the same angle about x, and the opposite
                    // angles about y and z.
                    turns: [x, [-y[1], -y[0]], [-z[1], -z[0]]],
                    ..bones[right].clone()
                });
            }
        }
        Self { bones }
    }

    /// Returns whether one bone is the parent of the other, or both are the same.
    pub fn adjacent(&self, a: usize, b: usize) -> bool {
        a == b || self.bones[a].parent == b || self.bones[b].parent == a
    }

    /// Draws proportions of body type A (0), B (1) or caricatures of A (2): of the whole body, and
    /// of every bone.
    pub fn proportions(&self, body: usize, rng: &mut Rng) -> Proportions {
        let more = if body == CARICATURE { EXAGGERATION } else { 1.0 };
        let mut about_one = |spread: f64| 1.0 + more * spread * (2.0 * rng.uniform() - 1.0);
        let size = about_one(0.08);
        let stout = about_one(0.15);
        let own: Vec<[f64; 2]> =
            (0..self.entries()).map(|_| [about_one(0.12), about_one(0.08)]).collect();
        let factors = self.bones.iter().map(|bone| {
            let [length, radius] = if body == 1 { bone.body_b } else { [1.0, 1.0] };
            [size * length * own[bone.spec][0], size * radius * stout * own[bone.spec][1]]
        });
        Proportions(factors.collect())
    }

    /// Returns the number of entries of the list of bones.
    pub fn entries(&self) -> usize {
        self.bones.iter().map(|bone| bone.spec + 1).max().unwrap_or(0)
    }

    /// Returns the proportions with these factors of length and thickness of each entry.
    pub fn with_entries(&self, factors: &[[f64; 2]]) -> Proportions {
        Proportions(self.bones.iter().map(|bone| factors[bone.spec]).collect())
    }

    /// Draws a pose: a rotation for each bone, whose angles are multiplied by a factor.
    pub fn pose(&self, turned: f64, rng: &mut Rng) -> Vec<Rotation> {
        let mut within = |[low, high]: [f64; 2]| turned * (low + (high - low) * rng.uniform());
        self.bones.iter().map(|bone| about(bone.turns.map(&mut within))).collect()
    }

    /// Returns the positions of the vertices, which bones move with these weights.
    pub fn skin(
        &self,
        vertices: &[Vector],
        weights: &[Vec<(u32, f64)>],
        proportions: &Proportions,
        pose: &[Rotation],
    ) -> Vec<Vector> {
        let placed = self.place(proportions, pose);
        let moved = |b: usize, p: Vector| {
            let at = &placed[b];
            let from_head = sub(self.proportioned(b, p, proportions, at.rest), at.rest);
            add(at.head, rotate(&at.rotation, from_head))
        };
        let blended = |(&p, held): (&Vector, &Vec<(u32, f64)>)| {
            held.iter().fold([0.0; 3], |sum, &(b, w)| add(sum, scale(moved(b as usize, p), w)))
        };
        vertices.iter().zip(weights).map(blended).collect()
    }

    fn place(&self, proportions: &Proportions, pose: &[Rotation]) -> Vec<Placed> {
        let mut placed: Vec<Placed> = Vec::new();
        for (b, bone) in self.bones.iter().enumerate() {
            let next = match placed.get(bone.parent) {
                Some(parent) => {
                    let rest = self.proportioned(bone.parent, bone.head, proportions, parent.rest);
                    let from_head = rotate(&parent.rotation, sub(rest, parent.rest));
                    let rotation = compose(&parent.rotation, &pose[b]);
                    Placed { rest, head: add(parent.head, from_head), rotation }
                }
                None => Placed { rest: bone.head, head: bone.head, rotation: pose[b] },
            };
            placed.push(next);
        }
        placed
    }

    /// Scales a point of bone b, whose head moves to `head`: along the bone by its length, and
    /// across and beyond its ends by its thickness.
    fn proportioned(&self, b: usize, p: Vector, proportions: &Proportions, head: Vector) -> Vector {
        let bone = &self.bones[b];
        let [longer, thicker] = proportions.0[b];
        let length = distance(bone.head, bone.tail);
        let axis = scale(sub(bone.tail, bone.head), 1.0 / length);
        let from_head = sub(p, bone.head);
        let along = dot(from_head, axis);
        let inside = along.clamp(0.0, length);
        let across = sub(from_head, scale(axis, along));
        let along = longer * inside + thicker * (along - inside);
        add(head, add(scale(axis, along), scale(across, thicker)))
    }
}

impl Proportions {
    /// Returns the proportions of the template.
    #[cfg(test)]
    pub fn of_template(skeleton: &Skeleton) -> Self {
        Self(vec![[1.0; 2]; skeleton.bones.len()])
    }
}

/// Returns the pose at rest.
#[cfg(test)]
pub(super) fn rest(skeleton: &Skeleton) -> Vec<Rotation> {
    vec![super::rotation::IDENTITY; skeleton.bones.len()]
}
