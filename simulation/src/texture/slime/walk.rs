use super::surface::{ACROSS_FLIP, HOPS, NO_TRIANGLE, Surface, UV};

/// The number of edges after which a walk ends. Steps of a sensible length do not reach it.
pub const MOST_HOPS: usize = 4096;

/// A position on a surface and a direction, of an agent or a sensor.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Walker {
    /// The triangle.
    pub triangle: u32,
    /// The position in the frame of the triangle.
    pub position: [f32; 2],
    /// The unit heading in the frame of the triangle.
    pub heading: [f32; 2],
}

/// Moves a walker straight ahead by `length`: across an edge, the next triangle is unfolded into
/// the plane of the current one, as for a geodesic; a boundary edge reflects the walker. Without
/// `rescale`, `length` is measured in the texture, whose side is 1 (thesis, figure 3.5).
///
/// ```
/// use catamaran_simulation::texture::slime::{Surface, Walker, unfold};
///
/// // One turn around a tile, whose sides are joined, ends at the start.
/// let tile = Surface::tile()?;
/// let [a, b, c] = tile.corners()[0];
/// let position = [0, 1].map(|k| ((a[k] + b[k] + c[k]) / 3.0) as f32);
/// let end = unfold(&tile, Walker { triangle: 0, position, heading: [1.0, 0.0] }, 1.0, true);
/// assert_eq!(end.triangle, 0);
/// assert!((end.position[0] - position[0]).abs() < 1e-5);
/// # Ok::<(), catamaran::Error>(())
/// ```
#[inline]
pub fn unfold(surface: &Surface, mut walker: Walker, length: f32, rescale: bool) -> Walker {
    let mut remaining = length;
    let mut entered = 3;
    for _ in 0..MOST_HOPS {
        let stretch = if rescale { 1.0 } else { stretch(surface, &walker) };
        let reach = if rescale { remaining } else { remaining / stretch };
        let (exit, way) = first_exit(surface, &walker, reach, entered);
        let [x, y] = walker.position;
        let [dx, dy] = walker.heading;
        walker.position = [x + way * dx, y + way * dy];
        if exit == 3 {
            break;
        }
        remaining -= way * stretch;
        entered = cross(surface, &mut walker, exit);
    }
    walker
}

/// Returns the edge at which a walker leaves its triangle within `reach`, 3 for none, and the
/// distance to it.
#[inline(always)]
fn first_exit(surface: &Surface, walker: &Walker, reach: f32, entered: usize) -> (usize, f32) {
    let record = &surface.records()[walker.triangle as usize];
    let [x, y] = walker.position;
    let [dx, dy] = walker.heading;
    let (mut exit, mut way) = (3, reach);
    for k in 0..3 {
        let [a, b, c] = [record[3 * k], record[3 * k + 1], record[3 * k + 2]];
        let inside = a * x + b * y + c;
        let rate = a * dx + b * dy;
        // Rounding may have moved the walker a little outside; then it leaves at once.
        if k != entered && rate < 0.0 && inside + rate * reach < 0.0 {
            let at = if inside > 0.0 { inside } else { 0.0 } / -rate;
            if at < way {
                (exit, way) = (k, at);
            }
        }
    }
    (exit, way)
}

/// Moves a walker across edge k; returns the index of the edge in its new triangle.
#[inline]
fn cross(surface: &Surface, walker: &mut Walker, k: usize) -> usize {
    let t = walker.triangle as usize;
    let record = &surface.records()[t];
    let [dx, dy] = walker.heading;
    let across = surface.across()[t][k];
    if across == NO_TRIANGLE {
        let [a, b] = [record[3 * k], record[3 * k + 1]];
        let twice = 2.0 * (a * dx + b * dy);
        walker.heading = [dx - twice * a, dy - twice * b];
        return k;
    }
    let hop = &record[HOPS + 4 * k..HOPS + 4 * k + 4];
    let (p, q, x0, y0) = (hop[0], hop[1], hop[2], hop[3]);
    let r = if across & ACROSS_FLIP == 0 { p } else { -p };
    let s = if across & ACROSS_FLIP == 0 { -q } else { q };
    let [x, y] = walker.position;
    walker.triangle = across >> 3;
    walker.position = [p * x + s * y + x0, q * x + r * y + y0];
    walker.heading = [p * dx + s * dy, q * dx + r * dy];
    (across & 3) as usize
}

/// Returns the factor by which the texture stretches lengths in the direction of a walker.
fn stretch(surface: &Surface, walker: &Walker) -> f32 {
    let record = &surface.records()[walker.triangle as usize];
    let [dx, dy] = walker.heading;
    let u = record[UV + 1] * dx + record[UV + 2] * dy;
    let v = record[UV + 4] * dx + record[UV + 5] * dy;
    (u * u + v * v).sqrt()
}

/// Moves a walker by algorithm 3.1 of the thesis: `count` sub-steps of `step` each, on the plane of
/// the triangle. A sub-step that ends beyond edges is projected, with its direction, onto the
/// nearest plane of the triangles across these edges; boundary edges reflect.
///
/// Differences from the thesis: positions are in the frame of the triangle instead of the texture
/// and a basis of its corners, so that no matrix is singular; a point whose projection is beside
/// the triangle is moved to its edge.
///
/// ```
/// use catamaran_geometry::mesh::families;
/// use catamaran_simulation::texture::slime::{Surface, Walker, atlas, project};
///
/// let sphere = families::icosphere(1)?;
/// let surface = Surface::of_faces(&sphere, atlas(&sphere, 128)?)?;
/// let [a, b, c] = surface.corners()[0];
/// let position = [0, 1].map(|k| ((a[k] + b[k] + c[k]) / 3.0) as f32);
/// let walker = Walker { triangle: 0, position, heading: [1.0, 0.0] };
/// let end = project(&surface, walker, 0.02, 20, true);
/// assert_ne!(end.triangle, 0);
/// # Ok::<(), catamaran::Error>(())
/// ```
pub fn project(
    surface: &Surface,
    mut walker: Walker,
    step: f32,
    count: u32,
    rescale: bool,
) -> Walker {
    let mut remaining = count;
    while remaining > 0 {
        let length = if rescale { step } else { step / stretch(surface, &walker) };
        let inside = steps_inside(surface, &walker, length, remaining);
        let [dx, dy] = walker.heading.map(|d| length * d);
        let [mut x, mut y] = walker.position;
        for _ in 0..inside {
            (x, y) = (x + dx, y + dy);
        }
        walker.position = [x, y];
        remaining -= inside;
        if remaining > 0 {
            substep(surface, &mut walker, length);
            remaining -= 1;
        }
    }
    walker
}

/// Returns how many of `most` sub-steps certainly stay in the triangle, so that they need no test
/// of its edges; steps that rounding makes doubtful are not counted.
#[inline(always)]
fn steps_inside(surface: &Surface, walker: &Walker, length: f32, most: u32) -> u32 {
    let record = &surface.records()[walker.triangle as usize];
    let [x, y] = walker.position;
    let [dx, dy] = walker.heading;
    // A whole number that single precision represents exactly.
    let mut steps = most.min(1 << 24) as f32;
    let way = length * steps;
    // Twice the bound of the rounding errors of the steps and of `first_exit`.
    let roundings = f32::EPSILON * (steps + 16.0);
    for k in 0..3 {
        let [a, b, c] = [record[3 * k], record[3 * k + 1], record[3 * k + 2]];
        let inside = a * x + b * y + c;
        let rate = a * dx + b * dy;
        let margin = roundings * (x.abs() + y.abs() + c.abs() + way);
        if rate < 0.0 {
            let here = (inside - margin) / -(rate * length);
            steps = if here < steps { here } else { steps };
        }
    }
    // Negative numbers: none.
    steps as u32
}

fn substep(surface: &Surface, walker: &mut Walker, length: f32) {
    let (exit, _) = first_exit(surface, walker, length, 3);
    let [x, y] = walker.position;
    let [dx, dy] = walker.heading;
    let ahead = [x + length * dx, y + length * dy];
    if exit == 3 {
        walker.position = ahead;
        return;
    }
    let t = walker.triangle as usize;
    if surface.across()[t][exit] == NO_TRIANGLE {
        let record = &surface.records()[t];
        let [a, b, c] = [record[3 * exit], record[3 * exit + 1], record[3 * exit + 2]];
        let twice = 2.0 * (a * ahead[0] + b * ahead[1] + c);
        cross(surface, walker, exit);
        walker.position = [ahead[0] - twice * a, ahead[1] - twice * b];
    } else {
        project_across(surface, walker, ahead, exit);
    }
    walker.position = moved_inside(surface, walker.triangle, walker.position);
}

fn project_across(surface: &Surface, walker: &mut Walker, ahead: [f32; 2], exit: usize) {
    let t = walker.triangle as usize;
    let from = &surface.frames()[t];
    let in_space = |i: usize, [x, y]: [f32; 2]| x * from[3 + i] + y * from[6 + i];
    let point = [0, 1, 2].map(|i| from[i] + in_space(i, ahead));
    let direction = [0, 1, 2].map(|i| in_space(i, walker.heading));
    let along = |a: [f32; 3], axis: &[f32]| a[0] * axis[0] + a[1] * axis[1] + a[2] * axis[2];
    let relative = |frame: &[f32; 12]| [0, 1, 2].map(|i| point[i] - frame[i]);
    let distance = |k: usize| {
        let frame = &surface.frames()[(surface.across()[t][k] >> 3) as usize];
        along(relative(frame), &frame[9..12]).abs()
    };
    let record = &surface.records()[t];
    let mut nearest = (exit, distance(exit));
    for k in 0..3 {
        let inside = record[3 * k] * ahead[0] + record[3 * k + 1] * ahead[1] + record[3 * k + 2];
        if k != exit && inside < 0.0 && surface.across()[t][k] != NO_TRIANGLE {
            let other = distance(k);
            if other < nearest.1 {
                nearest = (k, other);
            }
        }
    }
    let onto = surface.across()[t][nearest.0] >> 3;
    let frame = &surface.frames()[onto as usize];
    let local = relative(frame);
    let heading = [along(direction, &frame[3..6]), along(direction, &frame[6..9])];
    let length = (heading[0] * heading[0] + heading[1] * heading[1]).sqrt();
    // Across a fold of a right angle, projection leaves no direction: unfolding keeps it.
    cross(surface, walker, nearest.0);
    if length > 1e-3 {
        walker.heading = heading.map(|x| x / length);
    }
    walker.position = [along(local, &frame[3..6]), along(local, &frame[6..9])];
}

/// Returns a point moved to the edges beyond which it lies, or to the corner between them.
#[inline]
pub(super) fn moved_inside(surface: &Surface, triangle: u32, mut point: [f32; 2]) -> [f32; 2] {
    let record = &surface.records()[triangle as usize];
    let edge = |k: usize| [record[3 * k], record[3 * k + 1], record[3 * k + 2]];
    let inside = |k: usize, [x, y]: [f32; 2]| edge(k)[0] * x + edge(k)[1] * y + edge(k)[2];
    if (0..3).all(|k| inside(k, point) >= 0.0) {
        return point;
    }
    // Moving to the next edge may leave an earlier one, so edges are tested again.
    for k in [0, 1, 2, 0, 1, 2] {
        let beyond = inside(k, point);
        if beyond < 0.0 {
            point = [point[0] - beyond * edge(k)[0], point[1] - beyond * edge(k)[1]];
        }
    }
    // A sharp corner could take many rounds. Edge 2 was last, so the point is not beyond it.
    for k in [0, 1] {
        if inside(k, point) < -CORNER {
            let ([a, b, c], [p, q, r]) = (edge(k), edge(2));
            let determinant = a * q - p * b;
            point = [(b * r - q * c) / determinant, (p * c - a * r) / determinant];
        }
    }
    point
}

/// Largest distance between a point and its triangle that is due to rounding.
const CORNER: f32 = 1e-6;

#[cfg(test)]
mod tests {
    use super::*;
    use crate::texture::slime::atlas;
    use catamaran::base::Rng;
    use catamaran_geometry::mesh::families;

    #[test]
    fn steps_that_skip_the_edges_end_where_they_would() {
        let meshes = [families::torus(24, 12, 2.0, 0.7), families::torus(36, 3, 2.0, 0.1)];
        let mut rng = Rng::new(8);
        for mesh in meshes.map(Result::unwrap) {
            let surface = Surface::of_faces(&mesh, atlas(&mesh, 512).unwrap()).unwrap();
            for _ in 0..2000 {
                let triangle = (rng.uniform() * surface.len() as f64) as usize;
                let [_, b, c] = surface.corners()[triangle];
                let (sin, cos) = (std::f64::consts::TAU * rng.uniform()).sin_cos();
                // Includes points near corners and edges, and beyond them by a rounding error.
                let part = rng.uniform().powi(8) as f32;
                let walker = Walker {
                    triangle: triangle as u32,
                    position: [(b[0] + c[0]) as f32 / 3.0 * part, c[1] as f32 / 3.0 * part],
                    heading: [cos as f32, sin as f32],
                };
                let step = (0.1 * rng.uniform().powi(4)) as f32;
                for (count, rescale) in [(1, true), (10, true), (10, false), (101, true)] {
                    let mut each = walker;
                    for _ in 0..count {
                        let by = if rescale { step } else { step / stretch(&surface, &each) };
                        substep(&surface, &mut each, by);
                    }
                    assert_eq!(project(&surface, walker, step, count, rescale), each);
                }
            }
        }
    }
}
