//! Normal maps of heights, for the look of a surface that a texture raises.
//!
//! A normal map has, for each texel, the unit normal of the raised surface in the frame of the
//! surface there: x along growing u, y at a right angle to it on the side of growing v, z along the
//! normal. That is the frame of MikkTSpace, which glTF viewers, Blender and engines use; green is
//! up ("OpenGL").

use super::slime::{INSIDE, NO_TRIANGLE, OUTSIDE, Surface, Texels, UV, Walker};
use catamaran::base::{Error, Par, Result, finite, reserved};

/// Number of texels that one thread takes at a time.
const BLOCK: usize = 1 << 14;

/// A texture of heights on a plane, seen from above.
#[derive(Debug, Clone, Copy)]
pub struct HeightField<'a> {
    /// Heights; rows along u, the first at v = 0.
    pub heights: &'a [f32],
    /// Number of heights in a row, at least 1.
    pub width: usize,
    /// The side of a texel, in the same unit as `depth`.
    pub texel: f64,
    /// The height that a value of 1 stands for.
    pub depth: f64,
    /// Whether the texture is a tile, whose opposite sides are neighbours.
    pub repeats: bool,
}

/// Computes the normal map of a plane, by differences of neighbours. Differences are one-sided at
/// the border of a texture that does not repeat.
///
/// ```
/// use catamaran_simulation::texture::{HeightField, flat_normal_map};
///
/// // The slope is 1 along u: normals lean back by 45 degrees.
/// let heights: Vec<f32> = (0..16).map(|t| (t % 4) as f32).collect();
/// let field = HeightField { heights: &heights, width: 4, texel: 0.5, depth: 0.5, repeats: false };
/// let half = 0.5_f32.sqrt();
/// for [x, y, z] in flat_normal_map(field)? {
///     assert!((x + half).abs() < 1e-6 && y == 0.0 && (z - half).abs() < 1e-6);
/// }
/// # Ok::<(), catamaran::Error>(())
/// ```
///
/// # Errors
/// [`Error::Shape`] when heights are not whole rows, [`Error::Argument`] for a texel that is not
/// above 0 or a depth that is not finite, [`Error::OutOfMemory`].
pub fn flat_normal_map(field: HeightField<'_>) -> Result<Vec<[f32; 3]>> {
    let HeightField { heights, width, texel, depth, repeats } = field;
    let height = heights.len() / width.max(1);
    Error::check_shape("heights", (height.max(1), width.max(1)), (height, width))?;
    Error::check_shape("heights", (height * width, 1), (heights.len(), 1))?;
    if !(texel > 0.0 && texel.is_finite()) {
        let why = format!("must be a length above 0, is {texel}");
        return Err(Error::Argument { what: "texel", why });
    }
    finite("depth", depth)?;
    // The neighbours on both sides, and their distance in texels.
    let around = |i: usize, count: usize| match (i, repeats) {
        (_, true) => ((i + count - 1) % count, (i + 1) % count, 2.0),
        (0, false) => (0, 1.min(count - 1), 1.0),
        (_, false) if i + 1 == count => (i - 1, i, 1.0),
        (_, false) => (i - 1, i + 1, 2.0),
    };
    let mut normals = reserved(heights.len())?;
    for row in 0..height {
        let (below, above, rows) = around(row, height);
        for column in 0..width {
            let (left, right, columns) = around(column, width);
            let at = |i: usize, j: usize| f64::from(heights[j * width + i]);
            let along_u = (at(right, row) - at(left, row)) / (columns * texel);
            let along_v = (at(column, above) - at(column, below)) / (rows * texel);
            normals.push(leaning(depth * along_u, depth * along_v));
        }
    }
    Ok(normals)
}

/// Computes the normal map of a texture of a surface. `heights` has [`Texels::size`] rows and
/// columns; `depth` is the height that a value of 1 stands for, in the unit of the surface, the
/// square root of its area.
///
/// Slopes are relative to the surface, on which the texture may be stretched and rotated.
/// Neighbours across seams are found by walking on the surface ([`Texels::beside`]), so that no
/// seam shows. Texels outside of the surface have (0, 0, 1).
///
/// ```
/// use catamaran::Par;
/// use catamaran_geometry::mesh::families;
/// use catamaran_simulation::texture::normal_map;
/// use catamaran_simulation::texture::slime::{Surface, Texels, atlas};
///
/// let sphere = families::icosphere(1)?;
/// let surface = Surface::of_faces(&sphere, atlas(&sphere, 128)?)?;
/// let texels = Texels::new(&surface, 128)?;
/// let flat = normal_map(&surface, &texels, &vec![0.5; 128 * 128], 0.1, Par::all())?;
/// assert!(flat.iter().all(|n| *n == [0.0, 0.0, 1.0]));
/// # Ok::<(), catamaran::Error>(())
/// ```
///
/// # Errors
/// [`Error::Shape`] for another number of heights, [`Error::Argument`] for a depth that is not
/// finite.
pub fn normal_map(
    surface: &Surface,
    texels: &Texels,
    heights: &[f32],
    depth: f64,
    par: Par,
) -> Result<Vec<[f32; 3]>> {
    let size = texels.size();
    Error::check_shape("heights", (size * size, 1), (heights.len(), 1))?;
    finite("depth", depth)?;
    let field = Field { surface, texels, heights };
    let parts = par.map_blocks(heights.len(), BLOCK, |range| {
        range.map(|t| field.normal(t, depth)).collect::<Vec<_>>()
    });
    let mut normals = reserved(heights.len())?;
    parts.iter().for_each(|part| normals.extend_from_slice(part));
    Ok(normals)
}

/// Returns normals as colours: a byte for each of x, y and z, 0 for -1 and 255 for 1.
pub fn normal_colors(normals: &[[f32; 3]]) -> Vec<[u8; 3]> {
    let byte = |x: f32| (127.5 * x.clamp(-1.0, 1.0) + 127.5).round() as u8;
    normals.iter().map(|n| n.map(byte)).collect()
}

/// Returns the unit normal of a plane with these slopes along x and y.
fn leaning(x: f64, y: f64) -> [f32; 3] {
    let length = (1.0 + x * x + y * y).sqrt();
    // Adding zero turns -0 into 0.
    [0.0 - x / length, 0.0 - y / length, 1.0 / length].map(|c| c as f32)
}

struct Field<'a> {
    surface: &'a Surface,
    texels: &'a Texels,
    heights: &'a [f32],
}

impl Field<'_> {
    fn normal(&self, t: usize, depth: f64) -> [f32; 3] {
        let owner = self.texels.owners()[t];
        if owner == NO_TRIANGLE {
            return [0.0, 0.0, 1.0];
        }
        let size = self.texels.size() as f64;
        let [du, dv] = [[1, 0], [0, 1]].map(|step: [i32; 2]| {
            let after = self.height_beside(t, step);
            let before = self.height_beside(t, step.map(|c| -c));
            let here = f64::from(self.heights[t]);
            size * match (before, after) {
                (Some(before), Some(after)) => (after - before) / 2.0,
                (Some(before), None) => here - before,
                (None, Some(after)) => after - here,
                (None, None) => 0.0,
            }
        });
        // The map from the frame of the triangle to the texture.
        let record = &self.surface.records()[owner as usize];
        let [a, b, c, d] = [UV + 1, UV + 2, UV + 4, UV + 5].map(|i| f64::from(record[i]));
        let slope = [a * du + c * dv, b * du + d * dv];
        // The direction of growing u at constant v, then the side of growing v.
        let sign = (a * d - b * c).signum();
        let length = c.hypot(d);
        let tangent = [sign * d / length, -sign * c / length];
        let bitangent = [c / length, d / length];
        let along = |to: [f64; 2]| depth * (slope[0] * to[0] + slope[1] * to[1]);
        leaning(along(tangent), along(bitangent))
    }

    /// Returns the height one step further on the surface.
    fn height_beside(&self, t: usize, step: [i32; 2]) -> Option<f64> {
        let size = self.texels.size();
        let at = |x: usize, d: i32| x.checked_add_signed(d as isize).filter(|&x| x < size);
        let plain = at(t / size, step[1]).and_then(|j| Some(j * size + at(t % size, step[0])?));
        if let Some(n) = plain
            && (self.texels.kinds()[t] == INSIDE || self.chart(n) == self.chart(t))
        {
            return Some(f64::from(self.heights[n]));
        }
        self.height_at(self.texels.beside(self.surface, t, step)?)
    }

    /// Returns the height at a position, interpolated between the texels around it that are in its
    /// chart.
    fn height_at(&self, place: Walker) -> Option<f64> {
        let size = self.texels.size();
        let record = &self.surface.records()[place.triangle as usize];
        let [x, y] = place.position.map(f64::from);
        let chart = self.surface.charts()[place.triangle as usize];
        let texel = |first: usize| {
            let [o, a, b] = [0, 1, 2].map(|i| f64::from(record[first + i]));
            (o + a * x + b * y) * size as f64 - 0.5
        };
        let (u, v) = (texel(UV), texel(UV + 3));
        let (mut sum, mut weights) = (0.0, 0.0);
        for (i, j) in [(0.0, 0.0), (1.0, 0.0), (0.0, 1.0), (1.0, 1.0)] {
            let (column, row) = (u.floor() + i, v.floor() + j);
            let inside = 0.0..size as f64;
            if !inside.contains(&column) || !inside.contains(&row) {
                continue;
            }
            let n = row as usize * size + column as usize;
            if self.chart(n) == Some(chart) {
                let weight = (1.0 - (u - column).abs()) * (1.0 - (v - row).abs());
                sum += weight * f64::from(self.heights[n]);
                weights += weight;
            }
        }
        (weights > 0.0).then(|| sum / weights)
    }

    fn chart(&self, t: usize) -> Option<u32> {
        if self.texels.kinds()[t] == OUTSIDE {
            return None;
        }
        Some(self.surface.charts()[self.texels.owners()[t] as usize])
    }
}
