//! Sheets that are rolled and folded without stretching.

use std::f64::consts::TAU;

use catamaran::Result;
use catamaran::base::Rng;
use catamaran_geometry::mesh::TriMesh;
use catamaran_geometry::mesh::vector::Vector;

/// A grid of cells with an even number of columns.
#[derive(Debug, Clone)]
pub(super) struct Sheet {
    columns: usize,
    rows: usize,
}

/// Number of tiles along each side.
const TILES: usize = 3;

/// Number of steps in the integration of a fold.
const STEPS: usize = 400;

impl Sheet {
    pub fn new(vertices: usize) -> Self {
        let side = (vertices as f64).sqrt() as usize;
        Self { columns: side.next_multiple_of(2), rows: side }
    }

    /// Returns the square `[-1/2, 1/2] x [-1/2, 1/2]`, and the mirror image of each vertex.
    pub fn template(&self) -> Result<(TriMesh, Vec<u32>)> {
        let (columns, rows) = (self.columns, self.rows);
        let number = |i: usize, j: usize| (i * (rows + 1) + j) as u32;
        let (mut vertices, mut mirror) = (Vec::new(), Vec::new());
        let half = columns as f64 / 2.0;
        for i in 0..=columns {
            for j in 0..=rows {
                let y = j as f64 / rows as f64 - 0.5;
                vertices.push([(i as f64 - half) / columns as f64, y, 0.0]);
                mirror.push(number(columns - i, j));
            }
        }
        let mut faces = Vec::new();
        for i in 0..columns {
            for j in 0..rows {
                let [a, b] = [number(i, j), number(i + 1, j)];
                let [c, d] = [number(i + 1, j + 1), number(i, j + 1)];
                // The diagonals of the left half mirror those of the right half.
                faces.extend(match 2 * i < columns {
                    true => [[a, b, d], [b, c, d]],
                    false => [[a, b, c], [a, c, d]],
                });
            }
        }
        Ok((TriMesh::new(vertices, faces)?, mirror))
    }

    /// Returns the tile of each vertex.
    pub fn segments(&self) -> Vec<u32> {
        let tile = |i: usize, count: usize| (TILES * i / (count + 1)) as u32;
        (0..=self.columns)
            .flat_map(|i| (0..=self.rows).map(move |j| (i, j)))
            .map(|(i, j)| TILES as u32 * tile(i, self.columns) + tile(j, self.rows))
            .collect()
    }

    /// Returns a rectangle or trapezium (given by the identity), rolled around parallel lines with
    /// a curvature that changes along the profile (given by the pose): isometric to the flat one.
    /// Body type B is long.
    pub fn folded(
        &self,
        template: &[Vector],
        body: usize,
        identity: &mut Rng,
        pose: &mut Rng,
    ) -> Vec<Vector> {
        let mut between = |low: f64, high: f64| low + (high - low) * identity.uniform();
        let (width, taper) = (between(0.7, 1.1), between(-0.25, 0.25));
        let height = between(0.7, 1.1) * if body == 0 { 1.0 } else { 1.6 };
        let mut between = |low: f64, high: f64| low + (high - low) * pose.uniform();
        let (direction, waves, phase) = (between(0.0, TAU), between(0.5, 2.0), between(0.0, TAU));
        let turn = between(0.5, 1.5);
        let (sin, cos) = direction.sin_cos();
        // The profile of the fold, over arc lengths from -2 to 2.
        let step = 4.0 / STEPS as f64;
        let mut profile = vec![[0.0; 2]];
        for i in 0..STEPS {
            let s = -2.0 + (i as f64 + 0.5) * step;
            let angle = turn * (waves * TAU * s / 2.0 + phase).sin();
            let [x, z] = profile[i];
            profile.push([x + step * angle.cos(), z + step * angle.sin()]);
        }
        let along = |s: f64| {
            let t = ((s + 2.0) / step).clamp(0.0, STEPS as f64 - 1e-9);
            let (i, rest) = (t as usize, t.fract());
            [0, 1].map(|k| (1.0 - rest) * profile[i][k] + rest * profile[i + 1][k])
        };
        let place = |p: &Vector| {
            let x = width * p[0] * (1.0 + taper * p[1]);
            let y = height * p[1];
            let [u, z] = along(cos * x + sin * y);
            [u, cos * y - sin * x, z]
        };
        template.iter().map(place).collect()
    }
}
