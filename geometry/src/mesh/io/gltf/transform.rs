//! Affine transformations of nodes.

use super::super::super::vector::{Vector, cross, dot};
use super::super::draft::Checked;
use super::document::Node;

/// An affine transformation: the images of the three axes and of the origin.
#[derive(Clone, Copy)]
pub(in super::super) struct Transform {
    axes: [Vector; 3],
    origin: Vector,
}

impl Transform {
    pub const IDENTITY: Self =
        Self { axes: [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]], origin: [0.0; 3] };

    /// Creates the transformation with these images of the three axes and of the origin.
    pub fn new(axes: [Vector; 3], origin: Vector) -> Self {
        Self { axes, origin }
    }

    /// Returns the transformation from a node to its parent; an error for a matrix that is not
    /// affine.
    pub(super) fn of(node: &Node) -> Checked<Self> {
        if let Some(m) = node.matrix {
            if [m[3], m[7], m[11], m[15]] != [0.0, 0.0, 0.0, 1.0] {
                return Err(format!("matrix {m:?} is not affine").into());
            }
            let column = |i: usize| [m[4 * i], m[4 * i + 1], m[4 * i + 2]];
            return Ok(Self { axes: [0, 1, 2].map(column), origin: column(3) });
        }
        Ok(Self::of_parts(node.translation, node.rotation, node.scale))
    }

    /// Returns the transformation that scales, then rotates by a quaternion (x, y, z, w), then
    /// translates.
    pub fn of_parts(
        translation: Option<Vector>,
        rotation: Option<[f64; 4]>,
        scale: Option<Vector>,
    ) -> Self {
        let given = rotation.unwrap_or([0.0, 0.0, 0.0, 1.0]);
        // Files hold rounded quaternions, which would scale.
        let length = given.iter().map(|x| x * x).sum::<f64>().sqrt();
        let [x, y, z, w] = if length > 0.0 { given.map(|x| x / length) } else { given };
        let rotated = [
            [1.0 - 2.0 * (y * y + z * z), 2.0 * (x * y + z * w), 2.0 * (x * z - y * w)],
            [2.0 * (x * y - z * w), 1.0 - 2.0 * (x * x + z * z), 2.0 * (y * z + x * w)],
            [2.0 * (x * z + y * w), 2.0 * (y * z - x * w), 1.0 - 2.0 * (x * x + y * y)],
        ];
        let scale = scale.unwrap_or([1.0; 3]);
        let axes = [0, 1, 2].map(|i| rotated[i].map(|x| x * scale[i]));
        Self { axes, origin: translation.unwrap_or([0.0; 3]) }
    }

    /// Returns the composition that applies `inner` first, then this transformation.
    pub fn after(&self, inner: &Self) -> Self {
        Self { axes: inner.axes.map(|axis| self.direction(axis)), origin: self.point(inner.origin) }
    }

    /// Returns the transformed point.
    pub fn point(&self, p: Vector) -> Vector {
        let moved = self.direction(p);
        std::array::from_fn(|k| moved[k] + self.origin[k])
    }

    fn direction(&self, d: Vector) -> Vector {
        std::array::from_fn(|k| (0..3).map(|i| d[i] * self.axes[i][k]).sum())
    }

    /// Returns the normal transformed by the cofactors, of length 1 unless it is zero.
    pub fn normal(&self, n: Vector) -> Vector {
        let [a, b, c] = self.axes;
        let cofactors = [cross(b, c), cross(c, a), cross(a, b)];
        let side = if self.is_mirrored() { -1.0 } else { 1.0 };
        let moved: Vector =
            std::array::from_fn(|k| side * (0..3).map(|i| n[i] * cofactors[i][k]).sum::<f64>());
        let length = dot(moved, moved).sqrt();
        if length > 0.0 { moved.map(|x| x / length) } else { moved }
    }

    /// Returns whether the transformation turns faces over.
    pub fn is_mirrored(&self) -> bool {
        let [a, b, c] = self.axes;
        dot(cross(a, b), c) < 0.0
    }
}
