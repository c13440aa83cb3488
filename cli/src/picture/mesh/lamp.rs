//! Where light comes from.

use super::camera::Vector;

/// Where the two lamps are as the viewer sees it (right, up, near; unit vectors), and how bright.
pub const LAMPS: [(Vector, f64); 2] = [([-0.43, 0.62, 0.656], 0.68), ([0.77, 0.12, 0.627], 0.28)];
/// The scalar product.
pub fn dot(a: Vector, b: Vector) -> f64 {
    a[0] * b[0] + a[1] * b[1] + a[2] * b[2]
}

/// The direction of a vector; zero if it has none.
pub fn unit(a: Vector) -> Vector {
    let length = dot(a, a).sqrt();
    if length > 0.0 { a.map(|x| x / length) } else { a }
}
