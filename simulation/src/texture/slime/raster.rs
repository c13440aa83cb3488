use super::surface::{NO_TRIANGLE, Surface, doubled_area};
use catamaran::base::{Result, reserved, zeros};

/// The triangle of each texel, and the share of the surface that each texel covers.
pub(super) struct Raster {
    pub owners: Vec<u32>,
    pub areas: Vec<f32>,
    /// Triangles that overlap others in the texture, ascending.
    pub overlapping: Vec<u32>,
}

/// Positions in `f32` may be wrong by this share of the side of the texture: texels that near to a
/// triangle count as its own, too.
const SLACK: f64 = 4.0 * f32::EPSILON as f64;

/// Assigns texels to triangles in two passes over all triangles: a texel belongs to the triangle
/// that contains its centre, or otherwise to the first triangle that touches it.
pub(super) fn raster(surface: &Surface, size: usize) -> Result<Raster> {
    let mut owners = reserved(size * size)?;
    owners.resize(size * size, NO_TRIANGLE);
    let mut areas = zeros::<f32>(size * size)?;
    let mut overlaps = reserved(surface.len())?;
    overlaps.resize(surface.len(), false);
    for (t, &area) in surface.areas().iter().enumerate() {
        let triangle = Triangle::new(surface, t, size);
        let density = area / triangle.area;
        triangle.for_texels(|i, j, part| {
            let texel = j * size + i;
            areas[texel] += (part.area * density) as f32;
            if part.centre && owners[texel] == NO_TRIANGLE {
                owners[texel] = t as u32;
            } else if part.inside {
                overlaps[t] = true;
                overlaps[owners[texel] as usize] = true;
            }
        });
    }
    for t in 0..surface.len() {
        Triangle::new(surface, t, size).for_texels(|i, j, _| {
            let owner = &mut owners[j * size + i];
            if *owner == NO_TRIANGLE {
                *owner = t as u32;
            }
        });
    }
    let overlapping = (0..).zip(overlaps).filter(|(_, overlaps)| *overlaps).map(|(t, _)| t);
    Ok(Raster { owners, areas, overlapping: overlapping.collect() })
}

/// The relation of a triangle to a texel.
struct Part {
    area: f64,
    /// Whether the triangle contains the centre of the texel, perhaps on an edge.
    centre: bool,
    /// Whether it contains the centre, and not on an edge but for rounding.
    inside: bool,
}

/// A triangle in the texture, in texels, counter-clockwise.
struct Triangle {
    corners: [[f64; 2]; 3],
    /// For each edge, a x + b y + c is the distance from the edge, positive inside.
    edges: [[f64; 3]; 3],
    area: f64,
    slack: f64,
    size: usize,
}

impl Triangle {
    fn new(surface: &Surface, t: usize, size: usize) -> Self {
        let mut corners = surface.uv()[t].map(|p| p.map(|x| x * size as f64));
        if doubled_area(&corners) < 0.0 {
            corners.swap(1, 2);
        }
        let edge = |k: usize| {
            let (p, q) = (corners[k], corners[(k + 1) % 3]);
            let d = [q[0] - p[0], q[1] - p[1]];
            let length = d[0].hypot(d[1]);
            let [a, b] = [-d[1] / length, d[0] / length];
            [a, b, -(a * p[0] + b * p[1])]
        };
        Self {
            corners,
            edges: [0, 1, 2].map(edge),
            area: doubled_area(&corners) / 2.0,
            slack: SLACK * size as f64,
            size,
        }
    }

    /// Calls `visit` for the texels that the triangle touches, row by row.
    fn for_texels(&self, mut visit: impl FnMut(usize, usize, Part)) {
        let range = |axis: usize| {
            let values = self.corners.map(|p| p[axis]);
            let low = values.into_iter().fold(f64::INFINITY, f64::min) - self.slack;
            let high = values.into_iter().fold(0.0, f64::max) + self.slack;
            low.max(0.0) as usize..=(high as usize).min(self.size - 1)
        };
        for j in range(1) {
            for i in range(0) {
                let (x, y) = (i as f64 + 0.5, j as f64 + 0.5);
                let (mut centre, mut whole, mut near, mut deep) = (true, true, true, true);
                for [a, b, c] in self.edges {
                    let inside = a * x + b * y + c;
                    // Half of the width of the texel across the edge.
                    let half = (a.abs() + b.abs()) / 2.0;
                    centre &= inside >= 0.0;
                    deep &= inside > self.slack;
                    whole &= inside >= half;
                    near &= inside >= -half - self.slack;
                }
                if whole {
                    visit(i, j, Part { area: 1.0, centre, inside: deep });
                } else if near {
                    visit(i, j, Part { area: self.overlap(i, j), centre, inside: deep });
                }
            }
        }
    }

    /// Returns the area of the intersection of the triangle with a texel, clipped at its four sides
    /// (Sutherland and Hodgman 1974).
    fn overlap(&self, i: usize, j: usize) -> f64 {
        let (x, y) = (i as f64, j as f64);
        // Relative to the texel, so that there is no cancellation.
        let mut polygon: Vec<[f64; 2]> =
            self.corners.iter().map(|p| [p[0] - x, p[1] - y]).collect();
        for (axis, side) in [(0, 0.0), (0, 1.0), (1, 0.0), (1, 1.0)] {
            let inside = |p: &[f64; 2]| if side == 0.0 { p[axis] } else { 1.0 - p[axis] };
            let mut cut = Vec::with_capacity(8);
            for (k, p) in polygon.iter().enumerate() {
                let q = &polygon[(k + 1) % polygon.len()];
                let (at_p, at_q) = (inside(p), inside(q));
                if at_p >= 0.0 {
                    cut.push(*p);
                }
                if (at_p >= 0.0) != (at_q >= 0.0) {
                    let s = at_p / (at_p - at_q);
                    cut.push([p[0] + s * (q[0] - p[0]), p[1] + s * (q[1] - p[1])]);
                }
            }
            polygon = cut;
        }
        let Some(&first) = polygon.first() else { return 0.0 };
        let fan = polygon.windows(2).map(|w| doubled_area(&[first, w[0], w[1]]));
        (fan.sum::<f64>() / 2.0).clamp(0.0, 1.0)
    }
}
