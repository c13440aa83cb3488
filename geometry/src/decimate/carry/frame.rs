//! Textures of single faces as affine maps.

use crate::mesh::vector::{Vector, cross, dot, doubled_normal, norm, scale, sub, unit};

/// A point of a texture.
pub(super) type Uv = [f64; 2];

/// Ratio of the singular values of a face below which it counts as without area in the texture.
const FLATTEST: f64 = 1e-6;

/// Largest stretch or compression of a face in any direction.
const STRETCH: f64 = 3.0;

/// The texture of a face, extended over its plane.
pub(super) struct Frame {
    normal: Vector,
    /// The gradients of u and v, in the plane.
    gradients: [Vector; 2],
}

impl Frame {
    /// Creates the frame of the face with these corners; `None` where the face has no area on the
    /// surface or in the texture.
    pub fn of([a, b, c]: [Vector; 3], uv: [Uv; 3]) -> Option<Self> {
        let (ab, ac) = (sub(b, a), sub(c, a));
        let normal = cross(ab, ac);
        let square = dot(normal, normal);
        let (at_b, at_c) = (cross(ac, normal), cross(normal, ab));
        let gradients = [0, 1].map(|k| -> Vector {
            let (b, c) = (uv[1][k] - uv[0][k], uv[2][k] - uv[0][k]);
            std::array::from_fn(|i| (b * at_b[i] + c * at_c[i]) / square)
        });
        let [u, v] = gradients;
        let area = norm(cross(u, v));
        let usable = area.is_finite() && area > FLATTEST * (dot(u, u) + dot(v, v));
        usable.then(|| Self { normal: unit(normal), gradients })
    }

    /// Returns the texture at `step` from a point whose texture is `from`.
    pub fn continued(&self, from: Uv, step: Vector) -> Uv {
        [0, 1].map(|k| from[k] + dot(self.gradients[k], step))
    }

    /// Returns the texture of a face that is rotated about `hinge` into this plane, where the
    /// texture is `from` at `hinge`. With `flipped`, the back of this plane faces outwards.
    pub fn unfolded(
        &self,
        from: Uv,
        hinge: Vector,
        corners: [Vector; 3],
        flipped: bool,
    ) -> [Uv; 3] {
        let own = unit(doubled_normal(corners));
        let normal = if flipped { scale(self.normal, -1.0) } else { self.normal };
        corners.map(|p| self.continued(from, turned(sub(p, hinge), own, normal)))
    }
}

/// Returns a vector after the shortest rotation that takes one unit vector to another.
fn turned(step: Vector, from: Vector, to: Vector) -> Vector {
    let sum: Vector = std::array::from_fn(|k| from[k] + to[k]);
    let half = dot(sum, sum) / 2.0;
    if half > 1e-9 {
        let (along_sum, along_from) = (dot(sum, step) / half, 2.0 * dot(from, step));
        return std::array::from_fn(|k| step[k] - sum[k] * along_sum + to[k] * along_from);
    }
    // Half a turn about any orthogonal axis.
    let least = (0..3).min_by(|&i, &j| from[i].abs().total_cmp(&from[j].abs())).unwrap_or(0);
    let mut other = [0.0; 3];
    other[least] = 1.0;
    let axis = unit(cross(from, other));
    std::array::from_fn(|k| 2.0 * dot(axis, step) * axis[k] - step[k])
}

/// Returns twice the area, negative for clockwise corners.
pub(super) fn area([a, b, c]: [Uv; 3]) -> f64 {
    (b[0] - a[0]) * (c[1] - a[1]) - (b[1] - a[1]) * (c[0] - a[0])
}

/// Returns whether the affine map of a triangle to another one neither reverses its orientation nor
/// stretches or compresses it by more than [`STRETCH`].
pub(super) fn is_fair(from: [Uv; 3], to: [Uv; 3]) -> bool {
    let whole = area(from);
    let part = |k: usize, c: usize| {
        // The derivative of component c of the image along axis k.
        let mut corners = from;
        for (corner, image) in corners.iter_mut().zip(to) {
            corner[k] = image[c];
        }
        area(corners) / whole
    };
    let [p, q, r, s] = [part(0, 0), part(1, 0), part(0, 1), part(1, 1)];
    let determinant = p * s - q * r;
    let squares = p * p + q * q + r * r + s * s;
    // The singular values a and b satisfy: a b is the determinant, a a + b b the sum of squares.
    let largest =
        (squares / 2.0 + ((squares / 2.0).powi(2) - determinant.powi(2)).max(0.0).sqrt()).sqrt();
    determinant > 0.0 && largest <= STRETCH && determinant / largest >= 1.0 / STRETCH
}
