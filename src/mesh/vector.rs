//! The little vector arithmetic that triangles need.

/// A point or direction in space.
pub(crate) type Vector = [f64; 3];

pub(crate) fn sub(a: Vector, b: Vector) -> Vector {
    [a[0] - b[0], a[1] - b[1], a[2] - b[2]]
}

pub(crate) fn scale(a: Vector, s: f64) -> Vector {
    [a[0] * s, a[1] * s, a[2] * s]
}

pub(crate) fn dot(a: Vector, b: Vector) -> f64 {
    a[0] * b[0] + a[1] * b[1] + a[2] * b[2]
}

pub(crate) fn cross(a: Vector, b: Vector) -> Vector {
    [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]]
}

/// Returns the square of the length.
pub(crate) fn square(a: Vector) -> f64 {
    dot(a, a)
}

pub(crate) fn norm(a: Vector) -> f64 {
    square(a).sqrt()
}

/// Returns the direction of `a`; zero if it has none.
pub(crate) fn unit(a: Vector) -> Vector {
    let length = norm(a);
    if length > 0.0 { a.map(|x| x / length) } else { [0.0; 3] }
}

pub(crate) fn distance(a: Vector, b: Vector) -> f64 {
    norm(sub(a, b))
}

/// Returns the point in the middle between two.
pub(crate) fn middle(a: Vector, b: Vector) -> Vector {
    std::array::from_fn(|k| 0.5 * (a[k] + b[k]))
}
