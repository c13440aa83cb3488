//! Tells maps that keep the orientation of a surface from those that mirror it.

use faer::Mat;

use crate::mesh::TriMesh;
use crate::mesh::vector::{doubled_normal, norm};

/// Number of functions whose turns are compared, in pairs.
pub(super) const TURNING: usize = 6;

/// The faces around some vertices, which are seen counter-clockwise from outside where the mesh is
/// closed.
pub(super) struct Rings {
    /// The corners of the faces around each vertex, and their area.
    rings: Vec<(Vec<[u32; 3]>, f64)>,
    /// -1 for a closed mesh whose faces are seen clockwise from outside.
    sign: f64,
}

impl Rings {
    /// Finds the faces around `vertices`.
    pub fn new(mesh: &TriMesh, vertices: &[u32]) -> Self {
        let mut place = vec![usize::MAX; mesh.vertices().len()];
        for (i, &v) in vertices.iter().enumerate() {
            place[v as usize] = i;
        }
        let mut rings = vec![(Vec::new(), 0.0); vertices.len()];
        for &face in mesh.faces() {
            for v in face {
                if let Some((faces, area)) = rings.get_mut(place[v as usize]) {
                    let corners = face.map(|v| mesh.vertices()[v as usize]);
                    faces.push(face);
                    *area += 0.5 * norm(doubled_normal(corners));
                }
            }
        }
        let sign = mesh.volume().map_or(1.0, |volume| if volume < 0.0 { -1.0 } else { 1.0 });
        Self { rings, sign }
    }

    /// Computes for each vertex (row) and each pair of the functions f and g (column) that have
    /// these values, the mean of `n . (grad f x grad g)` over the faces around the vertex.
    pub fn turns(&self, value: impl Fn(u32) -> [f64; TURNING]) -> Mat<f64> {
        let pairs = || (0..TURNING).flat_map(|i| (i + 1..TURNING).map(move |j| (i, j)));
        let mut turns = Mat::zeros(self.rings.len(), pairs().count());
        for (s, (faces, area)) in self.rings.iter().enumerate() {
            if *area <= 0.0 {
                continue;
            }
            for &face in faces {
                let [p, q, r] = face.map(&value);
                for (pair, (i, j)) in pairs().enumerate() {
                    let twice = (q[i] - p[i]) * (r[j] - p[j]) - (r[i] - p[i]) * (q[j] - p[j]);
                    turns[(s, pair)] += self.sign * twice / area;
                }
            }
        }
        turns
    }
}

/// Returns the correlation, from -1 to 1, of the turns at vertices of the target with those at
/// their points among the samples of the source: positive for maps that keep the orientation.
pub(super) fn correlation(target: &Mat<f64>, source: &Mat<f64>, points: &[u32]) -> f64 {
    let [mut both, mut own, mut other] = [0.0; 3];
    for pair in 0..target.ncols() {
        for (y, &x) in points.iter().enumerate() {
            let (t, s) = (target[(y, pair)], source[(x as usize, pair)]);
            both += t * s;
            own += t * t;
            other += s * s;
        }
    }
    if own > 0.0 && other > 0.0 { both / (own * other).sqrt() } else { 0.0 }
}
