//! Measures of the uniformity of a mesh (thesis, section 5.4.1).

use std::fmt;

use crate::mesh::{Edges, TriMesh};

/// Measures of uniformity of a mesh.
#[derive(Debug, Clone, PartialEq)]
pub struct Quality {
    /// Mean area of the faces, in units of area.
    pub mean_area: f64,
    /// Standard deviation of the areas over their mean; 0 when all are equal.
    pub area_variation: f64,
    /// Mean of Q(t) = 2 sqrt(3) A / (S l) over the faces, from 0 to 1 (equilateral):
    /// [`TriMesh::qualities`].
    pub mean_quality: f64,
    /// Standard deviation of Q.
    pub quality_deviation: f64,
    /// The least Q.
    pub least_quality: f64,
    /// Mean number of edges at a vertex with a face.
    pub mean_valence: f64,
    /// Share of these vertices that have 6 edges, or 4 on the boundary, from 0 to 1.
    pub regular_vertices: f64,
    /// The number of edges with more than two faces.
    pub non_manifold_edges: usize,
}

impl Quality {
    /// Computes the measures of `mesh`; all 0 when the mesh has no face.
    ///
    /// ```
    /// use catamaran_geometry::{decimate::Quality, mesh::families};
    ///
    /// let quality = Quality::of(&families::icosphere(0)?);
    /// assert!((quality.mean_quality - 1.0).abs() < 1e-12 && quality.area_variation < 1e-12);
    /// assert_eq!(quality.mean_valence, 5.0);
    /// # Ok::<(), catamaran::Error>(())
    /// ```
    pub fn of(mesh: &TriMesh) -> Self {
        let (mean_area, area_deviation) = mean_and_deviation(&mesh.face_areas());
        let qualities = mesh.qualities();
        let (mean_quality, quality_deviation) = mean_and_deviation(&qualities);
        let least = qualities.iter().copied().reduce(f64::min);
        let edges = Edges::new(mesh);
        let mut valences = vec![0u32; mesh.vertices().len()];
        let mut on_boundary = vec![false; mesh.vertices().len()];
        for (e, ends) in edges.ends().iter().enumerate() {
            for &v in ends {
                valences[v as usize] += 1;
                on_boundary[v as usize] |= edges.faces(e).len() == 1;
            }
        }
        let used = valences.iter().filter(|&&valence| valence > 0).count().max(1) as f64;
        let regular = |v: &usize| valences[*v] == if on_boundary[*v] { 4 } else { 6 };
        Self {
            mean_area,
            area_variation: if mean_area > 0.0 { area_deviation / mean_area } else { 0.0 },
            mean_quality,
            quality_deviation,
            least_quality: least.unwrap_or(0.0),
            mean_valence: valences.iter().map(|&valence| f64::from(valence)).sum::<f64>() / used,
            regular_vertices: (0..valences.len()).filter(regular).count() as f64 / used,
            non_manifold_edges: edges.non_manifold().count(),
        }
    }
}

impl fmt::Display for Quality {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        writeln!(
            f,
            "area        {:.4e} mean, variation {:.3}",
            self.mean_area, self.area_variation
        )?;
        writeln!(
            f,
            "quality     {:.3} mean, deviation {:.3}, least {:.3} (1: equilateral)",
            self.mean_quality, self.quality_deviation, self.least_quality
        )?;
        write!(
            f,
            "valence     {:.2} mean, {:.1} % regular; edges with more than two faces: {}",
            self.mean_valence,
            100.0 * self.regular_vertices,
            self.non_manifold_edges
        )
    }
}

fn mean_and_deviation(values: &[f64]) -> (f64, f64) {
    let count = values.len().max(1) as f64;
    let mean = values.iter().sum::<f64>() / count;
    let square = values.iter().map(|x| (x - mean).powi(2)).sum::<f64>() / count;
    (mean, square.sqrt())
}
