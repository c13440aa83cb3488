//! The implicit surface around bones: a smooth union of capsules.

use catamaran_geometry::mesh::vector::{Vector, distance, dot, scale, sub};

use super::skeleton::{Bone, Skeleton};

/// The smooth union of distances d to the capsules, `-s ln(sum exp(-d / s))`, symmetric in x.
pub(super) struct Field<'a> {
    skeleton: &'a Skeleton,
    /// s, the width of the rounding of creases between limbs.
    pub smoothness: f64,
}

impl<'a> Field<'a> {
    pub fn new(skeleton: &'a Skeleton, smoothness: f64) -> Self {
        Self { skeleton, smoothness }
    }

    /// Returns approximately the signed distance, negative inside.
    pub fn at(&self, p: Vector) -> f64 {
        // Equal to the value on the other side, bit for bit.
        let p = [p[0].abs(), p[1], p[2]];
        let s = self.smoothness;
        let nearest =
            self.skeleton.bones.iter().map(|bone| to_flesh(bone, p)).fold(f64::INFINITY, f64::min);
        let sum: f64 =
            self.skeleton.bones.iter().map(|bone| ((nearest - to_flesh(bone, p)) / s).exp()).sum();
        nearest - s * sum.ln()
    }

    /// Returns the point on the surface near p, by steps along the gradient (central differences).
    pub fn onto_surface(&self, mut p: Vector) -> Vector {
        let step = 1e-4 * self.smoothness;
        for _ in 0..3 {
            let gradient = std::array::from_fn(|k| {
                let (mut above, mut below) = (p, p);
                above[k] += step;
                below[k] -= step;
                (self.at(above) - self.at(below)) / (2.0 * step)
            });
            let slope = dot(gradient, gradient);
            // The gradient is zero in the middle of a limb.
            if slope < 0.01 {
                break;
            }
            p = sub(p, scale(gradient, self.at(p) / slope));
        }
        p
    }

    /// Returns the corners of a box around the surface.
    pub fn bounds(&self) -> [Vector; 2] {
        let mut bounds = [[f64::INFINITY; 3], [f64::NEG_INFINITY; 3]];
        for bone in &self.skeleton.bones {
            for (p, radius) in [bone.head, bone.tail].iter().zip(bone.radii) {
                for k in 0..3 {
                    bounds[0][k] = bounds[0][k].min(p[k] - radius - 3.0 * self.smoothness);
                    bounds[1][k] = bounds[1][k].max(p[k] + radius + 3.0 * self.smoothness);
                }
            }
        }
        bounds
    }
}

/// Returns the distance of p to the surface of a capsule whose radius changes linearly from end to
/// end, negative inside.
pub(super) fn to_flesh(bone: &Bone, p: Vector) -> f64 {
    let axis = sub(bone.tail, bone.head);
    let t = (dot(sub(p, bone.head), axis) / dot(axis, axis)).clamp(0.0, 1.0);
    let nearest = std::array::from_fn(|k| bone.head[k] + t * axis[k]);
    distance(p, nearest) - (bone.radii[0] + t * (bone.radii[1] - bone.radii[0]))
}
