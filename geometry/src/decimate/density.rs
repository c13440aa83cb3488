//! Densities of vertices that vary over the surface: lengths are measured in units that vary.

use std::sync::Arc;

use crate::mesh::TriMesh;
use crate::mesh::vector::{doubled_normal, norm};
use catamaran::base::{Error, Result};

/// Largest ratio of two densities.
const RANGE: f64 = 1e12;

/// For each vertex of a surface, the factor by which lengths there are longer than without a
/// density: the square root of the density, relative to its mean. Between vertices, factors are
/// linear. So the area is the same, and a decimation that is uniform in stretched lengths has the
/// density.
#[derive(Clone, Default)]
pub(super) struct Stretch(Option<Arc<[f64]>>);

impl Stretch {
    /// Creates the stretch of a mesh with these square roots of densities at its vertices.
    pub fn new(mesh: &TriMesh, roots: Vec<f64>) -> Self {
        let most = roots.iter().copied().fold(0.0, f64::max);
        if roots.iter().all(|&root| root == most) {
            return Self(Some(vec![1.0; roots.len()].into()));
        }
        let (mut area, mut total) = (0.0, 0.0);
        for &face in mesh.faces() {
            let own = norm(doubled_normal(face.map(|v| mesh.vertices()[v as usize])));
            let [a, b, c] = face.map(|v| roots[v as usize] / most);
            area += own;
            total += own * (a * (a + b) + b * (b + c) + c * (c + a)) / 6.0;
        }
        let mean = (total / area).sqrt();
        let mean = if mean > 0.0 && mean.is_finite() { mean } else { 1.0 };
        Self(Some(roots.into_iter().map(|root| root / most / mean).collect()))
    }

    /// Returns the factors; `None` if all are 1.
    pub fn factors(&self) -> Option<&[f64]> {
        self.0.as_deref()
    }

    /// Returns the factor at v.
    pub fn at(&self, v: u32) -> f64 {
        self.0.as_ref().map_or(1.0, |factors| factors[v as usize])
    }

    /// Returns the mean factor between u and v.
    pub fn between(&self, u: u32, v: u32) -> f64 {
        self.0.as_ref().map_or(1.0, |factors| 0.5 * (factors[u as usize] + factors[v as usize]))
    }

    /// Returns the least and the largest factor.
    pub fn range(&self) -> [f64; 2] {
        let Some(factors) = &self.0 else { return [1.0; 2] };
        let least = factors.iter().copied().fold(f64::INFINITY, f64::min);
        [least, factors.iter().copied().fold(least, f64::max)]
    }
}

/// Checks the densities at the vertices of a mesh.
///
/// # Errors
/// [`Error::Argument`] that names the vertex whose density is not positive and finite, or the two
/// whose ratio is too large; or says how many densities are needed.
pub(super) fn check_density(density: &[f64], vertices: usize) -> Result<()> {
    let refused = |why| Err(Error::Argument { what: "density", why });
    if density.is_empty() {
        return Ok(());
    }
    if density.len() != vertices {
        let count = density.len();
        return refused(format!("must be one for each of {vertices} vertices, has {count}"));
    }
    if let Some(v) = density.iter().position(|&d| !(d > 0.0 && d.is_finite())) {
        return refused(format!("must be positive and finite, is {:e} at vertex {v}", density[v]));
    }
    let by_size = |a: &usize, b: &usize| density[*a].total_cmp(&density[*b]);
    let (least, most) = ((0..vertices).min_by(by_size), (0..vertices).max_by(by_size));
    if let (Some(least), Some(most)) = (least, most)
        && density[most] / density[least] > RANGE
    {
        return refused(format!(
            "must not vary by more than {RANGE:e}, is {:e} at vertex {least} and {:e} at vertex \
             {most}",
            density[least], density[most]
        ));
    }
    Ok(())
}
