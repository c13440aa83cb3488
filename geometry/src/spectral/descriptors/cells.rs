use crate::mesh::vector::{Vector, distance};

/// Largest number of cells along an axis, so that the number of a cell fits 63 bits.
const MOST: f64 = (1_u64 << 20) as f64;

/// Points sorted into the cells of a cubic grid, to find those near a position.
pub(super) struct Cells<'p> {
    points: &'p [Vector],
    origin: Vector,
    side: f64,
    /// The numbers of the cell and of the point, sorted.
    entries: Vec<(u64, u32)>,
}

impl<'p> Cells<'p> {
    /// Creates an index of finite points for searches within `radius`, which is positive.
    pub fn new(points: &'p [Vector], radius: f64) -> Self {
        let extreme = |pick: fn(f64, f64) -> f64| {
            let first = points.first().copied().unwrap_or_default();
            points.iter().fold(first, |e, p| std::array::from_fn(|k| pick(e[k], p[k])))
        };
        let (origin, end) = (extreme(f64::min), extreme(f64::max));
        let extent = (0..3).map(|k| end[k] - origin[k]).fold(0.0, f64::max);
        let mut cells = Self { points, origin, side: radius.max(extent / MOST), entries: vec![] };
        let mut entries: Vec<_> =
            points.iter().zip(0..).map(|(p, i)| (key(cells.cell(p)), i)).collect();
        entries.sort_unstable();
        cells.entries = entries;
        cells
    }

    /// Calls `found` with each point within `radius` of `place`, at most the radius given to `new`,
    /// and its distance.
    pub fn near(&self, place: &Vector, radius: f64, mut found: impl FnMut(u32, f64)) {
        let [x, y, z] = self.cell(place);
        for x in x.saturating_sub(1)..=x + 1 {
            for y in y.saturating_sub(1)..=y + 1 {
                // Cells along z have consecutive numbers.
                let (first, last) = (key([x, y, z.saturating_sub(1)]), key([x, y, z + 1]));
                let start = self.entries.partition_point(|e| e.0 < first);
                for &(_, i) in self.entries[start..].iter().take_while(|e| e.0 <= last) {
                    let d = distance(*place, self.points[i as usize]);
                    if d <= radius {
                        found(i, d);
                    }
                }
            }
        }
    }

    fn cell(&self, p: &Vector) -> [u64; 3] {
        std::array::from_fn(|k| ((p[k] - self.origin[k]) / self.side) as u64)
    }
}

fn key([x, y, z]: [u64; 3]) -> u64 {
    x << 42 | y << 21 | z
}
