//! Vectors and rotations in space.

pub type Vector = [f64; 3];

pub fn add(a: Vector, b: Vector) -> Vector {
    [a[0] + b[0], a[1] + b[1], a[2] + b[2]]
}

pub fn sub(a: Vector, b: Vector) -> Vector {
    [a[0] - b[0], a[1] - b[1], a[2] - b[2]]
}

pub fn scale(s: f64, a: Vector) -> Vector {
    a.map(|x| s * x)
}

pub fn dot(a: Vector, b: Vector) -> f64 {
    a[0] * b[0] + a[1] * b[1] + a[2] * b[2]
}

pub fn cross(a: Vector, b: Vector) -> Vector {
    [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]]
}

pub fn distance(a: Vector, b: Vector) -> f64 {
    dot(sub(a, b), sub(a, b)).sqrt()
}

/// The mirror image in the plane x = 0.
pub fn mirrored(a: Vector) -> Vector {
    [-a[0], a[1], a[2]]
}

/// A rotation, its rows.
pub type Rotation = [Vector; 3];

/// No rotation.
pub const IDENTITY: Rotation = [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]];

pub fn rotate(r: &Rotation, p: Vector) -> Vector {
    r.map(|row| dot(row, p))
}

/// First b, then a.
pub fn compose(a: &Rotation, b: &Rotation) -> Rotation {
    a.map(|row| std::array::from_fn(|j| (0..3).map(|k| row[k] * b[k][j]).sum()))
}

/// The rotation about an axis by its length in radians (Rodrigues).
pub fn about(axis: Vector) -> Rotation {
    let angle = dot(axis, axis).sqrt();
    if angle == 0.0 {
        return IDENTITY;
    }
    let u = scale(1.0 / angle, axis);
    let (sin, cos) = angle.sin_cos();
    let turned = |p: Vector| {
        let along = scale(dot(u, p) * (1.0 - cos), u);
        add(add(scale(cos, p), scale(sin, cross(u, p))), along)
    };
    let columns = IDENTITY.map(turned);
    std::array::from_fn(|i| columns.map(|column| column[i]))
}
