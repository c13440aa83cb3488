//! Maps positions on the surface to texels of its texture, and back.

use super::surface::{Surface, UV};
use super::walk::{Walker, moved_inside};

/// Returns the texel of a walker.
#[inline]
pub(super) fn texel(surface: &Surface, size: u32, walker: &Walker) -> u32 {
    let record = &surface.records()[walker.triangle as usize];
    let [x, y] = walker.position;
    let u = record[UV] + record[UV + 1] * x + record[UV + 2] * y;
    let v = record[UV + 3] + record[UV + 4] * x + record[UV + 5] * y;
    // The conversion clamps: negative numbers become 0.
    let at = |part: f32| ((part * size as f32) as u32).min(size - 1);
    at(v) * size + at(u)
}

/// Returns the point of a triangle nearest to the centre of a texel, in the frame of the triangle.
pub(super) fn anchor(surface: &Surface, size: usize, triangle: u32, texel: usize) -> [f32; 2] {
    let record = &surface.records()[triangle as usize];
    let [u0, a, b, v0, c, d] = [0, 1, 2, 3, 4, 5].map(|i| f64::from(record[UV + i]));
    let at = |i: usize| (i as f64 + 0.5) / size as f64;
    let (u, v) = (at(texel % size) - u0, at(texel / size) - v0);
    let determinant = a * d - b * c;
    let point = [(d * u - b * v) / determinant, (a * v - c * u) / determinant];
    moved_inside(surface, triangle, point.map(|x| x as f32))
}
