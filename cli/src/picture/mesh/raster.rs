use super::camera::Projected;

/// No face.
const NONE: u32 = u32::MAX;

/// The part of the mesh that a sample shows: a face and the position on it, as shares of its
/// corners on the screen.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Hit {
    pub face: usize,
    pub shares: [f64; 3],
}

/// For each sample of a screen the nearest face.
#[derive(Debug)]
pub struct Buffer {
    width: usize,
    faces: Vec<u32>,
    nearness: Vec<f32>,
    /// Shares of the first two corners.
    shares: Vec<[f32; 2]>,
}

impl Buffer {
    /// Draws all faces; among equally near faces the first one stays.
    pub fn of(width: usize, height: usize, points: &[Projected], faces: &[[u32; 3]]) -> Self {
        let n = width * height;
        let mut buffer = Self {
            width,
            faces: vec![NONE; n],
            nearness: vec![f32::NEG_INFINITY; n],
            shares: vec![[0.0; 2]; n],
        };
        for (number, face) in (0..).zip(faces) {
            buffer.draw(number, face.map(|v| points[v as usize]), height);
        }
        buffer
    }

    fn draw(&mut self, number: u32, p: [Projected; 3], height: usize) {
        let doubled = side(p[0], p[1], p[2].x, p[2].y);
        if doubled == 0.0 || !doubled.is_finite() {
            return; // seen from its edge
        }
        let within = |c: [f64; 3], end: usize| {
            let low = c[0].min(c[1]).min(c[2]) - 0.5;
            let high = c[0].max(c[1]).max(c[2]) - 0.5;
            // Samples are taken in the middle; casts cut to the range of the type.
            (low.ceil().max(0.0) as usize)..((high.floor() + 1.0).max(0.0) as usize).min(end)
        };
        let columns = within(p.map(|p| p.x), self.width);
        for row in within(p.map(|p| p.y), height) {
            for column in columns.clone() {
                let (x, y) = (column as f64 + 0.5, row as f64 + 0.5);
                let a = side(p[1], p[2], x, y) / doubled;
                let b = side(p[2], p[0], x, y) / doubled;
                let c = 1.0 - a - b;
                if a < 0.0 || b < 0.0 || c < 0.0 {
                    continue;
                }
                let near = (a * p[0].nearness + b * p[1].nearness + c * p[2].nearness) as f32;
                let at = row * self.width + column;
                if near > self.nearness[at] {
                    self.nearness[at] = near;
                    self.faces[at] = number;
                    self.shares[at] = [a as f32, b as f32];
                }
            }
        }
    }

    /// Returns the part of the mesh that is seen at a sample, which is on the screen.
    pub fn at(&self, column: usize, row: usize) -> Option<Hit> {
        let at = row * self.width + column;
        let [a, b] = self.shares[at].map(f64::from);
        let face = self.faces[at];
        (face != NONE).then_some(Hit { face: face as usize, shares: [a, b, 1.0 - a - b] })
    }
}

/// Returns twice the area between an edge and a place, positive on one side of the edge.
fn side(a: Projected, b: Projected, x: f64, y: f64) -> f64 {
    (b.x - a.x) * (y - a.y) - (b.y - a.y) * (x - a.x)
}
