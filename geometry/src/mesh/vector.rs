//! Arithmetic of points and directions in space.

/// A point or direction in space.
pub type Vector = [f64; 3];

/// Returns `a + b`.
pub fn add(a: Vector, b: Vector) -> Vector {
    [a[0] + b[0], a[1] + b[1], a[2] + b[2]]
}

/// Returns `a - b`.
pub fn sub(a: Vector, b: Vector) -> Vector {
    [a[0] - b[0], a[1] - b[1], a[2] - b[2]]
}

/// Returns `s a`.
pub fn scale(a: Vector, s: f64) -> Vector {
    [a[0] * s, a[1] * s, a[2] * s]
}

/// Returns the scalar product.
pub fn dot(a: Vector, b: Vector) -> f64 {
    a[0] * b[0] + a[1] * b[1] + a[2] * b[2]
}

/// Returns the vector product.
pub fn cross(a: Vector, b: Vector) -> Vector {
    [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]]
}

/// Returns the normal of a triangle, scaled to twice its area.
pub fn doubled_normal([a, b, c]: [Vector; 3]) -> Vector {
    cross(sub(b, a), sub(c, a))
}

/// Returns the square of the length.
pub fn square(a: Vector) -> f64 {
    dot(a, a)
}

/// Returns the length.
pub fn norm(a: Vector) -> f64 {
    square(a).sqrt()
}

/// Returns the direction of `a`, of length 1; zero if `a` has none.
pub fn unit(a: Vector) -> Vector {
    let length = norm(a);
    if length > 0.0 { a.map(|x| x / length) } else { [0.0; 3] }
}

/// Returns the distance between two points.
pub fn distance(a: Vector, b: Vector) -> f64 {
    norm(sub(a, b))
}

/// Returns the point in the middle between two.
pub fn middle(a: Vector, b: Vector) -> Vector {
    std::array::from_fn(|k| 0.5 * (a[k] + b[k]))
}

/// Returns bits that are equal where the numbers are: adding zero turns -0 into 0.
pub(crate) fn bits<const N: usize>(values: [f64; N]) -> [u64; N] {
    values.map(|x| (x + 0.0).to_bits())
}
