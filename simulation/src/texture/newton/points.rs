//! The points at which fractals are computed.

use super::options::{FARTHEST, Parameters};
use catamaran::base::{Error, Result};

/// A lattice of points: a plane, or a volume. Point (i, j, k) is `origin` + i `steps[0]` + j
/// `steps[1]` + k `steps[2]`, and has the number i + `counts[0]` (j + `counts[1]` k).
///
/// ```
/// use catamaran_simulation::texture::newton::Grid;
///
/// let cube = Grid::cube(4, 2.0);
/// assert_eq!((cube.counts, cube.origin), ([4; 3], [-0.75; 3]));
/// assert_eq!(Grid::plane(3, 2, [0.0, 0.0], 3.0).origin, [-1.0, 0.5, 0.0]);
/// ```
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Grid {
    /// Point (0, 0, 0).
    pub origin: [f32; 3],
    /// The steps from a point to the next one in each of the three directions.
    pub steps: [[f32; 3]; 3],
    /// Number of points in each of the three directions, at most 65,536.
    pub counts: [u32; 3],
}

impl Grid {
    /// Returns the grid of the centres of the `width` x `height` pixels of the rectangle of the
    /// plane z = 0 whose middle is `center` and that is `extent` wide; rows from the top (large y)
    /// down.
    pub fn plane(width: u32, height: u32, center: [f64; 2], extent: f64) -> Self {
        let step = extent / f64::from(width.max(1));
        let first = |count: u32| (f64::from(count) - 1.0) / 2.0 * step;
        Self {
            origin: [(center[0] - first(width)) as f32, (center[1] + first(height)) as f32, 0.0],
            steps: [[step as f32, 0.0, 0.0], [0.0, -step as f32, 0.0], [0.0; 3]],
            counts: [width, height, 1],
        }
    }

    /// Returns the grid of the centres of the side^3 voxels of the cube whose middle is the origin
    /// and whose edges are `extent` long; x runs fastest.
    pub fn cube(side: u32, extent: f64) -> Self {
        let step = (extent / f64::from(side.max(1))) as f32;
        let first = -(f64::from(side) - 1.0) / 2.0 * f64::from(step);
        Self {
            origin: [first as f32; 3],
            steps: [[step, 0.0, 0.0], [0.0, step, 0.0], [0.0, 0.0, step]],
            counts: [side; 3],
        }
    }

    /// Computes a point. Each sum and product is rounded, in this order, as on devices.
    #[inline(always)]
    fn at(&self, i: u32, row: [f32; 3]) -> [f32; 3] {
        let i = i as f32;
        [0, 1, 2].map(|c| row[c] + i * self.steps[0][c])
    }

    #[inline(always)]
    fn row(&self, j: u32, k: u32) -> [f32; 3] {
        let (j, k) = (j as f32, k as f32);
        [0, 1, 2].map(|c| (self.origin[c] + k * self.steps[2][c]) + j * self.steps[1][c])
    }
}

/// The points at which a fractal is computed.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Points<'a> {
    /// The points of a lattice, which are never stored.
    Grid(Grid),
    /// Any points, such as the vertices of a mesh or the texels of [`texels`](super::texels()).
    List(&'a [[f32; 3]]),
}

impl Points<'_> {
    /// Returns the number of points, or an error unless the fractal can be computed at all of them.
    pub(crate) fn check(&self, parameters: &Parameters) -> Result<usize> {
        let near = |p: [f32; 3]| {
            let scaled = |c: usize| (p[c] + parameters.offset[c]) * parameters.scale;
            let w = parameters.offset[3] * parameters.scale;
            [scaled(0), scaled(1), scaled(2), w].iter().all(|x| f64::from(x.abs()) <= FARTHEST)
        };
        let count = match self {
            Self::Grid(grid) => {
                let sides = grid.counts.map(u64::from);
                if sides.iter().any(|&side| side > 1 << 16) {
                    let why = format!("at most 65,536 points a side, got {:?}", grid.counts);
                    return Err(Error::Argument { what: "grid", why });
                }
                for corner in 0..8_u32 {
                    let [i, j, k] = [0, 1, 2].map(|c| {
                        if corner >> c & 1 == 1 { grid.counts[c].saturating_sub(1) } else { 0 }
                    });
                    if !near(grid.at(i, grid.row(j, k))) {
                        return Err(Error::NonFinite { what: "grid", index: (corner as usize, 0) });
                    }
                }
                sides.iter().product()
            }
            Self::List(list) => {
                if let Some(i) = list.iter().position(|&p| !near(p)) {
                    return Err(Error::NonFinite { what: "points", index: (i, 0) });
                }
                list.len() as u64
            }
        };
        if count >= 1 << 31 {
            let why = format!("must be fewer than 2^31, are {count}");
            return Err(Error::Argument { what: "points", why });
        }
        Ok(count as usize)
    }
}

/// Iterates over points.
pub(super) struct Cursor<'a> {
    points: Points<'a>,
    /// The index of the next point of a list.
    next: usize,
    /// The next point of a grid, and the point at which its row begins.
    place: [u32; 3],
    row: [f32; 3],
}

impl<'a> Cursor<'a> {
    /// Creates a cursor that begins at point `first`.
    pub fn new(points: Points<'a>, first: usize) -> Self {
        let (mut place, mut row) = ([0; 3], [0.0; 3]);
        if let Points::Grid(grid) = points {
            let [nx, ny] = [grid.counts[0].max(1) as usize, grid.counts[1].max(1) as usize];
            place = [first % nx, first / nx % ny, first / nx / ny].map(|i| i as u32);
            row = grid.row(place[1], place[2]);
        }
        Self { points, next: first, place, row }
    }

    /// Returns the next point; after the end of a list, returns its last point again and again.
    #[inline(always)]
    pub fn advance(&mut self) -> [f32; 3] {
        match &self.points {
            Points::List(list) => {
                let point = list[self.next.min(list.len() - 1)];
                self.next += 1;
                point
            }
            Points::Grid(grid) => {
                let point = grid.at(self.place[0], self.row);
                self.place[0] += 1;
                if self.place[0] >= grid.counts[0] {
                    self.place[0] = 0;
                    self.place[1] += 1;
                    if self.place[1] >= grid.counts[1] {
                        self.place[1] = 0;
                        self.place[2] += 1;
                    }
                    self.row = grid.row(self.place[1], self.place[2]);
                }
                point
            }
        }
    }
}
