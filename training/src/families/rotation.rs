//! Rotations and mirror images in space.

use catamaran_geometry::mesh::vector::{Vector, add, cross, dot, norm, scale};

/// Returns the mirror image in the plane x = 0.
pub fn mirrored(a: Vector) -> Vector {
    [-a[0], a[1], a[2]]
}

/// A rotation matrix, by rows.
pub type Rotation = [Vector; 3];

/// The identity.
pub const IDENTITY: Rotation = [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]];

pub fn rotate(r: &Rotation, p: Vector) -> Vector {
    r.map(|row| dot(row, p))
}

/// Returns the product of two rotations: first b, then a.
pub fn compose(a: &Rotation, b: &Rotation) -> Rotation {
    a.map(|row| std::array::from_fn(|j| (0..3).map(|k| row[k] * b[k][j]).sum()))
}

/// Returns the rotation about an axis by the length of the axis in radians (Rodrigues).
pub fn about(axis: Vector) -> Rotation {
    let angle = norm(axis);
    if angle == 0.0 {
        return IDENTITY;
    }
    let u = scale(axis, 1.0 / angle);
    let (sin, cos) = angle.sin_cos();
    let turned = |p: Vector| {
        let along = scale(u, dot(u, p) * (1.0 - cos));
        add(add(scale(p, cos), scale(cross(u, p), sin)), along)
    };
    let columns = IDENTITY.map(turned);
    std::array::from_fn(|i| columns.map(|column| column[i]))
}
